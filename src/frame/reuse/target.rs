//! The rule by which a sample may serve a cell: *a cell shows a sample of the surface that its target sees*.
//!
//! The target is the cell's centre; what it sees is what a ray from the eye through it meets first. A sample shows the same
//! surface if it is of the same model and material, on the same side, and on the same *layer*: no further from the tangent plane at
//! the point that was met than a share of a cell's width there ([`LAYER`]), that point no further from the tangent plane at the
//! sample, and the two planes about parallel ([`ABOUT_PARALLEL`]). (By one of the planes alone, faces that are seen at an angle would lose
//! cells to those beside them, frame by frame; and where a face is narrower than a layer, as a bevel is that is seen from afar, it is the
//! angle that tells it from its neighbours.) Lengths are measured in cells, so that slats before a wall are told from the wall whenever
//! anybody could see that they are apart, however far away they are.
//!
//! So surfaces have the cells whose targets they cover, as in a frame that is traced in full, however small they are, however long a
//! chain of inferred frames is, and however densely they happen to be sampled.

use glam::Vec3;

use crate::exposure::Tick;
use crate::frame::shot::frame_view::FrameView;
use crate::samples::{BACKGROUND, Sample};
use crate::scene::Mesh;
use crate::shade::surface::geometric_normal_of;
use crate::trace::Hit;

/// Largest distance of a sample from the tangent plane of what a target sees, as a share of a cell's width there: where a layer ends,
/// the picture of what lies this much behind it is wrong by no more than this share of a cell, from whatever side it is seen.
pub const LAYER: f32 = 0.25;

/// Least cosine of the angle between the normals of a sample and of what a target sees: 26 degrees, so that curved meshes keep samples, and
/// what is kept has the light of what is seen within a tenth.
pub const ABOUT_PARALLEL: f32 = 0.9;

/// What a cell's target sees.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Index into [`Scene::models`](crate::scene::Scene::models), or [`BACKGROUND`].
    model: u32,
    triangle: u32,
    /// Index into [`Scene::materials`](crate::scene::Scene::materials).
    material: u16,
    /// True if the mesh is not made of triangles.
    is_curved: bool,
    is_from_behind: bool,
    /// Tick of the exposure at which the cell sees it.
    tick: Tick,
    /// From the eye at that tick to the point that was met, world space.
    offset: Vec3,
    /// Normal of the surface there, world space, unit length; zero where it has none.
    normal: Vec3,
    /// Thickness of the layer, to either side: world units.
    layer: f32,
}

impl Seen {
    /// Finds what was seen along `origin + t * direction` at a `tick` of the exposure, from the hit of that ray.
    pub fn new(frame: &FrameView, [origin, direction]: [Vec3; 2], tick: Tick, hit: Option<Hit>) -> Self {
        let Some(Hit { t, u, v, model, triangle }) = hit else {
            return Self {
                model: BACKGROUND,
                triangle: 0,
                material: 0,
                is_curved: false,
                is_from_behind: false,
                tick,
                offset: direction,
                normal: Vec3::ZERO,
                layer: 0.0,
            };
        };
        let mesh: &Mesh = &frame.scene.models[model as usize].mesh;
        let way = t * direction;
        let in_object = geometric_normal_of(mesh, triangle, [u, v]);
        let normal = frame.place(model, tick).geometric_normal(triangle, in_object).normalize_or_zero();
        let spread = frame.view.spread();
        Self {
            model,
            triangle,
            material: mesh.material_of[triangle as usize],
            is_curved: mesh.is_curved(),
            is_from_behind: normal.dot(direction) > 0.0,
            tick,
            offset: origin - frame.view.eye(tick) + way,
            normal,
            layer: LAYER * (spread.by_distance * way.length() + spread.fixed),
        }
    }

    /// Returns true if a sample shows this surface.
    pub fn is_shown_by(&self, frame: &FrameView, sample: &Sample) -> bool {
        let Sample { model, record, .. } = sample;
        if *model != self.model || *model == BACKGROUND {
            return *model == self.model;
        }
        if record.triangle == self.triangle {
            // a plane has one side towards the eye, and rounding alone may say otherwise
            return !self.is_curved || record.is_from_behind() == self.is_from_behind;
        }
        if record.is_from_behind() != self.is_from_behind || record.material != self.material {
            return false;
        }
        // where the sample is when the target looks
        let apart = frame.offset_of(sample, self.tick) - self.offset;
        apart.dot(self.normal).abs() <= self.layer && {
            let kept = record.geometric_normal.unfold();
            let normal = frame.place(*model, self.tick).geometric_normal(record.triangle, kept);
            let length = normal.length();
            // kept normals are on the side of the eye
            let towards_eye = if self.is_from_behind { -self.normal } else { self.normal };
            apart.dot(normal).abs() <= self.layer * length
                && normal.dot(towards_eye) >= ABOUT_PARALLEL * length
        }
    }
}
