//! Files of other programs: several parts, windows that begin elsewhere, tiles, deep pixels, values that are no numbers.
#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

mod bytes;

use std::path::PathBuf;

use bytes::{Part, file};
use openexr::{part_count, read, scan_part};
use tempfile::TempDir;

fn written(folder: &TempDir, parts: &[Part<'_>]) -> PathBuf {
    let path = folder.path().join("a.exr");
    std::fs::write(&path, file(parts)).unwrap();
    path
}

const RED: &[(&str, &[f32])] = &[("R", &[1.0, 2.0, 3.0, 4.0])];

#[test]
fn each_part_is_read_by_its_number() {
    let folder = tempfile::tempdir().unwrap();
    let depth: &[(&str, &[f32])] = &[("Z", &[5.0, 6.0])];
    let parts = [
        Part { name: "beauty", kind: "scanlineimage", window: [0, 0, 1, 1], channels: RED },
        Part { name: "tiles", kind: "tiledimage", window: [0, 0, 1, 1], channels: RED },
        Part { name: "depth", kind: "scanlineimage", window: [0, 0, 1, 0], channels: depth },
    ];
    let path = written(&folder, &parts);
    assert_eq!(part_count(&path).unwrap(), 3);
    assert_eq!(read(&path).unwrap().channels[0].data, RED[0].1);
    let mut values = Vec::new();
    let image = scan_part(&path, 2, |channel, line| values.push((channel, line.to_vec()))).unwrap();
    assert_eq!((image.part_name.as_str(), image.channels[0].name.as_str()), ("depth", "Z"));
    assert_eq!(values, [(0, vec![5.0, 6.0])]);
    let text = scan_part(&path, 1, |_, _| {}).unwrap_err().to_string();
    assert!(text.contains("it is tiled"), "{text}");
    assert!(scan_part(&path, 3, |_, _| {}).is_err());
}

#[test]
fn windows_may_begin_anywhere_and_values_be_no_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let odd = [f32::NAN, f32::INFINITY, -1.0, f32::NEG_INFINITY];
    let window = [-3, 7, -2, 8];
    let part = Part { name: "a", kind: "scanlineimage", window, channels: &[("R", &odd)] };
    let path = written(&folder, &[part]);
    assert_eq!(part_count(&path).unwrap(), 1);
    let image = read(&path).unwrap();
    assert_eq!((image.width, image.height, image.origin, image.display), (2, 2, [-3, 7], window));
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&image.channels[0].data), bits(&odd));
}

#[test]
fn tiled_and_deep_files_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for (kind, word) in [("tiledimage", "tiled"), ("deepscanline", "deep")] {
        let path = written(&folder, &[Part { name: "a", kind, window: [0, 0, 1, 1], channels: RED }]);
        let text = read(&path).unwrap_err().to_string();
        assert!(text.contains("a.exr") && text.contains(word) && text.contains("scanline"), "{text}");
    }
}
