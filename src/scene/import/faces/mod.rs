//! Faces of files of any format, and the triangles that they are cut into.

mod face_lists;
pub mod polygon;
pub mod run;
pub mod triangulate;

use glam::{Vec2, Vec3};
use half::f16;
use rayon::prelude::*;

pub use face_lists::FaceLists;

/// Maximum of coordinates. Larger ones are refused: Embree silently ignores such triangles.
pub const LARGEST_COORDINATE: f32 = 1e18;

/// Triangles of a file, with the names of their materials and groups.
#[derive(Debug, Default, PartialEq)]
pub struct TriangleSoup {
    /// Vertex positions, object space, finite. The list has room for one more.
    pub positions: Vec<[f32; 3]>,
    /// Number of each vertex's position (`v`) in the file, from 0; empty if these are the vertices' own
    /// numbers.
    pub sources: Vec<u32>,
    /// Number of positions in the file.
    pub places: usize,
    /// Normals, one a vertex or none at all; unit length, or zero where the file has none that is usable.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, one a vertex or none at all; finite.
    pub uvs: Vec<Vec2>,
    /// Colours of the vertices, one a vertex or none at all; linear RGB.
    pub colors: Vec<[f16; 3]>,
    /// Vertices of the triangles. Never empty; each triangle has an area.
    pub triangles: Vec<[u32; 3]>,
    /// Runs of consecutive triangles with the same of `materials` and `groups`, as length and use; lengths
    /// are above 0.
    pub uses: Vec<(usize, Use)>,
    /// Names of materials by their first use; the first is empty, for faces before any.
    pub materials: Vec<Named>,
    /// Names after `g` and `o` by their first use; the first is `default`, for faces before any.
    pub groups: Vec<Named>,
    /// Names of files that define materials (`mtllib`), in order.
    pub libraries: Vec<Named>,
    /// Normals that are not finite numbers, if there are any. If they belong to corners, the faces' own
    /// normals replace them.
    pub odd_normals: Option<OddNormals>,
}

/// Normals (`vn`) of a file that are not finite numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OddNormals {
    /// Number of them.
    pub count: usize,
    /// Line of the first, from 1.
    pub line: usize,
}

/// A name in the text and the first line that has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// Name, trimmed; may hold spaces.
    pub name: String,
    /// Line, from 1.
    pub line: usize,
}

/// Material, group and object of a face, as indices into the file's names.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Use {
    /// Material of the last `usemtl`.
    pub material: u32,
    /// Group of the last `g` or `o`.
    pub group: u32,
    /// Object of the last `o`: a name among those of the groups.
    pub object: u32,
}

/// Returns true if all coordinates are numbers that can be used.
pub fn are_within_reach(positions: &[[f32; 3]]) -> bool {
    // without an early end for each number, several are compared at once
    let all = |block: &[f32]| block.iter().fold(true, |all, x| all & (x.abs() <= LARGEST_COORDINATE));
    positions.as_flattened().par_chunks(1 << 14).all(all)
}
