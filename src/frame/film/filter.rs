//! Filtering: samples to pixels (the paper's "Filtering").
//!
//! Each tile writes its own pixels into its [`Window`] of the film. Where the filter is wider than a pixel,
//! colours stay sums in a [`TileFilm`], halo included, until [`develop`](super::develop) makes pixels of
//! them.
//!
//! Only colours are filtered here; values that must not be mixed are in [`pixels`](super::pixels).

use super::areas::Areas;
use super::mattes::{ids_of_cells, rank_boxes};
use super::pixels::{OLDEST, Planes, choose_nearest, count, reduce, take_data};
use super::reach::{Spread, Weighing};
use super::rims::Rims;
use super::spread::{TileFilm, spread};
use super::variance::pixel_variances;
use crate::cryptomatte::{Id, Kind, Mattes};
use crate::frame::planes::channels::{
    Channel, MATTE_PLANES, NonZeroPlanes, Picture, PlaneSource, data, matte_planes, sums,
};
use crate::frame::planes::window::Window;
use crate::frame::reuse::candidates::REACH;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::placed::PlacedTile;
use crate::frame::surface::radiance::{Light, Radiance};
use crate::frame::surface::ray_tally::CellRays;
use crate::frame::surface::trace_scratch::TraceScratch;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::layers::Layers;
use crate::samples::{BACKGROUND, CELLS, Column, EMPTY, Tile};
use crate::scene::{Mist, MistFalloff};
use crate::settings::Backdrop;

/// Scratch memory of a worker for this phase, by cell where nothing else is said.
#[derive(Debug)]
pub struct Filtering {
    /// Share of what is behind the picture that is hidden.
    alpha: Column<f32>,
    /// Albedo; 0 for the background.
    albedo: Light,
    /// Share of the directions around that is open; 1 for the background.
    openness: Column<f32>,
    /// Distance along the view axis, in the units of the shot's files; 0 for the background.
    depth: Column<f32>,
    /// How much mist is before the sample; 1 for the background.
    mist: Column<f32>,
    /// Variance of the cell's pixel, from [`pixel_variances`].
    variance: Column<f32>,
    /// Place of the sample, in cells from the tile's corner.
    x: Column<f32>,
    y: Column<f32>,
    /// Where samples count, for a filter wider than a pixel.
    rims: Rims,
    /// Areas of samples, for a filter that is by area.
    areas: Areas,
    /// Cell whose sample is nearest to the pixel's centre, for each pixel.
    nearest: Vec<u16>,
    /// Sums of the tile's pixels, for a filter without a halo.
    sums: Planes<{ sums::COUNT }>,
    /// Data of the tile's pixels.
    data: Planes<{ data::COUNT }>,
    /// Mattes of the tile's pixels, for a filter without a halo.
    mattes: Planes<MATTE_PLANES>,
    /// Matte of each cell.
    ids: Column<Id>,
    /// True for each pixel that is written; an empty list stands for all.
    wanted: Vec<bool>,
}

impl Default for Filtering {
    fn default() -> Self {
        let none = [0.0; CELLS];
        Self {
            alpha: none,
            albedo: [none; 3],
            openness: none,
            depth: none,
            mist: none,
            variance: none,
            x: none,
            y: none,
            rims: Rims::default(),
            areas: Areas::default(),
            nearest: Vec::new(),
            sums: Planes::default(),
            data: Planes::default(),
            mattes: Planes::default(),
            ids: [Id::NONE; CELLS],
            wanted: Vec::new(),
        }
    }
}

