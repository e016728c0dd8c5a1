//! What materials reflect beside diffuse light: all over, and at one place of a surface.

use std::sync::Arc;

use glam::Vec3;

use super::albedos::{Albedos, LEAST_ALBEDO, LEAST_COSINE, Shares, VALUES};
use super::coat::{BelowCoat, CoatLayer, SeenCoat};
use super::fresnel::{Fresnel, dielectric};
use super::fuzz::SeenFuzz;
use super::hair::HairLobes;
use super::rough_diffuse::SeenRough;
use super::seen::{SeenBsdf, SurfaceAxes, facing};
use super::seen_by::{SeenBy, alpha_of_paths};
use super::stretched::{Stretch, Widths};
use super::upper::Upper;
use crate::scene::look::Varied;
use crate::scene::material::{Fuzz, LEAST_ALPHA, MetalRough};
use crate::shade::sampling::orthonormal;

/// What a material reflects beside diffuse light: its layer, and the coat above that.
#[derive(Debug, Clone)]
pub struct Bsdf {
    pub alpha: f32,
    /// Share of metal, from 0 to 1.
    pub metallic: f32,
    /// Reflectance of the metal at right angles: this, and `metal_of_kept` for each unit of the reflectance
    /// that samples store.
    pub metal: Vec3,
    pub metal_of_kept: Vec3,
    /// How white the metal is at grazing angles, from 0 (as at right angles) to 1.
    pub edge: f32,
    /// Index of refraction of the part that is not metal, 1 or more; it lets light through.
    pub index: f32,
    /// Share of light that does not pass straight through.
    pub solid: f32,
    /// Emission, which the layer does not dim.
    pub emission: Vec3,
    pub albedos: Arc<Albedos>,
    /// Alpha as paths see it that have been scattered before.
    pub alpha_of_paths: f32,
    pub albedos_of_paths: Arc<Albedos>,
    /// What of it varies, if anything does.
    pub varying: Option<VaryingBsdf>,
    /// Clear coat above all of that.
    pub coat: Option<CoatLayer>,
    /// Fuzz above all.
    pub fuzz: Option<Fuzz>,
    /// Fibres in place of all of that.
    pub hair: Option<HairLobes>,
    /// Roughness of what is matt below the layer, from 0 to 1.
    pub diffuse_roughness: f32,
    /// How the layer's lobe is wider along the tangent than across it.
    pub stretch: Option<Stretch>,
}

impl Bsdf {
    /// Returns true if there is more than the layer: something above it, or what is below it is rough.
    #[inline(always)]
    pub fn has_more(&self) -> bool {
        let has_upper = self.coat.is_some() || self.fuzz.is_some();
        has_upper || self.diffuse_roughness > 0.0 || self.stretch.is_some() || self.hair.is_some()
    }

    /// The layer where these parameters are what varies of it.
    #[inline(always)]
    pub fn at(&self, varied: Varied) -> BsdfAt<'_> {
        match &self.varying {
            None => self.at_rest(),
            Some(varying) => self.varied_at(varying, varied),
        }
    }

    /// Not inlined: most layers are the same all over.
    #[inline(never)]
    fn varied_at<'a>(&'a self, varying: &'a VaryingBsdf, varied: Varied) -> BsdfAt<'a> {
        let VaryingBsdf { layer, is_glass, .. } = varying;
        let here = layer.at(varied);
        let MetalRough { metallic, solid, .. } = here;
        let plain = BsdfAt { metallic, solid, emission: varied.light_of(self.emission), ..self.at_rest() };
        let Some(tables) = &varying.by_roughness else { return plain };
        let (alpha, share) = (here.alpha(), varied.of_roughness());
        BsdfAt {
            alpha,
            albedos: Between::of(tables.each_ref().map(|[eye, _]| &**eye), share),
            alpha_of_paths: alpha_of_paths(alpha, *is_glass),
            albedos_of_paths: Between::of(tables.each_ref().map(|[_, paths]| &**paths), share),
            ..plain
        }
    }

    /// The layer with the material's own parameters.
    #[inline(always)]
    fn at_rest(&self) -> BsdfAt<'_> {
        BsdfAt {
            bsdf: self,
            alpha: self.alpha,
            metallic: self.metallic,
            solid: self.solid,
            emission: self.emission,
            albedos: Between::one(&self.albedos),
            alpha_of_paths: self.alpha_of_paths,
            albedos_of_paths: Between::one(&self.albedos_of_paths),
        }
    }
}

