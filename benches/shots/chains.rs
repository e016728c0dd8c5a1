//! Long chains of inferred frames: their newly traced samples, kept samples and costs, beside the paper's
//! rule and full frames.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use afterimage::frame::Renderer;
use afterimage::scene::{self, Scene};
use afterimage::settings::{Mode, Reuse, Settings};
use serde::Serialize;

use super::flows::Flow;
use super::kinds::{Lights, still_file};
use super::places::{Place, SceneName};
use super::table::{Circumstances, write_json};
use super::{Arguments, folder};

/// Scenes, unless the command line names others.
const SCENES: [SceneName; 3] = [SceneName::Kitchen, SceneName::Warehouse, SceneName::City];

/// Early frame that later ones are compared with.
const EARLY: i32 = 5;

/// Number of frames on either side of a frame over which the median of times is taken.
const NEIGHBOURS: i32 = 2;

/// A set-up of all flows of a scene, unless the command line says otherwise.
#[derive(Debug, Clone, Copy)]
struct Setup {
    lights: Lights,
    /// Samples along a pixel's edge.
    samples: u32,
    /// Flows to measure.
    flows: &'static [Flow],
    /// Scenes to measure.
    scenes: &'static [SceneName],
}

const ALL_FLOWS: &[Flow] =
    &[Flow::DollyIn, Flow::DollyOut, Flow::Pan, Flow::Turn, Flow::ZoomIn, Flow::ZoomOut, Flow::Sideways];

impl Setup {
    /// Default set-ups. With --quick the first alone.
    const DEFAULTS: [Self; 5] = [
        Self { lights: Lights::Points(1), samples: 2, flows: ALL_FLOWS, scenes: &SCENES },
        Self { lights: Lights::Points(1), samples: 1, flows: ALL_FLOWS, scenes: &SCENES },
        Self { lights: Lights::Points(1), samples: 4, flows: &[Flow::DollyIn], scenes: &SCENES },
        Self {
            lights: Lights::Points(8),
            samples: 2,
            flows: &[Flow::DollyIn],
            scenes: &[SceneName::Kitchen],
        },
        Self { lights: Lights::Soft, samples: 2, flows: &[Flow::DollyIn], scenes: &[SceneName::Kitchen] },
    ];

    fn is_for(&self, scene: SceneName) -> bool {
        !SCENES.contains(&scene) || self.scenes.contains(&scene)
    }
}

/// A frame of two chains that differ in their rule.
#[derive(Debug, Clone, Serialize)]
struct Row {
    scene: &'static str,
    flow: String,
    /// Number of lights, or `soft`.
    lights: String,
    /// Number of samples of a pixel.
    samples: u32,
    /// Number of the frame; the base frame is 1.
    frame: i32,
    full_seconds: f64,
    target: Figures,
    paper: Figures,
}

/// A frame of one chain.
#[derive(Debug, Clone, Copy, Serialize)]
struct Figures {
    /// Cells that were traced, as a percentage of all.
    traced_percent: f64,
    /// Samples that serve no cell, as a percentage of the cells.
    spare_percent: f64,
    /// Bytes of the sample store, for each sample of a frame.
    bytes_per_sample: f64,
    /// Median of the seconds over neighbours.
    seconds: f64,
    /// Speed relative to a full frame of the same number.
    full_over_inferred: f64,
    /// Ratio of `seconds` to those of frame [`EARLY`].
    over_early: f64,
}

/// A chain by one rule.
struct Chain<'s> {
    renderer: Renderer<'s>,
    /// Frames by number, the first being 1.
    frames: Vec<Frame>,
}

struct Frame {
    seconds: f64,
    traced_percent: f64,
    spare_percent: f64,
    bytes_per_sample: f64,
}

type Failable<T> = Result<T, Box<dyn Error>>;

