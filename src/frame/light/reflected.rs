//! Reflected paths of samples: which of them are kept, and what is shown of them.
//!
//! The paths by which a sample's layer reflects are kept with the sample, with the direction to the eye for
//! which they were drawn. Each frame weights them for its own eye ([`layer_paths`](super::layer_paths)). They
//! are drawn anew when the eye has turned too far ([`serves`]): the weights of narrow lobes spread fast. Until
//! then only paths that are no longer valid are traced.

use glam::Vec3;

use super::indirect::kept;
use super::layer_paths::paths_of_layer;
use super::light_paths::{AT_ONCE, PathScratch, trace_paths};
use super::path_ends::{DrawnLayer, PathStart};
use super::starts::{NOTHING, Starts};
use crate::changes::Until;
use crate::frame::grid::bits::{set_bits, surface_bits};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::placed::{Placed, PlacedTile, horizon};
use crate::frame::surface::ray_tally::RayTally;
use crate::frame::surface::tangents::tangent_of_sample;
use crate::lanes::{LANES, Vec3x8};
use crate::samples::{CELLS, Octahedral, Tile, full_color};
use crate::shade::bsdf::{SeenBsdf, SeenBy, SurfaceAxes};
use crate::shade::sampling::{PathSequence, SampleSeed};
use crate::shade::within::Within;

/// Mean angle by which an eye may turn while it sees the paths that were drawn for another direction, in units
/// of the lobe's width: at half of it the noise of a path has grown by some 10 to 20 %.
const MOST_TURN: f32 = 0.5;

/// Returns true if paths drawn for an eye in the direction `drawn_for` serve one in the direction `to_eye`
/// (unit length). The limit is in proportion to the lobe's width `alpha`, and less at grazing angles, where
/// weights spread faster. It differs from sample to sample, by half of its mean to either side: so not all
/// draw anew in one frame. It depends on directions to the eye, on the surface and on the seed alone: a limit
/// that looked at paths would favour some of them.
pub fn serves(alpha: f32, normal: Vec3, drawn_for: Vec3, to_eye: Vec3, seed: SampleSeed) -> bool {
    let turn = (to_eye - drawn_for).length();
    let cos = normal.dot(to_eye).min(normal.dot(drawn_for)).max(0.0);
    turn <= MOST_TURN * (0.5 + seed.share()) * alpha * cos + ROUNDING
}

/// Turn that rounding of the direction to four bytes may cause.
const ROUNDING: f32 = 1e-4;

/// Returns true if the paths that are known of the sample in `cell` [serve](serves) an eye in the direction
/// `to_eye`.
pub fn serve(frame: &FrameView, tile: &Tile, cell: usize, placed: &Placed, to_eye: Vec3) -> bool {
    let (lane, drawn_for) = (cell % LANES, tile.gathered.drawn_for(cell).unfold());
    // weights of a fibre spread as fast from wherever it is seen
    let is_fibre = placed.fibres >> lane & 1 != 0;
    let normal = if is_fibre { drawn_for } else { placed.normal.lane(lane) };
    let alpha = frame.palette.bsdfs.alpha_of_rough(tile.look(cell));
    alpha.is_some_and(|alpha| serves(alpha, normal, drawn_for, to_eye, tile.gathered.seed(cell)))
}

/// Directions from eight samples, in the cells of `tile` from `first` on, to the eye; world space, unit length. Of a sample in the very place of the eye, which may lie in
/// a surface, its normal.
pub fn directions_to_eye(frame: &FrameView, tile: &Tile, first: usize, placed: &Placed) -> Vec3x8 {
    let cameras = frame.cameras(tile, first);
    let sights = cameras.sights(placed.point - cameras.eye);
    sights.is_some().select3(-sights.normalize(), placed.normal)
}

/// Start of the first reflected path of the sample in `cell`, as it was drawn; `placed` holds its group of
/// eight cells. None if it has no rough layer, or samples reflect no paths.
pub fn start_at(
    frame: &FrameView,
    tile: &Tile,
    cell: usize,
    placed: &Placed,
) -> Option<(PathStart, DrawnLayer)> {
    let (lane, record, gathered) = (cell % LANES, &tile.record[cell], &tile.gathered);
    if !gathered.reflects() {
        return None;
    }
    let [normal, geometric_normal] =
        [&placed.normal, &placed.geometric_normal].map(|normal| normal.lane(lane));
    let incoming = -gathered.drawn_for(cell).unfold();
    let seen = frame.palette.bsdfs.seen(
        tile.look(cell),
        full_color(record.reflectance),
        SurfaceAxes { normal, geometric_normal, tangent: tangent_of_sample(frame, tile, cell) },
        incoming,
        SeenBy::Eye,
    );
    let seen = seen?.rough()?;
    let most = frame.settings.reflections as usize;
    let layer = DrawnLayer { seen, paths: paths_of_layer(frame, &seen) };
    let start = PathStart {
        owner: cell as u32,
        cell: cell as u32,
        model: tile.model[cell],
        index: 0,
        sequence: PathSequence::of_reflections(gathered.seed(cell), most),
        point: placed.point.lane(lane),
        normal,
        tangent: Vec3::ZERO,
        geometric_normal,
        horizon: horizon(frame, tile, cell, placed),
        of_surface: NOTHING,
        within: Within::NOTHING,
    };
    Some((start, layer))
}

