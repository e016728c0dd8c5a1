//! Curves of files, of any basis, to chains of points that a [`Curves`] geometry has.

use std::path::Path;
use std::sync::Arc;

use glam::Vec2;
use half::f16;

use super::basis::{self, Basis, Point, Wrap};
use crate::geometry::{Bounds, Curves};
use crate::memory::{self, Need, Part};
use crate::scene::details::{Details, vertex_color};
use crate::scene::import::Import;
use crate::scene::material::Optics;
use crate::scene::{Geometry, Mesh, SceneError};

/// Curves as a file has them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CurveSet {
    /// Control points, curve after curve.
    pub points: Vec<[f32; 3]>,
    /// Radius of each point.
    pub radii: Vec<f32>,
    /// Number of points of each curve.
    pub counts: Vec<u32>,
    pub basis: Basis,
    pub wrap: Wrap,
    /// Texture coordinates of each curve, or none.
    pub uvs: Vec<Vec2>,
    /// Colour of each point (linear RGB), or none.
    pub colors: Vec<[f32; 3]>,
}

/// Curves that were made of a set.
pub struct BuiltCurves {
    pub curves: Curves,
    /// Colour of each of its points, or none.
    pub colors: Vec<[f16; 3]>,
    /// What was left out, in whole sentences.
    pub left_out: Vec<String>,
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
        self.check()?;
        let diagonal = self.diagonal();
        let mut chains = Chains::default();
        let mut left_out = LeftOut::default();
        let mut first = 0;
        for (curve, count) in self.counts.iter().enumerate() {
            let points: Vec<Point> = (first..first + *count as usize).map(|at| self.point(at)).collect();
            first += *count as usize;
            if !points.iter().flatten().all(|value| value.is_finite() && value.abs() <= 1e30) {
                left_out.not_finite += 1;
                continue;
            }
            let thickest = points.iter().map(|point| point[3]).fold(0.0, f64::max);
            if thickest <= 0.0 {
                left_out.no_radius += 1;
                continue;
            }
            let off = tolerance.unwrap_or(diagonal * MOST_OFF).max(f64::MIN_POSITIVE);
            let before = chains.points.len();
            if !basis::dice(&points, (self.basis, self.wrap), off, MOST_PIECES, &mut |point| {
                chains.push(point)
            }) {
                left_out.too_short += 1;
                continue;
            }
            let is_place = |point: &[f32; 4]| point[..3] == chains.points[before][..3];
            if chains.points[before..].iter().all(is_place) {
                left_out.no_length += 1;
                chains.truncate(before);
                continue;
            }
            if chains.points.len() > MOST_POINTS {
                return Err(String::from(
                    "the curves have more than 1,073,741,824 points: draw fewer of them",
                ));
            }
            chains.counts.push((chains.points.len() - before) as u32);
            chains.uvs.extend(self.uvs.get(curve));
        }
        let sentences = left_out.sentences(self.basis, self.wrap);
        let made = Curves::new(&chains.points, &chains.counts, &chains.uvs);
        let Some((curves, kept)) = made else {
            let why = sentences.first().map_or("there is none", |why| why.as_str());
            return Err(format!("there is no curve to be drawn: {why}"));
        };
        let color = |at: &u32| vertex_color(chains.colors[*at as usize]);
        let colors = if self.colors.is_empty() { Vec::new() } else { kept.iter().map(color).collect() };
        Ok(BuiltCurves { curves, colors, left_out: sentences })
    }

    fn check(&self) -> Result<(), String> {
        let Self { points, radii, counts, uvs, colors, .. } = self;
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
        let need = BYTES_OF_POINT * points.len() as u64;
        Need::new(Part::new("the curves", need, "fewer curves, fewer points"))
            .check(&memory::left())
            .map_err(|error| error.to_string())
    }

    fn point(&self, at: usize) -> Point {
        let [x, y, z] = self.points[at].map(f64::from);
        let [red, green, blue] = self.colors.get(at).copied().unwrap_or([1.0; 3]).map(f64::from);
        [x, y, z, f64::from(self.radii[at]), red, green, blue]
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
struct Chains {
    points: Vec<[f32; 4]>,
    colors: Vec<[f32; 3]>,
    counts: Vec<u32>,
    uvs: Vec<Vec2>,
}

impl Chains {
    fn push(&mut self, [x, y, z, radius, red, green, blue]: Point) {
        self.points.push([x, y, z, radius.max(0.0)].map(|value| value as f32));
        self.colors.push([red, green, blue].map(|value| value.max(0.0) as f32));
    }

    fn truncate(&mut self, length: usize) {
        self.points.truncate(length);
        self.colors.truncate(length);
    }
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

/// Makes the mesh of curves of one material, and notes what was left out.
///
/// # Errors Those of [`CurveSet::build`], in `path`.
pub(in crate::scene) fn mesh_of(
    import: &mut Import,
    path: &Path,
    set: &CurveSet,
    tolerance: Option<f64>,
    material: u16,
) -> Result<Mesh, SceneError> {
    let BuiltCurves { curves, colors, left_out } =
        set.build(tolerance).map_err(|what| SceneError::new(path, what))?;
    for what in left_out {
        import.findings.note(SceneError::new(path, what));
    }
    if !colors.is_empty() {
        import.surfaces.color_vertices(material);
    }
    let of = &import.surfaces.materials[usize::from(material)];
    if matches!(of.optics, Optics::Glass { .. }) {
        let message = format!(
            "curves of the material `{}` bend light where it enters them, and not where it leaves them: what is to look like glass must be a mesh",
            of.name
        );
        import.findings.note(SceneError::new(path, message));
    }
    let casts_shadow = import.surfaces.casts_shadow(material);
    let mesh = Mesh::plain(Geometry::Curved(Arc::new(curves)), material, casts_shadow);
    let details = Arc::new(Details { colors, ..Details::default() });
    Ok(import.arranger().with_details(Mesh { details, ..mesh }, &[]))
}

#[cfg(test)]
mod tests;
