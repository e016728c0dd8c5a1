//! What a surface on a path asks for light: each kind of light source that there is.
//!
//! The surface is what cost: a ray more to each kind costs less than the noise where kinds share one. Of the shot's lights it asks one,
//! by [chances](crate::shade::light_chances::LightChances).

use glam::Vec3;

use super::step::Step;
use crate::frame::shot::frame_view::FrameView;
use crate::scene::SkyDensity;

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

/// Kinds of light sources that a surface on a path asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kinds {
    pub lights: bool,
    pub sky: bool,
    pub emitters: bool,
}

impl Kinds {
    /// Those of surfaces at this place of a path.
    pub fn of(frame: &FrameView, step: Step) -> Self {
        let (sky, emitters) = (asks_sky(frame, step), frame.emitters.are_asked());
        Self { lights: !frame.pose.lights.is_empty(), sky, emitters }
    }
}

/// Returns true if surfaces on paths ask the sky: if they gather light, and asking finds more of
/// it than paths do by chance, or no path goes on that could find the sky.
pub fn asks_sky(frame: &FrameView, step: Step) -> bool {
    frame.paths > 0 && (frame.sky.is_uneven() || frame.sky.shines() && !paths_go_on(frame, step))
}

/// Density with which surfaces at this place of a path ask the sky: from where a path goes on, that finds what is not asked for.
pub fn sky_density(frame: &FrameView, step: Step) -> SkyDensity {
    if paths_go_on(frame, step) { SkyDensity::Peaks } else { SkyDensity::Whole }
}

/// Returns true if paths go on from a surface. From the last one they only collect emission: near an emitting
/// surface, asking alone would give nothing but noise.
pub fn paths_go_on(frame: &FrameView, step: Step) -> bool {
    !step.is_last() || !frame.emitters.is_empty()
}

/// Number of the light that a surface of `model` at `point` asks, and the probability with which it chose that one.
pub fn light_asked(frame: &FrameView, model: u32, point: Vec3, random: f32) -> (u32, f32) {
    frame
        .choose_light(model, point, random)
        .map_or((NO_LIGHT, 1.0), |light| (light.source as u32, light.chance))
}

/// Number of no light: of those that none lights.
pub const NO_LIGHT: u32 = u32::MAX;
