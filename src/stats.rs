//! Cost of a frame, and the samples that it reused: rays by kind, samples by status, seconds by phase.

use std::fmt;
use std::ops::AddAssign;

use serde::Serialize;

use crate::scene::texture::PageCounts;
use crate::settings::Settings;
use crate::stereo::Eye;

/// Seconds of wall-clock time, by phase.
///
/// The phases of a frame run tile by tile on all threads: their time is split by the time that the threads
/// spent in each. `reproject` includes the pose, the commit to the tracer and scattering; `light` is all light, kept
/// and seen, with its shadow rays. `total` is the whole frame, with work that is in no phase, without the audit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[serde(into = "WrittenSeconds")]
#[allow(missing_docs, reason = "the phases of the frame loop, by name")]
pub struct Seconds {
    /// The whole frame, `denoise` and `write` included.
    pub total: f64,
    pub reproject: f64,
    pub verify: f64,
    pub trace: f64,
    pub light: f64,
    pub filter: f64,
    /// Zero where frames are not denoised.
    pub denoise: f64,
    pub write: f64,
}

/// [`Seconds`] with the keys that files have.
#[derive(Serialize)]
struct WrittenSeconds {
    total: f64,
    reproject: f64,
    verify: f64,
    trace: f64,
    light: f64,
    /// Old name of `light`: written until the version after 0.1.
    enhance: f64,
    filter: f64,
    #[serde(skip_serializing_if = "is_zero")]
    denoise: f64,
    write: f64,
}

impl From<Seconds> for WrittenSeconds {
    fn from(seconds: Seconds) -> Self {
        let Seconds { total, reproject, verify, trace, light, filter, denoise, write } = seconds;
        Self { total, reproject, verify, trace, light, enhance: light, filter, denoise, write }
    }
}

fn is_zero(seconds: &f64) -> bool {
    *seconds == 0.0
}

/// Samples by status (see [`Status`](crate::samples::Status)).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[allow(missing_docs, reason = "one count a status, by name")]
pub struct SampleCounts {
    pub base: u64,
    pub good: u64,
    pub overlapped: u64,
    pub missed: u64,
    pub obscured: u64,
    /// Samples that are kept and serve no cell in this frame: in no total.
    pub spare: u64,
}

/// Rays that were cast, each under the kind that it served.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[allow(missing_docs, reason = "one count a kind, by name")]
pub struct RayCounts {
    pub primary: u64,
    /// Segments from the eye to reprojected samples.
    pub verification: u64,
    /// Shadow rays for primary samples and for surfaces seen in mirrors and through glass.
    pub shadow: u64,
    pub reflection: u64,
    pub refraction: u64,
    /// Rays of paths that gather light: from surface to surface, or to the sky.
    pub gathering: u64,
}

impl RayCounts {
    /// Number of all rays.
    pub fn total(&self) -> u64 {
        self.primary + self.verification + self.shadow + self.reflection + self.refraction + self.gathering
    }
}

/// Seconds that threads spent in the tracer, all of them together, by kind of ray. The seconds of the phases
/// are wall-clock time, and include these.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[allow(missing_docs, reason = "one number a kind, by name")]
pub struct TracingSeconds {
    pub primary: f64,
    pub verification: f64,
    pub shadow: f64,
    /// Time of reflection, refraction, and gathering.
    pub bounced: f64,
}

/// Findings of `--audit`. Its own rays are in no other count.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct AuditCounts {
    /// Number of samples that were checked.
    pub checked: u64,
    /// Number of samples that do not hold, or whose pixel differs from all of its samples. The claim is that
    /// this is 0.
    pub differing: u64,
    /// Number of samples that hold within the named tolerance only: on an edge, or where surfaces coincide.
    pub on_edge: u64,
    /// Number of cells whose targets were asked what they see; none with the paper's rule, which promises nothing of them.
    pub targets: u64,
    /// Number of cells that show another surface than their target sees. The claim is that this is 0.
    pub coverage: u64,
    /// Number of cells whose target lies within the named tolerance of the surface that they show.
    pub coverage_on_edge: u64,
    /// Number of surfaces seen by way of mirrors whose light was kept, and that were checked as samples are: those that do not hold count
    /// with the samples whose mirrors show them.
    pub mirrored: u64,
}

