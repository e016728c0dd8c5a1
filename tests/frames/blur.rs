//! Motion blur and depth of field: are all exposures exact, and does their mean depend on nothing else?

use afterimage::animation::{Track, Visibility};
use afterimage::exposure::Shutter;
use afterimage::film::Film;
use afterimage::frame::{Finished, Renderer, Spoil};
use afterimage::scene::Scene;
use afterimage::scene::camera::EyeTrack;
use afterimage::settings::{Budget, Filter, Mode, PixelRect, Refinement, Reuse, Settings};
use glam::DVec3;

use crate::runs;
use crate::runs::{Place, assert_same as assert_same_files};
use crate::toy;
use crate::toy::worlds::*;

/// Half of the time, about each frame's own.
const HALF: Option<Shutter> = Some(Shutter::new(-0.25, 0.25));

/// Four exposures.
pub fn settings(samples: u32) -> Settings {
    Settings { shutter: HALF, exposures: Some(4), ..toy::settings(samples) }
}

/// With a lens of that radius, focused on the camera's target.
pub fn with_lens(mut scene: Scene, radius: f64) -> Scene {
    scene.camera.lens.aperture = Some(Track::constant(radius));
    scene
}

fn dolly(scene: Scene) -> Scene {
    with_camera(scene, goes(EYE, EYE + DVec3::new(0.4, -0.2, -0.5)), rests(TARGET))
}

/// With a flyer that is there for parts of some shutters.
fn comes_and_goes(mut scene: Scene) -> Scene {
    let flyer = scene.models.last_mut().unwrap();
    flyer.track.visible = Visibility::through(false, vec![(2.1, true), (3.05, false), (3.9, true)]).unwrap();
    scene
}

/// Demands an audit without a difference; gives the share of samples that were reused after the first frame.
fn audited(name: &str, scene: &Scene, settings: &Settings) -> f64 {
    let (mut reused, mut all) = (0, 0);
    for Finished { stats, .. } in toy::render(scene, &Settings { audit: true, ..settings.clone() }, 4) {
        let audit = stats.audit.unwrap();
        assert_eq!(audit.checked, stats.samples.total());
        assert_eq!(audit.wrong(), 0, "{name}, frame {}: {audit:?}", stats.frame);
        assert!(audit.on_edge * 100 < audit.checked, "{name}, frame {}: {audit:?}", stats.frame);
        if stats.frame > 1 {
            (reused, all) = (reused + stats.samples.reused(), all + stats.samples.total());
        }
    }
    reused as f64 / all as f64
}

/// Each way of rendering before each kind of camera; with and without a lens, lights that move and a flyer that comes and goes, so
/// that each two of all of these meet.
#[test]
fn every_exposure_is_exact_whatever_moves() {
    type Change = fn(Scene) -> Scene;
    let turns = |scene| with_camera(scene, rests(EYE), goes(TARGET, TARGET + DVec3::X));
    let cameras: [(&str, Change); 3] = [("at rest", |scene| scene), ("dolly", dolly), ("turns", turns)];
    let small = |samples| Settings { width: 64, height: 48, ..settings(samples) };
    let ways = [
        small(2),
        Settings { filter: Filter::Mitchell, ..small(4) },
        // in a smaller picture tracing would pay
        Settings { mode: Mode::Auto, exposures: Some(9), ..settings(3) },
        Settings { reuse: Reuse::Paper, ..small(4) },
        Settings { shutter: None, ..small(2) },
        Settings { refinement: Some(Refinement { most: 4, threshold: 0.1 }), ..small(2) },
    ];
    for (way, settings) in ways.iter().enumerate() {
        for (number, (name, camera)) in cameras.into_iter().enumerate() {
            let (lens, lights, flyer) = (way + number, way / 2 + number, way / 3 + number.div_ceil(2));
            let mut scene = camera(with_flyer(world()));
            if lens % 2 == 1 {
                scene = with_lens(scene, 0.2);
            }
            if lights % 2 == 1 {
                scene = with_area_lights(scene);
            }
            if flyer % 2 == 1 {
                scene = comes_and_goes(scene);
            }
            let name = format!("{name}, way {way}, {lens} {lights} {flyer}");
            let share = audited(&name, &scene, settings);
            assert!(share > 0.7, "{name}: {share}");
        }
    }
}

