//! Prints seconds and bytes of a 1280x720 frame with 37 channels, for deflate levels and methods.
//!
//! `cargo run --release -p afterimage-openexr --example write_speed [FOLDER]`; the folder defaults to the
//! temporary one. Planes imitate a rendered frame: noisy colours, empty layers, coverage that is 0 or
//! 1, positions and normals that vary smoothly, and a sky.

use std::error::Error;
use std::fs::File;
use std::path::PathBuf;
use std::time::Instant;

use openexr::{Channel, Compression, Data, Image, SampleType, write_at_level};

const WIDTH: usize = 1280;
const HEIGHT: usize = 720;
const HALVES: usize = 25;
const CHANNELS: usize = 37;
const REPEATS: u32 = 3;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map_or_else(std::env::temp_dir, PathBuf::from);
    let path = folder.join(format!("write_speed-{}.exr", std::process::id()));
    let names: Vec<String> = (0..CHANNELS).map(|index| format!("layer{:02}.v", index)).collect();
    let planes: Vec<Vec<f32>> = (0..CHANNELS).map(plane).collect();
    let stored = |index| {
        if index < HALVES { SampleType::Half } else { SampleType::Float }
    };
    let channels: Vec<Channel<'_>> = (0..CHANNELS)
        .map(|index| Channel {
            name: &names[index],
            stored: stored(index),
            data: Data::Floats(&planes[index]),
        })
        .collect();
    println!("OpenEXR {}, {} threads", openexr::version(), rayon::current_num_threads());
    println!("method level seconds processor-seconds megabytes");
    let zips = [1, 2, 3, 4, 6].map(|level| (Compression::Zips, level));
    let others = [(Compression::Zip, 1), (Compression::Piz, 1), (Compression::None, 1)];
    for (compression, level) in zips.into_iter().chain(others) {
        let (width, height) = (WIDTH as u32, HEIGHT as u32);
        let (channels, attributes) = (channels.clone(), Vec::new());
        let image = Image { width, height, placed: None, channels, attributes, compression };
        let (mut best, before) = (f64::INFINITY, processor_seconds());
        for _ in 0..REPEATS {
            let start = Instant::now();
            write_at_level(&File::create(&path)?, &path, &image, level)?;
            best = best.min(start.elapsed().as_secs_f64());
        }
        let busy = (processor_seconds() - before) / f64::from(REPEATS);
        let megabytes = std::fs::metadata(&path)?.len() as f64 / 1e6;
        println!("{:<6} {level:>5} {best:>7.3} {busy:>17.3} {megabytes:>9.1}", format!("{compression:?}"));
    }
    std::fs::remove_file(&path)?;
    Ok(())
}

/// Time of all threads so far: what a file costs, however busy the machine is. Linux only, else 0.
fn processor_seconds() -> f64 {
    const TICKS_PER_SECOND: f64 = 100.0; // the kernel's unit towards programs
    let status = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = status.rsplit_once(')').map_or("", |(_, fields)| fields).split_whitespace();
    let ticks = fields.skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok());
    ticks.sum::<f64>() / TICKS_PER_SECOND
}

fn plane(channel: usize) -> Vec<f32> {
    let mut state = 0x9E37_79B9_u32 ^ channel as u32;
    let mut noise = move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        (state >> 8) as f32 / 16_777_216.0
    };
    let pixel = |index: usize| {
        let (x, y) = ((index % WIDTH) as f32 / WIDTH as f32, (index / WIDTH) as f32 / HEIGHT as f32);
        value(channel, x, y, noise())
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

/// `x` and `y` run from 0 to 1 over the frame, `noise` is uniform in 0 to 1.
fn value(channel: usize, x: f32, y: f32, noise: f32) -> f32 {
    let sky = y < 0.25;
    let object = (x * 8.0) as usize + 8 * (y * 5.0) as usize;
    match channel {
        0..12 if sky => 0.3 + 0.1 * y,
        0..12 => {
            let tint = 0.2 + 0.1 * (object % 5) as f32;
            tint * (0.7 + 0.3 * (x * 20.0).sin() * y) * (0.95 + 0.05 * noise)
        }
        12..18 => 0.0,
        18..25 => f32::from(object % 3 == 0 && channel % 2 == 0),
        25..31 if sky => 1e4,
        25..31 => 10.0 / (0.01 + y) + channel as f32 * x + 0.1 * (x * 50.0).sin(),
        31..34 if sky => 0.0,
        31..34 => (x * 3.0 + y).sin() * (0.9 + 0.1 * (y * 40.0).cos()),
        _ if sky => 2.5,
        _ => 3.0 * x - 0.5 * y * x,
    }
}
