//! Cameras of glTF files, as tables of a shot file.

use super::document::Document;
use super::json::Camera;
use super::nodes::Tree;
use crate::scene::SceneError;
use crate::scene::camera::{FARTHEST_PLANE, Projection};
use crate::scene::import::cameras::{self, size_of_ratio};
use crate::scene::import::part_of_file::NodeTrack;
use crate::scene::keys::camera::{CameraKey, CameraTable};
use crate::scene::keys::spelling;
use crate::scene::keys::toml_text::At;

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

/// Lens of a camera, which does not change.
#[derive(Clone, Copy)]
struct Lens {
    /// Vertical field of view, degrees; or the height of what is seen.
    fov_or_height: f64,
    /// Distances of the near and the far clipping plane.
    planes: [Option<f64>; 2],
}

/// The table of a camera. Clipping planes that make no sense are left out.
///
/// # Errors A lens that makes no sense.
pub fn table(document: &Document, camera: &Camera, track: &NodeTrack) -> Result<CameraTable, SceneError> {
    let lens = match (camera.kind.as_str(), &camera.perspective, &camera.orthographic) {
        ("perspective", Some(lens), _) => {
            let fov = lens.yfov.to_degrees();
            let fits = (0.001..179.9).contains(&fov);
            fits.then(|| Lens { fov_or_height: fov, planes: planes(document, lens.znear, lens.zfar) })
        }
        ("orthographic", _, Some(lens)) => {
            let height = 2.0 * lens.ymag.abs();
            let fits = (1e-9..1e9).contains(&height);
            fits.then(|| Lens { fov_or_height: height, planes: planes(document, lens.znear, lens.zfar) })
        }
        _ => None,
    };
    let lens = lens
        .ok_or_else(|| document.fault("its camera has no field of view that makes sense: export it again"))?;
    let projection = (camera.kind == "orthographic").then_some(Projection::Orthographic);
    let is_resting = track.map.is_constant();
    let keys = track.map.frames().zip(track.map.values()).enumerate().map(|(i, (frame, map))| {
        let key = cameras::key(if is_resting { 1.0 } else { frame }, map);
        // the others have the lens of the first
        if i == 0 { seen_through(lens, projection, key) } else { key }
    });
    Ok(cameras::table(projection, keys, &track.map.cut_frames()))
}

/// A key with a lens.
fn seen_through(lens: Lens, projection: Option<Projection>, key: CameraKey) -> CameraKey {
    let Lens { fov_or_height, planes } = lens;
    let view = Some(At::of(fov_or_height));
    let (fov, height) = if projection.is_some() { (None, view) } else { (view, None) };
    let [near, far] = planes.map(|depth| depth.map(At::of));
    CameraKey { fov, height, near, far, ..key }
}

/// Distances of the clipping planes of a camera. Those that cut nothing off are taken out again when the shot is loaded, with all others of
/// shots.
fn planes(document: &Document, near: Option<f64>, far: Option<f64>) -> [Option<f64>; 2] {
    // some programs write 0, others a distance behind the eye: nothing is cut off there
    let near = near.filter(|near| *near > 0.0);
    if far.is_some_and(|far| far <= near.unwrap_or(0.0)) || near.is_some_and(|near| near > FARTHEST_PLANE) {
        document.leave_out(
            "clipping planes of a camera (znear, zfar) leave nothing between them, and are not used",
        );
        return [None; 2];
    }
    [near, far.filter(|far| *far <= FARTHEST_PLANE)]
}
