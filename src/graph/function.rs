//! Functions of nodes, and what they may ask of a place.

use std::fmt::{self, Debug};
use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::functions::color::luma;
use crate::lanes::{LANES, Vec3x8};

/// Kind of a value. All are three floats: a number is the same three times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// One number.
    Number,
    /// A vector, or a point.
    Vector,
    /// A colour, linear RGB.
    Color,
}

impl Kind {
    /// Values of this kind where those of another kind are taken, as Blender's links convert them: of a colour its luminance is the
    /// number, of a vector the mean.
    pub fn converted(self, to: Self, value: Vec3x8) -> Vec3x8 {
        match (self, to) {
            (Self::Color, Self::Number) => Vec3x8::all_of(luma(value)),
            (Self::Vector, Self::Number) => Vec3x8::all_of((value.x + value.y + value.z) / 3.0),
            _ => value,
        }
    }

    /// Returns true if values change where they are taken as another kind.
    pub fn changes(self, to: Self) -> bool {
        self != Self::Number && to == Self::Number
    }
}

/// Set of texture coordinates of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum UvSet {
    /// [`Triangles::uvs`](crate::scene::Triangles::uvs).
    #[default]
    First,
    /// [`Details::second_uvs`](crate::scene::details::Details::second_uvs).
    Second,
}

/// A place of a surface, as functions see it.
pub trait Place {
    /// Texture coordinates, v upwards; zero where there are none.
    fn uv(&self, set: UvSet) -> Vec2;
    /// The place in object space, of a mesh that deforms in its shape at rest.
    fn point(&self) -> Vec3;
    /// The place in the box around the mesh: from 0 to 1 along each axis.
    fn generated(&self) -> Vec3;
    /// The place in the world of the shot's files, of a model that moves as it is at first; in object space where that is not known.
    fn world_point(&self) -> Vec3 {
        self.point()
    }
    /// Normal of the surface there, of unit length, on the outside.
    fn world_normal(&self) -> Vec3 {
        self.normal()
    }
    /// Normal of the surface, object space, of unit length, on the outside.
    fn normal(&self) -> Vec3;
    /// Origin of the model's object space in the world of the shot's files, as it is at first; zero where that is not known.
    fn model_place(&self) -> Vec3 {
        Vec3::ZERO
    }
    /// Number of the model from 0 to 1, by which copies may differ.
    fn model_random(&self) -> f32 {
        0.0
    }
    /// Colour of the vertices, linear RGB; white where they have none.
    fn vertex_color(&self) -> Vec3 {
        Vec3::ONE
    }
    /// What the grid of this name has there, of a volume: a number is the same three times. `None` without such a grid.
    fn of_volume(&self, _grid: &str) -> Option<Vec3> {
        None
    }
    /// Cosine between the normal and the way to what sees the place, from -1 to 1: below 0 the back of the surface is seen. 1 where nothing
    /// sees it.
    fn facing(&self) -> f32 {
        1.0
    }
    /// Linear RGB, or numbers, and alpha of the picture with this number of the shot. Without `at` at the texture coordinates that the picture
    /// takes, filtered over the place; else there, v upwards, and not filtered.
    fn picture(&self, number: u32, at: Option<Vec2>) -> [f32; 4];
}

/// Places at which a program is evaluated at once: one for each lane, from the first on. There is one, at least.
#[derive(Clone, Copy)]
pub struct Places<'a>(&'a [&'a dyn Place]);

impl<'a> Places<'a> {
    /// Creates the first [`LANES`] of some places; that of which nothing is known where there is none.
    pub fn new(places: &'a [&'a dyn Place]) -> Self {
        match places {
            [] => Self::NOWHERE,
            _ => Self(&places[..places.len().min(LANES)]),
        }
    }

    /// A place of which nothing is known: where constants are computed.
    pub(super) const NOWHERE: Self = Self(&[&Nowhere]);

    /// Number of lanes that have a place.
    pub fn lanes(self) -> usize {
        self.0.len()
    }

    /// What each place gives, of the number of its lane and the place. The lanes beyond have what the first place gives: nothing is
    /// computed of what nobody has set, and what is [the same in all lanes](crate::lanes::F32x8::each) is computed once.
    pub fn each(self, mut of: impl FnMut(usize, &dyn Place) -> Vec3) -> Vec3x8 {
        let mut values = Vec3x8::splat(of(0, self.0[0]));
        for (lane, place) in self.0.iter().enumerate().skip(1) {
            values.set_lane(lane, of(lane, *place));
        }
        values
    }

    /// A value that is computed lane by lane, of the inputs and the place.
    pub fn lane_by_lane(self, inputs: &[Vec3x8], of: impl Fn(&[Vec3], &dyn Place) -> Vec3) -> Vec3x8 {
        let mut of_lane = [Vec3::ZERO; MOST_INPUTS];
        self.each(|lane, place| {
            for (one, eight) in of_lane.iter_mut().zip(inputs) {
                *one = eight.lane(lane);
            }
            of(&of_lane[..inputs.len().min(MOST_INPUTS)], place)
        })
    }
}

