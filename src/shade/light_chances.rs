//! How likely a surface is to ask each of several light sources: the likelier, the more light it may send there.
//!
//! Chances are those of the shot, not of a frame: a source that moves counts by the middle of its way, and one
//! that changes by the most that it ever sends. So what a path has asked depends on no source but that one, and
//! its result holds whatever the others do. What is in the way is not known. A share of all questions is spread
//! evenly, which bounds the noise of sources that count for less than they send.

use glam::Vec3;

use crate::cumulative::BELOW_ONE;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::pose::{AreaShape, LightPose, LightShape, LightSource};
use crate::scene::Light;

/// Least reach of a source: the square of its reciprocal is finite.
const LEAST_REACH: f32 = 1e-15;

/// Share of the questions that is spread evenly over all sources.
const EVEN_SHARE: f32 = 0.25;

/// Source of light, world space.
#[derive(Debug, Clone, Copy)]
pub struct Source {
    /// Irradiance of sources at infinity; intensity of others. Any unit that all have.
    strength: f32,
    /// None for one at infinity.
    place: Option<Vec3>,
    /// Distance from its place within which it is nowhere in particular: its size, or its way.
    reach: f32,
    aim: Aim,
}

/// Directions in which a source shines.
#[derive(Debug, Clone, Copy)]
enum Aim {
    All,
    /// To one side of a panel, and less aside, by the cosine to its axis.
    Panel(Vec3),
    /// To both sides of what is flat, in the same way.
    Flat(Vec3),
    /// Within a cone about an axis, up to an angle of this cosine.
    Cone(Vec3, f32),
}

impl Source {
    /// Creates a source of this strength that shines to all sides, within `reach` of `place`.
    pub fn around(place: Vec3, reach: f32, strength: f32) -> Self {
        Self { strength, place: Some(place), reach, aim: Aim::All }
    }

    /// Has the source shine as what is flat does, with this axis (unit length).
    #[must_use]
    pub fn flat(self, axis: Vec3) -> Self {
        Self { aim: Aim::Flat(axis), ..self }
    }

    /// Looks at all frames of `light`.
    pub fn of_light(light: &Light) -> Self {
        let poses: Vec<LightPose> =
            light.frames().into_iter().map(|frame| LightPose::new(light, frame)).collect();
        let strength = poses.iter().map(|pose| pose.strength.max_element()).fold(0.0, f32::max);
        let places = poses.iter().filter_map(|pose| match pose.shape.source() {
            LightSource::Place(place) => Some(place),
            LightSource::Direction(_) => None,
        });
        let (low, high) = places.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), place| {
            (low.min(place), high.max(place))
        });
        let is_near = low.cmple(high).all();
        let size = poses.first().map_or(0.0, |pose| pose.shape.reach());
        let aim = match poses.first().map(|pose| pose.shape) {
            Some(shape) if poses.iter().any(|pose| pose.shape != shape) => Aim::All,
            Some(LightShape::Area(AreaShape::Rectangle { axis, .. } | AreaShape::Disk { axis, .. })) => {
                Aim::Panel(axis)
            }
            Some(
                LightShape::Spot { cone, .. } | LightShape::Area(AreaShape::Sphere { cone: Some(cone), .. }),
            ) => Aim::Cone(cone.axis, cone.cos_outer),
            _ => Aim::All,
        };
        Self {
            strength,
            place: is_near.then_some(0.5 * (low + high)),
            reach: if is_near { 0.5 * (high - low).length() + 0.5 * size } else { 0.0 },
            aim,
        }
    }
}

/// Chances of some sources.
#[derive(Debug, Clone, Default)]
pub struct LightChances {
    /// The sources, eight at a time; lanes without one send nothing.
    eights: Vec<Eight>,
    count: usize,
}

/// Source that was chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chosen {
    /// Its number.
    pub source: usize,
    /// Probability with which it is chosen.
    pub chance: f32,
    /// What is left of the random number: from 0 to below 1, as random as that was.
    pub rest: f32,
}

