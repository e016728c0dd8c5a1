//! Are frames that are inferred backwards in time, from a base frame in the middle, what they must be, in whatever chunks?

use std::fs;

use afterimage::animation::{Track, TransformTrack};
use afterimage::exposure::Shutter;
use afterimage::frame::{Finished, Renderer};
use afterimage::layers::Layers;
use afterimage::scene::Scene;
use afterimage::settings::{BasePlace, Budget, Mode, Refinement, Settings};
use afterimage::stereo::Stereo;
use glam::{DVec3, Vec3};
use serde_json::Value;

use crate::runs;
use crate::runs::{Place, assert_same};
use crate::toy;
use crate::toy::worlds::*;

const MIDDLE: &str = "--base-every 5 --base-place middle --mode reproject --progress none";

const FIRST: &str = "--base-every 5 --mode reproject --progress none";

fn stats(place: &Place, name: &str) -> Value {
    serde_json::from_slice(&fs::read(place.path(name)).unwrap()).unwrap()
}

/// The frames of a run, in the order in which they came.
fn frames(stats: &Value) -> Vec<i64> {
    stats["frames"].as_array().unwrap().iter().map(|frame| frame["frame"].as_i64().unwrap()).collect()
}

#[track_caller]
fn assert_same_frames(place: &Place, folders: [&str; 2], last: i32) {
    for frame in 1..=last {
        let [one, other] = folders.map(|folder| place.path(&format!("{folder}/a.{frame:04}.exr")));
        assert_same(&one, &other);
    }
}

/// Mirrors, glass, gathered light with a budget, occlusion, motion, counts of rays.
#[test]
fn chunks_are_parts_of_the_whole() {
    for options in [
        "",
        "--paths 6 --paths-per-frame 2 --budget full --filter mitchell",
        "--reuse paper --depth 0",
        "--samples 1-4 --filter box",
        "--shutter -0.25,0.25 --exposures 3 --paths 2",
        "--stereo --separation 0.1",
        "--stereo --separation 0.1 --shutter 0,0.5 --exposures 2 --filter tent",
    ] {
        let options = format!("{MIDDLE} --layers all {options}");
        let place = Place::new();
        place.render(&format!("-o whole/a.####.exr --stats a.json {options}")).done();
        // 1 2 [3] 4 5 | 6 [7] 8
        let told = stats(&place, "a.json");
        let mut order = frames(&told);
        let eyes = order.iter().filter(|frame| **frame == 3).count();
        assert_eq!((eyes, order.len()), if options.contains("stereo") { (2, 16) } else { (1, 8) });
        order.dedup();
        assert_eq!(order, [3, 4, 5, 2, 1, 7, 8, 6]);
        let is_base = |frame: &&Value| frame["mode"] == "base" && frame["eye"] != "right";
        let bases = told["frames"].as_array().unwrap().iter().filter(is_base);
        assert_eq!(bases.map(|frame| frame["frame"].as_i64().unwrap()).collect::<Vec<_>>(), [3, 7]);
        for chunk in ["1", "2-4", "5-6", "7-8"] {
            place.render(&format!("-o chunks/a.####.exr --frames {chunk} {options}")).done();
        }
        assert_same_frames(&place, ["whole", "chunks"], 8);
    }
}

#[test]
fn an_interrupted_run_goes_on_to_the_same_frames() {
    let place = Place::new();
    place.render(&format!("-o whole/a.####.exr {MIDDLE}")).done();
    place.render(&format!("-o parts/a.####.exr {MIDDLE}")).done();
    for frame in [1, 5, 6] {
        fs::remove_file(place.path(&format!("parts/a.{frame:04}.exr"))).unwrap();
    }
    let ran = place.render(&format!("-o parts/a.####.exr --resume --stats a.json {MIDDLE}")).done();
    assert!(ran.stderr.contains("resume: 5 frames"), "{}", ran.stderr);
    assert_eq!(frames(&stats(&place, "a.json")), [5, 1, 6]);
    assert_same_frames(&place, ["whole", "parts"], 8);
    // with the base frame elsewhere, frames come about in another way
    let ran = place.render(&format!("-o parts/a.####.exr --resume {FIRST}")).done();
    assert!(
        ran.stderr.contains("rendering again") && ran.stderr.contains("other settings"),
        "{}",
        ran.stderr
    );
}

