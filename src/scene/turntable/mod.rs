//! A bare OBJ becomes a shot: it stands on a floor under a soft light, and the camera goes once around it.
//!
//! The model and its light rest, so that what samples have gathered of that light is kept all the way round.

pub(in crate::scene) mod corners;
mod fit;
pub(crate) mod text;
mod up;

use std::path::Path;

use super::SceneError;
use super::import::meshes::read_model::ReadModel;
use super::import::usd::StageChoice;
use super::keys::toml_text::TomlText;
use super::model::copies::MOST_ADDED;
use super::shot::{self, Beside, ReadBefore, Shot};
use corners::Corners;
pub use fit::Fit;
pub use text::text;
pub use up::Up;

/// Number of frames of one turn.
pub const FRAMES: i32 = 120;

/// Choices of a turntable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// Axis of the file that points up; guessed if none is given.
    pub up: Option<Up>,
    /// Size of the picture that the model is to fill: width and height, pixels.
    pub size: [u32; 2],
    /// Of a glTF or USD file: name of the camera, or in USD its path; its first one if none is given.
    pub camera: Option<String>,
    /// Of a glTF file: name of the animation; the first ones if none is given.
    pub animation: Option<String>,
    /// Of a USD file: what of it is read.
    pub usd: StageChoice,
    /// Of a USD file: path of its RenderSettings; those that it names, if none is given.
    pub render_settings: Option<String>,
    /// Of a USD file: true if payloads that its camera does not see are left out.
    pub only_seen: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            up: None,
            size: [1280, 720],
            camera: None,
            animation: None,
            usd: StageChoice::default(),
            render_settings: None,
            only_seen: false,
        }
    }
}

/// Presentation of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Presentation {
    /// Way of the camera.
    pub fit: Fit,
    /// Axis of the file that points up.
    pub up: Up,
    /// Size of the picture: width and height, pixels.
    pub size: [u32; 2],
    /// Names of materials that are shown in light grey: all of the model's, if they are black throughout.
    pub black: Vec<String>,
    /// Decisions that were made for the user, in whole sentences.
    pub notes: Vec<String>,
}

/// Decides the presentation of the model at `path`.
///
/// # Errors Those of the OBJ and of its MTL files.
pub fn look(path: &Path, options: &Options) -> Result<Presentation, SceneError> {
    look_at(&ReadModel::at(path)?, options)
}

fn look_at(model: &ReadModel, options: &Options) -> Result<Presentation, SceneError> {
    let corners = Corners { positions: &model.obj.positions, triangles: &model.obj.triangles };
    let up = options.up.unwrap_or_else(|| Up::guess(&corners));
    let [width, height] = options.size.map(f64::from);
    let black = model.black_materials()?.unwrap_or_default();
    let other = if up == Up::Y { Up::Z } else { Up::Y };
    let guess = options
        .up
        .is_none()
        .then(|| format!("up is {up}, by what the model stands on (--up {other} if it lies on its side)"));
    let painted = (!black.is_empty())
        .then(|| String::from("all materials of the model are black: they are shown in light grey"));
    Ok(Presentation {
        fit: Fit::new(&corners, up, width / height),
        up,
        size: options.size,
        black,
        notes: guess.into_iter().chain(painted).collect(),
    })
}

/// Loads the turntable of the OBJ file at `path`.
///
/// # Errors Those of the OBJ and of its files.
pub(crate) fn shot(path: &Path, strict: bool, options: &Options) -> Result<Shot, SceneError> {
    let model = ReadModel::at(path)?;
    let look = look_at(&model, options)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let text = text(&look, &name);
    // the column is one of our generated text, which nobody has seen
    let of_text = |error: &SceneError| error.path == path && error.column.is_some();
    let told = |error: SceneError| if of_text(&error) { SceneError::new(path, error.message) } else { error };
    let beside = Beside { read: Some(ReadBefore::Obj(Box::new(model))), ..Beside::default() };
    let shot =
        shot::from_text_with(TomlText { path, text: &text }, strict, beside, MOST_ADDED).map_err(told)?;
    // it stands there twice: for the model, and for the text
    let mut files = shot.files;
    if let Some(last) = files.iter().rposition(|file| file == path) {
        files.remove(last);
    }
    Ok(Shot { notes: look.notes, files, ..shot })
}
