//! Quadrics of revolution and planes: their intersections with rays, and their surfaces there.
//!
//! All is computed in double floats, in a space of the quadric's own, where it is about as large as 1 and stands
//! around the Y axis: its [side](Piece) is x² + z² = A y² + B y + C between two heights, and disks close it. An
//! affine map leads from there to object space. Ellipsoids and elliptical cylinders are spheres and cylinders
//! under such maps.
//!
//! *Weights*. Each kind of piece has a [chart](Kind) that maps two numbers to a point on it without a loss: no
//! chart has a region where single floats are coarse.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec3};

use super::Bounds;
use super::curved::{Curved, FOUR, Meeting, Ray};
use piece::{Kind, Piece};

mod four;
mod piece;

/// Solid or surface of a quadric, about the Y axis of its object. All but the sphere stand on y = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum QuadricShape {
    /// Ellipsoid around the origin, with a radius along each axis.
    Ellipsoid {
        /// Radii along x, y and z.
        radii: DVec3,
    },
    /// A tube.
    Cylinder {
        /// Radius of the tube.
        radius: f64,
        /// Height of its upper rim.
        height: f64,
    },
    /// A cone, or a part of one.
    Cone {
        /// Radius at y = 0.
        radius: f64,
        /// Radius at the upper end; 0 for a tip. One of the two is above 0.
        top: f64,
        /// Height of the upper end.
        height: f64,
    },
    /// A bowl whose lowest point is the origin.
    Paraboloid {
        /// Radius of the rim.
        radius: f64,
        /// Height of the rim.
        height: f64,
    },
    /// Hyperboloid of one sheet: a tube with a waist.
    OneSheet {
        /// Radius of both rims.
        radius: f64,
        /// Radius half way up; above 0, less than `radius`.
        waist: f64,
        /// Height of the upper rim.
        height: f64,
    },
    /// Hyperboloid of two sheets: two bowls, one upside down.
    TwoSheets {
        /// Radius of both rims.
        radius: f64,
        /// Distance between the bowls; above 0, less than `height`.
        gap: f64,
        /// Height of the upper rim.
        height: f64,
    },
    /// Plane y = 0, around `center` as far as `reach`.
    Plane {
        /// Coordinates x and z of the centre.
        center: [f64; 2],
        /// Radius up to which it is drawn.
        reach: f64,
    },
}

impl QuadricShape {
    /// Name of the shape in shot files; spheres are ellipsoids.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ellipsoid { .. } => "ellipsoid",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Paraboloid { .. } => "paraboloid",
            Self::OneSheet { .. } | Self::TwoSheets { .. } => "hyperboloid",
            Self::Plane { .. } => "plane",
        }
    }
}

/// A quadric in object space.
#[derive(Debug, Clone, PartialEq)]
pub struct Quadric {
    name: &'static str,
    pieces: Vec<Piece>,
    /// Map from the quadric's own space to object space.
    place: DAffine3,
    /// Map from object space to the quadric's own space.
    inverse: DAffine3,
    /// Map from object space to the one in which a plane's texture coordinates are x and -z.
    to_texture: DAffine3,
    is_endless: bool,
}

/// Room of a box for rounding to single floats, as a share of a coordinate.
const BOX_ROOM: f64 = 2e-7;

impl Quadric {
    /// Creates `shape` in its object's space; `is_open`: without the disks that close it.
    pub fn new(shape: QuadricShape, is_open: bool) -> Self {
        let (sides, place) = own_space(shape);
        let mut pieces = sides;
        let is_endless = matches!(shape, QuadricShape::Plane { .. });
        if !is_open && !is_endless {
            pieces.extend(caps(&pieces));
        }
        let (inverse, to_texture) = (place.inverse(), DAffine3::IDENTITY);
        Self { name: shape.name(), pieces, place, inverse, to_texture, is_endless }
    }

    /// Transforms the quadric by `map`, which has an inverse.
    pub fn placed(&self, map: DAffine3) -> Self {
        let place = map * self.place;
        let to_texture = self.to_texture * map.inverse();
        Self { pieces: self.pieces.clone(), place, inverse: place.inverse(), to_texture, ..*self }
    }

    /// Piece number `number`, or the last one if there is none: a wrong number shows, and is no fault.
    #[inline]
    fn piece(&self, number: u32) -> &Piece {
        const NOTHING: &Piece = &Piece { kind: Kind::Ball, profile: [0.0; 3], range: [0.0; 2] };
        self.pieces.get(number as usize).or(self.pieces.last()).unwrap_or(NOTHING)
    }
}

