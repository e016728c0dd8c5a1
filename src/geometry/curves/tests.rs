use glam::DMat3;

use super::*;

/// A tuft of bent chains whose radii differ.
fn tuft() -> Curves {
    let mut points = Vec::new();
    for curve in 0..5 {
        for at in 0..6 {
            let (turn, height) = (curve as f32 * 1.3, at as f32 * 0.3);
            let lean = 0.12 * (at * at) as f32;
            points.push([
                lean * turn.cos() + curve as f32 * 0.05,
                height,
                lean * turn.sin(),
                0.08 - 0.012 * at as f32,
            ]);
        }
    }
    Curves::new(&points, &[6; 5], &[]).expect("it has curves").0
}

fn dice(seed: &mut u64) -> f32 {
    *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*seed >> 40) as f32 / (1u64 << 24) as f32
}

fn random_ray(seed: &mut u64) -> Ray {
    let mut vector = |size: f32| Vec3::new(dice(seed) - 0.5, dice(seed) - 0.5, dice(seed) - 0.5) * size;
    let (origin, at) = (vector(20.0), vector(1.5));
    let direction = at + Vec3::Y * 0.7 - origin;
    Ray { origin, direction, near: 0.0, far: f32::INFINITY, ends_here: false }
}

/// Distance from a point to the union of the pieces of one primitive, by stepping along its axis: the definition.
fn beyond_by_steps(curves: &Curves, primitive: u32, point: DVec3) -> f64 {
    let first = curves.chains.firsts[primitive as usize] as usize;
    let [a, b] = [first, first + 1].map(|at| curves.own.all[at].map(f64::from));
    (0..=4000)
        .map(|step| {
            let share = f64::from(step) / 4000.0;
            let [x, y, z, radius] = std::array::from_fn(|axis| a[axis] + (b[axis] - a[axis]) * share);
            point.distance(DVec3::new(x, y, z)) - radius
        })
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn rays_enter_where_the_spheres_along_a_piece_begin() {
    let (curves, mut seed, mut met) = (tuft(), 1, 0);
    for _ in 0..2000 {
        let ray = random_ray(&mut seed);
        for primitive in 0..curves.count() {
            let (from, hull) = curves.hull(primitive);
            let origin = ray.origin.as_dvec3() - from;
            let direction = ray.direction.as_dvec3().normalize();
            let Some(t) = hull.enter(origin, direction) else {
                // steps along the line find no point within
                let nearest = (0..400)
                    .map(|step| beyond_by_coarse(&curves, primitive, ray, step))
                    .fold(f64::INFINITY, f64::min);
                assert!(nearest > -1e-3, "{nearest}");
                continue;
            };
            met += 1;
            let point = from + origin + direction * t;
            let off = beyond_by_steps(&curves, primitive, point);
            assert!(off.abs() < 1e-6, "{off}");
            let inwards = beyond_by_steps(&curves, primitive, point + direction * 1e-5);
            let outwards = beyond_by_steps(&curves, primitive, point - direction * 1e-5);
            assert!(inwards < outwards, "it leaves there");
            let weights = hull.weights(point - from);
            assert!(hull.point(weights).distance(point - from) < 1e-9);
            assert!(hull.normal(weights).dot(direction) < 1e-6);
            assert!(hull.beyond(point - from).abs() < 1e-9);
        }
    }
    assert!(met > 300, "{met}");
}

fn beyond_by_coarse(curves: &Curves, primitive: u32, ray: Ray, step: i32) -> f64 {
    let share = f64::from(step) / 400.0 * 2.0;
    let point = ray.origin.as_dvec3() + ray.direction.as_dvec3() * share;
    let (from, hull) = curves.hull(primitive);
    hull.beyond(point - from)
}

#[test]
fn no_ray_meets_the_inside_of_a_curve() {
    let (curves, mut seed, mut met) = (tuft(), 7, 0);
    for _ in 0..4000 {
        let ray = random_ray(&mut seed);
        // the ray goes on from where it has entered, and meets none of the pieces that it is in
        let first = (0..curves.count())
            .filter_map(|primitive| Some((curves.meet(primitive, &ray)?.t, primitive)))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((t, primitive)) = first else { continue };
        met += 1;
        let on = Ray { near: t * 1.0001, ..ray };
        let point = |t: f32| (ray.origin + ray.direction * t).as_dvec3();
        for next in 0..curves.count() {
            if let Some(again) = curves.meet(next, &on) {
                let within = |other: u32| {
                    let (from, hull) = curves.hull(other);
                    hull.beyond(point(again.t) - from) < -1e-3
                };
                assert!(!curves.neighbours(next).any(within), "{next} after {primitive}");
            }
        }
    }
    assert!(met > 200, "{met}");
}

/// A ray from within a piece, to whichever side, leaves it without meeting it.
#[test]
fn rays_from_within_leave_their_piece() {
    let curves = tuft();
    let stretched = curves.mapped(DAffine3::from_scale(DVec3::new(2.0, 0.5, 1.0)));
    let mut seed = 5;
    for _ in 0..2000 {
        let ray = random_ray(&mut seed);
        let aside = Vec3::new(dice(&mut seed), dice(&mut seed), dice(&mut seed)) - 0.5;
        for primitive in 0..curves.count() {
            let Some(Meeting { weights, .. }) = curves.meet(primitive, &ray) else { continue };
            for all in [&curves as &dyn Curved, stretched.as_ref()] {
                let origin = all.inside(primitive, weights).expect("it is a fibre");
                let to = Ray { origin, direction: aside, near: 0.0, far: f32::INFINITY, ends_here: false };
                assert_eq!(all.meet(primitive, &to), None);
                let off = all.distance(primitive, origin);
                assert!(off > 1e-3 && off < 0.1, "{off}");
            }
        }
    }
}

#[test]
fn places_and_maps_agree() {
    let curves = tuft();
    let turn = DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(0.4);
    let maps = [
        DAffine3::from_mat3_translation(turn * 2.5, DVec3::new(1.0, 2.0, 3.0)),
        DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(DVec3::new(2.0, 0.5, -1.0)), DVec3::ONE),
    ];
    for map in maps {
        let mapped = curves.mapped(map);
        let mut seed = 3;
        let mut met = 0;
        for _ in 0..1000 {
            let ray = random_ray(&mut seed);
            let there = Ray {
                origin: map.transform_point3(ray.origin.as_dvec3()).as_vec3(),
                direction: map.transform_vector3(ray.direction.as_dvec3()).as_vec3(),
                ..ray
            };
            for primitive in 0..curves.count() {
                let (here, there) = (curves.meet(primitive, &ray), mapped.meet(primitive, &there));
                let (Some(here), Some(there)) = (here, there) else { continue };
                met += 1;
                assert!((here.t - there.t).abs() < 1e-3 * here.t, "{here:?} {there:?}");
                let point = mapped.point(primitive, there.weights);
                assert!(mapped.distance(primitive, point) < 1e-5);
                let parts = (0..mapped.boxes()).map(|part| mapped.bounds_of_part(primitive, part));
                let holds = |of: &Bounds| of.low.cmple(point).all() && point.cmple(of.high).all();
                assert!(parts.filter(holds).count() > 0);
                let bounds = mapped.bounds(primitive);
                assert!(bounds.low.cmple(point).all() && point.cmple(bounds.high).all());
                let mut found = false;
                mapped.near(point, 1e-4, &mut |one| found |= one == primitive);
                assert!(found);
            }
        }
        assert!(met > 100, "{met}");
    }
}

