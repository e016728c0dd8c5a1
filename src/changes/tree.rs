//! A hierarchy over space and frames, with eight children a node.

use glam::Vec3;
use rayon::prelude::*;

use super::split::{Around, Leaf, Split, parts};
use crate::geometry::{Bounds8, Segments};
use crate::lanes::{F32x8, LANES, Vec3x8};

/// Number of levels below which lists are split in the middle, so that no scene makes the tree deep.
const BEST_LEVELS: usize = 12;

/// Largest number of nodes between the root and a leaf: split in the middle, 2^32 leaves take eleven levels.
const DEPTH: usize = BEST_LEVELS + 12;

/// Share of all frames, about, that queries look ahead.
const PATIENCE: f64 = 0.1;

/// Number of leaves from which on parts are built by several threads.
const PARALLEL: usize = 1 << 12;

/// Node with up to eight children, by rising first frame. Frames are whole numbers, exact as floats.
#[derive(Debug, Clone)]
struct Node {
    boxes: Bounds8,
    /// First frame of a change within each child.
    first: F32x8,
    /// Last frame of a change within each child; negative infinity for a missing child.
    last: F32x8,
    /// Second frame of a leaf, or the number of a child node.
    links: [u32; LANES],
    /// Bit mask of the children that are leaves.
    leaves: u8,
}

/// Hierarchy that finds the first frame of a change along a segment.
#[derive(Debug, Clone, Default)]
pub struct Tree {
    /// Nodes; the root is the first.
    nodes: Vec<Node>,
}

impl Tree {
    /// Builds the hierarchy of `leaves`, in any order.
    pub fn of(mut leaves: Vec<Leaf>) -> Self {
        let mut nodes = Vec::new();
        if !leaves.is_empty() {
            let all = Around::new(&leaves);
            let patience = 1.0 + f64::from(all.last - all.first) * PATIENCE;
            build(&mut nodes, &mut leaves, 0, patience);
        }
        Self { nodes }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }

    /// First frame after `after` in which something changes along the segment, if it is before `end`, or else
    /// `end`. `after` is -1 at least.
    pub fn first_touch(&self, origin: Vec3, direction: Vec3, far: f32, after: f32, end: f32) -> f32 {
        self.search(origin, direction, far, after, end, || ())
    }

    /// [`first_touch`](Self::first_touch) with a call of `visit` for each node that is visited.
    #[inline(always)]
    pub fn search(
        &self,
        origin: Vec3,
        direction: Vec3,
        far: f32,
        after: f32,
        end: f32,
        mut visit: impl FnMut(),
    ) -> f32 {
        if self.nodes.is_empty() {
            return end;
        }
        let segment = Segments::new(Vec3x8::splat(origin), Vec3x8::splat(direction), F32x8::splat(far));
        let mut best = end;
        // nodes on the way to the current one, with the children that are still to be visited
        let mut way = [(0_u32, 0_u8); DEPTH];
        let (mut depth, mut number) = (0, 0);
        let mut open = self.nodes[0].open(&segment, after, &mut best);
        visit();
        loop {
            let node = &self.nodes[number as usize];
            let lane = open.trailing_zeros() as usize;
            // children that begin later cannot be better either
            if open == 0 || node.first.lane(lane).max(after + 1.0) >= best {
                if depth == 0 {
                    return best;
                }
                depth -= 1;
                (number, open) = way[depth];
                continue;
            }
            open &= open - 1;
            if open != 0 {
                way[depth] = (number, open);
                depth += 1;
            }
            number = node.links[lane];
            open = self.nodes[number as usize].open(&segment, after, &mut best);
            visit();
        }
    }
}

impl Node {
    const EMPTY: Self = Self {
        boxes: Bounds8::ORIGIN,
        first: F32x8::ZERO,
        last: F32x8::new([f32::NEG_INFINITY; LANES]),
        links: [0; LANES],
        leaves: 0,
    };

    /// Bit mask of the child nodes that may contain a better frame than `best`. Children that are leaves are
    /// handled here: `best` becomes the best of them.
    #[inline(always)]
    fn open(&self, segment: &Segments, after: f32, best: &mut f32) -> u8 {
        let in_time = self.last.gt(F32x8::splat(after)) & self.first.lt(F32x8::splat(*best));
        let met = (self.boxes.meets(segment) & in_time).bits();
        let mut leaves = met & self.leaves;
        while leaves != 0 {
            let lane = leaves.trailing_zeros() as usize;
            *best = best.min(self.leaf_change(lane, after));
            leaves &= leaves - 1;
        }
        met & !self.leaves
    }

    /// First frame after `after` in which a leaf changes; there must be one.
    #[inline(always)]
    fn leaf_change(&self, lane: usize, after: f32) -> f32 {
        let first = self.first.lane(lane);
        if first > after { first } else { (after + 1.0).max(self.links[lane] as f32) }
    }

    fn set(&mut self, lane: usize, around: &Around) {
        self.boxes.set_lane(lane, &around.bounds);
        self.first.set_lane(lane, f32::from(around.first));
        self.last.set_lane(lane, f32::from(around.last));
    }
}

/// Appends a node for `leaves`, and all nodes below it.
fn build(nodes: &mut Vec<Node>, leaves: &mut [Leaf], level: usize, patience: f64) {
    let is_large = leaves.len() >= PARALLEL;
    // full nodes at the bottom make a smaller tree
    let best = Split::Best { patience, together: LANES };
    let split = if level < BEST_LEVELS { best } else { Split::Middle };
    let mut parts: Vec<(Around, &mut [Leaf])> =
        parts(leaves, LANES, split).into_iter().map(|part| (Around::new(part), part)).collect();
    parts.sort_by_key(|(around, _)| (around.first, around.last));

    let number = nodes.len();
    let mut node = Node::EMPTY;
    for (lane, (around, part)) in parts.iter().enumerate() {
        node.set(lane, around);
        if let [leaf] = part {
            node.leaves |= 1 << lane;
            node.links[lane] = leaf.second.into();
        }
    }
    nodes.push(node);

    let inner = parts.into_iter().enumerate().filter(|(_, (_, part))| part.len() > 1);
    if !is_large {
        for (lane, (_, part)) in inner {
            nodes[number].links[lane] = nodes.len() as u32;
            build(nodes, part, level + 1, patience);
        }
        return;
    }
    let inner: Vec<(usize, (Around, &mut [Leaf]))> = inner.collect();
    let below = inner.into_par_iter().map(|(lane, (_, part))| {
        let mut nodes = Vec::new();
        build(&mut nodes, part, level + 1, patience);
        (lane, nodes)
    });
    for (lane, below) in below.collect::<Vec<_>>() {
        let first = nodes.len() as u32;
        nodes[number].links[lane] = first;
        nodes.extend(below.into_iter().map(|node| node.shifted(first)));
    }
}

impl Node {
    /// Increases the numbers of its child nodes by `by`.
    fn shifted(mut self, by: u32) -> Self {
        for lane in 0..LANES {
            if self.leaves >> lane & 1 == 0 {
                self.links[lane] += by;
            }
        }
        self
    }
}
