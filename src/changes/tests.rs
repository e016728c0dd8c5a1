//! Answers of [`Motion`], compared with those of looking at each frame, box and triangle.

use std::sync::Arc;
use std::time::Instant;

use glam::{DVec3, Vec3};

use super::parts::{MOST_BOXES, PartBoxes, boxes_of};
use super::world::*;
use super::{Direction, Motion, Until};
use crate::animation::{Interpolation, ShapeTrack, Track, Transform, TransformTrack};
use crate::exposure::{Clock, Exposures, Shutter, Strata};
use crate::geometry::Bounds;
use crate::pose::Pose;
use crate::scene::{Mesh, Scene, Shapes};
use crate::sweep::Sweeps;

/// Frames that hold all motion of random scenes.
const FRAMES: std::ops::RangeInclusive<i32> = -15..=50;

/// By how much boxes of which it is asked whether an answer is too early are larger.
const ROOM: f64 = 1e-5;

/// A frame's count, and a count's frame.
fn count(direction: Direction, frame: i32) -> i32 {
    direction.count(frame.into()) as i32
}

/// The counts of all frames, rising.
fn counts(direction: Direction) -> Vec<i32> {
    let mut counts: Vec<i32> = FRAMES.map(|frame| count(direction, frame)).collect();
    counts.sort_unstable();
    counts
}

/// By frame, the models that are not where they were in the frame before, at their old places and their new ones: those at which they
/// are there.
fn moved(poses: &[Pose]) -> impl Iterator<Item = (i32, Vec<(usize, &Transform)>)> {
    poses.windows(2).map(|pair| {
        let [before, now] = [&pair[0], &pair[1]];
        let is_other = |model: &usize| {
            before.models[*model] != now.models[*model] || before.sweeps.of(*model) != now.sweeps.of(*model)
        };
        let places = (0..now.models.len()).filter(is_other).flat_map(|model| {
            before.transforms(model).chain(now.transforms(model)).map(move |place| (model, place))
        });
        (now.frame, places.filter(|(_, place)| place.is_visible).collect())
    })
}

/// The first frame after the segment's in which one of those that moved touches it, by brute force.
fn first_frame<T>(moved: &[(i32, Vec<T>)], segment: &Segment, touches: impl Fn(&T) -> bool) -> Option<i32> {
    let mut later = moved.iter().filter(|(frame, _)| *frame > segment.after);
    later.find(|(_, placed)| placed.iter().any(&touches)).map(|(frame, _)| *frame)
}

/// A model at one of its places, world space.
struct Placed {
    /// Boxes of the parts of its mesh.
    boxes: Vec<Bounds>,
    triangles: Vec<[DVec3; 3]>,
    /// Around both.
    around: Bounds,
}

impl Placed {
    fn new(mesh: &Mesh, boxes: &PartBoxes, place: &Transform) -> Self {
        let boxes: Vec<Bounds> = boxes.on(&place.shape).map(|bounds| bounds.placed(place)).collect();
        let (all, shapes) = (mesh.triangles(), mesh.shapes());
        let deformed = shapes.map(|shapes| place.shape.ends.map(|end| shapes.positions(&end)));
        let corner = |i: u32| {
            let at = |positions: &[[f32; 3]]| Vec3::from_array(positions[i as usize]);
            let ends = deformed.as_ref().map(|ends| place.shape.point([at(&ends[0]), at(&ends[1])]));
            place.point(ends.unwrap_or_else(|| at(all.positions.as_slice())))
        };
        let triangles: Vec<[Vec3; 3]> = all.corners.iter().map(|triangle| triangle.map(corner)).collect();
        let around = boxes.iter().fold(Bounds::EMPTY, |all, bounds| all.union(*bounds));
        let around = triangles.iter().flatten().copied().fold(around, Bounds::with);
        let triangles = triangles.iter().map(|corners| corners.map(|corner| corner.as_dvec3())).collect();
        Self { boxes, triangles, around }
    }

    /// Returns true if a segment meets one of the boxes, which are larger by a share of its distance.
    fn is_met_in_a_box(&self, segment: &Segment, room: f64) -> bool {
        meets_box(&self.around, segment, room)
            && self.boxes.iter().any(|bounds| meets_box(bounds, segment, room))
    }

