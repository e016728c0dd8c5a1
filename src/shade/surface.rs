//! Points of surfaces that rays have met, and the origins of rays that leave them.

use glam::{DVec3, Vec3};
use wide::{CmpGt, f64x4};

use super::bsdf::SurfaceAxes;
use super::horizon::Horizon;
use super::within::Within;
use crate::animation::Transform;
use crate::geometry::{Bounds, Curved};
use crate::lanes::{F32x8, LANES, Mask, Vec3x8, unsigned};
use crate::scene::look::{Look, Varied};
use crate::scene::material::Optics;
use crate::scene::on_mesh::OnMesh;
use crate::scene::{Geometry, Mesh, Model, Scene, Triangles};

/// A point of a surface as shading sees it, world space. Normals have unit length and point to the side
/// from which the surface is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Point, world space.
    pub point: Vec3,
    /// Shading normal, interpolated from the corners where the mesh has normals.
    pub normal: Vec3,
    /// Normal of the triangle itself; of a curved primitive the same as `normal`.
    pub geometric_normal: Vec3,
    /// Tangent, of any length; zero if its material asks for none.
    pub tangent: Vec3,
    /// The curved surface that the triangle stands for.
    pub horizon: Horizon,
    /// Reflectance that its material's diffuse and ambient ones are shares of, texture included: see
    /// [`Material::painted`](crate::scene::Material::painted).
    pub reflectance: Vec3,
    /// Index into [`Scene::materials`].
    pub material: u16,
    /// Parameters of the material that vary, there.
    pub varied: Varied,
    /// True if the back of the triangle is seen.
    pub from_behind: bool,
    /// Width of the beam that sees it, world space; 0 if nobody asks.
    pub width: f32,
}

/// Corners of eight triangles, object space, as in the mesh.
#[derive(Debug, Clone, Copy)]
pub struct Corners {
    first: Vec3x8,
    second: Vec3x8,
    third: Vec3x8,
    /// Normals at the three corners, for triangles whose mesh has some.
    normals: [Vec3x8; 3],
    is_smooth: Mask,
    /// Bit mask of lanes that hold a curved primitive instead: the caller fills in their surfaces by
    /// [`each_curved`].
    curved: u8,
}

impl Corners {
    /// Lanes that hold no triangle yet; their values are finite all the same.
    pub const NONE: Self = Self {
        first: Vec3x8::ZERO,
        second: Vec3x8 { x: F32x8::ONE, y: F32x8::ZERO, z: F32x8::ZERO },
        third: Vec3x8 { x: F32x8::ZERO, y: F32x8::ONE, z: F32x8::ZERO },
        normals: [Vec3x8::ZERO; 3],
        is_smooth: Mask::NONE,
        curved: 0,
    };

