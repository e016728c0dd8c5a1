//! A safe wrapper of [Embree 4](https://www.embree.org) for tracing packets of 4, 8 or 16 rays.
//!
//! A [`Device`] makes [`Scene`]s. A scene holds meshes ([`Geometry`]) and instances of [`FrozenScene`]s.
//! [`Scene::commit`] builds it and gives a [`Committed`], which answers rays: [`intersect`] for the closest
//! hit, [`occluded`] for any hit, [`occluded_past`] for any hit but with primitives that a ray passes.
//!
//! ```
//! use embree::{BuildQuality, Coherence, Device, Geometry, Ray, RayHit, Scene, Valid, VertexBuffer};
//! use std::sync::Arc;
//!
//! let device = Device::new("")?;
//! let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let vertices = Arc::new(VertexBuffer::new(corners));
//! let triangle = Geometry::triangles(&device, vertices, Arc::new(vec![[0, 1, 2]]), u32::MAX)?;
//!
//! let mut scene = Scene::new(&device, BuildQuality::Medium, false)?;
//! let id = scene.attach(&triangle)?;
//! let tracer = scene.commit()?;
//!
//! let mut rays = Ray::<8>::default();
//! rays.set(0, [0.25, 0.25, 1.0], [0.0, 0.0, -1.0], 0.0, f32::INFINITY);
//! let mut packet = RayHit::new(rays);
//! tracer.intersect(&Valid::first(1), &mut packet, Coherence::Coherent);
//! assert_eq!(packet.hit.geom_id[0], id.0);
//! assert!((packet.ray.tfar[0] - 1.0).abs() < 1e-6); // the last bit depends on the processor
//! # Ok::<(), embree::Error>(())
//! ```
//!
//! # What the compiler forbids
//! A scene cannot change while it is traced, because [`Committed`] borrows it:
//! ```compile_fail,E0499
//! # use embree::{BuildQuality, Coherence, Device, Geometry, Ray, Scene, Valid};
//! fn wrong(scene: &mut Scene, more: &Geometry) -> Result<(), embree::Error> {
//!     let tracer = scene.commit()?;
//!     scene.attach(more)?;
//!     tracer.occluded(&Valid::<8>::ALL, &mut Ray::default(), Coherence::Coherent);
//!     Ok(())
//! }
//! ```
//! nor go away:
//! ```compile_fail,E0505
//! # use embree::{BuildQuality, Coherence, Device, Ray, Scene, Valid};
//! fn wrong(mut scene: Scene) -> Result<(), embree::Error> {
//!     let tracer = scene.commit()?;
//!     drop(scene);
//!     tracer.occluded(&Valid::<8>::ALL, &mut Ray::default(), Coherence::Coherent);
//!     Ok(())
//! }
//! ```
//! A buffer cannot be freed under its geometry, nor written to: the geometry takes it, or a share of it, and a
//! [`VertexBuffer`] lends its vertices for reading alone.
//! ```compile_fail,E0382
//! # use embree::{Device, Error, Geometry, VertexBuffer};
//! # use std::sync::Arc;
//! fn wrong(device: &Device, vertices: VertexBuffer) -> Result<Geometry, Error> {
//!     let mesh = Geometry::triangles(device, Arc::new(vertices), Arc::new(vec![[0, 1, 2]]), u32::MAX)?;
//!     drop(vertices);
//!     Ok(mesh)
//! }
//! ```
//! A scene that instances show cannot be changed: [`Scene::freeze`] takes it away.
//! ```compile_fail,E0382
//! # use embree::{Geometry, Scene};
//! fn wrong(child: Scene, more: &Geometry) -> Result<(), embree::Error> {
//!     let frozen = child.freeze()?;
//!     child.attach(more)?;
//!     Ok(())
//! }
//! ```
//!
//! # Threads
//! Everything is `Send` and `Sync`; a [`Committed`] is `Copy`, made to be handed to all threads. Embree builds
//! with its own threads: commit outside of rayon's pool, or two pools share the cores. Embree recommends
//! flush-to-zero; that is undefined behaviour in Rust, and nothing here touches the floating-point environment.
//!
//! # Errors
//! Whatever can fail returns an [`Error`] with Embree's own message, taken where it arose. Queries cannot fail.
//!
//! # Finding the library
//! The build script's metadata reach direct dependents: `DEP_EMBREE_RPATH` (a folder to write into programs as
//! run path, empty if none is needed) and `DEP_EMBREE_VERSION` (of the headers).
//!
//! [`intersect`]: Committed::intersect
//! [`occluded`]: Committed::occluded
//! [`occluded_past`]: Committed::occluded_past

mod cutout;
mod device;
mod error;
mod geometry;
mod packet;
mod primitives;
mod quality;
mod query;
mod scene;
mod segment;

pub use cutout::{Candidates, Cutout};
pub use device::Device;
pub use error::{Error, ErrorCode};
pub use geometry::{Geometry, VertexBuffer};
pub use packet::{Hit, INVALID, PacketWidth, PrimId, Ray, RayHit, Valid};
pub use primitives::{PrimitiveHit, Primitives};
pub use quality::BuildQuality;
pub use query::{Coherence, Committed, OneHit};
pub use scene::{ALL_TIMES, FrozenScene, GeometryId, Scene};
pub use segment::{Bounds, Segment};
