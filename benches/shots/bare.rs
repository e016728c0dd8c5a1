//! The limit: the rays of a frame that is traced in full, through bare loops of Embree's packet queries.
//!
//! Packets are of the widest kind that is native to the processor, as the renderer's.
//!
//! Built like the renderer's scenes: one of what never moves in the shot, one with an instance of each other
//! model (copies that stand still and share their mesh among them), both robust. The rays are those of the renderer, in its order: primary rays in blocks of 4 x 4
//! cells, then for each light the shadow rays of the surfaces that face it, packed tile by tile; those to the
//! points of an area light make a packet for each surface. Packets are prepared beforehand; only the calls that
//! trace them are timed. What is movable is asked for in those tiles alone in which any ray meets it, which is found
//! out beforehand, too. There are no rays for mirrors and glass.

use std::sync::Arc;
use std::time::Instant;

use afterimage::frame::grid::view::View;
use afterimage::frame::grid::{Grid, holds};
use afterimage::lanes::{F32x8, LANES as HALF, Mask, Vec3x8};
use afterimage::pose::{LightPose, Pose};
use afterimage::samples::CELLS;
use afterimage::scene::{Mesh, Scene};
use afterimage::settings::Settings;
use afterimage::shade::light::{
    LightSample, StratifiedPattern, light_sample, light_samples, seeds_of_places,
};
use afterimage::shade::surface::{Corners, off_surfaces};
use afterimage::trace::embree::device_config;
use afterimage::trace::{LANES, RayBatch, RayPacket};
use embree::{
    ALL_TIMES, BuildQuality, Coherence, Committed, Device, Geometry, GeometryId, INVALID, PacketWidth, Ray,
    RayHit, Scene as EmbreeScene, Valid,
};
use rayon::prelude::*;

/// Cost of tracing alone.
#[derive(Debug, Clone, Copy, Default)]
pub struct TraceCost {
    /// Wall-clock seconds.
    pub seconds: f64,
    /// Number of primary and shadow rays.
    pub rays: u64,
}

/// Place of a geometry's triangles in the scene's lists: model, and first triangle in its mesh.
type Part = (u32, u32);

/// Masks: of triangles that cast shadows, and of rays that meet all triangles.
const SHADOW: u32 = 1;
pub const SIGHT: u32 = 3;

/// Embree's scenes of a shot.
pub struct Bare {
    still: EmbreeScene,
    movable: EmbreeScene,
    /// Model that each instance shows.
    instances: Vec<u32>,
    parts: Parts,
    width: PacketWidth,
}

/// Packets of N rays, each with those that take part.
pub type Packets<const N: usize> = Vec<(Valid<N>, Ray<N>)>;
/// Packets of N rays with their hits, each with those that take part.
pub type HitPackets<const N: usize> = Vec<(Valid<N>, RayHit<N>)>;

/// Places of the triangles of all geometries in both scenes.
#[derive(Default)]
struct Parts {
    still: Vec<Part>,
    /// Places by instance.
    movable: Vec<Vec<Part>>,
}

impl Bare {
    /// Builds both scenes.
    pub fn new(scene: &Scene) -> Result<Self, embree::Error> {
        let config = device_config().expect("the program checks it at its start, too");
        let device = Device::new(&config)?;
        let mut bare = Self {
            still: EmbreeScene::new(&device, BuildQuality::High, true)?,
            movable: EmbreeScene::new(&device, BuildQuality::Low, true)?,
            instances: Vec::new(),
            parts: Parts::default(),
            width: device.native_width(),
        };
        for (model, number) in scene.models.iter().zip(0..) {
            if model.track.is_constant() && !model.is_placed_at_rest() {
                bare.parts.still.extend(attach(&device, &mut bare.still, number, &model.mesh)?);
                continue;
            }
            let mut own = EmbreeScene::new(&device, BuildQuality::High, true)?;
            bare.parts.movable.push(attach(&device, &mut own, number, &model.mesh)?);
            let identity = afterimage::animation::Transform::IDENTITY.columns();
            bare.movable.attach_instance(&own.freeze()?, identity, SIGHT)?;
            bare.instances.push(number);
        }
        bare.still.commit()?;
        Ok(bare)
    }

    /// Width of its packets.
    pub fn width(&self) -> PacketWidth {
        self.width
    }

