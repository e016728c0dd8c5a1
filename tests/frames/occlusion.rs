//! Is ambient occlusion what formulas say, and is what is kept of it what would be found anew?

use std::f32::consts::PI;
use std::sync::Arc;

use afterimage::animation::TransformTrack;
use afterimage::frame::{Finished, Renderer, Spoil};
use afterimage::layers::Layers;
use afterimage::scene::material::Optics;
use afterimage::scene::{self, Background, Material, Mesh, Model, Scene};
use afterimage::settings::{Backdrop, Filter, Reuse, Settings};
use embree::VertexBuffer;
use glam::{DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::*;

/// One sample a pixel, and the layer with what tells where it is; no mirror shows anything, and `A` is coverage.
fn settings(rays: u32, radius: f64) -> Settings {
    let layers = Layers::OCCLUSION.with(Layers::POSITION).with(Layers::OBJECT);
    let background = Backdrop::Transparent;
    Settings {
        occlusion_rays: rays,
        occlusion_radius: radius,
        layers,
        background,
        depth: 0,
        ..toy::settings(1)
    }
}

fn audited(rays: u32, radius: f64) -> Settings {
    Settings { audit: true, ..settings(rays, radius) }
}

fn first(scene: &Scene, settings: &Settings) -> Finished {
    toy::render(scene, settings, 1).remove(0)
}

fn plane(finished: &Finished, name: &str) -> Vec<f32> {
    finished.film.values(name).expect("the plane is there")
}

/// Where the samples of model number `model` are, and how open.
fn of_model(finished: &Finished, model: f32) -> Vec<(Vec3, f32)> {
    let [x, y, z, id, open] =
        ["P.X", "P.Y", "P.Z", "object.V", "occlusion.V"].map(|name| plane(finished, name));
    let shown = (0..id.len()).filter(|pixel| id[*pixel] == model);
    shown.map(|pixel| (Vec3::new(x[pixel], y[pixel], z[pixel]), open[pixel])).collect()
}

/// A floor of half size 100 in the plane y = 0, and other models on it.
fn on_a_floor(eye: DVec3, others: Vec<Model>) -> Scene {
    let mut models = vec![toy::still("floor", toy::floor(100.0, 0), Vec3::ZERO)];
    models.extend(others);
    let camera = toy::camera(rests(eye), rests(DVec3::ZERO));
    toy::scene(camera, models, vec![toy::matt(0.5)], vec![])
}

fn scaled(mesh: Mesh, factor: f32) -> Mesh {
    let corners = mesh.triangles().positions.as_slice().iter().map(|p| p.map(|at| at * factor)).collect();
    mesh.with_triangles(|triangles| triangles.positions = Arc::new(VertexBuffer::new(corners)))
}

#[test]
fn a_plane_is_open_and_so_is_the_background() {
    let scene = on_a_floor(DVec3::new(0.0, 2.0, 9.0), vec![]);
    let finished = first(&scene, &settings(16, 1000.0));
    let coverage = plane(&finished, "A");
    assert!(coverage.contains(&0.0) && coverage.contains(&1.0), "both are seen");
    assert!(plane(&finished, "occlusion.V").iter().all(|open| *open == 1.0));
}

#[test]
fn a_closed_room_is_closed() {
    let camera = toy::camera(rests(DVec3::new(0.1, 0.05, 0.0)), rests(DVec3::X));
    let room = |casts_shadow| toy::still("room", toy::octahedron(0, casts_shadow), Vec3::ZERO);
    let scene = |models| toy::scene(camera.clone(), models, vec![toy::matt(0.5)], vec![]);
    let open = |scene: &Scene, radius| plane(&first(scene, &settings(16, radius)), "occlusion.V");
    assert!(open(&scene(vec![room(true)]), 4.0).iter().all(|open| *open == 0.0));
    // what casts no shadow does not occlude
    assert!(open(&scene(vec![room(false)]), 4.0).iter().all(|open| *open == 1.0));
    let near = open(&scene(vec![room(true)]), 1e-3);
    assert!(near.iter().sum::<f32>() > 0.9 * near.len() as f32, "rays end before they meet anything");
}

/// Beside an endless wall in a distance of k radii, 1 - (acos k - k sqrt(1 - k²)) / pi is open: half of it at the wall.
#[test]
fn a_floor_beside_a_wall_is_as_open_as_the_formula_says() {
    let corners = [[0.0, 0.0, 100.0], [0.0, 100.0, 100.0], [0.0, 100.0, -100.0], [0.0, 0.0, -100.0]];
    let wall = toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], 0, true);
    let scene = on_a_floor(DVec3::new(3.0, 3.0, 0.5), vec![toy::still("wall", wall, Vec3::ZERO)]);
    for radius in [1.0, 3.0, 60.0] {
        let finished = first(&scene, &settings(64, radius));
        let errors: Vec<f32> = of_model(&finished, 1.0)
            .into_iter()
            .filter(|(place, _)| place.x > 0.01)
            .map(|(place, open)| {
                let k = (place.x / radius as f32).min(1.0);
                open - 1.0 + (k.acos() - k * (1.0 - k * k).sqrt()) / PI
            })
            .collect();
        let count = errors.len() as f32;
        let bias = errors.iter().sum::<f32>() / count;
        let spread = (errors.iter().map(|error| error * error).sum::<f32>() / count).sqrt();
        assert!(count > 1000.0 && bias.abs() < 2e-3 && spread < 0.03, "{radius}: {count} {bias} {spread}");
        if radius == 60.0 {
            let open =
                of_model(&finished, 1.0).into_iter().filter(|(place, _)| (0.1..0.5).contains(&place.x));
            let (sum, count) = open.fold((0.0, 0.0), |(sum, count), (_, open)| (sum + open, count + 1.0));
            assert!((sum / count - 0.5_f32).abs() < 0.01, "{}", sum / count);
        }
    }
}

