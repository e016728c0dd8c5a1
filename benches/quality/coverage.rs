//! The exact area that each material covers, from frames in which materials have codes instead of colours.
//!
//! A pixel is the mean of its n samples. If material k has the colour (n + 1)^k, then the digits of the pixel's sum, in
//! base n + 1, are its numbers of samples of each material. A channel has room for a few digits; emission and
//! reflectance have three channels each; several passes cover all materials. Where samples lie does not depend on
//! colours, so that all passes have the same samples.

use afterimage::film::Film;
use afterimage::frame::{RenderError, Renderer};
use afterimage::layers::Layers;
use afterimage::scene::material::Optics;
use afterimage::scene::{Background, Material, Scene};
use afterimage::settings::Settings;
use glam::Vec3;

/// Maximum sum in a plane. Planes are half floats, with 11 significant bits; one is left for rounding.
const LARGEST_SUM: usize = 1000;

/// Planes of emission and diffuse reflectance, which the film keeps apart.
const PLANES: [&str; 6] = ["R", "G", "B", "albedo.R", "albedo.G", "albedo.B"];

/// Area of each material, in pixels; the background comes last.
pub type Areas = Vec<f64>;

/// Codes of a scene's materials.
struct Code {
    /// Number of samples of a pixel.
    of_pixel: usize,
    /// Number of materials that a channel has room for.
    digits: usize,
    materials: usize,
}

impl Code {
    fn new(scene: &Scene, settings: &Settings) -> Self {
        let of_pixel = (settings.samples * settings.samples) as usize;
        let fit = |digits: &usize| of_pixel * (of_pixel + 1).pow(*digits as u32 - 1) <= LARGEST_SUM;
        let digits = (1..).take_while(fit).count();
        Self { of_pixel, digits, materials: scene.materials.len() }
    }

    /// Number of materials of one pass.
    fn of_pass(&self) -> usize {
        self.digits * PLANES.len()
    }

    fn passes(&self) -> usize {
        self.materials.div_ceil(self.of_pass())
    }

    /// Copy of `scene` with the codes of pass `pass` as colours, without lights.
    fn scene(&self, scene: &Scene, pass: usize) -> Scene {
        let coded = |(number, material): (usize, &Material)| {
            let mut planes = [0.0; PLANES.len()];
            if let Some(place) = number.checked_sub(pass * self.of_pass()).filter(|at| *at < self.of_pass()) {
                planes[place / self.digits] = (self.of_pixel + 1).pow((place % self.digits) as u32) as f32;
            }
            Material {
                emission: Vec3::from_slice(&planes[..3]),
                diffuse: Vec3::from_slice(&planes[3..]),
                ambient: Vec3::ZERO,
                specular: Vec3::ZERO,
                optics: Optics::Opaque,
                metal_rough: None,
                diffuse_map: None,
                cutout: None,
                ..material.clone()
            }
        };
        Scene {
            materials: scene.materials.iter().enumerate().map(coded).collect(),
            lights: vec![],
            ambient: Vec3::ZERO,
            background: Background::uniform(Vec3::ZERO),
            ..scene.clone()
        }
    }

    /// Calls `put` with pixel, material and number of samples, for all materials of pass `pass`.
    fn read(&self, film: &Film, pass: usize, mut put: impl FnMut(usize, usize, usize)) {
        let base = self.of_pixel + 1;
        for (channel, name) in PLANES.iter().enumerate() {
            let first = pass * self.of_pass() + channel * self.digits;
            for (pixel, value) in film.values(name).expect("it was asked for").iter().enumerate() {
                let mut sum = (value * self.of_pixel as f32).round() as usize;
                for material in first..first + self.digits {
                    if sum % base > 0 {
                        put(pixel, material, sum % base);
                    }
                    sum /= base;
                }
            }
        }
    }
}

/// Renders `frames` (rising) in codes and calls `put` with an index into `frames`, a pixel, a material and its number of
/// samples in that pixel. With `reuse` the frames belong to one chain that starts at frame 1.
pub fn count(
    scene: &Scene,
    settings: &Settings,
    frames: &[i32],
    reuse: bool,
    mut put: impl FnMut(usize, usize, usize, usize),
) -> Result<(), RenderError> {
    let code = Code::new(scene, settings);
    let settings = Settings { layers: Layers::ALBEDO, ..settings.clone() };
    for pass in 0..code.passes() {
        let coded = code.scene(scene, pass);
        let mut renderer = Renderer::new(&coded, &settings)?;
        for frame in 1..=frames.last().copied().unwrap_or(0) {
            let number = frames.binary_search(&frame).ok();
            if !reuse && number.is_none() {
                continue;
            }
            let film = renderer.render(frame, reuse)?.film;
            if let Some(number) = number {
                code.read(&film, pass, |pixel, material, count| put(number, pixel, material, count));
            }
        }
    }
    Ok(())
}

/// Measures the areas in each of `frames`: see [`count`].
pub fn areas(
    scene: &Scene,
    settings: &Settings,
    frames: &[i32],
    reuse: bool,
) -> Result<Vec<Areas>, RenderError> {
    let of_pixel = f64::from(settings.samples).powi(2);
    let background = scene.materials.len();
    let mut nothing = vec![0.0; background + 1];
    nothing[background] = f64::from(settings.width) * f64::from(settings.height);
    let mut areas = vec![nothing; frames.len()];
    count(scene, settings, frames, reuse, |number, _, material, count| {
        areas[number][material] += count as f64 / of_pixel;
        areas[number][background] -= count as f64 / of_pixel;
    })?;
    Ok(areas)
}

/// Half the sum of the areas that materials gain and lose, as a percentage of the picture.
pub fn moved(areas: &Areas, reference: &Areas) -> f64 {
    let moved: f64 = areas.iter().zip(reference).map(|(a, b)| (a - b).abs()).sum();
    50.0 * moved / reference.iter().sum::<f64>()
}
