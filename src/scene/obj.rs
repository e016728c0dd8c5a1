//! Reads the geometry of OBJ files.
//!
//! What it gives is a soup of triangles with the names of their materials; what those names mean is
//! found in [`mtl`](super::mtl), and [`assemble`](super::assemble) makes a mesh of both. Objects and
//! groups are not told apart: a file is one model, which moves as one.

use std::path::Path;

use glam::{DVec3, Vec2, Vec3};

use super::SceneError;
use super::lines::readable;
use super::obj_lines::{Fault, LARGEST_COORDINATE, Named, ObjLines};
use super::polygon::Cutter;

/// The content of an OBJ file.
#[derive(Debug, Default)]
pub(crate) struct ObjFile {
    /// Object space, finite.
    pub positions: Vec<[f32; 3]>,
    /// One a vertex or none at all; unit length, or zero where the file has none that is usable.
    pub normals: Vec<Vec3>,
    /// One a vertex or none at all; finite.
    pub uvs: Vec<Vec2>,
    /// Never empty; none without an area.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle, an index into `materials`.
    pub material_of: Vec<u32>,
    /// Names after `usemtl` by their first use; the first is empty, for faces before any.
    pub materials: Vec<Named>,
    /// What `mtllib` lines say, in order.
    pub libraries: Vec<Named>,
}

/// Reads the OBJ file at `path`.
///
/// # Errors
/// Where the file cannot be read, holds values that make no sense (with their line), or no surface.
pub(crate) fn read(path: &Path) -> Result<ObjFile, SceneError> {
    let bytes = std::fs::read(path)
        .map_err(|error| SceneError::new(path, format!("the OBJ file cannot be read: {error}")))?;
    parse(&readable(bytes)).map_err(|fault| {
        let error = SceneError::new(path, fault.message);
        if fault.line == 0 { error } else { error.at_line(fault.line) }
    })
}

/// Reads OBJ text. A fault of the whole file has line 0.
pub(crate) fn parse(text: &[u8]) -> Result<ObjFile, Fault> {
    let mut lines = ObjLines::new(text);
    let options = tobj::LoadOptions {
        single_index: true,
        triangulate: false, // it would fan out concave faces
        ignore_points: true,
        ignore_lines: true,
    };
    // the lines keep `mtllib` to themselves, and the loader is never called
    let no_materials = |_: &Path| Ok(Default::default());
    let groups = match tobj::load_obj_buf(&mut lines, &options, no_materials) {
        Ok((groups, _)) => groups,
        Err(error) => return Err(fault_of(error, text, lines)),
    };
    let mut obj = ObjFile::default();
    let mut flat = 0;
    for group in &groups {
        flat += obj.append(group)?;
    }
    if !obj.positions.as_flattened().iter().all(|x| x.abs() <= LARGEST_COORDINATE) {
        let whole =
            Fault { line: 0, message: String::from("a vertex is not finite: export the model again") };
        return Err(ObjLines::find_fault(text, lines.counts()).unwrap_or(whole));
    }
    if obj.triangles.is_empty() {
        return Err(Fault { line: 0, message: nothing_there(flat + lines.too_small) });
    }
    obj.materials = lines.materials;
    obj.libraries = lines.libraries;
    Ok(obj)
}

fn nothing_there(without_area: usize) -> String {
    match without_area {
        0 => String::from("the OBJ file holds no faces: points and lines alone cannot be rendered"),
        n => format!("none of the {n} faces in the OBJ file has an area: check the export's scale and units"),
    }
}

/// Puts tobj's error into words, with the line.
fn fault_of(error: tobj::LoadError, text: &[u8], mut lines: ObjLines<'_>) -> Fault {
    use tobj::LoadError as E;
    if let Some(fault) = lines.fault.take() {
        return fault;
    }
    match error {
        E::PositionParseError => lines.fault_here("`v` takes three numbers"),
        E::NormalParseError => lines.fault_here("`vn` takes three numbers"),
        E::TexcoordParseError => lines.fault_here("`vt` takes two numbers"),
        E::ReadError => lines.fault_here("expected numbers"),
        // tobj looks at indices at the end of a group: only a second look knows the line
        _ => {
            while std::io::BufRead::fill_buf(&mut lines).is_ok_and(|rest| !rest.is_empty()) {
                let rest = std::io::BufRead::fill_buf(&mut lines).map_or(0, <[u8]>::len);
                std::io::BufRead::consume(&mut lines, rest);
            }
            let whole = Fault { line: 0, message: format!("the OBJ file is damaged: {error}") };
            ObjLines::find_fault(text, lines.counts()).unwrap_or(whole)
        }
    }
}

