//! Lines as most files spell them, read sixteen and more bytes at a time. Whatever is spelled otherwise is refused, and
//! left to [`super::number`].
//!
//! One comparison finds all bytes that are no digits, and their mask where each number ends. (Masks instead of looking
//! at byte after byte: G. Langdale and D. Lemire, "Parsing Gigabytes of JSON per Second", 2019, section 3.1.)

#[cfg(target_feature = "sse4.1")]
use bytemuck::cast;
use wide::{CmpEq, CmpGt, i8x16, i8x32};

use super::number::{POWERS, eight_digits, rounded_once};

/// Bytes of the window that is looked at: the beginning of a line, and further bytes that may be loaded
/// behind it.
pub(super) const WINDOW: usize = REACH + 64;

/// Limit in the window before which numbers and corners begin.
const REACH: usize = 128;

/// Maximum number of digits of an index.
const MOST_DIGITS: usize = 7;

/// Places of a number's digits, by the number of digits before the point and by the length of the number. The
/// last digit is in the last lane; lanes before the first one are -1, for zero.
static PLACES: [[[i8; 16]; 16]; 16] = places();

/// Indices of a corner: position, texture coordinate, normal; 0 if left out.
type Corner = [i32; 3];

/// A face as most are.
#[derive(Debug, PartialEq)]
pub(super) enum Face {
    Triangle([Corner; 3]),
    Quad([Corner; 4]),
}

/// A value that was read, the offset of its end, and the byte there.
#[derive(Clone, Copy)]
struct Read<T> {
    value: T,
    end: usize,
    last: u8,
}

/// Reads `count` numbers (of three at most, the others are 0) behind a keyword of `keyword` bytes. Returns
/// also the end of the last one.
#[inline(always)]
pub(super) fn numbers(window: &[u8; WINDOW], keyword: usize, count: usize) -> Option<([f32; 3], usize)> {
    let mut values = [0.0; 3];
    // as if a word ended before the first number
    let mut read = Read { value: 0.0, end: skip_blanks(window, keyword) - 1, last: b' ' };
    // one piece of code for all keywords and numbers: unrolled, it takes longer, because it no longer fits into the
    // processor's cache for decoded code (docs/experiments.md, "Files")
    for value in &mut values[..count] {
        read = number(window, read.next()?)?;
        *value = read.value;
    }
    Some((values, read.end))
}

/// Reads the face behind `f` and a blank, to the line's end. Returns also the length of the line.
#[inline(always)]
pub(super) fn face(window: &[u8; WINDOW]) -> Option<(Face, usize)> {
    let a = corner(window, skip_blanks(window, 2))?;
    let b = corner(window, a.next()?)?;
    let c = corner(window, b.next()?)?;
    if let Some(length) = line_end(window, c.end) {
        return Some((Face::Triangle([a.value, b.value, c.value]), length));
    }
    let d = corner(window, c.next()?)?;
    Some((Face::Quad([a.value, b.value, c.value, d.value]), line_end(window, d.end)?))
}

/// Offset behind the line's end, which comes at byte `at` or after one blank.
#[inline(always)]
pub(super) fn line_end(window: &[u8; WINDOW], at: usize) -> Option<usize> {
    match (window[at], window[at + 1]) {
        (b'\n', _) => Some(at + 1),
        (b' ' | b'\r', b'\n') => Some(at + 2),
        _ => None,
    }
}

/// Reads the number at byte `at`, of fifteen bytes at most: sign and point included, if there are any.
#[inline(always)]
fn number(window: &[u8; WINDOW], at: usize) -> Option<Read<f32>> {
    if at >= REACH {
        return None;
    }
    let minus = usize::from(window[at] == b'-');
    let others = not_digits(sixteen(window, at)?) >> minus;
    let point = others.trailing_zeros() as usize;
    let end = (others & others.wrapping_sub(1)).trailing_zeros() as usize;
    let begin = at + minus;
    if !(2..16).contains(&end) || window[begin + point] != b'.' {
        return whole_number(window, begin, point, minus);
    }
    // the remainders change nothing, but show that no check is needed
    let mantissa = mantissa(sixteen(window, begin)?, &PLACES[point % 16][end]);
    // 14 digits at most: exact, as the power of ten
    let value = rounded_once(mantissa as i64 as f64 / POWERS[(end - 1 - point) % 16])?;
    let value = f32::from_bits(value.to_bits() | (minus as u32) << 31);
    Some(Read { value, end: begin + end, last: window[begin + end] })
}

