//! Error at equal time: light from all around in a dolly through the kitchen, each frame traced in full, and frames that
//! spend what reuse saves on more samples and paths (`--budget`).
//!
//! Errors are those of frames 24 and 25 against pictures of 32x32 samples a pixel and 8 paths a sample, in which nothing is
//! reused, as they are and after denoising, where Open Image Denoise is installed. With a quarter of the samples and half of
//! the paths the reference would be as noisy as the best of what is denoised. Two are counted: the relative mean square
//! error, with each pixel's square over that of the reference; and the temporal one, the mean square of how much the error
//! changes from one frame to the next along points that stay in sight, over that of the reference.

use std::error::Error;
use std::time::Instant;

use afterimage::denoise::{self, Denoiser};
use afterimage::film::{Film, Plane};
use afterimage::frame::Renderer;
use afterimage::layers::Layers;
use afterimage::pose::{CameraPose, Pose};
use afterimage::scene::Scene;
use afterimage::settings::{Budget, DenoiseQuality, Mode, PixelRect, Settings};
use glam::{Vec2, Vec3};
use serde::Serialize;

use super::flows::Flow;
use super::gathered::{made_rough, under_a_sky};
use super::places::SceneName;
use super::table::{Circumstances, write_json};
use super::{Arguments, folder};

/// Frames whose errors count.
const LAST: [i32; 2] = [24, 25];

/// Factor on width and height with which the reference is rendered.
const FINER: usize = 2;

/// Number of strips in which the reference is rendered, one after the other: its samples would fill the
/// memory.
const STRIPS: u32 = 8;

/// Radiance below which errors are not counted as larger shares of it.
const DARK: f32 = 0.1;

/// One way to render the shot.
struct Contestant {
    name: &'static str,
    settings: Settings,
    /// Budget, as a share of the rays of a frame that is traced in full; none: that of its settings.
    share_of_rays: Option<f64>,
}

/// A line of the table.
#[derive(Debug, Clone, Serialize)]
struct Row {
    name: &'static str,
    /// Mean of the seconds of frames 2 to 25.
    seconds: f64,
    relative_mse: f64,
    temporal: f64,
    /// Both errors after denoising.
    denoised: Option<[f64; 2]>,
    bytes_per_sample: f64,
    /// Rays of paths and to lights, in the last frame.
    rays: u64,
}

/// Colours of a frame, and the points that it shows.
struct Picture {
    colors: Vec<Vec3>,
    denoised: Option<Vec<Vec3>>,
    points: Vec<Vec3>,
    is_surface: Vec<bool>,
}

type Failable<T> = Result<T, Box<dyn Error>>;

/// Measures; prints rows as they come.
pub fn run(arguments: &Arguments) -> Failable<()> {
    let circumstances = Circumstances::now(arguments);
    println!("{}\n", circumstances.text());
    let place = made_rough(SceneName::Kitchen.place(arguments.triangles(), &folder())?, arguments.rough)?;
    let (mut scene, settings) = under_a_sky(&place, arguments)?;
    scene.camera = Flow::DollyIn.camera(&place, &scene.space);
    let mut denoiser = Denoiser::new(0, DenoiseQuality::High).ok();
    let settings = Settings { bounces: 2, layers: Layers::parse("P,object")?, ..settings };
    let settings = if denoiser.is_some() { denoise::with_guides(&settings) } else { settings };
    let [before, after] = LAST.map(|frame| Picture::reference(&scene, &settings, frame));
    let reference = [before?, after?];

    let line = "| frames                              | seconds | over full | relative MSE | over full | temporal | over full | \
                denoised: MSE | over full | temporal | over full | B/sample |";
    println!("{line}\n{}", line.chars().map(|c| if c == '|' { '|' } else { '-' }).collect::<String>());
    let mut rows: Vec<Row> = Vec::new();
    for mut contestant in contestants(&settings) {
        if let (Some(share), Some(full)) = (contestant.share_of_rays, rows.first()) {
            contestant.settings.budget = Budget::Rays((share * full.rays as f64) as u64);
        }
        let row = contestant.measure(&scene, &reference, arguments, denoiser.as_mut())?;
        println!("{}", row.text(rows.first().unwrap_or(&row)));
        rows.push(row);
    }
    let path = folder().join("equal.json");
    write_json(&path, &circumstances, &rows)?;
    println!("\nalso in {}", path.display());
    Ok(())
}

