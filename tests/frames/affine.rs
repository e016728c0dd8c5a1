//! Models under any affine transform: do they look as they must, and is reuse exact on them?

use afterimage::animation::{Track, TransformTrack};
use std::sync::Arc;

use afterimage::frame::{Finished, Renderer};
use afterimage::scene::{LightKind, Material, Model, Scene};
use afterimage::settings::Settings;
use afterimage::trace::BackendKind;
use glam::{DAffine3, DMat3, DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::*;

/// Shear and a mirror image, as it grows from one to the other.
fn sheared() -> [DAffine3; 2] {
    let first =
        DMat3::from_cols(DVec3::new(-0.7, 0.1, 0.0), DVec3::new(0.5, 0.6, 0.0), DVec3::new(0.0, 0.3, 0.6));
    let last =
        DMat3::from_cols(DVec3::new(-0.4, 0.0, 0.3), DVec3::new(-0.5, 0.9, 0.2), DVec3::new(0.4, -0.2, 0.5));
    let places = [DVec3::new(-2.6, 2.0, 1.5), DVec3::new(1.8, 1.6, 1.0)];
    [DAffine3::from_mat3_translation(first, places[0]), DAffine3::from_mat3_translation(last, places[1])]
}

fn between(maps: [DAffine3; 2]) -> TransformTrack {
    let keys = toy::keys(&[(1.0, maps[0]), (f64::from(FRAMES), maps[1])]);
    TransformTrack { matrix: Some(keys), ..TransformTrack::identity() }
}

fn audited(scene: &Scene, settings: &Settings) -> Vec<Finished> {
    let frames = toy::render(scene, &Settings { audit: true, ..settings.clone() }, FRAMES);
    let cells = u64::from(settings.width * settings.height * settings.samples.pow(2));
    for finished in &frames {
        let audit = finished.stats.audit.unwrap();
        assert_eq!(audit.wrong(), 0, "frame {}: {audit:?}", finished.stats.frame);
        assert!(audit.on_edge * 200 < cells, "frame {}: {audit:?}", finished.stats.frame);
    }
    frames
}

#[test]
fn reuse_is_exact_under_shear_and_reflection() {
    let track = between(sheared());
    for frame in 1..=FRAMES {
        assert!(track.map_at(frame.into()).matrix3.determinant() < -0.05, "a mirror image");
    }
    let mut meshes = vec![toy::octahedron(0, true), toy::octahedron(1, true), toy::octahedron(2, false)];
    meshes.extend(toy::quadrics().iter().map(|quadric| {
        toy::moving_quadric("quadric", quadric, 0, TransformTrack::identity()).mesh.as_ref().clone()
    }));
    for mesh in meshes {
        let mut scene = world();
        scene.models.push(toy::moving("sheared", mesh, track.clone()));
        let frames = audited(&scene, &Settings { width: 64, height: 48, ..toy::settings(2) });
        assert!(frames[3].stats.samples.obscured > 0 && frames[3].stats.samples.missed > 0, "it moves");
        let goes = with_camera(scene, goes(EYE, EYE + DVec3::new(0.6, 0.2, -0.8)), rests(TARGET));
        audited(&with_area_lights(goes), &Settings { paths: 2, ..toy::settings(1) });
    }
}

/// Copies that stand still and share their meshes: turned, stretched, mirrored and sheared, of matt, mirroring, clear and glowing
/// surfaces, one of them with a reflection map.
fn with_copies(mut scene: Scene) -> Scene {
    let first = scene.materials.len() as u16;
    scene.materials.push(Material { emission: Vec3::new(2.0, 1.5, 0.5), ..toy::matt(0.3) });
    let turned = DMat3::from_rotation_x(0.4) * DMat3::from_rotation_y(2.0);
    let linear = [turned * DMat3::from_diagonal(DVec3::new(0.7, 0.3, 0.5)), sheared()[0].matrix3];
    for (material, row) in [0, 1, 2, first].into_iter().zip(0..) {
        let mesh = Arc::new(toy::octahedron(material, material != 2));
        for (linear, column) in linear.into_iter().zip(0..) {
            let at = DVec3::new(-3.6 + 2.1 * f64::from(row), 0.8, 3.2 - 4.4 * f64::from(column));
            let matrix = Some(Track::constant(DAffine3::from_mat3_translation(linear, at)));
            let track = TransformTrack { matrix, ..TransformTrack::identity() };
            let reflection_map = (material == 1 && column == 0).then_some(16);
            let copy = toy::moving("copy", toy::octahedron(0, true), track);
            scene.models.push(Model { mesh: Arc::clone(&mesh), reflection_map, ..copy });
        }
    }
    assert_eq!(scene.models.iter().filter(|model| model.is_placed_at_rest()).count(), 8);
    scene
}

#[test]
fn reuse_is_exact_on_copies_at_rest() {
    let scene = with_flyer(with_copies(world()));
    let goes = with_camera(scene.clone(), goes(EYE, EYE + DVec3::new(0.6, 0.2, -0.8)), rests(TARGET));
    let gathering = Settings { paths: 2, ..toy::audited(1) };
    for (scene, settings) in
        [(&scene, toy::audited(2)), (&goes, toy::audited(2)), (&with_area_lights(goes.clone()), gathering)]
    {
        for kind in [BackendKind::Embree, BackendKind::Rust] {
            let [alone, together] = [1, 3].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| {
                    let settings = Settings { audit: threads == 1, ..settings.clone() };
                    let mut renderer = Renderer::with(kind, scene, &settings).unwrap();
                    (1..=FRAMES).map(|frame| renderer.render(frame, true).unwrap()).collect::<Vec<_>>()
                })
            });
            for (a, b) in alone.iter().zip(&together) {
                let audit = a.stats.audit.unwrap();
                assert_eq!(audit.wrong(), 0, "{kind:?}, frame {}: {audit:?}", a.stats.frame);
                assert!(a.film == b.film, "{kind:?}, frame {}", a.stats.frame);
            }
            let shown = alone[3].film.values("object.V").unwrap();
            let is_shown = |model: usize| shown.contains(&(model as f32 + 1.0));
            let copies = scene.models.iter().enumerate().filter(|(_, model)| model.is_placed_at_rest());
            let seen = copies.filter(|(number, _)| is_shown(*number)).count();
            assert!(seen >= 7 && alone[3].stats.samples.good > 1000, "{seen}");
        }
    }
}

