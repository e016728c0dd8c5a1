//! Samples that are seen by way of flat mirrors, and where to find them.
//!
//! What a mirror shows is a place on another surface. Its light does not depend on the mirror, nor on the eye if it is matt: it is
//! kept, by the place, for as long as nothing that moves touches what it was found with. Which of them the eye sees in which cell is
//! asked in each frame anew (`src/frame/secondary/mirrors.rs`).
//!
//! They are found by [voxels](Voxel) about as wide as what a cell shows of the surface, so that a few of them lie in each.

use glam::Vec3;

use super::Octahedral;
use crate::changes::Until;
use crate::scrambled::scrambled;

/// Frames in a row, of those that ask, after which a sample that serves no cell is dropped. Neighbours change places as the eye moves, and
/// what serves none now may in the next frame.
const MOST_UNUSED: u8 = 2;

/// A sample that is seen by way of flat mirrors. Its surface rests as long as the sample holds: places are in world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MirroredSample {
    /// Its point, world space.
    pub point: Vec3,
    /// Barycentric weights of the second and third corner there, as the ray tracer found them.
    pub weights: [f32; 2],
    /// Index into [`Scene::models`](crate::scene::Scene::models).
    pub model: u32,
    /// Number of the triangle.
    pub triangle: u32,
    /// Normal of the triangle on the side that is seen, world space.
    pub geometric_normal: Octahedral,
    /// Radiance towards whoever looks.
    pub light: Vec3,
    /// Width over which its textures were filtered, world space.
    pub width: f32,
    /// First frame in which its light may differ.
    pub until: Until,
    /// Number of paths by which it gathered light.
    pub paths: u16,
    /// Size of its [`Voxel`].
    pub octave: i8,
    /// Frames in a row in which it served no cell.
    pub unused: u8,
}

/// Edge length of voxels, as a power of 2: the least above the width of a cell.
pub fn octave_of(width: f32) -> i8 {
    /// Exponent of the float 1.
    const BIAS: i32 = 127;
    let exponent = (width.to_bits() >> 23 & 0xff) as i32;
    (exponent - BIAS + 1).clamp(i8::MIN.into(), i8::MAX.into()) as i8
}

/// Place of a surface for finding what is near: a square of the plane of two axes that the surface is nearest to. How far it is along the
/// third axis makes no difference: few surfaces that face the same way lie before each other, and who looks for one tells them apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Voxel {
    model: u32,
    octave: i8,
    /// The axis that is left out, and the side of it that the surface faces.
    facing: u8,
    at: [i32; 2],
}

/// Voxels along the edge of a block of them that lie side by side in memory.
const BLOCK: i32 = 8;

impl Voxel {
    /// The voxel of a sample.
    fn of(sample: &MirroredSample) -> Self {
        let normal = sample.geometric_normal.unfold();
        let (facing, [u, v]) = projected(normal, sample.point);
        let scale = scale_of(sample.octave);
        let at = [u, v].map(|at| whole(at * scale));
        Self { model: sample.model, octave: sample.octave, facing, at }
    }

    /// The four around a place that are nearest to it.
    fn around(model: u32, octave: i8, normal: Vec3, point: Vec3) -> [Self; 4] {
        let (facing, [u, v]) = projected(normal, point);
        let scale = scale_of(octave);
        let [u, v] = [u, v].map(|at| whole(at * scale - 0.5));
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[across, up]| Self {
            model,
            octave,
            facing,
            at: [u.wrapping_add(across), v.wrapping_add(up)],
        })
    }

    /// Its list among `count`, a power of two that is at least [`BLOCK`] squared.
    fn bucket(self, count: usize) -> usize {
        let of_block = self.at.map(|at| at.div_euclid(BLOCK) as u32);
        let named = [self.model, self.octave as u32, u32::from(self.facing)];
        let hash = named.into_iter().chain(of_block).fold(0, |hash, word| scrambled(hash ^ word));
        let [x, y] = self.at.map(|at| at.rem_euclid(BLOCK) as usize);
        let in_block = y * BLOCK as usize + x;
        ((hash as usize) * (BLOCK * BLOCK) as usize + in_block) & (count - 1)
    }
}

