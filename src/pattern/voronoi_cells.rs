//! One octave of the Voronoi texture: a grid of cells with one random point in each, and what a place has to
//! do with the points about it. Worley, "A Cellular Texture Basis Function" (SIGGRAPH 1996).

use std::array;

use super::gradient::eased;
use super::hash::{self, CellHash, CellOffset};
use super::{difference, dot, finite_vectors, finite8, mix, scaled, sum_of};
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};

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
    pub exponent: F32x8,
    /// 0 to 0.5.
    pub smoothness: F32x8,
    /// 0 to 1.
    pub randomness: F32x8,
}

impl Points {
    /// Those of one lane in all of them.
    #[inline(always)]
    fn of_lane(self, lane: usize) -> Self {
        let [exponent, smoothness, randomness] =
            [self.exponent, self.smoothness, self.randomness].of_lane(lane);
        Self { exponent, smoothness, randomness, ..self }
    }

    /// The length of a vector. Of one axis, it is the same in all metrics.
    #[inline(always)]
    pub fn length<const N: usize>(&self, vector: [F32x8; N]) -> F32x8 {
        let rank = self.rank(vector);
        match self.metric {
            _ if N == 1 => rank,
            VoronoiMetric::Euclidean => rank.sqrt(),
            VoronoiMetric::Manhattan | VoronoiMetric::Chebychev => rank,
            VoronoiMetric::Minkowski => rank.each_with(F32x8::ONE / self.exponent, f32::powf),
        }
    }

    /// A number that grows with the length, and is cheaper.
    #[inline(always)]
    fn rank<const N: usize>(&self, vector: [F32x8; N]) -> F32x8 {
        let sum = |parts: [F32x8; N]| parts.into_iter().fold(F32x8::ZERO, |sum, part| sum + part);
        match self.metric {
            _ if N == 1 => vector[0].abs(),
            VoronoiMetric::Euclidean => dot(vector, vector),
            VoronoiMetric::Manhattan => sum(vector.map(F32x8::abs)),
            VoronoiMetric::Chebychev => vector.iter().fold(F32x8::ZERO, |most, part| part.abs().max(most)),
            VoronoiMetric::Minkowski => {
                sum(vector.map(|part| part.abs().each_with(self.exponent, f32::powf)))
            }
        }
    }
}

/// What is found at a place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found<const N: usize> {
    /// Distance to a point.
    pub distance: F32x8,
    /// Random colour of the point, 0 to 1.
    pub color: Vec3x8,
    /// The point.
    pub position: [F32x8; N],
}

impl<const N: usize> Found<N> {
    /// This where a mask says so, the other elsewhere.
    #[inline(always)]
    pub fn where_or(self, mask: Mask, other: Self) -> Self {
        Self {
            distance: mask.select(self.distance, other.distance),
            color: mask.select3(self.color, other.color),
            position: array::from_fn(|axis| mask.select(self.position[axis], other.position[axis])),
        }
    }
}

/// A point near a place.
#[derive(Debug, Clone, Copy)]
struct Near<const N: usize> {
    distance: F32x8,
    /// Of its cell, from that of the place: whole numbers.
    offset: [F32x8; N],
    /// From the corner of the place's cell.
    point: [F32x8; N],
}

impl<const N: usize> Near<N> {
    /// Farther than all.
    #[inline(always)]
    fn none() -> Self {
        Self { distance: F32x8::splat(f32::MAX), offset: [F32x8::ZERO; N], point: [F32x8::ZERO; N] }
    }

    /// This where a mask says so, the other elsewhere.
    #[inline(always)]
    fn where_or(self, mask: Mask, other: Self) -> Self {
        Self {
            distance: mask.select(self.distance, other.distance),
            offset: array::from_fn(|axis| mask.select(self.offset[axis], other.offset[axis])),
            point: array::from_fn(|axis| mask.select(self.point[axis], other.point[axis])),
        }
    }
}

/// A place, and the cells about it.
pub(super) struct Cells<const N: usize> {
    pub points: Points,
    /// The cell of the place, as a hash and as floats.
    hash: CellHash<N>,
    floor: [F32x8; N],
    /// The place within its cell, 0 to 1.
    local: [F32x8; N],
    /// True if one place counts, which all lanes have.
    is_one: bool,
}

/// Cells in each lane, by how far they are from that of the place: whole numbers.
#[derive(Clone, Copy)]
struct Offset<const N: usize> {
    floats: [F32x8; N],
    in_hash: CellOffset<N>,
}

impl<const N: usize> Offset<N> {
    /// The same in all lanes.
    #[inline(always)]
    fn all(offset: [i32; N]) -> Self {
        let floats = offset.map(|part| F32x8::splat(part as f32));
        Self { floats, in_hash: CellOffset::all(offset) }
    }

    /// Another one in each lane.
    #[inline(always)]
    fn each(floats: [F32x8; N]) -> Self {
        Self { floats, in_hash: CellOffset::each(floats.map(F32x8::to_whole)) }
    }

