//! Curves as text.
#![no_main]

use std::sync::LazyLock;

use afterimage_fuzz::Folder;
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> = LazyLock::new(|| Folder::of_model("curves = { file = \"m.curves\" }"));

fuzz_target!(|bytes: &[u8]| {
    FOLDER.write("m.curves", bytes);
    FOLDER.load("s.toml");
});
