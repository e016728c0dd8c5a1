//! Reference frames with many samples a pixel, each of which can be read by itself: they are rendered as a larger
//! picture with one sample a pixel.

use std::sync::Arc;

use afterimage::film::Film;
use afterimage::frame::{RenderError, Renderer};
use afterimage::scene::Scene;
use afterimage::settings::Settings;
use glam::Vec3;

use super::coverage::{self, Areas};
use super::picture::Picture;

/// A frame with `side` x `side` samples a pixel.
pub struct Reference {
    side: usize,
    /// Size of the frame, pixels across and down.
    size: [usize; 2],
    film: Arc<Film>,
    /// Material of each sample; for the background one more than the last.
    material: Vec<u16>,
    materials: usize,
}

impl Reference {
    /// Renders references of `frames`, for pictures of the size in `settings`.
    pub fn of(
        scene: &Scene,
        settings: &Settings,
        frames: &[i32],
        side: u32,
    ) -> Result<Vec<Self>, RenderError> {
        let size = [settings.width, settings.height];
        let large =
            Settings { width: size[0] * side, height: size[1] * side, samples: 1, ..settings.clone() };
        let materials = scene.materials.len();
        let mut renderer = Renderer::new(scene, &large)?;
        let reference = |frame: &i32| {
            let film = renderer.render(*frame, false)?.film;
            let material = vec![materials as u16; film.width as usize * film.height as usize];
            Ok(Self { side: side as usize, size: size.map(|side| side as usize), film, material, materials })
        };
        let mut all = frames.iter().map(reference).collect::<Result<Vec<_>, RenderError>>()?;
        drop(renderer); // its samples and those of the next one need not be in memory together
        coverage::count(scene, &large, frames, false, |number, sample, material, _| {
            all[number].material[sample] = material as u16;
        })?;
        Ok(all)
    }

    /// Computes the mean of all samples, and the area of each material.
    pub fn whole(&self) -> (Picture, Areas) {
        self.jittered(self.side, 0)
    }

    /// Draws a frame with `samples` x `samples` samples a pixel, each at a random place in its cell
    /// (stratified sampling).
    pub fn jittered(&self, samples: usize, seed: u64) -> (Picture, Areas) {
        let planes = ["R", "G", "B"].map(|name| &self.film.plane(name).expect("every film has it").values);
        let weight = (samples * samples) as f32;
        let mut areas = vec![0.0; self.materials + 1];
        let [width, height] = self.size;
        let colors = (0..width * height).map(|pixel| {
            let mut sum = Vec3::ZERO;
            for sample in self.chosen(pixel, samples, seed) {
                sum += Vec3::from_array(planes.map(|plane| plane.get(sample)));
                areas[usize::from(self.material[sample])] += 1.0 / f64::from(weight);
            }
            sum / weight
        });
        let picture = Picture::new(width, colors);
        (picture, areas)
    }

    /// Ratio of the mean squared distance of jittered frames from this reference to that from the truth:
    /// below 1, because their samples are some of the reference's (finite population correction).
    pub fn bias(&self, samples: usize) -> f64 {
        1.0 - (samples as f64 / self.side as f64).powi(2)
    }

    /// Number of pixels that `material` covers in part.
    pub fn rim(&self, material: usize) -> f64 {
        let shows = |sample: usize| usize::from(self.material[sample]) == material;
        let count = |pixel| self.chosen(pixel, self.side, 0).filter(|sample| shows(*sample)).count();
        let pixels = 0..self.size[0] * self.size[1];
        pixels.filter(|pixel| (1..self.side * self.side).contains(&count(*pixel))).count() as f64
    }

    /// Chooses one sample in each of the `samples` x `samples` cells of `pixel`.
    fn chosen(&self, pixel: usize, samples: usize, seed: u64) -> impl Iterator<Item = usize> + '_ {
        let cell = self.side / samples;
        let [x, y] = [pixel % self.size[0], pixel / self.size[0]].map(|at| at * self.side);
        (0..samples * samples).map(move |number| {
            let random = hash(seed << 40 ^ (pixel * samples * samples + number) as u64) as usize;
            let across = x + number % samples * cell + random % cell;
            let down = y + number / samples * cell + (random >> 16) % cell;
            down * self.size[0] * self.side + across
        })
    }
}

/// The output function of SplitMix64.
fn hash(number: u64) -> u64 {
    let mut x = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}
