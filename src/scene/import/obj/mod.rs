//! Reads the geometry of OBJ files, on all threads.
//!
//! What it gives is a soup of triangles with the names of their materials and groups; what materials mean is
//! found in `mtl`, and `import::meshes` makes a mesh of both. A file is one model, which moves as one; objects (`o`) and groups
//! (`g`) in it are names for mattes, and the last of either counts.
//!
//! The text is cut into pieces at line ends (`source`), which are read independently (`piece`). Then
//! it is known how much each of them defines, and indices that count back become absolute (`join`).
//! Corners that have all in common become vertices (`weld`), and faces become triangles (`import::faces`).
//! What comes out depends neither on the pieces nor on the threads. Where something is wrong, the text
//! is read once more, in order, to say where (`fault`).

pub(crate) mod cage;
mod column;
mod fault;
mod join;
pub mod lines;
mod number;
#[cfg(test)]
mod oracle;
mod piece;
mod plain;
mod positions;
mod source;
mod statement;
mod weld;

use std::io;
use std::path::Path;

use bytemuck::cast_vec;
use rayon::prelude::*;

use self::lines::{Lines, split_keyword};
use crate::digest::Digest;
use crate::input::{self, Kind};
use crate::memory::{self, Need, Part};
use crate::scene::SceneError;
pub use crate::scene::import::faces::{Named, OddNormals, TriangleSoup, Use};
use crate::scene::import::faces::{are_within_reach, triangulate};
use fault::Fault;
use join::{Joined, Misfit};
use piece::{Piece, Reader};
pub use positions::{line_of_position, read_positions};
use source::Source;
use weld::Vertices;

/// Bytes of a piece: its text and its content fit into a core's cache, and the overhead of ten thousand
/// pieces is small.
const PIECE: u64 = 1 << 18;

/// Reads the OBJ file at `path`.
///
/// # Errors
/// Where the file cannot be read, holds values that make no sense (with their line), or no surface.
pub fn read(path: &Path) -> Result<TriangleSoup, SceneError> {
    read_with_digest(path).map(|(obj, _)| obj)
}

/// Reads the OBJ file like [`read`], with a digest of its text: that of the text as read, even if the file
/// changes meanwhile.
///
/// # Errors As [`read`].
pub fn read_with_digest(path: &Path) -> Result<(TriangleSoup, Digest), SceneError> {
    let source = open(path)?;
    let read = parse(&source, PIECE).map_err(|error| unreadable(path, &error))?;
    read.map_err(|fault| faulty(path, fault))
}

/// Opens the text of the OBJ file at `path`, if there is memory for its content.
fn open(path: &Path) -> Result<Source<'static>, SceneError> {
    let unreadable = |error: io::Error| unreadable(path, &error);
    let input = input::open(path, Kind::Model).map_err(|error| unreadable(error.into()))?;
    // the content takes about as much memory as the text
    let need = Need::new(Part::new("the text of the model", input.length, "a smaller model"));
    need.check(&memory::left()).map_err(|error| SceneError::new(path, error.to_string()))?;
    let source = Source::new(input).map_err(unreadable)?;
    match not_a_model(&source).map_err(unreadable)? {
        Some(what) => Err(SceneError::new(path, what)),
        None => Ok(source),
    }
}

fn unreadable(path: &Path, error: &io::Error) -> SceneError {
    SceneError::new(path, format!("the OBJ file cannot be read: {error}"))
}

fn faulty(path: &Path, fault: Fault) -> SceneError {
    let error = SceneError::new(path, fault.message);
    if fault.line == 0 { error } else { error.at_line(fault.line) }
}

