//! Queries of the frame loop to a scene, and the ray tracers that answer them.
//!
//! A [`Tracer`] answers two: the first hit of a ray ([`closest`](Tracer::closest)), and if anything is in its
//! way ([`blocked`](Tracer::blocked)). Both take whole [batches](RayBatch) of 16-wide packets, so that a call
//! costs nothing beside its rays. Models that stand still for the whole shot are apart from those that move:
//! the paper's rules (see [`frame::plan`](crate::frame::shot::plan)) often test against one of the two only.
//!
//! A [`Backend`] owns the acceleration structures. [`commit`](Backend::commit) borrows it mutably for as long
//! as its tracer lives: the compiler keeps changes and tracing apart.

mod batch;
pub mod clipped;
pub mod embree;
pub mod rust;
pub mod timed;

pub use batch::{Coherence, Hit, HitBatch, HitPacket, LANES, NO_HIT, RayBatch, RayPacket};

use crate::pose::Pose;
use crate::scene::{BlockerSet, Mesh, RayKind, Scene};
use crate::settings::{Build, Caustics};

/// Models that may block a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Occluders {
    /// Models that never move in the shot.
    Still,
    /// Models that move in some frame of the shot, at their place in this one.
    Movable,
    /// Movable models that moved since the frame before, at their new place.
    Moved,
}

/// Models among which the first hit is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SceneSubset {
    /// All models.
    All,
    /// Models that never move in the shot: enough for rays that can meet no other.
    Still,
}

/// Kinds of the rays of a batch.
#[derive(Debug, Clone, Copy)]
pub enum OfKind<'a> {
    /// All rays are of one kind.
    All(RayKind),
    /// Kind of each ray, in their order.
    Each(&'a [RayKind]),
}

impl<'a> OfKind<'a> {
    /// Kinds of rays that go on from surfaces, of which `each` has its own; an empty list stands for a scene that hides
    /// nothing from any, where it makes no difference what they come from, as long as it is not the eye.
    pub fn of(each: &'a [RayKind]) -> Self {
        if each.is_empty() { Self::All(RayKind::Diffuse) } else { Self::Each(each) }
    }
}

/// Search for the first hits of a batch of rays.
#[derive(Debug, Clone, Copy)]
pub struct Search<'a> {
    /// Kinds of the rays, which meet what they see.
    pub kinds: OfKind<'a>,
    /// Models that they may meet.
    pub among: SceneSubset,
    /// What the rays have in common.
    pub coherence: Coherence,
}

impl Search<'_> {
    /// Search of rays from the eye.
    pub fn from_eye(among: SceneSubset, coherence: Coherence) -> Self {
        Self { kinds: OfKind::All(RayKind::Camera), among, coherence }
    }
}

/// Purpose of a segment, which decides what blocks it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Purpose {
    /// Segment from the eye to a sample, of the kind [`RayKind::Camera`]. Everything that such rays see blocks, but the
    /// sample's own primitive: its triangle, or that place of a curved primitive.
    Sight,
    /// Segment from a sample to a light, of the kind [`RayKind::Shadow`]. Surfaces that cast shadows block (see
    /// [`Material::casts_shadow`](crate::scene::Material::casts_shadow)); under [`Caustics::Paths`] all do.
    #[default]
    Shadow,
    /// As `Shadow`, of a light in which the models of one set alone cast shadows.
    LinkedShadow(BlockerSet),
}

impl Purpose {
    /// Segments to a light in which the models of `set` cast shadows.
    pub fn shadow_of(set: BlockerSet) -> Self {
        if set == BlockerSet::ALL { Self::Shadow } else { Self::LinkedShadow(set) }
    }

    /// Returns true for segments to lights.
    pub fn is_shadow(self) -> bool {
        self != Self::Sight
    }

    /// Models that may block the segments.
    pub fn blockers(self) -> BlockerSet {
        match self {
            Self::Sight | Self::Shadow => BlockerSet::ALL,
            Self::LinkedShadow(set) => set,
        }
    }

    /// Kind of the segments.
    pub fn kind(self) -> RayKind {
        if self.is_shadow() { RayKind::Shadow } else { RayKind::Camera }
    }
}

/// Ray tracer for the scene as it was committed.
pub trait Tracer: Sync {
    /// Finds the first hit of each ray of `rays`.
    fn closest(&self, rays: &RayBatch, search: Search, hits: &mut HitBatch);

    /// Sets the bit of each ray of `rays` that models of the kind `by` block; rays whose bit is set already
    /// are not traced. `blocked` has one word a packet.
    fn blocked(
        &self,
        rays: &RayBatch,
        by: Occluders,
        purpose: Purpose,
        coherence: Coherence,
        blocked: &mut [u16],
    );
}

/// Acceleration structures of a shot.
pub trait Backend: Send {
    /// Moves the models to their place in `pose` (`moved`: those that are not where they were in the frame
    /// before) and opens the scene for rays.
    fn commit<'a>(&'a mut self, pose: &Pose, moved: &[bool]) -> Result<Box<dyn Tracer + 'a>, TraceError>;
}

/// Largest number of triangles that cast shadows for each clear one where clear ones count as many. The
/// additional trees are then at most so many times as large as the clear triangles that they keep from shadow
/// rays.
const MOST_CASTERS_FOR_A_CLEAR_ONE: usize = 8;

