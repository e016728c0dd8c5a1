//! A ray tracer in Rust behind the [`Tracer`] trait, without `unsafe`, which Embree is compared with.
//!
//! It is made of the same halves as [`embree`](super::embree): one tree of the triangles of all models that
//! never move, in world space; and for each other mesh a tree in object space, with a small tree of the
//! instances above that is built anew in every frame. Copies that stand still and share their mesh have such
//! a tree above, too, which is built once. A mesh that deforms has a tree for each of its models, built anew
//! when the shape changes. An instance takes the rays into its own space; directions keep their length there,
//! so that t means the same in both.
//!
//! - [`tree`](crate::geometry::tree): boxes, eight a node, from a binary tree that the crate `obvhs` builds;
//! - [`triangles`]: leaves, eight triangles each, and a test that lets no ray through between two triangles;
//! - [`beam`]: rays that go about the same way pass through the tree as one;
//! - [`instances`]: placed models, in a tree above those of their meshes;
//! - [`rays`]: a packet's rays, and which of them make a beam;
//! - [`of_kind`]: which rays share their trees;
//! - [`curved`]: tests of curved geometry, each ray by itself;
//! - [`search`]: both queries, for beams and for single rays.
//!
//! Packets that are said to be coherent are traced as beams, one for each main direction of their rays; all
//! others ray by ray. Where a ray meets two triangles at the same t, that with the lower numbers is the
//! result, so that no result depends on the order of the search or on other rays.
//!
//! The crate was chosen by measuring `obvhs` (its binary tree and its CWBVH, at four qualities), `bvh` and
//! `parry3d` on a kitchen of a million triangles, each with its own traversal and the same single rays
//! (`benches/bvh_crates`): CWBVH was fastest, 1.6 times `parry3d` and 6 times `bvh` for primary rays, and
//! builds beyond `medium_build` gained little for their time. None of them takes packets or closes cracks, so
//! only `obvhs`'s builder is used: on the same scene beams are several times as fast as its CWBVH
//! (`examples/trace_speed.rs`, which compares this tracer with Embree).

mod beam;
mod curved;
mod instances;
mod of_kind;
mod rays;
mod search;
mod triangles;

use std::collections::HashMap;
use std::sync::Arc;

use super::{
    Backend, Coherence, HitBatch, HitPacket, LANES, NO_HIT, Occluders, OfKind, Purpose, RayBatch, RayPacket,
    SceneSubset, Search, TraceError, Tracer, has_many_clear,
};
use crate::animation::{Chord, Shape};
use crate::exposure::{TICKS, Tick};
use crate::pose::Pose;
use crate::scene::{BlockerSet, BlockerSets, Mesh, Model, RayKind, Scene};
use crate::settings::Caustics;
use curved::{CurvedPrimitives, Standing};
use instances::{Instances, Placed};
use of_kind::{TreesOfKind, distinct};
use rays::{Rays, open_lanes};
use search::{Exempt, block, closest_of};
use triangles::{OF_INSTANCE, Shown, Triangles};

/// All trees of a shot.
pub struct RustBackend {
    /// Trees of the models that rays see: one set, unless some models are hidden from some kinds of rays.
    seen: Vec<Trees>,
    of_kind: TreesOfKind,
    /// Trees of the triangles that cast shadows, where [many are clear](has_many_clear).
    casters: Option<Trees>,
    /// Trees of what casts shadows in the light of some lights: those of each set of models, in the order of their numbers.
    linked: Vec<Trees>,
    /// True if triangles that cast no shadow let shadow rays pass.
    clear_passes: bool,
}

/// Trees of all triangles, or of some.
struct Trees {
    still: Triangles,
    /// Triangles of all other models; models of one mesh share them, unless it deforms.
    meshes: Vec<Triangles>,
    /// Instances of copies that stand still.
    at_rest: Instances,
    /// Models that deform.
    deforming: Vec<Deforming>,
    /// Number of a mesh's triangles to include, from the first on.
    count: fn(&Mesh) -> usize,
    /// Models that move, each with the index of its triangles in `meshes`.
    movable: Vec<(u32, usize)>,
    curved: CurvedPrimitives,
}

/// Model whose triangles are built anew for each of its shapes.
struct Deforming {
    model: u32,
    mesh: Arc<Mesh>,
    /// Index of its triangles among the meshes.
    at: usize,
    /// Shapes between which these triangles go, or twice their one shape.
    shapes: [Shape; 2],
}

impl RustBackend {
    /// Builds all trees, on rayon's threads.
    pub fn new(scene: &Scene) -> Self {
        Self::of(scene, Caustics::None)
    }

