//! Shots of files with a camera and lights of their own. They are rendered by what `afterimage init` writes: the same text, and lights by the
//! tables that it writes as text.

use std::fmt::Write;
use std::path::Path;

use glam::{DAffine3, DVec3};

use super::SceneError;
use super::keys::LightTable;
use super::keys::toml_text::TomlText;
use super::model::copies::MOST_ADDED;
use super::shot::{self, Beside, ReadBefore, Shot};

/// Height of a picture whose width follows from the camera, pixels.
const HEIGHT: f64 = 720.0;

/// Ratios of width to height that are taken from a camera.
const RATIOS: std::ops::RangeInclusive<f64> = 0.1..=10.0;

/// Roll below which a camera is level, degrees: files keep rotations as single floats.
const LEAST_ROLL: f64 = 1e-4;

/// A shot file that shows another file.
pub struct Written {
    /// Text of the shot file.
    pub text: String,
    /// Decisions that were made for the user, in whole sentences.
    pub notes: Vec<String>,
}

/// The shot of a file with a camera and lights of its own.
pub(crate) struct BareShot {
    /// Text before its lights, and behind them.
    pub before: String,
    pub after: String,
    pub lights: Vec<LightTable>,
    /// Decisions that were made for the user, in whole sentences.
    pub notes: Vec<String>,
}

impl BareShot {
    /// Writes the shot.
    pub fn written(self) -> Written {
        let Self { before, lights, after, notes } = self;
        let lights: String = lights.iter().map(LightTable::text).collect();
        Written { text: format!("{before}{lights}{after}"), notes }
    }
}

/// Loads the shot of the file at `path`, which was `read`.
///
/// # Errors Those of the file and of what it names.
pub(crate) fn shot_of(
    path: &Path,
    bare: BareShot,
    read: ReadBefore,
    strict: bool,
) -> Result<Shot, SceneError> {
    let BareShot { before, after, lights, notes } = bare;
    let text = before + &after;
    // the column is one of our generated text, which nobody has seen
    let of_text = |error: &SceneError| error.path == path && error.column.is_some();
    let told = |error: SceneError| if of_text(&error) { SceneError::new(path, error.message) } else { error };
    let beside = Beside { read: Some(read), lights };
    let shot =
        shot::from_text_with(TomlText { path, text: &text }, strict, beside, MOST_ADDED).map_err(told)?;
    // it stands there twice: for the model, and for the text
    let mut files = shot.files;
    if let Some(last) = files.iter().rposition(|file| file == path) {
        files.remove(last);
    }
    Ok(Shot { notes, files, ..shot })
}

/// Size of a picture that is `ratio` times as wide as high, pixels. `None` if no picture is.
pub fn size_of_ratio(ratio: f64) -> Option<[u32; 2]> {
    RATIOS.contains(&ratio).then(|| [(ratio * HEIGHT).round() as u32, HEIGHT as u32])
}

/// Place of a camera at a frame.
pub struct CameraKey {
    /// Frame.
    pub frame: f64,
    /// Map from the camera, which looks along -Z, to the world.
    pub map: DAffine3,
    /// Lines of the key about its lens.
    pub lens: String,
}

/// Writes the keys of a camera, which jumps at `cuts`.
pub fn camera_keys(keys: impl Iterator<Item = CameraKey>, cuts: &[f64]) -> String {
    let (mut text, mut turned) = (String::new(), 0.0);
    for (i, CameraKey { frame, map, lens }) in keys.enumerate() {
        let View { eye, target, roll } = View::of(map);
        // the shorter way from key to key
        turned += (roll - turned + 180.0).rem_euclid(360.0) - 180.0;
        let _ = write!(
            text,
            "\n[[camera.key]]\nframe = {frame}\neye = {}\ntarget = {}\n",
            list(eye),
            list(target)
        );
        if f64::abs(turned) > LEAST_ROLL {
            let _ = writeln!(text, "roll = {turned}");
        }
        text += &lens;
        if i > 0 && frame.fract() == 0.0 && cuts.contains(&frame) {
            text += "cut = true\n";
        }
    }
    text
}

/// Place and direction of a camera.
struct View {
    eye: DVec3,
    target: DVec3,
    /// Degrees, clockwise.
    roll: f64,
}

impl View {
    /// View of a camera that looks along -Z of its node. The target is the point nearest to the origin, if it is before the camera.
    fn of(map: DAffine3) -> Self {
        let axis = |axis: DVec3| axis.normalize_or_zero();
        let (eye, forward) = (map.translation, axis(-map.matrix3.z_axis));
        let right = forward.cross(axis(map.matrix3.y_axis));
        let level = forward.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
        let roll = f64::atan2(-right.dot(level.cross(forward)), right.dot(level)).to_degrees();
        let ahead = -eye.dot(forward);
        let distance = if ahead > 1e-3 * eye.length() { ahead } else { 1.0 };
        Self { eye, target: eye + forward * distance, roll }
    }
}

/// Formats a vector with all of its digits.
pub fn list(vector: DVec3) -> String {
    let [x, y, z] = vector.to_array().map(number);
    format!("[{x}, {y}, {z}]")
}

/// Formats a number with all of its digits, so that it is one of TOML.
pub fn number(value: f64) -> String {
    // never a whole number of more than 64 bits
    format!("{value:?}")
}