/// Number of inputs that functions have, at most.
const MOST_INPUTS: usize = 16;

/// Function of a node's output. What it prints by [`Debug`] tells it from all others.
pub trait Function: Debug + Send + Sync {
    /// Returns true if it depends on the place beside its inputs.
    fn is_of_place(&self) -> bool {
        false
    }

    /// Returns true if it depends on what sees the place.
    fn is_of_eye(&self) -> bool {
        false
    }

    /// Returns true if it filters over the place, so that it is another value where the place is seen from elsewhere.
    fn is_filtered(&self) -> bool {
        false
    }

    /// The function of the same inputs whose value has the value of this one as its first part, to the bit. Where both are needed, it is
    /// computed alone.
    fn whole(&self) -> Option<&Arc<dyn Function>> {
        None
    }

    /// Values of the output at up to eight places, one for each lane. `inputs`: one for each [`Socket`](super::Socket), of its kind, all
    /// finite. What is not finite in a value is replaced by 0.
    ///
    /// What a lane gives depends, to the bit, on what that lane has: it is the same whatever is in the others and wherever it is among them.
    /// Lanes without a place give anything.
    fn values(&self, inputs: &[Vec3x8], places: Places) -> Vec3x8;
}

/// A function of inputs alone, eight at a time; it is also told how many lanes count, from the first on. `name` tells it from all
/// others: it has all options that decide a value.
pub fn function(
    name: String,
    of: impl Fn(&[Vec3x8], usize) -> Vec3x8 + Send + Sync + 'static,
) -> Arc<dyn Function> {
    Arc::new(OfInputs { name, of })
}

/// A function of inputs alone that is computed for one place after the other: for what is rare.
pub fn lane_by_lane(name: String, of: impl Fn(&[Vec3]) -> Vec3 + Send + Sync + 'static) -> Arc<dyn Function> {
    Arc::new(LaneByLane { name, of })
}

/// `function`, which gives the first part of what `whole` gives: see [`Function::whole`].
pub fn first_part(whole: Arc<dyn Function>, function: Arc<dyn Function>) -> Arc<dyn Function> {
    Arc::new(FirstPart { whole, function })
}

struct FirstPart {
    whole: Arc<dyn Function>,
    function: Arc<dyn Function>,
}

impl Debug for FirstPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.function.fmt(f)
    }
}

impl Function for FirstPart {
    fn whole(&self) -> Option<&Arc<dyn Function>> {
        Some(&self.whole)
    }

    fn values(&self, inputs: &[Vec3x8], places: Places) -> Vec3x8 {
        self.function.values(inputs, places)
    }
}

struct OfInputs<F> {
    name: String,
    of: F,
}

impl<F> Debug for OfInputs<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

impl<F: Fn(&[Vec3x8], usize) -> Vec3x8 + Send + Sync> Function for OfInputs<F> {
    fn values(&self, inputs: &[Vec3x8], places: Places) -> Vec3x8 {
        (self.of)(inputs, places.lanes())
    }
}

struct LaneByLane<F> {
    name: String,
    of: F,
}

impl<F> Debug for LaneByLane<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

impl<F: Fn(&[Vec3]) -> Vec3 + Send + Sync> Function for LaneByLane<F> {
    fn values(&self, inputs: &[Vec3x8], places: Places) -> Vec3x8 {
        places.lane_by_lane(inputs, |inputs, _| (self.of)(inputs))
    }
}

/// A place of which nothing is known.
#[derive(Debug)]
struct Nowhere;

impl Place for Nowhere {
    fn uv(&self, _: UvSet) -> Vec2 {
        Vec2::ZERO
    }

    fn point(&self) -> Vec3 {
        Vec3::ZERO
    }

    fn generated(&self) -> Vec3 {
        Vec3::ZERO
    }

    fn normal(&self) -> Vec3 {
        Vec3::Z
    }

    fn picture(&self, _: u32, _: Option<Vec2>) -> [f32; 4] {
        [0.0; 4]
    }
}
