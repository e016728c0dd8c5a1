//! The store itself: tiles of cells.

use glam::Vec3;
use half::f16;
use half::slice::HalfFloatSliceExt;

use super::{
    ClearRegions, Flags, GatheredLight, HalfColor, MOST_SPARES, MirroredSamples, Octahedral, Record, Sample,
    Spares, Status, TagLayout, Tags, VariedColumn,
};
use crate::changes::Until;
use crate::exposure::Tick;
use crate::lanes::{F32x8, LANES, Vec3x8};
use crate::prefetch::prefetch;
use crate::scene::look::Look;

/// Cells along a tile's edge.
pub const TILE: usize = 32;

/// Cells in a tile.
pub const CELLS: usize = TILE * TILE;

/// `model` of a sample of the background; its `point` is a direction then.
pub const BACKGROUND: u32 = u32::MAX;

/// `model` of a cell without a sample.
pub const EMPTY: u32 = u32::MAX - 1;

/// One value for each cell of a tile.
pub type Column<T> = [T; CELLS];

/// Move of a sample from a slot of one tile to a cell of another.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Move {
    /// New cell.
    pub to: u16,
    /// Old tile, by its number in a list.
    pub source: u16,
    /// [Slot](Tile::slots) in the old tile.
    pub from: u16,
}

/// Part of a tile that a [slot](Tile::slots) is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slot {
    /// A cell.
    Cell(usize),
    /// Number of a spare sample.
    Spare(usize),
}

impl Slot {
    /// Slot number `slot` of a tile.
    #[inline(always)]
    pub fn new(slot: usize) -> Self {
        match slot.checked_sub(CELLS) {
            None => Self::Cell(slot),
            Some(number) => Self::Spare(number),
        }
    }
}

/// Samples of 32 x 32 cells. Places, which projection reads, are in columns, eight cells at a time. The other
/// data of a sample is in a record: copying samples waits for the cache, a line for each column.
#[derive(Debug, Clone)]
pub struct Tile {
    /// Point of the surface, object space; for the background the direction, world space. First coordinate.
    pub x: Column<f32>,
    /// Second coordinate.
    pub y: Column<f32>,
    /// Third coordinate.
    pub z: Column<f32>,
    /// Index into [`Scene::models`](crate::scene::Scene::models), [`BACKGROUND`] or [`EMPTY`].
    pub model: Column<u32>,
    /// Other data of the samples.
    pub record: Column<Record>,
    /// Parameters of the samples' surfaces that vary from place to place.
    pub varied: VariedColumn,
    /// Status in this frame.
    pub status: Column<Status>,
    /// Bit masks, for each eight cells, of those served by a copy of a sample that another tile or another
    /// cell keeps: copies are not handed on to the next frame.
    pub copies: [u8; CELLS / LANES],
    /// Shadow tags.
    pub tags: Tags,
    /// Gathered light and openness.
    pub gathered: GatheredLight,
    /// Samples that lie in the tile and serve none of its cells.
    pub spares: Spares,
}

impl Tile {
    /// Creates a tile without samples.
    pub fn empty(layout: &TagLayout) -> Self {
        Self {
            x: [0.0; CELLS],
            y: [0.0; CELLS],
            z: [0.0; CELLS],
            model: [EMPTY; CELLS],
            record: [Record::default(); CELLS],
            varied: VariedColumn::new(layout.varying),
            status: [Status::default(); CELLS],
            copies: [0; CELLS / LANES],
            tags: Tags::unknown(layout),
            gathered: GatheredLight::unknown(layout, CELLS),
            spares: Spares::none(layout),
        }
    }

    /// Size of a tile without spare samples, in bytes.
    pub fn bytes_of_cells(layout: &TagLayout) -> usize {
        size_of::<Self>() + CELLS * layout.bytes()
    }

    /// Size of this tile, in bytes.
    pub fn bytes(&self, layout: &TagLayout) -> usize {
        Self::bytes_of_cells(layout) + self.spares.bytes()
    }

    /// Number of slots: the cells, and after them the spare samples.
    pub fn slots(&self) -> usize {
        CELLS + self.spares.len()
    }

    /// Sample in a slot, without its tags.
    #[inline(always)]
    pub fn sample(&self, slot: usize) -> Sample {
        match Slot::new(slot) {
            Slot::Cell(cell) => {
                let (point, varied) = (self.point(cell), self.varied.get(cell));
                Sample { point, model: self.model[cell], record: self.record[cell], varied }
            }
            Slot::Spare(number) => self.spares.samples[number],
        }
    }