/// Below the middle of a disc of radius r at height h the share r² / (r² + h²) is closed, and no more than 1 - (h / R)² within
/// a radius R.
#[test]
fn below_a_disc_is_as_open_as_the_formula_says() {
    const SIDES: u32 = 128;
    let (radius, height) = (0.8_f32, 1.0_f32);
    let rim = (0..SIDES).map(|side| {
        let (sin, cos) = (side as f32 / SIDES as f32 * 2.0 * PI).sin_cos();
        [radius * cos, height, radius * sin]
    });
    let corners: Vec<[f32; 3]> = std::iter::once([0.0, height, 0.0]).chain(rim).collect();
    let triangles: Vec<[u32; 3]> = (0..SIDES).map(|side| [0, 1 + side, 1 + (side + 1) % SIDES]).collect();
    let disc = toy::still("disc", toy::mesh(&corners, &triangles, 0, true), Vec3::ZERO);
    let scene = on_a_floor(DVec3::new(0.0, 0.5, 2.0), vec![disc]);
    for (reach, closed) in [(50.0, 0.64 / 1.64), (1.1, 1.0 - 1.0 / (1.1_f32 * 1.1)), (0.9, 0.0)] {
        let finished = first(&scene, &settings(256, reach));
        let near = of_model(&finished, 1.0).into_iter().filter(|(place, _)| place.length() < 0.15);
        let (sum, count) = near.fold((0.0, 0.0), |(sum, count), (_, open)| (sum + open, count + 1.0));
        assert!(
            count > 8.0 && (sum / count - 1.0 + closed).abs() < 0.01,
            "{reach}: {count}, {}",
            sum / count
        );
    }
}

#[test]
fn more_rays_find_the_same_with_less_noise() {
    let scene = world();
    let [few, many, most] =
        [4, 16, 256].map(|rays| plane(&first(&scene, &settings(rays, 2.0)), "occlusion.V"));
    let mean = |open: &[f32]| open.iter().sum::<f32>() / open.len() as f32;
    let error = |open: &[f32]| {
        let squares = open.iter().zip(&most).map(|(open, truth)| (open - truth).powi(2));
        (squares.sum::<f32>() / open.len() as f32).sqrt()
    };
    assert!(mean(&most) < 0.99 && (mean(&few) - mean(&most)).abs() < 5e-3, "{} {}", mean(&few), mean(&most));
    assert!(error(&many) < 0.6 * error(&few), "{} {}", error(&many), error(&few));
}

