//! Do several processes on one folder divide a shot, whatever becomes of them, into the frames of one run?

use std::fs;
use std::os::unix::fs::symlink;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use crate::runs::{Place, Ran, analytic, assert_same};

const OPTIONS: &str = "--mode reproject --base-every 2 --size 320x180 --progress plain --threads 1";

fn start(place: &Place, options: &str) -> Child {
    let options = format!("-o parts/a.####.exr {OPTIONS} --shared {options}");
    place.command(analytic(), &options).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

#[track_caller]
fn assert_complete(place: &Place, last: i32) {
    let names = place.names("parts");
    assert_eq!(names.len(), last as usize, "neither locks nor checkpoints are left: {names:?}");
    for frame in 1..=last {
        let [one, other] = ["all", "parts"].map(|folder| place.path(&format!("{folder}/a.{frame:04}.exr")));
        assert_same(&one, &other);
    }
}

/// Numbers of frames that a run wrote.
fn written(ran: &Ran) -> Vec<i32> {
    let numbers =
        ran.stderr.lines().filter_map(|line| line.split_once("] frame ")?.1.split(':').next()?.parse().ok());
    numbers.collect()
}

#[test]
fn processes_divide_the_segments_and_all_end_when_all_is_there() {
    let place = Place::new();
    place.render(&format!("-o all/a.####.exr {OPTIONS}")).done();
    let children: Vec<Child> = (0..3).map(|_| start(&place, "")).collect();
    let runs: Vec<Ran> =
        children.into_iter().map(|child| Ran::new(child.wait_with_output().unwrap()).done()).collect();
    assert_complete(&place, 8);
    let mut all: Vec<i32> = runs.iter().flat_map(written).collect();
    all.sort_unstable();
    assert_eq!(all, (1..=8).collect::<Vec<_>>(), "no frame is rendered twice, and none as a run-up");
}

#[test]
fn the_segment_of_a_killed_process_is_taken_by_another() {
    for options in ["", "--checkpoint 1"] {
        let place = Place::new();
        let frames = "--base-every 8 --frames 1-16";
        place.render(&format!("-o all/a.####.exr {OPTIONS} {frames}").replace("--base-every 2", "")).done();
        let options = format!("{frames} {options}");
        let start = || {
            let options =
                format!("-o parts/a.####.exr {OPTIONS} --shared {options}").replace("--base-every 2", "");
            place.command(analytic(), &options).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
        };
        let mut victim = start();
        let begin = Instant::now();
        // it holds the first segment, and has written some of it
        while !place.path("parts/a.0003.exr").exists() {
            assert!(begin.elapsed() < Duration::from_secs(60), "nothing is rendered");
            std::thread::sleep(Duration::from_millis(2));
        }
        let others = [start(), start()];
        victim.kill().unwrap();
        victim.wait().unwrap();
        for child in others {
            Ran::new(child.wait_with_output().unwrap()).done();
        }
        assert_complete(&place, 16);
    }
}

#[test]
fn a_process_that_waits_for_others_can_be_stopped_and_one_that_comes_late_has_nothing_to_do() {
    let place = Place::new();
    place.render(&format!("-o all/a.####.exr {OPTIONS}")).done();
    Ran::new(start(&place, "").wait_with_output().unwrap()).done();
    let late = Ran::new(start(&place, "").wait_with_output().unwrap()).done();
    assert!(late.stderr.contains("resume: 8 frames are there and whole"), "{}", late.stderr);
    assert_complete(&place, 8);
    let ran = Ran::new(start(&place, "--save-store s.store").wait_with_output().unwrap());
    assert!(ran.code == 2 && ran.stderr.contains("--save-store"), "{}", ran.stderr);
}

#[test]
fn a_link_with_the_name_of_a_lock_is_an_error_and_what_it_points_to_stays_as_it_was() {
    let place = Place::new();
    let victim = place.path("victim");
    fs::create_dir(place.path("parts")).unwrap();
    fs::write(&victim, "of somebody else").unwrap();
    symlink("../victim", place.path("parts/.analytic.1-2.lock")).unwrap();
    let ran = Ran::new(start(&place, "").wait_with_output().unwrap());
    let ran = ran.failed(&[".analytic.1-2.lock", "a symbolic link has the lock's name", "remove it"]);
    assert!(!ran.stderr.contains("flock"), "{}", ran.stderr);
    assert_eq!(fs::read_to_string(&victim).unwrap(), "of somebody else");
}
