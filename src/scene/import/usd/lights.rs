//! Lights (UsdLux), and their tables in a shot file.
//!
//! UsdLux states what surfaces of lights emit: radiance (in nits) is intensity x 2^exposure x colour, divided by the area of the light in
//! the file's units where `normalize` says so (UsdLuxLightAPI, "Quantities and Units"). A matt white surface at an irradiance of pi has a
//! radiance of 1, and here at a power of 1: so power is intensity (radiance times the area that is seen along the axis) divided by pi, as
//! for glTF.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::path::Path;

use glam::{DAffine3, DVec3};
use openusd::usd::Prim;

use super::clock::Clock;
use super::file::{Content, LightKey, Picture, Units, UsdLight, UsdLightKind};
use super::links;
use super::shader::Shaders;
use super::temperature;
use super::value::{self, Answer, codes, codes_read, flag, number, word};
use crate::animation::{Track, Visibility};
use crate::scene::environment;
use crate::scene::import::lights::{self, three};
use crate::scene::keys::toml_text::{At, List};
use crate::scene::keys::{self, BackgroundTable, EnvironmentTable, LightTable, LightType};

/// Cosine of the angle to its level axes, about, up to which a rectangle counts as level.
const LEVEL: f64 = 0.999;

/// Frames before a light goes on or off in which it does so: less than the shutter of any camera is open.
const SWITCH: f64 = 1e-4;

/// Returns true for files that are maps of light from all around, by their endings.
fn is_map(path: &Path) -> bool {
    let ending =
        path.to_string_lossy().trim_end_matches(']').rsplit('.').next().unwrap_or_default().to_lowercase();
    matches!(ending.as_str(), "exr" | "hdr")
}

/// Returns true for types of prims that are lights here.
pub fn is_light(kind: &str) -> bool {
    matches!(kind, "RectLight" | "DiskLight" | "SphereLight" | "DistantLight" | "DomeLight" | "DomeLight_1")
}

/// Reads a light at the place `map`. `None` if it does not shine.
///
/// # Errors What the library says.
pub fn read(
    (prim, kind): (&Prim, &str),
    (map, visible): (&Track<DAffine3>, &Visibility),
    (clock, units): (&Clock, Units),
    shaders: &mut Shaders<'_>,
) -> Answer<Option<UsdLight>> {
    let unit = units.metres;
    let start = clock.code(clock.first());
    let input =
        |name: &str, default: f64| -> Answer<f64> { Ok(number_at(prim, name, start)?.unwrap_or(default)) };
    let first = map.at(clock.first());
    let [x, y, z] = [first.matrix3.x_axis, first.matrix3.y_axis, first.matrix3.z_axis].map(DVec3::length);
    note_unused(prim, start, shaders)?;
    let is_normalized = flag_at(prim, "normalize", start)?.unwrap_or(false);
    // factor from radiance (or, where that is normalised, from intensity) to power
    let (light, factor) = match kind {
        "RectLight" => {
            let size = [input("width", 1.0)? * x, input("height", 1.0)? * y];
            let area = size[0] * size[1];
            (UsdLightKind::Rectangle { size }, if is_normalized { unit * unit } else { area } / PI)
        }
        "DiskLight" => {
            let radius = input("radius", 0.5)?;
            let area = PI * radius * x * radius * y;
            (
                UsdLightKind::Disk { size: [2.0 * radius * x, 2.0 * radius * y] },
                if is_normalized { unit * unit } else { area } / PI,
            )
        }
        "SphereLight" => sphere(prim, start, ((x + y + z) / 3.0, unit), is_normalized)?,
        "DistantLight" => sun(input("angle", 0.53)?, is_normalized, units),
        _ => {
            let file = shaders.file(prim)?.filter(|(path, name, packed)| {
                let is_there = packed.is_some() || path.is_file();
                let is_read = is_map(path);
                if !is_there || !is_read {
                    let why = if is_there {
                        "is no map that is read: its light is even; save it as OpenEXR (.exr) or Radiance (.hdr)"
                    } else {
                        "cannot be found: its light is even; copy it to where it is named"
                    };
                    shaders.missing.insert(format!("the picture `{name}` of the light from all around {why}"));
                }
                is_there && is_read
            });
            let picture = file.map(|(path, name, packed)| Picture::plain(path, name, packed));
            (UsdLightKind::Dome { picture }, 1.0)
        }
    };
    let mut frames: BTreeSet<u64> = BTreeSet::new();
    let has_temperature = flag_at(prim, "enableColorTemperature", start)?.unwrap_or(false);
    for name in ["intensity", "exposure", "color", "colorTemperature"]
        .into_iter()
        .flat_map(|name| [format!("inputs:{name}"), name.into()])
    {
        let times = codes_read(prim, &name, clock)?;
        if times.len() > 1 {
            frames.extend(times.iter().map(|code| clock.frame(*code).to_bits()));
        }
    }
    if !map.is_constant() {
        frames.extend(map.frames().map(f64::to_bits));
    }
    if let Some(track) = visible.track() {
        // it goes on and off at once: a key where it does, and one before, as lights change evenly between keys
        frames.extend(track.frames().flat_map(|frame| [frame, frame - SWITCH]).map(f64::to_bits));
    }
    let mut frames: Vec<f64> = frames.into_iter().map(f64::from_bits).collect();
    frames.sort_by(f64::total_cmp);
    if frames.is_empty() {
        frames.push(clock.first());
    }
    let keys = frames.into_iter().map(|frame| {
        let code = clock.code(frame);
        let (intensity, exposure) =
            (number_at(prim, "intensity", code)?, number_at(prim, "exposure", code)?.unwrap_or(0.0));
        let intensity = intensity.unwrap_or(if kind == "DistantLight" { 50_000.0 } else { 1.0 });
        let color = match value::three(prim, "inputs:color", code)? {
            Some(color) => color,
            None => value::three(prim, "color", code)?.unwrap_or(DVec3::ONE),
        };
        let kelvin = number_at(prim, "colorTemperature", code)?.filter(|_| has_temperature);
        let color = color * kelvin.map_or(DVec3::ONE, temperature::color);
        let power = intensity * exposure.exp2() * factor;
        let power = if visible.at(frame) { power } else { 0.0 };
        let fits = (0.0..=1e30).contains(&power) && color.min_element() >= 0.0 && color.max_element() <= 1e30;
        match fits {
            true => Ok(LightKey { frame, map: map.at(frame), color, power }),
            false => Err(format!("the light {} has values that make no sense: export it again", prim.path())),
        }
    });
    let keys = keys.collect::<Answer<Vec<_>>>()?;
    let name = prim.path().name().unwrap_or_default().to_string();
    let shines = keys.iter().any(|key| key.power > 0.0 && key.color != DVec3::ZERO);
    let [light_link, shadow_link] = ["lightLink", "shadowLink"].map(|name| links::read(prim, name, start));
    let (light_link, shadow_link, path) = (light_link?, shadow_link?, prim.path().to_string());
    let is_all = kind.starts_with("Dome") && (light_link.is_some() || shadow_link.is_some());
    if is_all {
        shaders.leave_out("links of lights from all around (DomeLight) are not used: they light all");
    }
    Ok(shines.then_some(UsdLight { name, path, light_link, shadow_link, kind: light, keys }))
}

