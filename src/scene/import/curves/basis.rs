//! Bases of curves: control points to cubic segments, and these to chains of points.
//!
//! All cubic bases are Bézier's by a matrix: J. Foley and others, "Computer Graphics: Principles and Practice", 1990, 11.2. Where curves
//! begin and end, and how they close, is as USD has it (`UsdGeomBasisCurves`).

use serde::Deserialize;

/// A point of a curve: place, radius, colour.
pub type Point = [f64; 7];

/// Basis of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// Straight from point to point
    #[default]
    Linear,
    /// Cubic Bezier: a point, two that lead on, a point, and so forth
    Bezier,
    /// Cubic B-spline, which passes by its points
    Bspline,
    /// Cubic, through its points
    CatmullRom,
}

/// How curves begin and end.
#[cfg_attr(not(feature = "usd"), allow(dead_code, reason = "curves of other files are all pinned"))]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// At their first and last point, whatever the basis.
    #[default]
    Pinned,
    /// Where the basis has them end: one point before the ends, for those that pass by their points.
    Open,
    /// They are closed.
    Periodic,
}

/// Number of points that curves need, as a text.
pub fn points_wanted(basis: Basis, wrap: Wrap) -> &'static str {
    match (basis, wrap) {
        (Basis::Linear, Wrap::Periodic) => "3 or more",
        (Basis::Linear, _) => "2 or more",
        (Basis::Bezier, Wrap::Periodic) => "3, 6, 9 and so on",
        (Basis::Bezier, _) => "4, 7, 10 and so on",
        (_, Wrap::Periodic) => "3 or more",
        (_, Wrap::Open) => "4 or more",
        (_, Wrap::Pinned) => "2 or more",
    }
}

/// Gives `put` the points of a chain that is no further than `off` from the curve of these control points, each segment in `most` pieces at
/// most. Returns false, and gives none, if their number is none that the basis takes.
pub fn dice(
    points: &[Point],
    (basis, wrap): (Basis, Wrap),
    off: f64,
    most: f64,
    put: &mut impl FnMut(Point),
) -> bool {
    let count = points.len();
    let at = |number: usize| points[number % count];
    match (basis, wrap) {
        (Basis::Linear, _) => {
            if count < 2 || wrap == Wrap::Periodic && count < 3 {
                return false;
            }
            points.iter().for_each(|point| put(*point));
            if wrap == Wrap::Periodic {
                put(points[0]);
            }
        }
        (Basis::Bezier, _) => {
            let closed = wrap == Wrap::Periodic;
            if closed && (count < 3 || count % 3 != 0) || !closed && (count < 4 || count % 3 != 1) {
                return false;
            }
            let segments = count / 3;
            chain((0..segments).map(|segment| [0, 1, 2, 3].map(|one| at(3 * segment + one))), off, most, put);
        }
        _ => {
            let to_bezier = if basis == Basis::Bspline { of_bspline } else { of_catmull_rom };
            match wrap {
                Wrap::Periodic if count >= 3 => {
                    let four = |first: usize| to_bezier([0, 1, 2, 3].map(|one| at(first + count - 1 + one)));
                    chain((0..count).map(four), off, most, put);
                }
                Wrap::Open if count >= 4 => {
                    chain(
                        points.windows(4).map(|four| to_bezier([four[0], four[1], four[2], four[3]])),
                        off,
                        most,
                        put,
                    );
                }
                Wrap::Pinned if count >= 2 => {
                    // a point before the first and one behind the last, for which the curve goes straight there
                    let beyond = |end: Point, next: Point| mix(&[(2.0, end), (-1.0, next)]);
                    let before = beyond(points[0], points[1]);
                    let behind = beyond(points[count - 1], points[count - 2]);
                    let at = |number: usize| match number {
                        0 => before,
                        number if number > count => behind,
                        number => points[number - 1],
                    };
                    let four = |first: usize| to_bezier([0, 1, 2, 3].map(|one| at(first + one)));
                    chain((0..count - 1).map(four), off, most, put);
                }
                _ => return false,
            }
        }
    }
    true
}

/// Sum of points, each by its factor.
fn mix(parts: &[(f64, Point)]) -> Point {
    let mut sum = [0.0; 7];
    for (factor, point) in parts {
        sum.iter_mut().zip(point).for_each(|(sum, value)| *sum += factor * value);
    }
    sum
}

fn of_bspline([a, b, c, d]: [Point; 4]) -> [Point; 4] {
    const SIXTH: f64 = 1.0 / 6.0;
    [
        mix(&[(SIXTH, a), (4.0 * SIXTH, b), (SIXTH, c)]),
        mix(&[(4.0 * SIXTH, b), (2.0 * SIXTH, c)]),
        mix(&[(2.0 * SIXTH, b), (4.0 * SIXTH, c)]),
        mix(&[(SIXTH, b), (4.0 * SIXTH, c), (SIXTH, d)]),
    ]
}

fn of_catmull_rom([a, b, c, d]: [Point; 4]) -> [Point; 4] {
    const SIXTH: f64 = 1.0 / 6.0;
    [b, mix(&[(1.0, b), (SIXTH, c), (-SIXTH, a)]), mix(&[(1.0, c), (-SIXTH, d), (SIXTH, b)]), c]
}

/// Chain of Bézier segments that follow each other.
fn chain(segments: impl Iterator<Item = [Point; 4]>, off: f64, most: f64, put: &mut impl FnMut(Point)) {
    let mut end = None;
    for segment in segments {
        let pieces = pieces(&segment, off, most);
        for piece in 0..pieces {
            put(at(&segment, f64::from(piece) / f64::from(pieces)));
        }
        end = Some(segment[3]);
    }
    end.into_iter().for_each(put);
}

/// Number of pieces for which chords are no further than `off` from the segment: by an eighth of its greatest second derivative, times the
/// square of the step.
fn pieces([a, b, c, d]: &[Point; 4], off: f64, most: f64) -> u32 {
    let bend = |a: &Point, b: &Point, c: &Point| {
        (0..3).map(|axis| a[axis] - 2.0 * b[axis] + c[axis]).map(|part| part * part).sum::<f64>().sqrt()
    };
    let second = 6.0 * bend(a, b, c).max(bend(b, c, d));
    (second / (8.0 * off)).sqrt().ceil().clamp(1.0, most) as u32
}

fn at([a, b, c, d]: &[Point; 4], t: f64) -> Point {
    let s = 1.0 - t;
    mix(&[(s * s * s, *a), (3.0 * s * s * t, *b), (3.0 * s * t * t, *c), (t * t * t, *d)])
}
