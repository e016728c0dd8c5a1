//! Tests of quadrics against their known properties.

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};

use super::{Quadric, QuadricShape};
use crate::geometry::curved::{Curved, FOUR, Ray};

/// One of each shape.
const SHAPES: [QuadricShape; 8] = [
    QuadricShape::Ellipsoid { radii: DVec3::new(2.0, 0.5, 1.25) },
    QuadricShape::Cylinder { radius: 0.75, height: 3.0 },
    QuadricShape::Cone { radius: 1.5, top: 0.0, height: 2.0 },
    QuadricShape::Cone { radius: 0.5, top: 1.0, height: 1.5 },
    QuadricShape::Paraboloid { radius: 1.0, height: 2.5 },
    QuadricShape::OneSheet { radius: 1.0, waist: 0.4, height: 2.0 },
    QuadricShape::TwoSheets { radius: 1.5, gap: 0.5, height: 3.0 },
    QuadricShape::Plane { center: [3.0, -2.0], reach: 1e6 },
];

/// Map that turns, shears by an uneven scale, and mirrors.
fn awry() -> DAffine3 {
    let turned = DAffine3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.0));
    DAffine3::from_translation(DVec3::new(1.0, -2.0, 0.5))
        * DAffine3::from_scale(DVec3::new(-1.0, 2.0, 0.7))
        * turned
}

fn quadrics() -> impl Iterator<Item = Quadric> {
    SHAPES.into_iter().flat_map(|shape| {
        [
            Quadric::new(shape, false),
            Quadric::new(shape, true).placed(awry()),
            Quadric::new(shape, false).placed(awry()),
        ]
    })
}

/// Points from 0 to below 1 in each coordinate, evenly spread, always the same.
fn even(count: u32) -> impl Iterator<Item = Vec3> {
    (0..count).map(|i| (Vec3::new(0.618_034, 0.414_214, 0.732_051) * (i as f32 + 0.5)).fract())
}

fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray { origin, direction, near: 0.0, far: f32::INFINITY, ends_here: false }
}

/// Rays through the box of a piece, from outside of it; for planes, through points near the centre.
fn rays(quadric: &Quadric, piece: u32) -> Vec<Ray> {
    let bounds = quadric.bounds(piece);
    let reach = Vec3::splat(20.0);
    let (low, high) = (bounds.low.max(-reach), bounds.high.min(reach));
    let through = even(3000).map(|at| low + (high - low) * at);
    let around = even(3000).map(|at| (at * 2.0 - 1.0).normalize_or(Vec3::X));
    through.zip(around).map(|(at, aside)| ray(at - aside * 30.0, aside * 1.5)).collect()
}

fn meetings(quadric: &Quadric, ray: &Ray) -> Vec<(f32, u32, Vec3)> {
    let (mut met, mut near) = (Vec::new(), 0.0);
    loop {
        let next = (0..quadric.count()).filter_map(|piece| {
            quadric
                .meet(piece, &Ray { near, ..*ray })
                .map(|hit| (hit.t, piece, quadric.normal(piece, hit.weights)))
        });
        let Some(next) = next.min_by(|a, b| a.0.total_cmp(&b.0)) else { return met };
        near = next.0;
        met.push(next);
    }
}

#[test]
fn rays_meet_points_of_the_surface() {
    for quadric in quadrics() {
        let mut count = 0;
        for piece in 0..quadric.count() {
            let bounds = quadric.bounds(piece);
            for ray in rays(&quadric, piece) {
                let Some(met) = quadric.meet(piece, &ray) else { continue };
                let (there, point) = (ray.origin + ray.direction * met.t, quadric.point(piece, met.weights));
                assert!(there.distance(point) < 1e-4, "{quadric:?}: {there} {point}");
                assert!(
                    point.cmpge(bounds.low).all() && point.cmple(bounds.high).all(),
                    "{point} {bounds:?}"
                );
                assert!(quadric.distance(piece, point) < 1e-5, "{point}");
                // a stored point is found again
                let again = quadric.point(piece, quadric.weights(piece, point));
                assert!(again.distance(point) < 4e-6 * point.length().max(1.0), "{again} {point}");
                let exact = quadric.meet_line(piece, ray.origin.as_dvec3(), ray.direction.as_dvec3(), point);
                assert!(
                    exact.distance(point) < 1e-4 && quadric.distance(piece, exact) < 1e-5,
                    "{exact} {point}"
                );
                count += 1;
            }
        }
        assert!(count > 300, "{count}");
    }
}

