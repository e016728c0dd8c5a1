//! Which pixels differ from their neighbours, so that adaptive samples refine them: the paper's "adaptive
//! supersampling".
//!
//! Two neighbouring samples differ by any of four criteria:
//! - *object*: they show other models, or one of them the background;
//! - *normal*: their shading normals are more than [`NORMAL_COSINE`] apart;
//! - *shadow*: a light without a size reaches one of them, and is hidden from the other;
//! - *colour*: in red, green or blue `|a - b| / (a + b)`, the contrast of Mitchell, "Generating Antialiased Images at Low
//!   Sampling Densities" (1987), is more than the threshold. Differences below [`DARK`] are not seen.
//!
//! The pixels of both are flagged. What differs inside a pixel is found as soon as the level has several samples in it.

use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use crate::frame::grid::wanted::PixelFlags;
use crate::frame::grid::{Grid, cell_number};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::radiance::{Light, Radiance};
use crate::lanes::{F32x8, LANES, Vec3x8};
use crate::samples::{
    BACKGROUND, CELLS, EMPTY, HalfColor, Octahedral, SampleStore, TILE, Tag, TagSlot, Tile, half_colors,
};

/// Cosine of the angle between shading normals from which on they differ: 25 degrees.
const NORMAL_COSINE: f32 = 0.906;

/// Two colours below this, added up, are compared as if they added up to it: linear, where 1 is white.
const DARK: f32 = 0.04;

/// Colours of the cells of a tile, all layers of light together, over white where veils, holes and catchers let it through. Empty before they were shown first.
pub type TileColors = Vec<HalfColor>;

/// Notes what a tile shows.
pub fn note_colors(radiance: &Radiance, colors: &mut TileColors) {
    let Radiance { diffuse, specular, reflection, refraction, clear, has_specular, has_secondary, .. } =
        radiance;
    colors.resize(CELLS, [f16::ZERO; 3]);
    let load =
        |light: &Light, first: usize| Vec3x8::load(light.each_ref().map(|column| column.as_slice()), first);
    for (first, colors) in (0..).step_by(LANES).zip(colors.chunks_exact_mut(LANES)) {
        let mut sum = load(diffuse, first);
        if *has_specular {
            sum = sum + load(specular, first);
        }
        if *has_secondary {
            // over a plate of white
            let clear = Vec3x8::splat(Vec3::ONE) * F32x8::load(clear, first);
            sum = sum + load(reflection, first) + load(refraction, first) + clear;
        }
        colors.copy_from_slice(&half_colors(sum));
    }
}

/// Values of a cell that are compared with others.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CellValues {
    /// [`EMPTY`] if there is nothing to compare.
    model: u32,
    /// Object space; of a model that deforms, world space, because its folds are not those at rest.
    normal: Octahedral,
    color: [f32; 3],
    /// Lights that reach it, and that are hidden from it, a bit each. From the 33rd on they are not compared.
    lit: u32,
    hidden: u32,
}

impl CellValues {
    /// Nothing to compare.
    fn nothing() -> Self {
        Self { model: EMPTY, normal: Octahedral::default(), color: [0.0; 3], lit: 0, hidden: 0 }
    }

    fn new(frame: &FrameView, tile: &Tile, colors: &TileColors, cell: usize) -> Self {
        let model = tile.model[cell];
        let Some(color) = colors.get(cell).filter(|_| model != EMPTY) else { return Self::nothing() };
        let (mut lit, mut hidden) = (0, 0);
        let lights = frame.slots.iter().take(u32::BITS as usize).enumerate();
        // without power it makes no shadow, and what is known of it depends on what came before
        let is_compared =
            |light: usize, slot: &TagSlot| matches!(slot, TagSlot::Single(_)) && !frame.pose.is_dark(light);
        for (light, slot) in lights.filter(|(light, slot)| is_compared(*light, slot)) {
            match tile.tags.get(*slot, 0, cell) {
                Tag::Lit => lit |= 1 << light,
                Tag::StaticOccluder | Tag::DynamicOccluder => hidden |= 1 << light,
                Tag::Unknown | Tag::BackFacing => {}
            }
        }
        let normal = normal_of(frame, tile, cell);
        Self { model, normal, color: color.map(f16::to_f32), lit, hidden }
    }

    /// Returns true if two neighbours differ by any criterion.
    fn differs(&self, other: &Self, threshold: f32) -> bool {
        if self.model == EMPTY || other.model == EMPTY {
            return false;
        }
        self.model != other.model
            || self.model != BACKGROUND && (self.is_turned_from(other) || self.is_lit_otherwise(other))
            || self.color.iter().zip(other.color).any(|(a, b)| (a - b).abs() > threshold * (a + b).max(DARK))
    }

    fn is_turned_from(&self, other: &Self) -> bool {
        self.normal != other.normal && self.normal.unfold().dot(other.normal.unfold()) < NORMAL_COSINE
    }

    fn is_lit_otherwise(&self, other: &Self) -> bool {
        self.lit & other.hidden | self.hidden & other.lit != 0
    }
}

/// The shading normal of a sample: see [`CellValues::normal`].
fn normal_of(frame: &FrameView, tile: &Tile, cell: usize) -> Octahedral {
    let (model, record) = (tile.model[cell], &tile.record[cell]);
    if !frame.deformations.has(model) {
        return record.normal;
    }
    let kept = [tile.point(cell), record.normal.unfold(), record.geometric_normal.unfold()];
    let [_, normal, _] = frame.place(model, record.traced.tick()).surface(record.triangle, kept);
    Octahedral::fold(normal)
}

