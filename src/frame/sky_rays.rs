//! Rays from surfaces to the sky, in directions from which much light comes (next-event estimation).
//!
//! Paths that escape find the sky, too. What either way finds is weighed by the balance heuristic (Veach and Guibas,
//! "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995): by its density in the sum of both.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::bits::bit;
use super::frame_view::FrameView;
use super::path_ends::{Brought, PathStart};
use super::ray_tally::RayTally;
use crate::shade::surface::off_surface;
use crate::trace::{Coherence, Occluders, Purpose, RayBatch};

/// How likely the two ways are that lead from a surface to the sky.
#[derive(Debug, Clone, Copy)]
pub struct Chances {
    /// The probability with which the sky is asked from there.
    pub asks_sky: f32,
    /// The probability with which a path goes on from there by the cosine law.
    pub goes_on: f32,
}

impl Chances {
    /// Of a surface off which nothing else than its path finds the sky.
    pub const PATH_ALONE: Self = Self { asks_sky: 0.0, goes_on: 1.0 };

    /// The weight of the sky in `direction` where a path finds it that left a surface with this `normal`.
    pub fn of_path(self, frame: &FrameView, normal: Vec3, direction: Vec3) -> f32 {
        if self.asks_sky == 0.0 {
            return 1.0;
        }
        let by_path = self.goes_on * cosine_pdf(normal, direction);
        by_path / (by_path + self.asks_sky * frame.sky.pdf(direction))
    }
}

/// The density of directions by the cosine law about `normal`, in solid angle.
fn cosine_pdf(normal: Vec3, direction: Vec3) -> f32 {
    normal.dot(direction).max(0.0) * FRAC_1_PI
}

/// A surface that asks.
#[derive(Debug, Clone, Copy)]
pub struct Asking {
    /// Number of its path.
    pub path: u32,
    /// World space.
    pub point: Vec3,
    /// For shading.
    pub normal: Vec3,
    /// Of the triangle.
    pub geometric_normal: Vec3,
    /// Of what a white surface would reflect, in what the path brings.
    pub weight: Vec3,
    /// Of the ways to the sky.
    pub chances: Chances,
}

/// A ray, and what it brings if nothing is in its way.
#[derive(Debug, Clone, Copy)]
struct SkyRay {
    path: u32,
    origin: Vec3,
    direction: Vec3,
    light: Vec3,
}

/// Rays that wait to be cast.
#[derive(Debug, Default)]
pub struct SkyRays {
    waiting: Vec<SkyRay>,
    rays: RayBatch,
    blocked: Vec<u16>,
}

impl SkyRays {
    /// Adds a ray in a direction that two `random` numbers choose, if it leaves the surface.
    pub fn push(&mut self, frame: &FrameView, asking: &Asking, random: [f32; 2]) {
        let Asking { path, point, normal, geometric_normal, weight, chances } = *asking;
        let (direction, pdf) = frame.sky.sample(random);
        let by_cosine = cosine_pdf(normal, direction);
        if by_cosine <= 0.0 || geometric_normal.dot(direction) <= 0.0 || pdf <= 0.0 {
            return;
        }
        let densities = chances.asks_sky * pdf + chances.goes_on * by_cosine;
        let light = weight * frame.sky.radiance(direction) * (by_cosine / densities);
        self.waiting.push(SkyRay { path, origin: off_surface(point, geometric_normal), direction, light });
    }

    /// Casts the rays, and adds to what the paths have `brought`, which began at `starts`.
    pub fn cast(
        &mut self,
        frame: &FrameView,
        starts: &[PathStart],
        brought: &mut [Brought],
        tally: &mut RayTally,
    ) {
        let Self { waiting, rays, blocked } = self;
        if waiting.is_empty() {
            return;
        }
        rays.clear();
        for ray in &*waiting {
            rays.push(ray.origin, ray.direction, 0.0, f32::INFINITY);
            let counted = &mut tally.cells.shadow[starts[ray.path as usize].cell as usize];
            *counted = counted.saturating_add(1);
        }
        tally.counts.shadow += waiting.len() as u64;
        blocked.clear();
        blocked.resize(rays.packet_count(), 0);
        for by in [Occluders::Still, Occluders::Movable] {
            frame.tracer.blocked(rays, by, Purpose::Shadow, Coherence::Incoherent, blocked);
        }
        for (number, ray) in waiting.drain(..).enumerate() {
            let brought = &mut brought[ray.path as usize];
            let until = frame.first_touch(ray.origin, ray.direction, f32::INFINITY);
            brought.until = brought.until.min(until);
            if !bit(blocked, number) {
                brought.radiance += ray.light;
            }
        }
    }
}
