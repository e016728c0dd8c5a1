//! Headers of PLY files: elements and their properties.

use std::io::{BufRead, Read};

use super::fault::Fault;
use super::values::{Scalar, Values};
use crate::scene::import::faces::Named;

/// Longest line of a header, bytes, and the largest number of lines.
const LONGEST_LINE: u64 = 4096;
const MOST_LINES: usize = 10_000;

/// Property of an element.
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    pub name: String,
    /// Type of its value, or of each value of a list.
    pub kind: Scalar,
    /// Type of a list's length; none if it is one value.
    pub count: Option<Scalar>,
}

/// Meaning of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Vertex,
    Face,
    Strip,
    Other,
}

/// Element: a table with a row for each vertex, for instance.
#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    pub kind: Kind,
    name: String,
    /// Number of rows.
    pub count: u64,
    pub properties: Vec<Property>,
}

/// Header of a file.
#[derive(Debug, PartialEq)]
pub struct Header {
    /// Byte order of a binary file: true for the most significant byte first. None of a text.
    pub is_big: Option<bool>,
    pub elements: Vec<Element>,
    /// Number of its lines.
    pub lines: usize,
    /// Names that comments give to materials (`comment material NAME`), in order.
    pub materials: Vec<Named>,
    /// True if a comment names a texture.
    names_texture: bool,
}

impl Header {
    /// Reads a header, up to its last line.
    pub fn read(bytes: &mut impl BufRead) -> Result<Self, Fault> {
        let (elements, materials) = (Vec::new(), Vec::new());
        let mut header = Self { is_big: None, elements, lines: 0, materials, names_texture: false };
        let mut format = None;
        // some programs mark texts as UTF-8
        if header.line(bytes)?.trim_start_matches('\u{feff}') != "ply" {
            return Err(Fault::whole("this is no PLY file: it does not begin with `ply`"));
        }
        loop {
            let line = header.line(bytes)?;
            let fault = |message: String| Fault { line: Some(header.lines), message };
            let mut words = line.split_ascii_whitespace();
            match words.next().unwrap_or_default() {
                "end_header" => break,
                "format" => format = Some(byte_order(words.next().unwrap_or_default()).map_err(fault)?),
                "element" => {
                    let element = Element::stated(words).ok_or_else(|| {
                        fault(format!(
                            "`{line}` is no element: write its name and number, as `element vertex 8`"
                        ))
                    });
                    header.elements.push(element?);
                }
                "property" => {
                    let property = Property::stated(words).ok_or_else(|| {
                        fault(format!(
                            "`{line}` is no property: write its type and name, as `property float x`"
                        ))
                    })?;
                    let orphan = || fault(format!("`{line}` belongs to no element: put it below one"));
                    let element = header.elements.last_mut();
                    element.ok_or_else(orphan)?.properties.push(property);
                }
                "comment" => match words.next() {
                    Some("material") => {
                        let name = line.split_once("material").map_or("", |(_, name)| name.trim()).into();
                        header.materials.push(Named { name, line: header.lines });
                    }
                    word => {
                        header.names_texture |=
                            word.is_some_and(|word| word.eq_ignore_ascii_case("texturefile"));
                    }
                },
                "obj_info" | "" => {}
                // comments of Blender 2.4, which left the word out
                "Created" if line.starts_with("Created by Blender") => {}
                _ => {
                    return Err(fault(format!(
                        "`{line}` is no statement of a PLY header: export the file again"
                    )));
                }
            }
        }
        let missing = || Fault::whole("the PLY header has no `format`: export the file again");
        header.is_big = format.ok_or_else(missing)?;
        Ok(header)
    }

