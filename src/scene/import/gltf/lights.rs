//! Lights of glTF files (KHR_lights_punctual), as tables of a shot file.

use std::f64::consts::PI;

use glam::{DAffine3, DVec3};
use serde::Deserialize;

use super::document::{Document, extension};
use super::json::Light;
use crate::scene::import::lights::{self, three};
use crate::scene::import::part_of_file::NodeTrack;
use crate::scene::keys::toml_text::At;
use crate::scene::keys::{LightTable, LightType};
use crate::scene::{SceneError, SpotFall};

/// Lumens of a watt, as Blender converts them in both directions.
const LUMENS_A_WATT: f64 = 683.0;

/// Name of the extension.
const NAME: &str = "KHR_lights_punctual";

#[derive(Debug, Deserialize)]
struct Lights {
    lights: Vec<Light>,
}

#[derive(Debug, Deserialize)]
struct OfNode {
    light: usize,
}

/// Shown nodes with a light, and the number of the light.
///
/// # Errors An extension that makes no sense.
pub fn nodes(document: &Document, shown: &[usize]) -> Result<Vec<(usize, usize)>, SceneError> {
    let mut found = Vec::new();
    for node in shown {
        let of_node: Option<OfNode> = extension(document, &document.json.nodes[*node].extensions, NAME)?;
        found.extend(of_node.map(|of_node| (*node, of_node.light)));
    }
    Ok(found)
}

/// Returns true if the file's lights are in lumens made of watts, for which emission is a number that was not converted.
pub fn is_of_blender(document: &Document) -> bool {
    document.json.asset.generator.contains("Blender")
}

/// The table of a light.
///
/// # Errors A light that is not there, or makes no sense.
pub fn table(
    document: &Document,
    light: usize,
    name: &str,
    track: &NodeTrack,
) -> Result<LightTable, SceneError> {
    let all: Option<Lights> = extension(document, &document.json.extensions, NAME)?;
    let all = all.map_or(Vec::new(), |all| all.lights);
    let light = document.get(&all, light, "light")?;
    let wrong =
        || document.fault(format!("the light `{name}` has values that make no sense: export it again"));
    let color = light.color.unwrap_or([1.0; 3]);
    let unit = if is_of_blender(document) { LUMENS_A_WATT } else { 1.0 };
    // a matt white surface at an irradiance of pi has a radiance of 1, and here at a power of 1
    let power = light.intensity.unwrap_or(1.0) / (unit * PI);
    let fits = |value: f64| (0.0..=1e30).contains(&value);
    if !fits(power) || !color.into_iter().all(fits) {
        return Err(wrong());
    }
    let kind = match light.kind.as_str() {
        "directional" => LightType::Directional,
        "point" => LightType::Point,
        "spot" => LightType::Spot,
        _ => return Err(wrong()),
    };
    let name = light.name.as_deref().unwrap_or(name);
    let keys: Vec<(f64, DAffine3)> = track.map.frames().zip(track.map.values()).collect();
    let table = match keys.first() {
        Some((_, map)) if track.map.is_constant() => lights::at_rest(name, kind, map),
        _ => lights::keyed(name, kind, keys.iter().map(|(frame, map)| lights::key(*frame, kind, map))),
    };
    let (color, power) = (Some(three(DVec3::from(color))), Some(At::of(power)));
    let table = LightTable { color, power, ..table };
    if kind != LightType::Spot {
        return Ok(table);
    }
    let (inner, outer) = (light.spot.inner_cone_angle, light.spot.outer_cone_angle);
    if !(outer > 0.0 && inner >= 0.0) {
        return Err(wrong());
    }
    let cone = (2.0 * outer.to_degrees()).min(lights::WIDEST);
    let soft = (1.0 - inner / outer).clamp(0.0, 1.0);
    // Blender makes its own curve these angles
    let is_square = soft > 0.0 && !is_of_blender(document);
    let fall = is_square.then(|| At::of(SpotFall::Square));
    Ok(LightTable { cone: Some(At::of(cone)), soft: Some(At::of(soft)), fall, ..table })
}
