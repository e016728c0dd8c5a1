//! One octave of the Voronoi texture: a grid of cells with one random point in each, and what a place has to
//! do with the points about it. Worley, "A Cellular Texture Basis Function" (SIGGRAPH 1996).

use std::array;

use glam::Vec3;

use super::gradient::eased;
use super::{difference, dot, finite, finite_vector, hash, mix, scaled, sum_of};

/// How far apart two points are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum VoronoiMetric {
    /// The root of the sum of squares.
    Euclidean,
    /// The sum of the distances on each axis.
    Manhattan,
    /// The largest of the distances on each axis.
    Chebychev,
    /// As the Euclidean one, with a power of any exponent instead of the square.
    Minkowski,
}

/// Visits the offsets of all cells up to `reach` away on each axis, X fastest: of two points at the same
/// distance, that which comes first counts.
pub(super) fn around<const N: usize>(reach: i32, mut visit: impl FnMut([i32; N])) {
    let mut offset = [-reach; N];
    for _ in 0..(2 * reach + 1).pow(N as u32) {
        visit(offset);
        for part in &mut offset {
            if *part < reach {
                *part += 1;
                break;
            }
            *part = -reach;
        }
    }
}

/// What the points have in common.
#[derive(Debug, Clone, Copy)]
pub(super) struct Points {
    /// How far away a point is.
    pub metric: VoronoiMetric,
    /// Of Minkowski's metric.
    pub exponent: f32,
    /// 0 to 0.5.
    pub smoothness: f32,
    /// 0 to 1.
    pub randomness: f32,
}

impl Points {
    /// The length of a vector. Of one axis, it is the same in all metrics.
    pub fn length<const N: usize>(&self, vector: [f32; N]) -> f32 {
        let rank = self.rank(vector);
        match self.metric {
            _ if N == 1 => rank,
            VoronoiMetric::Euclidean => rank.sqrt(),
            VoronoiMetric::Manhattan | VoronoiMetric::Chebychev => rank,
            VoronoiMetric::Minkowski => rank.powf(1.0 / self.exponent),
        }
    }

    /// A number that grows with the length, and is cheaper.
    fn rank<const N: usize>(&self, vector: [f32; N]) -> f32 {
        match self.metric {
            _ if N == 1 => vector[0].abs(),
            VoronoiMetric::Euclidean => dot(vector, vector),
            VoronoiMetric::Manhattan => vector.iter().map(|part| part.abs()).sum(),
            VoronoiMetric::Chebychev => vector.iter().fold(0.0, |most, part| part.abs().max(most)),
            VoronoiMetric::Minkowski => vector.iter().map(|part| part.abs().powf(self.exponent)).sum(),
        }
    }
}

/// What is found at a place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found<const N: usize> {
    /// Distance to a point.
    pub distance: f32,
    /// Random colour of the point, 0 to 1.
    pub color: Vec3,
    /// The point.
    pub position: [f32; N],
}

/// A point near a place.
#[derive(Debug, Clone, Copy)]
struct Near<const N: usize> {
    distance: f32,
    /// Of its cell, from that of the place.
    offset: [i32; N],
    /// From the corner of the place's cell.
    point: [f32; N],
}

impl<const N: usize> Near<N> {
    /// Farther than all.
    const NONE: Self = Self { distance: f32::MAX, offset: [0; N], point: [0.0; N] };
}

/// A place, and the cells about it.
pub(super) struct Cells<const N: usize> {
    points: Points,
    /// The cell of the place, as whole numbers and as floats.
    cell: [i32; N],
    floor: [f32; N],
    /// The place within its cell, 0 to 1.
    local: [f32; N],
}

impl<const N: usize> Cells<N> {
    /// The cells about a place.
    pub fn new(points: Points, place: [f32; N]) -> Self {
        let place = place.map(finite);
        let floor = place.map(f32::floor);
        Self { points, cell: floor.map(|value| value as i32), floor, local: difference(place, floor) }
    }

    /// The nearest point.
    pub fn first(&self) -> Found<N> {
        let nearest = self.nearest(|vector| self.points.rank(vector));
        let distance = self.points.length(difference(nearest.point, self.local));
        self.found(Near { distance, ..nearest })
    }

    /// The second nearest point.
    pub fn second(&self) -> Found<N> {
        let (mut first, mut second) = (Near::NONE, Near::NONE);
        around(1, |offset| {
            let point = self.point(offset);
            let near = Near { distance: self.points.length(difference(point, self.local)), offset, point };
            if near.distance < first.distance {
                second = first;
                first = near;
            } else if near.distance < second.distance {
                second = near;
            }
        });
        self.found(second)
    }

