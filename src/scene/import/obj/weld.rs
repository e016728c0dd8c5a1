//! Merges corners, which have three indices each, into vertices, which have one.
//!
//! A vertex stands for all corners with the same position, texture coordinate and normal. Vertices come
//! in the order of their positions in the file, those of one position in an order that follows from its
//! corners' order in the file. So their numbers do not depend on how the work was split; and a file whose
//! indices agree anyway (or that has positions alone) keeps its lists as they are.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::iter;
use std::ops::Range;

use rayon::prelude::*;

use super::fault::Fault;
use super::join::{Joined, concatenated};
use crate::scene::import::faces::run::{FaceRun, Indices, all_used};

/// End of a list of variants.
const NONE: u32 = u32::MAX;

/// Maximum number of variants of a position that are searched one by one.
const LONGEST_WALK: usize = 64;

/// Number of blocks of positions for each thread: more than one, because they take different times.
const BLOCKS_A_THREAD: usize = 4;

/// Vertex data: lists of one entry a vertex, or empty.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    pub positions: Vec<[f32; 3]>,
    /// Numbers of the positions in the file; empty if they equal the vertices' own numbers.
    pub sources: Vec<u32>,
    /// Texture coordinates; finite.
    pub uvs: Vec<[f32; 2]>,
    /// Normals; of unit length, or zero.
    pub normals: Vec<[f32; 3]>,
}

/// Relation of the corners' indices of one attribute (texture coordinate or normal) to those of their
/// positions.
#[derive(Debug, Clone, Copy, PartialEq)]
enum IndexRelation {
    /// No corner has the attribute.
    Absent,
    /// Both indices are the same in each corner.
    Same,
    /// Indices of their own.
    Own,
}

/// Combination in which corners use one position: with a texture coordinate and a normal (from 1; 0 if
/// absent, or if the index follows from the position).
#[derive(Debug, Clone, Copy)]
struct Variant {
    key: [u32; 2],
    /// Next variant of the position, in its block; or `NONE`.
    next: u32,
    /// Number of the vertex within its block; `NONE` if no corner has asked for the position yet.
    vertex: u32,
}

/// Variants of a block of positions: first the first one of each position, then all others.
#[derive(Debug)]
struct Block {
    /// Number of positions.
    positions: usize,
    variants: Vec<Variant>,
    /// Variants beyond the [`LONGEST_WALK`], by position and key.
    far: HashMap<(usize, [u32; 2]), u32>,
    /// Number of vertices.
    count: usize,
}

/// Makes vertices. The runs' `positions` become the corners' vertices; `uvs` and `normals` are dropped.
pub(super) fn weld(joined: &mut Joined) -> Result<Vertices, Fault> {
    let parts = [part(&joined.runs, |run| &run.uvs), part(&joined.runs, |run| &run.normals)];
    let is_long = |part: IndexRelation, entries: usize| {
        part == IndexRelation::Absent || entries >= joined.positions.len()
    };
    if !parts.contains(&IndexRelation::Own)
        && is_long(parts[0], joined.uvs.len())
        && is_long(parts[1], joined.normals.len())
        && all_used(&joined.runs, joined.positions.len())
    {
        return Ok(as_they_are(joined, parts));
    }
    number(joined, parts)
}

fn part(runs: &[FaceRun], indices: impl Fn(&FaceRun) -> &Indices) -> IndexRelation {
    // runs without faces say nothing
    let mut all = runs.iter().filter(|run| run.faces > 0).map(indices);
    match all.next() {
        None => IndexRelation::Absent,
        Some(Indices::Absent) if all.all(|indices| *indices == Indices::Absent) => IndexRelation::Absent,
        Some(Indices::AsPositions) if all.all(|indices| *indices == Indices::AsPositions) => {
            IndexRelation::Same
        }
        _ => IndexRelation::Own,
    }
}

fn as_they_are(joined: &mut Joined, parts: [IndexRelation; 2]) -> Vertices {
    let positions = std::mem::take(&mut joined.positions);
    let mut uvs = if parts[0] == IndexRelation::Same { std::mem::take(&mut joined.uvs) } else { Vec::new() };
    let mut normals =
        if parts[1] == IndexRelation::Same { std::mem::take(&mut joined.normals) } else { Vec::new() };
    uvs.truncate(positions.len());
    normals.truncate(positions.len());
    Vertices { positions, sources: Vec::new(), uvs, normals }
}

fn number(joined: &mut Joined, parts: [IndexRelation; 2]) -> Result<Vertices, Fault> {
    let positions = joined.positions.len();
    let wanted = rayon::current_num_threads() * BLOCKS_A_THREAD;
    let size = positions.div_ceil(wanted).max(1).next_power_of_two();
    let extents: Vec<Range<u32>> = joined.runs.par_iter().map(extent).collect();
    let blocks: Vec<Block> = (0..positions.div_ceil(size))
        .into_par_iter()
        .map(|block| {
            Block::new(block * size..positions.min((block + 1) * size), &joined.runs, &extents, parts)
        })
        .collect();
    let mut vertices = 0;
    let firsts = blocks.iter().map(|block| {
        let first = vertices;
        vertices += block.count;
        first
    });
    let firsts: Vec<usize> = firsts.collect();
    if vertices > u32::MAX as usize {
        return Err(Fault::whole("more than 4294967295 vertices: split the model"));
    }
    joined.runs.par_iter_mut().for_each(|run| {
        for corner in 0..run.positions.len() {
            let (key, position) = (run.key(corner, parts), run.positions[corner] as usize);
            let block = position / size;
            run.positions[corner] = firsts[block] as u32 + blocks[block].vertex(position % size, key);
        }
        (run.uvs, run.normals) = (Indices::Absent, Indices::Absent);
    });
    Ok(Vertices {
        positions: gathered(&blocks, size, |position, _| joined.positions[position]),
        sources: gathered(&blocks, size, |position, _| position as u32),
        uvs: match parts[0] {
            IndexRelation::Absent => Vec::new(),
            part => gathered(&blocks, size, |position, [key, _]| {
                index(part, key, position).and_then(|i| joined.uvs.get(i)).copied().unwrap_or_default()
            }),
        },
        normals: match parts[1] {
            IndexRelation::Absent => Vec::new(),
            part => gathered(&blocks, size, |position, [_, key]| {
                index(part, key, position).and_then(|i| joined.normals.get(i)).copied().unwrap_or_default()
            }),
        },
    })
}

