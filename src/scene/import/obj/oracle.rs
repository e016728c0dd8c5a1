//! Compares our reader with tobj, on files by many authors and on some of our own.
//!
//! tobj is given lines in a plain form of OBJ, because it takes some things otherwise than they are meant:
//! indices of which only some corners of a face have a texture coordinate, say. Faces are cut
//! up in the same way for both.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

#[path = "../../../../tests/collection/mod.rs"]
mod collection;

use std::borrow::Cow;
use std::fmt::Write;
use std::iter;
use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};

use super::lines::{Lines, readable, split_keyword, words};
use super::source::Source;
use super::{PIECE, TriangleSoup, parse};
use crate::scene::import::faces::polygon::Cutter;

/// Bits of position, texture coordinate and normal; zeros for absent ones.
type Corner = [u32; 8];

/// All triangles, with material and corners.
type Soup = Vec<(String, [Corner; 3])>;

fn corner(position: [f32; 3], uv: Vec2, normal: Vec3) -> Corner {
    let [x, y, z] = position;
    [x, y, z, uv.x, uv.y, normal.x, normal.y, normal.z].map(f32::to_bits)
}

fn ours(obj: &TriangleSoup) -> Soup {
    let corner = |i: u32| {
        let i = i as usize;
        let uv = obj.uvs.get(i).copied().unwrap_or_default();
        corner(obj.positions[i], uv, obj.normals.get(i).copied().unwrap_or_default())
    };
    let uses = obj.uses.iter().flat_map(|(count, material)| iter::repeat_n(*material, *count));
    let material = |of: super::Use| obj.materials[of.material as usize].name.clone();
    assert_eq!(uses.clone().count(), obj.triangles.len());
    obj.triangles.iter().zip(uses).map(|(t, id)| (material(id), t.map(corner))).collect()
}

/// Reads `text` with tobj; `None` if it refuses.
fn theirs(text: &[u8]) -> Option<Soup> {
    let (plain, materials) = plain(text)?;
    let options = tobj::LoadOptions { single_index: true, ..tobj::OFFLINE_RENDERING_LOAD_OPTIONS };
    let options = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..options };
    let (groups, _) = tobj::load_obj_buf(&mut plain.as_bytes(), &options, |_| Ok(Default::default())).ok()?;
    let mut soup = Soup::new();
    for group in groups {
        add(&mut soup, &materials[group.name.parse::<usize>().unwrap_or(0)], &group.mesh);
    }
    Some(soup)
}

fn add(soup: &mut Soup, material: &str, mesh: &tobj::Mesh) {
    let position = |i: usize| -> [f32; 3] { mesh.positions[3 * i..3 * i + 3].try_into().unwrap() };
    let corner = |i: usize| {
        let uv = mesh.texcoords.get(2 * i..2 * i + 2).map_or(Vec2::ZERO, Vec2::from_slice);
        let normal = mesh.normals.get(3 * i..3 * i + 3).map_or(Vec3::ZERO, Vec3::from_slice);
        let uv = if uv.is_finite() { uv } else { Vec2::ZERO };
        corner(position(i), uv, normal.normalize_or_zero())
    };
    let mut indices = mesh.indices.iter().map(|i| *i as usize);
    let faces = if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { mesh.face_arities.len() };
    for face in 0..faces {
        let arity = mesh.face_arities.get(face).map_or(3, |arity| *arity as usize);
        let face: Vec<usize> = indices.by_ref().take(arity).collect();
        let places: Vec<_> = face.iter().map(|i| Vec3::from(position(*i)).as_dvec3()).collect();
        Cutter::new().cut(&places, |[a, b, c]| {
            if (places[b] - places[a]).cross(places[c] - places[a]).length_squared() != 0.0 {
                soup.push((material.to_string(), [a, b, c].map(|i| corner(face[i]))));
            }
        });
    }
}

/// Writes the text in a form that tobj reads as intended, with a group for each change of material or of the
/// attributes that faces have. Returns also the materials: the groups' names are their numbers.
fn plain(text: &[u8]) -> Option<(String, Vec<String>)> {
    let (mut out, mut materials) = (String::new(), vec![String::new()]);
    let (mut counts, mut material, mut group) = ([0; 3], 0, None);
    for (_, line) in Lines::new(text) {
        let (keyword, rest) = split_keyword(&line);
        let words: Vec<Cow<'_, str>> = words(rest).map(String::from_utf8_lossy).collect();
        match keyword {
            b"v" => (counts[0] += 1, writeln!(out, "v {}", words.get(..3)?.join(" ")).unwrap()).1,
            b"vn" => (counts[2] += 1, writeln!(out, "vn {}", words.get(..3)?.join(" ")).unwrap()).1,
            b"vt" => {
                counts[1] += 1;
                writeln!(out, "vt {} {}", words.first()?, words.get(1).map_or("0", |word| word)).unwrap();
            }
            b"usemtl" => {
                let name = String::from_utf8_lossy(rest).into_owned();
                let known = materials.iter().position(|material| *material == name);
                material = known.unwrap_or(materials.len());
                if known.is_none() {
                    materials.push(name);
                }
            }
            b"f" if words.len() > 2 => {
                let corners: Vec<[i64; 3]> =
                    words.iter().map(|word| absolute(word, counts)).collect::<Option<_>>()?;
                let parts = [0, 1, 2].map(|part| corners.iter().all(|corner| corner[part] != 0));
                if group != Some((material, parts)) {
                    writeln!(out, "g {material}").unwrap();
                    group = Some((material, parts));
                }
                out.push('f');
                for [v, vt, vn] in corners {
                    let [vt, vn] = [(parts[1], vt), (parts[2], vn)]
                        .map(|(is_there, index)| if is_there { index.to_string() } else { String::new() });
                    write!(out, " {v}/{vt}/{vn}").unwrap();
                }
                out.push('\n');
            }
            _ => {}
        }
    }
    Some((out, materials))
}