/// Reads the number of `digits` digits at byte `at`, without a point; `minus` is 1 behind a minus sign.
#[inline(never)]
fn whole_number(window: &[u8; WINDOW], at: usize, digits: usize, minus: usize) -> Option<Read<f32>> {
    if !(1..15).contains(&digits) {
        return None;
    }
    // as if the point were behind the last digit
    let value = rounded_once(mantissa(sixteen(window, at)?, &PLACES[digits][digits + 1]) as f64)?;
    let value = f32::from_bits(value.to_bits() | (minus as u32) << 31);
    Some(Read { value, end: at + digits, last: window[at + digits] })
}

/// Reads the corner at byte `at`: indices of one to seven digits, 0 if left out.
#[inline(always)]
fn corner(window: &[u8; WINDOW], at: usize) -> Option<Read<Corner>> {
    if at >= REACH {
        return None;
    }
    let bytes = thirty_two(window, at)?;
    let others = not_digits_of_32(bytes);
    let first = others.trailing_zeros() as usize;
    let v = index(window, at, first)?;
    // often all three are the same: then the text is, too, where it is moved by one of them
    let moved = thirty_two(window, at + first + 1)?;
    let same = (!bytes.cmp_eq(moved).move_mask()).trailing_zeros() as usize;
    let end = 3 * first + 2;
    if window[at + first] == b'/' && same > 2 * first && others >> end & 1 == 1 {
        return Some(Read { value: [v; 3], end: at + end, last: window[at + end] });
    }
    any_corner(window, at, v, others)
}

/// Reads a corner whose indices differ, the first of which is `v`. `others`: mask of bytes other than digits.
#[inline(never)]
fn any_corner(window: &[u8; WINDOW], at: usize, v: i32, others: u32) -> Option<Read<Corner>> {
    let read = |value, length| Read { value, end: at + length, last: window[at + length] };
    let first = others.trailing_zeros() as usize;
    if window[at + first] != b'/' {
        return Some(read([v, 0, 0], first));
    }
    let others = others & others.wrapping_sub(1);
    let second = others.trailing_zeros() as usize;
    let length = second - first - 1;
    let vt = if length == 0 { 0 } else { index(window, at + first + 1, length)? };
    if window[at + second] != b'/' {
        return (vt > 0).then(|| read([v, vt, 0], second));
    }
    let others = others & others.wrapping_sub(1);
    let third = others.trailing_zeros() as usize;
    let vn = index(window, at + second + 1, third - second - 1)?;
    Some(read([v, vt, vn], third))
}

impl<T> Read<T> {
    /// Offset of the next word, one blank behind this one.
    #[inline(always)]
    fn next(&self) -> Option<usize> {
        (self.last == b' ').then_some(self.end + 1)
    }
}

/// Reads the index at byte `at`, of one to seven digits. 0 has its own meaning, and is refused.
#[inline(always)]
fn index(window: &[u8; WINDOW], at: usize, digits: usize) -> Option<i32> {
    if !(1..=MOST_DIGITS).contains(&digits) {
        return None;
    }
    let bytes = u64::from_le_bytes(*window[at..].first_chunk()?);
    let zeros = u64::from_le_bytes([b'0'; 8]);
    // zeros come in before the first digit, and what is behind the last one goes
    let value = eight_digits((bytes ^ zeros) << (64 - 8 * digits)) as i32;
    (value != 0).then_some(value)
}

/// Computes the value of the digits at `places`.
#[inline(always)]
fn mantissa(bytes: i8x16, places: &[i8; 16]) -> u64 {
    let digits = (bytes - i8x16::splat(b'0' as i8)).swizzle_relaxed(i8x16::new(*places));
    let [high, low] = eights(digits);
    u64::from(high) * 100_000_000 + u64::from(low)
}

