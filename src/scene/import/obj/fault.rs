//! Finds the place of an error in a text that is known to be wrong: line by line, on one thread.

use super::lines::{Lines, split_keyword, words};
use super::number::parsed;
use super::statement::{self, Corner, shown};
use crate::scene::import::faces::LARGEST_COORDINATE;
use crate::scene::import::faces::run::MOST_CORNERS;

/// Numbers of `v`, `vt` and `vn` statements.
type Counts = [u64; 3];

/// An error in the text.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fault {
    /// Line, from 1; 0 for the text as a whole.
    pub line: usize,
    /// Description of the error, and of what to do.
    pub message: String,
}

impl Fault {
    /// Creates a fault of the text as a whole.
    pub fn whole(message: impl Into<String>) -> Self {
        Self { line: 0, message: message.into() }
    }
}

/// Finds the first line of `text` that cannot be read. If there is none, finds the first that holds a
/// coordinate which cannot be used, or an index beyond what the text defines.
pub(super) fn find(text: &[u8]) -> Option<Fault> {
    let counts = match look(text, None) {
        Ok(counts) => counts,
        Err(fault) => return Some(fault),
    };
    look(text, Some(counts)).err()
}

/// Goes through the lines, and counts their definitions. With the counts of an earlier pass, checks values
/// too.
fn look(text: &[u8], checked_against: Option<Counts>) -> Result<Counts, Fault> {
    let mut counts = [0; 3];
    for (line, content) in Lines::new(text) {
        check(&content, &mut counts, checked_against).map_err(|message| Fault { line, message })?;
    }
    Ok(counts)
}

fn check(line: &[u8], counts: &mut Counts, against: Option<Counts>) -> Result<(), String> {
    let (keyword, rest) = split_keyword(line);
    match keyword {
        b"v" => {
            counts[0] += 1;
            statement::three("v", rest)?;
            if against.is_some() {
                check_coordinates(rest)?;
            }
        }
        b"vt" => {
            counts[1] += 1;
            statement::texture_coordinate(rest)?;
        }
        b"vn" => {
            counts[2] += 1;
            statement::three("vn", rest)?;
        }
        b"f" => {
            let mut corners = 0;
            for word in words(rest) {
                check_corner(statement::corner(word)?, word, counts, against)?;
                corners += 1;
            }
            if corners > MOST_CORNERS {
                return Err(statement::too_many_corners(corners));
            }
        }
        _ => {}
    }
    Ok(())
}

fn check_coordinates(rest: &[u8]) -> Result<(), String> {
    for word in words(rest).take(3) {
        if parsed(word).is_none_or(|value| value.is_nan() || value.abs() > LARGEST_COORDINATE) {
            let word = String::from_utf8_lossy(word);
            return Err(format!(
                "a vertex coordinate is `{word}`: it must be a finite number within ±{LARGEST_COORDINATE:e}; \
                 export the model again"
            ));
        }
    }
    Ok(())
}

fn check_corner(corner: Corner, word: &[u8], defined: &Counts, all: Option<Counts>) -> Result<(), String> {
    let whats = ["vertex", "texture coordinate", "normal"];
    for (part, (index, what)) in corner.into_iter().zip(whats).enumerate() {
        let before = defined[part];
        let absolute = if index >= 0 { index } else { before as i64 + 1 + index };
        if absolute < 0 || (absolute == 0 && index != 0) {
            return Err(format!(
                "`{}` counts back beyond the first {what}: {before} are defined here",
                shown(word)
            ));
        }
        // texture coordinates and normals are not checked if the file has none at all
        let count = all.map(|counts| counts[part]).filter(|count| part == 0 || *count > 0);
        if let Some(count) = count.filter(|count| absolute as u64 > *count) {
            return Err(format!(
                "`{}` asks for {what} {absolute} of {count}: the file is cut off or its indices are wrong",
                shown(word)
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_name_the_line() {
        for (text, line, words) in [
            ("v 0 0 0\n\nf 1 2 x", 3, "no corner"),
            ("f 0 1 2", 1, "count from 1"),
            ("v 0 0 0\nf -2 -1 -1", 2, "counts back"),
            ("v 0 0 0\nf -0 1 1", 2, "counts back"),
            ("v 0 0 0\nf 1 \\\n -2 1", 2, "counts back"),
            ("v 0 0 0\nv 0 nan 0\nf 1 2 9", 2, "`nan`"),
            ("v 0 0 0\nv 0 1 0\nf 1 2 9", 3, "vertex 9 of 2"),
            ("v 0 0 0\nvt 0 0\nf 1/7 1/7 1/7", 3, "coordinate 7 of 1"),
        ] {
            let fault = find(text.as_bytes()).unwrap_or(Fault::whole("none"));
            assert!(fault.line == line && fault.message.contains(words), "{text}: {fault:?}");
        }
        assert_eq!(find(b"v 0 0 0\nf 1/7 1/7 1/7"), None);
        let many = format!("v 0 0 0\nf{}", " 1".repeat(MOST_CORNERS + 1));
        assert!(find(many.as_bytes()).is_some_and(|fault| fault.message.contains("20001 corners")));
    }
}
