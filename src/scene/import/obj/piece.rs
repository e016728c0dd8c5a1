//! Reads a piece of an OBJ file without knowing what stands before it.
//!
//! Lines are read in one of three ways. Those of which big files are made, `v`, `vt`, `vn` and `f` with one blank between
//! words and numbers that are neither long nor have an exponent, are read where they stand (`plain`). Others of these
//! four are read word by word (`number`): longer numbers, more corners, indices that count back. Whatever else there
//! is about a line (a comment, a continuation, a sign that OBJ does not need) has it read again with care, so that
//! nothing has to be decided twice (`statement`).

use std::collections::HashMap;

use glam::Vec3;
use half::f16;
use memchr::memchr;

use super::column::Column;
use super::lines::{Lines, split_keyword, words};
use super::number::{Cursor, is_blank};
use super::plain::{self, Face};
use super::statement;
use crate::scene::import::faces::run::MOST_CORNERS;

/// Indices of position, texture coordinate and normal: from 1, negative ones count back, 0 is absent.
type Corner = [i32; 3];

/// A name as bytes, and the line of the piece (from 0) that has it first.
pub(super) type Name = (Vec<u8>, usize);

/// Change of material, group or object between two faces, by the number of the name among the piece's names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Change {
    /// `usemtl`.
    Material(u32),
    /// `g`.
    Group(u32),
    /// `o`.
    Object(u32),
}

/// Content of a piece.
#[derive(Debug, Default)]
pub(super) struct Piece {
    /// Positions (`v`).
    pub positions: Vec<[f32; 3]>,
    /// Colours behind positions, with the numbers of these in the piece.
    pub colors: Vec<(u32, [f16; 3])>,
    /// Texture coordinates (`vt`); finite.
    pub uvs: Vec<[f32; 2]>,
    /// Normals (`vn`); of unit length, or zero.
    pub normals: Vec<[f32; 3]>,
    /// Faces of three corners and more.
    pub faces: Faces,
    /// Names after `usemtl`, by their first use.
    pub materials: Vec<Name>,
    /// Names after `g` and `o`, by their first use.
    pub groups: Vec<Name>,
    /// Arguments of `mtllib` lines.
    pub libraries: Vec<Name>,
    /// Number of faces of fewer than three corners.
    pub too_small: usize,
    /// Number of normals (`vn`) that are not finite numbers.
    pub odd_normals: usize,
    /// Number of lines in the piece.
    pub lines: usize,
    /// True if a line cannot be read.
    pub is_faulty: bool,
}

/// Faces one after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Faces {
    /// Indices of positions, texture coordinates and normals; only the first is filled as long as all agree.
    pub columns: [Column; 3],
    /// True if some corner's indices differ or count back, or a face has more than four corners.
    is_mixed: bool,
    /// Number of corners of all faces.
    pub corners: usize,
    /// Number of faces.
    pub count: usize,
    /// Number of corners of each face; empty if all have three.
    pub arities: Vec<u16>,
    /// Changes of material, group and object, with the first face behind each, in order.
    pub changes: Vec<(u32, Change)>,
}

/// Reads pieces, one after the other, into the same memory.
#[derive(Debug, Default)]
pub(super) struct Reader {
    /// Content of the piece at work. Texture coordinates and normals are as written here.
    piece: Piece,
    material_of: HashMap<Vec<u8>, u32>,
    group_of: HashMap<Vec<u8>, u32>,
    /// Corners of the face at work.
    corners: Vec<Corner>,
}

impl Reader {
    /// Reads `text`, which begins with a line and ends with one. Stops early at a fault.
    pub fn read(&mut self, text: &[u8]) -> Piece {
        self.clear();
        let mut cursor = Cursor { rest: text };
        while !cursor.rest.is_empty() && !self.piece.is_faulty {
            let line = cursor.rest;
            if self.plain_line(&mut cursor).or_else(|| self.usual_line(&mut cursor)).is_some() {
                self.piece.lines += 1;
            } else {
                cursor.rest = self.any_line(line);
            }
        }
        self.packed()
    }

