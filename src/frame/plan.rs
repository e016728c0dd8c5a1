//! What a frame may skip: the paper's rules, decided once from two poses, before any ray is traced.
//!
//! The rows of [`Plan::sight_check`] and [`Plan::shadow_check`] are the paper's "Verification Phase",
//! read from top to bottom. Where the paper tests a sample against *the* object that shadowed it, we test
//! against the half of the scene (still or movable) that it is in: the tag is one byte, and the answer is
//! the same.

use crate::pose::{CameraPose, LightPose, Pose};
use crate::samples::{Flags, Tag};

/// How the camera differs from that of the frame before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraChange {
    /// Not at all: nothing has to be projected.
    None,
    /// It stands where it stood, and turned or zoomed.
    SamePlace,
    /// It moved.
    Moved,
}

/// How a light differs from that of the frame before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightChange {
    /// Not at all.
    None,
    /// Only in colour or power: visibility is kept, light is computed anew.
    Strength,
    /// In place, direction or cone.
    Moved,
}

/// What a segment from the eye to a sample is tested against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SightCheck {
    /// The sample is visible, as it was.
    Nothing,
    /// Models that moved, at their new place.
    Moved,
    /// All of the scene.
    Everything,
}

/// What a sample's shadow ray is tested against, in this order; the first that blocks ends it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShadowCheck {
    /// Nothing: the tag holds.
    Keep,
    /// Models that moved, at their new place.
    Moved,
    /// All that never moves, then the rest.
    StillThenMovable,
    /// All that may move, then the rest: for samples that a movable model shadowed.
    MovableThenStill,
}

/// What changed since the frame before.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The eye.
    pub camera: CameraChange,
    /// For each model, whether it is elsewhere now.
    pub moved: Vec<bool>,
    /// Whether any model is.
    pub any_moved: bool,
    /// For each light.
    pub lights: Vec<LightChange>,
}

impl Plan {
    /// Compares the poses of two frames, exactly.
    pub fn between(before: &Pose, now: &Pose) -> Self {
        let moved: Vec<bool> = before.models.iter().zip(&now.models).map(|(old, new)| old != new).collect();
        Self {
            camera: camera_change(&before.camera, &now.camera),
            any_moved: moved.contains(&true),
            moved,
            lights: before.lights.iter().zip(&now.lights).map(|(old, new)| light_change(old, new)).collect(),
        }
    }

    /// For a frame that has none before it: nothing is known to have stayed.
    pub fn of_base_frame(pose: &Pose) -> Self {
        Self {
            camera: CameraChange::Moved,
            moved: vec![true; pose.models.len()],
            any_moved: !pose.models.is_empty(),
            lights: vec![LightChange::Moved; pose.lights.len()],
        }
    }

    /// What must be asked before a sample counts as visible. `moved`: its model did.
    pub fn sight_check(&self, moved: bool) -> SightCheck {
        match (self.camera, moved) {
            (CameraChange::Moved, _) | (_, true) => SightCheck::Everything,
            (_, false) if self.any_moved => SightCheck::Moved,
            (_, false) => SightCheck::Nothing,
        }
    }

    /// What must be asked before a sample's `tag` for `light` can be trusted. `moved`: its model did.
    pub fn shadow_check(&self, light: usize, moved: bool, tag: Tag) -> ShadowCheck {
        let light_moved = self.lights[light] == LightChange::Moved;
        match tag {
            Tag::BackFacing | Tag::StaticOccluder if !moved && !light_moved => ShadowCheck::Keep,
            Tag::Lit | Tag::DynamicOccluder if !moved && !light_moved && !self.any_moved => ShadowCheck::Keep,
            Tag::Lit if !moved && !light_moved => ShadowCheck::Moved,
            Tag::DynamicOccluder => ShadowCheck::MovableThenStill,
            _ => ShadowCheck::StillThenMovable,
        }
    }

