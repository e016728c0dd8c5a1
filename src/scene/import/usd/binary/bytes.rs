//! Bytes of a file, read one after the other.

/// What is wrong, as a part of a sentence.
pub type Check<T = ()> = Result<T, String>;

/// Bytes that a byte of an LZ4 block can stand for, at most.
pub const MOST_RATIO: u64 = 255;

/// What is left of a file.
#[derive(Clone, Copy)]
pub struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    pub fn new(all: &'a [u8]) -> Self {
        Self { all, at: 0 }
    }

    /// The bytes from a place on, if that is in the file.
    pub fn at(all: &'a [u8], place: u64) -> Option<Self> {
        Self::new(all).from(place)
    }

    /// The same file from a place on.
    pub fn from(self, place: u64) -> Option<Self> {
        let at = usize::try_from(place).ok().filter(|at| *at <= self.all.len())?;
        Some(Self { at, ..self })
    }

    /// Where this is.
    pub fn place(self) -> u64 {
        self.at as u64
    }

    /// Number of bytes that are left.
    pub fn left(self) -> u64 {
        (self.all.len() - self.at) as u64
    }

    /// Number of bytes of the file.
    pub fn all(self) -> u64 {
        self.all.len() as u64
    }

    pub fn take(&mut self, count: u64) -> Check<&'a [u8]> {
        if count > self.left() {
            return Err(format!("states {count} bytes, and {} are left of the file", self.left()));
        }
        let bytes = &self.all[self.at..self.at + count as usize];
        self.at += count as usize;
        Ok(bytes)
    }

    /// Takes `count` things of `size` bytes.
    pub fn list(&mut self, count: u64, size: u64) -> Check<&'a [u8]> {
        let bytes = count.checked_mul(size).filter(|bytes| *bytes <= self.left());
        match bytes {
            Some(bytes) => self.take(bytes),
            None => Err(format!("states {count} things, and {} bytes are left of the file", self.left())),
        }
    }

    pub fn u8(&mut self) -> Check<u8> {
        Ok(self.take(1)?[0])
    }

    pub fn u32(&mut self) -> Check<u32> {
        Ok(u32::from_le_bytes(self.take(4)?.try_into().unwrap_or_default()))
    }

    pub fn u64(&mut self) -> Check<u64> {
        Ok(u64::from_le_bytes(self.take(8)?.try_into().unwrap_or_default()))
    }

    /// Takes a number of things, of which each takes a quarter of a byte or more of what is packed.
    pub fn count(&mut self) -> Check<u64> {
        let count = self.u64()?;
        if count > self.left().saturating_mul(4 * MOST_RATIO) {
            return Err(format!("states {count} things, and {} bytes are left of the file", self.left()));
        }
        Ok(count)
    }
}
