//! Numbers as OBJ files write them, read where they stand: eight digits at a time, exact to the bit.

use std::str;

use super::lines::NON_FINITE;

const ZEROS: u64 = 0x3030_3030_3030_3030;

/// Powers of ten in 64-bit integers.
const WHOLE_POWERS: [u64; 9] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// Powers of ten that an f64 holds exactly.
pub(super) const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Limit up to which each whole number is exact as an f64.
const EXACT_MANTISSA: u64 = 1 << 53;

/// Maximum number of digits that surely fit into 64 bits.
const MOST_DIGITS: usize = 19;

/// Text that is still to be read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cursor<'a> {
    pub rest: &'a [u8],
}

impl Cursor<'_> {
    /// Returns the next byte; a line end behind the end of the text.
    #[inline(always)]
    pub fn peek(&self) -> u8 {
        self.rest.first().copied().unwrap_or(b'\n')
    }

    /// Advances by `count` bytes, if there are as many.
    #[inline(always)]
    pub fn skip(&mut self, count: usize) -> Option<()> {
        self.rest = self.rest.get(count..)?;
        Some(())
    }

    /// Advances to the next byte that is no blank; a line end is not a blank here.
    #[inline(always)]
    pub fn skip_blanks(&mut self) {
        // mostly there are none: one comparison
        while let [b'\0'..=b' ', rest @ ..] = self.rest {
            if !is_blank(self.peek()) {
                break;
            }
            self.rest = rest;
        }
    }

    /// Reads the number here, as `str::parse` does, and the byte behind it, a blank or the line's end.
    /// Advances behind both. `None` also close to the end of the text.
    pub fn number(&mut self) -> Option<(f32, u8)> {
        match self.usual_number() {
            Some((value, end, length)) => {
                self.skip(length)?;
                Some((value, end))
            }
            None => self.any_number(),
        }
    }

    /// Reads up to three indices with slashes between (0 for one that is left out between two), and the byte
    /// behind them. Advances behind all. `None` if there is no index, and close to the end of the text.
    pub fn indices(&mut self) -> Option<([i32; 3], u8)> {
        let mut indices = [0; 3];
        let mut end = b'/';
        for (part, index) in indices.iter_mut().enumerate() {
            if end == b'/' && (part != 1 || self.peek() != b'/') {
                (*index, end) = self.any_index()?;
            } else if end == b'/' {
                self.skip(1)?;
            }
        }
        Some((indices, end))
    }

    /// Reads an index that is not 0, negative ones as they are, and the byte behind it. Advances behind both.
    fn any_index(&mut self) -> Option<(i32, u8)> {
        let is_negative = self.peek() == b'-';
        self.skip(usize::from(is_negative))?;
        let (mut count, mut value) = leading_digits(self.eight(0)?);
        if count == 8 {
            let (more, low) = leading_digits(self.eight(8)?);
            value = value * WHOLE_POWERS[more] + low;
            count += more;
        }
        let end = *self.rest.get(count)?;
        self.skip(count + 1)?;
        let value = i32::try_from(value).ok().filter(|value| *value != 0 && count < 16)?;
        Some((if is_negative { -value } else { value }, end))
    }

    /// Reads a number of up to 15 digits. Returns also the byte behind it, and the length of both.
    fn usual_number(&self) -> Option<(f32, u8, usize)> {
        let is_negative = self.peek() == b'-';
        let mut at = usize::from(is_negative);
        let (mut digits, mut mantissa) = leading_digits(self.eight(at)?);
        at += digits;
        let mut exponent = 0;
        if self.rest.get(at) == Some(&b'.') {
            at += 1;
            // a full eight: there may be more
            for _ in 0..2 {
                let (count, low) = leading_digits(self.eight(at)?);
                mantissa = mantissa.wrapping_mul(WHOLE_POWERS[count]).wrapping_add(low);
                at += count;
                exponent -= count as i32;
                if count < 8 {
                    break;
                }
            }
            digits += exponent.unsigned_abs() as usize;
        }
        if self.rest.get(at)? | 0x20 == b'e' {
            let (power, length) = self.exponent(at + 1)?;
            exponent += power;
            at += 1 + length;
        }
        let end = *self.rest.get(at)?;
        let is_complete = end == b'\n' || is_blank(end);
        if !is_complete || digits == 0 || digits > MOST_DIGITS || mantissa > EXACT_MANTISSA {
            return None;
        }
        let power = *POWERS.get(exponent.unsigned_abs() as usize)?;
        let mantissa = mantissa as i64 as f64; // as signed: one instruction
        let value = rounded_once(if exponent < 0 { mantissa / power } else { mantissa * power })?;
        Some((if is_negative { -value } else { value }, end, at + 1))
    }

    /// Reads the exponent at `ahead`, behind its `e`. Returns also its length.
    fn exponent(&self, ahead: usize) -> Option<(i32, usize)> {
        let sign = *self.rest.get(ahead)?;
        let begin = usize::from(matches!(sign, b'+' | b'-'));
        let (count, value) = leading_digits(self.eight(ahead + begin)?);
        let value = value as i32; // 8 digits at most
        (count > 0 && count < 8).then_some((if sign == b'-' { -value } else { value }, begin + count))
    }

    #[cold]
    fn any_number(&mut self) -> Option<(f32, u8)> {
        let length = self.rest.iter().position(u8::is_ascii_whitespace)?;
        let value = (parsed(&self.rest[..length])?, self.rest[length]);
        self.skip(length + 1)?;
        Some(value)
    }

    /// Loads eight bytes, the first one lowest.
    #[inline(always)]
    fn eight(&self, ahead: usize) -> Option<u64> {
        let bytes = self.rest.get(ahead..)?.first_chunk()?;
        Some(u64::from_le_bytes(*bytes))
    }
}

