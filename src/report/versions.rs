//! Versions of the program, its libraries and the machine, for results.

use std::fmt;

use serde::Serialize;

use crate::trace::BackendKind;

/// Versions of the program and its libraries, and the machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Versions {
    /// Version of the program: `git describe` if the build knew it, otherwise the package's version.
    pub afterimage: &'static str,
    /// Version of the Embree library that is loaded.
    pub embree: String,
    /// Version of the OpenEXR library that is loaded.
    pub openexr: String,
    /// Name of the processor, from the system.
    pub cpu: String,
    /// Name of its arithmetic with Embree: machines with the same one give the same pixels.
    pub arithmetic: String,
    /// Number of threads that work now.
    pub threads: usize,
}

/// Version of this program.
pub const AFTERIMAGE: &str = concat!(env!("CARGO_PKG_VERSION"), " (", env!("AFTERIMAGE_GIT_DESCRIBE"), ")");

impl Versions {
    /// Asks the libraries and the system.
    pub fn here() -> Self {
        Self {
            afterimage: AFTERIMAGE,
            embree: embree(),
            openexr: openexr::version(),
            cpu: cpu(),
            arithmetic: super::arithmetic::name(BackendKind::Embree),
            threads: rayon::current_num_threads(),
        }
    }
}

/// The version of Embree that is loaded.
pub fn embree() -> String {
    match embree::Device::new("") {
        Ok(device) => device.version(),
        Err(error) => format!("does not start: {error}"),
    }
}

impl fmt::Display for Versions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "afterimage  {}", self.afterimage)?;
        writeln!(f, "Embree      {}", self.embree)?;
        writeln!(f, "OpenEXR     {}", self.openexr)?;
        writeln!(f, "CPU         {}, {} threads", self.cpu, self.threads)?;
        write!(f, "arithmetic  {}", self.arithmetic)
    }
}

fn cpu() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    model_name(&info).unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

fn model_name(info: &str) -> Option<String> {
    let line = info.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_the_processor() {
        let info = "processor\t: 0\nmodel name\t: Swift 9000 @ 3 GHz\n";
        assert_eq!(model_name(info).as_deref(), Some("Swift 9000 @ 3 GHz"));
        assert_eq!(model_name(""), None);
        assert!(!cpu().is_empty());
    }
}
