//! Mistakes in PLY files.

use std::io;

/// Mistake in a file: the end of a sentence, and the line if the file is text.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    pub line: Option<usize>,
    pub message: String,
}

impl Fault {
    /// Creates a fault of the whole file.
    pub fn whole(message: impl Into<String>) -> Self {
        Self { line: None, message: message.into() }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Self::whole(match error.kind() {
            io::ErrorKind::UnexpectedEof => String::from(
                "the PLY file is cut off: it ends before its last value; copy or export it again",
            ),
            _ => format!("the PLY file cannot be read: {error}"),
        })
    }
}
