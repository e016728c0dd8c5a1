//! Errors of reprojected frames and of frames in full against a reference.

use serde::Serialize;

use super::both_ways::{BothTotals, ComparedFrame};
use super::error::{BothErrors, PictureError};

/// Errors over some frames.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct ErrorTotals {
    /// Number of frames.
    pub frames: usize,
    /// Errors of both ways.
    pub errors: BothErrors,
    /// Ratio of the `display` errors, reprojected over full; none if one of them is zero.
    pub ratio: Option<f64>,
    /// Speed of reprojection relative to full tracing if both ways take as many samples as the same `display`
    /// error needs. By Monte Carlo's efficiency, variance goes with 1 / samples and time with samples, so
    /// that the time for an error is proportional to the product of error squared and seconds. Without
    /// writing files.
    pub speed_up_at_equal_error: Option<f64>,
}

impl ErrorTotals {
    fn new<'a>(frames: impl IntoIterator<Item = &'a ComparedFrame>) -> Self {
        let (frames, errors): (Vec<ComparedFrame>, Vec<BothErrors>) =
            frames.into_iter().filter_map(|frame| Some((frame.clone(), frame.error?))).unzip();
        let both = BothErrors {
            reprojected: PictureError::over(errors.iter().map(|error| error.reprojected)),
            full: PictureError::over(errors.iter().map(|error| error.full)),
        };
        let totals = BothTotals::new(&frames);
        let needs = |error: f64, seconds: f64| error.powi(2) * seconds;
        let (ours, full) = (both.reprojected.display, both.full.display);
        let [our_time, full_time] = [
            needs(ours, totals.reprojected.seconds.rendering()),
            needs(full, totals.full.seconds.rendering()),
        ];
        let ratio = |a: f64, b: f64| (a > 0.0 && b > 0.0).then(|| a / b);
        Self {
            frames: frames.len(),
            errors: both,
            ratio: ratio(ours, full),
            speed_up_at_equal_error: ratio(full_time, our_time),
        }
    }
}

/// Errors of both ways against a reference.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Reference {
    /// N, for N x N samples a pixel.
    pub samples: u32,
    /// Errors over all frames, base frames included.
    pub all: ErrorTotals,
    /// Errors over frames in which samples were reused.
    pub inferred: ErrorTotals,
}

impl Reference {
    /// Computes the errors over `frames`, which were compared with a reference of `samples`.
    pub fn of(samples: u32, frames: &[ComparedFrame]) -> Self {
        Self {
            samples,
            all: ErrorTotals::new(frames),
            inferred: ErrorTotals::new(frames.iter().filter(|frame| frame.is_inferred())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::both_ways::tests::frame;

    #[test]
    fn time_for_equal_error_goes_with_error_squared() {
        let of = |display| PictureError { display, linear: 2.0 * display };
        let mut frames = [frame(1, 0), frame(2, 90), frame(3, 90)];
        for (frame, (ours, full)) in frames.iter_mut().zip([(0.1, 0.1), (0.2, 0.1), (0.2, 0.1)]) {
            frame.error = Some(BothErrors { reprojected: of(ours), full: of(full) });
        }
        let reference = Reference::of(8, &frames);
        assert_eq!((reference.all.frames, reference.inferred.frames), (3, 2));
        // twice the error in half the time: a quarter of the samples, and so half as fast
        let inferred = reference.inferred;
        assert!((inferred.ratio.expect("neither is zero") - 2.0).abs() < 1e-9);
        assert!((inferred.speed_up_at_equal_error.expect("neither is zero") - 0.5).abs() < 1e-9);
        let all = reference.all.errors;
        assert!((all.reprojected.display.powi(2) - 0.03).abs() < 1e-9, "{all:?}");
        assert!((all.full.linear - 0.2).abs() < 1e-9, "{all:?}");
    }

    #[test]
    fn nothing_is_said_where_there_is_no_error() {
        let mut exact = frame(2, 90);
        exact.error = Some(BothErrors::default());
        let totals = ErrorTotals::new([&exact]);
        assert_eq!((totals.frames, totals.ratio, totals.speed_up_at_equal_error), (1, None, None));
        assert_eq!(ErrorTotals::new([&frame(2, 90)]), ErrorTotals::default(), "not compared");
    }
}