    /// Builds all trees, where clear glass blocks shadow rays or lets them pass by `caustics`.
    pub fn of(scene: &Scene, caustics: Caustics) -> Self {
        let has_casters = has_many_clear(scene, caustics);
        let sets = BlockerSets::of(scene);
        let shadows = |set: BlockerSet, casters: bool| {
            let count = if casters { |mesh: &Mesh| mesh.shadow_casting } else { Mesh::count };
            let see = |number: usize, model: &Model| {
                model.ray_visibility.is_seen_by(RayKind::Shadow) && sets.has(set, number)
            };
            Trees::new(scene, see, count, CurvedPrimitives::new(scene, see, casters))
        };
        let (kinds, of_kind) = distinct(scene);
        let seen = |kind: RayKind| {
            let see = |_, model: &Model| model.ray_visibility.is_seen_by(kind);
            Trees::new(scene, see, Mesh::count, CurvedPrimitives::new(scene, see, false))
        };
        Self {
            seen: kinds.into_iter().map(seen).collect(),
            of_kind,
            casters: has_casters.then(|| shadows(BlockerSet::ALL, true)),
            linked: sets.linked().map(|set| shadows(set, has_casters)).collect(),
            clear_passes: caustics == Caustics::None,
        }
    }

    /// Returns true if shadow rays have trees of their own.
    #[cfg(test)]
    pub fn keeps_casters_apart(&self) -> bool {
        self.casters.is_some()
    }
}

impl Trees {
    /// Builds trees of the first `count` triangles of each mesh of the models, with their numbers, that rays `see`, and of `curved`.
    fn new(
        scene: &Scene,
        see: impl Fn(usize, &Model) -> bool,
        count: fn(&Mesh) -> usize,
        curved: CurvedPrimitives,
    ) -> Self {
        let (mut still, mut meshes, mut movable, mut deforming) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (mut known, mut at_rest) = (HashMap::new(), Vec::new());
        let has_triangles = |number: usize, model: &Model| {
            !model.mesh.is_curved() && count(&model.mesh) > 0 && see(number, model)
        };
        let models = scene.models.iter().enumerate();
        for (number, model) in models.filter(|(number, model)| has_triangles(*number, model)) {
            if model.track.is_constant() && !model.is_placed_at_rest() {
                still.push((number as u32, &*model.mesh));
            } else if model.mesh.shapes().is_some() {
                let (mesh, shapes) = (Arc::clone(&model.mesh), Chord::FIRST.ends);
                deforming.push(Deforming { model: number as u32, at: meshes.len(), shapes, mesh });
                movable.push((number as u32, meshes.len()));
                meshes.push(deformed(&model.mesh, &shapes, count));
            } else {
                let mesh: &Mesh = &model.mesh;
                let at = *known.entry(Arc::as_ptr(&model.mesh)).or_insert_with(|| {
                    meshes.push(Triangles::new(&[(OF_INSTANCE, mesh)], count));
                    meshes.len() - 1
                });
                let list = if model.is_placed_at_rest() { &mut at_rest } else { &mut movable };
                list.push((number as u32, at));
            }
        }
        let place = |number: u32| scene.models[number as usize].track.at(0.0);
        let at_rest = Instances::new(at_rest.into_iter(), &meshes, place, |_| false);
        Self { still: Triangles::new(&still, count), meshes, at_rest, deforming, count, movable, curved }
    }

    /// Builds the trees of changed shapes anew. Nothing of the trees before is kept: frames do not depend on
    /// which others were rendered.
    fn deform(&mut self, pose: &Pose) {
        let Self { meshes, deforming, count, .. } = self;
        for Deforming { model, mesh, at, shapes } in deforming {
            let place = &pose.models[*model as usize];
            if place.is_visible && place.shape.ends != *shapes {
                *shapes = place.shape.ends;
                meshes[*at] = deformed(mesh, shapes, *count);
            }
        }
    }

    /// Opens the trees as they are in one frame.
    fn open(&mut self, pose: &Pose, moved: &[bool]) -> OpenTrees<'_> {
        self.deform(pose);
        let this = &*self;
        // the places of one tick of each group
        let ticks = (0..TICKS as Tick).step_by(TICKS / pose.sweeps.groups());
        let is_there = |model: u32| pose.models[model as usize].is_visible;
        let movable = |tick: Tick| {
            let there = this.movable.iter().copied().filter(|(model, _)| is_there(*model));
            let place = |model: u32| *pose.transform(model as usize, tick);
            Instances::new(there, &this.meshes, place, |model| moved[model as usize])
        };
        let curved = |tick: Tick| this.curved.open((pose, tick), moved);
        OpenTrees {
            still: &this.still,
            meshes: &this.meshes,
            at_rest: &this.at_rest,
            movable: ticks.clone().map(movable).collect(),
            still_curved: this.curved.still(),
            curved: ticks.map(curved).collect(),
        }
    }
}

