//! Cages of OBJ files: their faces as they are, and the tags of OpenSubdiv (`t crease 2/1/0 0 1 2.5`), whose indices count from 0.
//!
//! The file was read before, as triangles: what is wrong with any other statement was told then.

use std::collections::HashMap;
use std::path::Path;
use std::str;

use super::lines::{Lines, readable, split_keyword, words};
use super::statement::{self, Corner};
use crate::input::{self, Kind};
use crate::memory::{self, Need, Part};
use crate::scene::SceneError;
use crate::scene::cage::{Cage, FaceVarying, Spread, SpreadKind};
use crate::subdivision::{Boundary, Scheme};

/// Memory for each byte of a file while it is read as a cage.
const READING_BYTES: u64 = 8;

/// A cage whose faces name their materials.
pub(crate) struct ObjCage {
    /// The cage; `material_of` are indices into `names`.
    pub cage: Cage,
    /// Names of materials by their first use.
    pub names: Vec<String>,
    /// Tags that are not used, by name.
    pub unused: Vec<String>,
}

/// Statements that were read so far.
#[derive(Default)]
struct Read {
    points: Vec<[f32; 3]>,
    colors: Vec<Option<[f32; 3]>>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    counts: Vec<u32>,
    /// Position, texture coordinate and normal of each corner, from 0.
    corners: Vec<[Option<u32>; 3]>,
    material_of: Vec<u16>,
    /// Number of the last material.
    material: u16,
    names: Vec<String>,
    numbers: HashMap<String, u16>,
    creases: Vec<([u32; 2], f32)>,
    sharp_points: Vec<(u32, f32)>,
    holes: Vec<u32>,
    /// Number that the file states for its boundary.
    boundary: Option<i64>,
    unused: Vec<String>,
}

/// Reads the cage in the OBJ file at `path`.
///
/// # Errors With line: tags that make no sense. The file changed meanwhile.
pub(crate) fn read_cage(path: &Path, scheme: Scheme) -> Result<ObjCage, SceneError> {
    let unreadable = |error: &dyn std::fmt::Display| {
        SceneError::new(path, format!("the OBJ file cannot be read as a cage: {error}"))
    };
    let input = input::open(path, Kind::Model).map_err(|error| unreadable(&error))?;
    let part = Part::new("reading the cage", READING_BYTES * input.length, "a coarser cage");
    Need::new(part).check(&memory::left()).map_err(|error| unreadable(&error))?;
    let text = readable(input.read_all().map_err(|error| unreadable(&error))?);
    let mut read = Read::default();
    for (line, content) in Lines::new(&text) {
        read.statement(&content).map_err(|what| SceneError::new(path, what).at_line(line))?;
    }
    read.cage(scheme).map_err(|what| SceneError::new(path, what))
}

impl Read {
    fn statement(&mut self, line: &[u8]) -> Result<(), String> {
        let (keyword, rest) = split_keyword(line);
        match keyword {
            b"v" => {
                self.points.push(statement::three("v", rest)?);
                let more: Vec<&[u8]> = words(rest).skip(3).collect();
                let color = (more.len() >= 3).then(|| statement::color_behind(&more.join(&b' '))).flatten();
                self.colors.push(color.map(|color| color.map(f32::from)));
            }
            b"vt" => self.uvs.push(statement::texture_coordinate(rest)?),
            b"vn" => self.normals.push(statement::three("vn", rest)?),
            b"usemtl" => self.use_material(&String::from_utf8_lossy(rest)),
            b"f" => self.face(rest)?,
            b"t" => self.tag(rest)?,
            _ => {}
        }
        Ok(())
    }

    fn use_material(&mut self, name: &str) {
        let next = self.names.len() as u16;
        let number = *self.numbers.entry(name.to_string()).or_insert(next);
        if number == next {
            self.names.push(name.to_string());
        }
        self.material = number;
    }

    fn face(&mut self, rest: &[u8]) -> Result<(), String> {
        let defined = [self.points.len(), self.uvs.len(), self.normals.len()];
        let begin = self.corners.len();
        for word in words(rest) {
            let corner: Corner = statement::corner(word)?;
            let absolute = |part: usize| match corner[part] {
                0 => None,
                index if index > 0 => u32::try_from(index - 1).ok(),
                index => u32::try_from(defined[part] as i64 + index).ok(),
            };
            self.corners.push([0, 1, 2].map(absolute));
        }
        if self.names.is_empty() {
            self.use_material("");
        }
        self.counts.push((self.corners.len() - begin) as u32);
        self.material_of.push(self.material);
        Ok(())
    }

