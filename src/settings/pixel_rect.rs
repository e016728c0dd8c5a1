//! Rectangles of pixels.

use serde::Serialize;

/// Rectangle of pixels, counted from the picture's first to the right and down. Pixels left of the picture or
/// above it have negative places.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct PixelRect {
    /// First column.
    pub x: i32,
    /// First row.
    pub y: i32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl PixelRect {
    /// Parses the form of the command line: `WxH+X+Y`, with `-` before a negative place.
    pub fn parse(text: &str) -> Option<Self> {
        let (width, rest) = text.split_once(['x', 'X'])?;
        let signs: Vec<usize> = rest.match_indices(['+', '-']).map(|(at, _)| at).collect();
        let [x, y] = signs[..] else { return None };
        let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
        let count = |text: &str| digits(text).then(|| text.parse().ok()).flatten();
        let place = |text: &str| digits(&text[1..]).then(|| text.parse().ok()).flatten();
        Some(Self {
            width: count(width)?,
            height: count(&rest[..x])?,
            x: place(&rest[x..y])?,
            y: place(&rest[y..])?,
        })
    }

    /// Number of pixels.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Returns true if `other` is not empty and lies in it.
    pub fn holds(&self, other: &Self) -> bool {
        let within = |first: i32, count: u32, other: i32, others: u32| {
            let [first, count, other, others] =
                [i64::from(first), i64::from(count), i64::from(other), i64::from(others)];
            first <= other && other + others <= first + count && others > 0
        };
        within(self.x, self.width, other.x, other.width) && within(self.y, self.height, other.y, other.height)
    }
}

impl std::fmt::Display for PixelRect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { x, y, width, height } = self;
        write!(f, "{width}x{height}{x:+}{y:+}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_are_read_as_they_are_written() {
        for text in ["64x32+8+16", "1x1+0+0", "70x40-8-16", "9x9-1+65535"] {
            assert_eq!(PixelRect::parse(text).map(|rect| rect.to_string()).as_deref(), Some(text));
        }
        let wrong = [
            "",
            "64x32",
            "64x32+8",
            "64x32+8+",
            "64x+8+8",
            "x32+1+1",
            "+6x3+1+1",
            "6x3+1+1+1",
            "6x3+-1+1",
            "6x3+1+1 ",
        ];
        for text in
            wrong.into_iter().chain(["99999999999x1+0+0", "1x1+99999999999+0", "6.5x3+1+1", "6x\u{663}+1+1"])
        {
            assert_eq!(PixelRect::parse(text), None, "{text}");
        }
    }
}
