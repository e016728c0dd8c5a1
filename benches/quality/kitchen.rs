//! The kitchen of the scene collection: a million triangles, 83 materials; not shipped.

use std::error::Error;
use std::path::PathBuf;

use afterimage::scene::material::Optics;
use afterimage::scene::{self, Scene};
use glam::{DVec3, Vec3};

use crate::flows::{Flow, Stand};
use crate::subjects::Subject;

/// A shot whose camera stands where that of the bench `shots` starts.
const SHOT: &str = r#"
[render]
filter = "box"
[background]
color = [0.2, 0.25, 0.3]
[ambient]
color = [0.25, 0.25, 0.25]
everywhere = true
[[light]]
type = "point"
power = 1.0
position = [0.3, 2.3, 1.2]
[[camera.key]]
frame = 1
eye = [1.211, 1.80475, 3.85239]
target = [0.335, 1.72, 2.056]
"#;

/// Loads the kitchen.
///
/// # Errors
/// Its OBJ is not on this machine, or cannot be read.
pub fn kitchen() -> Result<Subject, Box<dyn Error>> {
    let folder = match std::env::var_os("AFTERIMAGE_SCENES") {
        Some(folder) => PathBuf::from(folder),
        None => PathBuf::from(std::env::var_os("HOME").unwrap_or_default()).join(".cache/afterimage-scenes"),
    };
    let obj = folder.join("kitchen/kitchen.obj");
    if !obj.is_file() {
        return Err(format!(
            "there is no {}; AFTERIMAGE_SCENES names the folder of such scenes",
            obj.display()
        )
        .into());
    }
    let file = tempfile::Builder::new().suffix(".toml").tempfile()?;
    std::fs::write(file.path(), format!("{SHOT}[[model]]\nobj = {:?}\n", obj.canonicalize()?))?;
    let scene = scene::load(file.path(), false)?.scene;
    let stand = Stand {
        eye: DVec3::new(1.211, 1.80475, 3.85239),
        target: DVec3::new(0.335, 1.72, 2.056),
        fov: 40.0,
        stride: 0.012,
        aside: -0.008,
        turn: -0.3,
    };
    let flows = &[Flow::In, Flow::Out, Flow::Sideways, Flow::Turn];
    Ok(Subject { name: "kitchen", scene: matt(scene), stand, flows, object: None })
}

/// Removes highlights, mirrors and glass: they depend on the view and are never reused.
fn matt(mut scene: Scene) -> Scene {
    for material in &mut scene.materials {
        (material.specular, material.optics, material.metal_rough) = (Vec3::ZERO, Optics::Opaque, None);
    }
    scene
}
