//! Finds Embree: the search order and the version gate, free of side effects so that tests reach them.

use std::path::{Path, PathBuf};

/// Advice for a failed search; the end of each error message.
const REMEDY: &str = "run `make setup` (with EMBREE_DIR unset), or set EMBREE_DIR to a folder that holds \
                      include/embree4/rtcore.h and lib/libembree4.so";

/// Oldest Embree whose structs our bindings describe: 4.3 made `RTCHit` longer.
const OLDEST: Version = Version(4, 3, 0);

/// Major, minor, patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version(pub u32, pub u32, pub u32);

impl std::fmt::Display for Version {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}.{}", self.0, self.1, self.2)
    }
}

/// An Embree that can be bound and linked.
#[derive(Debug)]
pub struct Found {
    /// The folder that holds `embree4/rtcore.h`.
    pub include: PathBuf,
    /// The folder that holds `libembree4.so`.
    pub libdir: PathBuf,
    /// Version in the headers.
    pub version: Version,
}

/// The prefixes to look into, first match wins.
#[derive(Debug)]
pub struct Places {
    /// `EMBREE_DIR`. If set, nothing else is considered: who names a place wants that one or an error.
    pub chosen: Option<PathBuf>,
    /// Prefixes of the system.
    pub system: Vec<PathBuf>,
    /// Prefix of the private copy that `make setup` installs.
    pub private: PathBuf,
    /// Debian's folder below `lib`, for instance `x86_64-linux-gnu`.
    pub multiarch: String,
}

/// Finds the first usable Embree, or says in one sentence what is wrong and what to do.
pub fn locate(places: &Places) -> Result<Found, String> {
    if let Some(prefix) = &places.chosen {
        return examine(prefix, &places.multiarch)
            .map_err(|why| format!("EMBREE_DIR is set, but {}: {REMEDY}", why.sentence()));
    }
    let mut too_old = None;
    for prefix in places.system.iter().chain([&places.private]) {
        match examine(prefix, &places.multiarch) {
            Ok(found) => return Ok(found),
            // A version that was refused explains more than "not found".
            Err(why @ Unusable::TooOld(..)) => too_old = Some(why),
            Err(_) => {}
        }
    }
    Err(match too_old {
        Some(why) => format!("{}: {REMEDY}", why.sentence()),
        None => format!("Embree 4.3 or newer was not found: {REMEDY}"),
    })
}

enum Unusable {
    NoHeader(PathBuf),
    NoVersion(PathBuf),
    NoLibrary(PathBuf),
    TooOld(PathBuf, Version),
}

impl Unusable {
    fn sentence(&self) -> String {
        match self {
            Self::NoHeader(at) => format!("there is no {}", at.display()),
            Self::NoVersion(at) => format!("{} states no version", at.display()),
            Self::NoLibrary(at) => format!("there is no libembree4.so below {}", at.display()),
            Self::TooOld(at, version) => {
                format!("the Embree in {} is {version} and 4.3 or newer is needed", at.display())
            }
        }
    }
}

fn examine(prefix: &Path, multiarch: &str) -> Result<Found, Unusable> {
    let include = prefix.join("include");
    let header = include.join("embree4/rtcore.h");
    if !header.is_file() {
        return Err(Unusable::NoHeader(header));
    }
    let config = include.join("embree4/rtcore_config.h");
    let text = std::fs::read_to_string(&config).unwrap_or_default();
    let version = version_of(&text).ok_or(Unusable::NoVersion(config))?;
    if version < OLDEST {
        return Err(Unusable::TooOld(prefix.to_path_buf(), version));
    }
    let libdir = ["lib".to_owned(), "lib64".to_owned(), format!("lib/{multiarch}")]
        .iter()
        .map(|below| prefix.join(below))
        .find(|dir| dir.join("libembree4.so").is_file())
        .ok_or_else(|| Unusable::NoLibrary(prefix.to_path_buf()))?;
    Ok(Found { include, libdir, version })
}

/// Reads the three `#define RTC_VERSION_…` lines of `rtcore_config.h`.
pub fn version_of(config: &str) -> Option<Version> {
    let number = |name: &str| {
        config.lines().find_map(|line| {
            let mut words = line.split_whitespace();
            let matches = words.next() == Some("#define") && words.next() == Some(name);
            matches.then(|| words.next()?.parse().ok()).flatten()
        })
    };
    Some(Version(number("RTC_VERSION_MAJOR")?, number("RTC_VERSION_MINOR")?, number("RTC_VERSION_PATCH")?))
}
