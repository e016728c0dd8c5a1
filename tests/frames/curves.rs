//! Curves: do they cover what formulas say, is light around fibres of hair what it must be, and is reuse exact on them?

use afterimage::animation::TransformTrack;
use afterimage::frame::Renderer;
use afterimage::geometry::Curves;
use afterimage::scene::material::{Hair, MetalRough, Optics};
use afterimage::scene::{
    Background, Environment, LightKind, Material, Mesh, Panel, RayKind, RayKinds, Scene,
};
use afterimage::settings::Settings;
use afterimage::trace::BackendKind;
use glam::{DAffine3, DVec3, Vec3};

use crate::changing::{CHANGES, expect_nothing_found};
use crate::toy;
use crate::toy::worlds::*;

pub fn hair(color: Vec3, roughness: f32) -> Material {
    let layer = MetalRough { base: color, roughness: 1.0, metallic: 1.0, head_on: 0.0, solid: 1.0 };
    let fibres =
        Hair { roughness, radial_roughness: 0.3, coat: 0.0, index: 1.55, offset: 2.0_f32.to_radians() };
    Material {
        diffuse: Vec3::ZERO,
        ambient: Vec3::ZERO,
        metal_rough: Some(layer),
        hair: Some(fibres),
        ..toy::matt(0.0)
    }
}

/// The world with tufts of hair and cords, one of which flies.
fn hairy() -> Scene {
    let mut scene = world();
    scene.materials.push(hair(Vec3::new(0.7, 0.4, 0.2), 0.3));
    let number = scene.materials.len() as u16 - 1;
    let at = |x: f64, z: f64, scale: DVec3| {
        DAffine3::from_translation(DVec3::new(x, 0.0, z)) * DAffine3::from_scale(scale)
    };
    scene.models.push(toy::still_curves("hair", &toy::tuft(false), number, at(-0.5, 1.8, DVec3::ONE)));
    scene.models.push(toy::still_curves(
        "matt",
        &toy::tuft(false),
        0,
        at(1.4, 2.2, DVec3::new(1.0, 0.6, 0.7)),
    ));
    scene.models.push(toy::still_curves("cords", &toy::tuft(true), number, at(-2.5, 2.0, DVec3::splat(0.7))));
    scene.models.push(toy::still_curves("balls", &toy::balls(), 0, at(0.4, 2.6, DVec3::splat(0.8))));
    let track = TransformTrack {
        translate: goes(DVec3::new(-1.5, 1.2, 2.0), DVec3::new(0.5, 1.5, 2.5)),
        rotate: goes(DVec3::ZERO, DVec3::new(20.0, 60.0, 0.0)),
        scale: goes(DVec3::splat(0.5), DVec3::new(0.5, 0.7, 0.4)),
        ..TransformTrack::identity()
    };
    scene.models.push(toy::moving("flyer", Mesh::of_curved(toy::tuft(false), number, true), track));
    scene
}

#[test]
fn an_audit_finds_nothing() {
    let settings = Settings { paths: 2, reflections: 2, depth: 3, ..toy::settings(1) };
    expect_nothing_found(&hairy(), &CHANGES, &settings);
}

#[test]
fn an_audit_of_the_tracer_in_rust_finds_nothing() {
    let scene = CHANGES[1].iter().fold(hairy(), |scene, change| change(scene));
    let settings = Settings {
        paths: 2,
        reflections: 2,
        depth: 3,
        audit: true,
        width: 80,
        height: 60,
        ..toy::settings(1)
    };
    let mut renderer = Renderer::with(BackendKind::Rust, &scene, &settings).unwrap();
    for frame in 1..=4 {
        let finished = renderer.render(frame, true).unwrap();
        assert_eq!(toy::differing(&finished), 0, "frame {frame}");
    }
}

/// How far the curves of a row lean aside, for each unit that they rise.
const LEAN: f32 = 0.37;

/// A row of curves that lean aside, each of this radius, before a black sky.
fn row(radius: f32, material: Material) -> Scene {
    let mut points = Vec::new();
    for curve in 0..80 {
        let x = (curve as f32 - 39.5) * 0.1;
        points.extend((0..3).map(|at| 4.0 * at as f32 - 4.0).map(|y| [x + LEAN * y, y, 0.0, radius]));
    }
    let curves = Curves::new(&points, &[3; 80], &[]).expect("they have a length").0;
    let models = vec![toy::moving("row", Mesh::of_curved(curves, 0, true), TransformTrack::identity())];
    let camera = toy::camera(rests(DVec3::Z * 30.0), rests(DVec3::ZERO));
    let mut scene = toy::scene(camera, models, vec![material], vec![]);
    scene.background = Background::uniform(Vec3::ZERO);
    scene
}

/// Share of the middle of the picture that hairs far thinner than a pixel cover: that of their width in the distance between them.
#[test]
fn thin_curves_cover_what_they_are_wide() {
    for radius in [0.002, 0.01, 0.03] {
        let settings = Settings { width: 8, height: 6, samples: 16, ..toy::settings(16) };
        let glowing = Material { emission: Vec3::ONE, ..toy::matt(0.0) };
        let mut scene = row(radius, glowing);
        // a pixel is as wide as all the distances between some hairs
        scene.camera = toy::camera(rests(DVec3::Z * 8.0), rests(DVec3::ZERO));
        let finished = toy::render(&scene, &Settings { audit: true, ..settings }, 1).remove(0);
        assert_eq!(toy::differing(&finished), 0);
        let middle = (0..6).map(|at| toy::pixel(&finished, "G", 2 + at % 3, 2 + at / 3)).sum::<f32>() / 6.0;
        // along the row they are wider than across themselves
        let wanted = 2.0 * radius / 0.1 * (1.0 + LEAN * LEAN).sqrt();
        assert!((middle / wanted - 1.0).abs() < 0.06, "{radius}: {middle} for {wanted}");
    }
}

