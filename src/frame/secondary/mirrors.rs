//! What flat mirrors show, kept from frame to frame.
//!
//! A flat mirror shows what a mirrored eye sees. So what was met by way of one is a sample like others
//! ([`MirroredSample`]), with the difference that it is seen where its *image* is: the place itself, mirrored by the planes on the way in
//! their reverse order. It serves a cell by the rule for all samples:
//!
//! - *Target.* The ray that goes on from the cell's own sample is traced as ever. What it meets is what the cell shows, and the sample must
//!   show the same surface ([`target`](crate::frame::reuse::target)): model, material, side, layer, about parallel.
//! - *Nearest.* Its image lies within [`REACH`] of the cell's centre, and none that would do lies nearer.
//! - *Verified.* A ray from the eye to the image must meet the same mirrors, in the planes that they had on the way of the target, and at
//!   last the sample ([`Mirrors::verify`]). An edge of a mirror, a fold, or anything that came before any of them, ends it there.
//!
//! What it saves is light: shadow rays and paths of the place that is shown. Where none serves, the place that was met is lit as ever, and
//! is kept for the frames that follow. How much of the light the mirrors reflect depends on the eye, and is found for the cell's own
//! sample.
//!
//! What is seen over anything that is not [flat](super::ways) is lit in each frame.

use glam::{Vec2, Vec3};

use super::bounced_ray::Bounce;
use super::met_surfaces::{MetSurface, MetSurfaces};
use super::ways::{Links, ONE_PLACE, Way, Ways, rounding};
use crate::exposure::MIDDLE_TICK;
use crate::frame::grid::place;
use crate::frame::reuse::candidates::REACH;
use crate::frame::reuse::target::{ABOUT_PARALLEL, LAYER};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::hits::{Hits8, surfaces};
use crate::frame::surface::trace_scratch::TraceScratch;
use crate::lanes::F32x8;
use crate::pose::Clip;
use crate::samples::{MirroredOfTile, MirroredSample, Octahedral, octave_of};
use crate::scene::RayKind;
use crate::shade::Surface;
use crate::shade::within::Within;
use crate::trace::{Coherence, Hit, HitPacket, OfKind, SceneSubset, Search};

/// Factors between which the width may lie over which the textures of a kept place were filtered: as footprints of samples, which are
/// steps of the root of 2.
const WIDTHS: [f32; 2] = [0.84, 1.19];

/// A kept sample on its way to a cell: the part of its way that is still to be verified.
#[derive(Debug, Clone, Copy)]
struct Attempt {
    /// Index of the surface that was met.
    met: usize,
    /// Number and data of the kept sample.
    number: u32,
    sample: MirroredSample,
    links: Links,
    /// Links that it has passed.
    passed: usize,
    /// Begin of the next ray.
    origin: Vec3,
    /// What it leads to: the image of the sample as it is seen from there.
    goal: Vec3,
}

/// A kept sample that serves in the place of a surface that a ray has met.
#[derive(Debug, Clone, Copy)]
pub struct Served {
    /// That surface, from which rays go on as ever.
    pub met: MetSurface,
    pub sample: MirroredSample,
    /// Where the eye sees it.
    pub image: Vec3,
    /// Length of the way to it.
    pub length: f32,
    /// Surfaces on that way.
    pub links: usize,
}

/// Scratch memory of a worker for what flat mirrors show in the tile at work.
#[derive(Debug, Default)]
pub struct Mirrors {
    /// Number of the tile.
    number: usize,
    attempts: Vec<Attempt>,
    /// True for each surface that was met for which one serves.
    is_served: Vec<bool>,
    kinds: Vec<RayKind>,
    /// Of the rays that were followed last.
    pub served: Vec<Served>,
    /// True if all that serve in the tile are to be known at its end: for the audit.
    pub collects: bool,
    /// These, then.
    pub all_served: Vec<Served>,
    /// What the tile has used and made.
    pub of_tile: MirroredOfTile,
}

impl Mirrors {
    /// Clears the state for tile `number`.
    pub fn begin(&mut self, number: usize) {
        self.number = number;
        self.served.clear();
        self.all_served.clear();
        self.of_tile.used.clear();
        self.of_tile.made.clear();
    }

    /// Takes those surfaces out of `met` for which a kept sample serves, and leaves these in [`served`](Self::served).
    pub fn serve(
        &mut self,
        frame: &FrameView,
        ways: &Ways,
        met: &mut MetSurfaces,
        scratch: &mut TraceScratch,
    ) {
        self.served.clear();
        let Some(before) = frame.mirrored.filter(|before| !before.all().is_empty()) else { return };
        self.attempts.clear();
        for (number, met) in met.all.iter().enumerate().filter(|(_, met)| met.is_kept) {
            let links = ways.links(met.bounce.way);
            let Some(target) = Target::of(frame, self.number, met, &links) else { continue };
            let mut best: Option<(f32, u32, MirroredSample)> = None;
            before.near((met.model, target.octave), (target.place, target.normal), |number, sample| {
                if let Some(off) = target.distance(frame, sample)
                    && best.is_none_or(|(least, first, _)| (off, number) < (least, first))
                {
                    best = Some((off, number, *sample));
                }
            });
            if let Some((_, kept, sample)) = best {
                let (origin, goal) = (frame.view.camera.eye, links.image(sample.point));
                self.attempts.push(Attempt {
                    met: number,
                    number: kept,
                    sample,
                    links,
                    passed: 0,
                    origin,
                    goal,
                });
            }
        }
        self.verify(frame, met, scratch);
    }

