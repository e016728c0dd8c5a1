//! Motion blur and depth of field: the times and the points of the lens at which a frame is exposed.
//!
//! A frame is the mean of its *exposures*, the accumulation buffer of Haeberli and Akeley (1990): each is a
//! picture at one time within the shutter, from one point of the lens. Exposures divide the samples of a pixel
//! among them ([`Strata`]): of N x N cells each has every K-th in every K-th row, which is a grid of its own with
//! cells that are K times as wide and a window that is shifted by a fraction of one. So a blurred frame has as
//! many samples as a sharp one, in the same places, and they are spread evenly over shutter and lens in each
//! pixel, whichever of them are reused.
//!
//! ```text
//! N = 4, K = 2   a b a b      N = 4, K = 4   a b c d      a letter: an exposure
//!                c d c d                     e f g h
//!                a b a b                     i j k l
//!                c d c d                     m n o p
//! ```
//!
//! Each exposure has an equal part of the [shutter](Shutter), equal by the light that it lets in, and of the lens, and its samples are spread over both: a
//! part has [`TICKS`] moments, each with a point of the lens, and each cell has one of them, so that
//! neighbours see others (Cook, Porter and Carpenter, "Distributed Ray Tracing", 1984). So what moves
//! leaves a ramp and no steps, and what is out of focus a disc and no points. A walk through the parts of the lens, and
//! one through the places in the pixel, pairs them with times, chosen so that the three have the least
//! correlation. All of it follows from the number of exposures alone.

mod lens;
mod shutter;

use lens::lens_parts;
pub use lens::{LensPart, LensPose};
pub use shutter::{Curve, Shutter};

/// Largest number of exposures of a frame: one for each sample of a pixel.
pub const MOST_EXPOSURES: u32 = 256;

/// Number of moments, and of points of the lens, of an exposure: a power of two, so that they are exact shares of its time.
pub const TICKS: usize = 16;

/// Number of one of an exposure's [`TICKS`].
pub type Tick = u8;

/// The tick in the middle of an exposure, for what has none of its own.
pub const MIDDLE_TICK: Tick = TICKS as Tick / 2;

/// Division of a pixel's samples among exposures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Strata {
    /// K: there are K x K exposures, and each has every K-th cell across and down.
    pub across: u32,
}

impl Strata {
    /// All samples are of one exposure.
    pub const ONE: Self = Self { across: 1 };

    /// Division of `samples` x `samples` into `exposures` at most: the most that divide them evenly. Where
    /// none do but one, although more than one is asked for, the fewest there are instead.
    pub fn new(samples: u32, exposures: u32) -> Self {
        let divisors = || (2..=samples).filter(|across| samples % across == 0);
        let fits = |across: &u32| across * across <= exposures;
        let across = divisors().rfind(fits).or_else(|| divisors().find(|_| exposures > 1));
        Self { across: across.unwrap_or(1) }
    }

    /// Number of exposures.
    pub fn count(self) -> u32 {
        self.across * self.across
    }
}

/// Time before a cut at which a take ends, in frames: enough for single and double floats to tell both apart
/// in the longest shots.
const JUST: f64 = 1e-6;

/// Number of equal parts of a moment's light whose times are known: two for each tick.
const PARTS: usize = 2 * TICKS;

/// Moments at which a shot is seen, one a frame, with the frame's number.
#[derive(Debug, Clone, PartialEq)]
pub struct Clock {
    /// Times from a frame's own, in frames from -1 to 1, between equal parts of the light that comes in during a moment.
    after: [f64; PARTS + 1],
    /// Frames at which the shot cuts, rising: no frame is seen at a time of another take.
    cuts: Vec<i32>,
}

impl Clock {
    /// Clock that sees each frame at its own time.
    pub const FRAMES: Self = Self { after: [0.0; PARTS + 1], cuts: Vec::new() };

