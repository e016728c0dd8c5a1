//! Does each Cryptomatte hold the share of a pixel that its name says, exactly under the filter, and do all add up to alpha?

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage::film::Film;
use afterimage::frame::Finished;
use afterimage::layers::Layers;
use afterimage::scene::mesh::Groups;
use afterimage::scene::{Background, Material, Scene};
use afterimage::settings::{Backdrop, Filter, Settings};
use glam::{DVec3, Vec3};

use crate::runs::{Place, Ran};
use crate::toy;
use crate::toy::worlds::*;

/// Layers of a kind of mattes, and ranks in each.
const PARTS: [&str; 3] = ["00", "01", "02"];

/// The names of the mattes of a header, with the bits of their numbers.
fn manifest(finished: &Finished, layer: &str) -> BTreeMap<String, u32> {
    let about: BTreeMap<_, _> = finished.about_layers.iter().cloned().collect();
    let (key, _) = about.iter().find(|(_, value)| *value == layer).expect("the layer is in the header");
    let text = &about[&key.replace("/name", "/manifest")];
    let names: BTreeMap<String, String> = serde_json::from_str(text).unwrap();
    names.into_iter().map(|(name, digits)| (name, u32::from_str_radix(&digits, 16).unwrap())).collect()
}

/// The matte of one number: the coverage of the ranks that have it.
fn matte(film: &Film, layer: &str, id: u32) -> Vec<f32> {
    let mut sum = vec![0.0; (film.width * film.height) as usize];
    for (part, [number, share]) in PARTS.iter().flat_map(|part| [(part, ["R", "G"]), (part, ["B", "A"])]) {
        let [numbers, shares] =
            [number, share].map(|channel| film.values(&format!("{layer}{part}.{channel}")).unwrap());
        let of_matte =
            numbers.iter().zip(shares).zip(&mut sum).filter(|((number, _), _)| number.to_bits() == id);
        of_matte.for_each(|((_, share), sum)| *sum += share);
    }
    sum
}

/// A scene without light in which nothing is seen but what `shines` of its models emits: the picture is its matte.
fn shining(scene: &Scene, shines: impl Fn(usize) -> bool) -> Scene {
    let mut scene = scene.clone();
    scene.lights.clear();
    (scene.ambient, scene.background) = (Vec3::ZERO, Background::uniform(Vec3::ZERO));
    let emission =
        |shines| Material { emission: Vec3::splat(if shines { 1.0 } else { 0.0 }), ..toy::matt(0.0) };
    scene.materials = vec![emission(false), emission(true)];
    for (number, model) in scene.models.iter_mut().enumerate() {
        let mesh = Arc::make_mut(&mut model.mesh);
        mesh.material_of.fill(u16::from(shines(number)));
    }
    scene
}

fn mattes_of(samples: u32, filter: Filter, backdrop: Backdrop) -> Settings {
    let layers = Layers::CRYPTOMATTE.with(Layers::STATUS);
    Settings { layers, filter, background: backdrop, ..toy::settings(samples) }
}

/// How many pixels differ by more than the rounding of halves, and by how much at most.
fn off(ours: &[f32], wanted: &[f32]) -> (usize, f32) {
    let off = ours.iter().zip(wanted).map(|(a, b)| (a - b).abs()).filter(|off| *off > 1.0 / 2000.0);
    off.fold((0, 0.0), |(count, most), off| (count + 1, off.max(most)))
}

/// A world of matt solids with a flyer, whose camera rests or travels.
fn worlds() -> [Scene; 2] {
    let scene = matt_world();
    let travels = with_camera(scene.clone(), goes(EYE, EYE + DVec3::X), rests(TARGET));
    [scene, travels]
}

#[test]
fn a_matte_is_what_the_picture_would_be_if_its_object_alone_were_white() {
    for (scene, (samples, filter)) in worlds().into_iter().flat_map(|scene| {
        [(1, Filter::Box), (3, Filter::Box), (2, Filter::Mitchell)].map(|how| (scene.clone(), how))
    }) {
        let settings = mattes_of(samples, filter, Backdrop::Transparent);
        let frames = toy::render(&scene, &Settings { audit: true, ..settings.clone() }, 4);
        let ids = manifest(&frames[0], "CryptoObject");
        assert_eq!(ids.len(), scene.models.len());
        for (number, model) in scene.models.iter().enumerate() {
            let white = toy::render(&shining(&scene, |other| other == number), &settings, 4);
            for (frame, white) in frames.iter().zip(&white) {
                assert_eq!(toy::differing(frame), 0);
                let [matte, wanted] =
                    [matte(&frame.film, "CryptoObject", ids[&model.name]), white.film.values("R").unwrap()];
                let (count, most) = off(&matte, &wanted);
                let sees = wanted.iter().any(|value| *value > 0.5);
                // beside edges Mitchell's lobes are clamped: of mattes so that they add up, of colours each by itself
                let may_be = if filter == Filter::Box { 0 } else { wanted.len() / 12 };
                assert!(
                    sees && count <= may_be && most < 0.1,
                    "{}, {samples}, {filter:?}: {count} pixels of {}, by up to {most}",
                    model.name,
                    wanted.len()
                );
            }
        }
    }
}

