//! Rays for the search: sixteen of a packet, those of them that make a beam, and single ones.

#![allow(
    clippy::needless_range_loop,
    reason = "one index leads into several arrays, and loops over it become vectors"
)]

use glam::Affine3A;

use super::beam::{Common, Ray};
use super::triangles::{Axes, Shear, axes_for, longest_axis};
use crate::geometry::tree::{Box3, WIDTH};
use crate::lanes::F32x8;
use crate::trace::LANES;

/// Number of groups of eight in a packet.
pub const HALVES: usize = LANES / WIDTH;

/// Sixteen rays in the space of the triangles that they are tested against.
#[derive(Clone)]
pub struct Rays {
    /// Origins, by axis.
    pub origin: [[f32; LANES]; 3],
    /// Directions, by axis.
    pub direction: [[f32; LANES]; 3],
    /// Least t.
    pub near: [f32; LANES],
}

impl Rays {
    /// Transforms the rays `used` to an object's space; the others get arbitrary values.
    #[inline(always)]
    pub fn transformed(&self, to_object: &Affine3A, used: u16) -> Self {
        let mut rays = self.clone();
        let matrix = to_object.to_cols_array_2d();
        for axis in 0..3 {
            let [x, y, z, w] = [matrix[0][axis], matrix[1][axis], matrix[2][axis], matrix[3][axis]];
            // a single ray must not cost as much as sixteen
            let first = first_of(used);
            let lanes = if used.count_ones() == 1 { first..first + 1 } else { 0..LANES };
            for lane in lanes {
                let (o, d) = (&self.origin, &self.direction);
                rays.origin[axis][lane] = o[0][lane] * x + o[1][lane] * y + o[2][lane] * z + w;
                rays.direction[axis][lane] = d[0][lane] * x + d[1][lane] * y + d[2][lane] * z;
            }
        }
        rays
    }

    /// Kind of a ray's direction: its longest axis, and if it goes against it. Rays of one kind make a beam.
    #[inline(always)]
    fn kind(&self, lane: usize) -> usize {
        let [x, y, z] = self.direction_of(lane);
        let [a, b, c] = [x.abs(), y.abs(), z.abs()];
        if a >= b && a >= c {
            usize::from(x < 0.0)
        } else if b >= c {
            2 + usize::from(y < 0.0)
        } else {
            4 + usize::from(z < 0.0)
        }
    }

    /// Rays among `lanes` (at least one) that have the same kind as the first.
    #[inline(always)]
    pub fn like_first(&self, lanes: u16) -> u16 {
        let kind = self.kind(first_of(lanes));
        let mut same = 0;
        for lane in 0..LANES {
            same |= u16::from(self.kind(lane) == kind) << lane;
        }
        same & lanes
    }

    #[inline(always)]
    fn direction_of(&self, lane: usize) -> [f32; 3] {
        [self.direction[0][lane], self.direction[1][lane], self.direction[2][lane]]
    }

    /// Ray number `lane`, up to `far`, for a tree within `bounds`, with the shear of triangles for it.
    #[inline(always)]
    pub fn one(&self, lane: usize, far: f32, bounds: &Box3) -> (Ray, Axes, Shear) {
        let origin = [self.origin[0][lane], self.origin[1][lane], self.origin[2][lane]];
        let direction = self.direction_of(lane);
        let axes = axes_for(longest_axis(direction));
        let [x, y, z] = axes;
        let shear = Shear {
            origin: [F32x8::splat(origin[x]), F32x8::splat(origin[y]), F32x8::splat(origin[z])],
            shear: [
                F32x8::splat(direction[x] / direction[z]),
                F32x8::splat(direction[y] / direction[z]),
                F32x8::splat(1.0 / direction[z]),
            ],
            near: F32x8::splat(self.near[lane]),
        };
        (Ray::new(origin, direction, [self.near[lane], far], bounds), axes, shear)
    }

