//! Cells about random points: Blender's Voronoi Texture node.
//!
//! Worley, "A Cellular Texture Basis Function" (SIGGRAPH 1996), in octaves as [`fractal`](super::fractal)
//! noise is.

use std::array;

use glam::Vec3;

pub use super::voronoi_cells::VoronoiMetric;
use super::voronoi_cells::{Cells, Found, Points};
use super::{Dimensions, finite, finite_vector, mix, place_of, scaled};

/// The most octaves after the first.
const MOST_DETAIL: f32 = 15.0;

/// What is looked for at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum VoronoiFeature {
    /// The nearest point.
    F1,
    /// The second nearest point.
    F2,
    /// The nearest points, blended.
    SmoothF1,
    /// Distance to the edge of the cell; Euclidean.
    DistanceToEdge,
    /// Half the distance from the nearest point to the point nearest to that; Euclidean.
    NSphereRadius,
}

/// Options of the Voronoi Texture node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Voronoi {
    /// Axes on which it depends.
    pub dimensions: Dimensions,
    /// What is looked for.
    pub feature: VoronoiFeature,
    /// How far apart two points are.
    pub metric: VoronoiMetric,
    /// Whether distance and colour are divided by the largest that is possible.
    pub is_normalized: bool,
}

/// Inputs of the Voronoi Texture node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoronoiInputs {
    /// Multiplies the place: the number of cells in a unit.
    pub scale: f32,
    /// Octaves after the first, 0 to 15 (clamped). A fraction adds a share of the next.
    pub detail: f32,
    /// Amplitude of an octave as a share of that of the one before; 0 to 1 (clamped). 0 is no detail.
    pub roughness: f32,
    /// Frequency of an octave as a multiple of that of the one before.
    pub lacunarity: f32,
    /// How far points are blended, 0 to 1 (clamped); of [`VoronoiFeature::SmoothF1`].
    pub smoothness: f32,
    /// Exponent of [`VoronoiMetric::Minkowski`].
    pub exponent: f32,
    /// 0 where points lie on a lattice, 1 where they may lie all over their cells (clamped).
    pub randomness: f32,
}

impl Default for VoronoiInputs {
    /// Those of a new node.
    fn default() -> Self {
        Self {
            scale: 5.0,
            detail: 0.0,
            roughness: 0.5,
            lacunarity: 2.0,
            smoothness: 1.0,
            exponent: 0.5,
            randomness: 1.0,
        }
    }
}

/// Outputs of the Voronoi Texture node. Those that the feature or the dimensions lack are 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VoronoiOutput {
    /// Distance to the point or the edge, in cells.
    pub distance: f32,
    /// Random colour of the point, each part 0 to 1 if there is no detail.
    pub color: Vec3,
    /// The point, in the space of the place.
    pub position: Vec3,
    /// Its fourth axis.
    pub w: f32,
    /// See [`VoronoiFeature::NSphereRadius`], in cells.
    pub radius: f32,
}

impl Voronoi {
    /// The output Distance, or Radius where that is what is looked for.
    pub fn value(&self, vector: Vec3, w: f32, inputs: &VoronoiInputs) -> f32 {
        let outputs = self.outputs(vector, w, inputs);
        if self.feature == VoronoiFeature::NSphereRadius { outputs.radius } else { outputs.distance }
    }

    /// The output Color.
    pub fn color(&self, vector: Vec3, w: f32, inputs: &VoronoiInputs) -> Vec3 {
        self.outputs(vector, w, inputs).color
    }

    /// All outputs.
    pub fn outputs(&self, vector: Vec3, w: f32, inputs: &VoronoiInputs) -> VoronoiOutput {
        let outputs = match self.dimensions {
            Dimensions::One => self.outputs_at::<1>(place_of(vector, w), inputs),
            Dimensions::Two => self.outputs_at::<2>(place_of(vector, w), inputs),
            Dimensions::Three => self.outputs_at::<3>(place_of(vector, w), inputs),
            Dimensions::Four => self.outputs_at::<4>(place_of(vector, w), inputs),
        };
        VoronoiOutput {
            distance: finite(outputs.distance),
            color: finite_vector(outputs.color),
            position: finite_vector(outputs.position),
            w: finite(outputs.w),
            radius: finite(outputs.radius),
        }
    }

