//! Parts of a material: what reflects, what lets light through, and what lies above and below.

use glam::Vec3;

use crate::lanes::Real;
use crate::scene::look::Varied;

/// Least width of a rough layer's lobe (alpha of GGX), the square of a roughness of 0.045: the lobe is some
/// 0.2 degrees wide, less than half of the sun's disk, so that no change is seen below it. The peak of a
/// narrower lobe is lost to the rounding of single floats.
pub const LEAST_ALPHA: f32 = 0.002;

/// Width of the lobe (alpha of GGX) of a layer of this roughness.
fn alpha_of(roughness: f32) -> f32 {
    (roughness * roughness).max(LEAST_ALPHA)
}

/// A clear coat, as OpenPBR has it: a dielectric above all else of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coat {
    /// Share of the surface that it covers, above 0 and up to 1.
    pub weight: f32,
    /// Roughness, from 0 to 1.
    pub roughness: f32,
    /// Index of refraction, above 1.
    pub index: f32,
    /// Colour of light that has passed it at right angles, in and out again: linear RGB from 0 to 1.
    pub tint: Vec3,
    /// How far what it reflects back onto what is below darkens that, from 0 to 1: not at all, or as light does.
    pub darkening: f32,
}

impl Coat {
    /// Width of the lobe (alpha of GGX).
    pub fn alpha(&self) -> f32 {
        alpha_of(self.roughness)
    }

    /// Returns true if it reflects as a mirror does.
    pub fn is_smooth(&self) -> bool {
        self.alpha() <= LEAST_ALPHA
    }
}

/// Anisotropy of a rough layer, as OpenPBR has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Anisotropy {
    /// How much narrower its lobe is across the tangent than along it, above 0 (round) and up to 1.
    pub amount: f32,
    /// Turn of the tangent about the normal, radians, counter-clockwise as seen from outside.
    pub turn: f32,
    /// Axis of object space around which the tangent leads, as the grooves of turned metal do; without one it is that of the first texture
    /// coordinate.
    pub around: Option<Vec3>,
}

/// Fuzz, as OpenPBR has it: fibres above all else of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fuzz {
    /// Share of the surface that it covers, above 0 and up to 1.
    pub weight: f32,
    /// Colour: linear RGB from 0 to 1.
    pub color: Vec3,
    /// Roughness, from 0 to 1: how far from grazing angles it is seen.
    pub roughness: f32,
}

/// Hair, as Chiang and others have it (2016): fibres of coloured glass with tilted scales. Its colour is that of the layer beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hair {
    /// Roughness along the fibre, from 0 to 1.
    pub roughness: f32,
    /// Roughness around it, from 0 to 1.
    pub radial_roughness: f32,
    /// How much smoother light is reflected off its surface, from 0 (as rough as all else) to 1.
    pub coat: f32,
    /// Index of refraction, above 1.
    pub index: f32,
    /// Tilt of the scales, radians.
    pub offset: f32,
}

/// Reflectance at right angles of a surface with this index of refraction, by Fresnel's equations.
pub fn head_on(index: f64) -> f64 {
    ((index - 1.0) / (index + 1.0)).powi(2)
}

/// Index of refraction of a surface that reflects this share of light at right angles, from 0 to 1: the inverse of [`head_on`], from 1 to
/// infinity.
#[inline(always)]
pub fn index_of<T: Real>(head_on: T) -> T {
    let (one, root) = (T::of(1.0), head_on.sqrt());
    (one + root) / (one - root)
}

/// Metal-rough reflection: diffuse beneath a dielectric layer, or metallic, or a mixture of both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MetalRough {
    /// Base colour, multiplied with the texture, if any: the reflection colour of metals, the diffuse colour of other surfaces.
    pub base: Vec3,
    /// Roughness, from 0 to 1.
    pub roughness: f32,
    /// Share of metal, from 0 to 1.
    pub metallic: f32,
    /// Reflectance of the part that is no metal at normal incidence.
    pub head_on: f32,
    /// Opacity: the share of the light that does not pass straight through.
    pub solid: f32,
}

impl MetalRough {
    /// Width of the lobe (alpha of GGX): the square of the roughness (Burley, "Physically Based Shading at
    /// Disney", 2012), so that equal steps of roughness look like equal steps.
    pub fn alpha(&self) -> f32 {
        alpha_of(self.roughness)
    }

