//! A whole comparison of reprojected frames with frames traced in full, as `--json` writes it.

use serde::Serialize;

use super::backends::BackendRun;
use super::both_ways::{BothTotals, ComparedFrame, Saving};
use super::reference::Reference;
use super::versions::Versions;
use crate::stats::{Eyes, Memory, RunSettings};
use crate::stereo::Eye;

/// A whole comparison, as `--json` writes it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// File of the shot as given on the command line.
    pub shot: String,
    /// Title of the shot.
    pub title: String,
    /// Settings of all renderings. The backend is the first one: all numbers before `backends` are its own.
    pub settings: RunSettings,
    /// Frames in the order of rendering.
    pub frames: Vec<ComparedFrame>,
    /// Sums over `frames`.
    pub totals: BothTotals,
    /// Saving over all frames, base frames included.
    pub saved: Saving,
    /// Saving over frames in which samples were reused.
    pub saved_inferred: Saving,
    /// Costs of each of two eyes with reuse, and the right one's saving.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eyes: Option<ComparedEyes>,
    /// Errors of the pictures, if they were measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<Reference>,
    /// Memory of the reprojected renderer's store; both renderers share the process, and its peak.
    pub memory: Memory,
    /// Seconds for building the scene for one renderer.
    pub build_seconds: f64,
    /// Measurements of every tracer on the same frames, the first one included.
    pub backends: Vec<BackendRun>,
    /// The command line that made it.
    pub command: String,
    /// Versions of the program and its libraries.
    pub versions: Versions,
}

/// Comparison of two eyes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedEyes {
    /// Costs of each eye with reuse.
    pub reprojected: Eyes,
    /// Saving of the right eye, against tracing its picture in full.
    pub saved_right: Saving,
}

impl ComparedEyes {
    /// Computes it from `frames`; `None` with one eye.
    fn new(frames: &[ComparedFrame]) -> Option<Self> {
        let reprojected = Eyes::new(frames.iter().map(|frame| &frame.reprojected))?;
        let of_right = |frame: &&ComparedFrame| frame.reprojected.eye == Some(Eye::Right);
        Some(Self { reprojected, saved_right: Saving::new(frames.iter().filter(of_right)) })
    }
}

impl Comparison {
    /// Computes all values that follow from `frames`.
    pub fn sum_up(&mut self) {
        self.totals = BothTotals::new(&self.frames);
        self.saved = Saving::new(&self.frames);
        self.eyes = ComparedEyes::new(&self.frames);
        self.saved_inferred = Saving::new(self.frames.iter().filter(|frame| frame.is_inferred()));
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::report::both_ways::tests::frame;
    use crate::settings::Settings;

    pub fn comparison(frames: Vec<ComparedFrame>) -> Comparison {
        let settings = Settings { width: 10, height: 10, samples: 1, paths: 0, ..Settings::default() };
        let mut comparison = Comparison {
            shot: "city <1>.toml".into(),
            title: "A city & a blimp".into(),
            settings: RunSettings { picture: settings, backend: "embree", threads: 2 },
            frames,
            totals: BothTotals::new(&[]),
            saved: Saving::default(),
            saved_inferred: Saving::default(),
            eyes: None,
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
                arithmetic: "avx2".into(),
                threads: 2,
            },
        };
        comparison.sum_up();
        comparison
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
    fn the_right_eye_is_told_of_by_itself() {
        let seen = |eye, mut frame: ComparedFrame| {
            (frame.reprojected.eye, frame.full.eye) = (Some(eye), Some(eye));
            frame.reprojected.from_left = eye == Eye::Right;
            frame
        };
        let comparison = comparison(vec![seen(Eye::Left, frame(1, 0)), seen(Eye::Right, frame(1, 90))]);
        let eyes = comparison.eyes.expect("two eyes");
        assert_eq!((eyes.saved_right.frames, eyes.reprojected.from_left.percent), (1, 90.0));
        assert!((eyes.saved_right.rays_percent - 50.0).abs() < 1e-9);
    }

    #[test]
    fn nothing_compared_saves_nothing() {
        assert_eq!(Saving::new([]), Saving { speed_up: 1.0, ..Saving::default() });
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
