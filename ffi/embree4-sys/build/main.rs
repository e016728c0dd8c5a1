//! Finds Embree, refuses one that is too old, and makes the bindings from its headers.
//!
//! Dependents that have this crate as a direct dependency read `DEP_EMBREE4_VERSION` and
//! `DEP_EMBREE4_RPATH` (empty when the loader finds the library by itself).

mod locate;

use locate::{Found, Places};
use std::env;
use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rerun-if-env-changed=EMBREE_DIR");
    println!("cargo::rerun-if-changed=build");
    let places = places();
    // `cargo::error` is one line for the user, where a panic would be a page.
    match locate::locate(&places) {
        Ok(found) => {
            watch(&found, &places);
            link(&found);
            if let Err(why) = bind(&found) {
                println!("cargo::error={}", why.replace('\n', " "));
            }
        }
        Err(why) => println!("cargo::error={why}"),
    }
}

fn places() -> Places {
    let crate_dir = PathBuf::from(cargo_env("CARGO_MANIFEST_DIR"));
    let workspace = crate_dir.ancestors().nth(2).unwrap_or(&crate_dir);
    Places {
        chosen: env::var_os("EMBREE_DIR")
            .filter(|dir| !dir.is_empty())
            // People set it where they type `cargo` or `make`, which is the workspace's folder.
            .map(|dir| workspace.join(dir)),
        // Neither Embree nor Debian ships a pkg-config file, so the prefixes are named here.
        system: vec!["/usr/local".into(), "/usr".into()],
        private: workspace.join(".deps/embree"),
        multiarch: format!("{}-linux-gnu", cargo_env("CARGO_CFG_TARGET_ARCH")),
    }
}

/// Reruns when the Embree in use changes. A failed search needs no watch: cargo repeats it.
fn watch(found: &Found, places: &Places) {
    let headers = found.include.join("embree4");
    if headers.starts_with(&places.private) {
        // Unpacking keeps old time stamps on files; the folders' own stamps tell.
        println!("cargo::rerun-if-changed={}", places.private.display());
    } else {
        println!("cargo::rerun-if-changed={}", headers.display());
        println!("cargo::rerun-if-changed={}", found.libdir.join("libembree4.so").display());
    }
}

fn link(found: &Found) {
    let libdir = found.libdir.canonicalize().unwrap_or_else(|_| found.libdir.clone());
    let rpath = if on_loader_path(&libdir) { String::new() } else { libdir.display().to_string() };
    println!("cargo::rustc-link-search=native={}", libdir.display());
    println!("cargo::rustc-link-lib=dylib=embree4");
    if !rpath.is_empty() {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{rpath}");
    }
    println!("cargo::metadata=rpath={rpath}");
    println!("cargo::metadata=libdir={}", libdir.display());
    println!("cargo::metadata=version={}", found.version);
    // The layout test compiles C against the same headers.
    println!("cargo::rustc-env=EMBREE4_INCLUDE={}", found.include.display());
    println!("cargo::rustc-env=EMBREE4_TARGET={}", cargo_env("TARGET"));
}

fn on_loader_path(libdir: &Path) -> bool {
    libdir.starts_with("/usr/lib") || libdir.starts_with("/usr/lib64") || libdir.starts_with("/lib")
}

fn bind(found: &Found) -> Result<(), String> {
    let bindings = bindgen::Builder::default()
        .header(found.include.join("embree4/rtcore.h").display().to_string())
        .clang_arg(format!("-I{}", found.include.display()))
        .allowlist_function("rtc[A-Z].*")
        .allowlist_type("RTC.*")
        .allowlist_var("RTC_.*")
        .prepend_enum_name(false)
        .merge_extern_blocks(true)
        .generate()
        .map_err(|why| format!("bindgen cannot read Embree's headers: {why}"))?;
    let target = PathBuf::from(cargo_env("OUT_DIR")).join("bindings.rs");
    bindings.write_to_file(&target).map_err(|why| format!("cannot write {}: {why}", target.display()))
}

fn cargo_env(name: &str) -> String {
    env::var(name).unwrap_or_else(|_| panic!("cargo sets {name} for build scripts"))
}
