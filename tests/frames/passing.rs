//! Models that appear and disappear: is reuse exact, is nothing left of what has gone, and is what is away no cost?

use afterimage::animation::{Track, TransformTrack, Visibility};
use afterimage::frame::{Finished, Renderer};
use afterimage::layers::Layers;
use afterimage::scene::{Background, Material, Scene};
use afterimage::settings::{Filter, Mode, Refinement, Settings};
use afterimage::stereo::{Eye, Stereo};
use afterimage::trace::BackendKind;
use glam::{DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::*;

/// In which frames the last model of a scene is there.
const PATTERNS: [(bool, &[(f64, bool)]); 4] = [
    (true, &[(3.0, false), (5.0, true)]),
    (false, &[(2.0, true), (4.5, false)]),
    (true, &[(2.0, false), (3.0, true), (4.0, false), (5.0, true), (6.0, false)]),
    (false, &[(6.0, true)]),
];

/// The same scene, the last model of which comes and goes.
fn passing(mut scene: Scene, (before, keys): (bool, &[(f64, bool)])) -> Scene {
    let model = scene.models.last_mut().unwrap();
    model.track.visible = Visibility::through(before, keys.to_vec()).unwrap();
    scene
}

/// A world through which a model flies; others in which it stands still, until long after.
fn scenes() -> [Scene; 3] {
    let mut stands = world();
    let at = DVec3::new(-0.4, 1.6, 1.5);
    let translate = toy::keys(&[(1.0, at), (99.0, at), (100.0, DVec3::ZERO)]);
    let place = TransformTrack { translate, ..TransformTrack::identity() };
    stands.models.push(toy::moving("stands", toy::octahedron(0, true), place.clone()));
    let mut ball = world();
    ball.models.push(toy::moving_quadric("ball", &toy::sphere(), 1, place));
    [with_flyer(world()), stands, ball]
}

fn camera_goes(scene: Scene) -> Scene {
    with_camera(scene, goes(EYE, EYE + DVec3::new(0.6, 0.2, -0.8)), rests(TARGET))
}

fn check(finished: &Finished, what: &str) {
    let audit = finished.stats.audit.unwrap();
    assert_eq!(audit.wrong(), 0, "{what}, frame {}: {audit:?}", finished.stats.frame);
}

#[test]
fn reuse_is_exact() {
    type Change = fn(Scene) -> Scene;
    let changes: [(&str, Change); 3] =
        [("at rest", |scene| scene), ("the camera goes", camera_goes), ("soft lights", with_area_lights)];
    // each two of scene, pattern and change meet
    for (number, scene) in scenes().into_iter().enumerate() {
        for (at, pattern) in PATTERNS.into_iter().enumerate() {
            let (name, change) = changes[(number + at) % changes.len()];
            let scene = change(passing(scene.clone(), pattern));
            for finished in toy::render(&scene, &toy::audited(2), FRAMES) {
                check(&finished, &format!("{number}, {name}, {pattern:?}"));
            }
        }
    }
}

#[test]
fn reuse_is_exact_by_every_way_of_rendering() {
    let usual = toy::audited(1);
    let refinement = Some(Refinement { most: 3, threshold: 0.05 });
    let ways = [
        ("paths", Settings { paths: 4, bounces: 2, ..usual.clone() }),
        ("a wide filter", Settings { filter: Filter::Mitchell, ..usual.clone() }),
        ("adaptive samples", Settings { refinement, ..usual.clone() }),
        ("occlusion", Settings { occlusion_rays: 9, occlusion_radius: 1.5, ..usual }),
    ];
    for (name, settings) in ways {
        for scene in [with_flyer(world()), camera_goes(with_flyer(world()))] {
            let mut scene = passing(scene, PATTERNS[0]);
            scene.ambient_is_occluded = name == "occlusion";
            for finished in toy::render(&scene, &settings, FRAMES) {
                check(&finished, name);
            }
        }
    }
}

#[test]
fn reuse_is_exact_with_the_other_tracer_and_backwards() {
    let scene = passing(with_flyer(world()), PATTERNS[0]);
    for kind in [BackendKind::Rust, BackendKind::Embree] {
        let settings = Settings { paths: 3, ..toy::audited(1) };
        let mut renderer = Renderer::with(kind, &scene, &settings).unwrap();
        for frame in [6, 4, 4, 3, 2, 5, 1, 3] {
            check(&renderer.render(frame, true).unwrap(), kind.name());
        }
    }
}

#[test]
fn both_eyes_see_what_is_there() {
    let scene = passing(camera_goes(with_flyer(world())), PATTERNS[2]);
    let stereo = Some(Stereo { separation: 0.2, convergence: Some(7.0) });
    let mut renderer = Renderer::new(&scene, &Settings { stereo, ..toy::audited(1) }).unwrap();
    for frame in 1..=FRAMES {
        Eye::BOTH
            .into_iter()
            .for_each(|eye| check(&renderer.render_eye(eye, frame, true).unwrap(), "stereo"));
    }
}

/// A surface that emits light, and appears elsewhere than it went.
#[test]
fn light_comes_and_goes_with_what_emits_it() {
    for pattern in PATTERNS {
        let mut scene = with_flyer(world());
        let material = scene.materials.len() as u16;
        scene.materials.push(Material { emission: Vec3::new(5.0, 4.0, 2.0), ..toy::matt(0.3) });
        scene.models.last_mut().unwrap().mesh = toy::octahedron(material, true).into();
        scene.background = Background::uniform(Vec3::splat(0.1));
        let scene = passing(scene, pattern);
        for scene in [scene.clone(), camera_goes(scene)] {
            let frames = toy::render(&scene, &Settings { paths: 5, ..toy::audited(1) }, FRAMES);
            frames.iter().for_each(|finished| check(finished, "an emitter"));
        }
    }
}

/// All planes but those that say how a picture was made.
fn picture(finished: &Finished) -> Vec<(String, Vec<u32>)> {
    let shown = finished.film.planes.iter().filter(|plane| {
        !["status", "rays", "age", "motion", "forward", "backward"]
            .iter()
            .any(|name| plane.name.starts_with(name))
    });
    let bits = |name: &str| finished.film.values(name).unwrap().iter().map(|value| value.to_bits()).collect();
    shown.map(|plane| (plane.name.to_string(), bits(&plane.name))).collect()
}

/// Frames are those of a scene that has the model, or of one that has not.
#[test]
fn nothing_is_left_of_what_has_gone() {
    let settings = Settings { mode: Mode::Full, paths: 2, ..toy::settings(1) };
    let full = |scene: &Scene| {
        let mut renderer = Renderer::new(scene, &settings).unwrap();
        (1..=FRAMES).map(|frame| picture(&renderer.render(frame, false).unwrap())).collect::<Vec<_>>()
    };
    for scene in scenes() {
        let present = full(&scene);
        let mut without = scene.clone();
        without.models.pop();
        let absent = full(&without);
        for pattern in PATTERNS {
            let visible = Visibility::through(pattern.0, pattern.1.to_vec()).unwrap();
            let frames = full(&passing(scene.clone(), pattern));
            for (frame, ((shown, present), absent)) in (1..).zip(frames.iter().zip(&present).zip(&absent)) {
                let is_there = visible.at(frame.into());
                assert!(present != absent, "or nothing is tested");
                assert!(shown == if is_there { present } else { absent }, "frame {frame}, {pattern:?}");
            }
        }
    }
}

/// What flies while it is away moves nothing: frames cost what they cost in a still world.
#[test]
fn what_is_away_is_no_cost() {
    let mut scene = passing(with_flyer(matt_world()), (true, &[(3.0, false), (6.0, true)]));
    scene.models.retain(|model| model.name != "flyer" || !model.track.visible.is_always());
    let frames = toy::render(&scene, &toy::settings(2), FRAMES);
    let rays = |frame: usize| frames[frame - 1].stats.rays;
    for frame in [4, 5] {
        assert_eq!(
            (rays(frame).primary, rays(frame).verification, rays(frame).shadow),
            (0, 0, 0),
            "frame {frame}"
        );
    }
    for frame in [2, 3, 6] {
        assert!(rays(frame).primary > 0 && rays(frame).shadow > 0, "frame {frame}: it moved");
        assert!(rays(frame).primary * 10 < rays(1).primary, "frame {frame}: and little with it");
    }
}

/// Where a model was before it appeared, and will be after it has gone, is not known.
#[test]
fn motion_vectors_end_where_a_model_does() {
    let mut scene = passing(with_flyer(matt_world()), (false, &[(3.0, true), (5.0, false)]));
    scene.models.retain(|model| model.name != "flyer" || !model.track.visible.is_always());
    let flyer = scene.models.len() as f32 - 1.0;
    let settings = Settings { layers: Layers::ALL, ..toy::audited(1) };
    let frames = toy::render(&scene, &settings, FRAMES);
    frames.iter().for_each(|finished| check(finished, "motion"));
    let longest = |frame: usize, names: [&str; 2]| {
        let film = &frames[frame - 1].film;
        let [x, y] = names.map(|name| film.values(name).unwrap());
        let models = film.values("object.V").unwrap();
        let of_flyer = (0..models.len()).filter(|pixel| models[*pixel] == flyer + 1.0);
        of_flyer
            .map(|pixel| glam::Vec2::new(x[pixel], y[pixel]).length())
            .fold(None, |most, length| Some(length.max(most.unwrap_or(0.0))))
    };
    let (backward, forward) = (["backward.U", "backward.V"], ["forward.U", "forward.V"]);
    assert_eq!([2, 5].map(|frame| longest(frame, forward)), [None; 2], "it is not there");
    assert!(longest(3, forward).unwrap() > 1.0 && longest(4, backward).unwrap() > 1.0);
    assert_eq!((longest(3, backward), longest(4, forward)), (Some(0.0), Some(0.0)));
    // all of its pixels, and no others, have vectors that are not known
    for (frame, name, is_known) in [(3, "backward.A", false), (3, "forward.A", true), (4, "forward.A", false)]
    {
        let film = &frames[frame - 1].film;
        let models = film.values("object.V").unwrap();
        for (known, model) in film.values(name).unwrap().iter().zip(&models) {
            assert_eq!(
                *known,
                f32::from(u8::from(is_known || *model != flyer + 1.0)),
                "{name}, frame {frame}"
            );
        }
    }
}

/// A shot may lose all that it has, or have nothing from the beginning.
#[test]
fn an_empty_stage_shows_the_background() {
    let mut scene = passing(with_flyer(world()), (true, &[(3.0, false)]));
    scene.models.drain(..scene.models.len() - 1);
    for scene in [scene.clone(), with_camera(scene, goes(EYE, EYE + DVec3::X), Track::constant(TARGET))] {
        let frames = toy::render(&scene, &toy::audited(1), FRAMES);
        frames.iter().for_each(|finished| check(finished, "an empty stage"));
        for finished in &frames[2..] {
            assert_eq!(toy::color(finished, 48, 36), Vec3::new(0.25, 0.5, 1.0));
        }
        let nothing = Scene { models: vec![], ..scene };
        toy::render(&nothing, &toy::audited(1), 3).iter().for_each(|finished| check(finished, "nothing"));
    }
}
