//! Names of output files: `out/shot.####.exr`, `out/shot.%04d.exr`, or a bare folder.

use std::fmt;
use std::path::{MAIN_SEPARATOR, Path, PathBuf};

/// Number of digits of a frame number if it is not given.
const USUAL_DIGITS: usize = 4;

/// A folder and a file name with one place for the frame number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputPattern {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

/// Reason why a text is no pattern. Its text says what to write instead.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PatternError {
    /// Two places for the frame number, in this name.
    TwoGroups(String),
    /// A place for the frame number in the name of a folder.
    GroupInFolder(String),
    /// A `%` that is not `%d` or `%04d`, in this name.
    UnknownFormat(String),
    /// More digits than a frame number can have, in this name.
    TooWide(String),
}

impl OutputPattern {
    /// Reads what stands after `-o`. `shot` names the files where only a folder is given, and
    /// `extension` (without dot) is appended where the name has none.
    ///
    /// `#` is one digit each, `%04d` is four with zeros in front, `%d` as many as it takes. A folder
    /// (it exists, or ends with a separator) gets `shot.####.extension`; a name without a place for
    /// the number gets `.####` before its extension.
    ///
    /// # Errors
    /// Two places for the number, one in a folder's name, or a `%` that means nothing.
    ///
    /// ```
    /// use afterimage::output::OutputPattern;
    /// let pattern = OutputPattern::parse("out/walk.####.exr", "walk", "exr").unwrap();
    /// assert_eq!(pattern.at(7).to_str(), Some("out/walk.0007.exr"));
    /// ```
    pub fn parse(text: &str, shot: &str, extension: &str) -> Result<Self, PatternError> {
        let path = Path::new(text);
        if text.is_empty() || is_folder(text) {
            return Ok(Self::in_folder(path, shot, extension));
        }
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        if folder.to_string_lossy().contains('#') {
            return Err(PatternError::GroupInFolder(text.to_owned()));
        }
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        let Some(name) = name else {
            return Ok(Self::in_folder(path, shot, extension));
        };
        let (before, group, mut after) = split_at_group(&name)?;
        let Some(digits) = group else {
            return Ok(Self::without_group(folder, &name, extension));
        };
        if Path::new(&format!("x{after}")).extension().is_none() {
            after = format!("{after}.{extension}");
        }
        Ok(Self { folder, before, digits, after })
    }

    /// Reads the name of a file that exists, whose last group of digits is a frame's number. `None` if its name has none.
    #[must_use]
    pub fn of_file(path: &Path) -> Option<(Self, i32)> {
        let name = path.file_name()?.to_str()?;
        let (stem, extension) = name.rsplit_once('.')?;
        let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
        let digits = stem[..end].bytes().rev().take_while(u8::is_ascii_digit).count();
        let (before, after) = (&stem[..end - digits], format!("{}.{extension}", &stem[end..]));
        // a sign follows a separator: in `a-0001` it is one itself
        let before = match before.strip_suffix('-') {
            Some(rest) if rest.is_empty() || rest.ends_with(['.', '_', '-']) => rest,
            _ => before,
        };
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let pattern = Self { folder, before: before.to_owned(), digits, after };
        let frame = pattern.frame_of(name)?;
        Some((pattern, frame))
    }

    /// The same names with fewer digits where a number needs no more.
    #[must_use]
    pub fn with_digits_of(&self, other: &Self) -> Self {
        Self { digits: self.digits.min(other.digits), ..self.clone() }
    }

    fn in_folder(folder: &Path, shot: &str, extension: &str) -> Self {
        let (before, after) = (format!("{shot}."), format!(".{extension}"));
        Self { folder: folder.to_owned(), before, digits: USUAL_DIGITS, after }
    }

    fn without_group(folder: PathBuf, name: &str, extension: &str) -> Self {
        let (stem, extension) = match name.rsplit_once('.') {
            Some((stem, own)) if !stem.is_empty() && !own.is_empty() => (stem, own),
            _ => (name.trim_end_matches('.'), extension),
        };
        Self::in_folder(&folder, stem, extension)
    }

    /// File of that frame. A number with more digits than the pattern has keeps them all; a minus sign stands
    /// before the digits and is none of them: frame -3 of `####` is `-0003`.
    #[must_use]
    pub fn at(&self, frame: i32) -> PathBuf {
        self.folder.join(self.name(frame))
    }

