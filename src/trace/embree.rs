//! Embree behind the [`Tracer`] trait: nothing else builds or queries an Embree scene. Scenes are built here, and [rays](tracer) are traced in them.
//!
//! There are two scenes. *Still* holds the triangles of all models that never move, in world space (the
//! loader has put them there), built once; of meshes of which many copies stand still, an instance for each
//! copy. *Movable* holds an instance of each model that moves in some frame; a frame only sets transforms and
//! masks and rebuilds the tiny tree above the instances. A model that deforms has an instance of a scene of
//! its own, which is [refitted](deforming) when its shape changes.
//!
//! Curved geometries are of a kind of their own, for which Embree calls back ([`CurvedPart`](curved::CurvedPart)).
//!
//! Masks. A ray meets whatever shares a bit with it at every level: see [`mask`].
//!
//! *Casters*. Where there are [many clear triangles](has_many_clear), two more scenes hold the triangles that
//! cast shadows and nothing else, and shadow rays are traced in these.

mod by_time;
mod config;
mod curved;
mod deforming;
mod frozen;
mod mask;
mod one_by_one;
mod parts;
mod places;
mod tracer;

use std::collections::HashMap;
use std::sync::Arc;

use embree::{BuildQuality, Device, GeometryId, PacketWidth, Scene as EmbreeScene};

use super::{Backend, TraceError, Tracer, has_many_clear};
use crate::animation::Transform;
use crate::geometry::Bounds;
use crate::pose::Pose;
use crate::scene::{BlockerSets, Mesh, Model, Scene};
use crate::settings::{Build, Caustics};
pub use config::{CONFIG_VARIABLE, check_config, device_config, settings};
use deforming::Deforming;
use frozen::{Frozen, Part, ROBUST, Source, freeze, parts_of};
use mask::SeenBy;
use parts::PartsById;
use places::{Instance, are_twins, has_twins, set_places, times};
use tracer::{EmbreeTracer, OpenCasters};

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
    parts: PartsById,
    /// Instances of movable models.
    instances: Vec<Instance>,
    /// Movable models that deform.
    deforming: Vec<Deforming>,
    device: Device,
    /// Width of the packets that Embree gets.
    width: PacketWidth,
    /// True if triangles that cast no shadows let shadow rays pass.
    clear_passes: bool,
    /// Models that cast shadows in some lights alone.
    sets: BlockerSets,
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
            parts: PartsById::default(),
            instances: Vec::new(),
            deforming: Vec::new(),
            width: device.native_width(),
            device: device.clone(),
            clear_passes: caustics == Caustics::None,
            sets: BlockerSets::of(scene),
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
            let frozen = Arc::new(freeze(&device, mesh, &Source::at_rest(mesh), quality, with_casters)?);
            known.insert(Arc::as_ptr(mesh), Arc::clone(&frozen));
            Ok(frozen)
        };
        for (model, number) in scene.models.iter().zip(0..) {
            if model.is_placed_at_rest() {
                continue;
            }
            if model.track.is_constant() {
                self.add_still(number, model)?;
            } else if model.mesh.shapes().is_some() {
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
        let seen_by = self.seen_by(number, model);
        let (has_sets, clear_passes) = (self.sets.count() > 0, self.clear_passes);
        let mask_of = |casts_shadow| match has_sets {
            true => mask::of_geometry_in_sets(seen_by, casts_shadow, clear_passes),
            false => mask::of_geometry(seen_by.kinds, casts_shadow),
        };
        let parts = parts_of(&self.device, mesh, &Source::at_rest(mesh), mask_of)?;
        for Part { geometry, first, casts_shadow } in parts {
            self.parts.add(self.still.attach(&geometry)?, number, first);
            if let Some(casters) = self.casters.as_mut().filter(|_| casts_shadow) {
                casters.still.attach(&geometry)?;
            }
        }
        Ok(())
    }

    /// Adds a copy that stands still. Called after all models that move, so that its instance has another id
    /// than theirs.
    fn add_at_rest(&mut self, number: u32, model: &Model, frozen: &Frozen) -> Result<(), TraceError> {
        let (place, mask) =
            (model.track.at(0.0).columns(), mask::of_instance(self.seen_by(number, model), false));
        self.still.skip_ids_to(self.parts.next_instance());
        let id = self.still.attach_instance(&frozen.scene, place, mask)?;
        self.parts.add_instance(id, number, frozen.firsts);
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
        let seen_by = self.seen_by(number, model);
        let mask = mask::of_instance(seen_by, true);
        let bounds = frozen.bounds;
        let placed = |id| Instance { id, model: number as usize, seen_by, bounds };
        let instance = self.movable.attach_instance(&frozen.scene, identity, mask)?;
        debug_assert_eq!(instance, self.parts.next_instance());
        self.parts.add_instance(instance, number, frozen.firsts);
        self.instances.push(placed(instance));
        let mut of_caster = None;
        if let (Some(casters), Some(scene)) = (&mut self.casters, &frozen.casters) {
            let id = casters.movable.attach_instance(scene, identity, mask)?;
            casters.instances.push(placed(id));
            of_caster = Some(id);
        }
        Ok([Some(instance), of_caster])
    }

    /// Rays that see a model.
    fn seen_by(&self, number: u32, model: &Model) -> SeenBy {
        let kinds = model.ray_visibility.hidden_from.others();
        SeenBy { kinds, sets: self.sets.bits_of(number as usize) }
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
            parts: &self.parts,
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
    use crate::trace::{Coherence, HitBatch, Occluders, Purpose, RayBatch, SceneSubset, Search};

    /// Creates bundles through the box of `scene`: sixteen rays from a point to its neighbours.
    fn bundles(scene: &Scene) -> RayBatch {
        let points = scene.models.iter().flat_map(|model| model.mesh.triangles().positions.as_slice());
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