    fn clear(&mut self) {
        let Piece { positions, uvs, normals, mut faces, .. } = std::mem::take(&mut self.piece);
        faces.columns.iter_mut().for_each(Column::clear);
        faces.arities.clear();
        self.material_of.clear();
        self.group_of.clear();
        self.piece = Piece {
            positions: emptied(positions),
            uvs: emptied(uvs),
            normals: emptied(normals),
            faces: Faces { columns: faces.columns, arities: faces.arities, ..Faces::default() },
            ..Piece::default()
        };
    }

    /// Returns the piece, in no more memory than it needs; the reader keeps its own for the next.
    fn packed(&mut self) -> Piece {
        let piece = &mut self.piece;
        Piece {
            positions: piece.positions.as_slice().to_vec(),
            colors: std::mem::take(&mut piece.colors),
            uvs: piece.uvs.iter().map(usable_uv).collect(),
            normals: piece.normals.iter().map(usable_normal).collect(),
            odd_normals: piece.normals.iter().filter(|normal| is_odd(normal)).count(),
            faces: Faces {
                columns: piece.faces.packed_columns(),
                arities: piece.faces.arities.as_slice().to_vec(),
                changes: std::mem::take(&mut piece.faces.changes),
                ..piece.faces
            },
            materials: std::mem::take(&mut piece.materials),
            groups: std::mem::take(&mut piece.groups),
            libraries: std::mem::take(&mut piece.libraries),
            ..*piece
        }
    }

    /// Reads a line by `plain`; `None`, with nothing kept, if that refuses it.
    #[inline(always)]
    fn plain_line(&mut self, cursor: &mut Cursor<'_>) -> Option<()> {
        let window = cursor.rest.first_chunk()?;
        let (keyword, count) = match window[..3] {
            [b'v', b' ', _] => (2, 3),
            [b'v', b'n', b' '] => (3, 3),
            [b'v', b't', b' '] => (3, 2),
            [b'f', b' ', _] => {
                let length = self.plain_face(window)?;
                return cursor.skip(length);
            }
            _ => return None,
        };
        let (values, end) = plain::numbers(window, keyword, count)?;
        let (length, has_more) = match plain::line_end(window, end) {
            Some(length) => (length, false),
            None if is_blank(window[end]) => (end + behind_more(&cursor.rest[end..])?, true),
            None => return None,
        };
        match window[1] {
            b'n' => self.piece.normals.push(values),
            b't' => self.piece.uvs.push([values[0], values[1]]),
            _ => {
                self.piece.positions.push(values);
                if has_more {
                    self.note_color(&cursor.rest[end..length]);
                }
            }
        }
        cursor.skip(length)
    }

    /// Keeps the colour of the last position, if what is written `behind` it is one: three numbers from 0 to 1, as screens show
    /// them. One number is a weight.
    #[inline(never)]
    fn note_color(&mut self, behind: &[u8]) {
        if let Some(color) = statement::color_behind(behind) {
            self.piece.colors.push(((self.piece.positions.len() - 1) as u32, color));
        }
    }

    /// Reads a face. Returns the length of the line.
    #[inline(always)]
    fn plain_face(&mut self, window: &[u8; plain::WINDOW]) -> Option<usize> {
        let (face, length) = plain::face(window)?;
        let defined = self.defined();
        match face {
            Face::Triangle(corners) => self.piece.faces.add(corners, defined),
            Face::Quad(corners) => self.piece.faces.add(corners, defined),
        }
        Some(length)
    }

    /// Reads a line word by word; `None`, with nothing kept, for any that is no plain `v`, `vt`, `vn` or `f`.
    #[inline(never)]
    fn usual_line(&mut self, cursor: &mut Cursor<'_>) -> Option<()> {
        cursor.skip_blanks();
        match *cursor.rest {
            [b'v', b' ', ..] => {
                let line = cursor.rest;
                self.piece.positions.push(usual_numbers(cursor, 2)?);
                self.note_color(behind_numbers(&line[2..line.len() - cursor.rest.len()], 3));
            }
            [b'f', b' ', ..] => self.usual_face(cursor)?,
            [b'v', b'n', b' ', ..] => self.piece.normals.push(usual_numbers(cursor, 3)?),
            [b'v', b't', b' ', ..] => self.piece.uvs.push(usual_numbers(cursor, 3)?),
            [b'\n', ..] => cursor.skip(1)?,
            _ => return None,
        }
        Some(())
    }