/// Answers hold until some moment, and not until some frame.
#[test]
fn what_samples_gather_is_exact_at_every_moment() {
    let scenes = [
        ("at rest", with_flyer(world())),
        ("dolly", dolly(with_flyer(world()))),
        ("comes and goes", comes_and_goes(with_flyer(world()))),
    ];
    for (name, mut scene) in scenes {
        scene.ambient_is_occluded = true;
        for budget in [Budget::None, Budget::Full] {
            let settings = Settings {
                paths: 4,
                paths_per_frame: 2,
                budget,
                occlusion_rays: 4,
                occlusion_radius: 1.5,
                ..settings(2)
            };
            audited(name, &scene, &settings);
            audited(name, &with_lens(scene.clone(), 0.15), &Settings { shutter: None, ..settings });
        }
    }
}

/// A camera that rests, moves and rests again within a shutter, and cuts.
#[test]
fn exposures_are_exact_when_the_camera_starts_and_stops() {
    let away = EYE + DVec3::new(0.3, 0.0, -0.2);
    let eye = toy::keys(&[(1.0, EYE), (3.25, EYE), (4.5, away), (20.0, away)]);
    for radius in [0.0, 0.1] {
        let mut scene = with_lens(with_camera(with_flyer(world()), eye.clone(), rests(TARGET)), radius);
        let settings = Settings { audit: true, ..settings(2) };
        let frames = toy::render(&scene, &settings, 8);
        assert!(frames.iter().all(|frame| toy::differing(frame) == 0));
        let verified = |frame: usize| frames[frame - 1].stats.rays.verification;
        assert!(verified(4) > 4 * verified(8), "in place again: {} {}", verified(4), verified(8));
        scene.camera.cuts = vec![4];
        if let EyeTrack::Keyed(places) = scene.camera.eye {
            scene.camera.eye = places.cut_at(&[4.0]).into();
        }
        assert!(toy::render(&scene, &settings, 6).iter().all(|frame| toy::differing(frame) == 0));
    }
}

#[test]
fn the_audit_finds_spoilt_samples_of_an_exposure() {
    for scene in [dolly(with_flyer(matt_world())), with_flyer(matt_world())] {
        for what in [Spoil::Place, Spoil::Reflectance, Spoil::Tags] {
            let settings = Settings { audit: true, ..settings(2) };
            let mut renderer = Renderer::new(&scene, &settings).unwrap();
            renderer.render(1, true).unwrap();
            assert!(renderer.spoil(what).unwrap() > 0);
            let audit = renderer.render(2, true).unwrap().stats.audit.unwrap();
            assert!(audit.differing > 0, "{what:?}");
        }
    }
}

fn planes(film: &Film) -> Vec<(String, Vec<u32>)> {
    let bits = |values: Vec<f32>| values.into_iter().map(f32::to_bits).collect();
    film.planes.iter().map(|plane| (plane.name.to_string(), bits(plane.values.to_floats()))).collect()
}

#[track_caller]
fn assert_same(one: &Finished, other: &Finished, what: &str) {
    for ((name, one), (_, other)) in planes(&one.film).into_iter().zip(planes(&other.film)) {
        let off = one.iter().zip(&other).filter(|(one, other)| one != other).count();
        assert_eq!((one.len(), off), (other.len(), 0), "{what}: {name}");
    }
}

#[test]
fn frames_are_the_same_for_any_number_of_threads_and_in_any_chunk() {
    for scene in [with_lens(dolly(with_flyer(world())), 0.1), with_flyer(world())] {
        let settings = Settings { paths: 2, ..settings(2) };
        let on = |threads, first: i32| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut renderer = Renderer::new(&scene, &settings).unwrap();
                (first..=4).map(|frame| renderer.render(frame, frame != 3).unwrap()).collect::<Vec<_>>()
            })
        };
        let one = on(1, 1);
        for (threads, first) in [(2, 1), (5, 1), (3, 3)] {
            for other in on(threads, first) {
                let frame = other.stats.frame;
                let one = &one[frame as usize - 1];
                // ages are counted from where a chunk begins, and nothing but those
                assert_same(one, &other, &format!("{threads} threads from {first}, frame {frame}"));
                assert_eq!(one.stats.rays, other.stats.rays);
            }
        }
    }
}

#[test]
fn a_shutter_that_does_not_open_takes_a_sharp_frame() {
    let scene = dolly(with_flyer(world()));
    let render = |shutter| toy::render(&scene, &Settings { shutter, ..settings(2) }, 3);
    let (sharp, closed) = (render(None), render(Some(Shutter::new(0.0, 0.0))));
    for (one, other) in sharp.iter().zip(&closed) {
        assert_same(one, other, "closed");
        assert_eq!((one.camera, one.stats.rays), (other.camera, other.stats.rays));
    }
    let traced = |frame, shutter| {
        let settings = Settings { shutter, ..settings(2) };
        Renderer::new(&scene, &settings).unwrap().render(frame, false).unwrap()
    };
    let later = traced(2, Some(Shutter::new(1.0, 1.0)));
    for plane in ["R", "Z", "P.X", "CryptoObject00.G"] {
        assert_eq!(toy::mean_difference(&later, &traced(3, None), plane), 0.0, "{plane}");
    }
}

