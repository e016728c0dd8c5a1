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
        let tables = Tables { render, indirect, occlusion, output };
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
