//! Foresees the memory of a renderer, before there is one. Measured on the project's shots: what the process holds at most is
//! within a fifth of it. Samples that fall far from where they were are kept longer than is estimated here:
//! a picture that turns upside down at once needs up to twice the samples.

use std::collections::HashSet;
use std::sync::Arc;

use super::grid::Grid;
use super::planes::channels::{Channel, channels};
use super::planes::mixing::MixRule;
use super::secondary::ray_trees::bytes_of_tree;
use super::shot::exposed;
use crate::layers::Layers;
use crate::memory::{Need, Part};
use crate::samples::{CELLS, MirroredSamples, Sample, TagLayout, Tile};
use crate::scene::camera::Projection;
use crate::scene::{CameraTrack, LightGroups, Material, Model, Scene, Shot};
use crate::settings::{Mode, Reuse, Settings};
use crate::trace::{BackendKind, held_twice};

/// Bytes for each sample of what falls where, while a frame is inferred.
const LIST_BYTES: u64 = 16;
/// Spare samples for each that serves a cell, with what their lists have in reserve: so many gather in long chains of a moving
/// camera.
const SPARES: f64 = 0.9;
/// After so many inferred pictures there are half as many.
const HALF_OF_SPARES: f64 = 16.0;
/// Tiles of a band for each thread: as many as these are there twice.
const BAND_TILES: u64 = 32;
/// Scratch memory of a thread.
const THREAD_BYTES: u64 = 12 << 20;
/// Pages of the program and its libraries that are touched.
const PROGRAM_BYTES: u64 = 20 << 20;
/// Address space that an Embree device reserves and hardly touches.
const EMBREE_RESERVED: u64 = 128 << 20;
/// Address space that the C library reserves for each thread that begins to allocate, with its stack.
const THREAD_RESERVED: u64 = 68 << 20;

/// Foresees what [`Renderer::with`](super::Renderer::with) and so many frames, one after the other, need beside the scene, on so many
/// threads.
pub fn need(shot: &Shot, settings: &Settings, kind: BackendKind, frames: usize, threads: usize) -> Need {
    need_of_chain(shot, settings, kind, most_projected(shot, settings, frames), threads)
}

