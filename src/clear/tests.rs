//! Whatever is proven holds for rays that are cast one by one at every triangle; and what should be proven is.

use glam::{DVec3, Vec3};

use super::{EyeBox, Lanes, Obstacles, Patch, Prover, Shows};
use crate::animation::TransformTrack;
use crate::changes::world::{Dice, model, scene, triangles};
use crate::geometry::Bounds;
use crate::lanes::{LANES, Vec3x8};
use crate::scene::{Mesh, Scene};

/// Width of a cell for each unit of distance.
const SPREAD: f32 = 0.01;

/// Reach of a sample for each unit of distance.
const REACH: f32 = 0.8 * SPREAD;

/// A wall at z = -5 of `count` x `count` squares, whose corners are off its plane by up to `bump`; without the squares of which `is_there`
/// is not true.
fn wall(dice: &mut Dice, count: u32, bump: f64, is_there: impl Fn(u32, u32) -> bool) -> Mesh {
    let at = |of: u32| -3.0 + 6.0 * f64::from(of) / f64::from(count);
    let mut corners = Vec::new();
    for (y, x) in (0..=count).flat_map(|y| (0..=count).map(move |x| (y, x))) {
        let corner = DVec3::new(at(x), at(y), -5.0 + dice.between(-bump, bump));
        corners.push(corner.as_vec3().to_array());
    }
    let number = |x: u32, y: u32| y * (count + 1) + x;
    let squares = (0..count).flat_map(|y| (0..count).map(move |x| (x, y))).filter(|(x, y)| is_there(*x, *y));
    let halves = |(x, y): (u32, u32)| {
        let [a, b, c, d] = [number(x, y), number(x + 1, y), number(x + 1, y + 1), number(x, y + 1)];
        [[a, b, c], [a, c, d]]
    };
    triangles(corners, squares.flat_map(halves).collect())
}