/// A frame of the same ancestry is the same wherever base frames are, unless what is asked again takes paths from others.
#[test]
fn frames_of_one_ancestry_are_kept_unless_paths_share_a_budget() {
    for blur in ["", "--shutter -0.25,0.25 --exposures 4"] {
        let options = |more: &str| {
            format!(
                "--frames 3-4 --mode reproject --progress none --paths 8 --paths-per-frame 1 {blur} {more}"
            )
        };
        let place = Place::new();
        let run = |folder: &str, more: &str| {
            place.render(&format!("-o {folder}/a.####.exr {}", options(more))).done().stderr
        };
        run("middle", "--base-every 5 --base-place middle");
        run("first", "--base-every 2");
        for frame in [3, 4] {
            let [one, other] =
                ["middle", "first"].map(|folder| place.path(&format!("{folder}/a.{frame:04}.exr")));
            assert_same(&one, &other);
        }
        assert!(run("middle", "--base-every 2 --resume").contains("2 frames are there"));
        run("middle", "--base-every 5 --base-place middle --budget full");
        let again = run("middle", "--base-every 2 --budget full --resume");
        assert!(again.contains("rendering again") && again.contains("other settings"), "{again}");
    }
}

#[test]
fn compare_measures_both_ways_of_all_frames() {
    let place = Place::new();
    let json = place.path("a.json");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_afterimage"));
    command
        .arg("compare")
        .arg(runs::analytic())
        .args(MIDDLE.split(' ').filter(|word| *word != "--mode" && *word != "reproject"));
    let ran = runs::Ran::new(command.args(["--audit", "--json"]).arg(&json).output().unwrap()).done();
    assert!(ran.stdout.contains("saved"), "{}", ran.stdout);
    let told = stats(&place, "a.json");
    let frames: Vec<_> =
        told["frames"].as_array().unwrap().iter().map(|frame| frame["frame"].as_i64().unwrap()).collect();
    assert_eq!(frames, [3, 4, 5, 2, 1, 7, 8, 6]);
}

/// A fly that passes, and little else that moves.
fn with_fly(mut scene: Scene) -> Scene {
    scene.models.truncate(2);
    let translate = goes(DVec3::new(-1.0, 0.4, 1.5), DVec3::new(1.0, 0.4, 1.5));
    let track = TransformTrack { translate, scale: rests(DVec3::splat(0.1)), ..TransformTrack::identity() };
    scene.models.push(toy::moving("fly", toy::octahedron(0, true), track));
    scene
}

/// What a later frame gathered says nothing of earlier ones; what an earlier one did, on the way back, holds for those before it.
#[test]
fn gathered_light_is_kept_on_the_way_back() {
    let at_rest = with_fly(world());
    let goes = with_camera(at_rest.clone(), goes(EYE, EYE + DVec3::X), rests(TARGET));
    for (name, scene) in [("at rest", at_rest), ("moving", goes)] {
        for budget in [Budget::None, Budget::Full] {
            let settings = Settings { paths: 8, bounces: 2, budget, paths_per_frame: 8, ..toy::audited(1) };
            let mut renderer = Renderer::new(&scene, &settings).unwrap();
            let mut gathered = Vec::new();
            for frame in [FRAMES, 5, 4, 3, 2, 1, 2, 3] {
                let stats = renderer.render(frame, true).unwrap().stats;
                assert_eq!(stats.audit.unwrap().wrong(), 0, "{name}, frame {frame}");
                gathered.push(stats.rays.gathering as f64);
            }
            let share = |at: usize| gathered[at] / gathered[0];
            assert!(share(1) > 0.5 && share(6) > 0.5, "{name}: it turns: {gathered:?}");
            if budget == Budget::None {
                assert!((2..=5).chain([7]).all(|at| share(at) < 0.2), "{name}: {gathered:?}");
            }
        }
    }
}

