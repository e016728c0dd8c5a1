//! Where a light path starts, and what it brings back. Rays of ambient occlusion start in the same way.

use glam::Vec3;

use crate::changes::Until;
use crate::shade::sampling::{PathRandom, PathSequence, cosine_direction};

/// Where a path starts.
#[derive(Debug, Clone, Copy)]
pub struct PathStart {
    /// Whatever number its owner knows it by.
    pub owner: u32,
    /// The cell for which it is traced.
    pub cell: u32,
    /// Its number among the paths of its surface.
    pub index: u32,
    /// Of its random numbers: all paths of a surface share it.
    pub sequence: PathSequence,
    /// On the surface, world space.
    pub point: Vec3,
    /// For shading, world space, unit length.
    pub normal: Vec3,
    /// At right angles to the normal, unit length; turns with the model, and the path with it.
    pub tangent: Vec3,
    /// Of the triangle, world space, unit length, on the same side.
    pub geometric_normal: Vec3,
}

impl PathStart {
    /// Its random numbers.
    #[inline]
    pub fn random(&self) -> PathRandom {
        self.sequence.path(self.index)
    }

    /// A direction by the cosine law about the normal, of two random numbers. Unit length.
    #[inline]
    pub fn direction(&self, random: [f32; 2]) -> Vec3 {
        cosine_direction(random, [self.tangent, self.normal.cross(self.tangent), self.normal])
    }
}

/// What a path brings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brought {
    /// Radiance, linear RGB.
    pub radiance: Vec3,
    /// The first frame in which it may be another.
    pub until: Until,
}
