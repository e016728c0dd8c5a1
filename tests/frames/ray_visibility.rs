//! Does each kind of ray see what a shot says it sees?

use afterimage::frame::Finished;
use afterimage::layers::Layers;
use afterimage::scene::material::Optics;
use afterimage::scene::{
    Background, Environment, Material, Model, RayKind, RayKinds, RayVisibility, Role, Scene,
};
use afterimage::settings::{Backdrop, Budget, Caustics, Mode, Settings};
use glam::{DVec3, Vec3};

use crate::changing::{camera_goes, under_a_sky, with_metal_flyer};
use crate::toy;
use crate::toy::worlds::*;

/// Share of the light that a veil lets through.
const CLEAR: f32 = 0.7;

fn hidden(model: Model, kinds: &[RayKind]) -> Model {
    let hidden_from = kinds.iter().copied().collect();
    Model { ray_visibility: RayVisibility { hidden_from, role: Role::Itself }, ..model }
}

fn glowing() -> Material {
    Material { emission: Vec3::ONE, ..toy::matt(0.0) }
}

fn glass(index: f32) -> Material {
    let optics = Optics::clear(Vec3::ONE, index, Vec3::ZERO);
    Material { optics, ..toy::matt(0.0) }
}

/// A picture of what is at `height` between two and four under an eye that looks down: a level sheet of material 0. Sheets
/// of material 1 are at 0 and, above the eye, at 8; the background is black.
fn between(sheet: Material, other: Material, kinds: &[RayKind]) -> Scene {
    let camera = toy::camera(rests(DVec3::new(0.0, 6.0, 0.01)), rests(DVec3::ZERO));
    let models = vec![
        toy::still("sheet", toy::floor(400.0, 0), Vec3::Y * 3.0),
        hidden(toy::still("below", toy::floor(400.0, 1), Vec3::ZERO), kinds),
        hidden(toy::still("above", toy::floor(400.0, 1), Vec3::Y * 8.0), kinds),
    ];
    let mut scene = toy::scene(camera, models, vec![sheet, other], vec![]);
    scene.background = Background::uniform(Vec3::ZERO);
    scene
}

/// What the middle of the picture shows.
fn shown(scene: &Scene, settings: &Settings) -> f32 {
    let finished = toy::render(scene, settings, 1).remove(0);
    assert_eq!(toy::differing(&finished), 0);
    toy::color(&finished, finished.film.width / 2, finished.film.height / 2).y
}

/// Of sheets that glow: each case is seen by rays of one kind, whatever the others see.
#[test]
fn what_glows_is_seen_by_the_kinds_of_rays_that_see_it() {
    let mirror = Material { optics: Optics::Mirror { tint: Vec3::ONE, fresnel: false }, ..toy::matt(0.0) };
    let cases = [
        ("a mirror", mirror, RayKind::Glossy, 1.0),
        ("glass", glass(1.5), RayKind::Transmission, 1.0),
        (
            "a veil",
            Material { optics: Optics::veil(Vec3::splat(CLEAR)), ..toy::matt(0.0) },
            RayKind::Camera,
            CLEAR,
        ),
        ("a matt surface", toy::matt(0.5), RayKind::Diffuse, 0.5),
    ];
    let settings = Settings { paths: 64, bounces: 1, depth: 4, ..toy::audited(1) };
    for (name, sheet, seen_by, light) in cases {
        for kind in RayKind::ALL {
            let shown = shown(&between(sheet.clone(), glowing(), &[kind]), &settings);
            let expected = if kind == seen_by { 0.0 } else { light };
            // glass that Fresnel dims; paths that bounce once
            let is_right =
                if expected == 0.0 { shown == 0.0 } else { (shown - expected).abs() < 0.1 * expected };
            assert!(is_right, "{name}, hidden from {kind:?}: {shown}, not {expected}");
        }
    }
}

