//! `afterimage info`: describes a file, or the program and its libraries.

pub(crate) mod cost;
pub mod exr;
mod extent;
mod pictures;

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use crate::cli::args::{default_output, on_threads, open};
use crate::cli::bare_model::BareModelArgs;
use crate::cli::failure::Failure;
use crate::cli::say::terminal::Terminal;
use crate::denoise::Denoiser;
use crate::exposure::Shutter;
use crate::frame;
use crate::pilot;
use crate::report::versions::Versions;
use crate::scene::camera::Projection;
use crate::scene::shot::Shot;
use crate::scene::{Geometry, Material, Mesh, Model, Scene, Triangles, Warning};
use crate::settings::{DenoiseQuality, Refinement};
use crate::stereo::Stereo;
use crate::trace::BackendKind;

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  afterimage info                    versions of the program, Embree and OpenEXR; the CPU
  afterimage info city.toml          models, materials, lights, frames, and warnings
  afterimage info city.0001.exr      parts, layers and channels with their values; the header")]
pub struct InfoArgs {
    /// A shot (TOML), a model (OBJ, PLY, glTF, USD), or a picture (EXR)
    file: Option<PathBuf>,

    /// A bare model's axis, camera and animation.
    #[command(flatten)]
    bare: BareModelArgs,
}

/// Name of the library that `render --denoise` would use.
fn denoiser() -> String {
    Denoiser::new(1, DenoiseQuality::default()).map_or_else(
        |_| String::from("none: `make setup` fetches Open Image Denoise"),
        |denoiser| format!("Open Image Denoise {}", denoiser.version()),
    )
}

impl InfoArgs {
    /// Prints what it finds.
    pub fn execute(&self, terminal: &mut Terminal) -> Result<(), Failure> {
        on_threads(None, || self.tell(terminal))
    }

    fn tell(&self, terminal: &mut Terminal) -> Result<(), Failure> {
        let Some(path) = &self.file else {
            terminal.result(&Versions::here().to_string());
            terminal.result(&format!("Denoiser    {}", denoiser()));
            return Ok(());
        };
        let kind = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let text = match kind.as_str() {
            "exr" => exr::describe(path)?,
            "obj" | "ply" | "gltf" | "glb" | "usd" | "usda" | "usdc" | "usdz" | "toml" => {
                let mut shot = open(path, false, &self.bare.options(path, None)?)?;
                let choice =
                    pilot::choose(BackendKind::default(), &shot, &shot.settings).map_err(Failure::of)?;
                if let Some(choice) = &choice {
                    choice.apply(&mut shot.scene, &mut shot.settings);
                }
                shot.notes.iter().for_each(|note| terminal.note(note));
                // what has no effect is a part of the description
                for warning in shot.warnings.iter().filter(|warning| !is_unused(warning)) {
                    terminal.warn(&warning.0.to_string());
                }
                let mut text = if matches!(kind.as_str(), "obj" | "ply") {
                    model(&shot, path)
                } else {
                    described(&shot, path)
                };
                unused(&mut text, &shot.warnings);
                if let Some(choice) = &choice {
                    line(&mut text, "counts", format!("follow from {choice}"));
                }
                cost::tell(&mut text, &shot);
                text
            }
            _ => {
                return Err(Failure::Failed(format!(
                    "{}: not a shot (.toml), a model (.obj, .ply, .gltf, .glb, .usda, .usdc, .usdz) or a frame (.exr), by its ending",
                    path.display()
                )));
            }
        };
        terminal.result(text.trim_end());
        Ok(())
    }
}

