//! Pictures of all formats and depths: what their texels mean.

use std::fs::{self, File};
use std::path::Path;

use afterimage::scene::Texture;
use afterimage::scene::material::Computes;
use afterimage::scene::shared_exponent::SharedExponent;
use glam::{Vec2, Vec3};
use image::{ImageBuffer, Luma, Rgb, Rgb32FImage, Rgba};
use openexr::{Channel, Compression, Data, Image, SampleType};

use crate::small_shot::*;

/// The texture of the material `wood`, with this statement.
fn texture(folder: &Path, statement: &str) -> Texture {
    fs::write(folder.join("m.mtl"), format!("newmtl wood\n{statement}\nnewmtl clear\n")).unwrap();
    load_in(folder, REST, true).unwrap().scene.textures[0].clone()
}

/// Colour of the texel to the left, of two.
fn left(texture: &Texture) -> Vec3 {
    texture.color(Vec2::new(0.25, 0.5), 0)
}

/// Names and values of channels, of two texels.
fn write_exr(path: &Path, planes: &[(&str, [f32; 2])]) {
    let channels = planes.iter().map(|(name, values)| {
        let data = Data::Floats(values);
        Channel { name, stored: SampleType::Half, data }
    });
    let (attributes, compression) = (Vec::new(), Compression::Zip);
    let image =
        Image { width: 2, height: 1, placed: None, channels: channels.collect(), attributes, compression };
    openexr::write(&File::create(path).unwrap(), path, &image).unwrap();
}

#[test]
fn sixteen_bits_are_finer_than_eight() {
    let folder = folder();
    // within one step of eight bits
    for (name, value) in [("a.png", 30_000_u16), ("b.png", 30_060)] {
        let picture = ImageBuffer::from_pixel(2, 1, Rgb([value; 3]));
        picture.save(folder.path().join(name)).unwrap();
    }
    let [low, high] =
        ["a.png", "b.png"].map(|name| left(&texture(folder.path(), &format!("map_Kd {name}"))).x);
    let linear = |encoded: f32| ((encoded / 65535.0 + 0.055) / 1.055).powf(2.4);
    for (shown, value) in [(low, 30_000.0), (high, 30_060.0)] {
        assert!((shown / linear(value) - 1.0).abs() < 1e-3, "{shown}, not {}", linear(value));
    }
    assert!(low < high);
}

#[test]
fn pictures_of_floats_hold_light() {
    let folder = folder();
    let picture = Rgb32FImage::from_pixel(2, 1, Rgb([0.25, 0.5, 7.0]));
    picture.save_with_format(folder.path().join("a.hdr"), image::ImageFormat::Hdr).unwrap();
    write_exr(
        &folder.path().join("a.exr"),
        &[("R", [0.25; 2]), ("G", [0.5; 2]), ("B", [7.0; 2]), ("depth.Z", [9.0; 2])],
    );
    for name in ["a.hdr", "a.exr"] {
        let color = left(&texture(folder.path(), &format!("map_Kd {name}")));
        assert!(color.distance(Vec3::new(0.25, 0.5, 1.0)) < 2e-3, "{name}: {color}, no more than all light");
    }
    write_exr(&folder.path().join("grey.exr"), &[("Y", [0.125, 1.0]), ("A", [1.0, 0.0])]);
    let grey = texture(folder.path(), "map_Kd grey.exr");
    assert_eq!(left(&grey), Vec3::splat(0.125));
    assert_eq!([0, 1].map(|texel| grey.texels().get(texel).alpha()), [255.0, 0.0]);
}

#[test]
fn a_statement_may_say_what_colours_mean() {
    let folder = folder();
    ImageBuffer::from_pixel(2, 1, Rgb([51_u8; 3])).save(folder.path().join("a.png")).unwrap();
    write_exr(&folder.path().join("a.exr"), &[("Y", [0.5; 2])]);
    for (statement, value) in [
        ("map_Kd a.png", 0.0331),
        ("map_Kd -colorspace sRGB a.png", 0.0331),
        ("map_Kd -colorspace linear a.png", 0.2),
        ("map_Kd a.exr", 0.5),
        ("map_Kd -colorspace sRGB a.exr", 0.214),
    ] {
        let shown = left(&texture(folder.path(), statement)).x;
        assert!((shown - value).abs() < 5e-4, "{statement}: {shown}");
    }
}

