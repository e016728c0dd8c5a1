//! One picture, through all phases: what is to be seen at a pose, made of samples that are kept or of none.

use std::sync::Arc;
use std::time::Instant;

use super::audit;
use super::audit::audit_tiles;
use super::eyes::EyeMemory;
use super::film::develop;
use super::grid::view::View;
use super::grid::wanted::Wanted;
use super::planes::channels::Channel;
use super::planes::kernel::Kernel;
use super::render_error::RenderError;
use super::reuse::estimate::{Estimate, estimate};
use super::secondary::ray_trees::{self, TileTrees};
use super::secondary::surroundings;
use super::shot::frame_view::FrameView;
use super::shot::motion_vectors::MotionVectors;
use super::shot::moved_bounds::MovedBounds;
use super::shot::plan::{CameraChange, Plan};
use super::shot::prepared::Prepared;
use super::shot::reflection_maps::{NO_MAPS, ReflectionMaps};
use super::tiles::level::Level;
use super::tiles::{Shows, TileSum};
use crate::changes::{Direction, Motion, Until};
use crate::film::Film;
use crate::layers::Layers;
use crate::pose::{CameraPose, Pose};
use crate::samples::SampleStore;
use crate::settings::{Backdrop, Caustics, Mode, Settings};
use crate::shade::deformed::Deformations;
use crate::shade::sampling::hash_of;
use crate::stats::{AuditCounts, Seconds, TracingSeconds};
use crate::trace::timed::Timed;
use crate::trace::{Backend, Tracer};

/// Which picture is to be made, and of what.
pub struct Order<'a> {
    /// Where everything is.
    pub pose: &'a Pose,
    /// Whether it may be made of the samples that the memory has.
    pub reuse: bool,
    /// What changed since those were seen.
    pub plan: Plan,
    /// Where everything was in the picture that the memory's film shows, if that is the one before this.
    pub shown: Option<&'a Pose>,
    /// In which direction time runs, and whether what is found out is to hold in both.
    pub time: (Direction, bool),
    /// Frames rendered so far, with this one.
    pub rendered: u32,
    /// Its planes.
    pub channels: &'a [Channel],
    /// The frame whose motion vectors it shows, if it shows any.
    pub at_frame: Option<i32>,
    /// Pictures of a frame that are kept beside each other, with this one: they share the memory for ray trees.
    pub sharers: usize,
    /// When work on it began.
    pub start: Instant,
}

/// A picture that is made, and what it took.
pub struct Made {
    pub film: Arc<Film>,
    /// Whether it was made of the samples that there were.
    pub reuses: bool,
    /// Nothing of those was in sight: nobody had said that the shot cuts.
    pub is_cut: bool,
    pub sum: TileSum,
    pub seconds: Seconds,
    pub tracing: TracingSeconds,
    pub audit: Option<AuditCounts>,
}

/// Makes what `order` asks for, and leaves samples and film in `memory`.
pub fn make(
    prepared: &Prepared,
    backend: &mut dyn Backend,
    memory: &mut EyeMemory,
    maps: &mut ReflectionMaps,
    order: &Order,
) -> Result<Made, RenderError> {
    memory.last = None;
    let setup = Setup::of(prepared, memory, order);
    let tracer = backend.commit(order.pose, &order.plan.moved)?;
    let timed = Timed::new(&*tracer);
    let frame = setup.frame_view(prepared, order, &timed);

    // what will not pay is not begun
    let (reuses, estimate) = choose(order.reuse, memory.levels[0].store.as_ref(), &frame);
    let is_cut = estimate.is_cut;
    if !reuses {
        memory.levels.iter_mut().for_each(Level::drop_samples);
    }
    let plan = if reuses { &order.plan } else { &setup.base_plan };
    // not in frames that are traced in full: few are followed by one with the same camera
    let stays = reuses && plan.camera == CameraChange::None;
    let keeps_trees = stays
        && prepared.has_trees
        && !frame.motion.is_none()
        && !frame.motion.expires_next(frame.light_change, order.pose.moment);
    let frame = FrameView { plan, keeps_trees, ..frame };
    if keeps_trees {
        allow_trees(&mut memory.levels, &prepared.settings, order.sharers);
    }

    let mut seconds = Seconds { reproject: order.start.elapsed().as_secs_f64(), ..Seconds::default() };
    let begin = Instant::now();
    let (now, map_rays) = surroundings::updated(std::mem::take(maps), &frame, &prepared.bounds);
    let frame = FrameView { maps: &now, ..frame };
    seconds.enhance += begin.elapsed().as_secs_f64();
    let shown = memory.film.take().and_then(Arc::into_inner);
    let film_is_last = shown.is_some();
    let mut film = shown.unwrap_or_else(|| develop::blank(&memory.levels[0].grid, frame.channels));
    let first_shows = if film_is_last { Shows::Last } else { Shows::Nothing };
    let mut sum = memory.levels[0].render(&frame, estimate, &mut film, first_shows);
    if sum.is_stopped {
        return Err(RenderError::Stopped);
    }
    sum.share_time(&mut seconds);
    let threshold = prepared.settings.refinement.map_or(f32::INFINITY, |refinement| refinement.threshold);
    let mut all_wanted: Vec<Wanted> = Vec::new();
    for finer in 1..memory.levels.len() {
        let begin = Instant::now();
        let (coarser, finest) = memory.levels.split_at_mut(finer);
        let (coarser, level) = (&coarser[finer - 1], &mut finest[0]);
        level.want(&coarser.flag(&setup.of_level(&frame, finer - 1, &all_wanted), threshold), stays);
        all_wanted.extend(level.wanted.take());
        let written = coarser.written(level);
        let frame = setup.of_level(&frame, finer, &all_wanted);
        seconds.reproject += begin.elapsed().as_secs_f64();
        let shows = Shows::Coarser { is_last: film_is_last, written: &written };
        let of_level = level.render(&frame, Estimate::default(), &mut film, shows);
        if of_level.is_stopped {
            return Err(RenderError::Stopped);
        }
        of_level.share_time(&mut seconds);
        sum = sum.plus(of_level);
    }
    seconds.total = order.start.elapsed().as_secs_f64();
    let tracing = timed.seconds();
    let audit = prepared.settings.audit.then(|| {
        let frames = (0..memory.levels.len()).map(|level| setup.of_level(&frame, level, &all_wanted));
        let stores = memory.levels.iter().filter_map(|level| level.store.as_ref());
        // nothing was left in a film that is new
        let mut counts = audit(&frames.zip(stores).collect::<Vec<_>>(), film_is_last.then_some(&film));
        counts.differing += now.differing(&surroundings::made(&frame, &prepared.bounds).0);
        counts
    });
    sum.rays += map_rays;
    *maps = now;
    for (level, wanted) in memory.levels[1..].iter_mut().zip(all_wanted) {
        level.wanted = Some(wanted);
    }
    memory.last = Some(order.pose.clone());
    let film = Arc::new(film);
    memory.film = Some(Arc::clone(&film));
    Ok(Made { film, reuses, is_cut, sum, seconds, tracing, audit })
}

