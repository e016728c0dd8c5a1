//! Orthographic cameras and shifted lenses: do they draw what they must, and is reuse exact before them?

use afterimage::animation::Track;
use afterimage::frame::{Finished, Renderer, Spoil};
use afterimage::layers::Layers;
use afterimage::scene::Scene;
use afterimage::scene::camera::Lens;
use afterimage::settings::{Filter, Mode, PixelRect, Reuse, Settings};
use glam::{DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::*;

/// Sees so much from top to bottom, world units.
fn orthographic(mut scene: Scene, height: Track<f64>) -> Scene {
    scene.camera.lens.height = Some(height);
    scene
}

fn shifted(mut scene: Scene, shift: [Track<f64>; 2]) -> Scene {
    scene.camera.lens.shift = shift;
    scene
}

fn full(scene: &Scene, settings: &Settings, frame: i32) -> Finished {
    let settings = Settings { mode: Mode::Full, audit: true, ..settings.clone() };
    let mut renderer = Renderer::new(scene, &settings).expect("the scene builds");
    let finished = renderer.render(frame, false).expect("the frame renders");
    let audit = finished.stats.audit.expect("asked for");
    assert_eq!(audit.wrong(), 0, "{audit:?}");
    finished
}

/// Squares of edge 2 that face +Z, at these places.
fn squares(places: &[Vec3]) -> Scene {
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let square = |at: &Vec3| toy::still("square", toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], 0, true), *at);
    let models = places.iter().map(square).collect();
    let eye = DVec3::new(0.0, 0.0, 5.0);
    let camera = toy::camera(rests(eye), rests(DVec3::ZERO));
    toy::scene(camera, models, vec![toy::matt(0.5)], vec![toy::sun_overhead(1.0)])
}

#[test]
fn an_orthographic_picture_has_the_size_of_things_whatever_their_distance() {
    // a pixel is a tenth of a unit
    let scene = orthographic(
        squares(&[Vec3::new(-2.0, 0.5, 0.0), Vec3::new(2.0, 0.5, -700.0)]),
        Track::constant(7.2),
    );
    for samples in [1, 2] {
        let frame = full(&scene, &toy::settings(samples), 1);
        for (y, x) in (0..72).flat_map(|y| (0..96).map(move |x| (y, x))) {
            let rows = 21..41;
            let (id, z) = match (rows.contains(&y), x) {
                (true, 18..38) => (1.0, 5.0),
                (true, 58..78) => (2.0, 705.0),
                _ => (0.0, 1e10),
            };
            assert_eq!(toy::pixel(&frame, "object.V", x, y), id, "{x} {y}");
            let depth = toy::pixel(&frame, "Z", x, y);
            assert!((depth - z).abs() <= 1e-5 * z, "{x} {y}: {depth}");
            assert_eq!(
                toy::pixel(&frame, "A", x, y),
                if id > 0.0 { 1.0 } else { toy::pixel(&frame, "A", 0, 0) }
            );
        }
        // where the first pixel's centre is
        let place = [toy::pixel(&frame, "P.X", 18, 21), toy::pixel(&frame, "P.Y", 18, 21)];
        if samples == 1 {
            assert!((place[0] + 2.95).abs() < 1e-5 && (place[1] - 1.45).abs() < 1e-5, "{place:?}");
        }
    }
}

#[test]
fn what_is_behind_an_orthographic_camera_is_not_seen() {
    let scene = orthographic(squares(&[Vec3::new(0.0, 0.0, 6.0)]), Track::constant(7.2));
    let frame = full(&scene, &toy::settings(1), 1);
    assert!(frame.film.values("object.V").expect("asked for").iter().all(|id| *id == 0.0));
    // all of the background is seen in one direction
    let background = frame.film.values("background.B").expect("asked for");
    assert!(background.iter().all(|blue| *blue == background[0]) && background[0] > 0.0);
}

