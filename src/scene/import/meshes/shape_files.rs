//! Reads the shapes of a deforming model from files that hold other positions for its OBJ file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::point_cache;
use crate::digest::Digest;
use crate::scene::import::deformed::Distinct;
use crate::scene::import::faces::{TriangleSoup, are_within_reach};
use crate::scene::import::obj;
use crate::scene::{Mesh, SceneError, Shapes, Triangles};

/// A file of a sequence.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Numbered {
    /// Number in its name.
    pub number: i64,
    /// Path of the file.
    pub path: PathBuf,
}

/// Origins of a mesh's vertices in its OBJ file.
pub(crate) struct Origins {
    /// Number of each vertex's position in the file, from 0.
    pub of_vertex: Vec<u32>,
    /// Number of positions in the file.
    pub count: usize,
}

impl Origins {
    /// Reads the origins from an OBJ file.
    pub fn new(obj: &TriangleSoup) -> Self {
        let own = || (0..obj.positions.len() as u32).collect();
        let of_vertex = if obj.sources.is_empty() { own() } else { obj.sources.clone() };
        Self { of_vertex, count: obj.places }
    }
}

/// Source of shapes.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum ShapeSource {
    /// A file for each shape, in the order of their numbers; at least one.
    Files(Vec<Numbered>),
    /// A point cache.
    Cache(PathBuf),
}

impl ShapeSource {
    /// The files that are read.
    pub fn files(&self) -> Vec<PathBuf> {
        match self {
            Self::Files(files) => files.iter().map(|file| file.path.clone()).collect(),
            Self::Cache(path) => vec![path.clone()],
        }
    }
}

/// Content of a sequence of shapes.
#[derive(Clone)]
pub(crate) struct ReadShapes {
    /// The mesh with its shapes.
    pub mesh: Arc<Mesh>,
    /// Keys in order: the time of a shape, in steps of its source, and the shape's number. Equal shapes have
    /// the same number.
    pub keys: Arc<Vec<(f64, u32)>>,
    /// First sample and time between two samples, in frames, as a point cache states them.
    pub says: Option<(f64, f64)>,
    /// Digest of the files and their numbers.
    pub digest: Digest,
}

/// Gives `mesh`, which was read from `path`, the shapes in `source`. `origins`: the places of its vertices in
/// that file.
///
/// # Errors A file that cannot be read, or that has other positions than the mesh.
pub fn read(
    mesh: &Mesh,
    path: &Path,
    origins: &Origins,
    source: &ShapeSource,
) -> Result<ReadShapes, SceneError> {
    let mut read = Distinct::default();
    let (mut digests, mut says) = (Vec::new(), None);
    match source {
        ShapeSource::Files(files) => {
            check_memory(path, files.len(), origins)?;
            for Numbered { number, path: file } in files {
                let (positions, digest) = obj::read_positions(file)?;
                digests.extend([Digest::new(&number.to_le_bytes()), digest]);
                read.add(*number as f64, shape_of(file, &positions, path, origins)?);
            }
        }
        ShapeSource::Cache(file) => {
            let cache = point_cache::read(file)?;
            check_memory(path, cache.samples.len(), origins)?;
            (says, digests) = (Some((cache.first, cache.every)), vec![cache.digest]);
            for (number, positions) in cache.samples.iter().enumerate() {
                read.add(number as f64, shape_of(file, positions, path, origins)?);
            }
        }
    }
    let Triangles { corners, normals, .. } = mesh.triangles();
    let shapes = Arc::new(Shapes::new(read.list, corners, normals, &origins.of_vertex));
    Ok(ReadShapes {
        mesh: Arc::new(mesh.clone().with_triangles(|triangles| triangles.shapes = Some(shapes))),
        keys: Arc::new(read.keys),
        says,
        digest: Digest::of_all(digests),
    })
}

fn check_memory(path: &Path, shapes: usize, origins: &Origins) -> Result<(), SceneError> {
    let check = Shapes::check_memory(shapes, origins.of_vertex.len());
    check.map_err(|error| SceneError::new(path, error.to_string()))
}

/// Vertex positions of the mesh from `rest` in the shape whose file holds `positions`.
fn shape_of(
    file: &Path,
    positions: &[[f32; 3]],
    rest: &Path,
    origins: &Origins,
) -> Result<Vec<[f32; 3]>, SceneError> {
    let (count, wanted) = (positions.len(), origins.count);
    if count != wanted {
        let message = format!(
            "this shape has {count} positions, and `{}` has {wanted} (`v`): shapes of a model must have the same positions in the \
             same order; export all of them at once, with the same settings",
            rest.display()
        );
        return Err(SceneError::new(file, message));
    }
    let shape: Vec<[f32; 3]> = origins.of_vertex.iter().map(|at| positions[*at as usize]).collect();
    if are_within_reach(&shape) {
        return Ok(shape);
    }
    let is_bad = |at: &&u32| !are_within_reach(&positions[**at as usize..=**at as usize]);
    let first = origins.of_vertex.iter().filter(is_bad).min().map_or(0, |at| *at as usize);
    let message = format!(
        "the position {:?} is not finite, or farther than 1e18 from the origin: export the shape again",
        positions[first]
    );
    // a point cache has no lines
    let line = obj::line_of_position(file, first);
    let error = SceneError::new(file, message);
    Err(line.map_or(error.clone(), |line| error.at_line(line)))
}
