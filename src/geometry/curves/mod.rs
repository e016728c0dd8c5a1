//! Curves with a thickness: hair, fur, grass, wires.
//!
//! A curve is a chain of points with radii; a primitive is the [`hull`] of the spheres around two that follow each other. Cubic curves
//! become such chains when they are read. Rays meet a curve where they *enter* it, and pass what they leave: so light that is sent on through a
//! hair starts on it and does not meet it again, in whichever of its pieces. Where a ray would enter a piece within the piece before or behind
//! it, there is no surface of the curve, and it passes that, too.
//!
//! Points are single floats: 16 bytes each, and 4 bytes a primitive. A map that keeps angles moves the points; any other one is kept beside
//! them, and rays are taken into the space of the points. Curves may deform: see [`shapes`].

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};

use super::Bounds;
use super::curved::{Curved, FOUR, Meeting, Ray};
use super::tree::{Box3, Child, Tree, WIDTH};
use crate::animation::Shape;
use hull::Hull;
use shapes::Later;

mod hull;
mod lengths;
mod shapes;

/// Curves of a mesh, in object space.
#[derive(Debug, Clone)]
pub struct Curves {
    own: Arc<Points>,
    chains: Arc<Chains>,
    /// Points in each of their shapes, if they deform.
    shapes: Option<Arc<Vec<Arc<Points>>>>,
    /// What the points go to, if they are on the way between two shapes.
    later: Option<Later>,
    /// Map from the space of the points to object space and back, where they differ.
    place: Option<Box<Place>>,
    /// Tree over the primitives, for those [near](Curved::near) a point; made when it is first asked.
    tree: Arc<OnceLock<Tree>>,
}

#[derive(Debug)]
struct Points {
    /// Places and radii, curve after curve.
    all: Vec<[f32; 4]>,
    /// Greatest radius.
    most_radius: f32,
    /// See [`lengths`]; made when it is first asked.
    ways: OnceLock<Vec<f64>>,
}

/// Which points make curves.
#[derive(Debug)]
struct Chains {
    /// First point of each primitive; its other one follows.
    firsts: Vec<u32>,
    /// First primitive of each curve, in order.
    curves: Vec<u32>,
    /// Texture coordinates of each curve, or none.
    uvs: Vec<Vec2>,
    /// Boxes of a primitive.
    boxes: u32,
}

#[derive(Debug, Clone, Copy)]
struct Place {
    map: DAffine3,
    inverse: DAffine3,
}

/// Radii that a piece of a primitive is long for which a tree has a box, and most boxes of a primitive: askew, the box of a hair is mostly empty, and rays
/// are tested against all whose boxes they pass through.
const RADII_OF_BOX: f32 = 16.0;
const MOST_BOXES: u32 = 4;

impl Points {
    fn new(all: Vec<[f32; 4]>) -> Self {
        let most_radius = all.iter().map(|point| point[3]).fold(0.0, f32::max);
        Self { all, most_radius, ways: OnceLock::new() }
    }

    /// The points after `map`, in whose space lengths are `scale` times as large.
    fn mapped(&self, map: &DAffine3, scale: f64) -> Self {
        let moved = |[x, y, z, radius]: [f64; 4]| {
            let [x, y, z] = map.transform_point3(DVec3::new(x, y, z)).to_array();
            [x, y, z, radius * scale].map(|value| value as f32)
        };
        let all = self.all.iter().map(|point| moved(point.map(f64::from))).collect();
        let most_radius = (f64::from(self.most_radius) * scale) as f32;
        Self { all, most_radius, ways: OnceLock::new() }
    }

    /// Number of boxes that suit the most of the primitives that begin at these points.
    fn boxes_wanted(&self, firsts: &[u32]) -> u32 {
        let (mut length, mut radii) = (0.0_f64, 0.0_f64);
        for first in firsts {
            let [a, b] = [*first, *first + 1].map(|at| &self.all[at as usize]);
            length += f64::from(Vec3::from_slice(a).distance(Vec3::from_slice(b)));
            radii += f64::from(a[3].max(b[3]));
        }
        let ratio = (length / radii.max(f64::MIN_POSITIVE)) as f32;
        ((ratio / RADII_OF_BOX) as u32).clamp(1, MOST_BOXES)
    }
}

