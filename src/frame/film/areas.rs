//! Areas of samples: the part of the picture that each stands for.
//!
//! Across and down by itself, a sample stands for what is nearer to it than to the samples of the cells beside it: Voronoi's division of
//! a line. Areas of samples in rows cover the picture once, wherever the rows lie and however far they are
//! apart; where samples lie in the centres of their cells, areas are the cells.
//!
//! If a pixel's edge cuts an area, the part within the pixel lies to one side of the sample. To give it the sample's colour would blur the
//! picture, the more the farther samples lie from the centres of their cells: frames that reuse samples would be less sharp than those that
//! are traced in full. So within an area the picture is taken to rise or fall evenly, by the slope between the samples beside it: a
//! part weighs for these two as well, for one of them more and for the other one less (van Leer 1979, without a limit: weights must not depend
//! on colours). Nothing slopes at [rims](super::rims), where another surface begins, nor where samples lie at their targets.

use super::rims::{AT_TARGET, Rims};
use crate::frame::grid::{Grid, cell_number, place};
use crate::lanes::{F32x8, LANES, Mask};
use crate::samples::{CELLS, Column, EMPTY, TILE, Tile};

/// Half of a cell: how far an area reaches where the next cell holds no sample, or is one of another tile.
const USUAL: f32 = 0.5;

/// Least that an area reaches to any side, in cells. Samples may lie in their neighbours' cells, and beyond their
/// neighbours' samples.
const LEAST: f32 = 0.05;

/// Least distance in cells, of samples two cells apart, over which their difference is divided. Where they happen to lie closer together
/// their colours differ by what they differ down or across as well.
const LEAST_RUN: f32 = 1.0;

/// How much steeper areas slope than their neighbours say. Any value leaves what rises evenly as it is. With 1 what is curved gently is as in
/// frames that are traced in full, and what is as fine as samples is less sharp; with this much, textures of all kinds are as sharp, about.
const STEEPER: f32 = 1.3;

/// Number of no cell.
const NONE: u16 = CELLS as u16;

/// Number of pixels in a row that a sample reaches, where areas slope: the parts of the areas beside it lie up to a cell and a half from it.
pub const SLOPED_TAPS: usize = 4;

/// The cells next to each cell of a tile: to the left and to the right, above and below.
type Neighbours = [[Column<u16>; 2]; 2];

/// Areas of a tile's samples.
#[derive(Debug)]
pub struct Areas {
    neighbours: Box<Neighbours>,
    /// How far the area of each cell's sample reaches from it, in cells: to the left and to the right, up and down.
    sides: [[Column<f32>; 2]; 2],
    /// Weights of each cell's sample in the pixels around it, across and down, where areas slope.
    weights: Box<[[Column<f32>; SLOPED_TAPS]; 2]>,
}

impl Default for Areas {
    fn default() -> Self {
        let next = |cell: usize, axis: usize, forwards: bool| {
            let mut at = place(cell);
            at[axis] = if forwards { at[axis] + 1 } else { at[axis].wrapping_sub(1) };
            if at[axis] < TILE as u32 { cell_number(at) as u16 } else { NONE }
        };
        let neighbours =
            |axis| [false, true].map(|forwards| std::array::from_fn(|cell| next(cell, axis, forwards)));
        Self {
            neighbours: Box::new([0, 1].map(neighbours)),
            sides: [[[USUAL; CELLS]; 2]; 2],
            weights: Box::new([[[0.0; CELLS]; SLOPED_TAPS]; 2]),
        }
    }
}

/// A row or a column of a tile, with room for eight at once before it and after it. What is beyond the tile is no number.
#[derive(Debug, Clone, Copy)]
struct Line([f32; Self::LENGTH]);

impl Line {
    const LENGTH: usize = TILE + 2 * LANES;
    const UNKNOWN: Self = Self([f32::NAN; Self::LENGTH]);
    const ZERO: Self = Self([0.0; Self::LENGTH]);

    /// Eight values from number `at` on, `beyond` (-1, 0 or 1) those.
    #[inline(always)]
    fn eight(&self, at: usize, beyond: isize) -> F32x8 {
        F32x8::load(&self.0, at.wrapping_add_signed(LANES as isize + beyond))
    }

