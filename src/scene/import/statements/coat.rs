//! Clear coats as files state them.

use glam::Vec3;

use crate::scene::material::Coat;

/// What a file says of a clear coat.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct StatedCoat {
    /// Share of the surface that it covers, 0 to 1; without it there is no coat.
    pub weight: Option<f32>,
    /// Roughness, 0 to 1.
    pub roughness: Option<f32>,
    /// Index of refraction.
    pub index: Option<f32>,
    /// Colour of light that has passed it twice.
    pub tint: Option<Vec3>,
    /// How far it darkens what is below, 0 to 1.
    pub darkening: Option<f32>,
}

/// Roughness where none is stated: a coat is varnish.
const ROUGHNESS: f32 = 0.0;

/// Index of refraction where none is stated, as in glTF and USD.
pub(crate) const INDEX_OF_COAT: f64 = 1.5;

impl StatedCoat {
    /// Takes every value that `other` states.
    pub fn replace_with(&mut self, other: &Self) {
        self.weight = other.weight.or(self.weight);
        self.roughness = other.roughness.or(self.roughness);
        self.index = other.index.or(self.index);
        self.tint = other.tint.or(self.tint);
        self.darkening = other.darkening.or(self.darkening);
    }

    /// The coat, if there is one that does anything.
    pub fn settle(&self) -> Option<Coat> {
        let weight = self.weight.filter(|weight| *weight > 0.0)?.min(1.0);
        let coat = Coat {
            weight,
            roughness: self.roughness.unwrap_or(ROUGHNESS).clamp(0.0, 1.0),
            index: self.index.unwrap_or(INDEX_OF_COAT as f32),
            tint: self.tint.unwrap_or(Vec3::ONE).clamp(Vec3::ZERO, Vec3::ONE),
            darkening: self.darkening.unwrap_or(0.0).clamp(0.0, 1.0),
        };
        (coat.index > 1.0 || coat.tint != Vec3::ONE)
            .then_some(Coat { index: coat.index.clamp(LEAST_INDEX, GREATEST_INDEX), ..coat })
    }
}

/// Least index of refraction: a coat that does not bend light may have a colour all the same.
const LEAST_INDEX: f32 = 1.0001;

/// Greatest index of refraction: beyond it nothing would come out.
const GREATEST_INDEX: f32 = 100.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coat_is_there_where_it_does_something() {
        let stated = StatedCoat { weight: Some(0.5), ..StatedCoat::default() };
        let coat = stated.settle().expect("it has a weight");
        assert_eq!((coat.weight, coat.index, coat.tint, coat.darkening), (0.5, 1.5, Vec3::ONE, 0.0));
        assert!(StatedCoat { weight: Some(0.0), ..stated }.settle().is_none());
        assert!(StatedCoat { index: Some(1.0), ..stated }.settle().is_none(), "it is not seen");
        assert!(StatedCoat { index: Some(1.0), tint: Some(Vec3::X), ..stated }.settle().is_some());
        let mut replaced = stated;
        replaced.replace_with(&StatedCoat { roughness: Some(0.25), ..StatedCoat::default() });
        assert_eq!(replaced.settle().map(|coat| (coat.weight, coat.roughness)), Some((0.5, 0.25)));
    }
}
