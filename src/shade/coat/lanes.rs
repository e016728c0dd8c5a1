//! Layers of eight surfaces at a time, as the eye sees them.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use super::albedos::{LEAST_COSINE, Shares};
use super::layer::{Between, CoatAt, LEAST_ALBEDO};
use crate::lanes::{F32x8, LANES, Mask, Vec3x8, are_same};
use crate::scene::look::Look;
use crate::shade::area::AreaRadiance;
use crate::shade::fresnel::Fresnel;
use crate::shade::ggx;
use crate::shade::light::LightSample;
use crate::shade::mis::mis_weight;

/// Rays by which the layers of eight surfaces reflect.
#[derive(Debug, Clone, Copy)]
pub struct LayerRays {
    /// Number of rays that each reflects.
    pub count: [u32; LANES],
    /// Direction along which each was seen when their directions were drawn; unit length.
    pub incoming: Vec3x8,
}

/// Layers of eight surfaces, each as a ray sees it. A lane without one reflects nothing and lets everything
/// through.
#[derive(Debug, Clone, Copy)]
pub struct SeenCoats {
    normal: Vec3x8,
    to_eye: Vec3x8,
    alpha: F32x8,
    fresnel: Fresnel<F32x8>,
    gain: Vec3x8,
    /// Share of scattered light that the layer lets through to the eye.
    pub through: F32x8,
    /// Light to be added where `through` has dimmed emission.
    added: Vec3x8,
    /// Number of rays by which each reflects.
    rays: F32x8,
    /// Normal, and direction to the eye, by which their directions were drawn.
    drawn_for: [Vec3x8; 2],
    /// Mask of mirrors whose reflection is shown by a ray alone.
    is_followed_alone: Mask,
}

impl SeenCoats {
    /// Dims scattered light by the layer; `light` includes emission, which stays as it is.
    #[inline(always)]
    pub fn show(&self, light: Vec3x8) -> Vec3x8 {
        light * self.through + self.added
    }

    /// Highlight of a light; where it has a size, of one of its points. Rays see a light that has a size,
    /// too: then the highlight is weighted by the balance heuristic, and `radiance` is that of the light as
    /// rays see it.
    #[inline(always)]
    pub fn highlight(&self, light_sample: &LightSample, radiance: Option<AreaRadiance>) -> Vec3x8 {
        let Self { alpha, fresnel, normal, to_eye, gain, drawn_for, .. } = *self;
        let LightSample { direction, irradiance, .. } = *light_sample;
        let reflected = ggx::reflected_lanes(alpha, &fresnel, normal, to_eye, direction);
        let mut light = reflected * gain * irradiance;
        if let Some(radiance) = radiance {
            // both densities times the irradiance: they would be infinite where it is next to nothing
            let by_points = density_of_points(&radiance, direction);
            let by_rays = self.rays * ggx::density_lanes(alpha, drawn_for[0], drawn_for[1], direction);
            light = light * mis_weight(by_points, by_rays * brightest(irradiance));
        }
        let shows = match radiance {
            Some(_) => gain.is_some() & !self.is_followed_alone & irradiance.is_some(),
            None => gain.is_some(),
        };
        shows.select3(light, Vec3x8::ZERO)
    }
}

impl SeenCoats {
    /// Notes the rays by which surfaces with these `normals` reflect.
    pub(super) fn follow(
        &mut self,
        [normal, geometric_normal]: [Vec3x8; 2],
        rays: LayerRays,
        is_rough: impl Fn(usize) -> bool,
    ) {
        for lane in (0..LANES).filter(|lane| rays.count[*lane] > 0) {
            if is_rough(lane) {
                self.rays.set_lane(lane, rays.count[lane] as f32);
            } else {
                self.is_followed_alone.set(lane);
            }
        }
        self.drawn_for = seen_from(normal, geometric_normal, rays.incoming);
    }
}

