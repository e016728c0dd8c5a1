//! The triangles of a mesh: all of its primitives together.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use glam::{Vec2, Vec3};
use half::f16;

use super::document::{Document, packed};
use super::json::{Json, Primitive};
use super::materials::{UvSets, VertexAlpha, is_absent, uv_sets};
use crate::scene::SceneError;
use crate::scene::details::vertex_color;
use crate::scene::import::deformed::remove_closed;
use crate::scene::import::faces::are_within_reach;

/// Geometry of a mesh before its materials are looked up.
#[derive(Debug, Default, Clone)]
pub struct Geometry {
    /// Vertex positions, finite.
    pub positions: Vec<[f32; 3]>,
    /// Vertex normals, none at all or one a vertex: unit length, or zero.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, none at all or one a vertex; v = 0 at the bottom of the picture.
    pub uvs: Vec<Vec2>,
    /// Second set of texture coordinates, where a material takes two.
    pub second_uvs: Vec<Vec2>,
    /// Colours of the vertices, none at all or one a vertex; linear RGB.
    pub colors: Vec<[f16; 3]>,
    /// Alphas of the vertices, none at all or one a vertex; 0 to 1. None where all are 1.
    pub alphas: Vec<f32>,
    /// Tangents that the file states, none at all or one a vertex: a direction, and the side of the other one. Zero where it
    /// states none.
    pub tangents: Vec<[f32; 4]>,
    /// Vertices of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Runs of consecutive triangles with the same material: the number of triangles, and that of the material in the file.
    pub uses: Vec<(usize, Option<usize>)>,
    /// Joints of the vertices, in sets of four a vertex.
    pub influences: Vec<Influences>,
    /// Displacements of all vertices by each morph target.
    pub targets: Vec<Vec<[f32; 3]>>,
}

impl Geometry {
    /// Alpha of the vertices of the triangles in `range`.
    pub fn alpha_of(&self, range: Range<usize>) -> VertexAlpha {
        if self.alphas.is_empty() {
            return VertexAlpha::OPAQUE;
        }
        let mut alphas =
            self.triangles[range].as_flattened().iter().map(|corner| self.alphas[*corner as usize]);
        let Some(first) = alphas.next() else { return VertexAlpha::OPAQUE };
        if alphas.all(|alpha| alpha == first) { VertexAlpha::Even(first) } else { VertexAlpha::Uneven }
    }

    /// The same without the triangles that have no area where the vertices are at these positions; at rest if none are given.
    pub fn without_closed(mut self, positions: Option<&[[f32; 3]]>) -> Self {
        let positions = positions.unwrap_or(&self.positions);
        remove_closed(positions, &mut self.triangles, &mut self.uses);
        self
    }
}

/// Four joints of each vertex, and their weights.
#[derive(Debug, Clone)]
pub struct Influences {
    pub joints: Vec<[u32; 4]>,
    /// Not negative.
    pub weights: Vec<[f32; 4]>,
}

/// Attributes of vertices, with the accessors in which they are: primitives with the same ones share their vertices.
type Attributes = (Vec<(String, usize)>, Vec<Vec<(String, usize)>>, UvSets);

/// Reads the mesh with this number. It may have no triangles, and some without an area: a deformation may open them.
///
/// # Errors An accessor that is damaged or makes no sense.
pub fn read(document: &Document, mesh: usize) -> Result<Geometry, SceneError> {
    let Json { meshes, .. } = &document.json;
    let primitives = &document.get(meshes, mesh, "mesh")?.primitives;
    let mut geometry = Geometry::default();
    let mut known: HashMap<Attributes, u32> = HashMap::new();
    for primitive in primitives {
        let Some(mode) = mode(document, primitive, mesh)? else { continue };
        if is_absent(document, primitive.material)? {
            continue;
        }
        let sets = uv_sets(document, primitive.material)?;
        let list = |map: &BTreeMap<String, usize>| -> Vec<(String, usize)> {
            map.iter().map(|(name, accessor)| (name.clone(), *accessor)).collect()
        };
        let key = (list(&primitive.attributes), primitive.targets.iter().map(list).collect(), sets);
        let (first, count) = match known.get(&key) {
            Some(first) => (*first, count_of(document, primitive)?),
            None => {
                let first = add_vertices(document, mesh, primitive, sets, &mut geometry)?;
                known.insert(key, first);
                (first, geometry.positions.len() - first as usize)
            }
        };
        let corners = match primitive.indices {
            Some(indices) => document.whole_numbers(indices, 1)?,
            None => (0..count as u32).collect(),
        };
        if let Some(wrong) = corners.iter().find(|corner| **corner as usize >= count) {
            return Err(document.fault(format!(
                "mesh {mesh} has a triangle at vertex {wrong}, and {count} vertices: the file is damaged; export it again"
            )));
        }
        let before = geometry.triangles.len();
        let triangles = cut(mode, &corners).into_iter().map(|triangle| triangle.map(|corner| corner + first));
        geometry.triangles.extend(triangles);
        geometry.uses.push((geometry.triangles.len() - before, primitive.material));
    }
    geometry.uses.retain(|(count, _)| *count > 0);
    Ok(geometry)
}

