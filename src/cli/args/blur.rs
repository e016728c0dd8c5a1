//! Options of motion blur and depth of field: as typed, and validated.

use clap::Args;

use crate::exposure::{Curve, MOST_EXPOSURES, Shutter};
use crate::scene::Scene;
use crate::settings::Settings;

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
pub struct BlurArgs {
    /// Largest number of exposures, each with its own part of the shutter and of the lens, among which the
    /// samples of a pixel are divided; in shots with a shutter or a lens [default: the shot's, or as many as suit it]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_EXPOSURES)))]
    exposures: Option<u32>,

    /// When the shutter is open, in frames from each frame's own time, as -0.25,0.25 (180 degrees); a curve of the shot's stays
    /// [default: the shot's]
    #[arg(long, value_name = "OPEN,CLOSE", value_parser = shutter, allow_hyphen_values = true)]
    shutter: Option<Shutter>,

    /// Render sharp frames, without a shutter and a lens, whatever the shot says
    #[arg(long, conflicts_with_all = ["exposures", "shutter"])]
    sharp: bool,
}

impl BlurArgs {
    /// Applies the arguments to the `settings` and the `scene` of a shot.
    pub fn settle(&self, settings: Settings, scene: &mut Scene) -> Settings {
        if self.sharp {
            scene.camera.lens.aperture = None;
            return Settings { shutter: None, ..settings };
        }
        // the curve goes over to other times
        let curve = settings.shutter.as_ref().map_or(Curve::CONSTANT, |shutter| shutter.curve.clone());
        let stated = self.shutter.clone().map(|shutter| Shutter { curve, ..shutter });
        let shutter = stated.or(settings.shutter);
        Settings { exposures: self.exposures.or(settings.exposures), shutter, ..settings }
    }
}

fn shutter(text: &str) -> Result<Shutter, String> {
    let both = text.split_once(',').map(|(open, close)| (open.trim().parse(), close.trim().parse()));
    let Some((Ok(open), Ok(close))) = both else {
        return Err(String::from(
            "must be two times with a comma between them, in frames from the frame's own, like -0.25,0.25",
        ));
    };
    let shutter = Shutter::new(open, close);
    shutter.fault().map_or(Ok(shutter), Err)
}
