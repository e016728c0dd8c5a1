//! Triangulation of faces of more than three corners.

use std::collections::HashSet;

use earcut::Earcut;
use glam::DVec3;

/// Cuts polygons into triangles; keeps its buffers from face to face.
pub struct Cutter {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    indices: Vec<u32>,
}

impl Cutter {
    /// Creates a cutter with empty buffers.
    pub fn new() -> Self {
        Self { earcut: Earcut::new(), flat: Vec::new(), indices: Vec::new() }
    }

    /// Triangles (indices into `corners`) that cover the polygon, turning the way that it turns. None
    /// for a polygon without area.
    pub fn cut(&mut self, corners: &[DVec3], mut triangle: impl FnMut([usize; 3])) {
        match corners {
            [] | [_] | [_, _] => {}
            [_, _, _] => triangle([0, 1, 2]),
            [a, b, c, d] => cut_quad([*a, *b, *c, *d]).into_iter().for_each(triangle),
            _ if goes_round_again(corners) => {
                (1..corners.len() - 1).for_each(|i| triangle([0, i, i + 1]));
            }
            _ => self.clip_ears(corners, triangle),
        }
    }

    fn clip_ears(&mut self, corners: &[DVec3], mut triangle: impl FnMut([usize; 3])) {
        let Some(normal) = area_normal(corners).try_normalize() else { return };
        // an orthonormal frame of the face's plane, right-handed with the normal
        let (right, up) = normal.any_orthonormal_pair();
        let up = if right.cross(up).dot(normal) < 0.0 { -up } else { up };
        self.flat.clear();
        self.flat.extend(corners.iter().map(|p| [(*p - corners[0]).dot(right), (*p - corners[0]).dot(up)]));
        self.earcut.earcut(self.flat.iter().copied(), &[], &mut self.indices);
        for cut in self.indices.chunks_exact(3) {
            let [a, b, c] = [cut[0] as usize, cut[1] as usize, cut[2] as usize];
            let [pa, pb, pc] = [self.flat[a], self.flat[b], self.flat[c]];
            let turn = (pb[0] - pa[0]) * (pc[1] - pa[1]) - (pb[1] - pa[1]) * (pc[0] - pa[0]);
            triangle(if turn < 0.0 { [a, c, b] } else { [a, b, c] });
        }
    }
}

/// Returns true if the polygon runs over its own corners again and again. Ear clipping takes cubic time for
/// such, and nobody knows what they mean. (Bridges to holes repeat fewer than half of the corners.)
fn goes_round_again(corners: &[DVec3]) -> bool {
    let distinct: HashSet<[u64; 3]> =
        corners.iter().map(|corner| corner.to_array().map(f64::to_bits)).collect();
    distinct.len() * 2 < corners.len()
}

/// Cuts a quadrilateral along the diagonal that lies inside, or the shorter one if both do.
fn cut_quad(corners: [DVec3; 4]) -> [[usize; 3]; 2] {
    let normal = area_normal(&corners);
    let hollow = |i: usize| {
        let (before, at, after) = (corners[(i + 3) % 4], corners[i], corners[(i + 1) % 4]);
        (at - before).cross(after - at).dot(normal) <= 0.0
    };
    let from_first = if hollow(0) || hollow(2) {
        true
    } else if hollow(1) || hollow(3) {
        false
    } else {
        corners[0].distance_squared(corners[2]) <= corners[1].distance_squared(corners[3])
    };
    if from_first { [[0, 1, 2], [0, 2, 3]] } else { [[0, 1, 3], [1, 2, 3]] }
}

/// Computes Newell's normal: its length is twice the area of the polygon.
fn area_normal(corners: &[DVec3]) -> DVec3 {
    // relative to one corner, so that far away from the origin nothing cancels
    let edges = corners.windows(2).map(|pair| (pair[0] - corners[0]).cross(pair[1] - corners[0]));
    edges.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[DVec3]) -> (usize, f64) {
        let (mut count, mut total) = (0, DVec3::ZERO);
        Cutter::new().cut(corners, |[a, b, c]| {
            count += 1;
            total += (corners[b] - corners[a]).cross(corners[c] - corners[a]) * 0.5;
        });
        (count, total.z)
    }

    fn flat(points: &[[f64; 2]]) -> Vec<DVec3> {
        points.iter().map(|[x, y]| DVec3::new(*x, *y, 5.0)).collect()
    }

    #[test]
    fn quads_take_the_shorter_diagonal() {
        let kite = flat(&[[0.0, 0.0], [5.0, -1.0], [10.0, 0.0], [5.0, 1.0]]).try_into().expect("four");
        assert_eq!(cut_quad(kite), [[0, 1, 3], [1, 2, 3]]);
        assert_eq!(area(&kite), (2, 10.0));
    }

    #[test]
    fn hollow_quads_are_cut_from_the_hollow_corner() {
        let dart = [[0.0, 0.0], [4.0, 4.0], [0.0, 1.0], [-4.0, 4.0]];
        for shift in 0..4 {
            let mut turned = dart;
            turned.rotate_left(shift);
            let corners = flat(&turned);
            assert_eq!(area(&corners), (2, 4.0), "{shift}");
            Cutter::new().cut(&corners, |t| {
                let piece: Vec<_> = t.iter().map(|i| corners[*i]).collect();
                assert!(area_normal(&piece).z > 0.0, "no piece is turned over");
            });
        }
    }

    #[test]
    fn concave_polygons_keep_their_area_and_their_turn() {
        let comb = [
            [0.0, 0.0],
            [7.0, 0.0],
            [7.0, 3.0],
            [6.0, 3.0],
            [6.0, 1.0],
            [4.0, 1.0],
            [4.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [0.0, 3.0],
        ];
        let corners = flat(&comb);
        assert_eq!(area(&corners), (10, 13.0));
        let back: Vec<_> = corners.into_iter().rev().collect();
        assert_eq!(area(&back), (10, -13.0));
    }

    #[test]
    fn a_ring_that_repeats_itself_takes_no_time() {
        let square = flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert!(area(&square.repeat(5000)).1 > 0.0);
    }

    #[test]
    fn polygons_without_area_vanish() {
        assert_eq!(area(&flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [4.0, 0.0]])).0, 0);
    }
}
