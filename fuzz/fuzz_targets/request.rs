//! Heads of requests to `preview`, up to its answer. `TOKEN` stands for the word that lets a reader in.
#![no_main]

use std::sync::LazyLock;

use afterimage::cli::preview::unserved::Unserved;
use afterimage_fuzz::{Folder, SHOT};
use libfuzzer_sys::fuzz_target;

static PAGE: LazyLock<Unserved> = LazyLock::new(|| {
    let folder = Folder::new();
    folder.write("s.toml", format!("{SHOT}[[model]]\nobj = \"m.obj\"\n"));
    let shot = folder.load("s.toml").expect("the shot of this target is right");
    Unserved::new(&shot).expect("the system has random numbers")
});

fuzz_target!(|bytes: &[u8]| {
    PAGE.status(bytes);
});
