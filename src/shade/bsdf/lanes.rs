//! Layers of eight surfaces at a time, as the eye sees them.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use super::albedos::{LEAST_ALBEDO, LEAST_COSINE, Shares};
use super::fuzz::FuzzLobe;
use super::rough_diffuse::{RoughLanes, SeenRough};
use super::seen::{Between, BsdfAt, SurfaceAxes};
use super::seen_by::SeenBy;
use super::stretched::{StretchedLanes, Widths};
use super::upper::{Chances, Upper};
use crate::lanes::{F32x8, LANES, Mask, Vec3x8, are_same};
use crate::scene::look::Look;
use crate::scene::material::LEAST_ALPHA;
use crate::shade::area::AreaRadiance;
use crate::shade::bsdf::fresnel::Fresnel;
use crate::shade::bsdf::ggx;
use crate::shade::bsdf::mis::mis_weight;
use crate::shade::light::LightSample;

/// Rays by which eight surfaces reflect.
#[derive(Debug, Clone, Copy)]
pub struct LayerRays {
    /// Number of rays by which what is rough of each reflects.
    pub count: [u32; LANES],
    /// Bit mask of surfaces of which a ray shows what is a mirror.
    pub followed: u8,
    /// Direction along which each was seen when the directions of rough reflections were drawn; unit length.
    pub incoming: Vec3x8,
}

/// What eight surfaces reflect beside diffuse light, each as a ray sees it. A lane without a layer reflects nothing and lets everything
/// through.
#[derive(Debug, Clone, Copy)]
pub struct SeenBsdfs {
    normal: Vec3x8,
    to_eye: Vec3x8,
    alpha: F32x8,
    fresnel: Fresnel<F32x8>,
    gain: Vec3x8,
    /// Share of scattered light that is let through to the eye.
    pub through: Vec3x8,
    /// Light to be added where `through` has dimmed emission.
    added: Vec3x8,
    /// Number of rays by which what is rough of each reflects.
    rays: F32x8,
    /// Normal, and direction to the eye, by which their directions were drawn.
    drawn_for: [Vec3x8; 2],
    /// Mask of surfaces of which a ray shows what is a mirror.
    is_followed: Mask,
    /// What is above the layers and below them, if there is more than these.
    more: Option<More>,
}

/// What eight surfaces have beside their layers. A lane without it reflects nothing.
#[derive(Debug, Clone, Copy)]
struct More {
    /// What is matt and rough below the layers, if anything is.
    rough: Option<RoughLanes>,
    /// Lobes of the layers as they are seen, and as they were when directions were drawn, if any is not round.
    stretched: Option<[StretchedLanes; 2]>,
    /// Widths of the coats' lobes, their indices of refraction, and the factors for light that they reflect once.
    alpha: F32x8,
    index: F32x8,
    gain: F32x8,
    /// Lobes of fuzz, as they are seen and as they were when directions were drawn, and the light that they reflect.
    fuzz: [FuzzLobe<F32x8>; 2],
    gain_of_fuzz: Vec3x8,
    /// Chances with which directions were drawn by the lobes of coats, and of fuzz.
    chances: [F32x8; 2],
}

impl SeenBsdfs {
    /// Dims scattered light by what is above it; `light` includes emission, which stays as it is.
    #[inline(always)]
    pub fn show(&self, light: Vec3x8) -> Vec3x8 {
        light * self.through + self.added
    }

    /// Highlight of a light; where it has a size, of one of its points. Rays see a light that has a size,
    /// too: then the highlight is weighted by the balance heuristic, and `radiance` is that of the light as
    /// rays see it.
    #[inline(always)]
    pub fn highlight(&self, light_sample: &LightSample, radiance: Option<AreaRadiance>) -> Vec3x8 {
        if self.more.is_some() {
            return self.highlight_of_all(light_sample, radiance);
        }
        let Self { alpha, fresnel, normal, to_eye, gain, .. } = *self;
        let LightSample { direction, irradiance, .. } = *light_sample;
        let reflected = ggx::reflected_lanes(alpha, &fresnel, normal, to_eye, direction);
        let mut light = reflected * gain * irradiance;
        if let Some(radiance) = radiance {
            let [normal, to_eye] = self.drawn_for;
            let drawn = ggx::density_lanes(alpha, normal, to_eye, direction);
            light = light * self.weight_of_points(light_sample, &radiance, drawn);
        }
        let shows = match radiance {
            Some(_) => gain.is_some() & !self.is_followed & irradiance.is_some(),
            None => gain.is_some(),
        };
        shows.select3(light, Vec3x8::ZERO)
    }

