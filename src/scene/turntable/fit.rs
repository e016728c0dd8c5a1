//! Finds the place of a camera that goes around a model so that it sees all of it, and as little as possible
//! beside it.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::Up;
use super::corners::Corners;

/// Vertical field of view, degrees: a long lens, as for portraits.
const FOV: f64 = 28.0;
/// Elevation of the camera above its target, degrees. More than half the field of view: the horizon is above
/// the picture.
const ELEVATION: f64 = 17.0;
/// Factor on the distance at which the model just fits into the picture.
const MARGIN: f64 = 1.08;
/// Depth of the floor below the model, in diagonals of its box: a model that has a floor of its own hides it.
const GAP: f64 = 2e-4;
/// Number of directions in which the outline of a model is measured, for the axis that the camera goes
/// around.
const DIRECTIONS: usize = 32;
/// Number of corrections of the target's height.
const CENTERINGS: u32 = 4;
/// Number of steps towards the centre of the smallest circle around that outline.
const STEPS: u32 = 2000;

/// A camera's way around a model: one turn at one height. The model's axis points up; in units of its file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Point that the camera looks at.
    pub target: DVec3,
    /// Distance from the target to the eye.
    pub distance: f64,
    /// Elevation of the eye above the target, degrees.
    pub elevation: f64,
    /// Vertical field of view, degrees.
    pub fov: f64,
    /// Height of the floor on which the model stands.
    pub floor: f64,
    /// Diagonal of the model's box.
    pub size: f64,
}

impl Fit {
    /// Fits the camera for a picture that is `aspect` times as wide as high.
    ///
    /// As the camera sees it, each corner of the model moves on a circle. The camera stands as near as
    /// possible with all of these circles inside the four planes of its picture.
    pub(in crate::scene) fn new(corners: &Corners<'_>, up: Up, aspect: f64) -> Self {
        let (low, high) = upright_bounds(corners.bounds(), up);
        let axis = axis(corners, up, (low, high));
        // for the planes above, below and beside the picture: how much of a circle's radius and height their normals take
        let ((sin, cos), tall) = (ELEVATION.to_radians().sin_cos(), (FOV * 0.5).to_radians());
        let wide = (tall.tan() * aspect).atan();
        let (steep, flat) = (ELEVATION.to_radians() + tall, ELEVATION.to_radians() - tall);
        let planes = [
            DVec2::new(flat.sin().abs(), flat.cos()),
            DVec2::new(steep.sin(), -steep.cos()),
            DVec2::new((wide.cos().powi(2) + (wide.sin() * cos).powi(2)).sqrt(), wide.sin() * sin),
        ];
        let reach = |all: [f64; 3], point: glam::Vec3A| {
            let point = upright(point.as_dvec3(), up) - axis;
            let profile = DVec2::new(DVec2::new(point.x, point.z).length(), point.y);
            std::array::from_fn(|i| all[i].max(planes[i].dot(profile)))
        };
        let farthest = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| a[i].max(b[i]));
        let [above, below, beside] = corners.fold([f64::NEG_INFINITY; 3], reach, farthest);
        let distance = |height: f64| {
            let upright = (above - planes[0].y * height).max(below - planes[1].y * height) / tall.sin();
            MARGIN * upright.max((beside - planes[2].y * height) / wide.sin())
        };
        // as much room above as below, first of the planes, then in the picture
        let mut height = (above - below) / (planes[0].y - planes[1].y);
        for _ in 0..CENTERINGS {
            let (target, distance) = (axis + DVec3::Y * height, distance(height));
            // the tangent below and above the middle, where a circle's nearest and farthest point are seen
            let seen = |all: [f64; 2], point: glam::Vec3A| {
                let point = upright(point.as_dvec3(), up) - target;
                let (radius, y) = (DVec2::new(point.x, point.z).length(), point.y);
                let tangent = |out: f64| (y * cos - out * sin) / (distance - out * cos - y * sin);
                let [near, far] = [tangent(radius), tangent(-radius)];
                [all[0].min(near.min(far)), all[1].max(near.max(far))]
            };
            let joined = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
            let [lowest, highest] = corners.fold([f64::INFINITY, f64::NEG_INFINITY], seen, joined);
            height += 0.5 * (lowest + highest) * distance / cos;
        }
        let size = (high - low).length();
        Self {
            target: axis.with_y(axis.y + height),
            distance: distance(height),
            elevation: ELEVATION,
            fov: FOV,
            floor: low.y - GAP * size,
            size,
        }
    }
}

