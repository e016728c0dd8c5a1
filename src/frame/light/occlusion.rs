//! Ambient occlusion: the openness of samples, up to a radius.
//!
//! Rays leave a sample in directions by the cosine law, each as long as the radius. The share of those that
//! meet nothing that casts a shadow is the sample's openness. It does not depend on the eye, and is kept with
//! the sample, with the first frame in which it may change ([`Motion`](crate::changes::Motion)); then all
//! rays of the sample are cast again. Rays are cast one by one ([`Coherence::Incoherent`]), so that each has
//! the same result to the bit whatever others are cast with it.

use glam::Vec3;

use super::indirect::start_at;
use super::path_ends::PathStart;
use crate::changes::Until;
use crate::frame::grid::bits::{bit, set_bits, surface_bits};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::placed::{Placed, PlacedTile};
use crate::frame::surface::ray_tally::RayTally;
use crate::lanes::LANES;
use crate::layers::Layers;
use crate::samples::{CELLS, Flags, Openness, Tile};
use crate::trace::{Coherence, Occluders, Purpose, RayBatch};

/// A surface whose openness is computed, and the number of its rays.
#[derive(Debug, Clone, Copy)]
pub struct OpenSurface {
    /// Start of its first ray.
    pub start: PathStart,
    /// Number of rays; 0 if the surface is closed.
    pub rays: u32,
}

/// A ray to be cast.
#[derive(Debug, Clone, Copy)]
struct OcclusionRay {
    /// Number of the surface that it leaves.
    look: u32,
    origin: Vec3,
    direction: Vec3,
}

/// Scratch memory of a worker for occlusion.
#[derive(Debug, Default)]
pub struct OcclusionScratch {
    /// Surfaces whose openness is computed.
    pub looks: Vec<OpenSurface>,
    /// Openness of these surfaces, in the same order.
    pub found: Vec<Openness>,
    waiting: Vec<OcclusionRay>,
    rays: RayBatch,
    by_still: Vec<u16>,
    blocked: Vec<u16>,
}

impl OcclusionScratch {
    /// Openness of surface number `number`: the share of its rays that meet nothing.
    pub fn share(&self, number: usize) -> f32 {
        f32::from(self.found[number].open) / self.looks[number].rays.max(1) as f32
    }

    /// Makes the rays of all surfaces, `radius` long, and counts them.
    fn queue(&mut self, radius: f32, tally: &mut RayTally) {
        let Self { looks, waiting, rays, .. } = self;
        waiting.clear();
        rays.clear();
        for (number, OpenSurface { start, rays: count }) in (0..).zip(&*looks) {
            let before = waiting.len();
            let directions = (0..*count).map(|index| {
                let [along, above, ..] = PathStart { index, ..*start }.random().four(RANDOM_SET);
                start.direction([along, above])
            });
            // directions below the surface are closed
            for direction in directions.filter(|direction| start.leaves(*direction)) {
                let origin = start.origin(direction);
                rays.push(origin, direction, 0.0, radius);
                waiting.push(OcclusionRay { look: number, origin, direction });
            }
            let counted = &mut tally.cells.shadow[start.cell as usize];
            *counted = counted.saturating_add((waiting.len() - before) as u16);
        }
        tally.counts.shadow += waiting.len() as u64;
    }
}

/// Number of rays, about, that are cast at once: they fit into a second-level cache.
const AT_ONCE: usize = 1024;

/// Set of random numbers for directions. No path uses it, so that gathered light and openness have no noise
/// in common.
const RANDOM_SET: u32 = 1 << 16;