/// Ambient light times openness; what is emitted is not dimmed.
#[test]
fn ambient_light_is_dimmed_by_occlusion() {
    let mut scene = world();
    scene.lights.clear();
    scene.ambient = Vec3::new(0.2, 0.4, 0.8);
    scene.background = Background::uniform(Vec3::ZERO);
    scene.models.truncate(2);
    let glow = Vec3::new(0.0, 0.0, 3.0);
    scene.materials[0].emission = glow;
    let layers = Layers::OCCLUSION.with(Layers::EMISSION);
    let settings = Settings { layers, ..audited(16, 3.0) };
    let plain = first(&scene, &settings);
    scene.ambient_is_occluded = true;
    let occluded = first(&scene, &settings);
    assert_eq!((toy::differing(&plain), toy::differing(&occluded)), (0, 0));
    let [shown, alpha] = ["occlusion.V", "A"].map(|name| plane(&occluded, name));
    assert_eq!(shown, plane(&plain, "occlusion.V"));
    let mut dimmed = 0;
    for (channel, part) in ["R", "G", "B"].into_iter().zip(0..) {
        let reflected = 0.6 * scene.ambient[part];
        let [bright, dark] = [&plain, &occluded].map(|finished| plane(finished, channel));
        let emission = plane(&occluded, &format!("emission.{channel}"));
        for pixel in (0..shown.len()).filter(|pixel| alpha[*pixel] == 1.0) {
            let expected = |openness: f32| glow[part] + reflected * openness;
            assert!((bright[pixel] - expected(1.0)).abs() < 3e-3, "{channel} {pixel}");
            assert!((dark[pixel] - expected(shown[pixel])).abs() < 3e-3, "{channel} {pixel}");
            assert_eq!(dark[pixel], emission[pixel], "{channel} {pixel}");
            dimmed += usize::from(shown[pixel] < 0.9);
        }
    }
    assert!(dimmed > 500, "{dimmed}");
    // the layer is not needed for it
    let alone = first(&scene, &Settings { layers: Layers::NONE, ..settings });
    assert_eq!(plane(&alone, "G"), plane(&occluded, "G"));
    assert_eq!(toy::differing(&alone), 0);
}

#[test]
fn mirrors_show_ambient_light_dimmed() {
    let mirror = Material { optics: Optics::Mirror { tint: Vec3::ONE, fresnel: false }, ..toy::matt(0.0) };
    let corners = [[0.5, -9.0, -9.0], [0.5, 9.0, -9.0], [0.5, 0.0, 9.0]];
    let models = vec![
        toy::still("room", scaled(toy::octahedron(0, true), 2.0), Vec3::ZERO),
        toy::still("mirror", toy::mesh(&corners, &[[0, 1, 2]], 1, true), Vec3::ZERO),
    ];
    let camera = toy::camera(rests(DVec3::new(-0.5, 0.1, 0.1)), rests(DVec3::X));
    let mut scene = toy::scene(camera, models, vec![toy::matt(0.5), mirror], vec![]);
    scene.ambient = Vec3::ONE;
    let shown = |scene: &Scene, radius| {
        let settings = Settings { depth: 2, layers: Layers::ALL, ..audited(16, radius) };
        let finished = first(scene, &settings);
        assert_eq!(toy::differing(&finished), 0);
        let reflected = plane(&finished, "reflection.G");
        reflected.iter().sum::<f32>() / reflected.len() as f32
    };
    let bright = shown(&scene, 20.0);
    scene.ambient_is_occluded = true;
    assert!(bright > 0.3, "{bright}");
    assert_eq!(shown(&scene, 20.0), 0.0, "the room is closed");
    let near = shown(&scene, 0.2);
    assert!(near > 0.2 && near < 0.99 * bright, "{near} {bright}");
}

fn occluded(mut scene: Scene) -> Scene {
    scene.ambient_is_occluded = true;
    scene
}

fn camera_goes(scene: Scene) -> Scene {
    with_camera(scene, goes(EYE, EYE + DVec3::new(0.3, 0.1, -0.4)), rests(TARGET))
}

fn camera_turns(scene: Scene) -> Scene {
    with_camera(scene, rests(EYE), goes(TARGET, TARGET + DVec3::X * 0.3))
}

/// A wall of what is shaded smoothly moves, too: some directions by its normals lie below its triangles.
fn with_smooth_mover(mut scene: Scene) -> Scene {
    let mesh = toy::octahedron(0, true);
    let normals =
        mesh.triangles().positions.as_slice().iter().map(|corner| Vec3::from_array(*corner)).collect();
    let track = TransformTrack {
        translate: toy::keys(&[(2.0, DVec3::new(0.0, 0.6, 2.0)), (4.0, DVec3::new(0.5, 0.6, 2.0))]),
        scale: rests(DVec3::splat(0.6)),
        ..TransformTrack::identity()
    };
    let smooth = mesh.with_triangles(|triangles| triangles.normals = normals);
    scene.models.push(toy::moving("smooth", smooth, track));
    scene
}

