//! Does the layer of a group of lights hold what these lights add to the picture, and do all add up to it?

use afterimage::film::Film;
use afterimage::scene::material::MetalRough;
use afterimage::scene::{Light, Material, Scene};
use afterimage::settings::{Filter, Settings};
use glam::{DVec3, Vec3};

use crate::runs::{Place, Ran};
use crate::toy;
use crate::toy::worlds::*;

const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// A world with mirrors, glass, highlights and rough metal, whose camera travels or rests; its two panels are one group, its
/// lamp is another, and its sun is in none.
fn worlds() -> [Scene; 2] {
    let mut scene = with_flyer(world());
    scene.lights.push(panel(rests(DVec3::new(1.0, 5.0, 2.0))));
    scene.lights.push(Light {
        name: "other panel".into(),
        ..panel(goes(DVec3::new(-3.0, 5.0, 2.0), DVec3::new(-2.0, 5.0, 2.0)))
    });
    for (light, group) in scene.lights.iter_mut().zip([None, Some("lamp"), Some("panels"), Some("panels")]) {
        light.group = group.map(String::from);
    }
    scene.materials[0].specular = Vec3::splat(0.3);
    scene.materials[0].shininess = 20.0;
    scene.materials[0].emission = Vec3::new(0.01, 0.0, 0.02);
    let metal =
        MetalRough { base: Vec3::splat(0.7), roughness: 0.4, metallic: 0.5, head_on: 0.04, solid: 1.0 };
    scene.materials.push(Material { metal_rough: Some(metal), ..toy::matt(0.35) });
    let metal = toy::still("metal", toy::octahedron(3, true), Vec3::new(-0.5, 1.0, 2.0));
    scene.models.push(metal);
    let travels = with_camera(scene.clone(), goes(EYE, EYE + DVec3::X), rests(TARGET));
    [scene, travels]
}

fn films(scene: &Scene, settings: &Settings) -> Vec<Film> {
    let frames = toy::render(scene, &Settings { audit: true, ..settings.clone() }, 4);
    let film = |frame: &afterimage::frame::Finished| {
        assert_eq!(toy::differing(frame), 0);
        Film::clone(&frame.film)
    };
    frames.iter().map(film).collect()
}

/// What the pixels of some layers add up to, in a channel.
fn sum(film: &Film, layers: &[&str], channel: &str) -> Vec<f32> {
    let mut sum = vec![0.0; (film.width * film.height) as usize];
    for layer in layers {
        let values = film.values(&format!("{layer}.{channel}")).unwrap();
        sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
    }
    sum
}

/// How many values are off by more than the rounding of the halves that are added up, and by how much at most.
fn off(ours: &[f32], wanted: &[f32]) -> (usize, f32) {
    let pairs = ours.iter().zip(wanted).map(|(ours, wanted)| ((ours - wanted).abs(), ours + 2.0 * wanted));
    let off = pairs.filter(|(off, all)| *off > all / 1024.0 + 2e-5).map(|(off, _)| off);
    off.fold((0, 0.0), |(count, most), off| (count + 1, off.max(most)))
}

#[test]
fn groups_and_all_else_add_up_to_the_picture() {
    let layers = [
        "light_lamp",
        "light_panels",
        "light_others",
        "indirect",
        "emission",
        "background",
        "reflection",
        "refraction",
    ];
    for scene in worlds() {
        for film in films(&scene, &Settings { paths: 2, ..toy::settings(2) }) {
            for channel in CHANNELS {
                let (count, most) = off(&sum(&film, &layers, channel), &film.values(channel).unwrap());
                assert_eq!(count, 0, "{channel}: by up to {most}");
            }
        }
    }
}