/// Measures what `arguments` ask for; prints rows as they come.
pub fn run(arguments: &Arguments) -> Failable<()> {
    let frames = marks(arguments).iter().max().map(|last| (last + NEIGHBOURS) as u32);
    let circumstances = Circumstances::now(&Arguments { frames, rounds: Some(1), ..arguments.clone() });
    println!("{}", circumstances.machine());
    let [width, height] = arguments.size();
    let layers: Vec<&str> = ["R G B A"].into_iter().chain(arguments.layers().names()).collect();
    println!(
        "{width}x{height}; layers: {}; times: median of {} frames",
        layers.join(", "),
        1 + 2 * NEIGHBOURS
    );
    println!("\n{}", header());
    let mut rows = Vec::new();
    let mut missing = Vec::new();
    let scenes = if arguments.scenes.is_empty() { &SCENES } else { arguments.scenes.as_slice() };
    for name in scenes {
        match name.place(arguments.triangles(), &folder()) {
            Ok(place) => measure_scene(arguments, *name, &place, &mut rows)?,
            Err(error) => missing.push(error.to_string()),
        }
    }
    missing.iter().for_each(|why| println!("skipped: {why}"));
    let path = folder().join("chains.json");
    write_json(&path, &circumstances, &rows)?;
    println!("\nalso in {}", path.display());
    Ok(())
}

fn measure_scene(arguments: &Arguments, name: SceneName, place: &Place, rows: &mut Vec<Row>) -> Failable<()> {
    let (mut scene, settings) = load_still(place, arguments)?;
    let lights = std::mem::take(&mut scene.lights);
    for (set, samples, flow) in chains(arguments, name) {
        scene.lights = set.of(&lights).to_vec();
        scene.camera = flow.camera(place, &scene.space);
        let settings = Settings { samples, ..settings.clone() };
        for (frame, full_seconds, [target, paper]) in measure(&scene, &settings, marks(arguments))? {
            let row = Row {
                scene: place.name,
                flow: flow.name(),
                lights: set.to_string(),
                samples: samples * samples,
                frame,
                full_seconds,
                target,
                paper,
            };
            println!("{}", row.text());
            rows.push(row);
        }
    }
    Ok(())
}

/// Frames whose figures are printed.
fn marks(arguments: &Arguments) -> &'static [i32] {
    match (arguments.quick, arguments.long) {
        (true, _) => &[24],
        (false, false) => &[24, 96],
        (false, true) => &[24, 96, 300],
    }
}

/// Chains to measure of `scene`: lights, samples along a pixel's edge, flow.
fn chains(arguments: &Arguments, scene: SceneName) -> Vec<(Lights, u32, Flow)> {
    let is_asked = |flow: &Flow| arguments.flows.is_empty() || arguments.flows.contains(flow);
    let flows = |of: &[Flow]| of.iter().copied().filter(is_asked).collect::<Vec<Flow>>();
    if arguments.lights.is_empty() && arguments.samples.is_empty() {
        let count = if arguments.quick { 1 } else { Setup::DEFAULTS.len() };
        let setups = Setup::DEFAULTS.into_iter().take(count).filter(|setup| setup.is_for(scene));
        let of = |setup: Setup| {
            flows(setup.flows).into_iter().map(move |flow| (setup.lights, setup.samples, flow))
        };
        return setups.flat_map(of).collect();
    }
    let lights = if arguments.lights.is_empty() { &[Lights::Points(1)] } else { arguments.lights.as_slice() };
    let samples = if arguments.samples.is_empty() { &[2] } else { arguments.samples.as_slice() };
    let pairs = lights.iter().flat_map(|lights| samples.iter().map(move |samples| (*lights, *samples)));
    let of = |(lights, samples)| flows(ALL_FLOWS).into_iter().map(move |flow| (lights, samples, flow));
    pairs.flat_map(of).collect()
}

/// Loads the scene with all lights and nothing that moves.
pub fn load_still(place: &Place, arguments: &Arguments) -> Failable<(Scene, Settings)> {
    let path = folder().join(format!("{}-still.toml", place.name));
    std::fs::write(&path, still_file(place))?;
    let shot = scene::load(Path::new(&path), false)?;
    let [width, height] = arguments.size();
    let depth = arguments.depth.first().copied().unwrap_or(0);
    // one base frame, and every later frame inferred whatever it costs
    let (mode, base_every, layers) = (Mode::Reproject, 0, arguments.layers());
    Ok((shot.scene, Settings { width, height, depth, mode, base_every, layers, ..shot.settings }))
}