/// Like [`need`], with samples of each store projected for so many pictures.
fn need_of_chain(shot: &Shot, of_shot: &Settings, kind: BackendKind, inferred: f64, threads: usize) -> Need {
    let Scene { lights, .. } = &shot.scene;
    let settings = &exposed::picture_settings(&shot.scene, of_shot).0;
    let grids = || settings.levels().map(|samples| Grid::new(&Settings { samples, ..settings.clone() }));
    let tiles: u64 = grids().map(|grid| grid.tiles() as u64).sum();
    let samples: u64 = grids().map(|grid| grid.all_cells()).sum();
    let layout = TagLayout::for_scene(&shot.scene, settings);
    let untagged = Tile::bytes_of_cells(&TagLayout::default()) as u64;
    let spares = match settings.reuse {
        Reuse::Paper => 0.0,
        Reuse::Target => SPARES * inferred / (inferred + HALF_OF_SPARES) * samples as f64,
    };
    let spares_of = |bytes: usize| (spares * bytes as f64) as u64;
    let workers = (threads as u64).min(tiles);
    let of_eye = stores_of_eye(shot, of_shot);
    // beside a picture's own samples, those that it is lent
    let projected = if exposed::lenders(settings, &layout, of_eye as usize) > 1 { 2 } else { 1 };
    let lists = if inferred == 0.0 { 0 } else { projected * LIST_BYTES * samples };
    // all pictures are made of the same spare tiles
    let twice = (BAND_TILES * workers).min(tiles);
    let film = settings.data_window();
    let edge = of_shot.levels().last().unwrap_or(of_shot.samples);
    let (pixels, width, height) = (film.pixels(), film.width, film.height);
    let exposures = exposed::exposures(&shot.scene, of_shot);
    let stores = eyes(settings) * of_eye;

    let parts = vec![
        Part::new(
            format!(
                "{edge}x{edge} samples a pixel at {width}x{height}{}",
                match (of_eye, eyes(settings)) {
                    (1, 1) => String::new(),
                    (1, _) => String::from(" for two eyes"),
                    (_, 1) => format!(" in {of_eye} exposures"),
                    (_, _) => format!(" in {of_eye} exposures for two eyes"),
                }
            ),
            (stores * tiles + twice) * untagged + lists + stores * spares_of(size_of::<Sample>()),
            "a smaller --size, fewer --samples",
        ),
        Part::new(
            format!("what they keep of {}", kept(&shot.scene, &layout).join(" and ")),
            (stores * tiles + twice) * (CELLS * layout.bytes()) as u64 + stores * spares_of(layout.bytes()),
            match (lights.len(), layout.paths) {
                (0, _) => "fewer --paths",
                (_, 0) => "fewer lights",
                (_, _) => "fewer --paths, fewer lights",
            },
        ),
        Part::new(
            "planes of the picture",
            eyes(settings)
                * pixels
                * bytes_of_films(
                    &shot.scene,
                    settings.layers,
                    exposures.is_some(),
                    films_of_eye(shot, of_eye),
                ),
            "a smaller --size, fewer --layers",
        ),
        tracing(shot, settings, kind),
        Part::new(
            format!("{workers} threads"),
            eyes(settings) * THREAD_BYTES * workers + PROGRAM_BYTES,
            "fewer --threads",
        ),
    ];
    let reserved = match kind {
        // it builds with threads of its own
        BackendKind::Embree => [EMBREE_RESERVED, THREAD_RESERVED * embree_threads(threads)],
        BackendKind::Rust => [0, 0],
    };
    let trees = trees(&shot.scene, settings, stores * samples);
    let in_mirrors = mirrored(
        &shot.scene,
        settings,
        inferred > 0.0 && exposures.is_none() && layout.paths > 0,
        stores * samples,
    );
    let deforming = deforming(&shot.scene, settings, kind);
    let proofs = obstacles(&shot.scene, settings, inferred);
    let parts = parts
        .into_iter()
        .chain(trees.map(|bytes| Part::new("what mirrors and glass show", bytes, "a smaller --tree-memory")))
        .chain(
            in_mirrors.map(|bytes| {
                Part::new("what flat mirrors show", bytes, "a smaller --depth, fewer --samples")
            }),
        )
        .chain(proofs.map(|bytes| Part::new("proofs of what is seen", bytes, "a smaller model")))
        .chain(
            deforming
                .map(|bytes| Part::new("a frame's shapes of models that deform", bytes, "smaller models")),
        );
    Need { parts: parts.collect(), reserved }
}

/// Names the lights, paths, reflections and occlusion for which samples keep results.
fn kept(scene: &Scene, layout: &TagLayout) -> Vec<String> {
    let counted = |count: usize, what: &str| match count {
        0 => None,
        1 => Some(format!("1 {what}")),
        _ => Some(format!("{count} {what}s")),
    };
    let occlusion = (layout.occlusion_rays > 0).then(|| String::from("ambient occlusion"));
    let reflections = counted(layout.reflections, "reflection");
    let parts = [counted(scene.lights.len(), "light"), counted(layout.paths, "path"), reflections, occlusion];
    parts.into_iter().flatten().collect()
}

/// Pictures that are made, one from the other, of the samples of one store, where these are projected, at most in so many frames.
fn most_projected(shot: &Shot, settings: &Settings, frames: usize) -> f64 {
    if settings.mode == Mode::Full || (settings.stereo.is_none() && shot.scene.camera.is_constant()) {
        return 0.0;
    }
    // the first one of all is traced, and of a second eye none
    let pictures = frames.max(1).saturating_mul(eyes(settings) as usize);
    pictures as f64 - 1.0
}

/// Foresees what pictures with `settings` [beside](super::Aside) the frames of a renderer of `shot` need.
pub fn need_of_aside(shot: &Shot, settings: &Settings, kind: BackendKind, threads: usize) -> Need {
    // a camera that is led around may go on for as long as anybody wants
    let mut need = need_of_chain(shot, settings, kind, f64::from(u32::MAX), threads);
    // the renderer has it
    let tracing = tracing(shot, settings, kind);
    need.parts.retain(|part| *part != tracing);
    Need { reserved: [0; 2], ..need }
}