#[test]
fn a_ray_that_ends_on_a_piece_passes_that_place_and_no_other() {
    let (curves, mut seed, mut far_side) = (tuft(), 11, 0);
    for _ in 0..2000 {
        let ray = random_ray(&mut seed);
        for primitive in 0..curves.count() {
            let Some(Meeting { t, .. }) = curves.meet(primitive, &ray) else { continue };
            let to_there = Ray { direction: ray.direction * t, far: 1.0, ends_here: true, ..ray };
            assert_eq!(curves.meet(primitive, &to_there), None);
            let (from, hull) = curves.hull(primitive);
            let direction = ray.direction.as_dvec3().normalize();
            let back = hull.enter(ray.origin.as_dvec3() - from, -direction).expect("it leaves, too");
            let through = Ray { direction: (direction * -back).as_vec3(), far: 1.0, ends_here: true, ..ray };
            far_side += usize::from(curves.meet(primitive, &through).is_some());
        }
    }
    assert!(far_side > 100, "{far_side}");
}

#[test]
fn what_has_no_length_is_left_out() {
    let point = |x: f32| [x, 0.0, 0.0, 0.1];
    let points =
        [point(0.0), point(0.0), point(1.0), point(5.0), point(7.0), point(7.0), point(9.0), point(9.5)];
    let (curves, kept) = Curves::new(&points, &[3, 1, 2, 2], &[]).expect("two remain");
    assert_eq!((curves.curves(), curves.count()), (2, 2));
    let mut kept = kept;
    kept.sort_unstable();
    assert_eq!(kept, [0, 2, 6, 7]);
    assert!(Curves::new(&points[..2], &[2], &[]).is_none());
    // one sphere within the other: the larger one alone
    let nested =
        Curves::new(&[[0.0, 0.0, 0.0, 1.0], [0.1, 0.0, 0.0, 0.2]], &[2], &[]).expect("it has a length").0;
    let ray = Ray { origin: Vec3::X * 5.0, direction: Vec3::NEG_X, near: 0.0, far: 9.0, ends_here: false };
    let met = nested.meet(0, &ray).expect("it is met");
    assert!((met.t - 4.0).abs() < 1e-6);
    assert!(nested.point(0, met.weights).abs_diff_eq(Vec3::X, 1e-6));
}

