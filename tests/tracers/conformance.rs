//! One suite for every tracer: tiny scenes with known answers, and random rays on which tracers must agree.

use std::f32::consts::TAU;

use afterimage::animation::{Track, TransformTrack};
use afterimage::geometry::Quadric;
use afterimage::geometry::quadric::QuadricShape;
use afterimage::pose::Pose;
use afterimage::scene::{self, Geometry, Mesh, Model, Scene};
use afterimage::settings::Build;
use afterimage::trace::{
    BackendKind, Coherence, HitBatch, Occluders, Purpose, RayBatch, SceneSubset, Search,
};
use glam::{DAffine3, DVec3, Vec2, Vec3};

use crate::collection;
use crate::kinds::*;
use crate::toy;
use crate::toy::{floor, keys, mesh, moving, octahedron, still};

/// One triangle (0,0,0) (4,0,0) (0,4,0), seen along -z.
fn triangle() -> Scene {
    let corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    scene_of(vec![still("triangle", mesh(&corners, &[[0, 1, 2]], 0, true), Vec3::ZERO)])
}

#[test]
fn a_hit_has_distance_weights_model_and_triangle() {
    on_each(&triangle(), |tracer, way| {
        // directions of any length: t counts in them
        let hit = first(tracer, way, Vec3::new(1.0, 2.0, 6.0), Vec3::new(0.0, 0.0, -2.0)).unwrap();
        assert_eq!((hit.model, hit.triangle), (0, 0));
        for (is, should) in [(hit.t, 3.0), (hit.u, 0.25), (hit.v, 0.5)] {
            assert!((is - should).abs() < 1e-6, "{hit:?}");
        }
        // from behind as well
        assert!(first(tracer, way, Vec3::new(1.0, 2.0, -6.0), Vec3::Z).is_some());
    });
}

#[test]
fn what_is_beside_behind_or_edge_on_is_not_met() {
    on_each(&triangle(), |tracer, way| {
        for (origin, direction) in [
            (Vec3::new(3.0, 3.0, 1.0), Vec3::NEG_Z),
            (Vec3::new(-0.001, 1.0, 1.0), Vec3::NEG_Z),
            (Vec3::new(1.0, 1.0, 1.0), Vec3::Z),
            (Vec3::new(-1.0, 1.0, 0.0), Vec3::X),
            (Vec3::new(1.0, 1.0, 1.0), Vec3::X),
        ] {
            assert_eq!(first(tracer, way, origin, direction), None, "{origin} {direction}");
        }
    });
}

#[test]
fn rays_end_where_they_are_said_to() {
    on_each(&triangle(), |tracer, way| {
        for (near, far, met) in
            [(0.0, 0.999, false), (0.0, 1.001, true), (0.999, 9.0, true), (1.001, 9.0, false)]
        {
            let mut rays = RayBatch::default();
            rays.push(Vec3::new(1.0, 1.0, 1.0), Vec3::NEG_Z, near, far);
            assert_eq!(closest(tracer, way, &rays)[0].is_some(), met, "{near} {far}");
            let by = blocks(tracer, way, Occluders::Still, Purpose::Shadow, &rays);
            assert_eq!(by, [met], "{near} {far}");
        }
    });
}

#[test]
fn no_ray_passes_between_triangles() {
    // a fan around the origin, and rays through its centre, its spokes and points around
    let rim = |i: usize| {
        let angle = TAU * i as f32 / 24.0 + 0.1;
        [3.0 * angle.cos(), 3.0 * angle.sin(), 0.3 * (5.0 * angle).sin()]
    };
    let corners: Vec<[f32; 3]> = std::iter::once([0.0, 0.0, 0.1]).chain((0..24).map(rim)).collect();
    let faces: Vec<[u32; 3]> = (0..24).map(|i| [0, i + 1, (i + 1) % 24 + 1]).collect();
    let scene = scene_of(vec![still("fan", mesh(&corners, &faces, 0, true), Vec3::ZERO)]);
    on_each(&scene, |tracer, way| {
        for eye in [Vec3::new(0.3, 0.7, 9.0), Vec3::new(4.0, -1.0, 2.0), Vec3::new(0.1, 1e3, 1e4)] {
            let mut rays = RayBatch::default();
            let mut through = |at: Vec3| rays.push(eye, at - eye, 0.0, f32::INFINITY);
            through(Vec3::from(corners[0]));
            for spoke in &corners[1..] {
                (1..40)
                    .for_each(|i| through(Vec3::from(corners[0]).lerp(Vec3::from(*spoke), i as f32 / 41.0)));
            }
            let lost = closest(tracer, way, &rays).iter().filter(|hit| hit.is_none()).count();
            assert_eq!(lost, 0, "from {eye}");
        }
    });
}