impl Curved for Quadric {
    fn name(&self) -> &'static str {
        self.name
    }

    fn kind(&self) -> &'static str {
        "quadrics"
    }

    fn count(&self) -> u32 {
        self.pieces.len() as u32
    }

    fn bounds(&self, piece: u32) -> Bounds {
        let piece = self.piece(piece);
        let [x, y, z] = [self.place.matrix3.x_axis, self.place.matrix3.y_axis, self.place.matrix3.z_axis];
        let mut bounds = Bounds::EMPTY;
        let mut add = |center: DVec3, reach: DVec3| {
            let room = (center.abs() + reach) * BOX_ROOM;
            bounds = bounds.with((center - reach - room).as_vec3()).with((center + reach + room).as_vec3());
        };
        if piece.kind == Kind::Ball {
            add(self.place.translation, (x * x + y * y + z * z).map(f64::sqrt));
        } else {
            let around = (x * x + z * z).map(f64::sqrt);
            for (height, radius) in piece.circles() {
                add(self.place.transform_point3(DVec3::Y * height), around * radius);
            }
        }
        bounds
    }

    fn meet_four(&self, piece: u32, rays: &[Ray; FOUR]) -> (u8, [Meeting; FOUR]) {
        four::meet(self.piece(piece), &self.inverse, rays)
    }

    fn meet_line(&self, piece: u32, origin: DVec3, direction: DVec3, about: Vec3) -> Vec3 {
        let piece = self.piece(piece);
        let [origin, about] = [origin, about.as_dvec3()].map(|point| self.inverse.transform_point3(point));
        let direction = self.inverse.transform_vector3(direction);
        let expected = (about - origin).dot(direction) / direction.dot(direction);
        let places = four::places_of(piece, origin, direction).into_iter().filter(|t| t.is_finite());
        let nearest = places.min_by(|a, b| (a - expected).abs().total_cmp(&(b - expected).abs()));
        let met = nearest.map_or(about, |t| origin + direction * t);
        self.place.transform_point3(piece.point(four::weights_of(piece, met))).as_vec3()
    }

    fn point(&self, piece: u32, weights: [f32; 2]) -> Vec3 {
        self.place.transform_point3(self.piece(piece).point(weights.map(f64::from))).as_vec3()
    }

    fn weights(&self, piece: u32, point: Vec3) -> [f32; 2] {
        let own = self.inverse.transform_point3(point.as_dvec3());
        four::weights_of(self.piece(piece), own).map(|weight| weight as f32)
    }

    /// The least of three: the distance to the point with its weights, which on a steep side is far above or
    /// below; the distances along the axes, which are small where the piece is flat; and a first-order estimate,
    /// which is right close to the piece.
    fn distance(&self, piece: u32, point: Vec3) -> f64 {
        let piece = self.piece(piece);
        let own = self.inverse.transform_point3(point.as_dvec3());
        let to_place = self.place.transform_vector3(piece.point(four::weights_of(piece, own)) - own).length();
        let along = |axis: DVec3| {
            let nearest = four::places_of(piece, own, axis)
                .into_iter()
                .fold(f64::INFINITY, |least, t| least.min(t.abs()));
            nearest * self.place.transform_vector3(axis).length()
        };
        let to_place = DVec3::AXES.into_iter().map(along).fold(to_place, f64::min);
        let Some((value, gradient)) = piece.implicit(own) else { return to_place };
        let gradient = self.inverse.matrix3.transpose() * gradient;
        to_place.min(value.abs() / gradient.length())
    }

    fn normal(&self, piece: u32, weights: [f32; 2]) -> Vec3 {
        let piece = self.piece(piece);
        let normal = piece.normal(piece.point(weights.map(f64::from)));
        // by the transposed inverse: outward normals stay outward in mirror images
        (self.inverse.matrix3.transpose() * normal).normalize_or(DVec3::Y).as_vec3()
    }

    /// Around the axis u goes once from 0 to 1, to the right as seen from outside, with 0.5 towards +Z, and v from
    /// 0 at the lower end to 1 at the upper one (spheres: by latitude). Disks show the square around them. Planes
    /// have the object's x and -z.
    fn uv(&self, piece: u32, weights: [f32; 2]) -> Vec2 {
        let own = self.piece(piece);
        let point = own.point(weights.map(f64::from));
        if self.is_endless {
            let there = (self.to_texture * self.place).transform_point3(point);
            return Vec2::new(there.x as f32, -there.z as f32);
        }
        let u = 0.5 + point.x.atan2(point.z) / std::f64::consts::TAU;
        let [low, high] = own.range;
        match own.kind {
            Kind::Ball => Vec2::new(u as f32, (0.5 + latitude(point) / std::f64::consts::PI) as f32),
            Kind::Belt | Kind::Sheet { .. } => Vec2::new(u as f32, ((point.y - low) / (high - low)) as f32),
            Kind::Disk { faces_up } => {
                let away = if faces_up { -point.z } else { point.z };
                Vec2::new((0.5 + point.x * 0.5) as f32, (0.5 + away * 0.5) as f32)
            }
        }
    }

    fn mapped(&self, map: DAffine3) -> Arc<dyn Curved> {
        Arc::new(self.placed(map))
    }

    fn bytes(&self) -> u64 {
        (size_of::<Self>() + size_of_val(self.pieces.as_slice())) as u64
    }

    /// Planes have no size.
    fn is_endless(&self) -> bool {
        self.is_endless
    }
}

