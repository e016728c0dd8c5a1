//! Reports on disk, whole or not at all.

use std::path::Path;

use serde::Serialize;

use crate::output::{WriteError, write_bytes};

/// Writes `value` as JSON that people can read.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), WriteError> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| WriteError { path: path.to_owned(), source: error.into() })?;
    write_text(path, &format!("{text}\n"))
}

/// Writes `text`.
pub fn write_text(path: &Path, text: &str) -> Result<(), WriteError> {
    write_bytes(path, text.as_bytes())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use std::fs;

    use super::*;

    #[test]
    fn replaces_whole_files_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        write_text(&path, "old, and longer than the new").unwrap();
        write_json(&path, &[1, 2]).unwrap();
        assert_eq!(serde_json::from_str::<Vec<i32>>(&fs::read_to_string(&path).unwrap()).unwrap(), [1, 2]);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn names_the_file_that_it_cannot_write() {
        let folder = tempfile::tempdir().unwrap();
        for path in [folder.path().join("no/such.json"), folder.path().to_owned()] {
            let error = write_text(&path, "x").unwrap_err().to_string();
            assert!(error.contains(&path.display().to_string()), "{error}");
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