    /// Time of a moment, in frames.
    pub fn time(&self, moment: i64) -> f64 {
        self.time_within(moment, 0.5)
    }

    /// Time of one of the ticks about a moment, in frames.
    pub fn time_of_tick(&self, moment: i64, tick: Tick) -> f64 {
        self.time_within(moment, (f64::from(tick) + 0.5) / TICKS as f64)
    }

    /// Time within a moment's part of the shutter, when a `share` of its light has come in.
    pub fn time_within(&self, moment: i64, share: f64) -> f64 {
        // shares of ticks, and of groups of them, are among the parts
        let part = (share * PARTS as f64).clamp(0.0, PARTS as f64);
        let (before, after) = (self.after[part.floor() as usize], self.after[part.ceil() as usize]);
        let time = moment as f64 + before + (after - before) * part.fract();
        let next = self.cuts.partition_point(|cut| i64::from(*cut) <= moment);
        let begin = next.checked_sub(1).map_or(f64::NEG_INFINITY, |last| f64::from(self.cuts[last]));
        let end = self.cuts.get(next).map_or(f64::INFINITY, |cut| f64::from(*cut) - JUST);
        time.clamp(begin, end)
    }

    /// True if the shutter is closed at once: no moment has any length.
    pub fn is_instant(&self) -> bool {
        self.after[0] == self.after[PARTS]
    }

    /// First moment of which a `share` is not over before `time`.
    pub fn at_or_after(&self, time: f64, share: f64) -> i64 {
        /// Frame beyond which there are no others.
        const FAR: f64 = 4e9;
        let around = time.clamp(-FAR, FAR).floor() as i64;
        // no moment is further than a frame from the time of its frame
        let (mut low, mut high) = (around - 1, around + 3);
        while low < high {
            let middle = (low + high).div_euclid(2);
            if self.time_within(middle, share) < time { low = middle + 1 } else { high = middle }
        }
        low
    }

    /// Last moment of which a `share` is over before `time`, or the first one at it.
    pub fn at_or_before(&self, time: f64, share: f64) -> i64 {
        let next = self.at_or_after(time, share);
        if self.time_within(next, share) > time { next - 1 } else { next }
    }

    /// First and last moment of all frames that have numbers.
    pub fn bounds() -> [i64; 2] {
        [i32::MIN, i32::MAX].map(i64::from)
    }
}

/// One exposure of each frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Part of the lens through which it sees the scene.
    pub lens: LensPart,
    /// Place of its first sample among those of the pixel: column from the left, and row from the top.
    pub stratum: [u32; 2],
    /// Shift of its window, in its own cells: to the right, and up.
    pub shift: [f64; 2],
}

/// Exposures of each frame of a shot.
#[derive(Debug, Clone, PartialEq)]
pub struct Exposures {
    /// Division of the samples among them.
    pub strata: Strata,
    /// Moments of the exposures: one clock for each, or one for all.
    clocks: Vec<Clock>,
    /// Exposures in the order of time.
    pub all: Vec<Exposure>,
}

impl Exposures {
    /// Creates the exposures of `strata`, with a `shutter` if the shot has one; `cuts`: see [`Clock`].
    pub fn new(strata: Strata, shutter: Option<&Shutter>, cuts: &[i32]) -> Self {
        let count = strata.count() as usize;
        let closed = Shutter::new(0.0, 0.0);
        let shutter = shutter.unwrap_or(&closed);
        let clocks = if shutter.is_open() { count } else { 1 };
        let clock = |number: usize| {
            let within = |part: usize| (number as f64 + part as f64 / PARTS as f64) / clocks as f64;
            Clock { after: std::array::from_fn(|part| shutter.time_of(within(part))), cuts: cuts.to_vec() }
        };
        let (lens, windows) = (lens_parts(strata), lattice(strata));
        let middles: Vec<[f64; 2]> = lens.iter().map(LensPart::middle).collect();
        let [by_lens, by_window] = walks(&middles, &windows, strata);
        let all = (0..count).map(|number| {
            let at = by_window.at(number, count);
            let stratum = [at as u32 % strata.across, at as u32 / strata.across];
            Exposure { lens: lens[by_lens.at(number, count)], stratum, shift: windows[at] }
        });
        Self { strata, clocks: (0..clocks).map(clock).collect(), all: all.collect() }
    }

