//! Triangles in blocks of eight, and the test of eight rays with a triangle, or of a ray with eight
//! triangles.
//!
//! The test is that of S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013):
//! space is sheared so that the ray becomes an axis, and the signs of three areas in the plane decide. A
//! corner is sheared to the same floats in each triangle that has it, and the area at an edge that two
//! triangles share has the same size and opposite signs in them, so that no ray passes between them. An area
//! of zero is computed again in double floats; if it stays zero it counts as either sign: a ray through an
//! edge meets both triangles.

use glam::DVec3;

use super::lanes::{F32x8, WIDTH};
use super::tree::{Box3, Planes, Tree};
use crate::scene::Mesh;
use crate::scene::cutout::CutoutTest;

/// `model` of a triangle whose instance has the model.
pub const OF_INSTANCE: u32 = u32::MAX;

/// Sine of the angle between two edges below which a triangle's plane is computed in double floats: in single
/// ones its normal is wrong by 6e-8 over this.
const SLIVER: f32 = 0.02;

/// Up to eight triangles.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct Block {
    /// Corners, by corner, axis and triangle. Those of missing triangles are NaN: nothing meets them.
    pub corners: [[[f32; WIDTH]; 3]; 3],
    /// Indices into [`Scene::models`](crate::scene::Scene::models), or [`OF_INSTANCE`].
    pub model: [u32; WIDTH],
    /// Indices into [`Mesh::triangles`].
    pub triangle: [u32; WIDTH],
    /// Bit mask of the triangles that cast shadows.
    pub casts_shadow: u32,
    /// Bit mask of the triangles that are cut out.
    pub is_cut: u32,
}

/// A tree of triangles.
pub struct Triangles {
    /// Tree whose leaves are blocks.
    pub tree: Tree,
    /// Blocks, by leaf.
    pub blocks: Vec<Block>,
    /// Tests for meshes with triangles that are cut out, by the model that is stored; in rising order.
    cut: Vec<(u32, CutoutTest)>,
}

impl Triangles {
    /// Builds a tree of the first `count` triangles of each of `meshes`, which come with the models to store.
    /// Positions are taken as they are.
    pub fn new(meshes: &[(u32, &Mesh)], count: fn(&Mesh) -> usize) -> Self {
        let placed = meshes.iter().map(|(model, mesh)| (*model, *mesh, mesh.positions.as_slice()));
        Self::at(&placed.collect::<Vec<_>>(), count)
    }

    /// Builds a tree like [`new`](Self::new), with each mesh's vertices at these positions.
    pub fn at(meshes: &[(u32, &Mesh, &[[f32; 3]])], count: fn(&Mesh) -> usize) -> Self {
        let sources: Vec<(u32, u32)> = (meshes.iter().enumerate())
            .flat_map(|(i, (_, mesh, _))| (0..count(mesh) as u32).map(move |t| (i as u32, t)))
            .collect();
        let corners = |(mesh, triangle): (u32, u32)| {
            let (_, mesh, positions) = meshes[mesh as usize];
            mesh.triangles[triangle as usize].map(|corner| positions[corner as usize])
        };
        let boxes: Vec<Box3> = sources.iter().map(|source| Box3::around(corners(*source))).collect();
        let mut blocks = Vec::with_capacity(sources.len() / 4);
        let tree = Tree::new(&boxes, WIDTH as u32, |ids| {
            let mut block = Block::EMPTY;
            for (lane, id) in ids.iter().enumerate() {
                let source = sources[*id as usize];
                let (model, mesh, _) = meshes[source.0 as usize];
                block.put(lane, corners(source), (model, source.1), mesh);
            }
            blocks.push(block);
            blocks.len() as u32 - 1
        });
        let tests = meshes.iter().filter_map(|(model, mesh, _)| Some((*model, CutoutTest::new(mesh)?)));
        let mut cut: Vec<(u32, CutoutTest)> = tests.collect();
        cut.sort_by_key(|(model, _)| *model);
        Self { tree, blocks, cut }
    }

