//! Reads the positions of OBJ files alone: shapes of a model whose faces are known.

use std::io;
use std::path::Path;

use super::join::concatenated;
use super::lines::{Lines, split_keyword};
use super::source::Source;
use super::{PIECE, faulty, look_for_fault, open, pieces, unreadable};
use crate::digest::Digest;
use crate::scene::SceneError;

/// Reads the positions (`v`) of the OBJ file at `path` in its order, and a digest of its text. They may be
/// not finite.
///
/// # Errors Where the file cannot be read, or has lines that make no sense (with their numbers).
pub fn read_positions(path: &Path) -> Result<(Vec<[f32; 3]>, Digest), SceneError> {
    let source = open(path)?;
    let (mut pieces, digest) = pieces(&source, PIECE).map_err(|error| unreadable(path, &error))?;
    if pieces.iter().any(|piece| piece.is_faulty) {
        let fault = look_for_fault(&source).map_err(|error| unreadable(path, &error))?;
        return Err(faulty(path, fault));
    }
    let positions = concatenated(pieces.iter_mut().map(|piece| std::mem::take(&mut piece.positions)));
    Ok((positions, digest))
}

/// Finds the line of position number `number`, from 0, in the OBJ file at `path`, if it is there.
pub fn line_of_position(path: &Path, number: usize) -> Option<usize> {
    let lines = |source: &Source<'_>| -> io::Result<Option<usize>> {
        let mut buffer = Vec::new();
        let text = source.read(0..source.len(), &mut buffer)?;
        let is_position = |line: &[u8]| split_keyword(line).0 == b"v";
        let mut positions = Lines::new(text).filter(|(_, line)| is_position(line));
        Ok(positions.nth(number).map(|(line, _)| line))
    };
    lines(&open(path).ok()?).ok().flatten()
}
