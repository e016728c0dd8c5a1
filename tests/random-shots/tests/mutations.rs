//! Does each mutation still break the program: does what it replaces stand once in its file?
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use std::fs;
use std::path::Path;

#[test]
fn each_mutation_finds_what_it_breaks() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let list: toml::Table = fs::read_to_string(here.join("mutations.toml")).unwrap().parse().unwrap();
    let mutations = list["mutation"].as_array().unwrap();
    let more = mutations.iter().filter_map(|mutation| mutation.get("and")?.as_array()).flatten();
    let mut stale = Vec::new();
    for change in mutations.iter().chain(more) {
        let [file, old] = ["file", "old"].map(|key| change[key].as_str().unwrap());
        let source = fs::read_to_string(here.join("../..").join(file)).unwrap_or_default();
        if source.matches(old).count() != 1 {
            stale.push(format!("{file}: {old}"));
        }
    }
    assert!(stale.is_empty(), "these do not stand once in their file: {stale:#?}");
}
