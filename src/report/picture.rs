//! Small pictures for the report, as PNG in data URIs.

use std::cmp::Ordering;
use std::io::Cursor;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use crate::film::{Film, Plane};
use crate::output::false_color;
use crate::output::look::on_screen;
use crate::settings::Look;

/// Widest picture in a report, pixels.
const WIDEST: usize = 560;

/// Widest map in a report, pixels. Pages show maps enlarged, on phones as well: a browser that makes them smaller may leave
/// out the thin lines that they are looked at for.
const WIDEST_MAP: usize = 320;

/// A status: the plane's layer channel, its colour (sRGB), and its meaning.
pub struct StatusKey {
    /// Name in the contract.
    pub name: &'static str,
    /// Colour, sRGB.
    pub color: [u8; 3],
    /// Meaning, in a sentence.
    pub meaning: &'static str,
}

/// All statuses in the order of the contract.
pub const STATUSES: [StatusKey; 5] = [
    StatusKey {
        name: "base",
        color: [138, 143, 152],
        meaning: "traced because the whole frame was: a base frame, which is the first one, one at a cut, or one of those at regular distances",
    },
    StatusKey {
        name: "good",
        color: [46, 164, 79],
        meaning: "carried over alone into its cell, checked, and right",
    },
    StatusKey {
        name: "overlapped",
        color: [47, 129, 247],
        meaning: "several samples fell into the cell; the nearest won, was checked, and is right",
    },
    StatusKey { name: "missed", color: [218, 54, 51], meaning: "nothing fell into the cell; traced" },
    StatusKey {
        name: "obscured",
        color: [219, 138, 20],
        meaning: "what fell into the cell is hidden now; traced",
    },
];

/// Formats a colour as `#2ea44f`.
pub fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Encodes the picture as a viewer shows it with this `look`: the `denoised` one, if there is one. `None` if
/// the film has no picture.
pub fn beauty(film: &Film, denoised: Option<&[Plane; 3]>, look: Look) -> Option<String> {
    let denoised = denoised.map(|planes| planes.each_ref().map(|plane| plane.values.to_floats()));
    let (planes, on_screen) = (denoised.or_else(|| colors(film))?, on_screen(look));
    Some(Blocks::new(film, WIDEST).png(|block| {
        let mut sum = [0.0; 3];
        for pixel in block {
            let light = on_screen(planes.each_ref().map(|plane| plane[*pixel]));
            sum.iter_mut().zip(light).for_each(|(sum, light)| *sum += light);
        }
        sum.map(|sum| to_byte(sum / block.len() as f32))
    }))
}

/// Draws the difference between the pictures of two films of the same size in false colours. `None` if one
/// has no picture. Each block of [`block_side`] shows its largest difference.
pub fn difference_map(a: &Film, b: &Film) -> Option<String> {
    let (a_planes, b_planes) = (colors(a)?, colors(b)?);
    let apart = |pixel: &usize| {
        let channels = a_planes.iter().zip(&b_planes).map(|(a, b)| (a[*pixel] - b[*pixel]).abs());
        channels.fold(0.0, larger)
    };
    let largest = |block: &[usize]| block.iter().map(apart).fold(0.0, larger);
    Some(Blocks::new(a, WIDEST_MAP).png(|block| false_color::of_difference(largest(block))))
}

/// The larger value. A NaN is larger than any number.
fn larger(a: f32, b: f32) -> f32 {
    if b.is_nan() || b > a { b } else { a }
}

/// Draws each pixel in the colours of its samples' statuses. `None` if the film has no statuses. Each block
/// of [`block_side`] shows its worst pixel: that with most samples traced anew, then with most overlapped
/// ones.
pub fn status_map(film: &Film) -> Option<String> {
    let names = STATUSES.map(|status| format!("status_{}.V", status.name));
    let planes = names.iter().map(|name| film.values(name)).collect::<Option<Vec<_>>>()?;
    let colors = STATUSES.map(|status| status.color.map(|byte| linear(f32::from(byte) / 255.0)));
    let badness = |pixel: usize| {
        let [overlapped, missed, obscured] = [2, 3, 4].map(|status: usize| planes[status][pixel]);
        [missed + obscured, overlapped]
    };
    let worse = |a: &&usize, b: &&usize| badness(**a).partial_cmp(&badness(**b)).unwrap_or(Ordering::Equal);
    Some(Blocks::new(film, WIDEST_MAP).png(|block| {
        let worst = block.iter().max_by(worse).copied().unwrap_or(0);
        let mut sum = [0.0; 3];
        for (plane, color) in planes.iter().zip(colors) {
            for (channel, part) in sum.iter_mut().zip(color) {
                *channel += plane[worst] * part;
            }
        }
        sum.map(to_byte)
    }))
}

