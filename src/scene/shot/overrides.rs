//! Settings that whoever renders a shot puts in place of the shot's own, in the words of shot files.

use std::path::Path;

use serde::Deserialize;

use super::settings::{Tables, frames, settings};
use super::{Shot, lens};
use crate::scene::SceneError;
use crate::scene::keys::camera::{ShutterTable, StereoTable};
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::keys::values::look;
use crate::scene::keys::{IndirectTable, OcclusionTable, OutputTable, RenderTable};
use crate::settings::{Build, FileFormat, Settings};

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
    /// Replaces settings by those of `tables`: the tables `[render]`, `[indirect]`, `[occlusion]`, `[output]`, `[stereo]` and
    /// `[shutter]` as a shot file has them. What they do not state stays as it is.
    ///
    /// # Errors
    /// Those of a shot file, with the line and the column in `tables`. The frame rate, the output path and cuts are the shot's
    /// own: these keys are refused. The shot is as it was.
    pub fn set(&mut self, tables: &str) -> Result<(), SceneError> {
        let text = TomlText { path: Path::new("settings"), text: tables };
        let file: SettingsFile = text.read()?;
        let SettingsFile { render, indirect, occlusion, output, stereo, shutter } = &file;
        refuse_the_shots_own(text, render, output)?;
        let tables = Tables { render, indirect, occlusion, output };
        let mut settings = settings(text, &tables, &self.settings)?;
        if let Some(table) = stereo {
            settings.stereo = Some(lens::stereo(text, table, &self.scene.camera)?);
        }
        if let Some(table) = shutter {
            settings.shutter = Some(lens::shutter(text, table)?);
        }
        let look = look(text, output, self.look)?;
        if let Some(frames) = frames(text, render)? {
            (self.frames, self.says_frames) = (frames, true);
        }
        self.settings = settings;
        self.look = look;
        self.format = FileFormat {
            multipart: output.multipart.unwrap_or(self.format.multipart),
            compression: output.compression.unwrap_or(self.format.compression),
        };
        self.denoise = output.denoise.unwrap_or(self.denoise);
        self.denoise_quality = output.denoise_quality.unwrap_or(self.denoise_quality);
        Ok(())
    }

    /// Chooses the build quality that renders the whole shot faster. It does not depend on which frames are requested: their pictures
    /// must not depend on which others are rendered with them.
    pub fn build_that_pays(&self, settings: &Settings) -> Build {
        self.rays(settings).map_or(Build::Best, |rays| Build::that_pays(rays, self.triangles()))
    }
}

/// Refuses keys of settings that decide more than how a shot is rendered.
fn refuse_the_shots_own(
    text: TomlText<'_>,
    render: &RenderTable,
    output: &OutputTable,
) -> Result<(), SceneError> {
    let cuts = render.cuts.as_ref().and_then(|cuts| cuts.first()).map(At::span);
    let all = [
        ("rate", render.rate.as_ref().map(At::span)),
        ("cuts", cuts),
        ("path", output.path.as_ref().map(At::span)),
    ];
    match all.into_iter().find_map(|(key, span)| Some((key, span?))) {
        Some((key, span)) => {
            Err(text.fault(span, format!("`{key}` is the shot's own, and no setting of a render")))
        }
        None => Ok(()),
    }
}
