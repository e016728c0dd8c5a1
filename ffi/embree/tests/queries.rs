//! Rays with known answers.
#![allow(clippy::unwrap_used, reason = "tests")]

mod scenes;

use embree::{
    ALL_TIMES, Bounds, BuildQuality, Coherence, Device, ErrorCode, Geometry, GeometryId, INVALID, PrimId,
    Ray, RayHit, Scene, Segment, Valid, VertexBuffer,
};
use scenes::{IDENTITY, UNIT_TRIANGLE, down, medium, mesh, moved};
use std::sync::Arc;

/// Runs a test with packets of each width, native or not, within each instruction set.
macro_rules! in_each_width {
    ($($name:ident)+) => {
        mod in_each_width {
            $(#[test]
            fn $name() {
                for device in super::devices() {
                    super::$name::<4>(&device);
                    super::$name::<8>(&device);
                    super::$name::<16>(&device);
                }
            })+
        }
    };
}
in_each_width! {
    lanes_that_are_off_are_left_alone
    of_two_coincident_triangles_one_is_closest_and_both_occlude
    of_equally_near_triangles_the_least_is_hit
    no_ray_is_occluded_by_its_own_primitive
    own_primitives_are_known_by_their_instance
    an_empty_scene_answers_no
}

/// One of each instruction set that this processor has.
fn devices() -> Vec<Device> {
    let configs = ["threads=1", "threads=1,isa=avx2", "threads=1,isa=sse4.2"];
    configs.into_iter().filter(|config| has_isa(config)).map(|config| Device::new(config).unwrap()).collect()
}

