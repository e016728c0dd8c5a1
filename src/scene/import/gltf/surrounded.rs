//! Finds the mesh that shuts out light from without: a sky box, or a room.

use glam::{DAffine3, DVec3};

use super::animation::Clip;
use super::document::Document;
use super::geometry;
use super::nodes::Tree;
use crate::scene::SceneError;

/// Name of the node whose mesh lies around `eye` on all sides at the first frame, if there is one, and emits no light itself.
///
/// # Errors Damaged geometry.
pub fn by(
    document: &Document,
    (tree, clip): (&Tree, &Clip),
    eye: DVec3,
) -> Result<Option<String>, SceneError> {
    let globals = tree.globals(&clip.locals(tree, 1.0));
    for number in &tree.shown {
        let node = &document.json.nodes[*number];
        let Some(mesh) = node.mesh.filter(|_| node.skin.is_none()) else { continue };
        let inside = globals[*number].inverse();
        if inside.is_finite() && surrounds(document, mesh, &inside, eye)? {
            return Ok(Some(node.name.clone().unwrap_or_else(|| format!("node {number}"))));
        }
    }
    Ok(None)
}

/// Returns true if rays from `eye` meet the mesh in all directions of the axes and between them. `inside`: to the space of the mesh.
fn surrounds(document: &Document, mesh: usize, inside: &DAffine3, eye: DVec3) -> Result<bool, SceneError> {
    let geometry = geometry::read(document, mesh)?;
    let mut shutting: Vec<[DVec3; 3]> = Vec::new();
    let mut begin = 0;
    for (count, material) in &geometry.uses {
        let range = begin..begin + count;
        begin += count;
        if is_shutting(document, *material) {
            let place = |corner: u32| DVec3::from(geometry.positions[corner as usize].map(f64::from));
            shutting.extend(geometry.triangles[range].iter().map(|triangle| triangle.map(place)));
        }
    }
    let eye = inside.transform_point3(eye);
    let signs = [-1.0, 0.0, 1.0];
    let mut directions =
        signs.into_iter().flat_map(|x| signs.map(|y| signs.map(|z| DVec3::new(x, y, z)))).flatten();
    // a little beside the axes: boxes have edges there
    let beside = DVec3::new(0.013, 0.007, 0.011);
    Ok(directions.all(|direction| {
        direction == DVec3::ZERO || shutting.iter().any(|triangle| meets(eye, direction + beside, triangle))
    }))
}

/// Returns true if light does not pass a material, and none comes from it.
fn is_shutting(document: &Document, material: Option<usize>) -> bool {
    let Some(json) = material.and_then(|number| document.json.materials.get(number)) else { return true };
    let lets_through = matches!(json.alpha_mode.as_deref(), Some("BLEND" | "MASK"))
        || json.extensions.contains_key("KHR_materials_transmission");
    let emits = json.emissive_factor != [0.0; 3] || json.extensions.contains_key("KHR_materials_unlit");
    !lets_through && !emits
}

/// Returns true if a ray meets a triangle: T. Möller and B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997).
fn meets(from: DVec3, direction: DVec3, [a, b, c]: &[DVec3; 3]) -> bool {
    let (along, across, to) = (*b - *a, *c - *a, from - *a);
    let p = direction.cross(across);
    let volume = along.dot(p);
    let q = to.cross(along);
    let (u, v, t) = (to.dot(p) / volume, direction.dot(q) / volume, across.dot(q) / volume);
    // what has no volume gives no numbers
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0
}
