//! A value that is keyed at some frames and defined at all of them.

use glam::{DAffine3, DVec3, Vec3};

/// Interpolation of a track from key to key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// Linear from key to key; the speed jumps at each.
    #[default]
    Linear,
    /// A cubic Hermite curve through the keys with finite-difference tangents (Catmull-Rom for keys
    /// that are evenly spaced), at rest in the first and the last.
    Smooth,
}

/// A type whose values can be keyed: a vector space over f64.
pub trait Keyed: Copy + PartialEq {
    /// `self * k`
    fn scaled(self, k: f64) -> Self;
    /// `self + other`
    fn plus(self, other: Self) -> Self;
}

impl Keyed for f64 {
    fn scaled(self, k: f64) -> Self {
        self * k
    }
    fn plus(self, other: Self) -> Self {
        self + other
    }
}

/// Each number is interpolated by itself.
impl Keyed for [f64; 2] {
    fn scaled(self, k: f64) -> Self {
        self.map(|number| number * k)
    }
    fn plus(self, other: Self) -> Self {
        [self[0] + other[0], self[1] + other[1]]
    }
}

impl Keyed for DVec3 {
    fn scaled(self, k: f64) -> Self {
        self * k
    }
    fn plus(self, other: Self) -> Self {
        self + other
    }
}

impl Keyed for Vec3 {
    fn scaled(self, k: f64) -> Self {
        self * k as f32
    }
    fn plus(self, other: Self) -> Self {
        self + other
    }
}

/// Each element is interpolated by itself; the last row stays 0 0 0 1.
impl Keyed for DAffine3 {
    fn scaled(self, k: f64) -> Self {
        Self { matrix3: self.matrix3 * k, translation: self.translation * k }
    }
    fn plus(self, other: Self) -> Self {
        Self { matrix3: self.matrix3 + other.matrix3, translation: self.translation + other.translation }
    }
}

/// Parts of a frame after which the product of two maps that both change has keys.
const STEPS_A_FRAME: f64 = 4.0;

/// A track that never changes.
impl<T: Keyed> From<T> for Track<T> {
    fn from(value: T) -> Self {
        Self::constant(value)
    }
}

impl Track<DAffine3> {
    /// Computes the map of `part`, and after it this one. Where both change, it has keys at each quarter of a frame: the product of two
    /// maps does not change evenly then.
    pub fn after(&self, part: &Self) -> Self {
        if let Some(map) = self.is_constant().then(|| self.at(0.0)) {
            return part.clone().map(|of_part| map * of_part);
        }
        if let Some(map) = part.is_constant().then(|| part.at(0.0)) {
            return self.clone().map(|of_whole| of_whole * map);
        }
        let ends = |track: &Self| {
            track
                .frames()
                .fold((f64::MAX, f64::MIN), |(first, last), frame| (first.min(frame), last.max(frame)))
        };
        let ((a, b), (c, d)) = (ends(self), ends(part));
        let (first, last) = (a.max(c), b.min(d));
        let steps = ((last - first).max(0.0) * STEPS_A_FRAME).ceil() as u32;
        let between = (0..steps).map(|step| first + f64::from(step) / STEPS_A_FRAME);
        let mut frames: Vec<f64> = self.frames().chain(part.frames()).chain(between).collect();
        frames.sort_by(f64::total_cmp);
        frames.dedup();
        let keys = frames.into_iter().map(|frame| (frame, self.at(frame) * part.at(frame))).collect();
        let track =
            Self::through(keys, Interpolation::Linear).expect("frames are finite, and each is there once");
        track.cut_at(&[self.cut_frames(), part.cut_frames()].concat())
    }
}

/// Keys in rising order of frame, never empty. Before the first key and after the last the value rests.
#[derive(Debug, Clone, PartialEq)]
pub struct Track<T> {
    keys: Vec<(f64, T)>,
    interpolation: Interpolation,
    /// Indices of keys that are cuts: the value jumps there, without interpolation from the key before;
    /// rising.
    cuts: Vec<usize>,
}

impl<T: Keyed> Track<T> {
    /// Creates a track that never changes.
    pub fn constant(value: T) -> Self {
        Self { keys: vec![(0.0, value)], interpolation: Interpolation::Linear, cuts: Vec::new() }
    }

    /// Creates a track through `keys`, pairs of frame and value in any order.
    ///
    /// `None` if there are no keys, if two share a frame, or if a frame is not finite.
    pub fn through(mut keys: Vec<(f64, T)>, interpolation: Interpolation) -> Option<Self> {
        if keys.is_empty() || keys.iter().any(|(frame, _)| !frame.is_finite()) {
            return None;
        }
        keys.sort_by(|a, b| a.0.total_cmp(&b.0));
        let twice = keys.windows(2).any(|pair| pair[0].0 == pair[1].0);
        (!twice).then_some(Self { keys, interpolation, cuts: Vec::new() })
    }

