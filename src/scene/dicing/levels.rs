//! How often a cage is subdivided.

use glam::DVec3;
use rayon::prelude::*;

use crate::memory::{self, Need, Part};
use crate::scene::cage::{Cage, in_doubles};
use crate::subdivision::{Hierarchy, Scheme, Topology};

/// Maximum number of times that a cage is subdivided.
pub(super) const MOST_DEPTH: usize = 10;

/// Distance in pixels between the middle of an edge, or of a face, and the surface that it stands for, up to which longer edges stay: less
/// than a half of what a silhouette may be beside its place.
const DEVIATION: f64 = 0.2;

/// Factor by which the next level is nearer to the surface, if it is smooth: a little less than four.
const NEARER: f64 = 3.5;

/// Reciprocal of the share of a mesh's edges, by their lengths in pixels, that may leave the surface by more. Around points where creases or
/// many edges meet levels come nearer by halves alone, in ever smaller places.
const LEFT_OUT: u64 = 200;

/// Parts of a pixel in which lengths are summed up: whole numbers have one sum in any order.
const PARTS_OF_PIXEL: f64 = 1024.0;

/// Bytes that a quadrilateral takes while it is made, at most: in lists of its level and of those before it, in limits, and in a mesh.
const BYTES_OF_QUAD: u64 = 480;

/// Bytes that a vertex takes in each shape, while they are made.
const BYTES_IN_SHAPE: u64 = 12;

/// Maximum number of shapes in which a cage is measured.
const MOST_MEASURED: usize = 4;

/// How finely a shot is diced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::scene) struct Dicing {
    /// Length of edges, pixels.
    pub edge: f64,
    /// Maximum number of triangles of a mesh. As few levels as can be are made in any case.
    pub triangles: u64,
}

/// A cage, subdivided, and why not further.
pub struct Levels {
    /// Its levels.
    pub hierarchy: Hierarchy,
    /// What kept it from being as fine as it should be.
    pub bound: Option<Bound>,
}

/// What keeps a mesh from being finer.
#[derive(Debug, PartialEq)]
pub enum Bound {
    /// The greatest number of triangles, with the number that is there.
    Triangles(u64),
    /// The greatest number of levels.
    Depth,
    /// Memory, with what there is to say of it.
    Memory(String),
}

/// How near an edge is to what it stands for.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Fineness {
    TooCoarse,
    /// The next level is fine enough.
    Almost,
    Enough,
}

/// Subdivides a cage until its edges are fine. `pixels`: for each face of the cage, how many of them a unit is long. `by_length`: true for
/// faces whose edges must be short, however straight they are.
///
/// # Errors If there is not enough memory for as few levels as there can be.
pub fn levels(
    cage: &Cage,
    pixels: &[f64],
    by_length: impl Fn(u32) -> bool + Sync,
    dicing: &Dicing,
) -> Result<Levels, String> {
    let mut hierarchy = Hierarchy::new(&cage.faces());
    let mut measured: Vec<Vec<DVec3>> = measured_shapes(cage).map(in_doubles).collect();
    let mut refine = |hierarchy: &mut Hierarchy| {
        let depth = hierarchy.depth();
        hierarchy.refine();
        for values in &mut measured {
            *values = hierarchy.values(depth, depth + 1, std::mem::take(values));
        }
        measured.iter().map(|values| hierarchy.limit(values)).collect::<Vec<_>>()
    };
    let least = usize::from(!hierarchy.first().is_uniform());
    if least > 0 {
        check_memory(cage, &hierarchy)?;
        refine(&mut hierarchy);
    }
    let mut bound;
    loop {
        let depth = hierarchy.depth();
        let next = triangles_of_next(hierarchy.last());
        bound = if next > dicing.triangles {
            Some(Bound::Triangles(next / 4))
        } else if depth >= MOST_DEPTH {
            Some(Bound::Depth)
        } else {
            check_memory(cage, &hierarchy).err().map(Bound::Memory)
        };
        if bound.is_some() {
            break;
        }
        let limits = refine(&mut hierarchy);
        let measure = |limit: &Vec<DVec3>| fineness(&hierarchy, limit, (pixels, &by_length), dicing.edge);
        match limits.iter().map(measure).min().unwrap_or(Fineness::Enough) {
            Fineness::Enough => {
                hierarchy.coarsen();
                break;
            }
            Fineness::Almost => break,
            Fineness::TooCoarse => {}
        }
    }
    // it may be as fine as it should be at the bound
    if bound.is_some() {
        let limits = measured.iter().map(|values| hierarchy.limit(values));
        let mut all = limits.map(|limit| longest(&hierarchy, &limit, pixels));
        if all.all(|longest| longest <= dicing.edge) {
            bound = None;
        }
    }
    let is_flat = cage.scheme == Scheme::Bilinear && !(0..cage.counts.len() as u32).any(by_length);
    Ok(Levels { hierarchy, bound: bound.filter(|_| !is_flat) })
}

/// Number of triangles of the level after one.
fn triangles_of_next(level: &Topology) -> u64 {
    let of_face = if level.vertex_of_face(0).is_some() { 2 } else { 1 };
    of_face * level.next_faces() as u64
}