/// Measures each of the frames `marks`: its number, the seconds of a full one, and the figures of the chains
/// by target and by the paper's rule. The three take turns frame by frame, so that a disturbance of the
/// machine affects all.
fn measure(scene: &Scene, settings: &Settings, marks: &[i32]) -> Failable<Vec<(i32, f64, [Figures; 2])>> {
    let mut chains = Vec::new();
    for reuse in [Reuse::Target, Reuse::Paper] {
        let renderer = Renderer::new(scene, &Settings { reuse, ..settings.clone() })?;
        chains.push(Chain { renderer, frames: Vec::new() });
    }
    let mut full = Renderer::new(scene, &Settings { mode: Mode::Full, ..settings.clone() })?;
    let mut full_seconds = vec![Vec::new(); marks.len()];
    for frame in 1..=marks.iter().max().map_or(0, |last| last + NEIGHBOURS) {
        // in alternating order
        for turn in 0..chains.len() {
            let number = (turn + frame as usize) % chains.len();
            chains[number].infer(frame)?;
        }
        for (mark, seconds) in marks.iter().zip(&mut full_seconds) {
            if (frame - mark).abs() <= NEIGHBOURS {
                let start = Instant::now();
                full.render(frame, false)?;
                seconds.push(start.elapsed().as_secs_f64());
            }
        }
    }
    let figures = |(mark, full_seconds): (&i32, Vec<f64>)| {
        let full_seconds = median(full_seconds);
        (*mark, full_seconds, [0, 1].map(|number| chains[number].figures(*mark, full_seconds)))
    };
    Ok(marks.iter().zip(full_seconds).map(figures).collect())
}

impl Chain<'_> {
    fn infer(&mut self, frame: i32) -> Failable<()> {
        let start = Instant::now();
        let finished = self.renderer.render(frame, true)?;
        let seconds = start.elapsed().as_secs_f64();
        let samples = finished.stats.samples;
        let percent = |count: u64| 100.0 * count as f64 / samples.total() as f64;
        self.frames.push(Frame {
            seconds,
            traced_percent: percent(samples.missed + samples.obscured),
            spare_percent: percent(samples.spare),
            bytes_per_sample: self.renderer.memory().bytes_per_sample,
        });
        Ok(())
    }

    /// Median of the seconds over the neighbours of frame `number`.
    fn seconds(&self, number: i32) -> f64 {
        let around = number - NEIGHBOURS..=number + NEIGHBOURS;
        median(around.map(|number| self.frames[number as usize - 1].seconds).collect())
    }

    fn figures(&self, number: i32, full_seconds: f64) -> Figures {
        let frame = &self.frames[number as usize - 1];
        let seconds = self.seconds(number);
        Figures {
            traced_percent: frame.traced_percent,
            spare_percent: frame.spare_percent,
            bytes_per_sample: frame.bytes_per_sample,
            seconds,
            full_over_inferred: full_seconds / seconds,
            over_early: seconds / self.seconds(EARLY),
        }
    }
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

impl Row {
    /// Formats a line below [`header`].
    fn text(&self) -> String {
        let Self { scene, flow, lights, samples, frame, full_seconds, target, paper } = self;
        format!(
            "| {scene:<9} | {flow:<9} | {lights:>6} | {samples:>7} | {frame:>5} | {:6.2} | {:5.2} | {:7.1} | {:8.1} | {:5.1} \
             | {full_seconds:6.4} | {:8.4} | {:7.4} | {:11.2} | {:10.2} | {:6.2} | {:5.2} |",
            target.traced_percent,
            paper.traced_percent,
            target.spare_percent,
            target.bytes_per_sample,
            paper.bytes_per_sample,
            target.seconds,
            paper.seconds,
            target.full_over_inferred,
            paper.full_over_inferred,
            target.over_early,
            paper.over_early,
        )
    }
}

/// Formats the header. Columns of `paper` are those of the paper's rule, of the figure to their left.
fn header() -> String {
    let line = "| scene     | flow      | lights | samples | frame | anew % | paper | spare % | B/sample | paper \
                | full s | target s | paper s | full/target | full/paper | over 5 | paper |";
    let rule: String = line.chars().map(|c| if c == '|' { '|' } else { '-' }).collect();
    format!("{line}\n{rule}")
}