    /// Puts `triangle` of `mesh` into a lane, or notes that it is curved.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, mesh: &Mesh, triangle: u32) {
        let Geometry::Triangles(triangles) = &mesh.geometry else {
            self.curved |= 1 << lane;
            return;
        };
        let corners = triangles.corners[triangle as usize].map(|corner| corner as usize);
        let positions = triangles.positions.as_slice();
        let [a, b, c] = corners.map(|corner| Vec3::from_array(positions[corner]));
        self.first.set_lane(lane, a);
        self.second.set_lane(lane, b);
        self.third.set_lane(lane, c);
        if !triangles.normals.is_empty() {
            for (normals, corner) in self.normals.iter_mut().zip(corners) {
                normals.set_lane(lane, triangles.normals[corner]);
            }
            self.is_smooth.set(lane);
        }
    }

    /// `triangle` of `mesh` in all lanes.
    #[inline(always)]
    pub fn all(mesh: &Mesh, triangle: u32) -> Self {
        let mut one = Self::NONE;
        one.set(0, mesh, triangle);
        let all = |corner: Vec3x8| Vec3x8::splat(corner.lane(0));
        Self {
            first: all(one.first),
            second: all(one.second),
            third: all(one.third),
            normals: one.normals.map(all),
            is_smooth: if one.is_smooth.lane(0) { Mask::ALL } else { Mask::NONE },
            curved: if one.curved != 0 { u8::MAX } else { 0 },
        }
    }

    /// Corners in one lane, object space.
    #[inline(always)]
    pub fn of_lane(&self, lane: usize) -> [Vec3; 3] {
        [&self.first, &self.second, &self.third].map(|corner| corner.lane(lane))
    }

    /// Returns true if a lane holds a triangle whose mesh has normals.
    #[inline(always)]
    pub fn is_smooth(&self, lane: usize) -> bool {
        self.is_smooth.lane(lane)
    }

    /// Bit mask of the lanes that hold curved primitives.
    #[inline(always)]
    pub fn curved(&self) -> u8 {
        self.curved
    }

    /// Points with these barycentric weights of the second and third corner.
    #[inline(always)]
    pub fn point(&self, [u, v]: [F32x8; 2]) -> Vec3x8 {
        self.first + (self.second - self.first) * u + (self.third - self.first) * v
    }

    /// Barycentric weights of the second and third corner at `points` of the triangles, in double floats.
    /// Rounding may put points beside very thin triangles: the weights are those of a point inside.
    ///
    /// The stored attributes of a surface are looked up at the weights of the stored point, and not at those
    /// of the hit: a point is rounded, and far from the origin, or on a fine texture, the surface is another
    /// there. So the surface at a stored point can be found again, to the bit.
    #[inline(always)]
    pub fn weights_at(&self, points: Vec3x8) -> [F32x8; 2] {
        let (mut second, mut third) = ([0.0; LANES], [0.0; LANES]);
        for half in [0, LANES / 2] {
            let four = |of: &Vec3x8| [&of.x, &of.y, &of.z].map(|axis| four_doubles(axis.values(), half));
            let corners = [four(&self.first), four(&self.second), four(&self.third)];
            let [u, v] = weights_of_four(corners, four(&points));
            for (lane, (u, v)) in (half..).zip(u.to_array().into_iter().zip(v.to_array())) {
                (second[lane], third[lane]) = (u as f32, v as f32);
            }
        }
        [F32x8::new(second), F32x8::new(third)]
    }

    /// Normals of the triangles by the right-hand rule over the corners, of unit length.
    #[inline(always)]
    pub fn geometric_normal(&self) -> Vec3x8 {
        let across = (self.second - self.first).cross(self.third - self.first);
        let squared = across.dot(across);
        let mut geometric_normal = across * (F32x8::splat(1.0) / squared.sqrt());
        let fits = squared.gt(F32x8::splat(LEAST_SQUARE)) & squared.lt(F32x8::splat(f32::INFINITY));
        for lane in (0..LANES).filter(|lane| !fits.lane(*lane)) {
            geometric_normal.set_lane(lane, self.exact_geometric_normal(lane));
        }
        geometric_normal
    }

    /// Normal of a tiny or huge triangle: in single floats the cross product of edges of 1e-10 is all but 0,
    /// and the square of that of edges of 1e10 is infinite.
    #[cold]
    fn exact_geometric_normal(&self, lane: usize) -> Vec3 {
        let [a, b, c] = [self.first, self.second, self.third].map(|corner| corner.lane(lane).as_dvec3());
        (b - a).cross(c - a).try_normalize().map_or(Vec3::Y, |normal| normal.as_vec3())
    }

    /// Shading normals, of unit length: interpolated where the mesh has normals, the geometric ones
    /// elsewhere.
    #[inline(always)]
    pub fn normal(&self, weights: [F32x8; 2]) -> Vec3x8 {
        self.normals(weights)[0]
    }

    /// [Shading normals](Self::normal), and [geometric ones](Self::geometric_normal).
    #[inline(always)]
    pub fn normals(&self, [u, v]: [F32x8; 2]) -> [Vec3x8; 2] {
        let geometric_normal = self.geometric_normal();
        if !self.is_smooth.any() {
            return [geometric_normal; 2];
        }
        let w = F32x8::splat(1.0) - u - v;
        let sum = self.normals[0] * w + self.normals[1] * u + self.normals[2] * v;
        let squared = sum.dot(sum);
        let usable = self.is_smooth & squared.gt(F32x8::splat(LEAST_SQUARE));
        let normal = usable.select3(sum * (F32x8::splat(1.0) / squared.sqrt()), geometric_normal);
        [normal, geometric_normal]
    }
}

