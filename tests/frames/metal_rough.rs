//! Are metal-rough surfaces right, and is what stays of them in a picture what would be made anew?

use std::f32::consts::{PI, TAU};

use afterimage::frame::{Finished, Renderer};
use afterimage::layers::Layers;
use afterimage::scene::environment::Sky;
use afterimage::scene::look::Look;
use afterimage::scene::material::{MetalRough, Optics};
use afterimage::scene::{Background, Environment, LightKind, Material, Panel, Scene, SkyDensity};
use afterimage::settings::{Filter, Settings};
use afterimage::shade::bsdf::fresnel::Fresnel;
use afterimage::shade::bsdf::ggx;
use afterimage::shade::bsdf::{Bsdfs, SeenBy, SurfaceAxes};
use afterimage::stats::FrameStats;
use glam::{DVec3, Vec3};

use crate::changing::{Change, camera_goes, lamp_goes, under_a_sky, with_metal_flyer};
use crate::toy;
use crate::toy::worlds::*;

/// A metal-rough material of the base colour `base`.
pub fn metal_rough(base: f32, roughness: f32, metallic: f32) -> Material {
    let base = Vec3::splat(base);
    let metal_rough = MetalRough { base, roughness, metallic, head_on: 0.04, solid: 1.0 };
    Material {
        diffuse: base * (1.0 - metallic),
        ambient: Vec3::ZERO,
        metal_rough: Some(metal_rough),
        ..Material::fallback()
    }
}

fn settings(reflections: u32) -> Settings {
    Settings { reflections, ..toy::settings(1) }
}

fn audited(reflections: u32) -> Settings {
    Settings { audit: true, ..settings(reflections) }
}

/// The mean of some planes' values, as a colour.
fn mean_of(finished: &Finished, planes: [&str; 3]) -> Vec3 {
    let mean = |plane: &str| {
        let values = finished.film.values(plane).expect("the plane is there");
        values.iter().sum::<f32>() / values.len() as f32
    };
    Vec3::from(planes.map(mean))
}

pub fn reflected(finished: &Finished) -> Vec3 {
    mean_of(finished, ["reflection.R", "reflection.G", "reflection.B"])
}

/// Frame 1 of `scene`.
fn first(scene: &Scene, settings: &Settings) -> Finished {
    toy::render(scene, settings, 1).remove(0)
}

/// What frames `1..=last` cost. Nobody keeps their films, so that each may show what the one before has shown.
fn stats(scene: &Scene, settings: &Settings, last: i32) -> Vec<FrameStats> {
    let mut renderer = Renderer::new(scene, settings).expect("the scene builds");
    (1..=last).map(|frame| renderer.render(frame, true).expect("the frame renders").stats).collect()
}

/// Within an even sky of 1, a white body that nothing else shines on shows no more than 1 anywhere, and hardly less.
#[test]
fn a_white_body_in_a_furnace_is_white() {
    for (roughness, metallic) in
        [(0.0, 1.0), (0.3, 1.0), (0.6, 1.0), (1.0, 1.0), (0.05, 0.0), (0.3, 0.0), (1.0, 0.0)]
    {
        let camera = toy::camera(rests(DVec3::new(0.4, 1.0, 3.0)), rests(DVec3::ZERO));
        let models = vec![toy::still("body", toy::octahedron(0, true), Vec3::ZERO)];
        let mut scene = toy::scene(camera, models, vec![metal_rough(1.0, roughness, metallic)], vec![]);
        scene.background = Background::uniform(Vec3::ONE);
        scene.environment = Some(Environment::from_background(&scene.background));
        let finished = first(&scene, &Settings { paths: 16, ..audited(64) });
        let alpha = finished.film.values("object.V").expect("the plane is there");
        let colors = finished.film.values("G").expect("the plane is there");
        let body: Vec<f32> = colors
            .iter()
            .zip(&alpha)
            .filter(|(_, object)| **object == 1.0)
            .map(|(color, _)| *color)
            .collect();
        let mean = body.iter().sum::<f32>() / body.len() as f32;
        let most = body.iter().copied().fold(0.0, f32::max);
        let name = format!("roughness {roughness}, metal {metallic}: mean {mean}, most {most}");
        assert!(body.len() > 500 && mean > 0.98 && mean < 1.005, "{name}");
        // sixty-four rays of a rough surface differ
        assert!(most < 1.15, "{name}");
        assert_eq!(toy::differing(&finished), 0);
    }
}