#[test]
fn what_shadow_rays_do_not_see_casts_no_shadow() {
    for kind in RayKind::ALL {
        let mut scene = between(toy::matt(0.5), toy::matt(0.5), &[kind]);
        scene.lights.push(toy::sun_overhead(1.0));
        let shown = shown(&scene, &toy::audited(1));
        assert_eq!(shown > 0.0, kind == RayKind::Shadow, "hidden from {kind:?}: {shown}");
    }
}

/// The light of a panel in the picture reaches all else alike, to the bit, whether the camera sees it or not.
#[test]
fn a_lamp_that_the_camera_does_not_see_lights_all_else_as_before() {
    let scene = |kinds: &[RayKind]| {
        let mut scene = under_a_sky(world());
        let number = scene.materials.len() as u16;
        scene.materials.push(Material { emission: Vec3::splat(9.0), ..toy::matt(0.0) });
        scene
            .models
            .push(hidden(toy::still("panel", toy::floor(0.5, number), Vec3::new(0.0, 2.5, 2.0)), kinds));
        scene
    };
    let settings =
        Settings { mode: Mode::Full, paths: 4, bounces: 2, depth: 3, reflections: 2, ..toy::settings(1) };
    let [seen, unseen] =
        [&[][..], &[RayKind::Camera][..]].map(|kinds| toy::render(&scene(kinds), &settings, 1).remove(0));
    let panel = 5.0;
    let (mut alike, mut behind) = (0, 0);
    for y in 0..seen.film.height {
        for x in 0..seen.film.width {
            assert_ne!(toy::pixel(&unseen, "object.V", x, y), panel, "the camera does not see it");
            if toy::pixel(&seen, "object.V", x, y) == panel {
                behind += 1;
            } else {
                alike += 1;
                assert_eq!(toy::color(&seen, x, y), toy::color(&unseen, x, y), "pixel {x}, {y}");
            }
        }
    }
    assert!(alike > 1000 && behind > 10, "{alike}, {behind}");
}

/// Light of an emitting sheet is the same whether points on it are asked for, or paths alone find it.
#[test]
fn what_is_asked_for_and_what_paths_find_is_the_same_light() {
    let settings = Settings { paths: 256, bounces: 1, depth: 4, ..toy::audited(1) };
    let lit = |kinds: &[RayKind]| shown(&between(toy::matt(0.5), glowing(), kinds), &settings);
    let (asked, found) = (lit(&[]), lit(&[RayKind::Transmission]));
    assert!((asked - found).abs() < 0.02 * asked, "{asked}, {found}");
}

fn holdouts(mut scene: Scene, names: &[&str]) -> Scene {
    for model in &mut scene.models {
        if names.contains(&model.name.as_str()) {
            model.ray_visibility.role = Role::Holdout;
        }
    }
    scene
}

/// A hole has neither light nor coverage. All else is what it was, mirrors that show the model among it.
#[test]
fn a_holdout_is_a_hole_in_the_picture_and_nothing_else_changes() {
    for samples in [1, 2] {
        let settings = Settings { paths: 2, depth: 3, samples, ..toy::audited(samples) };
        let scene = with_flyer(camera_goes(under_a_sky(world())));
        let with_holes = holdouts(scene.clone(), &["matt", "glass"]);
        let [whole, holed] = [&scene, &with_holes].map(|scene| toy::render(scene, &settings, FRAMES));
        for (whole, holed) in whole.iter().zip(&holed) {
            assert_eq!([whole, holed].map(toy::differing), [0, 0]);
            let values = |finished: &Finished, name: &str| finished.film.values(name).unwrap();
            let mattes = |name: &str| values(whole, name);
            let object = mattes("object.V");
            let (mut holes, mut others) = (0, 0);
            for (pixel, object) in object.iter().enumerate() {
                let of = |finished, name| values_at(finished, name, pixel);
                let channels = ["R", "G", "B", "A"];
                if samples > 1 {
                    // a pixel has no more than it had
                    for channel in channels {
                        assert!(of(holed, channel) <= of(whole, channel) + 1e-3, "{channel} of {pixel}");
                    }
                } else if [2.0, 4.0].contains(object) {
                    holes += 1;
                    channels.iter().for_each(|name| assert_eq!(of(holed, name), 0.0, "{name} of {pixel}"));
                } else {
                    others += 1;
                    channels
                        .iter()
                        .for_each(|name| assert_eq!(of(holed, name), of(whole, name), "{name} of {pixel}"));
                }
            }
            assert!(samples > 1 || holes > 200 && others > 1000, "{holes}, {others}");
        }
    }
}

