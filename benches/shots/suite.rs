//! Shots to measure, scene by scene.

use std::error::Error;
use std::path::Path;

use afterimage::animation::TransformTrack;
use afterimage::frame::Renderer;
use afterimage::scene::{self, Scene};
use afterimage::settings::Settings;
use afterimage::trace::BackendKind;
use clap::ValueEnum;
use serde::Serialize;

use super::bare::Bare;
use super::contest::Arena;
use super::kinds::{Kind, Lights, MOST_LIGHTS, Setup, shot_file};
use super::places::{Place, SceneName, generated};
use super::table::{Circumstances, Row, header, write_json};
use super::{Arguments, folder};

/// Number of triangles of the object that moves alone.
const OBJECT_TRIANGLES: u64 = 5_000;

/// Measured unless the command line says otherwise: every kind with the first of these...
const SETUPS: [Setup; 6] = [
    Setup::of(Lights::Points(1), 1, 0),
    Setup::of(Lights::Points(8), 1, 0),
    Setup::of(Lights::Points(MOST_LIGHTS), 1, 0),
    Setup::of(Lights::Soft, 1, 0),
    Setup::of(Lights::Points(1), 2, 0),
    Setup::of(Lights::Points(1), 2, 4),
];

/// ... and these kinds with the others: one that reprojection serves best, and one that it serves badly.
const KINDS_OF_ALL_SETUPS: [Kind; 2] = [Kind::Object, Kind::Dolly];

/// Measures what `arguments` ask for; prints rows as they come.
pub fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    run_scenes(arguments, &header(), "shots.json", measure_scene)
}

/// Lets `measure` add rows of each requested scene that exists, below `header`. They are written to `file` as
/// well.
pub fn run_scenes<R: Serialize>(
    arguments: &Arguments,
    header: &str,
    file: &str,
    measure: impl Fn(&Arguments, &Place, &mut Vec<R>) -> Result<(), Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    let circumstances = Circumstances::now(arguments);
    println!("{}\n\n{header}", circumstances.text());
    let mut rows = Vec::new();
    let mut missing = Vec::new();
    let scenes = if arguments.scenes.is_empty() { SceneName::value_variants() } else { &arguments.scenes };
    for name in scenes {
        match name.place(arguments.triangles(), &folder()) {
            Ok(place) => measure(arguments, &place, &mut rows)?,
            Err(error) => missing.push(error.to_string()),
        }
    }
    missing.iter().for_each(|why| println!("skipped: {why}"));
    let path = folder().join(file);
    write_json(&path, &circumstances, &rows)?;
    println!("\nalso in {}", path.display());
    Ok(())
}

fn measure_scene(arguments: &Arguments, place: &Place, rows: &mut Vec<Row>) -> Result<(), Box<dyn Error>> {
    let (mut scene, settings) = load(place, arguments)?;
    let lights = std::mem::take(&mut scene.lights);
    let track = std::mem::replace(&mut scene.models[0].track, TransformTrack::identity());
    for moves_all in [false, true] {
        let setups = setups(arguments, moves_all);
        if setups.iter().all(|(_, kinds)| kinds.is_empty()) {
            continue;
        }
        if moves_all {
            scene.models[0].track = track.clone();
        }
        let mut bare = Bare::new(&scene)?;
        for (setup, kinds) in setups.iter().filter(|(_, kinds)| !kinds.is_empty()) {
            scene.lights = setup.lights.of(&lights).to_vec();
            let settings = Settings { samples: setup.samples, depth: setup.depth, ..settings.clone() };
            let [renderer, rust] =
                [BackendKind::Embree, BackendKind::Rust].map(|kind| Renderer::with(kind, &scene, &settings));
            let (renderer, rust) = (renderer?, rust?);
            let mut arena = Arena { scene: &scene, settings: &settings, bare: &mut bare, renderer, rust };
            for kind in kinds {
                let first = kind.first_frame();
                let frames = first..first + arguments.frames() as i32;
                let outcome = arena.measure(frames, arguments.rounds())?;
                let row = Row::new(place.name, kind.name(), *setup, &outcome);
                println!("{}", row.text());
                rows.push(row);
            }
        }
    }
    Ok(())
}

/// Kinds to measure with each set-up; those that move all models apart, as they need another build.
fn setups(arguments: &Arguments, moves_all: bool) -> Vec<(Setup, Vec<Kind>)> {
    let by_default =
        arguments.lights.is_empty() && arguments.samples.is_empty() && arguments.depth.is_empty();
    let kinds = if arguments.kinds.is_empty() { Kind::value_variants() } else { &arguments.kinds };
    let chosen = |setup: Setup| {
        let wanted = |kind: &&Kind| {
            let extra = arguments.kinds.is_empty() && by_default && setup != SETUPS[0];
            kind.moves_all() == moves_all && (!extra || KINDS_OF_ALL_SETUPS.contains(kind))
        };
        (setup, kinds.iter().filter(wanted).copied().collect())
    };
    if by_default {
        let count = if arguments.quick { 2 } else { SETUPS.len() };
        return SETUPS.into_iter().take(count).map(chosen).collect();
    }
    let lights = if arguments.lights.is_empty() { &[Lights::Points(1)] } else { arguments.lights.as_slice() };
    let samples = if arguments.samples.is_empty() { &[1] } else { arguments.samples.as_slice() };
    let depths = if arguments.depth.is_empty() { &[0] } else { arguments.depth.as_slice() };
    let of = |lights: Lights| {
        let each = samples.iter().flat_map(|samples| depths.iter().map(move |depth| (samples, depth)));
        each.map(move |(samples, depth)| Setup::of(lights, *samples, *depth))
    };
    lights.iter().flat_map(|lights| of(*lights)).map(chosen).collect()
}

/// Loads the scene with all lights, and settings for one sample a pixel.
pub fn load(place: &Place, arguments: &Arguments) -> Result<(Scene, Settings), Box<dyn Error>> {
    let object = generated(OBJECT_TRIANGLES, &folder())?;
    let text = shot_file(place, &object.to_string_lossy(), arguments.frames());
    let path = folder().join(format!("{}.toml", place.name));
    std::fs::write(&path, text)?;
    let shot = scene::load(Path::new(&path), false)?;
    let [width, height] = arguments.size();
    Ok((shot.scene, Settings { width, height, samples: 1, layers: arguments.layers(), ..shot.settings }))
}