    /// Those from number `first` on of the cells up to `reach` away, in the order of [`around`], one in each lane.
    #[inline(always)]
    fn of_numbers(first: usize, reach: i32) -> Self {
        let (side, reach) = ((2 * reach + 1) as f32, reach as f32);
        let mut rest = F32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]) + first as f32;
        Self::each(array::from_fn(|_| {
            // the half keeps whole numbers away from the border of rounding
            let above = ((rest + 0.5) / side).floor();
            let part = rest - above * side - reach;
            rest = above;
            part
        }))
    }
}

/// What is found of a cell: it can be that of one lane in all of them.
trait OfCell: Copy {
    fn of_lane(self, lane: usize) -> Self;
}

impl OfCell for F32x8 {
    #[inline(always)]
    fn of_lane(self, lane: usize) -> Self {
        Self::splat(self.lane(lane))
    }
}

impl<const N: usize> OfCell for [F32x8; N] {
    #[inline(always)]
    fn of_lane(self, lane: usize) -> Self {
        self.map(|part| part.of_lane(lane))
    }
}

impl<const N: usize> OfCell for Near<N> {
    #[inline(always)]
    fn of_lane(self, lane: usize) -> Self {
        Self {
            distance: self.distance.of_lane(lane),
            offset: self.offset.of_lane(lane),
            point: self.point.of_lane(lane),
        }
    }
}

impl<const N: usize> OfCell for Found<N> {
    #[inline(always)]
    fn of_lane(self, lane: usize) -> Self {
        let color = <[F32x8; 3]>::from(self.color).of_lane(lane).into();
        Self { distance: self.distance.of_lane(lane), color, position: self.position.of_lane(lane) }
    }
}

impl<const N: usize> Cells<N> {
    /// The cells about places, of which so many count.
    #[inline(always)]
    pub fn new(points: Points, place: [F32x8; N], lanes: usize) -> Self {
        let is_one = lanes == 1;
        let (points, place) = if is_one { (points.of_lane(0), place.of_lane(0)) } else { (points, place) };
        let place = place.map(finite8);
        let floor = place.map(F32x8::floor);
        let hash = CellHash::new(floor.map(F32x8::to_whole));
        Self { points, hash, floor, local: difference(place, floor), is_one }
    }

    /// Visits what is found `of` all cells up to `reach` away, in the order of [`around`]: cell by cell, of eight places; of one place, eight
    /// cells at once.
    #[inline(always)]
    fn each_cell<T: OfCell>(&self, reach: i32, of: impl Fn(&Offset<N>) -> T, mut visit: impl FnMut(T)) {
        if !self.is_one {
            around(reach, |offset| visit(of(&Offset::all(offset))));
            return;
        }
        let count = (2 * reach as usize + 1).pow(N as u32);
        for first in (0..count).step_by(LANES) {
            let eight = of(&Offset::of_numbers(first, reach));
            (0..LANES.min(count - first)).for_each(|lane| visit(eight.of_lane(lane)));
        }
    }

    /// The nearest point.
    #[inline(never)]
    pub fn first(&self) -> Found<N> {
        let nearest = self.nearest(|vector| self.points.rank(vector));
        let distance = self.points.length(difference(nearest.point, self.local));
        self.found(Near { distance, ..nearest })
    }

    /// The second nearest point.
    #[inline(never)]
    pub fn second(&self) -> Found<N> {
        let (mut first, mut second) = (Near::none(), Near::none());
        let near = |offset: &Offset<N>| self.near(offset, |vector| self.points.length(vector));
        self.each_cell(1, near, |near| {
            let is_first = near.distance.lt(first.distance);
            let is_second = near.distance.lt(second.distance);
            second = first.where_or(is_first, near.where_or(is_second, second));
            first = near.where_or(is_first, first);
        });
        self.found(second)
    }

    /// The points near the place, blended: the smooth minimum of their distances, one after the other.
    ///
    /// The result depends on their order, if little. A smoothness of 0 is not for it.
    #[inline(never)]
    pub fn smooth_first(&self) -> Found<N> {
        let smoothness = self.points.smoothness;
        let mut blend: Option<Found<N>> = None;
        let of_cell = |offset: &Offset<N>| {
            let Near { point, distance, .. } = self.near(offset, |vector| self.points.length(vector));
            Found { distance, color: self.color(offset), position: point }
        };
        self.each_cell(2, of_cell, |next| {
            let Some(so_far) = blend else {
                blend = Some(next);
                return;
            };
            let share = eased((so_far.distance - next.distance) * 0.5 / smoothness + 0.5);
            let rest = F32x8::ONE - share;
            let dip = smoothness * share * rest;
            let small_dip = dip / (smoothness * 3.0 + 1.0);
            let moved = |value: F32x8| value - small_dip;
            let between = |axis: usize| mix(so_far.position[axis], next.position[axis], share);
            blend = Some(Found {
                distance: mix(so_far.distance, next.distance, share) - dip,
                color: (so_far.color * rest + next.color * share).each(moved),
                position: array::from_fn(|axis| moved(between(axis))),
            });
        });
        let nothing = Found { distance: F32x8::ZERO, color: Vec3x8::ZERO, position: [F32x8::ZERO; N] };
        let blend = blend.unwrap_or(nothing);
        let color = finite_vectors(blend.color);
        Found { color, position: sum_of(self.floor, blend.position), ..blend }
    }

