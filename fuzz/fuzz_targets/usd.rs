//! USD files, text and binary. Panics of the library that reads them are caught where it is called, so that they are no finding.
#![no_main]

use std::sync::LazyLock;

use afterimage_fuzz::Folder;
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> = LazyLock::new(|| {
    // the one of libFuzzer ends the process before a panic can be caught; one that nobody catches ends it still
    std::panic::set_hook(Box::new(|_| {}));
    Folder::new()
});

fuzz_target!(|bytes: &[u8]| {
    let name = if bytes.starts_with(b"PXR-USDC") { "m.usdc" } else { "m.usda" };
    FOLDER.write(name, bytes);
    FOLDER.load(name);
});
