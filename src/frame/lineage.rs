//! Lineage: the samples that a picture is made of, decided from poses alone before any ray is cast.
//!
//! A frame is one picture, or several: one for each eye, and one for each exposure of a shutter or a lens. Each picture is made by the same
//! phases, of the samples of another picture that was made before. Which one follows from three rules, in this order:
//!
//! 1. *In place.* Where its camera is exactly where it was in its own picture of an earlier frame, a picture goes on with its own samples:
//!    what does not move costs nothing.
//! 2. *The latest.* Otherwise it is made of the samples of the latest picture that it may use: its own of an earlier frame, or for the
//!    right eye, that of the left eye in the same frame. Between the two eyes nothing has moved: all that samples keep, light and tags,
//!    holds as it is.
//! 3. *Nothing.* A base frame begins without samples: all of its pictures are traced, but for what the right eye takes from the left one.
//!
//! Samples go over to the new picture, but between the two eyes they are only lent, and projected: the left one goes on with them.
//! An exposure goes on with its own samples: each has its own time, point of the lens and part of the pixel in every frame, so that what
//! it keeps is as new to the others' parts as what is traced, and the samples of a pixel stay as many different ones as in a sharp frame.
//! What these leave open it is lent by the exposure before it, [beside](super::reuse::beside) its own; the first one by the last one of the
//! frame before.
//!
//! ```text
//! two eyes           L1 ──► L2 ──► L3        one goes on with its own samples,
//!                     ┊      ┊      ┊
//!                    R1     R2     R3        the other is lent them (rule 2)
//!
//! three exposures    1a ──► 2a ──► 3a        each goes on with its own
//!                    1b ──► 2b ──► 3b
//!                    1c ──► 2c ──► 3c       (and is lent what is missing: 1a, 1b, 1c, 2a, 2b, ...)
//! ```

use super::shot::plan::{CameraChange, Plan, camera_change};
use super::validity::ValidDirection;
use crate::media::MediaOfShot;
use crate::pose::Pose;
use crate::samples::saved::PictureName;
use crate::stereo::Eye;

/// A picture that was made before, whose samples exist.
#[derive(Debug, Clone, Copy)]
pub struct Ancestor<'a> {
    /// Its eye and exposure.
    pub picture: PictureName,
    /// The state of the shot in it.
    pub pose: &'a Pose,
    /// The direction of time in which the answers of its samples hold.
    pub valid: ValidDirection,
}

/// Facts of the shot and the frame that decide on lineages, beside poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rule {
    /// Samples of earlier frames may be used. Without it the frame is a base frame, and pictures use those of the same frame alone.
    pub reuse: bool,
    /// Every picture is traced in full.
    pub is_full: bool,
    /// Frames are inferred from a base frame in both directions of time: its answers are to hold in both.
    pub has_two_sides: bool,
    /// Number of exposures that lend each other samples; 1: none does.
    pub lenders: usize,
}

/// Ancestor of one picture, and the changes since then.
#[derive(Debug, Clone, PartialEq)]
pub struct Lineage {
    /// The picture whose samples it is made of. `None`: every cell is traced.
    pub from: Option<PictureName>,
    /// Those samples stay with that picture.
    pub is_lent: bool,
    /// The picture that lends samples where those leave cells open.
    pub beside: Option<PictureName>,
    /// Changes since that picture. With [`CameraChange::None`] samples stay in place; otherwise they are projected.
    pub plan: Plan,
    /// The direction of time in which the answers of its samples hold.
    pub valid: ValidDirection,
}

impl Lineage {
    /// Decides how the picture called `picture`, with everything as `pose` says, is made. `made`: all pictures that have samples, the latest
    /// one last.
    pub fn new(picture: PictureName, pose: &Pose, made: &[Ancestor], rule: &Rule) -> Self {
        let from = if rule.is_full { None } else { ancestor(picture, pose, made, rule) };
        let valid =
            ValidDirection::between(from.map(|from| (from.pose, from.valid)), pose, rule.has_two_sides);
        let Some(Ancestor { picture: name, pose: seen, .. }) = from else {
            let plan = Plan::of_base_frame(pose);
            return Self { from: None, is_lent: false, beside: None, plan, valid };
        };
        let is_lent = name.eye != picture.eye;
        let mut plan = Plan::between(seen, pose);
        // samples that are lent are never changed in place, however near the pictures are
        if is_lent && plan.camera == CameraChange::None {
            plan.camera = CameraChange::SamePlace;
        }
        let beside = if is_lent { None } else { beside(picture, (pose, seen.frame), made, rule.lenders) };
        let beside = beside.filter(|lender| is_as_near(lender.pose, pose, plan.camera));
        Self { from: Some(name), is_lent, beside: beside.map(|lender| lender.picture), plan, valid }
    }

