//! Cost of glass: the generated sphere, first matt and then of clear glass, which all shadow rays pass. A
//! small matt sphere in front of it casts shadows in both cases.

use std::error::Error;
use std::sync::Arc;

use afterimage::animation::TransformTrack;
use afterimage::frame::Renderer;
use afterimage::scene::material::Optics;
use afterimage::scene::{Material, Mesh, Scene};
use afterimage::settings::Settings;
use afterimage::trace::BackendKind;
use glam::Vec3;
use serde::Serialize;

use super::fastest::{Speeds, fastest};
use super::kinds::Kind;
use super::places::{generated, rippled_sphere};
use super::suite::load;
use super::table::{Circumstances, write_json};
use super::{Arguments, folder};

/// Number of mirrors and panes that a ray may meet, unless the command line says otherwise.
const DEPTH: u32 = 4;

/// A line of the table.
#[derive(Debug, Clone, Serialize)]
struct Row {
    sphere: &'static str,
    surface: &'static str,
    tracer: &'static str,
    build_seconds: f64,
    shadow_rays: u64,
    /// Of the fastest frame, as are the rays.
    #[serde(flatten)]
    speeds: Speeds,
}

type Failable<T> = Result<T, Box<dyn Error>>;

/// Measures; prints a table.
pub fn run(arguments: &Arguments) -> Failable<()> {
    let circumstances = Circumstances::now(arguments);
    println!("{}\n", circumstances.text());
    let triangles = arguments.triangles.unwrap_or(if arguments.quick { 100_000 } else { 1_000_000 });
    let (mut scene, settings) = load(&rippled_sphere(generated(triangles, &folder())?), arguments)?;
    let settings = Settings { depth: arguments.depth.first().copied().unwrap_or(DEPTH), ..settings };
    scene.lights.truncate(1);
    println!(
        "| sphere | surface | tracer | build s |  full s | shadow M | primary M/s | shadow M/s | bounced M/s |"
    );
    println!(
        "|--------|---------|--------|---------|---------|----------|-------------|------------|-------------|"
    );
    let track = std::mem::replace(&mut scene.models[0].track, TransformTrack::identity());
    let moving = |scene: &Scene| {
        let mut scene = scene.clone();
        scene.models[0].track = track.clone();
        scene
    };
    let glass = of_glass(&scene);
    let scenes = [
        ("still", "matt", scene.clone()),
        ("still", "glass", glass.clone()),
        ("moves", "matt", moving(&scene)),
        ("moves", "glass", moving(&glass)),
    ];
    let mut rows = Vec::new();
    for (sphere, surface, scene) in &scenes {
        for kind in [BackendKind::Embree, BackendKind::Rust] {
            rows.push(measure(kind, [sphere, surface], scene, &settings, arguments)?);
        }
    }
    let path = folder().join("glass.json");
    write_json(&path, &circumstances, &rows)?;
    println!("\nalso in {}", path.display());
    Ok(())
}

/// Copy of `scene` with the first model of clear glass.
fn of_glass(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let (transmission, reflection) = (Vec3::splat(0.9), Vec3::ONE);
    let optics = Optics::clear(transmission, 1.5, reflection);
    let glass = scene.materials.len() as u16;
    scene.materials.push(Material { diffuse: Vec3::splat(0.05), optics, ..Material::fallback() });
    let mesh = Mesh::clone(&scene.models[0].mesh);
    let material_of = vec![glass; mesh.count()];
    scene.models[0].mesh = Arc::new(Mesh { shadow_casting: 0, material_of, ..mesh });
    scene
}

fn measure(
    kind: BackendKind,
    [sphere, surface]: [&'static str; 2],
    scene: &Scene,
    settings: &Settings,
    arguments: &Arguments,
) -> Failable<Row> {
    let mut renderer = Renderer::with(kind, scene, settings)?;
    let first = if sphere == "moves" { Kind::All } else { Kind::Dolly }.first_frame();
    let (rays, speeds) = fastest(&mut renderer, first, arguments)?;
    let row = Row {
        sphere,
        surface,
        tracer: kind.name(),
        build_seconds: renderer.build_seconds(),
        shadow_rays: rays.shadow,
        speeds,
    };
    println!(
        "| {sphere:<6} | {surface:<7} | {:<6} | {:7.2} | {:7.3} | {:8.2} | {:11.1} | {:10.1} | {:11.1} |",
        row.tracer,
        row.build_seconds,
        speeds.full_seconds,
        row.shadow_rays as f64 / 1e6,
        speeds.primary_speed,
        speeds.shadow_speed,
        speeds.bounced_speed,
    );
    Ok(row)
}
