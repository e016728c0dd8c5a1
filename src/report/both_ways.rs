//! Measurements of frames made in two ways, reprojected and traced in full.

use serde::Serialize;

use super::error::BothErrors;
use crate::film::Film;
use crate::stats::{FrameStats, Totals, saved_percent};

/// Values that are further apart than this, in any of R, G, B (linear), count as different.
pub const THRESHOLD: f32 = 0.02;

/// Difference between two pictures.
///
/// A reprojected sample keeps the place in its cell to which it was carried, and a new sample lies where the
/// pattern puts it. Both are right, so edges and textures differ a little; flat parts must not.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Difference {
    /// Mean of the absolute difference over R, G and B, linear.
    pub mean: f64,
    /// Percentage of pixels that differ by more than [`THRESHOLD`].
    pub percent_above: f64,
}

impl Difference {
    /// Compares two films of the same size. A plane that is missing counts as equal.
    pub fn between(a: &Film, b: &Film) -> Self {
        let planes: Vec<_> =
            ["R", "G", "B"].iter().filter_map(|name| a.values(name).zip(b.values(name))).collect();
        let pixels = planes.iter().map(|(a, b)| a.len().min(b.len())).min().unwrap_or(0);
        if pixels == 0 {
            return Self::default();
        }
        let (mut sum, mut above) = (0.0, 0_u64);
        for pixel in 0..pixels {
            let apart = planes.iter().map(|(a, b)| (a[pixel] - b[pixel]).abs());
            sum += apart.clone().map(f64::from).sum::<f64>();
            // written so that a value that is no number counts as different
            above += u64::from(!apart.clone().all(|apart| apart <= THRESHOLD));
        }
        Self {
            mean: sum / (pixels * planes.len()) as f64,
            percent_above: 100.0 * above as f64 / pixels as f64,
        }
    }
}

/// One frame, made twice.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedFrame {
    /// Number of the frame.
    pub frame: i32,
    /// Statistics of the frame made as `render` makes it.
    pub reprojected: FrameStats,
    /// Statistics of the frame traced from nothing.
    pub full: FrameStats,
    /// Difference between the two pictures.
    pub difference: Difference,
    /// Errors of both pictures against a reference, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<BothErrors>,
}

impl ComparedFrame {
    /// Returns true if any sample was reused.
    pub fn is_inferred(&self) -> bool {
        self.reprojected.samples.reused() > 0
    }
}

/// Saving of reprojection over some frames.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Saving {
    /// Number of frames.
    pub frames: usize,
    /// Rays saved, as a percentage of all rays of full tracing, of every kind. Verification rays count
    /// against reprojection.
    pub rays_percent: f64,
    /// Time saved, as a percentage of the seconds of full tracing, without writing files.
    pub time_percent: f64,
    /// Seconds of full tracing over seconds with reprojection, without writing files.
    pub speed_up: f64,
}

impl Saving {
    /// Computes the saving over `frames`.
    pub fn new<'a>(frames: impl IntoIterator<Item = &'a ComparedFrame>) -> Self {
        let frames: Vec<_> = frames.into_iter().collect();
        let ours = Totals::new(frames.iter().map(|frame| &frame.reprojected));
        let full = Totals::new(frames.iter().map(|frame| &frame.full));
        let seconds = (ours.seconds.rendering(), full.seconds.rendering());
        Self {
            frames: frames.len(),
            rays_percent: saved_percent(ours.rays.total() as f64, full.rays.total() as f64),
            time_percent: saved_percent(seconds.0, seconds.1),
            speed_up: if seconds.0 > 0.0 { seconds.1 / seconds.0 } else { 1.0 },
        }
    }
}

/// Totals of both ways on the same frames.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BothTotals {
    /// Totals of the frames made as `render` makes them.
    pub reprojected: Totals,
    /// Totals of the frames traced from nothing.
    pub full: Totals,
}

impl BothTotals {
    /// Sums over `frames`.
    pub fn new(frames: &[ComparedFrame]) -> Self {
        Self {
            reprojected: Totals::new(frames.iter().map(|frame| &frame.reprojected)),
            full: Totals::new(frames.iter().map(|frame| &frame.full)),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::film::{Plane, PlaneKind};
    use crate::stats::{AuditCounts, RayCounts, SampleCounts, Seconds, TracingSeconds};

    pub fn frame(number: i32, reused: u64) -> ComparedFrame {
        let full = FrameStats {
            frame: number,
            eye: None,
            from_left: false,
            mode: "full",
            cut: false,
            seconds: Seconds { total: 0.4, trace: 0.3, ..Seconds::default() },
            samples: SampleCounts { base: 100, ..SampleCounts::default() },
            rays: RayCounts { primary: 100, shadow: 100, ..RayCounts::default() },
            tracing: TracingSeconds::default(),
            audit: None,
        };
        let traced = 100 - reused;
        let reprojected = FrameStats {
            mode: if reused > 0 { "reproject" } else { "base" },
            seconds: Seconds { total: 0.3, trace: 0.1, write: 0.1, ..Seconds::default() },
            samples: SampleCounts {
                base: if reused > 0 { 0 } else { traced },
                missed: if reused > 0 { traced } else { 0 },
                good: reused,
                ..SampleCounts::default()
            },
            rays: RayCounts { primary: traced, verification: reused, ..RayCounts::default() },
            audit: Some(AuditCounts { checked: 100, on_edge: 1, ..Default::default() }),
            ..full.clone()
        };
        ComparedFrame {
            frame: number,
            reprojected,
            full,
            difference: Difference { mean: 0.001, percent_above: 0.5 },
            error: None,
        }
    }

    pub fn film(values: [f32; 4]) -> Film {
        let plane = |name| Plane::new(name, PlaneKind::Half, &values);
        Film { width: 2, height: 2, planes: ["R", "G", "B"].map(plane).to_vec() }
    }

    #[test]
    fn measures_the_mean_and_the_share_of_pixels() {
        let difference =
            Difference::between(&film([0.0, 1.0, 2.0, 0.5]), &film([0.0, 1.375, 2.0078125, 0.5]));
        assert!((difference.mean - 0.3828125 / 4.0).abs() < 1e-6, "{difference:?}");
        assert_eq!(difference.percent_above, 25.0);
        let nan = Difference::between(&film([f32::NAN; 4]), &film([0.0; 4]));
        assert_eq!(nan.percent_above, 100.0);
    }
}