/// Between surfaces that reflect each other, light that bounces too often is left out, and none is made.
#[test]
fn no_light_is_made_in_a_corner() {
    for (roughness, metallic) in [(0.3, 1.0), (0.8, 1.0), (0.3, 0.0), (0.8, 0.5)] {
        let mut scene = solid_world(vec![metal_rough(1.0, roughness, metallic); 3]);
        scene.background = Background::uniform(Vec3::ONE);
        scene.environment = Some(Environment::from_background(&scene.background));
        let settings = Settings { paths: 16, bounces: 6, depth: 6, ..settings(16) };
        let mean = mean_of(&first(&scene, &settings), ["R", "G", "B"]).y;
        assert!(mean > 0.95 && mean < 1.003, "roughness {roughness}, metal {metallic}: {mean}");
    }
}

/// Dark but for a few bright texels.
fn patchy() -> Environment {
    let texel = |i: usize| if i % 97 == 5 { [9.0, 3.0, 1.0] } else { [0.1, 0.1, 0.2] };
    Environment::from_picture(64, 32, (0..64 * 32).flat_map(texel).collect()).expect("it is good")
}

/// What rough metal reflects of the light of a direction, seen from `to_eye`, Y up: once, and by as much more as the layer says that it
/// reflects several times.
fn of_metal(roughness: f32, base: f32, to_eye: Vec3) -> impl Fn(Vec3) -> Vec3 {
    const STEPS: usize = 64;
    let turned = |v: Vec3| Vec3::new(v.z, v.x, v.y);
    let material = metal_rough(base, roughness, 1.0);
    let alpha = material.metal_rough.expect("it has a layer").alpha();
    let (fresnel, to_eye) = (Fresnel::of_metal(Vec3::splat(base)), turned(to_eye));
    let place = |step: usize| (step as f32 + 0.5) / STEPS as f32;
    let once = (0..STEPS * STEPS).map(|step| {
        let to_light = ggx::sample(alpha, to_eye, [place(step / STEPS), place(step % STEPS)]);
        ggx::sample_weight(alpha, &fresnel, to_eye, to_light).x
    });
    let once = once.sum::<f32>() / (STEPS * STEPS) as f32;
    let seen = Bsdfs::new(&[material]).seen(
        Look::plain(0),
        Vec3::ZERO,
        SurfaceAxes::of_normals([Vec3::Z; 2]),
        -to_eye,
        SeenBy::Eye,
    );
    let several_times = seen.expect("it has a layer").albedo / once;
    move |direction| ggx::reflected(alpha, &fresnel, to_eye, turned(direction)) * several_times
}

/// The [world](world) of these materials, none of which is glass.
pub fn solid_world(materials: Vec<Material>) -> Scene {
    let mut scene = world();
    scene.models[3] = toy::still("solid", toy::octahedron(2, true), Vec3::new(2.3, 1.0, 1.0));
    scene.materials = materials;
    scene.lights.clear();
    scene.ambient = Vec3::ZERO;
    scene
}

