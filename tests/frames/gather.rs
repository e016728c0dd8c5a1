//! Is light that comes from all around right, and is what is kept of it what would be made anew?

use std::f32::consts::{PI, TAU};

use afterimage::animation::{Track, TransformTrack};
use afterimage::frame::{Finished, Renderer, Spoil};
use afterimage::pose::{AreaShape, LightShape, Pose};
use afterimage::scene::environment::Sky;
use afterimage::scene::{Background, Environment, LightKind, Material, Model, Panel, Scene, SkyDensity};
use afterimage::settings::{Budget, Filter, Settings};
use glam::{DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::*;

fn settings(paths: u32, bounces: u32) -> Settings {
    Settings { paths, bounces, ..toy::settings(1) }
}

fn audited(paths: u32, bounces: u32) -> Settings {
    Settings { audit: true, ..settings(paths, bounces) }
}

/// The mean colour of a frame.
fn mean(finished: &Finished) -> Vec3 {
    let mean = |plane: &str| {
        let values = finished.film.values(plane).expect("the plane is there");
        values.iter().sum::<f32>() / values.len() as f32
    };
    Vec3::new(mean("R"), mean("G"), mean("B"))
}

/// Frame 1 of `scene`.
fn first(scene: &Scene, settings: &Settings) -> Finished {
    toy::render(scene, settings, 1).remove(0)
}

/// Within a closed surface that glows evenly light is the same everywhere: the sum of a geometric series.
#[test]
fn a_furnace_is_as_bright_as_the_series_says() {
    const EMITTED: f32 = 0.5;
    const ALBEDO: f32 = 0.6;
    let glowing = Material { emission: Vec3::splat(EMITTED), ..toy::matt(ALBEDO) };
    let camera = toy::camera(rests(DVec3::new(0.1, 0.05, 0.0)), rests(DVec3::X));
    let models = vec![toy::still("furnace", toy::octahedron(0, true), Vec3::ZERO)];
    let scene = toy::scene(camera, models, vec![glowing], vec![]);
    for bounces in 0..5 {
        let finished = first(&scene, &audited(16, bounces));
        // the last surface that a path meets is lit by what emits, too
        let reflected = if bounces == 0 { 0 } else { bounces + 1 };
        let expected: f32 = (0..=reflected).map(|bounce| EMITTED * ALBEDO.powi(bounce as i32)).sum();
        let seen = mean(&finished);
        assert!((seen / expected - Vec3::ONE).abs().max_element() < 2e-3, "{bounces}: {seen}, {expected}");
        assert_eq!(toy::differing(&finished), 0);
    }
}

/// A convex body under an even sky reflects its share of the sky, without noise.
#[test]
fn a_body_alone_under_an_even_sky_shows_its_colour() {
    let camera = toy::camera(rests(DVec3::new(0.0, 1.0, 4.0)), rests(DVec3::ZERO));
    let models = vec![toy::still("body", toy::octahedron(0, true), Vec3::ZERO)];
    let scene = toy::scene(camera, models, vec![toy::matt(0.5)], vec![]);
    let finished = first(&scene, &settings(7, 2));
    let seen = toy::color(&finished, 48, 36);
    assert!((seen - Vec3::new(0.125, 0.25, 0.5)).abs().max_element() < 1e-3, "{seen}");
}

/// An open floor reflects the light of the whole upper half of the sky, a sun of half a degree included.
#[test]
fn a_floor_under_a_sky_is_as_bright_as_the_sky_says() {
    for environment in [Environment::from_sky(&Sky::default()), patchy()] {
        let camera = toy::camera(rests(DVec3::new(0.0, 3.0, 4.0)), rests(DVec3::ZERO));
        let models = vec![toy::still("floor", toy::floor(40.0, 0), Vec3::ZERO)];
        let mut scene = toy::scene(camera, models, vec![toy::matt(0.5)], vec![]);
        let sun = environment.sun().map_or(Vec3::ZERO, |sun| sun.radiance * sun.solid_angle() * sun.to_sun.y);
        const STEPS: usize = 1000;
        let mut from_grid = Vec3::ZERO;
        for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS / 4).map(move |j| (i, j))) {
            let (turn, up) = ((i as f32 + 0.5) / STEPS as f32, (j as f32 + 0.5) / (STEPS / 4) as f32);
            let ((sin, cos), across) = ((TAU * turn).sin_cos(), (1.0 - up * up).sqrt());
            let direction = Vec3::new(across * sin, up, across * cos);
            from_grid += environment.grid_light(SkyDensity::Whole, direction).radiance * up;
        }
        let expected = 0.5 * (sun + from_grid * TAU / (STEPS * STEPS / 4) as f32) / PI;
        scene.environment = Some(environment);
        let finished = first(&scene, &audited(64, 1));
        let seen = (20..70).map(|y| toy::color(&finished, 48, y)).sum::<Vec3>() / 50.0;
        assert!((seen / expected - Vec3::ONE).abs().max_element() < 0.02, "{seen}, {expected}");
        assert_eq!(toy::differing(&finished), 0);
    }
}

