//! Bad input, through the binary: an error that names file and line, never a panic, and nothing left behind.
//! What the loaders say about each mistake in a shot is tested in `scene_shot`.

use std::fs;
use std::process::Command;

use crate::runs::{Place, Ran, ended, make_fifo, whole};

const SHOT: &str = "[render]\nsize = [16, 9]\nsamples = 2\nframes = \"1-2\"\n\
    [[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n\
    [[camera.key]]\nframe = 2\neye = [1, 0, 5]\ntarget = [0, 0, 0]\n\
    [[model]]\nobj = \"m.obj\"\n";
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// The same shot with light in it, so that nothing is told of darkness.
fn lit(shot: &str) -> String {
    format!("{shot}[ambient]\ncolor = [0.1, 0.1, 0.1]\n")
}

/// A folder with a shot and its model.
fn place(shot: &str, obj: &[u8]) -> Place {
    let place = Place::new();
    fs::write(place.path("s.toml"), shot).unwrap();
    fs::write(place.path("m.obj"), obj).unwrap();
    place
}

fn render(place: &Place, file: &str, options: &str) -> Ran {
    Ran::new(place.command(file, &format!("-o out/a.####.exr --layers all {options}")).output().unwrap())
}

/// That `file` is refused in one line that holds `words`, and that nothing new lies in the folder.
#[track_caller]
fn refused(place: &Place, file: &str, words: &[&str]) {
    let before = place.names("");
    let ran = render(place, file, "").failed(words);
    assert_eq!((ran.stderr.lines().count(), ran.stdout.as_str()), (1, ""), "{}", ran.stderr);
    assert_eq!(place.names(""), before);
}

#[test]
fn mistakes_in_a_shot_name_its_line() {
    for (from, to, words) in [
        ("samples = 2", "sampels = 2", ["s.toml:3:1", "did you mean `samples`"]),
        ("\"1-2\"", "\"2-1\"", ["s.toml:4:10", "backwards"]),
        ("\"1-2\"", "\"\"", ["s.toml:4:10", "frames"]),
        ("\"1-2\"", "\"1-2x0\"", ["s.toml:4:10", "`1-2x0`"]),
        ("\"1-2\"", "\"1-99999999\"", ["s.toml:4:10", "1000000"]),
        ("\"1-2\"", "\"1-99999999999\"", ["s.toml:4:10", "99999999999"]),
        ("m.obj", "gone.obj", ["s.toml:14:7", "gone.obj"]),
        ("m.obj", "", ["s.toml:14:7", "obj"]),
        ("m.obj", ".", ["obj", "`.`"]),
        ("eye = [1, 0, 5]", "eye = [1e999, 0, 5]", ["s.toml:11:8", "overflow"]),
        ("[render]", "[render", ["s.toml:1:8", "]"]),
        ("[render]", "\u{0}", ["s.toml:1:2", "key"]),
    ] {
        refused(&place(&SHOT.replacen(from, to, 1), OBJ.as_bytes()), "s.toml", &words);
    }
}

#[test]
fn models_that_cannot_be_shown_name_file_and_line() {
    let cases: [(&[u8], &[&str]); 13] = [
        (b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &["m.obj:1", "`nan`", "finite"]),
        (b"v 0 0 0\nv 1 0 0\nv 0 inf 0\nf 1 2 3\n", &["m.obj:3", "`inf`"]),
        (b"v 0 0 0\nv 1 0 0\nv 0 1e30 0\nf 1 2 3\n", &["m.obj:3", "1e30"]),
        (b"v 0 0 0\nv 1 0\n", &["m.obj:2", "three numbers"]),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", &["m.obj:4", "vertex 4 of 3"]),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", &["m.obj:4", "counts back"]),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3/x\n", &["m.obj:4", "3/x"]),
        (b"", &["m.obj: ", "is empty"]),
        (b"\x64\x86\x07\x00\x5a\x10\x2b\x65\x00\x01\x00\x00", &["m.obj: ", "compiler (COFF)"]),
        (b"\x4c\x01\x02\x00\x0a\x0d\x2b\x65\x00\x01\x00\x00\x0a", &["m.obj: ", "compiler (COFF)"]),
        (b"v 0 0 0\nv 1 0 0\nl 1 2\n", &["m.obj: ", "no faces"]),
        (b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", &["m.obj: ", "area"]),
        (b"\x7fELF\x02\x01\x01\x00\x00\xff\xfe", &["m.obj: ", "no faces"]),
    ];
    for (obj, words) in cases {
        let place = place(SHOT, obj);
        refused(&place, "s.toml", words);
        refused(&place, "m.obj", words);
        let mut info = Command::new(env!("CARGO_BIN_EXE_afterimage"));
        Ran::new(info.current_dir(place.0.path()).args(["info", "m.obj"]).output().unwrap()).failed(words);
    }
}

