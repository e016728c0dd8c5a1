//! Materials of a scene, ready for lighting: what they reflect of all light that comes from around, and their layers.

use glam::Vec3;

use super::Bsdfs;
use super::phong::Gloss;
use crate::lanes::{F32x8, Mask, Vec3x8};
use crate::scene::look::{Look, Varied};
use crate::scene::material::{MetalRough, Optics, Scattering};
use crate::scene::{Material, Scene};

/// Material as lighting needs it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Paint {
    /// Light that leaves the surface whatever the light sources and the eye: the sum of the next two.
    base: Vec3,
    /// Emission.
    emission: Vec3,
    /// Ambient light where no texture colours it.
    plain_ambient: Vec3,
    /// Ambient light, for each unit of reflectance: where a texture colours the diffuse light it colours the
    /// ambient one as well.
    ambient: Vec3,
    /// Diffuse reflectance, for each unit of reflectance: 1, or less where the ambient one is larger.
    diffuse: Vec3,
    /// Colour of the highlight.
    specular: Vec3,
    /// Exponent of the highlight.
    shininess: f32,
    /// True if rays go on from it.
    goes_on: bool,
    /// True if it is a mirror or glass.
    is_followed: bool,
    /// True if it reflects light diffusely at all.
    is_diffuse: bool,
    /// See [`Material::is_matt`].
    is_matt: bool,
    /// What of it varies, if anything does.
    varying: Option<VaryingPaint>,
    /// What goes below it; the mean free path is one of the space in which the shot is rendered.
    scattering: Option<Scattering>,
    /// What it absorbs of light on its way through it, for each unit of length in that space.
    absorption: Vec3,
}

/// What varies of a material from place to place.
#[derive(Debug, Clone, Copy, PartialEq)]
struct VaryingPaint {
    /// Share of metal, or of glass, if that varies: of what is neither the diffuse reflectance is a share.
    not_matt: Option<f32>,
    /// The same of glass alone: what is glass reflects no ambient light, and metal does.
    glass: Option<f32>,
    /// Its layer, if that may be a mirror in places.
    layer: Option<MetalRough>,
}

impl VaryingPaint {
    /// Share of the surface that reflects ambient light.
    #[inline(always)]
    fn lit(&self, varied: Varied) -> f32 {
        let matt = self.glass.map_or(1.0, |share| 1.0 - share * varied.of_metal());
        varied.of_opacity() * matt
    }
}

impl Paint {
    /// Diffuse reflectance, for each unit of reflectance, of a surface with these parameters.
    #[inline(always)]
    fn diffuse_at(&self, varied: Varied) -> Vec3 {
        match &self.varying {
            None => self.diffuse,
            Some(varying) => {
                let not_matt = varying.not_matt.map_or(0.0, |share| share * varied.of_metal());
                self.diffuse * ((1.0 - not_matt) * varied.of_opacity())
            }
        }
    }

    /// Light that leaves it whatever the light sources and the eye: what no reflectance colours, and that for each unit of reflectance.
    #[inline(always)]
    fn light_at(&self, varied: Varied) -> [Vec3; 2] {
        let Some(varying) = &self.varying else { return [self.base, self.ambient] };
        let opacity = varying.lit(varied);
        [varied.light_of(self.emission) + self.plain_ambient * opacity, self.ambient * opacity]
    }

    /// Emission; then ambient light as [`light_at`](Self::light_at) has it.
    #[inline(always)]
    fn apart_at(&self, varied: Varied) -> [Vec3; 3] {
        let Some(varying) = &self.varying else {
            return [self.emission, self.plain_ambient, self.ambient];
        };
        let opacity = varying.lit(varied);
        [varied.light_of(self.emission), self.plain_ambient * opacity, self.ambient * opacity]
    }

