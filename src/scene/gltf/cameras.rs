//! Cameras of glTF files, as keys of a shot file.

use super::document::Document;
use super::json::Camera;
use crate::scene::SceneError;
use crate::scene::part_of_file::NodeTrack;
use crate::scene::written::{CameraKey, camera_keys, size_of_ratio};

/// Size of the picture that a camera asks for: width and height, pixels.
pub fn size(camera: &Camera) -> Option<[u32; 2]> {
    let ratio = match (&camera.perspective, &camera.orthographic) {
        (Some(lens), _) => lens.aspect_ratio?,
        (None, Some(lens)) => (lens.xmag / lens.ymag).abs(),
        (None, None) => return None,
    };
    size_of_ratio(ratio)
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
