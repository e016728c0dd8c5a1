//! Do a thousand random shots hold? The same ones each time; `scripts/random-shots` tries others.

use std::time::Duration;

use random_shots::run::{Options, run};

#[test]
fn a_thousand_random_shots_are_exact() {
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    let time = Duration::from_secs(3600);
    let options = Options { workers, most_failures: 3, time, having: Vec::new() };
    let tally = run(1..1001, &options, |seed, failure| eprintln!("seed {seed}: {failure}"));
    let tally = tally.expect("there is a folder for temporary files");
    assert!(tally.failed.is_empty(), "scripts/random-shots --seed SEED --count 1 cuts each of these down");
    let refused: u64 = tally.refused.values().sum();
    assert!(
        tally.passed > 900 && tally.passed + refused == 1000,
        "{} held: {:?}",
        tally.passed,
        tally.refused
    );
    assert!(tally.counts.inferred > 3000 && tally.counts.compared > 10_000, "{:?}", tally.counts);
    assert!(tally.counts.cells > 100_000 && tally.counts.pixels > 10_000, "{:?}", tally.counts);
    assert!(tally.fairness.is_fair(), "brighter or darker than in full: {:?}", tally.fairness);
}