    /// One exposure at the frame's own time, through a pinhole.
    pub fn sharp() -> Self {
        Self::new(Strata::ONE, None, &[])
    }

    /// Number of the one in the middle of the shutter, near the centre of the lens.
    pub fn middle(&self) -> usize {
        self.all.len() / 2
    }

    /// Clocks that differ: one for each exposure, or one for all of them.
    pub fn clocks(&self) -> &[Clock] {
        &self.clocks
    }

    /// Clock of exposure number `index`.
    pub fn clock(&self, index: usize) -> &Clock {
        &self.clocks[self.clock_of(index)]
    }

    /// Number of the clock of exposure number `index`.
    pub fn clock_of(&self, index: usize) -> usize {
        index.min(self.clocks.len() - 1)
    }

    /// Time of exposure number `index` of a frame, in frames: of one of its ticks, or else of its middle.
    pub fn time(&self, frame: i32, index: usize, tick: Option<Tick>) -> f64 {
        let clock = self.clock(index);
        match tick {
            Some(tick) => clock.time_of_tick(frame.into(), tick),
            None => clock.time(frame.into()),
        }
    }

    /// Point of the lens of exposure number `index`, of radius 1: at one of its ticks, or else in its middle.
    pub fn lens(&self, index: usize, tick: Option<Tick>) -> [f64; 2] {
        let part = self.all[index].lens;
        tick.map_or_else(|| part.middle(), |tick| part.at_tick(tick))
    }
}

/// A walk through a list that visits each of its entries once.
#[derive(Debug, Clone, Copy)]
struct Walk {
    /// Step from one exposure to the next; it has no divisor in common with the length of the list.
    step: usize,
    /// Index of the entry for the middle exposure.
    middle: usize,
}

impl Walk {
    /// Index, in a list of `count`, of the entry for exposure `number`.
    fn at(self, number: usize, count: usize) -> usize {
        ((number + count - count / 2) * self.step + self.middle) % count
    }
}

/// Golden ratio, less 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Shifts of the windows of all strata, rows from the top: in cells, to the right and up. Their mean is 0.
fn lattice(Strata { across }: Strata) -> Vec<[f64; 2]> {
    let centred = |place: u32| (f64::from(place) + 0.5) / f64::from(across) - 0.5;
    let of_row = |row: u32| (0..across).map(move |column| [centred(column), -centred(row)]);
    (0..across).flat_map(of_row).collect()
}