    /// Returns true if triangle number `at` of a block is there in the place with these weights of its second
    /// and third corner.
    #[inline(always)]
    pub fn is_there(&self, block: &Block, at: usize, weights: [f32; 2]) -> bool {
        block.is_cut >> at & 1 == 0 || self.is_left(block, at, weights)
    }

    #[cold]
    fn is_left(&self, block: &Block, at: usize, [u, v]: [f32; 2]) -> bool {
        let found = self.cut.binary_search_by_key(&block.model[at], |(model, _)| *model);
        found.is_ok_and(|test| self.cut[test].1.is_there(block.triangle[at], u, v))
    }

    /// Returns true if there are no triangles.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }
}

impl Block {
    const EMPTY: Self = Self {
        corners: [[[f32::NAN; WIDTH]; 3]; 3],
        model: [OF_INSTANCE; WIDTH],
        triangle: [0; WIDTH],
        casts_shadow: 0,
        is_cut: 0,
    };

    fn put(&mut self, lane: usize, corners: [[f32; 3]; 3], (model, triangle): (u32, u32), mesh: &Mesh) {
        for (corner, place) in corners.iter().enumerate() {
            for (axis, coordinate) in place.iter().enumerate() {
                self.corners[corner][axis][lane] = *coordinate;
            }
        }
        (self.model[lane], self.triangle[lane]) = (model, triangle);
        let casts_shadow = (triangle as usize) < mesh.shadow_casting;
        let is_cut = mesh.cut.as_ref().is_some_and(|cut| cut.range().contains(&(triangle as usize)));
        self.casts_shadow |= u32::from(casts_shadow) << lane;
        self.is_cut |= u32::from(is_cut) << lane;
    }

    /// Boxes around the triangles.
    #[inline(always)]
    pub fn planes<L: F32x8>(&self, lanes: L) -> Planes {
        let [a, b, c] = &self.corners;
        let mut planes = [[0.0; WIDTH]; 6];
        for axis in 0..3 {
            let (a, b, c) = (lanes.load(&a[axis]), lanes.load(&b[axis]), lanes.load(&c[axis]));
            planes[axis] = lanes.store(lanes.min(a, lanes.min(b, c)));
            planes[axis + 3] = lanes.store(lanes.max(a, lanes.max(b, c)));
        }
        planes
    }

    /// Corner number `corner` of each triangle, axes in the order of a ray.
    #[inline(always)]
    pub fn corner<L: F32x8>(&self, lanes: L, corner: usize, [x, y, z]: Axes) -> [L::F; 3] {
        let corner = &self.corners[corner];
        [lanes.load(&corner[x]), lanes.load(&corner[y]), lanes.load(&corner[z])]
    }

    /// Corner number `corner` of one triangle in all lanes, axes in the order of a ray.
    #[inline(always)]
    pub fn corner_of<L: F32x8>(&self, lanes: L, corner: usize, at: usize, [x, y, z]: Axes) -> [L::F; 3] {
        let corner = &self.corners[corner];
        [lanes.splat(corner[x][at]), lanes.splat(corner[y][at]), lanes.splat(corner[z][at])]
    }
}

/// Origins of eight rays, or of one ray eight times, and the shear of space for them.
///
/// Axes are in the order that [`Axes`] gives.
#[derive(Clone, Copy)]
pub struct Shear<L: F32x8> {
    /// Origins of the rays.
    pub origin: [L::F; 3],
    /// x / z, y / z and 1 / z of the directions.
    pub shear: [L::F; 3],
    /// Least t; infinite for lanes that are not in use.
    pub near: L::F,
}

/// Order of axes for a ray: two across, and last the one along which it goes furthest.
pub type Axes = [usize; 3];

/// Order of axes for rays that go furthest along axis `along`.
#[inline(always)]
pub fn axes_for(along: usize) -> Axes {
    [(along + 1) % 3, (along + 2) % 3, along]
}

