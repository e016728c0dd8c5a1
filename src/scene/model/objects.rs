//! Objects (`o`) and groups (`g`) of OBJ files as models of their own.
//!
//! The file is read once, into one mesh; each part takes its triangles and their vertices out of that. What all parts share
//! (materials, pictures, warnings) is then the file's, as if it were one model.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use embree::VertexBuffer;

use super::assemble::Assembly;
use crate::scene::cutout::CutTriangles;
use crate::scene::keys::model::Division;
use crate::scene::keys::spelling;
use crate::scene::mesh::Groups;
use crate::scene::{Mesh, SceneError};

/// Maximum number of names that an error lists.
const MOST_LISTED: usize = 20;

/// Vertex of the whole mesh that a part does not have.
const NOT_THERE: u32 = u32::MAX;

/// Objects of the OBJ files that were read, and the parts that were taken out of them.
#[derive(Default)]
pub(super) struct ObjectFiles {
    /// Objects of each file's mesh.
    objects: HashMap<PathBuf, Arc<Groups>>,
    /// Parts by file and name, for copies.
    parts: HashMap<(PathBuf, String), Arc<Mesh>>,
    /// All parts of a file, by division.
    divided: HashMap<(PathBuf, Division), Arc<Vec<PartOfObj>>>,
}

impl ObjectFiles {
    /// Records the objects of a file's mesh, which are runs of its triangles as groups are.
    pub fn add(&mut self, file: PathBuf, objects: Groups) {
        self.objects.insert(file, Arc::new(objects));
    }
}

/// A part of an OBJ file.
pub(crate) struct PartOfObj {
    /// Name of the object or group; `default` for faces that are in none.
    pub name: String,
    /// The mesh, with the groups that the file puts its triangles in.
    pub mesh: Arc<Mesh>,
}

/// Run of consecutive triangles of one object and one group, by the numbers of their names.
struct Segment {
    triangles: Range<usize>,
    object: u32,
    group: u32,
}

impl Assembly {
    /// Takes the part called `name` out of the OBJ file at `path`: all faces whose last `o`, or whose last `o` or `g`, is `name`.
    /// The inner error, the end of a sentence about the name, says that there is no such part.
    ///
    /// # Errors Those of [`mesh`](Self::mesh).
    pub fn part_of_obj(&mut self, path: &Path, name: &str) -> Result<Result<PartOfObj, String>, SceneError> {
        let whole = self.mesh(path)?;
        let key = (key_of(path), String::from(name));
        if let Some(mesh) = self.of_objects.parts.get(&key) {
            return Ok(Ok(PartOfObj { name: key.1, mesh: mesh.clone() }));
        }
        let (names, segments) = (whole.groups.names(), segments(&whole, &self.of_objects.objects[&key.0]));
        let is_called = |number: u32| names[number as usize] == name;
        let of_part: Vec<&Segment> =
            segments.iter().filter(|of| is_called(of.object) || is_called(of.group)).collect();
        if of_part.is_empty() {
            return Ok(Err(unknown(name, names, &segments)));
        }
        let mesh = Arc::new(Taker::new(&whole).take(&of_part));
        self.of_objects.parts.insert(key, mesh.clone());
        Ok(Ok(PartOfObj { name: String::from(name), mesh }))
    }

    /// Divides the OBJ file at `path` into parts, in the order in which it names them. The inner error, the end of a sentence,
    /// says that there is nothing to divide by.
    ///
    /// # Errors Those of [`mesh`](Self::mesh).
    pub fn divided_obj(
        &mut self,
        path: &Path,
        by: Division,
    ) -> Result<Result<Arc<Vec<PartOfObj>>, String>, SceneError> {
        let whole = self.mesh(path)?;
        let key = (key_of(path), by);
        if let Some(parts) = self.of_objects.divided.get(&key) {
            return Ok(Ok(parts.clone()));
        }
        let segments = segments(&whole, &self.of_objects.objects[&key.0]);
        let number = |of: &Segment| match by {
            Division::Objects => of.object,
            Division::Groups => of.group,
        };
        let mut of_parts: BTreeMap<u32, Vec<&Segment>> = BTreeMap::new();
        segments.iter().for_each(|of| of_parts.entry(number(of)).or_default().push(of));
        if of_parts.keys().all(|number| *number == 0) {
            return Ok(Err(nothing_to_divide(by, &segments)));
        }
        let (mut taker, names) = (Taker::new(&whole), whole.groups.names());
        let parts = of_parts.iter().map(|(number, of_part)| PartOfObj {
            name: names[*number as usize].clone(),
            mesh: Arc::new(taker.take(of_part)),
        });
        let parts: Arc<Vec<PartOfObj>> = Arc::new(parts.collect());
        self.of_objects.divided.insert(key, parts.clone());
        Ok(Ok(parts))
    }
}