/// What sources may send to one place: the paths of a sample all ask from there.
#[derive(Debug, Clone, Copy)]
pub struct Sent {
    to: Option<Vec3>,
    all: [F32x8; Self::MOST / LANES],
    sum: Option<f32>,
}

impl Sent {
    /// Most sources of which it is known.
    pub const MOST: usize = 32;
    /// Nothing is known.
    pub const NOWHERE: Self = Self { to: None, all: [F32x8::ZERO; Self::MOST / LANES], sum: None };
}

impl Default for Sent {
    fn default() -> Self {
        Self::NOWHERE
    }
}

/// Eight sources.
#[derive(Debug, Clone, Copy)]
struct Eight {
    strength: F32x8,
    is_far: Mask,
    place: Vec3x8,
    /// Above zero.
    reach: F32x8,
    /// Zero for sources that shine to all sides.
    axis: Vec3x8,
    is_panel: Mask,
    is_flat: Mask,
    /// Cosine to the axis from which on others shine.
    least_cos: F32x8,
}

impl Eight {
    fn new(sources: &[Source]) -> Self {
        let mut eight = Self {
            strength: F32x8::ZERO,
            is_far: Mask::NONE,
            place: Vec3x8::ZERO,
            reach: F32x8::ONE,
            axis: Vec3x8::ZERO,
            is_panel: Mask::NONE,
            is_flat: Mask::NONE,
            least_cos: F32x8::ZERO,
        };
        for (lane, source) in sources.iter().enumerate() {
            eight.strength.set_lane(lane, source.strength);
            let Some(place) = source.place else {
                eight.is_far.set(lane);
                continue;
            };
            eight.place.set_lane(lane, place);
            eight.reach.set_lane(lane, source.reach.max(LEAST_REACH));
            match source.aim {
                Aim::All => {}
                Aim::Panel(axis) => {
                    eight.axis.set_lane(lane, axis);
                    eight.is_panel.set(lane);
                }
                Aim::Flat(axis) => {
                    eight.axis.set_lane(lane, axis);
                    eight.is_flat.set(lane);
                }
                Aim::Cone(axis, cos) => {
                    eight.axis.set_lane(lane, axis);
                    eight.least_cos.set_lane(lane, cos);
                }
            }
        }
        eight
    }

    /// Irradiance that each source may send to `point`, if it is faced there and nothing is between.
    #[inline]
    fn at(&self, point: Vec3) -> F32x8 {
        let way = Vec3x8::splat(point) - self.place;
        let squared = way.dot(way).max(self.reach * self.reach);
        let distance = squared.sqrt();
        let (cos, size) = (self.axis.dot(way) / distance, self.reach / distance);
        // aside of the middle of what is wide and near, some of it is not aside
        let flat = cos.abs().max(size);
        let panel = F32x8::ZERO.le(cos).select(flat, F32x8::ZERO);
        let within = self.least_cos.le(cos).select(F32x8::ONE, F32x8::ZERO);
        let aimed = self.is_panel.select(panel, self.is_flat.select(flat, within));
        self.strength * self.is_far.select(F32x8::ONE, aimed / squared)
    }
}

impl LightChances {
    /// Chances of these sources.
    pub fn new(sources: &[Source]) -> Self {
        Self { eights: sources.chunks(LANES).map(Eight::new).collect(), count: sources.len() }
    }

    /// Chooses a source for a surface at `point` (world space) by a `random` number from 0 to below 1. There is at
    /// least one.
    pub fn choose(&self, point: Vec3, random: f32) -> Chosen {
        if self.count < 2 {
            return Chosen { source: 0, chance: 1.0, rest: random };
        }
        self.choose_by(self.sum(point), |number| self.eights[number].at(point), random)
    }

