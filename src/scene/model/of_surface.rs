//! From [`Surface`] to what MTL's statements hold, and a graph of the base colour: all that materials have today.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::dielectric::{Below, Coat, index_of, stated_index};
use super::mtl::MtlMaterial;
use crate::graph::{Function, Input, Place, Program};
use crate::scene::material::{Bump, LARGEST_COLOR, head_on};
use crate::scene::surface::{Parameter, Surface};

/// What is told of glass whose colour is computed.
const GLASS_OF_GRAPH: &str =
    "the base colour of glass is one colour: the default counts in place of its graph";

/// Statements of a surface, the graph of its base colour if it has one, and what is left out of it.
pub(super) struct OfSurface {
    pub stated: MtlMaterial,
    pub color: Option<Arc<Program>>,
    pub bump: Option<Bump>,
    /// Picture of normals, with the factor on their slopes.
    pub normals: Option<(u32, f32)>,
    pub left_out: Vec<&'static str>,
}

impl OfSurface {
    pub fn new(surface: &mut Surface) -> Self {
        // even heights bend nothing
        let bump = surface.heights.filter(|heights| matches!(heights.height, Input::Node(_)));
        let bump = bump.map(|heights| Bump {
            height: Arc::new(Program::new(&surface.graph, heights.height)),
            distance: heights.distance,
            strength: heights.strength.clamp(0.0, 1.0),
        });
        let number = |parameter| f64::from(surface.number(parameter)).clamp(0.0, 1.0);
        let [metallic, roughness] = [Parameter::BaseMetalness, Parameter::SpecularRoughness].map(number);
        let through = number(Parameter::TransmissionWeight) * (1.0 - metallic);
        let mut left_out = Vec::new();
        let mut index = head_on(f64::from(surface.number(Parameter::SpecularIor)).max(1.0));
        index *= number(Parameter::SpecularWeight)
            * f64::from(surface.constant(Parameter::SpecularColor).element_sum().max(0.0))
            / 3.0;
        let below = Below { head_on: index, metallic };
        let coat = Coat { share: number(Parameter::CoatWeight), roughness: number(Parameter::CoatRoughness) };
        let coated = if through > 0.0 { None } else { coat.over(below, |said| left_out.push(said)) };
        let opacity = number(Parameter::GeometryOpacity);
        let glow = surface.constant(Parameter::EmissionColor) * surface.number(Parameter::EmissionLuminance);
        let base = base(surface);
        let mut color = match base {
            Input::Constant(_) => None,
            Input::Node(_) => Some(Arc::new(Program::new(&surface.graph, base))),
        };
        if through > 0.0 && color.take().is_some() {
            left_out.push(GLASS_OF_GRAPH);
        }
        let kd = match base {
            Input::Constant(value) => value,
            Input::Node(_) if color.is_some() => Vec3::ONE,
            Input::Node(_) => surface.constant(Parameter::BaseColor),
        };
        let reflected = coated.map_or(index, |layer| layer.head_on);
        let glow = glow.clamp(Vec3::ZERO, Vec3::splat(LARGEST_COLOR));
        let kd = kd.clamp(Vec3::ZERO, Vec3::ONE);
        let d = (opacity < 1.0).then_some(opacity as f32);
        if reflected + metallic + through == 0.0 {
            // matt, without a layer
            let (kd, ke, illum, name) = (Some(kd), Some(glow), Some(1), surface.name.clone());
            return Self {
                stated: MtlMaterial { name, kd, ke, d, illum, ..MtlMaterial::default() },
                color,
                bump,
                normals: surface.normals,
                left_out,
            };
        }
        let stated = MtlMaterial {
            name: surface.name.clone(),
            kd: Some(kd),
            ke: Some(glow),
            pr: Some(coated.and_then(|layer| layer.coat_roughness).unwrap_or(roughness) as f32),
            pm: Some(metallic as f32),
            ni: Some(index_of(reflected) as f32),
            d,
            ..MtlMaterial::default()
        };
        let stated = if through > 0.0 {
            let tint = surface.constant(Parameter::TransmissionColor).as_dvec3();
            let ior = stated_index(f64::from(surface.number(Parameter::SpecularIor)));
            let clear = MtlMaterial { kd: Some(Vec3::ONE), ..stated };
            let glass = clear.with_transmission(through, tint.clamp(DVec3::ZERO, DVec3::ONE));
            MtlMaterial { kd: glass.kd.map(|rest| rest * kd), ni: Some(ior as f32), ..glass }
        } else {
            stated
        };
        Self { stated, color, bump, normals: surface.normals, left_out }
    }
}

/// The base colour, with its weight.
fn base(surface: &mut Surface) -> Input {
    let (color, weight) = (surface[Parameter::BaseColor], surface[Parameter::BaseWeight]);
    if weight == Input::Constant(Vec3::ONE) {
        return color;
    }
    surface.graph.add(Arc::new(Product), vec![color, weight])
}

/// Product of two values.
#[derive(Debug)]
struct Product;

impl Function for Product {
    fn value(&self, inputs: &[Vec3], _: &dyn Place) -> Vec3 {
        inputs[0] * inputs[1]
    }
}
