//! Rims: cells beside which another surface is shown, and those beside these. A sample of a rim counts in the place of its target.
//!
//! A cell shows a sample of the surface that its [target](crate::frame::reuse::target) sees. So where a silhouette lies is said by
//! targets, and to within a cell: beyond the border between the cells of two surfaces. Samples say less. Of a thing that moves before
//! another one those of what is behind are hidden as soon as it reaches them, and its own lie within it: the samples beside a silhouette lie off it,
//! to either side, and by how much depends on where things move. What is filtered by their true places has silhouettes of its own. With the
//! places of targets on both sides of it, two cells wide, a silhouette is where frames have it that are traced in full, and looks as it does there: what lies
//! next to it is as dense on either side.

use crate::exposure::MIDDLE_TICK;
use crate::frame::grid::{cell_number, place};
use crate::frame::reuse::target::{ABOUT_PARALLEL, LAYER, Seen};
use crate::frame::reuse::trace_missed::through_targets;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::trace_scratch::TraceScratch;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::samples::{CELLS, Column, EMPTY, TILE, Tile};
use crate::trace::{self, Coherence, Hit, NO_HIT, Search};

/// Distance from the target, across or down in cells, up to which a sample counts as if it lay there: more than rounding puts between a
/// sample that was traced and the target of its cell.
pub const AT_TARGET: f32 = 1.0 / 64.0;

/// Cells of a row, with room beyond the last one for eight at once.
const ROW: usize = TILE + LANES;

/// Number of cells in rows, with a row below the last one.
const ROWS: usize = (TILE + 1) * ROW;

/// What the samples of a tile show, in rows: [`EMPTY`] beyond the tile.
#[derive(Debug)]
struct Shown {
    model: [u32; ROWS],
    /// Material, and the side.
    side: [u32; ROWS],
    /// From the eye, world space.
    offset: [[f32; ROWS]; 3],
    /// Geometric normals, world space, unit length.
    normal: [[f32; ROWS]; 3],
    /// Thickness of the layer, to either side: world units.
    layer: [f32; ROWS],
}

/// Rims of a tile, and where its samples count.
#[derive(Debug)]
pub struct Rims {
    /// x and y of the places where samples count, in cells from the tile's corner.
    pub places: [Column<f32>; 2],
    /// True for each cell of a rim.
    pub is_rim: [bool; CELLS],
    shown: Box<Shown>,
    /// Cells of the outermost ring that ask what is beside the tile, and what they ask: a column and a row beside the tile's.
    asked: Vec<(usize, [i32; 2])>,
}

impl Default for Rims {
    fn default() -> Self {
        let none = [0.0; ROWS];
        let shown = Shown {
            model: [EMPTY; ROWS],
            side: [0; ROWS],
            offset: [none; 3],
            normal: [none; 3],
            layer: none,
        };
        Self { places: [[0.0; CELLS]; 2], is_rim: [false; CELLS], shown: Box::new(shown), asked: Vec::new() }
    }
}

impl Rims {
    /// Finds where the samples of tile number `number`, which lie in these `places`, count. Returns false if all lie at their
    /// targets, where they count in any case.
    ///
    /// What the cells beside the tile show is for other workers to find: here their targets are asked for it, with a ray each.
    pub fn find(
        &mut self,
        frame: &FrameView,
        number: usize,
        tile: &Tile,
        places: [&Column<f32>; 2],
        scratch: &mut TraceScratch,
    ) -> bool {
        self.asked.clear();
        let off = |first: usize| off_target(frame, tile, places, first);
        if (0..CELLS).step_by(LANES).all(|first| off(first) == 0) {
            return false;
        }
        self.shown.fill(frame, tile);
        self.is_rim.fill(false);
        for row in 0..TILE {
            for column in (0..TILE).step_by(LANES) {
                let at = row * ROW + column;
                for (next, [x, y]) in [(at + 1, [1, 0]), (at + ROW, [0, 1])] {
                    let mut others = self.shown.are_others(at, next);
                    while others != 0 {
                        let lane = others.trailing_zeros() as usize;
                        others &= others - 1;
                        self.is_rim[cell_at([column + lane, row])] = true;
                        self.is_rim[cell_at([column + lane + x, row + y])] = true;
                    }
                }
            }
        }
        self.ask_beside(frame, number, tile, off, scratch);
        self.widen();
        for (places, (of, target)) in self
            .places
            .iter_mut()
            .zip(places.into_iter().zip([&frame.view.grid.place_x, &frame.view.grid.place_y]))
        {
            places.copy_from_slice(of);
            for first in (0..CELLS).step_by(LANES) {
                let rim = Mask::new(|lane| self.is_rim[first + lane]) & Mask::from_bits(off(first));
                if rim.any() {
                    let target = F32x8::load(target, first) + F32x8::splat(0.5);
                    rim.select(target, F32x8::load(of, first)).store(places, first);
                }
            }
        }
        true
    }

