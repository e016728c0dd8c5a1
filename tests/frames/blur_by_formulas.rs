//! Motion blur and depth of field: do pictures show what formulas say?

use afterimage::animation::{Track, TransformTrack};
use afterimage::exposure::{Curve, Shutter, Strata};
use afterimage::scene::camera::{Aim, Lens};
use afterimage::scene::{Background, Material, Mesh, Scene};
use afterimage::settings::{Backdrop, Mode, Settings};
use glam::{DVec3, Vec3};

use crate::blur::settings;
use crate::toy;
use crate::toy::worlds::*;

/// A square of light, 2 wide, that moves to the right before nothing; seen side by side, ten pixels a unit.
fn square(track: Track<DVec3>) -> Scene {
    let shining = Material { emission: Vec3::ONE, ..toy::matt(0.0) };
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let mesh = toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], 0, true);
    let track = TransformTrack { translate: track, ..TransformTrack::identity() };
    let eye = DVec3::new(0.0, 0.0, 5.0);
    let mut scene = toy::scene(
        toy::camera(rests(eye), rests(DVec3::ZERO)),
        vec![toy::moving("square", mesh, track)],
        vec![shining],
        vec![],
    );
    scene.camera.lens = Lens { height: Some(Track::constant(7.2)), ..Lens::default() };
    scene.background = Background::uniform(Vec3::ZERO);
    scene
}

/// How far a shutter is open at times from 0 to 1.
type Openness = fn(f64) -> f64;

/// How much of the light of what is `wide` pixels wide and moves by `far` pixels to the right comes in where the left edge of a pixel
/// is at `x` from where its own begins: a box, moved evenly.
fn covered(x: f64, [wide, far]: [f64; 2], open: Openness) -> f64 {
    let steps = 4000;
    let at = |time: f64| {
        let (low, high) = (time * far, time * far + wide);
        (high.min(x + 1.0) - low.max(x)).max(0.0)
    };
    let times = || (0..steps).map(|step| (f64::from(step) + 0.5) / f64::from(steps));
    times().map(|time| at(time) * open(time)).sum::<f64>() / times().map(open).sum::<f64>()
}

#[test]
fn what_moves_evenly_leaves_a_ramp() {
    // 20 pixels a frame, of which the shutter sees half
    let scene = square(toy::keys(&[(0.0, DVec3::X * -5.0), (5.0, DVec3::X * 5.0)]));
    let curve = |points: &[[f64; 2]]| Curve::through(points.to_vec()).unwrap();
    let rising: (Curve, Openness) = (curve(&[[0.0, 0.0], [1.0, 1.0]]), |time| time);
    let late: (Curve, Openness) =
        (curve(&[[0.5, 0.25], [0.5, 1.0]]), |time| if time < 0.5 { 0.25 } else { 1.0 });
    let even: (Curve, Openness) = (Curve::CONSTANT, |_| 1.0);
    for (mode, samples, tolerance, (curve, open)) in [
        (Mode::Reproject, 4, 0.07, even.clone()),
        (Mode::Reproject, 8, 0.04, even.clone()),
        (Mode::Full, 8, 0.04, even),
        (Mode::Reproject, 8, 0.05, rising),
        (Mode::Reproject, 8, 0.05, late),
    ] {
        let settings = Settings {
            shutter: Some(Shutter { curve, ..Shutter::new(0.0, 0.5) }),
            exposures: Some(samples * samples),
            mode,
            background: Backdrop::Transparent,
            audit: true,
            ..settings(samples)
        };
        let frame = toy::render(&scene, &settings, 2).pop().unwrap();
        assert_eq!(toy::differing(&frame), 0);
        // at frame 2 the square reaches from -2 to 0, and the picture from -4.8 to 4.8
        let mut worst: f64 = 0.0;
        for x in 0..96 {
            let expected = covered(f64::from(x) - 28.0, [20.0, 10.0], open);
            for plane in ["A", "G"] {
                let shown = f64::from(toy::pixel(&frame, plane, x, 36));
                worst = worst.max((shown - expected).abs());
            }
            let id = toy::pixel(&frame, "CryptoObject00.G", x, 36);
            assert!((id - toy::pixel(&frame, "A", x, 36)).abs() < 2e-3, "mattes add up to alpha");
        }
        assert!(worst < tolerance, "{mode:?}, {samples}: {worst}");
        // motion vectors are those of the frame's own time, whenever samples were seen: pixel by pixel of the middle exposure
        for (plane, expected) in [("forward.U", 20.0), ("backward.U", -20.0)] {
            let pixels = toy::pixel(&frame, plane, 40, 36);
            assert!((pixels - expected).abs() < 1e-4, "{plane}: {pixels}");
        }
    }
}

