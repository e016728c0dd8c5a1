//! Rays a second of both backends on one scene, in one run: `cargo run --release --example trace_speed --
//! SCENE.obj|SHOT.toml [ROUNDS] [WxH]`.
//!
//! Four kinds of rays, each the same for both backends: primary rays of the shot's first frame in packets of
//! 4 x 4 pixels; segments from the eye to what they meet (as verification casts them); shadow rays from there to
//! the first light; and rays from there in all directions, each for itself. The backends take turns; the
//! best round of each counts, because whatever else the machine does can only slow it down.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use afterimage::pose::LightSource;
use afterimage::pose::Pose;
use afterimage::scene;
use afterimage::settings::Build;
use afterimage::trace::embree::EmbreeBackend;
use afterimage::trace::rust::RustBackend;
use afterimage::trace::{
    Backend, Coherence, HitBatch, Occluders, Purpose, RayBatch, SceneSubset, Search, Tracer,
};
use glam::Vec3;
use rayon::prelude::*;

/// Rays in a batch: those of a tile of the renderer.
const BATCH: usize = 1024;

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let path = words.next().ok_or("which scene? trace_speed SCENE.obj|SHOT.toml [ROUNDS] [WxH]")?;
    let rounds: usize = words.next().map_or(Ok(5), |word| word.parse())?;
    let size = words.next().unwrap_or_else(|| String::from("1280x720"));
    let (width, height) = size.split_once('x').ok_or("a size is written 1280x720")?;
    let shot = scene::load(Path::new(&path), false)?;
    let scene = &shot.scene;
    let pose = Pose::new(scene, shot.frames.first());

    let start = Instant::now();
    let mut embree = EmbreeBackend::new(scene, Build::Best)?;
    let embree_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut rust = RustBackend::new(scene);
    let rust_seconds = start.elapsed().as_secs_f64();
    let triangles: usize = scene.models.iter().map(|model| model.mesh.count()).sum();
    println!("{path}: {triangles} triangles, {} threads, best of {rounds}", rayon::current_num_threads());
    println!("{:<14}{:>12}{:>12}{:>10}", "", "embree", "rust", "ratio");
    println!(
        "{:<14}{embree_seconds:>10.2} s{rust_seconds:>10.2} s{:>10.2}",
        "build",
        embree_seconds / rust_seconds
    );

    let moved = vec![true; scene.models.len()];
    let tracers = [embree.commit(&pose, &moved)?, rust.commit(&pose, &moved)?];
    let primary = primary_rays(&pose, width.parse()?, height.parse()?);
    let hits = closest(&*tracers[0], &primary, Coherence::Coherent);
    let ends = ends_of(&primary, &hits);
    let shadow = shadow_rays(&pose, &ends);
    let scattered = scattered_rays(&ends);
    report("primary", rounds, &tracers, &primary, |tracer| {
        count_hits(&closest(tracer, &primary, Coherence::Coherent), &primary)
    });
    let sights = sight_rays(&pose, &ends);
    report("sight", rounds, &tracers, &sights, |tracer| count_blocked(tracer, &sights, Purpose::Sight));
    report("shadow", rounds, &tracers, &shadow, |tracer| count_blocked(tracer, &shadow, Purpose::Shadow));
    report("incoherent", rounds, &tracers, &scattered, |tracer| {
        count_hits(&closest(tracer, &scattered, Coherence::Incoherent), &scattered)
    });
    Ok(())
}

