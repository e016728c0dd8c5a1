//! Curved geometry: each ray is traced by itself, through a tree over the models, and trees over the primitives of each geometry, which
//! are built once. Geometry of models that are still is in world space; for moving ones the ray is taken into the space of each.

use std::collections::HashMap;
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

/// A model of a curved geometry.
#[derive(Debug, Clone)]
struct CurvedModel {
    of: Arc<dyn Curved>,
    model: u32,
    /// Number of its primitives that cast shadows, from the first on.
    casting: u32,
    /// Tree over its primitives, object space; its leaves are their numbers. Models of one mesh share it.
    tree: Arc<Tree>,
}

/// All curved geometry of a scene, or what of it casts shadows: still models, and the others.
pub struct CurvedPrimitives {
    still: Standing,
    movable: Vec<CurvedModel>,
}

/// Curved geometry in one frame, or for the whole shot.
pub struct Standing {
    models: Vec<CurvedModel>,
    /// Places by model, for those that move.
    places: Vec<Place>,
    /// Tree over the models, world space; its leaves are their numbers here.
    above: Tree,
}

#[derive(Debug, Clone, Copy)]
struct Place {
    to_object: Affine3A,
    /// True if it moved since the frame before.
    moved: bool,
}

impl CurvedPrimitives {
    /// Collects the geometry of those models of `scene`, with their numbers, that rays `see`; `casters`: only primitives that cast shadows.
    pub fn new(scene: &Scene, see: impl Fn(usize, &Model) -> bool, casters: bool) -> Self {
        let (mut still, mut movable) = (Vec::new(), Vec::new());
        let mut trees: HashMap<(*const (), u32), Arc<Tree>> = HashMap::new();
        let models = scene.models.iter().zip(0_u32..);
        for (model, number) in models.filter(|(model, number)| see(*number as usize, model)) {
            let Some(curved) = model.mesh.as_curved() else { continue };
            let casting = model.mesh.shadow_casting as u32;
            let count = if casters { casting } else { curved.count() };
            if count == 0 {
                continue;
            }
            let tree = trees.entry((Arc::as_ptr(curved).cast(), count)).or_insert_with(|| {
                let parts = curved.boxes();
                let boxes: Vec<Box3> = (0..count * parts)
                    .map(|number| {
                        let bounds = curved.bounds_of_part(number / parts, number % parts);
                        Box3 { low: bounds.low.to_array(), high: bounds.high.to_array() }
                    })
                    .collect();
                Arc::new(Tree::new(&boxes, 1, |ids| ids[0] / parts))
            });
            let list = if model.track.is_constant() { &mut still } else { &mut movable };
            list.push(CurvedModel { of: Arc::clone(curved), model: number, casting, tree: Arc::clone(tree) });
        }
        let boxes: Vec<Box3> = still.iter().map(|model: &CurvedModel| model.tree.bounds).collect();
        let above = Tree::new(&boxes, 1, |ids| ids[0]);
        Self { still: Standing { models: still, places: Vec::new(), above }, movable }
    }

    /// What never moves.
    pub fn still(&self) -> &Standing {
        &self.still
    }

    /// What moves, as it is in one frame.
    pub fn open(&self, (pose, tick): (&Pose, Tick), moved: &[bool]) -> Standing {
        let transform = |one: &CurvedModel| pose.transform(one.model as usize, tick);
        let place = |one: &CurvedModel| Place {
            to_object: transform(one).to_object,
            moved: moved[one.model as usize],
        };
        let is_there = |one: &&CurvedModel| pose.models[one.model as usize].is_visible;
        let models: Vec<CurvedModel> = self.movable.iter().filter(is_there).cloned().collect();
        let boxes: Vec<Box3> = models.iter().map(|one| one.tree.bounds.placed(transform(one))).collect();
        let above = Tree::new(&boxes, 1, |ids| ids[0]);
        Standing { places: models.iter().map(place).collect(), models, above }
    }
}

impl Standing {
    /// Returns true if there is none.
    pub fn is_empty(&self) -> bool {
        self.models.is_empty()
    }

    /// Shortens the rays `used` to their first hits.
    #[inline(always)]
    pub fn closest(&self, rays: &Rays, mut used: u16, best: &mut HitPacket, stack: &mut Vec<Open>) {
        while used != 0 {
            let lane = first_of(used);
            used &= used - 1;
            let (mut probe, ..) = rays.one(lane, best.t[lane], &self.above.bounds);
            let mut visitor = ClosestModel { standing: self, rays, lane, best };
            walk::<true, _>(&mut probe, &self.above, stack, &mut visitor);
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
            let (mut probe, ..) = rays.one(lane, far[lane], &self.above.bounds);
            let mut visitor =
                BlockingModel { standing: self, moved_alone, rays, lane, exempt, far: &mut far[lane] };
            walk::<false, _>(&mut probe, &self.above, stack, &mut visitor);
        }
    }