/// Whatever moves: all samples are as open as they keep.
#[test]
fn what_is_kept_is_what_would_be_found_anew() {
    type Change = fn(Scene) -> Scene;
    let changes: [(&str, &[Change]); 8] = [
        ("nothing", &[]),
        ("a flyer", &[with_flyer]),
        ("a flyer and the camera", &[with_flyer, camera_goes]),
        ("a flyer and a smooth one", &[with_flyer, with_smooth_mover]),
        ("a smooth one that comes to rest, and the camera", &[with_smooth_mover, camera_goes]),
        ("area lights", &[with_flyer, with_area_lights, camera_goes]),
        ("a camera that turns", &[with_flyer, camera_turns]),
        ("the camera", &[camera_goes]),
    ];
    for (name, changes) in changes {
        let scene = changes.iter().fold(occluded(world()), |scene, change| change(scene));
        let reuse = Reuse::Target;
        let base =
            Settings { layers: Layers::ALL, depth: 3, width: 80, height: 60, reuse, ..audited(7, 1.5) };
        for settings in [
            base.clone(),
            Settings { samples: 2, filter: Filter::Mitchell, ..base.clone() },
            Settings { paths: 3, layers: Layers::NONE, ..base.clone() },
            Settings { reuse: Reuse::Paper, ..base },
        ] {
            for finished in toy::render(&scene, &settings, FRAMES) {
                let (frame, layers) = (finished.stats.frame, settings.layers);
                assert_eq!(toy::differing(&finished), 0, "{name}, frame {frame}, {layers:?}");
            }
        }
    }
}

#[test]
fn frames_may_be_rendered_backwards_and_in_steps() {
    let scene = occluded(with_smooth_mover(with_flyer(world())));
    let mut renderer = Renderer::new(&scene, &audited(8, 2.0)).expect("the scene builds");
    for frame in [6, 4, 4, 2, 5, 1, 6, 9] {
        let finished = renderer.render(frame, true).expect("renders");
        assert_eq!(toy::differing(&finished), 0, "frame {frame}");
    }
}

/// A small thing that moves.
fn with_fly(mut scene: Scene) -> Scene {
    let track = TransformTrack {
        translate: goes(DVec3::new(-1.0, 0.4, 1.5), DVec3::new(1.0, 0.4, 1.5)),
        scale: rests(DVec3::splat(0.1)),
        ..TransformTrack::identity()
    };
    scene.models.push(toy::moving("fly", toy::octahedron(0, true), track));
    scene
}

/// Most of what is found stays. Without lights all shadow rays are those of occlusion.
#[test]
fn few_rays_are_cast_again() {
    let mut scene = world();
    scene.models.truncate(2);
    scene.lights.clear();
    let shares = |scene: &Scene, radius: f64| -> Vec<f64> {
        let frames = toy::render(scene, &settings(8, radius), FRAMES);
        let rays = |finished: &Finished| finished.stats.rays.shadow as f64;
        assert!(rays(&frames[0]) > 20_000.0);
        frames[1..].iter().map(|finished| rays(finished) / rays(&frames[0])).collect()
    };
    let none = shares(&scene, 1.0);
    assert!(none.iter().all(|share| *share == 0.0), "nothing moves: {none:?}");
    let camera = shares(&camera_goes(scene.clone()), 1.0);
    assert!(camera.iter().all(|share| *share > 0.0 && *share < 0.1), "the camera alone: {camera:?}");
    let fly = with_fly(scene);
    let [near, far] = [0.3, 3.0].map(|radius| shares(&fly, radius));
    assert!(near.iter().all(|share| *share > 0.0 && *share < 0.1), "{near:?}");
    assert!(far.iter().zip(&near).all(|(far, near)| far > near && *far < 0.6), "{far:?}");
    let both = shares(&camera_goes(fly), 0.3);
    assert!(both.iter().all(|share| *share > 0.0 && *share < 0.2), "{both:?}");
}

#[test]
fn who_does_not_ask_pays_nothing() {
    let mut scene = camera_goes(with_flyer(world()));
    let with = |scene: &Scene, layers: Layers, rays: u32| {
        let settings = Settings { layers, depth: 4, ..settings(rays, 2.0) };
        let mut renderer = Renderer::new(scene, &settings).expect("the scene builds");
        let rays: Vec<_> =
            (1..=FRAMES).map(|frame| renderer.render(frame, true).expect("renders").stats.rays).collect();
        (rays, renderer.memory().store_bytes)
    };
    let few = with(&scene, Layers::USUAL, 1);
    assert_eq!(few, with(&scene, Layers::USUAL, 256), "whatever it would cost");
    scene.ambient = Vec3::ZERO;
    scene.ambient_is_occluded = true;
    assert_eq!(few, with(&scene, Layers::USUAL, 16), "there is no ambient light");
    // samples have eight bytes more, with their seeds, and so many rays from each surface
    let (rays, bytes) = with(&scene, Layers::USUAL.with(Layers::OCCLUSION), 16);
    let surfaces = plane(&first(&scene, &settings(1, 1.0)), "A").iter().sum::<f32>();
    assert_eq!(rays[0].shadow - few.0[0].shadow, 16 * surfaces as u64);
    let other = |of: &afterimage::stats::RayCounts| of.total() - of.shadow;
    assert!(rays.iter().zip(&few.0).all(|(more, few)| other(more) == other(few)));
    assert!(bytes > few.1 + 8 * 96 * 72, "{bytes} {}", few.1);
}

