//! Do the parts of a picture add up, and does each hold what its name says?

use std::path::Path;

use afterimage::film::Film;
use afterimage::frame::Renderer;
use afterimage::layers::Layers;
use afterimage::scene::material::{MetalRough, Optics};
use afterimage::scene::{self, Background, LightKind, Material, Mist, MistFalloff, Scene, Triangles};
use afterimage::settings::{Backdrop, Filter, Mode, Settings};
use glam::{DVec3, Vec2, Vec3};
use half::f16;

use crate::toy;
use crate::toy::worlds::*;

const PARTS: [&str; 4] = ["direct", "indirect", "emission", "background"];

/// The parts of `diffuse` of frames of a scene, one after the other; each with what goes wrong.
fn frames(scene: &Scene, settings: &Settings, last: i32) -> Vec<Film> {
    let settings = Settings { audit: true, ..settings.clone() };
    let mut renderer = Renderer::new(scene, &settings).unwrap();
    let film = |frame| {
        let finished = renderer.render(frame, true).unwrap();
        assert_eq!(toy::differing(&finished), 0, "frame {frame}");
        Film::clone(&finished.film)
    };
    (1..=last).map(film).collect()
}

/// How many pixels have parts that do not add up to `diffuse` within the rounding of halves: the parts', that of `diffuse`,
/// and that of the light that samples keep.
fn off(film: &Film) -> usize {
    let off = |channel: &str| -> Vec<bool> {
        let values = |layer: &str| film.values(&format!("{layer}.{channel}")).unwrap();
        let (diffuse, parts) = (values("diffuse"), PARTS.map(values));
        let pixel = |(pixel, diffuse): (usize, &f32)| {
            let sum: f32 = parts.iter().map(|part| part[pixel]).sum();
            (sum - diffuse).abs() > (sum + 2.0 * diffuse) / 2048.0 + 1e-6
        };
        diffuse.iter().enumerate().map(pixel).collect()
    };
    let [r, g, b] = ["R", "G", "B"].map(off);
    (0..r.len()).filter(|pixel| r[*pixel] || g[*pixel] || b[*pixel]).count()
}

/// A world in which every part has something, under a camera that stands and one that travels.
fn worlds() -> [Scene; 2] {
    let mut scene = with_flyer(world());
    scene.lights.push(panel(rests(DVec3::new(1.0, 5.0, 2.0))));
    scene.materials[0].emission = Vec3::new(0.01, 0.0, 0.02);
    let travels = with_camera(scene.clone(), goes(EYE, EYE + DVec3::X), rests(TARGET));
    [scene, travels]
}

#[test]
fn parts_add_up_to_the_diffuse_light() {
    for scene in worlds() {
        for film in frames(&scene, &Settings { paths: 3, ..toy::settings(2) }, 4) {
            assert_eq!(off(&film), 0);
            for part in PARTS {
                let sum: f32 = film.values(&format!("{part}.B")).unwrap().iter().sum();
                assert!(sum > 1.0, "there is some {part}: {sum}");
            }
        }
    }
}

/// What a wide filter takes away from a pixel for bright ones beside it may have been rounded there.
const ROUNDING: f32 = 2e-4;

/// A wide filter is clamped layer by layer beside edges, so that a few pixels differ there.
#[test]
fn parts_add_up_with_a_wide_filter_where_nothing_is_clamped() {
    for scene in worlds() {
        let settings = Settings { paths: 3, filter: Filter::Mitchell, ..toy::settings(2) };
        for film in frames(&scene, &settings, 4) {
            let pixels = (film.width * film.height) as usize;
            assert!(off(&film) * 5 < pixels, "{} of {pixels}", off(&film));
            for channel in ["R", "G", "B"] {
                let values = |layer: &str| film.values(&format!("{layer}.{channel}")).unwrap();
                let (diffuse, parts) = (values("diffuse"), PARTS.map(values));
                for (pixel, diffuse) in diffuse.iter().enumerate() {
                    let sum: f32 = parts.iter().map(|part| part[pixel]).sum();
                    assert!(
                        sum >= diffuse * (1.0 - 3.0 / 2048.0) - ROUNDING,
                        "nothing is lost: {sum}, {diffuse}"
                    );
                }
            }
        }
    }
}

