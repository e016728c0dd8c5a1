//! Motion blur and depth of field: the times and the points of the lens at which a frame is exposed.
//!
//! A frame is the mean of its *exposures*, the accumulation buffer of Haeberli and Akeley (1990): each is a
//! picture at one time within the shutter, from one point of the lens, through a window that is shifted by a
//! fraction of a cell. So the samples of a frame are spread evenly over shutter and lens in each pixel,
//! whichever of them are reused: every pixel has as many at each of the times and points.
//!
//! Times are the middles of equal parts of the shutter. Points of the lens lie on Vogel's spiral (1979), in
//! rings of equal area, and shifts of the window on a lattice by the golden ratio. A walk through each list
//! pairs points and shifts with times, chosen so that the three have the least correlation. All of it follows
//! from the number of exposures alone.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::stereo::EyePlace;

/// Largest number of exposures of a frame.
pub const MOST_EXPOSURES: u32 = 256;

/// Time in which the shutter is open, in frames from the frame's own time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Shutter {
    /// Opening time.
    pub open: f64,
    /// Closing time.
    pub close: f64,
}

impl Default for Shutter {
    /// Opens the shutter for half of the time from frame to frame (180 degrees), about the frame's own.
    fn default() -> Self {
        Self { open: -0.25, close: 0.25 }
    }
}

impl Shutter {
    /// Describes the error in the shutter's times, if there is one, and how to correct it.
    pub fn fault(&self) -> Option<String> {
        let Self { open, close } = *self;
        let within = |time: f64| (-1.0..=1.0).contains(&time);
        if !within(open) || !within(close) {
            return Some(format!(
                "the shutter is open from {open} to {close}: both are times from -1 to 1, in frames from the frame's own"
            ));
        }
        if close < open {
            return Some(format!(
                "the shutter closes at {close}, before it opens at {open}: give the earlier time as `open`"
            ));
        }
        (close - open > 1.0).then(|| {
            format!(
                "the shutter is open from {open} to {close}, longer than it takes to the next frame: at most 1 (360 degrees) may \
                 lie between"
            )
        })
    }
}

/// Time before a cut at which a take ends, in frames: enough for single and double floats to tell both apart
/// in the longest shots.
const JUST: f64 = 1e-6;

/// Moments at which a shot is seen, counted through all of its frames: as many of each frame as it has
/// different times.
#[derive(Debug, Clone, PartialEq)]
pub struct Clock {
    shutter: Shutter,
    /// Number of moments of a frame.
    per_frame: i64,
    /// Frames at which the shot cuts, rising: no frame is seen at a time of another take.
    cuts: Vec<i32>,
}

impl Clock {
    /// Clock with one moment a frame: its own time.
    pub const FRAMES: Self =
        Self { shutter: Shutter { open: 0.0, close: 0.0 }, per_frame: 1, cuts: Vec::new() };

    /// Number of moment `index` of `frame`, counted from 0; that of the last one, if it has fewer.
    pub fn moment(&self, frame: i32, index: usize) -> i64 {
        i64::from(frame) * self.per_frame + (index as i64).min(self.per_frame - 1)
    }

    /// Time of a moment, in frames.
    pub fn time(&self, moment: i64) -> f64 {
        let (frame, index) = (moment.div_euclid(self.per_frame), moment.rem_euclid(self.per_frame));
        let Shutter { open, close } = self.shutter;
        let within = (index as f64 + 0.5) / self.per_frame as f64;
        let time = frame as f64 + (open + (close - open) * within);
        let next = self.cuts.partition_point(|cut| i64::from(*cut) <= frame);
        let begin = next.checked_sub(1).map_or(f64::NEG_INFINITY, |last| f64::from(self.cuts[last]));
        let end = self.cuts.get(next).map_or(f64::INFINITY, |cut| f64::from(*cut) - JUST);
        time.clamp(begin, end)
    }

    /// First moment that is not before `time`.
    pub fn at_or_after(&self, time: f64) -> i64 {
        /// Frame beyond which there are no others.
        const FAR: f64 = 4e9;
        let around = time.clamp(-FAR, FAR).floor() as i64;
        // no moment is further than a frame from the time of its frame
        let (mut low, mut high) = ((around - 1) * self.per_frame, (around + 3) * self.per_frame);
        while low < high {
            let middle = (low + high).div_euclid(2);
            if self.time(middle) < time { low = middle + 1 } else { high = middle }
        }
        low
    }

