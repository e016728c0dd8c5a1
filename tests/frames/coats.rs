//! Are clear coats seen as they should be, by rays and by paths, and is what stays of them what would be made anew?

use afterimage::frame::Finished;
use afterimage::scene::material::Coat;
use afterimage::scene::{Background, Environment, LightKind, Material, Panel, Scene};
use afterimage::settings::Settings;
use glam::{DVec3, Vec3};

use crate::changing::{camera_goes, under_a_sky, with_metal_flyer};
use crate::metal_rough::{metal_rough, solid_world};
use crate::toy;
use crate::toy::worlds::*;

const VARNISH: Coat = Coat { weight: 1.0, roughness: 0.0, index: 1.5, tint: Vec3::ONE, darkening: 0.0 };

fn coated(coat: Coat, below: Material) -> Material {
    Material { coat: Some(coat), ..below }
}

/// A floor of a material, seen from straight above by a camera at rest.
fn floor_of(material: Material) -> Scene {
    let camera = toy::camera(rests(DVec3::new(0.0, 4.0, 0.001)), rests(DVec3::ZERO));
    let models = vec![toy::still("floor", toy::floor(8.0, 0), Vec3::ZERO)];
    toy::scene(camera, models, vec![material], vec![])
}

/// A panel that shines on the middle of the floor.
fn panel() -> LightKind {
    LightKind::Rectangle(Panel::at_rest(DVec3::new(0.0, 3.0, -3.0), DVec3::ZERO, [2.0, 2.0]))
}

fn middle(finished: &Finished) -> Vec3 {
    let around = (44..52).flat_map(|x| (32..40).map(move |y| toy::color(finished, x, y)));
    around.sum::<Vec3>() / 64.0
}

/// Black plastic that is rough, below a varnish: of an even sky the varnish shows what Fresnel's equations say, head-on 4 %, and the
/// plastic as much of what comes through.
#[test]
fn a_smooth_coat_shows_the_sky_above_what_is_rough() {
    for (roughness, tolerance) in [(0.0, 2e-3), (0.3, 4e-3)] {
        let plastic = metal_rough(0.0, 0.6, 0.0);
        let mut scene = floor_of(coated(Coat { roughness, ..VARNISH }, plastic.clone()));
        scene.background = Background::uniform(Vec3::ONE);
        scene.environment = Some(Environment::from_background(&scene.background));
        let settings = Settings { reflections: 64, paths: 4, ..toy::audited(1) };
        let [with, without] = [scene, {
            let mut plain = floor_of(plastic);
            plain.background = Background::uniform(Vec3::ONE);
            plain.environment = Some(Environment::from_background(&plain.background));
            plain
        }]
        .map(|scene| toy::render(&scene, &settings, 1).remove(0));
        let below = middle(&without).y;
        let expected = 0.04 + 0.96 * below;
        let found = middle(&with).y;
        assert!((found - expected).abs() < tolerance, "{roughness}: {found}, not {expected}");
        assert_eq!(toy::differing(&with), 0);
    }
}

/// A panel, which a coat shows once, whether rays, paths or highlights show it: as depth 0, by highlights alone, a rough coat does; and a
/// varnish, of which rays alone show it, has as much light as a coat that is hardly rough.
#[test]
fn coats_show_lights_with_a_size_once() {
    let shown = |coat: Coat, depth: u32| {
        let camera = toy::camera(rests(DVec3::new(0.0, 3.0, 4.0)), rests(DVec3::ZERO));
        let models = vec![toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO)];
        let materials = vec![coated(coat, metal_rough(0.8, 0.5, 1.0))];
        let mut scene = toy::scene(camera, models, materials, vec![toy::light("panel", panel(), 20.0)]);
        scene.background = Background::uniform(Vec3::ZERO);
        let settings = Settings { depth, reflections: 32, ..toy::audited(4) };
        let finished = toy::render(&scene, &settings, 1).remove(0);
        assert_eq!(toy::differing(&finished), 0);
        let all = finished.film.values("G").expect("the plane is there");
        all.iter().sum::<f32>() / all.len() as f32
    };
    let rough = Coat { roughness: 0.4, tint: Vec3::splat(0.5), ..VARNISH };
    let [alone, shared] = [0, 1].map(|depth| shown(rough, depth));
    assert!((shared / alone - 1.0).abs() < 0.02, "{alone} {shared}");
    let [varnish, hardly_rough] = [0.0, 0.08].map(|roughness| shown(Coat { roughness, ..VARNISH }, 1));
    let without = shown(Coat { weight: 0.001, ..VARNISH }, 1);
    assert!((varnish / hardly_rough - 1.0).abs() < 0.02, "{varnish} {hardly_rough}");
    assert!((varnish / without - 1.0).abs() > 0.002, "the coat is seen: {varnish} {without}");
}

/// A white body stays white below any clear coat, in a white furnace.
#[test]
fn a_coated_body_in_a_furnace_is_white() {
    for (roughness, below, metallic) in [(0.0, 0.4, 1.0), (0.3, 0.0, 1.0), (0.4, 0.5, 0.0), (0.0, 0.3, 0.0)] {
        let coat = Coat { roughness, darkening: 1.0, ..VARNISH };
        let camera = toy::camera(rests(DVec3::new(0.4, 1.0, 3.0)), rests(DVec3::ZERO));
        let models = vec![toy::still("body", toy::octahedron(0, true), Vec3::ZERO)];
        let materials = vec![coated(coat, metal_rough(1.0, below, metallic))];
        let mut scene = toy::scene(camera, models, materials, vec![]);
        scene.background = Background::uniform(Vec3::ONE);
        scene.environment = Some(Environment::from_background(&scene.background));
        let settings = Settings { paths: 16, reflections: 64, ..toy::audited(1) };
        let finished = toy::render(&scene, &settings, 1).remove(0);
        let object = finished.film.values("object.V").expect("the plane is there");
        let colors = finished.film.values("G").expect("the plane is there");
        let body: Vec<f32> = colors
            .iter()
            .zip(&object)
            .filter(|(_, object)| **object == 1.0)
            .map(|(color, _)| *color)
            .collect();
        let mean = body.iter().sum::<f32>() / body.len() as f32;
        assert!((0.97..1.005).contains(&mean), "{roughness} {below} {metallic}: {mean}");
        assert_eq!(toy::differing(&finished), 0);
    }
}

/// A flyer, a camera that goes, and coats of all kinds on the floor and the walls: what is kept is what would be made anew.
#[test]
fn reuse_is_exact_below_coats() {
    let tint = Vec3::new(0.9, 0.6, 0.3);
    for (coat, below) in [
        (VARNISH, metal_rough(0.6, 0.4, 1.0)),
        (Coat { roughness: 0.3, tint, ..VARNISH }, metal_rough(0.6, 0.0, 1.0)),
        (Coat { roughness: 0.5, weight: 0.5, darkening: 1.0, ..VARNISH }, metal_rough(0.6, 0.3, 0.0)),
    ] {
        let mut scene = under_a_sky(camera_goes(with_metal_flyer(solid_world(vec![coated(coat, below); 3]))));
        scene.lights.push(toy::light("panel", panel(), 20.0));
        let settings = Settings { reflections: 3, paths: 2, ..toy::audited(1) };
        let finished = toy::render(&scene, &settings, 4);
        for (frame, finished) in (1..).zip(&finished) {
            assert_eq!(toy::differing(finished), 0, "frame {frame}: {coat:?}");
        }
        assert!(finished[3].stats.samples.reused() > 1_000);
    }
}
