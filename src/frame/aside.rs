//! Pictures beside the frames of a shot: its scene at one of its frames, seen from elsewhere than its camera is, and of any size.
//!
//! They are traced through the renderer's acceleration structures, which take long to build, and made of samples of their own: those
//! of the frames stay as they are. Each is sharp: at the frame's own time, through a pinhole.

use std::time::Instant;

use super::lineage::Rule;
use super::picture::PictureRequest;
use super::pictures::Pictures;
use super::shot::prepared::Prepared;
use super::{Finished, RenderError, Renderer, stats};
use crate::exposure::Exposures;
use crate::layers::Layers;
use crate::pose::{CameraPose, Pose};
use crate::samples::saved::PictureName;
use crate::scene::{CameraTrack, Scene};
use crate::settings::{Mode, Settings};
use crate::stereo::Eye;

/// Samples that such pictures pass on to the next one.
pub struct Aside<'s> {
    prepared: Prepared<'s>,
    pictures: Pictures,
    /// Pictures so far.
    rendered: u32,
}

impl<'s> Aside<'s> {
    /// For pictures of `scene` with `settings`, of which they have size and samples: one eye, no shutter, and `R G B A` alone.
    pub fn new(scene: &'s Scene, settings: &Settings) -> Self {
        let settings = Settings { stereo: None, shutter: None, layers: Layers::NONE, ..settings.clone() };
        let prepared = Prepared::new(scene, &settings, Exposures::sharp());
        Self { prepared, pictures: Pictures::default(), rendered: 0 }
    }
}

