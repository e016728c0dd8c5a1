//! Measurements as a table and as JSON.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use serde::Serialize;

use afterimage::layers::Layers;

use super::Arguments;
use super::contest::{Contestant, Cost, Outcome};
use super::kinds::Setup;

/// Row of one shot.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    pub scene: &'static str,
    pub shot: String,
    /// Number of lights, or `soft`.
    pub lights: String,
    /// Number of samples of a pixel.
    pub samples: u32,
    /// Number of mirrors and panes that a ray may meet.
    pub depth: u32,
    /// Costs by the contestant's name.
    pub costs: BTreeMap<&'static str, Cost>,
    pub full_over_raw: f64,
    /// Ratio of the pure-Rust tracer's time to Embree's.
    pub rust_over_full: f64,
    /// Speed of a reprojected frame relative to a full one.
    pub full_over_reprojected: f64,
    pub bytes_per_sample: f64,
}

impl Row {
    /// Creates a row for `outcome` of one kind of shot.
    pub fn new(scene: &'static str, shot: String, setup: Setup, outcome: &Outcome) -> Self {
        let of = |contestant: Contestant| outcome.costs[contestant as usize];
        let full = of(Contestant::Full).seconds;
        Self {
            scene,
            shot,
            lights: setup.lights.to_string(),
            samples: setup.samples * setup.samples,
            depth: setup.depth,
            costs: Contestant::ALL.into_iter().map(|who| (who.name(), of(who))).collect(),
            full_over_raw: full / of(Contestant::Raw).seconds,
            rust_over_full: of(Contestant::Rust).seconds / full,
            full_over_reprojected: full / of(Contestant::Reprojected).seconds,
            bytes_per_sample: outcome.bytes_per_sample,
        }
    }

    /// Formats a line below [`header`].
    pub fn text(&self) -> String {
        let costs = Contestant::ALL.map(|who| self.costs[who.name()]);
        let seconds: String = costs.iter().map(|cost| format!(" {:8.4} |", cost.seconds)).collect();
        let rays: String = costs.iter().map(|cost| format!(" {:8.2} |", cost.rays / 1e6)).collect();
        let kept = 100.0 * self.costs[Contestant::Reprojected.name()].kept;
        format!(
            "| {:<9} | {:<6} | {:>6} | {:>7} | {:>5} |{seconds} {:8.2} | {:9.2} | {:11.2} |{rays} {kept:4.0} | {:8.1} |",
            self.scene,
            self.shot,
            self.lights,
            self.samples,
            self.depth,
            self.full_over_raw,
            self.rust_over_full,
            self.full_over_reprojected,
            self.bytes_per_sample,
        )
    }
}

/// Seconds a frame by contestant, ratios, millions of rays a frame by contestant, percent of the samples kept.
pub fn header() -> String {
    let names = Contestant::ALL.map(Contestant::name);
    let seconds: String = names.iter().map(|name| format!(" {:>8} |", format!("{name} s"))).collect();
    let rays: String = names.iter().map(|name| format!(" {:>8} |", format!("{name} M"))).collect();
    let rule = |line: &str| -> String { line.chars().map(|c| if c == '|' { '|' } else { '-' }).collect() };
    let line = format!(
        "| scene     | shot   | lights | samples | depth |{seconds} full/raw | rust/full | full/reproj |{rays} kept | B/sample |"
    );
    format!("{line}\n{}", rule(&line))
}

/// Machine and load with which it was measured, and how.
#[derive(Debug, Clone, Serialize)]
pub struct Circumstances {
    pub processor: String,
    pub threads: usize,
    /// The system's load average over a minute before the start: what else was running.
    pub load_before: f64,
    pub size: [u32; 2],
    pub frames: u32,
    pub rounds: u32,
    /// Layers beside the picture's colours.
    pub layers: Layers,
}

impl Circumstances {
    /// Determines the present circumstances.
    pub fn now(arguments: &Arguments) -> Self {
        let (size, frames, rounds) = (arguments.size(), arguments.frames(), arguments.rounds());
        let layers = arguments.layers();
        let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
        let load_before = load.split(' ').next().and_then(|load| load.parse().ok()).unwrap_or(0.0);
        let threads = rayon::current_num_threads();
        Self { processor: processor(), threads, load_before, size, frames, rounds, layers }
    }

    /// Describes the machine, for the first line above a table.
    pub fn machine(&self) -> String {
        let Self { processor, threads, load_before, .. } = self;
        format!("{processor}, {threads} threads; load before the start: {load_before}")
    }

    /// Formats the lines above a table of shots.
    pub fn text(&self) -> String {
        let Self { size: [width, height], frames, rounds, layers, .. } = self;
        let layers: Vec<&str> = ["R G B A"].into_iter().chain(layers.names()).collect();
        format!(
            "{}\n\
             {width}x{height}; each number is the mean of {} frames, each of which counts as in the fastest \
             of {rounds} rounds; layers: {}",
            self.machine(),
            frames - 1,
            layers.join(", ")
        )
    }
}

/// Name of the processor, from the system.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split(": ").nth(1));
    name.unwrap_or("a processor").to_owned()
}

/// Writes `rows` to `path`.
pub fn write_json<T: Serialize>(
    path: &Path,
    circumstances: &Circumstances,
    rows: &[T],
) -> Result<(), Box<dyn Error>> {
    #[derive(Serialize)]
    struct File<'a, T> {
        circumstances: &'a Circumstances,
        rows: &'a [T],
    }
    std::fs::write(path, serde_json::to_string_pretty(&File { circumstances, rows })?)?;
    Ok(())
}
