//! What media along rays from the eye show: the light that they leave, emit and scatter.
//!
//! A function of the eye, the sample, its seed and the scene, and made anew in each frame, as what mirrors show is; before a camera at rest
//! it is kept with the ray tree of the sample ([`ray_trees`](super::ray_trees)), which each sample has where there are media, those of the
//! background included. The light goes to the layer of what passes through glass; depth, normals and all other data layers are of the
//! sample, as if there were no media.

use glam::Vec3;

use super::bounced_ray::Bounce;
use super::tree_times::TreeTimes;
use crate::frame::grid::bits::set_bits;
use crate::frame::light::light_paths::{AT_ONCE, PathScratch, trace_paths};
use crate::frame::light::path_ends::PathStart;
use crate::frame::light::scattering::SeenRay;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::radiance::{Layer, Light, Radiance};
use crate::frame::surface::ray_tally::RayTally;
use crate::lanes::{F32x8, LANES, Vec3x8};
use crate::media::Media;
use crate::media::spans::Spans;
use crate::samples::{BACKGROUND, CELLS, EMPTY, Tile};
use crate::settings::Backdrop;
use crate::shade::sampling::{PathSequence, hash_of};

/// A ray along which media scatter light.
#[derive(Debug, Clone, Copy)]
struct Scattering {
    cell: u32,
    layer: Layer,
    ray: SeenRay,
    sequence: PathSequence,
}

/// Scratch memory for what media show in a tile.
#[derive(Debug, Default)]
pub struct InMedia {
    /// Share of each sample's light that comes to the eye; empty without media.
    left: Vec<Vec3>,
    rays: Vec<Scattering>,
    spans: Spans,
    gathering: PathScratch,
}

impl InMedia {
    /// Begins with another tile.
    pub fn begin(&mut self, frame: &FrameView) {
        self.rays.clear();
        self.left.clear();
        if frame.media.is_some() {
            self.left.resize(CELLS, Vec3::ONE);
        }
    }

    /// Share of the light of the sample of `cell` that comes to the eye.
    #[inline]
    pub fn left(&self, cell: usize) -> Vec3 {
        self.left.get(cell).copied().unwrap_or(Vec3::ONE)
    }

    /// Looks from the eye to eight samples of a tile, of which the number comes first. Of those whose bit is set in `traced` light that media emit goes to `radiance`, and
    /// what they scatter is asked for [later](Self::scatter).
    pub fn look(
        &mut self,
        frame: &FrameView,
        media: &Media,
        (number, tile): (usize, &Tile),
        (first, traced): (usize, u8),
        (times, radiance): (&mut TreeTimes, &mut Radiance),
    ) {
        let [origins, sights] = frame.sights(tile, first);
        let through_cells =
            frame.view.camera.is_orthographic().then(|| origins_of_cells(frame, number, tile, first));
        for lane in set_bits(bits(&tile.model[first..first + LANES])) {
            let cell = first + lane;
            let (origin, sight) = (origins.lane(lane), sights.lane(lane));
            let is_background = tile.model[cell] == BACKGROUND;
            // in parallel views the background has no place of its own: it is seen along the line through its cell
            let origin = through_cells.filter(|_| is_background).map_or(origin, |origins| origins.lane(lane));
            let far = if is_background { f32::INFINITY } else { sight.length() };
            let direction = sight.normalize_or_zero();
            if direction == Vec3::ZERO {
                continue;
            }
            media.find((origin, direction), far, frame.tick_of(cell as u32), &mut self.spans);
            self.left[cell] = self.spans.left();
            if traced >> lane & 1 == 0 {
                continue;
            }
            times.note_segment(frame, cell as u32, origin, direction, far);
            if is_background && frame.settings.background == Backdrop::Transparent {
                radiance.clear[cell] = self.spans.left().element_sum() / 3.0;
            }
            let ray = SeenRay { origin, direction, far, weight: Vec3::ONE };
            let seed = tile.gathered.seed(cell);
            let sequence = PathSequence::of_media(seed, frame.settings.volume_samples as usize);
            self.show(
                frame,
                Scattering { cell: cell as u32, layer: Layer::Refraction, ray, sequence },
                radiance,
            );
        }
    }

