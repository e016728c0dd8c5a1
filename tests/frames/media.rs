//! Is light right that passes through media, that they emit and scatter, and is what is kept of it what would be made anew?

use std::f32::consts::PI;

use afterimage::animation::TransformTrack;
use afterimage::frame::Renderer;
use afterimage::scene::medium::Medium;
use afterimage::scene::{Background, Environment, LightKind, Material, Mesh, Scene};
use afterimage::settings::{Backdrop, Mode, Settings};
use afterimage::stereo::{Eye, Stereo};
use afterimage::trace::BackendKind;
use glam::{DVec3, Vec3};

use crate::changing::{CHANGES, expect_nothing_found};
use crate::toy;
use crate::toy::worlds::*;

const INK: Medium = Medium { absorb: Vec3::new(0.2, 0.7, 1.5), ..Medium::NONE };

const SMOKE: Medium = Medium {
    scatter: Vec3::new(0.5, 0.4, 0.3),
    absorb: Vec3::new(0.05, 0.1, 0.2),
    emit: Vec3::ZERO,
    anisotropy: 0.0,
};

/// What is in a mesh, without a surface around it.
fn filling(medium: Medium) -> Material {
    Material { medium: Some(medium), has_surface: false, ..toy::matt(0.0) }
}

/// A box of this size about the origin.
fn cuboid(size: Vec3, material: u16) -> Mesh {
    let corner = |number: u32| {
        let side = |bit: u32, half: f32| if number >> bit & 1 == 1 { half } else { -half };
        [side(0, 0.5 * size.x), side(1, 0.5 * size.y), side(2, 0.5 * size.z)]
    };
    let corners: Vec<[f32; 3]> = (0..8).map(corner).collect();
    let faces = [[4, 5, 7, 6], [1, 0, 2, 3], [5, 1, 3, 7], [0, 4, 6, 2], [6, 7, 3, 2], [0, 1, 5, 4]];
    let triangles: Vec<[u32; 3]> =
        faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    toy::mesh(&corners, &triangles, material, true)
}

/// A box of a medium about the origin, seen straight on from `eye`, before a background of 1.
fn seen_from(eye: DVec3, size: Vec3, medium: Medium) -> Scene {
    let camera = toy::camera(rests(eye), rests(eye - DVec3::Z));
    let models = vec![toy::still("box", cuboid(size, 0), Vec3::ZERO)];
    let mut scene = toy::scene(camera, models, vec![filling(medium)], vec![]);
    scene.background = Background::uniform(Vec3::ONE);
    scene.hide_media();
    scene
}

fn middle(scene: &Scene, settings: &Settings) -> Vec3 {
    let finished = toy::render(scene, settings, 1).remove(0);
    assert_eq!(toy::differing(&finished), 0);
    let around = (0..16).map(|number| toy::color(&finished, 46 + number % 4, 34 + number / 4));
    around.sum::<Vec3>() / 16.0
}

fn visible() -> Settings {
    Settings { background: Backdrop::Visible, ..toy::audited(1) }
}

fn near(found: Vec3, wanted: Vec3, within: f32, what: &str) {
    assert!((found - wanted).abs().max_element() < within, "{what}: {found}, not {wanted}");
}

/// Light fades with the length of its way in a medium, wherever the eye is, and media that overlap add up.
#[test]
fn light_fades_on_its_way() {
    for (eye, inside) in [(6.0, 3.0), (1.0, 2.5), (0.0, 1.5), (-6.0, 0.0)] {
        let scene = seen_from(DVec3::new(0.0, 0.0, eye), Vec3::new(40.0, 40.0, 3.0), INK);
        near(middle(&scene, &visible()), (-INK.absorb * inside).exp(), 4e-3, "ink");
    }
    let mut scene = seen_from(DVec3::new(0.0, 0.0, 6.0), Vec3::new(40.0, 40.0, 3.0), INK);
    scene.models.push(toy::still("other", cuboid(Vec3::new(40.0, 40.0, 1.0), 0), Vec3::ZERO));
    scene.hide_media();
    near(middle(&scene, &visible()), (-INK.absorb * 4.0).exp(), 4e-3, "one in the other");
    // and what fills everything lets nothing through that is without end
    scene.fog = Some(Medium { emit: Vec3::splat(0.5), ..INK });
    let emitted = middle(&scene, &visible());
    let apart = Vec3::splat(0.5) / INK.absorb;
    let before = 1.0 - (-INK.absorb * 4.5).exp();
    let behind = (-INK.absorb * (4.5 + 3.0 * 2.0 + 1.0)).exp();
    assert!((emitted - apart * before).min_element() > 0.0 && behind.max_element() < 0.2, "{emitted}");
}

