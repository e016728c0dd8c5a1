//! Rays that go all around: how many a second bare loops of Embree's queries answer, one by one and in packets, how many
//! the renderer's tracer, and what a frame of such rays takes beside that.
//!
//! The rays are those of light paths in the kitchen: from what the eye sees by the cosine law, from there on once more, and from
//! both to directions of the sky. For bare loops they are prepared beforehand; only the calls that trace them are timed.

use std::error::Error;
use std::fmt::Write as _;
use std::time::Instant;

use afterimage::frame::Renderer;
use afterimage::pose::Pose;
use afterimage::scene::{Environment, Scene, SkyDensity};
use afterimage::settings::{Build, Mode, Settings};
use afterimage::shade::sampling::{PathSequence, cosine_direction, orthonormal, seed_of};
use afterimage::trace::embree::EmbreeBackend;
use afterimage::trace::{
    Backend, Coherence as How, HitBatch, LANES, Occluders, Purpose, RayBatch, SceneSubset, Search, Tracer,
};
use embree::{Coherence, Committed, PacketWidth, RayHit, Segment};
use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;

use super::bare::{self, Bare};
use super::places::SceneName;
use super::table::{Circumstances, write_json};
use super::{Arguments, folder, gathered};

/// Number of rays that a worker traces at once: as many as the renderer does.
const BATCH: usize = 1024;
/// Number of rays that are sorted at once.
const STREAM: usize = 16 * BATCH;

type Failable<T> = Result<T, Box<dyn Error>>;

/// One kind of ray.
struct Rays {
    name: &'static str,
    /// True if the rays ask for occlusion, and not for hits.
    is_shadow: bool,
    batches: Vec<RayBatch>,
}

/// Millions of rays a second of one kind.
#[derive(Debug, Clone, Serialize)]
struct Row {
    rays: &'static str,
    one_by_one: f64,
    packets: f64,
    packets_sorted: f64,
    tracer: f64,
    /// Ratio of the fastest bare loop to the tracer.
    bare_over_tracer: f64,
}

/// Prints a line for each kind of ray, and one for a frame.
pub fn run(arguments: &Arguments) -> Failable<()> {
    let circumstances = Circumstances::now(arguments);
    println!("{}\n", circumstances.text());
    let place = SceneName::Kitchen.place(arguments.triangles(), &folder())?;
    let (scene, settings) = gathered::under_a_sky(&place, arguments)?;
    let rows = rates(arguments, &scene, &settings)?;
    println!("\n{}", frame(arguments, &scene, &settings, &rows)?);
    let path = folder().join("incoherent.json");
    write_json(&path, &circumstances, &rows)?;
    println!("\nalso in {}", path.display());
    Ok(())
}

/// Measures each kind of ray; prints lines as they come.
fn rates(arguments: &Arguments, scene: &Scene, settings: &Settings) -> Failable<Vec<Row>> {
    let sky = scene.environment.clone().ok_or("the sky that was just set")?;
    let mut backend = EmbreeBackend::new(scene, Build::Best)?;
    let pose = Pose::new(scene, 1);
    let tracer = backend.commit(&pose, &vec![true; scene.models.len()])?;
    let mut limit = Bare::new(scene)?;
    let width = limit.width();
    let bare = limit.still()?;
    println!(
        "| million rays a second  | one by one | packets of {:>2} | sorted | tracer | bare/tracer |",
        width.lanes()
    );
    println!("|------------------------|------------|---------------|--------|--------|-------------|");
    let mut rows = Vec::new();
    for rays in kinds(scene, settings, &pose, &*tracer, &sky) {
        let row = measure(arguments.rounds(), &rays, &*tracer, bare, width);
        println!("{}", row.text());
        rows.push(row);
    }
    Ok(rows)
}

