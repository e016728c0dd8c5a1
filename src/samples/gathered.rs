//! Light that samples gather from all around, path by path, that which their layers reflect, and their
//! openness, with the frames until which these are valid.
//!
//! A path is a function of the sample, of its seed, which is stored, and of the scene in a frame. So a valid
//! path is not traced again, however often the sample is handed on, and an invalid one is replaced alone.

use wide::u32x8;

use super::store::{HalfColor, full_color, half_colors};
use super::{Openness, ReflectedPaths, TagLayout};
use crate::changes::Until;
use crate::lanes::{F32x8, LANES, Vec3x8};
use crate::shade::sampling::SampleSeed;

/// Result of a path, or the mean of those of a sample's paths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathLight {
    /// Radiance, linear RGB.
    pub radiance: HalfColor,
    /// First frame in which the radiance may differ.
    pub until: Until,
}

const _: () = assert!(size_of::<PathLight>() == 8);

impl PathLight {
    /// Result that is not known.
    pub const UNKNOWN: Self = Self { radiance: [half::f16::ZERO; 3], until: Until::UNKNOWN };
}

/// Gathered and reflected light, openness and seeds of random numbers of a list of samples. There is nothing for what
/// samples do not gather, and no seeds where samples use no random numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GatheredLight {
    /// True if samples have seeds.
    is_seeded: bool,
    /// Number of paths of each sample.
    pub(super) paths: usize,
    /// Number of each sample's occlusion rays.
    pub(super) rays: usize,
    /// Results of paths, sample by sample.
    of_paths: Vec<PathLight>,
    /// Mean of each sample's known paths, with the first frame in which any of them may differ.
    pub(super) means: Vec<PathLight>,
    /// Paths by which the samples' layers reflect.
    pub reflected: ReflectedPaths,
    /// Openness of each sample.
    pub(super) openness: Vec<Openness>,
    /// Seed of each sample's random numbers.
    pub(super) seeds: Vec<SampleSeed>,
}

impl GatheredLight {
    /// Creates `count` samples of which nothing is known, for this `layout`.
    pub fn unknown(layout: &TagLayout, count: usize) -> Self {
        let TagLayout { paths, occlusion_rays: rays, is_seeded, .. } = *layout;
        Self {
            is_seeded,
            paths,
            rays,
            of_paths: vec![PathLight::UNKNOWN; paths * count],
            means: vec![PathLight::UNKNOWN; if paths == 0 { 0 } else { count }],
            reflected: ReflectedPaths::unknown(layout, count),
            openness: vec![Openness::UNKNOWN; if rays == 0 { 0 } else { count }],
            seeds: vec![SampleSeed::default(); if is_seeded { count } else { 0 }],
        }
    }

    /// Size of a sample's part, in bytes.
    pub fn bytes_of_sample(layout: &TagLayout) -> usize {
        let of_light = if layout.paths == 0 { 0 } else { (layout.paths + 1) * size_of::<PathLight>() };
        let of_openness = if layout.occlusion_rays == 0 { 0 } else { size_of::<Openness>() };
        let of_reflection = ReflectedPaths::bytes_of_sample(layout);
        of_light + of_reflection + of_openness + if layout.is_seeded { size_of::<SampleSeed>() } else { 0 }
    }

    /// Returns memory that is not needed.
    pub fn trim(&mut self) {
        self.of_paths.shrink_to_fit();
        self.means.shrink_to_fit();
        self.reflected.trim();
        self.openness.shrink_to_fit();
        self.seeds.shrink_to_fit();
    }

    /// Memory held on the heap, in bytes.
    pub fn bytes(&self) -> usize {
        (self.of_paths.capacity() + self.means.capacity()) * size_of::<PathLight>()
            + self.reflected.bytes()
            + self.openness.capacity() * size_of::<Openness>()
            + self.seeds.capacity() * size_of::<SampleSeed>()
    }

    /// Returns true if samples gather light.
    pub fn is_some(&self) -> bool {
        self.paths != 0
    }

    /// Returns true if samples have seeds: all samples that gather or reflect anything have.
    pub fn is_seeded(&self) -> bool {
        self.is_seeded
    }

    /// Results of a sample's paths, in their order.
    pub fn paths(&self, sample: usize) -> &[PathLight] {
        &self.of_paths[sample * self.paths..(sample + 1) * self.paths]
    }

    /// Number of paths of a sample that are known: the first ones.
    pub fn known(&self, sample: usize) -> usize {
        known_of(self.paths(sample)).len()
    }

    /// Mean of a sample's known paths.
    pub fn mean(&self, sample: usize) -> PathLight {
        self.means[sample]
    }

    /// [Means](Self::mean) of eight samples, from `first` on: radiance, black where samples gather none.
    #[inline(always)]
    pub fn means(&self, first: usize) -> Vec3x8 {
        let mut eight = Vec3x8::ZERO;
        if self.is_some() {
            for (lane, mean) in self.means[first..first + LANES].iter().enumerate() {
                eight.set_lane(lane, full_color(mean.radiance));
            }
        }
        eight
    }