    /// Follows a ray beyond the first surface, which ends at `far`. Returns the share of the light there that comes to its origin.
    pub fn follow(
        &mut self,
        frame: &FrameView,
        media: &Media,
        (bounce, far): (&Bounce, f32),
        radiance: &mut Radiance,
    ) -> Vec3 {
        let Bounce { cell, layer, weight, origin, direction, .. } = *bounce;
        media.find((origin, direction), far, frame.tick_of(cell), &mut self.spans);
        let seed = hash_of(&[origin.to_array(), direction.to_array()].concat());
        let ray = SeenRay { origin, direction, far, weight };
        let sequence = PathSequence::of_media_of_seed(seed);
        self.show(frame, Scattering { cell, layer, ray, sequence }, radiance);
        self.spans.left()
    }

    /// Shows what media along a ray emit, and notes the ray if they scatter anything.
    fn show(&mut self, frame: &FrameView, scattering: Scattering, radiance: &mut Radiance) {
        let Scattering { cell, layer, ray, .. } = scattering;
        radiance.add_secondary(layer, cell as usize, ray.weight * self.spans.emitted(frame.scene.ambient));
        if ray.weight * self.spans.scattered() != Vec3::ZERO {
            self.rays.push(scattering);
        }
    }

    /// Adds to `radiance` the light that media scatter along all rays noted so far.
    pub fn scatter(
        &mut self,
        frame: &FrameView,
        radiance: &mut Radiance,
        times: &mut TreeTimes,
        tally: &mut RayTally,
    ) {
        let Self { rays, gathering, .. } = self;
        let count = frame.settings.volume_samples;
        for some in rays.chunks((AT_ONCE / count as usize).max(1)) {
            gathering.starts.clear();
            for (number, scattering) in (0..).zip(some) {
                let Scattering { cell, ray, sequence, .. } = *scattering;
                let start = PathStart::on_ray((number, cell), sequence, (ray.origin, ray.direction));
                gathering.starts.scatter(&start, ray, 0..count);
            }
            trace_paths(frame, gathering, tally);
            for (start, brought) in gathering.starts.iter().zip(&gathering.brought) {
                let Scattering { cell, layer, .. } = some[start.owner as usize];
                times.note(cell, brought.until);
                if brought.radiance.is_finite() {
                    radiance.add_secondary(layer, cell as usize, brought.radiance / count as f32);
                }
            }
        }
        rays.clear();
    }

    /// Dims the light of all samples to the share of it that comes to the eye.
    pub fn dim(&self, radiance: &mut Radiance) {
        if self.left.is_empty() {
            return;
        }
        let Radiance { diffuse, specular, parts, has_specular, .. } = radiance;
        let parts = [&mut parts.direct, &mut parts.indirect, &mut parts.emission, &mut parts.sky]
            .into_iter()
            .chain(&mut parts.groups);
        let dim = |light: &mut Light| {
            for (axis, column) in light.iter_mut().enumerate() {
                column.iter_mut().zip(&self.left).for_each(|(light, left)| *light *= left[axis]);
            }
        };
        parts.chain([diffuse]).chain(has_specular.then_some(specular)).for_each(dim);
    }
}

/// Origins of the lines of sight through the centres of eight cells of a tile.
fn origins_of_cells(frame: &FrameView, number: usize, tile: &Tile, first: usize) -> Vec3x8 {
    let grid = &frame.view.grid;
    let [x, y] = grid.tile_corner(number).map(|at| F32x8::splat(at as f32 + 0.5));
    let [right, down] = [&grid.place_x, &grid.place_y].map(|places| F32x8::load(places, first));
    let [origins, _] = frame.cameras(tile, first).rays(x + right, y + down);
    origins
}

/// Bit mask of those of eight cells that have a sample, of a surface or of the background.
pub fn bits(models: &[u32]) -> u8 {
    (0..).zip(models).fold(0, |bits, (lane, model): (u8, _)| bits | u8::from(*model != EMPTY) << lane)
}