/// A picture of reused samples is that of samples that were all traced, but for which points of surfaces stand for a pixel.
#[test]
fn pictures_agree_with_those_that_are_traced_in_full() {
    for (name, scene) in [
        ("at rest", with_lens(with_flyer(matt_world()), 0.2)),
        ("dolly", with_lens(dolly(with_flyer(matt_world())), 0.2)),
    ] {
        let render = |mode, samples| {
            let settings = Settings { mode, exposures: Some(samples * samples), ..settings(samples) };
            // what is traced in full depends on no frame before it
            let first = if mode == Mode::Full { FRAMES } else { 1 };
            let mut renderer = Renderer::new(&scene, &settings).unwrap();
            (first..=FRAMES).map(|frame| renderer.render(frame, true).unwrap()).last().unwrap()
        };
        let truth = render(Mode::Full, 12);
        let [full, inferred] = [Mode::Full, Mode::Reproject].map(|mode| render(mode, 4));
        let [off, own] = [&inferred, &full].map(|frame| toy::mean_difference(frame, &truth, "G"));
        assert!(off < own * 2.5 && off < 0.003, "{name}: {off} {own}");
    }
}

/// Where nothing moves, exposures have the samples of a sharp frame among them: in the same places, with the same random numbers. (What is
/// seen in mirrors has random numbers that follow from the bits of its place.)
#[test]
fn a_still_world_is_as_in_a_sharp_frame() {
    let mut scene = world();
    scene.ambient_is_occluded = true;
    for (samples, exposures) in [(2, 4), (4, 4), (4, 16), (6, 9)] {
        let settings =
            Settings { paths: 2, occlusion_rays: 4, exposures: Some(exposures), ..settings(samples) };
        let sharp = Settings { shutter: None, ..settings.clone() };
        let [blurred, sharp] = [settings, sharp].map(|settings| toy::render(&scene, &settings, 1).remove(0));
        assert_eq!(blurred.stats.samples, sharp.stats.samples);
        assert_eq!(blurred.stats.rays.primary, sharp.stats.rays.primary);
        for plane in ["diffuse.R", "diffuse.G", "A", "occlusion.V"] {
            let [one, other] = [&blurred, &sharp].map(|frame| frame.film.values(plane).unwrap());
            let off = one.iter().zip(&other).filter(|(one, other)| (*one - *other).abs() > 2e-3).count();
            // rounding decides where a sample meets an edge
            assert!(off * 200 < one.len(), "{samples}, {exposures}, {plane}: {off} of {}", one.len());
        }
    }
}

/// The same, frame after frame, before a camera that moves.
#[test]
fn a_blurred_frame_costs_what_a_sharp_one_costs() {
    let scene = dolly(with_flyer(matt_world()));
    for (samples, exposures, most) in [(4, 4, 1.1), (4, 16, 1.5)] {
        let settings = Settings { paths: 2, exposures: Some(exposures), ..settings(samples) };
        let sharp = Settings { shutter: None, ..settings.clone() };
        let [blurred, sharp] = [settings, sharp].map(|settings| {
            let mut renderer = Renderer::new(&scene, &settings).unwrap();
            let frames = (1..=4).map(|frame| renderer.render(frame, true).unwrap().stats);
            let rays: u64 = frames.map(|stats| stats.rays.total()).sum();
            (rays as f64, renderer.memory().bytes_per_sample)
        });
        let (rays, bytes) = (blurred.0 / sharp.0, blurred.1 / sharp.1);
        assert!(rays < most && bytes < most, "{samples}, {exposures}: {rays} rays, {bytes} bytes");
    }
}

#[test]
fn a_resting_camera_pays_only_for_what_moves() {
    let still = with_lens(matt_world(), 0.2);
    let mut scene = still.clone();
    scene.models.retain(|model| model.name != "flyer");
    let frames = toy::render(&scene, &Settings { shutter: None, ..settings(2) }, 3);
    assert_eq!(frames[2].stats.rays.total(), 0);
    assert_eq!(toy::mean_difference(&frames[1], &frames[2], "R"), 0.0);
    let frames = toy::render(&still, &settings(2), 4);
    let rays = |frame: usize| frames[frame].stats.rays.total();
    assert!(rays(3) * 3 < rays(0), "{} {}", rays(0), rays(3));
}

