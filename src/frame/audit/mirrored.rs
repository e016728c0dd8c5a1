//! Check of what flat mirrors show, where it was kept: see [`mirrors`](crate::frame::secondary::mirrors).
//!
//! The tile is enhanced again, which lets the same samples serve. Of each it is then asked, by rays that are turned at whatever they meet,
//! with the normals that it has there, and that know nothing of planes and images:
//! 1. Its image lies in its cell, its textures were filtered over a place about as wide as they would be now, and it has as many paths.
//! 2. The ray from the eye through the image meets what the cell's own sample lies on, then the same things as the ray through that, one
//!    after the other, and at last the kept sample, in its point.
//! 3. What the ray through the cell's own sample meets at last is the surface that the kept sample shows.
//! 4. Lit anew, it has the light that was kept.

use glam::{Vec2, Vec3};

use super::sights::{Sight, around, sight};
use super::tolerances::{
    ABOUT_PARALLEL, CELL_TOLERANCE, COLOR_TOLERANCE, COORDINATE_TOLERANCE, DARKEST, DISPLACEMENTS, LAYER,
    TOLERANCE, WIDER,
};
use super::verdict::Verdict;
use crate::changes::Until;
use crate::exposure::MIDDLE_TICK;
use crate::frame::grid::place;
use crate::frame::reuse::candidates::REACH;
use crate::frame::secondary::enhance;
use crate::frame::secondary::met_surfaces::{MetSurface, MetSurfaces};
use crate::frame::secondary::mirrors::{Served, surface_of};
use crate::frame::secondary::tree_times::TreeTimes;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::ray_tally::RayTally;
use crate::frame::tiles::thread_scratch::ThreadScratch;
use crate::samples::{MirroredSample, Octahedral, Tile};
use crate::scene::RayKind;
use crate::shade::Surface;
use crate::trace::{Coherence, Hit, HitBatch, OfKind, RayBatch, SceneSubset, Search};

/// Checks the kept samples that serve cells of tile number `number`. Returns their number.
pub fn check_mirrored(
    frame: &FrameView,
    number: usize,
    tile: &Tile,
    raise: &mut impl FnMut(usize, Verdict),
) -> u64 {
    if frame.mirrored.is_none() {
        return 0;
    }
    let mut scratch = ThreadScratch::default();
    scratch.begin_tile();
    let ThreadScratch { radiance, bounces, placed, trace, .. } = &mut scratch;
    bounces.mirrors.collects = true;
    enhance::enhance(frame, (number, tile), radiance, bounces, None, placed, trace);
    let all = std::mem::take(&mut bounces.mirrors.all_served);
    check_light(frame, &all, raise);
    for served in &all {
        let cell = served.met.bounce.cell as usize;
        raise(cell, check_place(frame, number, served));
        let first = (tile.model[cell], tile.record[cell].material);
        raise(cell, check_way(frame, served, (sight(frame, number, tile, cell), first)));
    }
    all.len() as u64
}

/// Checks that the image of a sample lies as near to the centre of its cell as it must, and that it is as good as a new one.
fn check_place(frame: &FrameView, number: usize, served: &Served) -> Verdict {
    let (corner, place) = (frame.view.grid.tile_corner(number), place(served.met.bounce.cell as usize));
    let centre = Vec2::from([0, 1].map(|axis| (corner[axis] + place[axis] as i32) as f32 + 0.5));
    let seen = frame.view.project_one(served.image - frame.view.camera.eye, MIDDLE_TICK);
    let is_in = seen.is_some_and(|seen| (seen.truncate() - centre).length() <= REACH + CELL_TOLERANCE);
    let Served { met, sample, .. } = served;
    // as sharp, and with as little noise, as what would be found there now
    let is_as_wide = !frame.palette.has_textures
        || sample.width <= met.surface.width * WIDER && met.surface.width <= sample.width * WIDER;
    Verdict::new(is_in && is_as_wide && u32::from(sample.paths) >= met.paths)
}

/// Checks that the eye sees the sample at its image by the way on which it sees the same surface through the cell's `own` sample, which is on
/// the model and of the material that are `first`. Of two surfaces in one place a ray may meet either: which one the cell shows is checked
/// with its sample.
fn check_way(frame: &FrameView, served: &Served, (own, first): (Sight, (u32, u16))) -> Verdict {
    let to_image = Sight { direction: served.image - own.origin, ..own };
    let shows = |targets: &[Option<Arrival>], ways: &[Option<Arrival>]| {
        let targets = || targets.iter().flatten().filter(|target| target.shows(frame, &served.sample));
        let ways = || ways.iter().flatten().filter(|way| way.meets(frame, &served.sample));
        let is_same =
            |way: &Arrival, target: &Arrival| way.over[0] == first && way.over[1..] == target.over[1..];
        targets().any(|target| ways().any(|way| is_same(way, target)))
    };
    let follow = |sights: &[Sight]| follow(frame, served, sights);
    let (target, way) = (follow(&[own]), follow(&[to_image]));
    Verdict::new(shows(&target, &way)).or_on_edge(|| {
        let beside = |sight: Sight| {
            let reach =
                served.length * TOLERANCE + frame.view.camera.eye.abs().max_element() * COORDINATE_TOLERANCE;
            let reach = reach * sight.direction.length() / served.length.max(f32::MIN_POSITIVE);
            let aside = DISPLACEMENTS
                .iter()
                .flat_map(|share| around(sight.direction).map(|aside| aside * *share * reach));
            let all: Vec<Sight> = aside
                .map(|aside| Sight { direction: sight.direction + aside, ..sight })
                .chain([sight])
                .collect();
            all
        };
        shows(&follow(&beside(own)), &follow(&beside(to_image)))
    })
}

