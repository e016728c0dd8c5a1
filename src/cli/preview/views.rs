//! Views of cameras that the page moves: coarse ones soon, and full ones when there is time.

use std::sync::Arc;

use super::board::{Detail, View};
use crate::cli::coarse::smaller;
use crate::film::Film;
use crate::frame::{self, Aside, RenderError, Renderer};
use crate::memory;
use crate::scene::Shot;
use crate::settings::Settings;
use crate::trace::BackendKind;

/// Divisors of the sides of pictures; 1: the full picture.
const DIVISORS: [u32; 4] = [1, 2, 4, 8];
/// Maximum number of samples of the first coarse picture.
const FIRST_SAMPLES: u64 = 20_000;
/// A coarse picture that takes longer, in seconds, is made coarser; one that takes less is made finer.
const TOO_LONG: f64 = 0.4;
const SHORT: f64 = 0.05;

/// Renders views of a shot by free cameras.
pub struct Views<'s> {
    shot: &'s Shot,
    settings: Settings,
    /// One size for each of the [`DIVISORS`], once it is asked for: each continues with its own samples.
    sizes: [Option<Size<'s>>; DIVISORS.len()],
    /// Index of the coarse size.
    coarse: usize,
}

struct Size<'s> {
    beside: Aside<'s>,
    /// The frame rendered last.
    last: Option<i32>,
}

impl<'s> Views<'s> {
    /// Creates views of `shot`, with the `settings` of its frames.
    pub fn new(shot: &'s Shot, settings: &Settings) -> Self {
        let settings = Settings { exposures: Some(1), shutter: None, ..settings.clone() };
        let is_quick = |divisor: &u32| smaller(&settings, *divisor).data_window().pixels() <= FIRST_SAMPLES;
        let first = DIVISORS[1..].iter().position(is_quick).map_or(DIVISORS.len() - 1, |place| place + 1);
        Self { shot, settings, sizes: [const { None }; DIVISORS.len()], coarse: first }
    }

    /// Renders `view`; nothing if that was stopped.
    ///
    /// # Errors There is not enough memory for it, or the tracer failed.
    pub fn render(&mut self, renderer: &mut Renderer<'s>, view: &View) -> Result<Option<Arc<Film>>, String> {
        let place = match view.detail {
            Detail::Full => 0,
            Detail::Coarse => self.coarse,
        };
        if self.sizes[place].is_none() {
            self.sizes[place] = Some(Size { beside: self.beside(DIVISORS[place])?, last: None });
        }
        let Some(Size { beside, last }) = &mut self.sizes[place] else { return Err(String::from("no room")) };
        let cuts = &self.shot.scene.camera.cuts;
        let reuse = last.is_some_and(|last| !is_cut(cuts, last, view.frame));
        let finished = renderer.render_aside(beside, Some(&view.camera), view.frame, reuse);
        let finished = match finished {
            Err(RenderError::Stopped) => return Ok(None),
            finished => finished.map_err(|error| format!("frame {}: {error}", view.frame))?,
        };
        *last = Some(view.frame);
        if view.detail == Detail::Coarse {
            self.coarse = next_coarse(place, finished.stats.seconds.total);
        }
        Ok(Some(finished.film))
    }

    fn beside(&self, divisor: u32) -> Result<Aside<'s>, String> {
        let settings = if divisor == 1 { self.settings.clone() } else { smaller(&self.settings, divisor) };
        let threads = rayon::current_num_threads();
        let need = frame::need_of_aside(self.shot, &settings, BackendKind::default(), threads);
        need.check(&memory::left()).map_err(|error| error.to_string())?;
        Ok(Aside::new(&self.shot.scene, &settings))
    }
}

/// Chooses the index of the next coarse divisor, after a picture with divisor `place` that took `seconds`.
fn next_coarse(place: usize, seconds: f64) -> usize {
    if seconds > TOO_LONG {
        (place + 1).min(DIVISORS.len() - 1)
    } else if seconds < SHORT {
        (place - 1).max(1)
    } else {
        place
    }
}

/// Returns true if the shot cuts between two frames.
pub fn is_cut(cuts: &[i32], a: i32, b: i32) -> bool {
    cuts.iter().any(|cut| a.min(b) < *cut && *cut <= a.max(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_reused_across_a_cut_in_either_direction() {
        let is_cut = |a, b| is_cut(&[8], a, b);
        assert_eq!([is_cut(7, 8), is_cut(8, 7), is_cut(8, 9), is_cut(1, 7)], [true, true, false, false]);
    }

    #[test]
    fn coarse_pictures_are_as_coarse_as_they_must_be() {
        let slow = (0..5).fold(1, |place, _| next_coarse(place, 1.0));
        let fast = (0..5).fold(slow, |place, _| next_coarse(place, 0.01));
        assert_eq!((slow, fast, next_coarse(2, 0.2)), (3, 1, 2));
    }
}
