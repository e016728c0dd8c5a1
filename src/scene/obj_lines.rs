//! OBJ text as tobj understands it: the lines between the file and the parser.
//!
//! tobj reads numbers and shares vertices; this reader, through which it sees the file, keeps from it
//! what it reads otherwise than OBJ means it:
//! - continued lines, tabs, comments after values, vertex colours and weights, points and lines;
//! - negative indices (made absolute) and indices that make no sense (a fault with its line);
//! - faces of which only some corners have a normal or a texture coordinate (tobj would shift the lists
//!   against each other): what not all corners have is dropped, and faces with other parts than those
//!   before start a group;
//! - `usemtl` and `mtllib`: kept here, so that their order does not matter. Each change of material
//!   starts a group whose name is the material's number.

use std::collections::HashMap;
use std::io::{self, BufRead, Read, Write};
use std::str;

use super::lines::{Lines, split_keyword, words};

/// Coordinates beyond this are refused: Embree passes over such triangles without a word.
pub(crate) const LARGEST_COORDINATE: f32 = 1e18;

/// Most corners of one face: cutting up a tangled one takes time with the square of their number.
const MOST_CORNERS: usize = 20_000;

/// How many `v`, `vt`, `vn` there are.
pub(crate) type Counts = [u64; 3];

/// Which of position, texture coordinate and normal the corners of a face have.
type Parts = [bool; 3];

/// Something wrong in the text.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fault {
    /// From 1.
    pub line: usize,
    /// What, and what to do.
    pub message: String,
}

/// A name in the text and the first line that has it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Named {
    /// Trimmed; may hold spaces.
    pub name: String,
    /// From 1.
    pub line: usize,
}

/// The cleaned lines of an OBJ file, one at a time.
pub(crate) struct ObjLines<'a> {
    lines: Lines<'a>,
    /// Number of the line that `out` was made of.
    line: usize,
    out: Vec<u8>,
    taken: usize,
    corners: Vec<[u64; 3]>,
    counts: Counts,
    /// For the second look at a file that is known to be wrong.
    checked_against: Option<Counts>,
    group: Option<(usize, Parts)>,
    material: usize,
    material_of: HashMap<Vec<u8>, usize>,
    /// Group names are indices into this list; 0 is "no material".
    pub materials: Vec<Named>,
    /// What `mtllib` lines say.
    pub libraries: Vec<Named>,
    /// Faces of fewer than three corners.
    pub too_small: usize,
    /// Why reading ended early.
    pub fault: Option<Fault>,
}

impl<'a> ObjLines<'a> {
    /// Reads `text` from its beginning.
    pub fn new(text: &'a [u8]) -> Self {
        Self {
            lines: Lines::new(text),
            line: 0,
            out: Vec::new(),
            taken: 0,
            corners: Vec::new(),
            counts: [0; 3],
            checked_against: None,
            group: None,
            material: 0,
            material_of: HashMap::new(),
            materials: vec![Named { name: String::new(), line: 0 }],
            libraries: Vec::new(),
            too_small: 0,
            fault: None,
        }
    }

    /// Looks for the line at which `text` is wrong: a coordinate that cannot be used, or an index
    /// beyond the `counts` that a first pass has found.
    pub fn find_fault(text: &'a [u8], counts: Counts) -> Option<Fault> {
        let mut lines = Self { checked_against: Some(counts), ..Self::new(text) };
        while lines.advance().is_some() {}
        lines.fault
    }

    /// What the lines so far have defined.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// A fault at the line that was handed out last, showing its text.
    pub fn fault_here(&self, message: &str) -> Fault {
        let shown: String = String::from_utf8_lossy(&self.out).trim().chars().take(60).collect();
        Fault { line: self.line, message: format!("{message}, found `{shown}`") }
    }

    /// Puts the next line that tobj has to see into `out`. `None` at the end and at a fault.
    fn advance(&mut self) -> Option<()> {
        self.out.clear();
        self.taken = 0;
        while self.out.is_empty() {
            let (number, line) = self.lines.next()?;
            self.line = number;
            if let Err(message) = self.take(&line) {
                self.fault = Some(Fault { line: number, message });
                self.out.clear();
                return None;
            }
        }
        Some(())
    }

