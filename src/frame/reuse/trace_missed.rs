//! Primary rays: through the centre of every cell that has no sample, or a hidden one; and through the target of every cell that a
//! sample serves, unless it is known what is seen there.
//!
//! Where a target sees [another surface](super::target) than the server shows, another sample may show it: then that one serves, if
//! it is not hidden. Otherwise what the ray met takes the server's place, and the server becomes a spare sample.

use super::sight::restyle;
use super::target::Seen;
use super::verify::{self, Request};
use crate::exposure::{MIDDLE_TICK, Tick};
use crate::frame::grid::bits::{count_bits, set_bits, status_bits};
use crate::frame::grid::cells::{CellSet, is_traced};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::footprints::{cell_widths, has_textures};
use crate::frame::surface::hits::Hits8;
use crate::frame::surface::trace_scratch::TraceScratch;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::samples::{
    BACKGROUND, Column, Flags, Footprint, Octahedral, Record, Sample, Status, Tile, Traced, half_colors,
};
use crate::scene::look::Varied;
use crate::trace::{self, Coherence, Hit, HitPacket, NO_HIT, RayBatch, RayPacket, SceneSubset, Search};

/// Largest distance of a hit point from its ray, as a share of its distance from the eye. It is below the
/// audit's tolerance by enough that a later ray through the point meets the same surface as this one.
const OFF_RAY: f32 = 2.5e-6;

/// Number of rays that are traced at once: with their results they stay in a first-level cache meanwhile.
const AT_ONCE: usize = 4 * trace::LANES;

/// Gives a cell of a tile another sample that shows what its target sees. Returns true if there is one.
pub type Replace<'a> = &'a mut dyn FnMut(&mut Tile, usize, &Seen) -> bool;

/// Traces the cells of tile number `number` that are `Missed`, `Obscured` or `Base`, and asks the targets of the cells in `asked`.
/// Their rays can meet nothing but models `among` these. Where a target sees another surface than its cell shows, `replace` is
/// asked for a sample that shows it.
pub fn trace_missed(
    frame: &FrameView,
    number: usize,
    among: SceneSubset,
    (tile, asked): (&mut Tile, &CellSet),
    replace: Replace,
    scratch: &mut TraceScratch,
) {
    scratch.begin_rays();
    for (first, status) in (0..).step_by(LANES).zip(tile.status.chunks_exact(LANES)) {
        let traced = status_bits(status, is_traced);
        tile.copies[first / LANES] &= !traced;
        let cast = traced | asked.eight(first);
        count_bits(cast, &mut scratch.tally.cells.primary[first..first + LANES]);
        scratch.owners.extend(set_bits(cast).map(|lane| (first + lane) as u32));
    }
    let replaced = trace_owners(frame, number, among, (tile, asked), replace, scratch);
    if !replaced.is_empty() {
        let proven = &CellSet::default();
        let request = Request { number, cells: &replaced, proven, bounds: None, flags: Flags::UNSEEN };
        verify::verify(frame, among, tile, &request, scratch);
        scratch.begin_rays();
        let hidden = CellSet::new(|cell| tile.status[cell] == Status::Obscured).and(&replaced);
        for cell in hidden.numbers() {
            scratch.tally.cells.primary[cell] += 1;
            scratch.owners.push(cell as u32);
            tile.set_copy(cell, false);
        }
        trace_owners(frame, number, among, (tile, &CellSet::default()), &mut |_, _, _| false, scratch);
    }
}

