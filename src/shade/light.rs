//! Light from light sources. An area light is up to sixteen points, spread evenly: each sample has a pattern
//! of its own, so that shadows have a grain rather than steps.

use glam::Vec3;
use wide::u32x8;

use super::area::from_places;
pub use super::light_sample::LightSample;
use super::light_sample::{from_place, within};
use super::sampling::NUMBER_BITS;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8, signed};
use crate::pose::{LightPose, LightShape, LightSource};
use crate::scene::Light;

/// Points of an area light that eight samples aim at, for as long as they live. The points of all samples of
/// a pixel are the first ones of one (0, 2)-sequence in base 2 (Sobol's first two dimensions), with its
/// digits scrambled for the pixel. They are spread evenly together, and those of each sample by themselves,
/// one in each field of a grid.
#[derive(Debug, Clone, Copy)]
pub struct StratifiedPattern([u32x8; 2]);

impl StratifiedPattern {
    /// Pattern for lights that have no area.
    pub const NONE: Self = Self([u32x8::ZERO; 2]);

    /// Creates the patterns of samples with these [seeds](super::sampling::SampleSeed). Unused unless `light`
    /// has an area.
    #[inline(always)]
    pub fn of_seeds(light: &LightPose, seeds: u32x8) -> Self {
        if !light.shape.is_area() {
            return Self::NONE;
        }
        let across = scrambled(seeds >> NUMBER_BITS);
        let up = scrambled(across);
        let first = (seeds & u32x8::splat((1 << NUMBER_BITS) - 1)) * u32x8::splat(light.points as u32);
        Self([across ^ radical_inverse(first), up ^ radical_inverse(pascal(first))])
    }

    /// Point number `point` of each sample, as shares of the light's edges from -1/2 to 1/2.
    #[inline(always)]
    fn aside(&self, point: usize) -> [F32x8; 2] {
        [0, 1].map(|axis| share(self.0[axis] ^ u32x8::splat(POINTS[axis][point])))
    }

    /// Eight points of one of the samples, from number `first` on, as shares of the light's edges.
    #[inline(always)]
    fn asides(&self, sample: usize, first: usize) -> [F32x8; 2] {
        [0, 1].map(|axis| {
            let points = u32x8::new(std::array::from_fn(|lane| POINTS[axis][first + lane]));
            share(u32x8::splat(self.0[axis].as_array_ref()[sample]) ^ points)
        })
    }
}

/// Seeds of surfaces that are not samples, at `places`: as if each had a pixel of its own.
#[inline(always)]
pub fn seeds_of_places(places: Vec3x8) -> u32x8 {
    let [x, y, z] = [places.x, places.y, places.z].map(F32x8::to_bits);
    scrambled(scrambled(scrambled(x) ^ y) ^ z) << NUMBER_BITS
}

/// Largest number of points of a light.
const MOST_POINTS: usize = Light::MOST_SAMPLES as usize;

/// First points of the sequence, unscrambled. The sequence is linear: a sample's points are these, combined
/// with its own first point.
const POINTS: [[u32; MOST_POINTS]; 2] = {
    let mut points = [[0; MOST_POINTS]; 2];
    let mut number = 0;
    while number < MOST_POINTS {
        let mut pascal = number as u32;
        pascal ^= (pascal & 0xaaaa_aaaa) >> 1;
        pascal ^= (pascal & 0xcccc_cccc) >> 2;
        points[0][number] = (number as u32).reverse_bits();
        points[1][number] = pascal.reverse_bits();
        number += 1;
    }
    points
};

/// Reverses the bits of a number: the first dimension of Sobol's sequence.
#[inline(always)]
fn radical_inverse(number: u32x8) -> u32x8 {
    let swap = |bits: u32x8, mask: u32, by: u32| {
        let mask = u32x8::splat(mask);
        ((bits >> by) & mask) | ((bits & mask) << by)
    };
    let bits = swap(number, 0x5555_5555, 1);
    let bits = swap(bits, 0x3333_3333, 2);
    let bits = swap(bits, 0x0f0f_0f0f, 4);
    let bits = swap(bits, 0x00ff_00ff, 8);
    swap(bits, 0x0000_ffff, 16)
}

