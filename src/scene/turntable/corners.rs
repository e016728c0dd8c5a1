//! Parallel folds over the corners of a model's triangles, of which there may be many.

use glam::{DVec3, Vec3A};
use rayon::prelude::*;

/// Number of triangles that one thread handles in one go.
const BLOCK: usize = 1 << 14;

/// Positions and triangles of a file that was read. Vertices that no triangle uses do not count.
#[derive(Debug, Clone, Copy)]
pub(in crate::scene) struct Corners<'a> {
    pub positions: &'a [[f32; 3]],
    pub triangles: &'a [[u32; 3]],
}

impl Corners<'_> {
    /// Folds all corners, in any order: `with` and `joined` must not depend on it.
    pub fn fold<T: Copy + Send + Sync>(
        &self,
        nothing: T,
        with: impl Fn(T, Vec3A) -> T + Sync,
        joined: impl Fn(T, T) -> T + Sync,
    ) -> T {
        let of_block = |block: &[[u32; 3]]| {
            let points = block.as_flattened().iter().map(|i| Vec3A::from(self.positions[*i as usize]));
            points.fold(nothing, &with)
        };
        self.triangles.par_chunks(BLOCK).map(of_block).reduce(|| nothing, &joined)
    }

    /// Computes the smallest box.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let joined = |a: (Vec3A, Vec3A), b: (Vec3A, Vec3A)| (a.0.min(b.0), a.1.max(b.1));
        let nothing = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        let (low, high) = self.fold(nothing, |all, point| joined(all, (point, point)), joined);
        (low.as_dvec3(), high.as_dvec3())
    }

    /// Computes the centre of the surface.
    pub fn center(&self) -> DVec3 {
        let of_block = |block: &[[u32; 3]]| {
            let sum = |(sum, area): (DVec3, f64), triangle: &[u32; 3]| {
                let [a, b, c] = triangle.map(|i| Vec3A::from(self.positions[i as usize]).as_dvec3());
                let own = (b - a).cross(c - a).length();
                (sum + own * (a + b + c) / 3.0, area + own)
            };
            block.iter().fold((DVec3::ZERO, 0.0), sum)
        };
        // one after the other, so that the sum does not depend on the number of threads
        let sums: Vec<(DVec3, f64)> = self.triangles.par_chunks(BLOCK).map(of_block).collect();
        let (sum, area) = sums.into_iter().fold((DVec3::ZERO, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        if area > 0.0 && sum.is_finite() { sum / area } else { self.bounds().0 }
    }
}
