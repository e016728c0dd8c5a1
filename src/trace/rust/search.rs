//! Both queries, for the rays of a beam together and for a single ray: the tests at the leaves.

use super::beam::{Beam, Open, Probe, Ray, Visitor, walk};
use super::rays::{HALVES, Pace, Rays, eight_of, first_of, open_lanes};
use super::triangles::{Axes, Block, Meeting, OF_INSTANCE, Shear, Shown};
use crate::geometry::tree::WIDTH;
use crate::lanes::F32x8;
use crate::scene::cutout::Asks;
use crate::trace::{Coherence, HitPacket, LANES, NO_HIT};

/// Largest number of triangles that a beam is tested against before its rays are traced one by one: more mean
/// that the beam is wide compared with the triangles, and most of them are met by few of its rays.
const MOST_TRIANGLES: u32 = 64;

/// Name of a triangle: its model and its number.
type Name = (u32, u32);

// the lesser of the triangle's own model and that of its instance is the valid one
const _: () = assert!(OF_INSTANCE == u32::MAX && NO_HIT == u32::MAX);

#[inline(always)]
fn name_of(block: &Block, at: usize, instance: u32) -> Name {
    (block.model[at].min(instance), block.triangle[at])
}

/// Removes the lowest of `bits`, which are not all zero, and returns its number.
#[inline(always)]
fn take(bits: &mut u32) -> usize {
    let at = bits.trailing_zeros() as usize % WIDTH;
    *bits &= *bits - 1;
    at
}

/// Weights of the second and the third corner in lane `at`.
#[inline(always)]
fn weights(meeting: &Meeting, at: usize) -> [f32; 2] {
    [meeting.u.lane(at), meeting.v.lane(at)]
}

/// Corners of one triangle in all lanes.
#[inline(always)]
fn corners_of(block: &Block, at: usize, axes: Axes) -> [[F32x8; 3]; 3] {
    [block.corner_of(0, at, axes), block.corner_of(1, at, axes), block.corner_of(2, at, axes)]
}

/// Corners of eight triangles.
#[inline(always)]
fn all_corners(block: &Block, axes: Axes) -> [[F32x8; 3]; 3] {
    [block.corner(0, axes), block.corner(1, axes), block.corner(2, axes)]
}

/// Shortens the rays `used` of `best`, all of one kind, to their first hits among what is
/// `shown`. Returns true if the search was completed; otherwise the rays are to be
/// traced one by one.
#[inline(always)]
pub fn closest_of_beam(
    shown: Shown<'_>,
    rays: &Rays,
    used: u16,
    best: &mut HitPacket,
    stack: &mut Vec<Open>,
) -> bool {
    let (common, pace) = rays.common(used, &best.t);
    let (axes, shears) = rays.shears(used);
    let mut beam = Beam::new(&common, &shown.triangles.tree.bounds);
    let mut visitor = ClosestOfBeam { shown, axes, shears, used, pace, tested: 0, best };
    walk::<true, _>(&mut beam, &shown.triangles.tree, stack, &mut visitor);
    visitor.tested <= MOST_TRIANGLES
}

struct ClosestOfBeam<'a> {
    shown: Shown<'a>,
    axes: Axes,
    shears: [Shear; HALVES],
    used: u16,
    pace: Pace,
    /// Number of triangles tested so far.
    tested: u32,
    best: &'a mut HitPacket,
}

impl Visitor<Beam> for ClosestOfBeam<'_> {
    #[inline(always)]
    fn visit(&mut self, beam: &mut Beam, leaf: u32, _: &mut Vec<Open>) {
        let mut room = None;
        let block = self.shown.block(leaf, &mut room);
        let (mut met, _) = beam.meet(&block.planes());
        self.tested += met.count_ones();
        let mut closer = false;
        while met != 0 {
            let at = take(&mut met);
            let corners = corners_of(block, at, self.axes);
            for half in 0..HALVES {
                let far = eight_of(&self.best.t, half);
                let Some(meeting) = self.shears[half].meet(corners, far) else { continue };
                let (t, u, v) = (*meeting.t.values(), *meeting.u.values(), *meeting.v.values());
                let name = name_of(block, at, self.shown.model);
                let mut hits = u32::from(meeting.mask.bits());
                while hits != 0 {
                    let i = take(&mut hits);
                    if self.shown.triangles.is_there(block, at, [u[i], v[i]], Asks::Sight) {
                        closer |= put(self.best, half * WIDTH + i, [t[i], u[i], v[i]], name);
                    }
                }
            }
        }
        if self.tested > MOST_TRIANGLES {
            beam.end_at(f32::NEG_INFINITY);
        } else if closer {
            beam.end_at(self.pace.greatest(&self.best.t, self.used));
        }
    }
}

