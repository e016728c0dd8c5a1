//! Embree behind the [`Tracer`] trait: the only file that builds or asks an Embree scene.
//!
//! Two scenes. *Still* holds the triangles of all models that never move, in world space (the loader has
//! put them there), built once. *Movable* holds an instance of each model that moves
//! in some frame; a frame only sets transforms and masks and rebuilds the tiny tree above the instances.
//!
//! Ids. A model has up to two geometries: the triangles that cast shadows and then those that do not (in
//! this order in [`Mesh::triangles`]), so that `triangle = first + primID`. In *still* a geometry's id leads
//! to its [`Part`]; in *movable* the instance's id leads to the model and the geometry's to its part.
//!
//! Masks. A ray meets what shares a bit with it at every level: see [`mask`].
//!
//! *Casters*. Where there are [many clear triangles](has_many_clear), two more scenes hold what casts shadows
//! and nothing else, and shadow rays are asked of these.

use std::collections::HashMap;
use std::sync::Arc;

use embree::{
    BuildQuality, Coherence as EmbreeCoherence, Committed, Device, FrozenScene, Geometry, GeometryId,
    INVALID, OwnPrims16, Ray16, RayHit16, Scene as EmbreeScene, Valid16,
};

use super::{
    Among, Backend, Blockers, Coherence, HitBatch, HitPacket, LANES, NO_HIT, Purpose, RayBatch, RayPacket,
    TraceError, Tracer, has_many_clear,
};
use crate::lanes::{F32x8, are_same};
use crate::pose::Pose;
use crate::scene::{Mesh, Scene};
use crate::settings::Build;

/// Bits of rays and of what they meet. Instances carry one of the first two, geometries one of the others.
mod mask {
    /// An instance that is where it was in the frame before.
    pub const RESTS: u32 = 1;
    /// An instance that moved since the frame before.
    pub const MOVED: u32 = 2;
    /// Triangles that cast shadows.
    pub const CASTS_SHADOW: u32 = 4;
    /// Triangles that do not.
    pub const CLEAR: u32 = 8;
    /// Meets everything.
    pub const ALL: u32 = RESTS | MOVED | CASTS_SHADOW | CLEAR;
}

/// Closed surfaces have no cracks: without this, a few rays slip between two triangles
/// that share an edge and show what is behind them, and the audit rightly complains.
const ROBUST: bool = true;

/// Embree counts t = tnear as met: an eye in a surface, at t = 0, would see nothing else. Large enough that products
/// with it are not subnormal in scenes of usual size, which would be slow.
const LEAST_T: f32 = 1e-20;

/// Where a geometry's triangles are in the program's own lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Part {
    model: u32,
    /// Index of its first triangle in the mesh.
    first: u32,
}

/// The ids of one model's triangles in Embree, to keep a segment from being blocked by its own end.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// In *movable*; [`INVALID`] for still models.
    instance: u32,
    /// The geometry of the triangles that cast shadows, and of the others.
    geometries: [u32; 2],
    /// How many cast shadows.
    split: u32,
}

/// What casts shadows alone.
struct Casters {
    still: EmbreeScene,
    movable: EmbreeScene,
    /// The models in `movable`, each with its instance.
    instances: Vec<(usize, GeometryId)>,
}

/// Owns all scenes.
pub struct EmbreeBackend {
    still: EmbreeScene,
    movable: EmbreeScene,
    /// Where shadow rays have scenes of their own.
    casters: Option<Casters>,
    still_parts: Vec<Part>,
    /// By instance.
    movable_parts: Vec<[Part; 2]>,
    /// By model.
    places: Vec<Place>,
}

