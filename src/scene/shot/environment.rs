//! The environment of a shot file: checked, and its map read.

use std::path::PathBuf;

use crate::digest::Digest;
use crate::scene::environment::{self, Sky};
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::keys::values::{file_of, optional_color};
use crate::scene::keys::{EnvironmentTable, SkyTable};
use crate::scene::{Background, Environment, SceneError, Warning};

/// Maximum number of rays to the environment where a path starts.
const MOST_SAMPLES: u32 = 64;

/// Environment read from an `[environment]` table.
pub struct Read {
    pub environment: Environment,
    /// File of the map.
    pub file: Option<PathBuf>,
    /// Digest of the map's content.
    pub digest: Option<Digest>,
    /// Warning about the map.
    pub warning: Option<Warning>,
}

/// Reads the environment that `table` describes. With neither map nor sky it is the `background`, which then
/// lights the scene.
///
/// # Errors With line and column: values that make no sense. With the map's name: a map that cannot be used.
pub fn of_table(
    text: TomlText<'_>,
    table: &At<EnvironmentTable>,
    background: Option<&Background>,
) -> Result<Read, SceneError> {
    let EnvironmentTable { map, sky, rotation, power, visible, samples, light_group: _ } = table.get_ref();
    let rotation = number(text, "rotation", rotation, 0.0, "finite", |_| true)?;
    let fits = |power| (0.0..=f64::from(f32::MAX)).contains(&power);
    let power = number(text, "power", power, 1.0, "finite and not negative", fits)? as f32;
    let (environment, map, warning) = match (map, sky, background) {
        (Some(map), Some(_), _) => {
            return Err(text.bad("map", map, "and `sky` exclude each other: remove one"));
        }
        (Some(map), None, _) => {
            let path = file_of(text, "map", map)?;
            let (environment, digest, warning) = environment::read(&path)?;
            (environment, Some((path, digest)), warning)
        }
        (None, Some(table), _) => (Environment::from_sky(&sky_of(text, table)?), None, None),
        (None, None, Some(background)) => (Environment::from_background(background), None, None),
        (None, None, None) => {
            let message = "the environment needs `map` or `sky`: without them it is the [background], and there is none";
            return Err(text.fault(table.span(), message));
        }
    };
    let mut environment = environment.rotated(rotation).times(power);
    environment.visible = visible.unwrap_or(true);
    let of_samples = |samples| text.whole("samples", samples, 0..i64::from(MOST_SAMPLES) + 1);
    environment.samples = samples.as_ref().map_or(Ok(1), of_samples)?;
    let (file, digest) = map.unzip();
    Ok(Read { environment, file, digest, warning })
}

fn sky_of(text: TomlText<'_>, table: &SkyTable) -> Result<Sky, SceneError> {
    let default = Sky::default();
    let within = |key, value, default, [low, high]: [f64; 2], unit| {
        let wanted = format!("from {low} to {high}{unit}");
        number(text, key, value, default, &wanted, |number| (low..=high).contains(&number))
    };
    let elevation = within("elevation", &table.elevation, default.elevation, Sky::ELEVATIONS, " degrees")?;
    let turbidity = within("turbidity", &table.turbidity, default.turbidity, Sky::TURBIDITIES, "")?;
    let ground = optional_color(text, "ground", &table.ground)?.unwrap_or(default.ground);
    match &table.ground {
        Some(albedo) if ground.max_element() > 1.0 => {
            Err(text.bad("ground", albedo, "is an albedo: none of its three numbers may be above 1"))
        }
        _ => {
            let azimuth = number(text, "azimuth", &table.azimuth, default.azimuth, "finite", |_| true)?;
            Ok(Sky { elevation, azimuth, turbidity, ground })
        }
    }
}

/// Reads a number for which `fits` holds; `default` if none is stated.
fn number(
    text: TomlText<'_>,
    key: &str,
    value: &Option<At<f64>>,
    default: f64,
    wanted: &str,
    fits: impl Fn(f64) -> bool,
) -> Result<f64, SceneError> {
    value.as_ref().map_or(Ok(default), |value| text.number(key, value, wanted, fits))
}
