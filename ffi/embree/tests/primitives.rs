//! Primitives that are no triangles, in packets of each width and within each instruction set.
#![allow(clippy::unwrap_used, reason = "tests")]

mod scenes;

use embree::{
    Bounds, BuildQuality, Coherence, Device, Geometry, INVALID, PrimId, PrimitiveHit, Primitives, Ray,
    RayHit, Scene, Segment, Valid,
};
use scenes::moved;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// Slabs: from y = 4 i up to 4 i + 1, where -1 < x, z < 1. A ray along -Y meets the upper side, and then the lower one.
#[derive(Debug)]
struct Slabs(u32);

impl Primitives for Slabs {
    fn count(&self) -> u32 {
        self.0
    }

    fn bounds(&self, primitive: u32) -> Bounds {
        let low = 4.0 * primitive as f32;
        Bounds { lower: [-1.0, low, -1.0], upper: [1.0, low + 1.0, 1.0] }
    }

    fn meet(&self, primitive: u32, ray: &Segment, ends_here: bool) -> Option<PrimitiveHit> {
        let low = 4.0 * primitive as f32;
        let at = |height: f32| (height - ray.origin[1]) / ray.direction[1];
        let mut places = [at(low + 1.0), at(low)];
        if ends_here {
            let nearest = usize::from((places[1] - 1.0).abs() < (places[0] - 1.0).abs());
            places[nearest] = f32::NAN;
        }
        let t = places.into_iter().filter(|t| *t >= ray.near && *t <= ray.far).reduce(f32::min)?;
        let place = |axis: usize| ray.origin[axis] + t * ray.direction[axis];
        let is_inside = place(0).abs() < 1.0 && place(2).abs() < 1.0;
        is_inside.then_some(PrimitiveHit { t, u: place(0), v: place(2) })
    }
}

/// One of each instruction set that this processor has.
fn devices() -> Vec<Device> {
    let configs = ["threads=1", "threads=1,isa=avx2", "threads=1,isa=sse4.2"];
    let has_avx2 = |config: &&str| !config.contains("avx2") || cfg!(target_feature = "avx2");
    configs.into_iter().filter(has_avx2).map(|config| Device::new(config).unwrap()).collect()
}

const BOTH: [Coherence; 2] = [Coherence::Coherent, Coherence::Incoherent];

fn slabs(device: &Device, mask: u32) -> Geometry {
    Geometry::primitives(device, Arc::new(Slabs(2)), mask).unwrap()
}

/// Rays that fall from y = 9, from x = 0 on by a tenth each.
fn falling<const N: usize>(far: f32) -> Ray<N> {
    let mut rays = Ray::default();
    for lane in 0..N {
        rays.set(lane, [lane as f32 * 0.1, 9.0, 0.25], [0.0, -1.0, 0.0], 0.0, far);
    }
    rays
}

fn check<const N: usize>(device: &Device, quality: BuildQuality) {
    let mut scene = Scene::new(device, quality, true).unwrap();
    let id = scene.attach(&slabs(device, 4)).unwrap();
    let mut child = Scene::new(device, quality, true).unwrap();
    child.attach(&slabs(device, 4)).unwrap();
    let instance = scene.attach_instance(&child.freeze().unwrap(), moved(0.0, -20.0, 0.0), 8).unwrap();
    let tracer = scene.commit().unwrap();
    for coherence in BOTH {
        for (mask, met, t) in
            [(4, (1, id.0, INVALID), 4.0), (12, (1, id.0, INVALID), 4.0), (8, (0, 0, 0), f32::INFINITY)]
        {
            let mut packet = RayHit::new(Ray { mask: [mask; N], ..falling::<N>(f32::INFINITY) });
            tracer.intersect(&Valid::ALL, &mut packet, coherence);
            for lane in 0..N {
                let is_met = t < f32::INFINITY && lane < 10;
                assert_eq!(packet.ray.tfar[lane], if is_met { t } else { f32::INFINITY }, "{mask} {lane}");
                let hit = &packet.hit;
                if is_met {
                    assert_eq!((hit.prim_id[lane], hit.geom_id[lane], hit.inst_id[lane]), met);
                    assert_eq!([hit.u[lane], hit.v[lane]], [lane as f32 * 0.1, 0.25]);
                } else {
                    assert_eq!(hit.geom_id[lane], INVALID);
                }
            }
        }
        // from below both, where the instance is alone
        let mut packet = RayHit::new(falling::<N>(f32::INFINITY));
        packet.ray.org_y = [-1.0; N];
        tracer.intersect(&Valid::ALL, &mut packet, coherence);
        assert_eq!((packet.ray.tfar[3], packet.hit.inst_id[3], packet.hit.prim_id[3]), (14.0, instance.0, 1));

        for (far, mask, is_blocked) in [(3.5, 4, false), (4.5, 4, true), (4.5, 8, false), (40.0, 8, false)] {
            let mut rays = Ray { mask: [mask; N], ..falling::<N>(far) };
            tracer.occluded(&Valid::ALL, &mut rays, coherence);
            assert_eq!(rays.tfar[1] == f32::NEG_INFINITY, is_blocked, "{far} {mask}");
            let by_one = |lane: usize| {
                let origin = [lane as f32 * 0.1, 9.0, 0.25];
                let segment =
                    Segment { origin, direction: [0.0, -1.0, 0.0], near: 0.0, far, mask, time: 0.0 };
                tracer.occluded_one(&segment, coherence)
            };
            assert_eq!(by_one(1), is_blocked);
        }
    }
}

