//! Means of what graphs give, for parameters that the renderer has as constants alone.

use glam::{Vec2, Vec3};

use crate::graph::{Graph, Input, Place, Places, Program, UvSet};
use crate::scene::Texture;
use crate::scene::import::Import;
use crate::scene::surface::{Surface, Value};

/// Number of places whose mean it is.
const PLACES: usize = 512;

/// Cosine of the angle at which these are seen: 45 degrees.
const ASLANT: f32 = std::f32::consts::FRAC_1_SQRT_2;

impl Import {
    /// Puts the mean of its graph in place of each parameter that the renderer has as a constant: over a whole texture, and over the box
    /// around a mesh, since which mesh has the surface is not known yet.
    pub(super) fn fold(&self, surface: &mut Surface) {
        for parameter in surface.parameters_to_fold() {
            let Value { factor, node } = surface[parameter];
            if let Some(node) = node {
                let mean = mean(&surface.graph, Input::Node(node), &self.pictures.textures);
                surface[parameter] = Value::constant(factor * mean);
            }
        }
    }
}

/// Mean of what is given; what is no number counts as 0.
pub(super) fn mean(graph: &Graph, input: Input, textures: &[Texture]) -> Vec3 {
    let program = Program::new(graph, input);
    let mut sum = Vec3::ZERO;
    for number in 0..PLACES {
        let place = Somewhere { point: spread(number), textures };
        let value = program.values(Places::new(&[&place]))[0].lane(0);
        sum += Vec3::select(value.is_finite_mask(), value, Vec3::ZERO);
    }
    sum / PLACES as f32
}

/// Points that cover a cube evenly, each part of their sequence as well (M. Roberts, "The unreasonable effectiveness of quasirandom
/// sequences", 2018): multiples of powers of the root of x^4 = x + 1.
fn spread(number: usize) -> Vec3 {
    let step = |power: i32| {
        let share = (number as f64 + 0.5) * ROOT.powi(-power);
        share.fract() as f32
    };
    Vec3::new(step(1), step(2), step(3))
}

const ROOT: f64 = 1.220_744_084_605_759_5;

/// A place of no mesh in particular.
struct Somewhere<'a> {
    /// From 0 to 1: its first two are its texture coordinates.
    point: Vec3,
    textures: &'a [Texture],
}

impl Place for Somewhere<'_> {
    fn uv(&self, _: UvSet) -> Vec2 {
        self.point.truncate()
    }

    fn point(&self) -> Vec3 {
        self.point
    }

    fn generated(&self) -> Vec3 {
        self.point
    }

    fn normal(&self) -> Vec3 {
        Vec3::Z
    }

    fn model_random(&self) -> f32 {
        self.point.z
    }

    fn facing(&self) -> f32 {
        ASLANT
    }

    fn picture(&self, number: u32, at: Option<Vec2>) -> [f32; 4] {
        let Some(texture) = self.textures.get(number as usize) else { return [0.0; 4] };
        let uv = at.unwrap_or(self.uv(texture.mapping.uvs));
        let Vec3 { x, y, z } = texture.value(uv, 0);
        [x, y, z, texture.alpha_between(&texture.between(uv))]
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::graph::nodes::picture::Shown;
    use crate::scene::surface::Parameter;
    use crate::scene::texture::Mapping;

    /// A coat on a quarter of a picture is there to a quarter.
    #[test]
    fn constants_are_the_means_of_their_graphs() {
        let mut import = Import::default();
        let black = [[0, 0, 0, 255]; 12];
        let texels = black.into_iter().chain([[255; 4]; 4]).collect();
        let texture = Texture::of_bytes(PathBuf::from("a.png"), [4, 4], texels, Mapping::default());
        let map = import.pictures.place(texture);
        let mut surface = Surface::matt("m", Vec3::ONE);
        surface[Parameter::CoatWeight] = 0.8.into();
        surface.show(Parameter::CoatWeight, map, Shown::Channel(0));
        let coat = import.settle(surface).material.coat.expect("there is some");
        assert!((coat.weight - 0.2).abs() < 0.01, "{}", coat.weight);
    }
}