/// Ways in which vertices become triangles.
#[derive(Debug, Clone, Copy)]
enum Mode {
    Triangles,
    Strip,
    Fan,
}

/// Finds the mode of a primitive. `None` for points and lines.
fn mode(document: &Document, primitive: &Primitive, mesh: usize) -> Result<Option<Mode>, SceneError> {
    match primitive.mode.unwrap_or(4) {
        0..=3 => {
            document.leave_out("points and lines are left out: only triangles have a surface");
            Ok(None)
        }
        4 => Ok(Some(Mode::Triangles)),
        5 => Ok(Some(Mode::Strip)),
        6 => Ok(Some(Mode::Fan)),
        other => {
            let message = format!("mesh {mesh} has the mode {other}, which is none: export it again");
            Err(document.fault(message))
        }
    }
}

fn cut(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    let three = |corners: &[u32]| [corners[0], corners[1], corners[2]];
    match mode {
        Mode::Triangles => corners.chunks_exact(3).map(three).collect(),
        Mode::Strip => {
            // every second one is the other way round
            let turned = |(i, [a, b, c]): (usize, [u32; 3])| if i % 2 == 0 { [a, b, c] } else { [a, c, b] };
            corners.windows(3).map(three).enumerate().map(turned).collect()
        }
        Mode::Fan => {
            let (Some(middle), rim) = (corners.first(), corners.get(1..).unwrap_or_default()) else {
                return Vec::new();
            };
            rim.windows(2).map(|edge| [*middle, edge[0], edge[1]]).collect()
        }
    }
}

fn position_accessor(document: &Document, primitive: &Primitive) -> Result<usize, SceneError> {
    primitive.attributes.get("POSITION").copied().ok_or_else(|| {
        document.fault("a mesh has no positions (POSITION): the file is incomplete; export it again")
    })
}

fn count_of(document: &Document, primitive: &Primitive) -> Result<usize, SceneError> {
    let accessor = position_accessor(document, primitive)?;
    Ok(document.get(&document.json.accessors, accessor, "accessor")?.count)
}

/// Adds the vertices of a primitive. Returns the number of the first one.
fn add_vertices(
    document: &Document,
    mesh: usize,
    primitive: &Primitive,
    sets: UvSets,
    to: &mut Geometry,
) -> Result<u32, SceneError> {
    let accessor = position_accessor(document, primitive)?;
    let is_draco = primitive.extensions.contains_key("KHR_draco_mesh_compression");
    if is_draco && document.get(&document.json.accessors, accessor, "accessor")?.buffer_view.is_none() {
        return Err(document.fault(packed("KHR_draco_mesh_compression")));
    }
    let first = to.positions.len();
    let positions: Vec<[f32; 3]> = document.vectors(accessor)?;
    let count = positions.len();
    let all = first + count;
    u32::try_from(all).map_err(|_| document.fault("a mesh has more than four thousand million vertices"))?;
    if !are_within_reach(&positions) {
        return Err(document.fault(format!(
            "a position of mesh {mesh} is not finite, or farther than 1e18 from the origin: export the file again"
        )));
    }
    to.positions.extend(positions);
    let new = NewVertices { document, primitive, mesh, first, all, sets };
    add_colors(&new, to)?;
    add_surface(&new, to)?;
    add_influences(&new, to)?;
    add_targets(&new, to)?;
    Ok(first as u32)
}

/// Vertices of a primitive that are being added.
struct NewVertices<'a> {
    document: &'a Document,
    primitive: &'a Primitive,
    /// Number of the mesh, for messages.
    mesh: usize,
    /// Number of the first of them in the geometry, and of all vertices with them.
    first: usize,
    all: usize,
    /// Numbers of the texture coordinates that count.
    sets: UvSets,
}

impl NewVertices<'_> {
    /// Checks the number of entries that an attribute has.
    fn fits(&self, length: usize, name: &str) -> Result<(), SceneError> {
        let (count, mesh) = (self.all - self.first, self.mesh);
        let message = || {
            format!("mesh {mesh} has {count} positions and {length} entries of {name}: export the file again")
        };
        if length == count { Ok(()) } else { Err(self.document.fault(message())) }
    }
}

/// Adds normals, texture coordinates and tangents.
fn add_surface(new: &NewVertices<'_>, to: &mut Geometry) -> Result<(), SceneError> {
    let NewVertices { document, primitive, first, all, sets, .. } = *new;
    let attribute = |name: &str| primitive.attributes.get(name).copied();
    if let Some(accessor) = attribute("NORMAL") {
        let normals: Vec<[f32; 3]> = document.vectors(accessor)?;
        new.fits(normals.len(), "NORMAL")?;
        let unit = |normal: [f32; 3]| Vec3::from(normal).as_dvec3().normalize_or_zero().as_vec3();
        to.normals.resize(first, Vec3::ZERO);
        to.normals.extend(normals.into_iter().map(unit));
    }
    add_uvs(new, sets.first, &mut to.uvs)?;
    if let Some(second) = sets.second {
        add_uvs(new, second, &mut to.second_uvs)?;
    }
    if let Some(accessor) = attribute("TANGENT") {
        let tangents: Vec<[f32; 4]> = document.vectors(accessor)?;
        new.fits(tangents.len(), "TANGENT")?;
        to.tangents.resize(first, [0.0; 4]);
        to.tangents.extend(tangents);
    }
    if !to.tangents.is_empty() {
        to.tangents.resize(all, [0.0; 4]);
    }
    if !to.normals.is_empty() {
        to.normals.resize(all, Vec3::ZERO);
    }
    for uvs in [&mut to.uvs, &mut to.second_uvs] {
        if !uvs.is_empty() {
            uvs.resize(all, Vec2::ZERO);
        }
    }
    Ok(())
}

