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

use crate::geometry::tree::{Box3, Planes, Tree, WIDTH};
use crate::lanes::{F32x8, Mask};
use crate::scene::Mesh;
use crate::scene::cutout::{Asks, CutoutTest};

/// `model` of a triangle whose instance has the model.
pub const OF_INSTANCE: u32 = u32::MAX;

/// Sine of the angle between two edges below which a triangle's plane is computed in double floats: in single
/// ones its normal is wrong by 6e-8 over this.
const SLIVER: f32 = 0.02;

/// Corners of eight triangles: by corner, axis and triangle.
type Corners = [[[f32; WIDTH]; 3]; 3];

/// Up to eight triangles.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct Block {
    /// Corners of the triangles. Those of missing ones are NaN: nothing meets them.
    pub corners: Corners,
    /// Indices into [`Scene::models`](crate::scene::Scene::models), or [`OF_INSTANCE`].
    pub model: [u32; WIDTH],
    /// Numbers of the triangles in their meshes.
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
    blocks: Vec<Block>,
    /// Corners when the exposure is over, by leaf, if they move within it; `blocks` have those at its beginning.
    later: Vec<Corners>,
    /// Tests for meshes with triangles that are cut out, by the model that is stored; in rising order.
    cut: Vec<(u32, CutoutTest)>,
}

/// Triangles as a model shows them.
#[derive(Clone, Copy)]
pub struct Shown<'a> {
    pub triangles: &'a Triangles,
    /// Model of triangles that have none; else [`OF_INSTANCE`].
    pub model: u32,
    /// Position of those that move on their way: see [`Chord`](crate::animation::Chord).
    pub share: f32,
}

impl<'a> Shown<'a> {
    /// Triangles that have their own models.
    pub fn of_models(triangles: &'a Triangles) -> Self {
        Self { triangles, model: OF_INSTANCE, share: 0.0 }
    }

    /// Block of a leaf, which is put into `room` if it moves.
    #[inline(always)]
    pub fn block<'b>(&self, leaf: u32, room: &'b mut Option<Block>) -> &'b Block
    where
        'a: 'b,
    {
        let block = &self.triangles.blocks[leaf as usize];
        match self.triangles.later.get(leaf as usize) {
            None => block,
            Some(later) => room.insert(block.on_way(later, self.share)),
        }
    }
}

impl Triangles {
    /// Builds a tree of the first `count` triangles of each of `meshes`, which come with the models to store.
    /// Positions are taken as they are.
    pub fn new(meshes: &[(u32, &Mesh)], count: fn(&Mesh) -> usize) -> Self {
        let placed =
            meshes.iter().map(|(model, mesh)| (*model, *mesh, mesh.triangles().positions.as_slice()));
        Self::at(&placed.collect::<Vec<_>>(), count)
    }

    /// Builds a tree of the first `count` triangles of a mesh of an instance whose vertices go from the one of these positions to the other.
    pub fn moving(mesh: &Mesh, [open, close]: [&[[f32; 3]]; 2], count: fn(&Mesh) -> usize) -> Self {
        let all = &mesh.triangles().corners;
        let corners = |triangle: u32, positions: &[[f32; 3]]| {
            all[triangle as usize].map(|corner| positions[corner as usize])
        };
        let around = |triangle: u32| {
            let [open, close] = [open, close].map(|positions| Box3::around(corners(triangle, positions)));
            open.union(&close)
        };
        let (mut blocks, mut later) = (Vec::new(), Vec::new());
        let boxes: Vec<Box3> = (0..count(mesh) as u32).map(around).collect();
        let tree = Tree::new(&boxes, WIDTH as u32, |ids| {
            let mut ends = [Block::EMPTY, Block::EMPTY];
            for (end, positions) in ends.iter_mut().zip([open, close]) {
                for (lane, id) in ids.iter().enumerate() {
                    end.put(lane, corners(*id, positions), (OF_INSTANCE, *id), mesh);
                }
            }
            let [open, close] = ends;
            blocks.push(open);
            later.push(close.corners);
            blocks.len() as u32 - 1
        });
        let cut = CutoutTest::new(mesh).map(|test| (OF_INSTANCE, test)).into_iter().collect();
        Self { tree, blocks, later, cut }
    }

