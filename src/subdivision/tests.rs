use std::collections::HashMap;

use super::*;

/// A cage that owns its lists.
#[derive(Default, Clone)]
struct Owned {
    points: Vec<DVec3>,
    counts: Vec<u32>,
    corners: Vec<u32>,
    creases: Vec<([u32; 2], f32)>,
    sharp_points: Vec<(u32, f32)>,
    boundary: Boundary,
}

impl Owned {
    fn hierarchy(&self, scheme: Scheme, depth: usize) -> Hierarchy {
        let mut hierarchy = Hierarchy::new(&CageFaces {
            scheme,
            points: self.points.len(),
            counts: &self.counts,
            corners: &self.corners,
            creases: &self.creases,
            sharp_points: &self.sharp_points,
            boundary: self.boundary,
        });
        (0..depth).for_each(|_| hierarchy.refine());
        hierarchy
    }

    fn limit(&self, depth: usize) -> (Hierarchy, Limit) {
        self.limit_by(Scheme::CatmullClark, depth)
    }

    /// The same cage of triangles: each face is a fan from its first corner on.
    fn cut(&self) -> Self {
        let (mut corners, mut begin) = (Vec::new(), 0);
        for count in &self.counts {
            let face = &self.corners[begin..begin + *count as usize];
            begin += *count as usize;
            corners.extend(face[1..].windows(2).flat_map(|pair| [face[0], pair[0], pair[1]]));
        }
        Self { counts: vec![3; corners.len() / 3], corners, ..self.clone() }
    }

    fn limit_by(&self, scheme: Scheme, depth: usize) -> (Hierarchy, Limit) {
        let hierarchy = self.hierarchy(scheme, depth);
        let values = hierarchy.values(0, depth, self.points.clone());
        let limit = hierarchy.limit_with_normals(&values);
        (hierarchy, limit)
    }
}

/// A cube from -1 to 1. Point number `x + 2 y + 4 z`.
fn cube() -> Owned {
    let sign = |bit: u32| if bit == 0 { -1.0 } else { 1.0 };
    let point = |number: u32| DVec3::new(sign(number & 1), sign(number >> 1 & 1), sign(number >> 2 & 1));
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    Owned {
        points: (0..8).map(point).collect(),
        counts: vec![4; 6],
        corners: faces.as_flattened().to_vec(),
        ..Owned::default()
    }
}

/// Sharp point of the [pot].
const TIP: u32 = 7;

/// A prism over a pentagon without a lid, with semi-sharp edges, a sharp point and a face of five corners: a bit of everything.
fn pot() -> Owned {
    let ring = |height: f64, turn: f64| {
        (0..5).map(move |i| {
            let (sin, cos) = (std::f64::consts::TAU * (f64::from(i) + turn) / 5.0).sin_cos();
            DVec3::new(cos * (1.0 + 0.2 * height), height + 0.1 * sin, sin)
        })
    };
    let points: Vec<DVec3> = ring(0.0, 0.0).chain(ring(1.0, 0.1)).chain(ring(2.0, 0.3)).collect();
    let mut corners: Vec<u32> = vec![0, 1, 2, 3, 4];
    let mut counts = vec![5];
    for row in 0..2 {
        for i in 0..5 {
            let next = (i + 1) % 5;
            corners.extend([row * 5 + i, row * 5 + 5 + i, row * 5 + 5 + next, row * 5 + next]);
            counts.push(4);
        }
    }
    Owned {
        points,
        counts,
        corners,
        creases: vec![
            ([0, 1], 2.5),
            ([1, 2], 0.6),
            ([2, 3], 3.0),
            ([3, 4], 10.0),
            ([4, 0], 10.0),
            ([4, 9], 1.3),
            ([5, 6], 10.0),
            ([8, 13], 0.4),
        ],
        sharp_points: vec![(2, 1.7), (TIP, 10.0)],
        boundary: Boundary::EdgesAndCorners,
    }
}

