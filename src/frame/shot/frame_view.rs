//! The scene in one frame, as every phase reads it.

use glam::Vec3;

use super::links::Links;
use super::motion_vectors::MotionVectors;
use super::moved_bounds::MovedBounds;
use super::place::Place;
use super::plan::Plan;
use super::proofs::{EyePath, Proofs};
use super::reflection_maps::ReflectionMaps;
use crate::animation::{Shape, Transform};
use crate::changes::{Motion, Until};
use crate::cryptomatte::Mattes;
use crate::exposure::{MIDDLE_TICK, Strata, Tick};
use crate::frame::grid::bits::bits_of_models;
use crate::frame::grid::cells::CellSet;
use crate::frame::grid::place;
use crate::frame::grid::view::{Cameras8, View};
use crate::frame::grid::wanted::Wanted;
use crate::frame::planes::channels::Channel;
use crate::frame::planes::kernel::Kernel;
use crate::frame::watcher::{Stop, Watcher};
use crate::lanes::{LANES, Mask, Vec3x8};
use crate::layers::Layers;
use crate::media::Media;
use crate::pose::Pose;
use crate::samples::{BACKGROUND, Column, EMPTY, MirroredSamples, Octahedral, Sample, TagSlot, Tile};
use crate::scene::look::Look;
use crate::scene::{LightGroups, RayKind, Role, Scene};
use crate::settings::{Caustics, Settings};
use crate::shade::bsdf::palette::Palette;
use crate::shade::deformed::Deformations;
use crate::shade::emitters::Emitters;
use crate::shade::horizon::Horizon;
use crate::shade::light_chances::LightChances;
use crate::shade::sampling::{SampleSeed, hash_of};
use crate::shade::sky::SkyLight;
use crate::trace::{NO_HIT, RayBatch, SceneSubset, Tracer};

/// Settings of ambient occlusion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Occlusion {
    /// Number of rays of each sample.
    pub rays: u32,
    /// Length of the rays, world space.
    pub radius: f32,
    /// True if the openness that they find dims ambient light.
    pub dims_ambient: bool,
}

/// What the seeds of new samples follow from, beside their cells: the same for all exposures of a frame, whose samples have one sequence of
/// random numbers a pixel.
#[derive(Clone, Copy)]
pub struct SeedPlace<'a> {
    /// The state of the shot at the frame's own time.
    pub pose: &'a Pose,
    /// A hash that changes when its camera does.
    pub view: u32,
    /// Division of the samples among exposures.
    pub strata: Strata,
    /// Place of the exposure's first sample among those of a pixel, across and down.
    pub stratum: [u32; 2],
}

/// The exposure with which another one shares samples, as it sees them in the same frame.
#[derive(Clone, Copy)]
pub struct Neighbor<'a> {
    /// Its camera and grid.
    pub view: &'a View,
    /// How much further right and down its pixels lie than those of the other exposure, in pixels.
    pub shift: [f32; 2],
}