/// Multiplies Pascal's triangle modulo 2 by a number of up to 16 bits: reversed, it is the second dimension.
#[inline(always)]
fn pascal(number: u32x8) -> u32x8 {
    let add = |bits: u32x8, mask: u32, by: u32| bits ^ ((bits & u32x8::splat(mask)) >> by);
    let bits = add(number, 0xaaaa_aaaa, 1);
    let bits = add(bits, 0xcccc_cccc, 2);
    let bits = add(bits, 0xf0f0_f0f0, 4);
    add(bits, 0xff00_ff00, 8)
}

/// Maps words evenly to numbers from -1/2 to below 1/2.
#[inline(always)]
fn share(bits: u32x8) -> F32x8 {
    const STEP: f32 = 1.0 / (1 << 24) as f32;
    F32x8::from_whole(signed(bits >> 8_u32)) * F32x8::splat(STEP) - F32x8::splat(0.5)
}

/// An integer hash in which each bit of the input changes each bit of the result about as often as not
/// (Wellons' "lowbias32").
#[inline(always)]
fn scrambled(bits: u32x8) -> u32x8 {
    let bits = (bits ^ (bits >> 16_u32)) * u32x8::splat(0x7feb_352d);
    let bits = (bits ^ (bits >> 15_u32)) * u32x8::splat(0x846c_a68b);
    bits ^ (bits >> 16_u32)
}

/// Vectors from `points` to a light, of any length, and the parameter along them at which the light is; to
/// the centre of an area light.
#[inline(always)]
pub fn to_light(light: &LightPose, points: Vec3x8) -> (Vec3x8, f32) {
    match light.shape.source() {
        LightSource::Direction(to_light) => (Vec3x8::splat(to_light), f32::INFINITY),
        LightSource::Place(place) => (Vec3x8::splat(place) - points, 1.0),
    }
}

/// Light that point number `point` of `light` sends to `points` if nothing is in its way. Lights that have no
/// area have point 0 alone.
///
/// Light falls with the square of the distance; a spot fades from its inner to its outer cone by a curve
/// of the cosine. Each point of an area light stands for one field of a grid and sends its share
/// of the light.
#[inline(always)]
pub fn light_sample(
    light: &LightPose,
    point: usize,
    pattern: &StratifiedPattern,
    points: Vec3x8,
) -> LightSample {
    match light.shape {
        LightShape::Directional { to_light } => {
            let to_light = Vec3x8::splat(to_light);
            let irradiance = Vec3x8::splat(light.strength);
            LightSample { to_light, direction: to_light, far: f32::INFINITY, irradiance, reaches: Mask::ALL }
        }
        LightShape::Point { position } => from_position(light.strength, position, points),
        LightShape::Spot { position, cone } => within(&cone, from_position(light.strength, position, points)),
        LightShape::Area(area) => from_places(light, area, pattern.aside(point), points),
    }
}

/// Light that all points of an area light send to one of eight samples: [`light_sample`], with points for
/// lanes. Lanes beyond the light's last point get nothing.
#[inline(always)]
pub fn light_samples(
    light: &LightPose,
    pattern: &StratifiedPattern,
    sample: usize,
    point: Vec3,
) -> [LightSample; 2] {
    [samples_from(light, pattern, (sample, 0), point), samples_from(light, pattern, (sample, LANES), point)]
}

/// Light from eight of the points, from number `first` on. Inlined, so that values that the caller does not
/// use are not computed.
#[inline(always)]
fn samples_from(
    light: &LightPose,
    pattern: &StratifiedPattern,
    (sample, first): (usize, usize),
    point: Vec3,
) -> LightSample {
    let points = Vec3x8::splat(point);
    let mut light_sample = match light.shape {
        LightShape::Area(area) => from_places(light, area, pattern.asides(sample, first), points),
        // the only point there is
        _ => light_sample(light, 0, pattern, points),
    };
    if light.points < first + LANES {
        let is_there = Mask::new(|lane| first + lane < light.points);
        light_sample.irradiance = is_there.select3(light_sample.irradiance, Vec3x8::ZERO);
        light_sample.reaches = light_sample.reaches & is_there;
    }
    light_sample
}

