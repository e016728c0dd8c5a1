//! One piece of a curve: the hull of two spheres, in double floats.
//!
//! Its surface is a part of each sphere and, between the circles in which it touches them, a part of a cone. All normals along a line of that
//! cone are the same, and make the angle with the axis whose cosine is `slope`. So the whole surface has one chart of *weights*: the first is
//! from 0 to 1 on the cone, by the way along its lines, from -1 (the pole) to 0 on the sphere of the beginning, and from 1 to 2 on that of the
//! end, by the angle to the axis, so that hulls of other radii stretch it evenly; the second is the direction about the axis ([`diamond`]).

use std::f64::consts::PI;

use glam::DVec3;

/// Hull of a sphere around the origin and another one.
#[derive(Debug, Clone, Copy)]
pub struct Hull {
    /// Direction to the centre of the other sphere, unit length.
    axis: DVec3,
    /// Distance of the centres; above 0.
    length: f64,
    /// Radii of both; not below 0.
    radii: [f64; 2],
    /// Component of the cone's normals along the axis, and that across it.
    slope: f64,
    across: f64,
}

/// Room of the borders between the parts of the surface, in weights: no ray passes between two of them.
const RIM: f64 = 1e-9;

/// Least sine of half the cone's angle to its axis for which there is a cone between the spheres: with less, one holds the other.
const LEAST_ACROSS: f64 = 1e-9;

impl Hull {
    /// Hull of spheres around the origin and around `end`, which is elsewhere.
    pub fn new(end: DVec3, radii: [f64; 2]) -> Self {
        let length = end.length();
        let axis = if length > 0.0 { end / length } else { DVec3::Y };
        let slope = if length > 0.0 { ((radii[0] - radii[1]) / length).clamp(-1.0, 1.0) } else { 1.0 };
        Self { axis, length, radii, slope, across: (1.0 - slope * slope).sqrt() }
    }

    /// Parameter at which the line from `origin` along `direction`, of unit length, enters the hull, before or behind its origin.
    ///
    /// Computed from the point of the line that is nearest to the middle, so that a distance costs no digits.
    #[inline]
    pub fn enter(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let Self { axis, length, radii: [first, second], slope, across } = *self;
        let from_middle = origin - axis * (0.5 * length);
        let start = -from_middle.dot(direction);
        let beside = from_middle + direction * start;
        let reach = 0.5 * length + first.max(second);
        if beside.length_squared() > reach * reach {
            return None;
        }
        let near = origin + direction * start;
        let (height, rise, along) = (near.dot(axis), direction.dot(axis), near.dot(direction));
        let mut least = f64::INFINITY;
        if across > LEAST_ACROSS {
            // across² (|P|² - z²) = (r - slope z)², where z is the height of P
            let rest = first - slope * height;
            let square = across * across - rise * rise;
            let half = across * across * (along - height * rise) + slope * rise * rest;
            let constant = across * across * (near.length_squared() - height * height) - rest * rest;
            let discriminant = half * half - square * constant;
            if discriminant < 0.0 {
                // both spheres are within the cone
                return None;
            }
            let sum = -(half + discriminant.sqrt().copysign(half));
            for t in [sum / square, constant / sum] {
                let z = height + t * rise;
                let weight = (z - first * slope) / (length * across * across);
                let radius = (first - slope * z) / across;
                let outwards = across * (along + t - z * rise) + slope * rise * radius;
                if (-RIM..=1.0 + RIM).contains(&weight) && radius >= 0.0 && outwards < 0.0 {
                    least = least.min(t);
                }
            }
        }
        let mut sphere = |near: DVec3, radius: f64, is_on: &dyn Fn(f64) -> bool| {
            let half = near.dot(direction);
            let discriminant = half * half - (near.length_squared() - radius * radius);
            if radius > 0.0 && discriminant >= 0.0 {
                let t = -half - discriminant.sqrt();
                if is_on((near.dot(axis) + t * rise) / radius) {
                    least = least.min(t);
                }
            }
        };
        sphere(near, first, &|up| up <= slope + RIM);
        sphere(near - axis * length, second, &|up| up >= slope - RIM);
        least.is_finite().then_some(start + least)
    }

    /// Weights of a point on the surface; of a point beside it those of one near it.
    pub fn weights(&self, point: DVec3) -> [f64; 2] {
        let Self { axis, length, radii: [first, _], slope, across } = *self;
        let height = point.dot(axis);
        let [x, y] = self.frame().map(|axis| axis.dot(point));
        let radius = (x * x + y * y).sqrt();
        let around = diamond(x, y);
        let along = (height - first * slope) * across - (radius - first * across) * slope;
        let way = length * across;
        let weight = if along < 0.0 || slope >= 1.0 {
            self.weight_at(radius.atan2(height)).min(0.0)
        } else if along > way {
            self.weight_at(radius.atan2(height - length)).max(1.0)
        } else {
            (along / way).clamp(0.0, 1.0)
        };
        [weight, around]
    }