/// Finds walks through both lists that give time, lens and window the least correlation: the greatest between
/// any two of their coordinates is minimized. The middle exposure gets the centre of the lens. In windows each
/// step goes on by about the golden ratio of the columns, and of the rows: from column to column, window and
/// edges that move would go along with each other.
fn walks(lens: &[[f64; 2]], windows: &[[f64; 2]], Strata { across }: Strata) -> [Walk; 2] {
    /// Steps in which correlations are compared: nothing may depend on rounding.
    const EQUAL: f64 = 1e-6;
    /// Largest number of walks that are tried.
    const MOST_WAYS: usize = 512;
    let (count, across) = (lens.len(), across as usize);
    let coordinates = |points: &[[f64; 2]], walk: Walk| -> Vec<Vec<f64>> {
        let at = |number: usize| points[walk.at(number, count)];
        let column = |of: fn([f64; 2]) -> f64| (0..count).map(|number| of(at(number))).collect();
        vec![column(|at| at[0]), column(|at| at[1]), column(|at| at[0] * at[0] + at[1] * at[1])]
    };
    let worst = |ones: &[Vec<f64>], others: &[Vec<f64>]| -> u64 {
        let pairs = ones.iter().flat_map(|one| others.iter().map(move |other| correlation(one, other).abs()));
        (pairs.fold(0.0, f64::max) / EQUAL).round() as u64
    };
    let best = |points: &[[f64; 2]], beside: &[Vec<f64>], walks: &mut dyn Iterator<Item = Walk>| {
        let best = walks.take(MOST_WAYS).min_by_key(|walk| worst(beside, &coordinates(points, *walk)));
        best.expect("there is a walk by steps of 1")
    };
    let nearest = |steps: &mut dyn Iterator<Item = usize>, to: usize| {
        let off = |step: &usize| ((*step as f64 - GOLDEN * to as f64).abs() / EQUAL).round() as u64;
        steps.min_by_key(off).expect("1 has no divisor in common with anything")
    };
    let is_free = |step: &usize, of: usize| greatest_common_divisor(*step, of) == 1;
    let columns = nearest(&mut (1..=across).filter(|step| is_free(step, across)), across);
    let step = nearest(&mut (1..=count).filter(|step| step % across == columns % across), count);
    let times = vec![(0..count).map(|number| number as f64).collect()];
    let by_window = best(windows, &times, &mut (0..count.min(16)).map(|middle| Walk { step, middle }));
    let beside: Vec<Vec<f64>> = times.into_iter().chain(coordinates(windows, by_window)).collect();
    let steps = (1..=count).filter(|step| is_free(step, count));
    [best(lens, &beside, &mut steps.map(|step| Walk { step, middle: 0 })), by_window]
}

fn greatest_common_divisor(one: usize, other: usize) -> usize {
    if other == 0 { one } else { greatest_common_divisor(other, one % other) }
}

