//! OpenEXR files as `diff`, `info`, `verify` and `--resume` read them.
#![no_main]

use std::sync::LazyLock;

use afterimage::output::picture::Picture;
use afterimage::settings::Look;
use afterimage_fuzz::Folder;
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> = LazyLock::new(Folder::new);

fuzz_target!(|bytes: &[u8]| {
    let path = FOLDER.write("a.exr", bytes);
    let Ok(head) = openexr::read_header(&path) else { return };
    let parts = openexr::part_count(&path).unwrap_or(0);
    // what is larger is not read by lines in a test that makes thousands of them
    if u64::from(head.width) * u64::from(head.height) > 1 << 20 {
        return;
    }
    for part in 0..parts.min(4) {
        let _ = openexr::scan_part(&path, part, |_, _| {});
    }
    let _ = openexr::read(&path);
    let _ = Picture::of_exr(&path, ["R", "G", "B"], Look::default());
});
