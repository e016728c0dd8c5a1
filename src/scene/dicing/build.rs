//! From a subdivided cage to a mesh.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};

use crate::scene::cage::{Cage, FaceVarying, Spread, SpreadKind, in_doubles, in_floats};
use crate::scene::details::{Details, ObjectSpace, vertex_color};
use crate::scene::import::Import;
use crate::scene::import::deformed::has_area;
use crate::scene::import::faces::are_within_reach;
use crate::scene::import::part_of_file::Surface;
use crate::scene::{Mesh, Shapes};
use crate::subdivision::{Hierarchy, Limit, Scheme};

/// Values at the corners of the last level.
struct AtCorners {
    values: Vec<DVec3>,
    /// Number of each corner's value. None: that of its vertex.
    of_corner: Option<Vec<u32>>,
}

impl AtCorners {
    /// Spreads values of a cage over its last level.
    fn of(cage: &Cage, spread: &Spread, hierarchy: &Hierarchy) -> Self {
        let (depth, values) = (hierarchy.depth(), in_doubles(&spread.values));
        let is_smooth = cage.scheme != Scheme::Bilinear;
        match spread.kind {
            SpreadKind::OfPoints => {
                let values = hierarchy.values(0, depth, values);
                Self { values: hierarchy.limit(&values), of_corner: None }
            }
            SpreadKind::OfCorners if is_smooth && cage.face_varying != FaceVarying::All => {
                let mut own = cage.face_varying_hierarchy(spread);
                (0..depth).for_each(|_| own.refine());
                let values = own.values(0, depth, values);
                Self { values: own.limit(&values), of_corner: Some(own.last().corners.clone()) }
            }
            SpreadKind::OfCorners | SpreadKind::Linear => {
                let at_corners: Vec<DVec3> =
                    spread.of_corner.iter().map(|number| values[*number as usize]).collect();
                Self::interned(hierarchy.linear_values(at_corners))
            }
        }
    }

    /// Equal values are one.
    fn interned(at_corners: Vec<DVec3>) -> Self {
        let (mut known, mut values) = (HashMap::new(), Vec::new());
        let of_corner = at_corners.iter().map(|value| {
            *known.entry(in_floats(*value).map(f32::to_bits)).or_insert_with(|| {
                values.push(*value);
                (values.len() - 1) as u32
            })
        });
        let of_corner = of_corner.collect();
        Self { values, of_corner: Some(of_corner) }
    }

    fn at(&self, corner: u32, vertex: u32) -> DVec3 {
        self.values[self.number(corner).unwrap_or(vertex) as usize]
    }

    fn number(&self, corner: u32) -> Option<u32> {
        self.of_corner.as_ref().map(|numbers| numbers[corner as usize])
    }
}

/// Vertices of a mesh: one for each normal of the surface, and the values at it.
struct Vertices {
    /// First vertex of each normal, or none.
    first: Vec<Option<u32>>,
    /// Corner, values and the next vertex of the same normal, of each vertex.
    all: Vec<(u32, [u32; 4], Option<u32>)>,
}

impl Vertices {
    /// Number of the vertex of a normal with these values.
    fn number(&mut self, normal: u32, corner: u32, values: [u32; 4]) -> u32 {
        let mut at = self.first[normal as usize];
        while let Some(number) = at {
            let (_, known, next) = self.all[number as usize];
            if known == values {
                return number;
            }
            at = next;
        }
        let number = self.all.len() as u32;
        self.all.push((corner, values, self.first[normal as usize]));
        self.first[normal as usize] = Some(number);
        number
    }
}

