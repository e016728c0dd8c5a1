//! Makes [`ReflectionMaps`]: traces what surrounds models.

use glam::Vec3;
use rayon::prelude::*;

use super::bounce::{Bounces, follow};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::reflection_maps::{CubeMap, NO_MAPS, ReflectionMaps, directions};
use crate::frame::surface::radiance::Radiance;
use crate::frame::surface::trace_scratch::TraceScratch;
use crate::geometry::Bounds;
use crate::layers::Layers;
use crate::samples::CELLS;
use crate::scene::material::Optics;
use crate::scene::{Model, Scene};
use crate::stats::RayCounts;
use crate::trace::{Coherence, SceneSubset};

/// Surfaces of a model that are passed on the way out of it; what is behind more of them is not seen.
const MOST_LAYERS: usize = 64;

/// By how much a ray goes on behind a surface of its own model, as a share of the way.
const BEHIND: f32 = 1.0 + 1e-5;

/// The maps of the frame's pose: `kept`, if they are, or new ones. `bounds`: one box a model, object space. And the rays that it
/// took.
pub fn updated(kept: ReflectionMaps, frame: &FrameView, bounds: &[Bounds]) -> (ReflectionMaps, RayCounts) {
    if kept.holds(frame.pose) { (kept, RayCounts::default()) } else { made(frame, bounds) }
}

/// The maps of the frame's pose, and the rays that it took.
pub fn made(frame: &FrameView, bounds: &[Bounds]) -> (ReflectionMaps, RayCounts) {
    // what maps show is traced, and makes no guides of its own
    let frame = FrameView { maps: &NO_MAPS, keeps_trees: false, layers: Layers::NONE, ..*frame };
    let mut rays = RayCounts::default();
    let maps = frame.scene.models.iter().zip(bounds).zip(0..).map(|((model, bounds), number)| {
        let transform = frame.transform(number);
        let size = model.reflection_map.filter(|_| transform.is_visible && goes_on(frame.scene, model))?;
        let center = transform.point((bounds.low + bounds.high) * 0.5);
        let (map, cast) = around(&frame, number, center, size as usize);
        rays += cast;
        Some(map)
    });
    let maps = maps.collect();
    (ReflectionMaps::of(maps, frame.pose), rays)
}

/// Whether a model has mirrors or glass.
fn goes_on(scene: &Scene, model: &Model) -> bool {
    let is_opaque = |material: &u16| scene.materials[usize::from(*material)].optics == Optics::Opaque;
    !model.mesh.material_of.iter().all(is_opaque)
}

/// What surrounds `model`, seen from `center` (world space). And the rays that it took.
fn around(frame: &FrameView, model: u32, center: Vec3, size: usize) -> (CubeMap, RayCounts) {
    let directions = directions(size);
    let look = |scratch: &mut Scratch, directions: &[Vec3]| scratch.look(frame, model, center, directions);
    let looked: Vec<(Vec<Vec3>, RayCounts)> =
        directions.par_chunks(CELLS).map_init(Scratch::default, look).collect();
    let mut rays = RayCounts::default();
    looked.iter().for_each(|(_, cast)| rays += *cast);
    (CubeMap::of(size, looked.into_iter().flat_map(|(texels, _)| texels).collect()), rays)
}

/// A worker's memory for making maps.
#[derive(Default)]
struct Scratch {
    bounces: Bounces,
    radiance: Box<Radiance>,
    trace: TraceScratch,
}

impl Scratch {
    /// What is seen from `center` in these directions, as many as a tile has cells at most, when `model` itself is passed through.
    /// And the rays that it took.
    fn look(
        &mut self,
        frame: &FrameView,
        model: u32,
        center: Vec3,
        directions: &[Vec3],
    ) -> (Vec<Vec3>, RayCounts) {
        self.trace.tally.cells.begin_tile();
        self.radiance.begin_tile();
        self.radiance.open_secondary();
        for (cell, (direction, near)) in
            (0..).zip(directions.iter().zip(self.ends(frame, model, center, directions)))
        {
            self.bounces.start_from(cell, center + *direction * near, *direction);
        }
        follow(frame, &mut self.bounces, &mut self.radiance, &mut self.trace);
        self.radiance.cut_secondary();
        let [r, g, b] = &self.radiance.reflection;
        let texels = (0..directions.len()).map(|cell| Vec3::new(r[cell], g[cell], b[cell])).collect();
        (texels, std::mem::take(&mut self.trace.tally.counts))
    }

    /// How far from `center` `model` ends in each direction, before anything else that is met.
    fn ends(&mut self, frame: &FrameView, model: u32, center: Vec3, directions: &[Vec3]) -> Vec<f32> {
        let mut ends = vec![0.0; directions.len()];
        let mut open: Vec<usize> = (0..directions.len()).collect();
        for _ in 0..MOST_LAYERS {
            if open.is_empty() {
                break;
            }
            self.trace.begin_rays();
            for ray in &open {
                self.trace.rays.push(center, directions[*ray], ends[*ray], f32::INFINITY);
            }
            self.trace.tally.counts.reflection += open.len() as u64;
            let TraceScratch { rays, hits, .. } = &mut self.trace;
            frame.tracer.closest(rays, SceneSubset::All, Coherence::Bounced, hits);
            let mut number = 0;
            open.retain(|ray| {
                let own = hits.get(number).filter(|hit| hit.model == model);
                number += 1;
                if let Some(hit) = own {
                    ends[*ray] = hit.t * BEHIND;
                }
                own.is_some()
            });
        }
        ends
    }
}
