//! What a frame cost and what it reused: rays by kind, samples by status, seconds by phase.

use std::fmt;
use std::ops::AddAssign;

use serde::Serialize;

use crate::settings::Settings;
use crate::stereo::Eye;

/// Seconds of wall-clock time, by phase.
///
/// The phases of a frame run tile by tile on all threads: their time is split by what the threads spent in
/// each. `reproject` has the pose, the commit to the tracer and scattering as well, `enhance` the shadow
/// rays of samples. `total` is the whole frame with what is in no phase, without the audit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[allow(missing_docs, reason = "the phases of the frame loop, by name")]
pub struct Seconds {
    /// All of the frame, `denoise` and `write` included.
    pub total: f64,
    pub reproject: f64,
    pub verify: f64,
    pub trace: f64,
    pub enhance: f64,
    pub filter: f64,
    /// Only where frames are denoised.
    #[serde(skip_serializing_if = "is_zero")]
    pub denoise: f64,
    pub write: f64,
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
    /// Kept, and serving no cell in this frame: in no total.
    pub spare: u64,
}

/// Rays that were cast, each under the kind that it served.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[allow(missing_docs, reason = "one count a kind, by name")]
pub struct RayCounts {
    pub primary: u64,
    /// Segments from the eye to reprojected samples.
    pub verification: u64,
    /// For primary samples and for what is seen in mirrors and through glass.
    pub shadow: u64,
    pub reflection: u64,
    pub refraction: u64,
    /// Of paths that gather light: from surface to surface, or to the sky.
    pub gathering: u64,
}

impl RayCounts {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.primary + self.verification + self.shadow + self.reflection + self.refraction + self.gathering
    }
}

/// Seconds that threads spent in the tracer, all of them together, by kind of ray. Beside the phases' seconds,
/// which are wall-clock time and have them within.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[allow(missing_docs, reason = "one number a kind, by name")]
pub struct TracingSeconds {
    pub primary: f64,
    pub verification: f64,
    pub shadow: f64,
    /// Reflection, refraction, and gathering.
    pub bounced: f64,
}

/// What `--audit` found. Its own rays are in no other count.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct AuditCounts {
    /// Samples looked at.
    pub checked: u64,
    /// Samples that do not hold, or whose pixel shows what no sample of it does. The claim is that this is 0.
    pub differing: u64,
    /// Samples that hold within the named tolerance only: on an edge, or where surfaces coincide.
    pub on_edge: u64,
}

/// One frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct FrameStats {
    /// The frame's number.
    pub frame: i32,
    /// Which of two eyes saw it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eye: Option<Eye>,
    /// Of the right eye: what is reused comes from the left eye's samples of this frame, and not from its own of the frame
    /// before.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub from_left: bool,
    /// `base` (traced in full because nothing could be reused), `reproject` or `full`.
    pub mode: &'static str,
    /// Of a base frame, and only where it holds: the shot says that it cuts here, or next to nothing of the frame before is in
    /// sight.
    #[serde(skip_serializing_if = "is_false")]
    pub cut: bool,
    /// By phase.
    pub seconds: Seconds,
    /// By status.
    pub samples: SampleCounts,
    /// By kind.
    pub rays: RayCounts,
    /// In the tracer, by kind.
    pub tracing: TracingSeconds,
    /// Only where an audit was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub audit: Option<AuditCounts>,
    /// Of a frame with several exposures the first of which was traced in full: what is told by that one.
    #[serde(skip)]
    pub full: Option<FullEstimate>,
}

fn is_false(holds: &bool) -> bool {
    !holds
}

/// Sums over frames.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Totals {
    /// By phase.
    pub seconds: Seconds,
    /// By status.
    pub samples: SampleCounts,
    /// By kind.
    pub rays: RayCounts,
    /// In the tracer, by kind.
    pub tracing: TracingSeconds,
    /// Only where an audit was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub audit: Option<AuditCounts>,
}

impl Totals {
    /// The sum over `frames`.
    pub fn of<'a>(frames: impl IntoIterator<Item = &'a FrameStats>) -> Self {
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

/// What each of two eyes cost, and what the right one took from the left one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Eyes {
    /// The sum over its frames.
    pub left: Totals,
    /// The same.
    pub right: Totals,
    /// Over those frames of the right eye that were made from the left eye's samples.
    pub from_left: FromLeft,
}