    /// Returns true if a segment meets one of the triangles.
    fn is_met(&self, segment: &Segment) -> bool {
        meets_box(&self.around, segment, ROOM)
            && self.triangles.iter().any(|triangle| meets_triangle(*triangle, segment))
    }
}

/// In the order of time that runs in `direction`; their frames are counts.
fn poses(scene: &Scene, clock: &Clock, direction: Direction) -> Vec<Pose> {
    let pose = |counted: i32| {
        let moment = count(direction, counted).into();
        let mut models: Vec<Transform> =
            scene.models.iter().map(|model| model.track.at(clock.time(moment))).collect();
        let sweeps = Sweeps::new(scene, clock, moment, &mut models);
        Pose { frame: counted, models, sweeps, ..Pose::new(scene, 0) }
    };
    counts(direction).into_iter().map(pose).collect()
}

/// Boxes of all models, object space.
fn boxes(scene: &Scene) -> Vec<PartBoxes> {
    scene.models.iter().map(|model| PartBoxes::new(&model.mesh, MOST_BOXES)).collect()
}

/// Returns true if a segment meets a box that is larger by a share of its distance: in double precision.
fn meets_box(bounds: &Bounds, segment: &Segment, room: f64) -> bool {
    let (mut enter, mut leave) = (0.0, f64::from(segment.far));
    for axis in 0..3 {
        let origin = f64::from(segment.origin[axis]);
        let along = f64::from(segment.direction[axis]);
        let (low, high) =
            (f64::from(bounds.low[axis]) - origin - room, f64::from(bounds.high[axis]) - origin + room);
        if along == 0.0 {
            if low > 0.0 || high < 0.0 {
                return false;
            }
            continue;
        }
        enter = f64::max(enter, f64::min(low / along, high / along));
        leave = f64::min(leave, f64::max(low / along, high / along));
    }
    enter <= leave
}

/// In double precision.
fn meets_triangle([a, b, c]: [DVec3; 3], segment: &Segment) -> bool {
    let (origin, direction) = (segment.origin.as_dvec3(), segment.direction.as_dvec3());
    let (across, up) = (b - a, c - a);
    let side = direction.cross(up);
    let scale = 1.0 / across.dot(side);
    let u = (origin - a).dot(side) * scale;
    let other = (origin - a).cross(across);
    let (v, t) = (direction.dot(other) * scale, up.dot(other) * scale);
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t <= f64::from(segment.far)
}

/// The frame of an answer; none if it holds forever.
fn frame_of(motion: &Motion, until: Until) -> Option<i32> {
    count_of(motion, Direction::Forward, until)
}

/// Its count.
fn count_of(motion: &Motion, direction: Direction, until: Until) -> Option<i32> {
    counts(direction).into_iter().find(|frame| motion.has_expired(until, count(direction, *frame)))
}

/// Frames in their order, never last.
fn rank(frame: Option<i32>) -> i32 {
    frame.unwrap_or(i32::MAX)
}

/// Comparison of answers with those of brute force.
#[derive(Debug, Default)]
struct Tally {
    asked: usize,
    /// Touched by a triangle some time.
    touched: usize,
    /// Later than the boxes, or than the triangles: wrong.
    late: usize,
    /// Not after the frame of the question: wrong.
    spent: usize,
    /// Earlier than boxes that are a little larger: the hierarchy is wrong, or coarse.
    early: usize,
    /// Earlier than the triangles: the price of boxes.
    false_alarms: usize,
}

impl Tally {
    /// Asks random questions about `scene`. `answer` has the count of the first frame of a touch.
    fn of(
        scene: &Scene,
        (clock, direction): (&Clock, Direction),
        dice: &mut Dice,
        answer: impl Fn(&Segment) -> Option<i32>,
    ) -> Self {
        let (poses, boxes) = (poses(scene, clock, direction), boxes(scene));
        let placed = |(model, place): (usize, &Transform)| {
            Placed::new(&scene.models[model].mesh, &boxes[model], place)
        };
        let moved: Vec<(i32, Vec<Placed>)> =
            moved(&poses).map(|(frame, places)| (frame, places.into_iter().map(placed).collect())).collect();
        let mut tally = Self::default();
        for _ in 0..60 {
            let segment = random_segment(dice);
            let after = count(direction, segment.after);
            let segment = Segment { after, ..segment };
            let got = rank(answer(&segment));
            let by_box = |room: f64| {
                rank(first_frame(&moved, &segment, |placed| placed.is_met_in_a_box(&segment, room)))
            };
            let (exact, roomy) = (by_box(0.0), by_box(ROOM));
            let mesh = rank(first_frame(&moved, &segment, |placed| placed.is_met(&segment)));
            tally.asked += 1;
            tally.touched += usize::from(mesh < i32::MAX);
            tally.late += usize::from(got > exact || got > mesh);
            tally.spent += usize::from(got <= segment.after);
            tally.early += usize::from(got < roomy);
            tally.false_alarms += usize::from(got < mesh);
        }
        tally
    }

