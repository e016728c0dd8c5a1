//! Makes the mesh of an OBJ or PLY file whose materials are known.

use std::iter;
use std::ops::Range;
use std::sync::Arc;

use crate::scene::cutout::VertexData;
use crate::scene::details::Details;
use crate::scene::import::arrange::Arranger;
use crate::scene::import::faces::{TriangleSoup, Use};
use crate::scene::mesh::Groups;
use crate::scene::{Geometry, Mesh, Triangles};

/// A run of consecutive triangles that have the same material and group.
struct Stretch {
    range: Range<usize>,
    of: Use,
}

/// Orders the triangles: first those that cast shadows, each kind in the order of the file. Returns also the objects, as runs
/// of triangles.
pub fn mesh_of(arranger: Arranger<'_>, obj: TriangleSoup, ids: &[u16]) -> (Mesh, Groups) {
    let id = |stretch: &Stretch| ids[stretch.of.material as usize];
    let has = VertexData { uvs: !obj.uvs.is_empty(), alphas: false };
    let casts = |stretch: &Stretch| arranger.casts_shadow_on(id(stretch), has);
    let rank = |stretch: &Stretch| arranger.rank(id(stretch), has);
    let mut stretches = Vec::with_capacity(obj.uses.len());
    let mut begin = 0;
    for (count, of) in &obj.uses {
        stretches.push(Stretch { range: begin..begin + count, of: *of });
        begin += count;
    }
    let casting = stretches.iter().filter(|stretch| casts(stretch));
    let shadow_casting = casting.map(|stretch| stretch.range.len()).sum();
    let mut triangles = obj.triangles;
    if !stretches.is_sorted_by_key(rank) {
        stretches.sort_by_key(rank);
        let mut ordered = Vec::with_capacity(triangles.len());
        stretches.iter().for_each(|stretch| ordered.extend_from_slice(&triangles[stretch.range.clone()]));
        triangles = ordered;
    }
    let mut material_of = Vec::with_capacity(triangles.len());
    let mut groups = Groups::named(obj.groups.into_iter().map(|group| group.name));
    let mut objects = Groups::named(iter::empty()); // their names are among those of the groups
    for stretch in &stretches {
        groups.begin(material_of.len() as u32, stretch.of.group);
        objects.begin(material_of.len() as u32, stretch.of.object);
        material_of.extend(iter::repeat_n(id(stretch), stretch.range.len()));
    }
    let mesh = Mesh {
        geometry: Geometry::Triangles(Triangles {
            normals: obj.normals,
            uvs: obj.uvs,
            ..Triangles::new(obj.positions, triangles)
        }),
        cut: arranger.cut_triangles(&material_of, has),
        material_of,
        groups: Arc::new(groups),
        shadow_casting,
        details: Arc::new(Details { colors: obj.colors, ..Details::default() }),
    };
    (arranger.with_details(mesh, &[]), objects)
}