    /// Scene of everything that never moves.
    pub fn still(&mut self) -> Result<Committed<'_>, embree::Error> {
        self.still.commit()
    }

    /// Traces frame number `frame` of `scene`, which may have other lights than the one it was built for.
    pub fn trace(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        frame: i32,
    ) -> Result<TraceCost, embree::Error> {
        match self.width {
            PacketWidth::Four => self.trace_by::<4>(scene, settings, frame),
            PacketWidth::Eight => self.trace_by::<8>(scene, settings, frame),
            PacketWidth::Sixteen => self.trace_by::<16>(scene, settings, frame),
        }
    }

    fn trace_by<const N: usize>(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        frame: i32,
    ) -> Result<TraceCost, embree::Error> {
        let pose = Pose::new(scene, frame);
        for (instance, model) in self.instances.iter().enumerate() {
            let columns = pose.models[*model as usize].columns();
            self.movable.set_instance_transforms(GeometryId(instance as u32), &[columns], ALL_TIMES)?;
        }
        let scenes = Scenes {
            still: self.still.commit()?,
            movable: (!self.instances.is_empty()).then_some(self.movable.commit()?),
        };
        let view = View::new(&Arc::new(Grid::new(settings)), pose.camera);
        let mut cost = TraceCost::default();
        let mut primary: Vec<HitPackets<N>> = primary_rays(&view);
        let are_near: Vec<bool> = primary.par_iter().map(|tile| scenes.may_meet(tile)).collect();
        cost.time(|| {
            let tiles = primary.par_iter_mut().zip(&are_near);
            tiles.for_each(|(tile, is_near)| scenes.intersect(tile, *is_near));
        });
        cost.rays += count(&primary);
        let surfaces: Vec<Vec<Eight>> =
            primary.par_iter().map(|tile| self.parts.surfaces(scene, &pose, tile)).collect();
        drop(primary);
        for light in &pose.lights {
            let mut shadow: Vec<Packets<N>> =
                surfaces.par_iter().map(|tile| shadow_rays(tile, light)).collect();
            let are_near: Vec<bool> = shadow.par_iter().map(|tile| scenes.may_occlude(tile)).collect();
            cost.time(|| {
                let tiles = shadow.par_iter_mut().zip(&are_near);
                tiles.for_each(|(tile, is_near)| scenes.occlude(tile, *is_near));
            });
            cost.rays += count(&shadow);
        }
        Ok(cost)
    }
}

impl Parts {
    /// Surfaces that the rays of a tile have hit.
    fn surfaces<const N: usize>(
        &self,
        scene: &Scene,
        pose: &Pose,
        tile: &[(Valid<N>, RayHit<N>)],
    ) -> Vec<Eight> {
        (0..tile.len() * N).step_by(HALF).map(|first| self.eight(scene, pose, tile, first)).collect()
    }

    /// Eight of these surfaces, from ray number `first` of the tile on.
    fn eight<const N: usize>(
        &self,
        scene: &Scene,
        pose: &Pose,
        tile: &[(Valid<N>, RayHit<N>)],
        first: usize,
    ) -> Eight {
        let at = |lane: usize| (tile.get((first + lane) / N), (first + lane) % N);
        let mut corners = Corners::NONE;
        let mut models = [None; HALF];
        for (lane, model) in models.iter_mut().enumerate() {
            let (Some((valid, RayHit { hit, .. })), at) = at(lane) else { continue };
            if !valid.is_on(at) || hit.geom_id[at] == INVALID {
                continue;
            }
            let (number, first) = match hit.inst_id[at] {
                INVALID => self.still[hit.geom_id[at] as usize],
                instance => self.movable[instance as usize][hit.geom_id[at] as usize],
            };
            corners.set(lane, &scene.models[number as usize].mesh, first + hit.prim_id[at]);
            *model = Some(number as usize);
        }
        let each = |value: fn(&RayHit<N>, usize) -> f32| {
            let value = |lane| match at(lane) {
                (Some((_, packet)), at) => value(packet, at),
                (None, _) => 0.0,
            };
            F32x8::new(std::array::from_fn(value))
        };
        let weights = [each(|packet, at| packet.hit.u[at]), each(|packet, at| packet.hit.v[at])];
        let (mut point, mut normal, mut geometric_normal) =
            (corners.point(weights), corners.normal(weights), corners.geometric_normal());
        for (lane, model) in models.iter().enumerate() {
            let Some(place) = model.map(|model| &pose.models[model]).filter(|place| !place.is_identity)
            else {
                continue;
            };
            point.set_lane(lane, place.point(point.lane(lane)));
            normal.set_lane(lane, place.normal(normal.lane(lane)));
            geometric_normal.set_lane(lane, place.geometric_normal(geometric_normal.lane(lane)));
        }
        let direction = Vec3x8 {
            x: each(|packet, at| packet.ray.dir_x[at]),
            y: each(|packet, at| packet.ray.dir_y[at]),
            z: each(|packet, at| packet.ray.dir_z[at]),
        };
        let behind = geometric_normal.dot(direction).gt(F32x8::ZERO);
        Eight {
            point,
            normal: behind.select3(-normal, normal),
            geometric_normal: behind.select3(-geometric_normal, geometric_normal),
            is_surface: Mask::new(|lane| models[lane].is_some()).bits(),
        }
    }
}

