//! Do surfaces that let light pass straight through dim it, and use up no bounces?

use afterimage::scene::material::Optics;
use afterimage::scene::{Background, Environment, Material, Scene};
use afterimage::settings::{Caustics, Settings};
use glam::{DVec3, Vec3};

use crate::changing::{camera_goes, lamp_goes, under_a_sky, with_metal_flyer};
use crate::toy;
use crate::toy::worlds::*;

/// Share of the light that each lets through.
const CLEAR: f32 = 0.7;

fn veil(diffuse: f32) -> Material {
    Material { optics: Optics::veil(Vec3::splat(CLEAR)), ..toy::matt(diffuse) }
}

/// Adds level veils over all of the world, from this height on.
fn with_veils(mut scene: Scene, count: usize, height: f32, diffuse: f32) -> Scene {
    let material = scene.materials.len() as u16;
    scene.materials.push(veil(diffuse));
    for number in 0..count {
        let at = Vec3::Y * (height + 0.05 * number as f32);
        scene.models.push(toy::still(&format!("veil {number}"), toy::floor(400.0, material), at));
    }
    scene
}

/// A floor that the eye sees from above.
fn floor(material: Material, eye_above: f64) -> Scene {
    let camera = toy::camera(rests(DVec3::new(0.0, eye_above, 0.01)), rests(DVec3::ZERO));
    let models = vec![toy::still("floor", toy::floor(400.0, 0), Vec3::ZERO)];
    let mut scene = toy::scene(camera, models, vec![material], vec![]);
    scene.background = Background::uniform(Vec3::ONE);
    scene
}

/// What the middle of the picture shows.
fn shown(scene: &Scene, settings: &Settings) -> f32 {
    let finished = toy::render(scene, settings, 1).remove(0);
    assert_eq!(toy::differing(&finished), 0);
    toy::color(&finished, finished.film.width / 2, finished.film.height / 2).y
}

#[test]
fn a_ray_passes_through_more_veils_than_it_may_bounce() {
    let glowing = Material { emission: Vec3::ONE, ..toy::matt(0.0) };
    for (count, depth) in [(1, 1), (3, 1), (12, 2)] {
        let scene = with_veils(floor(glowing.clone(), 4.0), count, 1.0, 0.0);
        let shown = shown(&scene, &Settings { depth, ..toy::audited(1) });
        let expected = CLEAR.powi(count as i32);
        assert!((shown - expected).abs() < 0.01 * expected, "{count}, {depth}: {shown}, not {expected}");
    }
    // a mirror takes its bounce, whatever comes before and after it
    let mirror = Material { optics: Optics::Mirror { tint: Vec3::ONE, fresnel: false }, ..toy::matt(0.0) };
    let scene = with_veils(floor(mirror.clone(), 4.0), 5, 1.0, 0.0);
    let shown_once = shown(&scene, &Settings { depth: 1, ..toy::audited(1) });
    assert!((shown_once - CLEAR.powi(10)).abs() < 0.001, "{shown_once}");
    let mut between = with_veils(floor(mirror, 2.0), 1, 1.0, 0.0);
    between.models.push(toy::still("ceiling", toy::floor(400.0, 0), Vec3::Y * 3.0));
    assert_eq!(shown(&between, &Settings { depth: 9, ..toy::audited(1) }), 0.0, "no way leads out");
}

/// Below veils an even sky is as much darker as they are together, however few surfaces a path may meet.
#[test]
fn a_path_passes_through_more_veils_than_it_may_bounce() {
    for (count, bounces) in [(1, 1), (5, 1), (5, 3)] {
        let mut scene = with_veils(floor(toy::matt(0.6), 0.5), count, 1.0, 0.0);
        scene.environment = Some(Environment::from_background(&scene.background));
        let settings = Settings { paths: 16, bounces, caustics: Caustics::Paths, ..toy::audited(1) };
        let (shown, expected) = (shown(&scene, &settings), 0.6 * CLEAR.powi(count as i32));
        assert!((shown - expected).abs() < 0.01 * expected, "{count}, {bounces}: {shown}, not {expected}");
    }
}

/// Veils that reflect as much as they hold back, over a white floor within an even sky: nothing is dimmed.
#[test]
fn veils_in_a_furnace_are_hardly_seen() {
    let mut scene = with_veils(floor(toy::matt(1.0), 4.0), 4, 1.0, 1.0 - CLEAR);
    scene.environment = Some(Environment::from_background(&scene.background));
    let caustics = Caustics::Paths;
    let settings = Settings { paths: 256, bounces: 24, depth: 4, caustics, ..toy::audited(1) };
    let finished = toy::render(&scene, &settings, 1).remove(0);
    let green = finished.film.values("G").expect("it is there");
    let mean = green.iter().sum::<f32>() / green.len() as f32;
    assert!(mean > 0.97 && mean < 1.02, "{mean}");
}

/// Whatever moves: what is kept below and behind veils is what would be made anew.
#[test]
fn an_audit_finds_nothing() {
    type Change = fn(Scene) -> Scene;
    let changes: [(&str, &[Change]); 3] = [
        ("a flyer under a sky", &[with_metal_flyer, under_a_sky]),
        ("the camera, under a sky, and area lights", &[camera_goes, under_a_sky, with_area_lights]),
        ("a flyer, a lamp and the camera", &[with_metal_flyer, lamp_goes, camera_goes]),
    ];
    for (name, changes) in changes {
        let scene = changes.iter().fold(world(), |scene, change| change(scene));
        let scene = with_veils(scene, 6, 0.3, 0.1);
        let settings = Settings { paths: 3, bounces: 2, depth: 2, reflections: 2, ..toy::audited(1) };
        for finished in toy::render(&scene, &settings, FRAMES) {
            let found = finished.stats.audit.as_ref();
            assert_eq!(toy::differing(&finished), 0, "{name}, frame {}: {found:?}", finished.stats.frame);
        }
    }
}
