//! Embree behind the [`Tracer`] trait: the only file that builds or queries an Embree scene.
//!
//! There are two scenes. *Still* holds the triangles of all models that never move, in world space (the
//! loader has put them there), built once; of meshes of which many copies stand still, an instance for each
//! copy. *Movable* holds an instance of each model that moves in some frame; a frame only sets transforms and
//! masks and rebuilds the tiny tree above the instances. A model that deforms has an instance of a scene of
//! its own, which is [refitted](deforming) when its shape changes.
//!
//! Quadrics are geometries of their own kind, for which Embree calls back ([`Pieces`](pieces::Pieces)).
//!
//! Ids. A model has up to four geometries: the triangles that cast shadows and then those that do not, whole
//! ones and those that are [cut out](crate::scene::cutout) apart (in the order of [`Mesh::triangles`]), so that
//! `triangle = first + primID`. In *still* a geometry's id leads to
//! its [`GeometryPart`]. With instances, the instance's id leads to the model and the geometry's to its part,
//! whichever scene they are in: instances of copies that stand still have ids after all those in *movable*.
//!
//! Masks. A ray meets whatever shares a bit with it at every level: see [`mask`].
//!
//! Widths. A [`RayPacket`] has sixteen rays. Embree gets them in packets of the widest kind that is native to
//! the processor: whole, in halves or in quarters. Embree's layout differs from ours, so that rays are copied
//! in any case, and parts cost no more than the whole.
//!
//! *Casters*. Where there are [many clear triangles](has_many_clear), two more scenes hold the triangles that
//! cast shadows and nothing else, and shadow rays are traced in these.

mod by_time;
mod config;
mod deforming;
mod frozen;
mod mask;
mod one_by_one;
mod pieces;
mod places;

use std::collections::HashMap;
use std::sync::Arc;

use embree::{
    BuildQuality, Coherence as EmbreeCoherence, Committed, Device, GeometryId, Hit, INVALID, PacketWidth,
    PrimId, Ray, RayHit, Scene as EmbreeScene, Valid,
};

use super::{
    Backend, Coherence, HitBatch, HitPacket, LANES, NO_HIT, Occluders, OfKind, Purpose, RayBatch, RayPacket,
    SceneSubset, Search, TraceError, Tracer, has_many_clear,
};
use crate::animation::Transform;
use crate::exposure::{TICKS, Tick};
use crate::geometry::Bounds;
use crate::lanes::{F32x8, are_same};
use crate::pose::Pose;
use crate::scene::{Mesh, Model, RayKind, RayKinds, Scene};
use crate::settings::{Build, Caustics};
pub use config::{CONFIG_VARIABLE, check_config, device_config, settings};
use deforming::Deforming;
use frozen::{Frozen, MOST_PARTS, Part, ROBUST, Vertices, freeze, parts_of};
use places::{Instance, are_twins, has_twins, set_places, times};

/// Least t of rays. Embree counts t = tnear as met: an eye in a surface, at t = 0, would see nothing else.
/// Large enough that products with it are not subnormal in scenes of usual size, which would be slow.
const LEAST_T: f32 = 1e-20;

/// Place of a geometry's triangles in the program's own lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct GeometryPart {
    model: u32,
    /// Index of the geometry's first triangle in the mesh.
    first: u32,
}

/// Places of an instance's triangles in the program's own lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct InstanceParts {
    model: u32,
    /// Index of the first triangle in the mesh, by geometry.
    firsts: [u32; MOST_PARTS],
}

/// Scenes of the triangles that cast shadows.
struct Casters {
    still: EmbreeScene,
    movable: EmbreeScene,
    /// Instances in `movable`.
    instances: Vec<Instance>,
}

/// All Embree scenes of a shot.
pub struct EmbreeBackend {
    still: EmbreeScene,
    movable: EmbreeScene,
    /// Scenes for shadow rays, if these have their own.
    casters: Option<Casters>,
    still_parts: Vec<GeometryPart>,
    /// Parts by instance, of both scenes.
    instance_parts: Vec<InstanceParts>,
    /// Instances of movable models.
    instances: Vec<Instance>,
    /// Movable models that deform.
    deforming: Vec<Deforming>,
    device: Device,
    /// Width of the packets that Embree gets.
    width: PacketWidth,
    /// True if triangles that cast no shadows let shadow rays pass.
    clear_passes: bool,
    /// True if models that stand still [lie in each other](are_twins), where it matters.
    has_still_twins: bool,
}