/// Traced in full: what is reused in a crop lacks what comes from beside it.
#[test]
fn a_crop_is_the_part_of_the_picture() {
    let scene = with_lens(with_flyer(world()), 0.2);
    for filter in [Filter::Box, Filter::Gaussian] {
        let settings = Settings { filter, mode: Mode::Full, ..settings(2) };
        let crop = PixelRect { x: 20, y: 30, width: 40, height: 20 };
        let render = |crop| toy::render(&scene, &Settings { crop, ..settings.clone() }, 1).pop().unwrap();
        let (whole, part) = (render(None), render(Some(crop)));
        for plane in ["R", "A", "Z", "CryptoObject00.G", "N.X", "forward.U"] {
            for (x, y) in (0..40).flat_map(|x| (0..20).map(move |y| (x, y))) {
                let [part, whole] =
                    [toy::pixel(&part, plane, x, y), toy::pixel(&whole, plane, x + 20, y + 30)];
                assert_eq!(part, whole, "{plane} {x} {y}");
            }
        }
    }
}

/// Runs of the binary, with frames that are blurred.
fn run(place: &Place, options: &str) -> runs::Ran {
    place.render(&format!("--size 48x27 --progress none {options}"))
}

#[test]
fn chunks_and_resumed_runs_are_blurred_alike() {
    let place = Place::new();
    let blurred = "--shutter -0.25,0.25 --samples 4 --exposures 4 --base-every 4 --layers all";
    run(&place, &format!("{blurred} --frames 1-8 --audit -o whole/f.####.exr")).done();
    for chunk in ["7-8", "1-2", "3-6"] {
        run(&place, &format!("{blurred} --frames {chunk} -o chunks/f.####.exr")).done();
    }
    for frame in 1..=8 {
        let [one, other] =
            ["whole", "chunks"].map(|folder| place.path(&format!("{folder}/f.{frame:04}.exr")));
        assert_same_files(&one, &other);
    }
    let again = |options: &str| {
        run(&place, &format!("{options} --frames 1-8 --resume -o whole/f.####.exr")).done().stderr
    };
    assert!(again(blurred).contains("8 frames are there"));
    assert!(again(&blurred.replace("exposures 4", "exposures 16")).contains("settings"));
}

#[test]
fn the_shot_says_how_it_is_blurred_and_the_command_line_beats_it() {
    let place = Place::new();
    let text = std::fs::read_to_string(runs::analytic()).unwrap();
    let shot = runs::analytic().canonicalize().unwrap();
    let folder = shot.parent().unwrap();
    let text = text.replace("obj = \"", &format!("obj = \"{}/", folder.display()));
    std::fs::write(place.path("s.toml"), format!("{text}\n[shutter]\n")).unwrap();
    let rays = |options: &str| {
        let options = format!("--size 48x27 --frames 2 --mode full --stats s.json --progress none {options}");
        runs::Ran::new(place.command("s.toml", &options).output().unwrap()).done();
        let json = std::fs::read(place.path("s.json")).unwrap();
        let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
        json["totals"]["rays"]["primary"].as_u64().unwrap()
    };
    let sharp = rays("--sharp");
    for options in ["", "--exposures 4", "--exposures 1", "--shutter 0.25,0.25"] {
        assert_eq!(rays(options), sharp, "{options}: exposures divide the samples");
    }
}

#[test]
fn what_does_not_go_with_exposures_is_refused_with_a_way_out() {
    let place = Place::new();
    for (options, word) in [
        ("--shutter 0.5,0", "before it opens"),
        ("--shutter 0,1.5", "-1 to 1"),
        ("--shutter -0.75,0.5", "360 degrees"),
        ("--shutter nan,1", "-1 to 1"),
        ("--shutter 180", "comma"),
        ("--exposures 0", "1..=256"),
        ("--sharp --exposures 4", "cannot be used"),
    ] {
        let ran = run(&place, options);
        assert!(ran.code == 2 && ran.stderr.contains(word), "{options}: {}", ran.stderr);
    }
}

/// A lens as large as the scene, and one whose points are inside of things.
#[test]
fn a_lens_as_large_as_the_scene_is_exact() {
    for radius in [3.0, 12.0] {
        let scene = with_lens(with_flyer(world()), radius);
        for finished in toy::render(&scene, &Settings { mode: Mode::Auto, audit: true, ..settings(2) }, 3) {
            assert_eq!(toy::differing(&finished), 0, "{radius}");
            assert!(finished.film.values("R").unwrap().iter().all(|value| value.is_finite()));
        }
    }
}
