//! Adaptive samples: do pixels get what they need, and is reuse exact in all levels?

use std::sync::Arc;

use afterimage::frame::{Finished, Renderer};
use afterimage::scene::Scene;
use afterimage::settings::{Mode, PixelRect, Refinement, Reuse, Settings};
use afterimage::trace::BackendKind;
use glam::DVec3;

use crate::small_shot;
use crate::toy;
use crate::toy::worlds::*;

fn adaptive(fewest: u32, most: u32) -> Settings {
    let refinement = Some(Refinement { most, threshold: 0.1 });
    Settings { refinement, ..toy::settings(fewest) }
}

/// Samples of a frame, those of all levels.
fn samples(frame: &Finished) -> u64 {
    let counts = frame.stats.samples;
    counts.base + counts.good + counts.overlapped + counts.missed + counts.obscured
}

/// Renders all frames, and demands audits without a difference.
fn audited(scene: &Scene, settings: &Settings) -> Vec<Finished> {
    let frames = toy::render(scene, &Settings { audit: true, ..settings.clone() }, FRAMES);
    for frame in &frames {
        let audit = frame.stats.audit.expect("asked for");
        assert_eq!(audit.wrong(), 0, "frame {}: {audit:?}", frame.stats.frame);
        assert_eq!(audit.checked, samples(frame), "frame {}", frame.stats.frame);
    }
    frames
}

/// Planes of the picture, without those that tell how it was made.
fn picture(frame: &Finished) -> Vec<(String, Vec<f32>)> {
    let planes = frame.film.planes.iter();
    let shown = planes.filter(|plane| !["status", "rays"].iter().any(|kind| plane.name.starts_with(kind)));
    shown.map(|plane| (plane.name.to_string(), plane.values.to_floats())).collect()
}

#[test]
fn pixels_that_differ_have_the_value_of_a_finer_picture_and_others_of_a_coarser_one() {
    let scene = world();
    let full = |settings: Settings| {
        let settings = Settings { mode: Mode::Full, ..settings };
        toy::render(&scene, &settings, 1).remove(0)
    };
    let levels = [1, 2, 4].map(|samples| full(toy::settings(samples)));
    let adaptive = full(adaptive(1, 4));
    let mut counts = [0; 3];
    for y in 0..72 {
        for x in 0..96 {
            let shown = toy::color(&adaptive, x, y);
            // the finest that it is equal to: where all are, none is worth more
            let level = (0..3).rev().find(|level| toy::color(&levels[*level], x, y) == shown);
            counts[level.unwrap_or_else(|| panic!("{x} {y}: {shown} is no level's"))] += 1;
        }
    }
    assert!(counts.iter().all(|count| *count > 50), "{counts:?}");
    assert!(samples(&adaptive) < samples(&levels[2]) / 2, "{}", samples(&adaptive));
}

#[test]
fn edges_are_refined_and_flat_surfaces_are_not() {
    let floor = toy::still("floor", toy::floor(50.0, 0), glam::Vec3::ZERO);
    let thing = toy::still("thing", toy::octahedron(0, true), glam::Vec3::new(0.0, 3.0, 0.0));
    let camera = toy::camera(rests(DVec3::new(0.0, 4.0, 8.0)), rests(DVec3::new(0.0, 2.0, 0.0)));
    let scene = toy::scene(camera, vec![floor, thing], vec![toy::matt(0.5)], vec![toy::sun_overhead(1.0)]);
    let settings = Settings { mode: Mode::Full, ..adaptive(1, 4) };
    let frame = toy::render(&scene, &settings, 1).remove(0);
    let fine = toy::render(&scene, &Settings { mode: Mode::Full, ..toy::settings(4) }, 1).remove(0);
    let mut mixed = 0;
    for (x, y) in (0..72).flat_map(|y| (0..96).map(move |x| (x, y))) {
        let (shown, wanted) = (toy::color(&frame, x, y), toy::color(&fine, x, y));
        // all that is seen here are four flat colours and edges between them
        assert!((shown - wanted).abs().max_element() < 2e-3, "{x} {y}: {shown} instead of {wanted}");
        let beside = |dx: u32, dy: u32| toy::color(&fine, (x + dx).min(95), (y + dy).min(71));
        mixed += u64::from(beside(0, 0) != beside(1, 0) || beside(0, 0) != beside(0, 1));
    }
    let added = samples(&frame) - 96 * 72;
    assert!(mixed > 100 && added < 3 * 20 * mixed, "{added} samples more for {mixed} edges");
}

