//! Instances within instances, and the copies that point instancers make.

use glam::DAffine3;
use openusd::sdf::Path;
use openusd::usd::{Prim, PrimPredicate, PrimStatus};

use super::{Context, MOST_SHOWN, Walk};
use crate::animation::{Track, Visibility};
use crate::scene::import::usd::file::ShownMesh;
use crate::scene::import::usd::instancer::{self, Copy};
use crate::scene::import::usd::value::{Answer, said};

/// Most point instancers within each other.
const MOST_DEPTH: usize = 8;

impl Walk<'_> {
    /// Collects the copies that a point instancer makes.
    pub fn copies(&mut self, prim: &Prim, context: &Context, shown: &mut Vec<ShownMesh>) -> Answer<()> {
        let path = prim.path().clone();
        if self.within.len() >= MOST_DEPTH || self.within.contains(&path) {
            let message = format!("the point instancer {path} copies itself: these copies are left out");
            self.content.defects.insert(message);
            return Ok(());
        }
        let read = instancer::copies(prim, &self.content.clock, &mut self.content.unused);
        let Some(copies) = self.or_left_out(prim, read)? else { return Ok(()) };
        self.within.push(path.clone());
        let mut of_prototypes = Vec::with_capacity(copies.prototypes.len());
        for prototype in &copies.prototypes {
            let context = Context {
                map: Track::constant(DAffine3::IDENTITY),
                visible: Visibility::ALWAYS,
                is_rendered: true,
                is_skinned: false,
            };
            // prototypes may be `over`, so that they are not shown by themselves
            let is_there =
                PrimPredicate::new(PrimStatus::ACTIVE.union(PrimStatus::LOADED), PrimStatus::empty())
                    .with_instance_proxies(true);
            let parent = prototype.parent().unwrap_or_else(Path::abs_root);
            let before = parent.as_str().trim_start_matches('/').len();
            let base = std::mem::replace(&mut self.base, parent);
            let meshes = self.below(vec![self.stage.prim(prototype.clone())], context, is_there)?;
            self.base = base;
            of_prototypes.push((meshes, before));
        }
        self.within.pop();
        let name = path.as_str().trim_start_matches('/');
        for Copy { number, prototype, map, visible } in copies.list {
            let visible = context.visible.and(&visible);
            let map = context.map.after(&map);
            let (meshes, before) = &of_prototypes[prototype];
            if shown.len() + meshes.len() > MOST_SHOWN {
                return Err(format!("it shows more than {MOST_SHOWN} models"));
            }
            shown.extend(meshes.iter().map(|mesh| ShownMesh {
                name: format!("{name}/{number}/{}", mesh.name[*before..].trim_start_matches('/')),
                mesh: mesh.mesh,
                map: map.after(&mesh.map),
                visible: visible.and(&mesh.visible),
            }));
        }
        Ok(())
    }

    /// Makes a plain prim of an instance within which there are others: the library composes nothing in these.
    pub fn open_nested(&mut self, prim: &Prim) -> Answer<()> {
        let Some(prototype) = said(prim.prototype())? else { return Ok(()) };
        let has_nested = match self.has_nested.get(prototype.as_str()) {
            Some(known) => *known,
            None => {
                let found = self.has_instances(said(prim.children())?)?;
                self.has_nested.insert(prototype.to_string(), found);
                found
            }
        };
        if has_nested {
            let opened = said(self.stage.override_prim(prim.path().clone()));
            if opened.and_then(|prim| said(prim.set_instanceable(false))).is_err() {
                let message = format!("instances within {} are not shown: make it a plain prim", prim.path());
                self.content.defects.insert(message);
            }
        }
        Ok(())
    }

    /// True if there are instances among prims or below them.
    fn has_instances(&mut self, mut waiting: Vec<Prim>) -> Answer<bool> {
        while let Some(prim) = waiting.pop() {
            self.count_prim(&prim)?;
            if said(prim.is_instance())? {
                return Ok(true);
            }
            waiting.extend(said(prim.children())?);
        }
        Ok(false)
    }
}
