//! The shot of a bare USD file: its own camera, lights and animation; and what it lacks, as for a bare OBJ.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use toml::Value;

use super::choice::ViewChoice;
use super::clock::Clock;
use super::file::{Content, UsdCamera, UsdFile, UsdLightKind};
use super::{cameras, lights, written};
use crate::scene::SceneError;
use crate::scene::import::faces::are_within_reach;
use crate::scene::keys::{FileTables, Rate};
use crate::scene::turntable::corners::Corners;
use crate::scene::turntable::text::{HEAD, INDIRECT, LIGHT, around, floor};
use crate::scene::turntable::{Fit, Options, Up};
use crate::scene::written::{BareShot, Written};

/// Reads the USD file at `path`, and makes its shot.
///
/// # Errors Those of the file.
pub(crate) fn read(path: &Path, options: &Options) -> Result<(Arc<UsdFile>, BareShot), SceneError> {
    let file = UsdFile::open(path, &options.usd, Some(&view(options)))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let shot = bare(&file, &name, options)?;
    Ok((Arc::new(file), shot))
}

/// Writes the shot of the USD file at `path`, which the shot names `model`.
///
/// # Errors Those of the file.
pub fn text(path: &Path, model: &str, options: &Options) -> Result<Written, SceneError> {
    let file = UsdFile::open(path, &options.usd, Some(&view(options)))?;
    Ok(bare(&file, model, options)?.written())
}

/// What is chosen for the picture.
fn view(options: &Options) -> ViewChoice {
    ViewChoice {
        camera: options.camera.clone(),
        settings: options.render_settings.clone(),
        only_seen: options.only_seen,
    }
}

fn bare(file: &UsdFile, model: &str, options: &Options) -> Result<BareShot, SceneError> {
    let content = &file.content;
    let (mut notes, mut stage) = (Vec::new(), String::new());
    let (around_it, mut tables) = match chosen(content) {
        Some(camera) => {
            if content.cameras.len() > 1 && content.camera.is_none() {
                let count = content.cameras.len();
                notes.push(format!(
                    "of {count} cameras the first is shown: `{}`; --camera names another one",
                    camera.name
                ));
            }
            let settings = (frames(file), rate(&content.clock));
            (String::new(), cameras::tables(camera, options.size, content.render.as_ref(), settings))
        }
        None => {
            let fit = fit(file, options.size)?;
            let what =
                if file.choice.mask.is_empty() { "the file" } else { "what the mask leaves of the file" };
            notes.push(format!("{what} has no camera: one goes once around all of it"));
            if !content.has_lights {
                stage = floor(&fit);
            }
            (around(&fit, options.size), FileTables::default())
        }
    };
    tables.lights = content.lights.iter().filter_map(|light| lights::table(content, light)).collect();
    let domes: Vec<_> =
        content.lights.iter().filter(|light| matches!(light.kind, UsdLightKind::Dome { .. })).collect();
    if let Some(dome) = domes.first() {
        (tables.background, tables.environment) = lights::dome(dome, &mut notes);
    }
    if domes.len() > 1 {
        notes.push(String::from("of several lights from all around (DomeLight) the first one shines"));
    }
    let mut stand_in = "";
    if !content.has_lights {
        stand_in = LIGHT;
        let what = if file.choice.mask.is_empty() { "the file" } else { "what the mask leaves of the file" };
        notes.push(format!("{what} has no lights: a sky and two soft lights stand in for them"));
    } else if content.lights.is_empty() {
        notes.push(String::from("none of the file's lights shines, so it is dark"));
    }
    notes.extend(content.note.clone());
    if !content.variants.is_empty() {
        notes.push(format!("variants: {}; --variant chooses others", content.variants.join(", ")));
    }
    let model = Value::from(model);
    let stage_of = written::stage(&file.choice);
    let output = written::output(file, chosen(content).map_or(0.0, |camera| camera.stops));
    let text = [
        format!("{HEAD}{around_it}"),
        format!("\n[[model]]\nusd = {model}\n{stage_of}{stage}"),
        format!("{stand_in}{INDIRECT}{output}"),
    ];
    Ok(BareShot { text, tables, notes })
}

/// The camera that is chosen or that the file's settings name, or else the first one.
fn chosen(content: &Content) -> Option<&UsdCamera> {
    let named = content.camera.as_ref();
    let found = named.and_then(|path| content.cameras.iter().find(|camera| camera.path == *path));
    found.or_else(|| content.cameras.first())
}

/// Frames of a file: those that it states, or those between its first and last key.
fn frames(file: &UsdFile) -> String {
    let content = &file.content;
    let keys = || {
        let cameras = chosen(content).into_iter().flat_map(|camera| camera.keys.iter().map(|key| key.frame));
        let maps = content.shown.iter().filter(|shown| !shown.map.is_constant());
        let shapes = content.meshes.iter().flat_map(|mesh| mesh.frames_of_shapes());
        maps.flat_map(|shown| shown.map.frames()).chain(cameras).chain(shapes)
    };
    let [first, last] = content.clock.range.unwrap_or_else(|| {
        let ends =
            keys().fold([f64::MAX, f64::MIN], |[first, last], frame| [first.min(frame), last.max(frame)]);
        if ends[0] <= ends[1] { ends } else { [1.0, 1.0] }
    });
    let first = first.ceil().clamp(-1e6, 1e6) as i64;
    let last = (last.floor().clamp(-1e6, 1e6) as i64).clamp(first, first + 999_999);
    format!("{first}:{last}")
}

/// Frames in a second, as a shot file states them.
fn rate(clock: &Clock) -> Rate {
    let rate = clock.rate;
    if (rate - rate.round()).abs() < 1e-6 {
        return Rate::Whole(rate.round() as i64);
    }
    // of television: 23.976 is 24000/1001
    let exact = rate * 1001.0 / 1000.0;
    if (exact - exact.round()).abs() < 0.01 {
        return Rate::Text(format!("{}/1001", 1000 * exact.round() as i64));
    }
    Rate::Text(format!("{}/1000", ((rate * 1000.0).round() as i64).max(1)))
}

/// Fits a camera around all that is shown at the first frame.
fn fit(file: &UsdFile, size: [u32; 2]) -> Result<Fit, SceneError> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let frame = file.content.clock.first();
    for shown in file.content.shown.iter().filter(|shown| shown.visible.at(frame)) {
        let (mesh, map) = (&file.content.meshes[shown.mesh], shown.map.at(frame));
        let first = positions.len() as u32;
        let place =
            |position: &[f32; 3]| map.transform_point3(Vec3::from(*position).as_dvec3()).as_vec3().to_array();
        if let Some(curves) = &mesh.curves {
            positions.extend(curves.points.iter().map(place));
            triangles.extend((first..positions.len() as u32).map(|point| [point; 3]));
            continue;
        }
        positions.extend(mesh.positions_at(frame).iter().map(place));
        triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(|corner| corner + first)));
    }
    if triangles.is_empty() || !are_within_reach(&positions) {
        let why = file.content.defects.first().map_or(String::new(), |defect| format!(" ({defect})"));
        let has_volumes = file.content.meshes.iter().any(|mesh| mesh.volume.is_some());
        let why =
            if has_volumes { String::from(" (no camera is fitted around volumes: add one)") } else { why };
        let message = format!("it shows no meshes with triangles, or none within 1e18 of the origin{why}");
        return Err(file.fault(message));
    }
    let [width, height] = size.map(f64::from);
    let corners = Corners { positions: &positions, triangles: &triangles };
    Ok(Fit::new(&corners, Up::Y, width / height))
}