    /// Returns true if what is matt of any is rough.
    #[inline(always)]
    pub fn is_matt_rough(&self) -> bool {
        self.more.as_ref().is_some_and(|more| more.rough.is_some())
    }

    /// Light that what is matt and rough shows of a light, or of one of its points, beyond what it would show of even light. Below 0 where
    /// it shows less.
    pub fn of_rough_matt(&self, light_sample: &LightSample) -> Vec3x8 {
        let Some(rough) = self.more.as_ref().and_then(|more| more.rough.as_ref()) else {
            return Vec3x8::ZERO;
        };
        let LightSample { direction, irradiance, .. } = *light_sample;
        irradiance
            .is_some()
            .select3(rough.beyond_smooth(self.normal, self.to_eye, direction) * irradiance, Vec3x8::ZERO)
    }

    /// Weight of a light's points beside the rays that see it, whose directions were `drawn` with this density.
    #[inline(always)]
    fn weight_of_points(&self, light_sample: &LightSample, radiance: &AreaRadiance, drawn: F32x8) -> F32x8 {
        let LightSample { direction, irradiance, .. } = *light_sample;
        // both densities times the irradiance: they would be infinite where it is next to nothing
        let by_points = density_of_points(radiance, direction);
        mis_weight(by_points, self.rays * drawn * brightest(irradiance))
    }

    /// [`highlight`](Self::highlight) of surfaces some of which have more than a layer. Not inlined: hardly any has it.
    #[inline(never)]
    fn highlight_of_all(&self, light_sample: &LightSample, radiance: Option<AreaRadiance>) -> Vec3x8 {
        let Some(more) = &self.more else { return Vec3x8::ZERO };
        let Self { normal, to_eye, .. } = *self;
        let LightSample { direction, irradiance, .. } = *light_sample;
        let least = F32x8::splat(LEAST_ALPHA);
        // rays show the mirrors among lobes where they meet the light
        let shows = |alpha: F32x8| match radiance {
            Some(_) => (alpha.gt(least) | !self.is_followed) & irradiance.is_some(),
            None => Mask::ALL,
        };
        let lobe = |alpha: F32x8, fresnel: &Fresnel<F32x8>, gain: Vec3x8| {
            let reflected = ggx::reflected_lanes(alpha, fresnel, normal, to_eye, direction) * gain;
            (gain.is_some() & shows(alpha)).select3(reflected, Vec3x8::ZERO)
        };
        let mut of_layer = lobe(self.alpha, &self.fresnel, self.gain);
        if let Some([seen, _]) = &more.stretched {
            let ([shape, _], cos) = seen.towards(normal, to_eye, direction);
            let reflected = Vec3x8::from(self.fresnel.at(cos)) * shape * self.gain;
            let is_shown = self.gain.is_some() & shows(self.alpha);
            // a round lobe is computed as it is where no other is beside it, so that it has the same bits
            of_layer = seen.is_stretched.select3(is_shown.select3(reflected, Vec3x8::ZERO), of_layer);
        }
        let of_coats = lobe(more.alpha, &more.fresnel(), Vec3x8::all_of(more.gain));
        let of_fuzz = more.gain_of_fuzz * density_of_fuzz(&more.fuzz[0], [normal, to_eye], direction);
        // in this order, as layers alone are
        let [of_layer, of_coats, of_fuzz] = [of_layer, of_coats, of_fuzz].map(|light| light * irradiance);
        let Some(radiance) = radiance else { return of_layer + of_coats + of_fuzz };
        let weight = self.weight_of_points(light_sample, &radiance, self.drawn_by_all(more, direction));
        // nothing else shows mirrors that no ray follows
        let weight_of = |alpha: F32x8| alpha.gt(least).select(weight, F32x8::ONE);
        let light = of_layer * weight_of(self.alpha) + of_coats * weight_of(more.alpha) + of_fuzz * weight;
        irradiance.is_some().select3(light, Vec3x8::ZERO)
    }
}

