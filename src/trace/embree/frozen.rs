//! Scenes that instances place: built once, and refitted where a mesh deforms.

use std::sync::Arc;

use embree::{BuildQuality, Device, FrozenScene, Geometry, GeometryId, Scene as EmbreeScene, VertexBuffer};
use glam::Vec3;

use super::curved::CurvedPart;
use super::mask;
use super::places::times_of_ends;
use crate::geometry::{Bounds, Curved};
use crate::scene::cutout::{Asks, CutoutTest};
use crate::scene::{Geometry as MeshGeometry, Mesh, RayKinds, Triangles};
use crate::trace::TraceError;

/// Flag of all scenes, so that closed surfaces have no cracks: without it a few rays slip between two
/// triangles that share an edge and show what is behind them, and the audit rightly complains.
pub const ROBUST: bool = true;

/// Vertex positions of a mesh.
pub enum Vertices<'a> {
    /// They stay where they are.
    Still(&'a Arc<VertexBuffer>),
    /// They go straight from one place to another while the exposure lasts, as rays of so many groups of ticks see them.
    Moving([Arc<VertexBuffer>; 2], usize),
}

/// What a scene is built of.
pub enum Source<'a> {
    /// The triangles of a mesh, with these vertices.
    Triangles(&'a Triangles, Vertices<'a>),
    /// A curved geometry.
    Curved(&'a Arc<dyn Curved>),
}

impl<'a> Source<'a> {
    /// A mesh at rest.
    pub fn at_rest(mesh: &'a Mesh) -> Self {
        match &mesh.geometry {
            MeshGeometry::Triangles(triangles) => {
                Self::Triangles(triangles, Vertices::Still(&triangles.positions))
            }
            MeshGeometry::Curved(curved) => Self::Curved(curved),
        }
    }

    /// Positions for which a [`spacer`] is needed, if there are any.
    fn flat(&self) -> Option<&Arc<VertexBuffer>> {
        match self {
            Self::Triangles(_, vertices) => vertices.flat(),
            Self::Curved(_) => None,
        }
    }

    /// Box around it, at the first of its times.
    fn bounds(&self) -> Bounds {
        match self {
            Self::Triangles(_, vertices) => around(vertices.first()),
            Self::Curved(curved) => {
                (0..curved.count()).map(|one| curved.bounds(one)).fold(Bounds::EMPTY, Bounds::union)
            }
        }
    }
}

impl Vertices<'_> {
    fn geometry(
        &self,
        device: &Device,
        triangles: Arc<Vec<[u32; 3]>>,
        mask: u32,
    ) -> Result<Geometry, TraceError> {
        Ok(match self {
            Self::Still(positions) => Geometry::triangles(device, Arc::clone(positions), triangles, mask)?,
            Self::Moving(ends, groups) => {
                Geometry::moving_triangles(device, ends.clone(), times_of_ends(*groups), triangles, mask)?
            }
        })
    }

    fn first(&self) -> &Arc<VertexBuffer> {
        match self {
            Self::Still(positions) => positions,
            Self::Moving([first, _], _) => first,
        }
    }

    /// Positions at one of their times at which the mesh is flat, if it ever is.
    fn flat(&self) -> Option<&Arc<VertexBuffer>> {
        let all = match self {
            Self::Still(positions) => std::slice::from_ref(*positions),
            Self::Moving(ends, _) => ends,
        };
        all.iter().find(|positions| is_flat(positions))
    }
}

/// A mesh's own scene.
pub struct Frozen {
    pub scene: Arc<FrozenScene>,
    /// First primitive by geometry id.
    pub firsts: [u32; MOST_PARTS],
    /// Box around the mesh when it was built, object space.
    pub bounds: Bounds,
    /// Scene of the primitives that cast shadows, if it is wanted and there are any.
    pub casters: Option<Arc<FrozenScene>>,
    /// Number of the mesh's parts, and of those that cast shadows: the first geometries of `scene`, and of `casters`.
    parts: u32,
    casting: u32,
    /// True if the geometry after these is a [`spacer`].
    pub has_spacer: bool,
}

/// Builds the scene of `mesh`, made of `source`.
pub fn freeze(
    device: &Device,
    mesh: &Mesh,
    source: &Source<'_>,
    quality: BuildQuality,
    with_casters: bool,
) -> Result<Frozen, TraceError> {
    let mut scene = EmbreeScene::new(device, quality, ROBUST)?;
    let mut firsts = [0; MOST_PARTS];
    // who sees a model, its instance says
    let mask = |casts_shadow| mask::of_geometry(RayKinds::ALL, casts_shadow);
    let parts = parts_of(device, mesh, source, mask)?;
    for Part { geometry, first, .. } in &parts {
        let GeometryId(id) = scene.attach(geometry)?;
        firsts[id as usize] = *first;
    }
    // between two times boxes go straight from one to the other: none is flatter than the flatter of them
    let spacer = source.flat().map(|positions| spacer(device, positions)).transpose()?;
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
    let [parts, casting] = [parts.len(), casting].map(|count| count as u32);
    let bounds = source.bounds();
    Ok(Frozen { scene, firsts, bounds, casters, parts, casting, has_spacer: spacer.is_some() })
}