/// What varies of a layer from place to place.
#[derive(Debug, Clone)]
pub struct VaryingBsdf {
    /// The layer where all factors are 1.
    pub layer: MetalRough,
    /// True if it is rough glass.
    pub is_glass: bool,
    /// Light as the eye and as paths see it, for even steps of the roughness up to that, if it varies.
    pub by_roughness: Option<Box<[[Arc<Albedos>; 2]; ROUGHNESS_STEPS + 1]>>,
}

/// Steps of a roughness that varies between which light is interpolated.
pub const ROUGHNESS_STEPS: usize = 32;

/// A layer at one place.
#[derive(Debug, Clone, Copy)]
pub struct BsdfAt<'a> {
    /// What it has all over.
    pub bsdf: &'a Bsdf,
    /// Width of its lobe.
    pub alpha: f32,
    /// Share of metal.
    pub metallic: f32,
    /// Share of light that does not pass straight through.
    pub solid: f32,
    /// Emission, which the layer does not dim.
    pub emission: Vec3,
    /// Light that it reflects.
    pub albedos: Between<'a>,
    alpha_of_paths: f32,
    albedos_of_paths: Between<'a>,
}

/// Light of a layer between two that are known.
#[derive(Debug, Clone, Copy)]
pub struct Between<'a> {
    low: &'a Albedos,
    high: &'a Albedos,
    /// Way from one to the other, from 0 to 1.
    rest: f32,
}

impl<'a> Between<'a> {
    #[inline(always)]
    fn one(albedos: &'a Albedos) -> Self {
        Self { low: albedos, high: albedos, rest: 0.0 }
    }

    /// At a share, from 0 to 1, of the way through even steps.
    fn of(steps: [&'a Albedos; ROUGHNESS_STEPS + 1], share: f32) -> Self {
        let at = share * ROUGHNESS_STEPS as f32;
        let low = (at as usize).min(ROUGHNESS_STEPS - 1);
        Self { low: steps[low], high: steps[low + 1], rest: at - low as f32 }
    }

    /// See [`Albedos::at`].
    #[inline(always)]
    pub fn at(&self, cos: f32) -> [f32; VALUES] {
        let low = self.low.at(cos);
        if self.rest == 0.0 {
            return low;
        }
        let high = self.high.at(cos);
        std::array::from_fn(|of| low[of] + (high[of] - low[of]) * self.rest)
    }
}

impl BsdfAt<'_> {
    /// Width of the narrowest of its lobes that are not as good as mirrors, if there is one.
    #[inline(always)]
    pub fn alpha_of_rough(&self) -> Option<f32> {
        let own = Some(self.alpha).filter(|alpha| *alpha > LEAST_ALPHA);
        if !self.bsdf.has_more() {
            return own;
        }
        if let Some(hair) = &self.bsdf.hair {
            return Some(hair.alpha());
        }
        let narrowest = |alpha| self.bsdf.stretch.map_or(alpha, |stretch| stretch.widths(alpha).across);
        let own = own.filter(|_| self.reflects()).map(narrowest);
        let of_coat = self.bsdf.coat.as_ref().map(CoatLayer::alpha).filter(|alpha| *alpha > LEAST_ALPHA);
        let of_fuzz = self.bsdf.fuzz.map(|_| WIDEST);
        own.into_iter().chain(of_coat).chain(of_fuzz).reduce(f32::min)
    }

