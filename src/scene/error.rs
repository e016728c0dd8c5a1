//! What can be wrong with a shot or its files: each message names the file, the line, and what to do.

use std::fmt;
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

impl SceneError {
    /// About a whole file.
    pub fn new(path: impl Into<PathBuf>, message: impl Into<String>) -> Self {
        Self { path: path.into(), line: None, column: None, message: message.into() }
    }

    /// The same, with the line (from 1) at fault.
    pub fn at_line(self, line: usize) -> Self {
        Self { line: Some(line), ..self }
    }

    /// The same, with line and column (both from 1) at fault.
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

/// What a load has to say beside its result.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    /// Whether a stand-in in the picture is an error.
    pub strict: bool,
    /// In the order of their discovery.
    pub warnings: Vec<Warning>,
}

impl Findings {
    /// The picture will not be what the files ask for.
    pub fn stand_in(&mut self, finding: SceneError) -> Result<(), SceneError> {
        if self.strict {
            return Err(finding);
        }
        self.note(finding);
        Ok(())
    }

    /// The picture is as asked, but the files are odd.
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