/// Number of a light: its attributes had no prefix before 2021.
fn number_at(prim: &Prim, name: &str, code: f64) -> Answer<Option<f64>> {
    let own = number(prim, &format!("inputs:{name}"), code)?;
    if own.is_some() { Ok(own) } else { number(prim, name, code) }
}

fn flag_at(prim: &Prim, name: &str, code: f64) -> Answer<Option<bool>> {
    let own = flag(prim, &format!("inputs:{name}"), code)?;
    if own.is_some() { Ok(own) } else { flag(prim, name, code) }
}

/// A sphere, or a point or spot if it has no size. `scale`: metres in a unit at its place.
fn sphere(
    prim: &Prim,
    code: f64,
    (scale, unit): (f64, f64),
    is_normalized: bool,
) -> Answer<(UsdLightKind, f64)> {
    let radius = number_at(prim, "radius", code)?.unwrap_or(0.5) * scale;
    let is_point = flag(prim, "treatAsPoint", code)?.unwrap_or(false) || radius <= 0.0;
    // all of its surface is 4 pi r^2, and pi r^2 of it is seen
    let normalized = unit * unit / (4.0 * PI);
    let factor = if is_normalized || radius <= 0.0 { normalized } else { radius * radius };
    let cone = number_at(prim, "shaping:cone:angle", code)?.filter(|cone| *cone > 0.0 && *cone < 90.0);
    Ok(match cone {
        Some(cone) => {
            let soft = number_at(prim, "shaping:cone:softness", code)?.unwrap_or(0.0).clamp(0.0, 1.0);
            (UsdLightKind::Spot { cone, soft, radius: if is_point { 0.0 } else { radius } }, factor)
        }
        None if is_point => (UsdLightKind::Point, factor),
        None => (UsdLightKind::Sphere { radius }, factor),
    })
}

/// A light that is infinitely far away, of this diameter in degrees.
fn sun(angle: f64, is_normalized: bool, units: Units) -> (UsdLightKind, f64) {
    // Blender (5.0.1) writes a quarter of its strength, and half of its diameter: measured beside Cycles
    let (angle, strength) = if units.is_of_blender { (2.0 * angle, 4.0) } else { (angle, 1.0) };
    let angle = angle.clamp(0.0, 180.0);
    // radiance is irradiance over the projected solid angle of the disk
    let disk = PI * (angle / 2.0).to_radians().sin().powi(2);
    let factor = if is_normalized || disk == 0.0 { 1.0 } else { disk };
    (UsdLightKind::Sun { angle }, strength * factor / PI)
}

