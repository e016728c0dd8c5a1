//! Cameras of glTF files, as keys of a shot file.

use std::fmt::Write;

use glam::{DAffine3, DVec3};

use super::bake::NodeTrack;
use super::document::Document;
use super::json::Camera;
use super::nodes::Tree;
use crate::scene::SceneError;
use crate::scene::keys::spelling;

/// Height of a picture whose width follows from the camera, pixels.
const HEIGHT: f64 = 720.0;

/// Ratios of width to height that are taken from a camera.
const RATIOS: std::ops::RangeInclusive<f64> = 0.1..=10.0;

/// Maximum number of names that an error lists.
const MOST_LISTED: usize = 20;

/// Roll below which a camera is level, degrees: files keep rotations as single floats.
const LEAST_ROLL: f64 = 1e-4;

/// Size of the picture that a camera asks for: width and height, pixels.
pub fn size(camera: &Camera) -> Option<[u32; 2]> {
    let ratio = match (&camera.perspective, &camera.orthographic) {
        (Some(lens), _) => lens.aspect_ratio?,
        (None, Some(lens)) => (lens.xmag / lens.ymag).abs(),
        (None, None) => return None,
    };
    RATIOS.contains(&ratio).then(|| [(ratio * HEIGHT).round() as u32, HEIGHT as u32])
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
    let cuts = track.map.cut_frames();
    let mut turned = 0.0;
    let maps: Vec<(f64, DAffine3)> = track.map.frames().zip(track.map.values()).collect();
    for (i, (frame, map)) in maps.into_iter().enumerate() {
        let View { eye, target, roll } = View::of(map);
        // the shorter way from key to key
        turned += (roll - turned + 180.0).rem_euclid(360.0) - 180.0;
        let frame = if track.map.is_constant() { 1.0 } else { frame };
        let _ = write!(
            text,
            "\n[[camera.key]]\nframe = {frame}\neye = {}\ntarget = {}\n",
            list(eye),
            list(target)
        );
        if f64::abs(turned) > LEAST_ROLL {
            let _ = writeln!(text, "roll = {turned}");
        }
        if i == 0 {
            text += &lens;
        } else if frame.fract() == 0.0 && cuts.contains(&frame) {
            text += "cut = true\n";
        }
    }
    Ok(text)
}

/// Place and direction of a camera.
struct View {
    eye: DVec3,
    target: DVec3,
    /// Degrees, clockwise.
    roll: f64,
}

impl View {
    /// View of a camera that looks along -Z of its node. The target is the point nearest to the origin, if it is before the camera.
    fn of(map: DAffine3) -> Self {
        let axis = |axis: DVec3| axis.normalize_or_zero();
        let (eye, forward) = (map.translation, axis(-map.matrix3.z_axis));
        let right = forward.cross(axis(map.matrix3.y_axis));
        let level = forward.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
        let roll = f64::atan2(-right.dot(level.cross(forward)), right.dot(level)).to_degrees();
        let ahead = -eye.dot(forward);
        let distance = if ahead > 1e-3 * eye.length() { ahead } else { 1.0 };
        Self { eye, target: eye + forward * distance, roll }
    }
}

/// Formats a vector with all of its digits.
pub fn list(vector: DVec3) -> String {
    let [x, y, z] = vector.to_array().map(number);
    format!("[{x}, {y}, {z}]")
}

/// Formats a number with all of its digits, so that it is one of TOML.
pub fn number(value: f64) -> String {
    // never a whole number of more than 64 bits
    format!("{value:?}")
}
