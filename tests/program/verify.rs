//! Does `verify` find what is missing, damaged, or of another run, and does what it prints bring it back?

use std::fs;
use std::process::Command;

use crate::runs::{Place, Ran, analytic};

fn verify(place: &Place, words: &str) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_afterimage"));
    command.current_dir(place.0.path()).arg("verify").args(words.split_whitespace());
    Ran::new(command.output().unwrap())
}

/// Options in the line `again` of the result.
fn again(ran: &Ran) -> String {
    let line = ran.stdout.lines().find_map(|line| line.strip_prefix("again")).unwrap();
    line.trim().to_owned()
}

#[test]
fn all_that_is_wrong_is_found_and_what_is_printed_brings_it_back() {
    let place = Place::new();
    place.render("-o out/ --base-every 3").done();
    assert!(verify(&place, "out").done().stdout.contains("complete"));
    let path = |frame: i32| place.path(&format!("out/analytic.{frame:04}.exr"));
    // frames of two runs with the same shot and size: only their fingerprints tell
    place.render("-o out/ --base-every 3 --frames 4 --samples 3").done();
    let bytes = fs::read(path(2)).unwrap();
    fs::write(path(2), &bytes[..bytes.len() - 50]).unwrap();
    fs::remove_file(path(5)).unwrap();
    fs::remove_file(path(6)).unwrap();
    for words in ["out", "out/analytic.####.exr", "out --frames 1-8"] {
        let ran = verify(&place, words).failed(&["4 of 8 frames", "--frames 2,4-6"]);
        for line in ["missing  5-6", "damaged  2 (not whole)", "other    4 (made with other settings)"] {
            assert!(ran.stdout.contains(line), "{line}: {}", ran.stdout);
        }
        assert_eq!(again(&ran), "--frames 2,4-6");
    }
    let ran = verify(&place, "out").failed(&[]);
    place.render(&format!("-o out/ --base-every 3 {}", again(&ran))).done();
    verify(&place, "out").done();
    verify(&place, "out --frames 1-9").failed(&["1 of 9", "--frames 9"]);
}

#[test]
fn frames_under_the_name_of_another_one_are_found() {
    let place = Place::new();
    // all are made in the same way: nothing but their numbers tells them apart
    let options = "-o out/ --mode full --size 16x9 --frames 1-9 --png";
    place.render(options).done();
    let path = |frame: i32, kind: &str| place.path(&format!("out/analytic.{frame:04}.{kind}"));
    let copy = |from: i32, to: i32, kind: &str| fs::copy(path(from, kind), path(to, kind)).unwrap();
    let bytes = fs::read(path(5, "exr")).unwrap();
    copy(3, 4, "exr");
    copy(9, 5, "exr");
    fs::write(path(9, "exr"), bytes).unwrap();
    let shot = analytic().display().to_string();
    let by_shot = format!("out --shot {shot} --frames 1-9 -- --mode full --size 16x9");
    for words in ["out", &by_shot] {
        let ran = verify(&place, words).failed(&["3 of 9 frames", "--frames 4-5,9"]);
        for line in ["4 (the picture of frame 3)", "5 (the picture of frame 9)", "9 (the picture of frame 5)"]
        {
            assert!(ran.stdout.contains(line), "{line}: {}", ran.stdout);
        }
    }
    let ran = place.render(&format!("{options} --resume")).done();
    assert!(ran.stderr.contains("frame 4 (the picture of frame 3)"), "{}", ran.stderr);
    verify(&place, "out").done();
    // previews have numbers as well
    copy(3, 4, "png");
    let ran = place.render(&format!("{options} --resume")).done();
    assert!(ran.stderr.contains("rendering again frame 4 (without the preview"), "{}", ran.stderr);
    assert_ne!(fs::read(path(3, "png")).unwrap(), fs::read(path(4, "png")).unwrap());
}

#[test]
fn a_shot_tells_which_frames_there_must_be_and_of_what() {
    let place = Place::new();
    place.render("-o out/ --base-every 3 --frames 2-8").done();
    let shot = analytic().display().to_string();
    let by_shot = |options: &str| verify(&place, &format!("out --shot {shot} -- --base-every 3 {options}"));
    by_shot("").failed(&["1 of 8", "--frames 1"]);
    place.render("-o out/ --base-every 3 --frames 1").done();
    by_shot("").done();
    by_shot("--samples 3").failed(&["8 of 8"]);
    // frames of another ancestry look alike, and their samples differ
    let ran = verify(&place, &format!("out --shot {shot} -- --base-every 0")).failed(&["5 of 8"]);
    assert_eq!(again(&ran), "--frames 4-8");
    let ran = verify(&place, &format!("out --shot {shot} -- --frames 1-3"));
    assert_eq!(ran.code, 2, "{}", ran.stderr);
}

#[test]
fn what_cannot_be_verified_is_an_error() {
    let place = Place::new();
    fs::create_dir(place.path("empty")).unwrap();
    verify(&place, "empty").failed(&["empty", "no frames"]);
    verify(&place, "no/such/").failed(&["no/such", "cannot be read"]);
    place.render("-o out/a.####.exr --frames 1-2").done();
    fs::copy(place.path("out/a.0001.exr"), place.path("out/b.0001.exr")).unwrap();
    let ran = verify(&place, "out");
    assert!(ran.code == 2 && ran.stderr.contains("a.####.exr, out/b.####.exr"), "{}", ran.stderr);
    verify(&place, "out/a.####.exr").done();
    // what another program wrote, or an earlier version, is not known to be of one run
    fs::write(place.path("out/a.0002.exr"), "no picture").unwrap();
    verify(&place, "out/a.####.exr").failed(&["--frames 2"]);
}
