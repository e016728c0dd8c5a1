//! Tells tests whether OpenEXR's own tools are at hand.

use std::env;

const TOOLS: &str = "AFTERIMAGE_OPENEXR_TOOLS";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={TOOLS}");
    println!("cargo::rustc-check-cfg=cfg(openexr_tools)");
    if env::var_os(TOOLS).is_some_and(|folder| !folder.is_empty()) {
        println!("cargo::rustc-cfg=openexr_tools");
    }
}
