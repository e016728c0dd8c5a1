//! Windows of the film through which tiles write their pixels. The film is cut into windows so that many
//! tiles may write at once, each while its pixels are in its processor's cache.

use std::ops::Range;

use half::f16;
use rayon::prelude::*;

use crate::film::{Plane, Values, round_to_halves};
use crate::prefetch::prefetch;

/// Part of a film, in all planes, that some adjacent tiles show.
#[derive(Debug)]
pub struct Window<'f> {
    /// First column and row.
    corner: [usize; 2],
    planes: Vec<Rows<'f>>,
}

/// Rows of a plane in a window.
#[derive(Debug)]
enum Rows<'f> {
    Half(Vec<&'f mut [f16]>),
    Float(Vec<&'f mut [f32]>),
}

/// Cuts planes into windows, from left to right and down: a row of windows between each two successive `rows`, and in
/// row number `row` one between each two successive `columns(row)`, of which the last is the planes' width. A plane is
/// present only in windows where `is_wanted(plane, window)`.
pub fn cut<'f, 'c>(
    planes: &'f mut [Plane],
    rows: &[usize],
    columns: impl Fn(usize) -> &'c [usize] + Sync,
    is_wanted: impl Fn(usize, usize) -> bool + Sync,
) -> Vec<Window<'f>> {
    let [top, .., bottom] = rows else { return Vec::new() };
    let corners = rows[..rows.len() - 1].iter().enumerate().flat_map(|(row, y)| {
        let columns = columns(row);
        columns[..columns.len() - 1].iter().map(move |x| [*x, *y])
    });
    let mut windows: Vec<Window> =
        corners.map(|corner| Window { corner, planes: Vec::with_capacity(planes.len()) }).collect();
    let width = columns(0).last().copied().unwrap_or(0);
    let pixels = top * width..bottom * width;
    let rows_of = planes.par_iter_mut().enumerate().map(|(number, plane)| {
        let is_wanted = |window| is_wanted(number, window);
        match &mut plane.values {
            Values::Half(values) => {
                let cut = cut_plane(&mut values[pixels.clone()], rows, &columns, is_wanted);
                cut.into_iter().map(Rows::Half).collect::<Vec<_>>()
            }
            Values::Float(values) => {
                let cut = cut_plane(&mut values[pixels.clone()], rows, &columns, is_wanted);
                cut.into_iter().map(Rows::Float).collect()
            }
        }
    });
    for plane in rows_of.collect::<Vec<_>>() {
        windows.iter_mut().zip(plane).for_each(|(window, rows)| window.planes.push(rows));
    }
    windows
}

/// Cuts some rows of a plane into windows; those that are not wanted stay empty.
fn cut_plane<'f, 'c, T>(
    values: &'f mut [T],
    rows: &[usize],
    columns: impl Fn(usize) -> &'c [usize],
    is_wanted: impl Fn(usize) -> bool,
) -> Vec<Vec<&'f mut [T]>> {
    let mut all: Vec<Vec<&mut [T]>> = Vec::new();
    let mut left = values;
    for (row, count) in rows.windows(2).map(|pair| pair[1] - pair[0]).enumerate() {
        let columns = columns(row);
        let (across, width) = (columns.len() - 1, columns[columns.len() - 1]);
        let (band, below) = left.split_at_mut(count * width);
        left = below;
        let first = all.len();
        let room = |window| if is_wanted(window) { count } else { 0 };
        all.extend((first..first + across).map(|window| Vec::with_capacity(room(window))));
        let windows = &mut all[first..];
        if windows.iter().all(|rows| rows.capacity() == 0) {
            continue;
        }
        for mut row in band.chunks_mut(width) {
            for (rows, pair) in windows.iter_mut().zip(columns.windows(2)) {
                let (piece, right) = row.split_at_mut(pair[1] - pair[0]);
                row = right;
                if rows.capacity() > 0 {
                    rows.push(piece);
                }
            }
        }
    }
    all
}

