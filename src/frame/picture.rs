//! One picture, through all phases: the scene at one pose, made of the samples that its [lineage](super::lineage) names.

use std::sync::Arc;
use std::time::Instant;

use super::audit;
use super::audit::audit_tiles;
use super::film::develop;
use super::grid::view::View;
use super::grid::wanted::Wanted;
use super::history::PictureHistory;
use super::lineage::{Lineage, exposure_beside};
use super::planes::channels::Channel;
use super::planes::kernel::Kernel;
use super::render_error::RenderError;
use super::reuse::estimate::{Estimate, estimate};
use super::reuse::proofs;
use super::secondary::ray_trees::{self, TileTrees};
use super::secondary::surroundings;
use super::shot::frame_view::{FrameView, Neighbor, SeedPlace};
use super::shot::motion_vectors::MotionVectors;
use super::shot::moved_bounds::MovedBounds;
use super::shot::plan::{CameraChange, Plan};
use super::shot::prepared::Prepared;
use super::shot::proofs::EyePath;
use super::shot::reflection_maps::{NO_MAPS, ReflectionMaps};
use super::tiles::TileSum;
use super::tiles::input::FilmContents;
use super::tiles::level::{Level, LevelScratch, Others};
use super::validity::ValidDirection;
use crate::changes::{Direction, Motion, Until};
use crate::film::Film;
use crate::geometry::Bounds;
use crate::layers::Layers;
use crate::media::Media;
use crate::pose::{CameraPose, Clip, Pose};
use crate::samples::SampleStore;
use crate::samples::saved::PictureName;
use crate::settings::{Backdrop, Mode, Reuse, Settings};
use crate::shade::deformed::Deformations;
use crate::shade::sampling::hash_of;
use crate::stats::{AuditCounts, Seconds, TracingSeconds};
use crate::stereo::EyePlace;
use crate::trace::clipped::Clipped;
use crate::trace::timed::Timed;
use crate::trace::{Backend, Tracer};

/// A picture to render.
pub struct PictureRequest {
    /// Its eye and exposure.
    pub picture: PictureName,
    /// The state of the shot in it.
    pub pose: Pose,
    /// The state of the shot from which seeds follow, if it is another one: that at the frame's own time, which all exposures share.
    pub seed_pose: Option<Pose>,
    /// The place of its eye beside the camera, if there are two.
    pub place: Option<EyePlace>,
    /// The frame whose motion vectors it shows, if it shows any.
    pub at_frame: Option<i32>,
    /// Number of frames rendered so far, with this one.
    pub rendered: u32,
    /// Number of pictures that may be kept beside each other, with this one: they share the memory for ray trees.
    pub sharers: usize,
    /// The time when work on it began.
    pub start: Instant,
}

/// A picture that is rendered, and its costs.
pub struct RenderedPicture {
    pub film: Arc<Film>,
    /// True if it was made of the samples that its lineage names.
    pub reuses: bool,
    /// True if none of those were in sight: a cut that nobody had marked.
    pub is_cut: bool,
    /// True if those samples were lent.
    pub is_lent: bool,
    pub sum: TileSum,
    pub seconds: Seconds,
    pub tracing: TracingSeconds,
    pub audit: Option<AuditCounts>,
}

