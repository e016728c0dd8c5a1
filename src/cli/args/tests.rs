use clap::Parser;
use glam::DVec3;

use super::*;
use crate::animation::{Interpolation, Track, TransformTrack};
use crate::scene::{Model, Scene};
use crate::settings::{Build, Mode, RayEstimate, Refinement};

#[derive(Parser)]
struct Typed {
    #[command(flatten)]
    args: ShotArgs,
}

fn typed(line: &str) -> Result<ShotArgs, String> {
    let words = std::iter::once("test").chain(line.split_whitespace());
    Typed::try_parse_from(words).map(|typed| typed.args).map_err(|error| error.to_string())
}

fn of_file() -> Settings {
    Settings {
        width: 64,
        height: 32,
        overscan: 6,
        crop: None,
        samples: 3,
        refinement: None,
        filter: Filter::Mitchell,
        filter_radius: Some(1.75),
        depth: 5,
        reflections: 4,
        paths: 3,
        paths_per_frame: 2,
        budget: Budget::Rays(5),
        bounces: 1,
        volume_bounces: 7,
        volume_samples: 3,
        caustics: Caustics::None,
        clamp: Some(9.0),
        only_lights: Some(String::from("key")),
        occlusion_rays: 8,
        occlusion_radius: 3.0,
        tree_memory: 5,
        stereo: None,
        shutter: None,
        exposures: Some(9),
        mode: Mode::Auto,
        reuse: Reuse::Paper,
        base_every: 7,
        base_place: BasePlace::First,
        layers: Layers::ALL,
        background: Backdrop::Visible,
        audit: false,
        build: Build::Best,
        wanted: Some(Wanted { error: 0.2, free: Free { paths: false, ..Free::ALL } }),
    }
}

#[test]
fn the_file_holds_where_the_command_line_is_silent() {
    let args = typed("a.toml").expect("fine");
    assert_eq!(args.settled(&of_file()), Ok(of_file()));
}

#[test]
fn the_command_line_beats_the_file() {
    let line = "a.toml --size 8x4 --crop 9x3-2+1 --overscan 2 --samples 2 --filter tent --filter-radius 1.25 --depth 1 --reflections 9 --paths 16 --caustics paths --clamp 2.5 --only-lights fill --paths-per-frame 4 --budget full --occlusion-rays 32 --occlusion-radius 0.25 --tree-memory 0 --reuse target --base-every 0 --base-place middle --layers Z --background transparent --audit --error 3%";
    let settled = typed(line).expect("fine").settled(&of_file()).expect("fine");
    let expected = Settings {
        width: 8,
        height: 4,
        overscan: 2,
        crop: Some(PixelRect { x: -2, y: 1, width: 9, height: 3 }),
        samples: 2,
        refinement: None,
        filter: Filter::Tent,
        filter_radius: Some(1.25),
        depth: 1,
        reflections: 9,
        paths: 16,
        paths_per_frame: 4,
        budget: Budget::Full,
        bounces: 1,
        volume_bounces: 7,
        volume_samples: 3,
        caustics: Caustics::Paths,
        clamp: Some(2.5),
        only_lights: Some(String::from("fill")),
        occlusion_rays: 32,
        occlusion_radius: 0.25,
        tree_memory: 0,
        stereo: None,
        shutter: None,
        exposures: Some(9),
        mode: Mode::Auto,
        reuse: Reuse::Target,
        base_every: 0,
        base_place: BasePlace::Middle,
        layers: Layers::Z,
        background: Backdrop::Transparent,
        audit: true,
        build: Build::Best,
        wanted: Some(Wanted {
            error: 0.03,
            free: Free { samples: false, paths: false, reflections: false, shadow_rays: true },
        }),
    };
    assert_eq!(settled, expected);
}

#[test]
fn what_makes_no_sense_is_refused_with_a_way_out() {
    for (options, word) in [
        ("--size 0x4", "1280x720"),
        ("--size 4", "1280x720"),
        ("--size 4x70000", "65535"),
        ("--crop 9x3", "320x180+640+400"),
        ("--crop 9x3+0,0", "320x180+640+400"),
        ("--overscan -1", "unexpected"),
        ("--overscan 99999", "0..=16384"),
        ("--samples 0", "1..=16"),
        ("--samples 1-17", "1..=16"),
        ("--samples -4", "unexpected"),
        ("--samples 1-", "1..=16"),
        ("--error 0", "0.001 to 0.9"),
        ("--error 100%", "0.001 to 0.9"),
        ("--error nan", "0.001 to 0.9"),
        ("--error few", "3%"),
        ("--threshold 0", "above 0"),
        ("--threshold 1", "above 0"),
        ("--threshold nan", "above 0"),
        ("--depth 65", "0..=64"),
        ("--threads 0", "1 to 4096"),
        ("--frames 9-1", "backwards"),
        ("--frames 1-x", "frames"),
        ("--backend cuda", "embree"),
        ("--progress loud", "plain"),
        ("--layers far", "there are diffuse"),
        ("--occlusion-rays 0", "1..=256"),
        ("--occlusion-rays 257", "1..=256"),
        ("--occlusion-radius 0", "above 0"),
        ("--occlusion-radius=-1", "above 0"),
        ("--occlusion-radius nan", "above 0"),
        ("--occlusion-radius inf", "above 0"),
        ("--exposure bright", "-20 to 20 stops"),
        ("--exposure -21", "-20 to 20 stops"),
        ("--exposure nan", "-20 to 20 stops"),
        ("--view aces", "agx"),
    ] {
        let error = typed(&format!("a.toml {options}")).expect_err(options);
        assert!(error.contains(word), "{options}: {error}");
    }
}