/// Turns a point or direction of a file in which the axis `up` points up, so that Y points up.
fn upright(point: DVec3, up: Up) -> DVec3 {
    match up {
        Up::Y => point,
        Up::Z => DVec3::new(point.x, point.z, -point.y),
    }
}

fn upright_bounds((low, high): (DVec3, DVec3), up: Up) -> (DVec3, DVec3) {
    let (a, b) = (upright(low, up), upright(high, up));
    (a.min(b), a.max(b))
}

/// Finds the middle of the smallest circle around the model, seen from above; at the height of its box's
/// middle.
fn axis(corners: &Corners<'_>, up: Up, (low, high): (DVec3, DVec3)) -> DVec3 {
    let middle = (low + high) * 0.5;
    let directions: [DVec2; DIRECTIONS] =
        std::array::from_fn(|i| DVec2::from_angle(TAU * i as f64 / DIRECTIONS as f64));
    let place = |point: glam::Vec3A| {
        let point = upright(point.as_dvec3(), up) - middle;
        DVec2::new(point.x, point.z)
    };
    // by place where two are as far, so that threads do not matter
    let farther = |direction: DVec2, a: DVec2, b: DVec2| {
        let key = |at: DVec2| (direction.dot(at), at.x, at.y);
        if key(b) > key(a) { b } else { a }
    };
    let joined = |a: [DVec2; DIRECTIONS], b: [DVec2; DIRECTIONS]| {
        std::array::from_fn(|i| farther(directions[i], a[i], b[i]))
    };
    let nothing = directions.map(|direction| direction * -f64::MAX.sqrt());
    let outline = corners.fold(nothing, |all, point| joined(all, [place(point); DIRECTIONS]), joined);
    // M. Bădoiu and K. L. Clarkson, "Smaller Core-Sets for Balls" (2003): towards what is farthest, less and less
    let toward = |center: DVec2, step: u32| {
        let far = |a: DVec2, b: DVec2| if b.distance(center) > a.distance(center) { b } else { a };
        center + (outline.into_iter().fold(center, far) - center) / f64::from(step + 1)
    };
    let center = (1..STEPS).fold(DVec2::ZERO, toward);
    middle + DVec3::new(center.x, 0.0, center.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::on_orbit;

    /// Largest distance of the corners from the middle of the picture in a whole turn: 1 is the picture's
    /// edge.
    fn reach(points: &[[f32; 3]], up: Up, aspect: f64) -> DVec2 {
        let triangles: Vec<[u32; 3]> = (0..points.len() as u32 - 2).map(|i| [i, i + 1, i + 2]).collect();
        let fit = Fit::new(&Corners { positions: points, triangles: &triangles }, up, aspect);
        let tangent = (fit.fov * 0.5).to_radians().tan();
        let turns = (0..120).map(|i| DVec3::new(f64::from(i) * 3.0, fit.elevation, fit.distance));
        let seen = turns.flat_map(|turn| {
            let eye = on_orbit(fit.target, turn);
            let forward = (fit.target - eye).normalize();
            let right = forward.cross(DVec3::Y).normalize();
            let place = move |point: &[f32; 3]| {
                let to = upright(glam::Vec3::from(*point).as_dvec3(), up) - eye;
                let at = DVec2::new(to.dot(right) / aspect, to.dot(right.cross(forward)));
                at / (tangent * to.dot(forward))
            };
            points.iter().map(place)
        });
        let (low, high) = seen.fold((DVec2::MAX, DVec2::MIN), |all, at| (all.0.min(at), all.1.max(at)));
        let is_centered = (low + high).abs().max_element() < 0.05;
        assert!(is_centered, "from {low} to {high}");
        low.abs().max(high.abs())
    }

    #[test]
    fn the_model_fills_the_picture_and_no_more_whatever_its_shape() {
        let block = |size: [f32; 3]| -> Vec<[f32; 3]> {
            (0..8).map(|i| std::array::from_fn(|axis| size[axis] * (i >> axis & 1) as f32 + 7.0)).collect()
        };
        let wedge = vec![[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [4.5, 3.0, 7.8]];
        for points in [block([1.0, 10.0, 1.0]), block([10.0, 1.0, 2.0]), block([3.0; 3]), wedge] {
            for (aspect, up) in [(16.0 / 9.0, Up::Y), (16.0 / 9.0, Up::Z), (0.5, Up::Y)] {
                let reach = reach(&points, up, aspect).max_element();
                assert!(reach < 1.0 && reach > 0.85, "{points:?} {aspect}: {reach}");
            }
        }
    }
}
