//! Outlines of what is there in a part of a picture.

use glam::{DVec2, Vec2};

use super::{Alpha, Mask, Square};
use crate::scene::texture::{Placement, Wrap};

/// Share of the box around what is there that a corner must have to be worth an edge of the outline.
const LEAST_CORNER: f64 = 0.02;

/// A half of the plane of a picture: `normal.dot(place) <= end`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfPlane {
    /// Direction to the border, of any length.
    pub normal: DVec2,
    /// The border: product of `normal` and any place there.
    pub end: f64,
}

impl HalfPlane {
    /// How far a place is beyond the border: its distance times the length of `normal`; at most 0 within the half.
    pub fn beyond(&self, place: DVec2) -> f64 {
        self.normal.dot(place) - self.end
    }
}

/// Part of a picture, in squares between the centres of texels: columns and rows, from the first to the last. Numbers go on where the
/// picture wraps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Part {
    columns: [i64; 2],
    rows: [i64; 2],
}

impl Part {
    /// Creates the part in which all places between two corners are.
    pub fn between(low: DVec2, high: DVec2) -> Self {
        let ends = |low: f64, high: f64| [low.floor() as i64, high.floor() as i64];
        Self { columns: ends(low.x, high.x), rows: ends(low.y, high.y) }
    }

    /// Number of its squares.
    pub fn count(&self) -> u64 {
        let length = |[first, last]: [i64; 2]| last.abs_diff(first).saturating_add(1);
        length(self.columns).saturating_mul(length(self.rows))
    }
}

impl Mask {
    /// Texels of texture coordinates: 0 at the centre of the picture's first one, rightwards and downwards. `None` if not the picture
    /// alone says what is there.
    pub fn texel_of(&self, uv: Vec2) -> Option<DVec2> {
        let Alpha::Picture { placement, .. } = &self.alpha else { return None };
        let place = placement.mapping.at(uv).as_dvec2();
        let size = DVec2::new(placement.width.into(), placement.height.into());
        Some(DVec2::new(place.x, 1.0 - place.y) * size - 0.5)
    }

    /// Outline of what is there of a part of the picture, of at most eight edges. `None` if all may be there.
    pub fn outline(&self, part: Part) -> Option<Outline> {
        let Alpha::Picture { placement, squares, .. } = &self.alpha else { return None };
        let Placement { width, height, mapping, .. } = *placement;
        let [across, down] = mapping.wrap;
        let is_known = |[first, last]: [i64; 2], size: u32, wrap| {
            wrap != Wrap::Mirror || (first >= -1 && last < i64::from(size))
        };
        if !is_known(part.columns, width, across) || !is_known(part.rows, height, down) {
            return None;
        }
        let is_there = |column: i64, row: i64| {
            let (column, row) = (wrapped(column, width, across), wrapped(row, height, down));
            squares[row * width as usize + column] != Square::Gone
        };
        let columns = || part.columns[0]..=part.columns[1];
        let ends = |row: i64| {
            let first = columns().find(|column| is_there(*column, row))?;
            let last = columns().rev().find(|column| is_there(*column, row))?;
            Some([DVec2::new(first as f64, row as f64), DVec2::new(last as f64, row as f64)])
        };
        // the corners of each row's first and last square
        let corners: Vec<DVec2> = (part.rows[0]..=part.rows[1])
            .filter_map(ends)
            .flat_map(|[first, last]| [first, first + DVec2::Y, last + DVec2::X, last + DVec2::ONE])
            .collect();
        Some(Outline::around(&corners))
    }
}

/// Column or row of the picture, of so many, for a number that goes on where it wraps.
fn wrapped(number: i64, size: u32, wrap: Wrap) -> usize {
    match wrap {
        Wrap::Repeat => number.rem_euclid(size.into()) as usize,
        Wrap::Clamp | Wrap::Mirror => number.clamp(0, i64::from(size) - 1) as usize,
    }
}

/// What holds all that is there of a part of a picture.
#[derive(Debug, Clone, PartialEq)]
pub enum Outline {
    /// Nothing is there.
    Nothing,
    /// What is there is in all of these.
    Within(Vec<HalfPlane>),
}