fn latitude(point: DVec3) -> f64 {
    point.y.atan2((point.x * point.x + point.z * point.z).sqrt())
}

/// Pieces of the side of `shape` in its own space, and the map from there to object space.
fn own_space(shape: QuadricShape) -> (Vec<Piece>, DAffine3) {
    let belt = |profile, range| vec![Piece { kind: Kind::Belt, profile, range }];
    let standing = |radius, height| DAffine3::from_scale(DVec3::new(radius, height, radius));
    // from -1 to 1 instead of from 0 to 1
    let around_waist = |radius: f64, height: f64| {
        let scale = DVec3::new(radius, height * 0.5, radius);
        DAffine3::from_translation(DVec3::Y * (height * 0.5)) * DAffine3::from_scale(scale)
    };
    match shape {
        QuadricShape::Ellipsoid { radii } => {
            let ball = Piece { kind: Kind::Ball, profile: [-1.0, 0.0, 1.0], range: [-1.0, 1.0] };
            (vec![ball], DAffine3::from_scale(radii))
        }
        QuadricShape::Cylinder { radius, height } => {
            (belt([0.0, 0.0, 1.0], [0.0, 1.0]), standing(radius, height))
        }
        QuadricShape::Cone { radius, top, height } => {
            let largest = radius.max(top);
            let (below, above) = (radius / largest, top / largest);
            let growth = above - below;
            let profile = [growth * growth, 2.0 * below * growth, below * below];
            (belt(profile, [0.0, 1.0]), standing(largest, height))
        }
        QuadricShape::Paraboloid { radius, height } => {
            let kind = Kind::Sheet { is_upper: true };
            let bowl = Piece { kind, profile: [0.0, 1.0, 0.0], range: [0.0, 1.0] };
            (vec![bowl], standing(radius, height))
        }
        QuadricShape::OneSheet { radius, waist, height } => {
            let square = (waist / radius) * (waist / radius);
            (belt([1.0 - square, 0.0, square], [-1.0, 1.0]), around_waist(radius, height))
        }
        QuadricShape::TwoSheets { radius, gap, height } => {
            let half = gap / height;
            let steep = 1.0 / (1.0 - half * half);
            let profile = [steep, 0.0, -steep * half * half];
            let sheet = |is_upper, range| Piece { kind: Kind::Sheet { is_upper }, profile, range };
            (vec![sheet(false, [-1.0, -half]), sheet(true, [half, 1.0])], around_waist(radius, height))
        }
        QuadricShape::Plane { center: [x, z], reach } => {
            let place = DAffine3::from_translation(DVec3::new(x, 0.0, z))
                * DAffine3::from_scale(DVec3::new(reach, reach, reach));
            (vec![disk(0.0, 1.0, true)], place)
        }
    }
}

fn disk(height: f64, squared_radius: f64, faces_up: bool) -> Piece {
    Piece { kind: Kind::Disk { faces_up }, profile: [0.0, 0.0, squared_radius], range: [height; 2] }
}

/// Disks at those ends of `sides` that are not closed by themselves.
fn caps(sides: &[Piece]) -> Vec<Piece> {
    let least = |all: &[Piece]| all.iter().map(|piece| piece.range[0]).fold(f64::INFINITY, f64::min);
    let most = |all: &[Piece]| all.iter().map(|piece| piece.range[1]).fold(f64::NEG_INFINITY, f64::max);
    let ends = [(least(sides), false), (most(sides), true)];
    let open = sides.iter().filter(|piece| piece.kind != Kind::Ball);
    open.flat_map(|side| {
        ends.into_iter().filter_map(|(end, faces_up)| {
            let square = side.squared_radius(end);
            (side.range.contains(&end) && square > 1e-30).then(|| disk(end, square, faces_up))
        })
    })
    .collect()
}

#[cfg(test)]
mod tests;