/// The scene in one frame. Built once a frame; no phase writes to it.
#[derive(Clone, Copy)]
pub struct FrameView<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Light of the sky, for rays that leave the scene.
    pub sky: &'a SkyLight,
    /// Surfaces that emit light, if samples gather it.
    pub emitters: &'a Emitters,
    /// Chances with which paths ask each of the shot's lights.
    pub light_chances: &'a LightChances,
    /// Which models each light lights, and which cast shadows in its light.
    pub links: &'a Links,
    /// Sets of models that cast shadows in some lights in which any moved since the frame before: a bit each, bit 0 for all models.
    pub moved_sets: u32,
    /// Media of the scene where they are in this frame, if there are any.
    pub media: Option<&'a Media<'a>>,
    /// Materials of the scene, ready for lighting.
    pub palette: &'a Palette,
    /// Camera, models and lights in this frame.
    pub pose: &'a Pose,
    /// Shapes of the models that deform.
    pub deformations: &'a Deformations,
    /// Ticks of the cells of the tile at work, for rays that leave its samples; `None` where no ray [needs](Pose::has_ticks) one.
    pub ticks: Option<&'a Column<Tick>>,
    /// True for each model that deforms or is not where its file puts it; empty if there is none.
    pub displaced: &'a [bool],
    /// True for each model that is not there; empty if all are.
    pub hidden: &'a [bool],
    /// True if any model is hidden from some kinds of rays.
    pub hides_from_some: bool,
    /// What the eye sees of each model; empty if it sees all as themselves.
    pub roles: &'a [Role],
    /// Camera and grid.
    pub view: &'a View,
    /// The exposure with which this one [shares](crate::frame::reuse::beside) samples, if it shares any.
    pub beside: Option<Neighbor<'a>>,
    /// Cells to be made, in a level of refinement; `None`, in the coarsest, for all.
    pub wanted: Option<&'a Wanted>,
    /// True if the cells' colours are noted, for a finer level.
    pub notes_colors: bool,
    /// What seeds of new samples follow from.
    pub seeds: SeedPlace<'a>,
    /// Place of the tags of each light.
    pub slots: &'a [TagSlot],
    /// True for each model that is not made of triangles; empty if there is none.
    pub curved: &'a [bool],
    /// Upper bound, for each model, of the way from its triangles at rest to the curved surfaces that they stand for, object space;
    /// empty if all are flat.
    pub lifts: &'a [f32],
    /// Places of the eye in this frame and in some that follow.
    pub eye_path: &'a EyePath,
    /// Proofs of what need not be asked, in a frame whose camera is not where it was.
    pub proofs: Option<&'a Proofs<'a>>,
    /// Changes since the frame before.
    pub plan: &'a Plan,
    /// Boxes around the models that moved since the frame before.
    pub moved_bounds: &'a MovedBounds,
    /// Boxes around all models that move in some frame of the shot.
    pub dynamic_bounds: &'a MovedBounds,
    /// Ray tracer with the scene of this frame.
    pub tracer: &'a dyn Tracer,
    /// Reflection maps, which replace rays of some models' mirrors and glass.
    pub maps: &'a ReflectionMaps,
    /// Settings of the run. What a phase must not take from them as they are is a field of its own.
    pub settings: &'a Settings,
    /// Number of paths by which each sample gathers light; 0: it gathers none.
    pub paths: usize,
    /// Number of these paths that a sample gets at once.
    pub first_paths: usize,
    /// Settings of ambient occlusion, if samples have it.
    pub occlusion: Option<Occlusion>,
    /// Motion of the whole shot, in the direction in which frames are inferred.
    pub motion: &'a Motion,
    /// Motion in the other direction, in a frame from which frames on both sides are inferred.
    pub other_motion: Option<&'a Motion>,
    /// First later frame in which each light changes.
    pub light_changes: &'a [Until],
    /// First later frame in which any area light changes.
    pub area_light_change: Until,
    /// True if the expiry of rays beyond the first surface is tracked for later frames: the camera rests, and
    /// no light changes in the next frame.
    pub keeps_trees: bool,
    /// True if what flat mirrors show is kept for the next frame, and served from the one before: the camera moves.
    pub keeps_mirrored: bool,
    /// Samples of the frame before that are seen by way of flat mirrors, in a frame that lets them serve and leaves some; `None` in others.
    pub mirrored: Option<&'a MirroredSamples>,
    /// First later frame in which any light changes.
    pub light_change: Until,
    /// Layers of the picture beside its colours.
    pub layers: Layers,
    /// Motion vectors of the frame, if a layer shows them.
    pub motion_vectors: Option<&'a MotionVectors>,
    /// Filter from samples to pixels, if it is wider than a pixel.
    pub kernel: Option<Kernel>,
    /// Planes of the picture.
    pub channels: &'a [Channel],
    /// Groups of lights that have layers of their own.
    pub light_groups: &'a LightGroups,
    /// Mattes of the scene, if a layer shows any.
    pub mattes: Option<&'a Mattes>,
    /// Number of the frame, counted from the renderer's first.
    pub rendered: u32,
    /// Receiver of the frame's progress.
    pub watcher: Option<&'a Watcher>,
    /// Request to stop the frame.
    pub stop: Option<&'a Stop>,
}