/// A square of which a matrix makes a rectangle twice as long and half as wide, in front of a lamp straight above: as bright as
/// the cosine law says on the side that looks up, and black below, whichever way round its corners go.
#[test]
fn surfaces_face_the_way_that_their_normals_say() {
    let lamp = toy::sun_overhead(2.0);
    for sign in [1.0, -1.0] {
        // y = 0 is tilted to y = x / 2: its normal is (-1/2, 1, 0), whatever else is sheared
        let linear = DMat3::from_cols(
            DVec3::new(1.0, 0.5, 0.0),
            DVec3::new(0.3, 1.0, 0.2),
            DVec3::new(0.0, 0.0, sign),
        );
        let maps = [linear, linear * 1.01].map(DAffine3::from_mat3);
        let models = vec![toy::moving("tilted", toy::floor(3.0, 0), between(maps))];
        for (eye, is_lit) in [(4.0, true), (-4.0, false)] {
            let camera = toy::camera(rests(DVec3::new(0.1, eye, 0.0)), rests(DVec3::ZERO));
            let scene = toy::scene(camera, models.clone(), vec![toy::matt(0.5)], vec![lamp.clone()]);
            let shown = toy::color(&audited(&scene, &toy::settings(1))[2], 48, 36).x;
            // Lambert: irradiance times cosine times reflectance, as all lights here count it
            let expected = if is_lit { 2.0 * 0.5 / 1.25_f32.sqrt() } else { 0.0 };
            assert!((shown - expected).abs() < 2e-3, "{shown}, not {expected}");
        }
    }
}

/// A sphere under a matrix is the ellipsoid that its formula says: normals of x^T A x = 1 are A x.
#[test]
fn a_sheared_sphere_is_the_ellipsoid_of_its_formula() {
    let linear =
        DMat3::from_cols(DVec3::new(-1.5, 0.2, 0.0), DVec3::new(0.6, 1.0, 0.0), DVec3::new(0.0, -0.4, 0.8));
    let maps = [linear, linear * 0.9].map(DAffine3::from_mat3);
    let ball = toy::moving_quadric("ball", &toy::sphere(), 0, between(maps));
    let camera = toy::camera(rests(DVec3::new(1.0, 2.0, 5.0)), rests(DVec3::ZERO));
    let white = Material { ambient: Vec3::ZERO, ..toy::matt(1.0) };
    let sun = toy::light("sun", LightKind::Directional { direction: rests(DVec3::NEG_Z) }, 1.0);
    let frame =
        audited(&toy::scene(camera, vec![ball], vec![white], vec![sun]), &toy::settings(1)).swap_remove(0);
    let inverse = linear.inverse();
    let form = inverse.transpose() * inverse;
    let plane = |name: &str| frame.film.values(name).unwrap();
    let ([x, y, z], normals) = (["P.X", "P.Y", "P.Z"].map(plane), ["N.X", "N.Y", "N.Z"].map(plane));
    let mut seen = 0;
    for pixel in (0..x.len()).filter(|pixel| normals[2][*pixel] != 0.0) {
        let at = DVec3::new(x[pixel].into(), y[pixel].into(), z[pixel].into());
        assert!((at.dot(form * at) - 1.0).abs() < 1e-3, "{at}");
        let expected = (form * at).normalize().as_vec3();
        let normal = Vec3::new(normals[0][pixel], normals[1][pixel], normals[2][pixel]);
        assert!(normal.distance(expected) < 5e-3, "{normal}, not {expected}");
        seen += 1;
    }
    assert!(seen > 500, "{seen}");
}

/// A matrix that only turns, scales and moves is what those keys say, to the bit, once it is exact.
#[test]
fn a_matrix_is_what_other_keys_say() {
    let turned = TransformTrack {
        translate: goes(DVec3::new(-2.0, 2.0, 1.5), DVec3::new(2.0, 1.0, 1.5)),
        rotate: rests(DVec3::new(0.0, 0.0, 90.0)),
        scale: goes(DVec3::new(0.5, 0.75, 0.5), DVec3::new(1.0, 0.5, 0.25)),
        ..TransformTrack::identity()
    };
    let maps = [1.0, f64::from(FRAMES)].map(|frame| turned.map_at(frame));
    for frame in 1..=FRAMES {
        let (a, b) = (turned.map_at(frame.into()), between(maps).map_at(frame.into()));
        assert!(a.abs_diff_eq(b, 1e-12), "{a}, {b}");
    }
    // and it is applied before them
    let halved = TransformTrack {
        matrix: Some(Track::constant(DAffine3::from_scale(DVec3::new(0.5, 0.5, -0.5)))),
        ..turned.clone()
    };
    let scaled = TransformTrack {
        scale: turned.scale.clone().map(|scale| scale * DVec3::new(0.5, 0.5, -0.5)),
        ..turned
    };
    assert!(halved.map_at(3.0).abs_diff_eq(scaled.map_at(3.0), 1e-12));
}
