//! Does a light light the models that it is linked to, do those of its shadow link alone cast shadows in its light, and is what is kept
//! of it exact?

use std::sync::Arc;

use afterimage::frame::{Finished, Renderer};
use afterimage::layers::Layers;
use afterimage::scene::{
    Light, LightKind, LightLinks, Linked, Model, ModelNames, Panel, RayKind, Scene, SpotFall,
};
use afterimage::settings::{Mode, Settings};
use afterimage::trace::BackendKind;
use glam::{DVec3, Vec3};

use crate::changing::{camera_goes, under_a_sky};
use crate::toy;
use crate::toy::worlds::*;

fn all_but(names: &[&str]) -> ModelNames {
    ModelNames { include: None, exclude: names.iter().copied().map(String::from).collect() }
}

fn only(names: &[&str]) -> ModelNames {
    ModelNames { include: Some(names.iter().copied().map(String::from).collect()), exclude: Vec::new() }
}

fn lights_only(names: &[&str]) -> LightLinks {
    LightLinks { receivers: only(names), ..LightLinks::default() }
}

fn shadows_of(blockers: ModelNames) -> LightLinks {
    LightLinks { blockers, ..LightLinks::default() }
}

/// Gives what `name` emits these links.
fn emits(mut scene: Scene, name: &str, links: &LightLinks) -> Scene {
    for model in scene.models.iter_mut().filter(|model| model.name == name) {
        model.linked = Linked { emission: Some(Arc::new(links.clone())), ..model.linked.clone() };
    }
    scene
}

/// The world of solids, one of them of rough metal and one that glows, with a light of every kind.
fn rich() -> Scene {
    let mut scene = with_flyer(under_a_sky(world()));
    add_metal_and_glow(&mut scene);
    scene.lights.push(panel(rests(DVec3::new(1.0, 5.0, 2.0))));
    let spot = LightKind::Spot {
        position: rests(DVec3::new(-4.0, 4.0, 4.0)),
        target: rests(DVec3::ZERO),
        cone: 60.0.into(),
        soft: 0.5.into(),
        fall: SpotFall::Smooth,
        radius: 0.3.into(),
    };
    scene.lights.push(toy::light("spot", spot, 20.0));
    scene
}

fn settings() -> Settings {
    Settings { paths: 3, reflections: 3, bounces: 2, depth: 3, ..toy::settings(1) }
}

fn full(paths: u32) -> Settings {
    Settings { mode: Mode::Full, paths, ..settings() }
}

fn rendered(scene: &Scene, settings: &Settings) -> Finished {
    toy::render(scene, settings, 1).remove(0)
}

fn is_same(one: &Finished, other: &Finished) -> bool {
    ["R", "G", "B", "A"].iter().all(|name| one.film.values(name) == other.film.values(name))
}

/// Number of the model that the middle of a pixel shows, counted from 1.
fn object(finished: &Finished, x: u32, y: u32) -> usize {
    toy::pixel(finished, "object.V", x, y) as usize
}

#[test]
fn links_to_all_models_change_nothing() {
    let scene = rich();
    let names: Vec<String> = scene.models.iter().map(|model| model.name.clone()).collect();
    let all = ModelNames { include: Some(names), exclude: Vec::new() };
    let mut linked = scene.clone();
    for light in &mut linked.lights {
        light.links = LightLinks { receivers: all.clone(), blockers: all.clone() };
    }
    let links = LightLinks { receivers: all.clone(), blockers: all };
    let linked = emits(linked, "glow", &links);
    assert!(is_same(&rendered(&scene, &settings()), &rendered(&linked, &settings())));
}

/// What the light sends to no model of the picture is as if it were not there, in whatever way surfaces find it: a model that nobody
/// sees is the only one that it lights.
#[test]
fn a_light_that_lights_nothing_in_sight_is_as_good_as_none() {
    let mut scene = rich();
    scene.models.push(toy::still("away", toy::octahedron(0, false), Vec3::new(0.0, -90.0, 0.0)));
    for light in 0..scene.lights.len() {
        let mut linked = scene.clone();
        linked.lights[light].links = lights_only(&["away"]);
        let mut without = scene.clone();
        without.lights.remove(light);
        let [linked, without] = [&linked, &without].map(|scene| rendered(scene, &settings()));
        assert!(is_same(&linked, &without), "light {light}");
    }
}

