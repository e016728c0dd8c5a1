//! Frames of a shot to render: `1-100x2,150`.

use std::fmt;

/// Maximum number of frames that a range may name: at 24 a second, eleven hours.
pub const MOST_FRAMES: u64 = 1_000_000;

/// Frames from `first` to `last`, both included where `step` meets them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Run {
    /// First frame of the run.
    pub first: i32,
    /// Last frame of the run, never below `first`.
    pub last: i32,
    /// Distance from frame to frame, at least 1.
    pub step: u32,
}

/// Requested frames. Never empty, at most [`MOST_FRAMES`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frames {
    runs: Vec<Run>,
}

impl Run {
    /// Number of frames in the run.
    pub fn count(&self) -> u64 {
        (i64::from(self.last) - i64::from(self.first)) as u64 / u64::from(self.step) + 1
    }

    fn frames(self) -> impl Iterator<Item = i32> {
        (self.first..=self.last).step_by(self.step as usize)
    }
}

impl Frames {
    /// Reads runs between commas: `FRAME`, `FIRST-LAST` or `FIRST:LAST`, each with `xSTEP` if wanted.
    /// Frames may be negative: `-10--1` is `-10:-1`.
    ///
    /// # Errors
    /// The part that is wrong, and what to write.
    pub fn parse(text: &str) -> Result<Self, FramesError> {
        let mut runs = text.split(',').map(|part| run(part.trim())).collect::<Result<Vec<_>, _>>()?;
        runs.sort();
        let total: u64 = runs.iter().map(Run::count).sum();
        if total > MOST_FRAMES {
            return Err(FramesError::TooMany { text: text.into(), total });
        }
        Ok(Self { runs })
    }

    /// Creates the frames from `first` to `last`.
    ///
    /// # Panics
    /// Where `last` is before `first`.
    pub fn between(first: i32, last: i32) -> Self {
        assert!(first <= last, "a range ends before it begins");
        Self { runs: vec![Run { first, last, step: 1 }] }
    }

    /// Creates the frames of `runs`.
    ///
    /// # Panics
    /// Where there are none.
    pub fn of_runs(runs: &[Run]) -> Self {
        assert!(!runs.is_empty(), "some frames are needed");
        let mut runs = runs.to_vec();
        runs.sort();
        Self { runs }
    }

    /// Runs in rising order of their first frame; they may overlap.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Every frame once, in rising order.
    pub fn list(&self) -> Vec<i32> {
        let mut frames: Vec<i32> = self.runs.iter().flat_map(|run| run.frames()).collect();
        frames.sort_unstable();
        frames.dedup();
        frames
    }

    /// The latest frame.
    pub fn last(&self) -> i32 {
        self.runs.iter().fold(i32::MIN, |last, run| last.max(run.last))
    }

    /// The earliest frame.
    pub fn first(&self) -> i32 {
        self.runs[0].first
    }

    /// The earliest and the latest frame.
    pub fn ends(&self) -> [i32; 2] {
        [self.first(), self.last()]
    }
}

/// Writes the frames as [`Frames::parse`] reads them.
impl fmt::Display for Frames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, run) in self.runs.iter().enumerate() {
            let comma = if i == 0 { "" } else { "," };
            match run {
                Run { first, last, .. } if first == last => write!(f, "{comma}{first}")?,
                Run { first, last, step: 1 } => write!(f, "{comma}{first}-{last}")?,
                Run { first, last, step } => write!(f, "{comma}{first}-{last}x{step}")?,
            }
        }
        Ok(())
    }
}

/// Text that names no frames.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum FramesError {
    /// A part between commas is empty.
    EmptyPart,
    /// The step of a part is no whole number above 0.
    Step {
        /// The part between commas.
        part: String,
    },
    /// A word of a part is no frame's number.
    Number {
        /// The part between commas.
        part: String,
        /// The word in it.
        word: String,
    },
    /// A part ends before it begins.
    Backwards {
        /// The part between commas.
        part: String,
        /// Its first number.
        first: i32,
        /// Its last number.
        last: i32,
    },
    /// More frames than a run renders.
    TooMany {
        /// All of the text.
        text: String,
        /// Number of frames that it names.
        total: u64,
    },
}

