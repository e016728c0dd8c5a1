//! Curved geometry: each ray is traced by itself, through a tree over all primitives. Those of models that are
//! still are in world space; for moving ones the ray is taken into the space of each.

use std::sync::Arc;

use glam::{Affine3A, Vec3};

use super::beam::{Open, Probe, Ray as Line, Visitor, walk};
use super::rays::{Rays, first_of, open_lanes};
use super::search::{Exempt, put};
use crate::exposure::Tick;
use crate::geometry::Curved;
use crate::geometry::curved::Ray;
use crate::geometry::tree::{Box3, Tree};
use crate::pose::Pose;
use crate::scene::{Model, Scene};
use crate::trace::{HitPacket, LANES};

/// A primitive of a curved geometry in a scene.
#[derive(Debug, Clone)]
struct Primitive {
    of: Arc<dyn Curved>,
    model: u32,
    number: u32,
    casts_shadow: bool,
    /// Bounds, object space.
    bounds: Box3,
}

/// All curved primitives of a scene, or those that cast shadows: still ones, and the others.
pub struct CurvedPrimitives {
    still: Standing,
    movable: Vec<Primitive>,
}

/// Curved primitives in one frame, or for the whole shot.
pub struct Standing {
    primitives: Vec<Primitive>,
    /// Places by primitive, for those that move.
    places: Vec<Place>,
    /// Tree over the primitives, world space; its leaves are their numbers.
    tree: Tree,
}

#[derive(Debug, Clone, Copy)]
struct Place {
    to_object: Affine3A,
    /// True if it moved since the frame before.
    moved: bool,
}

impl CurvedPrimitives {
    /// Collects the primitives of those models of `scene`, with their numbers, that rays `see`; `casters`: only those that cast shadows.
    pub fn new(scene: &Scene, see: impl Fn(usize, &Model) -> bool, casters: bool) -> Self {
        let (mut still, mut movable) = (Vec::new(), Vec::new());
        let models = scene.models.iter().zip(0_u32..);
        for (model, number) in models.filter(|(model, number)| see(*number as usize, model)) {
            let Some(curved) = model.mesh.as_curved() else { continue };
            let casting = model.mesh.shadow_casting as u32;
            let count = if casters { casting } else { curved.count() };
            let list = if model.track.is_constant() { &mut still } else { &mut movable };
            list.extend((0..count).map(|primitive| {
                let bounds = curved.bounds(primitive);
                let bounds = Box3 { low: bounds.low.to_array(), high: bounds.high.to_array() };
                let (of, casts_shadow) = (Arc::clone(curved), primitive < casting);
                Primitive { of, model: number, number: primitive, casts_shadow, bounds }
            }));
        }
        let boxes: Vec<Box3> = still.iter().map(|primitive| primitive.bounds).collect();
        let tree = Tree::new(&boxes, 1, |ids| ids[0]);
        Self { still: Standing { primitives: still, places: Vec::new(), tree }, movable }
    }

    /// Those that never move.
    pub fn still(&self) -> &Standing {
        &self.still
    }

    /// Those that move, as they are in one frame.
    pub fn open(&self, (pose, tick): (&Pose, Tick), moved: &[bool]) -> Standing {
        let transform = |one: &Primitive| pose.transform(one.model as usize, tick);
        let place =
            |one: &Primitive| Place { to_object: transform(one).to_object, moved: moved[one.model as usize] };
        let is_there = |one: &&Primitive| pose.models[one.model as usize].is_visible;
        let primitives: Vec<Primitive> = self.movable.iter().filter(is_there).cloned().collect();
        let boxes: Vec<Box3> = primitives.iter().map(|one| one.bounds.placed(transform(one))).collect();
        let tree = Tree::new(&boxes, 1, |ids| ids[0]);
        Standing { places: primitives.iter().map(place).collect(), primitives, tree }
    }
}

impl Standing {
    /// Returns true if there are none.
    pub fn is_empty(&self) -> bool {
        self.primitives.is_empty()
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

    /// Ray number `lane`, in the space of a primitive.
    #[inline(always)]
    fn ray(&self, primitive: usize, rays: &Rays, lane: usize, far: f32, ends_here: bool) -> Ray {
        let of = |rays: &Rays| {
            let [origin, direction] = [&rays.origin, &rays.direction];
            let three = |rows: &[[f32; LANES]; 3]| Vec3::new(rows[0][lane], rows[1][lane], rows[2][lane]);
            Ray { origin: three(origin), direction: three(direction), near: rays.near[lane], far, ends_here }
        };
        match self.places.get(primitive) {
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
        let (primitive, lane) = (&self.standing.primitives[leaf as usize], self.lane);
        let ray = self.standing.ray(leaf as usize, self.rays, lane, self.best.t[lane], false);
        if let Some(met) = primitive.of.meet(primitive.number, &ray) {
            put(
                self.best,
                lane,
                [met.t, met.weights[0], met.weights[1]],
                (primitive.model, primitive.number),
            );
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
        let (primitive, leaf) = (&self.standing.primitives[leaf as usize], leaf as usize);
        let rests = self.standing.places.get(leaf).is_some_and(|place| !place.moved);
        if self.exempt.clear && !primitive.casts_shadow || self.moved_alone && rests {
            return;
        }
        let is_own = self.exempt.is_own(self.lane, (primitive.model, primitive.number));
        let ray = self.standing.ray(leaf, self.rays, self.lane, *self.far, is_own);
        if *self.far != f32::NEG_INFINITY && primitive.of.meet(primitive.number, &ray).is_some() {
            *self.far = f32::NEG_INFINITY;
            probe.end_at(f32::NEG_INFINITY);
        }
    }
}