    /// The points near the place, blended: the smooth minimum of their distances, one after the other.
    ///
    /// The result depends on their order, if little. A smoothness of 0 is not for it.
    pub fn smooth_first(&self) -> Found<N> {
        let smoothness = self.points.smoothness;
        let mut blend: Option<Found<N>> = None;
        around(2, |offset| {
            let (point, color) = (self.point(offset), self.color(offset));
            let distance = self.points.length(difference(point, self.local));
            let Some(so_far) = blend else {
                blend = Some(Found { distance, color, position: point });
                return;
            };
            let share = eased(0.5 + 0.5 * (so_far.distance - distance) / smoothness);
            let dip = smoothness * share * (1.0 - share);
            let small_dip = dip / (1.0 + 3.0 * smoothness);
            blend = Some(Found {
                distance: mix(so_far.distance, distance, share) - dip,
                color: so_far.color * (1.0 - share) + color * share - small_dip,
                position: array::from_fn(|axis| mix(so_far.position[axis], point[axis], share) - small_dip),
            });
        });
        let blend = blend.unwrap_or(Found { distance: 0.0, color: Vec3::ZERO, position: [0.0; N] });
        let color = finite_vector(blend.color);
        Found { color, position: sum_of(self.floor, blend.position), ..blend }
    }

    /// Distance to the nearest plane between the cell of the nearest point and another, after Quilez,
    /// "Voronoi edges" (2012).
    pub fn edge_distance(&self) -> f32 {
        if N == 1 {
            return self.edge_distance_on_line();
        }
        let nearest = self.nearest(|vector| dot(vector, vector));
        let to_nearest = difference(nearest.point, self.local);
        let mut least = f32::MAX;
        around(1, |offset| {
            let to_point = difference(self.point(offset), self.local);
            let across = difference(to_point, to_nearest);
            let square = dot(across, across);
            // All but the nearest point itself.
            if square > 0.0001 {
                let middle = scaled(sum_of(to_nearest, to_point), 0.5);
                least = least.min(dot(middle, across) / square.sqrt());
            }
        });
        least
    }

    /// Distance to the nearest middle between the point of this cell and those of the cells beside it.
    fn edge_distance_on_line(&self) -> f32 {
        // The key of this cell is its number as it is. Others take in an offset, by which a negative zero
        // becomes a positive one, with other bits.
        let own = hash::unit([self.floor[0]]) * self.points.randomness;
        let distance = |side| ((own + self.point([side; N])[0]) / 2.0 - self.local[0]).abs();
        distance(-1).min(distance(1))
    }

    /// Half the distance from the nearest point to the point that is nearest to it.
    pub fn radius(&self) -> f32 {
        let nearest = self.nearest(|vector| dot(vector, vector));
        let mut least = f32::MAX;
        around(1, |offset: [i32; N]| {
            if offset != [0; N] {
                let other = self.point(array::from_fn(|axis| nearest.offset[axis] + offset[axis]));
                let vector = difference(nearest.point, other);
                least = least.min(dot(vector, vector));
            }
        });
        least.sqrt() / 2.0
    }

    fn nearest(&self, rank: impl Fn([f32; N]) -> f32) -> Near<N> {
        let mut nearest = Near::NONE;
        around(1, |offset| {
            let point = self.point(offset);
            let distance = rank(difference(point, self.local));
            if distance < nearest.distance {
                nearest = Near { distance, offset, point };
            }
        });
        nearest
    }

    fn found(&self, near: Near<N>) -> Found<N> {
        let position = sum_of(near.point, self.floor);
        Found { distance: near.distance, color: self.color(near.offset), position }
    }

    fn key(&self, offset: [i32; N]) -> [i32; N] {
        array::from_fn(|axis| self.cell[axis].wrapping_add(offset[axis]))
    }

    /// The point of a cell, from the corner of the place's cell.
    fn point(&self, offset: [i32; N]) -> [f32; N] {
        let random =
            if N == 1 { [hash::unit([self.line_key(offset)]); N] } else { hash::cell(self.key(offset)) };
        array::from_fn(|axis| offset[axis] as f32 + random[axis] * self.points.randomness)
    }

    /// The random colour of a cell, each part 0 to 1.
    fn color(&self, offset: [i32; N]) -> Vec3 {
        if N == 1 {
            return hash::unit3_of1(self.line_key(offset));
        }
        let key = self.key(offset);
        let part = |axis: usize| key.get(axis).copied().unwrap_or(0);
        let [red, green, blue] = if N == 4 {
            let [red, green, blue, _] = hash::cell([part(0), part(1), part(2), part(3)]);
            [red, green, blue]
        } else {
            hash::cell([part(0), part(1), part(2)])
        };
        Vec3::new(red, green, blue)
    }

    /// Of one axis, the other hash is used, of the cell as a float.
    fn line_key(&self, offset: [i32; N]) -> f32 {
        self.floor[0] + offset[0] as f32
    }
}
