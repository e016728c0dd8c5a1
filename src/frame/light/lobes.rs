//! Lobes of a surface that a light path has met: where light may have come from.

use glam::Vec3;

use crate::frame::shot::frame_view::FrameView;
use crate::shade::Surface;
use crate::shade::bsdf::SeenBsdf;
use crate::shade::optics::{branch, random_of_place};

/// Lobes of a surface: diffuse, off a mirror, through glass, and off the layer of a metal-rough surface.
#[derive(Debug, Clone, Copy)]
pub struct Lobes {
    /// Weight of the light that each carries, and its direction where it has but one.
    pub all: [(Vec3, Option<Vec3>); 4],
    /// Share of each, not normalized: the largest channel of its weight.
    shares: [f32; 4],
    /// Sum of the shares.
    sum: f32,
}

impl Lobes {
    /// Number of the lobe through glass.
    pub const THROUGH: usize = 2;

    /// Number of the lobe off the layer.
    pub const GLOSSY: usize = 3;

    /// Number of the lobe of the cosine law.
    pub const DIFFUSE: usize = 0;

    /// Computes the lobes of a surface that was met along `incoming`; `bsdf` is its layer, if it has one.
    #[inline(always)]
    pub fn new(frame: &FrameView, surface: &Surface, incoming: Vec3, bsdf: Option<&SeenBsdf>) -> Self {
        let albedo = frame.palette.albedo_of(surface.look(), surface.reflectance);
        let mut all = [(albedo, None), (Vec3::ZERO, None), (Vec3::ZERO, None), (Vec3::ZERO, None)];
        if let Some(bsdf) = bsdf {
            all[0].0 *= bsdf.through;
        }
        if let Some(bsdf) = bsdf.filter(|_| frame.settings.depth > 0) {
            all[Self::GLOSSY].0 = bsdf.albedo;
        }
        let material = &frame.scene.materials[usize::from(surface.material)];
        if frame.settings.depth > 0 && !material.is_opaque_at(surface.varied) {
            let branches = branch(material, surface, incoming, || random_of_place(surface));
            for (lobe, branch) in all[1..].iter_mut().zip([branches.reflection, branches.refraction]) {
                if let Some(branch) = branch {
                    *lobe = (branch.weight, Some(branch.direction));
                }
            }
        }
        let shares = all.map(|(weight, _)| weight.max_element().max(0.0));
        Self { all, shares, sum: shares.iter().sum() }
    }

    /// Lobes of a matt surface with this albedo.
    pub fn matt(albedo: Vec3) -> Self {
        let all = [(albedo, None), (Vec3::ZERO, None), (Vec3::ZERO, None), (Vec3::ZERO, None)];
        let shares = all.map(|(weight, _)| weight.max_element());
        Self { all, shares, sum: shares.iter().sum() }
    }

    /// Probability with which a path samples a lobe.
    pub fn chance(&self, lobe: usize) -> f32 {
        if self.sum > 0.0 && self.sum.is_finite() { self.shares[lobe] / self.sum } else { 0.0 }
    }

    /// Way that a random number from 0 to below 1 chooses.
    pub fn choose(&self, choice: f32) -> Option<usize> {
        let mut at = choice * self.sum;
        let chosen = self.shares.iter().position(|share| {
            let is_here = at < *share;
            at -= share;
            is_here
        });
        // rounding may lead past the last lobe that carries anything
        chosen.or_else(|| (0..self.all.len()).rfind(|lobe| self.chance(*lobe) > 0.0))
    }
}
