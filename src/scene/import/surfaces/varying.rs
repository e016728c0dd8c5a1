//! Parameters of materials that vary from place to place: by graphs, and by pictures, which are graphs of one node.

use std::sync::Arc;

use glam::Vec3;

use crate::graph::nodes::picture::{self, Shown};
use crate::graph::{Graph, Input, Program};
use crate::scene::Material;
use crate::scene::import::pictures::PictureUse;
use crate::scene::import::statements::maps::{Channel, MapUse};
use crate::scene::material::{ByParameter, Computed, Computes};

/// A material, and what gives its parameters from place to place.
pub(in crate::scene) struct Settled {
    pub material: Material,
    pub graphs: Graphs,
}

impl From<Material> for Settled {
    fn from(material: Material) -> Self {
        Self { material, graphs: Graphs::default() }
    }
}

/// Nodes that give values of a surface.
#[derive(Debug, Clone, Default)]
pub(in crate::scene) struct Graphs {
    graph: Graph,
    inputs: ByParameter<Input>,
}

impl Graphs {
    /// Creates values of `graph`: those of `inputs`.
    pub fn new(graph: Graph, inputs: ByParameter<Input>) -> Self {
        Self { graph, inputs }
    }

    /// Returns true if something gives this value.
    pub fn has(&self, of: Computes) -> bool {
        self.inputs[of].is_some()
    }

    /// Has a number count instead of what gives this value.
    pub fn remove(&mut self, of: Computes) {
        self.inputs[of] = None;
    }

    /// Has a channel of picture number `map` of the shot give the value that pictures of this use give.
    pub fn show(&mut self, used: MapUse, map: u32, channel: Channel) {
        let Some(of) = computed_by(used) else { return };
        let shown = match (of, channel) {
            (Computes::Highlight | Computes::Emission, _) => Shown::Color,
            (_, Channel::Mean) => Shown::Mean,
            (_, Channel::Red) => Shown::Channel(0),
            (_, Channel::Green) => Shown::Channel(1),
            (_, Channel::Blue) => Shown::Channel(2),
            (_, Channel::Alpha) => Shown::Alpha,
        };
        self.inputs[of] = Some(picture::add(&mut self.graph, map, shown, None));
    }

    /// What is computed of `material`: of those values that it has.
    pub fn computed(&self, material: &Material) -> Option<Computed> {
        let mut values = Vec::new();
        let mut numbers = ByParameter::default();
        for of in Computes::ALL {
            if let Some(input) = self.inputs[of].filter(|_| has_value(material, of)) {
                numbers[of] = Some(values.len());
                values.push(input);
            }
        }
        let opacity = self.inputs[Computes::Opacity].filter(|_| numbers[Computes::Opacity].is_some());
        (!values.is_empty()).then(|| Computed {
            program: Program::of_all(&self.graph, &values),
            numbers,
            opacity: opacity.map(|opacity| Arc::new(Program::new(&self.graph, opacity))),
        })
    }
}

/// Returns true if `material` has the parameter that this value is a factor of.
fn has_value(material: &Material, of: Computes) -> bool {
    let shines = material.specular != Vec3::ZERO;
    match of {
        Computes::Color => true,
        Computes::Roughness => material.metal_rough.is_some() || shines,
        Computes::Metalness => material.metal_rough.is_some() && !material.is_rough_glass(),
        Computes::Opacity => material.can_blend(),
        Computes::Highlight => shines,
        Computes::Emission => material.emission != Vec3::ZERO,
    }
}

/// Uses of pictures that give parameters of a material.
pub(crate) const PARAMETERS: [MapUse; 5] =
    [MapUse::Roughness, MapUse::Metal, MapUse::Shininess, MapUse::Emission, MapUse::Specular];

/// The value that pictures of a use give, if they give one.
pub(in crate::scene) fn computed_by(used: MapUse) -> Option<Computes> {
    Some(match used {
        MapUse::Color => Computes::Color,
        MapUse::Roughness | MapUse::Shininess => Computes::Roughness,
        MapUse::Metal => Computes::Metalness,
        MapUse::Opacity => Computes::Opacity,
        MapUse::Specular => Computes::Highlight,
        MapUse::Emission => Computes::Emission,
        MapUse::Normal | MapUse::Bump => return None,
    })
}

/// Returns true if `material` has the parameter that pictures of this use give.
pub(crate) fn is_of_use(material: &Material, used: MapUse) -> bool {
    match used {
        MapUse::Roughness => material.metal_rough.is_some(),
        MapUse::Emission => true,
        MapUse::Shininess => material.specular != Vec3::ZERO,
        _ => computed_by(used).is_none_or(|of| has_value(material, of)),
    }
}

/// Use of a picture that gives a parameter.
pub(crate) fn picture_use(used: MapUse) -> PictureUse {
    match used {
        MapUse::Specular => PictureUse::ColorParameter,
        MapUse::Emission => PictureUse::Light,
        _ => PictureUse::Parameter,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::material::MetalRough;

    /// A picture of a parameter counts where the material has it, and nowhere else.
    #[test]
    fn pictures_give_what_a_material_has() {
        let layer = MetalRough { base: Vec3::ONE, roughness: 1.0, metallic: 1.0, head_on: 0.04, solid: 1.0 };
        let matt = Material::fallback();
        let metal = Material { metal_rough: Some(layer), ..Material::fallback() };
        let glossy = Material { specular: Vec3::ONE, ..Material::fallback() };
        let glowing = Material { emission: Vec3::ONE, ..Material::fallback() };
        let uses = [MapUse::Roughness, MapUse::Metal, MapUse::Specular, MapUse::Emission, MapUse::Opacity];
        for (material, expected) in [
            (matt, [false, false, false, false, true]),
            (metal, [true, true, false, false, true]),
            (glossy, [true, false, true, false, true]),
            (glowing, [false, false, false, true, true]),
        ] {
            for (used, counts) in uses.into_iter().zip(expected) {
                let mut graphs = Graphs::default();
                graphs.show(used, 0, Channel::Mean);
                assert_eq!(graphs.computed(&material).is_some(), counts, "{used:?} of {material:?}");
            }
        }
    }

    /// All pictures of a material are one program.
    #[test]
    fn values_are_numbered_in_the_order_of_their_uses() {
        let mut graphs = Graphs::default();
        for (used, map) in [(MapUse::Emission, 3), (MapUse::Opacity, 1), (MapUse::Specular, 2)] {
            graphs.show(used, map, Channel::Alpha);
        }
        let material = Material { specular: Vec3::ONE, emission: Vec3::ONE, ..Material::fallback() };
        let Some(Computed { program, numbers, .. }) = graphs.computed(&material) else { panic!("nothing") };
        assert_eq!(program.len(), 3);
        let places = [Computes::Opacity, Computes::Highlight, Computes::Emission].map(|of| numbers[of]);
        assert_eq!((places, numbers[Computes::Color]), ([Some(0), Some(1), Some(2)], None));
        graphs.remove(Computes::Opacity);
        assert!(graphs.has(Computes::Emission) && !graphs.has(Computes::Opacity));
    }
}