    fn usual_face(&mut self, cursor: &mut Cursor<'_>) -> Option<()> {
        self.corners.clear();
        cursor.skip(2)?;
        loop {
            cursor.skip_blanks();
            if cursor.peek() == b'\n' {
                cursor.skip(1)?;
                break;
            }
            let (corner, end) = cursor.indices()?;
            self.corners.push(corner);
            if end == b'\n' {
                break;
            }
            if end != b' ' && !is_blank(end) {
                return None;
            }
        }
        self.add_face()
    }

    /// Adds the face at work; `None` if it has too many corners.
    #[inline(always)]
    fn add_face(&mut self) -> Option<()> {
        let defined = self.defined();
        let piece = &mut self.piece;
        match *self.corners.as_slice() {
            [] | [_] | [_, _] => piece.too_small += 1,
            // apart, because their length is known where they are added
            [a, b, c] => piece.faces.add([a, b, c], defined),
            [a, b, c, d] => piece.faces.add([a, b, c, d], defined),
            ref corners if corners.len() > MOST_CORNERS => return None,
            ref corners => piece.faces.add_polygon(corners, defined),
        }
        Some(())
    }

    /// Numbers of `v`, `vt` and `vn` statements so far.
    #[inline(always)]
    fn defined(&self) -> [usize; 3] {
        [self.piece.positions.len(), self.piece.uvs.len(), self.piece.normals.len()]
    }

    /// Reads any line at the beginning of `text`, and those that continue it. Returns the rest.
    #[cold]
    fn any_line<'a>(&mut self, text: &'a [u8]) -> &'a [u8] {
        let mut lines = Lines::new(text);
        if let Some((_, line)) = lines.next() {
            self.piece.is_faulty |= self.statement(&line).is_none();
        }
        self.piece.lines += lines.passed();
        lines.rest()
    }

    /// Reads a statement. `None` if it makes no sense; the reason is found later, in order.
    fn statement(&mut self, line: &[u8]) -> Option<()> {
        let (keyword, rest) = split_keyword(line);
        let piece = &mut self.piece;
        match keyword {
            b"v" => {
                piece.positions.push(statement::three("v", rest).ok()?);
                self.note_color(behind_numbers(rest, 3));
            }
            b"vt" => piece.uvs.push(statement::texture_coordinate(rest).ok()?),
            b"vn" => piece.normals.push(statement::three("vn", rest).ok()?),
            b"f" => {
                self.corners.clear();
                for word in words(rest) {
                    let [v, vt, vn] = statement::corner(word).ok()?.map(i32::try_from);
                    self.corners.push([v.ok()?, vt.ok()?, vn.ok()?]);
                }
                self.add_face()?;
            }
            b"usemtl" => {
                let number = number_of(rest, piece.lines, &mut piece.materials, &mut self.material_of);
                piece.faces.changes.push((piece.faces.count as u32, Change::Material(number)));
            }
            b"g" | b"o" => {
                let number = number_of(rest, piece.lines, &mut piece.groups, &mut self.group_of);
                let change = if keyword == b"o" { Change::Object(number) } else { Change::Group(number) };
                piece.faces.changes.push((piece.faces.count as u32, change));
            }
            b"mtllib" => piece.libraries.push((rest.to_vec(), piece.lines)),
            _ => {}
        }
        Some(())
    }
}

/// Number of `name` among `names`. A new name is added.
fn number_of(name: &[u8], line: usize, names: &mut Vec<Name>, numbers: &mut HashMap<Vec<u8>, u32>) -> u32 {
    if let Some(number) = numbers.get(name) {
        return *number;
    }
    let number = names.len() as u32;
    names.push((name.to_vec(), line));
    numbers.insert(name.to_vec(), number);
    number
}

