//! Meshes: a geometry, and what its primitives are made of.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec3, Vec3, Vec3A};
use rayon::prelude::*;

use super::cage::Cage;
use super::cutout::CutTriangles;
use super::details::Details;
use super::geometry::{Geometry, Triangles};
use super::shapes::Shapes;
use crate::geometry::{Bounds, Curved};

/// Number of triangles that one thread handles in one go.
const BLOCK: usize = 1 << 14;

/// A geometry in object space, with what belongs to its primitives whatever they are.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// The primitives.
    pub geometry: Geometry,
    /// Number of primitives, from the first on, that cast shadows. Shadow rays pass the rest.
    pub shadow_casting: usize,
    /// Index into [`Scene::materials`](super::Scene::materials) for each primitive.
    pub material_of: Vec<u16>,
    /// Names that the file gives to parts of the mesh.
    pub groups: Arc<Groups>,
    /// Triangles of which alpha cuts parts out; the mesh has texture coordinates or alphas then.
    pub cut: Option<Arc<CutTriangles>>,
    /// Colours, alphas and tangents, where it has any.
    pub details: Arc<Details>,
}

/// Groups of a mesh's triangles, as OBJ files name them with `g` and `o`.
#[derive(Debug, Clone, PartialEq)]
pub struct Groups {
    /// Distinct names.
    names: Vec<String>,
    /// Runs of consecutive triangles of the same group: the first triangle and the number of the group. In
    /// order; the first run begins at triangle 0.
    begins: Vec<(u32, u32)>,
}

impl Default for Groups {
    /// Puts all triangles in one group.
    fn default() -> Self {
        Self { names: vec![String::from("default")], begins: vec![(0, 0)] }
    }
}

impl Groups {
    /// Creates groups with these names, without triangles yet.
    pub fn named(names: impl Iterator<Item = String>) -> Self {
        Self { names: names.collect(), begins: Vec::new() }
    }

    /// Puts all triangles from number `first` on in this group. `first` rises from call to call.
    pub fn begin(&mut self, first: u32, group: u32) {
        if self.begins.last().is_none_or(|(_, last)| *last != group) {
            self.begins.push((first, group));
        }
    }

    /// Runs of consecutive triangles of the same group: the first triangle and the number of the group, in order.
    pub fn runs(&self) -> &[(u32, u32)] {
        &self.begins
    }

    /// Numbers of the groups that have triangles.
    pub fn used(&self) -> BTreeSet<usize> {
        self.begins.iter().map(|(_, group)| *group as usize).collect()
    }

    /// Names by number. The first is that of triangles that the file puts in no group.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Number of a triangle's group.
    #[inline]
    pub fn of(&self, triangle: u32) -> usize {
        let after = match &self.begins[..] {
            [_] => 1,
            begins => begins.partition_point(|(first, _)| *first <= triangle),
        };
        self.begins[after - 1].1 as usize
    }
}

impl Mesh {
    /// Creates a mesh of one material, all of which casts shadows or nothing.
    pub fn plain(geometry: Geometry, material: u16, casts_shadow: bool) -> Self {
        let count = geometry.count();
        Self {
            geometry,
            shadow_casting: if casts_shadow { count } else { 0 },
            material_of: vec![material; count],
            groups: Arc::default(),
            cut: None,
            details: Arc::default(),
        }
    }

    /// [`plain`](Self::plain), of a geometry that is not made of triangles.
    pub fn of_curved(curved: impl Curved + 'static, material: u16, casts_shadow: bool) -> Self {
        Self::plain(Geometry::Curved(Arc::new(curved)), material, casts_shadow)
    }

    /// Number of its primitives.
    pub fn count(&self) -> usize {
        self.geometry.count()
    }

    /// The triangles, if it is made of these.
    #[inline(always)]
    pub fn as_triangles(&self) -> Option<&Triangles> {
        match &self.geometry {
            Geometry::Triangles(triangles) => Some(triangles),
            Geometry::Curved(_) => None,
        }
    }

    /// The geometry, if it is not made of triangles.
    #[inline(always)]
    pub fn as_curved(&self) -> Option<&Arc<dyn Curved>> {
        match &self.geometry {
            Geometry::Triangles(_) => None,
            Geometry::Curved(curved) => Some(curved),
        }
    }

    /// Returns true if it is not made of triangles.
    #[inline(always)]
    pub fn is_curved(&self) -> bool {
        matches!(self.geometry, Geometry::Curved(_))
    }

    /// The triangles of a mesh that is known to be made of these.
    ///
    /// # Panics If it is not.
    pub fn triangles(&self) -> &Triangles {
        self.as_triangles().expect("the caller knows that it is made of triangles")
    }

    /// The mesh with other triangles, as many as before; one that is not made of triangles stays as it is.
    pub fn with_triangles(mut self, change: impl FnOnce(&mut Triangles)) -> Self {
        if let Geometry::Triangles(triangles) = &mut self.geometry {
            change(triangles);
        }
        self
    }

    /// The mesh, which stands for a cage until it is diced.
    pub(crate) fn with_cage(self, cage: Option<Arc<Cage>>) -> Self {
        match cage {
            Some(_) => Self { details: Arc::new(Details { cage, ..Details::clone(&self.details) }), ..self },
            None => self,
        }
    }

