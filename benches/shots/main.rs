//! `cargo bench --bench shots`: measures the cost of bare tracing, full frames by both tracers, and
//! reprojected frames, by kind of shot.
//!
//! All contestants are measured in one run, side by side, because machines are noisy: ratios between numbers
//! of two runs mean little. docs/performance.md has the tables.

mod bare;
mod chains;
mod contest;
mod cutouts;
mod equal;
mod fastest;
mod flows;
mod gathered;
mod glass;
mod growth;
mod guard;
mod incoherent;
mod kinds;
mod modes;
mod places;
mod rough;
mod sphere;
mod suite;
mod table;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use afterimage::layers::Layers;
use clap::{Parser, ValueEnum};

use flows::Flow;
use kinds::{Kind, Lights};
use places::SceneName;

/// Measures shots: bare Embree, full frames and reprojected frames, side by side
#[derive(Debug, Clone, Parser)]
#[command(name = "shots", bin_name = "cargo bench --bench shots --")]
pub struct Arguments {
    /// Subject to measure
    #[arg(value_enum, default_value = "shots")]
    subject: Subject,

    /// Scenes [default: all; of chains all but the sphere]
    #[arg(long, value_enum, value_delimiter = ',')]
    scenes: Vec<SceneName>,

    /// Kinds of shots [default: all with one light and one sample, some with more]
    #[arg(long, value_enum, value_delimiter = ',')]
    kinds: Vec<Kind>,

    /// Camera moves of chains [default: all with one light, 1x1 and 2x2 samples, some with others]
    #[arg(long, value_enum, value_delimiter = ',')]
    flows: Vec<Flow>,

    /// For gathered light: rows whose name contains this [default: all]
    #[arg(long)]
    moves: Option<String>,

    /// For gathered light: this roughness (`Pr`) on all materials but glass
    #[arg(long, value_name = "PR")]
    rough: Option<f32>,

    /// Chains up to frame 300
    #[arg(long)]
    long: bool,

    /// Numbers of point lights, up to 32; `soft` is one panel, with 16 shadow rays a sample [default: 1, and
    /// others for some kinds]
    #[arg(long, value_delimiter = ',')]
    lights: Vec<Lights>,

    /// Number of mirrors and panes of glass that a ray may meet [default: 0: only rays that the limit has,
    /// too]
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(u32).range(0..=64))]
    depth: Vec<u32>,

    /// Samples along a pixel's edge [default: 1, and 2 for some kinds]
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=16))]
    samples: Vec<u32>,

    /// Layers to make beside `R G B A`: as the program's option of this name [default: all; of chains none]
    #[arg(long, value_parser = Layers::parse)]
    layers: Option<Layers>,

    /// Pixels [default: 1280x720, of chains 640x360, at equal time 320x180; with --quick half as wide and high]
    #[arg(long, value_parser = size, value_name = "WxH")]
    size: Option<[u32; 2]>,

    /// Frames of a shot, the base frame among them [default: 6; with --quick 3]
    #[arg(long, value_parser = clap::value_parser!(u32).range(2..=999))]
    frames: Option<u32>,

    /// Number of times that everything is measured; the fastest counts [default: 2; with --quick 1]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: Option<u32>,

    /// Triangles of the generated sphere, and the most whose growth is shown [default: 10 million; with
    /// --quick 500 000]
    #[arg(long)]
    triangles: Option<u64>,

    /// Small enough for a minute: to see that all works, not to quote
    #[arg(long)]
    quick: bool,

    /// For `guard`: the commit that this program is compared with
    #[arg(long, value_name = "COMMIT", default_value = "HEAD")]
    against: String,

    /// Passed by cargo to every benchmark
    #[arg(long, hide = true)]
    bench: bool,
}

/// Subjects of measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Subject {
    /// Every kind of shot
    Shots,
    /// Growth of cost with triangles (up to --triangles, or 30 million), pixels, frames, lights and threads;
    /// takes the size, frames, rounds and layers
    Growth,
    /// Newly traced samples and costs of long chains of inferred frames at frames 24, 96 and, with --long,
    /// 300, beside the paper's rule; takes the scenes, flows, lights, samples, layers, size and the first
    /// depth
    Chains,
    /// Whole runs with `--mode full`, `reproject` and `auto`; takes the scenes, kinds, lights, samples, size, frames, rounds and
    /// layers
    Modes,
    /// Light from all around, kept path by path: full frames beside inferred ones, by what moves; takes the scenes
    /// (kitchen, city), moves, size, frames, samples, layers and the first depth
    Gathered,
    /// Error at equal time of light from all around in a dolly through the kitchen: full frames, and inferred ones that
    /// spend what reuse saves; takes the size, frames (of full tracing) and the first depth
    Equal,
    /// Rays that go all around, those of light paths in the kitchen: bare loops beside the tracer, and a frame beside both;
    /// takes the size and rounds
    Incoherent,
    /// This program and another commit's in turn, by kind of shot: has a change made frames slower? Takes all that `shots` takes,
    /// and --against
    Guard,
    /// Cost of cut-outs: leaves on quads beside whole and modelled ones, rays a second, by kind; takes the size, frames, rounds and layers
    Cutouts,
    /// Cost of glass before a sphere of a million triangles (or --triangles): rays a second, by kind
    Glass,
}

impl Arguments {
    fn size(&self) -> [u32; 2] {
        let [width, height] = match self.subject {
            Subject::Chains | Subject::Incoherent | Subject::Cutouts => [640, 360],
            Subject::Equal => [320, 180],
            _ => [1280, 720],
        };
        self.size.unwrap_or(if self.quick { [width / 2, height / 2] } else { [width, height] })
    }

    fn layers(&self) -> Layers {
        let alone = matches!(self.subject, Subject::Chains | Subject::Gathered);
        // the layers of the documentation's figures: the former default, before it became smaller
        let many = "diffuse,specular,reflection,refraction,albedo,Z,P,N,object,status,rays";
        let of_figures = if alone { Layers::NONE } else { Layers::parse(many).unwrap_or_default() };
        self.layers.unwrap_or(of_figures)
    }

    fn frames(&self) -> u32 {
        self.frames.unwrap_or(if self.quick { 3 } else { 6 })
    }

    fn rounds(&self) -> u32 {
        self.rounds.unwrap_or(if self.quick { 1 } else { 2 })
    }

    fn triangles(&self) -> u64 {
        self.triangles.unwrap_or(if self.quick { 500_000 } else { 10_000_000 })
    }
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let (width, height) = text.split_once('x').ok_or("write width and height as 1280x720")?;
    let side = |text: &str| match text.parse() {
        Ok(side @ 1..=65_535) => Ok(side),
        _ => Err(format!("`{text}` is no number of pixels")),
    };
    Ok([side(width)?, side(height)?])
}

/// Folder for generated models and results.
pub fn folder() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    target.join("bench")
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder())?;
    match arguments.subject {
        Subject::Shots => suite::run(arguments),
        Subject::Growth => growth::run(arguments),
        Subject::Chains => chains::run(arguments),
        Subject::Modes => modes::run(arguments),
        Subject::Gathered => gathered::run(arguments),
        Subject::Equal => equal::run(arguments),
        Subject::Incoherent => incoherent::run(arguments),
        Subject::Guard => guard::run(arguments, &arguments.against),
        Subject::Cutouts => cutouts::run(arguments),
        Subject::Glass => glass::run(arguments),
    }
}
