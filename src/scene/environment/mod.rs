//! Light from all around: radiance by direction, and directions sampled by importance, in one of two ways ([`SkyDensity`]).
//!
//! An [`Environment`] is a latitude-longitude grid and, for a sky, the [`Sun`] beside it, whose disk would be smaller
//! than a texel. World space, Y up. Before it is rotated, a direction falls on the grid at
//! `u = 1/2 + atan2(x, -z) / 2π` (from the left) and `v = atan2(√(x² + z²), y) / π` (from the top): the middle of a map
//! is -Z, where a camera without rotation looks, to its right is +X, and its upper edge is +Y.

mod distribution;
mod grid;
mod light_from;
mod picture_error;
mod read;
mod sampler;
mod sky;
mod spectrum;
mod sun;

use std::sync::Arc;

use glam::Vec3;

use super::Background;
use grid::Grid;
pub use light_from::LightFrom;
pub use picture_error::PictureError;
pub(super) use read::read;
#[cfg(feature = "usd")]
pub(super) use read::{is_even, is_map};
use sampler::Samplers;
pub use sampler::SkyDensity;
pub use sky::Sky;
pub use sun::Sun;

/// Number of rows of the grid made from a [`Background`].
const BACKGROUND_ROWS: u32 = 1024;

/// Radiance from all directions, linear RGB, scene-referred. It does not change with time, and a clone shares the grid.
///
/// [`Self::sample`] and [`Self::light`] treat grid and sun as one. [`Self::sample_grid`],
/// [`Self::grid_light`] and [`Self::sun`] serve callers that ask them one by one.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    /// True if the camera sees the environment directly. Otherwise rays that hit nothing show the
    /// [`Background`].
    pub visible: bool,
    /// Number of rays towards the environment where a path starts, if it [has peaks](Self::has_peaks). 0: only
    /// paths that escape find it.
    pub samples: u32,
    grid: Arc<Grid>,
    /// The sun, after rotation and with the radiance factor applied.
    sun: Option<Sun>,
    samplers: Arc<Samplers>,
    /// Rotation about Y, degrees.
    rotation: f64,
    /// Rotation from the space of the grid to world space.
    turn: Turn,
    power: f32,
}

impl Environment {
    /// Creates an environment from a latitude-longitude picture: linear RGB, three values for each of `width`
    /// x `height` texels, row by row from the top.
    ///
    /// # Errors
    /// A side of 0, another number of values, a value that is negative or not finite.
    pub fn from_picture(width: u32, height: u32, texels: Vec<f32>) -> Result<Self, PictureError> {
        Ok(Self::new(Grid::new(width, height, texels)?, None))
    }

    /// Creates a clear sky with its sun.
    ///
    /// # Panics With angles or a turbidity beyond the ranges that [`Sky`] states, where its formulas give no
    /// colour.
    pub fn from_sky(sky: &Sky) -> Self {
        let (width, height, texels) = sky.picture();
        let grid =
            Grid::new(width, height, texels).expect("within its ranges a sky is finite and not negative");
        Self::new(grid, sky.sun())
    }

    /// Creates an environment from a gradient, which depends on the height alone.
    ///
    /// # Panics With a colour that is negative or not finite.
    pub fn from_background(background: &Background) -> Self {
        let middle = |row| std::f32::consts::PI * (row as f32 + 0.5) / BACKGROUND_ROWS as f32;
        let row = |row| background.radiance(Vec3::new(0.0, middle(row).cos(), -middle(row).sin()));
        // a blend of the largest floats may be rounded to infinity
        let texels = (0..BACKGROUND_ROWS).flat_map(|at| row(at).min(Vec3::MAX).to_array()).collect();
        let grid = Grid::new(1, BACKGROUND_ROWS, texels).expect("colours are finite and not negative");
        Self::new(grid, None)
    }

    fn new(grid: Grid, sun: Option<Sun>) -> Self {
        let sun = sun.filter(|sun| sun.radiance.max_element() > 0.0);
        let samplers = Arc::new(Samplers::new(&grid, sun.as_ref()));
        let (visible, grid, turn) = (true, Arc::new(grid), Turn::new(0.0));
        Self { visible, samples: 1, grid, sun, samplers, rotation: 0.0, turn, power: 1.0 }
    }

