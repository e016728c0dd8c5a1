//! What eight surfaces reflect beside diffuse light, as the eye sees it.

use std::f32::consts::{FRAC_1_PI, PI};

use super::fresnel::Fresnel;
use super::fuzz::FuzzLobe;
use super::ggx;
use super::mis::mis_weight;
use super::rough_diffuse::RoughLanes;
use super::seen::SeenBsdf;
use super::stretched::StretchedLanes;
use super::upper::{Chances, Upper};
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::scene::material::LEAST_ALPHA;
use crate::shade::area::AreaRadiance;
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
#[derive(Debug, Clone)]
pub struct SeenBsdfs {
    pub(super) normal: Vec3x8,
    pub(super) to_eye: Vec3x8,
    pub(super) alpha: F32x8,
    pub(super) fresnel: Fresnel<F32x8>,
    pub(super) gain: Vec3x8,
    /// Share of scattered light that is let through to the eye.
    pub through: Vec3x8,
    /// Light to be added where `through` has dimmed emission.
    pub(super) added: Vec3x8,
    /// Number of rays by which what is rough of each reflects.
    pub(super) rays: F32x8,
    /// Normal, and direction to the eye, by which their directions were drawn.
    pub(super) drawn_for: [Vec3x8; 2],
    /// Mask of surfaces of which a ray shows what is a mirror.
    pub(super) is_followed: Mask,
    /// What is above the layers and below them, if there is more than these.
    pub(super) more: Option<More>,
}

/// Fibres of those of eight surfaces that are hair: as they are seen, and as they were when directions were drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct HairLanes {
    pub(super) seen: [Option<SeenBsdf>; LANES],
    pub(super) drawn: [Option<SeenBsdf>; LANES],
}

/// What eight surfaces have beside their layers. A lane without it reflects nothing.
#[derive(Debug, Clone)]
pub(super) struct More {
    /// Fibres, if any is hair.
    pub(super) hair: Option<Box<HairLanes>>,
    /// What is matt and rough below the layers, if anything is.
    pub(super) rough: Option<RoughLanes>,
    /// Lobes of the layers as they are seen, and as they were when directions were drawn, if any is not round.
    pub(super) stretched: Option<[StretchedLanes; 2]>,
    /// Widths of the coats' lobes, their indices of refraction, and the factors for light that they reflect once.
    pub(super) alpha: F32x8,
    pub(super) index: F32x8,
    pub(super) gain: F32x8,
    /// Lobes of fuzz, as they are seen and as they were when directions were drawn, and the light that they reflect.
    pub(super) fuzz: [FuzzLobe<F32x8>; 2],
    pub(super) gain_of_fuzz: Vec3x8,
    /// Chances with which directions were drawn by the lobes of coats, and of fuzz.
    pub(super) chances: [F32x8; 2],
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
        if !radiance.is_met {
            return F32x8::ONE;
        }
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
        let of_hair = more.hair.as_ref().map(|hair| hair.reflected(direction) * irradiance);
        let Some(radiance) = radiance else {
            let light = of_layer + of_coats + of_fuzz;
            return of_hair.map_or(light, |of_hair| light + of_hair);
        };
        let weight = self.weight_of_points(light_sample, &radiance, self.drawn_by_all(more, direction));
        // nothing else shows mirrors that no ray follows
        let weight_of = |alpha: F32x8| alpha.gt(least).select(weight, F32x8::ONE);
        let light = of_layer * weight_of(self.alpha) + of_coats * weight_of(more.alpha) + of_fuzz * weight;
        let light = of_hair.map_or(light, |of_hair| light + of_hair * weight);
        irradiance.is_some().select3(light, Vec3x8::ZERO)
    }

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
        let drawn = part(layer, of_layer) + part(coat, of_coat) + part(fuzz, of_fuzz);
        more.hair.as_ref().map_or(drawn, |hair| hair.drawn(direction, drawn))
    }
}

impl HairLanes {
    /// What the fibres send on of light from these directions, times the cosine, in the units of highlights; nothing of other surfaces.
    fn reflected(&self, direction: Vec3x8) -> Vec3x8 {
        let mut all = Vec3x8::ZERO;
        for (lane, seen) in self.seen.iter().enumerate() {
            if let Some(seen) = seen {
                all.set_lane(lane, seen.towards(direction.lane(lane)).0 * PI);
            }
        }
        all
    }

    /// Densities with which these directions were drawn; those of other surfaces as they are.
    fn drawn(&self, direction: Vec3x8, mut drawn: F32x8) -> F32x8 {
        for (lane, seen) in self.drawn.iter().enumerate() {
            if let Some(seen) = seen {
                drawn.set_lane(lane, seen.density(direction.lane(lane)));
            }
        }
        drawn
    }
}

impl More {
    pub(super) const NONE: Self = Self {
        hair: None,
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
    pub(super) fn set(&mut self, lane: usize, upper: &Upper) {
        let Upper { coat, fuzz, .. } = upper;
        self.alpha.set_lane(lane, coat.alpha);
        self.index.set_lane(lane, coat.index);
        self.gain.set_lane(lane, coat.gain * PI);
        self.gain_of_fuzz.set_lane(lane, fuzz.albedo * PI);
        set_lobe(&mut self.fuzz[0], lane, fuzz.lobe);
        self.set_drawn(lane, upper, upper.chances);
    }

    /// Sets the lobes and chances by which the directions of a lane were drawn.
    pub(super) fn set_drawn(&mut self, lane: usize, upper: &Upper, chances: Chances) {
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