#[cfg(target_arch = "x86_64")]
fn has_isa(config: &str) -> bool {
    !config.contains("avx2") || is_x86_feature_detected!("avx2")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_isa(config: &str) -> bool {
    !config.contains("isa")
}

const BOTH: [Coherence; 2] = [Coherence::Coherent, Coherence::Incoherent];

/// Traces eight times the ray that falls from (x, y, 1) and returns lane 3.
fn drop_ray(scene: &mut Scene, x: f32, y: f32, mask: u32) -> (f32, [u32; 3], [f32; 5]) {
    let mut rays = down(|_| [x, y, 1.0]);
    rays.mask = [mask; 8];
    let mut packet = RayHit::new(rays);
    scene.commit().unwrap().intersect(&Valid::ALL, &mut packet, Coherence::Incoherent);
    let hit = &packet.hit;
    // the last bit of Embree's reciprocals depends on the processor; infinity stays what it is
    const STEPS: f32 = (1 << 20) as f32;
    (
        (packet.ray.tfar[3] * STEPS).round() / STEPS,
        [hit.prim_id[3], hit.geom_id[3], hit.inst_id[3]],
        [hit.u[3], hit.v[3], hit.ng_x[3], hit.ng_y[3], hit.ng_z[3]],
    )
}

#[test]
fn a_triangle_is_hit_where_it_is() {
    let device = scenes::device();
    let mut scene = medium(&device);
    let id = scene.attach(&mesh(&device, &[UNIT_TRIANGLE], 1)).unwrap();
    let (t, ids, [u, v, normal @ ..]) = drop_ray(&mut scene, 0.25, 0.5, 1);
    assert_eq!((t, ids), (1.0, [0, id.0, INVALID]));
    assert!((u - 0.25).abs() < 1e-6 && (v - 0.5).abs() < 1e-6, "{u} {v}");
    assert_eq!(normal, [0.0, 0.0, 1.0]);
    assert_eq!(drop_ray(&mut scene, 0.75, 0.75, 1).0, f32::INFINITY);
}

fn lanes_that_are_off_are_left_alone<const N: usize>(device: &Device) {
    let mut scene = medium(device);
    scene.attach(&mesh(device, &[UNIT_TRIANGLE], 1)).unwrap();
    let tracer = scene.commit().unwrap();
    let valid = Valid::from_bits(0b0000_0000_1010_0101);
    for coherence in BOTH {
        let mut packet = RayHit::<N>::new(down(|_| [0.25, 0.25, 1.0]));
        let mut shadow = packet.ray;
        tracer.intersect(&valid, &mut packet, coherence);
        tracer.occluded(&valid, &mut shadow, coherence);
        for lane in 0..N {
            assert_eq!(packet.hit.is_hit(lane), valid.is_on(lane), "lane {lane}");
            assert_eq!(shadow.is_occluded(lane), valid.is_on(lane), "lane {lane}");
        }
    }
}

#[test]
fn an_instance_stands_where_its_transform_puts_it() {
    let device = scenes::device();
    let mut child = medium(&device);
    child.attach(&mesh(&device, &[UNIT_TRIANGLE], u32::MAX)).unwrap();
    let child = child.freeze().unwrap();
    let mut scene = medium(&device);
    scene.attach(&mesh(&device, &[UNIT_TRIANGLE], u32::MAX)).unwrap();
    let id = scene.attach_instance(&child, moved(5.0, 0.0, -1.0), u32::MAX).unwrap();
    assert_eq!(id.0, 1);

    assert_eq!(drop_ray(&mut scene, 5.25, 0.25, 1).0, 2.0);
    assert_eq!(drop_ray(&mut scene, 5.25, 0.25, 1).1, [0, 0, id.0]);
    assert_eq!(drop_ray(&mut scene, 0.25, 0.25, 1).1, [0, 0, INVALID]);

    scene.set_instance_transforms(id, &[moved(9.0, 0.0, -3.0)], ALL_TIMES).unwrap();
    assert_eq!(drop_ray(&mut scene, 5.25, 0.25, 1).0, f32::INFINITY);
    assert_eq!(drop_ray(&mut scene, 9.25, 0.25, 1).0, 4.0);

    // A quarter turn about z: the columns are the images of the axes. The normal stays in the object's space.
    let turned = [0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 20.0, 0.0, 0.0];
    scene.set_instance_transforms(id, &[turned], ALL_TIMES).unwrap();
    let (t, ids, [.., normal_z]) = drop_ray(&mut scene, 19.75, 0.25, 1);
    assert_eq!((t, ids, normal_z), (1.0, [0, 0, id.0], 1.0));
}

#[test]
fn an_instance_shows_the_scene_that_it_places_now() {
    let device = scenes::device();
    let child = |z: f32| {
        let mut child = medium(&device);
        child.attach(&mesh(&device, &[UNIT_TRIANGLE.map(|[x, y, _]| [x, y, z])], u32::MAX)).unwrap();
        child.freeze().unwrap()
    };
    let mut scene = medium(&device);
    let first = child(0.0);
    let id = scene.attach_instance(&first, moved(5.0, 0.0, -1.0), 0b010).unwrap();
    assert_eq!(drop_ray(&mut scene, 5.25, 0.25, 0b010).0, 2.0);
    for depth in 1..4 {
        // nobody else holds the one before
        scene.set_instance_scene(id, &child(-depth as f32)).unwrap();
        let (t, ids, _) = drop_ray(&mut scene, 5.25, 0.25, 0b010);
        assert_eq!((t, ids), (2.0 + depth as f32, [0, 0, id.0]), "where it was, with its own mask");
        assert_eq!(drop_ray(&mut scene, 5.25, 0.25, 0b101).0, f32::INFINITY);
    }
    assert_eq!(std::sync::Arc::strong_count(&first), 1, "let go");
}

/// Hundred triangles in a row along x, at these heights.
fn row(heights: impl Fn(usize) -> f32) -> Arc<VertexBuffer> {
    let corners = |at: usize| UNIT_TRIANGLE.map(|[x, y, _]| [x + at as f32, y, heights(at)]);
    Arc::new(VertexBuffer::new((0..100).flat_map(corners).collect()))
}

#[test]
fn vertices_that_move_are_met_where_they_are() {
    let device = scenes::device();
    let rest = row(|_| 0.0);
    let indices = Arc::new((0..100).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect());
    let geometry = Geometry::triangles(&device, Arc::clone(&rest), indices, 1).unwrap();
    for quality in [BuildQuality::Refit, BuildQuality::Low, BuildQuality::Medium, BuildQuality::High] {
        let mut scene = Scene::new(&device, quality, true).unwrap();
        let (first, second) = (scene.attach(&geometry).unwrap(), scene.attach(&geometry).unwrap());
        let met = |scene: &mut Scene, at: usize| drop_ray(scene, at as f32 + 0.25, 0.25, 1).0;
        assert_eq!(met(&mut scene, 7), 1.0);
        for depth in [3.0, 1000.0, 0.0, 0.5] {
            let moved = row(|at| -depth - at as f32);
            for id in [first, second] {
                scene.set_vertices(id, &moved).unwrap();
            }
            drop(moved);
            for at in [0, 7, 42, 99] {
                let (t, wanted) = (met(&mut scene, at), 1.0 + depth + at as f32);
                assert!((t - wanted).abs() <= 1e-6 * wanted, "{quality:?}, {depth}, {at}: {t}");
            }
        }
        // of the geometry, which others may have
        let mut other = Scene::new(&device, quality, true).unwrap();
        other.attach(&geometry).unwrap();
        assert_eq!(met(&mut other, 99), 1.0);
    }
    drop(geometry);
    assert_eq!(Arc::strong_count(&rest), 1, "let go");
}

#[test]
fn vertices_between_two_steps_are_where_a_ray_s_time_says() {
    let device = scenes::device();
    let indices: Arc<Vec<[u32; 3]>> = Arc::new((0..100).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect());
    let (first, second) = (row(|at| -(at as f32)), row(|at| -(at as f32) - 64.0));
    let moving = |times| {
        let ends = [&first, &second].map(Arc::clone);
        Geometry::moving_triangles(&device, ends, times, Arc::clone(&indices), 1)
    };
    for (quality, is_placed) in [BuildQuality::Low, BuildQuality::Medium, BuildQuality::High]
        .into_iter()
        .flat_map(|q| [(q, false), (q, true)])
    {
        // half a step of 16 ahead of the rays
        let geometry = moving([-1.0 / 32.0, 31.0 / 32.0]).unwrap();
        let mut scene = Scene::new(&device, quality, true).unwrap();
        let id = scene.attach(&geometry).unwrap();
        assert_eq!(scene.set_vertices(id, &first).unwrap_err().code(), ErrorCode::InvalidOperation);
        let mut above = Scene::new(&device, BuildQuality::Low, true).unwrap();
        if is_placed {
            above.attach_instance(&scene.freeze().unwrap(), moved(0.0, 0.0, 0.0), 1).unwrap();
            scene = above;
        }
        let scene = scene.commit().unwrap();
        for (tick, at) in (0..16).flat_map(|tick| [(tick, 3), (tick, 98)]) {
            let segment = Segment {
                origin: [at as f32 + 0.25, 0.25, 1.0],
                direction: [0.0, 0.0, -1.0],
                near: 0.0,
                far: f32::INFINITY,
                mask: 1,
                time: tick as f32 / 16.0,
            };
            let hit = scene.intersect_one(&segment, Coherence::Incoherent).unwrap();
            assert_eq!(hit.t, 3.0 + at as f32 + 4.0 * tick as f32, "{quality:?}, {is_placed}, {tick}");
        }
    }
    for times in [[0.5, 0.5], [1.0, 0.0], [0.0, f32::NAN]] {
        assert_eq!(moving(times).unwrap_err().code(), ErrorCode::InvalidArgument);
    }
    let few = Arc::new(VertexBuffer::new(vec![[0.0; 3]; 3]));
    let uneven = Geometry::moving_triangles(&device, [first, few], [0.0, 1.0], indices, 1);
    assert_eq!(uneven.unwrap_err().code(), ErrorCode::InvalidArgument);
}

#[test]
fn a_scene_is_thawed_moved_and_placed_again() {
    let device = scenes::device();
    let indices = Arc::new((0..100).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect());
    let geometry = Geometry::triangles(&device, row(|_| 0.0), indices, 1).unwrap();
    let mut child = Scene::new(&device, BuildQuality::Refit, true).unwrap();
    let mesh = child.attach(&geometry).unwrap();
    let mut child = child.freeze().unwrap();
    let nothing = Scene::new(&device, BuildQuality::Low, true).unwrap().freeze().unwrap();
    let mut scene = Scene::new(&device, BuildQuality::Low, true).unwrap();
    let id = scene.attach_instance(&child, moved(0.0, 5.0, 0.0), 1).unwrap();
    for depth in [2.0, 500.0, 0.0] {
        assert_eq!(Arc::clone(&child).thaw().unwrap_err().code(), ErrorCode::InvalidOperation);
        scene.set_instance_scene(id, &nothing).unwrap();
        let mut open = child.thaw().unwrap();
        open.set_vertices(mesh, &row(|at| -depth - at as f32)).unwrap();
        child = open.freeze().unwrap();
        scene.set_instance_scene(id, &child).unwrap();
        let (t, ids, _) = drop_ray(&mut scene, 42.25, 5.25, 1);
        assert!((t - 43.0 - depth).abs() <= 1e-6 * t, "{depth}: {t}");
        assert_eq!(ids, [42, 0, id.0]);
        assert_eq!(drop_ray(&mut scene, 42.25, 0.25, 1).0, f32::INFINITY);
    }
    scene.set_instance_scene(id, &nothing).unwrap();
    assert_eq!(drop_ray(&mut scene, 42.25, 5.25, 1).0, f32::INFINITY);
}

#[test]
fn ids_that_are_left_out_name_nothing() {
    let device = scenes::device();
    let mut child = medium(&device);
    child.attach(&mesh(&device, &[UNIT_TRIANGLE], 1)).unwrap();
    let child = child.freeze().unwrap();
    let mut scene = medium(&device);
    assert_eq!(scene.attach(&mesh(&device, &[UNIT_TRIANGLE], 1)).unwrap(), GeometryId(0));
    scene.skip_ids_to(GeometryId(7));
    let placed = scene.attach_instance(&child, moved(5.0, 0.0, 0.0), 1).unwrap();
    scene.skip_ids_to(GeometryId(3));
    let next = scene.attach(&mesh(&device, &[UNIT_TRIANGLE.map(|[x, y, z]| [x + 9.0, y, z])], 1)).unwrap();
    assert_eq!((placed, next), (GeometryId(7), GeometryId(8)));
    let mut met = |x: f32| drop_ray(&mut scene, x, 0.25, 1).1;
    assert_eq!([met(0.25), met(5.25), met(9.25)], [[0, 0, INVALID], [0, 0, 7], [0, 8, INVALID]]);
    for id in [1, 6, 9] {
        assert!(scene.set_mask(GeometryId(id), 0).is_err(), "{id}");
    }
}

#[test]
fn masks_hide_meshes_and_instances() {
    let device = scenes::device();
    let mut child = medium(&device);
    child.attach(&mesh(&device, &[UNIT_TRIANGLE], 0b110)).unwrap();
    let child = child.freeze().unwrap();
    let mut scene = medium(&device);
    let plain = scene.attach(&mesh(&device, &[UNIT_TRIANGLE], 0b001)).unwrap();
    let placed = scene.attach_instance(&child, moved(5.0, 0.0, 0.0), 0b010).unwrap();

    let is_hit = |scene: &mut Scene, x, mask| drop_ray(scene, x, 0.25, mask).0.is_finite();
    assert!(is_hit(&mut scene, 0.25, 0b001) && !is_hit(&mut scene, 0.25, 0b110));
    assert!(is_hit(&mut scene, 5.25, 0b010) && !is_hit(&mut scene, 5.25, 0b101));

    scene.set_mask(plain, 0b100).unwrap();
    scene.set_mask(placed, 0b100).unwrap();
    assert!(is_hit(&mut scene, 0.25, 0b100) && !is_hit(&mut scene, 0.25, 0b011));
    assert!(is_hit(&mut scene, 5.25, 0b100) && !is_hit(&mut scene, 5.25, 0b011));
}

#[test]
fn a_mask_changes_in_one_scene_alone() {
    let device = scenes::device();
    let shared = mesh(&device, &[UNIT_TRIANGLE], 0b01);
    let (mut one, mut other) = (medium(&device), medium(&device));
    let id = one.attach(&shared).unwrap();
    other.attach(&shared).unwrap();
    one.set_mask(id, 0b10).unwrap();
    assert!(drop_ray(&mut one, 0.25, 0.25, 0b01).0.is_infinite());
    assert!(drop_ray(&mut other, 0.25, 0.25, 0b01).0.is_finite());
}

fn of_two_coincident_triangles_one_is_closest_and_both_occlude<const N: usize>(device: &Device) {
    let mut scene = medium(device);
    scene.attach(&mesh(device, &[UNIT_TRIANGLE, UNIT_TRIANGLE], 1)).unwrap();
    let (t, ids, _) = drop_ray(&mut scene, 0.25, 0.25, 1);
    // not all instruction sets round alike
    assert!((t - 1.0).abs() < 1e-6 && ids[0] < 2);

    // Excluding one of them leaves the other in the way.
    let tracer = scene.commit().unwrap();
    for own in 0..2 {
        let own = PrimId { geom_id: 0, prim_id: own, inst_id: INVALID };
        let mut rays = down::<N>(|_| [0.25, 0.25, 1.0]);
        tracer.occluded_past(&Valid::ALL, &mut rays, Coherence::Coherent, &|_, met| met == own);
        assert!((0..N).all(|lane| rays.is_occluded(lane)));
    }
}

fn of_equally_near_triangles_the_least_is_hit<const N: usize>(device: &Device) {
    let mut scene = medium(device);
    let both = [0, 1, 2].map(|_| scene.attach(&mesh(device, &[UNIT_TRIANGLE], u32::MAX)).unwrap().0);
    let least = both.into_iter().min().unwrap();
    let tracer = scene.commit().unwrap();
    for lanes in [1, N / 2, N] {
        let mut packet = RayHit::new(down::<N>(|_| [0.25, 0.25, 1.0]));
        tracer.intersect_least(&Valid::first(lanes), &mut packet);
        for lane in 0..N {
            let expected = if lane < lanes { (least, 0) } else { (INVALID, INVALID) };
            let met = (packet.hit.geom_id[lane], packet.hit.prim_id[lane]);
            assert_eq!(met, expected, "lane {lane} of {lanes}");
            // not all instruction sets round alike
            let t = packet.ray.tfar[lane];
            assert!(if lane < lanes { (t - 1.0).abs() < 2e-7 } else { t == f32::INFINITY }, "{t}");
        }
    }
}

fn no_ray_is_occluded_by_its_own_primitive<const N: usize>(device: &Device) {
    let mut scene = medium(device);
    // 16 triangles side by side in one mesh; over the odd ones another mesh hovers.
    let floor: Vec<_> = (0..16).map(|i| UNIT_TRIANGLE.map(|[x, y, z]| [x + i as f32, y, z])).collect();
    let above: Vec<_> = floor.iter().skip(1).step_by(2).map(|t| t.map(|[x, y, z]| [x, y, z + 0.5])).collect();
    scene.attach(&mesh(device, &floor, 1)).unwrap();
    scene.attach(&mesh(device, &above, 1)).unwrap();
    let tracer = scene.commit().unwrap();

    // Lane i looks at triangle 15 - i, so that lane and primitive differ, and past it.
    let start = |lane: usize| [(15 - lane) as f32 + 0.25, 0.25, 1.0];
    let own = |lane: usize| PrimId { geom_id: 0, prim_id: 15 - lane as u32, inst_id: INVALID };
    for coherence in BOTH {
        let mut rays = down::<N>(start);
        tracer.occluded_past(&Valid::ALL, &mut rays, coherence, &|lane, met| met == own(lane));
        for lane in 0..N {
            assert_eq!(rays.is_occluded(lane), (15 - lane) % 2 == 1, "lane {lane}");
        }

        // With nothing excluded, or another's primitive, all are occluded, and lanes that are off are not asked.
        let of_an_instance = |lane, met: PrimId| met == PrimId { inst_id: 0, ..own(lane) };
        for none in [&|_, _| false, &of_an_instance as &dyn Fn(usize, PrimId) -> bool] {
            let mut rays = down::<N>(start);
            tracer.occluded_past(&Valid::first(3), &mut rays, coherence, &none);
            assert!((0..N).all(|lane| rays.is_occluded(lane) == (lane < 3)));
        }
    }
}

fn own_primitives_are_known_by_their_instance<const N: usize>(device: &Device) {
    let mut child = medium(device);
    child.attach(&mesh(device, &[UNIT_TRIANGLE], 1)).unwrap();
    let child = child.freeze().unwrap();
    let mut scene = medium(device);
    scene.attach_instance(&child, IDENTITY, 1).unwrap();
    scene.attach_instance(&child, moved(5.0, 0.0, 0.0), 1).unwrap();
    let tracer = scene.commit().unwrap();
    // Half of the lanes look at each instance, all exclude the second.
    let start = |lane: usize| [if lane < N / 2 { 0.25 } else { 5.25 }, 0.25, 1.0];
    let own = PrimId { geom_id: 0, prim_id: 0, inst_id: 1 };
    for coherence in BOTH {
        let mut rays = down::<N>(start);
        tracer.occluded_past(&Valid::ALL, &mut rays, coherence, &|_, met| met == own);
        assert!((0..N).all(|lane| rays.is_occluded(lane) == (lane < N / 2)));
    }
}

fn an_empty_scene_answers_no<const N: usize>(device: &Device) {
    let mut empty = medium(device);
    let mut no_triangles = medium(device);
    no_triangles.attach(&mesh(device, &[], 1)).unwrap();
    for scene in [&mut empty, &mut no_triangles] {
        let tracer = scene.commit().unwrap();
        assert_eq!(tracer.bounds(), None);
        for coherence in BOTH {
            let mut packet = RayHit::<N>::new(Ray::default());
            let before = packet;
            tracer.intersect(&Valid::ALL, &mut packet, coherence);
            tracer.occluded(&Valid::ALL, &mut packet.ray, coherence);
            tracer.occluded_past(&Valid::ALL, &mut packet.ray, coherence, &|_, _| true);
            assert_eq!((packet.hit, packet.ray.tfar), (before.hit, before.ray.tfar));
        }
    }
}

#[test]
fn bounds_contain_instances() {
    let device = scenes::device();
    let mut child = medium(&device);
    child.attach(&mesh(&device, &[UNIT_TRIANGLE], 1)).unwrap();
    let child = child.freeze().unwrap();
    let unit = Bounds { lower: [0.0; 3], upper: [1.0, 1.0, 0.0] };
    assert_eq!(child.committed().bounds(), Some(unit));
    let mut scene = medium(&device);
    scene.attach_instance(&child, moved(0.0, 0.0, 2.0), 1).unwrap();
    let Bounds { lower, upper } = scene.commit().unwrap().bounds().unwrap();
    // Embree may widen an instance's box by a rounding error.
    let is_near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(is_near(lower, [0.0, 0.0, 2.0]) && is_near(upper, [1.0, 1.0, 2.0]), "{lower:?} {upper:?}");
}

#[test]
fn tracing_leaves_denormals_alone() {
    let device = scenes::device();
    let mut scene = medium(&device);
    scene.attach(&mesh(&device, &[UNIT_TRIANGLE], 1)).unwrap();
    assert_eq!(drop_ray(&mut scene, 0.25, 0.25, 1).0, 1.0);
    let tiny = std::hint::black_box(f32::MIN_POSITIVE);
    assert!(tiny * 0.5 > 0.0, "denormals are flushed to zero");
}
