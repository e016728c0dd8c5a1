//! Quadrics: each ray is traced by itself, through a tree over their pieces. Still ones are in world space;
//! for moving ones the ray is taken into the space of each.

use std::sync::Arc;

use glam::{Affine3A, Vec3};

use super::beam::{Open, Probe, Ray as Line, Visitor, walk};
use super::rays::{Rays, first_of, open_lanes};
use super::search::{Exempt, put};
use crate::exposure::Tick;
use crate::geometry::Quadric;
use crate::geometry::quadric::Ray;
use crate::geometry::tree::{Box3, Tree};
use crate::pose::Pose;
use crate::scene::{RayKind, Scene};
use crate::trace::{HitPacket, LANES};

/// A piece of a quadric in a scene.
#[derive(Debug, Clone)]
struct Piece {
    quadric: Arc<Quadric>,
    model: u32,
    number: u32,
    casts_shadow: bool,
    /// Bounds, object space.
    bounds: Box3,
}

/// All quadrics of a scene, or those that cast shadows: still ones, and the others.
pub struct Quadrics {
    still: Standing,
    movable: Vec<Piece>,
}

/// Quadrics in one frame, or for the whole shot.
pub struct Standing {
    pieces: Vec<Piece>,
    /// Places by piece, for those that move.
    places: Vec<Place>,
    /// Tree over the pieces, world space; its leaves are their numbers.
    tree: Tree,
}

#[derive(Debug, Clone, Copy)]
struct Place {
    to_object: Affine3A,
    /// True if it moved since the frame before.
    moved: bool,
}

impl Quadrics {
    /// Collects the quadrics of `scene` that rays of this kind see; `casters`: only those that cast shadows.
    pub fn new(scene: &Scene, kind: RayKind, casters: bool) -> Self {
        let (mut still, mut movable) = (Vec::new(), Vec::new());
        for (model, number) in
            scene.models.iter().zip(0..).filter(|(model, _)| model.ray_visibility.is_seen_by(kind))
        {
            let casts_shadow = model.mesh.shadow_casting > 0;
            let Some(quadric) = model.mesh.quadric.as_ref().filter(|_| casts_shadow || !casters) else {
                continue;
            };
            let list = if model.track.is_constant() { &mut still } else { &mut movable };
            list.extend((0..quadric.count()).map(|piece| {
                let bounds = quadric.bounds(piece);
                let bounds = Box3 { low: bounds.low.to_array(), high: bounds.high.to_array() };
                let quadric = Arc::clone(quadric);
                Piece { quadric, model: number, number: piece, casts_shadow, bounds }
            }));
        }
        let boxes: Vec<Box3> = still.iter().map(|piece| piece.bounds).collect();
        let tree = Tree::new(&boxes, 1, |ids| ids[0]);
        Self { still: Standing { pieces: still, places: Vec::new(), tree }, movable }
    }

    /// Quadrics that never move.
    pub fn still(&self) -> &Standing {
        &self.still
    }

    /// Quadrics that move, as they are in one frame.
    pub fn open(&self, (pose, tick): (&Pose, Tick), moved: &[bool]) -> Standing {
        let transform = |piece: &Piece| pose.transform(piece.model as usize, tick);
        let place = |piece: &Piece| Place {
            to_object: transform(piece).to_object,
            moved: moved[piece.model as usize],
        };
        let is_there = |piece: &&Piece| pose.models[piece.model as usize].is_visible;
        let pieces: Vec<Piece> = self.movable.iter().filter(is_there).cloned().collect();
        let boxes: Vec<Box3> = pieces.iter().map(|piece| piece.bounds.placed(transform(piece))).collect();
        let tree = Tree::new(&boxes, 1, |ids| ids[0]);
        Standing { places: pieces.iter().map(place).collect(), pieces, tree }
    }
}

impl Standing {
    /// Returns true if there are none.
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// Shortens the rays `used` to their first hits.
    #[inline(always)]
    pub fn closest(&self, rays: &Rays, mut used: u16, best: &mut HitPacket, stack: &mut Vec<Open>) {
        while used != 0 {
            let lane = first_of(used);
            used &= used - 1;
            let (mut probe, ..) = rays.one(lane, best.t[lane], &self.tree.bounds);
            let mut visitor = Closest { standing: self, rays, lane, best };
            walk::<true, _>(&mut probe, &self.tree, stack, &mut visitor);
        }
    }

    /// Ends those of the rays `used` that are blocked.
    #[inline(always)]
    pub fn block(
        &self,
        moved_alone: bool,
        rays: &Rays,
        used: u16,
        exempt: Exempt<'_>,
        far: &mut [f32; LANES],
        stack: &mut Vec<Open>,
    ) {
        let mut open = used & open_lanes(far);
        while open != 0 {
            let lane = first_of(open);
            open &= open - 1;
            let (mut probe, ..) = rays.one(lane, far[lane], &self.tree.bounds);
            let mut visitor =
                Blocking { standing: self, moved_alone, rays, lane, exempt, far: &mut far[lane] };
            walk::<false, _>(&mut probe, &self.tree, stack, &mut visitor);
        }
    }

    /// Ray number `lane`, in the space of a piece.
    #[inline(always)]
    fn ray(&self, piece: usize, rays: &Rays, lane: usize, far: f32, ends_here: bool) -> Ray {
        let of = |rays: &Rays| {
            let [origin, direction] = [&rays.origin, &rays.direction];
            let three = |rows: &[[f32; LANES]; 3]| Vec3::new(rows[0][lane], rows[1][lane], rows[2][lane]);
            Ray { origin: three(origin), direction: three(direction), near: rays.near[lane], far, ends_here }
        };
        match self.places.get(piece) {
            Some(place) => of(&rays.transformed(&place.to_object, 1 << lane)),
            None => of(rays),
        }
    }
}

struct Closest<'a> {
    standing: &'a Standing,
    rays: &'a Rays,
    lane: usize,
    best: &'a mut HitPacket,
}

impl Visitor<Line> for Closest<'_> {
    #[inline(always)]
    fn visit(&mut self, probe: &mut Line, leaf: u32, _: &mut Vec<Open>) {
        let (piece, lane) = (&self.standing.pieces[leaf as usize], self.lane);
        let ray = self.standing.ray(leaf as usize, self.rays, lane, self.best.t[lane], false);
        if let Some(met) = piece.quadric.meet(piece.number, &ray) {
            put(self.best, lane, [met.t, met.weights[0], met.weights[1]], (piece.model, piece.number));
            probe.end_at(self.best.t[lane]);
        }
    }
}

struct Blocking<'a> {
    standing: &'a Standing,
    moved_alone: bool,
    rays: &'a Rays,
    lane: usize,
    exempt: Exempt<'a>,
    far: &'a mut f32,
}

impl Visitor<Line> for Blocking<'_> {
    #[inline(always)]
    fn visit(&mut self, probe: &mut Line, leaf: u32, _: &mut Vec<Open>) {
        let (piece, leaf) = (&self.standing.pieces[leaf as usize], leaf as usize);
        let rests = self.standing.places.get(leaf).is_some_and(|place| !place.moved);
        if self.exempt.clear && !piece.casts_shadow || self.moved_alone && rests {
            return;
        }
        let is_own = self.exempt.is_own(self.lane, (piece.model, piece.number));
        let ray = self.standing.ray(leaf, self.rays, self.lane, *self.far, is_own);
        if *self.far != f32::NEG_INFINITY && piece.quadric.meet(piece.number, &ray).is_some() {
            *self.far = f32::NEG_INFINITY;
            probe.end_at(f32::NEG_INFINITY);
        }
    }
}
