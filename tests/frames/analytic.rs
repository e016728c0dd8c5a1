//! Is the maths right? Scenes whose pixels can be worked out by hand.

use std::f32::consts::PI;
use std::path::PathBuf;
use std::sync::Arc;

use afterimage::animation::Track;
use afterimage::layers::Layers;
use afterimage::scene::material::Optics;
use afterimage::scene::texture::Mapping;
use afterimage::scene::{LightKind, Material, Panel, Scene, Texture};
use afterimage::settings::Settings;
use glam::{DVec3, Vec3};

use crate::toy;
use crate::toy::{color, pixel};

/// Looks straight down on the floor from height 4; the picture's top is -Z.
fn from_above(models: Vec<afterimage::scene::Model>, materials: Vec<Material>) -> Scene {
    let camera =
        toy::camera(Track::constant(DVec3::new(0.0, 4.0, 0.0)), Track::constant(DVec3::new(0.0, 0.0, -1e-6)));
    toy::scene(camera, models, materials, vec![toy::sun_overhead(2.0)])
}

fn one(scene: &Scene) -> afterimage::frame::Finished {
    toy::render(scene, &toy::settings(1), 1).remove(0)
}

fn near(a: Vec3, b: Vec3) {
    assert!((a - b).abs().max_element() < 2e-3 * b.max_element().max(1.0), "{a} is not {b}");
}

#[test]
fn a_matt_floor_under_the_sun_reflects_kd_times_irradiance() {
    let frame =
        one(&from_above(vec![toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO)], vec![toy::matt(0.3)]));
    near(color(&frame, 48, 36), Vec3::splat(0.6));
    near(Vec3::splat(pixel(&frame, "albedo.G", 10, 10)), Vec3::splat(0.3));
    assert_eq!(pixel(&frame, "A", 10, 10), 1.0);
}

#[test]
fn distance_position_and_normal_are_those_of_the_floor() {
    let frame =
        one(&from_above(vec![toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO)], vec![toy::matt(0.3)]));
    // pixel (72, 36): half a pixel beyond 24 of 36 half heights to the right, 4 tan 30 = 2.3094 each
    let x = 4.0 * 30.0_f32.to_radians().tan() * 24.5 / 36.0;
    near(Vec3::splat(pixel(&frame, "Z", 72, 36)), Vec3::splat(4.0));
    let p =
        Vec3::new(pixel(&frame, "P.X", 72, 36), pixel(&frame, "P.Y", 72, 36), pixel(&frame, "N.Y", 72, 36));
    near(p, Vec3::new(x, 0.0, 1.0));
    assert_eq!(pixel(&frame, "object.V", 72, 36), 1.0);
}

#[test]
fn a_point_light_falls_with_square_and_cosine() {
    let mut scene =
        from_above(vec![toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO)], vec![toy::matt(1.0)]);
    let position = Track::constant(DVec3::new(0.0, 2.0, 0.0));
    scene.lights = vec![toy::light("lamp", LightKind::Point { position }, 8.0)];
    let frame = one(&scene);
    let at = |x: u32| {
        let p = Vec3::new(pixel(&frame, "P.X", x, 36), 0.0, pixel(&frame, "P.Z", x, 36));
        let d = Vec3::new(0.0, 2.0, 0.0) - p;
        8.0 * d.normalize().y / d.length_squared()
    };
    for x in [0, 20, 48, 80] {
        near(color(&frame, x, 36), Vec3::splat(at(x)));
    }
}

/// A square panel with edges of 1, 2 above the origin, that shines down.
fn panel() -> LightKind {
    LightKind::Rectangle(Panel::at_rest(DVec3::Y * 2.0, DVec3::ZERO, [1.0, 1.0]))
}

#[test]
fn a_panel_lights_the_floor_as_the_integral_over_it_does() {
    let mut scene =
        from_above(vec![toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO)], vec![toy::matt(1.0)]);
    scene.lights = vec![toy::light("panel", panel(), 8.0)];
    let frame = one(&scene);
    let integral = |x: u32, y: u32| {
        let p = Vec3::new(pixel(&frame, "P.X", x, y), 0.0, pixel(&frame, "P.Z", x, y));
        let steps = (0..50).map(|i| (i as f32 + 0.5) / 50.0 - 0.5);
        let places = steps.clone().flat_map(|x| steps.clone().map(move |z| Vec3::new(x, 2.0, z)));
        // both cosines are the panel's height over the distance
        let light = |place: Vec3| 8.0 * 4.0 / (place - p).length_squared().powi(2);
        places.map(light).sum::<f32>() / 2500.0
    };
    for (samples, noise) in [(16, 0.01), (4, 0.02), (1, 0.05)] {
        scene.lights[0].samples = samples;
        // rays of occlusion count as shadow rays
        let settings = Settings { layers: Layers::USUAL, ..toy::settings(1) };
        let frame = toy::render(&scene, &settings, 1).remove(0);
        for x in [0, 20, 48, 80] {
            // so many points stand for the panel, others for each sample
            let places = (x..x + 8).flat_map(|x| (6..66).map(move |y| (x, y)));
            let ratio = places.map(|(x, y)| color(&frame, x, y).x / integral(x, y)).sum::<f32>() / 480.0;
            assert!((ratio - 1.0).abs() < noise, "{samples} {x}: {ratio}");
        }
        assert_eq!(frame.stats.rays.shadow, u64::from(samples) * 96 * 72);
    }
}