/// Renders the picture that `request` names. Its samples and its film are left in `history`, which has those of its ancestor, unless a
/// `lender` keeps them; the picture `beside` lends what they leave open.
pub fn render(
    prepared: &Prepared,
    (backend, maps, scratch): (&mut dyn Backend, &mut ReflectionMaps, &mut LevelScratch),
    (history, lender, beside): (&mut PictureHistory, Option<&PictureHistory>, Option<&PictureHistory>),
    lineage: &Lineage,
    request: &PictureRequest,
) -> Result<RenderedPicture, RenderError> {
    let setup = Setup::of(prepared, history, lineage, request);
    let tracer = backend.commit(&request.pose, &lineage.plan.moved)?;
    let timed = Timed::new(&*tracer);
    let clipped = Clipped::new(&timed, &request.pose);
    let is_whole = request.pose.camera.clip == Clip::NONE;
    let tracer: &dyn Tracer = if is_whole { &timed } else { &clipped };
    let frame = setup.frame_view(prepared, lineage, request, tracer);

    // what will not pay is not begun
    let coarsest = lender.unwrap_or(history).levels[0].store.as_ref();
    let (reuses, estimate) = choose(lineage.from.is_some(), coarsest, &frame);
    let lender = lender.filter(|_| reuses);
    let is_cut = estimate.is_cut;
    if !reuses {
        history.levels.iter_mut().for_each(|level| level.drop_samples(scratch));
    }
    let plan = if reuses { &lineage.plan } else { &setup.base_plan };
    // not in frames that are traced in full: few are followed by one with the same camera
    let stays = reuses && plan.camera == CameraChange::None;
    let keeps_trees = stays
        && prepared.has_trees
        && !frame.motion.is_none()
        && !frame.motion.expires_next(frame.light_change, request.pose.moment)
        // the background that veils show in its own layer is not kept with their trees
        && !shows_background_apart(&frame);
    let keeps_mirrored = keeps_mirrored(prepared, request, &frame, stays);
    let frame = FrameView { plan, keeps_trees, keeps_mirrored, ..frame };
    if keeps_trees {
        allow_trees(&mut history.levels, &prepared.settings, request.sharers);
    }

    let mut seconds = Seconds { reproject: request.start.elapsed().as_secs_f64(), ..Seconds::default() };
    let begin = Instant::now();
    let (now, map_rays) = surroundings::updated(std::mem::take(maps), &frame, &prepared.bounds);
    let frame = FrameView { maps: &now, ..frame };
    seconds.light += begin.elapsed().as_secs_f64();
    let shown = history.film.take().and_then(Arc::into_inner);
    let film_is_last = shown.is_some();
    let mut film = shown.unwrap_or_else(|| develop::blank(&history.levels[0].grid, frame.channels));
    let first_shows = if film_is_last { FilmContents::Last } else { FilmContents::Nothing };
    let begin = Instant::now();
    let obstacles = (reuses && proofs::are_of_use(&frame)).then(|| prepared.obstacles());
    seconds.reproject += begin.elapsed().as_secs_f64();
    let beside = beside.filter(|_| reuses);
    let others = |level: usize| {
        let [lent, beside] =
            [lender, beside].map(|other| other.and_then(|other| other.levels[level].store.as_ref()));
        Others { lent, beside, obstacles }
    };
    let mut sum = history.levels[0].render(&frame, estimate, others(0), scratch, &mut film, first_shows);
    if sum.is_stopped {
        return Err(RenderError::Stopped);
    }
    sum.share_time(&mut seconds);
    let threshold = prepared.settings.refinement.map_or(f32::INFINITY, |refinement| refinement.threshold);
    let mut all_wanted: Vec<Wanted> = Vec::new();
    for finer in 1..history.levels.len() {
        let begin = Instant::now();
        let (coarser, finest) = history.levels.split_at_mut(finer);
        let (coarser, level) = (&coarser[finer - 1], &mut finest[0]);
        level.want(&coarser.flag(&setup.of_level(&frame, finer - 1, &all_wanted), threshold), stays);
        all_wanted.extend(level.wanted.take());
        let written = coarser.written(level);
        let frame = setup.of_level(&frame, finer, &all_wanted);
        seconds.reproject += begin.elapsed().as_secs_f64();
        let shows = FilmContents::Coarser { is_last: film_is_last, written: &written };
        let of_level = level.render(&frame, Estimate::default(), others(finer), scratch, &mut film, shows);
        if of_level.is_stopped {
            return Err(RenderError::Stopped);
        }
        of_level.share_time(&mut seconds);
        sum = sum.plus(of_level);
    }
    if let Some(fault) = frame.scene.pager().and_then(|pager| pager.fault()) {
        return Err(RenderError::Textures(fault.to_owned()));
    }
    seconds.total = request.start.elapsed().as_secs_f64();
    let tracing = timed.seconds();
    let audit = prepared.settings.audit.then(|| {
        let frames = (0..history.levels.len()).map(|level| {
            let mirrored = frame.keeps_mirrored.then_some(&history.levels[level].mirrored_before);
            FrameView { mirrored, ..setup.of_level(&frame, level, &all_wanted) }
        });
        let stores = history.levels.iter().filter_map(|level| level.store.as_ref());
        // nothing was left in a film that is new
        let mut counts = audit(&frames.zip(stores).collect::<Vec<_>>(), film_is_last.then_some(&film));
        counts.differing += now.differing(&surroundings::made(&frame, &prepared.bounds).0);
        counts
    });
    sum.rays += map_rays;
    *maps = now;
    for (level, wanted) in history.levels[1..].iter_mut().zip(all_wanted) {
        level.wanted = Some(wanted);
    }
    let film = Arc::new(film);
    history.film = Some(Arc::clone(&film));
    Ok(RenderedPicture {
        film,
        reuses,
        is_cut,
        is_lent: reuses && lineage.is_lent,
        sum,
        seconds,
        tracing,
        audit,
    })
}