#[test]
fn a_medium_shines_by_what_it_emits() {
    let fire = Medium { emit: Vec3::new(0.5, 0.25, 2.0), ..INK };
    for thickness in [0.1, 2.0] {
        let scene = seen_from(DVec3::new(0.0, 0.0, 6.0), Vec3::new(4.0, 4.0, thickness), fire);
        let left = (-fire.absorb * thickness).exp();
        let wanted = left + fire.emit / fire.absorb * (1.0 - left);
        near(middle(&scene, &visible()), wanted, 4e-3, "fire");
    }
    let clear = Medium { emit: Vec3::ONE, ..Medium::NONE };
    let scene = seen_from(DVec3::new(0.0, 0.0, 6.0), Vec3::new(4.0, 4.0, 0.5), clear);
    near(middle(&scene, &visible()), Vec3::splat(1.5), 4e-3, "a clear one");
}

/// Coverage is what of the background is hidden.
#[test]
fn media_cover_what_they_hide() {
    let grey = Medium { absorb: Vec3::splat(0.7), ..Medium::NONE };
    let scene = seen_from(DVec3::new(0.0, 0.0, 6.0), Vec3::new(4.0, 4.0, 1.0), grey);
    let settings = Settings { background: Backdrop::Transparent, ..toy::audited(1) };
    let finished = toy::render(&scene, &settings, 1).remove(0);
    let [covered, open] = [[48, 36], [1, 1]].map(|[x, y]| toy::pixel(&finished, "A", x, y));
    assert!((covered - (1.0 - (-0.7_f32).exp())).abs() < 2e-3 && open == 0.0, "{covered} {open}");
}

/// Density, in solid angle, of what goes on at this cosine.
fn phase(g: f32, cos: f32) -> f32 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5))
}

/// Light of a sun from above that a layer scatters once, in whatever direction it prefers.
#[test]
fn a_layer_scatters_the_light_of_a_sun() {
    for anisotropy in [0.0, 0.5, -0.3] {
        let smoke = Medium { anisotropy, ..SMOKE };
        for (direction, cos) in [(DVec3::NEG_Y, 0.0), (DVec3::new(0.0, -1.0, 1.0), -0.5_f32.sqrt())] {
            let size = Vec3::new(4.0, 3.0, 1.5);
            let mut scene = seen_from(DVec3::new(0.0, 0.0, 6.0), size, smoke);
            scene.background = Background::uniform(Vec3::ZERO);
            let kind = LightKind::Directional { direction: rests(direction) };
            scene.lights.push(toy::light("sun", kind, 2.0));
            let settings = Settings { volume_samples: 16, ..visible() };
            let seen = middle(&scene, &settings);
            // by steps along the eye's ray, at each of which the sun's way is known
            let (extinction, steps) = (smoke.extinction(), 4000);
            let mut wanted = Vec3::ZERO;
            for step in 0..steps {
                let depth = size.z * (step as f32 + 0.5) / steps as f32;
                let way = if cos == 0.0 {
                    0.5 * size.y
                } else {
                    // to the top, or out of the far side
                    2.0_f32.sqrt() * (0.5 * size.y).min(size.z - depth)
                };
                wanted += (-extinction * (depth + way)).exp() * smoke.scatter * (size.z / steps as f32);
            }
            // light straight on comes towards the eye: it is turned from where the sun goes to where the eye is
            let turned = phase(anisotropy, if cos == 0.0 { 0.0 } else { 0.5_f32.sqrt() });
            let wanted = wanted * turned * 2.0 * PI;
            near(seen / wanted, Vec3::ONE, 0.02, &format!("{anisotropy} {direction}"));
        }
    }
}

