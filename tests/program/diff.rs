//! Does `diff` tell what differs, where, and by its exit code; and does `info` tell what is in files of other programs?

#[path = "../../ffi/openexr/tests/bytes/mod.rs"]
mod bytes;

use std::fs;
use std::process::Command;

use afterimage::output::false_color;

use crate::runs::{Place, Ran, whole};
use bytes::{Part, file};

fn run(place: &Place, line: &str) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    Ran::new(command.current_dir(place.0.path()).args(line.split_whitespace()).output().unwrap())
}

/// That a run ended with `code` and said all of `words`, on stdout, or in one line of stderr if something failed.
#[track_caller]
fn assert_says(ran: &Ran, code: i32, words: &[&str]) {
    assert_eq!(ran.code, code, "{}{}", ran.stdout, ran.stderr);
    let text = if code == 2 { &ran.stderr } else { &ran.stdout };
    assert!(code != 2 || (text.starts_with("error: ") && text.lines().count() == 1), "{text}");
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}

const WINDOW: [i32; 4] = [0, 0, 1, 1];

fn write(place: &Place, name: &str, channels: &[(&str, &[f32])]) {
    write_part(place, name, Part { name: "a", kind: "scanlineimage", window: WINDOW, channels });
}

fn write_part(place: &Place, name: &str, part: Part<'_>) {
    fs::write(place.path(name), file(&[part])).unwrap();
}

/// Two files that differ in three channels of two layers, and have one each alone.
fn two(place: &Place) {
    let zero: &[f32] = &[0.0; 4];
    write(place, "a.exr", &[("B", zero), ("G", zero), ("R", zero), ("Z", &[1.0; 4]), ("old.V", zero)]);
    let (red, green, depth) = ([0.0, 0.5, 0.0, 0.0], [0.0, 0.25, 1e-3, 0.0], [1.0, 1.0, 1.0, f32::NAN]);
    write(place, "b.exr", &[("B", zero), ("G", &green), ("R", &red), ("Z", &depth), ("new.V", zero)]);
}

#[test]
fn a_frame_is_the_same_as_itself() {
    let place = Place::new();
    place.render("-o a.####.exr --frames 1-2").done();
    let ran = run(&place, "diff a.0001.exr a.0001.exr");
    assert_says(&ran, 0, &["R G B A 0 - - 0 0", "status_age 0", "Z 0", "same"]);
    assert_says(&run(&place, "diff a.0001.exr a.0002.exr"), 1, &["R G B A", "differ: "]);
    assert_eq!(run(&place, "diff a.0001.exr a.0002.exr -q").stdout, "");
}

#[test]
fn parts_are_compared_as_one_picture() {
    let place = Place::new();
    let options = "--frames 1 --layers Z,status";
    place.render(&format!("-o a.####.exr {options}")).done();
    place.render(&format!("-o parts.####.exr {options} --multipart")).done();
    assert_eq!(openexr::part_count(&place.path("parts.0001.exr")).unwrap(), 8);
    let ran = run(&place, "diff a.0001.exr parts.0001.exr");
    assert_says(&ran, 0, &["R G B A 0 - - 0 0", "status_missed 0", "Z 0", "same"]);
    // names that say nothing without the part's; and a part elsewhere
    let part = |name, window, value| Part { name, kind: "scanlineimage", window, channels: value };
    let zero: &[(&str, &[f32])] = &[("R", &[0.0; 4])];
    let one: &[(&str, &[f32])] = &[("R", &[1.0; 4])];
    for (name, second, window) in [("a", zero, WINDOW), ("b", one, WINDOW), ("c", zero, [1, 0, 2, 1])] {
        let parts = [part("left", WINDOW, zero), part("right", window, second)];
        fs::write(place.path(&format!("{name}.exr")), file(&parts)).unwrap();
    }
    assert_says(&run(&place, "diff a.exr b.exr"), 1, &["R 0 - -", "right 1.000 R (0, 0) 1.000 4 100.000"]);
    assert_says(&run(&place, "diff a.exr c.exr"), 2, &["c.exr", "part 2 has another size or place"]);
}

