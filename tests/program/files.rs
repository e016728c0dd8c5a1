//! What stands at the paths that a run writes to: what it replaces, writes into, removes, or leaves alone.

use std::fs;
use std::os::unix::fs::{FileTypeExt, symlink};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use rustix::fs::{CWD, FileType, Mode, makedev, mknodat};

use crate::runs;
use crate::runs::{Place, Ran, ended, make_fifo, whole};

/// One small frame of the analytic shot.
const ONE: &str = "--frames 1 --size 16x9 --samples 1";

#[test]
fn what_is_no_file_under_a_frames_name_is_told_at_the_start() {
    for (name, options) in [("a.0001.exr", ""), ("a.0001.exr", "--resume"), ("a.0001.png", "--png --resume")]
    {
        let run = |place: &Place| {
            let ran = ended(place.command(runs::analytic(), &format!("-o a.####.exr {ONE} {options}")));
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
    ended(place.command(runs::analytic(), &format!("-o a.####.exr {ONE} --resume"))).done();
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
    for name in [
        ".a.0001.exr.4711-0.part",
        ".a.0001.png.4711.part",
        ".a.0001.exr.Xy12zQ34abCd.part",
        ".a.0009.exr.1.part",
    ] {
        fs::write(place.path(name), "half").unwrap();
    }
    place.render(&format!("-o a.####.exr {ONE} --png --resume")).done();
    assert_eq!(place.names(""), [".a.0009.exr.1.part", "a.0001.exr", "a.0001.png"]);
}

/// Renders one frame with `--stats NAME`.
fn with_stats(place: &Place, name: &str) -> Ran {
    ended(place.command(runs::analytic(), &format!("-o out/a.####.exr {ONE} -q --stats {name}")))
}

/// That `text` is the statistics of one frame.
#[track_caller]
fn assert_stats(text: &str) {
    let stats: serde_json::Value = serde_json::from_str(text).unwrap();
    assert_eq!(stats["frames"].as_array().unwrap().len(), 1);
}

#[test]
fn devices_are_written_into() {
    let place = Place::new();
    let (rights, null) = (Mode::RUSR | Mode::WUSR, makedev(1, 3));
    let made = mknodat(CWD, place.path("null"), FileType::CharacterDevice, rights, null);
    if made.is_err() || fs::write(place.path("null"), "x").is_err() {
        println!("skipped: no device can be made here (run as root)");
        return;
    }
    symlink("null", place.path("link")).unwrap();
    for name in ["null", "link"] {
        with_stats(&place, name).done();
        assert!(fs::metadata(place.path("null")).unwrap().file_type().is_char_device(), "{name}");
    }
    assert!(fs::symlink_metadata(place.path("link")).unwrap().is_symlink());
}

#[test]
fn a_fifo_is_written_into_once_frames_are_done() {
    let place = Place::new();
    make_fifo(&place.path("fifo"));
    let options = format!("-o a.####.exr {ONE} -q --stats fifo");
    let mut child = place.command(runs::analytic(), &options).spawn().unwrap();
    let start = Instant::now();
    while !place.path("a.0001.exr").exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "nobody reads, and it renders all the same");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_stats(&fs::read_to_string(place.path("fifo")).unwrap());
    assert!(child.wait().unwrap().success());
    assert!(fs::metadata(place.path("fifo")).unwrap().file_type().is_fifo());
    assert_eq!(place.names(""), ["a.0001.exr", "fifo"]);
}

/// Not with `/dev/stdout`, which a failure of this test would replace.
#[test]
fn stdout_is_a_place_for_reports_whatever_it_goes_to() {
    let place = Place::new();
    symlink("/proc/self/fd/1", place.path("link")).unwrap();
    assert_stats(&with_stats(&place, "link").done().stdout);
    let options = format!("-o out/a.####.exr {ONE} --stats link");
    let file = fs::File::create(place.path("file")).unwrap();
    let status = place.command(runs::analytic(), &options).stdout(file).status().unwrap();
    assert!(status.success() && fs::symlink_metadata(place.path("link")).unwrap().is_symlink());
    let text = fs::read_to_string(place.path("file")).unwrap();
    let (table, stats) = text.split_at(text.find("\n{").unwrap());
    assert!(table.contains("reused%") && table.contains("files"), "{text}");
    assert_stats(stats);
}

#[test]
fn links_stay_and_what_they_lead_to_is_replaced() {
    let place = Place::new();
    fs::create_dir(place.path("deep")).unwrap();
    fs::write(place.path("deep/old.json"), "old").unwrap();
    for target in ["deep/old.json", "deep/new.json"] {
        symlink(target, place.path("link")).unwrap();
        with_stats(&place, "link").done();
        assert_eq!(fs::read_link(place.path("link")).unwrap(), Path::new(target));
        assert_stats(&fs::read_to_string(place.path(target)).unwrap());
        fs::remove_file(place.path("link")).unwrap();
    }
    assert_eq!(place.names("deep"), ["new.json", "old.json"]);
}

#[test]
fn a_folder_where_a_report_goes_is_told_at_the_start() {
    let place = Place::new();
    fs::create_dir(place.path("taken")).unwrap();
    with_stats(&place, "taken").failed(&["taken", "give a file"]);
    assert_eq!(place.names(""), ["taken"]);
    // the folder that the frames make
    with_stats(&place, "out").failed(&["out", "give a file"]);
    assert!(place.names("out").is_empty());
}

#[test]
fn files_that_would_replace_one_another_are_usage_errors() {
    let place = Place::new();
    let scenes = runs::analytic();
    for name in ["analytic.toml", "analytic.obj", "analytic.mtl", "triangle.obj"] {
        fs::copy(scenes.with_file_name(name), place.path(name)).unwrap();
    }
    fs::create_dir(place.path("there")).unwrap();
    symlink("there/a.0001.exr", place.path("link")).unwrap();
    symlink(".", place.path("here")).unwrap();
    let before = place.names("");
    let refused = |command: &str, options: &str| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_afterimage"));
        program.current_dir(place.0.path()).args([command, "analytic.toml", "--size", "16x9"]);
        let ran = ended({
            program.args(options.split_whitespace());
            program
        });
        assert_eq!((ran.code, ran.stdout.as_str()), (2, ""), "{options}: {}", ran.stderr);
        assert_eq!(place.names(""), before, "{options}");
    };
    refused("render", "-o out/a.####.exr --stats out/a.0001.exr");
    refused("render", "-o out/a.####.exr --stats ./out/../out/a.0008.exr");
    refused("render", "-o out/a.####.exr --png --stats out/a.0001.png");
    refused("render", "-o there/a.####.exr --stats link");
    refused("render", "--stats analytic.toml");
    refused("render", "--stats here/analytic.obj");
    refused("render", "--stats analytic.mtl");
    refused("compare", "--json x --report x");
    refused("compare", "--json x --report here/x");
    refused("compare", "-o a.####.exr --json a.0001.exr");
    refused("compare", "--report analytic.toml");
    // what is read may not be among the frames either
    fs::rename(place.path("analytic.obj"), place.path("a.0001.exr")).unwrap();
    let shot = fs::read_to_string(place.path("analytic.toml")).unwrap();
    fs::write(place.path("analytic.toml"), shot.replace("analytic.obj", "a.0001.exr")).unwrap();
    let before = place.names("");
    let ran = Ran::new(place.command("analytic.toml", "-o a.####.exr").output().unwrap());
    assert_eq!((ran.code, place.names("")), (2, before), "{}", ran.stderr);
    // other frames, other names
    place.render(&format!("-o a.####.exr {ONE} --stats a.0002.exr")).done();
    place.render(&format!("-o a.####.exr {ONE} --stats a.0001.png")).done();
}