    /// Distance to the nearest plane between the cell of the nearest point and another, after Quilez,
    /// "Voronoi edges" (2012).
    #[inline(never)]
    pub fn edge_distance(&self) -> F32x8 {
        /// Farther than any edge.
        const FAR: F32x8 = F32x8::new([f32::MAX; LANES]);
        if N == 1 {
            return self.edge_distance_on_line();
        }
        let nearest = self.nearest(|vector| dot(vector, vector));
        let to_nearest = difference(nearest.point, self.local);
        let to_edge = |offset: &Offset<N>| {
            let to_point = difference(self.point(offset), self.local);
            let across = difference(to_point, to_nearest);
            let square = dot(across, across);
            let middle = scaled(sum_of(to_nearest, to_point), F32x8::splat(0.5));
            // All but the nearest point itself.
            square.gt(F32x8::splat(0.0001)).select(dot(middle, across) / square.sqrt(), FAR)
        };
        let mut least = FAR;
        self.each_cell(1, to_edge, |distance| least = distance.min(least));
        least
    }

    /// Distance to the nearest middle between the point of this cell and those of the cells beside it.
    fn edge_distance_on_line(&self) -> F32x8 {
        // The key of this cell is its number as it is. Others take in an offset, by which a negative zero
        // becomes a positive one, with other bits.
        let own = hash::unit8([self.floor[0]]) * self.points.randomness;
        let distance = |side| ((own + self.point(&Offset::all([side; N]))[0]) / 2.0 - self.local[0]).abs();
        distance(-1).min(distance(1))
    }

    /// Half the distance from the nearest point to the point that is nearest to it.
    #[inline(never)]
    pub fn radius(&self) -> F32x8 {
        let nearest = self.nearest(|vector| dot(vector, vector));
        let mut least = F32x8::splat(f32::MAX);
        around(1, |offset: [i32; N]| {
            if offset != [0; N] {
                let beside = |axis| nearest.offset[axis] + offset[axis] as f32;
                let vector = difference(nearest.point, self.point(&Offset::each(array::from_fn(beside))));
                least = dot(vector, vector).min(least);
            }
        });
        least.sqrt() / 2.0
    }

    #[inline(always)]
    fn nearest(&self, rank: impl Fn([F32x8; N]) -> F32x8) -> Near<N> {
        let mut nearest = Near::none();
        let near = |offset: &Offset<N>| self.near(offset, &rank);
        self.each_cell(1, near, |near| {
            nearest = near.where_or(near.distance.lt(nearest.distance), nearest);
        });
        nearest
    }

    /// The point of a cell, as far away as `distance` says.
    #[inline(always)]
    fn near(&self, offset: &Offset<N>, distance: impl Fn([F32x8; N]) -> F32x8) -> Near<N> {
        let point = self.point(offset);
        Near { distance: distance(difference(point, self.local)), offset: offset.floats, point }
    }

    fn found(&self, near: Near<N>) -> Found<N> {
        let position = sum_of(near.point, self.floor);
        Found { distance: near.distance, color: self.color(&Offset::each(near.offset)), position }
    }

    /// The point of a cell, from the corner of the place's cell.
    #[inline(always)]
    fn point(&self, Offset { floats, in_hash }: &Offset<N>) -> [F32x8; N] {
        let random = if N == 1 { [hash::unit8([self.line_key(*floats)]); N] } else { self.hash.at(*in_hash) };
        array::from_fn(|axis| floats[axis] + random[axis] * self.points.randomness)
    }

    /// The random colour of a cell, each part 0 to 1.
    #[inline(always)]
    fn color(&self, Offset { floats, in_hash }: &Offset<N>) -> Vec3x8 {
        if N == 1 {
            let key = self.line_key(*floats);
            let part = |number: f32| hash::unit8([key, F32x8::splat(number)]);
            return Vec3x8::from([hash::unit8([key]), part(1.0), part(2.0)]);
        }
        if N == 4 {
            let [red, green, blue, _] = self.hash.with_axes(*in_hash);
            return [red, green, blue].into();
        }
        self.hash.with_axes::<3>(*in_hash).into()
    }

    /// Of one axis, the other hash is used, of the cell as a float.
    #[inline(always)]
    fn line_key(&self, offset: [F32x8; N]) -> F32x8 {
        self.floor[0] + offset[0]
    }
}