/// Root mean square, over `wide + far` pixels, of how far a bar at `count` times is off one that moves evenly: see [`covered`].
fn staircase(count: u32, [wide, far]: [f64; 2]) -> f64 {
    let shares = |x: f64| {
        let low = |number: u32| (f64::from(number) + 0.5) / f64::from(count) * far;
        let covers = |low: f64| ((low + wide).min(x + 1.0) - low.max(x)).max(0.0);
        (0..count).map(|number| covers(low(number))).sum::<f64>() / f64::from(count)
    };
    let pixels = (wide + far) as i32;
    let off = |x: f64| shares(x) - covered(x, [wide, far], |_| 1.0);
    ((0..pixels).map(|x| off(f64::from(x)).powi(2)).sum::<f64>() / f64::from(pixels)).sqrt()
}

/// A bar that is blurred over 110 pixels leaves a ramp, a plateau and a ramp at any number of samples and exposures: whether it moves, its shape or
/// the camera does, no edge of an exposure is seen. Rows are averaged, over which samples' own times leave little noise; that of exposures
/// with one time each would stay.
#[test]
fn what_moves_far_leaves_no_rings() {
    // in units of 10 pixels: in frame 2 from the left of the middle to the right of it
    let far = 11.0;
    let moves = |way: f64, z: f64| {
        let at = |frame: f64| DVec3::new(way * far * (frame - 2.5), 0.0, z);
        toy::keys(&[(0.0, at(0.0)), (4.0, at(4.0))])
    };
    let still = square(rests(DVec3::ZERO));
    let scenes = [
        ("model", square(moves(1.0, 0.0))),
        ("shape", {
            let mut scene = still.clone();
            let mesh = Mesh::clone(&scene.models[0].mesh);
            let at = |frame: f32| move |place: Vec3| place + Vec3::X * far as f32 * (frame - 2.5);
            let shapes: [(f64, &dyn Fn(Vec3) -> Vec3); 2] = [(0.0, &at(0.0)), (4.0, &at(4.0))];
            scene.models = vec![toy::deforming("square", mesh, TransformTrack::identity(), &shapes)];
            scene
        }),
        ("camera", {
            let mut scene = still.clone();
            scene.camera.eye = moves(-1.0, 5.0).into();
            scene.camera.aim = Aim::Target { target: moves(-1.0, 0.0), roll: Track::constant(0.0) };
            scene
        }),
    ];
    for ((name, scene), (samples, exposures)) in
        scenes.iter().flat_map(|scene| [(2, 4), (3, 16), (4, 4), (4, 16)].map(|most| (scene, most)))
    {
        let settings = Settings {
            width: 240,
            height: 72,
            shutter: Some(Shutter::new(0.0, 1.0)),
            exposures: Some(exposures),
            background: Backdrop::Transparent,
            audit: true,
            ..settings(samples)
        };
        let frames = toy::render(scene, &settings, 2);
        for frame in &frames {
            assert_eq!(toy::differing(frame), 0);
        }
        let rows = 28..44;
        let mut squares = 0.0;
        for x in 0..240 {
            let expected = covered(f64::from(x) - 120.0 + 55.0 + 10.0, [20.0, 110.0], |_| 1.0);
            let row = |y: u32| f64::from(toy::pixel(&frames[1], "A", x, y));
            let shown = rows.clone().map(row).sum::<f64>() / rows.len() as f64;
            squares += (shown - expected).powi(2);
        }
        let off = (squares / 130.0).sqrt();
        // as far off as so many bars side by side would be
        let across = Strata::new(samples, exposures).across;
        let count = across * across;
        let steps = staircase(count, [20.0, 110.0]);
        println!(
            "{name}, {samples}x{samples} samples, {count} exposures: {off:.4}, of one time each {steps:.4}"
        );
        assert!(off < 0.5 * steps && off < 0.02, "{name}, {samples}, {exposures}: {off} {steps}");
    }
}

/// A white square of edge `size` at `distance` before a lens of radius 0.3 that is focused at 4, before nothing.
fn before_a_lens(size: f32, distance: f64) -> Scene {
    let mut scene = square(rests(DVec3::ZERO));
    let (half, z) = (size / 2.0, -distance as f32);
    let corners = [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
    let mesh = toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], 0, true);
    scene.models = vec![toy::still("square", mesh, Vec3::ZERO)];
    scene.camera = toy::camera(rests(DVec3::ZERO), rests(DVec3::Z * -1.0));
    scene.camera.lens =
        Lens { aperture: Some(Track::constant(0.3)), focus: Some(Track::constant(4.0)), ..Lens::default() };
    scene
}