impl EmbreeBackend {
    /// Builds all scenes. Call it while rayon's threads are idle: Embree builds with threads of its own, as
    /// many as rayon has.
    pub fn new(scene: &Scene, build: Build) -> Result<Self, TraceError> {
        let device = Device::new(&format!("threads={}", rayon::current_num_threads()))?;
        let quality = match build {
            Build::Best => BuildQuality::High,
            Build::Quick => BuildQuality::Low,
        };
        let still = || EmbreeScene::new(&device, quality, ROBUST);
        let movable = || EmbreeScene::new(&device, BuildQuality::Low, ROBUST);
        let casters = if has_many_clear(scene) {
            Some(Casters { still: still()?, movable: movable()?, instances: Vec::new() })
        } else {
            None
        };
        let mut backend = Self {
            still: still()?,
            movable: movable()?,
            casters,
            still_parts: Vec::new(),
            movable_parts: Vec::new(),
            places: Vec::new(),
        };
        let mut frozen = HashMap::new();
        for (number, model) in scene.models.iter().enumerate() {
            let place = if model.track.is_constant() {
                backend.add_still(&device, number as u32, &model.mesh)?
            } else {
                let shared = Arc::as_ptr(&model.mesh);
                let parts = match frozen.get(&shared) {
                    Some(parts) => Arc::clone(parts),
                    None => {
                        let with_casters = backend.casters.is_some();
                        let made = Arc::new(freeze(&device, &model.mesh, quality, with_casters)?);
                        frozen.insert(shared, Arc::clone(&made));
                        made
                    }
                };
                backend.add_movable(number as u32, &model.mesh, &parts)?
            };
            backend.places.push(place);
        }
        // still scenes are built here, and found unchanged in every frame
        backend.still.commit()?;
        if let Some(casters) = &mut backend.casters {
            casters.still.commit()?;
        }
        Ok(backend)
    }

    /// Whether shadow rays have scenes of their own.
    #[cfg(test)]
    pub fn keeps_casters_apart(&self) -> bool {
        self.casters.is_some()
    }

    fn add_still(&mut self, device: &Device, model: u32, mesh: &Mesh) -> Result<Place, TraceError> {
        let mut geometries = [INVALID; 2];
        for (half, (geometry, first)) in geometries_of(device, mesh)? {
            let GeometryId(id) = self.still.attach(&geometry)?;
            debug_assert_eq!(id as usize, self.still_parts.len());
            self.still_parts.push(Part { model, first });
            geometries[half] = id;
            if let Some(casters) = self.casters.as_mut().filter(|_| half == CASTS_SHADOW) {
                casters.still.attach(&geometry)?;
            }
        }
        Ok(Place { instance: INVALID, geometries, split: mesh.shadow_casting as u32 })
    }

    fn add_movable(&mut self, model: u32, mesh: &Mesh, frozen: &Frozen) -> Result<Place, TraceError> {
        let identity = crate::animation::Transform::IDENTITY.columns();
        let GeometryId(instance) = self.movable.attach_instance(&frozen.scene, identity, mask::MOVED)?;
        debug_assert_eq!(instance as usize, self.movable_parts.len());
        self.movable_parts.push(frozen.firsts.map(|first| Part { model, first }));
        if let (Some(casters), Some(scene)) = (&mut self.casters, &frozen.casters) {
            let id = casters.movable.attach_instance(scene, identity, mask::MOVED)?;
            casters.instances.push((model as usize, id));
        }
        Ok(Place { instance, geometries: frozen.geometries, split: mesh.shadow_casting as u32 })
    }
}

/// A movable model's own scene.
struct Frozen {
    scene: Arc<FrozenScene>,
    /// First triangle by geometry id.
    firsts: [u32; 2],
    /// Geometry id of the triangles that cast shadows, and of the others.
    geometries: [u32; 2],
    /// The triangles that cast shadows by themselves, where that is wanted and there are any.
    casters: Option<Arc<FrozenScene>>,
}

fn freeze(
    device: &Device,
    mesh: &Mesh,
    quality: BuildQuality,
    with_casters: bool,
) -> Result<Frozen, TraceError> {
    let mut scene = EmbreeScene::new(device, quality, ROBUST)?;
    let (mut firsts, mut geometries) = ([0; 2], [INVALID; 2]);
    let halves = geometries_of(device, mesh)?;
    for (half, (geometry, first)) in &halves {
        let GeometryId(id) = scene.attach(geometry)?;
        firsts[id as usize] = *first;
        geometries[*half] = id;
    }
    let scene = scene.freeze()?;
    let casters = match halves.as_slice() {
        [(CASTS_SHADOW, _)] if with_casters => Some(Arc::clone(&scene)),
        [(CASTS_SHADOW, (geometry, _)), _] if with_casters => {
            let mut casters = EmbreeScene::new(device, quality, ROBUST)?;
            casters.attach(geometry)?;
            Some(casters.freeze()?)
        }
        _ => None,
    };
    Ok(Frozen { scene, firsts, geometries, casters })
}

/// The half of a mesh that casts shadows; the other one is clear.
const CASTS_SHADOW: usize = 0;

