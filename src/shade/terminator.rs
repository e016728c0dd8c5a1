//! The terminator: where light ends on smooth meshes. A triangle whose corners have normals stands for a piece of a curved
//! surface, and light ends where it would end there, not along the edges of triangles:
//!
//! - Light reaches a point from above the horizon of the curved surface, be it below that of the triangle.
//! - Rays to such light start on the curved surface: from the triangle they would lead into the mesh (Hanika, "Hacking the Shadow
//!   Terminator", Ray Tracing Gems II, chapter 4).
//! - What a normal map bends to the light [fades out](super::horizon::fading) towards that horizon.

use glam::Vec3;
use rayon::prelude::*;

use super::light::LightSample;
use super::surface::{corners_of, off_surface, off_surfaces, weights_of};
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::scene::{Mesh, Triangles};

/// Eight surfaces as light sees them, world space.
#[derive(Debug, Clone, Copy)]
pub struct Receivers {
    /// Points of triangles.
    pub point: Vec3x8,
    /// Shading normals.
    pub normal: Vec3x8,
    /// Normals of the curved surfaces, where a normal map bends any; else they are the shading normals.
    pub smooth: Option<Vec3x8>,
    /// Normals of the triangles.
    pub geometric_normal: Vec3x8,
    /// Bit mask of fibres, which light reaches from all around: their rays start within them.
    pub fibres: u8,
}

impl Receivers {
    /// Masks of the surfaces on whose front a light is, by their curved surfaces and by their triangles. They depend on geometry
    /// alone, since the answer is kept while the light's colour and power change.
    #[inline(always)]
    fn before(&self, light_sample: &LightSample) -> [Mask; 2] {
        let before = |normal: Vec3x8| normal.dot(light_sample.direction).gt(F32x8::ZERO);
        let curved = before(self.normal) & light_sample.reaches;
        let curved = self.smooth.map_or(curved, |smooth| curved & before(smooth));
        let flat = before(self.geometric_normal);
        if self.fibres == 0 {
            return [curved, flat];
        }
        let fibres = Mask::from_bits(self.fibres);
        [(curved | fibres) & light_sample.reaches, flat & !fibres]
    }

    /// Shadow rays from those of the surfaces whose bit is set in `wanted`. `lift` gives the [way](super::horizon::Horizon::lift) to the curved
    /// surface of a lane, and is asked for few.
    #[inline(always)]
    pub fn to_light(&self, light_sample: &LightSample, wanted: u8, lift: impl Fn(usize) -> Vec3) -> ToLight {
        let [curved, flat] = self.before(light_sample);
        let mut rays = ToLight {
            faces: (curved & flat).bits(),
            origins: off_surfaces(self.point, self.geometric_normal),
            to_light: light_sample.to_light,
        };
        let beyond = curved.bits() & !flat.bits() & wanted;
        for lane in (0..LANES).filter(|lane| beyond >> lane & 1 != 0) {
            let lift = lift(lane);
            if lift != Vec3::ZERO {
                rays.faces |= 1 << lane;
                rays.origins.set_lane(lane, rays.origins.lane(lane) + lift);
                rays.to_light.set_lane(lane, light_sample.from_lifted(lane, lift));
            }
        }
        rays
    }

    /// Shadow rays from one of the surfaces to sixteen points of a light, which start in one point.
    pub fn to_sixteen(
        &self,
        lane: usize,
        light_samples: &[LightSample; 2],
        lift: impl Fn() -> Vec3,
    ) -> ToSixteen {
        let one = |all: Vec3x8| Vec3x8::splat(all.lane(lane));
        let this = Self {
            point: self.point,
            normal: one(self.normal),
            smooth: self.smooth.map(one),
            geometric_normal: one(self.geometric_normal),
            fibres: if self.fibres >> lane & 1 != 0 { u8::MAX } else { 0 },
        };
        let halves = light_samples.each_ref().map(|half| this.before(half).map(Mask::bits));
        let of = |kind: usize| u16::from_le_bytes(halves.map(|half| half[kind]));
        let [curved, flat] = [of(0), of(1)];
        let lift = if curved & !flat == 0 { Vec3::ZERO } else { lift() };
        let origin = off_surface(self.point.lane(lane), self.geometric_normal.lane(lane));
        if lift == Vec3::ZERO {
            return ToSixteen { faces: curved & flat, origin, lift, light_samples: *light_samples };
        }
        let light_samples =
            light_samples.map(|half| LightSample { to_light: half.all_from_lifted(lift), ..half });
        ToSixteen { faces: curved, origin: origin + lift, lift, light_samples }
    }
}

/// Shadow rays from eight surfaces to a point of a light.
#[derive(Debug, Clone, Copy)]
pub struct ToLight {
    /// Bit mask of the surfaces whose front the light reaches if nothing is in its way. Only those that were wanted count.
    pub faces: u8,
    /// Origins, off the surfaces.
    pub origins: Vec3x8,
    /// Ways to the light; see [`LightSample::to_light`].
    pub to_light: Vec3x8,
}

/// Shadow rays from a surface to sixteen points of a light.
#[derive(Debug, Clone, Copy)]
pub struct ToSixteen {
    /// Bit mask of the points that the surface faces.
    pub faces: u16,
    /// Origin of all rays, off the surface.
    pub origin: Vec3,
    /// Way from the triangle to the curved surface on which the rays start, if they do.
    pub lift: Vec3,
    /// The points, seen from the origin.
    pub light_samples: [LightSample; 2],
}