impl Outline {
    /// Creates the outline of points: the box around them, less the corners that are empty.
    fn around(points: &[DVec2]) -> Self {
        let furthest = |normal: DVec2| {
            let ends = points.iter().map(|point| normal.dot(*point));
            HalfPlane { normal, end: ends.fold(f64::NEG_INFINITY, f64::max) }
        };
        if points.is_empty() {
            return Self::Nothing;
        }
        let mut halves: Vec<HalfPlane> =
            [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].map(furthest).into();
        let low = DVec2::new(-halves[1].end, -halves[3].end);
        let high = DVec2::new(halves[0].end, halves[2].end);
        let size = high - low;
        for toward in
            [DVec2::new(1.0, 1.0), DVec2::new(1.0, -1.0), DVec2::new(-1.0, 1.0), DVec2::new(-1.0, -1.0)]
        {
            let half = furthest(toward / size);
            let corner = DVec2::select(toward.cmpgt(DVec2::ZERO), high, low);
            // the part of both edges that the half plane cuts off at the corner, of the box's edge
            let cut = half.beyond(corner);
            if cut * cut / 2.0 >= LEAST_CORNER {
                halves.push(half);
            }
        }
        Self::Within(halves)
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;
    use std::sync::Arc;

    use super::*;
    use crate::scene::Texture;
    use crate::scene::cutout::{Asks, Cutout, LEAST_OPACITY};
    use crate::scene::texture::Mapping;

    /// A mask of `size` texels, there where `is_there` says so.
    fn mask([width, height]: [u32; 2], wrap: Wrap, is_there: impl Fn(u32, u32) -> bool) -> Mask {
        let alpha = |i: u32| if is_there(i % width, i / width) { 255 } else { 0 };
        let texels: Arc<[[u8; 4]]> = (0..width * height).map(|i| [0, 0, 0, alpha(i)]).collect();
        let mapping = Mapping { wrap: [wrap; 2], ..Mapping::default() };
        let texture = Texture::of_bytes(PathBuf::new(), [width, height], texels, mapping);
        Mask::new(Cutout::by_picture(0, LEAST_OPACITY), Some(texture))
    }

    /// What is there at any place of a part is within its outline, however the picture wraps.
    #[test]
    fn outlines_hold_all_that_is_there() {
        let leaf = |x: u32, y: u32| x.abs_diff(9) + y.abs_diff(6) < 4;
        for (wrap, low, high) in [
            (Wrap::Repeat, Vec2::ZERO, Vec2::ONE),
            (Wrap::Repeat, Vec2::new(-0.95, 1.05), Vec2::new(-0.05, 1.95)),
            (Wrap::Clamp, Vec2::new(-0.5, -0.5), Vec2::splat(1.5)),
            (Wrap::Mirror, Vec2::new(0.1, 0.0), Vec2::new(0.9, 1.0)),
        ] {
            let mask = mask([20, 12], wrap, leaf);
            let corners = [low, high].map(|uv| mask.texel_of(uv).expect("a picture"));
            let part = Part::between(corners[0].min(corners[1]), corners[0].max(corners[1]));
            let Some(Outline::Within(halves)) = mask.outline(part) else {
                panic!("{wrap:?}: there is a leaf")
            };
            assert!(halves.len() > 4, "{wrap:?}: a rhombus has empty corners");
            let (mut there, mut outside) = (0, 0);
            for i in 0..200 * 200 {
                let uv = low + (high - low) * Vec2::new((i % 200) as f32, (i / 200) as f32) / 200.0;
                let texel = mask.texel_of(uv).expect("a picture");
                let is_within = halves.iter().all(|half| half.beyond(texel) <= 1e-4);
                let is_there = mask.is_there((0, mask.place_of(uv)), Asks::Sight, || 1.0);
                assert!(is_within || !is_there, "{wrap:?}: {uv}");
                there += u32::from(is_there);
                outside += u32::from(!is_within);
            }
            assert!(there > 1000 && outside > 1000, "{wrap:?}: {there} there, {outside} outside");
        }
    }

    #[test]
    fn what_is_gone_has_no_outline_and_what_is_mirrored_none_that_is_known() {
        let part = |[x0, x1]: [f64; 2]| Part::between(DVec2::new(x0, 0.0), DVec2::new(x1, 3.0));
        let half = mask([8, 8], Wrap::Repeat, |x, _| x < 4);
        assert_eq!(half.outline(part([4.5, 6.5])), Some(Outline::Nothing));
        assert_ne!(half.outline(part([4.5, 9.5])), Some(Outline::Nothing), "the picture begins again");
        let mirrored = mask([8, 8], Wrap::Mirror, |x, _| x < 4);
        assert_eq!(mirrored.outline(part([4.5, 6.5])), Some(Outline::Nothing));
        assert_eq!(mirrored.outline(part([4.5, 9.5])), None);
    }
}
