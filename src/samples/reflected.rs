//! Paths by which the layers of samples reflect, and the direction to the eye for which they were drawn.
//!
//! The light that arrives from a direction does not depend on the eye; only the share of it that the layer
//! sends on does. So a path serves other eyes as well, as long as it is weighted for them.

use super::store::HalfColor;
use super::{Octahedral, TagLayout};
use crate::changes::Until;
use glam::Vec3;
use half::f16;

/// Result of a reflected path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReflectedLight {
    /// Radiance, linear RGB, never negative. The sign of the first channel is set if the light source is in
    /// sight that the surface asks beside the path.
    bits: HalfColor,
    /// First frame in which any of it may differ.
    pub until: Until,
}

const _: () = assert!(size_of::<ReflectedLight>() == 8);

impl ReflectedLight {
    /// Result that is not known.
    pub const UNKNOWN: Self = Self { bits: [f16::ZERO; 3], until: Until::UNKNOWN };

    /// Creates a result. `sees_light`: the light source that the surface asks is in sight.
    pub fn new(radiance: HalfColor, sees_light: bool, until: Until) -> Self {
        let [r, g, b] = radiance.map(|half| half.max(f16::ZERO));
        Self { bits: [if sees_light { -r } else { r }, g, b], until }
    }

    /// Creates a result from its [`bits`](Self::bits).
    pub fn from_bits(bits: HalfColor, until: Until) -> Self {
        Self { bits, until }
    }

    /// Radiance, with [`sees_light`](Self::sees_light) as the sign of its first channel.
    pub fn bits(self) -> HalfColor {
        self.bits
    }

    /// Radiance, linear RGB.
    pub fn radiance(self) -> Vec3 {
        let [r, g, b] = self.bits.map(f16::to_f32);
        Vec3::new(r.abs(), g, b)
    }

    /// Returns true if the light source that the surface asks is in sight.
    pub fn sees_light(self) -> bool {
        self.bits[0].is_sign_negative()
    }
}

/// Reflected paths of a list of samples. There is nothing if no surface of the shot has a rough layer.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReflectedPaths {
    /// Largest number of paths of a sample.
    pub(super) paths: usize,
    /// Results, sample by sample.
    of_paths: Vec<ReflectedLight>,
    /// Direction to the eye for which each sample's paths were drawn; world space.
    drawn_for: Vec<Octahedral>,
}

impl ReflectedPaths {
    /// Creates the paths of `count` samples, of which none is known.
    pub fn unknown(layout: &TagLayout, count: usize) -> Self {
        let paths = layout.reflections;
        Self {
            paths,
            of_paths: vec![ReflectedLight::UNKNOWN; paths * count],
            drawn_for: vec![Octahedral::default(); if paths == 0 { 0 } else { count }],
        }
    }

    /// Size of a sample's part, in bytes.
    pub fn bytes_of_sample(layout: &TagLayout) -> usize {
        match layout.reflections {
            0 => 0,
            paths => paths * size_of::<ReflectedLight>() + size_of::<Octahedral>(),
        }
    }

    /// Returns memory that is not needed.
    pub fn trim(&mut self) {
        self.of_paths.shrink_to_fit();
        self.drawn_for.shrink_to_fit();
    }

    /// Memory held on the heap, in bytes.
    pub fn bytes(&self) -> usize {
        self.of_paths.capacity() * size_of::<ReflectedLight>()
            + self.drawn_for.capacity() * size_of::<Octahedral>()
    }

    /// Returns true if samples keep reflected paths.
    pub fn is_some(&self) -> bool {
        self.paths != 0
    }

    /// Results of a sample's paths, in their order. Those of paths that its layer does not have are unknown.
    pub fn paths(&self, sample: usize) -> &[ReflectedLight] {
        &self.of_paths[sample * self.paths..(sample + 1) * self.paths]
    }

    /// Results of those paths of a sample that its layer has, once they are traced.
    pub fn known(&self, sample: usize) -> &[ReflectedLight] {
        let paths = self.paths(sample);
        let known = paths.iter().position(|path| path.until == Until::UNKNOWN);
        &paths[..known.unwrap_or(paths.len())]
    }