impl Faces {
    #[inline(always)]
    fn add<const N: usize>(&mut self, corners: [Corner; N], defined: [usize; 3]) {
        if !self.is_mixed && corners.iter().all(|[v, vt, vn]| *v > 0 && vt == v && vn == v) {
            self.columns[0].append(self.corners, corners.map(|[v, ..]| v), defined[0]);
        } else {
            self.add_mixed(corners, defined);
        }
        self.count(N);
    }

    #[inline(always)]
    fn add_mixed<const N: usize>(&mut self, corners: [Corner; N], defined: [usize; 3]) {
        self.mix();
        for part in 0..3 {
            let indices = corners.map(|corner| corner[part]);
            // what not all corners have is dropped
            if !indices.contains(&0) {
                self.columns[part].append(self.corners, indices, defined[part]);
            }
        }
    }

    /// Fills each column from now on.
    fn mix(&mut self) {
        if !self.is_mixed {
            let [positions, others @ ..] = &mut self.columns;
            others.iter_mut().for_each(|column| column.copy(positions));
            self.is_mixed = true;
        }
    }

    /// Copies the columns without spare memory.
    fn packed_columns(&self) -> [Column; 3] {
        let [positions, uvs, normals] = &self.columns;
        if self.is_mixed {
            [positions.packed(None), uvs.packed(Some(positions)), normals.packed(Some(positions))]
        } else if self.corners > 0 {
            [positions.packed(None), positions.as_positions(), positions.as_positions()]
        } else {
            Default::default()
        }
    }

    fn add_polygon(&mut self, corners: &[Corner], defined: [usize; 3]) {
        self.mix();
        for part in 0..3 {
            if corners.iter().all(|corner| corner[part] != 0) {
                for (number, corner) in (self.corners..).zip(corners) {
                    self.columns[part].append(number, [corner[part]], defined[part]);
                }
            }
        }
        self.count(corners.len());
    }

    #[inline(always)]
    fn count(&mut self, arity: usize) {
        if arity != 3 && self.arities.is_empty() {
            self.arities.resize(self.count, 3);
        }
        if arity != 3 || !self.arities.is_empty() {
            self.arities.push(arity as u16); // see `MOST_CORNERS`
        }
        self.count += 1;
        self.corners += arity;
    }
}

fn usable_uv(uv: &[f32; 2]) -> [f32; 2] {
    if uv.iter().all(|x| x.is_finite()) { *uv } else { [0.0; 2] }
}

/// Returns true if a normal is not finite.
pub(super) fn is_odd(normal: &[f32; 3]) -> bool {
    !normal.iter().all(|x| x.is_finite())
}

fn usable_normal(normal: &[f32; 3]) -> [f32; 3] {
    Vec3::from(*normal).normalize_or_zero().into()
}

fn emptied<T>(mut list: Vec<T>) -> Vec<T> {
    list.clear();
    list
}

/// Reads N numbers behind a keyword of `keyword` bytes with its blank, and ignores the rest of the line.
fn usual_numbers<const N: usize>(cursor: &mut Cursor<'_>, keyword: usize) -> Option<[f32; N]> {
    cursor.skip(keyword)?;
    let (mut values, mut end) = ([0.0; N], b' ');
    for value in &mut values {
        if end == b'\n' {
            return None;
        }
        cursor.skip_blanks();
        (*value, end) = cursor.number()?;
    }
    if end != b'\n' {
        let length = behind_more(cursor.rest)?;
        cursor.skip(length)?;
    }
    Some(values)
}

/// Rest of a line behind so many words.
fn behind_numbers(line: &[u8], count: usize) -> &[u8] {
    let mut rest = line;
    for _ in 0..count {
        rest = rest.trim_ascii_start();
        rest = &rest[rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len())..];
    }
    rest
}

