//! What the renderer has of a [`Surface`](super::surface::Surface): its optical properties, lowered to what is shaded.

mod computed;
mod layers;

use std::sync::Arc;

use glam::Vec3;

pub use computed::{Along, Bump, ByParameter, Computed, Computes, Displacement, Varying};
pub use layers::{
    Anisotropy, Coat, Entry, Fuzz, Hair, LEAST_ALPHA, MetalRough, Optics, Scattering, UnevenGlass, head_on,
    index_of,
};

use super::cutout::Cutout;
pub use super::look::LARGEST_COLOR;
use super::look::Varied;
use super::medium::Medium;
use crate::graph::Program;

/// A surface as it is shaded. It knows no file format: readers make [surfaces](super::surface), which are lowered to it in one place.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name in its file.
    pub name: String,
    /// Diffuse reflectance, times the share of the light that the surface does not let through. Multiplied with
    /// the texture, if any.
    pub diffuse: Vec3,
    /// Reflectance of ambient light, times that share.
    pub ambient: Vec3,
    /// Reflectance of the highlight of Phong's model.
    pub specular: Vec3,
    /// Emitted radiance.
    pub emission: Vec3,
    /// Exponent of that highlight.
    pub shininess: f32,
    /// Transport of light beside diffuse and highlight: opaque, mirror or glass.
    pub optics: Optics,
    /// Metal-rough reflection, in place of `specular` and `shininess`.
    pub metal_rough: Option<MetalRough>,
    /// How white the metal of that is at grazing angles, from 0 (as at right angles) to 1.
    pub metal_edge: f32,
    /// Roughness of what is matt, from 0 to 1; it has a metal-rough layer then, which may reflect nothing.
    pub diffuse_roughness: f32,
    /// How its metal-rough layer spreads light more along one direction than across it.
    pub anisotropy: Option<Anisotropy>,
    /// Clear coat above its metal-rough layer, which it has then.
    pub coat: Option<Coat>,
    /// Fuzz above all of that; it has a metal-rough layer then.
    pub fuzz: Option<Fuzz>,
    /// Fibres that it is made of; it has a metal-rough layer then, for its colour alone.
    pub hair: Option<Hair>,
    /// Light that leaves it somewhere else than where it came, or on the other side.
    pub scattering: Option<Scattering>,
    /// What of its glass is not the same all over, if anything is.
    pub uneven_glass: Option<UnevenGlass>,
    /// What it absorbs of the light on its way through it, if it is glass: exponents for each unit of length, space of the shot's files.
    pub absorption: Vec3,
    /// Texture of its colour: index into [`Scene::textures`](super::Scene::textures).
    pub diffuse_map: Option<u32>,
    /// What graphs compute of it at each place.
    pub computed: Option<Arc<Computed>>,
    /// Alpha that cuts parts out of it: of a picture, of vertices, or of a graph.
    pub cutout: Option<Cutout>,
    /// Picture of the normals of a surface that is rougher than its triangles.
    pub normal_map: Option<NormalMap>,
    /// Heights of a surface that is rougher than its triangles; on top of its normal map, if it has one.
    pub bump: Option<Bump>,
    /// What moves the vertices of its triangles, before anything is rendered.
    pub displacement: Option<Displacement>,
    /// True if the colours of vertices are a factor of the reflectance, as a texture is.
    pub has_vertex_colors: bool,
    /// What fills closed meshes of it; where graphs give that, a factor of what they give.
    pub medium: Option<Medium>,
    /// What graphs give of that from place to place: of what is scattered, absorbed and emitted.
    pub medium_graph: Option<Arc<Program>>,
    /// Cells along the longest edge of a mesh in which that is even, where it is stated.
    pub medium_cells: Option<u32>,
    /// False if it is a medium alone: where a model has no other material, no ray meets it.
    pub has_surface: bool,
}