#[test]
fn files_that_are_none_are_named() {
    let place = place(SHOT, OBJ.as_bytes());
    for folder in ["folder.toml", "folder.obj"] {
        fs::create_dir(place.path(folder)).unwrap();
        refused(&place, folder, &[folder, "cannot be read"]);
    }
    fs::write(place.path("latin.toml"), b"title = \"caf\xe9\"\n").unwrap();
    refused(&place, "latin.toml", &["latin.toml", "UTF-8"]);
    fs::write(place.path("m.stl"), "solid").unwrap();
    refused(&place, "m.stl", &["m.stl", ".obj"]);
    refused(&place, "gone.toml", &["gone.toml"]);
}

/// `words` on the command line, ended before long.
fn afterimage(place: &Place, words: &str) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    command.current_dir(place.0.path()).args(words.split_whitespace());
    ended(command)
}

/// A shot that reads a file of each kind.
fn place_of_all_kinds() -> Place {
    let shapes = "[model.shapes]\nobj = \"k.#.obj\"\n";
    let cache = "[[model]]\nobj = \"m.obj\"\n[model.shapes]\ncache = \"c.pc2\"\n";
    let shot = format!("{SHOT}{shapes}{cache}[environment]\nmap = \"e.hdr\"\n");
    let obj = OBJ.replace("f 1 2 3", "vt 0 0\nusemtl a\nf 1/1 2/1 3/1");
    let place = place(&shot, format!("mtllib m.mtl\n{obj}").as_bytes());
    let write = |name: &str, bytes: &[u8]| fs::write(place.path(name), bytes).unwrap();
    write("m.mtl", b"newmtl a\nmap_Kd t.png\n");
    write("k.1.obj", OBJ.as_bytes());
    write("k.2.obj", OBJ.replace("0 1 0", "0 2 0").as_bytes());
    image::RgbImage::from_pixel(1, 1, image::Rgb([9, 99, 200])).save(place.path("t.png")).unwrap();
    let pc2 = [&b"POINTCACHE2\0"[..], &[1, 3].map(u32::to_le_bytes).concat()];
    let pc2 = [&pc2.concat()[..], &[1.0, 1.0].map(f32::to_le_bytes).concat(), &1_u32.to_le_bytes(), &[0; 36]];
    write("c.pc2", &pc2.concat());
    write("e.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x80\x80\x80\x80\x80");
    place
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_told_and_never_waited_for() {
    let render = |place: &Place, words: &str| afterimage(place, &format!("render --strict -o out/ {words}"));
    let whole = place_of_all_kinds();
    render(&whole, "s.toml --frames 1 --save-store a.store").done();
    for (name, commands) in [
        ("s.toml", &["render s.toml", "info s.toml", "compare s.toml"][..]),
        ("m.obj", &["render s.toml", "render m.obj", "info m.obj", "init m.obj"]),
        ("k.2.obj", &["render s.toml"]),
        ("m.mtl", &["render s.toml", "info m.obj", "init m.obj"]),
        ("t.png", &["render s.toml --strict", "render m.obj --strict"]),
        ("c.pc2", &["info s.toml"]),
        ("e.hdr", &["info s.toml"]),
    ] {
        for what in ["a FIFO", "a device"] {
            let place = place_of_all_kinds();
            fs::remove_file(place.path(name)).unwrap();
            match what {
                "a FIFO" => make_fifo(&place.path(name)),
                _ => std::os::unix::fs::symlink("/dev/zero", place.path(name)).unwrap(),
            }
            for command in commands {
                let ran =
                    afterimage(&place, command).failed(&[name, what, "not a regular file", "give a file"]);
                assert_eq!(ran.stdout, "", "{command}");
            }
            assert!(!place.path("out").exists());
        }
    }
    // a texture has a stand-in
    let place = place_of_all_kinds();
    fs::remove_file(place.path("t.png")).unwrap();
    make_fifo(&place.path("t.png"));
    let ran = afterimage(&place, "info m.obj").done();
    assert!(ran.stderr.contains("t.png` cannot be read: it is a FIFO"), "{}", ran.stderr);

    fs::remove_file(whole.path("a.store")).unwrap();
    make_fifo(&whole.path("a.store"));
    render(&whole, "s.toml --frames 2 --load-store a.store").failed(&["a.store"]);
    make_fifo(&whole.path("b.exr"));
    let frame = whole.names("out").swap_remove(0);
    for files in [format!("b.exr out/{frame}"), format!("out/{frame} b.exr")] {
        let ran = afterimage(&whole, &format!("diff {files}"));
        assert!(ran.code == 2 && ran.stderr.contains("b.exr"), "{ran:?}");
    }
}

/// All but `src/input.rs`, which looks before it opens, and what reads nothing of the user's.
#[test]
fn one_place_opens_what_is_read() {
    const OPENING: [&str; 7] = [
        "File::open",
        "fs::read(",
        "read_to_string",
        "ImageReader::open",
        "image::open",
        "OpenOptions",
        "File::options",
    ];
    const OTHERS: [&str; 7] = [
        "input.rs",
        // what the system tells of itself
        "memory.rs",
        "stats.rs",
        "report/versions.rs",
        // what is written
        "output/staged.rs",
        "output/lock.rs",
        "report/file.rs",
    ];
    let source = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut folders, mut seen) = (vec![source.clone()], 0);
    while let Some(folder) = folders.pop() {
        for entry in folder.read_dir().unwrap().map(Result::unwrap) {
            let path = entry.path();
            let name = path.strip_prefix(&source).unwrap().to_str().unwrap().to_owned();
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(".rs")
                && !name.ends_with("tests.rs")
                && name != "scene/import/obj/oracle.rs"
            {
                let text = fs::read_to_string(&path).unwrap();
                let code = text.split("#[cfg(test)]\nmod tests").next().unwrap();
                let code = code.replace("StoreFile::open", "").replace("UsdFile::open", "");
                let found = OPENING.iter().find(|word| code.contains(**word));
                assert!(found.is_none() || OTHERS.contains(&name.as_str()), "{name}: {found:?}");
                seen += 1;
            }
        }
    }
    assert!(seen > 100, "{seen} files");
}

