//! What a surface is made of: the parameters of OpenPBR Surface 1.1 by their names, each a constant or a value of a graph.
//!
//! Readers of files make surfaces; what the renderer has as constants alone, and graphs give, is [told](Surface::left_out).

use std::ops::{Index, IndexMut};

use glam::Vec3;

use crate::graph::{Graph, Input, Kind};

/// A parameter of OpenPBR. `ALL` has them in the same order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "named as the specification has them")]
pub enum Parameter {
    BaseWeight,
    BaseColor,
    BaseDiffuseRoughness,
    BaseMetalness,
    SpecularWeight,
    SpecularColor,
    SpecularRoughness,
    SpecularRoughnessAnisotropy,
    SpecularIor,
    TransmissionWeight,
    TransmissionColor,
    TransmissionDepth,
    SubsurfaceWeight,
    SubsurfaceColor,
    SubsurfaceRadius,
    SubsurfaceRadiusScale,
    CoatWeight,
    CoatColor,
    CoatRoughness,
    CoatIor,
    CoatDarkening,
    FuzzWeight,
    FuzzColor,
    FuzzRoughness,
    EmissionLuminance,
    EmissionColor,
    GeometryOpacity,
    GeometryThinWalled,
}

/// Name, kind and default of a parameter.
#[derive(Debug)]
pub struct Described {
    /// The parameter.
    pub parameter: Parameter,
    /// Name in the specification.
    pub name: &'static str,
    /// Kind of its values.
    pub kind: Kind,
    /// Value where none is stated.
    pub default: [f32; 3],
}

const fn number(parameter: Parameter, name: &'static str, default: f32) -> Described {
    Described { parameter, name, kind: Kind::Number, default: [default; 3] }
}

const fn color(parameter: Parameter, name: &'static str, default: f32) -> Described {
    Described { parameter, name, kind: Kind::Color, default: [default; 3] }
}

/// All parameters, in the order of [`Parameter`].
pub const ALL: [Described; 28] = [
    number(Parameter::BaseWeight, "base_weight", 1.0),
    color(Parameter::BaseColor, "base_color", 0.8),
    number(Parameter::BaseDiffuseRoughness, "base_diffuse_roughness", 0.0),
    number(Parameter::BaseMetalness, "base_metalness", 0.0),
    number(Parameter::SpecularWeight, "specular_weight", 1.0),
    color(Parameter::SpecularColor, "specular_color", 1.0),
    number(Parameter::SpecularRoughness, "specular_roughness", 0.3),
    number(Parameter::SpecularRoughnessAnisotropy, "specular_roughness_anisotropy", 0.0),
    number(Parameter::SpecularIor, "specular_ior", 1.5),
    number(Parameter::TransmissionWeight, "transmission_weight", 0.0),
    color(Parameter::TransmissionColor, "transmission_color", 1.0),
    number(Parameter::TransmissionDepth, "transmission_depth", 0.0),
    number(Parameter::SubsurfaceWeight, "subsurface_weight", 0.0),
    color(Parameter::SubsurfaceColor, "subsurface_color", 0.8),
    number(Parameter::SubsurfaceRadius, "subsurface_radius", 1.0),
    Described {
        default: [1.0, 0.5, 0.25],
        ..color(Parameter::SubsurfaceRadiusScale, "subsurface_radius_scale", 1.0)
    },
    number(Parameter::CoatWeight, "coat_weight", 0.0),
    color(Parameter::CoatColor, "coat_color", 1.0),
    number(Parameter::CoatRoughness, "coat_roughness", 0.0),
    number(Parameter::CoatIor, "coat_ior", 1.6),
    number(Parameter::CoatDarkening, "coat_darkening", 1.0),
    number(Parameter::FuzzWeight, "fuzz_weight", 0.0),
    color(Parameter::FuzzColor, "fuzz_color", 1.0),
    number(Parameter::FuzzRoughness, "fuzz_roughness", 0.5),
    number(Parameter::EmissionLuminance, "emission_luminance", 0.0),
    color(Parameter::EmissionColor, "emission_color", 1.0),
    number(Parameter::GeometryOpacity, "geometry_opacity", 1.0),
    number(Parameter::GeometryThinWalled, "geometry_thin_walled", 0.0),
];

