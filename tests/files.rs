//! What stands at the paths that a run writes to: what it replaces, writes into, removes, or leaves alone.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod program;

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use program::{Place, Ran, whole};

/// One small frame of the analytic shot.
const ONE: &str = "--frames 1 --size 16x9 --samples 1";

/// Runs `command`, which must end by itself before long.
fn ended(mut command: Command) -> Ran {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("it does not end: {command:?}");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    Ran::of(child.wait_with_output().unwrap())
}

fn make_fifo(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

#[test]
fn what_is_no_file_under_a_frames_name_is_told_at_the_start() {
    for (name, options) in [("a.0001.exr", ""), ("a.0001.exr", "--resume"), ("a.0001.png", "--png --resume")]
    {
        let run = |place: &Place| {
            let ran = ended(place.command(program::analytic(), &format!("-o a.####.exr {ONE} {options}")));
            assert_eq!(ran.failed(&[name, "remove it", "-o"]).stdout, "");
            assert!(
                place.names("").iter().all(|found| found == name || found == "fifo"),
                "{:?}",
                place.names("")
            );
        };
        let fifo = Place::new();
        make_fifo(&fifo.path(name));
        run(&fifo);
        let link = Place::new();
        make_fifo(&link.path("fifo"));
        symlink("fifo", link.path(name)).unwrap();
        run(&link);
        let folder = Place::new();
        fs::create_dir(folder.path(name)).unwrap();
        run(&folder);
    }
}

#[test]
fn names_of_other_frames_do_not_matter() {
    let place = Place::new();
    make_fifo(&place.path("a.0002.exr"));
    make_fifo(&place.path("a.0001.png"));
    symlink("gone.exr", place.path("a.0001.exr")).unwrap();
    ended(place.command(program::analytic(), &format!("-o a.####.exr {ONE} --resume"))).done();
    whole(&place.path("a.0001.exr"));
    assert!(!place.path("gone.exr").exists(), "the link itself was replaced");
}

#[test]
fn info_opens_no_fifo() {
    let place = Place::new();
    make_fifo(&place.path("a.exr"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    command.arg("info").arg(place.path("a.exr"));
    ended(command).failed(&["a.exr", "regular file"]);
}

#[test]
fn what_killed_runs_left_goes_with_the_next_run_of_the_frame() {
    let place = Place::new();
    place.render(&format!("-o a.####.exr {ONE} --png")).done();
    for name in
        [".a.0001.exr.4711-0.part", ".a.0001.png.4711.part", ".a.0001.exr.Xy12zQ.part", ".a.0009.exr.1.part"]
    {
        fs::write(place.path(name), "half").unwrap();
    }
    place.render(&format!("-o a.####.exr {ONE} --png --resume")).done();
    assert_eq!(place.names(""), [".a.0009.exr.1.part", "a.0001.exr", "a.0001.png"]);
}