    #[inline(always)]
    fn put(&mut self, at: usize, values: F32x8) {
        values.store(&mut self.0, at + LANES);
    }
}

impl Areas {
    /// Finds the areas of the samples of `tile`, whose `places` are x and y, in cells.
    pub fn find(&mut self, tile: &Tile, places: [&Column<f32>; 2]) {
        for ((sides, neighbours), place) in self.sides.iter_mut().zip(&*self.neighbours).zip(places) {
            // what is next to no sample is no number
            let mut places = [f32::NAN; CELLS + 1];
            for first in (0..CELLS).step_by(LANES) {
                let is_empty = Mask::equal(&tile.model[first..first + LANES], EMPTY);
                is_empty.select(F32x8::splat(f32::NAN), F32x8::load(place, first)).store(&mut places, first);
            }
            let [before, after] = sides;
            for ((side, place), next) in after.iter_mut().zip(places).zip(&neighbours[1]) {
                let half = (places[usize::from(*next)] - place) * 0.5;
                *side = if half.is_nan() { USUAL } else { half.max(LEAST) };
            }
            for (side, previous) in before.iter_mut().zip(&neighbours[0]) {
                *side = after.get(usize::from(*previous)).copied().unwrap_or(USUAL);
            }
        }
    }

    /// Returns how far the areas of eight samples reach to the left and to the right, up and down, in cells.
    #[inline(always)]
    pub fn sides(&self, first: usize) -> [[F32x8; 2]; 2] {
        self.sides.each_ref().map(|sides| sides.each_ref().map(|side| F32x8::load(side, first)))
    }

    /// Finds the weights of the samples of `tile`, some of which lie beside their targets, in these `places`: of those at `rims` the
    /// places where they count are others.
    pub fn find_sloped(&mut self, grid: &Grid, tile: &Tile, places: [&Column<f32>; 2], rims: &Rims) {
        let samples = grid.samples as f32;
        for (axis, weights) in self.weights.iter_mut().enumerate() {
            for line in 0..TILE {
                let cells: [usize; TILE] = std::array::from_fn(|number| {
                    let at = if axis == 0 { [number, line] } else { [line, number] };
                    cell_number(at.map(|at| at as u32))
                });
                let (mut shown, mut lies) = (Line::UNKNOWN, Line::UNKNOWN);
                let mut may_slope = [0.0; TILE];
                for (number, cell) in cells.into_iter().enumerate() {
                    if tile.model[cell] != EMPTY {
                        shown.0[LANES + number] = rims.places[axis][cell];
                        lies.0[LANES + number] = places[axis][cell];
                        let aside = (places[axis][cell] - number as f32 - 0.5).abs();
                        may_slope[number] = f32::from(u8::from(!rims.is_rim[cell] && aside > AT_TARGET));
                    }
                }
                for (at, of_eight) in weights_of_line(samples, [&shown, &lies], &may_slope) {
                    for (column, weights) in weights.iter_mut().zip(of_eight) {
                        for (cell, weight) in cells[at..at + LANES].iter().zip(weights.values()) {
                            column[*cell] = *weight;
                        }
                    }
                }
            }
        }
    }

    /// Areas of eight samples, across and down, in cells.
    #[inline(always)]
    pub fn extents(&self, first: usize) -> [F32x8; 2] {
        self.sides(first).map(|[before, after]| before + after)
    }

    /// Weights of eight samples in the pixels around them, across and down, where areas slope.
    #[inline(always)]
    pub fn sloped<const N: usize>(&self, first: usize) -> [[F32x8; N]; 2] {
        self.weights.each_ref().map(|weights| {
            std::array::from_fn(|pixel| weights.get(pixel).map_or(F32x8::ZERO, |of| F32x8::load(of, first)))
        })
    }
}

/// Number of the pixel, shifted by two, from which on samples in these places (in cells of which a pixel has `samples`) weigh in
/// [`SLOPED_TAPS`] pixels.
#[inline(always)]
pub fn first_pixel(places: F32x8, cell: F32x8) -> F32x8 {
    F32x8::from_whole((places * cell + F32x8::splat(0.5)).to_whole())
}