/// Parameters that the renderer has as constants alone: of a graph the default counts.
const CONSTANT: [Parameter; 20] = [
    Parameter::BaseDiffuseRoughness,
    Parameter::SubsurfaceWeight,
    Parameter::SubsurfaceRadius,
    Parameter::SubsurfaceRadiusScale,
    Parameter::SpecularWeight,
    Parameter::SpecularColor,
    Parameter::SpecularIor,
    Parameter::SpecularRoughnessAnisotropy,
    Parameter::TransmissionWeight,
    Parameter::TransmissionColor,
    Parameter::TransmissionDepth,
    Parameter::CoatWeight,
    Parameter::CoatRoughness,
    Parameter::CoatIor,
    Parameter::CoatColor,
    Parameter::CoatDarkening,
    Parameter::FuzzWeight,
    Parameter::FuzzColor,
    Parameter::FuzzRoughness,
    Parameter::GeometryThinWalled,
];

/// Heights of a surface that is rougher than its triangles.
#[derive(Debug, Clone, Copy)]
pub struct Heights {
    /// The heights.
    pub height: Input,
    /// Length for which a height of 1 stands, object space.
    pub distance: f32,
    /// Share of the bent normal, from 0 to 1.
    pub strength: f32,
}

/// A surface.
#[derive(Debug)]
pub struct Surface {
    /// Name of the material.
    pub name: String,
    /// Nodes that its parameters take.
    pub graph: Graph,
    /// Heights that bend its normal (`geometry_normal`).
    pub heights: Option<Heights>,
    /// Number of the shot's picture of its normals, with the factor on their slopes.
    pub normals: Option<(u32, f32)>,
    values: [Input; ALL.len()],
}

impl Index<Parameter> for Surface {
    type Output = Input;

    fn index(&self, parameter: Parameter) -> &Input {
        &self.values[parameter as usize]
    }
}

impl IndexMut<Parameter> for Surface {
    fn index_mut(&mut self, parameter: Parameter) -> &mut Input {
        &mut self.values[parameter as usize]
    }
}

impl Surface {
    /// Creates the specification's default surface, with the nodes of `graph` to take values from.
    pub fn new(name: impl Into<String>, graph: Graph) -> Self {
        Self {
            name: name.into(),
            graph,
            heights: None,
            normals: None,
            values: ALL.map(|of| Input::Constant(Vec3::from(of.default))),
        }
    }

    /// The parameter's value; its default if a graph gives it.
    pub fn constant(&self, parameter: Parameter) -> Vec3 {
        match self[parameter] {
            Input::Constant(value) => value,
            Input::Node(_) => Vec3::from(ALL[parameter as usize].default),
        }
    }

    /// [`constant`](Self::constant) of a parameter that is a number.
    pub fn number(&self, parameter: Parameter) -> f32 {
        self.constant(parameter).x
    }

    /// A sentence about what graphs give of it that the renderer has as constants alone, if they give any.
    pub fn left_out(&self) -> Option<String> {
        let described = CONSTANT.iter().map(|parameter| &ALL[*parameter as usize]);
        let computed: Vec<&str> = described
            .filter(|of| matches!(self[of.parameter], Input::Node(_)))
            .map(|described| described.name)
            .collect();
        let said = || format!("a graph gives {}: the default counts in its place", computed.join(", "));
        (!computed.is_empty()).then(said)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_where_their_names_say() {
        for (number, described) in ALL.iter().enumerate() {
            assert_eq!(described.parameter as usize, number, "{}", described.name);
        }
        assert_eq!(CONSTANT.len() + 8, ALL.len(), "all but those that vary");
    }
}