    fn and(self, other: Self) -> Self {
        Self {
            asked: self.asked + other.asked,
            touched: self.touched + other.touched,
            late: self.late + other.late,
            spent: self.spent + other.spent,
            early: self.early + other.early,
            false_alarms: self.false_alarms + other.false_alarms,
        }
    }

    /// Compares answers in many random scenes; `change` is done to each.
    fn of_random_scenes(limit: usize, direction: Direction, change: impl Fn(i32) -> i32) -> Self {
        Self::at_moments(limit, &Clock::FRAMES, direction, change)
    }

    /// Compares answers at the moments of `clock`.
    fn at_moments(limit: usize, clock: &Clock, direction: Direction, change: impl Fn(i32) -> i32) -> Self {
        let mut dice = Dice(7);
        let scenes = if *clock == Clock::FRAMES { 200 } else { 30 };
        let tallies = (0..scenes).map(|_| {
            let scene = random_scene(&mut dice);
            let motion = Motion::with_limit(&scene, clock, direction, limit);
            Self::of(&scene, (clock, direction), &mut dice, |segment| {
                let after = count(direction, segment.after);
                let until = motion.first_touch(segment.origin, segment.direction, segment.far, after);
                count_of(&motion, direction, until).map(&change)
            })
        });
        tallies.fold(Self::default(), Self::and)
    }
}

#[test]
fn answers_are_those_of_looking_at_each_frame_and_box() {
    for direction in [Direction::Forward, Direction::Backward] {
        let tally = Tally::of_random_scenes(1 << 20, direction, |frame| frame);
        println!("{tally:?}");
        assert_eq!((tally.late, tally.spent, tally.early), (0, 0, 0));
        assert!(tally.touched > tally.asked / 20, "{tally:?}");
        assert!(tally.false_alarms < tally.asked * 3 / 10, "{tally:?}");
    }
}

/// Frames that are exposed before and after their own time, and with cuts.
#[test]
fn answers_are_those_of_looking_at_each_moment_and_box() {
    let clock = |number: usize, open, close, cuts: &[i32]| {
        let exposures = Exposures::new(Strata { across: 2 }, Some(&Shutter::new(open, close)), cuts);
        exposures.clocks()[number].clone()
    };
    for clock in [clock(0, -0.25, 0.25, &[]), clock(1, -1.0, 0.0, &[4, 20]), clock(3, 0.0, 1.0, &[7])] {
        for direction in [Direction::Forward, Direction::Backward] {
            let tally = Tally::at_moments(1 << 20, &clock, direction, |moment| moment);
            assert_eq!((tally.late, tally.spent), (0, 0), "{clock:?}, {direction:?}");
            // a box is around all places of a moment
            assert!(tally.early * 20 < tally.asked, "{tally:?}");
            assert!(tally.touched > tally.asked / 20, "{tally:?}");
        }
        let later = Tally::at_moments(1 << 20, &clock, Direction::Forward, |moment| moment + 1);
        assert!(later.late > later.asked / 10, "{later:?}");
    }
}

#[test]
fn an_answer_a_frame_later_or_earlier_would_be_seen() {
    for direction in [Direction::Forward, Direction::Backward] {
        let later = Tally::of_random_scenes(1 << 20, direction, |frame| frame + 1);
        assert!(later.late > later.asked / 10, "{later:?}");
        let earlier = Tally::of_random_scenes(1 << 20, direction, |frame| frame - 1);
        assert!(earlier.early > earlier.asked / 10 && earlier.spent > 0, "{earlier:?}");
    }
}