    /// Colour and exponent of the highlight there.
    #[inline(always)]
    fn highlight_at(&self, varied: Varied) -> (Vec3, f32) {
        if self.varying.is_none() || self.specular == Vec3::ZERO {
            return (self.specular, self.shininess);
        }
        let specular = self.specular * varied.of_highlight() * varied.of_opacity();
        (specular, (self.shininess * varied.of_roughness()).max(1.0))
    }

    /// Returns true if it is a mirror or glass there.
    #[inline(always)]
    fn is_followed_at(&self, varied: Varied) -> bool {
        let here = |varying: VaryingPaint| {
            varied.opacity < u8::MAX || varying.layer.is_some_and(|layer| layer.at(varied).is_smooth())
        };
        self.is_followed || self.varying.is_some_and(here)
    }

    /// Returns true if rays go on from it there.
    #[inline(always)]
    fn goes_on_at(&self, varied: Varied) -> bool {
        self.goes_on || self.is_followed_at(varied)
    }
}

/// Materials of a scene, ready for lighting.
#[derive(Debug, Clone)]
pub struct Palette {
    paints: Vec<Paint>,
    /// True if the reflectance that samples store is the diffuse one for all materials.
    all_diffuse: bool,
    /// Largest diffuse reflectance of any material, by channel; textures count as white.
    pub brightest: Vec3,
    /// Layers of metal-rough materials.
    pub bsdfs: Bsdfs,
    /// True if any material has a normal map.
    pub bends_normals: bool,
    /// True if any material has a picture that is filtered over the places that samples stand for.
    pub has_textures: bool,
    /// True if light goes below the surface of any material.
    pub scatters_below: bool,
    /// True if any material absorbs light on its way through it.
    pub absorbs: bool,
    /// True if any material has graphs, or shows the colours of vertices.
    pub varies: bool,
    /// True if graphs compute anything of any material: its colour, a parameter, heights.
    pub computes: bool,
    /// True if the lobe of any layer is not round: tangents count then.
    pub is_stretched: bool,
    /// True if any material is hair.
    pub has_hair: bool,
    /// True if anything of that depends on what sees a surface.
    pub is_of_eye: bool,
}

impl Palette {
    /// Creates the palette of all materials of `scene` in its ambient light.
    pub fn of(scene: &Scene) -> Self {
        Self::in_ambient(scene, scene.ambient)
    }

    /// Creates the palette of all materials of `scene` in this `ambient` light.
    pub fn in_ambient(scene: &Scene, ambient: Vec3) -> Self {
        let mut paints: Vec<Paint> =
            scene.materials.iter().map(|material| paint(material, ambient)).collect();
        let brightest = scene.materials.iter().fold(Vec3::ZERO, |most, one| most.max(one.most_diffuse()));
        let bends_normals = scene.materials.iter().any(Material::bends_normals);
        let is_varied = |one: &Material| one.has_vertex_colors || one.computed.is_some();
        let varies = scene.materials.iter().any(is_varied);
        let has_textures = scene.materials.iter().any(Material::is_filtered);
        let computes = scene.materials.iter().any(Material::has_graphs);
        let is_of_eye = scene.materials.iter().any(Material::is_of_eye);
        let bsdfs = Bsdfs::new(&scene.materials);
        let scatters_below = scene.materials.iter().any(|one| one.scattering.is_some());
        let absorbs = scene.materials.iter().any(|one| one.absorption != Vec3::ZERO);
        let to_world = scene.space.scale() as f32;
        for paint in &mut paints {
            paint.absorption /= to_world;
            if let Some(scattering) = &mut paint.scattering {
                scattering.radius *= to_world;
            }
        }
        Self {
            bsdfs,
            scatters_below,
            absorbs,
            is_stretched: scene.materials.iter().any(|one| one.anisotropy.is_some()),
            has_hair: scene.materials.iter().any(|one| one.hair.is_some()),
            brightest,
            bends_normals,
            has_textures,
            varies,
            computes,
            is_of_eye,
            ..Self::new(paints)
        }
    }

