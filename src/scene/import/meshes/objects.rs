//! Parts of the mesh of an OBJ file: its triangles of some objects or groups, with their vertices.

use std::collections::HashMap;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use crate::scene::cutout::CutTriangles;
use crate::scene::details::{Details, ObjectSpace};
use crate::scene::keys::model::Division;
use crate::scene::mesh::Groups;
use crate::scene::{Geometry, Mesh, Triangles};

/// Vertex of the whole mesh that a part does not have.
const NOT_THERE: u32 = u32::MAX;

/// Parts that were taken out of OBJ files.
#[derive(Default)]
pub(super) struct Parts {
    /// Parts by file and name, for copies.
    pub by_name: HashMap<(PathBuf, String), Arc<Mesh>>,
    /// All parts of a file, by division.
    pub divided: HashMap<(PathBuf, Division), Arc<Vec<PartOfObj>>>,
}

/// A part of an OBJ file.
pub(crate) struct PartOfObj {
    /// Name of the object or group; `default` for faces that are in none.
    pub name: String,
    /// The mesh, with the groups that the file puts its triangles in.
    pub mesh: Arc<Mesh>,
}

/// Run of consecutive triangles of one object and one group, by the numbers of their names.
pub(super) struct Segment {
    pub triangles: Range<usize>,
    pub object: u32,
    pub group: u32,
}

/// Takes parts out of a mesh, one after the other.
pub(super) struct Taker<'a> {
    whole: &'a Mesh,
    all: &'a Triangles,
    /// Number in the part at work for each vertex of the whole; `NOT_THERE` between parts.
    number_of: Vec<u32>,
}

impl<'a> Taker<'a> {
    /// Creates a taker of parts of `whole`, which is made of triangles.
    pub fn new(whole: &'a Mesh) -> Self {
        let all = whole.triangles();
        Self { whole, all, number_of: vec![NOT_THERE; all.positions.as_slice().len()] }
    }

    /// Makes a mesh of the triangles of `segments`, in their order, so that those which cast shadows stay first.
    pub fn take(&mut self, segments: &[&Segment]) -> Mesh {
        let (whole, all) = (self.whole, self.all);
        let count = segments.iter().map(|of| of.triangles.len()).sum();
        let (mut triangles, mut material_of) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let (mut groups, mut vertices) = (Groups::named(whole.groups.names().iter().cloned()), Vec::new());
        for of in segments {
            groups.begin(triangles.len() as u32, of.group);
            material_of.extend_from_slice(&whole.material_of[of.triangles.clone()]);
            let own = all.corners[of.triangles.clone()].iter();
            triangles.extend(own.map(|corners| corners.map(|vertex| self.number(vertex, &mut vertices))));
        }
        vertices.iter().for_each(|vertex| self.number_of[*vertex as usize] = NOT_THERE);
        let casting = |of: &&Segment| whole.shadow_casting.clamp(of.triangles.start, of.triangles.end);
        let shadow_casting = segments.iter().map(|of| casting(of) - of.triangles.start).sum();
        let of_segments =
            |of: &&Segment| whole.details.tangents.get(of.triangles.clone()).unwrap_or_default();
        let tangents = segments.iter().flat_map(of_segments).copied().collect();
        // each part has a box of its own, as if it came from a file of its own
        let positions = chosen(all.positions.as_slice(), &vertices, 1);
        let space = whole.details.space.map(|_| ObjectSpace::around(&positions));
        let details = Details {
            colors: chosen(&whole.details.colors, &vertices, 0),
            second_uvs: chosen(&whole.details.second_uvs, &vertices, 0),
            alphas: chosen(&whole.details.alphas, &vertices, 0),
            tangents,
            space,
            volume: None,
            cage: None,
        };
        // a list that has an entry a vertex, or none at all
        Mesh {
            geometry: Geometry::Triangles(Triangles {
                normals: chosen(&all.normals, &vertices, 0),
                uvs: chosen(&all.uvs, &vertices, 0),
                ..Triangles::new(positions, triangles)
            }),
            shadow_casting,
            cut: cut(whole, segments),
            material_of,
            groups: Arc::new(groups),
            details: Arc::new(details),
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