    /// What is not known any more of a sample that nobody looks at in this frame. `moved`: its model did.
    pub fn doubts(&self, moved: bool) -> Flags {
        let unseen = Flags::UNSEEN.when(self.sight_check(moved) != SightCheck::Nothing);
        unseen.with(Flags::STALE.when(self.light_changes(moved)))
    }

    /// Whether a `tag` for `light` holds without a question. `moved`: the sample's model did.
    pub fn keeps_tag(&self, light: usize, moved: bool, tag: Tag) -> bool {
        self.shadow_check(light, moved, tag) == ShadowCheck::Keep
    }

    /// Whether all tags for `light` do.
    pub fn keeps_all_tags(&self, light: usize) -> bool {
        !self.any_moved && self.lights[light] != LightChange::Moved
    }

    /// Whether any light changed, in place or strength.
    pub fn any_light_changed(&self) -> bool {
        self.lights.iter().any(|light| *light != LightChange::None)
    }

    /// Whether the light on a sample must be summed anew even if all of its tags hold.
    pub fn light_changes(&self, moved: bool) -> bool {
        moved || self.any_light_changed()
    }
}

fn camera_change(before: &CameraPose, now: &CameraPose) -> CameraChange {
    if before == now {
        CameraChange::None
    } else if before.eye == now.eye && (!now.is_orthographic() || before.forward == now.forward) {
        CameraChange::SamePlace
    } else {
        CameraChange::Moved
    }
}

