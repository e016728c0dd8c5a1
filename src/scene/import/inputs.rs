//! Files that a shot is made of.

use std::path::PathBuf;

use crate::digest::Digest;

/// Files that were read so far, and digests of what they hold. Pictures keep their own.
#[derive(Default)]
pub(in crate::scene) struct Inputs {
    files: Vec<PathBuf>,
    digests: Vec<Digest>,
}

impl Inputs {
    /// Adds files, and the digest of all that they hold.
    pub fn add(&mut self, files: impl IntoIterator<Item = PathBuf>, digest: Digest) {
        self.files.extend(files);
        self.digests.push(digest);
    }

    /// Adds the digest of something that is no file, and decides pictures as well.
    pub fn depend_on(&mut self, digest: Digest) {
        self.digests.push(digest);
    }

    /// The files, and `last` after them.
    pub fn files(&self, last: impl IntoIterator<Item = PathBuf>) -> Vec<PathBuf> {
        self.files.iter().cloned().chain(last).collect()
    }

    /// Digest of everything, and `last` after it.
    pub fn digest(&self, last: Digest) -> Digest {
        Digest::of_all(self.digests.iter().copied().chain([last]))
    }
}
