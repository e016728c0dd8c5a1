//! Measurements of a subject in one flow.

use std::collections::{BTreeMap, BTreeSet};

use afterimage::frame::{RenderError, Renderer};
use afterimage::layers::Layers;
use afterimage::scene::Scene;
use afterimage::settings::{Filter, Settings};
use afterimage::stats::SampleCounts;

use super::coverage::{Areas, areas, moved};
use super::flows::Flow;
use super::picture::Picture;
use super::reference::Reference;
use super::sequence::{Pictures, Sequence, Tracks};
use super::subjects::{Subject, Unit};
use super::toy;

#[derive(Debug, Clone)]
pub struct Options {
    /// Size of the pictures, pixels.
    pub size: [u32; 2],
    /// Frames to measure, rising; the chain starts at frame 1.
    pub frames: Vec<i32>,
    /// Filter of inferred and of centred frames, with its radius in pixels, if it is not the usual one.
    pub filter: (Filter, Option<f32>),
    /// Samples along a pixel's edge in the references.
    pub reference: u32,
    /// Samples along a pixel's edge in the references of all frames that are compared over time.
    pub sequence: u32,
    /// Frames over which flicker is measured, the last of them one of `frames`.
    pub window: i32,
    /// Number of jittered frames to average.
    pub seeds: u64,
}

/// One frame of a chain, beside two fresh frames: *centred*, traced through the centres of the cells, as the program
/// does, and *jittered*, with a random place in each cell.
pub struct Row {
    pub flow: Flow,
    /// Samples along a pixel's edge.
    pub samples: u32,
    pub frame: i32,
    /// Share of the samples that were traced for this frame.
    pub traced: f64,
    /// RMSE of a jittered frame.
    pub jittered: f64,
    /// RMSE of the inferred frame over `jittered`.
    pub inferred: f64,
    /// RMSE of the centred frame over `jittered`.
    pub centred: f64,
    /// Coverage error of the subject's object, if it has one.
    pub coverage: Option<Coverage>,
    /// Half the sum of the areas that materials gain and lose, as a percentage of the picture: inferred,
    /// centred, jittered.
    pub moved: [f64; 3],
    /// Flicker over that of centred frames, and over that of jittered ones.
    pub flicker: [f64; 2],
    pub picture: Picture,
    /// Areas of all materials: inferred, centred, reference.
    pub areas: [Areas; 3],
}

/// Signed coverage error, in percent of the object's rim or area; positive if it covers too much.
#[derive(Debug, Clone, Copy)]
pub struct Coverage {
    pub inferred: f64,
    pub centred: f64,
    /// Standard deviation of jittered frames.
    pub jittered: f64,
}

/// Pops: changes of the error between a base frame and an inferred one, compared with other changes.
pub struct Pops {
    pub flow: Flow,
    pub samples: u32,
    /// Change from frame 1, a base frame, to frame 2, over the change from 2 to 3.
    pub from_base: f64,
    /// Change to a base frame in the middle of a chain, over the change to the frame before it.
    pub to_base: f64,
    /// Both changes, over the change between centred frames of the same numbers.
    pub over_centred: [f64; 2],
}

/// Number of the material of a subject's object.
const OBJECT: usize = 0;

/// Number of the base frame in the middle of the chain in which [`Pops`] are measured.
const SECOND_BASE: i32 = 25;

/// References of one flow, with which chains are compared.
pub struct Comparison<'s> {
    subject: &'s Subject,
    flow: Flow,
    options: &'s Options,
    scene: Scene,
    references: Vec<Reference>,
    sequence: Sequence,
    tracks: Vec<Tracks>,
}

/// Settings of all renderings here: the place for a setting that decides how samples are reused.
fn settings(options: &Options, samples: u32) -> Settings {
    let [width, height] = options.size;
    Settings { width, height, samples, audit: false, layers: Layers::NONE, ..toy::settings(samples) }
}

impl<'s> Comparison<'s> {
    pub fn new(subject: &'s Subject, flow: Flow, options: &'s Options) -> Result<Self, RenderError> {
        let scene = subject.scene(flow);
        let (settings, frames) = (settings(options, 1), &options.frames);
        let references = Reference::of(&scene, &settings, frames, options.reference)?;
        let windows = || frames.iter().map(|frame| (frame - options.window + 1).max(1)..=*frame);
        let compared: BTreeSet<i32> = windows().flatten().chain(pop_frames()).collect();
        let sequence = Sequence::new(&scene, &settings, compared, options.sequence)?;
        let tracks = windows().map(|window| sequence.tracks(window)).collect();
        Ok(Self { subject, flow, options, scene, references, sequence, tracks })
    }

    /// Reference picture of `options.frames[number]`.
    pub fn reference(&self, number: usize) -> Picture {
        self.references[number].whole().0
    }

    /// Returns `settings` with the filter of inferred and of centred frames.
    fn filtered(&self, settings: &Settings) -> Settings {
        let (filter, filter_radius) = self.options.filter;
        Settings { filter, filter_radius, ..settings.clone() }
    }

