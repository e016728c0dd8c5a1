//! Anisotropy of rough layers as files state it.

use glam::Vec3;

use crate::scene::material::Anisotropy;

/// What a file says of the direction along which a rough layer spreads light.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct StatedAnisotropy {
    /// How much narrower the lobe is across the tangent than along it, 0 to 1; without it the lobe is round.
    pub amount: Option<f32>,
    /// Turn of the tangent, degrees.
    pub turn: Option<f32>,
    /// Axis of the model's file around which the tangent leads.
    pub around: Option<Vec3>,
}

impl StatedAnisotropy {
    /// Takes every value that `other` states.
    pub fn replace_with(&mut self, other: &Self) {
        self.amount = other.amount.or(self.amount);
        self.turn = other.turn.or(self.turn);
        self.around = other.around.or(self.around);
    }

    /// The anisotropy, if there is any.
    pub fn settle(&self) -> Option<Anisotropy> {
        let amount = self.amount.filter(|amount| *amount > 0.0)?.min(1.0);
        let turn = self.turn.unwrap_or(0.0).to_radians();
        Some(Anisotropy { amount, turn, around: self.around })
    }
}

/// Widths of a lobe as other models have them, along the tangent and across it, as those of OpenPBR: its anisotropy, and its roughness.
pub(crate) fn as_open_pbr([along, across]: [f64; 2]) -> (f64, f64) {
    let share = (across / along).clamp(0.0, 1.0);
    let stretch = (2.0 / (1.0 + share * share)).sqrt();
    (1.0 - share, (along / stretch).sqrt().clamp(0.0, 1.0))
}

/// [`as_open_pbr`] of a model whose widths are the square of its `roughness` over an aspect, and times it, where the aspect is the root of one
/// less the anisotropy: that of Disney, of Standard Surface and, for nine tenths of its anisotropy, of Blender.
pub(crate) fn of_aspect(roughness: f64, anisotropy: f64) -> (f64, f64) {
    let aspect = (1.0 - anisotropy.clamp(0.0, MOST_ANISOTROPIC)).sqrt();
    let alpha = roughness * roughness;
    as_open_pbr([(alpha / aspect).min(1.0), alpha * aspect])
}

/// Anisotropy beyond which Standard Surface has none.
const MOST_ANISOTROPIC: f64 = 0.98;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_of_other_models_are_kept() {
        for (roughness, anisotropy) in [(0.3, 0.5), (0.6, 0.8), (0.5, 0.0)] {
            let (amount, round) = of_aspect(roughness, anisotropy);
            let along = round * round * (2.0 / (1.0 + (1.0 - amount) * (1.0 - amount))).sqrt();
            let aspect = f64::sqrt(1.0 - anisotropy);
            assert!((along - roughness * roughness / aspect).abs() < 1e-9, "{roughness} {anisotropy}");
            assert!((along * (1.0 - amount) - roughness * roughness * aspect).abs() < 1e-9);
        }
    }

    #[test]
    fn none_is_round() {
        assert_eq!(StatedAnisotropy::default().settle(), None);
        let stated = StatedAnisotropy { amount: Some(0.5), turn: Some(180.0), around: None };
        let settled = stated.settle().expect("there is some");
        assert!(
            settled.amount == 0.5
                && (settled.turn - std::f32::consts::PI).abs() < 1e-6
                && settled.around.is_none()
        );
    }
}