/// Room of a box for rounding to single floats, as a share of a coordinate.
const BOX_ROOM: f64 = 2e-7;

/// The same of points that are on the way between two, which is a sum and a product more.
const BOX_ROOM_BETWEEN: f64 = 8e-7;

/// How deep in a neighbour a place of a piece must lie to count as within the curve, as a share of the radius: less is rounding.
const WITHIN: f64 = 1e-4;

/// Room for the rounding of double floats where lines that pass by are told.
const ROUNDING: f64 = 1e-6;

/// How deep rays start within a fibre, as a share of its radius: far more than the rounding of coordinates, unless they are ten thousand times as
/// large as the fibre is thick.
const INSIDE: f64 = 0.25;

/// By how much the axes of a map may differ in length and angle to count as those of one that keeps angles.
const SAME_ANGLES: f64 = 1e-9;

impl Curves {
    /// Creates curves of these points and radii (finite, not below 0), curve after curve, of `counts` points each. Points in the place of the one before
    /// are left out, and curves of which less than two remain; `uvs`: texture coordinates of each curve, or none. Returns, too, the numbers of the points that remain.
    /// `None` if no curve remains.
    pub fn new(points: &[[f32; 4]], counts: &[u32], uvs: &[Vec2]) -> Option<(Self, Vec<u32>)> {
        let (mut all, mut kept): (Vec<[f32; 4]>, Vec<u32>) = (Vec::new(), Vec::new());
        let mut chains = Chains { firsts: Vec::new(), curves: Vec::new(), uvs: Vec::new(), boxes: 1 };
        for (curve, numbers) in in_space(points, counts) {
            let begin = all.len();
            for number in numbers {
                let point = points[number as usize];
                if all.len() > begin && all[all.len() - 1][..3] == point[..3] {
                    continue;
                }
                all.push(point);
                kept.push(number);
            }
            if all.len() < begin + 2 {
                all.truncate(begin);
                kept.truncate(begin);
                continue;
            }
            chains.curves.push(chains.firsts.len() as u32);
            chains.firsts.extend(begin as u32..all.len() as u32 - 1);
            chains.uvs.extend(uvs.get(curve));
        }
        let own = Points::new(all);
        chains.boxes = own.boxes_wanted(&chains.firsts);
        let curves = Self {
            own: Arc::new(own),
            chains: Arc::new(chains),
            shapes: None,
            later: None,
            place: None,
            tree: Arc::default(),
        };
        (!curves.chains.firsts.is_empty()).then_some((curves, kept))
    }

    /// Number of the curves.
    pub fn curves(&self) -> usize {
        self.chains.curves.len()
    }

    /// Direction of a primitive from its beginning to its end, of unit length, object space.
    fn along(&self, primitive: u32) -> DVec3 {
        let axis = self.hull(primitive).1.axis();
        self.place.as_ref().map_or(axis, |place| place.map.transform_vector3(axis).normalize_or(axis))
    }

    fn number(&self, primitive: u32) -> usize {
        (primitive as usize).min(self.chains.firsts.len() - 1)
    }

    /// First point of a primitive.
    #[inline(always)]
    fn first(&self, primitive: u32) -> usize {
        self.chains.firsts[self.number(primitive)] as usize
    }

    /// Places and radii at both ends of a primitive.
    #[inline(always)]
    fn ends(&self, primitive: u32) -> [[f64; 4]; 2] {
        let first = self.first(primitive);
        let ends = [self.own.all[first], self.own.all[first + 1]];
        match &self.later {
            None => ends,
            Some(later) => later.between(first, ends),
        }
        .map(|point| point.map(f64::from))
    }