/// Barycentric weights of the second and third corner at `point` of a triangle: those of a point inside, see
/// [`Corners::weights_at`].
#[inline(always)]
pub fn weights_of([a, b, c]: [DVec3; 3], point: DVec3) -> [f64; 2] {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let normal = ab.cross(ac);
    let square = normal.dot(normal);
    let scale = if square > 0.0 { 1.0 / square } else { 0.0 };
    let u = (ap.cross(ac).dot(normal) * scale).max(0.0);
    let v = (ab.cross(ap).dot(normal) * scale).max(0.0);
    let most = (u + v).max(1.0);
    [u / most, v / most]
}

/// Four of `values`, from number `first` on, as double floats.
#[inline(always)]
fn four_doubles(values: &[f32; LANES], first: usize) -> f64x4 {
    f64x4::new(std::array::from_fn(|lane| f64::from(values[first + lane])))
}

/// [`weights_of`] four points, to the bit.
#[inline(always)]
fn weights_of_four([a, b, c]: [[f64x4; 3]; 3], point: [f64x4; 3]) -> [f64x4; 2] {
    let minus = |to: [f64x4; 3]| [to[0] - a[0], to[1] - a[1], to[2] - a[2]];
    let cross = |[x, y, z]: [f64x4; 3], [u, v, w]: [f64x4; 3]| [y * w - v * z, z * u - w * x, x * v - u * y];
    let dot = |[x, y, z]: [f64x4; 3], [u, v, w]: [f64x4; 3]| x * u + y * v + z * w;
    let (zero, one) = (f64x4::splat(0.0), f64x4::splat(1.0));
    let (ab, ac, ap) = (minus(b), minus(c), minus(point));
    let normal = cross(ab, ac);
    let square = dot(normal, normal);
    let scale = square.cmp_gt(zero).blend(one / square, zero);
    let u = (dot(cross(ap, ac), normal) * scale).max(zero);
    let v = (dot(cross(ab, ap), normal) * scale).max(zero);
    let most = (u + v).max(one);
    // mostly all are inside: a division by one would change nothing, and take time
    if most == one { [u, v] } else { [u / most, v / most] }
}

/// Calls `put` with each lane of `curved`, its geometry and its primitive, if there are any. `of` gives the mesh
/// and the primitive of a lane.
#[inline(always)]
pub fn each_curved<'a>(
    curved: u8,
    of: impl Fn(usize) -> (&'a Mesh, u32),
    mut put: impl FnMut(usize, &dyn Curved, u32),
) {
    if curved == 0 {
        return;
    }
    for lane in (0..LANES).filter(|lane| curved >> lane & 1 != 0) {
        let (mesh, primitive) = of(lane);
        if let Some(curved) = mesh.as_curved() {
            put(lane, curved.as_ref(), primitive);
        }
    }
}

/// Surface of a mesh at a point of one of its primitives, object space.
#[derive(Debug, Clone, Copy)]
pub struct SurfacePoint {
    /// Barycentric weights: see [`Corners::weights_at`].
    pub weights: [f32; 2],
    /// Shading normal; unit length.
    pub normal: Vec3,
    /// Normal of the triangle itself; unit length.
    pub geometric_normal: Vec3,
    /// Distance of the point from the primitive.
    pub distance: f64,
}

impl SurfacePoint {
    /// Weights of the second and third corner of a triangle, or of a curved primitive, at `point`, at rest.
    pub fn weights(mesh: &Mesh, primitive: u32, point: Vec3) -> [f32; 2] {
        match &mesh.geometry {
            Geometry::Triangles(_) => {
                Corners::all(mesh, primitive).weights_at(Vec3x8::splat(point)).map(|weight| weight.lane(0))
            }
            Geometry::Curved(curved) => curved.weights(primitive, point),
        }
    }

    /// Computes the surface at `point` of a primitive of a model, at rest. `width`: of the part of the surface over which textures are
    /// filtered.
    pub fn at(scene: &Scene, (model, primitive): (&Model, u32), point: Vec3, width: f32) -> Self {
        let triangles = match &model.mesh.geometry {
            Geometry::Triangles(triangles) => triangles,
            Geometry::Curved(curved) => {
                let weights = curved.weights(primitive, point);
                let normal = curved.normal(primitive, weights);
                let distance = curved.distance(primitive, point);
                return Self { weights, normal, geometric_normal: normal, distance };
            }
        };
        let corners = Corners::all(&model.mesh, primitive);
        let lanes = corners.weights_at(Vec3x8::splat(point));
        let weights = lanes.map(|weight| weight.lane(0));
        let exact = point.as_dvec3();
        let (place, normal) =
            (OnMesh::on(model, primitive, weights).with_width(width), corners.normal(lanes).lane(0));
        Self {
            weights,
            normal: place.bent_normal(scene, normal, corners.of_lane(0)),
            geometric_normal: corners.geometric_normal().lane(0),
            distance: nearest_point(corners_of(triangles, primitive), exact).distance(exact),
        }
    }
}