    /// What is above the layer as a ray sees it at this cosine, where the layer below reflects and lets through so much; `None` if nothing is.
    #[inline(never)]
    pub fn upper(&self, cos: f32, reflectance: Vec3, [albedo, through]: [Vec3; 2], seen_by: SeenBy) -> Upper {
        let Bsdf { coat, fuzz, .. } = self.bsdf;
        let coat = coat.as_ref().map_or(SeenCoat::NONE, |coat| {
            coat.seen(cos, self.below_coat(reflectance, albedo, through.x), seen_by).in_part(self.solid)
        });
        let fuzz = fuzz.map_or(SeenFuzz::NONE, |fuzz| SeenFuzz::new(&fuzz, cos).in_part(self.solid));
        Upper::new(coat, fuzz, albedo)
    }

    /// Widths of the layer's lobe where the round one has this `alpha`, and its axes; `None` if it is round, or as narrow as a mirror's.
    pub fn stretched(&self, alpha: f32, normal: Vec3, tangent: Vec3) -> Option<(Widths<f32>, [Vec3; 2])> {
        let stretch = self.bsdf.stretch.as_ref().filter(|_| alpha > LEAST_ALPHA)?;
        Some((stretch.widths(alpha), stretch.axes(normal, tangent)?))
    }

    /// Returns true if the layer reflects anything: that of what is matt does not.
    fn reflects(&self) -> bool {
        self.bsdf.index > 1.0 || self.metallic > 0.0
    }

    /// What is matt below the layer as a ray sees it at this cosine, if it is rough, with its albedo.
    pub fn rough(&self, cos: f32, reflectance: Vec3) -> Option<(SeenRough, Vec3)> {
        let roughness = self.bsdf.diffuse_roughness;
        let albedo = self.diffuse(reflectance);
        let share = (1.0 - self.metallic) * self.solid;
        (roughness > 0.0 && share > 0.0).then(|| (SeenRough::new(roughness, albedo / share, cos), albedo))
    }

    /// Albedo of what is matt below the layer; `reflectance` is what samples store.
    fn diffuse(&self, reflectance: Vec3) -> Vec3 {
        match self.bsdf.metal_of_kept {
            Vec3::ZERO => reflectance,
            metal => reflectance * metal * (1.0 - self.metallic),
        }
    }

    /// What is below its coat, where the layer reflects and lets through so much.
    pub fn below_coat(&self, reflectance: Vec3, albedo: Vec3, through: f32) -> BelowCoat {
        let diffuse = self.diffuse(reflectance);
        // what is no metal is matt for the most part
        let roughness = 1.0 - self.metallic * (1.0 - self.alpha.sqrt());
        BelowCoat { albedo: albedo + diffuse * through, roughness }
    }

    /// Reflectance of its microfacets; `reflectance` is what samples store.
    fn fresnel(&self, reflectance: Vec3) -> Fresnel<f32> {
        let metal = (self.bsdf.metal + self.bsdf.metal_of_kept * reflectance).min(Vec3::ONE);
        Fresnel {
            metal: metal.to_array(),
            edge: self.bsdf.edge,
            metallic: self.metallic,
            index: self.bsdf.index,
        }
    }

    /// Returns true if the layer is as good as a mirror.
    fn is_smooth(&self) -> bool {
        self.alpha <= LEAST_ALPHA
    }

    /// Albedo at normal incidence of what is rough, with that of the surface beneath, which is `diffuse`, as far as the layer lets light through.
    pub fn head_on_over(&self, reflectance: Vec3, diffuse: Vec3) -> Vec3 {
        if self.bsdf.hair.is_some() {
            return self.color_of_hair(reflectance);
        }
        let through = 1.0 - dielectric(self.bsdf.index, 1.0);
        let layer = Vec3::from(self.fresnel(reflectance).at(1.0)) * self.solid;
        if !self.bsdf.has_more() {
            return layer + diffuse * through;
        }
        let upper = self.upper(1.0, reflectance, [layer, Vec3::splat(through)], SeenBy::Eye);
        // of mirrors rays bring what they show
        let layer = if self.is_smooth() { Vec3::ZERO } else { layer };
        let of_coat = if upper.coat.is_smooth() { 0.0 } else { upper.coat.albedo };
        (layer + diffuse * through) * upper.lets_through + of_coat + upper.fuzz.albedo
    }

