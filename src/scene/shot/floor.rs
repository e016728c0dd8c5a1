//! The floor of a shot file: a level disk under the models, so large that its rim is far away.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use crate::animation::{Track, TransformTrack};
use crate::scene::keys::FloorTable;
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::keys::values::optional_color;
use crate::scene::render_space::Extent;
use crate::scene::surface::Surface;
use crate::scene::{Material, Mesh, Model, SceneError, Triangles};

/// Number of corners of the disk.
const CORNERS: u32 = 48;

/// Default radius, in diagonals of the box around all models.
const USUAL_RADIUS: f64 = 40.0;

/// Default reflectance.
const USUAL_COLOR: f32 = 0.3;

/// Floor read from a `[floor]` table.
#[derive(Debug, Clone, PartialEq)]
pub struct Floor {
    /// Centre of the disk, space of the files.
    center: DVec3,
    radius: f64,
    color: Vec3,
}

/// Reads `table`; `extent` is that of all models at the shot's first frame: the floor lies around their middle.
///
/// # Errors
/// With line and column: values that make no sense.
pub fn of_table(text: TomlText<'_>, table: &FloorTable, extent: &Extent) -> Result<Floor, SceneError> {
    let number = |key, value: &Option<At<f64>>, default, wanted, fits: fn(f64) -> bool| {
        value.as_ref().map_or(Ok(default), |value| text.number(key, value, wanted, fits))
    };
    let (height, length) = ("from -1e18 to 1e18", "a length above 0, up to 1e18");
    let height = number("height", &table.height, 0.0, height, |height| height.abs() <= 1e18)?;
    let usual = (extent.diagonal() * USUAL_RADIUS).clamp(f64::from(f32::MIN_POSITIVE), 1e18);
    let radius = number("radius", &table.radius, usual, length, |radius| radius > 0.0 && radius <= 1e18)?;
    let color = optional_color(text, "color", &table.color)?.unwrap_or(Vec3::splat(USUAL_COLOR));
    match &table.color {
        Some(stated) if color.max_element() > 1.0 => {
            Err(text.bad("color", stated, "is a reflectance: none of its three numbers may be above 1"))
        }
        _ => Ok(Floor { center: extent.center().with_y(height), radius, color }),
    }
}

impl Floor {
    /// Creates its matt material.
    pub fn material(&self) -> Material {
        Surface::matt("floor", self.color).material()
    }

    /// Creates the model, in the space of the files, of the shot at `path`; `material` is its index.
    pub fn model(&self, path: &Path, material: u16) -> Model {
        let corner = |i: u32| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(CORNERS)).sin_cos();
            [(self.radius * sin) as f32, 0.0, (self.radius * cos) as f32]
        };
        let positions = std::iter::once([0.0; 3]).chain((0..CORNERS).map(corner)).collect();
        let triangles = (0..CORNERS).map(|i| [0, 1 + i, 1 + (i + 1) % CORNERS]).collect::<Vec<_>>();
        let mesh = Mesh::plain(Triangles::new(positions, triangles).into(), material, true);
        let track = TransformTrack { translate: Track::constant(self.center), ..TransformTrack::identity() };
        Model {
            name: String::from("floor"),
            path: path.to_owned(),
            mesh: Arc::new(mesh),
            track,
            to_world: None,
            random: 0.0,
            reflection_map: None,
            ray_visibility: Default::default(),
            linked: Default::default(),
        }
    }
}
