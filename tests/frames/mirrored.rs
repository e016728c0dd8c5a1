//! Is what flat mirrors show kept while the eye moves, is it what the eye sees there, and is everything else traced?

use afterimage::animation::{Track, TransformTrack};
use afterimage::frame::{Finished, Renderer, Spoil};
use afterimage::layers::Layers;
use afterimage::scene::material::Optics;
use afterimage::scene::{Material, Mesh, Model, Scene};
use afterimage::settings::{Mode, Settings};
use afterimage::stereo::{Eye, Stereo};
use glam::{DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::*;

fn settings() -> Settings {
    Settings {
        paths: 4,
        bounces: 2,
        audit: true,
        layers: Layers::new(["reflection"]).expect("it is one"),
        ..toy::settings(1)
    }
}

fn mirror() -> Material {
    Material { optics: Optics::Mirror { tint: Vec3::splat(0.8), fresnel: false }, ..toy::matt(0.1) }
}

/// An upright wall from `from` to `to`, two corners on the ground, whose front is on the right of who goes that way.
fn wall(from: [f32; 2], to: [f32; 2], height: f32, material: u16) -> Mesh {
    let [[x, z], [u, w]] = [from, to];
    let corners = [[x, 0.0, z], [u, 0.0, w], [u, height, w], [x, height, z]];
    toy::mesh(&corners, &[[0, 1, 2], [0, 2, 3]], material, true)
}

/// A hall with a matt floor and two matt things before a mirror that fills the far end, and matt walls behind the eye, which moves a
/// little, and to both sides.
fn hall(more: Vec<Model>) -> Scene {
    let mut models = vec![
        toy::still("floor", toy::floor(8.0, 1), Vec3::ZERO),
        toy::still("mirror", wall([-6.0, -4.0], [6.0, -4.0], 5.0, 0), Vec3::ZERO),
        toy::still("behind", wall([6.0, 7.0], [-6.0, 7.0], 40.0, 1), Vec3::ZERO),
        toy::still("beside", wall([-6.0, 7.0], [-6.0, -4.0], 40.0, 1), Vec3::ZERO),
        toy::still("across", wall([6.0, -4.0], [6.0, 7.0], 40.0, 1), Vec3::ZERO),
        toy::still("thing", toy::octahedron(1, true), Vec3::new(-1.2, 1.0, -1.5)),
        toy::still("other", toy::octahedron(1, true), Vec3::new(1.6, 1.0, 0.5)),
    ];
    models.extend(more);
    let camera = toy::camera(
        goes(DVec3::new(0.3, 1.8, 5.0), DVec3::new(0.5, 1.9, 4.8)),
        rests(DVec3::new(0.0, 1.4, -4.0)),
    );
    toy::scene(camera, models, vec![mirror(), toy::matt(0.6)], vec![lamp(2.0, 4.5, 3.0)])
}

fn mirrored(finished: &Finished) -> u64 {
    finished.stats.audit.expect("asked for").mirrored
}

#[test]
fn what_a_flat_mirror_shows_is_kept() {
    let frames = toy::render(&hall(vec![]), &settings(), FRAMES);
    assert_eq!(frames.iter().map(toy::differing).sum::<u64>(), 0);
    let [first, last] = [&frames[0], &frames[FRAMES as usize - 1]];
    assert_eq!(mirrored(first), 0);
    let seen = last.stats.rays.reflection;
    assert!(seen > 2000, "{seen}");
    assert!(mirrored(last) * 10 > seen * 8, "{} of {seen}", mirrored(last));
    assert!(last.stats.rays.gathering * 8 < first.stats.rays.gathering, "{:?}", last.stats.rays);
}

/// Kept light is that of other places of the same surfaces, and no dimmer or brighter than what a frame in full shows.
#[test]
fn kept_light_is_as_bright_as_in_full() {
    let scene = hall(vec![]);
    let settings = Settings { samples: 2, audit: false, ..settings() };
    let kept = toy::render(&scene, &settings, FRAMES).pop().expect("there are some");
    let full = Settings { mode: Mode::Full, ..settings };
    let full = Renderer::new(&scene, &full).expect("builds").render(FRAMES, false).expect("renders");
    for plane in ["reflection.R", "reflection.G", "reflection.B"] {
        let sum = |finished: &Finished| finished.film.values(plane).expect("it is there").iter().sum::<f32>();
        let (kept, full) = (sum(&kept), sum(&full));
        assert!((kept / full - 1.0).abs() < 0.01, "{plane}: {kept} {full}");
    }
}

/// Two mirrors that face each other: what is seen in the fourth reflection is kept as that in the first one.
#[test]
fn mirrors_that_face_each_other_keep_what_they_show() {
    let facing = toy::still("facing", wall([6.0, 6.5], [-6.0, 6.5], 5.0, 0), Vec3::ZERO);
    let frames = toy::render(&hall(vec![facing]), &settings(), FRAMES);
    assert_eq!(frames.iter().map(toy::differing).sum::<u64>(), 0);
    let last = &frames[FRAMES as usize - 1];
    let one = toy::render(&hall(vec![]), &settings(), FRAMES).pop().expect("there are some");
    assert!(mirrored(last) > mirrored(&one) * 11 / 10, "{} and {}", mirrored(last), mirrored(&one));
}

/// Whatever mirrors do: what they show is what the eye sees, kept or not.
#[test]
fn mirrors_that_move_and_end_and_are_nothing_show_what_is_seen() {
    let goes_by = |mesh: Mesh| {
        let track = TransformTrack {
            translate: goes(DVec3::new(-1.0, 0.0, 2.0), DVec3::new(1.0, 0.2, 1.0)),
            rotate: goes(DVec3::ZERO, DVec3::new(0.0, 25.0, 0.0)),
            ..TransformTrack::identity()
        };
        toy::moving("goes by", mesh, track)
    };
    let flat = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let small = wall([-0.5, 0.0], [0.5, 0.0], 1.5, 0);
    let cases: [(&str, Vec<Model>, bool); 5] = [
        ("a mirror that moves", vec![goes_by(small.clone())], true),
        ("a thing that moves before a mirror", vec![goes_by(toy::octahedron(1, true))], true),
        (
            "a mirror without area",
            vec![toy::still("none", toy::mesh(&flat, &[[0, 1, 2]], 0, true), Vec3::Y)],
            true,
        ),
        // the target is straight ahead: its edge runs down the middle of the picture, between two columns of cells
        (
            "an edge along cells",
            vec![toy::still("half", wall([-3.0, 1.0], [0.0, 1.0], 4.0, 0), Vec3::ZERO)],
            false,
        ),
        (
            "an eye that passes through",
            vec![toy::still("pane", wall([-3.0, 4.9], [3.0, 4.9], 4.0, 0), Vec3::ZERO)],
            true,
        ),
    ];
    for (name, more, turns) in cases {
        let mut scene = hall(more);
        if !turns {
            let ahead = |z: f64| DVec3::new(0.0, 1.8, z);
            scene.camera = toy::camera(goes(ahead(5.0), ahead(4.8)), rests(ahead(-4.0)));
        }
        for finished in toy::render(&scene, &settings(), FRAMES) {
            assert_eq!(toy::differing(&finished), 0, "{name}");
            let values = finished.film.values("reflection.R").expect("it is there");
            assert!(values.iter().all(|value| value.is_finite()), "{name}");
        }
    }
}

/// A film that was left by a moving eye shows other places of what its mirrors show than one before an eye at rest.
#[test]
fn an_eye_that_comes_to_rest_sees_what_its_own_rays_meet() {
    let scene = hall(vec![]);
    let mut renderer = Renderer::new(&scene, &settings()).expect("the scene builds");
    for frame in 1..=FRAMES + 3 {
        let finished = renderer.render(frame, true).expect("renders");
        assert_eq!(toy::differing(&finished), 0, "{frame}");
        assert_eq!(mirrored(&finished) > 0, (2..=FRAMES).contains(&frame), "{frame}");
    }
}

/// Both eyes look into the same mirror, and the right one shows what the left one has found there.
#[test]
fn the_right_eye_is_lent_what_mirrors_show() {
    let scene = hall(vec![]);
    let stereo = Stereo { separation: 0.06, convergence: Some(8.0) };
    let mut renderer =
        Renderer::new(&scene, &Settings { stereo: Some(stereo), ..settings() }).expect("the scene builds");
    for frame in 1..=3 {
        let [left, right] = Eye::BOTH.map(|eye| renderer.render_eye(eye, frame, true).expect("renders"));
        assert_eq!(toy::differing(&left) + toy::differing(&right), 0, "{frame}");
        assert!(mirrored(&right) > 1000, "{frame}: {}", mirrored(&right));
    }
}

/// Who goes on from a copy of the samples goes on with what mirrors showed.
#[test]
fn a_snapshot_has_what_mirrors_show() {
    let scene = hall(vec![]);
    let settings = Settings { audit: false, ..settings() };
    let mut renderer = Renderer::new(&scene, &settings).expect("the scene builds");
    (1..=3).for_each(|frame| drop(renderer.render(frame, true).expect("renders")));
    let snapshot = renderer.snapshot().expect("there are samples");
    let mut other = Renderer::new(&scene, &settings).expect("the scene builds");
    other.restore(snapshot);
    let [a, b] = [&mut renderer, &mut other].map(|renderer| renderer.render(4, true).expect("renders"));
    assert_eq!(a.stats.rays, b.stats.rays);
    for plane in ["R", "reflection.G"] {
        assert_eq!(a.film.values(plane), b.film.values(plane));
    }
}

/// What is shown wrongly is found, whatever is wrong with it.
#[test]
fn an_audit_finds_what_mirrors_show_wrongly() {
    let flyer = TransformTrack {
        translate: goes(DVec3::new(-3.0, 2.0, 2.0), DVec3::new(3.0, 2.0, 2.0)),
        scale: Track::constant(DVec3::splat(0.6)),
        ..TransformTrack::identity()
    };
    for what in [Spoil::Mirrored, Spoil::MirroredUntil] {
        let found = |spoils: bool| {
            let scene = hall(vec![toy::moving("flyer", toy::octahedron(1, true), flyer.clone())]);
            let mut renderer = Renderer::new(&scene, &settings()).expect("the scene builds");
            let mut differing = 0;
            for frame in 1..=FRAMES {
                differing += toy::differing(&renderer.render(frame, true).expect("renders"));
                if spoils {
                    assert!(renderer.spoil(what).expect("no rays are cast") > 20, "{what:?}");
                }
            }
            differing
        };
        assert_eq!(found(false), 0);
        assert!(found(true) > 20, "{what:?}: {}", found(true));
    }
}
