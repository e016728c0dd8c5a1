//! `cargo bench --bench phases`: measures the hot functions, each by itself, with a small generated scene.

#[path = "shots/sphere.rs"]
mod sphere;

use std::hint::black_box;
use std::path::Path;

use afterimage::animation::{Interpolation, Track, TransformTrack};
use afterimage::changes::Motion;
use afterimage::film::Film;
use afterimage::frame::Renderer;
use afterimage::frame::grid::Grid;
use afterimage::frame::grid::view::View;
use afterimage::geometry::{Bounds, Segments};
use afterimage::lanes::{F32x8, LANES, Vec3x8};
use afterimage::output::{FrameMeta, write_exr};
use afterimage::pose::Pose;
use afterimage::samples::CELLS;
use afterimage::scene::{self, Scene, obj};
use afterimage::settings::{Build, Settings};
use afterimage::trace::embree::EmbreeBackend;
use afterimage::trace::{Backend, Coherence, HitBatch, Occluders, Purpose, RayBatch, SceneSubset, Search};
use divan::Bencher;
use divan::counter::ItemsCount;
use glam::{DVec3, Vec3};
use tempfile::TempDir;

const TRIANGLES: u64 = 50_000;

/// A shot in which the camera travels, a light rests, and nothing else moves.
const SHOT: &str = r#"
[render]
size = [640, 360]
samples = 1
[camera]
[[camera.key]]
frame = 1
eye = [0.3, 0.8, 2.0]
target = [0, 0, 0]
[[camera.key]]
frame = 1001
eye = [-7.7, 0.8, 2.0]
target = [0, 0, 0]
[[model]]
obj = "sphere.obj"
[[light]]
type = "point"
position = [2, 3, 2.5]
power = 14
"#;

fn main() {
    divan::main();
}

/// Writes the scene's files: gone when this is dropped.
fn files() -> TempDir {
    let folder = tempfile::tempdir().expect("the folder for temporary files takes one more");
    sphere::write(&folder.path().join("sphere.obj"), TRIANGLES).expect("the disk has room for an OBJ");
    std::fs::write(folder.path().join("shot.toml"), SHOT).expect("the disk has room for a shot file");
    folder
}

fn shot(folder: &Path) -> (Scene, Settings) {
    let shot = scene::load(&folder.join("shot.toml"), false).expect("the shot above is whole");
    (shot.scene, shot.settings)
}

/// Creates primary rays, in the renderer's order.
fn rays(scene: &Scene, settings: &Settings) -> RayBatch {
    let view = View::new(&Grid::new(settings).into(), Pose::new(scene, 1).camera);
    let far = F32x8::splat(f32::INFINITY);
    let mut rays = RayBatch::default();
    for tile in 0..view.grid.tiles() {
        let corner = view.grid.tile_corner(tile).map(|at| F32x8::splat(at as f32 + 0.5));
        for first in (0..CELLS).step_by(LANES) {
            let x = corner[0] + F32x8::load(&view.grid.place_x, first);
            let y = corner[1] + F32x8::load(&view.grid.place_y, first);
            let [origins, directions] = view.middle().rays(x, y);
            rays.push_lanes(origins, directions, far, u8::MAX);
        }
    }
    rays
}

#[divan::bench]
fn read_obj(bencher: Bencher) {
    let folder = files();
    let path = folder.path().join("sphere.obj");
    bencher
        .counter(ItemsCount::new(TRIANGLES))
        .bench_local(|| obj::read(&path).expect("a generated OBJ is whole"));
}

#[divan::bench]
fn build(bencher: Bencher) {
    let folder = files();
    let (scene, _) = shot(folder.path());
    bencher
        .counter(ItemsCount::new(TRIANGLES))
        .bench_local(|| EmbreeBackend::new(&scene, Build::Best).expect("a small scene fits into memory"));
}