/// Light of a lamp in a box, from near and from far.
#[test]
fn a_box_scatters_the_light_of_a_lamp() {
    for at in [DVec3::new(0.0, 0.9, 0.2), DVec3::new(0.0, 4.0, 1.0)] {
        let size = Vec3::splat(2.0);
        let mut scene = seen_from(DVec3::new(0.0, 0.0, 6.0), size, SMOKE);
        scene.background = Background::uniform(Vec3::ZERO);
        scene.lights.push(lamp(at.x, at.y, at.z));
        let settings = Settings { volume_samples: 64, ..visible() };
        let seen = middle(&scene, &settings);
        let (extinction, steps, mut wanted) = (SMOKE.extinction(), 4000, Vec3::ZERO);
        for step in 0..steps {
            let depth = size.z * (step as f32 + 0.5) / steps as f32;
            let point = Vec3::new(0.0, 0.0, 0.5 * size.z - depth);
            let to_lamp = at.as_vec3() - point;
            let distance = to_lamp.length();
            let way = distance * (0.5 * size.y / to_lamp.y.max(0.5 * size.y)).min(1.0);
            let arrives = 9.0 / (distance * distance) * (-extinction * (depth + way)).exp();
            wanted += arrives * SMOKE.scatter * (size.z / steps as f32);
        }
        let wanted = wanted * phase(0.0, 0.0) * PI;
        near(seen / wanted, Vec3::ONE, 0.03, &format!("{at}"));
    }
}

/// In even light all around a medium that absorbs nothing cannot be seen, however often light is scattered in it.
#[test]
fn what_absorbs_nothing_is_not_seen_in_even_light() {
    for (scatter, anisotropy) in [(0.3, 0.0), (2.0, 0.0), (2.0, 0.6)] {
        let milk = Medium { scatter: Vec3::splat(scatter), anisotropy, ..Medium::NONE };
        let mut scene = seen_from(DVec3::new(0.0, 0.0, 6.0), Vec3::splat(2.0), milk);
        scene.environment = Some(Environment::from_background(&scene.background));
        let settings = Settings { paths: 1, bounces: 2, volume_bounces: 60, volume_samples: 16, ..visible() };
        near(middle(&scene, &settings), Vec3::ONE, 0.03, &format!("{scatter} {anisotropy}"));
    }
}

/// Surfaces in media are lit by what is left of the light: of lamps, of the sky, and of what paths bring.
#[test]
fn surfaces_get_what_media_leave() {
    let camera = toy::camera(rests(DVec3::new(0.0, 0.4, 1.0)), rests(DVec3::ZERO));
    let floor = toy::still("floor", toy::floor(50.0, 0), Vec3::ZERO);
    let layer = toy::still("layer", cuboid(Vec3::new(400.0, 1.0, 400.0), 1), Vec3::new(0.0, 2.0, 0.0));
    let mut scene = toy::scene(camera, vec![floor, layer], vec![toy::matt(0.5), filling(INK)], vec![]);
    scene.hide_media();
    scene.background = Background::uniform(Vec3::ZERO);
    scene.lights.push(toy::sun_overhead(1.0));
    near(middle(&scene, &visible()), 0.5 * (-INK.absorb).exp(), 2e-3, "a sun");
    scene.lights.clear();
    scene.background = Background::uniform(Vec3::ONE);
    scene.environment = Some(Environment::from_background(&scene.background));
    let settings = Settings { paths: 256, bounces: 1, ..visible() };
    // by the cosine law: 2 E3(1) of what comes from all around
    let wanted = 0.5 * 2.0 * 0.109_692;
    let thin = Medium { absorb: Vec3::ONE, ..Medium::NONE };
    scene.materials[1].medium = Some(thin);
    near(middle(&scene, &settings), Vec3::splat(wanted), 0.004, "a sky");
}