    /// Last moment before `time`, or the first one at it.
    pub fn at_or_before(&self, time: f64) -> i64 {
        let next = self.at_or_after(time);
        if self.time(next) > time { next - 1 } else { next }
    }

    /// First and last moment of all frames that have numbers.
    pub fn bounds(&self) -> [i64; 2] {
        [self.moment(i32::MIN, 0), self.moment(i32::MAX, usize::MAX >> 1)]
    }
}

/// One exposure of each frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Point from which it sees the scene, in a lens of radius 1: to the right, and up.
    pub lens: [f64; 2],
    /// Shift of its window, in cells.
    pub shift: [f64; 2],
}

/// Exposures of each frame of a shot.
#[derive(Debug, Clone, PartialEq)]
pub struct Exposures {
    /// Moments of the exposures.
    pub clock: Clock,
    /// Exposures in the order of time.
    pub all: Vec<Exposure>,
}

impl Exposures {
    /// Creates `count` exposures, one at least, with a `shutter` if the shot has one; `cuts`: see [`Clock`].
    /// Windows are shifted if `shifts` is set.
    pub fn new(count: u32, shutter: Option<Shutter>, cuts: &[i32], shifts: bool) -> Self {
        let count = count.clamp(1, MOST_EXPOSURES) as usize;
        let shutter = shutter.unwrap_or(Shutter { open: 0.0, close: 0.0 });
        let per_frame = if shutter.close > shutter.open { count as i64 } else { 1 };
        let clock = Clock { shutter, per_frame, cuts: cuts.to_vec() };
        let (lens, windows) = (spiral(count), lattice(count));
        let [by_lens, by_window] = walks(&lens, &windows);
        let all = (0..count).map(|number| Exposure {
            lens: lens[by_lens.at(number, count)],
            shift: if shifts { windows[by_window.at(number, count)] } else { [0.0; 2] },
        });
        Self { clock, all: all.collect() }
    }

    /// One exposure at the frame's own time, through a pinhole.
    pub fn sharp() -> Self {
        Self::new(1, None, &[], false)
    }

    /// Number of the one in the middle of the shutter, near the centre of the lens.
    pub fn middle(&self) -> usize {
        self.all.len() / 2
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

/// Points of a disc of radius 1, from its centre outwards: in rings of equal area, a golden angle apart.
fn spiral(count: usize) -> Vec<[f64; 2]> {
    if count == 1 {
        return vec![[0.0; 2]];
    }
    let point = |number: usize| {
        let radius = ((number as f64 + 0.5) / count as f64).sqrt();
        let (up, right) = (number as f64 * (1.0 - GOLDEN) * TAU).sin_cos();
        [radius * right, radius * up]
    };
    (0..count).map(point).collect()
}

/// Golden ratio, less 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Points of a square of edge 1 about the origin, evenly spread; the first is near the origin.
fn lattice(count: usize) -> Vec<[f64; 2]> {
    let centred = |share: f64| (share + 0.5).rem_euclid(1.0) - 0.5;
    // an even number of points has none in the middle
    let first = if count % 2 == 0 { 0.5 } else { 0.0 };
    let point = |number: usize| {
        let x = (number as f64 + first) / count as f64;
        [centred(x), centred(number as f64 * GOLDEN)]
    };
    let points: Vec<[f64; 2]> = (0..count).map(point).collect();
    // their mean is the middle of the window
    let mean = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / count as f64);
    points.into_iter().map(|point| [point[0] - mean[0], point[1] - mean[1]]).collect()
}

/// Finds walks through both lists that give time, lens and window the least correlation: the greatest between
/// any two of their coordinates is minimized. The middle exposure gets the centre of the lens.
fn walks(lens: &[[f64; 2]], windows: &[[f64; 2]]) -> [Walk; 2] {
    /// Steps in which correlations are compared: nothing may depend on rounding.
    const EQUAL: f64 = 1e-6;
    /// Largest number of walks that are tried.
    const MOST_WAYS: usize = 512;
    let count = lens.len();
    let coordinates = |points: &[[f64; 2]], walk: Walk| -> Vec<Vec<f64>> {
        let at = |number: usize| points[walk.at(number, count)];
        let column = |of: fn([f64; 2]) -> f64| (0..count).map(|number| of(at(number))).collect();
        vec![column(|at| at[0]), column(|at| at[1]), column(|at| at[0] * at[0] + at[1] * at[1])]
    };
    let worst = |ones: &[Vec<f64>], others: &[Vec<f64>]| -> u64 {
        let pairs = ones.iter().flat_map(|one| others.iter().map(move |other| correlation(one, other).abs()));
        (pairs.fold(0.0, f64::max) / EQUAL).round() as u64
    };
    let steps = (1..=count).filter(|step| greatest_common_divisor(*step, count) == 1);
    let best = |points: &[[f64; 2]], beside: &[Vec<f64>], middles: usize| {
        let walks = steps.clone().flat_map(|step| (0..middles).map(move |middle| Walk { step, middle }));
        let best = walks.take(MOST_WAYS).min_by_key(|walk| worst(beside, &coordinates(points, *walk)));
        best.expect("1 has no divisor in common with anything")
    };
    let times = vec![(0..count).map(|number| number as f64).collect()];
    let by_lens = best(lens, &times, 1);
    let beside: Vec<Vec<f64>> = times.into_iter().chain(coordinates(lens, by_lens)).collect();
    [by_lens, best(windows, &beside, count.min(16))]
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

/// Lens at one time, in world units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensPose {
    /// Radius of the opening.
    pub radius: f64,
    /// Distance of the plane of focus along the view axis.
    pub focus: f64,
}

impl LensPose {
    /// Largest ratio of radius to focus distance: beyond it, no window is left before the lens.
    pub const WIDEST: f64 = 10.0;

