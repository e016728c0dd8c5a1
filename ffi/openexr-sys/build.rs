//! Finds the installed OpenEXR, checks its version and makes the bindings from its own headers.
//!
//! `OPENEXR_DIR` (a folder that holds `include/` and `lib/`) beats pkg-config.

use std::env;
use std::error::Error;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The C interface that these bindings speak came with 3.1; the next major version may change it.
const OLDEST: (u32, u32) = (3, 1);
const FIRST_UNKNOWN: (u32, u32) = (4, 0);

const WHAT_TO_DO: &str = "Run `make setup`, which installs it, or set OPENEXR_DIR to a folder that \
     holds include/OpenEXR/openexr.h and lib/libOpenEXRCore.";

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Location of the library on this machine.
struct Installation {
    /// Folders with `openexr.h` and the headers that it includes.
    includes: Vec<PathBuf>,
    /// Folders with the library; empty if the linker finds it by itself.
    libraries: Vec<PathBuf>,
    /// Name for the linker, with its version suffix: `OpenEXRCore-3_1`.
    link_name: String,
}

fn main() -> ExitCode {
    println!("cargo::rerun-if-env-changed=OPENEXR_DIR");
    println!("cargo::rerun-if-changed=build.rs");
    match build() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}\n{WHAT_TO_DO}");
            ExitCode::FAILURE
        }
    }
}

fn build() -> Outcome<()> {
    let found = match env::var_os("OPENEXR_DIR") {
        Some(folder) => from_folder(Path::new(&folder))?,
        None => from_pkg_config()?,
    };
    let header = find_header(&found.includes, "openexr.h")?;
    check_version(&find_header(&found.includes, "OpenEXRConfig.h")?)?;
    generate(&header, &found.includes)?;
    for folder in &found.libraries {
        println!("cargo::rustc-link-search=native={}", folder.display());
    }
    println!("cargo::rustc-link-lib={}", found.link_name);
    publish(&found)
}

/// Tells the layout test where the headers are, and dependent build scripts where the library is.
fn publish(found: &Installation) -> Outcome<()> {
    let includes = env::join_paths(&found.includes)?;
    println!("cargo::rustc-env=OPENEXR_INCLUDES={}", text(&includes)?);
    let libraries = env::join_paths(&found.libraries)?;
    println!("cargo::metadata=libraries={}", text(&libraries)?);
    Ok(())
}

fn text(value: &OsString) -> Outcome<&str> {
    let failure = || format!("the path {value:?} is not valid UTF-8");
    Ok(value.to_str().ok_or_else(failure)?)
}

fn from_pkg_config() -> Outcome<Installation> {
    let library = pkg_config::Config::new()
        .cargo_metadata(false) // the module names five libraries, of which one is needed
        .env_metadata(true)
        .probe("OpenEXR")
        .map_err(|error| format!("OpenEXR was not found by pkg-config: {error}"))?;
    let link_name = library.libs.into_iter().find(|name| name.starts_with("OpenEXRCore"));
    Ok(Installation {
        includes: library.include_paths,
        libraries: library.link_paths,
        link_name: link_name.ok_or("the installed OpenEXR has no OpenEXRCore library")?,
    })
}

fn from_folder(folder: &Path) -> Outcome<Installation> {
    let include = folder.join("include");
    for name in ["lib", "lib64"] {
        let libraries = folder.join(name);
        if let Some(link_name) = core_library_in(&libraries) {
            return Ok(Installation {
                includes: vec![include.join("OpenEXR"), include.join("Imath")],
                libraries: vec![libraries],
                link_name,
            });
        }
    }
    Err(format!("OPENEXR_DIR={} holds no lib/libOpenEXRCore", folder.display()).into())
}

/// Name of the library in a folder: `OpenEXRCore-3_1` for `libOpenEXRCore-3_1.so`.
fn core_library_in(folder: &Path) -> Option<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .ok()?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| {
            let stem = name.strip_prefix("lib")?;
            let stem = [".so", ".dylib", ".a"].iter().find_map(|end| stem.strip_suffix(end))?;
            stem.starts_with("OpenEXRCore").then(|| stem.to_owned())
        })
        .collect();
    names.sort(); // the folder's own order is not defined
    names.pop()
}

fn find_header(folders: &[PathBuf], name: &str) -> Outcome<PathBuf> {
    let mut candidates = folders.iter().map(|folder| folder.join(name));
    let found = candidates.find(|path| path.is_file());
    Ok(found.ok_or_else(|| format!("OpenEXR's header {name} is in none of {folders:?}"))?)
}

/// Checks the version in the header rather than in pkg-config, because the bindings are made from the header.
fn check_version(config: &Path) -> Outcome<()> {
    println!("cargo::rerun-if-changed={}", config.display());
    let header = fs::read_to_string(config)?;
    let number = |name: &str| -> Outcome<u32> {
        let failure = || format!("{} does not define {name}", config.display());
        let mut lines = header.lines().filter_map(|line| line.strip_prefix("#define "));
        let value = lines.find_map(|line| line.strip_prefix(name)).ok_or_else(failure)?;
        Ok(value.trim().parse()?)
    };
    let version = (number("OPENEXR_VERSION_MAJOR ")?, number("OPENEXR_VERSION_MINOR ")?);
    if version < OLDEST || version >= FIRST_UNKNOWN {
        let (major, minor) = version;
        return Err(format!(
            "OpenEXR {major}.{minor} was found ({}), but 3.1 or newer, below 4, is needed.",
            config.display()
        )
        .into());
    }
    Ok(())
}

fn generate(header: &Path, includes: &[PathBuf]) -> Outcome<()> {
    println!("cargo::rerun-if-changed={}", header.display());
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo did not set OUT_DIR")?);
    let oldest_rust = bindgen::RustTarget::stable(85, 0).map_err(|error| error.to_string())?;
    bindgen::Builder::default()
        .header(header.display().to_string())
        .clang_args(includes.iter().map(|folder| format!("-I{}", folder.display())))
        .allowlist_function("exr_.*")
        .allowlist_type("exr_.*")
        .allowlist_var("EXR_.*")
        .prepend_enum_name(false) // C's own names: EXR_PIXEL_HALF
        .rust_target(oldest_rust)
        .rust_edition(bindgen::RustEdition::Edition2024)
        .generate_comments(false)
        .generate()?
        .write_to_file(out.join("bindings.rs"))?;
    Ok(())
}
