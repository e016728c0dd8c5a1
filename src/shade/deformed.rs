//! Deforming meshes at one time: maps points on the shape at rest to their places in the shape of that time.
//!
//! Within an exposure vertices go straight from one shape to another ([`Chord`]), and their normals with them.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::surface::{corners_of, nearest_point, weights_of};
use super::terminator::{SmoothPoint, most_lift};
use crate::animation::{Chord, Shape, Transform};
use crate::scene::on_mesh::OnMesh;
use crate::scene::{Geometry, Mesh, Model, Scene, Triangles};
pub use curved::DeformedCurved;
use curved::DeformedGeometry;

mod curved;

/// The `point` of `triangle` that is there at rest, on the curved surface that the triangle stands for in its present shape; `None` for
/// flat meshes, and geometry that is curved itself.
pub fn smooth_point(
    mesh: &Mesh,
    triangle: u32,
    point: Vec3,
    deformed: Option<&Deformed>,
) -> Option<SmoothPoint> {
    match deformed {
        None => SmoothPoint::at_rest(mesh.as_triangles()?, triangle, point),
        Some(deformed) => deformed.smooth_point(triangle, point),
    }
}

/// Vertices of a mesh in one of its shapes.
#[derive(Debug)]
struct Vertices {
    shape: Shape,
    /// Positions by vertex, object space.
    positions: Vec<[f32; 3]>,
    /// Normals by vertex, unit length or zero; empty for flat meshes, or where they are not needed.
    normals: Vec<Vec3>,
}

/// A mesh in the shapes at both ends of an exposure, or in its one shape.
#[derive(Debug, Clone)]
struct DeformedMesh {
    open: Arc<Vertices>,
    /// `None` where it has one shape.
    close: Option<Arc<Vertices>>,
    /// See [`most_lift`].
    most_lift: f32,
}

/// A mesh that deforms, at one time.
#[derive(Debug, Clone, Copy)]
pub struct Deformed<'a> {
    /// The triangles at rest.
    triangles: &'a Triangles,
    of: &'a DeformedMesh,
    chord: Chord,
}

/// A point on a deformed mesh, object space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeformedPlace {
    /// Place of the point.
    pub point: Vec3,
    /// Shading normal, on the outside; unit length, or zero where the triangle has no area.
    pub normal: Vec3,
    /// Normal of the triangle, on the outside; unit length, or zero where it has no area.
    pub geometric_normal: Vec3,
}

impl DeformedMesh {
    /// Creates `mesh` with the shapes of `chord`; `None` if it does not deform. Without `normals` the result serves for
    /// points alone. `before`: the same mesh at another time, made in the same way, of which shapes are taken that it has.
    fn new(mesh: &Mesh, chord: &Chord, normals: bool, before: Option<&Self>) -> Option<Self> {
        let Triangles { corners, shapes, .. } = mesh.as_triangles()?;
        let shapes = shapes.as_ref()?;
        let vertices = |shape: &Shape| {
            let known =
                before.into_iter().flat_map(|before| std::iter::once(&before.open).chain(&before.close));
            if let Some(known) = known.into_iter().find(|known| known.shape == *shape) {
                return Arc::clone(known);
            }
            let positions = shapes.positions(shape);
            let normals = if normals { shapes.normals(&positions, corners) } else { Vec::new() };
            Arc::new(Vertices { shape: *shape, positions, normals })
        };
        let [open, close] = &chord.ends;
        let (open, close) = (vertices(open), (!chord.is_still()).then(|| vertices(close)));
        // in between, the heights of corners above each other's planes are means of these
        let ends = || std::iter::once(&open).chain(&close).map(|end| &**end);
        let pairs = ends().flat_map(|at| ends().map(|other| (&at.positions, &other.normals)));
        let lifts = pairs.map(|(positions, normals)| most_lift(positions, normals, corners));
        let most_lift = lifts.fold(0.0, f32::max);
        Some(Self { open, close, most_lift })
    }
}