    fn name(&self, frame: i32) -> String {
        let sign = if frame < 0 { "-" } else { "" };
        let (before, after, digits) = (&self.before, &self.after, self.digits);
        format!("{before}{sign}{:0digits$}{after}", frame.unsigned_abs())
    }

    /// Frame whose file has this name in the folder.
    #[must_use]
    pub fn frame_of(&self, name: &str) -> Option<i32> {
        let number = name.strip_prefix(&self.before)?.strip_suffix(&self.after)?;
        number.parse().ok().filter(|frame| self.name(*frame) == name)
    }

    /// Replaces the extension (without dot): for previews and reports beside frames.
    #[must_use]
    pub fn with_extension(&self, extension: &str) -> Self {
        let stem = self.after.rsplit_once('.').map_or(self.after.as_str(), |(stem, _)| stem);
        Self { after: format!("{stem}.{extension}"), ..self.clone() }
    }

    /// Names of one of several views: `walk.left.####.png`, and `walk_left_####.png` if the pattern has no
    /// dot.
    #[must_use]
    pub fn of_view(&self, view: &str) -> Self {
        let before = match split_separator(&self.before) {
            Some((name, separator)) => format!("{name}{separator}{view}{separator}"),
            None if self.before.is_empty() => format!("{view}."),
            None => format!("{}.{view}.", self.before),
        };
        Self { before, ..self.clone() }
    }

    /// Folder of all files; empty for the current one.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}

/// Splits off the last character of a name, if it is a separator.
fn split_separator(name: &str) -> Option<(&str, char)> {
    let separator = name.chars().next_back().filter(|last| "._-".contains(*last))?;
    Some((&name[..name.len() - separator.len_utf8()], separator))
}

fn is_folder(text: &str) -> bool {
    text.ends_with(MAIN_SEPARATOR) || text.ends_with('/') || Path::new(text).is_dir()
}

/// Splits a name: the text before the number, its digits if there is a number, and the text after it.
fn split_at_group(name: &str) -> Result<(String, Option<usize>, String), PatternError> {
    let Some(start) = name.find(['#', '%']) else {
        return Ok((name.into(), None, String::new()));
    };
    let (before, rest) = name.split_at(start);
    let (digits, length) = if rest.starts_with('#') {
        let count = rest.bytes().take_while(|&byte| byte == b'#').count();
        (count, count)
    } else {
        percent_group(rest).ok_or_else(|| PatternError::UnknownFormat(name.to_owned()))?
    };
    let after = &rest[length..];
    if digits > 32 {
        return Err(PatternError::TooWide(name.to_owned()));
    }
    if after.contains(['#', '%']) {
        return Err(PatternError::TwoGroups(name.to_owned()));
    }
    Ok((before.to_owned(), Some(digits), after.to_owned()))
}

/// Number of digits, and of bytes of the group, of a text that begins with `%d` or `%04d`.
fn percent_group(text: &str) -> Option<(usize, usize)> {
    let inner = text.strip_prefix('%')?;
    let width = inner.bytes().take_while(u8::is_ascii_digit).count();
    if inner.as_bytes().get(width) != Some(&b'd') {
        return None;
    }
    let number = &inner[..width];
    let padded = number.is_empty() || number.starts_with('0');
    let digits = if number.is_empty() { 1 } else { number.parse().ok()? };
    padded.then_some((digits, width + 2)) // `%4d` would put spaces into names
}

/// Writes the pattern with `#` for each digit.
impl fmt::Display for OutputPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = format!("{}{}{}", self.before, "#".repeat(self.digits), self.after);
        write!(f, "{}", self.folder.join(name).display())
    }
}

impl fmt::Display for PatternError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TwoGroups(name) => {
                write!(f, "{name}: two places for the frame number; keep one, such as ####")
            }
            Self::GroupInFolder(name) => {
                write!(f, "{name}: # stands in a folder's name; put it into the file's name")
            }
            Self::UnknownFormat(name) => {
                write!(f, "{name}: after % only d or a padded width such as 04d may stand; use ####")
            }
            Self::TooWide(name) => write!(f, "{name}: that many digits; use ####"),
        }
    }
}