#[test]
fn reuse_is_exact_in_all_levels_whatever_moves() {
    let moves = || with_camera(world(), goes(EYE, EYE + DVec3::new(1.0, 0.2, -1.5)), rests(TARGET));
    let shots = [
        ("nothing moves", world()),
        ("something flies", with_flyer(world())),
        ("the camera moves", moves()),
        ("both move", with_flyer(moves())),
        ("soft light", with_area_lights(with_flyer(moves()))),
        ("soft light at rest", with_area_lights(with_flyer(world()))),
    ];
    for (name, scene) in shots {
        let frames = audited(&scene, &adaptive(1, 4));
        let reused = |frame: &Finished| {
            let counts = frame.stats.samples;
            (counts.good + counts.overlapped) as f64 / samples(frame) as f64
        };
        let least = frames[1..].iter().map(reused).fold(1.0, f64::min);
        assert!(least > 0.5, "{name}: {least}");
    }
}

#[test]
fn gathered_light_occlusion_and_fewer_levels_are_exact_too() {
    let scene = with_flyer(with_camera(world(), goes(EYE, EYE + DVec3::new(0.5, 0.1, -0.8)), rests(TARGET)));
    audited(&scene, &Settings { paths: 2, occlusion_rays: 4, ..adaptive(1, 2) });
    audited(&with_flyer(world()), &Settings { paths: 2, occlusion_rays: 4, ..adaptive(2, 4) });
    audited(&scene, &Settings { mode: Mode::Auto, reuse: Reuse::Paper, ..adaptive(1, 4) });
}

#[test]
fn a_film_that_stands_shows_what_a_new_one_shows() {
    // the film of the frame before is kept by its reader: the next one gets a new film
    for scene in [world(), with_flyer(world())] {
        let [stands, anew] = [false, true].map(|keeps| {
            let mut renderer = Renderer::new(&scene, &adaptive(1, 4)).expect("the scene builds");
            let mut kept = Vec::new();
            let mut last = None;
            for frame in 1..=FRAMES {
                let finished = renderer.render(frame, true).expect("the frame renders");
                if keeps {
                    kept.push(Arc::clone(&finished.film));
                }
                last = Some(picture(&finished));
            }
            last
        });
        assert_eq!(stands, anew);
    }
}

#[test]
fn frames_do_not_depend_on_threads() {
    let scene = with_flyer(with_camera(world(), goes(EYE, EYE + DVec3::new(0.6, 0.0, -1.0)), rests(TARGET)));
    let render = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        pool.install(|| toy::render(&scene, &adaptive(1, 4), 4).iter().map(picture).collect::<Vec<_>>())
    };
    assert_eq!(render(1), render(5));
}

#[test]
fn a_crop_is_the_part_of_the_picture_in_all_levels() {
    let scene = with_flyer(world());
    let full = |crop: Option<PixelRect>, kind| {
        let settings = Settings { crop, mode: Mode::Full, ..adaptive(1, 4) };
        Renderer::with(kind, &scene, &settings).expect("the scene builds").render(3, false).expect("renders")
    };
    // on a tile's edge in each level
    let rect = PixelRect { x: 32, y: 8, width: 16, height: 24 };
    let [whole, part] = [None, Some(rect)].map(|crop| full(crop, BackendKind::Rust));
    for (plane, whole) in part.film.planes.iter().zip(&whole.film.planes) {
        for (x, y) in (0..16).flat_map(|x| (0..24).map(move |y| (x, y))) {
            let of_whole = whole.values.get((y + 8) * 96 + x + 32);
            assert_eq!(plane.values.get(y * 16 + x).to_bits(), of_whole.to_bits(), "{} {x} {y}", plane.name);
        }
    }
}

