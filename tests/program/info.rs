//! Does `info` tell what a person must know before rendering?

use std::fs;

use crate::runs::{Place, Ran};

fn info(place: &Place, words: &[&str]) -> Ran {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_afterimage"));
    command.current_dir(place.0.path()).arg("info").args(words);
    Ran::new(command.output().unwrap())
}

/// A model of two objects and two materials, of which one has a picture of 16 bits and another one that is missing.
fn place() -> Place {
    let place = Place::new();
    let write = |name: &str, text: &str| fs::write(place.path(name), text).unwrap();
    write(
        "m.obj",
        "mtllib m.mtl\nv 0 0 0\nv 2 0 0\nv 0 1 0\nv 0 0 -3\nvt 0 0\no Wall\nusemtl a\nf 1/1 2/1 3/1\no Side\nusemtl b\nf 1/1 4/1 3/1\n",
    );
    write("m.mtl", "newmtl a\nKd 1 1 1\nmap_Kd deep.png\nnewmtl b\nKd 1 1 1\ndecal d.png\nmap_Kd gone.png\n");
    let picture = image::ImageBuffer::from_pixel(3, 2, image::Rgb([9_u16, 999, 65535]));
    picture.save(place.path("deep.png")).unwrap();
    let camera = "[[camera.key]]\nframe = 1\neye = [0, 0, 9]\ntarget = [0, 0, 0]\n";
    let ball = "[[model]]\nquadric = { type = \"sphere\" }\n[[model.key]]\nframe = 1\n[[model.key]]\nframe = 4\ntranslate = [4, 0, 0]\n";
    let light = "[[light]]\ntype = \"point\"\nposition = [0, 0, 9]\n";
    write(
        "s.toml",
        &format!(
            "[render]\nsize = [64, 36]\nframes = \"1-4\"\n{camera}[[model]]\nobj = \"m.obj\"\n{ball}{light}"
        ),
    );
    place
}

/// The line that begins with `name`.
fn line<'a>(text: &'a str, name: &str) -> &'a str {
    let found = text.lines().find_map(|line| line.trim_start().strip_prefix(name));
    found.unwrap_or_else(|| panic!("no line {name} in\n{text}")).trim_start()
}

#[test]
fn a_model_is_told_with_its_size_its_axis_and_its_objects() {
    let place = place();
    let text = info(&place, &["m.obj", "--up", "y"]).done().stdout;
    assert_eq!(line(&text, "bounds"), "[0, 0, -3] to [2, 1, 0], size [2, 1, 3]");
    assert_eq!(line(&text, "up"), "as --up says");
    assert_eq!(line(&text, "objects"), "2 groups (Wall, Side)");
    assert!(line(&info(&place, &["m.obj"]).done().stdout, "up").contains("by what the model stands on"));
}

#[test]
fn textures_are_told_with_format_and_bits_and_stand_ins_as_such() {
    let text = info(&place(), &["m.obj"]).done().stdout;
    assert!(text.contains("deep.png: 3x2, PNG, 16 bits a channel, colour\n"), "{text}");
    assert!(text.contains("gone.png: a checker stands in for it, because it cannot be found\n"), "{text}");
    assert!(!text.contains("8x8"), "{text}");
}

#[test]
fn statements_without_effect_are_told_with_file_and_line() {
    let ran = info(&place(), &["s.toml"]).done();
    assert!(
        line(&ran.stdout, "not used")
            .ends_with("m.mtl:6: `decal` is not used: nothing is laid over `map_Kd`")
    );
    assert!(!ran.stderr.contains("decal") && ran.stderr.contains("gone.png"), "{}", ran.stderr);
}

#[test]
fn a_shot_is_told_with_what_moves_and_what_it_takes() {
    let text = info(&place(), &["s.toml"]).done().stdout;
    assert_eq!(line(&text, "motion"), "1 of 2 models move");
    assert_eq!(line(&text, "bounds"), "[-1, -1, -3] to [2, 1, 1], size [3, 2, 4], at frame 1");
    assert_eq!(line(&text, "up"), "y, as in all shots");
    assert!(line(&text, "memory").contains(" MiB for rendering, "), "{text}");
    let time = line(&text, "time");
    assert!(time.starts_with("some ") && time.contains("an estimate"), "{text}");
}

#[test]
fn a_light_of_any_type_that_moves_is_told() {
    let place = place();
    let camera = "[[camera.key]]\nframe = 1\neye = [0, 0, 9]\ntarget = [0, 0, 0]\n";
    let keys = "[[light.key]]\nframe = 1\ndirection = [0, -1, 0]\n[[light.key]]\nframe = 4\ndirection = [1, -1, 0]\n";
    let sun = format!("[[light]]\ntype = \"directional\"\nangle = 4\n{keys}");
    fs::write(
        place.path("sun.toml"),
        format!("[render]\nframes = \"1-4\"\n{camera}[[model]]\nobj = \"m.obj\"\n{sun}"),
    )
    .unwrap();
    assert_eq!(line(&info(&place, &["sun.toml"]).done().stdout, "motion"), "1 of 1 lights change");
}
