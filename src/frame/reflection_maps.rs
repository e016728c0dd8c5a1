//! Reflection maps: what surrounds a model, in a cube map around its middle, to be looked up instead of rays of its mirrors and glass
//! (Blinn and Newell, "Texture and Reflection in Computer Generated Images", 1976; Greene, "Environment Mapping and Other
//! Applications of World Projections", 1986).
//!
//! The only place where pixels are not true: a map is seen from the model's middle, wherever on the model a ray leaves it. Models
//! have none unless the shot says so.
//!
//! A map is a function of the places of the models and of the lights, and of nothing else: not of the camera, nor of any frame
//! before. It is kept as long as all of these are what they were, and made anew otherwise.

use glam::Vec3;
use rayon::prelude::*;

use super::bounce::{Bounces, follow};
use super::frame_view::FrameView;
use super::radiance::Radiance;
use super::trace_scratch::TraceScratch;
use crate::animation::Transform;
use crate::geometry::Bounds;
use crate::layers::Layers;
use crate::pose::{LightPose, Pose};
use crate::samples::CELLS;
use crate::scene::material::Optics;
use crate::scene::{Model, Scene};
use crate::stats::RayCounts;
use crate::trace::{Coherence, SceneSubset};

/// Surfaces of a model that are passed on the way out of it; what is behind more of them is not seen.
const MOST_LAYERS: usize = 64;

/// By how much a ray goes on behind a surface of its own model, as a share of the way.
const BEHIND: f32 = 1.0 + 1e-5;

/// The maps of a shot's models.
#[derive(Debug, Default)]
pub struct ReflectionMaps {
    /// By model; empty before the first frame.
    maps: Vec<Option<CubeMap>>,
    /// Where models and lights were when they were made.
    seen: Option<(Vec<Transform>, Vec<LightPose>)>,
}

/// What is seen around a point.
#[derive(Debug, Clone, PartialEq)]
struct CubeMap {
    /// Texels along an edge of a face, those around it not counted.
    size: usize,
    /// Six faces (towards +x, -x, +y, -y, +z, -z), each with a texel around it on all sides: neighbours are there wherever one looks up.
    texels: Vec<Vec3>,
}

/// Of a frame whose maps are not known yet, and of what maps show.
pub static NO_MAPS: ReflectionMaps = ReflectionMaps { maps: Vec::new(), seen: None };

impl ReflectionMaps {
    /// The maps of the frame's pose: these, if they are, or new ones. `bounds`: one box a model, object space. And the rays that
    /// it took.
    pub fn updated(self, frame: &FrameView, bounds: &[Bounds]) -> (Self, RayCounts) {
        if self.holds(frame.pose) { (self, RayCounts::default()) } else { Self::made(frame, bounds) }
    }

    /// What of these maps is not what would be made anew, in texels.
    pub fn differing(&self, frame: &FrameView, bounds: &[Bounds]) -> u64 {
        let (anew, _) = Self::made(frame, bounds);
        let maps =
            self.maps.iter().zip(&anew.maps).filter_map(|(kept, anew)| kept.as_ref().zip(anew.as_ref()));
        let differs = |(kept, anew): (&CubeMap, &CubeMap)| {
            kept.texels.iter().zip(&anew.texels).filter(|(kept, anew)| kept != anew).count() as u64
        };
        maps.map(differs).sum()
    }

    /// What is seen from `model` in a direction (world space, any length but zero), if it has a map.
    pub fn look_up(&self, model: u32, direction: Vec3) -> Option<Vec3> {
        self.maps.get(model as usize)?.as_ref().map(|map| map.look_up(direction))
    }

    /// Whether `model` has one.
    pub fn has(&self, model: u32) -> bool {
        self.maps.get(model as usize).is_some_and(Option::is_some)
    }

    /// Spoils what is kept, for a test of the audit.
    pub fn spoil(&mut self) {
        self.maps.iter_mut().flatten().flat_map(|map| &mut map.texels).for_each(|texel| *texel += Vec3::ONE);
    }

    /// Whether nothing that a map could show has changed.
    fn holds(&self, pose: &Pose) -> bool {
        self.seen.as_ref().is_some_and(|(models, lights)| *models == pose.models && *lights == pose.lights)
    }

