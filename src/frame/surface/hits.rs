//! Surfaces that rays have met: eight hits at a time. Hits become surfaces only here.

use glam::Vec3;

use super::computed_hits::ComputedHit;
use super::facing::facing;
use super::tangents::tangent;
use crate::exposure::{MIDDLE_TICK, Tick};
use crate::frame::grid::bits::set_bits;
use crate::frame::shot::frame_view::FrameView;
use crate::lanes::{F32x8, LANES, Vec3x8, are_same};
use crate::prefetch::prefetch;
use crate::scene::look::{Look, Varied};
use crate::scene::material::Bump;
use crate::scene::on_mesh::{LastDensity, OnMesh, appearances, heights};
use crate::scene::{Geometry, Mesh};
use crate::shade::Surface;
use crate::shade::horizon::Horizon;
use crate::shade::surface::{Corners, each_curved};
use crate::trace::{HitPacket, NO_HIT};

/// Eight hits. The values of a lane without a hit mean nothing.
#[derive(Debug, Clone, Copy)]
pub struct Hits8<'a> {
    /// Models; [`NO_HIT`] where nothing was met.
    pub models: &'a [u32],
    /// Triangles of the models' meshes.
    pub triangles: &'a [u32],
    /// Barycentric weights of the second and third corner, as the tracer rounds them.
    pub weights: [F32x8; 2],
    /// What graphs compute of them, by lanes; empty: it has not been computed yet.
    pub computed: &'a [ComputedHit],
}

impl<'a> Hits8<'a> {
    /// Hits of lanes `from` onwards of a packet.
    #[inline(always)]
    pub fn new(hits: &'a HitPacket, from: usize) -> Self {
        Self {
            models: &hits.model[from..from + LANES],
            triangles: &hits.triangle[from..from + LANES],
            weights: [F32x8::load(&hits.u, from), F32x8::load(&hits.v, from)],
            computed: &[],
        }
    }

    /// These hits with what graphs compute of them, at their weights: nothing, or that of eight lanes.
    #[inline(always)]
    pub fn with_computed(self, computed: &'a [ComputedHit]) -> Self {
        Self { computed, ..self }
    }

    /// Returns true if a lane has a hit.
    #[inline(always)]
    pub fn is_hit(&self, lane: usize) -> bool {
        self.models[lane] != NO_HIT
    }

