//! Reads `[render]`, `[indirect]`, `[occlusion]` and `[output]` of a shot file into settings: each value
//! checked.

use crate::exposure::MOST_EXPOSURES;
use crate::layers::{Layers, UnknownLayer};
use crate::scene::keys::samples::{AdaptiveTable, SamplesValue};
use crate::scene::keys::toml_text::{At, List, TomlText};
use crate::scene::keys::{
    BudgetValue, IndirectTable, OcclusionTable, OutputTable, Rate, RenderTable, ShotFile,
};
use crate::scene::render_space::Extent;
use crate::scene::{Frames, SceneError};
use crate::settings::{
    Budget, Filter, LONGEST_SIDE, MOST_OCCLUSION_RAYS, MOST_OVERSCAN, MOST_PATHS, MOST_REFLECTIONS,
    MOST_SAMPLES, MOST_TREE_MEMORY, Refinement, RefinementError, Settings,
};

/// Reads the settings of a shot file, its frames, and its frame rate.
pub fn render(text: TomlText<'_>, file: &ShotFile) -> Result<(Settings, Frames, (i32, u32)), SceneError> {
    let ShotFile { render: table, indirect, occlusion, output, .. } = file;
    let whole = |key, value: &Option<At<i64>>, default, range| {
        value.as_ref().map_or(Ok(default), |value| text.whole(key, value, range))
    };
    let sides = 1..i64::from(LONGEST_SIDE) + 1;
    let default = Settings::default();
    let (width, height) = match &table.size {
        Some(List([width, height])) => {
            (text.whole("size", width, sides.clone())?, text.whole("size", height, sides)?)
        }
        None => (default.width, default.height),
    };
    let (samples, refinement) = samples(text, table)?;
    let settings = Settings {
        width,
        height,
        samples,
        refinement,
        overscan: whole("overscan", &table.overscan, default.overscan, 0..i64::from(MOST_OVERSCAN) + 1)?,
        filter: table.filter,
        filter_radius: filter_radius(text, table)?,
        depth: whole("depth", &table.depth, default.depth, 0..65)?,
        reflections: whole(
            "reflections",
            &table.reflections,
            default.reflections,
            0..i64::from(MOST_REFLECTIONS) + 1,
        )?,
        caustics: table.caustics,
        clamp: clamp(text, table)?,
        tree_memory: whole(
            "tree_memory",
            &table.tree_memory,
            default.tree_memory,
            0..i64::from(MOST_TREE_MEMORY) + 1,
        )?,
        paths: whole("paths", &indirect.paths, default.paths, 0..i64::from(MOST_PATHS) + 1)?,
        paths_per_frame: whole(
            "paths_per_frame",
            &indirect.paths_per_frame,
            default.paths_per_frame,
            1..i64::from(MOST_PATHS) + 1,
        )?,
        budget: budget(text, indirect)?,
        bounces: whole("bounces", &indirect.bounces, default.bounces, 0..65)?,
        occlusion_rays: whole(
            "rays",
            &occlusion.rays,
            default.occlusion_rays,
            1..i64::from(MOST_OCCLUSION_RAYS) + 1,
        )?,
        occlusion_radius: occlusion_radius(text, occlusion)?.unwrap_or(default.occlusion_radius),
        exposures: whole("exposures", &table.exposures, default.exposures, 1..i64::from(MOST_EXPOSURES) + 1)?,
        mode: table.mode,
        reuse: table.reuse,
        base_every: whole("base_every", &table.base_every, default.base_every, 0..1_000_001)?,
        base_place: table.base_place,
        layers: layers(text, output)?,
        ..default
    };
    if let Some(overscan) = table.overscan.as_ref().filter(|_| !settings.fits()) {
        let message =
            format!("makes a picture of {width}x{height} longer than {LONGEST_SIDE} pixels on a side");
        return Err(text.bad("overscan", overscan, &message));
    }
    let frames = match &table.frames {
        Some(frames) => Frames::parse(frames.get_ref())
            .map_err(|message| text.fault(frames.span(), format!("`frames`: {message}")))?,
        None => Frames::between(1, 1),
    };
    let rate = match &table.rate {
        Some(rate) => fraction(rate.get_ref()).ok_or_else(|| {
            text.bad(
                "rate",
                rate,
                "must be frames per second above 0: a whole number or a fraction like \"24000/1001\"",
            )
        })?,
        None => (24, 1),
    };
    Ok((settings, frames, rate))
}