/// [`closest_of_beam`] for ray number `lane` alone.
#[inline(always)]
pub fn closest_of_ray(
    shown: Shown<'_>,
    rays: &Rays,
    lane: usize,
    best: &mut HitPacket,
    stack: &mut Vec<Open>,
) {
    let (mut ray, axes, shear) = rays.one(lane, best.t[lane], &shown.triangles.tree.bounds);
    let mut visitor = ClosestOfRay { shown, axes, shear, lane, best };
    walk::<true, _>(&mut ray, &shown.triangles.tree, stack, &mut visitor);
}

struct ClosestOfRay<'a> {
    shown: Shown<'a>,
    axes: Axes,
    shear: Shear,
    lane: usize,
    best: &'a mut HitPacket,
}

impl Visitor<Ray> for ClosestOfRay<'_> {
    #[inline(always)]
    fn visit(&mut self, ray: &mut Ray, leaf: u32, _: &mut Vec<Open>) {
        let mut room = None;
        let (lane, block) = (self.lane, self.shown.block(leaf, &mut room));
        let far = F32x8::splat(self.best.t[lane]);
        let Some(meeting) = self.shear.meet(all_corners(block, self.axes), far) else { return };
        let (t, u, v) = (*meeting.t.values(), *meeting.u.values(), *meeting.v.values());
        let mut hits = u32::from(meeting.mask.bits());
        while hits != 0 {
            let i = take(&mut hits);
            if self.shown.triangles.is_there(block, i, [u[i], v[i]], Asks::Sight) {
                put(self.best, lane, [t[i], u[i], v[i]], name_of(block, i, self.shown.model));
            }
        }
        ray.end_at(self.best.t[lane]);
    }
}

/// Takes a hit if it is closer than that of ray number `lane`, and returns true if it was. Among hits at the
/// same distance the lowest name wins: the result does not depend on the order of traversal.
#[inline(always)]
pub fn put(best: &mut HitPacket, lane: usize, [t, u, v]: [f32; 3], name: Name) -> bool {
    let old = (best.model[lane], best.triangle[lane]);
    let closer = t < best.t[lane] || (t == best.t[lane] && name < old);
    if closer {
        (best.t[lane], best.u[lane], best.v[lane]) = (t, u, v);
        (best.model[lane], best.triangle[lane]) = name;
    }
    closer
}

/// Triangles that never block a ray.
#[derive(Clone, Copy)]
pub struct Exempt<'a> {
    /// True if triangles that cast no shadow do not block.
    pub clear: bool,
    /// Model and triangle that each ray ends on, if any.
    pub own: Option<(&'a [u32; LANES], &'a [u32; LANES])>,
}

impl Exempt<'_> {
    /// Bit mask of the triangles of `block` that may block anything.
    #[inline(always)]
    fn candidates(&self, block: &Block) -> u32 {
        if self.clear { block.casts_shadow } else { u32::MAX }
    }

    /// What the rays ask of places.
    fn asks(&self) -> Asks {
        if self.clear { Asks::Shadow } else { Asks::Sight }
    }

    /// Returns true if ray number `lane` ends on the triangle of this name.
    #[inline(always)]
    pub fn is_own(&self, lane: usize, name: Name) -> bool {
        match self.own {
            Some((model, triangle)) => (model[lane], triangle[lane]) == name,
            None => false,
        }
    }
}

/// Ends those of the rays `used`, all of one kind, that what is `shown` blocks: `far` becomes minus infinity.
/// Returns true if the search was completed, like
/// [`closest_of_beam`].
#[inline(always)]
pub fn block_beam(
    shown: Shown<'_>,
    rays: &Rays,
    used: u16,
    exempt: Exempt<'_>,
    far: &mut [f32; LANES],
    stack: &mut Vec<Open>,
) -> bool {
    let (common, pace) = rays.common(used, far);
    let (axes, shears) = rays.shears(used);
    let mut beam = Beam::new(&common, &shown.triangles.tree.bounds);
    let mut visitor = BlockBeam { shown, axes, shears, used, pace, tested: 0, exempt, far };
    walk::<false, _>(&mut beam, &shown.triangles.tree, stack, &mut visitor);
    visitor.tested <= MOST_TRIANGLES
}

struct BlockBeam<'a> {
    shown: Shown<'a>,
    axes: Axes,
    shears: [Shear; HALVES],
    used: u16,
    pace: Pace,
    /// Number of triangles tested so far.
    tested: u32,
    exempt: Exempt<'a>,
    far: &'a mut [f32; LANES],
}

