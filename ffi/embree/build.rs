//! Hands on what `embree4-sys` found: cargo gives a `links` crate's metadata to direct dependents only.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(has_last_error_message)");
    let version = env::var("DEP_EMBREE4_VERSION").unwrap_or_default();
    let rpath = env::var("DEP_EMBREE4_RPATH").unwrap_or_default();
    println!("cargo::metadata=version={version}");
    println!("cargo::metadata=rpath={rpath}");
    if !rpath.is_empty() {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{rpath}");
    }
    // rtcGetDeviceLastErrorMessage came with 4.3.3; before, a device that fails has a code alone.
    let numbers: Vec<u32> = version.split('.').filter_map(|n| n.parse().ok()).collect();
    if numbers >= vec![4, 3, 3] {
        println!("cargo::rustc-cfg=has_last_error_message");
    }
}
