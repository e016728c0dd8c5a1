//! Do tracers meet models where their transforms put them, whatever these are, and only while they are there?

use std::cell::RefCell;
use std::sync::Arc;

use afterimage::animation::{Track, TransformTrack, Visibility};
use afterimage::pose::Pose;
use afterimage::scene::{self, Mesh, Model, Scene};
use afterimage::settings::Build;
use afterimage::trace::{BackendKind, Hit, Occluders, Purpose, RayBatch};
use glam::{DAffine3, DMat3, DVec3, Vec3};

use crate::kinds::*;
use crate::toy;
use crate::toy::{floor, keys, moving, octahedron, still};

/// An octahedron that is sheared and turned inside out: its planes |x| + |y| + |z| = 1 are met in object space.
#[test]
fn instances_shear_and_mirror() {
    let linear =
        DMat3::from_cols(DVec3::new(-2.0, 0.0, 0.0), DVec3::new(1.0, 1.0, 0.0), DVec3::new(0.0, 0.5, 1.5));
    let map = DAffine3::from_mat3_translation(linear, DVec3::new(3.0, 1.0, -2.0));
    let track = |is_still: bool| TransformTrack {
        matrix: Some(if is_still {
            Track::constant(map)
        } else {
            keys(&[(1.0, map), (2.0, DAffine3::IDENTITY)])
        }),
        ..TransformTrack::identity()
    };
    assert!(linear.determinant() < 0.0, "a mirror image");
    let meshes = [
        octahedron(0, true),
        toy::moving_quadric("ball", &toy::sphere(), 0, track(false)).mesh.as_ref().clone(),
    ];
    for (mesh, is_round) in meshes.into_iter().zip([false, true]) {
        let scene = scene_of(vec![moving("sheared", mesh, track(false))]);
        on_each(&scene, |tracer, way| {
            let mut met = 0;
            for (x, z) in [(3.1, -2.2), (2.0, -2.5), (4.5, -1.2), (3.0, -3.3), (1.5, -2.1)] {
                let (origin, direction) = (Vec3::new(x, 9.0, z), Vec3::NEG_Y);
                let inverse = map.inverse();
                let from = inverse.transform_point3(origin.as_dvec3());
                let along = inverse.transform_vector3(direction.as_dvec3());
                let outside = |t: f64| {
                    let at = from + along * t;
                    if is_round { at.length() - 1.0 } else { at.abs().element_sum() - 1.0 }
                };
                let steps = (0..200_000).map(|step| f64::from(step) * 1e-4);
                let expected = steps.into_iter().find(|t| outside(*t) <= 0.0).map(|t| t as f32);
                let hit = first(tracer, way, origin, direction).map(|hit| hit.t);
                let agree = hit.zip(expected).map(|(a, b)| (a - b).abs() < 2e-4);
                assert!(agree.unwrap_or(hit.is_none() && expected.is_none()), "{hit:?}, not {expected:?}");
                met += usize::from(hit.is_some());
            }
            assert!(met >= 3, "{met}");
            assert_eq!(first(tracer, way, Vec3::new(6.0, 9.0, -2.0), Vec3::NEG_Y), None);
        });
    }
}

/// Copies that were forgotten in one place, among many others: each ray meets the first of them, however often the trees are built, and by however
/// many threads.
#[test]
fn of_copies_in_one_place_the_first_is_met() {
    let at = |number: usize| DVec3::new((number % 20) as f64 * 3.0, 0.0, 0.0);
    let track = |number: usize| TransformTrack {
        translate: keys(&[(1.0, at(number)), (2.0, DVec3::Y)]),
        ..TransformTrack::identity()
    };
    // each with its own mesh, or all with one
    let meshes: Vec<Arc<Mesh>> = (0..60).map(|_| Arc::new(octahedron(0, true))).collect();
    let rays = {
        let mut rays = RayBatch::default();
        (0..20).for_each(|i| rays.push(Vec3::new(i as f32 * 3.0 + 0.1, 5.0, 0.1), Vec3::NEG_Y, 0.0, 9.0));
        rays
    };
    let scenes = [(true, false), (true, true), (false, false)].map(|(moves, is_shared)| {
        let model = |number: usize| {
            let mesh = meshes[if is_shared { 0 } else { number }].clone();
            let place = at(number);
            match moves {
                true => Model { mesh, ..moving("copy", octahedron(0, true), track(number)) },
                false => still("copy", Mesh::clone(&mesh), place.as_vec3()),
            }
        };
        scene_of((0..60).map(model).collect())
    });
    for (scene, build) in scenes.iter().flat_map(|scene| [(scene, Build::Quick), (scene, Build::Best)]) {
        let pose = Pose::new(scene, 1);
        // one tree of all triangles is built alike each time, and meets whichever of them it likes
        let is_any = scene.models[0].track.is_constant() && build == Build::Best;
        let mut expected = (!is_any).then(|| (0..20).collect::<Vec<u32>>());
        for _ in 0..20 {
            let mut backend = BackendKind::Embree.build(scene, build).unwrap();
            let tracer = backend.commit(&pose, &[true; 60]).unwrap();
            for way in if is_any { &WAYS[..1] } else { &WAYS[..] } {
                let hits = closest(&*tracer, *way, &rays);
                let models: Vec<u32> = hits.iter().map(|hit| hit.unwrap().model).collect();
                assert_eq!(*expected.get_or_insert_with(|| models.clone()), models, "{build:?}, {way:?}");
            }
        }
    }
}

