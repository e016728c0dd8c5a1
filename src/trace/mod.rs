//! The questions that the frame loop asks of a scene, and who answers them.
//!
//! A [`Tracer`] answers two: what does a ray meet first ([`closest`](Tracer::closest)), and is anything
//! in its way ([`blocked`](Tracer::blocked))? Both take whole [batches](RayBatch) of 16-wide packets, so
//! that a call costs nothing beside its rays. What stands still for the whole shot is apart from what
//! moves: the paper's rules (see [`frame::plan`](crate::frame::shot::plan)) often ask about one of the two only.
//!
//! A [`Backend`] owns the acceleration structures. [`commit`](Backend::commit) borrows it mutably for as
//! long as its tracer lives: the compiler keeps change and trace apart.

mod batch;
pub mod embree;
pub mod rust;
pub mod timed;

pub use batch::{Coherence, Hit, HitBatch, HitPacket, LANES, NO_HIT, RayBatch, RayPacket};

use crate::pose::Pose;
use crate::scene::{Mesh, Scene};
use crate::settings::{Build, Caustics};

/// What may be in a ray's way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Occluders {
    /// Models that never move in the shot.
    Still,
    /// Models that move in some frame of the shot, at their place in this one.
    Movable,
    /// Those of the movable ones that moved since the frame before, at their new place.
    Moved,
}

/// Where the first hit is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SceneSubset {
    /// All models.
    All,
    /// Models that never move in the shot: enough for rays that can meet no other.
    Still,
}

/// What a segment is for: it decides what blocks it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// From the eye to a sample. Everything blocks but the sample's own primitive: its triangle, or that place of a
    /// quadric's piece.
    Sight,
    /// From a sample to a light. What casts a shadow blocks (see
    /// [`Material::casts_shadow`](crate::scene::Material::casts_shadow)); under [`Caustics::Paths`] everything.
    Shadow,
}

/// Answers rays about the scene as it was committed.
pub trait Tracer: Sync {
    /// For each ray of `rays` the first hit `among` the models.
    fn closest(&self, rays: &RayBatch, among: SceneSubset, coherence: Coherence, hits: &mut HitBatch);

    /// Sets the bit of each ray of `rays` that `by` blocks; rays whose bit is set are not asked again.
    /// `blocked` has one word a packet.
    fn blocked(
        &self,
        rays: &RayBatch,
        by: Occluders,
        purpose: Purpose,
        coherence: Coherence,
        blocked: &mut [u16],
    );
}

/// Owns what a tracer searches.
pub trait Backend: Send {
    /// Moves the models to their place in `pose` (`moved`: those that are not where they were in the
    /// frame before) and opens the scene for rays.
    fn commit<'a>(&'a mut self, pose: &Pose, moved: &[bool]) -> Result<Box<dyn Tracer + 'a>, TraceError>;
}

/// For so many triangles that cast shadows there is at least one clear one where these are many: trees of what
/// casts shadows are no more than so many times as large as the clear triangles that they spare shadow rays.
const MOST_CASTERS_FOR_A_CLEAR_ONE: usize = 8;

/// Whether so many triangles are clear that a tracer should keep those that cast shadows a second time, in trees
/// of their own. No clear triangle ends a shadow ray: it would test all that it passes.
///
/// The other questions keep trees of all triangles. Asked of two, one after the other, nearest hits took up to a
/// fifth longer where there is little glass, and Embree answered with another one of two triangles that share
/// an edge.
fn has_many_clear(scene: &Scene, caustics: Caustics) -> bool {
    let count = |of: fn(&Mesh) -> usize| scene.models.iter().map(|model| of(&model.mesh)).sum::<usize>();
    let casters = count(|mesh| mesh.shadow_casting);
    let clear = count(|mesh| mesh.triangles.len()) - casters;
    caustics == Caustics::None && clear > 0 && clear * MOST_CASTERS_FOR_A_CLEAR_ONE >= casters
}

/// How many triangles of `scene` tracers hold twice, at most.
pub fn held_twice(scene: &Scene, caustics: Caustics) -> u64 {
    let casters = || scene.built().map(|mesh| mesh.shadow_casting as u64).sum();
    if has_many_clear(scene, caustics) { casters() } else { 0 }
}

/// The tracers that there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BackendKind {
    /// [`embree::EmbreeBackend`]
    #[default]
    Embree,
    /// [`rust::RustBackend`]
    Rust,
}

impl BackendKind {
    /// As statistics and files name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Embree => "embree",
            Self::Rust => "rust",
        }
    }

    /// Builds the acceleration structures for `scene`; only Embree has a choice.
    pub fn build(self, scene: &Scene, build: Build) -> Result<Box<dyn Backend>, TraceError> {
        self.build_for(scene, build, Caustics::None)
    }

    /// The same, where clear glass blocks shadow rays or lets them pass.
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

/// A backend that failed, in its own words.
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

    /// A scene of the repository, of which so many triangles are clear.
    fn with_clear(clear: usize) -> Scene {
        let mut scene = scene::load(Path::new("scenes/city/city.toml"), false).expect("it is shipped").scene;
        for model in &mut scene.models {
            let mesh = Mesh::clone(&model.mesh);
            model.mesh = Arc::new(Mesh { shadow_casting: mesh.triangles.len(), ..mesh });
        }
        let mesh = Mesh::clone(&scene.models[0].mesh);
        scene.models[0].mesh = Arc::new(Mesh { shadow_casting: mesh.triangles.len() - clear, ..mesh });
        scene
    }

    #[test]
    fn shadow_rays_are_spared_many_clear_triangles() {
        let all: usize = with_clear(0).models.iter().map(|model| model.mesh.triangles.len()).sum();
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
        let all: usize = with_clear(0).models.iter().map(|model| model.mesh.triangles.len()).sum();
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
        // where its file puts it, it has triangles of its own
        scene.models.push(Model { track: at(0.0), ..moving });
        assert_eq!(scene.built().count(), built + 1);
        assert_eq!(held_twice(&scene, Caustics::Paths), 0);
    }
}
