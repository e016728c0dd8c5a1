//! Reads PLY files (the Stanford triangle format): text, and binary of either byte order.
//!
//! A file is a header that lists elements with their properties, and then the values of all elements, row by row. Vertices and faces
//! count here; other elements are passed over. What comes out is what the OBJ reader gives, with one material and one group, so that all
//! that follows is the same for both.
//!
//! The reader is our own: those on crates.io (ply-rs-bw, ply-rs, serde-ply) make a list on the heap of each face and look properties
//! up by name in each row, which takes many times as long and as much memory as a mesh of ten million triangles, and they do not say
//! where in a file its damage is.

mod fault;
mod header;
mod values;

use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

use glam::{Vec2, Vec3};
use half::f16;

use self::fault::Fault;
use self::header::{Element, Header, Kind};
use self::values::{Binary, Scalar, Text, Values};
use crate::digest::{Digest, DigestingReader};
use crate::input;
use crate::memory::{self, Need, Part};
use crate::scene::SceneError;
use crate::scene::details::vertex_color;
use crate::scene::import::faces::{FaceLists, Named, TriangleSoup};
use crate::scene::texture;

/// Bytes that are read from a file at once.
const BUFFER: usize = 1 << 20;

/// Memory for each byte of a file while it is read: its values, triangles, and what is made of them.
const READING_BYTES: u64 = 3;

/// Content of a PLY file.
pub(crate) struct PlyFile {
    /// Its surface, as an OBJ file of one material has it.
    pub surface: TriangleSoup,
    /// Digest of the file.
    pub digest: Digest,
    /// Parts of the file that have no effect, in whole sentences.
    pub unused: Vec<String>,
}

/// Reads the PLY file at `path`.
///
/// # Errors A file that cannot be read, is damaged, or has no surface.
pub(crate) fn read(path: &Path) -> Result<PlyFile, SceneError> {
    let unreadable = |what: String| SceneError::new(path, format!("the PLY file cannot be read: {what}"));
    let input = input::open(path, input::Kind::Model).map_err(|error| unreadable(error.to_string()))?;
    let need = Need::new(Part::new("the PLY file", READING_BYTES * input.length, "a smaller model"));
    need.check(&memory::left()).map_err(|error| SceneError::new(path, error.to_string()))?;
    read_from(input.file, input.length).map_err(|fault| {
        let error = SceneError::new(path, fault.message);
        fault.line.map_or(error.clone(), |line| error.at_line(line))
    })
}

/// Reads the text or bytes of a PLY file, as [`read`] does. Errors tell what is wrong; for tests.
///
/// # Errors Those of [`read`].
#[doc(hidden)]
pub fn check(bytes: &[u8]) -> Result<usize, String> {
    let read = read_bytes(bytes, bytes.len() as u64);
    read.map(|file| file.surface.triangles.len()).map_err(|fault| fault.message)
}

fn read_from(file: File, length: u64) -> Result<PlyFile, Fault> {
    read_bytes(file, length)
}

fn read_bytes(bytes: impl io::Read, length: u64) -> Result<PlyFile, Fault> {
    let mut bytes = BufReader::with_capacity(BUFFER, DigestingReader::new(bytes));
    let header = Header::read(&mut bytes)?;
    header.check_size(length)?;
    let content = match header.is_big {
        None => Content::read(&header, &mut Text::new(&mut bytes, header.lines)),
        Some(is_big) => Content::read(&header, &mut Binary::new(&mut bytes, is_big)),
    };
    let content = content?;
    io::copy(&mut bytes, &mut io::sink())?;
    let unused = header.unused();
    let surface = content.surface()?;
    Ok(PlyFile { surface, digest: bytes.into_inner().digest(), unused })
}

/// Names of the three parts of a vertex's colour.
const COLORS: [[&str; 3]; 3] =
    [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]];

/// Values that count.
#[derive(Default)]
struct Content {
    positions: Vec<[f32; 3]>,
    /// One a vertex, or none.
    normals: Vec<Vec3>,
    /// One a vertex, or none.
    uvs: Vec<Vec2>,
    /// One a vertex, or none; linear RGB.
    colors: Vec<[f16; 3]>,
    faces: FaceLists,
    /// Materials that faces name by their numbers; none if the whole surface has one without a name.
    materials: Vec<Named>,
    /// Number of faces and strips of fewer than three corners.
    too_small: usize,
}

impl Content {
    fn read(header: &Header, values: &mut impl Values) -> Result<Self, Fault> {
        let mut content = Self { materials: header.materials.clone(), ..Self::default() };
        for element in &header.elements {
            match element.kind {
                Kind::Vertex => content.read_vertices(element, values)?,
                Kind::Face => content.read_faces(element, values)?,
                Kind::Strip => content.read_strips(element, values)?,
                Kind::Other => element.pass_over(values)?,
            }
        }
        Ok(content)
    }

