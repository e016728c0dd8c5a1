//! PLY files.
#![no_main]

use std::sync::LazyLock;

use afterimage_fuzz::Folder;
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> = LazyLock::new(|| Folder::of_model("ply = \"m.ply\""));

fuzz_target!(|bytes: &[u8]| {
    FOLDER.write("m.ply", bytes);
    FOLDER.load("s.toml");
});