/// The same of what a model emits, as others see it: it is asked for, and met by paths and rays.
#[test]
fn emission_that_lights_nothing_in_sight_is_seen_by_the_eye_alone() {
    let mut scene = rich();
    scene.models.push(toy::still("away", toy::octahedron(0, false), Vec3::new(0.0, -90.0, 0.0)));
    scene.materials.last_mut().unwrap().emission *= 10.0;
    let settings = full(64);
    let linked = rendered(&emits(scene.clone(), "glow", &lights_only(&["away"])), &settings);
    let lit = rendered(&scene, &settings);
    let glow = scene.models.iter().position(|model| model.name == "glow").unwrap() + 1;
    let mut dark = scene.clone();
    let number = usize::from(scene.models[glow - 1].mesh.material_of[0]);
    dark.materials[number].emission = Vec3::ZERO;
    let dark = rendered(&dark, &settings);
    let (mut sums, mut seen) = ([0.0; 3], 0);
    for (x, y) in (0..lit.film.height).flat_map(|y| (0..lit.film.width).map(move |x| (x, y))) {
        if object(&lit, x, y) == glow {
            seen += 1;
            assert!(toy::color(&linked, x, y).x > 4.0, "the eye sees it");
            continue;
        }
        for (sum, finished) in sums.iter_mut().zip([&linked, &dark, &lit]) {
            *sum += toy::color(finished, x, y).x;
        }
    }
    let [linked, dark, lit] = sums;
    assert!(seen > 5 && lit > 1.03 * dark, "{seen} {lit} {dark}");
    let brings = lit - dark;
    assert!((linked - dark).abs() < 0.05 * brings, "{linked} instead of {dark}: {lit} where all see it");
}

/// Without paths and mirrors each model has exactly the lights that light it.
#[test]
fn models_have_the_light_of_the_lights_that_light_them() {
    let scene = rich();
    let settings = Settings { depth: 0, paths: 0, ..settings() };
    let whole = rendered(&scene, &settings);
    for light in 0..scene.lights.len() {
        let (mut linked, mut without) = (scene.clone(), scene.clone());
        linked.lights[light].links = lights_only(&["matt", "floor"]);
        without.lights[light].power = 0.0.into();
        let [linked, without] = [&linked, &without].map(|scene| rendered(scene, &settings));
        let mut counts = [0; 2];
        for (x, y) in (0..whole.film.height).flat_map(|y| (0..whole.film.width).map(move |x| (x, y))) {
            let is_lit = [1, 2].contains(&object(&whole, x, y));
            let expected = if is_lit { &whole } else { &without };
            assert_eq!(toy::color(&linked, x, y), toy::color(expected, x, y), "light {light} at {x}, {y}");
            let differs = toy::color(&whole, x, y) != toy::color(&without, x, y);
            counts[usize::from(is_lit)] += usize::from(differs);
        }
        assert!(counts.iter().all(|count| *count > 20), "light {light} shows: {counts:?}");
    }
}

/// Light in which a model casts no shadow is what it would be if shadow rays passed the model.
#[test]
fn who_casts_no_shadow_in_a_light_stops_no_ray_to_it() {
    let scene = rich();
    let settings = Settings { depth: 0, paths: 0, ..settings() };
    let mut linked = scene.clone();
    let mut passed = scene.clone();
    for light in &mut linked.lights {
        light.links = shadows_of(all_but(&["matt", "flyer"]));
    }
    let hides = |model: &mut Model| {
        model.ray_visibility.hidden_from = [RayKind::Shadow].into_iter().collect();
    };
    passed.models.iter_mut().filter(|model| ["matt", "flyer"].contains(&model.name.as_str())).for_each(hides);
    let [whole, linked, passed] = [&scene, &linked, &passed].map(|scene| rendered(scene, &settings));
    assert!(is_same(&linked, &passed));
    assert!(!is_same(&whole, &passed), "or nothing is in the way");
}