/// Normal of eight surfaces that are seen along `incoming`, and direction to the eye above it.
#[inline(always)]
fn seen_from(normal: Vec3x8, geometric_normal: Vec3x8, incoming: Vec3x8) -> [Vec3x8; 2] {
    let normal = facing_lanes(normal, geometric_normal, -incoming);
    let cos = -normal.dot(incoming);
    let to_eye = normal * (cos.max(F32x8::splat(LEAST_COSINE)) - cos) - incoming;
    [normal, to_eye.dot(to_eye).gt(F32x8::ZERO).select3(to_eye.normalize(), normal)]
}

/// Density of the directions to all points of a light together, for each unit of the irradiance of one of
/// them.
#[inline(always)]
fn density_of_points(radiance: &AreaRadiance, direction: Vec3x8) -> F32x8 {
    radiance.brightest_along(direction) * F32x8::splat(FRAC_1_PI)
}

#[inline(always)]
fn brightest(color: Vec3x8) -> F32x8 {
    color.x.max(color.y).max(color.z)
}

/// Layers of eight surfaces, side by side. A lane without one reflects nothing.
pub(super) struct CoatLanes<'a> {
    alpha: F32x8,
    metallic: F32x8,
    metal: Vec3x8,
    metal_of_kept: Vec3x8,
    index: F32x8,
    solid: F32x8,
    emission: Vec3x8,
    albedos: [Option<Between<'a>>; LANES],
    has: Mask,
}

impl<'a> CoatLanes<'a> {
    const NONE: Self = Self {
        alpha: F32x8::ONE,
        metallic: F32x8::ZERO,
        metal: Vec3x8::ZERO,
        metal_of_kept: Vec3x8::ZERO,
        index: F32x8::ONE,
        solid: F32x8::ZERO,
        emission: Vec3x8::ZERO,
        albedos: [None; LANES],
        has: Mask::NONE,
    };

    /// Layers of eight surfaces; `coat` looks up that of each.
    #[inline]
    pub(super) fn new(coat: impl Fn(Look) -> Option<CoatAt<'a>>, looks: &[Look; LANES]) -> Self {
        let mut lanes = Self::NONE;
        if are_same(looks) {
            if let Some(coat) = coat(looks[0]) {
                lanes.fill(&coat);
            }
            return lanes;
        }
        for (lane, look) in looks.iter().enumerate() {
            if let Some(coat) = coat(*look) {
                lanes.set(lane, &coat);
            }
        }
        lanes
    }

    /// Sets all lanes to the same layer.
    fn fill(&mut self, at: &CoatAt<'a>) {
        let coat = at.coat;
        *self = Self {
            alpha: F32x8::splat(at.alpha),
            metallic: F32x8::splat(at.metallic),
            metal: Vec3x8::splat(coat.metal),
            metal_of_kept: Vec3x8::splat(coat.metal_of_kept),
            index: F32x8::splat(coat.index),
            solid: F32x8::splat(at.solid),
            emission: Vec3x8::splat(at.emission),
            albedos: [Some(at.albedos); LANES],
            has: Mask::ALL,
        };
    }

    fn set(&mut self, lane: usize, at: &CoatAt<'a>) {
        let coat = at.coat;
        self.alpha.set_lane(lane, at.alpha);
        self.metallic.set_lane(lane, at.metallic);
        self.metal.set_lane(lane, coat.metal);
        self.metal_of_kept.set_lane(lane, coat.metal_of_kept);
        self.index.set_lane(lane, coat.index);
        self.solid.set_lane(lane, at.solid);
        self.emission.set_lane(lane, at.emission);
        self.albedos[lane] = Some(at.albedos);
        self.has.set(lane);
    }