#[test]
fn mattes_add_up_to_alpha() {
    for (samples, filter, backdrop) in [
        (1, Filter::Box, Backdrop::Visible),
        (2, Filter::Box, Backdrop::Transparent),
        (2, Filter::Mitchell, Backdrop::Transparent),
        (3, Filter::Mitchell, Backdrop::Visible),
    ] {
        let [_, scene] = worlds();
        for frame in toy::render(&scene, &mattes_of(samples, filter, backdrop), 3) {
            let alpha = frame.film.values("A").unwrap();
            for layer in ["CryptoObject", "CryptoMaterial", "CryptoGroup"] {
                let mut sum = vec![0.0; alpha.len()];
                for (name, id) in manifest(&frame, layer) {
                    let matte = matte(&frame.film, layer, id);
                    assert!(matte.iter().all(|share| (0.0..=1.0).contains(share)), "{name}");
                    sum.iter_mut().zip(matte).for_each(|(sum, share)| *sum += share);
                }
                let (count, most) = off(&sum, &alpha);
                assert_eq!(count, 0, "{layer}, {filter:?}, {backdrop:?}: by up to {most}");
                assert!(alpha.contains(&1.0));
                assert_eq!(alpha.contains(&0.0), backdrop == Backdrop::Transparent);
            }
        }
    }
}

#[test]
fn what_has_a_name_in_common_is_one_matte_and_groups_are_told_apart_by_their_models() {
    let mut scene = matt_world();
    let mut groups = Groups::named(["default", "left", "right"].map(String::from).into_iter());
    groups.begin(0, 1);
    groups.begin(4, 2);
    // an octahedron: of its eight faces the first four are one group
    let solid = scene.models.iter_mut().find(|model| model.name == "matt").unwrap();
    Arc::make_mut(&mut solid.mesh).groups = Arc::new(groups);
    scene.materials[1].name = String::from("paint");
    scene.materials[2].name = String::from("paint");
    let frames = toy::render(&scene, &mattes_of(2, Filter::Box, Backdrop::Visible), 1);
    let names = |layer: &str| manifest(&frames[0], layer).into_keys().collect::<Vec<_>>();
    assert_eq!(names("CryptoGroup"), ["background", "floor", "flyer", "matt/left", "matt/right"]);
    assert_eq!(names("CryptoMaterial"), ["(none)", "background", "paint"]);
    assert_eq!(names("CryptoObject"), ["background", "floor", "flyer", "matt"]);
    let film = &frames[0].film;
    let of = |layer: &str, name: &str| matte(film, layer, manifest(&frames[0], layer)[name]);
    let whole = of("CryptoObject", "matt");
    let [left, right] = ["matt/left", "matt/right"].map(|name| of("CryptoGroup", name));
    let both: Vec<f32> = left.iter().zip(&right).map(|(left, right)| left + right).collect();
    assert_eq!(off(&both, &whole).0, 0);
    assert!([&left, &right].iter().all(|matte| matte.contains(&1.0)));
}

#[test]
fn files_say_what_their_mattes_are_with_the_names_of_the_obj_file() {
    let place = Place::new();
    let square = |name: &str, x: f32| {
        let corners =
            [[0.0, 0.0], [0.8, 0.0], [0.8, 0.8], [0.0, 0.8]].map(|[dx, y]| format!("v {} {y} 0\n", x + dx));
        format!("o {name}\n{}f -4 -3 -2 -1\n", corners.concat())
    };
    let obj = format!("{}{}", square("left one", 0.0), square("right", 1.0));
    std::fs::write(place.path("squares.obj"), obj).unwrap();
    let options = "--frames 1 --size 64x32 --layers CryptoGroup -o a.####.exr";
    Ran::new(place.command("squares.obj", options).output().unwrap()).done();
    let header = openexr::read_header(&place.path("a.0001.exr")).unwrap();
    let text = |end: &str| {
        let found = header
            .attributes
            .iter()
            .find(|(name, _)| name.starts_with("cryptomatte/") && name.ends_with(end));
        match found {
            Some((_, openexr::Attribute::Text(text))) => text.clone(),
            other => panic!("{end}: {other:?}"),
        }
    };
    assert_eq!(
        [text("/name"), text("/hash"), text("/conversion")],
        ["CryptoGroup", "MurmurHash3_32", "uint32_to_float32"]
    );
    let names: BTreeMap<String, String> = serde_json::from_str(&text("/manifest")).unwrap();
    assert!(names.contains_key("squares/left one") && names.contains_key("squares/right"), "{names:?}");
}