    /// Compares all frames, with `samples` x `samples` samples a pixel.
    pub fn rows(&self, samples: u32) -> Result<Vec<Row>, RenderError> {
        let (settings, frames) = (settings(self.options, samples), &self.options.frames);
        let filtered = self.filtered(&settings);
        let wanted = self.tracks.iter().flat_map(|tracks| tracks.frames.iter().copied()).collect();
        let (inferred, counts) = pictures(&self.scene, &filtered, &wanted, Way::Chain { base: 1 })?;
        let (centred, _) = pictures(&self.scene, &filtered, &wanted, Way::Full)?;
        let inferred_areas = areas(&self.scene, &settings, frames, true)?;
        let centred_areas = areas(&self.scene, &settings, frames, false)?;
        let row = |(number, frame): (usize, &i32)| {
            let (reference, tracks) = (&self.references[number], &self.tracks[number]);
            let (truth, area) = reference.whole();
            let fresh = Jittered::new(reference, samples as usize, self.options.seeds);
            let error = fresh.rms(|(picture, _)| picture.rmse(&truth));
            let unit = self.subject.object.map(|unit| match unit {
                Unit::Rim => reference.rim(OBJECT),
                Unit::Area => area[OBJECT],
            });
            let signed = |areas: &Areas, unit: f64| 100.0 * (areas[OBJECT] - area[OBJECT]) / unit;
            let noise = fresh.rms(|(picture, _)| Sequence::noise(tracks, &picture.less(&truth)).sqrt());
            let flicker = self.sequence.flicker(tracks, &inferred);
            let [ours, centres] = [&inferred_areas, &centred_areas].map(|areas| areas[number].clone());
            Row {
                flow: self.flow,
                samples,
                frame: *frame,
                traced: traced(&counts[frame]),
                jittered: error,
                inferred: inferred[frame].rmse(&truth) / error,
                centred: centred[frame].rmse(&truth) / error,
                coverage: unit.map(|unit| Coverage {
                    inferred: signed(&ours, unit),
                    centred: signed(&centres, unit),
                    jittered: fresh.rms(|(_, areas)| signed(areas, unit)),
                }),
                moved: [
                    moved(&ours, &area),
                    moved(&centres, &area),
                    fresh.rms(|(_, areas)| moved(areas, &area)),
                ],
                flicker: [self.sequence.flicker(tracks, &centred), noise.powi(2)]
                    .map(|other| flicker / other),
                picture: inferred[frame].clone(),
                areas: [ours, centres, area],
            }
        };
        Ok(frames.iter().enumerate().map(row).collect())
    }

    /// Measures pops, with `samples` x `samples` samples a pixel.
    pub fn pops(&self, samples: u32) -> Result<Pops, RenderError> {
        let settings = settings(self.options, samples);
        let (filtered, wanted) = (self.filtered(&settings), pop_frames().collect());
        let (chain, _) = pictures(&self.scene, &filtered, &wanted, Way::Chain { base: SECOND_BASE })?;
        let (centred, _) = pictures(&self.scene, &filtered, &wanted, Way::Full)?;
        let change = |frame| self.sequence.change(frame, &chain);
        Ok(Pops {
            flow: self.flow,
            samples,
            from_base: change(2) / change(3),
            to_base: change(SECOND_BASE) / change(SECOND_BASE - 1),
            over_centred: [2, SECOND_BASE].map(|frame| change(frame) / self.sequence.change(frame, &centred)),
        })
    }
}

/// Fresh frames with a random place in each cell.
struct Jittered {
    frames: Vec<(Picture, Areas)>,
    bias: f64,
}

impl Jittered {
    fn new(reference: &Reference, samples: usize, seeds: u64) -> Self {
        let frames = (0..seeds).map(|seed| reference.jittered(samples, seed)).collect();
        Self { frames, bias: reference.bias(samples) }
    }

    /// Root mean square of a distance from the reference.
    fn rms(&self, distance: impl Fn(&(Picture, Areas)) -> f64) -> f64 {
        let squares: f64 = self.frames.iter().map(|frame| distance(frame).powi(2)).sum();
        (squares / self.frames.len() as f64 / self.bias).sqrt()
    }
}

/// Frames in which [`Pops`] are measured.
fn pop_frames() -> impl Iterator<Item = i32> {
    (1..=3).chain(SECOND_BASE - 2..=SECOND_BASE)
}

/// Ways to make frames.
enum Way {
    /// Inferred from the frame before, except for frames 1 and `base`.
    Chain { base: i32 },
    /// Traced in full.
    Full,
}

/// Renders the `wanted` frames.
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
    }
    Ok((pictures, counts))
}

/// Share of the samples that were traced.
fn traced(counts: &SampleCounts) -> f64 {
    let traced = counts.base + counts.missed + counts.obscured;
    traced as f64 / (traced + counts.good + counts.overlapped) as f64
}