/// `path`: the shot file's.
fn described(shot: &Shot, path: &Path) -> String {
    let (settings, scene) = (&shot.settings, &shot.scene);
    let samples = settings.samples;
    let samples = match settings.refinement {
        None => format!("{samples}x{samples}"),
        Some(Refinement { most, threshold }) => {
            format!("{samples}x{samples} to {most}x{most} (contrast {threshold})")
        }
    };
    let mut text = format!("{}\n", in_line(&shot.title));
    line(&mut text, "picture", format!("{}x{}, {samples} samples a pixel", settings.width, settings.height));
    if settings.overscan > 0 {
        line(&mut text, "overscan", format!("{} pixels on each side", settings.overscan));
    }
    line(
        &mut text,
        "frames",
        format!("{} ({} in all), {} a second", shot.frames, shot.frames.list().len(), rate(shot.rate)),
    );
    line(
        &mut text,
        "base",
        match settings.base_every {
            0 => String::from("the first frame alone"),
            every => format!("every {every} frames"),
        },
    );
    if scene.camera.projection() == Projection::Orthographic {
        line(&mut text, "camera", String::from("orthographic"));
    }
    if let Some(Stereo { separation, convergence }) = settings.stereo {
        let where_to =
            convergence.map_or_else(|| String::from("parallel"), |at| format!("converging at {at}"));
        line(&mut text, "stereo", format!("two eyes {separation} apart, {where_to}"));
    }
    if let Some(exposures) = frame::exposures(scene, settings) {
        let shutter = settings.shutter.as_ref().map(Shutter::to_string);
        let lens = scene.camera.has_lens().then(|| String::from("a lens"));
        let what: Vec<String> = shutter.into_iter().chain(lens).collect();
        let (count, what) = (exposures.all.len(), what.join(" and "));
        let own = frame::picture_settings(scene, settings).0.levels().last().unwrap_or(1);
        let share = if count > 1 { format!(" of {own}x{own} samples") } else { String::new() };
        line(&mut text, "exposures", format!("{count} a frame{share}, with {what}"));
    }
    if !scene.camera.cuts.is_empty() {
        line(&mut text, "cuts", list(scene.camera.cuts.iter().map(|cut| format!("before frame {cut}"))));
    }
    line(&mut text, "output", shot.output.clone().unwrap_or_else(|| default_output(path)));
    let count = |mesh: &Mesh| mesh.as_triangles().map_or(0, |triangles| triangles.corners.len());
    let triangles: usize = scene.models.iter().map(|model| count(&model.mesh)).sum();
    let kept: usize = scene.built().map(count).sum();
    let kept = if kept < triangles { format!(" ({kept} kept: copies share them)") } else { String::new() };
    line(
        &mut text,
        "models",
        format!("{}, {triangles} triangles{kept}{}", scene.models.len(), curved(scene)),
    );
    for model in &scene.models {
        let moves = match (model.track.is_constant(), model.is_placed_at_rest()) {
            (false, _) => "moves",
            (true, false) => "still",
            (true, true) => "still, shared",
        };
        let (name, path, count) = (&model.name, model.path.display(), model.mesh.count());
        let what = model.mesh.as_curved().map_or(format!("{count} triangles"), |of| of.name().into());
        let shapes = shapes(model).map_or(String::new(), |shapes| format!("{shapes}, "));
        let groups = extent::groups(model).map_or(String::new(), |groups| format!("{groups}, "));
        line(&mut text, "", format!("{name}: {what}, {groups}{shapes}{moves}, {path}"));
    }
    extent::tell(&mut text, shot, path);
    extent::tell_motion(&mut text, scene);
    line(&mut text, "lights", scene.lights.len().to_string());
    for light in &scene.lights {
        line(&mut text, "", format!("{}: {}", light.name, light.kind.name()));
    }
    if let Some(environment) = &scene.environment {
        let [width, height] = environment.size();
        let sun = if environment.sun().is_some() { " and a sun" } else { "" };
        line(&mut text, "environment", format!("{width}x{height} directions{sun}"));
    }
    if settings.paths > 0 {
        let (paths, bounces) = (settings.paths, settings.bounces);
        line(&mut text, "gathering", format!("{paths} paths a sample, {bounces} bounces"));
    }
    if scene.asks_openness(settings.layers) {
        let (rays, radius) = (settings.occlusion_rays, settings.occlusion_radius as f32);
        line(&mut text, "occlusion", format!("{rays} rays a sample, up to {radius} away"));
    }
    surfaces(&mut text, shot, &used_by(&scene.models));
    text
}

/// Numbers of the models that are not made of triangles, by what they are.
fn curved(scene: &Scene) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let kinds = scene.models.iter().filter_map(|model| Some(model.mesh.as_curved()?.kind()));
    kinds.for_each(|kind| *counts.entry(kind).or_default() += 1);
    counts.into_iter().map(|(kind, count)| format!(", {count} {kind}")).collect()
}

/// Describes the shapes between which a model deforms, and their times.
fn shapes(model: &Model) -> Option<String> {
    let count = match &model.mesh.geometry {
        Geometry::Triangles(_) => model.mesh.shapes()?.list().len(),
        Geometry::Curved(curved) => curved.shapes() as usize,
    };
    let track = model.track.shapes.as_ref()?;
    let ([first, last], again) = (track.ends(), if track.repeats() { " and again" } else { "" });
    Some(format!("{count} shapes from frame {first} to {last}{again}"))
}