/// Creates all kinds of rays, as many as pixels leave of them.
fn kinds(
    scene: &Scene,
    settings: &Settings,
    pose: &Pose,
    tracer: &dyn Tracer,
    sky: &Environment,
) -> Vec<Rays> {
    let seen = ends(scene, pose, tracer, &bare::primary_batches(settings, pose), How::Coherent);
    let first = bounced(&seen, 0);
    let met = ends(scene, pose, tracer, &first, How::Incoherent);
    let second = bounced(&met, 1);
    let [near, far] = [(&seen, 0), (&met, 1)].map(|(ends, number)| to_sky(ends, sky, number));
    let rays = |name, is_shadow, batches| Rays { name, is_shadow, batches };
    vec![
        rays("first bounce", false, first),
        rays("second bounce", false, second),
        rays("to the sky", true, near),
        rays("to the sky, bounced", true, far),
    ]
}

/// End of a ray on a surface: a point just off it, and its normal on the ray's side (world space).
type End = (Vec3, Vec3);

fn ends(scene: &Scene, pose: &Pose, tracer: &dyn Tracer, batches: &[RayBatch], how: How) -> Vec<End> {
    let of_batch = |rays: &RayBatch| {
        let mut hits = HitBatch::default();
        tracer.closest(rays, Search::from_eye(SceneSubset::All, how), &mut hits);
        let packets = rays.packets().enumerate();
        let hits = packets.flat_map(|(packet, (ray, _))| {
            let hits = &hits;
            (0..LANES).filter_map(move |lane| {
                let hit = hits.get(packet * LANES + lane)?;
                let of = |rows: &[[f32; LANES]; 3]| Vec3::from([0, 1, 2].map(|axis| rows[axis][lane]));
                let (origin, direction) = (of(&ray.origin), of(&ray.direction));
                let mesh = &scene.models[hit.model as usize].mesh;
                let corner = |corner: u32| {
                    pose.models[hit.model as usize]
                        .point(mesh.triangles().positions.as_slice()[corner as usize].into())
                };
                let [a, b, c] = mesh.triangles().corners[hit.triangle as usize].map(corner);
                let normal = (b - a).cross(c - a).normalize();
                let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
                Some((origin + direction * hit.t + normal * 1e-4, normal))
            })
        });
        hits.collect::<Vec<End>>()
    };
    batches.par_iter().flat_map_iter(of_batch).collect()
}

/// Creates a ray from each of `ends`, by the cosine law.
fn bounced(ends: &[End], number: u32) -> Vec<RayBatch> {
    let ray = |(point, normal): &End| {
        let [tangent, bitangent] = orthonormal(*normal);
        let [along, above, ..] = PathSequence::of_seed(seed_of(*point, 0)).path(0).four(2 * number);
        (*point, cosine_direction([along, above], [tangent, bitangent, *normal]))
    };
    batches(ends.iter().map(ray))
}

/// Creates a ray from each of `ends` to the sky, in a direction that it samples, if that leaves the surface.
fn to_sky(ends: &[End], sky: &Environment, number: u32) -> Vec<RayBatch> {
    let ray = |(point, normal): &End| {
        let [along, above, ..] = PathSequence::of_seed(seed_of(*point, 0)).path(0).four(2 * number + 1);
        let direction = sky.sample(SkyDensity::Peaks, [along, above]);
        (normal.dot(direction) > 0.0).then_some((*point, direction))
    };
    batches(ends.iter().filter_map(ray))
}

fn batches(rays: impl Iterator<Item = (Vec3, Vec3)>) -> Vec<RayBatch> {
    let rays: Vec<(Vec3, Vec3)> = rays.collect();
    let batch = |rays: &[(Vec3, Vec3)]| {
        let mut batch = RayBatch::default();
        rays.iter().for_each(|(origin, direction)| batch.push(*origin, *direction, 0.0, f32::INFINITY));
        batch
    };
    rays.chunks(BATCH).map(batch).collect()
}

