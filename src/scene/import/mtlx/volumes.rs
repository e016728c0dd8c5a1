//! Volumes of materials: what fills closed meshes.

use glam::Vec3;

use super::document::Element;
use super::walk::Walk;
use crate::graph::Input;
use crate::scene::SceneError;
use crate::scene::surface::Volume;

/// The volume of a material, if it has one that is understood: a `volume` of an `anisotropic_vdf` or an `absorption_vdf`, and of a
/// `uniform_edf`.
///
/// # Errors
/// Numbers that are none; those of pictures.
pub fn of(walk: &mut Walk<'_, '_>, material: &Element) -> Result<Option<Volume>, SceneError> {
    let Some(shader) = behind(walk, material, "volumeshader", &["volume"]) else { return Ok(None) };
    let none = Input::Constant(Vec3::ZERO);
    let mut volume = Volume { scatter: none, absorb: none, emit: none, anisotropy: 0.0 };
    if let Some(vdf) = behind(walk, shader, "vdf", &["anisotropic_vdf", "absorption_vdf"]) {
        volume.scatter = value(walk, vdf, "scattering")?;
        volume.absorb = value(walk, vdf, "absorption")?;
        if let Input::Constant(anisotropy) = value(walk, vdf, "anisotropy")? {
            volume.anisotropy = anisotropy.x;
        } else {
            walk.tell(vdf.line, String::from("an anisotropy that a graph gives is not used"));
        }
    }
    if let Some(edf) = behind(walk, shader, "edf", &["uniform_edf"]) {
        volume.emit = value(walk, edf, "color")?;
    }
    Ok(Some(volume))
}

/// The element that an input names, if it is of one of these categories; others are told.
fn behind<'d>(
    walk: &mut Walk<'d, '_>,
    element: &Element,
    input: &str,
    known: &[&str],
) -> Option<&'d Element> {
    let stated = element.input(input)?;
    let document = walk.document;
    let found = document.element("", stated.node.as_deref()?)?;
    if !known.contains(&found.category.as_str()) {
        let category = &found.category;
        walk.tell(found.line, format!("`{category}` as `{input}` is not used: take {}", known.join(" or ")));
        return None;
    }
    Some(found)
}

/// The value of an input; none of it where nothing is stated.
fn value(walk: &mut Walk<'_, '_>, element: &Element, name: &str) -> Result<Input, SceneError> {
    let stated = element.input(name).map(|stated| walk.value(element, stated)).transpose()?;
    Ok(stated.flatten().map_or(Input::Constant(Vec3::ZERO), |(value, _)| value))
}
