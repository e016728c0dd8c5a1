//! Does the wrapper hand pictures over as they are meant, and errors back? What needs the library looks for it where
//! `make setup` puts it.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use std::path::{Path, PathBuf};

use oidn::{Denoiser, Error, Guide, Guides, Quality};

const SIZE: [usize; 2] = [80, 48];

fn library() -> PathBuf {
    let prefix = std::env::var_os("OIDN_DIR")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.deps/oidn"), PathBuf::from);
    prefix.join("lib/libOpenImageDenoise.so.2")
}

type Pixels = Vec<[f32; 3]>;

/// A number from 0 to 1 for each seed.
fn random(seed: usize) -> f32 {
    let mut bits = (seed as u32).wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
    for shift in [16, 13, 16] {
        bits = (bits ^ bits >> shift).wrapping_mul(0xC2B2_AE35);
    }
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// The left half red and the right half green, eight times as bright as white, under noise as strong as itself.
fn noisy() -> (Pixels, Pixels, Pixels) {
    let pixels = SIZE[0] * SIZE[1];
    let albedo: Vec<[f32; 3]> = (0..pixels)
        .map(|pixel| if pixel % SIZE[0] < SIZE[0] / 2 { [0.8, 0.1, 0.1] } else { [0.1, 0.8, 0.1] })
        .collect();
    let light = |pixel: usize| 20.0 * random(pixel);
    let color = albedo.iter().enumerate().map(|(pixel, albedo)| albedo.map(|part| part * light(pixel)));
    (color.collect(), albedo.clone(), vec![[0.0, 0.0, 1.0]; pixels])
}

fn denoised(threads: usize, quality: Quality) -> Pixels {
    let (color, albedo, normal) = noisy();
    let mut output = vec![[-1.0; 3]; color.len()];
    let mut denoiser = Denoiser::load(&library(), threads, quality).unwrap();
    denoiser.denoise(SIZE, &color, Guides { albedo: &albedo, normal: &normal }, &mut output).unwrap();
    output
}

#[test]
#[cfg_attr(not(open_image_denoise), ignore = "needs Open Image Denoise: make setup")]
fn guides_lose_their_noise_and_keep_their_range() {
    let [lowest, highest] = [0.3, 0.7];
    let noisy: Pixels =
        (0..SIZE[0] * SIZE[1]).map(|pixel| [lowest + (highest - lowest) * random(pixel); 3]).collect();
    let mut denoiser = Denoiser::load(&library(), 2, Quality::High).unwrap();
    for guide in [Guide::Albedo, Guide::Normal] {
        let mut output = vec![[-9.0; 3]; noisy.len()];
        denoiser.denoise_guide(SIZE, guide, &noisy, &mut output).unwrap();
        let off = |picture: &Pixels| picture.iter().map(|color| (color[0] - 0.5).abs()).sum::<f32>();
        assert!(off(&output) < off(&noisy) / 4.0, "{guide:?}: {} {}", off(&output), off(&noisy));
    }
    let error = denoiser.denoise_guide(SIZE, Guide::Albedo, &noisy[1..], &mut vec![[0.0; 3]; noisy.len()]);
    assert!(matches!(error, Err(Error::Size { what: "the guide", .. })), "{error:?}");
}

/// The mean, and how far values are from it on average, of the red of the left half and the green of the right one.
fn spread(picture: &[[f32; 3]]) -> [f32; 2] {
    let value = |(pixel, color): (usize, &[f32; 3])| color[usize::from(pixel % SIZE[0] >= SIZE[0] / 2)];
    let values: Vec<f32> = picture.iter().enumerate().map(value).collect();
    let mean = values.iter().sum::<f32>() / values.len() as f32;
    [mean, values.iter().map(|value| (value - mean).abs()).sum::<f32>() / values.len() as f32]
}

#[test]
#[cfg_attr(not(open_image_denoise), ignore = "needs Open Image Denoise: make setup")]
fn noise_goes_and_light_and_edges_stay() {
    let before = spread(&noisy().0);
    for quality in [Quality::High, Quality::Balanced, Quality::Fast] {
        let picture = denoised(2, quality);
        let after = spread(&picture);
        assert!((after[0] / before[0] - 1.0).abs() < 0.05, "{quality:?}: {before:?} {after:?}");
        assert!(after[1] < before[1] / 10.0, "{quality:?}: {before:?} {after:?}");
        let row = &picture[24 * SIZE[0]..][..SIZE[0]];
        assert!(row[38][0] > 4.0 * row[38][1], "{quality:?}: {:?}", row[38]);
        assert!(row[41][1] > 4.0 * row[41][0], "{quality:?}: {:?}", row[41]);
    }
    assert!(denoised(2, Quality::High) != denoised(2, Quality::Fast), "the library is told");
}

#[test]
#[cfg_attr(not(open_image_denoise), ignore = "needs Open Image Denoise: make setup")]
fn the_number_of_threads_changes_no_bit() {
    for quality in [Quality::High, Quality::Fast] {
        let one = denoised(1, quality);
        assert!(one == denoised(2, quality) && one == denoised(5, quality), "{quality:?}");
    }
}

#[test]
#[cfg_attr(not(open_image_denoise), ignore = "needs Open Image Denoise: make setup")]
fn lists_of_another_size_are_refused() {
    let mut denoiser = Denoiser::load(&library(), 1, Quality::Fast).unwrap();
    assert_eq!(denoiser.version()[0], 2);
    let (color, albedo, normal) = noisy();
    let guides = Guides { albedo: &albedo[1..], normal: &normal };
    let error = denoiser.denoise(SIZE, &color, guides, &mut color.clone()).unwrap_err();
    assert!(error.to_string().contains("the albedo has 3839 pixels, and the picture 3840"), "{error}");
    // and what is empty by the library, or not at all
    let guides = Guides { albedo: &[], normal: &[] };
    let _ = denoiser.denoise([0, 0], &[], guides, &mut []);
    let guides = Guides { albedo: &albedo, normal: &normal };
    denoiser.denoise(SIZE, &color, guides, &mut color.clone()).expect("it goes on after that");
}

#[test]
fn a_library_that_is_not_there_is_named() {
    let error = Denoiser::load(Path::new("/nowhere/libOpenImageDenoise.so.2"), 1, Quality::High).unwrap_err();
    assert!(matches!(error, Error::Load { .. }), "{error:?}");
    assert!(error.to_string().contains("/nowhere/libOpenImageDenoise.so.2"), "{error}");
}

/// Another library lacks the functions.
#[test]
#[cfg(target_os = "linux")]
fn another_library_is_refused() {
    let error = Denoiser::load(Path::new("libm.so.6"), 1, Quality::High).unwrap_err().to_string();
    assert!(error.contains("libm.so.6") && error.contains("oidnNewDevice"), "{error}");
}

/// A library with the functions of Open Image Denoise, of a version in which they may have other types.
#[test]
#[cfg(target_os = "linux")]
fn a_library_of_another_version_is_refused_before_its_other_functions_are_called() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (source, library) = (folder.join("version-3.c"), folder.join("libversion-3.so"));
    let others = [
        "oidnSetDeviceInt",
        "oidnSetDeviceBool",
        "oidnCommitDevice",
        "oidnNewFilter",
        "oidnSetSharedFilterImage",
        "oidnSetFilterBool",
        "oidnSetFilterInt",
        "oidnCommitFilter",
        "oidnExecuteFilter",
        "oidnReleaseFilter",
    ];
    let others: String = others.iter().map(|name| format!("void {name}(void) {{ abort(); }}\n")).collect();
    let text = format!(
        "#include <stdlib.h>\n#include <string.h>\nstatic int device;\nvoid *oidnNewDevice(int type) {{ return &device; }}\n\
         void oidnReleaseDevice(void *device) {{}}\nint oidnGetDeviceError(void *device, const char **text) {{ return 0; }}\n\
         int oidnGetDeviceInt(void *device, const char *name) {{ return strcmp(name, \"versionMajor\") ? 1 : 3; }}\n{others}"
    );
    std::fs::write(&source, text).unwrap();
    let mut compiler = std::process::Command::new("cc");
    let status = compiler.args(["-shared", "-fPIC", "-w", "-o"]).arg(&library).arg(&source).status().unwrap();
    assert!(status.success());
    let error = Denoiser::load(&library, 1, Quality::High).unwrap_err().to_string();
    assert!(error.contains("libversion-3.so") && error.contains("3.1.1, and version 2 is needed"), "{error}");
}
