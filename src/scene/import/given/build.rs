//! From given meshes to the renderer's.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use embree::VertexBuffer;
use glam::{DVec3, Vec2, Vec3};

use super::curves;
use super::meshes::{Given, GivenMesh, GivenModel, NAME};
use crate::animation::{ShapeTrack, Visibility};
use crate::digest::Digest;
use crate::scene::details::vertex_color;
use crate::scene::import::Import;
use crate::scene::import::deformed::Distinct;
use crate::scene::import::deformed::has_area;
use crate::scene::import::faces::polygon::Cutter;
use crate::scene::import::part_of_file::{NodeTrack, PartOfFile, Surface};
use crate::scene::{Mesh, SceneError, Shapes};

/// A mesh and its shapes over time, or none if no face has an area.
pub(super) type Built = Option<(Arc<Mesh>, Option<ShapeTrack>)>;

/// The models that were given, in order.
///
/// # Errors A material that is nowhere stated, or wrong.
pub fn models(import: &mut Import, given: &Given) -> Result<Vec<PartOfFile>, SceneError> {
    let built = given.meshes.iter().map(|mesh| built_mesh(import, mesh)).collect::<Result<Vec<_>, _>>()?;
    let mut parts = Vec::with_capacity(given.models.len());
    for model in &given.models {
        let Some((mesh, shapes)) = built[model.mesh].clone() else { continue };
        match part(model, mesh, shapes) {
            Some(part) => parts.push(part),
            None => import.findings.note(SceneError::new(
                NAME,
                format!("model `{}` is scaled to nothing in all frames: it is left out", model.name),
            )),
        }
    }
    if parts.is_empty() {
        return Err(SceneError::new(NAME, "there is nothing to see: no mesh has a face with an area"));
    }
    Ok(parts)
}

fn built_mesh(import: &mut Import, given: &GivenMesh) -> Result<Built, SceneError> {
    if let Some(set) = &given.curves {
        let name = given.materials.first().map_or("", String::as_str);
        let material = index_of_material(import, given, name)?;
        return curves::built(import, given, set, material);
    }
    digests(given).for_each(|digest| import.inputs.depend_on(digest));
    let Triangulated { surface, runs, point_of } = Triangulated::new(given);
    if surface.triangles.is_empty() {
        let message = format!("mesh `{}` has no face with an area: it is left out", given.name);
        import.findings.stand_in(SceneError::new(NAME, message))?;
        return Ok(None);
    }
    let (mut begin, mut all) = (0, Vec::with_capacity(runs.len()));
    for (material, count) in runs {
        let name = given.materials.get(material as usize).map_or("", String::as_str);
        let index = index_of_material(import, given, name)?;
        if !surface.colors.is_empty() {
            import.surfaces.color_vertices(index);
        }
        all.push((begin..begin + count, index));
        begin += count;
    }
    Ok(Some(with_shapes(import.arranger().mesh_of_runs(surface, all), given, &point_of)))
}

fn index_of_material(import: &mut Import, mesh: &GivenMesh, name: &str) -> Result<u16, SceneError> {
    let fault = |what: String| SceneError::new(NAME, format!("mesh `{}`: {what}", mesh.name));
    match import.material_of_table(name) {
        Some(material) => material.map_err(fault),
        None => Err(fault(format!("there is no material `{name}`{}: add it", import.surfaces.hint_at(name)))),
    }
}

fn digests(given: &GivenMesh) -> impl Iterator<Item = Digest> {
    let bytes: [&[u8]; 4] = [
        bytemuck::cast_slice(&given.points),
        bytemuck::cast_slice(&given.corners),
        bytemuck::cast_slice(&given.normals),
        bytemuck::cast_slice(&given.uvs),
    ];
    bytes.map(Digest::new).into_iter()
}

/// Model of a mesh. `None` if it is scaled to nothing for ever.
fn part(model: &GivenModel, mesh: Arc<Mesh>, shapes: Option<ShapeTrack>) -> Option<PartOfFile> {
    let NodeTrack { map, visible } = NodeTrack::through(model.places.clone(), &[])?;
    let stated = Visibility::through(model.is_visible, model.visible.clone())?;
    let (name, visible, ray_visibility) = (model.name.clone(), visible.and(&stated), model.ray_visibility);
    Some(PartOfFile { name, mesh, map, visible, shapes, ray_visibility, linked: model.linked.clone() })
}

/// Gives a mesh its shapes.
fn with_shapes(mesh: Mesh, given: &GivenMesh, point_of: &[u32]) -> (Arc<Mesh>, Option<ShapeTrack>) {
    let mut shapes = Distinct::default();
    for (frame, points) in &given.shapes {
        shapes.add(*frame, point_of.iter().map(|point| points[*point as usize]).collect());
    }
    let Distinct { list, keys, .. } = shapes;
    if list.is_empty() {
        return (Arc::new(mesh), None);
    }
    let mesh = mesh.with_triangles(|triangles| {
        triangles.positions = Arc::new(VertexBuffer::new(list[0].clone()));
        let shapes = Shapes::new(list, &triangles.corners, &triangles.normals, point_of);
        triangles.shapes = Some(Arc::new(shapes));
    });
    (Arc::new(mesh), ShapeTrack::through(keys, None))
}

