//! Random directions, and the random numbers that they are made of.

use glam::Vec3;

use super::sobol;
use crate::geometry::angle;
use crate::scrambled::scrambled;

/// Random numbers of a path: a point of an Owen-scrambled Sobol sequence (Burley, "Practical Hash-based Owen
/// Scrambling", 2020). The paths of one sequence are spread evenly; those of two are independent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PathRandom {
    seed: u32,
    index: u32,
    /// Place of the point in the sequence with that seed.
    place: u32,
}

impl PathRandom {
    /// Point number `index`, below 65,536, of the sequence with this `seed`.
    #[inline]
    pub fn new(seed: u32, index: u32) -> Self {
        Self { seed, index, place: sobol::shuffled(index, seed) }
    }

    /// The same point of another sequence.
    pub fn apart(self, sequence: u32) -> Self {
        Self::new(scrambled(self.seed ^ sequence), self.index)
    }

    /// Four numbers from 0 to below 1; each `set` has others.
    #[inline]
    pub fn four(self, set: u32) -> [f32; 4] {
        match set / sobol::SETS {
            0 => sobol::four(self.place, set, self.seed),
            // as many dimensions as the sequence has: beyond them, new seeds
            beyond => {
                let seed = self.seed.wrapping_add(beyond.wrapping_mul(0x9e37_79b9));
                sobol::four(sobol::shuffled(self.index, seed), set % sobol::SETS, seed)
            }
        }
    }
}

/// Part of a sequence that belongs to the paths of a surface. The samples of a pixel share one sequence, each
/// with a part of its own: not only are the paths of each sample spread evenly, but all of the pixel's
/// together.
#[derive(Debug, Clone, Copy)]
pub struct PathSequence {
    seed: u32,
    /// First point of the surface's part.
    first: u32,
}

impl PathSequence {
    /// Creates the sequence of a surface that shares it with no other.
    pub fn of_seed(seed: u32) -> Self {
        Self { seed, first: 0 }
    }

    /// Creates the part of a sample with up to `paths` paths, which was first traced with this `seed`.
    pub fn of_sample(SampleSeed(seed): SampleSeed, paths: usize) -> Self {
        let paths = paths.next_power_of_two() as u32;
        let (pixel, number) = (seed >> NUMBER_BITS, seed & ((1 << NUMBER_BITS) - 1));
        // as many samples as the sequence has points for: beyond them, new seeds
        let samples = (POINTS / paths).max(1);
        Self { seed: scrambled(pixel ^ (number / samples) << 24), first: number % samples * paths }
    }

    /// Creates the part of a sample with up to `paths` reflected paths. They have no numbers in common with
    /// [others](Self::of_sample).
    pub fn of_reflections(seed: SampleSeed, paths: usize) -> Self {
        Self::of_sample(SampleSeed(seed.0 ^ OF_REFLECTIONS << NUMBER_BITS), paths)
    }

    /// Creates the sequence of reflected paths of a surface that shares it with no other.
    pub fn of_reflections_of_seed(seed: u32) -> Self {
        Self::of_seed(seed ^ OF_REFLECTIONS)
    }

    /// Creates the part of a sample with up to `paths` paths in media before it. They have no numbers in common with others.
    pub fn of_media(seed: SampleSeed, paths: usize) -> Self {
        Self::of_sample(SampleSeed(seed.0 ^ OF_MEDIA << NUMBER_BITS), paths)
    }

    /// Creates the sequence of paths in media along a ray that shares it with no other.
    pub fn of_media_of_seed(seed: u32) -> Self {
        Self::of_seed(seed ^ OF_MEDIA)
    }

    /// Random numbers of path number `index` of the surface.
    #[inline]
    pub fn path(self, index: u32) -> PathRandom {
        PathRandom::new(self.seed, self.first + index)
    }
}

/// Difference between the seeds of reflected paths and of others.
const OF_REFLECTIONS: u32 = 0x0032_b5ab;

/// Difference between the seeds of paths in media and of others.
const OF_MEDIA: u32 = 0x0059_c1e7;

/// Number of points of a sequence.
const POINTS: u32 = 1 << 16;

/// Seed of a sample's random numbers, for as long as it lives: 24 bits from the pixel in which it was first
/// traced, and the sample's number in that pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SampleSeed(u32);

/// Number of bits for the number of a sample in its pixel: a pixel has 16 x 16 at most.
pub const NUMBER_BITS: u32 = 8;

impl SampleSeed {
    /// Converts the seed to a word: the number in its lowest bits, the pixel above.
    #[inline]
    pub fn to_bits(self) -> u32 {
        self.0
    }

