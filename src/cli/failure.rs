//! Reasons for an exit code other than 0.

use std::fmt;
use std::process::ExitCode;

use crate::schedule::steps::StepError;

/// The end of a run that did not do what was asked. The text is one line and says what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Failure {
    /// The command line makes no sense.
    Usage(String),
    /// The work could not be done.
    Failed(String),
    /// A signal of this number asked the program to stop.
    Stopped(u8, String),
}

impl Failure {
    /// Creates a failure from any error.
    pub fn of(error: impl fmt::Display) -> Self {
        Self::Failed(one_line(&error.to_string()))
    }

    /// Exit code: 1 for failed, 2 for usage, 128 and the signal's number for stopped, as shells have it.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Failed(_) => ExitCode::from(1),
            Self::Usage(_) => ExitCode::from(2),
            Self::Stopped(signal, _) => ExitCode::from(128 + (signal & 0x7f)),
        }
    }
}

impl From<StepError> for Failure {
    fn from(error: StepError) -> Self {
        Self::of(error)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(text) => write!(f, "{text} (see --help)"),
            Self::Failed(text) | Self::Stopped(_, text) => f.write_str(text),
        }
    }
}

/// Joins the lines of a message: libraries may write several, a log wants one.
pub fn one_line(text: &str) -> String {
    text.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_become_one_line() {
        assert_eq!(Failure::of("first\n  second\n\n").to_string(), "first; second");
        assert_eq!(Failure::Usage("no".into()).to_string(), "no (see --help)");
    }
}
