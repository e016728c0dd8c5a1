//! Volumes: values on lattices of which most points are empty, as OpenVDB's files have them.
//!
//! Values are kept in blocks of eight points along each edge, and nodes of sixteen blocks: what is empty takes nothing.

use std::collections::HashMap;

use glam::{DAffine3, DVec3, IVec3, Vec3};

/// Points along the edge of a block.
pub const BLOCK: i32 = 8;

/// Points of a block.
pub const BLOCK_POINTS: usize = (BLOCK * BLOCK * BLOCK) as usize;

/// Blocks along the edge of a node.
pub const NODE: i32 = 16;

/// Blocks of a node.
pub const NODE_BLOCKS: usize = (NODE * NODE * NODE) as usize;

/// Marks the number of a value that a whole block has.
const EVEN: u32 = 1 << 31;

/// The number of a block that is empty.
const NONE: u32 = u32::MAX;

/// Grids of one file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Volume {
    /// Each has a name of its own.
    pub grids: Vec<Grid>,
}

impl Volume {
    /// The grid of this name.
    pub fn grid(&self, name: &str) -> Option<&Grid> {
        self.grids.iter().find(|grid| grid.name == name)
    }
}

/// Values at the points of a lattice: zero where nothing is said.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Name in the file.
    pub name: String,
    /// Map of object space to the lattice, whose points have whole numbers.
    pub to_lattice: DAffine3,
    /// Numbers of a value: 1 or 3.
    width: usize,
    /// Nodes by their place, in nodes.
    nodes: HashMap<IVec3, Node>,
    /// Values of blocks: of a point one after the other, points along Z first, then Y, then X.
    values: Vec<f32>,
    /// Values that whole blocks have.
    even: Vec<Vec3>,
}

#[derive(Debug, Clone, PartialEq)]
enum Node {
    /// All of it has one value.
    Even(Vec3),
    /// Numbers of its blocks: along Z first.
    Blocks(Vec<u32>),
}

impl Grid {
    /// Creates a grid without values, of numbers or of vectors. `to_lattice`: map of object space to the lattice.
    pub fn new(name: String, to_lattice: DAffine3, is_vector: bool) -> Self {
        let width = if is_vector { 3 } else { 1 };
        Self { name, to_lattice, width, nodes: HashMap::new(), values: Vec::new(), even: Vec::new() }
    }

    /// Says the values of a block, whose place is in blocks: as many as points, or three times as many, along Z first.
    ///
    /// # Panics
    /// If there are more or less.
    pub fn set_block(&mut self, at: IVec3, values: &[f32]) {
        assert_eq!(values.len(), BLOCK_POINTS * self.width, "values of all points of a block");
        if values.iter().all(|value| *value == 0.0) {
            return;
        }
        let number = (self.values.len() / values.len()) as u32;
        self.values.extend(values.iter().map(|value| if value.is_finite() { *value } else { 0.0 }));
        self.number(at, number);
    }

    /// Says that all points of a block have one value.
    pub fn set_even_block(&mut self, at: IVec3, value: Vec3) {
        if value.is_finite() && value != Vec3::ZERO {
            self.even.push(value);
            self.number(at, EVEN | (self.even.len() - 1) as u32);
        }
    }

    /// Says that all points of a node have one value.
    pub fn set_even_node(&mut self, at: IVec3, value: Vec3) {
        if value.is_finite() && value != Vec3::ZERO {
            self.nodes.insert(at, Node::Even(value));
        }
    }

    fn number(&mut self, at: IVec3, number: u32) {
        let (node, slot) = node_of(at);
        let node = self.nodes.entry(node).or_insert_with(|| Node::Blocks(Vec::new()));
        if let Node::Even(_) = node {
            *node = Node::Blocks(Vec::new());
        }
        if let Node::Blocks(blocks) = node {
            if blocks.is_empty() {
                *blocks = vec![NONE; NODE_BLOCKS];
            }
            blocks[slot] = number;
        }
    }

    /// Number of its blocks that are not empty.
    pub fn count(&self) -> usize {
        let of = |node: &Node| match node {
            Node::Even(_) => NODE_BLOCKS,
            Node::Blocks(blocks) => blocks.iter().filter(|number| **number != NONE).count(),
        };
        self.nodes.values().map(of).sum()
    }