/// Reads N, for N x N samples a pixel, and the refinement.
fn samples(text: TomlText<'_>, table: &RenderTable) -> Result<(u32, Option<Refinement>), SceneError> {
    let Some(samples) = &table.samples else { return Ok((Settings::default().samples, None)) };
    let bad = |message: String| text.bad("samples", samples, &message);
    let count = |number: i64| u32::try_from(number).ok().filter(|count| (1..=MOST_SAMPLES).contains(count));
    match samples.get_ref() {
        SamplesValue::Fixed(number) => {
            let wanted = || bad(format!("is {number}: it must be a whole number from 1 to {MOST_SAMPLES}"));
            Ok((count(*number).ok_or_else(wanted)?, None))
        }
        SamplesValue::Adaptive(AdaptiveTable { min, max, threshold }) => {
            let threshold = threshold.unwrap_or(f64::from(Refinement::THRESHOLD)) as f32;
            let refinement = count(*min).zip(count(*max)).ok_or(RefinementError::Bounds);
            let refinement = refinement.and_then(|(min, most)| {
                Ok((min, Some(Refinement { most, threshold }.checked(min, table.filter)?)))
            });
            refinement.map_err(|error| bad(format!("= {{ min = {min}, max = {max} }}: {error}")))
        }
    }
}

/// The frames that `cuts` lists.
pub fn marked_cuts(text: TomlText<'_>, table: &RenderTable) -> Result<Vec<i32>, SceneError> {
    let frame = |cut: &At<i64>| {
        let frame = i32::try_from(*cut.get_ref());
        frame.map_err(|_| text.bad("cuts", cut, "is not a frame's number: it must fit into 32 bits"))
    };
    table.cuts.iter().flatten().map(frame).collect()
}

fn clamp(text: TomlText<'_>, table: &RenderTable) -> Result<Option<f32>, SceneError> {
    // a limit that is 0 or infinite as a single float is no limit
    let fits = |limit: f64| limit as f32 > 0.0 && (limit as f32).is_finite();
    let read = |limit| text.number("clamp", limit, "a radiance above 0", fits);
    Ok(table.clamp.as_ref().map(read).transpose()?.map(|limit| limit as f32))
}

fn occlusion_radius(text: TomlText<'_>, table: &OcclusionTable) -> Result<Option<f64>, SceneError> {
    let wanted = "a length above 0, in the units of the models";
    let read = |radius| text.number("radius", radius, wanted, |radius| radius > 0.0);
    table.radius.as_ref().map(read).transpose()
}

/// Length of the rays of ambient occlusion in a shot that does not state it; `extent`: of all its models.
pub fn usual_occlusion_radius(extent: &Extent) -> f64 {
    extent.diagonal() / 10.0
}

fn budget(text: TomlText<'_>, table: &IndirectTable) -> Result<Budget, SceneError> {
    let Some(budget) = &table.budget else { return Ok(Budget::None) };
    match budget.get_ref() {
        BudgetValue::Rays(rays) => Ok(Budget::Rays(*rays)),
        BudgetValue::Text(stated) => {
            Budget::parse(stated).map_err(|error| text.bad("budget", budget, &error.to_string()))
        }
    }
}

fn fraction(rate: &Rate) -> Option<(i32, u32)> {
    let (above, below) = match rate {
        Rate::Whole(rate) => (i32::try_from(*rate).ok()?, 1),
        Rate::Text(text) => {
            let (above, below) = text.split_once('/').unwrap_or((text, "1"));
            (above.trim().parse().ok()?, below.trim().parse().ok()?)
        }
    };
    (above > 0 && below > 0).then_some((above, below))
}

fn filter_radius(text: TomlText<'_>, table: &RenderTable) -> Result<Option<f32>, SceneError> {
    let Some(radius) = &table.filter_radius else { return Ok(None) };
    if table.filter == Filter::Box {
        return Err(text.bad(
            "filter_radius",
            radius,
            "means nothing for the box, which is a pixel: choose another `filter`",
        ));
    }
    let range = f64::from(Filter::LEAST_RADIUS)..=f64::from(Filter::LARGEST_RADIUS);
    let radius =
        text.number("filter_radius", radius, "from 0.5 to 4 pixels", |radius| range.contains(&radius))?;
    Ok(Some(radius as f32))
}

fn layers(text: TomlText<'_>, output: &OutputTable) -> Result<Layers, SceneError> {
    let Some(names) = &output.layers else { return Ok(Layers::USUAL) };
    names.iter().try_fold(Layers::NONE, |all, name| {
        let known = Layers::new([name.get_ref().as_str()]);
        let unknown =
            |name_of: &str| text.fault(name.span(), format!("`layers`: {}", UnknownLayer::new(name_of)));
        known.map(|layers| all.with(layers)).map_err(unknown)
    })
}

/// Path of the frames, unless it is empty.
pub fn output(text: TomlText<'_>, path: Option<At<String>>) -> Result<Option<String>, SceneError> {
    match path {
        Some(path) if path.get_ref().trim().is_empty() => {
            Err(text.bad("path", &path, "is empty: give a file name like \"out/name.####.exr\""))
        }
        path => Ok(path.map(At::into_inner)),
    }
}