#[test]
fn what_differs_is_told_layer_by_layer() {
    let place = Place::new();
    two(&place);
    let rmse = format!("{:.4}", (0.3125_f64 + 1e-6).sqrt() / 12.0_f64.sqrt());
    assert_says(
        &run(&place, "diff a.exr b.exr"),
        1,
        &[
            &format!("R G B 0.5000 R (1, 0) {rmse} 2 50.000"),
            "Z inf Z (1, 1) 0 1 25.000",
            "only in a.exr: old.V",
            "only in b.exr: new.V",
            "differ: 3 of 4 pixels; 1 values are NaN or infinite in one of the files alone",
        ],
    );
}

#[test]
fn the_tolerance_decides_what_is_the_same() {
    let place = Place::new();
    write(&place, "a.exr", &[("R", &[0.0; 4])]);
    write(&place, "b.exr", &[("R", &[0.0, 0.5, 0.0, 0.25])]);
    assert_says(&run(&place, "diff a.exr b.exr --tolerance 0.25"), 1, &["0.5000 R (1, 0)", "1 of 4 pixels"]);
    assert_says(&run(&place, "diff a.exr b.exr --tolerance 0.5"), 0, &["same within 0.5"]);
    for bad in ["-1", "nan", "inf", "x"] {
        let ran = run(&place, &format!("diff a.exr b.exr --tolerance={bad}"));
        assert_eq!(ran.code, 2, "{bad}");
        assert!(ran.stderr.contains("number from 0 on"), "{}", ran.stderr);
    }
}

#[test]
fn a_picture_of_the_difference_has_all_channels_or_false_colors() {
    let place = Place::new();
    two(&place);
    assert_eq!(run(&place, "diff a.exr b.exr -o d.exr -q").code, 1);
    let picture = whole(&place.path("d.exr"));
    let names: Vec<&str> = picture.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["B", "G", "R", "Z"]);
    assert_eq!(picture.channel("R").unwrap().data, [0.0, 0.5, 0.0, 0.0]);
    assert_eq!(picture.channel("Z").unwrap().data, [0.0, 0.0, 0.0, f32::MAX], "a file holds no infinity");
    assert_eq!(run(&place, "diff a.exr b.exr -o d.png -q --tolerance 0.01").code, 1);
    let colors = image::open(place.path("d.png")).unwrap().to_rgb8();
    let expected = [0.0, 0.5, 0.0, 0.0].map(false_color::of_difference);
    assert_eq!(colors.into_raw(), expected.concat());
}

#[test]
fn other_sizes_and_windows_are_told() {
    let place = Place::new();
    write(&place, "a.exr", &[("R", &[0.0; 4])]);
    let channels: &[(&str, &[f32])] = &[("R", &[0.0; 4])];
    for (window, words) in
        [([0, 0, 3, 0], "sizes differ: 2x2 and 4x1"), ([5, 6, 6, 7], "sizes differ: 2x2 and 2x2 at (5, 6)")]
    {
        write_part(&place, "b.exr", Part { name: "a", kind: "scanlineimage", window, channels });
        assert_says(&run(&place, "diff a.exr b.exr"), 1, &[words]);
        assert_says(&run(&place, "diff a.exr b.exr -o d.exr"), 2, &["d.exr", "different sizes"]);
        assert!(!place.path("d.exr").exists());
    }
}

#[test]
fn sequences_are_compared_frame_by_frame() {
    let place = Place::new();
    fs::create_dir(place.path("x")).unwrap();
    for (name, value) in [
        ("a.0001", 0.0),
        ("a.0002", 0.0),
        ("a.0003", 0.0),
        ("a.0005", 0.0),
        ("x/b.1", 0.0),
        ("x/b.2", 0.5),
        ("x/b.3", 0.25),
        ("x/b.4", 0.0),
    ] {
        write(&place, &format!("{name}.exr"), &[("B", &[0.0; 4]), ("G", &[0.0; 4]), ("R", &[value; 4])]);
    }
    let ran = run(&place, "diff a.####.exr x/b.#.exr -o d/d.####.png");
    assert_says(
        &ran,
        1,
        &[
            "frame 2: 4 pixels differ; the largest difference is 0.5000 in R at (0, 0)",
            "frame 3: 4 pixels differ",
            "R G B 0.5000 R (0, 0) of 2",
            "only in a.####.exr: frame 5",
            "only in x/b.#.exr: frame 4",
            "differ: 2 of 3 frames",
        ],
    );
    assert!(!ran.stdout.contains("frame 1"), "{}", ran.stdout);
    assert_eq!(place.names("d"), ["d.0001.png", "d.0002.png", "d.0003.png"]);
    assert_says(&run(&place, "diff a.%04d.exr a.####.exr"), 0, &["same: 4 frames"]);
    assert_says(&run(&place, "diff a.####.exr a.0001.exr"), 2, &["two sequences"]);
    assert_says(&run(&place, "diff c.####.exr a.####.exr"), 2, &["c.####.exr", "no such frame"]);
    assert_says(&run(&place, "diff none/c.####.exr a.####.exr"), 2, &["none/c.####.exr", "folder"]);
}

