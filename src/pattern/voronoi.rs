//! Cells about random points: Blender's Voronoi Texture node.
//!
//! Worley, "A Cellular Texture Basis Function" (SIGGRAPH 1996), in octaves as [`fractal`](super::fractal)
//! noise is.

use std::array;

pub use super::voronoi_cells::VoronoiMetric;
use super::voronoi_cells::{Cells, Found, Points};
use super::{Dimensions, finite_vectors, finite8, mix, place_of, scaled};
use crate::lanes::{F32x8, Mask, Vec3x8};

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
    pub scale: F32x8,
    /// Octaves after the first, 0 to 15 (clamped). A fraction adds a share of the next.
    pub detail: F32x8,
    /// Amplitude of an octave as a share of that of the one before; 0 to 1 (clamped). 0 is no detail.
    pub roughness: F32x8,
    /// Frequency of an octave as a multiple of that of the one before.
    pub lacunarity: F32x8,
    /// How far points are blended, 0 to 1 (clamped); of [`VoronoiFeature::SmoothF1`].
    pub smoothness: F32x8,
    /// Exponent of [`VoronoiMetric::Minkowski`].
    pub exponent: F32x8,
    /// 0 where points lie on a lattice, 1 where they may lie all over their cells (clamped).
    pub randomness: F32x8,
}

impl Default for VoronoiInputs {
    /// Those of a new node.
    fn default() -> Self {
        Self {
            scale: F32x8::splat(5.0),
            detail: F32x8::splat(0.0),
            roughness: F32x8::splat(0.5),
            lacunarity: F32x8::splat(2.0),
            smoothness: F32x8::splat(1.0),
            exponent: F32x8::splat(0.5),
            randomness: F32x8::splat(1.0),
        }
    }
}

/// Outputs of the Voronoi Texture node. Those that the feature or the dimensions lack are 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoronoiOutput {
    /// Distance to the point or the edge, in cells.
    pub distance: F32x8,
    /// Random colour of the point, each part 0 to 1 if there is no detail.
    pub color: Vec3x8,
    /// The point, in the space of the place.
    pub position: Vec3x8,
    /// Its fourth axis.
    pub w: F32x8,
    /// See [`VoronoiFeature::NSphereRadius`], in cells.
    pub radius: F32x8,
}

impl VoronoiOutput {
    const ZERO: Self = Self {
        distance: F32x8::ZERO,
        color: Vec3x8::ZERO,
        position: Vec3x8::ZERO,
        w: F32x8::ZERO,
        radius: F32x8::ZERO,
    };
}

impl Voronoi {
    /// The output Distance, or Radius where that is what is looked for, at the first `lanes` places.
    pub fn value(&self, vector: Vec3x8, w: F32x8, inputs: &VoronoiInputs, lanes: usize) -> F32x8 {
        let outputs = self.outputs(vector, w, inputs, lanes);
        if self.feature == VoronoiFeature::NSphereRadius { outputs.radius } else { outputs.distance }
    }

    /// All outputs at the first `lanes` places.
    pub fn outputs(&self, vector: Vec3x8, w: F32x8, inputs: &VoronoiInputs, lanes: usize) -> VoronoiOutput {
        let outputs = match self.dimensions {
            Dimensions::One => self.outputs_at::<1>(place_of(vector, w), inputs, lanes),
            Dimensions::Two => self.outputs_at::<2>(place_of(vector, w), inputs, lanes),
            Dimensions::Three => self.outputs_at::<3>(place_of(vector, w), inputs, lanes),
            Dimensions::Four => self.outputs_at::<4>(place_of(vector, w), inputs, lanes),
        };
        VoronoiOutput {
            distance: finite8(outputs.distance),
            color: finite_vectors(outputs.color),
            position: finite_vectors(outputs.position),
            w: finite8(outputs.w),
            radius: finite8(outputs.radius),
        }
    }

    #[inline(never)]
    fn outputs_at<const N: usize>(
        &self,
        place: [F32x8; N],
        inputs: &VoronoiInputs,
        lanes: usize,
    ) -> VoronoiOutput {
        let points = Points {
            metric: self.metric,
            exponent: inputs.exponent,
            smoothness: (inputs.smoothness / 2.0).clamp(0.0, 0.5),
            randomness: inputs.randomness.clamp(0.0, 1.0),
        };
        let place = scaled(place, inputs.scale);
        match self.feature {
            VoronoiFeature::NSphereRadius => {
                VoronoiOutput { radius: Cells::new(points, place, lanes).radius(), ..VoronoiOutput::ZERO }
            }
            VoronoiFeature::DistanceToEdge => {
                let distance = self.edge_distance(points, place, &Octaves::new(inputs, lanes));
                VoronoiOutput { distance, ..VoronoiOutput::ZERO }
            }
            _ => {
                let found = self.found(points, place, &Octaves::new(inputs, lanes));
                let is_flat = inputs.scale.is_zero();
                let position = found.position.map(|value| is_flat.select(F32x8::ZERO, value / inputs.scale));
                let axis = |index: usize| position.get(index).copied().unwrap_or(F32x8::ZERO);
                let (position, w) = if N == 1 {
                    (Vec3x8::ZERO, axis(0))
                } else {
                    (Vec3x8::from([axis(0), axis(1), axis(2)]), axis(3))
                };
                VoronoiOutput {
                    distance: found.distance,
                    color: found.color,
                    position,
                    w,
                    radius: F32x8::ZERO,
                }
            }
        }
    }

