//! Shaders of materials: their inputs as OpenPBR's parameters.

use glam::Vec3;

use super::document::{Document, Element, Stated};
use super::picture_nodes::Pictures;
use super::volumes;
use super::walk::{Finding, Value, Walk};
use crate::graph::{Graph, Input, Kind, numbers};
use crate::scene::SceneError;
use crate::scene::import::surfaces::spread::of_aspect;
use crate::scene::material::Along;
use crate::scene::surface::{ALL, Displaced, Heights, INDEX_OF_COAT, Parameter, Surface};

/// From inputs of a shader to parameters. Inputs that are not here are told, unless they have no value.
struct Shader {
    category: &'static str,
    inputs: &'static [(&'static str, Parameter)],
    /// Values where the shader's defaults differ from OpenPBR's.
    defaults: &'static [(Parameter, f32)],
}

/// Autodesk's Standard Surface 1.0.1.
const STANDARD_SURFACE: Shader = Shader {
    category: "standard_surface",
    inputs: &[
        ("base", Parameter::BaseWeight),
        ("base_color", Parameter::BaseColor),
        ("diffuse_roughness", Parameter::BaseDiffuseRoughness),
        ("metalness", Parameter::BaseMetalness),
        ("specular", Parameter::SpecularWeight),
        ("specular_color", Parameter::SpecularColor),
        ("specular_roughness", Parameter::SpecularRoughness),
        ("specular_IOR", Parameter::SpecularIor),
        ("specular_anisotropy", Parameter::SpecularRoughnessAnisotropy),
        ("transmission", Parameter::TransmissionWeight),
        ("transmission_color", Parameter::TransmissionColor),
        ("transmission_depth", Parameter::TransmissionDepth),
        ("subsurface", Parameter::SubsurfaceWeight),
        ("subsurface_color", Parameter::SubsurfaceColor),
        ("subsurface_scale", Parameter::SubsurfaceRadius),
        ("subsurface_radius", Parameter::SubsurfaceRadiusScale),
        ("sheen", Parameter::FuzzWeight),
        ("sheen_color", Parameter::FuzzColor),
        ("sheen_roughness", Parameter::FuzzRoughness),
        ("coat", Parameter::CoatWeight),
        ("coat_color", Parameter::CoatColor),
        ("coat_roughness", Parameter::CoatRoughness),
        ("coat_IOR", Parameter::CoatIor),
        ("emission", Parameter::EmissionLuminance),
        ("emission_color", Parameter::EmissionColor),
        ("opacity", Parameter::GeometryOpacity),
        ("thin_walled", Parameter::GeometryThinWalled),
    ],
    defaults: &[
        (Parameter::SpecularRoughness, 0.2),
        (Parameter::CoatRoughness, 0.1),
        (Parameter::FuzzRoughness, 0.3),
        (Parameter::SubsurfaceColor, 1.0),
        (Parameter::SubsurfaceRadiusScale, 1.0),
        (Parameter::CoatIor, INDEX_OF_COAT),
        (Parameter::CoatDarkening, 0.0),
    ],
};

/// Khronos' glTF PBR.
const GLTF_PBR: Shader = Shader {
    category: "gltf_pbr",
    inputs: &[
        ("base_color", Parameter::BaseColor),
        ("metallic", Parameter::BaseMetalness),
        ("roughness", Parameter::SpecularRoughness),
        ("ior", Parameter::SpecularIor),
        ("specular", Parameter::SpecularWeight),
        ("specular_color", Parameter::SpecularColor),
        ("transmission", Parameter::TransmissionWeight),
        ("clearcoat", Parameter::CoatWeight),
        ("clearcoat_roughness", Parameter::CoatRoughness),
        ("sheen_color", Parameter::FuzzColor),
        ("sheen_roughness", Parameter::FuzzRoughness),
        ("emissive", Parameter::EmissionColor),
        ("emissive_strength", Parameter::EmissionLuminance),
        ("alpha", Parameter::GeometryOpacity),
    ],
    defaults: &[
        (Parameter::BaseColor, 1.0),
        (Parameter::BaseMetalness, 1.0),
        (Parameter::SpecularRoughness, 1.0),
        (Parameter::FuzzWeight, 1.0),
        (Parameter::FuzzColor, 0.0),
        (Parameter::FuzzRoughness, 0.0),
        (Parameter::CoatIor, INDEX_OF_COAT),
        (Parameter::CoatDarkening, 0.0),
        (Parameter::EmissionColor, 0.0),
        (Parameter::EmissionLuminance, 1.0),
    ],
};

