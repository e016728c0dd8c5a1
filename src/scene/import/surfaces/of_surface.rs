//! From [`Surface`] to what MTL's statements hold, and a graph of the base colour: all that materials have today.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::dielectric::{index_of, stated_index};
use super::varying::Graphs;
use crate::graph::{Function, Input, Places, Program};
use crate::lanes::Vec3x8;
use crate::scene::import::statements::Statements;
use crate::scene::import::statements::anisotropy::StatedAnisotropy;
use crate::scene::import::statements::coat::StatedCoat;
use crate::scene::import::statements::fuzz::StatedFuzz;
use crate::scene::import::statements::interior::StatedInterior;
use crate::scene::material::{Bump, ByParameter, Computes, LARGEST_COLOR, head_on};
use crate::scene::surface::{Parameter, Surface};

/// What is told of glass whose colour is computed.
const GLASS_OF_GRAPH: &str =
    "the base colour of glass is one colour: the default counts in place of its graph";

/// What is told of glass whose metalness is computed.
const GLASS_OF_METAL: &str = "a graph of the metalness of glass is not used: the default counts in its place";

/// What is told of glass with a coat.
const COAT_OF_GLASS: &str = "coats and fuzz of glass are not used: glass reflects by its index alone";

/// What is told of heights that depend on the angle at which they are seen.
const HEIGHTS_OF_EYE: &str =
    "heights that depend on the angle at which they are seen are what they are head-on";

/// Statements of a surface, its graphs, and what is left out of it.
pub(in crate::scene) struct OfSurface {
    pub stated: Statements,
    pub graphs: Graphs,
    pub bump: Option<Bump>,
    /// Picture of normals, with the factor on their slopes.
    pub normals: Option<(u32, f32)>,
    pub left_out: Vec<&'static str>,
}

impl OfSurface {
    pub fn new(mut surface: Surface) -> Self {
        let mut left_out = Vec::new();
        let mut layer = Layer::new(&surface, &mut left_out);
        let base = base(&mut surface);
        let mut color = node(base);
        if layer.through > 0.0 && color.take().is_some() {
            left_out.push(GLASS_OF_GRAPH);
        }
        let (emission, opacity) = (emission(&mut surface), surface[Parameter::GeometryOpacity]);
        layer.computed[Computes::Color] = color;
        layer.computed[Computes::Emission] = node(emission);
        layer.computed[Computes::Opacity] = node(opacity);
        let kd = match base {
            Input::Constant(value) => value.clamp(Vec3::ZERO, Vec3::ONE),
            Input::Node(_) if color.is_some() => Vec3::ONE,
            Input::Node(_) => surface.constant(Parameter::BaseColor),
        };
        let glow = match emission {
            Input::Constant(value) => value,
            Input::Node(_) => Vec3::ONE,
        };
        let opacity = share(&surface, Parameter::GeometryOpacity) as f32;
        let stated = Statements {
            name: surface.name.clone(),
            kd: Some(kd),
            ke: Some(glow.clamp(Vec3::ZERO, Vec3::splat(LARGEST_COLOR))),
            d: (opacity < 1.0).then_some(opacity),
            interior: interior(&surface),
            diffuse_roughness: Some(share(&surface, Parameter::BaseDiffuseRoughness) as f32),
            metal_edge: Some(metal_edge(&surface) as f32),
            anisotropy: StatedAnisotropy {
                amount: Some(share(&surface, Parameter::SpecularRoughnessAnisotropy) as f32),
                ..StatedAnisotropy::default()
            },
            fuzz: if layer.through > 0.0 { StatedFuzz::default() } else { fuzz(&surface) },
            ..Statements::default()
        };
        // a colour that light takes on its way is none of the surface
        let is_of_depth = stated.interior.depth.is_some();
        let tint = if is_of_depth { Vec3::ONE } else { surface.constant(Parameter::TransmissionColor) };
        let stated = layer.stated(stated, tint);
        let (bump, normals) = (bump(&surface), surface.normals);
        if bump.as_ref().is_some_and(|bump| bump.height.is_of_eye()) {
            left_out.push(HEIGHTS_OF_EYE);
        }
        Self { stated, graphs: Graphs::new(surface.graph, layer.computed), bump, normals, left_out }
    }
}

