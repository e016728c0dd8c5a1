//! Reflection maps: do they show what is around a model, and is what is kept of them what would be made anew?

use afterimage::frame::{Finished, Renderer};
use afterimage::scene::material::Optics;
use afterimage::scene::{Background, Material, Scene};
use afterimage::settings::{Filter, Settings};
use afterimage::stereo::{Eye, Stereo};
use glam::{DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::*;

/// The same scene, the mirror and the glass of which have maps.
fn mapped(mut scene: Scene, size: u32) -> Scene {
    for model in scene.models.iter_mut().filter(|model| ["mirror", "glass", "ball"].contains(&&*model.name)) {
        model.reflection_map = Some(size);
    }
    scene
}

/// A ball that is a mirror of this radius in the middle of what is around it.
fn ball_in(mut scene: Scene, radius: f64) -> Scene {
    let optics = Optics::Mirror { tint: Vec3::ONE, fresnel: false };
    let material = scene.materials.len() as u16;
    scene.materials.push(Material { optics, ..toy::matt(0.0) });
    let place = glam::DAffine3::from_scale(DVec3::splat(radius));
    scene.models.push(toy::still_quadric("ball", &toy::sphere(), material, true, place));
    with_camera(scene, rests(DVec3::new(0.0, 0.0, 4.0 * radius)), rests(DVec3::ZERO))
}

fn check(finished: &Finished, what: &str) {
    let audit = finished.stats.audit.unwrap();
    assert_eq!(audit.wrong(), 0, "{what}, frame {}: {audit:?}", finished.stats.frame);
}

fn plane(finished: &Finished, name: &str) -> Vec<f32> {
    finished.film.values(name).unwrap().to_vec()
}

/// The root of the mean square of how far two frames are apart.
fn apart(a: &Finished, b: &Finished, name: &str) -> f32 {
    let (a, b) = (plane(a, name), plane(b, name));
    (a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f32>() / a.len() as f32).sqrt()
}

/// What is infinitely far away looks the same from everywhere: a map of it has no error but that of its texels.
#[test]
fn a_map_of_the_sky_is_what_rays_find() {
    let mut empty = toy::scene(toy::camera(rests(DVec3::Z), rests(DVec3::ZERO)), vec![], vec![], vec![]);
    empty.background = Background {
        zenith: Vec3::new(0.1, 0.2, 0.9),
        horizon: Vec3::new(0.9, 0.7, 0.5),
        ground: Vec3::splat(0.2),
    };
    let scene = ball_in(empty, 1.0);
    let settings = toy::audited(2);
    let [rays, coarse, fine] = [scene.clone(), mapped(scene.clone(), 16), mapped(scene, 256)]
        .map(|scene| toy::render(&scene, &settings, 1).swap_remove(0));
    for finished in [&rays, &coarse, &fine] {
        check(finished, "a sky");
    }
    let [coarse, fine] = [coarse, fine].map(|finished| apart(&rays, &finished, "reflection.R"));
    assert!(fine < 2e-3 && coarse > 4.0 * fine, "{coarse}, {fine}");
}

/// The nearer something is for its size, the further a map is from the truth: the model's middle is not its surface.
#[test]
fn the_error_falls_with_the_size_of_the_model() {
    let error = |radius: f64| {
        let mut room = world();
        room.models.retain(|model| model.name == "matt");
        let scene = ball_in(room, radius);
        let settings = toy::audited(2);
        let both =
            [scene.clone(), mapped(scene, 256)].map(|scene| toy::render(&scene, &settings, 1).swap_remove(0));
        both.iter().for_each(|finished| check(finished, "a ball"));
        apart(&both[0], &both[1], "reflection.G")
    };
    let errors = [0.8, 0.2, 0.01].map(error);
    assert!(errors[0] > 1.3 * errors[1] && errors[1] > 1.5 * errors[2], "{errors:?}");
    assert!(errors[2] < 0.02 && errors[0] > 0.02, "{errors:?}");
}

#[test]
fn what_is_kept_is_what_would_be_made_anew() {
    let camera =
        |scene: Scene| with_camera(scene, goes(EYE, EYE + DVec3::new(0.6, 0.2, -0.8)), rests(TARGET));
    let mut fades = world();
    fades.lights[1].power = toy::keys(&[(3.0, 9.0), (5.0, 3.0)]);
    let usual = Settings { width: 64, height: 48, ..toy::audited(1) };
    for settings in [
        usual.clone(),
        Settings { filter: Filter::Mitchell, samples: 2, ..usual.clone() },
        Settings { paths: 3, ..usual },
    ] {
        for (name, scene) in [
            ("at rest", world()),
            ("the camera", camera(world())),
            ("a flyer", with_flyer(world())),
            ("a flyer and the camera", camera(with_flyer(world()))),
            ("a lamp that fades", fades.clone()),
            ("soft lights", with_flyer(with_area_lights(world()))),
        ] {
            for finished in toy::render(&mapped(scene.clone(), 24), &settings, FRAMES) {
                check(&finished, name);
            }
        }
    }
}

/// Maps take rays in frames in which something has moved, and no others.
#[test]
fn a_map_is_kept_while_nothing_moves() {
    let texels = 6 * 26 * 26;
    let secondary = |scene: Scene| -> Vec<u64> {
        let frames = toy::render(&mapped(scene, 24), &toy::settings(1), FRAMES);
        frames
            .iter()
            .map(|finished| finished.stats.rays.reflection + finished.stats.rays.refraction)
            .collect()
    };
    let camera = |scene: Scene| with_camera(scene, goes(EYE, EYE + DVec3::X * 0.5), rests(TARGET));
    let kept = secondary(camera(world()));
    assert!(kept[0] >= 2 * texels, "two maps: {kept:?}");
    assert_eq!(kept[1..], [0; 5], "the camera alone");
    let mut late = with_flyer(world());
    let flyer = late.models.last_mut().unwrap();
    flyer.track.translate = toy::keys(&[(4.0, DVec3::new(-1.0, 2.0, 1.0)), (5.0, DVec3::new(0.0, 2.0, 1.0))]);
    (flyer.track.rotate, flyer.track.scale) = (rests(DVec3::ZERO), rests(DVec3::splat(0.5)));
    let remade = secondary(camera(late));
    let makes: Vec<bool> = remade.iter().map(|rays| *rays >= 2 * texels).collect();
    assert_eq!(makes, [true, false, false, false, true, false], "{remade:?}");
}

/// What a mirror shows moves with what it shows, although the mirror and its map stay in their place.
#[test]
fn maps_show_what_moves() {
    let scene = mapped(ball_in(with_flyer(world()), 0.8), 64);
    let mut renderer = Renderer::new(&scene, &toy::audited(1)).unwrap();
    let shown: Vec<Vec<f32>> = (1..=FRAMES)
        .map(|frame| {
            let finished = renderer.render(frame, true).unwrap();
            check(&finished, "a flyer in a mirror");
            plane(&finished, "reflection.R")
        })
        .collect();
    assert!(shown.windows(2).all(|pair| pair[0] != pair[1]));
}

#[test]
fn both_eyes_look_up_the_same_maps() {
    let scene = mapped(with_flyer(world()), 16);
    let stereo = Some(Stereo { separation: 0.2, convergence: Some(7.0) });
    let mut renderer = Renderer::new(&scene, &Settings { stereo, ..toy::audited(1) }).unwrap();
    for frame in 1..=3 {
        let [left, right] = Eye::BOTH.map(|eye| renderer.render_eye(eye, frame, true).unwrap());
        check(&left, "left");
        check(&right, "right");
        assert!(
            left.stats.rays.reflection >= 2 * 6 * 18 * 18 && right.stats.rays.reflection == 0,
            "made once"
        );
    }
}

#[test]
fn frames_are_the_same_for_any_number_of_threads_and_wherever_a_run_begins() {
    let scene = mapped(with_flyer(world()), 24);
    let settings = Settings { paths: 2, ..toy::settings(1) };
    let run = |threads: usize, first: i32| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut renderer = Renderer::new(&scene, &settings).unwrap();
            (first..=4).map(|frame| renderer.render(frame, frame != 3).unwrap()).collect::<Vec<_>>()
        })
    };
    let (one, three, late) = (run(1, 1), run(3, 1), run(2, 3));
    for name in ["R", "G", "B"] {
        for (a, b) in one.iter().zip(&three).chain(one[2..].iter().zip(&late)) {
            assert!(plane(a, name) == plane(b, name), "frame {}, {name}", a.stats.frame);
        }
    }
}

#[test]
fn an_audit_finds_a_map_that_is_not_what_it_should_be() {
    let scene = mapped(with_camera(world(), goes(EYE, EYE + DVec3::X * 0.5), rests(TARGET)), 16);
    let mut renderer = Renderer::new(&scene, &toy::audited(1)).unwrap();
    check(&renderer.render(1, true).unwrap(), "as it was made");
    check(&renderer.render(2, true).unwrap(), "kept");
    renderer.spoil_maps();
    let audit = renderer.render(3, true).unwrap().stats.audit.unwrap();
    assert_eq!(audit.differing, 2 * 6 * 18 * 18, "all texels of both maps");
}
