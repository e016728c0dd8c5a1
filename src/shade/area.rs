//! Area lights: points on them that send light, and the radiance that a ray sees which passes through one.
//!
//! Irradiance of lights leaves out Lambert's division by pi ([`phong`](super::bsdf::phong)), radiance does not: the
//! radiance of a light is pi times what its strength would give.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, PI, TAU};

use glam::Vec3;

use super::light_sample::{LightSample, from_place, share_of, share_of_spread, within};
use crate::lanes::{F32x8, Mask, Vec3x8};
use crate::pose::{AreaShape, Cone, LightPose, LightShape, Spread};

/// An area light as a ray sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glow {
    /// Distance to the light; infinite for a directional one.
    pub distance: f32,
    /// Radiance, linear RGB.
    pub radiance: Vec3,
    /// Density, in solid angle, of the ray's direction where a point on the light is chosen evenly.
    pub density: f32,
    /// Number of rays that a surface sends to it where all lights are summed.
    pub points: usize,
}

/// Radiance of an area light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaRadiance {
    /// Where it is full; linear RGB.
    pub full: Vec3,
    /// What of it is sent in each direction.
    pub beam: Beam,
    /// False if the points of the light that are asked bring all of its light, and paths off the same surface none.
    pub is_met: bool,
}

/// What of the radiance of a light is sent in each direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Beam {
    /// All of it.
    Even,
    /// That within the cone of a spot.
    Cone(Cone),
    /// What the spread of a panel leaves.
    Spread(Spread),
}

impl Beam {
    #[inline(always)]
    fn share(&self, to_light: Vec3x8) -> F32x8 {
        match self {
            Self::Even => F32x8::ONE,
            Self::Cone(cone) => share_of(cone, to_light),
            Self::Spread(spread) => share_of_spread(spread, to_light),
        }
    }
}

impl AreaRadiance {
    /// Radiance that is seen along `direction`, unit length, towards the light.
    #[inline(always)]
    pub fn along(&self, direction: Vec3) -> Vec3 {
        match self.beam {
            Beam::Even => self.full,
            _ => self.full * self.beam.share(Vec3x8::splat(direction)).lane(0),
        }
    }

    /// Largest channel of the radiance that is seen along eight directions.
    #[inline(always)]
    pub fn brightest_along(&self, directions: Vec3x8) -> F32x8 {
        F32x8::splat(self.full.max_element()) * self.beam.share(directions)
    }
}

/// Radiance of an area light. `None` for lights that have no area.
pub fn radiance(light: &LightPose) -> Option<AreaRadiance> {
    let LightShape::Area(area) = light.shape else { return None };
    let spread_of = |spread: Option<Spread>| spread.map_or(Beam::Even, Beam::Spread);
    let (factor, beam) = match area {
        AreaShape::Rectangle { across, up, spread, .. } => {
            (PI / (across.length() * up.length()), spread_of(spread))
        }
        AreaShape::Disk { across, up, spread, .. } => {
            (1.0 / (across.length() * up.length()), spread_of(spread))
        }
        AreaShape::Sphere { radius, cone, .. } => {
            (1.0 / (radius * radius), cone.map_or(Beam::Even, Beam::Cone))
        }
        AreaShape::Sun { versine, .. } => (0.5 / versine, Beam::Even),
    };
    Some(AreaRadiance { full: light.strength * factor, beam, is_met: true })
}

