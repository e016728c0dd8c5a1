//! Previews as `--resume` and contact sheets read them.
#![no_main]

use std::sync::LazyLock;

use afterimage::output::picture::Picture;
use afterimage::output::png;
use afterimage_fuzz::Folder;
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> = LazyLock::new(Folder::new);

fuzz_target!(|bytes: &[u8]| {
    let path = FOLDER.write("a.png", bytes);
    let _ = png::fingerprint(&path);
    let _ = Picture::of_png(&path);
});
