//! How much light comes from where. An area light is up to sixteen points, jittered in a grid: each sample has a
//! pattern of its own, so that shadows have a grain rather than steps.

use glam::Vec3;
use wide::u32x8;

use super::area::from_places;
pub use super::light_sample::LightSample;
use super::light_sample::from_place;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8, signed};
use crate::pose::{LightPose, LightShape};

/// Where eight samples aim at in an area light: each has a pattern of its own, which is a function of its place
/// on its model alone. So it stays the same as long as the sample lives.
#[derive(Debug, Clone, Copy)]
pub struct StratifiedPattern(u32x8);

impl StratifiedPattern {
    /// For lights that are no areas.
    pub const NONE: Self = Self(u32x8::ZERO);

    /// The patterns of samples at `places`, in whatever space they are kept in. Of no use for `light` unless
    /// it is an area.
    #[inline(always)]
    pub fn at(light: &LightPose, places: Vec3x8) -> Self {
        if !light.shape.is_area() {
            return Self::NONE;
        }
        let [x, y, z] = [places.x, places.y, places.z].map(F32x8::to_bits);
        Self(scrambled(scrambled(scrambled(x) ^ y) ^ z))
    }

    /// Places in field number `point` of the light's grid, as shares of the light's edges from -1/2 to 1/2.
    #[inline(always)]
    fn aside(&self, light: &LightPose, point: usize) -> [F32x8; 2] {
        places(light, self.0, u32x8::splat(point as u32))
    }

    /// The same for one of the samples in eight fields, from number `first` on.
    #[inline(always)]
    fn asides(&self, light: &LightPose, sample: usize, first: usize) -> [F32x8; 2] {
        let points = u32x8::splat(first as u32) + u32x8::new(std::array::from_fn(|lane| lane as u32));
        places(light, u32x8::splat(self.0.as_array_ref()[sample]), points)
    }
}

/// Jittered places in fields of the light's grid.
#[inline(always)]
fn places(light: &LightPose, seeds: u32x8, points: u32x8) -> [F32x8; 2] {
    // 1, 2 or 4 fields along each edge: of numbers of so many bits
    let bits_of_field = light.points.ilog2() / 2;
    let grid = 1 << bits_of_field;
    let step = 1.0 / grid as f32;
    let bits = scrambled(seeds + points * u32x8::splat(0x9e37_79b9));
    let place = |field: u32x8, within: u32x8| {
        let [field, within] = [field, within].map(|whole| F32x8::from_whole(signed(whole)));
        within * F32x8::splat(step / 65536.0) + (field * F32x8::splat(step) - F32x8::splat(0.5))
    };
    [
        place(points & u32x8::splat(grid - 1), bits >> 16_u32),
        place(points >> bits_of_field, bits & u32x8::splat(0xffff)),
    ]
}

/// An integer hash in which each bit of the input changes each bit of the result about as often as not
/// (Wellons' "lowbias32").
#[inline(always)]
fn scrambled(bits: u32x8) -> u32x8 {
    let bits = (bits ^ (bits >> 16_u32)) * u32x8::splat(0x7feb_352d);
    let bits = (bits ^ (bits >> 15_u32)) * u32x8::splat(0x846c_a68b);
    bits ^ (bits >> 16_u32)
}

/// The ways from `points` to a light, any length, and where along them it is; to the centre of an area.
#[inline(always)]
pub fn way(light: &LightPose, points: Vec3x8) -> (Vec3x8, f32) {
    match light.shape {
        LightShape::Directional { to_light } | LightShape::Sun { to_light, .. } => {
            (Vec3x8::splat(to_light), f32::INFINITY)
        }
        LightShape::Point { position }
        | LightShape::Spot { position, .. }
        | LightShape::Rectangle { center: position, .. }
        | LightShape::Disk { center: position, .. }
        | LightShape::Sphere { center: position, .. } => (Vec3x8::splat(position) - points, 1.0),
    }
}

