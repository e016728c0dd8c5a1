//! Scenes that instances place: built once, or anew for each shape of a model that deforms.

use std::sync::Arc;

use embree::{BuildQuality, Device, FrozenScene, Geometry, GeometryId, Scene as EmbreeScene, VertexBuffer};
use glam::Vec3;

use super::mask;
use super::pieces::Pieces;
use crate::animation::Shape;
use crate::geometry::Bounds;
use crate::pose::Pose;
use crate::scene::{Mesh, Shapes};
use crate::trace::TraceError;

/// Flag of all scenes, so that closed surfaces have no cracks: without it a few rays slip between two
/// triangles that share an edge and show what is behind them, and the audit rightly complains.
pub const ROBUST: bool = true;

/// A mesh's own scene.
pub struct Frozen {
    pub scene: Arc<FrozenScene>,
    /// First triangle by geometry id.
    pub firsts: [u32; 2],
    /// Scene of the triangles that cast shadows, if it is wanted and there are any.
    pub casters: Option<Arc<FrozenScene>>,
}

/// Builds the scene of `mesh` with its vertices at `positions`.
pub fn freeze(
    device: &Device,
    mesh: &Mesh,
    positions: &Arc<VertexBuffer>,
    quality: BuildQuality,
    with_casters: bool,
) -> Result<Frozen, TraceError> {
    let mut scene = EmbreeScene::new(device, quality, ROBUST)?;
    let mut firsts = [0; 2];
    let halves = geometries_of(device, mesh, positions)?;
    for (_, (geometry, first)) in &halves {
        let GeometryId(id) = scene.attach(geometry)?;
        firsts[id as usize] = *first;
    }
    let spacer = if mesh.quadric.is_none() { spacer(device, positions)? } else { None };
    if let Some(spacer) = &spacer {
        scene.attach(spacer)?;
    }
    let scene = scene.freeze()?;
    let casters = match halves.as_slice() {
        [(CASTS_SHADOW, _)] if with_casters => Some(Arc::clone(&scene)),
        [(CASTS_SHADOW, (geometry, _)), _] if with_casters => {
            let mut casters = EmbreeScene::new(device, quality, ROBUST)?;
            casters.attach(geometry)?;
            if let Some(spacer) = &spacer {
                casters.attach(spacer)?;
            }
            Some(casters.freeze()?)
        }
        _ => None,
    };
    Ok(Frozen { scene, firsts, casters })
}

/// Least thickness of a mesh, relative to its extent; a flatter one gets a [`spacer`] of this size.
const FLAT: f32 = 1e-4;

/// Creates a geometry that gives a mesh that is flat along an axis a box that is not: a triangle without an
/// area, which no ray meets.
///
/// Among instances Embree tests the boxes of coherent packets all at once, in a way that is not conservative
/// whatever the scene's flags: where rays are nearly parallel (an orthographic camera's, refracted) the
/// nearest and the farthest distance to a box without thickness differ by less than rounding, and the whole
/// packet misses it (Embree 4.4, `kernels/bvh/node_intersector_frustum.h`).
fn spacer(device: &Device, positions: &Arc<VertexBuffer>) -> Result<Option<Geometry>, TraceError> {
    let corners = positions.as_slice().iter().map(|at| Vec3::from_array(*at));
    let around = corners.fold(Bounds::EMPTY, Bounds::with);
    let extent = around.high - around.low;
    let least = FLAT * extent.max_element();
    if around.is_empty() || extent.min_element() >= least {
        return Ok(None);
    }
    let reach = Vec3::from_array(extent.to_array().map(|along| if along < least { least } else { 0.0 }));
    let middle = (around.low + around.high) * 0.5;
    let ends = Arc::new(VertexBuffer::new(vec![(middle - reach).to_array(), (middle + reach).to_array()]));
    Ok(Some(Geometry::triangles(device, ends, Arc::new(vec![[0, 1, 1]]), mask::HIDDEN)?))
}

/// Number of the half of a mesh that casts shadows; the other one is clear.
pub const CASTS_SHADOW: usize = 0;

