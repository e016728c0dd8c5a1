//! How much of the picture each material covers, exactly: from frames whose materials show codes instead of colours.
//!
//! A pixel is the mean of its samples. If material number `k` shows the base-th power of `k`, with one more than the
//! samples of a pixel for a base, the digits of the pixel's sum are the counts of its samples by material. Emission
//! and reflectance have three channels each, and each holds a few digits; several passes hold all materials. Where
//! samples lie depends on no colour, so that all passes show the same samples.

use afterimage::film::Film;
use afterimage::frame::{RenderError, Renderer};
use afterimage::layers::Layers;
use afterimage::scene::material::Optics;
use afterimage::scene::{Background, Material, Scene};
use afterimage::settings::Settings;
use glam::Vec3;

/// Planes hold halves, which have 11 bits: the largest sum leaves one for rounding.
const LARGEST_SUM: usize = 1000;

/// Emission and reflectance.
const PLANES: [&str; 6] = ["R", "G", "B", "albedo.R", "albedo.G", "albedo.B"];

/// Pixels that each material covers, by number; the background comes last.
pub type Areas = Vec<f64>;

/// Which material shows what.
struct Code {
    of_pixel: usize,
    /// Of one plane.
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

    /// Materials of one pass.
    fn of_pass(&self) -> usize {
        self.digits * PLANES.len()
    }

    fn passes(&self) -> usize {
        self.materials.div_ceil(self.of_pass())
    }

    /// The scene, with the codes of pass `pass` for colours, and no light.
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
                diffuse_map: None,
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

    /// Gives `put` each pixel with a material of pass `pass` and how many of its samples show it.
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

/// Renders `frames` (in rising order) in codes and gives `put` each number in the list with a pixel, a material, and how
/// many samples of the pixel show it. With `reuse` all frames from the first on are rendered, as one chain.
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
            renderer.recycle(film);
        }
    }
    Ok(())
}

/// The areas of all materials in each of `frames`.
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

/// Half of what materials gain and lose, in percent of the picture.
pub fn moved(areas: &Areas, reference: &Areas) -> f64 {
    let moved: f64 = areas.iter().zip(reference).map(|(a, b)| (a - b).abs()).sum();
    50.0 * moved / reference.iter().sum::<f64>()
}