#[test]
fn a_shift_is_a_crop_beside_the_picture() {
    // 24 pixels to the right and 12 upwards, of a longer side of 96
    let crop = PixelRect { x: 24, y: -12, width: 96, height: 72 };
    let straight = with_flyer(world());
    for scene in [straight.clone(), orthographic(straight, Track::constant(5.0))] {
        let settings = toy::settings(1);
        let shift = shifted(scene.clone(), [0.25, 0.125].map(Track::constant));
        let (shifted, beside) = (
            full(&shift, &settings, 2),
            full(&scene, &Settings { overscan: 24, crop: Some(crop), ..settings }, 2),
        );
        for (plane, tolerance) in [("object.V", 0.0), ("Z", 1e-4), ("P.X", 1e-3), ("N.Y", 1e-2)] {
            let [one, other] = [&shifted, &beside].map(|frame| frame.film.values(plane).expect("asked for"));
            let off = one
                .iter()
                .zip(&other)
                .filter(|(a, b)| (**a - **b).abs() > tolerance * b.abs().max(1.0))
                .count();
            assert!(off * 500 < one.len(), "{plane}: {off} of {}", one.len());
            assert!(one.iter().any(|value| *value != one[0]), "{plane}: or nothing is compared");
        }
    }
}

/// Renders all frames, demands an audit without a difference, and gives the share of samples that were reused in the inferred
/// ones.
fn audited(scene: &Scene, settings: &Settings) -> f64 {
    let frames = toy::render(scene, &Settings { audit: true, ..settings.clone() }, FRAMES);
    let (mut reused, mut all) = (0, 0);
    for frame in &frames {
        let (audit, samples) = (frame.stats.audit.expect("asked for"), frame.stats.samples);
        assert_eq!(audit.wrong(), 0, "frame {}: {audit:?}", frame.stats.frame);
        assert!(audit.on_edge * 200 < audit.checked, "frame {}: {audit:?}", frame.stats.frame);
        reused += samples.good + samples.overlapped;
        all += audit.checked;
    }
    // coverage is that of a frame traced in full
    let last = frames.last().expect("there are some");
    if settings.reuse == Reuse::Target {
        let [ids, wanted] = [last, &full(scene, settings, FRAMES)]
            .map(|frame| frame.film.values("object.V").expect("asked for"));
        let off = ids.iter().zip(&wanted).filter(|(a, b)| a != b).count();
        assert!(off * 40 < ids.len(), "{off} of {}", ids.len());
    }
    reused as f64 / (all * (FRAMES as u64 - 1) / FRAMES as u64) as f64
}

/// Each way of moving an orthographic camera, with how much of the samples is reused at least.
fn moves() -> Vec<(&'static str, Scene, f64)> {
    let (pan, dolly) = (EYE + DVec3::new(0.7, 0.2, 0.1), EYE + (TARGET - EYE) * 0.3);
    let constant = || Track::constant(6.0);
    let seen = |eye, target| orthographic(with_camera(world(), eye, target), constant());
    let mut rolls = seen(rests(EYE), rests(TARGET));
    rolls.camera.aim = afterimage::scene::camera::Aim::Target {
        target: rests(TARGET),
        roll: toy::keys(&[(1.0, 0.0), (6.0, 12.0)]),
    };
    vec![
        ("rests", seen(rests(EYE), rests(TARGET)), 1.0),
        ("pans", seen(goes(EYE, pan), goes(TARGET, TARGET + (pan - EYE))), 0.7),
        ("goes near", seen(goes(EYE, dolly), rests(TARGET)), 0.7),
        ("goes around", seen(goes(EYE, EYE + DVec3::X), rests(TARGET)), 0.6),
        ("turns", seen(rests(EYE), goes(TARGET, TARGET + DVec3::new(0.5, 0.2, 0.0))), 0.6),
        ("rolls", rolls, 0.6),
        ("zooms", orthographic(world(), toy::keys(&[(1.0, 6.0), (6.0, 5.0)])), 0.6),
        (
            "shifts",
            shifted(
                seen(rests(EYE), rests(TARGET)),
                [toy::keys(&[(1.0, 0.0), (6.0, 0.1)]), Track::constant(0.1)],
            ),
            0.6,
        ),
    ]
}

#[test]
fn orthographic_cameras_are_exact() {
    for (name, scene, least) in moves() {
        let share = audited(&scene, &toy::settings(2));
        assert!(share >= least, "{name}: {share}");
    }
}

#[test]
fn orthographic_cameras_are_exact_while_everything_moves() {
    for (name, scene, _) in moves() {
        let scene = with_area_lights(with_flyer(scene));
        let share = audited(&scene, &Settings { paths: 2, occlusion_rays: 4, ..toy::settings(1) });
        assert!(share > 0.4, "{name}: {share}");
    }
}

