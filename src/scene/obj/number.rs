//! Numbers as OBJ files write them, read where they stand: eight digits at a time, exact to the bit.

use std::str;

const ZEROS: u64 = 0x3030_3030_3030_3030;

/// Powers of ten that a 64-bit integer holds.
const WHOLE_POWERS: [u64; 9] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// Powers of ten that an f64 holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Up to here each whole number is an f64.
const EXACT_MANTISSA: u64 = 1 << 53;

/// Most digits that surely fit into 64 bits.
const MOST_DIGITS: usize = 19;

/// A place in a text.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cursor<'a> {
    /// All of it.
    pub text: &'a [u8],
    /// Offset of the next byte.
    pub at: usize,
}

impl<'a> Cursor<'a> {
    /// The byte `ahead` of the next one; behind the end there are line ends.
    #[inline(always)]
    pub fn peek(&self, ahead: usize) -> u8 {
        self.text.get(self.at + ahead).copied().unwrap_or(b'\n')
    }

    /// Goes to the next byte that is no blank; a line end is none here.
    #[inline(always)]
    pub fn skip_blanks(&mut self) {
        while is_blank(self.peek(0)) {
            self.at += 1;
        }
    }

    /// The number here, as `str::parse` reads it; what follows is a blank or the line's end.
    #[inline(always)]
    pub fn number(&mut self) -> Option<f32> {
        match self.short_number() {
            Some((value, end)) => {
                self.at = end;
                Some(value)
            }
            None => self.any_number(),
        }
    }

    /// An index that is not 0, negative ones as they are; what follows is not looked at.
    #[inline(always)]
    pub fn index(&mut self) -> Option<i64> {
        let negative = self.peek(0) == b'-';
        let begin = self.at + usize::from(negative);
        let (mut count, mut value) = leading_digits(self.eight(begin));
        if count == 8 {
            let (more, low) = leading_digits(self.eight(begin + 8));
            if more == 8 {
                return None;
            }
            value = value * WHOLE_POWERS[more] + low;
            count += more;
        }
        self.at = begin + count;
        let value = value as i64; // 15 digits at most
        (value != 0).then_some(if negative { -value } else { value })
    }

    /// A number of few digits, and where it ends.
    ///
    /// W. D. Clinger, "How to Read Floating Point Numbers Accurately" (1990), section 3: where mantissa and
    /// power of ten are exact, one operation rounds once. It is done in f64 and rounded again, to f32. That
    /// is the same as rounding once, unless the f64 lies just between two f32: those are left to others.
    #[inline(always)]
    fn short_number(&self) -> Option<(f32, usize)> {
        let negative = self.peek(0) == b'-';
        let mut at = self.at + usize::from(negative);
        let (mut digits, mut mantissa) = leading_digits(self.eight(at));
        at += digits;
        let mut exponent = 0;
        if self.byte(at) == b'.' {
            at += 1;
            // a full eight: there may be more
            for _ in 0..2 {
                let (count, low) = leading_digits(self.eight(at));
                mantissa = mantissa.wrapping_mul(WHOLE_POWERS[count]).wrapping_add(low);
                at += count;
                exponent -= count as i32;
                if count < 8 {
                    break;
                }
            }
            digits += exponent.unsigned_abs() as usize;
        }
        if self.byte(at) | 0x20 == b'e' {
            let (power, end) = self.exponent(at + 1)?;
            exponent += power;
            at = end;
        }
        let ends = matches!(self.byte(at), b' ' | b'\n') || is_blank(self.byte(at));
        if !ends || digits == 0 || digits > MOST_DIGITS || mantissa > EXACT_MANTISSA {
            return None;
        }
        let power = *POWERS.get(exponent.unsigned_abs() as usize)?;
        let mantissa = mantissa as i64 as f64; // as signed: one instruction
        let value = if exponent < 0 { mantissa / power } else { mantissa * power };
        if is_between_two(value) {
            return None;
        }
        // powers of ten from -22 to 37: neither an overflow nor a subnormal number
        let value = value as f32;
        Some((if negative { -value } else { value }, at))
    }