/// Without texture coordinates of a curve u is the share of its length, however many pieces it has, and whichever curves are before it.
#[test]
fn places_know_how_far_along_their_curve_they_are() {
    let (mut seed, mut points) = (5, Vec::new());
    let counts = [2, 65, 66, 1000, 129];
    for (curve, count) in (0..).zip(counts) {
        let mut at = Vec3::new(0.0, 100.0 * curve as f32, 0.0);
        for _ in 0..count {
            at.x += 0.01 + dice(&mut seed).abs() * (1.0 + at.x.sin());
            points.push(at.extend(0.01).to_array());
        }
    }
    let curves = Curves::new(&points, &counts, &[]).expect("all have a length").0;
    let mapped = curves.mapped(DAffine3::from_scale(DVec3::splat(0.1)));
    let mut number = 0;
    for curve in 0..counts.len() {
        // curves are ordered by place: this one has as many pieces as follow each other
        let pieces = (number..curves.count()).take_while(|piece| curves.curve_of(*piece as usize) == curve);
        let pieces: Vec<u32> = pieces.collect();
        let length = |piece: u32| {
            let [a, b] = curves.ends(piece);
            (DVec3::from_slice(&b) - DVec3::from_slice(&a)).length()
        };
        let all: f64 = pieces.iter().map(|piece| length(*piece)).sum();
        let mut before = 0.0;
        for piece in &pieces {
            for weight in [0.0, 0.3, 1.0] {
                let wanted = ((before + length(*piece) * f64::from(weight)) / all) as f32;
                for curves in [&curves as &dyn Curved, &*mapped] {
                    let found = curves.uv(*piece, [weight, 0.0]).x;
                    assert!((found - wanted).abs() < 2e-6, "{curve}, {piece}: {found}, not {wanted}");
                }
            }
            before += length(*piece);
        }
        number += pieces.len() as u32;
    }
    assert_eq!(number, counts.iter().sum::<u32>() - 5);
}

/// A sphere that holds the next one is all that there is of a piece, with a chart of its own: so points are drawn, as balls.
#[test]
fn a_point_within_a_ball_leaves_the_ball() {
    let balls: [[f32; 4]; 3] = [[0.3, 0.5, -0.2, 0.4], [-0.8, 1.2, 0.4, 0.25], [0.1, 0.2, 0.9, 0.05]];
    let points: Vec<[f32; 4]> =
        balls.iter().flat_map(|ball| [*ball, [ball[0], ball[1] + 0.5 * ball[3], ball[2], 0.0]]).collect();
    let (curves, kept) = Curves::new(&points, &[2; 3], &[]).expect("they have a size");
    let (mut seed, mut met) = (5, 0);
    for _ in 0..6000 {
        let ray = random_ray(&mut seed);
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        for primitive in 0..3 {
            let ball = points[kept[2 * primitive as usize] as usize];
            let (middle, radius) = (Vec3::from_slice(&ball[..3]).as_dvec3(), f64::from(ball[3]));
            let half = direction.dot(origin - middle);
            let square = direction.length_squared();
            let root = half * half - square * ((origin - middle).length_squared() - radius * radius);
            let found = curves.meet(primitive, &ray);
            if root.abs() < 1e-3 {
                continue;
            }
            assert_eq!(found.is_some(), root > 0.0 && half < 0.0, "{ray:?} {ball:?}");
            let Some(Meeting { t, weights }) = found else { continue };
            assert!((f64::from(t) - (-half - root.sqrt()) / square).abs() < 1e-6, "{t}");
            let point = curves.point(primitive, weights).as_dvec3();
            let outwards = (point - middle) / radius;
            assert!((outwards.length() - 1.0).abs() < 1e-5, "{point}");
            assert!(curves.normal(primitive, weights).as_dvec3().dot(outwards) > 1.0 - 1e-6);
            assert!(point.distance(origin + direction * f64::from(t)) < 1e-4, "{weights:?}");
            met += 1;
        }
    }
    assert!(met > 500, "{met}");
}
