//! What a run leaves that did not get to its end: earlier frames whole, no half ones, and a way to go on.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod program;

use std::ffi::CString;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use program::{Place, assert_same, whole};
use rustix::mount::{MountFlags, UnmountFlags, mount, unmount};

/// That all files under a frame's name are whole; says how many there are. Leftovers of a killed run are
/// hidden and end in `.part`.
#[track_caller]
fn whole_frames(place: &Place, folder: &str) -> usize {
    let names = place.names(folder);
    let (hidden, frames): (Vec<_>, Vec<_>) = names.iter().partition(|name| name.starts_with('.'));
    assert!(hidden.iter().all(|name| name.ends_with(".part")), "{hidden:?}");
    for name in &frames {
        let path = place.path(folder).join(name);
        if name.ends_with(".exr") {
            whole(&path);
        } else {
            image::open(&path).unwrap();
        }
    }
    frames.iter().filter(|name| name.ends_with(".exr")).count()
}

#[test]
fn a_file_where_the_folder_should_be_ends_the_run_before_it_begins() {
    let place = Place::new();
    fs::write(place.path("taken"), "mine").unwrap();
    let ran = place.render("-o taken/a.####.exr").failed(&["taken", "remove it", "another folder"]);
    assert_eq!(ran.stdout, "");
    assert_eq!(fs::read(place.path("taken")).unwrap(), b"mine");
    place.render("-o a.####.exr --stats taken/a.json").failed(&["taken"]);
    assert_eq!(place.names(""), ["taken"]);
}

#[test]
fn a_frame_that_cannot_be_written_is_named_and_those_before_stay() {
    let place = Place::new();
    // with one digit more, the temporary name is longer than file systems allow
    let longest = 255 - ".x.exr.TWELVELETTER.part".len();
    let name = "a".repeat(longest);
    let ran = place.render(&format!("-o {name}#.exr --frames 8-10 --stats a.json"));
    let ran = ran.failed(&[&format!("{name}10.exr"), "shorten the name"]);
    assert!(ran.stdout.contains("reused%"), "what was done is told: {}", ran.stdout);
    let stats: serde_json::Value = serde_json::from_slice(&fs::read(place.path("a.json")).unwrap()).unwrap();
    assert_eq!(stats["frames"].as_array().unwrap().len(), 2);
    fs::remove_file(place.path("a.json")).unwrap();
    assert_eq!(whole_frames(&place, ""), 2);
    assert_eq!(place.names("").len(), 2, "{:?}", place.names(""));
}

/// A small file system of its own, as long as this lives.
struct Disk<'a>(&'a Path);

impl<'a> Disk<'a> {
    /// `None` where this is not allowed.
    fn of(bytes: u64, at: &'a Path) -> Option<Self> {
        fs::create_dir(at).unwrap();
        let size = CString::new(format!("size={bytes}")).unwrap();
        mount("tmpfs", at, "tmpfs", MountFlags::empty(), size.as_c_str()).is_ok().then_some(Self(at))
    }
}

impl Drop for Disk<'_> {
    fn drop(&mut self) {
        // what fails here is no more than a leftover of the test
        let _ = unmount(self.0, UnmountFlags::empty());
    }
}

#[test]
fn a_full_disk_is_told_and_leaves_whole_frames_only() {
    let place = Place::new();
    place.render("-o whole/a.####.exr").done();
    let size = |frame| fs::metadata(place.path(&format!("whole/a.{frame:04}.exr"))).unwrap().len();
    let all: u64 = (1..=8).map(size).sum();
    let folder = place.path("disk");
    let Some(disk) = Disk::of(all / 2, &folder) else {
        println!("skipped: a small file system cannot be mounted here (run as root)");
        return;
    };
    let ran = place.render("-o disk/a.####.exr").failed(&["free space"]);
    let names = place.names("disk");
    let fitted = whole_frames(&place, "disk");
    assert!((2..=5).contains(&fitted) && names.len() == fitted, "{names:?}");
    let next = format!("a.{:04}.exr", fitted + 1);
    assert!(ran.stderr.contains(&next), "{next}: {}", ran.stderr);
    // nothing goes on while there is no room, and all goes on when there is
    place.render("-o disk/a.####.exr --resume").failed(&["disk", "free space"]);
    assert_eq!(place.names("disk"), names);
    names.iter().for_each(|name| fs::remove_file(folder.join(name)).unwrap());
    place.render("-o disk/a.####.exr --frames 6-8").done();
    assert_same(&folder.join("a.0007.exr"), &place.path("whole/a.0007.exr"));
    drop(disk);
}

/// Renders until `frame` is told, waits so long, and kills.
fn kill_after(place: &Place, options: &str, frame: usize, wait: Duration) {
    let mut command = place.command(program::analytic(), &format!("{options} --progress plain"));
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let told = BufReader::new(child.stderr.take().unwrap());
    let done = format!("] frame {frame}: ");
    told.lines().map_while(Result::ok).find(|line| line.contains(&done));
    std::thread::sleep(wait);
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_killed_run_leaves_no_half_frame_and_goes_on_to_the_same_frames() {
    for every in [0, 3] {
        let place = Place::new();
        let options = format!("--mode reproject --base-every {every} --size 192x108 --png");
        place.render(&format!("-o all/a.####.exr {options}")).done();
        let options = format!("-o parts/a.####.exr {options} --resume");
        // at other moments of a frame each time; the longest wait is about a frame
        let mut frames = 0;
        for round in 0..5 {
            kill_after(&place, &options, frames + 1, Duration::from_millis(round * 7));
            let now = whole_frames(&place, "parts");
            assert!(now > frames || now == 8, "it goes on: {now} after {frames}");
            frames = now;
        }
        let last = place.render(&options).done();
        assert!(last.stderr.contains(&format!("resume: {frames} frames")), "{}", last.stderr);
        assert_eq!(whole_frames(&place, "parts"), 8);
        assert_eq!(place.names("parts").len(), 16, "nothing of the killed runs is left");
        for frame in 1..=8 {
            let path = |folder| place.path(&format!("{folder}/a.{frame:04}.exr"));
            assert_same(&path("all"), &path("parts"));
        }
    }
}

#[test]
fn frames_that_are_not_whole_are_made_again() {
    let place = Place::new();
    place.render("-o all/a.####.exr").done();
    place.render("-o some/a.####.exr").done();
    let path = |folder: &str, frame: i32| place.path(&format!("{folder}/a.{frame:04}.exr"));
    let bytes = fs::read(path("some", 2)).unwrap();
    fs::write(path("some", 2), &bytes[..bytes.len() - 100]).unwrap();
    fs::write(path("some", 3), "no picture").unwrap();
    fs::write(path("some", 4), "").unwrap();
    fs::remove_file(path("some", 6)).unwrap();
    let ran = place.render("-o some/a.####.exr --resume").done();
    assert!(ran.stderr.contains("resume: 4 frames"), "{}", ran.stderr);
    (1..=8).for_each(|frame| assert_same(&path("all", frame), &path("some", frame)));
    let before = fs::metadata(path("some", 2)).unwrap().modified().unwrap();
    place.render("-o some/a.####.exr --resume").done();
    assert_eq!(fs::metadata(path("some", 2)).unwrap().modified().unwrap(), before, "nothing was left to do");
}