    fn read_vertices(&mut self, element: &Element, values: &mut impl Values) -> Result<(), Fault> {
        let place = element.columns(["x", "y", "z"]).ok_or_else(|| {
            Fault::whole("the vertices of the PLY file have no `x`, `y` and `z`: export the model again")
        })?;
        let normal = element.columns(["nx", "ny", "nz"]);
        let uv = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]]
            .into_iter()
            .find_map(|names| element.columns(names));
        let color = COLORS.into_iter().find_map(|names| element.columns(names));
        // bytes are as screens show them, floats are light
        let is_bytes = color.is_some_and(|[red, ..]| element.properties[red].kind == Scalar::Uint8);
        let light = |value: f64| if is_bytes { texture::linear(value as u8) } else { value as f32 };
        let mut row = vec![0.0; element.properties.len()];
        for _ in 0..element.count {
            element.read_row(values, &mut row, &mut Vec::new(), None)?;
            self.positions.push(place.map(|column| row[column] as f32));
            if let Some(columns) = normal {
                let [x, y, z] = columns.map(|column| row[column] as f32);
                self.normals.push(Vec3::new(x, y, z).normalize_or_zero());
            }
            if let Some(columns) = color {
                self.colors.push(vertex_color(columns.map(|column| light(row[column]))));
            }
            if let Some(columns) = uv {
                let [u, v] = columns.map(|column| row[column] as f32);
                self.uvs.push(if u.is_finite() && v.is_finite() { Vec2::new(u, v) } else { Vec2::ZERO });
            }
        }
        Ok(())
    }

    fn read_faces(&mut self, element: &Element, values: &mut impl Values) -> Result<(), Fault> {
        let list = element.list(["vertex_indices", "vertex_index"]).ok_or_else(|| {
            Fault::whole("the faces of the PLY file have no list `vertex_indices`: export the model again")
        })?;
        let material = element.columns(["material_index"]).filter(|_| !self.materials.is_empty());
        let (mut row, mut corners) = (vec![0.0; element.properties.len()], Vec::new());
        for number in 0..element.count {
            element.read_row(values, &mut row, &mut corners, Some(list))?;
            if let Some([material]) = material {
                self.use_material(row[material])
                    .map_err(|message| values.fault(format!("face {number} {message}")))?;
            }
            match corners.len() {
                0..3 => self.too_small += 1,
                count if count > FaceLists::MOST_CORNERS => {
                    return Err(values.fault(format!(
                        "face {number} has {count} corners, and {} are the most: split it in the modeller",
                        FaceLists::MOST_CORNERS
                    )));
                }
                _ => self.faces.add(corners.iter().copied().map(index)),
            }
        }
        Ok(())
    }

    /// Gives the faces that come next the material of this index.
    fn use_material(&mut self, material: f64) -> Result<(), String> {
        let index = index(material);
        if index as usize >= self.materials.len() {
            let count = self.materials.len();
            return Err(format!(
                "has material {material}, and {count} are named, from 0: the PLY file is damaged; export it again"
            ));
        }
        self.faces.use_material(index);
        Ok(())
    }

    fn read_strips(&mut self, element: &Element, values: &mut impl Values) -> Result<(), Fault> {
        let list = element.list(["vertex_indices", "vertex_index"]).ok_or_else(|| {
            Fault::whole("the strips of the PLY file have no list `vertex_indices`: export the model again")
        })?;
        let (mut row, mut corners) = (vec![0.0; element.properties.len()], Vec::new());
        for _ in 0..element.count {
            element.read_row(values, &mut row, &mut corners, Some(list))?;
            // -1 ends a strip, and begins the next one
            for strip in corners.split(|corner| *corner < 0.0) {
                self.too_small += usize::from(strip.len() < 3);
                for (number, corners) in strip.windows(3).enumerate() {
                    let [a, b, c] = [0, 1, 2].map(|corner| index(corners[corner]));
                    // each second one turns the other way
                    self.faces.add(if number % 2 == 0 { [a, b, c] } else { [b, a, c] }.into_iter());
                }
            }
        }
        Ok(())
    }

    fn surface(self) -> Result<TriangleSoup, Fault> {
        let Self { positions, normals, uvs, colors, faces, materials, too_small } = self;
        let count = positions.len();
        if let Some((face, corner)) = faces.beyond(count) {
            let corner = if corner == u32::MAX {
                String::from("a vertex that is none")
            } else {
                format!("vertex {corner}")
            };
            let message = format!(
                "face {face} names {corner}, and there are {count}, from 0: the PLY file is damaged; export it again"
            );
            return Err(Fault::whole(message));
        }
        let none = faces.count() + too_small;
        let file = TriangleSoup { positions, normals, uvs, colors, ..TriangleSoup::default() };
        let file = faces.surface(file).map_err(|vertex| {
            let message = format!(
                "vertex {vertex} is at no place that can be shown: coordinates must be numbers within 1e18 of the origin"
            );
            Fault::whole(message)
        })?;
        if file.triangles.is_empty() {
            return Err(Fault::whole(match none {
                0 => String::from(
                    "the PLY file has no faces: points alone cannot be rendered; make a surface of them first",
                ),
                n => format!(
                    "none of the {n} faces in the PLY file has an area: check the export's scale and units"
                ),
            }));
        }
        let own = |name: &str| vec![Named { name: name.into(), line: 1 }];
        let materials = if materials.is_empty() { own("") } else { materials };
        Ok(TriangleSoup { places: count, materials, groups: own("default"), ..file })
    }
}

/// Number of a vertex; one that is none becomes one that no file has.
fn index(value: f64) -> u32 {
    let is_one = (0.0..f64::from(u32::MAX)).contains(&value) && value.fract() == 0.0;
    if is_one { value as u32 } else { u32::MAX }
}

#[cfg(test)]
mod tests;