    /// Centre of the first sphere of a primitive, in the space of the points, and the hull around there.
    #[inline]
    fn hull(&self, primitive: u32) -> (DVec3, Hull) {
        let [[x, y, z, radius], [to_x, to_y, to_z, other]] = self.ends(primitive);
        let from = DVec3::new(x, y, z);
        (from, Hull::new(DVec3::new(to_x, to_y, to_z) - from, [radius, other]))
    }

    /// Returns true if a line, in the space of the points, is farther from the axis of a primitive than its greatest radius: so are most whose box
    /// it passes through, for a hair is far thinner than its box. It asks for no root and no quotient.
    #[inline]
    fn passes_by(&self, primitive: u32, origin: DVec3, direction: DVec3) -> bool {
        let [[x, y, z, radius], [to_x, to_y, to_z, other]] = self.ends(primitive);
        let from = DVec3::new(x, y, z);
        let across = direction.cross(DVec3::new(to_x, to_y, to_z) - from);
        let off = across.dot(origin - from);
        let radius = radius.max(other) * (1.0 + ROUNDING);
        off * off > radius * radius * across.length_squared()
    }

    /// The primitives before and behind a primitive on its curve.
    fn neighbours(&self, primitive: u32) -> impl Iterator<Item = u32> {
        let (number, firsts) = (self.number(primitive), &self.chains.firsts);
        let follows =
            |before: usize| firsts.get(before + 1).is_some_and(|first| *first == firsts[before] + 1);
        let before = number.checked_sub(1).filter(|before| follows(*before));
        let behind = Some(number + 1).filter(|_| follows(number));
        before.into_iter().chain(behind).map(|number| number as u32)
    }

    /// Returns true if a point of a primitive, in the space of the points, lies within its curve.
    fn is_within(&self, primitive: u32, point: DVec3) -> bool {
        self.neighbours(primitive).any(|other| {
            let (from, hull) = self.hull(other);
            hull.beyond(point - from) < -WITHIN * hull.most_radius()
        })
    }

    /// Box around spheres with these centres and radii, object space.
    fn around(&self, spheres: [[f64; 4]; 2]) -> Bounds {
        let rows = self.stretch();
        let room = if self.later.is_some() { BOX_ROOM_BETWEEN } else { BOX_ROOM };
        spheres.into_iter().fold(Bounds::EMPTY, |bounds, [x, y, z, radius]| {
            let center = self.object_space(DVec3::new(x, y, z));
            let reach = DVec3::from_array(rows) * radius;
            let room = (center.abs() + reach) * room;
            bounds.with((center - reach - room).as_vec3()).with((center + reach + room).as_vec3())
        })
    }

    /// How much further a sphere reaches along each axis of object space than in the space of the points.
    fn stretch(&self) -> [f64; 3] {
        self.place.as_ref().map_or([1.0; 3], |place| {
            let [x, y, z] = [place.map.matrix3.x_axis, place.map.matrix3.y_axis, place.map.matrix3.z_axis];
            (x * x + y * y + z * z).to_array().map(f64::sqrt)
        })
    }

    fn own_space(&self, origin: DVec3, direction: DVec3) -> (DVec3, DVec3) {
        match &self.place {
            None => (origin, direction),
            Some(place) => {
                (place.inverse.transform_point3(origin), place.inverse.transform_vector3(direction))
            }
        }
    }

    fn object_space(&self, point: DVec3) -> DVec3 {
        self.place.as_ref().map_or(point, |place| place.map.transform_point3(point))
    }

    #[inline]
    fn meet_one(&self, primitive: u32, ray: &Ray) -> Option<Meeting> {
        let (origin, direction) = self.own_space(ray.origin.as_dvec3(), ray.direction.as_dvec3());
        if self.passes_by(primitive, origin, direction) {
            return None;
        }
        let (from, hull) = self.hull(primitive);
        let length = direction.length();
        let (origin, direction) = (origin - from, direction / length);
        let way = hull.enter(origin, direction)?;
        let t = (way / length) as f32;
        if !(t > ray.near && t <= ray.far) {
            return None;
        }
        if ray.ends_here {
            // the place at which the ray ends is the one where it enters, or the one where it leaves
            let leaves = hull.enter(origin, -direction).map_or(way, |back| -back);
            if (length - way).abs() <= (length - leaves).abs() {
                return None;
            }
        }
        let point = origin + direction * way;
        if self.is_within(primitive, point + from) {
            return None;
        }
        Some(Meeting { t, weights: hull.weights(point).map(|weight| weight as f32) })
    }