/// Measured on one thread.
#[divan::bench]
fn trace_closest(bencher: Bencher) {
    let folder = files();
    let (scene, settings) = shot(folder.path());
    let mut backend = EmbreeBackend::new(&scene, Build::Best).expect("a small scene fits into memory");
    let tracer = backend.commit(&Pose::new(&scene, 1), &[false]).expect("nothing moves");
    let (rays, mut hits) = (rays(&scene, &settings), HitBatch::default());
    bencher.counter(ItemsCount::new(rays.len())).bench_local(|| {
        tracer.closest(&rays, Search::from_eye(SceneSubset::All, Coherence::Coherent), &mut hits)
    });
}

/// Measured on one thread.
#[divan::bench]
fn trace_blocked(bencher: Bencher) {
    let folder = files();
    let (scene, settings) = shot(folder.path());
    let mut backend = EmbreeBackend::new(&scene, Build::Best).expect("a small scene fits into memory");
    let tracer = backend.commit(&Pose::new(&scene, 1), &[false]).expect("nothing moves");
    let rays = rays(&scene, &settings);
    bencher
        .counter(ItemsCount::new(rays.len()))
        .with_inputs(|| vec![0; rays.packet_count()])
        .bench_local_refs(|blocked| {
            tracer.blocked(&rays, Occluders::Still, Purpose::Shadow, Coherence::Coherent, blocked)
        });
}

/// Measured on one thread: segments to visible surfaces, pushed and traced in runs of so many packets. 64 are
/// a tile's, and more than most first-level caches hold.
#[divan::bench(args = [4, 8, 16, 64])]
fn push_and_block(bencher: Bencher, run: usize) {
    let folder = files();
    let (scene, settings) = shot(folder.path());
    let mut backend = EmbreeBackend::new(&scene, Build::Best).expect("a small scene fits into memory");
    let tracer = backend.commit(&Pose::new(&scene, 1), &[false]).expect("nothing moves");
    let (primary, mut hits) = (rays(&scene, &settings), HitBatch::default());
    tracer.closest(&primary, Search::from_eye(SceneSubset::All, Coherence::Coherent), &mut hits);
    let eye = Vec3x8::splat(Pose::new(&scene, 1).camera.eye);
    let segments: Vec<_> = primary
        .packets()
        .zip(hits.packets)
        .map(|((packet, lanes), hit)| {
            let [x, y, z] = &packet.direction;
            let half = |first| {
                (eye, Vec3x8::load([x, y, z], first), F32x8::load(&hit.t, first) * F32x8::splat(1.0 - 1e-5))
            };
            ([half(0), half(LANES)], hit.model, hit.triangle, lanes)
        })
        .collect();
    let mut batch = RayBatch::default();
    bencher.counter(ItemsCount::new(primary.len())).bench_local(|| {
        let mut blocked = 0;
        for run in segments.chunks(run) {
            batch.clear();
            for (ways, models, triangles, lanes) in run {
                batch.push_packet_to_samples(ways, [models, triangles], *lanes);
            }
            let mut words = [0; 64];
            let words = &mut words[..run.len()];
            tracer.blocked(&batch, Occluders::Still, Purpose::Sight, Coherence::Coherent, words);
            blocked += words.iter().map(|bits| bits.count_ones()).sum::<u32>();
        }
        blocked
    });
}

/// Time of finding how long an answer holds, on one thread: for segments to visible surfaces, past a ball
/// that crosses the view in 256 frames.
#[divan::bench]
fn first_touch(bencher: Bencher) {
    let folder = files();
    let (mut scene, settings) = shot(folder.path());
    let mut ball = scene.models[0].clone();
    let track = |from: DVec3, to: DVec3| {
        Track::through(vec![(1.0, from), (257.0, to)], Interpolation::Linear).expect("frames rise")
    };
    ball.track = TransformTrack {
        translate: track(DVec3::new(-2.0, 0.5, 1.0), DVec3::new(2.0, 0.5, 1.0)),
        scale: Track::constant(DVec3::splat(0.05)),
        ..TransformTrack::identity()
    };
    scene.models.push(ball);
    let motion = Motion::of(&scene);
    let mut backend = EmbreeBackend::new(&scene, Build::Best).expect("a small scene fits into memory");
    let tracer = backend.commit(&Pose::new(&scene, 1), &[false, true]).expect("nothing is out of reach");
    let (primary, mut hits) = (rays(&scene, &settings), HitBatch::default());
    tracer.closest(&primary, Search::from_eye(SceneSubset::All, Coherence::Coherent), &mut hits);
    let eye = Pose::new(&scene, 1).camera.eye;
    let segments: Vec<(Vec3, f32)> = primary
        .packets()
        .enumerate()
        .flat_map(|(number, (packet, _))| {
            let hits = &hits;
            (0..2 * LANES).filter_map(move |lane| {
                let hit = hits.get(number * 2 * LANES + lane)?;
                Some((Vec3::from([0, 1, 2].map(|axis| packet.direction[axis][lane])), hit.t))
            })
        })
        .collect();
    bencher.counter(ItemsCount::new(segments.len())).bench_local(|| {
        let until = |(direction, far): &(Vec3, f32)| motion.first_touch(eye, *direction, *far, 1);
        segments.iter().map(until).min()
    });
}

