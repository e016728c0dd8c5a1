//! Clipping planes that cut nothing off are taken out of cameras: frames whose camera moves take more time with planes, and most files
//! state some beyond which there is nothing.
//!
//! A plane goes only if nothing that is seen reaches over it at any frame. Where that would take long to find out, or is not certain,
//! it stays.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use super::extents::bounds_of_meshes;
use crate::pose::CameraPose;
use crate::scene::camera::{Aim, Lens};
use crate::scene::render_space::RenderSpace;
use crate::scene::{CameraTrack, Mesh, Model};
use crate::settings::Settings;

/// Maximum number of times at which planes are tried.
const MOST_TIMES: f64 = 20_000.0;

/// Maximum number of places of models that move, and of triangles, that are tried.
const MOST_PLACES: usize = 2_000_000;
const MOST_TRIANGLES: usize = 50_000_000;

/// Part of a plane's distance by which things stay away from it: between the times that are tried they move on.
const MARGIN: f64 = 0.01;

/// Factor by which more is looked at than the picture shows: the command line may ask for another shape of it.
const WIDER: f64 = 2.0;

/// What decides, beside the camera, which rays leave the eye.
pub struct Picture {
    /// Width over height.
    aspect: f32,
    /// Distance of eyes from the camera's place, render space.
    aside: f64,
    /// Times in a frame that are tried.
    times_a_frame: f64,
}

impl Picture {
    /// That of these settings.
    pub fn of(settings: &Settings, space: &RenderSpace) -> Self {
        let [width, height] =
            [settings.width, settings.height].map(|side| (side + 2 * settings.overscan) as f32);
        Self {
            aspect: width / height,
            aside: settings.stereo.as_ref().map_or(0.0, |stereo| stereo.separation * space.scale()),
            times_a_frame: if settings.shutter.is_some() { 4.0 } else { 1.0 },
        }
    }
}

/// Takes the planes out of `camera` that cut nothing off of `models`. Both are in the render space.
pub fn without_idle(camera: CameraTrack, models: &[Model], picture: &Picture) -> CameraTrack {
    let Lens { near, far, .. } = &camera.lens;
    if near.is_none() && far.is_none() {
        return camera;
    }
    let Some(times) = times(&camera, models, picture.times_a_frame) else { return camera };
    let seen_at = if camera.is_constant() { &times[..1] } else { &times[..] };
    let views: Vec<View> = seen_at.iter().map(|time| View::new(&camera, *time, picture)).collect();
    let course = Course { times: &times, views: &views };
    let bounds = bounds_of_meshes(models);
    let placed = || models.iter().map(|model| (model, bounds[&Arc::as_ptr(&model.mesh)]));
    let cuts_far = far.is_some() && course.is_cut_far(placed());
    let cuts_near = near.is_some() && course.is_cut_near(placed());
    let Lens { near, far, .. } = camera.lens;
    let lens = Lens { near: near.filter(|_| cuts_near), far: far.filter(|_| cuts_far), ..camera.lens };
    CameraTrack { lens, ..camera }
}

/// Times from the first key to the last: before and after these nothing changes. None: there are too many.
fn times(camera: &CameraTrack, models: &[Model], a_frame: f64) -> Option<Vec<f64>> {
    let moving = models.iter().filter(|model| !model.track.is_constant());
    let keys = moving.flat_map(|model| model.track.key_frames()).chain(key_frames(camera));
    let [first, last] =
        keys.fold([f64::MAX, f64::MIN], |[first, last], frame| [first.min(frame), last.max(frame)]);
    let (first, last) = (first.floor(), last.ceil());
    let count = (last - first) * a_frame + 1.0;
    (count <= MOST_TIMES).then(|| (0..count as u32).map(|i| first + f64::from(i) / a_frame).collect())
}

/// Whole frames from the first key of a shot to the last, as many as are tried; `first` alone where nothing has keys.
pub fn whole_frames(camera: &CameraTrack, models: &[Model], first: i32) -> Vec<f64> {
    let moving = models.iter().filter(|model| !model.track.is_constant());
    let keys = moving.flat_map(|model| model.track.key_frames()).chain(key_frames(camera));
    let [begin, end] =
        keys.fold([f64::from(first); 2], |[begin, end], frame| [begin.min(frame), end.max(frame)]);
    let count = (end.ceil() - begin.floor()).min(MOST_TIMES) as u32;
    (0..=count).map(|i| begin.floor() + f64::from(i)).collect()
}

