//! Clear sight: proofs, without a ray, that all that can be seen in a part of the picture is one surface.
//!
//! A [`Patch`] is a few samples that lie beside each other, each with the room around it that rays through targets may need. It is
//! *clear* for all eyes in a [box](EyeBox) if every ray from such an eye through the room of a sample meets one sheet of one model
//! first, and nothing else ([`sheet`]). Then the samples are seen, and so is their surface at the targets that they serve: neither has
//! to be asked, for as long as the eye stays in the box.
//!
//! The proof is about models at rest alone. Of them it has a tree of boxes ([`Obstacles`]), which is searched for what reaches into a
//! [`volume`] that holds all these rays. Everything is rounded towards "not proven", which costs a ray and no error.
//!
//! (Beams are traced through trees by A. Reshetov and others, "Multi-Level Ray Tracing Algorithm", 2005. They look for where rays may
//! begin; here the answer is that none is needed.)

mod obstacles;
mod patch;
mod sheet;
#[cfg(test)]
mod tests;
mod volume;

use glam::Vec3;

use crate::geometry::Bounds;

pub use obstacles::Obstacles;
pub use patch::{Lanes, Patch, Shows};
pub use sheet::Prover;

/// A box of places that an eye takes, world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EyeBox {
    /// Its middle.
    pub middle: Vec3,
    /// Half its size along each axis.
    pub half: Vec3,
}

impl EyeBox {
    /// Smallest such box around `places`, which are not empty.
    pub fn new(places: &Bounds) -> Self {
        let middle = 0.5 * (places.low + places.high);
        // the middle is rounded
        Self { middle, half: (places.high - middle).max(middle - places.low) }
    }

    /// Half its extent along a direction, for a unit of that direction's length.
    pub fn extent(&self, direction: Vec3) -> f32 {
        self.half.dot(direction.abs())
    }
}