/// Weights of the samples of a row or a column in the pixels around them, in pixels, eight by eight. `samples`: cells of a pixel's edge;
/// where samples are `shown`, where each `lies`, and 1 for those between whose neighbours the picture may slope.
#[inline(always)]
fn weights_of_line(
    samples: f32,
    [shown, lies]: [&Line; 2],
    may_slope: &[f32; TILE],
) -> impl Iterator<Item = (usize, [F32x8; SLOPED_TAPS])> {
    let [usual, least, half, zero] = [USUAL, LEAST, 0.5, 0.0].map(F32x8::splat);
    let known = |value: F32x8, other: F32x8| value.abs().lt(F32x8::splat(f32::MAX)).select(value, other);
    // how far areas reach to the next sample; and how much of a difference to the next sample and to the one before is the slope
    let [mut after, mut to_next, mut to_last] = [Line([USUAL; Line::LENGTH]), Line::ZERO, Line::ZERO];
    for at in (0..TILE).step_by(LANES) {
        let side = (shown.eight(at, 1) - shown.eight(at, 0)) * half;
        after.put(at, known(side, usual).max(least));
        let [last, here, next] = [-1, 0, 1].map(|beyond| lies.eight(at, beyond));
        let least_run = F32x8::splat(LEAST_RUN);
        let over = |run: F32x8, least: F32x8| F32x8::ONE / known(run, zero).max(least);
        let is_known = |place: F32x8| place.abs().lt(F32x8::splat(f32::MAX));
        let (has_last, has_next) = (is_known(last), is_known(next));
        let may = F32x8::load(may_slope, at) * F32x8::splat(STEEPER);
        // at the tile's border from one side
        let by_both = over(next - last, least_run);
        let by_next = over(next - here, least_run * half);
        let by_last = over(here - last, least_run * half);
        to_next.put(at, may * has_next.select(has_last.select(by_both, by_next), zero));
        to_last.put(at, may * has_last.select(has_next.select(by_both, by_last), zero));
    }
    let (shown, cell) = (*shown, F32x8::splat(samples.recip()));
    (0..TILE).step_by(LANES).map(move |at| {
        let pixel = first_pixel(known(shown.eight(at, 0), zero), cell) - F32x8::splat(2.0);
        let mut weights = [zero; SLOPED_TAPS];
        for beyond in [-1, 0, 1] {
            let place = shown.eight(at, beyond);
            let (start, end) = (place - after.eight(at, beyond - 1), place + after.eight(at, beyond));
            let share = match beyond {
                -1 => to_next.eight(at, beyond),
                0 => to_last.eight(at, 0) - to_next.eight(at, 0),
                _ => zero - to_last.eight(at, beyond),
            };
            for (number, weight) in weights.iter_mut().enumerate() {
                let left = (pixel + F32x8::splat(number as f32)) * F32x8::splat(samples);
                let (from, to) = (start.max(left), end.min(left + F32x8::splat(samples)));
                let width = (to - from).max(zero);
                let aside = (from + to) * half - place;
                let sloped = width * aside * share;
                let part = if beyond == 0 { width + sloped } else { sloped };
                // beyond the tile there is nothing
                *weight = *weight + known(part, zero) * cell;
            }
        }
        (at, weights)
    })
}

