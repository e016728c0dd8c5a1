//! What the program must know of its build: where its libraries are, Embree's version, and the state of the sources. And
//! what its tests must know: whether the scene collection is at hand, and programs that read EXR files.

use std::env;
use std::path::Path;
use std::process::Command;

/// Where a program that is made to be carried elsewhere finds its libraries: `scripts/package` puts them there.
const CARRIED_LIBRARIES: &str = "$ORIGIN/../lib/afterimage";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    libraries();
    source_state();
    scene_collection();
    programs_of_tests();
    open_image_denoise();
}

/// `cfg(scene_collection)` where `AFTERIMAGE_SCENES` names a folder: without it, tests that need it are ignored.
fn scene_collection() {
    println!("cargo::rerun-if-env-changed=AFTERIMAGE_SCENES");
    println!("cargo::rustc-check-cfg=cfg(scene_collection)");
    if env::var_os("AFTERIMAGE_SCENES").is_some_and(|folder| Path::new(&folder).is_dir()) {
        println!("cargo::rustc-cfg=scene_collection");
    }
}

/// Tests start no program from outside the checkout but those that a variable names: without it they are ignored.
fn programs_of_tests() {
    let named = [
        ("AFTERIMAGE_OPENEXR_TOOLS", "openexr_tools"),
        ("AFTERIMAGE_PYTHON", "python_with_openexr"),
        ("AFTERIMAGE_BPY", "python_with_bpy"),
        ("AFTERIMAGE_BLENDER", "blender"),
        ("AFTERIMAGE_OIIO", "python_with_openimageio"),
        ("AFTERIMAGE_CRYPTOMATTE", "python_with_cryptomatte"),
        ("AFTERIMAGE_FFMPEG", "ffmpeg"),
        ("AFTERIMAGE_CONVERT", "imagemagick"),
    ];
    for (variable, cfg) in named {
        println!("cargo::rerun-if-env-changed={variable}");
        println!("cargo::rustc-check-cfg=cfg({cfg})");
        if env::var_os(variable).is_some_and(|named| !named.is_empty()) {
            println!("cargo::rustc-cfg={cfg}");
        }
    }
}

/// `cfg(open_image_denoise)` where the library that denoises is at hand, which only tests must know: the program loads it.
fn open_image_denoise() {
    println!("cargo::rerun-if-env-changed=OIDN_DIR");
    println!("cargo::rustc-check-cfg=cfg(open_image_denoise)");
    let named = env::var_os("OIDN_DIR").filter(|prefix| !prefix.is_empty());
    let library =
        Path::new(&named.unwrap_or_else(|| ".deps/oidn".into())).join("lib/libOpenImageDenoise.so.2");
    if library.exists() {
        println!("cargo::rustc-cfg=open_image_denoise");
        println!("cargo::rerun-if-changed={}", library.display());
    }
}

/// The run path makes the program start from anywhere, as long as the libraries of the build stay where they are; with
/// `AFTERIMAGE_RELOCATABLE` they travel with the program, which then names no folder of this checkout.
fn libraries() {
    println!("cargo::rerun-if-env-changed=AFTERIMAGE_RELOCATABLE");
    let is_relocatable = env::var_os("AFTERIMAGE_RELOCATABLE").is_some_and(|value| !value.is_empty());
    // `ffi/embree` hands on what the build found.
    let version = env::var("DEP_EMBREE_VERSION").unwrap_or_default();
    let rpath = env::var("DEP_EMBREE_RPATH").unwrap_or_default();
    println!("cargo::rustc-env=AFTERIMAGE_EMBREE_VERSION={version}");
    if is_relocatable {
        // The old kind of run path counts for libraries that libraries ask for, too, and comes before LD_LIBRARY_PATH,
        // with which other programs of a studio may name another Embree or TBB.
        println!("cargo::rustc-link-arg=-Wl,--disable-new-dtags,-rpath,{CARRIED_LIBRARIES}");
        return;
    }
    if !rpath.is_empty() {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{rpath}");
    }
    let checkout = env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo::rustc-env=AFTERIMAGE_PRIVATE_OIDN={checkout}/.deps/oidn");
}

/// `AFTERIMAGE_GIT_DESCRIBE`: tag or commit, `-dirty` if the sources differ from it; the package's version
/// where there is no git, as in a source archive.
fn source_state() {
    let version = env::var("CARGO_PKG_VERSION").unwrap_or_default();
    let describe = git(&["describe", "--tags", "--always", "--dirty"]);
    println!("cargo::rustc-env=AFTERIMAGE_GIT_DESCRIBE={}", describe.unwrap_or(version));
    // A new commit changes the log of HEAD; an edit that makes the tree dirty is in one of the folders. cargo
    // would run this each time for a path that does not exist.
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"]);
    let watched = ["Cargo.toml", "Cargo.lock", "ffi", "src"].map(str::to_owned);
    for path in watched.into_iter().chain(log).filter(|path| Path::new(path).exists()) {
        println!("cargo::rerun-if-changed={path}");
    }
}

/// Git's answer in one line, if there is git and it has one.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let line = text.trim();
    (output.status.success() && !line.is_empty()).then(|| line.to_owned())
}
