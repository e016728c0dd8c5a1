//! Short digests of content: the same content gives the same digest on every machine, and other content
//! another one, but for chance (1 in 10^19). They detect changes, and give no protection against deception.
//!
//! XXH3 with 64 bits: faster than memory, so that files are digested while they are read.

use std::fmt;
use std::hash::Hasher;
use std::io::{self, Read};
use std::str::FromStr;

use twox_hash::XxHash3_64;

/// A digest. As text: 16 hexadecimal digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Digest(u64);

/// Reader that digests what is read through it.
pub struct DigestingReader<R> {
    reader: R,
    state: XxHash3_64,
}

impl<R: Read> DigestingReader<R> {
    /// Creates a reader of what `reader` gives.
    pub fn new(reader: R) -> Self {
        Self { reader, state: XxHash3_64::default() }
    }

    /// Digest of all bytes that were read.
    pub fn digest(&self) -> Digest {
        Digest(self.state.finish())
    }
}

impl<R: Read> Read for DigestingReader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.reader.read(buffer)?;
        self.state.write(&buffer[..count]);
        Ok(count)
    }
}

impl Digest {
    /// Digest of `bytes`.
    pub fn new(bytes: &[u8]) -> Self {
        Self(XxHash3_64::oneshot(bytes))
    }

    /// Digest of several contents, in this order.
    pub fn of_all(digests: impl IntoIterator<Item = Self>) -> Self {
        let bytes: Vec<u8> = digests.into_iter().flat_map(|digest| digest.0.to_le_bytes()).collect();
        Self::new(&bytes)
    }

    /// Converts the digest to eight bytes.
    pub fn to_bytes(self) -> [u8; 8] {
        self.0.to_le_bytes()
    }

    /// Inverse of [`to_bytes`](Self::to_bytes).
    pub fn from_bytes(bytes: [u8; 8]) -> Self {
        Self(u64::from_le_bytes(bytes))
    }

    /// Digest of a table of `width` columns, whose values are `bytes`.
    pub fn of_table(width: u32, bytes: &[u8]) -> Self {
        Self::of_all([Self::new(&width.to_le_bytes()), Self::new(bytes)])
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

impl FromStr for Digest {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let is_digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
        if text.len() != 16 || !text.bytes().all(is_digit) {
            return Err(());
        }
        u64::from_str_radix(text, 16).map(Self).map_err(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_other_machines_have_the_same_digests() {
        // from the specification's own test program: no bytes, seed 0
        assert_eq!(Digest::new(b"").to_string(), "2d06800538d394c2");
        assert_eq!(Digest::new(b"afterimage"), Digest::new(b"afterimage"));
    }

    #[test]
    fn order_and_shape_count() {
        let [a, b] = [&b"a"[..], b"b"].map(Digest::new);
        assert_ne!(Digest::of_all([a, b]), Digest::of_all([b, a]));
        assert_ne!(Digest::of_all([a]), a);
        assert_ne!(Digest::of_table(2, b"abcd"), Digest::of_table(4, b"abcd"));
    }

    #[test]
    fn text_comes_back() {
        let digest = Digest(0x0123);
        assert_eq!(digest.to_string().parse(), Ok(digest));
        for bad in
            ["", "123", "00000000000000123", "+000000000000123", "000000000000012G", "000000000000012A"]
        {
            assert_eq!(bad.parse::<Digest>(), Err(()), "{bad}");
        }
    }
}
