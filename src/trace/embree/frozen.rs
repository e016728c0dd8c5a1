//! Scenes that instances place: built once, or anew for each shape of a model that deforms.

use std::sync::Arc;

use embree::{BuildQuality, Device, FrozenScene, Geometry, GeometryId, Scene as EmbreeScene, VertexBuffer};
use glam::Vec3;

use super::mask;
use super::pieces::Pieces;
use crate::animation::Shape;
use crate::geometry::Bounds;
use crate::pose::Pose;
use crate::scene::cutout::{Asks, CutoutTest};
use crate::scene::{Mesh, RayKinds, Shapes};
use crate::trace::TraceError;

/// Flag of all scenes, so that closed surfaces have no cracks: without it a few rays slip between two
/// triangles that share an edge and show what is behind them, and the audit rightly complains.
pub const ROBUST: bool = true;

/// A mesh's own scene.
pub struct Frozen {
    pub scene: Arc<FrozenScene>,
    /// First triangle by geometry id.
    pub firsts: [u32; MOST_PARTS],
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
    let mut firsts = [0; MOST_PARTS];
    // who sees a model, its instance says
    let parts = parts_of(device, mesh, positions, RayKinds::ALL)?;
    for Part { geometry, first, .. } in &parts {
        let GeometryId(id) = scene.attach(geometry)?;
        firsts[id as usize] = *first;
    }
    let spacer = if mesh.quadric.is_none() { spacer(device, positions)? } else { None };
    if let Some(spacer) = &spacer {
        scene.attach(spacer)?;
    }
    let scene = scene.freeze()?;
    let casting = parts.iter().filter(|part| part.casts_shadow).count();
    let casters = if !with_casters || casting == 0 {
        None
    } else if casting == parts.len() {
        Some(Arc::clone(&scene))
    } else {
        let mut casters = EmbreeScene::new(device, quality, ROBUST)?;
        for Part { geometry, .. } in &parts[..casting] {
            casters.attach(geometry)?;
        }
        if let Some(spacer) = &spacer {
            casters.attach(spacer)?;
        }
        Some(casters.freeze()?)
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

/// Maximum number of parts of a mesh.
pub const MOST_PARTS: usize = 4;

/// Part of a mesh: its triangles that cast shadows or do not, and are cut out or whole. Those that cast shadows come first.
pub struct Part {
    pub geometry: Geometry,
    /// Number of its first triangle.
    pub first: u32,
    pub casts_shadow: bool,
}

/// Parts of `mesh` that have triangles, with its vertices at `positions`, for rays of the kinds that it is `seen_by`.
pub fn parts_of(
    device: &Device,
    mesh: &Mesh,
    positions: &Arc<VertexBuffer>,
    seen_by: RayKinds,
) -> Result<Vec<Part>, TraceError> {
    let (all, split) = (&mesh.triangles, mesh.shadow_casting);
    let mask_of = |casts_shadow| mask::of_geometry(seen_by, casts_shadow);
    if let Some(quadric) = &mesh.quadric {
        let (pieces, casts_shadow) = (Arc::new(Pieces(Arc::clone(quadric))), split > 0);
        let geometry = Geometry::primitives(device, pieces, mask_of(casts_shadow))?;
        return Ok(vec![Part { geometry, first: 0, casts_shadow }]);
    }
    let cutout = CutoutTest::new(mesh).map(Arc::new);
    let cut = mesh.cut.as_ref().map_or(split..split, |cut| cut.range());
    let mut borders = [0, cut.start, split, cut.end, all.len()];
    borders.sort_unstable();
    let mut parts = Vec::new();
    for range in borders.windows(2).map(|ends| ends[0]..ends[1]).filter(|range| !range.is_empty()) {
        let (first, casts_shadow, is_cut) =
            (range.start as u32, range.start < split, cut.contains(&range.start));
        let triangles =
            if range.len() == all.len() { Arc::clone(all) } else { Arc::new(all[range].to_vec()) };
        let geometry = Geometry::triangles(device, Arc::clone(positions), triangles, mask_of(casts_shadow))?;
        let geometry = match cutout.as_ref().filter(|_| is_cut) {
            Some(test) => geometry.cut_by(Arc::new(CutPart { test: Arc::clone(test), first })),
            None => geometry,
        };
        parts.push(Part { geometry, first, casts_shadow });
    }
    Ok(parts)
}

/// Cut-out triangles of a part, for Embree.
#[derive(Debug)]
struct CutPart {
    test: Arc<CutoutTest>,
    /// Number of the part's first triangle.
    first: u32,
}

impl embree::Cutout for CutPart {
    fn retain(&self, candidates: embree::Candidates<'_>) {
        candidates.retain(|primitive, weights, of_ray| {
            let asks = if mask::clear_passes(of_ray) { Asks::Shadow } else { Asks::Sight };
            self.test.is_there(self.first + primitive, weights, asks)
        });
    }
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