#[test]
fn the_corner_of_a_cube_goes_where_it_is_known_to_go() {
    for depth in 0..4 {
        let (_, limit) = cube().limit(depth);
        // nine times itself, four times its three neighbours, once what is across its faces: a half, by 24
        for (corner, position) in cube().points.iter().zip(&limit.positions) {
            assert!(position.abs_diff_eq(*corner * 0.5, 1e-12), "{depth}: {position}");
        }
        for (position, normal) in limit.positions.iter().zip(&limit.normals).take(8) {
            assert!(normal.abs_diff_eq(position.normalize(), 1e-9), "{depth}: {normal}");
        }
    }
}

/// The surface does not depend on the level at which it is looked at, whatever is sharp for a few levels.
#[test]
fn vertices_go_to_the_same_places_at_all_levels() {
    for (boundary, scheme) in [
        (Boundary::EdgesAndCorners, Scheme::CatmullClark),
        (Boundary::Edges, Scheme::CatmullClark),
        (Boundary::EdgesAndCorners, Scheme::Loop),
        (Boundary::Edges, Scheme::Loop),
    ] {
        let pot = if scheme == Scheme::Loop { pot().cut() } else { pot() };
        let cage = Owned { boundary, ..pot };
        let (_, coarse) = cage.limit_by(scheme, 1);
        for depth in 2..5 {
            let (_, fine) = cage.limit_by(scheme, depth);
            for (vertex, (one, other)) in coarse.positions.iter().zip(&fine.positions).enumerate() {
                assert!(one.abs_diff_eq(*other, 1e-12), "vertex {vertex}, {depth}: {one} {other}");
            }
        }
    }
}

/// A formula for each kind of place beside the facets of levels that are far finer.
#[test]
fn normals_are_those_of_the_facets_far_below() {
    let sides = |cage: &Owned, scheme: Scheme, depth: usize| {
        let (hierarchy, limit) = cage.limit_by(scheme, depth);
        let level = hierarchy.last();
        let cage_faces = hierarchy.cage_faces_of(depth);
        let corners = 0..level.corners.len() as u32;
        let with_face = corners.map(|corner| (corner, cage_faces[level.face_of(corner) as usize]));
        let mut normals: HashMap<(u32, u32), DVec3> = HashMap::new();
        for (corner, face) in with_face.clone() {
            normals.insert(
                (level.corners[corner as usize], face),
                limit.normals[limit.normal_of[corner as usize] as usize],
            );
        }
        let mut facets: HashMap<(u32, u32), DVec3> = HashMap::new();
        for (corner, face) in with_face {
            let place = |corner: u32| limit.positions[level.corners[corner as usize] as usize];
            let [before, here, after] = [level.previous(corner), corner, level.next(corner)].map(place);
            let across = (after - here).cross(before - here);
            *facets.entry((level.corners[corner as usize], face)).or_default() += across;
        }
        (normals, facets)
    };
    let mut tried = 0;
    for (cage, scheme) in [
        (cube(), Scheme::CatmullClark),
        (pot(), Scheme::CatmullClark),
        (cube().cut(), Scheme::Loop),
        (pot().cut(), Scheme::Loop),
    ] {
        let (normals, _) = sides(&cage, scheme, 1);
        let (_, facets) = sides(&cage, scheme, 7);
        // a sharp point within a smooth surface is the tip of a cone, which has no normal
        for ((vertex, face), normal) in normals.iter().filter(|((vertex, _), _)| *vertex != TIP) {
            let near = facets[&(*vertex, *face)].normalize();
            // facets of one face alone lean a little, and more where many triangles meet beside a crease (`ring.rs` tries these)
            let most = if scheme == Scheme::Loop { 0.98 } else { 0.998 };
            assert!(normal.dot(near) > most, "vertex {vertex}, face {face}: {normal} {near}");
            tried += 1;
        }
    }
    assert!(tried > 120);
}

