//! `cargo bench --bench quality`: how good frames are that reuse samples, beside frames that were traced anew.
//!
//! docs/quality.md says what is measured, and has the tables. No time is measured.

mod coverage;
mod fine;
mod flows;
mod kitchen;
mod measure;
mod panels;
mod picture;
mod subjects;
mod table;
#[path = "../../tests/toy/mod.rs"]
mod toy;
mod watched;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use afterimage::output::png::write_png;
use clap::{Parser, ValueEnum};

use flows::Flow;
use measure::{Extent, Yardstick};
use subjects::Subject;

/// Measures the quality of frames that reuse samples
#[derive(Debug, Clone, Parser)]
#[command(name = "quality", bin_name = "cargo bench --bench quality --")]
struct Arguments {
    /// What is seen [default: all]
    #[arg(long, value_enum, value_delimiter = ',')]
    shot: Vec<Shot>,

    /// How the camera moves [default: all that the shot has]
    #[arg(long, value_enum, value_delimiter = ',')]
    flow: Vec<Flow>,

    /// Samples along a pixel's edge, of 1, 2, 4 and 8 [default: 1,2,4; with --quick 1,2]
    #[arg(long, value_delimiter = ',', value_parser = one_of_samples)]
    samples: Vec<u32>,

    /// Frames that are measured; the chain begins with frame 1 [default: 24,96,300; with --quick 24]
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(i32).range(2..=2000))]
    frames: Vec<i32>,

    /// Pixels; the reference takes 60 bytes for each of its 256 samples a pixel [default: 320x180; with --quick 160x90]
    #[arg(long, value_parser = size, value_name = "WxH")]
    size: Option<[u32; 2]>,

    /// Writes a picture of each row: reference, inferred frame, and four times their difference
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,

    /// Tells of each row which materials cover too much or too little, those that are furthest off first
    #[arg(long)]
    objects: bool,

    /// Small enough for a minute: to see that all works, not to quote
    #[arg(long)]
    quick: bool,

    /// What cargo says to every benchmark
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
        _ => Err(String::from("cells must hold whole samples of the reference: 1, 2, 4 or 8")),
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
    fn extent(&self) -> Extent {
        let mut frames = if self.frames.is_empty() {
            if self.quick { vec![24] } else { vec![24, 96, 300] }
        } else {
            self.frames.clone()
        };
        frames.sort_unstable();
        frames.dedup();
        let size = self.size.unwrap_or(if self.quick { [160, 90] } else { [320, 180] });
        Extent { size, frames, fine: 16, watched: 8, window: 16, seeds: 8 }
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
    let extent = arguments.extent();
    arguments.png.as_ref().map_or(Ok(()), std::fs::create_dir_all)?;
    let shots = if arguments.shot.is_empty() { Shot::value_variants() } else { &arguments.shot };
    for shot in shots {
        let subject = match shot {
            Shot::Discs => subjects::discs(),
            Shot::Wires => subjects::wires(extent.size[1]),
            Shot::Movers => subjects::movers(),
            Shot::Kitchen => match kitchen::kitchen() {
                Ok(subject) => subject,
                Err(error) => {
                    eprintln!("kitchen left out: {error}");
                    continue;
                }
            },
        };
        measure(&subject, arguments, &extent)?;
    }
    Ok(())
}

fn measure(subject: &Subject, arguments: &Arguments, extent: &Extent) -> Result<(), Box<dyn Error>> {
    let is_asked = |flow: &&Flow| arguments.flow.is_empty() || arguments.flow.contains(flow);
    let names: Vec<String> = subject.scene.materials.iter().map(|material| material.name.clone()).collect();
    let mut jumps = Vec::new();
    table::print_head(subject.name, extent.size);
    for flow in subject.flows.iter().filter(is_asked) {
        let yardstick = Yardstick::new(subject, *flow, extent)?;
        for samples in arguments.samples() {
            for (number, row) in yardstick.rows(samples)?.iter().enumerate() {
                table::print_row(row);
                if arguments.objects {
                    table::print_materials(row, &names);
                }
                if let Some(folder) = &arguments.png {
                    let name =
                        format!("{}-{}-{samples}x{samples}-{}.png", subject.name, flow.name(), row.frame);
                    write_png(
                        &folder.join(name),
                        &panels::side_by_side(yardstick.reference(number), &row.picture),
                    )?;
                }
            }
            jumps.push(yardstick.jumps(samples)?);
        }
    }
    table::print_jumps(&jumps);
    Ok(())
}