    /// Adds the cells beside those of rims.
    fn widen(&mut self) {
        const LAST: usize = TILE - 1;
        let narrow = self.is_rim;
        for (x, y) in (0..TILE).flat_map(|y| (0..TILE).map(move |x| (x, y))) {
            if narrow[cell_at([x, y])] {
                for beside in [
                    [x.saturating_sub(1), y],
                    [LAST.min(x + 1), y],
                    [x, y.saturating_sub(1)],
                    [x, LAST.min(y + 1)],
                ] {
                    self.is_rim[cell_at(beside)] = true;
                }
            }
        }
    }

    /// Asks the targets of the cells beside the tile what they see, where it is not known already that a cell of the outermost
    /// ring is of a rim.
    fn ask_beside(
        &mut self,
        frame: &FrameView,
        number: usize,
        tile: &Tile,
        off: impl Fn(usize) -> u8,
        scratch: &mut TraceScratch,
    ) {
        const LAST: usize = TILE - 1;
        let Self { is_rim, asked, .. } = self;
        let end = TILE as i32;
        for along in 0..TILE {
            let at = along as i32;
            let sides = [
                ([along, 0], [at, -1]),
                ([along, LAST], [at, end]),
                ([0, along], [-1, at]),
                ([LAST, along], [end, at]),
            ];
            asked.extend(sides.into_iter().map(|(at, beside)| (cell_at(at), beside)).filter(|(cell, _)| {
                let is_off = off(cell / LANES * LANES) >> (cell % LANES) & 1 != 0;
                is_off && !is_rim[*cell]
            }));
        }
        if asked.is_empty() {
            return;
        }
        let TraceScratch { rays, hits, tally, .. } = scratch;
        rays.clear();
        for asked in asked.chunks(LANES) {
            let of = |axis: usize| {
                let mut all = F32x8::ZERO;
                asked.iter().enumerate().for_each(|(lane, (_, beside))| {
                    all.set_lane(lane, beside[axis] as f32);
                });
                all
            };
            let [origins, directions] = through_targets(frame, number, [of(0), of(1)]);
            let far = F32x8::splat(f32::INFINITY);
            rays.push_lanes(origins, directions, far, u8::MAX >> (LANES - asked.len()));
        }
        if frame.pose.has_ticks() {
            rays.set_ticks(asked.iter().map(|(_, beside)| frame.view.tick_beside(number, *beside)));
        }
        frame.tracer.closest(rays, Search::from_eye(frame.in_sight(number), Coherence::Coherent), hits);
        tally.counts.primary += asked.len() as u64;
        let answers = rays.packets().zip(&hits.packets).zip(asked.chunks(trace::LANES));
        for (((rays, _), hits), asked) in answers {
            for (lane, (cell, beside)) in asked.iter().enumerate() {
                tally.cells.primary[*cell] += 1;
                let of = |all: &[[f32; trace::LANES]; 3]| {
                    glam::Vec3::from_array(all.each_ref().map(|axis| axis[lane]))
                };
                let (model, triangle) = (hits.model[lane], hits.triangle[lane]);
                let hit = (model != NO_HIT).then(|| Hit {
                    t: hits.t[lane],
                    u: hits.u[lane],
                    v: hits.v[lane],
                    model,
                    triangle,
                });
                let tick = frame.view.tick_beside(number, *beside);
                let seen = Seen::new(frame, [of(&rays.origin), of(&rays.direction)], tick, hit);
                is_rim[*cell] |= !seen.is_shown_by(frame, &tile.sample(*cell));
            }
        }
    }

