//! Ways on from a surface that a light path has met.

use glam::Vec3;

use crate::frame::shot::frame_view::FrameView;
use crate::shade::Surface;
use crate::shade::coat::SeenCoat;
use crate::shade::optics::branch;

/// Ways on from a surface: diffusely, off a mirror, through glass, and off the layer of a metal-rough
/// surface.
#[derive(Debug, Clone, Copy)]
pub struct Lobes {
    /// Weight of the light that each carries, and its direction where it has but one.
    pub ways: [(Vec3, Option<Vec3>); 4],
}

impl Lobes {
    /// Number of the way through glass.
    pub const THROUGH: usize = 2;

    /// Number of the way off the layer.
    pub const COAT: usize = 3;

    /// Number of the way on by the cosine law.
    pub const DIFFUSE: usize = 0;

    /// Computes the ways on from a surface that was met along `incoming`; `coat` is its layer, if it has one.
    pub fn new(frame: &FrameView, surface: &Surface, incoming: Vec3, coat: Option<&SeenCoat>) -> Self {
        let albedo = frame.palette.albedo_of(surface.material, surface.reflectance);
        let mut ways = [(albedo, None), (Vec3::ZERO, None), (Vec3::ZERO, None), (Vec3::ZERO, None)];
        if let Some(coat) = coat {
            ways[0].0 *= coat.through;
        }
        if let Some(coat) = coat.filter(|_| frame.depth > 0) {
            ways[Self::COAT].0 = coat.albedo;
        }
        if frame.depth > 0 {
            let optics = frame.scene.materials[usize::from(surface.material)].optics;
            let branches = branch(optics, surface, incoming);
            for (way, branch) in ways[1..].iter_mut().zip([branches.reflection, branches.refraction]) {
                if let Some(branch) = branch {
                    *way = (branch.weight, Some(branch.direction));
                }
            }
        }
        Self { ways }
    }

    /// Share of a way, not normalized: the largest channel of its weight.
    fn share(&self, way: usize) -> f32 {
        self.ways[way].0.max_element().max(0.0)
    }

    fn sum(&self) -> f32 {
        (0..self.ways.len()).map(|way| self.share(way)).sum()
    }

    /// Probability with which a path takes a way.
    pub fn chance(&self, way: usize) -> f32 {
        let sum = self.sum();
        if sum > 0.0 && sum.is_finite() { self.share(way) / sum } else { 0.0 }
    }

    /// Way that a random number from 0 to below 1 chooses.
    pub fn choose(&self, choice: f32) -> Option<usize> {
        let mut at = choice * self.sum();
        let chosen = (0..self.ways.len()).find(|way| {
            let is_here = at < self.share(*way);
            at -= self.share(*way);
            is_here
        });
        // rounding may lead past the last way that carries anything
        chosen.or_else(|| (0..self.ways.len()).rfind(|way| self.chance(*way) > 0.0))
    }
}