/// What point number `point` of `light` sends to `points` when nothing is in its way. Lights that are no areas
/// have point 0 alone.
///
/// Light falls with the square of the distance; a spot fades from its inner to its outer cone by the
/// smoothstep of the cosine. Each point of an area stands for one field of a grid and sends its share of the light.
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
            LightSample { to_light, direction: to_light, far: f32::INFINITY, irradiance }
        }
        LightShape::Point { position } => from_position(light.strength, position, points),
        LightShape::Spot { position, axis, cos_outer, cos_inner } => {
            let mut light_sample = from_position(light.strength, position, points);
            let cos = -light_sample.direction.dot(Vec3x8::splat(axis));
            light_sample.irradiance = light_sample.irradiance * fade(cos, cos_outer, cos_inner);
            light_sample
        }
        LightShape::Rectangle { .. }
        | LightShape::Disk { .. }
        | LightShape::Sphere { .. }
        | LightShape::Sun { .. } => from_places(light, pattern.aside(light, point), points),
    }
}

/// What all points of an area light send to one of eight samples: [`light_sample`], with points for lanes. Where it has fewer,
/// nothing comes from the lanes behind them.
#[inline(always)]
pub fn light_samples(
    light: &LightPose,
    pattern: &StratifiedPattern,
    sample: usize,
    point: Vec3,
) -> [LightSample; 2] {
    [0, LANES].map(|first| {
        let mut light_sample = from_places(light, pattern.asides(light, sample, first), Vec3x8::splat(point));
        if light.points < first + LANES {
            let is_there = Mask::of(|lane| first + lane < light.points);
            light_sample.irradiance = is_there.select3(light_sample.irradiance, Vec3x8::ZERO);
        }
        light_sample
    })
}

/// All of the light that one place of `light` would send to eight points if all of it came from there; in an area that is
/// the place at `along` and `above` from 0 to 1. The mean over all places is what the light sends.
#[inline(always)]
pub fn light_from_anywhere(light: &LightPose, [along, above]: [F32x8; 2], points: Vec3x8) -> LightSample {
    if !light.shape.is_area() {
        return light_sample(light, 0, &StratifiedPattern::NONE, points);
    }
    let half = F32x8::splat(0.5);
    let mut light_sample = from_places(light, [along - half, above - half], points);
    light_sample.irradiance = light_sample.irradiance * F32x8::splat(light.points as f32);
    light_sample
}

#[inline(always)]
fn from_position(intensity: Vec3, position: Vec3, points: Vec3x8) -> LightSample {
    from_place(intensity, Vec3x8::splat(position), points)
}

