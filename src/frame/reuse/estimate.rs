//! Estimate, from a few samples and before any work is done, of whether reprojection pays: `--mode auto`
//! traces frames in which it does not. In every mode a frame is traced in which next to nothing is seen
//! again: a cut that nobody has marked.
//!
//! The decision is a function of the samples and the poses alone, never of a clock: frames stay the same to
//! the bit on every machine.

use rayon::prelude::*;

use super::bins::STEPS;
use super::project::project_lanes;
use super::sight::{Outdated, segments};
use crate::frame::grid::Grid;
use crate::frame::grid::bits::{bit, set_bits, surface_bits};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::{CameraChange, LightChange};
use crate::frame::surface::ray_tally::RayTally;
use crate::lanes::LANES;
use crate::samples::{CELLS, Flags, SampleStore, Tile};
use crate::trace::{Coherence, Occluders, Purpose, RayBatch};

/// Costs of the steps of a sample, in units of tracing one: a primary ray and storing its hit. They favour
/// reprojection: it is to lose only in frames of which little is seen again, and where both cost about the
/// same, as in a dolly past matt models under one light, the samples that are kept serve later frames.
mod cost {
    /// Projecting an old sample, finding the cell that it serves, and copying it there; and probing edges.
    pub const REPROJECT: f32 = 0.5;
    /// The ray that verifies that it is still seen.
    pub const VERIFY: f32 = 0.3;
    /// Tracing a sample that shows the background: a ray that meets nothing, and no surface to store or to
    /// light.
    pub const BACKGROUND: f32 = 0.25;
    /// Tracing a surface that moved, less what reprojection pays more for it than for others: it is placed
    /// anew again and again, and all its shadow rays are cast.
    pub const MOVED: f32 = 0.5;
    /// The shadow ray to a light that did not move, which a surface that is traced needs.
    pub const SHADOW: f32 = 0.4;
    /// A ray of ambient occlusion from a surface that is traced.
    pub const OCCLUSION: f32 = 0.5;
    /// A path that gathers light for a surface that is traced, for each surface that it meets.
    pub const GATHER: f32 = 3.0;
}

/// Least share of the samples of the frame before that must be in sight. Nothing is inferred, in any mode,
/// for a frame that has less and does not pay: it shows something else, as after a cut. As many samples may
/// be in sight by chance.
const LEAST_SEEN: f32 = 1.0 / 16.0;

/// Number of tiles that are probed together: their segments fill whole packets.
const TILES_AT_ONCE: usize = 64;

/// Result of the estimate.
#[derive(Debug, Default)]
pub struct Estimate {
    /// True if the frame is to be inferred, not traced.
    pub pays: bool,
    /// True if hardly anything of the frame before is still in sight.
    pub is_cut: bool,
    /// Rays of the estimate: for each tile, a bit mask of those of its eight probed samples that needed one.
    asked: Vec<u8>,
}

/// Estimates whether to infer this frame from `old`. Eight samples of some tiles are projected and, where the
/// eye moved, verified.
pub fn estimate(old: &SampleStore, frame: &FrameView) -> Estimate {
    let mut asked = vec![0; old.tiles.len()];
    let ask = |(number, (tiles, asked)): (usize, (&[Box<Tile>], &mut [u8]))| {
        ask_tiles(number * TILES_AT_ONCE, tiles, old.tiles.len(), frame, asked)
    };
    let groups = old.tiles.par_chunks(TILES_AT_ONCE).zip(asked.par_chunks_mut(TILES_AT_ONCE)).enumerate();
    let sum = groups.map(ask).reduce(Asked::default, Asked::plus);
    let share = |count: u64| count as f32 / sum.asked.max(1) as f32;
    let spent = cost::REPROJECT + cost::VERIFY * share(sum.verified);
    let lights = frame.pose.lights.iter().zip(&frame.plan.lights);
    let kept = lights.filter(|(_, change)| **change != LightChange::Moved);
    let shadow_rays: usize = kept.map(|(light, _)| light.points).sum();
    let path_rays = frame.paths as f32 * frame.settings.bounces as f32;
    let occlusion_rays = frame.occlusion.map_or(0.0, |occlusion| occlusion.rays as f32);
    let kept_rays = cost::SHADOW * shadow_rays as f32 + cost::OCCLUSION * occlusion_rays;
    let surface = 1.0 + kept_rays + cost::GATHER * path_rays;
    let gained = share(sum.seen[AT_REST]) * surface
        + share(sum.seen[MOVED]) * cost::MOVED
        + share(sum.seen[BACKGROUND]) * cost::BACKGROUND;
    let seen = share(sum.seen.iter().sum());
    let spread = sum.spread(fields(&frame.view.grid));
    let traced = gained + (1.0 - seen) * surface;
    let cost = (spent + traced - gained * spread) / traced;
    let pays = cost < 1.0;
    Estimate { pays, is_cut: !pays && seen < LEAST_SEEN, asked }
}

impl Estimate {
    /// Counts the rays of tile number `number` for the cells whose samples were probed.
    pub fn count(&self, number: usize, tally: &mut RayTally) {
        let asked = self.asked.get(number).copied().unwrap_or(0);
        tally.counts.verification += u64::from(asked.count_ones());
        set_bits(asked).for_each(|lane| tally.cells.verification[first_asked(number) + lane] += 1);
    }
}

/// Number of fields across and down: no more than tiles.
fn fields(grid: &Grid) -> [usize; 2] {
    [grid.tiles_x, grid.tiles_y].map(|tiles| FIELDS.min(tiles as usize))
}

