//! Gabor noise, waves of one direction and length in random patches: Blender's Gabor Texture node.
//!
//! Lagae et al., "Procedural Noise using Sparse Gabor Convolution" (SIGGRAPH 2009), with the fixed number of
//! impulses in a cell and the even weights of Tavernier et al., "Making Gabor Noise Fast and Normalized"
//! (Eurographics 2019). Phase and intensity are those of Tricard et al., "Procedural Phasor Noise" (SIGGRAPH
//! 2019).

use std::f32::consts::{PI, SQRT_2, TAU};

use glam::{Vec2, Vec3};

use super::voronoi_cells::around;
use super::{difference, dot, finite, hash, scaled, sum_of};

/// Impulses in a cell.
const IMPULSES: usize = 8;

/// Options of the Gabor Texture node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Gabor {
    /// Of X and Y.
    Flat,
    /// Of X, Y, and Z.
    Solid,
}

/// Inputs of the Gabor Texture node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaborInputs {
    /// Multiplies the place: the number of cells in a unit.
    pub scale: f32,
    /// Waves in a cell; at least 0.001 (clamped).
    pub frequency: f32,
    /// 1 where all waves go one way, 0 where each goes its own (clamped).
    pub anisotropy: f32,
    /// Which way, radians from X to Y: the Orientation of [`Gabor::Flat`].
    pub orientation_2d: f32,
    /// Which way, of any length: the Orientation of [`Gabor::Solid`].
    pub orientation_3d: Vec3,
}

impl Default for GaborInputs {
    /// Those of a new node.
    fn default() -> Self {
        Self {
            scale: 5.0,
            frequency: 2.0,
            anisotropy: 1.0,
            orientation_2d: PI / 4.0,
            orientation_3d: Vec3::new(SQRT_2, SQRT_2, 0.0),
        }
    }
}

/// Outputs of the Gabor Texture node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaborOutput {
    /// The noise, mostly 0 to 1.
    pub value: f32,
    /// Place within a wave, 0 to 1: saw teeth, however strong the wave is.
    pub phase: f32,
    /// How strong the wave is, 0 to mostly 1.
    pub intensity: f32,
}

impl Gabor {
    /// The output Value, mostly 0 to 1.
    pub fn value(&self, vector: Vec3, inputs: &GaborInputs) -> f32 {
        self.outputs(vector, inputs).value
    }

    /// All outputs.
    pub fn outputs(&self, vector: Vec3, inputs: &GaborInputs) -> GaborOutput {
        let place = vector * inputs.scale;
        let isotropy = 1.0 - inputs.anisotropy.clamp(0.0, 1.0);
        let frequency = inputs.frequency.max(0.001);
        // The mean of the squared kernel over space, for waves much shorter than a cell: Lagae et al.,
        // equation 9.
        let (phasor, square) = match self {
            Self::Flat => {
                let waves = FlatWaves { frequency, isotropy, angle: inputs.orientation_2d };
                (phasor_of(place.truncate().to_array(), &waves), 0.25)
            }
            Self::Solid => {
                let waves = SolidWaves::new(frequency, isotropy, inputs.orientation_3d);
                (phasor_of(place.to_array(), &waves), 0.25 / SQRT_2)
            }
        };
        // Blender takes a half for the mean square of the weights. Six standard deviations hold nearly all
        // values.
        let full = 6.0 * (IMPULSES as f32 * 0.5 * square).sqrt();
        GaborOutput {
            value: finite(phasor.y / full * 0.5 + 0.5),
            phase: finite((phasor.y.atan2(phasor.x) + PI) / TAU),
            intensity: finite(phasor.length() / full),
        }
    }
}

/// The random impulses of a cell. Each is known by the cell and a number within it.
trait Waves<const N: usize> {
    /// Where it is within the cell, each axis 0 to 1.
    fn centre(&self, cell: [f32; N], seed: f32) -> [f32; N];
    /// The direction of its waves, as long as there are waves in a unit.
    fn frequency(&self, cell: [f32; N], seed: f32) -> [f32; N];
    /// A random number, 0 to 1.
    fn chance(&self, cell: [f32; N], seed: f32) -> f32;
}

