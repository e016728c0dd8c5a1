//! Run path of the module: to the libraries that it carries, and in a checkout to those of the build.

use std::env;

/// Beside the module: `scripts/wheel` puts them there.
const CARRIED_LIBRARIES: &str = "$ORIGIN/lib/afterimage";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=AFTERIMAGE_RELOCATABLE");
    let is_relocatable = env::var_os("AFTERIMAGE_RELOCATABLE").is_some_and(|value| !value.is_empty());
    // the old kind of run path counts for what libraries load, too, and comes before LD_LIBRARY_PATH
    println!("cargo::rustc-link-arg=-Wl,--disable-new-dtags,-rpath,{CARRIED_LIBRARIES}");
    let rpath = env::var("DEP_EMBREE_RPATH").unwrap_or_default();
    if !is_relocatable && !rpath.is_empty() {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{rpath}");
    }
}
