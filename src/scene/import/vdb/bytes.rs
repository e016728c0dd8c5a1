//! Bytes of a file, read in order: what is not there is an error, whatever the file says of its size.

/// What is left of a file.
pub struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    /// All of these.
    pub fn new(all: &'a [u8]) -> Self {
        Self { all, at: 0 }
    }

    /// Goes on at a place, from the beginning.
    pub fn go_to(&mut self, place: u64) -> Result<(), String> {
        match usize::try_from(place).ok().filter(|place| *place <= self.all.len()) {
            Some(place) => {
                self.at = place;
                Ok(())
            }
            None => Err(self.cut()),
        }
    }

    /// How many bytes were passed.
    pub fn at(&self) -> usize {
        self.at
    }

    /// The next `count` bytes.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let taken = self.at.checked_add(count).and_then(|end| self.all.get(self.at..end));
        let taken = taken.ok_or_else(|| self.cut())?;
        self.at += count;
        Ok(taken)
    }

    fn cut(&self) -> String {
        format!("it ends at byte {}, before what it says is in it: it is cut off, or damaged", self.all.len())
    }

    /// As many bytes as an array has.
    pub fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.take(N).map(|bytes| bytes.try_into().expect("as many as were asked for"))
    }

    /// A byte.
    pub fn byte(&mut self) -> Result<u8, String> {
        self.array::<1>().map(|[byte]| byte)
    }

    /// A number without a sign.
    pub fn u32(&mut self) -> Result<u32, String> {
        self.array().map(u32::from_le_bytes)
    }

    /// A number with a sign.
    pub fn i32(&mut self) -> Result<i32, String> {
        self.array().map(i32::from_le_bytes)
    }

    /// A long number with a sign.
    pub fn i64(&mut self) -> Result<i64, String> {
        self.array().map(i64::from_le_bytes)
    }

    /// A number of double precision.
    pub fn f64(&mut self) -> Result<f64, String> {
        self.array().map(f64::from_le_bytes)
    }

    /// A count, which a file cannot have more of than bytes.
    pub fn count(&mut self) -> Result<usize, String> {
        let count = self.u32()? as usize;
        if count > self.all.len() { Err(self.cut()) } else { Ok(count) }
    }

    /// A text, with its length before it.
    pub fn text(&mut self) -> Result<String, String> {
        let length = self.count()?;
        Ok(String::from_utf8_lossy(self.take(length)?).into_owned())
    }
}
