//! Do chunks that do not begin at base frames go on from what the one before has left, to the frames of one run?

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

use serde_json::Value;

use crate::runs::{Place, Ran, analytic, assert_same};

const OPTIONS: &str = "--mode reproject --base-every 0";

/// Renders a chunk to the folder `parts`.
fn chunk(place: &Place, frames: &str, options: &str) -> Ran {
    place.render(&format!(
        "-o parts/a.####.exr --stats {frames}.json --handoff {OPTIONS} {options} --frames {frames}"
    ))
}

/// Number of frames of run-up that the chunk rendered, each with as many samples that serve.
fn run_up(place: &Place, frames: &str) -> u64 {
    let stats = fs::read(place.path(&format!("{frames}.json"))).unwrap();
    let stats: Value = serde_json::from_slice(&stats).unwrap();
    let serving = |counts: &Value| {
        let kinds = ["base", "good", "overlapped", "missed", "obscured"];
        kinds.iter().map(|kind| counts["samples"][kind].as_u64().unwrap()).sum::<u64>()
    };
    stats.get("run_up").map_or(0, |run_up| serving(run_up) / serving(&stats["frames"][0]))
}

/// Names of stores beside the frames.
fn stores(place: &Place) -> Vec<String> {
    place.names("parts").into_iter().filter(|name| !name.ends_with(".exr")).collect()
}

#[track_caller]
fn assert_same_frames(place: &Place, frames: impl IntoIterator<Item = i32>) {
    for frame in frames {
        let [one, other] = ["all", "parts"].map(|folder| place.path(&format!("{folder}/a.{frame:04}.exr")));
        assert_same(&one, &other);
    }
}

/// A place with the frames of one run in `all`.
fn place(options: &str) -> Place {
    let place = Place::new();
    place.render(&format!("-o all/a.####.exr {OPTIONS} {options}")).done();
    place
}

#[test]
fn a_chunk_goes_on_from_the_one_before_without_a_run_up() {
    for options in ["", "--audit", "--layers all"] {
        let place = place(options);
        chunk(&place, "1-3", options).done();
        assert_eq!(stores(&place), ["analytic.3.handoff"]);
        let ran = chunk(&place, "4-6", options).done();
        assert!(ran.stderr.contains("--handoff: goes on from frame 3"), "{}", ran.stderr);
        assert_eq!(
            stores(&place),
            ["analytic.6.handoff"],
            "frames 4 to 6 are there, and nobody needs the other"
        );
        chunk(&place, "7-8", options).done();
        assert_eq!(["1-3", "4-6", "7-8"].map(|frames| run_up(&place, frames)), [0; 3]);
        assert!(stores(&place).is_empty(), "{:?}", stores(&place));
        assert_same_frames(&place, 1..=8);
    }
}

#[test]
fn base_frames_in_the_middle_serve_both_sides_and_steps_their_own_chain() {
    let middle = "--base-place middle";
    let place = place(middle);
    for frames in ["4-6", "7-8", "1-3"] {
        chunk(&place, frames, middle).done();
        assert_eq!(run_up(&place, frames), 0, "{frames}");
    }
    assert!(stores(&place).is_empty(), "{:?}", stores(&place));
    assert_same_frames(&place, 1..=8);

    let place = Place::new();
    place.render(&format!("-o all/a.####.exr {OPTIONS} --frames 1-7x2")).done();
    chunk(&place, "1-3x2", "").done();
    chunk(&place, "4-6", "").done();
    assert_eq!(run_up(&place, "4-6"), 3, "frame 3 is of another chain");
    chunk(&place, "5-7x2", "").done();
    assert_eq!(run_up(&place, "5-7x2"), 0);
    assert_same_frames(&place, [1, 3, 7]);
}

