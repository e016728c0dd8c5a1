//! Curves that deform: do they look as they must, sharp and blurred, and is reuse exact on them?

use afterimage::animation::TransformTrack;
use afterimage::exposure::Shutter;
use afterimage::frame::Renderer;
use afterimage::geometry::{Curved, Curves};
use afterimage::scene::{Mesh, Scene};
use afterimage::settings::{Mode, Settings};
use afterimage::trace::BackendKind;
use glam::{DVec3, Vec3};

use crate::changing::{CHANGES, expect_nothing_found};
use crate::curves::hair;
use crate::toy;
use crate::toy::worlds::*;

const HALF: Option<Shutter> = Some(Shutter::new(-0.25, 0.25));

/// Points of a tuft that leans by this much, whose hairs have these radii at their roots and tips.
fn leaning(lean: f32, [root, tip]: [f32; 2]) -> Vec<[f32; 4]> {
    toy::tuft_points(|turn, up| {
        let away = 0.2 + 0.5 * up * up;
        let aside = lean * up * up * 1.5;
        let high = 2.0 * up * (1.0 - 0.15 * lean.abs());
        [away * turn.cos() + aside, high, away * turn.sin() - 0.4 * aside, root + (tip - root) * up]
    })
}

/// Points of a tuft that has not grown: all hairs are points, and without a thickness.
fn seeds() -> Vec<[f32; 4]> {
    toy::tuft_points(|turn, _| [0.2 * turn.cos(), 0.0, 0.2 * turn.sin(), 0.0])
}

/// The world with hairs that wave, cords that swell, and hairs that grow out of nothing while they fly.
fn waving() -> Scene {
    let mut scene = world();
    scene.materials.push(hair(Vec3::new(0.7, 0.4, 0.2), 0.3));
    let number = scene.materials.len() as u16 - 1;
    let at = |x: f64, z: f64| TransformTrack {
        translate: rests(DVec3::new(x, 0.0, z)),
        ..TransformTrack::identity()
    };
    let thin = [0.03, 0.0];
    let waves = [(1.0, leaning(0.0, thin)), (2.5, leaning(0.6, thin)), (4.0, leaning(-0.3, thin))];
    scene.models.push(toy::deforming_curves("waves", number, at(-0.5, 1.8), &waves));
    let cords = [(1.0, leaning(0.2, [0.16, 0.05])), (3.0, leaning(0.2, [0.05, 0.14]))];
    scene.models.push(toy::deforming_curves("cords", 0, at(1.5, 2.0), &cords));
    let track = TransformTrack {
        translate: goes(DVec3::new(-1.5, 1.2, 2.0), DVec3::new(0.5, 1.5, 2.5)),
        rotate: goes(DVec3::ZERO, DVec3::new(20.0, 60.0, 0.0)),
        scale: rests(DVec3::new(0.5, 0.7, 0.4)),
        ..TransformTrack::identity()
    };
    let grows = [(1.0, seeds()), (5.0, leaning(0.3, thin))];
    scene.models.push(toy::deforming_curves("grows", number, track, &grows));
    scene
}

#[test]
fn an_audit_finds_nothing() {
    let settings = Settings { paths: 2, reflections: 2, depth: 3, ..toy::settings(1) };
    expect_nothing_found(&waving(), &CHANGES, &settings);
}

#[test]
fn an_audit_finds_nothing_behind_a_shutter_by_either_tracer() {
    let scene = CHANGES[1].iter().fold(waving(), |scene, change| change(scene));
    let settings = Settings {
        paths: 1,
        reflections: 1,
        audit: true,
        width: 64,
        height: 48,
        shutter: HALF,
        exposures: Some(2),
        ..toy::settings(2)
    };
    let mut pictures = Vec::new();
    for kind in [BackendKind::Embree, BackendKind::Rust] {
        let mut renderer = Renderer::with(kind, &scene, &settings).unwrap();
        for frame in 1..=3 {
            let finished = renderer.render(frame, true).unwrap();
            assert_eq!(toy::differing(&finished), 0, "{kind:?}, frame {frame}");
            pictures.push(finished);
        }
    }
    let (embree, rust) = pictures.split_at(3);
    for (one, other) in embree.iter().zip(rust) {
        for (plane, most) in [("Z", OF_ROUNDING), ("R", OF_SEEDS)] {
            let apart = toy::mean_difference(one, other, plane);
            assert!(apart < most, "frame {}, {plane}: {apart}", one.stats.frame);
        }
    }
}

/// How far tracers may be apart where they see the same: the depth, and light, by rounding.
const OF_ROUNDING: f32 = 2e-5;

/// How far they may be apart beyond mirrors and glass. What is met there takes its random numbers from its place, to the bit, and the two round that in other
/// ways: paths from there differ, and their mean does not. Some 3 % of these pixels are concerned.
const OF_SEEDS: f32 = 1e-2;

