//! Lists that begin at a line of the processor's caches, so that a row of a tile lies in as few lines as
//! possible: in a list that begins within a line, each row lies in one line more.

use std::ops::{Deref, DerefMut};

use crate::prefetch::LINE;

/// List of fixed length. As a slice it is the list alone.
#[derive(Debug)]
pub struct Aligned<T> {
    /// The list with one cache line of further values, before and behind it together.
    padded: Vec<T>,
    /// Index of the list's first value.
    first: usize,
    length: usize,
}

impl<T: Copy + Default> Aligned<T> {
    /// Creates a list of `length` zeros, or whatever is the default.
    #[must_use]
    pub fn zeros(length: usize) -> Self {
        const { assert!(LINE % size_of::<T>() == 0, "values do not fill lines") };
        let in_line = LINE / size_of::<T>();
        let padded = vec![T::default(); length + in_line];
        // the offset need not be known: then nothing but time is lost
        let first = padded.as_ptr().align_offset(LINE).min(in_line);
        Self { padded, first, length }
    }
}

impl<T> Deref for Aligned<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        &self.padded[self.first..][..self.length]
    }
}

impl<T> DerefMut for Aligned<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.padded[self.first..][..self.length]
    }
}

impl<T: Copy + Default> Clone for Aligned<T> {
    fn clone(&self) -> Self {
        let mut copy = Self::zeros(self.length);
        copy.copy_from_slice(self);
        copy
    }
}

impl<T: PartialEq> PartialEq for Aligned<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_begin_with_a_line() {
        for length in [0, 1, 15, 16, 1000] {
            let list = Aligned::<f32>::zeros(length);
            assert_eq!((list.len(), list.as_ptr() as usize % LINE), (length, 0));
        }
        assert_eq!(Aligned::<u16>::zeros(3).as_ptr() as usize % LINE, 0);
    }

    #[test]
    fn copies_hold_the_same() {
        let mut list = Aligned::<f32>::zeros(3);
        list.copy_from_slice(&[1.0, 2.0, 3.0]);
        let copy = list.clone();
        assert_eq!((&copy[..], copy.as_ptr() as usize % LINE), (&[1.0, 2.0, 3.0][..], 0));
        assert!(copy == list && copy != Aligned::zeros(3) && list != Aligned::zeros(2));
    }
}
