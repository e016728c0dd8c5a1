//! Do motion vectors lead to where a point was and will be?

use afterimage::animation::{Track, TransformTrack};
use afterimage::film::Film;
use afterimage::frame::Renderer;
use afterimage::layers::Layers;
use afterimage::scene::Scene;
use afterimage::settings::Settings;
use glam::{DVec3, Vec2, Vec3};

use crate::toy;
use crate::toy::worlds::*;

fn settings(samples: u32) -> Settings {
    Settings { layers: Layers::ALL, ..toy::audited(samples) }
}

/// The pictures of frames `numbers`, each inferred from the one before it.
fn films(scene: &Scene, settings: &Settings, numbers: impl IntoIterator<Item = i32>) -> Vec<Film> {
    let mut renderer = Renderer::new(scene, settings).unwrap();
    let film = |frame| {
        let finished = renderer.render(frame, true).unwrap();
        assert_eq!(toy::differing(&finished), 0, "frame {frame}");
        Film::clone(&finished.film)
    };
    numbers.into_iter().map(film).collect()
}

/// The vectors of a layer, to the right and upwards.
fn vectors(film: &Film, names: [&str; 2]) -> Vec<Vec2> {
    let [x, y] = names.map(|name| film.values(name).unwrap());
    x.iter().zip(&y).map(|(x, y)| Vec2::new(*x, *y)).collect()
}

/// A floor seen from 4 units above by a camera with a right angle from top to bottom, which moves by (0.5, 0, 0.25) a frame.
fn over_the_floor() -> Scene {
    let at = |frame: f64| DVec3::new(0.5, 0.0, 0.25) * frame;
    let along = |offset: DVec3| toy::keys(&[(1.0, at(1.0) + offset), (5.0, at(5.0) + offset)]);
    let mut camera = toy::camera(along(DVec3::Y * 4.0), along(DVec3::NEG_Z * 1e-6));
    camera.fov = Track::constant(90.0);
    toy::scene(
        camera,
        vec![toy::still("floor", toy::floor(50.0, 0), Vec3::ZERO)],
        vec![toy::matt(0.5)],
        vec![toy::sun_overhead(1.0)],
    )
}

#[test]
fn a_camera_that_travels_moves_the_floor_against_its_way() {
    // 36 pixels are 4 units; the picture's top is -Z, so that the camera goes right and down, and the floor left and up
    let a_frame = Vec2::new(-0.5, 0.25) * 36.0 / 4.0;
    for film in films(&over_the_floor(), &settings(1), 2..=4) {
        for (names, expected) in [
            (["forward.U", "forward.V"], a_frame),
            (["backward.U", "backward.V"], -a_frame),
            (["motion.X", "motion.Y"], -a_frame),
            (["motion.Z", "motion.W"], -a_frame),
        ] {
            let off = vectors(&film, names).into_iter().map(|vector| (vector - expected).length());
            assert!(off.fold(0.0, f32::max) < 1e-3, "{names:?}");
        }
    }
}

#[test]
fn they_are_those_of_the_shots_frames_whichever_are_rendered() {
    let scene = over_the_floor();
    let apart = films(&scene, &settings(1), [1, 3, 5]);
    let together = films(&scene, &settings(1), 1..=5);
    for (apart, together) in apart.iter().zip(together.iter().step_by(2)) {
        let both = [apart, together].map(|film| vectors(film, ["motion.X", "motion.Z"]));
        let off = both[0].iter().zip(&both[1]).map(|(a, b)| (*a - *b).length());
        assert!(off.fold(0.0, f32::max) < 1e-3);
    }
    // the camera stands before frame 1 and after frame 5
    for (film, name) in [(&apart[0], "backward.A"), (&apart[2], "forward.A")] {
        assert!(film.values(name).unwrap().iter().all(|known| *known == 1.0), "{name}");
    }
    assert!(vectors(&apart[0], ["backward.U", "backward.V"]).iter().all(|vector| *vector == Vec2::ZERO));
    assert!(vectors(&apart[2], ["forward.U", "forward.V"]).iter().all(|vector| *vector == Vec2::ZERO));
}

#[test]
fn across_a_cut_nothing_moves() {
    let mut scene = over_the_floor();
    scene.camera.cuts = vec![3];
    let mut renderer = Renderer::new(&scene, &settings(1)).unwrap();
    for (frame, [moves_back, moves_on]) in [(2, [true, false]), (3, [false, true])] {
        let film = renderer.render(frame, false).unwrap().film;
        let moves = |names| vectors(&film, names).iter().any(|vector| *vector != Vec2::ZERO);
        assert_eq!(
            [moves(["backward.U", "backward.V"]), moves(["forward.U", "forward.V"])],
            [moves_back, moves_on]
        );
        let known = ["backward.A", "forward.A"].map(|name| {
            let all = film.values(name).unwrap();
            assert!(all.iter().all(|known| *known == all[0]), "{name}");
            all[0] == 1.0
        });
        assert_eq!(known, [moves_back, moves_on]);
    }
}