/// Dark but for a few bright texels.
fn patchy() -> Environment {
    let texel = |i: usize| if i % 97 == 5 { [9.0, 3.0, 1.0] } else { [0.1, 0.1, 0.2] };
    Environment::from_picture(64, 32, (0..64 * 32).flat_map(texel).collect()).expect("it is good")
}

/// Large bright texels on a dim sky: paths that escape find them, too, and most rays that ask find one.
fn blotchy() -> Environment {
    let texel = |i: usize| if i % 5 == 2 { [4.0, 2.0, 1.0] } else { [0.5, 0.5, 1.0] };
    Environment::from_picture(8, 4, (0..8 * 4).flat_map(texel).collect()).expect("it is good")
}

/// Asking the sky and escaping to it add up to the same light as escaping alone, after any number of bounces.
#[test]
fn both_ways_to_the_sky_add_up() {
    for bounces in 1..4 {
        let mut scene = world();
        scene.lights.truncate(1);
        for environment in [Environment::from_background(&scene.background), blotchy()] {
            let mut with = |samples, paths| {
                let mut environment = environment.clone();
                environment.samples = samples;
                scene.environment = Some(environment);
                mean(&first(&scene, &settings(paths, bounces)))
            };
            let by_escape = with(0, 256);
            for samples in [1, 3] {
                let by_both = with(samples, 64);
                let ratio = by_both / by_escape;
                assert!((ratio - Vec3::ONE).abs().max_element() < 0.01, "{samples}: {by_both}, {by_escape}");
            }
        }
    }
}

/// A surface that emits lights others as a light of the same shape and power does, after any number of bounces. (Lights
/// leave out Lambert's division by pi.)
#[test]
fn a_glowing_panel_lights_as_a_panel_does() {
    for bounces in 1..4 {
        let mut scene = world();
        scene.models.truncate(2);
        (scene.ambient, scene.background) = (Vec3::ZERO, Background::uniform(Vec3::ZERO));
        scene.lights = vec![panel(rests(DVec3::new(1.0, 5.0, 2.0)))];
        let lit = mean(&first(&scene, &settings(64, bounces)));
        let LightKind::Rectangle(Panel { size, .. }) = &scene.lights[0].kind else { unreachable!() };
        let [width, height] = size.at(1.0);
        let radiance = 20.0 * PI / (width * height) as f32;
        let LightShape::Area(AreaShape::Rectangle { center, across, up, .. }) =
            Pose::new(&scene, 1).lights[0].shape
        else {
            unreachable!()
        };
        let corner = |x: f32, y: f32| (center + across * x + up * y).to_array();
        let corners = [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
        scene.materials[1] = Material { emission: Vec3::splat(radiance), ..toy::matt(0.0) };
        scene.models.push(toy::still(
            "panel",
            toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], 1, true),
            Vec3::ZERO,
        ));
        scene.lights.clear();
        let finished = first(&scene, &audited(64, bounces));
        let glowing = mean(&finished);
        assert_eq!(toy::differing(&finished), 0);
        assert!((glowing / lit - Vec3::ONE).abs().max_element() < 0.01, "{bounces}: {glowing}, {lit}");
    }
}