fn values_at(finished: &Finished, name: &str, pixel: usize) -> f32 {
    let width = finished.film.width as usize;
    toy::pixel(finished, name, (pixel % width) as u32, (pixel / width) as u32)
}

/// Veils before nothing, in a picture without its background: they hide as much of a plate as they hold back.
#[test]
fn veils_before_a_background_that_is_not_shown_cover_what_they_hold_back() {
    let camera = toy::camera(rests(DVec3::new(0.0, 6.0, 0.01)), rests(DVec3::ZERO));
    for (count, holds) in [(1, false), (3, false), (2, true)] {
        let material = Material { optics: Optics::veil(Vec3::splat(CLEAR)), ..toy::matt(0.0) };
        let veil = |number| toy::still("veil", toy::floor(400.0, 0), Vec3::Y * (1.0 + 0.1 * number as f32));
        let mut models: Vec<Model> = (0..count).map(veil).collect();
        if holds {
            // what is behind them is a hole
            models.push(toy::still("hole", toy::floor(400.0, 1), Vec3::ZERO));
        }
        let scene = toy::scene(camera.clone(), models, vec![material, toy::matt(0.5)], vec![]);
        let scene = holdouts(scene, &["hole"]);
        let background = if holds { Backdrop::Visible } else { Backdrop::Transparent };
        let finished = toy::render(&scene, &Settings { background, ..toy::audited(1) }, 1).remove(0);
        assert_eq!(toy::differing(&finished), 0);
        let (alpha, expected) = (toy::pixel(&finished, "A", 48, 36), 1.0 - CLEAR.powi(count));
        assert!((alpha - expected).abs() < 1e-3, "{count}: {alpha}, not {expected}");
        assert_eq!(toy::color(&finished, 48, 36), Vec3::ZERO);
    }
}

fn with_veil(mut scene: Scene, height: f32) -> Scene {
    let material = scene.materials.len() as u16;
    scene.materials.push(Material { optics: Optics::veil(Vec3::new(0.2, 0.5, 0.8)), ..toy::matt(0.1) });
    scene.models.push(toy::still("veil", toy::floor(3.0, material), Vec3::Y * height));
    scene
}

/// Over its own background such a picture is the one that shows it, frame after frame, before cameras that rest and that move.
#[test]
fn over_its_background_a_picture_with_veils_is_the_visible_one() {
    for scene in
        [with_veil(with_flyer(under_a_sky(world())), 3.5), with_veil(camera_goes(under_a_sky(world())), 3.5)]
    {
        let mut scene = scene;
        scene.models.retain(|model| model.name != "floor");
        let render = |background| {
            toy::render(&scene, &Settings { paths: 1, depth: 3, background, ..toy::audited(1) }, FRAMES)
        };
        let mut through = 0;
        for (visible, over) in render(Backdrop::Visible).iter().zip(&render(Backdrop::Transparent)) {
            assert_eq!([visible, over].map(toy::differing), [0, 0]);
            for pixel in 0..(visible.film.width * visible.film.height) as usize {
                for channel in ["R", "G", "B"] {
                    let of = |finished, name: &str| values_at(finished, name, pixel);
                    let sum = of(over, channel) + of(over, &format!("background.{channel}"));
                    let shown = of(visible, channel);
                    assert!(
                        (sum - shown).abs() <= 2e-3 * sum + 1e-5,
                        "{channel} of {pixel}: {sum}, not {shown}"
                    );
                }
                through += usize::from((0.01..0.99).contains(&values_at(over, "A", pixel)));
            }
        }
        assert!(through > 500, "{through}");
    }
}

