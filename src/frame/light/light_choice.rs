//! Choice of the one light source that a surface on a path asks for light.

use super::step::Step;
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

/// First of some sets of random numbers that no surface on a path uses.
pub fn free_sets(frame: &FrameView) -> u32 {
    2 * frame.settings.bounces.max(frame.settings.depth) + 3
}

/// Surfaces that a path meets: gathered ones as many as the shot's `bounces`; reflected ones one more, or, if
/// surfaces gather no light, as many as there are bounces of a ray from the eye.
pub fn surfaces_on_paths(frame: &FrameView, is_reflected: bool) -> u32 {
    match (is_reflected, frame.paths) {
        (false, _) => frame.settings.bounces,
        (true, 0) => frame.settings.depth,
        (true, _) => frame.settings.bounces + 1,
    }
}

impl LightChoice {
    /// Number of choices of a surface.
    pub fn count(frame: &FrameView, step: Step) -> u32 {
        let others = [asks_sky(frame, step), frame.emitters.are_asked()];
        frame.pose.lights.len() as u32 + others.into_iter().map(u32::from).sum::<u32>()
    }

    /// Light source for choice number `choice`.
    pub fn new(frame: &FrameView, step: Step, choice: u32) -> Self {
        let lights = frame.pose.lights.len() as u32;
        match (choice.checked_sub(lights), asks_sky(frame, step), frame.emitters.are_asked()) {
            (None, ..) => Self::Light(choice),
            (Some(0), true, _) => Self::Sky,
            (Some(_), _, true) => Self::Emitter,
            (Some(_), ..) => Self::Nothing,
        }
    }
}

/// Returns true if surfaces on paths may choose to ask the sky: if they gather light, and asking finds more of
/// it than paths do by chance, or no path goes on that could find the sky.
pub fn asks_sky(frame: &FrameView, step: Step) -> bool {
    frame.paths > 0 && (frame.sky.is_uneven() || frame.sky.shines() && !paths_go_on(frame, step))
}

/// Returns true if paths go on from a surface. From the last one they only collect emission: near an emitting
/// surface, asking alone would give nothing but noise.
pub fn paths_go_on(frame: &FrameView, step: Step) -> bool {
    !step.is_last() || !frame.emitters.is_empty()
}