    /// [Chooses](Self::choose) one of at most [`Sent::MOST`] sources; `sent` is what was known of the last surface,
    /// often the same.
    pub fn choose_again(&self, point: Vec3, random: f32, sent: &mut Sent) -> Chosen {
        if self.count < 2 {
            return Chosen { source: 0, chance: 1.0, rest: random };
        }
        if sent.to != Some(point) {
            for (sent, eight) in sent.all.iter_mut().zip(&self.eights) {
                *sent = eight.at(point);
            }
            (sent.to, sent.sum) = (Some(point), sum_of_all(sent.all[..self.eights.len()].iter().copied()));
        }
        self.choose_by(sent.sum, |number| sent.all[number], random)
    }

    /// Chooses a source; `sum` and `sent`: what all send, and eight by their number.
    #[inline]
    fn choose_by(&self, sum: Option<f32>, sent: impl Fn(usize) -> F32x8, random: f32) -> Chosen {
        let count = self.count;
        let evenly = |share: f32| {
            let source = ((share * count as f32) as usize).min(count - 1);
            (source, (share * count as f32 - source as f32).min(BELOW_ONE))
        };
        let Some(sum) = sum else {
            let (source, rest) = evenly(random);
            return Chosen { source, chance: 1.0 / count as f32, rest };
        };
        let (mut source, mut rest) = evenly(random / EVEN_SHARE);
        if random >= EVEN_SHARE {
            let mut left = (random - EVEN_SHARE) / (1.0 - EVEN_SHARE) * sum;
            // where rounding leads past the last one, that one stands
            'all: for number in 0..self.eights.len() {
                let sent = sent(number);
                let of_eight = sum_of(sent);
                if left >= of_eight {
                    left -= of_eight;
                    continue;
                }
                for (lane, sent) in sent.values().iter().enumerate() {
                    if left < *sent {
                        (source, rest) = (number * LANES + lane, (left / sent).min(BELOW_ONE));
                        break 'all;
                    }
                    left -= sent;
                }
            }
        }
        let chance = self.chance(sent(source / LANES).lane(source % LANES), sum);
        Chosen { source, chance, rest }
    }

    /// Probability with which a surface at `point` asks `source`, of all sources.
    pub fn of(&self, point: Vec3, source: usize) -> f32 {
        if self.count < 2 {
            return 1.0;
        }
        let Some(sum) = self.sum(point) else { return 1.0 / self.count as f32 };
        self.chance(self.eights[source / LANES].at(point).lane(source % LANES), sum)
    }

    /// What all sources may send to `point`, if that tells anything.
    fn sum(&self, point: Vec3) -> Option<f32> {
        sum_of_all(self.eights.iter().map(|eight| eight.at(point)))
    }

    fn chance(&self, sent: f32, sum: f32) -> f32 {
        EVEN_SHARE / self.count as f32 + (1.0 - EVEN_SHARE) * sent / sum
    }
}

/// Sum of what sources send, if it tells anything.
fn sum_of_all(sent: impl Iterator<Item = F32x8>) -> Option<f32> {
    Some(sum_of(sent.fold(F32x8::ZERO, |sum, sent| sum + sent))).filter(|sum| *sum > 0.0 && sum.is_finite())
}

