//! Frames that are the mean of several exposures: motion blur and depth of field ([`exposure`](crate::exposure)).
//!
//! Each exposure is a picture by itself, at its own time and from its own point of the lens: made by the same phases as any
//! frame, and of samples that were seen elsewhere and at another time, which are projected and verified for it. Whose samples those
//! are is a rule that follows from poses alone:
//!
//! - While the camera moves there is one store, which goes from each exposure to the next, and from the last one of a frame to
//!   the first one of the next: steps are small.
//! - Where the camera rests, each exposure keeps its own store, and goes on in place with it: what does not move costs nothing,
//!   out of focus as well. Until it has one it takes the samples of the exposure before, which gets them back, as the right
//!   one of two eyes takes the left one's.
//!
//! Two eyes expose a frame one after the other, and each goes on with its own samples. From the left eye's exposure at the same time
//! the right one would be further away than from its own exposure before; and the left eye has left that time when it is done.

use std::time::Instant;

use super::channels::Channel;
use super::eyes::{EyeMemory, Source};
use super::mean::{Mean, Rule};
use super::picture::{self, Made, Order};
use super::prepared::Prepared;
use super::reflection_maps::ReflectionMaps;
use crate::changes::Direction;
use crate::exposure::Exposures;
use crate::film::Film;
use crate::pose::{CameraPose, Pose};
use crate::scene::Scene;
use crate::settings::{Filter, Mode, Settings};
use crate::stereo::{Eye, EyePlace};
use crate::trace::{Backend, TraceError};

/// What is kept of the exposures of one eye from frame to frame.
pub struct Blur {
    exposures: Exposures,
    /// Where the eye is beside the camera, if there are two.
    place: Option<EyePlace>,
    /// One for each exposure; none where it has no samples.
    memories: Vec<Option<EyeMemory>>,
    /// Which of them was rendered last.
    newest: usize,
    /// Planes of exposures that are not the middle one.
    channels: Vec<Channel>,
    /// The frame rendered last.
    frame: Option<i32>,
}

/// The exposures of a frame of `scene`, if it has more to it than one picture at its own time.
pub fn exposures(scene: &Scene, settings: &Settings) -> Option<Exposures> {
    let Settings { shutter, exposures, filter, .. } = settings;
    let has_lens = scene.camera.has_lens();
    if shutter.is_none() && !has_lens {
        return None;
    }
    let is_open = shutter.is_some_and(|shutter| shutter.close > shutter.open);
    let count = if is_open || has_lens { *exposures } else { 1 };
    // a wider filter weighs samples by where they are, and would be made wider still
    Some(Exposures::new(count, *shutter, &scene.camera.cuts, *filter == Filter::Box))
}

impl Blur {
    /// Of a shot that is prepared.
    pub fn new(exposures: Exposures, place: Option<EyePlace>, prepared: &Prepared) -> Self {
        let is_of_all = |channel: &&Channel| Rule::of(channel) != Rule::Middle;
        Self {
            memories: exposures.all.iter().map(|_| None).collect(),
            newest: 0,
            channels: prepared.channels.iter().filter(is_of_all).cloned().collect(),
            frame: None,
            exposures,
            place,
        }
    }

    /// All that is kept.
    pub fn memories(&mut self) -> impl Iterator<Item = &mut EyeMemory> {
        self.memories.iter_mut().flatten()
    }

    /// The same, to be read.
    pub fn kept(&self) -> impl Iterator<Item = &EyeMemory> {
        self.memories.iter().flatten()
    }

    /// What is kept of the exposure rendered last.
    pub fn newest(&mut self) -> Option<&mut EyeMemory> {
        self.memories[self.newest].as_mut()
    }

    /// Whether each exposure of `frame` keeps its samples in place.
    pub fn rests(&self, prepared: &Prepared, frame: i32) -> bool {
        prepared.settings.mode != Mode::Full && rests(&self.exposures, prepared.scene, frame)
    }

    /// Makes all exposures of `frame`, and gives each to `take`. With `reuse` they are made of the samples of an earlier frame, if there
    /// was one; without it the first one is traced in full, and the others are made of its samples. `rendered`: frames so far, with this
    /// one.
    pub fn render(
        &mut self,
        prepared: &Prepared,
        (backend, maps): (&mut dyn Backend, &mut ReflectionMaps),
        (frame, reuse): (i32, bool),
        rendered: u32,
        mut take: impl FnMut(Made),
    ) -> Result<Film, TraceError> {
        let last = self.frame.take();
        let is_full = prepared.settings.mode == Mode::Full;
        if is_full || !reuse || last.is_none_or(|last| last >= frame) {
            self.memories.iter_mut().for_each(|memory| *memory = None);
        }
        let rests = self.rests(prepared, frame);
        let size = prepared.settings.data_window();
        let mut mean = Mean::new(&prepared.channels, [size.width, size.height]);
        for index in 0..self.memories.len() {
            let made = self.expose(prepared, (&mut *backend, &mut *maps), (frame, index), rests, rendered)?;
            mean.add(&made.film, &prepared.channels);
            take(made);
        }
        self.frame = Some(frame);
        Ok(mean.finish(&prepared.channels))
    }