/// Pixels along an edge of the blocks that a map of a picture of this width shows as one pixel.
pub fn block_side(width: u32) -> usize {
    side(width, WIDEST_MAP)
}

fn side(width: u32, widest: usize) -> usize {
    (width as usize).div_ceil(widest).max(1)
}

fn colors(film: &Film) -> Option<[Vec<f32>; 3]> {
    Some([film.values("R")?, film.values("G")?, film.values("B")?])
}

/// A film in square blocks of pixels, cut off at its right and lower rim.
struct Blocks {
    side: usize,
    /// Size of the film.
    size: [usize; 2],
}

impl Blocks {
    /// Divides a film into blocks, at most `widest` of them in a row.
    fn new(film: &Film, widest: usize) -> Self {
        Self { side: side(film.width, widest), size: [film.width, film.height].map(|edge| edge as usize) }
    }

    /// Draws a pixel for each block; `color` gives its sRGB from the numbers of the block's pixels.
    fn png(&self, color: impl Fn(&[usize]) -> [u8; 3]) -> String {
        let [width, height] = self.size;
        let [columns, rows] = self.size.map(|edge| edge.div_ceil(self.side));
        let mut bytes = Vec::with_capacity(columns * rows * 3);
        let mut block = Vec::with_capacity(self.side * self.side);
        for (top, left) in (0..height)
            .step_by(self.side)
            .flat_map(|top| (0..width).step_by(self.side).map(move |left| (top, left)))
        {
            block.clear();
            for y in top..(top + self.side).min(height) {
                block.extend((left..(left + self.side).min(width)).map(|x| y * width + x));
            }
            bytes.extend(color(&block));
        }
        png_uri(&bytes, columns as u32, rows as u32)
    }
}

fn png_uri(rgb: &[u8], width: u32, height: u32) -> String {
    let mut png = Cursor::new(Vec::new());
    PngEncoder::new(&mut png)
        .write_image(rgb, width, height, ExtendedColorType::Rgb8)
        .expect("memory takes every byte, and the bytes are as many as the size says");
    format!("data:image/png;base64,{}", base64(png.get_ref()))
}

fn to_byte(linear: f32) -> u8 {
    (encoded(linear) * 255.0 + 0.5) as u8
}