/// Picture of normals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalMap {
    /// Picture of vectors: index into [`Scene::textures`](super::Scene::textures). X points along the first texture coordinate, Y
    /// along the second, upwards, and Z out of the surface.
    pub map: u32,
    /// Factor on X and Y.
    pub slope: f32,
}

/// Name of the stand-in for a missing material.
const FALLBACK: &str = "(none)";

impl Material {
    /// Creates the grey material for faces without one.
    pub fn fallback() -> Self {
        Self {
            name: String::from(FALLBACK),
            diffuse: Vec3::splat(0.6),
            ambient: Vec3::splat(0.6),
            specular: Vec3::ZERO,
            emission: Vec3::ZERO,
            shininess: 1.0,
            optics: Optics::Opaque,
            metal_rough: None,
            metal_edge: 1.0,
            diffuse_roughness: 0.0,
            anisotropy: None,
            coat: None,
            fuzz: None,
            hair: None,
            scattering: None,
            uneven_glass: None,
            absorption: Vec3::ZERO,
            diffuse_map: None,
            computed: None,
            cutout: None,
            normal_map: None,
            bump: None,
            displacement: None,
            has_vertex_colors: false,
            medium: None,
            medium_graph: None,
            medium_cells: None,
            has_surface: true,
        }
    }

    /// Returns true if what samples keep of its reflectance is not its diffuse reflectance alone: a texture, a graph or the colours of
    /// vertices are a factor of it, or its share of metal varies.
    pub fn is_painted(&self) -> bool {
        let is_colored = self.diffuse_map.is_some() || self.has_vertex_colors;
        is_colored || self.has_computed_color() || self.varies_in_metal()
    }

    /// Diffuse reflectance where that is greatest: where a share of metal, or of glass, that varies is 0.
    pub fn most_diffuse(&self) -> Vec3 {
        match (self.uneven_glass, self.metal_rough) {
            _ if !self.varies_in_metal() => self.diffuse,
            (Some(glass), _) => glass.base,
            (None, Some(layer)) => layer.base * layer.solid,
            (None, None) => self.diffuse,
        }
    }

    /// What it reflects by metal or lets through as glass of each unit of its [greatest diffuse reflectance](Self::most_diffuse), where the
    /// factor of that share is 1. `None` if the share does not vary.
    pub fn share_that_is_not_matt(&self) -> Option<f32> {
        let of_layer = self.metal_rough.map(|layer| layer.metallic);
        self.uneven_glass.map(|glass| glass.share).or(of_layer).filter(|_| self.varies_in_metal())
    }

    /// Colour by which what goes through tinted glass is tinted where samples keep this reflectance.
    #[inline]
    pub fn tint_of_glass(&self, reflectance: Vec3) -> Vec3 {
        // 1 or more, where glass is tinted
        reflectance / self.painted()
    }

    /// Returns true if a graph computes this of it.
    pub fn is_computed(&self, of: Computes) -> bool {
        self.computed.as_ref().is_some_and(|computed| computed.numbers[of].is_some())
    }

    /// Returns true if graphs compute values of it that depend on what sees it: they are computed anew in each frame.
    pub fn is_of_eye(&self) -> bool {
        self.computed.as_ref().is_some_and(|computed| computed.program.is_of_eye())
    }

    /// Returns true if its share of metal, or of glass, varies from place to place.
    pub fn varies_in_metal(&self) -> bool {
        self.is_computed(Computes::Metalness)
    }

    /// Returns true if its roughness varies from place to place.
    pub fn varies_in_roughness(&self) -> bool {
        self.is_computed(Computes::Roughness)
    }

    /// Returns true if it is a veil that is as clear from place to place as graphs say.
    pub fn is_blended(&self) -> bool {
        self.is_computed(Computes::Opacity)
    }

    /// Returns true if its normals are bent, by a picture or by heights.
    pub fn bends_normals(&self) -> bool {
        self.normal_map.is_some() || self.bump.is_some()
    }

    /// Returns true if a graph is a factor of its reflectance.
    pub fn has_computed_color(&self) -> bool {
        self.is_computed(Computes::Color)
    }

