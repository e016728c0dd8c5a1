//! Grouping of leaves: by surface area, in space and in time.

use crate::geometry::Bounds;

/// Number of bins along an axis, between which a list may be split.
const BINS: usize = 16;

/// Box of something that moves, and the frames in which it changes. Frames are counted as
/// [`Until`](super::Until) counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leaf {
    /// Box in world space; for parts of a mesh, which have no frames, in object space.
    pub bounds: Bounds,
    /// First frame of a change.
    pub first: u16,
    /// Earliest frame of a change after the first; from it on, up to the last, any frame may have a change.
    pub second: u16,
    /// Last frame of a change.
    pub last: u16,
}

/// Rule by which lists are split.
#[derive(Debug, Clone, Copy)]
pub enum Split {
    /// Split that makes the two parts be met least often.
    Best {
        /// Number of frames, about, that a query looks ahead: a part that lasts longer is met more often.
        patience: f64,
        /// Number of leaves up to which parts are not split.
        together: usize,
    },
    /// Split in the middle of the frames: both parts have equally many leaves.
    Middle,
}

/// Splits `leaves` into up to `most` parts, none empty, always the one that is met most often.
pub fn parts(leaves: &mut [Leaf], most: usize, split: Split) -> Vec<&mut [Leaf]> {
    if leaves.len() <= most {
        return leaves.chunks_mut(1).collect();
    }
    // negative infinity for parts that stay as they are
    let weight = |part: &[Leaf]| match split {
        Split::Best { together, .. } if part.len() <= together => f64::NEG_INFINITY,
        Split::Best { patience, .. } => Around::new(part).cost(patience),
        Split::Middle => part.len() as f64,
    };
    let mut parts = vec![(weight(leaves), leaves)];
    while parts.len() < most {
        let heaviest = parts.iter().enumerate().max_by(|(_, a), (_, b)| a.0.total_cmp(&b.0));
        let Some((heaviest, _)) = heaviest.filter(|(_, (weight, _))| *weight >= 0.0) else { break };
        let (_, part) = parts.swap_remove(heaviest);
        let (left, right) = match split {
            Split::Best { patience, together } => in_best(part, patience, together),
            Split::Middle => in_middle(part),
        };
        parts.push((weight(left), left));
        parts.push((weight(right), right));
    }
    parts.into_iter().map(|(_, part)| part).collect()
}

/// Bounds of some leaves in space and time.
#[derive(Debug, Clone, Copy)]
pub struct Around {
    pub bounds: Bounds,
    pub first: u16,
    pub last: u16,
    count: u32,
}

impl Around {
    const NOTHING: Self = Self { bounds: Bounds::EMPTY, first: u16::MAX, last: 0, count: 0 };

    pub fn new(leaves: &[Leaf]) -> Self {
        leaves.iter().fold(Self::NOTHING, Self::with)
    }

    fn with(self, leaf: &Leaf) -> Self {
        self.and(&Self { bounds: leaf.bounds, first: leaf.first, last: leaf.last, count: 1 })
    }

    fn and(self, other: &Self) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            first: self.first.min(other.first),
            last: self.last.max(other.last),
            count: self.count + other.count,
        }
    }

    /// Cost: about how often a leaf in it is visited. Surface area, which rays meet in proportion, times
    /// frames, times leaves. 0 for no leaves.
    fn cost(&self, patience: f64) -> f64 {
        if self.count == 0 {
            return 0.0;
        }
        let [x, y, z] = (self.bounds.high.as_dvec3() - self.bounds.low.as_dvec3()).to_array();
        let frames = f64::from(self.last.saturating_sub(self.first)) + patience;
        (x * y + y * z + z * x) * frames * f64::from(self.count)
    }
}

/// Centre of a leaf, doubled: x, y, z, frame.
fn middle(leaf: &Leaf) -> [f32; 4] {
    let [x, y, z] = (leaf.bounds.low + leaf.bounds.high).to_array();
    [x, y, z, f32::from(leaf.first) + f32::from(leaf.last)]
}

/// Splits a list into two, neither empty, that cost least among those cut across one axis. Few leaves are cut
/// across that axis so that all parts but one can have `together` leaves.
fn in_best(leaves: &mut [Leaf], patience: f64, together: usize) -> (&mut [Leaf], &mut [Leaf]) {
    let ends = leaves.iter().map(middle).fold(([f32::INFINITY; 4], [f32::NEG_INFINITY; 4]), |ends, at| {
        let each = |axis: usize| (ends.0[axis].min(at[axis]), ends.1[axis].max(at[axis]));
        (std::array::from_fn(|axis| each(axis).0), std::array::from_fn(|axis| each(axis).1))
    });
    let scale: [f32; 4] = std::array::from_fn(|axis| BINS as f32 / (ends.1[axis] - ends.0[axis]));
    let bin = |leaf: &Leaf, axis: usize| {
        // an axis without extent gives a NaN here, which becomes bin 0
        (((middle(leaf)[axis] - ends.0[axis]) * scale[axis]) as usize).min(BINS - 1)
    };
    let mut bins = [[Around::NOTHING; BINS]; 4];
    for leaf in leaves.iter() {
        for (axis, bins) in bins.iter_mut().enumerate() {
            let bin = &mut bins[bin(leaf, axis)];
            *bin = bin.with(leaf);
        }
    }
    let mut best = (f64::INFINITY, 0, 0);
    for (axis, bins) in bins.iter().enumerate() {
        for (end, cost) in costs(bins, patience) {
            if cost < best.0 {
                best = (cost, axis, end);
            }
        }
    }
    let (cost, axis, end) = best;
    if cost == f64::INFINITY {
        return in_middle(leaves);
    }
    if leaves.len() > together && leaves.len() <= together * together {
        let half = (leaves.len() / 2).next_multiple_of(together);
        leaves.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
        return leaves.split_at_mut(half);
    }
    let at = partition(leaves, |leaf| bin(leaf, axis) < end);
    leaves.split_at_mut(at)
}

/// Costs of both sides, for each number of bins that leaves something on either side.
fn costs(bins: &[Around; BINS], patience: f64) -> impl Iterator<Item = (usize, f64)> {
    let mut right = [Around::NOTHING; BINS + 1];
    for i in (0..BINS).rev() {
        right[i] = right[i + 1].and(&bins[i]);
    }
    let mut left = Around::NOTHING;
    (1..BINS).filter_map(move |end| {
        left = left.and(&bins[end - 1]);
        let both = left.count > 0 && right[end].count > 0;
        both.then(|| (end, left.cost(patience) + right[end].cost(patience)))
    })
}

fn in_middle(leaves: &mut [Leaf]) -> (&mut [Leaf], &mut [Leaf]) {
    let half = leaves.len() / 2;
    leaves.select_nth_unstable_by_key(half, |leaf| (leaf.first, leaf.last));
    leaves.split_at_mut(half)
}

/// Moves those that `belong` to the front, and returns their number.
fn partition(leaves: &mut [Leaf], belong: impl Fn(&Leaf) -> bool) -> usize {
    let mut count = 0;
    for i in 0..leaves.len() {
        if belong(&leaves[i]) {
            leaves.swap(count, i);
            count += 1;
        }
    }
    count
}
