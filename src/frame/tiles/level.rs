//! One level of the samples of a picture: its grid, and what is kept from frame to frame. Without adaptive samples there is
//! one; otherwise each is twice as fine as the one before ([`wanted`](crate::frame::grid::wanted)).

use std::sync::Arc;

use rayon::prelude::*;

use super::{FrameBuffers, Reused, Shows, Start, TileSum, contrast, run_tiles};
use crate::changes::Until;
use crate::film::Film;
use crate::frame::grid::Grid;
use crate::frame::grid::wanted::{PixelFlags, Wanted};
use crate::frame::reuse::bins::Bins;
use crate::frame::reuse::estimate::Estimate;
use crate::frame::reuse::reproject;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::CameraChange;
use crate::frame::static_camera::tile_state::{self, TileState};
use crate::frame::static_camera::{self, Detached};
use crate::samples::saved::LevelSamples;
use crate::samples::{SampleStore, Status, TagLayout};
use crate::settings::Settings;

/// See the module's documentation.
pub struct Level {
    pub grid: Arc<Grid>,
    /// Samples of the frame rendered last.
    pub store: Option<SampleStore>,
    /// They are another eye's, and go back to it.
    is_lent: bool,
    /// Those that were lent, when the level is made.
    lent: Option<SampleStore>,
    /// Which of its cells are asked for; all of the coarsest level.
    pub wanted: Option<Wanted>,
    pub buffers: FrameBuffers,
    bins: Bins,
    detached: Detached,
    layout: TagLayout,
}

impl Level {
    /// All levels of pictures as `settings` ask for them.
    pub fn all(settings: &Settings, layout: &TagLayout) -> Vec<Self> {
        let all: Vec<u32> = settings.levels().collect();
        let finer = (0..all.len() as u32).rev();
        all.into_iter()
            .zip(finer)
            .map(|(samples, finer)| Self::new(settings, samples, finer, layout))
            .collect()
    }

    /// Of `samples` along a pixel's edge, with `finer` finer ones: what these are asked for depends on a pixel more around
    /// each.
    fn new(settings: &Settings, samples: u32, finer: u32, layout: &TagLayout) -> Self {
        let reach = settings.filter_reach().max(finer);
        Self {
            grid: Arc::new(Grid::reaching(&Settings { samples, ..settings.clone() }, reach)),
            store: None,
            is_lent: false,
            lent: None,
            wanted: None,
            buffers: FrameBuffers::new(layout.clone()),
            layout: layout.clone(),
            bins: Bins::default(),
            detached: Detached::default(),
        }
    }

    /// Drops the samples of the frame before, and what was known of them; those that are lent it keeps for who has lent them.
    pub fn drop_samples(&mut self) {
        if std::mem::take(&mut self.is_lent) {
            self.lent = self.store.take();
        }
        self.store.take().into_iter().for_each(|store| self.buffers.pool.take(store));
        self.buffers.states.clear();
    }

    /// Takes the samples of the same level as another eye has it, for one frame, and drops its own.
    pub fn borrow_from(&mut self, other: &mut Self) {
        self.drop_samples();
        self.store = other.store.take();
        self.is_lent = self.store.is_some();
    }

    /// Gives back what was lent, whether it was of use or not.
    pub fn give_back_to(&mut self, other: &mut Self) {
        let unused = if self.is_lent { self.store.take() } else { None };
        other.store = self.lent.take().or(unused).or(other.store.take());
        self.is_lent = false;
    }

    /// Takes what the same level of other pictures has to work in.
    pub fn take_room_from(&mut self, other: &mut Self) {
        self.buffers.take_room_from(&mut other.buffers);
        std::mem::swap(&mut self.bins, &mut other.bins);
        std::mem::swap(&mut self.detached, &mut other.detached);
    }

    /// Forgets what samples have gathered.
    pub fn forget_gathered(&mut self) {
        let tiles = self.store.iter_mut().flat_map(|store| &mut store.tiles);
        tiles.for_each(|tile| tile.forget_gathered());
        self.buffers.forget();
    }

    /// Has what samples have gathered hold until `changed` of what it did.
    pub fn change_validity(&mut self, changed: impl Fn(Until) -> Until + Sync) {
        let tiles = self.store.par_iter_mut().flat_map(|store| &mut store.tiles);
        tiles.for_each(|tile| tile.change_validity(&changed));
        self.buffers.forget();
    }

    /// What later frames need of this one.
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

    /// Makes this level of a frame: of the samples of the frame before, if there are any, and writes its pixels into
    /// `film`.
    pub fn render(
        &mut self,
        frame: &FrameView,
        estimate: Estimate,
        film: &mut Film,
        shows: Shows,
    ) -> TileSum {
        let Self { grid, store, is_lent, lent, buffers, bins, detached, layout, .. } = self;
        if frame.plan.camera != CameraChange::None {
            buffers.states.clear();
        }
        buffers.begin_frame(grid);
        let is_lent = std::mem::take(is_lent);
        let lists = (bins, detached);
        let (mut now, reused) = begin(store.take(), is_lent, frame, layout, &mut buffers.states, lists);
        let mut start = Start { reused, estimate };
        let sum = run_tiles(frame, &mut start, &mut now, buffers, film, shows);
        *store = Some(now);
        if let (Reused::Projected(old, _), true) = (start.reused, is_lent) {
            *lent = Some(old.into_store());
        }
        sum
    }

    /// Asks for the pixels that are `flagged`. With `stays`, the camera does not move: what was asked for stays.
    pub fn want(&mut self, flagged: &PixelFlags, stays: bool) {
        let mut wanted = Wanted::of(flagged, &self.grid);
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
        store + self.buffers.pool.bytes() + self.buffers.state_bytes() + self.bins.bytes()
    }
}

/// The store of this frame as far as it is there already, and the samples that it reuses: from another store, which may be
/// lent, from its own tiles, or none.
fn begin<'c>(
    last: Option<SampleStore>,
    is_lent: bool,
    frame: &FrameView,
    layout: &TagLayout,
    states: &mut [TileState],
    (bins, detached): (&'c mut Bins, &'c mut Detached),
) -> (SampleStore, Reused<'c>) {
    match last {
        Some(mut store) if frame.plan.camera == CameraChange::None => {
            bins.open(frame.view.grid.tiles());
            static_camera::detach(&mut store, states, frame, layout, detached);
            static_camera::scatter(detached, frame, bins);
            tile_state::find_reached(&store, frame, bins, states);
            (store, Reused::InPlace(detached, bins))
        }
        Some(old) => {
            bins.open(frame.view.grid.tiles());
            let old = reproject::scatter(old, is_lent, frame, bins);
            (SampleStore::default(), Reused::Projected(old, bins))
        }
        None => (SampleStore::default(), Reused::None),
    }
}