impl Deformed<'_> {
    /// What is at one place in the one shape and at another in the other.
    #[inline(always)]
    fn between(&self, of: impl Fn(&Vertices) -> Vec3) -> Vec3 {
        let open = of(&self.of.open);
        self.of.close.as_ref().map_or(open, |close| self.chord.point([open, of(close)]))
    }

    /// Corners of `triangle`, in this shape.
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        let place = |corner: u32| self.between(|all| Vec3::from_array(all.positions[corner as usize]));
        self.triangles.corners[triangle as usize].map(|corner| place(corner).as_dvec3())
    }

    /// Normals of the vertices of `triangle`, of any length; `None` for flat meshes.
    fn normals(&self, triangle: u32) -> Option<[Vec3; 3]> {
        let normal = |corner: u32| self.between(|all| all.normals[corner as usize]);
        (!self.of.open.normals.is_empty()).then(|| self.triangles.corners[triangle as usize].map(normal))
    }

    /// Place of the `point` of `triangle` that is there at rest.
    pub fn point(&self, triangle: u32, point: Vec3) -> Vec3 {
        let weights = weights_of(corners_of(self.triangles, triangle), point.as_dvec3());
        at_weights(self.corners(triangle), weights).as_vec3()
    }

    /// Place of a point, as in [`point`](Self::point), with the normals there.
    pub fn place(&self, scene: &Scene, model: &Model, triangle: u32, point: Vec3) -> DeformedPlace {
        let [u, v] = weights_of(corners_of(self.triangles, triangle), point.as_dvec3());
        let corners = self.corners(triangle);
        let geometric_normal = normal_of(corners);
        let normal = match self.normals(triangle) {
            None => geometric_normal,
            Some([a, b, c]) => {
                let mean = a.as_dvec3() * (1.0 - u - v) + b.as_dvec3() * u + c.as_dvec3() * v;
                mean.try_normalize().map_or(geometric_normal, |normal| normal.as_vec3())
            }
        };
        let normal = if model.mesh.may_bend_normals() {
            let place = OnMesh::on(model, triangle, [u as f32, v as f32]);
            place.bent_normal(scene, normal, corners.map(|corner| corner.as_vec3()))
        } else {
            normal
        };
        DeformedPlace { point: at_weights(corners, [u, v]).as_vec3(), normal, geometric_normal }
    }

    /// See [`smooth_point`].
    fn smooth_point(&self, triangle: u32, point: Vec3) -> Option<SmoothPoint> {
        let weights = weights_of(corners_of(self.triangles, triangle), point.as_dvec3());
        let corners = self.corners(triangle);
        Some(SmoothPoint {
            corners: corners.map(|corner| corner.as_vec3()),
            normals: self.normals(triangle)?,
            weights: weights.map(|weight| weight as f32),
            point: at_weights(corners, weights).as_vec3(),
        })
    }

    /// Upper bound of the length of any [lift](SmoothPoint::lift), object space.
    pub fn most_lift(&self) -> f32 {
        self.of.most_lift
    }

    /// Normal of the outside of `triangle`; unit length, or zero where it has no area.
    pub fn geometric_normal(&self, triangle: u32) -> Vec3 {
        normal_of(self.corners(triangle))
    }

    /// Side of `triangle` at rest that a normal is on: 1 for its outside, -1 for its inside.
    #[inline]
    pub fn side_at_rest(&self, triangle: u32, geometric_normal: Vec3) -> f32 {
        let [a, b, c] = corners_of(self.triangles, triangle);
        if (b - a).cross(c - a).dot(geometric_normal.as_dvec3()) < 0.0 { -1.0 } else { 1.0 }
    }

    /// Maps a `direction` in the plane of `triangle` from rest to this shape, of any length; `None` for
    /// triangles without an area.
    pub fn direction(&self, triangle: u32, direction: Vec3) -> Option<Vec3> {
        let [a, b, c] = corners_of(self.triangles, triangle);
        let (along, up, way) = (b - a, c - a, direction.as_dvec3());
        let normal = along.cross(up);
        let square = normal.length_squared();
        let (u, v) = (way.cross(up).dot(normal) / square, along.cross(way).dot(normal) / square);
        let [a, b, c] = self.corners(triangle);
        Some(((b - a) * u + (c - a) * v).as_vec3()).filter(|way| way.is_finite())
    }

    /// Intersects a line with the plane of `triangle`, and returns the nearest point of the triangle, at
    /// rest; see [`meet_exactly`](super::surface::meet_exactly).
    pub fn meet(&self, triangle: u32, [origin, along]: [DVec3; 2]) -> Option<Vec3> {
        let corners = self.corners(triangle);
        let [a, b, c] = corners;
        let plane = (b - a).cross(c - a);
        if plane == DVec3::ZERO {
            return None;
        }
        let t = (a - origin).dot(plane) / along.dot(plane);
        let met = if t.is_finite() { origin + along * t } else { a };
        let weights = weights_of(corners, nearest_point(corners, met));
        Some(at_weights(corners_of(self.triangles, triangle), weights).as_vec3())
    }

    /// Area of `triangle` at rest over its area in this shape; 0 if it has none now.
    pub fn shrinks(&self, triangle: u32) -> f64 {
        let twice_area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length();
        let now = twice_area(self.corners(triangle));
        if now > 0.0 { twice_area(corners_of(self.triangles, triangle)) / now } else { 0.0 }
    }
}