/// Checks that a ray ignores the point of its own primitive in which it ends, and no other.
fn check_own<const N: usize>(device: &Device) {
    let mut scene = Scene::new(device, BuildQuality::Medium, true).unwrap();
    let id = scene.attach(&slabs(device, u32::MAX)).unwrap();
    let tracer = scene.commit().unwrap();
    for coherence in BOTH {
        // lanes in turn: to the upper side of slab 1, to its lower side, to the upper side of slab 0
        let ends = [5.0, 4.0, 1.0];
        let mut rays = Ray::<N>::default();
        for lane in 0..N {
            let end = ends[lane % 3];
            rays.set(lane, [0.5, 9.0, 0.5], [0.0, end - 9.0, 0.0], 0.0, 0.999);
        }
        let owns = |lane: usize, met: PrimId| {
            assert_eq!((met.geom_id, met.inst_id), (id.0, INVALID));
            met.prim_id == [1, 1, 0][lane % 3]
        };
        tracer.occluded_past(&Valid::ALL, &mut rays, coherence, &owns);
        for lane in 0..N {
            assert_eq!(rays.tfar[lane] == f32::NEG_INFINITY, lane % 3 != 0, "{lane}");
        }
    }
}

#[test]
fn primitives_are_met_in_each_width() {
    for device in devices() {
        for quality in [BuildQuality::Low, BuildQuality::Medium, BuildQuality::High] {
            check::<4>(&device, quality);
            check::<8>(&device, quality);
            check::<16>(&device, quality);
        }
    }
}

#[test]
fn primitives_may_hide_themselves_in_each_width() {
    for device in devices() {
        check_own::<4>(&device);
        check_own::<8>(&device);
        check_own::<16>(&device);
    }
}

#[test]
fn primitives_live_as_long_as_their_scene() {
    let device = Device::new("threads=1").unwrap();
    let slabs = Arc::new(Slabs(3));
    let mut scene = Scene::new(&device, BuildQuality::Medium, true).unwrap();
    scene.attach(&Geometry::primitives(&device, slabs.clone(), 1).unwrap()).unwrap();
    assert!(Arc::strong_count(&slabs) > 1);
    assert_eq!(scene.commit().unwrap().bounds().unwrap().upper[1], 9.0);
    drop(scene);
    assert_eq!(Arc::strong_count(&slabs), 1);
    assert!(Geometry::primitives(&device, Arc::new(Slabs(u32::MAX)), 1).is_err());
}

/// Primitives that answer in another way each time: what Embree counts in one pass over their boxes, it must have room for in the next.
#[derive(Debug, Default)]
struct Fickle {
    boxes: AtomicU32,
    counts: AtomicU32,
}

impl Primitives for Fickle {
    fn count(&self) -> u32 {
        1000 * (1 + self.counts.fetch_add(1, Ordering::Relaxed))
    }

    fn bounds(&self, primitive: u32) -> Bounds {
        let asked = self.boxes.fetch_add(1, Ordering::Relaxed);
        // all the same for a while, and then none of them
        let upper = if asked % 2500 < 1500 { 1.0 } else { f32::NAN };
        Bounds { lower: [primitive as f32, 0.0, 0.0], upper: [primitive as f32 + upper, upper, upper] }
    }

    fn meet(&self, primitive: u32, ray: &Segment, _: bool) -> Option<PrimitiveHit> {
        Some(PrimitiveHit { t: ray.near, u: primitive as f32, v: 0.0 })
    }
}

#[test]
fn boxes_that_differ_from_time_to_time_are_asked_once() {
    for quality in [BuildQuality::Low, BuildQuality::Medium, BuildQuality::High] {
        let device = Device::new("threads=1").unwrap();
        let fickle = Arc::new(Fickle::default());
        let geometry = Geometry::primitives(&device, fickle.clone(), u32::MAX).unwrap();
        let mut scenes = [0, 1].map(|_| Scene::new(&device, quality, true).unwrap());
        for scene in &mut scenes {
            scene.attach(&geometry).unwrap();
            let bounds = scene.commit().unwrap().bounds();
            assert_eq!(bounds.map(|bounds| bounds.upper[0]), Some(1000.0), "{quality:?}");
        }
        let asked = [&fickle.boxes, &fickle.counts].map(|count| count.load(Ordering::Relaxed));
        assert_eq!(asked, [1000, 1]);
    }
}
