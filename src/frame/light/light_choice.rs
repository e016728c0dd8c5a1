//! Choice of the one light source that a surface on a path asks for light.

use crate::frame::shot::frame_view::FrameView;

/// Light source that a surface asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LightChoice {
    /// A light of the shot, by number.
    Light(u32),
    /// A direction of the sky.
    Sky,
    /// An emitting surface.
    Emitter,
    /// No light source exists.
    Nothing,
}

impl LightChoice {
    /// Number of choices of a surface after `bounce` bounces.
    pub fn count(frame: &FrameView, bounce: u32) -> u32 {
        let others = [asks_sky(frame, bounce), frame.emitters.are_asked()];
        frame.pose.lights.len() as u32 + others.into_iter().map(u32::from).sum::<u32>()
    }

    /// Light source for choice number `choice`.
    pub fn new(frame: &FrameView, bounce: u32, choice: u32) -> Self {
        let lights = frame.pose.lights.len() as u32;
        match (choice.checked_sub(lights), asks_sky(frame, bounce), frame.emitters.are_asked()) {
            (None, ..) => Self::Light(choice),
            (Some(0), true, _) => Self::Sky,
            (Some(_), _, true) => Self::Emitter,
            (Some(_), ..) => Self::Nothing,
        }
    }
}

/// Returns true if vertices after `bounce` bounces may choose to ask the sky: if asking finds more light than
/// paths do by chance, or if no path goes on that could find the sky.
pub fn asks_sky(frame: &FrameView, bounce: u32) -> bool {
    frame.sky.is_uneven() || frame.sky.shines() && !paths_go_on(frame, bounce)
}

/// Returns true if paths go on from vertices after `bounce` bounces. From the last vertex they only collect
/// emission: near an emitting surface, asking alone would give nothing but noise.
pub fn paths_go_on(frame: &FrameView, bounce: u32) -> bool {
    bounce + 1 < frame.bounces || !frame.emitters.is_empty()
}
