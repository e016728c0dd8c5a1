//! Media that vary from place to place: a grid of cells, each of which is even.
//!
//! So all that is said of even media holds in each cell, by the same closed formulas: nothing along a ray is missed or drawn by lot, and a
//! ray is as long in each cell as it is. Blocks of empty cells are passed in one step.

use glam::{DVec3, UVec3, Vec3};

/// Cells along the edge of a block.
const BLOCK: u32 = 8;

/// What becomes of light in a cell, as factors of a [`Medium`](crate::scene::medium::Medium).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Factor on what is scattered.
    pub scatter: Vec3,
    /// Factor on what is absorbed.
    pub absorb: Vec3,
    /// Factor on what is emitted.
    pub emit: Vec3,
}

impl Cell {
    /// Clear air.
    pub const EMPTY: Self = Self { scatter: Vec3::ZERO, absorb: Vec3::ZERO, emit: Vec3::ZERO };

    /// All of it.
    pub const FULL: Self = Self { scatter: Vec3::ONE, absorb: Vec3::ONE, emit: Vec3::ONE };

    /// The same without what is negative or no number.
    fn cleaned(self) -> Self {
        let clean = |value: f32| if value > 0.0 && value.is_finite() { value } else { 0.0 };
        let [scatter, absorb, emit] =
            [self.scatter, self.absorb, self.emit].map(|of| Vec3::from_array(of.to_array().map(clean)));
        Self { scatter, absorb, emit }
    }
}

/// Cells in a box, object space.
#[derive(Debug, Clone, PartialEq)]
pub struct MediumGrid {
    low: DVec3,
    /// Size of a cell.
    cell: DVec3,
    counts: UVec3,
    /// Cells one after the other along X, then Y, then Z.
    cells: Vec<Cell>,
    /// Blocks in the same order: true if any of its cells is not empty.
    blocks: Vec<bool>,
}

impl MediumGrid {
    /// Most cells of a grid.
    pub const MOST_CELLS: u64 = 1 << 28;

    /// Creates the grid of `cells` of this size from `low` on: along X first, then Y, then Z. `None` if the numbers do not fit. What is
    /// negative or no number is empty.
    pub fn new(low: DVec3, size: DVec3, counts: UVec3, mut cells: Vec<Cell>) -> Option<Self> {
        let [x, y, z] = counts.to_array().map(u64::from);
        let count = x.checked_mul(y)?.checked_mul(z)?;
        let fits = count == cells.len() as u64 && count > 0 && count <= Self::MOST_CELLS;
        let is_box = low.is_finite() && size.is_finite() && size.cmpgt(DVec3::ZERO).all();
        if !(fits && is_box) {
            return None;
        }
        cells.iter_mut().for_each(|cell| *cell = cell.cleaned());
        let mut grid = Self { low, cell: size, counts, cells, blocks: Vec::new() };
        grid.blocks = grid.filled_blocks();
        Some(grid)
    }

    fn filled_blocks(&self) -> Vec<bool> {
        let counts = self.block_counts();
        let mut blocks = vec![false; (counts.x * counts.y * counts.z) as usize];
        for (number, _) in (0_u32..).zip(&self.cells).filter(|(_, cell)| **cell != Cell::EMPTY) {
            let row = number / self.counts.x;
            let at = UVec3::new(number % self.counts.x, row % self.counts.y, row / self.counts.y);
            blocks[number_of(at / BLOCK, counts)] = true;
        }
        blocks
    }

    fn block_counts(&self) -> UVec3 {
        (self.counts + BLOCK - 1) / BLOCK
    }