/// Normals and numbers are no colours, whatever the file.
#[test]
fn numbers_are_not_encoded() {
    let folder = folder();
    ImageBuffer::from_pixel(2, 1, Rgba([65_535_u16, 32_768, 0, 65_535]))
        .save(folder.path().join("n.png"))
        .unwrap();
    let normals = texture(folder.path(), "norm n.png");
    let vector = normals.vector(Vec2::new(0.3, 0.5), 0);
    assert!(vector.distance(Vec3::new(1.0, 0.0, -1.0)) < 2e-3, "{vector}");
    // a step that eight bits do not have is a slope
    let heights = ImageBuffer::from_fn(4, 1, |x, _| Luma([if x < 2 { 40_000_u16 } else { 40_050 }]));
    heights.save(folder.path().join("h.png")).unwrap();
    let bumps = texture(folder.path(), "bump h.png");
    assert!(bumps.vector(Vec2::new(0.375, 0.5), 0).x < -0.9);
}

#[test]
fn odd_floats_are_numbers_in_textures() {
    let folder = folder();
    write_exr(&folder.path().join("a.exr"), &[("R", [-3.0, 0.5]), ("G", [0.0, 1.0]), ("B", [60_000.0, 0.0])]);
    assert_eq!(left(&texture(folder.path(), "map_Kd a.exr")), Vec3::Z);
    write_exr(&folder.path().join("b.exr"), &[("X", [1.0; 2])]);
    fs::write(folder.path().join("m.mtl"), "newmtl wood\nmap_Kd b.exr\nnewmtl clear\n").unwrap();
    let message = load_in(folder.path(), REST, true).unwrap_err().to_string();
    assert!(message.contains("must have the channels R, G and B, or Y, and has X"), "{message}");
}

/// `DWAA` and `B44`, which OpenEXR 3.1 cannot unpack by itself, with a gradient: see ffi/openexr/tests/packed.rs.
const PACKED: [(&str, &[u8]); 3] = [
    ("dwaa.exr", include_bytes!("../../ffi/openexr/tests/packed/dwaa.exr")),
    ("dwab.exr", include_bytes!("../../ffi/openexr/tests/packed/dwab.exr")),
    ("b44.exr", include_bytes!("../../ffi/openexr/tests/packed/b44.exr")),
];

#[test]
fn textures_in_dwa_and_b44_have_the_colours_of_their_files() {
    let folder = folder();
    for (name, bytes) in PACKED {
        fs::write(folder.path().join(name), bytes).unwrap();
        let picture = texture(folder.path(), &format!("map_Kd {name}"));
        assert_eq!(picture.size(), [21, 37], "{name}");
        for (x, y) in [(0, 0), (5, 9), (10, 30), (20, 16)] {
            let color = picture.texels().get(y * 21 + x).color().truncate();
            let [across, down, both] = [x as f32 / 21.0, y as f32 / 37.0, (x + y) as f32 / 29.0];
            let expected = Vec3::new(across, down, both).min(Vec3::ONE);
            assert!(
                (color - expected).abs().max_element() < 0.011,
                "{name} {x} {y}: {color}, not {expected}"
            );
        }
    }
}

#[test]
fn light_of_a_picture_may_be_brighter_than_white() {
    let folder = folder();
    write_exr(&folder.path().join("a.exr"), &[("R", [20.0, 0.0]), ("G", [5.0, 0.5]), ("B", [0.0, 1.0])]);
    fs::write(folder.path().join("m.mtl"), "newmtl wood\nmap_Ke a.exr\nnewmtl clear\n").unwrap();
    let scene = load_in(folder.path(), REST, true).unwrap().scene;
    let wood = scene.materials.iter().position(|one| one.name == "wood").unwrap();
    assert!(scene.materials[wood].is_computed(Computes::Emission));
    let picture = scene.textures.iter().find(|one| one.path.ends_with("a.exr")).unwrap();
    let shown = [0.25, 0.75].map(|u| SharedExponent::new(picture.value(Vec2::new(u, 0.5), 0)).color());
    assert_eq!(shown, [Vec3::new(20.0, 5.0, 0.0), Vec3::new(0.0, 0.5, 1.0)]);
}