/// Returns true for blanks within a line: ASCII whitespace without the line end.
#[inline(always)]
pub(super) fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r' | b'\x0C')
}

/// Parses a whole word as a number.
pub(super) fn parsed(word: &[u8]) -> Option<f32> {
    str::from_utf8(word).ok()?.parse().ok().or_else(|| non_finite(word))
}

/// Parses a number that is not finite, as Microsoft's library writes it.
#[cold]
fn non_finite(word: &[u8]) -> Option<f32> {
    let (sign, digits) = word.strip_prefix(b"-").map_or((1.0, word), |digits| (-1.0, digits));
    let name = digits.strip_prefix(b"1.#")?;
    NON_FINITE.iter().find(|(known, _)| name.starts_with(known)).map(|(_, value)| sign * value)
}

/// Counts the digits at the beginning of eight bytes, from the lowest on, and gives their value.
#[inline(always)]
fn leading_digits(bytes: u64) -> (usize, u64) {
    let bytes = bytes ^ ZEROS;
    // beyond the first byte that is no digit, carries may spoil the marks: only the lowest mark counts
    let marks = (bytes.wrapping_add(0x7676_7676_7676_7676) | bytes) & 0x8080_8080_8080_8080;
    let bits = marks.trailing_zeros() & !7;
    if bits == 0 {
        return (0, 0);
    }
    // leading zeros come in; all 8 digits stay where they are
    ((bits / 8) as usize, eight_digits(bytes << (bits.wrapping_neg() % 64)))
}

/// The value of eight digits (not their letters), the first one lowest.
#[inline(always)]
pub(super) fn eight_digits(digits: u64) -> u64 {
    // pairs of digits, then both halves at once: D. Lemire, "Quickly parsing eight digits" (2018)
    let pairs = digits.wrapping_mul(10).wrapping_add(digits >> 8);
    const LOW: u64 = 0x0000_00FF_0000_00FF;
    let high = (pairs & LOW).wrapping_mul(100 + (1_000_000 << 32));
    let low = ((pairs >> 16) & LOW).wrapping_mul(1 + (10_000 << 32));
    high.wrapping_add(low) >> 32
}

/// Rounds an f64, which was rounded once, to the f32 nearest to the exact value. `None` if it lies just
/// between two f32, and the exact value could be on either side of it.
///
/// W. D. Clinger, "How to Read Floating Point Numbers Accurately" (1990), section 3: where mantissa and
/// power of ten are exact, one operation rounds once. (With at most 2^53 for one and 10^22 for the other
/// there is neither an overflow nor a subnormal f32.)
#[inline(always)]
pub(super) fn rounded_once(value: f64) -> Option<f32> {
    const DROPPED: u64 = (1 << 29) - 1;
    (value.to_bits() & DROPPED != 1 << 28).then_some(value as f32)
}