/// Where a shadow link changes no shadow, light is the same, though it is found in another way: it is asked alone.
#[test]
fn shadow_links_that_change_no_shadow_change_no_light() {
    let mut scene = rich();
    scene.models.push(toy::still("away", toy::octahedron(0, true), Vec3::new(0.0, -90.0, 0.0)));
    let links = shadows_of(all_but(&["away"]));
    let mut linked = emits(scene.clone(), "glow", &links);
    linked.lights.iter_mut().for_each(|light| light.links = links.clone());
    let settings = Settings { samples: 2, reflections: 64, ..full(96) };
    let [whole, linked] = [&scene, &linked].map(|scene| rendered(scene, &settings));
    // by model, so that light that one has too much of is not what another lacks
    let mut sums = vec![[0.0_f64; 2]; scene.models.len() + 1];
    for (x, y) in (0..whole.film.height).flat_map(|y| (0..whole.film.width).map(move |x| (x, y))) {
        let of = &mut sums[object(&whole, x, y)];
        for (sum, finished) in of.iter_mut().zip([&whole, &linked]) {
            *sum += f64::from(toy::color(finished, x, y).min(Vec3::splat(4.0)).y);
        }
    }
    for (model, [whole, linked]) in sums.into_iter().enumerate().filter(|(_, [whole, _])| *whole > 5.0) {
        assert!((whole - linked).abs() < 0.012 * whole, "model {model}: {linked}, not {whole}");
    }
}

/// A light of each kind that lights some, in whose light some cast shadows, and what emits as well.
fn linked_world() -> Scene {
    let mut scene = emits(
        rich(),
        "glow",
        &LightLinks { receivers: all_but(&["metal"]), blockers: all_but(&["flyer", "matt"]) },
    );
    let moving_panel = LightKind::Rectangle(Panel {
        position: goes(DVec3::new(-3.0, 5.0, 2.0), DVec3::new(-2.0, 5.0, 2.0)),
        ..Panel::at_rest(DVec3::ZERO, DVec3::ZERO, [1.0, 1.0])
    });
    scene.lights.push(toy::light("moving panel", moving_panel, 10.0));
    let links = [
        lights_only(&["floor", "flyer"]),
        shadows_of(all_but(&["flyer"])),
        LightLinks { receivers: all_but(&["mirror"]), blockers: only(&["flyer", "glass"]) },
        LightLinks { receivers: only(&["floor", "metal", "mirror"]), blockers: only(&["matt"]) },
        shadows_of(only(&["flyer", "metal"])),
    ];
    for (light, links) in scene.lights.iter_mut().zip(links) {
        light.links = links;
    }
    scene
}

#[test]
fn what_is_kept_of_linked_lights_is_exact() {
    let scene = linked_world();
    for scene in [scene.clone(), camera_goes(scene)] {
        for backend in [BackendKind::Embree, BackendKind::Rust] {
            let audited = Settings { audit: true, ..settings() };
            let mut renderer = Renderer::with(backend, &scene, &audited).unwrap();
            for frame in 1..=FRAMES {
                let finished = renderer.render(frame, true).unwrap();
                assert_eq!(toy::differing(&finished), 0, "{backend:?}, frame {frame}");
            }
        }
    }
}

/// Both tracers show the same, but for some rays along edges, which lead paths elsewhere.
#[test]
fn tracers_agree_on_linked_lights() {
    let differing = |scene: &Scene| {
        let of = |backend| Renderer::with(backend, scene, &settings()).unwrap().render(1, false).unwrap();
        let [embree, rust] = [of(BackendKind::Embree), of(BackendKind::Rust)].map(|finished| {
            let values = ["R", "G", "B"].map(|name| finished.film.values(name).unwrap());
            values.concat()
        });
        embree.iter().zip(&rust).filter(|(embree, rust)| (*embree - *rust).abs() > 0.005).count()
    };
    let [plain, linked] = [rich(), linked_world()].map(|scene| differing(&scene));
    assert!(linked <= 2 * plain + 20, "{linked} values differ, {plain} of them without links");
}

/// A model that casts no shadow in a light costs none of its tags when it flies by.
#[test]
fn who_casts_no_shadow_ends_no_tag() {
    let settings = Settings { depth: 0, paths: 0, layers: Layers::NONE, ..settings() };
    let shadow_rays = |links: &LightLinks| {
        let mut scene = with_flyer(world());
        let flyer = scene.models.last_mut().unwrap();
        flyer.ray_visibility.hidden_from = [RayKind::Camera].into_iter().collect();
        scene.lights.iter_mut().for_each(|light: &mut Light| light.links = links.clone());
        let frames = toy::render(&scene, &settings, 3);
        frames[1..].iter().map(|finished| finished.stats.rays.shadow).sum::<u64>()
    };
    let [all, others] =
        [LightLinks::default(), shadows_of(all_but(&["flyer"]))].map(|links| shadow_rays(&links));
    assert!(all > 500 && others == 0, "{others} of {all} shadow rays");
}
