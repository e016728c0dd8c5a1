//! Is what `init` writes a shot that shows the model, wherever and however large it is? And what other programs are told.

use std::fs;
use std::process::Command;

use crate::runs;
use crate::runs::{Place, Ran, whole};

fn run(place: &Place, line: &str) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    Ran::new(command.current_dir(place.0.path()).args(line.split_whitespace()).output().unwrap())
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
        let ran = Ran::new(ran.unwrap()).done();
        assert!(ran.stdout.contains("afterimage render s.toml"), "{}", ran.stdout);
        let info = run(&place, "info s.toml").done();
        assert!(
            info.stdout.contains("120 in all") && info.stderr.is_empty(),
            "{}{}",
            info.stdout,
            info.stderr
        );
        // without its floor what is covered is the model
        let text = fs::read_to_string(place.path("s.toml")).unwrap();
        let (before, after) = text.split_once("[floor]").unwrap();
        let after = &after[after.find("\n#").unwrap()..];
        fs::write(place.path("s.toml"), format!("{before}{after}")).unwrap();
        let options = "-o a.####.exr --frames 1,31,81 --size 64x36 --samples 1 --paths 0 --layers none --background transparent";
        Ran::new(place.command("s.toml", options).output().unwrap()).done();
        let mut highest = 0;
        for frame in [1, 31, 81] {
            let frame = whole(&place.path(&format!("a.{frame:04}.exr")));
            let coverage = &frame.channel("A").unwrap().data;
            let is_seen = |pixel: &usize| coverage[*pixel] > 0.0;
            let is_rim = |pixel: &usize| [0, 63].contains(&(pixel % 64)) || [0, 35].contains(&(pixel / 64));
            let at_rim = (0..64 * 36).filter(|pixel| is_rim(pixel) && is_seen(pixel)).count();
            assert_eq!(at_rim, 0, "{center:?} {size}");
            let rows: Vec<usize> = (0..64 * 36).filter(is_seen).map(|pixel| pixel / 64).collect();
            highest = highest.max(rows.last().unwrap() - rows[0] + 1);
        }
        assert!(highest > 36 * 7 / 10, "{center:?} {size}: {highest} rows");
    }
}

/// What `init` writes is what a bare model is rendered by.
#[test]
fn a_bare_model_looks_as_its_shot() {
    let place = Place::new();
    fs::write(place.path("a.obj"), pyramid([0.3, 2.0, -1.0], 1.5)).unwrap();
    run(&place, "init a.obj").done();
    let options = "--frames 1-3 --size 64x36 --samples 1 --paths 2 --audit --stats s.json";
    for (shot, output) in [("a.toml", "shot.####.exr"), ("a.obj", "bare.####.exr")] {
        let ran = Ran::new(place.command(shot, &format!("{options} -o {output}")).output().unwrap()).done();
        for note in ["up is y", "go 6 of 360 degrees around"] {
            assert_eq!(ran.stderr.contains(note), shot == "a.obj", "{}", ran.stderr);
        }
    }
    for frame in 1..=3 {
        let [shot, bare] = ["shot", "bare"].map(|name| place.path(&format!("{name}.{frame:04}.exr")));
        runs::assert_same(&shot, &bare);
        // pictures that can be looked at, but of a shot only those that were asked for
        assert_eq!([&shot, &bare].map(|path| path.with_extension("png").exists()), [false, true]);
    }
    // model and light rest: what samples have gathered is kept
    let stats: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(place.path("s.json")).unwrap()).unwrap();
    let frames = stats["frames"].as_array().unwrap();
    let modes: Vec<&str> = frames.iter().map(|frame| frame["mode"].as_str().unwrap()).collect();
    assert_eq!(modes, ["base", "reproject", "reproject"]);
    let gathering = |frame: usize| frames[frame]["rays"]["gathering"].as_u64().unwrap();
    assert!(gathering(1) * 4 < gathering(0) && gathering(2) * 4 < gathering(0), "{stats}");
}

#[test]
fn the_axis_up_is_guessed_or_given() {
    let place = Place::new();
    let upright = pyramid([0.0; 3], 1.0);
    let lying: String = upright.lines().fold(String::new(), |all, line| {
        let words: Vec<&str> = line.split(' ').collect();
        let line = match words[..] {
            ["v", x, y, z] => format!("v {x} {} {y}", -z.parse::<f64>().unwrap()),
            _ => line.to_owned(),
        };
        all + &line + "\n"
    });
    fs::write(place.path("y.obj"), upright).unwrap();
    fs::write(place.path("z.obj"), lying).unwrap();
    let rotate = "\nrotate = [-90, 0, 0]";
    for (model, options, note, turns) in [
        ("y", "", "up is y", false),
        ("z", "", "up is z", true),
        ("y", "--up z", "", true),
        ("z", "--up y", "", false),
    ] {
        let ran = run(&place, &format!("init {model}.obj {options} -o s.toml")).done();
        assert!(ran.stderr.contains(note) && ran.stderr.is_empty() == note.is_empty(), "{}", ran.stderr);
        assert_eq!(
            fs::read_to_string(place.path("s.toml")).unwrap().contains(rotate),
            turns,
            "{model} {options}"
        );
        fs::remove_file(place.path("s.toml")).unwrap();
    }
    fs::write(place.path("s.toml"), "").unwrap();
    let ran = run(&place, "render s.toml --up z");
    assert!(ran.code == 2 && ran.stderr.contains("rotate"), "{}", ran.stderr);
}

#[test]
fn the_shot_lies_in_the_current_folder_and_replaces_nothing() {
    let place = Place::new();
    fs::create_dir(place.path("m")).unwrap();
    fs::write(place.path("m/a.obj"), pyramid([0.0; 3], 1.0)).unwrap();
    run(&place, "init m/a.obj").done();
    let info = run(&place, "info m/a.obj").done().stdout;
    assert!(
        info.contains("\n  materials   0; what has none is grey\n"),
        "without the floor of its turntable: {info}"
    );
    let text = fs::read_to_string(place.path("a.toml")).unwrap();
    assert!(text.contains("obj = \"m/a.obj\"") && !text.contains("[[material]]"), "{text}");
    fs::write(place.path("a.toml"), "mine").unwrap();
    run(&place, "init m/a.obj").failed(&["a.toml", "not overwritten", "-o"]);
    assert_eq!(fs::read(place.path("a.toml")).unwrap(), b"mine");
    run(&place, "init m/a.obj -o x/y/b.toml").done();
    assert!(fs::read_to_string(place.path("x/y/b.toml")).unwrap().contains("obj = \"../../m/a.obj\""));
    run(&place, "info x/y/b.toml").done();
    // black as some exporters write it
    fs::write(place.path("m/dark.mtl"), "newmtl d\nKd 0 0 0\nKa 0 0 0\nillum 1\n").unwrap();
    let dark = pyramid([0.0; 3], 1.0).replacen("f ", "mtllib dark.mtl\nusemtl d\nf ", 1);
    fs::write(place.path("m/dark.obj"), dark).unwrap();
    assert!(run(&place, "init m/dark.obj").done().stderr.contains("light grey"));
    assert!(fs::read_to_string(place.path("dark.toml")).unwrap().contains("name = \"d\"\nkd = "));
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
    let commands =
        "compare completions diff farm info init man preview render schema verify".split_whitespace();
    let expected = commands.map(|name| format!("afterimage-{name}.1")).chain(["afterimage.1".into()]);
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
        let ran = Ran::new(child.wait_with_output().unwrap());
        assert_eq!((ran.code, ran.stderr.as_str()), (0, ""), "{word}");
    }
}
