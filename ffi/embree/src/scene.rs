//! Scenes that can be changed, frozen scenes, and the step between.

use crate::device::Device;
use crate::error::{Error, ErrorCode};
use crate::geometry::{Geometry, Handle, MeshHandle, VertexBuffer, check_times};
use crate::quality::BuildQuality;
use crate::query::Committed;
use embree4_sys as sys;
use std::sync::Arc;

/// The number of a geometry in its scene: 0, 1, 2 … in the order of attaching, but for numbers that are
/// [left out](Scene::skip_ids_to). It is `geom_id` of a hit in a mesh of the scene itself, and `inst_id` of a hit in an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GeometryId(pub u32);

/// First and last time of rays, for the transforms of an [instance](Scene::set_instance_transforms).
pub const ALL_TIMES: [f32; 2] = [0.0, 1.0];

/// A scene that can be changed. It answers rays only through [`Committed`], which borrows it.
#[derive(Debug)]
pub struct Scene {
    // Field order is drop order: the scene before what it holds, the geometries before their device.
    raw: SceneHandle,
    /// Geometries and instances by id; none where ids were left out.
    attached: Vec<Option<Attached>>,
    device: Device,
    quality: BuildQuality,
    changed: bool,
}

#[derive(Debug)]
enum Attached {
    Mesh { mesh: MeshHandle, mask: u32 },
    Instance { handle: Handle, transforms: Vec<[f32; 12]>, times: [f32; 2], mask: u32, of: Arc<FrozenScene> },
}

/// A scene that was committed, and cannot be changed while anybody has it. Instances place it in other scenes.
#[derive(Debug)]
pub struct FrozenScene {
    scene: Scene,
}

impl Scene {
    /// An empty scene. `robust` avoids optimisations that let rays slip through shared edges; it costs 10 to
    /// 25 % of the speed.
    ///
    /// # Errors
    /// Embree's, for instance when memory is exhausted.
    pub fn new(device: &Device, quality: BuildQuality, robust: bool) -> Result<Self, Error> {
        // SAFETY: the device is live.
        let raw = unsafe { sys::rtcNewScene(device.raw()) };
        if raw.is_null() {
            device.take_error()?;
            return Err(Error::new(ErrorCode::Unknown, "no scene, and no reason given"));
        }
        let raw = SceneHandle(raw);
        let robust = if robust { sys::RTC_SCENE_FLAG_ROBUST } else { sys::RTC_SCENE_FLAG_NONE };
        // SAFETY: the scene is live.
        unsafe {
            sys::rtcSetSceneBuildQuality(raw.0, quality.of_scene());
            // `Committed::occluded16_past_own` passes a filter; an instanced scene needs the flag as well.
            let filter = sys::RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
            sys::rtcSetSceneFlags(raw.0, robust | filter | quality.scene_flags());
        }
        device.take_error()?;
        Ok(Self { raw, attached: Vec::new(), device: device.clone(), quality, changed: true })
    }

    /// Adds a mesh. The scene shares its buffers and keeps them alive.
    ///
    /// # Errors
    /// If the geometry is of another device, or if memory is exhausted.
    pub fn attach(&mut self, geometry: &Geometry) -> Result<GeometryId, Error> {
        self.check_device(geometry.device())?;
        let mesh = geometry.instantiate(self.quality)?;
        let id = self.attach_handle(&mesh.handle)?;
        self.attached.push(Some(Attached::Mesh { mesh, mask: geometry.mask() }));
        Ok(id)
    }

    /// Leaves out ids, so that the next geometry has the id `next` or a later one: ids of two scenes can thus
    /// be kept distinct.
    pub fn skip_ids_to(&mut self, next: GeometryId) {
        let count = self.attached.len().max(next.0 as usize);
        self.attached.resize_with(count, || None);
    }

    /// Places a frozen scene. `transform` takes points from the space of `of` into the space of this scene:
    /// 3 rows, 4 columns, stored column after column; the last column is the translation. A ray meets the
    /// instance only if `ray.mask & mask` is not 0 (and then the masks inside of `of` count).
    ///
    /// A transform that cannot be inverted (a scale of 0) shows nothing.
    ///
    /// # Errors
    /// If the transform is not finite, if `of` is of another device or holds instances itself (there is one
    /// level), or if memory is exhausted.
    pub fn attach_instance(
        &mut self,
        of: &Arc<FrozenScene>,
        transform: [f32; 12],
        mask: u32,
    ) -> Result<GeometryId, Error> {
        self.check_instanced(of)?;
        check_transform(&transform)?;
        let mut handle = Handle::new(&self.device, sys::RTC_GEOMETRY_TYPE_INSTANCE)?;
        // SAFETY: both are live and of one device; `of` in `attached` keeps the child alive longer than this scene.
        unsafe { sys::rtcSetGeometryInstancedScene(handle.raw(), of.scene.raw.0) };
        handle.set_mask(mask);
        handle.set_transforms(&[transform], ALL_TIMES);
        handle.commit();
        self.device.take_error()?;
        let id = self.attach_handle(&handle)?;
        let (transforms, of) = (vec![transform], Arc::clone(of));
        self.attached.push(Some(Attached::Instance { handle, transforms, times: ALL_TIMES, mask, of }));
        Ok(id)
    }