fn absolute(word: &str, counts: [i64; 3]) -> Option<[i64; 3]> {
    let mut corner = [0; 3];
    for (part, digits) in word.split('/').enumerate().filter(|(_, digits)| !digits.is_empty()) {
        let index: i64 = digits.parse().ok()?;
        *corner.get_mut(part)? = if index < 0 { counts[part] + 1 + index } else { index };
    }
    Some(corner)
}

/// Reads `text` in pieces of many sizes on one thread and on several, and compares all results with tobj's.
/// Returns true if tobj found any triangle.
#[track_caller]
fn compare(text: &[u8], sizes: &[u64], name: &str) -> bool {
    let text = readable(text.to_vec());
    let expected = theirs(&text);
    let source = Source::Memory(Cow::Borrowed(&text));
    let mut first = None;
    for (threads, size) in [1, 3].into_iter().flat_map(|n| sizes.iter().map(move |size| (n, *size))) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let read = pool.install(|| parse(&source, size)).unwrap().map(|(obj, _)| obj);
        if let (Ok(obj), Some(expected)) = (&read, &expected) {
            let soup = ours(obj);
            assert_eq!(soup.len(), expected.len(), "{name}, in pieces of {size}: triangles");
            let differing = soup.iter().zip(expected).position(|(a, b)| a != b);
            assert_eq!(differing, None, "{name}, in pieces of {size}");
        } else if read.is_ok() {
            panic!("{name}: only tobj refuses it");
        }
        // not only the triangles: everything
        assert!(first.is_none_or(|first| first == read), "{name}: {threads} threads, pieces of {size}");
        first = Some(read);
    }
    expected.is_some_and(|expected| !expected.is_empty())
}

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";

/// Writes a vertex with `normals` normals, each twice.
fn tip(normals: usize) -> String {
    let faces = |n| format!("f 1//{n} 2//{n} 3//{n}\n");
    (0..normals).map(|n| format!("vn 1 {n} 1\n")).chain((1..=normals).chain(1..=normals).map(faces)).collect()
}

