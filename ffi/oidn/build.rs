//! Tells tests whether the library is at hand.

use std::env;
use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=OIDN_DIR");
    println!("cargo::rustc-check-cfg=cfg(open_image_denoise)");
    let crate_dir = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let private = crate_dir.join("../../.deps/oidn");
    let prefix = env::var_os("OIDN_DIR").map_or(private, PathBuf::from);
    let library = prefix.join("lib/libOpenImageDenoise.so.2");
    if Path::new(&library).exists() {
        println!("cargo::rustc-cfg=open_image_denoise");
        println!("cargo::rerun-if-changed={}", library.display());
    }
}
