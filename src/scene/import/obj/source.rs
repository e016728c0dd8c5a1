//! The text of an OBJ file, in pieces that can be read independently.
//!
//! A file is read piece by piece and never held as a whole. (Not mapped into memory: a mapped file that
//! another program cuts short ends this one.) What is no plain text is read whole: UTF-16, and lines that
//! end in the lone carriage returns of old systems.

use std::borrow::Cow;
use std::fs::File;
use std::io;
use std::ops::Range;
use std::os::unix::fs::FileExt;

use memchr::memchr_iter;

use super::lines::{readable, starts_with_mark};
use crate::input::Input;

/// Bytes in which a line's end is looked for at first; twice as many each time that there is none.
const WINDOW: u64 = 1 << 12;

/// Text that can be read in pieces.
#[derive(Debug)]
pub(super) enum Source<'a> {
    /// A file that is to be read in pieces, and its length in bytes.
    File(File, u64),
    /// The whole text in memory.
    Memory(Cow<'a, [u8]>),
}

impl Source<'_> {
    /// Creates the source of an OBJ file's text.
    pub fn new(input: Input) -> io::Result<Self> {
        let mut head = vec![0; input.length.min(WINDOW) as usize];
        read_at(&input.file, &mut head, 0)?;
        if head.contains(&b'\n') && !starts_with_mark(&head) {
            return Ok(Self::File(input.file, input.length));
        }
        Ok(Self::Memory(Cow::Owned(readable(input.read_all()?))))
    }

    /// Length in bytes.
    pub fn len(&self) -> u64 {
        match self {
            Self::File(_, length) => *length,
            Self::Memory(text) => text.len() as u64,
        }
    }

    /// Returns the bytes of `range`, read into `buffer` if they are not in memory yet.
    pub fn read<'b>(&'b self, range: Range<u64>, buffer: &'b mut Vec<u8>) -> io::Result<&'b [u8]> {
        match self {
            Self::Memory(text) => Ok(&text[range.start as usize..range.end as usize]),
            Self::File(file, _) => {
                buffer.resize((range.end - range.start) as usize, 0);
                read_at(file, buffer, range.start)?;
                Ok(buffer)
            }
        }
    }

    /// Divides the text into ranges of `size` bytes or a little more (much more only where lines are as
    /// long). Each begins with a line that continues no other.
    pub fn pieces(&self, size: u64) -> io::Result<Vec<Range<u64>>> {
        let mut pieces = Vec::new();
        let mut begin = 0;
        while begin < self.len() {
            let end = self.line_after(begin + size)?;
            pieces.push(begin..end);
            begin = end;
        }
        Ok(pieces)
    }

    /// Offset of the first line behind `at` that certainly continues no other line; or the end of the text.
    fn line_after(&self, at: u64) -> io::Result<u64> {
        let mut buffer = Vec::new();
        let mut window = WINDOW;
        while at < self.len() {
            let end = self.len().min(at + window);
            if let Some(offset) = line_in(self.read(at..end, &mut buffer)?) {
                return Ok(at + offset as u64);
            }
            if end == self.len() {
                break;
            }
            window *= 2;
        }
        Ok(self.len())
    }
}

/// Offset of the line behind the first whole line that is not continued. The text may begin within a line.
fn line_in(text: &[u8]) -> Option<usize> {
    let mut ends = memchr_iter(b'\n', text);
    let mut begin = ends.next()? + 1;
    for end in ends {
        if text[begin..end].trim_ascii_end().last() != Some(&b'\\') {
            return Some(end + 1);
        }
        begin = end + 1;
    }
    None
}

fn read_at(file: &File, buffer: &mut [u8], offset: u64) -> io::Result<()> {
    file.read_exact_at(buffer, offset).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => io::Error::new(error.kind(), "it became shorter while it was read"),
        _ => error,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;
    use crate::input::{Kind, open};

    fn pieces(text: &str, size: u64) -> Vec<&str> {
        let source = Source::Memory(Cow::Borrowed(text.as_bytes()));
        let pieces = source.pieces(size).unwrap();
        pieces.iter().map(|piece| &text[piece.start as usize..piece.end as usize]).collect()
    }

    #[test]
    fn pieces_begin_where_no_line_is_continued() {
        assert_eq!(pieces("a\nb\nc\nd\ne\nf", 1), ["a\nb\n", "c\nd\n", "e\nf"]);
        assert_eq!(
            pieces("a\nb \\ \r\nc\\\n\\\nd\n\ne\nf\ng", 1),
            ["a\nb \\ \r\nc\\\n\\\nd\n", "\ne\nf\n", "g"]
        );
        assert_eq!(pieces("one line", 2), ["one line"]);
        assert!(pieces("", 4).is_empty());
    }

    #[test]
    fn long_lines_are_looked_through_once() {
        let line = "x".repeat(3 * WINDOW as usize);
        let text = format!("{line}\n{line}\n{line}\n");
        assert_eq!(pieces(&text, 1), [format!("{line}\n{line}\n"), format!("{line}\n")]);
    }

    #[test]
    fn a_file_gives_what_memory_gives() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("t.obj");
        for text in [&b"v 1\nf 2\n# 3\n# 4\n"[..], b"\xEF\xBB\xBFv 1\nf 2", b"v 1\rf 2", b"", b"\xFF\xFEv\0"]
        {
            std::fs::write(&path, text).unwrap();
            let source = Source::new(open(&path, Kind::Model).unwrap()).unwrap();
            let mut buffer = Vec::new();
            assert_eq!(source.read(0..source.len(), &mut buffer).unwrap(), readable(text.to_vec()));
        }
    }

    #[test]
    fn a_file_that_shrinks_is_an_error() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("t.obj");
        std::fs::write(&path, "v 1\nv 2\n").unwrap();
        let source = Source::new(open(&path, Kind::Model).unwrap()).unwrap();
        std::fs::write(&path, "v").unwrap();
        let error = source.read(0..8, &mut Vec::new()).unwrap_err();
        assert!(error.to_string().contains("shorter"), "{error}");
    }
}
