//! Ways of rays from the eye over flat mirrors, and where the eye sees what lies at their ends.
//!
//! *Flat* are triangles whose corners have the normal of their plane, and that no picture bends. What lets rays pass straight through may
//! be curved: it turns nothing. All other ways are [bent](Way::BENT).

use glam::Vec3;

use crate::exposure::MIDDLE_TICK;
use crate::frame::shot::frame_view::FrameView;
use crate::scene::RayKind;
use crate::shade::Surface;
use crate::shade::surface::{geometric_normal_of, off_surface};
use crate::trace::Hit;

/// Largest angle, in radians, between planes that count as one: it moves an image by twice as much of its distance, a fiftieth of a cell of
/// a picture 1000 cells high.
const ONE_PLANE: f32 = 1e-5;

/// Largest distance of a plane from another that counts as the same one, and of what is met at the end of a way from the sample that it
/// leads to, as a share of the distance from the eye: so much are places rounded.
pub const ONE_PLACE: f32 = 1e-5;

/// Mirrors, and what lets rays pass, on a way; behind more of them nothing is kept.
const MOST_LINKS: usize = 8;

/// Way of a ray from the eye over flat mirrors, as [`Ways`] know it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Way(u32);

impl Way {
    /// Straight from the eye.
    pub const DIRECT: Self = Self(u32::MAX);
    /// Anything that is not kept.
    pub const BENT: Self = Self(u32::MAX - 1);
}

/// A surface on the way of a ray.
#[derive(Debug, Clone, Copy)]
pub struct Link {
    /// A point of its plane, world space.
    point: Vec3,
    /// Normal of its plane on the side from which the ray came.
    normal: Vec3,
    model: u32,
    material: u16,
    /// True if the ray was mirrored there, and not let pass.
    is_mirror: bool,
    /// Kind of the ray that came to it.
    pub ray_kind: RayKind,
    /// The way to it.
    before: Way,
}

impl Link {
    /// The mirror image of a point, if it is a mirror.
    pub fn image(&self, point: Vec3) -> Vec3 {
        if self.is_mirror { point - 2.0 * (point - self.point).dot(self.normal) * self.normal } else { point }
    }

    /// Begin of the ray that goes on from it, after one from `origin` towards an image at `origin + way` met `hit`; none if that is not the
    /// same mirror in the same plane.
    pub fn beyond(&self, frame: &FrameView, (origin, way): (Vec3, Vec3), hit: Hit) -> Option<Vec3> {
        let mesh = &frame.scene.models[hit.model as usize].mesh;
        // the image lies behind a mirror, and what is seen behind what lets rays pass
        if hit.model != self.model || mesh.material_of[hit.triangle as usize] != self.material || hit.t >= 1.0
        {
            return None;
        }
        let point = origin + hit.t * way;
        let normal = plane_of(frame, hit.model, hit.triangle, self.is_mirror)?;
        let normal = if normal.dot(way) > 0.0 { -normal } else { normal };
        if !self.is_mirror {
            return Some(off_surface(point, -normal));
        }
        let off = (point - self.point).dot(self.normal).abs();
        let is_same = normal.cross(self.normal).length() <= ONE_PLANE
            && normal.dot(self.normal) > 0.0
            && off <= ONE_PLACE * way.length() + rounding(point);
        is_same.then(|| off_surface(point, normal))
    }

    /// The mirror image of a direction, if it is a mirror.
    fn turned(&self, direction: Vec3) -> Vec3 {
        if self.is_mirror { direction - 2.0 * direction.dot(self.normal) * self.normal } else { direction }
    }
}

/// The surfaces on a way in the order in which a ray meets them.
#[derive(Debug, Clone, Copy)]
pub struct Links {
    all: [Link; MOST_LINKS],
    count: usize,
}

impl Links {
    pub fn as_slice(&self) -> &[Link] {
        &self.all[..self.count]
    }

