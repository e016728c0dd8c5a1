//! What graphs give of media, from place to place: evaluated once a shot, in the middle of each cell of a grid.

use glam::{DVec3, UVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::grid::{Cell, MediumGrid};
use crate::geometry::tree::Box3;
use crate::graph::{Place, Places, Program, UvSet};
use crate::lanes::LANES;
use crate::scene::{Material, Model, Scene};

/// Cells along the longest edge of the box around a mesh, where a material states none.
pub const USUAL_CELLS: u32 = 64;

/// The grid of a material in a mesh of a model within `bounds` (object space), if graphs give what is in it.
pub fn grid(scene: &Scene, model: &Model, material: &Material, bounds: &Box3) -> Option<MediumGrid> {
    let program = material.medium_graph.as_ref()?;
    let [low, high] = [bounds.low, bounds.high].map(|corner| Vec3::from_array(corner).as_dvec3());
    let longest = (high - low).max_element();
    let cells = f64::from(material.medium_cells.unwrap_or(USUAL_CELLS));
    let size = longest / cells;
    let counts = ((high - low) / size).ceil().max(DVec3::ONE).min(DVec3::splat(cells)).as_uvec3();
    let size = (high - low) / counts.as_dvec3();
    let rows: Vec<UVec3> =
        (0..counts.z).flat_map(|z| (0..counts.y).map(move |y| UVec3::new(0, y, z))).collect();
    let row = |at: &UVec3| {
        let middle = |x: u32| low + size * (UVec3 { x, ..*at }.as_dvec3() + 0.5);
        let places: Vec<InMesh> =
            (0..counts.x).map(|x| InMesh { scene, model, at: middle(x).as_vec3() }).collect();
        places.chunks(LANES).flat_map(|some| evaluated(program, some)).collect::<Vec<Cell>>()
    };
    let cells = rows.par_iter().flat_map_iter(row).collect();
    MediumGrid::new(low, size, counts, cells)
}

fn evaluated(program: &Program, places: &[InMesh]) -> Vec<Cell> {
    let all: Vec<&dyn Place> = places.iter().map(|place| place as &dyn Place).collect();
    let [scatter, absorb, emit, ..] = program.values(Places::new(&all));
    let cell = |lane| Cell { scatter: scatter.lane(lane), absorb: absorb.lane(lane), emit: emit.lane(lane) };
    (0..places.len()).map(cell).collect()
}

/// A place within a mesh, as graphs see it: on no surface.
#[derive(Clone, Copy)]
struct InMesh<'a> {
    scene: &'a Scene,
    model: &'a Model,
    /// In the space of the mesh's positions.
    at: Vec3,
}

impl Place for InMesh<'_> {
    fn uv(&self, _: UvSet) -> Vec2 {
        Vec2::ZERO
    }

    fn point(&self) -> Vec3 {
        let space = self.model.mesh.details.space;
        space.map_or(self.at, |space| space.to_object.transform_point3(self.at))
    }

    fn generated(&self) -> Vec3 {
        let point = self.point();
        self.model.mesh.details.space.map_or(point, |space| (point - space.low) / space.size)
    }

    fn normal(&self) -> Vec3 {
        Vec3::Z
    }

    fn world_point(&self) -> Vec3 {
        let point = self.point();
        self.model.to_world.map_or(point, |map| map.transform_point3(point))
    }

    fn model_place(&self) -> Vec3 {
        self.model.to_world.map_or(Vec3::ZERO, |map| map.translation.into())
    }

    fn model_random(&self) -> f32 {
        self.model.random
    }

    fn picture(&self, number: u32, at: Option<Vec2>) -> [f32; 4] {
        let Some(texture) = self.scene.textures.get(number as usize) else { return [0.0; 4] };
        let uv = at.unwrap_or(Vec2::ZERO);
        let Vec3 { x, y, z } = texture.value(uv, 0);
        [x, y, z, texture.alpha_between(&texture.between(uv))]
    }
}
