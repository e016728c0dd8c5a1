//! What can be wrong with a shot or its files: each message names the file, the line, and what to do.

use std::path::PathBuf;

/// Ends the load. The text says which file, where in it, what is wrong and what to do.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneError {
    /// The file at fault.
    pub path: PathBuf,
    /// From 1, where known.
    pub line: Option<usize>,
    /// From 1, where known.
    pub column: Option<usize>,
    /// What is wrong, and what to do.
    pub message: String,
}

/// Something that the picture shows a stand-in for.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning(pub SceneError);