#[test]
fn coarse_answers_are_never_late() {
    let mut before = 0;
    for limit in [1 << 20, 200, 40, 1] {
        let tally = Tally::of_random_scenes(limit, Direction::Backward, |frame| frame);
        println!("limit {limit}: {tally:?}");
        assert_eq!((tally.late, tally.spent), (0, 0));
        assert!(tally.false_alarms >= before, "coarser is not better");
        before = tally.false_alarms;
    }
    assert!(before > 0);
}

fn sliding(keys: &[(f64, f64)]) -> TransformTrack {
    let keys = keys.iter().map(|(frame, x)| (*frame, DVec3::X * *x)).collect();
    let translate = Track::through(keys, Interpolation::Linear).expect("keys are good");
    TransformTrack { translate, ..TransformTrack::identity() }
}

/// A small mover on the x axis.
fn slider(keys: &[(f64, f64)]) -> Scene {
    scene(vec![model(pane(), sliding(keys))], vec![])
}

/// Across the x axis at `x`, without an end.
fn across(motion: &Motion, x: f32, after: i32) -> Until {
    motion.first_touch(Vec3::new(x, 0.0, -9.0), Vec3::Z, f32::INFINITY, after)
}

#[test]
fn where_nothing_moves_answers_hold_forever() {
    let resting = model(pane(), sliding(&[(1.0, 2.0), (9.0, 2.0)]));
    for scene in [scene(vec![], vec![]), scene(vec![resting], vec![])] {
        let motion = Motion::of(&scene);
        assert!(motion.is_none() && motion.nodes() == 0);
        for after in [i32::MIN, 0, i32::MAX] {
            assert_eq!(across(&motion, 2.0, after), Until::FOREVER);
            assert_eq!(motion.first_light_change(0, after), Until::FOREVER);
            assert!(!motion.has_expired(Until::FOREVER, after));
        }
    }
}

#[test]
fn what_rests_in_the_way_is_told_when_it_leaves() {
    let motion = Motion::of(&slider(&[(100.0, 0.0), (110.0, 50.0), (300.0, 50.0), (301.0, 90.0)]));
    let expires = |until, frame| !motion.has_expired(until, frame - 1) && motion.has_expired(until, frame);
    for after in [i32::MIN, 0, 100] {
        assert!(expires(across(&motion, 0.0, after), 101), "it leaves");
        assert!(expires(across(&motion, 50.0, after), 110), "it arrives");
        assert!(expires(across(&motion, 90.0, after), 301));
    }
    assert!(expires(across(&motion, 50.0, 110), 301) && expires(across(&motion, 50.0, 300), 301));
    assert_eq!(across(&motion, 0.0, 101), Until::FOREVER);
    assert_eq!(across(&motion, 50.0, 301), Until::FOREVER);
    assert_eq!(across(&motion, 90.0, i32::MAX), Until::FOREVER);
    assert_eq!(across(&motion, -30.0, 0), Until::FOREVER);
    let short = motion.first_touch(Vec3::new(50.0, 0.0, -9.0), Vec3::Z * 2.0, 4.0, 0);
    assert_eq!(short, Until::FOREVER, "it ends before");
    let (sooner, later) = (across(&motion, 0.0, 0), across(&motion, 50.0, 0));
    assert_eq!((sooner.min(later), later.min(Until::FOREVER)), (sooner, later));
    assert_eq!(Until::from_bits(later.to_bits()), later);
}

#[test]
fn frames_that_two_bytes_cannot_name_are_never_late() {
    let (first, named) = (-1000, i32::from(u16::MAX) - 1);
    let far = f64::from(first + 100_000);
    let begin = [(f64::from(first - 1), 0.0), (f64::from(first), 50.0)];
    let motion = Motion::of(&slider(&[begin[0], begin[1], (far - 1.0, 50.0), (far, 90.0)]));
    // counted from two frames before the first
    let last = first - 2 + named;
    // the truth is `far`
    for after in [first, 0, last - 1] {
        let until = across(&motion, 50.0, after);
        assert!(!motion.has_expired(until, last - 1) && motion.has_expired(until, last), "{after}");
    }
    for after in [last, last + 1, far as i32 - 1] {
        assert!(motion.has_expired(across(&motion, 50.0, after), after + 1), "{after}");
    }
    // without later motion nothing is lost
    let motion =
        Motion::of(&slider(&[begin[0], begin[1], (f64::from(last - 1), 50.0), (f64::from(last), 90.0)]));
    let until = across(&motion, 50.0, last - 1);
    assert!(
        until != Until::FOREVER && !motion.has_expired(until, last - 1) && motion.has_expired(until, last)
    );
    assert_eq!(across(&motion, 90.0, last), Until::FOREVER);
}

