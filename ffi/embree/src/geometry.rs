//! Triangle meshes and other primitives, and the handle that owns an Embree geometry.

use crate::cutout::{Cutout, Filter};
use crate::device::Device;
use crate::error::{Error, ErrorCode};
use crate::primitives::{Boxed, Callbacks, Primitives};
use crate::quality::BuildQuality;
use embree4_sys as sys;
use std::sync::Arc;

/// Vertex positions in object space, with the spare bytes behind the last one that Embree's 16-byte loads read.
#[derive(Debug)]
pub struct VertexBuffer {
    /// Vertices, and one more as padding.
    padded: Vec<[f32; 3]>,
}

impl VertexBuffer {
    /// Takes the vertices. Nothing is copied if `vertices` has capacity for one more.
    pub fn new(mut vertices: Vec<[f32; 3]>) -> Self {
        vertices.reserve_exact(1);
        vertices.push([0.0; 3]);
        Self { padded: vertices }
    }

    /// The vertices, without the padding.
    pub fn as_slice(&self) -> &[[f32; 3]] {
        &self.padded[..self.padded.len() - 1]
    }
}

/// Content of scenes: a triangle mesh (checked indices over shared buffers), or other [`Primitives`]. It
/// lives as long as any clone of the geometry and any scene it is attached to. Attaching copies no buffer.
#[derive(Clone, Debug)]
pub struct Geometry {
    device: Device,
    kind: Kind,
    mask: u32,
}

#[derive(Clone, Debug)]
enum Kind {
    Triangles { vertices: Steps, indices: Arc<Vec<[u32; 3]>>, cutout: Option<Arc<dyn Cutout>> },
    Primitives(Boxed),
}

/// Vertices of a mesh over time.
#[derive(Clone, Debug)]
enum Steps {
    /// They stay where they are.
    One(Arc<VertexBuffer>),
    /// They go straight from one place to another between two times.
    Two([Arc<VertexBuffer>; 2], [f32; 2]),
}

impl Steps {
    fn all(&self) -> &[Arc<VertexBuffer>] {
        match self {
            Self::One(vertices) => std::slice::from_ref(vertices),
            Self::Two(vertices, _) => vertices,
        }
    }
}

impl Geometry {
    /// A mesh of `indices.len()` triangles; triangle `i` is primitive `i` of a hit. A ray meets it only if
    /// `ray.mask & mask` is not 0.
    ///
    /// Vertices that are not finite are the caller's care: Embree leaves their triangles out without a word.
    ///
    /// # Errors
    /// [`InvalidArgument`](crate::ErrorCode::InvalidArgument) if an index is no vertex's, or if there are
    /// 2^32 - 1 triangles or more.
    pub fn triangles(
        device: &Device,
        vertices: Arc<VertexBuffer>,
        indices: Arc<Vec<[u32; 3]>>,
        mask: u32,
    ) -> Result<Self, Error> {
        Self::with_steps(device, Steps::One(vertices), indices, mask)
    }

    /// A mesh as in [`triangles`](Self::triangles) whose vertices go straight from the first places to the second between two `times` of rays:
    /// rising ones, which need not be within 0 and 1. Rays at other times do not meet it.
    ///
    /// # Errors
    /// As in [`triangles`](Self::triangles), if the numbers of vertices differ, and if the times do not rise.
    pub fn moving_triangles(
        device: &Device,
        vertices: [Arc<VertexBuffer>; 2],
        times: [f32; 2],
        indices: Arc<Vec<[u32; 3]>>,
        mask: u32,
    ) -> Result<Self, Error> {
        let [first, second] = vertices.each_ref().map(|vertices| vertices.as_slice().len());
        if first != second {
            return Err(Error::invalid_argument(format!(
                "a mesh has {first} vertices at its first step, and {second} at its second"
            )));
        }
        check_times(times)?;
        Self::with_steps(device, Steps::Two(vertices, times), indices, mask)
    }

    /// `vertices` has as many of them at each step.
    fn with_steps(
        device: &Device,
        vertices: Steps,
        indices: Arc<Vec<[u32; 3]>>,
        mask: u32,
    ) -> Result<Self, Error> {
        let count = vertices.all()[0].as_slice().len();
        let is_bad = |corner: &u32| *corner as usize >= count;
        // without an early end, several are looked at at once
        let highest = indices.as_flattened().iter().fold(0, |highest, corner| highest.max(*corner));
        let first_bad = || indices.iter().position(|corners| corners.iter().any(is_bad));
        if let Some(triangle) = is_bad(&highest).then(first_bad).flatten() {
            let corners = indices[triangle];
            return Err(Error::invalid_argument(format!(
                "triangle {triangle} has the vertices {corners:?}, but there are only {count} vertices"
            )));
        }
        // The id u32::MAX means "no hit".
        if indices.len() >= u32::MAX as usize {
            return Err(Error::invalid_argument("a mesh has 2^32 - 2 triangles at most"));
        }
        Ok(Self { device: device.clone(), kind: Kind::Triangles { vertices, indices, cutout: None }, mask })
    }