/// Intersects the ray `origin + t * direction` (unit length) with `light`: what it sees, if it meets the side
/// that shines.
pub fn glow(light: &LightPose, origin: Vec3, direction: Vec3) -> Option<Glow> {
    let LightShape::Area(area) = light.shape else { return None };
    let (distance, density) = match area {
        AreaShape::Rectangle { center, across, up, axis, .. } => {
            let (distance, aside, cos) = meet_plane(center, axis, origin, direction)?;
            let along = |edge: Vec3| aside.dot(edge).abs() <= 0.5 * edge.length_squared();
            let is_inside = along(across) && along(up);
            is_inside.then(|| (distance, distance * distance / (cos * across.length() * up.length())))?
        }
        AreaShape::Disk { center, across, up, axis, .. } => {
            let (distance, aside, cos) = meet_plane(center, axis, origin, direction)?;
            // shares of the radii
            let along = |radius: Vec3| aside.dot(radius) / radius.length_squared();
            let is_inside = along(across).powi(2) + along(up).powi(2) <= 1.0;
            is_inside.then(|| (distance, distance * distance / (cos * PI * across.length() * up.length())))?
        }
        AreaShape::Sphere { center, radius, faces: true, .. } => {
            let to_center = center - origin;
            let (squared, along) = (to_center.length_squared(), to_center.dot(direction));
            let to_rim = squared + radius * radius;
            let is_met = along > 0.0 && along * along * to_rim >= squared * squared;
            is_met.then(|| (squared / along, 1.0 / (TAU * versine(radius * radius / to_rim))))?
        }
        AreaShape::Sphere { center, radius, .. } => {
            let to_center = center - origin;
            let (squared, along) = (to_center.length_squared(), to_center.dot(direction));
            let beside = (to_center - direction * along).length_squared();
            let is_met = along > 0.0 && beside <= radius * radius && squared > radius * radius;
            let distance = along - (radius * radius - beside).max(0.0).sqrt();
            is_met.then(|| (distance, 1.0 / (TAU * versine(radius * radius / squared))))?
        }
        AreaShape::Sun { to_light, versine, .. } => {
            let is_met = (direction - to_light).length_squared() <= 2.0 * versine;
            is_met.then_some((f32::INFINITY, 1.0 / (TAU * versine)))?
        }
    };
    let radiance = radiance(light)?.along(direction);
    Some(Glow { distance, radiance, density, points: light.points })
}

/// Density with which [`light_from_anywhere`](super::light::light_from_anywhere) has chosen a direction from
/// which this irradiance arrives, of a light of this `radiance`.
pub fn density_of(radiance: Vec3, irradiance: Vec3) -> f32 {
    FRAC_1_PI * radiance.max_element() / irradiance.max_element()
}

/// Intersects a ray with the front of a plane: the distance, the point relative to the plane's centre, and
/// the cosine to its axis.
fn meet_plane(center: Vec3, axis: Vec3, origin: Vec3, direction: Vec3) -> Option<(f32, Vec3, f32)> {
    let cos = -direction.dot(axis);
    let distance = (origin - center).dot(axis) / cos;
    (cos > 0.0 && distance > 0.0).then(|| (distance, origin + direction * distance - center, cos))
}

/// Versine of an angle, 1 less its cosine, from its squared sine.
fn versine(squared_sine: f32) -> f32 {
    squared_sine / (1.0 + (1.0 - squared_sine).max(0.0).sqrt())
}

/// Light from the points of `light` at `aside`, shares of the edges of its `area` from -1/2 to 1/2, to eight `points`.
#[inline(always)]
pub(super) fn from_places(
    light: &LightPose,
    area: AreaShape,
    aside: [F32x8; 2],
    points: Vec3x8,
) -> LightSample {
    let share = light.strength / light.points as f32;
    match area {
        AreaShape::Rectangle { center, across, up, axis, spread } => {
            let [along, above] = aside;
            let source = Vec3x8::splat(center) + Vec3x8::splat(across) * along + Vec3x8::splat(up) * above;
            from_plane(share, source, (axis, spread), points)
        }
        AreaShape::Disk { center, across, up, axis, spread } => {
            let [along, above] = disk(aside);
            let source = Vec3x8::splat(center) + Vec3x8::splat(across) * along + Vec3x8::splat(up) * above;
            from_plane(share, source, (axis, spread), points)
        }
        AreaShape::Sphere { center, radius, faces: true, .. } => {
            from_facing(share, center, radius, disk(aside), points)
        }
        AreaShape::Sphere { center, radius, cone, .. } => {
            let light_sample = from_sphere(share, center, radius, disk(aside), points);
            cone.map_or(light_sample, |cone| within(&cone, light_sample))
        }
        AreaShape::Sun { to_light, across, up, versine } => {
            let axes = [across, up, to_light].map(Vec3x8::splat);
            let direction = in_cone(axes, F32x8::splat(versine), disk(aside)).0;
            let irradiance = Vec3x8::splat(share);
            LightSample { to_light: direction, direction, far: f32::INFINITY, irradiance, reaches: Mask::ALL }
        }
    }
}

