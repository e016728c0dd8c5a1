//! Does a run that is killed go on from its checkpoint, without a run-up, to the frames of one that was never interrupted?

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use crate::runs::{Place, Ran, analytic, assert_same};

const OPTIONS: &str = "--mode reproject --base-every 0 --size 320x180 --progress plain";

fn start(place: &Place, options: &str) -> Child {
    let mut command = place.command(analytic(), options);
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits until `frame` is told. Returns what comes after it on stderr.
fn told(child: &mut Child, frame: i32) -> impl Iterator<Item = String> + use<> {
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    lines.by_ref().find(|line| line.contains(&format!("frame {frame}: "))).unwrap();
    lines
}

#[track_caller]
fn assert_same_frames(place: &Place) {
    for frame in 1..=8 {
        let [one, other] = ["all", "parts"].map(|folder| place.path(&format!("{folder}/a.{frame:04}.exr")));
        assert_same(&one, &other);
    }
}

#[test]
fn a_killed_run_goes_on_from_its_checkpoint_to_the_same_frames() {
    for (options, is_taken) in [("", true), ("--base-place middle", true), ("--audit", true)] {
        let place = Place::new();
        place.render(&format!("-o all/a.####.exr {OPTIONS} {options}")).done();
        let options = format!("-o parts/a.####.exr {OPTIONS} {options} --checkpoint 2 --resume");
        let mut child = start(&place, &options);
        let last = if options.contains("middle") { 7 } else { 6 };
        drop(told(&mut child, last));
        child.kill().unwrap();
        child.wait().unwrap();
        let checkpoint = place.path("parts/analytic.1-8.checkpoint");
        assert!(checkpoint.exists());
        let ran = place.render(&options).done();
        assert_eq!(ran.stderr.contains("--checkpoint: goes on from frame"), is_taken, "{}", ran.stderr);
        assert!(!checkpoint.exists(), "the run is complete");
        assert_same_frames(&place);
    }
}

#[test]
fn signals_stop_a_run_cleanly_and_it_says_how_to_go_on() {
    for (signal, code, options, advice) in [
        ("TERM", 143, "--checkpoint 2 --resume", "the same command goes on"),
        ("INT", 130, "", "the same command with --resume goes on"),
    ] {
        let place = Place::new();
        place.render(&format!("-o all/a.####.exr {OPTIONS}")).done();
        let all = format!("-o parts/a.####.exr {OPTIONS} {options}");
        let mut child = start(&place, &all);
        let rest = told(&mut child, 3);
        Command::new("sh").args(["-c", &format!("kill -{signal} {}", child.id())]).status().unwrap();
        let rest: Vec<String> = rest.collect();
        assert_eq!(child.wait().unwrap().code(), Some(code), "{rest:?}");
        let end = rest.last().unwrap();
        assert!(end.starts_with("error: stopped by SIG") && end.ends_with(advice), "{end}");
        let names = place.names("parts");
        assert!(names.iter().all(|name| !name.starts_with('.')), "nothing is half written: {names:?}");
        place.render(&format!("{all} --resume").replace("--resume --resume", "--resume")).done();
        assert_same_frames(&place);
    }
}

#[test]
fn a_checkpoint_that_is_no_good_is_told_and_not_taken() {
    let place = Place::new();
    place.render(&format!("-o all/a.####.exr {OPTIONS}")).done();
    let options = format!("-o parts/a.####.exr {OPTIONS} --checkpoint 2 --resume");
    let mut child = start(&place, &options);
    drop(told(&mut child, 5));
    child.kill().unwrap();
    child.wait().unwrap();
    let path = place.path("parts/analytic.1-8.checkpoint");
    let good = fs::read(&path).unwrap();
    let mut flipped = good.clone();
    flipped[good.len() / 2] ^= 1;
    let frames: Vec<String> =
        place.names("parts").into_iter().filter(|name| name.ends_with(".exr")).collect();
    for (bad, word) in
        [(&flipped[..], "damaged"), (&good[..good.len() - 9], "not whole"), (&b"x"[..], "no sample store")]
    {
        fs::write(&path, bad).unwrap();
        // frames that are there are kept, so that the run has the same to do each time
        let last = frames.last().unwrap();
        fs::remove_file(place.path("parts").join(last)).ok();
        let ran = place.render(&options).done();
        assert!(
            ran.stderr.contains("nothing is taken from an earlier run") && ran.stderr.contains(word),
            "{}",
            ran.stderr
        );
        assert_same_frames(&place);
    }
    // of other settings
    fs::write(&path, &good).unwrap();
    let ran = place.render(&format!("{options} --samples 1")).done();
    assert!(ran.stderr.contains("other settings"), "{}", ran.stderr);
}

#[test]
fn checkpoints_mean_nothing_where_no_frame_is_made_of_another() {
    let place = Place::new();
    let ran: Ran = place.render("-o a.####.exr --mode full --checkpoint 2");
    assert!(
        ran.code == 2 && ran.stderr.contains("--checkpoint") && ran.stderr.contains("leave it out"),
        "{}",
        ran.stderr
    );
    assert_eq!(place.render("-o a.####.exr --checkpoint 0").code, 2);
}
