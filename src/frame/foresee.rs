//! `--mode auto`: whether reprojection will pay, foreseen from a few samples before any work is done.
//!
//! The decision is a function of the samples and the poses alone, never of a clock: frames stay the same to
//! the bit on every machine.

use rayon::prelude::*;

use super::plan::{CameraChange, LightChange};
use super::reproject::{scatter_lanes, seen_from_behind};
use super::stage::{CellRays, Stage, bit, set_bits, surface_bits};
use super::verify::segments;
use crate::lanes::LANES;
use crate::samples::{CELLS, SampleStore, Tile};
use crate::stats::RayCounts;
use crate::trace::{Blockers, Coherence, Purpose, RayBatch};

/// What the steps of a sample's way cost, in units of tracing one: a primary ray and what is kept of its hit.
/// In favour of reprojection: the border is for frames of which little is seen again, and where both ways cost
/// about the same, as in a dolly past matt things under one light, the samples that are kept serve later frames.
mod cost {
    /// Projecting an old sample, and bringing it to its cell.
    pub const REPROJECT: f32 = 0.3;
    /// The ray that shows that it is still seen.
    pub const VERIFY: f32 = 0.3;
    /// Tracing a sample that shows the background: a ray that meets nothing, and nothing to keep or to light.
    pub const BACKGROUND: f32 = 0.25;
    /// Tracing a surface that moved, less what reprojection pays more for it than for others: it is placed anew
    /// again and again, and asks everything about its light.
    pub const MOVED: f32 = 0.5;
    /// The shadow ray to a light that did not move, which a surface that is traced needs.
    pub const SHADOW: f32 = 0.4;
}

/// Tiles with fewer reused samples than this are traced whole: a share of their cells.
pub const LEAST_REUSED: usize = CELLS / 8;

/// Tiles that are asked together: their segments fill whole packets.
const TILES_AT_ONCE: usize = 64;

/// What was foreseen.
#[derive(Debug, Default)]
pub struct Foreseen {
    /// Inferring the frame is cheaper than tracing it.
    pub pays: bool,
    /// Rays that it took to say so: for each tile, which of its eight samples that were asked needed one.
    asked: Vec<u8>,
}

/// Whether inferring this frame from `old` is cheaper than tracing it. Eight samples a tile are projected
/// and, where the eye moved, verified.
pub fn foresee(old: &SampleStore, stage: &Stage) -> Foreseen {
    let mut asked = vec![0; old.tiles.len()];
    let ask = |(number, (tiles, asked)): (usize, (&[Box<Tile>], &mut [u8]))| {
        ask_tiles(number * TILES_AT_ONCE, tiles, stage, asked)
    };
    let groups = old.tiles.par_chunks(TILES_AT_ONCE).zip(asked.par_chunks_mut(TILES_AT_ONCE)).enumerate();
    let sum = groups.map(ask).reduce(Asked::default, Asked::plus);
    let share = |count: u64| count as f32 / sum.asked.max(1) as f32;
    let spent = cost::REPROJECT + cost::VERIFY * share(sum.verified);
    let lights = stage.pose.lights.iter().zip(&stage.plan.lights);
    let kept = lights.filter(|(_, change)| **change != LightChange::Moved);
    let shadow_rays: usize = kept.map(|(light, _)| light.shape.points()).sum();
    let surface = 1.0 + cost::SHADOW * shadow_rays as f32;
    let gained = share(sum.seen[AT_REST]) * surface
        + share(sum.seen[MOVED]) * cost::MOVED
        + share(sum.seen[BACKGROUND]) * cost::BACKGROUND;
    Foreseen { pays: gained > spent, asked }
}

impl Foreseen {
    /// Counts the rays of tile number `number` for the cells whose samples were asked.
    pub fn count(&self, number: usize, rays: &mut RayCounts, cells: &mut CellRays) {
        let asked = self.asked.get(number).copied().unwrap_or(0);
        rays.verification += u64::from(asked.count_ones());
        set_bits(asked).for_each(|lane| cells.verification[first_asked(number) + lane] += 1);
    }
}

/// The first of the eight samples of tile number `number` that are asked: another eight in each.
fn first_asked(number: usize) -> usize {
    // odd: all places of a tile have their turn
    const STRIDE: usize = 37;
    (number * STRIDE * LANES) % CELLS
}

/// What became of the samples that were asked.
#[derive(Debug, Clone, Copy, Default)]
struct Asked {
    asked: u64,
    verified: u64,
    /// Still seen, by what they show.
    seen: [u64; 3],
}

/// What samples show: surfaces that did not move, surfaces that did, and the background.
const AT_REST: usize = 0;
const MOVED: usize = 1;
const BACKGROUND: usize = 2;

impl Asked {
    fn plus(self, other: Self) -> Self {
        Self {
            asked: self.asked + other.asked,
            verified: self.verified + other.verified,
            seen: std::array::from_fn(|what| self.seen[what] + other.seen[what]),
        }
    }
}

/// Asks eight samples of each tile, and notes which of them needed a ray.
fn ask_tiles(number: usize, tiles: &[Box<Tile>], stage: &Stage, asked: &mut [u8]) -> Asked {
    let casts = stage.plan.camera == CameraChange::Moved;
    let (mut rays, mut shown_by_ray) = (RayBatch::default(), Vec::new());
    let mut sum = Asked::default();
    for (i, (tile, asked)) in tiles.iter().zip(asked).enumerate() {
        let first = first_asked(number + i);
        let mut inside = 0_u8;
        scatter_lanes(stage, tile, first, |lane, _, _| inside |= 1 << lane);
        inside &= !seen_from_behind(stage, tile, first);
        let models = &tile.model[first..first + LANES];
        let (surfaces, moved) = (surface_bits(models), stage.moved_bits(models));
        let shown = |lane: usize| match (surfaces >> lane & 1, moved >> lane & 1) {
            (0, _) => BACKGROUND,
            (_, 0) => AT_REST,
            _ => MOVED,
        };
        sum.asked += LANES as u64;
        set_bits(inside).for_each(|lane| sum.seen[shown(lane)] += 1);
        if casts {
            segments(stage, tile, first, inside, &mut rays);
            shown_by_ray.extend(set_bits(inside).map(shown));
            *asked = inside;
        }
    }
    let mut blocked = vec![0; rays.packet_count()];
    for by in [Blockers::Still, Blockers::Movable] {
        stage.tracer.blocked(&rays, by, Purpose::Sight, Coherence::Coherent, &mut blocked);
    }
    sum.verified = rays.len() as u64;
    for (_, shown) in shown_by_ray.into_iter().enumerate().filter(|(ray, _)| bit(&blocked, *ray)) {
        sum.seen[shown] -= 1;
    }
    sum
}
