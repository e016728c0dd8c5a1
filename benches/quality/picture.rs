//! Pictures as a display shows them, and their differences.

use afterimage::film::Film;
use glam::Vec3;

/// A picture in linear RGB, clamped to 0..1, row-major, top row first.
#[derive(Debug, Clone)]
pub struct Picture {
    pub width: usize,
    pub colors: Vec<Vec3>,
}

impl Picture {
    /// Creates a picture from colours that are not clamped yet.
    pub fn new(width: usize, colors: impl Iterator<Item = Vec3>) -> Self {
        Self { width, colors: colors.map(|color| color.clamp(Vec3::ZERO, Vec3::ONE)).collect() }
    }

    /// Reads the picture from a film's `R G B`.
    pub fn of(film: &Film) -> Self {
        let [r, g, b] = ["R", "G", "B"].map(|name| film.values(name).expect("every film has it"));
        let colors = r.iter().zip(&g).zip(&b).map(|((r, g), b)| Vec3::new(*r, *g, *b));
        Self::new(film.width as usize, colors)
    }

    /// Subtracts another picture from this one.
    pub fn less(&self, other: &Self) -> Vec<Vec3> {
        self.colors.iter().zip(&other.colors).map(|(a, b)| *a - *b).collect()
    }

    /// Root mean square difference over pixels and channels.
    pub fn rmse(&self, other: &Self) -> f64 {
        rms(&self.less(other))
    }
}

/// Root mean square over pixels and channels.
pub fn rms(values: &[Vec3]) -> f64 {
    let sum: f64 = values.iter().map(|value| f64::from(value.length_squared())).sum();
    (sum / (3 * values.len().max(1)) as f64).sqrt()
}