impl AuditCounts {
    /// Least number of cells of which one may be decided by rounding ([`coverage_on_edge`](Self::coverage_on_edge)). A ray is rounded by
    /// some millionths of the distance, and a cell is a thousandth of it: edges cross one cell in ten, and of these the rays of one in
    /// some hundred pass that near.
    const CELLS_FOR_EACH_ON_EDGE: u64 = 500;

    /// Number of such cells that small pictures may have besides.
    const FEW_ON_EDGE: u64 = 8;

    /// Number of findings against the claims.
    pub fn wrong(&self) -> u64 {
        let may_be_on_edge = Self::FEW_ON_EDGE + self.checked / Self::CELLS_FOR_EACH_ON_EDGE;
        self.differing + self.coverage + self.coverage_on_edge.saturating_sub(may_be_on_edge)
    }
}

/// Statistics of one frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct FrameStats {
    /// Number of the frame.
    pub frame: i32,
    /// Eye that saw it, of two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eye: Option<Eye>,
    /// True for a frame of the right eye that reuses the left eye's samples of this frame, and not its own of
    /// the frame before.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub from_left: bool,
    /// Mode: `base` (traced in full because nothing could be reused), `reproject` or `full`.
    pub mode: &'static str,
    /// True for a base frame at a cut: the shot says that it cuts here, or next to nothing of the frame
    /// before is in sight.
    #[serde(skip_serializing_if = "is_false")]
    pub cut: bool,
    /// Seconds by phase.
    pub seconds: Seconds,
    /// Samples by status.
    pub samples: SampleCounts,
    /// Rays by kind.
    pub rays: RayCounts,
    /// Seconds in the tracer, by kind.
    pub tracing: TracingSeconds,
    /// Findings of the audit, if there was one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub audit: Option<AuditCounts>,
}

fn is_false(holds: &bool) -> bool {
    !holds
}

/// Sums over frames.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Totals {
    /// Seconds by phase.
    pub seconds: Seconds,
    /// Samples by status.
    pub samples: SampleCounts,
    /// Rays by kind.
    pub rays: RayCounts,
    /// Seconds in the tracer, by kind.
    pub tracing: TracingSeconds,
    /// Findings of audits, if there were any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub audit: Option<AuditCounts>,
}

impl Totals {
    /// Sum over `frames`.
    pub fn new<'a>(frames: impl IntoIterator<Item = &'a FrameStats>) -> Self {
        let mut sum = Self::default();
        for frame in frames {
            sum.seconds += frame.seconds;
            sum.samples += frame.samples;
            sum.rays += frame.rays;
            sum.tracing += frame.tracing;
            if let Some(audit) = frame.audit {
                *sum.audit.get_or_insert_default() += audit;
            }
        }
        sum
    }
}

/// Cost of each of two eyes, and the samples that the right one took from the left one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Eyes {
    /// Sum over the left eye's frames.
    pub left: Totals,
    /// Sum over the right eye's frames.
    pub right: Totals,
    /// Sums over those frames of the right eye that were made from the left eye's samples.
    pub from_left: FromLeft,
}

/// Samples that the right eye took from the left one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct FromLeft {
    /// Number of frames of the right eye that were made so. The others were traced in full, or go on with its
    /// own samples while the camera rests.
    pub frames: u64,
    /// Number of samples of the left eye that the right one shows in them.
    pub reused: u64,
    /// Number of all samples in them.
    pub samples: u64,
    /// Percentage of `reused` in `samples`.
    pub percent: f64,
}

impl Eyes {
    /// Sums over the frames of a run; `None` if there is one eye.
    pub fn new<'a>(frames: impl IntoIterator<Item = &'a FrameStats>) -> Option<Self> {
        let frames: Vec<&FrameStats> = frames.into_iter().filter(|frame| frame.eye.is_some()).collect();
        let of = |eye| Totals::new(frames.iter().copied().filter(|frame| frame.eye == Some(eye)));
        let made = || frames.iter().copied().filter(|frame| frame.from_left);
        let SampleCounts { good, overlapped, .. } = Totals::new(made()).samples;
        let samples = Totals::new(made()).samples.total();
        let reused = good + overlapped;
        let percent = if samples > 0 { 100.0 * reused as f64 / samples as f64 } else { 0.0 };
        let from_left = FromLeft { frames: made().count() as u64, reused, samples, percent };
        let [left, right] = Eye::BOTH.map(of);
        (!frames.is_empty()).then_some(Self { left, right, from_left })
    }
}