    /// Mesh that was met in a lane, which must have a hit.
    #[inline(always)]
    pub fn mesh<'s>(&self, frame: &FrameView<'s>, lane: usize) -> &'s Mesh {
        &frame.scene.models[self.models[lane] as usize].mesh
    }

    /// Material that was met in a lane, which must have a hit.
    #[inline(always)]
    pub fn material(&self, frame: &FrameView, lane: usize) -> u16 {
        self.mesh(frame, lane).material_of[self.triangles[lane] as usize]
    }

    /// Prefetches the indices of the triangles that were met: their corners and materials. Hits of rays that
    /// go all around lie all over the scene, and each would wait for memory otherwise.
    #[inline(always)]
    pub fn prefetch_triangles(&self, frame: &FrameView) {
        for lane in (0..LANES).filter(|lane| self.is_hit(*lane)) {
            let (mesh, triangle) = (self.mesh(frame, lane), self.triangles[lane] as usize);
            if let Geometry::Triangles(triangles) = &mesh.geometry {
                prefetch(&triangles.corners[triangle..=triangle]);
            }
            prefetch(&mesh.material_of[triangle..=triangle]);
        }
    }

    /// Prefetches the corners of the triangles that were met; their indices should be in the cache.
    #[inline(always)]
    pub fn prefetch_corners(&self, frame: &FrameView) {
        for lane in (0..LANES).filter(|lane| self.is_hit(*lane)) {
            let Geometry::Triangles(triangles) = &self.mesh(frame, lane).geometry else { continue };
            let positions = triangles.positions.as_slice();
            for corner in triangles.corners[self.triangles[lane] as usize].map(|corner| corner as usize) {
                prefetch(&positions[corner..=corner]);
                if let Some(normal) = triangles.normals.get(corner..=corner) {
                    prefetch(normal);
                }
                if let Some(uv) = triangles.uvs.get(corner..=corner) {
                    prefetch(uv);
                }
            }
        }
    }

    /// Corners of the triangles that were met.
    #[inline(always)]
    pub fn corners(&self, frame: &FrameView) -> Corners {
        if are_same(self.triangles) && are_same(self.models) && self.is_hit(0) {
            return Corners::all(self.mesh(frame, 0), self.triangles[0]);
        }
        let mut corners = Corners::NONE;
        for lane in (0..LANES).filter(|lane| self.is_hit(*lane)) {
            corners.set(lane, self.mesh(frame, lane), self.triangles[lane]);
        }
        corners
    }

    /// Writes the points of curved primitives among eight hits, at their weights, into `points`. `curved`: bit mask of their lanes.
    #[inline(always)]
    pub fn put_curved_points(&self, frame: &FrameView, curved: u8, points: &mut Vec3x8) {
        let of = |lane| (self.mesh(frame, lane), self.triangles[lane]);
        let at = |lane: usize| self.weights.map(|weight| weight.lane(lane));
        each_curved(curved, of, |lane, of, primitive| points.set_lane(lane, of.point(primitive, at(lane))));
    }

    /// Writes the normals of curved primitives among eight hits, at `weights`, into both kinds of `normals`.
    #[inline(always)]
    pub fn put_curved_normals(
        &self,
        frame: &FrameView,
        curved: u8,
        weights: [F32x8; 2],
        mut normals: [&mut Vec3x8; 2],
    ) {
        let of = |lane| (self.mesh(frame, lane), self.triangles[lane]);
        each_curved(curved, of, |lane, of, primitive| {
            let normal = of.normal(primitive, weights.map(|weight| weight.lane(lane)));
            normals.iter_mut().for_each(|normals| normals.set_lane(lane, normal));
        });
    }

    /// Writes the weights of `points` on curved primitives among eight hits into `weights`.
    #[inline(always)]
    pub fn put_curved_weights(
        &self,
        frame: &FrameView,
        curved: u8,
        points: &Vec3x8,
        weights: &mut [F32x8; 2],
    ) {
        let of = |lane| (self.mesh(frame, lane), self.triangles[lane]);
        each_curved(curved, of, |lane, of, primitive| {
            let at = of.weights(primitive, points.lane(lane));
            weights.iter_mut().zip(at).for_each(|(weight, at)| weight.set_lane(lane, at));
        });
    }

    /// What the surfaces are made of, and their reflectances, at the points with these barycentric `weights`, over places of these `widths`
    /// (object space).
    #[inline(always)]
    pub fn looks(
        &self,
        frame: &FrameView,
        weights: [F32x8; 2],
        widths: &[f32; LANES],
    ) -> ([Look; LANES], Vec3x8) {
        let (mut looks, mut colors) = ([Look::plain(0); LANES], Vec3x8::ZERO);
        let (mut computed, mut last) = (0, LastDensity::default());
        for lane in (0..LANES).filter(|lane| self.is_hit(*lane)) {
            let place = self.place(frame, lane, weights).with_width(widths[lane]);
            let number = place.material();
            let material = &frame.scene.materials[usize::from(number)];
            looks[lane] = Look::plain(number);
            if frame.palette.varies {
                colors.set_lane(lane, place.painted_beside(frame.scene, material, &mut last));
                computed |= u8::from(material.computed.is_some()) << lane;
            } else {
                colors.set_lane(lane, place.textured_beside(frame.scene, material, &mut last));
            }
        }
        if computed != 0 {
            let made = self.looks_of_graphs(frame, computed, (weights, widths));
            for lane in set_bits(computed) {
                let (factor, varied) = made[lane];
                looks[lane].varied = varied;
                colors.set_lane(lane, colors.lane(lane) * factor);
            }
        }
        (looks, colors)
    }

    /// What graphs make of `lanes`: factors of reflectances, and parameters that vary. Not inlined: most shots have none.
    #[inline(never)]
    fn looks_of_graphs(
        &self,
        frame: &FrameView,
        lanes: u8,
        (weights, widths): ([F32x8; 2], &[f32; LANES]),
    ) -> [(Vec3, Varied); LANES] {
        let mut looks = [(Vec3::ONE, Varied::NONE); LANES];
        if !self.computed.is_empty() {
            set_bits(lanes).for_each(|lane| looks[lane] = self.computed[lane].look);
            return looks;
        }
        for group in self.by_material(frame, lanes) {
            let material = &frame.scene.materials[usize::from(group.material)];
            let Some(computed) = &material.computed else { continue };
            let places = group.lanes.map(|lane| self.place(frame, lane, weights).with_width(widths[lane]));
            let made = appearances(&places[..group.count], frame.scene, computed);
            group.lanes.into_iter().zip(made).take(group.count).for_each(|(lane, look)| looks[lane] = look);
        }
        looks
    }

    /// Heights at places of `lanes`, and beside them. Not inlined: most shots have none.
    #[inline(never)]
    fn heights(
        &self,
        frame: &FrameView,
        lanes: u8,
        (weights, widths): ([F32x8; 2], &[f32; LANES]),
    ) -> [[f32; 3]; LANES] {
        let mut all = [[0.0; 3]; LANES];
        if !self.computed.is_empty() {
            set_bits(lanes).for_each(|lane| all[lane] = self.computed[lane].heights);
            return all;
        }
        for group in self.by_material(frame, lanes) {
            let material = &frame.scene.materials[usize::from(group.material)];
            let Some(bump) = &material.bump else { continue };
            let places = group.lanes.map(|lane| self.place(frame, lane, weights).with_width(widths[lane]));
            let made = heights(&places[..group.count], frame.scene, bump);
            group.lanes.into_iter().zip(made).take(group.count).for_each(|(lane, of)| all[lane] = of);
        }
        all
    }

    /// Materials of `lanes`, in the order in which they come, each with all lanes that have it.
    fn by_material(&self, frame: &FrameView, mut lanes: u8) -> impl Iterator<Item = Group> {
        let mut materials = [0; LANES];
        set_bits(lanes).for_each(|lane| materials[lane] = self.material(frame, lane));
        std::iter::from_fn(move || {
            let first = set_bits(lanes).next()?;
            let mut group = Group { material: materials[first], lanes: [first; LANES], count: 0 };
            for lane in set_bits(lanes).filter(|lane| materials[*lane] == group.material) {
                group.lanes[group.count] = lane;
                group.count += 1;
                lanes &= !(1 << lane);
            }
            Some(group)
        })
    }

    /// Bends the normals (object space, outside) at the points with these `weights`, over places of these `widths` (object space),
    /// where materials have normal maps. `corners`: those of the triangles.
    #[inline(always)]
    pub fn bend_normals(
        &self,
        frame: &FrameView,
        corners: &Corners,
        (weights, widths): ([F32x8; 2], &[f32; LANES]),
        normals: &mut Vec3x8,
    ) {
        if !frame.palette.bends_normals {
            return;
        }
        let mut raised = 0;
        for lane in (0..LANES).filter(|lane| self.is_hit(*lane)) {
            let place = self.place(frame, lane, weights).with_width(widths[lane]);
            let mapped = place.mapped_normal(frame.scene, normals.lane(lane), corners.of_lane(lane));
            normals.set_lane(lane, mapped);
            raised |= u8::from(self.bump(frame, lane).is_some()) << lane;
        }
        if raised == 0 {
            return;
        }
        let heights = self.heights(frame, raised, (weights, widths));
        for lane in set_bits(raised) {
            let Some(bump) = self.bump(frame, lane) else { continue };
            let place = self.place(frame, lane, weights);
            let bent = place.raised(bump, heights[lane], normals.lane(lane), corners.of_lane(lane));
            normals.set_lane(lane, bent);
        }
    }

    /// Heights of the material that was met in a lane, which must have a hit.
    fn bump<'s>(&self, frame: &FrameView<'s>, lane: usize) -> Option<&'s Bump> {
        frame.scene.materials[usize::from(self.material(frame, lane))].bump.as_ref()
    }

    /// Place that was met in a lane, which must have a hit.
    #[inline(always)]
    fn place<'s>(&self, frame: &FrameView<'s>, lane: usize, weights: [F32x8; 2]) -> OnMesh<'s> {
        let weights = weights.map(|weight| weight.lane(lane));
        OnMesh::on(&frame.scene.models[self.models[lane] as usize], self.triangles[lane], weights)
    }
}