/// Cosine of the angle at which a surface with these normals (smooth, and that of the triangle; world space, unit length) is seen `along`
/// a way of any length: see [`Place::facing`](crate::graph::Place::facing).
pub fn facing([normal, geometric_normal]: [Vec3; 2], along: Vec3) -> f32 {
    let cos = normal.dot(along.normalize_or_zero()).abs().min(1.0);
    if geometric_normal.dot(along) > 0.0 { -cos } else { cos }
}

/// Least squared length to divide by: below it, lengths are too inexact.
const LEAST_SQUARE: f32 = 1e-30;

/// Intersects the ray from `eye` along `direction` (world space) with the plane of a triangle, and moves the
/// point into the triangle (object space), all in double floats. `None` for triangles without an area. On a
/// curved primitive, the intersection nearest to `about` (object space) is taken.
pub fn meet_exactly(
    transform: &Transform,
    (mesh, primitive): (&Mesh, u32),
    (eye, direction): (Vec3, Vec3),
    about: Vec3,
) -> Option<Vec3> {
    let [origin, along] = transform.line_to_object((eye, direction));
    let triangles = match &mesh.geometry {
        Geometry::Triangles(triangles) => triangles,
        Geometry::Curved(curved) => return Some(curved.meet_line(primitive, origin, along, about)),
    };
    let [a, b, c] = corners_of(triangles, primitive);
    let plane = (b - a).cross(c - a);
    if plane == DVec3::ZERO {
        return None;
    }
    let t = (a - origin).dot(plane) / along.dot(plane);
    // edge on: any point of the triangle will do
    let met = if t.is_finite() { origin + along * t } else { a };
    Some(nearest_point([a, b, c], met).as_vec3())
}

/// Normal of the surface itself at a place on a primitive, outwards, object space: unit length, or zero for triangles without an area.
pub fn geometric_normal_of(mesh: &Mesh, primitive: u32, weights: [f32; 2]) -> Vec3 {
    match &mesh.geometry {
        Geometry::Triangles(triangles) => {
            let [a, b, c] = corners_of(triangles, primitive);
            (b - a).cross(c - a).normalize_or_zero().as_vec3()
        }
        Geometry::Curved(curved) => curved.normal(primitive, weights),
    }
}

/// Corners of a triangle, object space.
pub fn corners_of(triangles: &Triangles, triangle: u32) -> [DVec3; 3] {
    triangles.positions_of(triangle).map(|corner| corner.as_dvec3())
}

/// Nearest point of a triangle to `point`: the region of corner, edge or face that `point` lies in decides
/// (C. Ericson, Real-Time Collision Detection, section 5.1.5). Clamping barycentric coordinates instead would
/// move a point beside a sliver along the whole sliver.
pub fn nearest_point([a, b, c]: [DVec3; 3], point: DVec3) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    let from = |corner: DVec3| (ab.dot(point - corner), ac.dot(point - corner));
    let ((d1, d2), (d3, d4), (d5, d6)) = (from(a), from(b), from(c));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let (of_a, of_b, of_c) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if of_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    if of_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    if of_a <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    a + (ab * of_b + ac * of_c) / (of_a + of_b + of_c)
}

impl Surface {
    /// Its material, with its parameters there.
    pub fn look(&self) -> Look {
        Look { material: self.material, varied: self.varied }
    }

    /// Its emission: radiance, linear RGB.
    pub fn emission(&self, scene: &Scene) -> Vec3 {
        scene.materials[usize::from(self.material)].emission_at(self.varied)
    }

    /// Effect on rays that meet it.
    pub fn optics(&self, scene: &Scene) -> Optics {
        scene.materials[usize::from(self.material)].optics_at(self.varied)
    }

