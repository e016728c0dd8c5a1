//! Boxes around parts of a mesh: they contain all that moves, and only where they are touched may anything
//! change.

use glam::Vec3;
use rayon::prelude::*;

use super::split::{Around, Leaf, Split, parts};
use crate::animation::{Chord, Shape};
use crate::geometry::{Bounds, Curved};
use crate::scene::{Mesh, Shapes, Triangles};

/// Largest number of boxes of a mesh: several give fewer false alarms where it is round, thin or hollow. With
/// 256 a ball that flies through a room has a tenth fewer rays of paths than with 64.
pub const MOST_BOXES: usize = 256;

/// Boxes around the parts of a mesh, object space. The parts are the same triangles in all of its shapes.
#[derive(Debug)]
pub struct PartBoxes {
    /// Boxes by shape and part; a mesh that does not deform has one shape.
    in_shapes: Vec<Vec<Bounds>>,
}

impl PartBoxes {
    /// Creates up to `most` boxes for each shape of `mesh`, which contain all its primitives.
    pub fn new(mesh: &Mesh, most: usize) -> Self {
        if let Some(curved) = mesh.as_curved().filter(|curved| curved.shapes() > 0) {
            return Self::of_curved(curved.as_ref(), most);
        }
        let Some((triangles, shapes)) = mesh.as_triangles().and_then(|all| Some((all, all.shapes.as_ref()?)))
        else {
            return Self { in_shapes: vec![boxes_of(mesh, most)] };
        };
        let middle = |triangle: &u32| -> Vec3 { triangles.positions_of(*triangle).iter().sum() };
        let parts = parts_of(triangles.corners.len(), middle, most);
        let in_shape = |positions: &Vec<[f32; 3]>| -> Vec<Bounds> {
            let corners =
                |triangle: &u32| triangles.corners[*triangle as usize].map(|at| positions[at as usize]);
            let around = |part: &Vec<u32>| {
                let all = part.iter().flat_map(corners).map(Vec3::from_array);
                all.fold(Bounds::EMPTY, Bounds::with)
            };
            parts.iter().map(around).collect()
        };
        Self { in_shapes: Shapes::list(shapes).par_iter().map(in_shape).collect() }
    }

    /// Boxes for each shape of a geometry.
    fn of_curved(curved: &dyn Curved, most: usize) -> Self {
        let middle = |primitive: &u32| {
            let Bounds { low, high } = curved.bounds_in_shape(*primitive, 0);
            low + high
        };
        let parts = parts_of(curved.count() as usize, middle, most);
        let in_shape = |shape: u32| -> Vec<Bounds> {
            let around = |part: &Vec<u32>| {
                part.iter()
                    .map(|primitive| curved.bounds_in_shape(*primitive, shape))
                    .fold(Bounds::EMPTY, Bounds::union)
            };
            parts.iter().map(around).collect()
        };
        Self { in_shapes: (0..curved.shapes()).into_par_iter().map(in_shape).collect() }
    }

    /// Number of boxes in a shape.
    pub fn count(&self) -> usize {
        self.in_shapes[0].len()
    }

    /// Boxes around the parts at a place on the way between two shapes.
    pub fn on(&self, chord: &Chord) -> impl Iterator<Item = Bounds> + '_ {
        let [open, close] = chord.ends.map(|shape| self.in_shape(shape));
        let chord = *chord;
        open.zip(close).map(move |(open, close)| Bounds {
            low: moved(chord.point([open.low, close.low]), -f32::EPSILON),
            high: moved(chord.point([open.high, close.high]), f32::EPSILON),
        })
    }

    /// Boxes around the parts in `shape`. Corners move straight from shape to shape, and so do boxes: in
    /// between, corners are within the interpolated boxes, but for a rounding by one float.
    fn in_shape(&self, shape: Shape) -> impl Iterator<Item = Bounds> + '_ {
        let [from, to] = [shape.from, shape.to].map(|number| &self.in_shapes[number as usize]);
        from.iter().zip(to).map(move |(from, to)| Bounds {
            low: moved(shape.between(from.low, to.low), -f32::EPSILON),
            high: moved(shape.between(from.high, to.high), f32::EPSILON),
        })
    }
}