/// A half of a mesh with its first triangle.
type Half = (usize, (Geometry, u32));

/// The geometries of `mesh` that have triangles.
fn geometries_of(device: &Device, mesh: &Mesh) -> Result<Vec<Half>, TraceError> {
    let (all, split) = (&mesh.triangles, mesh.shadow_casting);
    let ranges = [(0..split, mask::CASTS_SHADOW), (split..all.len(), mask::CLEAR)];
    let mut halves = Vec::new();
    for (half, (range, mask)) in ranges.into_iter().enumerate() {
        if range.is_empty() {
            continue;
        }
        let first = range.start as u32;
        let triangles =
            if range.len() == all.len() { Arc::clone(all) } else { Arc::new(all[range].to_vec()) };
        let geometry = Geometry::triangles(device, Arc::clone(&mesh.positions), triangles, mask)?;
        halves.push((half, (geometry, first)));
    }
    Ok(halves)
}

impl Backend for EmbreeBackend {
    fn commit<'a>(&'a mut self, pose: &Pose, moved: &[bool]) -> Result<Box<dyn Tracer + 'a>, TraceError> {
        for (model, place) in self.places.iter().enumerate().filter(|(_, place)| place.instance != INVALID) {
            let id = GeometryId(place.instance);
            self.movable.set_instance_transform(id, pose.models[model].columns())?;
            self.movable.set_mask(id, mask_of(moved[model]))?;
        }
        let has_movable = !self.movable_parts.is_empty();
        Ok(Box::new(EmbreeTracer {
            still: self.still.commit()?,
            movable: has_movable.then(|| self.movable.commit()).transpose()?,
            casters: self.casters.as_mut().map(|casters| casters.commit(pose, moved)).transpose()?,
            still_parts: &self.still_parts,
            movable_parts: &self.movable_parts,
            places: &self.places,
        }))
    }
}

impl Casters {
    fn commit(&mut self, pose: &Pose, moved: &[bool]) -> Result<OpenCasters<'_>, TraceError> {
        for (model, id) in &self.instances {
            self.movable.set_instance_transform(*id, pose.models[*model].columns())?;
            self.movable.set_mask(*id, mask_of(moved[*model]))?;
        }
        let has_movable = !self.instances.is_empty();
        Ok(OpenCasters {
            still: self.still.commit()?,
            movable: has_movable.then(|| self.movable.commit()).transpose()?,
        })
    }
}

fn mask_of(moved: bool) -> u32 {
    if moved { mask::MOVED } else { mask::RESTS }
}

/// What casts shadows, open for rays.
struct OpenCasters<'a> {
    still: Committed<'a>,
    /// If there is anything in it.
    movable: Option<Committed<'a>>,
}

/// All scenes, open for rays.
struct EmbreeTracer<'a> {
    still: Committed<'a>,
    /// If there is anything in it.
    movable: Option<Committed<'a>>,
    casters: Option<OpenCasters<'a>>,
    still_parts: &'a [Part],
    movable_parts: &'a [[Part; 2]],
    places: &'a [Place],
}

impl Tracer for EmbreeTracer<'_> {
    fn closest(&self, rays: &RayBatch, among: Among, coherence: Coherence, hits: &mut HitBatch) {
        let movable = self.movable.filter(|_| among == Among::All);
        hits.packets.resize(rays.packet_count(), HitPacket::NONE);
        for ((packet, lanes), out) in rays.packets().zip(&mut hits.packets) {
            let valid = Valid16::from_bits(lanes);
            let mut both = RayHit16 { ray: to_embree(packet, mask::ALL), ..RayHit16::default() };
            self.still.intersect16(&valid, &mut both, to_embree_coherence(coherence, Blockers::Still));
            if let Some(movable) = movable {
                movable.intersect16(&valid, &mut both, to_embree_coherence(coherence, Blockers::Movable));
            }
            self.convert_hits(&both, lanes, out);
        }
    }

    fn blocked(
        &self,
        rays: &RayBatch,
        by: Blockers,
        purpose: Purpose,
        coherence: Coherence,
        blocked: &mut [u16],
    ) {
        let (still, movable) = match (&self.casters, purpose) {
            (Some(casters), Purpose::Shadow) => (casters.still, casters.movable),
            _ => (self.still, self.movable),
        };
        let Some(scene) = (if by == Blockers::Still { Some(still) } else { movable }) else { return };
        let mask = ray_mask(by, purpose);
        let coherence = to_embree_coherence(coherence, by);
        for ((packet, lanes), blocked) in rays.packets().zip(blocked) {
            let open = lanes & !*blocked;
            if open == 0 {
                continue;
            }
            let mut ray = to_embree(packet, mask);
            match purpose {
                Purpose::Shadow => scene.occluded16(&Valid16::from_bits(open), &mut ray, coherence),
                Purpose::Sight => {
                    let own = self.own_ids(packet, by);
                    scene.occluded16_past_own(&Valid16::from_bits(open), &mut ray, &own, coherence);
                }
            }
            // Embree sets the end of a ray that is blocked to minus infinity
            let is_set = |end: F32x8| end.le(F32x8::splat(f32::NEG_INFINITY)).bits();
            let set = [0, LANES / 2].map(|first| is_set(F32x8::load(&ray.tfar, first)));
            *blocked |= open & u16::from_le_bytes(set);
        }
    }
}