    /// Traces the ways of all attempts from the eye on, surface by surface. Those that arrive serve.
    fn verify(&mut self, frame: &FrameView, met: &mut MetSurfaces, scratch: &mut TraceScratch) {
        let Self { attempts, is_served, kinds, served, collects, all_served, of_tile, .. } = self;
        let tells_kinds = frame.hides_from_some || frame.view.camera.clip != Clip::NONE;
        is_served.clear();
        is_served.resize(met.all.len(), false);
        while !attempts.is_empty() {
            scratch.begin_rays();
            kinds.clear();
            for attempt in &*attempts {
                scratch.rays.push(attempt.origin, attempt.goal - attempt.origin, 0.0, f32::INFINITY);
                let cell = met.all[attempt.met].bounce.cell as usize;
                let counted = &mut scratch.tally.cells.verification[cell];
                *counted = counted.saturating_add(1);
                if tells_kinds {
                    let link = attempt.links.as_slice().get(attempt.passed);
                    kinds.push(link.map_or(met.all[attempt.met].bounce.ray_kind, |link| link.ray_kind));
                }
            }
            scratch.tally.counts.verification += attempts.len() as u64;
            // not as packets, though the first ones begin at the eye: of two surfaces in one place the same is met for whoever asks
            let coherence = Coherence::Bounced;
            let search = Search { kinds: OfKind::of(kinds), among: SceneSubset::All, coherence };
            frame.tracer.closest(&scratch.rays, search, &mut scratch.hits);
            let mut ray = 0;
            attempts.retain_mut(|attempt| {
                let hit = scratch.hits.get(ray);
                ray += 1;
                let Some(hit) = hit else { return false };
                if attempt.passed < attempt.links.as_slice().len() {
                    return attempt.pass(frame, hit);
                }
                if attempt.arrives(frame, hit) {
                    is_served[attempt.met] = true;
                    of_tile.used.push(attempt.number);
                    let image = attempt.links.image(attempt.sample.point);
                    served.push(Served {
                        met: met.all[attempt.met],
                        sample: attempt.sample,
                        image,
                        length: (image - frame.view.camera.eye).length(),
                        links: attempt.links.as_slice().len(),
                    });
                }
                false
            });
        }
        if *collects {
            all_served.extend_from_slice(served);
        }
        if !served.is_empty() {
            let mut of_met = is_served.iter();
            met.all.retain(|_| of_met.next() != Some(&true));
        }
    }

    /// Keeps those of the surfaces that were met, and lit, that later frames may show again.
    pub fn keep(&mut self, frame: &FrameView, ways: &Ways, met: &MetSurfaces) {
        for met in met.all.iter().filter(|met| met.is_kept) {
            let expires = frame.motion.expires_next(met.until, frame.pose.moment);
            if expires || !met.light.is_finite() {
                continue;
            }
            let distance =
                (ways.links(met.bounce.way).image(met.surface.point) - frame.view.camera.eye).length();
            self.of_tile.made.push(MirroredSample {
                point: met.surface.point,
                weights: met.weights,
                model: met.model,
                triangle: met.triangle,
                geometric_normal: Octahedral::fold(met.surface.geometric_normal),
                light: met.light,
                width: met.surface.width,
                until: met.until,
                paths: met.paths as u16,
                octave: octave_of(width_of_cell(frame, distance)),
                unused: 0,
            });
        }
    }
}

impl Attempt {
    /// Goes on over the next link, if the ray towards it met it.
    fn pass(&mut self, frame: &FrameView, hit: Hit) -> bool {
        let link = &self.links.as_slice()[self.passed];
        let Some(beyond) = link.beyond(frame, (self.origin, self.goal - self.origin), hit) else {
            return false;
        };
        self.goal = link.image(self.goal);
        self.origin = beyond;
        self.passed += 1;
        true
    }

    /// Returns true if the last ray met the sample.
    fn arrives(&self, frame: &FrameView, hit: Hit) -> bool {
        let way = self.goal - self.origin;
        let off = (hit.t - 1.0).abs() * way.length();
        let distance = (self.links.image(self.sample.point) - frame.view.camera.eye).length();
        hit.model == self.sample.model && off <= ONE_PLACE * distance + rounding(self.sample.point)
    }
}

