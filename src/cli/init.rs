//! `afterimage init`: a commented shot file for a model, to start from.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;
use toml::Value;

use super::failure::Failure;
use super::shot_args::on_threads;
use super::terminal::Terminal;
use crate::output::{self, folder_of};
use crate::scene::turntable::{self, Fit, Look};

/// Last frame of the shot that is written.
const FRAMES: i32 = 48;
/// How far the camera turns around the model, degrees. Half-way between its two keys it comes nearer by the cosine of half of
/// it, which the distance of a turntable allows for.
const TURN: f64 = 30.0;

/// As typed.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  afterimage init statue.obj                     writes statue.toml
  afterimage init models/statue.obj -o walk.toml
  afterimage render statue.toml --frames 1 --png")]
pub struct InitArgs {
    /// The model (OBJ)
    #[arg(value_name = "MODEL.obj")]
    model: PathBuf,

    /// The shot file; what is there already is not overwritten [default: MODEL.toml in the current folder]
    #[arg(short, long, value_name = "SHOT.toml")]
    output: Option<PathBuf>,
}

impl InitArgs {
    /// Writes the file.
    pub fn execute(&self, terminal: &mut Terminal) -> Result<(), Failure> {
        on_threads(None, || self.write(terminal))
    }

    fn write(&self, terminal: &mut Terminal) -> Result<(), Failure> {
        let has_ending =
            |path: &Path, ending: &str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending));
        if !has_ending(&self.model, "obj") {
            return Err(Failure::Failed(format!(
                "{}: not a model (.obj), by its ending",
                self.model.display()
            )));
        }
        let shot = self.shot();
        if !has_ending(&shot, "toml") {
            return Err(Failure::Usage(format!("-o {}: shot files end in .toml", shot.display())));
        }
        // before the model is read: that may take a while
        let taken = || {
            let message = "it is there already, and is not overwritten: choose another name with -o";
            Failure::Failed(format!("{}: {message}", shot.display()))
        };
        if shot.symlink_metadata().is_ok() {
            return Err(taken());
        }
        let look = turntable::look(&self.model).map_err(Failure::of)?;
        for warning in &look.warnings {
            terminal.warn(&warning.0.to_string());
        }
        output::ensure_writable(&shot).map_err(Failure::of)?;
        let text = text(&look, &self.model_from(&shot)?);
        match output::write_new_bytes(&shot, text.as_bytes()) {
            Err(error) if error.source.kind() == ErrorKind::AlreadyExists => return Err(taken()),
            outcome => outcome.map_err(Failure::of)?,
        }
        terminal.result(&format!("{}: render it with `afterimage render {0}`", shot.display()));
        Ok(())
    }

    fn shot(&self) -> PathBuf {
        self.output.clone().unwrap_or_else(|| {
            let mut name = self.model.file_stem().unwrap_or_default().to_owned();
            name.push(".toml");
            PathBuf::from(name)
        })
    }

    /// The model's path as the shot file, which lies beside `shot`, must name it.
    fn model_from(&self, shot: &Path) -> Result<String, Failure> {
        let place = |path: &Path| {
            path.canonicalize().map_err(|error| Failure::of(format!("{}: {error}", path.display())))
        };
        let path = path_from(&place(folder_of(shot))?, &place(&self.model)?);
        path.into_os_string().into_string().map_err(|path| {
            Failure::Failed(format!(
                "{}: a shot file cannot name this path, which is not UTF-8: rename it",
                Path::new(&path).display()
            ))
        })
    }
}

/// The path from `folder` to `file`, both absolute and without links: with `..` where they have folders in common, otherwise
/// absolute.
fn path_from(folder: &Path, file: &Path) -> PathBuf {
    let common = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    // the root alone is nothing in common
    if common < 2 {
        return file.to_owned();
    }
    let mut path: PathBuf = folder.components().skip(common).map(|_| "..").collect();
    path.extend(file.components().skip(common));
    path
}