/// Computes the value of the first eight digits, and of the others: by pairs, by fours, by eights.
#[cfg(target_feature = "sse4.1")]
#[inline(always)]
fn eights(digits: i8x16) -> [u32; 2] {
    use safe_arch::{
        m128i, mul_i16_horizontal_add_m128i, mul_u8i8_add_horizontal_saturating_m128i, pack_i32_to_u16_m128i,
    };
    let weights = |high: i16| -> m128i { cast([high, 1, high, 1, high, 1, high, 1]) };
    let tens: m128i = cast([[10i8, 1]; 8]);
    let pairs = mul_u8i8_add_horizontal_saturating_m128i(cast(digits), tens);
    let fours = mul_i16_horizontal_add_m128i(pairs, weights(100));
    let eights = mul_i16_horizontal_add_m128i(pack_i32_to_u16_m128i(fours, fours), weights(10_000));
    let [high, low, ..]: [u32; 4] = cast(eights);
    [high, low]
}

#[cfg(not(target_feature = "sse4.1"))]
fn eights(digits: i8x16) -> [u32; 2] {
    let eight = |digits: &[i8]| digits.iter().fold(0, |value, digit| value * 10 + *digit as u32);
    let (high, low) = digits.as_array_ref().split_at(8);
    [eight(high), eight(low)]
}

/// Number that is added to a byte's value, wrapping around: the digits become the lowest ten.
const TO_LOWEST: i8 = (0x80 - b'0') as i8;
const HIGHEST_DIGIT: i8 = i8::MIN + 9;

/// Mask of the bytes that are no digits, one bit each.
#[inline(always)]
fn not_digits(bytes: i8x16) -> u32 {
    (bytes + i8x16::splat(TO_LOWEST)).cmp_gt(i8x16::splat(HIGHEST_DIGIT)).move_mask() as u32
}

/// Mask of the bytes that are no digits, for 32 bytes.
#[inline(always)]
fn not_digits_of_32(bytes: i8x32) -> u32 {
    (bytes + i8x32::splat(TO_LOWEST)).cmp_gt(i8x32::splat(HIGHEST_DIGIT)).move_mask() as u32
}

#[inline(always)]
fn sixteen(window: &[u8; WINDOW], at: usize) -> Option<i8x16> {
    Some(i8x16::new(window[at..].first_chunk::<16>()?.map(|byte| byte as i8)))
}

#[inline(always)]
fn thirty_two(window: &[u8; WINDOW], at: usize) -> Option<i8x32> {
    Some(i8x32::new(window[at..].first_chunk::<32>()?.map(|byte| byte as i8)))
}

#[inline(always)]
fn skip_blanks(window: &[u8; WINDOW], mut at: usize) -> usize {
    while at < REACH && window[at] == b' ' {
        at += 1;
    }
    at
}

