//! What does not fit into memory is refused with its size before it is begun, and never ends the program by a signal.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::runs::{Place, Ran, analytic};

/// The program in `place`, with so many MiB of addresses (`ulimit -v`).
fn limited(place: &Place, mib: u64, arguments: &[&str]) -> Ran {
    let mut shell = Command::new("sh");
    let script = format!("ulimit -v {} && exec \"$@\"", mib * 1024);
    shell.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_afterimage")]).args(arguments);
    Ran::new(shell.current_dir(place.0.path()).output().unwrap())
}

fn limited_render(place: &Place, mib: u64, options: &str) -> Ran {
    let shot = analytic();
    let mut arguments = vec!["render", shot.to_str().unwrap(), "--threads", "1"];
    arguments.extend(options.split_whitespace());
    limited(place, mib, &arguments)
}

#[test]
fn frames_that_do_not_fit_are_refused_with_their_size() {
    let place = Place::new();
    let options = "-o out/a.####.exr --size 16000x9000 --samples 4 --frames 1";
    let words = ["GiB", "4x4 samples a pixel at 16000x9000", "ulimit -v", "a smaller --size"];
    limited_render(&place, 2048, options).failed(&words);
    assert!(!place.path("out").exists());
    // one renderer would fit, four do not
    let shot = analytic();
    let mut arguments = vec!["compare", shot.to_str().unwrap()];
    arguments.extend("--threads 1 --size 1920x1080 --samples 1 --frames 1".split(' '));
    limited(&place, 1024, &arguments).failed(&["planes of the picture", "ulimit -v"]);
}

/// The MiB of `about … MiB of memory`.
fn foreseen(ran: &Ran) -> f64 {
    let (_, text) = ran.stderr.split_once("about ").unwrap();
    let mut words = text.split(' ');
    let number: f64 = words.next().unwrap().parse().unwrap();
    if words.next() == Some("GiB") { 1024.0 * number } else { number }
}

#[test]
fn what_is_foreseen_is_within_a_fifth_of_what_is_taken() {
    let place = Place::new();
    let size = "-o out/a.####.exr --size 1280x720 --samples 2 -q";
    for options in ["--frames 1", "--frames 1-2 --mode reproject", "--frames 1-5", "--frames 1-2 --mode full"]
    {
        let options = format!("{size} {options}");
        let foreseen = foreseen(&limited_render(&place, 230, &options).failed(&["2x2 samples a pixel"]));
        limited_render(&place, 8192, &format!("{options} --stats s.json")).done();
        let stats: serde_json::Value =
            serde_json::from_slice(&fs::read(place.path("s.json")).unwrap()).unwrap();
        let taken = stats["memory"]["peak_bytes"].as_f64().unwrap() / f64::from(1 << 20);
        println!("{options}: {foreseen:.0} MiB foreseen, {taken:.0} MiB taken");
        assert!((0.8..=1.2).contains(&(foreseen / taken)), "{options}: {foreseen} MiB, taken {taken} MiB");
    }
}

#[test]
fn remedies_are_told_once_and_only_those_that_help() {
    let place = Place::new();
    let options = "-o out/a.####.exr --size 4000x3000 --samples 2 --frames 1-2 --layers all";
    let ran = limited_render(&place, 800, options).failed(&[": try "]);
    let (_, remedies) = ran.stderr.trim_end().rsplit_once(": try ").unwrap();
    for remedy in ["a smaller --size", "fewer --samples", "fewer --layers"] {
        assert_eq!(remedies.matches(remedy).count(), 1, "{remedies}");
    }
    assert!(!remedies.contains("--threads"), "{remedies}");
}

#[test]
fn no_limit_ends_the_program_by_a_signal() {
    let place = Place::new();
    let mut codes = Vec::new();
    for mib in (100..=900).step_by(100) {
        // `Ran` takes no signal for an end
        let options = "-o out/a.####.exr --size 960x540 --samples 2 --frames 1-2 --mode reproject";
        let ran = limited_render(&place, mib, options);
        assert!(ran.code == 0 || ran.code == 1 && ran.stderr.starts_with("error: "), "{mib}: {ran:?}");
        codes.push(ran.code);
    }
    assert!(codes.is_sorted_by_key(|code| -code) && codes.contains(&1), "{codes:?}");
    assert_eq!(codes.last(), Some(&0), "there is room in 900 MiB");
}

