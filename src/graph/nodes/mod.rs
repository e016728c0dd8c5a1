//! Kinds of nodes, a file a family. A new one is a [`Definition`] in its file, and a line here.

pub mod arithmetic;
pub mod colors;
pub mod eye;
pub mod hextile;
pub mod inputs;
pub mod patterns;
pub mod picture;

use super::Definition;

/// All kinds of nodes that files may name.
pub static ALL: &[&Definition] = &[
    &inputs::UV,
    &inputs::POINT,
    &inputs::GENERATED,
    &inputs::NORMAL,
    &inputs::WORLD_POINT,
    &inputs::WORLD_NORMAL,
    &inputs::MODEL_PLACE,
    &inputs::MODEL_RANDOM,
    &inputs::VERTEX_COLOR,
    &inputs::VOLUME_GRID,
    &eye::FRESNEL,
    &eye::LAYER_WEIGHT,
    &eye::FACING_RATIO,
    &arithmetic::MATH,
    &arithmetic::VECTOR_MATH,
    &arithmetic::MIX_NUMBER,
    &arithmetic::MIX_VECTOR,
    &arithmetic::MIX_COLOR,
    &arithmetic::CLAMP,
    &arithmetic::MAP_RANGE,
    &arithmetic::MAP_RANGE_VECTOR,
    &arithmetic::MAPPING,
    &arithmetic::VECTOR_ROTATE,
    &arithmetic::SEPARATE_XYZ,
    &arithmetic::COMBINE_XYZ,
    &colors::HUE_SATURATION,
    &colors::BRIGHT_CONTRAST,
    &colors::GAMMA,
    &colors::INVERT,
    &colors::LUMINANCE,
    &colors::SEPARATE,
    &colors::COMBINE,
    &colors::RAMP,
    &colors::RGB_CURVES,
    &colors::VECTOR_CURVES,
    &colors::FLOAT_CURVE,
    &colors::BLACKBODY,
    &colors::WAVELENGTH,
    &patterns::NOISE,
    &patterns::VORONOI,
    &patterns::WAVE,
    &patterns::MAGIC,
    &patterns::CHECKER,
    &patterns::BRICK,
    &patterns::GRADIENT,
    &patterns::WHITE,
    &patterns::GABOR,
];

/// The kind of node with this name.
pub fn named(name: &str) -> Option<&'static Definition> {
    ALL.iter().find(|definition| definition.name == name).copied()
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::graph::{Graph, Input, Options};

    /// Names are those of files: each means one kind of node, and each kind can be made without options, or says what it lacks.
    #[test]
    fn every_kind_has_a_name_of_its_own_and_can_be_made() {
        let names: HashSet<&str> = ALL.iter().map(|definition| definition.name).collect();
        assert_eq!(names.len(), ALL.len());
        for definition in ALL {
            for output in 0..definition.outputs.len() {
                let made = Graph::default().add_defined(definition, &Options::default(), &[], output);
                match made {
                    Ok(Input::Constant(value)) => assert!(value.is_finite(), "{}", definition.name),
                    Ok(Input::Node(_)) => {}
                    Err(why) => assert!(why.contains('`'), "{}: {why}", definition.name),
                }
            }
        }
    }
}
