//! Textures of every format: the first byte chooses the ending of the name, the rest is the file.
#![no_main]

use std::sync::LazyLock;

use afterimage_fuzz::{Folder, MTL};
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<Folder> = LazyLock::new(|| Folder::of_model("obj = \"m.obj\""));

const ENDINGS: [&str; 6] = ["png", "jpg", "bmp", "tga", "tif", "webp"];

fuzz_target!(|bytes: &[u8]| {
    let Some((chosen, bytes)) = bytes.split_first() else { return };
    let name = format!("t.{}", ENDINGS[usize::from(*chosen) % ENDINGS.len()]);
    FOLDER.write("m.mtl", format!("{MTL}map_Kd {name}\nmap_Bump {name}\nmap_d {name}\n"));
    FOLDER.write(&name, bytes);
    FOLDER.load("s.toml");
});
