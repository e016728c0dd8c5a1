//! Builds [`ReflectionMaps`]: traces the surroundings of models.

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
use crate::scene::{Model, RayKind, Scene};
use crate::stats::RayCounts;
use crate::trace::{Coherence, OfKind, SceneSubset, Search};

/// Largest number of surfaces of a model that are passed on the way out of it; nothing is seen behind more of
/// them.
const MOST_LAYERS: usize = 64;

/// Factor by which a ray starts behind a surface of its own model, relative to the distance.
const BEHIND: f32 = 1.0 + 1e-5;

/// Maps for the frame's pose: `kept`, if they are still valid, or new ones. `bounds`: one box a model, object
/// space. Returns them with the rays that they took.
pub fn updated(kept: ReflectionMaps, frame: &FrameView, bounds: &[Bounds]) -> (ReflectionMaps, RayCounts) {
    if kept.holds(frame.pose) { (kept, RayCounts::default()) } else { made(frame, bounds) }
}

/// Builds the maps for the frame's pose. Returns them with the rays that they took.
pub fn made(frame: &FrameView, bounds: &[Bounds]) -> (ReflectionMaps, RayCounts) {
    // rays of maps are always traced, and make no guides
    let frame =
        FrameView { maps: &NO_MAPS, keeps_trees: false, layers: Layers::NONE, mirrored: None, ..*frame };
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
    (ReflectionMaps::new(maps, frame.pose), rays)
}

/// Returns true if a model has mirrors or glass.
fn goes_on(scene: &Scene, model: &Model) -> bool {
    let is_opaque = |material: &u16| {
        let material = &scene.materials[usize::from(*material)];
        material.optics == Optics::Opaque && material.cutout.is_none_or(|cutout| cutout.blended.is_none())
    };
    !model.mesh.material_of.iter().all(is_opaque)
}

/// Traces the surroundings of `model`, seen from `center` (world space). Returns the map with the rays that
/// it took.
fn around(frame: &FrameView, model: u32, center: Vec3, size: usize) -> (CubeMap, RayCounts) {
    let directions = directions(size);
    let look = |scratch: &mut Scratch, directions: &[Vec3]| scratch.look(frame, model, center, directions);
    let looked: Vec<(Vec<Vec3>, RayCounts)> =
        directions.par_chunks(CELLS).map_init(Scratch::default, look).collect();
    let mut rays = RayCounts::default();
    looked.iter().for_each(|(_, cast)| rays += *cast);
    (CubeMap::new(size, looked.into_iter().flat_map(|(texels, _)| texels).collect()), rays)
}

/// Scratch memory of a worker for building maps.
#[derive(Default)]
struct Scratch {
    bounces: Bounces,
    radiance: Box<Radiance>,
    trace: TraceScratch,
}

impl Scratch {
    /// Light that is seen from `center` in these directions, of which there are at most as many as a tile has
    /// cells; `model` itself is passed through. Returns it with the rays that it took.
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
            self.bounces.start_from(frame, (cell, model), center + *direction * near, *direction);
        }
        follow(frame, &mut self.bounces, &mut self.radiance, &mut self.trace);
        self.radiance.cut_secondary();
        let [r, g, b] = &self.radiance.reflection;
        let texels = (0..directions.len()).map(|cell| Vec3::new(r[cell], g[cell], b[cell])).collect();
        (texels, std::mem::take(&mut self.trace.tally.counts))
    }

    /// Distance from `center`, in each direction, at which `model` ends before anything else is met.
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
            let kinds = OfKind::All(RayKind::Glossy);
            let search = Search { kinds, among: SceneSubset::All, coherence: Coherence::Bounced };
            frame.tracer.closest(rays, search, hits);
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
