//! The closed surface around a medium: where a line crosses it.
//!
//! A crossing is never missed and never counted twice: triangles are tested by the signs of volumes that two which share an edge compute
//! alike, in double floats, and lines are moved aside by next to nothing, so that none meets an edge exactly. So a line that goes into a
//! closed mesh comes out of it.

use std::collections::HashMap;

use glam::DVec3;

use crate::geometry::tree::{Box3, Child, Tree, WIDTH};

/// Triangles in a leaf of the tree.
const LEAF: u32 = 4;

/// How far lines are moved aside, as a share of the size of coordinates: far less than single floats can tell, and in a direction in which
/// nothing lies. Lines of cameras and suns that go along axes would meet edges and corners of boxes exactly.
const ASIDE: DVec3 = DVec3::new(0.37e-10, -0.61e-10, 0.71e-10);

/// Planes of a boundary, at most, that is crossed by planes: those of a box are six, or twelve where it is turned.
const FEW_PLANES: usize = 12;

/// How far corners of such a boundary may be in front of its planes, as a share of the size of coordinates: rounding to single floats.
const CONVEX_SLACK: f64 = 3e-7;

/// Shares of the size of coordinates by which boxes are widened for rounding.
const SLACK: f64 = 1e-6;

/// The triangles around a medium, object space, and a tree over them.
#[derive(Debug)]
pub struct Boundary {
    triangles: Vec<[DVec3; 3]>,
    leaves: Vec<Vec<u32>>,
    tree: Tree,
    /// 1 if the triangles are counter-clockwise seen from outside, -1 if they are so seen from inside.
    side: f64,
    /// How far lines are moved aside before they are tested.
    aside: DVec3,
    /// Its planes, where it is convex and has few: normals to the outside, and how far they are from the origin along these.
    planes: Vec<(DVec3, f64)>,
}

/// What is wrong with triangles that are to be around a medium.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// They have no inside: edges without a neighbour, or with several, or with one that is turned the other way round.
    Open,
    /// There is no room in them.
    Flat,
}

impl Boundary {
    /// Creates the boundary of these triangles: object space.
    ///
    /// # Errors
    /// Triangles that are not closed.
    pub fn new(triangles: Vec<[DVec3; 3]>) -> Result<Self, Fault> {
        if !is_closed(&triangles) {
            return Err(Fault::Open);
        }
        let middle = triangles.first().map_or(DVec3::ZERO, |[a, ..]| *a);
        let volume: f64 =
            triangles.iter().map(|[a, b, c]| (a - middle).dot((b - middle).cross(c - middle))).sum();
        if volume == 0.0 || !volume.is_finite() {
            return Err(Fault::Flat);
        }
        Ok(Self::built(triangles, volume.signum()))
    }

    /// The same triangles in another shape.
    #[must_use]
    pub fn in_shape(&self, triangles: Vec<[DVec3; 3]>) -> Self {
        Self::built(triangles, self.side)
    }

    fn built(triangles: Vec<[DVec3; 3]>, side: f64) -> Self {
        let around = |corners: &[DVec3; 3]| Box3::around(corners.map(|corner| corner.as_vec3().to_array()));
        let boxes: Vec<Box3> = triangles.iter().map(around).collect();
        let mut leaves = Vec::new();
        let tree = Tree::quick(&boxes, LEAF, |ids| {
            leaves.push(ids.to_vec());
            leaves.len() as u32 - 1
        });
        let largest =
            |corner: [f32; 3]| corner.into_iter().fold(0.0, |most: f32, value| most.max(value.abs()));
        let size = largest(tree.bounds.low).max(largest(tree.bounds.high));
        let size = f64::from(size);
        let planes = planes(&triangles, side, size * CONVEX_SLACK).unwrap_or_default();
        Self { triangles, leaves, tree, side, aside: ASIDE * size, planes }
    }

