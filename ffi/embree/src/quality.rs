//! Build quality: time to build against time to trace.

use embree4_sys as sys;

/// Time to spend on building the acceleration structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildQuality {
    /// Fastest to build: for scenes that change each frame.
    Low,
    /// The default.
    Medium,
    /// Spatial splits: 2 to 3 times the build time of `Medium`, up to 10 % faster rays.
    High,
    /// For meshes whose [vertices move](crate::Scene::set_vertices). The first commit builds a tree for each mesh as
    /// `Medium` does; later ones keep it, and make the boxes of its nodes anew for the vertices of the time. What comes out
    /// follows from the vertices of the first commit and those of the last one, whatever was between.
    Refit,
}

impl BuildQuality {
    /// Quality of a scene.
    pub(crate) fn of_scene(self) -> sys::RTCBuildQuality {
        // a scene of low quality has a tree for each mesh, which is what can be refitted
        if self == Self::Refit { Self::Low.of_mesh() } else { self.of_mesh() }
    }

    /// Quality of a mesh in a scene.
    pub(crate) fn of_mesh(self) -> sys::RTCBuildQuality {
        match self {
            Self::Low => sys::RTC_BUILD_QUALITY_LOW,
            Self::Medium => sys::RTC_BUILD_QUALITY_MEDIUM,
            Self::High => sys::RTC_BUILD_QUALITY_HIGH,
            Self::Refit => sys::RTC_BUILD_QUALITY_REFIT,
        }
    }

    /// Flags of a scene.
    pub(crate) fn scene_flags(self) -> sys::RTCSceneFlags {
        // in other scenes Embree forgets after a commit how it has built, and builds anew
        if self == Self::Refit { sys::RTC_SCENE_FLAG_DYNAMIC } else { sys::RTC_SCENE_FLAG_NONE }
    }
}