    /// Stores the result of path number `path` of a sample. The caller has to [update the
    /// mean](Self::update_mean).
    pub fn set_path(&mut self, sample: usize, path: usize, light: PathLight) {
        self.of_paths[sample * self.paths + path] = light;
    }

    /// Marks a sample as one that gathers no light, for good.
    pub fn set_dark(&mut self, sample: usize) {
        let dark = PathLight { until: Until::FOREVER, ..PathLight::UNKNOWN };
        let paths = self.paths;
        self.of_paths[sample * paths..(sample + 1) * paths].fill(dark);
        self.means[sample] = dark;
    }

    /// Computes the mean of a sample's paths anew. Returns true if its radiance has changed.
    pub fn update_mean(&mut self, sample: usize) -> bool {
        let mean = mean_of(self.paths(sample));
        let before = std::mem::replace(&mut self.means[sample], mean);
        before.radiance != mean.radiance || before.until == Until::UNKNOWN
    }

    /// Openness of a sample.
    pub fn openness(&self, sample: usize) -> Openness {
        self.openness[sample]
    }

    /// Stores the openness of a sample. Returns true if it has changed.
    pub fn set_openness(&mut self, sample: usize, openness: Openness) -> bool {
        let before = std::mem::replace(&mut self.openness[sample], openness);
        before.until == Until::UNKNOWN || before.open != openness.open
    }

    /// Share of open rays of eight samples, from `first` on. Samples must have occlusion rays.
    #[inline(always)]
    pub fn opennesses(&self, first: usize) -> F32x8 {
        let (eight, rays) = (&self.openness[first..first + LANES], self.rays as f32);
        F32x8::new(std::array::from_fn(|lane| f32::from(eight[lane].open) / rays))
    }

    /// Resets light and openness of the samples whose number `is_doubtful`.
    pub fn forget(&mut self, is_doubtful: impl Fn(usize) -> bool) {
        // all samples that keep any of these have a seed
        let samples = self.seeds.len();
        for sample in (0..samples).filter(|sample| is_doubtful(*sample)) {
            self.forget_one(sample);
        }
    }

    /// Resets light and openness of a sample.
    pub(super) fn forget_one(&mut self, sample: usize) {
        if self.is_some() {
            self.of_paths[sample * self.paths..(sample + 1) * self.paths].fill(PathLight::UNKNOWN);
            self.means[sample] = PathLight::UNKNOWN;
        }
        self.reflected.forget_one(sample);
        if self.rays != 0 {
            self.openness[sample] = Openness::UNKNOWN;
        }
    }

    /// Seed of a sample's random numbers.
    pub fn seed(&self, sample: usize) -> SampleSeed {
        self.seeds[sample]
    }

    /// Resets a sample to a new one with this seed, of which nothing is known.
    pub fn begin(&mut self, sample: usize, seed: SampleSeed) {
        self.seeds[sample] = seed;
        self.forget_one(sample);
    }

    /// Seeds of eight samples, from `first` on, as words; 0 if samples have none.
    #[inline(always)]
    pub fn seeds(&self, first: usize) -> u32x8 {
        match self.seeds.get(first..first + LANES) {
            Some(seeds) => u32x8::new(std::array::from_fn(|lane| seeds[lane].to_bits())),
            None => u32x8::ZERO,
        }
    }

    /// Postpones the expiry of all paths by a frame. Returns the number of those that do expire. For tests of
    /// the audit.
    pub fn delay(&mut self) -> u64 {
        let mut count = 0;
        for light in self.of_paths.iter_mut().chain(&mut self.means) {
            count += u64::from(light.until.delay());
        }
        count
    }

    /// Postpones the expiry of all reflected paths in the same way.
    pub fn delay_reflected(&mut self) -> u64 {
        self.reflected.validity().map(|until| u64::from(until.delay())).sum()
    }

    /// Postpones the expiry of all openness in the same way.
    pub fn delay_openness(&mut self) -> u64 {
        self.openness.iter_mut().map(|openness| u64::from(openness.until.delay())).sum()
    }

    /// Replaces the expiry of everything by what `changed` returns for it.
    pub fn change_validity(&mut self, changed: impl Fn(Until) -> Until) {
        let lights = self.of_paths.iter_mut().chain(&mut self.means).map(|light| &mut light.until);
        let lights = lights.chain(self.reflected.validity());
        let openness = self.openness.iter_mut().map(|openness| &mut openness.until);
        lights.chain(openness).for_each(|until| *until = changed(*until));
    }

    /// Resets light and openness of all samples.
    pub fn forget_all(&mut self) {
        self.of_paths.fill(PathLight::UNKNOWN);
        self.means.fill(PathLight::UNKNOWN);
        self.reflected.forget_all();
        self.openness.fill(Openness::UNKNOWN);
    }

    /// Copies sample number `at` of `from` to `sample`.
    #[inline]
    pub fn copy(&mut self, sample: usize, from: &Self, at: usize) {
        if self.is_some() {
            let paths = self.paths;
            self.of_paths[sample * paths..(sample + 1) * paths].copy_from_slice(from.paths(at));
            self.means[sample] = from.means[at];
        }
        self.reflected.copy(sample, &from.reflected, at);
        if self.rays != 0 {
            self.openness[sample] = from.openness[at];
        }
        if self.is_seeded {
            self.seeds[sample] = from.seeds[at];
        }
    }

