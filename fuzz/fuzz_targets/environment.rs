//! Environment maps, Radiance pictures and OpenEXR files: their first bytes tell.
#![no_main]

use std::sync::LazyLock;

use afterimage_fuzz::{Folder, SHOT};
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> = LazyLock::new(|| {
    let folder = Folder::new();
    folder.write("s.toml", format!("{SHOT}[[model]]\nobj = \"m.obj\"\n[environment]\nmap = \"map\"\n"));
    folder
});

fuzz_target!(|bytes: &[u8]| {
    FOLDER.write("map", bytes);
    FOLDER.load("s.toml");
});