/// A world with a box of smoke in it that a ball flies through, and fog everywhere, if that is asked for.
fn misty(fog: f32) -> Scene {
    let mut scene = world();
    let material = scene.materials.len() as u16;
    scene.materials.push(filling(Medium { anisotropy: 0.4, ..SMOKE }));
    let smoke = cuboid(Vec3::new(3.0, 2.0, 2.5), material);
    scene.models.insert(1, toy::still("smoke", smoke, Vec3::new(0.5, 1.2, 0.3)));
    if fog > 0.0 {
        scene.fog = Some(Medium { scatter: Vec3::new(0.5, 0.7, 1.0) * fog, ..Medium::NONE });
    }
    scene.hide_media();
    scene
}

/// The box of smoke goes on its way.
fn smoke_goes(mut scene: Scene) -> Scene {
    let track = TransformTrack {
        translate: goes(DVec3::ZERO, DVec3::new(0.8, 0.1, 0.2)),
        rotate: goes(DVec3::ZERO, DVec3::new(0.0, 12.0, 0.0)),
        ..TransformTrack::identity()
    };
    scene.models[1].track = track;
    scene
}

#[test]
fn reuse_in_media_is_exact() {
    // each two of paths, media and changes meet
    let settings = |paths| Settings { paths, volume_bounces: 2, ..toy::settings(1) };
    expect_nothing_found(&misty(0.0), &CHANGES[1..], &settings(0));
    expect_nothing_found(&misty(0.05), &[&[smoke_goes], CHANGES[2]], &settings(1));
    expect_nothing_found(&smoke_goes(misty(0.0)), &CHANGES[..1], &settings(1));
}

#[test]
fn both_tracers_and_both_eyes_see_the_same_media() {
    let scene = smoke_goes(CHANGES[0].iter().fold(misty(0.02), |scene, change| change(scene)));
    let settings = Settings { paths: 1, ..toy::audited(1) };
    let mean = |kind| {
        let mut renderer = Renderer::with(kind, &scene, &settings).expect("the scene builds");
        let frames: Vec<_> = [1, 2, 3].map(|frame| renderer.render(frame, true).expect("renders")).into();
        assert!(frames.iter().all(|finished| toy::differing(finished) == 0), "{}", kind.name());
        let green = frames[2].film.values("G").expect("it is there");
        green.iter().sum::<f32>() / green.len() as f32
    };
    let [rust, embree] = [BackendKind::Rust, BackendKind::Embree].map(mean);
    assert!((rust / embree - 1.0).abs() < 1e-3, "{rust} {embree}");
    let stereo = Some(Stereo { separation: 0.2, convergence: Some(7.0) });
    let mut renderer = Renderer::new(&scene, &Settings { stereo, ..settings }).expect("the scene builds");
    for frame in 1..=2 {
        for eye in Eye::BOTH {
            assert_eq!(toy::differing(&renderer.render_eye(eye, frame, true).expect("renders")), 0);
        }
    }
}

/// Before a camera at rest what media show is kept while it holds, and is the same to the bit as what is made in full; for any number of
/// threads.
#[test]
fn what_media_show_is_kept_while_nothing_moves() {
    let settings = Settings { paths: 1, width: 64, height: 48, ..toy::settings(1) };
    let run = |scene: &Scene, settings: &Settings, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let mut renderer = Renderer::new(scene, settings).expect("the scene builds");
            let mut frames = (1..=5).map(|frame| renderer.render(frame, true).expect("renders"));
            let mut last = frames.by_ref().map(|finished| {
                let green = finished.film.values("G").expect("it is there");
                let bits: Vec<u32> = green.iter().map(|value| value.to_bits()).collect();
                (bits, finished.stats.rays.gathering + finished.stats.rays.shadow)
            });
            let all: Vec<_> = last.by_ref().collect();
            all
        })
    };
    for scene in [misty(0.02), smoke_goes(misty(0.0)), with_flyer(misty(0.02))] {
        let kept = run(&scene, &settings, 3);
        let full = run(&scene, &Settings { mode: Mode::Full, ..settings.clone() }, 2);
        let anew = run(&scene, &Settings { tree_memory: 0, ..settings.clone() }, 1);
        for frame in 0..5 {
            assert!(kept[frame].0 == anew[frame].0, "frame {frame}");
        }
        let is_still = scene.models[1].track.is_constant();
        if is_still && scene.models.iter().all(|model| model.track.is_constant()) {
            assert_eq!(kept[3].1, 0, "nothing moves: no ray is cast");
            assert!(kept[3].0 == full[3].0, "what is kept is what is made in full");
        }
        assert!(kept[4].1 <= full[4].1, "{} {}", kept[4].1, full[4].1);
    }
}