/// Traces `rays` in each way, `rounds` times in turn; the fastest counts.
fn measure(rounds: u32, rays: &Rays, tracer: &dyn Tracer, bare: Committed, width: PacketWidth) -> Row {
    let sorted = sorted(&rays.batches);
    let mut best = [f64::INFINITY; 4];
    for _ in 0..=rounds {
        let seconds = [
            one_by_one(rays, bare),
            packets(rays.is_shadow, &rays.batches, bare, width),
            packets(rays.is_shadow, &sorted, bare, width),
            by_tracer(rays, tracer),
        ];
        best = std::array::from_fn(|way| best[way].min(seconds[way]));
    }
    let count: usize = rays.batches.iter().map(RayBatch::len).sum();
    let [one_by_one, packets, packets_sorted, tracer] = best.map(|seconds| count as f64 * 1e-6 / seconds);
    let bare_over_tracer = one_by_one.max(packets).max(packets_sorted) / tracer;
    Row { rays: rays.name, one_by_one, packets, packets_sorted, tracer, bare_over_tracer }
}

fn timed(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

fn one_by_one(rays: &Rays, bare: Committed) -> f64 {
    let segments: Vec<Vec<Segment>> =
        rays.batches.par_iter().map(|batch| segments(batch).collect()).collect();
    let how = Coherence::Incoherent;
    timed(|| {
        segments.par_iter().for_each(|batch| {
            let is_met = |segment: &&Segment| match rays.is_shadow {
                true => bare.occluded_one(segment, how),
                false => bare.intersect_one(segment, how).is_some(),
            };
            std::hint::black_box(batch.iter().filter(is_met).count());
        });
    })
}

fn segments(batch: &RayBatch) -> impl Iterator<Item = Segment> {
    batch.packets().flat_map(|(packet, lanes)| {
        (0..LANES).filter(move |lane| lanes >> lane & 1 != 0).map(move |lane| {
            let of = |rows: &[[f32; LANES]; 3]| [0, 1, 2].map(|axis| rows[axis][lane]);
            let (near, far, mask) = (packet.near[lane], packet.far[lane], bare::SIGHT);
            Segment {
                origin: of(&packet.origin),
                direction: of(&packet.direction),
                near,
                far,
                mask,
                time: 0.0,
            }
        })
    })
}

fn packets(is_shadow: bool, batches: &[RayBatch], bare: Committed, width: PacketWidth) -> f64 {
    match width {
        PacketWidth::Four => packets_of::<4>(is_shadow, batches, bare),
        PacketWidth::Eight => packets_of::<8>(is_shadow, batches, bare),
        PacketWidth::Sixteen => packets_of::<16>(is_shadow, batches, bare),
    }
}

fn packets_of<const N: usize>(is_shadow: bool, batches: &[RayBatch], bare: Committed) -> f64 {
    let mut prepared: Vec<bare::Packets<N>> =
        batches.par_iter().map(|batch| bare::prepared(batch, bare::SIGHT).collect()).collect();
    let how = Coherence::Incoherent;
    if is_shadow {
        return timed(|| {
            let packets = prepared.par_iter_mut().flatten_iter();
            packets.for_each(|(valid, ray)| bare.occluded(valid, ray, how));
        });
    }
    let with_hit = |packets: bare::Packets<N>| -> bare::HitPackets<N> {
        packets.into_iter().map(|(valid, ray)| (valid, RayHit::new(ray))).collect()
    };
    let mut prepared: Vec<bare::HitPackets<N>> = prepared.into_par_iter().map(with_hit).collect();
    timed(|| {
        let packets = prepared.par_iter_mut().flatten_iter();
        packets.for_each(|(valid, ray)| bare.intersect(valid, ray, how));
    })
}

fn by_tracer(rays: &Rays, tracer: &dyn Tracer) -> f64 {
    timed(|| {
        rays.batches.par_iter().for_each_init(Default::default, |(hits, blocked), batch| {
            if rays.is_shadow {
                let blocked: &mut Vec<u16> = blocked;
                blocked.clear();
                blocked.resize(batch.packet_count(), 0);
                for by in [Occluders::Still, Occluders::Movable] {
                    tracer.blocked(batch, by, Purpose::Shadow, How::Incoherent, blocked);
                }
            } else {
                tracer.closest(batch, Search::from_eye(SceneSubset::All, How::Incoherent), hits);
            }
        });
    })
}

/// Sorts the rays, stream by stream, by the octant of their direction and then along a curve through their
/// origins.
fn sorted(batches: &[RayBatch]) -> Vec<RayBatch> {
    let mut rays: Vec<(Vec3, Vec3)> = batches
        .iter()
        .flat_map(segments)
        .map(|segment| (segment.origin.into(), segment.direction.into()))
        .collect();
    rays.par_chunks_mut(STREAM).for_each(|stream| {
        let (low, high) = stream
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), (at, _)| (low.min(*at), high.max(*at)));
        let scale = 1023.0 / (high - low).max(Vec3::splat(1e-9));
        stream.sort_by_cached_key(|(origin, direction)| {
            let at = ((*origin - low) * scale).as_uvec3();
            let octant = direction.to_array().map(|part| u32::from(part < 0.0));
            (octant, interleaved(at.x) << 2 | interleaved(at.y) << 1 | interleaved(at.z))
        });
    });
    self::batches(rays.into_iter())
}