/// Parts of a picture's [`FrameView`] that are made for it alone.
struct Setup<'a> {
    /// One for each level of samples, as all that follows.
    views: Vec<View>,
    /// Those of the exposure that shares samples with the picture's own; none where no samples are projected.
    beside: Vec<View>,
    /// See [`Neighbor`].
    shift_beside: [f32; 2],
    motion_vectors: Vec<Option<MotionVectors>>,
    moved_bounds: MovedBounds,
    dynamic_bounds: MovedBounds,
    deformations: Deformations,
    media: Option<Media<'a>>,
    displaced: Vec<bool>,
    hidden: Vec<bool>,
    base_plan: Plan,
    motions: (&'a Motion, Option<&'a Motion>),
    eye_path: EyePath,
    channels: &'a [Channel],
    light_changes: Vec<Until>,
    area_light_change: Until,
}

impl<'a> Setup<'a> {
    fn of(
        prepared: &'a Prepared,
        history: &PictureHistory,
        lineage: &Lineage,
        request: &'a PictureRequest,
    ) -> Self {
        let Prepared { scene, bounds, settings, .. } = prepared;
        let PictureRequest { picture, pose, place, at_frame, .. } = request;
        let strata = prepared.exposures.strata;
        let cameras = (pose.camera, &pose.cameras[..]);
        let view = |level: &Level| View::of_exposure(&level.grid, cameras, (strata, picture.exposure));
        let views: Vec<View> = history.levels.iter().map(view).collect();
        let has_motion = at_frame.filter(|_| settings.layers.has(Layers::ALL_MOTION));
        // what the film shows, which goes over with the samples
        let last = history.pose.as_ref().map(|shown| shown.frame);
        let motion_vectors = |view: &View| {
            has_motion.map(|frame| MotionVectors::about(scene, frame, &view.grid, place.as_ref(), last))
        };
        let motions = motions(prepared, picture.exposure, lineage.valid);
        let light_changes = light_changes(pose, motions);
        let is_area = |light: usize| pose.all_of_light(light).any(|light| light.shape.is_area());
        let areas = light_changes.iter().enumerate().filter(|(light, _)| is_area(*light));
        let deformations = prepared.deformations(pose);
        Self {
            media: prepared.media.placed(scene, pose, &deformations),
            motion_vectors: views.iter().map(motion_vectors).collect(),
            views,
            beside: views_beside(prepared, history, lineage, request),
            shift_beside: shift_beside(prepared, *picture),
            deformations,
            moved_bounds: MovedBounds::new(scene, bounds, pose, &lineage.plan),
            dynamic_bounds: MovedBounds::ever(scene, bounds, pose),
            displaced: flagged(pose, |model| {
                let rests = pose.models[model].is_identity && pose.sweeps.of(model).is_none();
                !rests || scene.models[model].mesh.deforms()
            }),
            hidden: flagged(pose, |model| !pose.models[model].is_visible),
            base_plan: Plan::of_base_frame(pose),
            area_light_change: areas.fold(Until::FOREVER, |least, (_, until)| least.min(*until)),
            motions,
            eye_path: eye_path(prepared, lineage, request),
            light_changes,
            channels: prepared.channels_of(*picture),
        }
    }

