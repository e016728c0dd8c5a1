//! Error of a picture against a reference: the same frame with more samples.

use serde::Serialize;

use crate::film::Film;

/// Root mean square error over all pixels and R, G and B, linear.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct PictureError {
    /// Error of values clamped to 0 to 1, as a display shows them: no bright light or single sample dominates
    /// it.
    pub display: f64,
    /// Error of the values as they are.
    pub linear: f64,
}

impl PictureError {
    /// Compares two films of the same size.
    pub fn between(picture: &Film, reference: &Film) -> Self {
        let mut squares = [0.0_f64; 2];
        let mut count = 0;
        for (a, b) in
            ["R", "G", "B"].iter().filter_map(|name| picture.values(name).zip(reference.values(name)))
        {
            count += a.len();
            for (a, b) in a.iter().zip(&b) {
                squares[0] += f64::from(a.clamp(0.0, 1.0) - b.clamp(0.0, 1.0)).powi(2);
                squares[1] += f64::from(a - b).powi(2);
            }
        }
        let [display, linear] = squares.map(|sum| (sum / count.max(1) as f64).sqrt());
        Self { display, linear }
    }

    /// Error over the pixels of several pictures of the same size.
    pub(super) fn over(errors: impl ExactSizeIterator<Item = Self>) -> Self {
        let count = errors.len().max(1) as f64;
        let [display, linear] = errors
            .fold([0.0; 2], |[display, linear], error| {
                [display + error.display.powi(2), linear + error.linear.powi(2)]
            })
            .map(|sum: f64| (sum / count).sqrt());
        Self { display, linear }
    }
}

/// Errors of a frame that was made in both ways.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct BothErrors {
    /// Error of the frame made as `render` makes it.
    pub reprojected: PictureError,
    /// Error of the frame traced from nothing.
    pub full: PictureError,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::both_ways::tests::film;

    #[test]
    fn a_bright_light_does_not_dominate_what_a_display_shows() {
        let error = PictureError::between(&film([0.0, 0.5, 100.0, 0.25]), &film([0.0, 0.25, 200.0, 0.25]));
        assert!((error.display - 0.125).abs() < 1e-9, "{error:?}");
        assert!((error.linear - 50.0).abs() < 0.01, "{error:?}");
        assert_eq!(PictureError::between(&film([7.0; 4]), &film([7.0; 4])), PictureError::default());
    }
}