/// Sparse files: long, and nowhere on the disk.
#[test]
fn files_that_are_too_long_are_not_read() {
    let place = Place::new();
    let sparse = |name: &str, begin: &str, bytes: u64| {
        fs::write(place.path(name), begin).unwrap();
        fs::OpenOptions::new().write(true).open(place.path(name)).unwrap().set_len(bytes).unwrap();
    };
    let refused = |command: &[&str], words: &[&str]| limited(&place, 400, command).failed(words);
    sparse("s.toml", "", 500 << 20);
    refused(&["render", "s.toml"], &["s.toml: ", "500 MiB", "a shot file may have 16 MiB"]);
    fs::write(place.path("s.toml"), format!("x = [{}]", "1,".repeat(5 << 20))).unwrap();
    refused(&["render", "s.toml"], &["s.toml: ", "reading the shot file 64"]);
    for begin in ["", "v 0 0 0\n"] {
        sparse("m.obj", begin, 100 << 30);
        refused(&["info", "m.obj"], &["m.obj: ", "100.0 GiB of memory", "a smaller model"]);
        refused(&["init", "m.obj"], &["m.obj: ", "100.0 GiB of memory"]);
    }
    fs::write(place.path("m.obj"), "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n").unwrap();
    sparse("m.mtl", "newmtl a\n", 1 << 30);
    refused(&["info", "m.obj"], &["m.mtl: ", "1.0 GiB", "an MTL file may have 256 MiB"]);
    sparse("m.mtl", "newmtl a\n", 250 << 20);
    refused(&["info", "m.obj"], &["m.mtl: ", "500 MiB of memory"]);
    fs::write(place.path("m.mtl"), "newmtl a\nmap_Kd t.jpg\n").unwrap();
    sparse("t.jpg", "\u{7f}", 2 << 30);
    refused(&["render", "m.obj"], &["m.mtl:2: ", "t.jpg", "2.0 GiB of memory"]);
}

/// The picture of a run-length coded BMP may be of any size in a few bytes.
#[test]
fn textures_that_cannot_be_are_not_decoded() {
    let place = Place::new();
    let edge = 25_000_u32.to_le_bytes();
    let mut bytes = b"BM\x38\x04\0\0\0\0\0\0\x36\x04\0\0\x28\0\0\0".to_vec();
    bytes.extend([edge, edge].concat());
    bytes.extend(b"\x01\0\x08\0\x01\0\0\0\x02\0\0\0\0\0\0\0\0\0\0\0\0\x01\0\0\0\0\0\0");
    bytes.extend([0; 1024]);
    bytes.extend([0, 1]);
    fs::write(place.path("t.bmp"), bytes).unwrap();
    fs::write(place.path("m.mtl"), "newmtl a\nmap_Kd t.bmp\n").unwrap();
    fs::write(place.path("m.obj"), "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n").unwrap();
    let ran = limited(&place, 1500, &["info", "m.obj"]).done();
    let words = ["warning: m.mtl:2: the texture `t.bmp` of 25000x25000 texels", "cannot be in a file of"];
    assert!(words.iter().all(|word| ran.stderr.contains(word)), "{}", ran.stderr);
    limited(&place, 1500, &["render", "m.obj", "--strict"]).failed(&["m.mtl:2", "25000x25000"]);
}

/// Makes the header of a frame claim 30000 x 30000 pixels.
fn enlarge(from: &Path, to: &Path, more_bytes: usize) {
    let mut bytes = fs::read(from).unwrap();
    for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
        let at = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4;
        bytes[at..at + 16].copy_from_slice(&[0_i32, 0, 29_999, 29_999].map(i32::to_le_bytes).concat());
    }
    bytes.extend(vec![0; more_bytes]);
    fs::write(to, bytes).unwrap();
}

#[test]
fn frames_that_claim_to_be_large_are_not_held() {
    let place = Place::new();
    place.render("-o a.####.exr --frames 1 --layers none").done();
    let whole = place.path("a.0001.exr");
    enlarge(&whole, &place.path("b.0001.exr"), 0);
    limited(&place, 500, &["info", "b.0001.exr"]).failed(&["b.0001.exr", "30000x30000", "cut short"]);
    // long enough for the claim
    enlarge(&whole, &place.path("b.0001.exr"), 1 << 20);
    limited(&place, 500, &["info", "b.0001.exr"]).failed(&["b.0001.exr", "read the pixels"]);
    // a frame of another size is not read at all, and one of its size line by line
    place.render("-o b.####.exr --frames 1 --layers none --resume").done();
    assert_eq!(fs::read(&whole).unwrap().len(), fs::read(place.path("b.0001.exr")).unwrap().len());
    enlarge(&whole, &place.path("b.0001.exr"), 1 << 20);
    let size = "-o b.####.exr --frames 1 --layers none --resume --size 30000x30000 --samples 1";
    limited_render(&place, 700, size).failed(&["30000x30000"]);
}