/// Sums into `film` what the samples of tile number `number` contribute to the pixels that they reach, pixels
/// of other tiles included. For a filter wider than a pixel. Returns true if that depends on what is beside the tile.
pub fn sum(
    frame: &FrameView,
    number: usize,
    tile: &Tile,
    filtering: &mut Filtering,
    radiance: &Radiance,
    trace: &mut TraceScratch,
    film: &mut TileFilm,
) -> bool {
    let Some(kernel) = &frame.kernel else { return false };
    prepare(frame, tile, radiance, filtering);
    locate(frame, number, tile, filtering);
    let Filtering { alpha, albedo, openness, depth, mist, variance, x, y, rims, areas, ids, .. } = filtering;
    let (grid, lie) = (&*frame.view.grid, [&*x, &*y]);
    let are_beside = rims.find(frame, number, tile, lie, trace);
    let count = if are_beside { rims.places.each_ref() } else { lie };
    let weighing = match kernel.is_by_area() {
        false if are_beside => {
            areas.find(tile, count);
            Weighing::DistanceAndArea(areas)
        }
        false => Weighing::Distance,
        true if are_beside => {
            areas.find_sloped(grid, tile, lie, rims);
            Weighing::SlopedArea(areas)
        }
        true => {
            areas.find(tile, lie);
            Weighing::Area(areas)
        }
    };
    let by = Spread::new(kernel, grid, count, weighing);
    let mut columns = [None; sums::COUNT];
    let planes = filtered(frame, radiance, [alpha, openness, depth, mist, variance], albedo);
    planes.for_each(|(plane, column)| columns[plane] = Some(column));
    spread(by, tile, &columns, film);
    for (kind, mattes) in shown_mattes(frame) {
        ids_of_cells(frame, mattes, tile, kind, ids);
        film.mattes[kind as usize].spread(by, ids);
    }
    rims.has_asked()
}

/// Results of earlier phases for a tile.
pub struct FilterInput<'a> {
    /// Light of its cells.
    pub radiance: &'a Radiance,
    /// Surfaces of its cells in world space.
    pub placed: &'a mut PlacedTile,
    /// Rays that each cell has cost.
    pub cell_rays: &'a CellRays,
}

/// Makes pixels of the samples of tile number `number`, and writes into its `window` those planes that need
/// no other tile. Returns the channels that hold anything.
pub fn filter(
    frame: &FrameView,
    number: usize,
    tile: &Tile,
    filtering: &mut Filtering,
    shown: FilterInput,
    picture: &Picture,
    window: &mut Window,
) -> NonZeroPlanes {
    if frame.wanted_of(number).is_empty() {
        return NonZeroPlanes::SHOWN;
    }
    let grid = &*frame.view.grid;
    let FilterInput { radiance, placed, cell_rays } = shown;
    filtering.sums.begin();
    filtering.data.begin();
    filtering.mattes.begin();
    let shows_samples = frame.layers.has(Layers::OF_ONE_SAMPLE);
    // with a wide filter `sum` has run, and has located the samples
    if picture.kernel.is_none() {
        prepare(frame, tile, radiance, filtering);
        if shows_samples && grid.samples > 1 {
            locate(frame, number, tile, filtering);
        }
        let Filtering { alpha, albedo, openness, depth, mist, variance, sums, .. } = filtering;
        for (plane, column) in filtered(frame, radiance, [alpha, openness, depth, mist, variance], albedo) {
            reduce(grid, column, |sum, value| sum + value, sums.open(plane));
        }
        take_mattes(frame, tile, filtering);
    }
    let Filtering { x, y, nearest, data, .. } = filtering;
    if shows_samples {
        if grid.samples > 1 {
            choose_nearest(grid, [x, y], nearest);
        }
        take_data(frame, tile, placed, nearest, data);
    }
    count(frame, tile, cell_rays, data);
    finish(frame, number, picture, filtering, window, |_| true)
}

/// Flags the pixels of tile number `number` that are written; leaves the list empty if all are.
fn mark_wanted(frame: &FrameView, number: usize, pixels: &mut Vec<bool>) {
    pixels.clear();
    if frame.wanted.is_some() {
        let (grid, wanted) = (&*frame.view.grid, frame.wanted_of(number));
        let all = 0..(grid.tile_pixels * grid.tile_pixels) as usize;
        pixels.extend(all.map(|pixel| wanted.has(usize::from(grid.cells_of_pixel(pixel)[0]))));
    }
}