/// Acceleration structures of the shot.
fn tracing(shot: &Shot, settings: &Settings, kind: BackendKind) -> Part {
    Part::new(
        format!("tracing {} triangles", shot.triangles()),
        (shot.triangles() + held_twice(&shot.scene, settings.caustics)) * bytes_of_triangle(kind),
        "a smaller model",
    )
}

/// Returns true if a camera may stand still from one frame to the next.
fn may_rest(camera: &CameraTrack) -> bool {
    let rests = |frame: f64| {
        let end = camera.eye.rests_until(frame);
        end.is_finite() && end >= frame + 1.0
    };
    camera.eye.is_constant() || camera.eye.frames().into_iter().any(rests)
}

/// Bytes of ray trees, if any can be kept: as if half of all samples had one, up to what is allowed.
fn trees(scene: &Scene, settings: &Settings, samples: u64) -> Option<u64> {
    let moves = scene.models.iter().any(|model| !model.track.is_constant());
    let is_followed = || settings.depth > 0 && scene.materials.iter().any(Material::is_followed);
    let goes_on = scene.has_media() || is_followed();
    let can = moves && goes_on && settings.mode != Mode::Full && may_rest(&scene.camera);
    let all = samples / 2 * bytes_of_tree(settings.layers) as u64;
    can.then_some(all.min(u64::from(settings.tree_memory) << 20)).filter(|bytes| *bytes > 0)
}

/// Bytes of what flat mirrors show, in frames that may keep it if it `can` be kept at all: as if a quarter of all samples had one.
fn mirrored(scene: &Scene, settings: &Settings, can: bool, samples: u64) -> Option<u64> {
    let is_followed = || settings.depth > 0 && scene.materials.iter().any(Material::is_followed);
    let is_kept = can
        && is_followed()
        && settings.reuse == Reuse::Target
        && scene.camera.projection() == Projection::Perspective
        && !scene.has_media();
    Some(samples / 4 * MirroredSamples::BYTES).filter(|bytes| is_kept && *bytes > 0)
}

/// Bytes of the models at rest, as [proofs](crate::clear) need them, while they are built; if frames are inferred of samples that are
/// projected.
fn obstacles(scene: &Scene, settings: &Settings, inferred: f64) -> Option<u64> {
    const OF_TRIANGLE: u64 = 100;
    let mut seen = HashSet::new();
    let at_rest = scene.models.iter().filter(|model| model.track.is_constant());
    let meshes = at_rest.map(|model| &model.mesh).filter(|mesh| seen.insert(Arc::as_ptr(mesh)));
    let triangles: u64 = meshes.map(|mesh| mesh.count() as u64).sum();
    let asks = inferred > 0.0
        && settings.reuse == Reuse::Target
        && scene.camera.projection() == Projection::Perspective;
    Some(triangles * OF_TRIANGLE).filter(|bytes| asks && *bytes > 0)
}

/// Bytes of models that deform, if there are any: a shape as it is placed and as it is traced, and what is traced while the one before
/// is still there; within an exposure with a shutter two shapes. All shapes themselves are read by then.
fn deforming(scene: &Scene, settings: &Settings, kind: BackendKind) -> Option<u64> {
    const POSITION: usize = size_of::<[f32; 3]>();
    /// Of a box of a curve, in a tracer's tree and while that is built, with its points.
    const BYTES_OF_PIECE: u64 = 160;
    // positions twice, and normals; positions in three frames for the motion vectors of each level
    let of_motion = if settings.layers.has(Layers::ALL_MOTION) { 3 * settings.levels().count() } else { 0 };
    let exposures = exposed::exposures(scene, settings);
    let is_swept = exposures.is_some_and(|all| all.clocks().iter().any(|clock| !clock.is_instant()));
    let shapes = if is_swept { 2 } else { 1 };
    let bytes_of_vertex = (3 * shapes + of_motion) * POSITION;
    let of_model = |model: &Model| {
        if let Some(curved) = model.mesh.as_curved() {
            return u64::from(curved.count()) * BYTES_OF_PIECE * shapes as u64 * u64::from(curved.boxes());
        }
        let vertices = model.mesh.as_triangles().map_or(0, |all| all.positions.as_slice().len());
        let triangles = model.mesh.count() as u64;
        (vertices * bytes_of_vertex) as u64 + triangles * bytes_of_triangle(kind) * shapes as u64
    };
    let deforming = scene.models.iter().filter(|model| model.mesh.deforms());
    Some(deforming.map(of_model).sum()).filter(|bytes| *bytes > 0)
}

