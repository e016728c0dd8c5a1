//! What varies of media, from place to place, on a lattice: evaluated once a shot. A graph gives it at points between which a mesh is even
//! enough; files of volumes have a lattice of their own, and may be what a graph is evaluated of.

use std::collections::HashSet;

use glam::{DAffine3, DVec3, IVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::channels::Channels;
use super::grid::{BLOCK, BLOCK_POINTS, Cell, MediumGrid, POINTS};
use crate::geometry::tree::Box3;
use crate::graph::{Place, Places, Program, UvSet};
use crate::lanes::LANES;
use crate::scene::volume::{Block, Grid};
use crate::scene::{Material, Model, Scene};

/// Cells along the longest edge of the box around a mesh, where a material states none.
pub const USUAL_CELLS: u32 = 128;

/// Blocks of which it is guessed how values depend on each other.
const SAMPLES: usize = 32;

/// Name of the grid that says how much of a medium is in a place, where no graph does.
pub const DENSITY: &str = "density";

/// The grid of a material in a mesh of a model within `bounds` (space of the mesh's positions), if what is in it varies.
pub fn grid(scene: &Scene, model: &Model, material: &Material, bounds: &Box3) -> Option<MediumGrid> {
    let program = material.medium_graph.as_deref();
    let cells = material.medium_cells.unwrap_or(USUAL_CELLS);
    let (lattice, blocks) = match model.mesh.details.volume.as_deref() {
        Some(volume) => {
            let main = volume.grid(DENSITY).or(volume.grids.first())?;
            let others = volume.grids.iter().filter(|grid| grid.to_lattice == main.to_lattice);
            let filled = others.flat_map(Grid::filled_blocks).flat_map(with_those_before);
            let blocks: HashSet<IVec3> = filled.collect();
            (Lattice::new(scene, model, program, in_positions(model, main.to_lattice)), blocks)
        }
        None => {
            let (to_lattice, counts) = around(bounds, cells);
            let last = counts.map(|count| (count - 1).div_euclid(BLOCK));
            let blocks = (0..=last.z)
                .flat_map(|z| (0..=last.y).flat_map(move |y| (0..=last.x).map(move |x| IVec3::new(x, y, z))));
            (Lattice::new(scene, model, Some(program?), to_lattice), blocks.collect())
        }
    };
    let mut blocks: Vec<IVec3> = blocks.into_iter().collect();
    blocks.sort_unstable_by_key(|at| [at.z, at.y, at.x]);
    let (channels, blocks) = lattice.evaluated(&blocks);
    MediumGrid::new(lattice.to_lattice, channels.cells(), blocks).ok()
}

/// The map of object space to a lattice, for the space of the positions of a model's mesh.
fn in_positions(model: &Model, to_lattice: DAffine3) -> DAffine3 {
    model.mesh.details.space.map_or(to_lattice, |space| to_lattice * space.to_object.as_daffine3())
}

/// A block, and those before it, whose cells end at points of it.
fn with_those_before(at: IVec3) -> impl Iterator<Item = IVec3> {
    (0..8).map(move |number| at - IVec3::new(number & 1, number >> 1 & 1, number >> 2))
}

/// A lattice of so many cells along the longest edge of a box, and how many there are along each.
fn around(bounds: &Box3, cells: u32) -> (DAffine3, IVec3) {
    let [low, high] = [bounds.low, bounds.high].map(|corner| Vec3::from_array(corner).as_dvec3());
    let size = (high - low).max_element() / f64::from(cells);
    let counts = ((high - low) / size).ceil().max(DVec3::ONE).min(DVec3::splat(f64::from(cells)));
    let to_lattice = DAffine3::from_scale(counts / (high - low)) * DAffine3::from_translation(-low);
    (to_lattice, counts.as_ivec3())
}

/// Where a medium is evaluated.
struct Lattice<'a> {
    scene: &'a Scene,
    model: &'a Model,
    program: Option<&'a Program>,
    /// From the space of the mesh's positions, and back.
    to_lattice: DAffine3,
    back: DAffine3,
    /// Grids of the mesh: whether their points are those of the lattice.
    grids: Vec<(&'a Grid, bool)>,
}

impl<'a> Lattice<'a> {
    fn new(scene: &'a Scene, model: &'a Model, program: Option<&'a Program>, to_lattice: DAffine3) -> Self {
        let grids = model.mesh.details.volume.iter().flat_map(|volume| &volume.grids);
        let grids = grids.map(|grid| (grid, in_positions(model, grid.to_lattice) == to_lattice));
        Self { scene, model, program, to_lattice, back: to_lattice.inverse(), grids: grids.collect() }
    }

    /// The values of these blocks, and what they are.
    fn evaluated(&self, blocks: &[IVec3]) -> (Channels, Vec<(IVec3, Vec<f32>)>) {
        let some = blocks.iter().step_by(blocks.len().div_ceil(SAMPLES).max(1));
        let samples: Vec<Cell> = some.flat_map(|at| self.block(*at)).collect();
        let by = |channels: &Channels| -> Option<Vec<(IVec3, Vec<f32>)>> {
            let values = |at: &IVec3| channels.values(&self.block(*at)).map(|values| (*at, values));
            blocks.par_iter().map(values).collect()
        };
        let guessed = Channels::of(&samples);
        match by(&guessed) {
            Some(values) => (guessed, values),
            None => (Channels::all(), by(&Channels::all()).unwrap_or_default()),
        }
    }

    /// What is at the points of a block.
    fn block(&self, at: IVec3) -> Vec<Cell> {
        let grids: Vec<Values<'_>> = self.grids.iter().map(|of| self.values(of, at)).collect();
        let Some(program) = self.program else {
            let density = grids.iter().find(|grid| grid.name == DENSITY).or(grids.first());
            let full = |value: &Vec3| Cell {
                scatter: Vec3::splat(value.x),
                absorb: Vec3::splat(value.x),
                emit: Vec3::splat(value.x),
            };
            return density.map_or(Vec::new(), |density| density.values.iter().map(full).collect());
        };
        let (scene, model) = (self.scene, self.model);
        let places: Vec<InMesh<'_>> = points(at)
            .enumerate()
            .map(|(number, at)| {
                let at = self.back.transform_point3(at.as_dvec3()).as_vec3();
                InMesh { scene, model, at, grids: &grids, number }
            })
            .collect();
        places.chunks(LANES).flat_map(|some| evaluated(program, some)).collect()
    }

    /// What a grid has at the points of a block.
    fn values(&self, (grid, is_same): &(&'a Grid, bool), at: IVec3) -> Values<'a> {
        let values = if *is_same {
            Block::new(grid, at).values().collect()
        } else {
            let map = in_positions(self.model, grid.to_lattice) * self.back;
            points(at).map(|at| grid.between(map.transform_point3(at.as_dvec3()))).collect()
        };
        Values { name: &grid.name, values }
    }
}

/// Points of a block: along X first, then Y, then Z.
fn points(block: IVec3) -> impl Iterator<Item = IVec3> {
    let point = move |number: i32| {
        let row = number / POINTS;
        block * BLOCK + IVec3::new(number % POINTS, row % POINTS, row / POINTS)
    };
    (0..BLOCK_POINTS as i32).map(point)
}

/// What a grid has at the points of a block.
struct Values<'a> {
    name: &'a str,
    values: Vec<Vec3>,
}

fn evaluated(program: &Program, places: &[InMesh<'_>]) -> Vec<Cell> {
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
    grids: &'a [Values<'a>],
    /// Number of the point in its block.
    number: usize,
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

    fn of_volume(&self, grid: &str) -> Option<Vec3> {
        self.grids.iter().find(|of| of.name == grid).map(|of| of.values[self.number])
    }

    fn picture(&self, number: u32, at: Option<Vec2>) -> [f32; 4] {
        let Some(texture) = self.scene.textures.get(number as usize) else { return [0.0; 4] };
        let uv = at.unwrap_or(Vec2::ZERO);
        let Vec3 { x, y, z } = texture.value(uv, 0);
        [x, y, z, texture.alpha_between(&texture.between(uv))]
    }
}
