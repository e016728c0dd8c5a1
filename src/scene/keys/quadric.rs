//! The table of a quadric in a shot file, as it is written: see [`shot_file`](super).

use schemars::JsonSchema;
use serde::Deserialize;

use super::toml_text::{At, Three};

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct QuadricTable {
    /// Type of the quadric
    #[serde(rename = "type")]
    pub kind: QuadricType,
    /// Sphere, cylinder, cone, paraboloid, hyperboloid: radius, of the lower rim or of both (1)
    #[schemars(range(min = 1e-9, max = 1e9))]
    pub radius: Option<At<f64>>,
    /// Ellipsoid: radii along X, Y and Z
    #[schemars(inner(range(min = 1e-9, max = 1e9)))]
    pub radii: Option<Three>,
    /// Cylinder, cone, paraboloid, hyperboloid: from y = 0 up (2)
    #[schemars(range(min = 1e-9, max = 1e9))]
    pub height: Option<At<f64>>,
    /// Cone: radius of the upper end; 0: a tip (0)
    #[schemars(range(min = 0, max = 1e9))]
    pub top: Option<At<f64>>,
    /// Hyperboloid of one sheet: radius half way up (half the radius)
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub waist: Option<At<f64>>,
    /// Hyperboloid of two sheets: height of the gap between them
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub gap: Option<At<f64>>,
    /// Cylinder, cone, paraboloid, hyperboloid: without the disks that close it
    pub open: Option<At<bool>>,
    /// Name of a `[[material]]` (matt grey)
    pub material: Option<At<String>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum QuadricType {
    Sphere,
    Ellipsoid,
    Cylinder,
    Cone,
    Paraboloid,
    Hyperboloid,
    Plane,
}

impl QuadricType {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Ellipsoid => "ellipsoid",
            Self::Cylinder => "cylinder",
            Self::Cone => "cone",
            Self::Paraboloid => "paraboloid",
            Self::Hyperboloid => "hyperboloid",
            Self::Plane => "plane",
        }
    }

    /// Keys that describe its shape.
    pub fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Sphere => &["radius"],
            Self::Ellipsoid => &["radii"],
            Self::Cylinder | Self::Paraboloid => &["radius", "height", "open"],
            Self::Cone => &["radius", "top", "height", "open"],
            Self::Hyperboloid => &["radius", "height", "waist", "gap", "open"],
            Self::Plane => &[],
        }
    }
}
