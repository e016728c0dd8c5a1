//! What every phase of a frame reads.

use glam::Vec3;

use super::motion_vectors::MotionVectors;
use super::moved_bounds::MovedBounds;
use super::place::Place;
use super::plan::Plan;
use super::reflection_maps::ReflectionMaps;
use crate::animation::{Shape, Transform};
use crate::changes::{Motion, Until};
use crate::cryptomatte::Mattes;
use crate::frame::grid::bits::bits_of_models;
use crate::frame::grid::cells::CellSet;
use crate::frame::grid::place;
use crate::frame::grid::view::View;
use crate::frame::grid::wanted::Wanted;
use crate::frame::planes::channels::Channel;
use crate::frame::planes::kernel::Kernel;
use crate::frame::watcher::{Stop, Watcher};
use crate::lanes::{LANES, Mask, Vec3x8};
use crate::layers::Layers;
use crate::pose::Pose;
use crate::samples::{BACKGROUND, EMPTY, TagSlot, Tile};
use crate::scene::{LightGroups, Scene};
use crate::settings::{Budget, Reuse};
use crate::shade::deformed::Deformations;
use crate::shade::emitters::Emitters;
use crate::shade::phong::Palette;
use crate::shade::sampling::{SampleSeed, hash_of};
use crate::shade::sky::SkyLight;
use crate::trace::{NO_HIT, SceneSubset, Tracer};

/// How samples find out how open they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Occlusion {
    /// Of each sample.
    pub rays: u32,
    /// How far they reach, world space.
    pub radius: f32,
    /// Whether ambient light is dimmed by what they find.
    pub dims_ambient: bool,
}

/// The scene in one frame. Built once a frame; no phase writes to it.
#[derive(Clone, Copy)]
pub struct FrameView<'a> {
    /// What there is.
    pub scene: &'a Scene,
    /// What rays see that leave it.
    pub sky: &'a SkyLight,
    /// Surfaces that emit light, if samples gather it.
    pub emitters: &'a Emitters,
    /// Its materials, ready for lighting.
    pub palette: &'a Palette,
    /// Where it is.
    pub pose: &'a Pose,
    /// The models that deform, as they are.
    pub deformations: &'a Deformations,
    /// For each model, whether it stands elsewhere than where its file puts it, or deforms; empty where none does.
    pub displaced: &'a [bool],
    /// For each model, whether it is not there; empty where all are.
    pub hidden: &'a [bool],
    /// How it is seen.
    pub view: &'a View,
    /// Which cells are asked for, in a level of refinement; all, if it is the coarsest.
    pub wanted: Option<&'a Wanted>,
    /// Whether what cells show is noted, for a finer level.
    pub notes_colors: bool,
    /// A hash of the camera's pose.
    pub view_hash: u32,
    /// Where the tags for each light are.
    pub slots: &'a [TagSlot],
    /// For each model whether it is an endless plane.
    pub endless: &'a [bool],
    /// What changed.
    pub plan: &'a Plan,
    /// Boxes around the models that moved since the frame before.
    pub moved_bounds: &'a MovedBounds,
    /// Boxes around all models that move in some frame of the shot.
    pub dynamic_bounds: &'a MovedBounds,
    /// Who answers rays about it.
    pub tracer: &'a dyn Tracer,
    /// What is looked up instead of rays of some models' mirrors and glass.
    pub maps: &'a ReflectionMaps,
    /// Bounces that a ray from the eye may take.
    pub depth: u32,
    /// Rays by which a sample of a rough surface reflects, at most.
    pub reflections: u32,
    /// Paths by which each sample gathers light; 0: it gathers none.
    pub paths: usize,
    /// Those of them that a sample gets at once.
    pub first_paths: usize,
    /// What is spent on the others.
    pub budget: Budget,
    /// Of the frame; a tile's part of the budget is that of its samples in them.
    pub samples: u64,
    /// Surfaces that a path may meet.
    pub bounces: u32,
    /// Whether clear glass casts shadows, and paths alone find the light that comes through it.
    pub finds_caustics: bool,
    /// What a ray or a path may bring by indirect ways, at most; none: whatever it finds. Radiance.
    pub clamp: Option<f32>,
    /// How samples find out how open they are, if they do.
    pub occlusion: Option<Occlusion>,
    /// All motion of the shot, in the direction in which frames are inferred.
    pub motion: &'a Motion,
    /// The same in the other direction, in a frame from which both are taken.
    pub other_motion: Option<&'a Motion>,
    /// For each light, the first later frame in which it changes.
    pub light_changes: &'a [Until],
    /// The first later frame in which any light that has a size changes.
    pub area_light_change: Until,
    /// Whether to trace where reprojection would not pay (`--mode auto`).
    pub chooses: bool,
    /// Which kept samples serve.
    pub reuse: Reuse,
    /// Whether to find out until when rays beyond the first surface bring what they bring, for later frames: the camera rests, and no
    /// light changes in the next frame.
    pub keeps_trees: bool,
    /// The first later frame in which any light changes.
    pub light_change: Until,
    /// What is made of the picture beside its colours.
    pub layers: Layers,
    /// Whether the background is a part of the picture.
    pub shows_background: bool,
    /// Of the frame, if a layer shows motion.
    pub motion_vectors: Option<&'a MotionVectors>,
    /// By which samples become pixels, if it is wider than a pixel.
    pub kernel: Option<Kernel>,
    /// The planes of the picture.
    pub channels: &'a [Channel],
    /// Whose share of the picture has a layer, if any has.
    pub light_groups: &'a LightGroups,
    /// Of the scene, if a layer shows any.
    pub mattes: Option<&'a Mattes>,
    /// The frame's number, counted from the renderer's first.
    pub rendered: u32,
    /// Who wants to know how far the frame is.
    pub watcher: Option<&'a Watcher>,
    /// Who may want no more of it.
    pub stop: Option<&'a Stop>,
}

