//! Rays with known answers.
#![allow(clippy::unwrap_used, reason = "tests")]

mod scenes;

use embree::{Bounds, Coherence, INVALID, LANES, OwnPrims16, Ray16, RayHit16, Scene, Valid16};
use scenes::{IDENTITY, UNIT_TRIANGLE, down, medium, mesh, moved};

const BOTH: [Coherence; 2] = [Coherence::Coherent, Coherence::Incoherent];

/// Traces 16 times the ray that falls from (x, y, 1) and returns lane 3.
fn drop_ray(scene: &mut Scene, x: f32, y: f32, mask: u32) -> (f32, [u32; 3], [f32; 5]) {
    let mut rays = down(|_| [x, y, 1.0]);
    rays.mask = [mask; LANES];
    let mut packet = RayHit16::new(rays);
    scene
        .commit()
        .unwrap()
        .intersect16(&Valid16::ALL, &mut packet, Coherence::Incoherent);
    let hit = &packet.hit;
    (
        packet.ray.tfar[3],
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

#[test]
fn lanes_that_are_off_are_left_alone() {
    let device = scenes::device();
    let mut scene = medium(&device);
    scene.attach(&mesh(&device, &[UNIT_TRIANGLE], 1)).unwrap();
    let tracer = scene.commit().unwrap();
    let valid = Valid16::from_bits(0b0000_0000_1010_0101);
    for coherence in BOTH {
        let mut packet = RayHit16::new(down(|_| [0.25, 0.25, 1.0]));
        let mut shadow = packet.ray;
        tracer.intersect16(&valid, &mut packet, coherence);
        tracer.occluded16(&valid, &mut shadow, coherence);
        for lane in 0..LANES {
            assert_eq!(packet.hit.is_hit(lane), valid.is_on(lane), "lane {lane}");
            assert_eq!(shadow.is_occluded(lane), valid.is_on(lane), "lane {lane}");
        }
    }
}

#[test]
fn an_instance_stands_where_its_transform_puts_it() {
    let device = scenes::device();
    let mut child = medium(&device);
    child
        .attach(&mesh(&device, &[UNIT_TRIANGLE], u32::MAX))
        .unwrap();
    let child = child.freeze().unwrap();
    let mut scene = medium(&device);
    scene
        .attach(&mesh(&device, &[UNIT_TRIANGLE], u32::MAX))
        .unwrap();
    let id = scene
        .attach_instance(&child, moved(5.0, 0.0, -1.0), u32::MAX)
        .unwrap();
    assert_eq!(id.0, 1);

    assert_eq!(drop_ray(&mut scene, 5.25, 0.25, 1).0, 2.0);
    assert_eq!(drop_ray(&mut scene, 5.25, 0.25, 1).1, [0, 0, id.0]);
    assert_eq!(drop_ray(&mut scene, 0.25, 0.25, 1).1, [0, 0, INVALID]);

    scene
        .set_instance_transform(id, moved(9.0, 0.0, -3.0))
        .unwrap();
    assert_eq!(drop_ray(&mut scene, 5.25, 0.25, 1).0, f32::INFINITY);
    assert_eq!(drop_ray(&mut scene, 9.25, 0.25, 1).0, 4.0);

    // A quarter turn about z: the columns are the images of the axes. The normal stays in the object's space.
    let turned = [0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 20.0, 0.0, 0.0];
    scene.set_instance_transform(id, turned).unwrap();
    let (t, ids, [.., normal_z]) = drop_ray(&mut scene, 19.75, 0.25, 1);
    assert_eq!((t, ids, normal_z), (1.0, [0, 0, id.0], 1.0));
}

#[test]
fn masks_hide_meshes_and_instances() {
    let device = scenes::device();
    let mut child = medium(&device);
    child
        .attach(&mesh(&device, &[UNIT_TRIANGLE], 0b110))
        .unwrap();
    let child = child.freeze().unwrap();
    let mut scene = medium(&device);
    let plain = scene
        .attach(&mesh(&device, &[UNIT_TRIANGLE], 0b001))
        .unwrap();
    let placed = scene
        .attach_instance(&child, moved(5.0, 0.0, 0.0), 0b010)
        .unwrap();

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

#[test]
fn of_two_coincident_triangles_one_is_closest_and_both_occlude() {
    let device = scenes::device();
    let mut scene = medium(&device);
    scene
        .attach(&mesh(&device, &[UNIT_TRIANGLE, UNIT_TRIANGLE], 1))
        .unwrap();
    let (t, ids, _) = drop_ray(&mut scene, 0.25, 0.25, 1);
    assert!(t == 1.0 && ids[0] < 2);

    // Excluding one of them leaves the other in the way.
    let tracer = scene.commit().unwrap();
    for own in 0..2 {
        let own = OwnPrims16 {
            geom_id: [0; LANES],
            prim_id: [own; LANES],
            ..Default::default()
        };
        let mut rays = down(|_| [0.25, 0.25, 1.0]);
        tracer.occluded16_past_own(&Valid16::ALL, &mut rays, &own, Coherence::Coherent);
        assert!((0..LANES).all(|lane| rays.is_occluded(lane)));
    }
}

#[test]
fn no_ray_is_occluded_by_its_own_primitive() {
    let device = scenes::device();
    let mut scene = medium(&device);
    // 16 triangles side by side in one mesh; over the odd ones another mesh hovers.
    let floor: Vec<_> = (0..16)
        .map(|i| UNIT_TRIANGLE.map(|[x, y, z]| [x + i as f32, y, z]))
        .collect();
    let above: Vec<_> = floor
        .iter()
        .skip(1)
        .step_by(2)
        .map(|t| t.map(|[x, y, z]| [x, y, z + 0.5]))
        .collect();
    scene.attach(&mesh(&device, &floor, 1)).unwrap();
    scene.attach(&mesh(&device, &above, 1)).unwrap();
    let tracer = scene.commit().unwrap();

    // Lane i looks at triangle 15 - i, so that lane and primitive differ, and past it.
    let start = |lane: usize| [(15 - lane) as f32 + 0.25, 0.25, 1.0];
    let own = OwnPrims16 {
        geom_id: [0; LANES],
        prim_id: std::array::from_fn(|lane| 15 - lane as u32),
        inst_id: [INVALID; LANES],
    };
    for coherence in BOTH {
        let mut rays = down(start);
        tracer.occluded16_past_own(&Valid16::ALL, &mut rays, &own, coherence);
        for lane in 0..LANES {
            assert_eq!(rays.is_occluded(lane), (15 - lane) % 2 == 1, "lane {lane}");
        }

        // With nothing excluded, or another's primitive, all are occluded, and lanes that are off are not asked.
        for none in [
            OwnPrims16::default(),
            OwnPrims16 {
                inst_id: [0; LANES],
                ..own
            },
        ] {
            let mut rays = down(start);
            tracer.occluded16_past_own(&Valid16::first(5), &mut rays, &none, coherence);
            assert!((0..LANES).all(|lane| rays.is_occluded(lane) == (lane < 5)));
        }
    }
}

#[test]
fn own_primitives_are_known_by_their_instance() {
    let device = scenes::device();
    let mut child = medium(&device);
    child.attach(&mesh(&device, &[UNIT_TRIANGLE], 1)).unwrap();
    let child = child.freeze().unwrap();
    let mut scene = medium(&device);
    scene.attach_instance(&child, IDENTITY, 1).unwrap();
    scene
        .attach_instance(&child, moved(5.0, 0.0, 0.0), 1)
        .unwrap();
    let tracer = scene.commit().unwrap();
    // Half of the lanes look at each instance, all exclude the second.
    let start = |lane: usize| [if lane < 8 { 0.25 } else { 5.25 }, 0.25, 1.0];
    let own = OwnPrims16 {
        geom_id: [0; LANES],
        prim_id: [0; LANES],
        inst_id: [1; LANES],
    };
    for coherence in BOTH {
        let mut rays = down(start);
        tracer.occluded16_past_own(&Valid16::ALL, &mut rays, &own, coherence);
        assert!((0..LANES).all(|lane| rays.is_occluded(lane) == (lane < 8)));
    }
}

#[test]
fn an_empty_scene_answers_no() {
    let device = scenes::device();
    let mut empty = medium(&device);
    let mut no_triangles = medium(&device);
    no_triangles.attach(&mesh(&device, &[], 1)).unwrap();
    for scene in [&mut empty, &mut no_triangles] {
        let tracer = scene.commit().unwrap();
        assert_eq!(tracer.bounds(), None);
        for coherence in BOTH {
            let mut packet = RayHit16::new(Ray16::default());
            let before = packet;
            tracer.intersect16(&Valid16::ALL, &mut packet, coherence);
            tracer.occluded16(&Valid16::ALL, &mut packet.ray, coherence);
            let own = OwnPrims16::default();
            tracer.occluded16_past_own(&Valid16::ALL, &mut packet.ray, &own, coherence);
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
    let unit = Bounds {
        lower: [0.0; 3],
        upper: [1.0, 1.0, 0.0],
    };
    assert_eq!(child.committed().bounds(), Some(unit));
    let mut scene = medium(&device);
    scene
        .attach_instance(&child, moved(0.0, 0.0, 2.0), 1)
        .unwrap();
    let Bounds { lower, upper } = scene.commit().unwrap().bounds().unwrap();
    // Embree may widen an instance's box by a rounding error.
    let is_near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(
        is_near(lower, [0.0, 0.0, 2.0]) && is_near(upper, [1.0, 1.0, 2.0]),
        "{lower:?} {upper:?}"
    );
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