impl<'a> FrameView<'a> {
    /// First later frame in which anything that moves touches the segment `origin + t * direction`, t in
    /// `0..=far`. In a frame from which earlier frames are inferred as well, the nearest such frame on either
    /// side counts, expressed as the later frame that is equally far away.
    #[inline]
    pub fn first_touch(&self, origin: Vec3, direction: Vec3, far: f32) -> Until {
        let moment = self.pose.moment;
        let until = self.motion.first_touch(origin, direction, far, moment);
        self.other_motion.map_or(until, |other| {
            let other_until = other.first_touch(origin, direction, far, moment);
            until.min(other.to_opposite(other_until, moment, self.motion))
        })
    }

    /// First later frame in which `model` moves, changes its shape, appears or disappears; counted as in
    /// [`first_touch`](Self::first_touch).
    #[inline]
    pub fn first_change_of(&self, model: u32) -> Until {
        let moment = self.pose.moment;
        let until = self.motion.first_change_of(model, moment);
        self.other_motion.map_or(until, |other| {
            until.min(other.to_opposite(other.first_change_of(model, moment), moment, self.motion))
        })
    }

    /// First later frame in which the model that a ray has met [changes](Self::first_change_of); never if the
    /// ray met nothing.
    #[inline]
    pub fn change_of_met(&self, model: u32) -> Until {
        if model == NO_HIT { Until::FOREVER } else { self.first_change_of(model) }
    }

    /// First later frame in which anything touches a segment, or `before` if that is earlier. Nothing is
    /// tested if `before` is the next frame already.
    #[inline]
    pub fn first_touch_before(&self, origin: Vec3, direction: Vec3, far: f32, before: Until) -> Until {
        if self.motion.expires_next(before, self.pose.moment) {
            return before;
        }
        match self.other_motion {
            Some(_) => before.min(self.first_touch(origin, direction, far)),
            None => self.motion.first_touch_before(origin, direction, far, self.pose.moment, before),
        }
    }

    /// Returns true if anything valid `until` that frame is invalid now.
    #[inline]
    pub fn has_expired(&self, until: Until) -> bool {
        self.motion.has_expired(until, self.pose.moment)
    }

