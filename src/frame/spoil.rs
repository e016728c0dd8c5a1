//! Paths to break what a frame leaves to the next one, one for each class of failure that the audit has to find. For
//! tests of just that.

use std::sync::Arc;

use glam::Vec3;
use half::f16;

use super::tiles::FrameBuffers;
use super::{RenderError, Renderer};
use crate::changes::Until;
use crate::film::Film;
use crate::lanes::Vec3x8;
use crate::pose::Pose;
use crate::samples::{
    CELLS, EMPTY, Flags, KeptPath, MirroredSample, Octahedral, PathColor, Record, Sample, Tag, TagSlot, Tile,
    half_colors,
};
use crate::scene::Scene;
use crate::scene::on_mesh::OnMesh;
use crate::shade::surface::SurfacePoint;
use crate::stereo::Eye;
use crate::trace::{Backend, Coherence, HitBatch, RayBatch, SceneSubset, Search};

/// Class of failure. But for [`Trees`](Spoil::Trees) and what mirrors show it is broken for every seventh cell that shows a surface, and in
/// nothing else: other things that are kept stay as they are or are found out anew.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spoil {
    /// The sample is displaced.
    Place,
    /// The sample is one of the surface behind, which is hidden.
    Sight,
    /// The normal is bent.
    Normal,
    /// The sample is said to be of another triangle.
    Triangle,
    /// The reflectance is halved.
    Reflectance,
    /// The light is brightened.
    Light,
    /// The tags say of lit points that something still hides them, and the other way round.
    Tags,
    /// The radiance of a sample's first path is brightened.
    Gathered,
    /// The last path of a sample is lost.
    Fewer,
    /// The radiance of paths is taken to be valid for a frame longer than it is.
    Until,
    /// The radiance of a sample's first reflected path is brightened.
    Reflected,
    /// Paths are said to be drawn for another direction to the eye.
    DrawnFor,
    /// Reflected paths are taken to be valid for a frame longer than they are.
    ReflectedUntil,
    /// Rays of ambient occlusion are held to find for a frame longer what they found.
    Openness,
    /// Ray trees of mirrors and glass are held to bring for a frame longer what they brought.
    Trees,
    /// What mirrors show is brightened.
    Mirrored,
    /// It is taken to be valid for a frame longer than it is.
    MirroredUntil,
}

impl Renderer<'_> {
    /// Spoils what the frame that the left eye saw last has left. Says how many samples (or, for [`Trees`](Spoil::Trees), trees and tiles) are
    /// spoilt.
    #[doc(hidden)]
    pub fn spoil(&mut self, what: Spoil) -> Result<u64, RenderError> {
        let Some(history) = self.pictures.latest(Eye::Left) else { return Ok(0) };
        let Some(pose) = &history.pose else { return Ok(0) };
        let buffers = history.levels.iter_mut().map(|level| &mut level.buffers);
        if what == Spoil::Trees {
            return Ok(buffers
                .flat_map(|buffers| &mut buffers.states)
                .map(|state| state.trees.delay())
                .sum());
        }
        buffers.for_each(FrameBuffers::forget);
        let stores = history.levels.iter_mut().filter_map(|level| level.store.as_mut());
        if let Some(spoil) = spoil_of_mirrored(what) {
            let samples = stores.flat_map(|store| store.mirrored.all_mut());
            return Ok(samples.map(|sample| u64::from(spoil(sample))).sum());
        }
        let tiles = stores.flat_map(|store| &mut store.tiles);
        if what == Spoil::Until {
            return Ok(tiles.map(|tile| tile.gathered.delay()).sum());
        }
        if what == Spoil::ReflectedUntil {
            return Ok(tiles.map(|tile| tile.gathered.reflected.delay()).sum());
        }
        if what == Spoil::Openness {
            return Ok(tiles.map(|tile| tile.gathered.delay_openness()).sum());
        }
        if what == Spoil::Sight {
            return hide(self.prepared.scene, &mut *self.backend, tiles, pose);
        }
        let mut count = 0;
        for tile in tiles {
            for cell in spoilt_cells(tile) {
                count +=
                    u64::from(spoil_cell(what, &self.prepared.layout.slots, self.prepared.scene, tile, cell));
            }
        }
        Ok(count)
    }
}

