//! Parameters of materials that vary from place to place: by graphs, and by pictures, which are graphs of one node.

use std::sync::Arc;

use glam::Vec3;

use super::means;
use crate::graph::nodes::picture::{self, Shown};
use crate::graph::{Graph, Input, Program};
use crate::scene::material::{ByParameter, Computed, Computes, Optics};
use crate::scene::{Material, Texture};

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

    /// Mean of a factor over surfaces: see [`means`]; 1 if nothing gives it.
    pub fn mean(&self, of: Computes, textures: &[Texture]) -> f32 {
        self.inputs[of].map_or(1.0, |input| means::mean(&self.graph, input, textures).x)
    }

    /// Has channels of picture number `map` of the shot give a value.
    pub fn show(&mut self, of: Computes, map: u32, shown: Shown) {
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
        Computes::Metalness => match material.optics {
            Optics::Glass { .. } if !material.can_blend() => material.uneven_glass.is_some(),
            _ => material.metal_rough.is_some(),
        },
        Computes::Opacity => material.can_blend(),
        Computes::Highlight => shines,
        Computes::Emission => material.emission != Vec3::ZERO,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::material::MetalRough;

    /// What is computed of a parameter counts where the material has it, and nowhere else.
    #[test]
    fn graphs_give_what_a_material_has() {
        let layer = MetalRough { base: Vec3::ONE, roughness: 1.0, metallic: 1.0, head_on: 0.04, solid: 1.0 };
        let matt = Material::fallback();
        let metal = Material { metal_rough: Some(layer), ..Material::fallback() };
        let glossy = Material { specular: Vec3::ONE, ..Material::fallback() };
        let glowing = Material { emission: Vec3::ONE, ..Material::fallback() };
        let uses = [
            Computes::Roughness,
            Computes::Metalness,
            Computes::Highlight,
            Computes::Emission,
            Computes::Opacity,
        ];
        for (material, expected) in [
            (matt, [false, false, false, false, true]),
            (metal, [true, true, false, false, true]),
            (glossy, [true, false, true, false, true]),
            (glowing, [false, false, false, true, true]),
        ] {
            for (of, counts) in uses.into_iter().zip(expected) {
                let mut graphs = Graphs::default();
                graphs.show(of, 0, Shown::Mean);
                assert_eq!(graphs.computed(&material).is_some(), counts, "{of:?} of {material:?}");
            }
        }
    }

    /// All pictures of a material are one program.
    #[test]
    fn values_are_numbered_in_the_order_of_their_uses() {
        let mut graphs = Graphs::default();
        for (of, map) in [(Computes::Emission, 3), (Computes::Opacity, 1), (Computes::Highlight, 2)] {
            graphs.show(of, map, Shown::Color);
        }
        let material = Material { specular: Vec3::ONE, emission: Vec3::ONE, ..Material::fallback() };
        let Some(Computed { program, numbers, .. }) = graphs.computed(&material) else { panic!("nothing") };
        assert_eq!(program.len(), 3);
        let places = [Computes::Opacity, Computes::Highlight, Computes::Emission].map(|of| numbers[of]);
        assert_eq!((places, numbers[Computes::Color]), ([Some(0), Some(1), Some(2)], None));
        assert!(graphs.has(Computes::Emission) && !graphs.has(Computes::Color));
    }
}