/// Small and far, it is met by few paths: without being asked it would be all noise. Near, asking alone would be.
#[test]
fn light_of_what_emits_has_little_noise_near_and_far() {
    let camera = toy::camera(rests(DVec3::new(0.0, 6.0, 0.01)), rests(DVec3::ZERO));
    for (height, size, most) in [(40.0, 0.5, 0.05), (0.3, 4.0, 0.35)] {
        let corner = |x: f32, z: f32| [x * size, height, z * size];
        let corners = [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
        let models = vec![
            toy::still("floor", toy::floor(8.0, 0), Vec3::ZERO),
            toy::still("lamp", toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], 1, true), Vec3::ZERO),
        ];
        let glowing = Material { emission: Vec3::splat(100.0), ..toy::matt(0.0) };
        let scene = toy::scene(camera.clone(), models, vec![toy::matt(0.5), glowing], vec![]);
        let dark = Scene { background: Background::uniform(Vec3::ZERO), ..scene };
        let small = |paths| Settings { width: 48, height: 36, ..settings(paths, 1) };
        let [few, many] = [16, 1024].map(|paths| first(&dark, &small(paths)));
        let of_floor = |finished: &Finished| -> Vec<f32> {
            let [green, id] =
                ["G", "object.V"].map(|plane| finished.film.values(plane).expect("it is there"));
            green.iter().zip(&id).filter(|(_, id)| **id == 1.0).map(|(green, _)| *green).collect()
        };
        let [few, many] = [few, many].map(|finished| of_floor(&finished));
        let squares = few.iter().zip(&many).map(|(few, many)| (few - many).powi(2)).sum::<f32>();
        let relative = (squares / many.iter().map(|green| green * green).sum::<f32>()).sqrt();
        assert!(many.len() > 500 && relative < most, "{height}: {relative}, {} pixels", many.len());
    }
}

#[test]
fn the_eye_sees_an_environment_if_it_is_visible() {
    let mut scene = world();
    scene.environment = Some(patchy().times(0.0));
    let corner = |scene: &Scene| toy::color(&first(scene, &settings(1, 1)), 2, 2);
    assert_eq!(corner(&scene), Vec3::ZERO);
    if let Some(environment) = &mut scene.environment {
        environment.visible = false;
    }
    assert!((corner(&scene) - Vec3::new(0.25, 0.5, 1.0)).abs().max_element() < 1e-3);
}

/// A path asks one light of several, and weighs it by their number: on average that is what all of them bring.
#[test]
fn one_light_of_several_stands_for_all() {
    let with = |lights: &[usize]| {
        let mut scene = world();
        scene.models.truncate(2);
        scene.background = Background::uniform(Vec3::ZERO);
        scene.lights.push(panel(rests(DVec3::new(1.0, 5.0, 2.0))));
        scene.lights = lights.iter().map(|light| scene.lights[*light].clone()).collect();
        scene.ambient = Vec3::ZERO;
        let gathered = mean(&first(&scene, &settings(64, 2)));
        gathered - mean(&first(&scene, &settings(0, 2)))
    };
    let together = with(&[0, 1, 2]);
    let apart = with(&[0]) + with(&[1]) + with(&[2]);
    assert!(together.min_element() > 0.003, "or it is too dark to tell: {together}");
    assert!((together / apart - Vec3::ONE).abs().max_element() < 0.02, "{together}, {apart}");
}

