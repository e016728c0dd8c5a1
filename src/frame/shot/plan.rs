//! Work that a frame may skip: the paper's rules, decided once from two poses, before any ray is traced.
//!
//! The rows of [`Plan::sight_check`] and [`Plan::shadow_check`] are the paper's "Verification Phase", read
//! from top to bottom. Where the paper tests a sample against *the* object that shadowed it, we test against
//! the half of the scene (still or movable) that the object is in: so the tag is one byte, and the answer is
//! the same.

use crate::exposure::{TICKS, Tick};
use crate::media::MediaOfShot;
use crate::pose::{CameraPose, Clip, Pose};
use crate::samples::{Flags, Tag};

/// Change of the camera since the frame before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraChange {
    /// None: nothing has to be projected.
    None,
    /// The camera turned or zoomed, at the same place.
    SamePlace,
    /// The camera moved.
    Moved,
}

/// Change of a light since the frame before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightChange {
    /// None.
    None,
    /// Colour or power alone: visibility is kept, light is computed anew.
    Strength,
    /// Place, direction or cone.
    Moved,
}

/// Models that a segment from the eye to a sample is tested against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SightCheck {
    /// None: the sample is visible, as it was.
    Nothing,
    /// Models that moved, at their new place.
    Moved,
    /// All of the scene.
    Everything,
}

/// Models that a sample's shadow ray is tested against, in this order; the first that blocks it ends the
/// test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShadowCheck {
    /// None: the tag holds.
    Keep,
    /// Models that moved, at their new place.
    Moved,
    /// Models that never move, then the others.
    StillThenMovable,
    /// Models that may move, then the others: for samples that a movable model shadowed.
    MovableThenStill,
}

/// A part of a sample's colour (the paper's "Color Calculation").
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Term {
    /// Reflection of the light that reaches everything. As far as occlusion dims it, see
    /// [`Until`](crate::changes::Until).
    Ambient,
    /// Light of a light source, scattered evenly.
    Diffuse,
    /// Light of a light source, as the eye sees it reflected.
    Specular,
}

/// Changes since the frame before.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Change of the camera.
    pub camera: CameraChange,
    /// True for each model that moved.
    pub moved: Vec<bool>,
    /// True if any model moved.
    pub any_moved: bool,
    /// Change of each light.
    pub lights: Vec<LightChange>,
}

impl Plan {
    /// Compares the poses of two frames, exactly.
    pub fn between(before: &Pose, now: &Pose) -> Self {
        let places = before.models.iter().zip(&now.models).enumerate();
        let moved: Vec<bool> = places
            .map(|(model, (old, new))| old != new || before.sweeps.of(model) != now.sweeps.of(model))
            .collect();
        Self {
            camera: camera_change(before, now),
            any_moved: moved.contains(&true),
            moved,
            lights: (0..now.lights.len()).map(|light| light_change(before, now, light)).collect(),
        }
    }

    /// Counts media that moved as a change of all lights: they fade other light than before on its way.
    #[must_use]
    pub fn with_media(self, media: &MediaOfShot) -> Self {
        let any_moved = (0..).zip(&self.moved).any(|(model, moved)| *moved && media.fills(model));
        let fades = |light: LightChange| match light {
            LightChange::None if any_moved => LightChange::Strength,
            other => other,
        };
        Self { lights: self.lights.into_iter().map(fades).collect(), ..self }
    }

    /// Creates the plan of a frame that has none before it: everything counts as changed.
    pub fn of_base_frame(pose: &Pose) -> Self {
        Self {
            camera: CameraChange::Moved,
            moved: vec![true; pose.models.len()],
            any_moved: !pose.models.is_empty(),
            lights: vec![LightChange::Moved; pose.lights.len()],
        }
    }

    /// Test that a sample must pass to count as visible. `moved`: its model moved.
    pub fn sight_check(&self, moved: bool) -> SightCheck {
        match (self.camera, moved) {
            (CameraChange::Moved, _) | (_, true) => SightCheck::Everything,
            (_, false) if self.any_moved => SightCheck::Moved,
            (_, false) => SightCheck::Nothing,
        }
    }

    /// Test that a sample's `tag` for `light` needs before it can be trusted. `moved`: its model moved.
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

    /// Flags for a sample that is not checked in this frame: they say what is unknown about it from now on.
    /// `moved`: its model moved.
    pub fn doubts(&self, moved: bool) -> Flags {
        let unseen = Flags::UNSEEN.when(self.sight_check(moved) != SightCheck::Nothing);
        unseen.with(Flags::STALE.when(self.light_changes(moved)))
    }

    /// Returns true if all tags for `light` hold without a test.
    pub fn keeps_all_tags(&self, light: usize) -> bool {
        !self.any_moved && self.lights[light] != LightChange::Moved
    }