/// An open floor of rough metal reflects a sky, a sun of half a degree included, as the integral over the sky says: rays to
/// the sky's bright places and rays that follow the roughness are weighed rightly.
#[test]
fn a_metal_floor_reflects_the_sky_as_its_integral_says() {
    for (roughness, environment) in [
        (0.45, Environment::from_sky(&Sky::default())),
        (0.7, Environment::from_sky(&Sky::default())),
        (0.4, patchy()),
    ] {
        let camera = toy::camera(rests(DVec3::new(0.0, 300.0, 400.0)), rests(DVec3::ZERO));
        let models = vec![toy::still("floor", toy::floor(4000.0, 0), Vec3::ZERO)];
        let base = 0.5;
        let mut scene = toy::scene(camera, models, vec![metal_rough(base, roughness, 1.0)], vec![]);
        let to_eye = Vec3::new(0.0, 0.6, 0.8);
        let light = of_metal(roughness, base, to_eye);
        let sun =
            environment.sun().map_or(Vec3::ZERO, |sun| sun.radiance * sun.solid_angle() * light(sun.to_sun));
        const STEPS: usize = 1200;
        let mut from_grid = Vec3::ZERO;
        for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS / 4).map(move |j| (i, j))) {
            let (turn, up) = ((i as f32 + 0.5) / STEPS as f32, (j as f32 + 0.5) / (STEPS / 4) as f32);
            let ((sin, cos), across) = ((TAU * turn).sin_cos(), (1.0 - up * up).sqrt());
            let direction = Vec3::new(across * sin, up, across * cos);
            from_grid += environment.grid_light(SkyDensity::Whole, direction).radiance * light(direction);
        }
        let expected = sun + from_grid * TAU / (STEPS * STEPS / 4) as f32;
        scene.environment = Some(environment);
        let finished = first(&scene, &audited(64));
        let seen =
            (33..40).flat_map(|y| (45..52).map(move |x| (x, y))).map(|(x, y)| toy::color(&finished, x, y));
        let seen: Vec<Vec3> = seen.collect();
        let mean = seen.iter().sum::<Vec3>() / seen.len() as f32;
        let ratio = mean / expected;
        assert!(ratio.min_element() > 0.98 && ratio.max_element() < 1.02, "{roughness}: {mean}, {expected}");
        let most = seen.iter().copied().fold(Vec3::ZERO, Vec3::max);
        assert!((most / mean).max_element() < 1.5, "no sparks: {roughness}: {most}, {mean}");
        assert_eq!(toy::differing(&finished), 0);
    }
}

/// Rays to the sky and rays that follow the roughness add up to the same light as the latter alone.
#[test]
fn both_ways_to_the_sky_add_up() {
    let materials = [metal_rough(0.8, 0.6, 0.0), metal_rough(0.9, 0.5, 1.0), metal_rough(0.9, 0.2, 1.0)];
    let mut scene = solid_world(materials.to_vec());
    scene.background = Background { zenith: Vec3::ONE, horizon: Vec3::splat(0.5), ground: Vec3::ZERO };
    let alone = reflected(&first(&scene, &settings(64)));
    scene.environment = Some(Environment::from_background(&scene.background));
    let both = reflected(&first(&scene, &settings(64)));
    assert!(alone.min_element() > 0.02, "or it is too dark to tell: {alone}");
    assert!((both / alone - Vec3::ONE).abs().max_element() < 0.01, "{both}, {alone}");
}

/// A directional light of power 1 is one of which a white surface reflects 1: pi times the reflectance reaches the eye.
#[test]
fn highlights_are_as_bright_as_the_formula_says() {
    let camera = toy::camera(rests(DVec3::new(0.0, 300.0, 400.0)), rests(DVec3::ZERO));
    let models = vec![toy::still("floor", toy::floor(4000.0, 0), Vec3::ZERO)];
    for roughness in [0.2, 0.4] {
        for to_light in [DVec3::new(0.0, 0.6, -0.8), DVec3::new(0.3, 0.9, -0.3).normalize()] {
            let kind = LightKind::Directional { direction: rests(-to_light) };
            let lights = vec![toy::light("sun", kind, 2.0)];
            let materials = vec![metal_rough(0.5, roughness, 1.0)];
            let scene = toy::scene(camera.clone(), models.clone(), materials, lights);
            let finished = first(&scene, &Settings { depth: 0, ..settings(4) });
            let seen =
                [toy::pixel(&finished, "specular.R", 48, 36), toy::pixel(&finished, "reflection.R", 48, 36)];
            let point = Vec3::from(["P.X", "P.Y", "P.Z"].map(|plane| toy::pixel(&finished, plane, 48, 36)));
            let to_eye = (Vec3::new(0.0, 300.0, 400.0) - point).normalize();
            let expected = 2.0 * PI * of_metal(roughness, 0.5, to_eye)(to_light.as_vec3()).x;
            assert!(
                seen[0] / expected > 0.99 && seen[0] / expected < 1.01,
                "{roughness}: {seen:?}, {expected}"
            );
            assert_eq!(seen[1], 0.0, "no rays go on with a depth of 0");
        }
    }
}

