//! The store itself: tiles of cells.

use glam::Vec3;
use half::f16;
use half::slice::HalfFloatSliceExt;

use super::{Octahedral, Status, TagLayout, Tags};
use crate::lanes::{F32x8, LANES, Vec3x8};

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

/// A sample goes from one cell of a tile to one of another.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Move {
    /// Its new cell.
    pub to: u16,
    /// Its old cell.
    pub from: u16,
}

impl Move {
    /// The new cell and the old one.
    #[inline(always)]
    pub fn cells(self) -> [usize; 2] {
        // the remainders are the numbers themselves: they spare checks
        [self.to, self.from].map(|cell| usize::from(cell) % CELLS)
    }
}

/// Half floats of a colour, a column for each of R, G and B.
pub type ColorColumns = [Column<f16>; 3];

/// One sample, as its tile keeps it in columns: 46 bytes, and its [tags](Tags): one for each light, or four.
///
/// Directions and colours are rounded when a sample is *traced*, before anything is computed from them: a
/// sample that was kept is shaded from the same numbers as one that was just made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Where the surface was hit, object space; for the background the direction, world space.
    pub point: Vec3,
    /// Index into [`Scene::models`](crate::scene::Scene::models), [`BACKGROUND`] or [`EMPTY`].
    pub model: u32,
    /// Index into [`Mesh::triangles`](crate::scene::Mesh::triangles).
    pub triangle: u32,
    /// Shading normal, object space, on the side from which the sample is seen.
    pub normal: Octahedral,
    /// The triangle's normal, object space, on the side from which the sample is seen.
    pub facet: Octahedral,
    /// Index into [`Scene::materials`](crate::scene::Scene::materials).
    pub material: u16,
    /// Whether the eye sees the back of the triangle.
    pub from_behind: bool,
}

/// 32 x 32 cells, as columns: each phase reads those that it needs, eight cells at a time.
#[derive(Debug, Clone)]
#[allow(missing_docs, reason = "columns of the fields of Sample")]
pub struct Tile {
    pub x: Column<f32>,
    pub y: Column<f32>,
    pub z: Column<f32>,
    pub model: Column<u32>,
    pub triangle: Column<u32>,
    pub normal: Column<Octahedral>,
    pub facet: Column<Octahedral>,
    pub material: Column<u16>,
    pub from_behind: Column<bool>,
    /// What the diffuse and the ambient reflectance are shares of, texture included: see
    /// [`Material::painted`](crate::scene::Material::painted).
    pub reflectance: ColorColumns,
    /// What does not depend on the eye: emission, ambient and diffuse light. Radiance, linear RGB.
    pub lit: ColorColumns,
    /// Rendered frames since the sample was traced; stays at the top.
    pub age: Column<u16>,
    /// In this frame.
    pub status: Column<Status>,
    pub tags: Tags,
}

impl Tile {
    /// No sample in any cell.
    pub fn empty(layout: &TagLayout) -> Self {
        Self {
            x: [0.0; CELLS],
            y: [0.0; CELLS],
            z: [0.0; CELLS],
            model: [EMPTY; CELLS],
            triangle: [0; CELLS],
            normal: [Octahedral::default(); CELLS],
            facet: [Octahedral::default(); CELLS],
            material: [0; CELLS],
            from_behind: [false; CELLS],
            reflectance: [[f16::ZERO; CELLS]; 3],
            lit: [[f16::ZERO; CELLS]; 3],
            age: [0; CELLS],
            status: [Status::default(); CELLS],
            tags: Tags::unknown(layout),
        }
    }

    /// Bytes of a tile.
    pub fn bytes(layout: &TagLayout) -> usize {
        size_of::<Self>() + CELLS * layout.bytes()
    }

    /// The sample's place: see [`Sample::point`].
    #[inline]
    pub fn point(&self, cell: usize) -> Vec3 {
        Vec3::new(self.x[cell], self.y[cell], self.z[cell])
    }

    /// Eight samples' places, from `first` on.
    #[inline(always)]
    pub fn points(&self, first: usize) -> Vec3x8 {
        Vec3x8::load([&self.x, &self.y, &self.z], first)
    }

    /// What the store keeps of the surface.
    #[inline]
    pub fn sample(&self, cell: usize) -> Sample {
        Sample {
            point: self.point(cell),
            model: self.model[cell],
            triangle: self.triangle[cell],
            normal: self.normal[cell],
            facet: self.facet[cell],
            material: self.material[cell],
            from_behind: self.from_behind[cell],
        }
    }

    /// Whether there is a surface in the cell, rather than nothing or the background.
    #[inline]
    pub fn is_surface(&self, cell: usize) -> bool {
        self.model[cell] < EMPTY
    }