/// Surfaces on paths ask each kind of light: a kind that is nowhere in sight takes no question from another, and changes no pixel.
#[test]
fn light_that_is_nowhere_in_sight_changes_nothing() {
    let camera = toy::camera(rests(DVec3::new(0.1, 0.05, 0.0)), rests(DVec3::X));
    let room = toy::still("room", toy::octahedron(0, true), Vec3::ZERO);
    let outside = toy::still("outside", toy::octahedron(1, true), Vec3::new(9.0, 0.0, 0.0));
    let glowing = Material { emission: Vec3::splat(5.0), ..toy::matt(0.0) };
    let materials = vec![toy::matt(0.6), glowing];
    let seen = |models: Vec<Model>, sky: Option<Environment>| {
        let lights = vec![lamp(0.2, 0.1, 0.1)];
        let scene = toy::scene(camera.clone(), models, materials.clone(), lights);
        let finished = first(&Scene { environment: sky, ..scene }, &settings(4, 2));
        ["R", "G", "B"].map(|plane| finished.film.values(plane).expect("it is there").to_vec())
    };
    let alone = seen(vec![room.clone()], None);
    assert!(alone[0].iter().any(|value| *value != alone[0][0]), "the lamp lights it");
    assert!(seen(vec![room.clone()], Some(patchy())) == alone, "a sky");
    assert!(seen(vec![room, outside], None) == alone, "a surface that emits");
}

/// A row of forty lamps between a floor and a ceiling lights what is near each of them: a path that asked any of
/// them alike would have more than twice the noise that is allowed here.
#[test]
fn of_many_lamps_those_are_asked_that_are_near() {
    const LENGTH: f32 = 80.0;
    let sheet = |y: f32, z: f32, x: [f32; 2], material: u16| {
        let corners = [[x[0], y, -z], [x[1], y, -z], [x[1], y, z], [x[0], y, z]];
        toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], material, true)
    };
    let camera = toy::camera(rests(DVec3::new(18.0, 1.0, 0.0)), rests(DVec3::new(20.0, 0.0, 0.0)));
    let walls = [("floor", 0.0), ("ceiling", 3.0)]
        .map(|(name, y)| toy::still(name, sheet(y, 2.0, [0.0, LENGTH], 0), Vec3::ZERO));
    let glowing = Material { emission: Vec3::splat(20.0), ..toy::matt(0.0) };
    let at = |i: u16| 2.0 * f32::from(i) + 1.0;
    let lamps = (0..40).map(|i| lamp(f64::from(at(i)), 1.5, 0.0)).collect();
    let panels =
        (0..40).map(|i| toy::still("panel", sheet(1.5, 0.05, [at(i) - 0.05, at(i) + 0.05], 1), Vec3::ZERO));
    let shots = [(walls.to_vec(), lamps), (walls.iter().cloned().chain(panels).collect(), vec![])];
    for (models, lights) in shots {
        let scene = toy::scene(camera.clone(), models, vec![toy::matt(0.8), glowing.clone()], lights);
        let dark = Scene { background: Background::uniform(Vec3::ZERO), ..scene };
        let gathered = |paths: u32| -> Vec<f32> {
            let small = |paths| Settings { width: 32, height: 24, audit: true, ..settings(paths, 1) };
            let [all, direct] = [paths, 0].map(|paths| first(&dark, &small(paths)));
            assert_eq!(toy::differing(&all), 0);
            let [all, direct] = [&all, &direct].map(|of| of.film.values("G").expect("it is there").to_vec());
            all.iter().zip(&direct).map(|(all, direct)| all - direct).collect()
        };
        let [few, many] = [16, 1024].map(gathered);
        let squares = few.iter().zip(&many).map(|(few, many)| (few - many).powi(2)).sum::<f32>();
        let relative = (squares / many.iter().map(|green| green * green).sum::<f32>()).sqrt();
        println!("{} lights: {relative}", dark.lights.len());
        assert!(relative < 0.3, "{} lights: {relative}", dark.lights.len());
    }
}