/// Lanes of one material.
struct Group {
    material: u16,
    /// Their numbers; behind them the first one.
    lanes: [usize; LANES],
    count: usize,
}

/// Calls `each` with lane and surface for those of the first `count` lanes that have a hit, seen along
/// `directions` (world space) by beams of these widths (world space), at these `ticks`: their normals point to the side from which they
/// are seen.
#[inline(always)]
pub fn surfaces(
    frame: &FrameView,
    hits: &Hits8,
    count: usize,
    directions: impl Fn(usize) -> Vec3,
    beams: impl Fn(usize) -> f32,
    ticks: impl Fn(usize) -> Tick,
    mut each: impl FnMut(usize, Surface),
) {
    let corners = hits.corners(frame);
    let mut point = corners.point(hits.weights);
    let [mut normal, mut geometric_normal] = corners.normals(hits.weights);
    hits.put_curved_points(frame, corners.curved(), &mut point);
    let in_object = point;
    let mut widths = [0.0; LANES];
    if frame.palette.has_textures {
        for lane in (0..count).filter(|lane| hits.is_hit(*lane)) {
            widths[lane] = beams(lane) * frame.scale_to_object(hits.models[lane]);
        }
    }
    hits.bend_normals(frame, &corners, (hits.weights, &widths), &mut normal);
    let normals = [&mut normal, &mut geometric_normal];
    hits.put_curved_normals(frame, corners.curved(), hits.weights, normals);
    let triangle = |lane: usize| hits.triangles[lane];
    let in_use = |lane: usize| if lane < count { ticks(lane) } else { MIDDLE_TICK };
    let of_lanes = || std::array::from_fn(in_use);
    place(frame, (hits.models, triangle), of_lanes, [&mut point, &mut normal, &mut geometric_normal]);
    let mut seen = hits.looks(frame, hits.weights, &widths);
    if frame.palette.is_of_eye {
        let way = |lane: usize| (directions(lane), ticks(lane));
        show_at_angles(frame, hits, count, way, (in_object, geometric_normal), &widths, &mut seen);
    }
    let (looks, reflectances) = seen;
    for lane in (0..count).filter(|lane| hits.is_hit(*lane)) {
        let from_behind = geometric_normal.lane(lane).dot(directions(lane)) > 0.0;
        let side = if from_behind { -1.0 } else { 1.0 };
        let [normal, geometric_normal] = [&normal, &geometric_normal].map(|normal| normal.lane(lane) * side);
        let is_curved = corners.is_smooth(lane) && normal.dot(geometric_normal) < NEARLY_FLAT;
        let at = |lane: usize| (hits.models[lane], hits.triangles[lane]);
        let horizon = if is_curved || frame.palette.bends_normals || frame.palette.has_hair {
            let normals = [normal, geometric_normal];
            horizon(frame, at(lane), (in_object.lane(lane), ticks(lane)), from_behind, normals)
        } else {
            Horizon::flat(normal)
        };
        let surface = Surface {
            point: point.lane(lane),
            normal,
            geometric_normal,
            tangent: tangent(frame, at(lane), hits.weights.map(|weight| weight.lane(lane)), ticks(lane)),
            horizon,
            reflectance: reflectances.lane(lane),
            material: looks[lane].material,
            varied: looks[lane].varied,
            from_behind,
            width: if frame.palette.has_textures { beams(lane) } else { 0.0 },
        };
        each(lane, surface);
    }
}

