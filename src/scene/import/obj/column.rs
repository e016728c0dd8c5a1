//! Indices of one attribute (position, texture coordinate or normal) for all corners of a piece.

use crate::scene::import::faces::run::Indices;

/// Maximum number of entries of one attribute in a file: indices have 32 bits and a sign.
pub(super) const MOST_ENTRIES: u64 = i32::MAX as u64;

/// Indices from 1, 0 for absent. Relative ones, which count back, stay relative to the beginning of their
/// piece until it is known how many entries the pieces before define.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Column {
    /// Indices, one a corner; empty if all are absent so far. Relative ones are `i32` in disguise.
    values: Vec<u32>,
    /// Corners at which indices become relative, absolute again, and so on.
    turns: Vec<u32>,
    /// True if it has the same values as the positions' column, and does not keep them.
    is_as_positions: bool,
    /// Highest absolute index.
    highest: u32,
}

/// Error: an index points beyond the existing entries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OutOfRange;

impl Column {
    /// Empties the column, and keeps its memory.
    pub fn clear(&mut self) {
        self.values.clear();
        self.turns.clear();
        self.highest = 0;
    }

    /// Copies `other` into this column.
    pub fn copy(&mut self, other: &Self) {
        self.values.clone_from(&other.values);
        self.turns.clone_from(&other.turns);
        self.highest = other.highest;
    }

    /// Column of another kind whose indices equal these of the positions. None of them may count back.
    pub fn as_positions(&self) -> Self {
        Self { is_as_positions: true, highest: self.highest, ..Self::default() }
    }

    /// Copies the content without spare memory, and without values if they equal those of `positions`.
    pub fn packed(&self, positions: Option<&Self>) -> Self {
        // relative ones may become different
        let is_same = |positions: &Self| self.turns.is_empty() && self == positions;
        if positions.is_some_and(is_same) {
            return self.as_positions();
        }
        Self { values: self.values.as_slice().to_vec(), turns: self.turns.clone(), ..*self }
    }

    /// Adds indices for the corners from number `corner` on; negative ones count back from the last of
    /// `defined` entries of this piece. 0 is for absent ones.
    #[inline(always)]
    pub fn append<const N: usize>(&mut self, corner: usize, indices: [i32; N], defined: usize) {
        if self.values.len() == corner && self.turns.len() % 2 == 0 && indices.iter().all(|index| *index > 0)
        {
            let indices = indices.map(|index| index as u32);
            self.values.extend_from_slice(&indices);
            self.highest = indices.iter().fold(self.highest, |highest, index| highest.max(*index));
        } else {
            self.append_any(corner, &indices, defined);
        }
    }

    #[inline(never)]
    fn append_any(&mut self, corner: usize, indices: &[i32], defined: usize) {
        if self.values.len() < corner {
            self.turn(false);
            self.values.resize(corner, 0);
        }
        for index in indices {
            self.turn(*index < 0);
            // pieces do not define as much as to overflow this
            let value = if *index < 0 { defined as i32 + 1 + index } else { *index };
            self.values.push(value as u32); // the sign of relative ones comes back in `resolve`
            self.highest = self.highest.max(*index.max(&0) as u32);
        }
    }

    /// Notes whether the next index is relative or absolute.
    #[inline(always)]
    fn turn(&mut self, relative: bool) {
        if relative != (self.turns.len() % 2 == 1) {
            self.turns.push(self.values.len() as u32);
        }
    }

    /// Resolves the indices of `corners` corners into absolute ones, none above `count`; `before` entries are
    /// defined in the pieces before this one. If there are no entries at all, all indices are absent.
    /// Positions are resolved first, and passed as `positions` for the other attributes.
    pub fn resolve(
        self,
        before: u64,
        count: u64,
        corners: usize,
        positions: &[u32],
    ) -> Result<Indices, OutOfRange> {
        let Self { mut values, turns, is_as_positions, highest } = self;
        if count == 0 || (values.is_empty() && !is_as_positions) {
            return Ok(Indices::Absent);
        }
        if u64::from(highest) > count {
            return Err(OutOfRange);
        }
        if is_as_positions {
            return Ok(Indices::AsPositions);
        }
        let mut begin = 0;
        let ends = turns.iter().map(|turn| *turn as usize).chain([values.len()]);
        for (run, end) in ends.enumerate() {
            let indices = &mut values[begin..end];
            if run % 2 == 1 {
                to_absolute(indices, before)?;
                check(indices, count)?;
            }
            begin = end;
        }
        values.resize(corners, 0);
        Ok(if values == positions { Indices::AsPositions } else { Indices::Own(values) })
    }
}

fn check(indices: &[u32], count: u64) -> Result<(), OutOfRange> {
    let highest = indices.iter().fold(0, |highest, index| highest.max(*index));
    if u64::from(highest) > count { Err(OutOfRange) } else { Ok(()) }
}

fn to_absolute(indices: &mut [u32], before: u64) -> Result<(), OutOfRange> {
    for index in indices {
        let absolute = i64::from(*index as i32) + before as i64;
        *index = u32::try_from(absolute).ok().filter(|index| *index > 0).ok_or(OutOfRange)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolved(column: &Column, before: u64, count: u64, corners: usize) -> Result<Indices, OutOfRange> {
        column.packed(None).resolve(before, count, corners, &[])
    }

    #[test]
    fn relative_indices_become_absolute() {
        let mut column = Column::default();
        column.append(0, [3, 4], 0);
        column.append(2, [-1, -5], 2);
        column.append(4, [7], 2);
        assert_eq!(resolved(&column, 10, 12, 6), Ok(Indices::Own(vec![3, 4, 12, 8, 7, 0])));
        assert_eq!(resolved(&column, 10, 11, 6), Err(OutOfRange));
        assert_eq!(resolved(&column, 2, 12, 6), Err(OutOfRange), "back beyond the first");
    }

    #[test]
    fn what_is_absent_takes_no_memory() {
        let mut column = Column::default();
        assert_eq!(resolved(&column, 0, 5, 9), Ok(Indices::Absent));
        column.append(2, [1], 0);
        assert_eq!(resolved(&column, 0, 0, 3), Ok(Indices::Absent), "there is none in the file");
        assert_eq!(resolved(&column, 0, 5, 4), Ok(Indices::Own(vec![0, 0, 1, 0])));
        column.append(3, [-1], 2);
        column.append(5, [-1], 2);
        assert_eq!(resolved(&column, 3, 5, 7), Ok(Indices::Own(vec![0, 0, 1, 5, 0, 5, 0])));
    }

    #[test]
    fn what_is_as_the_positions_is_seen() {
        let (mut absolute, mut relative) = (Column::default(), Column::default());
        absolute.append(0, [3, 4], 0);
        relative.append(0, [-2, -1], 2);
        let packed = absolute.packed(Some(&absolute));
        assert!(packed.values.is_empty());
        assert_eq!(packed.clone().resolve(9, 4, 2, &[3, 4]), Ok(Indices::AsPositions));
        assert_eq!(packed.resolve(9, 3, 2, &[3, 4]), Err(OutOfRange));
        let packed = relative.packed(Some(&relative));
        assert_eq!(packed.clone().resolve(2, 4, 2, &[3, 4]), Ok(Indices::AsPositions));
        assert_eq!(packed.resolve(1, 4, 2, &[3, 4]), Ok(Indices::Own(vec![2, 3])));
    }
}
