//! The exposures of a shot's frames, and whether the camera is at rest through them.

use crate::changes::Direction;
use crate::exposure::Exposures;
use crate::pose::CameraPose;
use crate::scene::Scene;
use crate::settings::{BasePlace, Mode, Settings};

/// The exposures of a frame of `scene`, if it has more to it than one picture at its own time.
pub fn exposures(scene: &Scene, settings: &Settings) -> Option<Exposures> {
    let Settings { shutter, exposures, filter, .. } = settings;
    let has_lens = scene.camera.has_lens();
    if shutter.is_none() && !has_lens {
        return None;
    }
    let is_open = shutter.is_some_and(|shutter| shutter.close > shutter.open);
    let count = if is_open || has_lens { *exposures } else { 1 };
    // a wider filter weighs samples by where they are, and would be made wider still
    Some(Exposures::new(count, *shutter, &scene.camera.cuts, filter.is_of_one_pixel()))
}

/// Returns true if the camera is in one place for all exposures of `frame` and of the next frame of the shot in `direction`.
pub fn rests(exposures: &Exposures, scene: &Scene, frame: i32, direction: Direction) -> bool {
    let clock = &exposures.clock;
    let at = |moment| {
        let time = clock.time(moment);
        (CameraPose::new(&scene.camera, time), scene.camera.lens_at(time))
    };
    let next = match direction {
        Direction::Forward => frame.saturating_add(1),
        Direction::Backward => frame.saturating_sub(1),
    };
    let [first, last] = [clock.moment(frame.min(next), 0), clock.moment(frame.max(next), usize::MAX >> 1)];
    let camera = at(first);
    (first..=last).all(|moment| at(moment) == camera)
}

/// Returns true if frames before base frames are inferred from them, as those after them are.
pub fn has_two_sides(settings: &Settings) -> bool {
    settings.base_place == BasePlace::Middle && settings.mode != Mode::Full
}

/// Number of sample stores of one eye in the worst of `frames`: one for each exposure where the camera rests.
pub fn most_stores(scene: &Scene, settings: &Settings, frames: impl Iterator<Item = i32>) -> usize {
    /// So many are looked at; of others the worst is assumed.
    const MOST_FRAMES: usize = 10_000;
    let Some(exposures) = exposures(scene, settings).filter(|_| settings.mode != Mode::Full) else {
        return 1;
    };
    let both = [Direction::Forward, Direction::Backward];
    let directions = if has_two_sides(settings) { &both[..] } else { &both[..1] };
    let rests = |frame| directions.iter().any(|direction| rests(&exposures, scene, frame, *direction));
    let mut rest = frames.enumerate().map(|(number, frame)| number >= MOST_FRAMES || rests(frame));
    if rest.any(|rests| rests) { exposures.all.len() } else { 1 }
}