/// Sum of eight values, by pairs.
fn sum_of(values: F32x8) -> f32 {
    let [a, b, c, d, e, f, g, h] = *values.values();
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use glam::DVec3;

    use super::*;
    use crate::animation::{Interpolation, Track};
    use crate::scene::{LightKind, Panel, SpotFall};

    fn light(kind: LightKind, power: f64) -> Light {
        let (color, power) = (Track::constant(Vec3::ONE), Track::constant(power));
        Light { name: "light".into(), kind, color, power, samples: 1, group: None, links: Default::default() }
    }

    fn lamp(place: DVec3, power: f64) -> Light {
        light(LightKind::Point { position: Track::constant(place) }, power)
    }

    /// One of each kind, one that moves, a dark one, and a row of lamps.
    fn lights() -> Vec<Light> {
        let [here, below] = [DVec3::new(1.0, 2.0, 0.0), DVec3::new(1.0, 0.0, 0.0)];
        let constant = Track::constant;
        let way = Track::through(vec![(0.0, DVec3::ZERO), (9.0, DVec3::X * 4.0)], Interpolation::Linear);
        let panel = Panel::at_rest(here, below, [0.5, 0.25]);
        let mut lights = vec![
            light(LightKind::Directional { direction: constant(DVec3::NEG_Y) }, 0.5),
            light(LightKind::Sun { direction: constant(DVec3::NEG_X), angle: 2.0.into() }, 1.0),
            light(LightKind::Rectangle(panel.clone()), 3.0),
            light(LightKind::Disk(panel), 1.0),
            light(LightKind::Sphere { position: constant(-here), radius: 0.3.into(), faces: false }, 2.0),
            light(LightKind::Point { position: way.unwrap() }, 1.0),
            light(
                LightKind::Spot {
                    position: constant(here),
                    target: constant(below),
                    cone: 40.0.into(),
                    soft: 0.2.into(),
                    fall: SpotFall::Smooth,
                    radius: 0.0.into(),
                },
                5.0,
            ),
            lamp(DVec3::ZERO, 0.0),
        ];
        lights.extend((0..9).map(|i| lamp(DVec3::new(f64::from(i) * 3.0, 3.0, 0.0), 1.0)));
        lights
    }

    fn chances_of(lights: &[Light]) -> LightChances {
        LightChances::new(&lights.iter().map(Source::of_light).collect::<Vec<_>>())
    }

    fn points() -> impl Iterator<Item = Vec3> {
        let at = |i: u32| [i % 7, i / 7 % 5, i / 35].map(|step| step as f32 * 1.7 - 2.0);
        // lights among them, and far away from all
        (0..105).map(move |i| Vec3::from(at(i))).chain([Vec3::new(1.0, 2.0, 0.0), Vec3::splat(1e19)])
    }

    #[test]
    fn chances_are_those_with_which_lights_are_chosen() {
        let lights = lights();
        for count in [1, 2, 7, 8, lights.len()] {
            let (chances, mut sent) = (chances_of(&lights[..count]), Sent::NOWHERE);
            for point in points() {
                let all: Vec<f32> = (0..count).map(|light| chances.of(point, light)).collect();
                let sum: f32 = all.iter().sum();
                assert!((sum - 1.0).abs() < 1e-5, "{count} {point}: {sum}");
                assert!(all.iter().all(|chance| *chance >= 0.999 * EVEN_SHARE / count as f32), "{all:?}");
                let (mut times, steps) = (vec![0.0; count], 1024);
                for step in 0..steps {
                    let random = step as f32 / steps as f32;
                    let Chosen { source, chance, rest } = chances.choose(point, random);
                    let again = chances.choose_again(point, random, &mut sent);
                    assert_eq!(again, Chosen { source, chance, rest });
                    assert_eq!(chance, all[source], "{count} {point}");
                    assert!((0.0..1.0).contains(&rest), "{rest}");
                    times[source] += 1.0 / steps as f32;
                }
                // each part of the numbers may be a step longer or shorter
                let off = times.iter().zip(&all).map(|(times, chance)| (times - chance).abs());
                assert!(off.fold(0.0, f32::max) < 3.0 / steps as f32, "{count} {point}: {times:?}, {all:?}");
            }
        }
    }

    #[test]
    fn a_surface_asks_what_shines_on_it() {
        let lights = lights();
        let chances = chances_of(&lights);
        let of = |light: usize, x: f32, y: f32| chances.of(Vec3::new(x, y, 0.0), light);
        let least = EVEN_SHARE / lights.len() as f32;
        // below the third lamp of the row, and below the last
        assert!(of(10, 6.0, 2.0) > 10.0 * of(16, 6.0, 2.0) && of(16, 24.0, 2.0) > 10.0 * of(10, 24.0, 2.0));
        // panels shine downwards, the spot within its cone
        for (light, [x, y]) in [(2, [1.0, 3.0]), (3, [1.0, 3.0]), (6, [3.0, 1.0]), (7, [0.5, 0.0])] {
            assert_eq!(of(light, x, y), least, "{light}");
        }
        assert!([2, 3, 6].iter().all(|light| of(*light, 1.0, 1.0) > 2.0 * least));
    }
}