/// Without mirrors, in which random numbers follow from places, light is the same by either tracer, from fibre to fibre as well.
#[test]
fn light_of_paths_is_the_same_by_either_tracer() {
    let scene = CHANGES[1].iter().fold(waving(), |scene, change| change(scene));
    for depth in [0, 4] {
        let settings = Settings {
            paths: 4,
            bounces: 4,
            reflections: 2,
            depth,
            width: 64,
            height: 48,
            ..toy::settings(2)
        };
        let [one, other] = [BackendKind::Embree, BackendKind::Rust].map(|kind| {
            let mut renderer = Renderer::with(kind, &scene, &settings).unwrap();
            renderer.render(1, true).unwrap()
        });
        let apart = toy::mean_difference(&one, &other, "R");
        let most = if depth == 0 { OF_ROUNDING } else { OF_SEEDS };
        assert!(apart < most, "depth {depth}: {apart}");
    }
}

/// Hairs whose points all go the same way look as ones that are moved, sharp and blurred, matt and with light that goes through them.
#[test]
fn hairs_that_go_aside_look_as_ones_that_are_moved() {
    let [from, to] = [Vec3::new(-0.5, 0.2, 1.8), Vec3::new(0.7, 0.6, 2.0)];
    let points = |by: Vec3| -> Vec<[f32; 4]> {
        let there = |[x, y, z, radius]: [f32; 4]| (Vec3::new(x, y, z) + by).extend(radius).to_array();
        leaning(0.2, [0.1, 0.03]).into_iter().map(there).collect()
    };
    let shapes = [(1.0, points(from)), (f64::from(FRAMES), points(to))];
    let curves = Curves::new(&points(Vec3::ZERO), &[9; 7], &[]).unwrap().0;
    let track =
        TransformTrack { translate: goes(from.as_dvec3(), to.as_dvec3()), ..TransformTrack::identity() };
    let mut world = world();
    world.materials.push(hair(Vec3::new(0.7, 0.4, 0.2), 0.3));
    for material in [0, world.materials.len() as u16 - 1] {
        let [mut deforming, mut moved] = [world.clone(), world.clone()];
        deforming.models.push(toy::deforming_curves("hairs", material, TransformTrack::identity(), &shapes));
        let mesh = Mesh::of_curved(curves.clone(), material, true);
        moved.models.push(toy::moving("hairs", mesh, track.clone()));
        for shutter in [None, HALF] {
            let settings = Settings { shutter: shutter.clone(), mode: Mode::Full, ..toy::settings(2) };
            let [one, other] = [&deforming, &moved].map(|scene| toy::render(scene, &settings, 3));
            for (one, other) in one.iter().zip(&other) {
                for plane in ["R", "G", "B"] {
                    let apart = toy::mean_difference(one, other, plane);
                    assert!(
                        apart < 2e-3,
                        "{material}, {shutter:?}, frame {}, {plane}: {apart}",
                        other.stats.frame
                    );
                }
            }
            // what goes from frame 1 to frame 3 is seen to go
            let goes = toy::mean_difference(&one[0], &one[2], "R");
            assert!(goes > 5e-3, "{goes}");
        }
    }
}

/// Frames of a camera that goes by hairs that wave keep most of what they have of these.
#[test]
fn samples_go_along_with_hairs() {
    let scene = with_camera(waving(), goes(EYE, EYE + DVec3::new(0.1, 0.0, -0.1)), rests(TARGET));
    let frames = toy::render(&scene, &Settings { audit: true, ..toy::settings(2) }, 3);
    let samples = frames[2].stats.samples;
    let kept = (samples.good + samples.overlapped) as f64 / f64::from(96 * 72 * 4);
    assert!(kept > 0.8, "{kept}");
    assert_eq!(toy::differing(&frames[2]), 0);
}

/// A place that is kept is a place of its own in every shape: weights come back from the curves at rest, whatever these were in the first shape.
#[test]
fn places_outlast_shapes_without_a_length_and_without_a_thickness() {
    let shapes = [seeds(), leaning(0.3, [0.03, 0.01]), leaning(-0.3, [0.2, 0.0])];
    let (curves, _) = Curves::deforming(&shapes, &[9; 7], &[]).unwrap();
    assert_eq!((curves.shapes(), curves.count()), (3, 56));
    for primitive in 0..curves.count() {
        for weights in [[-0.4, 0.3], [0.1, -1.2], [0.5, 1.9], [0.9, 0.0], [1.5, -0.7]] {
            let kept = curves.point(primitive, weights);
            let [along, around] = curves.weights(primitive, kept);
            assert!((along - weights[0]).abs() < 2e-3 && (around - weights[1]).abs() < 2e-3, "{weights:?}");
        }
    }
}
