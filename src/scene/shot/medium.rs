//! Media of shot files: `[fog]`, and what fills closed meshes of a `[[material]]`.

use glam::Vec3;

use crate::scene::SceneError;
use crate::scene::import::surfaces::material_table::StatedMedium;
use crate::scene::keys::FogTable;
use crate::scene::keys::material::MaterialTable;
use crate::scene::keys::toml_text::{At, Three, TomlText};
use crate::scene::keys::values::optional_color;
use crate::scene::medium::Medium;

/// Largest coefficient: beyond it all light ends within the rounding of its place.
const LARGEST: f32 = 1e9;

/// Names of the keys of a medium.
struct Keys {
    scatter: &'static str,
    absorb: &'static str,
    emit: &'static str,
    density: &'static str,
    anisotropy: &'static str,
}

/// Reads `[fog]`.
///
/// # Errors
/// Values that make no sense.
pub fn fog(text: TomlText<'_>, table: &FogTable) -> Result<Medium, SceneError> {
    let keys = Keys {
        scatter: "scatter",
        absorb: "absorb",
        emit: "emit",
        density: "density",
        anisotropy: "anisotropy",
    };
    let FogTable { scatter, absorb, emit, density, anisotropy } = table;
    Ok(stated(text, &keys, [scatter, absorb, emit], [density, anisotropy])?.over(None))
}

/// What a `[[material]]` table states of the medium in its meshes.
///
/// # Errors
/// Values that make no sense.
pub fn of_material(text: TomlText<'_>, table: &MaterialTable) -> Result<StatedMedium, SceneError> {
    let keys = Keys {
        scatter: "volume_scatter",
        absorb: "volume_absorb",
        emit: "volume_emit",
        density: "volume_density",
        anisotropy: "volume_anisotropy",
    };
    let MaterialTable { volume_scatter, volume_absorb, volume_emit, .. } = table;
    let colors = [volume_scatter, volume_absorb, volume_emit];
    let cells = table.volume_cells.as_ref();
    let cells = cells.map(|cells| text.whole("volume_cells", cells, 1..513)).transpose()?;
    let medium = stated(text, &keys, colors, [&table.volume_density, &table.volume_anisotropy])?;
    Ok(StatedMedium { cells, ..medium })
}

fn stated(
    text: TomlText<'_>,
    keys: &Keys,
    [scatter, absorb, emit]: [&Option<Three>; 3],
    [density, anisotropy]: [&Option<At<f64>>; 2],
) -> Result<StatedMedium, SceneError> {
    let color = |key, value: &Option<Three>| -> Result<Option<Vec3>, SceneError> {
        let color = optional_color(text, key, value)?;
        match value.as_ref().filter(|_| color.is_some_and(|color| color.max_element() > LARGEST)) {
            Some(value) => Err(text.bad(key, value, "is too large: 1e9 is the most")),
            None => Ok(color),
        }
    };
    let number = |key, value: &Option<At<f64>>, wanted, [low, high]: [f64; 2]| {
        let read = |value| text.number(key, value, wanted, |number| (low..=high).contains(&number));
        value.as_ref().map(read).transpose().map(|number| number.map(|number| number as f32))
    };
    Ok(StatedMedium {
        scatter: color(keys.scatter, scatter)?,
        absorb: color(keys.absorb, absorb)?,
        emit: color(keys.emit, emit)?,
        density: number(keys.density, density, "from 0 to 1e9", [0.0, f64::from(LARGEST)])?,
        anisotropy: number(keys.anisotropy, anisotropy, "from -1 (back) to 1 (straight on)", [-1.0, 1.0])?,
        cells: None,
    })
}
