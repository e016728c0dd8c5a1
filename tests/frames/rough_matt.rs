//! Are matt surfaces that are rough as bright as their model says, to lights and to a sky, and is what stays of them what would be made anew?

use std::f64::consts::PI;

use afterimage::scene::material::{Coat, MetalRough};
use afterimage::scene::{Background, Environment, LightKind, Material, Scene};
use afterimage::settings::Settings;
use glam::{DVec3, Vec3};

use crate::changing::{CHANGES, expect_nothing_found};
use crate::metal_rough::metal_rough;
use crate::toy;
use crate::toy::worlds::*;

/// Clay: what its layer reflects is nothing.
fn clay(albedo: f32, roughness: f32) -> Material {
    let base = Vec3::splat(albedo);
    let layer = MetalRough { base, roughness: 1.0, metallic: 0.0, head_on: 0.0, solid: 1.0 };
    Material { diffuse_roughness: roughness, metal_rough: Some(layer), ..toy::matt(albedo) }
}

/// A floor that is seen from this direction, and lit by a light that comes from another.
fn floor(material: Material, to_eye: DVec3, to_light: Option<DVec3>) -> Scene {
    let camera = toy::camera(rests(to_eye.normalize() * 5.0), rests(DVec3::ZERO));
    let models = vec![toy::still("floor", toy::floor(40.0, 0), Vec3::ZERO)];
    let mut scene = toy::scene(camera, models, vec![material], vec![]);
    scene.background = Background::uniform(Vec3::ZERO);
    if let Some(to_light) = to_light {
        let kind = LightKind::Directional { direction: rests(-to_light.normalize()) };
        scene.lights.push(toy::light("sun", kind, 1.0));
    }
    scene
}

/// Share of light that leaves a white surface after one scattering: the integral that the authors give (EON, equation 16 onwards).
fn once(roughness: f64, cos: f64) -> f64 {
    let dims = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * roughness);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let more = sin * (cos.acos() - sin * cos) + 2.0 / 3.0 * (sin / cos * (1.0 - sin.powi(3)) - sin);
    dims + roughness * dims / PI * more
}

/// What a rough matt surface shows of light of unit irradiance across its way, where a white smooth one shows the cosine.
fn shown(albedo: f64, roughness: f64, eye: DVec3, light: DVec3) -> f64 {
    let (eye, light) = (eye.normalize(), light.normalize());
    let apart = eye.dot(light) - eye.y * light.y;
    let towards = if apart > 0.0 { apart / eye.y.max(light.y) } else { apart };
    let dims = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * roughness);
    let mean = dims * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * roughness);
    let again = albedo * albedo * mean / (1.0 - albedo * (1.0 - mean));
    let several = again * (1.0 - once(roughness, eye.y)) * (1.0 - once(roughness, light.y)) / (1.0 - mean);
    (albedo * dims * (1.0 + roughness * towards) + several) * light.y
}

#[test]
fn lights_are_shown_as_the_model_says() {
    let directions = [
        (DVec3::new(2.0, 1.0, 0.0), DVec3::new(2.0, 1.0, 0.3)),
        (DVec3::new(2.0, 1.0, 0.0), DVec3::new(-2.0, 1.0, 0.0)),
        (DVec3::new(0.1, 1.0, 0.2), DVec3::new(0.5, 1.0, -1.0)),
    ];
    for (albedo, roughness) in [(0.2, 1.0), (0.8, 0.5)] {
        for (eye, light) in directions {
            let scene = floor(clay(albedo as f32, roughness as f32), eye, Some(light));
            let settings = Settings { depth: 1, reflections: 2, ..toy::audited(1) };
            let finished = toy::render(&scene, &settings, 1).remove(0);
            assert_eq!(toy::differing(&finished), 0);
            // half a pixel off the middle
            let found = f64::from(toy::color(&finished, 48, 36).y);
            let wanted = shown(albedo, roughness, eye, light);
            assert!(
                (found - wanted).abs() < 0.012 * wanted + 1e-3,
                "{albedo} {roughness} {eye} {light}: {found}, not {wanted}"
            );
            assert_eq!(toy::pixel(&finished, "specular.G", 48, 36), 0.0, "it is no highlight");
        }
    }
}

/// In even light white stays white, and what is coloured is as dark as its light is scattered often.
#[test]
fn even_light_is_shown_by_the_colour() {
    for (albedo, roughness) in [(1.0, 1.0), (0.5, 1.0), (0.5, 0.3)] {
        let eye = DVec3::new(1.0, 1.0, 0.0);
        let mut scene = floor(clay(albedo as f32, roughness as f32), eye, None);
        scene.background = Background::uniform(Vec3::ONE);
        scene.environment = Some(Environment::from_background(&scene.background));
        let finished = toy::render(&scene, &Settings { paths: 64, ..toy::audited(1) }, 1).remove(0);
        assert_eq!(toy::differing(&finished), 0);
        let dims = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * roughness);
        let mean = dims * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * roughness);
        let (first, again) =
            (once(roughness, eye.normalize().y), albedo * mean / (1.0 - albedo * (1.0 - mean)));
        let wanted = albedo * (first + again * (1.0 - first));
        let found = f64::from(toy::color(&finished, 48, 36).y);
        assert!((found - wanted).abs() < 0.02, "{albedo} {roughness}: {found}, not {wanted}");
    }
}

/// Whatever moves: what stays is what would be made anew.
#[test]
fn an_audit_finds_nothing() {
    let mut scene = world();
    let varnish = Coat { weight: 1.0, roughness: 0.0, index: 1.5, tint: Vec3::ONE, darkening: 0.0 };
    scene.materials[0] = clay(0.4, 0.8);
    scene.materials[1] = Material {
        coat: Some(varnish),
        diffuse_roughness: 1.0,
        metal_edge: 0.0,
        ..metal_rough(0.6, 0.4, 0.4)
    };
    let settings = Settings { paths: 2, reflections: 2, depth: 3, ..toy::settings(1) };
    expect_nothing_found(&scene, &CHANGES, &settings);
}