    /// Moves an instance; see [`attach_instance`](Self::attach_instance). The same transforms again are no change.
    ///
    /// Of several transforms the first is that at the first of the `times` of rays, and the last that at the last, with equal steps between
    /// them; rays before and after meet nothing. At a step between 0 and 1 an instance is exactly where its transform says if the number of
    /// steps is a power of two.
    ///
    /// # Errors
    /// If `id` is no instance of this scene, if a transform is not finite, if there are none or more than 129, or if `times` do not rise.
    pub fn set_instance_transforms(
        &mut self,
        id: GeometryId,
        transforms: &[[f32; 12]],
        times: [f32; 2],
    ) -> Result<(), Error> {
        const MOST: usize = sys::RTC_MAX_TIME_STEP_COUNT as usize;
        if transforms.is_empty() || transforms.len() > MOST {
            let text = format!("an instance has 1 to {MOST} transforms, not {}", transforms.len());
            return Err(Error::invalid_argument(text));
        }
        transforms.iter().try_for_each(check_transform)?;
        check_times(times)?;
        let Attached::Instance { handle, transforms: old, times: old_times, .. } = self.find(id)? else {
            let text = format!("geometry {} is a mesh, and only instances have a transform", id.0);
            return Err(Error::new(ErrorCode::InvalidOperation, text));
        };
        if *old != transforms || *old_times != times {
            transforms.clone_into(old);
            *old_times = times;
            handle.set_transforms(transforms, times);
            handle.commit();
            self.changed = true;
        }
        self.device.take_error()
    }

    /// Has an instance place another frozen scene; its transform and mask stay. The same scene again is no change.
    ///
    /// # Errors
    /// If `id` is no instance of this scene, if `of` is of another device or holds instances itself, or if memory is exhausted.
    pub fn set_instance_scene(&mut self, id: GeometryId, of: &Arc<FrozenScene>) -> Result<(), Error> {
        self.check_instanced(of)?;
        let Attached::Instance { handle, of: old, .. } = self.find(id)? else {
            let text = format!("geometry {} is a mesh, and only instances place a scene", id.0);
            return Err(Error::new(ErrorCode::InvalidOperation, text));
        };
        if !Arc::ptr_eq(old, of) {
            // SAFETY: both are live and of one device. Embree keeps a reference of its own to the child; that `of` is
            // replaced only after it has let go of the old one, whose buffers `old` keeps, holds for what it reads.
            unsafe { sys::rtcSetGeometryInstancedScene(handle.raw(), of.scene.raw.0) };
            handle.commit();
            *old = Arc::clone(of);
            self.changed = true;
        }
        self.device.take_error()
    }

    /// Moves the vertices of a triangle mesh, of this scene alone. The scene shares the buffer and keeps it alive.
    ///
    /// In scenes of the quality [`Refit`](BuildQuality::Refit) the mesh keeps its tree; others are built anew.
    ///
    /// # Errors
    /// If this scene has no such mesh, or there are more or fewer vertices than it has.
    pub fn set_vertices(&mut self, id: GeometryId, vertices: &Arc<VertexBuffer>) -> Result<(), Error> {
        let Attached::Mesh { mesh, .. } = self.find(id)? else {
            let text = format!("geometry {} is an instance, and only meshes have vertices", id.0);
            return Err(Error::new(ErrorCode::InvalidOperation, text));
        };
        mesh.set_vertices(vertices)?;
        self.changed = true;
        self.device.take_error()
    }

    /// Changes the mask of a mesh or an instance in this scene alone. The same mask again is no change.
    ///
    /// # Errors
    /// If this scene has no such geometry.
    pub fn set_mask(&mut self, id: GeometryId, mask: u32) -> Result<(), Error> {
        let (handle, old) = match self.find(id)? {
            Attached::Mesh { mesh, mask } => (&mut mesh.handle, mask),
            Attached::Instance { handle, mask, .. } => (handle, mask),
        };
        if *old != mask {
            *old = mask;
            handle.set_mask(mask);
            handle.commit();
            self.changed = true;
        }
        self.device.take_error()
    }