    /// Appends sample number `at` of `from` to the list.
    pub fn push(&mut self, from: &Self, at: usize) {
        if self.is_some() {
            self.of_paths.extend_from_slice(from.paths(at));
            self.means.push(from.means[at]);
        }
        self.reflected.push(&from.reflected, at);
        if self.rays != 0 {
            self.openness.push(from.openness[at]);
        }
        if self.is_seeded {
            self.seeds.push(from.seeds[at]);
        }
    }

    /// Removes all samples, and keeps their memory.
    pub fn clear(&mut self) {
        self.of_paths.clear();
        self.means.clear();
        self.reflected.clear();
        self.openness.clear();
        self.seeds.clear();
    }
}

/// Paths that are known: the first ones.
fn known_of(paths: &[PathLight]) -> &[PathLight] {
    let known = paths.iter().position(|path| path.until == Until::UNKNOWN);
    &paths[..known.unwrap_or(paths.len())]
}

/// Mean of the paths that are known, with the first frame in which any of them may differ.
pub fn mean_of(paths: &[PathLight]) -> PathLight {
    let paths = known_of(paths);
    if paths.is_empty() {
        return PathLight::UNKNOWN;
    }
    let sum =
        paths.iter().map(|path| full_color(path.radiance)).fold(glam::Vec3::ZERO, |sum, light| sum + light);
    let until = paths.iter().fold(Until::FOREVER, |least, path| least.min(path.until));
    let [radiance, ..] = half_colors(Vec3x8::splat(sum / paths.len() as f32));
    PathLight { radiance, until }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn light(value: f32) -> PathLight {
        let [radiance, ..] = half_colors(Vec3x8::splat(Vec3::splat(value)));
        PathLight { radiance, until: Until::FOREVER }
    }

    #[test]
    fn a_mean_is_that_of_the_paths_that_are_known() {
        let layout = TagLayout::default().with_paths(4);
        let mut gathered = GatheredLight::unknown(&layout, 8);
        let seed = SampleSeed::new(7, 3, 1, 2);
        gathered.begin(5, seed);
        gathered.update_mean(5);
        assert_eq!((gathered.mean(5), gathered.known(5)), (PathLight::UNKNOWN, 0));
        (0..3).for_each(|path| gathered.set_path(5, path, light(path as f32)));
        assert!(gathered.update_mean(5));
        assert_eq!((gathered.mean(5), gathered.known(5)), (light(1.0), 3));
        gathered.set_path(5, 3, light(3.0));
        assert!(gathered.update_mean(5));
        assert_eq!(gathered.mean(5), light(1.5));
        assert!(!gathered.update_mean(5), "it is the same again");
        assert_eq!(gathered.means(0).lane(5), Vec3::splat(1.5));
        let mut spares = GatheredLight::unknown(&layout, 0);
        spares.push(&gathered, 5);
        gathered.begin(5, SampleSeed::default());
        assert_eq!(gathered, GatheredLight::unknown(&layout, 8));
        gathered.copy(2, &spares, 0);
        assert_eq!((gathered.mean(2), gathered.paths(2)[3]), (light(1.5), light(3.0)));
        assert_eq!(gathered.seed(2), seed, "wherever it goes");
    }

    #[test]
    fn openness_goes_with_its_sample() {
        let layout = TagLayout::default().with_occlusion(8);
        let mut gathered = GatheredLight::unknown(&layout, 16);
        let half = Openness { open: 4, until: Until::FOREVER };
        assert!(gathered.set_openness(9, Openness::CLOSED), "nothing was known");
        assert!(gathered.set_openness(9, half) && !gathered.set_openness(9, half));
        assert_eq!(gathered.opennesses(8).lane(1), 0.5);
        let mut spares = GatheredLight::unknown(&layout, 0);
        spares.push(&gathered, 3);
        spares.push(&gathered, 9);
        gathered.begin(9, SampleSeed::default());
        assert_eq!(gathered, GatheredLight::unknown(&layout, 16));
        gathered.copy(2, &spares, 1);
        assert_eq!(gathered.openness(2), half);
        spares.forget(|number| number == 1);
        assert_eq!(spares.openness(1), Openness::UNKNOWN);
        assert!(!gathered.is_some() && gathered.is_seeded());
        assert_eq!(GatheredLight::bytes_of_sample(&layout), 8);
    }

    #[test]
    fn without_paths_nothing_is_held() {
        let layout = TagLayout::default();
        let mut none = GatheredLight::unknown(&layout, 1024);
        none.copy(3, &none.clone(), 9);
        none.push(&GatheredLight::default(), 0);
        assert_eq!((none.bytes(), GatheredLight::bytes_of_sample(&layout)), (0, 0));
        assert_eq!(none.means(8).lane(0), Vec3::ZERO);
        assert_eq!(GatheredLight::bytes_of_sample(&layout.with_paths(16)), 140);
    }
}