    /// Computes the common bounds of the rays `used`, of one kind and at least one, up to `far`; and the
    /// conversion of each ray's t to a distance along their axis.
    #[inline(always)]
    pub fn common(&self, used: u16, far: &[f32; LANES]) -> (Common, Pace) {
        let kind = self.kind(first_of(used));
        let (along, backwards) = (kind / 2, kind % 2 == 1);
        let sign = if backwards { -1.0 } else { 1.0 };
        let (leader, lines) = (first_of(used), Lines::new(self, used, along, sign));
        let places = lines.closest_together(far[leader], leader);
        let pace = lines.pace(&places);
        let mut common = Common {
            along,
            backwards,
            place: [[0.0; 3]; 2],
            origin: [[0.0; 3]; 2],
            slope: [[0.0; 3]; 2],
            near: pace.least(&self.near, used),
            far: pace.greatest(far, used),
        };
        for axis in 0..3 {
            (common.place[0][axis], common.place[1][axis]) = ends(&places[axis]);
            (common.origin[0][axis], common.origin[1][axis]) = ends(&lines.origin[axis]);
            (common.slope[0][axis], common.slope[1][axis]) = ends(&lines.slope[axis]);
        }
        (common, pace)
    }

    /// Shears of triangles for the rays `used`, of one kind and at least one; the other rays meet no
    /// triangle.
    #[inline(always)]
    pub fn shears(&self, used: u16) -> (Axes, [Shear; HALVES]) {
        let axes = axes_for(longest_axis(self.direction_of(first_of(used))));
        let mut near = self.near;
        for (lane, near) in near.iter_mut().enumerate() {
            *near = if used >> lane & 1 != 0 { *near } else { f32::INFINITY };
        }
        (axes, [self.shear(axes, &near, 0), self.shear(axes, &near, 1)])
    }

    #[inline(always)]
    fn shear(&self, [x, y, z]: Axes, near: &[f32; LANES], half: usize) -> Shear {
        let (o, d) = (&self.origin, &self.direction);
        let along = eight_of(&d[z], half);
        Shear {
            origin: [eight_of(&o[x], half), eight_of(&o[y], half), eight_of(&o[z], half)],
            shear: [eight_of(&d[x], half) / along, eight_of(&d[y], half) / along, F32x8::ONE / along],
            near: eight_of(near, half),
        }
    }
}

/// Number of the first of `lanes`, of which there is at least one.
#[inline(always)]
pub fn first_of(lanes: u16) -> usize {
    lanes.trailing_zeros() as usize % LANES
}

/// Bit mask of the rays that are not blocked.
#[inline(always)]
pub fn open_lanes(far: &[f32; LANES]) -> u16 {
    let mut open = 0;
    for (lane, far) in far.iter().enumerate() {
        open |= u16::from(*far != f32::NEG_INFINITY) << lane;
    }
    open
}

/// One half of sixteen values.
#[inline(always)]
pub fn eight_of(values: &[f32; LANES], half: usize) -> F32x8 {
    F32x8::load(values, half * WIDTH)
}

/// Copies `values`, with that of the first of the lanes `used` in lanes that are not in use.
#[inline(always)]
fn only(values: &[f32; LANES], used: u16) -> [f32; LANES] {
    let mut values = *values;
    let instead = values[first_of(used)];
    for (lane, value) in values.iter_mut().enumerate() {
        *value = if used >> lane & 1 != 0 { *value } else { instead };
    }
    values
}

/// Least and greatest of `values`.
#[inline(always)]
fn ends(values: &[f32; LANES]) -> (f32, f32) {
    let (a, b) = (eight_of(values, 0), eight_of(values, 1));
    let (low, high) = (*a.min(b).values(), *a.max(b).values());
    let (mut least, mut most) = (low[0], high[0]);
    for i in 1..WIDTH {
        (least, most) = (lesser(least, low[i]), greater(most, high[i]));
    }
    (least, most)
}

