<<<<<<< HEAD
//! (to be filled)
/// Vertices (to be filled).
#[derive(Debug)]
pub struct VertexBuffer(Vec<[f32; 3]>);
impl VertexBuffer {
    /// New.
    pub fn new(v: Vec<[f32; 3]>) -> Self {
        Self(v)
    }
    /// All.
    pub fn as_slice(&self) -> &[[f32; 3]] {
        &self.0
    }
}
=======
//! A safe wrapper of Embree 4 for tracing packets of 16 rays.

mod device;
mod error;
mod geometry;
mod packet;
mod query;
mod scene;

pub use device::Device;
pub use error::{Error, ErrorCode};
pub use geometry::{Geometry, VertexBuffer};
pub use packet::{Hit16, INVALID, LANES, OwnPrims16, Ray16, RayHit16, Valid16};
pub use query::{Bounds, Coherence, Committed};
pub use scene::{BuildQuality, FrozenScene, GeometryId, Scene};
>>>>>>> ffi-embree
