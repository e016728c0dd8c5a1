//! Media that vary from place to place: values at the points of a lattice, between which they are interpolated.
//!
//! In a cell between eight points a value is trilinear in the place, and along a line a cubic polynomial of the parameter. Its integral is
//! exact by two places (Gauss and Legendre), so what is left of light behind a cell is exact, too. Within a cell a ray takes the mean of its
//! part there: all that is said of even media holds in it, by the same closed formulas, and nothing along a ray is drawn by lot.
//!
//! Points are kept in blocks, and only where there is anything: regions and blocks that are empty are passed in one step.

use std::collections::HashMap;

use glam::{DAffine3, DVec3, IVec3, Vec3};

/// Cells along the edge of a block.
pub const BLOCK: i32 = 8;

/// Points along the edge of a block: those of its cells, with the far ones.
pub const POINTS: i32 = BLOCK + 1;

/// Points of a block: along X first, then Y, then Z.
pub const BLOCK_POINTS: usize = (POINTS * POINTS * POINTS) as usize;

/// Blocks along the edge of a region.
const REGION: i32 = 16;

/// Most regions in the box around all that are not empty: 13,000 cells along each edge.
const MOST_REGIONS: i64 = 1 << 20;

/// The number of no block, and of no region.
const NONE: u32 = u32::MAX;

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

    fn plus(self, other: &Self, factor: f32) -> Self {
        Self {
            scatter: self.scatter + other.scatter * factor,
            absorb: self.absorb + other.absorb * factor,
            emit: self.emit + other.emit * factor,
        }
    }
}

/// Values on a lattice in the space of a mesh's positions.
#[derive(Debug, Clone, PartialEq)]
pub struct MediumGrid {
    /// Map from that space to that of the lattice, whose points have whole numbers; the lowest region begins at 0.
    to_lattice: DAffine3,
    /// Regions along each axis.
    counts: IVec3,
    /// Number of the table of each region, along X first, then Y, then Z.
    regions: Vec<u32>,
    /// Tables of regions: the number of each block.
    tables: Vec<Vec<u32>>,
    /// Values of blocks: of each channel at each point.
    values: Vec<f32>,
    /// What 1 of each channel is.
    channels: Vec<Cell>,
}

/// Channels of a grid, at most: all that a [`Cell`] has.
pub const MOST_CHANNELS: usize = 9;

/// Why values make no grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoGrid {
    /// There are none, or the lattice has no space.
    Empty,
    /// They are too far apart.
    TooWide,
}

impl MediumGrid {
    /// Creates the grid of `blocks`: the place of each on the lattice, in blocks, and the values of each channel at its points. 1 of a
    /// channel is what `channels` say. What is negative or no number counts as zero.
    ///
    /// # Errors
    /// Blocks that are nowhere, or far apart.
    pub fn new(
        to_lattice: DAffine3,
        channels: Vec<Cell>,
        blocks: Vec<(IVec3, Vec<f32>)>,
    ) -> Result<Self, NoGrid> {
        let size = BLOCK_POINTS * channels.len();
        let is_filled = |values: &[f32]| values.iter().any(|value| *value > 0.0);
        let mut blocks = blocks;
        blocks.retain(|(_, values)| values.len() == size && is_filled(values));
        let regions = || blocks.iter().map(|(at, _)| at.div_euclid(IVec3::splat(REGION)));
        let low = regions().reduce(IVec3::min).ok_or(NoGrid::Empty)?;
        let high = regions().reduce(IVec3::max).ok_or(NoGrid::Empty)?;
        let counts = (high.as_i64vec3() - low.as_i64vec3()) + 1;
        let is_small = counts.cmple(glam::I64Vec3::splat(MOST_REGIONS)).all();
        if !is_small || counts.x * counts.y * counts.z > MOST_REGIONS {
            return Err(NoGrid::TooWide);
        }
        if !to_lattice.is_finite() || to_lattice.matrix3.determinant() == 0.0 {
            return Err(NoGrid::Empty);
        }
        let counts = counts.as_ivec3();
        let origin = low.as_dvec3() * f64::from(REGION * BLOCK);
        let mut grid = Self {
            to_lattice: DAffine3::from_translation(-origin) * to_lattice,
            counts,
            regions: vec![NONE; (counts.x * counts.y * counts.z) as usize],
            tables: Vec::new(),
            values: Vec::with_capacity(blocks.len() * size),
            channels,
        };
        // what is even all over is kept once
        let mut even: HashMap<Vec<u32>, u32> = HashMap::new();
        for (at, values) in blocks {
            let region = at.div_euclid(IVec3::splat(REGION));
            let known = &mut grid.regions[number_of(region - low, counts)];
            if *known == NONE {
                *known = grid.tables.len() as u32;
                grid.tables.push(vec![NONE; (REGION * REGION * REGION) as usize]);
            }
            let slot = number_of(at - region * REGION, IVec3::splat(REGION));
            let next = (grid.values.len() / size) as u32;
            let mut add = || {
                let clean = |value: &f32| if *value > 0.0 && value.is_finite() { *value } else { 0.0 };
                grid.values.extend(values.iter().map(clean));
                next
            };
            let is_even = values.chunks(BLOCK_POINTS).all(|of| of.iter().all(|value| *value == of[0]));
            let number = if is_even {
                let key = values.chunks(BLOCK_POINTS).map(|of| of[0].to_bits()).collect();
                *even.entry(key).or_insert_with(add)
            } else {
                add()
            };
            grid.tables[*known as usize][slot] = number;
        }
        Ok(grid)
    }