impl<'a> FrameView<'a> {
    /// The first later frame in which anything that moves touches the segment `origin + t * direction`, t in `0..=far`. In a frame from
    /// which earlier frames are inferred as well: the later frame that is as far away as the nearest one on either side.
    #[inline]
    pub fn first_touch(&self, origin: Vec3, direction: Vec3, far: f32) -> Until {
        let moment = self.pose.moment;
        let until = self.motion.first_touch(origin, direction, far, moment);
        self.other_motion.map_or(until, |other| {
            let other_until = other.first_touch(origin, direction, far, moment);
            until.min(other.to_opposite(other_until, moment, self.motion))
        })
    }

    /// The first later frame in which `model` is elsewhere or has another shape, appears or disappears; counted as in
    /// [`first_touch`](Self::first_touch).
    #[inline]
    pub fn first_change_of(&self, model: u32) -> Until {
        let moment = self.pose.moment;
        let until = self.motion.first_change_of(model, moment);
        self.other_motion.map_or(until, |other| {
            until.min(other.to_opposite(other.first_change_of(model, moment), moment, self.motion))
        })
    }

    /// The same of what a ray has met: never, if that is nothing.
    #[inline]
    pub fn change_of_met(&self, model: u32) -> Until {
        if model == NO_HIT { Until::FOREVER } else { self.first_change_of(model) }
    }

    /// The first later frame in which anything touches a segment, but `before` if that is earlier. What does not hold in the next
    /// frame is not asked about.
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

    /// Whether what holds `until` then does not hold any more.
    #[inline]
    pub fn has_expired(&self, until: Until) -> bool {
        self.motion.has_expired(until, self.pose.moment)
    }

