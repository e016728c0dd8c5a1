//! What a run of the binary gives: frames, statistics, words; and what they do not depend on.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Stdio};

use openexr::ReadImage;
use serde_json::Value;

use crate::runs;
use crate::runs::{Place, Ran, analytic, assert_same, whole};

/// Frames 1 to 8 of two runs.
#[track_caller]
fn assert_same_frames(place: &Place, one: &str, other: &str) {
    for frame in 1..=8 {
        let path = |folder| place.path(&format!("{folder}/a.{frame:04}.exr"));
        assert_same(&path(one), &path(other));
    }
}

fn statistics(place: &Place, options: &str) -> Value {
    place.render(&format!("-o a.####.exr --stats a.json {options}")).done();
    serde_json::from_slice(&std::fs::read(place.path("a.json")).unwrap()).unwrap()
}

#[track_caller]
fn assert_keys(value: &Value, keys: &str) {
    let found: BTreeSet<&str> = value.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(found, keys.split_whitespace().collect(), "{value}");
}

const SECONDS: &str = "total reproject verify trace light enhance filter write";
const SAMPLES: &str = "base good overlapped missed obscured spare";
const RAYS: &str = "primary verification shadow reflection refraction gathering";
/// All but the first two are ours, beside those that are promised.
const AUDIT: &str = "checked differing on_edge targets coverage coverage_on_edge mirrored";

#[test]
fn statistics_have_the_keys_that_others_rely_on() {
    let json = statistics(&Place::new(), "--audit --frames 1-3");
    assert_keys(&json, "shot settings frames totals memory");
    assert_keys(&json["memory"], "peak_bytes store_bytes bytes_per_sample");
    assert_keys(&json["totals"], "seconds samples rays tracing audit");
    let frames = json["frames"].as_array().unwrap();
    assert_eq!(frames.iter().map(|frame| frame["frame"].as_i64()).collect::<Vec<_>>(), [1, 2, 3].map(Some));
    assert_eq!(
        frames.iter().map(|frame| &frame["mode"]).collect::<Vec<_>>(),
        ["base", "reproject", "reproject"]
    );
    for part in frames.iter().chain([&json["totals"]]) {
        assert_keys(&part["seconds"], SECONDS);
        assert_keys(&part["samples"], SAMPLES);
        assert_keys(&part["rays"], RAYS);
        assert_keys(&part["tracing"], "primary verification shadow bounced");
        assert_keys(&part["audit"], AUDIT);
    }
    frames.iter().for_each(|frame| assert_keys(frame, "frame mode seconds samples rays tracing audit"));
    let plain = statistics(&Place::new(), "--frames 1");
    assert_keys(&plain["frames"][0], "frame mode seconds samples rays tracing");
    assert_keys(&plain["totals"], "seconds samples rays tracing");
}

#[test]
fn statistics_add_up() {
    let json = statistics(&Place::new(), "--audit --frames 1-4");
    let frames = json["frames"].as_array().unwrap();
    for (part, keys) in [("samples", SAMPLES), ("rays", RAYS), ("audit", AUDIT), ("seconds", SECONDS)] {
        for key in keys.split_whitespace() {
            let sum: f64 = frames.iter().map(|frame| frame[part][key].as_f64().unwrap()).sum();
            let total = json["totals"][part][key].as_f64().unwrap();
            assert!((sum - total).abs() < 1e-9 * total.max(1.0), "{part}.{key}: {sum}, not {total}");
        }
    }
    let cells = 64 * 36 * 4;
    for frame in frames {
        let of = |part: &str, key: &str| frame[part][key].as_u64().unwrap();
        // spare samples serve no cell
        let cells_by_status = SAMPLES.split_whitespace().filter(|key| *key != "spare");
        let samples: u64 = cells_by_status.map(|key| of("samples", key)).sum();
        assert_eq!((samples, of("audit", "checked"), of("audit", "differing")), (cells, cells, 0));
        // the old name of `light` is the same time once more
        let phases = SECONDS.split_whitespace().skip(1).filter(|key| *key != "enhance");
        let phases = phases.map(|key| frame["seconds"][key].as_f64().unwrap());
        assert!(phases.sum::<f64>() <= frame["seconds"]["total"].as_f64().unwrap() * 1.001, "{frame}");
    }
    let memory = &json["memory"];
    let store = memory["store_bytes"].as_f64().unwrap();
    assert!(0.0 < store && store < memory["peak_bytes"].as_f64().unwrap());
    let each = memory["bytes_per_sample"].as_f64().unwrap();
    assert!((each * cells as f64 - store).abs() < 1.0, "{memory}");
}