impl Window<'_> {
    /// Writes pixels that cover these columns and rows of the film into plane number `number`. `values` are
    /// in rows of `stride`; the last row may end after the last value written.
    pub fn put(&mut self, number: usize, pixels: &[Range<usize>; 2], values: &[f32], stride: usize) {
        let [left, top] = self.corner;
        let columns = pixels[0].start - left..pixels[0].end - left;
        let rows_of = pixels[1].start - top..pixels[1].end - top;
        match &mut self.planes[number] {
            Rows::Float(rows) => {
                for (to, from) in rows[rows_of].iter_mut().zip(values.chunks(stride)) {
                    copy(&mut to[columns.clone()], from);
                }
            }
            Rows::Half(rows) => {
                for (to, from) in rows[rows_of].iter_mut().zip(values.chunks(stride)) {
                    let to = &mut to[columns.clone()];
                    round_to_halves(&from[..to.len()], to);
                }
            }
        }
    }

    /// Like [`put`](Self::put), for the `wanted` pixels alone: a flag for each of `values`.
    pub fn put_some(
        &mut self,
        number: usize,
        pixels: &[Range<usize>; 2],
        values: &[f32],
        wanted: &[bool],
        stride: usize,
    ) {
        let [left, top] = self.corner;
        let columns = pixels[0].start - left..pixels[0].end - left;
        let rows_of = pixels[1].start - top..pixels[1].end - top;
        let from = values.chunks(stride).zip(wanted.chunks(stride));
        match &mut self.planes[number] {
            Rows::Float(rows) => {
                for (to, (from, wanted)) in rows[rows_of].iter_mut().zip(from) {
                    let to = to[columns.clone()].iter_mut().zip(from).zip(wanted);
                    to.filter(|(_, wanted)| **wanted).for_each(|((to, from), _)| *to = *from);
                }
            }
            Rows::Half(rows) => {
                let mut halves = vec![f16::ZERO; columns.len()];
                for (to, (from, wanted)) in rows[rows_of].iter_mut().zip(from) {
                    round_to_halves(&from[..columns.len()], &mut halves);
                    let to = to[columns.clone()].iter_mut().zip(&halves).zip(wanted);
                    to.filter(|(_, wanted)| **wanted).for_each(|((to, from), _)| *to = *from);
                }
            }
        }
    }

    /// Prefetches the memory of these pixels of plane number `number`, which are written soon.
    #[inline]
    pub fn prefetch(&self, number: usize, pixels: &[Range<usize>; 2]) {
        let [left, top] = self.corner;
        let columns = pixels[0].start - left..pixels[0].end - left;
        let rows_of = pixels[1].start - top..pixels[1].end - top;
        match &self.planes[number] {
            Rows::Half(rows) => rows[rows_of].iter().for_each(|row| prefetch(&row[columns.clone()])),
            Rows::Float(rows) => rows[rows_of].iter().for_each(|row| prefetch(&row[columns.clone()])),
        }
    }

    /// Writes zeros into these pixels of plane number `number`.
    pub fn clear(&mut self, number: usize, pixels: &[Range<usize>; 2]) {
        let [left, top] = self.corner;
        let columns = pixels[0].start - left..pixels[0].end - left;
        let rows_of = pixels[1].start - top..pixels[1].end - top;
        match &mut self.planes[number] {
            Rows::Half(rows) => rows[rows_of].iter_mut().for_each(|row| row[columns.clone()].fill(f16::ZERO)),
            Rows::Float(rows) => rows[rows_of].iter_mut().for_each(|row| row[columns.clone()].fill(0.0)),
        }
    }

    /// Adds 1 to each of these pixels, up to `most`. Halves are left alone: they cannot count far.
    pub fn count_up(&mut self, number: usize, pixels: &[Range<usize>; 2], most: f32) {
        let [left, top] = self.corner;
        if let Rows::Float(rows) = &mut self.planes[number] {
            for row in &mut rows[pixels[1].start - top..pixels[1].end - top] {
                let counts = &mut row[pixels[0].start - left..pixels[0].end - left];
                counts.iter_mut().for_each(|count| *count = (*count + 1.0).min(most));
            }
        }
    }
}