    /// The crossings of a convex boundary: where the line is behind all planes, it is inside.
    fn cross_planes(&self, origin: DVec3, along: DVec3, mut each: impl FnMut(f64, f64)) {
        let (mut enters, mut leaves) = (f64::NEG_INFINITY, f64::INFINITY);
        for (normal, offset) in &self.planes {
            let (behind, pace) = (offset - normal.dot(origin), normal.dot(along));
            let at = behind / pace;
            if pace > 0.0 {
                leaves = leaves.min(at);
            } else if pace < 0.0 {
                enters = enters.max(at);
            } else if behind < 0.0 {
                return;
            }
        }
        if enters < leaves && leaves > 0.0 {
            each(leaves, 1.0);
            if enters > 0.0 {
                each(enters, -1.0);
            }
        }
    }

    /// Calls `each` for all crossings of the line at a parameter above 0, in no order: with the parameter, and 1 where the line comes out,
    /// -1 where it goes in. Object space; `along` need not have unit length.
    pub fn crossings(&self, [origin, along]: [DVec3; 2], mut each: impl FnMut(f64, f64)) {
        /// Nodes that are open at once: a tree of any mesh is less deep.
        const MOST: usize = 256;
        if self.tree.nodes.is_empty() || !along.is_finite() || !origin.is_finite() {
            return;
        }
        let origin = origin + self.aside;
        if !self.planes.is_empty() {
            return self.cross_planes(origin, along, each);
        }
        let mut open = [Child::ROOT; MOST];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            match open[count].open() {
                Ok(leaf) => {
                    for triangle in &self.leaves[leaf as usize] {
                        let crossing = crossing(self.triangles[*triangle as usize], origin, along);
                        if let Some((t, side)) = crossing.filter(|(t, _)| *t > 0.0) {
                            each(t, side * self.side);
                        }
                    }
                }
                Err(node) => {
                    let node = &self.tree.nodes[node];
                    for slot in 0..WIDTH {
                        let [low, high] =
                            [0, 3].map(|first| [0, 1, 2].map(|axis| node.planes[first + axis][slot]));
                        if count < MOST && may_meet(low, high, origin, along) {
                            open[count] = node.children[slot];
                            count += 1;
                        }
                    }
                }
            }
        }
    }

    /// Box around it.
    pub fn bounds(&self) -> Box3 {
        self.tree.bounds
    }
}

/// Planes of triangles, if these are convex and few of them have planes of their own.
fn planes(triangles: &[[DVec3; 3]], side: f64, slack: f64) -> Option<Vec<(DVec3, f64)>> {
    // more triangles than a box has in each plane are not worth a look
    if triangles.len() > 2 * FEW_PLANES {
        return None;
    }
    let mut planes: Vec<(DVec3, f64)> = Vec::new();
    for [a, b, c] in triangles {
        let normal = (b - a).cross(c - a) * side;
        // a triangle without an area is in the planes of others
        let Some(normal) = normal.try_normalize() else { continue };
        let plane = (normal, normal.dot(*a));
        if !planes.contains(&plane) {
            planes.push(plane);
        }
    }
    let corners = triangles.iter().flatten();
    let is_behind =
        |(normal, offset): &(DVec3, f64)| corners.clone().all(|corner| normal.dot(*corner) <= offset + slack);
    (planes.len() <= FEW_PLANES && planes.iter().all(is_behind)).then_some(planes)
}

/// Returns true if each edge of the triangles is that of one other, the other way round. Corners are the same where their places are.
fn is_closed(triangles: &[[DVec3; 3]]) -> bool {
    // zeros are the same, whatever their sign
    let key = |corner: DVec3| (corner + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut balance: HashMap<[[u64; 3]; 2], i32> = HashMap::new();
    for corners in triangles {
        let corners = corners.map(key);
        for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(from, to)| (corners[from], corners[to])) {
            // what has shrunk to a line or a point is crossed by no line
            if from < to {
                *balance.entry([from, to]).or_default() += 1;
            } else if to < from {
                *balance.entry([to, from]).or_default() -= 1;
            }
        }
    }
    balance.values().all(|balance| *balance == 0) && !balance.is_empty()
}

