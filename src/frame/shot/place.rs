//! Places and shapes of models: the one way from object space, where samples are kept, to world space.

use glam::Vec3;

use crate::animation::Transform;
use crate::frame::grid::bits::set_bits;
use crate::geometry::Curved;
use crate::lanes::{Mask, Vec3x8};
use crate::scene::{Mesh, Model, Scene, Triangles};
use crate::shade::deformed::{Deformations, Deformed, DeformedPlace, smooth_point};
use crate::shade::horizon::Horizon;
use crate::shade::surface::{corners_of, meet_exactly, off_surface};

/// Place and shape of a model at one time. The object space of a model that deforms is that of its shape at
/// rest: a point on one of its triangles goes to the point with the same weights of the corners in the shape
/// of that time.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    transform: &'a Transform,
    deformed: Option<(Deformed<'a>, &'a Model)>,
    scene: &'a Scene,
}

impl<'a> Place<'a> {
    /// Place of `model` by this `transform`, with its shape.
    #[inline]
    pub fn of(scene: &'a Scene, transform: &'a Transform, shapes: &'a Deformations, model: u32) -> Self {
        let deformed = shapes.of_model(scene, model, transform);
        let deformed = deformed.map(|deformed| (deformed, &scene.models[model as usize]));
        Self { transform, deformed, scene }
    }

    /// Transforms a point of a triangle, object to world. `triangle` is only called where the model deforms:
    /// elsewhere its number need not be looked up.
    #[inline(always)]
    pub fn point(&self, triangle: impl FnOnce() -> u32, point: Vec3) -> Vec3 {
        match self.deformed {
            None => self.transform.point(point),
            Some((deformed, _)) => self.transform.point(deformed.point(triangle(), point)),
        }
    }

    /// Transforms a point of `triangle` and the normals there, for shading and of the triangle, on either
    /// side: object to world. Normals have unit length; that of a deformed triangle without an area is zero.
    #[inline]
    pub fn surface(&self, triangle: u32, [point, normal, geometric_normal]: [Vec3; 3]) -> [Vec3; 3] {
        let transform = self.transform;
        let Some((deformed, model)) = self.deformed else {
            return [transform.point(point), transform.normal(normal), transform.normal(geometric_normal)];
        };
        let side = deformed.side_at_rest(triangle, geometric_normal);
        let DeformedPlace { point, normal, geometric_normal } =
            deformed.place(self.scene, model, triangle, point);
        let [normal, geometric_normal] = [normal, geometric_normal].map(|all| transform.normal(all * side));
        [transform.point(point), normal, geometric_normal]
    }

    /// Transforms the normal of `triangle`, on either side: object to world, of any length; zero if the
    /// triangle is deformed and has no area.
    #[inline]
    pub fn geometric_normal(&self, triangle: u32, geometric_normal: Vec3) -> Vec3 {
        match self.deformed {
            None => self.transform.geometric_normal(geometric_normal),
            Some((deformed, _)) => {
                let side = deformed.side_at_rest(triangle, geometric_normal);
                self.transform.geometric_normal(deformed.geometric_normal(triangle) * side)
            }
        }
    }

    /// The curved surface that `triangle` of `mesh`, the model's, stands for at a point (object space, at rest), on the side on
    /// which `side` is 1, its outside, or -1; `None` where it stands for itself, for want of usable normals. A normal map may bend it.
    pub fn horizon(&self, mesh: &Mesh, triangle: u32, point: Vec3, side: f32) -> Option<Horizon> {
        let deformed = self.deformed.as_ref().map(|(deformed, _)| deformed);
        let smooth = smooth_point(mesh, triangle, point, deformed)?;
        let normal = smooth.normal().try_normalize()? * side;
        let [normal, lift] = [self.transform.normal(normal), self.transform.direction(smooth.lift(side))];
        Some(Horizon { normal, lift, is_bent: true, is_fibre: false })
    }

