//! Paths of a list of samples: what each has brought, and until when.

use super::path_color::PathColor;
use crate::changes::Until;

/// Result of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeptPath {
    /// Radiance, linear RGB. The bit beside it is set if the light source is in sight that a layer asks beside
    /// a reflected path.
    pub light: PathColor,
    /// First frame in which any of it may differ.
    pub until: Until,
}

/// Paths of a list of samples, as many of each. The first ones of a sample are known.
///
/// As long as all hold for ever, which is so for most tiles of most shots, their expiry takes no memory.
#[derive(Debug, Clone, Default)]
pub struct PathList {
    /// Number of paths of each sample.
    paths: usize,
    light: Vec<PathColor>,
    /// Expiry of each; empty if all hold for ever.
    until: Vec<Until>,
}

impl PartialEq for PathList {
    fn eq(&self, other: &Self) -> bool {
        let same = |path| self.at(path) == other.at(path);
        self.paths == other.paths && self.light.len() == other.light.len() && (0..self.light.len()).all(same)
    }
}

impl PathList {
    /// Largest size of a path, in bytes.
    pub const MOST_BYTES: usize = size_of::<PathColor>() + size_of::<Until>();

    /// Size of a path that holds for ever, in bytes.
    pub const LEAST_BYTES: usize = size_of::<PathColor>();

    /// Creates `paths` paths of each of `count` samples, of which none is known.
    pub fn unknown(paths: usize, count: usize) -> Self {
        Self { paths, light: vec![PathColor::UNKNOWN; paths * count], until: Vec::new() }
    }

    /// Number of paths of each sample.
    pub fn paths(&self) -> usize {
        self.paths
    }

    /// Returns memory that is not needed.
    pub fn trim(&mut self) {
        self.light.shrink_to_fit();
        self.until.shrink_to_fit();
    }

    /// Memory held on the heap, in bytes.
    pub fn bytes(&self) -> usize {
        self.light.capacity() * size_of::<PathColor>() + self.until.capacity() * size_of::<Until>()
    }

    /// Path number `path` of the whole list, if it is known.
    #[inline]
    fn at(&self, path: usize) -> Option<KeptPath> {
        let light = self.light[path];
        let until = self.until.get(path).copied().unwrap_or(Until::FOREVER);
        (light != PathColor::UNKNOWN).then_some(KeptPath { light, until })
    }

    /// Path number `path` of a sample, if it is known.
    pub fn path(&self, sample: usize, path: usize) -> Option<KeptPath> {
        self.at(sample * self.paths + path)
    }

