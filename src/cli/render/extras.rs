//! Files that `render` makes of finished frames: a contact sheet, a movie.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::failure::Failure;
use crate::cli::frames::paths::Report;
use crate::cli::frames::target::Target;
use crate::cli::say::terminal::Terminal;
use crate::output::movie::{self, Container, MovieError};
use crate::output::picture::Picture;
use crate::output::{WriteError, contact_sheet, png};
use crate::report::file::Destination;

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
pub struct ExtrasArgs {
    /// Also write one PNG with small pictures of the run's frames (60 at most, evenly chosen), each with its number
    /// [default: NAME.contact.png beside the frames]
    #[arg(long, value_name = "FILE.png", num_args = 0..=1)]
    #[allow(clippy::option_option, reason = "the option may have no value")]
    contact_sheet: Option<Option<PathBuf>>,

    /// Also pack the run's frames into a movie, at the shot's frame rate; needs FFmpeg
    #[arg(long, value_name = "FILE.mp4|FILE.gif")]
    movie: Option<PathBuf>,
}

/// Validated arguments.
#[derive(Debug, Clone)]
pub struct Extras {
    contact_sheet: Option<PathBuf>,
    movie: Option<(PathBuf, Container)>,
}

impl ExtrasArgs {
    /// Validates the arguments for the frames of `target`.
    pub fn settle(self, target: &Target) -> Result<Extras, Failure> {
        let sheet = self.contact_sheet.map(|path| path.unwrap_or_else(|| target.contact_sheet()));
        if let Some(path) = sheet.as_ref().filter(|path| ending(path) != "png") {
            let path = path.display();
            return Err(Failure::Usage(format!("--contact-sheet {path}: contact sheets end in .png")));
        }
        let movie = self.movie.map(|path| match ending(&path).as_str() {
            "mp4" => Ok((path, Container::Mp4)),
            "gif" => Ok((path, Container::Gif)),
            _ => Err(Failure::Usage(format!("--movie {}: movies end in .mp4 or .gif", path.display()))),
        });
        Ok(Extras { contact_sheet: sheet, movie: movie.transpose()? })
    }
}

impl Extras {
    /// The files, by option.
    pub fn reports(&self) -> impl Iterator<Item = Report<'_>> {
        let sheet = self.contact_sheet.iter().map(|path| ("--contact-sheet", path.as_path()));
        sheet.chain(self.movie.iter().map(|(path, _)| ("--movie", path.as_path())))
    }

    /// Fails before the first frame if the files could not be made after the last one.
    pub fn prepare(&self) -> Result<(), Failure> {
        for (option, path) in self.reports() {
            if !matches!(Destination::new(path).map_err(Failure::of)?, Destination::File(_)) {
                let path = path.display();
                return Err(Failure::Failed(format!(
                    "{option} {path}: this is not a regular file; choose another name"
                )));
            }
        }
        if self.movie.is_some() { movie::ensure_ffmpeg().map_err(Failure::of) } else { Ok(()) }
    }

    /// Writes the files from the frames of `target`, which all exist.
    pub fn write(&self, target: &Target, is_denoised: bool, terminal: &mut Terminal) -> Result<(), Failure> {
        if let Some(path) = &self.contact_sheet {
            let small = |frame| Ok((frame, contact_sheet::thumbnail(&target.picture(frame, is_denoised)?)));
            let frames = contact_sheet::chosen(target.frames());
            let frames = frames.into_iter().map(small).collect::<Result<Vec<_>, Failure>>()?;
            let sheet = contact_sheet::sheet(&frames);
            png::write_rgb(path, [sheet.width, sheet.height], &sheet.rgb).map_err(Failure::of)?;
            terminal.result(&format!("{:<9}{}, {} frames", "sheet", path.display(), frames.len()));
        }
        if let Some((path, container)) = &self.movie {
            let pictures = || -> Box<dyn Iterator<Item = Result<Picture, Failure>>> {
                let target = target.clone();
                let frames = target.frames().to_vec();
                Box::new(frames.into_iter().map(move |frame| target.picture(frame, is_denoised)))
            };
            movie::write_movie(path, *container, target.rate(), pictures)?;
            terminal.result(&format!("{:<9}{}, {} frames", "movie", path.display(), target.frames().len()));
        }
        Ok(())
    }
}

impl From<MovieError> for Failure {
    fn from(error: MovieError) -> Self {
        Self::of(error)
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        Self::of(error)
    }
}

fn ending(path: &Path) -> String {
    path.extension().and_then(OsStr::to_str).unwrap_or_default().to_lowercase()
}