/// Triangles of a mesh between two of its shapes.
fn deformed(mesh: &Mesh, [open, close]: &[Shape; 2], count: fn(&Mesh) -> usize) -> Triangles {
    let triangles = mesh.triangles();
    let positions = |shape: &Shape| triangles.shapes.as_ref().map(|shapes| shapes.positions(shape));
    let positions =
        |shape: &Shape| positions(shape).unwrap_or_else(|| triangles.positions.as_slice().to_vec());
    let first = positions(open);
    match open == close {
        true => Triangles::at(&[(OF_INSTANCE, mesh, &first)], count),
        false => Triangles::moving(mesh, [&first, &positions(close)], count),
    }
}

impl Backend for RustBackend {
    fn commit<'a>(&'a mut self, pose: &Pose, moved: &[bool]) -> Result<Box<dyn Tracer + 'a>, TraceError> {
        let casters = self.casters.as_mut().map(|trees| trees.open(pose, moved));
        let seen = self.seen.iter_mut().map(|trees| trees.open(pose, moved)).collect();
        let linked = self.linked.iter_mut().map(|trees| trees.open(pose, moved)).collect();
        let (of_kind, clear_passes) = (self.of_kind, self.clear_passes);
        Ok(Box::new(RustTracer { seen, of_kind, casters, linked, clear_passes }))
    }
}

/// All trees, as they are in one frame.
struct RustTracer<'a> {
    seen: Vec<OpenTrees<'a>>,
    of_kind: TreesOfKind,
    casters: Option<OpenTrees<'a>>,
    linked: Vec<OpenTrees<'a>>,
    clear_passes: bool,
}

/// Trees, as they are in one frame.
struct OpenTrees<'a> {
    still: &'a Triangles,
    /// Triangles that the instances place.
    meshes: &'a [Triangles],
    at_rest: &'a Instances,
    /// Models that move, at the places of each group of ticks.
    movable: Vec<Instances>,
    still_curved: &'a Standing,
    /// Curved primitives that move, as `movable`.
    curved: Vec<Standing>,
}

impl OpenTrees<'_> {
    /// Returns true if no model moves in any frame.
    fn are_all_still(&self) -> bool {
        self.movable[0].is_empty() && self.curved[0].is_empty()
    }

    /// Those of the rays `used` that meet models that move at the places of each group of ticks, with the number of the group.
    fn by_group(&self, ticks: [Tick; LANES], used: u16) -> impl Iterator<Item = (usize, u16)> {
        let each = TICKS / self.movable.len();
        let of_group = move |group: usize| match each {
            TICKS => used,
            _ => (0..LANES)
                .filter(|lane| usize::from(ticks[*lane]) / each == group)
                .fold(0, |bits, lane| bits | 1 << lane & used),
        };
        (0..self.movable.len()).map(move |group| (group, of_group(group))).filter(|(_, rays)| *rays != 0)
    }
}

impl Tracer for RustTracer<'_> {
    fn closest(&self, rays: &RayBatch, search: Search, hits: &mut HitBatch) {
        let Search { kinds, among, coherence } = search;
        hits.packets.resize(rays.packet_count(), HitPacket::NONE);
        for ((packet, _), best) in rays.packets().zip(&mut hits.packets) {
            best.t = packet.far;
            best.model = [NO_HIT; LANES];
            best.triangle = [NO_HIT; LANES];
        }
        let hits = &mut hits.packets;
        match kinds {
            OfKind::All(kind) => {
                find_closest(self.seen_by(kind), rays, |_| u16::MAX, among, coherence, hits);
            }
            OfKind::Each(kinds) => {
                for (number, trees) in self.seen.iter().enumerate() {
                    let see = |packet: usize| {
                        let lanes = kinds[packet * LANES..].iter().take(LANES).enumerate();
                        lanes.fold(0, |see, (lane, kind)| {
                            see | u16::from(self.of_kind[*kind as usize] == number) << lane
                        })
                    };
                    find_closest(trees, rays, see, among, coherence, hits);
                }
            }
        }
    }

    fn blocked(
        &self,
        rays: &RayBatch,
        by: Occluders,
        purpose: Purpose,
        coherence: Coherence,
        blocked: &mut [u16],
    ) {
        let trees = match (&self.casters, purpose) {
            (_, Purpose::LinkedShadow(set)) => &self.linked[set.number() - 1],
            (Some(casters), Purpose::Shadow) => casters,
            _ => self.seen_by(purpose.kind()),
        };
        if by == Occluders::Still || !trees.are_all_still() {
            let clear_passes = self.clear_passes && purpose.is_shadow();
            find_blocked(trees, rays, Blockers { by, purpose, clear_passes, coherence }, blocked);
        }
    }
}

