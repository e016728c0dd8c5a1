//! Is the picture the sum of those of its light groups, to rounding, whatever brings their light, and is each exact under reuse?

use std::sync::Arc;

use afterimage::animation::Track;
use afterimage::frame::{Finished, Renderer};
use afterimage::scene::{Environment, Linked, Scene};
use afterimage::settings::{Backdrop, Settings};
use glam::{DVec3, Vec3};

use crate::changing::{camera_goes, under_a_sky};
use crate::toy;
use crate::toy::worlds::*;

/// A world of solids, one of them of rough metal and one that glows, under a sky and lights of a group each; the sun is in none.
fn grouped() -> Scene {
    let mut scene = with_flyer(under_a_sky(world()));
    scene.ambient = Vec3::new(0.02, 0.03, 0.05);
    add_metal_and_glow(&mut scene);
    let glow = scene.models.last_mut().expect("there is one");
    glow.linked = Linked { light_group: Some(Arc::from("glow")), ..Linked::default() };
    let mut key = panel(goes(DVec3::new(-3.0, 5.0, 2.0), DVec3::new(-2.0, 5.0, 2.0)));
    key.group = Some(String::from("key"));
    key.color = Track::constant(Vec3::new(1.0, 0.7, 0.5));
    scene.lights.push(key);
    scene.world_group = Some(String::from("world"));
    scene
}

fn settings() -> Settings {
    Settings { paths: 3, reflections: 3, bounces: 2, depth: 3, ..toy::settings(1) }
}

fn rendered(scene: &Scene, only: Option<&str>, last: i32) -> Vec<Finished> {
    let settings = Settings { only_lights: only.map(String::from), audit: true, ..settings() };
    let frames = toy::render(scene, &settings, last);
    for (number, finished) in frames.iter().enumerate() {
        assert_eq!(toy::differing(finished), 0, "{only:?}, frame {number}");
    }
    frames
}

#[test]
fn the_picture_is_the_sum_of_those_of_its_groups() {
    for scene in [grouped(), camera_goes(grouped())] {
        let groups: Vec<String> = scene.light_groups().into_iter().map(String::from).collect();
        assert_eq!(groups, ["key", "glow", "world", "others"]);
        let whole = rendered(&scene, None, 4);
        let parts: Vec<Vec<Finished>> = groups.iter().map(|group| rendered(&scene, Some(group), 4)).collect();
        for (frame, whole) in whole.iter().enumerate() {
            let mut shown = [0; 4];
            for (x, y) in (0..whole.film.height).flat_map(|y| (0..whole.film.width).map(move |x| (x, y))) {
                let colors: Vec<Vec3> = parts.iter().map(|part| toy::color(&part[frame], x, y)).collect();
                let (sum, expected) = (colors.iter().sum::<Vec3>(), toy::color(whole, x, y));
                // half floats round each of what is added, and what samples keep
                let slack = 8e-3 * expected.max_element() + 1e-4;
                let off = (sum - expected).abs().max_element();
                assert!(off <= slack, "frame {frame}, {x}, {y}: {sum}, not {expected}");
                shown.iter_mut().zip(&colors).for_each(|(count, color)| {
                    *count += usize::from(color.max_element() > 0.05 * expected.max_element());
                });
            }
            assert!(shown.iter().all(|count| *count > 50), "each group brings something: {shown:?}");
        }
    }
}

/// A light of another group casts no shadow rays of samples, and a group that brings nothing is black.
#[test]
fn groups_without_light_are_black() {
    let mut scene = grouped();
    scene.environment = None::<Environment>;
    scene.background = afterimage::scene::Background::uniform(Vec3::ZERO);
    scene.ambient = Vec3::ZERO;
    let settings = Settings {
        only_lights: Some(String::from("world")),
        background: Backdrop::Transparent,
        ..settings()
    };
    let finished = toy::render(&scene, &settings, 1).remove(0);
    for name in ["R", "G", "B"] {
        assert!(finished.film.values(name).unwrap().iter().all(|value| *value == 0.0), "{name}");
    }
}

#[test]
fn unknown_groups_are_told() {
    let scene = grouped();
    let settings = Settings { only_lights: Some(String::from("kye")), ..settings() };
    let error = Renderer::new(&scene, &settings).err().expect("there is no such group").to_string();
    assert_eq!(
        error,
        "`only_lights` names no light group of the shot: there are `key`, `glow`, `world`, `others`; write one of these"
    );
}