    /// Puts a sample into a cell. The caller sets all that is not in it.
    #[inline(always)]
    pub fn put(&mut self, cell: usize, Sample { point, model, record, varied }: Sample) {
        [self.x[cell], self.y[cell], self.z[cell]] = point.to_array();
        self.model[cell] = model;
        self.record[cell] = record;
        self.varied.set(cell, varied);
    }

    /// Prefetches eight samples, from cell `first` on.
    #[inline(always)]
    pub fn prefetch_eight(&self, first: usize) {
        [&self.x, &self.y, &self.z].into_iter().for_each(|column| prefetch(&column[first..=first]));
        prefetch(&self.model[first..=first]);
        prefetch(&self.record[first..first + LANES]);
    }

    /// Prefetches the record in a slot.
    #[inline(always)]
    pub fn prefetch_record(&self, slot: usize) {
        if let Some(record) = self.record.get(slot) {
            prefetch(std::slice::from_ref(record));
        }
    }

    /// Model and record of the sample in a slot.
    #[inline(always)]
    pub fn surface_in(&self, slot: usize) -> (u32, &Record) {
        match Slot::new(slot) {
            Slot::Cell(cell) => (self.model[cell], &self.record[cell]),
            Slot::Spare(number) => (self.spares.samples[number].model, &self.spares.samples[number].record),
        }
    }

    /// Copies the sample in `slot` of `from`, with its light and without its tags, to `cell`. The caller sets
    /// the status and the bit of copies. Returns the sample's flags.
    #[inline(always)]
    fn copy_untagged(&mut self, cell: usize, from: &Self, slot: usize) -> Flags {
        let cell = cell % CELLS;
        // records straight from one to the other: a copy in between would wait for the first
        let record = match Slot::new(slot) {
            Slot::Cell(old) => {
                self.x[cell] = from.x[old];
                self.y[cell] = from.y[old];
                self.z[cell] = from.z[old];
                self.model[cell] = from.model[old];
                self.varied.copy(cell, &from.varied, old);
                &from.record[old]
            }
            Slot::Spare(number) => {
                let spare = &from.spares.samples[number];
                [self.x[cell], self.y[cell], self.z[cell]] = spare.point.to_array();
                self.model[cell] = spare.model;
                self.varied.set(cell, spare.varied);
                &spare.record
            }
        };
        self.record[cell] = *record;
        record.flags
    }

    /// Copies samples, with their light and tags, from tiles in `sources`. The caller sets their status and
    /// the bits of copies. Returns the flags that any of them has.
    pub fn copy_all(&mut self, sources: &[&Self], moves: &[Move]) -> Flags {
        let copy = |flags: Flags, Move { to, source, from }: &Move| {
            let source = sources[usize::from(*source)];
            flags.with(self.copy_untagged(usize::from(*to), source, usize::from(*from)))
        };
        let flags = moves.iter().fold(Flags::default(), copy);
        let tags = sources.iter().map(|tile| (&tile.tags, &tile.spares));
        self.tags.copy_all(&tags.collect::<Vec<_>>(), moves);
        if self.gathered.is_seeded() {
            for Move { to, source, from } in moves {
                self.copy_gathered(
                    usize::from(*to) % CELLS,
                    sources[usize::from(*source)],
                    usize::from(*from),
                );
            }
        }
        flags
    }

    /// Copies the sample in `slot` of `from`, with its light, its tags and its paths, to `cell`. The caller
    /// sets the status and the bit of copies. Returns the sample's flags.
    #[inline]
    pub fn copy_slot(&mut self, cell: usize, from: &Self, slot: usize) -> Flags {
        match Slot::new(slot) {
            Slot::Cell(old) => self.tags.take_over(cell, &from.tags, old),
            Slot::Spare(number) => from.spares.copy_tags(number, &mut self.tags, cell),
        }
        self.copy_gathered(cell, from, slot);
        self.copy_untagged(cell, from, slot)
    }

    /// Copies gathered light and openness of the sample in `slot` of `from`.
    #[inline]
    fn copy_gathered(&mut self, cell: usize, from: &Self, slot: usize) {
        match Slot::new(slot) {
            Slot::Cell(old) => self.gathered.copy(cell, &from.gathered, old),
            Slot::Spare(number) => self.gathered.copy(cell, &from.spares.gathered, number),
        }
    }

