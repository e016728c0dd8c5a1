//! Schedules of ranges, and the frames that they make one another of.

use super::*;
use crate::scene::frames::Frames;

const RULE: Rule<'_> = Rule {
    shot_first: 1,
    shot_last: None,
    base_every: 10,
    base_place: BasePlace::First,
    cuts: &[],
    full: false,
};

const MIDDLE: Rule<'_> = Rule { base_place: BasePlace::Middle, ..RULE };

fn plan(frames: &str, rule: &Rule<'_>) -> Vec<Step> {
    resumed(frames, rule, &[])
}

fn resumed(frames: &str, rule: &Rule<'_>, finished: &[i32]) -> Vec<Step> {
    let frames = Frames::parse(frames).expect("a good range");
    schedule(frames.runs(), rule, None, |frame| finished.contains(&frame)).expect("short enough")
}

fn bases(steps: &[Step]) -> Vec<i32> {
    steps.iter().filter(|step| !step.reuses()).map(|step| step.frame).collect()
}

fn written(steps: &[Step]) -> Vec<i32> {
    steps.iter().filter(|step| step.write).map(|step| step.frame).collect()
}

/// (frame, inferred from) for each written frame.
fn ancestry(steps: &[Step]) -> Vec<(i32, Vec<i32>)> {
    let mut chain = Vec::new();
    let mut all = Vec::new();
    for step in steps {
        match step.origin {
            Origin::Nothing => chain.clear(),
            Origin::Base => chain.truncate(1),
            Origin::Before | Origin::Saved => {}
        }
        chain.push(step.frame);
        if step.write {
            all.push((step.frame, chain.clone()));
        }
    }
    all.sort();
    all
}

#[test]
fn bases_lie_on_a_grid_from_the_shots_first_frame() {
    let steps = plan("1-25", &RULE);
    assert_eq!(bases(&steps), [1, 11, 21]);
    assert_eq!(written(&steps), (1..=25).collect::<Vec<_>>());
    let once = Rule { base_every: 0, ..RULE };
    assert_eq!(bases(&plan("1-25", &once)), [1]);
}

#[test]
fn a_chunk_starts_at_the_base_frame_before_it() {
    let steps = plan("15-17", &RULE);
    assert_eq!(steps.len(), 7);
    assert_eq!((bases(&steps), written(&steps)), (vec![11], vec![15, 16, 17]));
    let note = |frames| run_up_note(&plan(frames, &RULE), "remedy");
    assert!(note("11-20").is_none());
    for (frames, words) in [
        (
            "15-17",
            "4 frames from 11 on are rendered without being written, more than the 3 to write, because",
        ),
        (
            "19-20",
            "8 frames from 11 on are rendered without being written, more than the 2 to write, because",
        ),
        ("12-20", "1 frame from 11 on is rendered without being written, because"),
    ] {
        let note = note(frames).expect("frames that are not written");
        assert!(note.contains(words) && note.ends_with("(remedy)"), "{note}");
    }
}

#[test]
fn chunks_give_every_frame_the_ancestry_that_the_whole_gives() {
    let middle = Rule { cuts: &[8, 19], shot_last: Some(37), ..MIDDLE };
    for rule in [RULE, Rule { base_every: 0, ..RULE }, Rule { cuts: &[8, 19], ..RULE }, MIDDLE, middle] {
        for step in 1..=4 {
            let whole = ancestry(&plan(&format!("1-40x{step}"), &rule));
            for second in (1 + step..40).step_by(step) {
                let mut chunks = ancestry(&plan(&format!("1-{}x{step}", second - 1), &rule));
                chunks.extend(ancestry(&plan(&format!("{second}-40x{step}"), &rule)));
                assert_eq!(whole, chunks, "step {step} from {second} on, {rule:?}");
            }
        }
    }
}

#[test]
fn a_step_across_the_grid_makes_a_base() {
    // 1 4 7 10 | 13 16 19 | 22 25: the first of each ten
    assert_eq!(bases(&plan("1-25x3", &RULE)), [1, 13, 22]);
    // another phase has its own first frame
    assert_eq!(bases(&plan("2-25x3", &RULE)), [2, 11, 23]);
}

#[test]
fn a_cut_is_a_base_even_if_the_step_jumps_over_it() {
    let rule = Rule { base_every: 0, cuts: &[8], ..RULE };
    assert_eq!(bases(&plan("1-12", &rule)), [1, 8]);
    assert_eq!(bases(&plan("1-12x3", &rule)), [1, 10]);
    assert_eq!(bases(&plan("10-12", &rule)), [8]);
}

