//! `cargo bench --bench quality`: the picture quality of frames that reuse samples. It measures no times.
//!
//! docs/quality.md says what is measured, and has the results.

mod coverage;
mod flows;
mod kitchen;
mod measure;
mod panels;
mod picture;
mod reference;
mod sequence;
mod subjects;
mod table;
#[path = "../../tests/toy/mod.rs"]
mod toy;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use afterimage::cli::args::values::{FilterArg, filter_radius};
use afterimage::output::png::write_png;
use clap::{Parser, ValueEnum};

use flows::Flow;
use measure::{Comparison, Options};
use subjects::Subject;

/// Measures the quality of frames that reuse samples
#[derive(Debug, Clone, Parser)]
#[command(name = "quality", bin_name = "cargo bench --bench quality --")]
struct Arguments {
    /// Scenes [default: all]
    #[arg(long, value_enum, value_delimiter = ',')]
    shot: Vec<Shot>,

    /// Camera moves [default: all of the shot's]
    #[arg(long, value_enum, value_delimiter = ',')]
    flow: Vec<Flow>,

    /// Samples along a pixel's edge, of 1, 2, 4 and 8 [default: 1,2,4; with --quick 1,2]
    #[arg(long, value_delimiter = ',', value_parser = one_of_samples)]
    samples: Vec<u32>,

    /// Frames to measure, of a chain that starts at frame 1 [default: 24,96,300; with --quick 24]
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(i32).range(2..=2000))]
    frames: Vec<i32>,

    /// Pixels; memory: some 25 KB a pixel [default: 320x180; with --quick 160x90]
    #[arg(long, value_parser = size, value_name = "WxH")]
    size: Option<[u32; 2]>,

    /// Pixel filter of inferred and of centred frames; references and jittered frames have the box
    #[arg(long, value_enum, default_value = "box")]
    filter: FilterArg,

    /// Radius of that filter, in pixels, 0.5 to 4 [default: by the filter]
    #[arg(long, value_name = "PIXELS", value_parser = filter_radius)]
    filter_radius: Option<f32>,

    /// Write a picture for each row: reference, inferred frame, and four times their difference
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,

    /// List the materials with the largest area errors below each row
    #[arg(long)]
    objects: bool,

    /// A minute's worth: to see that everything works, not to quote
    #[arg(long)]
    quick: bool,

    /// Passed by cargo to every benchmark
    #[arg(long, hide = true)]
    bench: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Shot {
    /// Discs before a chequered plane
    Discs,
    /// Wires 1.2 pixels wide before a chequered plane
    Wires,
    /// Discs that move
    Movers,
    /// An interior of a million triangles; not shipped
    Kitchen,
}

fn one_of_samples(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(samples @ (1 | 2 | 4 | 8)) => Ok(samples),
        _ => Err(String::from("must be 1, 2, 4 or 8, so that 16 is a multiple")),
    }
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let (width, height) = text.split_once('x').ok_or("write width and height as 320x180")?;
    let side = |text: &str| match text.parse() {
        Ok(side @ 1..=4000) => Ok(side),
        _ => Err(format!("`{text}` is no number of pixels from 1 to 4000")),
    };
    Ok([side(width)?, side(height)?])
}

impl Arguments {
    fn options(&self) -> Options {
        let mut frames = if self.frames.is_empty() {
            if self.quick { vec![24] } else { vec![24, 96, 300] }
        } else {
            self.frames.clone()
        };
        frames.sort_unstable();
        frames.dedup();
        let size = self.size.unwrap_or(if self.quick { [160, 90] } else { [320, 180] });
        Options {
            size,
            frames,
            filter: (self.filter.into(), self.filter_radius),
            reference: 16,
            sequence: 8,
            window: 16,
            seeds: 8,
        }
    }

    fn samples(&self) -> Vec<u32> {
        match (self.samples.is_empty(), self.quick) {
            (false, _) => self.samples.clone(),
            (true, true) => vec![1, 2],
            (true, false) => vec![1, 2, 4],
        }
    }
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
    let options = arguments.options();
    arguments.png.as_ref().map_or(Ok(()), std::fs::create_dir_all)?;
    let shots = if arguments.shot.is_empty() { Shot::value_variants() } else { &arguments.shot };
    for shot in shots {
        let subject = match shot {
            Shot::Discs => subjects::discs(),
            Shot::Wires => subjects::wires(options.size[1]),
            Shot::Movers => subjects::movers(),
            Shot::Kitchen => match kitchen::kitchen() {
                Ok(subject) => subject,
                Err(error) => {
                    eprintln!("kitchen left out: {error}");
                    continue;
                }
            },
        };
        measure(&subject, arguments, &options)?;
    }
    Ok(())
}

fn measure(subject: &Subject, arguments: &Arguments, options: &Options) -> Result<(), Box<dyn Error>> {
    let is_asked = |flow: &&Flow| arguments.flow.is_empty() || arguments.flow.contains(flow);
    let names: Vec<String> = subject.scene.materials.iter().map(|material| material.name.clone()).collect();
    let (mut all, mut pops) = (Vec::new(), Vec::new());
    table::print_head(subject.name, options.size);
    for flow in subject.flows.iter().filter(is_asked) {
        let comparison = Comparison::new(subject, *flow, options)?;
        for samples in arguments.samples() {
            for (number, row) in comparison.rows(samples)?.into_iter().enumerate() {
                table::print_row(&row);
                if arguments.objects {
                    table::print_materials(&row, &names);
                }
                if let Some(folder) = &arguments.png {
                    let name =
                        format!("{}-{}-{samples}x{samples}-{}.png", subject.name, flow.name(), row.frame);
                    let panels = panels::side_by_side(&comparison.reference(number), &row.picture);
                    write_png(&folder.join(name), &panels)?;
                }
                all.push(row);
            }
            pops.push(comparison.pops(samples)?);
        }
    }
    table::print_summary(&all);
    table::print_pops(&pops);
    Ok(())
}
