//! Fits a camera around all that a file shows in the course of its animation, copies included.
//!
//! What rests is measured corner by corner. Of what moves, and of what has copies, the outline counts: the points that lie farthest in
//! some directions, in each frame.

use std::sync::LazyLock;

use glam::{DAffine3, DVec3};

use super::animation::Clip;
use super::document::Document;
use super::geometry::{self, Geometry};
use super::nodes::Tree;
use super::parts::copies;
use super::skin::{self, Pose};
use crate::scene::SceneError;
use crate::scene::import::faces::are_within_reach;
use crate::scene::import::part_of_file::is_flat;
use crate::scene::turntable::corners::Corners;
use crate::scene::turntable::{Fit, Up};

/// Number of directions of an outline. Of a ball it misses 3 % at most: less than the margin of a fit.
const DIRECTIONS: usize = 64;

/// Largest number of points that are placed, over all frames: of more, fewer frames are measured.
const MOST_PLACED: usize = 4 << 20;

/// Directions that are spread evenly over the ball: E. B. Saff and A. B. J. Kuijlaars, "Distributing Many Points on a Sphere" (1997).
static OUTWARD: LazyLock<[DVec3; DIRECTIONS]> = LazyLock::new(|| {
    let golden = std::f64::consts::PI * (3.0 - 5_f64.sqrt());
    std::array::from_fn(|i| {
        let height = 1.0 - (2.0 * i as f64 + 1.0) / DIRECTIONS as f64;
        let radius = (1.0 - height * height).sqrt();
        let (sin, cos) = (golden * i as f64).sin_cos();
        DVec3::new(radius * cos, height, radius * sin)
    })
});

/// Points that lie farthest in each direction.
struct Outline([(f64, DVec3); DIRECTIONS]);

impl Outline {
    const EMPTY: Self = Self([(f64::NEG_INFINITY, DVec3::ZERO); DIRECTIONS]);

    fn of(points: impl Iterator<Item = DVec3>) -> Self {
        let mut outline = Self::EMPTY;
        points.for_each(|point| outline.add(point));
        outline
    }

    fn add(&mut self, point: DVec3) {
        for (direction, (reach, farthest)) in OUTWARD.iter().zip(&mut self.0) {
            let own = direction.dot(point);
            if own > *reach {
                (*reach, *farthest) = (own, point);
            }
        }
    }

    /// The points, each once; none of nothing.
    fn points(&self) -> Vec<DVec3> {
        let mut points: Vec<DVec3> = Vec::new();
        for (_, point) in self.0.iter().filter(|(reach, _)| reach.is_finite()) {
            if !points.contains(point) {
                points.push(*point);
            }
        }
        points
    }
}

/// Something that is elsewhere, or of another shape, in other frames.
struct Mover {
    node: usize,
    /// True if its points are in the space of the scene.
    is_at_root: bool,
    /// Places of its copies; one without any if it has none.
    copies: Vec<DAffine3>,
    shape: Shape,
}

enum Shape {
    /// Outline of all copies.
    Rigid(Vec<DVec3>),
    /// Vertices, which are posed in each frame.
    Posed(Box<(Pose, Geometry)>),
}

/// Fits a camera around all that is shown in the frames of `clip`.
///
/// # Errors Damaged geometry, or none at all.
pub fn fit(document: &Document, (tree, clip): (&Tree, &Clip), size: [u32; 2]) -> Result<Fit, SceneError> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let mut movers = Vec::new();
    let globals = tree.globals(&clip.locals(tree, 1.0));
    let moved = skin::moved(tree, clip);
    for number in &tree.shown {
        let node = &document.json.nodes[*number];
        let Some(mesh) = node.mesh else { continue };
        let mut geometry = geometry::read(document, mesh)?;
        if node.skin.is_none() && geometry.targets.is_empty() {
            geometry = geometry.without_closed(None);
        }
        if geometry.triangles.is_empty() {
            continue;
        }
        let pose = Pose::new(document, *number, &geometry)?;
        let is_at_root = node.skin.is_some();
        let (is_posed, own) = (pose.is_animated(tree, clip), copies(document, node)?);
        let is_still = is_at_root || !moved[*number];
        if !is_posed && is_still && own.is_none() {
            let first = positions.len() as u32;
            let map = if is_at_root { DAffine3::IDENTITY } else { globals[*number] };
            let of_node = pose.positions(document, (tree, clip), &geometry, 1.0);
            positions.extend(of_node.into_iter().map(|point| placed(&map, of_file(point))));
            triangles.extend(geometry.triangles.iter().map(|triangle| triangle.map(|corner| corner + first)));
            continue;
        }
        let copies = own.unwrap_or(vec![DAffine3::IDENTITY]);
        let shape = if is_posed {
            Shape::Posed(Box::new((pose, geometry)))
        } else {
            let points = pose.positions(document, (tree, clip), &geometry, 1.0);
            Shape::Rigid(outline(&geometry, &points, &copies).points())
        };
        movers.push(Mover { node: *number, is_at_root, copies, shape });
    }
    for point in outline_of_all(document, (tree, clip), &movers).points() {
        triangles.push([positions.len() as u32; 3]);
        positions.push(point.as_vec3().to_array());
    }
    if triangles.is_empty() || !are_within_reach(&positions) {
        let message = "it shows no triangles within 1e18 of the origin: points, lines and empty nodes alone cannot be rendered";
        return Err(document.fault(message));
    }
    let [width, height] = size.map(f64::from);
    let corners = Corners { positions: &positions, triangles: &triangles };
    Ok(Fit::new(&corners, Up::Y, width / height))
}