/// Of pairs that share a mesh one has disappeared: no ray of any kind meets it.
#[test]
fn what_is_not_there_is_met_by_no_ray() {
    let track = |x: f64, is_there: bool| TransformTrack {
        translate: Track::constant(DVec3::X * x),
        visible: Visibility::through(true, vec![(if is_there { 2.0 } else { 1.0 }, false)]).unwrap(),
        ..TransformTrack::identity()
    };
    let (solid, clear) = (octahedron(0, true), octahedron(0, false));
    let ball = toy::moving_quadric("ball", &toy::sphere(), 0, track(0.0, true)).mesh.as_ref().clone();
    let pairs = |meshes: &[Mesh]| {
        let mut models = vec![still("floor", floor(99.0, 0), Vec3::Y * -2.0)];
        for (mesh, x) in meshes.iter().zip((0..).map(|pair| f64::from(pair) * 8.0)) {
            models.push(moving("away", mesh.clone(), track(x, false)));
            models.push(moving("there", mesh.clone(), track(x + 4.0, true)));
        }
        models
    };
    // with trees of their own for what casts shadows, and without
    for (meshes, casts) in
        [(vec![solid.clone(), ball, clear], [true, true, false]), (vec![solid; 3], [true; 3])]
    {
        let scene = scene_of(pairs(&meshes));
        for moved in [true, false] {
            on_each_moved(&scene, &[moved; 7], |tracer, way| {
                for (model, x) in (1..7).zip((0..).map(|i| i as f32 * 4.0)) {
                    let is_there = model % 2 == 0;
                    let rays = down(x + 0.1, 0.1, 3.5);
                    let met = first(tracer, way, Vec3::new(x + 0.1, 2.0, 0.1), Vec3::NEG_Y).unwrap().model;
                    assert_eq!(met, if is_there { model } else { 0 });
                    for by in [Occluders::Movable, Occluders::Moved] {
                        let is_asked = is_there && (moved || by == Occluders::Movable);
                        let casts = is_asked && casts[(model as usize - 1) / 2];
                        assert_eq!(
                            blocks(tracer, way, by, Purpose::Sight, &rays),
                            [is_asked],
                            "{model} {by:?}"
                        );
                        assert_eq!(
                            blocks(tracer, way, by, Purpose::Shadow, &rays),
                            [casts],
                            "{model} {by:?}"
                        );
                    }
                }
            });
        }
    }
}

#[test]
fn where_all_that_moves_is_away_the_rest_is_met() {
    let track = TransformTrack {
        visible: Visibility::through(false, vec![(5.0, true)]).unwrap(),
        ..TransformTrack::identity()
    };
    let scene = scene_of(vec![
        still("floor", floor(9.0, 0), Vec3::Y * -2.0),
        moving("mesh", octahedron(0, true), track.clone()),
        toy::moving_quadric("ball", &toy::sphere(), 0, track),
    ]);
    on_each(&scene, |tracer, way| {
        let hit = first(tracer, way, Vec3::new(0.1, 2.0, 0.1), Vec3::NEG_Y).unwrap();
        // Embree divides by a reciprocal that processors approximate, each in its own way
        assert!(hit.model == 0 && (hit.t - 4.0).abs() < 1e-6, "{hit:?}");
        assert_eq!(blocks(tracer, way, Occluders::Movable, Purpose::Shadow, &down(0.1, 0.1, 9.0)), [false]);
    });
}