    /// A fibre at a point (object space) of a curved `primitive`: rays start within it, from where they leave the curve without meeting it.
    pub fn fibre(&self, curved: &dyn Curved, primitive: u32, point: Vec3) -> Option<Horizon> {
        let weights = curved.weights(primitive, point);
        let inside = curved.inside(primitive, weights)?;
        let normal = self.transform.normal(curved.normal(primitive, weights));
        let lift = self.transform.point(inside) - off_surface(self.transform.point(point), normal);
        Some(Horizon { normal, lift, is_bent: false, is_fibre: true })
    }

    /// Upper bound of the length of the way to the curved surface from any point, world space; `at_rest` is that of the model's mesh
    /// in object space.
    pub fn most_lift(&self, at_rest: f32) -> f32 {
        self.deformed.map_or(at_rest, |(deformed, _)| deformed.most_lift()) * self.transform.most_stretch()
    }

    /// [`point`](Self::point) for those of eight points that are `of_model`; `triangle` gives that of a lane.
    #[inline(always)]
    pub fn points(&self, of_model: Mask, triangle: impl Fn(usize) -> u32, points: &mut Vec3x8) {
        if self.deformed.is_none() {
            *points = of_model.select3(self.transform.points(*points), *points);
            return;
        }
        for lane in set_bits(of_model.bits()) {
            points.set_lane(lane, self.point(|| triangle(lane), points.lane(lane)));
        }
    }

    /// [`surface`](Self::surface) for those of eight surfaces that are `of_model`.
    #[inline(always)]
    pub fn surfaces(&self, of_model: Mask, triangle: impl Fn(usize) -> u32, surfaces: [&mut Vec3x8; 3]) {
        let [point, normal, geometric_normal] = surfaces;
        if self.deformed.is_none() {
            let transform = self.transform;
            *point = of_model.select3(transform.points(*point), *point);
            *normal = of_model.select3(transform.normals(*normal), *normal);
            *geometric_normal = of_model.select3(transform.normals(*geometric_normal), *geometric_normal);
            return;
        }
        for lane in set_bits(of_model.bits()) {
            let object = [&*point, &*normal, &*geometric_normal].map(|all| all.lane(lane));
            let world = self.surface(triangle(lane), object);
            point.set_lane(lane, world[0]);
            normal.set_lane(lane, world[1]);
            geometric_normal.set_lane(lane, world[2]);
        }
    }

    /// [`geometric_normal`](Self::geometric_normal) for those of eight normals that are `of_model`.
    #[inline(always)]
    pub fn geometric_normals(&self, of_model: Mask, triangle: impl Fn(usize) -> u32, normals: &mut Vec3x8) {
        if self.deformed.is_none() {
            *normals = of_model.select3(self.transform.geometric_normals(*normals), *normals);
            return;
        }
        for lane in set_bits(of_model.bits()) {
            normals.set_lane(lane, self.geometric_normal(triangle(lane), normals.lane(lane)));
        }
    }

    /// Transforms a direction in the plane of `triangle`, object to world, of any length.
    pub fn direction(&self, triangle: u32, direction: Vec3) -> Vec3 {
        let deformed = self.deformed.and_then(|(deformed, _)| deformed.direction(triangle, direction));
        self.transform.direction(deformed.unwrap_or(direction))
    }

    /// Intersects a ray with a primitive: see [`meet_exactly`]. Returns a point in object space, at rest.
    pub fn meet_exactly(&self, primitive: (&Mesh, u32), ray: (Vec3, Vec3), about: Vec3) -> Option<Vec3> {
        match self.deformed {
            None => meet_exactly(self.transform, primitive, ray, about),
            Some((deformed, _)) => deformed.meet(primitive.1, self.transform.line_to_object(ray)),
        }
    }

    /// Corners of one of the model's `triangles`: world space.
    pub fn corners(&self, triangles: &Triangles, triangle: u32) -> [Vec3; 3] {
        let corners = match self.deformed {
            None => corners_of(triangles, triangle),
            Some((deformed, _)) => deformed.corners(triangle),
        };
        corners.map(|corner| self.transform.point(corner.as_vec3()))
    }
}
