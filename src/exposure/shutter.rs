//! The shutter: when it is open, and how far.

use std::fmt;

use serde::Serialize;

/// Time in which the shutter is open, in frames from the frame's own time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shutter {
    /// Opening time.
    pub open: f64,
    /// Closing time.
    pub close: f64,
    /// How far it is open meanwhile.
    #[serde(skip_serializing_if = "Curve::is_constant")]
    pub curve: Curve,
}

impl Default for Shutter {
    /// Opens the shutter for half of the time from frame to frame (180 degrees), about the frame's own.
    fn default() -> Self {
        Self::new(-0.25, 0.25)
    }
}

/// As `a shutter from -0.25 to 0.25`.
impl fmt::Display for Shutter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { open, close, curve } = self;
        write!(f, "a shutter from {open} to {close}")?;
        if curve.is_constant() { Ok(()) } else { write!(f, " with a curve of {} points", curve.points.len()) }
    }
}

impl Shutter {
    /// Shutter that is all open from one time to the other.
    pub const fn new(open: f64, close: f64) -> Self {
        Self { open, close, curve: Curve::CONSTANT }
    }

    /// Returns true if it is open for any time at all.
    pub fn is_open(&self) -> bool {
        self.close > self.open
    }

    /// Time by which a share of the light has come in, in frames from the frame's own time.
    pub fn time_of(&self, share: f64) -> f64 {
        self.open + (self.close - self.open) * self.curve.time_of(share)
    }

    /// Describes the error in the shutter's times, if there is one, and how to correct it.
    pub fn fault(&self) -> Option<String> {
        let Self { open, close, .. } = *self;
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

/// How far a shutter is open over its time: goes straight from point to point.
///
/// All exposures of a frame count alike. So their times lie closer together the further the shutter is open: at equal steps of the
/// light that has come in.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Curve {
    /// Times, 0 when the shutter opens and 1 when it closes, rising, and how far it is open then, 0 to 1. Before the first and after
    /// the last one it is as far open as there. None: it is always all open.
    points: Vec<[f64; 2]>,
}

impl Curve {
    /// The shutter is always all open.
    pub const CONSTANT: Self = Self { points: Vec::new() };

    /// Creates the curve through `points`, pairs of time and openness. Where two points have one time the shutter jumps.
    ///
    /// # Errors If this is no curve, a description and how to correct it.
    pub fn through(points: Vec<[f64; 2]>) -> Result<Self, String> {
        const LIKE: &str =
            "pairs of a time and how far the shutter is open then, such as [[0, 0], [0.5, 1], [1, 0]]";
        if points.len() < 2 {
            return Err(format!(
                "needs two points or more, {LIKE}; leave it out for a shutter that is always all open"
            ));
        }
        let within = |value: &f64| (0.0..=1.0).contains(value);
        if let Some([time, openness]) = points.iter().find(|point| !point.iter().all(within)) {
            return Err(format!(
                "has the point [{time}, {openness}]: times are from 0, when the shutter opens, to 1, when it closes, and it is open \
                 from 0, not at all, to 1"
            ));
        }
        if let Some(pair) = points.windows(2).find(|pair| pair[0][0] > pair[1][0]) {
            let [[before, _], [time, _]] = [pair[0], pair[1]];
            return Err(format!(
                "goes back from the time {before} to {time}: give its points in the order of time"
            ));
        }
        let curve = Self { points };
        if curve.pieces().map(Piece::light).sum::<f64>() <= 0.0 {
            return Err(String::from("never opens the shutter: let it be more than 0 somewhere"));
        }
        // what is open alike all the time is open as ever
        let first = curve.points[0][1];
        let is_constant = curve.points.iter().all(|[_, openness]| *openness == first);
        Ok(if is_constant { Self::CONSTANT } else { curve })
    }

    /// Returns true if the shutter is always as far open.
    pub fn is_constant(&self) -> bool {
        self.points.is_empty()
    }

    /// Time by which a share of the light has come in, both from 0 to 1.
    fn time_of(&self, share: f64) -> f64 {
        if self.is_constant() {
            return share;
        }
        let mut left = share * self.pieces().map(Piece::light).sum::<f64>();
        let mut time = 0.0;
        for piece in self.pieces().filter(|piece| piece.light() > 0.0) {
            time = piece.begin + piece.length * piece.share_of(left);
            left -= piece.light();
            if left <= 0.0 {
                break;
            }
        }
        time
    }

    /// Pieces from the opening to the closing of the shutter.
    fn pieces(&self) -> impl Iterator<Item = Piece> + '_ {
        let ends = self.points.first().zip(self.points.last());
        let [first, last] = ends.map_or([1.0; 2], |(first, last)| [first[1], last[1]]);
        let points = || std::iter::once([0.0, first]).chain(self.points.iter().copied()).chain([[1.0, last]]);
        points().zip(points().skip(1)).map(|([begin, from], [end, to])| Piece {
            begin,
            length: end - begin,
            from,
            to,
        })
    }
}