/// A medium without a surface is met by no ray, and one in a mesh with a surface is as well behind it.
/// In parallel views the background is seen beside a box, and through it, along lines of its cells.
#[test]
fn the_background_of_parallel_views_is_seen_along_lines_of_its_cells() {
    let keys = "[[camera.key]]\nframe = 1\neye = [0, 0, 6]\ntarget = [0, 0, 0]\nheight = 8\n[[camera.key]]\nframe = 3\neye = [1, 0, 6]\ntarget = [1, 0, 0]\nheight = 8\n";
    let scene = graded_from(keys, "", "");
    for (frame, finished) in
        toy::render(&scene, &Settings { width: 64, height: 64, ..visible() }, 3).iter().enumerate()
    {
        assert_eq!(toy::differing(finished), 0);
        for pixel in [2, 40, 44, 47, 60] {
            let at = (pixel as f32 + 0.5) / 64.0 * 8.0 - 4.0 + 0.5 * frame as f32;
            let inside = if at.abs() < 2.0 { at.max(0.0) } else { 0.0 };
            let found = toy::color(finished, pixel, 33).y;
            assert!((found - (-2.0 * inside).exp()).abs() < 5e-3, "{frame} {pixel}: {found}");
        }
    }
}

#[test]
fn a_medium_is_no_surface() {
    let nothing = Medium { absorb: Vec3::splat(1e-9), ..Medium::NONE };
    let mut scene = seen_from(DVec3::new(0.0, 0.0, 6.0), Vec3::splat(2.0), nothing);
    near(middle(&scene, &visible()), Vec3::ONE, 1e-6, "it is not there");
    let finished = toy::render(&scene, &visible(), 1).remove(0);
    assert_eq!(toy::pixel(&finished, "Z", 48, 36), 1e10);
    // with a surface it is seen from outside, and what is inside is not
    scene.materials[0] = Material { emission: Vec3::splat(0.25), medium: Some(INK), ..toy::matt(0.0) };
    scene.models[0].ray_visibility = Default::default();
    near(middle(&scene, &visible()), Vec3::splat(0.25), 1e-3, "a wall");
}

/// A box whose density a graph gives: as much as the place is to the right of its middle, in object space.
const MTLX: &str = "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n<nodegraph name=\"G\"><position name=\"p\" type=\"vector3\"/>\
    <separate3 name=\"s\" type=\"multioutput\"><input name=\"in\" type=\"vector3\" nodename=\"p\"/></separate3>\
    <max name=\"n\" type=\"float\"><input name=\"in1\" type=\"float\" nodename=\"s\" output=\"outx\"/><input name=\"in2\" type=\"float\" value=\"0\"/></max>\
    <output name=\"out\" type=\"vector3\" nodename=\"n\"/></nodegraph>\n\
    <anisotropic_vdf name=\"V\" type=\"VDF\"><input name=\"absorption\" type=\"vector3\" nodegraph=\"G\" output=\"out\"/>SCATTER</anisotropic_vdf>\n\
    <volume name=\"S\" type=\"volumeshader\"><input name=\"vdf\" type=\"VDF\" nodename=\"V\"/></volume>\n\
    <volumematerial name=\"m\" type=\"material\"><input name=\"volumeshader\" type=\"volumeshader\" nodename=\"S\"/></volumematerial>\n</materialx>\n";

