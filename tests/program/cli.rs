//! The binary itself: exit codes, messages, help. What needs a tracer is tested elsewhere.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn afterimage(words: &[&str]) -> Output {
    in_folder(Path::new("."), words)
}

fn in_folder(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    command.current_dir(folder).args(words).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("it ended by itself")
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[test]
fn help_is_a_result() {
    for words in [&["--help"][..], &["render", "--help"], &["compare", "--help"], &["info", "--help"]] {
        let output = afterimage(words);
        assert_eq!((code(&output), stderr(&output)), (0, String::new()), "{words:?}");
        assert!(stdout(&output).contains("Usage:"), "{words:?}");
    }
    for (command, option) in [("render", "--resume"), ("compare", "--report"), ("render", "Examples:")] {
        assert!(stdout(&afterimage(&[command, "--help"])).contains(option), "{command} {option}");
    }
}

#[test]
fn the_version_is_a_result() {
    let output = afterimage(&["--version"]);
    assert_eq!(code(&output), 0);
    assert!(stdout(&output).starts_with("afterimage "));
}

#[test]
fn nonsense_is_a_usage_error_and_says_why() {
    for (words, why) in [
        (&[][..], "Usage:"),
        (&["paint"], "paint"),
        (&["render"], "SHOT"),
        (&["render", "a.toml", "--frames", "9-1"], "backwards"),
        (&["render", "a.toml", "--size", "big"], "1280x720"),
        (&["render", "a.toml", "--samples", "0"], "samples"),
        (&["render", "a.toml", "--threads", "0"], "threads"),
        (&["render", "a.toml", "--mode", "fast"], "reproject"),
        (&["render", "a.toml", "--backend", "cuda"], "embree"),
        (&["render", "a.toml", "--no-such-option"], "--no-such-option"),
        (&["compare", "a.toml", "--png"], "-o"),
    ] {
        let output = afterimage(words);
        assert_eq!((code(&output), stdout(&output)), (2, String::new()), "{words:?}");
        assert!(stderr(&output).contains(why), "{words:?}: {}", stderr(&output));
    }
}

#[test]
fn a_reference_tells_the_error_of_both_ways() {
    let folder = tempfile::tempdir().unwrap();
    let [json, html] = ["a.json", "a.html"].map(|name| folder.path().join(name).display().to_string());
    let shot = "compare scenes/analytic/panel.toml --size 48x27 --frames 1-3 --samples 2 \
                --backend embree --progress none";
    let words = |more: &'static str| shot.split(' ').filter(|word| !word.is_empty()).chain(more.split(' '));
    for (samples, code_and_why) in [("2", (2, "--reference 2")), ("17", (2, "1..=16"))] {
        let words: Vec<&str> = words("--reference").chain([samples]).collect();
        let output = afterimage(&words);
        assert_eq!(code(&output), code_and_why.0);
        assert!(stderr(&output).contains(code_and_why.1), "{}", stderr(&output));
    }
    let words: Vec<&str> = words("--reference 6 --json").chain([&*json, "--report", &html]).collect();
    let output = afterimage(&words);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("reprojected at equal error"), "{}", stdout(&output));
    let page = fs::read_to_string(html).unwrap();
    assert!(page.contains("at equal error"));
    let made: serde_json::Value = serde_json::from_str(&fs::read_to_string(json).unwrap()).unwrap();
    let display =
        |frame: usize, way: &str| made["frames"][frame]["error"][way]["display"].as_f64().expect("measured");
    assert_eq!(display(0, "reprojected"), display(0, "full"), "frame 1 is a base frame");
    for (frame, mode) in
        (1..).zip(made["frames"].as_array().unwrap().iter().map(|frame| &frame["reprojected"]["mode"]))
    {
        let is_shown = page.contains(&format!("<h3>Frame {frame}</h3>"));
        assert_eq!(
            is_shown,
            mode == "reproject",
            "frame {frame} is {mode}: the report shows what was reused"
        );
    }
    for frame in 0..3 {
        let full = display(frame, "full");
        assert!(full > 1e-4 && full < 0.1 && display(frame, "reprojected") < 4.0 * full, "{made}");
    }
    assert_eq!(
        (made["reference"]["samples"].as_u64(), made["reference"]["all"]["frames"].as_u64()),
        (Some(6), Some(3))
    );
    assert!(made["reference"]["inferred"]["speed_up_at_equal_error"].as_f64().unwrap() > 0.0);
}

