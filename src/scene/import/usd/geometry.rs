//! The triangles of a mesh (UsdGeomMesh).

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::{DVec3, Vec2, Vec3};
use half::f16;
use openusd::sdf::Value;
use openusd::usd::Prim;

use super::cage;
use super::clock::Clock;
use super::file::{Content, UsdMesh};
use super::shader::UvNames;
use super::skin::Skin;
use super::value::{
    Answer, PrimError, Read, codes, codes_read, pairs, points, said, value, whole_numbers, word,
};
use crate::geometry::vertex_normal::Face;
use crate::scene::Shapes;
use crate::scene::details::vertex_color;
use crate::scene::import::deformed::remove_closed;
use crate::scene::import::faces::are_within_reach;
use crate::scene::import::faces::polygon::Cutter;
use crate::subdivision::Scheme;

/// Surfaces of a mesh's faces.
#[derive(Debug, Default)]
pub struct FaceSurfaces {
    /// Surface of all other faces.
    pub of_mesh: Option<usize>,
    /// True if the colours of vertices (displayColor) tint that surface.
    pub is_tinted: bool,
    /// Surfaces of faces that are in a subset.
    pub of_face: HashMap<u32, Option<usize>>,
    /// Names of the texture coordinates of each surface.
    pub uvs: HashMap<usize, UvNames>,
}

/// Faces of a mesh.
pub(super) struct Faces {
    pub(super) counts: Vec<usize>,
    /// Points of the corners, face after face.
    pub(super) corners: Vec<u32>,
    pub(super) is_left_handed: bool,
    pub(super) holes: BTreeSet<usize>,
}

/// Spread of values over a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PrimvarSpread {
    Constant,
    Uniform,
    Varying,
    Vertex,
    FaceVarying,
}

/// Values that are spread over a mesh.
pub(super) struct Primvar<T> {
    values: Vec<T>,
    indices: Option<Vec<i64>>,
    pub(super) spread: PrimvarSpread,
}

/// Values at the corners of a mesh's faces.
pub(super) struct Spreads {
    pub(super) normals: Option<Primvar<[f32; 3]>>,
    pub(super) colors: Option<Primvar<[f32; 3]>>,
    pub(super) uvs: UvPrimvars,
}

/// Texture coordinates of a mesh.
#[derive(Default)]
pub(super) struct UvPrimvars {
    all: Vec<Primvar<[f32; 2]>>,
    /// The two sets of each surface, by their numbers among all.
    of_surface: HashMap<usize, [Option<usize>; 2]>,
    /// The set of faces without a surface.
    usual: Option<usize>,
}

/// A corner of a face.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub(super) face: usize,
    /// Number among the corners of all faces.
    pub(super) number: usize,
    pub(super) point: u32,
}

/// Numbers of what values are spread over.
struct Extent {
    faces: usize,
    points: usize,
    corners: usize,
}

