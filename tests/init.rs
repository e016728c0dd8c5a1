//! Is what `init` writes a shot that shows the model, wherever and however large it is? And what other programs are told.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod program;

use std::fs;
use std::process::Command;

use program::{Place, Ran, whole};

fn run(place: &Place, line: &str) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    Ran::of(command.current_dir(place.0.path()).args(line.split_whitespace()).output().unwrap())
}

/// A pyramid of `size` around `center`.
fn pyramid(center: [f64; 3], size: f64) -> String {
    let corners = [[-0.5, -0.5, -0.5], [0.5, -0.5, -0.5], [0.0, -0.5, 0.5], [0.0, 0.5, 0.0]];
    let line = |corner: [f64; 3]| {
        let [x, y, z] = std::array::from_fn(|i| center[i] + size * corner[i]);
        format!("v {x:e} {y:e} {z:e}\n")
    };
    corners.map(line).concat() + "f 1 2 3\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
}

#[test]
fn the_camera_sees_all_of_the_model() {
    for (center, size) in
        [([0.0; 3], 1.0), ([3e4, -7e3, 12.0], 20.0), ([0.0; 3], 1e-6), ([0.0, 1e9, 0.0], 3e9)]
    {
        let place = Place::new();
        fs::create_dir(place.path("models")).unwrap();
        fs::write(place.path("models/a b.obj"), pyramid(center, size)).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
        let ran =
            command.current_dir(place.0.path()).args(["init", "models/a b.obj", "-o", "s.toml"]).output();
        let ran = Ran::of(ran.unwrap()).done();
        assert!(ran.stdout.contains("afterimage render s.toml"), "{}", ran.stdout);
        let info = run(&place, "info s.toml").done();
        assert!(
            info.stdout.contains("48 in all") && info.stderr.is_empty(),
            "{}{}",
            info.stdout,
            info.stderr
        );
        let options = "-o a.####.exr --frames 1-48x47,24 --size 64x36 --samples 1 --layers none --background transparent";
        Ran::of(place.command("s.toml", options).output().unwrap()).done();
        for frame in [1, 24, 48] {
            let frame = whole(&place.path(&format!("a.{frame:04}.exr")));
            let coverage = &frame.channel("A").unwrap().data;
            let seen = coverage.iter().filter(|alpha| **alpha > 0.0).count();
            assert!(seen > 64 * 36 / 20, "{center:?} {size}: {seen} pixels");
            let is_rim = |pixel: usize| [0, 63].contains(&(pixel % 64)) || [0, 35].contains(&(pixel / 64));
            let at_rim = (0..64 * 36).filter(|&pixel| is_rim(pixel) && coverage[pixel] > 0.0).count();
            assert_eq!(at_rim, 0, "{center:?} {size}");
        }
    }
}

#[test]
fn the_shot_lies_in_the_current_folder_and_replaces_nothing() {
    let place = Place::new();
    fs::create_dir(place.path("m")).unwrap();
    fs::write(place.path("m/a.obj"), pyramid([0.0; 3], 1.0)).unwrap();
    run(&place, "init m/a.obj").done();
    let text = fs::read_to_string(place.path("a.toml")).unwrap();
    assert!(text.contains("obj = \"m/a.obj\"") && !text.contains("everywhere"), "{text}");
    fs::write(place.path("a.toml"), "mine").unwrap();
    run(&place, "init m/a.obj").failed(&["a.toml", "not overwritten", "-o"]);
    assert_eq!(fs::read(place.path("a.toml")).unwrap(), b"mine");
    run(&place, "init m/a.obj -o x/y/b.toml").done();
    assert!(fs::read_to_string(place.path("x/y/b.toml")).unwrap().contains("obj = \"../../m/a.obj\""));
    run(&place, "info x/y/b.toml").done();
    fs::write(place.path("m/dark.mtl"), "newmtl d\nKd 1 1 1\nKa 0 0 0\n").unwrap();
    let dark = pyramid([0.0; 3], 1.0).replacen("f ", "mtllib dark.mtl\nusemtl d\nf ", 1);
    fs::write(place.path("m/dark.obj"), dark).unwrap();
    run(&place, "init m/dark.obj").done();
    assert!(fs::read_to_string(place.path("dark.toml")).unwrap().contains("\neverywhere = true"));
    assert_eq!(run(&place, "info dark.toml").done().stderr, "");
}

#[test]
fn what_is_no_model_gets_no_shot() {
    let place = Place::new();
    fs::write(place.path("a.txt"), "x").unwrap();
    fs::write(place.path("bad.obj"), "v 0 0\n").unwrap();
    run(&place, "init a.txt").failed(&["a.txt", ".obj"]);
    run(&place, "init none.obj").failed(&["none.obj"]);
    run(&place, "init bad.obj").failed(&["bad.obj:1"]);
    assert_eq!(run(&place, "init bad.obj -o a.txt").code, 2);
    assert_eq!(place.names(""), ["a.txt", "bad.obj"]);
}

#[test]
fn shells_complete_all_commands() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let text = run(&place, &format!("completions {shell}")).done().stdout;
        for word in ["render", "diff", "base-every"] {
            assert!(text.contains(word), "{shell}: {word}");
        }
        let completes_values = ["bash", "zsh", "fish"].contains(&shell);
        assert!(!completes_values || text.contains("reproject"), "{shell}");
    }
    assert_eq!(run(&place, "completions tcsh").code, 2);
}

#[test]
fn each_command_has_a_man_page() {
    let place = Place::new();
    let text = run(&place, "man").done().stdout;
    assert!(text.contains(".TH afterimage 1") && text.contains("afterimage\\-render(1)"), "{text}");
    run(&place, "man -o pages").done();
    let commands = ["compare", "completions", "diff", "info", "init", "man", "render", "schema"];
    let expected =
        commands.map(|name| format!("afterimage-{name}.1")).into_iter().chain(["afterimage.1".into()]);
    assert_eq!(place.names("pages"), expected.collect::<Vec<_>>());
    let page = fs::read_to_string(place.path("pages/afterimage-render.1")).unwrap();
    assert!(page.contains(".TH afterimage-render 1") && page.contains("base\\-every"), "{page}");
    fs::write(place.path("file"), "").unwrap();
    run(&place, "man -o file").failed(&["file"]);
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    for word in ["schema", "man"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
        let piped = std::process::Stdio::piped;
        let mut child = command.arg(word).stdout(piped()).stderr(piped()).spawn().unwrap();
        drop(child.stdout.take());
        let ran = Ran::of(child.wait_with_output().unwrap());
        assert_eq!((ran.code, ran.stderr.as_str()), (0, ""), "{word}");
    }
}
