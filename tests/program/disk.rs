//! Small file systems for tests.

use std::ffi::CString;
use std::fs;
use std::path::Path;

use rustix::mount::{MountFlags, UnmountFlags, mount, unmount};

/// A small file system of its own, as long as this lives.
pub struct Disk<'a>(&'a Path);

impl<'a> Disk<'a> {
    /// `None`, with a message, where this is not allowed.
    pub fn new(bytes: u64, at: &'a Path) -> Option<Self> {
        Self::with(bytes, at, MountFlags::empty())
    }

    /// One that nobody can write to.
    pub fn read_only(at: &'a Path) -> Option<Self> {
        Self::with(1 << 20, at, MountFlags::RDONLY)
    }

    fn with(bytes: u64, at: &'a Path, flags: MountFlags) -> Option<Self> {
        fs::create_dir(at).unwrap();
        let size = CString::new(format!("size={bytes}")).unwrap();
        let disk = mount("tmpfs", at, "tmpfs", flags, size.as_c_str()).is_ok().then_some(Self(at));
        if disk.is_none() {
            println!("skipped: a small file system cannot be mounted here (run as root)");
        }
        disk
    }
}

impl Drop for Disk<'_> {
    fn drop(&mut self) {
        // what fails here is no more than a leftover of the test
        let _ = unmount(self.0, UnmountFlags::empty());
    }
}
