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
