//! Finds the files that other files name, even if those were written on another system.

use std::path::{Component, Path, PathBuf};

/// The existing file that `name` means, seen from `folder`.
///
/// Tries in turn the name as it stands, with backslashes for slashes, without regard to case, and the
/// bare file name in `folder`: files get copied together, and absolute names are another machine's.
pub(crate) fn find_beside(folder: &Path, name: &str) -> Option<PathBuf> {
    let slashed = name.replace('\\', "/");
    let bare = slashed.rsplit('/').next().unwrap_or_default();
    [name, &slashed]
        .into_iter()
        .map(|name| folder.join(name))
        .find(|path| may_be_read(path))
        .or_else(|| any_case(folder, Path::new(&slashed)))
        .or_else(|| any_case(folder, Path::new(bare)))
}

/// Walks down from `folder`, and takes at each step the entry that agrees but for case. Where several
/// do, the first in alphabetical order, so that the answer does not depend on the file system.
fn any_case(folder: &Path, name: &Path) -> Option<PathBuf> {
    let mut at = folder.to_path_buf();
    for part in name.components() {
        at = match part {
            Component::Normal(part) if at.join(part).exists() => at.join(part),
            Component::Normal(part) => {
                let wanted = part.to_str()?.to_lowercase();
                let here = if at.as_os_str().is_empty() { Path::new(".") } else { &at };
                let entries = here.read_dir().ok()?.filter_map(Result::ok).map(|entry| entry.file_name());
                let same = entries.filter(|entry| entry.to_string_lossy().to_lowercase() == wanted);
                at.join(same.min()?)
            }
            Component::ParentDir => at.join(".."),
            Component::CurDir => at,
            Component::RootDir | Component::Prefix(_) => return None,
        };
    }
    may_be_read(&at).then_some(at)
}

/// Returns true for anything that exists and is no folder. Opening it later reports why it cannot be read, if
/// it is no file.
fn may_be_read(path: &Path) -> bool {
    path.metadata().is_ok_and(|found| !found.is_dir())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    #[test]
    fn finds_names_of_other_systems() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("Maps")).unwrap();
        let picture = folder.path().join("Maps/Wood 1.png");
        std::fs::write(&picture, "").unwrap();
        std::fs::write(folder.path().join("top.mtl"), "").unwrap();
        for name in ["Maps/Wood 1.png", "maps\\wood 1.PNG", "./Maps/../maps/Wood 1.png"] {
            let found = find_beside(folder.path(), name).unwrap();
            assert_eq!(found.canonicalize().unwrap(), picture.canonicalize().unwrap(), "{name}");
        }
        for name in ["/top.mtl", "C:\\models\\top.mtl", "lost/top.mtl"] {
            assert_eq!(find_beside(folder.path(), name).unwrap(), folder.path().join("top.mtl"), "{name}");
        }
        assert_eq!(find_beside(folder.path(), "none.png"), None);
        assert_eq!(find_beside(folder.path(), ""), None);
    }
}