#[test]
fn a_group_is_the_picture_with_no_other_light() {
    for scene in worlds() {
        for filter in [Filter::Box, Filter::Mitchell] {
            let settings = Settings { width: 64, height: 48, filter, ..toy::settings(2) };
            let shown = films(&scene, &settings);
            for (layer, group) in
                [("light_lamp", Some("lamp")), ("light_panels", Some("panels")), ("light_others", None)]
            {
                let mut alone = scene.clone();
                alone.lights.retain(|light| light.group.as_deref() == group);
                alone.ambient = Vec3::ZERO;
                alone.materials.iter_mut().for_each(|material| material.emission = Vec3::ZERO);
                for (film, alone) in shown.iter().zip(films(&alone, &settings)) {
                    for channel in CHANNELS {
                        let ours = sum(film, &[layer], channel);
                        let background = alone.values(&format!("background.{channel}")).unwrap();
                        let wanted = sum(&alone, &["diffuse", "specular"], channel);
                        // what is seen of the background is no light of a group
                        let wanted: Vec<f32> = wanted
                            .iter()
                            .zip(background)
                            .map(|(all, sky)| if sky > 0.0 { -1.0 } else { *all })
                            .collect();
                        let [ours, wanted]: [Vec<f32>; 2] = [&ours, &wanted].map(|values| {
                            values
                                .iter()
                                .zip(&wanted)
                                .filter(|(_, wanted)| **wanted >= 0.0)
                                .map(|(value, _)| *value)
                                .collect()
                        });
                        let (count, most) = off(&ours, &wanted);
                        // a wide filter is clamped layer by layer
                        let may_be = if filter == Filter::Box { 0 } else { ours.len() / 16 };
                        assert!(
                            count <= may_be && ours.iter().sum::<f32>() > 1.0,
                            "{layer}, {channel}, {filter:?}: {count} of {}, by up to {most}",
                            ours.len()
                        );
                    }
                }
            }
        }
    }
}

/// A shot with these lights, in a file; what a run says of it.
fn run(lights: &str, options: &str) -> (Place, Ran) {
    let place = Place::new();
    std::fs::write(place.path("square.obj"), "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let shot = format!(
        "[[camera.key]]\nframe = 1\neye = [0, 0, 3]\ntarget = [0, 0, 0]\n[[model]]\nobj = \"square.obj\"\n{lights}"
    );
    std::fs::write(place.path("a.toml"), shot).unwrap();
    let ran = Ran::new(place.command("a.toml", options).output().unwrap());
    (place, ran)
}

fn point(more: &str) -> String {
    format!("[[light]]\ntype = \"point\"\nposition = [0, 1, 2]\n{more}\n")
}

#[test]
fn shot_files_name_groups() {
    let options = "--frames 1 --size 32x18 --layers light -o a.####.exr";
    let (place, ran) = run(&format!("{}{}", point("group = \"key-1\""), point("power = 2")), options);
    ran.done();
    let names =
        openexr::read(&place.path("a.0001.exr")).unwrap().channels.into_iter().map(|channel| channel.name);
    let mut names: Vec<String> = names.filter(|name| name.starts_with("light")).collect();
    names.sort();
    assert_eq!(
        names.join(" "),
        "light_key-1.B light_key-1.G light_key-1.R light_others.B light_others.G light_others.R"
    );
}

#[test]
fn odd_groups_are_refused_with_their_line() {
    let options = "--frames 1 --size 32x18";
    let named = |group: &str, name: &str| point(&format!("group = \"{group}\"\nname = \"{name}\""));
    let same = format!("{}{}", named("key", "a"), named("key", "a"));
    run(&same, options).1.failed(&["a.toml:12", "two lights `a` in the group `key`", "rename one"]);
    run(&named("a.b", "a"), options).1.failed(&["a.toml:10", "`group`", "letters"]);
    run(&named("others", "a"), options).1.failed(&["a.toml:10", "`group`", "all lights that state none"]);
    run(&named("", "a"), options).1.failed(&["`group`"]);
    let many: String = (0..8).map(|number| named(&format!("g{number}"), "a")).collect();
    run(&many, options).1.failed(&["more than 7 groups"]);
    // the same name in two groups is none of anybody's business
    run(&format!("{}{}", named("key", "a"), named("fill", "a")), options).1.done();
}