#[test]
fn of_surfaces_in_the_same_place_one_is_always_the_answer() {
    let scene = scene_of(vec![still("a", floor(2.0, 0), Vec3::ZERO), still("b", floor(2.0, 0), Vec3::ZERO)]);
    let pose = Pose::new(&scene, 1);
    let mut rust = BackendKind::Rust.build(&scene, Build::Best).unwrap();
    let tracer = rust.commit(&pose, &[true, true]).unwrap();
    for way in WAYS {
        for (x, z) in [(0.5, 0.25), (0.0, 0.0), (-1.25, 1.25)] {
            let hit = first(&*tracer, way, Vec3::new(x, 2.0, z), Vec3::NEG_Y).unwrap();
            assert_eq!(hit.model, 0, "the first of two");
        }
    }
}

#[test]
fn a_segment_is_not_blocked_by_its_own_end() {
    let corners = [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]];
    let square = || mesh(&corners, &[[0, 1, 2], [0, 2, 3]], 0, true);
    let track = TransformTrack {
        translate: keys(&[(0.0, DVec3::ZERO), (2.0, DVec3::X * 0.5)]),
        ..TransformTrack::identity()
    };
    for (models, by) in [
        (vec![still("still", square(), Vec3::ZERO)], Occluders::Still),
        (vec![moving("moving", square(), track)], Occluders::Movable),
    ] {
        on_each(&scene_of(models), |tracer, way| {
            let at = Vec3::new(0.6, 0.0, 0.2);
            let mut rays = RayBatch::default();
            let eye = Vec3::new(0.6, 2.0, 0.2);
            for (model, triangle) in [(0, 0), (0, 1), (0, 7), (u32::MAX, u32::MAX)] {
                rays.push_to_sample(eye, at - eye, 0.0, 1.5, model, triangle);
            }
            let own = closest(tracer, way, &rays)[0].unwrap().triangle;
            let blocked = blocks(tracer, way, by, Purpose::Sight, &rays);
            assert_eq!(blocked, [own != 0, own != 1, true, true]);
            // a packet whose rays all end on the same model, or on none
            for (model, triangle) in [(0, 0), (0, 1), (u32::MAX, u32::MAX)] {
                let mut rays = RayBatch::default();
                (0..16).for_each(|_| rays.push_to_sample(eye, at - eye, 0.0, 1.5, model, triangle));
                let blocked = blocks(tracer, way, by, Purpose::Sight, &rays);
                assert_eq!(blocked, [own != triangle; 16], "{model} {triangle}");
            }
        });
    }
}

#[test]
fn shadow_rays_pass_clear_triangles() {
    // the second triangle casts no shadow
    let corners = [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]];
    let mut half_clear = mesh(&corners, &[[0, 1, 2], [0, 2, 3]], 0, true);
    half_clear.shadow_casting = 1;
    let scene = scene_of(vec![still("glass", half_clear, Vec3::ZERO)]);
    on_each(&scene, |tracer, way| {
        for (x, z, casts) in [(0.5, 0.2, true), (-0.5, -0.2, false)] {
            let rays = down(x, z, 9.0);
            assert_eq!(blocks(tracer, way, Occluders::Still, Purpose::Shadow, &rays), [casts]);
            assert_eq!(blocks(tracer, way, Occluders::Still, Purpose::Sight, &rays), [true]);
            assert!(closest(tracer, way, &rays)[0].is_some());
        }
    });
}