/// Whatever moves, and whoever sees it: what is kept is what would be made anew, and what is shown is what is there.
#[test]
fn an_audit_finds_nothing() {
    type Change = fn(Scene) -> Scene;
    let changes: [(&str, &[Change]); 3] = [
        ("a flyer under a sky", &[with_metal_flyer, under_a_sky]),
        ("the camera, under a sky, and area lights", &[camera_goes, under_a_sky, with_area_lights]),
        ("both", &[with_metal_flyer, camera_goes]),
    ];
    for (name, changes) in changes {
        let mut scene = with_veil(changes.iter().fold(world(), |scene, change| change(scene)), 2.6);
        for (number, model) in scene.models.iter_mut().enumerate() {
            let kinds = [RayKind::ALL[number % 5], RayKind::ALL[(number * 3 + 1) % 5]];
            model.ray_visibility.hidden_from = kinds.into_iter().collect::<RayKinds>();
            model.ray_visibility.role = [Role::Itself, Role::Holdout, Role::ShadowCatcher][number % 3];
        }
        for (caustics, background) in
            [(Caustics::None, Backdrop::Transparent), (Caustics::Paths, Backdrop::Visible)]
        {
            let settings = Settings {
                paths: 3,
                bounces: 2,
                depth: 3,
                reflections: 2,
                caustics,
                background,
                ..toy::audited(1)
            };
            for finished in toy::render(&scene, &settings, FRAMES) {
                let found = finished.stats.audit.as_ref();
                assert_eq!(toy::differing(&finished), 0, "{name}, frame {}: {found:?}", finished.stats.frame);
            }
        }
    }
}

/// A sky is no model: all rays see it as before.
#[test]
fn a_model_hidden_from_all_rays_leaves_no_trace() {
    let mut without = under_a_sky(world());
    without.environment = Some(Environment::from_background(&without.background));
    let mut with = without.clone();
    let kinds = RayKind::ALL;
    with.models.push(hidden(toy::still("nobody sees it", toy::floor(30.0, 0), Vec3::Y * 2.0), &kinds));
    let settings = Settings { paths: 2, depth: 3, ..toy::settings(1) };
    let [without, with] = [&without, &with].map(|scene| toy::render(scene, &settings, 2));
    for (without, with) in without.iter().zip(&with) {
        for channel in ["R", "G", "B", "A"] {
            assert!(without.film.values(channel).unwrap() == with.film.values(channel).unwrap(), "{channel}");
        }
    }
}

/// What clipping planes cut off is not seen by the camera. Mirrors show it, and it casts its shadow.
#[test]
fn the_camera_sees_what_is_between_its_planes() {
    let mirror = Material { optics: Optics::Mirror { tint: Vec3::ONE, fresnel: false }, ..toy::matt(0.0) };
    // an eye 6 above the ground, a sheet 3 above it, and one above the eye
    let seen = |sheet: &Material, near: f64, far: f64| {
        let mut scene = between(sheet.clone(), glowing(), &[]);
        scene.camera.lens.near = Some(rests_at(near));
        scene.camera.lens.far = Some(rests_at(far));
        shown(&scene, &Settings { depth: 2, ..toy::audited(1) })
    };
    let matt = toy::matt(0.5);
    for (near, far, expected) in
        [(0.0, 9.0, 0.0), (3.1, 9.0, 1.0), (3.1, 5.9, 0.0), (7.0, 9.0, 0.0), (0.5, 2.0, 0.0)]
    {
        assert_eq!(seen(&matt, near, far), expected, "between {near} and {far}");
    }
    assert_eq!(seen(&mirror, 1.0, 4.0), 1.0, "a mirror shows what is behind the eye");
    assert_eq!(
        seen(&glass(1.5), 1.0, 4.0),
        seen(&glass(1.5), 0.0, 9.0),
        "glass shows what is beyond the far plane"
    );
}

fn rests_at(depth: f64) -> afterimage::animation::Track<f64> {
    afterimage::animation::Track::constant(depth)
}

