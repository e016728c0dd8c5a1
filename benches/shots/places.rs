//! The scenes that are measured: their OBJ files, and the places of cameras and lights.

use std::error::Error;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use glam::DVec3;

use super::sphere;

/// Scenes by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SceneName {
    /// A city of this project: mirrors, glass, textures, 755 polygons
    City,
    /// An interior of a million triangles; not shipped
    Kitchen,
    /// Furniture in a grid, 2.4 million triangles; not shipped
    Warehouse,
    /// Generated: 10 million triangles, or as many as --triangles says
    Sphere,
}

/// A scene with the numbers that all shots of it are made from. World space, in the units of the OBJ.
#[derive(Debug, Clone)]
pub struct Place {
    pub name: &'static str,
    pub obj: PathBuf,
    pub eye: DVec3,
    pub target: DVec3,
    /// Places of eye and target after [`super::kinds::DOLLY_FRAMES`] frames.
    pub dolly: [DVec3; 2],
    /// World units that the camera of a chain travels in a frame; [`super::flows`] has the length of its way.
    pub stride: f64,
    /// Place of the first light; the others are within `light_spread` of it.
    pub light: DVec3,
    pub light_spread: DVec3,
    /// Width and height of the soft light.
    pub panel: [f64; 2],
    /// Point that it faces.
    pub panel_target: DVec3,
    /// Intensity of each light.
    pub power: f64,
    /// True if a cut turns the camera where it stands; otherwise it goes around the target.
    pub cut_turns: bool,
}

impl SceneName {
    /// Finds the scene; `Err` if its files are not on this machine.
    pub fn place(self, triangles: u64, folder: &Path) -> Result<Place, Box<dyn Error>> {
        match self {
            Self::City => Ok(city()),
            Self::Kitchen => Ok(kitchen(real_scene("kitchen")?)),
            Self::Warehouse => Ok(warehouse(real_scene("warehouse")?)),
            Self::Sphere => Ok(rippled_sphere(generated(triangles, folder)?)),
        }
    }
}

/// Path of the OBJ of a scene that is not shipped.
fn real_scene(name: &str) -> Result<PathBuf, Box<dyn Error>> {
    let folder = match std::env::var_os("AFTERIMAGE_SCENES") {
        Some(folder) => PathBuf::from(folder),
        None => PathBuf::from(std::env::var_os("HOME").unwrap_or_default()).join(".cache/afterimage-scenes"),
    };
    let obj = folder.join(name).join(name).with_extension("obj");
    if obj.is_file() {
        return Ok(obj.canonicalize()?);
    }
    Err(format!("there is no {}; AFTERIMAGE_SCENES names the folder of such scenes", obj.display()).into())
}

/// Path of the OBJ of a sphere in `folder`, made if it is not there yet.
pub fn generated(triangles: u64, folder: &Path) -> Result<PathBuf, Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    let obj = folder.join(format!("sphere-{triangles}.obj"));
    if !obj.is_file() {
        // under its name only when it is whole: a run that was interrupted leaves none
        let part = obj.with_extension("part");
        sphere::write(&part, triangles)?;
        std::fs::rename(&part, &obj)?;
    }
    Ok(obj.canonicalize()?)
}

fn city() -> Place {
    Place {
        name: "city",
        obj: Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/city/city.obj"),
        eye: DVec3::new(-16.0, 63.0, 165.0),
        target: DVec3::new(4.0, 48.0, 0.0),
        dolly: [DVec3::new(-8.0, 53.0, 151.0), DVec3::new(1.5, 47.5, 0.0)],
        stride: 0.4,
        light: DVec3::new(-70.0, 150.0, 90.0),
        panel: [40.0, 40.0],
        panel_target: DVec3::new(4.0, 20.0, 0.0),
        light_spread: DVec3::new(90.0, 40.0, 90.0),
        power: 2e4,
        cut_turns: false,
    }
}

fn kitchen(obj: PathBuf) -> Place {
    Place {
        name: "kitchen",
        obj,
        eye: DVec3::new(1.211, 1.80475, 3.85239),
        target: DVec3::new(0.335, 1.72, 2.056),
        dolly: [DVec3::new(0.95, 1.75, 3.3), DVec3::new(0.0, 1.6, 1.5)],
        stride: 0.015,
        light: DVec3::new(0.3, 2.3, 1.2),
        panel: [1.0, 0.6],
        panel_target: DVec3::new(0.3, 0.0, 1.2),
        light_spread: DVec3::new(1.2, 0.2, 1.5),
        power: 2.5,
        cut_turns: true,
    }
}

/// The warehouse, seen along the rows that are full: there is neither floor nor wall.
fn warehouse(obj: PathBuf) -> Place {
    Place {
        name: "warehouse",
        obj,
        eye: DVec3::new(-150.0, 170.0, 420.0),
        target: DVec3::new(1000.0, 100.0, 380.0),
        dolly: [DVec3::new(20.0, 150.0, 400.0), DVec3::new(1000.0, 80.0, 300.0)],
        stride: 3.0,
        light: DVec3::new(900.0, 700.0, 500.0),
        panel: [300.0, 200.0],
        panel_target: DVec3::new(900.0, 0.0, 400.0),
        light_spread: DVec3::new(900.0, 150.0, 400.0),
        power: 4e5,
        cut_turns: false,
    }
}

/// The generated sphere, near enough that it fills most of the picture.
pub fn rippled_sphere(obj: PathBuf) -> Place {
    Place {
        name: "sphere",
        obj,
        eye: DVec3::new(0.3, 0.8, 2.0),
        target: DVec3::ZERO,
        dolly: [DVec3::new(0.1, 0.6, 1.8), DVec3::ZERO],
        stride: 0.006,
        light: DVec3::new(2.0, 3.0, 2.5),
        panel: [1.5, 1.5],
        panel_target: DVec3::ZERO,
        light_spread: DVec3::new(2.0, 1.5, 1.5),
        power: 14.0,
        cut_turns: false,
    }
}