/// Light from points of a plane, which shines with the cosine to its axis (Lambert's law), and less aside of it where it has a spread.
#[inline(always)]
fn from_plane(
    strength: Vec3,
    source: Vec3x8,
    (axis, spread): (Vec3, Option<Spread>),
    points: Vec3x8,
) -> LightSample {
    let mut light_sample = from_place(strength, source, points);
    let mut share = (-light_sample.direction.dot(Vec3x8::splat(axis))).max(F32x8::ZERO);
    if let Some(spread) = spread {
        share = share * share_of_spread(&spread, light_sample.direction);
    }
    light_sample.irradiance = light_sample.irradiance * share;
    light_sample.reaches = share.gt(F32x8::ZERO);
    light_sample
}

/// Light from the part of a sphere that is in sight, evenly by solid angle (Shirley, Wang and Zimmerman,
/// "Monte Carlo Techniques for Direct Lighting Calculations", 1996). It shines outwards: nothing reaches
/// points inside.
#[inline(always)]
fn from_sphere(strength: Vec3, center: Vec3, radius: f32, place: [F32x8; 2], points: Vec3x8) -> LightSample {
    let (one, squared_radius) = (F32x8::ONE, F32x8::splat(radius * radius));
    let to_center = Vec3x8::splat(center) - points;
    let squared = to_center.dot(to_center).max(F32x8::splat(f32::MIN_POSITIVE.sqrt()));
    let is_outside = squared.gt(squared_radius);
    let squared_sine = (squared_radius / squared).min(one);
    let versine = squared_sine / (one + (one - squared_sine).sqrt());
    let distance = squared.sqrt();
    let axis = to_center * (one / distance);
    let (direction, squared_sine) = in_cone(axes_about(axis), versine, place);
    let beside = squared * squared_sine;
    let along = distance * (one - squared_sine).max(F32x8::ZERO).sqrt();
    let reach = along - (squared_radius - beside).max(F32x8::ZERO).sqrt();
    // as much as comes from the whole cone
    let share = Vec3x8::splat(strength) * (versine * F32x8::splat(2.0) / squared_radius);
    LightSample {
        to_light: direction * reach.max(F32x8::splat(f32::MIN_POSITIVE)),
        direction,
        far: 1.0,
        irradiance: is_outside.select3(share, Vec3x8::ZERO),
        reaches: is_outside,
    }
}

/// Light from a disc that faces the points, evenly by solid angle.
#[inline(always)]
fn from_facing(strength: Vec3, center: Vec3, radius: f32, place: [F32x8; 2], points: Vec3x8) -> LightSample {
    let (one, squared_radius) = (F32x8::ONE, F32x8::splat(radius * radius));
    let to_center = Vec3x8::splat(center) - points;
    let squared = to_center.dot(to_center).max(F32x8::splat(f32::MIN_POSITIVE.sqrt()));
    let squared_sine = squared_radius / (squared + squared_radius);
    let versine = squared_sine / (one + (one - squared_sine).max(F32x8::ZERO).sqrt());
    let distance = squared.sqrt();
    let axis = to_center * (one / distance);
    let (direction, squared_sine) = in_cone(axes_about(axis), versine, place);
    let cos = (one - squared_sine).max(F32x8::splat(f32::MIN_POSITIVE)).sqrt();
    let share = Vec3x8::splat(strength) * (versine * F32x8::splat(2.0) / squared_radius);
    LightSample {
        to_light: direction * (distance / cos).max(F32x8::splat(f32::MIN_POSITIVE)),
        direction,
        far: 1.0,
        irradiance: share,
        reaches: Mask::ALL,
    }
}

