//! Samples that exposures share: is what comes into sight traced once and not once an exposure, and are the samples of a pixel
//! different ones all the same?

use afterimage::animation::TransformTrack;
use afterimage::exposure::Shutter;
use afterimage::film::Film;
use afterimage::frame::Renderer;
use afterimage::scene::Scene;
use afterimage::scene::camera::CameraTrack;
use afterimage::settings::{Mode, Refinement, Settings};
use afterimage::stereo::Stereo;
use glam::{DVec3, Vec3};

use crate::blur::with_lens;
use crate::toy;
use crate::toy::worlds::*;

/// Frame from which on a camera that [turns](turning) rests.
const RESTS: i32 = 6;

fn settings(samples: u32) -> Settings {
    let shutter = Some(Shutter::new(-0.25, 0.25));
    Settings { shutter, exposures: Some(4), paths: 2, bounces: 1, ..toy::settings(samples) }
}

/// Turns by some pixels a frame, and then rests.
fn turning() -> CameraTrack {
    let away = TARGET + DVec3::new(9.0, 0.0, 2.0);
    toy::camera(rests(EYE), toy::keys(&[(1.0, TARGET), (f64::from(RESTS) - 0.5, away)]))
}

/// A floor below a ceiling, and a lamp that makes a spot on it; nothing in the picture has an edge.
fn between_floor_and_ceiling() -> Scene {
    let ceiling = [[-30.0, 6.0, -30.0], [30.0, 6.0, -30.0], [30.0, 6.0, 30.0], [-30.0, 6.0, 30.0]];
    let models = vec![
        toy::still("floor", toy::floor(30.0, 0), Vec3::ZERO),
        toy::still("ceiling", toy::mesh(&ceiling, &[[0, 1, 2], [0, 2, 3]], 0, true), Vec3::ZERO),
    ];
    toy::scene(turning(), models, vec![toy::matt(0.8)], vec![lamp(0.0, 5.5, 1.0)])
}

/// The same, but for a thing far away that moves: exposures share nothing then.
fn with_something_that_moves(mut scene: Scene) -> Scene {
    let track = TransformTrack {
        translate: toy::keys(&[(-90.0, DVec3::new(0.0, 900.0, 0.0)), (90.0, DVec3::new(9.0, 900.0, 0.0))]),
        ..TransformTrack::identity()
    };
    scene.models.push(toy::moving("far", toy::octahedron(0, true), track));
    scene
}

#[test]
fn what_comes_into_sight_is_traced_once() {
    let scene = between_floor_and_ceiling();
    let [shared, each] = [scene.clone(), with_something_that_moves(scene)].map(|scene| {
        let frames = toy::render(&scene, &settings(4), RESTS - 1);
        frames[1..].iter().map(toy::traced).sum::<u64>()
    });
    assert!(shared * 2 < each, "{shared} of {each}");
}

/// Root of the mean square of the difference in green.
fn apart(film: &Film, truth: &Film) -> f64 {
    let (shown, truth) = (film.values("G").unwrap(), truth.values("G").unwrap());
    let squares = shown.iter().zip(&truth).map(|(a, b)| f64::from(a - b).powi(2));
    (squares.sum::<f64>() / shown.len() as f64).sqrt()
}

/// While the camera turns, and after it has come to rest.
#[test]
fn the_samples_of_a_pixel_stay_different_ones() {
    let small = |samples: u32| Settings { width: 64, height: 48, ..settings(samples) };
    let scene = between_floor_and_ceiling();
    let asked = [RESTS - 1, RESTS + 1];
    let truths = {
        let settings = Settings { mode: Mode::Full, paths: 16, ..small(12) };
        let mut renderer = Renderer::new(&scene, &settings).unwrap();
        asked.map(|frame| renderer.render(frame, false).unwrap())
    };
    let errors = |scene: &Scene| {
        let frames = toy::render(scene, &small(4), asked[1]);
        [0, 1].map(|at| apart(&frames[asked[at] as usize - 1].film, &truths[at].film))
    };
    let (shared, each) = (errors(&scene), errors(&with_something_that_moves(scene.clone())));
    for ((frame, shared), each) in asked.into_iter().zip(shared).zip(each) {
        println!("frame {frame}: {shared}, and {each} where none is shared");
        assert!(shared < 1.08 * each, "frame {frame}: {shared}, and {each} where none is shared");
    }
}

/// With lenses, two eyes, levels of samples, and all that a room of mirrors and glass has.
#[test]
fn shared_samples_are_exact() {
    let mut still = world();
    still.ambient_is_occluded = true;
    still.camera = turning();
    let refinement = Some(Refinement { most: 4, threshold: 0.05 });
    let two_eyes = Some(Stereo { separation: 0.2, convergence: Some(6.0) });
    let table = [
        ("turns", 0.0, settings(2)),
        ("turns, many exposures", 0.0, Settings { exposures: Some(16), ..settings(4) }),
        ("a lens", 0.2, Settings { shutter: None, ..settings(4) }),
        ("a lens, and turns", 0.1, Settings { occlusion_rays: 4, occlusion_radius: 1.5, ..settings(2) }),
        ("levels", 0.0, Settings { refinement, ..settings(2) }),
        ("two eyes", 0.1, Settings { stereo: two_eyes, ..settings(2) }),
    ];
    for (name, radius, settings) in table {
        let scene = with_lens(still.clone(), radius);
        let mut renderer = Renderer::new(&scene, &Settings { audit: true, ..settings }).unwrap();
        for frame in 1..=RESTS + 1 {
            for eye in renderer.eyes() {
                let finished = renderer.render_eye(*eye, frame, true).unwrap();
                assert_eq!(toy::differing(&finished), 0, "{name}, frame {frame}, {eye:?}");
            }
        }
    }
}