    fn made(frame: &FrameView, bounds: &[Bounds]) -> (Self, RayCounts) {
        // what maps show is traced, and makes no guides of its own
        let frame = FrameView { maps: &NO_MAPS, records_paths: false, layers: Layers::NONE, ..*frame };
        let mut rays = RayCounts::default();
        let maps = frame.scene.models.iter().zip(bounds).zip(0..).map(|((model, bounds), number)| {
            let transform = frame.transform(number);
            let size =
                model.reflection_map.filter(|_| transform.is_visible && goes_on(frame.scene, model))?;
            let center = transform.point((bounds.low + bounds.high) * 0.5);
            let (map, cast) = CubeMap::around(&frame, number, center, size as usize);
            rays += cast;
            Some(map)
        });
        let maps = maps.collect();
        (Self { maps, seen: Some((frame.pose.models.clone(), frame.pose.lights.clone())) }, rays)
    }
}

/// Whether a model has mirrors or glass.
fn goes_on(scene: &Scene, model: &Model) -> bool {
    let is_opaque = |material: &u16| scene.materials[usize::from(*material)].optics == Optics::Opaque;
    !model.mesh.material_of.iter().all(is_opaque)
}

impl CubeMap {
    /// What surrounds `model`, seen from `center` (world space). And the rays that it took.
    fn around(frame: &FrameView, model: u32, center: Vec3, size: usize) -> (Self, RayCounts) {
        let directions = directions(size);
        let look =
            |scratch: &mut Scratch, directions: &[Vec3]| scratch.look(frame, model, center, directions);
        let looked: Vec<(Vec<Vec3>, RayCounts)> =
            directions.par_chunks(CELLS).map_init(Scratch::default, look).collect();
        let mut rays = RayCounts::default();
        looked.iter().for_each(|(_, cast)| rays += *cast);
        (Self { size, texels: looked.into_iter().flat_map(|(texels, _)| texels).collect() }, rays)
    }

    /// Between four texels.
    fn look_up(&self, direction: Vec3) -> Vec3 {
        let [x, y, z] = direction.abs().to_array();
        let axis = if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        };
        let face = 2 * axis + usize::from(direction[axis] < 0.0);
        let scale = 1.0 / direction[axis].abs();
        let (across, row) = (self.size as f32, self.size + 2);
        let at = [1, 2].map(|step| {
            // in texels, from the middle of the first one, which is around the face
            let at = (direction[(axis + step) % 3] * scale + 1.0) * 0.5 * across + 0.5;
            at.clamp(0.0, across + 0.999)
        });
        let [left, low] = at.map(|at| at as usize);
        let texel = |x: usize, y: usize| self.texels[(face * row + low + y) * row + left + x];
        let [u, v] = at.map(f32::fract);
        texel(0, 0).lerp(texel(1, 0), u).lerp(texel(0, 1).lerp(texel(1, 1), u), v)
    }
}

/// Through the middles of all texels of a map, in order; unit length.
fn directions(size: usize) -> Vec<Vec3> {
    let row = size + 2;
    let direction = |number: usize| {
        let (face, x, y) = (number / (row * row), number % row, number / row % row);
        let axis = face / 2;
        let mut direction = Vec3::ZERO;
        direction[axis] = if face % 2 == 0 { 1.0 } else { -1.0 };
        for (step, at) in [x, y].into_iter().enumerate() {
            direction[(axis + 1 + step) % 3] = (at as f32 - 0.5) / size as f32 * 2.0 - 1.0;
        }
        direction.normalize()
    };
    (0..6 * row * row).map(direction).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_finds_its_own_texel() {
        for size in [1, 4, 9] {
            let directions = directions(size);
            let row = size + 2;
            let inner =
                |number: &usize| [number % row, number / row % row].iter().all(|at| (1..=size).contains(at));
            let map = CubeMap { size, texels: directions.clone() };
            for number in (0..directions.len()).filter(inner) {
                let found = map.look_up(directions[number] * 3.0);
                assert!(found.distance(directions[number]) < 1e-5, "{number} of {size}");
            }
        }
    }

    #[test]
    fn between_texels_and_faces_a_map_has_no_seams() {
        let map = CubeMap { size: 16, texels: directions(16) };
        for number in 0..2000 {
            let [a, b] = [0.618_034, 0.754_878].map(|step: f32| (number as f32 * step).fract());
            let (z, turn) = (2.0 * a - 1.0, b * std::f32::consts::TAU);
            let direction = Vec3::new(turn.cos(), turn.sin(), 0.0) * (1.0 - z * z).sqrt() + Vec3::Z * z;
            // directions themselves are as good as linear from texel to texel
            assert!(map.look_up(direction).distance(direction) < 4e-3, "{direction}");
        }
        // right on edges and corners of the cube
        for direction in [Vec3::ONE, Vec3::NEG_ONE, Vec3::new(1.0, -1.0, 0.3), Vec3::new(0.0, 1.0, 1.0)] {
            assert!(map.look_up(direction).distance(direction.normalize()) < 4e-3, "{direction}");
        }
    }
}
