//! The proof: what reaches into the room of a patch is one sheet.
//!
//! Let S be all triangles that reach into the room. If
//! 1. all of them are of the patch's model, material and side, with normals near its mean;
//! 2. each edge of theirs that reaches into the room belongs to two of them;
//! 3. none of them reaches to the room's end behind, or to the eyes;
//! 4. one ray in the room meets exactly one of them;
//!
//! then every ray from an eye through the room meets exactly one, in one point. For seen from an eye, S covers the room's directions like
//! a map without folds (1: triangles do not turn their backs; 2: there is no rim; 3: nothing leaves through an end), so that all directions
//! are covered equally often, and one of them once (4).
//!
//! A sample of the patch lies on a triangle of S, so that point is it. A patch of the background is clear if S has nothing.

use glam::{DVec3, Vec3};

use super::EyeBox;
use super::obstacles::{Obstacles, Piece, SearchStack};
use super::patch::{Lanes, Patch, Room, Shows};
use super::volume::cut;
use crate::lanes::{F32x8, LANES, Vec3x8};
use crate::scene::Scene;

/// Triangles of a sheet, at most: where there are more, rays cost less.
const MOST: usize = 64;

/// Share of the coordinates by which rounding may move a point against the plane of a triangle.
const ROUNDING: f32 = 4e-6;

/// Planes of a volume beside what is seen; the others are behind it and behind the eyes.
const LATERAL: usize = 4;

/// Memory of a worker for proofs.
#[derive(Debug, Default)]
pub struct Prover {
    found: Vec<Piece>,
    stack: SearchStack,
    balls: Vec<(Vec3x8, F32x8, u8)>,
    edges: Vec<Edge>,
}

/// An edge that reaches into the room: its ends, the lesser first, as bits.
type Edge = [[u32; 3]; 2];

impl Prover {
    /// Returns true if it is proven that the patch is clear for `eyes`.
    pub fn is_clear(&mut self, scene: &Scene, obstacles: &Obstacles, eyes: &EyeBox, patch: &Patch) -> bool {
        let Some(room) = patch.room(eyes, &mut self.balls) else { return false };
        let Self { found, stack, edges, .. } = self;
        let Shows::Surface { model, material, is_from_behind } = patch.shows else {
            return obstacles.find(&room.volume, (0, &|_| false), stack, found).is_ok();
        };
        let mesh = &scene.models[model as usize].mesh;
        let is_of_sheet = |piece: &Piece| {
            piece.model == model
                && mesh.material_of[piece.triangle as usize] == material
                && faces(piece, eyes, &room, is_from_behind)
                && stays_within(piece, &room)
        };
        obstacles.find(&room.volume, (MOST, &is_of_sheet), stack, found).is_ok()
            && patch.lanes.iter().all(|lanes| are_found(lanes, found))
            && is_without_rim(found, &room, edges)
            && (found.len() == 1 || is_single(found, eyes, patch.lanes))
    }
}

/// Rays that are tried until one meets no edge.
const TRIED: usize = 4;

/// Lanes whose bit is set.
fn lanes_in(used: u8) -> impl Iterator<Item = usize> {
    (0..LANES).filter(move |lane| used >> lane & 1 != 0)
}

/// Returns true if all samples lie on triangles that were found.
fn are_found(Lanes { triangles, used, .. }: &Lanes, found: &[Piece]) -> bool {
    lanes_in(*used).all(|lane| found.iter().any(|piece| piece.triangle == triangles[lane]))
}

/// Returns true if all `eyes` see the triangle from the same side as the patch, and its normal is near the patch's.
fn faces(piece: &Piece, eyes: &EyeBox, room: &Room, is_from_behind: bool) -> bool {
    let [a, b, c] = piece.corners;
    let outside = (b - a).cross(c - a);
    let Some(normal) = (if is_from_behind { -outside } else { outside }).try_normalize() else {
        return false;
    };
    let room_for_rounding = ROUNDING * (a.abs() + eyes.middle.abs()).max_element();
    (normal - room.normal).length() <= room.most_bent
        && normal.dot(eyes.middle - a) - eyes.extent(normal) > room_for_rounding
}

/// Returns true if what of a triangle is between the sides of the room reaches neither to its end nor to the eyes.
fn stays_within(piece: &Piece, room: &Room) -> bool {
    let is_within =
        |corner: &Vec3| room.normal.dot(*corner) > room.behind && room.axis.dot(*corner) > room.eyes_end;
    if piece.corners.iter().all(is_within) {
        return true;
    }
    let (corners, count) = cut(&piece.corners, &room.volume.sides[..LATERAL]);
    corners[..count].iter().all(is_within)
}

/// Returns true if each edge that reaches into the room belongs to two triangles.
fn is_without_rim(found: &[Piece], room: &Room, edges: &mut Vec<Edge>) -> bool {
    edges.clear();
    for piece in found {
        for [from, to] in [[0, 1], [1, 2], [2, 0]] {
            let ends = [piece.corners[from], piece.corners[to]];
            if !room.volume.misses_segment(&ends) {
                let [a, b] = ends.map(|end| end.to_array().map(f32::to_bits));
                edges.push(if a < b { [a, b] } else { [b, a] });
            }
        }
    }
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).all(|same| same.len() == 2)
}

/// Returns true if the ray from the middle of the eyes to one of the samples certainly meets exactly one triangle.
fn is_single(found: &[Piece], eyes: &EyeBox, lanes: &[Lanes]) -> bool {
    let mut samples =
        lanes.iter().flat_map(|lanes| lanes_in(lanes.used).map(|lane| lanes.offsets.lane(lane)));
    samples.by_ref().take(TRIED).find_map(|offset| count(found, eyes.middle, offset)) == Some(1)
}

/// Number of triangles that the ray from `eye` along `direction` meets; `None` if it meets an edge of any, but for rounding.
fn count(found: &[Piece], eye: Vec3, direction: Vec3) -> Option<usize> {
    let (eye, direction) = (eye.as_dvec3(), direction.as_dvec3());
    let mut count = 0;
    for piece in found {
        let [a, b, c] = piece.corners.map(|corner| corner.as_dvec3() - eye);
        // signs of the volumes that the ray spans with the edges
        let volumes = [(a, b), (b, c), (c, a)].map(|(from, to)| volume(from, to, direction));
        let size = volumes.iter().fold(0.0, |most: f64, volume| most.max(volume.abs()));
        if volumes.iter().any(|volume| volume.abs() <= 1e-5 * size) {
            return None;
        }
        let is_met = volumes.iter().all(|volume| *volume > 0.0) || volumes.iter().all(|volume| *volume < 0.0);
        let normal = (b - a).cross(c - a);
        count += usize::from(is_met && normal.dot(a) * normal.dot(direction) > 0.0);
    }
    Some(count)
}

fn volume(from: DVec3, to: DVec3, direction: DVec3) -> f64 {
    from.cross(to).dot(direction)
}