/// Reads a mesh, which `skin` may deform. `None` if it has no triangles. Of one that deforms some may have no area at rest. `content` gets to
/// know what has no effect, and what of its values does not fit it and is left out.
///
/// # Errors Faces that name points that are not there, points that are not finite, or more than there is memory for.
pub fn mesh(
    prim: &Prim,
    surfaces: &FaceSurfaces,
    skin: Option<&Skin>,
    content: &mut Content,
) -> Read<Option<UsdMesh>> {
    let clock = &content.clock.clone();
    let Content { unused, defects, .. } = content;
    let times = codes_read(prim, "points", clock)?;
    let code = times.first().copied().unwrap_or_else(|| clock.code(clock.first()));
    let Some(rest) = value(prim, "points", code)?.as_ref().and_then(points) else { return Ok(None) };
    check_points(&rest)?;
    let Some(faces) = Faces::read(prim, code, rest.len(), defects)? else { return Ok(None) };
    let mut primvars = Primvars { prim, code, extent: faces.extent(rest.len()), defects };
    // by unknown rules it is shown as its cage, with smooth normals
    let scheme = cage::scheme(prim, code, unused)?;
    let is_plain = word(prim, "subdivisionScheme", code)?.as_deref() == Some("none");
    let has_normals = is_plain || scheme == Some(Scheme::Bilinear);
    let normals = if has_normals { primvars.normals()? } else { None };
    let uvs = UvPrimvars::read(&mut primvars, &surfaces.uvs)?;
    let colors = match surfaces.is_tinted {
        true => primvars.read("primvars:displayColor", PrimvarSpread::Constant, points)?,
        false => None,
    };
    let spreads = Spreads { normals, colors, uvs };
    let mut mesh = triangulated(&rest, &faces, surfaces, &spreads);
    if let Some(scheme) = scheme {
        let cage = cage::cage((prim, code), scheme, (&rest, &faces), (surfaces, &spreads), defects)?;
        mesh.cage = Some(Box::new(cage));
    }
    mesh.shapes = match skin {
        Some(skin) => skin.shapes(&rest)?,
        None => shapes(prim, clock, &times, rest.len(), unused)?,
    };
    mesh.shapes.iter().try_for_each(|(_, points)| check_points(points))?;
    if mesh.shapes.is_empty() {
        remove_closed(&mesh.positions, &mut mesh.triangles, &mut mesh.uses);
    }
    if mesh.triangles.is_empty() {
        return Ok(None);
    }
    if !has_normals {
        mesh.normals = smooth_normals(&mesh);
    }
    Ok(Some(mesh))
}

fn check_points(points: &[[f32; 3]]) -> Answer<()> {
    if are_within_reach(points) && u32::try_from(points.len()).is_ok() {
        return Ok(());
    }
    Err(String::from("a point of it is not finite, or farther than 1e18 from the origin: export it again"))
}

impl Faces {
    fn read(prim: &Prim, code: f64, points: usize, defects: &mut BTreeSet<String>) -> Answer<Option<Self>> {
        let list = |name: &str| -> Answer<Option<Vec<i64>>> {
            Ok(value(prim, name, code)?.as_ref().and_then(whole_numbers))
        };
        let (Some(counts), Some(corners)) = (list("faceVertexCounts")?, list("faceVertexIndices")?) else {
            return Ok(None);
        };
        let wrong = |what: String| Err(format!("it {what}: export it again"));
        let read = |count: &i64| usize::try_from(*count).ok();
        let Some(counts) = counts.iter().map(read).collect::<Option<Vec<usize>>>() else {
            return wrong(String::from("has a face with fewer than no corners"));
        };
        let sum = counts.iter().try_fold(0_usize, |sum, count| sum.checked_add(*count));
        if sum.is_none_or(|sum| sum > corners.len()) {
            return wrong(format!("has faces with more corners than the {} that it names", corners.len()));
        }
        if let Some(sum) = sum.filter(|sum| *sum < corners.len()) {
            let (path, named) = (prim.path(), corners.len());
            defects.insert(format!(
                "{path} names {named} points of corners, and its faces have {sum}: what is beyond these is left out; export it again"
            ));
        }
        let is_there = |corner: i64| usize::try_from(corner).is_ok_and(|corner| corner < points);
        if let Some(bad) = corners.iter().find(|corner| !is_there(**corner)) {
            return wrong(format!("has a face at point {bad}, and {points} points"));
        }
        let holes = list("holeIndices")?.unwrap_or_default();
        Ok(Some(Self {
            counts,
            corners: corners.into_iter().map(|corner| corner as u32).collect(),
            is_left_handed: word(prim, "orientation", code)?.as_deref() == Some("leftHanded"),
            holes: holes.into_iter().filter_map(|hole| usize::try_from(hole).ok()).collect(),
        }))
    }