impl fmt::Display for FramesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const EXAMPLE: &str = "write frames like `1-100x2,150`";
        match self {
            Self::EmptyPart => write!(f, "a part of the frame range is empty: {EXAMPLE}"),
            Self::Step { part } => write!(f, "`{part}`: the step after `x` must be a whole number above 0"),
            Self::Number { part, word } => write!(f, "`{part}`: `{word}` is not a frame's number: {EXAMPLE}"),
            Self::Backwards { part, first, last } => write!(
                f,
                "`{part}` runs backwards: write `{last}-{first}`; frames are rendered in rising order"
            ),
            Self::TooMany { text, total } => {
                write!(f, "`{text}` names {total} frames: more than {MOST_FRAMES} are not rendered in a run")
            }
        }
    }
}

impl std::error::Error for FramesError {}

fn run(part: &str) -> Result<Run, FramesError> {
    let named = || String::from(part);
    if part.is_empty() {
        return Err(FramesError::EmptyPart);
    }
    let (range, step) = match part.split_once(['x', 'X']) {
        Some((range, step)) => (range.trim(), step.trim().parse().ok().filter(|step| *step > 0)),
        None => (part, Some(1)),
    };
    let step: u32 = step.ok_or_else(|| FramesError::Step { part: named() })?;
    // a minus sign at the front belongs to the number
    let separator = range.char_indices().skip(1).find(|(_, c)| matches!(c, '-' | ':')).map(|(i, _)| i);
    let number = |text: &str| {
        let word = text.trim();
        word.parse::<i32>().map_err(|_| FramesError::Number { part: named(), word: word.into() })
    };
    let (first, last) = match separator {
        Some(i) => (number(&range[..i])?, number(&range[i + 1..])?),
        None => (number(range)?, number(range)?),
    };
    if last < first {
        return Err(FramesError::Backwards { part: named(), first, last });
    }
    let beyond = (i64::from(last) - i64::from(first)) % i64::from(step);
    Ok(Run { first, last: (i64::from(last) - beyond) as i32, step })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    #[test]
    fn reads_runs_steps_and_single_frames() {
        let frames = Frames::parse(" 150, 1-10x4 , 5:6").unwrap();
        assert_eq!(frames.list(), [1, 5, 6, 9, 150]);
        assert_eq!(frames.runs()[0], Run { first: 1, last: 9, step: 4 });
        assert_eq!((frames.first(), frames.to_string().as_str()), (1, "1-9x4,5-6,150"));
    }

    #[test]
    fn reads_negative_frames() {
        for text in ["-3--1", "-3:-1", "-3 - -1", "-1,-2,-3,-2"] {
            assert_eq!(Frames::parse(text).unwrap().list(), [-3, -2, -1], "{text}");
        }
        assert_eq!(Frames::parse("-2-1x3").unwrap().list(), [-2, 1]);
    }

    #[test]
    fn reads_back_what_it_prints() {
        for text in ["1", "-5--1", "1-99x7,200", "1-9x4,5-6,150"] {
            let frames = Frames::parse(text).unwrap();
            assert_eq!(Frames::parse(&frames.to_string()).unwrap(), frames);
        }
    }

    #[test]
    fn refuses_what_makes_no_sense() {
        for (text, word) in [
            ("", "empty"),
            ("1,,2", "empty"),
            ("10-1", "runs backwards"),
            ("1-10x0", "step"),
            ("1-10x-2", "step"),
            ("one", "not a frame"),
            ("1-", "not a frame"),
            ("1.5", "not a frame"),
            ("99999999999", "not a frame"),
            ("1-2-3", "not a frame"),
            ("é-1", "not a frame"),
        ] {
            let message = Frames::parse(text).unwrap_err().to_string();
            assert!(message.contains(word), "{text}: {message}");
        }
    }

    #[test]
    fn refuses_absurdly_many() {
        let message = Frames::parse("-2147483648-2147483647").unwrap_err().to_string();
        assert!(message.contains("4294967296 frames"), "{message}");
        assert_eq!(Frames::parse("-2147483648-2147483647x4294967295").unwrap().list().len(), 2);
        assert!(Frames::parse("1-600000,1-600000").is_err());
    }
}