#[test]
fn half_a_panel_gives_half_the_light() {
    // a roof whose edge runs across the middle of the panel, seen from the floor under that edge
    let models = vec![
        toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO),
        toy::still("roof", toy::floor(2.0, 0), Vec3::new(2.0, 1.0, 0.0)),
    ];
    let mut scene = from_above(models, vec![toy::matt(1.0)]);
    scene.lights = vec![toy::light("panel", panel(), 8.0)];
    let light = |scene: &Scene| {
        let frame = one(scene);
        (26..46).map(|y| color(&frame, 47, y).x).sum::<f32>()
    };
    let shaded = light(&scene);
    scene.models.truncate(1);
    let open = light(&scene);
    assert!((0.5..0.54).contains(&(shaded / open)), "{shaded} {open}");
}

/// A mirror floor shows the lights above it, with the radiance that follows from strength and size: the eye does not see
/// them, and no highlight stands for them.
#[test]
fn mirrors_show_lights_that_have_a_size() {
    let mirror = Material {
        specular: Vec3::splat(0.5),
        shininess: 9.0,
        optics: Optics::Mirror { tint: Vec3::splat(0.5), fresnel: false },
        ..toy::matt(0.0)
    };
    let mut scene = from_above(vec![toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO)], vec![mirror]);
    let position = Track::constant(DVec3::new(0.0, 2.0, 0.0));
    let direction = Track::constant(DVec3::NEG_Y);
    let sun = 1.0 / (1.0 - 2.0_f32.to_radians().cos()) / 2.0;
    for (kind, radiance) in [
        (panel(), PI),
        (LightKind::Disk(Panel::at_rest(DVec3::Y * 2.0, DVec3::ZERO, [1.0, 1.0])), 4.0),
        (LightKind::Sphere { position, radius: 0.5.into(), faces: false }, 4.0),
        (LightKind::Sun { direction, angle: 4.0.into() }, sun),
    ] {
        scene.lights = vec![toy::light("light", kind.clone(), 1.0)];
        scene.lights[0].samples = 1;
        let mut settings = toy::settings(1);
        let frame = toy::render(&scene, &settings, 1).remove(0);
        // between the eye and the mirror the panel is not seen, and it is seen beyond the mirror
        near(color(&frame, 48, 36), Vec3::splat(0.5 * radiance) + color(&frame, 48, 0));
        assert_eq!(pixel(&frame, "specular.R", 48, 36), 0.0, "{kind:?}");
        settings.depth = 0;
        let flat = toy::render(&scene, &settings, 1).remove(0);
        assert!(pixel(&flat, "specular.R", 48, 36) > 0.0 && pixel(&flat, "reflection.R", 48, 36) == 0.0);
    }
}

#[test]
fn a_shadow_is_where_the_blocker_stands_and_as_dark_as_the_ambient_light() {
    let models = vec![
        toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO),
        toy::still("roof", toy::floor(0.5, 0), Vec3::new(1.0, 1.0, 0.0)),
    ];
    let mut scene = from_above(models, vec![toy::matt(0.5)]);
    scene.ambient = Vec3::splat(0.2);
    let tilted = LightKind::Directional { direction: Track::constant(DVec3::new(-2.0, -1.0, 0.0)) };
    scene.lights = vec![toy::light("sun", tilted, 1.0)];
    let frame = one(&scene);
    // the roof's shadow is at x = 1 - 2: 24 pixels are 1.5396 on the floor
    let column = (48.0 - 24.0 / (4.0 * 30.0_f32.to_radians().tan() * 24.0 / 36.0)) as u32;
    near(color(&frame, column, 36), Vec3::splat(0.1));
    near(color(&frame, 5, 36), Vec3::splat(0.1 + 0.5 * 5.0_f32.sqrt().recip()));
}

