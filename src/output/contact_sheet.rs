//! Frames of a run side by side in one picture, each with its number below.

use super::picture::Picture;

/// Maximum number of frames on a sheet.
pub const MOST_FRAMES: usize = 60;
/// Maximum width and height of a frame on it, pixels.
const LARGEST: [u32; 2] = [256, 192];
/// Gap between frames, pixels.
const GAP: usize = 8;
/// Aspect ratio that the sheet comes as close to as its frames allow.
const ASPECT: f64 = 16.0 / 9.0;

const PAPER: [u8; 3] = [24, 24, 26];
const INK: [u8; 3] = [190, 190, 194];

/// Columns and rows of a figure, and pixels of the sheet for each of its dots.
const FIGURE: [usize; 2] = [5, 7];
const DOT: usize = 2;

/// The figures 0 to 9 and the minus sign: a row of five dots in each byte, from the top.
const FIGURES: [[u8; 7]; 11] = [
    [0x0e, 0x11, 0x13, 0x15, 0x19, 0x11, 0x0e],
    [0x04, 0x0c, 0x04, 0x04, 0x04, 0x04, 0x0e],
    [0x0e, 0x11, 0x01, 0x02, 0x04, 0x08, 0x1f],
    [0x1f, 0x02, 0x04, 0x02, 0x01, 0x11, 0x0e],
    [0x02, 0x06, 0x0a, 0x12, 0x1f, 0x02, 0x02],
    [0x1f, 0x10, 0x1e, 0x01, 0x01, 0x11, 0x0e],
    [0x06, 0x08, 0x10, 0x1e, 0x11, 0x11, 0x0e],
    [0x1f, 0x01, 0x02, 0x04, 0x08, 0x08, 0x08],
    [0x0e, 0x11, 0x11, 0x0e, 0x11, 0x11, 0x0e],
    [0x0e, 0x11, 0x11, 0x0f, 0x01, 0x02, 0x0c],
    [0x00, 0x00, 0x00, 0x0e, 0x00, 0x00, 0x00],
];

/// Chooses those of `frames` that a sheet shows: all, or as many as it has room for, evenly spaced, with the
/// first and the last.
pub fn chosen(frames: &[i32]) -> Vec<i32> {
    if frames.len() <= MOST_FRAMES {
        return frames.to_vec();
    }
    (0..MOST_FRAMES).map(|i| frames[i * (frames.len() - 1) / (MOST_FRAMES - 1)]).collect()
}

/// Scales a picture to its size on a sheet.
#[must_use]
pub fn thumbnail(picture: &Picture) -> Picture {
    picture.within(LARGEST[0], LARGEST[1])
}

/// Draws frames' numbers and [`thumbnail`]s on one sheet, row by row. Empty without any.
#[must_use]
pub fn sheet(frames: &[(i32, Picture)]) -> Picture {
    let widest = frames.iter().map(|(_, picture)| picture.width as usize).max().unwrap_or(0);
    let highest = frames.iter().map(|(_, picture)| picture.height as usize).max().unwrap_or(0);
    // under each frame its number, and room around it
    let [across, down] = [widest + GAP, highest + FIGURE[1] * DOT + 2 * GAP];
    let columns = (frames.len() as f64 * ASPECT * down as f64 / across as f64).sqrt().round() as usize;
    let columns = columns.clamp(1, frames.len().max(1));
    let rows = frames.len().div_ceil(columns);
    let mut sheet = Canvas::new(columns * across + GAP, rows * down + GAP);
    for (i, (frame, picture)) in frames.iter().enumerate() {
        let [x, y] = [GAP + i % columns * across, GAP + i / columns * down];
        sheet.place(picture, [x, y]);
        sheet.write(&frame.to_string(), [x, y + highest + GAP / 2 + 1]);
    }
    sheet.0
}

struct Canvas(Picture);

impl Canvas {
    fn new(width: usize, height: usize) -> Self {
        let rgb = PAPER.repeat(width * height);
        Self(Picture { width: width as u32, height: height as u32, rgb })
    }

    /// Draws a picture with its upper left pixel at `place`: column and row.
    fn place(&mut self, picture: &Picture, [x, y]: [usize; 2]) {
        let width = picture.width as usize * 3;
        for (row, pixels) in picture.rgb.chunks_exact(width).enumerate() {
            let first = ((y + row) * self.0.width as usize + x) * 3;
            self.0.rgb[first..first + width].copy_from_slice(pixels);
        }
    }

    /// Draws a number. Parts beyond the sheet are left out.
    fn write(&mut self, number: &str, [x, y]: [usize; 2]) {
        for (i, figure) in number.chars().enumerate() {
            let rows = FIGURES[figure.to_digit(10).map_or(10, |digit| digit as usize)];
            for (row, column) in
                (0..FIGURE[1] * DOT).flat_map(|row| (0..FIGURE[0] * DOT).map(move |x| (row, x)))
            {
                let is_ink = rows[row / DOT] >> (FIGURE[0] - 1 - column / DOT) & 1 == 1;
                let [at, line] = [x + i * (FIGURE[0] + 1) * DOT + column, y + row];
                if is_ink && at < self.0.width as usize {
                    let first = (line * self.0.width as usize + at) * 3;
                    self.0.rgb[first..first + 3].copy_from_slice(&INK);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_frames_some_are_chosen_with_both_ends() {
        let frames: Vec<i32> = (-10..=2000).collect();
        let chosen = chosen(&frames);
        assert_eq!((chosen.len(), chosen[0], chosen[MOST_FRAMES - 1]), (MOST_FRAMES, -10, 2000));
        let steps: Vec<i32> = chosen.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|step| [34, 35].contains(step)), "{steps:?}");
        assert_eq!(super::chosen(&[3, 5]), [3, 5]);
    }

    #[test]
    fn each_frame_has_its_place_and_its_number() {
        let picture = |byte| Picture { width: 20, height: 10, rgb: vec![byte; 600] };
        let sheet = sheet(&[(1, picture(100)), (-2, picture(150)), (30, picture(200))]);
        let count = |byte: u8| sheet.rgb.chunks_exact(3).filter(|pixel| **pixel == [byte; 3]).count();
        assert_eq!([100, 150, 200].map(count), [200; 3]);
        let ink = sheet.rgb.chunks_exact(3).filter(|pixel| **pixel == INK).count();
        let dots: u32 = [1, 10, 2, 3, 0].iter().flat_map(|i| FIGURES[*i]).map(u8::count_ones).sum();
        // the minus sign's frame has room for both figures
        assert_eq!(ink, dots as usize * DOT * DOT);
        assert_eq!(sheet.rgb.len(), sheet.width as usize * sheet.height as usize * 3);
    }
}
