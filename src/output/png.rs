//! An 8-bit sRGB preview of `R G B`.

use std::fmt;
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::staged::{WriteError, write_bytes};
use crate::film::{Film, Plane};

/// Why there is no preview.
#[derive(Debug)]
pub enum PreviewError {
    /// The file could not be written.
    Write(WriteError),
    /// The film lacks a plane of this name.
    NoPlane(&'static str),
    /// The encoder refused the picture.
    Encode(String),
}

impl fmt::Display for PreviewError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Write(error) => error.fmt(f),
            Self::NoPlane(name) => write!(f, "no preview: the frame has no plane {name}"),
            Self::Encode(why) => write!(f, "no preview: the PNG encoder says: {why}"),
        }
    }
}

impl std::error::Error for PreviewError {}

/// Writes `R G B` as an opaque 8-bit PNG, clamped to 0 to 1 and encoded with the sRGB curve.
///
/// # Errors
/// A plane is missing or of the wrong size, or the file cannot be written; then no file is left.
pub fn write_png(path: &Path, film: &Film) -> Result<(), PreviewError> {
    let planes = ["R", "G", "B"].map(|name| film.plane(name).ok_or(PreviewError::NoPlane(name)));
    let [red, green, blue] = planes;
    write_colors(path, [film.width, film.height], [red?, green?, blue?])
}

/// The same of these planes of a picture of `size` (columns and rows): red, green and blue.
///
/// # Errors
/// The same.
pub fn write_colors(path: &Path, size: [u32; 2], planes: [&Plane; 3]) -> Result<(), PreviewError> {
    let pixels = size[0] as usize * size[1] as usize;
    if let Some(plane) = planes.iter().find(|plane| plane.values.len() != pixels) {
        return Err(PreviewError::NoPlane(plane.name));
    }
    let [red, green, blue] = planes.map(|plane| &plane.values);
    let mut bytes = Vec::with_capacity(pixels * 3);
    for pixel in 0..pixels {
        bytes.extend([red, green, blue].map(|plane| srgb_byte(plane.get(pixel))));
    }
    write_rgb(path, size, &bytes)
}

/// Writes bytes as they are: red, green and blue of each pixel of a picture of `size` (columns and rows).
///
/// # Errors
/// The bytes are not as many as the size says, or the file cannot be written; then no file is left.
pub fn write_rgb(path: &Path, size: [u32; 2], bytes: &[u8]) -> Result<(), PreviewError> {
    let mut file = Vec::new();
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    if bytes.len() as u64 != 3 * pixels {
        return Err(PreviewError::Encode(format!("{} bytes are not {pixels} pixels", bytes.len())));
    }
    PngEncoder::new_with_quality(&mut file, CompressionType::Fast, FilterType::Sub)
        .write_image(bytes, size[0], size[1], ExtendedColorType::Rgb8)
        .map_err(|error| PreviewError::Encode(error.to_string()))?;
    write_bytes(path, &file).map_err(PreviewError::Write)
}

/// Linear light to an sRGB byte: IEC 61966-2-1, its linear piece included; NaN becomes 0.
#[must_use]
pub fn srgb_byte(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0); // leaves a NaN alone
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8 // `as` saturates, and takes NaN to 0
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

    use super::*;
    use crate::film::PlaneKind;

    #[test]
    fn the_curve_meets_known_points() {
        // Middle grey and the bytes of the standard's tables.
        let points = [(0.0, 0), (0.18, 118), (0.214_041_14, 127), (0.5, 188), (1.0, 255)];
        for (linear, byte) in points {
            assert!(srgb_byte(linear).abs_diff(byte) <= u8::from(linear == 0.214_041_14), "{linear}");
        }
        let extremes = [-1.0, 2.0, 1e30, f32::NAN].map(srgb_byte);
        assert_eq!(extremes, [0, 255, 255, 0]);
    }

    #[test]
    fn every_byte_survives_the_way_there_and_back() {
        for byte in 0..=255_u8 {
            let encoded = f64::from(byte) / 255.0;
            let linear =
                if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
            assert_eq!(srgb_byte(linear as f32), byte);
        }
    }

    #[test]
    fn a_preview_has_the_colours_in_place() {
        let data = [vec![1.0, 0.0], vec![0.0, 1.0], vec![0.5, 0.5]];
        let planes = ["R", "G", "B"].into_iter().zip(data);
        let planes = planes.map(|(name, data)| Plane::new(name, PlaneKind::Half, &data));
        let mut film = Film { width: 2, height: 1, planes: planes.collect() };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        write_png(&path, &film).unwrap();
        let back = image::open(&path).unwrap().to_rgb8();
        assert_eq!(back.into_raw(), [255, 0, 188, 0, 255, 188]);
        film.planes.pop();
        let text = write_png(&path, &film).unwrap_err().to_string();
        assert!(text.contains("plane B"), "{text}");
    }
}