/// In a base frame in the middle what is gathered holds on both sides, so that nothing is gathered anew at the turn.
#[test]
fn what_a_base_frame_in_the_middle_gathers_serves_both_sides() {
    let at_rest = with_fly(world());
    let goes = with_camera(at_rest.clone(), goes(EYE, EYE + DVec3::X), rests(TARGET));
    let mut fading = goes.clone();
    fading.lights[1].power = toy::keys(&[(1.0, 9.0), (2.0, 8.0), (4.0, 8.0), (5.0, 9.0)]);
    for (name, scene) in [("at rest", at_rest), ("moving", goes), ("under a light that changes", fading)] {
        for budget in [Budget::None, Budget::Full] {
            let base_place = BasePlace::Middle;
            let paths = Settings { paths: 8, bounces: 2, budget, paths_per_frame: 4, ..toy::audited(1) };
            let settings = Settings { base_place, layers: Layers::ALL, ..paths };
            let mut renderer = Renderer::new(&scene, &settings).unwrap();
            let render = |renderer: &mut Renderer<'_>, frame| {
                let stats = renderer.render(frame, true).unwrap().stats;
                assert_eq!(stats.audit.unwrap().wrong(), 0, "{name}, frame {frame}");
                stats.rays.gathering as f64
            };
            let base = render(&mut renderer, 3);
            let kept = renderer.snapshot().unwrap();
            let later = [4, 5, 6].map(|frame| render(&mut renderer, frame));
            renderer.restore(kept);
            let earlier = [2, 1].map(|frame| render(&mut renderer, frame));
            if budget == Budget::None && !name.contains("light") {
                let shares: Vec<f64> = later.iter().chain(&earlier).map(|rays| rays / base).collect();
                assert!(shares.iter().all(|share| *share < 0.25), "{name}: {shares:?}");
            }
        }
    }
}

/// Half of the time, about each frame's own.
const HALF: Option<Shutter> = Some(Shutter::new(-0.25, 0.25));

/// The same where frames are exposed several times: an exposure's answers hold for exposures of frames on both sides.
#[test]
fn what_exposures_of_a_base_frame_gather_serves_both_sides() {
    let at_rest = with_fly(world());
    let goes = with_camera(at_rest.clone(), goes(EYE, EYE + DVec3::X), rests(TARGET));
    let mut fading = goes.clone();
    fading.lights[1].power = toy::keys(&[(1.0, 9.0), (2.0, 8.0), (4.0, 8.0), (5.0, 9.0)]);
    for (name, scene) in [("at rest", at_rest), ("moving", goes), ("under a light that changes", fading)] {
        let settings = Settings {
            base_place: BasePlace::Middle,
            paths: 8,
            bounces: 2,
            shutter: HALF,
            exposures: Some(4),
            occlusion_rays: 4,
            occlusion_radius: 1.0,
            layers: Layers::ALL,
            ..toy::audited(2)
        };
        let mut renderer = Renderer::new(&scene, &settings).unwrap();
        let render = |renderer: &mut Renderer<'_>, frame| {
            let stats = renderer.render(frame, true).unwrap().stats;
            assert_eq!(stats.audit.unwrap().wrong(), 0, "{name}, frame {frame}");
            stats.rays.gathering as f64
        };
        let base = render(&mut renderer, 3);
        let kept = renderer.snapshot().unwrap();
        let later = [4, 5, 6].map(|frame| render(&mut renderer, frame));
        renderer.restore(kept);
        let earlier = [2, 1].map(|frame| render(&mut renderer, frame));
        if !name.contains("light") {
            let shares: Vec<f64> = later.iter().chain(&earlier).map(|rays| rays / base).collect();
            assert!(shares.iter().all(|share| *share < 0.6), "{name}: {shares:?}");
        }
    }
}

/// A frame as all eyes see it.
fn seen(renderer: &mut Renderer<'_>, frame: i32) -> Vec<Finished> {
    let eyes = renderer.eyes().iter();
    eyes.map(|eye| renderer.render_eye(*eye, frame, true).unwrap()).collect()
}

/// Frames 3, 4, 5, and from a copy of 3's samples 2 and 1.
fn around_the_middle(scene: &Scene, settings: &Settings) -> Vec<Vec<Finished>> {
    let mut renderer = Renderer::new(scene, settings).unwrap();
    let mut frames = vec![seen(&mut renderer, 3)];
    let kept = renderer.snapshot().unwrap();
    frames.extend([4, 5].map(|frame| seen(&mut renderer, frame)));
    renderer.restore(kept);
    frames.extend([2, 1].map(|frame| seen(&mut renderer, frame)));
    frames
}

/// A sheet that waves above the floor.
fn with_sheet(mut scene: Scene) -> Scene {
    let wave = |phase: f32| move |at: Vec3| at + Vec3::Y * 0.3 * (2.2 * at.x + phase).sin();
    let track = TransformTrack { translate: rests(DVec3::new(-0.3, 2.0, 1.5)), ..TransformTrack::identity() };
    let (first, last) = (wave(0.0), wave(2.0));
    scene.models.push(toy::deforming(
        "sheet",
        toy::sheet(1.2, 10, 0, true),
        track,
        &[(1.0, &first), (6.0, &last)],
    ));
    scene
}

