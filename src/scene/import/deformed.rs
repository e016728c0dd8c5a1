//! Meshes of files that state their own deformation: skins, morph targets, points with times.

use std::collections::HashMap;
use std::sync::Arc;

use embree::VertexBuffer;
use glam::Vec3;

use crate::animation::ShapeTrack;
use crate::digest::Digest;
use crate::scene::{Mesh, Shapes};

/// Distinct shapes: equal ones are stored once.
#[derive(Default)]
pub(in crate::scene) struct Distinct {
    pub list: Vec<Vec<[f32; 3]>>,
    /// Times in order, and numbers of shapes.
    pub keys: Vec<(f64, u32)>,
    /// Numbers of the shapes by digest of their content.
    known: HashMap<Digest, Vec<u32>>,
}

impl Distinct {
    /// Adds the shape of a time.
    pub fn add(&mut self, time: f64, shape: Vec<[f32; 3]>) {
        let Self { list, keys, known } = self;
        let same = known.entry(Digest::new(bytemuck::cast_slice(&shape))).or_default();
        let before = same.iter().find(|number| list[**number as usize] == shape).copied();
        let number = before.unwrap_or(list.len() as u32);
        if before.is_none() {
            same.push(number);
            list.push(shape);
        }
        keys.push((time, number));
    }
}

/// The shape in which the samples of a mesh are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::scene) enum Kept {
    /// That of the file.
    AtRest,
    /// One of its shapes, by number.
    Shape(usize),
}

impl Kept {
    /// Positions of the vertices in a shape; none for that of the file.
    pub fn among(self, shapes: &Distinct) -> Option<&[[f32; 3]]> {
        match self {
            Self::AtRest => None,
            Self::Shape(number) => Some(&shapes.list[number]),
        }
    }
}

/// Returns true if a triangle has an area.
pub(in crate::scene) fn has_area(positions: &[[f32; 3]], triangle: [u32; 3]) -> bool {
    let [a, b, c] = triangle.map(|corner| Vec3::from(positions[corner as usize]).as_dvec3());
    (b - a).cross(c - a).length_squared() > 0.0
}

/// Removes the triangles that have no area where the vertices are at these positions. `uses`: runs of consecutive triangles, their number
/// first; those that become empty go.
pub(in crate::scene) fn remove_closed<T>(
    positions: &[[f32; 3]],
    triangles: &mut Vec<[u32; 3]>,
    uses: &mut Vec<(usize, T)>,
) {
    let mut begin = 0;
    let mut open = Vec::with_capacity(triangles.len());
    for (count, _) in uses.iter_mut() {
        let (all, before) = (&triangles[begin..begin + *count], open.len());
        open.extend(all.iter().copied().filter(|triangle| has_area(positions, *triangle)));
        begin += *count;
        *count = open.len() - before;
    }
    *triangles = open;
    uses.retain(|(count, _)| *count > 0);
}

/// The shape in which no triangle is closed up to a line, or as few as possible: the first one, if that is as good as others, since a
/// mesh may be bound at another scale than it is seen. `rest`: positions of the vertices in the file; there is a shape at least.
pub(in crate::scene) fn most_open(rest: &[[f32; 3]], triangles: &[[u32; 3]], shapes: &Distinct) -> Kept {
    if shapes.list.len() == 1 {
        return Kept::Shape(0);
    }
    let all = || [Kept::Shape(0), Kept::AtRest].into_iter().chain((1..shapes.list.len()).map(Kept::Shape));
    let is_closed = |kept: Kept, triangle: [u32; 3]| !has_area(kept.among(shapes).unwrap_or(rest), triangle);
    let triangles = || triangles.iter().copied();
    // most meshes that have any closed at first, at the poles of a sphere say, never open them
    let opens = |triangle: [u32; 3]| all().any(|kept| !is_closed(kept, triangle));
    if !triangles().filter(|triangle| is_closed(Kept::Shape(0), *triangle)).any(opens) {
        return Kept::Shape(0);
    }
    let closed = |kept: &Kept| triangles().filter(|triangle| is_closed(*kept, *triangle)).count();
    all().min_by_key(closed).unwrap_or(Kept::Shape(0))
}

/// Gives a mesh its shapes; one alone becomes its own shape. `kept`: the one in which its samples are kept, in which all its triangles
/// have an area. `places`: see [`Shapes::new`].
pub(in crate::scene) fn with_shapes(
    mesh: Mesh,
    shapes: Distinct,
    kept: Kept,
    places: &[u32],
) -> (Mesh, Option<ShapeTrack>) {
    let own = kept.among(&shapes).map(<[_]>::to_vec);
    let Distinct { list, keys, .. } = shapes;
    let Some(triangles) = mesh.as_triangles() else { return (mesh, None) };
    if list.len() == 1 && list[0] == triangles.positions.as_slice() {
        return (mesh, None);
    }
    let count = list.len();
    let shapes = Shapes::new(list, &triangles.corners, &triangles.normals, places);
    let mesh = mesh.with_triangles(|triangles| {
        if let Some(positions) = own {
            triangles.normals = shapes.normals(&positions, &triangles.corners);
            triangles.positions = Arc::new(VertexBuffer::new(positions));
        }
        if count > 1 {
            triangles.shapes = Some(Arc::new(shapes));
        }
    });
    let track = if count > 1 { ShapeTrack::through(keys, None) } else { None };
    (mesh, track)
}

/// Numbers of the vertices' places, for files that do not tell: vertices that are at one place at rest and in the first, the middle and
/// the last shape are at one place in all of them, and share their normal if they have the same one.
pub(in crate::scene) fn places(rest: &[[f32; 3]], list: &[Vec<[f32; 3]>]) -> Vec<u32> {
    let mut places = vec![0; rest.len()];
    let some = [list.first(), list.get(list.len() / 2), list.last()];
    for positions in std::iter::once(rest).chain(some.into_iter().flatten().map(Vec::as_slice)) {
        let mut numbers = HashMap::new();
        for (place, position) in places.iter_mut().zip(positions) {
            let next = numbers.len() as u32;
            *place = *numbers.entry((*place, position.map(f32::to_bits))).or_insert(next);
        }
    }
    places
}