/// Maps points of a unit disc to directions about the last of three axes, evenly in solid angle. Returns them
/// with the squared sines of their angles to that axis. `versine`: 1 less the cosine of the cone's half
/// angle.
#[inline(always)]
fn in_cone(axes: [Vec3x8; 3], versine: F32x8, [along, above]: [F32x8; 2]) -> (Vec3x8, F32x8) {
    let squared = along * along + above * above;
    let one_less_cos = squared * versine;
    let sine_by_radius = versine * (F32x8::splat(2.0) - one_less_cos);
    let stretch = sine_by_radius.max(F32x8::ZERO).sqrt();
    let direction =
        axes[0] * (along * stretch) + axes[1] * (above * stretch) + axes[2] * (F32x8::ONE - one_less_cos);
    (direction, squared * sine_by_radius)
}

/// Maps points of a square from -1/2 to 1/2 to points of a unit disc, areas in proportion: Shirley and Chiu,
/// "A Low Distortion Map Between Disk and Square", 1997.
#[inline(always)]
fn disk([along, above]: [F32x8; 2]) -> [F32x8; 2] {
    let (a, b) = (along + along, above + above);
    let is_steep = a.abs().lt(b.abs());
    let (radius, other) = (is_steep.select(b, a), is_steep.select(a, b));
    let some = radius.abs().gt(F32x8::ZERO);
    let angle = F32x8::splat(FRAC_PI_4) * some.select(other / radius, F32x8::ZERO);
    // series that end below the last bit within 45 degrees
    let series = |terms: [f32; 4]| {
        let square = angle * angle;
        terms.into_iter().fold(F32x8::ZERO, |sum, term| sum * square + F32x8::splat(term))
    };
    let cos = series([-1.0 / 720.0, 1.0 / 24.0, -0.5, 1.0]);
    let sin = angle * series([-1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0]);
    let (near, far) = (radius * cos, radius * sin);
    [is_steep.select(far, near), is_steep.select(near, far)]
}

