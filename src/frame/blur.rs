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
//! Where frames are inferred backwards in time, a frame's exposures come in the reverse order: the first one of the frame after is
//! nearest to the last one of this, so that steps stay as small as they are forwards. A base frame's come forwards in any case, from
//! the one that is traced: later frames go on from its last exposure in a small step. Earlier ones go on from the same
//! samples, so that there is one state to keep, and not two; their first exposure is a whole frame away then, as in a shot
//! without blur, and no other is.
//!
//! Two eyes expose a frame one after the other, and each goes on with its own samples. From the left eye's exposure at the same time
//! the right one would be further away than from its own exposure before; and the left eye has left that time when it is done.

use std::time::Instant;

use super::eyes::{EyeMemory, Source};
use super::film::mean::{Mean, Rule};
use super::picture::{self, Made, Order};
use super::planes::channels::Channel;
use super::render_error::RenderError;
use super::shot::prepared::Prepared;
use super::shot::reflection_maps::ReflectionMaps;
use super::snapshot::{Holds, Moment};
use super::turn;
use crate::changes::Direction;
use crate::exposure::Exposures;
use crate::film::Film;
use crate::pose::{CameraPose, Pose};
use crate::scene::Scene;
use crate::settings::{Filter, Mode, Settings};
use crate::stereo::{Eye, EyePlace};
use crate::trace::Backend;

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

/// A frame that is begun.
#[derive(Debug, Clone, Copy)]
pub struct Begun {
    frame: i32,
    /// In which its exposures are made.
    direction: Direction,
    /// Whether each of them keeps its samples in place.
    rests: bool,
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

    /// How many a frame has.
    pub fn exposures(&self) -> usize {
        self.exposures.all.len()
    }

    /// What is kept of each exposure of the frame rendered last, by number: nothing if that could not be finished.
    pub fn finished(&self) -> impl Iterator<Item = (usize, &EyeMemory)> {
        let memories = self.memories.iter().enumerate().filter(|_| self.frame.is_some());
        memories.filter_map(|(index, memory)| Some((index, memory.as_ref()?)))
    }

    /// Goes on from samples of `moment`, as if its frame were the one rendered last, once they are [`restored`](Self::restored).
    pub fn begin_restore(&mut self, moment: Moment) {
        self.forget();
        self.frame = Some(moment.frame);
        self.newest = match moment.holds {
            Holds::To(Direction::Backward) => 0,
            Holds::To(Direction::Forward) | Holds::Both => self.memories.len() - 1,
        };
    }

    /// Forgets all samples.
    pub fn forget(&mut self) {
        self.memories.iter_mut().for_each(|memory| *memory = None);
        self.frame = None;
    }

    /// Where samples of exposure `index` of `frame` are to be put, and where everything was when they were seen.
    pub fn restored(&mut self, prepared: &Prepared, frame: i32, index: usize) -> (&mut EyeMemory, Pose) {
        let pose = self.pose(prepared, frame, index);
        (self.memories[index].insert(fresh(self.place, prepared)), pose)
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

    /// Begins `frame`, which comes after any other one of the shot or before it. With `reuse` its exposures are made of the samples
    /// of the frame rendered last, if there was one; without it the first one is traced in full, and the others are made of its samples.
    pub fn begin(&mut self, prepared: &mut Prepared, frame: i32, reuse: bool) -> Begun {
        let is_full = prepared.settings.mode == Mode::Full;
        let last = self.frame.take().filter(|last| reuse && !is_full && *last != frame);
        if last.is_none() {
            self.forget();
        }
        let direction = match last {
            Some(last) if last > frame => Direction::Backward,
            _ => Direction::Forward,
        };
        let rests = !is_full && rests(&self.exposures, prepared.scene, frame, direction);
        if rests {
            prepared.look_ahead();
        }
        if direction == Direction::Backward || turn::has_two_sides(&prepared.settings) {
            prepared.look_back();
        }
        Begun { frame, direction, rests }
    }

    /// Makes all exposures of the frame that is `begun`, and gives each to `take`. `rendered`: frames so far, with this one.
    pub fn render(
        &mut self,
        prepared: &Prepared,
        (backend, maps): (&mut dyn Backend, &mut ReflectionMaps),
        begun: Begun,
        rendered: u32,
        mut take: impl FnMut(Made),
    ) -> Result<Film, RenderError> {
        let size = prepared.settings.data_window();
        let mut mean = Mean::new(&prepared.channels, [size.width, size.height]);
        let count = self.memories.len();
        for number in 0..count {
            let index = match begun.direction {
                Direction::Forward => number,
                Direction::Backward => count - 1 - number,
            };
            let made = self.expose(prepared, (&mut *backend, &mut *maps), (begun, index), rendered)?;
            mean.add(&made.film, &prepared.channels);
            take(made);
        }
        self.frame = Some(begun.frame);
        Ok(mean.finish(&prepared.channels))
    }

    /// Where everything is in exposure `index` of `frame`.
    fn pose(&self, prepared: &Prepared, frame: i32, index: usize) -> Pose {
        let settings = &prepared.settings;
        let cells = settings.levels().last().unwrap_or(settings.samples);
        let picture = ([settings.width, settings.height], cells);
        Pose::exposed(prepared.scene, frame, (&self.exposures, index), self.place.as_ref(), picture)
    }

    fn expose(
        &mut self,
        prepared: &Prepared,
        (backend, maps): (&mut dyn Backend, &mut ReflectionMaps),
        (Begun { frame, rests, .. }, index): (Begun, usize),
        rendered: u32,
    ) -> Result<Made, RenderError> {
        let start = Instant::now();
        let settings = &prepared.settings;
        let pose = self.pose(prepared, frame, index);
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
        let time = turn::direction(settings, memory, source.pose(), &pose);
        turn::turn(prepared, memory, source.pose(), time);
        let order = Order {
            pose: &pose,
            reuse: source.pose().is_some(),
            plan: source.plan(&pose),
            shown: source.pose().filter(|_| !is_lent),
            time,
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

/// Whether the camera is in one place for all of this frame and the one of the shot that comes next in that `direction`.
fn rests(exposures: &Exposures, scene: &Scene, frame: i32, direction: Direction) -> bool {
    let clock = &exposures.clock;
    let at = |moment| {
        let time = clock.time(moment);
        (CameraPose::of(&scene.camera, time), scene.camera.lens_at(time))
    };
    let next = match direction {
        Direction::Forward => frame.saturating_add(1),
        Direction::Backward => frame.saturating_sub(1),
    };
    let [first, last] = [clock.moment(frame.min(next), 0), clock.moment(frame.max(next), usize::MAX >> 1)];
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
    let both = [Direction::Forward, Direction::Backward];
    let directions = if turn::has_two_sides(settings) { &both[..] } else { &both[..1] };
    let rests = |frame| directions.iter().any(|direction| rests(&exposures, scene, frame, *direction));
    let mut rest = frames.enumerate().map(|(number, frame)| number >= MOST_FRAMES || rests(frame));
    if rest.any(|rests| rests) { exposures.all.len() } else { 1 }
}

/// Of an exposure that has no samples yet.
fn fresh(place: Option<EyePlace>, prepared: &Prepared) -> EyeMemory {
    EyeMemory::new(place, &prepared.settings, &prepared.layout)
}
