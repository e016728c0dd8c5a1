//! Noise of MaterialX's standard library, as Open Shading Language has it.

use std::array;

use wide::u32x8;

use crate::lanes::{F32x8, Mask, Vec3x8, unsigned};
use crate::pattern::hash::jenkins8;
use crate::pattern::perlin::{signed, signed3};

/// Octaves of a fractal, at most: those beyond are finer than floats.
const MOST_OCTAVES: f32 = 24.0;

/// Place of the second number of a fractal beside that of the first.
const ASIDE: [f32; 3] = [19.0, 193.0, 17.0];

/// Distances above that of any point of the cells around a place.
const FAR: f32 = 1e6;

/// Perlin noise of the first `lanes` places, about -1 to 1: one number, or as many as there are channels.
pub fn perlin<const N: usize>(place: [F32x8; N], channels: usize, lanes: usize) -> Vec3x8 {
    if channels == 1 { Vec3x8::all_of(signed(place, lanes)) } else { signed3(place, lanes) }
}

/// Octaves of a fractal.
#[derive(Debug, Clone, Copy)]
pub struct Octaves {
    pub count: F32x8,
    /// Factor on the frequency from one to the next.
    pub lacunarity: F32x8,
    /// Factor on the amplitude.
    pub diminish: F32x8,
}

impl Octaves {
    /// Sum of octaves of Perlin noise of the first `lanes` places: one number, or as many as there are channels.
    pub fn noise<const N: usize>(self, place: [F32x8; N], channels: usize, lanes: usize) -> Vec3x8 {
        if channels != 2 {
            return self.sum(place, channels, lanes);
        }
        let aside: [F32x8; N] = array::from_fn(|axis| place[axis] + ASIDE[axis]);
        [self.sum(place, 1, lanes).x, self.sum(aside, 1, lanes).x, F32x8::ZERO].into()
    }

    fn sum<const N: usize>(self, mut place: [F32x8; N], channels: usize, lanes: usize) -> Vec3x8 {
        let count = self.count.clamp(0.0, MOST_OCTAVES).floor();
        let most = count.values()[..lanes].iter().copied().fold(0.0, f32::max);
        let (mut sum, mut amplitude) = (Vec3x8::ZERO, F32x8::ONE);
        for octave in 0..most as u32 {
            let counts = F32x8::splat(octave as f32).lt(count);
            sum = counts.select3(sum + perlin(place, channels, lanes) * amplitude, sum);
            amplitude = amplitude * self.diminish;
            place = place.map(|axis| axis * self.lacunarity);
        }
        sum
    }
}

/// A number from 0 to 1 for each whole place.
pub fn cell<const N: usize>(place: [F32x8; N]) -> F32x8 {
    share(jenkins8(whole(place)))
}

/// Three numbers from 0 to 1 for each whole place, of two or three axes.
#[inline(always)]
fn cell3<const N: usize>(place: [F32x8; N]) -> Vec3x8 {
    let of = |number: u32| match whole(place)[..] {
        [x, y] => share(jenkins8([x, y, u32x8::splat(number)])),
        [x, y, z] => share(jenkins8([x, y, z, u32x8::splat(number)])),
        _ => F32x8::ZERO,
    };
    [of(0), of(1), of(2)].into()
}

#[inline(always)]
fn whole<const N: usize>(place: [F32x8; N]) -> [u32x8; N] {
    place.map(|axis| unsigned(axis.floor().to_whole()))
}

#[inline(always)]
fn share(hash: u32x8) -> F32x8 {
    F32x8::from_unsigned(hash) / u32::MAX as f32
}