    /// Deals with one line of the file.
    fn take(&mut self, line: &[u8]) -> Result<(), String> {
        let (keyword, rest) = split_keyword(line);
        match keyword {
            b"v" => {
                self.counts[0] += 1;
                // beyond the third there are weights of curves, or colours
                copy_words(b"v", rest, 3, &mut self.out);
                if self.checked_against.is_some() {
                    check_coordinates(rest)?;
                }
            }
            b"vt" => {
                self.counts[1] += 1;
                if copy_words(b"vt", rest, 2, &mut self.out) == 1 {
                    self.out.truncate(self.out.len() - 1);
                    self.out.extend_from_slice(b" 0\n");
                }
            }
            b"vn" => {
                self.counts[2] += 1;
                copy_words(b"vn", rest, 3, &mut self.out);
            }
            b"f" => self.face(rest)?,
            b"usemtl" => self.material = self.number_of(rest),
            b"mtllib" => {
                let name = String::from_utf8_lossy(rest).into_owned();
                self.libraries.push(Named { name, line: self.line });
            }
            _ => {}
        }
        Ok(())
    }

    fn number_of(&mut self, name: &[u8]) -> usize {
        if let Some(number) = self.material_of.get(name) {
            return *number;
        }
        let number = if name.is_empty() { 0 } else { self.materials.len() };
        if number != 0 {
            self.materials.push(Named { name: String::from_utf8_lossy(name).into_owned(), line: self.line });
        }
        self.material_of.insert(name.to_vec(), number);
        number
    }

    fn face(&mut self, rest: &[u8]) -> Result<(), String> {
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        for word in words(rest) {
            corners.push(self.corner(word)?);
        }
        if corners.len() > MOST_CORNERS {
            return Err(format!(
                "a face of {} corners: at most {MOST_CORNERS} are read, split it in the modeller",
                corners.len()
            ));
        }
        if corners.len() < 3 {
            self.too_small += 1;
        } else {
            self.write_face(&corners);
        }
        self.corners = corners;
        Ok(())
    }

    /// Indices from 1 of `v/vt/vn`, 0 for what is absent.
    fn corner(&self, word: &[u8]) -> Result<[u64; 3], String> {
        let shown = || String::from_utf8_lossy(&word[..word.len().min(40)]).into_owned();
        let mut indices = [0; 3];
        for (part, digits) in word.split(|byte| *byte == b'/').enumerate() {
            let index = integer(digits).filter(|_| part < 3).ok_or_else(|| {
                format!("`{}` is no corner of a face: write v, v/vt, v//vn or v/vt/vn", shown())
            })?;
            let what = ["vertex", "texture coordinate", "normal"][part];
            let before = self.counts[part];
            // a negative index counts back from the last one defined so far
            let index = if index >= 0 { index } else { before as i64 + 1 + index };
            if index < 0 || (index == 0 && digits.starts_with(b"-")) {
                return Err(format!(
                    "`{}` counts back beyond the first {what}: {before} are defined here",
                    shown()
                ));
            }
            let count = self.checked_against.map(|counts| counts[part]);
            if count.is_some_and(|count| index as u64 > count && (part == 0 || count > 0)) {
                return Err(format!(
                    "`{}` asks for {what} {index} of {}: the file is cut off or its indices are wrong",
                    shown(),
                    count.unwrap_or_default()
                ));
            }
            indices[part] = index as u64;
        }
        if indices[0] == 0 {
            return Err(format!("`{}` names no vertex: indices count from 1", shown()));
        }
        Ok(indices)
    }

    fn write_face(&mut self, corners: &[[u64; 3]]) {
        let parts = [0, 1, 2].map(|part| corners.iter().all(|corner| corner[part] != 0));
        let group = (self.material, parts);
        if self.group != Some(group) {
            self.group = Some(group);
            let _ = writeln!(self.out, "g {}", self.material); // a vector takes all that is written
        }
        self.out.push(b'f');
        for corner in corners {
            for (part, separator) in [b' ', b'/', b'/'].into_iter().enumerate() {
                if part == 0 || parts[part] || (part == 1 && parts[2]) {
                    self.out.push(separator);
                }
                if parts[part] {
                    push_digits(&mut self.out, corner[part]);
                }
            }
        }
        self.out.push(b'\n');
    }
}

/// Copies at most `most` words behind `keyword`, ends the line, and says how many there were.
fn copy_words(keyword: &[u8], rest: &[u8], most: usize, out: &mut Vec<u8>) -> usize {
    out.extend_from_slice(keyword);
    let mut count = 0;
    for word in words(rest).take(most) {
        out.push(b' ');
        out.extend_from_slice(word);
        count += 1;
    }
    out.push(b'\n');
    count
}