/// A square whose right half is cut out, as the tracers get it: with a part that is whole, and with clear ones.
#[test]
fn rays_pass_what_is_cut_out() {
    let uvs = |mesh: Mesh| {
        let corners = mesh.triangles().positions.as_slice().iter();
        let uvs = corners.map(|[x, _, z]| Vec2::new((x + 1.0) / 2.0, *z)).collect();
        mesh.with_triangles(|triangles| triangles.uvs = uvs)
    };
    let square = |y: f32| [[-1.0, y, 1.0], [1.0, y, 1.0], [1.0, y, -1.0], [-1.0, y, -1.0]];
    // at the bottom a whole square, above it one that casts shadows, above that a clear one
    let corners = [square(0.0), square(0.5), square(1.0)].concat();
    let faces = |first: u32| [[first, first + 1, first + 2], [first, first + 2, first + 3]];
    let triangles = [faces(0), faces(4), faces(8)].concat();
    let whole = uvs(mesh(&corners, &triangles, 0, true));
    let cut = toy::cut_out(Mesh { shadow_casting: 4, ..whole }, 2..6, &toy::opacity(255, 0));
    let track = TransformTrack {
        translate: keys(&[(1.0, DVec3::X * 4.0), (2.0, DVec3::Y)]),
        ..TransformTrack::identity()
    };
    let scene = scene_of(vec![still("still", cut.clone(), Vec3::ZERO), moving("moving", cut, track)]);
    on_each(&scene, |tracer, way| {
        for (at, by) in [(0.0, Occluders::Still), (4.0, Occluders::Movable)] {
            // to all there is, and to what is above the bottom
            for (x, z, first, casts) in
                [(-0.5, 0.2, 1.0, true), (0.5, 0.2, 2.0, false), (0.5, -0.9, 2.0, false)]
            {
                let all = down(at + x, z, 9.0);
                let hit = closest(tracer, way, &all)[0].unwrap();
                assert!((hit.t - first).abs() < 1e-5_f32, "{hit:?}");
                assert_eq!(blocks(tracer, way, by, Purpose::Sight, &all), [true]);
                assert_eq!(blocks(tracer, way, by, Purpose::Shadow, &all), [true]);
                let above = down(at + x, z, 1.75);
                assert_eq!(closest(tracer, way, &above)[0].is_some(), casts);
                assert_eq!(blocks(tracer, way, by, Purpose::Sight, &above), [casts]);
                assert_eq!(blocks(tracer, way, by, Purpose::Shadow, &above), [casts]);
                // the clear one alone
                let clear = down(at + x, z, 1.25);
                assert_eq!(blocks(tracer, way, by, Purpose::Sight, &clear), [casts]);
                assert_eq!(blocks(tracer, way, by, Purpose::Shadow, &clear), [false]);
            }
        }
    });
}

/// A clear roof above a floor that casts shadows, in halves of what is still and of what moves, with so many
/// casters more that never meet a ray.
fn roofed(casters: u32) -> Scene {
    let corners: Vec<[f32; 3]> = [0.0_f32, 1.0]
        .iter()
        .flat_map(|y| [[-1.0, *y, 1.0], [1.0, *y, 1.0], [1.0, *y, -1.0], [-1.0, *y, -1.0]])
        .chain([[9.0, -9.0, 9.0], [9.0, -9.0, 9.1], [9.1, -9.0, 9.0]])
        .collect();
    let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
    triangles.extend((0..casters).map(|_| [8, 9, 10]));
    triangles.extend([[4, 5, 6], [4, 6, 7]]);
    let mut roofed = mesh(&corners, &triangles, 0, true);
    roofed.shadow_casting -= 2;
    let track = |x: f64| TransformTrack {
        translate: keys(&[(1.0, DVec3::X * x), (2.0, DVec3::Y)]),
        ..TransformTrack::identity()
    };
    scene_of(vec![
        still("still", roofed.clone(), Vec3::ZERO),
        moving("rests", roofed.clone(), track(4.0)),
        moving("moved", roofed, track(8.0)),
        moving("glass", octahedron(0, false), track(12.0)),
    ])
}