/// The axis along which `normal` is longest, with its side, and the coordinates of `point` along the others.
fn projected(normal: Vec3, point: Vec3) -> (u8, [f32; 2]) {
    let long = normal.abs();
    let axis = if long.x >= long.y && long.x >= long.z { 0 } else { 2 - usize::from(long.y >= long.z) };
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3].map(|other| point[other]);
    (2 * axis as u8 + u8::from(normal[axis] < 0.0), [u, v])
}

/// Voxels in a unit of length.
fn scale_of(octave: i8) -> f32 {
    (-f32::from(octave)).exp2()
}

/// The whole number below; numbers that have none are as good as any.
fn whole(number: f32) -> i32 {
    number.floor() as i32
}

/// Samples that are seen by way of flat mirrors, in the order of their lists.
#[derive(Debug, Clone, Default)]
pub struct MirroredSamples {
    all: Vec<MirroredSample>,
    /// Number of the first sample of each list, and behind them the number of all; empty without samples.
    starts: Vec<u32>,
}

/// What a tile asks of the samples of the frame before, and what it leaves to those of its own.
#[derive(Debug, Default)]
pub struct MirroredOfTile {
    /// Numbers of the samples that serve its cells.
    pub used: Vec<u32>,
    /// New ones.
    pub made: Vec<MirroredSample>,
}

impl MirroredSamples {
    /// Bytes of one, with its share of the lists.
    pub const BYTES: u64 = (size_of::<MirroredSample>() + 2 * size_of::<u32>()) as u64;

    /// Sorts samples into lists. The order of those in a list stays.
    pub fn new(samples: Vec<MirroredSample>) -> Self {
        if samples.is_empty() {
            return Self::default();
        }
        let count = samples.len().next_power_of_two().max((BLOCK * BLOCK) as usize);
        let buckets: Vec<u32> = samples.iter().map(|sample| Voxel::of(sample).bucket(count) as u32).collect();
        let mut starts = vec![0_u32; count + 1];
        buckets.iter().for_each(|bucket| starts[*bucket as usize + 1] += 1);
        for bucket in 0..count {
            starts[bucket + 1] += starts[bucket];
        }
        let mut next = starts.clone();
        let mut order = vec![0_u32; samples.len()];
        for (number, bucket) in (0..).zip(buckets) {
            let place = &mut next[bucket as usize];
            order[*place as usize] = number;
            *place += 1;
        }
        let all = order.into_iter().map(|number| samples[number as usize]).collect();
        Self { all, starts }
    }

