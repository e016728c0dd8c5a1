//! Puts the pieces of a file together: what is defined where, and what indices and names then mean.

use std::collections::HashMap;

use rayon::prelude::*;

use super::column::{Indices, MOST_ENTRIES, OutOfRange};
use super::fault::Fault;
use super::piece::{Faces, Name, Piece};

/// What a file says, with absolute indices.
#[derive(Debug, Default)]
pub(super) struct Joined {
    /// Of `v`.
    pub positions: Vec<[f32; 3]>,
    /// Of `vt`; finite.
    pub uvs: Vec<[f32; 2]>,
    /// Of `vn`; of unit length, or zero.
    pub normals: Vec<[f32; 3]>,
    /// In the order of the file.
    pub runs: Vec<Run>,
    /// By first use; the first is no material.
    pub materials: Vec<Named>,
    /// What `mtllib` lines say.
    pub libraries: Vec<Named>,
    /// Faces of fewer than three corners.
    pub too_small: usize,
}

/// A name in the text and the first line that has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// Trimmed; may hold spaces.
    pub name: String,
    /// From 1.
    pub line: usize,
}

/// Faces of one piece; corners are in order.
#[derive(Debug, Default)]
pub(super) struct Run {
    /// Indices from 0.
    pub positions: Vec<u32>,
    /// Of texture coordinates.
    pub uvs: Indices,
    /// Of normals.
    pub normals: Indices,
    /// Number of faces.
    pub faces: usize,
    /// Corners of each face; empty where all have three.
    pub arities: Vec<u16>,
    /// From which face on which of the file's materials is used; the first entry is for face 0.
    pub uses: Vec<(u32, u32)>,
}

/// Why pieces do not fit together.
#[derive(Debug)]
pub(super) enum Misfit {
    /// Where, has to be looked for in the text.
    Somewhere,
    /// In the file as a whole.
    Whole(Fault),
}

/// Joins pieces that are not faulty.
pub(super) fn join(mut pieces: Vec<Piece>) -> Result<Joined, Misfit> {
    let (bases, counts) = bases(&pieces);
    if counts.iter().any(|count| *count > MOST_ENTRIES) {
        let message = format!("more than {MOST_ENTRIES} vertices: split the model");
        return Err(Misfit::Whole(Fault::whole(message)));
    }
    let mut joined =
        Joined { too_small: pieces.iter().map(|piece| piece.too_small).sum(), ..Joined::default() };
    joined.name(&mut pieces);
    joined.positions = concatenated(pieces.iter_mut().map(|piece| std::mem::take(&mut piece.positions)));
    joined.uvs = concatenated(pieces.iter_mut().map(|piece| std::mem::take(&mut piece.uvs)));
    joined.normals = concatenated(pieces.iter_mut().map(|piece| std::mem::take(&mut piece.normals)));
    let runs = pieces.into_par_iter().zip(bases).map(|(piece, base)| Run::new(piece.faces, base, counts));
    joined.runs = runs.collect::<Result<_, _>>().map_err(|OutOfRange| Misfit::Somewhere)?;
    Ok(joined)
}

/// How many `v`, `vt`, `vn` the pieces before each one define, and how many all do.
fn bases(pieces: &[Piece]) -> (Vec<[u64; 3]>, [u64; 3]) {
    let mut sum = [0; 3];
    let bases = pieces.iter().map(|piece| {
        let before = sum;
        let counts = [piece.positions.len(), piece.uvs.len(), piece.normals.len()];
        sum = [0, 1, 2].map(|part| sum[part] + counts[part] as u64);
        before
    });
    (bases.collect(), sum)
}

/// One list of many, with room for one more (which a vertex buffer needs).
pub(super) fn concatenated<T: Copy + Default + Send + Sync>(lists: impl Iterator<Item = Vec<T>>) -> Vec<T> {
    let lists: Vec<Vec<T>> = lists.collect();
    let length = lists.iter().map(Vec::len).sum();
    let mut whole = vec![T::default(); length + 1]; // zeros: the system gives them for nothing
    whole.truncate(length);
    let lengths = lists.iter().map(Vec::len);
    let places = split(&mut whole, lengths);
    // each is freed once it is copied
    places.into_par_iter().zip(lists).for_each(|(place, list)| place.copy_from_slice(&list));
    whole
}

/// Parts of so many entries, from the first on.
pub(super) fn split<T>(mut list: &mut [T], lengths: impl Iterator<Item = usize>) -> Vec<&mut [T]> {
    let mut parts = Vec::new();
    for length in lengths {
        let (part, rest) = list.split_at_mut(length);
        list = rest;
        parts.push(part);
    }
    parts
}

impl Joined {
    /// Gives materials their numbers in the file, and names their lines. Each piece gets the material that
    /// it begins with.
    fn name(&mut self, pieces: &mut [Piece]) {
        self.materials.push(Named { name: String::new(), line: 0 });
        let mut number_of = HashMap::from([(Vec::new(), 0)]);
        let (mut line, mut current) = (1, 0);
        for piece in pieces {
            let mut number = |(name, ahead): Name| {
                *number_of.entry(name).or_insert_with_key(|name| {
                    self.materials.push(named(name, line + ahead));
                    self.materials.len() as u32 - 1
                })
            };
            let numbers: Vec<u32> =
                std::mem::take(&mut piece.materials).into_iter().map(&mut number).collect();
            let uses = piece.faces.uses.iter().map(|(face, material)| (*face, numbers[*material as usize]));
            let uses: Vec<(u32, u32)> = std::iter::once((0, current)).chain(uses).collect();
            current = uses.last().map_or(current, |(_, material)| *material);
            piece.faces.uses = uses;
            self.libraries.extend(piece.libraries.iter().map(|(name, ahead)| named(name, line + ahead)));
            line += piece.lines;
        }
    }
}

fn named(name: &[u8], line: usize) -> Named {
    Named { name: String::from_utf8_lossy(name).into_owned(), line }
}

impl Run {
    /// So many entries are defined before the piece, and `counts` in the file.
    fn new(faces: Faces, [bv, bvt, bvn]: [u64; 3], counts: [u64; 3]) -> Result<Self, OutOfRange> {
        let Faces { columns: [positions, uvs, normals], corners, count, arities, uses, .. } = faces;
        let mut places = match positions.resolve(bv, counts[0], corners, &[])? {
            Indices::Own(places) => places,
            _ if corners == 0 => Vec::new(),
            _ => return Err(OutOfRange), // not one vertex in the file
        };
        let uvs = uvs.resolve(bvt, counts[1], corners, &places)?;
        let normals = normals.resolve(bvn, counts[2], corners, &places)?;
        places.iter_mut().for_each(|index| *index -= 1);
        Ok(Self { positions: places, uvs, normals, faces: count, arities, uses })
    }
}