/// Whatever the frame: forwards and backwards the same number of frames.
#[test]
fn an_answer_can_be_told_in_the_other_direction() {
    let keys = [(100.0, 0.0), (110.0, 50.0), (300.0, 50.0), (301.0, 90.0), (400.0, 90.0), (401.0, 0.0)];
    let world = slider(&keys);
    let (forward, back) =
        (Motion::of(&world), Motion::in_direction(&world, &Clock::FRAMES, Direction::Backward, 1));
    let length = |motion: &Motion, direction: Direction, until, frame: i32| {
        let holds = |ahead: &i32| !motion.has_expired(until, frame + ahead * count(direction, 1));
        (0..500).take_while(holds).count()
    };
    for frame in [-9, 0, 99, 100, 105, 110, 200, 300, 301, 400, 401, 450] {
        for x in [0.0, 25.0, 50.0, 90.0, -30.0] {
            let until = across(&forward, x, frame);
            let other = forward.to_opposite(until, frame, &back);
            let [own, others] = [
                length(&forward, Direction::Forward, until, frame),
                length(&back, Direction::Backward, other, frame),
            ];
            assert!(own > 0 && others == own, "frame {frame}, {x}: {own}, {others}");
            let until = across(&back, x, frame);
            let other = back.to_opposite(until, frame, &forward);
            let [own, others] = [
                length(&back, Direction::Backward, until, frame),
                length(&forward, Direction::Forward, other, frame),
            ];
            assert!(own > 0 && others == own, "frame {frame}, {x}: {own}, {others}");
        }
    }
    for until in [Until::FOREVER, Until::UNKNOWN, Until::EXPIRED] {
        assert_eq!(forward.to_opposite(until, 7, &back), until);
    }
}

#[test]
fn changes_of_lights_are_told_one_after_the_other() {
    let power = vec![(5.0, 1.0), (7.0, 1.0), (9.0, 3.0)];
    let power = Track::through(power, Interpolation::Linear).expect("good");
    let moving =
        Track::through(vec![(20.0, DVec3::ZERO), (21.0, DVec3::X)], Interpolation::Linear).expect("good");
    let lights = vec![lamp(moving, Track::constant(1.0)), lamp(Track::constant(DVec3::ZERO), power)];
    let world = scene(vec![], lights);
    let motion = Motion::of(&world);
    let after = |light| {
        let frame = |after| frame_of(&motion, motion.first_light_change(light, after));
        [i32::MIN, 7, 8, 9, 20, 21, i32::MAX].map(frame)
    };
    assert_eq!(after(0), [Some(21), Some(21), Some(21), Some(21), Some(21), None, None]);
    assert_eq!(after(1), [Some(8), Some(8), Some(9), None, None, None, None]);
    assert_eq!(across(&motion, 0.0, 0), Until::FOREVER, "lights have no size");
    let back = Motion::in_direction(&world, &Clock::FRAMES, Direction::Backward, 1);
    let before = |light| {
        let count = |frame| count_of(&back, Direction::Backward, back.first_light_change(light, frame));
        [i32::MAX, 21, 20, 9, 8, 7, i32::MIN].map(|frame| count(frame).map(|count| -count))
    };
    assert_eq!(before(0), [Some(20), Some(20), None, None, None, None, None]);
    assert_eq!(before(1), [Some(8), Some(8), Some(8), Some(8), Some(7), None, None]);
    assert!(!motion.is_none() && motion.nodes() == 0);
}

#[test]
fn changes_of_models_are_told_wherever_they_are() {
    let mut world = slider(&[(2.0, 0.0), (4.0, 0.0), (6.0, 1.0)]);
    world.models.push(model(pane(), TransformTrack::identity()));
    let motion = Motion::of(&world);
    let after = |model| [0, 4, 5, 6].map(|frame| frame_of(&motion, motion.first_change_of(model, frame)));
    assert_eq!(after(0), [Some(5), Some(5), Some(6), None]);
    assert_eq!(after(1), [None; 4], "it rests");
}

