//! Do shots that were wrong once hold? Each says in its first line what was wrong. In each way of trying a shot.

use std::path::Path;

use random_shots::check::Outcome;
use random_shots::run::run_kept;

#[test]
fn what_was_wrong_once_is_right() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("kept");
    let count = run_kept(&kept, |path, trial, outcome| {
        assert!(
            matches!(outcome, Outcome::Passed(_)),
            "{}: {:?}, {:?}: {outcome:?}",
            path.display(),
            trial.variation,
            trial.backend
        );
    });
    let count = count.expect("they can be read");
    assert!(count >= 140, "only {count} trials of shots in {}", kept.display());
}
