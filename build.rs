//! What the program must know of its build: where its Embree lies, and which commit it is.

use std::env;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=.git/HEAD");
    // a private Embree is found by its path, from wherever the program is started
    let rpath = env::var("DEP_EMBREE_RPATH").unwrap_or_default();
    if !rpath.is_empty() {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{rpath}");
    }
    let describe = Command::new("git").args(["describe", "--always", "--dirty", "--tags"]).output();
    let commit = describe.ok().filter(|out| out.status.success());
    let commit = commit.map(|out| String::from_utf8_lossy(&out.stdout).trim().to_owned());
    println!("cargo::rustc-env=AFTERIMAGE_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
}