/// Memory, in bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Memory {
    /// Largest amount that the process ever held (resident).
    pub peak_bytes: u64,
    /// Size of the sample store, both halves of it.
    pub store_bytes: u64,
    /// `store_bytes` over the samples of a frame.
    pub bytes_per_sample: f64,
    /// Use of the textures that are in pages, if there are some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texture_pages: Option<PageCounts>,
}

impl Memory {
    /// Updates the largest amount that this process ever held.
    pub fn with_peak(self) -> Self {
        Self { peak_bytes: peak_bytes().unwrap_or(self.peak_bytes), ..self }
    }
}

/// Largest number of bytes that this process ever held in memory (resident); `None` if the system does not
/// tell.
pub fn peak_bytes() -> Option<u64> {
    entry(&std::fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// Number of bytes that this process holds in memory now (resident); `None` if the system does not tell.
pub fn held_bytes() -> Option<u64> {
    entry(&std::fs::read_to_string("/proc/self/status").ok()?, "VmRSS:")
}

/// Reads an entry, in KiB, of Linux's process status or of its account of memory. Returns bytes.
pub(crate) fn entry(status: &str, name: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}

impl FrameStats {
    /// Adds an exposure after the first one, of the same frame. Each decides for itself if it is traced in full: a frame is a base frame if
    /// all of its exposures are.
    pub fn add_exposure(&mut self, other: &Self) {
        if self.mode == "base" {
            self.mode = other.mode;
        }
        self.cut &= other.cut;
        self.from_left &= other.from_left;
        self.seconds += other.seconds;
        self.samples += other.samples;
        self.rays += other.rays;
        self.tracing += other.tracing;
        if let Some(audit) = other.audit {
            *self.audit.get_or_insert_default() += audit;
        }
    }

    /// Kind of the frame, in a word for people: its mode, or `cut`.
    pub fn kind(&self) -> &'static str {
        if self.cut { "cut" } else { self.mode }
    }
}

impl Seconds {
    /// Time without denoising and the writing of files, which cost the same for any picture.
    pub fn rendering(&self) -> f64 {
        self.total - self.denoise - self.write
    }
}

impl SampleCounts {
    /// Number of all samples.
    pub fn total(&self) -> u64 {
        self.base + self.reused() + self.missed + self.obscured
    }

    /// Number of samples that were not traced.
    pub fn reused(&self) -> u64 {
        self.good + self.overlapped
    }
}

/// Estimate of the rays for tracing every sample of a frame, in a run that does not do it.
///
/// It counts one primary ray a sample; shadow and gathering rays a sample as in the last base frame, where
/// they were counted; reflection and refraction rays as cast, which is too few where the camera rests and
/// some are spared: no more is said to be saved than is. `compare` measures instead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FullEstimate {
    /// Number of shadow rays, and of rays that gather light, for each sample.
    lighting_per_sample: f64,
}

impl FullEstimate {
    /// Estimate from a frame that was traced in full; `None` if `frame` was not.
    pub fn from_base(frame: &FrameStats) -> Option<Self> {
        let samples = frame.samples.total();
        let full = samples > 0 && frame.samples.base == samples;
        let lighting = (frame.rays.shadow + frame.rays.gathering) as f64;
        full.then(|| Self { lighting_per_sample: lighting / samples as f64 })
    }

    /// Estimated number of rays of `frame`, had it been traced in full.
    pub fn rays(&self, frame: &FrameStats) -> f64 {
        let each = 1.0 + self.lighting_per_sample;
        each * frame.samples.total() as f64 + (frame.rays.reflection + frame.rays.refraction) as f64
    }
}

/// Percentage of `full` that `cast` leaves out; negative where it is more.
pub fn saved_percent(cast: f64, full: f64) -> f64 {
    if full > 0.0 { 100.0 * (1.0 - cast / full) } else { 0.0 }
}

/// Percentage with one decimal, and without a sign if it rounds to zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Percent(pub f64);

impl fmt::Display for Percent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = format!("{:.1}", self.0);
        // numbers are aligned to the right
        let width = f.width().unwrap_or(0);
        write!(f, "{:>width$}", if text == "-0.0" { "0.0" } else { &text })
    }
}