/// Copies as many values as `to` has room for, in blocks of a known size: rows of tiles are too short to be
/// worth a call.
#[inline(always)]
fn copy<T: Copy>(to: &mut [T], from: &[T]) {
    const MANY: usize = 16;
    let from = &from[..to.len()];
    let (mut all_to, all_from) = (to.chunks_exact_mut(MANY), from.chunks_exact(MANY));
    let rest = all_from.remainder();
    for (to, from) in all_to.by_ref().zip(all_from) {
        to.copy_from_slice(from);
    }
    all_to.into_remainder().copy_from_slice(rest);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::PlaneKind;
    use crate::samples::CELLS;

    #[test]
    fn a_window_has_the_planes_that_are_wanted() {
        let blank = vec![0.0; 20 * 8];
        let mut planes = [("R", PlaneKind::Half), ("Z", PlaneKind::Float)]
            .map(|(name, kind)| Plane::new(name, kind, &blank));
        // four windows; the third has the second plane alone
        let mut windows =
            cut(&mut planes, &[0, 4, 8], |_| &[0, 10, 20], |plane, window| window != 2 || plane == 1);
        for (number, window) in windows.iter_mut().enumerate() {
            let [left, top] = window.corner;
            window.put(1, &[left..left + 10, top..top + 4], &[1.0; 40], 10);
            let Rows::Half(rows) = &window.planes[0] else { panic!("a plane of halves") };
            assert_eq!(rows.len(), if number == 2 { 0 } else { 4 });
        }
        assert!(planes[1].values.to_floats().iter().all(|value| *value == 1.0));
    }

    #[test]
    fn pixels_that_are_not_wanted_stay() {
        let blank = vec![0.0; 6 * 4];
        let mut planes = [("R", PlaneKind::Half), ("Z", PlaneKind::Float)]
            .map(|(name, kind)| Plane::new(name, kind, &blank));
        let mut windows = cut(&mut planes, &[0, 4], |_| &[0, 2, 6], |_, _| true);
        // three columns and two rows in the second window, in rows of four
        let wanted = [true, false, true, true, false, true, false];
        for plane in [0, 1] {
            let values = [1.0, 2.0, 3.0, 99.0, 4.0, 5.0, 6.0];
            windows[1].put_some(plane, &[3..6, 1..3], &values, &wanted, 4);
        }
        for plane in &planes {
            let some = (0..24).map(|at| plane.values.get(at)).enumerate().filter(|(_, value)| *value != 0.0);
            assert_eq!(some.collect::<Vec<_>>(), [(9, 1.0), (11, 3.0), (16, 5.0)]);
        }
    }

    #[test]
    fn each_row_of_windows_has_borders_of_its_own() {
        let blank = vec![0.0; 6 * 5];
        let mut planes = [Plane::new("Z", PlaneKind::Float, &blank)];
        let columns: [&[usize]; 2] = [&[0, 2, 6], &[0, 6]];
        let mut windows = cut(&mut planes, &[0, 2, 5], |row| columns[row], |_, _| true);
        let pixels = [[0..2, 0..2], [2..6, 0..2], [0..6, 2..5]];
        assert_eq!(windows.len(), pixels.len());
        for (value, (window, pixels)) in [1.0, 2.0, 3.0].into_iter().zip(windows.iter_mut().zip(&pixels)) {
            window.put(0, pixels, &[value; 18], pixels[0].len());
        }
        let wanted = [[1.0, 1.0, 2.0, 2.0, 2.0, 2.0]; 2].into_iter().chain([[3.0; 6]; 3]);
        assert_eq!(planes[0].values.to_floats().as_ref(), wanted.flatten().collect::<Vec<f32>>());
    }

    #[test]
    fn every_pixel_is_in_one_window() {
        let (width, height) = (21, 10);
        let blank = vec![0.0; width * height];
        let mut planes = [("R", PlaneKind::Half), ("Z", PlaneKind::Float)]
            .map(|(name, kind)| Plane::new(name, kind, &blank));
        // tiles of 4 x 4, two beside each other in a window
        for rows in [&[0, 4][..], &[4, 8, 10]] {
            let top = rows[0];
            for (number, mut window) in
                cut(&mut planes, rows, |_| &[0, 8, 16, 21], |_, _| true).into_iter().enumerate()
            {
                let [x, y] = window.corner;
                assert_eq!([x, y], [number % 3 * 8, top + number / 3 * 4]);
                for left in (x..(x + 8).min(width)).step_by(4) {
                    let pixels = [left..(left + 4).min(width), y..(y + 4).min(height)];
                    let mut values = [-1.0; CELLS];
                    for (i, value) in values[..16].iter_mut().enumerate() {
                        *value = ((y + i / 4) * width + left + i % 4) as f32;
                    }
                    window.put(0, &pixels, &values, 4);
                    window.put(1, &pixels, &values, 4);
                    if left == 16 {
                        window.count_up(1, &pixels, 40.0);
                        window.clear(0, &pixels);
                    }
                }
            }
        }
        for at in 0..width * height {
            let is_marked = (16..20).contains(&(at % width));
            assert_eq!(planes[0].values.get(at), if is_marked { 0.0 } else { at as f32 });
            let counted = if is_marked { (at as f32 + 1.0).min(40.0) } else { at as f32 };
            assert_eq!(planes[1].values.get(at), counted);
        }
    }
}
