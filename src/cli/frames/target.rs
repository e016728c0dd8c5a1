//! Destination of frames: one EXR each, and a preview beside it if wanted.

use std::fmt;
use std::fs::FileType;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::frame_list;
use super::writing::Seen;
use crate::cli::failure::Failure;
use crate::denoise;
use crate::digest::Digest;
use crate::layers::Layers;
use crate::output::exr::{Head, Packing, Windows};
use crate::output::fingerprint::{self, Kind, MadeFrom};
use crate::output::picture::Picture;
use crate::output::{self, Fingerprint, FrameMeta, OutputPattern, exr, png};
use crate::settings::{FileFormat, Look, Settings};
use crate::stereo::Eye;

/// Valid file names for the frames of a run.
#[derive(Debug, Clone)]
pub struct Target {
    pattern: OutputPattern,
    /// Names of previews, one for each eye.
    previews: Vec<OutputPattern>,
    has_two_eyes: bool,
    /// Requested frames, in rising order.
    frames: Vec<i32>,
    text: String,
    shot: String,
    rate: (i32, u32),
    layers: Layers,
    windows: Windows,
    format: FileFormat,
    look: Look,
}

/// State of a frame's files before a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FileState {
    /// No file.
    Nothing,
    /// No EXR file, or a part of one.
    Damaged,
    /// A picture that does not say what it was made from.
    Unknown,
    /// Another frame of this number, under the name of this one.
    OtherFrame(i32),
    /// A frame that was made from something else.
    Other(Vec<Kind>),
    /// The frame, but not its preview, or not with the look that is asked for.
    NoPreview,
    /// All files that the run would write.
    Finished,
}

/// Reason why a frame is not kept.
impl fmt::Display for FileState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nothing => "not there",
            Self::Finished => "there and whole",
            Self::Damaged => "not whole",
            Self::NoPreview => "without the preview that is asked for",
            Self::Unknown => "without a fingerprint: another version made them, or another program",
            Self::OtherFrame(frame) => return write!(f, "the picture of frame {frame}"),
            Self::Other(kinds) => {
                let kinds: Vec<&str> = kinds.iter().map(|kind| kind.other()).collect();
                return write!(f, "made with {}", kinds.join(", and "));
            }
        })
    }
}

impl Target {
    /// Creates a target. `text` names the files, with `####` or `%04d` for the frame's number (see
    /// [`OutputPattern`]), or just their folder. `shot` is the name of the shot, `frames` are the requested
    /// ones, in rising order, and `rate` is frames a second. `settings` decide which layers and pixels are
    /// written, `format` how, and `look` the exposure and view transform of previews.
    pub fn new(
        text: &str,
        shot: &str,
        frames: Vec<i32>,
        png: bool,
        rate: (i32, u32),
        (settings, format, look): (&Settings, FileFormat, Look),
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
        let has_two_eyes = settings.stereo.is_some();
        let preview = pattern.with_extension("png");
        let previews = match (png, has_two_eyes) {
            (false, _) => Vec::new(),
            (true, false) => vec![preview],
            (true, true) => Eye::NAMES.map(|eye| preview.of_view(eye)).into(),
        };
        let (text, shot) = (text.to_owned(), shot.to_owned());
        let (layers, windows) = (settings.layers, Windows::new(settings));
        Ok(Self { pattern, previews, has_two_eyes, frames, text, shot, rate, layers, windows, format, look })
    }

    /// Name of the output as given.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Name of the shot.
    pub fn shot(&self) -> &str {
        &self.shot
    }

    /// Names of all frames, with a number sign for each digit.
    pub fn exr_pattern(&self) -> PathBuf {
        PathBuf::from(self.pattern.to_string())
    }

    /// Requested frames, in rising order.
    pub fn frames(&self) -> &[i32] {
        &self.frames
    }

    /// Frames a second, as a fraction.
    pub fn rate(&self) -> (i32, u32) {
        self.rate
    }

    /// Default path of a contact sheet.
    pub fn contact_sheet(&self) -> PathBuf {
        self.folder().join(format!("{}.contact.png", self.shot))
    }

    /// Path of the checkpoint of a run, or of a part of it, that makes these frames.
    pub fn checkpoint(&self, first: i32, last: i32) -> PathBuf {
        self.folder().join(format!("{}.{first}-{last}.checkpoint", self.shot))
    }

    /// Path of the samples that a run leaves of `frame` for the frames that follow.
    pub fn handoff(&self, frame: i32) -> PathBuf {
        self.folder().join(format!("{}.{frame}.handoff", self.shot))
    }

    /// Path of the lock of a part of the run, from `first` to `last`.
    pub fn lock(&self, first: i32, last: i32) -> PathBuf {
        self.folder().join(format!(".{}.{first}-{last}.lock", self.shot))
    }