#[cfg(unix)]
#[test]
fn files_that_may_not_be_read_are_named() {
    use std::os::unix::fs::PermissionsExt;
    let place = place(SHOT, OBJ.as_bytes());
    fs::set_permissions(place.path("m.obj"), fs::Permissions::from_mode(0o000)).unwrap();
    if fs::read(place.path("m.obj")).is_ok() {
        println!("skipped: root may read everything");
        return;
    }
    refused(&place, "s.toml", &["m.obj", "ermission"]);
}

#[test]
fn odd_side_files_are_one_warning_each_and_strictly_errors() {
    let obj = format!("mtllib m.mtl\nusemtl a\n{OBJ}");
    let cases: [(&str, &[u8], &[&str]); 4] = [
        ("t.png", b"no picture", &["m.mtl:2", "t.png"]),
        (
            "t.png",
            b"\x89PNG\r\n\x1a\n\x00\x00\x00\x0dIHDR\xff\xff\xff\xff\xff\xff\xff\xff\x08\x02",
            &["m.mtl:2", "t.png"],
        ),
        ("folder.png", b"", &["m.mtl:2", "folder.png"]),
        ("gone.png", b"", &["m.mtl:2", "gone.png"]),
    ];
    for (name, bytes, words) in cases {
        let place = place(&lit(SHOT), obj.as_bytes());
        fs::write(place.path("m.mtl"), format!("newmtl a\nmap_Kd {name}\n")).unwrap();
        match name {
            "t.png" => fs::write(place.path(name), bytes).unwrap(),
            "folder.png" => fs::create_dir(place.path(name)).unwrap(),
            _ => {}
        }
        render(&place, "s.toml", "--strict").failed(words);
        assert!(!place.path("out").exists());
        let ran = render(&place, "s.toml", "").done();
        assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
        assert!(ran.stderr.starts_with("warning: "), "{}", ran.stderr);
        assert!(words.iter().all(|word| ran.stderr.contains(word)), "{}", ran.stderr);
    }
}