/// The sum of all impulses that reach a place, cosine and sine. The sine is the noise: its mean is zero.
fn phasor_of<const N: usize>(place: [f32; N], waves: &impl Waves<N>) -> Vec2 {
    let place = place.map(finite);
    let floor = place.map(f32::floor);
    let local = difference(place, floor);
    let mut sum = Vec2::ZERO;
    around(1, |offset: [i32; N]| {
        let offset = offset.map(|part| part as f32);
        sum += phasor_of_cell(sum_of(floor, offset), difference(local, offset), waves);
    });
    sum
}

fn phasor_of_cell<const N: usize>(cell: [f32; N], local: [f32; N], waves: &impl Waves<N>) -> Vec2 {
    let mut sum = Vec2::ZERO;
    for impulse in 0..IMPULSES {
        let seed = |part: usize| (impulse * 3 + part) as f32;
        let from_centre = difference(local, waves.centre(cell, seed(1)));
        let square = dot(from_centre, from_centre);
        if square >= 1.0 {
            continue;
        }
        // A window of Hann ends the Gaussian without a step.
        let envelope = (-PI * square).exp() * (0.5 + 0.5 * (PI * square).cos());
        let angle = TAU * dot(from_centre, waves.frequency(cell, seed(0)));
        let sign = if waves.chance(cell, seed(2)) < 0.5 { -1.0 } else { 1.0 };
        sum += sign * envelope * Vec2::from_angle(angle);
    }
    sum
}

/// Waves in the plane.
struct FlatWaves {
    frequency: f32,
    isotropy: f32,
    angle: f32,
}

impl Waves<2> for FlatWaves {
    fn centre(&self, [x, y]: [f32; 2], seed: f32) -> [f32; 2] {
        hash::unit2_of3([x, y, seed]).to_array()
    }

    fn frequency(&self, cell: [f32; 2], seed: f32) -> [f32; 2] {
        // Half a turn is all: the kernel is the same the other way round.
        let turn = (self.chance(cell, seed) - 0.5) * PI * self.isotropy;
        scaled(Vec2::from_angle(self.angle + turn).to_array(), self.frequency)
    }

    fn chance(&self, [x, y]: [f32; 2], seed: f32) -> f32 {
        hash::unit([x, y, seed])
    }
}

/// Waves in space.
struct SolidWaves {
    frequency: f32,
    isotropy: f32,
    /// Unit length.
    direction: Vec3,
    /// The angle of `direction` from Z, and that about Z from X to Y.
    angles: Vec2,
}

impl SolidWaves {
    fn new(frequency: f32, isotropy: f32, direction: Vec3) -> Self {
        let direction = direction.normalize_or_zero();
        let angles = Vec2::new(direction.z.clamp(-1.0, 1.0).acos(), direction.y.atan2(direction.x));
        Self { frequency, isotropy, direction, angles }
    }
}

impl Waves<3> for SolidWaves {
    fn centre(&self, [x, y, z]: [f32; 3], seed: f32) -> [f32; 3] {
        hash::unit3_of4([x, y, z, seed]).to_array()
    }

    fn frequency(&self, [x, y, z]: [f32; 3], seed: f32) -> [f32; 3] {
        if self.isotropy == 0.0 {
            return (self.direction * self.frequency).to_array();
        }
        let turned = self.angles + hash::unit2_of4([x, y, z, seed]) * PI * self.isotropy;
        let (from_z, about_z) = (Vec2::from_angle(turned.x), Vec2::from_angle(turned.y));
        (Vec3::new(from_z.y * about_z.x, from_z.y * about_z.y, from_z.x) * self.frequency).to_array()
    }

    fn chance(&self, [x, y, z]: [f32; 3], seed: f32) -> f32 {
        hash::unit([x, y, z, seed])
    }
}
