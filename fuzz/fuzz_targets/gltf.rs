//! glTF files, as text or binary by their first bytes.
#![no_main]

use std::sync::LazyLock;

use afterimage_fuzz::Folder;
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> = LazyLock::new(Folder::new);

fuzz_target!(|bytes: &[u8]| {
    let name = if bytes.starts_with(b"glTF") { "m.glb" } else { "m.gltf" };
    FOLDER.write(name, bytes);
    FOLDER.load(name);
});