/// Two directions at right angles to `axis` (unit length) and to each other, then the axis: see
/// [`orthonormal`](super::sampling::orthonormal).
#[inline(always)]
fn axes_about(axis: Vec3x8) -> [Vec3x8; 3] {
    let one = F32x8::ONE;
    let sign = one.with_sign_of(axis.z);
    let a = -one / (sign + axis.z);
    let b = axis.x * axis.y * a;
    [
        Vec3x8 { x: one + sign * axis.x * axis.x * a, y: sign * b, z: -sign * axis.x },
        Vec3x8 { x: b, y: sign + axis.y * axis.y * a, z: -axis.y },
        axis,
    ]
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::shade::light::light_from_anywhere;
    use crate::shade::sampling::PathRandom;

    fn lights() -> [LightPose; 9] {
        let (center, axis) = (Vec3::new(0.3, 2.0, -0.5), Vec3::new(0.6, -0.8, 0.0));
        let (across, up) = (Vec3::Z, Vec3::new(0.8, 0.6, 0.0));
        let shapes = [
            AreaShape::Rectangle { center, across: across * 1.5, up: up * 0.7, axis, spread: None },
            AreaShape::Disk { center, across: across * 0.8, up: up * 0.8, axis, spread: None },
            AreaShape::Disk { center, across: across * 0.9, up: up * 0.4, axis, spread: None },
            // the origin is where it is dim
            AreaShape::Rectangle {
                center,
                across,
                up: up * 0.7,
                axis,
                spread: Some(Spread { axis, fall: 0.5 }),
            },
            AreaShape::Sphere { center, radius: 0.9, cone: None, faces: false },
            AreaShape::Sphere { center, radius: 0.9, cone: None, faces: true },
            // the origin is within
            AreaShape::Sphere { center, radius: 2.5, cone: None, faces: true },
            // the origin is where it fades
            AreaShape::Sphere {
                center,
                radius: 0.4,
                faces: false,
                cone: Some(Cone { axis: Vec3::NEG_Y, cos_outer: 0.7, cos_inner: 0.99, curve: [3.0, 2.0] }),
            },
            AreaShape::Sun { to_light: -axis, across, up, versine: 0.02 },
        ];
        shapes.map(|area| LightPose {
            shape: LightShape::Area(area),
            strength: Vec3::new(1.0, 2.0, 4.0),
            points: 16,
        })
    }

    fn anywhere(light: &LightPose, index: u32) -> LightSample {
        let [along, above, ..] = PathRandom::new(3, index).four(0);
        light_from_anywhere(light, [along, above].map(F32x8::splat), Vec3x8::ZERO)
    }

    /// Checks that the integral of the radiance that rays see is the light that the light sends.
    #[test]
    fn what_rays_see_adds_up_to_what_a_light_sends() {
        const ROWS: usize = 1500;
        for light in lights() {
            let sent = (0..256).map(|index| anywhere(&light, index).irradiance.lane(0)).sum::<Vec3>() / 256.0;
            let mut seen = DVec3::ZERO;
            for (i, j) in (0..2 * ROWS).flat_map(|i| (0..ROWS).map(move |j| (i, j))) {
                let (turn, up) = ((i as f32 + 0.5) / ROWS as f32 * PI, (j as f32 + 0.5) / ROWS as f32);
                let across = (1.0 - up * up).sqrt();
                let direction = Vec3::new(across * turn.sin(), up, across * turn.cos());
                seen +=
                    glow(&light, Vec3::ZERO, direction).map_or(DVec3::ZERO, |glow| glow.radiance.as_dvec3());
            }
            let seen = seen.as_vec3() * (TAU / (2 * ROWS * ROWS) as f32) / PI;
            assert!((seen / sent - Vec3::ONE).abs().max_element() < 0.01, "{light:?}: {seen}, {sent}");
        }
    }

    /// Checks that the ray towards a chosen point meets the light there, with the density that is given.
    #[test]
    fn rays_to_places_meet_them() {
        for light in lights() {
            for index in 0..64 {
                let sample = anywhere(&light, index);
                let direction = sample.to_light.lane(2).normalize();
                let Some(met) = glow(&light, Vec3::ZERO, direction) else {
                    panic!("{light:?} is not met {index}")
                };
                let distance = sample.to_light.lane(2).length() * sample.far;
                assert!(
                    (met.distance / distance - 1.0).abs() < 1e-3 || met.distance == distance,
                    "{light:?}"
                );
                let seen = radiance(&light).expect("it has an area").along(direction);
                let density = density_of(seen, sample.irradiance.lane(2));
                assert!((met.density / density - 1.0).abs() < 1e-3, "{light:?}: {met:?}, {density}");
                assert!((direction - sample.direction.lane(2)).length() < 1e-5);
            }
        }
    }

    #[test]
    fn far_away_a_sphere_is_a_point() {
        let shape = LightShape::Area(AreaShape::Sphere {
            center: Vec3::new(0.0, 50.0, 0.0),
            radius: 0.5,
            cone: None,
            faces: false,
        });
        let light = LightPose { shape, strength: Vec3::splat(2500.0), points: 16 };
        assert!((anywhere(&light, 0).irradiance.lane(0).x - 1.0).abs() < 1e-4);
        let inside =
            LightShape::Area(AreaShape::Sphere { center: Vec3::ZERO, radius: 0.5, cone: None, faces: false });
        assert_eq!(anywhere(&LightPose { shape: inside, ..light }, 0).irradiance.lane(0), Vec3::ZERO);
        assert_eq!(glow(&LightPose { shape: inside, ..light }, Vec3::ZERO, Vec3::Y), None);
    }

    #[test]
    fn from_behind_nothing_is_seen() {
        for light in &lights()[..4] {
            assert_eq!(glow(light, Vec3::new(0.3, 9.0, -0.5), Vec3::NEG_Y), None);
            assert!(glow(light, Vec3::new(0.3, -9.0, -0.5), Vec3::Y).is_some());
        }
        assert!(lights().iter().all(|light| glow(light, Vec3::ZERO, Vec3::NEG_Y).is_none()));
    }
}