    /// The layer with these parameters.
    #[inline]
    pub fn at(&self, varied: Varied) -> Self {
        Self {
            roughness: self.roughness * varied.of_roughness(),
            metallic: self.metallic * varied.of_metal(),
            solid: self.solid * varied.of_opacity(),
            ..*self
        }
    }

    /// Returns true if it reflects anything: that of what is matt does not.
    pub fn reflects(&self) -> bool {
        self.head_on > 0.0 || self.metallic > 0.0
    }

    /// Returns true if it reflects as a mirror does.
    pub fn is_smooth(&self) -> bool {
        self.alpha() <= LEAST_ALPHA
    }
}

/// Glass that is not the same all over: what is not glass of it is matt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnevenGlass {
    /// Diffuse reflectance of what is not glass.
    pub base: Vec3,
    /// Share of it that is glass, from 0 to 1; where that varies, what its factor is one of.
    pub share: f32,
    /// Mean of that factor over the surface: [shadows](super::Material::casts_shadow) ask for it.
    pub mean: f32,
    /// True if the reflectance that samples keep tints what goes through it, as it does what is matt.
    pub is_tinted: bool,
}

/// What becomes of the diffuse light of a surface that does not leave it where it came, in the colour of that light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scattering {
    /// Share of the light of each channel that goes below the surface and comes out somewhere else, from 0 to 1.
    pub below: Vec3,
    /// Mean free path below it: the way that red, green and blue light goes before it is scattered, world space of the shot's files.
    pub radius: Vec3,
    /// Share that leaves on the other side of the surface, as through a leaf; both shares together are 1 at most.
    pub through: f32,
    /// Directions in which light goes in.
    pub entry: Entry,
}

/// Directions in which light goes below a surface, over all from which it is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Share of it that goes in by the cosine law, from 0 to 1. The rest is bent by the microfacets of an interface.
    pub matt: f32,
    /// Index of refraction of that interface, 1 or more.
    pub index: f32,
    /// Width of its microfacets (alpha of GGX).
    pub alpha: f32,
}

impl Entry {
    /// That of what is matt.
    pub const MATT: Self = Self { matt: 1.0, index: 1.0, alpha: 1.0 };
}

impl Scattering {
    /// Share of the light of each channel that leaves the surface where it came, and on its side.
    pub fn at_surface(&self) -> Vec3 {
        (Vec3::splat(1.0 - self.through) - self.below).max(Vec3::ZERO)
    }
}

/// Effect of a surface on a ray from the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Optics {
    /// No effect: the ray ends.
    Opaque,
    /// Reflects the ray, weighted with `tint`. `fresnel`: by Schlick's formula
    /// from `tint` head-on to white at grazing angles.
    Mirror {
        /// Colour of the reflection.
        tint: Vec3,
        /// True if the reflection grows towards grazing angles.
        fresnel: bool,
    },
    /// Lets a share of the light through.
    Glass {
        /// Colour of transmitted light.
        transmission: Vec3,
        /// Index of refraction. 1: straight through, and nothing reflects.
        index: f32,
        /// Tint of the reflection, which Fresnel's formula weights.
        reflection: Vec3,
        /// True if it is as rough as the material's [`MetalRough`], which then is its reflection as well.
        is_rough: bool,
        /// True if the surface is both walls of a pane at once: light goes straight on behind it.
        is_thin: bool,
    },
}

impl Optics {
    /// Clear, smooth glass.
    pub const fn clear(transmission: Vec3, index: f32, reflection: Vec3) -> Self {
        Self::Glass { transmission, index, reflection, is_rough: false, is_thin: false }
    }

    /// A surface that lets light of this colour pass straight through.
    pub fn veil(transmission: Vec3) -> Self {
        Self::clear(transmission, 1.0, Vec3::ZERO)
    }

    /// Returns true if what it lets through goes straight on.
    pub fn is_straight(&self) -> bool {
        match self {
            Self::Glass { index, is_rough, is_thin, .. } => (*index == 1.0 || *is_thin) && !is_rough,
            _ => false,
        }
    }
}
