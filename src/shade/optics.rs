//! Mirrors and glass: rays that go on, and their weights.

use glam::Vec3;

use super::Surface;
use super::bsdf::{fresnel, ggx};
use super::sampling::{PathRandom, orthonormal, seed_of};
use crate::scene::Material;
use crate::scene::material::{LEAST_ALPHA, MetalRough, Optics};

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

/// Splits the ray at `surface` by what its `material` does beside its layer. Rough glass bends it by one of its microfacets, which `random`
/// chooses.
pub fn branch(
    material: &Material,
    surface: &Surface,
    incoming: Vec3,
    random: impl FnOnce() -> [f32; 2],
) -> Branches {
    let mut branches = branch_of_clear(material, surface, incoming, random);
    if material.uneven_glass.is_some_and(|glass| glass.is_tinted)
        && let Some(through) = &mut branches.refraction
    {
        through.weight *= material.tint_of_glass(surface.reflectance);
    }
    branches
}

/// [`branch`] where nothing but its material colours what goes through glass.
fn branch_of_clear(
    material: &Material,
    surface: &Surface,
    incoming: Vec3,
    random: impl FnOnce() -> [f32; 2],
) -> Branches {
    match material.optics_at(surface.varied) {
        Optics::Opaque => Branches::default(),
        Optics::Mirror { tint, fresnel } => {
            let weight = if fresnel { schlick(tint, surface, incoming) } else { tint };
            Branches { reflection: Some(reflect(surface, incoming, weight)), refraction: None }
        }
        Optics::Glass { transmission, index, reflection, is_rough: false, is_thin: true, .. } => {
            pane(surface, incoming, transmission, index, reflection)
        }
        Optics::Glass { transmission, index, reflection, total, is_rough: false, .. } => {
            glass(surface, incoming, (transmission, index), reflection, total)
        }
        Optics::Glass { transmission, index, total, is_thin, .. } => {
            let layer = material.metal_rough.map(|layer| layer.at(surface.varied));
            let microfacet = Microfacet::new(surface, incoming, layer.as_ref(), random());
            if index == 1.0 || is_thin {
                microfacet.thin(incoming, transmission)
            } else {
                microfacet.solid(surface, incoming, (transmission, index), total)
            }
        }
    }
}

/// Numbers for [`branch`] at a surface that a ray has met: they belong to its place.
pub fn random_of_place(surface: &Surface) -> [f32; 2] {
    let seed = seed_of(surface.point, surface.material.into());
    let [around, along, ..] = PathRandom::new(seed, 0).four(0);
    [around, along]
}

/// A part of rough glass that is as smooth as a mirror. Light that would meet another one on its way out leaves all the same, so that
/// none is lost (Walter et al. 2007 leave it out).
///
/// What it reflects as it does from outside, and is not masked, is left to the material's layer, whose paths are kept.
struct Microfacet {
    /// Its normal, on the side of the ray.
    normal: Vec3,
    /// Normal of the surface on the whole, on that side.
    mean: Vec3,
    /// Normal of the triangle, on that side.
    of_triangle: Vec3,
    /// Width of the lobe.
    alpha: f32,
    /// Index of refraction of the layer, 1 or more.
    index_of_layer: f32,
}

impl Microfacet {
    /// Samples one of those that the ray sees.
    fn new(surface: &Surface, incoming: Vec3, layer: Option<&MetalRough>, numbers: [f32; 2]) -> Self {
        let alpha = layer.map_or(LEAST_ALPHA, MetalRough::alpha);
        // an interpolated normal may face away from the ray, the triangle's does not
        let faces = |normal: &Vec3| normal.dot(incoming) < 0.0;
        let mean = Some(surface.normal).filter(faces).unwrap_or(surface.geometric_normal);
        let [across, up] = orthonormal(mean);
        let to_eye = -Vec3::new(across.dot(incoming), up.dot(incoming), mean.dot(incoming));
        let normal = ggx::visible_normal(alpha, to_eye, numbers);
        Self {
            normal: (across * normal.x + up * normal.y + mean * normal.z).normalize(),
            mean,
            of_triangle: surface.geometric_normal,
            alpha,
            index_of_layer: layer.map_or(1.0, |layer| fresnel::index_of(layer.head_on)),
        }
    }