impl Visitor<Beam> for BlockBeam<'_> {
    #[inline(always)]
    fn visit(&mut self, beam: &mut Beam, leaf: u32, _: &mut Vec<Open>) {
        let mut room = None;
        let block = self.shown.block(leaf, &mut room);
        let (met, _) = beam.meet(&block.planes());
        // triangles that cannot block show all the same how wide the beam is
        self.tested += met.count_ones();
        let mut met = met & self.exempt.candidates(block);
        let mut any = false;
        while met != 0 {
            let at = take(&mut met);
            let corners = corners_of(block, at, self.axes);
            for half in 0..HALVES {
                let far = eight_of(self.far, half);
                let Some(meeting) = self.shears[half].meet(corners, far) else { continue };
                let mut hits = u32::from(meeting.mask.bits());
                while hits != 0 {
                    let i = take(&mut hits);
                    let lane = half * WIDTH + i;
                    if !self.exempt.is_own(lane, name_of(block, at, self.shown.model))
                        && self.shown.triangles.is_there(block, at, weights(&meeting, i), self.exempt.asks())
                    {
                        self.far[lane] = f32::NEG_INFINITY;
                        any = true;
                    }
                }
            }
        }
        if self.tested > MOST_TRIANGLES {
            beam.end_at(f32::NEG_INFINITY);
        } else if any {
            beam.end_at(self.pace.greatest(self.far, self.used));
        }
    }
}

/// [`block_beam`] for ray number `lane` alone.
#[inline(always)]
pub fn block_ray(
    shown: Shown<'_>,
    rays: &Rays,
    lane: usize,
    exempt: Exempt<'_>,
    far: &mut [f32; LANES],
    stack: &mut Vec<Open>,
) {
    let (mut ray, axes, shear) = rays.one(lane, far[lane], &shown.triangles.tree.bounds);
    let end = F32x8::splat(far[lane]);
    let mut visitor = BlockRay { shown, axes, shear, lane, end, exempt, blocked: false };
    walk::<false, _>(&mut ray, &shown.triangles.tree, stack, &mut visitor);
    if visitor.blocked {
        far[lane] = f32::NEG_INFINITY;
    }
}

struct BlockRay<'a> {
    shown: Shown<'a>,
    axes: Axes,
    shear: Shear,
    lane: usize,
    end: F32x8,
    exempt: Exempt<'a>,
    blocked: bool,
}

impl Visitor<Ray> for BlockRay<'_> {
    #[inline(always)]
    fn visit(&mut self, ray: &mut Ray, leaf: u32, _: &mut Vec<Open>) {
        let mut room = None;
        let block = self.shown.block(leaf, &mut room);
        let corners = all_corners(block, self.axes);
        let Some(meeting) = self.shear.meet(corners, self.end) else { return };
        let mut hits = u32::from(meeting.mask.bits()) & self.exempt.candidates(block);
        while hits != 0 {
            let at = take(&mut hits);
            if !self.exempt.is_own(self.lane, name_of(block, at, self.shown.model))
                && self.shown.triangles.is_there(block, at, weights(&meeting, at), self.exempt.asks())
            {
                self.blocked = true;
                ray.end_at(f32::NEG_INFINITY);
                return;
            }
        }
    }
}

/// Least number of rays of one direction that make a beam; fewer are traced one by one.
const LEAST_BEAM: u32 = 3;

/// Rays among `rest` (at least one) that are traced next, together: a beam, or a single ray.
#[inline(always)]
pub fn next_beam(rays: &Rays, rest: u16, coherence: Coherence) -> u16 {
    match coherence {
        // beams pay for bounced rays too: a tenth of the time in a city of glass, for 3 % lost in a kitchen
        Coherence::Coherent | Coherence::Bounced | Coherence::SharedOrigin => rays.like_first(rest),
        Coherence::Incoherent => rest & rest.wrapping_neg(),
    }
}

/// Shortens the rays `used` to their first hits among what is `shown`.
#[inline(always)]
pub fn closest_of(
    shown: Shown<'_>,
    rays: &Rays,
    used: u16,
    coherence: Coherence,
    best: &mut HitPacket,
    stack: &mut Vec<Open>,
) {
    let mut rest = used;
    while rest != 0 {
        let mut beam = next_beam(rays, rest, coherence);
        rest &= !beam;
        if beam.count_ones() >= LEAST_BEAM && closest_of_beam(shown, rays, beam, best, stack) {
            continue;
        }
        while beam != 0 {
            closest_of_ray(shown, rays, first_of(beam), best, stack);
            beam &= beam - 1;
        }
    }
}

/// Ends those of the rays `used` that what is `shown` blocks.
#[inline(always)]
pub fn block(
    shown: Shown<'_>,
    rays: &Rays,
    used: u16,
    coherence: Coherence,
    exempt: Exempt<'_>,
    far: &mut [f32; LANES],
    stack: &mut Vec<Open>,
) {
    let mut rest = used;
    while rest != 0 {
        let mut beam = next_beam(rays, rest, coherence);
        rest &= !beam;
        if beam.count_ones() >= LEAST_BEAM && block_beam(shown, rays, beam, exempt, far, stack) {
            continue;
        }
        beam &= open_lanes(far);
        while beam != 0 {
            block_ray(shown, rays, first_of(beam), exempt, far, stack);
            beam &= beam - 1;
        }
    }
}
