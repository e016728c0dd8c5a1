//! Reads a piece of an OBJ file without knowing what stands before it.
//!
//! Plain lines, which big files are made of, are read where they stand. Whatever is unusual about a line (a
//! comment, a continuation, a sign) has it read again with care; so here nothing has to be decided twice.

use std::collections::HashMap;

use memchr::memchr;

use super::column::Column;
use super::number::{Cursor, is_blank};
use super::statement::{self, Corner, MOST_CORNERS};
use crate::scene::lines::{Lines, split_keyword, words};

/// A name as bytes, and the line of the piece (from 0) that has it first.
pub(super) type Name = (Vec<u8>, usize);

/// What a piece says.
#[derive(Debug, Default)]
pub(super) struct Piece {
    /// Of `v`.
    pub positions: Vec<[f32; 3]>,
    /// Of `vt`.
    pub uvs: Vec<[f32; 2]>,
    /// Of `vn`, of any length.
    pub normals: Vec<[f32; 3]>,
    /// Of faces of three corners and more.
    pub faces: Faces,
    /// Names after `usemtl`, by their first use.
    pub materials: Vec<Name>,
    /// What `mtllib` lines say.
    pub libraries: Vec<Name>,
    /// Faces of fewer than three corners.
    pub too_small: usize,
    /// Lines of the file.
    pub lines: usize,
    /// Whether a line cannot be read.
    pub is_faulty: bool,
}

/// Faces one after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Faces {
    /// Of position, texture coordinate and normal.
    pub columns: [Column; 3],
    /// In all.
    pub corners: usize,
    /// In all.
    pub count: usize,
    /// Corners of each face; none where all have three.
    pub arities: Vec<u16>,
    /// From which face on which of the piece's materials is used.
    pub uses: Vec<(u32, u32)>,
}

/// Reads pieces, one after the other, into the same memory.
#[derive(Debug, Default)]
pub(super) struct Reader {
    piece: Piece,
    material_of: HashMap<Vec<u8>, u32>,
    /// The face that is being read.
    corners: Vec<Corner>,
}

impl Reader {
    /// What `text` says, which begins with a line and ends with one. Ends early at a fault.
    pub fn read(&mut self, text: &[u8]) -> Piece {
        self.clear();
        let mut cursor = Cursor { text, at: 0 };
        while cursor.at < text.len() && !self.piece.is_faulty {
            let begin = cursor.at;
            if self.plain_line(&mut cursor).is_some() {
                self.piece.lines += 1;
            } else {
                cursor.at = begin;
                self.any_line(&mut cursor);
            }
        }
        self.packed()
    }

    fn clear(&mut self) {
        let Piece { positions, uvs, normals, mut faces, .. } = std::mem::take(&mut self.piece);
        faces.columns.iter_mut().for_each(Column::clear);
        faces.arities.clear();
        self.material_of.clear();
        self.piece = Piece {
            positions: emptied(positions),
            uvs: emptied(uvs),
            normals: emptied(normals),
            faces: Faces { columns: faces.columns, arities: faces.arities, ..Faces::default() },
            ..Piece::default()
        };
    }

    /// The piece, in no more memory than it needs; the reader's own stays for the next.
    fn packed(&mut self) -> Piece {
        let piece = &mut self.piece;
        Piece {
            positions: piece.positions.as_slice().to_vec(),
            uvs: piece.uvs.as_slice().to_vec(),
            normals: piece.normals.as_slice().to_vec(),
            faces: Faces {
                columns: piece.faces.columns.each_ref().map(Column::packed),
                arities: piece.faces.arities.as_slice().to_vec(),
                uses: std::mem::take(&mut piece.faces.uses),
                ..piece.faces
            },
            materials: std::mem::take(&mut piece.materials),
            libraries: std::mem::take(&mut piece.libraries),
            ..*piece
        }
    }

    /// Reads a line of the usual kind; `None`, with nothing done, for any other.
    #[inline(always)]
    fn plain_line(&mut self, cursor: &mut Cursor<'_>) -> Option<()> {
        cursor.skip_blanks();
        match (cursor.peek(0), cursor.peek(1)) {
            (b'v', b' ') => {
                cursor.at += 2;
                let values = plain_numbers(cursor)?;
                self.piece.positions.push(values);
            }
            (b'f', b' ') => {
                cursor.at += 2;
                self.plain_face(cursor)?;
                self.add_face()?;
            }
            (b'v', b'n') if is_blank(cursor.peek(2)) => {
                cursor.at += 3;
                let values = plain_numbers(cursor)?;
                self.piece.normals.push(values);
            }
            (b'v', b't') if is_blank(cursor.peek(2)) => {
                cursor.at += 3;
                let values = plain_numbers(cursor)?;
                self.piece.uvs.push(values);
            }
            (b'\n', _) => cursor.at += 1,
            _ => return None,
        }
        Some(())
    }

    #[inline(always)]
    fn plain_face(&mut self, cursor: &mut Cursor<'_>) -> Option<()> {
        self.corners.clear();
        loop {
            cursor.skip_blanks();
            if cursor.peek(0) == b'\n' {
                cursor.at += 1;
                return Some(());
            }
            self.corners.push(plain_corner(cursor)?);
        }
    }

