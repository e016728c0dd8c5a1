//! Pictures of the shot.
//!
//! They are no kinds of nodes that a name makes: which number a picture has is known where it is read.

use std::sync::Arc;

use glam::Vec3;

use crate::graph::{Function, Graph, Input, Kind, Place, Places};
use crate::lanes::Vec3x8;

/// A channel of a picture, or its colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// Linear RGB.
    Color,
    /// Mean of red, green and blue.
    Mean,
    /// Red, green or blue, by its number.
    Channel(usize),
    /// Alpha, from 0 to 1.
    Alpha,
}

impl Shown {
    /// Kind of its values.
    pub fn kind(self) -> Kind {
        match self {
            Self::Color => Kind::Color,
            Self::Mean | Self::Channel(_) | Self::Alpha => Kind::Number,
        }
    }
}

/// Adds picture number `number` of the shot to a graph, `at` a vector; without one at the texture coordinates that the picture takes.
pub fn add(graph: &mut Graph, number: u32, shown: Shown, at: Option<Input>) -> Input {
    let picture = Picture { number, shown, is_at: at.is_some() };
    graph.add(Arc::new(picture), at.into_iter().collect())
}

#[derive(Debug)]
struct Picture {
    number: u32,
    shown: Shown,
    /// True if its input says where.
    is_at: bool,
}

impl Function for Picture {
    fn is_of_place(&self) -> bool {
        true
    }

    fn is_filtered(&self) -> bool {
        // alpha decides what is there, which does not depend on from where it is seen
        !self.is_at && self.shown != Shown::Alpha
    }

    fn values(&self, inputs: &[Vec3x8], places: Places) -> Vec3x8 {
        places.lane_by_lane(inputs, |inputs, place| self.value(inputs, place))
    }
}

impl Picture {
    fn value(&self, inputs: &[Vec3], place: &dyn Place) -> Vec3 {
        let [r, g, b, alpha] = place.picture(self.number, inputs.first().map(|at| at.truncate()));
        match self.shown {
            Shown::Color => Vec3::new(r, g, b),
            Shown::Mean => Vec3::splat((r + g + b) / 3.0),
            Shown::Channel(number) => Vec3::splat([r, g, b][number.min(2)]),
            Shown::Alpha => Vec3::splat(alpha),
        }
    }
}
