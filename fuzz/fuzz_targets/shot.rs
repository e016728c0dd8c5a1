//! Shot files.
#![no_main]

use std::sync::LazyLock;

use afterimage_fuzz::Folder;
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> = LazyLock::new(Folder::new);

fuzz_target!(|bytes: &[u8]| {
    FOLDER.write("s.toml", bytes);
    FOLDER.load("s.toml");
});
