//! Command-line options of a bare model, which is shown on a turntable.

use std::path::Path;

use clap::{Args, ValueEnum};

use super::failure::Failure;
use super::usd_args::UsdArgs;
use crate::scene::turntable::{self, Up};
use crate::scene::usd;

/// Axes by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum UpArg {
    /// Y, as in most OBJ files
    Y,
    /// Z, as some CAD and modelling programs write
    Z,
}

impl From<UpArg> for Up {
    fn from(axis: UpArg) -> Self {
        match axis {
            UpArg::Y => Self::Y,
            UpArg::Z => Self::Z,
        }
    }
}

/// Returns true if a file is a bare model, by its ending.
pub fn is_model(path: &Path) -> bool {
    ends_in(path, &["obj", "ply", "gltf", "glb"]) || is_usd(path)
}

/// Returns true if a file is a glTF file, by its ending.
pub fn is_gltf(path: &Path) -> bool {
    ends_in(path, &["gltf", "glb"])
}

/// Returns true if a file is a USD file, by its ending.
pub fn is_usd(path: &Path) -> bool {
    ends_in(path, &usd::ENDINGS)
}

fn ends_in(path: &Path, endings: &[&str]) -> bool {
    path.extension().is_some_and(|own| endings.iter().any(|ending| own.eq_ignore_ascii_case(ending)))
}

/// Arguments for bare models, as typed.
#[derive(Debug, Clone, Default, Args)]
pub struct BareModelArgs {
    /// For a bare model: the axis of its file that points up [default: guessed from what the model stands on]
    #[arg(long, value_enum, value_name = "AXIS")]
    pub up: Option<UpArg>,

    /// For a bare glTF or USD file: the camera to look through; of USD its name or its path [default: the one that its render settings
    /// name, or its first]
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,

    /// For a bare glTF file: the animation to show [default: its first, and all that move other things]
    #[arg(long, value_name = "NAME")]
    pub animation: Option<String>,

    /// What of a USD file is read.
    #[command(flatten)]
    pub usd: UsdArgs,
}

impl BareModelArgs {
    /// Options of the model at `path`. Refuses those that the file has no use for.
    pub fn options(&self, path: &Path, size: Option<(u32, u32)>) -> Result<turntable::Options, Failure> {
        let Self { up, camera, animation, usd } = self;
        let usage = |text: &str| Err(Failure::Usage(String::from(text)));
        if up.is_some() && !is_model(path) {
            return usage("--up is for bare models: in a shot file, write `rotate` into the [[model]]");
        }
        if up.is_some() && is_gltf(path) {
            return usage("--up is for OBJ and PLY files: in glTF files Y is up");
        }
        if up.is_some() && is_usd(path) {
            return usage("--up is for OBJ and PLY files: USD files say what is up");
        }
        if camera.is_some() && !is_gltf(path) && !is_usd(path) {
            return usage(
                "--camera is for bare glTF and USD files: in a shot file, write `from = \"shot.glb#NAME\"` into [camera]",
            );
        }
        if let Some(option) = usd.first().filter(|_| !is_usd(path)) {
            return Err(Failure::Usage(format!(
                "{option} is for bare USD files: in a shot file, write `stage` into the [[model]]"
            )));
        }
        if animation.is_some() && !is_gltf(path) {
            return usage(
                "--animation is for bare glTF files: in a shot file, write `animation` into the [[model]]",
            );
        }
        let default = turntable::Options::default();
        let size = size.map_or(default.size, |(width, height)| [width, height]);
        Ok(turntable::Options {
            up: up.map(Up::from),
            size,
            camera: camera.clone(),
            animation: animation.clone(),
            usd: usd.choice(),
            render_settings: usd.render_settings.clone(),
            only_seen: usd.only_seen,
        })
    }
}

/// Note on the angle by which the camera goes around a model from the first of these frames to the last. None for a full turn, and for
/// one frame alone.
pub fn turn_note(frames: &[i32]) -> Option<String> {
    let last = |frame: i32| frame.clamp(1, turntable::FRAMES + 1);
    let mut at: Vec<i32> = frames.iter().copied().map(last).collect();
    at.sort_unstable();
    at.dedup();
    let step = at.windows(2).map(|pair| pair[1] - pair[0]).min()?;
    let turned = at[at.len() - 1] - at[0];
    let degrees = 360 * turned / turntable::FRAMES;
    // the last frame of a full turn is a step before the first one of the next
    (turned + step < turntable::FRAMES).then(|| {
        format!(
            "these frames go {degrees} of 360 degrees around the model: all of the turn is --frames 1-{}",
            turntable::FRAMES
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_usd_files_are_for_these_alone() {
        let args = BareModelArgs {
            usd: UsdArgs { mask: vec![String::from("/World")], ..UsdArgs::default() },
            ..BareModelArgs::default()
        };
        for name in ["a.obj", "a.glb", "a.toml"] {
            let told = format!("{:?}", args.options(Path::new(name), None).err());
            assert!(told.contains("--mask is for bare USD files: in a shot file, write `stage`"), "{told}");
        }
        let options = args.options(Path::new("a.usdz"), None).ok();
        assert_eq!(options.map(|options| options.usd.mask), Some(vec![String::from("/World")]));
        let camera = BareModelArgs { camera: Some(String::from("main")), ..BareModelArgs::default() };
        assert!(
            camera.options(Path::new("a.usda"), None).is_ok()
                && camera.options(Path::new("a.ply"), None).is_err()
        );
    }

    #[test]
    fn a_part_of_the_turn_says_how_large_it_is() {
        let degrees = |frames: Vec<i32>| {
            let note = turn_note(&frames)?;
            let text = note.strip_prefix("these frames go ")?.split(' ').next()?;
            text.parse::<i32>().ok()
        };
        assert_eq!(degrees((1..=24).collect()), Some(69));
        assert_eq!(degrees((31..=61).collect()), Some(90));
        assert_eq!(degrees((1..=60).step_by(4).collect()), Some(168));
        assert_eq!(degrees(vec![1, 31]), Some(90));
        assert_eq!(degrees(vec![1, 2, 61]), Some(180));
        assert_eq!(degrees((1..=120).collect()), None);
        assert_eq!(degrees((1..=120).step_by(2).collect()), None);
        assert_eq!(degrees((1..=1000).collect()), None);
        // the camera rests after the turn
        assert_eq!(degrees((112..=200).collect()), Some(27));
        assert_eq!(degrees(vec![7]), None);
    }
}
