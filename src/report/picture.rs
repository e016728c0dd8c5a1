//! Small pictures for the report, as PNG in data URIs.

use std::io::Cursor;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use crate::film::Film;

/// Widest picture in a report, pixels.
const WIDEST: usize = 560;

/// A status, the plane's layer channel, its colour (sRGB), and what it means.
pub struct StatusKey {
    /// As the contract names it.
    pub name: &'static str,
    /// sRGB.
    pub color: [u8; 3],
    /// In a sentence.
    pub meaning: &'static str,
}

/// All statuses in the order of the contract.
pub const STATUSES: [StatusKey; 5] = [
    StatusKey {
        name: "base",
        color: [138, 143, 152],
        meaning: "traced because the whole frame was: the first frame, a cut, a key frame",
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

/// `#2ea44f`
pub fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The picture as a viewer shows it: sRGB, clipped. `None` where the film has no picture.
pub fn beauty(film: &Film) -> Option<String> {
    let planes = [film.values("R")?, film.values("G")?, film.values("B")?];
    Some(data_uri(film, |pixel| planes.each_ref().map(|plane| plane[pixel])))
}

/// Each pixel in the colours of its samples' statuses. `None` where the film has no statuses.
pub fn status_map(film: &Film) -> Option<String> {
    let names = STATUSES.map(|status| format!("status_{}.V", status.name));
    let planes = names.iter().map(|name| film.values(name)).collect::<Option<Vec<_>>>()?;
    let colors = STATUSES.map(|status| status.color.map(|byte| linear(f32::from(byte) / 255.0)));
    Some(data_uri(film, |pixel| {
        let mut sum = [0.0; 3];
        for (plane, color) in planes.iter().zip(colors) {
            for (channel, part) in sum.iter_mut().zip(color) {
                *channel += plane[pixel] * part;
            }
        }
        sum
    }))
}

/// Shrinks by whole factors with a mean in linear light, and encodes. `color` gives a pixel's linear RGB.
fn data_uri(film: &Film, color: impl Fn(usize) -> [f32; 3]) -> String {
    let (width, height) = (film.width as usize, film.height as usize);
    let factor = width.div_ceil(WIDEST).max(1);
    let (small_width, small_height) = ((width / factor).max(1), (height / factor).max(1));
    let mut bytes = Vec::with_capacity(small_width * small_height * 3);
    for y in 0..small_height {
        for x in 0..small_width {
            let mut sum = [0.0_f32; 3];
            let (mut count, rows) = (0.0_f32, y * factor..((y + 1) * factor).min(height));
            for (row, column) in rows
                .flat_map(|row| (x * factor..((x + 1) * factor).min(width)).map(move |column| (row, column)))
            {
                for (channel, part) in sum.iter_mut().zip(color(row * width + column)) {
                    *channel += part.clamp(0.0, 1.0);
                }
                count += 1.0;
            }
            bytes.extend(sum.map(|channel| (encoded(channel / count.max(1.0)) * 255.0 + 0.5) as u8));
        }
    }
    png_uri(&bytes, small_width as u32, small_height as u32)
}

fn png_uri(rgb: &[u8], width: u32, height: u32) -> String {
    let mut png = Cursor::new(Vec::new());
    PngEncoder::new(&mut png)
        .write_image(rgb, width, height, ExtendedColorType::Rgb8)
        .expect("memory takes every byte, and the bytes are as many as the size says");
    format!("data:image/png;base64,{}", base64(png.get_ref()))
}

/// sRGB's curve.
fn encoded(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`encoded`].
fn linear(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// RFC 4648, section 4.
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

    fn film(width: u32, height: u32, names: &[(&'static str, f32)]) -> Film {
        let data = |value| vec![value; (width * height) as usize];
        let planes = names.iter().map(|&(name, value)| Plane::new(name, PlaneKind::Half, &data(value)));
        Film { width, height, planes: planes.collect() }
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
        let uri = beauty(&film(1200, 30, &[("R", 2.0), ("G", f32::NAN), ("B", -1.0)])).expect("a picture");
        assert!(uri.starts_with("data:image/png;base64,iVBORw0KGgo"));
        assert!(uri.len() < 4000, "one colour packs well");
        assert!(beauty(&film(1, 1, &[])).is_none());
    }

    #[test]
    fn a_status_has_exactly_its_colour() {
        let color = STATUSES[1].color.map(|byte| linear(f32::from(byte) / 255.0));
        let back = color.map(|part| (encoded(part) * 255.0 + 0.5) as u8);
        assert_eq!(back, STATUSES[1].color);
        let names =
            ["status_base.V", "status_good.V", "status_overlapped.V", "status_missed.V", "status_obscured.V"];
        let planes = names.map(|name| (name, 0.2));
        assert!(status_map(&film(3, 2, &planes)).is_some());
        assert!(status_map(&film(3, 2, &planes[1..])).is_none());
    }
}