    /// Reads a tag: its name, the numbers of its whole numbers, numbers and words, and these.
    fn tag(&mut self, rest: &[u8]) -> Result<(), String> {
        let all: Vec<&str> = words(rest).filter_map(|word| str::from_utf8(word).ok()).collect();
        let wrong = || {
            let shown: String = all.join(" ").chars().take(60).collect();
            format!(
                "the tag `t {shown}` makes no sense: write it as `t crease 2/1/0 0 1 2.5`, with points from 0"
            )
        };
        let [name, counts, values @ ..] = &all[..] else { return Err(wrong()) };
        let counts: Option<Vec<usize>> = counts.split('/').map(|count| count.parse().ok()).collect();
        let Some([wholes, numbers, ..]) = counts.as_deref() else { return Err(wrong()) };
        let wholes_of = values.get(..*wholes).ok_or_else(wrong)?;
        let end = wholes.checked_add(*numbers).ok_or_else(wrong)?;
        let numbers_of = values.get(*wholes..end).ok_or_else(wrong)?;
        let wholes: Option<Vec<u32>> = wholes_of.iter().map(|value| value.parse().ok()).collect();
        let wholes = wholes.ok_or_else(wrong)?;
        let sharp = |value: &&str| value.parse().ok().filter(|sharp: &f32| *sharp >= 0.0);
        let numbers: Option<Vec<f32>> = numbers_of.iter().map(sharp).collect();
        let numbers = numbers.ok_or_else(wrong)?;
        match *name {
            "crease" => {
                let sharp = *numbers.first().ok_or_else(wrong)?;
                let edges = wholes.windows(2).enumerate();
                self.creases.extend(
                    edges.map(|(edge, ends)| {
                        ([ends[0], ends[1]], numbers.get(edge).copied().unwrap_or(sharp))
                    }),
                );
            }
            "corner" => {
                let sharp = *numbers.first().ok_or_else(wrong)?;
                let points = wholes.iter().enumerate();
                self.sharp_points
                    .extend(points.map(|(at, point)| (*point, numbers.get(at).copied().unwrap_or(sharp))));
            }
            "hole" => self.holes.extend(wholes),
            "interpolateboundary" => self.boundary = wholes.first().map(|kind| i64::from(*kind)),
            other => self.unused.push(format!("the tag `{other}` of its cage is not used")),
        }
        Ok(())
    }

    fn cage(mut self, scheme: Scheme) -> Result<ObjCage, String> {
        let changed = || String::from("it changed while it was read: render again");
        let count = self.points.len();
        let points_of =
            self.corners.iter().map(|[point, ..]| point.filter(|point| (*point as usize) < count));
        let corners: Vec<u32> = points_of.collect::<Option<_>>().ok_or_else(changed)?;
        let is_there = |point: u32| (point as usize) < count;
        let named = self.creases.iter().flat_map(|(ends, _)| *ends);
        let named = named.chain(self.sharp_points.iter().map(|(point, _)| *point));
        if let Some(bad) = named.into_iter().find(|point| !is_there(*point)) {
            return Err(format!(
                "a tag names point {bad}, and there are {count} (from 0): the file is damaged; export it again"
            ));
        }
        let values = |part: usize, value: &dyn Fn(usize) -> Option<[f32; 3]>| {
            let at = |corner: &[Option<u32>; 3]| corner[part].and_then(|number| value(number as usize));
            let is_any = self.corners.iter().any(|corner| at(corner).is_some());
            is_any
                .then(|| self.corners.iter().map(|corner| at(corner).unwrap_or([0.0; 3])).collect::<Vec<_>>())
        };
        let is_finite = |value: &[f32; 3]| value.iter().all(|number| number.is_finite());
        let uv = |number: usize| self.uvs.get(number).map(|[u, v]| [*u, *v, 0.0]).filter(is_finite);
        let normal = |number: usize| self.normals.get(number).copied().filter(is_finite);
        let uvs = values(1, &uv).map(|values| Spread::of_corners(&values, &corners));
        let is_stated = scheme == Scheme::Bilinear;
        let normals = is_stated
            .then(|| values(2, &normal))
            .flatten()
            .map(|values| Spread { kind: SpreadKind::Linear, ..Spread::of_corners(&values, &corners) });
        let has_colors = self.colors.iter().all(Option::is_some);
        let colors = has_colors.then(|| Spread {
            values: self.colors.iter().map(|color| color.unwrap_or([1.0; 3])).collect(),
            of_corner: corners.clone(),
            kind: SpreadKind::OfPoints,
        });
        self.holes.sort_unstable();
        self.holes.dedup();
        let mut cage = Cage {
            scheme,
            uvs,
            second_uvs: None,
            colors,
            normals,
            points: self.points,
            counts: self.counts,
            corners,
            holes: self.holes,
            material_of: self.material_of,
            creases: self.creases,
            sharp_points: self.sharp_points,
            boundary: if self.boundary == Some(2) { Boundary::Edges } else { Boundary::EdgesAndCorners },
            face_varying: FaceVarying::default(),
            shapes: Vec::new(),
        };
        if self.boundary == Some(0) && scheme != Scheme::Bilinear {
            cage.hide_boundary();
        }
        self.unused.dedup();
        Ok(ObjCage { cage, names: self.names, unused: self.unused })
    }
}
