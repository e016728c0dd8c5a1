//! Pictures in hexagonal tiles, each turned, scaled and moved at random: Mikkelsen, "Practical Real-Time Hex-Tiling" (JCGT 2022), as
//! MaterialX's `hextiledimage` has it.

use std::sync::Arc;

use glam::{IVec2, Vec2, Vec3};

use crate::graph::{Function, Graph, Input, Place, Places};
use crate::lanes::Vec3x8;

/// Tiles in a unit of texture coordinates, along the first axis of their grid.
const DENSITY: f32 = 3.464_101_6;

/// Exponent of the weights of tiles: the larger, the narrower are their borders.
const SHARPNESS: i32 = 7;

/// Added to the places of tiles before they are hashed: without it some hashes are 0.
const SEED: f32 = 0.12345;

/// Inputs of the function beside the place: shares and ranges of the angle in degrees, the scale and the offset; the falloff, its
/// contrast, and the coefficients of luminance.
pub const INPUTS: [(&str, Vec3); 9] = [
    ("rotation", Vec3::ONE),
    ("rotationrange", Vec3::new(0.0, 360.0, 0.0)),
    ("scale", Vec3::ONE),
    ("scalerange", Vec3::new(0.5, 2.0, 0.0)),
    ("offset", Vec3::ONE),
    ("offsetrange", Vec3::new(0.0, 1.0, 0.0)),
    ("falloff", Vec3::splat(0.5)),
    ("falloffcontrast", Vec3::splat(0.5)),
    ("lumacoeffs", Vec3::new(0.272_228_7, 0.674_081_8, 0.053_689_5)),
];

/// Adds picture number `number` of the shot in tiles, `at` a vector; `inputs` are [`INPUTS`].
pub fn add(graph: &mut Graph, number: u32, at: Input, inputs: [Input; INPUTS.len()]) -> Input {
    graph.add(Arc::new(HexTiles { number }), std::iter::once(at).chain(inputs).collect())
}

#[derive(Debug)]
struct HexTiles {
    number: u32,
}

impl Function for HexTiles {
    fn is_of_place(&self) -> bool {
        true
    }

    fn values(&self, inputs: &[Vec3x8], places: Places) -> Vec3x8 {
        places.lane_by_lane(inputs, |inputs, place| self.value(inputs, place))
    }
}

impl HexTiles {
    fn value(&self, inputs: &[Vec3], place: &dyn Place) -> Vec3 {
        let (falloff, contrast, luminance) = (inputs[7].x, inputs[8].x, inputs[9]);
        let tiles = tiles_at(inputs[0].truncate());
        let colors = tiles.map(|(tile, _)| {
            let at = in_tile(tile, inputs);
            let [r, g, b, _] = place.picture(self.number, Some(at));
            Vec3::new(r, g, b)
        });
        let weight = |which: usize| {
            let bright = 1.0 + (colors[which].dot(luminance) - 1.0) * contrast;
            bright * tiles[which].1.powi(SHARPNESS)
        };
        let mut weights = normalized([weight(0), weight(1), weight(2)]);
        if falloff != 0.5 {
            weights = normalized(weights.map(|weight| gain(weight, falloff)));
        }
        colors.iter().zip(weights).map(|(color, weight)| *color * weight).sum()
    }
}

/// The three tiles around a place, by their places in the grid, and their weights.
fn tiles_at(place: Vec2) -> [(IVec2, f32); 3] {
    let at = place * DENSITY;
    let skewed = Vec2::new(at.x - at.y / 3.0_f32.sqrt(), at.y * 2.0 / 3.0_f32.sqrt());
    let (cell, within) = (skewed.floor().as_ivec2(), skewed - skewed.floor());
    // far away there is no next one
    let [right, up, both] = [IVec2::X, IVec2::Y, IVec2::ONE].map(|step| cell.wrapping_add(step));
    let third = 1.0 - within.x - within.y;
    if third > 0.0 {
        return [(cell, third), (up, within.y), (right, within.x)];
    }
    [(both, -third), (right, 1.0 - within.y), (up, 1.0 - within.x)]
}

