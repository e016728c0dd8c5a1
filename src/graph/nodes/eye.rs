//! Nodes that depend on the angle at which a surface is seen. What they give holds as long as neither the eye nor the surface moves.

use std::sync::Arc;

use glam::Vec3;

use crate::graph::functions::fresnel;
use crate::graph::{Definition, Function, Kind, Options, Places, Socket};
use crate::lanes::Vec3x8;

/// How far a normal leans towards the eye: 0 not at all, 1 all the way. Groups for Blender mix both, for what is rough.
const TOWARD: Socket = Socket::number("toward", 0.0);

/// Share of the light that a dielectric reflects, as Blender's Fresnel node has it.
pub static FRESNEL: Definition = Definition {
    name: "blender_fresnel",
    inputs: &[Socket::number("ior", 1.5), TOWARD],
    outputs: &[("out", Kind::Number)],
    function: |_, _| Ok(Arc::new(Weight::Fresnel)),
};

/// Weights of layers, as Blender's Layer Weight node has them.
pub static LAYER_WEIGHT: Definition = Definition {
    name: "blender_layer_weight",
    inputs: &[Socket::number("blend", 0.5), TOWARD],
    outputs: &[("fresnel", Kind::Number), ("facing", Kind::Number)],
    function: |_, output| Ok(Arc::new(if output == 0 { Weight::LayerFresnel } else { Weight::LayerFacing })),
};

/// Cosine of the angle, as MaterialX has it; options `faceforward`: of a back as of a front, and `invert`: 1 less it.
pub static FACING_RATIO: Definition = Definition {
    name: "facingratio",
    inputs: &[],
    outputs: &[("out", Kind::Number)],
    function: facing_ratio,
};

fn facing_ratio(options: &Options, _: usize) -> Result<Arc<dyn Function>, String> {
    let (forward, inverted) = (options.flag("faceforward", true)?, options.flag("invert", false)?);
    Ok(Arc::new(Weight::Ratio { forward, inverted }))
}

/// A number that follows from the angle.
#[derive(Debug)]
enum Weight {
    Fresnel,
    LayerFresnel,
    LayerFacing,
    Ratio { forward: bool, inverted: bool },
}

impl Weight {
    /// `facing`: see [`Place::facing`](crate::graph::Place::facing).
    fn of(&self, input: f32, facing: f32) -> f32 {
        let is_inside = facing < 0.0;
        match self {
            Self::Fresnel => fresnel::fresnel(facing, input, is_inside),
            Self::LayerFresnel => fresnel::layer_fresnel(facing, input, is_inside),
            Self::LayerFacing => fresnel::layer_facing(facing, input),
            Self::Ratio { forward, inverted } => {
                let ratio = if *forward { facing.abs() } else { facing };
                if *inverted { 1.0 - ratio } else { ratio }
            }
        }
    }
}

/// Cosine of the angle to a normal that leans towards the eye.
fn leaning(facing: f32, toward: f32) -> f32 {
    let share = toward.clamp(0.0, 1.0);
    let leaning = facing.abs() * (1.0 - share) + share;
    if facing < 0.0 { -leaning } else { leaning }
}

impl Function for Weight {
    fn is_of_place(&self) -> bool {
        true
    }

    fn is_of_eye(&self) -> bool {
        true
    }

    fn values(&self, inputs: &[Vec3x8], places: Places) -> Vec3x8 {
        places.lane_by_lane(inputs, |inputs, place| {
            let [input, toward] = [0, 1].map(|number| inputs.get(number).map_or(0.0, |input| input.x));
            Vec3::splat(self.of(input, leaning(place.facing(), toward)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Head-on a layer reflects what its index says, on edge everything; a ratio is the cosine, on both sides or on the front's alone.
    #[test]
    fn weights_follow_the_angle() {
        assert!((Weight::Fresnel.of(1.5, 1.0) - 0.04).abs() < 1e-6);
        assert!((Weight::Fresnel.of(1.5, 1e-6) - 1.0).abs() < 1e-3);
        // out of glass at 60 degrees all light stays inside
        assert_eq!(Weight::Fresnel.of(1.5, -0.5), 1.0);
        assert!((Weight::LayerFacing.of(0.5, 0.3) - 0.7).abs() < 1e-6);
        assert_eq!([leaning(0.2, 0.0), leaning(-0.2, 1.0), leaning(0.5, 0.5)], [0.2, -1.0, 0.75]);
        let ratio = |forward, inverted| Weight::Ratio { forward, inverted }.of(0.0, -0.25);
        assert_eq!([ratio(true, false), ratio(false, false), ratio(true, true)], [0.25, -0.25, 0.75]);
    }
}