#[test]
fn few_clear_triangles_and_many_are_passed_alike() {
    for casters in [0, 100] {
        let scene = roofed(casters);
        on_each_moved(&scene, &[false, false, true, true], |tracer, way| {
            for (model, x) in [(0, 0.1), (1, 4.1), (2, 8.1)] {
                let (to_roof, to_floor) = (down(x, 0.3, 1.5), down(x, 0.3, 9.0));
                let by = if model == 0 { Occluders::Still } else { Occluders::Movable };
                for (rays, purpose, blocked) in [
                    (&to_roof, Purpose::Shadow, false),
                    (&to_roof, Purpose::Sight, true),
                    (&to_floor, Purpose::Shadow, true),
                ] {
                    assert_eq!(blocks(tracer, way, by, purpose, rays), [blocked], "{model} {purpose:?}");
                    let moved = blocks(tracer, way, Occluders::Moved, purpose, rays);
                    assert_eq!(moved, [blocked && model == 2], "{model} {purpose:?}");
                }
                let hit = closest(tracer, way, &to_floor)[0].unwrap();
                // not all instruction sets round alike
                let is_near = (hit.t - 1.0).abs() < 1e-6;
                assert!(hit.model == model && is_near, "the roof is met first: {hit:?}");
                assert!(hit.triangle >= casters + 2, "{hit:?}");
                // its own triangle does not block a segment
                let (from, to) = (Vec3::new(x, 2.0, 0.3), Vec3::new(x, 1.0, 0.3));
                let mut rays = RayBatch::default();
                rays.push_to_sample(from, to - from, 0.0, 1.5, model, hit.triangle);
                assert_eq!(blocks(tracer, way, by, Purpose::Sight, &rays), [false]);
            }
            // all of it is clear
            for by in [Occluders::Still, Occluders::Movable, Occluders::Moved] {
                assert_eq!(blocks(tracer, way, by, Purpose::Shadow, &down(12.1, 0.1, 9.0)), [false]);
            }
            assert_eq!(closest(tracer, way, &down(12.1, 0.1, 9.0))[0].unwrap().model, 3);
        });
    }
}

#[test]
fn halves_answer_for_themselves_and_moved_ones_apart() {
    let track = |x: f64| TransformTrack {
        translate: keys(&[(0.0, DVec3::new(x, 0.0, 0.0)), (9.0, DVec3::new(x, 0.0, 1e-6))]),
        ..TransformTrack::identity()
    };
    let scene = scene_of(vec![
        still("still", floor(1.0, 0), Vec3::X * -10.0),
        moving("rests", floor(1.0, 0), track(0.0)),
        moving("moved", floor(1.0, 0), track(10.0)),
    ]);
    on_each_moved(&scene, &[false, false, true], |tracer, way| {
        for (x, answers) in
            [(-10.0, [true, false, false]), (0.0, [false, true, false]), (10.0, [false, true, true])]
        {
            let rays = down(x, 0.0, 9.0);
            for (by, blocked) in
                [Occluders::Still, Occluders::Movable, Occluders::Moved].into_iter().zip(answers)
            {
                assert_eq!(blocks(tracer, way, by, Purpose::Shadow, &rays), [blocked], "{x} {by:?}");
            }
            for (among, is_met) in [(SceneSubset::All, true), (SceneSubset::Still, answers[0])] {
                let mut hits = HitBatch::default();
                tracer.closest(&rays, Search::from_eye(among, way), &mut hits);
                assert_eq!(hits.get(0).is_some(), is_met, "{x} {among:?}");
            }
        }
    });
}

#[test]
fn instances_turn_and_scale() {
    let track = TransformTrack {
        translate: keys(&[(1.0, DVec3::new(5.0, 1.0, 0.0)), (9.0, DVec3::ZERO)]),
        rotate: Track::constant(DVec3::new(0.0, 90.0, 0.0)),
        scale: Track::constant(DVec3::new(4.0, 2.0, 0.5)),
        ..TransformTrack::identity()
    };
    let scene = scene_of(vec![moving("stretched", octahedron(0, true), track)]);
    on_each(&scene, |tracer, way| {
        // its x axis, four long, points along -z now; its z axis, half as long, along x
        for (origin, direction, t) in [
            (Vec3::new(5.0, 1.0, 10.0), Vec3::NEG_Z, 6.0),
            (Vec3::new(5.0, 9.0, 0.0), Vec3::NEG_Y * 2.0, 3.0),
            (Vec3::new(0.0, 1.0, 0.0), Vec3::X, 4.5),
        ] {
            let hit = first(tracer, way, origin, direction).unwrap();
            assert!((hit.t - t).abs() < 1e-5 && hit.model == 0, "{hit:?}, not {t}");
        }
        assert_eq!(first(tracer, way, Vec3::new(5.6, 1.0, 10.0), Vec3::NEG_Z), None);
    });
}