/// Describes a bare model, without the stage around it.
fn model(shot: &Shot, path: &Path) -> String {
    let scene = &shot.scene;
    let mut text = String::new();
    // the first one is the file's; the other is the floor of its turntable
    if let Some(model) = scene.models.first() {
        let _ = writeln!(text, "{}", in_line(&model.path.display().to_string()));
        let Triangles { positions, corners, normals, uvs, .. } = model.mesh.triangles();
        line(&mut text, "triangles", corners.len().to_string());
        line(
            &mut text,
            "vertices",
            format!(
                "{}{}{}",
                positions.as_slice().len(),
                if normals.is_empty() { ", no normals" } else { ", normals" },
                if uvs.is_empty() { ", no texture coordinates" } else { ", texture coordinates" }
            ),
        );
        extent::tell(&mut text, shot, path);
        if let Some(groups) = extent::groups(model) {
            line(&mut text, "objects", groups);
        }
    }
    surfaces(&mut text, shot, &used_by(&scene.models[..scene.models.len().min(1)]));
    text
}

/// Numbers of the materials that faces of `models` have.
fn used_by(models: &[Model]) -> BTreeSet<u16> {
    let mut known = HashSet::new();
    let meshes = models.iter().map(|model| &model.mesh).filter(|mesh| known.insert(Arc::as_ptr(mesh)));
    meshes.flat_map(|mesh| mesh.material_of.iter().copied()).collect()
}

/// `used`: the numbers of the materials to tell of.
fn surfaces(text: &mut String, shot: &Shot, used: &BTreeSet<u16>) {
    let scene = &shot.scene;
    let used: Vec<&Material> = used.iter().map(|number| &scene.materials[usize::from(*number)]).collect();
    let (none, named): (Vec<&Material>, Vec<&Material>) =
        used.into_iter().partition(|material| material.is_fallback());
    let mirrors = named.iter().filter(|material| material.has_secondary_rays()).count();
    let grey = if none.is_empty() { "" } else { "; what has none is grey" };
    let of_them = if named.is_empty() {
        String::new()
    } else {
        format!(", {mirrors} of them mirrors, glass or metal-rough")
    };
    line(text, "materials", format!("{}{of_them}{grey}", named.len()));
    line(text, "textures", scene.textures.len().to_string());
    for texture in &scene.textures {
        line(text, "", pictures::described(texture, &shot.warnings));
    }
}

/// Returns true if a warning says that a part of a file has no effect.
fn is_unused(warning: &Warning) -> bool {
    [" is not used", " are not used", " are not shown"].iter().any(|words| warning.0.message.contains(words))
}

/// Adds what of the files has no effect: file, line, statement.
fn unused(text: &mut String, warnings: &[Warning]) {
    let all: Vec<&Warning> = warnings.iter().filter(|warning| is_unused(warning)).collect();
    if let Some((first, others)) = all.split_first() {
        line(text, "not used", first.0.to_string());
        others.iter().for_each(|warning| line(text, "", warning.0.to_string()));
    }
}

fn rate((frames, seconds): (i32, u32)) -> String {
    if seconds == 1 { frames.to_string() } else { format!("{frames}/{seconds}") }
}

fn list(parts: impl Iterator<Item = String>) -> String {
    parts.collect::<Vec<_>>().join(", ")
}

fn line(text: &mut String, name: &str, value: String) {
    let _ = writeln!(text, "  {name:<12}{}", in_line(&value));
}

/// Text with its line feeds as characters: files, and what is in them, may have names with such.
fn in_line(text: &str) -> String {
    text.replace('\n', "\\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;

    #[test]
    fn rates_may_be_fractions() {
        assert_eq!((rate((24, 1)), rate((24000, 1001))), ("24".into(), "24000/1001".into()));
    }

    #[test]
    fn triangles_that_copies_share_are_told() {
        let folder = tempfile::tempdir().expect("there is room");
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("there is room");
        write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        let copies: String =
            (1..4).map(|x| format!("[[model]]\nobj = 'm.obj'\ntranslate = [{x}, 0, 0]\n")).collect();
        write("s.toml", &format!("[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n{copies}"));
        let path = folder.path().join("s.toml");
        for (most_added, [models, copy]) in [
            (1, ["3, 3 triangles (1 kept: copies share them)\n", "m: 1 triangles, still, shared, "]),
            (2, ["3, 3 triangles\n", "m: 1 triangles, still, "]),
        ] {
            let text = described(&scene::load_sharing(&path, true, most_added).expect("good"), &path);
            assert!(text.contains(models) && text.matches(copy).count() == 3, "{text}");
            assert_eq!(text.contains("shared"), most_added == 1);
        }
    }

    #[test]
    fn names_with_line_feeds_stay_in_their_line() {
        let mut text = String::new();
        line(&mut text, "", "a\nb: 1 triangles".into());
        assert_eq!(text, "              a\\nb: 1 triangles\n");
    }

    #[test]
    fn names_stand_apart_from_values() {
        let mut text = String::new();
        line(&mut text, "environment", "512x256 directions".into());
        line(&mut text, "lights", "2".into());
        assert_eq!(text, "  environment 512x256 directions\n  lights      2\n");
    }
}