    /// Message for a camera that has no place for a lens.
    pub const ORTHOGRAPHIC: &'static str = "goes with a perspective camera: lines of sight of an orthographic one do not meet in a lens; \
                                            leave `aperture` out";

    /// Place of the eye of `exposure` beside the camera, in a picture of `width` x `height` pixels of `cells`
    /// x `cells` cells.
    pub fn place(lens: Option<Self>, exposure: &Exposure, [width, height]: [u32; 2], cells: u32) -> EyePlace {
        let [width, height] = [width, height].map(f64::from);
        let Self { radius, focus } = lens.unwrap_or(Self { radius: 0.0, focus: 1.0 });
        let aside = exposure.lens.map(|at| at * radius);
        // between keys a curve may fall below the values that keys may have
        let focus = focus.max(radius / Self::WIDEST).max(f64::MIN_POSITIVE);
        let pixels = width.max(height) * f64::from(cells);
        EyePlace {
            aside,
            window: aside.map(|aside| -aside / focus),
            longer: (width / height).max(1.0),
            shift: exposure.shift.map(|cells| cells / pixels),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNTS: [u32; 12] = [1, 2, 3, 4, 5, 8, 12, 16, 31, 32, 64, 256];

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
    fn times_are_the_middles_of_equal_parts_of_the_shutter() {
        let shutter = Shutter { open: -0.25, close: 0.75 };
        for count in COUNTS {
            let Exposures { clock, all } = Exposures::new(count, Some(shutter), &[], true);
            for (index, frame) in (0..all.len()).flat_map(|index| [-7, 0, 12].map(|frame| (index, frame))) {
                let expected = f64::from(frame) - 0.25 + (index as f64 + 0.5) / f64::from(count);
                assert!((clock.time(clock.moment(frame, index)) - expected).abs() < 1e-12);
            }
            assert_eq!(clock.moment(3, 0) + i64::from(count), clock.moment(4, 0));
        }
        let frames = Exposures::new(16, None, &[], true);
        assert_eq!((frames.clock.moment(5, 9), frames.clock.time(5)), (5, 5.0));
    }

    #[test]
    fn lens_and_window_are_covered_evenly() {
        for count in COUNTS {
            let all = Exposures::new(count, None, &[], true).all;
            let rings = all.iter().map(|one| one.lens[0].powi(2) + one.lens[1].powi(2));
            // one of each ring of equal area
            assert!(count == 1 || worst_share(rings, count as usize) == 0.0, "{count}");
            let sectors = all.iter().map(|one| (one.lens[1].atan2(one.lens[0]) / TAU).rem_euclid(1.0));
            assert!(count < 4 || worst_share(sectors, 4) <= 1.0 + f64::from(count) / 16.0, "{count}");
            let mean = |axis: usize| all.iter().map(|one| one.lens[axis]).sum::<f64>() / f64::from(count);
            let off = glam::DVec2::new(mean(0), mean(1)).length();
            assert!(off < 0.5 / f64::from(count).sqrt(), "{count}: {off}");
            for axis in [0, 1] {
                let shifts = || all.iter().map(|one| one.shift[axis]);
                let sum: f64 = shifts().sum();
                assert!(sum.abs() < 1e-9 && shifts().all(|shift| shift.abs() <= 0.75), "{count}");
                let spread = shifts().map(|shift| shift * shift).sum::<f64>() / f64::from(count);
                // that of a cell is 1/12
                assert!(count < 8 || (spread - 1.0 / 12.0).abs() < 0.02, "{count}: {spread}");
            }
        }
    }

    #[test]
    fn time_lens_and_window_have_little_to_do_with_each_other() {
        for count in COUNTS.into_iter().filter(|count| *count >= 8) {
            let all = Exposures::new(count, Some(Shutter::default()), &[], true).all;
            let times: Vec<f64> = (0..count).map(f64::from).collect();
            let column = |of: fn(&Exposure) -> f64| all.iter().map(of).collect::<Vec<f64>>();
            let lens = [column(|one| one.lens[0]), column(|one| one.lens[1])];
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
        for count in COUNTS {
            let exposures = Exposures::new(count, Some(Shutter::default()), &[], true);
            let middle = exposures.all[exposures.middle()];
            let time = exposures.clock.time(exposures.clock.moment(0, exposures.middle()));
            assert!(time.abs() <= 0.25 / f64::from(count) + 1e-12, "{count}");
            let least = (0.5 / f64::from(count)).sqrt();
            assert!(glam::DVec2::from(middle.lens).length() <= least + 1e-12, "{count}");
        }
        let one = Exposures::new(1, Some(Shutter::default()), &[], true);
        assert_eq!(one.all, [Exposure { lens: [0.0; 2], shift: [0.0; 2] }]);
    }

    #[test]
    fn no_time_is_that_of_another_take() {
        let shutter = Shutter { open: -0.5, close: 0.5 };
        let clock = Exposures::new(4, Some(shutter), &[3, 8], false).clock;
        let times = |frame| [0, 1, 2, 3].map(|index| clock.time(clock.moment(frame, index)));
        assert_eq!(times(3), [3.0, 3.0, 3.125, 3.375]);
        assert_eq!(times(7)[..2], [6.625, 6.875]);
        assert!(times(7)[2..].iter().all(|time| *time < 8.0) && times(8)[0] == 8.0);
        let moments = (clock.moment(-2, 0)..clock.moment(12, 0)).map(|moment| clock.time(moment));
        let moments: Vec<f64> = moments.collect();
        assert!(moments.is_sorted());
    }

    #[test]
    fn moments_are_found_by_their_times() {
        let clocks = [
            Clock::FRAMES,
            Exposures::new(16, Some(Shutter { open: -1.0, close: 0.0 }), &[2], false).clock,
            Exposures::new(5, Some(Shutter { open: 0.25, close: 0.5 }), &[], false).clock,
        ];
        for clock in clocks {
            for time in (-40..80).map(|time| f64::from(time) * 0.125).chain([1e9 + 0.25]) {
                let [first, last] = [clock.at_or_after(time), clock.at_or_before(time)];
                assert!(clock.time(first) >= time && clock.time(first - 1) < time, "{time}");
                assert!(clock.time(last) == time || clock.time(last) < time && clock.time(last + 1) > time);
            }
            assert!(clock.at_or_after(f64::INFINITY) > clock.bounds()[1]);
            assert!(clock.at_or_after(f64::NEG_INFINITY) < clock.bounds()[0]);
        }
    }

    #[test]
    fn wrong_shutters_are_told() {
        let fault = |open, close| Shutter { open, close }.fault();
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
        for exposure in Exposures::new(16, None, &[], false).all {
            for size in [[200, 100], [100, 200]] {
                let place = LensPose::place(Some(lens), &exposure, size, 2);
                let half_height = 0.5;
                let longer = 4.0 * f64::max(f64::from(size[0]) / f64::from(size[1]), 1.0);
                let shift = place.shift(half_height);
                for axis in [0, 1] {
                    let middle = place.aside[axis] + shift[axis] * longer;
                    assert!(middle.abs() < 1e-12, "{size:?}: {middle}");
                }
            }
        }
        let moved = Exposure { lens: [0.0; 2], shift: [0.5, -0.25] };
        let place = LensPose::place(None, &moved, [200, 100], 2);
        assert_eq!((place.aside, place.shift(1.0)), ([0.0; 2], [0.5 / 400.0, -0.25 / 400.0]));
    }
}
