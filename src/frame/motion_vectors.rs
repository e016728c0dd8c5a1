//! Motion vectors: how far in the picture a pixel's point was in the frame before, and will be in the next.
//!
//! Exact from the poses of the shot, as samples are: both cameras project the point of the model. Frames are those of the shot,
//! whatever frames a run renders. Across a cut nothing moves.

use glam::{Vec2, Vec3};

use super::moved_bounds::ModelSet;
use super::view::View;
use crate::animation::Transform;
use crate::layers::Layers;
use crate::pose::Pose;
use crate::samples::BACKGROUND;
use crate::scene::Scene;
use crate::stereo::EyePlace;

/// Motion about one frame. Built once a frame, where a layer shows it.
#[derive(Debug)]
pub struct MotionVectors {
    /// The frame before and the next one.
    beside: [Beside; 2],
    /// Whether vectors may be others than in the frame rendered before, whatever the model.
    all_differ: bool,
    /// The models whose vectors may be.
    differing: ModelSet,
}

/// A frame beside this one.
#[derive(Debug)]
enum Beside {
    /// Camera and models are where they are in this one.
    Same,
    /// It belongs to another take.
    Cut,
    /// They are elsewhere.
    Moved { view: View, models: Vec<Transform> },
}

impl MotionVectors {
    /// About the frame of `pose`, which is seen as `view` says, by `eye` if there are two, and of which `last` was rendered
    /// before. None where no layer of `layers` shows them.
    pub fn about(
        scene: &Scene,
        (pose, view): (&Pose, &View),
        eye: Option<&EyePlace>,
        layers: Layers,
        last: Option<&Pose>,
    ) -> Option<Self> {
        if !layers.has(Layers::ALL_MOTION) {
            return None;
        }
        let near = Neighbours::of(scene, pose.frame, eye);
        let (mut all_differ, mut differing) = (true, ModelSet::default());
        if let Some(last) = last {
            let near_last = Neighbours::of(scene, last.frame, eye);
            let three =
                |near: &'_ Neighbours, pose: &'_ Pose| [near.before.camera, pose.camera, near.after.camera];
            all_differ = near.cuts != near_last.cuts || three(&near, pose) != three(&near_last, last);
            let differs = |model: &u32| {
                let three = |near: &Neighbours, pose: &Pose| {
                    [&near.before, pose, &near.after].map(|pose| pose.models[*model as usize])
                };
                three(&near, pose) != three(&near_last, last)
            };
            differing = ModelSet::of(&(0..pose.models.len() as u32).filter(differs).collect::<Vec<u32>>());
        }
        let Neighbours { before, after, cuts } = near;
        let beside = |other: Pose, is_cut: bool| {
            let moves = other.camera != pose.camera || other.models != pose.models;
            match (is_cut, moves) {
                (true, _) => Beside::Cut,
                (false, false) => Beside::Same,
                _ => Beside::Moved { view: View::new(&view.grid, other.camera), models: other.models },
            }
        };
        Some(Self { beside: [beside(before, cuts[0]), beside(after, cuts[1])], all_differ, differing })
    }

    /// Whether vectors of samples of any of `models` may be others than in the frame rendered before. A `false` is certain.
    pub fn may_differ(&self, models: ModelSet) -> bool {
        self.all_differ || self.differing.may_share(models)
    }

    /// Whether nothing moves from the frame before to this one, and from this one to the next.
    pub fn is_at_rest(&self) -> [bool; 2] {
        self.beside.each_ref().map(|beside| matches!(beside, Beside::Same))
    }

    /// From where a point of `model` (object space; of the background, a direction) is seen to where it was and will be seen:
    /// pixels, x to the right and y upwards. `offset`: from the eye to it. `None` where that is not known: across a cut, where
    /// either place is behind the eye, of a model that is not there in the other frame, and for the background of an orthographic
    /// camera that moves, which has no place.
    pub fn of(&self, view: &View, offset: Vec3, point: Vec3, model: u32) -> [Option<Vec2>; 2] {
        let here = view.project_one(offset).map(Vec3::truncate);
        let per_pixel = (view.grid.samples as f32).recip();
        self.beside.each_ref().map(|beside| match beside {
            Beside::Same => Some(Vec2::ZERO),
            Beside::Cut => None,
            Beside::Moved { view, models } => {
                let there = seen(view, models, point, model)?;
                Some((there - here?) * Vec2::new(per_pixel, -per_pixel))
            }
        })
    }
}

/// Where a point of `model` (object space; of the background, a direction) is seen, in cells. `None` behind the eye, for
/// the background of an orthographic view, and for a model that is not there.
fn seen(view: &View, models: &[Transform], point: Vec3, model: u32) -> Option<Vec2> {
    let offset = match model {
        BACKGROUND if view.camera.is_orthographic() => return None,
        BACKGROUND => point,
        _ if !models[model as usize].is_visible => return None,
        _ => models[model as usize].point(point) - view.camera.eye,
    };
    view.project_one(offset).map(Vec3::truncate)
}

/// What is beside a frame of the shot.
struct Neighbours {
    before: Pose,
    after: Pose,
    /// Whether the shot cuts between the frame and the one before, and the next one.
    cuts: [bool; 2],
}

impl Neighbours {
    fn of(scene: &Scene, frame: i32, eye: Option<&EyePlace>) -> Self {
        let (before, after) = (frame.saturating_sub(1), frame.saturating_add(1));
        let cuts = [frame, after].map(|first| scene.camera.cuts.contains(&first));
        let [before, after] = [before, after].map(|frame| Pose::seen_from(scene, frame, eye));
        Self { before, after, cuts }
    }
}
