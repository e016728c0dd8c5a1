//! Who keeps what alive, what is an error, and many threads.
#![allow(clippy::unwrap_used, reason = "tests")]

mod scenes;

use embree::{
    ALL_TIMES, BuildQuality, Coherence, Committed, Device, ErrorCode, FrozenScene, Geometry, GeometryId,
    PacketWidth, RayHit, Scene, Valid, VertexBuffer,
};
use scenes::{IDENTITY, UNIT_TRIANGLE, device, down, medium, mesh, moved};
use std::sync::Arc;

fn hits(tracer: Committed<'_>) -> usize {
    let mut packet = RayHit::<16>::new(down(|lane| [0.01 * lane as f32, 0.01, 1.0]));
    tracer.intersect(&Valid::ALL, &mut packet, Coherence::Coherent);
    (0..16).filter(|&lane| packet.hit.is_hit(lane)).count()
}

#[test]
fn the_version_is_at_least_4_3() {
    let version = device().version();
    let numbers: Vec<u32> = version.split('.').map(|n| n.parse().unwrap()).collect();
    assert!(numbers.len() == 3 && numbers >= vec![4, 3, 0], "{version}");
}

#[test]
fn a_wrong_configuration_is_refused_in_embrees_words() {
    let error = Device::new("threads=abc").unwrap_err();
    assert!(error.message().contains("integer expected"), "{error}");
    assert_eq!(error.to_string(), format!("Embree: {}", error.message()));
    assert_eq!(Device::new("a\0b").unwrap_err().code(), ErrorCode::InvalidArgument);
    // The failure is taken, not left for the next call.
    assert!(Device::new("threads=1").is_ok());
}

#[test]
#[cfg(target_arch = "x86_64")]
fn the_native_width_is_that_of_the_instruction_set() {
    let width = |config| Device::new(config).unwrap().native_width();
    assert_eq!(width("threads=1,isa=sse4.2"), PacketWidth::Four);
    if is_x86_feature_detected!("avx2") {
        assert_eq!(width("threads=1,isa=avx2"), PacketWidth::Eight);
    }
    let is_wide = is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512cd")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512vl");
    // an Embree may have been built without AVX-512, but never needs it
    assert!(is_wide || width("threads=1") < PacketWidth::Sixteen);
}

#[test]
fn an_index_out_of_range_is_an_error() {
    let vertices = Arc::new(VertexBuffer::new(UNIT_TRIANGLE.to_vec()));
    let indices = Arc::new(vec![[0, 1, 2], [0, 3, 1]]);
    let error = Geometry::triangles(&device(), Arc::clone(&vertices), indices, 1).unwrap_err();
    assert_eq!(error.code(), ErrorCode::InvalidArgument);
    assert!(error.message().contains("triangle 1"), "{error}");
    assert_eq!(vertices.as_slice(), UNIT_TRIANGLE);
}

#[test]
fn misuse_of_a_scene_is_an_error() {
    let device = device();
    let mut scene = medium(&device);
    let plain = scene.attach(&mesh(&device, &[UNIT_TRIANGLE], 1)).unwrap();
    let child = medium(&device).freeze().unwrap();
    let placed = scene.attach_instance(&child, IDENTITY, 1).unwrap();
    let mut code =
        |act: &dyn Fn(&mut Scene) -> Result<(), embree::Error>| act(&mut scene).unwrap_err().code();

    let nan = moved(f32::NAN, 0.0, 0.0);
    assert_eq!(code(&|s| s.set_instance_transforms(placed, &[nan], ALL_TIMES)), ErrorCode::InvalidArgument);
    assert_eq!(code(&|s| s.attach_instance(&child, nan, 1).map(drop)), ErrorCode::InvalidArgument);
    assert_eq!(
        code(&|s| s.set_instance_transforms(plain, &[IDENTITY], ALL_TIMES)),
        ErrorCode::InvalidOperation
    );
    assert_eq!(code(&|s| s.set_mask(GeometryId(2), 1)), ErrorCode::InvalidArgument);
    let few = Arc::new(VertexBuffer::new(UNIT_TRIANGLE[..2].to_vec()));
    assert_eq!(code(&|s| s.set_vertices(plain, &few)), ErrorCode::InvalidArgument);
    assert_eq!(code(&|s| s.set_vertices(placed, &few)), ErrorCode::InvalidOperation);
    assert_eq!(code(&|s| s.set_vertices(GeometryId(2), &few)), ErrorCode::InvalidArgument);
    assert_eq!(code(&|s| s.set_instance_scene(plain, &child)), ErrorCode::InvalidOperation);
    assert_eq!(code(&|s| s.set_instance_scene(GeometryId(2), &child)), ErrorCode::InvalidArgument);
    let foreign = scenes::device();
    let strange = mesh(&foreign, &[UNIT_TRIANGLE], 1);
    assert_eq!(code(&|s| s.attach(&strange).map(drop)), ErrorCode::InvalidArgument);
    let elsewhere = medium(&foreign).freeze().unwrap();
    assert_eq!(code(&|s| s.set_instance_scene(placed, &elsewhere)), ErrorCode::InvalidArgument);

    // One level of instances: what holds one cannot be one.
    let nested = scene.freeze().unwrap();
    let error = medium(&device).attach_instance(&nested, IDENTITY, 1).unwrap_err();
    assert_eq!(error.code(), ErrorCode::InvalidOperation);
    let mut other = medium(&device);
    let placed = other.attach_instance(&child, IDENTITY, 1).unwrap();
    assert_eq!(other.set_instance_scene(placed, &nested).unwrap_err().code(), ErrorCode::InvalidOperation);
}

