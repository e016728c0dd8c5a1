//! Curves of files, of any basis, to chains of points that a [`Curves`] geometry has.

use std::collections::HashMap;

use glam::Vec2;
use half::f16;

use super::basis::{self, Basis, Point, Wrap};
use crate::digest::Digest;
use crate::geometry::{Bounds, Curves};
use crate::memory::{self, Need, Part};
use crate::scene::details::vertex_color;

/// Curves as a file has them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CurveSet {
    /// Control points, curve after curve.
    pub points: Vec<[f32; 3]>,
    /// Radius of each point.
    pub radii: Vec<f32>,
    /// Number of points of each curve.
    pub counts: Vec<u32>,
    /// What control points mean.
    pub basis: Basis,
    /// How curves begin and end.
    pub wrap: Wrap,
    /// Texture coordinates of each curve, or none.
    pub uvs: Vec<Vec2>,
    /// Colour of each point (linear RGB), or none.
    pub colors: Vec<[f32; 3]>,
    /// Normal of each point, of any length, if the curves are flat; or none.
    pub normals: Vec<[f32; 3]>,
    /// Where the points are at several frames, which rise, if the curves deform; `points` and `radii` are then those at the first.
    pub shapes: Vec<CurveShape>,
}

/// Control points at one frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CurveShape {
    /// The frame.
    pub frame: f64,
    /// As many as the set has.
    pub points: Vec<[f32; 3]>,
    /// Radius of each point.
    pub radii: Vec<f32>,
    /// Those of flat curves, where they change.
    pub normals: Vec<[f32; 3]>,
}

/// Frames and the numbers of shapes.
pub type Keys = Vec<(f64, u32)>;

/// Curves that were made of a set.
pub struct BuiltCurves {
    pub curves: Curves,
    /// Colour of each of its points, or none.
    pub colors: Vec<[f16; 3]>,
    /// What was left out, in whole sentences.
    pub left_out: Vec<String>,
    /// Frames and the numbers of their shapes, if the curves deform.
    pub keys: Keys,
}

/// Greatest distance between a curve and the chain that stands for it, as a share of the diagonal of the box around all of them: in a picture
/// that they fill from side to side, of 2000 pixels, a tenth of a pixel.
const MOST_OFF: f64 = 1.0 / 20_000.0;

/// Most pieces of a segment of a curve.
const MOST_PIECES: f64 = 64.0;

/// Most points of all chains: numbers of primitives are 31 bits wide.
const MOST_POINTS: usize = 1 << 30;

/// Bytes of a point and its primitive: in the geometry, in a tracer's tree, and while both are made.
const BYTES_OF_POINT: u64 = 250;

/// Bytes of a point in a shape: as the file has it, and as it is drawn.
const BYTES_OF_SHAPE: u64 = 64;

/// Reasons for which a curve is left out.
#[derive(Default)]
struct LeftOut {
    not_finite: usize,
    too_short: usize,
    no_length: usize,
    no_radius: usize,
}

impl CurveSet {
    /// Makes chains of the curves. `tolerance`: greatest distance of a chain from its curve, in the space of the points; by default what no
    /// picture shows.
    ///
    /// # Errors Lists that do not fit each other, too many points, or no curve that can be drawn. The text says what is wrong.
    pub(in crate::scene) fn build(&self, tolerance: Option<f64>) -> Result<BuiltCurves, String> {
        let (mut chains, sentences) = self.chains(tolerance)?;
        let frames = self.shapes.iter().map(|shape| shape.frame);
        let (shapes, keys) = distinct(std::mem::take(&mut chains.shapes), frames);
        let made = match &shapes[..] {
            [points] => Curves::new(points, &chains.counts, &chains.uvs),
            shapes => Curves::deforming(shapes, &chains.counts, &chains.uvs),
        };
        let Some((curves, kept)) = made else {
            return Err(none_is_left(&sentences));
        };
        let color = |at: &u32| vertex_color(chains.colors[*at as usize]);
        let colors = if self.colors.is_empty() { Vec::new() } else { kept.iter().map(color).collect() };
        Ok(BuiltCurves { curves, colors, left_out: sentences, keys })
    }

