//! A tree of boxes with eight children a node, made from a binary one.
//!
//! `obvhs` builds the binary tree (PLOC, then reinsertion, on rayon's threads). Here its nodes are merged
//! until each has eight children, always by opening the child with the largest surface, and subtrees that are
//! small enough become leaves.

use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, reinsertion::ReinsertionOptimizer};

use crate::animation::Transform;
use crate::lanes::LANES;

/// Number of children of a node, of triangles in a leaf, and of floats in a register.
pub const WIDTH: usize = LANES;

/// Widening of an instance's box for the rounding of the model's matrix, as a share of its largest
/// coordinate.
const BOX_SLACK: f32 = 4e-6;

/// An axis-aligned box: low and high corner.
#[derive(Debug, Clone, Copy)]
pub struct Box3 {
    /// Least x, y, z.
    pub low: [f32; 3],
    /// Greatest x, y, z.
    pub high: [f32; 3],
}

impl Box3 {
    /// Empty box; no ray meets it.
    pub const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    /// Smallest box around `points`, exactly.
    pub fn around(points: impl IntoIterator<Item = [f32; 3]>) -> Self {
        points.into_iter().fold(Self::EMPTY, |mut all, point| {
            for (axis, coordinate) in point.into_iter().enumerate() {
                all.low[axis] = all.low[axis].min(coordinate);
                all.high[axis] = all.high[axis].max(coordinate);
            }
            all
        })
    }

    /// Smallest box around both.
    pub fn union(&self, other: &Self) -> Self {
        Self {
            low: [0, 1, 2].map(|axis| self.low[axis].min(other.low[axis])),
            high: [0, 1, 2].map(|axis| self.high[axis].max(other.high[axis])),
        }
    }

    /// Half of its surface.
    pub fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.high[axis] - self.low[axis]);
        x * y + y * z + z * x
    }

    /// Eight corners of the box.
    pub fn corners(&self) -> [[f32; 3]; 8] {
        std::array::from_fn(|i| {
            std::array::from_fn(|axis| if i >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] })
        })
    }

    /// Box around the transformed box, world space.
    pub fn placed(&self, transform: &Transform) -> Self {
        let corners = self.corners().map(|corner| transform.point(Vec3::from(corner)).to_array());
        let mut around = Self::around(corners);
        let largest = corners.iter().flatten().fold(0.0_f32, |most, coordinate| most.max(coordinate.abs()));
        around.low = around.low.map(|low| low - largest * BOX_SLACK);
        around.high = around.high.map(|high| high + largest * BOX_SLACK);
        around
    }
}

/// Eight boxes as structures of arrays: least x, y, z, then greatest x, y, z.
pub type Planes = [[f32; WIDTH]; 6];

/// Node with eight children.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct Node {
    /// Boxes of the children; those of missing children are met by no ray.
    pub planes: Planes,
    /// Children: nodes or leaves.
    pub children: [Child; WIDTH],
}

/// Number of a node, or that of a leaf with [`Child::LEAF`] set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Child(u32);

impl Child {
    const LEAF: u32 = 1 << 31;

    /// Number of the first node.
    pub const ROOT: Self = Self(0);

    /// Number of the leaf, or else that of the node.
    #[inline(always)]
    pub fn open(self) -> Result<u32, usize> {
        if self.0 & Self::LEAF != 0 { Ok(self.0 & !Self::LEAF) } else { Err(self.0 as usize) }
    }
}

/// A tree of boxes. The root is the first node; an empty tree has none.
#[derive(Debug)]
pub struct Tree {
    /// Nodes, parents before children.
    pub nodes: Vec<Node>,
    /// Box around everything.
    pub bounds: Box3,
}

/// Parameters for `obvhs`: its `medium_build` with four times as much reinsertion, one primitive a leaf
/// (leaves are made here), and no splitting of triangles, which makes more of them to test.
fn quality() -> BvhBuildParams {
    BvhBuildParams {
        reinsertion_batch_ratio: 0.2,
        max_prims_per_leaf: 1,
        pre_split: false,
        ..BvhBuildParams::medium_build()
    }
}

/// Parameters for `obvhs` where a tree is asked rarely: a tenth of the time.
fn quick() -> BvhBuildParams {
    BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::fastest_build() }
}

impl Tree {
    /// Builds a tree over `boxes`. `make_leaf` gets the numbers of up to `leaf_size` boxes and returns the
    /// leaf's number.
    pub fn new(boxes: &[Box3], leaf_size: u32, make_leaf: impl FnMut(&[u32]) -> u32) -> Self {
        Self::built(boxes, leaf_size, &quality(), make_leaf)
    }

    /// Like [`new`](Self::new), in less time, for a tree that takes more time to search.
    pub fn quick(boxes: &[Box3], leaf_size: u32, make_leaf: impl FnMut(&[u32]) -> u32) -> Self {
        Self::built(boxes, leaf_size, &quick(), make_leaf)
    }