#[test]
fn full_mode_reuses_nothing() {
    let json = statistics(&Place::new(), "--mode full --frames 1-3");
    for frame in json["frames"].as_array().unwrap() {
        assert_eq!(frame["mode"], "full");
        for key in SAMPLES.split_whitespace().skip(1) {
            assert_eq!(frame["samples"][key], 0, "{key}");
        }
        assert_eq!(
            (&frame["rays"]["verification"], &frame["rays"]["primary"]),
            (&0.into(), &(64 * 36 * 4).into())
        );
    }
}

#[test]
fn frames_do_not_depend_on_the_number_of_threads() {
    let place = Place::new();
    place.render("-o one/a.####.exr --layers all --threads 1").done();
    place.render("-o three/a.####.exr --layers all --threads 3").done();
    assert_same_frames(&place, "one", "three");
}

#[test]
fn frames_do_not_depend_on_chunks() {
    let place = Place::new();
    for (every, run_up) in [(0, "run-up: 4 frames from 1"), (3, "run-up: 1 frame from 4")] {
        let options = format!("--base-every {every} --mode reproject --layers all");
        place.render(&format!("-o all/a.####.exr {options}")).done();
        place.render(&format!("-o chunks/a.####.exr {options} --frames 1-4")).done();
        let second = place.render(&format!("-o chunks/a.####.exr {options} --frames 5-8")).done();
        for words in [run_up, "--mode full needs no run-up", "--base-every makes it shorter"] {
            assert!(second.stderr.contains(words), "{}", second.stderr);
        }
        assert_same_frames(&place, "all", "chunks");
    }
}

/// `compare` of the analytic shot with Embree.
fn compare(place: &Place, options: &str) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    command.current_dir(place.path("")).arg("compare").arg(analytic()).args(["--backend", "embree"]);
    Ran::new(command.args(options.split_whitespace()).output().unwrap()).done()
}

#[test]
fn compare_writes_the_frames_that_render_writes() {
    let place = Place::new();
    place.render("-o render/a.####.exr").done();
    for threads in [1, 3] {
        compare(&place, &format!("-o compare/a.####.exr --json a.json --threads {threads}"));
        assert_same_frames(&place, "render", "compare");
        assert_eq!(place.names("compare").len(), 8, "nothing else is left");
        let json: Value = serde_json::from_slice(&std::fs::read(place.path("a.json")).unwrap()).unwrap();
        for frame in json["frames"].as_array().unwrap() {
            let seconds = |way: &str| frame[way]["seconds"]["write"].as_f64().unwrap();
            assert!(seconds("reprojected") > 0.0 && seconds("full") == 0.0, "writing is told: {frame}");
        }
    }
}

#[test]
fn compare_tells_of_frames_when_their_files_are_there_and_of_run_up_without() {
    let place = Place::new();
    let ran = compare(&place, "-o a.####.exr --frames 3,4,7 --base-every 0 --progress json");
    let events = ran.stderr.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let frames: Vec<Value> = events.filter(|event| event["event"] == "frame").collect();
    let told: Vec<_> =
        frames.iter().map(|event| (event["frame"].as_i64().unwrap(), event["file"].as_str())).collect();
    let file = |frame, name| (frame, Some(name));
    let wanted = [
        (1, None),
        (2, None),
        file(3, "a.0003.exr"),
        file(4, "a.0004.exr"),
        (5, None),
        (6, None),
        file(7, "a.0007.exr"),
    ];
    assert_eq!(told, wanted);
    let rows: Vec<&str> = ran.stdout.lines().skip(1).take(3).map(|row| row.trim_start()).collect();
    assert!(rows.iter().zip(["3 ", "4 ", "7 "]).all(|(row, start)| row.starts_with(start)), "{}", ran.stdout);
    // it has no --mode to advise
    let note = ran.stderr.lines().find(|line| line.contains("run-up:")).unwrap();
    assert!(note.contains("--base-every") && !note.contains("--mode"), "{note}");
}

