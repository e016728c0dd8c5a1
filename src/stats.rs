//! What a frame cost and what it reused: rays by kind, samples by status, seconds by phase.

use std::ops::AddAssign;

use serde::Serialize;

/// Seconds of wall-clock time, by phase. `total` holds the whole frame with all that is not in a phase.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[allow(missing_docs, reason = "the phases of the frame loop, by name")]
pub struct Seconds {
    pub total: f64,
    pub reproject: f64,
    pub verify: f64,
    pub trace: f64,
    pub enhance: f64,
    pub filter: f64,
    pub write: f64,
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
}

impl RayCounts {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.primary + self.verification + self.shadow + self.reflection + self.refraction
    }
}

/// What `--audit` found. Its own rays are in no other count.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct AuditCounts {
    /// Samples looked at.
    pub checked: u64,
    /// Samples that do not hold. The claim is that this is 0.
    pub differing: u64,
    /// Samples that hold within the named tolerance only: on an edge, or where surfaces coincide.
    pub on_edge: u64,
}

/// One frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct FrameStats {
    /// The frame's number.
    pub frame: i32,
    /// `base` (traced in full because nothing could be reused), `reproject` or `full`.
    pub mode: &'static str,
    /// By phase.
    pub seconds: Seconds,
    /// By status.
    pub samples: SampleCounts,
    /// By kind.
    pub rays: RayCounts,
    /// Only where an audit was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub audit: Option<AuditCounts>,
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
            if let Some(audit) = frame.audit {
                *sum.audit.get_or_insert_default() += audit;
            }
        }
        sum
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

/// The most memory that this process ever held, resident; 0 where the system does not tell.
pub fn peak_resident_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|rest| rest.trim().trim_end_matches("kB").trim().parse::<u64>().ok());
    kib.unwrap_or(0) * 1024
}

macro_rules! sum_fields {
    ($type:ty: $($field:ident),+) => {
        impl AddAssign for $type {
            fn add_assign(&mut self, other: Self) {
                $(self.$field += other.$field;)+
            }
        }
    };
}
sum_fields!(Seconds: total, reproject, verify, trace, enhance, filter, write);
sum_fields!(SampleCounts: base, good, overlapped, missed, obscured);
sum_fields!(RayCounts: primary, verification, shadow, reflection, refraction);
sum_fields!(AuditCounts: checked, differing, on_edge);
