//! Looks: what a surface is made of at one place.

/// Parameters of a surface that vary from place to place, as samples keep them: rounded once, when a sample is traced. Each is a factor of
/// the material's own, in 255ths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(C)]
pub struct Varied {
    /// Roughness.
    pub roughness: u8,
    /// Share of metal.
    pub metalness: u8,
}

impl Varied {
    /// All parameters are the material's own.
    pub const NONE: Self = Self { roughness: u8::MAX, metalness: u8::MAX };

    /// The factor that a number from 0 to 1 is kept as.
    pub fn rounded(factor: f32) -> u8 {
        // a cast of NaN is 0
        (factor.clamp(0.0, 1.0) * f32::from(u8::MAX) + 0.5) as u8
    }

    /// The factor on the roughness, from 0 to 1.
    #[inline]
    pub fn of_roughness(self) -> f32 {
        f32::from(self.roughness) / f32::from(u8::MAX)
    }

    /// The factor on the share of metal, from 0 to 1.
    #[inline]
    pub fn of_metal(self) -> f32 {
        f32::from(self.metalness) / f32::from(u8::MAX)
    }
}

impl Default for Varied {
    fn default() -> Self {
        Self::NONE
    }
}

/// Material of a surface, with its parameters at one place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Look {
    /// Index into [`Scene::materials`](crate::scene::Scene::materials).
    pub material: u16,
    /// Parameters there.
    pub varied: Varied,
}

impl Look {
    /// A material whose parameters are its own.
    pub fn plain(material: u16) -> Self {
        Self { material, varied: Varied::NONE }
    }
}