/// Light that one point of `light` would send to eight points if all of the light came from there. In an area
/// light that is the point at `along` and `above`, from 0 to 1. The mean over all of these is the light's
/// own.
#[inline(always)]
pub fn light_from_anywhere(light: &LightPose, [along, above]: [F32x8; 2], points: Vec3x8) -> LightSample {
    let LightShape::Area(area) = light.shape else {
        return light_sample(light, 0, &StratifiedPattern::NONE, points);
    };
    let half = F32x8::splat(0.5);
    let mut light_sample = from_places(light, area, [along - half, above - half], points);
    light_sample.irradiance = light_sample.irradiance * F32x8::splat(light.points as f32);
    light_sample
}

#[inline(always)]
fn from_position(intensity: Vec3, position: Vec3, points: Vec3x8) -> LightSample {
    from_place(intensity, Vec3x8::splat(position), points)
}

#[cfg(test)]
mod tests {
    use super::super::sampling::SampleSeed;
    use super::*;
    use crate::pose::{AreaShape, Cone};

    #[test]
    fn a_point_light_falls_with_the_square() {
        let shape = LightShape::Point { position: Vec3::new(0.0, 2.0, 0.0) };
        let light = LightPose { shape, strength: Vec3::splat(8.0), points: 1 };
        let light_sample = light_sample(&light, 0, &StratifiedPattern::NONE, Vec3x8::ZERO);
        assert_eq!(light_sample.irradiance.lane(0), Vec3::splat(2.0));
        assert_eq!(light_sample.to_light.lane(1) * light_sample.far, Vec3::new(0.0, 2.0, 0.0));
        assert!((light_sample.direction.lane(2) - Vec3::Y).length() < 1e-6);
    }

    #[test]
    fn a_spot_is_full_inside_and_dark_outside() {
        let cone = Cone { axis: Vec3::NEG_Y, cos_outer: 0.5, cos_inner: 0.9, curve: [3.0, 2.0] };
        let shape = LightShape::Spot { position: Vec3::Y, cone };
        let light = LightPose { shape, strength: Vec3::ONE, points: 1 };
        let at = |point: Vec3| {
            let points = Vec3x8::splat(point);
            light_sample(&light, 0, &StratifiedPattern::of_seeds(&light, seeds_of_places(points)), points)
                .irradiance
                .lane(0)
        };
        assert_eq!(at(Vec3::ZERO), Vec3::ONE);
        assert_eq!(at(Vec3::new(3.0, 0.0, 0.0)), Vec3::ZERO);
    }

    fn panel(center: Vec3, size: f32) -> LightPose {
        let (across, up, axis) = (Vec3::X * size, Vec3::Z * size, Vec3::NEG_Y);
        let shape = LightShape::Area(AreaShape::Rectangle { center, across, up, axis, spread: None });
        LightPose { shape, strength: Vec3::splat(8.0), points: 16 }
    }

    #[test]
    fn a_small_rectangle_is_a_point_that_shines_with_the_cosine() {
        let light = panel(Vec3::new(0.0, 2.0, 0.0), 1e-3);
        let at = |point: Vec3| {
            let points = Vec3x8::splat(point);
            let pattern = StratifiedPattern::of_seeds(&light, seeds_of_places(points));
            let each = (0..light.points).map(|number| light_sample(&light, number, &pattern, points));
            each.map(|light_sample| light_sample.irradiance.lane(0).x).sum::<f32>()
        };
        assert!((at(Vec3::ZERO) - 2.0).abs() < 1e-3);
        // at 45 degrees: twice the square of the distance, and the cosine
        assert!((at(Vec3::new(2.0, 0.0, 0.0)) - 0.5_f32.sqrt()).abs() < 1e-3);
        assert_eq!(at(Vec3::new(0.0, 3.0, 0.0)), 0.0, "behind it there is no light");
    }

