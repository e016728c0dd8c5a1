//! The pictures of a renderer: each is made as its [lineage](super::lineage) says, and leaves a [history](super::history).

use super::history::PictureHistory;
use super::lineage::{Ancestor, Lineage, Rule};
use super::picture::{self, PictureRequest, RenderedPicture};
use super::render_error::RenderError;
use super::shot::plan::CameraChange;
use super::shot::prepared::Prepared;
use super::shot::reflection_maps::ReflectionMaps;
use super::tiles::level::{Level, LevelScratch};
use super::validity::ValidDirection;
use crate::pose::Pose;
use crate::samples::SampleStore;
use crate::samples::saved::{LevelSamples, PictureName, PictureSamples};
use crate::stereo::Eye;
use crate::trace::Backend;

/// The pictures of a renderer whose samples or films are kept, and the memory in which they are made.
#[derive(Default)]
pub struct Pictures {
    /// In the order in which they were made: the latest one last.
    all: Vec<PictureHistory>,
    /// Reflection maps of the picture made last, if it was finished.
    pub maps: ReflectionMaps,
    scratch: LevelScratch,
}

impl Pictures {
    /// Begins `frame` of `eye`: without `reuse`, samples of earlier frames are dropped.
    pub fn begin(&mut self, eye: Eye, reuse: bool) {
        if !reuse {
            let of_eye = self.all.iter_mut().filter(|one| one.picture.eye == eye);
            of_eye.for_each(|one| one.drop_samples(&mut self.scratch));
        }
    }

    /// Renders the picture that `request` names, and keeps its samples and its film. An error leaves nothing of the picture.
    pub fn render(
        &mut self,
        prepared: &mut Prepared,
        backend: &mut dyn Backend,
        request: &PictureRequest,
        rule: &Rule,
    ) -> Result<RenderedPicture, RenderError> {
        let lineage =
            Lineage::new(request.picture, &request.pose, &self.ancestors(), rule).with_media(&prepared.media);
        if lineage.from.is_some() && lineage.plan.camera == CameraChange::None {
            prepared.look_ahead();
        }
        if !lineage.valid.is_forward_alone() {
            prepared.look_back();
        }
        if let Some(ancestor) = self.all.iter_mut().find(|one| Some(one.picture) == lineage.from) {
            ancestor.reverse(prepared, lineage.valid);
        }
        let mut history = self.take(&lineage, request.picture, prepared);
        let named = |name: Option<PictureName>| self.all.iter().find(|one| Some(one.picture) == name);
        let (lender, beside) = (named(lineage.from.filter(|_| lineage.is_lent)), named(lineage.beside));
        let made = picture::render(
            prepared,
            (backend, &mut self.maps, &mut self.scratch),
            (&mut history, lender, beside),
            &lineage,
            request,
        )?;
        history.valid = lineage.valid;
        history.pose = Some(request.pose.clone());
        // of many exposures films would take as much memory as samples, and are of use where they can be left as they are
        if prepared.exposures.all.len() > 1
            && !prepared.rests(&request.pose, request.picture.exposure, request.place.as_ref())
        {
            history.forget_film();
        }
        self.all.push(history);
        Ok(made)
    }

    /// Takes out the history in which a picture of that lineage is made: its own, or a new one.
    fn take(&mut self, lineage: &Lineage, picture: PictureName, prepared: &Prepared) -> PictureHistory {
        let mut history = match self.all.iter().position(|one| one.picture == picture) {
            Some(index) => self.all.remove(index),
            None => PictureHistory::new(picture, prepared),
        };
        if lineage.from != Some(picture) {
            history.drop_samples(&mut self.scratch);
        }
        history
    }

    /// Pictures that have samples, the latest one last.
    fn ancestors(&self) -> Vec<Ancestor<'_>> {
        self.all.iter().filter_map(PictureHistory::ancestor).collect()
    }

    /// Samples of the frame rendered last, by picture, with the direction in which their answers hold.
    pub fn samples(&self) -> Option<(i32, ValidDirection, Vec<PictureSamples<&SampleStore>>)> {
        let latest = self.all.last().filter(|one| one.pose.is_some())?;
        let frame = latest.pose.as_ref()?.frame;
        let of_frame =
            self.all.iter().filter(|one| one.pose.as_ref().is_some_and(|pose| pose.frame == frame));
        let mut pictures: Vec<_> = of_frame.map(PictureHistory::samples).collect::<Option<_>>()?;
        pictures.sort_by_key(|one| (one.picture.eye as usize, one.picture.exposure));
        Some((frame, latest.valid, pictures))
    }

    /// Goes on from samples of a picture with everything as `pose` says. Pictures come in the order in which they were made.
    pub fn restore(
        &mut self,
        (picture, pose): (PictureName, Pose),
        valid: ValidDirection,
        levels: Vec<LevelSamples<SampleStore>>,
        prepared: &Prepared,
    ) {
        let mut history = PictureHistory::new(picture, prepared);
        history.levels.iter_mut().zip(levels).for_each(|(level, kept)| level.restore(kept));
        (history.pose, history.valid) = (Some(pose), valid);
        self.all.push(history);
    }

    /// Forgets all samples and films, and whatever a picture that was not finished has left.
    pub fn forget(&mut self) {
        self.all.clear();
        self.scratch = LevelScratch::default();
    }

    /// Forgets what films show.
    pub fn forget_films(&mut self) {
        self.all.iter_mut().for_each(PictureHistory::forget_film);
    }

    /// All levels of all pictures.
    pub fn levels(&mut self) -> impl Iterator<Item = &mut Level> {
        self.all.iter_mut().flat_map(|one| &mut one.levels)
    }

    /// The latest picture of `eye`.
    pub fn latest(&mut self, eye: Eye) -> Option<&mut PictureHistory> {
        self.all.iter_mut().rfind(|one| one.picture.eye == eye)
    }

    /// Bytes in use, and samples that are kept.
    pub fn size(&self, prepared: &Prepared) -> (u64, u64) {
        let levels = || self.all.iter().flat_map(|one| &one.levels).filter(|level| level.store.is_some());
        let bytes: usize = levels().map(|level| level.bytes(&prepared.layout)).sum();
        ((bytes + self.scratch.bytes(&prepared.layout)) as u64, levels().map(Level::samples).sum())
    }
}