#[test]
fn what_cannot_be_compared_is_an_error_with_the_file() {
    let place = Place::new();
    write(&place, "a.exr", &[("R", &[0.0; 4])]);
    let bytes = fs::read(place.path("a.exr")).unwrap();
    fs::write(place.path("short.exr"), &bytes[..bytes.len() - 4]).unwrap();
    fs::write(place.path("text.exr"), "this is no picture").unwrap();
    fs::create_dir(place.path("folder")).unwrap();
    let channels: &[(&str, &[f32])] = &[("R", &[0.0; 4])];
    for (name, kind) in [("tiled.exr", "tiledimage"), ("deep.exr", "deepscanline")] {
        write_part(&place, name, Part { name: "a", kind, window: WINDOW, channels });
    }
    let part = |name, kind| Part { name, kind, window: WINDOW, channels };
    let parts = [part("one", "scanlineimage"), part("two", "tiledimage")];
    fs::write(place.path("parts.exr"), file(&parts)).unwrap();
    for (name, words) in [
        ("none.exr", "check the name"),
        ("short.exr", "short.exr"),
        ("text.exr", "text.exr"),
        ("folder", "is a folder"),
        ("tiled.exr", "it is tiled"),
        ("deep.exr", "it is deep"),
        ("parts.exr", "it is tiled"),
    ] {
        for line in [format!("diff a.exr {name}"), format!("diff {name} a.exr")] {
            assert_says(&run(&place, &line), 2, &[name, words]);
        }
    }
    for (output, words) in [("a.exr", "compared"), ("d.jpg", ".png"), ("d.png", "R, G and B")] {
        assert_says(&run(&place, &format!("diff a.exr a.exr -o {output}")), 2, &[output, words]);
    }
    assert_eq!(fs::read(place.path("a.exr")).unwrap(), bytes);
    assert_says(&run(&place, "diff a.exr a.exr -o text.exr/d.exr"), 2, &["text.exr"]);
}

#[test]
fn info_tells_parts_layers_and_values() {
    let place = Place::new();
    let odd = [f32::NAN, f32::INFINITY, -1.0, 3.0];
    let beauty: &[(&str, &[f32])] = &[("B", &odd), ("R", &[0.0, 0.0, 0.0, 1.0])];
    let depth: &[(&str, &[f32])] = &[("Z", &[5.0; 4])];
    let parts = [
        Part { name: "beauty", kind: "scanlineimage", window: WINDOW, channels: beauty },
        Part { name: "tiles", kind: "tiledimage", window: WINDOW, channels: depth },
        Part { name: "depth", kind: "scanlineimage", window: [3, 3, 4, 4], channels: depth },
    ];
    fs::write(place.path("parts.exr"), file(&parts)).unwrap();
    let words = [
        "part 1 of 3: beauty size 2x2 compression NONE",
        "R float 0 1 0.25 0 0",
        "B float -1 3 1 1 1",
        "part 2 of 3: parts.exr: OpenEXR failed to read it: it is tiled",
        "part 3 of 3: depth size 2x2 at (3, 3); the display window is 2x2 at (3, 3)",
        "Z float 5 5 5 0 0",
    ];
    assert_says(&run(&place, "info parts.exr"), 0, &words);
    place.render("-o a.####.exr --frames 2").done();
    let ran = run(&place, "info a.0002.exr");
    let words = [
        "size 64x36",
        "frame 2, 24 a second",
        "camera at (",
        "field of view",
        "status_good V half",
        "comments",
    ];
    assert_says(&ran, 0, &words);
    let channels = ran.stdout.lines().filter(|line| line.contains(" half ") || line.contains(" float "));
    assert_eq!(channels.count(), 12, "{}", ran.stdout);
}