#[test]
fn before_the_shots_first_frame_each_frame_is_a_base() {
    let steps = plan("-2-3", &RULE);
    assert_eq!(bases(&steps), [-2, -1, 0, 1]);
    assert_eq!(written(&steps).len(), steps.len());
}

#[test]
fn full_mode_needs_no_run_up() {
    let rule = Rule { full: true, ..RULE };
    let steps = plan("15-17,99", &rule);
    assert_eq!((bases(&steps), written(&steps)), (vec![15, 16, 17, 99], vec![15, 16, 17, 99]));
}

#[test]
fn a_later_run_of_the_same_chain_goes_on_where_it_is_nearer() {
    let once = Rule { base_every: 0, ..RULE };
    assert_eq!(plan("1-3,6-7", &once).len(), 7);
    // with a base frame between, that is the nearer start
    assert_eq!(bases(&plan("1-3,22", &RULE)), [1, 21]);
}

#[test]
fn frames_asked_for_twice_are_written_once() {
    assert_eq!(written(&plan("1-6,4-8,2-8x2", &RULE)), (1..=8).collect::<Vec<_>>());
}

#[test]
fn resume_renders_finished_frames_only_as_run_up() {
    let all: Vec<i32> = (1..=30).collect();
    assert!(resumed("1-30", &RULE, &all).is_empty());
    let steps = resumed("1-30", &RULE, &all[..14]);
    assert_eq!((steps[0].frame, written(&steps)), (11, (15..=30).collect()));
    // a hole: up to it, and then on from the next base frame
    let steps = resumed("1-30", &RULE, &[1, 2, 3, 5, 6, 7, 8, 9, 10]);
    let frames: Vec<i32> = steps.iter().map(|step| step.frame).collect();
    assert_eq!(frames, (1..=4).chain(11..=30).collect::<Vec<_>>());
}

#[test]
fn resumed_frames_keep_their_ancestry() {
    let whole = ancestry(&plan("1-30", &RULE));
    let rest = ancestry(&resumed("1-30", &RULE, &[1, 2, 3, 4, 9, 17]));
    assert!(rest.iter().all(|frame| whole.contains(frame)));
}

#[test]
fn ancestries_are_those_of_the_schedule() {
    let middle = Rule { cuts: &[8, 19], shot_last: Some(37), ..MIDDLE };
    let rules = [RULE, Rule { base_every: 0, ..RULE }, Rule { cuts: &[8, 19], ..RULE }, MIDDLE, middle];
    let ranges = ["1-40", "3-40x3", "-2-3", "15-17,33", "1-40x2,2-40x3", "5"];
    for (rule, range) in rules.iter().flat_map(|rule| ranges.iter().map(move |range| (rule, range))) {
        let frames = Frames::parse(range).expect("a good range");
        let ancestries = ancestries(frames.runs(), rule).expect("short enough");
        let whole = ancestry(&plan(range, rule));
        assert_eq!(whole.len(), ancestries.len(), "{range}");
        for (frame, chain) in whole {
            let expected = match chain[..] {
                [_] => Ancestry::Base,
                [from, next, ..] => Ancestry::Inferred { from, stride: next.abs_diff(from) },
                [] => unreachable!("a chain ends with its frame"),
            };
            assert_eq!(ancestries[&frame], expected, "{frame} of {range}, {rule:?}");
        }
    }
}

#[test]
fn an_ancestry_is_read_as_it_is_written() {
    for ancestry in [Ancestry::Base, Ancestry::Inferred { from: -3, stride: 2 }] {
        assert_eq!(ancestry.to_string().parse(), Ok(ancestry));
    }
    for bad in ["", "from", "from 1", "from 1 by 0", "from 1 by -1", "from x by 1", "base "] {
        assert_eq!(bad.parse::<Ancestry>(), Err(()), "{bad}");
    }
}

/// Frames in the order in which they are rendered, with what they are made from.
fn order(steps: &[Step]) -> Vec<(i32, Origin)> {
    steps.iter().map(|step| (step.frame, step.origin)).collect()
}

