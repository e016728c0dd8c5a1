//! Light that samples gather from all around, path by path, that which their layers reflect, and their
//! openness, with the frames until which these are valid.
//!
//! A path is a function of the sample, of its seed, which is stored, and of the scene in a frame. So a valid
//! path is not traced again, however often the sample is handed on, and an invalid one is replaced alone.

use wide::u32x8;

use super::store::{full_color, half_colors};
use super::{HalfColor, KeptPath, Octahedral, Openness, PathColor, PathList, TagLayout};
use crate::changes::Until;
use crate::lanes::{F32x8, LANES, Vec3x8};
use crate::shade::sampling::SampleSeed;

/// Mean of what a sample's paths have brought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathLight {
    /// Radiance, linear RGB.
    pub radiance: HalfColor,
    /// First frame in which the radiance may differ.
    pub until: Until,
}

const _: () = assert!(size_of::<PathLight>() == 8);

impl PathLight {
    /// Mean that is not known.
    pub const UNKNOWN: Self = Self { radiance: [half::f16::ZERO; 3], until: Until::UNKNOWN };
}

/// Gathered and reflected light, openness and seeds of random numbers of a list of samples. There is nothing for what
/// samples do not gather, and no seeds where samples use no random numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GatheredLight {
    /// True if samples have seeds.
    is_seeded: bool,
    /// Number of each sample's occlusion rays.
    pub(super) rays: usize,
    /// Paths by which samples gather light.
    pub paths: PathList,
    /// Mean of each sample's known paths, with the first frame in which any of them may differ.
    pub(super) means: Vec<PathLight>,
    /// Paths by which the samples' layers reflect. A layer need not have all of them.
    pub reflected: PathList,
    /// Direction to the eye for which each sample's reflected paths were drawn; world space.
    pub(super) drawn_for: Vec<Octahedral>,
    /// Openness of each sample.
    pub(super) openness: Vec<Openness>,
    /// Seed of each sample's random numbers.
    pub(super) seeds: Vec<SampleSeed>,
}

impl GatheredLight {
    /// Creates `count` samples of which nothing is known, for this `layout`.
    pub fn unknown(layout: &TagLayout, count: usize) -> Self {
        let TagLayout { paths, reflections, occlusion_rays: rays, is_seeded, .. } = *layout;
        Self {
            is_seeded,
            rays,
            paths: PathList::unknown(paths, count),
            means: vec![PathLight::UNKNOWN; if paths == 0 { 0 } else { count }],
            reflected: PathList::unknown(reflections, count),
            drawn_for: vec![Octahedral::default(); if reflections == 0 { 0 } else { count }],
            openness: vec![Openness::UNKNOWN; if rays == 0 { 0 } else { count }],
            seeds: vec![SampleSeed::default(); if is_seeded { count } else { 0 }],
        }
    }

    /// Size of a sample's part, in bytes; `bytes_of_path` is that of a path.
    pub fn bytes_of_sample(layout: &TagLayout, bytes_of_path: usize) -> usize {
        let part = |count: usize, bytes: usize| if count == 0 { 0 } else { count * bytes_of_path + bytes };
        let of_light =
            part(layout.paths, size_of::<PathLight>()) + part(layout.reflections, size_of::<Octahedral>());
        let of_openness = if layout.occlusion_rays == 0 { 0 } else { size_of::<Openness>() };
        of_light + of_openness + if layout.is_seeded { size_of::<SampleSeed>() } else { 0 }
    }

    /// Returns memory that is not needed.
    pub fn trim(&mut self) {
        self.paths.trim();
        self.means.shrink_to_fit();
        self.reflected.trim();
        self.drawn_for.shrink_to_fit();
        self.openness.shrink_to_fit();
        self.seeds.shrink_to_fit();
    }

    /// Memory held on the heap, in bytes.
    pub fn bytes(&self) -> usize {
        self.paths.bytes()
            + self.means.capacity() * size_of::<PathLight>()
            + self.reflected.bytes()
            + self.drawn_for.capacity() * size_of::<Octahedral>()
            + self.openness.capacity() * size_of::<Openness>()
            + self.seeds.capacity() * size_of::<SampleSeed>()
    }

    /// Returns true if samples gather light.
    pub fn is_some(&self) -> bool {
        self.paths.paths() != 0
    }

    /// Returns true if samples have seeds: all samples that gather or reflect anything have.
    pub fn is_seeded(&self) -> bool {
        self.is_seeded
    }

    /// Returns true if the layers of samples reflect paths.
    pub fn reflects(&self) -> bool {
        self.reflected.paths() != 0
    }

    /// Direction to the eye for which the reflected paths of a sample were drawn; world space.
    pub fn drawn_for(&self, sample: usize) -> Octahedral {
        self.drawn_for[sample]
    }

    /// Sets the direction to the eye for which the reflected paths of a sample are drawn, and leaves the paths.
    pub fn set_drawn_for(&mut self, sample: usize, to_eye: Octahedral) {
        self.drawn_for[sample] = to_eye;
    }