/// Hair that absorbs nothing shows as much light as is all around it, whichever of samples, paths or lights bring it.
#[test]
fn white_hair_vanishes_in_a_furnace() {
    let mut scene = row(0.04, hair(Vec3::ONE, 0.4));
    scene.background = Background::uniform(Vec3::ONE);
    scene.environment = Some(Environment::from_background(&scene.background));
    let settings = Settings { paths: 4, bounces: 12, reflections: 8, depth: 12, ..toy::audited(4) };
    let finished = toy::render(&scene, &settings, 1).remove(0);
    assert_eq!(toy::differing(&finished), 0);
    let (object, green) = (finished.film.values("object.V").unwrap(), finished.film.values("G").unwrap());
    let whole: Vec<f32> =
        object.iter().zip(green).filter(|(object, _)| **object == 1.0).map(|(_, green)| green).collect();
    assert!(whole.len() > 30, "{}", whole.len());
    let mean = whole.iter().sum::<f32>() / whole.len() as f32;
    assert!((mean - 1.0).abs() < 0.03, "{mean}");
}

/// A panel behind hair shines through it, once, whether highlights, paths or both bring its light.
#[test]
fn lights_behind_hair_shine_through_it_once() {
    let shown = |depth: u32, z: f64| {
        let mut scene = row(0.04, hair(Vec3::new(0.9, 0.7, 0.5), 0.4));
        let panel = Panel::at_rest(DVec3::new(0.0, 3.0, z), DVec3::ZERO, [2.0, 2.0]);
        scene.lights.push(toy::light("panel", LightKind::Rectangle(panel), 200.0));
        let settings = Settings { depth, reflections: 64, ..toy::audited(4) };
        let finished = toy::render(&scene, &settings, 1).remove(0);
        assert_eq!(toy::differing(&finished), 0);
        let green = finished.film.values("G").unwrap();
        green.iter().sum::<f32>() / green.len() as f32
    };
    for z in [-4.0, 4.0] {
        let [alone, shared] = [0, 1].map(|depth| shown(depth, z));
        assert!(alone > 0.001, "{z}: {alone}");
        // paths bring what goes on from hair to hair as well
        assert!(shared > 0.97 * alone && shared < 1.8 * alone, "{z}: {alone} {shared}");
    }
}

/// Hair that a mirror shows is lit as hair that the eye sees from where the mirror image of it is.
#[test]
fn hair_in_a_mirror_is_lit_as_before_it() {
    let sun = LightKind::Directional { direction: rests(DVec3::new(0.3, -0.1, -1.0)) };
    let shown = |is_mirrored: bool| {
        let mut tuft =
            toy::still_curves("tuft", &toy::tuft(true), 0, DAffine3::from_translation(DVec3::Y * 0.3));
        let side = if is_mirrored { 1.0 } else { -1.0 };
        let camera = toy::camera(rests(DVec3::new(0.0, side * 2.0, 6.0)), rests(DVec3::new(0.0, -side, 0.0)));
        let mut models = Vec::new();
        if is_mirrored {
            tuft.ray_visibility.hidden_from = RayKinds::NONE.with(RayKind::Camera);
            models.push(toy::still("mirror", toy::floor(20.0, 1), Vec3::ZERO));
        }
        models.push(tuft);
        let optics = Optics::Mirror { tint: Vec3::ONE, fresnel: false };
        let materials = vec![
            hair(Vec3::new(0.8, 0.5, 0.2), 0.4),
            Material { optics, diffuse: Vec3::ZERO, ..toy::matt(0.0) },
        ];
        let mut scene = toy::scene(camera, models, materials, vec![toy::light("sun", sun.clone(), 2.0)]);
        scene.background = Background::uniform(Vec3::ZERO);
        let finished = toy::render(&scene, &Settings { reflections: 0, ..toy::audited(4) }, 1).remove(0);
        assert_eq!(toy::differing(&finished), 0);
        let green = finished.film.values("G").unwrap();
        green.iter().sum::<f32>() / green.len() as f32
    };
    let [mirrored, seen] = [true, false].map(shown);
    assert!(seen > 0.001 && (mirrored / seen - 1.0).abs() < 0.03, "{mirrored} {seen}");
}

/// Frames of a camera that goes keep most of what they have of hair.
#[test]
fn samples_on_hair_are_kept() {
    let scene = with_camera(hairy(), goes(EYE, EYE + DVec3::new(0.1, 0.0, -0.1)), rests(TARGET));
    let frames = toy::render(&scene, &Settings { audit: true, ..toy::settings(2) }, 3);
    let samples = frames[2].stats.samples;
    let kept = (samples.good + samples.overlapped) as f64 / f64::from(96 * 72 * 4);
    assert!(kept > 0.8, "{kept}");
    assert_eq!(toy::differing(&frames[2]), 0);
}