    fn built(
        boxes: &[Box3],
        leaf_size: u32,
        how: &BvhBuildParams,
        make_leaf: impl FnMut(&[u32]) -> u32,
    ) -> Self {
        let bounds = Box3::around(boxes.iter().flat_map(|one| [one.low, one.high]));
        if boxes.is_empty() {
            return Self { nodes: Vec::new(), bounds };
        }
        let aabbs: Vec<Aabb> =
            boxes.iter().map(|one| Aabb { min: one.low.into(), max: one.high.into() }).collect();
        let ids = (0..aabbs.len() as u32).collect();
        let search = how.ploc_search_distance;
        let mut binary = search.build(&aabbs, ids, how.sort_precision, how.search_depth_threshold);
        if how.reinsertion_batch_ratio > 0.0 {
            ReinsertionOptimizer::run(&mut binary, how.reinsertion_batch_ratio, None);
        }
        let counts = count_primitives(&binary);
        let mut merge = Merge { binary: &binary, counts, leaf_size, make_leaf, nodes: Vec::new() };
        merge.root();
        Self { nodes: merge.nodes, bounds }
    }
}

/// Number of primitives below each node.
fn count_primitives(binary: &Bvh2) -> Vec<u32> {
    let mut counts = vec![0; binary.nodes.len()];
    // each node is visited once before its children and once after them
    let mut open = vec![(0, false)];
    while let Some((node, done)) = open.pop() {
        let first = binary.nodes[node].first_index as usize;
        if binary.nodes[node].is_leaf() {
            counts[node] = binary.nodes[node].prim_count;
        } else if done {
            counts[node] = counts[first] + counts[first + 1];
        } else {
            open.extend([(node, true), (first, false), (first + 1, false)]);
        }
    }
    counts
}

struct Merge<'a, F> {
    binary: &'a Bvh2,
    counts: Vec<u32>,
    leaf_size: u32,
    make_leaf: F,
    nodes: Vec<Node>,
}

impl<F: FnMut(&[u32]) -> u32> Merge<'_, F> {
    fn root(&mut self) {
        // with a list of nodes still to be made, so that no depth of the binary tree is too much
        let mut open = vec![(self.new_node(), 0)];
        while let Some((number, source)) = open.pop() {
            for (slot, child) in self.children_of(source).into_iter().enumerate() {
                let made = if self.is_leaf(child) {
                    Child(self.leaf(child) | Child::LEAF)
                } else {
                    let inner = self.new_node();
                    open.push((inner, child));
                    Child(inner as u32)
                };
                let aabb = &self.binary.nodes[child].aabb;
                let node = &mut self.nodes[number];
                node.children[slot] = made;
                for axis in 0..3 {
                    node.planes[axis][slot] = aabb.min[axis];
                    node.planes[axis + 3][slot] = aabb.max[axis];
                }
            }
        }
    }

    fn new_node(&mut self) -> usize {
        let [none, all] = [[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]];
        let planes = [none, none, none, all, all, all];
        self.nodes.push(Node { planes, children: [Child::ROOT; WIDTH] });
        self.nodes.len() - 1
    }

    fn is_leaf(&self, node: usize) -> bool {
        self.counts[node] <= self.leaf_size
    }

    /// Up to eight nodes of the binary tree that together cover `node`.
    fn children_of(&self, node: usize) -> Vec<usize> {
        let mut children = vec![node];
        while children.len() < WIDTH {
            let area = |at: &usize| self.binary.nodes[children[*at]].aabb.half_area();
            let inner = (0..children.len()).filter(|at| !self.is_leaf(children[*at]));
            let Some(widest) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else { break };
            let first = self.binary.nodes[children[widest]].first_index as usize;
            children[widest] = first;
            children.push(first + 1);
        }
        children
    }

    fn leaf(&mut self, node: usize) -> u32 {
        let mut primitives = Vec::with_capacity(self.leaf_size as usize);
        let mut open = vec![node];
        while let Some(node) = open.pop() {
            let node = &self.binary.nodes[node];
            let first = node.first_index as usize;
            if node.is_leaf() {
                primitives.extend(&self.binary.primitive_indices[first..][..node.prim_count as usize]);
            } else {
                open.extend([first, first + 1]);
            }
        }
        (self.make_leaf)(&primitives)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(count: usize) -> Vec<Box3> {
        let at = |i: usize| Box3 { low: [i as f32, 0.0, 0.0], high: [i as f32 + 0.5, 1.0, 1.0] };
        (0..count).map(at).collect()
    }

    #[test]
    fn every_box_is_in_one_leaf_and_every_child_within_its_box() {
        for count in [0, 1, 2, 8, 9, 100, 1000] {
            let boxes = row(count);
            let mut leaves: Vec<Vec<u32>> = Vec::new();
            let tree = Tree::new(&boxes, 4, |ids| {
                leaves.push(ids.to_vec());
                leaves.len() as u32 - 1
            });
            let mut seen: Vec<u32> = leaves.iter().flatten().copied().collect();
            seen.sort_unstable();
            assert_eq!(seen, (0..count as u32).collect::<Vec<_>>());
            assert!(leaves.iter().all(|leaf| leaf.len() <= 4));
            for node in &tree.nodes {
                for slot in (0..WIDTH).filter(|slot| node.planes[0][*slot] <= node.planes[3][*slot]) {
                    let Ok(leaf) = node.children[slot].open() else { continue };
                    for id in &leaves[leaf as usize] {
                        let inside = &boxes[*id as usize];
                        assert!(
                            node.planes[0][slot] <= inside.low[0] && inside.high[0] <= node.planes[3][slot]
                        );
                    }
                }
            }
        }
    }
}