    fn extent(&self, points: usize) -> Extent {
        Extent { faces: self.counts.len(), points, corners: self.counts.iter().sum() }
    }
}

impl<T: Copy> Primvar<T> {
    /// Value at a corner, if there is one.
    pub(super) fn at(&self, corner: Corner) -> Option<T> {
        let place = match self.spread {
            PrimvarSpread::Constant => 0,
            PrimvarSpread::Uniform => corner.face,
            PrimvarSpread::Varying | PrimvarSpread::Vertex => corner.point as usize,
            PrimvarSpread::FaceVarying => corner.number,
        };
        let index = match &self.indices {
            Some(indices) => usize::try_from(*indices.get(place)?).ok()?,
            None => place,
        };
        self.values.get(index).copied()
    }
}

impl Extent {
    /// Number of values that are spread so, and what each of them belongs to.
    fn count(&self, spread: PrimvarSpread) -> (usize, &'static str) {
        match spread {
            PrimvarSpread::Constant => (1, "it as a whole"),
            PrimvarSpread::Uniform => (self.faces, "faces"),
            PrimvarSpread::Varying | PrimvarSpread::Vertex => (self.points, "points"),
            PrimvarSpread::FaceVarying => (self.corners, "corners of faces"),
        }
    }
}

impl<T> Primvar<T> {
    /// What does not fit a mesh. Negative indices stand for what has no value.
    fn misfit(&self, extent: &Extent) -> Option<String> {
        let (wanted, of) = extent.count(self.spread);
        let count = self.indices.as_ref().map_or(self.values.len(), Vec::len);
        if count < wanted {
            let what = if self.indices.is_some() { "indices" } else { "values" };
            return Some(format!("has {count} {what} for {wanted} {of}"));
        }
        let is_beyond = |index: &&i64| usize::try_from(**index).is_ok_and(|index| index >= self.values.len());
        let bad = self.indices.as_ref()?.iter().take(wanted).find(is_beyond)?;
        Some(format!("has the index {bad}, and {} values", self.values.len()))
    }
}

/// Reads values that are spread over a mesh.
struct Primvars<'a> {
    prim: &'a Prim,
    code: f64,
    extent: Extent,
    /// Gets to know those that do not fit the mesh, which are left out.
    defects: &'a mut BTreeSet<String>,
}

impl Primvars<'_> {
    /// Reads values by their name. `default`: their spread if the file does not say.
    fn read<T>(
        &mut self,
        name: &str,
        default: PrimvarSpread,
        read: impl Fn(&Value) -> Option<Vec<T>>,
    ) -> Answer<Option<Primvar<T>>> {
        let Self { prim, code, .. } = *self;
        let values = value(prim, name, code)?.as_ref().and_then(read);
        let Some(values) = values.filter(|values| !values.is_empty()) else { return Ok(None) };
        let stated = said(prim.attribute(name).get_metadata::<Value>("interpolation"))?;
        let spread = match stated {
            Some(Value::Token(word)) => match word.as_str() {
                "constant" => PrimvarSpread::Constant,
                "uniform" => PrimvarSpread::Uniform,
                "faceVarying" => PrimvarSpread::FaceVarying,
                "varying" => PrimvarSpread::Varying,
                _ => PrimvarSpread::Vertex,
            },
            _ => default,
        };
        let indices = value(prim, &format!("{name}:indices"), code)?.as_ref().and_then(whole_numbers);
        // exporters write lists without any
        let indices = indices.filter(|indices| !indices.is_empty());
        let read = Primvar { values, indices, spread };
        if let Some(what) = read.misfit(&self.extent) {
            self.defects.insert(left_out_of(prim, name, &what));
            return Ok(None);
        }
        Ok(Some(read))
    }

    fn normals(&mut self) -> Answer<Option<Primvar<[f32; 3]>>> {
        let of_primvar = self.read("primvars:normals", PrimvarSpread::Constant, points)?;
        if of_primvar.is_some() {
            return Ok(of_primvar);
        }
        self.read("normals", PrimvarSpread::Vertex, points)
    }
}

