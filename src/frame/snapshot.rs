//! Samples of a frame that was rendered, from which a renderer goes on later: when it has been elsewhere meanwhile, or in another
//! process.

use rayon::prelude::*;

use crate::changes::Direction;
use crate::samples::saved::{LevelSamples, PictureSamples};
use crate::samples::{SampleStore, Tile};

/// What of a renderer goes with its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    /// The frame rendered last.
    pub frame: i32,
    /// Frames rendered so far: samples count their age from it.
    pub rendered: u32,
    /// In which direction what the samples have found out holds.
    pub holds: Holds,
}

/// In which direction of time answers hold until the frame that they name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holds {
    /// In this one.
    To(Direction),
    /// In both, for as many frames: they are of a base frame with frames on either side, and name the frame forwards.
    Both,
}

impl Holds {
    /// Whether answers may be asked as they are by who goes in that direction.
    pub fn includes(self, direction: Direction) -> bool {
        match self {
            Self::To(own) => own == direction,
            Self::Both => direction == Direction::Forward,
        }
    }
}

/// Samples of a frame, and what goes with them.
#[derive(Debug)]
pub struct Snapshot {
    /// Of which frame.
    pub moment: Moment,
    /// Of each picture that it is made of.
    pub pictures: Vec<PictureSamples<SampleStore>>,
}

impl Snapshot {
    /// A copy.
    pub fn of(moment: Moment, pictures: &[PictureSamples<&SampleStore>]) -> Self {
        let copy = |LevelSamples { store, wanted }: &LevelSamples<&SampleStore>| {
            let tiles: Vec<Box<Tile>> = store.tiles.par_iter().cloned().collect();
            LevelSamples { store: SampleStore { tiles }, wanted: wanted.clone() }
        };
        let pictures = pictures.iter().map(|PictureSamples { picture, levels }| PictureSamples {
            picture: *picture,
            levels: levels.iter().map(copy).collect(),
        });
        Self { moment, pictures: pictures.collect() }
    }
}