impl Renderer<'_> {
    /// Spoils the frame rendered last as it is kept for the next one.
    #[doc(hidden)]
    pub fn spoil_film(&mut self, spoil: impl FnOnce(&mut Film)) {
        if let Some(film) = self.pictures.latest(Eye::Left).and_then(|history| history.film.as_mut()) {
            spoil(Arc::make_mut(film));
        }
    }
}

/// How to break a sample that is seen by way of mirrors; the result says if that was possible.
fn spoil_of_mirrored(what: Spoil) -> Option<fn(&mut MirroredSample) -> bool> {
    match what {
        Spoil::Mirrored => Some(|sample| {
            sample.light = sample.light * 1.5 + 0.1;
            true
        }),
        Spoil::MirroredUntil => Some(|sample| sample.until.delay()),
        _ => None,
    }
}

/// Every seventh cell, where it shows a surface.
fn spoilt_cells(tile: &Tile) -> Vec<usize> {
    (0..CELLS).step_by(7).filter(|cell| tile.model[*cell] < EMPTY).collect()
}

/// Returns true if anything could be spoilt.
fn spoil_cell(what: Spoil, slots: &[TagSlot], scene: &Scene, tile: &mut Tile, cell: usize) -> bool {
    let record = &mut tile.record[cell];
    // where tags are not known, they and the light that they give are found out anew
    let forgets = matches!(what, Spoil::Normal | Spoil::Reflectance);
    let is_spoilt = match what {
        Spoil::Place => {
            [&mut tile.x, &mut tile.y, &mut tile.z].into_iter().for_each(|at| at[cell] += 0.01);
            true
        }
        Spoil::Normal => {
            let normal = record.normal.unfold();
            let aside = normal.any_orthonormal_vector();
            record.normal = Octahedral::fold((normal + 0.1 * aside).normalize());
            true
        }
        Spoil::Triangle => {
            let count = scene.models[tile.model[cell] as usize].mesh.count() as u32;
            record.triangle = (record.triangle + 1) % count;
            count > 1
        }
        Spoil::Reflectance => {
            let kept = record.reflectance;
            record.reflectance = kept.map(|part| f16::from_f32(part.to_f32() * 0.5));
            record.reflectance != kept
        }
        Spoil::Light => {
            record.direct_diffuse =
                record.direct_diffuse.map(|part| f16::from_f32(part.to_f32() * 1.5 + 0.1));
            true
        }
        Spoil::Tags => {
            record.flags = record.flags.with(Flags::STALE);
            slots.iter().fold(false, |any, slot| flip(tile, *slot, cell) | any)
        }
        Spoil::Gathered => {
            tile.gathered.paths.set(cell, 0, bright());
            tile.gathered.update_mean(cell);
            true
        }
        Spoil::Fewer => {
            let last = tile.gathered.paths.paths().checked_sub(1);
            if let Some(last) = last {
                let lost = KeptPath { light: PathColor::UNKNOWN, until: Until::FOREVER };
                tile.gathered.paths.set(cell, last, lost);
                tile.gathered.update_mean(cell);
            }
            last.is_some()
        }
        Spoil::Reflected => {
            let reflected = &mut tile.gathered.reflected;
            reflected.known(cell).next().is_some() && reflected.set(cell, 0, bright())
        }
        Spoil::DrawnFor => {
            let gathered = &mut tile.gathered;
            let has_some = gathered.reflected.known(cell).next().is_some();
            if has_some {
                // so little that the paths still serve
                let to_eye = gathered.drawn_for(cell).unfold();
                let aside = to_eye.any_orthonormal_vector();
                gathered.set_drawn_for(cell, Octahedral::fold((to_eye + 0.02 * aside).normalize()));
            }
            has_some
        }
        Spoil::Sight
        | Spoil::Trees
        | Spoil::Until
        | Spoil::ReflectedUntil
        | Spoil::Openness
        | Spoil::Mirrored
        | Spoil::MirroredUntil => false,
    };
    if forgets {
        tile.tags.forget(&[cell as u32]);
    }
    is_spoilt
}