/// Spreads the ten lowest bits, each three places from the next: parts of a Morton code.
fn interleaved(bits: u32) -> u32 {
    (0..10).fold(0, |all, bit| all | (bits >> bit & 1) << (3 * bit))
}

/// Compares a full frame of light paths with its rays in the fastest bare loops, each kind at its own rate.
fn frame(arguments: &Arguments, scene: &Scene, settings: &Settings, rows: &[Row]) -> Failable<String> {
    let settings = Settings { paths: 16, bounces: 2, mode: Mode::Full, ..settings.clone() };
    let mut renderer = Renderer::new(scene, &settings)?;
    let mut best: Option<(f64, afterimage::stats::FrameStats)> = None;
    for number in 1..=1 + arguments.rounds() as i32 {
        let start = Instant::now();
        let stats = renderer.render(number, false)?.stats;
        let seconds = start.elapsed().as_secs_f64();
        if best.as_ref().is_none_or(|(least, _)| seconds < *least) {
            best = Some((seconds, stats));
        }
    }
    let (seconds, stats) = best.ok_or("a frame was rendered")?;
    // a half of the rays of either kind comes from what the eye sees
    let rate = |rows: &[Row]| {
        let mean =
            rows.iter().map(|row| 1.0 / row.one_by_one.max(row.packets)).sum::<f64>() / rows.len() as f64;
        1.0 / mean
    };
    let (closest, shadow) = rows.split_at(2);
    let rays = [stats.rays.gathering, stats.rays.shadow].map(|count| count as f64 * 1e-6);
    let limit = rays[0] / rate(closest) + rays[1] / rate(shadow);
    let threads = rayon::current_num_threads() as f64;
    let within = (stats.tracing.bounced + stats.tracing.shadow) / threads;
    let mut text = String::new();
    write!(
        text,
        "A full frame, 16 paths and two bounces: {:.1} million rays from surface to surface and {:.1} million to lights, \
         {seconds:.2} s; in the tracer {within:.2} s, in bare loops about {limit:.2} s. \
         Tracer over bare {:.2}, frame over bare {:.2}.",
        rays[0],
        rays[1],
        within / limit,
        seconds / limit
    )?;
    Ok(text)
}

impl Row {
    fn text(&self) -> String {
        format!(
            "| {:<22} | {:>10.2} | {:>13.2} | {:>6.2} | {:>6.2} | {:>11.2} |",
            self.rays, self.one_by_one, self.packets, self.packets_sorted, self.tracer, self.bare_over_tracer
        )
    }
}