/// A camera that flies backwards over the floor: what it saw of it at the rim before was behind it.
#[test]
fn what_was_behind_the_eye_has_no_vector() {
    let mut scene = over_the_floor();
    let eye = |z| DVec3::new(0.0, 1.0, z);
    scene.camera = toy::camera(toy::keys(&[(1.0, eye(-6.0)), (2.0, eye(6.0))]), rests(eye(-1e3)));
    let film = &films(&scene, &settings(1), [2])[0];
    let [z, known] = ["Z", "backward.A"].map(|name| film.values(name).unwrap());
    let back = vectors(film, ["backward.U", "backward.V"]);
    let mut counts = [0; 2];
    for ((z, known), vector) in z.iter().zip(&known).zip(&back) {
        assert_eq!(*known == 1.0, *z > 12.0 || *z == 1e10, "{z} before the eye, which was 12 ahead");
        assert!(*known == 1.0 || *vector == Vec2::ZERO);
        counts[usize::from(*known == 1.0)] += 1;
    }
    assert!(counts.iter().all(|count| *count > 50), "{counts:?}");
}

/// A camera that rests, travels and rests again; a flyer that sets out while it rests.
fn busy() -> Scene {
    let mut scene = with_flyer(world());
    let (from, to) = (EYE, EYE + DVec3::new(1.6, 0.4, -1.2));
    let eye = toy::keys(&[(3.0, from), (5.0, to)]);
    scene.camera.eye = eye.into();
    scene
}

/// The audit makes what stands in the film anew: also vectors, of a frame in which nothing but them changes.
#[test]
fn vectors_of_what_stands_are_made_anew_where_they_change() {
    let mut scene = busy();
    let start = toy::keys(&[(4.0, DVec3::ZERO), (6.0, DVec3::new(0.5, 0.2, 0.0))]);
    let flyer = scene.models.len() - 1;
    scene.models[flyer].track = TransformTrack { translate: start, ..scene.models[flyer].track.clone() };
    for scene in [busy(), scene] {
        for samples in [1, 2] {
            // the film is dropped before the next frame, which is made over it
            let mut renderer = Renderer::new(&scene, &settings(samples)).unwrap();
            for frame in [1, 2, 3, 4, 5, 6, 7, 8, 8, 12] {
                let finished = renderer.render(frame, true).unwrap();
                assert_eq!(toy::differing(&finished), 0, "frame {frame}");
            }
        }
    }
}

/// Where a point that rests is seen in the next frame, that point is; where one that moves is seen, its vector leads back.
#[test]
fn a_frame_warped_by_them_is_the_next_one() {
    let scene = busy();
    let flyer = scene.models.len() as f32;
    let (mut warped, mut unwarped, mut aside, mut count) = (0.0, 0.0, 0.0, [0, 0]);
    for pair in films(&scene, &settings(1), 1..=6).windows(2) {
        let [width, height] = [pair[0].width as usize, pair[0].height as usize];
        let place = |film: &Film, pixel: usize| {
            Vec3::from(["P.X", "P.Y", "P.Z"].map(|name| film.plane(name).unwrap().values.get(pixel)))
        };
        let [before, after] = [0, 1].map(|number| pair[number].values("object.V").unwrap());
        let back = vectors(&pair[1], ["backward.U", "backward.V"]);
        for (pixel, forward) in vectors(&pair[0], ["forward.U", "forward.V"]).into_iter().enumerate() {
            let at = Vec2::new((pixel % width) as f32, (pixel / width) as f32) + 0.5;
            let to = (at + forward * Vec2::new(1.0, -1.0)).floor();
            let is_inside = to.cmpge(Vec2::ZERO).all() && to.x < width as f32 && to.y < height as f32;
            let there = to.y as usize * width + to.x as usize;
            if !is_inside || before[pixel] != after[there] || before[pixel] == 0.0 {
                continue;
            }
            if before[pixel] == flyer {
                aside += (forward + back[there]).length();
                count[1] += 1;
            } else if forward.length() > 1.0 {
                warped += (place(&pair[0], pixel) - place(&pair[1], there)).length();
                unwarped += (place(&pair[0], pixel) - place(&pair[1], pixel)).length();
                count[0] += 1;
            }
        }
    }
    assert!(count[0] > 5000 && count[1] > 200, "{count:?} pixels");
    assert!(warped < 0.4 * unwarped, "{warped} beside {unwarped}");
    let aside = aside / count[1] as f32;
    assert!(aside < 0.3, "{aside} pixels");
}
