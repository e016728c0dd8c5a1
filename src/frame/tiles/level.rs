//! One level of the samples of a picture: its grid, and what is kept from frame to frame. Without adaptive samples there is
//! one; otherwise each is twice as fine as the one before ([`wanted`](crate::frame::grid::wanted)).

use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use super::{FilmContents, FrameBuffers, Reused, Start, TileScratch, TileSum, contrast, run_tiles};
use crate::changes::Until;
use crate::clear::Obstacles;
use crate::film::Film;
use crate::frame::grid::Grid;
use crate::frame::grid::wanted::{PixelFlags, Wanted};
use crate::frame::reuse::beside::{Beside, Copies};
use crate::frame::reuse::bins::Bins;
use crate::frame::reuse::estimate::Estimate;
use crate::frame::reuse::proofs;
use crate::frame::reuse::reproject;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::CameraChange;
use crate::frame::static_camera::tile_state;
use crate::frame::static_camera::{self, Detached};
use crate::samples::saved::LevelSamples;
use crate::samples::{ClearRegions, LeavingStore, MirroredSamples, OldStore, SampleStore, Status, TagLayout};

/// See the module's documentation.
pub struct Level {
    pub grid: Arc<Grid>,
    /// Samples of the frame rendered last.
    pub store: Option<SampleStore>,
    /// Which of its cells are asked for; all of the coarsest level.
    pub wanted: Option<Wanted>,
    pub buffers: FrameBuffers,
    /// What flat mirrors showed in the frame before the one rendered last, for its audit.
    pub mirrored_before: MirroredSamples,
    layout: TagLayout,
}

/// Memory in which levels are made, one after the other, of whatever picture.
#[derive(Default)]
pub struct LevelScratch {
    bins: Bins,
    /// Of samples that another exposure lends.
    bins_beside: Bins,
    detached: Detached,
    tiles: TileScratch,
}

/// What a level is made of beside its own samples.
#[derive(Clone, Copy)]
pub struct Others<'a> {
    /// Samples of the same level of another picture, which are projected instead of its own.
    pub lent: Option<&'a SampleStore>,
    /// Those of another exposure, which fill cells that the level's own leave open.
    pub beside: Option<&'a SampleStore>,
    /// The models at rest, where proofs are of use.
    pub obstacles: Option<&'a Obstacles>,
}

impl LevelScratch {
    /// Bytes of what is projected, which grow with the picture, and of tiles that belong to no store.
    pub fn bytes(&self, layout: &TagLayout) -> usize {
        self.bins.bytes() + self.bins_beside.bytes() + self.tiles.pool.bytes(layout)
    }
}

impl Level {
    /// Creates a level without samples.
    pub fn new(grid: Arc<Grid>, layout: &TagLayout) -> Self {
        let buffers = FrameBuffers::new(layout.clone());
        let mirrored_before = MirroredSamples::default();
        Self { grid, store: None, wanted: None, buffers, mirrored_before, layout: layout.clone() }
    }

    /// Drops the samples of the frame before, and what was known of them. Their tiles are used again.
    pub fn drop_samples(&mut self, scratch: &mut LevelScratch) {
        self.store.take().into_iter().for_each(|store| scratch.tiles.pool.take(store));
        self.buffers.states.clear();
    }

    /// Forgets what samples have gathered.
    pub fn forget_gathered(&mut self) {
        if let Some(store) = &mut self.store {
            store.tiles.iter_mut().for_each(|tile| tile.forget_gathered());
            store.mirrored = MirroredSamples::default();
        }
        self.buffers.forget();
    }

    /// Has what samples have gathered hold until `changed` of what it did.
    pub fn change_validity(&mut self, changed: impl Fn(Until) -> Until + Sync) {
        if let Some(store) = &mut self.store {
            store.tiles.par_iter_mut().for_each(|tile| tile.change_validity(&changed));
            store.mirrored.all_mut().par_iter_mut().for_each(|sample| sample.until = changed(sample.until));
        }
        self.buffers.forget();
    }

    /// Samples that later frames need of this one.
    pub fn kept(&self) -> Option<LevelSamples<&SampleStore>> {
        let wanted = self.wanted.as_ref().map(Wanted::to_masks);
        self.store.as_ref().map(|store| LevelSamples { store, wanted })
    }

    /// Goes on from what [`kept`](Self::kept) gave.
    pub fn restore(&mut self, kept: LevelSamples<SampleStore>) {
        self.store = Some(kept.store);
        self.wanted = kept.wanted.map(Wanted::from_masks);
    }

    /// Forgets all shadow tags.
    pub fn forget_tags(&mut self) {
        for tile in self.store.iter_mut().flat_map(|store| &mut store.tiles) {
            tile.tags.forget_all();
            tile.spares.forget_tags();
        }
        self.buffers.forget();
    }

