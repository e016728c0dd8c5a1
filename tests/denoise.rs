//! Is a denoised picture beside the exact one, better than it, and the same whatever the machine does? And what is said where
//! there is no library?
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod program;

use std::path::Path;

use afterimage::denoise::{Denoiser, PLANES, with_guides};
use afterimage::film::{Film, Plane};
use afterimage::frame::Renderer;
use afterimage::layers::Layers;
use afterimage::output::png::srgb_byte;
use afterimage::scene;
use afterimage::settings::{DenoiseQuality, Mode, Settings};
use program::{Place, Ran, assert_same, whole};

#[test]
#[cfg_attr(not(open_image_denoise), ignore = "needs Open Image Denoise: make setup")]
fn a_denoised_picture_is_beside_the_exact_one() {
    let place = Place::new();
    place.render("-o plain/a.####.exr --frames 1-3").done();
    place.render("-o both/a.####.exr --frames 1-3 --denoise").done();
    for frame in 1..=3 {
        let read = |folder| whole(&place.path(&format!("{folder}/a.{frame:04}.exr")));
        let (plain, both) = (read("plain"), read("both"));
        assert_eq!(both.channels.len(), plain.channels.len() + 3, "what guides the denoiser is not written");
        for channel in &plain.channels {
            assert_eq!(both.channel(&channel.name).unwrap().data, channel.data, "{}", channel.name);
        }
        for (denoised, exact) in PLANES.iter().zip(["R", "G", "B"]) {
            let [denoised, exact] = [denoised, exact].map(|name| &both.channel(name).unwrap().data);
            let sum = |values: &[f32]| values.iter().sum::<f32>();
            assert!(denoised != exact);
            assert!((sum(denoised) / sum(exact) - 1.0).abs() < 0.05, "{} {}", sum(denoised), sum(exact));
        }
    }
}

#[test]
#[cfg_attr(not(open_image_denoise), ignore = "needs Open Image Denoise: make setup")]
fn previews_show_the_denoised_picture_and_statistics_its_seconds() {
    let place = Place::new();
    place.render("-o a.####.exr --frames 2 --denoise --png --layers none --stats a.json").done();
    let frame = whole(&place.path("a.0002.exr"));
    let planes = PLANES.map(|name| &frame.channel(name).unwrap().data);
    let preview = image::open(place.path("a.0002.png")).unwrap().to_rgb8();
    for (pixel, bytes) in preview.pixels().enumerate() {
        assert_eq!(bytes.0, planes.map(|plane| srgb_byte(plane[pixel])));
    }
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(place.path("a.json")).unwrap()).unwrap();
    assert!(json["frames"][0]["seconds"]["denoise"].as_f64().unwrap() > 0.0, "{json}");
}

#[test]
#[cfg_attr(not(open_image_denoise), ignore = "needs Open Image Denoise: make setup")]
fn the_shot_file_asks_for_it_and_threads_change_no_bit() {
    let place = Place::new();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/analytic");
    let text = std::fs::read_to_string(scenes.join("analytic.toml")).unwrap();
    let obj = format!("obj = \"{}/", scenes.display());
    let text = text.replace("obj = \"", &obj).replace("[output]\n", "[output]\ndenoise = true\n");
    std::fs::write(place.path("s.toml"), text).unwrap();
    for threads in [1, 2, 7] {
        let options = format!("-o {threads}/a.####.exr --frames 1-2 --size 200x120 --threads {threads}");
        Ran::of(place.command("s.toml", &options).output().unwrap()).done();
    }
    for frame in ["a.0001.exr", "a.0002.exr"] {
        let path = |threads: u32| place.path(&format!("{threads}/{frame}"));
        assert!(whole(&path(1)).channel(PLANES[0]).is_some());
        assert_same(&path(1), &path(2));
        assert_same(&path(1), &path(7));
    }
    let quick = "-o quick/a.####.exr --frames 1 --size 200x120 --denoise-quality fast";
    Ran::of(place.command("s.toml", quick).output().unwrap()).done();
    let [best, quick] = ["1", "quick"].map(|folder| whole(&place.path(&format!("{folder}/a.0001.exr"))));
    assert!(best.channel(PLANES[0]).unwrap().data != quick.channel(PLANES[0]).unwrap().data);
}

/// The mean squared difference of colours from `truth`, cut to what a screen shows.
fn error<'p>(planes: impl IntoIterator<Item = &'p Plane>, truth: &Film) -> f64 {
    let of_plane = |(plane, name): (&Plane, &str)| {
        let truth = truth.values(name).unwrap();
        let pairs = plane.values.to_floats().into_iter().zip(truth);
        pairs.map(|(a, b)| f64::from((a.min(1.0) - b.min(1.0)).powi(2))).sum::<f64>()
    };
    planes.into_iter().zip(["R", "G", "B"]).map(of_plane).sum()
}

#[test]
#[cfg_attr(not(open_image_denoise), ignore = "needs Open Image Denoise: make setup")]
fn a_denoised_picture_is_nearer_to_the_truth() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/city/sky.toml");
    let shot = scene::load(&path, true).unwrap();
    let small = Settings {
        width: 160,
        height: 90,
        samples: 1,
        mode: Mode::Full,
        layers: Layers::NONE,
        ..shot.settings.clone()
    };
    let render = |paths| {
        let settings = with_guides(&Settings { paths, ..small.clone() });
        let mut renderer = Renderer::new(&shot.scene, &settings).unwrap();
        Film::clone(&renderer.render(1, false).unwrap().film)
    };
    let (noisy, truth) = (render(1), render(128));
    let denoised = Denoiser::new(2, DenoiseQuality::High).unwrap().denoise(&noisy).unwrap();
    let before = error(["R", "G", "B"].map(|name| noisy.plane(name).unwrap()), &truth);
    let after = error(&denoised, &truth);
    assert!(after < before / 2.0, "{before} {after}");
}

#[test]
fn without_a_library_it_is_said_what_to_do_before_anything_is_rendered() {
    let place = Place::new();
    let mut command = place.command(program::analytic(), "-o a.####.exr --frames 1 --denoise");
    let ran = Ran::of(command.env("OIDN_DIR", place.path("nothing")).output().unwrap());
    ran.failed(&["OIDN_DIR is set", "nothing/lib/libOpenImageDenoise.so.2", "make setup"]);
    assert!(!place.path("a.0001.exr").exists());
}