    /// Gives back memory for the expiry of paths that is not needed: nothing expires in any sample that is
    /// `there`.
    pub fn compact(&mut self, there: impl Fn(usize) -> bool) {
        self.paths.compact(&there);
        self.reflected.compact(&there);
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

    /// Marks a sample as one that gathers no light, for good.
    pub fn set_dark(&mut self, sample: usize) {
        let dark = KeptPath { light: PathColor::default(), until: Until::FOREVER };
        for path in 0..self.paths.paths() {
            self.paths.set(sample, path, dark);
        }
        self.means[sample] = PathLight { until: Until::FOREVER, ..PathLight::UNKNOWN };
    }

    /// Resets the paths that a sample has gathered light by.
    pub fn forget_paths(&mut self, sample: usize) {
        if self.is_some() {
            self.paths.forget_one(sample);
            self.means[sample] = PathLight::UNKNOWN;
        }
    }

    /// Computes the mean of a sample's paths anew. Returns true if its radiance has changed.
    pub fn update_mean(&mut self, sample: usize) -> bool {
        let mean = mean_of(self.paths.known(sample));
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
            self.paths.forget_one(sample);
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
        self.paths.delay() + self.means.iter_mut().map(|mean| u64::from(mean.until.delay())).sum::<u64>()
    }

    /// Postpones the expiry of all openness in the same way.
    pub fn delay_openness(&mut self) -> u64 {
        self.openness.iter_mut().map(|openness| u64::from(openness.until.delay())).sum()
    }

    /// Replaces the expiry of everything by what `changed` returns for it.
    pub fn change_validity(&mut self, changed: impl Fn(Until) -> Until) {
        self.paths.change_validity(&changed);
        self.reflected.change_validity(&changed);
        let means = self.means.iter_mut().map(|mean| &mut mean.until);
        let openness = self.openness.iter_mut().map(|openness| &mut openness.until);
        means.chain(openness).for_each(|until| *until = changed(*until));
    }

    /// Resets light and openness of all samples.
    pub fn forget_all(&mut self) {
        self.paths.forget_all();
        self.means.fill(PathLight::UNKNOWN);
        self.reflected.forget_all();
        self.openness.fill(Openness::UNKNOWN);
    }

    /// Copies sample number `at` of `from` to `sample`.
    #[inline]
    pub fn copy(&mut self, sample: usize, from: &Self, at: usize) {
        if self.is_some() {
            self.paths.copy(sample, &from.paths, at);
            self.means[sample] = from.means[at];
        }
        if self.reflects() {
            self.reflected.copy(sample, &from.reflected, at);
            self.drawn_for[sample] = from.drawn_for[at];
        }
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
            self.paths.push(&from.paths, at);
            self.means.push(from.means[at]);
        }
        if self.reflects() {
            self.reflected.push(&from.reflected, at);
            self.drawn_for.push(from.drawn_for[at]);
        }
        if self.rays != 0 {
            self.openness.push(from.openness[at]);
        }
        if self.is_seeded {
            self.seeds.push(from.seeds[at]);
        }
    }

    /// Removes all samples, and keeps their memory.
    pub fn clear(&mut self) {
        self.paths.clear();
        self.means.clear();
        self.reflected.clear();
        self.drawn_for.clear();
        self.openness.clear();
        self.seeds.clear();
    }
}

/// Mean of these paths, with the first frame in which any of them may differ.
pub fn mean_of(paths: impl Iterator<Item = KeptPath>) -> PathLight {
    let none = (glam::Vec3::ZERO, 0, Until::FOREVER);
    let (sum, count, until) = paths
        .fold(none, |(sum, count, least), path| (sum + path.light.color(), count + 1, least.min(path.until)));
    if count == 0 {
        return PathLight::UNKNOWN;
    }
    let [radiance, ..] = half_colors(Vec3x8::splat(sum / count as f32));
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

    fn path(value: f32) -> KeptPath {
        KeptPath { light: PathColor::new(Vec3::splat(value), false), until: Until::FOREVER }
    }

    #[test]
    fn a_mean_is_that_of_the_paths_that_are_known() {
        let layout = TagLayout::default().with_paths(4);
        let mut gathered = GatheredLight::unknown(&layout, 8);
        let seed = SampleSeed::new(7, 3, 1, 2);
        gathered.begin(5, seed);
        gathered.update_mean(5);
        assert_eq!((gathered.mean(5), gathered.paths.known(5).count()), (PathLight::UNKNOWN, 0));
        for number in 0..3 {
            gathered.paths.set(5, number, path(number as f32));
        }
        assert!(gathered.update_mean(5));
        assert_eq!((gathered.mean(5), gathered.paths.known(5).count()), (light(1.0), 3));
        gathered.paths.set(5, 3, path(3.0));
        assert!(gathered.update_mean(5));
        assert_eq!(gathered.mean(5), light(1.5));
        assert!(!gathered.update_mean(5), "it is the same again");
        assert_eq!(gathered.means(0).lane(5), Vec3::splat(1.5));
        let mut spares = GatheredLight::unknown(&layout, 0);
        spares.push(&gathered, 5);
        gathered.begin(5, SampleSeed::default());
        assert_eq!(gathered, GatheredLight::unknown(&layout, 8));
        gathered.copy(2, &spares, 0);
        assert_eq!((gathered.mean(2), gathered.paths.path(2, 3)), (light(1.5), Some(path(3.0))));
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
        assert_eq!(GatheredLight::bytes_of_sample(&layout, 4), 8);
    }

    #[test]
    fn without_paths_nothing_is_held() {
        let layout = TagLayout::default();
        let mut none = GatheredLight::unknown(&layout, 1024);
        none.copy(3, &none.clone(), 9);
        none.push(&GatheredLight::default(), 0);
        assert_eq!((none.bytes(), GatheredLight::bytes_of_sample(&layout, 4)), (0, 0));
        assert_eq!(none.means(8).lane(0), Vec3::ZERO);
        assert_eq!(GatheredLight::bytes_of_sample(&layout.with_paths(16), 4), 76);
    }
}