    fn curve_of(&self, primitive: usize) -> usize {
        self.chains.curves.partition_point(|first| *first as usize <= primitive) - 1
    }
}

impl Curved for Curves {
    fn name(&self) -> &'static str {
        "curves"
    }

    fn kind(&self) -> &'static str {
        "curves"
    }

    fn count(&self) -> u32 {
        self.chains.firsts.len() as u32
    }

    fn boxes(&self) -> u32 {
        self.chains.boxes
    }

    fn bounds_of_part(&self, primitive: u32, part: u32) -> Bounds {
        let ends = self.ends(primitive);
        let boxes = f64::from(self.chains.boxes);
        let at =
            |share: f64| std::array::from_fn(|axis| ends[0][axis] + (ends[1][axis] - ends[0][axis]) * share);
        self.around([at(f64::from(part) / boxes), at((f64::from(part) + 1.0) / boxes)])
    }

    fn bounds(&self, primitive: u32) -> Bounds {
        self.around(self.ends(primitive))
    }

    fn shapes(&self) -> u32 {
        self.shapes.as_ref().map_or(0, |shapes| shapes.len() as u32)
    }

    fn bounds_in_shape(&self, primitive: u32, shape: u32) -> Bounds {
        let Some(points) = self.shapes.as_ref().and_then(|shapes| shapes.get(shape as usize)) else {
            return self.bounds(primitive);
        };
        let first = self.first(primitive);
        self.around([points.all[first], points.all[first + 1]].map(|point| point.map(f64::from)))
    }

    fn between(&self, ends: &[Shape; 2], shares: &[f32]) -> Vec<Arc<dyn Curved>> {
        self.moments(ends, shares).into_iter().map(|moment| Arc::new(moment) as Arc<dyn Curved>).collect()
    }

    fn weights_of_normal(&self, primitive: u32, normal: Vec3) -> [f32; 2] {
        let normal = normal.as_dvec3();
        let own = match &self.place {
            None => normal,
            Some(place) => (place.map.matrix3.transpose() * normal).normalize_or(DVec3::Y),
        };
        self.hull(primitive).1.weights_of_normal(own).map(|weight| weight as f32)
    }

    fn axes(&self, primitive: u32) -> DMat3 {
        let hull = self.hull(primitive).1;
        let [x, y] = hull.frame();
        let axes = DMat3::from_cols(x, y, hull.axis());
        self.place.as_ref().map_or(axes, |place| place.map.matrix3 * axes)
    }

    fn meet_four(&self, primitive: u32, rays: &[Ray; FOUR]) -> (u8, [Meeting; FOUR]) {
        const NONE: Meeting = Meeting { t: 0.0, weights: [0.0; 2] };
        let (mut met, mut meetings) = (0, [NONE; FOUR]);
        for lane in 0..FOUR {
            // lanes without a ray repeat the last one
            if lane > 0 && rays[lane] == rays[lane - 1] {
                meetings[lane] = meetings[lane - 1];
                met |= (met >> (lane - 1) & 1) << lane;
            } else if let Some(meeting) = self.meet_one(primitive, &rays[lane]) {
                meetings[lane] = meeting;
                met |= 1 << lane;
            }
        }
        (met, meetings)
    }

    fn meet(&self, primitive: u32, ray: &Ray) -> Option<Meeting> {
        self.meet_one(primitive, ray)
    }

    fn meet_line(&self, primitive: u32, origin: DVec3, direction: DVec3, about: Vec3) -> Vec3 {
        let (from, hull) = self.hull(primitive);
        let (origin, direction) = self.own_space(origin, direction);
        let (about, _) = self.own_space(about.as_dvec3(), DVec3::ZERO);
        let (origin, direction) = (origin - from, direction.normalize_or(DVec3::Y));
        let expected = (about - from - origin).dot(direction);
        let places = [hull.enter(origin, direction), hull.enter(origin, -direction).map(|back| -back)];
        let nearest = places.into_iter().flatten();
        let nearest = nearest.min_by(|a, b| (a - expected).abs().total_cmp(&(b - expected).abs()));
        let met = nearest.map_or(about - from, |t| origin + direction * t);
        self.object_space(from + hull.point(hull.weights(met))).as_vec3()
    }

    fn point(&self, primitive: u32, weights: [f32; 2]) -> Vec3 {
        let (from, hull) = self.hull(primitive);
        self.object_space(from + hull.point(weights.map(f64::from))).as_vec3()
    }

    fn weights(&self, primitive: u32, point: Vec3) -> [f32; 2] {
        let (from, hull) = self.hull(primitive);
        let (own, _) = self.own_space(point.as_dvec3(), DVec3::ZERO);
        hull.weights(own - from).map(|weight| weight as f32)
    }

    fn distance(&self, primitive: u32, point: Vec3) -> f64 {
        let (from, hull) = self.hull(primitive);
        let (own, _) = self.own_space(point.as_dvec3(), DVec3::ZERO);
        let Some(place) = &self.place else { return hull.beyond(own - from).abs() };
        let on_surface = from + hull.point(hull.weights(own - from));
        place.map.transform_vector3(on_surface - own).length()
    }

    fn normal(&self, primitive: u32, weights: [f32; 2]) -> Vec3 {
        let normal = self.hull(primitive).1.normal(weights.map(f64::from));
        let Some(place) = &self.place else { return normal.as_vec3() };
        // by the transposed inverse: outward normals stay outward in mirror images
        (place.inverse.matrix3.transpose() * normal).normalize_or(DVec3::Y).as_vec3()
    }

    /// Those of the curve; where it has none the share of its length, from 0 at its beginning to 1, and 0.5.
    fn uv(&self, primitive: u32, [along, _]: [f32; 2]) -> Vec2 {
        match self.chains.uvs.get(self.curve_of(self.number(primitive))) {
            Some(uv) => *uv,
            None => Vec2::new(self.share(primitive, along), 0.5),
        }
    }

    fn mapped(&self, map: DAffine3) -> Arc<dyn Curved> {
        let whole = self.place.as_ref().map_or(map, |place| map * place.map);
        let (chains, tree) = (Arc::clone(&self.chains), Arc::default());
        let Some(scale) = scale_of(&whole) else {
            let place = Some(Box::new(Place { map: whole, inverse: whole.inverse() }));
            return Arc::new(Self { place, tree, ..self.clone() });
        };
        let mapped = |points: &Arc<Points>| Arc::new(points.mapped(&whole, scale));
        let shapes = self.shapes.as_ref().map(|shapes| Arc::new(shapes.iter().map(mapped).collect()));
        let later = self.later.as_ref().map(|later| Later { points: mapped(&later.points), ..*later });
        Arc::new(Self { own: mapped(&self.own), chains, shapes, later, place: None, tree })
    }

    fn bytes(&self) -> u64 {
        let Chains { firsts, curves, uvs, .. } = &*self.chains;
        let lists =
            [size_of_val(firsts.as_slice()), size_of_val(curves.as_slice()), size_of_val(uvs.as_slice())];
        let shapes = self.shapes.iter().flat_map(|shapes| shapes.iter());
        let points: usize = shapes.chain([&self.own]).map(|points| size_of_val(points.all.as_slice())).sum();
        (size_of::<Self>() + lists.into_iter().sum::<usize>() + points) as u64
    }

    fn vertices(&self, primitive: u32, [along, _]: [f32; 2]) -> Option<([u32; 2], f32)> {
        let first = self.first(primitive) as u32;
        Some(([first, first + 1], along.clamp(0.0, 1.0)))
    }

    fn tangent(&self, primitive: u32, _: [f32; 2]) -> Vec3 {
        self.along(primitive).as_vec3()
    }

    fn inside(&self, primitive: u32, weights: [f32; 2]) -> Option<Vec3> {
        let (from, hull) = self.hull(primitive);
        Some(self.object_space(from + hull.inside(weights.map(f64::from), INSIDE)).as_vec3())
    }

    fn most_radius(&self) -> f32 {
        // in any direction it is no more than along all axes together
        let [x, y, z] = self.stretch();
        self.greatest_radius()
            * if self.place.is_some() { (x * x + y * y + z * z).sqrt() as f32 } else { 1.0 }
    }

    fn near(&self, point: Vec3, reach: f32, found: &mut dyn FnMut(u32)) {
        let tree = self.tree.get_or_init(|| {
            let boxes: Vec<Box3> = (0..self.count())
                .map(|primitive| {
                    let Bounds { low, high } = self.bounds(primitive);
                    Box3 { low: low.to_array(), high: high.to_array() }
                })
                .collect();
            Tree::quick(&boxes, 1, |ids| ids[0])
        });
        let mut open = if tree.nodes.is_empty() { Vec::new() } else { vec![Child::ROOT] };
        while let Some(child) = open.pop() {
            let node = match child.open() {
                Ok(primitive) => {
                    found(primitive);
                    continue;
                }
                Err(node) => &tree.nodes[node],
            };
            let is_near = |slot: &usize| {
                (0..3).all(|axis| {
                    node.planes[axis][*slot] - reach <= point[axis]
                        && point[axis] <= node.planes[axis + 3][*slot] + reach
                })
            };
            open.extend((0..WIDTH).filter(is_near).map(|slot| node.children[slot]));
        }
    }
}