/// Savings, for people. Where much more was taken, a percentage far below zero says little; a factor says
/// more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Saved {
    /// Percentage of the reference; negative where up to twice as much was taken.
    Percent(Percent),
    /// Factor by which more was taken: above 2.
    Times(f64),
}

impl Saved {
    /// Savings where `taken` was taken instead of `full`; `None` where `full` is nothing.
    pub fn of(taken: f64, full: f64) -> Option<Self> {
        (full > 0.0).then(|| Self::of_percent(saved_percent(taken, full)))
    }

    /// Savings from a [`saved_percent`].
    pub fn of_percent(percent: f64) -> Self {
        if percent < -100.0 { Self::Times(1.0 - percent / 100.0) } else { Self::Percent(Percent(percent)) }
    }
}

impl fmt::Display for Saved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Percent(percent) => write!(f, "{percent} %"),
            Self::Times(times) => write!(f, "{times:.1}×"),
        }
    }
}

/// Settings of a run as its statistics state them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunSettings {
    /// Settings that decide the pictures.
    #[serde(flatten)]
    pub picture: Settings,
    /// Name of the tracer.
    pub backend: &'static str,
    /// Number of threads that worked.
    pub threads: usize,
}

/// Contents of the file that `--stats` writes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunStats<'a> {
    /// File of the shot, as it was named.
    pub shot: &'a str,
    /// Settings of the run.
    pub settings: &'a RunSettings,
    /// Frames that were written, in the order of rendering.
    pub frames: &'a [FrameStats],
    /// Sum over frames that were rendered only because others are inferred from them; in no other sum.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run_up: Option<Totals>,
    /// Cost of each of two eyes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eyes: Option<Eyes>,
    /// Sum over `frames`.
    pub totals: Totals,
    /// Memory of the process.
    pub memory: Memory,
}