/// A tetrahedron, of which half is of clear glass or nothing is, at several places, in one of which it moves; and a pane.
fn copies(is_half_clear: bool, most_added: u64) -> Scene {
    const MODELS: &str = "
        [[camera.key]]\nframe = 1\neye = [0, 0, 9]\ntarget = [0, 0, 0]
        [[model]]\nobj = 'm.obj'\ntranslate = [-3, 0, 0]
        [[model]]\nobj = 'm.obj'
        [[model]]\nobj = 'm.obj'\ntranslate = [3, 0, 0]\nrotate = [20, 130, 40]\nscale = [1.2, 0.4, 0.7]
        [[model.key]]\nframe = 1\n[[model.key]]\nframe = 2\ntranslate = [0, 9, 0]
        [[model]]\nobj = 'p.obj'\ntranslate = [0, -3, 0]
        [[model]]\nobj = 'm.obj'\ntranslate = [0, 2.5, 0]\nrotate = [70, 20, 110]\nscale = [1.2, 0.4, 0.7]
        [[model]]\nobj = 'm.obj'\ntranslate = [3, 2.5, 0]\nscale = [-1, 0.6, 0.9]\nrotate = [10, 20, 30]
        [[model]]\nobj = 'm.obj'\ntranslate = [-3, 2.5, 0]
        matrix = [[1, 0.4, 0, 0], [0, 1, -0.3, 0], [0.2, 0, 0.8, 0.1]]";
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let other = if is_half_clear { "clear" } else { "solid" };
    write("m.mtl", "newmtl solid\nKd 0.5 0.5 0.5\nnewmtl clear\nd 0.1\n");
    let corners = "v 0 1 0\nv -0.9 -0.5 0.6\nv 0.8 -0.5 0.7\nv 0.1 -0.6 -1\n";
    let faces = format!("usemtl solid\nf 1 2 3\nf 1 3 4\nusemtl {other}\nf 1 4 2\nf 2 4 3\n");
    write("m.obj", &format!("mtllib m.mtl\n{corners}{faces}"));
    write("p.obj", "mtllib m.mtl\nusemtl solid\nv -5 0 5\nv 5 0 5\nv 5 0 -5\nf 1 2 3\n");
    write("s.toml", MODELS);
    scene::load_sharing(&folder.path().join("s.toml"), false, most_added).unwrap().scene
}

/// What all tracers answer, in all ways: first hits, and what is blocked by what, for which purpose.
fn answers(scene: &Scene, rays: &RayBatch) -> Vec<(Vec<Option<Hit>>, Vec<bool>)> {
    let all = RefCell::new(Vec::new());
    on_each(scene, |tracer, way| {
        let by = [Occluders::Still, Occluders::Movable, Occluders::Moved];
        let questions = by.into_iter().flat_map(|by| [(by, Purpose::Sight), (by, Purpose::Shadow)]);
        let blocked = questions.flat_map(|(by, purpose)| blocks(tracer, way, by, purpose, rays));
        all.borrow_mut().push((closest(tracer, way, rays), blocked.collect()));
    });
    all.into_inner()
}

/// Of all seven models five share one mesh: four stand still elsewhere, and one moves.
#[test]
fn copies_that_share_a_mesh_are_met_where_those_in_world_space_are() {
    let place = |i: f32| (Vec3::new(0.618_034, 0.414_214, 0.732_051) * i).fract() * 2.0 - 1.0;
    let middles = [[-3., 0.], [0., 0.], [3., 0.], [0., -3.], [0., 2.5], [3., 2.5], [-3., 2.5]];
    let mut rays = RayBatch::default();
    for bundle in 0..140 {
        let [x, y] = middles[bundle % middles.len()];
        let (from, to) =
            (place(bundle as f32 + 0.3) * 6.0, Vec3::new(x, y, 0.0) + place(bundle as f32) * 0.3);
        (0..16).for_each(|ray| {
            let beside = Vec3::new(ray as f32, (ray % 4) as f32, (ray % 3) as f32) * 0.02;
            rays.push(from, to + beside - from, 0.0, 3.0);
        });
    }
    for is_half_clear in [false, true] {
        let [shared, baked] = [0, u64::MAX].map(|most_added| copies(is_half_clear, most_added));
        assert_eq!([shared.built().count(), baked.built().count()], [3, 7]);
        let mut met = [0; 7];
        for ((hits, blocked), (others, blocked_too)) in
            answers(&shared, &rays).iter().zip(&answers(&baked, &rays))
        {
            let is_same = |(hit, other): &(&Option<Hit>, &Option<Hit>)| match (hit, other) {
                (Some(hit), Some(other)) => {
                    let names = |hit: &Hit| (hit.model, hit.triangle);
                    names(hit) == names(other) && (hit.t - other.t).abs() < 1e-5
                }
                (hit, other) => hit.is_none() && other.is_none(),
            };
            // at edges a rounding decides
            let apart = hits.iter().zip(others).filter(|pair| !is_same(pair)).count();
            assert!(apart <= 4, "{apart} of {}", rays.len());
            let apart = blocked.iter().zip(blocked_too).filter(|(a, b)| a != b).count();
            assert!(apart <= 8, "{apart} of {} answers", blocked.len());
            hits.iter().flatten().for_each(|hit| met[hit.model as usize] += 1);
        }
        assert!(met.iter().all(|count| *count > 100), "{met:?}");
    }
}
