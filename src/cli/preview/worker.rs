//! Loads the shot, renders what the page asks for, and begins anew when a file has changed.

use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use super::args::PreviewArgs;
use super::board::{Board, Job, Loaded, ViewedPicture};
use super::camera::ShotCamera;
use super::needless::Needless;
use super::views::{Views, is_cut};
use super::watch::Watch;
use crate::cli::args::samples::check_samples;
use crate::cli::bare_model::is_model;
use crate::cli::failure::{Failure, one_line};
use crate::film::Film;
use crate::frame::{self, RenderError, Renderer};
use crate::layers::Layers;
use crate::memory;
use crate::output::png;
use crate::scene::warnings::kinds;
use crate::scene::{self, Shot};
use crate::settings::{Build, Settings};
use crate::trace::BackendKind;

/// Pause between two checks of the files.
const PAUSE: Duration = Duration::from_millis(250);
/// Maximum time until a shot that could not be loaded is loaded again.
const RETRY: Duration = Duration::from_secs(2);
/// Longer side of pictures, pixels, if their size is not given.
const USUAL_SIDE: u32 = 640;
/// Limits for settings that improve pictures at the cost of time.
const MOST_RAYS: u32 = 4;
/// Maximum number of exposures of a frame.
const MOST_EXPOSURES: u32 = 4;

/// The worker: the thread that renders, with its thread pool.
pub struct Worker {
    pub args: PreviewArgs,
    pub board: Arc<Board>,
}

impl Worker {
    /// Serves requests for ever.
    pub fn work(&self) {
        let mut watch = Watch::new([self.args.shot.clone()], &Watch::default());
        loop {
            // stamps are taken before files are read: what is written meanwhile is a change
            let (before, start) = (watch.now(), Instant::now());
            watch = match self.load() {
                Ok((shot, settings)) => {
                    let files = shot.files.iter().cloned().chain([self.args.shot.clone()]);
                    let watch = Watch::new(files, &before);
                    let warnings = kinds::told(&shot.warnings);
                    let notes = warnings.into_iter().chain(shot.notes.iter().cloned()).collect();
                    let window = settings.data_window();
                    self.board.loaded(Loaded {
                        title: &shot.title,
                        frames: &shot.frames,
                        rate: shot.rate,
                        notes,
                        camera: ShotCamera::new(&shot),
                        size: [window.width, window.height],
                    });
                    if let Err(error) = self.render(&shot, &settings, &watch) {
                        self.board.failed(&one_line(&error));
                        wait_for_change(&watch, Duration::MAX);
                    }
                    watch
                }
                Err((error, file)) => {
                    let watch = Watch::new(before.files().chain(file), &before);
                    self.board.failed(&one_line(&error));
                    // the name of a missing file is not known here
                    wait_for_change(&watch, RETRY.max(start.elapsed() * 10));
                    watch
                }
            };
        }
    }

    /// Loads the shot and its settings. Fails with a message, and the file at fault if that is known.
    fn load(&self) -> Result<(Shot, Settings), (String, Option<PathBuf>)> {
        let PreviewArgs { shot: path, bare, size, .. } = &self.args;
        let other = |error: Failure| (error.to_string(), None);
        let shot = if is_model(path) {
            let options = bare.options(path, *size).map_err(other)?;
            scene::load_turntable(path, false, &options)
        } else {
            scene::load(path, false)
        };
        let shot = shot.map_err(|error| (error.to_string(), Some(error.path)))?;
        let settings = self.settings(&shot.settings);
        check_samples(&settings, "--samples").map_err(other)?;
        Ok((shot, settings))
    }

    /// Settings of quick pictures.
    fn settings(&self, of_shot: &Settings) -> Settings {
        let PreviewArgs { size, samples, paths, .. } = &self.args;
        let [width, height] = size.map_or_else(|| small(of_shot), |(width, height)| [width, height]);
        Settings {
            width,
            height,
            samples: *samples,
            paths: of_shot.paths.min(*paths),
            paths_per_frame: of_shot.paths_per_frame.min(*paths).max(1),
            reflections: of_shot.reflections.min(MOST_RAYS),
            occlusion_rays: of_shot.occlusion_rays.min(MOST_RAYS),
            // the shot's camera, between its eyes
            stereo: None,
            exposures: of_shot.exposures.map(|most| most.min(MOST_EXPOSURES)),
            layers: Layers::NONE,
            audit: false,
            build: Build::Quick,
            ..of_shot.clone()
        }
    }

    /// Renders frames and views as they are requested, until a file has changed.
    fn render(&self, shot: &Shot, settings: &Settings, watch: &Watch) -> Result<(), String> {
        let kind = BackendKind::default();
        // as if all frames were looked at once
        let frames = shot.frames.list().len();
        let need = frame::need(shot, settings, kind, frames, rayon::current_num_threads());
        need.check(&memory::left()).map_err(|error| error.to_string())?;
        let mut renderer = Renderer::with(kind, &shot.scene, settings).map_err(|error| error.to_string())?;
        let needless = Arc::new(Needless::new(Arc::clone(&self.board), watch.clone(), PAUSE));
        let asked = Arc::clone(&needless);
        renderer.stop_when(Some(Arc::new(move || asked.is_at_work())));
        let mut views = Views::new(shot, settings);
        let look = self.args.look(shot.look);
        let mut last = None;
        while !watch.has_changed() {
            let Some(job) = self.board.next_job(PAUSE) else { continue };
            needless.begin(&job);
            let start = Instant::now();
            let shown = |film: &Film| {
                let png = png::file_of(film, look).map_err(|error| error.to_string())?;
                Ok::<_, String>(ViewedPicture { png: Arc::new(png), seconds: start.elapsed().as_secs_f64() })
            };
            match job {
                Job::Frame(frame) => {
                    let reuse = last.is_some_and(|last| !is_cut(&shot.scene.camera.cuts, last, frame));
                    let finished = match renderer.render(frame, reuse) {
                        Err(RenderError::Stopped) => continue,
                        finished => finished.map_err(|error| format!("frame {frame}: {error}"))?,
                    };
                    last = Some(frame);
                    self.board.rendered(frame, shown(&finished.film)?);
                }
                Job::View(number, view) => {
                    // frames may fit into memory where this does not
                    let film = views.render(&mut renderer, &view).transpose();
                    if let Some(film) = film {
                        self.board.viewed(number, film.and_then(|film| shown(&film)));
                    }
                }
            }
        }
        Ok(())
    }
}

/// Waits until a file has changed, but not for longer than that.
fn wait_for_change(watch: &Watch, longest: Duration) {
    let start = Instant::now();
    while !watch.has_changed() && start.elapsed() < longest {
        thread::sleep(PAUSE);
    }
}

/// The shot's size, made smaller if it is large.
fn small(settings: &Settings) -> [u32; 2] {
    let [width, height] = [settings.width, settings.height];
    let longer = width.max(height);
    if longer <= USUAL_SIDE {
        return [width, height];
    }
    let scaled =
        |side: u32| (f64::from(side) * f64::from(USUAL_SIDE) / f64::from(longer)).round().max(1.0) as u32;
    [scaled(width), scaled(height)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_pictures_become_small_in_their_proportions() {
        let size = |width, height| small(&Settings { width, height, ..Settings::default() });
        assert_eq!([size(1920, 1080), size(300, 200), size(1, 65535)], [[640, 360], [300, 200], [1, 640]]);
    }
}