/// Lights that have a size show highlights and are seen by rays: both together bring what highlights alone bring.
#[test]
fn a_light_with_a_size_is_counted_once() {
    for (roughness, size) in [(0.5, 2.0), (0.3, 2.0), (0.8, 4.0)] {
        let camera = toy::camera(rests(DVec3::new(0.0, 3.0, 4.0)), rests(DVec3::ZERO));
        let models = vec![toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO)];
        let kind =
            LightKind::Rectangle(Panel::at_rest(DVec3::new(0.0, 3.0, -3.0), DVec3::ZERO, [size, size]));
        let materials = vec![metal_rough(0.8, roughness, 1.0)];
        let mut scene = toy::scene(camera, models, materials, vec![toy::light("panel", kind, 20.0)]);
        scene.background = Background::uniform(Vec3::ZERO);
        let by = |depth| {
            let finished = first(&scene, &Settings { depth, ..settings(16) });
            (mean_of(&finished, ["specular.R"; 3]).x, reflected(&finished).x)
        };
        let ((alone, none), (weighed, by_rays)) = (by(0), by(1));
        assert_eq!(none, 0.0);
        assert!(by_rays > 0.05 * alone && weighed > 0.01 * alone, "{roughness}: {weighed}, {by_rays}");
        let ratio = (weighed + by_rays) / alone;
        assert!((ratio - 1.0).abs() < 0.02, "{roughness}: {weighed} + {by_rays}, {alone}");
    }
}

/// A metal without roughness is a mirror that turns white at grazing angles, and costs one ray.
#[test]
fn a_smooth_metal_is_a_mirror() {
    let shown = |material: Material| {
        let mut scene = world();
        scene.materials[1] = Material { ambient: Vec3::ZERO, ..material };
        scene.lights.clear();
        first(&scene, &settings(16))
    };
    let mirror = Optics::Mirror { tint: Vec3::splat(0.7), fresnel: true };
    let mirror = shown(Material { optics: mirror, ..toy::matt(0.0) });
    let metal = shown(metal_rough(0.7, 0.02, 1.0));
    for plane in ["reflection.R", "diffuse.B"] {
        let difference = toy::mean_difference(&mirror, &metal, plane);
        assert!(difference < 2e-4, "{plane}: {difference}");
    }
    assert_eq!(mirror.stats.rays.reflection, metal.stats.rays.reflection);
}

/// More rays bring the same light with less noise, and none bring none.
#[test]
fn the_mean_does_not_depend_on_the_number_of_rays() {
    let mut scene = world();
    scene.materials[1] = metal_rough(0.9, 0.5, 1.0);
    let [few, many] = [1, 32].map(|rays| first(&scene, &Settings { samples: 8, ..settings(rays) }));
    let ratio = reflected(&few) / reflected(&many);
    assert!((ratio - Vec3::ONE).abs().max_element() < 0.02, "{ratio}");
    assert!(many.stats.rays.reflection > 4 * few.stats.rays.reflection);
    let floor = |scene: &Scene| {
        let mut scene = scene.clone();
        scene.models.truncate(1);
        scene.materials[0] = metal_rough(0.9, 0.5, 1.0);
        first(&scene, &settings(0)).stats.rays.reflection
    };
    assert_eq!(floor(&scene), 0);
}

