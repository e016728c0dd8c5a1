//! Is fuzz seen as it should be, by rays and by paths, and is what stays of it what would be made anew?

use afterimage::scene::material::{Coat, Fuzz};
use afterimage::scene::{Background, Environment, LightKind, Material, Panel, Scene};
use afterimage::settings::Settings;
use glam::{DVec3, Vec3};

use crate::changing::{CHANGES, expect_nothing_found};
use crate::metal_rough::metal_rough;
use crate::toy;
use crate::toy::worlds::*;

const CLOTH: Fuzz = Fuzz { weight: 1.0, color: Vec3::ONE, roughness: 0.5 };

fn below(fuzz: Fuzz, material: Material) -> Material {
    Material { fuzz: Some(fuzz), ..material }
}

/// A floor of a material, seen aslant.
fn floor_of(material: Material) -> Scene {
    let camera = toy::camera(rests(DVec3::new(0.0, 1.5, 4.0)), rests(DVec3::ZERO));
    let models = vec![toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO)];
    let mut scene = toy::scene(camera, models, vec![material], vec![]);
    scene.background = Background::uniform(Vec3::ZERO);
    scene
}

fn mean(scene: &Scene, settings: &Settings) -> f32 {
    let finished = toy::render(scene, settings, 1).remove(0);
    assert_eq!(toy::differing(&finished), 0);
    let [object, green] = ["object.V", "G"].map(|plane| finished.film.values(plane).expect("it is there"));
    let of_floor: Vec<f32> =
        object.iter().zip(green).filter(|(object, _)| **object == 1.0).map(|(_, green)| green).collect();
    of_floor.iter().sum::<f32>() / of_floor.len() as f32
}

/// What is white stays white below fuzz in an even sky: it takes as much as it reflects.
#[test]
fn fuzz_takes_no_light_in_a_furnace() {
    for (roughness, material) in [
        (0.2, metal_rough(1.0, 0.5, 0.0)),
        (0.5, metal_rough(1.0, 0.4, 1.0)),
        (0.9, metal_rough(1.0, 1.0, 0.0)),
    ] {
        let mut scene = floor_of(below(Fuzz { roughness, ..CLOTH }, material));
        scene.background = Background::uniform(Vec3::ONE);
        scene.environment = Some(Environment::from_background(&scene.background));
        let shown = mean(&scene, &Settings { reflections: 32, paths: 16, ..toy::audited(2) });
        assert!((shown - 1.0).abs() < 0.015, "{roughness}: {shown}");
    }
}

/// A panel is seen once, whether highlights, rays or both show it.
#[test]
fn lights_with_a_size_shine_once() {
    let shown = |fuzz: Fuzz, depth: u32| {
        let material = Material { coat: None, ..below(fuzz, metal_rough(0.0, 0.6, 0.0)) };
        let mut scene = floor_of(material);
        let panel = Panel::at_rest(DVec3::new(0.0, 2.0, -3.0), DVec3::ZERO, [2.0, 2.0]);
        scene.lights.push(toy::light("panel", LightKind::Rectangle(panel), 30.0));
        mean(&scene, &Settings { depth, reflections: 32, ..toy::audited(4) })
    };
    for roughness in [0.2, 0.6] {
        let [alone, shared] = [0, 1].map(|depth| shown(Fuzz { roughness, ..CLOTH }, depth));
        assert!(alone > 0.01 && (shared / alone - 1.0).abs() < 0.03, "{roughness}: {alone} {shared}");
    }
}

/// Whatever moves: what stays is what would be made anew.
#[test]
fn an_audit_finds_nothing() {
    let mut scene = world();
    let varnish = Coat { weight: 1.0, roughness: 0.0, index: 1.5, tint: Vec3::ONE, darkening: 0.0 };
    scene.materials[0] = below(Fuzz { roughness: 0.2, ..CLOTH }, metal_rough(0.3, 0.0, 1.0));
    scene.materials[1] = Material { coat: Some(varnish), ..below(CLOTH, metal_rough(0.6, 0.4, 0.0)) };
    let settings = Settings { paths: 2, reflections: 2, depth: 3, ..toy::settings(1) };
    expect_nothing_found(&scene, &CHANGES, &settings);
}