    /// Calls `each` for the parts of a line that lie in cells where there is anything, in their order: with the parameters at which a part
    /// begins and ends, from `from` to `to`, and what the part is like in the mean.
    pub fn walk(&self, line: [DVec3; 2], range: [f64; 2], mut each: impl FnMut(f64, f64, &Cell)) {
        self.parts(line, range, |from, to, means| {
            let add = |cell: Cell, (mean, of): (&f32, &Cell)| cell.plus(of, *mean);
            each(from, to, &means.iter().zip(&self.channels).fold(Cell::EMPTY, add));
        });
    }

    /// Adds to `integrals` those of the channels along the part of a line between two parameters.
    pub fn integrate(&self, line: [DVec3; 2], range: [f64; 2], integrals: &mut [f64; MOST_CHANNELS]) {
        self.parts(line, range, |from, to, means| {
            for (integral, mean) in integrals.iter_mut().zip(means) {
                *integral += (to - from) * f64::from(*mean);
            }
        });
    }

    /// What so much of each channel is.
    pub fn cell(&self, amounts: &[f64; MOST_CHANNELS]) -> Cell {
        let add = |cell: Cell, (amount, of): (&f64, &Cell)| cell.plus(of, *amount as f32);
        amounts.iter().zip(&self.channels).fold(Cell::EMPTY, add)
    }

    /// Calls `each` for the parts of a line in cells that are not empty, with the means of the channels there.
    fn parts(&self, [origin, along]: [DVec3; 2], range: [f64; 2], mut each: impl FnMut(f64, f64, &[f32])) {
        let origin = self.to_lattice.transform_point3(origin);
        let ray = Line::new(origin, self.to_lattice.transform_vector3(along));
        let edge = REGION * BLOCK;
        let Some(range) = ray.clip((self.counts * edge).as_dvec3(), range) else { return };
        let (channels, size) = (self.channels.len(), self.channels.len() * BLOCK_POINTS);
        ray.steps((IVec3::ZERO, self.counts, edge), range, |region, range| {
            let table = self.regions[number_of(region, self.counts)];
            let Some(table) = self.tables.get(table as usize) else { return };
            let inner = (region * REGION, IVec3::splat(REGION), BLOCK);
            ray.steps(inner, range, |block, range| {
                let number = table[number_of(block - region * REGION, IVec3::splat(REGION))];
                if number == NONE {
                    return;
                }
                let values = &self.values[number as usize * size..][..size];
                let low = block * BLOCK;
                ray.steps((low, IVec3::splat(BLOCK), 1), range, |cell, [from, to]| {
                    let first = number_of(cell - low, IVec3::splat(POINTS));
                    let [one, other] = ray.places([from, to], cell);
                    let mut means = [0.0; MOST_CHANNELS];
                    for (mean, values) in means.iter_mut().zip(values.chunks_exact(BLOCK_POINTS)) {
                        *mean = mean_of(values, first, [one, other]);
                    }
                    if means != [0.0; MOST_CHANNELS] {
                        each(from, to, &means[..channels]);
                    }
                });
            });
        });
    }
}

/// Mean of the values at two places of the cell whose lowest point has the number `first`.
fn mean_of(values: &[f32], first: usize, places: [Vec3; 2]) -> f32 {
    const ROW: usize = POINTS as usize;
    const LAYER: usize = ROW * ROW;
    let corners = &values[first..first + LAYER + ROW + 2];
    let rows = [0, ROW, LAYER, LAYER + ROW].map(|row| [corners[row], corners[row + 1]]);
    let at = |place: Vec3| {
        let [a, b, c, d] = rows.map(|[low, high]| low + (high - low) * place.x);
        let (low, high) = (a + (b - a) * place.y, c + (d - c) * place.y);
        low + (high - low) * place.z
    };
    ((at(places[0]) + at(places[1])) * 0.5).max(0.0)
}