#[test]
fn odd_files_of_our_own_are_read_as_tobj_reads_them() {
    let relative = "v 9 0 0\nv 9 1 0\nv 9 0 1\nvn 0 0 1\nf -3//-1 -2//-1 -1//-1\n".repeat(9);
    let seams =
        "vt 0 0\nvt 1 0\nvn 0 0 1\nvn 0 1 0\nf 1/1/1 2/2/1 3/1/2\nf 3/2/2 2/2/1 1/1/1\nf 1/2 2/1 3/1\n";
    // longer than what is looked at at once
    let alike = "v 0.5 -1.25 12.25\nvt 0.125 0.25\nvn 0.0 -2 1\nv 1.5 1.25 -0.25\nvt -2 1\nvn 0.6 -0.0 0.25\n\
                 v 3.5 -1 100.25\nvt 5 0.25\nvn 0.5 0.5 0.25\nf 1/1/1 2/2/2 3/3/3\nf 3/3/3 2/2/2 1/1/1 2/2/2\n";
    let mixed = "f 1/2/1 2/1/2 3/3/3\nf 1 2 3\nf 1//3 2//2 3//1 2//2\nf 1/3 2/1 3/2\n";
    let counting = "f 1/1/1 2/2/2 3/3/3 2/2/2 1/1/1\nf -1/-1/-1 -2/-2/-2 -3/-3/-3\nf 1/1/1 -1/-1/-1 2/2/2\n";
    for (name, faces) in [
        ("triangles", "f 1 2 3\nf 1 3 4\n".repeat(5)),
        ("quads and more", "f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 7 5\nf 1 2 3 4 8 7 6\n".repeat(3)),
        (
            "groups",
            "g a\nf 1 2 3\no b c\nusemtl x y\nf 1 3 4\ns off\nusemtl z\nf 5 6 7\nusemtl x y\nf 5 7 8\n"
                .into(),
        ),
        (
            "a material before a border",
            format!("usemtl first\n{}usemtl x\n\n\n\n\n\n\nf 1 2 3\n", "f 1 2 4\n".repeat(9)),
        ),
        ("relative", relative.clone()),
        ("relative and absolute", format!("{relative}f 1 2 3\nf -9 2 3\nf 1//-1 2//1 -3//-1\n{relative}")),
        ("parts that come and go", format!("{seams}f 1 2 3\n{seams}{relative}f 5 6 7\n")),
        ("seams", seams.repeat(4)),
        (
            "continued",
            "f 1 \\\n 2 3\nf 1\\\r\n \\\n3 4\n# c \\\nf 5 6 7\nv 1 2 \\\n3\nf 9 1 2 \\\n\n".repeat(3),
        ),
        ("CR LF", "f 1 2 3\r\nusemtl a b \r\nf 1 3 4 \r\n\r\n".repeat(3)),
        ("comments", "f 1 2 3 # 4\n#f 1 2 4\nv 3 3 3#c\nf 1 2 9\n\n \t\nl 1 2 3\np 1\n".into()),
        ("stray vertices", "v nan 0 0\nv 1e30 0 0\nvn 1 1 1\nvt 3 4\nf 1 2 3\nf 4 3 5\n".into()),
        ("forward", "f 9 10 11\nf 1 2 9\nv 9 9 9\nv 8 9 9\nv 8 8 9\nf 1 2 3\n".into()),
        ("flat", "f 1 1 2\nf 1 2\nf 3 3 3 3\nf 1 2 3\nf 1 2 1\n".into()),
        ("colours and weights", "v 1 2 3 0.5 0.5 0.5\nv 4 5 6 1\nvt 0.5\nvt 1 2 3\nf 9/1 10/2 1/1\n".into()),
        (
            "numbers",
            "v 1e2 -.5 +3.\nv 0.1234567890123456789 1E-3 -0\nv 16777217.0000001 1.5e0 7\nf 9 10 11\n".into(),
        ),
        ("a tip of many normals", tip(150)),
        ("points and signs", alike.repeat(30)),
        ("corners that agree, and others", format!("{}{mixed}{}", alike.repeat(12), alike.repeat(12))),
        (
            "corners that agree, of five and counting back",
            format!("{}{counting}{}", alike.repeat(12), alike.repeat(12)),
        ),
        (
            "more in a line",
            alike.repeat(12).replace(".25\n", ".25 0.5 0.5 0.5\n").replace("-2 1\n", "-2 1 7\n"),
        ),
        (
            "whole numbers and blanks",
            alike.repeat(12).replace(".25", "").replace("f ", "f  ").replace(".5 ", ".5e0  "),
        ),
        ("no last line end", "f 1 2 3\nf 1 3 4".into()),
    ] {
        let text = format!("{CUBE}{faces}");
        assert!(
            compare(text.as_bytes(), &[1, 7, 20, 33, 100, 300, 700, PIECE], name),
            "{name}: tobj reads it"
        );
    }
}

#[test]
fn faulty_files_have_the_same_fault_in_pieces_of_any_size() {
    for faces in [
        "f 1 2 99",
        "f 1 2 x",
        "v 1 2",
        "v 1 2 nan\nf 1 2 9",
        "f -99 1 2",
        "f 1 1 1",
        "",
        "vt 1 1\nf 1/2 2/1 3/1",
        "vt 1 1\nvn 1 0 0\nf 1/1/1 1/1/1 1/1/1\nf 2/2/2 1/1/1 1/1/1",
        "vt 1 1\nf -1/-1 1/1 2/9",
    ] {
        let text = format!("{CUBE}{faces}\nv 1 2 3\n# c\n# c\n# c\n");
        compare(text.as_bytes(), &[1, 7, 33, PIECE], faces);
        let text =
            format!("{text}{}", "# a comment that is longer than what is looked at at once\n".repeat(9));
        compare(text.as_bytes(), &[PIECE], faces);
    }
}

#[test]
fn own_files_are_read_as_tobj_reads_them() {
    assert!(compare_files_of(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")) > 0);
}

#[test]
#[cfg_attr(not(scene_collection), ignore = "needs the scene collection: set AFTERIMAGE_SCENES")]
fn real_files_are_read_as_tobj_reads_them() {
    let collected = ["awkward", "statues", "animated", "bathroom", "kitchen", "warehouse"];
    let found: usize = collected.into_iter().map(|name| compare_files_of(&collection::folder(name))).sum();
    println!("{found} files are the same");
}

/// Counts the OBJ files in `folder` that both readers take.
fn compare_files_of(folder: &Path) -> usize {
    let mut files = Vec::new();
    files_of(folder, &mut files);
    let mut found = 0;
    for path in &files {
        let text = std::fs::read(path).unwrap();
        let sizes: &[u64] = if text.len() < 100_000 { &[1, 300, PIECE] } else { &[PIECE] };
        found += usize::from(compare(&text, sizes, &path.display().to_string()));
    }
    found
}

fn files_of(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files_of(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "obj") {
            found.push(path);
        }
    }
}