#[test]
fn a_scene_outlives_whatever_it_was_made_from() {
    let vertices = Arc::new(VertexBuffer::new(UNIT_TRIANGLE.to_vec()));
    let mut scene = {
        let device = device();
        let indices = Arc::new(vec![[0, 1, 2]]);
        let geometry = Geometry::triangles(&device, Arc::clone(&vertices), indices, 1).unwrap();
        let mut child = medium(&device);
        child.attach(&geometry).unwrap();
        let mut scene = medium(&device);
        scene.attach_instance(&child.freeze().unwrap(), IDENTITY, 1).unwrap();
        scene
    };
    assert_eq!(Arc::strong_count(&vertices), 2, "shared, not copied");
    assert_eq!(hits(scene.commit().unwrap()), 16);
    drop(scene);
    assert_eq!(Arc::strong_count(&vertices), 1, "let go");
}

#[test]
fn memory_is_counted_and_given_back() {
    let device = device();
    let many: Vec<_> = (0..10_000).map(|i| UNIT_TRIANGLE.map(|[x, y, z]| [x + i as f32, y, z])).collect();
    let mut scene = medium(&device);
    scene.attach(&mesh(&device, &many, 1)).unwrap();
    scene.commit().unwrap();
    assert!(device.memory_bytes() > 100_000, "{}", device.memory_bytes());
    drop(scene);
    assert!(device.memory_bytes() < 10_000, "{}", device.memory_bytes());
}

#[test]
fn a_scene_grows_after_it_was_traced() {
    let device = device();
    for quality in [BuildQuality::Low, BuildQuality::Medium, BuildQuality::High] {
        for robust in [false, true] {
            let mut scene = Scene::new(&device, quality, robust).unwrap();
            assert_eq!(hits(scene.commit().unwrap()), 0);
            scene.attach(&mesh(&device, &[UNIT_TRIANGLE], 1)).unwrap();
            assert_eq!(hits(scene.commit().unwrap()), 16);
            assert_eq!(hits(scene.commit().unwrap()), 16);
        }
    }
}

#[test]
fn threads_build_and_trace_at_the_same_time() {
    let device = device();
    let shared = mesh(&device, &[UNIT_TRIANGLE], 1);
    let child: Arc<FrozenScene> = {
        let mut child = medium(&device);
        child.attach(&shared).unwrap();
        child.freeze().unwrap()
    };
    std::thread::scope(|threads| {
        for _ in 0..8 {
            threads.spawn(|| {
                for i in 0..50 {
                    let mut scene = medium(&device);
                    scene.attach(&shared).unwrap();
                    let id = scene.attach_instance(&child, moved(3.0, 0.0, 0.0), 1).unwrap();
                    assert_eq!(hits(scene.commit().unwrap()), 16);
                    scene.set_instance_transforms(id, &[moved(i as f32, 0.0, 0.0)], ALL_TIMES).unwrap();
                    let tracer = scene.commit().unwrap();
                    std::thread::scope(|more| {
                        more.spawn(move || assert_eq!(hits(tracer), 16));
                        assert_eq!(hits(child.committed()), 16);
                    });
                }
            });
        }
    });
}

#[test]
fn errors_are_each_threads_own() {
    std::thread::scope(|threads| {
        for i in 0..8 {
            threads.spawn(move || {
                for _ in 0..20 {
                    let config = if i % 2 == 0 { "threads=abc" } else { "threads=1" };
                    assert_eq!(Device::new(config).is_err(), i % 2 == 0);
                }
            });
        }
    });
}