/// Light that no path brings.
fn bright() -> KeptPath {
    KeptPath { light: PathColor::new(Vec3::splat(7.0), false), until: Until::FOREVER }
}

/// Turns the tags of a cell for one light over. Whether there was any to turn.
fn flip(tile: &mut Tile, slot: TagSlot, cell: usize) -> bool {
    if let Some(tags) = tile.tags.area_mut(slot).get_mut(cell) {
        tags.learn(u16::MAX, !tags.lit(), 0);
        return true;
    }
    let Some(tag) = tile.tags.single_mut(slot).get_mut(cell) else { return false };
    let before = *tag;
    *tag = match before {
        Tag::Lit => Tag::StaticOccluder,
        Tag::StaticOccluder => Tag::Lit,
        other => other,
    };
    *tag != before
}

/// Puts samples of what is behind in the place of samples, seen on the same rays: all that is kept of them is right,
/// but that they are seen.
fn hide<'t>(
    scene: &Scene,
    backend: &mut dyn Backend,
    tiles: impl Iterator<Item = &'t mut Box<Tile>>,
    pose: &Pose,
) -> Result<u64, RenderError> {
    /// Share of the distance from the eye within which a hit is the sample itself.
    const BEHIND: f32 = 1.001;
    let tracer = backend.commit(pose, &vec![false; pose.models.len()])?;
    let is_placed =
        |model: u32| pose.models[model as usize].is_identity && !scene.models[model as usize].mesh.deforms();
    let line_of_sight = |tile: &Tile, cell: usize| {
        let camera = pose.camera_at(tile.record[cell].traced.tick());
        let offset = tile.point(cell) - camera.eye;
        (camera.origin(offset), camera.sight(offset))
    };
    let mut count = 0;
    for tile in tiles {
        let mut cells = spoilt_cells(tile);
        cells.retain(|cell| is_placed(tile.model[*cell]));
        let (mut rays, mut hits) = (RayBatch::default(), HitBatch::default());
        for (origin, sight) in cells.iter().map(|cell| line_of_sight(tile, *cell)) {
            rays.push(origin, sight, BEHIND, f32::INFINITY);
        }
        if pose.has_ticks() {
            rays.set_ticks(cells.iter().map(|cell| tile.record[*cell].traced.tick()));
        }
        tracer.closest(&rays, Search::from_eye(SceneSubset::All, Coherence::Coherent), &mut hits);
        for (ray, cell) in cells.into_iter().enumerate() {
            let Some(hit) = hits.get(ray).filter(|hit| is_placed(hit.model)) else { continue };
            let (origin, sight) = line_of_sight(tile, cell);
            let point = origin + hit.t * sight;
            let model = &scene.models[hit.model as usize];
            let width = tile.record[cell].footprint.width();
            let SurfacePoint { weights, normal, geometric_normal, .. } =
                SurfacePoint::at(scene, (model, hit.triangle), point, width);
            let is_behind = geometric_normal.dot(sight) > 0.0;
            let side = if is_behind { -1.0 } else { 1.0 };
            let place = OnMesh::on(model, hit.triangle, weights).with_width(width);
            let material = place.material();
            let of_place = &scene.materials[usize::from(material)];
            let (color, varied) = place.appearance(scene, of_place);
            let record = Record {
                triangle: hit.triangle,
                normal: Octahedral::fold(normal * side),
                geometric_normal: Octahedral::fold(geometric_normal * side),
                reflectance: half_colors(Vec3x8::splat(color))[0],
                material,
                flags: Flags::FROM_BEHIND.when(is_behind),
                ..tile.record[cell]
            };
            tile.put(cell, Sample { point, model: hit.model, record, varied });
            tile.tags.forget(&[cell as u32]);
            count += 1;
        }
    }
    Ok(count)
}