/// Makes a mesh of the last level of a cage. `space`: that of the graphs of the mesh for which the cage stands.
///
/// # Errors More than there is memory for, or a surface that is nowhere.
pub fn mesh(
    cage: &Cage,
    hierarchy: &Hierarchy,
    import: &Import,
    space: Option<ObjectSpace>,
) -> Result<Mesh, String> {
    let depth = hierarchy.depth();
    let refined = |points: &[[f32; 3]]| hierarchy.values(0, depth, in_doubles(points));
    let limit = hierarchy.limit_with_normals(&refined(&cage.points));
    let spread =
        |spread: &Option<Spread>| spread.as_ref().map(|spread| AtCorners::of(cage, spread, hierarchy));
    let [uvs, second_uvs, colors, normals] =
        [&cage.uvs, &cage.second_uvs, &cage.colors, &cage.normals].map(spread);
    let level = hierarchy.last();
    let mut vertices = Vertices { first: vec![None; limit.normals.len()], all: Vec::new() };
    let mut by_material: BTreeMap<u16, Vec<[u32; 3]>> = BTreeMap::new();
    for (face, cage_face) in (0..).zip(hierarchy.cage_faces()) {
        if cage.holes.binary_search(&cage_face).is_ok() {
            continue;
        }
        let corners = level.corners_of(face);
        let number =
            |of: &Option<AtCorners>, corner: u32| of.as_ref().and_then(|of| of.number(corner)).unwrap_or(0);
        let around: Vec<u32> = corners
            .map(|corner| {
                let values = [&uvs, &second_uvs, &colors, &normals].map(|of| number(of, corner));
                vertices.number(limit.normal_of[corner as usize], corner, values)
            })
            .collect();
        let of_material = by_material.entry(cage.material_of[cage_face as usize]).or_default();
        let place = |corner: u32| {
            let (corner, ..) = vertices.all[corner as usize];
            limit.positions[level.corners[corner as usize] as usize]
        };
        let length = |from: u32, to: u32| (place(to) - place(from)).length_squared();
        match around[..] {
            [a, b, c, d] if length(a, c) <= length(b, d) => of_material.extend([[a, b, c], [a, c, d]]),
            [a, b, c, d] => of_material.extend([[a, b, d], [b, c, d]]),
            _ => of_material.push([around[0], around[1], around[2]]),
        }
    }
    let vertex_of = |corner: u32| level.corners[corner as usize];
    let positions_of = |places: &[DVec3]| -> Vec<[f32; 3]> {
        vertices.all.iter().map(|(corner, ..)| in_floats(places[vertex_of(*corner) as usize])).collect()
    };
    let positions = positions_of(&limit.positions);
    if !are_within_reach(&positions) {
        return Err(String::from("a point of it is farther than 1e18 from the origin"));
    }
    by_material.values_mut().for_each(|triangles| triangles.retain(|of| has_area(&positions, *of)));
    by_material.retain(|_, triangles| !triangles.is_empty());
    if by_material.is_empty() {
        return Err(String::from("no face of it has an area"));
    }
    let shapes = shapes(cage, hierarchy, &positions_of)?;
    let mut begin = 0;
    let runs = by_material.iter().map(|(material, triangles)| {
        begin += triangles.len();
        (begin - triangles.len()..begin, *material)
    });
    let runs = runs.collect();
    let pair = |value: DVec3| Vec2::new(value.x as f32, value.y as f32);
    let values = |of: &Option<AtCorners>| -> Vec<DVec3> {
        let Some(of) = of else { return Vec::new() };
        vertices.all.iter().map(|(corner, ..)| of.at(*corner, vertex_of(*corner))).collect()
    };
    let surface = Surface {
        normals: match &normals {
            Some(of) => stated_normals(&vertices, of, vertex_of),
            None => of_surface(&vertices, &limit),
        },
        uvs: values(&uvs).into_iter().map(pair).collect(),
        second_uvs: values(&second_uvs).into_iter().map(pair).collect(),
        colors: values(&colors).into_iter().map(|color| vertex_color(in_floats(color))).collect(),
        triangles: by_material.into_values().flatten().collect(),
        positions,
        ..Surface::default()
    };
    let places: Vec<u32> = vertices.all.iter().map(|(corner, ..)| vertex_of(*corner)).collect();
    let mesh = import.arranger().mesh_of_runs(surface, runs);
    let mesh = mesh.with_triangles(|triangles| {
        if !shapes.is_empty() {
            let shapes = Shapes::new(shapes, &triangles.corners, &triangles.normals, &places);
            triangles.shapes = Some(Arc::new(shapes));
        }
    });
    let details = Details {
        space: mesh.details.space.and(space.or(mesh.details.space)),
        ..Details::clone(&mesh.details)
    };
    Ok(Mesh { details: Arc::new(details), ..mesh })
}

/// Positions of the vertices in each shape.
fn shapes(
    cage: &Cage,
    hierarchy: &Hierarchy,
    positions_of: &impl Fn(&[DVec3]) -> Vec<[f32; 3]>,
) -> Result<Vec<Vec<[f32; 3]>>, String> {
    if cage.shapes.is_empty() {
        return Ok(Vec::new());
    }
    Shapes::check_memory(cage.shapes.len(), hierarchy.last().vertices).map_err(|error| error.to_string())?;
    let of_shape = |points: &Vec<[f32; 3]>| {
        let refined = hierarchy.values(0, hierarchy.depth(), in_doubles(points));
        let positions = positions_of(&hierarchy.limit(&refined));
        let is_bad = !are_within_reach(&positions);
        if is_bad {
            Err(String::from("a point of it is farther than 1e18 from the origin"))
        } else {
            Ok(positions)
        }
    };
    cage.shapes.iter().map(of_shape).collect()
}

/// Normals of the surface.
fn of_surface(vertices: &Vertices, limit: &Limit) -> Vec<Vec3> {
    let normal = |corner: u32| limit.normals[limit.normal_of[corner as usize] as usize].as_vec3();
    vertices.all.iter().map(|(corner, ..)| normal(*corner)).collect()
}

/// Normals that a file states.
fn stated_normals(vertices: &Vertices, of: &AtCorners, vertex_of: impl Fn(u32) -> u32) -> Vec<Vec3> {
    let normal = |corner: u32| of.at(corner, vertex_of(corner)).normalize_or_zero().as_vec3();
    vertices.all.iter().map(|(corner, ..)| normal(*corner)).collect()
}