impl<'a> RustTracer<'a> {
    /// Trees of what rays of this kind see.
    fn seen_by(&self, kind: RayKind) -> &OpenTrees<'a> {
        &self.seen[self.of_kind[kind as usize]]
    }
}

fn rays_of(packet: &RayPacket) -> Rays {
    Rays { origin: packet.origin, direction: packet.direction, near: packet.near }
}

/// Shortens the rays to their first hits: those of which `see` returns the bit, by the number of their packet.
fn find_closest(
    trees: &OpenTrees<'_>,
    rays: &RayBatch,
    see: impl Fn(usize) -> u16,
    among: SceneSubset,
    coherence: Coherence,
    hits: &mut [HitPacket],
) {
    let mut stack = Vec::new();
    for (number, ((packet, used), best)) in rays.packets().zip(hits).enumerate() {
        let ticks = rays.ticks(number);
        let (rays, used) = (rays_of(packet), used & see(number));
        if !trees.still.is_empty() {
            closest_of(Shown::of_models(trees.still), &rays, used, coherence, best, &mut stack);
        }
        let asks_movable = among == SceneSubset::All && !trees.are_all_still();
        let groups: Vec<(usize, u16)> =
            if asks_movable { trees.by_group(*ticks, used).collect() } else { Vec::new() };
        let movable = groups.iter().map(|(group, used)| (&trees.movable[*group], *used));
        for (instances, used) in std::iter::once((trees.at_rest, used)).chain(movable) {
            if !instances.is_empty() {
                let placed = Placed { meshes: trees.meshes, instances };
                placed.closest(&rays, used, coherence, best, &mut stack);
            }
        }
        let movable = groups.iter().map(|(group, used)| (&trees.curved[*group], *used));
        for (curved, used) in std::iter::once((trees.still_curved, used)).chain(movable) {
            if !curved.is_empty() {
                curved.closest(&rays, used, best, &mut stack);
            }
        }
    }
}

/// Question that shadow rays, and rays between a surface and the eye, ask.
#[derive(Clone, Copy)]
struct Blockers {
    by: Occluders,
    purpose: Purpose,
    /// True if triangles that cast no shadow let the rays pass.
    clear_passes: bool,
    coherence: Coherence,
}

/// Marks the rays that are blocked; those that are marked already are not traced.
fn find_blocked(trees: &OpenTrees<'_>, rays: &RayBatch, asked: Blockers, blocked: &mut [u16]) {
    let Blockers { by, purpose, clear_passes, coherence } = asked;
    let mut stack = Vec::new();
    for (number, ((packet, used), blocked)) in rays.packets().zip(blocked).enumerate() {
        let open = used & !*blocked;
        let ticks = *rays.ticks(number);
        let own = (purpose == Purpose::Sight).then_some((&packet.own_model, &packet.own_triangle));
        let exempt = Exempt { clear: clear_passes, own };
        let (rays, mut far) = (rays_of(packet), packet.far);
        let moved_alone = by == Occluders::Moved;
        if by == Occluders::Still && !trees.still.is_empty() {
            block(Shown::of_models(trees.still), &rays, open, coherence, exempt, &mut far, &mut stack);
        }
        let mut block_placed = |instances: &Instances, curved: &Standing, open: u16| {
            if !instances.is_empty() {
                let open = open & open_lanes(&far);
                let placed = Placed { meshes: trees.meshes, instances };
                placed.block(moved_alone, &rays, open, coherence, exempt, &mut far, &mut stack);
            }
            if !curved.is_empty() {
                curved.block(moved_alone, &rays, open, exempt, &mut far, &mut stack);
            }
        };
        match by {
            Occluders::Still => block_placed(trees.at_rest, trees.still_curved, open),
            Occluders::Movable | Occluders::Moved => {
                for (group, open) in trees.by_group(ticks, open) {
                    block_placed(&trees.movable[group], &trees.curved[group], open);
                }
            }
        }
        *blocked |= open & !open_lanes(&far);
    }
}