impl EmbreeTracer<'_> {
    fn convert_hits(&self, both: &RayHit16, lanes: u16, out: &mut HitPacket) {
        out.t = both.ray.tfar;
        out.u = both.hit.u;
        out.v = both.hit.v;
        for lane in 0..LANES {
            let geometry = both.hit.geom_id[lane];
            if geometry == INVALID || lanes >> lane & 1 == 0 {
                out.model[lane] = NO_HIT;
                continue;
            }
            let part = match both.hit.inst_id[lane] {
                INVALID => self.still_parts[geometry as usize],
                instance => self.movable_parts[instance as usize][geometry as usize],
            };
            out.model[lane] = part.model;
            out.triangle[lane] = part.first + both.hit.prim_id[lane];
        }
    }

    /// What `packet`'s rays end on, in the ids of the scene that is asked.
    fn own_ids(&self, packet: &RayPacket, by: Blockers) -> OwnPrims16 {
        let mut own = OwnPrims16 { geom_id: [INVALID; 16], prim_id: [INVALID; 16], inst_id: [INVALID; 16] };
        // beyond the last model are background, empty cells, and no hit
        let place_of = |model: u32| {
            let place = self.places.get(model as usize);
            place.filter(|place| (place.instance == INVALID) == (by == Blockers::Still))
        };
        let models = &packet.own_model;
        let is_one = are_same(models);
        let one = place_of(models[0]);
        if is_one && one.is_none() {
            return own;
        }
        for (lane, (model, triangle)) in models.iter().zip(packet.own_triangle).enumerate() {
            let Some(place) = (if is_one { one } else { place_of(*model) }) else { continue };
            let half = usize::from(triangle >= place.split);
            own.geom_id[lane] = place.geometries[half];
            own.prim_id[lane] = if half == 0 { triangle } else { triangle - place.split };
            own.inst_id[lane] = place.instance;
        }
        own
    }
}

fn ray_mask(by: Blockers, purpose: Purpose) -> u32 {
    let models = match by {
        Blockers::Still | Blockers::Movable => mask::RESTS | mask::MOVED,
        Blockers::Moved => mask::MOVED,
    };
    let triangles = match purpose {
        Purpose::Sight => mask::CASTS_SHADOW | mask::CLEAR,
        Purpose::Shadow => mask::CASTS_SHADOW,
    };
    models | triangles
}

fn to_embree(packet: &RayPacket, mask: u32) -> Ray16 {
    Ray16 {
        org_x: packet.origin[0],
        org_y: packet.origin[1],
        org_z: packet.origin[2],
        tnear: packet.near.map(|near| near.max(LEAST_T)),
        dir_x: packet.direction[0],
        dir_y: packet.direction[1],
        dir_z: packet.direction[2],
        time: [0.0; LANES],
        tfar: packet.far,
        mask: [mask; LANES],
        id: [0; LANES],
        flags: [0; LANES],
    }
}

fn to_embree_coherence(coherence: Coherence, by: Blockers) -> EmbreeCoherence {
    match coherence {
        // a bundle is faster than ray by ray in a kitchen that rests, and slower before a ball of small triangles that
        // moves
        Coherence::Fanned if by != Blockers::Still => EmbreeCoherence::Incoherent,
        Coherence::Fanned => EmbreeCoherence::Coherent,
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
