//! The exposures of a shot's frames, and how they divide the samples.

use crate::changes::anything_changes;
use crate::exposure::{Exposures, Shutter, Strata};
use crate::samples::TagLayout;
use crate::scene::Scene;
use crate::settings::{BasePlace, Budget, Mode, Refinement, Reuse, Settings};

/// The exposures of a frame of `scene`, if it has more to it than one picture at its own time.
pub fn exposures(scene: &Scene, settings: &Settings) -> Option<Exposures> {
    let Settings { shutter, exposures, .. } = settings;
    let has_lens = scene.camera.has_lens();
    if shutter.is_none() && !has_lens {
        return None;
    }
    let is_open = shutter.as_ref().is_some_and(Shutter::is_open);
    let most = exposures.unwrap_or(if is_open || anything_changes(scene) { FEW } else { MANY });
    let strata = if is_open || has_lens { Strata::new(fewest_samples(settings), most) } else { Strata::ONE };
    Some(Exposures::new(strata, shutter.as_ref(), &scene.camera.cuts))
}

/// Largest number of exposures where the shot does not say: samples that are few in each exposure cost more rays, and those
/// whose moments lie far apart show other surfaces where much moves.
const FEW: u32 = 4;

/// The same where only a lens blurs, and nothing moves: samples of one exposure see through a smaller part of the lens, and show each
/// other's surfaces.
const MANY: u32 = 16;

/// Samples along a pixel's edge of the coarsest level: more than one, if there are finer ones, or nothing could be divided.
fn fewest_samples(settings: &Settings) -> u32 {
    match settings.refinement {
        Some(Refinement { most, .. }) if settings.samples == 1 && most > 1 => 2,
        _ => settings.samples,
    }
}

/// Settings of each picture of a frame of `scene`: of its exposures each has its part of the samples. And how these are divided. What is said
/// of a shot, in words or in files, follows from the shot's own `settings` instead.
pub fn picture_settings(scene: &Scene, settings: &Settings) -> (Settings, Strata) {
    let strata = exposures(scene, settings).map_or(Strata::ONE, |exposures| exposures.strata);
    (divided(settings, strata), strata)
}

/// `settings` of one of several exposures.
pub fn divided(settings: &Settings, strata: Strata) -> Settings {
    if strata == Strata::ONE {
        return settings.clone();
    }
    let samples = fewest_samples(settings) / strata.across;
    let part = |refinement: Refinement| Refinement { most: refinement.most / strata.across, ..refinement };
    let budget = match settings.budget {
        Budget::Rays(rays) => Budget::Rays((rays / u64::from(strata.count())).max(1)),
        other => other,
    };
    let refinement = settings.refinement.map(part).filter(|refinement| refinement.most > samples);
    Settings { samples, refinement, budget, ..settings.clone() }
}

/// Of so many `exposures`, the number of those that [lend](crate::frame::reuse::beside) each other samples of a `layout`: all of them or 1. What
/// samples keep holds for all exposures where nothing moves but the camera; and where they gather no light, finding one to share takes
/// about as long as making one.
pub fn lenders(settings: &Settings, layout: &TagLayout, exposures: usize) -> usize {
    let gathers = layout.paths > 0 || layout.reflections > 0 || layout.occlusion_rays > 0;
    let lend = gathers && !layout.expires && settings.reuse == Reuse::Target && settings.mode != Mode::Full;
    if lend { exposures } else { 1 }
}

/// Returns true if frames before base frames are inferred from them, as those after them are.
pub fn has_two_sides(settings: &Settings) -> bool {
    settings.base_place == BasePlace::Middle && settings.mode != Mode::Full
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposures_have_their_part_of_the_samples() {
        let settings = |samples, most: Option<u32>| {
            let refinement = most.map(|most| Refinement { most, threshold: 0.1 });
            Settings { samples, refinement, budget: Budget::Rays(900), ..Settings::default() }
        };
        let levels = |settings: &Settings, exposures| {
            let strata = Strata::new(fewest_samples(settings), exposures);
            divided(settings, strata).levels().map(|samples| samples * strata.across).collect::<Vec<_>>()
        };
        assert_eq!(levels(&settings(6, None), 9), [6]);
        assert_eq!(levels(&settings(3, Some(12)), 9), [3, 6, 12]);
        assert_eq!(levels(&settings(1, Some(4)), 9), [2, 4]);
        assert_eq!(levels(&settings(1, Some(2)), 9), [2]);
        assert_eq!(levels(&settings(1, Some(4)), 1), [1, 2, 4]);
        let part = divided(&settings(3, Some(12)), Strata { across: 3 });
        assert_eq!((part.budget, part.samples_a_pixel()), (Budget::Rays(100), 1 + 4 + 16));
    }
}