/// Samples that the right eye took from the left one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct FromLeft {
    /// How many frames of the right eye were made so. The others were traced in full, or go on with its own samples while the
    /// camera rests.
    pub frames: u64,
    /// Samples of the left eye that the right one shows in them.
    pub reused: u64,
    /// Of so many.
    pub samples: u64,
    /// The share of them.
    pub percent: f64,
}

impl Eyes {
    /// Of the frames of a run; `None` where there is one eye.
    pub fn of<'a>(frames: impl IntoIterator<Item = &'a FrameStats>) -> Option<Self> {
        let frames: Vec<&FrameStats> = frames.into_iter().filter(|frame| frame.eye.is_some()).collect();
        let of = |eye| Totals::of(frames.iter().copied().filter(|frame| frame.eye == Some(eye)));
        let made = || frames.iter().copied().filter(|frame| frame.from_left);
        let SampleCounts { good, overlapped, .. } = Totals::of(made()).samples;
        let samples = Totals::of(made()).samples.total();
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
    /// Most that the process ever held (resident).
    pub peak_bytes: u64,
    /// The sample store, both halves of it.
    pub store_bytes: u64,
    /// `store_bytes` over the samples of a frame.
    pub bytes_per_sample: f64,
}

impl Memory {
    /// The same, with the most that this process ever held until now.
    pub fn with_peak(self) -> Self {
        Self { peak_bytes: peak_bytes().unwrap_or(self.peak_bytes), ..self }
    }
}

/// Most bytes that this process ever held in memory (resident); `None` where the system does not tell.
pub fn peak_bytes() -> Option<u64> {
    entry(&std::fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// Bytes that this process holds in memory now (resident); `None` where the system does not tell.
pub fn held_bytes() -> Option<u64> {
    entry(&std::fs::read_to_string("/proc/self/status").ok()?, "VmRSS:")
}

/// An entry of Linux's process status, or of its account of memory, that is in KiB.
pub(crate) fn entry(status: &str, name: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}

impl FrameStats {
    /// Adds an exposure after the first one, of the same frame.
    pub fn add_exposure(&mut self, other: &Self) {
        self.seconds += other.seconds;
        self.samples += other.samples;
        self.rays += other.rays;
        self.tracing += other.tracing;
        if let Some(audit) = other.audit {
            *self.audit.get_or_insert_default() += audit;
        }
    }

    /// How the frame came about, in a word for people: its mode, or `cut`.
    pub fn kind(&self) -> &'static str {
        if self.cut { "cut" } else { self.mode }
    }
}

impl Seconds {
    /// Without denoising and the writing of files, which cost the same whatever made the picture.
    pub fn rendering(&self) -> f64 {
        self.total - self.denoise - self.write
    }
}

impl SampleCounts {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.base + self.reused() + self.missed + self.obscured
    }

    /// Those that were not traced.
    pub fn reused(&self) -> u64 {
        self.good + self.overlapped
    }
}

/// What tracing every sample of a frame would cast, estimated in a run that does not do it.
///
/// One primary ray a sample; shadow and gathering rays a sample as in the last base frame, where they were counted;
/// reflection and refraction rays as cast, which is too few where the camera rests and some are spared: no more is said
/// to be saved than is. `compare` measures instead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FullEstimate {
    /// Shadow rays, and rays that gather light.
    lighting_per_sample: f64,
}

impl FullEstimate {
    /// From a frame that was traced in full; `None` where `frame` was not.
    pub fn from_base(frame: &FrameStats) -> Option<Self> {
        let samples = frame.samples.total();
        let full = samples > 0 && frame.samples.base == samples;
        let lighting = (frame.rays.shadow + frame.rays.gathering) as f64;
        full.then(|| Self { lighting_per_sample: lighting / samples as f64 }).or(frame.full)
    }

    /// Rays of `frame`, had it been traced in full.
    pub fn rays(&self, frame: &FrameStats) -> f64 {
        let each = 1.0 + self.lighting_per_sample;
        each * frame.samples.total() as f64 + (frame.rays.reflection + frame.rays.refraction) as f64
    }
}

/// Percent of `full` that `cast` leaves out; negative where it is more.
pub fn saved_percent(cast: f64, full: f64) -> f64 {
    if full > 0.0 { 100.0 * (1.0 - cast / full) } else { 0.0 }
}

/// A percentage with one decimal, and without the sign of what rounds to zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Percent(pub f64);