    /// Resets gathered light and openness of all samples, spare ones included.
    pub fn forget_gathered(&mut self) {
        self.gathered.forget_all();
        self.spares.forget_gathered();
    }

    /// Gives back memory for the expiry of paths where nothing expires.
    pub fn compact(&mut self) {
        self.gathered.compact(|cell| self.model[cell] < EMPTY);
        self.spares.gathered.compact(|_| true);
    }

    /// Replaces the expiry of all gathered light and openness, that of spare samples included, by what
    /// `changed` returns for it.
    pub fn change_validity(&mut self, changed: impl Fn(Until) -> Until) {
        self.gathered.change_validity(&changed);
        self.spares.gathered.change_validity(&changed);
    }

    /// Place of the sample: see [`Tile::x`].
    #[inline]
    pub fn point(&self, cell: usize) -> Vec3 {
        Vec3::new(self.x[cell], self.y[cell], self.z[cell])
    }

    /// Places of eight samples, from `first` on.
    #[inline(always)]
    pub fn points(&self, first: usize) -> Vec3x8 {
        Vec3x8::load([&self.x, &self.y, &self.z], first)
    }

    /// Records of eight cells, from `first` on.
    #[inline(always)]
    pub fn records(&self, first: usize) -> &[Record] {
        &self.record[first..first + LANES]
    }

    /// What the surface of the sample in a cell is made of there.
    #[inline(always)]
    pub fn look(&self, cell: usize) -> Look {
        Look { material: self.record[cell].material, varied: self.varied.get(cell) }
    }

    /// What the surfaces of eight samples, from `first` on, are made of there.
    #[inline(always)]
    pub fn looks(&self, first: usize) -> [Look; LANES] {
        let records = self.records(first);
        if self.varied.is_empty() {
            return std::array::from_fn(|lane| Look::plain(records[lane].material));
        }
        std::array::from_fn(|lane| self.look(first + lane))
    }

    /// Ticks of the exposure at which eight samples are seen, from `first` on.
    #[inline(always)]
    pub fn ticks(&self, first: usize) -> [Tick; LANES] {
        let records = self.records(first);
        std::array::from_fn(|lane| records[lane].traced.tick())
    }

    /// Triangles of eight samples, from `first` on.
    #[inline(always)]
    pub fn triangles(&self, first: usize) -> [u32; LANES] {
        let records = self.records(first);
        std::array::from_fn(|lane| records[lane].triangle)
    }

    /// Shading normals of eight samples, from `first` on.
    #[inline(always)]
    pub fn normals(&self, first: usize) -> [Octahedral; LANES] {
        let records = self.records(first);
        std::array::from_fn(|lane| records[lane].normal)
    }

    /// Geometric normals of eight samples, from `first` on.
    #[inline(always)]
    pub fn geometric_normals(&self, first: usize) -> [Octahedral; LANES] {
        let records = self.records(first);
        std::array::from_fn(|lane| records[lane].geometric_normal)
    }

    /// Reflectances of eight samples, from `first` on.
    #[inline(always)]
    pub fn reflectances(&self, first: usize) -> Vec3x8 {
        let records = self.records(first);
        load_colors(|lane| &records[lane].reflectance)
    }

    /// Stored light of eight samples, from `first` on.
    #[inline(always)]
    pub fn kept_light(&self, first: usize) -> Vec3x8 {
        let records = self.records(first);
        load_colors(|lane| &records[lane].direct_diffuse)
    }

    /// Stores the light of eight samples, from `first` on.
    #[inline(always)]
    pub fn keep_light(&mut self, first: usize, light: Vec3x8) {
        let records = &mut self.record[first..first + LANES];
        for (record, color) in records.iter_mut().zip(half_colors(light)) {
            record.direct_diffuse = color;
        }
    }

    /// Bit mask of those of eight cells whose samples have these flags.
    #[inline]
    pub fn flagged(&self, first: usize, flags: Flags) -> u8 {
        (0..)
            .zip(self.records(first))
            .fold(0, |bits, (lane, record)| bits | u8::from(record.flags.has(flags)) << lane)
    }

    /// Removes these flags from those of eight samples whose bit in `which` is set.
    #[inline]
    pub fn unflag(&mut self, first: usize, which: u8, flags: Flags) {
        for (lane, record) in self.record[first..first + LANES].iter_mut().enumerate() {
            if which >> lane & 1 != 0 {
                record.flags = record.flags.without(flags);
            }
        }
    }