/// The negative lobes of a wide filter would make more of what is bright beside what is dark.
#[test]
fn no_albedo_is_larger_than_that_of_the_brightest_material() {
    for mut scene in worlds() {
        scene.materials[0].diffuse = Vec3::new(0.6, 0.9, 1.5);
        for film in frames(&scene, &Settings { filter: Filter::Mitchell, ..toy::settings(2) }, 3) {
            for (channel, kd) in [("R", 0.6), ("G", 0.9), ("B", 1.5)] {
                let values = film.values(&format!("albedo.{channel}")).unwrap();
                let largest = values.into_iter().fold(0.0, f32::max);
                assert_eq!(largest, f16::from_f32(kd).to_f32(), "albedo.{channel}");
            }
        }
    }
}

#[test]
fn parts_add_up_in_the_city() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/city/sky.toml");
    let shot = scene::load(&path, true).unwrap();
    for filter in [Filter::Box, Filter::Mitchell] {
        let settings = Settings {
            width: 192,
            height: 108,
            paths: 2,
            filter,
            mode: Mode::Reproject,
            layers: Layers::ALL,
            ..shot.settings.clone()
        };
        for film in frames(&shot.scene, &settings, 2) {
            let most = if filter == Filter::Box { 0 } else { (film.width * film.height) as usize / 2 };
            assert!(off(&film) <= most, "{filter:?}: {}", off(&film));
        }
    }
}

/// A floor that glows, under a sun and an even sky, with a roof over its left half.
fn floor_and_roof() -> Scene {
    let camera = toy::camera(rests(DVec3::new(0.0, 3.0, 6.0)), rests(DVec3::new(0.0, 2.0, 0.0)));
    let roof = [[-9.0, 8.0, 9.0], [0.0, 8.0, 9.0], [0.0, 8.0, -9.0], [-9.0, 8.0, -9.0]];
    let roof = toy::mesh(&roof, &[[0, 1, 2], [0, 2, 3]], 1, true);
    let models =
        vec![toy::still("floor", toy::floor(9.0, 0), Vec3::ZERO), toy::still("roof", roof, Vec3::ZERO)];
    let glowing = Material { emission: Vec3::splat(0.25), ..toy::matt(0.5) };
    let mut scene = toy::scene(camera, models, vec![glowing, toy::matt(0.0)], vec![toy::sun_overhead(1.0)]);
    scene.ambient = Vec3::splat(0.5);
    scene
}

fn at(film: &Film, layer: &str, x: usize, y: usize) -> Vec3 {
    let value = |channel: &str| film.values(&format!("{layer}.{channel}")).unwrap()[y * 96 + x];
    Vec3::new(value("R"), value("G"), value("B"))
}

#[test]
fn each_part_holds_what_its_name_says() {
    let film = frames(&floor_and_roof(), &toy::settings(1), 1).remove(0);
    let ([sun, shadow], [sky_x, sky_y]) = ([60, 36], [90, 2]);
    let shown =
        |part: &str| [at(&film, part, sun, 70), at(&film, part, shadow, 70), at(&film, part, sky_x, sky_y)];
    assert_eq!(shown("direct"), [Vec3::splat(0.5), Vec3::ZERO, Vec3::ZERO]);
    assert_eq!(shown("emission"), [Vec3::splat(0.5), Vec3::splat(0.5), Vec3::ZERO]);
    assert_eq!(shown("background"), [Vec3::ZERO, Vec3::ZERO, Vec3::new(0.25, 0.5, 1.0)]);
    assert_eq!(shown("indirect"), [Vec3::ZERO; 3]);
    // without the roof, half of what the whole upper half of the sky sends
    let mut open = floor_and_roof();
    open.models.pop();
    let film = frames(&open, &Settings { paths: 4, ..toy::settings(1) }, 1).remove(0);
    assert!((at(&film, "indirect", sun, 70) - Vec3::new(0.125, 0.25, 0.5)).abs().max_element() < 1e-3);
    assert_eq!(at(&film, "direct", sun, 70), Vec3::splat(0.5));
}

/// Direct light is not what rounding leaves of the sum.
#[test]
fn a_shadow_has_no_direct_light_however_bright_the_rest_is() {
    let mut scene = floor_and_roof();
    scene.ambient = Vec3::splat(999.3);
    let film = frames(&scene, &Settings { paths: 3, ..toy::settings(1) }, 1).remove(0);
    assert_eq!(at(&film, "direct", 36, 70), Vec3::ZERO);
    assert_eq!(at(&film, "direct", 60, 70), Vec3::splat(0.5));
}

/// A wall before the camera with a screen behind it: what the wall is made of decides what denoisers are told.
fn guides(optics: Optics, diffuse: f32) -> (Vec3, Vec3) {
    let color = Vec3::splat(diffuse);
    guides_of(Material { optics, diffuse: color, ambient: color, ..toy::matt(0.1) })
}

