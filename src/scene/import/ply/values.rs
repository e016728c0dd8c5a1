//! Values of PLY files, one after the other.

use std::io::{self, BufRead};

use super::fault::Fault;

/// Longest number in a text, bytes.
const LONGEST_NUMBER: usize = 64;

/// Type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    Int8,
    Uint8,
    Int16,
    Uint16,
    Int32,
    Uint32,
    Float32,
    Float64,
}

impl Scalar {
    /// Type of this name.
    pub fn called(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::Int8,
            "uchar" | "uint8" => Self::Uint8,
            "short" | "int16" => Self::Int16,
            "ushort" | "uint16" => Self::Uint16,
            "int" | "int32" => Self::Int32,
            "uint" | "uint32" => Self::Uint32,
            "float" | "float32" => Self::Float32,
            "double" | "float64" => Self::Float64,
            _ => return None,
        })
    }

    /// Size in bytes.
    pub fn bytes(self) -> usize {
        match self {
            Self::Int8 | Self::Uint8 => 1,
            Self::Int16 | Self::Uint16 => 2,
            Self::Int32 | Self::Uint32 | Self::Float32 => 4,
            Self::Float64 => 8,
        }
    }
}

/// Source of numbers.
pub trait Values {
    /// Reads the next number, which is of type `kind`.
    fn next(&mut self, kind: Scalar) -> Result<f64, Fault>;

    /// Creates a fault at the last number.
    fn fault(&self, message: String) -> Fault;
}

/// Numbers as bytes.
pub struct Binary<'a, R> {
    bytes: &'a mut R,
    is_big: bool,
}

impl<'a, R: BufRead> Binary<'a, R> {
    /// Creates a source; `is_big`: the most significant byte comes first.
    pub fn new(bytes: &'a mut R, is_big: bool) -> Self {
        Self { bytes, is_big }
    }

    /// Takes the next N bytes, the least significant one first.
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let mut taken = match self.bytes.fill_buf()?.first_chunk::<N>() {
            Some(bytes) => {
                let taken = *bytes;
                self.bytes.consume(N);
                taken
            }
            None => {
                // across the end of the buffer
                let mut taken = [0; N];
                self.bytes.read_exact(&mut taken)?;
                taken
            }
        };
        if self.is_big {
            taken.reverse();
        }
        Ok(taken)
    }
}

impl<R: BufRead> Values for Binary<'_, R> {
    #[inline]
    fn next(&mut self, kind: Scalar) -> Result<f64, Fault> {
        Ok(match kind {
            Scalar::Float32 => f64::from(f32::from_le_bytes(self.take()?)),
            Scalar::Int32 => f64::from(i32::from_le_bytes(self.take()?)),
            Scalar::Uint8 => f64::from(u8::from_le_bytes(self.take()?)),
            Scalar::Uint32 => f64::from(u32::from_le_bytes(self.take()?)),
            Scalar::Float64 => f64::from_le_bytes(self.take()?),
            Scalar::Int8 => f64::from(i8::from_le_bytes(self.take()?)),
            Scalar::Int16 => f64::from(i16::from_le_bytes(self.take()?)),
            Scalar::Uint16 => f64::from(u16::from_le_bytes(self.take()?)),
        })
    }

    fn fault(&self, message: String) -> Fault {
        Fault::whole(message)
    }
}

/// Numbers as words.
pub struct Text<'a, R> {
    bytes: &'a mut R,
    line: usize,
}

impl<'a, R: BufRead> Text<'a, R> {
    /// Creates a source; `lines`: those before it.
    pub fn new(bytes: &'a mut R, lines: usize) -> Self {
        Self { bytes, line: lines + 1 }
    }

    /// Skips blanks, and counts lines.
    #[inline]
    fn skip_blanks(&mut self) -> Result<(), Fault> {
        loop {
            let buffer = self.bytes.fill_buf()?;
            let blanks = buffer.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
            self.line += buffer[..blanks].iter().filter(|byte| **byte == b'\n').count();
            let is_all = blanks == buffer.len();
            if buffer.is_empty() {
                return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into());
            }
            self.bytes.consume(blanks);
            if !is_all {
                return Ok(());
            }
        }
    }
}

impl<R: BufRead> Values for Text<'_, R> {
    fn next(&mut self, _: Scalar) -> Result<f64, Fault> {
        self.skip_blanks()?;
        let (mut word, mut length) = ([0; LONGEST_NUMBER], 0);
        loop {
            let buffer = self.bytes.fill_buf()?;
            let part = buffer.iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
            let fits = part.min(LONGEST_NUMBER - length);
            word[length..length + fits].copy_from_slice(&buffer[..fits]);
            length += fits;
            let goes_on = part > 0 && part == buffer.len() && length < LONGEST_NUMBER;
            self.bytes.consume(part);
            if !goes_on {
                break;
            }
        }
        number(&word[..length]).ok_or_else(|| {
            let word = String::from_utf8_lossy(&word[..length]);
            self.fault(format!("`{word}` is no number: export the file again"))
        })
    }

    fn fault(&self, message: String) -> Fault {
        Fault { line: Some(self.line), message }
    }
}

/// Value of a word: whole numbers, as most are, in the short way.
fn number(word: &[u8]) -> Option<f64> {
    if word.len() < 10 && word.iter().all(u8::is_ascii_digit) {
        return Some(f64::from(word.iter().fold(0, |value, digit| 10 * value + u32::from(digit - b'0'))));
    }
    std::str::from_utf8(word).ok()?.parse().ok()
}
