//! Joins the pieces of a file: makes indices absolute and names common to all.

use std::collections::HashMap;

use half::f16;
use rayon::prelude::*;

use super::column::{MOST_ENTRIES, OutOfRange};
use super::fault::Fault;
use super::piece::{Change, Faces, Name, Piece};
use crate::scene::import::faces::run::{FaceRun, Indices, split};
use crate::scene::import::faces::{Named, Use};

/// Content of a file, with absolute indices.
#[derive(Debug, Default)]
pub(super) struct Joined {
    /// Positions (`v`).
    pub positions: Vec<[f32; 3]>,
    /// Colours of the positions, none at all or one for each.
    pub colors: Vec<[f16; 3]>,
    /// Texture coordinates (`vt`); finite.
    pub uvs: Vec<[f32; 2]>,
    /// Normals (`vn`); of unit length, or zero.
    pub normals: Vec<[f32; 3]>,
    /// Faces, by piece in the order of the file.
    pub runs: Vec<FaceRun>,
    /// Names of materials by first use; the first is no material.
    pub materials: Vec<Named>,
    /// Names of groups by first use; the first is [`NO_GROUP`].
    pub groups: Vec<Named>,
    /// Arguments of `mtllib` lines.
    pub libraries: Vec<Named>,
    /// Number of faces of fewer than three corners.
    pub too_small: usize,
}

/// Name that OBJ gives to the group of faces that are in none.
const NO_GROUP: &str = "default";

/// Reason why pieces do not fit together.
#[derive(Debug)]
pub(super) enum Misfit {
    /// A fault whose place has to be looked for in the text.
    Somewhere,
    /// A fault of the file as a whole.
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
    let uses = joined.name(&mut pieces);
    joined.colors = colors(&pieces, &bases, counts[0]);
    joined.positions = concatenated(pieces.iter_mut().map(|piece| std::mem::take(&mut piece.positions)));
    joined.uvs = concatenated(pieces.iter_mut().map(|piece| std::mem::take(&mut piece.uvs)));
    joined.normals = concatenated(pieces.iter_mut().map(|piece| std::mem::take(&mut piece.normals)));
    let runs = pieces.into_par_iter().zip(uses).zip(bases);
    let runs = runs.map(|((piece, uses), base)| run_of(piece.faces, uses, base, counts));
    joined.runs = runs.collect::<Result<_, _>>().map_err(|OutOfRange| Misfit::Somewhere)?;
    Ok(joined)
}

/// Colours of all `count` positions, white where a line says none; none if no line does.
fn colors(pieces: &[Piece], bases: &[[u64; 3]], count: u64) -> Vec<[f16; 3]> {
    if pieces.iter().all(|piece| piece.colors.is_empty()) {
        return Vec::new();
    }
    let mut colors = vec![[f16::ONE; 3]; count as usize];
    for (piece, [base, ..]) in pieces.iter().zip(bases) {
        piece.colors.iter().for_each(|(at, color)| colors[*base as usize + *at as usize] = *color);
    }
    colors
}

/// Counts the `v`, `vt` and `vn` statements before each piece, and those of all pieces.
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

/// Concatenates lists, with room for one more entry (which a vertex buffer needs).
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

impl Joined {
    /// Numbers the materials and groups of the file, and sets the lines of their names. Returns the changes
    /// of use among the faces of each piece.
    fn name(&mut self, pieces: &mut [Piece]) -> Vec<Vec<(u32, Use)>> {
        let named = |name: &str| Named { name: name.to_owned(), line: 0 };
        (self.materials, self.groups) = (vec![named("")], vec![named(NO_GROUP)]);
        let mut material_of = HashMap::from([(Vec::new(), 0)]);
        let mut group_of = HashMap::from([(Vec::new(), 0), (NO_GROUP.into(), 0)]);
        let (mut line, mut current) = (1, Use::default());
        let mut uses = Vec::with_capacity(pieces.len());
        for piece in pieces {
            let materials = numbers(&mut piece.materials, line, &mut self.materials, &mut material_of);
            let groups = numbers(&mut piece.groups, line, &mut self.groups, &mut group_of);
            let mut of_piece = vec![(0, current)];
            for (face, change) in &piece.faces.changes {
                match change {
                    Change::Material(number) => current.material = materials[*number as usize],
                    Change::Group(number) => current.group = groups[*number as usize],
                    Change::Object(number) => {
                        let name = groups[*number as usize];
                        current = Use { group: name, object: name, ..current };
                    }
                }
                of_piece.push((*face, current));
            }
            uses.push(of_piece);
            self.libraries.extend(piece.libraries.iter().map(|(name, ahead)| named_at(name, line + ahead)));
            line += piece.lines;
        }
        uses
    }
}

/// Looks up the file's numbers for the names of a piece that begins with this line; `names` are those of the
/// file so far.
fn numbers(
    of_piece: &mut Vec<Name>,
    line: usize,
    names: &mut Vec<Named>,
    number_of: &mut HashMap<Vec<u8>, u32>,
) -> Vec<u32> {
    let number = |(name, ahead): Name| {
        *number_of.entry(name).or_insert_with_key(|name| {
            names.push(named_at(name, line + ahead));
            names.len() as u32 - 1
        })
    };
    std::mem::take(of_piece).into_iter().map(number).collect()
}

fn named_at(name: &[u8], line: usize) -> Named {
    Named { name: String::from_utf8_lossy(name).into_owned(), line }
}

/// Creates the run of a piece. `[bv, bvt, bvn]`: numbers of entries defined before the piece; `counts`:
/// those of the file.
fn run_of(
    faces: Faces,
    uses: Vec<(u32, Use)>,
    [bv, bvt, bvn]: [u64; 3],
    counts: [u64; 3],
) -> Result<FaceRun, OutOfRange> {
    let Faces { columns: [positions, uvs, normals], corners, count, arities, .. } = faces;
    let mut places = match positions.resolve(bv, counts[0], corners, &[])? {
        Indices::Own(places) => places,
        _ if corners == 0 => Vec::new(),
        _ => return Err(OutOfRange), // not one vertex in the file
    };
    let uvs = uvs.resolve(bvt, counts[1], corners, &places)?;
    let normals = normals.resolve(bvn, counts[2], corners, &places)?;
    places.iter_mut().for_each(|index| *index -= 1);
    Ok(FaceRun { positions: places, uvs, normals, faces: count, arities, uses })
}