    /// The lineage in a shot with these media: see [`Plan::with_media`].
    #[must_use]
    pub fn with_media(self, media: &MediaOfShot) -> Self {
        Self { plan: self.plan.with_media(media), ..self }
    }
}

/// Number of the exposure with which one of so many shares samples: the one before it, or of the first the last.
pub fn exposure_beside(exposure: usize, count: usize) -> usize {
    (exposure + count - 1) % count
}

/// The exposure beside that of a `picture`, in this frame or, if it is only made later, in the frame `before`.
fn beside<'a>(
    picture: PictureName,
    (pose, before): (&Pose, i32),
    made: &[Ancestor<'a>],
    lenders: usize,
) -> Option<Ancestor<'a>> {
    if lenders < 2 || picture.exposure >= lenders {
        return None;
    }
    let name = PictureName { exposure: exposure_beside(picture.exposure, lenders), ..picture };
    let frame = if name.exposure < picture.exposure { pose.frame } else { before };
    made.iter().find(|one| one.picture == name && one.pose.frame == frame).copied()
}

/// Returns true if what is lent needs no other tests than the samples that a picture goes on with: their camera has changed by `change`.
fn is_as_near(lender: &Pose, pose: &Pose, change: CameraChange) -> bool {
    let of_lender = camera_change(lender, pose);
    let is_in_place = change == CameraChange::None || of_lender == CameraChange::None;
    !is_in_place && (change == CameraChange::Moved || of_lender == change)
}