/// `need` and that of writing frames of `scene` with `settings` while the next one is rendered: a second film, and one more
/// thread.
pub fn with_writing(need: Need, scene: &Scene, settings: &Settings) -> Need {
    let pixels = settings.data_window().pixels();
    let film = Part::new(
        "the frame that is being written",
        eyes(settings) * pixels * bytes_of_pixel(scene, settings.layers),
        "a smaller --size, fewer --layers",
    );
    let mut both = need.and(Need::new(film));
    both.reserved[1] += THREAD_RESERVED;
    both
}

/// Number of sample stores of each eye: one for each exposure.
fn stores_of_eye(shot: &Shot, settings: &Settings) -> u64 {
    exposed::exposures(&shot.scene, settings).map_or(1, |exposures| exposures.all.len() as u64)
}

/// Number of films of each eye: of several exposures those are kept whose cameras rest.
fn films_of_eye(shot: &Shot, stores: u64) -> u64 {
    if may_rest(&shot.scene.camera) { stores } else { 1 }
}

/// Number of eyes: each has samples and planes of its own.
fn eyes(settings: &Settings) -> u64 {
    if settings.stereo.is_some() { 2 } else { 1 }
}

/// `need` and that of a copy of a base frame's samples, to which rendering returns: of all of its eyes and exposures.
pub fn with_kept(need: Need, shot: &Shot, settings: &Settings) -> Need {
    let layout = TagLayout::for_scene(&shot.scene, settings);
    let (of_picture, _) = exposed::picture_settings(&shot.scene, settings);
    let grids = of_picture.levels().map(|samples| Grid::new(&Settings { samples, ..of_picture.clone() }));
    let tiles: u64 = grids.map(|grid| grid.tiles() as u64).sum();
    let bytes = eyes(settings) * stores_of_eye(shot, settings) * tiles * Tile::bytes_of_cells(&layout) as u64;
    need.and(Need::new(Part::new("a copy of a base frame's samples", bytes, "--base-place first")))
}

fn embree_threads(threads: usize) -> u64 {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    threads.min(cores.saturating_sub(1)).max(1) as u64
}

/// Bytes of all planes in one pixel.
fn bytes_of_pixel(scene: &Scene, layers: Layers) -> u64 {
    channels(layers, &LightGroups::new(&scene.lights))
        .map(|channel| if channel.is_float() { 4 } else { 2 })
        .sum()
}

/// Bytes a pixel of the films of an eye: of each store one, and if it `is_mean` of exposures, of what adds up and of what comes of it. What cannot
/// be mixed is in the film of one exposure alone.
fn bytes_of_films(scene: &Scene, layers: Layers, is_mean: bool, stores: u64) -> u64 {
    let film = bytes_of_pixel(scene, layers);
    if !is_mean {
        return film;
    }
    let groups = LightGroups::new(&scene.lights);
    let bytes = |channel: &Channel| if channel.is_float() { 4 } else { 2 };
    let of_all = |channel: &Channel| MixRule::new(channel) != MixRule::Middle;
    let mixed: u64 = channels(layers, &groups).filter(of_all).map(|channel| bytes(&channel)).sum();
    4 * channels(layers, &groups).count() as u64 + 2 * film + (stores - 1) * mixed
}

/// Bytes a triangle of acceleration structures, while they are built.
fn bytes_of_triangle(kind: BackendKind) -> u64 {
    match kind {
        BackendKind::Embree => 110,
        BackendKind::Rust => 280,
    }
}