/// Attaches the geometries of `mesh`. Returns the places of their triangles.
fn attach(
    device: &Device,
    scene: &mut EmbreeScene,
    model: u32,
    mesh: &Mesh,
) -> Result<Vec<Part>, embree::Error> {
    let (all, split) = (mesh.triangles(), mesh.shadow_casting);
    let mut parts = Vec::new();
    for (range, mask) in [(0..split, SIGHT), (split..mesh.count(), SIGHT & !SHADOW)] {
        if range.is_empty() {
            continue;
        }
        parts.push((model, range.start as u32));
        let triangles = match range.len() == mesh.count() {
            true => Arc::clone(&all.corners),
            false => Arc::new(all.corners[range].to_vec()),
        };
        scene.attach(&Geometry::triangles(device, Arc::clone(&all.positions), triangles, mask)?)?;
    }
    Ok(parts)
}

/// Eight surfaces, world space, on the side of the camera.
struct Eight {
    point: Vec3x8,
    normal: Vec3x8,
    geometric_normal: Vec3x8,
    /// Mask of the lanes that hit a surface, a bit each.
    is_surface: u8,
}

/// Both scenes, committed for tracing.
struct Scenes<'a> {
    still: Committed<'a>,
    movable: Option<Committed<'a>>,
}

impl Scenes<'_> {
    /// Returns true if any ray of a tile hits something movable.
    fn may_meet<const N: usize>(&self, packets: &[(Valid<N>, RayHit<N>)]) -> bool {
        let Some(movable) = &self.movable else { return false };
        packets.iter().any(|(valid, packet)| {
            let mut packet = *packet;
            movable.intersect(valid, &mut packet, Coherence::Coherent);
            (0..N).any(|lane| valid.is_on(lane) && packet.hit.is_hit(lane))
        })
    }

    /// Returns true if anything movable occludes any ray of a tile.
    fn may_occlude<const N: usize>(&self, packets: &[(Valid<N>, Ray<N>)]) -> bool {
        let Some(movable) = &self.movable else { return false };
        packets.iter().any(|(valid, ray)| {
            let mut ray = *ray;
            movable.occluded(valid, &mut ray, Coherence::Coherent);
            (0..N).any(|lane| valid.is_on(lane) && ray.is_occluded(lane))
        })
    }

    /// Traces packets. `is_near`: also in the movable scene.
    fn intersect<const N: usize>(&self, packets: &mut [(Valid<N>, RayHit<N>)], is_near: bool) {
        for (valid, packet) in packets {
            self.still.intersect(valid, packet, Coherence::Coherent);
            if let Some(movable) = self.movable.as_ref().filter(|_| is_near) {
                movable.intersect(valid, packet, Coherence::Coherent);
            }
        }
    }

    fn occlude<const N: usize>(&self, packets: &mut [(Valid<N>, Ray<N>)], is_near: bool) {
        for (valid, ray) in packets {
            self.still.occluded(valid, ray, Coherence::Coherent);
            let Some(movable) = self.movable.as_ref().filter(|_| is_near) else { continue };
            let open = Valid::from_fn(|lane| valid.is_on(lane) && !ray.is_occluded(lane));
            if open.any() {
                movable.occluded(&open, ray, Coherence::Coherent);
            }
        }
    }
}

impl TraceCost {
    fn time(&mut self, work: impl FnOnce()) {
        let start = Instant::now();
        work();
        self.seconds += start.elapsed().as_secs_f64();
    }
}

fn count<const N: usize, T: Sync>(tiles: &[Vec<(Valid<N>, T)>]) -> u64 {
    let lanes = |valid: &Valid<N>| (0..N).filter(|lane| valid.is_on(*lane)).count() as u64;
    tiles.par_iter().flat_map_iter(|tile| tile.iter().map(|(valid, _)| lanes(valid))).sum()
}