/// 0 at `outer` and beyond, 1 from `inner` on.
#[inline(always)]
fn fade(cos: F32x8, outer: f32, inner: f32) -> F32x8 {
    let (outer, inner, one) = (F32x8::splat(outer), F32x8::splat(inner), F32x8::splat(1.0));
    let t = (cos - outer) / (inner - outer);
    let between = t * t * (F32x8::splat(3.0) - (t + t));
    cos.le(outer).select(F32x8::ZERO, cos.lt(inner).select(between, one))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_light_falls_with_the_square() {
        let shape = LightShape::Point { position: Vec3::new(0.0, 2.0, 0.0) };
        let light = LightPose { shape, strength: Vec3::splat(8.0), points: 1 };
        let light_sample =
            light_sample(&light, 0, &StratifiedPattern::at(&light, Vec3x8::ZERO), Vec3x8::ZERO);
        assert_eq!(light_sample.irradiance.lane(0), Vec3::splat(2.0));
        assert_eq!(light_sample.to_light.lane(1) * light_sample.far, Vec3::new(0.0, 2.0, 0.0));
        assert!((light_sample.direction.lane(2) - Vec3::Y).length() < 1e-6);
    }

    #[test]
    fn a_spot_is_full_inside_and_dark_outside() {
        let shape = LightShape::Spot { position: Vec3::Y, axis: Vec3::NEG_Y, cos_outer: 0.5, cos_inner: 0.9 };
        let light = LightPose { shape, strength: Vec3::ONE, points: 1 };
        let at = |point: Vec3| {
            let points = Vec3x8::splat(point);
            light_sample(&light, 0, &StratifiedPattern::at(&light, points), points).irradiance.lane(0)
        };
        assert_eq!(at(Vec3::ZERO), Vec3::ONE);
        assert_eq!(at(Vec3::new(3.0, 0.0, 0.0)), Vec3::ZERO);
        assert_eq!(fade(F32x8::splat(0.7), 0.5, 0.9).lane(0), 0.5);
        assert_eq!(fade(F32x8::splat(0.7), 0.7, 0.7).lane(0), 0.0, "a cone without a soft rim");
    }

    fn panel(center: Vec3, size: f32) -> LightPose {
        let (across, up, axis) = (Vec3::X * size, Vec3::Z * size, Vec3::NEG_Y);
        let shape = LightShape::Rectangle { center, across, up, axis };
        LightPose { shape, strength: Vec3::splat(8.0), points: 16 }
    }

    #[test]
    fn a_small_rectangle_is_a_point_that_shines_with_the_cosine() {
        let light = panel(Vec3::new(0.0, 2.0, 0.0), 1e-3);
        let at = |point: Vec3| {
            let points = Vec3x8::splat(point);
            let pattern = StratifiedPattern::at(&light, points);
            let each = (0..light.points).map(|number| light_sample(&light, number, &pattern, points));
            each.map(|light_sample| light_sample.irradiance.lane(0).x).sum::<f32>()
        };
        assert!((at(Vec3::ZERO) - 2.0).abs() < 1e-3);
        // at 45 degrees: twice the square of the distance, and the cosine
        assert!((at(Vec3::new(2.0, 0.0, 0.0)) - 0.5_f32.sqrt()).abs() < 1e-3);
        assert_eq!(at(Vec3::new(0.0, 3.0, 0.0)), 0.0, "behind it there is no light");
    }

    #[test]
    fn the_points_fill_the_rectangle_and_are_the_samples_own() {
        for grid in [1, 2, 4] {
            let light = LightPose { points: grid * grid, ..panel(Vec3::new(0.0, 2.0, 0.0), 4.0) };
            let mut places = Vec3x8::ZERO;
            (0..LANES).for_each(|lane| places.set_lane(lane, Vec3::new(lane as f32, 0.5, -3.0)));
            let pattern = StratifiedPattern::at(&light, places);
            let field = 4.0 / grid as f32;
            for number in 0..light.points {
                let light_sample = light_sample(&light, number, &pattern, places);
                let source = places + light_sample.to_light;
                let [column, row] = [number % grid, number / grid].map(|at| at as f32 * field - 2.0);
                let within = |lane: usize| source.lane(lane) - Vec3::new(column, 2.0, row);
                for lane in 0..LANES {
                    let at = within(lane);
                    let is_inside = |along: f32| (-1e-5..=field).contains(&along);
                    assert!(is_inside(at.x) && is_inside(at.z), "{number} {at}");
                    assert_eq!(at.y, 0.0);
                }
                assert!(within(0) != within(1), "each sample has a pattern of its own");
                for sample in 0..LANES {
                    let alone = light_samples(&light, &pattern, sample, places.lane(sample))[number / LANES];
                    assert_eq!(alone.to_light.lane(number % LANES), light_sample.to_light.lane(sample));
                    assert_eq!(alone.irradiance.lane(number % LANES), light_sample.irradiance.lane(sample));
                }
            }
            let alone = light_samples(&light, &pattern, 0, places.lane(0));
            let shining = alone.map(|half| half.irradiance.is_some().bits().count_ones() as usize);
            assert_eq!(shining[0] + shining[1], light.points, "nothing comes from points that are not there");
        }
    }
}