    /// The rays on at the surface of rough glass: through it, and, from within, what it reflects more than its layer does.
    fn solid(
        &self,
        surface: &Surface,
        incoming: Vec3,
        (transmission, index): (Vec3, f32),
        total: Vec3,
    ) -> Branches {
        let bent = Surface { normal: self.normal, ..*surface };
        let through = glass(&bent, incoming, (Vec3::ONE, index), Vec3::ONE, total).refraction;
        let by_layer = self.reflected_by_layer(incoming);
        // from the denser side more is reflected than the layer knows of
        let is_dense = surface.from_behind == (index > 1.0);
        let reflected = match &through {
            Some(ray) if is_dense => by_layer.max(1.0 - ray.weight.x),
            Some(_) => by_layer,
            None => 1.0,
        };
        let mirrored = Branch {
            direction: self.turned_to(1.0, self.reflected(incoming)),
            weight: total * (reflected - by_layer),
        };
        let refraction = through.map(|ray| Branch {
            direction: self.turned_to(-1.0, ray.direction),
            weight: transmission * (1.0 - reflected),
        });
        Branches { reflection: Some(mirrored).filter(|ray| ray.weight.max_element() > 0.0), refraction }
    }

    /// Share of the light that the layer reflects here.
    fn reflected_by_layer(&self, incoming: Vec3) -> f32 {
        let up = self.mean.dot(self.reflected(incoming));
        if up <= 0.0 {
            return 0.0;
        }
        let of_eye = (-self.mean.dot(incoming)).max(f32::MIN_POSITIVE);
        let reflected = fresnel::dielectric(self.index_of_layer, -self.normal.dot(incoming));
        reflected * ggx::unmasked(self.alpha, of_eye, up)
    }

    /// The ray through a rough pane that does not bend it on the whole: that which would be reflected, on the other side.
    fn thin(&self, incoming: Vec3, transmission: Vec3) -> Branches {
        let direction = self.turned_to(-1.0, self.reflected(incoming));
        let weight = transmission * (1.0 - self.reflected_by_layer(incoming));
        Branches { reflection: None, refraction: Some(Branch { direction, weight }) }
    }

    fn reflected(&self, incoming: Vec3) -> Vec3 {
        (incoming - 2.0 * self.normal.dot(incoming) * self.normal).normalize()
    }

    /// The direction, or its mirror image, that leads to this `side` of the surface on the whole, and of the triangle: above it (1) or
    /// below (-1).
    fn turned_to(&self, side: f32, direction: Vec3) -> Vec3 {
        [self.mean, self.of_triangle].into_iter().fold(direction, |direction, normal| {
            let up = normal.dot(direction);
            if up * side < 0.0 { (direction - 2.0 * up * normal).normalize() } else { direction }
        })
    }
}