/// Moves `point` by a share of its coordinates, upwards or downwards.
fn moved(point: Vec3, by: f32) -> Vec3 {
    point + point.abs() * by
}

/// Divides so many primitives into up to `most` lists of about the same length, each of such whose middles lie together.
fn parts_of(count: usize, middle: impl Fn(&u32) -> Vec3, most: usize) -> Vec<Vec<u32>> {
    let mut numbers: Vec<u32> = (0..count as u32).collect();
    let mut open = vec![(numbers.as_mut_slice(), most.min(count))];
    let mut parts = Vec::new();
    while let Some((part, count)) = open.pop() {
        if count <= 1 {
            parts.push(part.to_vec());
            continue;
        }
        let around = part.iter().map(&middle).fold(Bounds::EMPTY, Bounds::with);
        let axis = (around.high - around.low).max_position();
        let at = part.len() * (count / 2) / count;
        part.select_nth_unstable_by(at, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
        let (left, right) = part.split_at_mut(at);
        open.extend([(left, count / 2), (right, count - count / 2)]);
    }
    parts
}

/// Three corners of a triangle, object space.
type Corners = [Vec3; 3];

/// Number of boxes [of](PartBoxes::new) a mesh.
pub fn count_of_boxes(mesh: &Mesh, most: usize) -> usize {
    if to_cut(mesh, most).is_some() { most } else { most.min(mesh.count()) }
}

/// The triangles of `mesh`, if they are cut to pieces. Parts of a mesh that deforms are whole triangles, and
/// those of curved geometry whole primitives.
fn to_cut(mesh: &Mesh, most: usize) -> Option<&Triangles> {
    let is_cut = |all: &&Triangles| all.shapes.is_none() && (1..most).contains(&all.corners.len());
    mesh.as_triangles().filter(is_cut)
}

/// Creates up to `most` boxes, object space, that contain all primitives of `mesh`: the top of a hierarchy
/// over them. If triangles are few they are cut to as many pieces: a box around a large one that is turned is
/// mostly empty.
pub fn boxes_of(mesh: &Mesh, most: usize) -> Vec<Bounds> {
    if let Some(triangles) = to_cut(mesh, most) {
        let all = 0..triangles.corners.len() as u32;
        let pieces = pieces(all.map(|triangle| triangles.positions_of(triangle)).collect(), most);
        return pieces.into_iter().map(|piece| piece.into_iter().fold(Bounds::EMPTY, Bounds::with)).collect();
    }
    let leaf = |bounds: Bounds| Leaf { bounds, first: 0, second: 0, last: 0 };
    let all = (0..mesh.count() as u32).into_par_iter();
    let mut leaves: Vec<Leaf> = all.map(|primitive| leaf(mesh.geometry.bounds(primitive))).collect();
    let parts = parts(&mut leaves, most, Split::Best { patience: 1.0, together: 1 });
    parts.iter().map(|part| Around::new(part).bounds).collect()
}

/// Cuts `triangles` to `count` pieces: always the one with the longest edge, in the middle of that. The
/// rounding of middles is far less than the [room](Bounds::placed) around boxes.
fn pieces(mut triangles: Vec<Corners>, count: usize) -> Vec<Corners> {
    let edge = |[a, b, c]: &Corners| [a.distance_squared(*b), b.distance_squared(*c), c.distance_squared(*a)];
    let longest = |triangle: &Corners| edge(triangle).into_iter().fold(0.0, f32::max);
    while triangles.len() < count {
        let all = triangles.iter().enumerate();
        let Some((number, _)) = all.max_by(|a, b| longest(a.1).total_cmp(&longest(b.1))) else { break };
        let triangle = triangles[number];
        let edges = edge(&triangle);
        let first = (0..3).max_by(|a, b| edges[*a].total_cmp(&edges[*b])).unwrap_or(0);
        let [a, b, c] = [0, 1, 2].map(|corner| triangle[(first + corner) % 3]);
        let middle = a.midpoint(b);
        triangles[number] = [a, middle, c];
        triangles.push([middle, b, c]);
    }
    triangles
}
