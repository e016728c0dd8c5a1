//! Are reflected paths that are kept as good as fresh ones, and are they drawn anew when they should be?

use afterimage::frame::{Finished, Renderer, Spoil};
use afterimage::layers::Layers;
use afterimage::scene::{Environment, LightKind, Scene};
use afterimage::settings::{Mode, Settings};
use afterimage::stereo::{Eye, Stereo};
use glam::{DVec3, Vec3};

use crate::changing::with_metal_flyer;
use crate::metal_rough::{metal_rough, reflected, rough_world};
use crate::toy;
use crate::toy::worlds::*;

/// Width of a lobe of this roughness.
const ROUGHNESS: f32 = 0.5;
const ALPHA: f64 = 0.25;

/// Distance of the eye: so far away that it sees all of the picture in nearly the same direction.
const FAR: f64 = 500.0;

fn settings(reflections: u32) -> Settings {
    Settings { reflections, layers: Layers::new(["reflection"]).expect("it is one"), ..toy::settings(1) }
}

/// Quarters of the sky are bright and dark in turn: in whatever direction one looks along an axis, what is mirrored there has an
/// edge.
fn quartered() -> Environment {
    let texel = |i: usize| if i % 64 / 16 % 2 == 0 { [2.0, 1.5, 1.0] } else { [0.02, 0.03, 0.05] };
    Environment::from_picture(64, 32, (0..64 * 32).flat_map(texel).collect()).expect("it is good")
}

/// A floor of rough metal that is seen at an angle with this cosine in frame 1, under a sky with edges and beside a lamp, a panel and a
/// surface that glows. In frame 2 the eye has turned around the floor by `turn` radians.
fn seen_from_afar(cos: f64, turn: f64) -> Scene {
    let sin = (1.0 - cos * cos).sqrt();
    let eye = |turn: f64| {
        // the horizontal turn by which the direction to the eye turns as much
        let around = turn / sin;
        DVec3::new(sin * around.sin(), cos, sin * around.cos()) * FAR
    };
    let glows = afterimage::scene::Material { emission: Vec3::splat(20.0), ..toy::matt(0.3) };
    let lamp = LightKind::Point { position: rests(DVec3::new(20.0, 60.0, -90.0)) };
    let mut panel = panel(rests(DVec3::new(-60.0, 50.0, -60.0)));
    panel.power = afterimage::animation::Track::constant(8000.0);
    let models = vec![
        toy::still("floor", toy::floor(4000.0, 0), Vec3::ZERO),
        toy::still("block", toy::octahedron(1, true), Vec3::new(0.0, 12.0, -60.0)),
    ];
    let camera = toy::camera(toy::keys(&[(1.0, eye(0.0)), (2.0, eye(turn))]), rests(DVec3::ZERO));
    let materials = vec![metal_rough(0.9, ROUGHNESS, 1.0), glows];
    let lights = vec![toy::light("lamp", lamp, 3000.0), panel];
    Scene { environment: Some(quartered()), ..toy::scene(camera, models, materials, lights) }
}

/// The middle of what is reflected in each frame: half of the picture's width and of its height.
fn in_the_middle(finished: &Finished) -> Vec3 {
    let places = (18..54).flat_map(|y| (24..72).map(move |x| (x, y)));
    let of = |plane: &'static str, places: Vec<(u32, u32)>| {
        let count = places.len() as f32;
        places.iter().map(|(x, y)| toy::pixel(finished, plane, *x, *y)).sum::<f32>() / count
    };
    let places: Vec<(u32, u32)> = places.collect();
    Vec3::from(["reflection.R", "reflection.G", "reflection.B"].map(|plane| of(plane, places.clone())))
}

/// Whatever share of the limit the eye has turned, and at grazing angles: the mean of what kept paths show is that of fresh ones. A
/// weight for the eye of their birth would show the picture of that eye, and a limit that looked at paths would favour some of them.
#[test]
fn kept_paths_show_the_same_light_as_fresh_ones() {
    for cos in [0.7, 0.25] {
        for share in [0.0, 0.25, 0.5, 1.0, 1.4] {
            let turn = share * 0.5 * ALPHA * cos;
            let scene = seen_from_afar(cos, turn);
            let settings = Settings { samples: 2, paths: 1, bounces: 1, ..settings(16) };
            let kept = toy::render(&scene, &settings, 2);
            let drawn = kept[1].stats.rays.reflection as f64 / kept[0].stats.rays.reflection as f64;
            let mut renderer = Renderer::new(&scene, &settings).expect("the scene builds");
            let fresh = renderer.render(2, false).expect("renders");
            let [before, seen, fresh] = [&kept[0], &kept[1], &fresh].map(in_the_middle);
            let case =
                format!("cosine {cos}, {share} of the limit: {drawn} drawn, {seen}, {fresh}, {before}");
            assert!(((seen / fresh - Vec3::ONE).abs().max_element()) < 0.01, "{case}");
            // limits are from half of the mean one to one and a half
            let expected = (share - 0.5).clamp(0.0, 1.0);
            assert!((drawn - expected).abs() < 0.12, "{case}");
            if share >= 1.0 && cos > 0.5 {
                assert!((before / fresh - Vec3::ONE).abs().max_element() > 0.03, "{case}");
            }
        }
    }
}

