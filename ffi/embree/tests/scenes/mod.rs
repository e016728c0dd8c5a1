//! The small scenes that all tests trace.
#![allow(dead_code, reason = "each test binary uses some of it")]

use embree::{BuildQuality, Device, Geometry, Ray, Scene, VertexBuffer};
use std::sync::Arc;

pub type Triangle = [[f32; 3]; 3];

/// In the plane z = 0, seen from above counter-clockwise.
pub const UNIT_TRIANGLE: Triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

pub const IDENTITY: [f32; 12] = moved(0.0, 0.0, 0.0);

pub const fn moved(x: f32, y: f32, z: f32) -> [f32; 12] {
    [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, x, y, z]
}

pub fn device() -> Device {
    Device::new("threads=1").unwrap()
}

pub fn medium(device: &Device) -> Scene {
    Scene::new(device, BuildQuality::Medium, false).unwrap()
}

/// Triangles that share no vertex.
pub fn mesh(device: &Device, triangles: &[Triangle], mask: u32) -> Geometry {
    let vertices = Arc::new(VertexBuffer::new(triangles.as_flattened().to_vec()));
    let indices = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Geometry::triangles(device, vertices, Arc::new(indices), mask).unwrap()
}

/// Rays that fall along -z.
pub fn down<const N: usize>(start: impl Fn(usize) -> [f32; 3]) -> Ray<N> {
    let mut rays = Ray::default();
    for lane in 0..N {
        rays.set(lane, start(lane), [0.0, 0.0, -1.0], 0.0, f32::INFINITY);
    }
    rays
}
