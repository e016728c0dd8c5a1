//! Growth of cost with triangles, pixels, lights, frames and threads: the dolly before the generated sphere.

use std::error::Error;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use afterimage::film::Film;
use afterimage::frame::Renderer;
use afterimage::scene::Scene;
use afterimage::settings::Settings;
use rayon::ThreadPoolBuilder;
use serde::Serialize;

use super::contest::{Cost, full_and_reprojected};
use super::kinds::{Kind, Lights, MOST_LIGHTS};
use super::places::{Place, generated, rippled_sphere};
use super::suite::load;
use super::table::{Circumstances, write_json};
use super::{Arguments, folder};

/// A line of the table.
#[derive(Debug, Clone, Serialize)]
struct Row {
    /// Name of the growing quantity.
    of: &'static str,
    /// Value of the growing quantity.
    at: String,
    /// Seconds for reading the OBJ; only if another one is read.
    read_seconds: Option<f64>,
    build_seconds: f64,
    full: Cost,
    reprojected: Cost,
}

type Failable<T> = Result<T, Box<dyn Error>>;

/// Measures; prints a table for each thing that grows.
pub fn run(arguments: &Arguments) -> Failable<()> {
    let circumstances = Circumstances::now(arguments);
    println!("{}", circumstances.text());
    let mut rows = triangles(arguments)?;
    let sphere = rippled_sphere(generated(if arguments.quick { 100_000 } else { 1_000_000 }, &folder())?);
    let (mut scene, settings) = load(&sphere, arguments)?;
    let lights = scene.lights.clone();
    scene.lights.truncate(1);
    rows.extend(pixels(arguments, &scene, &settings)?);
    rows.extend(threads(arguments, &scene, &settings)?);
    rows.extend(lengths(arguments, &sphere)?);
    title("lights");
    for set in [Lights::Points(1), Lights::Points(8), Lights::Points(MOST_LIGHTS), Lights::Soft] {
        scene.lights = set.of(&lights).to_vec();
        rows.push(measure("lights", set.to_string(), None, &scene, &settings, arguments)?);
    }
    let path = folder().join("growth.json");
    write_json(&path, &circumstances, &rows)?;
    println!("\nalso in {}", path.display());
    Ok(())
}

fn triangles(arguments: &Arguments) -> Failable<Vec<Row>> {
    let counts = [10_000, 100_000, 1_000_000, 10_000_000, 30_000_000];
    let most = if arguments.quick { 100_000 } else { arguments.triangles() };
    title("triangles");
    let mut rows = Vec::new();
    for count in counts.into_iter().filter(|count| *count <= most) {
        let place = rippled_sphere(generated(count, &folder())?);
        let start = Instant::now();
        let (mut scene, settings) = load(&place, arguments)?;
        let read = start.elapsed().as_secs_f64();
        scene.lights.truncate(1);
        rows.push(measure("triangles", count.to_string(), Some(read), &scene, &settings, arguments)?);
    }
    Ok(rows)
}

fn pixels(arguments: &Arguments, scene: &Scene, settings: &Settings) -> Failable<Vec<Row>> {
    title("pixels");
    let sizes = [[854, 480], [1280, 720], [1920, 1080], [3840, 2160]];
    let measured = sizes.into_iter().map(|[width, height]| {
        let settings = Settings { width, height, ..settings.clone() };
        measure("pixels", format!("{width}x{height}"), None, scene, &settings, arguments)
    });
    measured.collect()
}

/// Measures the numbers of threads. Also compares the pictures of all of them: they must be the same to the
/// bit.
fn threads(arguments: &Arguments, scene: &Scene, settings: &Settings) -> Failable<Vec<Row>> {
    title("threads");
    let most = rayon::current_num_threads();
    let mut counts: Vec<usize> =
        std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|n| *n < most).collect();
    counts.push(most);
    let mut rows: Vec<Row> = Vec::new();
    let mut pictures = Vec::new();
    for count in &counts {
        let pool = ThreadPoolBuilder::new().num_threads(*count).build()?;
        // an error is told as text, because it crosses to this thread
        let (row, film) = pool.install(|| {
            let row = measure("threads", count.to_string(), None, scene, settings, arguments);
            let film = picture(scene, settings, frames(arguments));
            row.and_then(|row| Ok((row, film?))).map_err(|error| error.to_string())
        })?;
        rows.push(row);
        pictures.push(film);
    }
    for (row, count) in rows.iter().zip(&counts) {
        let efficiency = |part: fn(&Row) -> f64| 100.0 * part(&rows[0]) / (*count as f64 * part(row));
        println!(
            "{count} threads: parallel efficiency {:.0} % (full), {:.0} % (reprojected), {:.0} % (build)",
            efficiency(|row| row.full.seconds),
            efficiency(|row| row.reprojected.seconds),
            efficiency(|row| row.build_seconds),
        );
    }
    if pictures.iter().any(|film| *film != pictures[0]) {
        return Err("the pictures of different numbers of threads are not the same".into());
    }
    println!("the pictures of all numbers of threads are the same to the bit");
    Ok(rows)
}

/// Runs of several lengths: does a chain of frames become dearer, or keep less, the longer it is?
fn lengths(arguments: &Arguments, place: &Place) -> Failable<Vec<Row>> {
    title("frames");
    let mut rows = Vec::new();
    for frames in if arguments.quick { [3, 6, 12] } else { [6, 24, 96] } {
        let arguments = Arguments { frames: Some(frames), ..arguments.clone() };
        let (mut scene, settings) = load(place, &arguments)?;
        scene.lights.truncate(1);
        let row = measure("frames", frames.to_string(), None, &scene, &settings, &arguments)?;
        println!("{frames} frames: {:.1} % of the samples kept", 100.0 * row.reprojected.kept);
        rows.push(row);
    }
    Ok(rows)
}

fn frames(arguments: &Arguments) -> Range<i32> {
    let first = Kind::Dolly.first_frame();
    first..first + arguments.frames() as i32
}

/// Renders the last frame, inferred from all before it.
fn picture(scene: &Scene, settings: &Settings, mut frames: Range<i32>) -> Failable<Arc<Film>> {
    let mut renderer = Renderer::new(scene, settings)?;
    let first = renderer.render(frames.next().unwrap_or_default(), false)?;
    frames.try_fold(first.film, |_, frame| Ok(renderer.render(frame, true)?.film))
}

fn measure(
    of: &'static str,
    at: String,
    read_seconds: Option<f64>,
    scene: &Scene,
    settings: &Settings,
    arguments: &Arguments,
) -> Failable<Row> {
    let mut renderer = Renderer::new(scene, settings)?;
    let build_seconds = renderer.build_seconds();
    let [full, reprojected] = full_and_reprojected(&mut renderer, frames(arguments), arguments.rounds())?;
    println!(
        "| {at:>9} | {:>7} | {build_seconds:7.3} | {:7.4} | {:8.4} | {:11.2} |",
        read_seconds.map_or(String::new(), |seconds| format!("{seconds:.3}")),
        full.seconds,
        reprojected.seconds,
        full.seconds / reprojected.seconds,
    );
    Ok(Row { of, at, read_seconds, build_seconds, full, reprojected })
}

fn title(of: &str) {
    println!("\n| {of:>9} |  read s | build s |  full s | reproj s | full/reproj |");
    println!("|-----------|---------|---------|---------|----------|-------------|");
}