impl EmbreeBackend {
    /// Builds all scenes. Call it while rayon's threads are idle: Embree builds with threads of its own, as
    /// many as rayon has.
    pub fn new(scene: &Scene, build: Build) -> Result<Self, TraceError> {
        Self::of(scene, build, Caustics::None)
    }

    /// Builds all scenes, where clear glass blocks shadow rays or lets them pass by `caustics`.
    pub fn of(scene: &Scene, build: Build, caustics: Caustics) -> Result<Self, TraceError> {
        Self::made(scene, build, caustics, &device_config()?)
    }

    /// Builds all scenes with a device of this configuration.
    pub fn with_config(scene: &Scene, build: Build, config: &str) -> Result<Self, TraceError> {
        Self::made(scene, build, Caustics::None, config)
    }

    fn made(scene: &Scene, build: Build, caustics: Caustics, config: &str) -> Result<Self, TraceError> {
        let device =
            Device::new(config).map_err(|error| TraceError(format!("{error} (configuration: {config})")))?;
        let quality = match build {
            Build::Best => BuildQuality::High,
            Build::Quick => BuildQuality::Low,
        };
        let still = || EmbreeScene::new(&device, quality, ROBUST);
        let movable = || EmbreeScene::new(&device, BuildQuality::Low, ROBUST);
        let casters = if has_many_clear(scene, caustics) {
            Some(Casters { still: still()?, movable: movable()?, instances: Vec::new() })
        } else {
            None
        };
        let mut backend = Self {
            still: still()?,
            movable: movable()?,
            casters,
            still_parts: Vec::new(),
            instance_parts: Vec::new(),
            instances: Vec::new(),
            deforming: Vec::new(),
            width: device.native_width(),
            device: device.clone(),
            clear_passes: caustics == Caustics::None,
            // a careful build has one tree of all triangles
            has_still_twins: quality == BuildQuality::Low && has_still_twins(scene),
        };
        backend.add_models(scene, quality)?;
        // still scenes are built here; in every frame they are found unchanged
        backend.still.commit()?;
        if let Some(casters) = &mut backend.casters {
            casters.still.commit()?;
        }
        Ok(backend)
    }

    /// Returns true if shadow rays have scenes of their own.
    #[cfg(test)]
    pub fn keeps_casters_apart(&self) -> bool {
        self.casters.is_some()
    }

    fn add_models(&mut self, scene: &Scene, quality: BuildQuality) -> Result<(), TraceError> {
        let device = self.device.clone();
        let with_casters = self.casters.is_some();
        let mut known: HashMap<*const Mesh, Arc<Frozen>> = HashMap::new();
        let mut shared = |mesh: &Arc<Mesh>| -> Result<Arc<Frozen>, TraceError> {
            if let Some(frozen) = known.get(&Arc::as_ptr(mesh)) {
                return Ok(Arc::clone(frozen));
            }
            let frozen =
                Arc::new(freeze(&device, mesh, &Vertices::Still(&mesh.positions), quality, with_casters)?);
            known.insert(Arc::as_ptr(mesh), Arc::clone(&frozen));
            Ok(frozen)
        };
        for (model, number) in scene.models.iter().zip(0..) {
            if model.is_placed_at_rest() {
                continue;
            }
            if model.track.is_constant() {
                self.add_still(number, model)?;
            } else if model.mesh.shapes.is_some() {
                let mut deforming = Deforming::new(&device, number as usize, &model.mesh, with_casters)?;
                let instances = self.add_movable(number, model, deforming.first(&device)?)?;
                self.deforming.push(deforming.placed(instances));
            } else {
                self.add_movable(number, model, &*shared(&model.mesh)?)?;
            }
        }
        for (model, number) in scene.models.iter().zip(0..).filter(|(model, _)| model.is_placed_at_rest()) {
            self.add_at_rest(number, model, &*shared(&model.mesh)?)?;
        }
        Ok(())
    }