macro_rules! sum_fields {
    ($type:ty: $($field:ident),+) => {
        impl AddAssign for $type {
            fn add_assign(&mut self, other: Self) {
                // a field that is missing in the list does not compile
                let Self { $($field),+ } = other;
                $(self.$field += $field;)+
            }
        }
    };
}
sum_fields!(Seconds: total, reproject, verify, trace, light, filter, denoise, write);
sum_fields!(SampleCounts: base, good, overlapped, missed, obscured, spare);
sum_fields!(RayCounts: primary, verification, shadow, reflection, refraction, gathering);
sum_fields!(TracingSeconds: primary, verification, shadow, bounced);
sum_fields!(AuditCounts: checked, differing, on_edge, targets, coverage, coverage_on_edge, mirrored);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Build, Filter};

    fn frame(number: i32, base: u64, good: u64, shadow: u64) -> FrameStats {
        FrameStats {
            frame: number,
            mode: if good == 0 { "base" } else { "reproject" },
            samples: SampleCounts { base, good, ..SampleCounts::default() },
            rays: RayCounts { primary: base, verification: good, shadow, ..RayCounts::default() },
            ..FrameStats::default()
        }
    }

    #[test]
    fn totals_sum_every_field() {
        let mut audited = frame(2, 0, 10, 3);
        audited.audit = Some(AuditCounts { checked: 10, differing: 1, on_edge: 2, ..Default::default() });
        let totals = Totals::new(&[frame(1, 10, 0, 5), audited]);
        assert_eq!((totals.samples.base, totals.samples.good, totals.rays.total()), (10, 10, 28));
        assert_eq!(totals.audit.map(|audit| audit.differing), Some(1));
    }

    #[test]
    fn eyes_are_told_apart() {
        let seen = |eye, from_left, frame: FrameStats| FrameStats { eye: Some(eye), from_left, ..frame };
        let mut made = seen(Eye::Right, true, frame(1, 0, 75, 1));
        made.samples.missed = 25;
        let left = seen(Eye::Left, false, frame(1, 100, 0, 5));
        let at_rest = seen(Eye::Right, false, frame(2, 0, 100, 0));
        let eyes = Eyes::new(&[left, made, at_rest]).expect("there are two");
        let FromLeft { frames, reused, samples, percent } = eyes.from_left;
        assert_eq!((frames, reused, samples, percent), (1, 75, 100, 75.0));
        assert_eq!((eyes.left.samples.base, eyes.right.samples.total()), (100, 200));
        assert_eq!(Eyes::new(&[frame(1, 100, 0, 5)]), None);
    }

    #[test]
    fn the_estimate_takes_shadow_rays_from_the_base_frame() {
        let estimate = FullEstimate::from_base(&frame(1, 100, 0, 200)).expect("a base frame");
        assert!(FullEstimate::from_base(&frame(2, 0, 100, 0)).is_none());
        let inferred = frame(2, 0, 100, 50);
        assert_eq!(estimate.rays(&inferred), 300.0);
        assert_eq!(saved_percent(inferred.rays.total() as f64, estimate.rays(&inferred)), 50.0);
        assert_eq!(saved_percent(1.0, 0.0), 0.0);
    }

    #[test]
    fn no_percentage_is_minus_zero() {
        let texts = [-0.04, -0.0, 0.04, -0.06, 99.96].map(|percent| Percent(percent).to_string());
        assert_eq!(texts, ["0.0", "0.0", "0.0", "-0.1", "100.0"]);
        assert_eq!(format!("{:>7}|", Percent(-0.01)), "    0.0|");
    }

    #[test]
    fn what_takes_more_than_twice_as_much_is_no_percentage() {
        let texts = [(1.0, 4.0), (4.0, 4.001), (4.0, 4.0), (4.0, 2.0), (5.0, 2.0), (1e6, 2.0)]
            .map(|(taken, full)| Saved::of(taken, full).map(|saved| saved.to_string()));
        let wanted = ["75.0 %", "0.0 %", "0.0 %", "-100.0 %", "2.5×", "500000.0×"];
        assert_eq!(texts, wanted.map(|text| Some(text.to_owned())));
        assert_eq!(Saved::of(1.0, 0.0), None);
    }

    #[test]
    fn the_json_has_the_keys_of_the_contract() {
        let picture = Settings {
            width: 4,
            height: 3,
            samples: 2,
            filter: Filter::Mitchell,
            audit: true,
            build: Build::Best,
            ..Settings::default()
        };
        let frames = [FrameStats { audit: Some(AuditCounts::default()), ..frame(2, 1, 0, 0) }];
        let stats = RunStats {
            shot: "a.toml",
            settings: &RunSettings { picture, backend: "embree", threads: 2 },
            frames: &frames,
            run_up: None,
            eyes: Eyes::new(&frames),
            totals: Totals::new(&frames),
            memory: Memory::default(),
        };
        let json = serde_json::to_value(&stats).expect("plain data");
        let keys = |pointer: &str| -> Vec<String> {
            let object = json.pointer(pointer).and_then(|value| value.as_object());
            object.expect(pointer).keys().cloned().collect()
        };
        let sorted = |list: &str| -> Vec<String> {
            let mut keys: Vec<String> = list.split(' ').map(String::from).collect();
            keys.sort();
            keys
        };
        assert_eq!(keys(""), sorted("shot settings frames totals memory"));
        assert_eq!(keys("/frames/0"), sorted("frame mode seconds samples rays tracing audit"));
        assert_eq!(keys("/totals"), sorted("seconds samples rays tracing audit"));
        assert_eq!(
            keys("/frames/0/seconds"),
            sorted("total reproject verify trace light enhance filter write")
        );
        assert_eq!(keys("/totals/samples"), sorted("base good overlapped missed obscured spare"));
        assert_eq!(
            keys("/totals/rays"),
            sorted("primary verification shadow reflection refraction gathering")
        );
        assert_eq!(keys("/totals/tracing"), sorted("primary verification shadow bounced"));
        assert_eq!(
            keys("/totals/audit"),
            sorted("checked differing on_edge targets coverage coverage_on_edge mirrored")
        );
        assert_eq!(keys("/memory"), sorted("peak_bytes store_bytes bytes_per_sample"));
        assert_eq!(json["settings"]["width"], 4);
        assert_eq!(json["settings"]["filter"], "mitchell");
    }

    #[test]
    fn reads_the_high_water_mark() {
        assert_eq!(entry("VmPeak:\t 9 kB\nVmHWM:\t  12 kB\n", "VmHWM:"), Some(12 * 1024));
        assert_eq!(entry("VmHWM: many", "VmHWM:"), None);
    }
}
