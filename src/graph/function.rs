//! Functions of nodes, and what they may ask of a place.

use std::fmt::{self, Debug};
use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::functions::color::luma;

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
    /// A value of this kind where one of another kind is taken, as Blender's links convert it: of a colour its luminance is the number,
    /// of a vector the mean.
    pub fn converted(self, to: Self, value: Vec3) -> Vec3 {
        match (self, to) {
            (Self::Color, Self::Number) => Vec3::splat(luma(value)),
            (Self::Vector, Self::Number) => Vec3::splat(value.element_sum() / 3.0),
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
    /// [`Mesh::uvs`](crate::scene::Mesh::uvs).
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
    fn world_point(&self) -> Vec3;
    /// Normal of the surface there, of unit length, on the outside.
    fn world_normal(&self) -> Vec3;
    /// Normal of the surface, object space, of unit length, on the outside.
    fn normal(&self) -> Vec3;
    /// Origin of the model's object space in the world of the shot's files, as it is at first; zero where that is not known.
    fn model_place(&self) -> Vec3;
    /// Number of the model from 0 to 1, by which copies may differ.
    fn model_random(&self) -> f32;
    /// Colour of the vertices, linear RGB; white where they have none.
    fn vertex_color(&self) -> Vec3;
    /// Linear RGB, or numbers, and alpha of the picture with this number of the shot. Without `at` at the texture coordinates that the picture
    /// takes, filtered over the place; else there, v upwards, and not filtered.
    fn picture(&self, number: u32, at: Option<Vec2>) -> [f32; 4];
}

/// Function of a node's output. What it prints by [`Debug`] tells it from all others.
pub trait Function: Debug + Send + Sync {
    /// Returns true if it depends on the place beside its inputs.
    fn is_of_place(&self) -> bool {
        false
    }

    /// Returns true if it filters over the place, so that it is another value where the place is seen from elsewhere.
    fn is_filtered(&self) -> bool {
        false
    }

    /// Value of the output. `inputs`: one for each [`Socket`](super::Socket), of its kind, all finite. What is not finite in the value
    /// is replaced by 0.
    fn value(&self, inputs: &[Vec3], place: &dyn Place) -> Vec3;
}

/// A function of inputs alone. `name` tells it from all others: it has all options that decide a value.
pub fn function(name: String, of: impl Fn(&[Vec3]) -> Vec3 + Send + Sync + 'static) -> Arc<dyn Function> {
    Arc::new(OfInputs { name, of })
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

impl<F: Fn(&[Vec3]) -> Vec3 + Send + Sync> Function for OfInputs<F> {
    fn value(&self, inputs: &[Vec3], _: &dyn Place) -> Vec3 {
        (self.of)(inputs)
    }
}

/// A place of which nothing is known: where constants are computed.
#[derive(Debug)]
pub(super) struct Nowhere;

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

    fn world_point(&self) -> Vec3 {
        Vec3::ZERO
    }

    fn world_normal(&self) -> Vec3 {
        Vec3::Z
    }

    fn normal(&self) -> Vec3 {
        Vec3::Z
    }

    fn model_place(&self) -> Vec3 {
        Vec3::ZERO
    }

    fn model_random(&self) -> f32 {
        0.0
    }

    fn vertex_color(&self) -> Vec3 {
        Vec3::ONE
    }

    fn picture(&self, _: u32, _: Option<Vec2>) -> [f32; 4] {
        [0.0; 4]
    }
}

/// A value without what is not finite in it.
#[inline]
pub(super) fn finite(value: Vec3) -> Vec3 {
    let finite = |number: f32| if number.is_finite() { number } else { 0.0 };
    Vec3::new(finite(value.x), finite(value.y), finite(value.z))
}