#[test]
fn threads_change_no_bit() {
    let scene = occluded(camera_goes(with_flyer(world())));
    let render = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        let settings = Settings { samples: 2, layers: Layers::ALL, depth: 3, ..settings(9, 2.0) };
        pool.install(|| toy::render(&scene, &settings, 4))
    };
    for (one, other) in render(1).iter().zip(&render(4)) {
        assert_eq!(one.stats.rays, other.stats.rays);
        for name in one.film.planes.iter().map(|plane| &*plane.name) {
            let same =
                plane(one, name).iter().zip(&plane(other, name)).all(|(a, b)| a.to_bits() == b.to_bits());
            assert!(same, "frame {}, {name}", one.stats.frame);
        }
    }
}

/// What is held to be open for a frame too long does not show what has come near.
#[test]
fn an_audit_finds_what_is_kept_a_frame_too_long() {
    for scene in [with_flyer(world()), camera_goes(with_flyer(world()))] {
        let found = |spoils: bool| {
            let mut renderer = Renderer::new(&scene, &audited(8, 2.0)).expect("the scene builds");
            renderer.render(1, true).expect("renders");
            renderer.render(2, true).expect("renders");
            if spoils {
                assert!(renderer.spoil(Spoil::Openness).expect("no rays are cast") > 100);
            }
            toy::differing(&renderer.render(3, true).expect("renders"))
        };
        assert_eq!(found(false), 0);
        assert!(found(true) > 20, "{}", found(true));
    }
}

/// A tiny shot, or one far away, is rendered in another space: its radius is that of its files.
#[test]
fn the_radius_scales_with_the_shot() {
    let folder = tempfile::tempdir().expect("there is room");
    let open = |scale: f64, aside: f64, radius: &str| {
        let at = |x: f64, y: f64, z: f64| format!("{} {} {}", x * scale + aside, y * scale, z * scale);
        let corners = [at(-4.0, 0.0, 4.0), at(4.0, 0.0, 4.0), at(4.0, 0.0, -4.0), at(-4.0, 0.0, -4.0)];
        let wall = [at(-4.0, 2.0, -4.0), at(4.0, 2.0, -4.0)];
        let vertices: String = corners.iter().chain(&wall).map(|corner| format!("v {corner}\n")).collect();
        let obj = format!("{vertices}f 1 2 3 4\nf 4 3 6 5\n");
        std::fs::write(folder.path().join("m.obj"), obj).expect("there is room");
        let [eye, target] = [at(0.0, 3.0, 5.0), at(0.0, 0.0, -2.0)].map(|place| place.replace(' ', ", "));
        let text = format!(
            "[render]\nsize = [48, 36]\nsamples = 1\n[output]\nlayers = [\"occlusion\"]\n{radius}[[camera.key]]\n\
             frame = 1\neye = [{eye}]\ntarget = [{target}]\n[[model]]\nobj = \"m.obj\"\n"
        );
        let path = folder.path().join("s.toml");
        std::fs::write(&path, text).expect("there is room");
        let shot = scene::load(&path, true).expect("it is good");
        let open = plane(&first(&shot.scene, &shot.settings), "occlusion.V");
        open.iter().sum::<f32>() / open.len() as f32
    };
    // the diagonal: 8, 8 and 2 long
    let given = |scale: f64| format!("[occlusion]\nradius = {:e}\n", 132_f64.sqrt() / 10.0 * scale);
    let usual = open(1.0, 0.0, "");
    assert!(usual > 0.8 && usual < 0.99, "{usual}");
    for (scale, aside) in [(1.0, 0.0), (1e-6, 0.0), (1e9, 0.0), (1.0, 1000.0)] {
        for radius in ["", &given(scale)] {
            let open = open(scale, aside, radius);
            assert!((open - usual).abs() < 3e-3, "{scale} {aside} {radius}: {open}, {usual}");
        }
    }
}
