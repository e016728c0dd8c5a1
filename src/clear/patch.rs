//! A patch: samples beside each other, and the rays that may be cast around them.

use glam::Vec3;

use super::EyeBox;
use super::volume::{SIDES, Side, Volume};
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};

/// Least cosine of the angle between sights and normals of a patch: what is seen at less is not looked into.
const LEAST_COSINE: f32 = 0.06;

/// Largest difference of the unit normals of a patch from their mean, as a share of the least cosine between sights and normals. Two
/// points of a sheet, of which one lies within 0.8 cells of the other, are then off each
/// other's tangent planes by less than a fifth of a cell's width: normals differ by twice this share of the cosine c, so that the way
/// from one point to the other, 0.8 widths / (c - 0.2 c) long, rises by at most 0.2 c of its length.
pub const MOST_BENT: f32 = 0.1;

/// Share of the distance from the eye by which rounding may move a point of a surface or a ray.
const ROUNDING: f32 = 2e-5;

/// Least distance of a patch from the middle of the eyes, in sizes of the box of eyes from its middle to a corner.
const NEAREST: f32 = 4.0;

/// Surface that the samples of a patch show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shows {
    /// None: they show the background.
    Background,
    /// One of a model at rest.
    Surface {
        /// Index into [`Scene::models`](crate::scene::Scene::models).
        model: u32,
        /// Index into [`Scene::materials`](crate::scene::Scene::materials).
        material: u16,
        /// True if the samples see the back of their triangles.
        is_from_behind: bool,
    },
}

/// Eight samples, of which those count whose bit is set.
#[derive(Debug, Clone, Copy)]
pub struct Lanes {
    /// From the middle of the [`EyeBox`] to the samples, world space; directions of unit length to the background.
    pub offsets: Vec3x8,
    /// Normals of the triangles, on the side of the eye: world space, unit length.
    pub normals: Vec3x8,
    /// Numbers of the triangles.
    pub triangles: [u32; LANES],
    /// A bit for each sample that counts.
    pub used: u8,
}

impl Lanes {
    /// None.
    pub const NONE: Self =
        Self { offsets: Vec3x8::ZERO, normals: Vec3x8::ZERO, triangles: [0; LANES], used: 0 };
}

/// Samples of a patch.
#[derive(Debug, Clone, Copy)]
pub struct Patch<'a> {
    /// What all of the samples show.
    pub shows: Shows,
    /// At least one of the samples is used.
    pub lanes: &'a [Lanes],
    /// Directions to the right and to the top of the picture, unit length: sides of the volume are about along them.
    pub axes: [Vec3; 2],
    /// Largest distance of a sample from a ray on which its surface is asked, for each unit of its distance from the eye.
    pub reach: f32,
}

/// What holds the rays of a patch, and what its sheet may be like.
pub(super) struct Room {
    pub volume: Volume,
    /// Mean of the normals; unit length. Zero for the background.
    pub normal: Vec3,
    /// Largest difference of a normal from that.
    pub most_bent: f32,
    /// The axis from the eyes to the patch, unit length; and how far along it, as a scalar product, places of eyes lie at most.
    pub axis: Vec3,
    pub eyes_end: f32,
    /// How far along the normal, as a scalar product, what counts lies at least.
    pub behind: f32,
}

/// Greatest of the values that count.
fn greatest(values: F32x8, used: u8) -> f32 {
    let values = Mask::from_bits(used).select(values, F32x8::splat(f32::NEG_INFINITY));
    values.values().iter().copied().fold(f32::NEG_INFINITY, f32::max)
}

/// Sum of the vectors that count.
fn sum(vectors: Vec3x8, used: u8) -> Vec3 {
    let vectors = Mask::from_bits(used).select3(vectors, Vec3x8::ZERO);
    let [x, y, z] = [vectors.x, vectors.y, vectors.z].map(|axis| axis.values().iter().sum());
    Vec3::new(x, y, z)
}

/// Balls that rays go through: centres, seen from the middle of the eyes, and radii.
type Balls = (Vec3x8, F32x8, u8);

