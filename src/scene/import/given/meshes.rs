//! Meshes and their places, as a program gives them: plain data.

use std::sync::Arc;

use glam::DAffine3;

use super::curves;
use crate::scene::import::curves::CurveSet;
use crate::scene::import::faces::are_within_reach;
use crate::scene::{Linked, RayVisibility};

/// Path of the shot in messages about the whole of it.
pub const NAME: &str = "scene";

/// A mesh of polygons, in object space.
///
/// Normals, texture coordinates and colours: none at all, one for each point, or one for each corner. Where there are as many points as
/// corners, they belong to points.
#[derive(Debug, Default, Clone)]
pub struct GivenMesh {
    /// Name for messages.
    pub name: String,
    /// Points.
    pub points: Vec<[f32; 3]>,
    /// Points of the corners, face after face, counter-clockwise seen from outside.
    pub corners: Vec<u32>,
    /// Number of corners of each face. None: all are triangles.
    pub counts: Option<Vec<u32>>,
    /// Normals, of any length. Faces without any are flat.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates: v = 0 at the bottom of the picture.
    pub uvs: Vec<[f32; 2]>,
    /// Colours, linear RGB from 0 to 1: factors of the reflectance.
    pub colors: Vec<[f32; 3]>,
    /// Names of the mesh's materials. An empty name stands for the grey of faces without a material.
    pub materials: Vec<String>,
    /// Index into `materials` of each face; empty: the first one for all.
    pub material_of: Vec<u32>,
    /// Frames, and all points at these, if the mesh deforms. `points` is its shape where there are none.
    pub shapes: Vec<(f64, Vec<[f32; 3]>)>,
    /// Curves of the first of its materials, in place of all faces.
    pub curves: Option<Box<CurveSet>>,
}

/// A mesh at a place.
#[derive(Debug, Clone)]
pub struct GivenModel {
    /// Name in layers.
    pub name: String,
    /// Index of its mesh.
    pub mesh: usize,
    /// Maps from the mesh to the world by frame, at least one. Between them each element is interpolated.
    pub places: Vec<(f64, DAffine3)>,
    /// True if it is there before the first of `visible`.
    pub is_visible: bool,
    /// True or false from these frames on.
    pub visible: Vec<(f64, bool)>,
    /// What rays of each kind see of it.
    pub ray_visibility: RayVisibility,
    /// What links of lights know of it.
    pub linked: Linked,
}

/// All models of a scene.
#[derive(Debug, Default, Clone)]
pub struct Given {
    /// Meshes, which models share.
    pub meshes: Vec<Arc<GivenMesh>>,
    /// Models, in the order of their numbers in the layer `object`.
    pub models: Vec<GivenModel>,
}

impl GivenMesh {
    /// Number of faces.
    pub fn faces(&self) -> usize {
        self.counts.as_ref().map_or(self.corners.len() / 3, Vec::len)
    }

    /// Number of bytes that the renderer's mesh takes while it is made of this one, at most.
    pub(in crate::scene) fn bytes_while_made(&self) -> u64 {
        /// Point and first corner of a vertex, and its position.
        const OF_VERTEX: usize = 4 + 4 + 12;
        /// Values of a vertex, if there are any.
        const VALUES: [usize; 3] = [12, 8, 12];
        /// Vertex of a corner.
        const OF_CORNER: usize = 4;
        /// Entry of the table that finds equal corners: it doubles as it grows, and is copied then.
        const OF_KNOWN_CORNER: usize = 3 * 44;
        /// Triangle, its material, and two copies of it where the list doubles.
        const OF_TRIANGLE: usize = 3 * 12 + 2;
        let (points, corners) = (self.points.len(), self.corners.len());
        let lists = [self.normals.len(), self.uvs.len(), self.colors.len()];
        let of_corners = lists.iter().any(|count| ![0, points].contains(count));
        let (vertices, of_corner) =
            if of_corners { (corners, OF_CORNER + OF_KNOWN_CORNER) } else { (points, OF_CORNER) };
        let values = lists.iter().zip(VALUES).filter(|(count, _)| **count > 0).map(|(_, bytes)| bytes);
        let of_vertex = OF_VERTEX + values.sum::<usize>() + 12 * self.shapes.len();
        let triangles = corners.saturating_sub(2 * self.faces());
        let counts = [(vertices, of_vertex), (corners, of_corner), (triangles, OF_TRIANGLE)];
        counts.iter().map(|(count, bytes)| *count as u64 * *bytes as u64).sum()
    }

    /// Checks that all numbers fit together.
    ///
    /// # Errors
    /// The first thing that does not, and what to do.
    pub fn check(&self) -> Result<(), String> {
        if let Some(set) = &self.curves {
            return curves::check(&self.name, set);
        }
        let (points, corners, faces) = (self.points.len(), self.corners.len(), self.faces());
        let in_mesh = |what: String| Err(format!("mesh `{}`: {what}", self.name));
        if faces == 0 || corners == 0 {
            return in_mesh(String::from("it has no faces: leave it out"));
        }
        if u32::try_from(corners).is_err() {
            return in_mesh(format!("{corners} corners are more than four thousand million"));
        }
        match &self.counts {
            None if corners % 3 != 0 => {
                return in_mesh(format!("{corners} corners make no triangles: give three for each"));
            }
            Some(counts) if counts.iter().map(|count| u64::from(*count)).sum::<u64>() != corners as u64 => {
                return in_mesh(format!(
                    "the loop counts of its faces do not add up to its {corners} corners"
                ));
            }
            _ => {}
        }
        if let Some(wrong) = self.corners.iter().find(|corner| **corner as usize >= points) {
            return in_mesh(format!("a face is at vertex {wrong}, and there are {points} vertices (from 0)"));
        }
        for (what, count) in
            [("normals", self.normals.len()), ("uv", self.uvs.len()), ("colors", self.colors.len())]
        {
            if ![0, points, corners].contains(&count) {
                return in_mesh(format!(
                    "`{what}` has {count} entries: give one for each of the {points} vertices, or for each of the {corners} corners"
                ));
            }
        }
        let is_finite = |numbers: &[f32]| numbers.iter().all(|number| number.is_finite());
        for (what, numbers) in [
            ("normals", self.normals.as_flattened()),
            ("uv", self.uvs.as_flattened()),
            ("colors", self.colors.as_flattened()),
        ] {
            if !is_finite(numbers) {
                return in_mesh(format!("`{what}` has a number that is not finite"));
            }
        }
        if ![0, faces].contains(&self.material_of.len()) {
            let count = self.material_of.len();
            return in_mesh(format!(
                "{count} numbers of materials do not fit to {faces} faces: give one for each"
            ));
        }
        let materials = self.materials.len().max(1);
        if let Some(wrong) = self.material_of.iter().find(|material| **material as usize >= materials) {
            return in_mesh(format!("a face has material {wrong}, and there are {materials} (from 0)"));
        }
        let named = [(None, &self.points)].into_iter();
        for (frame, shape) in named.chain(self.shapes.iter().map(|(frame, shape)| (Some(*frame), shape))) {
            let at = frame.map_or(String::new(), |frame| format!(" at frame {frame}"));
            if shape.len() != points {
                let count = shape.len();
                return in_mesh(format!("{count} vertices{at} do not fit to its {points}"));
            }
            if !are_within_reach(shape) {
                return in_mesh(format!("a vertex{at} is not finite, or farther than 1e18 from the origin"));
            }
        }
        Ok(())
    }
}