/// Pixels for a length of 1 at distance 1.
fn pixels_per_unit() -> f64 {
    36.0 / 30.0_f64.to_radians().tan()
}

/// With as many exposures as samples.
fn alpha(scene: &Scene, samples: u32) -> Vec<f32> {
    let settings = Settings {
        shutter: None,
        exposures: Some(samples * samples),
        background: Backdrop::Transparent,
        mode: Mode::Reproject,
        audit: true,
        ..settings(samples)
    };
    let frame = toy::render(scene, &settings, 1).pop().unwrap();
    assert_eq!(toy::differing(&frame), 0);
    frame.film.values("A").unwrap()
}

#[test]
fn what_is_in_focus_is_sharp() {
    let shown = alpha(&before_a_lens(1.5, 4.0), 6);
    let edge = 0.75 / 4.0 * pixels_per_unit();
    for (number, shown) in shown.iter().enumerate() {
        let (x, y) = (number % 96, number / 96);
        let share = |at: usize, middle: f64| {
            let (low, high) = (at as f64 - middle, at as f64 + 1.0 - middle);
            (high.min(edge) - low.max(-edge)).clamp(0.0, 1.0)
        };
        let expected = share(x, 48.0) * share(y, 36.0);
        assert!((f64::from(*shown) - expected).abs() < 0.08, "{x} {y}: {shown} {expected}");
    }
}

#[test]
fn what_is_out_of_focus_is_a_disc_of_the_thin_lens() {
    for distance in [2.0, 2.5, 8.0, 40.0] {
        let size = 0.05 * distance as f32;
        let shown = alpha(&before_a_lens(size, distance), 12);
        // on the plane in focus, through the point: see the thin lens formula
        let radius = 0.3 * (1.0 - 4.0 / distance).abs() / 4.0 * pixels_per_unit();
        let half = 0.025 * pixels_per_unit();
        let (mut sum, mut squares, mut reach) = (0.0, 0.0, 0.0_f64);
        for (number, shown) in shown.iter().enumerate().filter(|(_, shown)| **shown > 0.0) {
            let [x, y] = [number % 96, number / 96].map(|at| at as f64 + 0.5);
            let squared = (x - 48.0).powi(2) + (y - 36.0).powi(2);
            sum += f64::from(*shown);
            squares += f64::from(*shown) * squared;
            reach = reach.max(squared.sqrt());
        }
        let area = 4.0 * half * half;
        assert!((sum / area - 1.0).abs() < 0.03, "{distance}: {sum} {area}: nothing is lost");
        // a disc's mean squared distance from its middle is half of its squared radius; the square's and the pixel's come on top
        let expected = radius * radius / 2.0 + 2.0 * half * half / 3.0 + 1.0 / 6.0;
        let spread = squares / sum;
        assert!((spread / expected - 1.0).abs() < 0.04, "{distance}: {spread} {expected}");
        assert!(reach < radius + (2.0_f64).sqrt() * (half + 1.0), "{distance}: {reach} {radius}");
    }
}

/// Every pixel has a sample of every exposure: a thing that comes and goes in an instant shows in its share of the pixels.
#[test]
fn every_pixel_sees_every_time() {
    // a wall that stands before the camera in one of nine parts of the shutter only
    let away = DVec3::Y * 50.0;
    let near = DVec3::ZERO;
    for part in 0..9 {
        let (begin, end) = (3.0 + f64::from(part) / 9.0 - 0.5, 3.0 + f64::from(part + 1) / 9.0 - 0.5);
        let jump = 1e-3;
        let track =
            toy::keys(&[(begin - jump, away), (begin + jump, near), (end - jump, near), (end + jump, away)]);
        let mut scene = square(track);
        scene.camera.lens.height = Some(Track::constant(1.0));
        let settings = Settings {
            shutter: Some(Shutter::new(-0.5, 0.5)),
            exposures: Some(9),
            background: Backdrop::Transparent,
            ..settings(3)
        };
        let frame = toy::render(&scene, &settings, 3).pop().unwrap();
        let alpha = frame.film.values("A").unwrap();
        assert!(alpha.iter().all(|alpha| (alpha - 1.0 / 9.0).abs() < 1e-4), "{part}");
    }
}