    fn add_still(&mut self, number: u32, model: &Model) -> Result<(), TraceError> {
        let mesh = &model.mesh;
        let parts = parts_of(&self.device, mesh, &Vertices::Still(&mesh.positions), seen_by(model))?;
        for Part { geometry, first, casts_shadow } in parts {
            let GeometryId(id) = self.still.attach(&geometry)?;
            debug_assert_eq!(id as usize, self.still_parts.len());
            self.still_parts.push(GeometryPart { model: number, first });
            if let Some(casters) = self.casters.as_mut().filter(|_| casts_shadow) {
                casters.still.attach(&geometry)?;
            }
        }
        Ok(())
    }

    /// Adds a copy that stands still. Called after all models that move, so that its instance has another id
    /// than theirs.
    fn add_at_rest(&mut self, number: u32, model: &Model, frozen: &Frozen) -> Result<(), TraceError> {
        let (place, mask) = (model.track.at(0.0).columns(), mask::of_instance(seen_by(model), false));
        self.still.skip_ids_to(GeometryId(self.instance_parts.len() as u32));
        let GeometryId(id) = self.still.attach_instance(&frozen.scene, place, mask)?;
        // ids of triangles in world space are not those of instances
        let nobody = InstanceParts { model: NO_HIT, firsts: [0; MOST_PARTS] };
        self.instance_parts.resize(id as usize, nobody);
        self.instance_parts.push(InstanceParts { model: number, firsts: frozen.firsts });
        if let (Some(casters), Some(scene)) = (&mut self.casters, &frozen.casters) {
            casters.still.attach_instance(scene, place, mask)?;
        }
        Ok(())
    }

    /// Adds the instances of a model: one among all models, and one among those that cast shadows.
    fn add_movable(
        &mut self,
        number: u32,
        model: &Model,
        frozen: &Frozen,
    ) -> Result<[Option<GeometryId>; 2], TraceError> {
        let identity = Transform::IDENTITY.columns();
        let seen_by = seen_by(model);
        let mask = mask::of_instance(seen_by, true);
        let bounds = frozen.bounds;
        let placed = |id| Instance { id, model: number as usize, seen_by, bounds };
        let instance = self.movable.attach_instance(&frozen.scene, identity, mask)?;
        debug_assert_eq!(instance.0 as usize, self.instance_parts.len());
        self.instance_parts.push(InstanceParts { model: number, firsts: frozen.firsts });
        self.instances.push(placed(instance));
        let mut of_caster = None;
        if let (Some(casters), Some(scene)) = (&mut self.casters, &frozen.casters) {
            let id = casters.movable.attach_instance(scene, identity, mask)?;
            casters.instances.push(placed(id));
            of_caster = Some(id);
        }
        Ok([Some(instance), of_caster])
    }
}

impl Backend for EmbreeBackend {
    fn commit<'a>(&'a mut self, pose: &Pose, moved: &[bool]) -> Result<Box<dyn Tracer + 'a>, TraceError> {
        for deforming in &mut self.deforming {
            let casters = self.casters.as_mut().map(|casters| &mut casters.movable);
            deforming.deform(&self.device, &mut self.movable, casters, pose)?;
        }
        set_places(&mut self.movable, &self.instances, pose, moved)?;
        let has_movable = !self.instances.is_empty();
        Ok(Box::new(EmbreeTracer {
            still: self.still.commit()?,
            movable: has_movable.then(|| self.movable.commit()).transpose()?,
            casters: self.casters.as_mut().map(|casters| casters.commit(pose, moved)).transpose()?,
            still_parts: &self.still_parts,
            instance_parts: &self.instance_parts,
            width: self.width,
            clear_passes: self.clear_passes,
            times: times(pose),
            is_by_time: !pose.sweeps.are_straight(),
            twins: [self.has_still_twins, has_twins(&self.instances, pose)],
        }))
    }
}

impl Casters {
    fn commit(&mut self, pose: &Pose, moved: &[bool]) -> Result<OpenCasters<'_>, TraceError> {
        set_places(&mut self.movable, &self.instances, pose, moved)?;
        let has_movable = !self.instances.is_empty();
        Ok(OpenCasters {
            still: self.still.commit()?,
            movable: has_movable.then(|| self.movable.commit()).transpose()?,
        })
    }
}

/// Scenes of the triangles that cast shadows, open for rays.
struct OpenCasters<'a> {
    still: Committed<'a>,
    /// Scene of movable models, if there are any.
    movable: Option<Committed<'a>>,
}