/// Numbers of the curves with the ranges of their points, in the order of a curve that fills space (G. Morton, 1966): what lies together is read
/// together.
fn in_space(points: &[[f32; 4]], counts: &[u32]) -> Vec<(usize, Range<u32>)> {
    let mut first = 0;
    let ranges = counts.iter().map(|count| {
        let all = first..first + count;
        first += count;
        all
    });
    let ranges: Vec<Range<u32>> = ranges.collect();
    let middle = |all: &Range<u32>| {
        let at = (all.start + (all.end - all.start) / 2).min((points.len() as u32).saturating_sub(1));
        points.get(at as usize).map_or(Vec3::ZERO, |point| Vec3::from_slice(point))
    };
    let around = ranges.iter().map(middle).fold(Bounds::EMPTY, Bounds::with);
    let scale = 1023.0 / (around.high - around.low).max(Vec3::splat(f32::MIN_POSITIVE));
    let place = |all: &Range<u32>| {
        let cell = ((middle(all) - around.low) * scale).to_array().map(|along| along as u32);
        let spread = |axis: usize| {
            (0..10).fold(0_u32, |bits, bit| bits | (cell[axis] >> bit & 1) << (3 * bit + axis as u32))
        };
        spread(0) | spread(1) | spread(2)
    };
    let mut order: Vec<(u32, usize)> = ranges.iter().map(place).zip(0..).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, curve)| (curve, ranges[curve].clone())).collect()
}

/// Factor of all lengths under a map that keeps angles; `None` of any other map.
fn scale_of(map: &DAffine3) -> Option<f64> {
    let axes = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
    let squares = axes.map(|axis| axis.length_squared());
    let mean = squares.iter().sum::<f64>() / 3.0;
    let angles = [axes[0].dot(axes[1]), axes[1].dot(axes[2]), axes[2].dot(axes[0])];
    let same = squares.iter().all(|square| (square - mean).abs() <= SAME_ANGLES * mean)
        && angles.iter().all(|dot| dot.abs() <= SAME_ANGLES * mean);
    same.then(|| mean.sqrt())
}

#[cfg(test)]
mod tests;
