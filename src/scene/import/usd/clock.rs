//! Frames and time codes.

/// Frames of a file. Frame and time code are the same where a second has as many of both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Frames in a second.
    pub rate: f64,
    /// Time codes from frame to frame.
    pub codes: f64,
    /// First and last frame, if the file says.
    pub range: Option<[f64; 2]>,
    /// First and last time code of which values are read; none: those of all are.
    pub read: Option<[f64; 2]>,
}

impl Default for Clock {
    fn default() -> Self {
        Self { rate: 24.0, codes: 1.0, range: None, read: None }
    }
}

impl Clock {
    /// Frame of a time code.
    pub fn frame(&self, code: f64) -> f64 {
        code / self.codes
    }

    /// Time code of a frame.
    pub fn code(&self, frame: f64) -> f64 {
        frame * self.codes
    }

    /// Frame at which what rests is read.
    pub fn first(&self) -> f64 {
        self.range.map_or(1.0, |[first, _]| first)
    }
}