/// The picture whose samples are used: rules 1 and 2 of the [module](self).
fn ancestor<'a>(
    picture: PictureName,
    pose: &Pose,
    made: &[Ancestor<'a>],
    rule: &Rule,
) -> Option<Ancestor<'a>> {
    let is_usable = |one: &&Ancestor| rule.reuse || one.pose.frame == pose.frame && one.picture != picture;
    let is_reachable = |one: &&Ancestor| {
        let is_left_eye_of_frame = one.picture.eye == Eye::Left && one.pose.frame == pose.frame;
        one.picture.exposure == picture.exposure && (one.picture.eye == picture.eye || is_left_eye_of_frame)
    };
    let is_in_place =
        |one: &&Ancestor| one.picture == picture && one.pose.all_cameras() == pose.all_cameras();
    let candidates = || made.iter().filter(is_usable).filter(is_reachable);
    candidates().find(is_in_place).or_else(|| candidates().next_back()).copied()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::changes::Direction;
    use crate::frame::grid::view::tests::camera;
    use crate::sweep::Sweeps;

    fn pose(frame: i32, x: f32) -> Pose {
        let (camera, moment) = (camera(Vec3::X * x), i64::from(frame));
        Pose {
            frame,
            moment,
            camera,
            cameras: Vec::new(),
            models: Vec::new(),
            sweeps: Sweeps::default(),
            lights: Vec::new(),
            lights_at_ticks: Vec::new(),
        }
    }

    /// The picture called `L1b` is exposure 1 of the left eye in frame 1, with the camera at `x`.
    fn named(name: &str, x: f32) -> (PictureName, Pose) {
        let [eye, frame, exposure] = [0, 1, 2].map(|at| name.as_bytes()[at]);
        let eye = if eye == b'L' { Eye::Left } else { Eye::Right };
        let (frame, exposure) = (i32::from(frame - b'0'), usize::from(exposure - b'a'));
        (PictureName { eye, exposure }, pose(frame, x))
    }

    const RULE: Rule = Rule { reuse: true, is_full: false, has_two_sides: false, lenders: 1 };
    const BASE: Rule = Rule { reuse: false, ..RULE };
    const FULL: Rule = Rule { is_full: true, ..RULE };

    /// Like `L1a`, `L1a lent` or `-`, and the change of the camera: for `now`, after `made`, each with the place of its camera.
    fn lineage(made: &[(&str, f32)], (now, x): (&str, f32), rule: &Rule) -> (String, CameraChange) {
        let made: Vec<_> = made.iter().map(|(name, x)| (*name, named(name, *x))).collect();
        let valid = ValidDirection::To(Direction::Forward);
        let ancestors: Vec<Ancestor> =
            made.iter().map(|(_, (picture, pose))| Ancestor { picture: *picture, pose, valid }).collect();
        let (picture, pose) = named(now, x);
        let Lineage { from, is_lent, plan, .. } = Lineage::new(picture, &pose, &ancestors, rule);
        let Some(from) = from else { return (String::from("-"), plan.camera) };
        // of one picture there is one state
        let (name, _) = made.iter().find(|(_, (picture, _))| *picture == from).expect("it was made");
        (if is_lent { format!("{name} lent") } else { (*name).to_string() }, plan.camera)
    }

    #[test]
    fn samples_come_from() {
        use CameraChange::{Moved, None as Rests, SamePlace};
        type Seen<'a> = (&'a str, f32);
        type Case<'a> = (&'a str, &'a [Seen<'a>], Seen<'a>, Rule, &'a str, CameraChange);
        let table: [Case; 22] = [
            ("a first frame", &[], ("L1a", 0.0), RULE, "-", Moved),
            ("one eye goes on", &[("L1a", 0.0)], ("L2a", 9.0), RULE, "L1a", Moved),
            ("and in place", &[("L1a", 0.0)], ("L2a", 0.0), RULE, "L1a", Rests),
            ("a base frame", &[("L1a", 0.0)], ("L2a", 9.0), BASE, "-", Moved),
            ("a base frame made again", &[("L2a", 0.0)], ("L2a", 0.0), BASE, "-", Moved),
            ("the right eye is lent the left one's", &[("L2a", 0.0)], ("R2a", 1.0), RULE, "L2a lent", Moved),
            ("also in a base frame", &[("L2a", 0.0)], ("R2a", 1.0), BASE, "L2a lent", Moved),
            ("not in full", &[("L2a", 0.0)], ("R2a", 1.0), FULL, "-", Moved),
            ("eyes in one place", &[("L2a", 0.0)], ("R2a", 0.0), RULE, "L2a lent", SamePlace),
            ("it moves", &[("R1a", 1.0), ("L2a", 8.0)], ("R2a", 9.0), RULE, "L2a lent", Moved),
            ("it rests", &[("R1a", 1.0), ("L2a", 0.0)], ("R2a", 1.0), RULE, "R1a", Rests),
            (
                "it rests in a base frame",
                &[("R1a", 1.0), ("L2a", 0.0)],
                ("R2a", 1.0),
                BASE,
                "L2a lent",
                Moved,
            ),
            ("the right eye alone", &[("L1a", 0.0)], ("R2a", 1.0), RULE, "-", Moved),
            ("the left eye alone", &[("L1a", 0.0), ("R1a", 1.0)], ("L2a", 2.0), RULE, "L1a", Moved),
            ("never from another exposure", &[("L1a", 0.0)], ("L1b", 1.0), RULE, "-", Moved),
            ("nor in a base frame", &[("L2a", 3.0)], ("L2b", 4.0), BASE, "-", Moved),
            ("each goes on", &[("L1a", 0.0), ("L1b", 1.0)], ("L2a", 3.0), RULE, "L1a", Moved),
            ("also when others have", &[("L1b", 1.0), ("L2a", 3.0)], ("L2b", 4.0), RULE, "L1b", Moved),
            ("and in place", &[("L1b", 1.0), ("L2a", 0.0)], ("L2b", 1.0), RULE, "L1b", Rests),
            ("lent to the same one", &[("L2a", 2.0), ("L2b", 3.0)], ("R2a", 1.0), RULE, "L2a lent", Moved),
            ("not to another", &[("R1b", 1.0), ("L2a", 2.0)], ("R2b", 1.5), RULE, "R1b", Moved),
            ("not even where that rests", &[("L2b", 0.0)], ("R2a", 0.0), RULE, "-", Moved),
        ];
        for (case, made, now, rule, from, camera) in table {
            let (found, change) = lineage(made, now, &rule);
            assert_eq!(found, from, "{case}");
            assert!(from == "-" || change == camera, "{case}: {change:?}");
        }
    }

    #[test]
    fn exposures_are_lent_what_is_missing() {
        const SHARES: Rule = Rule { lenders: 3, ..RULE };
        type Case<'a> = (&'a [(&'a str, f32)], (&'a str, f32), Rule, Option<&'a str>);
        let table: [Case; 9] = [
            (&[("L1b", 1.0), ("L2a", 2.0)], ("L2b", 3.0), SHARES, Some("L2a")),
            (&[("L1c", 1.0), ("L2a", 2.0), ("L2b", 3.0)], ("L2c", 4.0), SHARES, Some("L2b")),
            (&[("L1a", 0.0), ("L1b", 1.0), ("L1c", 2.0)], ("L2a", 4.0), SHARES, Some("L1c")),
            // nothing of its own, or everything
            (&[("L1a", 0.0)], ("L1b", 1.0), SHARES, None),
            (&[("L1b", 1.0), ("L2a", 2.0)], ("L2b", 1.0), SHARES, None),
            // of an older frame, in the same place, of the other eye
            (&[("L1a", 0.0), ("L1b", 1.0)], ("L2b", 3.0), SHARES, None),
            (&[("L1b", 1.0), ("L2a", 3.0)], ("L2b", 3.0), SHARES, None),
            (&[("R1a", 1.0), ("L2a", 3.0)], ("R2b", 4.0), SHARES, None),
            (&[("L1b", 1.0), ("L2a", 2.0)], ("L2b", 3.0), RULE, None),
        ];
        for (made, (now, x), rule, wanted) in table {
            let made: Vec<_> = made.iter().map(|(name, x)| named(name, *x)).collect();
            let valid = ValidDirection::To(Direction::Forward);
            let ancestors: Vec<Ancestor> =
                made.iter().map(|(picture, pose)| Ancestor { picture: *picture, pose, valid }).collect();
            let (picture, pose) = named(now, x);
            let Lineage { beside, .. } = Lineage::new(picture, &pose, &ancestors, &rule);
            assert_eq!(beside, wanted.map(|name| named(name, 0.0).0), "{now} after {made:?}");
        }
    }

    /// What needs no test since the eye did not move may only come from where that holds as well.
    #[test]
    fn what_is_lent_is_as_near_as_what_goes_on() {
        let turned = |frame: i32, x: f32, right: Vec3| {
            let mut pose = pose(frame, x);
            pose.camera.right = right;
            pose
        };
        let now = turned(2, 0.0, Vec3::Z);
        for (lender, change, is_near) in [
            (turned(2, 0.0, Vec3::Y), CameraChange::SamePlace, true),
            (turned(2, 1.0, Vec3::Y), CameraChange::SamePlace, false),
            (turned(2, 1.0, Vec3::Y), CameraChange::Moved, true),
            (turned(2, 0.0, Vec3::Y), CameraChange::Moved, true),
            (turned(2, 1.0, Vec3::Y), CameraChange::None, false),
            (now.clone(), CameraChange::Moved, false),
        ] {
            assert_eq!(is_as_near(&lender, &now, change), is_near, "{change:?}");
        }
    }

    #[test]
    fn time_runs_from_the_ancestor_to_the_picture() {
        use ValidDirection::{Both, To};
        let two_sides = Rule { has_two_sides: true, ..RULE };
        let [forward, backward] = [Direction::Forward, Direction::Backward].map(To);
        for (from, valid, now, rule, expected) in [
            (None, forward, 5, RULE, forward),
            (Some(4), forward, 5, RULE, forward),
            (Some(6), forward, 5, RULE, backward),
            (Some(5), backward, 5, RULE, backward),
            (None, forward, 5, two_sides, Both),
            (Some(5), Both, 5, two_sides, Both),
            (Some(4), Both, 5, two_sides, forward),
            (Some(6), Both, 5, two_sides, backward),
        ] {
            let seen = from.map(|frame| pose(frame, 0.0));
            let picture = PictureName { eye: Eye::Left, exposure: 0 };
            let made: Vec<Ancestor> = seen.iter().map(|pose| Ancestor { picture, pose, valid }).collect();
            let lineage = Lineage::new(picture, &pose(now, 0.0), &made, &rule);
            assert_eq!(lineage.valid, expected, "from {from:?}, {valid:?}");
        }
    }
}