    /// Layer as a ray sees it: see [`Bsdfs::seen`](super::Bsdfs::seen).
    pub fn seen(
        &self,
        reflectance: Vec3,
        SurfaceAxes { normal, geometric_normal, tangent }: SurfaceAxes<Vec3>,
        incoming: Vec3,
        seen_by: SeenBy,
    ) -> SeenBsdf {
        if let Some(hair) = &self.bsdf.hair {
            return self.seen_hair(hair, reflectance, [normal, tangent], incoming);
        }
        let (alpha, albedos) = match seen_by {
            SeenBy::Eye => (self.alpha, &self.albedos),
            SeenBy::Path => (self.alpha_of_paths, &self.albedos_of_paths),
        };
        let normal = facing(normal, geometric_normal, -incoming);
        let stretched = self.stretched(alpha, normal, tangent);
        let [x, y] = stretched.map_or_else(|| orthonormal(normal), |(_, axes)| axes);
        let axes = [x, y, normal];
        let to_eye = axes.map(|axis| -axis.dot(incoming));
        let to_eye = Vec3::new(to_eye[0], to_eye[1], to_eye[2].max(LEAST_COSINE));
        // an eye in the surface sees it from no direction: treated as if above
        let to_eye = to_eye.try_normalize().unwrap_or(Vec3::Z);
        let fresnel = self.fresnel(reflectance);
        let shares = Shares::new(albedos.at(to_eye.z));
        let [once, albedo] = [shares.once(&fresnel), shares.in_all(&fresnel)].map(Vec3::from);
        // a surface that reflects nothing needs no factor
        let gain = Vec3::select(once.cmpgt(Vec3::splat(LEAST_ALBEDO)), albedo / once, Vec3::ONE);
        let through = (1.0 - shares.clear).clamp(0.0, 1.0);
        let seen = SeenBsdf {
            axes,
            to_eye,
            alpha,
            fresnel,
            gain: gain * self.solid,
            albedo: albedo * self.solid,
            through: Vec3::splat(through),
            added: self.emission * (1.0 - through),
            upper: None,
            widths: stretched.map(|(widths, _)| widths),
            hair: None,
        };
        if !self.bsdf.has_more() {
            return seen;
        }
        let upper = self.upper(to_eye.z, reflectance, [seen.albedo, seen.through], seen_by);
        let rough = self.rough(to_eye.z, reflectance);
        seen.with(upper, rough.map_or(Vec3::ONE, |(rough, _)| rough.shown), self.emission)
    }
}

impl BsdfAt<'_> {
    /// Colour that hair has in the end; `reflectance` is what samples store.
    fn color_of_hair(&self, reflectance: Vec3) -> Vec3 {
        Vec3::from(self.fresnel(reflectance).metal)
    }

    /// A fibre with these directions as a ray sees it.
    fn seen_hair(
        &self,
        hair: &HairLobes,
        reflectance: Vec3,
        [normal, tangent]: [Vec3; 2],
        incoming: Vec3,
    ) -> SeenBsdf {
        let along = tangent.try_normalize().unwrap_or_else(|| orthonormal(normal)[0]);
        let [across, up] = orthonormal(along);
        let axes = [along, across, up];
        let to_eye = -Vec3::from(axes.map(|axis| axis.dot(incoming)));
        // the sine of the angle between normal and eye, as seen along the fibre
        let flat = |direction: Vec3| (direction - along * along.dot(direction)).try_normalize();
        let offset = match (flat(normal), flat(-incoming)) {
            (Some(normal), Some(to_eye)) => normal.cross(to_eye).dot(along),
            _ => 0.0,
        };
        let hair = hair.seen(self.color_of_hair(reflectance), to_eye, offset);
        SeenBsdf {
            axes,
            to_eye,
            alpha: 1.0,
            fresnel: self.fresnel(reflectance),
            gain: Vec3::ZERO,
            albedo: hair.albedo(),
            through: Vec3::ONE,
            added: Vec3::ZERO,
            upper: None,
            widths: None,
            hair: Some(hair),
        }
    }
}

/// Width of the widest of lobes: that of fuzz, which is wider than any.
const WIDEST: f32 = 1.0;