    /// Builds what is needed to trace, if anything changed since the last time, and borrows the scene until
    /// tracing is over. Embree builds with threads of its own: call this outside of any thread pool.
    ///
    /// Where one part of a scene changes each frame, keep that in a scene of its own: a build begins anew.
    ///
    /// # Errors
    /// Embree's, for instance when memory is exhausted. The scene can be committed again.
    pub fn commit(&mut self) -> Result<Committed<'_>, Error> {
        if self.changed {
            // SAFETY: the scene is live, and `&mut self` says that nobody traces or changes it meanwhile.
            unsafe { sys::rtcCommitScene(self.raw.0) };
            self.device.take_error()?;
            self.changed = false;
        }
        // SAFETY: committed just now, and borrowed by the result.
        Ok(unsafe { Committed::new(self.raw.0) })
    }

    /// Commits the scene, and ends its changes, so that it can be instanced.
    ///
    /// # Errors
    /// As [`commit`](Self::commit).
    pub fn freeze(mut self) -> Result<Arc<FrozenScene>, Error> {
        self.commit()?;
        Ok(Arc::new(FrozenScene { scene: self }))
    }

    fn attach_handle(&mut self, handle: &Handle) -> Result<GeometryId, Error> {
        // Nothing is ever detached, so that ids are the places in `attached`, and this one is free.
        let id = self.attached.len() as u32;
        // SAFETY: both are live and of one device. The scene takes a reference of its own.
        unsafe { sys::rtcAttachGeometryByID(self.raw.0, handle.raw(), id) };
        self.device.take_error()?;
        self.changed = true;
        Ok(GeometryId(id))
    }

    fn find(&mut self, id: GeometryId) -> Result<&mut Attached, Error> {
        let count = self.attached.len();
        self.attached
            .get_mut(id.0 as usize)
            .and_then(Option::as_mut)
            .ok_or_else(|| Error::invalid_argument(format!("no geometry {} in a scene of {count}", id.0)))
    }

    /// Checks whether instances in this scene may place `of`.
    fn check_instanced(&self, of: &FrozenScene) -> Result<(), Error> {
        self.check_device(&of.scene.device)?;
        if of.scene.attached.iter().flatten().any(|a| matches!(a, Attached::Instance { .. })) {
            return Err(Error::new(
                ErrorCode::InvalidOperation,
                "a scene that holds instances cannot be instanced: there is one level of instances",
            ));
        }
        Ok(())
    }

    fn check_device(&self, other: &Device) -> Result<(), Error> {
        if self.device.is_same(other) {
            return Ok(());
        }
        Err(Error::invalid_argument("the geometry and the scene are of different devices"))
    }
}

impl FrozenScene {
    /// Returns the scene, to be traced by itself.
    pub fn committed(&self) -> Committed<'_> {
        // SAFETY: `Scene::freeze` committed it, nothing can change it since, and the result borrows it.
        unsafe { Committed::new(self.scene.raw.0) }
    }

    /// Takes the scene back to be changed, and [frozen](Scene::freeze) again.
    ///
    /// # Errors
    /// If anybody else holds it: an instance that places it may be traced.
    pub fn thaw(self: Arc<Self>) -> Result<Scene, Error> {
        let alone = Arc::try_unwrap(self);
        alone.map(|frozen| frozen.scene).map_err(|_| {
            Error::new(ErrorCode::InvalidOperation, "a scene that is placed by an instance cannot be changed")
        })
    }
}

fn check_transform(transform: &[f32; 12]) -> Result<(), Error> {
    if transform.iter().all(|x| x.is_finite()) {
        return Ok(());
    }
    Err(Error::invalid_argument(format!("the transform {transform:?} is not finite")))
}

/// Owns one reference to an Embree scene.
#[derive(Debug)]
struct SceneHandle(sys::RTCScene);

// SAFETY: an Embree scene may be used from any thread; it is changed through `&mut Scene` alone.
unsafe impl Send for SceneHandle {}
// SAFETY: through `&` a scene is traced at most, which Embree allows from many threads at once.
unsafe impl Sync for SceneHandle {}

impl Drop for SceneHandle {
    fn drop(&mut self) {
        // SAFETY: one reference, made by rtcNewScene, given back once.
        unsafe { sys::rtcReleaseScene(self.0) };
    }
}