    /// Makes the sample in `cell` a spare one, unless another cell or tile keeps it or there are enough. It
    /// has not been lit in this frame: its tags are unknown, and so are, if its model `moved`, its gathered
    /// light and openness.
    pub fn make_spare(&mut self, cell: usize, moved: bool) {
        let is_copy = self.copies[cell / LANES] >> (cell % LANES) & 1 != 0;
        if !is_copy && self.spares.len() < MOST_SPARES {
            let mut spare = self.sample(cell);
            spare.record.flags = spare.record.flags.with(Flags::STALE);
            self.spares.push_untagged(spare, &self.gathered, cell);
            if moved {
                self.spares.forget_last_answers();
            }
        }
    }

    /// Sets whether a cell is served by a copy.
    #[inline]
    pub fn set_copy(&mut self, cell: usize, is_copy: bool) {
        let (copies, bit) = (&mut self.copies[cell / LANES], 1 << (cell % LANES));
        *copies = *copies & !bit | if is_copy { bit } else { 0 };
    }

    /// Returns true if the cell shows a surface, rather than nothing or the background.
    #[inline]
    pub fn is_surface(&self, cell: usize) -> bool {
        self.model[cell] < EMPTY
    }

    /// Removes the sample of the cell.
    #[inline]
    pub fn clear(&mut self, cell: usize, status: Status) {
        self.model[cell] = EMPTY;
        self.status[cell] = status;
    }
}

/// All samples of a frame. Indices of samples run through the tiles in order.
#[derive(Debug, Default)]
pub struct SampleStore {
    /// Tiles, in rows from the top left.
    pub tiles: Vec<Box<Tile>>,
    /// Regions in which proofs hold that samples keep.
    pub regions: ClearRegions,
    /// Samples that are seen by way of flat mirrors.
    pub mirrored: MirroredSamples,
}

impl SampleStore {
    /// Memory held, in bytes, with this layout of tags.
    pub fn bytes(&self, layout: &TagLayout) -> usize {
        self.tiles.iter().map(|tile| tile.bytes(layout)).sum::<usize>() + self.mirrored.bytes()
    }
}

/// Greatest half float, to which larger values are clamped.
const MOST: f32 = 65504.0;

/// Rounds eight colours to the precision of the store.
#[inline(always)]
pub fn half_colors(colors: Vec3x8) -> [HalfColor; LANES] {
    let [r, g, b] = [colors.x, colors.y, colors.z].map(|values| {
        let cut = values.min(F32x8::splat(MOST)).max(F32x8::splat(-MOST));
        let mut halves = [f16::ZERO; LANES];
        halves.convert_from_f32_slice(cut.values());
        halves
    });
    std::array::from_fn(|lane| [r[lane], g[lane], b[lane]])
}

/// Loads eight stored colours.
#[inline(always)]
fn load_colors<'a>(color: impl Fn(usize) -> &'a HalfColor) -> Vec3x8 {
    let load = |part: usize| {
        let halves: [f16; LANES] = std::array::from_fn(|lane| color(lane)[part]);
        let mut eight = F32x8::ZERO;
        halves.convert_to_f32_slice(eight.values_mut());
        eight
    };
    Vec3x8 { x: load(0), y: load(1), z: load(2) }
}

/// Converts a stored colour to floats.
#[inline]
pub fn full_color(color: HalfColor) -> Vec3 {
    Vec3::from_array(color.map(f16::to_f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_as_small_as_it_says() {
        let [point, area] = [1, 16].map(|points| TagLayout::new(std::iter::once(points)));
        assert_eq!(Tile::bytes_of_cells(&point) / CELLS, 49 + 1);
        assert_eq!(Tile::bytes_of_cells(&area) / CELLS, 49 + 4);
    }

    #[test]
    fn colours_come_back_rounded_and_cut() {
        let mut tile = Tile::empty(&TagLayout::default());
        tile.keep_light(16, Vec3x8::splat(Vec3::new(0.5, 1e9, -0.1)));
        let one = full_color(tile.record[19].direct_diffuse);
        assert_eq!((one.x, one.y), (0.5, MOST));
        assert_eq!(tile.kept_light(16).lane(3), one);
        tile.keep_light(0, tile.kept_light(16));
        assert_eq!(full_color(tile.record[3].direct_diffuse), one, "what was rounded stays");
    }
}
