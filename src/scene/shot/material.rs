//! `[[material]]` tables of shot files.

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};

use super::hair;
use crate::scene::SceneError;
use crate::scene::import::mtl::statements::Statements;
use crate::scene::import::mtl::statements::maps::{MapStatement, MapStatements, MapUse};
use crate::scene::import::surfaces::material_table::Override;
use crate::scene::keys::material::{Axis, MaterialTable};
use crate::scene::keys::toml_text::{At, Three, TomlText};
use crate::scene::keys::values::optional_color;
use crate::scene::material::LARGEST_COLOR;
use crate::scene::paths::find_beside;
use crate::scene::surface::{Parameter, Value};

/// What a table states.
///
/// # Errors
/// Values that make no sense, and a MaterialX file that is missing.
pub fn replacement(text: TomlText<'_>, table: &MaterialTable) -> Result<Override, SceneError> {
    let read = Reader(text);
    let illum = table.illum.as_ref().map(|value| text.whole("illum", value, 0..11)).transpose()?;
    let place = text.fault(table.name.span(), "");
    let (line, column) = (place.line.unwrap_or(1), place.column.unwrap_or(1));
    let turn = |turn| text.number("anisotropy_turn", turn, "finite", f64::is_finite);
    let mut values = Statements {
        name: table.name.get_ref().clone(),
        line,
        kd: read.color("kd", &table.kd)?,
        ka: read.color("ka", &table.ka)?,
        ks: read.color("ks", &table.ks)?,
        ke: read.color("ke", &table.ke)?,
        tf: read.filter(table)?,
        ns: read.number("ns", &table.ns, "finite and not negative", f64::from(f32::MAX))?,
        ni: read.number("ni", &table.ni, "from 0 to 100", 100.0)?,
        d: read.number("d", &table.d, "from 0 (clear) to 1 (solid)", 1.0)?,
        illum,
        pr: read.number("pr", &table.pr, ROUGH, 1.0)?,
        pm: read.number("pm", &table.pm, "from 0 (no metal) to 1 (metal)", 1.0)?,
        metal_edge: read.number(
            "metal_edge",
            &table.metal_edge,
            "from 0 (as at right angles) to 1 (white)",
            1.0,
        )?,
        translucency: read.number("translucency", &table.translucency, OF_LIGHT, 1.0)?,
        entry_index: read.number("subsurface_ni", &table.subsurface_ni, "from 1 to 100", 100.0)?,
        entry_roughness: read.number("subsurface_pr", &table.subsurface_pr, ROUGH, 1.0)?,
        entry_matt: read.number("subsurface_matt", &table.subsurface_matt, OF_LIGHT, 1.0)?,
        tangent_turn: table.anisotropy_turn.as_ref().map(turn).transpose()?.map(|turn| turn as f32),
        tangent_around: table.anisotropy_around.map(Axis::vector),
        alpha_mode: table.alpha_mode,
        maps: read.maps(table)?,
        ..Statements::default()
    };
    read.parameters(table, &mut values)?;
    if let Some(table) = &table.hair {
        let (hair, color) = hair::of_table(text, table)?;
        (values.hair, values.kd) = (Some(hair), color.or(values.kd));
    }
    let through = read.number("transmission", &table.transmission, OF_LIGHT, 1.0)?;
    let values = match through.filter(|share| *share > 0.0) {
        Some(share) => values.with_transmission(f64::from(share), DVec3::ONE),
        None => values,
    };
    let mtlx = table.mtlx.as_ref().map(|file| mtlx_file(text, file)).transpose()?;
    let (medium, surface) = (super::medium::of_material(text, table)?, table.surface);
    Ok(Override { values, mtlx, medium, surface, path: text.path.to_path_buf(), line, column, used: false })
}

/// What numbers must be.
const ROUGH: &str = "from 0 (smooth) to 1 (rough)";
const OF_LIGHT: &str = "from 0 (none) to 1 (all of the light)";
const OF_SURFACE: &str = "from 0 (none) to 1 (all of the surface)";

/// Reads values of a table.
struct Reader<'t>(TomlText<'t>);