/// More paths bring the same light with less noise.
#[test]
fn the_mean_does_not_depend_on_the_number_of_paths() {
    let scene = world();
    let [few, many] = [4, 64].map(|paths| mean(&first(&scene, &settings(paths, 3))));
    assert!((few / many - Vec3::ONE).abs().max_element() < 0.01, "{few}, {many}");
}

fn under_a_sky(mut scene: Scene) -> Scene {
    scene.environment = Some(Environment::from_sky(&Sky::default()));
    scene
}

fn lamp_goes(mut scene: Scene) -> Scene {
    let position = goes(DVec3::new(2.0, 4.0, 3.0), DVec3::new(1.0, 4.5, 3.0));
    scene.lights[1].kind = LightKind::Point { position };
    scene
}

fn lamp_fades(mut scene: Scene) -> Scene {
    scene.lights[1].power = toy::keys(&[(3.0, 9.0), (5.0, 3.0)]);
    scene
}

/// The flyer emits light, as a small still thing does.
fn glows(mut scene: Scene) -> Scene {
    let material = scene.materials.len() as u16;
    scene.materials.push(Material { emission: Vec3::new(5.0, 4.0, 2.0), ..toy::matt(0.3) });
    if let Some(flyer) = scene.models.iter_mut().find(|model| model.name == "flyer") {
        flyer.mesh = std::sync::Arc::new(toy::octahedron(material, true));
        flyer.track.scale = goes(DVec3::new(0.3, 0.6, 0.2), DVec3::new(0.6, 0.5, 0.6));
    }
    let corners = [[-4.0, 1.0, -2.0], [-3.0, 1.0, -2.0], [-4.0, 2.0, -2.0]];
    scene.models.push(toy::still("tile", toy::mesh(&corners, &[[0, 1, 2]], material, true), Vec3::ZERO));
    scene
}

fn camera_goes(scene: Scene) -> Scene {
    with_camera(scene, goes(EYE, EYE + DVec3::new(0.3, 0.1, -0.4)), rests(TARGET))
}

/// Whatever moves: all paths of all samples bring what is kept of them.
#[test]
fn what_is_kept_is_what_would_be_gathered_anew() {
    type Change = fn(Scene) -> Scene;
    let changes: [(&str, &[Change]); 10] = [
        ("a flyer", &[with_flyer]),
        ("a flyer and the camera", &[with_flyer, camera_goes]),
        ("a lamp", &[lamp_goes]),
        ("a lamp that fades, and the camera", &[lamp_fades, camera_goes]),
        ("a flyer that glows", &[with_flyer, glows]),
        ("a flyer that glows, and the camera", &[with_flyer, glows, under_a_sky, camera_goes]),
        ("area lights", &[with_flyer, with_area_lights, camera_goes]),
        ("a flyer and a lamp", &[with_flyer, lamp_goes]),
        ("the camera", &[camera_goes]),
        ("a flyer under a sky, and the camera", &[with_flyer, under_a_sky, camera_goes]),
    ];
    for (name, changes) in changes {
        let scene = changes.iter().fold(world(), |scene, change| change(scene));
        for (samples, filter, budget) in [(1, Filter::Box, Budget::Full), (2, Filter::Mitchell, Budget::None)]
        {
            let [width, height] = [80, 60].map(|size| size / samples);
            let settings = Settings { samples, filter, budget, paths_per_frame: 2, ..audited(5, 2) };
            let settings = Settings { width, height, ..settings };
            for finished in toy::render(&scene, &settings, FRAMES) {
                assert_eq!(toy::differing(&finished), 0, "{name}, frame {}", finished.stats.frame);
            }
        }
    }
}