    /// Adds the face that was read; `None`, with nothing to be kept, where it is out of bounds.
    #[inline(always)]
    fn add_face(&mut self) -> Option<()> {
        let piece = &mut self.piece;
        let defined = [piece.positions.len(), piece.uvs.len(), piece.normals.len()];
        match self.corners.as_slice() {
            [] | [_] | [_, _] => {
                piece.too_small += 1;
                Some(())
            }
            // apart, because the length is known here
            [a, b, c] => piece.faces.add(&[*a, *b, *c], defined),
            corners => piece.faces.add(corners, defined),
        }
    }

    /// Reads any line, and those that continue it.
    #[cold]
    fn any_line(&mut self, cursor: &mut Cursor<'_>) {
        let mut lines = Lines::new(&cursor.text[cursor.at..]);
        if let Some((_, line)) = lines.next() {
            self.piece.is_faulty |= self.statement(&line).is_none();
        }
        self.piece.lines += lines.passed();
        cursor.at = cursor.text.len() - lines.rest().len();
    }

    /// `None` where it makes no sense; why, is found out when all is read.
    fn statement(&mut self, line: &[u8]) -> Option<()> {
        let (keyword, rest) = split_keyword(line);
        let piece = &mut self.piece;
        match keyword {
            b"v" => piece.positions.push(statement::three("v", rest).ok()?),
            b"vt" => piece.uvs.push(statement::texture_coordinate(rest).ok()?),
            b"vn" => piece.normals.push(statement::three("vn", rest).ok()?),
            b"f" => {
                self.corners.clear();
                for word in words(rest) {
                    self.corners.push(statement::corner(word).ok()?);
                }
                self.add_face()?;
            }
            b"usemtl" => self.use_material(rest),
            b"mtllib" => piece.libraries.push((rest.to_vec(), piece.lines)),
            _ => {}
        }
        Some(())
    }

    fn use_material(&mut self, name: &[u8]) {
        let piece = &mut self.piece;
        let number = match self.material_of.get(name) {
            Some(number) => *number,
            None => {
                let number = piece.materials.len() as u32;
                piece.materials.push((name.to_vec(), piece.lines));
                self.material_of.insert(name.to_vec(), number);
                number
            }
        };
        piece.faces.uses.push((piece.faces.count as u32, number));
    }
}

impl Faces {
    #[inline(always)]
    fn add(&mut self, corners: &[Corner], defined: [usize; 3]) -> Option<()> {
        if corners.len() > MOST_CORNERS {
            return None;
        }
        for part in 0..3 {
            // what not all corners have is dropped
            if corners.iter().all(|corner| corner[part] != 0) {
                let indices = corners.iter().map(|corner| corner[part]);
                self.columns[part].append(self.corners, indices, defined[part]).ok()?;
            }
        }
        if corners.len() != 3 && self.arities.is_empty() {
            self.arities.resize(self.count, 3);
        }
        if corners.len() != 3 || !self.arities.is_empty() {
            self.arities.push(corners.len() as u16);
        }
        self.count += 1;
        self.corners += corners.len();
        Some(())
    }
}

fn emptied<T>(mut list: Vec<T>) -> Vec<T> {
    list.clear();
    list
}

/// N numbers and whatever else is in the line.
#[inline(always)]
fn plain_numbers<const N: usize>(cursor: &mut Cursor<'_>) -> Option<[f32; N]> {
    let mut values = [0.0; N];
    for value in &mut values {
        cursor.skip_blanks();
        *value = cursor.number()?;
    }
    cursor.skip_blanks();
    if cursor.peek(0) == b'\n' {
        cursor.at += 1;
        return Some(values);
    }
    let rest = &cursor.text[cursor.at..];
    let rest = &rest[..memchr(b'\n', rest)?];
    cursor.at += rest.len() + 1;
    (rest.trim_ascii_end().last() != Some(&b'\\')).then_some(values)
}

/// A corner of the usual kind: `v`, `v/vt`, `v//vn` or `v/vt/vn`, without signs but minus.
#[inline(always)]
fn plain_corner(cursor: &mut Cursor<'_>) -> Option<Corner> {
    let mut corner = [cursor.index()?, 0, 0];
    if cursor.peek(0) == b'/' {
        cursor.at += 1;
        if cursor.peek(0) != b'/' {
            corner[1] = cursor.index()?;
        }
        if cursor.peek(0) == b'/' {
            cursor.at += 1;
            corner[2] = cursor.index()?;
        }
    }
    let next = cursor.peek(0);
    (next == b'\n' || is_blank(next)).then_some(corner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Piece {
        Reader::default().read(text.as_bytes())
    }

    fn resolved(piece: &Piece) -> [Vec<u32>; 3] {
        piece
            .faces
            .columns
            .each_ref()
            .map(|c| c.packed().resolve(0, 99, piece.faces.corners).unwrap_or_default())
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
        let [v, vt, vn] = resolved(&read("f 1/1/1 2/2/2 3//3\nf 1/4 2 3\nf 4 5 6\n"));
        assert_eq!((v.len(), vt.len()), (9, 0));
        assert_eq!(vn, [1, 2, 3, 0, 0, 0, 0, 0, 0]);
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
        assert_eq!(piece.faces.uses, [(0, 0), (1, 1), (1, 0)]);
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