fn contestants(settings: &Settings) -> Vec<Contestant> {
    let full = Settings { samples: 2, paths: 16, mode: Mode::Full, ..settings.clone() };
    let reused = Settings { mode: Mode::Reproject, base_every: 0, ..full.clone() };
    let filled = |samples, [first, most]: [u32; 2]| Settings {
        samples,
        paths: most,
        paths_per_frame: first,
        budget: Budget::Full,
        ..reused.clone()
    };
    let contestant = |name, settings, share_of_rays| Contestant { name, settings, share_of_rays };
    vec![
        contestant("full, 2x2, 16 paths", full, None),
        contestant("inferred, 2x2, 16 paths", reused.clone(), None),
        contestant("inferred, 2x2, 16 to 128 paths", filled(2, [16, 128]), None),
        contestant("inferred, 4x4, 4 to 64 paths", filled(4, [4, 64]), None),
        contestant("inferred, 8x8, 1 to 8 paths", filled(8, [1, 8]), None),
        contestant("inferred, 8x8, 1 to 16, 2/3 of rays", filled(8, [1, 16]), Some(2.0 / 3.0)),
        contestant("inferred, 8x8, 2 to 16 paths", filled(8, [2, 16]), None),
        contestant("inferred, 10x10, 1 to 4 paths", filled(10, [1, 4]), None),
        contestant("inferred, 12x12, 1 to 4 paths", filled(12, [1, 4]), None),
        contestant("inferred, 14x14, 1 to 3 paths", filled(14, [1, 3]), None),
    ]
}

impl Contestant {
    fn measure(
        &self,
        scene: &Scene,
        reference: &[Picture; 2],
        arguments: &Arguments,
        mut denoiser: Option<&mut Denoiser>,
    ) -> Failable<Row> {
        let mut renderer = Renderer::new(scene, &self.settings)?;
        let reuses = self.settings.mode != Mode::Full;
        let first = if reuses { 1 } else { LAST[0] - arguments.frames() as i32 };
        let (mut seconds, mut pictures, mut bytes_per_sample, mut rays) = (Vec::new(), Vec::new(), 0.0, 0);
        for frame in first..=LAST[1] {
            let start = Instant::now();
            let finished = renderer.render(frame, reuses)?;
            // the first one is paid by all
            if frame > first {
                seconds.push(start.elapsed().as_secs_f64());
            }
            if LAST.contains(&frame) {
                let denoised =
                    denoiser.as_mut().map(|denoiser| denoiser.denoise(&finished.film)).transpose()?;
                pictures.push(Picture::of(&finished.film, denoised));
            }
            rays = finished.stats.rays.gathering + finished.stats.rays.shadow;
            drop(finished);
            bytes_per_sample = renderer.memory().bytes_per_sample;
        }
        let camera = Pose::new(scene, LAST[0]).camera;
        let errors_of = |colors: &dyn Fn(&Picture) -> Option<&Vec<Vec3>>| {
            let errors = pictures.iter().zip(reference).map(|(picture, reference)| {
                colors(picture).map(|colors| reference.relative_error_of(colors))
            });
            let errors = errors.collect::<Option<Vec<Vec<Vec3>>>>()?;
            let squares = errors.iter().flatten().map(|error| f64::from(error.length_squared() / 3.0));
            let relative_mse = squares.sum::<f64>() / errors.iter().map(Vec::len).sum::<usize>() as f64;
            let size = [self.settings.width, self.settings.height];
            Some([relative_mse, temporal(&errors, reference, &camera, size)])
        };
        let [relative_mse, temporal] = errors_of(&|picture| Some(&picture.colors)).expect("all have colours");
        Ok(Row {
            name: self.name,
            seconds: seconds.iter().sum::<f64>() / seconds.len().max(1) as f64,
            relative_mse,
            temporal,
            denoised: errors_of(&|picture| picture.denoised.as_ref()),
            bytes_per_sample,
            rays,
        })
    }
}

impl Picture {
    fn of(film: &Film, denoised: Option<[Plane; 3]>) -> Self {
        let plane = |name: &str| film.values(name).expect("it was asked for");
        let vectors = |[x, y, z]: [Vec<f32>; 3]| -> Vec<Vec3> {
            x.iter().zip(&y).zip(&z).map(|((x, y), z)| Vec3::new(*x, *y, *z)).collect()
        };
        let three = |names: [&str; 3]| vectors(names.map(plane));
        Self {
            denoised: denoised.map(|planes| vectors(planes.map(|plane| plane.values.to_floats()))),
            colors: three(["R", "G", "B"]),
            points: three(["P.X", "P.Y", "P.Z"]),
            is_surface: plane("object.V").iter().map(|object| *object > 0.0).collect(),
        }
    }