    /// Where the eye sees what is at `point`.
    pub fn image(&self, point: Vec3) -> Vec3 {
        self.as_slice().iter().rev().fold(point, |point, link| link.image(point))
    }

    /// What the eye sees at an `image`.
    pub fn original(&self, image: Vec3) -> Vec3 {
        self.as_slice().iter().fold(image, |point, link| link.image(point))
    }

    /// Direction in which the eye sees one.
    pub fn image_of_direction(&self, direction: Vec3) -> Vec3 {
        self.as_slice().iter().rev().fold(direction, |direction, link| link.turned(direction))
    }
}

/// The ways of the rays of a tile. Each is the last of its links, which knows the way to it.
#[derive(Debug, Default)]
pub struct Ways {
    all: Vec<Link>,
}

impl Ways {
    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.all.clear();
    }

    /// The way on from `surface`, which is `triangle` of `model` and was met by a ray of that kind on the way `before`: over a mirror, or
    /// straight through.
    pub fn beyond(
        &mut self,
        frame: &FrameView,
        (before, ray_kind): (Way, RayKind),
        (surface, model, triangle): (&Surface, u32, u32),
        is_mirror: bool,
    ) -> Way {
        if frame.mirrored.is_none() || before == Way::BENT || self.count(before) == MOST_LINKS {
            return Way::BENT;
        }
        let plane = plane_of(frame, model, triangle, is_mirror);
        let Some(normal) = plane.filter(|_| !is_mirror || is_flat_there(surface)) else { return Way::BENT };
        let normal = if normal.dot(surface.geometric_normal) < 0.0 { -normal } else { normal };
        self.all.push(Link {
            point: surface.point,
            normal,
            model,
            material: surface.material,
            is_mirror,
            ray_kind,
            before,
        });
        Way(self.all.len() as u32 - 1)
    }

    fn count(&self, way: Way) -> usize {
        let mut count = 0;
        let mut at = way;
        while at != Way::DIRECT {
            at = self.all[at.0 as usize].before;
            count += 1;
        }
        count
    }

    /// The surfaces on a way that is not bent.
    pub fn links(&self, way: Way) -> Links {
        let count = self.count(way);
        let nothing = Link {
            point: Vec3::ZERO,
            normal: Vec3::ZERO,
            model: 0,
            material: 0,
            is_mirror: false,
            ray_kind: RayKind::Camera,
            before: Way::DIRECT,
        };
        let mut links = Links { all: [nothing; MOST_LINKS], count };
        let mut at = way;
        for place in links.all[..count].iter_mut().rev() {
            *place = self.all[at.0 as usize];
            at = place.before;
        }
        links
    }
}

/// Normal of the plane of a triangle, world space; none of curved geometry, and for a mirror none where the surface is not flat.
fn plane_of(frame: &FrameView, model: u32, triangle: u32, is_mirror: bool) -> Option<Vec3> {
    let mesh = &frame.scene.models[model as usize].mesh;
    let triangles = mesh.as_triangles()?;
    let in_object = geometric_normal_of(mesh, triangle, [0.0; 2]);
    if is_mirror {
        if mesh.deforms() || frame.is_bent(model, triangle) {
            return None;
        }
        if !triangles.normals.is_empty() {
            let corners = triangles.corners[triangle as usize];
            let normals = corners.map(|corner| triangles.normals[corner as usize].normalize_or_zero());
            if normals.iter().any(|normal| normal.cross(in_object).length() > ONE_PLANE) {
                return None;
            }
        }
    }
    frame.place(model, MIDDLE_TICK).geometric_normal(triangle, in_object).try_normalize()
}

/// Returns true if a mirror has the normal of its plane where it was met, but for the rounding of kept normals.
fn is_flat_there(surface: &Surface) -> bool {
    const ROUNDED: f32 = 1e-4;
    (surface.normal - surface.geometric_normal).length() <= ROUNDED
}

/// Room for the rounding of coordinates.
pub fn rounding(point: Vec3) -> f32 {
    4.0 * f32::EPSILON * point.abs().max_element()
}
