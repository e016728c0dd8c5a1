//! From corners with three indices each to vertices with one.
//!
//! A vertex is what corners share that have the same position, texture coordinate and normal. Vertices come
//! in the order of their positions in the file, those of one position by their first use. So their
//! numbers do not depend on how the work was split; and a file whose indices agree anyway (or that
//! has positions alone) keeps its lists as they are.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::fault::Fault;
use super::join::{Joined, Run};

/// Ends a list of variants.
const NONE: u32 = u32::MAX;

/// Blocks of positions for each thread: more than one, because they take different times.
const BLOCKS_A_THREAD: usize = 4;

/// What vertices have; lists of one entry a vertex or of none.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    pub positions: Vec<[f32; 3]>,
    /// Finite.
    pub uvs: Vec<Vec2>,
    /// Of unit length, or zero.
    pub normals: Vec<Vec3>,
}

/// How the corners' indices of one part follow from those of their positions.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Part {
    /// No corner has any.
    Absent,
    /// They are the same in each corner.
    Same,
    /// In no such way.
    Own,
}

/// What is used of one position: a texture coordinate and a normal (from 1; 0 for absent, or for what
/// need not be told apart).
#[derive(Debug, Clone, Copy)]
struct Variant {
    key: [u32; 2],
    /// The next variant of the position, in its block; or `NONE`.
    next: u32,
    /// The vertex, counted in its block; `NONE` where no corner has asked for the position yet.
    vertex: u32,
}

/// The variants of a block of positions: first the first one of each, then all others.
#[derive(Debug)]
struct Block {
    variants: Vec<Variant>,
    /// Of vertices.
    count: usize,
}

/// Makes vertices. The runs' `positions` become the corners' vertices, `uvs` and `normals` go.
pub(super) fn share(joined: &mut Joined) -> Result<Vertices, Fault> {
    let parts = [part(&joined.runs, |run| &run.uvs), part(&joined.runs, |run| &run.normals)];
    for run in &mut joined.runs {
        // what follows from the position is looked up there
        if parts[0] != Part::Own {
            run.uvs = Vec::new();
        }
        if parts[1] != Part::Own {
            run.normals = Vec::new();
        }
    }
    let same = |part: Part, entries: usize| part == Part::Absent || entries >= joined.positions.len();
    if !parts.contains(&Part::Own)
        && same(parts[0], joined.uvs.len())
        && same(parts[1], joined.normals.len())
        && all_used(&joined.runs, joined.positions.len())
    {
        return Ok(as_they_are(joined, parts));
    }
    number(joined, parts)
}

fn part(runs: &[Run], list: impl Fn(&Run) -> &Vec<u32> + Sync) -> Part {
    if runs.iter().all(|run| list(run).is_empty()) {
        return Part::Absent;
    }
    let is_same = |run: &Run| {
        list(run).len() == run.positions.len()
            && list(run).iter().zip(&run.positions).all(|(index, position)| *index == position + 1)
    };
    if runs.par_iter().all(is_same) { Part::Same } else { Part::Own }
}

/// Whether some face asks for each position: stray ones must not become vertices.
fn all_used(runs: &[Run], positions: usize) -> bool {
    let used: Vec<AtomicBool> = (0..positions).into_par_iter().map(|_| AtomicBool::new(false)).collect();
    runs.par_iter().flat_map_iter(|run| &run.positions).for_each(|index| {
        let flag = &used[*index as usize];
        // most are set already, and reading is cheaper than writing
        if !flag.load(Ordering::Relaxed) {
            flag.store(true, Ordering::Relaxed);
        }
    });
    used.par_iter().all(|flag| flag.load(Ordering::Relaxed))
}

fn as_they_are(joined: &mut Joined, parts: [Part; 2]) -> Vertices {
    let positions = std::mem::take(&mut joined.positions);
    let count = positions.len();
    let uvs = if parts[0] == Part::Same {
        joined.uvs[..count].par_iter().map(usable_uv).collect()
    } else {
        Vec::new()
    };
    let normals = if parts[1] == Part::Same {
        joined.normals[..count].par_iter().map(usable_normal).collect()
    } else {
        Vec::new()
    };
    Vertices { positions, uvs, normals }
}

fn usable_uv(uv: &[f32; 2]) -> Vec2 {
    Some(Vec2::from(*uv)).filter(|uv| uv.is_finite()).unwrap_or_default()
}

fn usable_normal(normal: &[f32; 3]) -> Vec3 {
    Vec3::from(*normal).normalize_or_zero()
}

fn number(joined: &mut Joined, parts: [Part; 2]) -> Result<Vertices, Fault> {
    let positions = joined.positions.len();
    let wanted = rayon::current_num_threads() * BLOCKS_A_THREAD;
    let size = positions.div_ceil(wanted).max(1).next_power_of_two();
    let extents: Vec<Range<u32>> = joined.runs.par_iter().map(extent).collect();
    let blocks: Vec<Block> = (0..positions.div_ceil(size))
        .into_par_iter()
        .map(|block| Block::new(block * size..positions.min((block + 1) * size), &joined.runs, &extents))
        .collect();
    let mut vertices = 0;
    let firsts: Vec<usize> = blocks.iter().map(|block| (vertices, vertices += block.count).0).collect();
    if vertices > u32::MAX as usize {
        return Err(Fault::whole("more than 4294967295 vertices: split the model"));
    }
    joined.runs.par_iter_mut().for_each(|run| {
        for corner in 0..run.positions.len() {
            let (key, position) = (run.key(corner), run.positions[corner] as usize);
            let block = position / size;
            run.positions[corner] = firsts[block] as u32 + blocks[block].vertex(position % size, key);
        }
        (run.uvs, run.normals) = (Vec::new(), Vec::new());
    });
    Ok(gathered(joined, parts, &blocks, size, vertices))
}