/// All scenes, open for rays.
struct EmbreeTracer<'a> {
    still: Committed<'a>,
    /// Scene of movable models, if there are any.
    movable: Option<Committed<'a>>,
    casters: Option<OpenCasters<'a>>,
    still_parts: &'a [GeometryPart],
    instance_parts: &'a [InstanceParts],
    width: PacketWidth,
    clear_passes: bool,
    /// Times of rays by their ticks, if it matters.
    times: Option<[f32; TICKS]>,
    /// True if rays of different times do not go [together](by_time).
    is_by_time: bool,
    /// True if models that stand still, or that move, [lie in each other](are_twins): of these the least is met.
    twins: [bool; 2],
}

impl Tracer for EmbreeTracer<'_> {
    fn closest(&self, rays: &RayBatch, search: Search, hits: &mut HitBatch) {
        let Search { kinds, among, coherence } = search;
        hits.packets.resize(rays.packet_count(), HitPacket::NONE);
        let is_alone = coherence == Coherence::Incoherent;
        let [of_still, of_movable] = self.twins;
        let has_twins = of_still || of_movable && among == SceneSubset::All;
        if is_alone && !has_twins {
            let both = [self.still, self.movable.unwrap_or(self.still)];
            let has_movable = among == SceneSubset::All && self.movable.is_some();
            let scenes = &both[..1 + usize::from(has_movable)];
            let name = |met: PrimId| self.name(met);
            return match kinds {
                OfKind::All(kind) => {
                    let mask = mask_of(kind);
                    one_by_one::closest(scenes, rays, |_| mask, (self.times.as_ref(), LEAST_T), hits, name)
                }
                OfKind::Each(kinds) => {
                    let mask = |ray: usize| mask_of(kinds[ray]);
                    one_by_one::closest(scenes, rays, mask, (self.times.as_ref(), LEAST_T), hits, name)
                }
            };
        }
        match self.width {
            PacketWidth::Four => self.closest_by::<4>(rays, search, hits),
            PacketWidth::Eight => self.closest_by::<8>(rays, search, hits),
            PacketWidth::Sixteen => self.closest_by::<16>(rays, search, hits),
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
        let (still, movable) = match (&self.casters, purpose) {
            (Some(casters), Purpose::Shadow) => (casters.still, casters.movable),
            _ => (self.still, self.movable),
        };
        let Some(scene) = (if by == Occluders::Still { Some(still) } else { movable }) else { return };
        if coherence == Coherence::Incoherent && purpose == Purpose::Shadow {
            let mask = self.ray_mask(by, purpose);
            return one_by_one::blocked(scene, rays, mask, (self.times.as_ref(), LEAST_T), blocked);
        }
        let question = Question {
            scene,
            mask: self.ray_mask(by, purpose),
            purpose,
            coherence: to_embree_coherence(coherence, by),
        };
        match self.width {
            PacketWidth::Four => self.blocked_by::<4>(rays, by, &question, blocked),
            PacketWidth::Eight => self.blocked_by::<8>(rays, by, &question, blocked),
            PacketWidth::Sixteen => self.blocked_by::<16>(rays, by, &question, blocked),
        }
    }
}

/// Returns true if models that stand still lie in each other.
fn has_still_twins(scene: &Scene) -> bool {
    let still = scene.models.iter().filter(|model| model.track.is_constant());
    // copies share their mesh
    let mut bounds = HashMap::new();
    let mut bounds_of =
        |mesh: &Arc<Mesh>| *bounds.entry(Arc::as_ptr(mesh)).or_insert_with(|| Bounds::of(mesh));
    let placed: Vec<(Bounds, Transform)> =
        still.map(|model| (bounds_of(&model.mesh), model.track.at(0.0))).collect();
    are_twins(placed.iter().map(|(bounds, place)| (*bounds, place)))
}

/// Lanes of a packet, as bit masks, that are traced together: each ray by itself where no result may depend on other rays.
fn together(lanes: u16, coherence: Coherence) -> impl Iterator<Item = u16> {
    let mut left = lanes;
    std::iter::from_fn(move || {
        let next = if coherence == Coherence::Incoherent { left & left.wrapping_neg() } else { left };
        left &= !next;
        (next != 0).then_some(next)
    })
}