/// Encodes linear light by sRGB's curve.
fn encoded(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`encoded`].
fn linear(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Encodes bytes as base64: RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let group = (0..3).fold(0_u32, |group, i| group << 8 | u32::from(*chunk.get(i).unwrap_or(&0)));
        for digit in 0..4 {
            let index = (group >> (18 - 6 * digit)) & 63;
            text.push(if digit <= chunk.len() { DIGITS[index as usize] as char } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Plane, PlaneKind};

    fn film_of(width: u32, height: u32, planes: &[(&'static str, Vec<f32>)]) -> Film {
        let planes = planes.iter().map(|(name, values)| Plane::new(*name, PlaneKind::Half, values));
        Film { width, height, planes: planes.collect() }
    }

    fn film(width: u32, height: u32, names: &[(&'static str, f32)]) -> Film {
        let data = |value| vec![value; (width * height) as usize];
        let planes: Vec<_> = names.iter().map(|&(name, value)| (name, data(value))).collect();
        film_of(width, height, &planes)
    }

    /// Decodes the pixels of a data URI. Returns also the number of pixels in a row.
    fn decoded(uri: &str) -> (Vec<[u8; 3]>, u32) {
        let text = uri.strip_prefix("data:image/png;base64,").expect("a PNG");
        let digit = |byte: u8| match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' => 62,
            _ => 63,
        };
        let digits: Vec<u8> = text.trim_end_matches('=').bytes().map(digit).collect();
        let bits = digits.chunks(4).flat_map(|four| {
            let group = (0..4).fold(0_u32, |group, i| group << 6 | u32::from(*four.get(i).unwrap_or(&0)));
            group.to_be_bytes()[1..four.len()].to_vec()
        });
        let picture = image::load_from_memory(&bits.collect::<Vec<u8>>()).expect("a PNG").to_rgb8();
        (picture.pixels().map(|pixel| pixel.0).collect(), picture.width())
    }

    #[test]
    fn base64_pads_as_the_rfc_shows() {
        let cases = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (bytes, text) in cases {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn wide_pictures_shrink() {
        let film_of = |red| film(1200, 31, &[("R", red), ("G", f32::NAN), ("B", -1.0)]);
        let uri = beauty(&film_of(2.0), None, Look::default()).expect("a picture");
        let (pixels, width) = decoded(&uri);
        assert_eq!((width, pixels.len()), (400, 400 * 11), "the last row of blocks is one of pixels");
        assert!(pixels.iter().all(|pixel| pixel[0] == 255 && pixel[2] == 0));
        let darker = beauty(&film_of(2.0), None, Look { exposure: -2.0, ..Look::default() });
        assert_eq!(darker, beauty(&film_of(0.5), None, Look::default()));
        assert!(darker != Some(uri) && beauty(&film(1, 1, &[]), None, Look::default()).is_none());
    }

    const STATUS_PLANES: [&str; 5] =
        ["status_base.V", "status_good.V", "status_overlapped.V", "status_missed.V", "status_obscured.V"];

    /// Creates a film of one row in which pixels have these statuses.
    fn row_of(statuses: &[usize]) -> Film {
        let plane = |status| statuses.iter().map(|own| f32::from(u8::from(*own == status))).collect();
        let planes = [0, 1, 2, 3, 4].map(|status| (STATUS_PLANES[status], plane(status)));
        film_of(statuses.len() as u32, 1, &planes)
    }

    #[test]
    fn a_status_has_exactly_its_colour() {
        let all: Vec<usize> = (0..5).collect();
        let (pixels, _) = decoded(&status_map(&row_of(&all)).expect("statuses"));
        assert_eq!(pixels, STATUSES.map(|status| status.color));
        assert!(
            status_map(&film(3, 2, &STATUS_PLANES[1..].iter().map(|name| (*name, 0.2)).collect::<Vec<_>>()))
                .is_none()
        );
    }

    #[test]
    fn a_block_of_a_map_shows_its_worst_pixel() {
        let mut statuses = vec![1; 640];
        assert_eq!(block_side(640), 2);
        (statuses[10], statuses[21], statuses[30], statuses[31]) = (3, 4, 2, 3);
        statuses[40] = 2;
        let (pixels, width) = decoded(&status_map(&row_of(&statuses)).expect("statuses"));
        assert_eq!(width, 320);
        let wanted = [(4, 1), (5, 3), (10, 4), (15, 3), (20, 2), (319, 1)];
        for (block, status) in wanted {
            assert_eq!(pixels[block], STATUSES[status].color, "block {block}");
        }
    }

    #[test]
    fn a_block_of_differences_shows_the_largest() {
        let of =
            |green: Vec<f32>| film_of(640, 1, &[("R", vec![0.5; 640]), ("G", green), ("B", vec![0.0; 640])]);
        let mut green = vec![0.25; 640];
        let flat = of(green.clone());
        (green[3], green[8], green[9]) = (0.0, f32::NAN, 0.5);
        let (pixels, _) = decoded(&difference_map(&of(green), &flat).expect("pictures"));
        assert_eq!(pixels[0], [0; 3]);
        assert_eq!(pixels[1], false_color::of_difference(0.25));
        assert_eq!(pixels[4], false_color::of_difference(f32::NAN));
        assert!(difference_map(&flat, &film(640, 1, &[])).is_none());
    }
}