/// What denoisers are told of a wall of this material.
fn guides_of(material: Material) -> (Vec3, Vec3) {
    let light = toy::light("lamp", LightKind::Point { position: rests(DVec3::new(0.0, 1.5, 3.0)) }, 1.0);
    let mut scene = before_a_mirror(DVec3::new(0.0, 1.5, 30.0), light);
    scene.materials[0] = material;
    // a screen in front of the wall, seen by way of mirrors, and one behind it, seen through glass
    let back = [[-9.0, -9.0, -3.0], [9.0, -9.0, -3.0], [9.0, 9.0, -3.0], [-9.0, 9.0, -3.0]];
    let back = toy::mesh(&back, &[[0, 1, 2], [0, 2, 3]], 2, true);
    scene.models.push(toy::still("back", back, Vec3::ZERO));
    scene.materials.push(toy::matt(0.3));
    scene.background = Background::uniform(Vec3::ONE);
    let film = frames(&scene, &toy::settings(1), 1).remove(0);
    let (x, y) = (48, 36);
    let value = |axis: &str| film.values(&format!("denoise_normal.{axis}")).unwrap()[y * 96 + x];
    (at(&film, "denoise_albedo", x, y), Vec3::new(value("X"), value("Y"), value("Z")))
}

#[test]
fn denoisers_are_told_what_is_seen_by_way_of_mirrors_and_glass() {
    let near = |(albedo, normal): (Vec3, Vec3), wanted: [Vec3; 2]| {
        let error = (albedo - wanted[0]).abs().max_element().max((normal - wanted[1]).abs().max_element());
        assert!(error < 2e-3, "{albedo} {normal}, not {wanted:?}");
    };
    near(guides(Optics::Opaque, 0.5), [Vec3::splat(0.5), Vec3::Z]);
    let mirror = Optics::Mirror { tint: Vec3::splat(0.8), fresnel: false };
    // the screen of 0.6 looks towards the wall
    near(guides(mirror, 0.0), [Vec3::splat(0.48), Vec3::NEG_Z * 0.8]);
    near(guides(mirror, 0.2), [Vec3::splat(0.68), Vec3::Z]);
    let pane = Optics::clear(Vec3::ONE, 1.0, Vec3::ONE);
    near(guides(pane, 0.0), [Vec3::splat(0.3), Vec3::Z]);
}

/// Rough metal has the colour that it reflects, which is all that it has; a smooth one shows the screen before it.
#[test]
fn denoisers_are_told_what_rough_metal_reflects_head_on() {
    let base = Vec3::new(0.9, 0.6, 0.3);
    let metal = |roughness| {
        let layer = MetalRough { base, roughness, metallic: 1.0, head_on: 0.04, solid: 1.0 };
        Material { diffuse: Vec3::ZERO, ambient: Vec3::ZERO, metal_rough: Some(layer), ..toy::matt(0.1) }
    };
    let (albedo, normal) = guides_of(metal(0.5));
    assert!(
        (albedo - base).abs().max_element() < 1e-3 && (normal - Vec3::Z).length() < 2e-3,
        "{albedo} {normal}"
    );
    let (albedo, normal) = guides_of(metal(0.0));
    // by Schlick's formula it reflects a little more where it is not seen head-on
    assert!((albedo - 0.6 * base).abs().max_element() < 5e-3 && normal.z < 0.0, "{albedo} {normal}");
}

#[test]
fn what_denoisers_are_told_is_filtered_as_the_picture_is() {
    let settings = Settings { filter: Filter::Mitchell, ..toy::settings(2) };
    let film = frames(&with_flyer(world()), &settings, 2).remove(1);
    let values = |name: &str| film.values(name).unwrap();
    let [x, y, z] = ["X", "Y", "Z"].map(|axis| values(&format!("denoise_normal.{axis}")));
    let lengths: Vec<f32> = (0..x.len()).map(|i| Vec3::new(x[i], y[i], z[i]).length()).collect();
    let count = |low: f32, high: f32| lengths.iter().filter(|length| (low..high).contains(*length)).count();
    assert!(count(0.999, 1.001) > 3000, "inside surfaces they have unit length");
    assert!(count(0.05, 0.95) > 100, "where surfaces meet they are mixed");
    assert!(values("denoise_normal.X").iter().any(|x| *x < -0.3), "they may be negative");
    assert!(values("denoise_albedo.G").iter().all(|albedo| (0.0..=1.0).contains(albedo)));
}

#[test]
fn files_hold_the_usual_layers_if_nobody_says_what() {
    let usual: Vec<&str> = Settings::default().layers.names().collect();
    let expected = "Z object status";
    assert_eq!(usual, expected.split_whitespace().collect::<Vec<_>>());
}