/// Query of [`Tracer::blocked`], in Embree's terms.
struct Question<'a> {
    scene: Committed<'a>,
    mask: u32,
    purpose: Purpose,
    coherence: EmbreeCoherence,
}

impl EmbreeTracer<'_> {
    /// [`Tracer::closest`] in Embree's packets of N rays.
    fn closest_by<const N: usize>(&self, rays: &RayBatch, search: Search, hits: &mut HitBatch) {
        let Search { kinds, among, coherence } = search;
        let movable = self.movable.filter(|_| among == SceneSubset::All);
        let [way, movable_way] =
            [Occluders::Still, Occluders::Movable].map(|by| to_embree_coherence(coherence, by));
        let is_bounced = coherence == Coherence::Bounced;
        let [of_still, of_movable] = self.twins.map(|has_twins| has_twins || is_bounced);
        // single rays are of one time in any case
        let times = self.times.as_ref().filter(|_| self.is_by_time && coherence != Coherence::Incoherent);
        let later = movable.zip(times);
        let movable = movable.filter(|_| later.is_none());
        let asked = || {
            let movable = movable.map(|scene| (scene, movable_way, of_movable));
            std::iter::once((self.still, way, of_still)).chain(movable)
        };
        let mut both = RayHit::<N>::default();
        if let OfKind::All(kind) = kinds {
            both.ray.mask = [mask_of(kind); N];
        }
        for (number, ((packet, lanes), out)) in rays.packets().zip(&mut hits.packets).enumerate() {
            for part in 0..LANES / N {
                let (first, in_part) = (part * N, part_of::<N>(lanes, part));
                if in_part == 0 {
                    out.model[first..first + N].fill(NO_HIT);
                    continue;
                }
                load(&mut both.ray, packet, first);
                self.set_times(&mut both.ray, rays.ticks(number), first);
                if let OfKind::Each(kinds) = kinds {
                    let kinds = &kinds[number * LANES + first..];
                    both.ray.mask.iter_mut().zip(kinds).for_each(|(mask, kind)| *mask = mask_of(*kind));
                }
                both.hit.clear();
                (both.hit.u, both.hit.v) = ([0.0; N], [0.0; N]);
                for bits in together(in_part, coherence) {
                    let valid = Valid::from_bits(bits);
                    for (scene, way, is_least) in asked() {
                        if is_least {
                            scene.intersect_least(&valid, &mut both);
                        } else {
                            scene.intersect(&valid, &mut both, way);
                        }
                    }
                }
                out.t[first..first + N].copy_from_slice(&both.ray.tfar);
                out.u[first..first + N].copy_from_slice(&both.hit.u);
                out.v[first..first + N].copy_from_slice(&both.hit.v);
                let triangles = (&mut out.model[first..first + N], &mut out.triangle[first..first + N]);
                self.name_triangles(&both.hit, triangles);
            }
        }
        if let Some((scene, times)) = later {
            let asked = by_time::Asked { scene, way: movable_way, is_least: of_movable };
            let mask = |ray: usize| match kinds {
                OfKind::All(kind) => mask_of(kind),
                OfKind::Each(kinds) => mask_of(kinds[ray]),
            };
            by_time::closest::<N>(asked, rays, mask, (times, LEAST_T), hits, |met| self.name(met));
        }
    }

    /// [`Tracer::blocked`] in Embree's packets of N rays.
    fn blocked_by<const N: usize>(
        &self,
        rays: &RayBatch,
        by: Occluders,
        question: &Question,
        blocked: &mut [u16],
    ) {
        let Question { scene, mask, purpose, coherence } = *question;
        if let Some(times) = self.times.as_ref().filter(|_| self.is_by_time && by != Occluders::Still) {
            let is_own = |packet: &RayPacket, lane: usize, met: PrimId| self.is_own(packet, lane, met);
            let (asked, of_ray) = ((scene, coherence), (mask, purpose));
            return by_time::blocked::<N>(asked, rays, of_ray, (times, LEAST_T), blocked, is_own);
        }
        let mut ray = Ray { mask: [mask; N], ..Ray::<N>::default() };
        for (number, ((packet, lanes), blocked)) in rays.packets().zip(blocked).enumerate() {
            let open = lanes & !*blocked;
            let mut ends = [0.0; LANES];
            for part in 0..LANES / N {
                let (first, in_part) = (part * N, part_of::<N>(open, part));
                if in_part == 0 {
                    continue;
                }
                load(&mut ray, packet, first);
                self.set_times(&mut ray, rays.ticks(number), first);
                let valid = Valid::from_bits(in_part);
                match purpose {
                    Purpose::Shadow => scene.occluded(&valid, &mut ray, coherence),
                    Purpose::Sight => scene.occluded_past(&valid, &mut ray, coherence, &|lane, met| {
                        self.is_own(packet, first + lane, met)
                    }),
                }
                ends[first..first + N].copy_from_slice(&ray.tfar);
            }
            // Embree sets the end of a ray that is blocked to minus infinity
            let is_set = |end: F32x8| end.le(F32x8::splat(f32::NEG_INFINITY)).bits();
            let set = [0, LANES / 2].map(|first| is_set(F32x8::load(&ends, first)));
            *blocked |= open & u16::from_le_bytes(set);
        }
    }

    /// Sets the times of N rays, from lane `first` of their packet on.
    #[inline(always)]
    fn set_times<const N: usize>(&self, ray: &mut Ray<N>, ticks: &[Tick; LANES], first: usize) {
        let Some(times) = &self.times else { return };
        for (time, tick) in ray.time.iter_mut().zip(&ticks[first..first + N]) {
            *time = times[usize::from(*tick)];
        }
    }

    /// Looks up the models and triangles that N rays met.
    #[inline(always)]
    fn name_triangles<const N: usize>(&self, hit: &Hit<N>, (models, triangles): (&mut [u32], &mut [u32])) {
        let (geometry, instance) = (hit.geom_id[0], hit.inst_id[0]);
        if geometry != INVALID && are_same(&hit.geom_id) && are_same(&hit.inst_id) {
            let part = self.part(instance, geometry);
            models.fill(part.model);
            triangles.iter_mut().zip(&hit.prim_id).for_each(|(triangle, id)| *triangle = part.first + id);
            return;
        }
        for lane in 0..N {
            if hit.geom_id[lane] == INVALID {
                models[lane] = NO_HIT;
                continue;
            }
            let part = self.part(hit.inst_id[lane], hit.geom_id[lane]);
            models[lane] = part.model;
            triangles[lane] = part.first + hit.prim_id[lane];
        }
    }

    /// Model and triangle of a primitive.
    #[inline(always)]
    fn name(&self, met: PrimId) -> (u32, u32) {
        let part = self.part(met.inst_id, met.geom_id);
        (part.model, part.first + met.prim_id)
    }

    #[inline(always)]
    fn part(&self, instance: u32, geometry: u32) -> GeometryPart {
        match instance {
            INVALID => self.still_parts[geometry as usize],
            instance => {
                let InstanceParts { model, firsts } = &self.instance_parts[instance as usize];
                GeometryPart { model: *model, first: firsts[geometry as usize] }
            }
        }
    }

    fn ray_mask(&self, by: Occluders, purpose: Purpose) -> u32 {
        mask::of_ray(purpose.kind(), by == Occluders::Moved, self.clear_passes)
    }

    /// Returns true if a ray of `packet` has met the triangle that its own sample is on.
    fn is_own(&self, packet: &RayPacket, lane: usize, met: PrimId) -> bool {
        self.name(met) == (packet.own_model[lane], packet.own_triangle[lane])
    }
}