#[test]
fn samples_that_are_not_needed_come_back() {
    // the camera goes aside and comes back: pixels of edges are refined, are not, and are again
    let eye = toy::keys(&[(1.0, EYE), (3.0, EYE + DVec3::new(0.4, 0.0, 0.0)), (5.0, EYE)]);
    let scene = with_camera(matt_world(), eye, rests(TARGET));
    for reuse in [Reuse::Target, Reuse::Paper] {
        let frames = audited(&scene, &Settings { reuse, ..adaptive(1, 4) });
        let traced = |frame: &Finished| (frame.stats.samples.missed + frame.stats.samples.obscured) as f64;
        let share = traced(&frames[4]) / samples(&frames[4]) as f64;
        assert!(share < 0.35, "{reuse:?}: {share}");
        let spare: Vec<u64> = frames.iter().map(|frame| frame.stats.samples.spare).collect();
        assert!(spare[0] == 0 && spare[2] > 0, "{reuse:?}: {spare:?}");
    }
}

#[test]
fn what_moves_is_refined_where_it_is() {
    let scene = with_flyer(world());
    let settings = adaptive(1, 2);
    let frames = audited(&scene, &settings);
    let full = toy::render(&scene, &Settings { mode: Mode::Full, ..settings }, FRAMES);
    for (inferred, full) in frames.iter().zip(&full) {
        // more samples than needed stay before a camera at rest; fewer must not be there
        assert!(samples(inferred) >= samples(full), "frame {}", full.stats.frame);
    }
}

#[test]
fn a_shot_file_says_the_fewest_the_most_and_the_threshold() {
    let settings = |samples: &str| {
        small_shot::load(&format!("[render]\nsamples = {samples}\n{}", small_shot::REST)).settings
    };
    assert_eq!((settings("3").samples, settings("3").refinement), (3, None));
    let adaptive = settings("{ min = 2, max = 8, threshold = 0.25 }");
    assert_eq!((adaptive.samples, adaptive.refinement), (2, Some(Refinement { most: 8, threshold: 0.25 })));
    let usual = settings("{ min = 1, max = 4 }").refinement.map(|refinement| refinement.threshold);
    assert_eq!(usual, Some(Refinement::THRESHOLD));
}

#[test]
fn bounds_that_make_no_levels_are_refused_with_their_place() {
    for (samples, words) in [
        ("{ min = 1, max = 3 }", "doubled once or more"),
        ("{ min = 4, max = 4 }", "doubled once or more"),
        ("{ min = 4, max = 1 }", "doubled once or more"),
        ("{ min = 0, max = 4 }", "doubled once or more"),
        ("{ min = -1, max = 4 }", "doubled once or more"),
        ("{ min = 1, max = 32 }", "16 at most"),
        ("{ min = 1, max = 4, threshold = 0 }", "above 0 and below 1"),
        ("{ min = 1, max = 4, threshold = 1.0 }", "above 0 and below 1"),
        ("{ min = 1, max = 4, threshold = nan }", "above 0 and below 1"),
        ("{ min = 1 }", "{ min = 1, max = 4 }"),
        ("{ min = 1, max = 4, most = 2 }", "{ min = 1, max = 4 }"),
        ("\"many\"", "{ min = 1, max = 4 }"),
        ("17", "from 1 to 16"),
    ] {
        let error = small_shot::error(&format!("[render]\nsamples = {samples}\n{}", small_shot::REST));
        assert!(error.starts_with("s.toml:2:") && error.contains(words), "{samples}: {error}");
    }
    let text = format!("[render]\nsamples = {{ min = 1, max = 4 }}\nfilter = \"tent\"\n{}", small_shot::REST);
    let error = small_shot::error(&text);
    assert!(error.starts_with("s.toml:2:") && error.contains("filter `box`"), "{error}");
}
