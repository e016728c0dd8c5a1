//! Hair of a shot file: its lobes, and the colour that its absorption gives it.

use glam::{DVec3, Vec3};

use crate::scene::SceneError;
use crate::scene::keys::hair::HairTable;
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::material::Hair;
use crate::shade::bsdf::log_of_hair_color;

/// Values where none are stated: those of human hair.
const USUAL: Hair = Hair {
    roughness: 0.3,
    radial_roughness: 0.3,
    coat: 0.0,
    index: 1.55,
    offset: 2.0 / 180.0 * std::f32::consts::PI,
};

/// Absorption of red, green and blue light by either kind of melanin, of a concentration of 1 (E. d'Eon and others, "An Energy-Conserving Hair
/// Reflectance Model", 2011, as Cycles has them).
const BLACK_MELANIN: DVec3 = DVec3::new(0.506, 0.841, 1.653);
const RED_MELANIN: DVec3 = DVec3::new(0.343, 0.733, 1.924);

/// Reads what hair is made of, and the colour that its pigments give it, if it states any.
///
/// # Errors With line and column: values that make no sense, alone or together.
pub fn of_table(text: TomlText<'_>, table: &At<HairTable>) -> Result<(Hair, Option<Vec3>), SceneError> {
    let keys = table.get_ref();
    let read = |key, value: &Option<At<f64>>, [least, most]: [f64; 2], usual: f32| {
        let fits = |number: f64| (least..=most).contains(&number);
        let wanted = format!("from {least} to {most}");
        let read = value.as_ref().map(|value| text.number(key, value, &wanted, fits)).transpose();
        read.map(|number| number.map_or(f64::from(usual), |number| number))
    };
    const SHARE: [f64; 2] = [0.0, 1.0];
    let offset = read("offset", &keys.offset, [-45.0, 45.0], USUAL.offset.to_degrees())?;
    let hair = Hair {
        roughness: read("roughness", &keys.roughness, SHARE, USUAL.roughness)? as f32,
        radial_roughness: read("radial_roughness", &keys.radial_roughness, SHARE, USUAL.radial_roughness)?
            as f32,
        coat: read("coat", &keys.coat, SHARE, USUAL.coat)? as f32,
        index: read("ni", &keys.ni, [1.01, 4.0], USUAL.index)? as f32,
        offset: offset.to_radians() as f32,
    };
    let of_color = f64::from(log_of_hair_color(hair.radial_roughness));
    let color = |absorption: DVec3| (-absorption.max(DVec3::ZERO).powf(0.5) * of_color).exp().as_vec3();
    let by_absorption = keys.absorption.as_ref();
    let by_absorption = by_absorption.map(|value| text.color("absorption", value)).transpose()?;
    let Some(stated) = &keys.melanin else {
        for (key, value) in [
            ("melanin_redness", keys.melanin_redness.as_ref().map(At::span)),
            ("tint", keys.tint.as_ref().map(At::span)),
        ] {
            if let Some(span) = value {
                return Err(
                    text.fault(span, format!("`{key}` goes with `melanin`: state that, or take it out"))
                );
            }
        }
        return Ok((hair, by_absorption.map(|absorption| color(absorption.as_dvec3()))));
    };
    if let Some(absorption) = &keys.absorption {
        return Err(text.bad(
            "absorption",
            absorption,
            "and `melanin` exclude each other: take one of them out",
        ));
    }
    let melanin = text.number("melanin", stated, "from 0 to 1", |number| (0.0..=1.0).contains(&number))?;
    let redness = read("melanin_redness", &keys.melanin_redness, SHARE, 1.0)?;
    let tint = keys.tint.as_ref().map(|tint| text.color("tint", tint)).transpose()?.unwrap_or(Vec3::ONE);
    // even steps of what is stated look even (B. Bitterli, "Practical hair", 2016, as Cycles has it)
    let amount = -(1.0 - melanin).max(1e-4).ln();
    let of_melanin = BLACK_MELANIN * (amount * (1.0 - redness)) + RED_MELANIN * (amount * redness);
    let of_tint = (tint.as_dvec3().clamp(DVec3::splat(1e-5), DVec3::ONE).to_array())
        .map(|share| (share.ln() / of_color).powi(2));
    Ok((hair, Some(color(of_melanin + DVec3::from_array(of_tint)))))
}
