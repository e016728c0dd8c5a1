//! How large the cameras of a shot see things at their nearest.

use std::ops::Range;

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use crate::pose::CameraPose;
use crate::scene::cage::Cage;
use crate::scene::{CameraTrack, Model};

/// Maximum number of times of a shot at which things are measured: cameras go little between more of them.
const MOST_TIMES: usize = 128;

/// Maximum number of measurements of a mesh: one is of a part of it, at a place, at a time.
const MOST_MEASUREMENTS: usize = 2_000_000;

/// Number of consecutive faces that are measured as one, in large cages.
const BLOCK: usize = 32;

/// Number of faces from which on a cage is large.
const LARGE: usize = 2048;

/// Factor on the size of what is outside of the picture, and seen in mirrors and by its shadow alone.
const ASIDE: f64 = 0.25;

/// Part of the picture around it that counts as inside.
const MARGIN: f64 = 0.1;

/// Part of a box's half diagonal that is the least distance at which it is seen.
const LEAST_DISTANCE: f64 = 0.25;

/// The cameras of a shot at its times, in the space of its files.
#[derive(Debug)]
pub(crate) struct Views {
    times: Vec<(f64, CameraPose)>,
    /// Width over height of the picture.
    aspect: f32,
    /// Height of the picture, pixels.
    height: f64,
}

/// Box around a part of a cage.
#[derive(Clone, Copy)]
struct Around {
    middle: DVec3,
    /// From the middle to three of its sides.
    arms: [DVec3; 3],
}

impl Around {
    fn placed(self, map: &DAffine3) -> Self {
        Self {
            middle: map.transform_point3(self.middle),
            arms: self.arms.map(|arm| map.transform_vector3(arm)),
        }
    }

    /// How far it reaches along an axis from its middle.
    fn reach(&self, axis: DVec3) -> f64 {
        self.arms.iter().map(|arm| arm.dot(axis).abs()).sum()
    }
}

impl Views {
    /// Views of a camera at these times, in pictures of this size in pixels.
    pub fn new(camera: &CameraTrack, times: &[f64], [width, height]: [u32; 2]) -> Self {
        let step = times.len().div_ceil(MOST_TIMES).max(1);
        let last = times.last().into_iter().filter(|_| (times.len() - 1) % step != 0);
        let kept = times.iter().step_by(step).chain(last);
        let mut views: Vec<(f64, CameraPose)> =
            kept.map(|time| (*time, CameraPose::new(camera, *time))).collect();
        views.dedup_by(|a, b| a == b);
        Self { times: views, aspect: width as f32 / height as f32, height: height.into() }
    }

    /// Pixels that a unit of a mesh's object space is long at most, for each face of its cage, in all places that the mesh has.
    pub fn pixels_of_faces(&self, cage: &Cage, models: &[&Model]) -> Vec<f64> {
        let faces = cage.counts.len();
        let is_constant = models.iter().all(|model| model.track.is_constant()) && self.is_constant();
        let times = if is_constant { &self.times[..1] } else { &self.times[..] };
        let mut block = if faces > LARGE { BLOCK } else { 1 };
        let mut step = 1;
        while faces.div_ceil(block) * models.len() * times.len().div_ceil(step) > MOST_MEASUREMENTS {
            // one after the other, until whole meshes are measured at one time
            if block < faces {
                block = (block * 4).min(faces);
            } else if step < times.len() {
                step *= 2;
            } else {
                break;
            }
        }
        let parts = parts(cage, block);
        let pixels = |part: &Around| {
            let at_all = times.iter().step_by(step).flat_map(|(time, pose)| {
                models.iter().map(move |model| {
                    let map = model.track.map_at(*time);
                    let scale = [map.x_axis, map.y_axis, map.z_axis].map(DVec3::length);
                    let scale = scale.into_iter().fold(0.0, f64::max);
                    self.pixels(pose, &part.placed(&map)) * scale
                })
            });
            at_all.filter(|pixels| pixels.is_finite()).fold(0.0, f64::max)
        };
        let of_blocks: Vec<f64> = parts.par_iter().map(pixels).collect();
        (0..faces).map(|face| of_blocks[face / block]).collect()
    }

    fn is_constant(&self) -> bool {
        self.times.windows(2).all(|pair| pair[0].1 == pair[1].1)
    }

    /// Pixels that a unit of world space is long at most within a box.
    fn pixels(&self, pose: &CameraPose, part: &Around) -> f64 {
        let [eye, forward, right, up] =
            [pose.eye, pose.forward, pose.right, pose.up].map(|vector| vector.as_dvec3());
        let offset = part.middle - eye;
        let radius = part.arms.iter().map(|arm| arm.length_squared()).sum::<f64>().sqrt();
        let (depth, reach) = (offset.dot(forward), part.reach(forward));
        let [half, center] = pose.frustum(self.aspect).map(|pair| pair.map(f64::from));
        let at_one = self.height / (2.0 * half[1]);
        let distance = if pose.is_orthographic() { 1.0 } else { depth };
        let is_within = |axis: DVec3, i: usize| {
            let wide = half[i] * (1.0 + MARGIN);
            let slope = if pose.is_orthographic() { 1.0 } else { (wide * wide + 1.0).sqrt() };
            (offset.dot(axis) - center[i] * distance).abs() <= wide * distance.max(0.0) + radius * slope
        };
        let is_seen = depth + reach > 0.0 && is_within(right, 0) && is_within(up, 1);
        let factor = if is_seen { 1.0 } else { ASIDE };
        if pose.is_orthographic() {
            return at_one * factor;
        }
        let nearest = if is_seen {
            (depth - reach).max(radius * LEAST_DISTANCE)
        } else {
            (offset.length() - radius).max(radius)
        };
        at_one * factor / nearest
    }
}

/// Boxes around so many consecutive faces of a cage each, in all of its shapes.
fn parts(cage: &Cage, block: usize) -> Vec<Around> {
    let mut end = 0;
    let parts = cage.counts.chunks(block).map(|counts| {
        let begin = end;
        end += counts.iter().map(|count| *count as usize).sum::<usize>();
        begin..end
    });
    let parts: Vec<Range<usize>> = parts.collect();
    let around = |corners: &Range<usize>| {
        let shapes = cage.shapes.iter().chain([&cage.points]);
        let all = shapes.flat_map(|points| {
            cage.corners[corners.clone()]
                .iter()
                .map(move |point| Vec3::from(points[*point as usize]).as_dvec3())
        });
        let (low, high) =
            all.fold((DVec3::MAX, DVec3::MIN), |(low, high), point| (low.min(point), high.max(point)));
        let half = (high - low) * 0.5;
        Around { middle: low + half, arms: [DVec3::X * half.x, DVec3::Y * half.y, DVec3::Z * half.z] }
    };
    parts.par_iter().map(around).collect()
}