    /// Copies the sample in cell `at` of `from`, with its light and its tags, to `cell`. Age and status are
    /// the caller's.
    #[inline]
    pub fn take_over(&mut self, cell: usize, from: &Self, at: usize) {
        self.take_over_untagged(cell, from, at);
        self.tags.take_over(cell, &from.tags, at);
    }

    /// Copies samples from `from`, with their light, tags and age. The status is the caller's.
    pub fn take_over_all(&mut self, from: &Self, moves: &[Move]) {
        for way in moves {
            let [to, at] = way.cells();
            self.take_over_untagged(to, from, at);
            self.age[to] = from.age[at];
        }
        self.tags.take_over_all(&from.tags, moves);
    }

    #[inline(always)]
    fn take_over_untagged(&mut self, cell: usize, from: &Self, at: usize) {
        self.x[cell] = from.x[at];
        self.y[cell] = from.y[at];
        self.z[cell] = from.z[at];
        self.model[cell] = from.model[at];
        self.triangle[cell] = from.triangle[at];
        self.normal[cell] = from.normal[at];
        self.facet[cell] = from.facet[at];
        self.material[cell] = from.material[at];
        self.from_behind[cell] = from.from_behind[at];
        for i in 0..3 {
            self.reflectance[i][cell] = from.reflectance[i][at];
            self.lit[i][cell] = from.lit[i][at];
        }
    }

    /// Leaves the cell without a sample.
    #[inline]
    pub fn clear(&mut self, cell: usize, status: Status) {
        self.model[cell] = EMPTY;
        self.status[cell] = status;
        self.age[cell] = 0;
    }
}

/// All samples of a frame. Indices of samples run through the tiles in order.
#[derive(Debug, Default)]
pub struct SampleStore {
    /// In rows from the top left.
    pub tiles: Vec<Box<Tile>>,
}

impl SampleStore {
    /// Bytes held, with tags as `layout` says.
    pub fn bytes(&self, layout: &TagLayout) -> usize {
        self.tiles.len() * Tile::bytes(layout)
    }
}

/// The greatest half float: what is beyond stays here.
const MOST: f32 = 65504.0;

/// Rounds eight colours to what the store keeps, from cell `first` on.
#[inline(always)]
pub fn store_colors(colors: Vec3x8, [r, g, b]: &mut ColorColumns, first: usize) {
    for (values, column) in [(colors.x, r), (colors.y, g), (colors.z, b)] {
        let cut = values.min(F32x8::splat(MOST)).max(F32x8::splat(-MOST));
        column[first..first + LANES].convert_from_f32_slice(cut.values());
    }
}

/// Eight colours that the store keeps, from cell `first` on.
#[inline(always)]
pub fn load_colors([r, g, b]: &ColorColumns, first: usize) -> Vec3x8 {
    let load = |column: &Column<f16>| {
        let mut eight = F32x8::ZERO;
        column[first..first + LANES].convert_to_f32_slice(eight.values_mut());
        eight
    };
    Vec3x8 { x: load(r), y: load(g), z: load(b) }
}

/// Rounds a colour to what the store keeps.
#[inline]
pub fn store_color(color: Vec3, columns: &mut ColorColumns, cell: usize) {
    let cut = color.clamp(Vec3::splat(-MOST), Vec3::splat(MOST)).to_array();
    for (column, value) in columns.iter_mut().zip(cut) {
        column[cell] = f16::from_f32(value);
    }
}

/// A colour that the store keeps.
#[inline]
pub fn load_color(columns: &ColorColumns, cell: usize) -> Vec3 {
    let [r, g, b] = columns;
    Vec3::new(r[cell].to_f32(), g[cell].to_f32(), b[cell].to_f32())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_as_small_as_it_says() {
        let [point, area] = [false, true].map(|is_area| TagLayout::of(std::iter::once(is_area)));
        assert_eq!(Tile::bytes(&point) / CELLS, 46 + 1);
        assert_eq!(Tile::bytes(&area) / CELLS, 46 + 4);
    }

    #[test]
    fn colours_come_back_rounded_and_cut() {
        let mut columns = [[f16::ZERO; CELLS]; 3];
        store_color(Vec3::new(0.5, 1e9, -0.1), &mut columns, 19);
        let one = load_color(&columns, 19);
        assert_eq!((one.x, one.y), (0.5, MOST));
        let eight = load_colors(&columns, 16);
        assert_eq!(eight.lane(3), one);
        store_colors(eight, &mut columns, 0);
        assert_eq!(load_color(&columns, 3), one, "what was rounded stays");
    }
}
