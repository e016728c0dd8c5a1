//! Detects changes of files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Time at which a file was written, and its length in bytes; `None` for a file that is not there.
type Stamp = Option<(Option<SystemTime>, u64)>;

/// Files as they were found.
#[derive(Debug, Default, Clone)]
pub struct Watch(BTreeMap<PathBuf, Stamp>);

impl Watch {
    /// Looks at `files`. What was looked at before keeps its stamp: a change between two looks is one.
    pub fn new(files: impl IntoIterator<Item = PathBuf>, before: &Self) -> Self {
        let stamped = |path: PathBuf| {
            let stamp = before.0.get(&path).copied().unwrap_or_else(|| stamp(&path));
            (path, stamp)
        };
        Self(files.into_iter().map(stamped).collect())
    }

    /// Watch of the same files with their present stamps.
    pub fn now(&self) -> Self {
        Self(self.0.keys().map(|path| (path.clone(), stamp(path))).collect())
    }

    /// Returns true if any of them has changed.
    pub fn has_changed(&self) -> bool {
        self.0.iter().any(|(path, found)| stamp(path) != *found)
    }

    /// The files.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> + '_ {
        self.0.keys().cloned()
    }
}

fn stamp(path: &Path) -> Stamp {
    let found = path.metadata().ok()?;
    Some((found.modified().ok(), found.len()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    #[test]
    fn what_is_written_removed_or_made_has_changed() {
        let folder = tempfile::tempdir().unwrap();
        let [there, missing] = ["a", "b"].map(|name| folder.path().join(name));
        std::fs::write(&there, "1").unwrap();
        let watch = Watch::new([there.clone(), missing.clone()], &Watch::default());
        assert!(!watch.has_changed());
        std::fs::write(&missing, "new").unwrap();
        assert!(watch.has_changed() && !watch.now().has_changed());
        std::fs::remove_file(&missing).unwrap();
        std::fs::write(&there, "longer").unwrap();
        assert!(watch.has_changed());
        assert!(Watch::new([there], &watch).has_changed(), "what changed in between is not forgotten");
    }
}