    /// Those of the next frame, of which `tiles` say in their order what they use and make, and for which `holds` is true. What nobody
    /// has used for [a while](MOST_UNUSED) goes.
    pub fn next<'t>(
        &self,
        tiles: impl Iterator<Item = &'t mut MirroredOfTile>,
        holds: impl Fn(&MirroredSample) -> bool,
    ) -> Self {
        let mut is_used = vec![false; self.all.len()];
        let mut made = Vec::new();
        for MirroredOfTile { used, made: of_tile } in tiles {
            std::mem::take(used).into_iter().for_each(|number| is_used[number as usize] = true);
            made.append(&mut std::mem::take(of_tile));
        }
        let kept = self.all.iter().zip(is_used).map(|(sample, is_used)| {
            let unused = if is_used { 0 } else { sample.unused.saturating_add(1) };
            MirroredSample { unused, ..*sample }
        });
        let stays = |sample: &MirroredSample| sample.unused <= MOST_UNUSED && holds(sample);
        Self::new(kept.filter(stays).chain(made).collect())
    }

    /// All of them.
    pub fn all(&self) -> &[MirroredSample] {
        &self.all
    }

    /// All of them, to be changed in anything but their places.
    pub fn all_mut(&mut self) -> &mut [MirroredSample] {
        &mut self.all
    }

    /// Calls `each` with the number and the sample of those that may lie near `point` on a surface of `model` with this normal (world
    /// space, on the side that is seen), of the cells of which voxels are so large; and with others that have nothing to do with it.
    pub fn near(
        &self,
        (model, octave): (u32, i8),
        (point, normal): (Vec3, Vec3),
        mut each: impl FnMut(u32, &MirroredSample),
    ) {
        let Some(count) = self.starts.len().checked_sub(1) else { return };
        for voxel in Voxel::around(model, octave, normal, point) {
            let bucket = voxel.bucket(count);
            let [from, to] = [self.starts[bucket], self.starts[bucket + 1]];
            (from..).zip(&self.all[from as usize..to as usize]).for_each(|(number, one)| each(number, one));
        }
    }

    /// Memory held, in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.all[..]) + size_of_val(&self.starts[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(point: Vec3) -> MirroredSample {
        MirroredSample {
            point,
            weights: [0.0; 2],
            model: 3,
            triangle: 0,
            geometric_normal: Octahedral::fold(Vec3::new(0.1, -0.9, 0.3).normalize()),
            light: Vec3::ONE,
            width: 0.0,
            until: Until::FOREVER,
            paths: 4,
            octave: octave_of(0.3),
            unused: 0,
        }
    }

    fn found(samples: &MirroredSamples, point: Vec3) -> Vec<Vec3> {
        let mut all = Vec::new();
        let normal = Vec3::new(0.1, -0.9, 0.3).normalize();
        samples.near((3, octave_of(0.3)), (point, normal), |_, one| all.push(one.point));
        all
    }

    #[test]
    fn voxels_are_wider_than_cells_and_no_more_than_twice() {
        for width in [1e-20_f32, 0.3, 0.5, 0.99, 1.0, 7.0, 1e20] {
            let edge = f64::from(octave_of(width)).exp2();
            assert!(edge > f64::from(width) && edge <= 2.0 * f64::from(width), "{width}: {edge}");
        }
    }

    #[test]
    fn what_lies_within_half_a_voxel_is_found() {
        let points: Vec<Vec3> = (0..900)
            .map(|at| Vec3::new(0.21 * (at % 30) as f32 - 3.0, 1.0, 0.17 * (at / 30) as f32 - 2.0))
            .collect();
        let samples = MirroredSamples::new(points.iter().map(|point| sample(*point)).collect());
        assert_eq!(samples.all().len(), 900);
        for point in &points {
            let at = *point + Vec3::new(0.2, 0.3, -0.2);
            let found = found(&samples, at);
            assert!(found.contains(point), "{point}");
            assert!(found.len() < 90, "{}", found.len());
        }
        assert!(found(&MirroredSamples::default(), Vec3::ZERO).is_empty());
    }

    #[test]
    fn what_nobody_uses_goes_after_a_while_and_the_order_is_that_of_the_tiles() {
        let mut samples = MirroredSamples::new(vec![sample(Vec3::ZERO), sample(Vec3::X)]);
        let used = |samples: &MirroredSamples, point: Vec3| {
            samples.all().iter().position(|one| one.point == point).expect("it is there") as u32
        };
        for frame in 0..=MOST_UNUSED {
            assert_eq!(samples.all().len(), 2, "{frame}");
            let mut tile = MirroredOfTile { used: vec![used(&samples, Vec3::X); 2], made: vec![] };
            samples = samples.next([&mut tile].into_iter(), |_| true);
        }
        assert_eq!(samples.all().iter().map(|one| one.point).collect::<Vec<_>>(), [Vec3::X]);
        let of_tile = |at: f32| MirroredOfTile { used: vec![], made: vec![sample(Vec3::X * at)] };
        let mut tiles = [of_tile(1e-3), of_tile(2e-3)];
        let next = samples.next(tiles.iter_mut(), |one| one.point != Vec3::X);
        assert_eq!(next.all().iter().map(|one| one.point.x).collect::<Vec<_>>(), [1e-3, 2e-3]);
    }
}