/// Not all samples draw anew in one frame, and each does in its time.
#[test]
fn a_camera_that_goes_on_pays_in_no_frame_for_all() {
    let turn = 0.1 * 0.5 * ALPHA * 0.7;
    let mut scene = seen_from_afar(0.7, turn);
    let eye = |frame: i32| {
        let around = f64::from(frame) * turn / 0.51_f64.sqrt();
        DVec3::new(0.51_f64.sqrt() * around.sin(), 0.7, 0.51_f64.sqrt() * around.cos()) * FAR
    };
    let keys: Vec<(f64, DVec3)> = (1..=40).map(|frame| (f64::from(frame), eye(frame))).collect();
    scene.camera = toy::camera(toy::keys(&keys), rests(DVec3::ZERO));
    let rays: Vec<u64> =
        toy::render(&scene, &settings(4), 40).iter().map(|f| f.stats.rays.reflection).collect();
    let most = rays[1..].iter().max().expect("there are frames");
    assert!(*most < rays[0] / 4, "{rays:?}");
    let all: u64 = rays[1..].iter().sum();
    assert!(all > 3 * rays[0], "{rays:?}");
}

/// The right eye shows the paths of the left one, weighted for itself.
#[test]
fn the_right_eye_weights_the_paths_of_the_left_one() {
    let scene = seen_from_afar(0.7, 0.0);
    let stereo = Stereo { separation: 10.0, convergence: Some(FAR) };
    let settings = Settings { stereo: Some(stereo), audit: true, samples: 2, ..settings(16) };
    let both = |mode: Mode| {
        let mut renderer = Renderer::new(&scene, &Settings { mode, ..settings.clone() }).expect("builds");
        let reuse = mode != Mode::Full;
        Eye::BOTH.map(|eye| renderer.render_eye(eye, 1, reuse).expect("renders"))
    };
    let ([left, right], [_, fresh]) = (both(Mode::Reproject), both(Mode::Full));
    assert!(right.stats.rays.reflection * 10 < left.stats.rays.reflection, "most are kept");
    assert_eq!(toy::differing(&right), 0);
    let [kept, fresh] = [&right, &fresh].map(in_the_middle);
    assert!((kept / fresh - Vec3::ONE).abs().max_element() < 0.01, "{kept}, {fresh}");
}

/// What shows other light than it should is found.
#[test]
fn an_audit_finds_spoilt_reflections() {
    for what in [Spoil::Reflected, Spoil::DrawnFor, Spoil::ReflectedUntil] {
        let found = |spoils: bool| {
            let scene = with_metal_flyer(rough_world());
            let settings = Settings { depth: 3, audit: true, paths: 2, bounces: 2, ..settings(4) };
            let mut renderer = Renderer::new(&scene, &settings).expect("the scene builds");
            (1..=2).for_each(|frame| drop(renderer.render(frame, true).expect("renders")));
            if spoils {
                assert!(renderer.spoil(what).expect("no rays are cast") > 20, "{what:?}");
            }
            renderer.render(3, true).expect("renders").stats.audit.expect("asked for").differing
        };
        assert_eq!(found(false), 0);
        assert!(found(true) > 20, "{what:?}: {}", found(true));
    }
}

/// A rough floor beside a small bright surface: no pixel is much brighter than what is around it in a picture without
/// noise. Paths that meet the surface by chance would bring all of its light, if rays that ask it did not count as well.
#[test]
fn a_small_bright_surface_makes_no_sparks() {
    for roughness in [0.5, 0.7] {
        let glows = afterimage::scene::Material { emission: Vec3::splat(2000.0), ..toy::matt(0.0) };
        let models = vec![
            toy::still("floor", toy::floor(40.0, 0), Vec3::ZERO),
            toy::still("lamp", toy::floor(0.05, 1), Vec3::new(0.3, 0.6, 0.0)),
        ];
        let camera =
            toy::camera(goes(DVec3::new(0.0, 1.5, 4.0), DVec3::new(0.5, 1.5, 3.5)), rests(DVec3::ZERO));
        let scene = toy::scene(camera, models, vec![metal_rough(0.5, roughness, 1.0), glows], vec![]);
        let settings = Settings { width: 64, height: 48, paths: 4, bounces: 2, ..toy::settings(1) };
        let fine = Settings { samples: 6, reflections: 8, mode: Mode::Full, ..settings.clone() };
        let wanted = Renderer::new(&scene, &fine).expect("builds").render(4, false).expect("renders");
        let frames = toy::render(&scene, &settings, 4);
        let at = |finished: &Finished, x: u32, y: u32| toy::pixel(finished, "R", x, y);
        let (width, height) = (settings.width, settings.height);
        let mut worst = (0.0, 0, 0);
        for (x, y) in (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y))) {
            let around = (0..9).map(|i| at(&wanted, x + i % 3 - 1, y + i / 3 - 1)).fold(0.0, f32::max);
            let ratio = at(&frames[3], x, y) / around.max(0.01);
            if ratio > worst.0 {
                worst = (ratio, x, y);
            }
        }
        assert!(worst.0 < 6.0, "{roughness}: {worst:?}");
    }
}

/// However rough, however many, wherever the eye is: numbers.
#[test]
fn extremes_are_numbers() {
    for roughness in [0.0, 0.0447, 0.045, 0.1, 1.0] {
        for reflections in [0, 1, 64] {
            for height in [0.0, 1e-6, 0.01, 3.0] {
                let mut scene = seen_from_afar(0.7, 0.0);
                scene.materials[0] = metal_rough(0.9, roughness, 1.0);
                let eye = goes(DVec3::new(0.0, height, 40.0), DVec3::new(1.0, height, 40.0));
                scene.camera = toy::camera(eye, rests(DVec3::new(0.0, 12.0, -60.0)));
                let settings = Settings { width: 24, height: 18, audit: true, ..settings(reflections) };
                for finished in toy::render(&scene, &settings, 3) {
                    let case = format!("{roughness}, {reflections} from {height}");
                    assert_eq!(toy::differing(&finished), 0, "{case}");
                    assert!(reflected(&finished).is_finite(), "{case}");
                }
            }
        }
    }
}
