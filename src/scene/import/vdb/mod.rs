//! OpenVDB's files: what clouds, smoke and fire are simulated as.
//!
//! Grids of floats, and of vectors of three, in trees of the usual shape (5, 4, 3), of any map but that of a camera's view; of versions from
//! 222 on (2013), packed by Zip or Blosc, as floats or halves. All else is told. An own reader: `vdb-rs` 0.6 panics on maps that turn and on
//! files that are cut.

mod header;
mod packed;
mod tree;

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, IVec3};

use self::header::Described;
use self::tree::Coding;
use super::Import;
use crate::digest::Digest;
use crate::input::{self, InputError, Kind};
use crate::memory::{self, Need, Part};
use crate::scene::details::{Details, ObjectSpace};
use crate::scene::import::bytes::Bytes;
use crate::scene::volume::{Grid, Volume};
use crate::scene::{Geometry, Mesh, SceneError, Triangles};

/// Memory for each byte of a file: values are packed, and read twice.
const READING_BYTES: u64 = 6;

/// Reads the grids of a file: those with these names, or without names all of numbers.
///
/// # Errors
/// A file that cannot be read, is none, is cut or damaged, or has no such grid.
pub fn read(import: &mut Import, path: &Path, wanted: Option<&[String]>) -> Result<Volume, SceneError> {
    let wrong = |what: String| SceneError::new(path, format!("the volume cannot be read: {what}"));
    let unreadable = |error: InputError| wrong(error.to_string());
    let input = input::open(path, Kind::Model).map_err(unreadable)?;
    let need =
        Need::new(Part::new("the volume", READING_BYTES * input.length, "coarser voxels, fewer grids"));
    need.check(&memory::left()).map_err(|error| SceneError::new(path, error.to_string()))?;
    let bytes = input.read_all().map_err(unreadable)?;
    import.inputs.add([path.to_path_buf()], Digest::new(&bytes));
    of_bytes(&bytes, wanted).map_err(wrong)
}

/// Reads the grids of a file's bytes.
fn of_bytes(all: &[u8], wanted: Option<&[String]>) -> Result<Volume, String> {
    let mut bytes = Bytes::new(all);
    let grids = header::grids(&mut bytes)?;
    let mut volume = Volume::default();
    let is_wanted = |grid: &&Described| match wanted {
        Some(names) => names.contains(&grid.name),
        None => grid.kind == NUMBERS,
    };
    if let Some(missing) =
        wanted.into_iter().flatten().find(|name| grids.iter().all(|grid| grid.name != **name))
    {
        return Err(format!("it has no grid `{missing}`: {}", listed(&grids)));
    }
    for described in grids.iter().filter(is_wanted) {
        if volume.grid(&described.name).is_none() {
            let grid = grid(&mut bytes, &grids, described);
            volume.grids.push(grid.map_err(|what| format!("{what} (in the grid `{}`)", described.name))?);
        }
    }
    if volume.grids.is_empty() {
        return Err(format!("it has no grid of numbers: {}", listed(&grids)));
    }
    Ok(volume)
}

/// Types of trees that are read.
const NUMBERS: &str = "Tree_float_5_4_3";
const VECTORS: &str = "Tree_vec3s_5_4_3";

fn grid(bytes: &mut Bytes<'_>, all: &[Described], described: &Described) -> Result<Grid, String> {
    let width = match described.kind.as_str() {
        NUMBERS => 1,
        VECTORS => 3,
        other => return Err(format!("it is a `{other}`, and `{NUMBERS}` and `{VECTORS}` are read")),
    };
    let before = described.enter(all, bytes)?;
    let mut grid = Grid::new(described.name.clone(), before.map.inverse(), width == 3);
    let coding = Coding { packing: before.packing, are_halves: described.are_halves, width };
    tree::read(bytes, &coding, &mut grid)?;
    Ok(grid)
}

/// What a file has.
fn listed(grids: &[Described]) -> String {
    let each: Vec<String> = grids.iter().map(|grid| format!("`{}` ({})", grid.name, grid.kind)).collect();
    if each.is_empty() {
        String::from("there is none in it")
    } else {
        format!("there are {}", each.join(", "))
    }
}

/// The mesh of a volume: the box around what is in it, object space, without a surface of its own.
///
/// # Errors
/// A volume that is too wide for what traces it.
pub fn mesh_of(import: &Import, volume: Volume, material: u16) -> Result<Mesh, String> {
    /// Points along an edge of the box, at most.
    const WIDEST: i32 = 12_000;
    let mut positions = Vec::new();
    for grid in &volume.grids {
        // what is between the outermost points and the next ones is less, and not nothing
        let Some([low, high]) = grid.filled_points().map(|[low, high]| [low - 1, high + 1]) else { continue };
        if (high - low).max_element() > WIDEST {
            return Err(format!(
                "the grid `{}` is {} points wide, and {WIDEST} is the most: make it coarser, or divide it",
                grid.name,
                high - low
            ));
        }
        positions.extend(corners(low, high).map(|corner| grid.to_lattice.inverse().transform_point3(corner)));
    }
    // nothing is in a box that nobody sees
    let mut positions: Vec<[f32; 3]> = positions.iter().map(|place| place.as_vec3().to_array()).collect();
    if positions.is_empty() {
        positions = corners(IVec3::ZERO, IVec3::ONE).map(|corner| corner.as_vec3().to_array()).to_vec();
    }
    if positions.len() > 8 {
        // several grids: the box around them
        let space = ObjectSpace::around(&positions);
        let at = |corner: DVec3| (space.low + space.size * corner.as_vec3()).to_array();
        positions = corners(IVec3::ZERO, IVec3::ONE).map(at).to_vec();
    }
    let space = Some(ObjectSpace::around(&positions));
    let geometry = Geometry::Triangles(Triangles::new(positions, SIDES.to_vec()));
    let details = Details { space, volume: Some(Arc::new(volume)), ..Details::default() };
    let mesh = Mesh::plain(geometry, material, import.surfaces.casts_shadow(material));
    Ok(Mesh { details: Arc::new(details), ..mesh })
}

/// Corners of a box: the bits of their numbers are the axes along which they are high.
fn corners(low: IVec3, high: IVec3) -> [DVec3; 8] {
    [0, 1, 2, 3, 4, 5, 6, 7].map(|number| {
        let is_high = IVec3::new(number & 1, number >> 1 & 1, number >> 2).cmpeq(IVec3::ONE);
        IVec3::select(is_high, high, low).as_dvec3()
    })
}

/// Triangles of a box, counter-clockwise seen from outside.
const SIDES: [[u32; 3]; 12] = [
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
];

#[cfg(test)]
mod tests;