#[test]
fn models_that_share_a_mesh_keep_their_numbers() {
    let shared = std::sync::Arc::new(octahedron(0, true));
    let at = |x: f64| Model {
        name: "twin".into(),
        path: "twin".into(),
        mesh: std::sync::Arc::clone(&shared),
        track: TransformTrack {
            translate: keys(&[(1.0, DVec3::X * x), (2.0, DVec3::Y)]),
            ..TransformTrack::identity()
        },
        to_world: None,
        random: 0.0,
        reflection_map: None,
        ray_visibility: Default::default(),
        linked: Default::default(),
    };
    on_each(&scene_of((0..20).map(|i| at(f64::from(i) * 3.0)).collect()), |tracer, way| {
        let mut rays = RayBatch::default();
        (0..20).for_each(|i| rays.push(Vec3::new(i as f32 * 3.0 + 0.1, 5.0, 0.1), Vec3::NEG_Y, 0.0, 9.0));
        let models: Vec<u32> = closest(tracer, way, &rays).iter().map(|hit| hit.unwrap().model).collect();
        assert_eq!(models, (0..20).collect::<Vec<_>>());
    });
}

#[test]
fn batches_of_any_size_are_answered_and_kept_bits_stay() {
    on_each(&scene_of(vec![still("floor", floor(1.0, 0), Vec3::ZERO)]), |tracer, way| {
        for count in [0_usize, 1, 15, 16, 17, 33] {
            let mut rays = RayBatch::default();
            // every third one misses
            for i in 0..count {
                let x = if i % 3 == 0 { 5.0 } else { 0.3 };
                rays.push(Vec3::new(x, 2.0, 0.1), Vec3::new(0.0, -1.0, 0.001 * i as f32), 0.0, 9.0);
            }
            let met: Vec<bool> = closest(tracer, way, &rays).iter().map(Option::is_some).collect();
            assert_eq!(met, (0..count).map(|i| i % 3 != 0).collect::<Vec<_>>());
            assert_eq!(blocks(tracer, way, Occluders::Still, Purpose::Shadow, &rays), met);
            let mut blocked = vec![0b1; rays.packet_count()];
            tracer.blocked(&rays, Occluders::Still, Purpose::Shadow, way, &mut blocked);
            assert!(blocked.iter().all(|bits| bits & 1 == 1), "what is set stays set");
        }
    });
}

#[test]
fn a_scene_of_nothing_is_met_by_nothing() {
    on_each(&scene_of(vec![]), |tracer, way| {
        assert_eq!(first(tracer, way, Vec3::ZERO, Vec3::X), None);
        for by in [Occluders::Still, Occluders::Movable, Occluders::Moved] {
            assert_eq!(blocks(tracer, way, by, Purpose::Shadow, &down(0.0, 0.0, 9.0)), [false]);
        }
    });
}

/// Numbers between -1 and 1, always the same ones.
fn random(seed: u32) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state as f32 / u32::MAX as f32 * 2.0 - 1.0
    }
}

/// Rays in bundles of 16 that start in one point and spread by `spread`, within the scene's box.
fn random_rays(scene: &Scene, spread: f32) -> RayBatch {
    let pose = Pose::new(scene, 1);
    let points = scene.models.iter().zip(&pose.models).flat_map(|(model, at)| {
        let points: Vec<Vec3> = match &model.mesh.geometry {
            Geometry::Triangles(all) => {
                all.positions.as_slice().iter().map(|point| (*point).into()).collect()
            }
            Geometry::Curved(all) => (0..all.count()).flat_map(|one| all.bounds(one).corners()).collect(),
        };
        points.into_iter().map(|point| at.point(point))
    });
    let (low, high) = points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let mut next = random(7);
    let mut rays = RayBatch::default();
    for _ in 0..1500 {
        let mut vector = || Vec3::new(next(), next(), next());
        let (origin, way) = ((low + high) * 0.5 + (high - low) * 0.6 * vector(), vector());
        for _ in 0..16 {
            rays.push(origin, way + spread * vector(), 0.0, f32::INFINITY);
        }
    }
    rays
}

/// Compares all tracers with the first: the same answer, or one that is as far, but for one ray in two thousand.
fn assert_agreement(scene: &Scene) {
    kinds().skip(1).for_each(|kind| assert_two_agree(scene, [KINDS[0], kind]));
}