    /// Directions by which its layer reflects.
    pub fn axes(&self) -> SurfaceAxes<Vec3> {
        let Self { normal, geometric_normal, tangent, .. } = *self;
        SurfaceAxes { normal, geometric_normal, tangent }
    }

    /// What a ray goes through that passes the surface, where it went through `before` it.
    pub fn within_behind(&self, scene: &Scene, before: Within) -> Within {
        let is_solid = scene.materials[usize::from(self.material)].is_solid();
        if is_solid { before.beyond(self.material, self.from_behind) } else { before }
    }

    /// The same place seen from the other side.
    #[must_use]
    pub fn flipped(self) -> Self {
        let geometric_normal = -self.geometric_normal;
        let normal = -self.normal;
        Self {
            normal,
            geometric_normal,
            horizon: Horizon::flat(normal),
            from_behind: !self.from_behind,
            ..self
        }
    }

    /// Origin of a ray that leaves the surface on the side of `direction`.
    pub fn leave(&self, direction: Vec3) -> Vec3 {
        let outward = if self.geometric_normal.dot(direction) < 0.0 {
            -self.geometric_normal
        } else {
            self.geometric_normal
        };
        off_surface(self.point, outward)
    }
}

/// Largest distance by which [`off_surface`] moves a point along an axis, as a share of its coordinate and in
/// world units.
const OFF_SURFACE: [f32; 2] = [256.0 * f32::EPSILON, 1.0 / 65536.0];

/// Moves `point` along `normal` just so far that a ray from there does not meet the surface again.
pub fn off_surface(point: Vec3, normal: Vec3) -> Vec3 {
    off_surfaces(Vec3x8::splat(point), Vec3x8::splat(normal)).lane(0)
}

/// [`off_surface`] for eight points.
///
/// Integer steps in the floats' own units make the distance fit the size of the coordinates; near zero a
/// fixed distance serves (Wächter and Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray
/// Tracing Gems, chapter 6).
#[inline(always)]
pub fn off_surfaces(points: Vec3x8, normals: Vec3x8) -> Vec3x8 {
    const STEPS: f32 = OFF_SURFACE[0] / f32::EPSILON;
    const NEAR_ZERO: f32 = 1.0 / 32.0;
    const FIXED: f32 = OFF_SURFACE[1];
    let moved = |point: F32x8, normal: F32x8| {
        let near = point.abs().lt(F32x8::splat(NEAR_ZERO));
        let steps = (normal * F32x8::splat(STEPS)).with_sign_changed_by(point);
        let far = F32x8::from_bits(point.to_bits() + unsigned(steps.to_whole()));
        near.select(point + normal * F32x8::splat(FIXED), far)
    };
    Vec3x8 { x: moved(points.x, normals.x), y: moved(points.y, normals.y), z: moved(points.z, normals.z) }
}

