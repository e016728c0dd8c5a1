//! Reads `[render]`, `[indirect]`, `[occlusion]` and `[output]` of a shot file into settings: each value
//! checked.

use crate::exposure::MOST_EXPOSURES;
use crate::layers::{Layers, UnknownLayer};
use crate::scene::dicing::{DEFAULT_EDGE, DEFAULT_TRIANGLES, Dicing, MOST_DICED};
use crate::scene::keys::samples::{AdaptiveTable, SamplesValue};
use crate::scene::keys::toml_text::{At, List, TomlText};
use crate::scene::keys::{BudgetValue, IndirectTable, OcclusionTable, OutputTable, Rate, RenderTable};
use crate::scene::render_space::Extent;
use crate::scene::{Frames, SceneError};
use crate::settings::{
    Budget, Filter, Free, LONGEST_SIDE, MOST_OCCLUSION_RAYS, MOST_OVERSCAN, MOST_PATHS, MOST_REFLECTIONS,
    MOST_SAMPLES, MOST_TREE_MEMORY, Refinement, RefinementError, Settings, Wanted,
};

/// Tables of settings, as they are written.
pub struct Tables<'a> {
    /// `[render]`
    pub render: &'a RenderTable,
    /// `[indirect]`
    pub indirect: &'a IndirectTable,
    /// `[occlusion]`
    pub occlusion: &'a OcclusionTable,
    /// `[output]`
    pub output: &'a OutputTable,
    /// True if any light states its shadow rays.
    pub lights_state_rays: bool,
}

/// Reads settings. Those whose keys are not there stay as they are `before`.
pub fn settings(text: TomlText<'_>, tables: &Tables<'_>, before: &Settings) -> Result<Settings, SceneError> {
    let Tables { render: table, indirect, occlusion, output, .. } = tables;
    let whole = |key, value: &Option<At<i64>>, before, range| {
        value.as_ref().map_or(Ok(before), |value| text.whole(key, value, range))
    };
    let sides = 1..i64::from(LONGEST_SIDE) + 1;
    let (width, height) = match &table.size {
        Some(List([width, height])) => {
            (text.whole("size", width, sides.clone())?, text.whole("size", height, sides)?)
        }
        None => (before.width, before.height),
    };
    let filter = table.filter.unwrap_or(before.filter);
    let (samples, refinement) = samples(text, table, filter, before)?;
    let settings = Settings {
        width,
        height,
        samples,
        refinement,
        overscan: whole("overscan", &table.overscan, before.overscan, 0..i64::from(MOST_OVERSCAN) + 1)?,
        filter,
        filter_radius: filter_radius(text, table, filter, before)?,
        depth: whole("depth", &table.depth, before.depth, 0..65)?,
        reflections: whole(
            "reflections",
            &table.reflections,
            before.reflections,
            0..i64::from(MOST_REFLECTIONS) + 1,
        )?,
        caustics: table.caustics.unwrap_or(before.caustics),
        clamp: clamp(text, table)?.or(before.clamp),
        only_lights: table
            .only_lights
            .as_ref()
            .map(|group| group.get_ref().clone())
            .or(before.only_lights.clone()),
        tree_memory: whole(
            "tree_memory",
            &table.tree_memory,
            before.tree_memory,
            0..i64::from(MOST_TREE_MEMORY) + 1,
        )?,
        paths: whole("paths", &indirect.paths, before.paths, 0..i64::from(MOST_PATHS) + 1)?,
        paths_per_frame: whole(
            "paths_per_frame",
            &indirect.paths_per_frame,
            before.paths_per_frame,
            1..i64::from(MOST_PATHS) + 1,
        )?,
        budget: budget(text, indirect)?.unwrap_or(before.budget),
        bounces: whole("bounces", &indirect.bounces, before.bounces, 0..65)?,
        volume_bounces: whole("volume_bounces", &indirect.volume_bounces, before.volume_bounces, 0..65)?,
        volume_samples: whole("volume_samples", &table.volume_samples, before.volume_samples, 1..65)?,
        occlusion_rays: whole(
            "rays",
            &occlusion.rays,
            before.occlusion_rays,
            1..i64::from(MOST_OCCLUSION_RAYS) + 1,
        )?,
        occlusion_radius: occlusion_radius(text, occlusion)?.unwrap_or(before.occlusion_radius),
        exposures: match &table.exposures {
            Some(most) => Some(text.whole("exposures", most, 1..i64::from(MOST_EXPOSURES) + 1)?),
            None => before.exposures,
        },
        mode: table.mode.unwrap_or(before.mode),
        reuse: table.reuse.unwrap_or(before.reuse),
        base_every: whole("base_every", &table.base_every, before.base_every, 0..1_000_001)?,
        base_place: table.base_place.unwrap_or(before.base_place),
        layers: layers(text, output)?.unwrap_or(before.layers),
        background: output.background.unwrap_or(before.background),
        wanted: wanted(text, tables, before)?,
        ..before.clone()
    };
    if let Some(overscan) = table.overscan.as_ref().filter(|_| !settings.fits()) {
        let message =
            format!("makes a picture of {width}x{height} longer than {LONGEST_SIDE} pixels on a side");
        return Err(text.bad("overscan", overscan, &message));
    }
    Ok(settings)
}

