//! Reads environment maps: Radiance pictures (`.hdr`), OpenEXR files (`.exr`), and pictures as screens show them, told apart by their first
//! bytes.

use std::fmt::Display;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use super::Environment;
use crate::digest::Digest;
use crate::input::{self, Input, Kind};
use crate::memory::{self, Need, Part};
use crate::scene::texture::linear_share;
use crate::scene::{SceneError, Warning};

/// Maximum number of texels along an edge.
const LONGEST_EDGE: u32 = 32_768;
/// Maximum number of texels that a byte of a Radiance picture can hold, generously: a byte for each of the
/// four values of a texel, in runs of 127 at most.
const MOST_TEXELS_A_BYTE: u64 = 64;
/// Bytes of a texel in memory: three floats, and a step of the distribution that samples it.
const TEXEL_BYTES: u64 = 3 * 4 + 4;
/// Bytes of a texel while it is decoded: the decoder of Radiance pictures has two lists of texels for a
/// while.
const DECODED_BYTES: u64 = 2 * 3 * 4;
/// Bytes of a texel of any other picture as it is decoded, at most: four floats.
const MOST_DECODED: u64 = 4 * 4;

/// Reads the map at `path`. Returns also a digest of its texels, and a warning if it is odd.
///
/// # Errors With the file and what to do: a file that is unreadable, empty, of another kind, damaged, or
/// without red, green or blue; with values that are negative or not finite; too large for memory.
pub(in crate::scene) fn read(path: &Path) -> Result<(Environment, Digest, Option<Warning>), SceneError> {
    let fault = |why: String| SceneError::new(path, format!("the environment map {why}"));
    let (width, height, texels) = decode(path).map_err(fault)?;
    let digest = Digest::of_table(width, bytemuck::cast_slice(&texels));
    let environment =
        Environment::from_picture(width, height, texels).map_err(|error| fault(error.to_string()))?;
    let is_odd = (width, height) != (1, 1) && u64::from(width) != 2 * u64::from(height);
    let odd = is_odd.then(|| {
        let message = format!(
            "the environment map has {width}x{height} texels and is stretched over the sphere: a latitude-longitude map \
             is twice as wide as high"
        );
        Warning(SceneError::new(path, message))
    });
    Ok((environment, digest, odd))
}

/// Largest file that is decoded to see whether it has one texel, bytes: those have some hundreds.
#[cfg(feature = "usd")]
const FEW_BYTES: u64 = 4096;

/// Returns true if the map at `path` has one texel: exporters write colours as such.
#[cfg(feature = "usd")]
pub(in crate::scene) fn is_even(path: &Path) -> bool {
    let is_small = path.metadata().is_ok_and(|file| file.len() <= FEW_BYTES);
    is_small && decode(path).is_ok_and(|(width, height, _)| (width, height) == (1, 1))
}

/// Decodes a map: width, height, and linear RGB row by row. Errors are the end of a sentence.
fn decode(path: &Path) -> Result<(u32, u32, Vec<f32>), String> {
    let mut input = input::open(path, Kind::Picture).map_err(|error| unreadable(&error))?;
    let mut begin = Vec::new();
    input.file.by_ref().take(4).read_to_end(&mut begin).map_err(|error| unreadable(&error))?;
    input.file.rewind().map_err(|error| unreadable(&error))?;
    match begin.as_slice() {
        [] => Err(String::from("is empty: check the file")),
        [b'#', b'?', ..] => radiance(input),
        [0x76, 0x2f, 0x31, 0x01] => open_exr(path),
        _ => of_screens(input, ImageFormat::from_path(path).ok()),
    }
}

/// Returns true for files that may be maps, by their endings.
#[cfg(feature = "usd")]
pub(in crate::scene) fn is_map(path: &Path) -> bool {
    // part of a package, maybe: `a.usdz[b.png]`
    let name = path.to_string_lossy();
    let ending = name.trim_end_matches(']').rsplit('.').next().unwrap_or_default().to_lowercase();
    ending == "exr" || ImageFormat::from_extension(ending).is_some_and(|format| format.reading_enabled())
}

fn unreadable(error: &dyn Display) -> String {
    format!("cannot be read: {error}")
}

