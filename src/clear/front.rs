//! The second proof: whatever reaches into the room of a patch lies behind the triangles of its samples.
//!
//! At silhouettes and creases a patch is no sheet: beside its triangles something else is seen. But mostly nothing is before them; of
//! what is convex nothing is before any triangle that faces the eye. If what of the room lies before the plane of a sample's triangle is
//! empty, the sample is seen, and so is the triangle wherever a ray in the room meets it. Whether the ray through a target does is a
//! matter of arithmetic, so that then no ray is needed either.

use glam::{DVec3, Vec3};

use super::EyeBox;
use super::obstacles::{Obstacles, Piece};
use super::patch::{Patch, Room, Shows};
use super::sheet::{MOST, Prover, ROUNDING, lanes_in};
use super::volume::cut;
use crate::lanes::LANES;

/// Height above a triangle's plane, as a share of the eye's, up to which something counts as lying in it. A segment to a point of the triangle ends
/// before that.
pub const IN_PLANE: f32 = 2.5e-6;

/// The plane of a triangle, world space.
#[derive(Debug, Clone, Copy)]
struct Front {
    /// A corner of the triangle.
    corner: DVec3,
    /// Normal towards the eyes, unit length.
    normal: DVec3,
    /// Height up to which something counts as lying in the plane.
    height: f64,
}

impl Front {
    /// `None` if not all `eyes` are before the triangle, or if it has no plane.
    fn new([a, b, c]: [Vec3; 3], eyes: &EyeBox, is_from_behind: bool) -> Option<Self> {
        let rounding = f64::from(ROUNDING * (a.abs() + eyes.middle.abs()).max_element());
        let [a, b, c] = [a, b, c].map(|corner| corner.as_dvec3());
        let outside = (b - a).cross(c - a).try_normalize()?;
        let normal = if is_from_behind { -outside } else { outside };
        let extent = eyes.half.as_dvec3().dot(normal.abs());
        let height = normal.dot(eyes.middle.as_dvec3() - a) - extent;
        (height > rounding).then(|| Self { corner: a, normal, height: height * f64::from(IN_PLANE) })
    }

    /// Height of a point above the plane.
    fn height_of(&self, point: Vec3) -> f64 {
        self.normal.dot(point.as_dvec3() - self.corner)
    }

    /// Returns true if nothing of a triangle is before the plane, in the room.
    fn is_clear_of(&self, piece: &Piece, room: &Room) -> bool {
        if piece.corners.iter().all(|corner| self.height_of(*corner) <= self.height) {
            return true;
        }
        // the corners of what is left are rounded
        let (corners, count) = cut(&piece.corners, &room.volume.sides);
        let is_behind = |corner: &Vec3| {
            let rounding =
                f64::from(ROUNDING * (corner.abs().max_element() + self.corner.abs().max_element() as f32));
            self.height_of(*corner) <= self.height - rounding
        };
        corners[..count].iter().all(is_behind)
    }
}

impl Prover {
    /// Returns true if it is proven that from `eyes` nothing hides the samples of a patch, nor their triangles where rays in its room meet
    /// these.
    pub fn is_unhidden(&mut self, obstacles: &Obstacles, eyes: &EyeBox, patch: &Patch) -> bool {
        let Shows::Surface { model, is_from_behind, .. } = patch.shows else { return false };
        let Some(room) = patch.room(eyes, &mut self.balls) else { return false };
        for lanes in patch.lanes {
            let (mut fronts, mut last) = ([None::<Front>; LANES], None);
            for lane in lanes_in(lanes.used) {
                let triangle = lanes.triangles[lane];
                // neighbours mostly lie on one
                if last.replace(triangle) == Some(triangle) {
                    continue;
                }
                let corners = obstacles.corners(model, triangle);
                let Some(front) = corners.and_then(|corners| Front::new(corners, eyes, is_from_behind))
                else {
                    return false;
                };
                fronts[lane] = Some(front);
            }
            let is_behind =
                |piece: &Piece| fronts.iter().flatten().all(|front| front.is_clear_of(piece, &room));
            let Self { found, stack, .. } = self;
            if obstacles.find(&room.volume, (MOST, &is_behind), stack, found).is_err() {
                return false;
            }
        }
        true
    }
}
