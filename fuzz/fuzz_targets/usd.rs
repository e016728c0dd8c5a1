//! USD files, text and binary. Panics of the library that reads them are caught where it is called, so that they are no finding.
#![no_main]

use std::sync::LazyLock;

use afterimage_fuzz::{Folder, SHOT};
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> = LazyLock::new(|| {
    // the one of libFuzzer ends the process before a panic can be caught; one that nobody catches ends it still
    std::panic::set_hook(Box::new(|_| {}));
    let folder = Folder::new();
    for ending in ["usda", "usdc"] {
        folder.write(&format!("{ending}.toml"), format!("{SHOT}[[model]]\nusd = \"m.{ending}\"\n"));
    }
    folder
});

fuzz_target!(|bytes: &[u8]| {
    let (name, shot) =
        if bytes.starts_with(b"PXR-USDC") { ("m.usdc", "usdc.toml") } else { ("m.usda", "usda.toml") };
    FOLDER.write(name, bytes);
    // a file of its own has cameras and lights, but takes longer
    FOLDER.load(if bytes.len().is_multiple_of(16) { name } else { shot });
});
