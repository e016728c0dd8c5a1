//! Volumes.
#![no_main]

use std::sync::LazyLock;

use afterimage_fuzz::Folder;
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> =
    LazyLock::new(|| Folder::of_model("vdb = { file = \"m.vdb\", material = \"m\" }\n[[material]]\nname = \"m\"\nsurface = false\nvolume_absorb = [1, 1, 1]"));

fuzz_target!(|bytes: &[u8]| {
    FOLDER.write("m.vdb", bytes);
    FOLDER.load("s.toml");
});
