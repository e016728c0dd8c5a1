//! Pictures in tiles (`<UDIM>` in their names): each shows a unit of texture coordinates.

use std::fs;
use std::path::{Path, PathBuf};

use glam::{Mat2, Vec2};

use crate::scene::texture::{Mapping, Wrap};

/// Word in a name that stands for the number of a tile.
const NUMBER: &str = "<UDIM>";

/// Number of the first tile, and of tiles in a row.
const FIRST: u32 = 1001;
const A_ROW: u32 = 10;

/// Largest number of a tile.
const LAST: u32 = 1999;

/// Tiles of a picture, as they lie.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tiles {
    /// Numbers of columns and rows.
    pub size: [u32; 2],
    /// Column and row of the first tile, from (0, 0) of the texture coordinates.
    first: [u32; 2],
    /// Files by column and row among these, rows from the bottom.
    pub files: Vec<([u32; 2], PathBuf)>,
}

/// Returns true if a name is that of tiles.
pub fn are_named(name: &str) -> bool {
    name.contains(NUMBER)
}

impl Tiles {
    /// Finds the tiles that are called `path`, with a number in it. `None` if there are none.
    pub fn find(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?;
        let (before, after) = name.split_once(NUMBER)?;
        let mut files: Vec<([u32; 2], PathBuf)> = fs::read_dir(path.parent()?)
            .ok()?
            .flatten()
            .filter_map(|entry| {
                let own = entry.file_name();
                let number = own.to_str()?.strip_prefix(before)?.strip_suffix(after)?;
                let number: u32 = number.parse().ok().filter(|_| number.len() == 4)?;
                let place = (FIRST..=LAST).contains(&number).then(|| number - FIRST)?;
                Some(([place % A_ROW, place / A_ROW], entry.path()))
            })
            .collect();
        files.sort();
        let ends = |axis: usize| {
            let places = files.iter().map(|(place, _)| place[axis]);
            Some([places.clone().min()?, places.max()?])
        };
        let ([left, right], [low, high]) = (ends(0)?, ends(1)?);
        files.iter_mut().for_each(|(place, _)| *place = [place[0] - left, place[1] - low]);
        Some(Self { size: [right - left + 1, high - low + 1], first: [left, low], files })
    }

    /// Mapping of a picture in which the tiles lie beside each other, for that of one tile.
    pub fn mapping(&self, of_tile: Mapping) -> Mapping {
        let shrink = Vec2::from(self.size.map(|count| 1.0 / count as f32));
        let first = Vec2::from(self.first.map(|place| place as f32));
        Mapping {
            linear: Mat2::from_diagonal(shrink) * of_tile.linear,
            offset: shrink * (of_tile.offset - first),
            wrap: [Wrap::Clamp; 2],
            ..of_tile
        }
    }
}
