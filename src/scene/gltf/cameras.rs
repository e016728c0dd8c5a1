//! Cameras of glTF files, as keys of a shot file.

use super::document::Document;
use super::json::Camera;
use super::nodes::Tree;
use crate::scene::SceneError;
use crate::scene::keys::spelling;
use crate::scene::part_of_file::NodeTrack;
use crate::scene::written::{CameraKey, camera_keys, size_of_ratio};

/// Maximum number of names that an error lists.
const MOST_LISTED: usize = 20;

/// Size of the picture that a camera asks for: width and height, pixels.
pub fn size(camera: &Camera) -> Option<[u32; 2]> {
    let ratio = match (&camera.perspective, &camera.orthographic) {
        (Some(lens), _) => lens.aspect_ratio?,
        (None, Some(lens)) => (lens.xmag / lens.ymag).abs(),
        (None, None) => return None,
    };
    size_of_ratio(ratio)
}

/// Nodes of the scene that have a camera, and the number of each one's camera.
pub fn nodes(document: &Document, tree: &Tree) -> Vec<(usize, usize)> {
    let nodes = &document.json.nodes;
    tree.shown.iter().filter_map(|node| Some((*node, nodes[*node].camera?))).collect()
}

/// Name of a node.
pub fn name(document: &Document, node: usize) -> String {
    document.json.nodes[node].name.clone().unwrap_or_else(|| format!("node {node}"))
}

/// Finds the camera called `name`, by its node or else by its own name: its node and its number. Without a name the first one. The
/// error is the end of a sentence about the choice.
pub fn chosen(document: &Document, tree: &Tree, name_of_it: Option<&str>) -> Result<(usize, usize), String> {
    let all = nodes(document, tree);
    let first = all
        .first()
        .copied()
        .ok_or("names a file that has no camera: write keys of one, or export it with one")?;
    let Some(wanted) = name_of_it else { return Ok(first) };
    let own = |camera: usize| document.json.cameras.get(camera).and_then(|camera| camera.name.as_deref());
    let by_node = all.iter().find(|(node, _)| name(document, *node) == wanted);
    let found = by_node.or_else(|| all.iter().find(|(_, camera)| own(*camera) == Some(wanted)));
    found.copied().ok_or_else(|| {
        let known: Vec<String> = all.iter().map(|(node, _)| name(document, *node)).collect();
        let hint = spelling::hint(wanted, known.iter().map(String::as_str));
        let list: Vec<String> = known.iter().take(MOST_LISTED).map(|name| format!("`{name}`")).collect();
        format!("names the camera `{wanted}`, which is not there{hint} (there: {})", list.join(", "))
    })
}

/// Writes `[camera]` and its keys.
///
/// # Errors A lens that makes no sense.
pub fn text(document: &Document, camera: &Camera, track: &NodeTrack) -> Result<String, SceneError> {
    let lens = match (camera.kind.as_str(), &camera.perspective, &camera.orthographic) {
        ("perspective", Some(lens), _) => {
            let fov = lens.yfov.to_degrees();
            (0.001..179.9).contains(&fov).then(|| format!("fov = {fov}\n"))
        }
        ("orthographic", _, Some(lens)) => {
            let height = 2.0 * lens.ymag.abs();
            (1e-9..1e9).contains(&height).then(|| format!("height = {height}\n"))
        }
        _ => None,
    };
    let lens = lens
        .ok_or_else(|| document.fault("its camera has no field of view that makes sense: export it again"))?;
    let mut text = String::new();
    if camera.kind == "orthographic" {
        text += "\n[camera]\nprojection = \"orthographic\"\n";
    }
    let keys = track.map.frames().zip(track.map.values());
    let keys = keys.enumerate().map(|(i, (frame, map))| CameraKey {
        frame: if track.map.is_constant() { 1.0 } else { frame },
        map,
        lens: if i == 0 { lens.clone() } else { String::new() },
    });
    Ok(text + &camera_keys(keys, &track.map.cut_frames()))
}
