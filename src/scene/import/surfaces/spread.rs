//! Widths of rough layers as models other than OpenPBR have them.

/// Widths of a lobe (alpha of GGX), along the tangent and across it, as those of OpenPBR: its anisotropy, and its roughness.
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
}
