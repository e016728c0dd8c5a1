//! Careful reading of the statements of an OBJ file: any spelling that the format allows, and for everything
//! else a message that says what is wrong and what to do.

use half::f16;

use super::lines::words;
use super::number::parsed;
use crate::scene::details::vertex_color;
use crate::scene::import::faces::run::MOST_CORNERS;
use crate::scene::texture::linear_share;

/// Stands for `-0`: it counts back beyond the first of anything.
pub(super) const BEYOND_THE_FIRST: i64 = i64::MIN;

/// A corner of a face as written: position, texture coordinate, normal. From 1, negative ones count
/// back from the last one that is defined so far, 0 is absent.
pub(super) type Corner = [i64; 3];

/// Message for a face's corner that cannot be read at all.
const NO_CORNER: &str = "is no corner of a face: write v, v/vt, v//vn or v/vt/vn";

/// Reads three numbers behind `v` or `vn`. Weights of curves, or colours, may follow them.
pub(super) fn three(keyword: &str, rest: &[u8]) -> Result<[f32; 3], String> {
    numbers(rest, 3).ok_or_else(|| wanted(keyword, "three numbers", rest, 3))
}

/// Reads a colour behind a position: three numbers, as screens show them. Returns it as light.
pub(super) fn color_behind(rest: &[u8]) -> Option<[f16; 3]> {
    let shown: [f32; 3] = numbers(rest, 3)?;
    Some(vertex_color(shown.map(|share| linear_share(f64::from(share).clamp(0.0, 1.0)))))
}

/// Reads one number or two behind `vt`.
pub(super) fn texture_coordinate(rest: &[u8]) -> Result<[f32; 2], String> {
    numbers(rest, 1).ok_or_else(|| wanted("vt", "two numbers", rest, 2))
}

/// Reads N numbers, of which the first `least` are required; those left out are 0.
fn numbers<const N: usize>(rest: &[u8], least: usize) -> Option<[f32; N]> {
    let mut values = [0.0; N];
    let mut count = 0;
    for (value, word) in values.iter_mut().zip(words(rest)) {
        *value = parsed(word)?;
        count += 1;
    }
    (count >= least).then_some(values)
}

fn wanted(keyword: &str, what: &str, rest: &[u8], most: usize) -> String {
    let mut shown = String::from(keyword);
    for word in words(rest).take(most) {
        shown.push(' ');
        shown.push_str(&String::from_utf8_lossy(word));
    }
    let shown: String = shown.chars().take(60).collect();
    format!("`{keyword}` takes {what}, found `{shown}`")
}

/// Reads the corner that `word` means.
pub(super) fn corner(word: &[u8]) -> Result<Corner, String> {
    let mut indices = [0; 3];
    for (part, digits) in word.split(|byte| *byte == b'/').enumerate() {
        indices[part.min(2)] =
            integer(digits).filter(|_| part < 3).ok_or_else(|| format!("`{}` {NO_CORNER}", shown(word)))?;
    }
    if indices[0] == 0 {
        return Err(format!("`{}` names no vertex: indices count from 1", shown(word)));
    }
    Ok(indices)
}

/// Returns the beginning of a word, for messages.
pub(super) fn shown(word: &[u8]) -> String {
    String::from_utf8_lossy(&word[..word.len().min(40)]).into_owned()
}

/// Message that a face has more corners than [`MOST_CORNERS`].
pub(super) fn too_many_corners(corners: usize) -> String {
    format!("a face of {corners} corners: at most {MOST_CORNERS} are read, split it in the modeller")
}

/// Reads the value of an index; 0 for nothing. A number too large for any file is no index.
fn integer(digits: &[u8]) -> Option<i64> {
    let (negative, digits) = match digits {
        [] => return Some(0),
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() || digits.len() > 18 || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let value = digits.iter().fold(0, |value, digit| value * 10 + i64::from(digit - b'0'));
    Some(match (negative, value) {
        (true, 0) => BEYOND_THE_FIRST,
        (true, _) => -value,
        (false, _) => value,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_the_format_allows() {
        assert_eq!(three("v", b"1 +2\t-.5 0.5 0.5 # red"), Ok([1.0, 2.0, -0.5]));
        assert_eq!(
            (texture_coordinate(b"1 2 3"), texture_coordinate(b"1")),
            (Ok([1.0, 2.0]), Ok([1.0, 0.0]))
        );
        for (word, indices) in [
            ("1", [1, 0, 0]),
            ("1/2", [1, 2, 0]),
            ("-1//+3", [-1, 0, 3]),
            ("1/2/3", [1, 2, 3]),
            ("1//", [1, 0, 0]),
        ] {
            assert_eq!(corner(word.as_bytes()), Ok(indices));
        }
    }

    #[test]
    fn says_what_is_wrong() {
        assert_eq!(three("v", b"1 2 # 3"), Err("`v` takes three numbers, found `v 1 2`".into()));
        assert!(three("vn", b"1 x 3").is_err_and(|message| message.contains("`vn 1 x 3`")));
        assert!(texture_coordinate(b"").is_err_and(|message| message.contains("two numbers")));
        for bad in ["x", "1.5", "1/2/3/4", "-", "99999999999999999999", "1/a"] {
            assert!(corner(bad.as_bytes()).is_err_and(|message| message.contains("no corner")), "{bad}");
        }
        assert!(corner(b"0").is_err_and(|message| message.contains("count from 1")));
    }
}