#[test]
fn an_orthographic_camera_looks_along_the_horizon() {
    // half of the picture is background, and a flyer crosses it
    let camera = [DVec3::new(0.0, 1.0, 9.0), DVec3::new(0.0, 1.0, 0.0)];
    let rest = orthographic(with_camera(world(), rests(camera[0]), rests(camera[1])), Track::constant(6.0));
    for filter in [Filter::Box, Filter::Mitchell] {
        let settings = Settings { filter, ..toy::settings(1) };
        let share = audited(&with_flyer(rest.clone()), &settings);
        // in whole tiles that the flyer may cross the background is traced
        assert!(share > 0.4, "{share}");
        let moving = with_camera(world(), goes(camera[0], camera[0] + DVec3::X * 0.5), rests(camera[1]));
        audited(&orthographic(with_flyer(moving), Track::constant(6.0)), &settings);
    }
}

#[test]
fn the_papers_rule_is_exact_before_an_orthographic_camera() {
    for (name, scene, _) in moves().into_iter().take(4) {
        let share = audited(&with_flyer(scene), &Settings { reuse: Reuse::Paper, ..toy::settings(1) });
        assert!(share > 0.3, "{name}: {share}");
    }
}

#[test]
fn a_shifted_lens_is_exact() {
    let scene = with_camera(world(), goes(EYE, EYE + DVec3::new(1.0, 0.2, -1.5)), rests(TARGET));
    let still = shifted(with_flyer(scene), [0.3, -0.2].map(Track::constant));
    assert!(audited(&still, &toy::settings(2)) > 0.6);
    let rise = [Track::constant(0.0), toy::keys(&[(1.0, -0.1), (6.0, 0.1)])];
    let turning = shifted(world(), rise);
    let frames = toy::render(&turning, &toy::settings(2), FRAMES);
    assert!(frames[1..].iter().all(|frame| frame.stats.rays.verification == 0), "nothing can hide");
    assert!(audited(&turning, &toy::settings(2)) > 0.7);
}

#[test]
fn threads_and_auto_mode_change_nothing() {
    let scene = with_flyer(moves().swap_remove(3).1);
    for mode in [Mode::Auto, Mode::Reproject] {
        let films = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
            let settings = Settings { mode, ..toy::audited(1) };
            let frames = pool.install(|| toy::render(&scene, &settings, FRAMES));
            assert!(frames.iter().all(|frame| toy::differing(frame) == 0));
            frames.into_iter().map(|frame| (*frame.film).clone()).collect::<Vec<_>>()
        });
        assert!(films[0] == films[1]);
    }
}

#[test]
fn the_audit_sees_what_an_orthographic_camera_does_not() {
    let scene = orthographic(world(), Track::constant(6.0));
    for what in [Spoil::Place, Spoil::Sight] {
        let settings = toy::audited(1);
        let mut renderer = Renderer::new(&scene, &settings).expect("the scene builds");
        renderer.render(1, true).expect("the frame renders");
        let spoilt = renderer.spoil(what).expect("it can be");
        let audit = renderer.render(2, true).expect("the frame renders").stats.audit.expect("asked for");
        assert!(spoilt > 100 && audit.differing + audit.on_edge > spoilt / 2, "{what:?}: {spoilt} {audit:?}");
    }
}

#[test]
fn motion_before_an_orthographic_camera_is_that_of_the_plane() {
    // a pixel is a tenth of a unit; three pixels a frame to the right, and one upwards
    let mut scene = squares(&[Vec3::new(0.0, 0.0, 0.0), Vec3::new(1.0, 0.0, -300.0)]);
    let (eye, step) = (DVec3::new(0.0, 0.0, 5.0), DVec3::new(0.3, 0.1, 0.0));
    let keys = |at: DVec3| toy::keys(&[(1.0, at), (6.0, at + step * 5.0)]);
    scene.camera = toy::camera(keys(eye), keys(DVec3::ZERO));
    scene.camera.lens = Lens { height: Some(Track::constant(7.2)), ..Lens::default() };
    let settings = Settings { layers: Layers::ALL, ..toy::settings(1) };
    let frame = full(&scene, &settings, 3);
    let mut seen = 0;
    for (y, x) in (0..72).flat_map(|y| (0..96).map(move |x| (y, x))) {
        let surface = toy::pixel(&frame, "object.V", x, y) > 0.0;
        let wanted = if surface { [-3.0, -1.0] } else { [0.0; 2] };
        let forward = ["forward.U", "forward.V"].map(|plane| toy::pixel(&frame, plane, x, y));
        assert!((0..2).all(|axis| (forward[axis] - wanted[axis]).abs() < 1e-3), "{x} {y}: {forward:?}");
        seen += usize::from(surface);
    }
    assert!(seen > 400);
}