    /// Makes the keys at `frames` cuts: the value rests after the key before, and jumps. Each side of a cut
    /// begins and ends as a track of its own would.
    pub fn cut_at(mut self, frames: &[f64]) -> Self {
        let cut = |i: &usize| frames.contains(&self.keys[*i].0);
        self.cuts = (1..self.keys.len()).filter(cut).collect();
        self
    }

    /// Values of the keys, in their order.
    pub fn values(&self) -> impl Iterator<Item = T> + '_ {
        self.keys.iter().map(|(_, value)| *value)
    }

    /// Frames of the keys, in rising order.
    pub fn frames(&self) -> impl Iterator<Item = f64> + '_ {
        self.keys.iter().map(|(frame, _)| *frame)
    }

    /// Frames of the keys that are cuts.
    pub fn cut_frames(&self) -> Vec<f64> {
        self.cuts.iter().map(|key| self.keys[*key].0).collect()
    }

    /// Converts the value of each key. Values between keys follow if `convert` is affine.
    pub fn map(self, convert: impl Fn(T) -> T) -> Self {
        let keys = self.keys.into_iter().map(|(frame, value)| (frame, convert(value))).collect();
        Self { keys, ..self }
    }

    /// Value at `frame`.
    pub fn at(&self, frame: f64) -> T {
        let after = self.keys.partition_point(|(key, _)| *key <= frame);
        if after == 0 {
            return self.keys[0].1;
        }
        if self.begins(after) {
            return self.keys[after - 1].1;
        }
        let ((f0, v0), (f1, v1)) = (self.keys[after - 1], self.keys[after]);
        let t = (frame - f0) / (f1 - f0);
        match self.interpolation {
            // a value that is the same at both keys must be the same between them, to the bit:
            // "did it move?" compares poses exactly
            _ if v0 == v1 && self.interpolation == Interpolation::Linear => v0,
            Interpolation::Linear => v0.scaled(1.0 - t).plus(v1.scaled(t)),
            Interpolation::Smooth => self.hermite(after - 1, t),
        }
    }

    /// End of the rest around `frame`: up to it, itself excluded, the value is certainly the same to the bit
    /// as at `frame`. It is `frame` itself if the value changes there, and infinite from the last key on.
    pub fn rests_until(&self, frame: f64) -> f64 {
        let after = self.keys.partition_point(|(key, _)| *key <= frame);
        let Some((next, value)) = self.keys.get(after) else { return f64::INFINITY };
        let rests = self.begins(after)
            || match self.interpolation {
                Interpolation::Linear => self.keys[after - 1].1 == *value,
                Interpolation::Smooth => self.is_flat(after - 1),
            };
        if rests { *next } else { frame }
    }

    /// Beginning of the rest around `frame`: from it on, itself included, the value is certainly the same to
    /// the bit as at `frame`. It is `frame` itself if the value changes there, and infinitely early up to the
    /// first key.
    pub fn rests_since(&self, frame: f64) -> f64 {
        let mut since = frame;
        while let Some(before) = self.keys.partition_point(|(key, _)| *key < since).checked_sub(1) {
            let (key, value) = self.keys[before];
            let end = self.rests_until(key);
            // up to a key that is cut, the value is another there
            if end < since || end == since && self.at(since) != value {
                return since;
            }
            since = key;
        }
        f64::NEG_INFINITY
    }

    /// Returns true if the value is the same at all frames.
    pub fn is_constant(&self) -> bool {
        self.keys.iter().all(|(_, value)| *value == self.keys[0].1)
    }

    /// Returns true if nothing is interpolated from key `i - 1` to key `i`: it is the first, behind the last,
    /// or cut.
    fn begins(&self, i: usize) -> bool {
        i == 0 || i == self.keys.len() || (!self.cuts.is_empty() && self.cuts.binary_search(&i).is_ok())
    }

    /// The cubic Hermite curve between keys `i` and `i + 1` at `t` in 0..1.
    fn hermite(&self, i: usize, t: f64) -> T {
        let ((f0, v0), (f1, v1)) = (self.keys[i], self.keys[i + 1]);
        if self.is_flat(i) {
            return v0;
        }
        let (m0, m1) = (self.tangent(i), self.tangent(i + 1));
        let (t2, t3, span) = (t * t, t * t * t, f1 - f0);
        v0.scaled(2.0 * t3 - 3.0 * t2 + 1.0)
            .plus(m0.scaled((t3 - 2.0 * t2 + t) * span))
            .plus(v1.scaled(3.0 * t2 - 2.0 * t3))
            .plus(m1.scaled((t3 - t2) * span))
    }

    /// Returns true if the curve between keys `i` and `i + 1` is constant.
    fn is_flat(&self, i: usize) -> bool {
        let (v0, v1, still) = (self.keys[i].1, self.keys[i + 1].1, self.keys[i].1.scaled(0.0));
        v0 == v1 && self.tangent(i) == still && self.tangent(i + 1) == still
    }

    /// Change per frame at key `i`: the slope from its neighbour before to its neighbour after,
    /// none at the two ends of the track and beside cuts.
    fn tangent(&self, i: usize) -> T {
        if self.begins(i) || self.begins(i + 1) {
            return self.keys[i].1.scaled(0.0);
        }
        let ((f0, v0), (f1, v1)) = (self.keys[i - 1], self.keys[i + 1]);
        v1.plus(v0.scaled(-1.0)).scaled(1.0 / (f1 - f0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn smooth(keys: &[(f64, f64)]) -> Track<f64> {
        Track::through(keys.to_vec(), Interpolation::Smooth).expect("keys are good")
    }

    #[test]
    fn rests_outside_its_keys() {
        let track = Track::through(vec![(10.0, 1.0), (20.0, 2.0)], Interpolation::Linear).expect("good");
        assert_eq!((track.at(-5.0), track.at(15.0), track.at(99.0)), (1.0, 1.5, 2.0));
    }

    #[test]
    fn smooth_meets_every_key_and_keeps_a_steady_slope() {
        let track = smooth(&[(0.0, 0.0), (10.0, 10.0), (20.0, 20.0), (30.0, 30.0)]);
        for frame in [0.0, 10.0, 20.0, 30.0] {
            assert!((track.at(frame) - frame).abs() < 1e-12);
        }
        assert!((track.at(13.7) - 13.7).abs() < 1e-9, "inner spans of a straight line stay straight");
    }

    #[test]
    fn a_rest_between_equal_keys_is_exact() {
        let track = Track::through(vec![(1.0, 0.1), (7.0, 0.1), (9.0, 3.0)], Interpolation::Linear);
        let track = track.expect("good");
        for frame in 1..=7 {
            assert_eq!(track.at(f64::from(frame)), 0.1);
        }
        assert!(!track.is_constant());
    }

    #[test]
    fn rests_up_to_a_cut_and_jumps() {
        let keys = [(1.0, 0.0), (11.0, 10.0), (21.0, 100.0), (31.0, 110.0)];
        let track = smooth(&keys).cut_at(&[21.0]);
        assert_eq!((track.at(11.0), track.at(20.999), track.at(21.0)), (10.0, 10.0, 100.0));
        let alone = smooth(&keys[2..]);
        for frame in 21..=33 {
            assert_eq!(track.at(f64::from(frame)), alone.at(f64::from(frame)));
        }
        let alone = smooth(&keys[..2]);
        for frame in 0..21 {
            assert_eq!(track.at(f64::from(frame)), alone.at(f64::from(frame)));
        }
    }

    #[test]
    fn knows_how_long_it_rests() {
        let keys = [(2.5, 1.0), (5.0, 1.0), (6.0, 3.0), (8.0, 3.0), (9.0, 3.0), (11.0, 7.0), (12.0, 9.0)];
        let linear = Track::through(keys.to_vec(), Interpolation::Linear).expect("good");
        assert_eq!((linear.rests_until(6.0), linear.rests_until(8.0)), (8.0, 9.0));
        assert_eq!((linear.rests_since(8.5), linear.clone().cut_at(&[8.0]).rests_since(8.5)), (6.0, 6.0));
        assert_eq!((linear.rests_since(5.5), linear.clone().cut_at(&[6.0]).rests_since(6.0)), (5.5, 6.0));
        for track in
            [linear.clone(), smooth(&keys), linear.cut_at(&[6.0, 12.0]), smooth(&keys).cut_at(&[6.0])]
        {
            for step in 0..60 {
                let frame = f64::from(step) * 0.25;
                let end = track.rests_until(frame);
                assert!(end >= frame);
                for part in 0..8 {
                    let between = frame + (end.min(99.0) - frame) * f64::from(part) / 8.0;
                    assert_eq!(track.at(between), track.at(frame), "{frame} {end}");
                }
                let since = track.rests_since(frame);
                assert!(since <= frame);
                for part in 0..=8 {
                    let between = frame - (frame - since.max(-9.0)) * f64::from(part) / 8.0;
                    assert_eq!(track.at(between), track.at(frame), "{frame} {since}");
                }
            }
            assert_eq!((track.rests_since(2.5), track.rests_since(99.0)), (f64::NEG_INFINITY, 12.0));
            assert_eq!((track.rests_until(0.0), track.rests_until(12.0)), (2.5, f64::INFINITY));
            assert_eq!(track.rests_until(10.0), 10.0);
        }
        assert_eq!(smooth(&keys).cut_at(&[6.0]).rests_until(5.5), 6.0);
        assert_eq!(smooth(&keys).rests_until(8.5), 8.5, "it swings out before it leaves");
    }

    #[test]
    fn refuses_two_keys_in_one_frame() {
        assert!(Track::through(vec![(1.0, 0.0), (1.0, 1.0)], Interpolation::Linear).is_none());
        assert!(Track::<f64>::through(vec![], Interpolation::Linear).is_none());
    }
}