/// Range of the positions that a run uses.
fn extent(run: &FaceRun) -> Range<u32> {
    let lowest = run.positions.iter().copied().min().unwrap_or(0);
    lowest..run.positions.iter().copied().max().map_or(0, |highest| highest + 1)
}

impl FaceRun {
    #[inline(always)]
    fn key(&self, corner: usize, [uv, normal]: [IndexRelation; 2]) -> [u32; 2] {
        [(uv, &self.uvs), (normal, &self.normals)].map(|(part, indices)| match (part, indices) {
            (IndexRelation::Own, Indices::Own(indices)) => indices[corner],
            (IndexRelation::Own, Indices::AsPositions) => self.positions[corner] + 1,
            // what follows from the position is looked up there
            _ => 0,
        })
    }
}

impl Block {
    /// Collects the variants of the positions in `range`. Goes through all runs that use any of them.
    fn new(range: Range<usize>, runs: &[FaceRun], extents: &[Range<u32>], parts: [IndexRelation; 2]) -> Self {
        let empty = Variant { key: [0; 2], next: NONE, vertex: NONE };
        let variants = vec![empty; range.len()];
        let mut block = Self { positions: range.len(), variants, far: HashMap::new(), count: 0 };
        let range = range.start as u32..range.end as u32;
        let touching = |extent: &Range<u32>| extent.start < range.end && range.start < extent.end;
        for (run, _) in runs.iter().zip(extents).filter(|(_, extent)| touching(extent)) {
            for (corner, position) in run.positions.iter().enumerate() {
                let place = position.wrapping_sub(range.start) as usize;
                if place < range.len() {
                    block.add(place, run.key(corner, parts));
                }
            }
        }
        block.number();
        block
    }

    #[inline(always)]
    fn add(&mut self, place: usize, key: [u32; 2]) {
        let first = &mut self.variants[place];
        if first.vertex == NONE {
            *first = Variant { key, next: NONE, vertex: 0 };
        } else if first.key != key {
            self.add_behind(place, key);
        }
    }

    /// Adds a variant that is not the first of its position.
    fn add_behind(&mut self, place: usize, key: [u32; 2]) {
        let new = self.variants.len() as u32;
        let mut at = place;
        for _ in 0..LONGEST_WALK {
            let next = self.variants[at].next;
            if next == NONE {
                self.variants[at].next = new;
                self.variants.push(Variant { key, next: NONE, vertex: 0 });
                return;
            }
            at = next as usize;
            if self.variants[at].key == key {
                return;
            }
        }
        if let Entry::Vacant(entry) = self.far.entry((place, key)) {
            entry.insert(new);
            // the end of the list is far: the new one goes before the others of its kind
            let next = std::mem::replace(&mut self.variants[at].next, new);
            self.variants.push(Variant { key, next, vertex: 0 });
        }
    }

    /// Counts the vertices, position by position.
    fn number(&mut self) {
        for place in 0..self.positions as u32 {
            let is_used = self.variants[place as usize].vertex != NONE;
            let mut at = if is_used { place } else { NONE };
            while at != NONE {
                let variant = &mut self.variants[at as usize];
                variant.vertex = self.count as u32;
                self.count += 1;
                at = variant.next;
            }
        }
    }

    /// Position in the block, and key, of each vertex, in order.
    fn vertices(&self) -> impl Iterator<Item = (usize, [u32; 2])> {
        let used = (0..self.positions).filter(|place| self.variants[*place].vertex != NONE);
        used.flat_map(|place| {
            let variants = iter::successors(Some(&self.variants[place]), |variant| {
                self.variants.get(variant.next as usize)
            });
            variants.map(move |variant| (place, variant.key))
        })
    }

    /// Vertex of a corner that was added.
    #[inline(always)]
    fn vertex(&self, place: usize, key: [u32; 2]) -> u32 {
        let mut variant = &self.variants[place];
        for _ in 0..=LONGEST_WALK {
            if variant.key == key {
                return variant.vertex;
            }
            variant = &self.variants[variant.next as usize];
        }
        self.variants[self.far[&(place, key)] as usize].vertex
    }
}

/// Gathers one attribute of all vertices, in their order: `value` gives it for a position and a key.
fn gathered<T: Copy + Default + Send + Sync>(
    blocks: &[Block],
    size: usize,
    value: impl Fn(usize, [u32; 2]) -> T + Sync,
) -> Vec<T> {
    let lists = blocks.par_iter().enumerate().map(|(number, block)| {
        block.vertices().map(|(place, key)| value(number * size + place, key)).collect()
    });
    concatenated(lists.collect::<Vec<Vec<T>>>().into_iter())
}

/// Index, from 0, of a vertex's attribute.
fn index(part: IndexRelation, key: u32, position: usize) -> Option<usize> {
    match part {
        IndexRelation::Absent => None,
        IndexRelation::Same => Some(position),
        IndexRelation::Own => (key as usize).checked_sub(1),
    }
}
