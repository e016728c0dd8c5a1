//! What a surface is made of: the parameters of OpenPBR Surface 1.1 by their names, each a constant, or a factor of what a graph gives.
//!
//! All readers of files make surfaces, and `[[material]]` tables are laid over them; what OpenPBR has no name for is [`Beyond`] it. One
//! place [lowers](super::import::surfaces) a surface to the [`Material`](super::Material) that the renderer has.

use std::ops::{Index, IndexMut};

use glam::Vec3;

use super::material::{Along, Hair};
use crate::graph::nodes::picture::{self, Shown};
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

/// Parameters that the renderer has as constants alone: of a graph the mean counts.
const CONSTANT: [Parameter; 18] = [
    Parameter::BaseDiffuseRoughness,
    Parameter::SubsurfaceWeight,
    Parameter::SubsurfaceRadius,
    Parameter::SubsurfaceRadiusScale,
    Parameter::SpecularWeight,
    Parameter::SpecularColor,
    Parameter::SpecularIor,
    Parameter::SpecularRoughnessAnisotropy,
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

/// A value of a surface: a constant, or a factor of what a node of its graph gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// The constant, or the factor.
    pub factor: Vec3,
    /// The node, if there is one.
    pub node: Option<u32>,
}

impl Value {
    /// Black, or none.
    pub const ZERO: Self = Self::constant(Vec3::ZERO);
    /// White, or all.
    pub const ONE: Self = Self::constant(Vec3::ONE);

    /// The same everywhere.
    pub const fn constant(factor: Vec3) -> Self {
        Self { factor, node: None }
    }

    /// What the node gives, if there is one.
    pub fn given(&self) -> Option<Input> {
        self.node.map(Input::Node)
    }

    /// Takes channels of picture number `map` of the shot as what it is a factor of.
    pub fn show(&mut self, graph: &mut Graph, map: u32, shown: Shown) {
        if let Input::Node(node) = picture::add(graph, map, shown, None) {
            self.node = Some(node);
        }
    }
}

impl From<Input> for Value {
    fn from(input: Input) -> Self {
        match input {
            Input::Constant(value) => Self::constant(value),
            Input::Node(node) => Self { factor: Vec3::ONE, node: Some(node) },
        }
    }
}

impl From<Vec3> for Value {
    fn from(color: Vec3) -> Self {
        Self::constant(color)
    }
}

impl From<f32> for Value {
    fn from(number: f32) -> Self {
        Self::constant(Vec3::splat(number))
    }
}

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

/// What moves the vertices of a surface.
#[derive(Debug, Clone, Copy)]
pub struct Displaced {
    /// Heights or vectors.
    pub by: Input,
    /// Length for which 1 stands, object space.
    pub scale: f32,
    /// Value that moves nothing.
    pub middle: f32,
    /// Where to.
    pub along: Along,
}

/// Meaning of alpha that a picture has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Alpha {
    /// Places where it is below that are not there.
    Cut(f32),
    /// Each place is a veil as clear as it says, where the material can be one. Else it cuts out.
    Blend,
}

/// Alpha that says how far places of a surface are there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaceAlpha {
    /// Picture of the shot whose alpha counts.
    pub map: Option<u32>,
    /// True if that of vertices is a factor of it; places are cut out then.
    pub by_vertices: bool,
    /// Its meaning.
    pub meaning: Alpha,
}

/// Highlight of Phong's model, as MTL has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phong {
    /// Colour.
    pub color: Value,
    /// Exponent; a node gives a share of it.
    pub exponent: Value,
}

/// A mirror, as MTL has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mirror {
    /// Colour of what it reflects.
    pub tint: Vec3,
    /// True if the reflection grows towards grazing angles, by Schlick's formula.
    pub fresnel: bool,
}