    /// Returns true if a `term` of a sample's colour stays the same, as far as it comes from one light.
    /// `moved`: the sample's model moved; `reached`: true if the light reached the sample in the frame
    /// before, and if it does now.
    ///
    /// Samples keep ambient and diffuse light of all lights as one sum, and highlights stay in the film, tile
    /// by tile; so the terms that are kept are those of [`keeps_all`](Self::keeps_all). Gathered light and
    /// openness last as long as [`Until`](crate::changes::Until) says.
    pub fn keeps(&self, term: Term, light: usize, moved: bool, reached: [bool; 2]) -> bool {
        let [before, now] = reached;
        let rests = !moved && self.lights[light] == LightChange::None && before == now;
        let stays_dark = !before && !now;
        match term {
            Term::Ambient => true,
            Term::Diffuse => stays_dark || rests,
            Term::Specular => stays_dark || rests && self.camera == CameraChange::None,
        }
    }

    /// Returns true if a `term` of a sample's colour stays the same, provided that each light reaches the
    /// sample as before. `moved`: its model moved.
    pub fn keeps_all(&self, term: Term, moved: bool) -> bool {
        // this holds without lights, too: the light that a surface has gathered depends on its place
        let rests = term == Term::Ambient || !moved;
        rests && (0..self.lights.len()).all(|light| self.keeps(term, light, moved, [true; 2]))
    }

    /// Returns true if the light on a sample must be summed anew even if all of its tags hold.
    pub fn light_changes(&self, moved: bool) -> bool {
        !self.keeps_all(Term::Diffuse, moved)
    }
}

/// Samples go on from frame to frame at their own ticks, so cameras are compared tick by tick.
pub fn camera_change(before: &Pose, now: &Pose) -> CameraChange {
    let is_in_place = |before: &CameraPose, now: &CameraPose| {
        before.eye == now.eye
            && (!now.is_orthographic() || before.forward == now.forward)
            // clipping planes turn with the camera, and hide or show other things
            && [before, now].iter().all(|camera| camera.clip == Clip::NONE)
    };
    if before.camera == now.camera && before.cameras == now.cameras {
        CameraChange::None
    } else if (0..TICKS as Tick).all(|tick| is_in_place(before.camera_at(tick), now.camera_at(tick))) {
        CameraChange::SamePlace
    } else {
        CameraChange::Moved
    }
}