#[test]
fn a_mesh_has_several_boxes_and_all_triangles_are_in_one() {
    let mesh = bent(&mut Dice(9), 200, 0.2);
    let (one, eight) = (boxes_of(&mesh, 1), boxes_of(&mesh, 8));
    assert_eq!((one.len(), eight.len()), (1, 8));
    let volume = |bounds: &Bounds| (bounds.high - bounds.low).element_product();
    assert!(eight.iter().map(volume).sum::<f32>() < 0.5 * volume(&one[0]), "the L is hollow");
    for triangle in 0..mesh.count() as u32 {
        let holds = |bounds: &Bounds| {
            mesh.triangles()
                .positions_of(triangle)
                .iter()
                .all(|corner| corner.cmpge(bounds.low).all() && corner.cmple(bounds.high).all())
        };
        assert!(eight.iter().any(holds));
    }
}

#[test]
fn a_few_large_triangles_have_many_small_boxes_that_hold_them() {
    let mesh = mesh_of_two();
    let (two, many) = (boxes_of(&mesh, 2), boxes_of(&mesh, MOST_BOXES));
    assert_eq!((two.len(), many.len()), (2, MOST_BOXES));
    let mut dice = Dice(3);
    // the triangles fill half of a square
    let mut share = |boxes: &[Bounds]| {
        let points = (0..4000).map(|_| [dice.between(-1.0, 1.0) as f32, dice.between(-1.0, 1.0) as f32]);
        let is_in = |[x, y]: [f32; 2], bounds: &Bounds| {
            (bounds.low.x..=bounds.high.x).contains(&x) && (bounds.low.y..=bounds.high.y).contains(&y)
        };
        points.filter(|point| boxes.iter().any(|bounds| is_in(*point, bounds))).count() as f32 / 4000.0
    };
    let [of_two, of_many] = [&two, &many].map(|boxes| share(boxes));
    assert!(of_two > 0.99 && of_many < 0.65, "{of_two} {of_many}");
    let mut dice = Dice(3);
    for triangle in (0..mesh.count() as u32).cycle().take(2000) {
        let [a, b, c] = mesh.triangles().positions_of(triangle);
        let (u, v) = (dice.between(0.0, 1.0) as f32, dice.between(0.0, 1.0) as f32);
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let point = a + u * (b - a) + v * (c - a);
        let room = Vec3::splat(1e-6);
        let holds =
            |bounds: &Bounds| point.cmpge(bounds.low - room).all() && point.cmple(bounds.high + room).all();
        assert!(many.iter().any(holds), "{point}");
    }
}

#[test]
fn asked_for_what_is_before_a_frame_the_first_touch_is_the_earlier_of_both() {
    let mut dice = Dice(17);
    let models = (0..6).map(|_| model(ball(0.4, 8), motion(&mut dice, [1.0, 60.0], 3.0))).collect();
    let moves = Motion::of(&scene(models, vec![]));
    let mut earlier = 0;
    for _ in 0..2000 {
        let (origin, direction) = (dice.point(4.0).as_vec3(), dice.point(4.0).as_vec3());
        let after = dice.below(60) as i32;
        let first = moves.first_touch(origin, direction, 1.0, after);
        let before = Until::from_bits(1 + dice.below(80) as u16);
        let expected =
            if before <= first && !moves.has_expired(before, after) { before } else { first.min(before) };
        let asked = moves.first_touch_before(origin, direction, 1.0, after, before);
        assert_eq!(asked, expected);
        earlier += u32::from(asked != before);
        assert_eq!(
            moves.expires_next(first, after),
            moves.has_expired(first, after + 1),
            "{first:?} {after}"
        );
    }
    assert!(earlier > 100, "{earlier}");
    assert!(!moves.expires_next(Until::FOREVER, 7) && moves.expires_next(Until::UNKNOWN, 7));
}

