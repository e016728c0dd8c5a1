//! Files in packages (`.usdz`): as the format has it, not compressed, one after the other in a ZIP file.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use crate::input::{self, Kind};
use crate::memory::{self, Need, Part};

/// Longest end of a ZIP file: its last entry, and a comment (APPNOTE.TXT of PKWARE, 4.3.16).
const MOST_END: u64 = 22 + 65_535;

/// Bytes of a file's entry in the list, and of the head before its bytes, both without its name.
const ENTRY: usize = 46;
const HEAD: usize = 30;

/// A file in a package.
struct Entry {
    is_stored: bool,
    size: u32,
    /// Where its head begins.
    head: u32,
}

/// Reads the file `name` in the package at `path`.
///
/// # Errors A package that is damaged, has no such file, or has it compressed.
pub fn read(path: &Path, name: &str) -> io::Result<Vec<u8>> {
    let wrong = |why: String| io::Error::new(io::ErrorKind::InvalidData, why);
    let damaged = || wrong(String::from("the package is damaged: export it again"));
    let opened = input::open(path, Kind::Model)?;
    let (mut file, length) = (opened.file, opened.length);
    let mut part = |from: u64, bytes: u64| -> io::Result<Vec<u8>> {
        if from.checked_add(bytes).is_none_or(|end| end > length) {
            return Err(damaged());
        }
        let need = Need::new(Part::new("a file in a package", bytes, "smaller files"));
        need.check(&memory::left()).map_err(|error| io::Error::other(error.to_string()))?;
        let mut part = vec![0; bytes as usize];
        file.seek(SeekFrom::Start(from))?;
        file.read_exact(&mut part)?;
        Ok(part)
    };
    let end = part(length.saturating_sub(MOST_END), length.min(MOST_END))?;
    let (start, size) = list(&end).ok_or_else(damaged)?;
    let entries = part(u64::from(start), u64::from(size))?;
    let entry = entry(&entries, name).ok_or_else(|| wrong(format!("the package has no file `{name}`")))?;
    if !entry.is_stored {
        return Err(wrong(format!("`{name}` is compressed in the package: pack it without compression")));
    }
    let head = part(u64::from(entry.head), HEAD as u64)?;
    let between = [26, 28].map(|at| short(&head, at).map(u64::from));
    let [Some(of_name), Some(extra)] = between else { return Err(damaged()) };
    part(u64::from(entry.head) + HEAD as u64 + of_name + extra, u64::from(entry.size))
}

/// Place and size of the list of files, out of the end of a package.
fn list(end: &[u8]) -> Option<(u32, u32)> {
    let at = end.windows(4).rposition(|four| four == b"PK\x05\x06")?;
    Some((long(end, at + 16)?, long(end, at + 12)?))
}

fn entry(mut list: &[u8], name: &str) -> Option<Entry> {
    while list.starts_with(b"PK\x01\x02") {
        let [of_name, extra, comment] = [28, 30, 32].map(|at| short(list, at).map(usize::from));
        let of_name = of_name?;
        if list.get(ENTRY..ENTRY + of_name)? == name.as_bytes() {
            let is_stored = short(list, 10)? == 0 && long(list, 20)? == long(list, 24)?;
            return Some(Entry { is_stored, size: long(list, 24)?, head: long(list, 42)? });
        }
        list = list.get(ENTRY + of_name + extra? + comment?..)?;
    }
    None
}

fn short(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

fn long(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}