    /// Layers as the eye sees them: [`CoatAt::seen`] for eight surfaces.
    #[inline]
    pub(super) fn seen(
        &self,
        reflectance: Vec3x8,
        [normal, geometric_normal]: [Vec3x8; 2],
        incoming: Vec3x8,
    ) -> SeenCoats {
        let Self { alpha, metallic, index, solid, has, .. } = *self;
        let [normal, to_eye] = seen_from(normal, geometric_normal, incoming);
        let metal = (self.metal + self.metal_of_kept * reflectance).min(Vec3x8::splat(Vec3::ONE));
        let fresnel = Fresnel { metal: metal.into(), metallic, index };
        let shares = self.shares_at(normal.dot(to_eye));
        let [once, albedo] = [shares.once(&fresnel), shares.in_all(&fresnel)].map(Vec3x8::from);
        let gain = |albedo: F32x8, once: F32x8| {
            // a surface that reflects nothing needs no factor
            once.gt(F32x8::splat(LEAST_ALBEDO)).select(albedo / once, F32x8::ONE) * solid * F32x8::splat(PI)
        };
        let gain = Vec3x8 { x: gain(albedo.x, once.x), y: gain(albedo.y, once.y), z: gain(albedo.z, once.z) };
        let through = (F32x8::ONE - shares.clear).max(F32x8::ZERO).min(F32x8::ONE);
        SeenCoats {
            normal,
            to_eye,
            alpha,
            fresnel,
            gain: has.select3(gain, Vec3x8::ZERO),
            through: has.select(through, F32x8::ONE),
            added: has.select3(self.emission * (F32x8::ONE - through), Vec3x8::ZERO),
            rays: F32x8::ZERO,
            drawn_for: [normal, to_eye],
            is_followed_alone: Mask::NONE,
        }
    }

    /// [`Albedos::at`](super::albedos::Albedos::at) the cosines of eight surfaces.
    #[inline]
    fn shares_at(&self, cos: F32x8) -> Shares<F32x8> {
        let mut all = Shares::<F32x8>::none();
        for (lane, albedos) in self.albedos.iter().enumerate() {
            let Some(albedos) = albedos else { continue };
            let of_lane = albedos.at(cos.lane(lane));
            all.iter_mut().zip(of_lane).for_each(|(all, value)| all.set_lane(lane, value));
        }
        Shares::new(all)
    }
}

/// [`facing`](super::layer::facing) for eight surfaces.
#[inline(always)]
fn facing_lanes(normal: Vec3x8, geometric_normal: Vec3x8, to_eye: Vec3x8) -> Vec3x8 {
    let cos = normal.dot(to_eye);
    let mirrored = normal * (cos + cos) - to_eye;
    let faces = cos.gt(F32x8::ZERO) & mirrored.dot(geometric_normal).gt(F32x8::ZERO);
    faces.select3(normal, geometric_normal)
}

#[cfg(test)]
mod tests {
    use super::super::tests::material;
    use super::super::{Coats, SeenBy};
    use super::*;
    use crate::scene::Material;
    use crate::shade::area::Beam;
    use crate::shade::sampling::PathRandom;

    #[test]
    fn one_surface_and_eight_are_the_same() {
        let materials = [material(0.4, 0.8, 0.6), Material::fallback()];
        let coats = Coats::new(&materials);
        let numbers = [0, 1, 0, 0, 1, 0, 0, 0];
        let [normal, incoming] = [Vec3::Y, Vec3::new(0.6, -0.8, 0.0)];
        let light = Vec3::new(0.36, 0.8, 0.48).normalize();
        let lanes = |v: Vec3| Vec3x8::splat(v);
        let eight = coats.seen_lanes(
            &numbers.map(Look::plain),
            lanes(Vec3::ZERO),
            [lanes(normal); 2],
            lanes(incoming),
            None,
        );
        let eight = eight.expect("some have one");
        let sample = LightSample {
            to_light: lanes(light),
            direction: lanes(light),
            far: 1.0,
            irradiance: lanes(Vec3::ONE / PI),
            reaches: Mask::ALL,
        };
        let one =
            coats.seen(Look::plain(0), Vec3::ZERO, [normal; 2], incoming, SeenBy::Eye).expect("it has one");
        let highlight = eight.highlight(&sample, None);
        let (wanted, density) = one.highlight(light, Vec3::ONE / PI);
        assert!((highlight.lane(2) - wanted).abs().max_element() < 1e-4 * wanted.max_element(), "{wanted}");
        assert_eq!(highlight.lane(1), Vec3::ZERO);
        // rays see a part of a light with a size: of this radiance all points together are as dense as 2
        let followed = coats.seen_lanes(
            &numbers.map(Look::plain),
            lanes(Vec3::ZERO),
            [lanes(normal); 2],
            lanes(incoming),
            Some(LayerRays { count: [3; LANES], incoming: lanes(incoming) }),
        );
        let weighed = followed
            .expect("some have one")
            .highlight(&sample, Some(AreaRadiance { full: Vec3::splat(2.0), beam: Beam::Even }))
            .lane(2);
        let share = 2.0 / (2.0 + 3.0 * density);
        assert!((weighed - wanted * share).abs().max_element() < 1e-4 * wanted.max_element(), "{weighed}");
        let shown = eight.show(lanes(Vec3::ONE));
        assert!((shown.lane(3).x - one.through).abs() < 1e-6 && shown.lane(4) == Vec3::ONE);
        assert!(
            coats
                .seen_lanes(
                    &[Look::plain(1); 8],
                    lanes(Vec3::ZERO),
                    [lanes(normal); 2],
                    lanes(incoming),
                    None
                )
                .is_none()
        );
    }