    /// Places of the blocks that are not empty, in no order.
    pub fn filled_blocks(&self) -> impl Iterator<Item = IVec3> + '_ {
        self.nodes.iter().flat_map(|(node, of)| {
            let is_filled = move |slot: &usize| match of {
                Node::Even(_) => true,
                Node::Blocks(blocks) => blocks[*slot] != NONE,
            };
            (0..NODE_BLOCKS).filter(is_filled).map(move |slot| {
                let slot = slot as i32;
                *node * NODE + IVec3::new(slot / (NODE * NODE), slot / NODE % NODE, slot % NODE)
            })
        })
    }

    /// Lowest and highest of the points that are not zero. `None`, if all are.
    pub fn filled_points(&self) -> Option<[IVec3; 2]> {
        let mut both: Option<[IVec3; 2]> = None;
        for block in self.filled_blocks() {
            let first = block * BLOCK;
            let mut add = |point: IVec3| {
                both = Some(both.map_or([point; 2], |[low, high]| [low.min(point), high.max(point)]));
            };
            match self.block(block) {
                Values::None => {}
                Values::Even(_) => [0, BLOCK - 1].into_iter().for_each(|along| add(first + along)),
                Values::Each(values) => {
                    for (number, value) in (0..).zip(values.chunks(self.width)) {
                        if value.iter().any(|value| *value != 0.0) {
                            add(first
                                + IVec3::new(
                                    number / (BLOCK * BLOCK),
                                    number / BLOCK % BLOCK,
                                    number % BLOCK,
                                ));
                        }
                    }
                }
            }
        }
        both
    }

    fn block(&self, at: IVec3) -> Values<'_> {
        let (node, slot) = node_of(at);
        match self.nodes.get(&node) {
            None => Values::None,
            Some(Node::Even(value)) => Values::Even(*value),
            Some(Node::Blocks(blocks)) => match blocks[slot] {
                NONE => Values::None,
                number if number & EVEN != 0 => Values::Even(self.even[(number & !EVEN) as usize]),
                number => {
                    let size = BLOCK_POINTS * self.width;
                    Values::Each(&self.values[number as usize * size..][..size])
                }
            },
        }
    }

    fn in_block(&self, values: &Values<'_>, at: IVec3) -> Vec3 {
        match values {
            Values::None => Vec3::ZERO,
            Values::Even(value) => *value,
            Values::Each(values) => {
                let number = ((at.x * BLOCK + at.y) * BLOCK + at.z) as usize;
                if self.width == 1 {
                    Vec3::splat(values[number])
                } else {
                    Vec3::from_slice(&values[3 * number..])
                }
            }
        }
    }

    /// Value at a point of the lattice; a number is the same three times.
    pub fn value(&self, at: IVec3) -> Vec3 {
        let block = at.div_euclid(IVec3::splat(BLOCK));
        self.in_block(&self.block(block), at - block * BLOCK)
    }

    /// Value at a place between points of the lattice, trilinear.
    pub fn between(&self, at: DVec3) -> Vec3 {
        let at = at.clamp(DVec3::splat(-1e9), DVec3::splat(1e9));
        let (first, within) = (at.floor().as_ivec3(), (at - at.floor()).as_vec3());
        let corner = |number: i32| {
            let offset = IVec3::new(number & 1, number >> 1 & 1, number >> 2);
            let weights = Vec3::select(offset.cmpeq(IVec3::ONE), within, 1.0 - within);
            self.value(first + offset) * (weights.x * weights.y * weights.z)
        };
        (0..8).map(corner).sum()
    }
}

/// Place of the node of a block, and the block's number in it.
fn node_of(at: IVec3) -> (IVec3, usize) {
    let node = at.div_euclid(IVec3::splat(NODE));
    let within = at - node * NODE;
    (node, ((within.x * NODE + within.y) * NODE + within.z) as usize)
}

/// Values of a block.
enum Values<'a> {
    None,
    Even(Vec3),
    Each(&'a [f32]),
}