/// Reads how finely what is subdivided or displaced is diced.
pub fn dicing(text: TomlText<'_>, table: &RenderTable) -> Result<Dicing, SceneError> {
    let is_edge = |edge: f64| (0.05..=1000.0).contains(&edge);
    let edge = table.dicing.as_ref();
    let edge =
        edge.map(|edge| text.number("dicing", edge, "from 0.05 to 1000 pixels", is_edge)).transpose()?;
    let triangles = table.dicing_triangles.as_ref();
    let most = i64::from(MOST_DICED) + 1;
    let triangles = triangles.map(|count| text.whole("dicing_triangles", count, 1..most)).transpose()?;
    Ok(Dicing {
        edge: edge.unwrap_or(DEFAULT_EDGE),
        triangles: triangles.map_or(DEFAULT_TRIANGLES, u64::from),
    })
}

/// Reads the error that is wanted. Counts that are stated beside it stay as they are.
fn wanted(text: TomlText<'_>, tables: &Tables<'_>, before: &Settings) -> Result<Option<Wanted>, SceneError> {
    let Tables { render, indirect, lights_state_rays, .. } = tables;
    let is_error = |error: f64| Wanted::RANGE.contains(&(error as f32));
    let error =
        |error: &At<f64>| text.number("error", error, "a share from 0.001 to 0.9, such as 0.03", is_error);
    let stated = render.error.as_ref().map(error).transpose()?.map(|error| error as f32);
    let Some(error) = stated.or(before.wanted.map(|wanted| wanted.error)) else { return Ok(None) };
    let free = before.wanted.map_or(Free::ALL, |wanted| wanted.free);
    let free = Free {
        samples: free.samples && render.samples.is_none(),
        paths: free.paths && indirect.paths.is_none(),
        reflections: free.reflections && render.reflections.is_none(),
        shadow_rays: free.shadow_rays && !lights_state_rays,
    };
    Ok(Some(Wanted { error, free }))
}

/// Reads the frames to render, if they are stated.
pub fn frames(text: TomlText<'_>, table: &RenderTable) -> Result<Option<Frames>, SceneError> {
    let read = |frames: &At<String>| {
        Frames::parse(frames.get_ref())
            .map_err(|message| text.fault(frames.span(), format!("`frames`: {message}")))
    };
    table.frames.as_ref().map(read).transpose()
}

/// Reads the frame rate, if it is stated.
pub fn rate(text: TomlText<'_>, table: &RenderTable) -> Result<Option<(i32, u32)>, SceneError> {
    let read = |rate: &At<Rate>| {
        let wanted = "must be frames per second above 0: a whole number or a fraction like \"24000/1001\"";
        fraction(rate.get_ref()).ok_or_else(|| text.bad("rate", rate, wanted))
    };
    table.rate.as_ref().map(read).transpose()
}

/// Reads N, for N x N samples a pixel, and the refinement, which `filter` must be able to mix.
fn samples(
    text: TomlText<'_>,
    table: &RenderTable,
    filter: Filter,
    before: &Settings,
) -> Result<(u32, Option<Refinement>), SceneError> {
    let Some(samples) = &table.samples else {
        let checked = before.refinement.map(|refinement| refinement.checked(before.samples, filter));
        let refinement =
            checked.transpose().map_err(|error| text.fault(0..0, format!("`filter`: {error}")))?;
        return Ok((before.samples, refinement));
    };
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
                Ok((min, Some(Refinement { most, threshold }.checked(min, filter)?)))
            });
            refinement.map_err(|error| bad(format!("= {{ min = {min}, max = {max} }}: {error}")))
        }
    }
}

/// Reads the memory for textures, in bytes, if the shot states it.
pub fn texture_memory(text: TomlText<'_>, table: &RenderTable) -> Result<Option<u64>, SceneError> {
    let mib = table
        .texture_memory
        .as_ref()
        .map(|value| text.whole("texture_memory", value, 0..i64::from(MOST_TREE_MEMORY) + 1));
    Ok(mib.transpose()?.map(|mib| u64::from(mib) << 20))
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

fn budget(text: TomlText<'_>, table: &IndirectTable) -> Result<Option<Budget>, SceneError> {
    let read = |budget: &At<BudgetValue>| match budget.get_ref() {
        BudgetValue::Rays(rays) => Ok(Budget::Rays(*rays)),
        BudgetValue::Text(stated) => {
            Budget::parse(stated).map_err(|error| text.bad("budget", budget, &error.to_string()))
        }
    };
    table.budget.as_ref().map(read).transpose()
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

fn filter_radius(
    text: TomlText<'_>,
    table: &RenderTable,
    filter: Filter,
    before: &Settings,
) -> Result<Option<f32>, SceneError> {
    let Some(radius) = &table.filter_radius else {
        // another filter has another radius
        return Ok(before.filter_radius.filter(|_| filter == before.filter));
    };
    if filter.is_of_one_pixel() {
        return Err(text.bad(
            "filter_radius",
            radius,
            "means nothing for `box` and `area`, which are a pixel: choose another `filter`",
        ));
    }
    let range = f64::from(Filter::LEAST_RADIUS)..=f64::from(Filter::LARGEST_RADIUS);
    let radius =
        text.number("filter_radius", radius, "from 0.5 to 4 pixels", |radius| range.contains(&radius))?;
    Ok(Some(radius as f32))
}

fn layers(text: TomlText<'_>, output: &OutputTable) -> Result<Option<Layers>, SceneError> {
    let Some(names) = &output.layers else { return Ok(None) };
    let all = names.iter().try_fold(Layers::NONE, |all, name| {
        let known = Layers::new([name.get_ref().as_str()]);
        let unknown =
            |name_of: &str| text.fault(name.span(), format!("`layers`: {}", UnknownLayer::new(name_of)));
        known.map(|layers| all.with(layers)).map_err(unknown)
    });
    all.map(Some)
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