    /// Wanted cells of tile number `number`; cells beyond the picture's rim may be among them.
    #[inline]
    pub fn wanted_of(&self, number: usize) -> &'a CellSet {
        self.wanted.map_or(&CellSet::ALL, |wanted| wanted.tile(number))
    }

    /// Seed of a sample of `model` that is traced anew in a cell of tile number `tile`.
    #[inline]
    pub fn new_seed(&self, tile: usize, cell: usize, model: u32) -> SampleSeed {
        let grid = &self.view.grid;
        let ([left, top], [x, y]) = (grid.tile_corner(tile), place(cell));
        let SeedPlace { pose, view, strata, stratum } = self.seeds;
        // among the samples of all exposures
        let samples = (grid.samples * strata.across) as i32;
        let at = [(left, x, stratum[0]), (top, y, stratum[1])]
            .map(|(first, cell, stratum)| (first + cell as i32) * strata.across as i32 + stratum as i32);
        let (pixel, number) = match samples {
            // without divisions, which take longer than all else here
            1 => (grid.number_of_pixel(at), 0),
            _ => {
                let [x, y] = at.map(|at| at.rem_euclid(samples));
                (grid.number_of_pixel(at.map(|at| at.div_euclid(samples))), y * samples + x)
            }
        };
        let moved = match self.displaced.get(model as usize) {
            Some(true) => {
                let transform = &pose.models[model as usize];
                hash_of(&transform.to_world.to_cols_array()) ^ self.hash_of_shape(model, transform)
            }
            _ => 0,
        };
        SampleSeed::new(pixel, number as u32, view, moved)
    }

    /// Hash that changes when the shape of a model does; 0 for a model that does not deform.
    fn hash_of_shape(&self, model: u32, transform: &Transform) -> u32 {
        if !self.deformations.has(model) {
            return 0;
        }
        // at the frame's own time a model has one shape
        let Shape { from, to, share } = transform.shape.ends[0];
        hash_of(&[from as f32, to as f32, share as f32])
    }

    /// Transform of a model's place in the middle of the exposure.
    pub fn transform(&self, model: u32) -> &'a Transform {
        &self.pose.models[model as usize]
    }

    /// Ticks of the samples of `tile`, for [`ticks`](Self::ticks), if rays need them.
    pub fn ticks_of(&self, tile: &Tile) -> Option<Column<Tick>> {
        self.pose.has_ticks().then(|| std::array::from_fn(|cell| tile.record[cell].traced.tick()))
    }

    /// Tick of the sample in a cell of the tile at work.
    #[inline(always)]
    pub fn tick_of(&self, cell: u32) -> Tick {
        self.ticks.map_or(MIDDLE_TICK, |ticks| ticks[cell as usize])
    }

    /// Has `rays` meet what moves at the ticks of these cells of the tile at work, one for each ray.
    #[inline]
    pub fn set_ticks(&self, rays: &mut RayBatch, cells: impl Iterator<Item = u32>) {
        if self.ticks.is_some() {
            rays.set_ticks(cells.map(|cell| self.tick_of(cell)));
        }
    }

    /// Has `rays` meet what moves at the ticks of the samples in these cells of `tile`, one for each ray.
    #[inline]
    pub fn set_ticks_of_samples(&self, rays: &mut RayBatch, tile: &Tile, cells: &[u32]) {
        if self.pose.has_ticks() {
            rays.set_ticks(cells.iter().map(|cell| tile.record[*cell as usize].traced.tick()));
        }
    }

    /// Has `rays` meet what moves at the ticks of the targets of these cells of tile number `number`, one for each ray.
    #[inline]
    pub fn set_ticks_of_targets(
        &self,
        rays: &mut RayBatch,
        number: usize,
        cells: impl Iterator<Item = usize>,
    ) {
        if self.pose.has_ticks() {
            rays.set_ticks(cells.map(|cell| self.view.tick_in_tile(number, cell)));
        }
    }

    /// Length in the object space of `model` for each unit of length in the world.
    #[inline]
    pub fn scale_to_object(&self, model: u32) -> f32 {
        if self.displaced.get(model as usize) == Some(&true) {
            self.transform(model).scale_to_object()
        } else {
            1.0
        }
    }

    /// Upper bound of the way from any of these models' triangles to the curved surfaces that they stand for, world space.
    pub fn most_lift(&self, models: &[u32]) -> f32 {
        if self.lifts.is_empty() {
            return 0.0;
        }
        let (mut last, mut most) = (EMPTY, 0.0_f32);
        for model in models.iter().copied().filter(|model| *model < EMPTY) {
            if model != last {
                let at_rest = self.lifts[model as usize];
                let places =
                    self.pose.transforms(model as usize).map(|transform| self.placed(model, transform));
                most = places.map(|place| place.most_lift(at_rest)).fold(most, f32::max);
                last = model;
            }
        }
        most
    }

    /// Returns true if a normal map or heights bend the normals of a triangle of a model.
    #[inline]
    pub fn is_bent(&self, model: u32, triangle: u32) -> bool {
        let mesh = &self.scene.models[model as usize].mesh;
        let material = || &self.scene.materials[usize::from(mesh.material_of[triangle as usize])];
        mesh.may_bend_normals() && mesh.is_bent_by(material())
    }

    /// Returns true if a primitive of a model is a fibre of hair, which light reaches from all around.
    #[inline(always)]
    pub fn is_fibre(&self, model: u32, primitive: u32) -> bool {
        self.palette.has_hair && self.is_hair_of_curves(model, primitive)
    }

    /// Not inlined: hardly any shot has hair.
    #[inline(never)]
    fn is_hair_of_curves(&self, model: u32, primitive: u32) -> bool {
        let mesh = &self.scene.models[model as usize].mesh;
        let material = mesh.material_of[primitive as usize];
        let has_axis = mesh.as_curved().is_some_and(|curved| curved.most_radius() > 0.0);
        has_axis && self.scene.materials[usize::from(material)].hair.is_some()
    }

    /// The curved surface that a triangle of a model stands for at a point (object space), on its outside or `from_behind`; `None`
    /// where it stands for itself. World space, at a `tick`.
    pub fn horizon(
        &self,
        (model, triangle): (u32, u32),
        point: Vec3,
        from_behind: bool,
        tick: Tick,
    ) -> Option<Horizon> {
        if self.lifts.is_empty() {
            return None;
        }
        let mesh = &self.scene.models[model as usize].mesh;
        if self.is_fibre(model, triangle) {
            return self.place(model, tick).fibre(mesh.as_curved()?.as_ref(), triangle, point);
        }
        self.place(model, tick).horizon(mesh, triangle, point, if from_behind { -1.0 } else { 1.0 })
    }

    /// Place and shape of a model at a `tick`.
    #[inline(always)]
    pub fn place(&self, model: u32, tick: Tick) -> Place<'a> {
        self.placed(model, self.pose.transform(model as usize, tick))
    }

    #[inline(always)]
    fn placed(&self, model: u32, transform: &'a Transform) -> Place<'a> {
        Place::of(self.scene, transform, self.deformations, model)
    }

    /// Albedo by which eight surfaces reflect lights that are asked for: of what goes below them paths bring the light, if there are any.
    #[inline(always)]
    pub fn albedo_of_lights(&self, looks: &[Look], albedo: Vec3x8) -> Vec3x8 {
        if self.palette.scatters_below && self.paths > 0 {
            self.palette.at_surface(looks, albedo)
        } else {
            albedo
        }
    }

    /// Returns true if lights shine through a `material` as if it were not there, always or by chance.
    pub fn shines_through(&self, material: u16) -> bool {
        let material = &self.scene.materials[usize::from(material)];
        let by_chance = material.cutout.is_some_and(|cutout| cutout.blended.is_some());
        self.settings.caustics != Caustics::Paths && (!material.casts_shadow() || by_chance)
    }

    /// Vector from the eye, at a `tick` of the exposure, to a sample at `point` of a triangle of `model`: an offset for a surface, a
    /// direction for the background.
    #[inline]
    pub fn offset(&self, point: Vec3, (model, triangle): (u32, u32), tick: Tick) -> Vec3 {
        self.offset_from(self.view.eye(tick), point, (model, triangle), tick)
    }

    /// [`offset`](Self::offset) from another `eye`.
    #[inline]
    pub fn offset_from(&self, eye: Vec3, point: Vec3, (model, triangle): (u32, u32), tick: Tick) -> Vec3 {
        if model == BACKGROUND {
            return point;
        }
        self.place(model, tick).point(|| triangle, point) - eye
    }

    /// [`offset`](Self::offset) of a sample.
    #[inline]
    pub fn offset_of(&self, sample: &Sample, tick: Tick) -> Vec3 {
        self.offset(sample.point, (sample.model, sample.record.triangle), tick)
    }

    /// The camera as the samples in eight cells of `tile`, from `first` on, are seen with it: each at its own tick.
    #[inline(always)]
    pub fn cameras(&self, tile: &Tile, first: usize) -> Cameras8 {
        self.view.cameras_at(|| tile.ticks(first))
    }

    /// [`offset`](Self::offset), from `eyes`, of the samples in eight cells of `tile`, from `first` on, where they are at these `ticks`.
    #[inline(always)]
    pub fn offsets_from(
        &self,
        eyes: Vec3x8,
        (tile, first): (&Tile, usize),
        ticks: impl FnOnce() -> [Tick; LANES],
    ) -> Vec3x8 {
        let models = &tile.model[first..first + LANES];
        let mut points = tile.points(first);
        self.each_displaced(models, ticks, |place, of_model| {
            place.points(of_model, |lane| tile.record[first + lane].triangle, &mut points);
        });
        let background = Mask::equal(models, BACKGROUND);
        background.select3(points, points - eyes)
    }

    /// Normals of the triangles of the samples in eight cells of `tile`, from `first` on, at these `ticks`: world space, of any length,
    /// on the sides from which they are seen.
    #[inline(always)]
    pub fn geometric_normals(
        &self,
        (tile, first): (&Tile, usize),
        ticks: impl FnOnce() -> [Tick; LANES],
    ) -> Vec3x8 {
        let mut normals = Octahedral::directions(tile.geometric_normals(first));
        self.each_displaced(&tile.model[first..first + LANES], ticks, |place, of_model| {
            place.geometric_normals(of_model, |lane| tile.record[first + lane].triangle, &mut normals);
        });
        normals
    }

    /// Lines of sight to the samples in eight cells of `tile`, from `first` on: origins, and vectors from there to the samples.
    #[inline(always)]
    pub fn sights(&self, tile: &Tile, first: usize) -> [Vec3x8; 2] {
        let cameras = self.cameras(tile, first);
        let offsets = self.offsets_from(cameras.eye, (tile, first), || tile.ticks(first));
        [cameras.origins(offsets), cameras.sights(offsets)]
    }

    /// Calls `each` for those of eight samples' models that are displaced, with the model's place at the samples' `ticks` and the
    /// mask of its samples that have this place: neighbours mostly share one model.
    #[inline(always)]
    pub fn each_displaced(
        &self,
        models: &[u32],
        ticks: impl FnOnce() -> [Tick; LANES],
        mut each: impl FnMut(Place<'a>, Mask),
    ) {
        let mut left = self.displaced_bits(models);
        if left == 0 {
            return;
        }
        let sweeps = &self.pose.sweeps;
        let groups = if sweeps.is_empty() { [0; LANES] } else { ticks().map(|tick| sweeps.group(tick)) };
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            let model = models[lane];
            let mut of_place = Mask::equal(models, model);
            let transform = match sweeps.of(model as usize) {
                None => &self.pose.models[model as usize],
                Some(places) => {
                    of_place = of_place & Mask::new(|other| groups[other] == groups[lane]);
                    &places[groups[lane]]
                }
            };
            each(self.placed(model, transform), of_place);
            left &= !of_place.bits();
        }
    }

    /// Bit mask of those of eight samples whose models deform, or have an object space that is not world
    /// space.
    #[inline(always)]
    pub fn displaced_bits(&self, models: &[u32]) -> u8 {
        if self.displaced.is_empty() {
            return 0;
        }
        bits_of_models(models, |model| self.displaced.get(model as usize) == Some(&true))
    }

    /// Bit mask of those of eight samples whose models are not there any more.
    #[inline(always)]
    pub fn hidden_bits(&self, models: &[u32]) -> u8 {
        if self.hidden.is_empty() {
            return 0;
        }
        bits_of_models(models, |model| self.hidden.get(model as usize) == Some(&true))
    }

    /// Returns true if rays of this kind do not meet a model.
    #[inline]
    pub fn is_hidden_from(&self, model: u32, kind: RayKind) -> bool {
        self.hides_from_some && !self.scene.models[model as usize].ray_visibility.is_seen_by(kind)
    }

    /// What the eye sees of a model; the background is itself.
    #[inline]
    pub fn role(&self, model: u32) -> Role {
        self.roles.get(model as usize).copied().unwrap_or_default()
    }

    /// Models that rays from the eye through the cells of tile number `number` may meet.
    pub fn in_sight(&self, number: usize) -> SceneSubset {
        if self.dynamic_bounds.may_meet_sweep(&self.view.sights_of_tile(number)) {
            SceneSubset::All
        } else {
            SceneSubset::Still
        }
    }

    /// Returns true if the model of a sample moved since the frame before. The background never does.
    #[inline]
    pub fn moved(&self, model: u32) -> bool {
        self.plan.any_moved && model < EMPTY && self.plan.moved[model as usize]
    }

    /// Bit mask of those of eight cells whose models moved.
    #[inline(always)]
    pub fn moved_bits(&self, models: &[u32]) -> u8 {
        if !self.plan.any_moved {
            return 0;
        }
        bits_of_models(models, |model| self.moved(model))
    }
}