/// Explains a file that is no model although it is named like one.
fn not_a_model(source: &Source<'_>) -> io::Result<Option<&'static str>> {
    /// Bytes of a COFF header, of which some are zero: no text holds zeros.
    const HEADER: u64 = 20;
    /// First bytes of COFF files: for x86-64, x86 and ARM64, and for files of many sections.
    const BEGINNINGS: [&[u8]; 4] = [&[0x64, 0x86], &[0x4C, 0x01], &[0x64, 0xAA], &[0, 0, 0xFF, 0xFF]];
    if source.len() == 0 {
        return Ok(Some("the OBJ file is empty: export the model again"));
    }
    let mut buffer = Vec::new();
    let head = source.read(0..source.len().min(HEADER), &mut buffer)?;
    let is_coff = head.contains(&0) && BEGINNINGS.iter().any(|beginning| head.starts_with(beginning));
    Ok(is_coff.then_some("this is an object file of a compiler (COFF), not a Wavefront model"))
}

/// Reads OBJ text in pieces of `piece` bytes. The digest is of the text in these pieces.
fn parse(source: &Source<'_>, piece: u64) -> io::Result<Result<(TriangleSoup, Digest), Fault>> {
    let (pieces, digest) = pieces(source, piece)?;
    if pieces.iter().any(|piece| piece.is_faulty) {
        return look_for_fault(source).map(Err);
    }
    let count = pieces.iter().map(|piece| piece.odd_normals).sum();
    match whole(pieces) {
        Ok(obj) if count == 0 => Ok(Ok((obj, digest))),
        Ok(obj) => {
            let odd_normals = Some(OddNormals { count, line: line_of_odd_normal(source)? });
            Ok(Ok((TriangleSoup { odd_normals, ..obj }, digest)))
        }
        Err(Misfit::Whole(fault)) => Ok(Err(fault)),
        Err(Misfit::Somewhere) => look_for_fault(source).map(Err),
    }
}

fn pieces(source: &Source<'_>, size: u64) -> io::Result<(Vec<Piece>, Digest)> {
    let ranges = source.pieces(size)?.into_iter().enumerate();
    let read = |(buffer, reader): &mut (Vec<u8>, Reader), (number, range)| {
        let text = source.read(range, buffer)?;
        // while the text is in the core's cache, where this takes a hundredth of the time of reading it
        Ok((number, Digest::new(text), reader.read(text)))
    };
    // each thread takes the next piece: ranges of them, handed out beforehand, would not end at the same time
    let pieces: io::Result<Vec<(usize, Digest, Piece)>> =
        ranges.par_bridge().map_init(Default::default, read).collect();
    let mut pieces = pieces?;
    pieces.sort_unstable_by_key(|(number, _, _)| *number);
    let digest = Digest::of_all(pieces.iter().map(|(_, digest, _)| *digest));
    Ok((pieces.into_iter().map(|(_, _, piece)| piece).collect(), digest))
}

/// Finds the line of the first normal that is not finite, in a text that has one.
fn line_of_odd_normal(source: &Source<'_>) -> io::Result<usize> {
    let mut buffer = Vec::new();
    let text = source.read(0..source.len(), &mut buffer)?;
    let is_odd = |line: &[u8]| {
        let (keyword, rest) = split_keyword(line);
        keyword == b"vn" && statement::three("vn", rest).is_ok_and(|normal| piece::is_odd(&normal))
    };
    Ok(Lines::new(text).find(|(_, line)| is_odd(line)).map_or(0, |(line, _)| line))
}

fn look_for_fault(source: &Source<'_>) -> io::Result<Fault> {
    let mut buffer = Vec::new();
    let text = source.read(0..source.len(), &mut buffer)?;
    Ok(fault::find(text).unwrap_or_else(|| {
        Fault::whole("the OBJ file is damaged, or was changed while it was read: export the model again")
    }))
}

/// Makes the whole file of its pieces.
fn whole(pieces: Vec<Piece>) -> Result<TriangleSoup, Misfit> {
    let mut joined = join::join(pieces)?;
    let places = joined.positions.len();
    let Vertices { positions, sources, uvs, normals } = weld::weld(&mut joined).map_err(Misfit::Whole)?;
    let colors = match (joined.colors.is_empty(), sources.is_empty()) {
        (true, _) => Vec::new(),
        // each position is a vertex of its own
        (false, true) => std::mem::take(&mut joined.colors),
        (false, false) => sources.iter().map(|source| joined.colors[*source as usize]).collect(),
    };
    let Joined { runs, materials, groups, libraries, too_small, .. } = joined;
    let triangles = triangulate::triangulate(runs, &positions);
    if !are_within_reach(&positions) {
        return Err(Misfit::Somewhere);
    }
    if triangles.corners.is_empty() {
        return Err(Misfit::Whole(Fault::whole(nothing_there(triangles.flat + too_small))));
    }
    let (triangles, uses) = (triangles.corners, triangles.uses);
    // the same bytes: nothing is copied
    let (normals, uvs) = (cast_vec(normals), cast_vec(uvs));
    Ok(TriangleSoup {
        positions,
        sources,
        places,
        normals,
        uvs,
        colors,
        triangles,
        uses,
        materials,
        groups,
        libraries,
        odd_normals: None,
    })
}

fn nothing_there(without_area: usize) -> String {
    match without_area {
        0 => String::from("the OBJ file holds no faces: points and lines alone cannot be rendered"),
        n => format!("none of the {n} faces in the OBJ file has an area: check the export's scale and units"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use std::borrow::Cow;

    use glam::{Vec2, Vec3};

    use super::*;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    /// Reads a text in pieces of `piece` bytes.
    fn parsed(text: &[u8], piece: u64) -> Result<TriangleSoup, Fault> {
        parse(&Source::Memory(Cow::Borrowed(text)), piece).unwrap().map(|(obj, _)| obj)
    }

    fn read_text(faces: &str) -> TriangleSoup {
        parsed(format!("{SQUARE}{faces}").as_bytes(), PIECE).unwrap()
    }

    fn fault(text: &str) -> Fault {
        parsed(text.as_bytes(), PIECE).unwrap_err()
    }

    #[test]
    fn reads_quads_with_all_parts() {
        let obj = read_text("vt 0 0\nvt 1 1\nvn 0 0 2\nf 1/1/1 2/2/1 3/2/1 -1/1/-1");
        assert_eq!(obj.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(obj.normals, [Vec3::Z; 4]);
        assert_eq!(obj.uvs, [Vec2::ZERO, Vec2::ONE, Vec2::ONE, Vec2::ZERO]);
    }

    /// In lines as most files spell them, others, and in pieces of any size; one number more is a weight.
    #[test]
    fn colours_stand_behind_positions() {
        let text = "v 0 0 0 1 0 0\nv 1 0 0 0.5\n v 1e0 1 0 0 1 0\nv 0 1 0 0 0 1 0.25\nvt 0 0\nvt 1 1\nf 1 2 3\nf 1 3 4\n";
        for piece in [PIECE, 20] {
            let obj = parsed(text.as_bytes(), piece).unwrap();
            let colors: Vec<_> = obj.colors.iter().map(|color| color.map(f32::from)).collect();
            assert_eq!(colors, [[1.0, 0.0, 0.0], [1.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "{piece}");
        }
        // one vertex is two, with the same colour
        let split =
            parsed(text.replace("f 1 2 3\nf 1 3 4", "f 1/1 2/1 3/1\nf 1/2 3/1 4/1").as_bytes(), PIECE);
        let red = split.unwrap().colors.iter().filter(|[red, ..]| f32::from(*red) == 1.0).count();
        assert_eq!(red, 3);
        assert!(parsed(SQUARE.as_bytes(), PIECE).is_err() && read_text("f 1 2 3 4").colors.is_empty());
    }

    #[test]
    fn vertices_split_where_their_parts_differ() {
        let obj = read_text("vt 0 0\nvt 1 1\nf 1/1 2/1 3/1\nf 1/2 3/1 4/1");
        assert_eq!((obj.positions.len(), obj.uvs.len()), (5, 5));
    }

    #[test]
    fn lists_stay_in_step_where_faces_have_different_parts() {
        let obj = read_text("vn 0 0 1\nf 1 2 3\nf 1//1 3//1 4//1\nf 1 2 4\nf 1//1 2 4");
        assert_eq!(obj.normals.len(), obj.positions.len());
        let normals = obj.triangles.iter().map(|t| obj.normals[t[0] as usize]);
        assert_eq!(normals.collect::<Vec<_>>(), [Vec3::ZERO, Vec3::Z, Vec3::ZERO, Vec3::ZERO]);
        assert!(obj.uvs.is_empty());
    }

    #[test]
    fn materials_are_counted_by_their_first_use() {
        let obj = read_text("f 1 2 3\nusemtl a b\nf 1 2 4\nusemtl\tc\no x\nf 1 3 4\nusemtl a b\nf 2 3 4");
        let names: Vec<_> = obj.materials.iter().map(|named| named.name.as_str()).collect();
        let uses: Vec<_> = obj.uses.iter().map(|(count, of)| (*count, of.material)).collect();
        assert_eq!((names, uses), (vec!["", "a b", "c"], vec![(1, 0), (1, 1), (1, 2), (1, 1)]));
    }

    #[test]
    fn the_last_object_or_group_counts_in_pieces_of_any_size() {
        let text = format!(
            "{SQUARE}f 1 2 3\no chair\nf 1 2 4\ng leg  a\nusemtl x\nf 1 3 4\nf 1 2 3\no table\nf 2 3 4\ng\nf 1 2 4\no chair\nf 1 2 3"
        );
        for piece in [1, 20, PIECE] {
            let obj = parsed(text.as_bytes(), piece).unwrap();
            let names = obj.uses.iter().map(|(_, of)| obj.groups[of.group as usize].name.as_str());
            let counts: Vec<_> = obj.uses.iter().map(|(count, _)| *count).collect();
            assert_eq!(
                names.collect::<Vec<_>>(),
                ["default", "chair", "leg  a", "table", "default", "chair"]
            );
            assert_eq!((counts, obj.groups.len()), (vec![1, 1, 2, 1, 1, 1], 4));
        }
    }

    #[test]
    fn unusable_normals_and_coordinates_become_zero() {
        let obj = read_text("vn nan 0 1\nvt inf 0\nf 1/1/1 2/1/1 3/1/1");
        assert_eq!((obj.normals[0], obj.uvs[0]), (Vec3::ZERO, Vec2::ZERO));
    }

    #[test]
    fn normals_that_microsofts_library_wrote_as_no_numbers_are_told_and_zero() {
        for odd in ["-1.#IND00 -1.#IND00 -1.#IND00", "0 1.#QNAN 1", "1.#INF00 0 0", "nan 0 0", "0 inf 0 # up"]
        {
            let obj = read_text(&format!("vn 0 0 1\nvn {odd}\nvn {odd}\nf 1//1 2//2 3//3"));
            assert_eq!(obj.odd_normals, Some(OddNormals { count: 2, line: 6 }), "{odd}");
            assert_eq!(obj.normals, [Vec3::Z, Vec3::ZERO, Vec3::ZERO], "{odd}");
        }
        assert_eq!(read_text("vn 0 0 0\nf 1//1 2//1 3//1").odd_normals, None);
        let fault = fault("v 0 0 0\nv 1.#INF 0 0\nv 0 1 0\nf 1 2 3");
        assert!(fault.line == 2 && fault.message.contains("`1.#INF`"), "{fault:?}");
    }

    #[test]
    fn what_has_no_area_is_dropped() {
        let obj = read_text("f 1 1 2\nf 1 2 3\nf 2 2 2 2\nf 1 2");
        assert_eq!(obj.triangles.len(), 1);
        let all = fault(&format!("{SQUARE}f 1 1 2\nf 2 2 2 2\nf 1 2"));
        assert!(all.line == 0 && all.message.contains("none of the 3 faces"), "{all:?}");
        assert!(fault(SQUARE).message.contains("no faces"));
    }

    #[test]
    fn faults_name_the_line() {
        for (text, line, words) in [
            ("v 0 0\n", 1, "three numbers, found `v 0 0`"),
            ("v 0 0 0\nv a 0 0\n", 2, "found `v a 0 0`"),
            ("v 0 0 0\nvn 0 \\\n 0\n", 2, "`vn` takes three"),
            ("\nvt\n", 2, "`vt` takes two"),
            ("v 0 0 0\nv 1 0 inf\nv 0 1 0\nf 1 2 3", 2, "`inf`"),
            ("v 0 0 0\nv 1 0 0\nv 0 1e39 0\nf 1 2 3", 3, "`1e39`"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 3\nf 1 2 4", 6, "vertex 4 of 3"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//6148914691236517206 2//1 3//1", 5, "no corner"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//614891469123651720 2//1 3//1", 5, "of 1"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/2 2/1 3/1\no next\nv 0 0 0", 5, "coordinate 2 of 1"),
            ("v 1 2 \u{e4}\n", 1, "three numbers"),
        ] {
            let fault = fault(text);
            assert!(fault.line == line && fault.message.contains(words), "{text}: {fault:?}");
        }
        assert_eq!(parsed(b"v 1 2 \xff\n", PIECE).unwrap_err().line, 1);
    }

    #[test]
    fn stray_vertices_may_be_odd() {
        assert_eq!(read_text("v nan 0 0\nf 1 2 3").triangles.len(), 1);
    }
}