    fn new(paints: Vec<Paint>) -> Self {
        let is_diffuse = |paint: &Paint| paint.diffuse == Vec3::ONE && paint.varying.is_none();
        let all_diffuse = paints.iter().all(is_diffuse);
        Self {
            paints,
            all_diffuse,
            brightest: Vec3::ZERO,
            bsdfs: Bsdfs::default(),
            bends_normals: false,
            has_textures: false,
            scatters_below: false,
            absorbs: false,
            is_stretched: false,
            has_hair: false,
            varies: false,
            computes: false,
            is_of_eye: false,
        }
    }

    /// Returns true if any material asks for tangents.
    #[inline(always)]
    pub fn has_tangents(&self) -> bool {
        self.is_stretched | self.has_hair
    }

    /// Diffuse reflectance of eight surfaces, from the reflectance that samples store.
    #[inline(always)]
    pub fn albedo(&self, looks: &[Look], reflectance: Vec3x8) -> Vec3x8 {
        if self.all_diffuse {
            return reflectance;
        }
        let [share] = self.of_looks(looks, |paint, varied| [paint.diffuse_at(varied)]);
        reflectance * share
    }

    /// [`albedo`](Self::albedo) of one surface, to the bit.
    #[inline(always)]
    pub fn albedo_of(&self, Look { material, varied }: Look, reflectance: Vec3) -> Vec3 {
        if self.all_diffuse {
            return reflectance;
        }
        reflectance * self.paints[usize::from(material)].diffuse_at(varied)
    }

    /// What goes below such a surface, if light does.
    #[inline]
    pub fn scattering(&self, look: Look) -> Option<Scattering> {
        self.paints[usize::from(look.material)].scattering
    }

    /// Albedo of eight surfaces without what goes below them and through them.
    #[inline]
    pub fn at_surface(&self, looks: &[Look], albedo: Vec3x8) -> Vec3x8 {
        let [share] = self.of_looks(looks, |paint, _| {
            [paint.scattering.map_or(Vec3::ONE, |scattering| scattering.at_surface())]
        });
        albedo * share
    }

    /// What a material absorbs of light on its way through it: exponents for each unit of length, world space.
    #[inline]
    pub fn absorption(&self, material: u16) -> Vec3 {
        self.paints[usize::from(material)].absorption
    }

    /// Reflectance with which a surface would be white.
    pub fn white(&self, Look { material, varied }: Look) -> Vec3 {
        let share = self.paints[usize::from(material)].diffuse_at(varied);
        Vec3::select(share.cmpgt(Vec3::ZERO), share.recip(), Vec3::ZERO)
    }

    /// Returns true if a material reflects light diffusely at all.
    #[inline]
    pub fn is_diffuse(&self, material: u16) -> bool {
        self.paints[usize::from(material)].is_diffuse
    }

    /// Returns true if a material sends the same light to whoever looks, but for [mirrors and glass](Material::is_matt).
    #[inline]
    pub fn is_matt(&self, material: u16) -> bool {
        self.paints[usize::from(material)].is_matt
    }

    /// Returns true if rays go on from such a surface.
    #[inline]
    pub fn goes_on(&self, Look { material, varied }: Look) -> bool {
        self.paints[usize::from(material)].goes_on_at(varied)
    }

    /// Returns true if a material reflects ambient light.
    #[inline]
    pub fn has_ambient(&self, material: u16) -> bool {
        let Paint { plain_ambient, ambient, .. } = self.paints[usize::from(material)];
        plain_ambient != Vec3::ZERO || ambient != Vec3::ZERO
    }

    /// Light that leaves surfaces wherever the eye is: emission and ambient light.
    #[inline(always)]
    pub fn emitted_and_ambient(&self, looks: &[Look], reflectance: Vec3x8) -> Vec3x8 {
        let [base, ambient] = self.of_looks(looks, Paint::light_at);
        base + ambient * reflectance
    }