fn assert_two_agree(scene: &Scene, kinds: [Kind; 2]) {
    let pose = Pose::new(scene, 1);
    let moved = vec![true; scene.models.len()];
    let [mut first, mut second] = kinds.map(|kind| kind.build(scene));
    let (first, second) = (first.commit(&pose, &moved).unwrap(), second.commit(&pose, &moved).unwrap());
    for (way, spread) in
        [(Coherence::Coherent, 0.01), (Coherence::Coherent, 0.5), (Coherence::Incoherent, 1.0)]
    {
        let rays = random_rays(scene, spread);
        let (theirs, ours) = (closest(&*first, way, &rays), closest(&*second, way, &rays));
        let (mut apart, mut neighbours, mut met) = (0, 0, 0);
        for pair in theirs.iter().zip(&ours) {
            match pair {
                (None, None) => {}
                (Some(a), Some(b)) if (a.t - b.t).abs() <= 1e-4 * a.t.abs() + 1e-6 => {
                    met += 1;
                    neighbours += usize::from((a.model, a.triangle) != (b.model, b.triangle));
                }
                _ => apart += 1,
            }
        }
        println!("{:?}: {met} meet, {neighbours} of them another triangle there, {apart} apart", kinds[1]);
        assert!(met > 1000 && apart * 2000 <= rays.len(), "{apart} of {} apart", rays.len());
        for purpose in [Purpose::Sight, Purpose::Shadow] {
            for by in [Occluders::Still, Occluders::Movable] {
                let both = [&first, &second].map(|tracer| blocks(&**tracer, way, by, purpose, &rays));
                let apart = both[0].iter().zip(&both[1]).filter(|(a, b)| a != b).count();
                assert!(apart * 2000 <= rays.len(), "{by:?} {purpose:?}: {apart} apart");
            }
        }
        if !matches!(kinds[1], Kind::Rust) {
            continue;
        }
        // its beams and single rays give the same floats
        let other = if way == Coherence::Coherent { Coherence::Incoherent } else { Coherence::Coherent };
        assert!(closest(&*second, other, &rays) == ours, "an answer depends on the rays beside");
    }
}

/// One of each quadric beside a mesh, still and moving; every third is clear.
fn quadrics_in_rows() -> Scene {
    let mut models = vec![still("mesh", octahedron(0, true), Vec3::new(-2.0, 0.5, 1.0))];
    for (quadric, number) in toy::quadrics().iter().zip(0..) {
        let (at, casts) =
            (DVec3::new(2.5 * f64::from(number % 3), 0.0, 2.5 * f64::from(number / 3)), number % 3 > 0);
        let place = DAffine3::from_translation(at) * DAffine3::from_axis_angle(DVec3::X, f64::from(number));
        models.push(toy::still_quadric("still", quadric, 0, casts, place));
        let track = TransformTrack {
            translate: keys(&[(0.0, at + DVec3::Y * 2.5), (2.0, at + DVec3::Y * 3.0)]),
            rotate: keys(&[(0.0, DVec3::ZERO), (2.0, DVec3::splat(40.0))]),
            scale: Track::constant(DVec3::new(0.7, -1.1, 0.9)),
            ..TransformTrack::identity()
        };
        models.push(toy::moving_quadric("moving", quadric, 0, track));
    }
    scene_of(models)
}

#[test]
fn tracers_agree_on_quadrics() {
    assert_agreement(&quadrics_in_rows());
}

/// Thin curves and thick ones, still and moving, stretched as well.
#[test]
fn tracers_agree_on_curves() {
    let mut models = vec![still("mesh", octahedron(0, true), Vec3::new(-2.0, 0.5, 1.0))];
    for (is_thick, number) in [(true, 0), (false, 1), (true, 2)] {
        let at = DVec3::X * 2.5 * f64::from(number);
        let curves = toy::tuft(is_thick);
        let stretch = if number == 2 { DVec3::new(0.5, 1.0, -1.4) } else { DVec3::ONE };
        let place = DAffine3::from_translation(at) * DAffine3::from_scale(stretch);
        models.push(toy::still_curves("still", &curves, 0, place));
        let track = TransformTrack {
            translate: keys(&[(0.0, at + DVec3::Z * 2.5), (2.0, at + DVec3::Z * 3.0)]),
            rotate: keys(&[(0.0, DVec3::ZERO), (2.0, DVec3::splat(40.0))]),
            scale: Track::constant(DVec3::new(0.7, -1.1, 0.9)),
            ..TransformTrack::identity()
        };
        models.push(moving("moving", Mesh::of_curved(curves, 0, true), track));
    }
    assert_agreement(&scene_of(models));
}