/// Casts a ray through the target of each cell in `scratch.owners`, and stores what is met in those that are traced, and in those that
/// show another surface. Returns the cells that were given another sample by `replace`.
fn trace_owners(
    frame: &FrameView,
    number: usize,
    among: SceneSubset,
    (tile, asked): (&mut Tile, &CellSet),
    replace: Replace,
    scratch: &mut TraceScratch,
) -> CellSet {
    let mut replaced = CellSet::default();
    let TraceScratch { owners, rays, hits, tally, .. } = &mut *scratch;
    tally.counts.primary += owners.len() as u64;
    let mut found = Found8::NONE;
    for owners in owners.chunks(AT_ONCE) {
        rays.clear();
        push_rays(frame, number, owners, rays);
        frame.set_ticks_of_targets(rays, number, owners.iter().map(|cell| *cell as usize));
        frame.tracer.closest(rays, Search::from_eye(among, Coherence::Coherent), hits);
        let answers = rays.packets().zip(&hits.packets).zip(owners.chunks(trace::LANES));
        for (((rays, _), hits), owners) in answers {
            for (half, owners) in owners.chunks(LANES).enumerate() {
                let answers = Answers8::new((rays, hits), half * LANES, (number, owners));
                if asked.is_empty() {
                    answers.keep(frame, tile);
                } else {
                    found.take_unconfirmed(frame, &answers, tile, replace, &mut replaced);
                }
            }
        }
    }
    found.keep(frame, tile);
    // samples that were confirmed keep their tags, and so do those that replace others
    owners.retain(|cell| is_traced(tile.status[*cell as usize]));
    tile.tags.forget(owners);
    if tile.gathered.is_seeded() {
        for cell in owners.iter().map(|cell| *cell as usize) {
            tile.gathered.begin(cell, frame.new_seed(number, cell, tile.model[cell]));
        }
    }
    replaced
}

/// Adds a ray through the centre of each cell in `owners`.
fn push_rays(frame: &FrameView, number: usize, owners: &[u32], rays: &mut RayBatch) {
    let grid = &frame.view.grid;
    let far = F32x8::splat(f32::INFINITY);
    for owners in owners.chunks(LANES) {
        let places = [values_of(&grid.place_x, owners), values_of(&grid.place_y, owners)];
        let [origins, directions] = through_targets(frame, number, places);
        rays.push_lanes(origins, directions, far, u8::MAX >> (LANES - owners.len()));
    }
}

/// Rays through the targets of eight cells of tile number `number`, from the cells' columns and rows in the tile: origins and
/// directions.
#[inline(always)]
pub fn through_targets(frame: &FrameView, number: usize, [x, y]: [F32x8; 2]) -> [Vec3x8; 2] {
    let corner = frame.view.grid.tile_corner(number).map(|at| F32x8::splat(at as f32));
    let (x, y, half) = (x + corner[0], y + corner[1], F32x8::splat(0.5));
    let cameras = frame.view.cameras_at(|| {
        let whole = |at: F32x8| at.values().map(|at| at as i32);
        frame.view.ticks_of_cells([whole(x), whole(y)])
    });
    cameras.rays(x + half, y + half)
}

/// Values of `column` for up to eight cells.
#[inline(always)]
fn values_of(column: &Column<f32>, cells: &[u32]) -> F32x8 {
    if are_neighbours(cells) {
        return F32x8::load(column, cells[0] as usize);
    }
    let mut values = F32x8::ZERO;
    (0..).zip(cells).for_each(|(lane, cell)| values.set_lane(lane, column[*cell as usize]));
    values
}

/// Returns true if these are eight successive cells. They come in order.
#[inline(always)]
fn are_neighbours(cells: &[u32]) -> bool {
    cells.len() == LANES && cells[LANES - 1] == cells[0] + LANES as u32 - 1
}

/// Up to eight rays, and their hits.
#[derive(Debug, Clone, Copy)]
struct Answers8<'a> {
    /// Cells that the rays are for, from the first lane on.
    owners: &'a [u32],
    /// Number of their tile.
    tile: usize,
    origin: Vec3x8,
    direction: Vec3x8,
    met: Hits8<'a>,
    /// Distances of the hits, as ray parameters.
    t: &'a [f32],
}

/// Up to eight rays and their hits, collected lane by lane from several packets.
#[derive(Debug, Clone)]
struct Found8 {
    count: usize,
    tile: usize,
    owners: [u32; LANES],
    origin: Vec3x8,
    direction: Vec3x8,
    t: [f32; LANES],
    models: [u32; LANES],
    triangles: [u32; LANES],
    weights: [F32x8; 2],
}

impl Found8 {
    const NONE: Self = Self {
        count: 0,
        tile: 0,
        owners: [0; LANES],
        origin: Vec3x8::ZERO,
        direction: Vec3x8::ZERO,
        t: [0.0; LANES],
        models: [NO_HIT; LANES],
        triangles: [NO_HIT; LANES],
        weights: [F32x8::ZERO; 2],
    };

