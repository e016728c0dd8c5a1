//! Where frames go: one EXR each, and a preview beside it if wanted.

use std::fs::FileType;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::failure::Failure;
use crate::denoise;
use crate::film::Plane;
use crate::frame::Finished;
use crate::layers::Layers;
use crate::output::exr::{Packing, Windows};
use crate::output::fingerprint::Kind;
use crate::output::picture::Picture;
use crate::output::{self, Fingerprint, FrameMeta, OutputPattern, exr, png};
use crate::settings::{FileFormat, Settings};

/// Names that are fit for the frames of a run.
#[derive(Debug, Clone)]
pub struct Target {
    pattern: OutputPattern,
    previews: Option<OutputPattern>,
    /// In rising order.
    frames: Vec<i32>,
    text: String,
    shot: String,
    rate: (i32, u32),
    layers: Layers,
    windows: Windows,
    format: FileFormat,
}

/// What is there of a frame before a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Left {
    /// No file.
    Nothing,
    /// No EXR file, or a part of one.
    Damaged,
    /// A picture that does not say what it was made from.
    Unknown,
    /// A frame that was made from something else.
    Other(Vec<Kind>),
    /// The frame, but not its preview.
    NoPreview,
    /// All files that the run would write.
    Finished,
}

impl Target {
    /// `text` names the files, with `####` or `%04d` for the frame's number (see [`OutputPattern`]) or just
    /// their folder; `shot` is the name of the shot; `frames` are those asked for, in rising order; `rate` is
    /// frames a second; `settings` say which layers and pixels are written, and `format` how.
    pub fn new(
        text: &str,
        shot: &str,
        frames: Vec<i32>,
        png: bool,
        rate: (i32, u32),
        (settings, format): (&Settings, FileFormat),
    ) -> Result<Self, Failure> {
        let pattern = OutputPattern::parse(text, shot, "exr")
            .map_err(|error| Failure::Usage(format!("`{text}` cannot name the frames: {error}")))?;
        let first = frames.first().copied().unwrap_or(0);
        let exr = pattern.at(first).extension().is_some_and(|kind| kind.eq_ignore_ascii_case("exr"));
        if !exr {
            return Err(Failure::Usage(format!(
                "`{text}` does not end in .exr: frames are EXR files; --png writes previews beside them"
            )));
        }
        let previews = png.then(|| pattern.with_extension("png"));
        let (text, shot) = (text.to_owned(), shot.to_owned());
        let (layers, windows) = (settings.layers, Windows::of(settings));
        Ok(Self { pattern, previews, frames, text, shot, rate, layers, windows, format })
    }

    /// As it was named.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Those asked for, in rising order.
    pub fn frames(&self) -> &[i32] {
        &self.frames
    }

    /// Frames a second, as a fraction.
    pub fn rate(&self) -> (i32, u32) {
        self.rate
    }

    /// Where a contact sheet goes that nobody has named.
    pub fn contact_sheet(&self) -> PathBuf {
        self.folder().join(format!("{}.contact.png", self.shot))
    }

    /// A frame that is finished, as its preview shows it, whether it has one or not.
    pub fn picture(&self, frame: i32, is_denoised: bool) -> Result<Picture, Failure> {
        let picture = match &self.previews {
            Some(previews) => Picture::of_png(&previews.at(frame)),
            None => {
                let channels = if is_denoised { denoise::PLANES } else { ["R", "G", "B"] };
                Picture::of_exr(&self.exr(frame), channels)
            }
        };
        picture.map_err(Failure::of)
    }

    /// The EXR of `frame`.
    pub fn exr(&self, frame: i32) -> PathBuf {
        self.pattern.at(frame)
    }

    /// Where all of them lie.
    pub fn folder(&self) -> &Path {
        let folder = self.pattern.folder();
        if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
    }

    /// Whether `name` in the folder is that of a frame asked for, or of its preview.
    pub fn has_name(&self, name: &str) -> bool {
        let frame = |pattern: &OutputPattern| pattern.frame_of(name);
        let frame = frame(&self.pattern).or_else(|| self.previews.as_ref().and_then(frame));
        frame.is_some_and(|frame| self.frames.binary_search(&frame).is_ok())
    }

    /// That nothing but files stands under the names of frames: others cannot be read to see whether a frame
    /// is finished (a FIFO may never end), nor replaced without loss.
    pub fn check(&self) -> Result<(), Failure> {
        let Ok(entries) = self.folder().read_dir() else { return Ok(()) };
        for entry in entries.filter_map(Result::ok) {
            let is_file =
                |kind: FileType| kind.is_file() || (kind.is_symlink() && leads_to_file(&entry.path()));
            let is_ours = entry.file_name().to_str().is_some_and(|name| self.has_name(name));
            if is_ours && !entry.file_type().is_ok_and(is_file) {
                return Err(Failure::Failed(format!(
                    "{}: a frame is to have this name, and something stands there that is not a regular file: \
                     remove it, or choose another name with -o",
                    self.folder().join(entry.file_name()).display()
                )));
            }
        }
        Ok(())
    }