impl<'s> Renderer<'s> {
    /// Renders frame number `frame` as `camera` sees it, which is in the space of the shot's files, or as the shot's own does. With
    /// `reuse` the picture is made of the samples of the one `beside` before. Both must be of one scene.
    pub fn render_aside(
        &mut self,
        beside: &mut Aside<'s>,
        camera: Option<&CameraTrack>,
        frame: i32,
        reuse: bool,
    ) -> Result<Finished, RenderError> {
        let start = Instant::now();
        let Aside { prepared, pictures, rendered } = beside;
        prepared.stop.clone_from(&self.prepared.stop);
        let (scene, is_full) = (prepared.scene, prepared.settings.mode == Mode::Full);
        let of_files = camera.map(|camera| scene.space.camera(camera.clone()));
        let camera = CameraPose::new(of_files.as_ref().unwrap_or(&scene.camera), f64::from(frame));
        let picture = PictureName { eye: Eye::Left, exposure: 0 };
        let request = PictureRequest {
            picture,
            pose: Pose { camera, ..Pose::new(scene, frame) },
            seed_pose: None,
            place: None,
            at_frame: None,
            rendered: *rendered + 1,
            sharers: 1,
            start,
        };
        let rule = Rule { reuse, is_full, has_two_sides: false, lenders: prepared.lenders() };
        pictures.begin(picture.eye, reuse);
        let made = pictures.render(prepared, &mut *self.backend, &request, &rule);
        let made = made.inspect_err(|_| pictures.forget())?;
        *rendered += 1;
        Ok(self.finished(made.film.clone(), stats(prepared, frame, &made), &camera))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::DVec3;

    use super::*;
    use crate::film::Film;
    use crate::scene;

    const FRAMES: [i32; 2] = [3, 40];

    fn colors(film: &Film) -> Vec<u32> {
        ["R", "G", "B"].iter().flat_map(|name| bits(film, name)).collect()
    }

    fn bits(film: &Film, name: &str) -> Vec<u32> {
        let plane = film.plane(name).expect("a plane");
        (0..plane.values.len()).map(|i| plane.values.get(i).to_bits()).collect()
    }

    #[test]
    fn pictures_beside_a_shot_are_what_a_shot_from_there_would_show() {
        let shot = scene::load(Path::new("scenes/city/city.toml"), false).expect("it is shipped");
        assert!(shot.scene.space.is_of_files(), "cameras need no conversion here");
        let mode = Mode::Reproject;
        let settings =
            Settings { width: 64, height: 36, samples: 1, mode, audit: true, ..shot.settings.clone() };
        let own = shot.scene.camera.clone();
        let elsewhere = CameraTrack {
            eye: own.eye.clone().converted(|eye| eye + DVec3::new(2.0, 1.0, -1.0), 1.0),
            ..own
        };
        let alone = |scene: &Scene, frame| {
            let mut renderer = Renderer::new(scene, &settings).expect("Embree is there");
            colors(&renderer.render(frame, false).expect("a frame").film)
        };
        let moved = Scene { camera: elsewhere.clone(), ..shot.scene.clone() };
        let expected = FRAMES.map(|frame| [alone(&shot.scene, frame), alone(&moved, frame)]);

        let mut renderer = Renderer::new(&shot.scene, &settings).expect("Embree is there");
        let mut beside = Aside::new(&shot.scene, &settings);
        // models move between the two frames: each picture has them where they are in its own
        for (frame, [own, from_elsewhere]) in FRAMES.into_iter().zip(&expected) {
            let picture =
                renderer.render_aside(&mut beside, Some(&elsewhere), FRAMES[0], false).expect("a picture");
            assert_eq!(colors(&picture.film), expected[0][1], "before frame {frame}");
            let frame_itself = renderer.render(frame, false).expect("a frame");
            assert_eq!(colors(&frame_itself.film), *own);
            let picture = renderer.render_aside(&mut beside, None, frame, false).expect("a picture");
            assert_eq!(colors(&picture.film), *own);
            let picture =
                renderer.render_aside(&mut beside, Some(&elsewhere), frame, false).expect("a picture");
            assert_eq!(colors(&picture.film), *from_elsewhere);
        }
        // led around, each picture is made of the one before, and all of its samples are right
        for step in 1..6 {
            let by = DVec3::new(0.3, 0.1, 0.2) * f64::from(step / 2);
            let camera = CameraTrack {
                eye: elsewhere.eye.clone().converted(|eye| eye + by, 1.0),
                ..elsewhere.clone()
            };
            let picture =
                renderer.render_aside(&mut beside, Some(&camera), FRAMES[1], true).expect("a picture");
            assert_eq!(picture.stats.mode, "reproject");
            assert_eq!(picture.stats.audit.map(|audit| audit.differing), Some(0), "step {step}");
        }
    }

    /// Whatever is at work when nobody wants it any more, the next picture is what it would have been without.
    #[test]
    fn what_is_stopped_leaves_nothing_behind() {
        let shot = scene::load(Path::new("scenes/city/city.toml"), false).expect("it is shipped");
        let mode = Mode::Reproject;
        // several bands of tiles, of whatever number of threads
        let settings =
            Settings { width: 256, height: 144, samples: 1, mode, audit: true, ..shot.settings.clone() };
        let refinement = Some(crate::settings::Refinement { most: 2, threshold: 0.1 });
        let blurred = Settings {
            shutter: Some(crate::exposure::Shutter::new(0.0, 0.5)),
            samples: 2,
            exposures: Some(4),
            ..settings.clone()
        };
        let camera = shot.scene.camera.clone();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread starts");
        for settings in [settings.clone(), Settings { refinement, ..settings }, blurred] {
            pool.install(|| {
                let unaudited = Settings { audit: false, ..settings.clone() };
                let mut untouched = Renderer::new(&shot.scene, &unaudited).expect("Embree is there");
                let expected =
                    [3, 4].map(|frame| colors(&untouched.render(frame, frame > 3).expect("a frame").film));
                let mut aside = Aside::new(&shot.scene, &unaudited);
                let seen = untouched.render_aside(&mut aside, Some(&camera), 4, false).expect("a picture");
                let expected_aside = colors(&seen.film);
                for bands in 1..3 {
                    let mut renderer = Renderer::new(&shot.scene, &settings).expect("Embree is there");
                    let mut beside = Aside::new(&shot.scene, &unaudited);
                    // what is stopped has something to reuse
                    renderer.render(2, false).expect("a frame");
                    renderer.render_aside(&mut beside, Some(&camera), 2, false).expect("a picture");
                    renderer.stop_when(Some(after(bands)));
                    assert!(matches!(renderer.render(3, true), Err(RenderError::Stopped)));
                    renderer.stop_when(Some(after(bands)));
                    let stopped = renderer.render_aside(&mut beside, Some(&camera), 3, true);
                    assert!(matches!(stopped, Err(RenderError::Stopped)));
                    renderer.stop_when(None);
                    let picture =
                        renderer.render_aside(&mut beside, Some(&camera), 4, true).expect("a picture");
                    assert_eq!(picture.stats.mode, "base");
                    assert_eq!(colors(&picture.film), expected_aside);
                    for (frame, expected) in [3, 4].into_iter().zip(&expected) {
                        let finished = renderer.render(frame, true).expect("a frame");
                        assert_eq!(finished.stats.audit.map(|audit| audit.differing), Some(0));
                        assert_eq!(colors(&finished.film), *expected, "frame {frame}, after {bands} bands");
                    }
                }
            });
        }
    }

    /// Has enough after so many bands.
    fn after(bands: usize) -> crate::frame::Stop {
        let asked = std::sync::atomic::AtomicUsize::new(0);
        std::sync::Arc::new(move || asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1 >= bands)
    }
}
