//! Is light that goes below surfaces right, and are walks that are kept those which would be made anew?

use std::sync::Arc;

use afterimage::animation::TransformTrack;
use afterimage::scene::material::{Entry, Scattering};
use afterimage::scene::{Background, Environment, Material, Mesh, Scene};
use afterimage::settings::Settings;
use glam::{DVec3, Vec3};

use crate::changing::{Change, camera_goes, expect_nothing_found, lamp_goes, under_a_sky, with_metal_flyer};
use crate::metal_rough::metal_rough;
use crate::toy;
use crate::toy::worlds::*;

fn skin(albedo: f32, radius: f32, weight: f32) -> Material {
    let scattering = Some(Scattering {
        below: Vec3::splat(weight),
        through: 0.0,
        radius: Vec3::new(1.0, 0.5, 0.25) * radius,
        entry: Entry::MATT,
    });
    Material { scattering, ..toy::matt(albedo) }
}

/// A body alone under an even sky.
fn alone(material: Material) -> Scene {
    let camera = toy::camera(rests(DVec3::new(0.4, 1.0, 3.0)), rests(DVec3::ZERO));
    let models = vec![toy::still("body", toy::octahedron(0, false), Vec3::ZERO)];
    let mut scene = toy::scene(camera, models, vec![material], vec![]);
    scene.background = Background::uniform(Vec3::ONE);
    scene.environment = Some(Environment::from_background(&scene.background));
    scene
}

/// Mean colour of the body.
fn body(scene: &Scene, settings: &Settings) -> Vec3 {
    let finished = toy::render(scene, settings, 1).remove(0);
    assert_eq!(toy::differing(&finished), 0);
    let object = finished.film.values("object.V").expect("it is there");
    Vec3::from(["R", "G", "B"].map(|plane| {
        let values = finished.film.values(plane).expect("it is there");
        let of_body: Vec<f32> = object
            .iter()
            .zip(values.iter().copied())
            .filter(|(of, _)| **of == 1.0)
            .map(|(_, value)| value)
            .collect();
        of_body.iter().sum::<f32>() / of_body.len() as f32
    }))
}

fn settings() -> Settings {
    Settings { audit: true, paths: 64, samples: 2, ..toy::settings(1) }
}

/// Where light goes far less than the size of a thing, the thing shows the albedo that it has: in even light that of a matt one.
#[test]
fn a_dense_body_shows_its_albedo() {
    for albedo in [0.2, 0.5, 0.8] {
        let shown = body(&alone(skin(albedo, 0.01, 1.0)), &settings());
        // as near as the fit of the medium's albedo is
        assert!((shown - albedo).abs().max_element() < 0.04, "{albedo}: {shown}");
    }
}

/// Copies in one place, or in each other, are as bright as one of them, and so is a body whose triangles are inside out.
#[test]
fn copies_in_one_place_are_one() {
    let one = body(&alone(skin(0.7, 0.1, 1.0)), &settings());
    let scaled = |size: f64| {
        let track = TransformTrack { scale: rests(DVec3::splat(size)), ..TransformTrack::identity() };
        toy::moving("copy", toy::octahedron(0, false), track)
    };
    // copies that are read from several files have a material each, which says the same
    let of_another_file = toy::still("copy", toy::octahedron(1, false), Vec3::ZERO);
    let copies = [1.0, 0.999, 0.7].map(scaled).into_iter().chain([of_another_file]);
    for (number, copy) in copies.enumerate() {
        let mut scene = alone(skin(0.7, 0.1, 1.0));
        scene.materials.push(skin(0.7, 0.1, 1.0));
        scene.models.push(copy);
        let finished = toy::render(&scene, &settings(), 1).remove(0);
        assert_eq!(toy::differing(&finished), 0);
        let [object, green] =
            ["object.V", "G"].map(|plane| finished.film.values(plane).expect("it is there"));
        let shown: Vec<f32> =
            object.iter().zip(green).filter(|(of, _)| **of > 0.0).map(|(_, green)| green).collect();
        let mean = shown.iter().sum::<f32>() / shown.len() as f32;
        assert!((mean - one.y).abs() < 0.02, "copy {number}: {mean}, not {}", one.y);
    }
    let mut inside_out = alone(skin(0.7, 0.1, 1.0));
    let mesh = Mesh::clone(&inside_out.models[0].mesh);
    let turned = Arc::new(mesh.triangles().corners.iter().map(|[a, b, c]| [*a, *c, *b]).collect());
    inside_out.models[0].mesh = Arc::new(mesh.with_triangles(|triangles| triangles.corners = turned));
    let shown = body(&inside_out, &settings());
    assert!((shown - one).abs().max_element() < 0.01, "{shown}, not {one}");
}

/// What light goes through is brighter than what it does not, in even light no brighter than that light.
#[test]
fn no_body_shines_by_itself() {
    let shown = body(&alone(skin(0.98, 0.5, 1.0)), &settings());
    assert!(shown.max_element() < 1.02 && shown.min_element() > 0.7, "{shown}");
}

/// Light of one lamp behind a body is seen through it, the more the farther its light goes, and red more than blue.
#[test]
fn light_comes_through_thin_things() {
    let behind = |radius: f32| {
        let camera = toy::camera(rests(DVec3::new(0.0, 0.0, 3.0)), rests(DVec3::ZERO));
        let models = vec![toy::still("body", toy::octahedron(0, false), Vec3::ZERO)];
        let mut scene = toy::scene(camera, models, vec![skin(0.8, radius, 1.0)], vec![]);
        scene.lights.push(lamp(0.0, 0.0, -4.0));
        scene.background = Background::uniform(Vec3::ZERO);
        body(&scene, &Settings { bounces: 1, ..settings() })
    };
    let [dense, thin] = [0.02, 0.4].map(behind);
    assert!(dense.max_element() < 0.01, "{dense}");
    assert!(thin.x > 0.02 && thin.x > 1.3 * thin.z, "{thin}");
}

/// Half of the light below the surface is the mean of both.
#[test]
fn shares_are_mixed() {
    let shown = |weight: f32| body(&alone(skin(0.6, 0.3, weight)), &settings());
    let [none, half, all] = [0.0, 0.5, 1.0].map(shown);
    assert!((half - 0.5 * (none + all)).abs().max_element() < 0.02, "{none} {half} {all}");
}

/// Whatever moves: walks that are kept are what would be made anew.
#[test]
fn an_audit_finds_nothing() {
    let mut scene = world();
    scene.materials[2] = skin(0.7, 0.3, 0.8);
    scene.materials[1] =
        Material { scattering: skin(0.5, 0.1, 1.0).scattering, ..metal_rough(0.6, 0.4, 0.0) };
    let changes: [&[Change]; 4] = [
        &[],
        &[with_metal_flyer, under_a_sky],
        &[camera_goes, under_a_sky, with_area_lights],
        &[with_metal_flyer, lamp_goes, camera_goes],
    ];
    let settings = Settings { paths: 4, bounces: 2, ..toy::settings(1) };
    expect_nothing_found(&scene, &changes, &settings);
}