/// Returns true if so many triangles are clear that a tracer should keep those that cast shadows a second
/// time, in trees of their own. No clear triangle ends a shadow ray: the ray would test all clear triangles
/// that it passes.
///
/// Other queries use trees of all triangles. With two trees, one searched after the other, nearest hits took
/// up to a fifth longer where there is little glass, and Embree returned another one of two triangles that
/// share an edge.
fn has_many_clear(scene: &Scene, caustics: Caustics) -> bool {
    let count = |of: fn(&Mesh) -> usize| scene.models.iter().map(|model| of(&model.mesh)).sum::<usize>();
    let casters = count(|mesh| mesh.shadow_casting);
    let clear = count(Mesh::count) - casters;
    caustics == Caustics::None && clear > 0 && clear * MOST_CASTERS_FOR_A_CLEAR_ONE >= casters
}

/// Largest number of triangles of `scene` that tracers hold twice.
pub fn held_twice(scene: &Scene, caustics: Caustics) -> u64 {
    let casters = || scene.built().map(|mesh| mesh.shadow_casting as u64).sum();
    if has_many_clear(scene, caustics) { casters() } else { 0 }
}

/// Kinds of ray tracers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BackendKind {
    /// [`embree::EmbreeBackend`]
    #[default]
    Embree,
    /// [`rust::RustBackend`]
    Rust,
}

impl BackendKind {
    /// Name of the tracer in statistics and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Embree => "embree",
            Self::Rust => "rust",
        }
    }

    /// Builds the acceleration structures for `scene`; only Embree has different ways to `build` them.
    pub fn build(self, scene: &Scene, build: Build) -> Result<Box<dyn Backend>, TraceError> {
        self.build_for(scene, build, Caustics::None)
    }

    /// Builds the acceleration structures, where clear glass blocks shadow rays or lets them pass by
    /// `caustics`.
    pub fn build_for(
        self,
        scene: &Scene,
        build: Build,
        caustics: Caustics,
    ) -> Result<Box<dyn Backend>, TraceError> {
        Ok(match self {
            Self::Embree => Box::new(embree::EmbreeBackend::of(scene, build, caustics)?),
            Self::Rust => Box::new(rust::RustBackend::of(scene, caustics)),
        })
    }
}

/// Failure of a backend, in its own words.
#[derive(Debug, Clone)]
pub struct TraceError(pub String);

impl std::fmt::Display for TraceError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the ray tracing kernel failed: {}", self.0)
    }
}

impl std::error::Error for TraceError {}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use crate::animation::{Track, TransformTrack};
    use crate::scene::{self, Model};

    /// Loads a scene of the repository and makes `clear` of its triangles clear.
    fn with_clear(clear: usize) -> Scene {
        let mut scene = scene::load(Path::new("scenes/city/city.toml"), false).expect("it is shipped").scene;
        for model in &mut scene.models {
            let mesh = Mesh::clone(&model.mesh);
            model.mesh = Arc::new(Mesh { shadow_casting: mesh.count(), ..mesh });
        }
        let mesh = Mesh::clone(&scene.models[0].mesh);
        scene.models[0].mesh = Arc::new(Mesh { shadow_casting: mesh.count() - clear, ..mesh });
        scene
    }

    #[test]
    fn shadow_rays_are_spared_many_clear_triangles() {
        let all: usize = with_clear(0).models.iter().map(|model| model.mesh.count()).sum();
        let enough = all.div_ceil(MOST_CASTERS_FOR_A_CLEAR_ONE + 1);
        for (clear, many) in [(0, false), (1, false), (enough - 1, false), (enough, true)] {
            assert_eq!(has_many_clear(&with_clear(clear), Caustics::None), many, "{clear} of {all}");
        }
        let glass = with_clear(enough);
        assert!(embree::EmbreeBackend::new(&glass, Build::Best).expect("it builds").keeps_casters_apart());
        assert!(rust::RustBackend::new(&glass).keeps_casters_apart());
        assert!(!has_many_clear(&glass, Caustics::Paths), "nothing is clear to them then");
    }

    #[test]
    fn copies_that_share_a_mesh_are_held_twice_once() {
        let all: usize = with_clear(0).models.iter().map(|model| model.mesh.count()).sum();
        let mut scene = with_clear(all / 2);
        assert!(has_many_clear(&scene, Caustics::None), "or nothing is held twice");
        let moving = scene.models.iter().find(|model| !model.track.is_constant()).expect("some move").clone();
        let at = |x: f64| TransformTrack {
            translate: Track::constant(DVec3::X * x),
            ..TransformTrack::identity()
        };
        let resting = Model { track: at(1.0), ..moving.clone() };
        let (before, built) = (held_twice(&scene, Caustics::None), scene.built().count());
        scene.models.extend(vec![moving.clone(); 5]);
        scene.models.extend(vec![resting; 5]);
        assert!(before > 0 && held_twice(&scene, Caustics::None) == before);
        assert_eq!(scene.built().count(), built);
        // at its place in the file it has triangles of its own
        scene.models.push(Model { track: at(0.0), ..moving });
        assert_eq!(scene.built().count(), built + 1);
        assert_eq!(held_twice(&scene, Caustics::Paths), 0);
    }
}