/// Pixar's UsdPreviewSurface.
const PREVIEW_SURFACE: Shader = Shader {
    category: "UsdPreviewSurface",
    inputs: &[
        ("diffuseColor", Parameter::BaseColor),
        ("metallic", Parameter::BaseMetalness),
        ("roughness", Parameter::SpecularRoughness),
        ("ior", Parameter::SpecularIor),
        ("clearcoat", Parameter::CoatWeight),
        ("clearcoatRoughness", Parameter::CoatRoughness),
        ("emissiveColor", Parameter::EmissionColor),
        ("opacity", Parameter::GeometryOpacity),
    ],
    defaults: &[
        (Parameter::BaseColor, 0.18),
        (Parameter::SpecularRoughness, 0.5),
        (Parameter::CoatRoughness, 0.01),
        (Parameter::CoatIor, INDEX_OF_COAT),
        (Parameter::CoatDarkening, 0.0),
        (Parameter::EmissionColor, 0.0),
        (Parameter::EmissionLuminance, 1.0),
    ],
};

/// Shaders that are known beside OpenPBR, whose parameters have its own names.
const TRANSLATED: [&Shader; 3] = [&STANDARD_SURFACE, &GLTF_PBR, &PREVIEW_SURFACE];

/// OpenPBR's own shader.
const OPEN_PBR: &str = "open_pbr_surface";

/// Returns true if surfaces may have this shader.
#[cfg(feature = "usd")]
pub fn is_known(category: &str) -> bool {
    category == OPEN_PBR || TRANSLATED.iter().any(|known| known.category == category)
}

/// Inputs that are no parameters of what a surface reflects, and so need not be told.
const SILENT: [&str; 2] = ["useSpecularWorkflow", "occlusion"];

/// Layers of shaders: what the names of their inputs begin with, and the inputs that say how much there is of them.
const LAYERS: [(&str, &[&str]); 15] = [
    ("subsurface", &["subsurface", "subsurface_weight"]),
    ("thin_film", &["thin_film_weight", "thin_film_thickness"]),
    ("transmission", &["transmission", "transmission_weight"]),
    ("sheen", &["sheen", "sheen_color"]),
    ("fuzz", &["fuzz_weight"]),
    ("geometry_thin_walled", &["geometry_thin_walled"]),
    ("geometry_coat", &["coat_weight"]),
    ("coat", &["coat", "coat_weight"]),
    ("thin_walled", &["thin_walled"]),
    ("specular_rotation", &["specular_anisotropy"]),
    ("iridescence", &["iridescence"]),
    ("thickness", &["thickness"]),
    ("specularColor", &["useSpecularWorkflow"]),
    ("opacityThreshold", &["opacityThreshold"]),
    ("displacement", &["displacement"]),
];

/// Returns true unless an input is of a layer of which there is nothing.
fn is_there(shader: &Element, input: &str) -> bool {
    let Some((_, weights)) = LAYERS.iter().find(|(layer, _)| input.starts_with(layer)) else { return true };
    let weights = weights.iter().filter_map(|weight| shader.input(weight));
    let is_none = |text: &str| {
        text == "false" || numbers(text).is_ok_and(|all| all.iter().all(|weight| *weight == 0.0))
    };
    weights.into_iter().any(|stated| stated.value.as_deref().is_none_or(|text| !is_none(text)))
}

/// Inputs of materials that lead to shaders.
const SHADERS: [&str; 3] = ["surfaceshader", "displacementshader", "volumeshader"];

