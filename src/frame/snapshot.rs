//! Samples of a frame that was rendered, from which a renderer goes on later: when it has been elsewhere meanwhile, or in another
//! process.

use rayon::prelude::*;

use super::validity::ValidDirection;
use crate::samples::saved::{LevelSamples, PictureSamples};
use crate::samples::{SampleStore, Tile};

/// State of a renderer that goes with its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    /// The frame rendered last.
    pub frame: i32,
    /// Frames rendered so far: samples count their age from it.
    pub rendered: u32,
    /// The direction of time in which the answers of its samples hold.
    pub valid: ValidDirection,
}

/// Samples of a frame, and what goes with them.
#[derive(Debug)]
pub struct Snapshot {
    /// Frame of the samples, and state that goes with it.
    pub moment: Moment,
    /// Samples of each picture of the frame.
    pub pictures: Vec<PictureSamples<SampleStore>>,
}

impl Snapshot {
    /// A copy.
    pub fn new(moment: Moment, pictures: &[PictureSamples<&SampleStore>]) -> Self {
        let copy = |LevelSamples { store, wanted }: &LevelSamples<&SampleStore>| {
            let tiles: Vec<Box<Tile>> = store.tiles.par_iter().cloned().collect();
            let SampleStore { regions, mirrored, .. } = *store;
            let store = SampleStore { tiles, regions: *regions, mirrored: mirrored.clone() };
            LevelSamples { store, wanted: wanted.clone() }
        };
        let pictures = pictures.iter().map(|PictureSamples { picture, levels }| PictureSamples {
            picture: *picture,
            levels: levels.iter().map(copy).collect(),
        });
        Self { moment, pictures: pictures.collect() }
    }
}