#[test]
fn a_base_frame_in_the_middle_serves_both_sides() {
    use Origin::{Base, Before, Nothing};
    let steps = plan("1-5", &Rule { base_every: 5, ..MIDDLE });
    let expected = [(3, Nothing), (4, Before), (5, Before), (2, Base), (1, Before)];
    assert_eq!(order(&steps), expected);
    assert_eq!(steps.iter().map(|step| step.keep).collect::<Vec<_>>(), [true, false, false, false, false]);
    // nothing comes between the base frame and what is before it: no copy
    let steps = plan("1-3", &Rule { base_every: 5, ..MIDDLE });
    assert_eq!(order(&steps), [(3, Nothing), (2, Base), (1, Before)]);
    assert!(steps.iter().all(|step| !step.keep && step.write));
    assert_eq!(order(&plan("1", &Rule { base_every: 5, ..MIDDLE })).len(), 3);
    // of an even number, one frame more comes before it; and of a step, the middle of its frames
    assert_eq!(bases(&plan("1-30", &MIDDLE)), [6, 16, 26]);
    assert_eq!(bases(&plan("1-30x3", &MIDDLE)), [7, 16, 25]);
    assert_eq!(bases(&plan("2-30x3", &MIDDLE)), [5, 17, 26]);
}

#[test]
fn cuts_and_the_ends_of_the_shot_are_borders_of_segments() {
    let rule = Rule { shot_last: Some(24), cuts: &[5, 18], ..MIDDLE };
    // 1-4, 5-10, 11-17, 18-20, 21-24; what is beyond is 25-30
    assert_eq!(bases(&plan("1-30", &rule)), [3, 8, 14, 19, 23, 28]);
    let takes = Rule { base_every: 0, ..rule };
    assert_eq!(bases(&plan("1-24", &takes)), [3, 11, 21]);
    assert_eq!(bases(&plan("-1-4", &takes)), [-1, 0, 3]);
    // whoever does not say where the shot ends must say how long segments are
    let frames = Frames::parse("1").expect("good");
    let endless = Rule { base_every: 0, ..MIDDLE };
    assert!(schedule(frames.runs(), &endless, None, |_| false).is_err());
}

#[test]
fn a_saved_store_stands_for_the_way_to_it() {
    use Origin::{Base, Before, Nothing};
    let with = |frames: &str, rule: &Rule<'_>, frame: i32, stride: u32| {
        let ancestry = rule.ancestry(frame, stride).expect("short enough");
        let frames = Frames::parse(frames).expect("a good range");
        let saved = Some(super::Saved { frame, ancestry });
        order(&schedule(frames.runs(), rule, saved, |_| false).expect("short enough"))
    };
    let saved = Origin::Saved;
    assert_eq!(with("7-8", &RULE, 6, 1), [(7, saved), (8, Before)]);
    assert_eq!(
        with("8-11", &RULE, 6, 1),
        [(7, saved), (8, Before), (9, Before), (10, Before), (11, Nothing)]
    );
    // it is of no use to frames of another segment or chain, or before it
    assert_eq!(with("11", &RULE, 6, 1), [(11, Nothing)]);
    assert_eq!(with("3x2", &RULE, 2, 1).len(), 2);
    assert_eq!(with("5-7", &RULE, 6, 1).len(), 7);
    // a base frame has no step
    assert_eq!(with("3x2,5x2", &RULE, 1, 1)[0], (3, saved));
    let five = Rule { base_every: 5, ..MIDDLE };
    assert_eq!(with("1-2,4-5", &five, 3, 1), [(4, saved), (5, Before), (2, saved), (1, Before)]);
    assert_eq!(with("1,5", &five, 4, 1), [(5, saved), (3, Nothing), (2, Base), (1, Before)]);
    assert_eq!(with("1,4", &five, 2, 1), [(3, Nothing), (4, Before), (1, saved)]);
}

#[test]
fn extreme_numbers_are_an_error_not_an_overflow() {
    let once = Rule { base_every: 0, ..RULE };
    let frames = Frames::parse("2147483647").expect("good");
    let error = schedule(frames.runs(), &once, None, |_| false).expect_err("too far");
    assert!(error.to_string().contains("--base-every"));
    assert_eq!(plan("2147483647", &RULE).len(), 7);
    let low = Rule { shot_first: i32::MIN, ..once };
    assert_eq!(plan("-2147483648", &low).len(), 1);
    assert_eq!(plan("-2147483648-2147483647x4294967295", &low).len(), 2);
    assert_eq!(bases(&plan("2147483640-2147483647", &MIDDLE)), [2147483636, 2147483644]);
}