    /// Has rays meet triangles only in places that are there. Other primitives stay as they are.
    #[must_use]
    pub fn cut_by(mut self, cut: Arc<dyn Cutout>) -> Self {
        if let Kind::Triangles { cutout, .. } = &mut self.kind {
            *cutout = Some(cut);
        }
        self
    }

    /// Primitives of another kind; number `i` of them is primitive `i` of a hit. Masks as in
    /// [`triangles`](Self::triangles).
    ///
    /// # Errors
    /// [`InvalidArgument`](crate::ErrorCode::InvalidArgument) if there are 2^32 - 1 or more, or if the times do not rise.
    pub fn primitives(device: &Device, primitives: Arc<dyn Primitives>, mask: u32) -> Result<Self, Error> {
        let Some(boxed) = Boxed::new(primitives) else {
            return Err(Error::invalid_argument("a geometry has 2^32 - 2 primitives at most"));
        };
        boxed.times().map_or(Ok(()), check_times)?;
        Ok(Self { device: device.clone(), kind: Kind::Primitives(boxed), mask })
    }

    pub(crate) fn device(&self) -> &Device {
        &self.device
    }

    pub(crate) fn mask(&self) -> u32 {
        self.mask
    }

    /// Makes Embree's object. Each scene gets its own: a mask that changes in one scene must not change in
    /// another that is being traced. A scene of low quality is a tree for each mesh, built as the mesh says, and one
    /// above them; in others the mesh's quality counts for nothing.
    pub(crate) fn instantiate(&self, quality: BuildQuality) -> Result<MeshHandle, Error> {
        let (mut handle, callbacks, filter) = match &self.kind {
            Kind::Triangles { vertices, indices, cutout } => {
                let handle = self.share(vertices, indices)?;
                let filter = cutout.clone().map(Filter::new);
                if let Some(filter) = &filter {
                    // SAFETY: the geometry is a live mesh, and `MeshHandle` keeps the filter longer.
                    unsafe { filter.set(handle.raw) };
                }
                (handle, None, filter)
            }
            Kind::Primitives(boxed) => {
                let handle = Handle::new(&self.device, sys::RTC_GEOMETRY_TYPE_USER)?;
                let callbacks = Callbacks::new(boxed.clone());
                // SAFETY: the geometry is live and of the type for callbacks, and `MeshHandle` keeps them longer.
                unsafe { callbacks.set(handle.raw) };
                (handle, Some(callbacks), None)
            }
        };
        // SAFETY: the geometry is live.
        unsafe { sys::rtcSetGeometryBuildQuality(handle.raw, quality.of_mesh()) };
        handle.set_mask(self.mask);
        handle.commit();
        self.device.take_error()?;
        Ok(MeshHandle { handle, _callbacks: callbacks, _filter: filter, geometry: self.clone() })
    }

    fn share(&self, vertices: &Steps, indices: &[[u32; 3]]) -> Result<Handle, Error> {
        let handle = Handle::new(&self.device, sys::RTC_GEOMETRY_TYPE_TRIANGLE)?;
        if let Steps::Two(_, [first, last]) = vertices {
            // SAFETY: the geometry is live.
            unsafe {
                sys::rtcSetGeometryTimeStepCount(handle.raw, 2);
                sys::rtcSetGeometryTimeRange(handle.raw, *first, *last);
            }
        }
        // SAFETY: the geometry is a live mesh with as many steps, and `MeshHandle` keeps all buffers alive and unchanged for as
        // long as the geometry has them. The indices have the stated format, stride and count.
        unsafe {
            for (step, vertices) in (0..).zip(vertices.all()) {
                handle.share_vertices(step, vertices);
            }
            sys::rtcSetSharedGeometryBuffer(
                handle.raw,
                sys::RTC_BUFFER_TYPE_INDEX,
                0,
                sys::RTC_FORMAT_UINT3,
                indices.as_ptr().cast(),
                0,
                size_of::<[u32; 3]>(),
                indices.len(),
            );
        }
        Ok(handle)
    }
}

/// An Embree geometry and what it reads. Field order: the geometry goes first.
#[derive(Debug)]
pub(crate) struct MeshHandle {
    pub(crate) handle: Handle,
    _callbacks: Option<Callbacks>,
    _filter: Option<Filter>,
    geometry: Geometry,
}

