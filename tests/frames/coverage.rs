//! Does every cell show what its target sees: are small things, and thin ones close before others, as large and as bright in inferred frames as in
//! full ones?
//!
//! All light here is flat: a surface is as bright everywhere, and casts no shadow. So a picture's light says how many cells show which
//! surface, and may differ from that of a full frame by no more than the cells for which rounding decides what they show
//! ([`allowed`]).

use afterimage::animation::{Track, TransformTrack};
use afterimage::exposure::Shutter;
use afterimage::frame::{Finished, Renderer};
use afterimage::scene::{Background, Light, LightKind, Mesh, Scene};
use afterimage::settings::{Mode, Refinement, Settings};
use afterimage::stereo::Stereo;
use glam::{DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::rests;

/// Frames of a chain.
const LAST: i32 = 8;

/// Distance of the wall from the eye; it lies in the plane z = 0.
const DISTANCE: f64 = 6.0;

/// From a picture's top to its bottom, in cells of 2 x 2 samples.
const ROWS: u32 = 96;

/// Width of a cell on the wall.
fn cell() -> f32 {
    2.0 * DISTANCE as f32 * 30_f32.to_radians().tan() / ROWS as f32
}

fn settings() -> Settings {
    Settings { width: 64, height: ROWS / 2, ..toy::settings(2) }
}

fn eye() -> DVec3 {
    DVec3::new(0.1, 0.05, DISTANCE)
}

/// From one place in the first frame to the other in frame `last`, and there for ever.
fn goes(from: DVec3, to: DVec3, last: i32) -> Track<DVec3> {
    toy::keys(&[(1.0, from), (f64::from(last), to)])
}

/// The ways in which a camera may go: turning, sideways, forward.
fn ways() -> [(&'static str, [DVec3; 4]); 3] {
    let target = DVec3::ZERO;
    [
        ("turns", [eye(), eye(), target, DVec3::new(0.5, 0.1, 0.0)]),
        ("sideways", [eye(), eye() + DVec3::new(0.6, 0.1, 0.0), target, DVec3::new(0.6, 0.1, 0.0)]),
        ("forward", [eye(), eye() - DVec3::Z, target, target]),
    ]
}

/// Squares that look to +Z, `width` wide and strewn over the picture, in the plane z = `z`.
fn dots(count: usize, width: f32, z: f32) -> Mesh {
    let half = width / 2.0;
    let corners: Vec<[f32; 3]> = (0..count)
        .flat_map(|number| {
            // multiples of two irrational numbers: nowhere in a row, nowhere dense
            let [x, y] = [0.618_034, 0.754_878].map(|step| (number as f32 * step).fract() * 2.0 - 1.0);
            let [x, y] = [4.0 * x, 3.0 * y];
            [
                [x - half, y - half, z],
                [x + half, y - half, z],
                [x + half, y + half, z],
                [x - half, y + half, z],
            ]
        })
        .collect();
    let first = (0..count as u32).map(|number| 4 * number);
    let triangles: Vec<[u32; 3]> =
        first.flat_map(|at| [[at, at + 1, at + 2], [at, at + 2, at + 3]]).collect();
    toy::mesh(&corners, &triangles, 1, false)
}

/// A large wall in the plane z = 0 that looks to +Z.
fn wall() -> Mesh {
    let [x, y] = [30.0, 20.0];
    toy::mesh(&[[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]], &[[0, 1, 2], [0, 2, 3]], 0, false)
}

/// A black wall, and white dots before it, with nothing but light from everywhere.
fn dotted(track: TransformTrack, width: f32) -> Scene {
    let models = vec![
        toy::still("wall", wall(), Vec3::ZERO),
        toy::moving("dots", dots(300, width * cell(), 0.3), track),
    ];
    let camera = toy::camera(rests(eye()), rests(DVec3::ZERO));
    let mut scene = toy::scene(camera, models, vec![toy::matt(0.0), toy::matt(0.8)], vec![]);
    scene.ambient = Vec3::ONE;
    scene.background = Background::uniform(Vec3::ZERO);
    scene
}

fn with_way(mut scene: Scene, [eye, to, target, turned]: [DVec3; 4], last: i32) -> Scene {
    scene.camera = toy::camera(goes(eye, to, last), goes(target, turned, last));
    scene
}

/// Light of a picture: the sum of its red pixels.
fn light(finished: &Finished) -> f64 {
    let red = finished.film.values("R").unwrap();
    red.iter().map(|value| f64::from(*value)).sum()
}

/// How far the light of an inferred frame may be from that in full. Cells show the same surfaces, and of the same brightness, but where
/// rounding decides: each of these adds its share of a pixel at most, as often as there are pictures that make the frame. Pixels are
/// half floats: of both, half a step.
fn allowed(settings: &Settings, inferred: &Finished) -> f64 {
    let on_edge = inferred.stats.audit.unwrap().coverage_on_edge;
    let rounding = light(inferred) * f64::from(half::f16::EPSILON) + 1e-3;
    on_edge as f64 / f64::from(settings.samples.pow(2)) + rounding
}

/// Demands that all frames up to `last` show what their targets see, and that they are as bright as in full.
fn check(what: &str, scene: &Scene, settings: &Settings, last: i32) {
    let mut inferred = Renderer::new(scene, &Settings { audit: true, ..settings.clone() }).unwrap();
    let mut full = Renderer::new(scene, &Settings { mode: Mode::Full, ..settings.clone() }).unwrap();
    for frame in 1..=last {
        for eye in inferred.eyes() {
            let finished = inferred.render_eye(*eye, frame, true).unwrap();
            let audit = finished.stats.audit.unwrap();
            assert_eq!((audit.coverage, audit.wrong()), (0, 0), "{what}, frame {frame}, {eye:?}: {audit:?}");
            let in_full = full.render_eye(*eye, frame, false).unwrap();
            let [shown, right] = [&finished, &in_full].map(light);
            let allowed = allowed(settings, &finished);
            assert!(right > 10.0, "{what}, frame {frame}: something is to be seen: {right}");
            assert!(
                (shown - right).abs() <= allowed,
                "{what}, frame {frame}, {eye:?}: {shown} of {right}, {allowed}"
            );
        }
    }
}

#[test]
fn dots_smaller_than_a_cell_stay_wherever_the_camera_goes() {
    let scene = dotted(TransformTrack::identity(), 0.6);
    for (way, places) in ways() {
        let scene = with_way(scene.clone(), places, LAST);
        check(way, &scene, &settings(), LAST);
    }
}

/// What was lost while the camera moved would stay lost: samples in place are asked by nobody but for what moves.
#[test]
fn snow_falls_before_a_camera_that_comes_to_rest() {
    let falls = TransformTrack {
        translate: goes(DVec3::ZERO, DVec3::new(0.2, -1.4, 0.1), LAST + 2),
        ..TransformTrack::identity()
    };
    for width in [0.6, 1.2] {
        let [_, (_, sideways), _] = ways();
        let scene = with_way(dotted(falls.clone(), width), sideways, 4);
        check("snow", &scene, &settings(), LAST + 2);
    }
}

/// Upright slats `gap` before a wall, all of one mesh and one material. They lean towards the light, so that they are brighter.
fn slats(width: f32, gap: f32) -> Scene {
    const LEANING: f32 = 0.7;
    let wall = wall();
    let mut corners = wall.triangles().positions.as_slice().to_vec();
    let mut triangles = wall.triangles().corners.to_vec();
    let [across, along] = [LEANING.cos() * width / 2.0, LEANING.sin() * width / 2.0];
    for number in -40..40 {
        let (x, first) = ((number as f32 + 0.37) * 3.3 * width, corners.len() as u32);
        let [left, right] = [(x - across, gap - along), (x + across, gap + along)];
        for ((x, z), y) in [(left, -3.0), (right, -3.0), (right, 3.0), (left, 3.0)] {
            corners.push([x, y, z]);
        }
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let mesh = toy::mesh(&corners, &triangles, 0, false);
    let sun: Light =
        toy::light("sun", LightKind::Directional { direction: rests(DVec3::new(1.0, 0.0, -1.0)) }, 3.0);
    let camera = toy::camera(rests(eye()), rests(DVec3::ZERO));
    let mut scene =
        toy::scene(camera, vec![toy::still("slats", mesh, Vec3::ZERO)], vec![toy::matt(0.5)], vec![sun]);
    scene.background = Background::uniform(Vec3::ZERO);
    scene
}

#[test]
fn slats_stay_as_wide_before_a_wall_of_the_same_mesh() {
    let [_, (_, sideways), _] = ways();
    for width in [0.5, 1.0] {
        let scene = with_way(slats(width * cell(), 0.06), sideways, LAST);
        check("slats", &scene, &settings(), LAST);
    }
}

#[test]
fn the_right_eye_sees_dots_in_base_frames() {
    let scene = dotted(TransformTrack::identity(), 0.6);
    let stereo = Some(Stereo { separation: 0.25, convergence: Some(DISTANCE) });
    check("stereo", &scene, &Settings { stereo, ..settings() }, 2);
}

/// Every level of samples shows what is to be seen, so that pixels get the samples that they get in full.
#[test]
fn adaptive_samples_see_dots() {
    let [(_, turns), ..] = ways();
    let scene = with_way(dotted(TransformTrack::identity(), 1.2), turns, LAST);
    let refinement = Some(Refinement { most: 4, threshold: 0.1 });
    let settings = Settings { refinement, ..toy::settings(1) };
    check("adaptive", &scene, &Settings { width: 64, height: 48, ..settings }, LAST);
}

#[test]
fn every_exposure_sees_dots() {
    let [(_, turns), ..] = ways();
    let falls = TransformTrack {
        translate: goes(DVec3::ZERO, DVec3::new(0.2, -1.4, 0.1), LAST),
        ..TransformTrack::identity()
    };
    let scene = with_way(dotted(falls, 0.6), turns, LAST);
    let shutter = Some(Shutter::new(-0.25, 0.25));
    check("exposures", &scene, &Settings { shutter, exposures: Some(3), ..settings() }, 4);
}