/// A flat thing that moves in its own plane never meets paths that begin on it.
#[test]
fn light_on_what_slides_in_its_own_plane_is_gathered_anew() {
    let slides = || {
        let path = goes(DVec3::new(-1.0, 0.5, 0.0), DVec3::new(1.0, 0.5, 0.0));
        let track = TransformTrack { translate: path, ..TransformTrack::identity() };
        let models = vec![
            toy::still("floor", toy::floor(6.0, 0), Vec3::ZERO),
            toy::still("thing", toy::octahedron(0, true), Vec3::new(0.0, 2.5, 0.0)),
            toy::moving("plate", toy::floor(1.0, 0), track),
        ];
        let camera = toy::camera(rests(DVec3::new(0.0, 4.0, 6.0)), rests(DVec3::ZERO));
        toy::scene(camera, models, vec![toy::matt(0.5)], vec![toy::sun_overhead(1.0)])
    };
    for scene in [slides(), camera_goes(slides())] {
        for frame in toy::render(&scene, &audited(4, 1), FRAMES) {
            assert_eq!(toy::differing(&frame), 0, "frame {}: {:?}", frame.stats.frame, frame.stats.audit);
        }
    }
}

#[test]
fn frames_may_be_rendered_backwards() {
    let scene = with_flyer(world());
    let mut renderer = Renderer::new(&scene, &audited(4, 2)).expect("the scene builds");
    for frame in [6, 4, 4, 2, 5, 1] {
        let finished = renderer.render(frame, true).expect("renders");
        assert_eq!(toy::differing(&finished), 0, "frame {frame}");
    }
}

/// Most of what is gathered stays: a small thing that moves touches few paths.
#[test]
fn few_paths_are_traced_again() {
    let mut scene = world();
    scene.models.truncate(2);
    let track = TransformTrack {
        translate: goes(DVec3::new(-1.0, 0.4, 1.5), DVec3::new(1.0, 0.4, 1.5)),
        scale: rests(DVec3::splat(0.1)),
        ..TransformTrack::identity()
    };
    scene.models.push(toy::moving("fly", toy::octahedron(0, true), track));
    for (name, scene) in [("at rest", scene.clone()), ("moving", camera_goes(scene))] {
        let frames = toy::render(&scene, &settings(8, 2), FRAMES);
        let base = frames[0].stats.rays.gathering as f64;
        for finished in &frames[1..] {
            let share = finished.stats.rays.gathering as f64 / base;
            assert!(share > 0.0 && share < 0.2, "{name}, frame {}: {share}", finished.stats.frame);
        }
    }
    // what mirrors show gathers anew until it is known where their rays go
    let mut scene = world();
    scene.models.truncate(2);
    let rests = toy::render(&scene, &settings(8, 2), 3);
    assert!(rests[1..].iter().all(|finished| finished.stats.rays.gathering == 0), "nothing moves");
}

/// What moves in a closed body that rests lies behind its walls on the ways of all paths.
#[test]
fn behind_what_rests_nothing_is_traced_again() {
    let inside = TransformTrack {
        translate: goes(DVec3::new(-0.3, 1.5, 0.0), DVec3::new(0.3, 1.5, 0.0)),
        scale: rests(DVec3::splat(0.2)),
        ..TransformTrack::identity()
    };
    let models = vec![
        toy::still("floor", toy::floor(6.0, 0), Vec3::ZERO),
        toy::still("body", toy::octahedron(0, true), Vec3::new(0.0, 1.5, 0.0)),
        toy::moving("fly", toy::octahedron(0, true), inside),
    ];
    let camera = toy::camera(rests(DVec3::new(0.0, 4.0, 6.0)), rests(DVec3::ZERO));
    let scene = toy::scene(camera, models, vec![toy::matt(0.5)], vec![toy::sun_overhead(1.0)]);
    for scene in [scene.clone(), under_a_sky(scene)] {
        let frames = toy::render(&scene, &audited(8, 2), FRAMES);
        assert!(frames[0].stats.rays.gathering > 0);
        for finished in &frames[1..] {
            assert_eq!((finished.stats.rays.gathering, toy::differing(finished)), (0, 0));
        }
    }
}