impl fmt::Display for Percent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = format!("{:.1}", self.0);
        // numbers stand to the right
        let width = f.width().unwrap_or(0);
        write!(f, "{:>width$}", if text == "-0.0" { "0.0" } else { &text })
    }
}

/// What was saved, for people. Where much more was taken, a percentage far below zero says little: how many times as much does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Saved {
    /// Of what is compared with; negative where up to twice as much was taken.
    Percent(Percent),
    /// So many times as much was taken: more than 2.
    Times(f64),
}

impl Saved {
    /// Of `full`, where `taken` was taken; `None` where that is nothing.
    pub fn of(taken: f64, full: f64) -> Option<Self> {
        (full > 0.0).then(|| Self::of_percent(saved_percent(taken, full)))
    }

    /// By [`saved_percent`].
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

/// The settings of a run as its statistics state them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunSettings {
    /// What decides the pictures.
    #[serde(flatten)]
    pub picture: Settings,
    /// Which tracer answered the rays.
    pub backend: &'static str,
    /// That worked.
    pub threads: usize,
}

/// All that `--stats` writes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunStats<'a> {
    /// The shot's file as it was named.
    pub shot: &'a str,
    /// Of the run.
    pub settings: &'a RunSettings,
    /// Frames that were written, in the order of rendering.
    pub frames: &'a [FrameStats],
    /// The sum over frames that were rendered only because others are inferred from them; in no other
    /// sum.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run_up: Option<Totals>,
    /// Of two eyes, what each of them cost.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eyes: Option<Eyes>,
    /// The sum over `frames`.
    pub totals: Totals,
    /// Of the process.
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
sum_fields!(Seconds: total, reproject, verify, trace, enhance, filter, denoise, write);
sum_fields!(SampleCounts: base, good, overlapped, missed, obscured, spare);
sum_fields!(RayCounts: primary, verification, shadow, reflection, refraction, gathering);
sum_fields!(TracingSeconds: primary, verification, shadow, bounced);
sum_fields!(AuditCounts: checked, differing, on_edge);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Budget, Build, Filter, Mode};

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
        audited.audit = Some(AuditCounts { checked: 10, differing: 1, on_edge: 2 });
        let totals = Totals::of(&[frame(1, 10, 0, 5), audited]);
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
        let eyes = Eyes::of(&[left, made, at_rest]).expect("there are two");
        let FromLeft { frames, reused, samples, percent } = eyes.from_left;
        assert_eq!((frames, reused, samples, percent), (1, 75, 100, 75.0));
        assert_eq!((eyes.left.samples.base, eyes.right.samples.total()), (100, 200));
        assert_eq!(Eyes::of(&[frame(1, 100, 0, 5)]), None);
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
            overscan: 0,
            crop: None,
            samples: 2,
            refinement: None,
            filter: Filter::Mitchell,
            filter_radius: None,
            depth: 4,
            reflections: 4,
            paths: 0,
            paths_per_frame: 16,
            budget: Budget::None,
            bounces: 2,
            clamp: None,
            occlusion_rays: 16,
            occlusion_radius: 1.0,
            tree_memory: 256,
            stereo: None,
            shutter: None,
            exposures: 16,
            mode: Mode::Auto,
            reuse: Default::default(),
            base_every: 0,
            caustics: Default::default(),
            base_place: Default::default(),
            layers: crate::layers::Layers::ALL,
            background: crate::settings::Backdrop::default(),
            audit: true,
            build: Build::Best,
        };
        let frames = [FrameStats { audit: Some(AuditCounts::default()), ..frame(2, 1, 0, 0) }];
        let stats = RunStats {
            shot: "a.toml",
            settings: &RunSettings { picture, backend: "embree", threads: 2 },
            frames: &frames,
            run_up: None,
            eyes: Eyes::of(&frames),
            totals: Totals::of(&frames),
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
        assert_eq!(keys("/frames/0/seconds"), sorted("total reproject verify trace enhance filter write"));
        assert_eq!(keys("/totals/samples"), sorted("base good overlapped missed obscured spare"));
        assert_eq!(
            keys("/totals/rays"),
            sorted("primary verification shadow reflection refraction gathering")
        );
        assert_eq!(keys("/totals/tracing"), sorted("primary verification shadow bounced"));
        assert_eq!(keys("/totals/audit"), sorted("checked differing on_edge"));
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
