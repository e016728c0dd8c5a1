//! Samples in world space.

use glam::Vec3;

use super::hits::place;
use crate::frame::grid::bits::{set_bits, surface_bits};
use crate::frame::shot::frame_view::FrameView;
use crate::lanes::{LANES, Vec3x8};
use crate::samples::{CELLS, Column, Octahedral, Tile};
use crate::shade::horizon::Horizon;
use crate::shade::terminator::Receivers;

/// Surfaces of eight samples in world space. Normals have unit length and point to the eye's side. The values
/// of a lane without a surface mean nothing.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    /// Places in this frame.
    pub point: Vec3x8,
    /// Shading normals.
    pub normal: Vec3x8,
    /// Normals of the triangles.
    pub geometric_normal: Vec3x8,
    /// Normals of the curved surfaces that the triangles stand for, where the shot has normal maps; else they are the shading ones.
    pub smooth: Option<Vec3x8>,
    /// Bit mask of fibres: see [`Receivers::fibres`].
    pub fibres: u8,
}

impl Placed {
    /// Transforms the samples of the eight cells from `first` on to world space. The result is the same to
    /// the bit for the same sample and pose, so that values computed from it may be kept.
    #[inline]
    pub fn of(frame: &FrameView, tile: &Tile, first: usize) -> Self {
        let point = tile.points(first);
        let (normals, geometric_normals) = (tile.normals(first), tile.geometric_normals(first));
        let geometric_normal = Octahedral::unfold_lanes(geometric_normals);
        // flat meshes: both normals are the same
        let normal =
            if normals == geometric_normals { geometric_normal } else { Octahedral::unfold_lanes(normals) };
        let mut placed =
            Self { point, normal, geometric_normal, smooth: None, fibres: fibres(frame, tile, first) };
        let Self { point, normal, geometric_normal, .. } = &mut placed;
        let triangle = |lane: usize| tile.record[first + lane].triangle;
        let of = (&tile.model[first..first + LANES], triangle);
        place(frame, of, || tile.ticks(first), [point, normal, geometric_normal]);
        if frame.palette.bends_normals {
            placed.smooth = Some(unbent(frame, tile, first, &placed));
        }
        placed
    }

    /// The surfaces as light sees them.
    #[inline(always)]
    pub fn receivers(&self) -> Receivers {
        let Self { point, normal, geometric_normal, smooth, fibres } = *self;
        Receivers { point, normal, smooth, geometric_normal, fibres }
    }
}

/// Bit mask of those of eight samples that are on fibres of hair.
#[inline(always)]
fn fibres(frame: &FrameView, tile: &Tile, first: usize) -> u8 {
    if !frame.palette.has_hair {
        return 0;
    }
    let surfaces = set_bits(surface_bits(&tile.model[first..first + LANES]));
    let is_fibre =
        |lane: &usize| frame.is_fibre(tile.model[first + *lane], tile.record[first + *lane].triangle);
    surfaces.filter(is_fibre).fold(0, |bits, lane| bits | 1 << lane)
}

/// Normals of the curved surfaces at eight samples: the shading normals, where no normal map bends them.
fn unbent(frame: &FrameView, tile: &Tile, first: usize, placed: &Placed) -> Vec3x8 {
    let mut normals = placed.normal;
    for lane in set_bits(surface_bits(&tile.model[first..first + LANES])) {
        let cell = first + lane;
        if frame.is_bent(tile.model[cell], tile.record[cell].triangle) {
            let flat = Horizon::flat(placed.geometric_normal.lane(lane));
            normals.set_lane(lane, of_sample(frame, tile, cell).unwrap_or(flat).normal);
        }
    }
    normals
}

/// The curved surface that a triangle stands for at the sample in `cell`, world space; `placed` holds its group of eight cells.
pub fn horizon(frame: &FrameView, tile: &Tile, cell: usize, placed: &Placed) -> Horizon {
    let normal = placed.smooth.unwrap_or(placed.normal).lane(cell % LANES);
    let is_fibre = placed.fibres >> (cell % LANES) & 1 != 0;
    Horizon { normal, lift: lift(frame, tile, cell), is_bent: placed.smooth.is_some(), is_fibre }
}

/// Way from the sample in `cell` to the curved surface that its triangle stands for, world space.
pub fn lift(frame: &FrameView, tile: &Tile, cell: usize) -> Vec3 {
    of_sample(frame, tile, cell).map_or(Vec3::ZERO, |horizon| horizon.lift)
}

fn of_sample(frame: &FrameView, tile: &Tile, cell: usize) -> Option<Horizon> {
    let record = &tile.record[cell];
    let (of, tick) = ((tile.model[cell], record.triangle), record.traced.tick());
    frame.horizon(of, tile.point(cell), record.is_from_behind(), tick)
}

/// Samples of one tile in world space. Each is placed once a frame, when a phase first asks for it.
#[derive(Debug)]
pub struct PlacedTile {
    /// Points, world space. The values of a cell without a surface mean nothing.
    pub point: [Column<f32>; 3],
    /// Shading normals, world space.
    pub normal: [Column<f32>; 3],
    geometric_normal: [Column<f32>; 3],
    /// See [`Placed::smooth`].
    smooth: [Column<f32>; 3],
    /// See [`Placed::fibres`].
    fibres: [u8; CELLS / LANES],
    /// True for each eight cells that are placed.
    is_ready: [bool; CELLS / LANES],
}

impl PlacedTile {
    /// Clears the state for the next tile.
    pub fn begin_tile(&mut self) {
        self.is_ready.fill(false);
    }

    /// Samples in the eight cells from `first` on, which must not change until the next tile.
    #[inline(always)]
    pub fn get(&mut self, frame: &FrameView, tile: &Tile, first: usize) -> Placed {
        if self.is_ready[first / LANES] {
            return Placed {
                point: load(&self.point, first),
                normal: load(&self.normal, first),
                geometric_normal: load(&self.geometric_normal, first),
                smooth: frame.palette.bends_normals.then(|| load(&self.smooth, first)),
                fibres: self.fibres[first / LANES],
            };
        }
        self.place(frame, tile, first)
    }

    #[inline(never)]
    fn place(&mut self, frame: &FrameView, tile: &Tile, first: usize) -> Placed {
        let placed = Placed::of(frame, tile, first);
        store(placed.point, &mut self.point, first);
        store(placed.normal, &mut self.normal, first);
        store(placed.geometric_normal, &mut self.geometric_normal, first);
        if let Some(smooth) = placed.smooth {
            store(smooth, &mut self.smooth, first);
        }
        self.fibres[first / LANES] = placed.fibres;
        self.is_ready[first / LANES] = true;
        placed
    }

    /// Places all samples of the tile that are not placed yet.
    pub fn complete(&mut self, frame: &FrameView, tile: &Tile) {
        for first in (0..CELLS).step_by(LANES) {
            if !self.is_ready[first / LANES] {
                self.get(frame, tile, first);
            }
        }
    }
}

impl Default for PlacedTile {
    fn default() -> Self {
        let columns = [[0.0; CELLS]; 3];
        Self {
            point: columns,
            normal: columns,
            geometric_normal: columns,
            smooth: columns,
            fibres: [0; CELLS / LANES],
            is_ready: [false; CELLS / LANES],
        }
    }
}

#[inline(always)]
fn load([x, y, z]: &[Column<f32>; 3], first: usize) -> Vec3x8 {
    Vec3x8::load([x, y, z], first)
}

#[inline(always)]
fn store(values: Vec3x8, [x, y, z]: &mut [Column<f32>; 3], first: usize) {
    values.store([x, y, z], first);
}
