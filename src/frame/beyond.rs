//! Where the rays went that left the mirrors and the glass of a tile. Before a camera at rest they bring the same
//! again as long as nothing moves there.

use glam::Vec3;

use super::rest::Around;
use super::stage::Stage;
use crate::geometry::{Bounds, SweptBox as Sweep};

/// Rays that share a [`Ways`]: neighbours, so that their boxes are small, and enough that there are few.
pub const TOGETHER: usize = 64;

/// Where some rays went that have bounced equally often. World space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ways {
    /// Where they began.
    from: Bounds,
    /// What they met, and from where lights were asked for.
    met: Bounds,
    /// Directions of those that met nothing.
    sky: Bounds,
}

impl Ways {
    /// No ray.
    pub const NONE: Self = Self { from: Bounds::EMPTY, met: Bounds::EMPTY, sky: Bounds::EMPTY };

    /// Adds a ray that met a surface.
    pub fn add_to_surface(&mut self, from: Vec3, point: Vec3) {
        self.from = self.from.with(from);
        self.met = self.met.with(point);
    }

    /// Adds a ray that met nothing.
    pub fn add_to_sky(&mut self, from: Vec3, direction: Vec3) {
        self.from = self.from.with(from);
        self.sky = self.sky.with(direction);
    }

    /// Whether anything that moved may be on a way, or between a light and what was met. A `false` is certain.
    fn may_be_met(&self, stage: &Stage) -> bool {
        let meets = |bounds: &Bounds, sweep: fn(&Bounds, &Bounds) -> Sweep| {
            !bounds.is_empty() && stage.movers.may_meet_sweep(&sweep(&self.from, bounds))
        };
        let met = Around::surfaces(self.met);
        meets(&self.met, Sweep::between)
            || meets(&self.sky, Sweep::fans)
            || stage.pose.lights.iter().any(|light| met.may_be_in_shadow(stage.movers, light))
    }
}

/// Where all rays of a tile went.
#[derive(Debug, Clone, Default)]
pub struct Beyond {
    ways: Vec<Ways>,
    /// Whether a model that moves in some frame may have been met, or was in the way of a light: it may be gone in the
    /// next frame.
    has_movable: bool,
}

impl Beyond {
    /// No ray, yet.
    pub fn clear(&mut self) {
        self.ways.clear();
        self.has_movable = false;
    }

    /// More rays, if there are any.
    pub fn add(&mut self, ways: Ways) {
        if ways != Ways::NONE {
            self.ways.push(ways);
        }
    }

    /// Notes that a movable model was seen, or cast a shadow that was.
    pub fn note_movable(&mut self, any: bool) {
        self.has_movable |= any;
    }

    /// Whether all rays would bring what they brought, if no light has changed.
    pub fn is_out_of_reach(&self, stage: &Stage) -> bool {
        !self.has_movable && !self.ways.iter().any(|ways| ways.may_be_met(stage))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.ways.capacity() * size_of::<Ways>()
    }
}