    /// Weights of a place at which the normal is this one, of unit length. All places of the cone along one of its lines have one.
    pub fn weights_of_normal(&self, normal: DVec3) -> [f64; 2] {
        let [x, y] = self.frame().map(|axis| axis.dot(normal));
        [self.weight_at((x * x + y * y).sqrt().atan2(normal.dot(self.axis))), diamond(x, y)]
    }

    /// First weight of places of the spheres whose normals make this angle with the axis.
    fn weight_at(&self, angle: f64) -> f64 {
        let beyond = angle - self.rim();
        if beyond > 0.0 {
            -(beyond / (PI - self.rim()).max(f64::MIN_POSITIVE)).min(1.0)
        } else {
            1.0 + (-beyond / self.rim().max(f64::MIN_POSITIVE)).min(1.0)
        }
    }

    /// Angle of the cone's normals to the axis.
    fn rim(&self) -> f64 {
        self.across.atan2(self.slope)
    }

    /// Normal, outwards, of unit length, at these weights.
    pub fn normal(&self, [weight, around]: [f64; 2]) -> DVec3 {
        let Self { axis, slope, across, .. } = *self;
        let (aside, up) = if weight < 0.0 {
            (self.rim() - weight.max(-1.0) * (PI - self.rim())).sin_cos()
        } else if weight > 1.0 {
            (self.rim() - (weight - 1.0).min(1.0) * self.rim()).sin_cos()
        } else {
            (across, slope)
        };
        let [x, y] = self.frame();
        let (sin, cos) = from_diamond(around);
        (axis * up + (x * cos + y * sin) * aside).normalize_or(axis)
    }

    /// Point of the surface at these weights.
    pub fn point(&self, weights: [f64; 2]) -> DVec3 {
        let share = weights[0].clamp(0.0, 1.0);
        let [first, second] = self.radii;
        self.axis * (self.length * share) + self.normal(weights) * (first + (second - first) * share)
    }

    /// Point below that at these weights, by a share of the radius there.
    pub fn inside(&self, weights: [f64; 2], depth: f64) -> DVec3 {
        let share = weights[0].clamp(0.0, 1.0);
        let [first, second] = self.radii;
        self.point(weights) - self.normal(weights) * (depth * (first + (second - first) * share))
    }

    /// Distance of a point from the surface: below 0 within the hull.
    pub fn beyond(&self, point: DVec3) -> f64 {
        let [weight, _] = self.weights(point);
        let share = weight.clamp(0.0, 1.0);
        let [first, second] = self.radii;
        if weight > 0.0 && weight < 1.0 {
            let height = point.dot(self.axis);
            let radius = (point.length_squared() - height * height).max(0.0).sqrt();
            return height * self.slope + radius * self.across - first;
        }
        (point - self.axis * (self.length * share)).length() - (first + (second - first) * share)
    }

    /// Direction from the beginning to the end, unit length.
    pub fn axis(&self) -> DVec3 {
        self.axis
    }

    /// The greater of the radii.
    pub fn most_radius(&self) -> f64 {
        self.radii[0].max(self.radii[1])
    }

    /// Two directions across the axis and each other (T. Duff and others, "Building an Orthonormal Basis, Revisited", 2017).
    pub fn frame(&self) -> [DVec3; 2] {
        let DVec3 { x, y, z } = self.axis;
        let sign = 1.0_f64.copysign(z);
        let a = -1.0 / (sign + z);
        let b = x * y * a;
        [DVec3::new(1.0 + sign * x * x * a, sign * b, -sign * x), DVec3::new(b, sign + y * y * a, -y)]
    }
}

/// Direction of (x, y) as a number from -2 to 2: its position along a square that stands on its corner.
fn diamond(x: f64, y: f64) -> f64 {
    let sum = x.abs() + y.abs();
    if sum > 0.0 { (1.0 - x / sum).copysign(y) } else { 0.0 }
}

/// Sine and cosine of a [`diamond`].
fn from_diamond(angle: f64) -> (f64, f64) {
    let x = 1.0 - angle.abs();
    let y = (1.0 - x.abs()).copysign(angle);
    let length = (x * x + y * y).sqrt();
    (y / length, x / length)
}
