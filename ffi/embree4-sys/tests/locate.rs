//! The search for Embree and the version gate, on made-up folders.
#![allow(clippy::unwrap_used, reason = "tests")]

#[path = "../build/locate.rs"]
mod locate;

use locate::{Places, Version, locate as find, version_of};
use std::fs;
use std::path::{Path, PathBuf};

fn config(version: &str) -> String {
    let n: Vec<&str> = version.split('.').collect();
    format!(
        "#define RTC_VERSION_MAJOR {}\n#define RTC_VERSION_MINOR {}\n#define RTC_VERSION_PATCH {}\n",
        n[0], n[1], n[2]
    )
}

/// A prefix with headers of `version`, and a library in `libdir` unless that is empty.
fn prefix(root: &Path, name: &str, version: &str, libdir: &str) -> PathBuf {
    let prefix = root.join(name);
    let include = prefix.join("include/embree4");
    fs::create_dir_all(&include).unwrap();
    fs::write(include.join("rtcore.h"), "").unwrap();
    fs::write(include.join("rtcore_config.h"), config(version)).unwrap();
    if !libdir.is_empty() {
        fs::create_dir_all(prefix.join(libdir)).unwrap();
        fs::write(prefix.join(libdir).join("libembree4.so"), "").unwrap();
    }
    prefix
}

fn places(chosen: Option<PathBuf>, system: Vec<PathBuf>, private: PathBuf) -> Places {
    Places {
        chosen,
        system,
        private,
        multiarch: "x86_64-linux-gnu".to_owned(),
    }
}

#[test]
fn a_chosen_folder_comes_first_and_then_the_system() {
    let root = tempfile::tempdir().unwrap();
    let chosen = prefix(root.path(), "chosen", "4.3.0", "lib64");
    let system = prefix(root.path(), "system", "4.3.1", "lib/x86_64-linux-gnu");
    let private = prefix(root.path(), "private", "4.3.2", "lib");

    let all = places(Some(chosen.clone()), vec![system.clone()], private.clone());
    let found = find(&all).unwrap();
    assert_eq!(
        (found.version, found.libdir),
        (Version(4, 3, 0), chosen.join("lib64"))
    );

    let found = find(&places(None, vec![system.clone()], private.clone())).unwrap();
    assert_eq!(
        (found.version, found.include),
        (Version(4, 3, 1), system.join("include"))
    );

    let found = find(&places(None, vec![root.path().join("none")], private)).unwrap();
    assert_eq!(found.version, Version(4, 3, 2));
}

#[test]
fn an_old_system_gives_way_to_the_private_copy() {
    let root = tempfile::tempdir().unwrap();
    let old = prefix(root.path(), "system", "4.2.0", "lib");
    let private = prefix(root.path(), "private", "4.3.3", "lib");
    assert_eq!(
        find(&places(None, vec![old], private)).unwrap().version,
        Version(4, 3, 3)
    );
}

#[test]
fn every_refusal_is_one_sentence_that_says_what_to_do() {
    let root = tempfile::tempdir().unwrap();
    let none = root.path().join("none");
    let old = prefix(root.path(), "old", "4.2.0", "lib");
    let no_library = prefix(root.path(), "no_library", "4.3.3", "");
    let unreadable = prefix(root.path(), "unreadable", "4.x.0", "lib");
    let good = prefix(root.path(), "good", "4.3.3", "lib");
    let refusals = [
        (
            places(None, vec![none.clone()], none.clone()),
            "was not found",
        ),
        (
            places(None, vec![old.clone()], none.clone()),
            "is 4.2.0 and 4.3 or newer is needed",
        ),
        // Who chooses a folder gets that or an error, never another.
        (
            places(Some(old), vec![good.clone()], good.clone()),
            "is 4.2.0 and 4.3 or newer is needed",
        ),
        (
            places(Some(none), vec![good.clone()], good.clone()),
            "there is no ",
        ),
        (
            places(Some(no_library), vec![], good.clone()),
            "there is no libembree4.so",
        ),
        (places(Some(unreadable), vec![], good), "states no version"),
    ];
    for (places, why) in refusals {
        let sentence = find(&places).unwrap_err();
        assert!(sentence.contains(why), "{sentence}");
        assert!(
            sentence.contains("make setup") && sentence.contains("EMBREE_DIR"),
            "{sentence}"
        );
        assert!(!sentence.contains('\n'), "{sentence}");
    }
}

#[test]
fn versions_compare_as_numbers() {
    assert_eq!(version_of(&config("4.10.2")), Some(Version(4, 10, 2)));
    assert!(Version(4, 10, 0) > Version(4, 9, 9));
    assert_eq!(version_of("#define RTC_VERSION 40303"), None);
}