/// A block of a grid, and the first points of those behind it.
pub struct Block<'a> {
    grid: &'a Grid,
    /// It, and those behind it along X, Y and Z: their bits are set in the number.
    all: [Values<'a>; 8],
}

impl<'a> Block<'a> {
    /// The block at a place, in blocks.
    pub fn new(grid: &'a Grid, at: IVec3) -> Self {
        let behind = |number: i32| grid.block(at + IVec3::new(number & 1, number >> 1 & 1, number >> 2));
        Self { grid, all: [0, 1, 2, 3, 4, 5, 6, 7].map(behind) }
    }

    /// Values at its points and the next ones behind: nine along each edge, along X first, then Y, then Z.
    pub fn values(&self) -> impl Iterator<Item = Vec3> + '_ {
        const EDGE: i32 = BLOCK + 1;
        (0..EDGE * EDGE * EDGE).map(|number| {
            let at = IVec3::new(number % EDGE, number / EDGE % EDGE, number / (EDGE * EDGE));
            let behind = at / BLOCK;
            let block = &self.all[(behind.x | behind.y << 1 | behind.z << 2) as usize];
            self.grid.in_block(block, at - behind * BLOCK)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid {
        let mut grid = Grid::new(String::from("g"), DAffine3::IDENTITY, false);
        let values: Vec<f32> = (0..BLOCK_POINTS).map(|number| number as f32).collect();
        grid.set_block(IVec3::new(-1, 0, 2), &values);
        grid.set_even_block(IVec3::new(0, 0, 2), Vec3::splat(5.0));
        grid.set_even_node(IVec3::new(3, 0, 0), Vec3::splat(7.0));
        grid
    }

    #[test]
    fn values_are_where_they_were_said() {
        let grid = grid();
        let at = |x, y, z| grid.value(IVec3::new(x, y, z)).x;
        assert_eq!((at(-8, 0, 16), at(-8, 0, 17), at(-7, 1, 16), at(-1, 7, 23)), (0.0, 1.0, 72.0, 511.0));
        assert_eq!((at(0, 0, 16), at(7, 7, 23), at(8, 0, 16), at(0, 0, 15)), (5.0, 5.0, 0.0, 0.0));
        assert_eq!((at(384, 0, 0), at(511, 127, 127), at(512, 0, 0), at(383, 0, 0)), (7.0, 7.0, 0.0, 0.0));
        assert_eq!(grid.between(DVec3::new(-0.5, 0.5, 16.5)).x, (448.0 + 449.0 + 456.0 + 457.0) / 8.0 + 2.5);
        assert_eq!(grid.count(), 2 + NODE_BLOCKS);
        assert_eq!(grid.filled_blocks().count(), grid.count());
        assert_eq!(grid.filled_points(), Some([IVec3::new(-8, 0, 0), IVec3::new(511, 127, 127)]));
    }

    #[test]
    fn a_block_has_the_points_behind_it() {
        let grid = grid();
        for block in
            [IVec3::new(-1, 0, 2), IVec3::new(-2, -1, 1), IVec3::new(47, 0, 0), IVec3::new(63, 15, 3)]
        {
            for (number, value) in (0..).zip(Block::new(&grid, block).values()) {
                let at = IVec3::new(number % 9, number / 9 % 9, number / 81);
                assert_eq!(value, grid.value(block * BLOCK + at), "{block} {at}");
            }
        }
    }

    #[test]
    fn what_is_zero_or_no_number_takes_nothing() {
        let mut grid = Grid::new(String::from("g"), DAffine3::IDENTITY, true);
        grid.set_block(IVec3::ZERO, &[0.0; BLOCK_POINTS * 3]);
        grid.set_even_block(IVec3::ONE, Vec3::NAN);
        grid.set_even_node(IVec3::ONE, Vec3::ZERO);
        assert_eq!((grid.count(), grid.filled_points()), (0, None));
        let mut values = [0.0; BLOCK_POINTS * 3];
        (values[0], values[4]) = (f32::INFINITY, 2.0);
        grid.set_block(IVec3::ZERO, &values);
        assert_eq!(grid.value(IVec3::ZERO), Vec3::ZERO);
        assert_eq!(grid.value(IVec3::Z), Vec3::Y * 2.0);
    }
}