/// How much two colours that are the same may be apart: roundings to halves, of which `sum` is what is added up.
fn rounding(sum: f32) -> f32 {
    sum * 3.0 / 2048.0 + 1e-6
}

/// A picture whose background is transparent, over its own background, is the picture that shows it. So over any plate
/// nothing of the background is left.
#[test]
fn over_its_background_a_transparent_picture_is_the_visible_one() {
    for (scene, filter) in
        worlds().into_iter().flat_map(|scene| [(scene.clone(), Filter::Box), (scene, Filter::Mitchell)])
    {
        let render =
            |background| frames(&scene, &Settings { paths: 1, filter, background, ..toy::settings(2) }, 3);
        for (visible, transparent) in render(Backdrop::Visible).iter().zip(&render(Backdrop::Transparent)) {
            let [shown, over] =
                [visible, transparent].map(|film| move |name: &str| film.values(name).unwrap());
            assert!(shown("A").iter().all(|alpha| *alpha == 1.0), "{filter:?}");
            let alpha = over("A");
            let partly = alpha.iter().filter(|alpha| (0.01..0.99).contains(*alpha)).count();
            assert!(partly > 20 && alpha.contains(&0.0) && alpha.contains(&1.0), "{filter:?}: {partly}");
            for channel in ["R", "G", "B"] {
                let (shown, over, background) =
                    (shown(channel), over(channel), over(&format!("background.{channel}")));
                for (pixel, shown) in shown.iter().enumerate() {
                    let sum = over[pixel] + background[pixel];
                    // a wide filter is clamped layer by layer
                    let is_right = match filter {
                        Filter::Box => (sum - shown).abs() <= rounding(sum),
                        _ => sum >= shown - rounding(sum) - ROUNDING,
                    };
                    assert!(is_right, "{filter:?}, {channel} of pixel {pixel}: {sum}, not {shown}");
                    assert!(filter == Filter::Mitchell || alpha[pixel] > 0.0 || over[pixel] == 0.0);
                }
            }
            // nothing else changes
            let of_background =
                |name: &str| ["diffuse", "Crypto", "denoise_variance"].iter().any(|of| name.starts_with(of));
            let other = |name: &str| !of_background(name) && !["R", "G", "B", "A"].contains(&name);
            for plane in visible.planes.iter().filter(|plane| other(&plane.name)) {
                assert!(plane.values.to_floats() == over(&plane.name), "{}", plane.name);
            }
        }
    }
}

/// Black that nobody asked for hides nothing.
#[test]
fn a_background_is_visible_if_there_is_one() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let of = |tables: &str| {
        let path = folder.path().join("s.toml");
        let camera = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n";
        std::fs::write(&path, format!("{camera}[[model]]\nobj = \"m.obj\"\n{tables}")).unwrap();
        scene::load(&path, true).unwrap().settings.background
    };
    let asked = |background: &str| format!("[output]\nbackground = \"{background}\"\n");
    assert_eq!([of(""), of(&asked("visible"))], [Backdrop::Transparent, Backdrop::Visible]);
    let unseen = "[environment]\nsky = {}\nvisible = false\n";
    assert_eq!(of(unseen), Backdrop::Transparent);
    for table in ["[background]\ncolor = [0, 0, 0]\n", "[environment]\nsky = {}\n"] {
        assert_eq!(of(table), Backdrop::Visible, "{table}");
        assert_eq!(of(&format!("{table}{}", asked("transparent"))), Backdrop::Transparent, "{table}");
    }
}

/// Of a floor with texture coordinates from 0 to 1 and a solid of another material on it.
#[test]
fn materials_and_texture_coordinates_are_those_of_the_point() {
    let floor = toy::floor(4.0, 1);
    let floor = floor.with_triangles(|Triangles { positions, uvs, .. }| {
        let at = |[x, _, z]: &[f32; 3]| Vec2::new((x + 4.0) / 8.0, (4.0 - z) / 8.0);
        *uvs = positions.as_slice().iter().map(at).collect();
    });
    let solid = toy::octahedron(0, true).with_triangles(|triangles| triangles.uvs = Vec::new());
    let models = vec![toy::still("floor", floor, Vec3::ZERO), toy::still("solid", solid, Vec3::Y)];
    let camera = toy::camera(goes(EYE, EYE + DVec3::X), rests(TARGET));
    let materials = vec![toy::matt(0.5), toy::matt(0.25)];
    let scene = toy::scene(camera, models, materials, vec![toy::sun_overhead(1.0)]);
    for samples in [1, 2] {
        for film in frames(&scene, &toy::settings(samples), 3) {
            let [object, material, u, v, is_there, x, z] =
                ["object.V", "material.V", "uv.U", "uv.V", "uv.A", "P.X", "P.Z"]
                    .map(|name| film.values(name).unwrap());
            let mut seen = [0; 3];
            for pixel in 0..object.len() {
                seen[object[pixel] as usize] += 1;
                let number = [0.0, 2.0, 1.0][object[pixel] as usize];
                assert_eq!(material[pixel], number, "pixel {pixel}");
                let wanted = match number {
                    2.0 => Vec2::new((x[pixel] + 4.0) / 8.0, (4.0 - z[pixel]) / 8.0),
                    _ => Vec2::ZERO,
                };
                let off = (Vec2::new(u[pixel], v[pixel]) - wanted).abs().max_element();
                assert!(off < 1e-5, "{samples}: pixel {pixel} is off by {off}");
                assert_eq!(is_there[pixel] == 1.0, number == 2.0, "the floor alone has any");
            }
            assert!(seen.iter().all(|count| *count > 100), "{seen:?}");
        }
    }
}

