//! The state that a picture leaves for later frames: its samples and its film.

use std::sync::Arc;

use super::lineage::Ancestor;
use super::shot::prepared::Prepared;
use super::tiles::level::{Level, LevelScratch};
use super::validity::{self, ValidDirection};
use crate::changes::Direction;
use crate::film::Film;
use crate::pose::Pose;
use crate::samples::SampleStore;
use crate::samples::saved::{PictureName, PictureSamples};

/// Samples and film of one picture: of an eye and an exposure, as it was rendered last.
pub struct PictureHistory {
    /// The picture's name.
    pub picture: PictureName,
    /// The state of the shot in the frame whose samples these are; `None` where there are no samples.
    pub pose: Option<Pose>,
    /// The direction of time in which the answers of its samples hold.
    pub valid: ValidDirection,
    /// Levels of samples, the coarsest first.
    pub levels: Vec<Level>,
    /// The film of that frame. What stays the same is left in it, unless somebody still reads it then.
    pub film: Option<Arc<Film>>,
}

impl PictureHistory {
    /// Creates a history without samples.
    pub fn new(picture: PictureName, prepared: &Prepared) -> Self {
        let level = |grid: &Arc<_>| Level::new(Arc::clone(grid), &prepared.layout);
        let levels = prepared.grids.iter().map(level).collect();
        Self { picture, pose: None, valid: ValidDirection::To(Direction::Forward), levels, film: None }
    }

    /// Drops the samples. Their tiles are used again.
    pub fn drop_samples(&mut self, scratch: &mut LevelScratch) {
        self.pose = None;
        self.levels.iter_mut().for_each(|level| level.drop_samples(scratch));
    }

    /// The picture, if its samples exist.
    pub fn ancestor(&self) -> Option<Ancestor<'_>> {
        Some(Ancestor { picture: self.picture, pose: self.pose.as_ref()?, valid: self.valid })
    }

    /// Forgets what the film shows.
    pub fn forget_film(&mut self) {
        self.film = None;
        self.levels.iter_mut().for_each(|level| level.buffers.states.clear());
    }

    /// The samples, if there are any.
    pub fn samples(&self) -> Option<PictureSamples<&SampleStore>> {
        let levels = self.levels.iter().map(Level::kept).collect::<Option<_>>()?;
        Some(PictureSamples { picture: self.picture, levels })
    }

    /// Makes the answers of its samples hold in the direction of `wanted`.
    pub fn reverse(&mut self, prepared: &Prepared, wanted: ValidDirection) {
        let Some(pose) = &self.pose else { return };
        let exposure = self.picture.exposure;
        let motions = (prepared.motion(exposure), prepared.motion_back(exposure));
        validity::reverse(&mut self.levels, self.valid, wanted, pose, motions);
        if self.valid.direction() != wanted.direction() {
            self.valid = wanted;
        }
    }
}