/// What files state of surfaces that OpenPBR has no parameter for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beyond {
    /// Reflectance of ambient light, where it is not that of the base.
    pub ambient: Option<Vec3>,
    /// Highlight in place of the specular layer's.
    pub phong: Option<Phong>,
    /// Mirror in place of the specular layer.
    pub mirror: Option<Mirror>,
    /// Colour of the light that passes where the surface is not there (`geometry_opacity`).
    pub veil: Vec3,
    /// Colour of light that passes the surface of glass, once each time; `transmission_color` is a factor of it where there is no
    /// `transmission_depth`.
    pub glass_tint: Value,
    /// Share of the light that it reflects totally as glass, where that is not the share of it that is glass (`transmission_weight`).
    pub total_reflection: Option<Vec3>,
    /// True if the picture of the base colour is a factor of it as well.
    pub is_glass_pictured: bool,
    /// How white metal is at grazing angles, from 0 to 1, where `specular_color` does not say.
    pub metal_edge: Option<f32>,
    /// Share of the diffuse light that leaves on the other side, where `geometry_thin_walled` does not say.
    pub translucency: Option<f32>,
    /// Index of refraction and roughness of the interface by which light goes below the surface, where they are not those of the specular
    /// layer, and the share that goes in by the cosine law.
    pub entry_index: Option<f32>,
    /// See there.
    pub entry_roughness: Option<f32>,
    /// See there.
    pub entry_matt: Option<f32>,
    /// Turn of the tangent along which rough layers spread light, degrees, counter-clockwise (`geometry_tangent`).
    pub tangent_turn: f32,
    /// Axis of object space around which that tangent leads; without one it is that of the first texture coordinate.
    pub tangent_around: Option<Vec3>,
    /// Fibres of hair in place of all that reflects; the base colour is the one that the hair has in the end.
    pub hair: Option<Hair>,
}

impl Default for Beyond {
    fn default() -> Self {
        Self {
            ambient: None,
            phong: None,
            mirror: None,
            veil: Vec3::ONE,
            glass_tint: Value::ONE,
            total_reflection: None,
            is_glass_pictured: false,
            metal_edge: None,
            translucency: None,
            entry_index: None,
            entry_roughness: None,
            entry_matt: None,
            tangent_turn: 0.0,
            tangent_around: None,
            hair: None,
        }
    }
}

/// A surface.
#[derive(Debug, Clone)]
pub struct Surface {
    /// Name of the material.
    pub name: String,
    /// Nodes that its parameters take.
    pub graph: Graph,
    /// Picture of the shot that is a factor of `base_color`.
    pub base_picture: Option<u32>,
    /// True if the colours of vertices are another.
    pub is_tinted: bool,
    /// Alpha that says which places are there, beside `geometry_opacity`.
    pub alpha: Option<PlaceAlpha>,
    /// Heights that bend its normal (`geometry_normal`).
    pub heights: Option<Heights>,
    /// What moves its vertices.
    pub displaced: Option<Displaced>,
    /// Number of the shot's picture of its normals, with the factor on their slopes.
    pub normals: Option<(u32, f32)>,
    /// What OpenPBR has no parameter for.
    pub beyond: Beyond,
    /// What fills closed meshes of it, if anything does.
    pub volume: Option<Volume>,
    /// False if it is that alone.
    pub has_surface: bool,
    values: [Value; ALL.len()],
}

impl Index<Parameter> for Surface {
    type Output = Value;

    fn index(&self, parameter: Parameter) -> &Value {
        &self.values[parameter as usize]
    }
}

impl IndexMut<Parameter> for Surface {
    fn index_mut(&mut self, parameter: Parameter) -> &mut Value {
        &mut self.values[parameter as usize]
    }
}

/// What fills meshes, as MaterialX's `anisotropic_vdf` and `uniform_edf` have it.
#[derive(Debug, Clone, Copy)]
pub struct Volume {
    /// Share of light that is scattered for each unit of length.
    pub scatter: Input,
    /// Share that is absorbed.
    pub absorb: Input,
    /// Radiance that is emitted.
    pub emit: Input,
    /// Mean cosine of the angle by which light is turned.
    pub anisotropy: f32,
}

