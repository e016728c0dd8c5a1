//! Do tracers meet models where their transforms put them, whatever these are, and only while they are there?
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod toy;
mod tracers;

use afterimage::animation::{Track, TransformTrack, Visibility};
use afterimage::scene::Mesh;
use afterimage::trace::{Occluders, Purpose};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use toy::{floor, keys, moving, octahedron, still};
use tracers::*;

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
