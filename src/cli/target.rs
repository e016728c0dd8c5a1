//! Where frames go: one EXR each, and a preview beside it if wanted.

use std::path::PathBuf;
use std::time::Instant;

use super::failure::Failure;
use crate::frame::Finished;
use crate::output::{self, FrameMeta, OutputPattern, exr, png};

/// Names that are fit for the frames of a run.
#[derive(Debug, Clone)]
pub struct Target {
    pattern: OutputPattern,
    text: String,
    shot: String,
    png: bool,
    rate: (i32, u32),
}

impl Target {
    /// `text` names the files, with `####` or `%04d` for the frame's number (see [`OutputPattern`]) or just
    /// their folder; `shot` is the name of the shot; `frames` are those to be written; `rate` is frames a
    /// second.
    pub fn new(text: &str, shot: &str, frames: &[i32], png: bool, rate: (i32, u32)) -> Result<Self, Failure> {
        let pattern = OutputPattern::parse(text, shot, "exr")
            .map_err(|error| Failure::Usage(format!("`{text}` cannot name the frames: {error}")))?;
        let first = frames.first().copied().unwrap_or(0);
        let exr = pattern.at(first).extension().is_some_and(|kind| kind.eq_ignore_ascii_case("exr"));
        if !exr {
            return Err(Failure::Usage(format!(
                "`{text}` does not end in .exr: frames are EXR files; --png writes previews beside them"
            )));
        }
        Ok(Self { pattern, text: text.to_owned(), shot: shot.to_owned(), png, rate })
    }

    /// As it was named.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The EXR of `frame`.
    pub fn exr(&self, frame: i32) -> PathBuf {
        self.pattern.at(frame)
    }

    fn preview(&self, frame: i32) -> PathBuf {
        self.exr(frame).with_extension("png")
    }

    /// Makes the folder and tries it, so that nothing is rendered for a folder that cannot be written.
    pub fn prepare(&self, frame: i32) -> Result<(), Failure> {
        output::ensure_writable(&self.exr(frame)).map_err(Failure::of)
    }

    /// Whether an earlier run left all files of `frame`, whole and of this size.
    pub fn is_finished(&self, frame: i32, width: u32, height: u32) -> bool {
        exr::is_whole(&self.exr(frame), width, height) && (!self.png || self.preview(frame).exists())
    }

    /// Writes a frame and adds the time this took to its statistics. Returns the EXR's path.
    ///
    /// The preview comes first: a frame counts as finished by its EXR.
    pub fn write(&self, finished: &mut Finished) -> Result<PathBuf, Failure> {
        let start = Instant::now();
        let frame = finished.stats.frame;
        if self.png {
            png::write_png(&self.preview(frame), &finished.film).map_err(Failure::of)?;
        }
        let camera = &finished.pose.camera;
        let aspect = finished.film.width as f32 / finished.film.height as f32;
        let meta = FrameMeta {
            frame,
            rate: self.rate,
            world_to_camera: camera.world_to_camera().to_cols_array(),
            world_to_ndc: camera.world_to_ndc(aspect).to_cols_array(),
            comments: format!("frame {frame}, {}, {}", finished.stats.mode, finished.backend.name()),
            shot: self.shot.clone(),
        };
        let path = self.exr(frame);
        exr::write_exr(&path, &finished.film, &meta).map_err(Failure::of)?;
        let seconds = start.elapsed().as_secs_f64();
        finished.stats.seconds.write += seconds;
        finished.stats.seconds.total += seconds;
        Ok(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target(text: &str) -> Result<Target, Failure> {
        Target::new(text, "city", &[1, 2], false, (24, 1))
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
