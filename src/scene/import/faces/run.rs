//! Faces before they are triangles, as one list.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::Use;

/// Maximum number of corners of one face: cutting up a tangled one takes time with the square of their
/// number.
pub const MOST_CORNERS: usize = 20_000;

/// Absolute indices of corners.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Indices {
    /// No corner has the attribute.
    #[default]
    Absent,
    /// Indices equal those of the corners' positions.
    AsPositions,
    /// Indices of their own, one a corner, from 1; 0 for absent.
    Own(Vec<u32>),
}

/// Faces of one list; corners are in order.
#[derive(Debug, Default)]
pub struct FaceRun {
    /// Indices of positions, from 0.
    pub positions: Vec<u32>,
    /// Indices of texture coordinates.
    pub uvs: Indices,
    /// Indices of normals.
    pub normals: Indices,
    /// Number of faces.
    pub faces: usize,
    /// Number of corners of each face; empty if all have three.
    pub arities: Vec<u16>,
    /// Changes of material, group and object: the first face, and its use. The first entry is for face 0.
    pub uses: Vec<(u32, Use)>,
}

/// Returns true if some face uses each position: unused ones must not become vertices.
pub fn all_used(runs: &[FaceRun], positions: usize) -> bool {
    let used: Vec<AtomicBool> = (0..positions).into_par_iter().map(|_| AtomicBool::new(false)).collect();
    runs.par_iter().flat_map_iter(|run| &run.positions).for_each(|index| {
        let flag = &used[*index as usize];
        // most are set already, and reading is cheaper than writing
        if !flag.load(Ordering::Relaxed) {
            flag.store(true, Ordering::Relaxed);
        }
    });
    used.par_iter().all(|flag| flag.load(Ordering::Relaxed))
}

/// Splits a list into parts of these lengths, from the first entry on.
pub fn split<T>(mut list: &mut [T], lengths: impl Iterator<Item = usize>) -> Vec<&mut [T]> {
    let mut parts = Vec::new();
    for length in lengths {
        let (part, rest) = list.split_at_mut(length);
        list = rest;
        parts.push(part);
    }
    parts
}