/// Box around the origins, off surfaces, of all rays from `surfaces`.
pub fn around_origins(surfaces: &Bounds) -> Bounds {
    let [share, least] = OFF_SURFACE;
    let room = surfaces.low.abs().max(surfaces.high.abs()) * share + least;
    Bounds { low: surfaces.low - room, high: surfaces.high + room }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_outwards_on_both_sides_of_zero() {
        for at in [-2.7e6_f32, -3.0, -0.01, 0.0, 0.01, 3.0, 2.7e6] {
            assert!(off_surface(Vec3::splat(at), Vec3::X).x > at);
            assert!(off_surface(Vec3::splat(at), Vec3::NEG_X).x < at);
        }
        let far = off_surface(Vec3::splat(1000.0), Vec3::X).x - 1000.0;
        assert!(far < 1000.0 * 1e-4, "the step stays in proportion: {far}");
    }

    /// Checks triangles of all sizes, slivers and such without an area, with points in them, beside them and
    /// far away.
    #[test]
    fn weights_of_eight_points_are_those_of_each_to_the_bit() {
        let mut state = 1_u32;
        let mut any = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 8_388_608.0 - 1.0
        };
        for round in 0..2000 {
            let size = [1.0, 1e-6, 1e6, 0.0][round % 4];
            let [mut a, mut b, mut c, mut points] = [Vec3x8::ZERO; 4];
            for lane in 0..LANES {
                let mut vector = || Vec3::new(any(), any(), any());
                let corners = [vector(), vector(), vector()].map(|corner| corner * size);
                let thin =
                    if round % 3 == 0 { corners[0] + (corners[1] - corners[0]) * 0.3 } else { corners[2] };
                a.set_lane(lane, corners[0]);
                b.set_lane(lane, corners[1]);
                c.set_lane(lane, thin);
                points.set_lane(lane, vector() * size.max(0.1));
            }
            let eight = Corners { first: a, second: b, third: c, ..Corners::NONE }.weights_at(points);
            for lane in 0..LANES {
                let corners = [&a, &b, &c].map(|corner| corner.lane(lane).as_dvec3());
                let one = weights_of(corners, points.lane(lane).as_dvec3()).map(|weight| weight as f32);
                assert_eq!(eight.map(|weights| weights.lane(lane)), one, "round {round}, lane {lane}");
            }
        }
    }

    #[test]
    fn the_nearest_point_of_a_triangle_is_in_its_region() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for (point, nearest) in [
            ([0.25, 0.5, 3.0], [0.25, 0.5, 0.0]),
            ([-1.0, -2.0, 0.5], [0.0, 0.0, 0.0]),
            ([2.0, -0.5, 0.0], [1.0, 0.0, 0.0]),
            ([-0.5, 3.0, 0.0], [0.0, 1.0, 0.0]),
            ([0.5, -1.0, 1.0], [0.5, 0.0, 0.0]),
            ([-1.0, 0.25, 0.0], [0.0, 0.25, 0.0]),
            ([1.0, 1.0, -1.0], [0.5, 0.5, 0.0]),
        ] {
            assert_eq!(nearest_point(corners, DVec3::from(point)), DVec3::from(nearest), "{point:?}");
        }
    }

    /// Checks a sliver along which clamped barycentric coordinates would lead some 40 units.
    #[test]
    fn beside_a_sliver_the_nearest_point_is_across_it() {
        let corners = [DVec3::ZERO, DVec3::new(412.0, 0.0, 0.0), DVec3::new(412.0, 0.03, 0.0)];
        let beside = DVec3::new(200.0, -0.001, 0.0);
        assert!(nearest_point(corners, beside).distance(beside) < 0.001_000_1);
    }

    #[test]
    fn weights_stay_within_triangles_that_are_thinner_than_rounding() {
        for third in [Vec3::new(9.0, 8.0 + 1e-6, 7.0), Vec3::new(9.0, 8.0, 7.0)] {
            let mut corners = Corners::NONE;
            let [first, second] = [Vec3::new(8.0, 8.0, 7.0), Vec3::new(9.0, 8.0, 7.0)];
            (corners.first, corners.second, corners.third) =
                (Vec3x8::splat(first), Vec3x8::splat(second), Vec3x8::splat(third));
            for aside in [-1e-6, 0.0, 1e-6] {
                let [u, v] = corners.weights_at(Vec3x8::splat(Vec3::new(8.5, 8.0 + aside, 7.0)));
                let [u, v] = [u.lane(0), v.lane(0)];
                assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.000_001, "{third} {aside}: {u} {v}");
            }
        }
    }

    #[test]
    fn triangles_of_all_sizes_have_normals() {
        for scale in [1e-12_f32, 1e-3, 1e6, 1e10, 1e12] {
            let mut corners = Corners::NONE;
            (corners.second, corners.third) =
                (Vec3x8::splat(Vec3::X * scale), Vec3x8::splat(Vec3::Y * scale));
            assert!((corners.geometric_normal().lane(5) - Vec3::Z).length() < 1e-6, "{scale}");
        }
    }

    #[test]
    fn weights_lead_back_to_the_point() {
        for scale in [1e-9_f32, 1.0, 1e9] {
            let mut corners = Corners::NONE;
            (corners.first, corners.second, corners.third) = (
                Vec3x8::splat(Vec3::new(1.0, 2.0, 3.0) * scale),
                Vec3x8::splat(Vec3::new(4.0, 2.5, 3.0) * scale),
                Vec3x8::splat(Vec3::new(1.5, 5.0, 2.0) * scale),
            );
            let wanted = [F32x8::splat(0.25), F32x8::splat(0.5)];
            let weights = corners.weights_at(corners.point(wanted));
            for (weight, wanted) in weights.iter().zip(wanted) {
                assert!((weight.lane(3) - wanted.lane(3)).abs() < 1e-6, "{scale}: {weight:?}");
            }
        }
    }
}