/// Returns false if the line does not meet the box at a parameter of 0 or above. A `false` is certain.
fn may_meet(low: [f32; 3], high: [f32; 3], origin: DVec3, along: DVec3) -> bool {
    let (mut near, mut far) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let (low, high) = (f64::from(low[axis]), f64::from(high[axis]));
        if low > high {
            return false;
        }
        let slack = SLACK * low.abs().max(high.abs()).max(origin[axis].abs());
        let (low, high) = (low - slack - origin[axis], high + slack - origin[axis]);
        if along[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return false;
            }
            continue;
        }
        let (one, other) = (low / along[axis], high / along[axis]);
        near = near.max(one.min(other));
        far = far.min(one.max(other));
    }
    near <= far * (1.0 + SLACK)
}

/// Parameter at which a line crosses a triangle, and 1 if it does from behind, -1 from its front.
fn crossing(corners: [DVec3; 3], origin: DVec3, along: DVec3) -> Option<(f64, f64)> {
    let [a, b, c] = corners.map(|corner| corner - origin);
    let volume = |from: usize, to: usize, (p, q): (DVec3, DVec3)| {
        let volume = along.dot(p.cross(q));
        if volume != 0.0 {
            return volume > 0.0;
        }
        // on the edge: the line is beside it, on the side that its corners say
        corners[from].to_array() < corners[to].to_array()
    };
    let sides = [volume(0, 1, (a, b)), volume(1, 2, (b, c)), volume(2, 0, (c, a))];
    if sides != [sides[0]; 3] {
        return None;
    }
    let normal = (b - a).cross(c - a);
    let t = normal.dot(a) / normal.dot(along);
    t.is_finite().then_some((t, if sides[0] { 1.0 } else { -1.0 }))
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::shade::sampling::PathRandom;

    /// The box from `low` to `high`, seen from outside.
    pub fn cuboid(low: DVec3, high: DVec3) -> Vec<[DVec3; 3]> {
        let corner = |number: usize| {
            let pick = |axis: usize| if number >> axis & 1 == 0 { low[axis] } else { high[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
            .into_iter()
            .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
            .map(|corners| corners.map(corner))
            .collect()
    }

    /// Length of the way inside, by the sum of signed parameters.
    fn length(boundary: &Boundary, origin: DVec3, along: DVec3) -> f64 {
        let mut sum = 0.0;
        boundary.crossings([origin, along], |t, side| sum += side * t);
        sum
    }

    #[test]
    fn lines_through_a_box_are_as_long_in_it_as_it_is() {
        let inside_out = cuboid(DVec3::splat(-1.0), DVec3::ONE).into_iter().map(|[a, b, c]| [a, c, b]);
        for triangles in [cuboid(DVec3::splat(-1.0), DVec3::ONE), inside_out.collect()] {
            let boundary = Boundary::new(triangles).expect("it is closed");
            for (origin, along, wanted) in [
                (DVec3::new(0.25, 0.5, -5.0), DVec3::Z, 2.0),
                // through diagonals, corners and edges exactly
                (DVec3::new(0.0, 0.0, -5.0), DVec3::Z, 2.0),
                (DVec3::splat(-3.0), DVec3::ONE, 2.0),
                (DVec3::new(-3.0, 0.0, -3.0), DVec3::new(1.0, 0.0, 1.0), 2.0),
                (DVec3::ZERO, DVec3::X, 1.0),
                (DVec3::ZERO, DVec3::new(0.0, -0.5, 0.0), 2.0),
                (DVec3::new(0.0, 0.0, 5.0), DVec3::Z, 0.0),
                (DVec3::new(3.0, 0.0, -5.0), DVec3::Z, 0.0),
            ] {
                let found = length(&boundary, origin, along);
                assert!((found - wanted).abs() < 1e-8, "{origin} {along}: {found} for {wanted}");
            }
        }
    }

    /// The planes of a convex boundary are crossed where its triangles are.
    #[test]
    fn planes_are_crossed_where_triangles_are() {
        let turn = glam::DQuat::from_rotation_y(0.4) * glam::DQuat::from_rotation_x(1.1);
        let corners = cuboid(DVec3::new(-1.0, 0.5, 2.0), DVec3::new(3.0, 1.0, 2.5));
        let turned =
            corners.iter().map(|triangle| triangle.map(|corner| (turn * corner).as_vec3().as_dvec3()));
        let convex = Boundary::new(turned.collect()).expect("it is closed");
        assert!((6..=12).contains(&convex.planes.len()), "{:?}", convex.planes);
        let meshed =
            Boundary { planes: Vec::new(), ..Boundary::built(convex.triangles.clone(), convex.side) };
        let mut met = 0;
        for number in 0..4000 {
            let [[a, b, c, d], [e, f, ..]] =
                [0, 1].map(|set| PathRandom::new(9, number).four(set).map(f64::from));
            let place =
                |x: f64, y: f64, z: f64| turn * (DVec3::new(-1.0, -1.0, 1.0) + DVec3::new(x, y, z) * 4.0);
            let line = [place(a, b, c), place(d, e, f) - place(a, b, c)];
            let [of_planes, of_triangles] = [&convex, &meshed].map(|boundary| {
                let mut all = Vec::new();
                boundary.crossings(line, |t, side| all.push((t, side)));
                all.sort_by(|a, b| a.0.total_cmp(&b.0));
                all
            });
            // what only just meets an edge may pass beside it
            let length = |all: &[(f64, f64)]| all.iter().map(|(t, side)| t * side).sum::<f64>();
            assert!(
                (length(&of_planes) - length(&of_triangles)).abs() < 1e-5,
                "{of_planes:?} {of_triangles:?}"
            );
            met += of_planes.len();
        }
        assert!(met > 1000, "{met}");
        // what is bent in has no planes
        let mut bent = cuboid(DVec3::ZERO, DVec3::ONE);
        let dent = |corner: DVec3| if corner == DVec3::ONE { DVec3::splat(0.3) } else { corner };
        bent.iter_mut().for_each(|corners| *corners = corners.map(dent));
        assert!(Boundary::new(bent).expect("it is closed").planes.is_empty());
    }

    #[test]
    fn what_goes_in_comes_out_of_a_round_thing() {
        // an octahedron whose edges lie in the planes of the axes, in which lines lie as well
        let tips = [DVec3::X, DVec3::Y, DVec3::Z];
        let mut triangles = Vec::new();
        for signs in 0..8 {
            let sign = |axis: usize| if signs >> axis & 1 == 0 { 1.0 } else { -1.0 };
            let [x, y, z] = [0, 1, 2].map(|axis| tips[axis] * sign(axis));
            let is_turned = sign(0) * sign(1) * sign(2) < 0.0;
            triangles.push(if is_turned { [x, z, y] } else { [x, y, z] });
        }
        let boundary = Boundary::new(triangles).expect("it is closed");
        for number in 0..4000 {
            let [x, y, z, pick] = PathRandom::new(7, number).four(0);
            let grid = |value: f32| f64::from((value * 8.0).floor() - 4.0) / 4.0;
            let (from, to) = (DVec3::new(grid(x), grid(y), -2.0), DVec3::new(grid(z), grid(pick), 2.0));
            let mut inside = 0.0;
            boundary.crossings([from, to - from], |_, side| inside += side);
            assert_eq!(inside, 0.0, "{from} {to}");
        }
    }

    #[test]
    fn what_is_open_is_told() {
        let mut triangles = cuboid(DVec3::ZERO, DVec3::ONE);
        let flat = vec![triangles[0], {
            let [a, b, c] = triangles[0];
            [a, c, b]
        }];
        assert_eq!(Boundary::new(flat).err(), Some(Fault::Flat));
        let [a, b, c] = triangles[3];
        triangles[3] = [a, c, b];
        assert_eq!(Boundary::new(triangles.clone()).err(), Some(Fault::Open), "turned the other way round");
        triangles.remove(3);
        assert_eq!(Boundary::new(triangles).err(), Some(Fault::Open), "a hole");
        assert_eq!(Boundary::new(Vec::new()).err(), Some(Fault::Open), "nothing");
    }
}