/// Checks that a ray's result is, to the bit, that of the ray alone, among rays that miss, end in the piece,
/// or are the same.
#[test]
fn four_rays_are_answered_as_each_alone() {
    let mut counts = [0; 2];
    for quadric in quadrics() {
        for piece in 0..quadric.count() {
            let mut rays = rays(&quadric, piece);
            for (number, ray) in rays.iter_mut().enumerate() {
                let there = quadric.meet(piece, ray).map_or(1.0, |met| met.t);
                match number % 5 {
                    // to a point of the piece, which does not count
                    0 => (ray.direction, ray.far, ray.ends_here) = (ray.direction * there, 1.0, true),
                    1 => ray.far = there * 0.9,
                    2 => ray.origin += ray.direction * there,
                    _ => {}
                }
            }
            for step in [1, 7] {
                for first in 0..rays.len() - FOUR * step {
                    let four: [Ray; FOUR] = std::array::from_fn(|lane| rays[first + lane * step]);
                    let (met, meetings) = quadric.meet_four(piece, &four);
                    for (lane, ray) in four.iter().enumerate() {
                        let together = (met >> lane & 1 != 0).then_some(meetings[lane]);
                        assert_eq!(together, quadric.meet(piece, ray), "{quadric:?} {ray:?}");
                        counts[usize::from(together.is_some())] += 1;
                    }
                    assert!(met < 1 << FOUR);
                }
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 10_000), "{counts:?}");
}

/// Checks that nothing is met again along the normal on one side of the surface, and that across it all ways
/// in are ways out.
#[test]
fn closed_quadrics_are_left_as_often_as_they_are_entered() {
    for shape in SHAPES.into_iter().filter(|shape| !matches!(shape, QuadricShape::Plane { .. })) {
        for quadric in [Quadric::new(shape, false), Quadric::new(shape, false).placed(awry())] {
            let mut entered = 0;
            for ray in (0..quadric.count()).flat_map(|piece| rays(&quadric, piece)) {
                let met = meetings(&quadric, &ray);
                for (number, (_, _, normal)) in met.iter().enumerate() {
                    let way = normal.dot(ray.direction);
                    assert!(
                        (way < 1e-3) == (number % 2 == 0) || way.abs() < 1e-3,
                        "{quadric:?} {ray:?} {met:?}"
                    );
                    assert!(normal.is_normalized());
                }
                assert!(met.len() % 2 == 0, "{quadric:?} {ray:?} {met:?}");
                entered += met.len() / 2;
            }
            assert!(entered > 1000, "{entered}");
        }
    }
}

#[test]
fn a_sphere_is_met_as_by_hand_near_and_far() {
    let sphere = Quadric::new(QuadricShape::Ellipsoid { radii: DVec3::ONE }, false);
    for far in [3.0, 3e3, 3e6] {
        let met = sphere.meet(0, &ray(Vec3::new(0.0, 0.6, far), Vec3::NEG_Z)).expect("it is in the way");
        assert!((f64::from(met.t) - (f64::from(far) - 0.8)).abs() <= f64::from(far) * 6e-8, "{far}: {met:?}");
        assert!(sphere.point(0, met.weights).distance(Vec3::new(0.0, 0.6, 0.8)) < 2e-7);
        // right beside the rim
        assert!(sphere.meet(0, &ray(Vec3::new(0.0, 0.999_999_9, far), Vec3::NEG_Z)).is_some());
        assert!(sphere.meet(0, &ray(Vec3::new(0.0, 1.000_000_1, far), Vec3::NEG_Z)).is_none());
    }
    let inside = sphere.meet(0, &ray(Vec3::ZERO, Vec3::new(0.0, 4.0, 0.0))).expect("it is all around");
    assert_eq!(inside.t, 0.25);
    // on the surface itself: once, at the other side, or not at all
    assert_eq!(sphere.meet(0, &ray(Vec3::X, Vec3::NEG_X)).map(|met| met.t), Some(2.0));
    assert_eq!(sphere.meet(0, &ray(Vec3::X, Vec3::X)), None);
    assert_eq!(sphere.meet(0, &ray(Vec3::X, Vec3::Y)), None);
}

#[test]
fn a_segment_passes_its_end_and_is_stopped_by_the_rest_of_its_piece() {
    let tube = Quadric::new(QuadricShape::Cylinder { radius: 1.0, height: 2.0 }, true);
    let to = |at: Vec3, eye: Vec3| Ray { far: 1.0 - 1e-5, ends_here: true, ..ray(eye, at - eye) };
    let eye = Vec3::new(0.0, 1.0, 5.0);
    assert_eq!(tube.meet(0, &to(Vec3::new(0.0, 1.0, 1.0), eye)), None, "the near wall is seen");
    assert!(tube.meet(0, &to(Vec3::new(0.0, 1.0, -1.0), eye)).is_some(), "it hides the far one");
    let above = Vec3::new(0.0, 9.0, 2.0);
    assert_eq!(tube.meet(0, &to(Vec3::new(0.0, 1.5, -1.0), above)), None, "seen through the open end");
}

#[test]
fn planes_reach_to_the_horizon_and_say_where_they_are() {
    let plane = Quadric::new(QuadricShape::Plane { center: [3.0, -2.0], reach: 1e6 }, false);
    let met = plane.meet(0, &ray(Vec3::new(1.0, 2.0, 5.0), Vec3::new(1.0, -1e-5, 0.0))).expect("far away");
    assert!((met.t - 2e5).abs() < 0.1, "{met:?}");
    let uv = plane.uv(0, plane.weights(0, Vec3::new(4.25, 0.0, -1.5)));
    assert!((uv - Vec2::new(4.25, 1.5)).length() < 1e-5, "{uv}");
    // texture coordinates of the object, wherever it is placed
    let turned = plane.placed(awry());
    let there = awry().transform_point3(DVec3::new(4.25, 0.0, -1.5)).as_vec3();
    assert!((turned.uv(0, turned.weights(0, there)) - Vec2::new(4.25, 1.5)).length() < 1e-5);
    assert_eq!(plane.meet(0, &ray(Vec3::Y, Vec3::X)), None, "beside it");
    assert_eq!(plane.meet(0, &ray(Vec3::ZERO, Vec3::NEG_Y)), None, "an eye in a plane does not see it");
}

#[test]
fn textures_go_around_to_the_right() {
    let sphere = Quadric::new(QuadricShape::Ellipsoid { radii: DVec3::ONE }, false);
    for (at, uv) in [
        (Vec3::Z, [0.5, 0.5]),
        (Vec3::X, [0.75, 0.5]),
        (Vec3::NEG_X, [0.25, 0.5]),
        (Vec3::new(0.0, 0.5_f32.sqrt(), 0.5_f32.sqrt()), [0.5, 0.75]),
    ] {
        let found = sphere.uv(0, sphere.weights(0, at));
        assert!((found - Vec2::from(uv)).length() < 1e-6, "{at}: {found}");
    }
    let tube = Quadric::new(QuadricShape::Cylinder { radius: 2.0, height: 4.0 }, false);
    let found = tube.uv(0, tube.weights(0, Vec3::new(2.0, 3.0, 0.0)));
    assert!((found - Vec2::new(0.75, 0.75)).length() < 1e-6, "{found}");
    let top = tube.uv(2, tube.weights(2, Vec3::new(1.0, 4.0, -1.0)));
    assert!((top - Vec2::new(0.75, 0.75)).length() < 1e-6, "{top}");
}

#[test]
fn what_is_beside_a_steep_side_is_near() {
    // at the rim it rises by 1,000 where it goes aside by 1
    let bowl = Quadric::new(QuadricShape::Paraboloid { radius: 1.0, height: 500.0 }, true);
    for aside in [-1e-3, 1e-3] {
        let at = Vec3::new(0.9 + aside, 405.0, 0.0);
        let distance = bowl.distance(0, at);
        assert!((distance - 1e-3).abs() < 1e-5, "{distance}");
    }
    let above = bowl.distance(0, Vec3::new(1.0, 501.0, 0.0));
    assert!((above - 1.0).abs() < 1e-3, "it ends at its rim: {above}");
}

#[test]
fn the_middle_of_a_leaf_is_near_to_its_sides() {
    let leaf = Quadric::new(QuadricShape::Ellipsoid { radii: DVec3::new(1.0, 1e-9, 1.0) }, false);
    for x in [0.0, 0.4, 0.67, 0.99] {
        let distance = leaf.distance(0, Vec3::new(x, 0.0, 0.0));
        assert!(distance <= 1e-9, "{x}: {distance}");
    }
    let beside = leaf.distance(0, Vec3::new(1.5, 0.0, 0.0));
    assert!((beside - 0.5).abs() < 0.1, "{beside}");
}
