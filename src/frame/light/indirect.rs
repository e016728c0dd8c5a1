//! Gathering: the light that reaches samples from all around, by way of the sky and of other surfaces. It
//! does not depend on the eye, is computed path by path ([`light_paths`](super::light_paths)), and is kept
//! with the sample: only paths that are no longer valid are traced.
//!
//! Under a [budget](crate::settings::Budget) a sample gets its first paths at once, and others in later
//! frames, as far as the budget goes. Each tile has its share of the budget, so that the paths that are
//! traced depend on nothing but the tile.

use glam::Vec3;

use super::light_paths::{AT_ONCE, PathScratch, trace_paths};
use super::path_ends::{Below, PathResult, PathStart};
use super::starts::NOTHING;
use crate::changes::Until;
use crate::frame::grid::bits::{set_bits, surface_bits};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::placed::{Placed, PlacedTile, horizon};
use crate::frame::surface::ray_tally::RayTally;
use crate::lanes::LANES;
use crate::samples::{CELLS, Flags, KeptPath, PathColor, Record, Tile};
use crate::scene::Role;
use crate::settings::Budget;
use crate::shade::sampling::{PathSequence, orthonormal};
use crate::shade::within::Within;

/// Updates the light that the samples of `tile` have gathered. Samples whose light changes are flagged as
/// [`STALE`](Flags::STALE). Returns true if there are any, and the first frame in which any path may become
/// invalid.
pub fn gather(
    frame: &FrameView,
    tile: &mut Tile,
    placed: &mut PlacedTile,
    scratch: &mut PathScratch,
    tally: &mut RayTally,
) -> (bool, Until) {
    let (mut any_changed, mut least) = (false, Until::FOREVER);
    if frame.paths == 0 {
        return (any_changed, least);
    }
    let rays_before = rays_of(tally);
    let mut traced = 0;
    scratch.starts.clear();
    for first in (0..CELLS).step_by(LANES) {
        let surfaces = surface_bits(&tile.model[first..first + LANES]);
        for lane in set_bits(surfaces) {
            let cell = first + lane;
            // paths that start on a model that moves are invalid even where nothing touches them
            let moved = frame.moved(tile.model[cell]);
            if !moved && !frame.has_expired(tile.gathered.mean(cell).until) {
                continue;
            }
            if !frame.palette.is_diffuse(tile.record[cell].material) {
                any_changed |= tile.gathered.mean(cell).until == Until::UNKNOWN;
                tile.gathered.set_dark(cell);
                tile.record[cell].flags = tile.record[cell].flags.with(Flags::STALE);
                continue;
            }
            let placed = placed.get(frame, tile, first);
            let list = &tile.gathered.paths;
            let wanted = list.known(cell).count().max(frame.first_paths) as u32;
            let holds = |path: KeptPath| !moved && !frame.has_expired(path.until);
            let expired = (0..wanted).filter(|index| !list.path(cell, *index as usize).is_some_and(holds));
            let start = start_at(frame, tile, cell, &placed, frame.paths);
            scratch.starts.gather(&start, below(frame, tile, cell), expired);
            if scratch.starts.len() >= AT_ONCE {
                traced += scratch.starts.len() as u64;
                any_changed |= renew(frame, tile, scratch, tally);
            }
        }
    }
    traced += scratch.starts.len() as u64;
    any_changed |= renew(frame, tile, scratch, tally);
    if frame.first_paths < frame.paths {
        let spent = Spent { paths: traced, rays: rays_of(tally) - rays_before };
        let (more, is_complete) = fill_in(frame, tile, placed, scratch, tally, spent);
        any_changed |= more;
        if !is_complete {
            least = Until::UNKNOWN;
        }
    }
    for first in (0..CELLS).step_by(LANES) {
        for lane in set_bits(surface_bits(&tile.model[first..first + LANES])) {
            least = least.min(tile.gathered.mean(first + lane).until);
        }
    }
    (any_changed, least)
}

/// Cost of a tile so far.
#[derive(Debug, Clone, Copy)]
struct Spent {
    paths: u64,
    rays: u64,
}

impl Spent {
    /// Number of paths that may still be traced for these `samples` samples of the tile, by their share of
    /// the frame's budget.
    fn paths_left(self, frame: &FrameView, samples: usize) -> u64 {
        match frame.settings.budget {
            Budget::None => 0,
            Budget::Full => ((samples * frame.first_paths) as u64).saturating_sub(self.paths),
            Budget::Rays(rays) => {
                let share = (u128::from(rays) * samples as u128
                    / u128::from(frame.settings.samples_a_frame())) as u64;
                let left = share.saturating_sub(self.rays);
                // mean cost of a path; a guess before any was traced
                let (rays, paths) = if self.paths == 0 {
                    (2 * frame.settings.bounces as u64 + 1, 1)
                } else {
                    (self.rays, self.paths)
                };
                left * paths / rays.max(1)
            }
        }
    }
}

/// Number of rays of paths, shadow rays from them included.
fn rays_of(tally: &RayTally) -> u64 {
    tally.counts.gathering + tally.counts.shadow
}