/// Column and row of the field that contains tile number `number`.
fn field(grid: &Grid, number: usize) -> [usize; 2] {
    let ([across, down], [tiles_x, tiles_y]) = (fields(grid), [grid.tiles_x as usize, grid.tiles_y as usize]);
    [number % tiles_x * across / tiles_x, number / tiles_x * down / tiles_y]
}

/// Returns true if tile number `number` of `tiles` is probed: of many tiles some that are spread over the
/// picture.
fn is_asked(number: usize, tiles: usize) -> bool {
    // some 2000 samples: the error of their share is a hundredth
    const ENOUGH: usize = 256;
    // the golden section of a word: neighbours in a row or a column are far apart in this order
    let place = (number as u32).wrapping_mul(0x9e37_79b9);
    tiles <= ENOUGH || u64::from(place) < ((ENOUGH as u64) << 32) / tiles as u64
}

/// First of the eight samples of tile number `number` that are probed: another eight in each tile.
fn first_asked(number: usize) -> usize {
    // odd: in turn, all places of a tile are probed
    const STRIDE: usize = 37;
    (number * STRIDE * LANES) % CELLS
}

/// Counts of the samples that were probed.
#[derive(Debug, Clone, Copy, Default)]
struct Asked {
    asked: u64,
    verified: u64,
    /// Samples that are still seen: surfaces at rest, surfaces that moved, background.
    seen: [u64; 3],
    /// Samples that fell into each of the picture's [`fields`], row by row.
    fallen: [[u64; FIELDS]; FIELDS],
}

/// Largest number of fields along an edge of the picture; they show if samples fall into all of it.
const FIELDS: usize = 8;

/// Indices of `seen`: surfaces that did not move, surfaces that did, and the background.
const AT_REST: usize = 0;
const MOVED: usize = 1;
const BACKGROUND: usize = 2;

impl Asked {
    fn plus(self, other: Self) -> Self {
        Self {
            asked: self.asked + other.asked,
            verified: self.verified + other.verified,
            seen: std::array::from_fn(|what| self.seen[what] + other.seen[what]),
            fallen: std::array::from_fn(|y| std::array::from_fn(|x| self.fallen[y][x] + other.fallen[y][x])),
        }
    }

    /// Share of the samples that fall into the picture which can have a cell of their own: where the eye has
    /// gone far back, all that was seen falls into a few cells.
    fn spread(&self, [across, down]: [usize; 2]) -> f32 {
        // factor by which a field may exceed an even share by chance
        const CROWD: f32 = 1.3;
        let room = CROWD * self.asked as f32 / (across * down) as f32;
        let counts = || self.fallen.iter().flatten().map(|count| *count as f32);
        counts().map(|count| count.min(room)).sum::<f32>() / counts().sum::<f32>().max(1.0)
    }
}

/// Probes eight samples of some tiles, the first of which has the number `number` of `of`, and notes in
/// `asked` which samples needed a ray.
fn ask_tiles(number: usize, tiles: &[Box<Tile>], of: usize, frame: &FrameView, asked: &mut [u8]) -> Asked {
    let casts = frame.plan.camera == CameraChange::Moved;
    let (mut rays, mut shown_by_ray, mut ticks) = (RayBatch::default(), Vec::new(), Vec::new());
    let mut sum = Asked::default();
    let all = tiles.iter().zip(asked).enumerate();
    for (i, (tile, asked)) in all.filter(|(i, _)| is_asked(number + i, of)) {
        let first = first_asked(number + i);
        let projected = project_lanes(frame, tile, first);
        for lane in set_bits(projected.which) {
            let at = [projected.x[lane], projected.y[lane]].map(|at| (at / STEPS) as u32);
            let [x, y] = field(&frame.view.grid, frame.view.grid.tile_at(at));
            sum.fallen[y][x] += 1;
        }
        let inside = projected.which & !Outdated::find(frame, tile, first, Flags::default()).ended;
        let models = &tile.model[first..first + LANES];
        let (surfaces, moved) = (surface_bits(models), frame.moved_bits(models));
        let shown = |lane: usize| match (surfaces >> lane & 1, moved >> lane & 1) {
            (0, _) => BACKGROUND,
            (_, 0) => AT_REST,
            _ => MOVED,
        };
        sum.asked += LANES as u64;
        set_bits(inside).for_each(|lane| sum.seen[shown(lane)] += 1);
        if casts {
            segments(frame, tile, first, inside, &mut rays);
            shown_by_ray.extend(set_bits(inside).map(shown));
            if frame.pose.has_ticks() {
                ticks.extend(set_bits(inside).map(|lane| tile.record[first + lane].traced.tick()));
            }
            *asked = inside;
        }
    }
    if frame.pose.has_ticks() {
        rays.set_ticks(ticks.into_iter());
    }
    let mut blocked = vec![0; rays.packet_count()];
    for by in [Occluders::Still, Occluders::Movable] {
        frame.tracer.blocked(&rays, by, Purpose::Sight, Coherence::Coherent, &mut blocked);
    }
    sum.verified = rays.len() as u64;
    for (_, shown) in shown_by_ray.into_iter().enumerate().filter(|(ray, _)| bit(&blocked, *ray)) {
        sum.seen[shown] -= 1;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_tiles_enough_are_asked_everywhere() {
        assert!((0..256).all(|number| is_asked(number, 256)));
        for (across, down) in [(40, 23), (80, 45), (480, 270)] {
            let asked = |rows: std::ops::Range<usize>| {
                let numbers = rows.start * across..rows.end * across;
                numbers.filter(|number| is_asked(*number, across * down)).count()
            };
            assert!((230..280).contains(&asked(0..down)), "{}", asked(0..down));
            let halves = [asked(0..down / 2), asked(down / 2..down)];
            assert!(halves.iter().all(|half| *half > 100), "{halves:?}");
        }
    }
}
