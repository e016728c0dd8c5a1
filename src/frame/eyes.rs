//! What is kept of each eye from frame to frame, and whose samples a frame may reuse.
//!
//! The left eye, which is the only one of most shots, goes on with its own samples of the frame before. The right eye takes
//! those that the left eye has in the same frame: nothing has moved between the two, so that all that samples keep, light and
//! tags, holds as it is, and whether the right eye sees them is all that is asked. While the camera rests each eye goes on with
//! its own, in place.
//!
//! One chain through both eyes (left, right, the next left …) would need no second store. But whatever one eye does not see
//! would be lost to the other in each frame, and no camera would ever rest.

use std::sync::Arc;

use super::shot::plan::{CameraChange, Plan};
use super::snapshot::Holds;
use super::tiles::level::Level;
use crate::changes::Direction;
use crate::film::Film;
use crate::pose::Pose;
use crate::samples::saved::{PictureName, PictureSamples};
use crate::samples::{SampleStore, TagLayout};
use crate::settings::Settings;
use crate::stereo::{Eye, EyePlace};

/// What is kept of one eye, or of one exposure.
pub struct EyeMemory {
    /// Beside the shot's camera, if there are two.
    pub place: Option<EyePlace>,
    /// What samples its pictures, the coarsest first: where the frame that it saw last has left its samples.
    pub levels: Vec<Level>,
    /// Where everything was in that frame.
    pub last: Option<Pose>,
    /// In which direction what the samples have found out holds.
    pub holds: Holds,
    /// The picture of that frame. What stays the same is left in it, unless somebody still reads it then.
    pub film: Option<Arc<Film>>,
}

impl EyeMemory {
    /// Of an eye that has seen nothing yet; `place`: beside the camera, if there are two.
    pub fn new(place: Option<EyePlace>, settings: &Settings, layout: &TagLayout) -> Self {
        let holds = Holds::To(Direction::Forward);
        Self { place, levels: Level::all(settings, layout), last: None, holds, film: None }
    }

    /// Forgets all samples, and what the film shows.
    pub fn forget(&mut self) {
        self.last = None;
        self.levels.iter_mut().for_each(|level| level.store = None);
        self.forget_film();
    }

    /// Forgets what the film shows.
    pub fn forget_film(&mut self) {
        self.film = None;
        self.levels.iter_mut().for_each(|level| level.buffers.states.clear());
    }

    /// What later frames need of its `picture`, if it has one.
    pub fn kept(&self, picture: PictureName) -> Option<PictureSamples<&SampleStore>> {
        let levels = self.levels.iter().map(Level::kept).collect::<Option<_>>()?;
        Some(PictureSamples { picture, levels })
    }

    /// Takes what `other` has to work in.
    pub fn take_room_from(&mut self, other: &mut Self) {
        let levels = self.levels.iter_mut().zip(&mut other.levels);
        levels.for_each(|(level, of_other)| level.take_room_from(of_other));
    }

    /// Takes the samples of `lender` for one picture, and drops its own.
    pub fn borrow_from(&mut self, lender: &mut Self) {
        let levels = self.levels.iter_mut().zip(&mut lender.levels);
        levels.for_each(|(level, of_lender)| level.borrow_from(of_lender));
        self.holds = lender.holds;
    }

    /// Gives them back.
    pub fn give_back_to(&mut self, lender: &mut Self) {
        let levels = self.levels.iter_mut().zip(&mut lender.levels);
        levels.for_each(|(level, of_lender)| level.give_back_to(of_lender));
    }
}

/// Whose samples a frame may reuse.
#[derive(Debug, PartialEq)]
pub enum Source {
    /// Nobody's.
    None,
    /// The eye's own, of the frame before, in which everything was where this says.
    Own(Pose),
    /// Of the left eye, or of the exposure before, in the same frame. They go back to it.
    Lent(Pose),
}