    fn outputs_at<const N: usize>(&self, place: [f32; N], inputs: &VoronoiInputs) -> VoronoiOutput {
        let points = Points {
            metric: self.metric,
            exponent: inputs.exponent,
            smoothness: (inputs.smoothness / 2.0).clamp(0.0, 0.5),
            randomness: inputs.randomness.clamp(0.0, 1.0),
        };
        let place = scaled(place, inputs.scale);
        match self.feature {
            VoronoiFeature::NSphereRadius => {
                VoronoiOutput { radius: Cells::new(points, place).radius(), ..VoronoiOutput::default() }
            }
            VoronoiFeature::DistanceToEdge => {
                let distance = self.edge_distance(points, place, &Octaves::new(inputs));
                VoronoiOutput { distance, ..VoronoiOutput::default() }
            }
            _ => {
                let found = self.found(points, place, &Octaves::new(inputs));
                let unscaled = |value| if inputs.scale == 0.0 { 0.0 } else { value / inputs.scale };
                let position = found.position.map(unscaled);
                let axis = |index: usize| position.get(index).copied().unwrap_or(0.0);
                let (position, w) = if N == 1 {
                    (Vec3::ZERO, axis(0))
                } else {
                    (Vec3::new(axis(0), axis(1), axis(2)), axis(3))
                };
                VoronoiOutput { distance: found.distance, color: found.color, position, w, radius: 0.0 }
            }
        }
    }

    /// The sum of the octaves of a feature that finds a point; of the positions, a mean.
    fn found<const N: usize>(&self, points: Points, place: [f32; N], octaves: &Octaves) -> Found<N> {
        let mut sum = Found { distance: 0.0, color: Vec3::ZERO, position: [0.0; N] };
        let mut most = 0.0;
        octaves.each(|frequency, amplitude| {
            let cells = Cells::new(points, scaled(place, frequency));
            let octave = match self.feature {
                VoronoiFeature::F2 => cells.second(),
                VoronoiFeature::SmoothF1 if points.smoothness != 0.0 => cells.smooth_first(),
                _ => cells.first(),
            };
            most += amplitude;
            sum.distance += octave.distance * amplitude;
            sum.color += octave.color * amplitude;
            let position = octave.position.map(|value| value / frequency);
            sum.position = array::from_fn(|axis| mix(sum.position[axis], position[axis], amplitude));
        });
        if self.is_normalized {
            let half = 0.5 + 0.5 * points.randomness;
            let farthest =
                points.length([half; N]) * if self.feature == VoronoiFeature::F2 { 2.0 } else { 1.0 };
            sum.distance /= most * farthest;
            sum.color /= most;
        }
        sum
    }

    /// Distance to the nearest edge of all octaves, where the smaller ones count less.
    fn edge_distance<const N: usize>(&self, points: Points, place: [f32; N], octaves: &Octaves) -> f32 {
        /// Farther than any edge.
        const FAR: f32 = 8.0;
        let farthest = 0.5 + 0.5 * points.randomness;
        let (mut least, mut most) = (FAR, farthest);
        octaves.each(|frequency, amplitude| {
            let distance = Cells::new(points, scaled(place, frequency)).edge_distance() / frequency;
            least = mix(least, least.min(distance), amplitude);
            most = mix(most, farthest / frequency, amplitude);
        });
        if self.is_normalized { least / most } else { least }
    }
}

/// The octaves of a Voronoi texture.
struct Octaves {
    detail: f32,
    roughness: f32,
    lacunarity: f32,
}

impl Octaves {
    fn new(inputs: &VoronoiInputs) -> Self {
        let roughness = inputs.roughness.clamp(0.0, 1.0);
        let detail = if roughness == 0.0 { 0.0 } else { inputs.detail.clamp(0.0, MOST_DETAIL) };
        Self { detail, roughness, lacunarity: inputs.lacunarity }
    }

    /// Visits all octaves with their frequencies and amplitudes, both from 1. The last has a share of its
    /// amplitude if the detail has a fraction.
    fn each(&self, mut visit: impl FnMut(f32, f32)) {
        let (mut frequency, mut amplitude) = (1.0, 1.0);
        for octave in 0..=self.detail.ceil() as u32 {
            let is_full = octave as f32 <= self.detail;
            let share = if is_full { 1.0 } else { self.detail - self.detail.floor() };
            visit(frequency, amplitude * share);
            frequency *= self.lacunarity;
            amplitude *= self.roughness;
        }
    }
}