/// Says that values of a prim are left out, as a whole sentence; `what` goes on after their name.
pub(super) fn left_out_of(prim: &Prim, name: &str, what: &str) -> String {
    let name = crate::visible::visible(name);
    format!("`{name}` of {} {what}: it is left out; export it again", prim.path())
}

impl UvPrimvars {
    /// Reads the sets that surfaces name. What is not there has the usual one.
    fn read(primvars: &mut Primvars, names: &HashMap<usize, UvNames>) -> Answer<Self> {
        let mut sets = Self::default();
        let mut known: HashMap<String, Option<usize>> = HashMap::new();
        let mut number = |sets: &mut Self, name: &str| -> Answer<Option<usize>> {
            if let Some(number) = known.get(name) {
                return Ok(*number);
            }
            let read = primvars.read(&format!("primvars:{name}"), PrimvarSpread::Constant, pairs)?;
            let number = read.map(|read| {
                sets.all.push(read);
                sets.all.len() - 1
            });
            known.insert(name.to_string(), number);
            Ok(number)
        };
        for name in ["st", "UVMap"] {
            if sets.usual.is_none() {
                sets.usual = number(&mut sets, name)?;
            }
        }
        for (surface, [first, second]) in names {
            let mut of = |name: &Option<String>| match name {
                Some(name) => number(&mut sets, name),
                None => Ok(None),
            };
            let [first, second] = [of(first)?, of(second)?];
            sets.of_surface.insert(*surface, [first.or(sets.usual), second]);
        }
        Ok(sets)
    }

    /// The two sets of a surface.
    pub(super) fn of(&self, surface: Option<usize>) -> [Option<&Primvar<[f32; 2]>>; 2] {
        let of_surface = surface.and_then(|surface| self.of_surface.get(&surface).copied());
        of_surface.unwrap_or([self.usual, None]).map(|number| number.map(|number| &self.all[number]))
    }

    /// True for each of the two sets that a surface has.
    pub(super) fn has(&self) -> [bool; 2] {
        let second = self.of_surface.values().any(|[_, second]| second.is_some());
        [!self.all.is_empty(), second]
    }
}

/// What tells vertices apart: the point, and the bits of the normal, the colour and both pairs of texture coordinates.
type VertexKey = (u32, [u32; 3], [u16; 3], [[u32; 2]; 2]);