    /// Reads a line of the header, without its end.
    fn line(&mut self, bytes: &mut impl BufRead) -> Result<String, Fault> {
        let mut line = Vec::new();
        self.lines += 1;
        bytes.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line)?;
        if line.pop() != Some(b'\n') || self.lines > MOST_LINES {
            let what = "the PLY header does not end (with `end_header`): the file is damaged, or none; export it again";
            return Err(Fault { line: Some(self.lines), message: what.into() });
        }
        let text: String = String::from_utf8_lossy(&line).trim().chars().take(200).collect();
        Ok(text)
    }

    /// Refuses numbers of rows that a file of `length` bytes cannot have: nothing is reserved for them.
    pub fn check_size(&self, length: u64) -> Result<(), Fault> {
        let least = |element: &Element| {
            let bytes = |property: &Property| match self.is_big {
                Some(_) => property.count.unwrap_or(property.kind).bytes() as u64,
                None => 2, // a digit, and what ends it
            };
            element.count.saturating_mul(element.properties.iter().map(bytes).sum())
        };
        let needed = self.elements.iter().map(least).fold(0, u64::saturating_add);
        // the last line of a text may have no end
        if needed > length.saturating_add(1) {
            let message = format!(
                "the PLY file is cut off: its header promises {needed} bytes or more, and it has {length}; copy or export it again"
            );
            return Err(Fault::whole(message));
        }
        Ok(())
    }

    /// Parts of the file that have no effect, in whole sentences.
    pub fn unused(&self) -> Vec<String> {
        let has = |kind: Kind, names: &[&str]| {
            let of_kind = self.elements.iter().filter(|element| element.kind == kind);
            of_kind
                .flat_map(|element| &element.properties)
                .any(|property| names.contains(&property.name.as_str()))
        };
        let found = [
            (
                has(Kind::Face, &["red", "diffuse_red", "r"]),
                "colours of faces are not used: the material has one colour, or a texture",
            ),
            (
                has(Kind::Face, &["texcoord", "texcoords"]),
                "texture coordinates of corners are not used: those of vertices are (`s` and `t`)",
            ),
            (
                self.names_texture,
                "the texture that a comment names is not used: state `map_kd` in a [[material]]",
            ),
        ];
        found.into_iter().filter(|(is_there, _)| *is_there).map(|(_, text)| text.into()).collect()
    }
}

/// Byte order of a format by its name.
fn byte_order(name: &str) -> Result<Option<bool>, String> {
    match name {
        "ascii" => Ok(None),
        "binary_little_endian" => Ok(Some(false)),
        "binary_big_endian" => Ok(Some(true)),
        other => Err(format!(
            "`{other}` is no format of PLY files: ascii, binary_little_endian or binary_big_endian"
        )),
    }
}

impl Element {
    fn stated<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<Self> {
        let (name, count) = (words.next()?, words.next()?.parse().ok()?);
        let kind = match name {
            "vertex" => Kind::Vertex,
            "face" => Kind::Face,
            "tristrips" => Kind::Strip,
            _ => Kind::Other,
        };
        Some(Self { kind, name: name.into(), count, properties: Vec::new() })
    }

    /// Numbers of the properties with these names, each of one value.
    pub fn columns<const N: usize>(&self, names: [&str; N]) -> Option<[usize; N]> {
        let mut columns = [0; N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self
                .properties
                .iter()
                .position(|property| property.name == name && property.count.is_none())?;
        }
        Some(columns)
    }

    /// Number of the list with one of these names.
    pub fn list(&self, names: [&str; 2]) -> Option<usize> {
        self.properties
            .iter()
            .position(|property| names.contains(&property.name.as_str()) && property.count.is_some())
    }

    /// Reads a row: one value for each property into `row`, and the values of list number `wanted` into `list`.
    #[inline]
    pub fn read_row(
        &self,
        values: &mut impl Values,
        row: &mut [f64],
        list: &mut Vec<f64>,
        wanted: Option<usize>,
    ) -> Result<(), Fault> {
        for (number, property) in self.properties.iter().enumerate() {
            let Some(count) = property.count else {
                row[number] = values.next(property.kind)?;
                continue;
            };
            let count = values.next(count)?;
            if !(count >= 0.0 && count.fract() == 0.0) {
                let (name, element) = (&property.name, &self.name);
                return Err(values.fault(format!(
                    "a list `{name}` of the element `{element}` has {count} values: the PLY file is damaged; export it again"
                )));
            }
            let is_wanted = wanted == Some(number);
            // lists may follow the wanted one
            if is_wanted {
                list.clear();
            }
            for _ in 0..count as u64 {
                let value = values.next(property.kind)?;
                if is_wanted {
                    list.push(value);
                }
            }
        }
        Ok(())
    }

    /// Reads all rows, and keeps nothing.
    pub fn pass_over(&self, values: &mut impl Values) -> Result<(), Fault> {
        if self.properties.is_empty() {
            return Ok(());
        }
        let mut row = vec![0.0; self.properties.len()];
        (0..self.count).try_for_each(|_| self.read_row(values, &mut row, &mut Vec::new(), None))
    }
}

impl Property {
    fn stated<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<Self> {
        let first = words.next()?;
        let (count, kind) = match first {
            "list" => (Some(Scalar::called(words.next()?)?), Scalar::called(words.next()?)?),
            kind => (None, Scalar::called(kind)?),
        };
        Some(Self { name: words.next()?.into(), kind, count })
    }
}