/// Like cameras, lights are compared tick by tick.
fn light_change(before: &Pose, now: &Pose, light: usize) -> LightChange {
    let ticks = if before.lights_at_ticks.is_empty() && now.lights_at_ticks.is_empty() { 1 } else { TICKS };
    let pairs = (0..ticks as Tick).map(|tick| [before, now].map(|pose| &pose.lights_at(tick)[light]));
    pairs.fold(LightChange::None, |change, [old, new]| {
        if old == new || change == LightChange::Moved {
            change
        } else if old.shape == new.shape {
            LightChange::Strength
        } else {
            LightChange::Moved
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::animation::{Transform, TransformTrack};
    use crate::frame::grid::view::tests::camera;
    use crate::pose::{LightPose, LightShape};
    use crate::sweep::Sweeps;
    use glam::Vec3;

    fn pose() -> Pose {
        let lamp = |x| LightPose {
            shape: LightShape::Point { position: Vec3::new(x, 0.0, 0.0) },
            strength: Vec3::ONE,
            points: 1,
        };
        Pose {
            frame: 1,
            moment: 1,
            camera: camera(Vec3::ZERO),
            cameras: Vec::new(),
            models: vec![Transform::IDENTITY; 2],
            sweeps: Sweeps::default(),
            lights: vec![lamp(0.0), lamp(5.0)],
            lights_at_ticks: Vec::new(),
        }
    }

    #[test]
    fn lights_are_compared_tick_by_tick() {
        let ticks = |change: fn(usize, &mut LightPose)| {
            let at = |tick| {
                let mut lights = pose().lights;
                change(tick, &mut lights[1]);
                lights
            };
            Pose { lights_at_ticks: (0..TICKS).map(at).collect(), ..pose() }
        };
        let moves = ticks(|tick, light| {
            light.shape = LightShape::Point { position: Vec3::X * tick as f32 };
        });
        let flickers = ticks(|tick, light| light.strength = Vec3::splat(tick as f32));
        let change = |before: &Pose, now: &Pose| Plan::between(before, now).lights;
        let of_second = |change| vec![LightChange::None, change];
        // each sample goes on at its own tick, where all is as it was
        assert_eq!(change(&moves, &moves), of_second(LightChange::None));
        assert_eq!(change(&flickers, &flickers), of_second(LightChange::None));
        for (one, change_of_it) in [(&moves, LightChange::Moved), (&flickers, LightChange::Strength)] {
            assert_eq!(change(&pose(), one), of_second(change_of_it));
            assert_eq!(change(one, &pose()), of_second(change_of_it));
        }
        assert_eq!(change(&moves, &flickers), of_second(LightChange::Moved));
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
    fn a_turned_camera_with_clipping_planes_may_hide_anything() {
        let clip = Clip { near: 0.0, far: 9.0 };
        let (mut before, mut now) = (pose(), pose());
        (before.camera.clip, now.camera.clip) = (clip, clip);
        assert_eq!(Plan::between(&before, &now).camera, CameraChange::None);
        (now.camera.right, now.camera.forward) = (Vec3::Z, Vec3::X);
        assert_eq!(Plan::between(&before, &now).camera, CameraChange::Moved);
        assert_eq!(change(|now| now.camera.clip = clip).camera, CameraChange::Moved);
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

    // One test a row of the third table.

    const LIT: [bool; 2] = [true, true];
    const STAYS_DARK: [bool; 2] = [false, false];
    const FALLS_DARK: [bool; 2] = [true, false];
    const COMES_TO_LIGHT: [bool; 2] = [false, true];

    #[test]
    fn ambient_light_stays_whatever_changes() {
        for reached in [LIT, STAYS_DARK, FALLS_DARK, COMES_TO_LIGHT] {
            for plan in [Plan::of_base_frame(&pose()), change(|now| now.lights[0].strength = Vec3::X)] {
                assert!(plan.keeps(Term::Ambient, 0, true, reached) && plan.keeps_all(Term::Ambient, true));
            }
        }
    }

    #[test]
    fn diffuse_light_stays_while_light_sample_and_shadow_do() {
        let camera = change(|now| now.camera.eye = Vec3::X);
        for plan in [change(|_| ()), Plan::between(&pose(), &moved_model()), camera] {
            assert!(plan.keeps(Term::Diffuse, 0, false, LIT) && plan.keeps_all(Term::Diffuse, false));
        }
    }

    #[test]
    fn diffuse_light_of_what_stays_dark_stays_whatever_moves() {
        let light = change(|now| now.lights[0].shape = LightShape::Point { position: Vec3::Y });
        for (plan, moved) in [(Plan::between(&pose(), &moved_model()), true), (light, false)] {
            assert!(plan.keeps(Term::Diffuse, 0, moved, STAYS_DARK), "another blocker is as dark");
            assert!(plan.keeps(Term::Specular, 0, moved, STAYS_DARK), "and as dull");
        }
    }

    #[test]
    fn diffuse_light_is_new_where_a_shadow_comes_or_goes() {
        for reached in [FALLS_DARK, COMES_TO_LIGHT] {
            assert!(!change(|_| ()).keeps(Term::Diffuse, 0, false, reached));
            assert!(!change(|_| ()).keeps(Term::Specular, 0, false, reached));
        }
    }

    #[test]
    fn tags_say_whether_a_shadow_comes_or_goes() {
        let tags = [Tag::BackFacing, Tag::Lit, Tag::StaticOccluder, Tag::DynamicOccluder];
        let plan = change(|_| ());
        for (before, now) in tags.into_iter().flat_map(|before| tags.map(|now| (before, now))) {
            let reached = [before, now].map(Tag::is_lit);
            assert_eq!(before.changes_light_to(now), !plan.keeps(Term::Diffuse, 0, false, reached));
        }
    }

    #[test]
    fn diffuse_light_is_new_on_what_moved() {
        let plan = Plan::between(&pose(), &moved_model());
        assert!(!plan.keeps(Term::Diffuse, 0, true, LIT) && !plan.keeps_all(Term::Diffuse, true));
        let unlit = Plan { lights: vec![], ..plan };
        assert!(!unlit.keeps_all(Term::Diffuse, true), "what it has gathered depends on its place");
    }

    #[test]
    fn diffuse_light_is_new_under_a_light_that_moved_or_has_another_colour() {
        for plan in [
            change(|now| now.lights[1].shape = LightShape::Point { position: Vec3::Y }),
            change(|now| now.lights[1].strength = Vec3::X),
        ] {
            assert!(!plan.keeps(Term::Diffuse, 1, false, LIT) && plan.keeps(Term::Diffuse, 0, false, LIT));
            assert!(!plan.keeps_all(Term::Diffuse, false), "they are kept as one sum");
        }
    }

    #[test]
    fn highlights_stay_while_camera_light_and_sample_rest() {
        assert!(change(|_| ()).keeps_all(Term::Specular, false));
        assert!(Plan::between(&pose(), &moved_model()).keeps_all(Term::Specular, false));
        assert!(!Plan::between(&pose(), &moved_model()).keeps_all(Term::Specular, true));
        for plan in [
            change(|now| now.camera.eye = Vec3::X),
            change(|now| now.camera.half_height = 0.5),
            change(|now| now.lights[1].strength = Vec3::X),
            change(|now| now.lights[1].shape = LightShape::Point { position: Vec3::Y }),
        ] {
            assert!(!plan.keeps_all(Term::Specular, false), "{plan:?}");
        }
    }

    #[test]
    fn a_fresh_sample_asks_everything_whatever_stood_still() {
        assert_eq!(change(|_| ()).shadow_check(0, false, Tag::Unknown), ShadowCheck::StillThenMovable);
    }
}
