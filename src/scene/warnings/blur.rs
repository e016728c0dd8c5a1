//! Warns before rendering where a shot has a shutter or a lens, and too few samples to show them.

use crate::exposure::Shutter;
use crate::scene::Scene;
use crate::settings::Settings;

/// Warning about frames of `scene` that are sharp with these `settings`, although it is blurred.
pub fn warning(scene: &Scene, settings: &Settings) -> Option<String> {
    let is_open = settings.shutter.as_ref().is_some_and(Shutter::is_open);
    let what = match (is_open, scene.camera.has_lens()) {
        (false, false) => return None,
        (true, false) => "motion",
        (false, true) => "what is out of focus",
        (true, true) => "motion and what is out of focus",
    };
    (settings.levels().last() == Some(1) && settings.exposures > 1).then(|| {
        format!(
            "with one sample a pixel {what} shows without blur: exposures divide the samples of a pixel; take --samples 2 or \
             more, or --sharp"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::changes::world::scene;

    #[test]
    fn one_sample_has_no_blur() {
        let scene = scene(vec![], vec![]);
        let is_warned = |samples, exposures, is_blurred: bool| {
            let shutter = is_blurred.then(Shutter::default);
            warning(&scene, &Settings { samples, exposures, shutter, ..Settings::default() }).is_some()
        };
        assert!(is_warned(1, 16, true));
        assert!(!is_warned(2, 16, true) && !is_warned(1, 1, true) && !is_warned(1, 16, false));
    }
}
