//! Do shots that were wrong once hold? Each says in its first line what was wrong. In each way of trying a shot.

use std::path::Path;

use afterimage::trace::BackendKind;
use random_shots::check::{Outcome, Pools, check};
use random_shots::trial::{Trial, Variation};

#[test]
fn what_was_wrong_once_is_right() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("kept");
    let (folder, pools) = (tempfile::tempdir().expect("there is room"), Pools::new());
    let mut count = 0;
    for entry in kept.read_dir().expect("it is there") {
        let path = entry.expect("it can be read").path();
        let text = std::fs::read_to_string(&path).expect("it is text");
        for backend in [BackendKind::Embree, BackendKind::Rust] {
            for variation in Variation::ALL {
                let trial = Trial { variation, backend, ..Trial::of_text(&text).expect("it is TOML") };
                let outcome = check(&trial, folder.path(), &pools);
                assert!(
                    matches!(outcome, Outcome::Passed(_)),
                    "{}: {variation:?}: {outcome:?}",
                    path.display()
                );
                count += 1;
            }
        }
    }
    assert!(count >= 140, "only {count} trials of shots in {}", kept.display());
}