    /// Builds a tree like [`new`](Self::new), with each mesh's vertices at these positions.
    pub fn at(meshes: &[(u32, &Mesh, &[[f32; 3]])], count: fn(&Mesh) -> usize) -> Self {
        let sources: Vec<(u32, u32)> = (meshes.iter().enumerate())
            .flat_map(|(i, (_, mesh, _))| (0..count(mesh) as u32).map(move |t| (i as u32, t)))
            .collect();
        let corners = |(mesh, triangle): (u32, u32)| {
            let (_, mesh, positions) = meshes[mesh as usize];
            mesh.triangles().corners[triangle as usize].map(|corner| positions[corner as usize])
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
        Self { tree, blocks, later: Vec::new(), cut }
    }

    /// Returns true if triangle number `at` of a block is there in the place with these weights of its second
    /// and third corner, for a ray that asks this.
    #[inline(always)]
    pub fn is_there(&self, block: &Block, at: usize, weights: [f32; 2], asks: Asks) -> bool {
        block.is_cut >> at & 1 == 0 || self.is_left(block, at, weights, asks)
    }

    #[cold]
    fn is_left(&self, block: &Block, at: usize, weights: [f32; 2], asks: Asks) -> bool {
        let found = self.cut.binary_search_by_key(&block.model[at], |(model, _)| *model);
        found.is_ok_and(|test| self.cut[test].1.is_there(block.triangle[at], weights, asks))
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

    /// The block with its corners a `share` of the way to where they are `later`.
    #[inline(always)]
    fn on_way(&self, later: &Corners, share: f32) -> Self {
        let mut block = self.clone();
        let share = F32x8::splat(share);
        for (corner, later) in block.corners.iter_mut().flatten().zip(later.iter().flatten()) {
            let open = F32x8::new(*corner);
            *corner = *(open + (F32x8::new(*later) - open) * share).values();
        }
        block
    }

    /// Boxes around the triangles.
    #[inline(always)]
    pub fn planes(&self) -> Planes {
        let [a, b, c] = &self.corners;
        let mut planes = [[0.0; WIDTH]; 6];
        for axis in 0..3 {
            let (a, b, c) = (F32x8::new(a[axis]), F32x8::new(b[axis]), F32x8::new(c[axis]));
            planes[axis] = *a.min(b.min(c)).values();
            planes[axis + 3] = *a.max(b.max(c)).values();
        }
        planes
    }

    /// Corner number `corner` of each triangle, axes in the order of a ray.
    #[inline(always)]
    pub fn corner(&self, corner: usize, [x, y, z]: Axes) -> [F32x8; 3] {
        let corner = &self.corners[corner];
        [F32x8::new(corner[x]), F32x8::new(corner[y]), F32x8::new(corner[z])]
    }

    /// Corner number `corner` of one triangle in all axes in the order of a ray.
    #[inline(always)]
    pub fn corner_of(&self, corner: usize, at: usize, [x, y, z]: Axes) -> [F32x8; 3] {
        let corner = &self.corners[corner];
        [F32x8::splat(corner[x][at]), F32x8::splat(corner[y][at]), F32x8::splat(corner[z][at])]
    }
}

/// Origins of eight rays, or of one ray eight times, and the shear of space for them.
///
/// Axes are in the order that [`Axes`] gives.
#[derive(Clone, Copy)]
pub struct Shear {
    /// Origins of the rays.
    pub origin: [F32x8; 3],
    /// x / z, y / z and 1 / z of the directions.
    pub shear: [F32x8; 3],
    /// Least t; infinite for lanes that are not in use.
    pub near: F32x8,
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
pub struct Meeting {
    /// Mask of the lanes that intersect; in others the rest means nothing.
    pub mask: Mask,
    /// Ray parameters.
    pub t: F32x8,
    /// Weights of the second corners.
    pub u: F32x8,
    /// Weights of the third corners.
    pub v: F32x8,
}

impl Shear {
    /// Tests for t above `near` and up to `far`. `corners` have their axes in the order of the rays.
    #[inline(always)]
    pub fn meet(&self, corners: [[F32x8; 3]; 3], far: F32x8) -> Option<Meeting> {
        let [ax, ay, az] = self.sheared(corners[0]);
        let [bx, by, bz] = self.sheared(corners[1]);
        let [cx, cy, cz] = self.sheared(corners[2]);
        let of_a = area([cx, cy], [bx, by]);
        let of_b = area([ax, ay], [cx, cy]);
        let of_c = area([bx, by], [ax, ay]);
        let zero = F32x8::ZERO;
        let least = of_a.min(of_b.min(of_c));
        let most = of_a.max(of_b.max(of_c));
        // not all zero: a triangle seen edge on is not met
        let forwards = zero.le(least) & zero.lt(most);
        let reversed = most.le(zero) & least.lt(zero);
        let mut within = forwards | reversed;
        if !within.any() {
            return None;
        }
        let on_edge = within & (is_zero(least) | is_zero(most));
        if on_edge.any() {
            let corners =
                [[*ax.values(), *ay.values()], [*bx.values(), *by.values()], [*cx.values(), *cy.values()]];
            within = Mask::from_bits(settle_edges(within.bits(), on_edge.bits(), &corners));
            if !within.any() {
                return None;
            }
        }
        let whole = of_a + (of_b + of_c);
        // the plane gives the best distance, above all near the ray's origin, where a ray must not meet the
        // surface that it leaves; a sliver has no good plane, but its corners bound the distance
        let depth = self.depth_of_plane(corners, within);
        let nearest = az.min(bz.min(cz));
        let depth = depth.min(az.max(bz.max(cz))).max(nearest);
        let t = depth * self.shear[2];
        let mask = within & (self.near.lt(t) & t.le(far));
        if !mask.any() {
            return None;
        }
        Some(Meeting { mask, t, u: of_b / whole, v: of_c / whole })
    }

    /// Depths at which the rays meet the plane of the corners, along their axis; for slivers, only where they
    /// are `wanted`.
    #[inline(always)]
    fn depth_of_plane(&self, [a, b, c]: [[F32x8; 3]; 3], wanted: Mask) -> F32x8 {
        let e = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        let f = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
        let x = (e[1] * f[2]).less_product(e[2], f[1]);
        let y = (e[2] * f[0]).less_product(e[0], f[2]);
        let z = (e[0] * f[1]).less_product(e[1], f[0]);
        let o = self.origin;
        let way = [a[0] - o[0], a[1] - o[1], a[2] - o[2]];
        let height = (z * way[2]).add_product(y, way[1]).add_product(x, way[0]);
        let fall = z.add_product(y, self.shear[1]).add_product(x, self.shear[0]);
        let depth = height / fall;
        let most = F32x8::splat(SLIVER * SLIVER) * (squared_length(e) * squared_length(f));
        let is_sliver = squared_length([x, y, z]).lt(most);
        let slivers = u32::from((wanted & is_sliver).bits());
        if slivers == 0 {
            return depth;
        }
        let [e, f] = [store_vector(e), store_vector(f)];
        let [way, shear] = [store_vector(way), store_vector(self.shear)];
        F32x8::new(exact_depths(*depth.values(), slivers, [e, f], way, shear))
    }

    /// Shears a corner into the space where the rays are an axis.
    #[inline(always)]
    fn sheared(&self, corner: [F32x8; 3]) -> [F32x8; 3] {
        let z = corner[2] - self.origin[2];
        [
            (corner[0] - self.origin[0]).less_product(self.shear[0], z),
            (corner[1] - self.origin[1]).less_product(self.shear[1], z),
            z,
        ]
    }
}

#[inline(always)]
fn is_zero(area: F32x8) -> Mask {
    area.le(F32x8::ZERO) & F32x8::ZERO.le(area)
}

#[inline(always)]
fn squared_length([x, y, z]: [F32x8; 3]) -> F32x8 {
    (z * z).add_product(y, y).add_product(x, x)
}

/// Eight vectors, by axis and lane.
type Vectors = [[f32; WIDTH]; 3];

#[inline(always)]
fn store_vector([x, y, z]: [F32x8; 3]) -> Vectors {
    [*x.values(), *y.values(), *z.values()]
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
fn settle_edges(within: u8, on_edge: u8, corners: &[[[f32; WIDTH]; 2]; 3]) -> u8 {
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
fn area(p: [F32x8; 2], q: [F32x8; 2]) -> F32x8 {
    p[0] * q[1] - p[1] * q[0]
}