fn radiance(input: Input) -> Result<(u32, u32, Vec<f32>), String> {
    let Input { file, length: file_bytes, .. } = input;
    // a header may be as long as the file
    let need = Need::new(Part::new("its file", file_bytes, "a smaller map"));
    need.check(&memory::left()).map_err(|error| format!("does not fit: {error}"))?;
    // not strict: many writers call the format by another name than `RADIANCE`
    let decoder = HdrDecoder::new_nonstrict(BufReader::new(file)).map_err(|error| unreadable(&error))?;
    let (width, height) = decoder.dimensions();
    check_size([width, height], DECODED_BYTES, &memory::left())?;
    if u64::from(width) * u64::from(height) / MOST_TEXELS_A_BYTE > file_bytes {
        return Err(format!(
            "of {width}x{height} texels cannot be in a file of {file_bytes} bytes: it is cut short"
        ));
    }
    let picture = DynamicImage::from_decoder(decoder).map_err(|error| unreadable(&error))?;
    Ok((width, height, picture.into_rgb32f().into_raw()))
}

/// Decodes a picture whose values are sRGB's, from black to white: what shines in it is no brighter than that. `format`: by the name of its
/// file.
fn of_screens(
    Input { file, length: file_bytes, .. }: Input,
    format: Option<ImageFormat>,
) -> Result<(u32, u32, Vec<f32>), String> {
    let need = Need::new(Part::new("its file", file_bytes, "a smaller map"));
    need.check(&memory::left()).map_err(|error| format!("does not fit: {error}"))?;
    let mut reader = ImageReader::new(BufReader::new(file));
    // files of some kinds have no mark, and are known by their ending alone
    if let Some(format) = format.filter(|format| format.reading_enabled() && *format != ImageFormat::Hdr) {
        reader.set_format(format);
    }
    let reader = reader.with_guessed_format().map_err(|error| unreadable(&error))?;
    if !reader.format().is_some_and(|format| format.reading_enabled()) {
        return Err(String::from(
            "is neither a Radiance picture (.hdr), nor an OpenEXR file (.exr), nor another picture that is read: convert it to one of the first \
             two",
        ));
    }
    let decoder = reader.into_decoder().map_err(|error| unreadable(&error))?;
    let (width, height) = decoder.dimensions();
    check_size([width, height], DECODED_BYTES + MOST_DECODED, &memory::left())?;
    let picture = DynamicImage::from_decoder(decoder).map_err(|error| unreadable(&error))?;
    let is_linear = matches!(picture, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let mut texels = picture.into_rgb32f().into_raw();
    if !is_linear {
        texels.iter_mut().for_each(|value| *value = linear_share(f64::from(*value)));
    }
    Ok((width, height, texels))
}

fn open_exr(path: &Path) -> Result<(u32, u32, Vec<f32>), String> {
    let header = openexr::read_header(path).map_err(|error| worded(&error))?;
    let (width, height) = (header.width, header.height);
    let number = |name: &str| header.channels.iter().position(|channel| channel.name == name);
    let [Some(red), Some(green), Some(blue)] = ["R", "G", "B"].map(number) else {
        let names: Vec<&str> = header.channels.iter().map(|channel| channel.name.as_str()).take(16).collect();
        return Err(format!("must have the channels R, G and B, and has {}", names.join(", ")));
    };
    check_size([width, height], TEXEL_BYTES, &memory::left())?;
    let mut texels = vec![0.0; 3 * width as usize * height as usize];
    let mut read = [0; 3];
    openexr::scan(path, |channel, values| {
        for at in (0..3).filter(|at| [red, green, blue][*at] == channel) {
            let targets = texels[at..].iter_mut().step_by(3).skip(read[at]);
            targets.zip(values).for_each(|(target, value)| *target = *value);
            read[at] += values.len();
        }
    })
    .map_err(|error| worded(&error))?;
    Ok((width, height, texels))
}

/// Words of an error without the name of the file, with which the whole message begins.
fn worded(error: &openexr::Error) -> String {
    match error {
        openexr::Error::File { source, .. } => unreadable(source),
        openexr::Error::Library { message, .. } => unreadable(message),
        other => unreadable(other),
    }
}

/// Checks the size of a map before it is decoded: it has texels, no edge is too long, and it fits into the
/// memory that is `left` with `decoded` bytes for each texel while it is decoded.
fn check_size([width, height]: [u32; 2], decoded: u64, left: &[memory::Headroom]) -> Result<(), String> {
    let texels = u64::from(width) * u64::from(height);
    if texels == 0 {
        return Err(format!("of {width}x{height} texels has none: check the file"));
    }
    if width.max(height) > LONGEST_EDGE {
        return Err(format!(
            "of {width}x{height} texels is too large: an edge may have {LONGEST_EDGE}; scale it down"
        ));
    }
    let need = Need::new(Part::new("the map", texels * decoded.max(TEXEL_BYTES), "a smaller map"));
    need.check(left).map_err(|error| format!("of {width}x{height} texels does not fit: {error}"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use std::fs::File;
    use std::path::PathBuf;

    use glam::Vec3;
    use image::codecs::hdr::HdrEncoder;
    use openexr::{Channel, Compression, Data, Image, SampleType};
    use tempfile::TempDir;

    use super::*;
    use crate::memory::Limit;

    /// Another number in each value, from 2 to 20.
    fn texels(width: u32, height: u32) -> Vec<f32> {
        let value = |at| (128 + at % 127) as f32 * 0.015_625 * (1 + at / 3 % 5) as f32;
        (0..3 * width * height).map(value).collect()
    }

    fn write_hdr(path: &Path, width: u32, height: u32, texels: &[f32]) {
        let rgb: Vec<_> = texels.chunks(3).map(|rgb| image::Rgb([rgb[0], rgb[1], rgb[2]])).collect();
        let file = File::create(path).unwrap();
        HdrEncoder::new(file).encode(&rgb, width as usize, height as usize).unwrap();
    }

    /// Names and planes.
    fn write_exr(path: &Path, width: u32, height: u32, planes: &[(&str, Vec<f32>)]) {
        let channels = planes.iter().map(|(name, data)| {
            let data = Data::Floats(data);
            Channel { name, stored: SampleType::Float, data }
        });
        // not compressed: tests find floats in the file
        let (channels, compression) = (channels.collect(), Compression::None);
        let image = Image { width, height, placed: None, channels, attributes: Vec::new(), compression };
        openexr::write(&File::create(path).unwrap(), path, &image).unwrap();
    }

    fn write_rgb(path: &Path, width: u32, height: u32, texels: &[f32]) {
        let plane = |first: usize| texels[first..].iter().step_by(3).copied().collect::<Vec<f32>>();
        let more = ("depth.Z", vec![-7.0; (width * height) as usize]);
        write_exr(
            path,
            width,
            height,
            &[("A", plane(0)), ("R", plane(0)), ("G", plane(1)), ("B", plane(2)), more],
        );
    }

    fn folder(name: &str) -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        (folder, path)
    }

    fn message(path: &Path) -> String {
        let error = read(path).unwrap_err();
        assert_eq!(error.path, path);
        error.message
    }

    #[test]
    fn maps_come_back_from_both_formats() {
        let [width, height] = [70, 35];
        let texels = texels(width, height);
        let expected = Environment::from_picture(width, height, texels.clone()).unwrap();
        let (_folder, path) = folder("a.hdr");
        write_hdr(&path, width, height, &texels);
        let (of_hdr, _, none) = read(&path).unwrap();
        assert_eq!(none, None);
        for row in 0..64 {
            let (sin, cos) = (0.1 * row as f32).sin_cos();
            let direction = Vec3::new(sin * 0.8, row as f32 / 32.0 - 1.0, cos).normalize();
            let (found, expected) = (of_hdr.radiance(direction), expected.radiance(direction));
            // a texel's largest value has eight bits
            assert!(found.abs_diff_eq(expected, expected.max_element() / 100.0), "{found}, not {expected}");
        }

        // the name says nothing
        write_rgb(&path, width, height, &texels);
        let digest = Digest::of_table(width, bytemuck::cast_slice(&texels));
        assert_eq!(read(&path).unwrap(), (expected, digest, None));
    }

    #[test]
    fn other_shapes_are_warned_of() {
        let (_folder, path) = folder("a.exr");
        write_rgb(&path, 4, 3, &texels(4, 3));
        let (_, _, warning) = read(&path).unwrap();
        let warning = warning.unwrap().to_string();
        assert!(warning.contains("a.exr: ") && warning.contains("4x3") && warning.contains("twice as wide"));
    }

    #[test]
    fn pictures_of_screens_are_maps_of_srgb_values() {
        let (_folder, path) = folder("a.png");
        let colors = [[0, 128, 255], [255, 188, 0]];
        let picture = image::RgbImage::from_fn(2, 1, |x, _| image::Rgb(colors[x as usize]));
        picture.save(&path).unwrap();
        let (size, texels) = decode(&path).map(|(width, height, texels)| ([width, height], texels)).unwrap();
        let wanted = colors.concat().into_iter().map(crate::scene::texture::linear);
        assert_eq!(size, [2, 1]);
        assert!(texels.iter().zip(wanted).all(|(texel, wanted)| (texel - wanted).abs() < 1e-6), "{texels:?}");
        assert_eq!(decode(&path).unwrap().2.len(), 6);
        // by what it is, not by its name
        let renamed = path.with_file_name("b.hdr");
        std::fs::rename(&path, &renamed).unwrap();
        assert_eq!(decode(&renamed).unwrap().2, texels);
        let cut = std::fs::read(&renamed).unwrap();
        std::fs::write(&renamed, &cut[..cut.len() / 2]).unwrap();
        assert!(message(&renamed).contains("cannot be read"));
    }

    #[test]
    fn bad_values_are_told_with_their_pixel() {
        let (_folder, path) = folder("a.exr");
        let mut texels = texels(8, 4);
        texels[3 * (2 * 8 + 5) + 1] = -0.25;
        write_rgb(&path, 8, 4, &texels);
        let negative = message(&path);
        assert!(negative.contains("-0.25 in channel G of pixel (5, 2): set"), "{negative}");
        // our writer takes no infinity: a float of the file becomes one
        texels[3 * (2 * 8 + 5) + 1] = 1234.5;
        write_rgb(&path, 8, 4, &texels);
        let bytes = std::fs::read(&path).unwrap();
        let at = bytes.windows(4).position(|four| four == 1234.5_f32.to_le_bytes()).unwrap();
        for (value, word) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf"), (f32::NEG_INFINITY, "-inf")] {
            let mut spoilt = bytes.clone();
            spoilt[at..at + 4].copy_from_slice(&value.to_le_bytes());
            std::fs::write(&path, spoilt).unwrap();
            let text = message(&path);
            assert!(text.contains(&format!("value {word} in channel G of pixel (5, 2): replace")), "{text}");
        }
    }

    #[test]
    fn files_that_are_no_maps_are_told_with_a_remedy() {
        let (_folder, path) = folder("a.hdr");
        let head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
        for (bytes, words) in [
            (Vec::new(), "is empty: check the file"),
            (
                b"P6 2 1 255".to_vec(),
                "is neither a Radiance picture (.hdr), nor an OpenEXR file (.exr), nor another picture that is read: convert it",
            ),
            (b"#".to_vec(), "is neither"),
            (b"#?RADIANCE\n".to_vec(), "cannot be read"),
            (format!("{head}-Y 4 +X 8\nabc").into_bytes(), "cannot be read"),
            (format!("{head}+X 4 -Y 8\n").into_bytes(), "cannot be read"),
            (format!("{head}-Y 0 +X 8\n").into_bytes(), "of 8x0 texels has none"),
            (format!("{head}-Y 20000 +X 40000\n").into_bytes(), "an edge may have 32768"),
            (format!("{head}-Y 512 +X 1024\n").into_bytes(), "cannot be in a file of"),
            (vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0], "cannot be read"),
        ] {
            std::fs::write(&path, &bytes).unwrap();
            let text = message(&path);
            assert!(text.contains(words), "{words}: {text}");
        }
        std::fs::remove_file(&path).unwrap();
        assert!(message(&path).contains("cannot be read"));
        write_exr(&path, 4, 2, &[("Y", vec![1.0; 8]), ("A", vec![1.0; 8])]);
        assert!(
            message(&path).contains("must have the channels R, G and B, and has A, Y"),
            "{}",
            message(&path)
        );
    }

    #[test]
    fn cut_or_spoilt_files_are_errors_or_maps_but_no_panics() {
        let (_folder, path) = folder("a");
        for name in ["hdr", "exr"] {
            match name {
                "hdr" => write_hdr(&path, 32, 16, &texels(32, 16)),
                _ => write_rgb(&path, 32, 16, &texels(32, 16)),
            }
            let bytes = std::fs::read(&path).unwrap();
            for length in (0..bytes.len()).step_by(bytes.len() / 40 + 1) {
                std::fs::write(&path, &bytes[..length]).unwrap();
                assert!(read(&path).is_err(), "{name}: {length} of {} bytes", bytes.len());
            }
            for at in (0..bytes.len()).step_by(bytes.len() / 60 + 1) {
                let mut spoilt = bytes.clone();
                spoilt[at] ^= 0x55;
                std::fs::write(&path, &spoilt).unwrap();
                let _ = read(&path);
            }
        }
    }

    #[test]
    fn sizes_are_looked_at_before_anything_is_decoded() {
        let left = |mib: u64| [(Limit::Machine, mib << 20)];
        assert_eq!(check_size([4096, 2048], DECODED_BYTES, &left(193)), Ok(()));
        let text = check_size([4096, 2048], DECODED_BYTES, &left(100)).unwrap_err();
        for words in
            ["of 4096x2048 texels does not fit: ", "192 MiB", "100 MiB are available", "a smaller map"]
        {
            assert!(text.contains(words), "{text}");
        }
    }
}
