//! Transforms and masks of instances in a frame.

use embree::{ALL_TIMES, GeometryId, Scene as EmbreeScene};

use super::mask::{self, SeenBy};
use crate::animation::Transform;
use crate::exposure::{TICKS, Tick};
use crate::geometry::Bounds;
use crate::pose::Pose;
use crate::sweep::Way;
use crate::trace::TraceError;

/// Number of different times of rays, at most: multiples of a share of 1.
pub const TIMES: usize = TICKS;

/// Instance of a model that moves in some frame.
pub struct Instance {
    pub id: GeometryId,
    /// Number of the model.
    pub model: usize,
    /// Rays that see it.
    pub seen_by: SeenBy,
    /// Box around its mesh at rest, object space.
    pub bounds: Bounds,
}

/// Returns true if any two of the instances lie in each other in `pose`: see [`are_twins`].
pub fn has_twins(instances: &[Instance], pose: &Pose) -> bool {
    let visible = instances.iter().filter(|instance| pose.models[instance.model].is_visible);
    are_twins(visible.map(|instance| (instance.bounds, &pose.models[instance.model])))
}

/// Returns true if any two models with these boxes, object space, lie in each other, to the bit: copies that were forgotten in one place.
///
/// A tree above several meshes or instances is built by several threads, which put equal boxes into the order in which they come (Embree
/// 4.4, `kernels/bvh/bvh_builder_twolevel.cpp`); and where a ray meets both at the same t, that order decides. So it is not left to it.
pub fn are_twins<'a>(placed: impl Iterator<Item = (Bounds, &'a Transform)>) -> bool {
    // two that are taken for twins by chance are met more slowly, and nothing else
    let digest = |(Bounds { low, high }, place): (Bounds, &Transform)| {
        let corners = [low, high].map(|end| end.to_array());
        let numbers = place.columns();
        let all = numbers.iter().chain(corners.as_flattened());
        all.fold(0_u64, |digest, number| {
            (digest ^ u64::from(number.to_bits())).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
        })
    };
    let mut digests: Vec<u64> = placed.map(digest).collect();
    digests.sort_unstable();
    digests.windows(2).any(|pair| pair[0] == pair[1])
}

/// Times at which an exposure begins and is over. A group's rays have the time when it begins, and see what is there in its middle.
pub fn times_of_ends(groups: usize) -> [f32; 2] {
    let ahead = 0.5 / groups as f32;
    [-ahead, 1.0 - ahead]
}

/// Times of rays at each tick, if anything moves: those of Embree's keys where there is one for each group, so that an instance is exactly
/// where the key says.
pub fn times(pose: &Pose) -> Option<[f32; TICKS]> {
    let groups = pose.sweeps.groups() as f32;
    let time = |tick| pose.sweeps.group(tick as Tick) as f32 / groups;
    (!pose.sweeps.is_empty()).then(|| std::array::from_fn(time))
}

/// Sets the transforms of `instances` in `scene` to those of `pose`, and their masks.
pub fn set_places(
    scene: &mut EmbreeScene,
    instances: &[Instance],
    pose: &Pose,
    moved: &[bool],
) -> Result<(), TraceError> {
    for Instance { id, model, seen_by, .. } in instances {
        let transform = &pose.models[*model];
        let mask =
            if transform.is_visible { mask::of_instance(*seen_by, moved[*model]) } else { mask::HIDDEN };
        let (keys, times): (Vec<[f32; 12]>, _) = match pose.sweeps.way(*model) {
            Some(Way::Straight(ends)) => {
                let mut keys: Vec<[f32; 12]> = ends.iter().map(Transform::columns).collect();
                // what deforms may rest
                keys.dedup();
                (keys, times_of_ends(pose.sweeps.groups()))
            }
            Some(Way::Bent(places)) => {
                // of the last key nothing is seen: no ray is that late
                (places.iter().chain(places.last()).map(Transform::columns).collect(), ALL_TIMES)
            }
            None => (vec![transform.columns()], ALL_TIMES),
        };
        scene.set_instance_transforms(*id, &keys, times)?;
        scene.set_mask(*id, mask)?;
    }
    Ok(())
}