    /// The exponent at `at`, behind its `e`, and where it ends.
    #[inline]
    fn exponent(&self, at: usize) -> Option<(i32, usize)> {
        let sign = self.byte(at);
        let begin = at + usize::from(matches!(sign, b'+' | b'-'));
        let (count, value) = leading_digits(self.eight(begin));
        let value = value as i32; // 8 digits at most
        (count > 0 && count < 8).then_some((if sign == b'-' { -value } else { value }, begin + count))
    }

    #[cold]
    fn any_number(&mut self) -> Option<f32> {
        let rest = &self.text[self.at..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let value = parsed(&rest[..end])?;
        self.at += end;
        Some(value)
    }

    #[inline(always)]
    fn byte(&self, at: usize) -> u8 {
        self.text.get(at).copied().unwrap_or(b'\n')
    }

    /// Eight bytes, the first one lowest. Where there are fewer: zeros, which are no digits.
    #[inline(always)]
    fn eight(&self, at: usize) -> u64 {
        let bytes = self.text.get(at..).and_then(|rest| rest.first_chunk());
        bytes.map_or(0, |bytes| u64::from_le_bytes(*bytes))
    }
}

/// Blanks within a line: what ASCII calls whitespace, without the line end.
#[inline(always)]
pub(super) fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r' | b'\x0C')
}

/// A whole word as a number.
pub(super) fn parsed(word: &[u8]) -> Option<f32> {
    str::from_utf8(word).ok()?.parse().ok()
}

/// How many of eight bytes, from the lowest on, are digits, and their value.
#[inline(always)]
fn leading_digits(bytes: u64) -> (usize, u64) {
    // beyond the first byte that is none, carries may spoil the marks: only the lowest mark counts
    let no_digit =
        (bytes.wrapping_add(0x4646_4646_4646_4646) | bytes.wrapping_sub(ZEROS)) & 0x8080_8080_8080_8080;
    let count = no_digit.trailing_zeros() / 8;
    // two shifts, because one may not be by all 64 bits; leading zeros come in
    let half = 32 - 4 * count;
    let digits = ((bytes ^ ZEROS) << half) << half;
    // pairs of digits, then both halves at once: D. Lemire, "Quickly parsing eight digits" (2018)
    let pairs = digits.wrapping_mul(10).wrapping_add(digits >> 8);
    const LOW: u64 = 0x0000_00FF_0000_00FF;
    let high = (pairs & LOW).wrapping_mul(100 + (1_000_000 << 32));
    let low = ((pairs >> 16) & LOW).wrapping_mul(1 + (10_000 << 32));
    (count as usize, high.wrapping_add(low) >> 32)
}

/// Whether `value` lies just in the middle between two neighbouring f32 (of the usual range).
#[inline(always)]
fn is_between_two(value: f64) -> bool {
    const DROPPED: u64 = (1 << 29) - 1;
    value.to_bits() & DROPPED == 1 << 28
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    /// Numbers that look random, the same in each run (SplitMix64).
    struct Dice(u64);

    impl Dice {
        fn roll(&mut self) -> u64 {
            self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
            mixed ^ mixed >> 31
        }
    }

    #[track_caller]
    fn same_as_std(word: &str) {
        // with bytes behind it, and at the very end of the text
        for text in [format!("{word} 1 2 3 4 5"), word.to_string(), format!("{word}\n")] {
            let mut cursor = Cursor { text: text.as_bytes(), at: 0 };
            let read = cursor.number().map(f32::to_bits);
            assert_eq!(read, word.parse().ok().map(f32::to_bits), "{word}");
            assert!(read.is_none() || cursor.at == word.len(), "{word}");
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
            same_as_std(&format!("{:.*e}", (dice.roll() % 17) as usize, near));
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
    fn indices_are_read_and_zero_is_none() {
        let index = |text: &str| {
            let mut cursor = Cursor { text: text.as_bytes(), at: 0 };
            (cursor.index(), cursor.at)
        };
        assert_eq!(index("7/8/9 12345"), (Some(7), 1));
        assert_eq!(index("-12 345678"), (Some(-12), 3));
        assert_eq!(index("12345678 12345678"), (Some(12_345_678), 8));
        assert_eq!(index("123456789012345 12345678"), (Some(123_456_789_012_345), 15));
        for none in ["1234567890123456 12345678", "0 0000000000", "-0 000000000", "x 00000000", "5"] {
            assert_eq!(index(none).0, None, "{none}");
        }
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