/// Name of a file among those that were read.
fn key_of(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

/// Runs of triangles of the same object and group, in order.
fn segments(whole: &Mesh, objects: &Groups) -> Vec<Segment> {
    let (objects, groups) = (objects.runs(), whole.groups.runs());
    let begins: BTreeSet<u32> = objects.iter().chain(groups).map(|(first, _)| *first).collect();
    let begins: Vec<usize> = begins.into_iter().map(|first| first as usize).collect();
    let ends = begins.iter().skip(1).copied().chain([whole.triangles.len()]);
    let at = |runs: &[(u32, u32)], first: usize| {
        let after = runs.partition_point(|(begin, _)| *begin as usize <= first);
        runs[after - 1].1
    };
    let segment = |(first, end): (&usize, usize)| Segment {
        triangles: *first..end,
        object: at(objects, *first),
        group: at(groups, *first),
    };
    begins.iter().zip(ends).map(segment).collect()
}

fn unknown(name: &str, names: &[String], segments: &[Segment]) -> String {
    let used: BTreeSet<u32> = segments.iter().flat_map(|of| [of.object, of.group]).collect();
    let used: Vec<&str> = used.iter().map(|number| names[*number as usize].as_str()).collect();
    if names.iter().any(|known| known == name) {
        return format!("`{name}`, which has no faces there: choose another one");
    }
    let hint = spelling::hint(name, used.iter().copied());
    let listed: Vec<String> = used.iter().take(MOST_LISTED).map(|name| format!("`{name}`")).collect();
    let more = used.len().saturating_sub(MOST_LISTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!(
        "`{name}`, and there is no such object (`o`) or group (`g`){hint} (there: {}{more})",
        listed.join(", ")
    )
}

fn nothing_to_divide(by: Division, segments: &[Segment]) -> String {
    let groups: BTreeSet<u32> = segments.iter().map(|of| of.group).collect();
    match by {
        Division::Objects if groups.iter().any(|group| *group > 0) => format!(
            "is \"objects\", and the file has none (`o`): write \"groups\" for its {} groups (`g`)",
            groups.len()
        ),
        _ => String::from(
            "divides a file by its objects (`o`) or groups (`g`), and this one has none: take it out",
        ),
    }
}

/// Takes parts out of a mesh, one after the other.
struct Taker<'a> {
    whole: &'a Mesh,
    /// Number in the part at work for each vertex of the whole; `NOT_THERE` between parts.
    number_of: Vec<u32>,
}

impl<'a> Taker<'a> {
    fn new(whole: &'a Mesh) -> Self {
        Self { whole, number_of: vec![NOT_THERE; whole.positions.as_slice().len()] }
    }

    /// Makes a mesh of the triangles of `segments`, in their order, so that those which cast shadows stay first.
    fn take(&mut self, segments: &[&Segment]) -> Mesh {
        let whole = self.whole;
        let count = segments.iter().map(|of| of.triangles.len()).sum();
        let (mut triangles, mut material_of) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let (mut groups, mut vertices) = (Groups::named(whole.groups.names().iter().cloned()), Vec::new());
        for of in segments {
            groups.begin(triangles.len() as u32, of.group);
            material_of.extend_from_slice(&whole.material_of[of.triangles.clone()]);
            let own = whole.triangles[of.triangles.clone()].iter();
            triangles.extend(own.map(|corners| corners.map(|vertex| self.number(vertex, &mut vertices))));
        }
        vertices.iter().for_each(|vertex| self.number_of[*vertex as usize] = NOT_THERE);
        let casting = |of: &&Segment| whole.shadow_casting.clamp(of.triangles.start, of.triangles.end);
        let shadow_casting = segments.iter().map(|of| casting(of) - of.triangles.start).sum();
        // a list that has an entry a vertex, or none at all
        Mesh {
            positions: Arc::new(VertexBuffer::new(chosen(whole.positions.as_slice(), &vertices, 1))),
            triangles: Arc::new(triangles),
            normals: chosen(&whole.normals, &vertices, 0),
            uvs: chosen(&whole.uvs, &vertices, 0),
            shadow_casting,
            cut: cut(whole, segments),
            material_of,
            groups: Arc::new(groups),
            quadric: None,
            shapes: None,
        }
    }

    /// Number of a vertex in the part; a new one is added to `vertices`.
    fn number(&mut self, vertex: u32, vertices: &mut Vec<u32>) -> u32 {
        let number = &mut self.number_of[vertex as usize];
        if *number == NOT_THERE {
            *number = vertices.len() as u32;
            vertices.push(vertex);
        }
        *number
    }
}

/// Entries of the part's vertices, with room for `more`; none if the whole has none.
fn chosen<T: Copy>(of_whole: &[T], vertices: &[u32], more: usize) -> Vec<T> {
    if of_whole.is_empty() {
        return Vec::new();
    }
    let mut list = Vec::with_capacity(vertices.len() + more);
    list.extend(vertices.iter().map(|vertex| of_whole[*vertex as usize]));
    list
}

/// Cut-out triangles of a part: they follow each other there as well.
fn cut(whole: &Mesh, segments: &[&Segment]) -> Option<Arc<CutTriangles>> {
    let cut = whole.cut.as_deref()?;
    let (mut first, mut before, mut mask_of) = (0, 0, Vec::new());
    for of in segments {
        let all = cut.range();
        let own = of.triangles.start.max(all.start)..of.triangles.end.min(all.end);
        if own.start < own.end {
            if mask_of.is_empty() {
                first = before + own.start - of.triangles.start;
            }
            mask_of.extend_from_slice(&cut.mask_of[own.start - all.start..own.end - all.start]);
        }
        before += of.triangles.len();
    }
    let masks = cut.masks.clone();
    (!mask_of.is_empty()).then(|| Arc::new(CutTriangles { first: first as u32, mask_of, masks }))
}