impl Source {
    /// For what `eye` sees as `pose` says. `last`: where everything was in the frames that the left eye and the right one saw
    /// last. `reuse`: it may be inferred from the frame before, and if it `may_be_lent`, from the left eye's of the same frame.
    pub fn of(last: [Option<&Pose>; 2], eye: Eye, pose: &Pose, reuse: bool, may_be_lent: bool) -> Self {
        let own = last[eye as usize].filter(|before| eye == Eye::Left || before.camera == pose.camera);
        let of_left = last[Eye::Left as usize].filter(|seen| eye == Eye::Right && seen.frame == pose.frame);
        match (own.filter(|_| reuse), of_left.filter(|_| may_be_lent)) {
            (Some(before), _) => Self::Own(before.clone()),
            (None, Some(seen)) => Self::Lent(seen.clone()),
            (None, None) => Self::None,
        }
    }

    /// Where everything was when those samples were seen.
    pub fn pose(&self) -> Option<&Pose> {
        match self {
            Self::None => None,
            Self::Own(pose) | Self::Lent(pose) => Some(pose),
        }
    }

    /// What changed between those samples and `pose`.
    pub fn plan(&self, pose: &Pose) -> Plan {
        match self {
            Self::None => Plan::of_base_frame(pose),
            Self::Own(before) => Plan::between(before, pose),
            Self::Lent(seen) => {
                let plan = Plan::between(seen, pose);
                // lent samples are not changed in place, however near the eyes are
                let is_at_rest = plan.camera == CameraChange::None;
                let camera = if is_at_rest { CameraChange::SamePlace } else { plan.camera };
                Plan { camera, ..plan }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::frame::grid::view::tests::camera;

    fn pose(frame: i32, x: f32) -> Pose {
        Pose {
            frame,
            moment: frame.into(),
            camera: camera(Vec3::X * x),
            models: Vec::new(),
            lights: Vec::new(),
        }
    }

    /// After frames in which the left eye was at 0 and the right one at 1: the frame whose samples are reused, and whether they
    /// are lent.
    fn source(
        frames: [i32; 2],
        eye: Eye,
        pose_now: &Pose,
        reuse: bool,
        may_be_lent: bool,
    ) -> (Option<i32>, bool) {
        let last = [pose(frames[0], 0.0), pose(frames[1], 1.0)];
        let source = Source::of(last.each_ref().map(Some), eye, pose_now, reuse, may_be_lent);
        (source.pose().map(|pose| pose.frame), matches!(source, Source::Lent(_)))
    }

    #[test]
    fn the_left_eye_goes_on_with_its_own() {
        assert_eq!(source([1, 1], Eye::Left, &pose(2, 9.0), true, true), (Some(1), false));
        assert_eq!(source([1, 1], Eye::Left, &pose(2, 9.0), false, true), (None, false));
    }

    #[test]
    fn the_right_eye_takes_the_left_ones_unless_it_rests() {
        assert_eq!(source([2, 1], Eye::Right, &pose(2, 9.0), true, true), (Some(2), true));
        assert_eq!(source([2, 1], Eye::Right, &pose(2, 1.0), true, true), (Some(1), false), "it rests");
        assert_eq!(source([2, 1], Eye::Right, &pose(2, 1.0), false, true), (Some(2), true), "a base frame");
        assert_eq!(source([2, 1], Eye::Right, &pose(2, 9.0), true, false), (None, false), "in full");
        assert_eq!(source([1, 1], Eye::Right, &pose(2, 9.0), true, true), (None, false), "another frame");
    }

    #[test]
    fn lent_samples_are_projected_even_between_eyes_in_one_place() {
        let change = |source: Source, x| source.plan(&pose(2, x)).camera;
        assert_eq!(change(Source::Lent(pose(2, 0.0)), 0.0), CameraChange::SamePlace);
        assert_eq!(change(Source::Own(pose(1, 0.0)), 0.0), CameraChange::None);
        assert_eq!(change(Source::Lent(pose(2, 0.0)), 1.0), CameraChange::Moved);
    }
}