#[test]
fn odd_values_of_materials_are_one_warning_each_and_strictly_errors() {
    let place = place(&lit(SHOT), format!("mtllib m.mtl\nusemtl a\n{OBJ}").as_bytes());
    fs::write(place.path("m.mtl"), "newmtl a\nNs -1.96\nNi -1\nillum 11\n").unwrap();
    render(&place, "s.toml", "--strict").failed(&["m.mtl:2", "`Ns` is `-1.96`"]);
    let ran = render(&place, "s.toml", "").done();
    let lines: Vec<&str> = ran.stderr.lines().filter(|line| line.starts_with("warning: m.mtl:")).collect();
    assert_eq!(lines.len(), 3, "{}", ran.stderr);
    assert!(lines[0].contains(":2: ") && lines[1].contains(":3: ") && lines[2].contains(":4: "), "{lines:?}");

    fs::write(place.path("m.mtl"), format!("newmtl a\n{}", "Ni -1\n".repeat(300))).unwrap();
    let ran = render(&place, "s.toml", "").done();
    assert_eq!(ran.stderr.lines().count(), 2, "{}", ran.stderr);
    assert!(ran.stderr.contains("and 9 more") && ran.stderr.contains("290 more"), "{}", ran.stderr);
}

/// What is extreme but means something renders, exactly and to finite values (the writer takes no others).
#[test]
fn extremes_render() {
    let light = |text: &str| format!("{SHOT}[[light]]\n{text}\n");
    let gathered = |text: &str| format!("{}[indirect]\npaths = 3\n", light(text));
    let moving =
        |scale: &str| format!("{SHOT}[[model.key]]\nframe = 1\n[[model.key]]\nframe = 2\nscale = {scale}\n");
    for (shot, what) in [
        (SHOT.replace("[16, 9]", "[1, 1]"), "one pixel"),
        (SHOT.replace("[16, 9]", "[1, 65]"), "a column"),
        (SHOT.replace("[0, 0, 5]", "[0, 0, 1e17]"), "from afar"),
        (SHOT.replace("[0, 0, 5]", "[0, 0, 1e-4]"), "from very near"),
        (SHOT.replace("[0, 0, 5]", "[0, 5, 0]"), "from straight above"),
        (SHOT.replace("frame = 1\n", "frame = 1\nfov = 179.9\n"), "wide"),
        (SHOT.replace("frame = 1\n", "frame = 1\nfov = 0.0001\n"), "narrow"),
        (moving("1e9"), "grows"),
        (moving("1e-4"), "shrinks"),
        (light("type = \"point\"\nposition = [0.2, 0.2, 0]"), "a lamp in the surface"),
        (light("type = \"point\"\nposition = [0.2, 0.2, 1e-25]"), "a lamp at the surface"),
        (light("type = \"point\"\nposition = [0, 0, 1]\npower = 1e30"), "a bright lamp"),
        (light("type = \"point\"\nposition = [0, 0, 1e18]\npower = 1e30"), "a bright lamp far away"),
        (
            light("type = \"directional\"\ndirection = [0, 0, -1]\ncolor = [1e38, 0, 1]\npower = 1e30"),
            "a bright sun",
        ),
        (
            light("type = \"spot\"\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\ncone = 0.001\nsoft = 0"),
            "a needle of light",
        ),
        (
            light("type = \"rectangle\"\nposition = [0.2, 0.2, 0]\ntarget = [0.2, 0.2, -1]"),
            "a panel in the surface",
        ),
        (
            light("type = \"rectangle\"\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\nsize = [1e9, 1e-9]"),
            "a panel like a thread",
        ),
        (format!("{SHOT}[background]\ncolor = [1e30, 1e30, 1e30]\n"), "a bright sky"),
        (
            gathered("type = \"disk\"\nposition = [0.2, 0.2, 0]\ntarget = [0.2, 0.2, 1]"),
            "a disc in the surface",
        ),
        (gathered("type = \"sphere\"\nposition = [0, 0, 0]\nradius = 1e3"), "all within a sphere of light"),
        (gathered("type = \"sphere\"\nposition = [0, 0, 1]\nradius = 1e-9"), "a sphere like a point"),
        (gathered("type = \"directional\"\ndirection = [0, 0, -1]\nangle = 179.9"), "half of the sky"),
        (gathered("type = \"directional\"\ndirection = [0, 0, -1]\nangle = 0.002"), "a sun like a star"),
        (format!("{SHOT}[indirect]\npaths = 0\nbounces = 3\n"), "no paths"),
        (format!("{SHOT}[indirect]\npaths = 3\nbounces = 0\n"), "paths that meet nothing"),
    ] {
        let place =
            place(&lit(&shot), format!("{OBJ}v 0 0 -1\nv 1 0 -1\nv 0 1 -1\nf 4 5 6\nf 1 3 2\n").as_bytes());
        let ran = render(&place, "s.toml", "--audit -q");
        let told = match what {
            "narrow" => "so narrow",
            "from afar" => "so far",
            _ => "",
        };
        assert!(ran.code == 0 && ran.stderr.contains(told), "{what}: {}", ran.stderr);
        assert_eq!(ran.stderr.is_empty(), told.is_empty(), "{what}: {}", ran.stderr);
        for frame in 1..=2 {
            let image = whole(&place.path(&format!("out/a.{frame:04}.exr")));
            let bad =
                image.channels.iter().find(|channel| channel.data.iter().any(|value| !value.is_finite()));
            assert_eq!(bad.map(|channel| &channel.name), None, "{what}, frame {frame}");
        }
    }
}