    /// Makes the view that the phases of the coarsest level read.
    fn frame_view<'f>(
        &'f self,
        prepared: &'f Prepared,
        lineage: &'f Lineage,
        request: &'f PictureRequest,
        tracer: &'f dyn Tracer,
    ) -> FrameView<'f> {
        let settings = &prepared.settings;
        FrameView {
            scene: prepared.scene,
            sky: &prepared.sky,
            emitters: &prepared.emitters,
            light_chances: &prepared.light_chances,
            links: &prepared.links,
            moved_sets: prepared.links.sets_of(&lineage.plan.moved),
            media: self.media.as_ref(),
            palette: &prepared.palette,
            pose: &request.pose,
            deformations: &self.deformations,
            ticks: None,
            displaced: &self.displaced,
            hidden: &self.hidden,
            hides_from_some: prepared.hides_from_some,
            roles: &prepared.roles,
            slots: &prepared.layout.slots,
            curved: &prepared.curved,
            lifts: &prepared.lifts,
            view: &self.views[0],
            beside: self.neighbor(0),
            wanted: None,
            notes_colors: self.views.len() > 1,
            seeds: SeedPlace {
                pose: request.seed_pose.as_ref().unwrap_or(&request.pose),
                view: view_hash(&request.seed_pose.as_ref().unwrap_or(&request.pose).camera) ^ prepared.salt,
                strata: prepared.exposures.strata,
                stratum: prepared.exposures.all[request.picture.exposure].stratum,
            },
            eye_path: &self.eye_path,
            proofs: None,
            plan: &lineage.plan,
            moved_bounds: &self.moved_bounds,
            dynamic_bounds: &self.dynamic_bounds,
            tracer,
            maps: &NO_MAPS,
            settings,
            paths: prepared.layout.paths,
            first_paths: prepared.layout.paths.min(settings.first_paths() as usize),
            occlusion: prepared.occlusion,
            motion: self.motions.0,
            other_motion: self.motions.1,
            light_changes: &self.light_changes,
            area_light_change: self.area_light_change,
            keeps_trees: false,
            keeps_mirrored: false,
            mirrored: None,
            light_change: self.light_changes.iter().fold(Until::FOREVER, |least, until| least.min(*until)),
            layers: settings.layers,
            motion_vectors: self.motion_vectors[0].as_ref(),
            kernel: Kernel::new(settings.filter, settings.filter_radius())
                .map(|kernel| kernel.shifted(shift_in_pixels(prepared, request.picture))),
            channels: self.channels,
            light_groups: &prepared.light_groups,
            mattes: prepared.mattes.as_ref(),
            rendered: request.rendered,
            watcher: prepared.watcher.as_ref(),
            stop: prepared.stop.as_ref(),
        }
    }

    /// The exposure that shares samples with the picture's own, at level number `level`.
    fn neighbor(&self, level: usize) -> Option<Neighbor<'_>> {
        self.beside.get(level).map(|view| Neighbor { view, shift: self.shift_beside })
    }

    /// Makes the view that the phases of level number `level` read, from that of the coarsest level, `frame`. `wanted`: of the
    /// levels after it.
    fn of_level<'f>(&'f self, frame: &FrameView<'f>, level: usize, wanted: &'f [Wanted]) -> FrameView<'f> {
        FrameView {
            view: &self.views[level],
            beside: self.neighbor(level),
            motion_vectors: self.motion_vectors[level].as_ref(),
            wanted: level.checked_sub(1).map(|finer| &wanted[finer]),
            notes_colors: level + 1 < self.views.len(),
            ..*frame
        }
    }
}

/// Views of the exposure with which a picture that is inferred shares samples, one for each level.
fn views_beside(
    prepared: &Prepared,
    history: &PictureHistory,
    lineage: &Lineage,
    request: &PictureRequest,
) -> Vec<View> {
    let lenders = prepared.lenders();
    if lenders < 2 || lineage.from.is_none() || lineage.plan.camera == CameraChange::None {
        return Vec::new();
    }
    let PictureRequest { picture, pose, place, .. } = request;
    let exposure = exposure_beside(picture.exposure, lenders);
    let (camera, at_ticks) = prepared.camera(pose.frame, exposure, place.as_ref());
    let of_exposure = (prepared.exposures.strata, exposure);
    history
        .levels
        .iter()
        .map(|level| View::of_exposure(&level.grid, (camera, &at_ticks), of_exposure))
        .collect()
}

/// How much further right and down the window of the exposure beside a picture's is shifted, in pixels.
fn shift_beside(prepared: &Prepared, picture: PictureName) -> [f32; 2] {
    let exposure = exposure_beside(picture.exposure, prepared.exposures.all.len());
    let [own, other] =
        [picture, PictureName { exposure, ..picture }].map(|picture| shift_in_pixels(prepared, picture));
    [0, 1].map(|axis| other[axis] - own[axis])
}

/// Shift of the window of a picture, to the right and down, in pixels.
fn shift_in_pixels(prepared: &Prepared, picture: PictureName) -> [f32; 2] {
    let [right, up] = prepared.exposures.all[picture.exposure].shift;
    let finest = prepared.grids.last().map_or(1, |grid| grid.samples);
    [right, -up].map(|cells| (cells / f64::from(finest)) as f32)
}