/// `cargo test --release --lib -- changes::tests::speed --ignored --nocapture`
#[test]
#[ignore = "measures"]
fn speed_of_queries() {
    let flying = |dice: &mut Dice, reach: f64, frames: f64| {
        let keys = (0..=4).map(|i| (1.0 + frames * f64::from(i) / 4.0, dice.point(reach)));
        let translate = Track::through(keys.collect(), Interpolation::Smooth).expect("keys rise");
        model(ball(0.15, 24), TransformTrack { translate, ..TransformTrack::identity() })
    };
    for (movers, frames, reach) in [(1, 256.0, 3.0), (100, 1000.0, 6.0)] {
        let mut dice = Dice(11);
        let scene = scene((0..movers).map(|_| flying(&mut dice, reach, frames)).collect(), vec![]);
        let start = Instant::now();
        let motion = Motion::of(&scene);
        let built = start.elapsed();
        let segments = (0..20_000).map(|_| {
            let (origin, end) = (dice.point(reach).as_vec3(), dice.point(reach).as_vec3());
            Segment { origin, direction: end - origin, far: 1.0, after: 1 + dice.below(frames as u64) as i32 }
        });
        let mut segments: Vec<Segment> = segments.collect();
        // as a renderer asks: frame after frame
        segments.sort_by_key(|segment| segment.after);
        let ask = |segment: &Segment| {
            motion.first_touch(segment.origin, segment.direction, segment.far, segment.after)
        };
        let touched = segments.iter().filter(|segment| ask(segment) != Until::FOREVER).count();
        let start = Instant::now();
        let sum: u64 = (0..20).flat_map(|_| &segments).map(|segment| u64::from(ask(segment).to_bits())).sum();
        let each = start.elapsed().as_secs_f64() * 1e9 / (20 * segments.len()) as f64;
        let visits =
            |segment: &Segment| motion.visits(segment.origin, segment.direction, segment.far, segment.after);
        let visits = segments.iter().map(visits).sum::<usize>() as f64 / segments.len() as f64;
        let touched = 100.0 * touched as f64 / segments.len() as f64;
        let poses: Vec<Pose> = (0..=frames as i32 + 1).map(|frame| Pose::new(&scene, frame)).collect();
        let moved: Vec<(i32, Vec<(usize, &Transform)>)> = moved(&poses).collect();
        let near = |place: &Transform, segment: &Segment| {
            let (line, to) = (segment.direction, place.point(Vec3::ZERO) - segment.origin);
            let t = (to.dot(line) / line.length_squared()).clamp(0.0, 1.0);
            to.distance(line * t) <= 0.15
        };
        let early = |segment: &&Segment| {
            let truth = first_frame(&moved, segment, |(_, place)| near(place, segment));
            truth.is_none_or(|frame| motion.has_expired(ask(segment), frame - 1))
                && ask(segment) != Until::FOREVER
        };
        let early = segments.iter().step_by(20).filter(early).count() as f64 * 0.1;
        println!(
            "{movers} movers, {frames} frames: {each:.1} ns and {visits:.2} nodes a query, {touched:.1} % touched, {early:.1} % too early; \
             {} nodes, built in {built:?} ({sum})",
            motion.nodes()
        );
    }
}

/// A pane that goes to and fro for ever: it is back in each frame, as it is in the first ones.
#[test]
fn what_repeats_moves_for_ever_from_its_first_frame_on() {
    let mesh = pane();
    let list = [0.0, 1.0]
        .map(|z| mesh.triangles().positions.as_slice().iter().map(|at| [at[0], at[1], at[2] + z]).collect());
    let shapes = Shapes::new(list.to_vec(), &mesh.triangles().corners, &[], &[0, 1, 2]);
    let shapes_track = ShapeTrack::through(vec![(5.0, 0), (8.0, 1)], Some(3.0));
    let track = TransformTrack { shapes: shapes_track, ..TransformTrack::identity() };
    let mesh = mesh.with_triangles(|triangles| triangles.shapes = Some(Arc::new(shapes)));
    let motion = Motion::of(&scene(vec![model(mesh, track)], vec![]));
    // across the way, where it is in frame 5 and each sixth one after it alone: it leaves with the next one
    let first = |after: i32| {
        let until = motion.first_touch(Vec3::new(0.1, -0.2, -0.25), Vec3::Z, 0.5, after);
        (1..3000).find(|frame| motion.has_expired(until, *frame))
    };
    assert_eq!(
        (first(-7), first(4), first(6), first(11), first(2999 - 5)),
        (Some(6), Some(6), Some(11), Some(12), Some(2999))
    );
    // beyond all frames with numbers everything counts as touched
    assert!(motion.has_expired(motion.first_touch(Vec3::splat(9.0), Vec3::X, 1.0, 5), 5 + 65_536));
}