/// Frames through which a camera with clipping planes goes and turns, things fly through these planes, and the planes go
/// themselves: what is inferred is what is traced in full.
#[test]
fn an_audit_finds_nothing_between_planes() {
    for (name, scene) in [
        ("a camera that goes", camera_goes(under_a_sky(world()))),
        ("a flyer", with_metal_flyer(under_a_sky(world()))),
        ("both", camera_goes(with_flyer(world()))),
    ] {
        for (near, far) in [((6.2, 6.2), (9.0, 9.0)), ((5.0, 7.5), (12.0, 8.0))] {
            let mut scene = scene.clone();
            let goes = |(from, to)| toy::keys(&[(1.0, from), (f64::from(FRAMES), to)]);
            (scene.camera.lens.near, scene.camera.lens.far) = (Some(goes(near)), Some(goes(far)));
            let settings = Settings { paths: 1, depth: 2, ..toy::audited(1) };
            let mut beyond = 0;
            for finished in toy::render(&scene, &settings, FRAMES) {
                let found = finished.stats.audit.as_ref();
                assert_eq!(toy::differing(&finished), 0, "{name}, frame {}: {found:?}", finished.stats.frame);
                let depths = finished.film.values("Z").unwrap();
                let least = depths.iter().copied().fold(f32::INFINITY, f32::min);
                assert!(least >= 5.0 - 1e-4, "{least}");
                beyond += depths.iter().filter(|depth| !depth.is_finite() || **depth > 1e6).count();
            }
            assert!(beyond > 1000, "{beyond}");
        }
    }
}

fn caught(mut scene: Scene, name: &str) -> Scene {
    for model in scene.models.iter_mut().filter(|model| model.name == name) {
        model.ray_visibility.role = Role::ShadowCatcher;
    }
    scene
}

/// A floor that catches the shadow of a roof above it: of half of the light, where one of two equal suns is hidden.
#[test]
fn a_catcher_covers_by_the_light_that_is_kept_from_it() {
    let scene = |suns: &[DVec3]| {
        let camera = toy::camera(rests(DVec3::new(0.0, 6.0, 0.01)), rests(DVec3::ZERO));
        let roof = hidden(toy::still("roof", toy::floor(1.0, 0), Vec3::Y), &[RayKind::Camera]);
        let floor = toy::still("floor", toy::floor(400.0, 0), Vec3::ZERO);
        let sun = |direction: &DVec3| {
            let kind = afterimage::scene::LightKind::Directional { direction: rests(*direction) };
            toy::light("sun", kind, 1.0)
        };
        let lights = suns.iter().map(sun).collect();
        caught(toy::scene(camera, vec![floor, roof], vec![toy::matt(0.3)], lights), "floor")
    };
    let overhead = DVec3::NEG_Y;
    // its shadow falls outside of the middle
    let aslant = DVec3::new(3.0, -1.0, 0.0).normalize();
    let share = -aslant.y as f32;
    for (suns, under, beside) in [
        (&[overhead][..], 1.0, 0.0),
        (&[overhead, aslant][..], 1.0 / (1.0 + share), 0.0),
        (&[aslant][..], 0.0, 0.0),
        (&[][..], 0.0, 0.0),
    ] {
        for background in [Backdrop::Transparent, Backdrop::Visible] {
            let finished =
                toy::render(&scene(suns), &Settings { background, ..toy::audited(1) }, 1).remove(0);
            assert_eq!(toy::differing(&finished), 0);
            for (x, y, alpha) in [(48, 36, under), (48, 4, beside)] {
                let (color, covers) = (toy::color(&finished, x, y), toy::pixel(&finished, "A", x, y));
                let expected = match background {
                    Backdrop::Transparent => (Vec3::ZERO, alpha),
                    Backdrop::Visible => (Vec3::new(0.25, 0.5, 1.0) * (1.0 - alpha), 1.0),
                };
                let off = (color - expected.0).abs().max_element().max((covers - expected.1).abs());
                assert!(off < 1e-3, "{suns:?}, {background:?}: {color} and {covers}, not {expected:?}");
            }
        }
    }
}

