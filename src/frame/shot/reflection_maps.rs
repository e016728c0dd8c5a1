//! Reflection maps: the surroundings of a model in a cube map around its centre, to be looked up instead of
//! rays of its mirrors and glass (Blinn and Newell, "Texture and Reflection in Computer Generated Images",
//! 1976; Greene, "Environment Mapping and Other Applications of World Projections", 1986).
//!
//! This is the only place where pixels are not exact: a map is seen from the model's centre, wherever on the
//! model a ray leaves it. Models have none unless the shot says so.
//!
//! A map is a function of the places of the models and of the lights, and of nothing else: not of the camera,
//! nor of any frame before. It is kept as long as all of these stay the same, and made anew otherwise
//! ([`surroundings`](crate::frame::secondary::surroundings)).

use glam::Vec3;

use crate::animation::Transform;
use crate::exposure::MIDDLE_TICK;
use crate::pose::{LightPose, Pose};
use crate::sweep::Sweeps;

/// Maps of a shot's models.
#[derive(Debug, Default)]
pub struct ReflectionMaps {
    /// Map of each model that has one; empty before the first frame.
    maps: Vec<Option<CubeMap>>,
    /// Places of models, and lights, with which the maps were made.
    seen: Option<(Vec<Transform>, Sweeps, Vec<LightPose>)>,
}

/// Light around a point.
#[derive(Debug, Clone, PartialEq)]
pub struct CubeMap {
    /// Texels along an edge of a face, without the rim.
    size: usize,
    /// Six faces (towards +x, -x, +y, -y, +z, -z), each with a rim of one texel, so that every look-up finds
    /// its neighbours.
    texels: Vec<Vec3>,
}

/// No maps: for a frame whose maps are not made yet, and for rays of maps themselves.
pub static NO_MAPS: ReflectionMaps = ReflectionMaps { maps: Vec::new(), seen: None };

impl ReflectionMaps {
    /// Looks up the light from a direction (world space, any length but zero) around `model`, if it has a
    /// map.
    pub fn look_up(&self, model: u32, direction: Vec3) -> Option<Vec3> {
        self.maps.get(model as usize)?.as_ref().map(|map| map.look_up(direction))
    }

    /// Returns true if `model` has a map.
    pub fn has(&self, model: u32) -> bool {
        self.maps.get(model as usize).is_some_and(Option::is_some)
    }

    /// Changes all texels, for a test of the audit.
    pub fn spoil(&mut self) {
        self.maps.iter_mut().flatten().flat_map(|map| &mut map.texels).for_each(|texel| *texel += Vec3::ONE);
    }

    /// Number of texels that differ from those in `anew`.
    pub fn differing(&self, anew: &Self) -> u64 {
        let maps =
            self.maps.iter().zip(&anew.maps).filter_map(|(kept, anew)| kept.as_ref().zip(anew.as_ref()));
        let differs = |(kept, anew): (&CubeMap, &CubeMap)| {
            kept.texels.iter().zip(&anew.texels).filter(|(kept, anew)| kept != anew).count() as u64
        };
        maps.map(differs).sum()
    }

    /// Returns true if models and lights are as when the maps were made.
    pub fn holds(&self, pose: &Pose) -> bool {
        self.seen.as_ref().is_some_and(|(models, sweeps, lights)| {
            *models == pose.models && *sweeps == pose.sweeps && lights == pose.lights_at(MIDDLE_TICK)
        })
    }

    /// Creates maps that were made with the models and lights of `pose`.
    pub fn new(maps: Vec<Option<CubeMap>>, pose: &Pose) -> Self {
        let lights = pose.lights_at(MIDDLE_TICK).to_vec();
        Self { maps, seen: Some((pose.models.clone(), pose.sweeps.clone(), lights)) }
    }
}

impl CubeMap {
    /// Creates a map from the light in all [`directions`] of a map of this size.
    pub fn new(size: usize, texels: Vec<Vec3>) -> Self {
        Self { size, texels }
    }

    /// Interpolates between four texels.
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
            // in texels, from the centre of the first one, which is in the rim
            let at = (direction[(axis + step) % 3] * scale + 1.0) * 0.5 * across + 0.5;
            at.clamp(0.0, across + 0.999)
        });
        let [left, low] = at.map(|at| at as usize);
        let texel = |x: usize, y: usize| self.texels[(face * row + low + y) * row + left + x];
        let [u, v] = at.map(f32::fract);
        texel(0, 0).lerp(texel(1, 0), u).lerp(texel(0, 1).lerp(texel(1, 1), u), v)
    }
}

/// Directions through the centres of all texels of a map, in order; unit length.
pub fn directions(size: usize) -> Vec<Vec3> {
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