    /// Parameters of it that vary from place to place, beside its colour.
    pub fn varying(&self) -> Varying {
        let has = |of| self.is_computed(of);
        Varying {
            roughness: has(Computes::Roughness),
            metalness: has(Computes::Metalness),
            opacity: has(Computes::Opacity),
            highlight: has(Computes::Highlight),
            emission: has(Computes::Emission),
        }
    }

    /// Returns true if parameters of it vary from place to place, beside its colour.
    pub fn varies(&self) -> bool {
        self.varying().is_any()
    }

    /// Returns true if its [effect on rays](Self::optics_at), with these parameters, is [none](Optics::Opaque).
    #[inline]
    pub fn is_opaque_at(&self, varied: Varied) -> bool {
        self.optics == Optics::Opaque && varied.opacity == u8::MAX
    }

    /// Its effect on rays from the camera, with these parameters: less of it is there, and so much more of what is behind is seen.
    #[inline]
    pub fn optics_at(&self, varied: Varied) -> Optics {
        if let (Some(_), Optics::Glass { transmission, index, reflection, total, is_rough, is_thin }) =
            (self.uneven_glass, self.optics)
        {
            let share = varied.of_metal();
            let (transmission, total) = (transmission * share, total * share);
            return Optics::Glass { transmission, index, reflection, total, is_rough, is_thin };
        }
        if varied.opacity == u8::MAX {
            return self.optics;
        }
        let opacity = varied.of_opacity();
        match self.optics {
            Optics::Glass { transmission, index, reflection, total, is_rough, is_thin } => Optics::Glass {
                transmission: Vec3::ONE - (Vec3::ONE - transmission) * opacity,
                index,
                reflection,
                total,
                is_rough,
                is_thin,
            },
            _ => Optics::veil(Vec3::splat(1.0 - opacity)),
        }
    }

    /// Its emission, with these parameters: radiance, linear RGB.
    #[inline]
    pub fn emission_at(&self, varied: Varied) -> Vec3 {
        if self.computed.is_some() { varied.light_of(self.emission) } else { self.emission }
    }

    /// Returns true if light may pass through it.
    pub fn lets_through(&self) -> bool {
        matches!(self.optics, Optics::Glass { .. }) || self.is_blended()
    }

    /// Returns true if light may pass straight through it.
    pub fn lets_straight_through(&self) -> bool {
        self.optics.is_straight() || self.is_blended()
    }

    /// Returns true if graphs compute anything of its places.
    pub fn has_graphs(&self) -> bool {
        self.computed.is_some() || self.bump.is_some()
    }

    /// Returns true if anything of it depends on the space of a mesh's own file.
    pub fn asks_for_space(&self) -> bool {
        self.programs().next().is_some()
            || self.displacement.is_some()
            || self.anisotropy.is_some_and(|anisotropy| anisotropy.around.is_some())
    }

    /// All programs that are evaluated at its places.
    pub fn programs(&self) -> impl Iterator<Item = &Program> {
        let heights = self.bump.iter().map(|bump| &*bump.height);
        let of_surface = self.computed.iter().map(|computed| &computed.program).chain(heights);
        of_surface.chain(self.medium_graph.as_deref())
    }

    /// Returns true if it has pictures that are filtered over the place that a sample stands for.
    pub fn is_filtered(&self) -> bool {
        let by_graph = || self.programs().any(Program::is_filtered);
        self.diffuse_map.is_some() || self.normal_map.is_some() || by_graph()
    }

    /// Share of the light that does not pass straight through.
    pub fn opacity(&self) -> f32 {
        match self.optics {
            Optics::Glass { transmission, .. } => 1.0 - transmission.max_element(),
            _ => 1.0,
        }
    }