    /// Takes those of `answers` that must be stored: all but those that confirm the samples which serve their
    /// cells, and those for which `replace` has another sample. Whenever there are eight they are stored: finding surfaces takes the
    /// same time for one and for eight.
    fn take_unconfirmed(
        &mut self,
        frame: &FrameView,
        answers: &Answers8,
        tile: &mut Tile,
        replace: Replace,
        replaced: &mut CellSet,
    ) {
        for (lane, cell) in answers.owners.iter().map(|cell| *cell as usize).enumerate() {
            if !is_traced(tile.status[cell]) {
                if answers.is_of_server(frame, tile, cell, lane) {
                    continue;
                }
                let seen = answers.seen(frame, lane);
                if seen.is_shown_by(frame, &tile.sample(cell)) {
                    continue;
                }
                if replace(tile, cell, &seen) {
                    replaced.insert(cell);
                    continue;
                }
            }
            self.take(answers, lane);
            if self.count == LANES {
                self.keep(frame, tile);
            }
        }
    }

    fn take(&mut self, from: &Answers8, lane: usize) {
        let to = self.count;
        self.tile = from.tile;
        self.owners[to] = from.owners[lane];
        self.origin.set_lane(to, from.origin.lane(lane));
        self.direction.set_lane(to, from.direction.lane(lane));
        self.t[to] = from.t[lane];
        (self.models[to], self.triangles[to]) = (from.met.models[lane], from.met.triangles[lane]);
        let weights = self.weights.iter_mut().zip(&from.met.weights);
        weights.for_each(|(weights, of)| weights.set_lane(to, of.lane(lane)));
        self.count += 1;
    }

    /// Stores all, and becomes empty.
    fn keep(&mut self, frame: &FrameView, tile: &mut Tile) {
        if self.count == 0 {
            return;
        }
        let Self { count, tile: number, owners, origin, direction, t, models, triangles, weights } = &*self;
        let met = Hits8 { models, triangles, weights: *weights, computed: &[] };
        let (owners, origin, direction) = (&owners[..*count], *origin, *direction);
        let answers = Answers8 { owners, tile: *number, origin, direction, met, t };
        answers.keep(frame, tile);
        (self.count, self.models) = (0, [NO_HIT; LANES]);
    }
}