#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// Lines that rays are on, as functions of a distance along one axis. Rays that are not in use are on the
/// line of one that is.
struct Lines {
    along: usize,
    /// 1, or -1 if they go against the axis.
    sign: f32,
    origin: [[f32; LANES]; 3],
    /// Slopes: along each axis for a unit of distance.
    slope: [[f32; LANES]; 3],
    /// Distance for a unit of t.
    a_unit: [f32; LANES],
}

impl Lines {
    #[inline(always)]
    fn new(rays: &Rays, used: u16, along: usize, sign: f32) -> Self {
        let mut a_unit = only(&rays.direction[along], used);
        for unit in &mut a_unit {
            *unit = unit.abs();
        }
        let (mut origin, mut slope) = (rays.origin, rays.direction);
        for axis in 0..3 {
            origin[axis] = only(&origin[axis], used);
            slope[axis] = only(&slope[axis], used);
            for (slope, unit) in slope[axis].iter_mut().zip(&a_unit) {
                *slope /= unit;
            }
        }
        Self { along, sign, origin, slope, a_unit }
    }

    /// Places of the rays at one height along the axis: at their start or at their end, whichever has them
    /// closer together. `far` is the end of the ray `leader`.
    #[inline(always)]
    fn closest_together(&self, far: f32, leader: usize) -> [[f32; LANES]; 3] {
        let start = self.origin[self.along][leader];
        let end = start + self.sign * far * self.a_unit[leader];
        let starts = self.places_at(start);
        if !end.is_finite() {
            return starts;
        }
        let others = self.places_at(end);
        if self.spread(&others) < self.spread(&starts) { others } else { starts }
    }

    /// Places of the rays at `height` along the axis.
    #[inline(always)]
    fn places_at(&self, height: f32) -> [[f32; LANES]; 3] {
        let mut places = self.origin;
        for axis in 0..3 {
            for lane in 0..LANES {
                let way = (height - self.origin[self.along][lane]) * self.sign;
                places[axis][lane] += self.slope[axis][lane] * way;
            }
        }
        places[self.along] = [height; LANES];
        places
    }

    /// Extent of places at one height, summed over the axes.
    #[inline(always)]
    fn spread(&self, places: &[[f32; LANES]; 3]) -> f32 {
        let mut sum = 0.0;
        for places in places {
            let (least, most) = ends(places);
            sum += most - least;
        }
        sum
    }

    /// Conversion of t to distances from `places`.
    #[inline(always)]
    fn pace(&self, places: &[[f32; LANES]; 3]) -> Pace {
        let mut pace = Pace { at_0: [0.0; LANES], a_unit: self.a_unit };
        for lane in 0..LANES {
            pace.at_0[lane] = (self.origin[self.along][lane] - places[self.along][lane]) * self.sign;
        }
        pace
    }
}

/// Conversion of t to a distance along a beam's axis, ray by ray.
#[derive(Clone, Copy)]
pub struct Pace {
    at_0: [f32; LANES],
    a_unit: [f32; LANES],
}

impl Pace {
    /// Identity: the distance is t.
    pub const OF_T: Self = Self { at_0: [0.0; LANES], a_unit: [1.0; LANES] };

    /// Greatest distance of the rays `used` at their t.
    #[inline(always)]
    pub fn greatest(&self, t: &[f32; LANES], used: u16) -> f32 {
        let mut most = f32::NEG_INFINITY;
        for lane in 0..LANES {
            let distance = self.at_0[lane] + t[lane] * self.a_unit[lane];
            most = greater(most, if used >> lane & 1 != 0 { distance } else { most });
        }
        most
    }

    /// Least distance of the rays `used` at their t.
    #[inline(always)]
    fn least(&self, t: &[f32; LANES], used: u16) -> f32 {
        let mut least = f32::INFINITY;
        for lane in 0..LANES {
            let distance = self.at_0[lane] + t[lane] * self.a_unit[lane];
            least = lesser(least, if used >> lane & 1 != 0 { distance } else { least });
        }
        least
    }
}