    /// Chains of all curves that can be drawn, and what is to be said of the others.
    pub(super) fn chains(&self, tolerance: Option<f64>) -> Result<(Chains, Vec<String>), String> {
        self.check()?;
        let diagonal = self.diagonal();
        let count = self.shapes.len().max(1);
        let mut chains = Chains {
            shapes: vec![Vec::new(); count],
            normals: vec![Vec::new(); if self.normals.is_empty() { 0 } else { count }],
            ..Chains::default()
        };
        let mut left_out = LeftOut::default();
        let mut first = 0;
        for (curve, count) in self.counts.iter().enumerate() {
            let numbers = first..first + *count as usize;
            first += *count as usize;
            let in_shape = |shape: Option<&CurveShape>| -> Vec<Point> {
                numbers.clone().map(|at| self.point(shape, at)).collect()
            };
            let shapes: Vec<Vec<Point>> = match &self.shapes[..] {
                [] => vec![in_shape(None)],
                shapes => shapes.iter().map(Some).map(in_shape).collect(),
            };
            let points = || shapes.iter().flatten();
            if !points().flatten().all(|value| value.is_finite() && value.abs() <= 1e30) {
                left_out.not_finite += 1;
                continue;
            }
            let thickest = points().map(|point| point[3]).fold(0.0, f64::max);
            if thickest <= 0.0 {
                left_out.no_radius += 1;
                continue;
            }
            let off = tolerance.unwrap_or(diagonal * MOST_OFF).max(f64::MIN_POSITIVE);
            let before = chains.shapes[0].len();
            if !basis::dice(&shapes, (self.basis, self.wrap), off, MOST_PIECES, &mut |shape, point| {
                chains.push(shape, point)
            }) {
                left_out.too_short += 1;
                continue;
            }
            let is_place =
                |all: &Vec<[f32; 4]>| all[before..].iter().all(|point| point[..3] == all[before][..3]);
            if chains.shapes.iter().all(is_place) {
                left_out.no_length += 1;
                chains.truncate(before);
                continue;
            }
            if chains.shapes[0].len() > MOST_POINTS {
                return Err(String::from(
                    "the curves have more than 1,073,741,824 points: draw fewer of them",
                ));
            }
            chains.counts.push((chains.shapes[0].len() - before) as u32);
            chains.uvs.extend(self.uvs.get(curve));
        }
        Ok((chains, left_out.sentences(self.basis, self.wrap)))
    }

    /// Returns true if the other set may be a shape of this one: as many curves, with as many points each, that are of one kind.
    #[cfg_attr(not(feature = "usd"), allow(dead_code, reason = "other files state shapes as such"))]
    pub fn is_like(&self, other: &Self) -> bool {
        let kind = |set: &Self| (set.basis, set.wrap, set.normals.is_empty());
        self.counts == other.counts && kind(self) == kind(other)
    }

    /// Checks that the lists fit each other, and that there is memory for them.
    ///
    /// # Errors What does not.
    pub(in crate::scene) fn check(&self) -> Result<(), String> {
        let Self { points, radii, counts, uvs, colors, normals, shapes, .. } = self;
        let all: u64 = counts.iter().map(|count| u64::from(*count)).sum();
        if all != points.len() as u64 {
            return Err(format!(
                "the curves have {all} points in all by their counts, and there are {}",
                points.len()
            ));
        }
        if radii.len() != points.len() {
            return Err(format!("there are {} radii for {} points", radii.len(), points.len()));
        }
        if !normals.is_empty() && normals.len() != points.len() {
            return Err(format!("there are {} normals for {} points", normals.len(), points.len()));
        }
        if !uvs.is_empty() && uvs.len() != counts.len() || !colors.is_empty() && colors.len() != points.len()
        {
            return Err(format!(
                "there are {} texture coordinates for {} curves, and {} colours for {} points",
                uvs.len(),
                counts.len(),
                colors.len(),
                points.len()
            ));
        }
        if let Some(CurveShape { frame, .. }) = shapes.iter().find(|shape| {
            let normals = if shape.normals.is_empty() { normals.len() } else { shape.normals.len() };
            shape.points.len() != points.len()
                || shape.radii.len() != points.len()
                || normals != self.normals.len()
        }) {
            return Err(format!(
                "the curves have {} points, and another number at frame {frame}: curves that deform keep theirs",
                points.len()
            ));
        }
        let need = (BYTES_OF_POINT + BYTES_OF_SHAPE * shapes.len() as u64) * points.len() as u64;
        Need::new(Part::new("the curves", need, "fewer curves, fewer points, a shorter animation"))
            .check(&memory::left())
            .map_err(|error| error.to_string())
    }

