//! Sources that are weighed one by one, eight at a time.

use glam::Vec3;

use super::source::{Aim, Source};
use crate::cumulative::BELOW_ONE;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};

/// Least reach of a source: the square of its reciprocal is finite.
const LEAST_REACH: f32 = 1e-15;

/// Share of the questions that is spread evenly over all sources.
pub(super) const EVEN_SHARE: f32 = 0.25;

/// Sources of which one is chosen by what each may send.
#[derive(Debug, Clone, Default)]
pub(super) struct Level {
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

impl Level {
    /// Weighs these sources.
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

    /// [Chooses](Self::choose) a source; `sent` is what was known of the last surface, often the same.
    pub fn choose_again(&self, point: Vec3, random: f32, sent: &mut Sent) -> Chosen {
        if self.count < 2 {
            return Chosen { source: 0, chance: 1.0, rest: random };
        }
        if self.count > Sent::MOST {
            return self.choose(point, random);
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
