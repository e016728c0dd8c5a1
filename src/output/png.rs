//! An 8-bit sRGB preview of `R G B`.

use std::borrow::Cow;
use std::fmt;
use std::io::BufReader;
use std::path::Path;

use rayon::prelude::*;

use super::fingerprint::{self, Fingerprint};
use super::look::on_screen;
use super::staged::{WriteError, write_bytes};
use crate::film::{Film, Plane};
use crate::input::{self, Kind};
use crate::settings::Look;

/// Red, green and blue.
const CHANNELS: usize = 3;

/// Pixels that a thread converts at once.
const AT_ONCE: usize = 1 << 13;

/// Reason why there is no preview.
#[derive(Debug)]
pub enum PreviewError {
    /// The file could not be written.
    Write(WriteError),
    /// The film lacks a plane of this name.
    NoPlane(Cow<'static, str>),
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
    write_colors(path, [film.width, film.height], colors(film)?, Look::default(), None)
}

/// Planes that a preview of `film` shows.
///
/// # Errors One is missing.
pub fn colors(film: &Film) -> Result<[&Plane; 3], PreviewError> {
    let plane = |name: &'static str| film.plane(name).ok_or(PreviewError::NoPlane(Cow::Borrowed(name)));
    Ok([plane("R")?, plane("G")?, plane("B")?])
}

/// [`write_png`] of these planes of a picture of `size` (columns and rows): red, green and blue, with a `look`. The file says
/// what the frame was made from, if that is given.
///
/// # Errors
/// The same.
pub fn write_colors(
    path: &Path,
    size: [u32; 2],
    planes: [&Plane; 3],
    look: Look,
    made_from: Option<Fingerprint>,
) -> Result<(), PreviewError> {
    write_bytes_of(path, size, &encoded(size, planes, look)?, made_from)
}

/// The bytes of the file that [`write_png`] writes, with a `look`.
///
/// # Errors
/// A plane is missing or of the wrong size.
pub fn file_of(film: &Film, look: Look) -> Result<Vec<u8>, PreviewError> {
    let size = [film.width, film.height];
    file_of_bytes(size, &encoded(size, colors(film)?, look)?, None)
}

/// Encodes red, green and blue of each pixel.
fn encoded(size: [u32; 2], planes: [&Plane; 3], look: Look) -> Result<Vec<u8>, PreviewError> {
    let pixels = size[0] as usize * size[1] as usize;
    if let Some(plane) = planes.iter().find(|plane| plane.values.len() != pixels) {
        return Err(PreviewError::NoPlane(plane.name.clone()));
    }
    let [red, green, blue] = planes.map(|plane| &plane.values);
    let on_screen = on_screen(look);
    // on all threads: where there are many, frames are done before one thread has bent their curves
    let mut bytes = vec![0; pixels * CHANNELS];
    bytes.par_chunks_mut(AT_ONCE * CHANNELS).enumerate().for_each(|(number, some)| {
        for (pixel, bytes) in (number * AT_ONCE..).zip(some.chunks_exact_mut(CHANNELS)) {
            let shown = on_screen([red, green, blue].map(|plane| plane.get(pixel)));
            bytes.copy_from_slice(&shown.map(srgb_byte));
        }
    });
    Ok(bytes)
}

/// Reads the fingerprint of the preview at `path`; `None` if it has none, or is no PNG.
pub fn fingerprint(path: &Path) -> Option<Fingerprint> {
    let input = input::open(path, Kind::Picture).ok()?;
    let reader = png::Decoder::new(BufReader::new(input.file)).read_info().ok()?;
    let texts = &reader.info().uncompressed_latin1_text;
    texts.iter().find(|text| text.keyword == fingerprint::KEY)?.text.parse().ok()
}

/// Writes bytes as they are: red, green and blue of each pixel of a picture of `size` (columns and rows).
///
/// # Errors
/// The bytes are not as many as the size says, or the file cannot be written; then no file is left.
pub fn write_rgb(path: &Path, size: [u32; 2], bytes: &[u8]) -> Result<(), PreviewError> {
    write_bytes_of(path, size, bytes, None)
}

fn write_bytes_of(
    path: &Path,
    size: [u32; 2],
    bytes: &[u8],
    made_from: Option<Fingerprint>,
) -> Result<(), PreviewError> {
    write_bytes(path, &file_of_bytes(size, bytes, made_from)?).map_err(PreviewError::Write)
}

fn file_of_bytes(
    size: [u32; 2],
    bytes: &[u8],
    made_from: Option<Fingerprint>,
) -> Result<Vec<u8>, PreviewError> {
    let mut file = Vec::new();
    encode(&mut file, size, bytes, made_from).map_err(|error| PreviewError::Encode(error.to_string()))?;
    Ok(file)
}

fn encode(
    file: &mut Vec<u8>,
    [width, height]: [u32; 2],
    bytes: &[u8],
    made_from: Option<Fingerprint>,
) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Sub);
    if let Some(made_from) = made_from {
        encoder.add_text_chunk(fingerprint::KEY.to_owned(), made_from.to_string())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()
}

/// Encodes linear light as an sRGB byte: IEC 61966-2-1, its linear piece included; NaN becomes 0.
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
    use crate::digest::Digest;
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
        assert_eq!(fingerprint(&path), None);
        let made_from = Fingerprint {
            version: Digest::new(b"1"),
            shot: Digest::new(b"2"),
            inputs: Digest::new(b"3"),
            settings: Digest::new(b"4"),
        };
        write_colors(&path, [2, 1], colors(&film).unwrap(), Look::default(), Some(made_from)).unwrap();
        assert_eq!(fingerprint(&path), Some(made_from));
        assert_eq!(image::open(&path).unwrap().to_rgb8().into_raw()[..3], [255, 0, 188]);
        let darker = Look { exposure: -1.0, ..Look::default() };
        write_colors(&path, [2, 1], colors(&film).unwrap(), darker, None).unwrap();
        assert_eq!(image::open(&path).unwrap().to_rgb8().into_raw()[..3], [188, 0, 137]);
        std::fs::write(&path, "no picture").unwrap();
        assert_eq!([fingerprint(&path), fingerprint(folder.path())], [None, None]);
        film.planes.pop();
        let text = write_png(&path, &film).unwrap_err().to_string();
        assert!(text.contains("plane B"), "{text}");
    }
}
