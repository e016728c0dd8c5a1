//! Random directions, and the numbers that they are made of.

use glam::Vec3;

/// The random numbers of a path: an Owen-scrambled Sobol sequence (Burley, "Practical Hash-based Owen Scrambling", 2020),
/// so that the paths of a surface are spread evenly, and those of two surfaces have nothing in common.
#[derive(Debug, Clone, Copy)]
pub struct PathRandom {
    /// Of the surface.
    pub seed: u32,
    /// Number of the path among those of the surface.
    pub index: u32,
}

impl PathRandom {
    /// Four numbers from 0 to below 1; each `set` has its own.
    #[inline]
    pub fn four(self, set: u32) -> [f32; 4] {
        // as many dimensions as the sequence has: beyond them, new seeds
        let seed = self.seed.wrapping_add((set / SETS).wrapping_mul(0x9e37_79b9));
        sobol_burley::sample_4d(self.index, set % SETS, seed)
    }
}

/// Sets of four dimensions that the sequence has.
const SETS: u32 = sobol_burley::NUM_DIMENSION_SETS_4D;

/// The seed of a surface: of its place on its model, and of the model.
#[inline]
pub fn seed_of(place: Vec3, model: u32) -> u32 {
    let [x, y, z] = place.to_array().map(f32::to_bits);
    scrambled(scrambled(scrambled(scrambled(x) ^ y) ^ z) ^ model)
}

/// An integer hash in which each bit of the input changes each bit of the result about as often as not (Wellons'
/// "lowbias32").
#[inline]
fn scrambled(bits: u32) -> u32 {
    let bits = (bits ^ (bits >> 16)).wrapping_mul(0x7feb_352d);
    let bits = (bits ^ (bits >> 15)).wrapping_mul(0x846c_a68b);
    bits ^ (bits >> 16)
}

/// A direction by the cosine law about the last of three `axes` at right angles: by Malley's method, a disc of even
/// density below the half sphere. Unit length.
#[inline]
pub fn cosine_direction([along, above]: [f32; 2], [x, y, z]: [Vec3; 3]) -> Vec3 {
    let (sin, cos) = (std::f32::consts::TAU * above).sin_cos();
    let radius = along.sqrt();
    let up = (1.0 - along).max(0.0).sqrt();
    (x * (radius * cos) + y * (radius * sin) + z * up).normalize_or(z)
}

/// Two directions at right angles to `normal` (unit length) and to each other: Duff et al., "Building an Orthonormal
/// Basis, Revisited", 2017.
#[inline]
pub fn orthonormal(normal: Vec3) -> [Vec3; 2] {
    let sign = 1.0_f32.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    [
        Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_at_right_angles() {
        for normal in [Vec3::X, Vec3::NEG_Z, Vec3::Z, Vec3::new(0.6, -0.64, 0.48), Vec3::new(1e-4, 0.0, -1.0)]
        {
            let normal = normal.normalize();
            let [x, y] = orthonormal(normal);
            for (a, b, wanted) in [(x, x, 1.0), (y, y, 1.0), (x, y, 0.0), (x, normal, 0.0), (y, normal, 0.0)]
            {
                assert!((a.dot(b) - wanted).abs() < 1e-5, "{normal}: {x} {y}");
            }
        }
    }

    #[test]
    fn directions_follow_the_cosine_law() {
        let [x, y] = orthonormal(Vec3::Y);
        let random = |index| PathRandom { seed: 7, index }.four(0);
        let directions = (0..4096).map(|index| {
            let [along, above, ..] = random(index);
            cosine_direction([along, above], [x, y, Vec3::Y])
        });
        let (mut mean, mut square) = (Vec3::ZERO, 0.0);
        for direction in directions {
            assert!(direction.y >= 0.0 && (direction.length() - 1.0).abs() < 1e-5);
            mean += direction / 4096.0;
            square += direction.y * direction.y / 4096.0;
        }
        // the mean cosine is 2/3, and of its square 1/2
        assert!((mean - Vec3::Y * 2.0 / 3.0).length() < 2e-3, "{mean}");
        assert!((square - 0.5).abs() < 2e-3, "{square}");
    }

    #[test]
    fn sets_and_seeds_have_numbers_of_their_own() {
        let mut seen = std::collections::HashSet::new();
        for (seed, index, set) in [(1, 0, 0), (2, 0, 0), (1, 1, 0), (1, 0, 1), (1, 0, SETS), (1, 0, SETS + 1)]
        {
            let four = PathRandom { seed, index }.four(set);
            assert!(four.iter().all(|number| (0.0..1.0).contains(number)));
            assert!(seen.insert(four.map(f32::to_bits)), "{seed} {index} {set}");
        }
        assert_ne!(seed_of(Vec3::ONE, 0), seed_of(Vec3::ONE, 1));
        assert_ne!(seed_of(Vec3::X, 0), seed_of(Vec3::Y, 0));
    }
}
