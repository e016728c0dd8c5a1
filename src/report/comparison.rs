//! The same frames, reprojected and traced in full: what was measured.

use serde::Serialize;

use super::backends::BackendRun;
use super::error::{BothErrors, Reference};
use super::versions::Versions;
use crate::film::Film;
use crate::stats::{FrameStats, Memory, RunSettings, Totals, saved_percent};

/// Values that are further apart than this, in any of R, G, B (linear), count as different.
pub const THRESHOLD: f32 = 0.02;

/// How far two pictures are apart.
///
/// A reprojected sample lies where it was carried to within its cell, and a sample traced anew where the
/// pattern puts it. Both are right, so edges and textures differ a little; flat parts must not.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Difference {
    /// Mean of the absolute difference over R, G and B, linear.
    pub mean: f64,
    /// Percent of pixels that differ by more than [`THRESHOLD`].
    pub percent_above: f64,
}

impl Difference {
    /// Between two films of the same size. A plane that is missing counts as equal.
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
    /// Its number.
    pub frame: i32,
    /// Made as `render` makes it.
    pub reprojected: FrameStats,
    /// Traced from nothing.
    pub full: FrameStats,
    /// Of the two pictures.
    pub difference: Difference,
    /// Of each from a reference, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<BothErrors>,
}

impl ComparedFrame {
    /// Whether anything could be reused.
    pub fn is_inferred(&self) -> bool {
        self.reprojected.samples.reused() > 0
    }
}

/// What reprojection saved over some frames.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Saving {
    /// How many.
    pub frames: usize,
    /// Percent of all rays of full tracing, of every kind, verification rays on our side.
    pub rays_percent: f64,
    /// Percent of the seconds of full tracing, without writing files.
    pub time_percent: f64,
    /// Seconds of full tracing over seconds with reprojection, without writing files.
    pub speed_up: f64,
}

impl Saving {
    /// Over `frames`.
    pub fn of<'a>(frames: impl IntoIterator<Item = &'a ComparedFrame>) -> Self {
        let frames: Vec<_> = frames.into_iter().collect();
        let ours = Totals::of(frames.iter().map(|frame| &frame.reprojected));
        let full = Totals::of(frames.iter().map(|frame| &frame.full));
        let seconds = (ours.seconds.rendering(), full.seconds.rendering());
        Self {
            frames: frames.len(),
            rays_percent: saved_percent(ours.rays.total() as f64, full.rays.total() as f64),
            time_percent: saved_percent(seconds.0, seconds.1),
            speed_up: if seconds.0 > 0.0 { seconds.1 / seconds.0 } else { 1.0 },
        }
    }
}

/// Two ways on the same frames.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BothTotals {
    /// Made as `render` makes them.
    pub reprojected: Totals,
    /// Traced from nothing.
    pub full: Totals,
}

impl BothTotals {
    /// The sums over `frames`.
    pub fn of(frames: &[ComparedFrame]) -> Self {
        Self {
            reprojected: Totals::of(frames.iter().map(|frame| &frame.reprojected)),
            full: Totals::of(frames.iter().map(|frame| &frame.full)),
        }
    }
}

/// A whole comparison, as `--json` writes it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The shot's file as it was named.
    pub shot: String,
    /// As the shot calls itself.
    pub title: String,
    /// Of all; the backend is the first one, whose numbers all that follows up to `backends` are.
    pub settings: RunSettings,
    /// In the order of rendering.
    pub frames: Vec<ComparedFrame>,
    /// Sums over `frames`.
    pub totals: BothTotals,
    /// Over all frames, base frames too.
    pub saved: Saving,
    /// Over frames in which something was reused.
    pub saved_inferred: Saving,
    /// What the pictures' errors are, if that was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// The reprojected renderer's store; both renderers share the process, and its peak.
    pub memory: Memory,
    /// Building the scene for one renderer.
    pub build_seconds: f64,
    /// Every tracer on the same frames, the first one included.
    pub backends: Vec<BackendRun>,
    /// The command line that made it.
    pub command: String,
    /// What made it.
    pub versions: Versions,
}

impl Comparison {
    /// Adds up what follows from `frames`.
    pub fn sum_up(&mut self) {
        self.totals = BothTotals::of(&self.frames);
        self.saved = Saving::of(&self.frames);
        self.saved_inferred = Saving::of(self.frames.iter().filter(|frame| frame.is_inferred()));
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::film::{Plane, PlaneKind};
    use crate::settings::{Build, Filter, Mode, Settings};
    use crate::stats::{AuditCounts, RayCounts, SampleCounts, Seconds, TracingSeconds};

    pub fn frame(number: i32, reused: u64) -> ComparedFrame {
        let full = FrameStats {
            frame: number,
            mode: "full",
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
            audit: Some(AuditCounts { checked: 100, differing: 0, on_edge: 1 }),
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

    pub fn comparison(frames: Vec<ComparedFrame>) -> Comparison {
        let settings = Settings {
            width: 10,
            height: 10,
            samples: 1,
            filter: Filter::Box,
            depth: 4,
            mode: Mode::Auto,
            base_every: 0,
            layers: crate::layers::Layers::ALL,
            audit: true,
            build: Build::Best,
        };
        let mut comparison = Comparison {
            shot: "city <1>.toml".into(),
            title: "A city & a blimp".into(),
            settings: RunSettings { picture: settings, backend: "embree", threads: 2 },
            frames,
            totals: BothTotals::of(&[]),
            saved: Saving::default(),
            saved_inferred: Saving::default(),
            reference: None,
            memory: Memory::default(),
            build_seconds: 0.1,
            backends: Vec::new(),
            command: "afterimage compare 'city <1>.toml'".into(),
            versions: Versions {
                afterimage: "1",
                embree: "4.4.0".into(),
                openexr: "3.1.5".into(),
                cpu: "a".into(),
                threads: 2,
            },
        };
        comparison.sum_up();
        comparison
    }

    pub fn film(values: [f32; 4]) -> Film {
        let plane = |name| Plane::new(name, PlaneKind::Half, &values);
        Film { width: 2, height: 2, planes: ["R", "G", "B"].map(plane).to_vec(), stamp: 0 }
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

    #[test]
    fn writing_is_in_no_ratio_and_base_frames_are_in_the_first() {
        let comparison = comparison(vec![frame(1, 0), frame(2, 90)]);
        assert_eq!((comparison.saved.frames, comparison.saved_inferred.frames), (2, 1));
        assert!((comparison.saved.speed_up - 2.0).abs() < 1e-9);
        assert!((comparison.saved.rays_percent - 50.0).abs() < 1e-9);
        assert!((comparison.saved.time_percent - 50.0).abs() < 1e-9);
    }

    #[test]
    fn nothing_compared_saves_nothing() {
        assert_eq!(Saving::of([]), Saving { speed_up: 1.0, ..Saving::default() });
    }

    #[test]
    fn the_json_has_both_sides_of_every_frame() {
        let json = serde_json::to_value(comparison(vec![frame(2, 90)])).expect("plain data");
        for pointer in [
            "/frames/0/reprojected/rays/verification",
            "/frames/0/full/seconds/trace",
            "/frames/0/difference/percent_above",
            "/totals/full/rays/shadow",
            "/saved_inferred/rays_percent",
            "/versions/embree",
            "/settings/threads",
        ] {
            assert!(json.pointer(pointer).is_some(), "{pointer}");
        }
    }
}
