//! Options of two eyes: as typed, and validated.

use clap::Args;

use super::values::radius;
use crate::cli::failure::Failure;
use crate::layers::Layers;
use crate::scene::Scene;
use crate::scene::camera::Projection;
use crate::settings::Settings;
use crate::stereo::Stereo;

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
pub struct StereoArgs {
    /// Render two eyes, the right one from the left one's samples, into multi-view EXR files. Shots with [stereo] do so in any
    /// case; others need --separation, which implies it
    #[allow(rustdoc::broken_intra_doc_links, reason = "a table in brackets is no link")]
    #[arg(long, conflicts_with = "mono")]
    stereo: bool,

    /// Render one eye, whatever the shot says
    #[arg(long, conflicts_with_all = ["separation", "convergence"])]
    mono: bool,

    /// From the left eye to the right one, in the units of the models; implies --stereo [default: the shot's]
    #[arg(long, value_name = "LENGTH", value_parser = radius)]
    separation: Option<f64>,

    /// Distance from the camera at which the pictures of both eyes agree, in the units of the models; implies --stereo
    /// [default: the shot's, or infinity]
    #[arg(long, value_name = "LENGTH", value_parser = radius)]
    convergence: Option<f64>,
}

impl StereoArgs {
    /// Settles the two eyes, if there are any; `of_shot`: those of the file.
    pub fn settle(&self, of_shot: Option<Stereo>) -> Result<Option<Stereo>, Failure> {
        let is_asked_for = self.stereo || self.separation.is_some() || self.convergence.is_some();
        if self.mono || !is_asked_for && of_shot.is_none() {
            return Ok(None);
        }
        let separation = self.separation.or(of_shot.map(|stereo| stereo.separation)).ok_or_else(|| {
            Failure::Usage(String::from(
                "two eyes need the distance between them: add --separation, in the units of the models (0.065 for metres), \
                 or [stereo] to the shot",
            ))
        })?;
        let convergence = self.convergence.or(of_shot.and_then(|stereo| stereo.convergence));
        let stereo = Stereo { separation, convergence };
        match stereo.fault() {
            Some(fault) => Err(Failure::Usage(fault)),
            None => Ok(Some(stereo)),
        }
    }
}

/// Refuses two eyes if `scene` cannot have them, or if channels of a file would get names that are too long.
pub fn check(settings: &Settings, scene: &Scene, is_multipart: bool) -> Result<(), Failure> {
    /// Maximum length of a light group's name, bytes: of 31, `light_` and `.right.R` take 14.
    const LONGEST_GROUP: usize = 17;
    if settings.stereo.is_none() {
        return Ok(());
    }
    if scene.camera.projection() == Projection::Orthographic {
        return Err(Failure::Usage(format!("--stereo: {}", Stereo::ORTHOGRAPHIC)));
    }
    let names_groups = settings.layers.has(Layers::LIGHT) && !is_multipart;
    let groups = scene.lights.iter().filter_map(|light| light.group.as_deref());
    match groups.into_iter().find(|group| names_groups && group.len() > LONGEST_GROUP) {
        Some(group) => Err(Failure::Usage(format!(
            "--stereo: the group of lights `{group}` has a name of more than {LONGEST_GROUP} bytes, too long for the channel \
             `light_{group}.right.R` of a file in one part: add --multipart, or take a shorter `group`"
        ))),
        None => Ok(()),
    }
}
