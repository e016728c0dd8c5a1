//! False colours for the difference between two pictures: small differences show beside large ones.

/// Differences of this and less have the first colour; 0 is black.
pub const LEAST: f32 = 1.0 / 4096.0;

/// Colour ramp, sRGB, from [`LEAST`] to 1 in equal steps of the logarithm, ever lighter: violet blue, purple,
/// red, orange, pale yellow.
const RAMP: [[u8; 3]; 5] = [[28, 26, 92], [112, 32, 140], [208, 48, 84], [246, 146, 42], [255, 248, 206]];

/// The sRGB colour of an absolute difference: black is 0, the last colour is 1 and more.
#[must_use]
pub fn of_difference(difference: f32) -> [u8; 3] {
    if difference == 0.0 {
        return [0; 3];
    }
    let last = RAMP.len() - 1;
    let decades = (difference / LEAST).log2() / (1.0 / LEAST).log2();
    let at = if decades.is_nan() { 1.0 } else { decades.clamp(0.0, 1.0) } * last as f32;
    let from = (at as usize).min(last - 1);
    let share = at - from as f32;
    std::array::from_fn(|i| {
        let [low, high] = [RAMP[from][i], RAMP[from + 1][i]].map(f32::from);
        (low + (high - low) * share + 0.5) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_go_from_black_to_light() {
        assert_eq!(of_difference(0.0), [0; 3]);
        assert_eq!([1e-30, LEAST].map(of_difference), [RAMP[0]; 2]);
        assert_eq!([1.0, 7.0, f32::INFINITY, f32::NAN].map(of_difference), [RAMP[4]; 4]);
        assert_eq!(of_difference(1.0 / 64.0), RAMP[2], "the middle of the logarithms");
        let luma = |difference| {
            let [r, g, b] = of_difference(difference).map(f32::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let rising: Vec<f32> = (0..60).map(|step| luma(LEAST * 2_f32.powf(step as f32 * 0.2))).collect();
        assert!(rising.windows(2).all(|pair| pair[0] < pair[1]), "{rising:?}");
    }
}