/// Pearson's correlation; 0 where either is constant.
fn correlation(ones: &[f64], others: &[f64]) -> f64 {
    let count = ones.len() as f64;
    let [mean, other_mean] = [ones, others].map(|all| all.iter().sum::<f64>() / count);
    let (mut both, mut own, mut other) = (0.0, 0.0, 0.0);
    for (a, b) in ones.iter().zip(others) {
        let (a, b) = (a - mean, b - other_mean);
        (both, own, other) = (both + a * b, own + a * a, other + b * b);
    }
    if own * other > 0.0 { both / (own * other).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const ALL: [Strata; 16] = {
        let mut all = [Strata::ONE; 16];
        let mut number = 0;
        while number < 16 {
            all[number].across = number as u32 + 1;
            number += 1;
        }
        all
    };

    fn length([x, y]: [f64; 2]) -> f64 {
        (x * x + y * y).sqrt()
    }

    /// Largest error of the share of `values` in each of `parts` equal parts of the unit interval, in numbers
    /// of values.
    fn worst_share(values: impl Iterator<Item = f64>, parts: usize) -> f64 {
        let mut counts = vec![0.0; parts];
        let values: Vec<f64> = values.collect();
        values.iter().for_each(|value| counts[(value * parts as f64) as usize] += 1.0);
        let share = values.len() as f64 / parts as f64;
        counts.iter().map(|count| (count - share).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn exposures_divide_samples() {
        let across = |samples, exposures| Strata::new(samples, exposures).across;
        assert_eq!(
            [1, 2, 3, 4, 5, 6, 7, 8, 12, 16].map(|samples| across(samples, 16)),
            [1, 2, 3, 4, 5, 3, 7, 4, 4, 4]
        );
        assert_eq!([1, 2, 3, 4, 9, 16, 63, 64, 256].map(|most| across(8, most)), [1, 2, 2, 2, 2, 4, 4, 8, 8]);
        for (samples, exposures) in (1..=16).flat_map(|samples| (1..=256).map(move |most| (samples, most))) {
            let strata = Strata::new(samples, exposures);
            assert!(samples % strata.across == 0 && (strata == Strata::ONE || exposures > 1));
            let fewest = (2..=samples).find(|across| samples % across == 0);
            assert!(strata.count() <= exposures || Some(strata.across) == fewest);
        }
    }

    #[test]
    fn times_are_the_middles_of_equal_parts_of_the_shutter() {
        let shutter = Shutter::new(-0.25, 0.75);
        for strata in ALL {
            let exposures = Exposures::new(strata, Some(&shutter), &[]);
            let count = exposures.all.len();
            for (index, frame) in (0..count).flat_map(|index| [-7, 0, 12].map(|frame| (index, frame))) {
                let expected = f64::from(frame) - 0.25 + (index as f64 + 0.5) / count as f64;
                assert!((exposures.time(frame, index, None) - expected).abs() < 1e-12);
            }
        }
        let frames = Exposures::new(Strata { across: 4 }, None, &[]);
        assert_eq!((frames.clocks(), frames.time(5, 9, Some(3))), (&[Clock::FRAMES][..], 5.0));
    }

    /// The places of all exposures' samples are those of a sharp frame, each once.
    #[test]
    fn strata_are_all_cells_of_a_sharp_frame() {
        for (strata, own) in ALL.into_iter().flat_map(|strata| [1, 2, 3].map(|own| (strata, own))) {
            let Strata { across } = strata;
            let samples = across * own;
            let mut seen = vec![false; (samples * samples) as usize];
            for exposure in Exposures::new(strata, None, &[]).all {
                let Exposure { stratum: [left, top], shift: [right, up], .. } = exposure;
                for (x, y) in (0..own).flat_map(|y| (0..own).map(move |x| (x, y))) {
                    let [x_of_all, y_of_all] = [x * across + left, y * across + top];
                    seen[(y_of_all * samples + x_of_all) as usize] = true;
                    let (x, y) = (f64::from(x) + 0.5 + right, f64::from(y) + 0.5 - up);
                    let [x, y] = [x, y].map(|at| at * f64::from(across) - 0.5);
                    assert!((x - f64::from(x_of_all)).abs() < 1e-9 && (y - f64::from(y_of_all)).abs() < 1e-9);
                }
            }
            assert!(seen.into_iter().all(|seen| seen), "{strata:?} of {own}x{own}");
        }
    }

    /// Each exposure's ticks go evenly over its part of the shutter, and those of all over the whole of it.
    #[test]
    fn steps_are_the_middles_of_equal_parts_of_an_exposure() {
        for strata in ALL {
            let exposures = Exposures::new(strata, Some(&Shutter::new(-0.5, 0.25)), &[]);
            let all =
                (0..exposures.all.len()).flat_map(|index| (0..TICKS as Tick).map(move |tick| (index, tick)));
            for (number, (index, tick)) in all.enumerate() {
                let share = (number as f64 + 0.5) / (exposures.all.len() * TICKS) as f64;
                let expected = 7.0 - 0.5 + 0.75 * share;
                assert!((exposures.time(7, index, Some(tick)) - expected).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_lens_is_covered_evenly() {
        for strata in ALL {
            let all = Exposures::new(strata, None, &[]).all;
            let points: Vec<[f64; 2]> = (0..TICKS as Tick)
                .flat_map(|tick| all.iter().map(move |one| one.lens.at_tick(tick)))
                .collect();
            let count = points.len() as f64;
            let rings = points.iter().map(|[x, y]| (x * x + y * y).min(0.999));
            // sixteen points alone are a net in the square, and less of one in rings
            assert!(worst_share(rings, 4) <= f64::max(0.1 * count, 4.0), "{strata:?}");
            let sectors = points.iter().map(|[x, y]| (y.atan2(*x) / TAU).rem_euclid(1.0));
            assert!(worst_share(sectors, 4) < 1e-9, "{strata:?}");
            let mean = [0, 1].map(|axis| points.iter().map(|at| at[axis]).sum::<f64>() / count);
            assert!(length(mean) < 0.5 / count.sqrt(), "{strata:?}: {mean:?}");
        }
    }

    /// Whatever the shares of a part's time and of its lens, each box with a volume of a tick has one.
    #[test]
    fn steps_are_a_net_in_time_and_lens() {
        let part = LensPart { corner: [0.0; 2], edge: 1.0 };
        let of_square = |tick: Tick| {
            // back from the disc to the square
            let [x, y] = part.at_tick(tick);
            let (radius, angle) = (length([x, y]), y.atan2(x).rem_euclid(TAU) * 8.0 / TAU);
            let [x, y] = match (angle + 1.0).rem_euclid(8.0) {
                0.0..2.0 => [radius, radius * ((angle + 1.0).rem_euclid(8.0) - 1.0)],
                2.0..4.0 => [radius * (2.0 - angle), radius],
                4.0..6.0 => [-radius, radius * (4.0 - angle)],
                _ => [radius * (angle - 6.0), -radius],
            };
            [x, y].map(|at| (at + 1.0) / 2.0)
        };
        let points: Vec<[f64; 3]> = (0..TICKS as Tick)
            .map(|tick| {
                let [x, y] = of_square(tick);
                [(f64::from(tick) + 0.5) / TICKS as f64, x, y]
            })
            .collect();
        for (a, b) in (0..=4_u32).flat_map(|a| (0..=4 - a).map(move |b| (a, b))) {
            let boxes = [a, b, 4 - a - b].map(|bits| f64::from(1_u32 << bits));
            let mut seen: Vec<[u32; 3]> =
                points.iter().map(|at| [0, 1, 2].map(|axis| (at[axis] * boxes[axis]) as u32)).collect();
            seen.sort_unstable();
            seen.dedup();
            assert_eq!(seen.len(), TICKS, "{boxes:?}: {points:?}");
        }
    }

    #[test]
    fn time_lens_and_window_have_little_to_do_with_each_other() {
        for strata in ALL.into_iter().filter(|strata| strata.across >= 3) {
            let (all, count) = (Exposures::new(strata, Some(&Shutter::default()), &[]).all, strata.count());
            let times: Vec<f64> = (0..count).map(f64::from).collect();
            let column = |of: fn(&Exposure) -> f64| all.iter().map(of).collect::<Vec<f64>>();
            let lens = [column(|one| one.lens.middle()[0]), column(|one| one.lens.middle()[1])];
            let shifts = [column(|one| one.shift[0]), column(|one| one.shift[1])];
            for (one, other) in lens
                .iter()
                .chain(&shifts)
                .map(|column| (&times, column))
                .chain(lens.iter().flat_map(|lens| shifts.iter().map(move |shift| (lens, shift))))
            {
                let correlation = correlation(one, other);
                let most = if count < 16 { 0.6 } else { 0.4 };
                assert!(correlation.abs() < most, "{count}: {correlation}");
            }
        }
    }

    #[test]
    fn the_middle_one_is_near_the_middle_of_everything() {
        for strata in ALL {
            let (exposures, count) =
                (Exposures::new(strata, Some(&Shutter::default()), &[]), f64::from(strata.count()));
            let middle = exposures.all[exposures.middle()];
            assert!(exposures.time(0, exposures.middle(), None).abs() <= 0.25 / count + 1e-12, "{count}");
            // of an even number of parts none is in the middle
            let [x, y] = middle.lens.middle();
            assert!(length([x, y]) <= (1.0 / count).sqrt() + 1e-12, "{count}");
        }
        let one = Exposures::new(Strata::ONE, Some(&Shutter::default()), &[]);
        let [Exposure { lens, stratum, shift }] = one.all[..] else { panic!("{one:?}") };
        assert_eq!((lens.middle(), stratum, shift), ([0.0; 2], [0; 2], [0.0; 2]));
    }

    #[test]
    fn no_time_is_that_of_another_take() {
        let shutter = Shutter::new(-0.5, 0.5);
        let exposures = Exposures::new(Strata { across: 2 }, Some(&shutter), &[3, 8]);
        let times = |frame| [0, 1, 2, 3].map(|index| exposures.time(frame, index, None));
        assert_eq!(times(3), [3.0, 3.0, 3.125, 3.375]);
        assert_eq!(times(7)[..2], [6.625, 6.875]);
        assert!(times(7)[2..].iter().all(|time| *time < 8.0) && times(8)[0] == 8.0);
        let all: Vec<f64> = (-2..12).flat_map(times).collect();
        assert!(all.is_sorted());
    }

    #[test]
    fn moments_are_found_by_their_times() {
        let clocks = |across, open, close, cuts: &[i32]| {
            Exposures::new(Strata { across }, Some(&Shutter::new(open, close)), cuts).clocks
        };
        let all = [vec![Clock::FRAMES], clocks(4, -1.0, 0.0, &[2]), clocks(2, 0.25, 0.5, &[])];
        for clock in all.into_iter().flatten() {
            for time in (-40..80).map(|time| f64::from(time) * 0.125).chain([1e9 + 0.25]) {
                for share in [0.0, 0.5, 1.0] {
                    let at = |moment| clock.time_within(moment, share);
                    let [first, last] = [clock.at_or_after(time, share), clock.at_or_before(time, share)];
                    assert!(at(first) >= time && at(first - 1) < time, "{time}");
                    assert!(at(last) == time || at(last) < time && at(last + 1) > time);
                }
            }
            assert!(clock.at_or_after(f64::INFINITY, 0.5) > Clock::bounds()[1]);
            assert!(clock.at_or_after(f64::NEG_INFINITY, 0.5) < Clock::bounds()[0]);
        }
    }

    #[test]
    fn wrong_shutters_are_told() {
        let fault = |open, close| Shutter::new(open, close).fault();
        for (open, close) in [(-0.25, 0.25), (0.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.5, 0.5)] {
            assert_eq!(fault(open, close), None);
        }
        for (open, close, word) in [
            (0.25, -0.25, "before it opens"),
            (-0.6, 0.6, "longer"),
            (0.0, 1.5, "from -1 to 1"),
            (f64::NAN, 0.0, "from -1 to 1"),
            (0.0, f64::INFINITY, "from -1 to 1"),
        ] {
            let fault = fault(open, close).expect(word);
            assert!(fault.contains(word), "{fault}");
        }
    }

    #[test]
    fn every_point_of_the_lens_shows_one_rectangle_where_it_is_focused() {
        let lens = LensPose { radius: 0.5, focus: 4.0 };
        let exposures = Exposures::new(Strata { across: 4 }, None, &[]);
        let all =
            (0..exposures.all.len()).flat_map(|index| [None, Some(0), Some(11)].map(|tick| (index, tick)));
        for (index, tick) in all {
            for size in [[200, 100], [100, 200]] {
                let place = LensPose::place(Some(lens), (exposures.lens(index, tick), [0.0; 2]), (size, 2));
                let half_height = 0.5;
                let longer = 4.0 * f64::max(f64::from(size[0]) / f64::from(size[1]), 1.0);
                let shift = place.shift(half_height);
                for axis in [0, 1] {
                    let middle = place.aside[axis] + shift[axis] * longer;
                    assert!(middle.abs() < 1e-12, "{size:?}: {middle}");
                }
            }
        }
        let place = LensPose::place(None, ([0.0; 2], [0.5, -0.25]), ([200, 100], 2));
        assert_eq!((place.aside, place.shift(1.0)), ([0.0; 2], [0.5 / 400.0, -0.25 / 400.0]));
    }
}
