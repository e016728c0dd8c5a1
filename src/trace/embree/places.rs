//! Transforms and masks of instances in a frame.

use embree::{GeometryId, Scene as EmbreeScene};

use super::mask;
use crate::pose::Pose;
use crate::scene::RayKinds;
use crate::trace::TraceError;

/// Instance of a model that moves in some frame.
pub struct Instance {
    pub id: GeometryId,
    /// Number of the model.
    pub model: usize,
    /// Rays that see it.
    pub seen_by: RayKinds,
}

/// Sets the transforms of `instances` in `scene` to those of `pose`, and their masks.
pub fn set_places(
    scene: &mut EmbreeScene,
    instances: &[Instance],
    pose: &Pose,
    moved: &[bool],
) -> Result<(), TraceError> {
    for Instance { id, model, seen_by } in instances {
        let transform = &pose.models[*model];
        let mask =
            if transform.is_visible { mask::of_instance(*seen_by, moved[*model]) } else { mask::HIDDEN };
        scene.set_instance_transform(*id, transform.columns())?;
        scene.set_mask(*id, mask)?;
    }
    Ok(())
}