/// A mesh of triangles that have an area.
struct Triangulated {
    surface: Surface,
    /// Number of a material, and of the triangles that have it, in the order of the triangles.
    runs: Vec<(u32, usize)>,
    /// Point of each vertex.
    point_of: Vec<u32>,
}

/// Values of vertices: none, or one for each point or corner.
#[derive(Clone, Copy)]
struct Values<'a, const N: usize> {
    list: &'a [[f32; N]],
    is_of_corners: bool,
}

impl<'a, const N: usize> Values<'a, N> {
    fn new(list: &'a [[f32; N]], points: usize) -> Self {
        Self { list, is_of_corners: !list.is_empty() && list.len() != points }
    }

    /// Value at a corner of a point; zero if there are none.
    fn at(self, corner: usize, point: u32) -> [f32; N] {
        let place = if self.is_of_corners { corner } else { point as usize };
        self.list.get(place).copied().unwrap_or([0.0; N])
    }
}

impl Triangulated {
    fn new(given: &GivenMesh) -> Self {
        let points = given.points.len();
        let values = VertexValues {
            normals: Values::new(&given.normals, points),
            uvs: Values::new(&given.uvs, points),
            colors: Values::new(&given.colors, points),
        };
        let mut vertices = Vertices { known: HashMap::new(), point_of: Vec::new(), corner_of: Vec::new() };
        let of_points =
            !(values.normals.is_of_corners || values.uvs.is_of_corners || values.colors.is_of_corners);
        let vertex_of: Vec<u32> = if of_points {
            given.corners.clone()
        } else {
            let corners = given.corners.iter().enumerate();
            corners.map(|(corner, point)| vertices.number(corner, *point, &values)).collect()
        };
        if of_points {
            vertices.point_of = (0..points as u32).collect();
            vertices.corner_of = vec![0; points];
        }
        let (triangles, runs) = cut(given, &vertex_of);
        let Vertices { point_of, corner_of, .. } = vertices;
        let all = || corner_of.iter().zip(&point_of).map(|(corner, point)| (*corner as usize, *point));
        let unit = |normal: [f32; 3]| Vec3::from(normal).as_dvec3().normalize_or_zero().as_vec3();
        let surface = Surface {
            positions: point_of.iter().map(|point| given.points[*point as usize]).collect(),
            normals: of(&given.normals, || all().map(|(c, p)| unit(values.normals.at(c, p))).collect()),
            uvs: of(&given.uvs, || all().map(|(c, p)| Vec2::from(values.uvs.at(c, p))).collect()),
            colors: of(&given.colors, || all().map(|(c, p)| vertex_color(values.colors.at(c, p))).collect()),
            triangles,
            ..Surface::default()
        };
        Self { surface, runs, point_of }
    }
}

/// Makes a list if there are values for it.
fn of<T, const N: usize>(values: &[[f32; N]], make: impl FnOnce() -> Vec<T>) -> Vec<T> {
    if values.is_empty() { Vec::new() } else { make() }
}

struct VertexValues<'a> {
    normals: Values<'a, 3>,
    uvs: Values<'a, 2>,
    colors: Values<'a, 3>,
}

/// Point and values of a vertex, bit by bit.
type Key = (u32, [u32; 3], [u32; 2], [u32; 3]);

/// Vertices of corners: those of one point and the same values are one.
struct Vertices {
    known: HashMap<Key, u32>,
    point_of: Vec<u32>,
    /// First corner of each.
    corner_of: Vec<u32>,
}

impl Vertices {
    /// Number of the vertex of a corner.
    fn number(&mut self, corner: usize, point: u32, values: &VertexValues<'_>) -> u32 {
        let VertexValues { normals, uvs, colors } = values;
        let key = (
            point,
            normals.at(corner, point).map(f32::to_bits),
            uvs.at(corner, point).map(f32::to_bits),
            colors.at(corner, point).map(f32::to_bits),
        );
        *self.known.entry(key).or_insert_with(|| {
            self.point_of.push(point);
            self.corner_of.push(corner as u32);
            (self.point_of.len() - 1) as u32
        })
    }
}

/// Cuts faces into triangles, those of one material after the other.
fn cut(given: &GivenMesh, vertex_of: &[u32]) -> (Vec<[u32; 3]>, Vec<(u32, usize)>) {
    let mut by_material: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
    let (mut cutter, mut begin, mut places) = (Cutter::new(), 0, Vec::new());
    let place = |corner: usize| Vec3::from(given.points[given.corners[corner] as usize]).as_dvec3();
    for face in 0..given.faces() {
        let count = given.counts.as_ref().map_or(3, |counts| counts[face] as usize);
        let first = begin;
        begin += count;
        let triangles = by_material.entry(given.material_of.get(face).copied().unwrap_or(0)).or_default();
        places.clear();
        places.extend((first..begin).map(place));
        let places: &[DVec3] = &places;
        cutter.cut(places, |three| {
            let points = three.map(|corner| given.corners[first + corner]);
            if has_area(&given.points, points) {
                triangles.push(three.map(|corner| vertex_of[first + corner]));
            }
        });
    }
    by_material.retain(|_, triangles| !triangles.is_empty());
    let runs = by_material.iter().map(|(material, triangles)| (*material, triangles.len())).collect();
    (by_material.into_values().flatten().collect(), runs)
}
