//! Settings that whoever renders a shot puts in place of the shot's own, in the words of shot files.

use std::path::Path;

use serde::Deserialize;

use super::settings::{Tables, settings};
use super::{Shot, lens};
use crate::scene::SceneError;
use crate::scene::keys::camera::{ShutterTable, StereoTable};
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::keys::{IndirectTable, OcclusionTable, OutputTable, RenderTable};
use crate::settings::{Build, DenoiseQuality, Settings};

/// Tables of a shot file that say how it is rendered, and nothing of what it shows.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SettingsFile {
    #[serde(default)]
    render: RenderTable,
    #[serde(default)]
    output: OutputTable,
    stereo: Option<At<StereoTable>>,
    shutter: Option<At<ShutterTable>>,
    #[serde(default)]
    indirect: IndirectTable,
    #[serde(default)]
    occlusion: OcclusionTable,
}

impl Shot {
    /// Its settings, and the quality of denoised pictures (none: no picture is denoised), as `tables` change them: the tables
    /// `[render]`, `[indirect]`, `[occlusion]`, `[output]`, `[stereo]` and `[shutter]` as a shot file has them. What they do not state
    /// stays as it is.
    ///
    /// # Errors
    /// Those of a shot file, with the line and the column in `tables`. Keys of `[render]` and `[output]` that are about the shot itself
    /// or about files are refused.
    pub fn settings_with(&self, tables: &str) -> Result<(Settings, Option<DenoiseQuality>), SceneError> {
        let text = TomlText { path: Path::new("settings"), text: tables };
        let file: SettingsFile = text.read()?;
        let SettingsFile { render, indirect, occlusion, output, stereo, shutter } = &file;
        refuse_others(text, render, output)?;
        let tables = Tables { render, indirect, occlusion, output, lights_state_rays: false };
        let mut settings = settings(text, &tables, &self.settings)?;
        if let Some(table) = stereo {
            settings.stereo = Some(lens::stereo(text, table, &self.scene.camera)?);
        }
        if let Some(table) = shutter {
            settings.shutter = Some(lens::shutter(text, table)?);
        }
        let quality = output.denoise_quality.unwrap_or(self.denoise_quality);
        Ok((settings, output.denoise.unwrap_or(self.denoise).then_some(quality)))
    }

    /// Chooses the build quality that renders the whole shot faster. It does not depend on which frames are requested: their pictures
    /// must not depend on which others are rendered with them.
    pub fn build_that_pays(&self, settings: &Settings) -> Build {
        self.rays(settings).map_or(Build::Best, |rays| Build::that_pays(rays, self.triangles()))
    }
}

/// Refuses keys that decide no picture, or more than one render.
fn refuse_others(text: TomlText<'_>, render: &RenderTable, output: &OutputTable) -> Result<(), SceneError> {
    let start = |is_there: bool| is_there.then_some(0..0);
    let of_shot = [
        ("frames", render.frames.as_ref().map(At::span)),
        ("rate", render.rate.as_ref().map(At::span)),
        ("cuts", render.cuts.as_ref().and_then(|cuts| cuts.first()).map(At::span)),
    ];
    let of_files = [
        ("path", output.path.as_ref().map(At::span)),
        ("exposure", output.exposure.as_ref().map(At::span)),
        ("view", start(output.view.is_some())),
        ("multipart", start(output.multipart.is_some())),
        ("compression", start(output.compression.is_some())),
    ];
    let of_shot = of_shot.into_iter().map(|found| (found, "is the shot's own, and no setting of a render"));
    let of_files =
        of_files.into_iter().map(|found| (found, "is about files: a frame's numbers do not depend on it"));
    for ((key, span), why) in of_shot.chain(of_files) {
        if let Some(span) = span {
            return Err(text.fault(span, format!("`{key}` {why}: take it out")));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use glam::DAffine3;

    use super::*;
    use crate::layers::Layers;
    use crate::scene::given::{self, Given, GivenMesh, GivenModel};
    use crate::settings::{Budget, Filter, Mode};

    fn shot() -> Shot {
        let mesh = GivenMesh {
            points: vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]],
            corners: vec![0, 1, 2],
            ..GivenMesh::default()
        };
        let model = GivenModel {
            name: String::from("triangle"),
            mesh: 0,
            places: vec![(1.0, DAffine3::IDENTITY)],
            is_visible: true,
            ray_visibility: Default::default(),
            linked: Default::default(),
            visible: Vec::new(),
        };
        let text = "[render]\nsize = [64, 48]\nfilter = \"tent\"\nfilter_radius = 2\nmode = \"full\"\n[output]\nlayers = [\"N\"]\n\
                    denoise_quality = \"fast\"\n[indirect]\npaths = 7\nbudget = \"full\"\n\
                    [[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n";
        given::shot(text, Given { meshes: vec![mesh.into()], models: vec![model] }, true).unwrap()
    }

    #[test]
    fn what_is_not_stated_stays_as_it_is() {
        let shot = shot();
        assert_eq!(shot.settings_with("").unwrap(), (shot.settings.clone(), None));
        let (settings, denoise) = shot
            .settings_with("[render]\nsamples = 3\n[output]\ndenoise = true\n[occlusion]\nrays = 5")
            .unwrap();
        assert_eq!((settings.samples, settings.occlusion_rays, denoise), (3, 5, Some(DenoiseQuality::Fast)));
        assert_eq!(settings, Settings { samples: 3, occlusion_rays: 5, ..shot.settings.clone() });
        assert_eq!((settings.width, settings.paths, settings.mode), (64, 7, Mode::Full));
        assert_eq!(
            (settings.budget, settings.layers, settings.filter_radius),
            (Budget::Full, Layers::NORMAL, Some(2.0))
        );
        let (settings, _) = shot.settings_with("[render]\nfilter = \"gaussian\"").unwrap();
        assert_eq!(
            (settings.filter, settings.filter_radius),
            (Filter::Gaussian, None),
            "each filter has its own radius"
        );
    }

    #[test]
    fn what_is_no_setting_of_a_render_is_refused() {
        let shot = shot();
        for (text, words) in [
            ("[render]\ncuts = [3]", "`cuts` is the shot's own"),
            ("[render]\nframes = \"1-3\"", "`frames` is the shot's own"),
            ("[output]\ncompression = \"zip\"", "`compression` is about files"),
            ("[[model]]\nobj = \"a.obj\"", "unknown key `model`"),
            ("[render]\nsamples = { min = 1, max = 4 }", "only the filter `box`"),
            ("[stereo]\nseparation = -1", "[stereo]"),
        ] {
            let error = shot.settings_with(text).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
