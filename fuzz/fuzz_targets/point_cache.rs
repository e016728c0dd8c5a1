//! Point caches, PC2 and MDD: their first bytes tell.
#![no_main]

use std::sync::LazyLock;

use afterimage_fuzz::{Folder, SHOT};
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> = LazyLock::new(|| {
    let folder = Folder::new();
    folder.write("s.toml", format!("{SHOT}[[model]]\nobj = \"m.obj\"\nshapes = {{ cache = \"a.cache\" }}\n"));
    folder
});

fuzz_target!(|bytes: &[u8]| {
    FOLDER.write("a.cache", bytes);
    FOLDER.load("s.toml");
});