/// Creates a ray through the centre of each cell, tile by tile.
fn primary_rays<const N: usize>(view: &View) -> Vec<HitPackets<N>> {
    let tile = |number| {
        let mut rays = RayBatch::default();
        push_tile(view, number, &mut rays);
        prepared(&rays, SIGHT).map(|(valid, ray)| (valid, RayHit::new(ray))).collect()
    };
    (0..view.grid.tiles()).into_par_iter().map(tile).collect()
}

/// Creates a ray through the centre of each cell, as batches of rays, a tile each.
pub fn primary_batches(settings: &Settings, pose: &Pose) -> Vec<RayBatch> {
    let view = View::new(&Arc::new(Grid::new(settings)), pose.camera);
    let tile = |number| {
        let mut rays = RayBatch::default();
        push_tile(&view, number, &mut rays);
        rays
    };
    (0..view.grid.tiles()).into_par_iter().map(tile).collect()
}

fn push_tile(view: &View, number: usize, rays: &mut RayBatch) {
    let grid = &view.grid;
    let corner = grid.tile_corner(number).map(|at| F32x8::splat(at as f32 + 0.5));
    let extent = grid.extent(number);
    let far = F32x8::splat(f32::INFINITY);
    for first in (0..CELLS).step_by(HALF) {
        let x = corner[0] + F32x8::load(&grid.place_x, first);
        let y = corner[1] + F32x8::load(&grid.place_y, first);
        let wanted = Mask::new(|lane| holds(extent, first + lane)).bits();
        let [origins, directions] = view.middle().rays(x, y);
        rays.push_lanes(origins, directions, far, wanted);
    }
}

/// Mask of surfaces with these normals whose front a light reaches if nothing is in its way.
fn faces(normal: Vec3x8, geometric_normal: Vec3x8, light_sample: &LightSample) -> Mask {
    let before = |normal: Vec3x8| normal.dot(light_sample.direction).gt(F32x8::ZERO);
    before(normal) & before(geometric_normal) & light_sample.reaches
}

/// Creates the rays from a tile's surfaces to a light that they face.
fn shadow_rays<const N: usize>(tile: &[Eight], light: &LightPose) -> Packets<N> {
    let mut rays = RayBatch::default();
    for eight in tile {
        let origins = off_surfaces(eight.point, eight.geometric_normal);
        let pattern = StratifiedPattern::of_seeds(light, seeds_of_places(eight.point));
        if !light.shape.is_area() {
            let light_sample = light_sample(light, 0, &pattern, eight.point);
            let wanted = eight.is_surface & faces(eight.normal, eight.geometric_normal, &light_sample).bits();
            rays.push_lanes(origins, light_sample.to_light, F32x8::splat(light_sample.far), wanted);
            continue;
        }
        for lane in (0..HALF).filter(|lane| eight.is_surface >> lane & 1 != 0) {
            let light_samples = light_samples(light, &pattern, lane, eight.point.lane(lane));
            let [normal, geometric_normal] =
                [&eight.normal, &eight.geometric_normal].map(|all| Vec3x8::splat(all.lane(lane)));
            let wanted = u16::from_le_bytes(
                [0, 1].map(|half| faces(normal, geometric_normal, &light_samples[half]).bits()),
            );
            if wanted != 0 {
                let ways = [light_samples[0].to_light, light_samples[1].to_light];
                rays.push_packet(origins.lane(lane), ways, light_samples[0].far, wanted);
            }
        }
    }
    prepared(&rays, SHADOW).collect()
}

/// Converts `rays` to Embree's packets, without those of no ray at all.
pub fn prepared<const N: usize>(rays: &RayBatch, mask: u32) -> impl Iterator<Item = (Valid<N>, Ray<N>)> {
    let parts = rays.packets().flat_map(|(packet, lanes)| {
        (0..LANES).step_by(N).map(move |first| (packet, lanes >> first & (u16::MAX >> (LANES - N)), first))
    });
    parts
        .filter(|(_, lanes, _)| *lanes != 0)
        .map(move |(packet, lanes, first)| (Valid::from_bits(lanes), part(packet, first, mask)))
}

/// The rays of `packet` from `first` on.
fn part<const N: usize>(packet: &RayPacket, first: usize, mask: u32) -> Ray<N> {
    let of = |row: &[f32; LANES]| std::array::from_fn(|lane| row[first + lane]);
    let ([org_x, org_y, org_z], [dir_x, dir_y, dir_z]) =
        (packet.origin.each_ref().map(of), packet.direction.each_ref().map(of));
    let (tnear, tfar, mask) = (of(&packet.near), of(&packet.far), [mask; N]);
    Ray { org_x, org_y, org_z, tnear, dir_x, dir_y, dir_z, tfar, mask, ..Ray::default() }
}
