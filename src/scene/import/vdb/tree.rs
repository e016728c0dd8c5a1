//! Values of a grid: a tree of nodes of 32 and 16 children along each edge, and of leaves of eight points.
//!
//! First comes the shape of the whole tree, with the values of nodes that have no children; then the leaves, in the same order. Sources of
//! the format: `openvdb/tree/RootNode.h`, `InternalNode.h`, `LeafNode.h` and `io/Compression.h` of OpenVDB.

use glam::{IVec3, Vec3};

use super::packed::{self, Packing};
use crate::scene::import::bytes::Bytes;
use crate::scene::volume::{BLOCK_POINTS, Grid};

/// Children along each edge of an upper node, and of a lower one, as powers of two.
const UPPER: u32 = 5;
const LOWER: u32 = 4;

/// Points along the edge of an upper node.
const UPPER_POINTS: i32 = 4096;

/// Coordinates of points, at most: far from where sums of them would overflow.
const FARTHEST: i32 = 1 << 30;

/// Blocks of a grid that are not empty, at most: two billion points.
const MOST_BLOCKS: usize = 1 << 22;

/// How values are read.
pub struct Coding {
    pub packing: Packing,
    pub are_halves: bool,
    /// Numbers of a value: 1 or 3.
    pub width: usize,
}

/// A leaf, before its values are read.
struct Leaf {
    /// In blocks.
    at: IVec3,
}

/// Reads the values of a grid into `grid`.
pub fn read(bytes: &mut Bytes<'_>, coding: &Coding, grid: &mut Grid) -> Result<(), String> {
    // buffers of a leaf
    bytes.u32()?;
    let background = raw(bytes, coding.width)?;
    let [tiles, children] = [bytes.count()?, bytes.count()?];
    for _ in 0..tiles {
        origin(bytes)?;
        let value = raw(bytes, coding.width)?;
        if bytes.byte()? != 0 && value.iter().any(|value| *value != 0.0) {
            return Err(String::from(
                "a cube of 4096 points along each edge has one value: save it without such a tile",
            ));
        }
    }
    let mut reader = Reader { coding, background, leaves: Vec::new(), count: 0 };
    for _ in 0..children {
        let at = origin(bytes)?;
        reader.upper(bytes, at, grid)?;
    }
    let leaves = std::mem::take(&mut reader.leaves);
    for leaf in leaves {
        let active = bytes.take(BLOCK_POINTS / 8)?;
        let values = reader.values(bytes, active, BLOCK_POINTS)?;
        grid.set_block(leaf.at, &values);
    }
    Ok(())
}

/// The lowest point of an upper node.
fn origin(bytes: &mut Bytes<'_>) -> Result<IVec3, String> {
    let at = IVec3::new(bytes.i32()?, bytes.i32()?, bytes.i32()?);
    let is_near = at.cmpge(IVec3::splat(-FARTHEST)).all() && at.cmple(IVec3::splat(FARTHEST)).all();
    if !is_near || at.rem_euclid(IVec3::splat(UPPER_POINTS)) != IVec3::ZERO {
        return Err(format!("a node at {at} is in no place of one: it is damaged"));
    }
    Ok(at)
}

/// A value as it is.
fn raw(bytes: &mut Bytes<'_>, width: usize) -> Result<Vec<f32>, String> {
    (0..width).map(|_| bytes.array().map(f32::from_le_bytes)).collect()
}

struct Reader<'c> {
    coding: &'c Coding,
    background: Vec<f32>,
    leaves: Vec<Leaf>,
    /// Blocks so far.
    count: usize,
}