#[test]
fn a_missing_file_is_named_in_one_line() {
    for command in ["render", "compare", "info"] {
        for file in ["no/such.toml", "no/such.obj"] {
            let output = afterimage(&[command, file]);
            assert_eq!(code(&output), 1, "{command} {file}");
            let text = stderr(&output);
            assert!(text.starts_with("error: ") && text.contains(file), "{command}: {text}");
            assert_eq!(text.lines().count(), 1, "{text}");
        }
    }
}

#[test]
fn info_refuses_what_it_does_not_know() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.txt"), "x").unwrap();
    let output = in_folder(folder.path(), &["info", "a.txt"]);
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("a.txt"));
    let output = in_folder(folder.path(), &["info", "none.exr"]);
    assert_eq!(code(&output), 1);
}

#[test]
fn info_tells_where_frames_would_go() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy("scenes/analytic/triangle.obj", folder.path().join("t.obj")).unwrap();
    let shot = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n[[model]]\nobj = \"t.obj\"\n";
    fs::write(folder.path().join("walk.toml"), shot).unwrap();
    let output = in_folder(folder.path(), &["info", "walk.toml"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("output      out/walk/walk.####.exr"), "{}", stdout(&output));
}

#[test]
fn info_names_versions_and_processor() {
    let output = afterimage(&["info"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    for part in ["afterimage", "Embree", "OpenEXR", "CPU"] {
        assert!(stdout(&output).contains(part), "{part}");
    }
}

#[test]
fn errors_are_json_where_progress_is() {
    let output = afterimage(&["render", "no/such.toml", "--progress", "json"]);
    assert_eq!(code(&output), 1);
    let event: serde_json::Value = serde_json::from_str(stderr(&output).trim()).unwrap();
    assert_eq!(event["event"], "error");
    assert!(event["message"].as_str().unwrap().contains("no/such.toml"));
}

#[test]
fn a_closed_pipe_is_no_error() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    let mut child = command.arg("info").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((code(&output), stderr(&output)), (0, String::new()));
}

#[test]
fn a_result_that_cannot_be_printed_is_a_failure_of_each_command() {
    let folder = tempfile::tempdir().unwrap();
    let shot = crate::runs::analytic().display().to_string();
    let render = format!("render {shot} --frames 1-2 --size 16x9 --mode full -o f.####.exr");
    assert_eq!(code(&in_folder(folder.path(), &render.split(' ').collect::<Vec<_>>())), 0);
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    fs::write(folder.path().join("m.obj"), obj).unwrap();
    for (words, expected) in [
        ("--help", 1),
        ("--version", 1),
        ("render --help", 1),
        ("info", 1),
        (&format!("info {shot}"), 1),
        ("info f.0001.exr", 1),
        ("verify f.####.exr", 1),
        ("diff f.0001.exr f.0001.exr", 2),
        ("completions bash", 1),
        ("man", 1),
        ("man -o pages", 1),
        ("schema", 1),
        ("init m.obj", 1),
        (&format!("farm {shot} --engine slurm"), 1),
        ("preview m.obj --port 0", 1),
        (&render, 1),
    ] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
        let output = command
            .current_dir(folder.path())
            .args(words.split(' '))
            .stdout(full)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        let said = stderr(&output);
        assert_eq!(code(&output), expected, "{words}: {said}");
        let last = said.lines().last().unwrap_or_default();
        assert!(last.starts_with("error: cannot print the result: No space left"), "{words}: {said}");
    }
}

#[test]
fn settings_of_embree_that_would_be_passed_over_are_told() {
    for (settings, words) in
        [("ISA=AVX2", "write `isa`"), ("isa=avx3", "`isa=avx3`"), ("verbose", "NAME=VALUE")]
    {
        for command in ["info", "render no/such.toml"] {
            let mut program = Command::new(env!("CARGO_BIN_EXE_afterimage"));
            program.args(command.split(' ')).env("AFTERIMAGE_EMBREE_CONFIG", settings);
            let output = program.output().unwrap();
            let said = stderr(&output);
            assert_eq!(code(&output), 2, "{said}");
            assert!(said.starts_with("error: AFTERIMAGE_EMBREE_CONFIG: ") && said.contains(words), "{said}");
        }
    }
    let mut program = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    let output = program.arg("info").env("AFTERIMAGE_EMBREE_CONFIG", "isa=SSE2").output().unwrap();
    assert!(stdout(&output).contains("sse2"), "{}", stdout(&output));
}