#[cfg(test)]
pub(super) mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    /// Random-looking numbers, the same in each run (SplitMix64).
    pub struct Dice(pub u64);

    impl Dice {
        pub fn roll(&mut self) -> u64 {
            self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
            mixed ^ mixed >> 31
        }
    }

    #[track_caller]
    fn same_as_std(word: &str) {
        // with bytes behind it, and at the very end of the text
        for end in [" 1 2 3 4 5 6 7 8 9", " 1", "\n", "\t ", "\r\n        "] {
            let text = format!("{word}{end}");
            let mut cursor = Cursor { rest: text.as_bytes() };
            let expected = word.parse().ok().map(|value| (f32::to_bits(value), end.as_bytes()[0]));
            assert_eq!(cursor.number().map(|(value, end)| (value.to_bits(), end)), expected, "{word}");
            assert!(expected.is_none() || cursor.rest == &end.as_bytes()[1..], "{word}");
        }
    }

    #[test]
    fn random_floats_are_read_as_std_reads_them() {
        let mut dice = Dice(1);
        for _ in 0..200_000 {
            let float = f32::from_bits(dice.roll() as u32);
            same_as_std(&format!("{float}"));
            same_as_std(&format!("{float:e}"));
            let near = (dice.roll() as i32 as f64) / (1u64 << (dice.roll() % 40)) as f64;
            same_as_std(&format!("{near:.*}", (dice.roll() % 17) as usize));
            same_as_std(&format!("{near:.*e}", (dice.roll() % 17) as usize));
        }
    }

    #[test]
    fn random_digits_are_read_as_std_reads_them() {
        let mut dice = Dice(2);
        for _ in 0..200_000 {
            let sign = ["", "-", "+"][(dice.roll() % 3) as usize];
            let whole = dice.roll() >> (dice.roll() % 64);
            let fraction = dice.roll() >> (dice.roll() % 64);
            same_as_std(&format!("{sign}{whole}.{fraction}"));
            same_as_std(&format!("{sign}{whole}"));
            same_as_std(&format!("{sign}.{fraction:020}"));
            same_as_std(&format!("{sign}{whole}.{fraction}e{}", (dice.roll() % 100) as i32 - 50));
        }
    }

    /// Just between two floats, or off it by less than an f64 can tell.
    #[test]
    fn numbers_between_two_floats_are_rounded_once() {
        let mut dice = Dice(3);
        for _ in 0..50_000 {
            let float = 1.0 + (dice.roll() as u32 >> 9) as f64 / (1u32 << 23) as f64;
            let middle = float + 0.5f64.powi(24);
            same_as_std(&format!("{middle}"));
            same_as_std(&format!("{middle:.30}"));
            same_as_std(&format!("{middle}0000001"));
        }
        same_as_std("16777217");
        same_as_std("16777217.0000001");
        same_as_std("1.00000005960464477539062500000000000000001");
    }

    #[test]
    fn odd_spellings_are_read_as_std_reads_them() {
        for word in [
            "0",
            "-0",
            "-0.0",
            "+1",
            "1.",
            ".5",
            "-.5",
            ".",
            "-",
            "+",
            "",
            "1e",
            "1e+",
            "1e5",
            "1E-5",
            "1e+05",
            "1e400",
            "1e-400",
            "1e99999999999",
            "nan",
            "NaN",
            "inf",
            "-inf",
            "infinity",
            "1.2.3",
            "1-2",
            "--1",
            "1,5",
            "0x10",
            "1e5.5",
            "3.4028235e38",
            "3.4028236e38",
            "1e-45",
            "1.17549435e-38",
            "00000000000.5",
            "0000000000000000000000001",
            "123456789012345678901234567890",
            "9007199254740993",
            "1_0",
            "1f",
        ] {
            same_as_std(word);
        }
    }

    #[test]
    fn indices_are_read_with_what_is_behind() {
        let indices = |text: &str| {
            let far_from_the_end = format!("{text}{}", " ".repeat(16));
            Cursor { rest: far_from_the_end.as_bytes() }.indices().map(|(indices, _)| indices)
        };
        for (text, expected) in [
            ("7", [7, 0, 0]),
            ("7/8/9", [7, 8, 9]),
            ("7//9", [7, 0, 9]),
            ("7/8", [7, 8, 0]),
            ("7/7/7", [7, 7, 7]),
            ("7/77/7", [7, 77, 7]),
            ("77/7/78", [77, 7, 78]),
            ("1234567//1234567", [1_234_567, 0, 1_234_567]),
            ("1234567/1234567/1234567", [1_234_567; 3]),
            ("12345678/2147483647/1", [12_345_678, i32::MAX, 1]),
            ("-12//-3", [-12, 0, -3]),
            ("1/-2/3", [1, -2, 3]),
        ] {
            assert_eq!(indices(text), Some(expected), "{text}");
        }
        for none in ["2147483648", "0", "1/0", "-0", "x", "--1", "", "/1", "1/", "1//", "1/2/", "1///2"] {
            assert_eq!(indices(none), None, "{none}");
        }
        let end = |text: &str| {
            Cursor { rest: format!("{text}                                ").as_bytes() }.indices()
        };
        assert_eq!(end("1/2/3\n"), Some(([1, 2, 3], b'\n')));
        assert_eq!(end("1/2/3/4"), Some(([1, 2, 3], b'/')));
        assert_eq!(end("1/1/1x"), Some(([1, 1, 1], b'x')));
        assert_eq!(Cursor { rest: b"1/1/1" }.indices(), None);
    }

    #[test]
    fn counts_digits_up_to_whatever_comes_first() {
        for other in 0..=255u8 {
            for at in 0..8 {
                let mut bytes = *b"12345678";
                bytes[at] = other;
                let digits = if other.is_ascii_digit() { 8 } else { at };
                let value =
                    bytes[..digits].iter().fold(0, |value, digit| value * 10 + u64::from(digit - b'0'));
                assert_eq!(leading_digits(u64::from_le_bytes(bytes)), (digits, value), "{other} at {at}");
            }
        }
    }
}
