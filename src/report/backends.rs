//! Comparison of several tracers on the same frames: measurements of each, and agreement of their pictures.

use serde::Serialize;

use super::both_ways::{BothTotals, Saving};
use crate::film::Film;
use crate::stats::Totals;

/// Tolerance for R, G or B (linear) of a pixel between two tracers: a share of the value, or of 1 if that is
/// more. It covers rounding to half floats, and hits that are a few roundings apart.
pub const AGREEMENT: f32 = 5e-3;

/// Maximum percentage of pixels that differ by more than [`AGREEMENT`]: those where a ray grazes an edge, or
/// where surfaces lie in the same place, and rounding decides which is seen.
const MOST_APART: f64 = 1.0;

/// Maximum percentage of pixels that differ if each sample gathers light by so many paths: one path that
/// meets something else is enough.
pub fn most_apart(paths: u32) -> f64 {
    let alike = 1.0 - MOST_APART / 100.0;
    100.0 * (1.0 - alike.powf(1.0 + f64::from(paths)))
}

/// Numbers of pixels that two tracers made alike or not.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Agreement {
    /// Number of pixels compared.
    pub pixels: u64,
    /// Number of pixels that differ by more than [`AGREEMENT`].
    pub apart: u64,
}

impl Agreement {
    /// Compares two films of the same size.
    pub fn between(a: &Film, b: &Film) -> Self {
        let planes: Vec<_> =
            ["R", "G", "B"].iter().filter_map(|name| a.values(name).zip(b.values(name))).collect();
        let pixels = planes.iter().map(|(a, b)| a.len().min(b.len())).min().unwrap_or(0);
        let alike = |a: f32, b: f32| (a - b).abs() <= AGREEMENT * a.abs().max(1.0);
        // written so that a value that is no number is apart
        let apart = |pixel: &usize| !planes.iter().all(|(a, b)| alike(a[*pixel], b[*pixel]));
        Self { pixels: pixels as u64, apart: (0..pixels).filter(apart).count() as u64 }
    }

    /// Percentage of the pixels that differ.
    pub fn percent_apart(&self) -> f64 {
        if self.pixels == 0 { 0.0 } else { 100.0 * self.apart as f64 / self.pixels as f64 }
    }

    /// Returns true if the tracers made the same pictures, from samples that gather light by so many paths.
    pub fn holds(&self, paths: u32) -> bool {
        self.percent_apart() <= most_apart(paths)
    }
}

impl std::ops::AddAssign for Agreement {
    fn add_assign(&mut self, other: Self) {
        self.pixels += other.pixels;
        self.apart += other.apart;
    }
}

/// Speed of each kind of ray: millions of rays a second, on one thread, while it is in the tracer; `None` if
/// no ray was cast.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[allow(missing_docs, reason = "one number a kind, by name")]
pub struct RaySpeeds {
    pub primary: Option<f64>,
    pub verification: Option<f64>,
    pub shadow: Option<f64>,
    /// Speed of rays of reflection, refraction and gathering.
    pub bounced: Option<f64>,
}

impl RaySpeeds {
    /// Computes the speeds over all frames of `totals`.
    pub fn new(totals: &Totals) -> Self {
        let (rays, seconds) = (&totals.rays, &totals.tracing);
        let speed =
            |rays: u64, seconds: f64| (rays > 0 && seconds > 0.0).then(|| rays as f64 / seconds / 1e6);
        Self {
            primary: speed(rays.primary, seconds.primary),
            verification: speed(rays.verification, seconds.verification),
            shadow: speed(rays.shadow, seconds.shadow),
            bounced: speed(rays.reflection + rays.refraction + rays.gathering, seconds.bounced),
        }
    }
}

/// Measurements of one tracer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BackendRun {
    /// Name of the tracer.
    pub backend: &'static str,
    /// Seconds for building its scene, once.
    pub build_seconds: f64,
    /// Growth of the process's memory meanwhile, bytes; 0 if the system does not tell.
    pub build_bytes: u64,
    /// Totals of the frames, reprojected and in full.
    pub totals: BothTotals,
    /// Saving over all frames, reprojected against full.
    pub saved: Saving,
    /// Speeds in the reprojected frames.
    pub speeds: RaySpeeds,
    /// Speeds in the frames in full.
    pub full_speeds: RaySpeeds,
    /// Agreement with the first tracer's pictures, reprojected and in full, over all frames; none for the
    /// first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub agreement: Option<[Agreement; 2]>,
}

impl BackendRun {
    /// Returns true if its pictures, from samples that gather light by so many paths, agree with the first
    /// tracer's.
    pub fn agrees(&self, paths: u32) -> bool {
        self.agreement.is_none_or(|both| both.iter().all(|agreement| agreement.holds(paths)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Plane, PlaneKind};
    use crate::stats::{RayCounts, TracingSeconds};

    fn film(values: [f32; 4]) -> Film {
        let plane = |name| Plane::new(name, PlaneKind::Half, &values);
        Film { width: 2, height: 2, planes: ["R", "G", "B"].map(plane).to_vec() }
    }

    #[test]
    fn counts_pixels_that_are_apart() {
        let agreement =
            Agreement::between(&film([0.0, 1.0, 200.0, 0.5]), &film([0.001, 1.1, 200.5, f32::NAN]));
        assert_eq!(agreement, Agreement { pixels: 4, apart: 2 });
        assert_eq!((agreement.percent_apart(), agreement.holds(0)), (50.0, false));
        assert!(Agreement::default().holds(0));
        assert!((most_apart(0) - 1.0).abs() < 1e-9 && (most_apart(16) - 15.7).abs() < 0.1);
    }

    #[test]
    fn speeds_are_rays_over_seconds_in_the_tracer() {
        let totals = Totals {
            rays: RayCounts {
                primary: 3_000_000,
                reflection: 1,
                refraction: 999_999,
                ..RayCounts::default()
            },
            tracing: TracingSeconds { primary: 1.5, bounced: 0.5, ..TracingSeconds::default() },
            ..Totals::default()
        };
        let speeds = RaySpeeds::new(&totals);
        assert_eq!((speeds.primary, speeds.bounced, speeds.shadow), (Some(2.0), Some(2.0), None));
    }
}
