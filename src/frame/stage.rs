//! What every phase of one frame reads, and what one worker writes beside the store.

use glam::Vec3;

use super::bits::{bits_of_models, set_bits};
use super::estimate::Estimate;
use super::movers::Movers;
use super::placed::PlacedTile;
use super::plan::Plan;
use super::view::View;
use crate::animation::Transform;
use crate::geometry::SweptBox as Sweep;
use crate::lanes::{LANES, Mask, Vec3x8};
use crate::layers::Layers;
use crate::pose::Pose;
use crate::samples::{BACKGROUND, CELLS, Column, EMPTY, TagSlot, Tile};
use crate::scene::Scene;
use crate::settings::Reuse;
use crate::shade::phong::Palette;
use crate::stats::RayCounts;
use crate::trace::{Among, HitBatch, RayBatch, Tracer};

/// A scene as it stands in one frame. Nobody writes to it.
#[derive(Clone, Copy)]
pub struct Stage<'a> {
    /// What there is.
    pub scene: &'a Scene,
    /// Its materials, ready for lighting.
    pub palette: &'a Palette,
    /// Where it is.
    pub pose: &'a Pose,
    /// For each model, whether it stands elsewhere than where its file puts it; empty where none does.
    pub displaced: &'a [bool],
    /// How it is seen.
    pub view: &'a View,
    /// Where the tags for each light are.
    pub slots: &'a [TagSlot],
    /// What changed.
    pub plan: &'a Plan,
    /// Where the models that moved are.
    pub movers: &'a Movers,
    /// Where all models are that move in some frame of the shot.
    pub movable: &'a Movers,
    /// Who answers rays about it.
    pub tracer: &'a dyn Tracer,
    /// Bounces that a ray from the eye may take.
    pub depth: u32,
    /// Whether to trace where reprojection would not pay (`--mode auto`).
    pub chooses: bool,
    /// Which kept samples serve.
    pub reuse: Reuse,
    /// Whether to note where rays beyond the first surface go: for the next frame, should the camera stand then.
    pub notes_ways: bool,
    /// What is made of the picture beside its colours.
    pub layers: Layers,
    /// The frame's number, counted from the renderer's first.
    pub rendered: u32,
    /// What it took to choose, once that is done.
    pub estimate: Option<&'a Estimate>,
}

impl<'a> Stage<'a> {
    /// The model's place.
    pub fn transform(&self, model: u32) -> &'a Transform {
        &self.pose.models[model as usize]
    }

    /// Whether any layer shows one sample of several for each pixel, the nearest to its centre.
    pub fn picks_samples(&self) -> bool {
        self.view.grid.samples > 1 && self.layers.has(Layers::OF_ONE_SAMPLE)
    }

    /// From the eye to a sample at `point` of `model`: an offset for a surface, a direction for the
    /// background.
    #[inline]
    pub fn offset(&self, point: Vec3, model: u32) -> Vec3 {
        if model == BACKGROUND {
            return point;
        }
        self.transform(model).point(point) - self.view.camera.eye
    }

    /// The same for eight cells of `tile`, from `first` on.
    #[inline(always)]
    pub fn offsets(&self, tile: &Tile, first: usize) -> Vec3x8 {
        let models = &tile.model[first..first + LANES];
        let mut points = tile.points(first);
        for lane in set_bits(self.displaced_bits(models)) {
            points.set_lane(lane, self.transform(models[lane]).point(points.lane(lane)));
        }
        let background = Mask::equal(models, BACKGROUND);
        background.select3(points, points - Vec3x8::splat(self.view.camera.eye))
    }

    /// Of eight samples' models, those whose object space is not world space, a bit each.
    #[inline(always)]
    pub fn displaced_bits(&self, models: &[u32]) -> u8 {
        if self.displaced.is_empty() {
            return 0;
        }
        bits_of_models(models, |model| self.displaced.get(model as usize) == Some(&true))
    }

    /// What rays from the eye through the cells of tile number `number` may meet.
    pub fn in_sight(&self, number: usize) -> Among {
        let ways = Sweep::fan(self.view.camera.eye, &self.view.directions_of_tile(number));
        if self.movable.may_meet_sweep(&ways) { Among::All } else { Among::Still }
    }

    /// Whether the model of a sample moved since the frame before. The background never does.
    #[inline]
    pub fn moved(&self, model: u32) -> bool {
        self.plan.any_moved && model < EMPTY && self.plan.moved[model as usize]
    }

    /// The same for eight cells, a bit each.
    #[inline(always)]
    pub fn moved_bits(&self, models: &[u32]) -> u8 {
        if !self.plan.any_moved {
            return 0;
        }
        bits_of_models(models, |model| self.moved(model))
    }
}

/// Rays that the cells of a tile have cost in this frame, by kind. Each traced cell has cost one primary ray; those that
/// were probed before have cost it as a probe.
#[derive(Debug)]
#[allow(missing_docs, reason = "one count a kind, by name")]
pub struct CellRays {
    pub probes: Column<u16>,
    pub verification: Column<u16>,
    pub shadow: Column<u16>,
    pub secondary: Column<u16>,
}

impl Default for CellRays {
    fn default() -> Self {
        Self { probes: [0; CELLS], verification: [0; CELLS], shadow: [0; CELLS], secondary: [0; CELLS] }
    }
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
    pub cell_rays: Box<CellRays>,
    /// Rays by kind.
    pub counts: RayCounts,
    /// Time by phase.
    pub seconds: WorkerSeconds,
    /// Of the phase that follows rays beyond the first surface.
    pub bounces: super::bounce::Bounces,
    /// Of the phase that brings samples from the frame before.
    pub serving: Box<super::serve::Serving>,
    /// The tile at work as it was in the frame before.
    pub before: Option<Box<Tile>>,
    /// Of the phase that lights samples.
    pub lighting: super::light::Lighting,
    /// Of the phase that makes pixels.
    pub filtering: Box<super::filter::Filtering>,
    /// The tile's surfaces in world space.
    pub placed: Box<PlacedTile>,
    /// What each cell shows in this frame.
    pub radiance: Box<super::enhance::Radiance>,
}

impl Workbench {
    /// Clears what belongs to a tile.
    pub fn begin_tile(&mut self) {
        self.cell_rays.probes.fill(0);
        self.cell_rays.verification.fill(0);
        self.cell_rays.shadow.fill(0);
        self.cell_rays.secondary.fill(0);
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