impl Reader<'_> {
    fn upper(&mut self, bytes: &mut Bytes<'_>, at: IVec3, grid: &mut Grid) -> Result<(), String> {
        let first = at / 128;
        let children = self.node(bytes, UPPER, &mut |reader, offset, value| {
            reader.add(4096)?;
            grid.set_even_node(first + offset, value);
            Ok(())
        })?;
        for offset in children {
            self.lower(bytes, (first + offset) * 16, grid)?;
        }
        Ok(())
    }

    /// Reads a node of leaves; `first`: in blocks.
    fn lower(&mut self, bytes: &mut Bytes<'_>, first: IVec3, grid: &mut Grid) -> Result<(), String> {
        let children = self.node(bytes, LOWER, &mut |reader, offset, value| {
            reader.add(1)?;
            grid.set_even_block(first + offset, value);
            Ok(())
        })?;
        for offset in children {
            // its mask, which comes again before its values
            bytes.take(BLOCK_POINTS / 8)?;
            self.add(1)?;
            self.leaves.push(Leaf { at: first + offset });
        }
        Ok(())
    }

    fn add(&mut self, blocks: usize) -> Result<(), String> {
        self.count += blocks;
        if self.count > MOST_BLOCKS {
            return Err(String::from(
                "it has more than 2 billion points that are not empty: make it coarser",
            ));
        }
        Ok(())
    }

    /// Reads a node. Calls `tile` with those places in it that have a value and no child; returns the places of the children.
    fn node(
        &mut self,
        bytes: &mut Bytes<'_>,
        edge: u32,
        tile: &mut dyn FnMut(&mut Self, IVec3, Vec3) -> Result<(), String>,
    ) -> Result<Vec<IVec3>, String> {
        let count = 1_usize << (3 * edge);
        let [children, active] = [bytes.take(count / 8)?, bytes.take(count / 8)?];
        let values = self.values(bytes, active, count)?;
        let place = |number: usize| {
            let (number, mask) = (number as i32, (1 << edge) - 1);
            IVec3::new(number >> (2 * edge), number >> edge & mask, number & mask)
        };
        let width = self.coding.width;
        for number in (0..count).filter(|number| !is_set(children, *number)) {
            let value = &values[number * width..][..width];
            let is_said = is_set(active, number) || value != self.background;
            if is_said && value.iter().any(|value| *value != 0.0) {
                let value = if width == 3 { Vec3::from_slice(value) } else { Vec3::splat(value[0]) };
                tile(self, place(number), value)?;
            }
        }
        Ok((0..count).filter(|number| is_set(children, *number)).map(place).collect())
    }

    /// Reads the values of a node or leaf, of which those that are `active` may be all that the file has.
    fn values(&self, bytes: &mut Bytes<'_>, active: &[u8], count: usize) -> Result<Vec<f32>, String> {
        let &Coding { packing, are_halves, width } = self.coding;
        let kind = Inactive::of(bytes.byte()?)?;
        let negative: Vec<f32> = self.background.iter().map(|value| -value).collect();
        let mut two = match kind {
            Inactive::Background | Inactive::None => [self.background.clone(), self.background.clone()],
            _ => [negative, self.background.clone()],
        };
        if matches!(kind, Inactive::One | Inactive::MaskOfOne | Inactive::MaskOfTwo) {
            two[0] = raw(bytes, width)?;
        }
        if kind == Inactive::MaskOfTwo {
            two[1] = raw(bytes, width)?;
        }
        let has_mask = matches!(kind, Inactive::Mask | Inactive::MaskOfOne | Inactive::MaskOfTwo);
        let second = if has_mask { bytes.take(count / 8)? } else { &[] };
        let leaves_out = packing.leaves_out_inactive() && kind != Inactive::None;
        let there =
            if leaves_out { active.iter().map(|byte| byte.count_ones() as usize).sum() } else { count };
        let values = packed::floats(bytes, there * width, packing, are_halves)?;
        if there == count {
            return Ok(values);
        }
        let (mut all, mut next) = (Vec::with_capacity(count * width), values.chunks_exact(width));
        for number in 0..count {
            let value = match is_set(active, number) {
                true => next.next().expect("as many as are active"),
                false => &two[usize::from(has_mask && is_set(second, number))],
            };
            all.extend_from_slice(value);
        }
        Ok(all)
    }
}

/// What inactive values are, where they are left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Inactive {
    /// The background.
    Background,
    /// Its negative.
    Negative,
    /// A value.
    One,
    /// The background or its negative, by a mask.
    Mask,
    /// The background or a value, by a mask.
    MaskOfOne,
    /// One of two values, by a mask.
    MaskOfTwo,
    /// They are not left out.
    None,
}

impl Inactive {
    fn of(byte: u8) -> Result<Self, String> {
        const ALL: [Inactive; 7] = [
            Inactive::Background,
            Inactive::Negative,
            Inactive::One,
            Inactive::Mask,
            Inactive::MaskOfOne,
            Inactive::MaskOfTwo,
            Inactive::None,
        ];
        let known = ALL.get(usize::from(byte)).copied();
        known.ok_or_else(|| format!("a node has values of the kind {byte}, which is none: it is damaged"))
    }
}

/// Returns true if a bit of a mask is set.
fn is_set(mask: &[u8], number: usize) -> bool {
    mask[number / 8] >> (number % 8) & 1 == 1
}