/// A model that deforms, at one time.
#[derive(Debug, Clone, Copy)]
pub enum DeformedModel<'a> {
    /// Of triangles.
    Triangles(Deformed<'a>),
    /// Of a curved geometry.
    Curved(DeformedCurved<'a>),
}

/// A model in the shapes that it has.
#[derive(Debug, Clone)]
enum InShapes {
    Triangles(DeformedMesh),
    Curved(DeformedGeometry),
}

impl InShapes {
    /// Creates `mesh` with the shapes of `chord`: see [`DeformedMesh::new`].
    fn new(mesh: &Mesh, chord: &Chord, normals: bool, before: Option<&Self>) -> Option<Self> {
        if let Geometry::Curved(curved) = &mesh.geometry {
            let before = before.and_then(|before| match before {
                Self::Curved(before) => Some(before),
                Self::Triangles(_) => None,
            });
            return DeformedGeometry::new(curved.as_ref(), chord, before).map(Self::Curved);
        }
        let before = before.and_then(|before| match before {
            Self::Triangles(before) => Some(before),
            Self::Curved(_) => None,
        });
        DeformedMesh::new(mesh, chord, normals, before).map(Self::Triangles)
    }
}

/// All models of a scene that deform, at one time.
#[derive(Debug, Clone, Default)]
pub struct Deformations {
    /// Shape of each model; empty if none deforms.
    all: Vec<Option<InShapes>>,
}

impl Deformations {
    /// Creates the shapes of `scene` with its models at these places, and at all others of the same exposure. Without `normals` they serve
    /// for points alone.
    pub fn new(scene: &Scene, places: &[Transform], normals: bool) -> Self {
        Self::after(scene, places, normals, &Self::default())
    }

    /// The same, of which shapes are taken from what was made in the same way `before`: where one exposure ends the next one begins.
    pub fn after(scene: &Scene, places: &[Transform], normals: bool, before: &Self) -> Self {
        if scene.models.iter().all(|model| !model.mesh.deforms()) {
            return Self::default();
        }
        let models = scene.models.iter().zip(places);
        // a model that is not there has no samples, and is met by no ray
        let deformed = models.enumerate().map(|(number, (model, place))| {
            let before = before.all.get(number).and_then(Option::as_ref);
            if place.is_visible { InShapes::new(&model.mesh, &place.shape, normals, before) } else { None }
        });
        Self { all: deformed.collect() }
    }

    /// Shape of a model of `scene` with this transform, if it deforms and is made of triangles.
    #[inline]
    pub fn of_model<'a>(
        &'a self,
        scene: &'a Scene,
        model: u32,
        transform: &Transform,
    ) -> Option<Deformed<'a>> {
        match self.shaped(scene, model, transform)? {
            DeformedModel::Triangles(deformed) => Some(deformed),
            DeformedModel::Curved(_) => None,
        }
    }

    /// Shape of a model of `scene` with this transform, if it deforms.
    #[inline]
    pub fn shaped<'a>(
        &'a self,
        scene: &'a Scene,
        model: u32,
        transform: &Transform,
    ) -> Option<DeformedModel<'a>> {
        match (self.all.get(model as usize)?.as_ref()?, &scene.models[model as usize].mesh.geometry) {
            (InShapes::Triangles(of), Geometry::Triangles(triangles)) => {
                Some(DeformedModel::Triangles(Deformed { triangles, of, chord: transform.shape }))
            }
            (InShapes::Curved(of), Geometry::Curved(rest)) => {
                Some(DeformedModel::Curved(of.at(rest.as_ref(), &transform.shape)))
            }
            _ => None,
        }
    }

    /// Returns true if a model that is there deforms.
    #[inline]
    pub fn has(&self, model: u32) -> bool {
        self.all.get(model as usize).is_some_and(Option::is_some)
    }
}

fn at_weights([a, b, c]: [DVec3; 3], [u, v]: [f64; 2]) -> DVec3 {
    a + (b - a) * u + (c - a) * v
}

fn normal_of([a, b, c]: [DVec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}