/// A point of a triangle whose corners have normals.
#[derive(Debug, Clone, Copy)]
pub struct SmoothPoint {
    /// Corners of the triangle.
    pub corners: [Vec3; 3],
    /// Their normals: unit length, or zero where the file's was unusable.
    pub normals: [Vec3; 3],
    /// Weights of the second and third corner.
    pub weights: [f32; 2],
    /// The point, in the space of the corners.
    pub point: Vec3,
}

impl SmoothPoint {
    /// A point of one of these triangles at rest; `None` if they are flat.
    pub fn at_rest(triangles: &Triangles, triangle: u32, point: Vec3) -> Option<Self> {
        if triangles.normals.is_empty() {
            return None;
        }
        let corners = corners_of(triangles, triangle);
        let weights = weights_of(corners, point.as_dvec3()).map(|weight| weight as f32);
        let normals = triangles.corners[triangle as usize].map(|corner| triangles.normals[corner as usize]);
        Some(Self { corners: corners.map(|corner| corner.as_vec3()), normals, weights, point })
    }

    /// Normal of the curved surface on the outside, of any length.
    pub fn normal(&self) -> Vec3 {
        self.weighted(|corner| self.normals[corner])
    }

    /// Way from the point to the curved surface, on the outside (`side` 1) or the inside (-1): to the planes that touch it at the
    /// corners, in so far as the point is below them.
    pub fn lift(&self, side: f32) -> Vec3 {
        let lift = self.weighted(|corner| {
            let normal = self.normals[corner] * side;
            normal * (self.corners[corner] - self.point).dot(normal).max(0.0)
        });
        if lift.is_finite() { lift } else { Vec3::ZERO }
    }

    fn weighted(&self, of_corner: impl Fn(usize) -> Vec3) -> Vec3 {
        let [u, v] = self.weights;
        of_corner(0) * (1.0 - u - v) + of_corner(1) * u + of_corner(2) * v
    }
}

/// Upper bound of the length of the [lift](SmoothPoint::lift) of any point on either side of a mesh with these vertices, object space.
///
/// A point with the weights w is at most by the sum over j of wⱼ hᵢⱼ below the plane at corner i, where hᵢⱼ is how far corner j is,
/// and no corner is below its own. So the lift is at most the sum over i of wᵢ (1 - wᵢ) h for the largest of these h: two thirds of it.
pub fn most_lift(positions: &[[f32; 3]], normals: &[Vec3], triangles: &[[u32; 3]]) -> f32 {
    if normals.is_empty() {
        return 0.0;
    }
    let highest = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|corner| Vec3::from_array(positions[corner as usize]));
        let [at_a, at_b, at_c] = triangle.map(|corner| normals[corner as usize]);
        let [ab, bc, ca] = [b - a, c - b, a - c];
        let of_corners = [ab.dot(at_a), ca.dot(at_a), ab.dot(at_b), bc.dot(at_b), bc.dot(at_c), ca.dot(at_c)];
        of_corners.into_iter().fold(0.0_f32, |largest, height| largest.max(height.abs()))
    };
    let largest = triangles.par_iter().map(highest).reduce(|| 0.0, f32::max);
    // a little more for rounding
    largest * (2.0 / 3.0 * 1.001)
}

/// [`most_lift`] of a mesh at rest.
pub fn most_lift_at_rest(mesh: &Mesh) -> f32 {
    let of = |Triangles { positions, normals, corners, .. }: &Triangles| {
        most_lift(positions.as_slice(), normals, corners)
    };
    match mesh.as_curved() {
        // rays from fibres start within them
        Some(curved) => curved.most_radius(),
        None => mesh.as_triangles().map_or(0.0, of),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A face of an octahedron inside the unit sphere, whose normals are the sphere's.
    fn of_sphere(weights: [f32; 2]) -> SmoothPoint {
        let corners = [Vec3::X, Vec3::Y, Vec3::Z];
        let [u, v] = weights;
        let point = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
        SmoothPoint { corners, normals: corners, weights, point }
    }

    #[test]
    fn points_are_lifted_to_where_no_corner_s_plane_is_above_them() {
        for weights in [[1.0 / 3.0, 1.0 / 3.0], [0.5, 0.0], [0.1, 0.8]] {
            let all = of_sphere(weights);
            let lifted = all.point + all.lift(1.0);
            let outward = Vec3::ONE.normalize();
            assert!(lifted.dot(outward) > all.point.dot(outward), "{weights:?}: {lifted}");
            assert!(lifted.length() <= 1.1, "{weights:?}: {lifted}");
            // seen from within it is hollow
            assert_eq!(all.lift(-1.0), Vec3::ZERO);
        }
        for corner in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] {
            assert_eq!(of_sphere(corner).lift(1.0), Vec3::ZERO);
        }
    }

    #[test]
    fn no_lift_is_above_its_bound() {
        let mut state = 1_u32;
        let mut any = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 8_388_608.0 - 1.0
        };
        let mut closest = 0.0_f32;
        for _ in 0..2000 {
            let mut vector = || Vec3::new(any(), any(), any());
            let corners = [vector(), vector(), vector()];
            let normals = [vector(), vector(), vector()].map(|normal| normal.normalize_or_zero());
            let bound = most_lift(&corners.map(|corner| corner.to_array()), &normals, &[[0, 1, 2]]);
            for [u, v] in [[1.0 / 3.0, 1.0 / 3.0], [0.5, 0.5], [0.1, 0.2], [0.0, 0.6]] {
                let point = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
                let all = SmoothPoint { corners, normals, weights: [u, v], point };
                for side in [1.0, -1.0] {
                    let lift = all.lift(side).length();
                    assert!(lift <= bound, "{lift} > {bound}");
                    closest = closest.max(lift / bound);
                }
            }
        }
        assert!(closest > 0.5, "a bound that says something: {closest}");
    }
}