/// A picture behind a window: it shines by ambient light alone, and a lamp does not make it brighter.
#[test]
fn a_texture_shows_in_ambient_light_where_nothing_is_diffuse() {
    let white = Vec3::splat(0.2);
    for (kd, albedo) in [(0.0, 0.0), (0.25, 0.125)] {
        let material = Material { ambient: Vec3::ONE, diffuse_map: Some(0), ..toy::matt(kd) };
        let mut scene = from_above(vec![toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO)], vec![material]);
        // sRGB's 188 is half of the light
        let texels = Arc::from([[188, 188, 188, 255]]);
        let (path, mapping) = (PathBuf::new(), Mapping::default());
        scene.textures = vec![Texture::of_bytes(path, [1, 1], texels, mapping)];
        (scene.ambient, scene.lights) = (white, vec![toy::sun_overhead(1.0)]);
        for frame in toy::render(&scene, &toy::audited(1), 2) {
            assert_eq!(frame.stats.audit.map(|audit| audit.differing), Some(0));
            near(color(&frame, 40, 36), white * 0.5 + Vec3::splat(albedo));
            near(Vec3::splat(pixel(&frame, "albedo.G", 40, 36)), Vec3::splat(albedo));
        }
    }
}

#[test]
fn a_mirror_shows_the_sky_in_its_tint() {
    let optics = Optics::Mirror { tint: Vec3::new(0.5, 0.6, 0.7), fresnel: false };
    let mirror = Material { optics, ..toy::matt(0.0) };
    let frame = one(&from_above(vec![toy::still("mirror", toy::floor(9.0, 0), Vec3::ZERO)], vec![mirror]));
    near(color(&frame, 30, 30), Vec3::new(0.125, 0.3, 0.7));
    near(Vec3::splat(pixel(&frame, "reflection.G", 30, 30)), Vec3::splat(0.3));
    assert_eq!(frame.stats.rays.reflection, 96 * 72);
}

#[test]
fn a_pane_of_glass_splits_the_light_and_loses_none() {
    // two faces of a slab before a background that is the same all around: whatever the path, all of the
    // background's light arrives but for what is beyond the depth
    let (transmission, reflection) = (Vec3::ONE, Vec3::ONE);
    let glass = Material { optics: Optics::clear(transmission, 1.5, reflection), ..toy::matt(0.0) };
    let top = toy::still(
        "top",
        toy::mesh(
            &[[-9., 1., 9.], [9., 1., 9.], [9., 1., -9.], [-9., 1., -9.]],
            &[[0, 1, 2], [0, 2, 3]],
            0,
            false,
        ),
        Vec3::ZERO,
    );
    let bottom = toy::still(
        "bottom",
        toy::mesh(
            &[[-9., 0., 9.], [9., 0., 9.], [9., 0., -9.], [-9., 0., -9.]],
            &[[0, 2, 1], [0, 3, 2]],
            0,
            false,
        ),
        Vec3::ZERO,
    );
    let frame = one(&from_above(vec![top, bottom], vec![glass]));
    let sky = Vec3::new(0.25, 0.5, 1.0);
    let seen = color(&frame, 48, 36) / sky;
    assert!((seen - Vec3::ONE).abs().max_element() < 5e-3, "{seen}");
    let through = pixel(&frame, "refraction.B", 48, 36);
    // what enters: 1 - 0.04, all of which comes out into the same sky, above or below
    assert!((through - 0.96).abs() < 5e-3, "{through}");
}

#[test]
fn the_highlight_is_where_the_sun_is_mirrored() {
    let shiny = Material { specular: Vec3::splat(0.4), shininess: 200.0, ..toy::matt(0.1) };
    let frame = one(&from_above(vec![toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO)], vec![shiny]));
    // Ks E (R . V)^Ns, half a pixel off the axis
    assert!((pixel(&frame, "specular.R", 48, 36) - 0.8).abs() < 0.02);
    assert!(pixel(&frame, "specular.R", 90, 36) < 1e-3);
    let sum: f32 = ["diffuse.R", "specular.R", "reflection.R", "refraction.R"]
        .iter()
        .map(|p| pixel(&frame, p, 50, 36))
        .sum();
    assert!((sum - pixel(&frame, "R", 50, 36)).abs() < 1e-3, "layers add up to the picture");
}

#[test]
fn clear_glass_casts_no_shadow() {
    let glass = Material { optics: Optics::clear(Vec3::ONE, 1.0, Vec3::ZERO), ..toy::matt(0.0) };
    let pane = toy::mesh(
        &[[-1., 1., 1.], [1., 1., 1.], [1., 1., -1.], [-1., 1., -1.]],
        &[[0, 1, 2], [0, 2, 3]],
        1,
        false,
    );
    let models =
        vec![toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO), toy::still("pane", pane, Vec3::ZERO)];
    let frame = one(&from_above(models, vec![toy::matt(0.3), glass]));
    near(color(&frame, 48, 36), Vec3::splat(0.6));
    assert!(pixel(&frame, "refraction.R", 48, 36) > 0.5, "seen through the pane");
}
