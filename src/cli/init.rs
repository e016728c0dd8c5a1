//! `afterimage init`: a commented shot file for a model, to start from.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use clap::Args;

use super::args::on_threads;
use super::bare_model::{BareModelArgs, is_gltf, is_model, is_usd};
use super::failure::Failure;
use super::say::terminal::Terminal;
use crate::output::{self, folder_of};
use crate::scene::{gltf, turntable, usd};

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  afterimage init statue.obj                     writes statue.toml
  afterimage init models/statue.obj -o walk.toml
  afterimage render statue.toml --frames 1 --png")]
pub struct InitArgs {
    /// The model (OBJ, PLY, glTF, USD)
    #[arg(value_name = "MODEL")]
    model: PathBuf,

    /// The shot file; what is there already is not overwritten [default: MODEL.toml in the current folder]
    #[arg(short, long, value_name = "SHOT.toml")]
    output: Option<PathBuf>,

    /// The model's axis, camera and animation.
    #[command(flatten)]
    bare: BareModelArgs,
}

impl InitArgs {
    /// Writes the file.
    pub fn execute(&self, terminal: &mut Terminal) -> Result<(), Failure> {
        on_threads(None, || self.write(terminal))
    }

    fn write(&self, terminal: &mut Terminal) -> Result<(), Failure> {
        if !is_model(&self.model) {
            return Err(Failure::Failed(format!(
                "{}: not a model (.obj, .ply, .gltf, .glb, .usda, .usdc, .usdz), by its ending",
                self.model.display()
            )));
        }
        let shot = self.shot();
        if !shot.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
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
        let options = self.bare.options(&self.model, None)?;
        let (text, notes) = if is_gltf(&self.model) || is_usd(&self.model) {
            output::ensure_writable(&shot).map_err(Failure::of)?;
            let name = self.model_from(&shot)?;
            let text = if is_gltf(&self.model) { gltf::text } else { usd::text };
            let written = text(&self.model, &name, &options).map_err(Failure::of)?;
            (written.text, written.notes)
        } else {
            let look = turntable::look(&self.model, &options).map_err(Failure::of)?;
            output::ensure_writable(&shot).map_err(Failure::of)?;
            (turntable::text(&look, &self.model_from(&shot)?), look.notes)
        };
        notes.iter().for_each(|note| terminal.note(note));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_lead_from_folder_to_file() {
        let from = |folder: &str, file: &str| path_from(Path::new(folder), Path::new(file));
        assert_eq!(from("/a/b", "/a/b/c/m.obj"), Path::new("c/m.obj"));
        assert_eq!(from("/a/b/c", "/a/m.obj"), Path::new("../../m.obj"));
        assert_eq!(from("/a/b", "/c/m.obj"), Path::new("/c/m.obj"));
        assert_eq!(from("/a/b", "/a/b/m.obj"), Path::new("m.obj"));
    }
}