/// Cuts faces into triangles, and makes a vertex for each point with one normal, one colour and one pair of texture coordinates of each set.
fn triangulated(
    points: &[[f32; 3]],
    faces: &Faces,
    surfaces: &FaceSurfaces,
    Spreads { normals, colors, uvs }: &Spreads,
) -> UsdMesh {
    let mut mesh = UsdMesh::default();
    let mut known: HashMap<VertexKey, u32> = HashMap::new();
    let [has_first, has_second] = uvs.has();
    let mut by_surface: BTreeMap<Option<usize>, Vec<[u32; 3]>> = BTreeMap::new();
    let (mut cutter, mut begin) = (Cutter::new(), 0);
    for (face, count) in faces.counts.iter().enumerate() {
        let range = begin..begin + count;
        begin += count;
        if faces.holes.contains(&face) {
            continue;
        }
        let mut corners: Vec<Corner> =
            range.map(|number| Corner { face, number, point: faces.corners[number] }).collect();
        if faces.is_left_handed {
            corners.reverse();
        }
        let place = |corner: &Corner| Vec3::from(points[corner.point as usize]).as_dvec3();
        let places: Vec<DVec3> = corners.iter().map(place).collect();
        let surface = surfaces.of_face.get(&(face as u32)).copied().unwrap_or(surfaces.of_mesh);
        let sets = uvs.of(surface);
        let vertices: Vec<u32> = corners
            .iter()
            .map(|corner| {
                let normal =
                    normals.as_ref().map_or([0.0; 3], |normals| normals.at(*corner).unwrap_or_default());
                let uvs = sets.map(|set| set.and_then(|set| set.at(*corner)).unwrap_or_default());
                let color = colors.as_ref().map(|colors| colors.at(*corner).unwrap_or([1.0; 3]));
                let color = color.map(vertex_color);
                let key = (
                    corner.point,
                    normal.map(f32::to_bits),
                    color.unwrap_or_default().map(f16::to_bits),
                    uvs.map(|uv| uv.map(f32::to_bits)),
                );
                *known.entry(key).or_insert_with(|| {
                    mesh.positions.push(points[corner.point as usize]);
                    mesh.point_of.push(corner.point);
                    mesh.colors.extend(color);
                    if normals.is_some() {
                        mesh.normals.push(Vec3::from(normal).as_dvec3().normalize_or_zero().as_vec3());
                    }
                    let [first, second] =
                        uvs.map(Vec2::from).map(|uv| if uv.is_finite() { uv } else { Vec2::ZERO });
                    mesh.uvs.extend(has_first.then_some(first));
                    mesh.second_uvs.extend(has_second.then_some(second));
                    (mesh.positions.len() - 1) as u32
                })
            })
            .collect();
        let triangles = by_surface.entry(surface).or_default();
        cutter.cut(&places, |three| {
            triangles.push(three.map(|corner| vertices[corner]));
        });
    }
    for (surface, triangles) in by_surface.into_iter().filter(|(_, triangles)| !triangles.is_empty()) {
        mesh.uses.push((triangles.len(), surface));
        mesh.triangles.extend(triangles);
    }
    mesh
}

/// Normals of a surface that is smooth everywhere: at each point the mean of those around it, by their angles there.
fn smooth_normals(mesh: &UsdMesh) -> Vec<Vec3> {
    let count = mesh.point_of.iter().max().map_or(0, |most| *most as usize + 1);
    let mut sums = vec![DVec3::ZERO; count];
    for triangle in &mesh.triangles {
        let face = Face::new(triangle.map(|corner| Vec3::from(mesh.positions[corner as usize]).as_dvec3()));
        for (number, corner) in triangle.iter().enumerate() {
            sums[mesh.point_of[*corner as usize] as usize] += face.share(number);
        }
    }
    mesh.point_of.iter().map(|point| sums[*point as usize].normalize_or_zero().as_vec3()).collect()
}

/// Reads the points at all times, if they change.
fn shapes(
    prim: &Prim,
    clock: &Clock,
    times: &[f64],
    count: usize,
    unused: &mut BTreeSet<String>,
) -> Read<Vec<(f64, Vec<[f32; 3]>)>> {
    if times.len() < 2 {
        return Ok(Vec::new());
    }
    said(Shapes::check_memory(times.len(), count)).map_err(PrimError::Fatal)?;
    let changes_faces = codes(prim, "faceVertexIndices")?.len() > 1;
    let mut shapes = Vec::with_capacity(times.len());
    for code in times {
        let Some(points) = value(prim, "points", *code)?.as_ref().and_then(points) else { continue };
        if points.len() != count || changes_faces && !is_same_topology(prim, times[0], *code)? {
            unused.insert(format!(
                "faces of {} change with time: it is shown as at its first time",
                prim.path()
            ));
            return Ok(Vec::new());
        }
        shapes.push((clock.frame(*code), points));
    }
    Ok(shapes)
}

fn is_same_topology(prim: &Prim, first: f64, code: f64) -> Answer<bool> {
    for name in ["faceVertexIndices", "faceVertexCounts"] {
        let read = |code: f64| -> Answer<_> { Ok(value(prim, name, code)?.as_ref().and_then(whole_numbers)) };
        if read(first)? != read(code)? {
            return Ok(false);
        }
    }
    Ok(true)
}
