//! glTF files, as text or binary by their first bytes.
#![no_main]

use std::sync::LazyLock;

use afterimage_fuzz::{Folder, SHOT};
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> = LazyLock::new(|| {
    let folder = Folder::new();
    for ending in ["gltf", "glb"] {
        folder.write(&format!("{ending}.toml"), format!("{SHOT}[[model]]\ngltf = \"m.{ending}\"\n"));
    }
    folder
});

fuzz_target!(|bytes: &[u8]| {
    let (name, shot) =
        if bytes.starts_with(b"glTF") { ("m.glb", "glb.toml") } else { ("m.gltf", "gltf.toml") };
    FOLDER.write(name, bytes);
    // a file of its own has cameras and lights, but takes longer
    FOLDER.load(if bytes.len().is_multiple_of(16) { name } else { shot });
});
