//! Bases of curves: control points to cubic segments, and these to chains of points.
//!
//! All cubic bases are Bézier's by a matrix: J. Foley and others, "Computer Graphics: Principles and Practice", 1990, 11.2. Where curves
//! begin and end, and how they close, is as USD has it (`UsdGeomBasisCurves`).

use serde::Deserialize;

/// A point of a curve: place, radius, colour, normal of flat ones.
pub type Point = [f64; 10];

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
/// most: with the number of the shape, since a curve may have its points in several places. Chains of all shapes have as many points. Returns
/// false, and gives none, if the number of points is none that the basis takes.
pub fn dice(
    shapes: &[Vec<Point>],
    (basis, wrap): (Basis, Wrap),
    off: f64,
    most: f64,
    put: &mut impl FnMut(usize, Point),
) -> bool {
    let count = shapes[0].len();
    if basis == Basis::Linear {
        if count < 2 || wrap == Wrap::Periodic && count < 3 {
            return false;
        }
        for (shape, points) in shapes.iter().enumerate() {
            let again = (wrap == Wrap::Periodic).then_some(&points[0]);
            points.iter().chain(again).for_each(|point| put(shape, *point));
        }
        return true;
    }
    let Some(segments) = shapes.iter().map(|points| cubics(points, basis, wrap)).collect::<Option<Vec<_>>>()
    else {
        return false;
    };
    // as many as the shape needs in which the segment bends most
    let pieces_of = |segment: usize| {
        segments.iter().map(|of_shape| pieces(&of_shape[segment], off, most)).max().unwrap_or(1)
    };
    let pieces: Vec<u32> = (0..segments[0].len()).map(pieces_of).collect();
    for (shape, segments) in segments.iter().enumerate() {
        for (segment, pieces) in segments.iter().zip(&pieces) {
            for piece in 0..*pieces {
                put(shape, at(segment, f64::from(piece) / f64::from(*pieces)));
            }
        }
        segments.last().into_iter().for_each(|last| put(shape, last[3]));
    }
    true
}

/// Bézier's segments of a curve of a cubic basis, which follow each other; `None` if the number of points is none that the basis takes.
fn cubics(points: &[Point], basis: Basis, wrap: Wrap) -> Option<Vec<[Point; 4]>> {
    let count = points.len();
    let at = |number: usize| points[number % count];
    if basis == Basis::Bezier {
        let closed = wrap == Wrap::Periodic;
        if closed && (count < 3 || count % 3 != 0) || !closed && (count < 4 || count % 3 != 1) {
            return None;
        }
        return Some((0..count / 3).map(|segment| [0, 1, 2, 3].map(|one| at(3 * segment + one))).collect());
    }
    let to_bezier = if basis == Basis::Bspline { of_bspline } else { of_catmull_rom };
    match wrap {
        Wrap::Periodic if count >= 3 => {
            let four = |first: usize| to_bezier([0, 1, 2, 3].map(|one| at(first + count - 1 + one)));
            Some((0..count).map(four).collect())
        }
        Wrap::Open if count >= 4 => {
            let four = |four: &[Point]| to_bezier([four[0], four[1], four[2], four[3]]);
            Some(points.windows(4).map(four).collect())
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
            Some((0..count - 1).map(four).collect())
        }
        _ => None,
    }
}

/// Sum of points, each by its factor.
fn mix(parts: &[(f64, Point)]) -> Point {
    let mut sum = [0.0; 10];
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
