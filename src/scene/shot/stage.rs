//! Reads what of a USD file a shot shows.

use crate::scene::SceneError;
use crate::scene::frames::Frames;
use crate::scene::import::usd::{StageChoice, VariantChoice, prim_path};
use crate::scene::keys::stage::StageTable;
use crate::scene::keys::toml_text::{At, TomlText};

/// Reads the table `stage` of a model; without one all of the file is read.
///
/// # Errors Names that are none, and an empty mask.
pub fn choice(text: TomlText<'_>, table: Option<&StageTable>) -> Result<StageChoice, SceneError> {
    let Some(StageTable { variants, purposes, mask, unloaded, time_samples }) = table else {
        return Ok(StageChoice::default());
    };
    let variants = variants.iter().flatten().map(|variant| {
        VariantChoice::parse(variant.get_ref())
            .map_err(|why| text.fault(variant.span(), format!("`variants`: {why}")))
    });
    let paths = |key: &'static str, paths: &[At<String>]| {
        let path = |path: &At<String>| {
            prim_path(path.get_ref()).map_err(|why| text.fault(path.span(), format!("`{key}`: {why}")))
        };
        paths.iter().map(path).collect::<Result<Vec<_>, SceneError>>()
    };
    if let Some(mask) = mask.as_ref().filter(|mask| mask.get_ref().is_empty()) {
        return Err(text.bad("mask", mask, "names no prim, so that nothing would be read: take it out"));
    }
    let frames = time_samples.as_ref().map(|range| {
        let frames = Frames::parse(range.get_ref())
            .map_err(|why| text.fault(range.span(), format!("`time_samples`: {why}")))?;
        Ok(frames.ends())
    });
    Ok(StageChoice {
        variants: variants.collect::<Result<_, SceneError>>()?,
        purposes: purposes.as_ref().map(|purposes| purposes.iter().copied().collect()),
        mask: mask.as_ref().map_or(Ok(Vec::new()), |mask| paths("mask", mask.get_ref()))?,
        unloaded: unloaded.as_ref().map_or(Ok(Vec::new()), |unloaded| paths("unloaded", unloaded))?,
        frames: frames.transpose()?,
    })
}