/// A shot of a model that is seen as `look` says, and lies at `model`.
fn text(look: &Look, model: &str) -> String {
    let Fit { center, radius, fov, .. } = look.fit;
    let turn = (TURN * 0.5).to_radians();
    let [first, last] = [-turn, turn].map(|turn| vector(look.fit.eye(turn), radius));
    let (target, file) = (vector(center, radius), Value::from(model));
    let mut text = format!(
        "\
# A shot for Afterimage. Check it with `afterimage info`, render it with `afterimage render`.
# Axes are right-handed, Y is up; angles are in degrees, colours are linear.

[render]
size = [1280, 720]      # pixels
samples = 2             # 2 x 2 samples a pixel
frames = \"1-{FRAMES}\"
rate = 24               # frames a second

# [output]
# path = \"out/name.####.exr\"

[background]
zenith = [0.12, 0.12, 0.12]
horizon = [0.35, 0.35, 0.35]
ground = [0.18, 0.18, 0.18]

# The model fits into the picture: it is {size} units across, around {target}.
# Between keys the camera moves; \"smooth\" starts and stops gently.
[camera]
interpolation = \"smooth\"

[[camera.key]]
frame = 1
eye = {first}
target = {target}
fov = {fov}                # vertical

[[camera.key]]
frame = {FRAMES}
eye = {last}
target = {target}

[[model]]
obj = {file}

# To move it, keys of its own; `rotate` turns it about its origin.
# [[model.key]]
# frame = 1
# rotate = [0, 0, 0]
#
# [[model.key]]
# frame = {FRAMES}
# rotate = [0, 90, 0]

[[light]]
name = \"key\"
type = \"directional\"
direction = [-0.5, -1, -0.6]    # in which the light travels
color = [1, 0.97, 0.92]
power = 0.8
# angle = 0.53                  # the size of the sun: soft shadows

[[light]]
name = \"fill\"
type = \"directional\"
direction = [0.8, -0.35, 0.4]
color = [0.85, 0.92, 1]
power = 0.3

[ambient]
color = [0.2, 0.2, 0.2]
",
        size = number(2.0 * radius, radius),
    );
    if !look.has_ambient {
        text += "everywhere = true       # no material says how it reflects ambient light (Ka is 0): as Kd\n";
    }
    text + "
# Light from a sky and from other surfaces, instead of [ambient]:
# [environment]
# sky = { elevation = 40, azimuth = 135 }
#
# [indirect]
# paths = 16
"
}

fn vector(vector: DVec3, size: f64) -> String {
    let [x, y, z] = vector.to_array().map(|coordinate| number(coordinate, size));
    format!("[{x}, {y}, {z}]")
}

/// To a thousandth of `size` or finer, as short as it goes.
fn number(value: f64, size: f64) -> String {
    let digits = (3.0 - size.log10().floor()).clamp(0.0, 60.0) as usize;
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    match text {
        "-0" => String::from("0"),
        // a whole number of the format has 64 bits
        text if !text.contains('.') && text.len() > 15 => format!("{text}.0"),
        text => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_fine_as_the_model() {
        let texts =
            [(1.23456, 1.0), (-0.0001, 1.0), (123_456.7, 5e5), (2e18, 1e18), (1.5e-9, 2e-9), (4.0, 3.0)];
        let texts = texts.map(|(value, size)| number(value, size));
        assert_eq!(texts, ["1.235", "0", "123457", "2000000000000000000.0", "0.0000000015", "4"]);
    }

    #[test]
    fn paths_lead_from_folder_to_file() {
        let from = |folder: &str, file: &str| path_from(Path::new(folder), Path::new(file));
        assert_eq!(from("/a/b", "/a/b/c/m.obj"), Path::new("c/m.obj"));
        assert_eq!(from("/a/b/c", "/a/m.obj"), Path::new("../../m.obj"));
        assert_eq!(from("/a/b", "/c/m.obj"), Path::new("/c/m.obj"));
        assert_eq!(from("/a/b", "/a/b/m.obj"), Path::new("m.obj"));
    }
}