/// What of the areas of samples lies in each of the `N` pixels of a row around them: their weights there. The samples lie
/// `beyond` (0 to 1) the centre of pixel N/2 - 1 of these; areas reach to both `sides`, in pixels, and half a pixel at most, so that
/// two pixels are enough.
#[inline(always)]
pub fn in_pixels<const N: usize>(beyond: F32x8, sides: [F32x8; 2]) -> [F32x8; N] {
    let half = F32x8::splat(0.5);
    let [before, after] = sides.map(|side| side.min(half));
    let [start, end] = [beyond - before, beyond + after];
    std::array::from_fn(|pixel| {
        let center = F32x8::splat(pixel as f32 - (N / 2 - 1) as f32);
        (end.min(center + half) - start.max(center - half)).max(F32x8::ZERO)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::TagLayout;

    /// Samples of a tile, each `beside` the centre of its cell.
    fn areas_of(beside: impl Fn([u32; 2]) -> [f32; 2], is_there: impl Fn([u32; 2]) -> bool) -> Areas {
        let mut tile = Tile::empty(&TagLayout::new(std::iter::empty()));
        let (mut x, mut y) = ([0.0; CELLS], [0.0; CELLS]);
        for cell in (0..CELLS).filter(|cell| is_there(place(*cell))) {
            let at = place(cell);
            tile.model[cell] = 0;
            x[cell] = at[0] as f32 + 0.5 + beside(at)[0];
            y[cell] = at[1] as f32 + 0.5 + beside(at)[1];
        }
        let mut areas = Areas::default();
        areas.find(&tile, [&x, &y]);
        areas
    }

    fn sides(areas: &Areas, at: [u32; 2]) -> [[f32; 2]; 2] {
        areas.sides.each_ref().map(|sides| sides.each_ref().map(|side| side[cell_number(at)]))
    }

    /// Rows of samples, wherever they lie and however far they are apart: areas fill the pixel, and the mean of what rises evenly
    /// is nearly its value in the pixel's centre. In the centres of cells samples weigh as with a box.
    #[test]
    fn areas_of_rows_fill_each_pixel_once() {
        for (samples, apart, shift) in [1.0, 2.0, 3.0, 4.0, 16.0_f32]
            .into_iter()
            .flat_map(|samples| [1.0, 0.9, 1.2_f32].map(|apart| (samples, apart)))
            .flat_map(|(samples, apart)| (0..=16).map(move |step| (samples, apart, step as f32 / 16.0 - 0.5)))
            // beyond half a pixel no area reaches
            .filter(|(samples, apart, _)| *samples > 1.0 || *apart <= 1.0)
        {
            let (cell, cells) = (apart / samples, 3 * samples as i32);
            let (mut sum, mut moment) = (0.0, 0.0);
            for number in -cells..cells {
                // from the pixel's left edge; pixels of the row begin half a pixel before the first centre
                let at = (number as f32 + 0.5 + shift) * cell;
                let left_centre = (at - 0.5).floor();
                let [beyond, side] = [at - 0.5 - left_centre, 0.5 * cell].map(F32x8::splat);
                let of_row = in_pixels::<2>(beyond, [side; 2]).map(|weight| weight.lane(3));
                let ours = -left_centre as i32;
                let weight = usize::try_from(ours).ok().and_then(|pixel| of_row.get(pixel)).unwrap_or(&0.0);
                sum += weight;
                moment += weight * (at - 0.5);
                let own = if (0.0..1.0).contains(&at) { cell } else { 0.0 };
                assert!(shift != 0.0 || apart != 1.0 || (*weight - own).abs() < 1e-5, "{samples}: {at}");
            }
            assert!((sum - 1.0).abs() < 1e-4, "{samples}, {apart}, {shift}: {sum}");
            // the areas that edges of the pixel cut are off by no more than a quarter of themselves, each by its share
            let most = if apart == 1.0 { 1e-4 } else { 0.25 * cell * cell };
            assert!(moment.abs() < most, "{samples}, {apart}, {shift}: {moment}");
        }
    }

    #[test]
    fn areas_of_rows_are_cells_wherever_the_rows_lie() {
        let areas = areas_of(|_| [0.4, -0.3], |_| true);
        for at in [[0, 0], [5, 9], [31, 31], [3, 4], [4, 3]] {
            for side in sides(&areas, at).as_flattened() {
                assert!((side - 0.5).abs() < 1e-5, "{at:?}: {side}");
            }
        }
    }

    #[test]
    fn an_area_ends_halfway_to_the_next_samples() {
        // one sample to the right and down, beside one that is missing
        let beside = |at| if at == [8, 12] { [0.4, 0.2] } else { [0.0; 2] };
        let areas = areas_of(beside, |at| at != [8, 11]);
        let wanted = [[0.7, 0.3], [USUAL, 0.4]];
        for (side, wanted) in sides(&areas, [8, 12]).as_flattened().iter().zip(wanted.as_flattened()) {
            assert!((side - wanted).abs() < 1e-5, "{side}, not {wanted}");
        }
        assert!((sides(&areas, [9, 12])[0][0] - 0.3).abs() < 1e-5);
        assert!((sides(&areas, [7, 12])[0][1] - 0.7).abs() < 1e-5);
        assert!((sides(&areas, [8, 13])[1][0] - 0.4).abs() < 1e-5);
    }

    #[test]
    fn samples_in_each_others_cells_stand_for_something() {
        let beside = |at: [u32; 2]| match at {
            [8, 12] => [0.7, 0.0],
            [9, 12] => [-0.7, 0.0],
            _ => [0.0; 2],
        };
        let areas = areas_of(beside, |_| true);
        for at in [[8, 12], [9, 12]] {
            let [[left, right], _] = sides(&areas, at);
            assert!(left >= LEAST && right >= LEAST && left + right > 0.5, "{left}, {right}");
        }
    }

    /// Weights of a row of samples in each pixel of a tile, for `samples` of a pixel along its edge: sums, and first and second moments about the
    /// pixel's centre, in pixels.
    fn moments(samples: u32, shift: f32, may_slope: bool) -> Vec<[f32; 3]> {
        let mut line = Line::UNKNOWN;
        let place = |number: usize| number as f32 + 0.5 + shift;
        (0..TILE).for_each(|number| line.0[LANES + number] = place(number));
        let cell = (samples as f32).recip();
        let mut pixels = vec![[0.0; 3]; TILE / samples as usize];
        for (at, weights) in
            weights_of_line(samples as f32, [&line; 2], &[f32::from(u8::from(may_slope)); TILE])
        {
            let places = F32x8::load(&line.0, at + LANES);
            let first = first_pixel(places, F32x8::splat(cell));
            for lane in 0..LANES {
                for (number, weight) in weights.iter().enumerate() {
                    let pixel = first.lane(lane) as isize - 2 + number as isize;
                    let Some(sums) = usize::try_from(pixel).ok().and_then(|pixel| pixels.get_mut(pixel))
                    else {
                        continue;
                    };
                    let at = places.lane(lane) * cell - pixel as f32 - 0.5;
                    (0..3).zip(sums).for_each(|(power, sum)| *sum += weight.lane(lane) * at.powi(power));
                }
            }
        }
        pixels
    }

    /// What rises evenly has in each pixel the value of its centre; what is curved gently is as curved as in frames that are traced in
    /// full, but for the excess of slopes.
    #[test]
    fn slopes_are_as_sharp_as_frames_that_are_traced_in_full() {
        for samples in [2, 4] {
            let cell = (samples as f32).recip();
            let in_full = (1.0 - cell * cell) / 12.0;
            for shift in [-0.5, -0.3, 0.1, 0.25, 0.5] {
                let [flat, sloped] = [false, true].map(|may_slope| moments(samples, shift, may_slope));
                // not at the tile's border, where pixels are made of several tiles
                for (flat, sloped) in flat.iter().zip(&sloped).skip(2).take(TILE / samples as usize - 4) {
                    assert!(
                        (sloped[0] - 1.0).abs() < 1e-5 && (flat[0] - 1.0).abs() < 1e-5,
                        "{flat:?} {sloped:?}"
                    );
                    assert!(sloped[1].abs() < 1e-5, "{samples}, {shift}: {sloped:?}");
                    // what is curved gently would be as in full without the excess
                    let off = |moments: &[f32; 3]| moments[2] - in_full;
                    let wanted = (1.0 - STEEPER) * off(flat);
                    assert!((off(sloped) - wanted).abs() < 1e-5, "{samples}, {shift}: {flat:?} {sloped:?}");
                }
            }
        }
    }

    #[test]
    fn a_line_may_have_gaps() {
        let mut line = Line::UNKNOWN;
        (0..TILE)
            .filter(|number| number % 5 != 3)
            .for_each(|number| line.0[LANES + number] = number as f32 + 0.8);
        for (_, weights) in weights_of_line(2.0, [&line; 2], &[1.0; TILE]) {
            assert!(
                weights
                    .iter()
                    .flat_map(|of| of.values())
                    .all(|weight| weight.is_finite() && weight.abs() < 3.0)
            );
        }
    }
}