/// What shines on it along paths is right: a floor beside rough metal gets what the metal reflects, be it by rays or
/// evaluated. A wall of metal that is all but matt lights a floor as a matt one does.
#[test]
fn paths_reflect_off_rough_metal() {
    let lit = |material: Material| {
        let wall = toy::mesh(
            &[[-6.0, 0.0, -1.0], [6.0, 0.0, -1.0], [6.0, 8.0, -1.0], [-6.0, 8.0, -1.0]],
            &[[0, 1, 2], [0, 2, 3]],
            1,
            true,
        );
        let camera = toy::camera(rests(DVec3::new(0.0, 3.0, 3.0)), rests(DVec3::new(0.0, 0.0, 0.5)));
        let models =
            vec![toy::still("floor", toy::floor(12.0, 0), Vec3::ZERO), toy::still("wall", wall, Vec3::ZERO)];
        let lamp = toy::light("lamp", LightKind::Point { position: rests(DVec3::new(0.0, 5.0, 5.0)) }, 20.0);
        let mut scene = toy::scene(camera, models, vec![toy::matt(0.5), material], vec![lamp]);
        scene.background = Background::uniform(Vec3::splat(0.5));
        let with = |paths| toy::color(&first(&scene, &Settings { paths, bounces: 2, ..settings(4) }), 48, 30);
        with(256) - with(0)
    };
    let rough = lit(metal_rough(0.9, 1.0, 1.0)).x;
    let smooth = lit(metal_rough(0.9, 0.0, 1.0)).x;
    let matt = lit(toy::matt(0.9)).x;
    let black = lit(toy::matt(0.0)).x;
    assert!(matt > 1.2 * black, "the wall matters: {matt}, {black}");
    // rough metal sends light rather forwards, and smooth metal shows a second lamp
    assert!(rough > 0.8 * matt && rough < 1.25 * matt, "{rough}, {matt}");
    assert!(smooth > 1.05 * black, "{smooth}, {black}");
}

/// The [world](world), but for its materials: a floor of rough plastic, with metal and glass on it, and some plastic that
/// glows.
pub fn rough_world() -> Scene {
    let mut scene = world();
    scene.materials[0] = metal_rough(0.6, 0.4, 0.0);
    scene.materials[1] = metal_rough(0.8, 0.35, 1.0);
    scene.materials.push(metal_rough(0.8, 0.02, 1.0));
    scene.materials.push(Material { emission: Vec3::splat(0.4), ..metal_rough(0.5, 0.7, 0.5) });
    scene.models.push(toy::still("smooth", toy::octahedron(3, true), Vec3::new(-2.6, 0.8, -3.0)));
    scene.models.push(toy::still("glowing", toy::octahedron(4, true), Vec3::new(2.6, 0.6, -3.0)));
    scene.lights.push(panel(rests(DVec3::new(1.0, 5.0, 2.0))));
    scene
}

/// Whatever moves: samples, what they have gathered, and what the film still shows are what would be made anew.
#[test]
fn an_audit_finds_nothing() {
    let changes: [(&str, &[Change]); 7] = [
        ("nothing", &[]),
        ("a flyer", &[with_metal_flyer]),
        ("a flyer under a sky", &[with_metal_flyer, under_a_sky]),
        ("a lamp", &[lamp_goes]),
        ("the camera, under a sky", &[camera_goes, under_a_sky]),
        ("a flyer and the camera", &[with_metal_flyer, camera_goes]),
        (
            "a flyer, a lamp and the camera, under a sky",
            &[with_metal_flyer, lamp_goes, camera_goes, under_a_sky],
        ),
    ];
    for (name, changes) in changes {
        let scene = changes.iter().fold(rough_world(), |scene, change| change(scene));
        for (samples, filter, paths) in [(1, Filter::Box, 3), (2, Filter::Mitchell, 0)] {
            let [width, height] = [80, 60].map(|size| size / samples);
            let settings = Settings { samples, filter, paths, depth: 3, width, height, ..audited(3) };
            for stats in stats(&scene, &settings, FRAMES) {
                let audit = stats.audit.expect("asked for");
                assert_eq!(audit.wrong(), 0, "{name}, frame {}", stats.frame);
            }
        }
    }
}