/// Triangles of the size `size` near the wall, before and behind it, and elsewhere.
fn specks(dice: &mut Dice, count: usize, size: f64) -> Mesh {
    let mut corners = Vec::new();
    for _ in 0..count {
        let middle = DVec3::new(dice.between(-1.5, 1.5), dice.between(-1.5, 1.5), dice.between(-5.5, -1.0));
        corners.extend([(); 3].map(|()| (middle + dice.point(size)).as_vec3().to_array()));
    }
    triangles(corners, (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// What a ray meets first: model, triangle, place, and the triangle's normal as the model has it.
fn first_hit(scene: &Scene, eye: Vec3, direction: Vec3) -> Option<(u32, u32, DVec3, DVec3)> {
    let (eye, direction) = (eye.as_dvec3(), direction.as_dvec3());
    let mut nearest: Option<(f64, (u32, u32, DVec3, DVec3))> = None;
    for (number, model) in (0..).zip(&scene.models) {
        for triangle in 0..model.mesh.count() as u32 {
            let corners = model.mesh.triangles().positions_of(triangle);
            let [a, b, c] = corners.map(|corner| corner.as_dvec3());
            let normal = (b - a).cross(c - a);
            let t = (a - eye).dot(normal) / direction.dot(normal);
            let at = eye + t * direction;
            let is_in = |from: DVec3, to: DVec3| (to - from).cross(at - from).dot(normal) >= 0.0;
            let is_met = t > 0.0 && is_in(a, b) && is_in(b, c) && is_in(c, a);
            if is_met && nearest.is_none_or(|(before, _)| t < before) {
                nearest = Some((t, (number, triangle, at, normal.normalize())));
            }
        }
    }
    nearest.map(|(_, hit)| hit)
}

/// A group of samples of model 0 around a direction, seen from the middle of `eyes`.
fn group(scene: &Scene, eyes: &EyeBox, towards: Vec3) -> Lanes {
    let mut lanes = Lanes { offsets: Vec3x8::ZERO, normals: Vec3x8::ZERO, triangles: [0; LANES], used: 0 };
    for lane in 0..LANES {
        let aside = Vec3::new((lane % 4) as f32, (lane / 4) as f32, 0.0) * SPREAD;
        let Some((0, triangle, at, normal)) = first_hit(scene, eyes.middle, towards + aside) else {
            continue;
        };
        lanes.offsets.set_lane(lane, (at - eyes.middle.as_dvec3()).as_vec3());
        lanes.normals.set_lane(lane, normal.as_vec3());
        lanes.triangles[lane] = triangle;
        lanes.used |= u8::from(normal.z > 0.0) << lane;
    }
    lanes
}

const WALL: Shows = Shows::Surface { model: 0, material: 0, is_from_behind: false };

fn is_clear(scene: &Scene, eyes: &EyeBox, lanes: &[Lanes], shows: Shows) -> bool {
    let patch = Patch { shows, lanes, axes: [Vec3::X, Vec3::Y], reach: REACH };
    Prover::default().is_clear(scene, &Obstacles::new(scene), eyes, &patch)
}

fn eyes(half: f32) -> EyeBox {
    EyeBox::new(&Bounds { low: Vec3::splat(-half), high: Vec3::splat(half) })
}

/// Casts rays from all over the box of eyes by the samples, and checks what they meet.
fn check(scene: &Scene, eyes: &EyeBox, lanes: &Lanes, dice: &mut Dice, what: &str) {
    for lane in (0..LANES).filter(|lane| lanes.used >> lane & 1 != 0).cycle().take(60) {
        let eye = eyes.middle + eyes.half * (dice.point(1.0).as_vec3());
        let sample = eyes.middle + lanes.offsets.lane(lane);
        let way = sample - eye;
        let (right, up) = way.normalize().any_orthonormal_pair();
        let turn = dice.between(0.0, std::f64::consts::TAU) as f32;
        let far = 0.75 * SPREAD * way.length() * dice.between(0.0, 1.0).sqrt() as f32;
        let target = sample + far * (turn.cos() * right + turn.sin() * up);
        let Some((met, _, at, normal)) = first_hit(scene, eye, target - eye) else {
            panic!("{what}: a ray by a sample that is proven to be clear meets nothing");
        };
        assert_eq!(met, 0, "{what}: something hides the surface of a sample that is proven to be clear");
        let layer = 0.25 * f64::from(SPREAD) * (at - eye.as_dvec3()).length();
        let apart = (at - sample.as_dvec3()).dot(normal).abs();
        assert!(normal.z > 0.0 && apart <= layer, "{what}: another layer: {apart} of {layer}");
    }
}

#[test]
fn what_is_proven_holds() {
    let mut dice = Dice(5);
    let (mut proven, mut unproven) = (0, 0);
    for trial in 0..120 {
        let bump = [0.0, 0.002, 0.02, 0.2][trial % 4];
        let count = [1, 4, 12, 40][trial / 4 % 4];
        let hole = dice.below(u64::from(count * count * 4)) as u32;
        let base = wall(&mut dice, count, bump, |x, y| y * count + x != hole);
        let small = [0.02, 0.2][trial / 16 % 2];
        let of_specks = 1 + dice.below(40) as usize;
        let specks = specks(&mut dice, of_specks, small);
        let models = [base, specks].map(|mesh| model(mesh, TransformTrack::identity()));
        let scene = scene(Vec::from(models), vec![]);
        let eyes = eyes([0.0, 0.02, 0.3][trial % 3]);
        for _ in 0..12 {
            let towards = Vec3::new(dice.between(-0.3, 0.3) as f32, dice.between(-0.3, 0.3) as f32, -1.0);
            let lanes = group(&scene, &eyes, towards);
            if lanes.used == 0 {
                continue;
            }
            if is_clear(&scene, &eyes, &[lanes], WALL) {
                proven += 1;
                check(&scene, &eyes, &lanes, &mut dice, &format!("trial {trial}"));
            } else {
                unproven += 1;
            }
        }
    }
    assert!(proven > 300 && unproven > 200, "both happen: {proven} {unproven}");
}

/// A mirror changes the order of a triangle's corners, and not its outside.
#[test]
fn mirrored_models_are_clear_as_others_are() {
    let mut dice = Dice(1);
    let wall = wall(&mut dice, 4, 0.0, |_, _| true);
    let mirrored = || {
        let scale = crate::animation::Track::constant(DVec3::new(-1.0, 1.0, 1.0));
        TransformTrack { scale, ..TransformTrack::identity() }
    };
    let of = |track: TransformTrack| scene(vec![model(wall.clone(), track)], vec![]);
    let as_it_is = of(TransformTrack::identity());
    let mut lanes = group(&as_it_is, &eyes(0.1), Vec3::new(0.2, 0.1, -1.0));
    assert!(is_clear(&as_it_is, &eyes(0.1), &[lanes], WALL));
    // the same triangles on the other side
    for lane in 0..LANES {
        let mut offset = lanes.offsets.lane(lane);
        offset.x = -offset.x;
        lanes.offsets.set_lane(lane, offset);
    }
    assert!(is_clear(&of(mirrored()), &eyes(0.1), &[lanes], WALL));
}

#[test]
fn a_wall_is_clear_until_something_is_before_it() {
    let mut dice = Dice(1);
    let speck = |at: Vec3| {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| (at + 0.001 * corner).to_array());
        triangles(corners.to_vec(), vec![[0, 1, 2]])
    };
    // a cell is 0.05 wide at the wall
    for (half, before, is_expected) in [
        (0.0, None, true),
        (0.1, None, true),
        (0.0, Some(Vec3::new(0.02, 0.01, -4.9)), false),
        (0.0, Some(Vec3::new(0.02, 0.01, -1.0)), false),
        (0.0, Some(Vec3::new(0.02, 0.01, -5.1)), true),
        // beside the samples, and within reach of their targets
        (0.0, Some(Vec3::new(-0.03, 0.0, -4.99)), false),
        (0.0, Some(Vec3::new(-0.06, 0.0, -4.99)), true),
        // other eyes of the box see it before them
        (0.0, Some(Vec3::new(-0.06, 0.0, -2.0)), true),
        (0.1, Some(Vec3::new(-0.06, 0.0, -2.0)), false),
        // behind the eyes
        (0.1, Some(Vec3::new(0.0, 0.0, 0.5)), true),
    ] {
        let walls = [1, 7].map(|count| wall(&mut dice, count, 0.0, |_, _| true));
        for wall in walls {
            let models = [Some(wall), before.map(speck)].into_iter().flatten();
            let scene = scene(models.map(|mesh| model(mesh, TransformTrack::identity())).collect(), vec![]);
            let eyes = eyes(half);
            let alone = crate::changes::world::scene(vec![scene.models[0].clone()], vec![]);
            let lanes = group(&alone, &eyes, Vec3::NEG_Z);
            assert_eq!(is_clear(&scene, &eyes, &[lanes], WALL), is_expected, "{half} {before:?}");
            let other = Shows::Surface { model: 0, material: 1, is_from_behind: false };
            assert!(!is_clear(&scene, &eyes, &[lanes], other), "it is of another material");
            let behind = Shows::Surface { model: 0, material: 0, is_from_behind: true };
            assert!(!is_clear(&scene, &eyes, &[lanes], behind), "it is seen from the other side");
        }
    }
}

#[test]
fn the_background_is_clear_where_nothing_is() {
    let mut dice = Dice(1);
    let scene = scene(vec![model(wall(&mut dice, 3, 0.0, |_, _| true), TransformTrack::identity())], vec![]);
    let towards = |direction: Vec3| {
        let mut lanes =
            Lanes { offsets: Vec3x8::ZERO, normals: Vec3x8::ZERO, triangles: [0; LANES], used: u8::MAX };
        for lane in 0..LANES {
            let aside = Vec3::new((lane % 4) as f32, (lane / 4) as f32, 0.0) * SPREAD;
            lanes.offsets.set_lane(lane, (direction + aside).normalize());
        }
        is_clear(&scene, &eyes(0.1), &[lanes], Shows::Background)
    };
    assert!(towards(Vec3::Z) && towards(Vec3::new(1.0, 0.0, -1.0)));
    // the wall ends at 0.6, for the eye that is furthest aside at 0.63
    assert!(
        !towards(Vec3::NEG_Z) && !towards(Vec3::new(0.61, 0.0, -1.0)) && towards(Vec3::new(0.65, 0.0, -1.0))
    );
}