fn key_frames(camera: &CameraTrack) -> Vec<f64> {
    let Lens { height, shift, aperture, focus, near, far } = &camera.lens;
    let mut frames = camera.eye.frames();
    match &camera.aim {
        Aim::Target { target, roll } => frames.extend(target.frames().chain(roll.frames())),
        Aim::Rotation(rotation) => frames.extend(rotation.frames()),
    }
    let optional = [height, aperture, focus, near, far].into_iter().flatten();
    frames.extend(shift.iter().chain(optional).chain([&camera.fov]).flat_map(|track| track.frames()));
    frames
}

/// What a camera sees at one time, a little more of it.
struct View {
    eye: DVec3,
    forward: DVec3,
    /// Distance from which on things may be cut off.
    far: f64,
    /// What lies nearer than the near plane.
    before: Box,
}

impl View {
    fn new(camera: &CameraTrack, time: f64, picture: &Picture) -> Self {
        let pose = CameraPose::new(camera, time);
        let [eye, forward, right, up] =
            [pose.eye, pose.forward, pose.right, pose.up].map(|vector| vector.as_dvec3());
        let near = f64::from(pose.clip.near) * (1.0 + MARGIN);
        let distance = if pose.is_orthographic() { 1.0 } else { near };
        let aside = picture.aside + camera.lens_at(time).map_or(0.0, |lens| lens.radius);
        let [half, shift] = pose.frustum(picture.aspect);
        let reach = |i: usize| f64::from(half[i] + shift[i].abs()) * WIDER * distance + aside;
        let arms = [right * reach(0), up * reach(1), forward * (0.5 * near)];
        Self {
            eye,
            forward,
            far: f64::from(pose.clip.far) * (1.0 - MARGIN),
            before: Box { center: eye + forward * (0.5 * near), arms },
        }
    }

    /// Greatest distance of a box, along the view axis.
    fn depth(&self, placed: &Box) -> f64 {
        let reach: f64 = placed.arms.iter().map(|arm| arm.dot(self.forward).abs()).sum();
        (placed.center - self.eye).dot(self.forward) + reach
    }
}

/// A box with any axes.
struct Box {
    center: DVec3,
    /// From the centre to three of its sides.
    arms: [DVec3; 3],
}

impl Box {
    fn of((low, high): (DVec3, DVec3)) -> Self {
        let half = (high - low) * 0.5;
        Self { center: low + half, arms: [DVec3::X * half.x, DVec3::Y * half.y, DVec3::Z * half.z] }
    }

    fn placed(&self, map: &DAffine3) -> Self {
        let arms = self.arms.map(|arm| map.transform_vector3(arm));
        Self { center: map.transform_point3(self.center), arms }
    }

    /// The smallest box along the axes around it.
    fn bounds(&self) -> (DVec3, DVec3) {
        let reach = self.arms.iter().fold(DVec3::ZERO, |reach, arm| reach + arm.abs());
        (self.center - reach, self.center + reach)
    }
}

fn joined(a: (DVec3, DVec3), b: (DVec3, DVec3)) -> (DVec3, DVec3) {
    (a.0.min(b.0), a.1.max(b.1))
}

const NOTHING: (DVec3, DVec3) = (DVec3::INFINITY, DVec3::NEG_INFINITY);

/// Returns true if two boxes along the axes meet. Where coordinates are no numbers they do.
fn meet(a: (DVec3, DVec3), b: (DVec3, DVec3)) -> bool {
    !(a.0.cmpgt(b.1) | b.0.cmpgt(a.1)).any()
}

/// The camera over time.
struct Course<'a> {
    times: &'a [f64],
    /// As many as there are times, or one of a camera that is the same at all of them.
    views: &'a [View],
}

