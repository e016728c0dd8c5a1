//! Checks of light that samples keep: of paths and of ambient occlusion.

use std::ops::RangeInclusive;

use glam::Vec3;

use super::tolerances::{COLOR_TOLERANCE, DARKEST};
use super::verdict::Verdict;
use crate::frame::grid::bits::{set_bits, surface_bits};
use crate::frame::light::indirect::{self, below, start_at};
use crate::frame::light::light_paths::{PathScratch, trace_paths};
use crate::frame::light::occlusion::{OcclusionScratch, is_asked, look_around, look_from};
use crate::frame::light::reflected;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::placed::Placed;
use crate::frame::surface::ray_tally::RayTally;
use crate::lanes::LANES;
use crate::samples::{CELLS, Tile, mean_of};

/// Checks that samples have gathered the light that all of their paths bring when they are traced again,
/// against everything, that they are as many as they have to be, and that the stored mean is that of these paths. Paths are cast ray
/// by ray, each a function of its start alone: no tolerance but that of stored colours is needed.
pub fn check_gathered(frame: &FrameView, tile: &Tile, raise: &mut impl FnMut(usize, Verdict)) {
    if frame.paths == 0 {
        return;
    }
    let (mut scratch, mut tally) = (PathScratch::default(), RayTally::default());
    for first in (0..CELLS).step_by(LANES) {
        scratch.starts.clear();
        let placed = Placed::of(frame, tile, first);
        for lane in set_bits(surface_bits(&tile.model[first..first + LANES])) {
            let (cell, gathered) = (first + lane, &tile.gathered);
            let start = start_at(frame, tile, cell, &placed, frame.paths);
            let known = gathered.paths.known(cell).count();
            let is_diffuse = frame.palette.is_diffuse(tile.record[cell].material);
            raise(cell, Verdict::new(paths_demanded(frame, is_diffuse).contains(&known)));
            if is_diffuse {
                scratch.starts.gather(&start, below(frame, tile, cell), 0..known as u32);
            }
            let mean = mean_of(gathered.paths.known(cell));
            raise(cell, Verdict::new(mean.radiance == gathered.mean(cell).radiance));
        }
        trace_paths(frame, &mut scratch, &mut tally);
        for (start, brought) in scratch.starts.iter().zip(&scratch.brought) {
            let cell = start.owner as usize;
            let known = tile.gathered.paths.path(cell, start.index as usize);
            let known = known.map_or(Vec3::ZERO, |path| path.light.color());
            let fresh = indirect::kept(brought).light.color();
            let slack = COLOR_TOLERANCE * fresh.abs().max_element().max(DARKEST);
            raise(cell, Verdict::new((known - fresh).abs().max_element() <= slack));
        }
    }
}

/// How many paths a sample has to know after any frame. Without a budget it is given all of them at once, and so are those that bring
/// nothing to what is not diffuse. With one it has its first ones at least, in its first frame and ever after; how many more follows
/// from what its tile has had to trace in all frames since.
fn paths_demanded(frame: &FrameView, is_diffuse: bool) -> RangeInclusive<usize> {
    let least = if is_diffuse { frame.first_paths } else { frame.paths };
    least..=frame.paths
}

/// Checks that the paths by which samples reflect serve the eye, and that each brings the stored light when it is
/// traced again as it was drawn: equal to the bit.
pub fn check_reflected(frame: &FrameView, tile: &Tile, raise: &mut impl FnMut(usize, Verdict)) {
    if !tile.gathered.reflects() {
        return;
    }
    let (mut scratch, mut tally) = (PathScratch::default(), RayTally::default());
    for first in (0..CELLS).step_by(LANES) {
        scratch.starts.clear();
        let placed = Placed::of(frame, tile, first);
        let to_eye = reflected::directions_to_eye(frame, tile, first, &placed);
        for lane in set_bits(surface_bits(&tile.model[first..first + LANES])) {
            let cell = first + lane;
            let known = tile.gathered.reflected.known(cell).count();
            let Some((start, layer)) = reflected::start_at(frame, tile, cell, &placed) else {
                raise(cell, Verdict::new(known == 0));
                continue;
            };
            raise(cell, Verdict::new(known == layer.paths as usize));
            raise(
                cell,
                Verdict::new(known == 0 || reflected::serve(frame, tile, cell, &placed, to_eye.lane(lane))),
            );
            scratch.starts.reflect(&start, layer, 0..known as u32);
        }
        trace_paths(frame, &mut scratch, &mut tally);
        for (start, brought) in scratch.starts.iter().zip(&scratch.brought) {
            let kept = tile.gathered.reflected.path(start.owner as usize, start.index as usize);
            let holds = kept.is_some_and(|path| path.light == indirect::kept(brought).light);
            raise(start.owner as usize, Verdict::new(holds));
        }
    }
}

/// Checks that as many rays get away from samples as is stored, when all are cast again, against everything.
/// Each is cast for itself: no tolerance is needed.
pub fn check_openness(frame: &FrameView, tile: &Tile, raise: &mut impl FnMut(usize, Verdict)) {
    let Some(occlusion) = frame.occlusion else { return };
    let (mut scratch, mut tally) = (OcclusionScratch::default(), RayTally::default());
    for first in (0..CELLS).step_by(LANES) {
        scratch.looks.clear();
        let placed = Placed::of(frame, tile, first);
        let surfaces = set_bits(surface_bits(&tile.model[first..first + LANES]));
        for cell in surfaces.map(|lane| first + lane) {
            if is_asked(frame, tile.record[cell].material) {
                scratch.looks.push(look_from(frame, tile, cell, &placed, occlusion.rays));
            } else {
                raise(cell, Verdict::new(tile.gathered.openness(cell).open == 0));
            }
        }
        look_around(frame, &mut scratch, &mut tally);
        for (look, found) in scratch.looks.iter().zip(&scratch.found) {
            let cell = look.start.owner as usize;
            raise(cell, Verdict::new(tile.gathered.openness(cell).open == found.open));
        }
    }
}