/// Index of refraction of a coat where a file that has coats states none: that of glTF and USD.
pub const INDEX_OF_COAT: f32 = 1.5;

impl Surface {
    /// Creates the specification's default surface, with the nodes of `graph` to take values from.
    pub fn new(name: impl Into<String>, graph: Graph) -> Self {
        Self {
            name: name.into(),
            graph,
            base_picture: None,
            is_tinted: false,
            alpha: None,
            heights: None,
            displaced: None,
            normals: None,
            beyond: Beyond::default(),
            volume: None,
            has_surface: true,
            values: ALL.map(|of| Value::constant(Vec3::from(of.default))),
        }
    }

    /// Creates a matt surface of one colour. A coat that is laid over it is that of formats other than OpenPBR: it darkens nothing.
    pub fn matt(name: impl Into<String>, color: Vec3) -> Self {
        let mut surface = Self::new(name, Graph::default());
        surface[Parameter::SpecularWeight] = Value::ZERO;
        surface[Parameter::BaseColor] = color.into();
        surface[Parameter::SubsurfaceColor] = color.into();
        surface[Parameter::EmissionLuminance] = Value::ONE;
        surface[Parameter::EmissionColor] = Value::ZERO;
        surface[Parameter::CoatIor] = INDEX_OF_COAT.into();
        surface[Parameter::CoatDarkening] = Value::ZERO;
        surface
    }

    /// Gives it a dielectric layer of this index, or makes it metal, or a mixture of both.
    pub fn set_layer(&mut self, index: f32, roughness: f32, metalness: f32) {
        self[Parameter::SpecularWeight] = Value::ONE;
        self[Parameter::SpecularIor] = index.into();
        self[Parameter::SpecularRoughness] = roughness.into();
        self[Parameter::BaseMetalness] = metalness.into();
    }

    /// Makes it emit this radiance, linear RGB.
    pub fn set_emission(&mut self, radiance: Vec3) {
        self[Parameter::EmissionColor] = radiance.into();
        self[Parameter::EmissionLuminance] = Value::ONE;
    }

    /// Gives a parameter channels of picture number `map` of the shot, of which its constant is the factor.
    pub fn show(&mut self, parameter: Parameter, map: u32, shown: Shown) {
        self.values[parameter as usize].show(&mut self.graph, map, shown);
    }

    /// The parameter's value; its default if a graph gives it.
    pub fn constant(&self, parameter: Parameter) -> Vec3 {
        let value = self[parameter];
        if value.node.is_some() { Vec3::from(ALL[parameter as usize].default) } else { value.factor }
    }

    /// [`constant`](Self::constant) of a parameter that is a number.
    pub fn number(&self, parameter: Parameter) -> f32 {
        self.constant(parameter).x
    }

    /// The parameters that a graph gives and the renderer has as constants alone.
    pub fn parameters_to_fold(&self) -> Vec<Parameter> {
        // a colour that glass has on the way through it is one colour
        let is_of_depth = self[Parameter::TransmissionDepth] != Value::ZERO;
        let of_depth = is_of_depth.then_some(Parameter::TransmissionColor);
        let constant = CONSTANT.into_iter().chain(of_depth);
        constant.filter(|parameter| self[*parameter].node.is_some()).collect()
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
        assert_eq!(CONSTANT.len() + 10, ALL.len(), "all but those that vary");
    }

    #[test]
    fn a_picture_leaves_the_factor() {
        let mut surface = Surface::matt("m", Vec3::ONE);
        surface.set_layer(1.5, 0.5, 0.0);
        surface.show(Parameter::SpecularRoughness, 3, Shown::Mean);
        let roughness = surface[Parameter::SpecularRoughness];
        assert!(roughness.factor == Vec3::splat(0.5) && roughness.given().is_some());
        assert_eq!(surface.parameters_to_fold(), [], "roughness may vary");
        surface.show(Parameter::CoatWeight, 3, Shown::Mean);
        assert_eq!(surface.parameters_to_fold(), [Parameter::CoatWeight]);
    }
}