    /// Makes the folder and tries it, so that nothing is rendered for a folder that cannot be written; and
    /// removes what killed runs left of these frames.
    pub fn prepare(&self) -> Result<(), Failure> {
        let first = self.frames.first().copied().unwrap_or(0);
        output::ensure_writable(&self.exr(first)).map_err(Failure::of)?;
        output::remove_leftovers(self.folder(), |name| self.has_name(name));
        Ok(())
    }

    /// What an earlier run left of `frame`, if it is to be what `wanted` says. Pixels are read only where all else fits.
    pub fn left(&self, frame: i32, wanted: &Fingerprint) -> Left {
        let path = self.exr(frame);
        if path.symlink_metadata().is_err() {
            return Left::Nothing;
        }
        match exr::fingerprint(&path) {
            Err(_) => return Left::Damaged,
            Ok(None) => return Left::Unknown,
            Ok(Some(found)) if found != *wanted => return Left::Other(wanted.changes(&found)),
            Ok(Some(_)) => {}
        }
        if self
            .previews
            .as_ref()
            .is_some_and(|previews| png::fingerprint(&previews.at(frame)) != Some(*wanted))
        {
            return Left::NoPreview;
        }
        if exr::is_whole(&path) { Left::Finished } else { Left::Damaged }
    }

    /// Writes a frame, with its `denoised` picture if there is one, and adds the time this took to its statistics. Returns
    /// the EXR's path. The preview shows the denoised picture. Both files say what the frame was `made_from`.
    ///
    /// The preview comes first: a frame counts as finished by its EXR.
    pub fn write(
        &self,
        finished: &mut Finished,
        denoised: Option<&[Plane; 3]>,
        made_from: Option<Fingerprint>,
        packing: Packing<'_>,
    ) -> Result<PathBuf, Failure> {
        let start = Instant::now();
        let frame = finished.stats.frame;
        let (size, [width, height]) = ([finished.film.width, finished.film.height], self.windows.picture);
        if let Some(previews) = &self.previews {
            let path = previews.at(frame);
            let planes = match denoised {
                Some(planes) => planes.each_ref(),
                None => png::colors(&finished.film).map_err(Failure::of)?,
            };
            png::write_colors(&path, size, planes, made_from).map_err(Failure::of)?;
        }
        let camera = &finished.camera;
        let aspect = width as f32 / height as f32;
        let meta = FrameMeta {
            frame,
            rate: self.rate,
            world_to_camera: camera.world_to_camera().to_cols_array(),
            world_to_ndc: camera.world_to_ndc(aspect).to_cols_array(),
            comments: format!("frame {frame}, {}, {}", finished.stats.mode, finished.backend.name()),
            shot: self.shot.clone(),
            fingerprint: made_from,
            layers: finished.about_layers.clone(),
        };
        let path = self.exr(frame);
        // more layers may have been made than are to be written: those that a denoiser needs
        let planes = finished.film.planes.iter().filter(|plane| self.layers.has_plane(&plane.name));
        let planes = planes.chain(denoised.into_iter().flatten());
        exr::write_planes(&path, self.windows, planes, &meta, self.format, packing).map_err(Failure::of)?;
        let seconds = start.elapsed().as_secs_f64();
        finished.stats.seconds.write += seconds;
        finished.stats.seconds.total += seconds;
        Ok(path)
    }
}

/// Or to nothing, and is then replaced itself.
fn leads_to_file(link: &Path) -> bool {
    link.metadata().map_or(true, |found| found.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target(text: &str) -> Result<Target, Failure> {
        Target::new(text, "city", vec![1, 2], false, (24, 1), (&Settings::default(), FileFormat::default()))
    }

    #[test]
    fn frames_get_files_of_their_own() {
        for (text, file) in [("a.##.exr", "a.02.exr"), ("a.exr", "a.0002.exr"), ("x/", "x/city.0002.exr")] {
            assert_eq!(target(text).expect(text).exr(2), PathBuf::from(file));
        }
    }

    #[test]
    fn frames_are_exr() {
        assert!(target("a.####.png").expect_err("no EXR").to_string().contains("--png"));
        assert!(target("a.##.##.exr").expect_err("twice").to_string().contains("cannot name"));
    }
}
