//! `[[material]]` tables of shot files, as they are stated.

use std::path::PathBuf;

use crate::scene::import::mtl::statements::Statements;

/// A `[[material]]` of the shot file: values other than `None` replace those of the MTL file.
pub(crate) struct Override {
    pub values: Statements,
    /// MaterialX file whose material of the same name counts in place of that of the model's files.
    pub mtlx: Option<PathBuf>,
    /// The shot file, and the line and column of the entry in it.
    pub path: PathBuf,
    pub line: usize,
    pub column: usize,
    /// True if any model has a material of the name.
    pub used: bool,
}