/// Axis along which `direction` goes furthest; the first of equals.
#[inline(always)]
pub fn longest_axis(direction: [f32; 3]) -> usize {
    let [x, y, z] = [direction[0].abs(), direction[1].abs(), direction[2].abs()];
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// Intersections of rays and triangles.
#[derive(Clone, Copy)]
pub struct Meeting<L: F32x8> {
    /// Mask of the lanes that intersect; in others the rest means nothing.
    pub mask: L::M,
    /// Ray parameters.
    pub t: L::F,
    /// Weights of the second corners.
    pub u: L::F,
    /// Weights of the third corners.
    pub v: L::F,
}

impl<L: F32x8> Shear<L> {
    /// Tests for t above `near` and up to `far`. `corners` have their axes in the order of the rays.
    #[inline(always)]
    pub fn meet(&self, lanes: L, corners: [[L::F; 3]; 3], far: L::F) -> Option<Meeting<L>> {
        let [ax, ay, az] = self.sheared(lanes, corners[0]);
        let [bx, by, bz] = self.sheared(lanes, corners[1]);
        let [cx, cy, cz] = self.sheared(lanes, corners[2]);
        let of_a = area(lanes, [cx, cy], [bx, by]);
        let of_b = area(lanes, [ax, ay], [cx, cy]);
        let of_c = area(lanes, [bx, by], [ax, ay]);
        let zero = lanes.splat(0.0);
        let least = lanes.min(of_a, lanes.min(of_b, of_c));
        let most = lanes.max(of_a, lanes.max(of_b, of_c));
        // not all zero: a triangle seen edge on is not met
        let forwards = lanes.and(lanes.at_most(zero, least), lanes.less(zero, most));
        let reversed = lanes.and(lanes.at_most(most, zero), lanes.less(least, zero));
        let mut within = lanes.or(forwards, reversed);
        if lanes.bits(within) == 0 {
            return None;
        }
        let on_edge = lanes.and(within, lanes.or(lanes.equal(least, zero), lanes.equal(most, zero)));
        if lanes.bits(on_edge) != 0 {
            let corners = [
                [lanes.store(ax), lanes.store(ay)],
                [lanes.store(bx), lanes.store(by)],
                [lanes.store(cx), lanes.store(cy)],
            ];
            within = lanes.mask(settle_edges(lanes.bits(within), lanes.bits(on_edge), &corners));
            if lanes.bits(within) == 0 {
                return None;
            }
        }
        let whole = lanes.add(of_a, lanes.add(of_b, of_c));
        // the plane gives the best distance, above all near the ray's origin, where a ray must not meet the
        // surface that it leaves; a sliver has no good plane, but its corners bound the distance
        let depth = self.depth_of_plane(lanes, corners, within);
        let nearest = lanes.min(az, lanes.min(bz, cz));
        let depth = lanes.max(lanes.min(depth, lanes.max(az, lanes.max(bz, cz))), nearest);
        let t = lanes.mul(depth, self.shear[2]);
        let mask = lanes.and(within, lanes.and(lanes.less(self.near, t), lanes.at_most(t, far)));
        if lanes.bits(mask) == 0 {
            return None;
        }
        Some(Meeting { mask, t, u: lanes.div(of_b, whole), v: lanes.div(of_c, whole) })
    }
    /// Depths at which the rays meet the plane of the corners, along their axis; for slivers, only where they
    /// are `wanted`.
    #[inline(always)]
    fn depth_of_plane(&self, lanes: L, [a, b, c]: [[L::F; 3]; 3], wanted: L::M) -> L::F {
        let e = [lanes.sub(b[0], a[0]), lanes.sub(b[1], a[1]), lanes.sub(b[2], a[2])];
        let f = [lanes.sub(c[0], a[0]), lanes.sub(c[1], a[1]), lanes.sub(c[2], a[2])];
        let x = lanes.sub_product(e[2], f[1], lanes.mul(e[1], f[2]));
        let y = lanes.sub_product(e[0], f[2], lanes.mul(e[2], f[0]));
        let z = lanes.sub_product(e[1], f[0], lanes.mul(e[0], f[1]));
        let o = self.origin;
        let way = [lanes.sub(a[0], o[0]), lanes.sub(a[1], o[1]), lanes.sub(a[2], o[2])];
        let height = lanes.add_product(x, way[0], lanes.add_product(y, way[1], lanes.mul(z, way[2])));
        let fall = lanes.add_product(x, self.shear[0], lanes.add_product(y, self.shear[1], z));
        let depth = lanes.div(height, fall);
        let most = lanes
            .mul(lanes.splat(SLIVER * SLIVER), lanes.mul(squared_length(lanes, e), squared_length(lanes, f)));
        let is_sliver = lanes.less(squared_length(lanes, [x, y, z]), most);
        let slivers = lanes.bits(lanes.and(wanted, is_sliver));
        if slivers == 0 {
            return depth;
        }
        let [e, f] = [store_vector(lanes, e), store_vector(lanes, f)];
        let [way, shear] = [store_vector(lanes, way), store_vector(lanes, self.shear)];
        lanes.load(&exact_depths(lanes.store(depth), slivers, [e, f], way, shear))
    }

    /// Shears a corner into the space where the rays are an axis.
    #[inline(always)]
    fn sheared(&self, lanes: L, corner: [L::F; 3]) -> [L::F; 3] {
        let z = lanes.sub(corner[2], self.origin[2]);
        [
            lanes.sub_product(self.shear[0], z, lanes.sub(corner[0], self.origin[0])),
            lanes.sub_product(self.shear[1], z, lanes.sub(corner[1], self.origin[1])),
            z,
        ]
    }
}

#[inline(always)]
fn squared_length<L: F32x8>(lanes: L, [x, y, z]: [L::F; 3]) -> L::F {
    lanes.add_product(x, x, lanes.add_product(y, y, lanes.mul(z, z)))
}

/// Eight vectors, by axis and lane.
type Vectors = [[f32; WIDTH]; 3];

#[inline(always)]
fn store_vector<L: F32x8>(lanes: L, [x, y, z]: [L::F; 3]) -> Vectors {
    [lanes.store(x), lanes.store(y), lanes.store(z)]
}

/// Computes `depths` again in double floats for the `slivers`: edges, vector from the ray's origin to the
/// first corner, and shear as in [`Shear::depth_of_plane`].
#[cold]
fn exact_depths(
    mut depths: [f32; WIDTH],
    slivers: u32,
    [e, f]: [Vectors; 2],
    way: Vectors,
    shear: Vectors,
) -> [f32; WIDTH] {
    for (lane, depth) in depths.iter_mut().enumerate().filter(|(lane, _)| slivers >> lane & 1 != 0) {
        let vector = |of: &Vectors| DVec3::from([of[0][lane], of[1][lane], of[2][lane]].map(f64::from));
        let normal = vector(&f).cross(vector(&e));
        let slope = vector(&shear).with_z(1.0);
        *depth = (normal.dot(vector(&way)) / normal.dot(slope)) as f32;
    }
    depths
}

/// Decides which of the triangles `within` the ray meets: for those `on_edge` the signs of the areas are
/// computed in double floats, where the products are exact. An area of zero may be the rounding of a triangle
/// that is tiny beside its distance; if two of three are zero, the ray would meet it from anywhere around.
/// `corners` are sheared.
#[cold]
fn settle_edges(within: u32, on_edge: u32, corners: &[[[f32; WIDTH]; 2]; 3]) -> u32 {
    let mut met = within;
    for lane in (0..WIDTH).filter(|lane| on_edge >> lane & 1 != 0) {
        let [a, b, c] = corners.map(|corner| corner.map(|along| f64::from(along[lane])));
        let areas = [[c, b], [a, c], [b, a]].map(|[p, q]| p[0] * q[1] - p[1] * q[0]);
        let none_below = areas.iter().all(|area| *area >= 0.0);
        let none_above = areas.iter().all(|area| *area <= 0.0);
        if none_below == none_above {
            met &= !(1 << lane);
        }
    }
    met
}

/// Twice the area between the origin, `p` and `q`.
///
/// Rounded twice on purpose: rounding is monotone, so the sign is never wrong, and an edge has the same area,
/// negated, in both of its triangles.
#[inline(always)]
fn area<L: F32x8>(lanes: L, p: [L::F; 2], q: [L::F; 2]) -> L::F {
    lanes.sub(lanes.mul(p[0], q[1]), lanes.mul(p[1], q[0]))
}