    /// The mesh without its cage.
    pub(crate) fn without_cage(self) -> Self {
        if self.details.cage.is_none() {
            return self;
        }
        Self { details: Arc::new(Details { cage: None, ..Details::clone(&self.details) }), ..self }
    }

    /// Its shapes, if it deforms.
    #[inline]
    pub fn shapes(&self) -> Option<&Arc<Shapes>> {
        self.as_triangles()?.shapes.as_ref()
    }

    /// Returns true if its surface has texture coordinates.
    pub fn has_uvs(&self) -> bool {
        self.as_triangles().is_none_or(|triangles| !triangles.uvs.is_empty())
    }

    /// The smallest box around the vertices that triangles use, object space, in all shapes; unused vertices must not make the model
    /// seem larger than it is. Of other geometries the box around all primitives.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        match &self.geometry {
            Geometry::Triangles(triangles) => bounds_of_used(triangles),
            Geometry::Curved(curved) => {
                let Bounds { low, high } = bounds_of_curved(curved.as_ref());
                (low.as_dvec3(), high.as_dvec3())
            }
        }
    }
}

fn bounds_of_used(triangles: &Triangles) -> (DVec3, DVec3) {
    let nothing = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
    let joined = |a: (Vec3A, Vec3A), b: (Vec3A, Vec3A)| (a.0.min(b.0), a.1.max(b.1));
    let in_shape = |positions: &[[f32; 3]]| {
        let of_block = |block: &[[u32; 3]]| {
            let corners = block.as_flattened().iter().map(|i| Vec3A::from(positions[*i as usize]));
            corners.fold(nothing, |bounds, corner| joined(bounds, (corner, corner)))
        };
        triangles.corners.par_chunks(BLOCK).map(of_block).reduce(|| nothing, joined)
    };
    let (low, high) = triangles.all_positions().map(in_shape).fold(nothing, joined);
    (low.as_dvec3(), high.as_dvec3())
}

fn bounds_of_curved(curved: &dyn Curved) -> Bounds {
    (0..curved.count()).map(|primitive| curved.bounds(primitive)).fold(Bounds::EMPTY, Bounds::union)
}

impl Bounds {
    /// Computes the box around all vertices of `mesh`, object space, in all of its shapes, whether a triangle
    /// uses them or not; or around all of its primitives, if they have none.
    pub fn of(mesh: &Mesh) -> Self {
        match &mesh.geometry {
            Geometry::Triangles(triangles) => {
                let all = triangles.all_positions().flatten();
                all.fold(Self::EMPTY, |all, point| all.with(Vec3::from_array(*point)))
            }
            Geometry::Curved(curved) => bounds_of_curved(curved.as_ref()),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geometry::Quadric;
    use crate::geometry::quadric::QuadricShape;

    /// A cylinder, which has three pieces.
    fn can() -> Mesh {
        let quadric = Quadric::new(QuadricShape::Cylinder { radius: 1.0, height: 2.0 }, false);
        Mesh::of_curved(quadric, 3, true)
    }

    /// Two triangles of four vertices, and a vertex that none of them has.
    fn sheet() -> Mesh {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [0.0, 2.0, 0.0], [9.0, 9.0, 9.0]];
        Mesh::plain(Triangles::new(positions.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).into(), 0, false)
    }

    #[test]
    fn all_geometries_say_how_many_primitives_they_have_and_where() {
        let (can, sheet) = (can(), sheet());
        assert_eq!((can.count(), can.material_of.len(), can.shadow_casting), (3, 3, 3));
        assert_eq!((sheet.count(), sheet.material_of.len(), sheet.shadow_casting), (2, 2, 0));
        for mesh in [&can, &sheet] {
            let primitives = 0..mesh.count() as u32;
            let all = primitives.map(|one| mesh.geometry.bounds(one)).fold(Bounds::EMPTY, Bounds::union);
            assert_eq!((all.low.as_dvec3(), all.high.as_dvec3()), mesh.bounds());
        }
        assert_eq!(sheet.bounds().1, DVec3::new(1.0, 2.0, 0.0), "without the vertex that no triangle has");
        assert_eq!(Bounds::of(&sheet).high, Vec3::splat(9.0));
        let around = Bounds::of(&can);
        assert!(around.high.abs_diff_eq(Vec3::new(1.0, 2.0, 1.0), 1e-5), "{around:?}");
    }

    #[test]
    fn a_geometry_is_of_triangles_or_curved() {
        let (can, sheet) = (can(), sheet());
        assert!(can.is_curved() && can.as_curved().is_some() && can.as_triangles().is_none());
        assert!(!sheet.is_curved() && sheet.as_curved().is_none() && sheet.as_triangles().is_some());
        assert!(can.has_uvs() && !sheet.has_uvs() && can.shapes().is_none());
        let raised = sheet.with_triangles(|triangles| triangles.uvs = vec![glam::Vec2::ZERO; 5]);
        assert!(raised.has_uvs());
        assert!(can.with_triangles(|_| unreachable!("it has none")).is_curved());
    }
}