/// Looks up what the first `count` surfaces are made of, and their reflectances, where that depends on the angle at which they are seen.
/// `way`: direction along which one is seen, and the tick; points in object space, normals (on the outside) in world space. Not inlined:
/// most shots have no such surface.
#[inline(never)]
fn show_at_angles(
    frame: &FrameView,
    hits: &Hits8,
    count: usize,
    way: impl Fn(usize) -> (Vec3, Tick),
    (points, geometric_normals): (Vec3x8, Vec3x8),
    widths: &[f32; LANES],
    (looks, reflectances): &mut ([Look; LANES], Vec3x8),
) {
    for lane in (0..count).filter(|lane| hits.is_hit(*lane)) {
        let material = &frame.scene.materials[usize::from(looks[lane].material)];
        if !material.is_of_eye() {
            continue;
        }
        let (along, tick) = way(lane);
        let outside = geometric_normals.lane(lane);
        let from_behind = outside.dot(along) > 0.0;
        let normal = if from_behind { -outside } else { outside };
        let of = (hits.models[lane], hits.triangles[lane]);
        let facing = facing(frame, of, (points.lane(lane), from_behind, tick), normal, along);
        let place = hits.place(frame, lane, hits.weights).with_width(widths[lane]).seen_at(facing);
        let (color, varied) = place.appearance(frame.scene, material);
        looks[lane].varied = varied;
        reflectances.set_lane(lane, color);
    }
}

/// Cosine between a shading normal and the triangle's above which the curved surface need not be told from it: less than a degree.
const NEARLY_FLAT: f32 = 0.9999;

/// The curved surface that a triangle stands for at a point (object space, at rest) with these normals, world space.
fn horizon(
    frame: &FrameView,
    (model, triangle): (u32, u32),
    (in_object, tick): (Vec3, Tick),
    from_behind: bool,
    [normal, geometric_normal]: [Vec3; 2],
) -> Horizon {
    let is_bent = frame.is_bent(model, triangle);
    match frame.horizon((model, triangle), in_object, from_behind, tick) {
        Some(horizon) if is_bent || horizon.is_fibre => horizon,
        Some(Horizon { lift, .. }) => Horizon { lift, ..Horizon::flat(normal) },
        None if is_bent => Horizon { is_bent, ..Horizon::flat(geometric_normal) },
        None => Horizon::flat(normal),
    }
}

/// Transforms eight surfaces of `models` from object to world space, at these `ticks`; `triangle` gives that of a lane. Normals
/// get unit length. Lanes without a surface stay as they are.
#[inline(always)]
pub fn place(
    frame: &FrameView,
    (models, triangle): (&[u32], impl Fn(usize) -> u32),
    ticks: impl FnOnce() -> [Tick; LANES],
    [point, normal, geometric_normal]: [&mut Vec3x8; 3],
) {
    frame.each_displaced(models, ticks, |place, of_model| {
        place.surfaces(of_model, &triangle, [&mut *point, &mut *normal, &mut *geometric_normal]);
    });
}
