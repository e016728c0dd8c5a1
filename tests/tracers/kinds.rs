//! Every tracer in every way in which it can be built, and questions to be asked of it.
#![allow(dead_code, reason = "each test binary uses its share")]

use afterimage::animation::Track;
use afterimage::pose::Pose;
use afterimage::scene::{Model, Scene};
use afterimage::settings::Build;
use afterimage::trace::embree::EmbreeBackend;
use afterimage::trace::{
    Backend, BackendKind, Coherence, Hit, HitBatch, Occluders, Purpose, RayBatch, SceneSubset, Search, Tracer,
};
use glam::{DVec3, Vec3};

use crate::toy::{self, matt};

/// What answers, and how it was built.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    Rust,
    Embree(Build),
    /// Within an instruction set that has no packets of sixteen: in halves, or in quarters.
    EmbreeOf(&'static str),
}

pub const KINDS: [Kind; 5] = [
    Kind::Embree(Build::Best),
    Kind::Embree(Build::Quick),
    Kind::EmbreeOf("isa=avx2"),
    Kind::EmbreeOf("isa=sse4.2"),
    Kind::Rust,
];

impl Kind {
    pub fn build(self, scene: &Scene) -> Box<dyn Backend> {
        match self {
            Self::Rust => BackendKind::Rust.build(scene, Build::Best).unwrap(),
            Self::Embree(build) => BackendKind::Embree.build(scene, build).unwrap(),
            Self::EmbreeOf(isa) => Box::new(EmbreeBackend::with_config(scene, Build::Best, isa).unwrap()),
        }
    }

    /// Whether this machine has the instructions.
    fn is_here(self) -> bool {
        match self {
            Self::Rust | Self::Embree(_) => true,
            Self::EmbreeOf(isa) => has_isa(isa),
        }
    }
}

#[cfg(target_arch = "x86_64")]
fn has_isa(isa: &str) -> bool {
    isa != "isa=avx2" || is_x86_feature_detected!("avx2")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_isa(_: &str) -> bool {
    false
}

pub fn kinds() -> impl Iterator<Item = Kind> {
    KINDS.into_iter().filter(|kind| kind.is_here())
}

pub const WAYS: [Coherence; 4] =
    [Coherence::Coherent, Coherence::Bounced, Coherence::SharedOrigin, Coherence::Incoherent];

pub fn scene_of(models: Vec<Model>) -> Scene {
    let camera = toy::camera(Track::constant(DVec3::Z), Track::constant(DVec3::ZERO));
    toy::scene(camera, models, vec![matt(0.5)], vec![])
}

/// Runs `check` on each tracer of `scene` at frame 1; everything that can move has moved.
pub fn on_each(scene: &Scene, check: impl Fn(&dyn Tracer, Coherence)) {
    on_each_moved(scene, &vec![true; scene.models.len()], check);
}

pub fn on_each_moved(scene: &Scene, moved: &[bool], check: impl Fn(&dyn Tracer, Coherence)) {
    let pose = Pose::new(scene, 1);
    for kind in kinds() {
        let mut backend = kind.build(scene);
        let tracer = backend.commit(&pose, moved).unwrap();
        println!("{kind:?}");
        WAYS.into_iter().for_each(|way| check(&*tracer, way));
    }
}

pub fn closest(tracer: &dyn Tracer, way: Coherence, rays: &RayBatch) -> Vec<Option<Hit>> {
    let mut hits = HitBatch::default();
    tracer.closest(rays, Search::from_eye(SceneSubset::All, way), &mut hits);
    (0..rays.len()).map(|ray| hits.get(ray)).collect()
}

pub fn first(tracer: &dyn Tracer, way: Coherence, origin: Vec3, direction: Vec3) -> Option<Hit> {
    let mut rays = RayBatch::default();
    rays.push(origin, direction, 0.0, f32::INFINITY);
    closest(tracer, way, &rays)[0]
}

/// Whether a ray of `far` is blocked.
pub fn blocks(
    tracer: &dyn Tracer,
    way: Coherence,
    by: Occluders,
    purpose: Purpose,
    rays: &RayBatch,
) -> Vec<bool> {
    let mut blocked = vec![0; rays.packet_count()];
    tracer.blocked(rays, by, purpose, way, &mut blocked);
    (0..rays.len()).map(|ray| blocked[ray / 16] >> (ray % 16) & 1 != 0).collect()
}

pub fn down(x: f32, z: f32, far: f32) -> RayBatch {
    let mut rays = RayBatch::default();
    rays.push(Vec3::new(x, 2.0, z), Vec3::NEG_Y, 0.0, far);
    rays
}