    /// Paths of a sample that are known, in their order.
    #[inline]
    pub fn known(&self, sample: usize) -> impl Iterator<Item = KeptPath> + '_ {
        (sample * self.paths..(sample + 1) * self.paths).map_while(|path| self.at(path))
    }

    /// Stores path number `path` of a sample. Returns true if its light has changed.
    pub fn set(&mut self, sample: usize, path: usize, kept: KeptPath) -> bool {
        let at = sample * self.paths + path;
        self.set_until(at, kept.until);
        std::mem::replace(&mut self.light[at], kept.light) != kept.light
    }

    #[inline]
    fn set_until(&mut self, at: usize, until: Until) {
        if self.until.is_empty() && until != Until::FOREVER {
            self.until.resize(self.light.len(), Until::FOREVER);
        }
        if let Some(known) = self.until.get_mut(at) {
            *known = until;
        }
    }

    /// Gives back the memory of expiries if all paths hold for ever that are known of samples that are `there`.
    pub fn compact(&mut self, there: impl Fn(usize) -> bool) {
        let expires = |sample: usize| self.known(sample).any(|path| path.until != Until::FOREVER);
        if !self.until.is_empty() {
            let samples = self.light.len() / self.paths;
            if !(0..samples).any(|sample| there(sample) && expires(sample)) {
                self.until = Vec::new();
            }
        }
    }

    /// Resets the paths of a sample.
    pub fn forget_one(&mut self, sample: usize) {
        self.light[sample * self.paths..(sample + 1) * self.paths].fill(PathColor::UNKNOWN);
    }

    /// Resets the paths of all samples.
    pub fn forget_all(&mut self) {
        self.light.fill(PathColor::UNKNOWN);
    }

    /// Replaces the expiry of all paths by what `changed` returns for it.
    pub fn change_validity(&mut self, changed: impl Fn(Until) -> Until) {
        if changed(Until::FOREVER) != Until::FOREVER {
            self.until.resize(self.light.len(), Until::FOREVER);
        }
        self.until.iter_mut().for_each(|until| *until = changed(*until));
    }

    /// Postpones the expiry of all paths by a frame. Returns the number of those that do expire.
    pub fn delay(&mut self) -> u64 {
        self.until.iter_mut().map(|until| u64::from(until.delay())).sum()
    }

    /// Copies the paths of sample number `at` of `from` to `sample`.
    #[inline]
    pub fn copy(&mut self, sample: usize, from: &Self, at: usize) {
        let paths = self.paths;
        let (to, from_paths) = (sample * paths..(sample + 1) * paths, at * paths..(at + 1) * paths);
        self.light[to.clone()].copy_from_slice(&from.light[from_paths.clone()]);
        match from.until.get(from_paths) {
            Some(until) if paths > 0 => {
                if self.until.is_empty() && until.iter().any(|until| *until != Until::FOREVER) {
                    self.until.resize(self.light.len(), Until::FOREVER);
                }
                if !self.until.is_empty() {
                    self.until[to].copy_from_slice(until);
                }
            }
            _ if self.until.is_empty() => {}
            _ => self.until[to].fill(Until::FOREVER),
        }
    }

    /// Appends the paths of sample number `at` of `from` to the list.
    pub fn push(&mut self, from: &Self, at: usize) {
        let sample = self.light.len() / self.paths.max(1);
        self.light.resize(self.light.len() + self.paths, PathColor::UNKNOWN);
        if !self.until.is_empty() {
            self.until.resize(self.light.len(), Until::FOREVER);
        }
        self.copy(sample, from, at);
    }

    /// Removes all samples, and keeps their memory.
    pub fn clear(&mut self) {
        self.light.clear();
        self.until.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn path(value: f32, until: Until) -> KeptPath {
        KeptPath { light: PathColor::new(Vec3::splat(value), false), until }
    }

    #[test]
    fn expiry_takes_memory_only_where_something_expires() {
        let soon = Until::from_bits(7);
        let mut list = PathList::unknown(2, 8);
        let bytes = list.bytes();
        assert!(list.set(3, 0, path(1.0, Until::FOREVER)) && !list.set(3, 0, path(1.0, Until::FOREVER)));
        assert_eq!((list.known(3).count(), list.path(3, 1), list.bytes()), (1, None, bytes));
        assert!(list.set(5, 1, path(2.0, soon)), "the first is not known: none is");
        assert_eq!((list.known(5).count(), list.bytes()), (0, bytes * 3 / 2));
        list.set(5, 0, path(3.0, Until::FOREVER));
        assert_eq!(list.known(5).map(|path| path.until).collect::<Vec<_>>(), [Until::FOREVER, soon]);
        // copies, from lists with expiries and without
        let mut spares = PathList::unknown(2, 0);
        [3, 5, 3].into_iter().for_each(|sample| spares.push(&list, sample));
        assert_eq!(spares.path(1, 1), Some(path(2.0, soon)));
        list.copy(5, &PathList::unknown(2, 1), 0);
        assert_eq!(list.known(5).count(), 0);
        list.compact(|_| true);
        assert_eq!(list.bytes(), bytes);
        list.copy(6, &spares, 1);
        assert_eq!(
            (list.path(6, 1), list.path(3, 0)),
            (Some(path(2.0, soon)), Some(path(1.0, Until::FOREVER)))
        );
        list.compact(|sample| sample != 6);
        assert_eq!(list.bytes(), bytes, "nothing is there that expires");
        spares.change_validity(|_| soon);
        assert_eq!(spares.path(0, 0), Some(path(1.0, soon)));
    }
}
