//! Build quality: time to build against time to trace.

use embree4_sys as sys;

/// Time to spend on building the acceleration structure.
///
/// Embree's fourth level, refitting, is missing on purpose: it serves meshes whose vertices move, and the
/// buffers here never change. What deforms is built anew, in a scene that takes the other's
/// [place](crate::Scene::set_instance_scene).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildQuality {
    /// Fastest to build: for scenes that change each frame.
    Low,
    /// The default.
    Medium,
    /// Spatial splits: 2 to 3 times the build time of `Medium`, up to 10 % faster rays.
    High,
}

impl BuildQuality {
    pub(crate) fn raw(self) -> sys::RTCBuildQuality {
        match self {
            Self::Low => sys::RTC_BUILD_QUALITY_LOW,
            Self::Medium => sys::RTC_BUILD_QUALITY_MEDIUM,
            Self::High => sys::RTC_BUILD_QUALITY_HIGH,
        }
    }
}