    /// Returns true if the last [`find`](Self::find) asked what is beside the tile.
    pub fn has_asked(&self) -> bool {
        !self.asked.is_empty()
    }
}

/// Number of a tile's cell in this column and row.
#[inline(always)]
fn cell_at([x, y]: [usize; 2]) -> usize {
    cell_number([x as u32, y as u32])
}

/// Bit mask of those of eight samples that lie beside their targets.
#[inline(always)]
fn off_target(frame: &FrameView, tile: &Tile, places: [&Column<f32>; 2], first: usize) -> u8 {
    let grid = &frame.view.grid;
    let is_off = |place: &Column<f32>, cells: &Column<f32>| {
        let off = F32x8::load(place, first) - F32x8::load(cells, first) - F32x8::splat(0.5);
        off.abs().gt(F32x8::splat(AT_TARGET))
    };
    let is_off = is_off(places[0], &grid.place_x) | is_off(places[1], &grid.place_y);
    (is_off & !Mask::equal(&tile.model[first..first + LANES], EMPTY)).bits()
}

impl Shown {
    /// Writes what the samples of `tile` show, in rows.
    fn fill(&mut self, frame: &FrameView, tile: &Tile) {
        const HALF: usize = LANES / 2;
        let spread = frame.view.spread();
        let [by_distance, fixed] = [spread.by_distance, spread.fixed].map(|of| F32x8::splat(LAYER * of));
        for first in (0..CELLS).step_by(LANES) {
            let models = &tile.model[first..first + LANES];
            let records = &tile.record[first..first + LANES];
            // neighbours may be seen at other ticks: they are compared at one, from one place
            let ticks = || [MIDDLE_TICK; LANES];
            let offsets = frame.offsets_from(Vec3x8::splat(frame.view.camera.eye), (tile, first), ticks);
            let normals = frame.geometric_normals((tile, first), ticks);
            let length = normals.dot(normals).sqrt();
            let is_surface = Mask::less(models, EMPTY);
            let has_normal = is_surface & length.gt(F32x8::ZERO);
            let normals = has_normal.select3(normals * (F32x8::ONE / length), Vec3x8::ZERO);
            let layer = offsets.dot(offsets).sqrt() * by_distance + fixed;
            // the background is one surface wherever it is seen
            let layer = is_surface.select(layer, F32x8::splat(f32::MAX));
            let offsets = is_surface.select3(offsets, Vec3x8::ZERO);
            let mut sides = [0; LANES];
            for (lane, side) in sides.iter_mut().enumerate().filter(|(lane, _)| models[*lane] < EMPTY) {
                let record = &records[lane];
                *side = u32::from(record.material) << 1 | u32::from(record.is_from_behind());
            }
            let [x, y] = place(first).map(|at| at as usize);
            for (half, at) in [(0, y * ROW + x), (HALF, (y + 1) * ROW + x)] {
                let own = half..half + HALF;
                self.model[at..at + HALF].copy_from_slice(&models[own.clone()]);
                self.side[at..at + HALF].copy_from_slice(&sides[own.clone()]);
                self.layer[at..at + HALF].copy_from_slice(&layer.values()[own.clone()]);
                for (to, from) in self
                    .offset
                    .iter_mut()
                    .chain(&mut self.normal)
                    .zip([offsets.x, offsets.y, offsets.z, normals.x, normals.y, normals.z])
                {
                    to[at..at + HALF].copy_from_slice(&from.values()[own.clone()]);
                }
            }
        }
    }