impl Reader<'_> {
    /// Parameters of OpenPBR that a table states by names of their own.
    fn parameters(&self, table: &MaterialTable, values: &mut Statements) -> Result<(), SceneError> {
        use Parameter::*;
        for (parameter, key, value, wanted, most) in [
            (BaseDiffuseRoughness, "diffuse_roughness", &table.diffuse_roughness, ROUGH, 1.0),
            (SpecularRoughnessAnisotropy, "anisotropy", &table.anisotropy, "from 0 (round) to 1", 1.0),
            (SubsurfaceWeight, "subsurface", &table.subsurface, OF_LIGHT, 1.0),
            (TransmissionDepth, "depth", &table.depth, "finite and not negative", f64::from(f32::MAX)),
            (CoatWeight, "coat", &table.coat, OF_SURFACE, 1.0),
            (CoatRoughness, "coat_roughness", &table.coat_roughness, ROUGH, 1.0),
            (CoatIor, "coat_ni", &table.coat_ni, "from 1 to 100", 100.0),
            (
                CoatDarkening,
                "coat_darkening",
                &table.coat_darkening,
                "from 0 (none) to 1 (as light does)",
                1.0,
            ),
            (FuzzWeight, "fuzz", &table.fuzz, OF_SURFACE, 1.0),
            (FuzzRoughness, "fuzz_roughness", &table.fuzz_roughness, ROUGH, 1.0),
        ] {
            values.state(parameter, self.number(key, value, wanted, most)?);
        }
        for (parameter, key, value) in [
            (SubsurfaceRadiusScale, "subsurface_radius", &table.subsurface_radius),
            (TransmissionColor, "depth_color", &table.depth_color),
            (CoatColor, "coat_color", &table.coat_color),
            (FuzzColor, "fuzz_color", &table.fuzz_color),
        ] {
            values.state(parameter, self.color(key, value)?);
        }
        // the colour of a radius is the radius
        values.state(SubsurfaceRadius, table.subsurface_radius.as_ref().map(|_| Value::ONE));
        values.state(GeometryThinWalled, table.thin.map(|is_thin| if is_thin { 1.0 } else { 0.0 }));
        Ok(())
    }

    /// Pictures that a table names.
    fn maps(&self, table: &MaterialTable) -> Result<MapStatements, SceneError> {
        let mut maps = MapStatements::default();
        let MaterialTable { map_kd, map_d, map_ks, map_ns, map_ke, map_pr, map_pm, norm, map_bump, .. } =
            table;
        let MaterialTable { map_tf, map_transmission, .. } = table;
        for (used, map) in [
            (MapUse::Color, map_kd),
            (MapUse::Opacity, map_d),
            (MapUse::Specular, map_ks),
            (MapUse::Shininess, map_ns),
            (MapUse::Emission, map_ke),
            (MapUse::Roughness, map_pr),
            (MapUse::Metal, map_pm),
            (MapUse::Normal, norm),
            (MapUse::Bump, map_bump),
            (MapUse::Filter, map_tf),
            (MapUse::Transmission, map_transmission),
        ] {
            let line = |map: &At<String>| self.0.fault(map.span(), "").line.unwrap_or(1);
            maps[used] = map.as_ref().map(|map| MapStatement::plain(map.get_ref().as_str(), line(map)));
        }
        maps[MapUse::Displacement] = self.displacement(table)?;
        Ok(maps)
    }

    /// Picture of heights that move vertices.
    fn displacement(&self, table: &MaterialTable) -> Result<Option<MapStatement>, SceneError> {
        let MaterialTable { map_displacement, displacement, displacement_middle, .. } = table;
        let read = |key: &str, value: &Option<At<f64>>, otherwise: f32| match value {
            Some(value) if map_displacement.is_none() => {
                Err(self.0.bad(key, value, "goes with `map_displacement`: name a picture, or take it out"))
            }
            Some(value) => {
                let is_near = |number: f64| number.abs() <= 1e9;
                Ok(self.0.number(key, value, "a length from -1e9 to 1e9", is_near)? as f32)
            }
            None => Ok(otherwise),
        };
        let slope = read("displacement", displacement, 1.0)?;
        let middle = read("displacement_middle", displacement_middle, 0.5)?;
        Ok(map_displacement.as_ref().map(|map| {
            let line = self.0.fault(map.span(), "").line.unwrap_or(1);
            MapStatement { slope, middle, ..MapStatement::plain(map.get_ref().as_str(), line) }
        }))
    }

    fn color(&self, key: &str, value: &Option<Three>) -> Result<Option<Vec3>, SceneError> {
        let color = optional_color(self.0, key, value)?;
        match value.as_ref().filter(|_| color.is_some_and(|color| color.max_element() > LARGEST_COLOR)) {
            Some(value) => Err(self.0.bad(key, value, "is too large: 65504 is the most that can be kept")),
            None => Ok(color),
        }
    }

    /// A number from 0 to `most`.
    fn number(
        &self,
        key: &str,
        value: &Option<At<f64>>,
        wanted: &str,
        most: f64,
    ) -> Result<Option<f32>, SceneError> {
        let fits = |number| (0.0..=most).contains(&number);
        let read = |value| self.0.number(key, value, wanted, fits).map(|number| number as f32);
        value.as_ref().map(read).transpose()
    }

    /// Transmission filter of a table; none if it states none.
    fn filter(&self, table: &MaterialTable) -> Result<Option<Vec3>, SceneError> {
        let stated = optional_color(self.0, "tf", &table.tf)?;
        let (Some(value), true) = (&table.tf, stated.is_some()) else { return Ok(None) };
        if stated.is_some_and(|filter| filter.max_element() > 1.0) {
            return Err(self.0.bad("tf", value, "must have channels from 0 (none) to 1 (all of the light)"));
        }
        if table.transmission.is_some() {
            return Err(self.0.bad(
                "tf",
                value,
                "and `transmission` exclude each other: `kd` tints what `transmission` lets through",
            ));
        }
        Ok(stated)
    }
}

/// Path of the MaterialX file that a table names.
fn mtlx_file(text: TomlText<'_>, file: &At<String>) -> Result<PathBuf, SceneError> {
    let name = file.get_ref();
    let folder = text.path.parent().unwrap_or(Path::new(""));
    find_beside(folder, name)
        .ok_or_else(|| text.fault(file.span(), format!("the MaterialX file `{name}` cannot be found")))
}