/// A box about the origin, four wide and two deep, with that in it, before a background of 1; `rest`: more of the shot.
fn graded(scatter: &str, rest: &str) -> Scene {
    graded_from("[[camera.key]]\nframe = 1\neye = [0, 0, 6]\ntarget = [0, 0, 0]\nheight = 4\n", scatter, rest)
}

/// The same, seen from these places in parallel.
fn graded_from(keys: &str, scatter: &str, rest: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let mut obj = String::new();
    for number in 0..8 {
        let side = |bit: u32, half: f32| if number >> bit & 1 == 1 { half } else { -half };
        obj += &format!("v {} {} {}\n", side(0, 2.0), side(1, 2.0), side(2, 1.0));
    }
    obj += "usemtl m\nf 5 6 8 7\nf 2 1 3 4\nf 6 2 4 8\nf 1 5 7 3\nf 7 8 4 3\nf 1 2 6 5\n";
    write("m.obj", &obj);
    write("m.mtlx", &MTLX.replace("SCATTER", scatter));
    let camera = format!("[camera]\nprojection = \"orthographic\"\n{keys}");
    let material = "[[material]]\nname = \"m\"\nmtlx = \"m.mtlx\"\nvolume_cells = 64\n";
    write(
        "s.toml",
        &format!("[background]\ncolor = [1, 1, 1]\n{camera}[[model]]\nobj = \"m.obj\"\n{rest}{material}"),
    );
    let shot = afterimage::scene::load(&folder.path().join("s.toml"), true).unwrap();
    assert!(shot.warnings.is_empty(), "{:?}", shot.warnings);
    shot.scene
}

/// Density that varies is that of each cell's middle, wherever the model is and however it is turned.
#[test]
fn density_follows_its_graph() {
    let turned =
        "[[model.key]]\nframe = 1\nrotate = [0, 0, 90]\n[[model.key]]\nframe = 2\nrotate = [0, 0, 91]\n";
    for (rest, is_turned) in [("", false), (turned, true)] {
        let finished =
            toy::render(&graded("", rest), &Settings { width: 64, height: 64, ..visible() }, 1).remove(0);
        assert_eq!(toy::differing(&finished), 0);
        for along in [4, 20, 31, 33, 40, 50, 60] {
            let [x, y] = if is_turned { [30, 63 - along] } else { [along, 30] };
            let at = (along as f32 + 0.5) / 64.0 * 4.0 - 2.0;
            // 64 cells of a 16th: a place's own is at most half of one off
            let [least, most] = [at + 0.04, at - 0.04].map(|at| (-2.0 * at.max(0.0)).exp());
            let found = toy::color(&finished, x, y).y;
            assert!(least - 2e-3 <= found && found <= most + 2e-3, "{along}: {found}, not {least} to {most}");
        }
    }
}

#[test]
fn reuse_in_media_that_vary_is_exact() {
    let moves = "[[model.key]]\nframe = 1\n[[model.key]]\nframe = 4\nrotate = [0, 30, 0]\ntranslate = [0.5, 0.2, 0]\n";
    let scatter = "<input name=\"scattering\" type=\"vector3\" nodegraph=\"G\" output=\"out\"/>";
    for rest in ["", moves] {
        let light = "[[light]]\ntype = \"point\"\nposition = [1, 3, 2]\npower = 9\n";
        let mut scene = graded(scatter, &format!("{rest}{light}"));
        scene.materials.push(toy::matt(0.5));
        let floor = toy::floor(9.0, scene.materials.len() as u16 - 1);
        scene.models.push(toy::still("floor", floor, Vec3::Y * -1.2));
        scene.environment = Some(Environment::from_background(&scene.background));
        scene.camera =
            toy::camera(goes(DVec3::new(0.0, 1.0, 6.0), DVec3::new(1.0, 1.5, 6.0)), rests(DVec3::ZERO));
        for finished in
            toy::render(&scene, &Settings { paths: 2, width: 48, height: 36, ..toy::audited(1) }, 4)
        {
            assert_eq!(toy::differing(&finished), 0, "{rest}");
        }
    }
}