/// See [`super::surface`].
pub fn surface(
    document: &Document,
    name: &str,
    pictures: Pictures<'_>,
) -> Result<(Surface, Vec<Finding>), SceneError> {
    let material = document.material(name)?;
    let stated = material.input("surfaceshader");
    let shader = stated.and_then(|stated| document.element("", stated.node.as_deref()?));
    let mut walk = Walk::new(document, pictures);
    for other in material.inputs.iter().filter(|input| !SHADERS.contains(&input.name.as_str())) {
        walk.tell(material.line, format!("`{}` is not used", other.name));
    }
    let volume = volumes::of(&mut walk, material)?;
    let shader = match (shader, volume) {
        (Some(shader), _) => shader,
        (None, Some(_)) => {
            let mut surface = Surface::matt(name, Vec3::ZERO);
            (surface.graph, surface.volume, surface.has_surface) = (walk.graph, volume, false);
            return Ok((surface, walk.findings));
        }
        (None, None) => {
            let message = format!("the material `{name}` has no `surfaceshader` with a `nodename`");
            return Err(document.fault(material, message));
        }
    };
    let found = match shader.category.as_str() {
        OPEN_PBR => open_pbr(&mut walk, shader)?,
        category => {
            let known = TRANSLATED.into_iter().find(|known| known.category == category).ok_or_else(|| {
                let message = format!(
                    "the shader of `{name}` is `{category}`: take open_pbr_surface, standard_surface, gltf_pbr or UsdPreviewSurface"
                );
                document.fault(shader, message)
            })?;
            translated(&mut walk, shader, known)?
        }
    };
    let mut surface = Surface::new(name, Graph::default());
    surface.volume = volume;
    bend_normals(&mut walk, shader, &mut surface)?;
    if let Some(stated) = material.input("displacementshader") {
        surface.displaced = displaced(&mut walk, material, stated)?;
    }
    surface.graph = std::mem::take(&mut walk.graph);
    for (parameter, (value, kind)) in found {
        let value = surface.graph.converted(value, kind, ALL[parameter as usize].kind);
        let is_reflectance = REFLECTANCES.contains(&parameter);
        surface[parameter] = if is_reflectance { reflectance(value) } else { value }.into();
    }
    if shader.category == STANDARD_SURFACE.category {
        spread_as_open_pbr(&mut surface);
    }
    let mut findings = walk.findings;
    findings.extend(surface.left_out().into_iter().map(|said| (shader.line, said)));
    Ok((surface, findings))
}

/// Parameters that are shares of light.
const REFLECTANCES: [Parameter; 3] =
    [Parameter::BaseColor, Parameter::BaseWeight, Parameter::SubsurfaceColor];

/// A colour that reflects no more light than there is; what graphs give is cut off where it is evaluated.
fn reflectance(value: Input) -> Input {
    match value {
        Input::Constant(color) => Input::Constant(color.clamp(Vec3::ZERO, Vec3::ONE)),
        Input::Node(_) => value,
    }
}

/// Turns the roughness and the anisotropy of a Standard Surface, whose widths are others, into those of OpenPBR; of constants.
fn spread_as_open_pbr(surface: &mut Surface) {
    use Parameter::{SpecularRoughness, SpecularRoughnessAnisotropy};
    let anisotropy = f64::from(surface.number(SpecularRoughnessAnisotropy));
    if anisotropy <= 0.0 {
        return;
    }
    let (amount, roughness) = of_aspect(surface.number(SpecularRoughness).into(), anisotropy);
    surface[SpecularRoughnessAnisotropy] = (amount as f32).into();
    if surface[SpecularRoughness].node.is_none() {
        surface[SpecularRoughness] = (roughness as f32).into();
    }
}

/// Finds what bends the shader's normals: heights, or a picture of normals.
fn bend_normals(walk: &mut Walk<'_, '_>, shader: &Element, surface: &mut Surface) -> Result<(), SceneError> {
    let Some(stated) = NORMALS.iter().find_map(|name| shader.input(name)) else { return Ok(()) };
    let Some(node) = walk.node_behind(shader, stated)? else { return Ok(()) };
    match node.category.as_str() {
        "bump" | "blender_bump" => surface.heights = heights(walk, node)?,
        "normalmap" | "gltf_normalmap" => {
            let behind = node.input("in").map(|stated| walk.node_behind(node, stated)).transpose()?;
            let picture = behind.flatten().unwrap_or(node);
            if picture.category == "heighttonormal" {
                surface.heights = heights(walk, picture)?;
                return Ok(());
            }
            // that of glTF's is of texture coordinates
            let scale = if node.category == "normalmap" { number(walk, node, "scale")? } else { 1.0 };
            match walk.normals(picture)? {
                Some(map) => surface.normals = Some((map, scale)),
                None => walk.tell(node.line, String::from("normals that are computed are not used")),
            }
        }
        other => walk.tell(node.line, format!("normals by nodes `{other}` are not used")),
    }
    Ok(())
}