#[test]
fn a_chunk_whose_neighbour_has_not_finished_does_its_run_up() {
    let place = place("");
    chunk(&place, "4-6", "").done();
    assert_eq!(run_up(&place, "4-6"), 3);
    assert_eq!(stores(&place), ["analytic.6.handoff"]);
    chunk(&place, "1-3", "").done();
    assert_eq!(
        stores(&place),
        ["analytic.6.handoff"],
        "all that follows from frame 3 is there, up to frame 6"
    );
    // of several the latest one
    fs::remove_file(place.path("parts/a.0005.exr")).unwrap();
    fs::remove_file(place.path("parts/a.0003.exr")).unwrap();
    chunk(&place, "1-3", "").done();
    assert_eq!(stores(&place), ["analytic.3.handoff", "analytic.6.handoff"]);
    chunk(&place, "7-8", "").done();
    assert_eq!(run_up(&place, "7-8"), 0);
    assert_eq!(stores(&place), ["analytic.3.handoff"], "frame 5 is missing");
    chunk(&place, "4-6", "").done();
    assert!(stores(&place).is_empty(), "{:?}", stores(&place));
    assert_same_frames(&place, 1..=8);
    // where a base frame comes next, nothing is left
    let options = OPTIONS.replace("--base-every 0", "--base-every 4");
    place.render(&format!("-o parts/a.####.exr {options} --handoff --frames 1-4")).done();
    assert!(stores(&place).is_empty(), "{:?}", stores(&place));
}

#[test]
fn stores_that_are_no_good_cost_a_run_up_and_no_picture() {
    let place = place("");
    chunk(&place, "1-3", "").done();
    let path = place.path("parts/analytic.3.handoff");
    let good = fs::read(&path).unwrap();
    let mut flipped = good.clone();
    flipped[good.len() / 2] ^= 1;
    for (bad, word) in
        [(&flipped[..], "damaged"), (&good[..good.len() - 9], "not whole"), (&b"x"[..], "no sample store")]
    {
        fs::write(&path, bad).unwrap();
        let ran = chunk(&place, "4-6", "").done();
        assert!(ran.stderr.contains("is not taken") && ran.stderr.contains(word), "{}", ran.stderr);
        assert_eq!(run_up(&place, "4-6"), 3, "{word}");
        for frame in 4..=6 {
            fs::rename(place.path(&format!("parts/a.{frame:04}.exr")), place.path("parts/last.exr")).unwrap();
            assert_same(&place.path(&format!("all/a.{frame:04}.exr")), &place.path("parts/last.exr"));
        }
        fs::remove_file(place.path("parts/last.exr")).unwrap();
        fs::remove_file(place.path("parts/analytic.6.handoff")).unwrap();
    }
    fs::write(&path, &good).unwrap();
    let ran = chunk(&place, "4-6", "--samples 1").done();
    assert!(ran.stderr.contains("is not taken") && ran.stderr.contains("other settings"), "{}", ran.stderr);
    assert_eq!(run_up(&place, "4-6"), 3);
    assert!(path.exists(), "it is of another run, which may need it");
    // something that is no file, where one is to be left and where one is looked for
    fs::remove_file(place.path("parts/analytic.6.handoff")).unwrap();
    fs::create_dir(place.path("parts/analytic.6.handoff")).unwrap();
    let ran = chunk(&place, "4-6", "").done();
    assert!(ran.stderr.contains("no samples are left"), "{}", ran.stderr);
    chunk(&place, "7-8", "").done();
    assert_same_frames(&place, 1..=8);
}

#[test]
fn the_checkpoint_of_a_killed_neighbour_is_taken() {
    let place = Place::new();
    let options = format!("{OPTIONS} --size 320x180 --progress plain");
    place.render(&format!("-o all/a.####.exr {options}")).done();
    let first = format!("-o parts/a.####.exr {options} --frames 1-6 --checkpoint 2 --resume");
    let mut command = place.command(analytic(), &first);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    lines.find(|line| line.contains("frame 5: ")).unwrap();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(place.path("parts/analytic.1-6.checkpoint").exists());
    let ran = chunk(&place, "7-8", "--size 320x180").done();
    assert!(ran.stderr.contains("--handoff: goes on from frame 4"), "{}", ran.stderr);
    assert_eq!(run_up(&place, "7-8"), 2);
    assert_same_frames(&place, 7..=8);
    assert!(place.path("parts/analytic.1-6.checkpoint").exists(), "it is the neighbour's");
}

#[test]
fn handoffs_mean_nothing_where_no_frame_is_made_of_another() {
    let place = Place::new();
    let ran = place.render("-o a.####.exr --mode full --handoff");
    assert!(ran.code == 2 && ran.stderr.contains("--handoff"), "{}", ran.stderr);
    assert_eq!(place.render("-o a.####.exr --shared --handoff").code, 2);
}
