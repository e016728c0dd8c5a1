//! Mirrors and glass: rays that go on, and their weights.

use glam::Vec3;

use crate::scene::material::Optics;

use super::Surface;

/// A ray that goes on from a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branch {
    /// Direction, unit length.
    pub direction: Vec3,
    /// Factor for the light that the ray brings back.
    pub weight: Vec3,
}

/// Rays that go on where a ray along `incoming` (unit length) meets `surface`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Branches {
    /// Reflected ray.
    pub reflection: Option<Branch>,
    /// Ray that passes through.
    pub refraction: Option<Branch>,
}

/// Splits the ray at `surface` by its material's `optics`.
pub fn branch(optics: Optics, surface: &Surface, incoming: Vec3) -> Branches {
    match optics {
        Optics::Opaque => Branches::default(),
        Optics::Mirror { tint, fresnel } => {
            let weight = if fresnel { schlick(tint, surface, incoming) } else { tint };
            Branches { reflection: Some(reflect(surface, incoming, weight)), refraction: None }
        }
        Optics::Glass { transmission, index, reflection } => {
            glass(surface, incoming, transmission, index, reflection)
        }
    }
}

/// Schlick's approximation: `tint` head-on, white at grazing angles.
fn schlick(tint: Vec3, surface: &Surface, incoming: Vec3) -> Vec3 {
    let cos = -surface.normal.dot(incoming);
    tint + (Vec3::ONE - tint) * (1.0 - cos.clamp(0.0, 1.0)).powi(5)
}

/// Reflects the ray off the surface, and never into it: where an interpolated normal would send it below the
/// triangle, the geometric normal reflects it.
fn reflect(surface: &Surface, incoming: Vec3, weight: Vec3) -> Branch {
    let off = |normal: Vec3| incoming - 2.0 * normal.dot(incoming) * normal;
    let direction = off(surface.normal);
    let direction =
        if surface.geometric_normal.dot(direction) > 0.0 { direction } else { off(surface.geometric_normal) };
    Branch { direction: direction.normalize(), weight }
}

/// Splits a ray by Snell's law and Fresnel's equations for unpolarised light. The triangle's front is the
/// outside of the glass.
fn glass(surface: &Surface, incoming: Vec3, transmission: Vec3, index: f32, reflection: Vec3) -> Branches {
    if index == 1.0 {
        let straight = Branch { direction: incoming, weight: transmission };
        return Branches { reflection: None, refraction: Some(straight) };
    }
    let eta = if surface.from_behind { index } else { index.recip() };
    let cos_in = (-surface.normal.dot(incoming)).clamp(0.0, 1.0);
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in);
    if sin2_out >= 1.0 {
        // total internal reflection: all of the light stays inside, untinted
        return Branches { reflection: Some(reflect(surface, incoming, Vec3::ONE)), refraction: None };
    }
    let cos_out = (1.0 - sin2_out).sqrt();
    let reflected = fresnel(cos_in, cos_out, eta);
    let direction = eta * incoming + (eta * cos_in - cos_out) * surface.normal;
    let refraction = Branch { direction: direction.normalize(), weight: transmission * (1.0 - reflected) };
    Branches {
        reflection: Some(reflect(surface, incoming, reflection * reflected)),
        refraction: Some(refraction),
    }
}

/// Share of unpolarised light that is reflected; `eta` is the index of the near side over that of the far
/// side.
fn fresnel(cos_in: f32, cos_out: f32, eta: f32) -> f32 {
    let across = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    let along = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    0.5 * (across * across + along * along)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn floor(from_behind: bool) -> Surface {
        let up = if from_behind { Vec3::NEG_Y } else { Vec3::Y };
        Surface {
            point: Vec3::ZERO,
            normal: up,
            geometric_normal: up,
            reflectance: Vec3::ZERO,
            material: 0,
            from_behind,
            width: 0.0,
        }
    }

    fn at_angle(degrees: f32, down: bool) -> Vec3 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vec3::new(sin, if down { -cos } else { cos }, 0.0)
    }

    const GLASS: Optics = Optics::Glass { transmission: Vec3::ONE, index: 1.5, reflection: Vec3::ONE };

    #[test]
    fn snells_law_holds_into_glass_and_out_of_it() {
        let into = branch(GLASS, &floor(false), at_angle(30.0, true)).refraction.expect("enters");
        assert!((into.direction.x - 0.5 / 1.5).abs() < 1e-6);
        let out = branch(GLASS, &floor(true), at_angle(30.0, false)).refraction.expect("leaves");
        assert!((out.direction.x - 0.5 * 1.5).abs() < 1e-6 && out.direction.y > 0.0);
    }

    #[test]
    fn light_is_neither_lost_nor_made_at_glass() {
        for degrees in [0.0, 20.0, 56.3, 80.0, 89.9] {
            let rays = branch(GLASS, &floor(false), at_angle(degrees, true));
            let sum = rays.reflection.expect("some").weight + rays.refraction.expect("some").weight;
            assert!((sum - Vec3::ONE).length() < 1e-5, "{degrees}: {sum}");
        }
        let head_on = branch(GLASS, &floor(false), Vec3::NEG_Y).reflection.expect("some").weight.x;
        assert!((head_on - 0.04).abs() < 1e-5, "((1.5 - 1) / (1.5 + 1))^2, not {head_on}");
    }

    #[test]
    fn beyond_the_critical_angle_everything_is_reflected() {
        // asin(1 / 1.5) = 41.8 degrees
        let below = branch(GLASS, &floor(true), at_angle(41.0, false));
        let above = branch(GLASS, &floor(true), at_angle(43.0, false));
        assert!(below.refraction.is_some());
        assert_eq!(above.refraction, None);
        assert_eq!(above.reflection.expect("all of it").weight, Vec3::ONE);
    }

    #[test]
    fn a_mirror_turns_the_ray_about_the_normal() {
        let mirror = Optics::Mirror { tint: Vec3::splat(0.8), fresnel: false };
        let ray = branch(mirror, &floor(false), at_angle(30.0, true)).reflection.expect("bounces");
        assert!((ray.direction - at_angle(30.0, false)).length() < 1e-6);
        assert_eq!(ray.weight, Vec3::splat(0.8));
        let leaning = Surface { normal: Vec3::new(0.9, 0.1, 0.0).normalize(), ..floor(false) };
        let ray = branch(mirror, &leaning, at_angle(60.0, true)).reflection.expect("bounces");
        assert!(ray.direction.y > 0.0, "never into the surface");
    }
}