impl MeshHandle {
    /// Has a triangle mesh read other vertices.
    pub(crate) fn set_vertices(&mut self, vertices: &Arc<VertexBuffer>) -> Result<(), Error> {
        let Kind::Triangles { vertices: Steps::One(old), .. } = &mut self.geometry.kind else {
            return Err(Error::new(
                ErrorCode::InvalidOperation,
                "only triangles that stay where they are have other vertices",
            ));
        };
        let [count, had] = [vertices, &*old].map(|buffer| buffer.as_slice().len());
        if count != had {
            return Err(Error::invalid_argument(format!("the mesh has {had} vertices, and not {count}")));
        }
        // SAFETY: the geometry is a live mesh whose indices fit as many vertices. It has let go of the old buffer before that is
        // replaced, and the new one is kept from then on.
        unsafe {
            self.handle.share_vertices(0, vertices);
            sys::rtcUpdateGeometryBuffer(self.handle.raw, sys::RTC_BUFFER_TYPE_VERTEX, 0);
        }
        *old = Arc::clone(vertices);
        self.handle.commit();
        Ok(())
    }
}

/// Times of rays at which steps of motion may be.
pub(crate) fn check_times(times: [f32; 2]) -> Result<(), Error> {
    if times.iter().all(|time| time.is_finite()) && times[0] < times[1] {
        return Ok(());
    }
    Err(Error::invalid_argument(format!("times of steps rise, and {times:?} do not")))
}

/// Owns one reference to an Embree geometry.
#[derive(Debug)]
pub(crate) struct Handle {
    raw: sys::RTCGeometry,
    /// Outlives `raw`: fields go after `drop`.
    _device: Device,
}

// SAFETY: an Embree geometry may be used from any thread; changing it needs `&mut` of the scene that has it.
unsafe impl Send for Handle {}
// SAFETY: as above.
unsafe impl Sync for Handle {}

impl Handle {
    pub(crate) fn new(device: &Device, kind: sys::RTCGeometryType) -> Result<Self, Error> {
        // SAFETY: the device is live.
        let raw = unsafe { sys::rtcNewGeometry(device.raw(), kind) };
        if raw.is_null() {
            device.take_error()?;
            return Err(Error::new(crate::ErrorCode::Unknown, "no geometry, and no reason given"));
        }
        Ok(Self { raw, _device: device.clone() })
    }

    pub(crate) fn raw(&self) -> sys::RTCGeometry {
        self.raw
    }

    pub(crate) fn set_mask(&mut self, mask: u32) {
        // SAFETY: the geometry is live.
        unsafe { sys::rtcSetGeometryMask(self.raw, mask) };
    }

    /// Has a triangle mesh read these vertices at one of its steps.
    ///
    /// # Safety
    /// The geometry is a triangle mesh with this step. The buffer must live, unchanged, for as long as the geometry has it.
    unsafe fn share_vertices(&self, step: u32, vertices: &VertexBuffer) {
        // SAFETY: the geometry is live. The buffer has the stated format, stride and count, and behind the last vertex are 12
        // more bytes.
        unsafe {
            sys::rtcSetSharedGeometryBuffer(
                self.raw,
                sys::RTC_BUFFER_TYPE_VERTEX,
                step,
                sys::RTC_FORMAT_FLOAT3,
                vertices.padded.as_ptr().cast(),
                0,
                size_of::<[f32; 3]>(),
                vertices.as_slice().len(),
            );
        }
    }

    /// Sets an instance's transforms at equal steps from the first of the `times` to the last, 129 at most: 3 rows, 4 columns, column after
    /// column.
    pub(crate) fn set_transforms(&mut self, transforms: &[[f32; 12]], [first, last]: [f32; 2]) {
        // SAFETY: the geometry is live.
        unsafe {
            sys::rtcSetGeometryTimeStepCount(self.raw, transforms.len() as u32);
            sys::rtcSetGeometryTimeRange(self.raw, first, last);
        }
        for (step, transform) in (0..).zip(transforms) {
            // SAFETY: the geometry is live and has this step, and Embree copies the 12 floats.
            unsafe {
                sys::rtcSetGeometryTransform(
                    self.raw,
                    step,
                    sys::RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                    transform.as_ptr().cast(),
                );
            }
        }
    }

    pub(crate) fn commit(&mut self) {
        // SAFETY: the geometry is live, and its buffers and instanced scene too.
        unsafe { sys::rtcCommitGeometry(self.raw) };
    }
}

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: one reference, made by rtcNewGeometry, given back once.
        unsafe { sys::rtcReleaseGeometry(self.raw) };
    }
}