/// The layer has each colour's own share: of a red sun that is hidden beside a blue one that is not. Beside catchers it is 1.
#[test]
fn the_layer_of_catchers_has_the_shadows_of_each_colour() {
    let camera = toy::camera(rests(DVec3::new(0.0, 6.0, 0.01)), rests(DVec3::ZERO));
    let roof = toy::still("roof", toy::floor(0.6, 0), Vec3::Y);
    let floor = toy::still("floor", toy::floor(3.0, 0), Vec3::ZERO);
    let sun = |direction: DVec3, color: Vec3| {
        let kind = afterimage::scene::LightKind::Directional { direction: rests(direction) };
        afterimage::scene::Light { color: color.into(), ..toy::light("sun", kind, 1.0) }
    };
    // the shadow of the first sun is right of the roof, that of the other one far left
    let slope = |x: f64| DVec3::new(x, -1.0, 0.0).normalize();
    let lights = vec![sun(slope(1.6), Vec3::X), sun(slope(-8.0), Vec3::new(0.0, 0.0, 1.0))];
    let scene = caught(toy::scene(camera, vec![floor, roof], vec![toy::matt(0.3)], lights), "floor");
    for samples in [1, 2] {
        let settings = Settings { background: Backdrop::Transparent, ..toy::audited(samples) };
        let finished = toy::render(&scene, &settings, 1).remove(0);
        assert_eq!(toy::differing(&finished), 0);
        let layer = |x, y| {
            Vec3::from(["catcher.R", "catcher.G", "catcher.B"].map(|name| toy::pixel(&finished, name, x, y)))
        };
        // on the roof, in the red shadow (no light is green, which has the mean), on the open floor, beside it
        for (x, y, expected, alpha) in [
            (48, 36, Vec3::ONE, 1.0),
            (64, 36, Vec3::new(0.0, 0.5, 1.0), 0.5),
            (48, 20, Vec3::ONE, 0.0),
            (2, 36, Vec3::ONE, 0.0),
        ] {
            let (found, covers) = (layer(x, y), toy::pixel(&finished, "A", x, y));
            assert!((found - expected).abs().max_element() < 1e-3, "{x}, {y}: {found}, not {expected}");
            assert!((covers - alpha).abs() < 1e-3, "{x}, {y}: {covers}, not {alpha}");
        }
        for (x, y) in (0..finished.film.height).flat_map(|y| (0..finished.film.width).map(move |x| (x, y))) {
            // what things hide, by the formula of docs/layers.md
            let hidden = toy::pixel(&finished, "A", x, y) - 1.0 + layer(x, y).element_sum() / 3.0;
            let is_whole = hidden.abs() < 2e-3 || (hidden - 1.0).abs() < 2e-3;
            assert!(is_whole || samples > 1 && (0.0..=1.0).contains(&hidden), "{x}, {y}: {hidden}");
        }
    }
}

/// Under a sky an open floor covers exactly nothing, however few paths there are; below a roof as much as the roof hides of
/// the sky.
#[test]
fn a_catcher_under_a_sky_covers_where_the_sky_is_hidden() {
    let camera = toy::camera(rests(DVec3::new(0.0, 6.0, 0.01)), rests(DVec3::ZERO));
    let floor = toy::still("floor", toy::floor(400.0, 0), Vec3::ZERO);
    let open = caught(under_a_sky(toy::scene(camera, vec![floor], vec![toy::matt(0.3)], vec![])), "floor");
    let settings = Settings { paths: 1, background: Backdrop::Transparent, ..toy::audited(1) };
    let finished = toy::render(&open, &settings, 1).remove(0);
    assert!(finished.film.values("A").unwrap().iter().all(|alpha| *alpha == 0.0));
    let mut covered = open;
    covered.environment = Some(Environment::from_background(&Background::uniform(Vec3::ONE)));
    covered.materials.push(toy::matt(0.0));
    covered.models.push(hidden(toy::still("roof", toy::floor(1.0, 1), Vec3::Y), &[RayKind::Camera]));
    let settings = Settings { paths: 1024, ..settings };
    let finished = toy::render(&covered, &settings, 1).remove(0);
    // form factor of a square of side 2 from 1 below its middle: Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-3
    let (side, root) = (1.0_f32, 2.0_f32.sqrt());
    let quarter = (side / root * (side / root).atan() * 2.0) / (2.0 * std::f32::consts::PI);
    let alpha = toy::pixel(&finished, "A", 48, 36);
    assert!((alpha - 4.0 * quarter).abs() < 0.03, "{alpha}, not {}", 4.0 * quarter);
}