/// Updates the openness of the samples of `tile`. Samples whose ambient light changes by it are flagged as
/// [`STALE`](Flags::STALE). Returns true if any openness changes, and the first frame in which any may change
/// again.
pub fn find_openness(
    frame: &FrameView,
    tile: &mut Tile,
    placed: &mut PlacedTile,
    scratch: &mut OcclusionScratch,
    tally: &mut RayTally,
) -> (bool, Until) {
    let Some(occlusion) = frame.occlusion else { return (false, Until::FOREVER) };
    let mut any_changed = false;
    scratch.looks.clear();
    for first in (0..CELLS).step_by(LANES) {
        let models = &tile.model[first..first + LANES];
        let (surfaces, moved) = (surface_bits(models), frame.moved_bits(models));
        for lane in set_bits(surfaces) {
            let cell = first + lane;
            if moved >> lane & 1 == 0 && !frame.has_expired(tile.gathered.openness(cell).until) {
                continue;
            }
            if !is_asked(frame, tile.record[cell].material) {
                tile.gathered.set_openness(cell, Openness::CLOSED);
                continue;
            }
            let placed = placed.get(frame, tile, first);
            scratch.looks.push(look_from(frame, tile, cell, &placed, occlusion.rays));
            if scratch.looks.len() * occlusion.rays as usize >= AT_ONCE {
                any_changed |= renew(frame, tile, scratch, tally);
            }
        }
    }
    any_changed |= renew(frame, tile, scratch, tally);
    let surfaces = |first: usize| set_bits(surface_bits(&tile.model[first..first + LANES]));
    let cells = (0..CELLS).step_by(LANES).flat_map(|first| surfaces(first).map(move |lane| first + lane));
    let until = cells.fold(Until::FOREVER, |least, cell| least.min(tile.gathered.openness(cell).until));
    (any_changed, until)
}

/// Returns true if the openness of surfaces of this material is needed.
pub fn is_asked(frame: &FrameView, material: u16) -> bool {
    frame.layers.has(Layers::OCCLUSION) || frame.palette.has_ambient(material)
}

/// Rays of the sample in `cell`; `placed` holds its group of eight cells.
pub fn look_from(frame: &FrameView, tile: &Tile, cell: usize, placed: &Placed, rays: u32) -> OpenSurface {
    OpenSurface { start: start_at(frame, tile, cell, placed, rays as usize), rays }
}

/// Computes the openness of the samples in `scratch`, stores it in the tile, and clears `scratch`. Returns
/// true if any openness changes.
fn renew(frame: &FrameView, tile: &mut Tile, scratch: &mut OcclusionScratch, tally: &mut RayTally) -> bool {
    look_around(frame, scratch, tally);
    let dims_ambient = frame.occlusion.is_some_and(|occlusion| occlusion.dims_ambient);
    let mut any = false;
    for (look, found) in scratch.looks.drain(..).zip(&scratch.found) {
        let cell = look.start.owner as usize;
        if tile.gathered.set_openness(cell, *found) {
            any = true;
            tile.record[cell].flags = tile.record[cell].flags.with(Flags::STALE.when(dims_ambient));
        }
    }
    any
}

/// Computes the openness of the surfaces in `scratch.looks`, and writes it to `scratch.found`.
pub fn look_around(frame: &FrameView, scratch: &mut OcclusionScratch, tally: &mut RayTally) {
    scratch.found.clear();
    scratch.found.resize(scratch.looks.len(), Openness::CLOSED);
    let Some(occlusion) = frame.occlusion else { return };
    scratch.queue(occlusion.radius, tally);
    let OcclusionScratch { looks, found, waiting, rays, by_still, blocked, .. } = scratch;
    frame.set_ticks(rays, waiting.iter().map(|ray| looks[ray.look as usize].start.cell));
    by_still.clear();
    by_still.resize(rays.packet_count(), 0);
    let ask = |by: Occluders, blocked: &mut [u16]| {
        frame.tracer.blocked(rays, by, Purpose::Shadow, Coherence::Incoherent, blocked);
    };
    ask(Occluders::Still, by_still);
    blocked.clone_from(by_still);
    ask(Occluders::Movable, blocked);
    for (number, ray) in waiting.iter().enumerate() {
        let found = &mut found[ray.look as usize];
        found.open += u16::from(!bit(blocked, number));
        // a still occluder stays in the way, whatever else comes there or goes
        if !bit(by_still, number) {
            found.until = found.until.min(frame.first_touch(ray.origin, ray.direction, occlusion.radius));
        }
    }
}