    /// Renders this level of a picture into `film`: from its own samples of the frame before, if it has any, or from those of
    /// `others`.
    pub fn render(
        &mut self,
        frame: &FrameView,
        estimate: Estimate,
        others: Others,
        scratch: &mut LevelScratch,
        film: &mut Film,
        shows: FilmContents,
    ) -> TileSum {
        let LevelScratch { bins, bins_beside, detached, tiles } = scratch;
        let Others { lent, beside, obstacles } = others;
        if frame.plan.camera != CameraChange::None {
            self.buffers.states.clear();
        }
        let begin = Instant::now();
        self.buffers.begin_frame(&self.grid);
        let before = lent.or(self.store.as_ref());
        let mut regions = before.map_or_else(ClearRegions::default, |before| before.regions);
        let both = before.zip(obstacles);
        let proofs = both.map(|(before, obstacles)| proofs::choose(frame, obstacles, before, &mut regions));
        let own = self.store.as_mut().map(|store| std::mem::take(&mut store.mirrored)).unwrap_or_default();
        let mirrored = lent.map_or(&own, |lent| &lent.mirrored);
        let mirrored = frame.keeps_mirrored.then_some(mirrored);
        let frame = &FrameView { proofs: proofs.as_ref(), mirrored, ..*frame };
        let (mut now, mut reused) = self.begin(frame, lent, bins, detached);
        if let (Reused::Projected(_, _, lends), Some(store)) = (&mut reused, beside) {
            bins_beside.open(frame.view.grid.tiles());
            reproject::scatter(store, frame, Copies::All, bins_beside);
            *lends = Some(Beside { store, bins: bins_beside });
        }
        let mut start = Start { reused, estimate };
        let projecting = begin.elapsed().as_secs_f64();
        let mut sum = run_tiles(frame, &mut start, &mut now, (&mut self.buffers, tiles), film, shows);
        now.regions = regions;
        let begin = Instant::now();
        now.mirrored = match mirrored {
            None => own,
            Some(before) => {
                let next = before
                    .next(self.buffers.states.iter_mut().map(|state| &mut state.mirrored), |sample| {
                        !frame.motion.expires_next(sample.until, frame.pose.moment)
                    });
                if frame.settings.audit {
                    self.mirrored_before = before.clone();
                }
                next
            }
        };
        sum.projecting = projecting + begin.elapsed().as_secs_f64();
        self.store = Some(now);
        sum
    }

    /// The store of this frame as far as it exists already, and the samples that it reuses.
    fn begin<'c>(
        &mut self,
        frame: &FrameView,
        lent: Option<&'c SampleStore>,
        bins: &'c mut Bins,
        detached: &'c mut Detached,
    ) -> (SampleStore, Reused<'c>) {
        let tiles = frame.view.grid.tiles();
        match (self.store.take(), lent) {
            (_, Some(lent)) => {
                bins.open(tiles);
                reproject::scatter(lent, frame, Copies::Shared, bins);
                (SampleStore::default(), Reused::Projected(OldStore::Lent(lent), bins, None))
            }
            (None, None) => (SampleStore::default(), Reused::None),
            (Some(mut store), None) if frame.plan.camera == CameraChange::None => {
                let states = &mut self.buffers.states;
                bins.open(tiles);
                static_camera::detach(&mut store, states, frame, &self.layout, detached);
                static_camera::scatter(detached, frame, bins);
                tile_state::find_reached(&store, frame, bins, states);
                (store, Reused::InPlace(detached, bins))
            }
            (Some(old), None) => {
                bins.open(tiles);
                let until = reproject::scatter(&old, frame, Copies::Shared, bins);
                let old = OldStore::Leaving(LeavingStore::new(old, &until));
                (SampleStore::default(), Reused::Projected(old, bins, None))
            }
        }
    }

    /// Asks for the pixels that are `flagged`. With `stays`, the camera does not move: what was asked for stays.
    pub fn want(&mut self, flagged: &PixelFlags, stays: bool) {
        let mut wanted = Wanted::new(flagged, &self.grid);
        if let (Some(before), Some(store), true) = (&self.wanted, &mut self.store, stays) {
            wanted.keep(before, |number, new| {
                let tile = &mut store.tiles[number];
                for cell in (0..tile.status.len()).filter(|cell| new.has(*cell)) {
                    if tile.status[cell] == Status::Empty {
                        tile.clear(cell, Status::Missed);
                    }
                }
                if let Some(state) = self.buffers.states.get_mut(number) {
                    state.forget();
                }
            });
        }
        self.wanted = Some(wanted);
    }

    /// The pixels that differ from their neighbours, once the level is made: those of tiles which this frame, or a tile
    /// beside them, has written. Others differ as they did.
    pub fn flag(&self, frame: &FrameView, threshold: f32) -> PixelFlags {
        let Some(store) = &self.store else { return PixelFlags::default() };
        let states = &self.buffers.states;
        let [across, down] = self.grid.tile_counts().map(|count| count as usize);
        let is_asked = |number: usize| {
            let [x, y] = self.grid.place_of_tile(number);
            let is_written = |x: usize, y: usize| states[y * across + x].was_written;
            is_written(x, y)
                || x > 0 && is_written(x - 1, y)
                || y > 0 && is_written(x, y - 1)
                || x + 1 < across && is_written(x + 1, y)
                || y + 1 < down && is_written(x, y + 1)
        };
        contrast::flag(frame, store, &self.buffers.colors, threshold, is_asked)
    }

    /// For each tile of the `finer` level whether this one, or a coarser one, has written into its pixels.
    pub fn written(&self, finer: &Self) -> Vec<bool> {
        let written = |number: usize| {
            let place = finer.grid.place_of_tile(number);
            let [x, y] = [0, 1].map(|axis| {
                let pixels = finer.grid.axes[axis].tile(place[axis]);
                self.grid.axes[axis].tiles_between(pixels, false).start
            });
            self.buffers.states[y * self.grid.tiles_x as usize + x].was_written
        };
        (0..finer.grid.tiles()).map(written).collect()
    }

    /// Cells that have a sample.
    pub fn samples(&self) -> u64 {
        match &self.wanted {
            None => self.grid.all_cells(),
            Some(wanted) => (0..self.grid.tiles()).map(|tile| wanted.tile(tile).count() as u64).sum(),
        }
    }

    /// Bytes in use.
    pub fn bytes(&self, layout: &TagLayout) -> usize {
        let store = self.store.as_ref().map_or(0, |store| store.bytes(layout));
        store + self.buffers.state_bytes()
    }
}
