//! Direct light on surfaces, whether the eye sees them or a ray that has bounced: all of it is summed here.

use crate::lanes::{Mask, Vec3x8};
use crate::pose::LightPose;
use crate::shade::light::{LightSample, StratifiedPattern, light_sample};

/// Where eight surfaces are.
#[derive(Debug, Clone, Copy)]
pub struct Places {
    /// World space.
    pub point: Vec3x8,
    /// What decides at which points of an area light they pattern: see [`StratifiedPattern::at`].
    pub pattern: Vec3x8,
}

/// `sum`, and what `shade` makes of the light from those points of `light` that reach the surfaces. The points are added
/// in their order, so that the sum is always the same to the bit. `reached`: by number of the point, which surfaces it
/// reaches.
#[inline(always)]
pub fn add_light(
    sum: Vec3x8,
    light: &LightPose,
    places: Places,
    reached: impl Fn(usize) -> Mask,
    shade: impl Fn(&LightSample) -> Vec3x8,
) -> Vec3x8 {
    let pattern = StratifiedPattern::at(light, places.pattern);
    (0..light.shape.points()).fold(sum, |sum, point| {
        let reached = reached(point);
        if !reached.any() {
            return sum;
        }
        let light_sample = light_sample(light, point, &pattern, places.point);
        sum + reached.select3(shade(&light_sample), Vec3x8::ZERO)
    })
}