    fn expose(
        &mut self,
        prepared: &Prepared,
        (backend, maps): (&mut dyn Backend, &mut ReflectionMaps),
        (frame, index): (i32, usize),
        rests: bool,
        rendered: u32,
    ) -> Result<Made, TraceError> {
        let start = Instant::now();
        let settings = &prepared.settings;
        let cells = settings.levels().last().unwrap_or(settings.samples);
        let picture = ([settings.width, settings.height], cells);
        let exposure = (&self.exposures, index);
        let pose = Pose::exposed(prepared.scene, frame, exposure, self.place.as_ref(), picture);
        let is_middle = index == self.exposures.middle();
        let is_full = settings.mode == Mode::Full;
        let source = if is_full { Source::None } else { self.source(prepared, index, &pose, rests) };
        let is_lent = matches!(source, Source::Lent(_));
        let eyes = if self.place.is_some() { Eye::BOTH.len() } else { 1 };
        let sharers = self.memories.len() * eyes;
        let mut newest = self.memories[self.newest].take_if(|_| self.newest != index);
        let place = self.place;
        let memory = self.memories[index].get_or_insert_with(|| fresh(place, prepared));
        if let Some(newest) = &mut newest {
            memory.take_room_from(newest);
        }
        if let Some(lender) = newest.as_mut().filter(|_| is_lent) {
            memory.borrow_from(lender);
        }
        let order = Order {
            pose: &pose,
            reuse: source.pose().is_some(),
            plan: source.plan(&pose),
            shown: source.pose().filter(|_| !is_lent),
            time: (Direction::Forward, false),
            rendered,
            channels: if is_middle { &prepared.channels } else { &self.channels },
            at_frame: is_middle.then_some(frame),
            sharers,
            start,
        };
        let made = picture::make(prepared, backend, memory, maps, &order);
        if let Some(mut newest) = newest {
            if is_lent {
                memory.give_back_to(&mut newest);
            }
            self.memories[self.newest] = Some(newest);
        }
        self.newest = index;
        made
    }

    /// Whose samples exposure `index` of the frame is made of: its own in place, or those of the exposure before, which leaves them to
    /// it, or lends them where the camera `rests`. They are where they are needed then, but for those that are lent.
    fn source(&mut self, prepared: &Prepared, index: usize, pose: &Pose, rests: bool) -> Source {
        let last = |memory: &Option<EyeMemory>| memory.as_ref().and_then(|memory| memory.last.clone());
        let own = last(&self.memories[index]);
        let newest = last(&self.memories[self.newest]);
        match (own, newest) {
            (Some(own), _) if own.camera == pose.camera || self.newest == index => Source::Own(own),
            (_, None) => {
                self.memories[index] = None;
                Source::None
            }
            (_, Some(newest)) if rests => Source::Lent(newest),
            (_, Some(newest)) => {
                let mut memory = self.memories[self.newest].take();
                let of = |index| {
                    if index == self.exposures.middle() { &prepared.channels } else { &self.channels }
                };
                if let Some(memory) = memory.as_mut().filter(|_| of(index).len() != of(self.newest).len()) {
                    memory.film = None;
                }
                self.memories[index] = memory;
                Source::Own(newest)
            }
        }
    }
}

/// Whether the camera is in one place for all of this frame and the next one of the shot.
fn rests(exposures: &Exposures, scene: &Scene, frame: i32) -> bool {
    let clock = &exposures.clock;
    let at = |moment| {
        let time = clock.time(moment);
        (CameraPose::of(&scene.camera, time), scene.camera.lens_at(time))
    };
    let [first, last] = [clock.moment(frame, 0), clock.moment(frame.saturating_add(1), usize::MAX >> 1)];
    let camera = at(first);
    (first..=last).all(|moment| at(moment) == camera)
}

/// How many stores there are in the worst of `frames`.
pub fn stores(scene: &Scene, settings: &Settings, frames: impl Iterator<Item = i32>) -> usize {
    /// So many are looked at; of others the worst is assumed.
    const MOST_FRAMES: usize = 10_000;
    let Some(exposures) = exposures(scene, settings).filter(|_| settings.mode != Mode::Full) else {
        return 1;
    };
    let mut rest =
        frames.enumerate().map(|(number, frame)| number >= MOST_FRAMES || rests(&exposures, scene, frame));
    if rest.any(|rests| rests) { exposures.all.len() } else { 1 }
}

/// Of an exposure that has no samples yet.
fn fresh(place: Option<EyePlace>, prepared: &Prepared) -> EyeMemory {
    EyeMemory::new(place, &prepared.settings, &prepared.layout)
}