#[test]
fn adaptive_samples_are_settled_with_the_shot() {
    let of_shot = Refinement { most: 8, threshold: 0.3 };
    let adaptive = Settings { samples: 2, refinement: Some(of_shot), filter: Filter::Box, ..of_file() };
    let adaptive = Settings { filter_radius: None, ..adaptive };
    let settled = |line: &str| typed(&format!("a.toml {line}")).expect("fine").settled(&adaptive);
    let samples = |line: &str| settled(line).map(|settings| (settings.samples, settings.refinement));
    assert_eq!(samples(""), Ok((2, Some(of_shot))));
    assert_eq!(samples("--samples 1-4"), Ok((1, Some(Refinement { most: 4, ..of_shot }))));
    assert_eq!(samples("--threshold 0.5"), Ok((2, Some(Refinement { threshold: 0.5, ..of_shot }))));
    assert_eq!(samples("--samples 4"), Ok((4, None)));
    let wrong = [
        ("--samples 1-3", "doubled"),
        ("--filter tent", "filter `box`"),
        ("--samples 4 --threshold 0.1", "MIN-MAX"),
    ];
    for (line, word) in wrong {
        let error = settled(line).expect_err(line);
        assert!(matches!(&error, Failure::Usage(text) if text.contains(word)), "{line}: {error:?}");
    }
}

#[test]
fn pixels_that_are_not_there_are_refused_with_the_size() {
    for (options, words) in [
        ("--crop 0x4+0+0", ["0x4+0+0", "64x32"]),
        ("--overscan 0 --crop 9x4-1+0", ["9x4-1+0", "picture is 64x32"]),
        ("--crop 9x4-7+0", ["64x32", "76x44-6-6"]),
        ("--size 20x10 --overscan 0 --crop 5x5+16+0", ["5x5+16+0", "20x10"]),
        ("--crop 4294967295x1+0+0", ["4294967295x1", "64x32"]),
        ("--size 65535x1 --overscan 1", ["65535", "--overscan"]),
    ] {
        let settled = typed(&format!("a.toml {options}")).expect(options).settled(&of_file());
        let error = settled.expect_err(options).to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{options}: {error}");
    }
}

#[test]
fn a_frame_that_no_memory_holds_is_refused() {
    let args = typed("a.toml --size 65535x65535 --samples 16").expect("each is fine by itself");
    assert!(args.settled(&of_file()).is_err_and(|error| error.to_string().contains("--size")));
}

#[test]
fn frames_may_be_negative() {
    let frames = typed("a.toml --frames -2-1").expect("fine").frames.expect("given");
    assert_eq!(frames.list(), [-2, -1, 0, 1]);
}

#[test]
fn how_to_build_follows_from_the_shot() {
    let mut one = open(Path::new("scenes/analytic/triangle.obj"), true, &turntable::Options::default())
        .expect("a scene of the repository");
    // without its floor, and with a ray to each light
    one.scene.models.truncate(1);
    one.scene.lights.iter_mut().for_each(|light| light.samples = 1);
    let of = |model: &Model| {
        let scene = Scene { models: vec![model.clone(); 10], ..one.scene.clone() };
        Shot { scene, ..one.clone() }
    };
    let model = &one.scene.models[0];
    let scale = Track::through(vec![(1.0, DVec3::ONE), (2.0, DVec3::ZERO)], Interpolation::Linear);
    let track = TransformTrack { scale: scale.expect("good keys"), ..TransformTrack::identity() };
    let (still, moving) = (of(model), of(&Model { track, ..model.clone() }));
    assert_eq!([one.triangles(), still.triangles(), moving.triangles()], [1, 10, 1], "built once to move");
    let tiny = Settings { width: 1, height: 1, samples: 1, paths: 0, ..one.settings.clone() };
    let rays = RayEstimate { coherent: 360, scattered: 0 };
    assert_eq!(one.rays(&tiny), Some(rays), "120 frames; from the eye, and to two lights");
    let tiny = Settings { paths: 3, bounces: 2, ..tiny };
    let rays = RayEstimate { coherent: 3, scattered: 15 };
    assert_eq!(one.rays_of_sample(&tiny), rays, "three segments of each path, and two rays to lights");

    let build = |options: &str, shot: &Shot| {
        let args = typed(&format!("a.obj --size 1x1 --samples 1 --paths 0 {options}")).expect("fine");
        args.build.for_shot(shot, &args.settled(&shot.settings).expect("fine"))
    };
    assert_eq!(build("", &one), Build::Best);
    assert_eq!(build("--build quick", &one), Build::Quick);
    assert_eq!(build("", &still), Build::Quick, "36 rays a triangle");
    assert_eq!(build("--build best", &still), Build::Best);
    let of_paths = still.build_that_pays(&Settings { paths: 1, ..tiny });
    assert_eq!(
        of_paths,
        Build::Best,
        "with paths 96 rays a triangle, of which those of paths count eight times"
    );
    assert_eq!(build("--frames 1-9999", &still), Build::Quick, "whatever frames are asked for");
    assert_eq!(build("", &Shot { says_frames: false, ..still }), Build::Best, "nobody knows how many");
    assert_eq!(build("", &moving), Build::Best);
}

#[test]
fn backends_have_names() {
    assert_eq!(typed("a.toml").expect("fine").backend, None);
    let rust = typed("a.toml --backend rust").expect("known").backend;
    assert_eq!(rust.map(|kind| BackendKind::from(kind).name()), Some("rust"));
}

#[test]
fn default_names_come_from_the_shot() {
    assert_eq!(default_output(Path::new("scenes/city.toml")), "out/city/city.####.exr");
    assert_eq!(default_output(Path::new("a#1.obj")), "out/a_1/a_1.####.exr");
}
