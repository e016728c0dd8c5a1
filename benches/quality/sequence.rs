//! Errors over time: their variance along tracked points, and their change from frame to frame.

use std::collections::BTreeMap;

use afterimage::frame::{RenderError, Renderer};
use afterimage::layers::Layers;
use afterimage::pose::CameraPose;
use afterimage::scene::Scene;
use afterimage::settings::Settings;
use glam::{Vec2, Vec3};

use super::picture::{Picture, rms};

/// Pictures by frame number.
pub type Pictures = BTreeMap<i32, Picture>;

/// Reference frames by number.
pub struct Sequence(BTreeMap<i32, Frame>);

struct Frame {
    picture: Picture,
    camera: CameraPose,
    /// Point of the sample nearest to each pixel's centre, world space.
    points: Vec<Vec3>,
    /// Depth of each point along the view axis.
    depths: Vec<f32>,
    /// True if the point is on a model that never moves.
    are_still: Vec<bool>,
}

/// Points of still surfaces, as the pixels in which they are seen from frame to frame.
pub struct Tracks {
    pub frames: Vec<i32>,
    pixels: Vec<Vec<usize>>,
}

impl Sequence {
    /// Renders `frames` with `side` x `side` samples a pixel.
    pub fn new(
        scene: &Scene,
        settings: &Settings,
        frames: impl IntoIterator<Item = i32>,
        side: u32,
    ) -> Result<Self, RenderError> {
        let layers = Layers::new(["P", "Z", "object"]).expect("these are layers");
        let mut renderer = Renderer::new(scene, &Settings { samples: side, layers, ..settings.clone() })?;
        let is_still = |id: f32| {
            let model = (id as usize).checked_sub(1).and_then(|number| scene.models.get(number));
            model.is_some_and(|model| model.track.is_constant())
        };
        let render = |number| {
            let finished = renderer.render(number, false)?;
            let plane = |name| finished.film.values(name).expect("it was asked for");
            let [x, y, z] = ["P.X", "P.Y", "P.Z"].map(plane);
            let frame = Frame {
                picture: Picture::of(&finished.film),
                camera: finished.camera,
                points: (0..x.len()).map(|pixel| Vec3::new(x[pixel], y[pixel], z[pixel])).collect(),
                depths: plane("Z"),
                are_still: plane("object.V").into_iter().map(is_still).collect(),
            };
            Ok((number, frame))
        };
        Ok(Self(frames.into_iter().map(render).collect::<Result<_, RenderError>>()?))
    }

    /// Tracks through `frames`: one from every second pixel, across and down, of the first frame, if its point stays in
    /// sight.
    pub fn tracks(&self, frames: impl IntoIterator<Item = i32>) -> Tracks {
        let frames: Vec<i32> = frames.into_iter().collect();
        let first = &self.0[&frames[0]];
        let width = first.picture.width;
        let is_start =
            |pixel: &usize| pixel % width % 2 == 0 && pixel / width % 2 == 0 && first.are_still[*pixel];
        let track =
            |start: usize| frames.iter().map(|frame| self.0[frame].pixel_of(first.points[start])).collect();
        let pixels = (0..first.points.len()).filter(is_start).filter_map(track).collect();
        Tracks { frames, pixels }
    }

    /// Computes the variance over time of the error of `pictures` along `tracks`; mean over tracks and
    /// channels.
    pub fn flicker(&self, tracks: &Tracks, pictures: &Pictures) -> f64 {
        let errors: Vec<Vec<Vec3>> = tracks.frames.iter().map(|frame| self.error(*frame, pictures)).collect();
        let count = errors.len() as f32;
        let variance = |track: &Vec<usize>| {
            let along = || errors.iter().zip(track).map(|(error, pixel)| error[*pixel]);
            let mean = along().sum::<Vec3>() / count;
            f64::from(along().map(|error| (error - mean).length_squared()).sum::<f32>() / (3.0 * count))
        };
        tracks.pixels.iter().map(variance).sum::<f64>() / tracks.pixels.len().max(1) as f64
    }

    /// Estimates the flicker of frames that have an error like `error` each, independent of one another: its
    /// mean square at the ends of `tracks`.
    pub fn noise(tracks: &Tracks, error: &[Vec3]) -> f64 {
        let ends: Vec<Vec3> = tracks.pixels.iter().filter_map(|track| Some(error[*track.last()?])).collect();
        rms(&ends).powi(2)
    }

    /// Computes the RMS change of the error of `pictures` from frame `frame - 1` to frame `frame`.
    pub fn change(&self, frame: i32, pictures: &Pictures) -> f64 {
        let [before, after] = [frame - 1, frame].map(|frame| self.error(frame, pictures));
        rms(&after.iter().zip(&before).map(|(after, before)| *after - *before).collect::<Vec<Vec3>>())
    }

    fn error(&self, frame: i32, pictures: &Pictures) -> Vec<Vec3> {
        pictures[&frame].less(&self.0[&frame].picture)
    }
}

impl Frame {
    /// Finds the pixel in which `point` is seen. Its surface must be in sight there or in a pixel beside it,
    /// because pixels at silhouettes show a point of one of two surfaces.
    fn pixel_of(&self, point: Vec3) -> Option<usize> {
        let (camera, offset) = (&self.camera, point - self.camera.eye);
        let [width, height] = [self.picture.width, self.depths.len() / self.picture.width];
        let size = Vec2::new(width as f32, height as f32);
        let depth = offset.dot(camera.forward);
        let seen = Vec2::new(offset.dot(camera.right), -offset.dot(camera.up)) / (depth * camera.half_height);
        let at = (seen * size.y + size) * 0.5;
        let is_inside = depth > 0.0 && at.cmpge(Vec2::ONE).all() && at.cmplt(size - 1.0).all();
        let pixel = is_inside.then(|| at.y as usize * width + at.x as usize)?;
        let is_here = |near: usize| self.are_still[near] && (self.depths[near] - depth).abs() < 0.01 * depth;
        let around = [0, 1, 2].into_iter().flat_map(|down| [0, 1, 2].map(|across| down * width + across));
        around.map(|step| pixel + step - width - 1).any(is_here).then_some(pixel)
    }
}