fn number_of(at: IVec3, counts: IVec3) -> usize {
    (at.x + counts.x * (at.y + counts.y * at.z)) as usize
}

/// A line in the space of a lattice.
struct Line {
    origin: DVec3,
    along: DVec3,
    /// Reciprocal of `along`.
    pace: DVec3,
}

impl Line {
    fn new(origin: DVec3, along: DVec3) -> Self {
        Self { origin, along, pace: along.recip() }
    }

    /// The part of it that lies in the box from zero to `high`.
    fn clip(&self, high: DVec3, [mut from, mut to]: [f64; 2]) -> Option<[f64; 2]> {
        for axis in 0..3 {
            if self.along[axis] == 0.0 {
                if !(0.0..=high[axis]).contains(&self.origin[axis]) {
                    return None;
                }
                continue;
            }
            let [one, other] = [0.0, high[axis]].map(|plane| (plane - self.origin[axis]) * self.pace[axis]);
            from = from.max(one.min(other));
            to = to.min(one.max(other));
        }
        (from < to).then_some([from, to])
    }

    /// Calls `each` for the boxes of `size` cells that it passes between two parameters, of those `counts` that begin at `low` (in
    /// boxes): J. Amanatides and A. Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", 1987.
    fn steps(
        &self,
        (low, counts, size): (IVec3, IVec3, i32),
        [from, to]: [f64; 2],
        mut each: impl FnMut(IVec3, [f64; 2]),
    ) {
        let edge = f64::from(size);
        // the box in which it is a little behind its beginning
        let start = self.origin + self.along * (from + (to - from).min(1e-9 * (1.0 + from.abs())));
        let highest = low + counts - 1;
        let mut at = (start / edge).floor().as_ivec3().clamp(low, highest);
        let leaves = |at: IVec3, axis: usize| {
            let plane = f64::from(if self.along[axis] > 0.0 { at[axis] + 1 } else { at[axis] }) * edge;
            if self.along[axis] == 0.0 {
                f64::INFINITY
            } else {
                (plane - self.origin[axis]) * self.pace[axis]
            }
        };
        let mut planes = [0, 1, 2].map(|axis| leaves(at, axis));
        let mut here = from;
        // one step more than there are planes in all directions: rounding ends nothing early, and nothing goes on for ever
        for _ in 0..=counts.x + counts.y + counts.z {
            let first = if planes[0] <= planes[1] { 0 } else { 1 };
            let axis = if planes[first] <= planes[2] { first } else { 2 };
            let there = planes[axis].min(to).max(here);
            if there > here {
                each(at, [here, there]);
            }
            here = there;
            at[axis] += if self.along[axis] > 0.0 { 1 } else { -1 };
            if here >= to || at[axis] < low[axis] || at[axis] > highest[axis] {
                break;
            }
            planes[axis] = leaves(at, axis);
        }
    }