/// What a ray has met at last.
struct Arrival {
    /// Models and materials that it has met before.
    over: Vec<(u32, u16)>,
    hit: Hit,
    surface: Surface,
    /// Direction of the last ray, unit length.
    direction: Vec3,
    /// Length of the whole way.
    length: f32,
}

impl Arrival {
    /// Returns true if it is in the point of the sample, and on its model.
    fn meets(&self, frame: &FrameView, sample: &MirroredSample) -> bool {
        let apart = sample.point - self.surface.point;
        let aside = apart - apart.dot(self.direction) * self.direction;
        self.hit.model == sample.model
            && aside.length() <= self.tolerance(frame, sample)
            && apart.dot(self.surface.geometric_normal).abs() <= self.tolerance(frame, sample)
    }

    /// Returns true if the sample shows the surface that was met.
    fn shows(&self, frame: &FrameView, sample: &MirroredSample) -> bool {
        let mesh = &frame.scene.models[sample.model as usize].mesh;
        let apart = sample.point - self.surface.point;
        let of_sample = sample.geometric_normal.unfold();
        let layer = LAYER * frame.view.spread().by_distance * self.length;
        let normal = self.surface.geometric_normal;
        self.hit.model == sample.model
            && mesh.material_of[sample.triangle as usize] == self.surface.material
            && normal.dot(of_sample) >= ABOUT_PARALLEL
            && apart.dot(normal).abs().max(apart.dot(of_sample).abs())
                <= layer + self.tolerance(frame, sample)
    }

    /// Greatest displacement by rounding.
    fn tolerance(&self, frame: &FrameView, sample: &MirroredSample) -> f32 {
        let largest = frame.view.camera.eye.abs().max(sample.point.abs()).max_element().max(self.length);
        // each mirror doubles the error of an angle
        let turns = 1.0 + 2.0 * self.over.len() as f32;
        turns * (self.length * TOLERANCE + largest * COORDINATE_TOLERANCE)
    }
}

/// Follows rays along `sights` as that on which `served` lies goes: turned or let pass at as many surfaces.
fn follow(frame: &FrameView, served: &Served, sights: &[Sight]) -> Vec<Option<Arrival>> {
    sights.iter().map(|sight| follow_one(frame, served, *sight)).collect()
}

fn follow_one(frame: &FrameView, served: &Served, sight: Sight) -> Option<Arrival> {
    let Sight { mut origin, direction, .. } = sight;
    let mut direction = direction.try_normalize()?;
    let (mut over, mut length, mut ray_kind) = (Vec::new(), 0.0, RayKind::Camera);
    for left in (0..=served.links).rev() {
        let (mut rays, mut hits, kinds) = (RayBatch::default(), HitBatch::default(), [ray_kind]);
        rays.push(origin, direction, 0.0, f32::INFINITY);
        let (among, coherence) = (SceneSubset::All, Coherence::Bounced);
        frame.tracer.closest(&rays, Search { kinds: OfKind::Each(&kinds), among, coherence }, &mut hits);
        let hit = hits.get(0)?;
        let met = MirroredSample {
            point: Vec3::ZERO,
            weights: [hit.u, hit.v],
            model: hit.model,
            triangle: hit.triangle,
            geometric_normal: Octahedral::fold(Vec3::X),
            light: Vec3::ZERO,
            width: 0.0,
            until: Until::UNKNOWN,
            paths: 0,
            octave: 0,
            unused: 0,
        };
        let surface = surface_of(frame, &met, direction);
        length += hit.t;
        if left == 0 {
            return Some(Arrival { over, hit, surface, direction, length });
        }
        over.push((hit.model, surface.material));
        let is_turned = served.met.bounce.path >> (left - 1) & 1 == 0;
        if is_turned {
            direction = (direction - 2.0 * direction.dot(surface.normal) * surface.normal).normalize();
            ray_kind = RayKind::Glossy;
        }
        origin = surface.leave(direction);
    }
    None
}

/// Checks that the samples, lit anew, have the light that was kept.
fn check_light(frame: &FrameView, all: &[Served], raise: &mut impl FnMut(usize, Verdict)) {
    let mut met = MetSurfaces::default();
    met.all.extend(all.iter().map(|Served { met, sample, .. }| MetSurface {
        bounce: met.bounce,
        surface: surface_of(frame, sample, -sample.geometric_normal.unfold()),
        model: sample.model,
        triangle: sample.triangle,
        weights: sample.weights,
        paths: sample.paths.into(),
        is_kept: false,
        light: Vec3::ZERO,
        until: Until::UNKNOWN,
    }));
    met.light(frame, &mut TreeTimes::default(), &mut RayTally::default());
    for (met, served) in met.all.iter().zip(all) {
        let (fresh, kept) = (met.light, served.sample.light);
        let slack = COLOR_TOLERANCE * fresh.abs().max_element().max(DARKEST);
        let holds = (kept - fresh).abs().max_element() <= slack && met.surface.point == served.sample.point;
        raise(served.met.bounce.cell as usize, Verdict::new(holds));
    }
}