/// Rays that see a model.
fn seen_by(model: &Model) -> RayKinds {
    model.ray_visibility.hidden_from.others()
}

/// Mask of a ray that finds its first hit.
fn mask_of(kind: RayKind) -> u32 {
    mask::of_ray(kind, false, false)
}

/// Bits of lanes `part * N..(part + 1) * N`.
#[inline(always)]
fn part_of<const N: usize>(lanes: u16, part: usize) -> u16 {
    lanes >> (part * N) & (u16::MAX >> (LANES - N))
}

/// Copies N rays of `packet` from lane `first` on, and leaves their masks.
#[inline(always)]
fn load<const N: usize>(ray: &mut Ray<N>, packet: &RayPacket, first: usize) {
    for (to, from) in [
        (&mut ray.org_x, &packet.origin[0]),
        (&mut ray.org_y, &packet.origin[1]),
        (&mut ray.org_z, &packet.origin[2]),
        (&mut ray.dir_x, &packet.direction[0]),
        (&mut ray.dir_y, &packet.direction[1]),
        (&mut ray.dir_z, &packet.direction[2]),
        (&mut ray.tfar, &packet.far),
    ] {
        to.copy_from_slice(&from[first..first + N]);
    }
    for (to, from) in ray.tnear.iter_mut().zip(&packet.near[first..first + N]) {
        *to = from.max(LEAST_T);
    }
}