const fn places() -> [[[i8; 16]; 16]; 16] {
    let mut places = [[[-1; 16]; 16]; 16];
    let mut point = 0;
    while point < 16 {
        let mut length = point + 1;
        while length < 16 {
            let mut digit = 0;
            while digit < length - 1 {
                let place = if digit < point { digit } else { digit + 1 };
                places[point][length][16 - (length - 1) + digit] = place as i8;
                digit += 1;
            }
            length += 1;
        }
        point += 1;
    }
    places
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::super::number::Cursor;
    use super::super::number::tests::Dice;
    use super::*;

    /// Creates a window with the beginning of a line, and arbitrary bytes behind it.
    fn window(line: &str) -> [u8; WINDOW] {
        let mut window = [b'7'; WINDOW];
        window[..line.len()].copy_from_slice(line.as_bytes());
        window
    }

    #[test]
    fn usual_numbers_are_read_to_the_bit() {
        for word in [
            "0.0",
            "-0.0",
            "1.",
            ".5",
            "-.5",
            "0.123456",
            "-12.345678",
            "1234567.1234567",
            "-0.00000000001",
            "9999999.999999",
            "0.1",
            "123.4",
            "0000000.1",
            "16777.217",
            "-1.0000001",
            "12345678901234.",
            "0",
            "-1",
            "12345678901234",
        ] {
            for end in ["\n", " \n", "\r\n"] {
                let line = format!("v {word}{end}");
                let expected: f32 = word.parse().unwrap();
                let read = number(&window(&line), 2).unwrap();
                assert_eq!(read.value.to_bits(), expected.to_bits(), "{word}");
                assert_eq!(line_end(&window(&line), read.end), Some(line.len()), "{word}");
            }
        }
    }

    /// Digits, points and signs in any order: what is not refused is what `str::parse` reads.
    #[test]
    fn random_words_are_read_to_the_bit_or_refused() {
        let mut dice = Dice(1);
        let mut read = 0;
        for _ in 0..300_000 {
            let mut word = String::new();
            for _ in 0..1 + dice.roll() % 18 {
                word.push(b"0123456789.-9.e/"[dice.roll() as usize % 16] as char);
            }
            let window = window(&format!("{word}\n"));
            let whole = number(&window, 0).filter(|read| line_end(&window, read.end).is_some());
            if let Some(Read { value, .. }) = whole {
                assert_eq!(Ok(f32::to_bits(value)), word.parse().map(f32::to_bits), "{word}");
                read += 1;
            }
        }
        assert!(read > 1000, "{read}");
    }

    /// Between two floats one division does not round as two do: those are left to others.
    #[test]
    fn a_number_that_would_be_rounded_twice_is_refused() {
        let is_read = |word: &str| number(&window(word), 0).is_some();
        assert!(!is_read("16777217.0\n") && !is_read("16777217\n"), "between two floats");
        assert!(!is_read("2097152.125\n"), "between two floats");
        assert!(is_read("2097152.126\n"));
    }

    #[test]
    fn corners_are_read_as_by_the_byte() {
        let mut dice = Dice(2);
        let mut read = 0;
        for _ in 0..300_000 {
            let index = |dice: &mut Dice| (dice.roll() % 10u64.pow(1 + (dice.roll() % 8) as u32)).to_string();
            let indices = [(); 3].map(|()| index(&mut dice));
            let slashes = [(); 3].map(|()| ["", "/", "/", "//", "x", "-", "/-"][dice.roll() as usize % 7]);
            let [a, b, c] = if dice.roll() % 2 == 0 { [0, 0, 0] } else { [0, 1, 2] };
            let [d, e, f] = slashes;
            let word = match dice.roll() % 3 {
                0 => format!("{}{d}", indices[a]),
                1 => format!("{}{d}{}{e}", indices[a], indices[b]),
                _ => format!("{}{d}{}{e}{}{f}", indices[a], indices[b], indices[c]),
            };
            let line = format!("{word} ");
            let Some(corner) = corner(&window(&line), 0) else { continue };
            // what ends at another byte than a blank is refused where the next corner is wanted
            if let Some(next) = corner.next() {
                let text = format!("{word}{}", " ".repeat(16));
                assert_eq!(Cursor { rest: text.as_bytes() }.indices(), Some((corner.value, b' ')), "{word}");
                assert_eq!(next, line.len());
                read += 1;
            }
        }
        assert!(read > 10_000, "{read}");
    }

    #[test]
    fn faces_are_read_to_the_end_of_the_line() {
        let read = |line: &str| face(&window(line));
        let (triangle, quad) = (
            |corners: [Corner; 3], length| Some((Face::Triangle(corners), length)),
            |corners: [Corner; 4], length| Some((Face::Quad(corners), length)),
        );
        assert_eq!(read("f 1 2 3\n"), triangle([[1, 0, 0], [2, 0, 0], [3, 0, 0]], 8));
        assert_eq!(read("f  1/1/1 2/2/2 3/3/3 \n"), triangle([[1; 3], [2; 3], [3; 3]], 22));
        assert_eq!(read("f 1/2 3//4 5/6/7\r\n"), triangle([[1, 2, 0], [3, 0, 4], [5, 6, 7]], 18));
        let seven = "1234567/1234567/1234567";
        let line = format!("f {seven} {seven} {seven} {seven}\n");
        assert_eq!(read(&line), quad([[1_234_567; 3]; 4], line.len()));
        for refused in
            ["f 1 2\n", "f 1 2 3 4 5\n", "f 1 2 3 \\\n", "f 1 2 3 # a\n", "f 1 2 0\n", "f 1 -2 3\n"]
        {
            assert_eq!(read(refused), None, "{refused}");
        }
        assert_eq!(read(&format!("f {} 1 2 3\n", " ".repeat(REACH))), None, "too far behind");
    }
}
