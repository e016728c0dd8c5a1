//! Whole runs in each mode: does `auto` need the time of the better one of `full` and `reproject`?

use std::error::Error;
use std::time::Instant;

use afterimage::animation::TransformTrack;
use afterimage::frame::Renderer;
use afterimage::scene::Scene;
use afterimage::settings::{Mode, Settings};
use clap::ValueEnum;
use serde::Serialize;

use super::Arguments;
use super::kinds::{Kind, Lights};
use super::places::Place;
use super::suite::{load, run_scenes};

/// Modes in the order of the columns.
const MODES: [Mode; 3] = [Mode::Full, Mode::Reproject, Mode::Auto];

type Failable<T> = Result<T, Box<dyn Error>>;

/// A run in all modes.
#[derive(Debug, Clone, Serialize)]
struct Row {
    scene: &'static str,
    shot: String,
    /// Number of lights, or `soft`.
    lights: String,
    /// Number of samples of a pixel.
    samples: u32,
    frames: u32,
    /// Seconds of the whole run, the base frame included.
    full_seconds: f64,
    reproject_seconds: f64,
    auto_seconds: f64,
    /// Number of full frames after the first, in the run with `auto`.
    frames_in_full: usize,
}

/// Measures what `arguments` ask for; prints rows as they come.
pub fn run(arguments: &Arguments) -> Failable<()> {
    run_scenes(arguments, &header(), "modes.json", measure_scene)
}

fn measure_scene(arguments: &Arguments, place: &Place, rows: &mut Vec<Row>) -> Failable<()> {
    let (mut scene, settings) = load(place, arguments)?;
    let all_lights = std::mem::take(&mut scene.lights);
    let track = std::mem::replace(&mut scene.models[0].track, TransformTrack::identity());
    let kinds = if arguments.kinds.is_empty() { Kind::value_variants() } else { &arguments.kinds };
    let lights = if arguments.lights.is_empty() { &[Lights::Points(1)] } else { arguments.lights.as_slice() };
    let samples = if arguments.samples.is_empty() { &[1] } else { arguments.samples.as_slice() };
    for kind in kinds {
        scene.models[0].track = if kind.moves_all() { track.clone() } else { TransformTrack::identity() };
        for set in lights {
            scene.lights = set.of(&all_lights).to_vec();
            for samples in samples {
                let settings = Settings { samples: *samples, base_every: 0, ..settings.clone() };
                let measured = measure(&scene, &settings, *kind, arguments)?;
                let row = Row { scene: place.name, lights: set.to_string(), ..measured };
                println!("{}", row.text());
                rows.push(row);
            }
        }
    }
    Ok(())
}

/// Measures all modes. They take turns frame by frame, in alternating order; of each frame the fastest round
/// counts.
fn measure(scene: &Scene, settings: &Settings, kind: Kind, arguments: &Arguments) -> Failable<Row> {
    let count = arguments.frames() as usize;
    let mut best = [const { Vec::new() }; MODES.len()].map(|mut seconds: Vec<f64>| {
        seconds.resize(count, f64::INFINITY);
        seconds
    });
    let mut frames_in_full = 0;
    for round in 0..arguments.rounds() as usize {
        let mut renderers = Vec::new();
        for mode in MODES {
            renderers.push(Renderer::new(scene, &Settings { mode, ..settings.clone() })?);
        }
        frames_in_full = 0;
        for (step, number) in (0..count).zip(kind.first_frame()..) {
            for turn in 0..MODES.len() {
                let which = (turn + step + round) % MODES.len();
                let start = Instant::now();
                let finished = renderers[which].render(number, step > 0 && MODES[which] != Mode::Full)?;
                let seconds = start.elapsed().as_secs_f64();
                best[which][step] = best[which][step].min(seconds);
                let is_in_full = finished.stats.samples.reused() == 0;
                frames_in_full += usize::from(MODES[which] == Mode::Auto && step > 0 && is_in_full);
            }
        }
    }
    let [full_seconds, reproject_seconds, auto_seconds] = best.map(|seconds| seconds.iter().sum());
    Ok(Row {
        scene: "",
        shot: kind.name(),
        lights: String::new(),
        samples: settings.samples * settings.samples,
        frames: arguments.frames(),
        full_seconds,
        reproject_seconds,
        auto_seconds,
        frames_in_full,
    })
}

impl Row {
    /// Formats a line below [`header`].
    fn text(&self) -> String {
        let Self { scene, shot, lights, samples, full_seconds, reproject_seconds, auto_seconds, .. } = self;
        let better = full_seconds.min(*reproject_seconds);
        format!(
            "| {scene:<9} | {shot:<6} | {lights:>6} | {samples:>7} | {full_seconds:6.3} | {reproject_seconds:11.3} | {auto_seconds:6.3} \
             | {:14} | {:11.2} |",
            self.frames_in_full,
            auto_seconds / better,
        )
    }
}

fn header() -> String {
    let line = "| scene     | shot   | lights | samples | full s | reproject s | auto s | auto: in full | auto/better |";
    let rule: String = line.chars().map(|c| if c == '|' { '|' } else { '-' }).collect();
    format!("{line}\n{rule}")
}