/// Before a camera at rest rough surfaces stay in the film where nothing moves on the way of their rays, and are made anew
/// where something does.
#[test]
fn what_rough_metal_shows_stays_until_something_moves_there() {
    let rays = |scene: &Scene| {
        let settings = Settings { depth: 2, ..audited(4) };
        let stats = stats(scene, &settings, LAST_BEFORE_MIRROR - 1);
        assert!(stats.iter().all(|stats| stats.audit.expect("asked for").differing == 0));
        stats.iter().map(|stats| stats.rays.reflection).collect::<Vec<_>>()
    };
    let with_flyer_at = |middle| {
        let mut scene = before_a_mirror(middle, seen_in_a_mirror().1);
        scene.materials[0] = metal_rough(0.9, 0.15, 1.0);
        scene
    };
    let before = rays(&with_flyer_at(seen_in_a_mirror().0));
    let is_mirrored = |rays: &u64| (1..before[0] / 20).contains(rays);
    assert!(
        before[2..].iter().all(is_mirrored),
        "in some samples, whose rays alone are cast again: {before:?}"
    );
    // the metal hides it, and what it mirrors is on the other side
    let behind = rays(&with_flyer_at(DVec3::new(0.0, 1.5, -4.0)));
    assert!(behind[2..].iter().all(|rays| *rays == 0), "{behind:?}");
    let behind = under_a_sky(with_flyer_at(DVec3::new(0.0, 1.5, -4.0)));
    let behind = rays(&behind);
    assert!(behind[2..].iter().all(|rays| *rays == 0), "{behind:?}");
}

#[test]
fn threads_change_no_bit() {
    let scene = under_a_sky(camera_goes(with_metal_flyer(rough_world())));
    let render = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        pool.install(|| toy::render(&scene, &Settings { samples: 2, paths: 2, ..settings(3) }, 3))
    };
    for (one, other) in render(1).iter().zip(&render(2)) {
        for plane in &one.film.planes {
            let values = |finished: &Finished| finished.film.values(&plane.name).expect("the plane is there");
            let same = values(one).iter().zip(&values(other)).all(|(a, b)| a.to_bits() == b.to_bits());
            assert!(same, "frame {}, {}", one.stats.frame, plane.name);
        }
    }
}

/// The light that samples keep does not depend on the eye: a camera that moves through a world at rest gathers none anew
/// for what it saw before.
#[test]
fn what_is_kept_does_not_depend_on_the_eye() {
    let mut scene = camera_goes(rough_world());
    // nothing that shows other surfaces, which gather anew
    scene.materials[1] = metal_rough(0.8, 0.35, 0.0);
    scene.materials.iter_mut().for_each(|material| material.optics = Optics::Opaque);
    let mut renderer =
        Renderer::new(&scene, &Settings { paths: 8, depth: 0, ..audited(4) }).expect("it builds");
    let base = renderer.render(1, true).expect("it renders").stats.rays.gathering;
    for frame in 2..=4 {
        let finished = renderer.render(frame, true).expect("it renders");
        assert_eq!(toy::differing(&finished), 0);
        assert!(finished.stats.rays.gathering * 5 < base, "frame {frame}");
    }
}

/// What lies beneath a layer is dimmed in all layers of the picture that tell of it.
#[test]
fn the_parts_of_diffuse_light_add_up() {
    let layers = Layers::parse("diffuse,direct,indirect,emission,background").expect("they are there");
    let finished = first(&rough_world(), &Settings { paths: 3, layers, ..settings(3) });
    let whole = mean_of(&finished, ["diffuse.R", "diffuse.G", "diffuse.B"]);
    let parts = ["direct", "indirect", "emission", "background"];
    let part = |part: &str| {
        mean_of(&finished, ["R", "G", "B"].map(|of| format!("{part}.{of}")).each_ref().map(String::as_str))
    };
    let sum: Vec3 = parts.into_iter().map(part).sum();
    assert!(part("emission").x > 1e-4 && part("indirect").x > 1e-3, "or it is too dark to tell: {sum}");
    assert!((sum / whole - Vec3::ONE).abs().max_element() < 2e-3, "{sum}, {whole}");
}
