//! Meshes that deform: vertex positions in each shape, and the vertices that share a normal.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::animation::Shape;
use crate::geometry::vertex_normal::Face;
use crate::memory::{self, Need, Part, TooLittle};

/// Number for vertices that have no normal.
const NONE: u32 = u32::MAX;

/// The shapes of a mesh that deforms.
#[derive(Debug, Clone)]
pub struct Shapes {
    /// Vertex positions by shape: object space, finite. Never empty.
    list: Vec<Vec<[f32; 3]>>,
    /// Shared normals of a mesh that has any.
    normals: Option<SharedNormals>,
}

/// Vertices that share a normal, and the corners of triangles of which that normal is the mean.
#[derive(Debug, Clone)]
struct SharedNormals {
    /// Number of each vertex's normal, or [`NONE`].
    of_vertex: Vec<u32>,
    /// First entry of each normal in `corners`; at the end the length of that list.
    begins: Vec<u32>,
    /// Triangles around each normal, in order, each with that of its corners which is there: 0, 1 or 2.
    corners: Vec<(u32, u8)>,
}

impl Shapes {
    /// Creates shapes of a mesh without normals, or with the `normals` of its vertices in the shape at rest
    /// (zero: none). `places`: by vertex, a number that tells its place; vertices of one place and one normal
    /// share their normal in all shapes.
    ///
    /// `list`: at least one shape, each with as many positions as there are `places`.
    pub fn new(list: Vec<Vec<[f32; 3]>>, triangles: &[[u32; 3]], normals: &[Vec3], places: &[u32]) -> Self {
        assert!(!list.is_empty() && list.iter().all(|shape| shape.len() == places.len()), "shapes must fit");
        let normals = (!normals.is_empty()).then(|| SharedNormals::new(triangles, normals, places));
        Self { list, normals }
    }

    /// Checks that there is memory for so many shapes of so many vertices.
    ///
    /// # Errors If there is not.
    pub fn check_memory(shapes: usize, vertices: usize) -> Result<(), TooLittle> {
        let bytes = (shapes * size_of::<[f32; 3]>()) as u64 * vertices as u64;
        let remedy = "a shorter animation or fewer shapes, a smaller model";
        Need::new(Part::new("the shapes of the model", bytes, remedy)).check(&memory::left())
    }

    /// Vertex positions of each shape, object space.
    pub fn list(&self) -> &[Vec<[f32; 3]>] {
        &self.list
    }

    /// Vertex positions in `shape`, object space. The list has room for one more.
    ///
    /// Tracers and the placement of samples both take them from here, so that the floats are the same.
    pub fn positions(&self, shape: &Shape) -> Vec<[f32; 3]> {
        let [from, to] = [shape.from, shape.to].map(|number| &self.list[number as usize]);
        let mut positions = Vec::with_capacity(from.len() + 1);
        if from.as_ptr() == to.as_ptr() {
            positions.extend_from_slice(from);
            return positions;
        }
        let between = |(from, to): (&[f32; 3], &[f32; 3])| {
            shape.between(Vec3::from_array(*from), Vec3::from_array(*to)).to_array()
        };
        positions.par_extend(from.par_iter().zip(to).map(between));
        positions
    }

