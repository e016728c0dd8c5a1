//! What surfaces that paths meet ask for light, one thing each.

use crate::frame::shot::frame_view::FrameView;

/// What a surface asks for light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Asks {
    /// This light of the shot.
    Light(u32),
    /// A direction of the sky.
    Sky,
    /// A surface that emits.
    Emitter,
    /// There is none.
    Nothing,
}

impl Asks {
    /// What there is to ask for a surface after so many bounces.
    pub fn count(frame: &FrameView, bounce: u32) -> u32 {
        let others = [asks_sky(frame, bounce), frame.emitters.are_asked()];
        frame.pose.lights.len() as u32 + others.into_iter().map(u32::from).sum::<u32>()
    }

    /// What number `choice` of them is.
    pub fn of(frame: &FrameView, bounce: u32, choice: u32) -> Self {
        let lights = frame.pose.lights.len() as u32;
        match (choice.checked_sub(lights), asks_sky(frame, bounce), frame.emitters.are_asked()) {
            (None, ..) => Self::Light(choice),
            (Some(0), true, _) => Self::Sky,
            (Some(_), _, true) => Self::Emitter,
            (Some(_), ..) => Self::Nothing,
        }
    }
}

/// Whether vertices after so many bounces may choose to ask the sky: wherever that finds more than chance would, and where
/// no path goes on that could find it.
pub fn asks_sky(frame: &FrameView, bounce: u32) -> bool {
    frame.sky.is_uneven() || frame.sky.shines() && !paths_go_on(frame, bounce)
}

/// Whether paths go on from vertices after so many bounces. Off the last one they only bring what emits: where a surface
/// that emits is near, asking for it alone would be all noise.
pub fn paths_go_on(frame: &FrameView, bounce: u32) -> bool {
    bounce + 1 < frame.bounces || !frame.emitters.is_empty()
}