    /// Rotates the environment further by `degrees` about Y: counter-clockwise as seen from above, as models
    /// turn. A light at -Z is at -X after 90 degrees.
    #[must_use]
    pub fn rotated(self, degrees: f64) -> Self {
        let rotation = (self.rotation + degrees) % 360.0;
        let sun = self.sun.map(|sun| Sun { to_sun: Turn::new(degrees).apply(sun.to_sun), ..sun });
        Self { rotation, turn: Turn::new(rotation), sun, ..self }
    }

    /// Multiplies the radiance by `factor`, which is finite and not negative. Directions are sampled as
    /// before.
    #[must_use]
    pub fn times(self, factor: f32) -> Self {
        let sun = self.sun.map(|sun| Sun { radiance: scaled(sun.radiance, factor), ..sun });
        Self { power: (self.power * factor).min(f32::MAX), sun, ..self }
    }

    /// Returns true if there are [peaks](SkyDensity::Peaks) of its light, and rays to them are worth their cost.
    pub fn has_peaks(&self) -> bool {
        self.samplers.have_peaks()
    }

    /// Radiance from `direction` (world space, unit length), as seen by a ray that leaves the scene.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.light(SkyDensity::Whole, direction).radiance
    }

    /// Radiance from `direction` (world space, unit length), and the density with which [`Self::sample`]
    /// returns that direction. The integral of the density over the sphere is 1, also for a black
    /// environment.
    pub fn light(&self, density: SkyDensity, direction: Vec3) -> LightFrom {
        let of_grid = self.grid_light(density, direction);
        let Some(sun) = self.sun else { return of_grid };
        let (of_sun, share) = (sun.light(direction), self.samplers.of(density).sun_share);
        LightFrom {
            radiance: (of_grid.radiance + of_sun.radiance).min(Vec3::MAX),
            pdf: share * of_sun.pdf + (1.0 - share) * of_grid.pdf,
        }
    }

    /// Samples a direction from which light comes (world space, unit length). `random`: two numbers from 0 to
    /// 1; stratified numbers give stratified directions. At the rim of lit texels, rounding may give a
    /// direction without light.
    pub fn sample(&self, density: SkyDensity, random: [f32; 2]) -> Vec3 {
        let [choice, other] = random;
        let Some(sun) = self.sun else { return self.sample_grid(density, random) };
        let share = self.samplers.of(density).sun_share;
        // the rest of the number that chose is as random as the number was
        if choice < share {
            sun.sample([choice / share, other])
        } else {
            self.sample_grid(density, [(choice - share) / (1.0 - share), other])
        }
    }

    /// The disk of the sun (world space), if there is one.
    pub fn sun(&self) -> Option<&Sun> {
        self.sun.as_ref()
    }

    /// [`Self::light`] without the sun.
    pub fn grid_light(&self, density: SkyDensity, direction: Vec3) -> LightFrom {
        let light = self.grid.light(&self.samplers.of(density).grid, self.to_grid(direction));
        LightFrom { radiance: scaled(light.radiance, self.power), ..light }
    }

    /// [`Self::sample`] without the sun.
    pub fn sample_grid(&self, density: SkyDensity, random: [f32; 2]) -> Vec3 {
        self.turn.apply(self.samplers.of(density).grid.sample(random))
    }

    /// Numbers of columns and rows of the grid.
    pub fn size(&self) -> [usize; 2] {
        self.grid.size()
    }

    /// Returns true if no light comes from any direction.
    pub fn is_black(&self) -> bool {
        let is_sun_black = self.sun.is_none_or(|sun| sun.radiance == Vec3::ZERO);
        is_sun_black && (self.power == 0.0 || self.samplers.is_grid_black())
    }

    fn to_grid(&self, direction: Vec3) -> Vec3 {
        let Turn { sin, cos } = self.turn;
        Turn { sin: -sin, cos }.apply(direction)
    }
}

/// A rotation about Y. Not a quaternion, whose rounding errors would be those of the long axis where a
/// direction is nearly Y: columns of the grid are narrow there.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Turn {
    sin: f32,
    cos: f32,
}

impl Turn {
    fn new(degrees: f64) -> Self {
        // whole turns go first: they would cost digits
        let (sin, cos) = (degrees % 360.0).to_radians().sin_cos();
        Self { sin: sin as f32, cos: cos as f32 }
    }

    fn apply(self, Vec3 { x, y, z }: Vec3) -> Vec3 {
        Vec3::new(self.cos * x + self.sin * z, y, self.cos * z - self.sin * x)
    }
}

/// Scales a colour. The result is finite, whatever the factor.
fn scaled(color: Vec3, factor: f32) -> Vec3 {
    (color * factor).min(Vec3::MAX)
}

#[cfg(test)]
mod tests;