/// Thousands of triangles that emit, some without an area, and a lamp that no light leaves.
#[test]
fn whatever_emits_renders() {
    let many = (0..10_000).map(|i| {
        let (x, y) = (f64::from(i % 100) * 0.05 - 2.5, f64::from(i / 100) * 0.05 - 2.5);
        format!("v {x} {y} -2\nv {} {y} -2\nv {x} {} -2\nf -3 -2 -1\n", x + 0.04, y + 0.04)
    });
    let needle =
        "v 0 0 0.5\nv 1e-30 0 0.5\nv 0 1e-30 0.5\nf -3 -2 -1\nv 0 0 0\nv 1 0 0\nv 2 0 0\nf -3 -2 -1\n";
    let many = format!("usemtl lamp\n{}{needle}", many.collect::<String>());
    let corners: String = (0..8).map(|i| format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2)).collect();
    let closed = "usemtl wall\nf -8 -7 -5 -6\nf -4 -3 -1 -2\nf -8 -7 -3 -4\nf -6 -5 -1 -2\nf -8 -6 -2 -4\nf -7 -5 -1 -3\n\
                  usemtl lamp\nv 0.5 0.5 0.4\nv 0.6 0.5 0.4\nv 0.5 0.6 0.5\nf -3 -2 -1\n";
    let closed = format!("{corners}{closed}");
    for (emitters, what) in [(many, "many"), (closed, "closed")] {
        let shot = format!("{SHOT}[indirect]\npaths = 3\n");
        let obj = format!("mtllib m.mtl\nusemtl wall\n{OBJ}f 1 3 2\n{emitters}");
        let place = place(&shot, obj.as_bytes());
        fs::write(
            place.path("m.mtl"),
            "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKe 900 500 1e3\nKd 0 0 0\n",
        )
        .unwrap();
        let ran = render(&place, "s.toml", "--audit -q");
        assert_eq!(ran.code, 0, "{what}: {}", ran.stderr);
        let image = whole(&place.path("out/a.0002.exr"));
        assert!(image.channels.iter().all(|of| of.data.iter().all(|value| value.is_finite())), "{what}");
        let lit = image.channels.iter().find(|of| of.name == "diffuse.G").expect("it is there");
        assert_eq!(lit.data.iter().any(|value| (0.01..500.0).contains(value)), what == "many", "{what}");
    }
}

