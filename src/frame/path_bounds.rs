//! Where the rays went that left the mirrors and the glass of a tile. While the camera does not move, they bring the
//! same again as long as nothing moves there.

use glam::Vec3;

use super::frame_view::FrameView;
use super::tile_bounds::TileBounds;
use crate::changes::Until;
use crate::geometry::{Bounds, SweptBox};

/// Rays that share a [`PathBounds`]: neighbours, so that their boxes are small, and enough that there are few.
pub const TOGETHER: usize = 64;

/// Boxes around the paths of some rays that have bounced equally often. World space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathBounds {
    /// Where they began.
    from: Bounds,
    /// What they met, and from where lights were asked for.
    met: Bounds,
    /// Directions of those that met nothing.
    sky: Bounds,
}

impl PathBounds {
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

    /// Whether anything that moved may be on a path, or between a light and what was met. A `false` is certain.
    fn may_be_met(&self, frame: &FrameView) -> bool {
        let meets = |bounds: &Bounds, swept: fn(&Bounds, &Bounds) -> SweptBox| {
            !bounds.is_empty() && frame.moved_bounds.may_meet_sweep(&swept(&self.from, bounds))
        };
        let met = TileBounds::surfaces(self.met);
        meets(&self.met, SweptBox::between)
            || meets(&self.sky, SweptBox::fans)
            || frame.pose.lights.iter().any(|light| met.may_be_in_shadow(frame.moved_bounds, light))
    }
}

/// Around the paths of all rays of a tile.
#[derive(Debug, Clone)]
pub struct TilePaths {
    paths: Vec<PathBounds>,
    /// Whether a model that moves in some frame may have been met, or was in the way of a light: it may be gone in the
    /// next frame.
    has_dynamic: bool,
    /// The first frame in which what they met may gather another light.
    until: Until,
}

impl Default for TilePaths {
    fn default() -> Self {
        Self { paths: Vec::new(), has_dynamic: false, until: Until::FOREVER }
    }
}

impl TilePaths {
    /// No ray, yet.
    pub fn clear(&mut self) {
        self.paths.clear();
        self.has_dynamic = false;
        self.until = Until::FOREVER;
    }

    /// Notes how long the light holds that something gathers that was met.
    pub fn note_until(&mut self, until: Until) {
        self.until = self.until.min(until);
    }

    /// More rays, if there are any.
    pub fn add(&mut self, bounds: PathBounds) {
        if bounds != PathBounds::NONE {
            self.paths.push(bounds);
        }
    }

    /// Notes that a movable model was seen, or cast a shadow that was.
    pub fn note_dynamic(&mut self, any: bool) {
        self.has_dynamic |= any;
    }

    /// Whether all rays would bring what they brought, if no light has changed.
    pub fn is_out_of_reach(&self, frame: &FrameView) -> bool {
        !self.has_dynamic
            && !frame.has_expired(self.until)
            && !self.paths.iter().any(|bounds| bounds.may_be_met(frame))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.paths.capacity() * size_of::<PathBounds>()
    }
}