fn light_change(before: &LightPose, now: &LightPose) -> LightChange {
    if before == now {
        LightChange::None
    } else if before.shape == now.shape {
        LightChange::Strength
    } else {
        LightChange::Moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::animation::{Transform, TransformTrack};
    use crate::frame::view::tests::camera;
    use crate::pose::LightShape;
    use glam::Vec3;

    fn pose() -> Pose {
        let lamp = |x| LightPose {
            shape: LightShape::Point { position: Vec3::new(x, 0.0, 0.0) },
            strength: Vec3::ONE,
            points: 1,
        };
        Pose {
            frame: 1,
            camera: camera(Vec3::ZERO),
            models: vec![Transform::IDENTITY; 2],
            lights: vec![lamp(0.0), lamp(5.0)],
        }
    }

    fn moved_model() -> Pose {
        let mut pose = pose();
        let track = TransformTrack {
            translate: crate::animation::Track::constant(glam::DVec3::X),
            ..TransformTrack::identity()
        };
        pose.models[1] = track.at(0.0);
        pose
    }

    fn change(edit: impl FnOnce(&mut Pose)) -> Plan {
        let mut now = pose();
        edit(&mut now);
        Plan::between(&pose(), &now)
    }

    // One test a row of the first table.

    #[test]
    fn a_static_camera_and_a_still_world_need_nothing() {
        let plan = change(|_| ());
        assert_eq!(plan.sight_check(false), SightCheck::Nothing);
    }

    #[test]
    fn a_turned_or_zoomed_camera_hides_nothing_that_is_still() {
        let turned = change(|now| (now.camera.right, now.camera.forward) = (Vec3::Z, Vec3::X));
        let zoomed = change(|now| now.camera.half_height = 0.5);
        for plan in [turned, zoomed] {
            assert_eq!(plan.camera, CameraChange::SamePlace);
            assert_eq!(plan.sight_check(false), SightCheck::Nothing);
        }
    }

    #[test]
    fn from_the_same_place_only_what_moved_can_hide_a_still_sample() {
        let plan = Plan::between(&pose(), &moved_model());
        assert_eq!((plan.camera, plan.moved.as_slice()), (CameraChange::None, &[false, true][..]));
        assert_eq!(plan.sight_check(false), SightCheck::Moved);
    }

    #[test]
    fn from_the_same_place_everything_can_hide_a_moved_sample() {
        let plan = Plan::between(&pose(), &moved_model());
        assert_eq!(plan.sight_check(true), SightCheck::Everything);
    }

    #[test]
    fn from_a_new_place_everything_can_hide_any_sample() {
        let plan = change(|now| now.camera.eye = Vec3::X);
        assert_eq!(plan.sight_check(false), SightCheck::Everything);
        assert_eq!(plan.sight_check(true), SightCheck::Everything);
    }

    // One test a row of the second table.

    #[test]
    fn a_still_sample_in_the_shadow_of_itself_or_of_a_still_model_stays_there() {
        let plan = Plan::between(&pose(), &moved_model());
        assert_eq!(plan.shadow_check(0, false, Tag::BackFacing), ShadowCheck::Keep);
        assert_eq!(plan.shadow_check(0, false, Tag::StaticOccluder), ShadowCheck::Keep);
    }

    #[test]
    fn a_still_lit_sample_is_tested_against_what_moved() {
        let plan = Plan::between(&pose(), &moved_model());
        assert_eq!(plan.shadow_check(0, false, Tag::Lit), ShadowCheck::Moved);
        assert_eq!(change(|_| ()).shadow_check(0, false, Tag::Lit), ShadowCheck::Keep);
    }

    #[test]
    fn a_still_sample_shadowed_by_a_movable_model_asks_there_first() {
        let plan = Plan::between(&pose(), &moved_model());
        assert_eq!(plan.shadow_check(0, false, Tag::DynamicOccluder), ShadowCheck::MovableThenStill);
        assert_eq!(change(|_| ()).shadow_check(0, false, Tag::DynamicOccluder), ShadowCheck::Keep);
    }

    #[test]
    fn a_moved_shadowed_sample_asks_its_occluder_first() {
        let plan = Plan::between(&pose(), &moved_model());
        assert_eq!(plan.shadow_check(0, true, Tag::DynamicOccluder), ShadowCheck::MovableThenStill);
        assert_eq!(plan.shadow_check(0, true, Tag::StaticOccluder), ShadowCheck::StillThenMovable);
        assert_eq!(plan.shadow_check(0, true, Tag::BackFacing), ShadowCheck::StillThenMovable);
    }

    #[test]
    fn a_moved_lit_sample_asks_everything() {
        let plan = Plan::between(&pose(), &moved_model());
        assert_eq!(plan.shadow_check(0, true, Tag::Lit), ShadowCheck::StillThenMovable);
    }

    #[test]
    fn under_a_moved_light_every_sample_asks_its_occluder_first() {
        let plan = change(|now| now.lights[1].shape = LightShape::Point { position: Vec3::Y });
        assert_eq!(plan.lights, [LightChange::None, LightChange::Moved]);
        for moved in [false, true] {
            for tag in [Tag::BackFacing, Tag::Lit, Tag::StaticOccluder, Tag::Unknown] {
                assert_eq!(plan.shadow_check(1, moved, tag), ShadowCheck::StillThenMovable);
            }
            assert_eq!(plan.shadow_check(1, moved, Tag::DynamicOccluder), ShadowCheck::MovableThenStill);
        }
        assert_eq!(plan.shadow_check(0, false, Tag::Lit), ShadowCheck::Keep, "the other light stands still");
    }

    #[test]
    fn a_recoloured_light_keeps_its_shadows_and_is_summed_anew() {
        let plan = change(|now| now.lights[0].strength = Vec3::X);
        assert_eq!(plan.lights, [LightChange::Strength, LightChange::None]);
        for tag in [Tag::BackFacing, Tag::Lit, Tag::StaticOccluder, Tag::DynamicOccluder] {
            assert_eq!(plan.shadow_check(0, false, tag), ShadowCheck::Keep);
        }
        assert!(plan.light_changes(false));
        assert!(!change(|_| ()).light_changes(false) && change(|_| ()).light_changes(true));
    }

    #[test]
    fn a_fresh_sample_asks_everything_whatever_stood_still() {
        assert_eq!(change(|_| ()).shadow_check(0, false, Tag::Unknown), ShadowCheck::StillThenMovable);
    }
}
