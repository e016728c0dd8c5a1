//! Do tracers that promise it answer a ray in the same way, to the bit, whatever rays are beside it?

use afterimage::animation::{Track, TransformTrack};
use afterimage::pose::Pose;
use afterimage::scene::Scene;
use afterimage::settings::Build;
use afterimage::trace::embree::EmbreeBackend;
use afterimage::trace::{
    Backend, BackendKind, Coherence, Hit, HitBatch, RayBatch, SceneSubset, Search, Tracer,
};
use glam::{DVec3, Vec3};

use crate::toy;
use crate::toy::{matt, mesh, moving, still};

/// Runs `check` on each tracer of `scene` at frame 1, with Embree's packets of each width that there is here.
fn on_each(scene: &Scene, check: impl Fn(&dyn Tracer, Coherence)) {
    let embree = |config| EmbreeBackend::with_config(scene, Build::Best, config).expect("it builds");
    let rust = BackendKind::Rust.build(scene, Build::Best).expect("it builds");
    let mut backends: Vec<Box<dyn Backend>> = vec![rust, Box::new(embree(""))];
    #[cfg(target_arch = "x86_64")]
    {
        backends.push(Box::new(embree("isa=sse4.2")));
        if is_x86_feature_detected!("avx2") {
            backends.push(Box::new(embree("isa=avx2")));
        }
    }
    for backend in &mut backends {
        let tracer =
            backend.commit(&Pose::new(scene, 1), &vec![true; scene.models.len()]).expect("it builds");
        [Coherence::Bounced, Coherence::Incoherent].into_iter().for_each(|way| check(&*tracer, way));
    }
}

fn scene_of(models: Vec<afterimage::scene::Model>) -> Scene {
    let camera = toy::camera(Track::constant(DVec3::Z), Track::constant(DVec3::ZERO));
    toy::scene(camera, models, vec![matt(0.5)], vec![])
}

fn closest(tracer: &dyn Tracer, way: Coherence, rays: &RayBatch) -> Vec<Option<Hit>> {
    let mut hits = HitBatch::default();
    tracer.closest(rays, Search::from_eye(SceneSubset::All, way), &mut hits);
    (0..rays.len()).map(|ray| hits.get(ray)).collect()
}

#[test]
fn what_a_ray_meets_alone_it_meets_among_others() {
    // every triangle is there twice, and many a time in many a place: whoever is looked at first must not matter
    let corner = |i: u32| [i % 9, i / 9].map(|at| at as f32 - 4.0);
    let corners: Vec<[f32; 3]> = (0..81).map(corner).map(|[x, y]| [x, y, 0.0]).collect();
    let squares = (0..72).filter(|i| i % 9 < 8);
    let triangles: Vec<[u32; 3]> = squares.flat_map(|i| [[i, i + 1, i + 10], [i, i + 10, i + 9]]).collect();
    let turned = triangles.iter().map(|[a, b, c]| [*b, *c, *a]);
    let twice: Vec<[u32; 3]> = triangles.iter().copied().chain(turned).collect();
    let sheet = |name| still(name, mesh(&corners, &twice, 0, true), Vec3::ZERO);
    let flyer = moving("flyer", mesh(&corners, &twice, 0, true), TransformTrack::identity());
    let scene = scene_of(vec![sheet("a"), sheet("b"), flyer]);
    // none along a plane of two axes: a box that such a ray only grazes may be looked at for another's sake
    let ray = |i: usize| {
        let at = [i % 31, i / 31].map(|at| at as f32 * 0.25 - 3.75);
        (Vec3::new(at[0], at[1], 3.0), Vec3::new(0.1 * (i % 7) as f32 + 0.01, 0.02, -1.0))
    };
    let rays = |which: &dyn Fn(&usize) -> bool| {
        let mut batch = RayBatch::default();
        let chosen = (0..961).filter(which).map(ray);
        chosen.for_each(|(origin, direction)| batch.push(origin, direction, 0.0, f32::INFINITY));
        batch
    };
    on_each(&scene, |tracer, way| {
        let name =
            |hit: Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.u.to_bits(), hit.model, hit.triangle));
        let all: Vec<_> = closest(tracer, way, &rays(&|_| true)).into_iter().map(name).collect();
        assert!(all.iter().flatten().count() > 800);
        for step in [2, 3, 16, 37] {
            let some = closest(tracer, way, &rays(&|i| i % step == 0)).into_iter().map(name);
            let differ = all.iter().step_by(step).copied().zip(some).filter(|(a, b)| a != b);
            assert_eq!(differ.collect::<Vec<_>>(), [], "{way:?}, every {step}th");
        }
    });
}
