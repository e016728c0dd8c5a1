//! Areas of samples: the part of the picture that each stands for.
//!
//! Across and down by itself, a sample stands for what is nearer to it than to the samples of the cells beside it: Voronoi's division of
//! a line. Areas of samples in rows cover the picture once, wherever the rows lie and however far they are
//! apart; where samples lie in the centres of their cells, areas are the cells.

use crate::frame::grid::{cell_number, place};
use crate::lanes::{F32x8, LANES, Mask};
use crate::samples::{CELLS, Column, EMPTY, TILE, Tile};

/// Half of a cell: how far an area reaches where the next cell holds no sample, or is one of another tile.
const USUAL: f32 = 0.5;

/// Least that an area reaches to any side, in cells. Samples may lie in their neighbours' cells, and beyond their
/// neighbours' samples.
const LEAST: f32 = 0.05;

/// Number of no cell.
const NONE: u16 = CELLS as u16;

/// The cells next to each cell of a tile: to the left and to the right, above and below.
type Neighbours = [[Column<u16>; 2]; 2];

/// Areas of a tile's samples.
#[derive(Debug)]
pub struct Areas {
    neighbours: Box<Neighbours>,
    /// How far the area of each cell's sample reaches from it, in cells: to the left and to the right, up and down.
    sides: [[Column<f32>; 2]; 2],
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
        Self { neighbours: Box::new([0, 1].map(neighbours)), sides: [[[USUAL; CELLS]; 2]; 2] }
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
}
