//! What is measured of one subject in one flow.

use std::collections::{BTreeMap, BTreeSet};

use afterimage::frame::{RenderError, Renderer};
use afterimage::layers::Layers;
use afterimage::scene::Scene;
use afterimage::settings::Settings;
use afterimage::stats::SampleCounts;

use crate::coverage::{Areas, areas, moved};
use crate::fine::Fine;
use crate::flows::Flow;
use crate::picture::Picture;
use crate::subjects::{Subject, Unit};
use crate::toy;
use crate::watched::{Pictures, Tracks, Watch};

/// How much is measured.
#[derive(Debug, Clone)]
pub struct Extent {
    /// Pixels.
    pub size: [u32; 2],
    /// Numbers of the frames that are measured, rising; the chain begins with frame 1.
    pub frames: Vec<i32>,
    /// Along a pixel's edge, of the reference.
    pub fine: u32,
    /// The same where many frames are watched.
    pub watched: u32,
    /// Frames over which flicker is measured: up to each of `frames`.
    pub window: i32,
    /// Jittered frames, of which the mean is told.
    pub seeds: u64,
}

/// One frame of a chain, compared with the same frame traced anew: in the centres of its cells, as the program does, and
/// with a random place in each cell, as is usual.
pub struct Row {
    pub flow: Flow,
    /// Along a pixel's edge.
    pub samples: u32,
    pub frame: i32,
    /// Share of the samples that were traced in this frame.
    pub traced: f64,
    /// RMSE of a jittered frame.
    pub jittered: f64,
    /// RMSE over that of a jittered frame.
    pub inferred: f64,
    /// The same of the centred frame.
    pub centred: f64,
    /// What the object covers too much; in percent.
    pub coverage: Option<Coverage>,
    /// Half of what materials gain and lose, in percent of the picture: inferred, centred, jittered.
    pub moved: [f64; 3],
    /// Variance in time of the error on still surfaces, over that of centred frames, and of jittered ones.
    pub flicker: [f64; 2],
    pub picture: Picture,
    /// Of each material: inferred, centred, reference.
    pub areas: [Areas; 3],
}

/// In percent of the object's rim or area; positive where it covers too much.
#[derive(Debug, Clone, Copy)]
pub struct Coverage {
    pub inferred: f64,
    pub centred: f64,
    /// Root mean square of jittered frames: what chance does.
    pub jittered: f64,
}

/// How much the error changes in one frame, over how much it changes in another one.
pub struct Jumps {
    pub flow: Flow,
    pub samples: u32,
    /// From the base frame to the first inferred one, over the change to the second.
    pub first: f64,
    /// To a base frame in the middle of the chain, over the change in the frame before.
    pub again: f64,
    /// The same two, over the change between centred frames of the same numbers.
    pub over_centred: [f64; 2],
}

/// The material of a subject's object.
const OBJECT: usize = 0;

/// The base frame in the middle of the chain that [`Jumps`] are measured in.
const AGAIN: i32 = 25;

/// Of one flow: what everything is compared with.
pub struct Yardstick<'s> {
    subject: &'s Subject,
    flow: Flow,
    extent: &'s Extent,
    scene: Scene,
    fine: Vec<Fine>,
    references: Vec<Picture>,
    watch: Watch,
    tracks: Vec<Tracks>,
}

/// The settings of all that is rendered here. What decides how samples are reused is said here, too.
fn settings(extent: &Extent, samples: u32) -> Settings {
    let [width, height] = extent.size;
    Settings { width, height, samples, audit: false, layers: Layers::NONE, ..toy::settings(samples) }
}

impl<'s> Yardstick<'s> {
    pub fn new(subject: &'s Subject, flow: Flow, extent: &'s Extent) -> Result<Self, RenderError> {
        let scene = subject.scene(flow);
        let (settings, frames) = (settings(extent, 1), &extent.frames);
        let fine = Fine::of(&scene, &settings, frames, extent.fine)?;
        let references = fine.iter().map(Fine::picture).collect();
        let windows = || frames.iter().map(|frame| (frame - extent.window + 1).max(1)..=*frame);
        let watched: BTreeSet<i32> = windows().flatten().chain(jump_frames()).collect();
        let watch = Watch::of(&scene, &settings, watched, extent.watched)?;
        let tracks = windows().map(|window| watch.tracks(window)).collect();
        Ok(Self { subject, flow, extent, scene, fine, references, watch, tracks })
    }

    /// The picture of number `number` of the frames.
    pub fn reference(&self, number: usize) -> &Picture {
        &self.references[number]
    }

