//! Meshes that prims show, and their skeletons.

use std::rc::Rc;

use glam::DAffine3;
use openusd::sdf::Path;
use openusd::usd::Prim;

use super::{Context, Walk, said_type};
use crate::animation::Track;
use crate::digest::Digest;
use crate::scene::import::usd::file::UsdMesh;
use crate::scene::import::usd::geometry;
use crate::scene::import::usd::skeleton::{self, Skeleton};
use crate::scene::import::usd::skin::{self, Skin};
use crate::scene::import::usd::value::{Answer, Read, said};

impl Walk<'_> {
    /// Number and map of the mesh that a prim shows, if it has triangles.
    pub fn mesh(&mut self, prim: &Prim, context: &Context) -> Read<Option<(usize, Track<DAffine3>)>> {
        let map = &context.map;
        if context.is_skinned
            && skin::is_bound(prim)?
            && let Some((skin, of_skeleton)) = self.skin(prim)?
        {
            let mesh = self.read_mesh(prim, Some(&skin))?;
            let map = if skin.has_joints() { of_skeleton } else { map.clone() };
            return Ok(mesh.map(|mesh| (mesh, map)));
        }
        let Some(prototype) = said(prim.prim_in_prototype())? else {
            let number = self.read_mesh(prim, None)?;
            return Ok(number.map(|number| (number, map.clone())));
        };
        let mut surfaces = vec![self.surface_of_mesh(prim)?.of_mesh];
        for (subset, _) in self.subsets(prim)? {
            let bound = self.surface(subset.path())?;
            surfaces
                .push(bound.map(|bound| self.colored(prim, &bound)).transpose()?.map(|(surface, _)| surface));
        }
        let key = (prototype.path().to_string(), surfaces);
        let number = match self.of_prototypes.get(&key) {
            Some(known) => *known,
            None => {
                let number = self.read_mesh(prim, None)?;
                self.of_prototypes.insert(key, number);
                number
            }
        };
        Ok(number.map(|number| (number, map.clone())))
    }

    fn read_mesh(&mut self, prim: &Prim, skin: Option<&Skin>) -> Read<Option<usize>> {
        let surfaces = self.surfaces(prim)?;
        let mesh = geometry::mesh(prim, &surfaces, skin, &mut self.content)?;
        Ok(mesh.map(|mesh| self.number_of(mesh)))
    }

    /// Binding of a mesh to its skeleton, and the map of that. `None` if the skeleton is nowhere, or does not fit.
    fn skin(&mut self, prim: &Prim) -> Answer<Option<(Skin, Track<DAffine3>)>> {
        let clock = self.content.clock;
        let path = skeleton::inherited(self.stage, prim.path(), "skel:skeleton")?;
        let skeleton = path.as_ref().map(|path| self.skeleton(path)).transpose();
        let known = match skeleton {
            Ok(known) => known.flatten(),
            Err(why) => return Ok(self.unbound(prim, &why)),
        };
        let map = path.as_ref().map(|path| self.map_of(path)).transpose()?.flatten();
        let (Some(skeleton), Some(map)) = (known, map) else {
            let message = format!("the skeleton of {} is nowhere: it stands as it was bound", prim.path());
            self.content.defects.insert(message);
            return Ok(None);
        };
        let code = clock.code(clock.first());
        match Skin::read(self.stage, prim, skeleton, code, &mut self.content.unused) {
            Ok(skin) => Ok(Some((skin, map))),
            Err(why) => Ok(self.unbound(prim, &why)),
        }
    }

    /// Tells that a mesh is not bound to its skeleton.
    fn unbound<T>(&mut self, prim: &Prim, why: &str) -> Option<T> {
        let message = format!("{} stands as it was bound, for {why}: export it again", prim.path());
        self.content.defects.insert(message);
        None
    }

    fn skeleton(&mut self, path: &Path) -> Answer<Option<Rc<Skeleton>>> {
        if let Some(known) = self.skeletons.get(path.as_str()) {
            return Ok(known.clone());
        }
        let is_there = said_type(self.stage, path)?.as_deref() == Some("Skeleton");
        let read = is_there.then(|| Skeleton::read(self.stage, path, &self.content.clock)).transpose()?;
        let read = read.map(Rc::new);
        self.skeletons.insert(path.to_string(), read.clone());
        Ok(read)
    }

    /// Number of a mesh: that of an equal one, if there is one. Exporters write copies.
    pub fn number_of(&mut self, mesh: UsdMesh) -> usize {
        let digest = Digest::of_all([
            Digest::new(bytemuck::cast_slice(&mesh.positions)),
            Digest::new(bytemuck::cast_slice(mesh.curves.as_ref().map_or(&[][..], |curves| &curves.points))),
            Digest::new(bytemuck::cast_slice(mesh.triangles.as_flattened())),
        ]);
        let same = self.known.entry(digest).or_default();
        if let Some(known) = same.iter().find(|number| self.content.meshes[**number] == mesh) {
            return *known;
        }
        same.push(self.content.meshes.len());
        self.content.meshes.push(mesh);
        self.content.meshes.len() - 1
    }
}