    fn point(&self, shape: Option<&CurveShape>, at: usize) -> Point {
        let (points, radii) =
            shape.map_or((&self.points, &self.radii), |shape| (&shape.points, &shape.radii));
        let [x, y, z] = points[at].map(f64::from);
        let of_shape = shape.map(|shape| &shape.normals).filter(|normals| !normals.is_empty());
        let normals = of_shape.unwrap_or(&self.normals);
        let [nx, ny, nz] = normals.get(at).copied().unwrap_or([0.0; 3]).map(f64::from);
        let [red, green, blue] = self.colors.get(at).copied().unwrap_or([1.0; 3]).map(f64::from);
        [x, y, z, f64::from(radii[at]), red, green, blue, nx, ny, nz]
    }

    fn diagonal(&self) -> f64 {
        let finite =
            self.points.iter().map(|point| glam::Vec3::from(*point)).filter(|point| point.is_finite());
        let around = finite.fold(Bounds::EMPTY, Bounds::with);
        if around.is_empty() { 0.0 } else { (around.high - around.low).as_dvec3().length() }
    }
}

/// Points of chains, as they are made.
#[derive(Default)]
pub(super) struct Chains {
    /// Points in each shape, or in the only one.
    pub shapes: Vec<Vec<[f32; 4]>>,
    /// Normals in each, of flat curves.
    pub normals: Vec<Vec<[f32; 3]>>,
    /// Of the points in the first shape.
    pub colors: Vec<[f32; 3]>,
    pub counts: Vec<u32>,
    pub uvs: Vec<Vec2>,
}

impl Chains {
    fn push(&mut self, shape: usize, [x, y, z, radius, red, green, blue, nx, ny, nz]: Point) {
        self.shapes[shape].push([x, y, z, radius.max(0.0)].map(|value| value as f32));
        if let Some(normals) = self.normals.get_mut(shape) {
            normals.push([nx, ny, nz].map(|value| value as f32));
        }
        if shape == 0 {
            self.colors.push([red, green, blue].map(|value| value.max(0.0) as f32));
        }
    }

    fn truncate(&mut self, length: usize) {
        self.shapes.iter_mut().for_each(|points| points.truncate(length));
        self.normals.iter_mut().for_each(|normals| normals.truncate(length));
        self.colors.truncate(length);
    }
}

/// Why there is nothing to be drawn.
pub(super) fn none_is_left(sentences: &[String]) -> String {
    let why = sentences.first().map_or("there is none", |why| why.as_str());
    format!("there is no curve to be drawn: {why}")
}

/// Shapes that differ, each once, and the keys of a track through them.
fn distinct(shapes: Vec<Vec<[f32; 4]>>, frames: impl Iterator<Item = f64>) -> (Vec<Vec<[f32; 4]>>, Keys) {
    let mut list: Vec<Vec<[f32; 4]>> = Vec::new();
    let mut known: HashMap<Digest, u32> = HashMap::new();
    let number = |points: Vec<[f32; 4]>| {
        let digest = Digest::new(bytemuck::cast_slice(&points));
        *known.entry(digest).or_insert_with(|| {
            list.push(points);
            list.len() as u32 - 1
        })
    };
    let numbers: Vec<u32> = shapes.into_iter().map(number).collect();
    let keys = frames.zip(numbers).collect();
    (list, keys)
}

impl LeftOut {
    fn sentences(&self, basis: Basis, wrap: Wrap) -> Vec<String> {
        let Self { not_finite, too_short, no_length, no_radius } = *self;
        let least = basis::points_wanted(basis, wrap);
        [
            (not_finite, String::from("with places or radii that are no numbers, or too large")),
            (too_short, format!("with another number of points than their basis takes ({least})")),
            (no_length, String::from("without a length")),
            (no_radius, String::from("without a thickness (all radii are 0)")),
        ]
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| {
            let curves = if count == 1 { "curve is" } else { "curves are" };
            format!("{count} {curves} left out: {what}")
        })
        .collect()
    }
}

#[cfg(test)]
mod tests;
