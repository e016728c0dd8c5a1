//! Finished frames as a viewer shows them, read back from their files.

use std::fmt;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use image::{ImageFormat, ImageReader};

use super::look::{light_of_srgb, on_screen};
use super::png::srgb_byte;
use crate::input::{self, Kind};
use crate::settings::Look;

/// A picture in 8-bit sRGB.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue of each pixel, row by row from the top.
    pub rgb: Vec<u8>,
}

/// A frame's file that cannot be read back. The text names it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReadBackError {
    /// The file.
    pub path: PathBuf,
    why: String,
}

impl fmt::Display for ReadBackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: cannot read the frame back: {}", self.path.display(), self.why)
    }
}

impl std::error::Error for ReadBackError {}

impl Picture {
    /// Reads the preview at `path`.
    ///
    /// # Errors It is no PNG that can be read.
    pub fn of_png(path: &Path) -> Result<Self, ReadBackError> {
        let file = input::open(path, Kind::Picture).map_err(|error| failed(path, error))?.file;
        let reader = ImageReader::with_format(BufReader::new(file), ImageFormat::Png);
        let picture = reader.decode().map_err(|error| failed(path, error))?.into_rgb8();
        Ok(Self { width: picture.width(), height: picture.height(), rgb: picture.into_raw() })
    }

    /// Reads the frame at `path`, and encodes it as a preview with this `look`. `channels` names its red,
    /// green and blue.
    ///
    /// # Errors It is no EXR that can be read, or has no such channels.
    pub fn of_exr(path: &Path, channels: [&str; 3], look: Look) -> Result<Self, ReadBackError> {
        let parts = openexr::part_count(path).map_err(|error| failed(path, error))?;
        for part in 0..parts {
            let head = openexr::read_header_of(path, part).map_err(|error| failed(path, error))?;
            let place = |name| head.channels.iter().position(|channel| channel.name == name);
            let [Some(red), Some(green), Some(blue)] = channels.map(place) else { continue };
            let places = [red, green, blue];
            let mut light = [const { Vec::new() }; 3];
            let keep = |channel: usize, lines: &[f32]| {
                let planes = light.iter_mut().zip(places).filter(|(_, place)| *place == channel);
                planes.for_each(|(plane, _)| plane.extend_from_slice(lines));
            };
            openexr::scan_part(path, part, keep).map_err(|error| failed(path, error))?;
            let [red, green, blue] = &light;
            let (on_screen, pixels) = (on_screen(look), red.iter().zip(green).zip(blue));
            let rgb = pixels
                .flat_map(|((red, green), blue)| on_screen([*red, *green, *blue]).map(srgb_byte))
                .collect();
            return Ok(Self { width: head.width, height: head.height, rgb });
        }
        Err(failed(path, format!("it has no {}", channels.join(" "))))
    }

    /// Scales the picture to at most `width` by `height` pixels in the same proportions, never to more than
    /// it has. Each pixel is the mean of the light of those that it covers.
    #[must_use]
    pub fn within(&self, width: u32, height: u32) -> Self {
        let factor =
            (f64::from(width) / f64::from(self.width)).min(f64::from(height) / f64::from(self.height));
        if factor >= 1.0 {
            return self.clone();
        }
        let scaled = |side: u32| ((f64::from(side) * factor).round() as usize).max(1);
        let size = [scaled(self.width), scaled(self.height)];
        let full = [self.width as usize, self.height as usize];
        let light: Vec<f32> = (0..=255_u8).map(|byte| light_of_srgb(f32::from(byte) / 255.0)).collect();
        // first and behind the last
        let covered = |at: usize, axis: usize| {
            let first = at * full[axis] / size[axis];
            first..((at + 1) * full[axis]).div_ceil(size[axis]).max(first + 1)
        };
        let mut rgb = Vec::with_capacity(size[0] * size[1] * 3);
        for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
            let mut sum = [0.0_f32; 3];
            let (rows, columns) = (covered(y, 1), covered(x, 0));
            let count = (rows.len() * columns.len()) as f32;
            for row in rows {
                let pixels =
                    &self.rgb[(row * full[0] + columns.start) * 3..(row * full[0] + columns.end) * 3];
                for pixel in pixels.chunks_exact(3) {
                    sum.iter_mut().zip(pixel).for_each(|(sum, byte)| *sum += light[usize::from(*byte)]);
                }
            }
            rgb.extend(sum.map(|sum| srgb_byte(sum / count)));
        }
        Self { width: size[0] as u32, height: size[1] as u32, rgb }
    }
}

fn failed(path: &Path, why: impl fmt::Display) -> ReadBackError {
    ReadBackError { path: path.to_owned(), why: why.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smaller_pictures_have_the_mean_of_the_light() {
        let rgb: Vec<u8> = [[0, 0, 0], [255, 255, 255], [10, 20, 30], [10, 20, 30]].concat();
        let small = Picture { width: 4, height: 1, rgb }.within(2, 9);
        // half of the light is byte 188
        assert_eq!((small.width, small.height, small.rgb), (2, 1, vec![188, 188, 188, 10, 20, 30]));
    }

    #[test]
    fn pictures_that_fit_stay() {
        let picture = Picture { width: 1, height: 2, rgb: vec![7; 6] };
        assert_eq!(picture.within(5, 2), picture);
        assert_eq!(picture.within(5, 1).height, 1);
    }
}
