//! Fuzz as files state it.

use glam::Vec3;

use crate::scene::material::Fuzz;

/// What a file says of fuzz.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct StatedFuzz {
    /// Share of the surface that it covers, 0 to 1; without it there is none.
    pub weight: Option<f32>,
    /// Colour.
    pub color: Option<Vec3>,
    /// Roughness, 0 to 1.
    pub roughness: Option<f32>,
}

/// Roughness where none is stated: that of OpenPBR.
const ROUGHNESS: f32 = 0.5;

impl StatedFuzz {
    /// Takes every value that `other` states.
    pub fn replace_with(&mut self, other: &Self) {
        self.weight = other.weight.or(self.weight);
        self.color = other.color.or(self.color);
        self.roughness = other.roughness.or(self.roughness);
    }

    /// The fuzz, if there is any that reflects.
    pub fn settle(&self) -> Option<Fuzz> {
        let fuzz = Fuzz {
            weight: self.weight.unwrap_or(0.0).clamp(0.0, 1.0),
            color: self.color.unwrap_or(Vec3::ONE).clamp(Vec3::ZERO, Vec3::ONE),
            roughness: self.roughness.unwrap_or(ROUGHNESS).clamp(0.0, 1.0),
        };
        (fuzz.weight > 0.0 && fuzz.color != Vec3::ZERO).then_some(fuzz)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fuzz_is_there_where_it_reflects() {
        let stated = StatedFuzz { weight: Some(2.0), ..StatedFuzz::default() };
        assert_eq!(stated.settle(), Some(Fuzz { weight: 1.0, color: Vec3::ONE, roughness: 0.5 }));
        assert_eq!(StatedFuzz { color: Some(Vec3::ZERO), ..stated }.settle(), None);
        assert_eq!(StatedFuzz::default().settle(), None);
        let mut replaced = stated;
        replaced.replace_with(&StatedFuzz { roughness: Some(0.2), ..StatedFuzz::default() });
        assert_eq!(replaced.settle().map(|fuzz| fuzz.roughness), Some(0.2));
    }
}