fn heights(walk: &mut Walk<'_, '_>, node: &Element) -> Result<Option<Heights>, SceneError> {
    let Some(height) = node.input("height").or_else(|| node.input("in")) else { return Ok(None) };
    let Some((height, kind)) = walk.value(node, height)? else { return Ok(None) };
    let height = walk.graph.converted(height, kind, Kind::Number);
    let distance = number(walk, node, if node.category == "blender_bump" { "distance" } else { "scale" })?;
    Ok(Some(Heights { height, distance, strength: number(walk, node, "strength")? }))
}

/// What moves vertices: a `displacement`, whose vectors are along the tangent, across it and along the normal, or one of Blender's.
fn displaced(
    walk: &mut Walk<'_, '_>,
    material: &Element,
    stated: &Stated,
) -> Result<Option<Displaced>, SceneError> {
    let Some(node) = stated.node.as_deref().and_then(|name| walk.document.element("", name)) else {
        walk.tell(material.line, String::from("`displacementshader` names no node: nothing is displaced"));
        return Ok(None);
    };
    let is_of_blender = node.category == "blender_displacement";
    if !is_of_blender && node.category != "displacement" {
        walk.tell(node.line, format!("displacement by nodes `{}` is not used", node.category));
        return Ok(None);
    }
    let Some(value) = node.input("displacement") else { return Ok(None) };
    let Some((by, kind)) = walk.value(node, value)? else { return Ok(None) };
    let along = match walk.document.text(node, "space") {
        Some("object") if is_of_blender => Along::ObjectSpace,
        _ if kind == Kind::Number => Along::Normal,
        _ => Along::TangentSpace,
    };
    let middle =
        if is_of_blender && node.input("midlevel").is_some() { number(walk, node, "midlevel")? } else { 0.0 };
    Ok(Some(Displaced { by, scale: number(walk, node, "scale")?, middle, along }))
}

/// A number that a node states; 1 where it states none, or a graph gives it.
fn number(walk: &mut Walk<'_, '_>, node: &Element, name: &str) -> Result<f32, SceneError> {
    let value = node.input(name).map(|stated| walk.value(node, stated)).transpose()?.flatten();
    Ok(match value {
        Some((Input::Constant(value), _)) => value.x,
        _ => 1.0,
    })
}

/// Inputs of shaders that are normals.
const NORMALS: [&str; 2] = ["geometry_normal", "normal"];

type Found = Vec<(Parameter, Value)>;

fn open_pbr(walk: &mut Walk<'_, '_>, shader: &Element) -> Result<Found, SceneError> {
    let named = |name: &str| ALL.iter().find(|of| of.name == name).map(|of| of.parameter);
    all(walk, shader, &named)
}

fn translated(walk: &mut Walk<'_, '_>, shader: &Element, as_known: &Shader) -> Result<Found, SceneError> {
    let defaults = as_known.defaults.iter().map(|(parameter, number)| {
        (*parameter, (Input::Constant(Vec3::splat(*number)), ALL[*parameter as usize].kind))
    });
    let mut found: Found = defaults.collect();
    let of = |name: &str| as_known.inputs.iter().find(|(input, _)| *input == name).map(|(_, of)| *of);
    let stated = all(walk, shader, &of)?;
    // what glass lets through has its base colour there
    let base = stated.iter().find(|(parameter, _)| *parameter == Parameter::BaseColor);
    let tint = base.filter(|_| as_known.category == GLTF_PBR.category).map(|(_, value)| *value);
    found.extend(tint.map(|value| (Parameter::TransmissionColor, value)));
    found.extend(stated);
    Ok(found)
}

/// The values of all inputs that a shader states.
fn all(
    walk: &mut Walk<'_, '_>,
    shader: &Element,
    parameter: &dyn Fn(&str) -> Option<Parameter>,
) -> Result<Found, SceneError> {
    let mut found = Found::new();
    for stated in &shader.inputs {
        match parameter(&stated.name) {
            Some(parameter) => {
                found.extend(walk.value(shader, stated)?.map(|value| (parameter, value)));
            }
            None if NORMALS.contains(&stated.name.as_str()) => {}
            None if SILENT.contains(&stated.name.as_str()) || !is_there(shader, &stated.name) => {}
            None => {
                let what = format!("`{}` of `{}` is not used", stated.name, shader.category);
                walk.tell(shader.line, what);
            }
        }
    }
    Ok(found)
}