/// What reflects and transmits above the base.
struct Layer {
    /// Reflectance at normal incidence of what is no metal.
    head_on: f64,
    /// Index of refraction, by which glass bends.
    index: f64,
    roughness: f64,
    metallic: f64,
    /// Share of the light that goes through.
    through: f64,
    /// Clear coat above it.
    coat: StatedCoat,
    /// What is computed; roughness and metal are 1 then.
    computed: ByParameter<Input>,
}

impl Layer {
    fn new(surface: &Surface, left_out: &mut Vec<&'static str>) -> Self {
        let of_number = |parameter| share(surface, parameter);
        let index = f64::from(surface.number(Parameter::SpecularIor)).max(1.0);
        let tint = f64::from(surface.constant(Parameter::SpecularColor).element_sum().max(0.0)) / 3.0;
        let plain = Self {
            head_on: head_on(index) * of_number(Parameter::SpecularWeight) * tint,
            index: stated_index(index),
            roughness: of_number(Parameter::SpecularRoughness),
            metallic: of_number(Parameter::BaseMetalness),
            through: 0.0,
            coat: StatedCoat::default(),
            computed: ByParameter::default(),
        };
        let mut computed = ByParameter::default();
        computed[Computes::Roughness] = node(surface[Parameter::SpecularRoughness]);
        computed[Computes::Metalness] = node(surface[Parameter::BaseMetalness]);
        let through = of_number(Parameter::TransmissionWeight) * (1.0 - plain.metallic);
        if through > 0.0 {
            if computed[Computes::Metalness].take().is_some() {
                left_out.push(GLASS_OF_METAL);
            }
            if coat(surface).settle().is_some() || fuzz(surface).settle().is_some() {
                left_out.push(COAT_OF_GLASS);
            }
            return Self { through, computed, ..plain }.with_factors();
        }
        Self { computed, coat: coat(surface), ..plain }.with_factors()
    }

    /// The same, with factors of 1 for what varies.
    fn with_factors(self) -> Self {
        let or_one = |of, number| if self.computed[of].is_some() { 1.0 } else { number };
        let roughness = or_one(Computes::Roughness, self.roughness);
        Self { roughness, metallic: or_one(Computes::Metalness, self.metallic), ..self }
    }

    /// Statements with those about the layer. `tint`: colour of what goes through.
    fn stated(&self, stated: Statements, tint: Vec3) -> Statements {
        let is_coated = self.coat.settle().is_some();
        if self.head_on + self.metallic + self.through == 0.0 && !is_coated {
            // matt, without a layer
            return Statements { illum: Some(1), ..stated };
        }
        let layer = Statements {
            pr: Some(self.roughness as f32),
            pm: Some(self.metallic as f32),
            ni: Some(index_of(self.head_on) as f32),
            coat: self.coat,
            ..stated
        };
        if self.through == 0.0 {
            return layer;
        }
        let kd = layer.kd.unwrap_or(Vec3::ONE);
        let clear = Statements { kd: Some(Vec3::ONE), ..layer };
        let tint = tint.as_dvec3().clamp(DVec3::ZERO, DVec3::ONE);
        let glass = clear.with_transmission(self.through, tint);
        Statements { kd: glass.kd.map(|rest| rest * kd), ni: Some(self.index as f32), ..glass }
    }
}

/// How white metal is at grazing angles, where its specular colour tints what it reflects at 82 degrees (the specification's F82): so that it
/// is as bright there.
fn metal_edge(surface: &Surface) -> f64 {
    let mean =
        |parameter| f64::from(surface.constant(parameter).clamp(Vec3::ZERO, Vec3::ONE).element_sum()) / 3.0;
    let [head_on, tint] = [Parameter::BaseColor, Parameter::SpecularColor].map(mean);
    if tint == 1.0 || head_on > MOST_OF_METAL {
        return 1.0;
    }
    // Schlick's formula at a cosine of 1/7
    let white = (6.0_f64 / 7.0).powi(5);
    let tinted = tint * (head_on + (1.0 - head_on) * white);
    ((tinted - head_on) / ((1.0 - head_on) * white)).clamp(0.0, 1.0)
}

