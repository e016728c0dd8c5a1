//! Where the program finds Embree at run time: in the place that `ffi/embree` hands on.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if let Some(rpath) = std::env::var("DEP_EMBREE_RPATH").ok().filter(|rpath| !rpath.is_empty()) {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{rpath}");
    }
}