    /// Bit mask of those of eight samples from number `at` on that show another surface than those from number `next` on. Where there
    /// is no sample there is no other surface.
    #[inline(always)]
    fn are_others(&self, at: usize, next: usize) -> u8 {
        let Self { model, side, offset, normal, layer } = self;
        let is_some = Mask::new(|lane| model[at + lane] != EMPTY && model[next + lane] != EMPTY);
        let is_other =
            Mask::new(|lane| model[at + lane] != model[next + lane] || side[at + lane] != side[next + lane]);
        let load = |of: &[[f32; ROWS]; 3], at: usize| {
            let [x, y, z] = of.each_ref().map(|axis| F32x8::load(axis, at));
            Vec3x8 { x, y, z }
        };
        let between = load(offset, next) - load(offset, at);
        let normals = [at, next].map(|at| load(normal, at));
        let is_beyond = |normal: Vec3x8, at: usize| between.dot(normal).abs().gt(F32x8::load(layer, at));
        let is_beyond = is_beyond(normals[0], at) | is_beyond(normals[1], next);
        // what has no normal is the background, or a model of which the next sample is not
        let is_bent = normals[0].dot(normals[1]).lt(F32x8::splat(ABOUT_PARALLEL));
        let has_normals =
            normals[0].dot(normals[0]).gt(F32x8::ZERO) & normals[1].dot(normals[1]).gt(F32x8::ZERO);
        (is_some & (is_other | is_beyond | is_bent & has_normals)).bits()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plane z = 0 of model 0, seen from a distance of 10, with cells of 1 and layers of 0.25; `change` changes some samples.
    fn shown(change: impl Fn(&mut Shown, usize, [usize; 2])) -> Box<Shown> {
        let mut shown = Rims::default().shown;
        for [x, y] in (0..TILE).flat_map(|y| (0..TILE).map(move |x| [x, y])) {
            let at = y * ROW + x;
            shown.model[at] = 0;
            shown.layer[at] = LAYER;
            for (axis, value) in [x as f32, y as f32, -10.0].into_iter().enumerate() {
                shown.offset[axis][at] = value;
            }
            shown.normal[2][at] = 1.0;
            change(&mut shown, at, [x, y]);
        }
        shown
    }

    /// Bits of a row of eight from [4, 8] on that differ from their neighbours to the right, and from those below.
    fn others(shown: &Shown) -> [u8; 2] {
        let at = 8 * ROW + 4;
        [shown.are_others(at, at + 1), shown.are_others(at, at + ROW)]
    }

    #[test]
    fn a_surface_is_one_until_something_sets_its_parts_apart() {
        assert_eq!(others(&shown(|_, _, _| {})), [0, 0]);
        let from_six = |x: usize| x >= 6;
        assert_eq!(others(&shown(|all, at, [x, _]| all.model[at] = u32::from(from_six(x)))), [0b10, 0]);
        assert_eq!(others(&shown(|all, at, [x, _]| all.side[at] = u32::from(from_six(x)))), [0b10, 0]);
        let lies = |depth: f32| {
            others(&shown(|all, at, [x, y]| {
                all.offset[2][at] -= if from_six(x) && y > 8 { depth } else { 0.0 }
            }))
        };
        assert_eq!(lies(0.2), [0, 0], "within the layer");
        assert_eq!(lies(0.3), [0, 0b1111_1100]);
        // nothing is beside what is missing
        let gap = shown(|all, at, [x, _]| all.model[at] = if from_six(x) { EMPTY } else { 0 });
        assert_eq!(others(&gap), [0, 0]);
    }

    /// A slope is one layer, however far its parts are from each other: what counts is how far they are from its plane.
    #[test]
    fn slopes_are_no_rims_and_creases_are() {
        let slope = |from: usize| {
            others(&shown(|all, at, [x, _]| {
                let steep = if x >= from { 3.0 } else { 0.0 };
                all.offset[2][at] += steep * (x as f32 - from as f32).max(0.0);
                let normal = glam::Vec3::new(-steep, 0.0, 1.0).normalize();
                (all.normal[0][at], all.normal[2][at]) = (normal.x, normal.z);
            }))
        };
        assert_eq!(slope(0), [0, 0]);
        assert_eq!(slope(6), [0b10, 0]);
    }

    #[test]
    fn rows_end_with_the_tile() {
        let shown = shown(|_, _, _| {});
        for at in 0..TILE {
            let (right, below) = (at * ROW + TILE - LANES, (TILE - 1) * ROW + at / LANES * LANES);
            assert_eq!(shown.are_others(right, right + 1), 0);
            assert_eq!(shown.are_others(below, below + ROW), 0);
        }
    }
}