fn note_unused(prim: &Prim, code: f64, shaders: &mut Shaders<'_>) -> Answer<()> {
    if number_at(prim, "shaping:focus", code)?.is_some_and(|focus| focus != 0.0) {
        shaders.leave_out("focus of lights (shaping:focus) is not used");
    }
    for (name, what) in
        [("radius", "radii"), ("width", "sizes"), ("angle", "angles"), ("shaping:cone:angle", "cones")]
    {
        if codes(prim, &format!("inputs:{name}"))?.len() > 1 {
            shaders.leave_out(format!(
                "{what} of lights do not change with time: they are as at the first frame"
            ));
        }
    }
    if word(prim, "inputs:shaping:ies:file", code)?.is_some() {
        shaders.leave_out("IES profiles of lights are not used");
    }
    Ok(())
}

/// The table of a light; `None` for a dome, see [`dome`], and for one that is linked to nothing that is shown.
pub fn table(content: &Content, light: &UsdLight) -> Option<LightTable> {
    let kind = match &light.kind {
        UsdLightKind::Rectangle { .. } => LightType::Rectangle,
        UsdLightKind::Disk { .. } => LightType::Disk,
        UsdLightKind::Sphere { .. } => LightType::Sphere,
        UsdLightKind::Point => LightType::Point,
        UsdLightKind::Spot { .. } => LightType::Spot,
        UsdLightKind::Sun { .. } => LightType::Directional,
        UsdLightKind::Dome { .. } => return None,
    };
    let table = match &light.keys[..] {
        [] => return None,
        [LightKey { map, color, power, .. }] => LightTable {
            color: Some(three(*color)),
            power: Some(At::of(*power)),
            ..lights::at_rest(&light.name, kind, map)
        },
        keys => lights::keyed(
            &light.name,
            kind,
            keys.iter().map(|LightKey { frame, map, color, power }| keys::LightKey {
                color: Some(three(*color)),
                power: Some(At::of(*power)),
                ..lights::key(*frame, kind, map)
            }),
        ),
    };
    let [light_link, shadow_link] = links::keys(content, light)?;
    Some(LightTable { light_link, shadow_link, ..shaped(table, &light.kind) })
}

/// A table with the shape of a light.
fn shaped(table: LightTable, kind: &UsdLightKind) -> LightTable {
    let number = |number: f64| Some(At::of(number));
    match kind {
        UsdLightKind::Rectangle { size } | UsdLightKind::Disk { size } => {
            LightTable { size: Some(At::of(List(*size))), ..table }
        }
        UsdLightKind::Sphere { radius } => LightTable { radius: number(*radius), ..table },
        UsdLightKind::Spot { cone, soft, radius } => LightTable {
            cone: number((2.0 * cone).min(lights::WIDEST)),
            soft: number(*soft),
            radius: number(*radius),
            ..table
        },
        UsdLightKind::Sun { angle } => LightTable { angle: number(*angle), ..table },
        UsdLightKind::Point | UsdLightKind::Dome { .. } => table,
    }
}

/// The tables of the light from all around, if there is one: of the background that it is, and of its map.
pub fn dome(
    light: &UsdLight,
    notes: &mut Vec<String>,
) -> (Option<BackgroundTable>, Option<EnvironmentTable>) {
    let (UsdLightKind::Dome { picture }, Some(key)) = (&light.kind, light.keys.first()) else {
        return (None, None);
    };
    if light.keys.len() > 1 {
        notes.push(String::from("the light from all around (DomeLight) rests: it is as at its first key"));
    }
    let Some(picture) = picture else {
        let color = Some(three(key.color * key.power));
        let background = BackgroundTable { color, ..BackgroundTable::default() };
        return (Some(background), Some(EnvironmentTable::default()));
    };
    if picture.packed.is_some() {
        notes.push(String::from(
            "the picture of the light from all around (DomeLight) is in a package, and is not used: unpack it, and name it as `map` of [environment]",
        ));
        return (None, None);
    }
    if key.color != DVec3::ONE {
        notes.push(String::from(
            "the colour of the light from all around (DomeLight) beside its picture is not used",
        ));
    }
    let up = key.map.matrix3.y_axis.normalize_or_zero();
    if up.y < LEVEL && !environment::is_even(&picture.path) {
        notes.push(String::from("the light from all around (DomeLight) is tilted there, and upright here"));
    }
    // the middle of a map is at +Z of the light, and here at -Z (OpenEXR, "Environment Maps")
    let ahead = key.map.matrix3.z_axis.normalize_or(DVec3::Z);
    let rotation = 180.0 + ahead.x.atan2(ahead.z).to_degrees();
    let environment = EnvironmentTable {
        map: Some(At::of(picture.path.to_string_lossy().into_owned())),
        rotation: Some(At::of(rotation)),
        power: Some(At::of(key.power)),
        ..EnvironmentTable::default()
    };
    (None, Some(environment))
}