/// Below a dark roof the mean of a catcher's paths stays nothing while more of them come, and what they would bring does not.
#[test]
fn a_catcher_shows_each_path_that_comes() {
    let mut scene = caught(under_a_sky(world()), "floor");
    let number = scene.materials.len() as u16;
    scene.materials.push(toy::matt(0.0));
    scene.models.retain(|model| model.name == "floor");
    scene.models.push(hidden(toy::still("roof", toy::floor(300.0, number), Vec3::Y), &[RayKind::Camera]));
    scene.lights.truncate(1);
    scene.lights[0].kind = afterimage::scene::LightKind::Point { position: rests(DVec3::new(0.0, 0.5, 0.0)) };
    let settings = Settings {
        paths: 32,
        budget: Budget::Full,
        paths_per_frame: 4,
        background: Backdrop::Transparent,
        base_every: 0,
        ..toy::audited(1)
    };
    let frames = toy::render(&scene, &settings, FRAMES);
    for finished in &frames {
        assert_eq!(toy::differing(finished), 0, "frame {}: {:?}", finished.stats.frame, finished.stats.audit);
    }
    let alphas = |finished: &Finished| finished.film.values("A").unwrap();
    assert!(alphas(&frames[1]) != alphas(&frames[5]), "more paths come, frame by frame");
}

/// What a catcher's material reflects of ambient light, be it nothing, casts no shadow where nothing hides it.
#[test]
fn occluded_ambient_light_covers_nothing_in_the_open() {
    for (ambient, of_catcher) in [(Vec3::ZERO, 0.5), (Vec3::splat(0.3), 0.0), (Vec3::splat(0.3), 0.5)] {
        let camera = toy::camera(rests(DVec3::new(0.0, 6.0, 0.01)), rests(DVec3::ZERO));
        let floor = toy::still("floor", toy::floor(400.0, 0), Vec3::ZERO);
        let other = toy::still("other", toy::floor(0.1, 1), Vec3::NEG_Y);
        let material = Material { ambient: Vec3::splat(of_catcher), ..toy::matt(0.5) };
        let lights = vec![toy::sun_overhead(1.0)];
        let mut scene =
            caught(toy::scene(camera, vec![floor, other], vec![material, toy::matt(0.5)], lights), "floor");
        (scene.ambient, scene.ambient_is_occluded) = (ambient, true);
        let settings =
            Settings { background: Backdrop::Transparent, layers: Layers::NONE, ..toy::audited(1) };
        let finished = toy::render(&scene, &settings, 1).remove(0);
        assert!(
            finished.film.values("A").unwrap().iter().all(|alpha| *alpha == 0.0),
            "{ambient}, {of_catcher}"
        );
    }
}

/// Veils show the background that is beside them, and nothing beyond the far plane.
#[test]
fn veils_show_what_the_eye_would_see_without_them() {
    let veil = Material { optics: Optics::veil(Vec3::splat(CLEAR)), ..toy::matt(0.0) };
    let mut scene = between(veil, glowing(), &[]);
    scene.background = Background::uniform(Vec3::splat(0.5));
    scene.camera.lens.far = Some(rests_at(4.0));
    assert_eq!(shown(&scene, &toy::audited(1)), half(0.5 * CLEAR), "what glows is beyond the plane");
    scene.models.retain(|model| model.name == "sheet");
    let mut light = Environment::from_background(&Background::uniform(Vec3::ONE));
    light.visible = false;
    scene.environment = Some(light);
    assert_eq!(shown(&scene, &toy::audited(1)), half(0.5 * CLEAR), "the eye does not see the environment");
}

fn half(value: f32) -> f32 {
    half::f16::from_f32(value).to_f32()
}
