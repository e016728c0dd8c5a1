//! Choice of the one light source that a surface on a path asks for light.
//!
//! The shot's lights, the sky and emitting surfaces are equally likely; among lights their
//! [chances](crate::shade::light_chances::LightChances) decide.

use glam::Vec3;

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

/// Kinds of light sources that the surfaces on paths choose among.
#[derive(Debug, Clone, Copy)]
pub struct Kinds {
    lights: bool,
    sky: bool,
    emitters: bool,
}

impl Kinds {
    /// Those of surfaces at this place of a path.
    pub fn of(frame: &FrameView, step: Step) -> Self {
        let (sky, emitters) = (asks_sky(frame, step), frame.emitters.are_asked());
        Self { lights: !frame.pose.lights.is_empty(), sky, emitters }
    }

    /// Probability of asking lights, the sky, and emitting surfaces.
    pub fn chances(self) -> [f32; 3] {
        let count = self.count();
        [self.lights, self.sky, self.emitters].map(|is_asked| if is_asked { 1.0 / count as f32 } else { 0.0 })
    }

    fn count(self) -> u32 {
        [self.lights, self.sky, self.emitters].into_iter().map(u32::from).sum()
    }

    /// Chooses a light source for a surface at `point` (world space) by a `random` number from 0 to below 1.
    /// Returns also the probability of that choice.
    pub fn choose(self, frame: &FrameView, point: Vec3, random: f32) -> (LightChoice, f32) {
        let count = self.count();
        if count == 0 {
            return (LightChoice::Nothing, 1.0);
        }
        let at = random * count as f32;
        let number = (at as u32).min(count - 1);
        let chance = 1.0 / count as f32;
        // looked up: no processor foresees a random choice
        let first = if self.sky { LightChoice::Sky } else { LightChoice::Emitter };
        let kinds = match self.lights {
            true => [LightChoice::Light(0), first, LightChoice::Emitter],
            false => [first, LightChoice::Emitter, LightChoice::Emitter],
        };
        let kind = kinds[number as usize];
        if frame.light_chances.are_many() && kind == LightChoice::Light(0) {
            // the rest of the number that chose the kind is as random as the number was
            let chosen = frame.light_chances.choose(point, at);
            return (LightChoice::Light(chosen.source as u32), chance * chosen.chance);
        }
        (kind, chance)
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