/// Adds texture coordinates number `set` to a list, if the primitive has them.
fn add_uvs(new: &NewVertices<'_>, set: u32, to: &mut Vec<Vec2>) -> Result<(), SceneError> {
    let name = format!("TEXCOORD_{set}");
    let Some(accessor) = new.primitive.attributes.get(&name) else { return Ok(()) };
    let uvs: Vec<[f32; 2]> = new.document.vectors(*accessor)?;
    new.fits(uvs.len(), &name)?;
    let flipped = |[u, v]: [f32; 2]| {
        let uv = Vec2::new(u, 1.0 - v);
        if uv.is_finite() { uv } else { Vec2::ZERO }
    };
    to.resize(new.first, Vec2::ZERO);
    to.extend(uvs.into_iter().map(flipped));
    Ok(())
}

/// Adds colours and alphas of vertices.
fn add_colors(new: &NewVertices<'_>, to: &mut Geometry) -> Result<(), SceneError> {
    let NewVertices { document, primitive, first, all, .. } = *new;
    const WHITE: [f16; 3] = [f16::ONE; 3];
    if let Some(accessor) = primitive.attributes.get("COLOR_0").copied() {
        let has_alpha = document.get(&document.json.accessors, accessor, "accessor")?.kind == "VEC4";
        let colors = document.floats(accessor, if has_alpha { 4 } else { 3 })?;
        let colors = colors.chunks_exact(if has_alpha { 4 } else { 3 });
        new.fits(colors.len(), "COLOR_0")?;
        // what is no number is not there
        let alpha = |color: &[f32]| if color[3] > 0.0 { color[3].min(1.0) } else { 0.0 };
        if has_alpha && colors.clone().any(|color| alpha(color) < 1.0) {
            to.alphas.resize(first, 1.0);
            to.alphas.extend(colors.clone().map(alpha));
        }
        to.colors.resize(first, WHITE);
        let color = |color: &[f32]| vertex_color([color[0], color[1], color[2]]);
        to.colors.extend(colors.map(color));
    }
    if !to.colors.is_empty() {
        to.colors.resize(all, WHITE);
    }
    if !to.alphas.is_empty() {
        to.alphas.resize(all, 1.0);
    }
    Ok(())
}

fn add_influences(new: &NewVertices<'_>, to: &mut Geometry) -> Result<(), SceneError> {
    let NewVertices { document, primitive, first, all, .. } = *new;
    for set in 0.. {
        let [joints, weights] =
            ["JOINTS", "WEIGHTS"].map(|name| primitive.attributes.get(&format!("{name}_{set}")).copied());
        let (Some(joints), Some(weights)) = (joints, weights) else { break };
        let joints = document.whole_numbers(joints, 4)?;
        let weights: Vec<[f32; 4]> = document.vectors(weights)?;
        new.fits(joints.len() / 4, "JOINTS")?;
        new.fits(weights.len(), "WEIGHTS")?;
        if to.influences.len() == set {
            to.influences.push(Influences { joints: vec![[0; 4]; first], weights: vec![[0.0; 4]; first] });
        }
        let Influences { joints: of_joints, weights: of_weights } = &mut to.influences[set];
        of_joints.extend(joints.chunks_exact(4).map(|four| [four[0], four[1], four[2], four[3]]));
        of_weights.extend(
            weights.into_iter().map(|four| four.map(|weight| if weight > 0.0 { weight } else { 0.0 })),
        );
    }
    for Influences { joints, weights } in &mut to.influences {
        joints.resize(all, [0; 4]);
        weights.resize(all, [0.0; 4]);
    }
    Ok(())
}

fn add_targets(new: &NewVertices<'_>, to: &mut Geometry) -> Result<(), SceneError> {
    let NewVertices { document, primitive, first, all, .. } = *new;
    for (number, target) in primitive.targets.iter().enumerate() {
        if to.targets.len() == number {
            to.targets.push(vec![[0.0; 3]; first]);
        }
        let Some(accessor) = target.get("POSITION") else { continue };
        let moved: Vec<[f32; 3]> = document.vectors(*accessor)?;
        new.fits(moved.len(), "a morph target")?;
        if !are_within_reach(&moved) {
            return Err(
                document.fault("a morph target has numbers that are not finite: export the file again")
            );
        }
        to.targets[number].extend(moved);
    }
    to.targets.iter_mut().for_each(|target| target.resize(all, [0.0; 3]));
    Ok(())
}
