//! Motion vectors: offsets in the picture from a pixel's point to its place in the frame before and in the
//! next.
//!
//! They are exact, from the poses of the shot, as samples are: both cameras project the point of the model.
//! Frames are those of the shot, whatever frames a run renders. There are no vectors across a cut.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::moved_bounds::ModelSet;
use super::place::Place;
use crate::animation::Transform;
use crate::frame::grid::Grid;
use crate::frame::grid::view::View;
use crate::pose::{CameraPose, Pose};
use crate::samples::BACKGROUND;
use crate::scene::Scene;
use crate::shade::deformed::Deformations;
use crate::stereo::EyePlace;

/// Motion vectors of one frame. Built once a frame, if a layer shows them.
#[derive(Debug)]
pub struct MotionVectors {
    /// The frame itself, at its own time, whatever time and point of the lens a sample was seen at.
    own: Seen,
    /// Frame before and next frame.
    beside: [Beside; 2],
    /// True if vectors of any model may differ from those in the frame rendered before.
    all_differ: bool,
    /// Models whose vectors may differ.
    differing: ModelSet,
}

/// Camera and models of a frame.
#[derive(Debug)]
struct Seen {
    view: View,
    models: Vec<Transform>,
    deformations: Deformations,
}

/// Neighbour of this frame in time.
#[derive(Debug)]
enum Beside {
    /// Camera and models are as in this frame.
    Same,
    /// The frame belongs to another take.
    Cut,
    /// Camera or models are elsewhere.
    Moved(Seen),
}

impl MotionVectors {
    /// Computes the motion about `frame` through `grid`. `eye` is the eye that sees it, if there are two;
    /// frame `last` was rendered before, if any was.
    pub fn about(
        scene: &Scene,
        frame: i32,
        grid: &Arc<Grid>,
        eye: Option<&EyePlace>,
        last: Option<i32>,
    ) -> Self {
        let near = Neighbours::new(scene, frame, eye);
        let (mut all_differ, mut differing) = (true, ModelSet::default());
        if let Some(last) = last {
            let near_last = Neighbours::new(scene, last, eye);
            all_differ = near.cuts != near_last.cuts || near.cameras() != near_last.cameras();
            let differs = |model: &u32| near.places_of(*model) != near_last.places_of(*model);
            let models = 0..near.all[1].models.len() as u32;
            differing = ModelSet::new(&models.filter(differs).collect::<Vec<u32>>());
        }
        let Neighbours { all: [before, own, after], cuts } = near;
        let seen = |pose: Pose| {
            let deformations = Deformations::new(scene, &pose.models, false);
            Seen { view: View::new(grid, pose.camera), models: pose.models, deformations }
        };
        let beside = |other: Pose, is_cut: bool| {
            let moves = other.camera != own.camera || other.models != own.models;
            match (is_cut, moves) {
                (true, _) => Beside::Cut,
                (false, false) => Beside::Same,
                _ => Beside::Moved(seen(other)),
            }
        };
        let beside = [beside(before, cuts[0]), beside(after, cuts[1])];
        Self { beside, own: seen(own), all_differ, differing }
    }

    /// Returns true if vectors of samples of any of `models` may differ from those in the frame rendered
    /// before. A `false` is certain.
    pub fn may_differ(&self, models: ModelSet) -> bool {
        self.all_differ || self.differing.may_share(models)
    }

    /// Returns true where nothing moves: from the frame before to this one, and from this one to the next.
    pub fn is_at_rest(&self) -> [bool; 2] {
        self.beside.each_ref().map(|beside| matches!(beside, Beside::Same))
    }

    /// Motion vectors of a point of a triangle of `model` (object space; of the background, a direction):
    /// from its place in this frame to those in the frame before and in the next, in pixels, x to the right
    /// and y upwards. `None` where a place is not known: across a cut, behind the eye, of a model that is not
    /// there in the other frame, and for the background of an orthographic camera that moves.
    pub fn of(&self, scene: &Scene, point: Vec3, (model, triangle): (u32, u32)) -> [Option<Vec2>; 2] {
        let here = self.own.sees(scene, point, (model, triangle));
        let per_pixel = (self.own.view.grid.samples as f32).recip();
        self.beside.each_ref().map(|beside| match beside {
            Beside::Same => Some(Vec2::ZERO),
            Beside::Cut => None,
            // the camera rests, so that the background does, whatever else moves; in an orthographic view it
            // has no place to compute that from
            Beside::Moved(seen) if model == BACKGROUND && seen.view.camera == self.own.view.camera => {
                Some(Vec2::ZERO)
            }
            Beside::Moved(seen) => {
                let there = seen.sees(scene, point, (model, triangle))?;
                Some((there - here?) * Vec2::new(per_pixel, -per_pixel))
            }
        })
    }
}

impl Seen {
    /// Place of a point of a triangle of `model` (object space; of the background, a direction), in cells.
    /// `None` behind the eye, for the background of an orthographic view, and for a model that is not there.
    fn sees(&self, scene: &Scene, point: Vec3, (model, triangle): (u32, u32)) -> Option<Vec2> {
        let Self { view, models, deformations } = self;
        let offset = match model {
            BACKGROUND if view.camera.is_orthographic() => return None,
            BACKGROUND => point,
            _ if !models[model as usize].is_visible => return None,
            _ => {
                let place = Place::of(scene, &models[model as usize], deformations, model);
                place.point(|| triangle, point) - view.camera.eye
            }
        };
        view.project_one(offset, 0).map(Vec3::truncate)
    }
}

/// A frame of the shot, between the one before and the next one.
struct Neighbours {
    all: [Pose; 3],
    /// True where the shot cuts: between the frame and the one before, and between it and the next one.
    cuts: [bool; 2],
}

impl Neighbours {
    fn new(scene: &Scene, frame: i32, eye: Option<&EyePlace>) -> Self {
        let (before, after) = (frame.saturating_sub(1), frame.saturating_add(1));
        let cuts = [frame, after].map(|first| scene.camera.cuts.contains(&first));
        let all = [before, frame, after].map(|frame| Pose::seen_from(scene, frame, eye));
        Self { all, cuts }
    }

    fn cameras(&self) -> [CameraPose; 3] {
        self.all.each_ref().map(|pose| pose.camera)
    }

    fn places_of(&self, model: u32) -> [Transform; 3] {
        self.all.each_ref().map(|pose| pose.models[model as usize])
    }
}