/// Traces more paths for those samples of `tile` that have fewest, as far as the budget goes. Returns true if
/// any light changes, and true if all samples have all of their paths.
fn fill_in(
    frame: &FrameView,
    tile: &mut Tile,
    placed: &mut PlacedTile,
    scratch: &mut PathScratch,
    tally: &mut RayTally,
    mut spent: Spent,
) -> (bool, bool) {
    let samples: Vec<(usize, usize)> = (0..CELLS)
        .step_by(LANES)
        .flat_map(|first| {
            set_bits(surface_bits(&tile.model[first..first + LANES])).map(move |lane| first + lane)
        })
        .map(|cell| (cell, tile.gathered.paths.known(cell).count()))
        .collect();
    let mut any_changed = false;
    let fewest = samples.iter().map(|(_, known)| *known).min().unwrap_or(frame.paths);
    for index in fewest..frame.paths {
        for (cell, known) in &samples {
            if *known > index {
                continue;
            }
            if spent.paths_left(frame, samples.len()) <= scratch.starts.len() as u64 {
                any_changed |= renew(frame, tile, scratch, tally);
                return (any_changed, false);
            }
            let placed = placed.get(frame, tile, cell - cell % LANES);
            let start = start_at(frame, tile, *cell, &placed, frame.paths);
            let number = std::iter::once(index as u32);
            scratch.starts.gather(&start, below(frame, tile, *cell), number);
            if scratch.starts.len() == AT_ONCE {
                let before = rays_of(tally);
                spent.paths += scratch.starts.len() as u64;
                any_changed |= renew(frame, tile, scratch, tally);
                spent.rays += rays_of(tally) - before;
            }
        }
    }
    any_changed |= renew(frame, tile, scratch, tally);
    (any_changed, true)
}

/// Start of the first of `paths` paths of the sample in `cell`; `placed` holds its group of eight cells.
pub fn start_at(frame: &FrameView, tile: &Tile, cell: usize, placed: &Placed, paths: usize) -> PathStart {
    let (lane, model) = (cell % LANES, tile.model[cell]);
    let normal = placed.normal.lane(lane);
    PathStart {
        owner: cell as u32,
        cell: cell as u32,
        model,
        index: 0,
        sequence: PathSequence::of_sample(tile.gathered.seed(cell), paths),
        point: placed.point.lane(lane),
        normal,
        tangent: tangent(frame, model, &tile.record[cell], normal),
        geometric_normal: placed.geometric_normal.lane(lane),
        horizon: horizon(frame, tile, cell, placed),
        of_surface: NOTHING,
        within: Within::NOTHING,
    }
}

/// What is below the surface of a sample, if light goes there.
pub fn below(frame: &FrameView, tile: &Tile, cell: usize) -> Option<Below> {
    if !frame.palette.scatters_below {
        return None;
    }
    let look = tile.look(cell);
    let reflectance = Vec3::from(tile.record[cell].reflectance.map(f32::from));
    let seen = (tile.model[cell], tile.record[cell].is_from_behind());
    Below::of(frame, seen, look, frame.palette.albedo_of(look, reflectance))
}

/// Tangent at a sample (world space), at right angles to `normal`. It turns with the model, or with the
/// triangle where the model deforms: it is the tangent of the normal in object space, transformed.
fn tangent(frame: &FrameView, model: u32, record: &Record, normal: Vec3) -> Vec3 {
    let [tangent, _] = orthonormal(record.normal.unfold());
    let turned = frame.place(model, record.traced.tick()).direction(record.triangle, tangent);
    let across = turned - normal * normal.dot(turned);
    across.try_normalize().unwrap_or_else(|| orthonormal(normal)[0])
}

/// Traces the paths in `scratch`, stores their results in the tile, and clears `scratch`. Returns true if any
/// light changes.
fn renew(frame: &FrameView, tile: &mut Tile, scratch: &mut PathScratch, tally: &mut RayTally) -> bool {
    trace_paths(frame, scratch, tally);
    for (start, brought) in scratch.starts.iter().zip(&scratch.brought) {
        tile.gathered.paths.set(start.owner as usize, start.index as usize, kept(brought));
    }
    let mut any = false;
    for same in scratch.starts.chunk_by(|a, b| a.owner == b.owner) {
        let cell = same[0].owner as usize;
        // what a catcher covers depends on each path, and on how many there are
        let is_catcher = frame.role(tile.model[cell]) == Role::ShadowCatcher;
        if tile.gathered.update_mean(cell) | is_catcher {
            any = true;
            tile.record[cell].flags = tile.record[cell].flags.with(Flags::STALE);
        }
    }
    scratch.starts.clear();
    any
}

/// Stored form of the result of a path.
pub fn kept(brought: &PathResult) -> KeptPath {
    let radiance = if brought.radiance.is_finite() { brought.radiance } else { Vec3::ZERO };
    KeptPath { light: PathColor::new(radiance, brought.sees_light), until: brought.until }
}