/// Prints million rays a second of both, and how many rays met something.
fn report(
    kind: &str,
    rounds: usize,
    tracers: &[Box<dyn Tracer + '_>; 2],
    rays: &[RayBatch],
    work: impl Fn(&dyn Tracer) -> usize,
) {
    let count: usize = rays.iter().map(RayBatch::len).sum();
    let (mut best, mut met) = ([f64::INFINITY; 2], [0; 2]);
    for _ in 0..rounds {
        for (which, tracer) in tracers.iter().enumerate() {
            let start = Instant::now();
            met[which] = work(&**tracer);
            best[which] = best[which].min(start.elapsed().as_secs_f64());
        }
    }
    let speed = best.map(|seconds| count as f64 / seconds / 1e6);
    println!(
        "{kind:<14}{:>8.2} M/s{:>8.2} M/s{:>10.2}   {count} rays, {} and {} met something",
        speed[0],
        speed[1],
        speed[1] / speed[0],
        met[0],
        met[1]
    );
}

fn closest(tracer: &dyn Tracer, rays: &[RayBatch], coherence: Coherence) -> Vec<HitBatch> {
    let trace = |batch: &RayBatch| {
        let mut hits = HitBatch::default();
        tracer.closest(batch, Search::from_eye(SceneSubset::All, coherence), &mut hits);
        hits
    };
    rays.par_iter().map(trace).collect()
}

fn count_hits(hits: &[HitBatch], rays: &[RayBatch]) -> usize {
    let of =
        |(hits, rays): (&HitBatch, &RayBatch)| (0..rays.len()).filter(|ray| hits.get(*ray).is_some()).count();
    hits.iter().zip(rays).map(of).sum()
}

fn count_blocked(tracer: &dyn Tracer, rays: &[RayBatch], purpose: Purpose) -> usize {
    let trace = |batch: &RayBatch| -> usize {
        let mut blocked = vec![0_u16; batch.packet_count()];
        tracer.blocked(batch, Occluders::Still, purpose, Coherence::Coherent, &mut blocked);
        tracer.blocked(batch, Occluders::Movable, purpose, Coherence::Coherent, &mut blocked);
        blocked.iter().map(|bits| bits.count_ones() as usize).sum()
    };
    rays.par_iter().map(trace).sum()
}

/// Collects rays into batches.
#[derive(Default)]
struct Batches(Vec<RayBatch>);

impl Batches {
    fn open(&mut self) -> &mut RayBatch {
        if self.0.last().is_none_or(|batch| batch.len() == BATCH) {
            self.0.push(RayBatch::default());
        }
        self.0.last_mut().expect("one was just pushed, if there was none")
    }
}

fn primary_rays(pose: &Pose, width: usize, height: usize) -> Vec<RayBatch> {
    let camera = &pose.camera;
    let mut batches = Batches::default();
    for corner in (0..height / 32 * 32).step_by(32).flat_map(|y| (0..width).step_by(32).map(move |x| [x, y]))
    {
        // a tile: packets of 4 x 4
        for i in 0..BATCH {
            let (packet, lane) = (i / 16, i % 16);
            let x = corner[0] + packet % 8 * 4 + lane % 4;
            let y = corner[1] + packet / 8 * 4 + lane / 4;
            let across = (2.0 * (x as f32 + 0.5) - width as f32) / height as f32 * camera.half_height;
            let upwards = (1.0 - 2.0 * (y as f32 + 0.5) / height as f32) * camera.half_height;
            let direction = camera.forward + camera.right * across + camera.up * upwards;
            batches.open().push(camera.eye, direction, 0.0, f32::INFINITY);
        }
    }
    batches.0
}

/// Where a ray ended: the point, the way back, the model and the triangle.
type End = (Vec3, Vec3, u32, u32);

fn ends_of(rays: &[RayBatch], hits: &[HitBatch]) -> Vec<End> {
    let mut ends = Vec::new();
    for (rays, hits) in rays.iter().zip(hits) {
        for (packet, (ray, _)) in rays.packets().enumerate() {
            for lane in 0..16 {
                if let Some(hit) = hits.get(packet * 16 + lane) {
                    let of = |values: &[[f32; 16]; 3]| Vec3::from([0, 1, 2].map(|axis| values[axis][lane]));
                    let way = of(&ray.direction);
                    ends.push((of(&ray.origin) + way * hit.t, -way, hit.model, hit.triangle));
                }
            }
        }
    }
    ends
}

fn sight_rays(pose: &Pose, ends: &[End]) -> Vec<RayBatch> {
    let mut batches = Batches::default();
    for (point, _, model, triangle) in ends {
        let (eye, end) = (pose.camera.eye, 1.0 - 1e-5);
        batches.open().push_to_sample(eye, *point - eye, 0.0, end, *model, *triangle);
    }
    batches.0
}

fn shadow_rays(pose: &Pose, ends: &[End]) -> Vec<RayBatch> {
    let mut batches = Batches::default();
    let light = pose.lights.first().map(|light| light.shape.source());
    for (point, back, ..) in ends {
        let start = *point + *back * 1e-4;
        let (to_light, far) = match light {
            Some(LightSource::Place(place)) => (place - start, 1.0),
            Some(LightSource::Direction(to_light)) => (to_light, f32::INFINITY),
            None => (Vec3::Y, f32::INFINITY),
        };
        batches.open().push(start, to_light, 0.0, far);
    }
    batches.0
}

fn scattered_rays(ends: &[End]) -> Vec<RayBatch> {
    let mut batches = Batches::default();
    let mut state = 1_u32;
    let mut random = || {
        // xorshift: always the same rays
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state as f32 / u32::MAX as f32 * 2.0 - 1.0
    };
    for (point, back, ..) in ends {
        let mut way = Vec3::new(random(), random(), random());
        if way.dot(*back) < 0.0 {
            way = -way;
        }
        batches.open().push(*point + *back * 1e-4, way, 0.0, f32::INFINITY);
    }
    batches.0
}