impl<'a> Answers8<'a> {
    /// Rays and hits of a packet from lane `from` on, for the cells `owners`.
    #[inline(always)]
    fn new(
        (rays, hits): (&RayPacket, &'a HitPacket),
        from: usize,
        (tile, owners): (usize, &'a [u32]),
    ) -> Self {
        let of_rays = |[x, y, z]: &[[f32; trace::LANES]; 3]| Vec3x8::load([x, y, z], from);
        let (origin, direction) = (of_rays(&rays.origin), of_rays(&rays.direction));
        let (met, t) = (Hits8::new(hits, from), &hits.t[from..from + LANES]);
        Self { owners, tile, origin, direction, met, t }
    }

    /// [`tick`](Self::tick) of all lanes.
    fn ticks(&self, frame: &FrameView) -> [Tick; LANES] {
        let count = self.owners.len();
        std::array::from_fn(|lane| if lane < count { self.tick(frame, lane) } else { MIDDLE_TICK })
    }

    /// Tick of the exposure at which the cell in a lane sees.
    fn tick(&self, frame: &FrameView, lane: usize) -> Tick {
        frame.view.tick_in_tile(self.tile, self.owners[lane] as usize)
    }

    /// Returns true if the ray through the target of a cell met the triangle on which the cell's server lies. A `false` is to be looked
    /// into, and so are curved primitives, which a ray may meet on either side.
    #[inline(always)]
    fn is_of_server(&self, frame: &FrameView, tile: &Tile, cell: usize, lane: usize) -> bool {
        let (model, triangle) = (self.met.models[lane], self.met.triangles[lane]);
        model == tile.model[cell]
            && triangle == tile.record[cell].triangle
            && frame.curved.get(model as usize) != Some(&true)
    }

    /// What the ray in a lane met.
    fn seen(&self, frame: &FrameView, lane: usize) -> Seen {
        let Self { met, t, .. } = self;
        let [u, v] = met.weights.map(|weight| weight.lane(lane));
        let (model, triangle) = (met.models[lane], met.triangles[lane]);
        let hit = met.is_hit(lane).then_some(Hit { t: t[lane], u, v, model, triangle });
        Seen::new(frame, [self.origin.lane(lane), self.direction.lane(lane)], self.tick(frame, lane), hit)
    }

    /// Bit mask of the lanes that met surfaces whose textures are filtered.
    fn textured(&self, frame: &FrameView) -> u8 {
        let met = &self.met;
        // neighbours mostly share one material
        let (mut last, mut is_textured, mut bits) = (None, false, 0);
        for lane in (0..self.owners.len()).filter(|lane| met.is_hit(*lane)) {
            let material = met.material(frame, lane);
            if last != Some(material) {
                (last, is_textured) = (Some(material), has_textures(frame.scene, material));
            }
            bits |= u8::from(is_textured) << lane;
        }
        bits
    }

    /// Places that the new samples stand for, where surfaces have textures: with `points` in object space and normals in world
    /// space.
    #[inline(never)]
    fn footprints(&self, frame: &FrameView, points: &Vec3x8, normals: Vec3x8) -> [Footprint; LANES] {
        let Self { met, .. } = *self;
        let textured = self.textured(frame);
        if textured == 0 {
            return [Footprint::NONE; LANES];
        }
        // as far as the samples are, not as the rays say: of triangles that are much larger than their distance these find it badly
        let mut world = *points;
        frame.each_displaced(
            met.models,
            || self.ticks(frame),
            |place, of_model| {
                place.points(of_model, |lane| met.triangles[lane], &mut world);
            },
        );
        let cameras = frame.view.cameras_at(|| self.ticks(frame));
        let mut widths = cell_widths(frame.view, cameras.sights(world - cameras.eye), normals);
        for lane in set_bits(textured) {
            widths.set_lane(lane, widths.lane(lane) * frame.scale_to_object(met.models[lane]));
        }
        let mut footprints = Footprint::eight(widths, *points);
        let none = (0..LANES).filter(|lane| textured >> lane & 1 == 0);
        none.for_each(|lane| footprints[lane] = Footprint::NONE);
        footprints
    }

    /// Stores the surfaces that were met in the cells: object space, on the side of the eye.
    #[inline(always)]
    fn keep(&self, frame: &FrameView, tile: &mut Tile) {
        let Self { owners, origin, direction, met, .. } = *self;
        let Hits8 { models, triangles, .. } = met;
        let corners = met.corners(frame);
        let (mut point, curved) = (corners.point(met.weights), corners.curved());
        met.put_curved_points(frame, curved, &mut point);
        put_on_ray(frame, [origin, direction], &met, || self.ticks(frame), &mut point);
        let mut weights = corners.weights_at(point);
        met.put_curved_weights(frame, curved, &point, &mut weights);
        let [mut normal, mut geometric_normal] = corners.normals(weights);
        met.put_curved_normals(frame, curved, weights, [&mut normal, &mut geometric_normal]);
        let in_world = geometric_normals_in_world(frame, geometric_normal, &met, || self.ticks(frame));
        let behind = in_world.dot(direction).gt(F32x8::ZERO);
        let (mut footprints, mut widths) = ([Footprint::NONE; LANES], [0.0; LANES]);
        if frame.palette.has_textures {
            footprints = self.footprints(frame, &point, in_world);
            widths = footprints.map(Footprint::width);
        }
        met.bend_normals(frame, &corners, (weights, &widths), &mut normal);
        let normals = Octahedral::fold_lanes(behind.select3(-normal, normal));
        let geometric_normals = Octahedral::fold_lanes(behind.select3(-geometric_normal, geometric_normal));
        let (looks, colors) = met.looks(frame, weights, &widths);
        let colors = half_colors(colors);
        let record = |lane: usize| Record {
            triangle: triangles[lane],
            normal: normals[lane],
            geometric_normal: geometric_normals[lane],
            reflectance: colors[lane],
            direct_diffuse: Default::default(),
            traced: Traced::new(frame.rendered, self.tick(frame, lane)),
            material: looks[lane].material,
            flags: Flags::FROM_BEHIND.when(behind.lane(lane)),
            footprint: footprints[lane],
        };
        let first = owners[0] as usize;
        let all_traced = || owners.iter().all(|cell| is_traced(tile.status[*cell as usize]));
        if are_neighbours(owners) && !models.contains(&NO_HIT) && all_traced() {
            // eight neighbours, as in every frame that is traced in full: whole columns
            point.store([&mut tile.x, &mut tile.y, &mut tile.z], first);
            tile.model[first..first + LANES].copy_from_slice(models);
            for (lane, kept) in tile.record[first..first + LANES].iter_mut().enumerate() {
                *kept = record(lane);
            }
            if !tile.varied.is_empty() {
                (first..).zip(&looks).for_each(|(cell, look)| tile.varied.set(cell, look.varied));
            }
            self.show_to_eye(frame, tile);
            return;
        }
        for (lane, cell) in owners.iter().map(|cell| *cell as usize).enumerate() {
            if !is_traced(tile.status[cell]) {
                tile.make_spare(cell, frame.moved(tile.model[cell]));
                tile.set_copy(cell, false);
                tile.status[cell] = Status::Missed;
            }
            let is_hit = models[lane] != NO_HIT;
            let at = if is_hit { point.lane(lane) } else { direction.lane(lane) };
            let model = if is_hit { models[lane] } else { BACKGROUND };
            let varied = if is_hit { looks[lane].varied } else { Varied::NONE };
            tile.put(cell, Sample { point: at, model, record: record(lane), varied });
        }
        self.show_to_eye(frame, tile);
    }

    /// Gives the samples that were stored the look that they have to the eye, where that depends on the angle.
    #[inline(always)]
    fn show_to_eye(&self, frame: &FrameView, tile: &mut Tile) {
        if frame.palette.is_of_eye {
            for lane in (0..self.owners.len()).filter(|lane| self.met.is_hit(*lane)) {
                if frame.scene.materials[usize::from(self.met.material(frame, lane))].is_of_eye() {
                    restyle(frame, tile, self.owners[lane] as usize);
                }
            }
        }
    }
}

/// Corrects the points (object space) that lie beside their rays.
///
/// Computed from the triangle's corners, a point lies in the triangle's plane as exactly as floats allow, and
/// is taken. But where the triangle is a sliver or is seen edge on, its weights are all but undetermined in
/// single floats, and the point may lie away from the ray, behind something else: there ray and triangle are
/// intersected again in double floats. So are curved primitives that are much larger than their distance.
#[inline(always)]
fn put_on_ray(
    frame: &FrameView,
    [origin, direction]: [Vec3x8; 2],
    met: &Hits8,
    ticks: impl Fn() -> [Tick; LANES],
    point: &mut Vec3x8,
) {
    let models = met.models;
    let mut world = *point;
    frame.each_displaced(models, &ticks, |place, of_model| {
        place.points(of_model, |lane| met.triangles[lane], &mut world);
    });
    let offset = world - origin;
    let aside = offset.cross(direction);
    let most = F32x8::splat(OFF_RAY * OFF_RAY) * offset.dot(offset) * direction.dot(direction);
    let is_beside = !(aside.dot(aside).le(most) | Mask::equal(models, NO_HIT));
    for lane in set_bits(is_beside.bits()) {
        let (place, mesh) = (frame.place(models[lane], ticks()[lane]), met.mesh(frame, lane));
        let (origin, direction) = (origin.lane(lane), direction.lane(lane));
        let (primitive, about) = ((mesh, met.triangles[lane]), point.lane(lane));
        let exact = place.meet_exactly(primitive, (origin, direction), about);
        if let Some(exact) = exact {
            point.set_lane(lane, exact);
        }
    }
}

/// Normals of the triangles that were `met`, object to world space, of any length.
#[inline(always)]
fn geometric_normals_in_world(
    frame: &FrameView,
    geometric_normal: Vec3x8,
    met: &Hits8,
    ticks: impl FnOnce() -> [Tick; LANES],
) -> Vec3x8 {
    let mut world = geometric_normal;
    frame.each_displaced(met.models, ticks, |place, of_model| {
        place.geometric_normals(of_model, |lane| met.triangles[lane], &mut world);
    });
    world
}