#[test]
fn sharp_edges_stay_where_they_are() {
    let mut cage = cube();
    cage.creases = vec![([4, 5], 10.0), ([5, 7], 10.0), ([7, 6], 10.0), ([6, 4], 10.0)];
    cage.sharp_points = vec![(4, 10.0), (5, 10.0), (6, 10.0), (7, 10.0)];
    let (hierarchy, limit) = cage.limit(3);
    // the top is a flat square with its corners, and each of its edges has two normals
    let level = hierarchy.last();
    let mut on_rim = 0;
    for corner in 0..level.corners.len() as u32 {
        let (position, normal) = (
            limit.positions[level.corners[corner as usize] as usize],
            limit.normals[limit.normal_of[corner as usize] as usize],
        );
        if hierarchy.cage_faces()[level.face_of(corner) as usize] == 5 {
            assert!(
                (position.z - 1.0).abs() < 1e-12 && normal.abs_diff_eq(DVec3::Z, 1e-9),
                "{position} {normal}"
            );
        } else if (position.z - 1.0).abs() < 1e-12 {
            on_rim += 1;
            let is_corner = position.abs_diff_eq(position.signum(), 1e-12);
            assert!(normal.z.abs() < 0.9 || is_corner, "{position} {normal}");
        }
    }
    assert!(on_rim > 30 && !limit.more.is_empty());
    assert!(limit.positions[7].abs_diff_eq(DVec3::ONE, 1e-12));
}

/// A boundary is a cubic B-spline of its points alone.
#[test]
fn boundaries_are_splines() {
    let (_, limit) = pot().limit(2);
    let points = pot().points;
    let spline =
        |before: usize, at: usize, after: usize| (points[before] + points[at] * 4.0 + points[after]) / 6.0;
    for (before, at, after) in [(10, 11, 12), (11, 12, 13), (14, 10, 11)] {
        assert!(limit.positions[at].abs_diff_eq(spline(before, at, after), 1e-12));
    }
    let sheet = Owned {
        points: vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y],
        counts: vec![4],
        corners: vec![0, 1, 2, 3],
        ..Owned::default()
    };
    let (_, limit) = sheet.limit(2);
    assert_eq!(limit.positions[2], DVec3::new(1.0, 1.0, 0.0), "a corner stays");
    let (_, limit) = Owned { boundary: Boundary::Edges, ..sheet }.limit(2);
    assert!(limit.positions[2].abs_diff_eq(DVec3::new(5.0 / 6.0, 5.0 / 6.0, 0.0), 1e-12));
}

/// Edges of more than two faces, faces that turn the other way round, points where two surfaces touch: nothing of it cracks or is no number.
#[test]
fn odd_cages_are_sharp_and_whole() {
    let mut fan = cube();
    // a third face at an edge, one that turns the other way round, and one that touches a point alone
    fan.points.extend([DVec3::new(2.0, 2.0, 2.0), DVec3::new(-1.0, -1.0, 3.0), DVec3::new(3.0, 0.0, 0.0)]);
    fan.corners.extend([4, 5, 8, 9, 0, 1, 10, 7, 10, 8]);
    fan.counts.extend([4, 3, 3]);
    let (hierarchy, limit) = fan.limit(3);
    assert!(hierarchy.first().odd_edges() >= 2);
    assert!(limit.positions.iter().chain(&limit.normals).all(|value| value.is_finite()));
    assert_eq!(limit.positions[4], fan.points[4]);
}

#[test]
fn bilinear_faces_stay_in_their_place() {
    let cage = cube();
    let hierarchy = cage.hierarchy(Scheme::Bilinear, 3);
    let values = hierarchy.values(0, 3, cage.points.clone());
    let limit = hierarchy.limit_with_normals(&values);
    assert!(limit.positions.iter().all(|place| (place.abs().max_element() - 1.0).abs() < 1e-12));
    let middle = limit.positions.iter().position(|place| place.abs_diff_eq(DVec3::Z, 1e-12));
    assert!(middle.is_some_and(|middle| limit.normals[middle].abs_diff_eq(DVec3::Z, 1e-12)));
}

/// Each edge of a closed surface is gone along once in either direction.
#[test]
fn a_closed_cage_stays_closed() {
    let (hierarchy, _) = cube().limit(3);
    let level = hierarchy.last();
    assert_eq!((level.faces(), level.vertices, level.ends.len()), (384, 386, 768));
    assert!(level.begun_at.iter().all(|begun| begun[1] != NONE));
}