    /// Returns true if it can be there in part, and bends nothing: where nothing else is asked of its optics.
    pub fn can_blend(&self) -> bool {
        match self.optics {
            Optics::Opaque => true,
            Optics::Glass { index, reflection, is_rough, .. } => {
                let is_even = self.uneven_glass.is_none();
                index == 1.0 && reflection == Vec3::ZERO && !is_rough && is_even
            }
            Optics::Mirror { .. } => false,
        }
    }

    /// Returns true if it is the stand-in for faces without a material.
    pub fn is_fallback(&self) -> bool {
        self.name == FALLBACK
    }

    /// Factor of texture and vertex colours in the reflectance that a sample keeps. By channel it is the larger of the
    /// diffuse and the ambient reflectance, so that both can be derived from the product where either is 0;
    /// and not less than the base colour of a metal. If nothing paints it, it is the diffuse reflectance.
    pub fn painted(&self) -> Vec3 {
        let base = self.metal_rough.map_or(Vec3::ZERO, |metal_rough| metal_rough.base);
        let base = match self.uneven_glass {
            // its tint is kept whole, however dark what is matt of it is
            Some(glass) if glass.is_tinted => glass.base.max(Vec3::ONE),
            Some(glass) => glass.base,
            None => base,
        };
        if self.is_painted() { self.diffuse.max(self.ambient).max(base) } else { self.diffuse }
    }

    /// Returns true if, without a texture, it shows nothing: it neither reflects nor transmits nor emits
    /// light.
    pub fn is_black(&self) -> bool {
        let colors = [self.diffuse, self.specular, self.emission];
        colors == [Vec3::ZERO; 3] && !self.has_secondary_rays()
    }

    /// Returns true if shadow rays stop here: clear glass casts no shadow, everything else a full one.
    /// Visibility stays a yes or no that can be kept as a tag.
    pub fn casts_shadow(&self) -> bool {
        match self.optics {
            Optics::Glass { transmission, .. } => {
                let mean = self.uneven_glass.map_or(1.0, |glass| glass.mean);
                transmission.max_element() * mean < 0.5
            }
            _ => true,
        }
    }

    /// Returns true if the colour of the surface depends on rays beyond it.
    pub fn has_secondary_rays(&self) -> bool {
        self.is_followed() || self.is_rough()
    }

    /// Returns true if it is a mirror or glass, at least in places: rays follow it, in each frame anew.
    pub fn is_followed(&self) -> bool {
        let may_be_smooth = |layer: MetalRough| layer.is_smooth() || self.varies_in_roughness();
        let has_smooth =
            self.metal_rough.is_some_and(may_be_smooth) || self.coat.is_some_and(|coat| coat.is_smooth());
        self.optics != Optics::Opaque || self.is_blended() || has_smooth
    }

    /// Returns true if it sends the same light to whoever looks, but for what it lets through or mirrors as glass does, and all of it from
    /// where light meets it.
    pub fn is_matt(&self) -> bool {
        self.metal_rough.is_none()
            && self.coat.is_none()
            && self.hair.is_none()
            && self.scattering.is_none()
            && self.specular == Vec3::ZERO
            && !self.varies()
            && !self.is_of_eye()
    }

    /// Returns true if it is glass that scatters what it lets through.
    pub fn is_rough_glass(&self) -> bool {
        matches!(self.optics, Optics::Glass { is_rough: true, .. })
    }

    /// Returns true if rays that pass its surface are inside of it, or have left it.
    pub fn is_solid(&self) -> bool {
        match self.optics {
            Optics::Glass { is_thin, .. } => {
                !is_thin && (!self.optics.is_straight() || self.absorption != Vec3::ZERO)
            }
            _ => false,
        }
    }

    /// Returns true if it has a layer that is rough, at least in places: paths by which it reflects are kept.
    pub fn is_rough(&self) -> bool {
        let is_coat_rough = self.coat.is_some_and(|coat| !coat.is_smooth());
        let is_layer_rough = self.metal_rough.is_some_and(|layer| layer.reflects() && !layer.is_smooth());
        is_layer_rough || is_coat_rough || self.fuzz.is_some()
    }
}
