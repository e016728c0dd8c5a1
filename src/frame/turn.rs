//! In which direction time runs from one picture to the next, and what of the answers that samples keep holds then.

use super::eyes::EyeMemory;
use super::shot::prepared::Prepared;
use super::snapshot::Holds;
use crate::changes::Direction;
use crate::pose::Pose;
use crate::settings::{BasePlace, Mode, Settings};

/// Whether frames before base frames are inferred from them, as those after them are.
pub fn has_two_sides(settings: &Settings) -> bool {
    settings.base_place == BasePlace::Middle && settings.mode != Mode::Full
}

/// In which direction time runs from the picture `before`, whose samples `memory` has, to that at `pose`, and whether what is found out
/// there is to hold in both: in base frames that have frames on either side, and so in all pictures of such a frame.
pub fn direction(
    settings: &Settings,
    memory: &EyeMemory,
    before: Option<&Pose>,
    pose: &Pose,
) -> (Direction, bool) {
    let direction =
        before.map_or(Direction::Forward, |before| way_from(before.moment, pose.moment, memory.holds));
    let is_of_base = before.is_none_or(|before| before.frame == pose.frame && memory.holds == Holds::Both);
    (direction, is_of_base && has_two_sides(settings))
}

/// Has what the samples of `memory` have found out until the picture `before` hold in the [`direction`] of `time`, or forgets it.
/// [`Prepared::look_back`] comes before it, unless time runs forwards alone.
pub fn turn(prepared: &Prepared, memory: &mut EyeMemory, before: Option<&Pose>, time: (Direction, bool)) {
    let EyeMemory { levels, holds, .. } = memory;
    let (direction, is_both) = time;
    if let Some(before) = before.filter(|_| !holds.includes(direction)) {
        let (motion, back) = (&prepared.motion, prepared.motion_back());
        let translated = |until| motion.translated(until, before.moment, back);
        let is_known = *holds == Holds::Both;
        levels.iter_mut().for_each(|level| match is_known {
            true => level.change_validity(translated),
            false => level.forget_gathered(),
        });
    }
    *holds = if is_both { Holds::Both } else { Holds::To(direction) };
}

/// In which direction time runs from one moment to the other; from a moment to itself as before.
fn way_from(before: i64, now: i64, holds: Holds) -> Direction {
    if now < before || now == before && holds == Holds::To(Direction::Backward) {
        Direction::Backward
    } else {
        Direction::Forward
    }
}