    /// Calls `each` for the parts of a line that lie in cells which are not empty, in their order: with the parameters at which a part
    /// begins and ends, from `from` to `to`, and its cell.
    pub fn walk(&self, line: [DVec3; 2], [from, to]: [f64; 2], mut each: impl FnMut(f64, f64, &Cell)) {
        let [origin, along] = line;
        // in cells
        let (origin, along) = ((origin - self.low) / self.cell, along / self.cell);
        let Some([from, to]) = clip(origin, along, self.counts.as_dvec3(), [from, to]) else { return };
        steps(origin, along, (self.block_counts(), f64::from(BLOCK)), [from, to], |block, from, to| {
            if self.blocks[number_of(block, self.block_counts())] {
                steps(origin, along, (self.counts, 1.0), [from, to], |cell, from, to| {
                    let cell = &self.cells[number_of(cell, self.counts)];
                    if *cell != Cell::EMPTY {
                        each(from, to, cell);
                    }
                });
            }
        });
    }
}

fn number_of(at: UVec3, counts: UVec3) -> usize {
    (at.x as usize) + (counts.x as usize) * (at.y as usize + counts.y as usize * at.z as usize)
}

/// The part of a line that lies in the box from zero to `high`.
fn clip(origin: DVec3, along: DVec3, high: DVec3, [mut from, mut to]: [f64; 2]) -> Option<[f64; 2]> {
    for axis in 0..3 {
        if along[axis] == 0.0 {
            if !(0.0..=high[axis]).contains(&origin[axis]) {
                return None;
            }
            continue;
        }
        let [one, other] = [0.0, high[axis]].map(|plane| (plane - origin[axis]) / along[axis]);
        from = from.max(one.min(other));
        to = to.min(one.max(other));
    }
    (from < to).then_some([from, to])
}