/// What a kept sample must be to serve for a surface that was met.
struct Target<'a> {
    met: &'a MetSurface,
    links: &'a Links,
    /// Where the line through the cell's centre meets the tangent plane of what was met: world space.
    place: Vec3,
    /// Normal of the triangle that was met.
    normal: Vec3,
    /// Width of a cell there.
    width: f32,
    /// Size of voxels there.
    octave: i8,
    /// Centre of the cell, in cells.
    centre: [f32; 2],
}

impl<'a> Target<'a> {
    /// The target of the surface that a ray of tile `number` has met by way of `links`; none where the surface is seen edge on.
    fn of(frame: &FrameView, number: usize, met: &'a MetSurface, links: &'a Links) -> Option<Self> {
        /// Largest distance of the place from what was met, in cells.
        const FARTHEST: f32 = 8.0;
        let (corner, at) = (frame.view.grid.tile_corner(number), place(met.bounce.cell as usize));
        let centre = [0, 1].map(|axis| (corner[axis] + at[axis] as i32) as f32 + 0.5);
        let [_, sight] = frame.view.middle().rays(F32x8::splat(centre[0]), F32x8::splat(centre[1]));
        let (eye, sight) = (frame.view.camera.eye, sight.lane(0));
        let Surface { point, geometric_normal, .. } = met.surface;
        let (image, normal) = (links.image(point) - eye, links.image_of_direction(geometric_normal));
        let t = image.dot(normal) / sight.dot(normal);
        let width = width_of_cell(frame, image.length());
        let seen = t * sight;
        // false for NaN as well
        let is_near = t > 0.0 && (seen - image).length() <= FARTHEST * width;
        is_near.then(|| Self {
            met,
            links,
            place: links.original(eye + seen),
            normal: geometric_normal,
            width,
            octave: octave_of(width),
            centre,
        })
    }

    /// Distance, in cells, of the image of a kept sample from the centre of the cell, if it may serve.
    fn distance(&self, frame: &FrameView, sample: &MirroredSample) -> Option<f32> {
        /// Widths by which the image of what lies within reach may seem further away from here, where cells are taken to be square.
        const ROOM: f32 = 1.25;
        let Self { met, links, place, normal, width, octave, centre } = self;
        let surface = &met.surface;
        let is_same = sample.model == met.model
            && sample.octave == *octave
            && u32::from(sample.paths) >= met.paths
            && !frame.has_expired(sample.until);
        if !is_same {
            return None;
        }
        let mesh = &frame.scene.models[sample.model as usize].mesh;
        let is_as_wide = || {
            let [least, most] = WIDTHS.map(|factor| factor * surface.width);
            !frame.palette.has_textures || (least..=most).contains(&sample.width)
        };
        if mesh.material_of[sample.triangle as usize] != surface.material || !is_as_wide() {
            return None;
        }
        let off = sample.point - *place;
        let along = met.bounce.direction;
        if (off - off.dot(along) * along).length_squared() > (ROOM * REACH * width).powi(2) {
            return None;
        }
        let (apart, layer) = (sample.point - surface.point, LAYER * width);
        let of_sample = sample.geometric_normal.unfold();
        let is_on = apart.dot(*normal).abs() <= layer
            && apart.dot(of_sample).abs() <= layer
            && normal.dot(of_sample) >= ABOUT_PARALLEL;
        if !is_on {
            return None;
        }
        let seen = frame.view.project_one(links.image(sample.point) - frame.view.camera.eye, MIDDLE_TICK)?;
        let off = (seen.truncate() - Vec2::from(*centre)).length();
        (off <= REACH).then_some(off)
    }
}

/// Returns true if the light of what a ray has met may be kept, and served by what was: a matt surface of triangles, by way of flat
/// mirrors.
pub fn may_be_kept(frame: &FrameView, bounce: &Bounce, surface: &Surface, model: u32) -> bool {
    frame.mirrored.is_some()
        && bounce.way != Way::BENT
        && bounce.within == Within::NOTHING
        && frame.palette.is_matt(surface.material)
        && !frame.scene.models[model as usize].mesh.is_curved()
}

/// The surface of a kept sample as the ray that leads to it in `direction` sees it, to the bit as it was met.
pub fn surface_of(frame: &FrameView, sample: &MirroredSample, direction: Vec3) -> Surface {
    let mut packet = HitPacket::NONE;
    [packet.u[0], packet.v[0]] = sample.weights;
    (packet.t[0], packet.model[0], packet.triangle[0]) = (1.0, sample.model, sample.triangle);
    let mut found = None;
    let hits = Hits8::new(&packet, 0);
    surfaces(
        frame,
        &hits,
        1,
        |_| direction,
        |_| sample.width,
        |_| MIDDLE_TICK,
        |_, surface| {
            found = Some(surface);
        },
    );
    found.expect("the hit is there")
}

/// Width of a cell at a distance from the eye.
fn width_of_cell(frame: &FrameView, distance: f32) -> f32 {
    frame.view.spread().by_distance * distance
}