fn check_coordinates(rest: &[u8]) -> Result<(), String> {
    for word in words(rest).take(3) {
        let value: Option<f32> = str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        if value.is_none_or(|value| value.is_nan() || value.abs() > LARGEST_COORDINATE) {
            let word = String::from_utf8_lossy(word);
            return Err(format!(
                "a vertex coordinate is `{word}`: it must be a finite number within ±{LARGEST_COORDINATE:e}; \
                 export the model again"
            ));
        }
    }
    Ok(())
}

/// The value of an index; 0 for nothing. What no file of this size can mean is no index.
fn integer(digits: &[u8]) -> Option<i64> {
    let (negative, digits) = match digits {
        [] => return Some(0),
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() || digits.len() > 18 || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let value = digits.iter().fold(0, |value, digit| value * 10 + i64::from(digit - b'0'));
    Some(if negative { -value } else { value })
}

fn push_digits(out: &mut Vec<u8>, mut value: u64) {
    let mut digits = [0; 20];
    let mut at = digits.len();
    loop {
        at -= 1;
        digits[at] = b'0' + (value % 10) as u8;
        value /= 10;
        if value == 0 {
            break;
        }
    }
    out.extend_from_slice(&digits[at..]);
}

impl BufRead for ObjLines<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.taken >= self.out.len() && self.advance().is_none() && self.fault.is_some() {
            // ends the parse; the fault itself is taken from the field
            return Err(io::ErrorKind::InvalidData.into());
        }
        Ok(&self.out[self.taken..])
    }

    fn consume(&mut self, amount: usize) {
        self.taken += amount;
    }
}

impl Read for ObjLines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let amount = self.fill_buf()?.read(buffer)?;
        self.consume(amount);
        Ok(amount)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    fn cleaned(text: &str) -> String {
        let mut out = String::new();
        ObjLines::new(text.as_bytes()).read_to_string(&mut out).unwrap();
        out
    }

    fn fault(text: &str) -> Fault {
        let mut lines = ObjLines::new(text.as_bytes());
        lines.read_to_string(&mut String::new()).unwrap_err();
        lines.fault.unwrap()
    }

    #[test]
    fn keeps_only_what_the_parser_should_see() {
        let text = "# c\no thing\nv\t1 2 3 0.5 0.5 0.5\nvt 0.5\nvn 0 0 1 #up\nl 1 1 1 1\np 1\ns off\n";
        assert_eq!(cleaned(text), "v 1 2 3\nvt 0.5 0\nvn 0 0 1\n");
    }

    #[test]
    fn makes_indices_absolute() {
        assert_eq!(
            cleaned("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1"),
            "v 0 0 0\nv 1 0 0\nv 0 1 0\ng 0\nf 1 2 3\n"
        );
    }

    #[test]
    fn starts_a_group_where_material_or_parts_change() {
        let text = "usemtl a b\nf 1 2 3\nusemtl c\nusemtl a b\nf 3 2 1\nf 1//1 2//1 3//1\nf 1/1/1 2/2/1 3//1\nusemtl c\nf 1 2 3";
        let expected = "g 1\nf 1 2 3\nf 3 2 1\ng 1\nf 1//1 2//1 3//1\nf 1//1 2//1 3//1\ng 2\nf 1 2 3\n";
        assert_eq!(cleaned(text), expected);
    }

    #[test]
    fn faults_name_the_line() {
        assert_eq!(fault("v 0 0 0\n\nf 1 2 x").line, 3);
        assert!(fault("f 0 1 2").message.contains("count from 1"));
        assert!(fault("v 0 0 0\nf -2 -1 -1").message.contains("counts back"));
        for bad in ["f 1/2/3/4 1 1", "f 99999999999999999999 1 1", "f 1.5 1 1", "f - 1 1"] {
            assert!(fault(bad).message.contains("no corner"), "{bad}");
        }
    }

    #[test]
    fn the_second_look_finds_what_the_first_could_not_see() {
        let text = b"v 0 0 0\nv 0 nan 0\nf 1 2 9";
        assert!(ObjLines::find_fault(text, [2, 0, 0]).unwrap().message.contains("`nan`"));
        let text = b"v 0 0 0\nv 0 1 0\nf 1 2 9";
        let fault = ObjLines::find_fault(text, [2, 0, 0]).unwrap();
        assert_eq!((fault.line, fault.message.contains("vertex 9 of 2")), (3, true), "{fault:?}");
        assert_eq!(ObjLines::find_fault(b"v 0 0 0\nf 1/7 1/7 1/7", [1, 0, 0]), None);
    }
}