    /// Columns and rows, in a grid of `columns` by `rows`, of the points that eight samples aim at in a panel
    /// of this size.
    fn fields(light: &LightPose, seeds: u32x8, size: f32, [columns, rows]: [u32; 2]) -> Vec<Vec<[u32; 2]>> {
        let pattern = StratifiedPattern::of_seeds(light, seeds);
        let center = Vec3::new(0.0, 2.0, 0.0);
        let field = |along: f32, of: u32| ((along / size + 0.5) * of as f32) as u32;
        let of_sample = |sample: usize| {
            let of_point = |number| {
                let to_light = light_sample(light, number, &pattern, Vec3x8::ZERO).to_light.lane(sample);
                assert_eq!(to_light.y, center.y);
                assert!(to_light.x.abs() <= 0.5 * size && to_light.z.abs() <= 0.5 * size, "{to_light}");
                [field(to_light.x, columns), field(to_light.z, rows)]
            };
            (0..light.points).map(of_point).collect()
        };
        (0..LANES).map(of_sample).collect()
    }

    fn count_of(fields: impl Iterator<Item = [u32; 2]>) -> usize {
        fields.collect::<std::collections::HashSet<_>>().len()
    }

    #[test]
    fn places_are_spread_evenly_for_each_sample_and_for_all_of_a_pixel() {
        for points in [1, 4, 16] {
            let light = LightPose { points, ..panel(Vec3::new(0.0, 2.0, 0.0), 4.0) };
            let seed = |number: u32| SampleSeed::new(7, number, 3, 0).to_bits();
            let seeds = u32x8::new(std::array::from_fn(|lane| seed(lane as u32)));
            let of_sample = points.ilog2();
            for bits in 0..=of_sample {
                for fields in fields(&light, seeds, 4.0, [1 << bits, 1 << (of_sample - bits)]) {
                    assert_eq!(count_of(fields.into_iter()), points, "a field of its own for each, {bits}");
                }
            }
            let of_all = of_sample + LANES.ilog2();
            for bits in 0..=of_all {
                let fields = fields(&light, seeds, 4.0, [1 << bits, 1 << (of_all - bits)]);
                assert_eq!(count_of(fields.into_iter().flatten()), points * LANES, "{bits}");
            }
            let other =
                fields(&light, u32x8::splat(SampleSeed::new(8, 0, 3, 0).to_bits()), 4.0, [1 << 12; 2]);
            assert_ne!(
                other[0],
                fields(&light, seeds, 4.0, [1 << 12; 2])[0],
                "each pixel has places of its own"
            );
        }
    }

    #[test]
    fn points_side_by_side_are_those_of_samples_side_by_side() {
        for points in [1, 4, 16] {
            let light = LightPose { points, ..panel(Vec3::new(0.0, 2.0, 0.0), 4.0) };
            let mut places = Vec3x8::ZERO;
            (0..LANES).for_each(|lane| places.set_lane(lane, Vec3::new(lane as f32, 0.5, -3.0)));
            let pattern = StratifiedPattern::of_seeds(&light, seeds_of_places(places));
            for sample in 0..LANES {
                let alone = light_samples(&light, &pattern, sample, places.lane(sample));
                for number in 0..points {
                    let light_sample = light_sample(&light, number, &pattern, places);
                    let alone = &alone[number / LANES];
                    assert_eq!(alone.to_light.lane(number % LANES), light_sample.to_light.lane(sample));
                    assert_eq!(alone.irradiance.lane(number % LANES), light_sample.irradiance.lane(sample));
                }
                let shining = alone.map(|half| half.irradiance.is_some().bits().count_ones() as usize);
                assert_eq!(shining[0] + shining[1], points, "nothing comes from points that are not there");
            }
        }
    }
}