/// What of a picture's [`FrameView`] is made for it alone.
struct Setup<'a> {
    /// One for each level of samples, as all that follows.
    views: Vec<View>,
    motion_vectors: Vec<Option<MotionVectors>>,
    moved_bounds: MovedBounds,
    dynamic_bounds: MovedBounds,
    deformations: Deformations,
    displaced: Vec<bool>,
    hidden: Vec<bool>,
    base_plan: Plan,
    motions: (&'a Motion, Option<&'a Motion>),
    light_changes: Vec<Until>,
    area_light_change: Until,
}

impl<'a> Setup<'a> {
    fn of(prepared: &'a Prepared, memory: &EyeMemory, order: &Order) -> Self {
        let Prepared { scene, bounds, settings, .. } = prepared;
        let pose = order.pose;
        let views: Vec<View> =
            memory.levels.iter().map(|level| View::new(&level.grid, pose.camera)).collect();
        let place = memory.place.as_ref();
        let has_motion = order.at_frame.filter(|_| settings.layers.has(Layers::ALL_MOTION));
        let last = order.shown.map(|shown| shown.frame);
        let motion_vectors =
            |view: &View| has_motion.map(|frame| MotionVectors::about(scene, frame, &view.grid, place, last));
        let motions = motions(prepared, order.time);
        let light_changes = light_changes(pose, motions);
        let areas = pose.lights.iter().zip(&light_changes).filter(|(light, _)| light.shape.is_area());
        Self {
            motion_vectors: views.iter().map(motion_vectors).collect(),
            views,
            deformations: Deformations::of(scene, &pose.models, true),
            moved_bounds: MovedBounds::of(scene, bounds, pose, &order.plan),
            dynamic_bounds: MovedBounds::ever(scene, bounds, pose),
            displaced: flagged(pose, |model| {
                !pose.models[model].is_identity || scene.models[model].mesh.shapes.is_some()
            }),
            hidden: flagged(pose, |model| !pose.models[model].is_visible),
            base_plan: Plan::of_base_frame(pose),
            area_light_change: areas.fold(Until::FOREVER, |least, (_, until)| least.min(*until)),
            motions,
            light_changes,
        }
    }

