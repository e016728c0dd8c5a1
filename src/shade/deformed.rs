//! Deforming meshes as they are at one time: from places on the shape at rest to where these are.

use glam::{DVec3, Vec3};

use super::surface::{corners_of, nearest_point, weights_of};
use crate::animation::{Shape, Transform};
use crate::scene::{Mesh, Scene};

/// A mesh in one of its shapes.
#[derive(Debug, Clone)]
pub struct Deformed {
    /// By vertex, object space.
    positions: Vec<[f32; 3]>,
    /// By vertex, unit length or zero; none at all for flat meshes, or where nobody asks for them.
    normals: Vec<Vec3>,
}

/// A place on a deformed mesh, object space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeformedPlace {
    /// Where it is.
    pub point: Vec3,
    /// For shading, on the outside; unit length, or zero where the triangle has no area.
    pub normal: Vec3,
    /// Of the triangle, on the outside; unit length, or zero where it has no area.
    pub geometric_normal: Vec3,
}

impl Deformed {
    /// `mesh` in `shape`; `None` where it does not deform. Only for points, if there is no need of its `normals`.
    pub fn of(mesh: &Mesh, shape: &Shape, normals: bool) -> Option<Self> {
        let shapes = mesh.shapes.as_ref()?;
        let positions = shapes.positions(shape);
        let normals = if normals { shapes.normals(&positions, &mesh.triangles) } else { Vec::new() };
        Some(Self { positions, normals })
    }

    /// The corners of `triangle` of `mesh`.
    pub fn corners(&self, mesh: &Mesh, triangle: u32) -> [DVec3; 3] {
        let place = |corner: u32| Vec3::from_array(self.positions[corner as usize]).as_dvec3();
        mesh.triangles[triangle as usize].map(place)
    }

    /// Where a `point` of `triangle` is that is at rest there.
    pub fn point(&self, mesh: &Mesh, triangle: u32, point: Vec3) -> Vec3 {
        let weights = weights_of(corners_of(mesh, triangle), point.as_dvec3());
        at_weights(self.corners(mesh, triangle), weights).as_vec3()
    }

    /// The same, with the normals there.
    pub fn place(&self, mesh: &Mesh, triangle: u32, point: Vec3) -> DeformedPlace {
        let [u, v] = weights_of(corners_of(mesh, triangle), point.as_dvec3());
        let corners = self.corners(mesh, triangle);
        let geometric_normal = normal_of(corners);
        let normal = match self.normals.as_slice() {
            [] => geometric_normal,
            normals => {
                let [a, b, c] = mesh.triangles[triangle as usize].map(|corner| normals[corner as usize]);
                let mean = a.as_dvec3() * (1.0 - u - v) + b.as_dvec3() * u + c.as_dvec3() * v;
                mean.try_normalize().map_or(geometric_normal, |normal| normal.as_vec3())
            }
        };
        DeformedPlace { point: at_weights(corners, [u, v]).as_vec3(), normal, geometric_normal }
    }

    /// The outside of `triangle`; unit length, or zero where it has no area.
    pub fn geometric_normal(&self, mesh: &Mesh, triangle: u32) -> Vec3 {
        normal_of(self.corners(mesh, triangle))
    }

    /// Where a `direction` in the plane of `triangle` at rest leads now, of any length; not known of triangles without an area.
    pub fn direction(&self, mesh: &Mesh, triangle: u32, direction: Vec3) -> Option<Vec3> {
        let [a, b, c] = corners_of(mesh, triangle);
        let (along, up, way) = (b - a, c - a, direction.as_dvec3());
        let normal = along.cross(up);
        let square = normal.length_squared();
        let (u, v) = (way.cross(up).dot(normal) / square, along.cross(way).dot(normal) / square);
        let [a, b, c] = self.corners(mesh, triangle);
        Some(((b - a) * u + (c - a) * v).as_vec3()).filter(|way| way.is_finite())
    }

    /// The point at rest of that point of `triangle` which is nearest to where a line meets its plane; see
    /// [`meet_exactly`](super::surface::meet_exactly).
    pub fn meet(&self, mesh: &Mesh, triangle: u32, [origin, along]: [DVec3; 2]) -> Option<Vec3> {
        let corners = self.corners(mesh, triangle);
        let [a, b, c] = corners;
        let plane = (b - a).cross(c - a);
        if plane == DVec3::ZERO {
            return None;
        }
        let t = (a - origin).dot(plane) / along.dot(plane);
        let met = if t.is_finite() { origin + along * t } else { a };
        let weights = weights_of(corners, nearest_point(corners, met));
        Some(at_weights(corners_of(mesh, triangle), weights).as_vec3())
    }

    /// How many times as large `triangle` is at rest; 0 where it has no area now.
    pub fn shrinks(&self, mesh: &Mesh, triangle: u32) -> f64 {
        let twice_area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length();
        let now = twice_area(self.corners(mesh, triangle));
        if now > 0.0 { twice_area(corners_of(mesh, triangle)) / now } else { 0.0 }
    }
}

/// All models of a scene that deform, as they are at one time.
#[derive(Debug, Clone, Default)]
pub struct Deformations {
    /// By model; empty where none deforms.
    all: Vec<Option<Deformed>>,
}

impl Deformations {
    /// Of `scene` with its models at these places. Only for points, if there is no need of `normals`.
    pub fn of(scene: &Scene, places: &[Transform], normals: bool) -> Self {
        if scene.models.iter().all(|model| model.mesh.shapes.is_none()) {
            return Self::default();
        }
        let models = scene.models.iter().zip(places);
        // what is not there has no samples, and is met by no ray
        let deformed = models.map(|(model, place)| {
            if place.is_visible { Deformed::of(&model.mesh, &place.shape, normals) } else { None }
        });
        Self { all: deformed.collect() }
    }

    /// Of a model, if it deforms.
    #[inline]
    pub fn of_model(&self, model: u32) -> Option<&Deformed> {
        self.all.get(model as usize)?.as_ref()
    }
}

fn at_weights([a, b, c]: [DVec3; 3], [u, v]: [f64; 2]) -> DVec3 {
    a + (b - a) * u + (c - a) * v
}

fn normal_of([a, b, c]: [DVec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}
