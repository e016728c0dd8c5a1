//! The shot of a bare glTF file: its own camera, lights and animation; and what it lacks, as for a bare OBJ.

use std::path::Path;
use std::sync::Arc;

use toml::Value;

use super::animation::Clip;
use super::bake;
use super::document::Document;
use super::framing::fit;
use super::nodes::Tree;
use super::surrounded;
use super::{cameras, lights};
use crate::scene::SceneError;
use crate::scene::import::cameras::settings;
use crate::scene::import::part_of_file::NodeTrack;
use crate::scene::keys::{Digits, FileTables, Rate};
use crate::scene::turntable::Options;
use crate::scene::turntable::text::{HEAD, INDIRECT, LIGHT, around, floor};
use crate::scene::written::{BareShot, Written};

/// Frames in a second.
const RATE: u32 = 24;

/// Reads the glTF file at `path`, and makes its shot.
///
/// # Errors Those of the file.
pub(crate) fn read(path: &Path, options: &Options) -> Result<(Arc<Document>, BareShot), SceneError> {
    let document = Document::open(path)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let shot = bare(&document, &name, options)?;
    Ok((Arc::new(document), shot))
}

/// Writes the shot of the glTF file at `path`, which the shot names `model`.
///
/// # Errors Those of the file.
pub fn text(path: &Path, model: &str, options: &Options) -> Result<Written, SceneError> {
    Ok(bare(&Document::open(path)?, model, options)?.written())
}

fn bare(document: &Document, model: &str, options: &Options) -> Result<BareShot, SceneError> {
    let tree = Tree::new(document)?;
    let clip = Clip::read(document, options.animation.as_deref(), RATE.into())?;
    let cameras = cameras::nodes(document, &tree);
    let nodes = lights::nodes(document, &tree.shown)?;
    let first = match &options.camera {
        Some(name) => {
            let chosen = cameras::chosen(document, &tree, Some(name));
            Some(chosen.map_err(|what| document.fault(format!("--camera {what}")))?)
        }
        None => cameras.first().copied(),
    };
    let wanted = nodes.iter().map(|(node, _)| *node).chain(first.map(|(node, _)| node)).collect();
    let tracks = bake::tracks(document, &tree, &clip, &wanted)?;
    let name = |node: usize| cameras::name(document, node);
    let (mut notes, mut stage) = (Vec::new(), String::new());
    let seen = first.and_then(|(node, camera)| Some((camera, tracks.get(&node)?)));
    let (around_it, mut tables) = if let Some((camera, track)) = seen {
        if cameras.len() > 1 && options.camera.is_none() {
            let shown = first.map_or(String::new(), |(node, _)| name(node));
            let count = cameras.len();
            notes.push(format!(
                "of {count} cameras the first is shown: `{shown}` (--camera NAME shows another)"
            ));
        }
        let eye = track.map.values().next().map(|map| map.translation);
        if let (true, Some(eye)) = (nodes.is_empty(), eye)
            && let Some(around) = surrounded::by(document, (&tree, &clip), eye)?
        {
            notes.push(format!(
                "`{around}` lies all around the camera, and may keep out the sky and lights that stand in for those of the file: if it \
                 is dark in there, `afterimage init` writes the shot, for a [[light]] within or `ke` in a [[material]]"
            ));
        }
        (String::new(), own_camera(document, (camera, track), clip.end, options.size)?)
    } else {
        let fit = fit(document, (&tree, &clip), options.size)?;
        notes.push(String::from("the file has no camera: one goes once around all of it"));
        if nodes.is_empty() {
            stage = floor(&fit);
        }
        (around(&fit, options.size), FileTables::default())
    };
    let mut stand_in = "";
    for (node, number) in &nodes {
        if let Some(track) = tracks.get(node) {
            tables.lights.push(lights::table(document, *number, &name(*node), track)?);
        }
    }
    if nodes.is_empty() {
        stand_in = LIGHT;
        notes.push(String::from("the file has no lights: a sky and two soft lights stand in for them"));
    } else if lights::is_of_blender(document) {
        notes.push(String::from("the lights of the file are of Blender: 683 lumens are taken for a watt"));
    }
    let model = Value::from(model);
    let animation = options.animation.as_deref().map(Value::from);
    let animation = animation.map_or(String::new(), |name| format!("animation = {name}\n"));
    let text = [
        format!("{HEAD}{around_it}"),
        format!("\n[[model]]\ngltf = {model}\n{animation}{stage}"),
        format!("{stand_in}{INDIRECT}"),
    ];
    Ok(BareShot { text, tables, notes })
}

/// Settings and the file's own camera; `end`: last frame of the animation.
fn own_camera(
    document: &Document,
    (camera, track): (usize, &NodeTrack),
    end: f64,
    size: [u32; 2],
) -> Result<FileTables, SceneError> {
    let camera = document.get(&document.json.cameras, camera, "camera")?;
    let size = cameras::size(camera).unwrap_or(size);
    let frames = format!("1-{}", end.floor());
    Ok(FileTables {
        render: Some(settings(size, frames, Rate::Whole(RATE.into()))),
        camera: Some(cameras::table(document, camera, track)?),
        digits: Digits::Short,
        ..FileTables::default()
    })
}