    /// Ambient light that leaves surfaces wherever the eye is, which `openness` dims.
    pub fn ambient_alone(&self, looks: &[Look], reflectance: Vec3x8, openness: F32x8) -> Vec3x8 {
        let [_, plain, ambient] = self.of_looks(looks, Paint::apart_at);
        (plain + ambient * reflectance) * openness
    }

    /// Emission and ambient light, where openness dims the latter.
    #[inline(always)]
    pub fn emitted_and_occluded(&self, looks: &[Look], reflectance: Vec3x8, openness: F32x8) -> Vec3x8 {
        let [emission, plain, ambient] = self.of_looks(looks, Paint::apart_at);
        emission + (plain + ambient * reflectance) * openness
    }

    /// Collects values of eight surfaces, side by side.
    #[inline(always)]
    fn of_looks<const N: usize>(
        &self,
        looks: &[Look],
        values: impl Fn(&Paint, Varied) -> [Vec3; N],
    ) -> [Vec3x8; N] {
        if let Some(paint) = self.one_for_all(looks) {
            return values(paint, looks[0].varied).map(Vec3x8::splat);
        }
        let mut all = [Vec3x8::ZERO; N];
        for (lane, look) in looks.iter().enumerate() {
            let values = values(&self.paints[usize::from(look.material)], look.varied);
            all.iter_mut().zip(values).for_each(|(all, value)| all.set_lane(lane, value));
        }
        all
    }

    /// Parameters of eight surfaces' highlights.
    #[inline(always)]
    pub fn gloss(&self, looks: &[Look]) -> Gloss {
        if let Some(paint) = self.one_for_all(looks) {
            let varied = looks[0].varied;
            let (specular, shininess) = paint.highlight_at(varied);
            return Gloss {
                specular: Vec3x8::splat(specular),
                shininess: F32x8::splat(shininess),
                is_any: specular != Vec3::ZERO,
                goes_on: if paint.goes_on_at(varied) { Mask::ALL } else { Mask::NONE },
                is_followed: if paint.is_followed_at(varied) { Mask::ALL } else { Mask::NONE },
            };
        }
        let (mut specular, mut shininess) = (Vec3x8::ZERO, F32x8::ZERO);
        let paint = |lane: usize| (&self.paints[usize::from(looks[lane].material)], looks[lane].varied);
        for lane in 0..looks.len() {
            let (paint, varied) = paint(lane);
            let (of_lane, exponent) = paint.highlight_at(varied);
            specular.set_lane(lane, of_lane);
            shininess.set_lane(lane, exponent);
        }
        let goes_on = Mask::new(|lane| paint(lane).0.goes_on_at(paint(lane).1));
        let is_followed = Mask::new(|lane| paint(lane).0.is_followed_at(paint(lane).1));
        Gloss { specular, shininess, is_any: specular.is_some().any(), goes_on, is_followed }
    }

    /// Material that all eight have in common, with the same parameters.
    #[inline(always)]
    fn one_for_all(&self, looks: &[Look]) -> Option<&Paint> {
        let first = looks[0];
        looks.iter().all(|look| *look == first).then(|| &self.paints[usize::from(first.material)])
    }
}