/// Where a tile has the picture at the place that a function is asked for.
fn in_tile(tile: IVec2, inputs: &[Vec3]) -> Vec2 {
    let [at, rotation, angles, scale, scales, offset, offsets, ..] = inputs else { return Vec2::ZERO };
    let random = hash(tile.as_vec2() + SEED);
    let of = |range: &Vec3, share: f32| range.x + (range.y - range.x) * share;
    let centre =
        Vec2::new(tile.x as f32 + 0.5 * tile.y as f32, tile.y as f32 * 3.0_f32.sqrt() * 0.5) / DENSITY;
    let turn = Vec2::from_angle(of(angles, random.x * rotation.x).to_radians());
    let size = 1.0 + (of(scales, random.y) - 1.0) * scale.x;
    let moved = Vec2::new(of(offsets, random.x * offset.x), of(offsets, random.y * offset.x));
    turn.rotate(at.truncate() - centre) / size + centre + moved
}

/// Two numbers from 0 to 1: the hash of Hoskins, "Hash without Sine" (2014), with the constants of MaterialX.
fn hash(place: Vec2) -> Vec2 {
    let three = (Vec3::new(place.x, place.y, place.x) * Vec3::new(0.1031, 0.1030, 0.0973)).fract_gl();
    let three = three + three.dot(Vec3::new(three.y, three.z, three.x) + 33.33);
    ((Vec2::splat(three.x) + Vec2::new(three.y, three.z)) * Vec2::new(three.z, three.y)).fract_gl()
}

/// Schlick's gain, "Fast Alternatives to Perlin's Bias and Gain Functions" (1994).
fn gain(value: f32, by: f32) -> f32 {
    let slope = (1.0 / by.clamp(0.001, 0.999) - 2.0) * (1.0 - 2.0 * value);
    if value < 0.5 { value / (slope + 1.0) } else { (slope - value) / (slope - 1.0) }
}

/// Weights whose sum is 1; the first alone where they have none.
fn normalized(weights: [f32; 3]) -> [f32; 3] {
    let sum: f32 = weights.iter().sum();
    if sum > 0.0 { weights.map(|weight| weight / sum) } else { [1.0, 0.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At the centre of a tile it alone counts, and everywhere the weights are shares of the whole.
    #[test]
    fn weights_of_tiles_are_shares() {
        for (x, y) in [(0.1, 0.2), (-3.7, 1.9), (0.5, -0.25), (12.3, 7.7)] {
            let tiles = tiles_at(Vec2::new(x, y));
            let sum: f32 = tiles.iter().map(|(_, weight)| weight).sum();
            assert!(
                (sum - 1.0).abs() < 1e-4 && tiles.iter().all(|(_, weight)| *weight >= -1e-4),
                "{tiles:?}"
            );
        }
        let centre = Vec2::new(2.0 + 0.5 * 3.0, 3.0 * 3.0_f32.sqrt() * 0.5) / DENSITY;
        let tiles = tiles_at(centre + 1e-5);
        assert!(tiles.iter().any(|(tile, weight)| *tile == IVec2::new(2, 3) && *weight > 0.99), "{tiles:?}");
    }

    /// What is not to be random shows the picture as it is.
    #[test]
    fn tiles_that_are_not_random_are_the_picture() {
        let at = Vec2::new(0.3, 0.6);
        let mut inputs = [Vec3::ZERO; 10];
        inputs[0] = at.extend(0.0);
        let found = in_tile(IVec2::new(1, -2), &inputs);
        assert!(found.distance(at) < 1e-5, "{found}");
    }

    #[test]
    fn gain_keeps_the_middle_and_the_ends() {
        for by in [0.1, 0.5, 0.8] {
            assert!([0.0, 0.5, 1.0].into_iter().all(|value| (gain(value, by) - value).abs() < 1e-5), "{by}");
        }
        assert!(gain(0.25, 0.2) != gain(0.25, 0.8));
    }
}