    /// Stores the result of path number `path` of a sample. Returns true if its light has changed.
    pub fn set_path(&mut self, sample: usize, path: usize, light: ReflectedLight) -> bool {
        let before = std::mem::replace(&mut self.of_paths[sample * self.paths + path], light);
        before.bits != light.bits || before.until == Until::UNKNOWN
    }

    /// Direction to the eye for which the paths of a sample were drawn; world space, unit length.
    pub fn drawn_for(&self, sample: usize) -> Octahedral {
        self.drawn_for[sample]
    }

    /// Forgets the paths of a sample, and has new ones drawn for an eye in this direction.
    pub fn draw_for(&mut self, sample: usize, to_eye: Octahedral) {
        self.forget_one(sample);
        self.drawn_for[sample] = to_eye;
    }

    /// Resets the paths of a sample.
    pub fn forget_one(&mut self, sample: usize) {
        self.of_paths[sample * self.paths..(sample + 1) * self.paths].fill(ReflectedLight::UNKNOWN);
    }

    /// Resets the paths of all samples.
    pub fn forget_all(&mut self) {
        self.of_paths.fill(ReflectedLight::UNKNOWN);
    }

    /// Expiry of all paths.
    pub fn validity(&mut self) -> impl Iterator<Item = &mut Until> {
        self.of_paths.iter_mut().map(|path| &mut path.until)
    }

    /// Copies sample number `at` of `from` to `sample`.
    #[inline]
    pub fn copy(&mut self, sample: usize, from: &Self, at: usize) {
        if self.is_some() {
            let paths = self.paths;
            self.of_paths[sample * paths..(sample + 1) * paths].copy_from_slice(from.paths(at));
            self.drawn_for[sample] = from.drawn_for[at];
        }
    }

    /// Appends sample number `at` of `from` to the list.
    pub fn push(&mut self, from: &Self, at: usize) {
        if self.is_some() {
            self.of_paths.extend_from_slice(from.paths(at));
            self.drawn_for.push(from.drawn_for[at]);
        }
    }

    /// Removes all samples, and keeps their memory.
    pub fn clear(&mut self) {
        self.of_paths.clear();
        self.drawn_for.clear();
    }

    /// Sets the direction for which the paths of a sample were drawn, and leaves the paths.
    pub fn set_drawn_for(&mut self, sample: usize, to_eye: Octahedral) {
        self.drawn_for[sample] = to_eye;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(value: f32, sees_light: bool) -> ReflectedLight {
        ReflectedLight::new([f16::from_f32(value); 3], sees_light, Until::FOREVER)
    }

    #[test]
    fn a_result_tells_light_and_sight_apart() {
        for (value, sees_light) in [(0.0, true), (0.0, false), (2.5, true), (2.5, false)] {
            let kept = light(value, sees_light);
            assert_eq!((kept.radiance(), kept.sees_light()), (Vec3::splat(value), sees_light));
            assert_eq!(ReflectedLight::from_bits(kept.bits(), kept.until), kept);
        }
    }

    #[test]
    fn paths_go_with_their_sample_until_others_are_drawn() {
        let layout = TagLayout::default().with_reflections(2);
        let mut paths = ReflectedPaths::unknown(&layout, 8);
        assert_eq!(ReflectedPaths::bytes_of_sample(&layout), 20);
        let to_eye = Octahedral::fold(Vec3::X);
        paths.draw_for(5, to_eye);
        assert!(paths.set_path(5, 1, light(1.0, true)), "nothing was known");
        assert!(!paths.set_path(5, 1, light(1.0, true)) && paths.set_path(5, 1, light(1.0, false)));
        let mut spares = ReflectedPaths::unknown(&layout, 0);
        spares.push(&paths, 5);
        paths.forget_all();
        paths.copy(2, &spares, 0);
        assert_eq!((paths.drawn_for(2), paths.paths(2)[1]), (to_eye, light(1.0, false)));
        paths.draw_for(2, Octahedral::fold(Vec3::Y));
        assert_eq!(paths.paths(2), [ReflectedLight::UNKNOWN; 2]);
    }
}