    /// Computes the normals of the vertices at these `positions`: unit length, or zero if there is none.
    /// Empty for a flat mesh. Each is the mean of the normals of the triangles around it, weighted by their
    /// [angles](Face) there.
    pub fn normals(&self, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<Vec3> {
        let Some(shared) = &self.normals else { return Vec::new() };
        let place = |corner: u32| Vec3::from_array(positions[corner as usize]).as_dvec3();
        // each triangle once, in order: around a vertex they are all over the memory
        let faces: Vec<Face> = triangles.par_iter().map(|corners| Face::new(corners.map(place))).collect();
        let share = |(triangle, corner): &(u32, u8)| faces[*triangle as usize].share((*corner).into());
        let mean = |ends: &[u32]| {
            let around = &shared.corners[ends[0] as usize..ends[1] as usize];
            around.iter().map(share).sum::<DVec3>().normalize_or_zero().as_vec3()
        };
        let normals: Vec<Vec3> = shared.begins.par_windows(2).map(mean).collect();
        let of_vertex = |number: &u32| normals.get(*number as usize).copied().unwrap_or(Vec3::ZERO);
        shared.of_vertex.par_iter().map(of_vertex).collect()
    }
}

impl SharedNormals {
    fn new(triangles: &[[u32; 3]], normals: &[Vec3], places: &[u32]) -> Self {
        let mut numbers = HashMap::new();
        let number = |(normal, place): (&Vec3, &u32)| {
            if *normal == Vec3::ZERO {
                return NONE;
            }
            let next = numbers.len() as u32;
            *numbers.entry((*place, normal.to_array().map(f32::to_bits))).or_insert(next)
        };
        let of_vertex: Vec<u32> = normals.iter().zip(places).map(number).collect();
        let mut begins = vec![0; numbers.len() + 1];
        let corners = || {
            (0_u32..).zip(triangles).flat_map(|(triangle, of)| {
                [0, 1, 2].map(|corner| (triangle, corner, of[usize::from(corner)]))
            })
        };
        let known = |(triangle, corner, vertex): (u32, u8, u32)| {
            let number = of_vertex[vertex as usize];
            (number != NONE).then_some(((triangle, corner), number as usize))
        };
        corners().filter_map(known).for_each(|(_, number)| begins[number + 1] += 1);
        let mut sum = 0;
        begins.iter_mut().for_each(|begin| {
            sum += *begin;
            *begin = sum;
        });
        let (mut next, mut around) = (begins.clone(), vec![(0, 0); sum as usize]);
        for (corner, number) in corners().filter_map(known) {
            around[next[number] as usize] = corner;
            next[number] += 1;
        }
        Self { of_vertex, begins, corners: around }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares that meet at an edge, from x = 0 to 2: flat, and bent up by a right angle at x = 1.
    fn strip(normals: &[Vec3]) -> Shapes {
        let rest =
            vec![[0., 0., 0.], [0., 0., -1.], [1., 0., 0.], [1., 0., -1.], [2., 0., 0.], [2., 0., -1.]];
        let mut bent = rest.clone();
        (bent[4], bent[5]) = ([1., 1., 0.], [1., 1., -1.]);
        Shapes::new(vec![rest, bent], &TRIANGLES, normals, &[0, 1, 2, 3, 4, 5])
    }

    const TRIANGLES: [[u32; 3]; 4] = [[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]];

    #[test]
    fn vertices_go_straight_from_shape_to_shape() {
        let shapes = strip(&[]);
        let half = shapes.positions(&Shape { from: 0, to: 1, share: 0.5 });
        assert_eq!((half[4], half[2]), ([1.5, 0.5, 0.0], [1.0, 0.0, 0.0]));
        assert_eq!(shapes.positions(&Shape::alone(1)), shapes.list()[1]);
        assert!(shapes.normals(&half, &TRIANGLES).is_empty());
    }

    #[test]
    fn a_shared_normal_is_the_mean_of_what_is_around_it() {
        let shapes = strip(&[Vec3::Y; 6]);
        let flat = shapes.normals(&shapes.list()[0], &TRIANGLES);
        assert_eq!(flat, [Vec3::Y; 6]);
        let bent = shapes.normals(&shapes.list()[1], &TRIANGLES);
        assert_eq!((bent[0], bent[4]), (Vec3::Y, Vec3::NEG_X));
        // both squares have a right angle at either end of the edge, into however many triangles they are cut there
        let mean = Vec3::new(-1.0, 1.0, 0.0).normalize();
        assert!(bent[2].abs_diff_eq(mean, 1e-6) && bent[3].abs_diff_eq(mean, 1e-6));
    }

    #[test]
    fn a_crease_stays_and_what_has_no_normal_gets_none() {
        let normals = [Vec3::Y, Vec3::Y, Vec3::ZERO, Vec3::Y, Vec3::X, Vec3::X];
        let shapes = strip(&normals);
        let bent = shapes.normals(&shapes.list()[1], &TRIANGLES);
        assert_eq!((bent[2], bent[1]), (Vec3::ZERO, Vec3::Y));
    }
}
