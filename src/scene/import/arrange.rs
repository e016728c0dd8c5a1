//! Arranges meshes for what their materials are: their triangles in the order that tracers want, those that cast shadows first and those that
//! are cut out together; and what materials need of them beside their vertices.

use std::collections::HashMap;
use std::sync::Arc;

use crate::geometry::Bounds;
use crate::scene::cutout::{CutTriangles, Cutout, Mask, VertexData};
use crate::scene::details::{Details, ObjectSpace};
use crate::scene::texture::UvSet;
use crate::scene::{Material, Mesh, Texture};

/// Arranges meshes of these materials and their textures.
#[derive(Clone, Copy)]
pub(in crate::scene) struct Arranger<'a> {
    pub materials: &'a [Material],
    pub textures: &'a [Texture],
}

impl Arranger<'_> {
    /// Gives a mesh what its materials need beside its vertices: tangents, of which `of_vertices` are those that its file states, if it
    /// does; and the space of graphs, and of tangents around an axis.
    pub fn with_details(&self, mesh: Mesh, of_vertices: &[[f32; 4]]) -> Mesh {
        let mesh = self.with_tangents(mesh, of_vertices);
        let asks = |material: &u16| self.materials[usize::from(*material)].asks_for_space();
        if !mesh.material_of.iter().any(asks) {
            return mesh;
        }
        let space = Some(ObjectSpace::in_box(Bounds::of(&mesh)));
        Mesh { details: Arc::new(Details { space, ..Details::clone(&mesh.details) }), ..mesh }
    }

    /// Gives a mesh tangents, if a material of it has a normal map.
    fn with_tangents(&self, mesh: Mesh, of_vertices: &[[f32; 4]]) -> Mesh {
        if [UvSet::First, UvSet::Second].iter().all(|set| mesh.uvs_of(*set).is_empty()) {
            return mesh;
        }
        let uvs = |material: u16| {
            let map = self.materials[usize::from(material)].normal_map?.map;
            Some(self.textures[map as usize].mapping.uvs)
        };
        let bends = |material: &u16| uvs(*material).is_some_and(|set| !mesh.uvs_of(set).is_empty());
        if !mesh.material_of.iter().any(bends) {
            return mesh;
        }
        let tangents = mesh.tangents(of_vertices, |material| uvs(material).unwrap_or_default());
        let details = Details { tangents, ..Details::clone(&mesh.details) };
        Mesh { details: Arc::new(details), ..mesh }
    }

    /// Returns true if triangles of a material, on a mesh with this vertex data, keep light from anything: all over, or where a picture
    /// says so.
    pub fn casts_shadow_on(&self, material: u16, has: VertexData) -> bool {
        let of = &self.materials[usize::from(material)];
        let cutout = of.cutout.and_then(|cutout| cutout.on_mesh(has));
        of.casts_shadow() || cutout.is_some_and(|cutout| cutout.blended.is_some())
    }

    /// Place of a material's triangles in the order of a mesh: those that cast shadows come first, and those that are cut out
    /// follow each other.
    pub fn rank(&self, material: u16, has: VertexData) -> u8 {
        let cutout = self.materials[usize::from(material)].cutout;
        let is_cut = cutout.is_some_and(|cutout| cutout.on_mesh(has).is_some());
        match (self.casts_shadow_on(material, has), is_cut) {
            (true, false) => 0,
            (true, true) => 1,
            (false, true) => 2,
            (false, false) => 3,
        }
    }

    /// Triangles that are cut out, which follow each other, given the material of each triangle in the order of [`rank`](Self::rank).
    pub fn cut_triangles(&self, material_of: &[u16], has: VertexData) -> Option<Arc<CutTriangles>> {
        let cutout = |material: &u16| self.materials[usize::from(*material)].cutout?.on_mesh(has);
        let first = material_of.iter().position(|material| cutout(material).is_some())?;
        let (mut masks, mut known): (Vec<Mask>, HashMap<u16, u16>) = (Vec::new(), HashMap::new());
        let cut = material_of[first..].iter().map_while(|material| Some((*material, cutout(material)?)));
        let texture = |map: u32| self.textures[map as usize].clone();
        let program =
            |material: u16| self.materials[usize::from(material)].computed.as_ref()?.opacity.clone();
        let mask = |material: u16, cutout: Cutout| match program(material).filter(|_| cutout.by_graph) {
            Some(program) => Mask::computed(cutout, program, self.textures.into()),
            None => Mask::new(cutout, cutout.map.map(texture)),
        };
        let mask_of = cut.map(|(material, cutout)| {
            *known.entry(material).or_insert_with(|| {
                masks.push(mask(material, cutout));
                (masks.len() - 1) as u16
            })
        });
        let mask_of = mask_of.collect();
        Some(Arc::new(CutTriangles { first: first as u32, mask_of, masks }))
    }
}