/// What glows behind a wall that rests lights the floor as soon as it comes out.
#[test]
fn light_comes_out_from_behind_what_rests() {
    let glowing = Material { emission: Vec3::new(9.0, 8.0, 4.0), ..toy::matt(0.3) };
    let wall = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [-1.0, 2.0, 0.0]];
    let comes_out = TransformTrack {
        translate: goes(DVec3::new(0.0, 1.0, -0.6), DVec3::new(2.5, 1.0, -0.6)),
        scale: rests(DVec3::splat(0.3)),
        ..TransformTrack::identity()
    };
    let models = vec![
        toy::still("floor", toy::floor(6.0, 0), Vec3::ZERO),
        toy::still("wall", toy::mesh(&wall, &[[0, 1, 2], [0, 2, 3]], 0, true), Vec3::ZERO),
        toy::moving("lamp", toy::octahedron(1, true), comes_out),
    ];
    let camera = toy::camera(rests(DVec3::new(0.0, 4.0, 6.0)), rests(DVec3::ZERO));
    let mut scene = toy::scene(camera, models, vec![toy::matt(0.5), glowing], vec![]);
    scene.background = Background::uniform(Vec3::ZERO);
    for scene in [scene.clone(), camera_goes(scene)] {
        let frames = toy::render(&scene, &audited(8, 2), FRAMES);
        frames
            .iter()
            .for_each(|finished| assert_eq!(toy::differing(finished), 0, "frame {}", finished.stats.frame));
        let [first, .., last] = &frames[..] else { panic!("there are several") };
        assert!(mean(last).y > 1.2 * mean(first).y, "{}, {}", mean(first), mean(last));
    }
}

/// The error of the last of so many frames at rest, against a reference.
fn error_after(scene: &Scene, reference: &Finished, settings: &Settings, frames: i32) -> f32 {
    let last = toy::render(scene, settings, frames).pop().expect("there is one");
    assert_eq!(toy::differing(&last), 0);
    let [last, reference] = [&last, reference].map(|of| of.film.values("G").expect("it is there").to_vec());
    let squares = last.iter().zip(&reference).map(|(a, b)| (a - b).powi(2)).sum::<f32>();
    (squares / last.len() as f32).sqrt()
}

/// Before a camera at rest each frame adds as many paths as the first one had, until all are there.
#[test]
fn under_a_budget_samples_get_more_paths() {
    let mut scene = world();
    scene.models.truncate(2);
    let reference = first(&scene, &settings(256, 2));
    let filling = Settings { budget: Budget::Full, paths_per_frame: 4, ..audited(16, 2) };
    let errors = [1, 2, 4, 6].map(|frames| error_after(&scene, &reference, &filling, frames));
    let [few, all] = [4, 16].map(|paths| error_after(&scene, &reference, &audited(paths, 2), 1));
    assert_eq!((errors[0], errors[2], errors[3]), (few, all, all), "{errors:?}");
    assert!(errors[1] < errors[0] && errors[2] < errors[1], "{errors:?}");
}

#[test]
fn a_budget_is_kept() {
    let mut scene = camera_goes(with_flyer(world()));
    scene.models.retain(|model| model.name != "mirror" && model.name != "glass");
    let share = |settings: &Settings| {
        let frames = toy::render(&scene, settings, FRAMES);
        let rays = |finished: &Finished| finished.stats.rays.gathering;
        let full = rays(&frames[0]);
        frames[1..].iter().map(|of| rays(of) as f64 / full as f64).collect::<Vec<_>>()
    };
    let filling = Settings { budget: Budget::Full, paths_per_frame: 4, ..settings(64, 2) };
    let (full, none) = (share(&filling), share(&settings(4, 2)));
    assert!(none.iter().all(|share| *share < 0.3), "{none:?}");
    assert!(full.iter().all(|share| (0.9..1.1).contains(share)), "{full:?}");
    // shadow rays count, too: about as many as others
    let rays = toy::render(&scene, &settings(4, 2), 1)[0].stats.rays.gathering;
    let half = share(&Settings { budget: Budget::Rays(rays), ..filling });
    assert!(half.iter().all(|share| (0.35..0.65).contains(share)), "{half:?}");
}