    /// Path of the coarse picture of the first frame.
    pub fn coarse(&self) -> PathBuf {
        self.folder().join(format!("{}.coarse.png", self.shot))
    }

    /// Returns true if previews are written.
    pub fn has_previews(&self) -> bool {
        !self.previews.is_empty()
    }

    /// Reads a finished frame as its preview shows it, whether it has a preview or not. With two eyes, that
    /// of the left one.
    pub fn picture(&self, frame: i32, is_denoised: bool) -> Result<Picture, Failure> {
        let picture = match self.previews.first() {
            Some(preview) => Picture::of_png(&preview.at(frame)),
            None => {
                let channels = if is_denoised { denoise::PLANES } else { ["R", "G", "B"] };
                let names_views = self.has_two_eyes && !self.format.multipart;
                let channels = channels.map(|name| match name.split_once('.') {
                    Some((layer, letter)) if names_views => {
                        format!("{layer}.{}.{letter}", Eye::Left.name())
                    }
                    _ => name.to_owned(),
                });
                Picture::of_exr(&self.exr(frame), channels.each_ref().map(String::as_str), self.look)
            }
        };
        picture.map_err(Failure::of)
    }

    /// Path of the EXR of `frame`.
    pub fn exr(&self, frame: i32) -> PathBuf {
        self.pattern.at(frame)
    }

    /// Folder of all files.
    pub fn folder(&self) -> &Path {
        let folder = self.pattern.folder();
        if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
    }

    /// Returns true if `name` in the folder is that of a requested frame, or of its preview.
    pub fn has_name(&self, name: &str) -> bool {
        let frame = |pattern: &OutputPattern| pattern.frame_of(name);
        let frame = frame(&self.pattern).or_else(|| self.previews.iter().find_map(frame));
        frame.is_some_and(|frame| self.frames.binary_search(&frame).is_ok())
    }

    /// Checks that only regular files exist under the names of frames. Others cannot be read to see whether a
    /// frame is finished (a FIFO may never end), nor replaced without loss.
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

    /// Checks, when the run has ended, that all files of all requested frames exist. A folder may be removed
    /// or unmounted while frames are written into it; then each of them was whole, and some are gone.
    pub fn check_all_there(&self) -> Result<(), Failure> {
        let patterns = || [&self.pattern].into_iter().chain(&self.previews);
        let is_there = |path: &PathBuf| path.metadata().is_ok_and(|found| found.is_file() && found.len() > 0);
        let has_all = |frame: &i32| patterns().all(|pattern| is_there(&pattern.at(*frame)));
        let missing: Vec<i32> = self.frames.iter().copied().filter(|frame| !has_all(frame)).collect();
        let Some(first) = missing.first() else { return Ok(()) };
        let gone = patterns().map(|pattern| pattern.at(*first)).find(|path| !is_there(path));
        Err(Failure::Failed(format!(
            "{} ({} of {}): written and not there at the end, {} for one: another program removed them, or {} was removed or \
             unmounted; render them again, or what is missing with --resume",
            frame_list::frames(&missing),
            missing.len(),
            self.frames.len(),
            gone.unwrap_or_else(|| self.exr(*first)).display(),
            self.folder().display()
        )))
    }

    /// Creates the folder and tries it, so that nothing is rendered for a folder that cannot be written.
    /// Removes leftovers of killed runs for these frames.
    pub fn prepare(&self) -> Result<(), Failure> {
        let first = self.frames.first().copied().unwrap_or(0);
        output::ensure_writable(&self.exr(first)).map_err(Failure::of)?;
        output::remove_leftovers(self.folder(), |name| self.has_name(name));
        Ok(())
    }

    /// Returns true if the header of `frame`'s EXR says that it was made from `wanted`. Pixels are not read.
    pub fn is_made(&self, frame: i32, wanted: &Fingerprint) -> bool {
        Head::read(&self.exr(frame))
            .is_ok_and(|head| head.made_from == Some(*wanted) && head.other_frame(frame).is_none())
    }

    /// State of `frame`'s files after an earlier run; `wanted` is the fingerprint of the frame to make.
    /// Pixels are read only if all else fits.
    pub fn left(&self, frame: i32, wanted: &Fingerprint) -> FileState {
        let path = self.exr(frame);
        if path.symlink_metadata().is_err() {
            return FileState::Nothing;
        }
        let Ok(head) = Head::read(&path) else { return FileState::Damaged };
        match (head.made_from, head.other_frame(frame)) {
            (None, _) => return FileState::Unknown,
            (_, Some(other)) => return FileState::OtherFrame(other),
            (Some(found), _) if found != *wanted => return FileState::Other(wanted.changes(&found)),
            _ => {}
        }
        let of_preview = self.of_preview(frame, *wanted);
        let is_wanted = |preview: &OutputPattern| png::fingerprint(&preview.at(frame)) == Some(of_preview);
        if !self.previews.iter().all(is_wanted) {
            return FileState::NoPreview;
        }
        if exr::is_whole(&path) { FileState::Finished } else { FileState::Damaged }
    }