/// Half of a mesh: its number, its geometry and its first triangle.
pub type Half = (usize, (Geometry, u32));

/// Geometries of `mesh` that have triangles, with its vertices at `positions`.
pub fn geometries_of(
    device: &Device,
    mesh: &Mesh,
    positions: &Arc<VertexBuffer>,
) -> Result<Vec<Half>, TraceError> {
    let (all, split) = (&mesh.triangles, mesh.shadow_casting);
    if let Some(quadric) = &mesh.quadric {
        let (half, mask) =
            if split > 0 { (CASTS_SHADOW, mask::CASTS_SHADOW) } else { (1 - CASTS_SHADOW, mask::CLEAR) };
        let pieces = Arc::new(Pieces(Arc::clone(quadric)));
        return Ok(vec![(half, (Geometry::primitives(device, pieces, mask)?, 0))]);
    }
    let ranges = [(0..split, mask::CASTS_SHADOW), (split..all.len(), mask::CLEAR)];
    let mut halves = Vec::new();
    for (half, (range, mask)) in ranges.into_iter().enumerate() {
        if range.is_empty() {
            continue;
        }
        let first = range.start as u32;
        let triangles =
            if range.len() == all.len() { Arc::clone(all) } else { Arc::new(all[range].to_vec()) };
        let geometry = Geometry::triangles(device, Arc::clone(positions), triangles, mask)?;
        halves.push((half, (geometry, first)));
    }
    Ok(halves)
}

/// Model whose scene is built anew for each of its shapes.
pub struct Deforming {
    model: usize,
    mesh: Arc<Mesh>,
    /// Instances among all movable models, and among those that cast shadows, if it has one there.
    instances: [Option<GeometryId>; 2],
    /// Shape of its scenes.
    shape: Shape,
}

impl Deforming {
    /// Creates model number `model`, with its scenes in the first of its shapes.
    pub fn new(
        device: &Device,
        model: usize,
        mesh: &Arc<Mesh>,
        with_casters: bool,
    ) -> Result<(Self, Frozen), TraceError> {
        let shape = Shape::FIRST;
        let deforming = Self { model, mesh: Arc::clone(mesh), instances: [None; 2], shape };
        let frozen = deforming.freeze(device, with_casters)?;
        Ok((deforming, frozen))
    }

    /// Sets the instances that place the model.
    pub fn placed(self, instances: [Option<GeometryId>; 2]) -> Self {
        Self { instances, ..self }
    }

    /// Builds the scenes of the present shape. Nothing of the scenes before is kept, and none is refitted:
    /// frames do not depend on which others were rendered.
    fn freeze(&self, device: &Device, with_casters: bool) -> Result<Frozen, TraceError> {
        let of_shape = |shapes: &Arc<Shapes>| Arc::new(VertexBuffer::new(shapes.positions(&self.shape)));
        let positions = self.mesh.shapes.as_ref().map_or_else(|| Arc::clone(&self.mesh.positions), of_shape);
        freeze(device, &self.mesh, &positions, BuildQuality::Low, with_casters)
    }

    /// Builds the model's scenes anew if it has another shape in `pose`, and is there.
    pub fn deform(
        &mut self,
        device: &Device,
        movable: &mut EmbreeScene,
        casters: Option<&mut EmbreeScene>,
        pose: &Pose,
    ) -> Result<(), TraceError> {
        let place = &pose.models[self.model];
        if !place.is_visible || place.shape == self.shape {
            return Ok(());
        }
        self.shape = place.shape;
        let frozen = self.freeze(device, casters.is_some())?;
        let scenes =
            [Some((movable, Some(&frozen.scene))), casters.map(|scene| (scene, frozen.casters.as_ref()))];
        for (id, scenes) in self.instances.into_iter().zip(scenes) {
            if let (Some(id), Some((scene, Some(of)))) = (id, scenes) {
                scene.set_instance_scene(id, of)?;
            }
        }
        Ok(())
    }
}
