//! Are chunks of B44 and DWA unpacked as they were packed, with any version of OpenEXR? `packed/` was written by OpenEXR's own
//! library, 3.5.

#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::tempdir;

const WIDTH: u32 = 21;
const HEIGHT: u32 = 37; // more than one chunk of 32 lines, and no whole blocks of 4 or 8

fn packed(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/packed").join(name)
}

/// Value of a channel that was packed, and the largest difference that B44 and DWA may make of it.
fn drawn(channel: &str, x: u32, y: u32) -> (f32, f32) {
    let (across, down) = (x as f32 / WIDTH as f32, y as f32 / HEIGHT as f32);
    match channel {
        "R" => (across, 0.01),
        "G" => (down, 0.01),
        "B" => ((x + y) as f32 / (WIDTH + HEIGHT) as f32 * 2.0, 0.01),
        "A" => (if x < y { 1.0 } else { 0.25 }, 0.0),
        _ => (x as f32 * 1000.0 + y as f32 + 0.123, 1e-3),
    }
}

#[test]
fn lossy_chunks_are_what_was_packed() {
    for (name, channels) in
        [("b44.exr", "BGRZ"), ("b44a.exr", "BGRZ"), ("dwaa.exr", "ABGRZ"), ("dwab.exr", "BGR")]
    {
        let image = openexr::read(&packed(name)).unwrap();
        assert_eq!((image.width, image.height), (WIDTH, HEIGHT));
        let names: Vec<&str> = image.channels.iter().map(|channel| channel.name.as_str()).collect();
        assert_eq!(names.concat(), channels);
        for channel in &image.channels {
            assert_eq!(channel.data.len(), (WIDTH * HEIGHT) as usize);
            for (value, at) in channel.data.iter().zip(0..) {
                let (x, y) = (at % WIDTH, at / WIDTH);
                let (expected, tolerance) = drawn(&channel.name, x, y);
                let difference = (value - expected).abs();
                assert!(
                    difference <= tolerance,
                    "{name} {} at {x}, {y}: {value}, not {expected}",
                    channel.name
                );
            }
        }
    }
}

#[test]
fn damaged_lossy_chunks_are_told_or_read_and_never_panic() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("damaged.exr");
    for name in ["b44.exr", "b44a.exr", "dwaa.exr", "dwab.exr"] {
        let whole = fs::read(packed(name)).unwrap();
        let mut told = 0;
        for at in (300..whole.len()).step_by(61) {
            let mut damaged = whole.clone();
            damaged[at] ^= 0xff;
            fs::write(&path, &damaged).unwrap();
            told += i32::from(openexr::read(&path).is_err());
        }
        assert!(told > 0 || name.starts_with('b'), "{name}: sums and Huffman codes do not fit");
        fs::write(&path, &whole[..whole.len() - 40]).unwrap();
        let text = openexr::read(&path).unwrap_err().to_string();
        assert!(text.contains("damaged.exr"), "{text}");
    }
}