/// Brings the reflected paths of the samples of `tile` up to date. Returns true if the light of any has
/// changed, and the first frame in which any may become invalid.
pub fn renew(
    frame: &FrameView,
    tile: &mut Tile,
    placed: &mut PlacedTile,
    scratch: &mut PathScratch,
    tally: &mut RayTally,
) -> (bool, Until) {
    let (mut any_changed, mut least) = (false, Until::FOREVER);
    if !tile.gathered.reflects() {
        return (any_changed, least);
    }
    scratch.starts.clear();
    for first in (0..CELLS).step_by(LANES) {
        let (surfaces, looks) = (surface_bits(&tile.model[first..first + LANES]), tile.looks(first));
        if surfaces == 0 || !frame.palette.bsdfs.any(&looks) {
            continue;
        }
        let placed = placed.get(frame, tile, first);
        let to_eye = directions_to_eye(frame, tile, first, &placed);
        for lane in set_bits(surfaces) {
            if frame.palette.bsdfs.is_rough(looks[lane]) {
                let cell = first + lane;
                any_changed |= draw(frame, tile, cell, &placed, to_eye.lane(lane), &mut scratch.starts);
            }
        }
        if scratch.starts.len() >= AT_ONCE {
            any_changed |= trace(frame, tile, scratch, tally);
        }
    }
    any_changed |= trace(frame, tile, scratch, tally);
    for first in (0..CELLS).step_by(LANES) {
        for lane in set_bits(surface_bits(&tile.model[first..first + LANES])) {
            let known = tile.gathered.reflected.known(first + lane);
            least = known.fold(least, |least, path| least.min(path.until));
        }
    }
    (any_changed, least)
}

/// Adds to `starts` the paths of the sample in `cell` that are to be traced: all of them if they do not serve
/// an eye in the direction `to_eye`, or else those that are not valid any more. Returns true if it was seen by
/// other paths before.
fn draw(
    frame: &FrameView,
    tile: &mut Tile,
    cell: usize,
    placed: &Placed,
    to_eye: Vec3,
    starts: &mut Starts,
) -> bool {
    let is_known = tile.gathered.reflected.path(cell, 0).is_some();
    let holds = is_known && !frame.moved(tile.model[cell]) && serve(frame, tile, cell, placed, to_eye);
    if !holds {
        tile.gathered.reflected.forget_one(cell);
        tile.gathered.set_drawn_for(cell, Octahedral::fold(to_eye));
        let Some((start, layer)) = start_at(frame, tile, cell, placed) else { return is_known };
        starts.reflect(&start, layer, 0..layer.paths);
        return is_known;
    }
    let known = || tile.gathered.reflected.known(cell);
    if known().any(|path| frame.has_expired(path.until)) {
        let expired = (0..).zip(known()).filter(|(_, path)| frame.has_expired(path.until));
        if let Some((start, layer)) = start_at(frame, tile, cell, placed) {
            starts.reflect(&start, layer, expired.map(|(index, _)| index));
        }
    }
    false
}

/// Traces the paths in `scratch`, stores their results in the tile, and clears `scratch`. Returns true if any
/// light changes.
fn trace(frame: &FrameView, tile: &mut Tile, scratch: &mut PathScratch, tally: &mut RayTally) -> bool {
    trace_paths(frame, scratch, tally);
    let mut any_changed = false;
    for (start, brought) in scratch.starts.iter().zip(&scratch.brought) {
        let (cell, path) = (start.owner as usize, start.index as usize);
        any_changed |= tile.gathered.reflected.set(cell, path, kept(brought));
        // of an emitter in sight no light is kept: it may bring other light from where it is now
        any_changed |= brought.sees_light && frame.emitters.are_asked();
    }
    scratch.starts.clear();
    any_changed
}

/// Light that the sample whose paths begin at `start`, off a `layer`, reflects to the eye, which sees its layer as `seen`.
pub fn shown(
    frame: &FrameView,
    tile: &Tile,
    (start, layer): (&PathStart, &DrawnLayer),
    seen: &SeenBsdf,
) -> Vec3 {
    let paths = (0..).zip(tile.gathered.reflected.known(start.owner as usize));
    paths
        .map(|(index, path)| layer.shows(frame, start, index, seen, (path.light.color(), path.light.flag())))
        .sum()
}
