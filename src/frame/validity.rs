//! The direction of time in which the answers that samples keep are valid: an [`Until`](crate::changes::Until) counts frames in one of them.

use super::tiles::level::Level;
use crate::changes::{Direction, Motion};
use crate::pose::Pose;

/// The direction of time in which answers hold until the frame that they name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValidDirection {
    /// Only this one.
    To(Direction),
    /// Both, for as many frames: the answers are of a base frame with frames on either side, and name the frame forwards.
    Both,
}

impl ValidDirection {
    /// The direction from the picture `before`, with that of its answers, to the picture at `pose`. Answers of a base frame are to hold in both,
    /// if it has frames on either side, and so in all pictures of such a frame.
    pub fn between(before: Option<(&Pose, Self)>, pose: &Pose, has_two_sides: bool) -> Self {
        let is_of_base =
            before.is_none_or(|(before, valid)| before.frame == pose.frame && valid == Self::Both);
        if is_of_base && has_two_sides {
            return Self::Both;
        }
        Self::To(match before {
            Some((before, _)) if before.moment > pose.moment => Direction::Backward,
            // from a moment to itself as before
            Some((before, Self::To(Direction::Backward))) if before.moment == pose.moment => {
                Direction::Backward
            }
            _ => Direction::Forward,
        })
    }

    /// The direction in which answers name a frame.
    pub fn direction(self) -> Direction {
        match self {
            Self::To(direction) => direction,
            Self::Both => Direction::Forward,
        }
    }

    /// Returns true if only motion forwards is asked.
    pub fn is_forward_alone(self) -> bool {
        self == Self::To(Direction::Forward)
    }
}

/// Makes the answers in `levels`, which are `valid` and were found until the picture at `before`, hold in the direction of `wanted`: they are
/// converted if they hold in both directions, and forgotten otherwise. `motions`: forwards, and backwards.
pub fn reverse(
    levels: &mut [Level],
    valid: ValidDirection,
    wanted: ValidDirection,
    before: &Pose,
    (motion, back): (&Motion, &Motion),
) {
    if valid.direction() == wanted.direction() {
        return;
    }
    let converted = |until| motion.to_opposite(until, before.moment, back);
    levels.iter_mut().for_each(|level| match valid {
        ValidDirection::Both => level.change_validity(converted),
        ValidDirection::To(_) => level.forget_gathered(),
    });
}