impl ObjFile {
    /// Adds a group of tobj's. Says how many faces had no area.
    fn append(&mut self, group: &tobj::Model) -> Result<usize, Fault> {
        let mesh = &group.mesh;
        let base = self.positions.len();
        let vertices = mesh.positions.len() / 3;
        if base + vertices > u32::MAX as usize {
            return Err(Fault {
                line: 0,
                message: String::from("more than 4294967295 vertices: split the model"),
            });
        }
        self.positions.extend(mesh.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        fill(&mut self.normals, base, mesh.normals.chunks_exact(3), vertices, |n| {
            Vec3::new(n[0], n[1], n[2]).normalize_or_zero()
        });
        fill(&mut self.uvs, base, mesh.texcoords.chunks_exact(2), vertices, |uv| {
            Some(Vec2::new(uv[0], uv[1])).filter(|uv| uv.is_finite()).unwrap_or_default()
        });
        let before = self.triangles.len();
        let flat = self.append_faces(mesh, base as u32);
        // the lines name each group by its material's number
        let material = group.name.parse().unwrap_or(0);
        self.material_of.resize(self.material_of.len() + self.triangles.len() - before, material);
        Ok(flat)
    }

    fn append_faces(&mut self, mesh: &tobj::Mesh, base: u32) -> usize {
        let mut cutter = Cutter::new();
        let mut corners = Vec::new();
        let (mut at, mut flat) = (0, 0);
        let all_triangles = mesh.face_arities.is_empty();
        let faces = if all_triangles { mesh.indices.len() / 3 } else { mesh.face_arities.len() };
        for face in 0..faces {
            let arity = if all_triangles { 3 } else { mesh.face_arities[face] as usize };
            let indices = &mesh.indices[at..at + arity];
            at += arity;
            corners.clear();
            corners.extend(indices.iter().map(|i| self.position(base + i)));
            let before = self.triangles.len();
            cutter.cut(&corners, |[a, b, c]| {
                let across = (corners[b] - corners[a]).cross(corners[c] - corners[a]);
                // not finite: kept, for the check of coordinates to find
                if across != DVec3::ZERO {
                    self.triangles.push([a, b, c].map(|i| base + indices[i]));
                }
            });
            flat += usize::from(self.triangles.len() == before);
        }
        flat
    }

    fn position(&self, index: u32) -> DVec3 {
        Vec3::from(self.positions[index as usize]).as_dvec3()
    }
}

/// Appends one entry a vertex to a list that has entries for all vertices or for none.
fn fill<'a, T: Copy + Default>(
    list: &mut Vec<T>,
    base: usize,
    values: impl ExactSizeIterator<Item = &'a [f32]>,
    vertices: usize,
    convert: impl Fn(&[f32]) -> T,
) {
    if values.len() == vertices && vertices > 0 {
        // groups before this one had none
        list.resize(base, T::default());
        list.extend(values.map(convert));
    } else if !list.is_empty() {
        list.resize(base + vertices, T::default());
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    fn read_text(faces: &str) -> ObjFile {
        parse(format!("{SQUARE}{faces}").as_bytes()).unwrap()
    }

    fn fault(text: &str) -> Fault {
        parse(text.as_bytes()).unwrap_err()
    }

    #[test]
    fn reads_quads_with_all_parts() {
        let obj = read_text("vt 0 0\nvt 1 1\nvn 0 0 2\nf 1/1/1 2/2/1 3/2/1 -1/1/-1");
        assert_eq!(obj.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(obj.normals, [Vec3::Z; 4]);
        assert_eq!(obj.uvs, [Vec2::ZERO, Vec2::ONE, Vec2::ONE, Vec2::ZERO]);
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
        assert_eq!((names, obj.material_of), (vec!["", "a b", "c"], vec![0, 1, 2, 1]));
    }

    #[test]
    fn unusable_normals_and_coordinates_become_zero() {
        let obj = read_text("vn nan 0 1\nvt inf 0\nf 1/1/1 2/1/1 3/1/1");
        assert_eq!((obj.normals[0], obj.uvs[0]), (Vec3::ZERO, Vec2::ZERO));
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
        assert_eq!(parse(b"v 1 2 \xff\n").unwrap_err().line, 1);
    }

    #[test]
    fn stray_vertices_may_be_odd() {
        assert_eq!(parse(format!("{SQUARE}v nan 0 0\nf 1 2 3").as_bytes()).unwrap().triangles.len(), 1);
    }
}
