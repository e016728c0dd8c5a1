//! Names of MaterialX's definitions, by which USD files call nodes: `ND_image_color3`, `ND_open_pbr_surface_surfaceshader`.

use super::picture_nodes::{HEXAGONS, IMAGES};
use super::{shaders, standard};
use crate::graph::nodes;

/// What names of definitions begin with.
const BEGIN: &str = "ND_";

/// Nodes that are known beside those that are arithmetic, patterns or pictures.
const OTHERS: [&str; 14] = [
    "UsdPrimvarReader",
    "blender_bump",
    "bump",
    "displacement",
    "dot",
    "geomcolor",
    "geompropvalue",
    "gltf_normalmap",
    "heighttonormal",
    "normal",
    "normalmap",
    "position",
    "swizzle",
    "texcoord",
];

/// A kind of node, of the name of its definition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeKind {
    /// Name of the kind, as MaterialX files have it.
    pub category: String,
    /// Type of its values, if the name ends with it.
    pub of_type: Option<String>,
    /// True if it is a surface that is known.
    pub is_surface: bool,
}

impl NodeKind {
    /// The kind that the name of a definition means; `None` of what is no such name. A kind that is not known keeps all of its name but
    /// the type.
    pub fn of_definition(id: &str) -> Option<Self> {
        let name = id.strip_prefix(BEGIN)?;
        let ends = name.match_indices('_').map(|(at, _)| at).chain([name.len()]);
        let known = ends.rev().map(|end| &name[..end]).find(|begin| is_known(begin));
        // operands of other types than the values are letters at the end: `color3FA`
        let last = name
            .rsplit('_')
            .next()
            .unwrap_or(name)
            .trim_end_matches(|letter: char| letter.is_ascii_uppercase());
        let of_type = is_type(last).then(|| last.to_string());
        let without = || match (name.rsplit_once('_'), &of_type) {
            (Some((begin, _)), Some(_)) => begin,
            _ => name,
        };
        let category = known.unwrap_or_else(without).to_string();
        Some(Self { is_surface: shaders::is_known(&category), category, of_type })
    }
}

fn is_known(name: &str) -> bool {
    let is_special = OTHERS.contains(&name) || IMAGES.contains(&name) || name == HEXAGONS;
    is_special || shaders::is_known(name) || standard::named(name).is_some() || nodes::named(name).is_some()
}

fn is_type(name: &str) -> bool {
    let names =
        ["float", "integer", "boolean", "color3", "color4", "vector2", "vector3", "vector4", "surfaceshader"];
    names.contains(&name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_those_of_the_longest_name() {
        let of = |id: &str| {
            let NodeKind { category, of_type, .. } = NodeKind::of_definition(id).expect("it is a definition");
            (category, of_type.unwrap_or_default())
        };
        for (id, category, of_type) in [
            ("ND_image_color3", "image", "color3"),
            ("ND_gltf_image_color3_color3_1_0", "gltf_image", ""),
            ("ND_multiply_color3FA", "multiply", "color3"),
            ("ND_normalmap", "normalmap", ""),
            ("ND_normalmap_float", "normalmap", "float"),
            ("ND_convert_float_color3", "convert", "color3"),
            ("ND_open_pbr_surface_surfaceshader", "open_pbr_surface", "surfaceshader"),
            ("ND_standard_surface_surfaceshader_100", "standard_surface", ""),
            ("ND_tangent_turn_vector3", "tangent_turn", "vector3"),
            ("ND_blackbody", "blackbody", ""),
        ] {
            assert_eq!(of(id), (category.to_string(), of_type.to_string()), "{id}");
        }
        assert_eq!(NodeKind::of_definition("UsdUVTexture"), None);
    }
}
