//! Errors and warnings of a shot and its files: each message names the file, the line, and what to do.

use std::fmt;
use std::path::PathBuf;

/// An error that ends the load. The text says which file, where in it, what is wrong and what to do.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneError {
    /// The file at fault.
    pub path: PathBuf,
    /// Line, from 1, if known.
    pub line: Option<usize>,
    /// Column, from 1, if known.
    pub column: Option<usize>,
    /// Description of the error, and of what to do.
    pub message: String,
}

/// A defect for which the picture shows a stand-in.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning(pub SceneError);

impl SceneError {
    /// Creates an error about a whole file.
    pub fn new(path: impl Into<PathBuf>, message: impl Into<String>) -> Self {
        Self { path: path.into(), line: None, column: None, message: message.into() }
    }

    /// Adds the line at fault (from 1).
    pub fn at_line(self, line: usize) -> Self {
        Self { line: Some(line), ..self }
    }

    /// Adds the line and the column at fault (both from 1).
    pub fn at(self, line: usize, column: usize) -> Self {
        Self { line: Some(line), column: Some(column), ..self }
    }
}

/// `path:line:column: message`, without the parts that are not known.
impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        for place in [self.line, self.column].into_iter().flatten() {
            write!(f, ":{place}")?;
        }
        write!(f, ": {}", self.message)
    }
}

impl std::error::Error for SceneError {}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Warnings collected by a load.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    /// True if a stand-in in the picture is an error.
    pub strict: bool,
    /// Warnings in the order of their discovery.
    pub warnings: Vec<Warning>,
}

impl Findings {
    /// Records that the picture will not be what the files ask for: an error in a strict load, otherwise a
    /// warning.
    pub fn stand_in(&mut self, finding: SceneError) -> Result<(), SceneError> {
        if self.strict {
            return Err(finding);
        }
        self.note(finding);
        Ok(())
    }

    /// Records a warning: the picture is as asked for, but the files are odd.
    pub fn note(&mut self, finding: SceneError) {
        self.warnings.push(Warning(finding));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_file_line_and_column_where_known() {
        let fault = SceneError::new("a/b.toml", "is odd");
        assert_eq!(fault.to_string(), "a/b.toml: is odd");
        assert_eq!(fault.clone().at_line(7).to_string(), "a/b.toml:7: is odd");
        assert_eq!(fault.at(7, 3).to_string(), "a/b.toml:7:3: is odd");
    }

    #[test]
    fn strict_turns_stand_ins_into_errors_but_not_notes() {
        let mut findings = Findings { strict: true, ..Findings::default() };
        findings.note(SceneError::new("x", "odd"));
        assert!(findings.stand_in(SceneError::new("x", "missing")).is_err());
        assert_eq!(findings.warnings.len(), 1);
    }
}
