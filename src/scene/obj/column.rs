//! Indices of one kind (position, texture coordinate or normal) for all corners of a piece.

/// Most entries of one kind in a file: indices have 32 bits and a sign.
pub(super) const MOST_ENTRIES: u64 = i32::MAX as u64;

/// Indices from 1, 0 for absent. Those that count back are kept relative to the beginning of their
/// piece until it is known how much the pieces before define.
#[derive(Debug, Clone, Default)]
pub(super) struct Column {
    /// One a corner; none where all are absent so far. Relative ones are `i32` in disguise.
    values: Vec<u32>,
    /// Corners from which on indices are relative, and absolute again, and so on.
    turns: Vec<u32>,
}

/// An index points beyond what there is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OutOfRange;

impl Column {
    /// Empties it, and keeps its memory.
    pub fn clear(&mut self) {
        self.values.clear();
        self.turns.clear();
    }

    /// Its content, without spare memory.
    pub fn packed(&self) -> Self {
        Self { values: self.values.as_slice().to_vec(), turns: self.turns.clone() }
    }

    /// Adds indices for the corners from number `corner` on; negative ones count back from the last of
    /// `defined` entries of this piece. 0 is for absent ones.
    #[inline(always)]
    pub fn append(
        &mut self,
        corner: usize,
        indices: impl Iterator<Item = i64>,
        defined: usize,
    ) -> Result<(), OutOfRange> {
        if self.values.len() < corner {
            self.turn(false);
            self.values.resize(corner, 0);
        }
        for index in indices {
            self.turn(index < 0);
            if index.unsigned_abs() > MOST_ENTRIES {
                return Err(OutOfRange);
            }
            let value = if index < 0 { defined as i64 + 1 + index } else { index };
            self.values.push(value as u32); // the sign of relative ones comes back in `resolve`
        }
        Ok(())
    }

    /// The next index is relative, or absolute.
    #[inline(always)]
    fn turn(&mut self, relative: bool) {
        if relative != (self.turns.len() % 2 == 1) {
            self.turns.push(self.values.len() as u32);
        }
    }

    /// The indices, all of them absolute and none above `count`; `before` entries are defined in the pieces
    /// before this one. Nothing if all are absent, or if there is nothing to point at.
    pub fn resolve(self, before: u64, count: u64, corners: usize) -> Result<Vec<u32>, OutOfRange> {
        let Self { mut values, turns } = self;
        if values.is_empty() || count == 0 {
            return Ok(Vec::new());
        }
        let mut begin = 0;
        let ends = turns.iter().map(|turn| *turn as usize).chain([values.len()]);
        for (run, end) in ends.enumerate() {
            let indices = &mut values[begin..end];
            if run % 2 == 1 {
                to_absolute(indices, before)?;
            }
            let highest = indices.iter().copied().max().unwrap_or(0);
            if u64::from(highest) > count {
                return Err(OutOfRange);
            }
            begin = end;
        }
        values.resize(corners, 0);
        Ok(values)
    }
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
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    #[test]
    fn relative_indices_become_absolute() {
        let mut column = Column::default();
        column.append(0, [3, 4].into_iter(), 0).unwrap();
        column.append(2, [-1, -5].into_iter(), 2).unwrap();
        column.append(4, [7].into_iter(), 2).unwrap();
        assert_eq!(column.packed().resolve(10, 12, 6), Ok(vec![3, 4, 12, 8, 7, 0]));
        assert_eq!(column.packed().resolve(10, 11, 6), Err(OutOfRange));
        assert_eq!(column.resolve(2, 12, 6), Err(OutOfRange), "back beyond the first");
    }

    #[test]
    fn what_is_absent_takes_no_memory() {
        let mut column = Column::default();
        assert_eq!(column.packed().resolve(0, 5, 9), Ok(Vec::new()));
        column.append(2, [1].into_iter(), 0).unwrap();
        assert_eq!(column.packed().resolve(0, 0, 3), Ok(Vec::new()), "there is none in the file");
        assert_eq!(column.packed().resolve(0, 5, 4), Ok(vec![0, 0, 1, 0]));
        column.append(3, [-1].into_iter(), 2).unwrap();
        column.append(5, [-1].into_iter(), 2).unwrap();
        assert_eq!(column.resolve(3, 5, 7), Ok(vec![0, 0, 1, 5, 0, 5, 0]));
    }

    #[test]
    fn indices_that_no_file_can_hold_are_refused() {
        for index in [1 << 31, -(1 << 31), i64::MIN] {
            assert_eq!(Column::default().append(0, [index].into_iter(), 0), Err(OutOfRange));
        }
    }
}
