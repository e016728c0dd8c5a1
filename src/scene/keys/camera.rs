//! `[camera]`, its keys, `[stereo]` and `[shutter]` of a shot file, as they are written: see [`shot_file`](super).

use schemars::JsonSchema;
use serde::Deserialize;

use super::toml_text::{At, List, Three};
use crate::animation::Interpolation;
use crate::scene::camera::Projection;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["key"]}, {"required": ["from"]}]))]
pub(crate) struct CameraTable {
    /// Camera of a glTF file, with its motion, instead of keys: "shot.glb#Name", or "shot.glb" for its first; relative to the shot
    /// file
    pub from: Option<At<String>>,
    /// With `from`: name of the glTF file's animation (as for models)
    pub animation: Option<At<String>>,
    /// Projection of the camera (perspective)
    pub projection: Option<Projection>,
    /// Between keys (linear)
    pub interpolation: Option<Interpolation>,
    /// Keys of the camera: its place, direction and lens at some frames
    #[serde(default)]
    #[schemars(length(min = 1))]
    pub key: Vec<At<CameraKey>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("anyOf" = [{"required": ["eye"]}, {"required": ["orbit"]}]))]
pub(crate) struct CameraKey {
    /// Number of the frame; may be fractional
    pub frame: At<f64>,
    /// Position of the camera; all keys use `eye`, or all use `orbit`
    pub eye: Option<Three>,
    /// [azimuth, elevation, distance] around `target`: degrees from +Z to +X, degrees above it
    pub orbit: Option<Three>,
    /// Point to look at; all keys use `target`, or all use `rotation`
    pub target: Option<Three>,
    /// [pitch, yaw, roll] in degrees: up, left, clockwise about the view axis
    pub rotation: Option<Three>,
    /// With `target`: bank, degrees clockwise (0)
    pub roll: Option<At<f64>>,
    /// Perspective cameras: vertical field of view, degrees (the previous key's; 40 in the first key)
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    pub fov: Option<At<f64>>,
    /// Orthographic cameras: height of what is seen, in the units of the models (the previous key's)
    #[schemars(range(min = 1e-18, max = 1e18))]
    pub height: Option<At<f64>>,
    /// Lens shift to the right and upwards, as shares of the picture's longer side (the previous key's; [0, 0] in the first key)
    #[schemars(inner(range(min = -100, max = 100)))]
    pub shift: Option<At<List<f64, 2>>>,
    /// Perspective cameras: radius of the lens, in the units of the models; 0: everything is sharp (the previous key's; 0 in the
    /// first key)
    #[schemars(range(min = 0, max = 1e18))]
    pub aperture: Option<At<f64>>,
    /// With `aperture`: distance along the view axis of what is sharp, in the units of the models (the previous key's; the
    /// target's distance)
    #[schemars(range(min = 1e-18, max = 1e18))]
    pub focus: Option<At<f64>>,
    /// Distance along the view axis nearer than which the camera sees nothing, in the units of the models (the previous key's; the
    /// next key's in keys before the first that has one)
    #[schemars(range(min = 0, max = 1e18))]
    pub near: Option<At<f64>>,
    /// Distance along the view axis farther than which the camera sees nothing, in the units of the models (as of `near`)
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1e18))]
    pub far: Option<At<f64>>,
    /// A camera cut: no interpolation from the previous key
    #[serde(default)]
    pub cut: bool,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("required" = ["separation"]))]
pub(crate) struct StereoTable {
    /// From the left eye to the right one, in the units of the models
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub separation: Option<At<f64>>,
    /// Distance from the camera at which both pictures agree, in the units of the models (infinity)
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub convergence: Option<At<f64>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ShutterTable {
    /// When it opens, in frames from each frame's own time (-0.25)
    #[schemars(range(min = -1, max = 1))]
    pub open: Option<At<f64>>,
    /// When it closes; at most 1 after it opens (0.25)
    #[schemars(range(min = -1, max = 1))]
    pub close: Option<At<f64>>,
    /// How far it is open over its time (all the time all open): points [time, openness], both from 0 to 1, in the order of time
    #[schemars(extend("minItems" = 2))]
    pub curve: Option<At<Vec<List<f64, 2>>>>,
}