impl Course<'_> {
    fn view(&self, time: usize) -> &View {
        &self.views[time.min(self.views.len() - 1)]
    }

    /// Returns true if a model, in a box of this size in its own space, may reach over the far plane.
    fn is_cut_far<'m>(&self, models: impl Iterator<Item = (&'m Model, (DVec3, DVec3))>) -> bool {
        let (resting, moving): (Vec<_>, Vec<_>) = models.partition(|(model, _)| has_one_place(model));
        if moving.len().saturating_mul(self.times.len()) > MOST_PLACES {
            return true;
        }
        let is_cut = |view: &View, placed: &Box| view.depth(placed) > view.far;
        let resting: Vec<Box> = resting
            .into_iter()
            .map(|(model, bounds)| Box::of(bounds).placed(&model.track.map_at(0.0)))
            .collect();
        let all = Box::of(resting.iter().map(Box::bounds).fold(NOTHING, joined));
        let cut_resting = || {
            let beyond = self.views.par_iter().filter(|view| is_cut(view, &all));
            beyond.any(|view| resting.iter().any(|placed| is_cut(view, placed)))
        };
        let cut_moving = || {
            moving.par_iter().any(|(model, bounds)| {
                let placed = |time: f64| Box::of(*bounds).placed(&model.track.map_at(time));
                self.times.iter().enumerate().any(|(i, time)| is_cut(self.view(i), &placed(*time)))
            })
        };
        !resting.is_empty() && cut_resting() || cut_moving()
    }

    /// Returns true if a model may reach over the near plane, where the camera would see it.
    fn is_cut_near<'m>(&self, models: impl Iterator<Item = (&'m Model, (DVec3, DVec3))>) -> bool {
        let everywhere = self.views.iter().map(|view| view.before.bounds()).fold(NOTHING, joined);
        let (resting, moving): (Vec<_>, Vec<_>) = models.partition(|(model, _)| has_one_place(model));
        if moving.len().saturating_mul(self.times.len()) > MOST_PLACES {
            return true;
        }
        let cut_resting = resting.into_iter().any(|(model, bounds)| {
            let map = model.track.map_at(0.0);
            if !meet(Box::of(bounds).placed(&map).bounds(), everywhere) {
                return false;
            }
            let inverse = map.inverse();
            let before = self.views.iter().map(|view| view.before.placed(&inverse).bounds());
            reaches_into(&model.mesh, before.filter(|before| meet(*before, bounds)).collect())
        });
        cut_resting
            || moving.into_iter().any(|(model, bounds)| {
                let before = self.times.iter().enumerate().map(|(i, time)| {
                    self.view(i).before.placed(&model.track.map_at(*time).inverse()).bounds()
                });
                reaches_into(&model.mesh, before.filter(|before| meet(*before, bounds)).collect())
            })
    }
}

fn has_one_place(model: &Model) -> bool {
    let track = &model.track;
    let place = [&track.translate, &track.rotate, &track.scale];
    place.into_iter().all(|track| track.is_constant())
        && track.matrix.as_ref().is_none_or(|matrix| matrix.is_constant())
}

/// Returns true if a mesh reaches into one of `boxes`, in its own space, which are in the box around it.
fn reaches_into(mesh: &Mesh, boxes: Vec<(DVec3, DVec3)>) -> bool {
    if boxes.is_empty() {
        return false;
    }
    // vertices are elsewhere in each shape
    let Some(triangles) = mesh.as_triangles().filter(|all| all.shapes.is_none()) else { return true };
    let all = boxes.iter().copied().fold(NOTHING, joined);
    let corners = |triangle: u32| triangles.positions_of(triangle).map(|corner| corner.as_dvec3());
    let around = |corners: [DVec3; 3]| corners.into_iter().map(|at| (at, at)).fold(NOTHING, joined);
    let every = (0..triangles.corners.len() as u32).into_par_iter();
    let near: Vec<[DVec3; 3]> = every.map(corners).filter(|corners| meet(around(*corners), all)).collect();
    if near.len().saturating_mul(boxes.len()) > MOST_TRIANGLES {
        return true;
    }
    near.par_iter().any(|corners| {
        let own = around(*corners);
        boxes.iter().any(|each| meet(own, *each) && is_on_both_sides(*corners, *each))
    })
}

/// Returns true if a box is on both sides of a triangle's plane.
fn is_on_both_sides([a, b, c]: [DVec3; 3], (low, high): (DVec3, DVec3)) -> bool {
    let normal = (b - a).cross(c - a);
    let half = (high - low) * 0.5;
    (normal.dot(a - low - half)).abs() <= normal.abs().dot(half)
}