/// Schlick's formula: `tint` head-on, white at grazing angles.
fn schlick(tint: Vec3, surface: &Surface, incoming: Vec3) -> Vec3 {
    let cos = -surface.normal.dot(incoming);
    Vec3::from(tint.to_array().map(|tint| fresnel::schlick(tint, cos)))
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

/// Splits a ray at a pane, of whose walls light is reflected back and forth: `2 R / (1 + R)` of it by all together, where either
/// reflects R (a geometric series).
fn pane(surface: &Surface, incoming: Vec3, transmission: Vec3, index: f32, reflection: Vec3) -> Branches {
    let reflected =
        of_both_walls(fresnel::dielectric(index.max(index.recip()), -surface.normal.dot(incoming)));
    let straight = Branch { direction: incoming, weight: transmission * (1.0 - reflected) };
    let mirrored = reflect(surface, incoming, reflection * reflected);
    Branches { reflection: Some(mirrored).filter(|_| reflected > 0.0), refraction: Some(straight) }
}

/// Share of the light that a pane reflects whose walls reflect this share of it.
pub fn of_both_walls(of_one: f32) -> f32 {
    2.0 * of_one / (1.0 + of_one)
}

/// Splits a ray by Snell's law and Fresnel's equations for unpolarised light. The triangle's front is the
/// outside of the glass. `reflection`, `total`: tints of light that is reflected in part, and of what is reflected totally.
fn glass(
    surface: &Surface,
    incoming: Vec3,
    (transmission, index): (Vec3, f32),
    reflection: Vec3,
    total: Vec3,
) -> Branches {
    if index == 1.0 {
        let straight = Branch { direction: incoming, weight: transmission };
        return Branches { reflection: None, refraction: Some(straight) };
    }
    let eta = if surface.from_behind { index } else { index.recip() };
    let cos_in = (-surface.normal.dot(incoming)).clamp(0.0, 1.0);
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in);
    if sin2_out >= 1.0 {
        // total internal reflection: all of the light stays inside
        return Branches { reflection: Some(reflect(surface, incoming, total)), refraction: None };
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
    use crate::scene::look::{Look, Varied};
    use crate::scene::material::head_on;
    use crate::shade::bsdf::{Bsdfs, SeenBy, SurfaceAxes};
    use crate::shade::horizon::Horizon;

    fn floor(from_behind: bool) -> Surface {
        let up = if from_behind { Vec3::NEG_Y } else { Vec3::Y };
        Surface {
            point: Vec3::ZERO,
            normal: up,
            geometric_normal: up,
            tangent: Vec3::ZERO,
            horizon: Horizon::flat(up),
            reflectance: Vec3::ZERO,
            material: 0,
            varied: Varied::NONE,
            from_behind,
            width: 0.0,
        }
    }

    fn at_angle(degrees: f32, down: bool) -> Vec3 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vec3::new(sin, if down { -cos } else { cos }, 0.0)
    }

    const GLASS: Optics = Optics::clear(Vec3::ONE, 1.5, Vec3::ONE);

    fn branch(optics: Optics, surface: &Surface, incoming: Vec3) -> Branches {
        let material = Material { optics, ..Material::fallback() };
        super::branch(&material, surface, incoming, || unreachable!("it is smooth"))
    }

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

    /// A pane is as clear as two walls of glass, from both sides, and bends nothing.
    #[test]
    fn panes_let_light_straight_through() {
        let thin = Optics::Glass {
            transmission: Vec3::ONE,
            index: 1.5,
            reflection: Vec3::ONE,
            total: Vec3::ONE,
            is_rough: false,
            is_thin: true,
        };
        for (degrees, from_behind) in [(0.0, false), (60.0, false), (60.0, true), (89.0, true)] {
            let incoming = at_angle(degrees, !from_behind);
            let rays = branch(thin, &floor(from_behind), incoming);
            let (back, on) = (rays.reflection.expect("some"), rays.refraction.expect("most"));
            assert!((back.weight + on.weight - 1.0).abs().max_element() < 1e-5, "{degrees}: {rays:?}");
            assert_eq!(on.direction, incoming);
        }
        let head_on = branch(thin, &floor(false), Vec3::NEG_Y).reflection.expect("some").weight.x;
        assert!((head_on - 0.08 / 1.04).abs() < 1e-5, "{head_on}");
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

    /// Of what is glass in part that part reflects totally, in a colour of its own; so does rough glass beside what its layer reflects.
    #[test]
    fn what_is_reflected_totally_has_a_colour_of_its_own() {
        let red = Vec3::new(0.5, 0.25, 0.0);
        let of = |is_rough| Optics::Glass {
            transmission: Vec3::ONE,
            index: 1.5,
            reflection: Vec3::ONE,
            total: red,
            is_rough,
            is_thin: false,
        };
        let (surface, incoming) = (floor(true), at_angle(60.0, false));
        let rays = branch(of(false), &surface, incoming);
        assert_eq!((rays.refraction, rays.reflection.map(|ray| ray.weight)), (None, Some(red)));
        let below = branch(of(false), &surface, at_angle(20.0, false));
        assert_eq!(below, branch(GLASS, &surface, at_angle(20.0, false)), "in part");
        let weight = |material: &Material| {
            let [around, along, ..] = PathRandom::new(5, 1).four(0);
            super::branch(material, &surface, incoming, || [around, along]).reflection.map(|ray| ray.weight)
        };
        let white = rough(0.01, 1.5);
        let tinted = Material { optics: of(true), ..white.clone() };
        let [white, tinted] = [white, tinted].map(|material| weight(&material).expect("some"));
        assert!(white.x > 0.5 && tinted.abs_diff_eq(red * white, 1e-6), "{white} {tinted}");
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

    /// Means over many microfacets: the weights of both rays, and where they lead.
    fn through_microfacets(material: &Material, surface: &Surface, incoming: Vec3) -> [(f32, Vec3); 2] {
        const COUNT: u32 = 1 << 14;
        let mut sums = [(0.0, Vec3::ZERO); 2];
        for index in 0..COUNT {
            let [around, along, ..] = PathRandom::new(5, index).four(0);
            let rays = super::branch(material, surface, incoming, || [around, along]);
            for (sum, ray) in sums.iter_mut().zip([rays.reflection, rays.refraction]) {
                let Some(ray) = ray else { continue };
                assert!((ray.direction.length() - 1.0).abs() < 1e-5);
                *sum = (sum.0 + ray.weight.x, sum.1 + ray.direction * ray.weight.x);
            }
        }
        sums.map(|(weight, direction)| (weight / COUNT as f32, direction / COUNT as f32))
    }

    /// The share of light that goes out of the glass, as an integral over the microfacets that are seen (Walter et al. 2007, equations 21 and
    /// 23), which knows nothing of how they are chosen. `eta`: the index of the near side over that of the far side.
    fn integral(alpha: f32, eta: f32, to_eye: Vec3) -> f64 {
        const STEPS: usize = 400;
        let (alpha, eye) = (f64::from(alpha), to_eye.abs().as_dvec3());
        let tan2 = (1.0 - eye.y * eye.y) / (eye.y * eye.y);
        let masked = 0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0);
        let mut sum = 0.0;
        for i in 0..STEPS {
            for j in 0..STEPS {
                // slopes in units of alpha, r, from 0 to infinity by s / (1 - s): their density is 1 / (pi (1 + r^2)^2)
                let s = (i as f64 + 0.5) / STEPS as f64;
                let (r, turn) = (s / (1.0 - s), std::f64::consts::TAU * (j as f64 + 0.5) / STEPS as f64);
                let area = r / (std::f64::consts::PI * (1.0 + r * r).powi(2) * (1.0 - s).powi(2));
                let area = area * std::f64::consts::TAU / (STEPS * STEPS) as f64;
                let tan = alpha * r;
                let cos = 1.0 / (1.0 + tan * tan).sqrt();
                let half = glam::DVec3::new(tan * cos * turn.cos(), cos, tan * cos * turn.sin());
                let toward = half.dot(eye);
                let sin2 = f64::from(eta).powi(2) * (1.0 - toward * toward);
                if toward > 0.0 && sin2 < 1.0 {
                    let reflected = fresnel(toward as f32, (1.0 - sin2).sqrt() as f32, eta);
                    // as much of it as is seen, for one unit of the surface
                    let seen = area * toward / (cos * eye.y * (1.0 + masked));
                    sum += seen * (1.0 - f64::from(reflected));
                }
            }
        }
        sum
    }

    /// Glass whose lobe has this width.
    fn rough(alpha: f32, index: f32) -> Material {
        let optics = Optics::Glass {
            transmission: Vec3::ONE,
            index,
            reflection: Vec3::ONE,
            total: Vec3::ONE,
            is_rough: true,
            is_thin: false,
        };
        let layer = MetalRough {
            base: Vec3::ZERO,
            roughness: alpha.sqrt(),
            metallic: 0.0,
            head_on: head_on(index.into()) as f32,
            solid: 1.0,
        };
        Material { optics, metal_rough: Some(layer), ..Material::fallback() }
    }

    #[test]
    fn rough_glass_lets_out_what_its_microfacets_do() {
        for (alpha, degrees) in [(0.01, 30.0), (0.09, 0.0), (0.25, 20.0), (0.6, 35.0)] {
            let incoming = at_angle(degrees, false);
            let [_, (through, _)] = through_microfacets(&rough(alpha, 1.5), &floor(true), incoming);
            let expected = integral(alpha, 1.5, incoming);
            assert!((f64::from(through) - expected).abs() < 3e-3, "{alpha} {degrees}: {through} {expected}");
        }
    }

    /// What the layer reflects, and what the rays reflect and let through, add up to the light that comes, for the eye and
    /// for paths.
    #[test]
    fn light_is_neither_lost_nor_made_at_rough_glass() {
        for (roughness, index) in [0.1_f32, 0.3, 0.4, 0.7, 1.0]
            .into_iter()
            .flat_map(|roughness| [0.7, 1.3, 1.5, 2.2].map(|index| (roughness, index)))
        {
            for (degrees, from_behind) in
                [(0.0, false), (45.0, false), (70.0, false), (20.0, true), (38.0, true), (60.0, true)]
            {
                let (material, surface) = (rough(roughness * roughness, index), floor(from_behind));
                let incoming = at_angle(degrees, !from_behind);
                let rays = through_microfacets(&material, &surface, incoming);
                let bsdfs = Bsdfs::new(std::slice::from_ref(&material));
                for seen_by in [SeenBy::Eye, SeenBy::Path] {
                    let layer = bsdfs.seen(
                        Look::plain(0),
                        Vec3::ZERO,
                        SurfaceAxes::of_normals([surface.normal; 2]),
                        incoming,
                        seen_by,
                    );
                    let sum = layer.expect("it has one").albedo.x + rays[0].0 + rays[1].0;
                    let name = format!("{roughness} {index} {degrees} {from_behind} {seen_by:?}");
                    assert!((sum - 1.0).abs() < 4e-3, "{name}: {sum}");
                }
            }
        }
    }

    #[test]
    fn glass_that_is_hardly_rough_is_as_smooth_glass() {
        for (from_behind, degrees) in [(false, 50.0), (true, 30.0), (true, 60.0)] {
            let (surface, incoming) = (floor(from_behind), at_angle(degrees, !from_behind));
            let smooth = branch(GLASS, &surface, incoming);
            let [(_, reflected), (_, refracted)] =
                through_microfacets(&rough(LEAST_ALPHA, 1.5), &surface, incoming);
            let of = |ray: Option<Branch>| ray.map_or(Vec3::ZERO, |ray| ray.direction * ray.weight.x);
            assert!(
                (refracted - of(smooth.refraction)).length() < 0.015,
                "{from_behind} {degrees}: {refracted}"
            );
            // of all that is reflected the layer reflects a part
            if smooth.refraction.is_none() {
                assert!(reflected.normalize().dot(of(smooth.reflection)) > 0.999, "{degrees}: {reflected}");
            } else {
                assert!(reflected.length() < 0.02, "{from_behind} {degrees}: {reflected}");
            }
        }
    }

    #[test]
    fn rays_stay_on_their_sides_of_the_triangle() {
        for from_behind in [false, true] {
            let straight = floor(from_behind);
            let up = straight.geometric_normal;
            let leaning = Surface { normal: (up * 0.2 + Vec3::X).normalize(), ..straight };
            let incoming = at_angle(80.0, !from_behind);
            for (index, material) in (0..256).zip([rough(0.3, 1.5), rough(0.3, 1.0)].iter().cycle()) {
                let [around, along, ..] = PathRandom::new(5, index).four(0);
                let rays = super::branch(material, &leaning, incoming, || [around, along]);
                assert!(rays.reflection.is_none_or(|ray| ray.direction.dot(up) >= -1e-6), "{rays:?}");
                assert!(rays.refraction.is_none_or(|ray| ray.direction.dot(up) <= 1e-6), "{rays:?}");
            }
        }
    }

    #[test]
    fn a_rough_pane_spreads_light_about_the_way_straight_on() {
        let incoming = at_angle(20.0, true);
        let [(mirrored, _), (through, mean)] = through_microfacets(&rough(0.1, 1.0), &floor(false), incoming);
        assert_eq!(mirrored, 0.0);
        assert!((through - 1.0).abs() < 1e-5, "{through}");
        assert!(mean.normalize().dot(incoming) > 0.999 && mean.length() < 0.99, "{mean}");
    }
}