fn to_embree_coherence(coherence: Coherence, by: Occluders) -> EmbreeCoherence {
    match coherence {
        // a bundle is faster than single rays in a kitchen at rest, and slower before a moving ball of small
        // triangles
        Coherence::SharedOrigin if by != Occluders::Still => EmbreeCoherence::Incoherent,
        Coherence::SharedOrigin => EmbreeCoherence::Coherent,
        // mirrors and panes are flat enough: as bundles their rays take a quarter less of the time of
        // `enhance`, in a kitchen and in a city of glass
        Coherence::Coherent | Coherence::Bounced => EmbreeCoherence::Coherent,
        Coherence::Incoherent => EmbreeCoherence::Incoherent,
    }
}

impl From<embree::Error> for TraceError {
    fn from(error: embree::Error) -> Self {
        Self(error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::Vec3;

    use super::*;
    use crate::scene;

    /// Creates bundles through the box of `scene`: sixteen rays from a point to its neighbours.
    fn bundles(scene: &Scene) -> RayBatch {
        let points = scene.models.iter().flat_map(|model| model.mesh.positions.as_slice());
        let (low, high) = points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), point| {
            (low.min(Vec3::from(*point)), high.max(Vec3::from(*point)))
        });
        // always the same places, evenly spread
        let place = |i: f32| low + (high - low) * (Vec3::new(0.618_034, 0.414_214, 0.732_051) * i).fract();
        let mut rays = RayBatch::default();
        for bundle in 0..500 {
            let (from, to) = (place(bundle as f32 + 0.3), place(bundle as f32 + 7.7));
            for ray in 0..16 {
                let beside = (high - low) * 0.002 * Vec3::new(ray as f32, (ray % 4) as f32, (ray % 3) as f32);
                rays.push_to_sample(from, to + beside - from, 0.0, 2.0, ray % 5, 7 * ray);
            }
        }
        rays.push(place(0.5), Vec3::X, 0.0, f32::INFINITY);
        rays
    }

    #[test]
    fn parts_of_packets_are_answered_as_whole_ones() {
        let scene = scene::load(Path::new("scenes/city/city.toml"), false).expect("it is shipped").scene;
        let (pose, moved) = (Pose::new(&scene, 1), vec![true; scene.models.len()]);
        let rays = bundles(&scene);
        let mut backend = EmbreeBackend::new(&scene, Build::Best).expect("it builds");
        let native = backend.width;
        let mut answers = |width: PacketWidth| {
            backend.width = width;
            let tracer = backend.commit(&pose, &moved).expect("it builds");
            let mut hits = HitBatch::default();
            tracer.closest(&rays, Search::from_eye(SceneSubset::All, Coherence::Coherent), &mut hits);
            let hits: Vec<_> = (0..rays.len()).map(|ray| hits.get(ray).map(|hit| hit.t.to_bits())).collect();
            let blocked = [Purpose::Sight, Purpose::Shadow].map(|purpose| {
                let mut blocked = vec![0b100; rays.packet_count()];
                tracer.blocked(&rays, Occluders::Still, purpose, Coherence::Coherent, &mut blocked);
                tracer.blocked(&rays, Occluders::Movable, purpose, Coherence::Coherent, &mut blocked);
                blocked
            });
            (hits, blocked)
        };
        let whole = answers(native);
        let met = whole.0.iter().flatten().count();
        assert!(met > 1000 && met < rays.len(), "{met} of {} rays meet something", rays.len());
        for width in [PacketWidth::Four, PacketWidth::Eight].into_iter().filter(|width| *width < native) {
            let parts = answers(width);
            let apart = parts.0.iter().zip(&whole.0).filter(|(part, whole)| part != whole).count();
            assert_eq!(apart, 0, "of {} rays, in packets of {}", rays.len(), width.lanes());
            assert!(parts.1 == whole.1, "other rays are blocked in packets of {}", width.lanes());
        }
    }
}