    /// The rays, of which number `lane` counts, in the space of a model that moves; `None` of one that does not.
    #[inline(always)]
    fn rays_to(&self, model: usize, rays: &Rays, lane: usize) -> Option<Rays> {
        self.places.get(model).map(|place| rays.transformed(&place.to_object, 1 << lane))
    }
}

/// Ray number `lane`.
#[inline(always)]
fn ray(rays: &Rays, lane: usize, far: f32, ends_here: bool) -> Ray {
    let three = |rows: &[[f32; LANES]; 3]| Vec3::new(rows[0][lane], rows[1][lane], rows[2][lane]);
    let (origin, direction) = (three(&rays.origin), three(&rays.direction));
    Ray { origin, direction, near: rays.near[lane], far, ends_here }
}

struct ClosestModel<'a> {
    standing: &'a Standing,
    rays: &'a Rays,
    lane: usize,
    best: &'a mut HitPacket,
}

impl Visitor<Line> for ClosestModel<'_> {
    #[inline(always)]
    fn visit(&mut self, probe: &mut Line, leaf: u32, stack: &mut Vec<Open>) {
        let model = &self.standing.models[leaf as usize];
        let inside = self.standing.rays_to(leaf as usize, self.rays, self.lane);
        let rays = inside.as_ref().unwrap_or(self.rays);
        let (mut inner, ..) = rays.one(self.lane, self.best.t[self.lane], &model.tree.bounds);
        let mut visitor = Closest { model, rays, lane: self.lane, best: self.best };
        walk::<true, _>(&mut inner, &model.tree, stack, &mut visitor);
        probe.end_at(self.best.t[self.lane]);
    }
}

struct Closest<'a> {
    model: &'a CurvedModel,
    rays: &'a Rays,
    lane: usize,
    best: &'a mut HitPacket,
}

impl Visitor<Line> for Closest<'_> {
    #[inline(always)]
    fn visit(&mut self, probe: &mut Line, primitive: u32, _: &mut Vec<Open>) {
        let (model, lane) = (self.model, self.lane);
        let ray = ray(self.rays, lane, self.best.t[lane], false);
        if let Some(met) = model.of.meet(primitive, &ray) {
            put(self.best, lane, [met.t, met.weights[0], met.weights[1]], (model.model, primitive));
            probe.end_at(self.best.t[lane]);
        }
    }
}

struct BlockingModel<'a> {
    standing: &'a Standing,
    moved_alone: bool,
    rays: &'a Rays,
    lane: usize,
    exempt: Exempt<'a>,
    far: &'a mut f32,
}

impl Visitor<Line> for BlockingModel<'_> {
    #[inline(always)]
    fn visit(&mut self, probe: &mut Line, leaf: u32, stack: &mut Vec<Open>) {
        let leaf = leaf as usize;
        let rests = self.standing.places.get(leaf).is_some_and(|place| !place.moved);
        if self.moved_alone && rests || *self.far == f32::NEG_INFINITY {
            return;
        }
        let model = &self.standing.models[leaf];
        let inside = self.standing.rays_to(leaf, self.rays, self.lane);
        let rays = inside.as_ref().unwrap_or(self.rays);
        let (mut inner, ..) = rays.one(self.lane, *self.far, &model.tree.bounds);
        let mut visitor = Blocking { model, rays, lane: self.lane, exempt: self.exempt, far: self.far };
        walk::<false, _>(&mut inner, &model.tree, stack, &mut visitor);
        probe.end_at(*self.far);
    }
}

struct Blocking<'a> {
    model: &'a CurvedModel,
    rays: &'a Rays,
    lane: usize,
    exempt: Exempt<'a>,
    far: &'a mut f32,
}

impl Visitor<Line> for Blocking<'_> {
    #[inline(always)]
    fn visit(&mut self, probe: &mut Line, primitive: u32, _: &mut Vec<Open>) {
        let model = self.model;
        if self.exempt.clear && primitive >= model.casting {
            return;
        }
        let is_own = self.exempt.is_own(self.lane, (model.model, primitive));
        let ray = ray(self.rays, self.lane, *self.far, is_own);
        if *self.far != f32::NEG_INFINITY && model.of.meet(primitive, &ray).is_some() {
            *self.far = f32::NEG_INFINITY;
            probe.end_at(f32::NEG_INFINITY);
        }
    }
}