    /// The two places of Gauss and Legendre between two parameters, in a cell: 0 to 1 along each axis.
    fn places(&self, [from, to]: [f64; 2], cell: IVec3) -> [Vec3; 2] {
        /// Half of the distance between them, as a share of the length.
        const APART: f64 = 0.288_675_134_594_812_9;
        let (middle, apart) = ((from + to) * 0.5, (to - from) * APART);
        let in_cell = self.origin - cell.as_dvec3();
        [middle - apart, middle + apart]
            .map(|at| (in_cell + self.along * at).as_vec3().clamp(Vec3::ZERO, Vec3::ONE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shade::sampling::PathRandom;

    const DENSITY: [Cell; 1] = [Cell { scatter: Vec3::X, ..Cell::EMPTY }];

    /// What is at a point of the lattice: nothing in places, and beyond some box.
    fn density(at: IVec3) -> f32 {
        let number = (at.x * 31 + at.y * 17 + at.z * 7).rem_euclid(11);
        let is_there = at.cmpge(IVec3::splat(-10)).all() && at.cmple(IVec3::new(12, 40, 150)).all();
        if is_there && number > 3 && at.y.div_euclid(20) != 0 { number as f32 } else { 0.0 }
    }

    fn block(at: IVec3, density: impl Fn(IVec3) -> f32) -> (IVec3, Vec<f32>) {
        let points = (0..POINTS).flat_map(|z| {
            (0..POINTS).flat_map(move |y| (0..POINTS).map(move |x| at * BLOCK + IVec3::new(x, y, z)))
        });
        (at, points.map(density).collect())
    }

    fn grid() -> MediumGrid {
        let mut blocks = Vec::new();
        for z in -3..20 {
            for y in -3..6 {
                blocks.extend((-3..3).map(|x| block(IVec3::new(x, y, z), density)));
            }
        }
        MediumGrid::new(to_lattice(), DENSITY.to_vec(), blocks).expect("it fits")
    }

    fn to_lattice() -> DAffine3 {
        DAffine3::from_scale(DVec3::new(2.0, 4.0, 1.0)) * DAffine3::from_rotation_y(0.3)
    }

    /// The integral of what is interpolated between points, by small steps.
    fn stepped([origin, along]: [DVec3; 2]) -> f64 {
        const STEPS: u32 = 100_000;
        let [origin, along] = [to_lattice().transform_point3(origin), to_lattice().transform_vector3(along)];
        let value = |number: u32| {
            let place = origin + along * ((f64::from(number) + 0.5) / f64::from(STEPS));
            let (cell, at) = (place.floor().as_ivec3(), place - place.floor());
            let corner = |number: i32| {
                let offset = IVec3::new(number & 1, number >> 1 & 1, number >> 2);
                let weight = |axis: usize| if offset[axis] == 1 { at[axis] } else { 1.0 - at[axis] };
                weight(0) * weight(1) * weight(2) * f64::from(density(cell + offset))
            };
            (0..8).map(corner).sum::<f64>()
        };
        (0..STEPS).map(value).sum::<f64>() / f64::from(STEPS)
    }

    #[test]
    fn what_a_line_passes_is_what_small_steps_say() {
        let grid = grid();
        for number in 0..24 {
            let random = PathRandom::new(5, number);
            let [[a, b, c, d], [e, f, ..]] = [random.four(0), random.four(1)];
            let place = |x: f32, y: f32, z: f32| {
                let [x, y, z] = [x, y, z].map(f64::from);
                to_lattice().inverse().transform_point3(
                    DVec3::new(-16.0, -20.0, -16.0) + DVec3::new(x * 34.0, y * 70.0, z * 180.0),
                )
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
            let wanted = stepped(line);
            assert!((found - wanted).abs() < 1e-4 * (1.0 + wanted), "{number}: {found} for {wanted}");
            let mut integrals = [0.0; MOST_CHANNELS];
            grid.integrate(line, [0.0, 1.0], &mut integrals);
            assert!((integrals[0] - found).abs() < 1e-9 * (1.0 + found));
        }
    }

    #[test]
    fn lines_along_planes_are_in_one_cell_or_the_other() {
        let full = |at: IVec3| {
            let is_there = at.cmpge(IVec3::ZERO).all() && at.cmple(IVec3::splat(16)).all();
            if is_there { 2.0 } else { 0.0 }
        };
        let blocks = (0..8).map(|number| {
            let (values, at) = (|at| block(at, full), IVec3::new(number & 1, number >> 1 & 1, number >> 2));
            values(at)
        });
        let grid = MediumGrid::new(DAffine3::IDENTITY, DENSITY.to_vec(), blocks.collect()).expect("it fits");
        for (origin, along, wanted) in [
            (DVec3::new(8.0, 8.0, -4.0), DVec3::Z, 16.0),
            (DVec3::new(0.0, 0.0, 20.0), DVec3::NEG_Z, 16.0),
            (DVec3::new(8.0, 3.0, -4.0), DVec3::Z, 16.0),
            (DVec3::splat(-1.0), DVec3::ONE, 16.0),
            (DVec3::splat(4.0), DVec3::NEG_X, 4.0),
            (DVec3::new(8.0, -1.0, 3.0), DVec3::Z, 0.0),
        ] {
            let mut length = 0.0;
            grid.walk([origin, along], [0.0, f64::INFINITY], |from, to, _| length += to - from);
            assert!((length - wanted).abs() < 1e-9, "{origin} {along}: {length}");
        }
        assert_eq!(grid.values.len(), BLOCK_POINTS, "what is even is kept once");
    }

    #[test]
    fn what_is_no_density_is_none() {
        let new = |value: f32, at: IVec3| {
            let blocks = vec![block(at, |_| value), block(IVec3::ZERO, |_| value)];
            MediumGrid::new(DAffine3::IDENTITY, DENSITY.to_vec(), blocks)
        };
        for nothing in [0.0, -1.0, f32::NAN] {
            assert_eq!(new(nothing, IVec3::ONE), Err(NoGrid::Empty));
        }
        assert_eq!(new(1.0, IVec3::splat(i32::MAX / 16)), Err(NoGrid::TooWide));
        assert_eq!(new(1.0, IVec3::new(i32::MIN / 16, 0, 0)), Err(NoGrid::TooWide));
        let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
        assert!(MediumGrid::new(flat, DENSITY.to_vec(), vec![block(IVec3::ZERO, |_| 1.0)]).is_err());
        let grid = new(f32::INFINITY, IVec3::ONE).expect("the infinite counts as zero");
        grid.walk([DVec3::splat(-1.0), DVec3::ONE], [0.0, 99.0], |_, _, _| panic!("it is empty"));
    }
}
