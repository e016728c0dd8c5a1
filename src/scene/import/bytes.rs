//! Bytes of a binary file, read in order: what is not there is an error, whatever the file says of its size.

/// What is wrong, as a part of a sentence.
pub type Check<T = ()> = Result<T, String>;

/// A place in the bytes of a file. Numbers have their least byte first.
#[derive(Clone, Copy)]
pub struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    /// The beginning of a file.
    pub fn new(all: &'a [u8]) -> Self {
        Self { all, at: 0 }
    }

    /// The same file from a place on, if that is in it.
    pub fn from(self, place: u64) -> Option<Self> {
        let at = usize::try_from(place).ok().filter(|at| *at <= self.all.len())?;
        Some(Self { at, ..self })
    }

    /// Goes on at a place, from the beginning.
    pub fn go_to(&mut self, place: u64) -> Check {
        *self = self.from(place).ok_or_else(|| self.cut(place))?;
        Ok(())
    }

    /// How many bytes were passed.
    pub fn place(self) -> u64 {
        self.at as u64
    }

    /// Number of bytes that are left.
    pub fn left(self) -> u64 {
        (self.all.len() - self.at) as u64
    }

    fn cut(&self, wanted: u64) -> String {
        format!("it states {wanted} bytes, and {} are left of it: it is cut off, or damaged", self.left())
    }

    /// The next `count` bytes.
    pub fn take(&mut self, count: usize) -> Check<&'a [u8]> {
        let taken = self.at.checked_add(count).and_then(|end| self.all.get(self.at..end));
        let taken = taken.ok_or_else(|| self.cut(count as u64))?;
        self.at += count;
        Ok(taken)
    }

    /// As many bytes as an array has.
    pub fn array<const N: usize>(&mut self) -> Check<[u8; N]> {
        self.take(N).map(|bytes| bytes.try_into().expect("as many as were asked for"))
    }

    /// A byte.
    pub fn byte(&mut self) -> Check<u8> {
        self.array::<1>().map(|[byte]| byte)
    }

    /// A number without a sign.
    pub fn u32(&mut self) -> Check<u32> {
        self.array().map(u32::from_le_bytes)
    }

    /// A number with a sign.
    pub fn i32(&mut self) -> Check<i32> {
        self.array().map(i32::from_le_bytes)
    }

    /// A long number with a sign.
    pub fn i64(&mut self) -> Check<i64> {
        self.array().map(i64::from_le_bytes)
    }

    /// A number of double precision.
    pub fn f64(&mut self) -> Check<f64> {
        self.array().map(f64::from_le_bytes)
    }

    /// A short count of things, of which a file cannot have more than bytes.
    pub fn count(&mut self) -> Check<usize> {
        let count = self.u32()? as usize;
        if count > self.all.len() { Err(self.cut(count as u64)) } else { Ok(count) }
    }

    /// A text, with its length before it.
    pub fn text(&mut self) -> Check<String> {
        let length = self.count()?;
        Ok(String::from_utf8_lossy(self.take(length)?).into_owned())
    }
}

#[cfg(feature = "usd")]
impl<'a> Bytes<'a> {
    /// Number of bytes of the file.
    pub fn all(self) -> u64 {
        self.all.len() as u64
    }

    /// Takes `count` things of `size` bytes.
    pub fn list(&mut self, count: u64, size: u64) -> Check<&'a [u8]> {
        let bytes = count.saturating_mul(size);
        match usize::try_from(bytes) {
            Ok(bytes) => self.take(bytes),
            Err(_) => Err(self.cut(bytes)),
        }
    }

    /// A long number without a sign.
    pub fn u64(&mut self) -> Check<u64> {
        self.array().map(u64::from_le_bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_is_an_error_and_nothing_is_passed() {
        let mut bytes = Bytes::new(&[1, 0, 0, 0, 2, 9, 9]);
        assert_eq!((bytes.u32(), bytes.byte(), bytes.place(), bytes.left()), (Ok(1), Ok(2), 5, 2));
        assert!(bytes.u32().is_err_and(|why| why.contains("states 4 bytes, and 2 are left")));
        assert!(bytes.take(usize::MAX).is_err() && bytes.go_to(8).is_err() && bytes.from(u64::MAX).is_none());
        assert_eq!((bytes.place(), bytes.take(2)), (5, Ok(&[9, 9][..])));
        assert!(bytes.go_to(7).is_ok() && bytes.byte().is_err());
        assert!(Bytes::new(&[200, 0, 0, 0, 7]).text().is_err(), "a text that is longer than the file");
        assert_eq!(Bytes::new(b"\x02\0\0\0abc").text().as_deref(), Ok("ab"));
    }

    #[cfg(feature = "usd")]
    #[test]
    fn lists_of_more_than_there_is_are_errors() {
        let mut bytes = Bytes::new(&[0; 16]);
        assert!(bytes.list(u64::MAX, 8).is_err() && bytes.list(3, 8).is_err());
        assert_eq!((bytes.list(1, 8).map(<[u8]>::len), bytes.u64(), bytes.all()), (Ok(8), Ok(0), 16));
    }
}