    /// Writes a frame as `seen` by one eye or two, with denoised pictures if there are any. Adds the time
    /// that this took to the statistics of the last eye. Returns the EXR's path. Previews show denoised
    /// pictures. All files hold the fingerprint
    /// `made_from`, frames that of the run, too.
    ///
    /// Previews come first: a frame counts as finished by its EXR.
    pub fn write(
        &self,
        seen: &mut [Seen],
        made_from: Option<MadeFrom>,
        packing: Packing<'_>,
    ) -> Result<PathBuf, Failure> {
        let start = Instant::now();
        for (preview, seen) in self.previews.iter().zip(&*seen) {
            self.write_preview(preview, seen, made_from.map(|made_from| made_from.frame))?;
        }
        let frame = seen.first().map_or(0, |seen| seen.finished.stats.frame);
        let path = self.exr(frame);
        let views: Vec<exr::View> = seen.iter().map(|seen| self.view(seen, made_from)).collect();
        exr::write_views(&path, self.windows, &views, self.format, packing).map_err(Failure::of)?;
        drop(views);
        if let Some(Seen { finished, .. }) = seen.last_mut() {
            let seconds = start.elapsed().as_secs_f64();
            finished.stats.seconds.write += seconds;
            finished.stats.seconds.total += seconds;
        }
        Ok(path)
    }

    fn write_preview(
        &self,
        preview: &OutputPattern,
        Seen { finished, denoised }: &Seen,
        made_from: Option<Fingerprint>,
    ) -> Result<(), Failure> {
        let planes = match denoised {
            Some(planes) => planes.each_ref(),
            None => png::colors(&finished.film).map_err(Failure::of)?,
        };
        let (frame, size) = (finished.stats.frame, [finished.film.width, finished.film.height]);
        let made_from = made_from.map(|made_from| self.of_preview(frame, made_from));
        png::write_colors(&preview.at(frame), size, planes, self.look, made_from).map_err(Failure::of)
    }

    /// Fingerprint of the previews of `frame`, which has the fingerprint `made_from`: the number is in it, because a PNG file says it
    /// nowhere else. The default look adds nothing to it.
    fn of_preview(&self, frame: i32, made_from: Fingerprint) -> Fingerprint {
        let look = if self.look == Look::default() { String::new() } else { format!("{:?}", self.look) };
        let own = Digest::new(format!("{frame} {look}").as_bytes());
        Fingerprint { settings: Digest::of_all([made_from.settings, own]), ..made_from }
    }

    /// Content of a frame's file for one eye.
    fn view<'s>(
        &'s self,
        Seen { finished, denoised }: &'s Seen,
        made_from: Option<MadeFrom>,
    ) -> exr::View<'s> {
        let (frame, camera) = (finished.stats.frame, &finished.camera);
        let [width, height] = self.windows.picture;
        let meta = FrameMeta {
            frame,
            rate: self.rate,
            world_to_camera: camera.world_to_camera().to_cols_array(),
            world_to_ndc: camera.world_to_ndc(width as f32 / height as f32).to_cols_array(),
            comments: format!("frame {frame}, {}, {}", finished.stats.mode, finished.backend.name()),
            shot: self.shot.clone(),
            fingerprint: made_from.map(|made_from| made_from.frame),
            layers: match made_from {
                Some(MadeFrom { run, .. }) => {
                    let run = (fingerprint::RUN_KEY.to_owned(), run.to_string());
                    finished.about_layers.iter().cloned().chain([run]).collect()
                }
                None => finished.about_layers.clone(),
            },
        };
        // more layers may have been made than are to be written: those that a denoiser needs
        let planes = finished.film.planes.iter().filter(|plane| self.layers.has_plane(&plane.name));
        let planes = planes.chain(denoised.iter().flatten()).collect();
        exr::View { name: finished.stats.eye.map(Eye::name), planes, meta }
    }
}

/// Returns true if a link leads to a file, or to nothing: then the link itself is replaced.
fn leads_to_file(link: &Path) -> bool {
    link.metadata().map_or(true, |found| found.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target(text: &str) -> Result<Target, Failure> {
        Target::new(
            text,
            "city",
            vec![1, 2],
            false,
            (24, 1),
            (&Settings::default(), FileFormat::default(), Look::default()),
        )
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