/// A light that changes concerns the paths that have asked it, and no others.
#[test]
fn paths_that_asked_another_light_stay() {
    // in a closed room, so that each path meets one surface and asks one of two lamps
    let mut scene = lamp_fades(world());
    scene.models = vec![toy::still("room", toy::octahedron(0, true), Vec3::ZERO)];
    scene.background = Background::uniform(Vec3::ZERO);
    for (light, x) in scene.lights.iter_mut().zip([-0.3, 0.3]) {
        light.kind = LightKind::Point { position: rests(DVec3::new(x, 0.1, 0.0)) };
    }
    // as strong as the other at first: paths ask both alike
    scene.lights[0].power = Track::constant(9.0);
    let scene = with_camera(scene, rests(DVec3::new(0.1, 0.05, 0.0)), rests(DVec3::X));
    let frames = toy::render(&scene, &settings(8, 1), 4);
    let share =
        |frame: usize| frames[frame].stats.rays.gathering as f64 / frames[0].stats.rays.gathering as f64;
    assert_eq!(share(2), 0.0, "it has not begun");
    // more than a half: it is on the side to which the eye looks, where more paths begin
    assert!((0.5..0.65).contains(&share(3)), "one of two lights: {}", share(3));
}

#[test]
fn threads_change_no_bit() {
    let scene = camera_goes(with_flyer(world()));
    let render = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        let filling =
            Settings { samples: 2, budget: Budget::Rays(100_000), paths_per_frame: 2, ..settings(7, 2) };
        pool.install(|| toy::render(&scene, &filling, 4))
    };
    for (one, other) in render(1).iter().zip(&render(5)) {
        for plane in &one.film.planes {
            let values = |finished: &Finished| finished.film.values(&plane.name).expect("the plane is there");
            let same = values(one).iter().zip(&values(other)).all(|(a, b)| a.to_bits() == b.to_bits());
            assert!(same, "frame {}, {}", one.stats.frame, plane.name);
        }
    }
}

/// A path that is held to bring a frame too long what it brought shows light that is not there any more.
#[test]
fn an_audit_finds_what_is_kept_a_frame_too_long() {
    for scene in [with_flyer(world()), glows(with_flyer(world())), lamp_goes(world())] {
        let found = |spoils: bool| {
            let mut renderer = Renderer::new(&scene, &audited(4, 2)).expect("the scene builds");
            renderer.render(1, true).expect("renders");
            renderer.render(2, true).expect("renders");
            if spoils {
                assert!(renderer.spoil(Spoil::Until).expect("no rays are cast") > 20);
            }
            toy::differing(&renderer.render(3, true).expect("renders"))
        };
        assert_eq!(found(false), 0);
        assert!(found(true) > 20, "{}", found(true));
    }
}

#[test]
fn an_audit_finds_spoilt_and_lost_paths() {
    let mut scene = world();
    scene.models.truncate(2);
    for what in [Spoil::Gathered, Spoil::Fewer] {
        let mut renderer = Renderer::new(&scene, &audited(4, 2)).expect("the scene builds");
        renderer.render(1, true).expect("renders");
        let spoilt = renderer.spoil(what).expect("no rays are cast");
        let found = toy::differing(&renderer.render(2, true).expect("renders"));
        assert!(spoilt > 50 && found == spoilt, "{what:?}: {spoilt}, {found}");
    }
}
