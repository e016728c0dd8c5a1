//! Bright sky on rough surfaces: rays towards it, beside those that follow the surface's roughness.
//!
//! Few of a rough surface's own rays meet a sun, and each of these would be far too bright. So for each ray
//! that follows the roughness another one is sent in proportion to the light of the sky, and both are
//! weighted by the balance heuristic (Veach and Guibas, "Optimally Combining Sampling Techniques for Monte
//! Carlo Rendering", 1995).
//!
//! Clear glass blocks these rays, though it does not block shadow rays: the sky behind it is found by the
//! other rays alone.

use glam::Vec3;

use super::bounced_ray::Bounce;
use super::tree_times::TreeTimes;
use crate::frame::grid::bits::bit;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::radiance::{Layer, Radiance};
use crate::frame::surface::ray_tally::RayTally;
use crate::scene::LightFrom;
use crate::shade::Surface;
use crate::shade::coat::SeenCoat;
use crate::trace::{Coherence, Occluders, Purpose, RayBatch};

/// Least light for which a ray is cast: a hundredth of the step of an 8-bit picture at full brightness.
const LEAST_LIGHT: f32 = 1.0 / 51200.0;

/// A ray to the sky, and the light that it adds to a cell if nothing is in its way.
#[derive(Debug, Clone, Copy)]
struct SkyRay {
    cell: u32,
    layer: Layer,
    origin: Vec3,
    direction: Vec3,
    light: Vec3,
}

/// Queue of rays to be cast.
#[derive(Debug, Default)]
pub struct RoughSky {
    waiting: Vec<SkyRay>,
    rays: RayBatch,
    blocked: Vec<u16>,
    by_still: Vec<u16>,
}

impl RoughSky {
    /// Removes all rays.
    pub fn clear(&mut self) {
        self.waiting.clear();
    }

    /// Adds a ray from `surface` in a direction that two `random` numbers choose. The light that `seen`
    /// reflects counts like that of `bounce`, a ray that leaves the surface.
    pub fn ask(
        &mut self,
        frame: &FrameView,
        (surface, seen): (&Surface, &SeenCoat),
        bounce: &Bounce,
        random: [f32; 2],
    ) {
        if seen.is_smooth() || !frame.sky.is_uneven() {
            return;
        }
        let direction = frame.sky.sample(random);
        if surface.geometric_normal.dot(direction) <= 0.0 {
            return;
        }
        let LightFrom { radiance, pdf } = frame.sky.light(direction);
        if pdf <= 0.0 {
            return;
        }
        let (reflected, by_roughness) = seen.towards(direction);
        let Bounce { cell, layer, weight, .. } = *bounce;
        let light = bounce.limited(frame, weight * reflected * radiance / (pdf + by_roughness));
        if light.max_element() >= LEAST_LIGHT {
            self.waiting.push(SkyRay { cell, layer, origin: surface.leave(direction), direction, light });
        }
    }

    /// Casts the rays, and adds their light.
    pub fn cast(
        &mut self,
        frame: &FrameView,
        radiance: &mut Radiance,
        times: &mut TreeTimes,
        tally: &mut RayTally,
    ) {
        let Self { waiting, rays, blocked, by_still } = self;
        if waiting.is_empty() {
            return;
        }
        rays.clear();
        for ray in &*waiting {
            rays.push(ray.origin, ray.direction, 0.0, f32::INFINITY);
            let counted = &mut tally.cells.secondary[ray.cell as usize];
            *counted = counted.saturating_add(1);
        }
        tally.counts.reflection += waiting.len() as u64;
        blocked.clear();
        blocked.resize(rays.packet_count(), 0);
        let ask = |by, blocked: &mut [u16]| {
            frame.tracer.blocked(rays, by, Purpose::Sight, Coherence::Incoherent, blocked);
        };
        ask(Occluders::Still, blocked);
        by_still.clone_from(blocked);
        ask(Occluders::Movable, blocked);
        for (number, ray) in waiting.drain(..).enumerate() {
            // a still occluder stays in the way, whatever else comes there or goes
            if !bit(by_still, number) {
                times.note_segment(frame, ray.cell, ray.origin, ray.direction, f32::INFINITY);
            }
            if !bit(blocked, number) {
                radiance.add_secondary(ray.layer, ray.cell as usize, ray.light);
            }
        }
    }
}