/// `depth.V` is the mean of the samples' distances, where `Z` shows one of them; multiplied by what share surfaces have.
#[test]
fn the_filtered_depth_is_between_those_of_the_samples() {
    let scene = with_camera(matt_world(), goes(EYE, EYE + DVec3::X), rests(TARGET));
    for filter in [Filter::Box, Filter::Mitchell] {
        let settings = Settings { filter, background: Backdrop::Transparent, ..toy::settings(3) };
        for film in frames(&scene, &settings, 3) {
            let [depth, z, alpha] = ["depth.V", "Z", "A"].map(|name| film.values(name).unwrap());
            let inside = (0..z.len()).filter(|pixel| alpha[*pixel] == 1.0 && z[*pixel] < 1e9);
            let far: Vec<f32> = inside.map(|pixel| (depth[pixel] / z[pixel] - 1.0).abs()).collect();
            let near = far.iter().filter(|off| **off < 0.02).count();
            // at silhouettes of one surface before another it lies between the two
            assert!(near * 10 > far.len() * 8 && far.len() - near > 20, "{near} of {}", far.len());
            let nothing = (0..z.len()).filter(|pixel| alpha[*pixel] == 0.0);
            // negative lobes may leave something of a far surface where they take all of a near one away
            assert!(filter != Filter::Box || nothing.map(|pixel| depth[pixel]).all(|depth| depth == 0.0));
        }
    }
    // with one sample a pixel both are the same
    for film in frames(&scene, &toy::settings(1), 3) {
        let [depth, z] = ["depth.V", "Z"].map(|name| film.values(name).unwrap());
        let off = depth
            .iter()
            .zip(&z)
            .filter(|(_, z)| **z < 1e9)
            .filter(|(depth, z)| (**depth / **z - 1.0).abs() > 1e-6);
        assert_eq!(off.count(), 0);
    }
}

/// `mist.V` grows with the distance from the eye: not along its axis, but for an orthographic camera.
#[test]
fn mist_grows_with_the_distance_from_the_eye() {
    let mist = Mist { start: 6.0, depth: 8.0, falloff: MistFalloff::Linear };
    for falloff in [MistFalloff::Linear, MistFalloff::Quadratic, MistFalloff::Inverse] {
        let scene =
            Scene { mist: Mist { falloff, ..mist }, ..with_camera(matt_world(), rests(EYE), rests(TARGET)) };
        let film = frames(&scene, &toy::settings(1), 1).remove(0);
        let values = ["mist.V", "P.X", "P.Y", "P.Z", "Z"].map(|name| film.values(name).unwrap());
        let [found, x, y, z, depth] = values;
        let (mut within, mut beyond) = (0, 0);
        for pixel in 0..found.len() {
            let place = DVec3::new(x[pixel].into(), y[pixel].into(), z[pixel].into());
            let share = ((place.distance(EYE) - mist.start) / mist.depth).clamp(0.0, 1.0);
            let expected = match falloff {
                MistFalloff::Linear => share,
                MistFalloff::Quadratic => share * share,
                MistFalloff::Inverse => share.sqrt(),
            };
            let is_background = depth[pixel] > 1e9;
            let expected = if is_background { 1.0 } else { expected as f32 };
            assert!((found[pixel] - expected).abs() < 2e-3, "{pixel}: {}, not {expected}", found[pixel]);
            within += usize::from(expected > 0.0 && expected < 1.0);
            beyond += usize::from(!is_background && expected == 1.0);
        }
        assert!(within > 500 && beyond > 100, "{within} {beyond}");
    }
}