    /// The sum of the octaves of a feature that finds a point; of the positions, a mean.
    fn found<const N: usize>(&self, points: Points, place: [F32x8; N], octaves: &Octaves) -> Found<N> {
        let mut sum = Found { distance: F32x8::ZERO, color: Vec3x8::ZERO, position: [F32x8::ZERO; N] };
        let mut most = F32x8::ZERO;
        octaves.each(|frequency, amplitude, counts| {
            let cells = Cells::new(points, scaled(place, frequency), octaves.lanes);
            let octave = self.feature_of(&cells, octaves.lanes);
            let position = octave.position.map(|value| value / frequency);
            let next = Found {
                distance: sum.distance + octave.distance * amplitude,
                color: sum.color + octave.color * amplitude,
                position: array::from_fn(|axis| mix(sum.position[axis], position[axis], amplitude)),
            };
            sum = next.where_or(counts, sum);
            most = counts.select(most + amplitude, most);
        });
        if self.is_normalized {
            let half = points.randomness * 0.5 + 0.5;
            let factor = if self.feature == VoronoiFeature::F2 { 2.0 } else { 1.0 };
            sum.distance = sum.distance / (most * (points.length([half; N]) * factor));
            sum.color = sum.color / most;
        }
        sum
    }

    /// What is found in an octave.
    fn feature_of<const N: usize>(&self, cells: &Cells<N>, lanes: usize) -> Found<N> {
        match self.feature {
            VoronoiFeature::F2 => cells.second(),
            VoronoiFeature::SmoothF1 => {
                let is_sharp = cells.points.smoothness.is_zero();
                match (is_sharp.any_of(lanes), (!is_sharp).any_of(lanes)) {
                    (false, _) => cells.smooth_first(),
                    (true, false) => cells.first(),
                    (true, true) => cells.first().where_or(is_sharp, cells.smooth_first()),
                }
            }
            _ => cells.first(),
        }
    }

    /// Distance to the nearest edge of all octaves, where the smaller ones count less.
    fn edge_distance<const N: usize>(&self, points: Points, place: [F32x8; N], octaves: &Octaves) -> F32x8 {
        /// Farther than any edge.
        const FAR: f32 = 8.0;
        let farthest = points.randomness * 0.5 + 0.5;
        let (mut least, mut most) = (F32x8::splat(FAR), farthest);
        octaves.each(|frequency, amplitude, counts| {
            let cells = Cells::new(points, scaled(place, frequency), octaves.lanes);
            let distance = cells.edge_distance() / frequency;
            least = counts.select(mix(least, distance.min(least), amplitude), least);
            most = counts.select(mix(most, farthest / frequency, amplitude), most);
        });
        if self.is_normalized { least / most } else { least }
    }
}

/// The octaves of a Voronoi texture.
struct Octaves {
    detail: F32x8,
    roughness: F32x8,
    lacunarity: F32x8,
    /// Number of places that count.
    lanes: usize,
}

impl Octaves {
    fn new(inputs: &VoronoiInputs, lanes: usize) -> Self {
        let roughness = inputs.roughness.clamp(0.0, 1.0);
        let detail = roughness.is_zero().select(F32x8::ZERO, inputs.detail.clamp(0.0, MOST_DETAIL));
        Self { detail, roughness, lacunarity: inputs.lacunarity, lanes }
    }

    /// Visits all octaves with their frequencies and amplitudes, both from 1, and where they count. The last has a share of its
    /// amplitude if the detail has a fraction.
    fn each(&self, mut visit: impl FnMut(F32x8, F32x8, Mask)) {
        let (mut frequency, mut amplitude) = (F32x8::ONE, F32x8::ONE);
        let share = self.detail - self.detail.floor();
        let last = self.detail.ceil();
        let most = last.values()[..self.lanes].iter().copied().fold(0.0, f32::max);
        for octave in 0..=most as u32 {
            let octave = F32x8::splat(octave as f32);
            let part = octave.le(self.detail).select(amplitude, amplitude * share);
            visit(frequency, part, octave.le(last));
            frequency = frequency * self.lacunarity;
            amplitude = amplitude * self.roughness;
        }
    }
}