/// Returns true if what flat mirrors show is kept, and served from the frame before. That is where it gathers light: what lights give it
/// straight costs no more than its verification. With `stays`, the camera does not move, and ray trees are kept instead.
fn keeps_mirrored(prepared: &Prepared, request: &PictureRequest, frame: &FrameView, stays: bool) -> bool {
    let settings = &prepared.settings;
    let pose = &request.pose;
    let is_kept = settings.mode != Mode::Full
        && settings.reuse == Reuse::Target
        && prepared.has_trees
        && frame.paths > 0;
    // what dims the eye's rays, and what the receiver of light is, would be another thing for each way to a place
    let is_of_place = frame.media.is_none()
        && !frame.has_linked_emission()
        && frame.occlusion.is_none_or(|occlusion| !occlusion.dims_ambient);
    // each cell of an exposure has a moment and an eye of its own
    let is_sharp = !pose.has_ticks() && pose.cameras.is_empty() && !pose.camera.is_orthographic();
    is_kept
        && is_of_place
        && is_sharp
        && !stays
        && prepared.moves(pose, request.picture.exposure, request.place.as_ref())
}

/// Returns true if a layer has the background that veils show.
fn shows_background_apart(frame: &FrameView) -> bool {
    frame.settings.background == Backdrop::Transparent
        && frame.layers.has(Layers::BACKGROUND)
        && frame.scene.materials.iter().any(|material| material.lets_straight_through())
}

/// Places that the eye of a picture takes in the frames that are inferred from it; where no samples are projected, nobody asks.
fn eye_path(prepared: &Prepared, lineage: &Lineage, request: &PictureRequest) -> EyePath {
    let PictureRequest { picture, pose, place, .. } = request;
    let here = Bounds::at(pose.camera.eye);
    if lineage.from.is_none() || lineage.plan.camera == CameraChange::None {
        return EyePath { soon: here, ahead: here, zoom: 1.0 };
    }
    let step = if lineage.valid.direction() == Direction::Backward { -1 } else { 1 };
    let cameras: Vec<CameraPose> = (0..=prepared.frames_ahead)
        .map(|ahead| prepared.middle_camera(pose.frame + step * ahead, picture.exposure, place.as_ref()))
        .collect();
    let around = |cameras: &[CameraPose]| cameras.iter().fold(here, |all, camera| all.with(camera.eye));
    let widest = cameras.iter().fold(pose.camera.half_height, |most, camera| most.max(camera.half_height));
    EyePath {
        soon: around(&cameras[..cameras.len() / 2]),
        ahead: around(&cameras),
        zoom: widest / pose.camera.half_height,
    }
}

/// Motion of the whole shot, at the moments of an exposure, in the direction of time in which answers are to be valid; and in the opposite
/// one, if they are to be in both.
fn motions<'a>(
    prepared: &'a Prepared,
    exposure: usize,
    valid: ValidDirection,
) -> (&'a Motion, Option<&'a Motion>) {
    let (motion, back) = (prepared.motion(exposure), prepared.motion_back(exposure));
    match valid {
        ValidDirection::To(Direction::Forward) => (motion, None),
        ValidDirection::To(Direction::Backward) => (back, None),
        ValidDirection::Both => (motion, Some(back)),
    }
}

/// For each light, the first later frame in which it changes.
fn light_changes(pose: &Pose, (motion, other_motion): (&Motion, Option<&Motion>)) -> Vec<Until> {
    let moment = pose.moment;
    let change = |light| {
        let until = motion.first_light_change(light, moment);
        other_motion.map_or(until, |other| {
            until.min(other.to_opposite(other.first_light_change(light, moment), moment, motion))
        })
    };
    (0..pose.lights.len()).map(change).collect()
}

/// Audits the samples of all levels, and the pixels of `film`, if that may show something left from before.
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

/// Decides if the frame is inferred from the `store` of the frame before, if it can be: not where it shows something else, and with
/// `--mode auto` not where that would not pay. And what it took to choose.
fn choose(can: bool, store: Option<&SampleStore>, frame: &FrameView) -> (bool, Estimate) {
    match store {
        Some(store) if can && frame.plan.camera != CameraChange::None => {
            let estimate = estimate(store, frame);
            let is_traced = estimate.is_cut || frame.settings.mode == Mode::Auto && !estimate.pays;
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