    /// Inverse of [`to_bits`](Self::to_bits); any other word is some seed, too.
    pub fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// A number from 0 to below 1 that belongs to the sample, and to no path of it.
    pub fn share(self) -> f32 {
        (scrambled(self.0 ^ 0x68e3_1da4) >> 8) as f32 / (1 << 24) as f32
    }

    /// Creates the seed of sample `number` of pixel number `pixel`, as seen from `view` and of a model in
    /// `pose`: hashes that change when camera or model move. So frames from one view have one noise, and
    /// surfaces that come into view pixel by pixel do not repeat that of the pixel before.
    pub fn new(pixel: u32, number: u32, view: u32, pose: u32) -> Self {
        let (pixel, number) = (scrambled(scrambled(pixel ^ view) ^ pose), number % (1 << NUMBER_BITS));
        Self(pixel << NUMBER_BITS | number)
    }
}

/// Seed of a surface, from its place on its model and from the model.
#[inline]
pub fn seed_of(place: Vec3, model: u32) -> u32 {
    scrambled(hash_of(&place.to_array()) ^ model)
}

/// Hash of these numbers.
#[inline]
pub fn hash_of(numbers: &[f32]) -> u32 {
    numbers.iter().fold(0, |hash, number| scrambled(hash ^ number.to_bits()))
}

/// Direction by the cosine law about the last of three `axes` at right angles: by Malley's method, a disc of
/// even density below the half sphere. Unit length.
#[inline]
pub fn cosine_direction([along, above]: [f32; 2], [x, y, z]: [Vec3; 3]) -> Vec3 {
    let [sin, cos] = angle::turned(above);
    let radius = along.sqrt();
    let up = (1.0 - along).max(0.0).sqrt();
    (x * (radius * cos) + y * (radius * sin) + z * up).normalize_or(z)
}

/// Two directions at right angles to `normal` (unit length) and to each other: Duff et al., "Building an
/// Orthonormal Basis, Revisited", 2017.
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
        let random = |index| PathRandom::new(7, index).four(0);
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

    /// Checks that, along each axis, all paths of a pixel fall into as many equal parts, each into one of its
    /// own; and so do those of each sample.
    #[test]
    fn the_paths_of_a_pixel_are_spread_evenly_together() {
        let paths = 16;
        let sequence = |number| PathSequence::of_sample(SampleSeed::new(77, number, 5, 0), paths);
        let of_sample = |number| (0..paths as u32).map(move |index| sequence(number).path(index));
        let all: Vec<PathRandom> = (0..16).flat_map(of_sample).collect();
        let own: Vec<PathRandom> = of_sample(5).collect();
        for points in [all, own] {
            for axis in 0..4 {
                let parts: std::collections::HashSet<usize> =
                    points.iter().map(|point| (point.four(0)[axis] * points.len() as f32) as usize).collect();
                assert_eq!(parts.len(), points.len(), "axis {axis}");
            }
        }
    }

    /// Checks that, where the sequence has too few points for a pixel, no two paths are the same.
    #[test]
    fn no_two_paths_of_a_pixel_are_the_same() {
        for (samples, paths) in [(256, 1024), (36, 12), (4, 1)] {
            let of_sample = |number| PathSequence::of_sample(SampleSeed::new(3, number, 0, 0), paths);
            let all = (0..samples).flat_map(|n| (0..paths as u32).map(move |index| of_sample(n).path(index)));
            let all: Vec<PathRandom> = all.collect();
            let seen: std::collections::HashSet<(u32, u32)> =
                all.iter().map(|at| (at.seed, at.index)).collect();
            assert_eq!(seen.len(), all.len(), "{samples} {paths}");
            assert!(all.iter().all(|at| at.index < POINTS));
        }
    }

    #[test]
    fn sets_and_seeds_have_numbers_of_their_own() {
        let mut seen = std::collections::HashSet::new();
        for (seed, index, set) in
            [(1, 0, 0), (2, 0, 0), (1, 1, 0), (1, 0, 1), (1, 0, sobol::SETS), (1, 0, sobol::SETS + 1)]
        {
            let four = PathRandom::new(seed, index).four(set);
            assert!(four.iter().all(|number| (0.0..1.0).contains(number)));
            assert!(seen.insert(four.map(f32::to_bits)), "{seed} {index} {set}");
        }
        assert_ne!(seed_of(Vec3::ONE, 0), seed_of(Vec3::ONE, 1));
        assert_ne!(seed_of(Vec3::X, 0), seed_of(Vec3::Y, 0));
    }
}