    /// Checks materials of every kind, seen from all sides, at grazing angles and from below too.
    #[test]
    fn eight_different_surfaces_are_seen_as_each_is_alone() {
        let materials = [(0.0, 1.0, 0.9), (0.3, 0.0, 0.5), (0.7, 0.6, 0.2), (1.0, 1.0, 0.0)]
            .map(|(roughness, metallic, base)| material(roughness, metallic, base));
        let coats = Coats::new(&[materials.as_slice(), &[Material::fallback()]].concat());
        for round in 0..200_u32 {
            let numbers: [u16; LANES] = std::array::from_fn(|lane| ((round + lane as u32 * 3) % 5) as u16);
            let any = |lane: usize, which: u32| {
                let [x, y, z, _] = PathRandom::new(round, lane as u32 * 4 + which).four(0);
                (Vec3::new(x, y, z) * 2.0 - 1.0).normalize_or(Vec3::X)
            };
            let [mut normal, mut geometric, mut incoming] = [Vec3x8::ZERO; 3];
            for lane in 0..LANES {
                geometric.set_lane(lane, any(lane, 0));
                normal.set_lane(lane, (any(lane, 0) + 0.3 * any(lane, 1)).normalize());
                incoming.set_lane(lane, any(lane, 2));
            }
            let reflectance = Vec3x8::splat(Vec3::new(0.2, 0.5, 0.9));
            let eight =
                coats.seen_lanes(&numbers.map(Look::plain), reflectance, [normal, geometric], incoming, None);
            let eight = eight.expect("some have one");
            for (lane, number) in numbers.iter().enumerate() {
                let normals = [normal.lane(lane), geometric.lane(lane)];
                let one = coats.seen(
                    Look::plain(*number),
                    reflectance.lane(lane),
                    normals,
                    incoming.lane(lane),
                    SeenBy::Eye,
                );
                let (through, gain) = one.map_or((1.0, Vec3::ZERO), |one| (one.through, one.gain * PI));
                let off = (eight.gain.lane(lane) - gain).abs().max_element();
                assert!((eight.through.lane(lane) - through).abs() < 1e-5, "round {round}, lane {lane}");
                assert!(off < 1e-4 * gain.max_element().max(1.0), "round {round}, lane {lane}: {off}");
            }
        }
    }

    #[test]
    fn emission_is_not_dimmed() {
        let glowing = Material { emission: Vec3::new(3.0, 2.0, 1.0), ..material(0.4, 0.0, 0.5) };
        let coats = Coats::new(std::slice::from_ref(&glowing));
        let [up, down] = [Vec3::Z, Vec3::NEG_Z].map(Vec3x8::splat);
        let seen =
            coats.seen_lanes(&[Look::plain(0); 8], Vec3x8::ZERO, [up; 2], down, None).expect("all have one");
        assert_eq!(seen.show(Vec3x8::splat(glowing.emission)).lane(0), glowing.emission);
    }
}