/// Calls `each` for the cells of this `size` that a line passes between two parameters: J. Amanatides and A. Woo, "A Fast Voxel Traversal
/// Algorithm for Ray Tracing", 1987.
fn steps(
    origin: DVec3,
    along: DVec3,
    (counts, size): (UVec3, f64),
    [from, to]: [f64; 2],
    mut each: impl FnMut(UVec3, f64, f64),
) {
    // the cell in which it is a little behind its beginning
    let start = origin + along * (from + (to - from).min(1e-9 * (1.0 + from.abs())));
    let mut at = [0_i64; 3];
    for axis in 0..3 {
        at[axis] = ((start[axis] / size).floor() as i64).clamp(0, i64::from(counts[axis]) - 1);
    }
    let mut here = from;
    // one step more than there are planes in all directions: rounding ends nothing early, and nothing goes on for ever
    for _ in 0..=counts.x + counts.y + counts.z {
        let leaves = |axis: usize| {
            let plane = if along[axis] > 0.0 { at[axis] + 1 } else { at[axis] } as f64 * size;
            if along[axis] == 0.0 { f64::INFINITY } else { (plane - origin[axis]) / along[axis] }
        };
        let planes = [0, 1, 2].map(leaves);
        let axis = (0..3).min_by(|a, b| planes[*a].total_cmp(&planes[*b])).unwrap_or(0);
        let there = planes[axis].min(to).max(here);
        if there > here {
            each(UVec3::new(at[0] as u32, at[1] as u32, at[2] as u32), here, there);
        }
        here = there;
        at[axis] += if along[axis] > 0.0 { 1 } else { -1 };
        if here >= to || !(0..i64::from(counts[axis])).contains(&at[axis]) {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shade::sampling::PathRandom;

    fn dense(density: f32) -> Cell {
        Cell { scatter: Vec3::X * density, ..Cell::EMPTY }
    }

    /// A grid whose cells are as dense as their numbers say, some of them empty.
    fn grid(counts: UVec3) -> MediumGrid {
        let cells = counts.x * counts.y * counts.z;
        let densities =
            (0..cells).map(|number| dense(if number % 3 == 0 { 0.0 } else { (number % 7) as f32 })).collect();
        MediumGrid::new(DVec3::new(-1.0, 0.5, 2.0), DVec3::new(0.5, 0.25, 1.0), counts, densities)
            .expect("it fits")
    }

    /// The length in each cell, by small steps, times its density.
    fn stepped(grid: &MediumGrid, origin: DVec3, along: DVec3, [from, to]: [f64; 2]) -> f64 {
        const STEPS: u32 = 200_000;
        let step = (to - from) / f64::from(STEPS);
        (0..STEPS)
            .map(|number| {
                let at = origin + along * (from + (f64::from(number) + 0.5) * step);
                let cell = ((at - grid.low) / grid.cell).floor();
                let is_in = cell.cmpge(DVec3::ZERO).all() && cell.cmplt(grid.counts.as_dvec3()).all();
                let density = || grid.cells[number_of(cell.as_uvec3(), grid.counts)].scatter.x;
                if is_in { f64::from(density()) * step } else { 0.0 }
            })
            .sum()
    }

    #[test]
    fn a_line_is_as_long_in_each_cell_as_small_steps_say() {
        let grid = grid(UVec3::new(9, 17, 11));
        for number in 0..24 {
            let random = PathRandom::new(5, number);
            let [[a, b, c, d], [e, f, ..]] = [random.four(0), random.four(1)];
            let place = |x: f32, y: f32, z: f32| {
                DVec3::new(-3.0, -2.0, -3.0)
                    + DVec3::new(f64::from(x) * 9.0, f64::from(y) * 9.0, f64::from(z) * 19.0)
            };
            let (origin, end) = (place(a, b, c), place(d, e, f));
            let line = [origin, end - origin];
            let (mut found, mut last) = (0.0, 0.0);
            grid.walk(line, [0.0, 1.0], |from, to, cell| {
                let density = cell.scatter.x;
                assert!(last <= from && from < to && to <= 1.0 && density > 0.0, "in order");
                last = to;
                found += (to - from) * f64::from(density);
            });
            let wanted = stepped(&grid, line[0], line[1], [0.0, 1.0]);
            assert!((found - wanted).abs() < 2e-3, "{number}: {found} for {wanted}");
        }
    }

    #[test]
    fn lines_along_planes_are_in_one_cell_or_the_other() {
        let grid = MediumGrid::new(DVec3::ZERO, DVec3::ONE, UVec3::splat(16), vec![dense(2.0); 4096])
            .expect("it fits");
        for (origin, along, wanted) in [
            (DVec3::new(8.0, 8.0, -4.0), DVec3::Z, 16.0),
            (DVec3::new(0.0, 0.0, 20.0), DVec3::NEG_Z, 16.0),
            (DVec3::new(16.0, 16.0, -4.0), DVec3::Z, 16.0),
            (DVec3::splat(-1.0), DVec3::ONE, 16.0),
            (DVec3::splat(4.0), DVec3::NEG_X, 4.0),
            (DVec3::new(8.0, 17.0, 3.0), DVec3::Z, 0.0),
        ] {
            let mut length = 0.0;
            grid.walk([origin, along], [0.0, f64::INFINITY], |from, to, _| length += to - from);
            assert!((length - wanted).abs() < 1e-9, "{origin} {along}: {length}");
        }
    }

    #[test]
    fn what_is_no_density_is_none() {
        let new = |counts, densities: &[f32]| {
            MediumGrid::new(DVec3::ZERO, DVec3::ONE, counts, densities.iter().copied().map(dense).collect())
        };
        assert!(new(UVec3::new(2, 1, 1), &[1.0]).is_none() && new(UVec3::ZERO, &[]).is_none());
        for (low, size) in [(DVec3::NAN, DVec3::ONE), (DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0))] {
            assert!(MediumGrid::new(low, size, UVec3::ONE, vec![dense(1.0)]).is_none());
        }
        let grid = new(UVec3::new(4, 1, 1), &[-1.0, f32::NAN, f32::INFINITY, 3.0]).expect("it fits");
        let mut parts = Vec::new();
        let line = [DVec3::new(-1.0, 0.5, 0.5), DVec3::X];
        grid.walk(line, [0.0, 9.0], |from, to, cell| parts.push((from, to, cell.scatter.x)));
        assert_eq!(parts, [(4.0, 5.0, 3.0)]);
    }
}