/// Worley noise of two or three axes. Each cell has a point, `jitter` away from its middle: 0 not at all, 1 anywhere in the cell. The
/// distance of the nearest point, or of as many as there are channels; where it `is_solid`, numbers from 0 to 1 of the nearest point's
/// cell.
pub fn worley<const N: usize>(place: [F32x8; N], jitter: F32x8, is_solid: Mask, channels: usize) -> Vec3x8 {
    let floor = place.map(F32x8::floor);
    let (mut nearest, mut nearest_point) = ([F32x8::splat(FAR); 3], [F32x8::ZERO; N]);
    for number in 0..3_usize.pow(N as u32) {
        let step: [f32; N] =
            array::from_fn(|axis| (number / 3_usize.pow((N - 1 - axis) as u32) % 3) as f32 - 1.0);
        let random: [F32x8; 3] = cell3::<N>(array::from_fn(|axis| floor[axis] + step[axis])).into();
        // from the place to the point
        let way: [F32x8; N] = array::from_fn(|axis| {
            (random[axis] - 0.5) * jitter + step[axis] + 0.5 - (place[axis] - floor[axis])
        });
        let distance = way.into_iter().fold(F32x8::ZERO, |sum, axis| sum + axis * axis);
        let is_nearest = distance.lt(nearest[0]);
        nearest_point =
            array::from_fn(|axis| is_nearest.select(place[axis] + way[axis], nearest_point[axis]));
        // in its place among them
        let [first, second, third] = nearest;
        nearest = [first.min(distance), first.max(second.min(distance)), second.max(third.min(distance))];
    }
    let (solid, distances) = match channels {
        1 => (Vec3x8::all_of(cell(nearest_point)), Vec3x8::all_of(nearest[0].sqrt())),
        _ => (cell3(nearest_point), nearest.map(F32x8::sqrt).into()),
    };
    is_solid.select3(solid, distances)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::lanes::LANES;

    fn all<const N: usize>(place: [f32; N]) -> [F32x8; N] {
        place.map(F32x8::splat)
    }

    fn perlin_of(place: [f32; 3], channels: usize) -> Vec3 {
        perlin(all(place), channels, LANES).lane(0)
    }

    /// Numbers of the first channel are not those of a single number: they come of other bits.
    #[test]
    fn channels_of_noise_differ() {
        let place = [0.3, 1.7, -2.2];
        let Vec3 { x, y, z } = perlin_of(place, 3);
        assert!(x != y && y != z && x != z, "{x} {y} {z}");
        assert!(perlin_of([3.0, -7.0, 2.0], 3).abs().max_element() < 1e-6, "0 on whole numbers");
        let [count, lacunarity, diminish] = all([1.0, 2.0, 0.5]);
        let of_octaves = |place, channels| {
            Octaves { count, lacunarity, diminish }.noise(all(place), channels, LANES).lane(0)
        };
        assert_eq!(of_octaves(place, 3), perlin_of(place, 3));
        let [first, second] = [place, [19.3, 194.7, 14.8]].map(|place| of_octaves(place, 1).x);
        assert!(of_octaves(place, 2).abs_diff_eq(Vec3::new(first, second, 0.0), 1e-4));
    }

    fn worley_of<const N: usize>(place: [f32; N], jitter: f32, is_solid: bool, channels: usize) -> Vec3 {
        let is_solid = if is_solid { Mask::ALL } else { Mask::NONE };
        worley(all(place), F32x8::splat(jitter), is_solid, channels).lane(0)
    }

    /// Without jitter points are in the middle of cells.
    #[test]
    fn nearest_points_are_those_of_the_grid() {
        let of = |place: [f32; 2], channels| worley_of(place, 0.0, false, channels);
        assert_eq!(of([4.5, -2.5], 1), Vec3::ZERO);
        assert!((of([4.75, -2.5], 1).x - 0.25).abs() < 1e-6);
        assert!(of([4.75, -2.5], 3).abs_diff_eq(Vec3::new(0.25, 0.75, 1.0625_f32.sqrt()), 1e-6));
        assert!((worley_of([0.5, 0.5, 0.75], 0.0, false, 1).x - 0.25).abs() < 1e-6);
    }

    /// What is solid changes where another point is nearest, and has the number of that point's cell.
    #[test]
    fn solid_cells_have_the_number_of_their_point() {
        let cell_of = |place: [f32; 2]| Vec3::splat(cell(all(place)).lane(0));
        assert_eq!(worley_of([4.75, -2.5], 0.0, true, 1), cell_of([4.0, -3.0]));
        assert_eq!(worley_of([4.75, -2.5], 0.0, true, 3), cell3(all([4.0, -3.0])).lane(0));
        let jittered = worley_of([4.75, -2.5], 1.0, true, 1);
        let around = (-1..=1).flat_map(|x| (-1..=1).map(move |y| cell_of([4.0 + x as f32, -3.0 + y as f32])));
        assert!(around.into_iter().any(|number| number == jittered), "one of those around it");
    }
}