/// Outline of all movers in all frames.
fn outline_of_all(document: &Document, (tree, clip): (&Tree, &Clip), movers: &[Mover]) -> Outline {
    let count = |mover: &Mover| match &mover.shape {
        Shape::Rigid(points) => points.len(),
        Shape::Posed(posed) => 3 * posed.1.triangles.len() + DIRECTIONS * mover.copies.len(),
    };
    let a_frame = movers.iter().map(count).sum::<usize>().max(1);
    let mut all = Outline::EMPTY;
    for frame in measured(&clip.moments(1), MOST_PLACED / a_frame) {
        let globals = tree.globals(&clip.locals(tree, frame));
        for Mover { node, is_at_root, copies, shape } in movers {
            let map = if *is_at_root { DAffine3::IDENTITY } else { globals[*node] };
            // what is scaled to nothing is not there
            if is_flat(&map) {
                continue;
            }
            let mut add = |points: &[DVec3]| {
                points.iter().for_each(|point| all.add(map.transform_point3(*point)));
            };
            match shape {
                Shape::Rigid(points) => add(points),
                Shape::Posed(posed) => {
                    let (pose, geometry) = &**posed;
                    let points = pose.positions(document, (tree, clip), geometry, frame);
                    add(&outline(geometry, &points, copies).points());
                }
            }
        }
    }
    all
}

/// Those of `frames` that are measured, at most so many but for two: the first, the last, and as many between them at even distances.
fn measured(frames: &[f64], most: usize) -> Vec<f64> {
    let count = frames.len().min(most.max(2));
    (0..count).map(|i| frames[i * (frames.len() - 1) / (count - 1).max(1)]).collect()
}

/// Outline of the triangles of a geometry whose vertices are at these positions, as all copies show it.
fn outline(geometry: &Geometry, positions: &[[f32; 3]], copies: &[DAffine3]) -> Outline {
    let corners = geometry.triangles.as_flattened().iter().map(|corner| of_file(positions[*corner as usize]));
    let one = Outline::of(corners);
    if *copies == [DAffine3::IDENTITY] {
        return one;
    }
    let points = one.points();
    Outline::of(copies.iter().flat_map(|copy| points.iter().map(|point| copy.transform_point3(*point))))
}

fn of_file(position: [f32; 3]) -> DVec3 {
    DVec3::from(position.map(f64::from))
}

fn placed(map: &DAffine3, point: DVec3) -> [f32; 3] {
    map.transform_point3(point).as_vec3().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outline_reaches_nearly_as_far_as_all_points() {
        let ball = (0..2000).map(|i| {
            let (height, turn) = (1.0 - (2.0 * f64::from(i) + 1.0) / 2000.0, f64::from(i) * 2.4);
            let radius = (1.0 - height * height).sqrt();
            DVec3::new(radius * turn.cos(), height, radius * turn.sin())
        });
        let points = Outline::of(ball).points();
        for direction in
            [DVec3::X, DVec3::NEG_Y, DVec3::new(0.6, 0.0, -0.8), DVec3::splat(-(1.0_f64 / 3.0).sqrt())]
        {
            let reach = points.iter().map(|point| point.dot(direction)).fold(0.0, f64::max);
            assert!(reach > 0.96, "{direction}: {reach}");
        }
        assert!(Outline::EMPTY.points().is_empty());
    }

    #[test]
    fn the_first_and_the_last_frame_are_measured() {
        let frames: Vec<f64> = (1..=9).map(f64::from).collect();
        assert_eq!(measured(&frames, 100), frames);
        assert_eq!(measured(&frames, 3), [1.0, 5.0, 9.0]);
        assert_eq!(measured(&frames, 0), [1.0, 9.0]);
        assert_eq!(measured(&[1.0], 7), [1.0]);
    }
}