/// A ray that has entered a curve meets nothing of it from within, in whichever piece.
#[test]
fn rays_pass_curves_from_within() {
    let curves = toy::tuft(true);
    let scene = scene_of(vec![toy::still_curves("tuft", &curves, 0, DAffine3::IDENTITY)]);
    on_each(&scene, |tracer, way| {
        for turn in 0..7 {
            let angle = turn as f32 * 0.9;
            for (up, direction) in [(0.5_f32, Vec3::Y), (0.5, Vec3::NEG_Y), (0.3, Vec3::new(0.1, 1.0, 0.0))] {
                let away = 0.2 + 0.7 * up * up;
                let axis = Vec3::new(away * angle.cos(), 2.0 * up, away * angle.sin());
                let within = first(tracer, way, axis, direction);
                assert!(within.is_none_or(|hit| hit.t > 0.15), "{within:?} from {axis}");
            }
        }
    });
}

#[test]
fn planes_have_no_end() {
    let plane = Quadric::new(QuadricShape::Plane { center: [0.0; 2], reach: 1e9 }, false);
    let track = TransformTrack {
        translate: keys(&[(0.0, DVec3::ZERO), (2.0, DVec3::Y)]),
        ..TransformTrack::identity()
    };
    let models = vec![
        toy::still_quadric("plane", &plane, 0, true, DAffine3::IDENTITY),
        toy::moving_quadric("above", &plane, 0, track),
    ];
    on_each(&scene_of(models), |tracer, way| {
        for (eye, direction, model, t) in [
            (Vec3::new(3.0, 0.25, 1.0), Vec3::new(1.0, -1e-6, 0.0), 0, 0.25e6),
            (Vec3::new(3.0, 0.25, 1.0), Vec3::new(-1.0, 1e-6, 0.0), 1, 0.25e6),
            (Vec3::new(-7.0, -2.0, 1.0), Vec3::Y, 0, 2.0),
        ] {
            let hit = first(tracer, way, eye, direction).unwrap();
            assert!(hit.model == model && (hit.t / t - 1.0).abs() < 1e-5, "{hit:?}");
        }
    });
}

/// A piece hides itself, as no triangle can; the place that a segment ends in does not.
#[test]
fn a_tube_hides_its_own_far_wall_alone() {
    let tube = Quadric::new(QuadricShape::Cylinder { radius: 1.0, height: 2.0 }, true);
    let moved = TransformTrack {
        translate: keys(&[(0.0, DVec3::ZERO), (2.0, DVec3::ZERO), (3.0, DVec3::X)]),
        ..TransformTrack::identity()
    };
    for (model, by) in [
        (toy::still_quadric("still", &tube, 0, true, DAffine3::IDENTITY), Occluders::Still),
        (toy::moving_quadric("moving", &tube, 0, moved), Occluders::Movable),
    ] {
        on_each(&scene_of(vec![model]), |tracer, way| {
            let mut rays = RayBatch::default();
            let eye = Vec3::new(0.0, 1.0, 5.0);
            for (eye, at) in [
                (eye, Vec3::new(0.0, 1.0, 1.0)),
                (eye, Vec3::new(0.0, 1.0, -1.0)),
                (Vec3::new(0.0, 9.0, 2.0), Vec3::new(0.0, 1.5, -1.0)),
            ] {
                rays.push_to_sample(eye, at - eye, 0.0, 1.0 - 1e-5, 0, 0);
            }
            assert_eq!(blocks(tracer, way, by, Purpose::Sight, &rays), [false, true, false]);
            // no sample of it: it blocks wherever it is met
            rays.clear();
            rays.push_to_sample(eye, Vec3::new(0.0, 0.0, -4.5), 0.0, 1.0, 0, 7);
            rays.push(eye, Vec3::new(0.0, 0.0, -3.5), 0.0, 1.0);
            assert_eq!(blocks(tracer, way, by, Purpose::Sight, &rays), [true, false]);
        });
    }
}

#[test]
fn tracers_agree_on_the_city() {
    assert_agreement(&scene::load("scenes/city/city.toml".as_ref(), false).unwrap().scene);
}

#[test]
#[cfg_attr(not(scene_collection), ignore = "needs the scene collection: set AFTERIMAGE_SCENES")]
fn tracers_agree_on_a_real_kitchen() {
    let folder = collection::folder("kitchen");
    assert_agreement(&scene::load(&folder.join("kitchen.obj"), false).unwrap().scene);
}