fn paint(material: &Material, light: Vec3) -> Paint {
    let painted = material.painted();
    let share = |of: Vec3| of / painted.max(Vec3::splat(f32::MIN_POSITIVE));
    let varying = material.varies().then(|| VaryingPaint {
        not_matt: material.share_that_is_not_matt(),
        glass: material.share_that_is_not_matt().filter(|_| material.uneven_glass.is_some()),
        layer: material.metal_rough.filter(|_| material.varies_in_roughness()),
    });
    let is_smooth = |layer: MetalRough| layer.is_smooth() && !material.varies_in_roughness();
    let full = material.most_diffuse();
    let (plain_ambient, ambient, diffuse) = if material.is_painted() {
        // a material that is black altogether may have any share
        let of_diffuse = Vec3::select(full.cmpeq(painted), Vec3::ONE, share(full));
        (Vec3::ZERO, share(material.ambient) * light, of_diffuse)
    } else {
        (material.ambient * light, Vec3::ZERO, Vec3::ONE)
    };
    Paint {
        base: material.emission + plain_ambient,
        emission: material.emission,
        plain_ambient,
        ambient,
        diffuse,
        specular: material.specular,
        shininess: material.shininess,
        goes_on: material.optics != Optics::Opaque || material.metal_rough.is_some(),
        is_followed: material.optics != Optics::Opaque
            || material.metal_rough.is_some_and(is_smooth)
            || material.coat.is_some_and(|coat| coat.is_smooth()),
        is_diffuse: full != Vec3::ZERO,
        is_matt: material.is_matt(),
        varying,
        scattering: material.scattering,
        absorption: material.absorption,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks diffuse and ambient reflectance and a texel against the diffuse reflectance, and the reflected share of an ambient light
    /// of 0.1. In all cases a sample stores the material's painted colour times the texel.
    #[test]
    fn a_texture_colours_diffuse_and_ambient_light_by_themselves() {
        let texel = Vec3::new(1.0, 0.5, 0.0);
        for (kd, ka, albedo, ambient) in [
            (0.5, 1.0, Vec3::new(0.5, 0.25, 0.0), Vec3::new(0.1, 0.05, 0.0)),
            (0.5, 0.25, Vec3::new(0.5, 0.25, 0.0), Vec3::new(0.025, 0.0125, 0.0)),
            (0.0, 1.0, Vec3::ZERO, Vec3::new(0.1, 0.05, 0.0)),
            (1e-9, 1.0, Vec3::new(1e-9, 5e-10, 0.0), Vec3::new(0.1, 0.05, 0.0)),
            (1.0, 0.0, texel, Vec3::ZERO),
            (0.0, 0.0, Vec3::ZERO, Vec3::ZERO),
        ] {
            let material = Material {
                diffuse: Vec3::splat(kd),
                ambient: Vec3::splat(ka),
                diffuse_map: Some(0),
                cutout: None,
                ..Material::fallback()
            };
            let palette = Palette::new(vec![paint(&material, Vec3::splat(0.1)); 2]);
            let kept = Vec3x8::splat(material.painted() * texel);
            let seen = [
                palette.albedo(&[Look::plain(1); 8], kept),
                palette.emitted_and_ambient(&[Look::plain(1); 8], kept),
            ];
            for (seen, wanted) in seen.map(|light| light.lane(3)).into_iter().zip([albedo, ambient]) {
                assert!(
                    (seen - wanted).abs().max_element() <= 1e-6 * wanted.max_element(),
                    "{kd}, {ka}: {seen}"
                );
            }
            let open = palette.emitted_and_occluded(&[Look::plain(1); 8], kept, F32x8::splat(0.5)).lane(3);
            assert!((open - 0.5 * ambient).abs().max_element() <= 1e-6, "{kd}, {ka}: {open}");
            assert_eq!(palette.has_ambient(1), ka > 0.0);
        }
    }

    #[test]
    fn eight_surfaces_have_each_their_own_material() {
        let dark = Material { ambient: Vec3::ZERO, ..Material::fallback() };
        let shiny = Material { specular: Vec3::ONE, ambient: Vec3::ONE, ..Material::fallback() };
        let palette = Palette::new([dark, shiny].map(|material| paint(&material, Vec3::ONE)).to_vec());
        let looks = [0, 1, 0, 0, 1, 1, 0, 0].map(Look::plain);
        let light = palette.emitted_and_ambient(&looks, Vec3x8::ZERO);
        let gloss = palette.gloss(&looks);
        for (lane, Look { material, .. }) in looks.iter().enumerate() {
            assert_eq!(light.lane(lane), Vec3::splat(f32::from(*material)));
            assert_eq!(gloss.specular.lane(lane), Vec3::splat(f32::from(*material)));
        }
        assert!(gloss.is_any && !palette.gloss(&[Look::plain(0); 8]).is_any);
    }
}