    /// What the phases of the coarsest level read.
    fn frame_view<'f>(
        &'f self,
        prepared: &'f Prepared,
        order: &'f Order,
        tracer: &'f dyn Tracer,
    ) -> FrameView<'f> {
        let settings = &prepared.settings;
        FrameView {
            scene: prepared.scene,
            sky: &prepared.sky,
            emitters: &prepared.emitters,
            palette: &prepared.palette,
            pose: order.pose,
            deformations: &self.deformations,
            displaced: &self.displaced,
            hidden: &self.hidden,
            slots: &prepared.layout.slots,
            endless: &prepared.endless,
            view: &self.views[0],
            wanted: None,
            notes_colors: self.views.len() > 1,
            view_hash: view_hash(&order.pose.camera),
            plan: &order.plan,
            moved_bounds: &self.moved_bounds,
            dynamic_bounds: &self.dynamic_bounds,
            tracer,
            maps: &NO_MAPS,
            depth: settings.depth,
            reflections: settings.reflections,
            paths: prepared.layout.paths,
            first_paths: prepared.layout.paths.min(settings.first_paths() as usize),
            budget: settings.budget,
            samples: settings.samples_a_frame(),
            bounces: settings.bounces,
            finds_caustics: settings.caustics == Caustics::Paths,
            clamp: settings.clamp,
            occlusion: prepared.occlusion,
            motion: self.motions.0,
            other_motion: self.motions.1,
            light_changes: &self.light_changes,
            area_light_change: self.area_light_change,
            chooses: settings.mode == Mode::Auto,
            reuse: settings.reuse,
            keeps_trees: false,
            light_change: self.light_changes.iter().fold(Until::FOREVER, |least, until| least.min(*until)),
            layers: settings.layers,
            shows_background: settings.background == Backdrop::Visible,
            motion_vectors: self.motion_vectors[0].as_ref(),
            kernel: Kernel::of(settings.filter, settings.filter_radius()),
            channels: order.channels,
            light_groups: &prepared.light_groups,
            mattes: prepared.mattes.as_ref(),
            rendered: order.rendered,
            watcher: prepared.watcher.as_ref(),
            stop: prepared.stop.as_ref(),
        }
    }

    /// What the phases of level number `level` read, where `frame` is what those of the coarsest one do. `wanted`: of the
    /// levels after it.
    fn of_level<'f>(&'f self, frame: &FrameView<'f>, level: usize, wanted: &'f [Wanted]) -> FrameView<'f> {
        FrameView {
            view: &self.views[level],
            motion_vectors: self.motion_vectors[level].as_ref(),
            wanted: level.checked_sub(1).map(|finer| &wanted[finer]),
            notes_colors: level + 1 < self.views.len(),
            ..*frame
        }
    }
}

/// All motion of the shot in the direction in which time runs; and in the other one, if what is found out is to hold in `both`.
fn motions<'a>(
    prepared: &'a Prepared,
    (direction, is_both): (Direction, bool),
) -> (&'a Motion, Option<&'a Motion>) {
    let back = prepared.motion_back();
    match direction {
        Direction::Forward => (&prepared.motion, Some(back).filter(|_| is_both)),
        Direction::Backward => (back, None),
    }
}

/// For each light, the first later frame in which it changes.
fn light_changes(pose: &Pose, (motion, other_motion): (&Motion, Option<&Motion>)) -> Vec<Until> {
    let moment = pose.moment;
    let change = |light| {
        let until = motion.first_light_change(light, moment);
        other_motion.map_or(until, |other| {
            until.min(other.translated(other.first_light_change(light, moment), moment, motion))
        })
    };
    (0..pose.lights.len()).map(change).collect()
}

/// What the samples of all levels are found to be; and the pixels of `film`, if that may show something left from before.
fn audit(levels: &[(FrameView, &SampleStore)], film: Option<&Film>) -> AuditCounts {
    let differs = film.map_or(Vec::new(), |film| audit::film::differing_pixels(levels, film));
    let mut counts = AuditCounts::default();
    levels.iter().for_each(|(frame, store)| counts += audit_tiles(frame, store, &differs));
    counts
}

/// Shares what the ray trees of one of the `sharers` may take among the tiles of its `levels`.
fn allow_trees(levels: &mut [Level], settings: &Settings, sharers: usize) {
    let states = levels.iter_mut().flat_map(|level| &mut level.buffers.states);
    let mut tiles: Vec<&mut TileTrees> = states.map(|state| &mut state.trees).collect();
    let budget = u64::from(settings.tree_memory) << 20;
    ray_trees::allow(&mut tiles, budget / sharers.max(1) as u64, ray_trees::bytes_of_tree(settings.layers));
}

/// Whether the frame is inferred from the `store` of the frame before, if it can be: not where it shows something else, and with
/// `--mode auto` not where that would not pay. And what it took to choose.
fn choose(can: bool, store: Option<&SampleStore>, frame: &FrameView) -> (bool, Estimate) {
    match store {
        Some(store) if can && frame.plan.camera != CameraChange::None => {
            let estimate = estimate(store, frame);
            let is_traced = estimate.is_cut || frame.chooses && !estimate.pays;
            (!is_traced, estimate)
        }
        _ => (can, Estimate::default()),
    }
}

/// A hash that changes when the camera does.
fn view_hash(camera: &CameraPose) -> u32 {
    let axes = [camera.eye, camera.right, camera.up, camera.forward].map(|axis| axis.to_array());
    hash_of(axes.as_flattened()) ^ camera.half_height.to_bits() ^ hash_of(&camera.shift)
}

/// For each model, by its number, whether this holds of it; empty where it holds of none.
fn flagged(pose: &Pose, holds: impl Fn(usize) -> bool) -> Vec<bool> {
    let flags: Vec<bool> = (0..pose.models.len()).map(holds).collect();
    if flags.contains(&true) { flags } else { Vec::new() }
}
