//! Quadrics and planes: do they look as formulas say, and is reuse exact on them?

use afterimage::animation::{Track, TransformTrack};
use afterimage::frame::{Finished, Renderer, Spoil};
use afterimage::geometry::quadric::QuadricShape;
use afterimage::geometry::{Curved, Quadric};
use afterimage::scene::material::Optics;
use afterimage::scene::{Background, LightKind, Material, Model, Scene};
use afterimage::settings::{Filter, Settings};
use afterimage::trace::BackendKind;
use glam::{DAffine3, DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::*;
use crate::toy::{color, pixel, quadrics, sphere};

const CELLS: u64 = 64 * 48 * 4;

fn small() -> Settings {
    Settings { width: 64, height: 48, ..toy::settings(2) }
}

/// All frames of `scene` by `settings`, of which none may have a sample that differs, and the share of those that were
/// reused in the inferred ones.
fn audited_with(scene: &Scene, settings: &Settings) -> (Vec<Finished>, f64) {
    let frames = toy::render(scene, &Settings { audit: true, ..settings.clone() }, FRAMES);
    let mut reused = 0;
    for frame in &frames {
        let (audit, samples) = (frame.stats.audit.unwrap(), frame.stats.samples);
        assert_eq!(audit.checked, CELLS, "frame {}", frame.stats.frame);
        assert_eq!(audit.wrong(), 0, "frame {}: {audit:?}", frame.stats.frame);
        assert!(audit.on_edge * 200 < CELLS, "frame {}: {audit:?}", frame.stats.frame);
        reused += samples.good + samples.overlapped;
    }
    let share = reused as f64 / (CELLS * (FRAMES as u64 - 1)) as f64;
    (frames, share)
}

fn audited(scene: &Scene) -> (Vec<Finished>, f64) {
    audited_with(scene, &small())
}

/// Matt, a mirror and glass.
fn materials() -> Vec<Material> {
    let mirror = Optics::Mirror { tint: Vec3::splat(0.7), fresnel: true };
    let glass = Optics::clear(Vec3::ONE, 1.5, Vec3::ONE);
    vec![
        toy::matt(0.6),
        Material { optics: mirror, specular: Vec3::splat(0.5), shininess: 40.0, ..toy::matt(0.2) },
        Material { optics: glass, ..toy::matt(0.0) },
    ]
}

/// A matt one, a mirror and one of glass of a quadric on an endless plane, each turned in its own way.
fn world(quadric: &Quadric) -> Scene {
    let plane = Quadric::new(QuadricShape::Plane { center: [0.0; 2], reach: 1e6 }, false);
    let at = |x: f64, z: f64, turn: f64, scale: DVec3| {
        DAffine3::from_translation(DVec3::new(x, 1.1, z))
            * DAffine3::from_axis_angle(DVec3::new(1.0, 0.5, 0.2).normalize(), turn)
            * DAffine3::from_scale(scale)
            * DAffine3::from_translation(DVec3::NEG_Y * 0.5)
    };
    let still =
        |name, material: u16, place| toy::still_quadric(name, quadric, material, material != 2, place);
    let models = vec![
        toy::still_quadric("plane", &plane, 0, true, DAffine3::IDENTITY),
        still("matt", 0, at(-2.0, 0.0, 0.3, DVec3::new(1.0, 0.8, 0.6))),
        still("mirror", 1, at(0.3, -1.5, -0.9, DVec3::ONE)),
        still("glass", 2, at(2.3, 1.0, 1.8, DVec3::new(-0.8, 0.8, 1.0))),
    ];
    let sun = LightKind::Directional { direction: rests(DVec3::new(-0.5, -1.0, -0.3)) };
    let lights = vec![toy::light("sun", sun, 0.6), lamp(2.0, 4.0, 3.0)];
    let mut scene = toy::scene(toy::camera(rests(EYE), rests(TARGET)), models, materials(), lights);
    scene.ambient = Vec3::splat(0.1);
    scene
}

/// Adds a quadric that flies through the picture, turning and stretching.
fn with_flying(mut scene: Scene, quadric: &Quadric) -> Scene {
    let track = TransformTrack {
        translate: goes(DVec3::new(-3.0, 2.0, 1.5), DVec3::new(2.0, 1.5, 1.0)),
        rotate: goes(DVec3::ZERO, DVec3::new(20.0, 90.0, 0.0)),
        scale: goes(DVec3::splat(0.5), DVec3::new(0.5, 0.7, 0.4)),
        ..TransformTrack::identity()
    };
    scene.models.push(toy::moving_quadric("flyer", quadric, 0, track));
    scene
}

fn dolly() -> Track<DVec3> {
    goes(EYE, EYE + DVec3::new(1.0, 0.2, -1.5))
}

#[test]
fn every_shape_before_a_moving_camera() {
    for quadric in quadrics() {
        println!("{}", quadric.name());
        let (frames, share) = audited(&with_camera(world(&quadric), dolly(), rests(TARGET)));
        assert!(share > 0.7, "{share}");
        let rays = frames[2].stats.rays;
        assert!(rays.reflection > 0 && rays.refraction > 0 && rays.verification > 0, "{rays:?}");
    }
}

#[test]
fn every_shape_in_flight() {
    for quadric in quadrics() {
        println!("{}", quadric.name());
        let (frames, share) = audited(&with_flying(world(&quadric), &quadric));
        assert!(share > 0.8, "{share}");
        assert!(frames[3].stats.samples.obscured > 0 && frames[3].stats.samples.missed > 0);
    }
}

#[test]
fn everything_moves_at_once_under_soft_lights() {
    for number in [0, 2, 5, 7] {
        let quadric = &quadrics()[number];
        let scene = with_camera(world(quadric), dolly(), goes(TARGET, TARGET + DVec3::Y));
        audited(&with_flying(with_area_lights(scene), quadric));
    }
}

#[test]
fn light_from_all_around_holds_while_quadrics_move() {
    for number in [0, 3, 5] {
        let quadric = &quadrics()[number];
        let settings = Settings { paths: 4, occlusion_radius: 1.0, ..small() };
        let mut scene = with_flying(world(quadric), quadric);
        scene.ambient_is_occluded = true;
        let (frames, _) = audited_with(&scene, &settings);
        let [first, later] = [&frames[0], &frames[3]].map(|frame| frame.stats.rays.gathering);
        assert!(later * 3 < first, "{later} of {first} rays");
    }
}

#[test]
fn a_camera_flies_into_a_sphere_and_below_the_plane() {
    let into = with_camera(world(&quadrics()[0]), goes(EYE, DVec3::new(-2.0, 1.0, 0.0)), rests(TARGET));
    audited(&into);
    let below = with_camera(world(&quadrics()[5]), goes(EYE, DVec3::new(0.5, -3.0, 7.0)), rests(TARGET));
    audited(&below);
}

/// However steeply it goes away towards the horizon, a plane is no edge: nothing but what comes into the picture is traced.
#[test]
fn a_plane_is_no_edge() {
    let mut scene = with_camera(world(&quadrics()[0]), rests(EYE), goes(TARGET, TARGET + DVec3::X * 0.3));
    scene.models.truncate(1);
    let (frames, _) = audited(&scene);
    let traced = toy::traced(&frames[3]);
    assert!(traced * 20 < CELLS, "{traced}");
    // its line against the sky is one, and the camera turns
    assert!(traced > 64, "{traced}");
}

#[test]
fn a_plane_that_moves() {
    let mut scene = world(&quadrics()[1]);
    let plane = Quadric::new(QuadricShape::Plane { center: [0.0; 2], reach: 1e6 }, false);
    let track = TransformTrack {
        translate: goes(DVec3::ZERO, DVec3::new(0.4, 0.3, 0.0)),
        rotate: goes(DVec3::ZERO, DVec3::new(0.0, 0.0, 4.0)),
        ..TransformTrack::identity()
    };
    scene.models[0] = toy::moving_quadric("plane", &plane, 0, track);
    let (frames, _) = audited(&scene);
    let moved = pixel(&frames[3], "forward.U", 32, 46);
    assert!(moved.is_finite() && moved != 0.0, "{moved}");
}

/// A sphere as ground is seen from much nearer than its middle is away: its samples hold all the same.
#[test]
fn the_ground_may_be_a_sphere() {
    let ground = Quadric::new(QuadricShape::Ellipsoid { radii: DVec3::splat(1000.0) }, false);
    let place = DAffine3::from_translation(DVec3::NEG_Y * 1000.0);
    let track = TransformTrack {
        translate: rests(DVec3::NEG_Y * 1000.0),
        rotate: goes(DVec3::ZERO, DVec3::new(0.0, 0.02, 0.0)),
        ..TransformTrack::identity()
    };
    for ground in [
        toy::still_quadric("ground", &ground, 0, true, place),
        toy::moving_quadric("ground", &ground, 0, track),
    ] {
        let mut scene = with_camera(world(&quadrics()[0]), dolly(), rests(TARGET));
        scene.models[0] = ground;
        let (_, share) = audited(&scene);
        assert!(share > 0.6, "{share}");
    }
}

#[test]
fn both_tracers_show_the_same() {
    for quadric in quadrics() {
        let scene = with_flying(world(&quadric), &quadric);
        let [embree, rust] = [BackendKind::Embree, BackendKind::Rust].map(|backend| {
            let settings = Settings { audit: backend == BackendKind::Rust, ..small() };
            let mut renderer = Renderer::with(backend, &scene, &settings).unwrap();
            renderer.render(1, true).unwrap();
            renderer.render(2, true).unwrap()
        });
        assert_eq!(toy::differing(&rust), 0);
        for plane in ["R", "Z", "N.X"] {
            let apart = toy::mean_difference(&embree, &rust, plane);
            assert!(apart < 2e-3, "{}: {plane} {apart}", quadric.name());
        }
    }
}

#[test]
fn an_audit_finds_what_is_spoilt_on_quadrics() {
    for spoil in
        [Spoil::Place, Spoil::Sight, Spoil::Normal, Spoil::Triangle, Spoil::Reflectance, Spoil::Light]
    {
        let mut scene = world(&quadrics()[1]);
        scene.models.truncate(3);
        let mut renderer = Renderer::new(&scene, &toy::audited(2)).unwrap();
        renderer.render(1, true).unwrap();
        let spoilt = renderer.spoil(spoil).unwrap();
        let found = renderer.render(2, true).unwrap().stats.audit.unwrap();
        assert!(spoilt > 50 && found.differing * 10 > spoilt * 9, "{spoil:?}: {spoilt}, {found:?}");
        assert!(found.differing * 10 <= spoilt * 11, "and no others, {spoil:?}: {spoilt}, {found:?}");
    }
}

/// A sphere of radius 1 about the origin, alone before a camera on +Z.
fn alone(distance: f64, materials: Vec<Material>, lights: Vec<afterimage::scene::Light>) -> Scene {
    let camera = toy::camera(rests(DVec3::Z * distance), rests(DVec3::ZERO));
    let model = toy::still_quadric("sphere", &sphere(), 0, true, DAffine3::IDENTITY);
    toy::scene(camera, vec![model], materials, lights)
}

/// The unit line of sight through the centre of a pixel.
fn sight(x: u32, y: u32) -> Vec3 {
    let aside = |at: u32, half: f32| (at as f32 + 0.5 - half) / 36.0 * 30.0_f32.to_radians().tan();
    Vec3::new(aside(x, 48.0), -aside(y, 36.0), -1.0).normalize()
}

/// Where a ray from `from` first meets the unit sphere.
fn meets(from: Vec3, way: Vec3) -> Vec3 {
    let along = from.dot(way);
    from + way * (-along - (along * along - from.length_squared() + 1.0).sqrt())
}

#[test]
fn a_sphere_has_the_place_normal_and_shade_that_formulas_give() {
    let to_sun = DVec3::new(1.0, 2.0, 2.0) / 3.0;
    let sun = LightKind::Directional { direction: rests(-to_sun) };
    let scene = alone(4.0, vec![toy::matt(0.5)], vec![toy::light("sun", sun, 2.0)]);
    let frame = toy::render(&scene, &toy::settings(1), 1).remove(0);
    for (x, y) in [(48, 36), (40, 30), (60, 36), (48, 50), (35, 40)] {
        let point = meets(Vec3::Z * 4.0, sight(x, y));
        let three = |name: &str| {
            Vec3::from_array(["X", "Y", "Z"].map(|axis| pixel(&frame, &format!("{name}.{axis}"), x, y)))
        };
        assert!(three("P").distance(point) < 1e-5, "{} {point}", three("P"));
        assert!(three("N").distance(point) < 1e-3, "{} {point}", three("N"));
        let shade = point.dot(to_sun.as_vec3()).max(0.0);
        assert!((color(&frame, x, y) - Vec3::splat(shade)).abs().max_element() < 2e-3, "{x} {y}");
    }
}

/// What a sphere hides of the picture is a disk: its radius is the tangent of the angle that the sphere fills.
#[test]
fn a_sphere_covers_the_disk_that_formulas_give() {
    let scene = alone(3.0, vec![toy::matt(0.5)], vec![]);
    let settings = Settings { filter: Filter::Box, ..toy::settings(4) };
    let frame = toy::render(&scene, &settings, 1).remove(0);
    let covered = frame.film.values("object.V").unwrap().iter().filter(|model| **model > 0.0).count();
    let radius = (1.0_f32 / 3.0).asin().tan() / 30.0_f32.to_radians().tan() * 36.0;
    let disk = std::f32::consts::PI * radius * radius;
    assert!((covered as f32 / disk - 1.0).abs() < 0.04, "{covered} {disk}");
}

/// A ball of glass before a sky that grows brighter upwards: light is bent where it enters and where it leaves.
#[test]
fn a_ball_of_glass_bends_light_twice() {
    let glass = Optics::clear(Vec3::ONE, 1.5, Vec3::ZERO);
    let mut scene = alone(4.0, vec![Material { optics: glass, ..toy::matt(0.0) }], vec![]);
    scene.background = Background { zenith: Vec3::ONE, horizon: Vec3::splat(0.2), ground: Vec3::splat(0.05) };
    let settings = Settings { depth: 2, ..toy::settings(1) };
    let frame = toy::render(&scene, &settings, 1).remove(0);
    for (x, y) in [(48, 36), (48, 43), (44, 30), (52, 33), (55, 45)] {
        let way = sight(x, y);
        let entry = meets(Vec3::Z * 4.0, way);
        let (inside, first) = bent(way, entry, 1.0 / 1.5);
        let exit = entry - 2.0 * inside.dot(entry) * inside;
        let (outside, second) = bent(inside, -exit, 1.5);
        let expected = scene.background.radiance(outside) * first * second;
        let seen = Vec3::from_array(["R", "G", "B"].map(|c| pixel(&frame, &format!("refraction.{c}"), x, y)));
        assert!((seen / expected - Vec3::ONE).abs().max_element() < 5e-3, "{x} {y}: {seen} {expected}");
    }
}

/// Snell's law and what Fresnel's equations let through; `normal` against the ray.
fn bent(way: Vec3, normal: Vec3, ratio: f32) -> (Vec3, f32) {
    let cos = -way.dot(normal);
    let below = (1.0 - ratio * ratio * (1.0 - cos * cos)).sqrt();
    let parallel = ((cos - ratio * below) / (cos + ratio * below)).powi(2);
    let across = ((ratio * cos - below) / (ratio * cos + below)).powi(2);
    (way * ratio + normal * (ratio * cos - below), 1.0 - 0.5 * (parallel + across))
}

/// Within a sphere that glows evenly light is the same everywhere: the sum of a geometric series. Nothing asks a quadric
/// for light; paths find it.
#[test]
fn a_furnace_is_as_bright_as_the_series_says() {
    let glowing = Material { emission: Vec3::splat(0.5), ..toy::matt(0.6) };
    let mut scene = alone(0.3, vec![glowing], vec![]);
    scene.models[0] =
        toy::still_quadric("furnace", &sphere(), 0, true, DAffine3::from_scale(DVec3::new(1.0, 2.0, 1.5)));
    let settings = Settings { paths: 16, bounces: 2, ..toy::audited(1) };
    let frame = toy::render(&scene, &settings, 1).remove(0);
    let expected: f32 = (0..=3).map(|bounce| 0.5 * 0.6_f32.powi(bounce)).sum();
    for (x, y) in [(5, 5), (48, 36), (90, 60)] {
        assert!((color(&frame, x, y) / expected - Vec3::ONE).abs().max_element() < 3e-3, "{x} {y}");
    }
    assert_eq!(toy::differing(&frame), 0);
}

#[test]
fn quadrics_have_their_own_matte_and_motion() {
    let scene = with_flying(world(&sphere()), &sphere());
    let frames = toy::render(&scene, &toy::settings(2), 3);
    let model = |name: &str| scene.models.iter().position(|model: &Model| model.name == name).unwrap();
    let ids = frames[1].film.values("object.V").unwrap();
    let at =
        ids.iter().position(|id| *id == model("flyer") as f32 + 1.0).expect("it is in the picture") as u32;
    let (x, y) = (at % 96, at / 96);
    assert!(pixel(&frames[1], "forward.U", x, y).abs() > 0.5, "it flies");
    assert!(frames[1].film.planes.iter().any(|plane| plane.name.starts_with("CryptoObject")));
}