/// Some of a cage's shapes.
fn measured_shapes(cage: &Cage) -> impl Iterator<Item = &[[f32; 3]]> {
    let step = cage.shapes.len().div_ceil(MOST_MEASURED).max(1);
    let some = cage.shapes.iter().step_by(step).map(Vec::as_slice);
    [cage.points.as_slice()].into_iter().chain(some)
}

fn check_memory(cage: &Cage, hierarchy: &Hierarchy) -> Result<(), String> {
    let quads = hierarchy.last().next_faces() as u64;
    let shapes = cage.shapes.len() as u64 + measured_shapes(cage).count() as u64 * 4;
    let bytes = quads * (BYTES_OF_QUAD + BYTES_IN_SHAPE * shapes);
    let part =
        Part::new("dicing a mesh", bytes, "a longer `dicing`, fewer `dicing_triangles`, a coarser cage");
    Need::new(part).check(&memory::left()).map_err(|error| error.to_string())
}

/// Lengths of edges by how fine they are.
#[derive(Clone, Copy, Default)]
struct Lengths {
    all: u64,
    /// Of those that leave the surface too far.
    almost: u64,
    /// Of those that leave it too far at the next level as well.
    coarse: u64,
}

impl Lengths {
    fn with(self, other: Self) -> Self {
        Self {
            all: self.all + other.all,
            almost: self.almost + other.almost,
            coarse: self.coarse + other.coarse,
        }
    }

    fn fineness(self) -> Fineness {
        let counts = |part: u64| part.saturating_mul(LEFT_OUT) > self.all;
        match (counts(self.coarse), counts(self.coarse + self.almost)) {
            (true, _) => Fineness::TooCoarse,
            (_, true) => Fineness::Almost,
            _ => Fineness::Enough,
        }
    }
}

/// How fine the level before the last is, by the places to which the vertices of the last go.
fn fineness(
    hierarchy: &Hierarchy,
    limit: &[DVec3],
    (pixels, by_length): (&[f64], &(impl Fn(u32) -> bool + Sync)),
    edge: f64,
) -> Fineness {
    let (cage_faces, level) = (hierarchy.cage_faces_of(hierarchy.depth() - 1), hierarchy.before_last());
    let of_face = |face: u32| level.vertex_of_face(face).map(|vertex| limit[vertex]);
    let of_edge = |edge: u32| limit[level.vertex_of_edge(edge)];
    let of_corner = |corner: u32| {
        let face = level.face_of(corner);
        let cage_face = cage_faces[face as usize];
        let pixels = pixels[cage_face as usize];
        let [from, to] = [corner, level.next(corner)].map(|at| limit[level.corners[at as usize] as usize]);
        let length = (to - from).length() * pixels;
        let all = (length.min(1e9) * PARTS_OF_PIXEL) as u64;
        let of_length = match length {
            length if length <= edge => return (Fineness::Enough, Lengths { all, ..Lengths::default() }),
            length if length <= 2.0 * edge => Fineness::Almost,
            _ => Fineness::TooCoarse,
        };
        if by_length(cage_face) {
            return (of_length, Lengths { all, ..Lengths::default() });
        }
        let of_middle = (of_edge(level.edge_of[corner as usize]) - (from + to) * 0.5).length();
        let corners = level.corners_of(face);
        let count = f64::from(corners.end - corners.start);
        let mean = corners.map(|at| limit[level.corners[at as usize] as usize]).sum::<DVec3>() / count;
        // triangles bend by their edges alone
        let of_face = of_face(face).map_or(0.0, |place| (place - mean).length());
        let deviation = of_middle.max(of_face) * pixels;
        let is_almost = deviation <= DEVIATION * NEARER || of_length == Fineness::Almost;
        let lengths = match deviation <= DEVIATION {
            true => Lengths { all, ..Lengths::default() },
            false if is_almost => Lengths { all, almost: all, ..Lengths::default() },
            false => Lengths { all, coarse: all, ..Lengths::default() },
        };
        (Fineness::Enough, lengths)
    };
    let none = || (Fineness::Enough, Lengths::default());
    let both = |a: (Fineness, Lengths), b: (Fineness, Lengths)| (a.0.min(b.0), a.1.with(b.1));
    let all = (0..level.corners.len() as u32).into_par_iter();
    let (by_length, lengths) = all.map(of_corner).reduce(none, both);
    by_length.min(lengths.fineness())
}

/// Length of the longest edge of the last level in pixels, once its vertices are where they go.
fn longest(hierarchy: &Hierarchy, limit: &[DVec3], pixels: &[f64]) -> f64 {
    let (cage_faces, level) = (hierarchy.cage_faces(), hierarchy.last());
    let of_corner = |corner: u32| {
        let [from, to] = [corner, level.next(corner)].map(|at| limit[level.corners[at as usize] as usize]);
        (to - from).length() * pixels[cage_faces[level.face_of(corner) as usize] as usize]
    };
    (0..level.corners.len() as u32).into_par_iter().map(of_corner).reduce(|| 0.0, f64::max)
}
