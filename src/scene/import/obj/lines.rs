//! Lines of OBJ and MTL text: any encoding of line ends, continuation by a backslash, byte order marks.

use std::borrow::Cow;

use memchr::memchr;

/// Converts text into an encoding that the readers understand: UTF-16 becomes UTF-8, marks go, and the lone
/// carriage returns of old systems become line ends.
pub(crate) fn readable(bytes: Vec<u8>) -> Vec<u8> {
    match bytes.as_slice() {
        [0xFE, 0xFF, rest @ ..] => utf16(rest, u16::from_be_bytes),
        [0xFF, 0xFE, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xEF, 0xBB, 0xBF, rest @ ..] => rest.to_vec(),
        all if memchr(b'\n', all).is_some() => bytes,
        all => all.iter().map(|byte| if *byte == b'\r' { b'\n' } else { *byte }).collect(),
    }
}

/// Returns true if the text begins with a byte order mark.
pub(crate) fn starts_with_mark(bytes: &[u8]) -> bool {
    matches!(bytes, [0xFE, 0xFF, ..] | [0xFF, 0xFE, ..] | [0xEF, 0xBB, 0xBF, ..])
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Vec<u8> {
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    let text: String = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    readable(text.into_bytes())
}

/// The lines of a text, trimmed, continued ones joined, with the number (from 1) of each one's beginning.
pub(crate) struct Lines<'a> {
    rest: &'a [u8],
    next: usize,
}

impl<'a> Lines<'a> {
    /// Creates the lines of `text`, from its beginning.
    pub fn new(text: &'a [u8]) -> Self {
        Self { rest: text, next: 1 }
    }

    /// Text that was not read yet.
    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Number of physical lines that were read: joined lines count one by one.
    pub fn passed(&self) -> usize {
        self.next - 1
    }

    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let (line, rest) = match memchr(b'\n', self.rest) {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &[][..]),
        };
        self.rest = rest;
        self.next += 1;
        Some(line.trim_ascii())
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        let number = self.next;
        let line = self.physical()?;
        // a comment may well end in a path of Windows
        if line.last() != Some(&b'\\') || line.first() == Some(&b'#') {
            return Some((number, Cow::Borrowed(line)));
        }
        let mut joined = line.to_vec();
        while joined.last() == Some(&b'\\') {
            joined.pop();
            let Some(more) = self.physical() else { break };
            joined.push(b' ');
            joined.extend_from_slice(more);
        }
        Some((number, Cow::Owned(joined.trim_ascii().to_vec())))
    }
}

/// Splits off the first word of a line. Returns it, and the rest without the blanks around it.
pub(crate) fn split_keyword(line: &[u8]) -> (&[u8], &[u8]) {
    let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    (&line[..end], line[end..].trim_ascii())
}

/// The words of a line up to a comment.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let begins_comment = |at: &usize| line[*at] == b'#' && !is_in_number(&line[..*at], &line[at + 1..]);
    let end = (0..line.len()).find(begins_comment).unwrap_or(line.len());
    line[..end].split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// Names of numbers that are not finite, behind `1.#`, as Microsoft's library writes them: `-1.#IND00`.
pub(crate) const NON_FINITE: [(&[u8], f32); 4] =
    [(b"IND", f32::NAN), (b"QNAN", f32::NAN), (b"SNAN", f32::NAN), (b"INF", f32::INFINITY)];

/// Returns true if a `#` between these stands in a number that is not finite, as some systems write it.
fn is_in_number(before: &[u8], behind: &[u8]) -> bool {
    before.ends_with(b"1.") && NON_FINITE.iter().any(|(name, _)| behind.starts_with(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &[u8]) -> Vec<(usize, String)> {
        let text = readable(text.to_vec());
        Lines::new(&text).map(|(n, line)| (n, String::from_utf8_lossy(&line).into_owned())).collect()
    }

    #[test]
    fn joins_continued_lines_and_keeps_count() {
        let read = lines(b"f 1 \\\r\n 2 \\\n3\r\n# c:\\\nv 1 2 3\nend\\");
        let expected = [(1, "f 1  2  3"), (4, "# c:\\"), (5, "v 1 2 3"), (6, "end")];
        assert_eq!(read, expected.map(|(n, line)| (n, line.to_string())));
    }

    #[test]
    fn reads_old_and_wide_encodings() {
        assert_eq!(lines(b"a\rb").len(), 2);
        assert_eq!(lines(b"\xEF\xBB\xBFv 1")[0].1, "v 1");
        assert_eq!(lines(b"\xFE\xFF\0v\0\n\0f"), lines(b"v\nf"));
        assert_eq!(lines(b"\xFF\xFEv\0\n\0f\0"), lines(b"v\nf"));
    }

    #[test]
    fn splits_words() {
        assert_eq!(split_keyword(b"usemtl\t a b "), (&b"usemtl"[..], &b"a b"[..]));
        assert_eq!(words(b" 1\t2 # 3").collect::<Vec<_>>(), [b"1", b"2"]);
        assert_eq!(words(b"-1.#IND00 1.#in #INF").collect::<Vec<_>>(), [&b"-1.#IND00"[..], b"1."]);
    }
}
