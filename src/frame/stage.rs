//! What every phase of one frame reads, and what one worker writes beside the store.

use glam::Vec3;

use super::movers::Movers;
use super::placed::PlacedTile;
use super::plan::Plan;
use super::view::View;
use crate::motion::{Pose, Transform};
use crate::samples::{BACKGROUND, CELLS, Cold, EMPTY, Hot};
use crate::scene::{Material, Scene};
use crate::stats::RayCounts;
use crate::trace::{HitBatch, RayBatch, Tracer};

/// A scene as it stands in one frame. Nobody writes to it.
#[derive(Clone, Copy)]
pub struct Stage<'a> {
    /// What there is.
    pub scene: &'a Scene,
    /// Where it is.
    pub pose: &'a Pose,
    /// How it is seen.
    pub view: &'a View,
    /// What changed.
    pub plan: &'a Plan,
    /// Where the models that moved are.
    pub movers: &'a Movers,
    /// Who answers rays about it.
    pub tracer: &'a dyn Tracer,
    /// Bounces that a ray from the eye may take.
    pub depth: u32,
}

impl<'a> Stage<'a> {
    /// The model's place.
    pub fn transform(&self, model: u32) -> &'a Transform {
        &self.pose.models[model as usize]
    }

    /// From the eye to a sample: an offset for a surface, a direction for the background.
    #[inline]
    pub fn offset(&self, sample: &Hot) -> Vec3 {
        if sample.model == BACKGROUND {
            return sample.point;
        }
        self.transform(sample.model).point(sample.point) - self.view.camera.eye
    }

    /// Whether the sample's model moved since the frame before. The background never does.
    #[inline]
    pub fn moved(&self, sample: &Hot) -> bool {
        self.plan.any_moved && sample.model < EMPTY && self.plan.moved[sample.model as usize]
    }

    /// What the surface of a sample is made of.
    #[inline]
    pub fn material(&self, hot: &Hot, cold: &Cold) -> &'a Material {
        let mesh = &self.scene.models[hot.model as usize].mesh;
        &self.scene.materials[usize::from(mesh.material_of[cold.triangle as usize])]
    }
}

/// Rays that one cell has cost in this frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[allow(missing_docs, reason = "one count a kind, by name")]
pub struct CellRays {
    pub primary: u16,
    pub verification: u16,
    pub shadow: u16,
    pub secondary: u16,
}

/// Seconds that a worker spent in each phase of its tiles.
#[derive(Debug, Clone, Copy, Default)]
#[allow(missing_docs, reason = "the phases, by name")]
pub struct WorkerSeconds {
    pub gather: f64,
    pub verify: f64,
    pub trace: f64,
    pub enhance: f64,
    pub filter: f64,
}

impl std::ops::AddAssign for WorkerSeconds {
    fn add_assign(&mut self, other: Self) {
        self.gather += other.gather;
        self.verify += other.verify;
        self.trace += other.trace;
        self.enhance += other.enhance;
        self.filter += other.filter;
    }
}

/// One worker's memory for the tile that it is at: kept from tile to tile and from frame to frame, so
/// that the loop allocates nothing.
#[derive(Debug, Default)]
pub struct Workbench {
    /// Of the phase at work.
    pub rays: RayBatch,
    /// Their answers.
    pub hits: HitBatch,
    /// Their answers, a bit a ray.
    pub blocked: Vec<u16>,
    /// Which cell (or which bounce) each ray of `rays` is for.
    pub owners: Vec<u32>,
    /// Rays by cell.
    pub cell_rays: Vec<CellRays>,
    /// Rays by kind.
    pub counts: RayCounts,
    /// Time by phase.
    pub seconds: WorkerSeconds,
    /// Of the phase that follows rays beyond the first surface.
    pub bounces: super::bounce::Bounces,
    /// Of the phase that lights samples.
    pub lighting: super::light::Lighting,
    /// The tile's surfaces in world space.
    pub placed: PlacedTile,
    /// What each cell shows in this frame.
    pub radiance: Vec<super::enhance::Radiance>,
}

impl Workbench {
    /// Clears what belongs to a tile.
    pub fn begin_tile(&mut self) {
        self.cell_rays.clear();
        self.cell_rays.resize(CELLS, CellRays::default());
        self.placed.begin_tile();
    }

    /// Starts a list of rays.
    pub fn begin_rays(&mut self) {
        self.rays.clear();
        self.owners.clear();
    }

    /// Makes room for one bit a ray of `rays`, none of them set.
    pub fn begin_answers(&mut self) {
        self.blocked.clear();
        self.blocked.resize(self.rays.packet_count(), 0);
    }
}

/// Whether bit number `ray` of `bits` is set.
#[inline]
pub fn bit(bits: &[u16], ray: usize) -> bool {
    bits[ray / 16] >> (ray % 16) & 1 != 0
}