    /// Renders the reference of `frame`, nearly without noise.
    fn reference(scene: &Scene, settings: &Settings, frame: i32) -> Failable<Self> {
        let in_full = Settings { mode: Mode::Full, ..settings.clone() };
        // what the centres of pixels show
        let of_centres = Settings { samples: 1, paths: 0, ..in_full.clone() };
        let centres = Self::of(&Renderer::new(scene, &of_centres)?.render(frame, false)?.film, None);
        let [width, height] = [settings.width, settings.height].map(|side| side * FINER as u32);
        let strip = height.div_ceil(STRIPS);
        let mut colors = Vec::new();
        for y in (0..height).step_by(strip as usize) {
            let crop = Some(PixelRect { x: 0, y: y as i32, width, height: strip.min(height - y) });
            let fine = Settings { width, height, crop, samples: 16, paths: 8, ..in_full.clone() };
            let mut renderer = Renderer::new(scene, &fine)?;
            colors.append(&mut Self::of(&renderer.render(frame, false)?.film, None).colors);
        }
        let width = width as usize;
        let mean = |pixel: usize| {
            let corner =
                pixel / settings.width as usize * FINER * width + pixel % settings.width as usize * FINER;
            let rows = (0..FINER).map(|row| corner + row * width);
            rows.flat_map(|first| &colors[first..first + FINER]).sum::<Vec3>() / (FINER * FINER) as f32
        };
        let colors = (0..centres.colors.len()).map(mean).collect();
        Ok(Self { colors, ..centres })
    }

    /// Error of `colors` against this reference, pixel by pixel, as shares of it.
    fn relative_error_of(&self, colors: &[Vec3]) -> Vec<Vec3> {
        let share = |(color, wanted): (&Vec3, &Vec3)| (*color - *wanted) / (*wanted + DARK);
        colors.iter().zip(&self.colors).map(share).collect()
    }
}

/// Mean square change of the error from one frame to the next, along points of surfaces that stay in sight.
fn temporal(errors: &[Vec<Vec3>], reference: &[Picture; 2], before: &CameraPose, size: [u32; 2]) -> f64 {
    let [width, height] = size.map(|side| side as f32);
    let (mut sum, mut count) = (0.0, 0);
    let surfaces = reference[1].is_surface.iter().enumerate().filter(|(_, is_surface)| **is_surface);
    for (pixel, _) in surfaces {
        let point = reference[1].points[pixel];
        let ndc = before.world_to_ndc(width / height).project_point3(point);
        let at = Vec2::new((ndc.x + 1.0) * 0.5 * width, (1.0 - ndc.y) * 0.5 * height).floor();
        if at.cmplt(Vec2::ZERO).any() || at.cmpge(Vec2::new(width, height)).any() {
            continue;
        }
        let was = at.y as usize * size[0] as usize + at.x as usize;
        let distance = (point - before.eye).length();
        if (reference[0].points[was] - point).length() < 0.02 * distance {
            sum += f64::from((errors[1][pixel] - errors[0][was]).length_squared() / 3.0);
            count += 1;
        }
    }
    sum / f64::from(count.max(1))
}

impl Row {
    fn text(&self, full: &Self) -> String {
        let Self { name, seconds, relative_mse, temporal, bytes_per_sample, .. } = self;
        let denoised = match (self.denoised, full.denoised) {
            (Some([mse, temporal]), Some([mse_of_full, temporal_of_full])) => format!(
                "{mse:13.6} | {:9.3} | {temporal:8.6} | {:9.3}",
                mse / mse_of_full,
                temporal / temporal_of_full
            ),
            _ => "            - |         - |        - |         -".to_owned(),
        };
        format!(
            "| {name:<35} | {seconds:7.3} | {:9.2} | {relative_mse:12.6} | {:9.3} | {temporal:8.6} | {:9.3} | \
             {denoised} | {bytes_per_sample:8.0} |",
            seconds / full.seconds,
            relative_mse / full.relative_mse,
            temporal / full.temporal,
        )
    }
}