impl Patch<'_> {
    /// Makes room for all rays from `eyes` that go by the samples, up to where they have met the surface. `None` where it is seen edge
    /// on, bent too much, or around the eyes. `balls`: memory.
    pub(super) fn room(&self, eyes: &EyeBox, balls: &mut Vec<Balls>) -> Option<Room> {
        balls.clear();
        let to_patch = self.lanes.iter().map(|lanes| sum(lanes.offsets, lanes.used)).sum::<Vec3>();
        let axis = to_patch.try_normalize()?;
        let right = (self.axes[0] - axis * axis.dot(self.axes[0])).try_normalize()?;
        let down = axis.cross(right);
        let (mut normal, mut most_bent, mut behind) = (Vec3::ZERO, 0.0, f32::NEG_INFINITY);
        let mut last = Side::NONE;
        let mut largest = eyes.middle.abs().max_element();
        if self.shows == Shows::Background {
            let radius = F32x8::splat(self.reach + ROUNDING);
            balls.extend(self.lanes.iter().map(|lanes| (lanes.offsets, radius, lanes.used)));
        } else {
            let surface = self.surface(eyes)?;
            (normal, most_bent) = (surface.normal, MOST_BENT * surface.cosine);
            self.put_balls(eyes, &surface, balls);
            largest += surface.farthest;
            last = Side::about(eyes.middle, -normal, -surface.end, largest);
            behind = -last.limit;
        }
        let mut sides = [Side::NONE; SIDES];
        for (side, lateral) in sides.iter_mut().zip([right, -right, down, -down]) {
            *side = self.side(eyes, balls, [lateral, axis], largest)?;
        }
        sides[4] = Side::about(eyes.middle, -axis, eyes.extent(axis), largest);
        sides[5] = last;
        let eyes_end = axis.dot(eyes.middle) + eyes.extent(axis);
        Some(Room { volume: Volume { sides }, normal, most_bent, axis, eyes_end, behind })
    }

    /// Facts about the samples of a surface; `None` if it is too bent, or seen edge on.
    fn surface(&self, eyes: &EyeBox) -> Option<SurfaceFacts> {
        let normal =
            self.lanes.iter().map(|lanes| sum(lanes.normals, lanes.used)).sum::<Vec3>().try_normalize()?;
        let normals = Vec3x8::splat(normal);
        let size = F32x8::splat(eyes.half.length());
        let along = F32x8::splat(eyes.extent(normal));
        let (mut bent, mut lowest, mut farthest, mut slope) =
            (0.0_f32, f32::INFINITY, 0.0_f32, f32::INFINITY);
        let nearest = self.lanes.iter().map(|lanes| -greatest(-offsets_length(lanes), lanes.used));
        if nearest.fold(f32::INFINITY, f32::min) < NEAREST * eyes.half.length() {
            return None;
        }
        for Lanes { offsets, normals: of_lanes, used, .. } in self.lanes {
            let apart = *of_lanes - normals;
            bent = bent.max(greatest(apart.dot(apart), *used));
            let height = offsets.dot(normals);
            let distance = offsets.dot(*offsets).sqrt() + size;
            lowest = lowest.min(-greatest(-height, *used));
            farthest = farthest.max(greatest(distance, *used));
            // the eyes are above the surface: seen from them its height is negative
            slope = slope.min(-greatest((height + along) / distance, *used));
        }
        // of any ray that goes by a sample
        let cosine = slope - 2.0 * (self.reach + ROUNDING);
        let is_fit = cosine >= LEAST_COSINE && bent.sqrt() <= MOST_BENT * cosine;
        // the sheet may bend beyond the samples as it does between them
        let beyond = farthest * (2.0 * bent.sqrt() * (self.reach + ROUNDING) / cosine + 2.0 * ROUNDING);
        is_fit.then_some(SurfaceFacts { normal, cosine, farthest, end: lowest - beyond })
    }

    /// Adds the balls through which rays go: where they pass samples, and where all of them have met the surface.
    fn put_balls(&self, eyes: &EyeBox, surface: &SurfaceFacts, balls: &mut Vec<Balls>) {
        let size = F32x8::splat(eyes.half.length());
        let normals = Vec3x8::splat(surface.normal);
        let reach = F32x8::splat(self.reach + ROUNDING);
        for Lanes { offsets, used, .. } in self.lanes {
            let distance = offsets.dot(*offsets).sqrt();
            let radius = (distance + size) * reach;
            // from the sample's ball to the end of the room, along a ray
            let way =
                (offsets.dot(normals) + radius - F32x8::splat(surface.end)) / F32x8::splat(surface.cosine);
            let far = *offsets + *offsets * (way / distance);
            // rays from other eyes go another way
            let nearest = distance - size;
            let far_radius =
                radius * (F32x8::ONE + way / nearest) + size * (way / nearest) * F32x8::splat(2.0);
            balls.push((*offsets, radius, *used));
            balls.push((far, far_radius, *used));
        }
    }

    /// A plane that has the eyes and all balls on one side, about along the `axis`; `lateral` leads to its outside.
    fn side(&self, eyes: &EyeBox, balls: &[Balls], [lateral, axis]: [Vec3; 2], largest: f32) -> Option<Side> {
        let [laterals, axes] = [lateral, axis].map(Vec3x8::splat);
        // the background is so far away that the size of the box of eyes plays no part
        let beside = if self.shows == Shows::Background { 0.0 } else { eyes.extent(lateral) };
        let mut slope = f32::NEG_INFINITY;
        for (centres, radii, used) in balls {
            let along = centres.dot(axes) - *radii;
            if greatest(-along, *used) >= 0.0 {
                return None;
            }
            slope =
                slope.max(greatest((centres.dot(laterals) + *radii - F32x8::splat(beside)) / along, *used));
        }
        let normal = lateral - slope * axis;
        let (normals, length) = (Vec3x8::splat(normal), F32x8::splat(normal.length()));
        let mut limit = eyes.extent(normal);
        if self.shows == Shows::Background {
            // none of the directions leads out of a plane that goes by the eyes, if it leans outwards
            return (slope >= 0.0).then(|| Side::about(eyes.middle, normal, limit, largest));
        }
        for (centres, radii, used) in balls {
            limit = limit.max(greatest(centres.dot(normals) + *radii * length, *used));
        }
        Some(Side::about(eyes.middle, normal, limit, largest))
    }
}

/// Distances of eight samples from the middle of the eyes.
fn offsets_length(lanes: &Lanes) -> F32x8 {
    lanes.offsets.dot(lanes.offsets).sqrt()
}

/// Facts about the samples of a surface.
struct SurfaceFacts {
    /// Mean of the normals; unit length.
    normal: Vec3,
    /// Least cosine between the normal and a ray that goes by a sample.
    cosine: f32,
    /// Largest distance of a sample from an eye.
    farthest: f32,
    /// Height along the normal, seen from the middle of the eyes, of the end of the room.
    end: f32,
}