impl Frozen {
    /// Moves the vertices of scenes that were built to be [refitted](BuildQuality::Refit), and refits them. No instance may place
    /// them meanwhile.
    pub fn refit(self, positions: &Arc<VertexBuffer>) -> Result<Self, TraceError> {
        let Self { scene, casters, .. } = self;
        let is_one = casters.as_ref().is_some_and(|casters| Arc::ptr_eq(casters, &scene));
        // the same scene may be held once
        let casters = casters.filter(|_| !is_one);
        let ends = self.has_spacer.then(|| spacer_ends(positions));
        let refit = |scene: Arc<FrozenScene>, parts: u32| -> Result<Arc<FrozenScene>, TraceError> {
            let mut scene = scene.thaw()?;
            for part in 0..parts {
                scene.set_vertices(GeometryId(part), positions)?;
            }
            if let Some(ends) = &ends {
                scene.set_vertices(GeometryId(parts), ends)?;
            }
            Ok(scene.freeze()?)
        };
        let scene = refit(scene, self.parts)?;
        let own = casters.map(|casters| refit(casters, self.casting)).transpose()?;
        let casters = if is_one { Some(Arc::clone(&scene)) } else { own };
        Ok(Self { scene, casters, ..self })
    }
}

/// Least thickness of a mesh, relative to its extent; a flatter one gets a [`spacer`] of this size.
const FLAT: f32 = 1e-4;

/// Returns true if a mesh with these vertices needs a [`spacer`].
pub fn is_flat(positions: &VertexBuffer) -> bool {
    let around = around(positions);
    let extent = around.high - around.low;
    !around.is_empty() && extent.min_element() < FLAT * extent.max_element()
}

/// Creates a geometry that gives a mesh that is flat along an axis a box that is not: a triangle without an
/// area, which no ray meets.
///
/// Among instances Embree tests the boxes of coherent packets all at once, in a way that is not conservative
/// whatever the scene's flags: where rays are nearly parallel (an orthographic camera's, refracted) the
/// nearest and the farthest distance to a box without thickness differ by less than rounding, and the whole
/// packet misses it (Embree 4.4, `kernels/bvh/node_intersector_frustum.h`).
fn spacer(device: &Device, positions: &VertexBuffer) -> Result<Geometry, TraceError> {
    Ok(Geometry::triangles(device, spacer_ends(positions), Arc::new(vec![[0, 1, 1]]), mask::HIDDEN)?)
}

/// Ends of the [`spacer`] of a mesh, in its middle: as far apart along each axis as the mesh is too flat there.
fn spacer_ends(positions: &VertexBuffer) -> Arc<VertexBuffer> {
    let around = around(positions);
    let extent = around.high - around.low;
    let least = FLAT * extent.max_element();
    let reach = Vec3::from_array(extent.to_array().map(|along| if along < least { least } else { 0.0 }));
    let middle = (around.low + around.high) * 0.5;
    Arc::new(VertexBuffer::new(vec![(middle - reach).to_array(), (middle + reach).to_array()]))
}

fn around(positions: &VertexBuffer) -> Bounds {
    positions.as_slice().iter().map(|at| Vec3::from_array(*at)).fold(Bounds::EMPTY, Bounds::with)
}

/// Maximum number of parts of a mesh.
pub const MOST_PARTS: usize = 4;

/// Part of a mesh: its primitives that cast shadows or do not, and are cut out or whole. Those that cast shadows come first.
pub struct Part {
    pub geometry: Geometry,
    /// Number of its first primitive.
    pub first: u32,
    pub casts_shadow: bool,
}

/// Parts of `mesh` that have primitives, made of `source`. `mask_of`: the mask of those that cast shadows, or do not.
pub fn parts_of(
    device: &Device,
    mesh: &Mesh,
    source: &Source<'_>,
    mask_of: impl Fn(bool) -> u32,
) -> Result<Vec<Part>, TraceError> {
    let (count, split) = (mesh.count(), mesh.shadow_casting);
    let cutout = CutoutTest::new(mesh).map(Arc::new);
    let cut = mesh.cut.as_ref().map_or(split..split, |cut| cut.range());
    let mut borders = [0, cut.start, split, cut.end, count];
    borders.sort_unstable();
    let mut parts = Vec::new();
    for range in borders.windows(2).map(|ends| ends[0]..ends[1]).filter(|range| !range.is_empty()) {
        let (first, casts_shadow, is_cut) =
            (range.start as u32, range.start < split, cut.contains(&range.start));
        let mask = mask_of(casts_shadow);
        let geometry = match source {
            Source::Triangles(Triangles { corners, .. }, vertices) => {
                let corners = match range.len() == count {
                    true => Arc::clone(corners),
                    false => Arc::new(corners[range].to_vec()),
                };
                vertices.geometry(device, corners, mask)?
            }
            Source::Curved(curved) => {
                let (of, range) = (Arc::clone(curved), range.start as u32..range.end as u32);
                Geometry::primitives(device, Arc::new(CurvedPart { of, range }), mask)?
            }
        };
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