#[test]
fn a_run_up_is_told_apart_in_the_statistics() {
    let json = statistics(&Place::new(), "--frames 3");
    assert_eq!(json["frames"].as_array().unwrap().len(), 1);
    assert_keys(&json["run_up"], "seconds samples rays tracing");
    assert_eq!(json["run_up"]["samples"]["base"], 64 * 36 * 4);
    assert_eq!(json["totals"]["samples"], json["frames"][0]["samples"]);
}

#[test]
fn the_command_line_beats_the_shot() {
    let place = Place::new();
    place.render("-o x/b.%03d.exr --frames 2-6x4 --size 20x10 --samples 1 --png").done();
    assert_eq!(place.names("x"), ["b.002.exr", "b.002.png", "b.006.exr", "b.006.png"]);
    let frame = whole(&place.path("x/b.006.exr"));
    assert_eq!((frame.width, frame.height), (20, 10));
    assert_eq!(image::open(place.path("x/b.006.png")).unwrap().to_rgb8().dimensions(), (20, 10));
    place.render("--frames 8").done();
    assert_eq!(place.names("out"), ["analytic.0008.exr"], "the shot's own name");
}

#[test]
fn windows_say_what_part_of_the_picture_is_there() {
    let place = Place::new();
    let common = "--frames 3 --mode full --layers all --png";
    for (name, options) in [
        ("all", ""),
        ("crop", "--crop 20x9+31+17"),
        ("more", "--overscan 6"),
        ("parts", "--overscan 6 --multipart"),
    ] {
        place.render(&format!("-o {name}.####.exr {common} {options}")).done();
    }
    let frame = |name: &str| whole(&place.path(&format!("{name}.0003.exr")));
    let all = frame("all");
    let attribute = |image: &ReadImage, name: &str| image.attribute(name).cloned();
    for (name, origin, size) in [
        ("all", [0, 0], [64, 36]),
        ("crop", [31, 17], [20, 9]),
        ("more", [-6, -6], [76, 48]),
        ("parts", [-6, -6], [76, 48]),
    ] {
        let part = frame(name);
        assert_eq!((part.origin, [part.width, part.height]), (origin, size));
        assert_eq!(part.display, [0, 0, 63, 35], "{name}");
        assert_eq!(attribute(&part, "worldToNDC"), attribute(&all, "worldToNDC"), "{name}");
        for channel in &part.channels {
            let wanted = all.channel(&channel.name).unwrap();
            for (x, y) in (0..36).flat_map(|y| (0..64).map(move |x| (x, y))) {
                let [column, row] = [x - origin[0], y - origin[1]];
                if (0..size[0] as i32).contains(&column) && (0..size[1] as i32).contains(&row) {
                    let value = channel.data[row as usize * size[0] as usize + column as usize];
                    let of_all = wanted.data[(y * 64 + x) as usize];
                    assert_eq!(value.to_bits(), of_all.to_bits(), "{name}: {} {x} {y}", channel.name);
                }
            }
        }
        let preview = image::open(place.path(&format!("{name}.0003.png"))).unwrap().to_rgb8();
        assert_eq!(preview.dimensions(), (size[0], size[1]));
    }
}

