//! Noise of MaterialX's standard library, as Open Shading Language has it.

use std::array;

use glam::Vec3;

use crate::pattern::hash::jenkins;
use crate::pattern::perlin::{signed, signed3};

/// Octaves of a fractal, at most: those beyond are finer than floats.
const MOST_OCTAVES: f32 = 24.0;

/// Place of the second number of a fractal beside that of the first.
const ASIDE: [f32; 3] = [19.0, 193.0, 17.0];

/// Distances above that of any point of the cells around a place.
const FAR: f32 = 1e6;

/// Perlin noise, about -1 to 1: one number, or as many as there are channels.
pub fn perlin<const N: usize>(place: [f32; N], channels: usize) -> Vec3 {
    if channels == 1 { Vec3::splat(signed(place)) } else { signed3(place) }
}

/// Octaves of a fractal.
#[derive(Debug, Clone, Copy)]
pub struct Octaves {
    pub count: f32,
    /// Factor on the frequency from one to the next.
    pub lacunarity: f32,
    /// Factor on the amplitude.
    pub diminish: f32,
}

impl Octaves {
    /// Sum of octaves of Perlin noise: one number, or as many as there are channels.
    pub fn noise<const N: usize>(self, place: [f32; N], channels: usize) -> Vec3 {
        if channels != 2 {
            return self.sum(place, channels);
        }
        let aside: [f32; N] = array::from_fn(|axis| place[axis] + ASIDE[axis]);
        Vec3::new(self.sum(place, 1).x, self.sum(aside, 1).x, 0.0)
    }

    fn sum<const N: usize>(self, mut place: [f32; N], channels: usize) -> Vec3 {
        let (mut sum, mut amplitude) = (Vec3::ZERO, 1.0);
        for _ in 0..self.count.clamp(0.0, MOST_OCTAVES) as u32 {
            sum += amplitude * perlin(place, channels);
            amplitude *= self.diminish;
            place = place.map(|axis| axis * self.lacunarity);
        }
        sum
    }
}

/// A number from 0 to 1 for each whole place.
pub fn cell<const N: usize>(place: [f32; N]) -> f32 {
    share(jenkins(whole(place)))
}

/// Three numbers from 0 to 1 for each whole place, of two or three axes.
fn cell3<const N: usize>(place: [f32; N]) -> Vec3 {
    let of = |number: u32| match whole(place)[..] {
        [x, y] => share(jenkins([x, y, number])),
        [x, y, z] => share(jenkins([x, y, z, number])),
        _ => 0.0,
    };
    Vec3::new(of(0), of(1), of(2))
}

fn whole<const N: usize>(place: [f32; N]) -> [u32; N] {
    place.map(|axis| axis.floor() as i32 as u32)
}

fn share(hash: u32) -> f32 {
    hash as f32 / u32::MAX as f32
}

/// Worley noise of two or three axes. Each cell has a point, `jitter` away from its middle: 0 not at all, 1 anywhere in the cell. The
/// distance of the nearest point, or of as many as there are channels; where it `is_solid`, numbers from 0 to 1 of the nearest point's
/// cell.
pub fn worley<const N: usize>(place: [f32; N], jitter: f32, is_solid: bool, channels: usize) -> Vec3 {
    let floor = place.map(f32::floor);
    let (mut nearest, mut nearest_point) = ([FAR; 3], [0.0; N]);
    for number in 0..3_usize.pow(N as u32) {
        let step: [f32; N] =
            array::from_fn(|axis| (number / 3_usize.pow((N - 1 - axis) as u32) % 3) as f32 - 1.0);
        let random = cell3::<N>(array::from_fn(|axis| floor[axis] + step[axis]));
        // from the place to the point
        let way: [f32; N] = array::from_fn(|axis| {
            step[axis] + (random[axis] - 0.5) * jitter + 0.5 - (place[axis] - floor[axis])
        });
        let distance = way.iter().map(|axis| axis * axis).sum();
        if distance < nearest[0] {
            nearest_point = array::from_fn(|axis| place[axis] + way[axis]);
        }
        let rank = nearest.iter().filter(|known| **known <= distance).count();
        if rank < 3 {
            nearest[rank..].rotate_right(1);
            nearest[rank] = distance;
        }
    }
    match (is_solid, channels) {
        (true, 1) => Vec3::splat(cell(nearest_point)),
        (true, _) => cell3(nearest_point),
        (false, 1) => Vec3::splat(nearest[0].sqrt()),
        (false, _) => Vec3::from(nearest.map(f32::sqrt)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of the first channel are not those of a single number: they come of other bits.
    #[test]
    fn channels_of_noise_differ() {
        let place = [0.3, 1.7, -2.2];
        let Vec3 { x, y, z } = perlin(place, 3);
        assert!(x != y && y != z && x != z, "{x} {y} {z}");
        assert!(perlin([3.0, -7.0, 2.0], 3).abs().max_element() < 1e-6, "0 on whole numbers");
        let octaves = Octaves { count: 1.0, lacunarity: 2.0, diminish: 0.5 };
        assert_eq!(octaves.noise(place, 3), perlin(place, 3));
        let [first, second] = [place, [19.3, 194.7, 14.8]].map(|place| octaves.noise(place, 1).x);
        assert!(octaves.noise(place, 2).abs_diff_eq(Vec3::new(first, second, 0.0), 1e-4));
    }

    /// Without jitter points are in the middle of cells.
    #[test]
    fn nearest_points_are_those_of_the_grid() {
        let of = |place: [f32; 2], channels| worley(place, 0.0, false, channels);
        assert_eq!(of([4.5, -2.5], 1), Vec3::ZERO);
        assert!((of([4.75, -2.5], 1).x - 0.25).abs() < 1e-6);
        assert!(of([4.75, -2.5], 3).abs_diff_eq(Vec3::new(0.25, 0.75, 1.0625_f32.sqrt()), 1e-6));
        assert!((worley([0.5, 0.5, 0.75], 0.0, false, 1).x - 0.25).abs() < 1e-6);
    }

    /// What is solid changes where another point is nearest, and has the number of that point's cell.
    #[test]
    fn solid_cells_have_the_number_of_their_point() {
        assert_eq!(worley([4.75, -2.5], 0.0, true, 1), Vec3::splat(cell([4.0, -3.0])));
        assert_eq!(worley([4.75, -2.5], 0.0, true, 3), cell3([4.0, -3.0]));
        let jittered = worley([4.75, -2.5], 1.0, true, 1);
        let around = (-1..=1).flat_map(|x| (-1..=1).map(move |y| cell([4.0 + x as f32, -3.0 + y as f32])));
        assert!(around.into_iter().any(|number| Vec3::splat(number) == jittered), "one of those around it");
    }
}