/// Cells across a tile with one around it.
const ACROSS: usize = TILE + 2;

/// The looks of a tile's cells, and of the cells beside it.
struct TileLooks([CellValues; ACROSS * ACROSS]);

impl TileLooks {
    /// Collects tile number `number` of `store`, whose tiles show `colors`.
    fn new(frame: &FrameView, store: &SampleStore, colors: &[TileColors], number: usize) -> Self {
        let grid = &*frame.view.grid;
        let mut looks = [CellValues::nothing(); ACROSS * ACROSS];
        let (tile, own) = (&store.tiles[number], &colors[number]);
        let [columns, rows] = grid.extent(number).map(|count| count as usize);
        for row in 0..rows {
            for column in 0..columns {
                let cell = cell_number([column as u32, row as u32]);
                looks[(row + 1) * ACROSS + column + 1] = CellValues::new(frame, tile, own, cell);
            }
        }
        let mut beside = |column: usize, row: usize| {
            if let Some((tile, cell)) = grid.cell_around(number, [column, row]) {
                looks[row * ACROSS + column] =
                    CellValues::new(frame, &store.tiles[tile], &colors[tile], cell);
            }
        };
        (1..=columns).for_each(|column| [0, rows + 1].into_iter().for_each(|row| beside(column, row)));
        (1..=rows).for_each(|row| [0, columns + 1].into_iter().for_each(|column| beside(column, row)));
        Self(looks)
    }

    /// Returns true if a cell of the tile differs from any of the four beside it.
    fn differs(&self, column: usize, row: usize, threshold: f32) -> bool {
        let at = (row + 1) * ACROSS + column + 1;
        let Self(looks) = self;
        [at - ACROSS, at - 1, at + 1, at + ACROSS]
            .iter()
            .any(|beside| looks[at].differs(&looks[*beside], threshold))
    }
}

/// Flags the pixels that differ from their neighbours, or within themselves, of those tiles that `is_asked` says. `colors`:
/// what the tiles of `store` show.
pub fn flag(
    frame: &FrameView,
    store: &SampleStore,
    colors: &[TileColors],
    threshold: f32,
    is_asked: impl Fn(usize) -> bool + Sync,
) -> PixelFlags {
    let grid = &*frame.view.grid;
    let mut flags = PixelFlags::none(grid);
    let width = flags.width();
    let rows = flags.rows_of_tiles(grid);
    rows.into_par_iter().enumerate().for_each(|(row, flags)| {
        let mut left = 0;
        for column in 0..grid.tiles_x as usize {
            let number = row * grid.tiles_x as usize + column;
            let across = grid.axes[0].tile(column).len();
            if is_asked(number) && store.tiles[number].model.iter().any(|model| *model != EMPTY) {
                flag_tile(frame, store, colors, (number, threshold), &mut flags[left..], width);
            }
            left += across;
        }
    });
    flags
}

/// Flags pixels of tile number `number`, in rows of `stride`.
fn flag_tile(
    frame: &FrameView,
    store: &SampleStore,
    colors: &[TileColors],
    (number, threshold): (usize, f32),
    flags: &mut [bool],
    stride: usize,
) {
    let Grid { samples, .. } = *frame.view.grid;
    let looks = TileLooks::new(frame, store, colors, number);
    let [columns, rows] = frame.view.grid.extent(number);
    for row in 0..rows {
        for column in 0..columns {
            let flag = &mut flags[(row / samples) as usize * stride + (column / samples) as usize];
            *flag = *flag || looks.differs(column as usize, row as usize, threshold);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn look() -> CellValues {
        CellValues {
            model: 3,
            normal: Octahedral::fold(Vec3::Y),
            color: [0.5, 0.25, 0.1],
            lit: 0b101,
            hidden: 0b010,
        }
    }

    #[test]
    fn each_criterion_tells_samples_apart() {
        let turned = |degrees: f32| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            CellValues { normal: Octahedral::fold(Vec3::new(sin, cos, 0.0)), ..look() }
        };
        let table = [
            ("the same", look(), false),
            ("another object", CellValues { model: 4, ..look() }, true),
            ("the background", CellValues { model: BACKGROUND, ..look() }, true),
            ("nothing", CellValues::nothing(), false),
            ("a curve", turned(20.0), false),
            ("a fold", turned(30.0), true),
            ("in shadow", CellValues { lit: 0b100, hidden: 0b011, ..look() }, true),
            ("turned away from a light", CellValues { lit: 0b100, ..look() }, false),
            ("a little brighter", CellValues { color: [0.55, 0.28, 0.11], ..look() }, false),
            ("bluer", CellValues { color: [0.5, 0.25, 0.14], ..look() }, true),
        ];
        for (name, other, differs) in table {
            assert_eq!(look().differs(&other, 0.1), differs, "{name}");
            assert_eq!(other.differs(&look(), 0.1), differs, "{name}, the other way round");
        }
        let dark = |color: f32| CellValues { color: [color; 3], ..look() };
        assert!(!dark(0.0).differs(&dark(0.0035), 0.1), "too dark to be seen");
        assert!(
            !look().differs(&CellValues { color: [0.9, 0.4, 0.2], ..look() }, 0.5),
            "the threshold counts"
        );
    }
}