/// Reflectance at right angles above which a metal is as white as it gets.
const MOST_OF_METAL: f64 = 0.999;

/// The clear coat.
fn coat(surface: &Surface) -> StatedCoat {
    StatedCoat {
        weight: Some(share(surface, Parameter::CoatWeight) as f32),
        roughness: Some(share(surface, Parameter::CoatRoughness) as f32),
        index: Some(surface.number(Parameter::CoatIor)),
        tint: Some(surface.constant(Parameter::CoatColor)),
        darkening: Some(share(surface, Parameter::CoatDarkening) as f32),
    }
}

/// The fuzz.
fn fuzz(surface: &Surface) -> StatedFuzz {
    StatedFuzz {
        weight: Some(share(surface, Parameter::FuzzWeight) as f32),
        color: Some(surface.constant(Parameter::FuzzColor)),
        roughness: Some(share(surface, Parameter::FuzzRoughness) as f32),
    }
}

/// The inside of the surface. What scatters light below itself lets a half of it through where it is thin.
fn interior(surface: &Surface) -> StatedInterior {
    let below = share(surface, Parameter::SubsurfaceWeight) as f32;
    let radius =
        surface.constant(Parameter::SubsurfaceRadiusScale) * surface.number(Parameter::SubsurfaceRadius);
    let is_thin = surface.number(Parameter::GeometryThinWalled) > 0.5;
    let depth = surface.number(Parameter::TransmissionDepth);
    StatedInterior {
        subsurface: Some(if is_thin { 0.0 } else { below }),
        subsurface_radius: Some(radius.max(Vec3::ZERO)),
        translucency: is_thin.then_some(0.5 * below),
        depth: (depth > 0.0).then_some(depth),
        depth_color: Some(surface.constant(Parameter::TransmissionColor)),
        is_thin: Some(is_thin),
    }
}

/// A number from 0 to 1.
fn share(surface: &Surface, parameter: Parameter) -> f64 {
    f64::from(surface.number(parameter)).clamp(0.0, 1.0)
}

/// A value that is no constant.
fn node(value: Input) -> Option<Input> {
    Some(value).filter(|value| matches!(value, Input::Node(_)))
}

/// Heights that bend normals: even ones bend nothing.
fn bump(surface: &Surface) -> Option<Bump> {
    let heights = surface.heights?;
    let height = Arc::new(Program::new(&surface.graph, node(heights.height)?));
    Some(Bump { height, distance: heights.distance, strength: heights.strength.clamp(0.0, 1.0) })
}

/// The base colour, with its weight.
fn base(surface: &mut Surface) -> Input {
    let base = product(surface, [Parameter::BaseColor, Parameter::BaseWeight]);
    let below = share(surface, Parameter::SubsurfaceWeight) as f32;
    if below == 0.0 {
        return base;
    }
    // what goes below the surface has a colour of its own, and the renderer one of both
    let color = surface[Parameter::SubsurfaceColor];
    surface.graph.add(Arc::new(Mixed { share: below }), vec![base, color])
}

/// The radiance that it emits, linear RGB.
fn emission(surface: &mut Surface) -> Input {
    product(surface, [Parameter::EmissionColor, Parameter::EmissionLuminance])
}

/// Product of a colour and its weight.
fn product(surface: &mut Surface, [color, weight]: [Parameter; 2]) -> Input {
    let (color, weight) = (surface[color], surface[weight]);
    match weight {
        Input::Constant(Vec3::ONE) => color,
        Input::Constant(Vec3::ZERO) => Input::Constant(Vec3::ZERO),
        _ => surface.graph.add(Arc::new(Product), vec![color, weight]),
    }
}

/// Two values, mixed.
#[derive(Debug)]
struct Mixed {
    /// Share of the second.
    share: f32,
}

impl Function for Mixed {
    fn values(&self, inputs: &[Vec3x8], _: Places) -> Vec3x8 {
        inputs[0] * (1.0 - self.share) + inputs[1] * self.share
    }
}

/// Product of two values.
#[derive(Debug)]
struct Product;

impl Function for Product {
    fn values(&self, inputs: &[Vec3x8], _: Places) -> Vec3x8 {
        inputs[0] * inputs[1]
    }
}