/// Test of segments to visible surfaces against a box, eight at a time, on one thread: the first question
/// about a kept tag.
#[divan::bench]
fn box_test(bencher: Bencher) {
    let folder = files();
    let (scene, settings) = shot(folder.path());
    let rays = rays(&scene, &settings);
    let moved = Bounds { low: Vec3::new(0.3, 0.2, 0.5), high: Vec3::new(0.5, 0.4, 0.7) };
    let bounds = black_box([moved]);
    let packets: Vec<_> =
        rays.packets().map(|(packet, _)| (packet.origin, packet.direction, packet.far)).collect();
    bencher.counter(ItemsCount::new(rays.len())).bench_local(|| {
        let mut met = 0;
        for (origin, direction, far) in &packets {
            for first in [0, LANES] {
                let [origin, direction] = [origin, direction].map(|[x, y, z]| Vec3x8::load([x, y, z], first));
                let segments = Segments::new(origin, direction, F32x8::load(far, first));
                met += bounds.iter().map(|bounds| bounds.meets(&segments).bits().count_ones()).sum::<u32>();
            }
        }
        met
    });
}

#[divan::bench]
fn base_frame(bencher: Bencher) {
    let folder = files();
    let (scene, settings) = shot(folder.path());
    let mut renderer = Renderer::new(&scene, &settings).expect("a small scene fits into memory");
    bencher.counter(samples(&settings)).bench_local(|| {
        renderer.render(1, false).expect("a commit that succeeded once");
    });
}

#[divan::bench]
fn reprojected_frame(bencher: Bencher) {
    let folder = files();
    let (scene, settings) = shot(folder.path());
    let mut renderer = Renderer::new(&scene, &settings).expect("a small scene fits into memory");
    renderer.render(0, false).expect("a small scene fits into memory");
    let mut frame = 0;
    bencher.counter(samples(&settings)).bench_local(|| {
        frame += 1;
        renderer.render(frame, true).expect("a commit that succeeded once");
    });
}

#[divan::bench]
fn write_file(bencher: Bencher) {
    let folder = files();
    let (film, meta) = frame(folder.path());
    let path = folder.path().join("frame.0001.exr");
    bencher
        .counter(ItemsCount::new(film.width * film.height))
        .bench_local(|| write_exr(&path, &film, &meta).expect("the disk has room for a frame"));
}

fn samples(settings: &Settings) -> ItemsCount {
    ItemsCount::new(settings.width * settings.height * settings.samples.pow(2))
}

fn frame(folder: &Path) -> (std::sync::Arc<Film>, FrameMeta) {
    let (scene, settings) = shot(folder);
    let mut renderer = Renderer::new(&scene, &settings).expect("a small scene fits into memory");
    let finished = renderer.render(1, false).expect("a small scene fits into memory");
    let meta = FrameMeta {
        frame: 1,
        rate: (24, 1),
        world_to_camera: finished.camera.world_to_camera().to_cols_array(),
        world_to_ndc: finished.camera.world_to_ndc(16.0 / 9.0).to_cols_array(),
        comments: "a benchmark".into(),
        shot: "sphere".into(),
        fingerprint: None,
        layers: finished.about_layers.clone(),
    };
    (finished.film, meta)
}