impl SeenBsdfs {
    /// Density with which directions were drawn by all lobes that are not mirrors.
    fn drawn_by_all(&self, more: &More, direction: Vec3x8) -> F32x8 {
        let [normal, to_eye] = self.drawn_for;
        let mut of_layer = ggx::density_lanes(self.alpha, normal, to_eye, direction);
        if let Some([_, drawn]) = &more.stretched {
            let ([_, stretched], _) = drawn.towards(normal, to_eye, direction);
            of_layer = drawn.is_stretched.select(stretched, of_layer);
        }
        let of_coat = ggx::density_lanes(more.alpha, normal, to_eye, direction);
        let of_fuzz = density_of_fuzz(&more.fuzz[1], self.drawn_for, direction);
        let [coat, fuzz] = more.chances;
        let layer = F32x8::ONE - coat - fuzz;
        // mirrors have no part in what is drawn: their chance is 0
        let part =
            |chance: F32x8, density: F32x8| chance.gt(F32x8::ZERO).select(density * chance, F32x8::ZERO);
        part(layer, of_layer) + part(coat, of_coat) + part(fuzz, of_fuzz)
    }
}

impl More {
    const NONE: Self = Self {
        rough: None,
        stretched: None,
        alpha: F32x8::ONE,
        index: F32x8::ONE,
        gain: F32x8::ZERO,
        fuzz: [FuzzLobe { scale: F32x8::ONE, shear: F32x8::ZERO }; 2],
        gain_of_fuzz: Vec3x8::ZERO,
        chances: [F32x8::ZERO; 2],
    };

    fn fresnel(&self) -> Fresnel<F32x8> {
        Fresnel { metal: [F32x8::ZERO; 3], edge: F32x8::ONE, metallic: F32x8::ZERO, index: self.index }
    }

    /// Sets what is above the layer in a lane.
    fn set(&mut self, lane: usize, upper: &Upper) {
        let Upper { coat, fuzz, .. } = upper;
        self.alpha.set_lane(lane, coat.alpha);
        self.index.set_lane(lane, coat.index);
        self.gain.set_lane(lane, coat.gain * PI);
        self.gain_of_fuzz.set_lane(lane, fuzz.albedo * PI);
        set_lobe(&mut self.fuzz[0], lane, fuzz.lobe);
        self.set_drawn(lane, upper, upper.chances);
    }

    /// Sets the lobes and chances by which the directions of a lane were drawn.
    fn set_drawn(&mut self, lane: usize, upper: &Upper, chances: Chances) {
        set_lobe(&mut self.fuzz[1], lane, upper.fuzz.lobe);
        self.chances[0].set_lane(lane, chances.coat);
        self.chances[1].set_lane(lane, chances.fuzz);
    }
}

fn set_lobe(lobes: &mut FuzzLobe<F32x8>, lane: usize, lobe: FuzzLobe<f32>) {
    lobes.scale.set_lane(lane, lobe.scale);
    lobes.shear.set_lane(lane, lobe.shear);
}

/// Density of lobes of fuzz, above surfaces with this normal and direction to the eye.
fn density_of_fuzz(lobe: &FuzzLobe<F32x8>, [normal, to_eye]: [Vec3x8; 2], direction: Vec3x8) -> F32x8 {
    let (of_eye, of_light) = (normal.dot(to_eye), normal.dot(direction));
    let density = lobe.density(of_eye, of_light, to_eye.dot(direction));
    (of_eye.gt(F32x8::ZERO) & of_light.gt(F32x8::ZERO)).select(density, F32x8::ZERO)
}

