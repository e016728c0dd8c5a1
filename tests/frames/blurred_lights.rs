//! Lights that change while the shutter is open: does each sample see them as they are at its own moment?

use afterimage::animation::Track;
use afterimage::exposure::Shutter;
use afterimage::scene::{LightKind, Panel, Scene, SpotFall};
use afterimage::settings::{Mode, Settings};
use glam::{DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::*;

/// Last frame of [`between`].
const LAST: i32 = 4;

/// The shutter is open for half of each frame, about its own time.
fn blurred(samples: u32, exposures: u32) -> Settings {
    let shutter = Some(Shutter::new(-0.25, 0.25));
    Settings { shutter, exposures: Some(exposures), audit: true, ..toy::settings(samples) }
}

/// From one value to another over the shot.
fn between<T: afterimage::animation::Keyed>(from: T, to: T) -> Track<T> {
    toy::keys(&[(1.0, from), (f64::from(LAST), to)])
}

/// A world under lights all of which change: their places, directions, sizes, cones, colours and power.
fn under_changing_lights(points: u32) -> Scene {
    let mut scene = with_flyer(world());
    let at = |x, y, z| DVec3::new(x, y, z);
    let lamp = LightKind::Point { position: between(at(2.0, 4.0, 3.0), at(0.0, 4.5, 3.0)) };
    let spot = LightKind::Spot {
        position: between(at(-3.0, 4.0, 2.0), at(-2.0, 4.0, 2.0)),
        target: between(at(-2.0, 0.0, 0.0), at(1.0, 0.0, 0.0)),
        cone: between(30.0, 60.0),
        soft: 0.3.into(),
        fall: SpotFall::default(),
        radius: between(0.0, 0.4),
    };
    let panel = Panel {
        position: between(at(0.0, 5.0, 0.0), at(1.5, 5.0, 1.0)),
        size: between([1.0, 0.5], [2.0, 1.5]),
        spread: 150.0.into(),
        ..Panel::at_rest(DVec3::ZERO, DVec3::ZERO, [1.0, 1.0])
    };
    let sun = LightKind::Sun {
        direction: between(at(-0.5, -1.0, -0.3), at(0.3, -1.0, -0.3)),
        angle: between(1.0, 5.0),
    };
    scene.lights = vec![
        toy::light("lamp", lamp, 6.0),
        toy::light("spot", spot, 9.0),
        toy::light("panel", LightKind::Rectangle(panel), 4.0),
        toy::light("sun", sun, 0.3),
    ];
    for light in &mut scene.lights {
        light.samples = points;
    }
    scene.lights[0].power = between(2.0, 9.0);
    scene.lights[2].color = between(Vec3::X, Vec3::Y);
    // rests, shines, and is dark
    scene.lights[3].power = toy::keys(&[(1.0, 0.3), (2.0, 0.3), (2.125, 0.0), (4.0, 0.0)]);
    scene
}

#[test]
fn samples_are_exact_under_lights_that_change_within_an_exposure() {
    for (points, paths, camera) in [(1, 0, false), (4, 0, true), (1, 2, false), (4, 2, true)] {
        let mut scene = under_changing_lights(points);
        if camera {
            scene = with_camera(scene, goes(EYE, EYE + DVec3::new(0.4, -0.2, -0.5)), rests(TARGET));
        }
        for (samples, exposures) in [(2, 4), (3, 9), (4, 4)] {
            let settings = Settings { width: 64, height: 48, paths, ..blurred(samples, exposures) };
            for frame in toy::render(&scene, &settings, LAST) {
                let audit = frame.stats.audit.unwrap();
                assert_eq!(
                    audit.wrong(),
                    0,
                    "{points}, {paths}, {samples}, {}: {audit:?}",
                    frame.stats.frame
                );
            }
        }
    }
}

/// The floor from above, ten pixels a unit, under a sun that sinks; a bar behind the camera casts a shadow that is 20 pixels wide and moves
/// by 110 while the shutter is open.
fn shadow_that_moves() -> Scene {
    let lit = |half: f32, [left, right]: [f32; 2], z: f32| {
        let corners = [[left, -half, z], [right, -half, z], [right, half, z], [left, half, z]];
        toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], 0, true)
    };
    // the way of the shadow for each unit of height, over frames of which the shutter sees half
    let slope = |frame: f64| DVec3::new((frame - 2.0) * 2.0 * 11.0 / HEIGHT, 0.0, -1.0);
    let direction = toy::keys(&[(1.0, slope(1.0)), (3.0, slope(3.0))]);
    let eye = DVec3::new(0.0, 0.0, 5.0);
    let models = vec![
        toy::still("floor", lit(40.0, [-40.0, 40.0], 0.0), Vec3::ZERO),
        toy::still("bar", lit(40.0, [-1.0, 1.0], HEIGHT as f32), Vec3::ZERO),
    ];
    let light = toy::light("sun", LightKind::Directional { direction }, 1.0);
    let mut scene =
        toy::scene(toy::camera(rests(eye), rests(DVec3::ZERO)), models, vec![toy::matt(1.0)], vec![light]);
    scene.camera.lens.height = Some(Track::constant(7.2));
    scene
}

/// Height of the bar above the floor.
const HEIGHT: f64 = 12.0;

/// Means of columns of the picture's middle.
fn columns(settings: &Settings) -> Vec<f64> {
    let frame = toy::render(&shadow_that_moves(), settings, 2).pop().unwrap();
    assert_eq!(toy::differing(&frame), 0);
    let rows = 28..44;
    let column = |x: u32| rows.clone().map(|y| f64::from(toy::pixel(&frame, "G", x, y))).sum::<f64>();
    (0..settings.width).map(|x| column(x) / rows.len() as f64).collect()
}

#[test]
fn shadows_of_lights_that_move_far_leave_no_rings() {
    let settings =
        |mode, samples, exposures| Settings { width: 240, height: 72, mode, ..blurred(samples, exposures) };
    let truth = columns(&settings(Mode::Full, 16, 256));
    let most = truth.iter().fold(0.0_f64, |most, shown| most.max(*shown));
    assert!(truth.iter().all(|shown| *shown > 0.5 * most), "the shadow does not rest anywhere");
    for (mode, samples) in [(Mode::Full, 4), (Mode::Reproject, 4), (Mode::Reproject, 2)] {
        let shown = columns(&settings(mode, samples, 4));
        let squares: f64 = shown.iter().zip(&truth).map(|(shown, truth)| (shown - truth).powi(2)).sum();
        let off = (squares / shown.len() as f64).sqrt() / most;
        println!("{mode:?}, {samples}x{samples} samples: {off:.4}");
        assert!(off < 0.02, "{mode:?}, {samples}: {off}");
    }
}