#[test]
fn results_and_progress_have_a_stream_each() {
    let place = Place::new();
    let plain = place.render("-o a.####.exr --frames 1-2 --progress plain").done();
    assert!(plain.stdout.contains("reused%") && !plain.stdout.contains("[1/2]"), "{}", plain.stdout);
    assert_eq!(plain.stderr.lines().count(), 2, "{}", plain.stderr);
    assert!(plain.stderr.starts_with("[1/2] frame 1: base"), "{}", plain.stderr);
    let json = place.render("-o a.####.exr --frames 1-2 --progress json").done();
    let events: Vec<Value> = json.stderr.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let kinds: Vec<_> = events.iter().map(|event| event["event"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["start", "frame", "frame", "end"]);
    assert!(!json.stdout.contains("event"), "{}", json.stdout);
    let none = place.render("-o a.####.exr --frames 1-2 --progress none").done();
    assert_eq!(none.stderr, "");
    // no terminal: no bar
    assert_eq!(place.render("-o a.####.exr --frames 1-2").done().stderr, "");
    let quiet = place.render("-o a.####.exr --frames 1-2 -q").done();
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
    let quiet = place.render("-o a.####.exr --frames 1-2 -q --progress plain").done();
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
}

#[test]
fn a_reader_that_leaves_does_not_end_the_run() {
    let place = Place::new();
    let mut command = place.command(runs::analytic(), "-o a.####.exr --progress plain");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let ran = Ran::new(child.wait_with_output().unwrap()).done();
    assert_eq!(ran.stderr.lines().count(), 8, "{}", ran.stderr);
    assert_eq!(place.names("").len(), 8);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop((child.stdout.take(), child.stderr.take()));
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[test]
fn names_that_make_no_sense_are_usage_errors() {
    let place = Place::new();
    for (options, why) in [
        ("-o a.##.##.exr", "a.##.##.exr"),
        ("-o a.####.png", "--png"),
        ("-o a#/b.exr", "a#/b.exr"),
        ("--frames 2147483647 --base-every 0", "--frames"),
        ("--size 65535x65535 --samples 16", "--size"),
        ("--crop 8x8+60+0", "64x36"),
        ("--crop 0x8+0+0", "64x36"),
        ("--crop 8x8", "WxH"),
        ("--crop 8x8-1+0", "64x36"),
        ("--overscan 2 --crop 8x8-3+0", "68x40-2-2"),
        ("--overscan 20000", "16384"),
    ] {
        let ran = place.render(options);
        assert_eq!((ran.code, ran.stdout.as_str()), (2, ""), "{options}: {}", ran.stderr);
        assert!(ran.stderr.contains(why), "{options}: {}", ran.stderr);
        assert!(place.names("").is_empty(), "{options}");
    }
}

#[test]
#[cfg_attr(not(openexr_tools), ignore = "needs exrheader: set AFTERIMAGE_OPENEXR_TOOLS")]
fn exrheader_reads_every_channel() {
    let tools = std::env::var("AFTERIMAGE_OPENEXR_TOOLS").expect("it names a folder with exrheader");
    let place = Place::new();
    place.render("-o a.####.exr --frames 2").done();
    let exrheader = Path::new(&tools).join("exrheader");
    let output = Command::new(&exrheader).arg(place.path("a.0002.exr")).output();
    let output = output.unwrap_or_else(|error| panic!("{}: {error}", exrheader.display()));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{text}");
    assert!(text.contains("zip, individual scanlines"), "{text}");
    let frame = whole(&place.path("a.0002.exr"));
    assert_eq!(frame.channels.len(), 12);
    for channel in &frame.channels {
        assert!(text.lines().any(|line| line.trim().starts_with(&format!("{}, ", channel.name))), "{text}");
    }
    for attribute in ["worldToCamera", "worldToNDC", "framesPerSecond", "imageCounter", "timeCode"] {
        assert!(text.contains(attribute), "{attribute}");
    }
}

/// A shot of one triangle whose two materials ask for the same picture, which is not there.
fn without_its_texture(place: &Place) {
    let write = |name: &str, text: &str| std::fs::write(place.path(name), text).unwrap();
    write("m.mtl", "newmtl a\nmap_Kd gone.png\nnewmtl b\nmap_Kd gone.png\n");
    write("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 3 2 1\n");
}

#[test]
fn a_missing_texture_is_one_warning_and_strictly_an_error() {
    let place = Place::new();
    without_its_texture(&place);
    let options = "--frames 1 --size 16x9 -o out/a.####.exr";
    let strict = Ran::new(place.command("m.obj", &format!("{options} --strict")).output().unwrap());
    strict.failed(&["m.mtl:2", "gone.png"]);
    assert!(!place.path("out").exists());
    let ran = Ran::new(place.command("m.obj", &format!("{options} -q")).output().unwrap()).done();
    assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
    assert!(ran.stderr.starts_with("warning: m.mtl:2: "), "{}", ran.stderr);
    assert!(ran.stderr.contains("gone.png"), "{}", ran.stderr);
    whole(&place.path("out/a.0001.exr"));
}