impl SeenBsdfs {
    /// Notes the rays by which surfaces with these `normals` and reflectances, which are of `layers`, reflect.
    pub(super) fn follow(
        &mut self,
        (layers, reflectance): (&BsdfLanes, Vec3x8),
        SurfaceAxes { normal, geometric_normal, tangent }: SurfaceAxes<Vec3x8>,
        rays: LayerRays,
    ) {
        self.rays = F32x8::new(rays.count.map(|count| count as f32));
        self.is_followed = Mask::from_bits(rays.followed);
        self.drawn_for = seen_from(normal, geometric_normal, rays.incoming);
        if let Some(more) = &mut self.more {
            let [normal, to_eye] = self.drawn_for;
            if let (Some([_, drawn]), Some(stretched)) =
                (&mut more.stretched, layers.stretched(normal, tangent))
            {
                *drawn = stretched;
            }
            let cos = normal.dot(to_eye);
            let [_, albedo, through] = layers.reflected(&self.fresnel, cos);
            for lane in 0..LANES {
                let drawn = layers.upper(lane, (cos, reflectance), [albedo, through]);
                let Some(drawn) = drawn else { continue };
                let is_rough = self.alpha.lane(lane) > LEAST_ALPHA;
                let of_layer = if is_rough { albedo.lane(lane) * drawn.lets_through } else { Vec3::ZERO };
                more.set_drawn(lane, &drawn, drawn.rough().chances_above(of_layer));
            }
        }
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
pub(super) struct BsdfLanes<'a> {
    alpha: F32x8,
    metallic: F32x8,
    metal: Vec3x8,
    metal_of_kept: Vec3x8,
    edge: F32x8,
    index: F32x8,
    solid: F32x8,
    emission: Vec3x8,
    albedos: [Option<Between<'a>>; LANES],
    has: Mask,
    /// Those that have more than a layer, if any has.
    more: Option<[Option<BsdfAt<'a>>; LANES]>,
}

impl<'a> BsdfLanes<'a> {
    const NONE: Self = Self {
        alpha: F32x8::ONE,
        metallic: F32x8::ZERO,
        metal: Vec3x8::ZERO,
        metal_of_kept: Vec3x8::ZERO,
        edge: F32x8::ONE,
        index: F32x8::ONE,
        solid: F32x8::ZERO,
        emission: Vec3x8::ZERO,
        albedos: [None; LANES],
        has: Mask::NONE,
        more: None,
    };

    /// Layers of eight surfaces; `bsdf` looks up that of each.
    #[inline]
    pub(super) fn new(bsdf: impl Fn(Look) -> Option<BsdfAt<'a>>, looks: &[Look; LANES]) -> Self {
        let mut lanes = Self::NONE;
        if are_same(looks) {
            if let Some(bsdf) = bsdf(looks[0]) {
                lanes.fill(&bsdf);
            }
            return lanes;
        }
        for (lane, look) in looks.iter().enumerate() {
            if let Some(bsdf) = bsdf(*look) {
                lanes.set(lane, &bsdf);
            }
        }
        lanes
    }

    /// Sets all lanes to the same layer.
    fn fill(&mut self, at: &BsdfAt<'a>) {
        let bsdf = at.bsdf;
        *self = Self {
            alpha: F32x8::splat(at.alpha),
            metallic: F32x8::splat(at.metallic),
            metal: Vec3x8::splat(bsdf.metal),
            metal_of_kept: Vec3x8::splat(bsdf.metal_of_kept),
            edge: F32x8::splat(bsdf.edge),
            index: F32x8::splat(bsdf.index),
            solid: F32x8::splat(at.solid),
            emission: Vec3x8::splat(at.emission),
            albedos: [Some(at.albedos); LANES],
            has: Mask::ALL,
            more: bsdf.has_more().then_some([Some(*at); LANES]),
        };
    }

    fn set(&mut self, lane: usize, at: &BsdfAt<'a>) {
        let bsdf = at.bsdf;
        self.alpha.set_lane(lane, at.alpha);
        self.metallic.set_lane(lane, at.metallic);
        self.metal.set_lane(lane, bsdf.metal);
        self.metal_of_kept.set_lane(lane, bsdf.metal_of_kept);
        self.edge.set_lane(lane, bsdf.edge);
        self.index.set_lane(lane, bsdf.index);
        self.solid.set_lane(lane, at.solid);
        self.emission.set_lane(lane, at.emission);
        self.albedos[lane] = Some(at.albedos);
        self.has.set(lane);
        if bsdf.has_more() {
            self.more.get_or_insert([None; LANES])[lane] = Some(*at);
        }
    }

    /// Layers as the eye sees them: [`BsdfAt::seen`] for eight surfaces.
    #[inline]
    pub(super) fn seen(
        &self,
        reflectance: Vec3x8,
        SurfaceAxes { normal, geometric_normal, tangent }: SurfaceAxes<Vec3x8>,
        incoming: Vec3x8,
    ) -> SeenBsdfs {
        let Self { alpha, metallic, index, has, .. } = *self;
        let [normal, to_eye] = seen_from(normal, geometric_normal, incoming);
        let metal = (self.metal + self.metal_of_kept * reflectance).min(Vec3x8::splat(Vec3::ONE));
        let fresnel = Fresnel { metal: metal.into(), edge: self.edge, metallic, index };
        let cos = normal.dot(to_eye);
        let [gain, albedo, through] = self.reflected(&fresnel, cos);
        let mut seen = SeenBsdfs {
            normal,
            to_eye,
            alpha,
            fresnel,
            gain: has.select3(gain, Vec3x8::ZERO),
            through: has.select3(through, Vec3x8::splat(Vec3::ONE)),
            added: has.select3(self.emission * (F32x8::ONE - through.x), Vec3x8::ZERO),
            rays: F32x8::ZERO,
            drawn_for: [normal, to_eye],
            is_followed: Mask::NONE,
            more: None,
        };
        if self.more.is_some() {
            self.add_more(&mut seen, (cos, reflectance), tangent, [albedo, through]);
        }
        seen
    }

    /// Factor for the light that microfacets of the layers reflect once, share of the light from all around that they reflect, and share of
    /// scattered light that they let through.
    #[inline(always)]
    fn reflected(&self, fresnel: &Fresnel<F32x8>, cos: F32x8) -> [Vec3x8; 3] {
        let solid = self.solid;
        let shares = self.shares_at(cos);
        let [once, albedo] = [shares.once(fresnel), shares.in_all(fresnel)].map(Vec3x8::from);
        let gain = |albedo: F32x8, once: F32x8| {
            // a surface that reflects nothing needs no factor
            once.gt(F32x8::splat(LEAST_ALBEDO)).select(albedo / once, F32x8::ONE) * solid * F32x8::splat(PI)
        };
        let gain = Vec3x8 { x: gain(albedo.x, once.x), y: gain(albedo.y, once.y), z: gain(albedo.z, once.z) };
        let through = (F32x8::ONE - shares.clear).max(F32x8::ZERO).min(F32x8::ONE);
        [gain, albedo * solid, Vec3x8::all_of(through)]
    }

    /// What is above the layer in a lane, as it is seen at these cosines: `below` are the albedo and what is let through of layers with nothing
    /// above them. `None` if nothing is.
    fn upper(&self, lane: usize, (cos, reflectance): (F32x8, Vec3x8), below: [Vec3x8; 2]) -> Option<Upper> {
        let at = self.more.as_ref()?[lane].as_ref()?;
        let below = below.map(|all| all.lane(lane));
        Some(at.upper(cos.lane(lane), reflectance.lane(lane), below, SeenBy::Eye))
    }

    /// Puts what is above layers and below them there.
    #[inline(never)]
    fn add_more(&self, seen: &mut SeenBsdfs, at: (F32x8, Vec3x8), tangent: Vec3x8, below: [Vec3x8; 2]) {
        let stretched = self.stretched(seen.normal, tangent);
        let mut more = More { stretched: stretched.map(|lanes| [lanes; 2]), ..More::NONE };
        let [mut lets_through, mut shown] = [Vec3x8::splat(Vec3::ONE); 2];
        for lane in 0..LANES {
            let Some(upper) = self.upper(lane, at, below) else { continue };
            more.set(lane, &upper);
            lets_through.set_lane(lane, upper.lets_through);
            if let Some((rough, albedo)) = self.rough(lane, at) {
                let through = below[1].lane(lane) * upper.lets_through;
                more.rough.get_or_insert(RoughLanes::NONE).set(lane, &rough, albedo * through);
                shown.set_lane(lane, rough.shown);
            }
        }
        seen.gain = seen.gain * lets_through;
        seen.through = seen.through * lets_through * shown;
        let dimmed = Vec3x8::splat(Vec3::ONE) - seen.through;
        seen.added = self.has.select3(self.emission * dimmed, Vec3x8::ZERO);
        seen.more = Some(more);
    }

    /// Lobes of the layers on surfaces with these normals and tangents, if any is not round.
    fn stretched(&self, normal: Vec3x8, tangent: Vec3x8) -> Option<StretchedLanes> {
        let all = self.more.as_ref()?;
        let found: [Option<(Widths<f32>, [Vec3; 2])>; LANES] = std::array::from_fn(|lane| {
            all[lane].as_ref()?.stretched(self.alpha.lane(lane), normal.lane(lane), tangent.lane(lane))
        });
        if found.iter().all(Option::is_none) {
            return None;
        }
        let mut lanes = StretchedLanes::ROUND;
        for (lane, found) in found.into_iter().enumerate() {
            if let Some((widths, axes)) = found {
                lanes.set(lane, widths, axes);
            }
        }
        Some(lanes)
    }

    /// What is matt and rough in a lane, with its albedo.
    fn rough(&self, lane: usize, (cos, reflectance): (F32x8, Vec3x8)) -> Option<(SeenRough, Vec3)> {
        self.more.as_ref()?[lane].as_ref()?.rough(cos.lane(lane), reflectance.lane(lane))
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

/// [`facing`](super::seen::facing) for eight surfaces.
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
    use super::super::{Bsdfs, SeenBy};
    use super::*;
    use crate::scene::Material;
    use crate::shade::area::Beam;
    use crate::shade::sampling::PathRandom;

    #[test]
    fn one_surface_and_eight_are_the_same() {
        let materials = [material(0.4, 0.8, 0.6), Material::fallback()];
        let bsdfs = Bsdfs::new(&materials);
        let numbers = [0, 1, 0, 0, 1, 0, 0, 0];
        let [normal, incoming] = [Vec3::Y, Vec3::new(0.6, -0.8, 0.0)];
        let light = Vec3::new(0.36, 0.8, 0.48).normalize();
        let lanes = |v: Vec3| Vec3x8::splat(v);
        let eight = bsdfs.seen_lanes(
            &numbers.map(Look::plain),
            lanes(Vec3::ZERO),
            SurfaceAxes::of_normals([lanes(normal); 2]),
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
        let one = bsdfs
            .seen(Look::plain(0), Vec3::ZERO, SurfaceAxes::of_normals([normal; 2]), incoming, SeenBy::Eye)
            .expect("it has one");
        let highlight = eight.highlight(&sample, None);
        let (wanted, density) = one.highlight(light, Vec3::ONE / PI, false);
        assert!((highlight.lane(2) - wanted).abs().max_element() < 1e-4 * wanted.max_element(), "{wanted}");
        assert_eq!(highlight.lane(1), Vec3::ZERO);
        // rays see a part of a light with a size: of this radiance all points together are as dense as 2
        let followed = bsdfs.seen_lanes(
            &numbers.map(Look::plain),
            lanes(Vec3::ZERO),
            SurfaceAxes::of_normals([lanes(normal); 2]),
            lanes(incoming),
            Some(LayerRays { count: [3; LANES], followed: 0, incoming: lanes(incoming) }),
        );
        let weighed = followed
            .expect("some have one")
            .highlight(&sample, Some(AreaRadiance { full: Vec3::splat(2.0), beam: Beam::Even }))
            .lane(2);
        let share = 2.0 / (2.0 + 3.0 * density);
        assert!((weighed - wanted * share).abs().max_element() < 1e-4 * wanted.max_element(), "{weighed}");
        let shown = eight.show(lanes(Vec3::ONE));
        assert!((shown.lane(3) - one.through).abs().max_element() < 1e-6 && shown.lane(4) == Vec3::ONE);
        assert!(
            bsdfs
                .seen_lanes(
                    &[Look::plain(1); 8],
                    lanes(Vec3::ZERO),
                    SurfaceAxes::of_normals([lanes(normal); 2]),
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
        let bsdfs = Bsdfs::new(&[materials.as_slice(), &[Material::fallback()]].concat());
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
            let eight = bsdfs.seen_lanes(
                &numbers.map(Look::plain),
                reflectance,
                SurfaceAxes::of_normals([normal, geometric]),
                incoming,
                None,
            );
            let eight = eight.expect("some have one");
            for (lane, number) in numbers.iter().enumerate() {
                let normals = [normal.lane(lane), geometric.lane(lane)];
                let one = bsdfs.seen(
                    Look::plain(*number),
                    reflectance.lane(lane),
                    SurfaceAxes::of_normals(normals),
                    incoming.lane(lane),
                    SeenBy::Eye,
                );
                let (through, gain) = one.map_or((Vec3::ONE, Vec3::ZERO), |one| (one.through, one.gain * PI));
                let off = (eight.through.lane(lane) - through).abs().max_element();
                assert!(off < 1e-5, "round {round}, lane {lane}: {off}");
                let off = (eight.gain.lane(lane) - gain).abs().max_element();
                assert!(off < 1e-4 * gain.max_element().max(1.0), "round {round}, lane {lane}: {off}");
            }
        }
    }

    #[test]
    fn emission_is_not_dimmed() {
        let glowing = Material { emission: Vec3::new(3.0, 2.0, 1.0), ..material(0.4, 0.0, 0.5) };
        let bsdfs = Bsdfs::new(std::slice::from_ref(&glowing));
        let [up, down] = [Vec3::Z, Vec3::NEG_Z].map(Vec3x8::splat);
        let seen = bsdfs
            .seen_lanes(&[Look::plain(0); 8], Vec3x8::ZERO, SurfaceAxes::of_normals([up; 2]), down, None)
            .expect("all have one");
        assert_eq!(seen.show(Vec3x8::splat(glowing.emission)).lane(0), glowing.emission);
    }
}