/// Limits by hand, of the weights that C. Loop gives.
#[test]
fn triangles_go_where_they_are_known_to_go() {
    let of = |points: &[[f64; 3]], faces: &[[u32; 3]]| Owned {
        points: points.iter().map(|point| DVec3::from(*point)).collect(),
        counts: vec![3; faces.len()],
        corners: faces.as_flattened().to_vec(),
        ..Owned::default()
    };
    // three neighbours weigh 3/16 each: a corner goes to (2 itself + its neighbours) / 5, and these sum up to minus itself
    let tetrahedron = of(
        &[[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]],
        &[[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
    );
    // four weigh 31/256 each: it goes to (96/31 itself + its neighbours) / (96/31 + 4), and these sum up to nothing
    let octahedron = of(
        &[
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [-1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, -1.0],
        ],
        &[[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]],
    );
    for (cage, share) in [(tetrahedron, 0.2), (octahedron, 24.0 / 55.0)] {
        for depth in 0..4 {
            let (hierarchy, limit) = cage.limit_by(Scheme::Loop, depth);
            for (at, (point, normal)) in cage.points.iter().zip(limit.positions.iter().zip(&limit.normals)) {
                assert!(point.abs_diff_eq(*at * share, 1e-12), "{depth}: {at} {point}");
                assert!(normal.abs_diff_eq(at.normalize(), 1e-9), "{depth}: {at} {normal}");
            }
            let level = hierarchy.last();
            assert_eq!(level.faces(), cage.counts.len() << (2 * depth));
            assert!(level.begun_at.iter().all(|begun| begun[1] != NONE), "it stays closed");
            assert_eq!(level.vertices + level.faces(), level.ends.len() + 2);
        }
    }
    // a hexagon that is flat stays flat, and its middle where it is; its boundary is a spline, or keeps a corner that one triangle has
    let rim = (0..6).map(|i| (std::f64::consts::TAU * f64::from(i) / 6.0).sin_cos());
    let points: Vec<[f64; 3]> = [[0.0; 3]].into_iter().chain(rim.map(|(sin, cos)| [cos, sin, 0.0])).collect();
    let mut hexagon = of(&points, &[1, 2, 3, 4, 5, 6].map(|i| [0, i, i % 6 + 1]));
    hexagon.points.push(DVec3::new(1.5, 1.5, 0.0));
    hexagon.corners.extend([2, 1, 7]);
    hexagon.counts.push(3);
    let (_, limit) = hexagon.limit_by(Scheme::Loop, 2);
    assert!(limit.positions.iter().all(|at| at.z == 0.0));
    assert!(limit.normals.iter().all(|normal| normal.abs_diff_eq(DVec3::Z, 1e-9)));
    assert!(limit.positions[0].length() < 1e-12);
    assert_eq!(limit.positions[7], hexagon.points[7]);
    let spline = (hexagon.points[3] + hexagon.points[4] * 4.0 + hexagon.points[5]) / 6.0;
    assert!(limit.positions[4].abs_diff_eq(spline, 1e-12));
}

/// In a net of triangles that are all alike the surface is a spline, which has places and slopes of quadratic functions: z = x² goes to x² and
/// what the neighbours' mean lifts it by.
#[test]
fn a_regular_net_of_triangles_is_a_spline() {
    let at = |x: u32, y: u32| 7 * y + x;
    let place = |number: u32| {
        let (x, y) = (f64::from(number % 7), f64::from(number / 7));
        let x = x + y * 0.5 - 4.5;
        DVec3::new(x, (y - 3.0) * 0.75_f64.sqrt(), x * x)
    };
    let faces = (0..6).flat_map(|y| {
        (0..6).flat_map(move |x| {
            [[at(x, y), at(x + 1, y), at(x, y + 1)], [at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]]
        })
    });
    let corners: Vec<u32> = faces.flatten().collect();
    let cage = Owned {
        points: (0..49).map(place).collect(),
        counts: vec![3; corners.len() / 3],
        corners,
        ..Owned::default()
    };
    let (_, limit) = cage.limit_by(Scheme::Loop, 0);
    let middle = at(3, 3) as usize;
    // its six neighbours are at x ± 1 and, twice, at x ± 1/2: their squares are 3 more in sum, of which a twelfth counts
    let x = cage.points[middle].x;
    assert!((limit.positions[middle].z - x * x - 0.25).abs() < 1e-12, "{}", limit.positions[middle]);
    let slope = DVec3::new(-2.0 * x, 0.0, 1.0).normalize();
    assert!(limit.normals[middle].abs_diff_eq(slope, 1e-9), "{}", limit.normals[middle]);
}