#[test]
fn damaged_frames_are_told_from_whole_ones() {
    let place = Place::new();
    place.render("-o a.####.exr --frames 1").done();
    let bytes = fs::read(place.path("a.0001.exr")).unwrap();
    let info = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
        Ran::new(command.arg("info").arg(place.path("b.exr")).output().unwrap())
    };
    for length in [0, 3, 8, 100, 700, bytes.len() / 2, bytes.len() - 1] {
        fs::write(place.path("b.exr"), &bytes[..length]).unwrap();
        info().failed(&["b.exr"]);
    }
    // one byte in many places: whatever it means, it is no crash
    for at in (0..bytes.len()).step_by(bytes.len() / 60 + 1).chain(0..40) {
        let mut spoilt = bytes.clone();
        spoilt[at] ^= 0x55;
        fs::write(place.path("b.exr"), &spoilt).unwrap();
        let ran = info();
        assert!(ran.code == 0 || (ran.code == 1 && ran.stderr.contains("b.exr")), "{at}: {}", ran.stderr);
    }
}

/// ESC and CSI begin commands to a terminal, and U+202E turns the text that follows.
const COMMANDS: [&str; 4] = ["\u{1b}]0;title\u{7}", "\u{9b}31m", "\u{7f}", "\u{202e}"];

/// That a terminal shows all of `text`, and some of it is escaped.
#[track_caller]
fn assert_shown(text: &str, what: &str) {
    let obeyed = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
    assert!(!text.contains(obeyed), "{what}: {text:?}");
    assert!(text.contains(r"\u{"), "{what}: {text:?}");
}

#[test]
fn names_are_no_commands_to_the_terminal() {
    let afterimage = |place: &Place, words: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
        Ran::new(command.current_dir(place.0.path()).args(words).output().unwrap())
    };
    let small = ["--frames", "1", "--size", "16x9", "--samples", "1", "--progress", "plain"];
    for odd in COMMANDS {
        let escaped: String = odd.chars().map(|c| format!("\\u{:04X}", c as u32)).collect();
        let light = "[[light]]\ntype = \"point\"\nposition = [0, 0, 1]";
        let shot =
            format!("title = \"t{escaped}\"\n{SHOT}name = \"m{escaped}\"\n{light}\nname = \"l{escaped}\"\n");
        let obj = format!("mtllib m.mtl\nmtllib {odd}.mtl\nusemtl a{odd}\n{OBJ}usemtl gone{odd}\nf 3 2 1\n");
        let place = place(&shot, obj.as_bytes());
        fs::write(place.path("m.mtl"), format!("newmtl a{odd}\nmap_Kd gone{odd}.png\n")).unwrap();

        let info = afterimage(&place, &["info", "s.toml"]).done();
        assert_shown(&info.stdout, "title, model, light, texture");
        assert_shown(&info.stderr, "warnings");
        let output = format!("o{odd}.####.exr");
        let render = afterimage(&place, &[&["render", "s.toml", "-o", &output][..], &small].concat()).done();
        assert_shown(&render.stdout, "files");
        assert_shown(&render.stderr, "warnings of a render");
        assert_shown(
            &afterimage(&place, &["render", "s.toml", "--strict"]).failed(&[]).stderr,
            "a strict error",
        );
        let page = format!("p{odd}.html");
        let words = ["compare", "s.toml", "--backend", "embree", "--report", &page];
        let compare = afterimage(&place, &[&words[..], &small].concat()).done();
        assert_shown(&compare.stdout, "the report's name");
        assert_shown(&fs::read_to_string(place.path(&page)).unwrap(), "the report");
        let odd_shot = format!("{odd}.toml");
        assert_shown(&afterimage(&place, &["info", &odd_shot]).failed(&[]).stderr, "a missing file");
        let usage = afterimage(&place, &["render", "s.toml", "--frames", odd]);
        assert_eq!(usage.code, 2);
        assert_shown(&usage.stderr, "a usage error");
    }
}

#[test]
fn events_keep_names_as_they_are() {
    for odd in COMMANDS {
        let place = place(SHOT, OBJ.as_bytes());
        let ran = Ran::new(place.command(format!("{odd}.toml"), "--progress json").output().unwrap());
        let event: serde_json::Value = serde_json::from_str(&ran.stderr).unwrap();
        assert!(event["message"].as_str().unwrap().contains(odd), "{event}");
    }
}