/// Which positions a run asks for.
fn extent(run: &Run) -> Range<u32> {
    let lowest = run.positions.iter().copied().min().unwrap_or(0);
    lowest..run.positions.iter().copied().max().map_or(0, |highest| highest + 1)
}

impl Run {
    #[inline(always)]
    fn key(&self, corner: usize) -> [u32; 2] {
        [&self.uvs, &self.normals].map(|list| list.get(corner).copied().unwrap_or(0))
    }
}

impl Block {
    /// Of the positions in `range`; goes through all runs that ask for any of them.
    fn new(range: Range<usize>, runs: &[Run], extents: &[Range<u32>]) -> Self {
        let empty = Variant { key: [0; 2], next: NONE, vertex: NONE };
        let mut block = Self { variants: vec![empty; range.len()], count: 0 };
        let range = range.start as u32..range.end as u32;
        let touching = |extent: &Range<u32>| extent.start < range.end && range.start < extent.end;
        for (run, _) in runs.iter().zip(extents).filter(|(_, extent)| touching(extent)) {
            for (corner, position) in run.positions.iter().enumerate() {
                let place = position.wrapping_sub(range.start) as usize;
                if place < range.len() {
                    block.add(place, run.key(corner));
                }
            }
        }
        block.number(range.len());
        block
    }

    #[inline(always)]
    fn add(&mut self, place: usize, key: [u32; 2]) {
        let first = &mut self.variants[place];
        if first.vertex == NONE {
            *first = Variant { key, next: NONE, vertex: 0 };
            return;
        }
        let mut at = place;
        while self.variants[at].key != key {
            if self.variants[at].next == NONE {
                self.variants[at].next = self.variants.len() as u32;
                self.variants.push(Variant { key, next: NONE, vertex: 0 });
                return;
            }
            at = self.variants[at].next as usize;
        }
    }

    /// Counts the vertices, position by position.
    fn number(&mut self, positions: usize) {
        for place in (0..positions).filter(|place| self.variants[*place].vertex != NONE).collect::<Vec<_>>() {
            let mut at = place as u32;
            while at != NONE {
                let variant = &mut self.variants[at as usize];
                variant.vertex = self.count as u32;
                self.count += 1;
                at = variant.next;
            }
        }
    }

    #[inline(always)]
    fn vertex(&self, place: usize, key: [u32; 2]) -> u32 {
        let mut variant = &self.variants[place];
        while variant.key != key {
            variant = &self.variants[variant.next as usize];
        }
        variant.vertex
    }
}

/// The lists of all vertices.
fn gathered(joined: &Joined, parts: [Part; 2], blocks: &[Block], size: usize, count: usize) -> Vertices {
    // one more, for a vertex buffer
    let mut positions = vec![[0.0; 3]; count + 1];
    positions.truncate(count);
    let mut uvs = vec![Vec2::ZERO; if parts[0] == Part::Absent { 0 } else { count }];
    let mut normals = vec![Vec3::ZERO; if parts[1] == Part::Absent { 0 } else { count }];
    let places = blocks.iter().enumerate().zip(split(&mut positions, blocks));
    let places = places.zip(split(&mut uvs, blocks)).zip(split(&mut normals, blocks));
    places.collect::<Vec<_>>().into_par_iter().for_each(|((((number, block), positions), uvs), normals)| {
        let firsts = block.variants.len().min(joined.positions.len() - number * size).min(size);
        for place in 0..firsts {
            let position = number * size + place;
            let mut at = place as u32;
            while at != NONE && block.variants[at as usize].vertex != NONE {
                let Variant { key, next, vertex } = block.variants[at as usize];
                let vertex = vertex as usize;
                positions[vertex] = joined.positions[position];
                if let Some(uv) = index(parts[0], key[0], position).and_then(|index| joined.uvs.get(index)) {
                    uvs[vertex] = usable_uv(uv);
                }
                if let Some(n) = index(parts[1], key[1], position).and_then(|index| joined.normals.get(index))
                {
                    normals[vertex] = usable_normal(n);
                }
                at = next;
            }
        }
    });
    Vertices { positions, uvs, normals }
}

/// Index from 0 of what a vertex has.
fn index(part: Part, key: u32, position: usize) -> Option<usize> {
    match part {
        Part::Absent => None,
        Part::Same => Some(position),
        Part::Own => (key as usize).checked_sub(1),
    }
}

/// The parts of `list` that belong to each block; empty ones of an empty list.
fn split<'a, T>(mut list: &'a mut [T], blocks: &[Block]) -> Vec<&'a mut [T]> {
    let mut parts = Vec::with_capacity(blocks.len());
    for block in blocks {
        let (part, rest) = list.split_at_mut(block.count.min(list.len()));
        list = rest;
        parts.push(part);
    }
    parts
}
