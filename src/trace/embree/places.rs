//! Transforms and masks of instances in a frame.

use embree::{GeometryId, Scene as EmbreeScene};

use super::mask;
use crate::pose::Pose;
use crate::trace::TraceError;

/// Sets the transforms of `instances` in `scene` (models with their instances) to those of `pose`, and their
/// masks.
pub fn set_places(
    scene: &mut EmbreeScene,
    instances: &[(usize, GeometryId)],
    pose: &Pose,
    moved: &[bool],
) -> Result<(), TraceError> {
    for (model, id) in instances {
        let transform = &pose.models[*model];
        let mask = match (transform.is_visible, moved[*model]) {
            (false, _) => mask::HIDDEN,
            (true, true) => mask::MOVED,
            (true, false) => mask::RESTS,
        };
        scene.set_instance_transform(*id, transform.columns())?;
        scene.set_mask(*id, mask)?;
    }
    Ok(())
}
