#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
use super::*;

const HEAD: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
const FACES: &str = "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";

fn text(head: &str, values: &str) -> String {
    format!("ply\nformat ascii 1.0\n{head}{values}")
}

fn surface(file: &[u8]) -> TriangleSoup {
    read_bytes(file, file.len() as u64).map(|read| read.surface).unwrap()
}

fn fault(file: &str) -> Fault {
    read_bytes(file.as_bytes(), file.len() as u64).map(|_| ()).unwrap_err()
}

#[test]
fn all_formats_give_the_same() {
    let expected = surface(text(&format!("{HEAD}{FACES}"), SQUARE).as_bytes());
    assert_eq!(expected.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(expected.positions[2], [1.0, 1.0, 0.0]);
    for is_big in [false, true] {
        let order = if is_big { "big" } else { "little" };
        let mut file = format!("ply\r\nformat binary_{order}_endian 1.0\r\n{HEAD}{FACES}").into_bytes();
        let ordered = |bytes: [u8; 4]| if is_big { [bytes[3], bytes[2], bytes[1], bytes[0]] } else { bytes };
        for place in [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]] {
            file.extend(place.iter().flat_map(|x| ordered(x.to_le_bytes())));
        }
        for face in [[0_i32, 1, 2], [0, 2, 3]] {
            file.push(3);
            file.extend(face.iter().flat_map(|corner| ordered(corner.to_le_bytes())));
        }
        assert_eq!(surface(&file), expected);
        for end in 0..file.len() {
            assert!(check(&file[..end]).is_err(), "cut off at {end}");
        }
    }
}

#[test]
fn properties_may_be_of_any_type_and_in_any_order() {
    let head = "comment made by hand\nCreated by Blender3D 247 - www.blender.org\nelement vertex 4\nproperty uchar red\nproperty double z\nproperty short x\nproperty float nx\n\
                property float ny\nproperty float nz\nproperty int8 y\nproperty list int float weights\nproperty float s\nproperty float t\n\
                element edge 1\nproperty int a\nelement face 1\nproperty list ushort uint vertex_index\nproperty uchar flags\nend_header\n";
    let row = |x: i32, y: i32| format!("255 0 {x} 0 0 2 {y} 2 0.5 0.5 {x} {y}\n");
    let rows = [row(0, 0), row(1, 0), row(1, 1), row(0, 1)].concat();
    let file = text(head, &format!("{rows}7\n4 0 1 2 3 9"));
    let PlyFile { surface, unused, .. } = read_bytes(file.as_bytes(), file.len() as u64).unwrap();
    assert_eq!(surface.triangles.len(), 2);
    assert_eq!((surface.normals[1], surface.uvs[2]), (Vec3::Z, Vec2::ONE));
    assert_eq!(unused, [] as [String; 0]);
}

#[test]
fn polygons_are_cut_and_strips_turn_every_second_triangle() {
    let hollow = "element vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
                  property list uchar int vertex_indices\nend_header\n0 0 0\n2 0 0\n2 2 0\n1 0.5 0\n0 2 0\n5 0 1 2 3 4\n";
    assert_eq!(surface(text("", hollow).as_bytes()).triangles.len(), 3);
    let strips = "element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 0 1 2\n";
    let strip = surface(text(HEAD, strips).as_bytes());
    assert_eq!(strip.triangles, [[0, 1, 2], [2, 1, 3], [0, 1, 2]]);
}

#[test]
fn vertices_that_no_face_uses_are_left_out() {
    let head = HEAD.replace("vertex 4", "vertex 6");
    let file = text(
        &format!("{head}{FACES}"),
        &format!("nan 0 0\n{}", SQUARE.replace("3 0 1 2\n3 0 2 3", "9 9 9\n3 1 2 3\n3 1 3 4")),
    );
    let read = surface(file.as_bytes());
    assert_eq!(
        (read.positions.len(), read.sources, read.triangles),
        (4, vec![1, 2, 3, 4], vec![[0, 1, 2], [0, 2, 3]])
    );
}

#[test]
fn damage_is_told_with_its_place() {
    let square = text(&format!("{HEAD}{FACES}"), SQUARE);
    for (from, to, line, words) in [
        ("ply\n", "plx\n", None, "does not begin with `ply`"),
        ("ascii", "asci", Some(2), "`asci` is no format"),
        ("format ascii 1.0\n", "", None, "no `format`"),
        ("property float y", "property flot y", Some(5), "`property flot y` is no property"),
        ("element vertex 4", "element vertex four", Some(3), "is no element"),
        ("element vertex 4\n", "", Some(3), "belongs to no element"),
        ("end_header\n", "", Some(9), "is no statement of a PLY header"),
        ("property float y\n", "", None, "no `x`, `y` and `z`"),
        ("vertex_indices", "corners", None, "no list `vertex_indices`"),
        ("1 1 0\n", "1 one 0\n", Some(12), "`one` is no number"),
        ("3 0 2 3", "3 0 2 4", None, "face 1 names vertex 4, and there are 4"),
        ("3 0 2 3", "3 0 2 -1", None, "a vertex that is none"),
        ("3 0 2 3", "3 0 2", None, "is cut off"),
        ("3 0 2 3", "-3 0 2 3", Some(15), "has -3 values"),
        ("1 1 0\n", "1 inf 0\n", None, "vertex 2 is at no place"),
        ("3 0 1 2\n3 0 2 3", "3 0 1 1\n3 0 2 2", None, "none of the 2 faces in the PLY file has an area"),
        ("element face 2", "element face 99999999999", None, "its header promises"),
        ("element vertex 4", "element vertex 18446744073709551615", None, "its header promises"),
    ] {
        let file = square.replacen(from, to, 1);
        let fault = fault(&file);
        assert!(fault.message.contains(words) && fault.line == line, "{from} to {to}: {fault:?}");
    }
    let points =
        "element vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n";
    assert!(fault(&text("", points)).message.contains("no faces: points alone"));
}

#[test]
fn whatever_a_byte_becomes_nothing_panics() {
    let whole = text(&format!("{HEAD}{FACES}"), SQUARE).into_bytes();
    let binary =
        [text(&format!("{HEAD}{FACES}"), "").replace("ascii", "binary_big_endian").as_bytes(), &[1; 90]]
            .concat();
    for file in [whole, binary] {
        for at in 0..file.len() {
            for byte in [0, b'\n', b'-', b'9', 0x80, 0xFF] {
                let mut odd = file.clone();
                odd[at] = byte;
                let _ = check(&odd);
            }
        }
    }
}

#[test]
fn lists_after_that_of_the_corners_take_nothing_from_it() {
    let head = "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n";
    let values = SQUARE.replace("3 0 1 2", "3 0 1 2 6 0 0 1 0 1 1").replace("3 0 2 3", "3 0 2 3 0");
    let read = surface(text(&format!("{HEAD}{head}"), &values).as_bytes());
    assert_eq!(read.triangles, [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn a_byte_order_mark_is_passed_over() {
    let file = format!("\u{feff}{}", text(&format!("{HEAD}{FACES}"), SQUARE));
    assert_eq!(surface(file.as_bytes()).triangles.len(), 2);
}
