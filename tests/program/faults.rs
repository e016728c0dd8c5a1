//! Do frames stay right when what is around the program fails: disks, clocks, other machines' locks, files that rot, and nodes of
//! another kind? docs/reliability.md lists all faults that are tried.

use std::fs::{self, File};
use std::process::Command;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use crate::disk::Disk;
use crate::runs::{Place, Ran, analytic, assert_same};

#[track_caller]
fn assert_same_frames(place: &Place, frames: i32) {
    for frame in 1..=frames {
        let [one, other] = ["all", "parts"].map(|folder| place.path(&format!("{folder}/a.{frame:04}.exr")));
        assert_same(&one, &other);
    }
}

#[test]
fn a_disk_without_room_for_a_checkpoint_keeps_its_frames() {
    let place = Place::new();
    place.render("-o all/a.####.exr --mode reproject --checkpoint 4 --frames 1-5").done();
    let all: u64 = (1..=5)
        .map(|frame| {
            fs::metadata(place.path(&format!("all/a.{frame:04}.exr"))).unwrap().len().next_multiple_of(4096)
        })
        .sum();
    let folder = place.path("parts");
    let Some(disk) = Disk::new(all, &folder) else { return };
    let options = "-o parts/a.####.exr --mode reproject --frames 1-5";
    place.render(&format!("{options} --checkpoint 4")).failed(&["checkpoint", "free space"]);
    let names = place.names("parts");
    assert!(names.len() >= 4 && names.iter().all(|name| name.ends_with(".exr")), "{names:?}");
    // without checkpoints there is room for all
    place.render(&format!("{options} --resume")).done();
    assert_same_frames(&place, 5);
    drop(disk);
}

#[test]
fn a_folder_that_cannot_be_written_to_is_told_before_anything_is_rendered() {
    let place = Place::new();
    let folder = place.path("disk");
    let Some(_disk) = Disk::read_only(&folder) else { return };
    for options in [
        "-o disk/a.####.exr",
        "-o disk/new/a.####.exr --resume --checkpoint 2",
        "-o disk/a.####.exr --shared",
    ] {
        let ran = place.render(options).failed(&["disk", "Read-only file system", "another folder"]);
        assert_eq!(ran.stdout, "", "{options}");
    }
}

/// Times that clocks of a farm's machines and file servers show when they are wrong.
fn odd_times() -> [SystemTime; 2] {
    [UNIX_EPOCH + Duration::from_secs(1), SystemTime::now() + Duration::from_secs(20 * 365 * 86_400)]
}

fn set_all_times(place: &Place, folder: &str, time: SystemTime) {
    for name in place.names(folder) {
        let file = File::options().append(true).open(place.path(folder).join(name)).unwrap();
        file.set_modified(time).unwrap();
    }
}

#[test]
fn no_clock_decides_about_a_frame_a_leftover_or_a_lock() {
    let options = "--mode reproject --base-every 2 --frames 1-4";
    for time in odd_times() {
        let place = Place::new();
        place.render(&format!("-o all/a.####.exr {options}")).done();
        place.render(&format!("-o parts/a.####.exr {options}")).done();
        // a frame that is to be made again, and what killed processes leave: on NFS, too, where the file stays when its holder is gone
        fs::remove_file(place.path("parts/a.0003.exr")).unwrap();
        fs::write(place.path("parts/.a.0003.exr.abcdefghijkl.part"), "half").unwrap();
        for segment in ["1-2", "3-4"] {
            fs::write(place.path(&format!("parts/.analytic.{segment}.lock")), "elsewhere 4711\n").unwrap();
        }
        set_all_times(&place, "parts", time);
        let ran = place.render(&format!("-o parts/a.####.exr {options} --shared")).done();
        assert!(ran.stderr.contains("resume: 3 frames are there and whole"), "{}", ran.stderr);
        assert_same_frames(&place, 4);
        let names = place.names("parts");
        assert!(
            names.iter().all(|name| !name.ends_with(".part") && name != ".analytic.3-4.lock"),
            "{names:?}"
        );
        assert_eq!(names.iter().filter(|name| name.ends_with(".exr")).count(), 4);
    }
}

#[test]
fn frames_with_a_bit_that_has_flipped_are_made_again() {
    let place = Place::new();
    let options = "--layers none --frames 1-2 --size 32x18";
    place.render(&format!("-o all/a.####.exr {options}")).done();
    let good = fs::read(place.path("all/a.0002.exr")).unwrap();
    place.render(&format!("-o parts/a.####.exr {options}")).done();
    // in the pixels, which are behind the header: with checksums, as compressed ones are
    for share in [5, 6, 7, 8, 9] {
        let mut bad = good.clone();
        bad[good.len() * share / 10] ^= 4;
        fs::write(place.path("parts/a.0002.exr"), bad).unwrap();
        let ran = place.render(&format!("-o parts/a.####.exr {options} --resume")).done();
        assert!(ran.stderr.contains("rendering again frame 2"), "byte {share} of 10: {}", ran.stderr);
        assert_same_frames(&place, 2);
    }
}

/// Runs the program as a node whose Embree has these settings.
fn node(place: &Place, settings: &str, words: &str) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    command
        .current_dir(place.0.path())
        .env("AFTERIMAGE_EMBREE_CONFIG", settings)
        .args(words.split_whitespace());
    Ran::new(command.output().unwrap())
}

#[test]
fn frames_of_nodes_that_round_differently_are_not_taken_for_those_of_one_run() {
    let place = Place::new();
    let shot = analytic().display().to_string();
    let render =
        |frames: &str| format!("render {shot} -o out/a.####.exr --mode full --size 16x9 --frames {frames}");
    let oldest = "isa=sse2";
    node(&place, "", &render("1-3")).done();
    node(&place, oldest, &render("4")).done();
    let verify = "verify out/a.####.exr --frames 1-4";
    let ran = node(&place, "", verify).failed(&["1 of 4 frames"]);
    assert!(
        ran.stdout.contains("other    4") && ran.stdout.contains("another kind of processor"),
        "{}",
        ran.stdout
    );
    // each goes on from its own frames alone
    let ran = node(&place, "verbose=0", &format!("{} --resume", render("1-4"))).done();
    assert!(ran.stderr.contains("rendering again frame 4 (made with another version of the program or of Embree, or another kind of processor)"), "{}", ran.stderr);
    node(&place, "", verify).done();
    // and nodes that are told to calculate alike do so
    node(&place, oldest, &render("1-2")).done();
    let ran = node(&place, "max_isa=sse2", &format!("{} --resume", render("1-2"))).done();
    assert!(ran.stderr.contains("resume: 2 frames are there and whole"), "{}", ran.stderr);
}

/// The fault behind it: a hit may be rounded in another way, so that samples of nodes of two kinds are not those of one run.
#[test]
fn saved_samples_of_a_node_that_rounds_differently_are_refused() {
    let place = Place::new();
    let shot = analytic().display().to_string();
    let render =
        |words: &str| format!("render {shot} -o out/a.####.exr --mode reproject --size 16x9 {words}");
    node(&place, "isa=sse2", &render("--frames 1 --save-store s.store")).done();
    node(&place, "", &render("--frames 2 --load-store s.store"))
        .failed(&["s.store", "another kind of processor"]);
    node(&place, "isa=sse2", &render("--frames 2 --load-store s.store")).done();
}