/// Length of the rest of a line, in which nothing counts any more. `None` if it is continued.
#[inline(never)]
fn behind_more(rest: &[u8]) -> Option<usize> {
    let length = memchr(b'\n', rest)?;
    let is_continued = rest[..length].trim_ascii_end().last() == Some(&b'\\');
    (!is_continued).then_some(length + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::import::faces::run::Indices;

    fn read(text: &str) -> Piece {
        Reader::default().read(text.as_bytes())
    }

    fn resolved(piece: &Piece) -> [Indices; 3] {
        let corners = piece.faces.corners;
        piece
            .faces
            .columns
            .each_ref()
            .map(|column| column.packed(None).resolve(0, 99, corners, &[]).unwrap_or_default())
    }

    #[test]
    fn lines_of_any_spelling_give_the_same() {
        let plain = read("v 1 2 3\nvt 1 0\nvn 0 0 1\nv 4 5 6\nv 7 8 9\nf 1/1/1 2/1/1 3/1/1\n");
        for odd in [
            "v 1 2 3 0.5 0.5 0.5\nvt 1\nvn 0 0 1 #up\nv +4 5. 6e0\nv 7 8 9 1\nf 1/1/1 2/1/1 3/1/1",
            " v\t1  2 3\r\nvt  1 0.0 \r\nvn 0 \\\r\n 0 1\r\n\r\nv 4 5 6\nv 7 8 9\n\tf -3/-1/-1 2/1/1 \\\n3/1/1",
            "#c\nv 1 2 3#c\nvt 1 0 0\nvn 0 0 1\nv 4 5 6\nv 7 8 9\nl 1 2\ng a b\nf 1/1/1 2/1/1 3/1/1#",
        ] {
            let odd = read(odd);
            assert!(!odd.is_faulty);
            assert_eq!(
                (&odd.positions, &odd.uvs, &odd.normals),
                (&plain.positions, &plain.uvs, &plain.normals)
            );
            assert_eq!(resolved(&odd), resolved(&plain));
        }
    }

    #[test]
    fn what_not_all_corners_have_is_dropped() {
        let [v, vt, vn] = resolved(&read("f 2/1/1 1/2/2 3//3\nf 1/4 2 3\nf 4 5 6\n"));
        assert_eq!(v, Indices::Own(vec![2, 1, 3, 1, 2, 3, 4, 5, 6]));
        assert_eq!(vt, Indices::Absent);
        assert_eq!(vn, Indices::Own(vec![1, 2, 3, 0, 0, 0, 0, 0, 0]));
    }

    #[test]
    fn arities_are_kept_where_they_differ() {
        assert!(read("f 1 2 3\nf 1 2 3\n").faces.arities.is_empty());
        let mixed = read("f 1 2 3\nf 1 2\nf 1 2 3 4\nf 1 2 3\n");
        assert_eq!((mixed.faces.arities, mixed.too_small, mixed.faces.corners), (vec![3, 4, 3], 1, 10));
    }

    #[test]
    fn materials_are_named_once_and_lines_are_counted() {
        let piece = read("\nusemtl a b\nf 1 2 3\nusemtl\tc\\\n\nusemtl a b\nmtllib x y.mtl\nf 1 2 3");
        assert_eq!(piece.materials, [(b"a b".to_vec(), 1), (b"c".to_vec(), 3)]);
        let used = [(0, 0), (1, 1), (1, 0)].map(|(face, number)| (face, Change::Material(number)));
        assert_eq!(piece.faces.changes, used);
        assert_eq!((piece.libraries, piece.lines), (vec![(b"x y.mtl".to_vec(), 6)], 8));
    }

    #[test]
    fn nothing_is_left_of_the_piece_before() {
        let mut reader = Reader::default();
        reader.read(b"v 1 2 3\nusemtl a\nf 1 2 3 -1\nx\nf x");
        let next = reader.read(b"f 1 2 3\nusemtl b");
        assert_eq!((next.positions.len(), next.faces.count, next.lines, next.is_faulty), (0, 1, 2, false));
        assert!(next.faces.arities.is_empty() && next.materials.len() == 1);
    }

    #[test]
    fn faults_are_seen() {
        for bad in ["v 1 2", "v 1 2 x", "vt", "vn 1 2 \u{e4}", "f 1 2 x", "f 0 1 2", "f 1 2 -99999999999"] {
            assert!(read(bad).is_faulty && read(&format!("{bad}\n# a line behind it\n")).is_faulty, "{bad}");
        }
    }
}
