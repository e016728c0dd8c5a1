//! Is rough glass right, and is what stays of it in a picture what would be made anew?

use afterimage::layers::Layers;
use afterimage::scene::material::{MetalRough, Optics, head_on};
use afterimage::scene::{Background, Environment, Material, Scene};
use afterimage::settings::{Caustics, Filter, Settings};
use glam::{DVec3, Vec3};

use crate::changing::{camera_goes, lamp_goes, under_a_sky, with_metal_flyer};
use crate::toy;
use crate::toy::worlds::*;

fn glass(roughness: f32, index: f32) -> Material {
    let optics = Optics::Glass {
        transmission: Vec3::ONE,
        index,
        reflection: Vec3::ONE,
        total: Vec3::ONE,
        is_rough: true,
        is_thin: false,
    };
    let (head_on, solid) = (head_on(index.into()) as f32, if index == 1.0 { 0.0 } else { 1.0 });
    let layer = MetalRough { base: Vec3::ZERO, roughness, metallic: 0.0, head_on, solid };
    Material { optics, metal_rough: Some(layer), ..toy::matt(0.0) }
}

/// An octahedron of rough glass on a floor.
fn before(background: Vec3, material: Material) -> Scene {
    let camera = toy::camera(rests(DVec3::new(0.4, 1.0, 3.0)), rests(DVec3::ZERO));
    let models = vec![toy::still("body", toy::octahedron(0, false), Vec3::ZERO)];
    let mut scene = toy::scene(camera, models, vec![material], vec![]);
    scene.background = Background::uniform(background);
    scene.environment = Some(Environment::from_background(&scene.background));
    scene
}

/// Within an even sky of 1, rough glass shows 1, as far as its rays are followed: within dense glass they are reflected often.
#[test]
fn rough_glass_in_a_furnace_is_hardly_seen() {
    for (roughness, index, depth) in [
        (0.1, 1.5, 12),
        (0.3, 1.5, 12),
        (1.0, 1.5, 12),
        (0.6, 1.3, 12),
        (0.4, 1.0, 12),
        (0.2, 2.2, 60),
        (0.4, 2.2, 60),
        (1.0, 2.2, 60),
    ] {
        let settings = Settings {
            audit: true,
            depth,
            bounces: depth,
            samples: 4,
            reflections: 16,
            paths: 4,
            ..toy::settings(1)
        };
        let finished = toy::render(&before(Vec3::ONE, glass(roughness, index)), &settings, 1).remove(0);
        let [object, green] =
            ["object.V", "G"].map(|plane| finished.film.values(plane).expect("it is there"));
        let is_body = |(object, _): &(f32, f32)| *object == 1.0;
        let both = object.iter().copied().zip(green.iter().copied());
        let body: Vec<f32> = both.filter(is_body).map(|(_, green)| green).collect();
        let mean = body.iter().sum::<f32>() / body.len() as f32;
        assert!(body.len() > 500 && (mean - 1.0).abs() < 0.008, "{roughness} {index}: {mean}");
        assert_eq!(toy::differing(&finished), 0);
    }
}

/// A pane that does not bend light shows a mean of what is behind it: all of a small bright square, over a wider place.
#[test]
fn a_rough_pane_blurs_what_is_behind_it() {
    let shown = |pane: Option<Material>| {
        let camera = toy::camera(rests(DVec3::new(0.0, 4.0, 0.01)), rests(DVec3::ZERO));
        let glowing = Material { emission: Vec3::ONE, ..toy::matt(0.0) };
        let mut models = vec![toy::still("square", toy::floor(0.4, 0), Vec3::ZERO)];
        let mut materials = vec![glowing];
        if let Some(pane) = pane {
            models.push(toy::still("pane", toy::floor(9.0, 1), Vec3::Y));
            materials.push(pane);
        }
        let mut scene = toy::scene(camera, models, materials, vec![]);
        scene.background = Background::uniform(Vec3::ZERO);
        let settings = Settings { samples: 8, layers: Layers::ALL, ..toy::settings(1) };
        let finished = toy::render(&scene, &settings, 1).remove(0);
        finished.film.values("R").expect("it is there").to_vec()
    };
    let (clear, blurred) = (shown(None), shown(Some(glass(0.4, 1.0))));
    let sum = |picture: &[f32]| picture.iter().sum::<f32>();
    assert!((sum(&blurred) / sum(&clear) - 1.0).abs() < 0.05, "{} {}", sum(&blurred), sum(&clear));
    let lit = |picture: &[f32]| picture.iter().filter(|value| **value > 0.02).count();
    assert!(lit(&blurred) > 2 * lit(&clear), "{} {}", lit(&blurred), lit(&clear));
    let most = |picture: &[f32]| picture.iter().copied().fold(0.0, f32::max);
    assert!(most(&blurred) < 0.9 * most(&clear), "{}", most(&blurred));
}

/// Whatever moves: what is kept of it is what would be made anew.
#[test]
fn an_audit_finds_nothing() {
    type Change = fn(Scene) -> Scene;
    let changes: [(&str, &[Change]); 4] = [
        ("nothing", &[]),
        ("a flyer under a sky", &[with_metal_flyer, under_a_sky]),
        ("the camera, under a sky, and area lights", &[camera_goes, under_a_sky, with_area_lights]),
        ("a flyer, a lamp and the camera", &[with_metal_flyer, lamp_goes, camera_goes]),
    ];
    for (name, changes) in changes {
        let mut scene = world();
        scene.materials[2] = glass(0.3, 1.5);
        let scene = changes.iter().fold(scene, |scene, change| change(scene));
        for (samples, filter, caustics) in
            [(1, Filter::Box, Caustics::Paths), (2, Filter::Mitchell, Caustics::None)]
        {
            let [width, height] = [80, 60].map(|size| size / samples);
            let settings = Settings {
                samples,
                filter,
                caustics,
                paths: 3,
                depth: 4,
                width,
                height,
                audit: true,
                reflections: 2,
                ..toy::settings(1)
            };
            for finished in toy::render(&scene, &settings, FRAMES) {
                assert_eq!(toy::differing(&finished), 0, "{name}, frame {}", finished.stats.frame);
            }
        }
    }
}