impl std::error::Error for PatternError {}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

    use super::*;

    fn at(text: &str, frame: i32) -> String {
        let pattern = OutputPattern::parse(text, "walk", "exr").unwrap();
        pattern.at(frame).to_str().unwrap().to_owned()
    }

    #[test]
    fn hashes_are_digits() {
        assert_eq!(at("out/a.####.exr", 7), "out/a.0007.exr");
        assert_eq!(at("a#.exr", 7), "a7.exr");
        assert_eq!(at("a.##.exr", 12345), "a.12345.exr");
        assert_eq!(at("###", 7), "007.exr");
    }

    #[test]
    fn percent_groups_work() {
        assert_eq!(at("out/a.%04d.exr", 7), "out/a.0007.exr");
        assert_eq!(at("a_%d.exr", 17), "a_17.exr");
        assert_eq!(at("a_%06d_b.exr", 17), "a_000017_b.exr");
    }

    #[test]
    fn a_minus_sign_is_no_digit() {
        assert_eq!(at("a.####.exr", -3), "a.-0003.exr");
        assert_eq!(at("a.####.exr", i32::MIN), "a.-2147483648.exr");
    }

    #[test]
    fn what_is_missing_is_added() {
        assert_eq!(at("out/", 1), "out/walk.0001.exr");
        assert_eq!(at("", 1), "walk.0001.exr");
        assert_eq!(at(".", 1), "./walk.0001.exr");
        assert_eq!(at("out/a.exr", 1), "out/a.0001.exr");
        assert_eq!(at("out/a", 1), "out/a.0001.exr");
        assert_eq!(at("out/a.v2.exr", 1), "out/a.v2.0001.exr");
        assert_eq!(at("out/a.####", 1), "out/a.0001.exr");
        let folder = tempfile::tempdir().unwrap();
        let name = folder.path().to_str().unwrap();
        assert_eq!(at(name, 1), format!("{name}/walk.0001.exr"));
    }

    #[test]
    fn what_means_nothing_is_refused() {
        let fault = |text| OutputPattern::parse(text, "walk", "exr").unwrap_err();
        assert!(matches!(fault("a.##.##.exr"), PatternError::TwoGroups(_)));
        assert!(matches!(fault("a.##.%04d.exr"), PatternError::TwoGroups(_)));
        assert!(matches!(fault("a##/b.exr"), PatternError::GroupInFolder(_)));
        assert!(matches!(fault("a.%s.exr"), PatternError::UnknownFormat(_)));
        assert!(matches!(fault("a.%4d.exr"), PatternError::UnknownFormat(_)));
        assert!(matches!(fault("a.%"), PatternError::UnknownFormat(_)));
        assert!(matches!(fault("a.%099d.exr"), PatternError::TooWide(_)));
        assert!(fault("a.##.##.exr").to_string().contains("keep one"));
    }

    #[test]
    fn names_lead_back_to_frames() {
        let pattern = OutputPattern::parse("out/a.####.exr", "walk", "exr").unwrap();
        for frame in [0, 7, 12345, -3, i32::MIN] {
            assert_eq!(pattern.frame_of(&pattern.name(frame)), Some(frame));
        }
        for name in ["a.7.exr", "a.+007.exr", "a.00007.exr", "a.0007.png", "b.0007.exr", "a..exr", "a.exr"] {
            assert_eq!(pattern.frame_of(name), None, "{name}");
        }
    }

    #[test]
    fn names_of_files_become_patterns() {
        for (file, text, frame) in [
            ("out/a.0007.exr", "out/a.####.exr", 7),
            ("a_12.exr", "a_##.exr", 12),
            ("a2_000017_b.exr", "a2_######_b.exr", 17),
            ("a.-0003.exr", "a.####.exr", -3),
            ("a-0003.exr", "a-####.exr", 3),
            ("7.exr", "#.exr", 7),
        ] {
            let (pattern, found) = OutputPattern::of_file(Path::new(file)).unwrap();
            assert_eq!((pattern.to_string().as_str(), found), (text, frame));
        }
        for file in ["a.exr", "a", "a.99999999999.exr", ""] {
            assert_eq!(OutputPattern::of_file(Path::new(file)), None, "{file}");
        }
    }

    #[test]
    fn previews_lie_beside_frames() {
        let pattern = OutputPattern::parse("out/a.####.exr", "walk", "exr").unwrap();
        assert_eq!(pattern.with_extension("png").at(5), Path::new("out/a.0005.png"));
        assert_eq!(pattern.folder(), Path::new("out"));
    }
}