/// Kinds of mattes that a layer shows.
fn shown_mattes<'a>(frame: &FrameView<'a>) -> impl Iterator<Item = (Kind, &'a Mattes)> + use<'a> {
    let layers = frame.layers;
    let kinds = frame.mattes.into_iter().flat_map(|mattes| Kind::ALL.map(|kind| (kind, mattes)));
    kinds.filter(move |(kind, _)| layers.has(kind.layer()))
}

/// Computes the mattes of a tile's pixels, each the mean of the pixel's own cells.
fn take_mattes(frame: &FrameView, tile: &Tile, filtering: &mut Filtering) {
    let Filtering { mattes: planes, ids, .. } = filtering;
    for (kind, mattes) in shown_mattes(frame) {
        ids_of_cells(frame, mattes, tile, kind, ids);
        let first = matte_planes(kind).start;
        rank_boxes(&frame.view.grid, ids, |pixel, ranked| {
            for (plane, (id, share)) in
                (first..).step_by(2).zip(ranked).take_while(|(_, (_, share))| *share > 0.0)
            {
                planes.open_zeroed(plane)[pixel] = id.as_float();
                planes.open_zeroed(plane + 1)[pixel] = *share;
            }
        });
    }
}

/// Handles a tile that the film shows already: its samples are a frame older.
pub fn stay(frame: &FrameView, number: usize, picture: &Picture, window: &mut Window) -> NonZeroPlanes {
    let mut written = NonZeroPlanes::SHOWN;
    // a pixel's age is counted up in the coarsest level alone
    if let Some(age) = picture.age().filter(|_| frame.wanted.is_none()) {
        window.count_up(age, &frame.view.grid.pixels(number), OLDEST as f32);
        written.note(age);
    }
    written
}

/// Like [`stay`], for a tile whose samples may have another status, and for which rays may have been cast.
pub fn recount(
    frame: &FrameView,
    number: usize,
    tile: &Tile,
    filtering: &mut Filtering,
    cell_rays: &CellRays,
    picture: &Picture,
    window: &mut Window,
) -> NonZeroPlanes {
    if frame.wanted_of(number).is_empty() {
        return NonZeroPlanes::SHOWN;
    }
    filtering.data.begin();
    count(frame, tile, cell_rays, &mut filtering.data);
    let counted = finish(frame, number, picture, filtering, window, Channel::is_count);
    stay(frame, number, picture, window).plus(counted)
}

/// Writes those planes that are `wanted` and need no neighbours.
fn finish(
    frame: &FrameView,
    number: usize,
    picture: &Picture,
    filtering: &mut Filtering,
    window: &mut Window,
    wanted: impl Fn(&Channel) -> bool,
) -> NonZeroPlanes {
    let grid = &*frame.view.grid;
    mark_wanted(frame, number, &mut filtering.wanted);
    let Filtering { sums, data, mattes, wanted: pixels_wanted, .. } = filtering;
    let scale = (grid.samples_of_pixel() as f32).recip();
    let stride = grid.tile_pixels as usize;
    let (pixels, first) = (grid.pixels(number), grid.first_in_film(number));
    let mut written = NonZeroPlanes::default();
    let mut scaled = [0.0; CELLS];
    let is_some = |channel: &Channel| match channel.source {
        PlaneSource::Data(number) => data.is_some[number],
        PlaneSource::Matte(number) => mattes.is_some[number],
        PlaneSource::Filtered(numbers) => numbers.iter().any(|number| sums.is_some[*number]),
    };
    let channels = picture.channels.iter().zip(&picture.was_zero).enumerate();
    // with a wide filter, colours are made of the sums of many tiles
    let is_ours = |channel: &Channel| wanted(channel) && (picture.kernel.is_none() || !channel.is_filtered());
    let mut channels = channels.filter(|(_, (channel, _))| is_ours(channel)).peekable();
    while let Some((number, (channel, was_zero))) = channels.next() {
        // rows lie far from each other, in memory that no cache holds any more
        if let Some((next, _)) = channels.peek().filter(|(_, (next, was_zero))| is_some(next) || !**was_zero)
        {
            window.prefetch(*next, &pixels);
        }
        let values = match channel.source {
            PlaneSource::Data(number) => data.is_some[number].then(|| &data.columns[number]),
            PlaneSource::Matte(number) => mattes.is_some[number].then(|| &mattes.columns[number]),
            PlaneSource::Filtered(numbers) => {
                let mut some = numbers.iter().filter(|number| sums.is_some[**number]);
                some.next().map(|first| {
                    if numbers.len() == 1 && scale == 1.0 {
                        return &sums.columns[*first];
                    }
                    for (pixel, sum) in scaled.iter_mut().zip(&sums.columns[*first]) {
                        *pixel = sum * scale;
                    }
                    for number in some {
                        for (pixel, sum) in scaled.iter_mut().zip(&sums.columns[*number]) {
                            *pixel += sum * scale;
                        }
                    }
                    &scaled
                })
            }
        };
        match values {
            Some(values) if pixels_wanted.is_empty() => {
                written.note(number);
                window.put(number, &pixels, &values[first..], stride);
            }
            Some(values) => {
                written.note(number);
                window.put_some(number, &pixels, &values[first..], &pixels_wanted[first..], stride);
            }
            None if *was_zero => {}
            None if pixels_wanted.is_empty() => window.clear(number, &pixels),
            None => window.put_some(number, &pixels, &[0.0; CELLS], &pixels_wanted[first..], stride),
        }
    }
    written
}

/// Computes the filtered columns other than light: coverage, albedo, openness, depth, mist, variance.
fn prepare(frame: &FrameView, tile: &Tile, radiance: &Radiance, filtering: &mut Filtering) {
    if frame.layers.has(Layers::VARIANCE) {
        pixel_variances(&frame.view.grid, radiance, &mut filtering.variance);
    }
    for first in (0..CELLS).step_by(LANES) {
        let models = &tile.model[first..first + LANES];
        let is_surface = Mask::less(models, EMPTY);
        // a background that is shown covers what the picture is put over, as surfaces do
        let hides =
            if frame.settings.background == Backdrop::Visible { F32x8::splat(1.0) } else { F32x8::ZERO };
        let clear = if radiance.has_secondary { F32x8::load(&radiance.clear, first) } else { F32x8::ZERO };
        // so do media before one that is not
        let is_background = Mask::equal(models, BACKGROUND);
        let hides = match frame.media {
            Some(_) => is_background.select(hides.max(F32x8::ONE - clear), hides),
            None => hides,
        };
        is_surface.select(F32x8::ONE - clear, hides).store(&mut filtering.alpha, first);
        if frame.layers.has(Layers::ALBEDO) {
            let [r, g, b] = &mut filtering.albedo;
            let kept = frame.palette.albedo(&tile.looks(first), tile.reflectances(first));
            is_surface.select3(kept, Vec3x8::ZERO).store([r, g, b], first);
        }
        if frame.layers.has(Layers::OCCLUSION) {
            let kept = tile.gathered.opennesses(first);
            is_surface.select(kept, F32x8::ONE).store(&mut filtering.openness, first);
        }
        if frame.layers.has(Layers::DEPTH) {
            let cameras = frame.cameras(tile, first);
            let depth =
                frame.offsets_from(cameras.eye, (tile, first), || tile.ticks(first)).dot(cameras.forward);
            let depth = depth * F32x8::splat(frame.scene.space.length_of_files(1.0));
            is_surface.select(depth, F32x8::ZERO).store(&mut filtering.depth, first);
        }
        if frame.layers.has(Layers::MIST) {
            is_surface.select(mist_of(frame, tile, first), F32x8::ONE).store(&mut filtering.mist, first);
        }
    }
}

/// How much mist is before eight samples: none up to its start, and 1 from its end on.
fn mist_of(frame: &FrameView, tile: &Tile, first: usize) -> F32x8 {
    let (cameras, Mist { start, depth, falloff }) = (frame.cameras(tile, first), frame.scene.mist);
    let offsets = frame.offsets_from(cameras.eye, (tile, first), || tile.ticks(first));
    // as far as rays from the eye go, which are parallel before an orthographic camera
    let distance = match frame.view.camera.is_orthographic() {
        true => offsets.dot(cameras.forward).abs(),
        false => offsets.dot(offsets).sqrt(),
    };
    let distance = distance * F32x8::splat(frame.scene.space.length_of_files(1.0));
    let share = (distance - F32x8::splat(start as f32)) / F32x8::splat(depth as f32);
    let share = share.max(F32x8::ZERO).min(F32x8::ONE);
    match falloff {
        MistFalloff::Quadratic => share * share,
        MistFalloff::Linear => share,
        MistFalloff::Inverse => share.sqrt(),
    }
}

/// Computes the places of samples in the tile. A sample is within [`REACH`] of the centre of the cell that it
/// serves; places that rounding puts elsewhere, right before the eye, are clamped.
fn locate(frame: &FrameView, number: usize, tile: &Tile, filtering: &mut Filtering) {
    let grid = &frame.view.grid;
    let [left, top] = grid.tile_corner(number).map(|at| F32x8::splat(at as f32));
    let reach = F32x8::splat(REACH);
    for first in (0..CELLS).step_by(LANES) {
        let cameras = frame.cameras(tile, first);
        let seen = cameras.project(frame.offsets_from(cameras.eye, (tile, first), || tile.ticks(first)));
        let near = |at: F32x8, cell: F32x8| {
            let target = cell + F32x8::splat(0.5);
            at.max(target - reach).min(target + reach)
        };
        let cells = [&grid.place_x, &grid.place_y].map(|place| F32x8::load(place, first));
        let mut at = [near(seen.x - left, cells[0]), near(seen.y - top, cells[1])];
        if frame.view.camera.is_orthographic() {
            // the background has no place of its own: its samples lie in the centres of their cells
            let is_background = Mask::equal(&tile.model[first..first + LANES], BACKGROUND);
            at = [0, 1].map(|axis| is_background.select(cells[axis] + F32x8::splat(0.5), at[axis]));
        }
        at[0].store(&mut filtering.x, first);
        at[1].store(&mut filtering.y, first);
    }
}

/// Columns that are filtered, as far as they hold anything, with their numbers in [`sums`].
fn filtered<'a>(
    frame: &FrameView,
    shown: &'a Radiance,
    [alpha, openness, depth, mist, variance]: [&'a Column<f32>; 5],
    albedo: &'a Light,
) -> impl Iterator<Item = (usize, &'a Column<f32>)> {
    let parts = &shown.parts;
    let has = |layer| frame.layers.has(layer);
    let colors = [
        (sums::DIFFUSE, &shown.diffuse, true),
        (sums::ALBEDO, albedo, has(Layers::ALBEDO)),
        (sums::SPECULAR, &shown.specular, shown.has_specular),
        (sums::REFLECTION, &shown.reflection, shown.has_secondary),
        (sums::REFRACTION, &shown.refraction, shown.has_secondary),
        (sums::DIRECT, &parts.direct, has(Layers::DIRECT)),
        (sums::INDIRECT, &parts.indirect, has(Layers::INDIRECT) && frame.paths > 0),
        (sums::EMISSION, &parts.emission, has(Layers::EMISSION)),
        (sums::SKY, &parts.sky, has(Layers::BACKGROUND)),
        (sums::CATCHER, &parts.catcher, has(Layers::CATCHER)),
        (sums::GUIDE_ALBEDO, &parts.guide_albedo, has(Layers::GUIDES)),
        (sums::GUIDE_NORMAL, &parts.guide_normal, has(Layers::GUIDES)),
    ];
    let planes = colors.into_iter().filter(|(.., is_some)| *is_some);
    let groups = parts.groups.iter().enumerate().map(|(group, light)| (sums::light(group), light, true));
    let groups = groups.filter(move |_| frame.layers.has(Layers::LIGHT));
    let planes = planes.chain(groups);
    let planes =
        planes.flat_map(|(first, light, _)| light.iter().enumerate().map(move |(i, c)| (first + i, c)));
    let openness = has(Layers::OCCLUSION).then_some((sums::OCCLUSION, openness));
    let depth = has(Layers::DEPTH).then_some((sums::DEPTH, depth));
    let mist = has(Layers::MIST).then_some((sums::MIST, mist));
    let variance = has(Layers::VARIANCE).then_some((sums::VARIANCE, variance));
    std::iter::once((sums::ALPHA, alpha))
        .chain(openness)
        .chain(depth)
        .chain(mist)
        .chain(variance)
        .chain(planes)
}