    /// All frames with so many samples.
    pub fn rows(&self, samples: u32) -> Result<Vec<Row>, RenderError> {
        let (settings, frames) = (settings(self.extent, samples), &self.extent.frames);
        let wanted = self.tracks.iter().flat_map(|tracks| tracks.frames.iter().copied()).collect();
        let (inferred, counts) = pictures(&self.scene, &settings, &wanted, Way::Chain { base: 1 })?;
        let (centred, _) = pictures(&self.scene, &settings, &wanted, Way::Full)?;
        let [covered, covered_centred] =
            [true, false].map(|reuse| areas(&self.scene, &settings, frames, reuse));
        let areas = covered?.into_iter().zip(covered_centred?);
        let row = |((number, frame), (covered, covered_centred)): ((usize, &i32), (Areas, Areas))| {
            let (fresh, reference) = (self.jittered(number, samples), &self.references[number]);
            let right = self.fine[number].areas();
            let whole = self.subject.object.map(|unit| match unit {
                Unit::Rim => self.fine[number].rim(OBJECT),
                Unit::Area => right[OBJECT],
            });
            let signed = |areas: &Areas, whole: f64| 100.0 * (areas[OBJECT] - right[OBJECT]) / whole;
            let error = fresh.root(|(picture, _)| picture.rmse(reference).powi(2));
            let tracks = &self.tracks[number];
            let noise = fresh.root(|(picture, _)| Watch::noise(tracks, &picture.less(reference)));
            let flicker = self.watch.flicker(tracks, &inferred);
            Row {
                flow: self.flow,
                samples,
                frame: *frame,
                traced: traced(&counts[frame]),
                jittered: error,
                inferred: inferred[frame].rmse(reference) / error,
                centred: centred[frame].rmse(reference) / error,
                coverage: whole.map(|whole| Coverage {
                    inferred: signed(&covered, whole),
                    centred: signed(&covered_centred, whole),
                    jittered: fresh.root(|(_, areas)| signed(areas, whole).powi(2)),
                }),
                moved: [
                    moved(&covered, &right),
                    moved(&covered_centred, &right),
                    fresh.root(|(_, areas)| moved(areas, &right).powi(2)),
                ],
                flicker: [self.watch.flicker(tracks, &centred), noise.powi(2)].map(|other| flicker / other),
                picture: inferred[frame].clone(),
                areas: [covered, covered_centred, right],
            }
        };
        Ok(frames.iter().enumerate().zip(areas).map(row).collect())
    }

    fn jittered(&self, number: usize, samples: u32) -> Jittered {
        let (fine, samples) = (&self.fine[number], samples as usize);
        let frames = (0..self.extent.seeds).map(|seed| fine.jittered(samples, seed)).collect();
        Jittered { frames, unbiased: 1.0 - fine.share_of_its_own(samples) }
    }

    /// How the error jumps at base frames.
    pub fn jumps(&self, samples: u32) -> Result<Jumps, RenderError> {
        let (settings, wanted) = (settings(self.extent, samples), jump_frames().collect());
        let (chain, _) = pictures(&self.scene, &settings, &wanted, Way::Chain { base: AGAIN })?;
        let (centred, _) = pictures(&self.scene, &settings, &wanted, Way::Full)?;
        let jump = |frame| self.watch.jump(frame, &chain);
        Ok(Jumps {
            flow: self.flow,
            samples,
            first: jump(2) / jump(3),
            again: jump(AGAIN) / jump(AGAIN - 1),
            over_centred: [2, AGAIN].map(|frame| jump(frame) / self.watch.jump(frame, &centred)),
        })
    }
}

/// Frames of which each cell has its sample at a random place.
struct Jittered {
    frames: Vec<(Picture, Areas)>,
    /// By so much are squares of distances to the reference too small.
    unbiased: f64,
}

impl Jittered {
    /// The root of the mean of `square`, the square of a distance to the reference.
    fn root(&self, square: impl Fn(&(Picture, Areas)) -> f64) -> f64 {
        (self.frames.iter().map(square).sum::<f64>() / self.frames.len() as f64 / self.unbiased).sqrt()
    }
}

/// Those that [`Jumps`] are measured in.
fn jump_frames() -> impl Iterator<Item = i32> {
    (1..=3).chain(AGAIN - 2..=AGAIN)
}

/// How frames are made.
enum Way {
    /// Each from the one before, but for the first and `base`.
    Chain { base: i32 },
    /// Each traced anew.
    Full,
}

/// The frames that are wanted.
fn pictures(
    scene: &Scene,
    settings: &Settings,
    wanted: &BTreeSet<i32>,
    way: Way,
) -> Result<(Pictures, BTreeMap<i32, SampleCounts>), RenderError> {
    let mut renderer = Renderer::new(scene, settings)?;
    let (mut pictures, mut counts) = (Pictures::new(), BTreeMap::new());
    for frame in 1..=wanted.last().copied().unwrap_or(0) {
        let is_wanted = wanted.contains(&frame);
        let reuse = match way {
            Way::Chain { base } => frame != base,
            Way::Full if is_wanted => false,
            Way::Full => continue,
        };
        let finished = renderer.render(frame, reuse)?;
        if is_wanted {
            pictures.insert(frame, Picture::of(&finished.film));
            counts.insert(frame, finished.stats.samples);
        }
        renderer.recycle(finished.film);
    }
    Ok((pictures, counts))
}

/// The share of samples that were traced.
fn traced(counts: &SampleCounts) -> f64 {
    let traced = counts.base + counts.missed + counts.obscured;
    traced as f64 / (traced + counts.good + counts.overlapped) as f64
}