/// Of each kind of motion, and of two eyes: all exposures are exact on both sides of the base frame; pictures are those of frames
/// that are traced in full, but for where their samples are; as much is reused backwards as forwards; and neither threads
/// nor what was rendered in between change a bit.
#[test]
fn blurred_frames_are_as_exact_backwards_as_forwards() {
    let dolly = |scene| with_camera(scene, goes(EYE, EYE + DVec3::new(0.4, -0.2, -0.5)), rests(TARGET));
    let away = EYE + DVec3::new(0.3, 0.0, -0.2);
    let stops = toy::keys(&[(1.0, EYE), (1.75, EYE), (2.9, away), (20.0, away)]);
    let starts = toy::keys(&[(1.0, EYE), (3.1, EYE), (4.6, away), (20.0, away)]);
    let with_lens = |mut scene: Scene| {
        scene.camera.lens.aperture = Some(Track::constant(0.1));
        scene
    };
    let small = Settings { width: 64, height: 48, ..toy::audited(2) };
    let exposed = Settings { base_place: BasePlace::Middle, shutter: HALF, exposures: Some(4), ..small };
    let refinement = Some(Refinement { most: 4, threshold: 0.1 });
    let stereo = Some(Stereo { separation: 0.25, convergence: Some(6.0) });
    let worlds = [
        ("at rest", with_flyer(world()), exposed.clone()),
        ("dolly", dolly(with_flyer(world())), exposed.clone()),
        ("stops", with_camera(with_flyer(world()), stops, rests(TARGET)), exposed.clone()),
        ("starts", with_camera(with_flyer(world()), starts.clone(), rests(TARGET)), exposed.clone()),
        ("lights that move", dolly(with_area_lights(with_flyer(world()))), exposed.clone()),
        ("deforming", with_sheet(world()), exposed.clone()),
        ("deforming, dolly", dolly(with_sheet(world())), Settings { refinement, ..exposed.clone() }),
        ("lens", with_lens(dolly(with_flyer(world()))), Settings { shutter: None, ..exposed.clone() }),
        ("lens at rest", with_lens(with_flyer(world())), Settings { mode: Mode::Auto, ..exposed.clone() }),
        ("two eyes", dolly(with_flyer(world())), Settings { stereo, ..exposed.clone() }),
        ("sharp eyes", dolly(with_flyer(world())), Settings { stereo, shutter: None, ..exposed.clone() }),
        ("sharp eyes at rest", with_flyer(world()), Settings { stereo, shutter: None, ..exposed.clone() }),
        ("two eyes at rest", with_flyer(world()), Settings { stereo, ..exposed.clone() }),
        (
            "two eyes start",
            with_camera(with_sheet(world()), starts, rests(TARGET)),
            Settings { stereo, ..exposed },
        ),
    ];
    for (name, scene, settings) in worlds {
        let frames = around_the_middle(&scene, &settings);
        let reused: Vec<f64> = frames.iter().flatten().map(|of| checked(name, of)).collect();
        // of the frame beside the base frame on either side
        let eyes = frames[0].len();
        let [later, earlier] = [reused[eyes], reused[3 * eyes]];
        assert!(later > 0.6 && earlier > 0.6, "{name}: {reused:?}");
        let full = Settings { mode: Mode::Full, audit: false, ..settings.clone() };
        let mut full = Renderer::new(&scene, &full).unwrap();
        for of in &frames {
            for (finished, alone) in of.iter().zip(seen(&mut full, of[0].stats.frame)) {
                let apart = toy::mean_difference(finished, &alone, "G");
                assert!(apart < 0.01, "{name}, frame {}: {apart}", finished.stats.frame);
            }
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let straight = pool.install(|| {
            let settings = Settings { audit: false, ..settings };
            let mut renderer = Renderer::new(&scene, &settings).unwrap();
            seen(&mut renderer, 3);
            renderer.forget_film();
            [2, 1].map(|frame| seen(&mut renderer, frame))
        });
        for (one, other) in frames[3..].iter().flatten().zip(straight.iter().flatten()) {
            assert_same_film(name, one, other);
        }
    }
}

/// The share of samples that were reused in a frame that must be exact.
fn checked(name: &str, finished: &Finished) -> f64 {
    let (stats, audit) = (&finished.stats, finished.stats.audit.unwrap());
    assert_eq!((audit.differing, audit.checked), (0, stats.samples.total()), "{name}, frame {}", stats.frame);
    stats.samples.reused() as f64 / stats.samples.total() as f64
}

#[track_caller]
fn assert_same_film(name: &str, one: &Finished, other: &Finished) {
    assert_eq!(one.stats.rays, other.stats.rays, "{name}, frame {}", one.stats.frame);
    for plane in &one.film.planes {
        let [one_values, other_values] =
            [one, other].map(|finished| finished.film.values(&plane.name).unwrap());
        let differ = one_values.iter().zip(&other_values).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        assert_eq!(differ, 0, "{name}: {} of frame {}", plane.name, one.stats.frame);
    }
}

/// Looking back from the end of a motion that goes on for longer than answers can be counted, all have expired; none is lost.
#[test]
fn what_moves_for_days_is_exact_on_both_sides() {
    let mut scene = with_camera(with_fly(world()), goes(EYE, EYE + DVec3::X), rests(TARGET));
    let days = toy::keys(&[(1.0, DVec3::new(-1.0, 0.4, 1.5)), (2e5, DVec3::new(5e4, 0.4, 1.5))]);
    scene.models.last_mut().unwrap().track.translate = days;
    for budget in [Budget::None, Budget::Full] {
        let paths = Settings { paths: 8, bounces: 2, budget, paths_per_frame: 4, ..toy::audited(1) };
        let settings = Settings { base_place: BasePlace::Middle, occlusion_rays: 4, ..paths };
        let mut renderer = Renderer::new(&scene, &settings).unwrap();
        let mut render = |frame, kept: Option<_>| {
            kept.into_iter().for_each(|kept| renderer.restore(kept));
            let finished = renderer.render(frame, true).unwrap();
            assert_eq!(finished.stats.audit.unwrap().wrong(), 0, "frame {frame}");
            renderer.snapshot()
        };
        let base = render(3, None);
        [4, 5].into_iter().for_each(|frame| drop(render(frame, None)));
        render(2, base);
        render(1, None);
    }
}

/// The way that a frame is come to shows in its samples, and in nothing that a viewer would see.
#[test]
fn backwards_is_as_exact_as_forwards() {
    let camera = |scene| with_camera(scene, goes(EYE, EYE + DVec3::new(0.6, 0.2, -0.5)), rests(TARGET));
    let worlds = [
        ("a flyer", with_flyer(world())),
        ("a flyer and the camera", camera(with_flyer(world()))),
        ("lights that move", camera(with_area_lights(with_flyer(world())))),
    ];
    for (name, scene) in worlds {
        for samples in [1, 2] {
            let settings = Settings { occlusion_rays: 4, ..toy::audited(samples) };
            let mut renderer = Renderer::new(&scene, &settings).unwrap();
            renderer.render(FRAMES, false).unwrap();
            for frame in (1..FRAMES).rev() {
                let finished = renderer.render(frame, true).unwrap();
                let alone = Renderer::new(&scene, &settings).unwrap().render(frame, false).unwrap();
                assert_eq!(finished.stats.audit.unwrap().wrong(), 0, "{name}, frame {frame}");
                assert!(finished.stats.samples.reused() > finished.stats.samples.total() / 2);
                for plane in ["motion.X", "motion.Y", "motion.Z", "motion.W"] {
                    let apart = toy::mean_difference(&finished, &alone, plane);
                    assert!(apart < 0.05, "{name}, frame {frame}, {plane}: {apart}");
                }
            }
        }
    }
}

#[test]
fn a_copy_of_samples_is_gone_back_to() {
    let scene = with_flyer(world());
    let settings = Settings { paths: 4, bounces: 1, ..toy::settings(1) };
    let film = |renderer: &mut Renderer<'_>, frame| renderer.render(frame, true).unwrap().film;
    let mut renderer = Renderer::new(&scene, &settings).unwrap();
    assert!(renderer.snapshot().is_none());
    film(&mut renderer, 3);
    let kept = renderer.snapshot().unwrap();
    film(&mut renderer, 4);
    film(&mut renderer, 5);
    renderer.restore(kept);
    let after = [film(&mut renderer, 2), film(&mut renderer, 1)];
    let mut other = Renderer::new(&scene, &settings).unwrap();
    film(&mut other, 3);
    other.forget_film();
    // both keep their films: whoever does has a whole picture shown anew, and mirrors cast their rays for that
    let straight = [film(&mut other, 2), film(&mut other, 1)];
    for ((one, straight), frame) in after.iter().zip(&straight).zip([2, 1]) {
        for plane in &one.planes {
            let is_same = one.values(&plane.name) == straight.values(&plane.name);
            assert!(is_same, "{} of frame {frame}", plane.name);
        }
    }
}