/// Part of a curve between two points.
#[derive(Debug, Clone, Copy)]
struct Piece {
    begin: f64,
    length: f64,
    /// How far the shutter is open at its ends.
    from: f64,
    to: f64,
}

impl Piece {
    /// Light that comes in.
    fn light(self) -> f64 {
        0.5 * (self.from + self.to) * self.length
    }

    /// Share of its time after which `light` has come in, 1 at most.
    fn share_of(self, light: f64) -> f64 {
        // from s + (to - from) s^2 / 2 = light / length, in the form that takes no difference of equal numbers
        let light = light / self.length;
        let root = (self.from * self.from + 2.0 * (self.to - self.from) * light).max(0.0).sqrt();
        let half = self.from + root;
        if half > 0.0 { (2.0 * light / half).min(1.0) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: &[[f64; 2]]) -> Curve {
        Curve::through(points.to_vec()).expect("it is a curve")
    }

    #[test]
    fn times_are_those_by_which_shares_of_the_light_have_come_in() {
        let shares = [0.0, 0.125, 0.25, 0.5, 0.75, 0.875, 1.0];
        type Case = (&'static [[f64; 2]], fn(f64) -> f64);
        let cases: [Case; 5] = [
            (&[[0.0, 0.0], [1.0, 1.0]], |share| share.sqrt()),
            (&[[0.0, 1.0], [1.0, 0.0]], |share| 1.0 - (1.0 - share).sqrt()),
            (&[[0.0, 0.0], [0.5, 1.0], [1.0, 0.0]], |share| {
                if share < 0.5 { (share / 2.0).sqrt() } else { 1.0 - ((1.0 - share) / 2.0).sqrt() }
            }),
            // jumps, and ends that hold on
            (
                &[[0.5, 1.0], [0.5, 0.25]],
                |share| if share < 0.8 { share / 1.6 } else { 0.5 + (share - 0.8) * 2.5 },
            ),
            // shut, open, shut
            (&[[0.25, 0.0], [0.25, 0.5], [0.75, 0.5], [0.75, 0.0]], |share| 0.25 + share / 2.0),
        ];
        for (points, expected) in cases {
            let curve = curve(points);
            for share in shares {
                let (time, expected) = (curve.time_of(share), expected(share));
                assert!((time - expected).abs() < 1e-12, "{points:?}, {share}: {time}, not {expected}");
            }
        }
    }

    #[test]
    fn times_rise_and_divide_any_curve_evenly() {
        let wild =
            curve(&[[0.0, 0.3], [0.1, 0.0], [0.4, 0.0], [0.45, 1.0], [0.5, 0.2], [0.9, 1e-9], [1.0, 0.7]]);
        let light_until = |time: f64| -> f64 {
            let steps = 20_000;
            let at = |step: u32| (f64::from(step) + 0.5) / f64::from(steps);
            let openness = |time: f64| {
                let piece = wild
                    .pieces()
                    .find(|piece| time < piece.begin + piece.length)
                    .expect("it is before the end");
                piece.from + (piece.to - piece.from) * (time - piece.begin) / piece.length
            };
            (0..steps).map(at).filter(|at| *at < time).map(openness).sum::<f64>() / f64::from(steps)
        };
        let all = light_until(2.0);
        let times: Vec<f64> = (0..16).map(|number| wild.time_of((f64::from(number) + 0.5) / 16.0)).collect();
        assert!(times.is_sorted());
        for (number, time) in (0_u32..).zip(times) {
            let share = light_until(time) / all;
            assert!((share - (f64::from(number) + 0.5) / 16.0).abs() < 1e-3, "{number}, {time}: {share}");
        }
    }

    #[test]
    fn what_is_always_as_far_open_is_as_if_nothing_were_said() {
        assert_eq!(curve(&[[0.0, 0.5], [1.0, 0.5]]), Curve::CONSTANT);
        assert_eq!(Shutter::new(-0.5, 0.25).time_of(1.0 / 3.0), -0.25);
    }

    #[test]
    fn what_is_no_curve_is_refused() {
        for (points, words) in [
            (vec![], "two points"),
            (vec![[0.5, 1.0]], "two points"),
            (vec![[0.0, 0.0], [1.0, 0.0]], "never opens"),
            // open at one moment alone
            (vec![[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [0.5, 0.0], [1.0, 0.0]], "never opens"),
            (vec![[0.0, 1.0], [1.0, -0.5]], "[1, -0.5]"),
            (vec![[0.0, 1.0], [1.0, f64::NAN]], "[1, NaN]"),
            (vec![[f64::NAN, 1.0], [1.0, 1.0]], "[NaN, 1]"),
            (vec![[0.0, 1.0], [1.5, 1.0]], "[1.5, 1]"),
            (vec![[0.0, 2.0], [1.0, 1.0]], "[0, 2]"),
            (vec![[0.6, 1.0], [0.5, 0.0]], "order of time"),
        ] {
            let fault = Curve::through(points.clone()).expect_err("it is no curve");
            assert!(fault.contains(words), "{points:?}: {fault}");
        }
    }
}