    /// The cells of tile number `number` that are asked for, those beyond the picture's rim perhaps among them.
    #[inline]
    pub fn wanted_of(&self, number: usize) -> &'a CellSet {
        self.wanted.map_or(&CellSet::ALL, |wanted| wanted.tile(number))
    }

    /// The seed of a sample of `model` that is traced anew in a cell of tile number `tile`.
    #[inline]
    pub fn new_seed(&self, tile: usize, cell: usize, model: u32) -> SampleSeed {
        let grid = &self.view.grid;
        let ([left, top], [x, y], samples) = (grid.tile_corner(tile), place(cell), grid.samples as i32);
        let at = [left + x as i32, top + y as i32];
        let (pixel, number) = match samples {
            // without divisions, which take longer than all else here
            1 => (grid.number_of_pixel(at), 0),
            _ => {
                let [x, y] = at.map(|at| at.rem_euclid(samples));
                (grid.number_of_pixel(at.map(|at| at.div_euclid(samples))), y * samples + x)
            }
        };
        let pose = match self.displaced.get(model as usize) {
            Some(true) => {
                hash_of(&self.transform(model).to_world.to_cols_array()) ^ self.hash_of_shape(model)
            }
            _ => 0,
        };
        SampleSeed::new(pixel, number as u32, self.view_hash, pose)
    }

    /// A hash that changes when the shape of a model does; 0 for one that does not deform.
    fn hash_of_shape(&self, model: u32) -> u32 {
        if self.deformations.of_model(model).is_none() {
            return 0;
        }
        let Shape { from, to, share } = self.transform(model).shape;
        hash_of(&[from as f32, to as f32, share as f32])
    }

    /// The map of the model's place.
    pub fn transform(&self, model: u32) -> &'a Transform {
        &self.pose.models[model as usize]
    }

    /// The model's place.
    #[inline(always)]
    pub fn place(&self, model: u32) -> Place<'a> {
        Place::of(self.scene, &self.pose.models, self.deformations, model)
    }

    /// Whether lights shine through a `material` as if it were not there.
    pub fn shines_through(&self, material: u16) -> bool {
        !self.finds_caustics && !self.scene.materials[usize::from(material)].casts_shadow()
    }

    /// From the eye to a sample at `point` of a triangle of `model`: an offset for a surface, a direction for the
    /// background.
    #[inline]
    pub fn offset(&self, point: Vec3, model: u32, triangle: u32) -> Vec3 {
        if model == BACKGROUND {
            return point;
        }
        self.place(model).point(|| triangle, point) - self.view.camera.eye
    }

    /// The same for eight cells of `tile`, from `first` on.
    #[inline(always)]
    pub fn offsets(&self, tile: &Tile, first: usize) -> Vec3x8 {
        let models = &tile.model[first..first + LANES];
        let mut points = tile.points(first);
        self.each_displaced(models, |place, of_model| {
            place.points(of_model, |lane| tile.record[first + lane].triangle, &mut points);
        });
        let background = Mask::equal(models, BACKGROUND);
        background.select3(points, points - Vec3x8::splat(self.view.camera.eye))
    }

    /// Calls `each` with the places of those of eight samples' models that are not where their files put them, and the samples of
    /// each: neighbours are of one model, mostly.
    #[inline(always)]
    pub fn each_displaced(&self, models: &[u32], mut each: impl FnMut(Place<'a>, Mask)) {
        let mut left = self.displaced_bits(models);
        while left != 0 {
            let model = models[left.trailing_zeros() as usize];
            let of_model = Mask::equal(models, model);
            each(self.place(model), of_model);
            left &= !of_model.bits();
        }
    }

    /// Of eight samples' models, those whose object space is not world space, or that deform, a bit each.
    #[inline(always)]
    pub fn displaced_bits(&self, models: &[u32]) -> u8 {
        if self.displaced.is_empty() {
            return 0;
        }
        bits_of_models(models, |model| self.displaced.get(model as usize) == Some(&true))
    }

    /// Of eight samples' models, those that are not there any more, a bit each.
    #[inline(always)]
    pub fn hidden_bits(&self, models: &[u32]) -> u8 {
        if self.hidden.is_empty() {
            return 0;
        }
        bits_of_models(models, |model| self.hidden.get(model as usize) == Some(&true))
    }

    /// What rays from the eye through the cells of tile number `number` may meet.
    pub fn in_sight(&self, number: usize) -> SceneSubset {
        if self.dynamic_bounds.may_meet_sweep(&self.view.sights_of_tile(number)) {
            SceneSubset::All
        } else {
            SceneSubset::Still
        }
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
