//! Faces that share one list of vertices, made into triangles.

use rayon::prelude::*;

use super::run::{FaceRun, Indices, MOST_CORNERS, all_used};
use super::triangulate::{self, Triangles};
use super::{LARGEST_COORDINATE, TriangleSoup, Use, are_within_reach};

/// Corners in a list: what one thread cuts in one go.
const LIST: usize = 1 << 18;

/// Vertex that no face uses.
const UNUSED: u32 = u32::MAX;

/// Faces that share one list of vertices.
#[derive(Debug, Default)]
pub struct FaceLists {
    /// Lists that are full, and then the one at work.
    runs: Vec<FaceRun>,
    /// Use of the faces that are added next.
    use_at_work: Use,
}

impl FaceLists {
    /// Maximum number of corners of a face.
    pub const MOST_CORNERS: usize = MOST_CORNERS;

    /// Adds a face of at least three corners, and of at most [`MOST_CORNERS`](Self::MOST_CORNERS), by its vertices.
    pub fn add(&mut self, corners: impl ExactSizeIterator<Item = u32>) {
        if self.runs.last().is_none_or(|run| run.positions.len() >= LIST) {
            let positions = Vec::with_capacity(LIST + 3);
            self.runs.push(FaceRun { positions, uses: vec![(0, self.use_at_work)], ..FaceRun::default() });
        }
        let Some(run) = self.runs.last_mut() else { return };
        let arity = corners.len();
        if arity != 3 && run.arities.is_empty() {
            run.arities.resize(run.faces, 3);
        }
        if arity != 3 || !run.arities.is_empty() {
            run.arities.push(arity as u16); // see `MOST_CORNERS`
        }
        run.positions.extend(corners);
        run.faces += 1;
    }

    /// Gives the faces that are added from now on a material, by its number.
    pub fn use_material(&mut self, material: u32) {
        if self.use_at_work.material == material {
            return;
        }
        self.use_at_work.material = material;
        if let Some(run) = self.runs.last_mut() {
            run.uses.push((run.faces as u32, self.use_at_work));
        }
    }

    /// Number of faces.
    pub fn count(&self) -> usize {
        self.runs.iter().map(|run| run.faces).sum()
    }

    /// Finds the first face that uses a vertex beyond the `count` that there are: its number, and the vertex.
    pub fn beyond(&self, count: usize) -> Option<(usize, u32)> {
        let is_beyond = |corner: &u32| *corner as usize >= count;
        let mut before = 0;
        for run in &self.runs {
            if let Some(at) = run.positions.iter().position(is_beyond) {
                return Some((before + face_of(run, at), run.positions[at]));
            }
            before += run.faces;
        }
        None
    }

    /// Makes triangles of the faces. `file` has the vertices, of which those that no face uses are left out.
    ///
    /// # Errors The number of a vertex whose place cannot be shown.
    pub fn surface(self, mut file: TriangleSoup) -> Result<TriangleSoup, usize> {
        let mut runs = self.runs;
        if !all_used(&runs, file.positions.len()) {
            file = used(file, &mut runs);
        }
        if !are_within_reach(&file.positions) {
            let is_far = |place: &[f32; 3]| !place.iter().all(|x| x.abs() <= LARGEST_COORDINATE);
            let vertex = file.positions.iter().position(is_far).unwrap_or_default();
            return Err(file.sources.get(vertex).map_or(vertex, |source| *source as usize));
        }
        let Triangles { corners, uses, .. } = triangulate::triangulate(runs, &file.positions);
        file.positions.reserve_exact(1);
        Ok(TriangleSoup { triangles: corners, uses, ..file })
    }
}

/// Number of the face in its run that has the corner number `at`.
fn face_of(run: &FaceRun, at: usize) -> usize {
    if run.arities.is_empty() {
        return at / 3;
    }
    let mut end = 0;
    let is_before = |arity: &&u16| {
        end += usize::from(**arity);
        end <= at
    };
    run.arities.iter().take_while(is_before).count()
}

/// Leaves out the vertices that no face uses.
fn used(file: TriangleSoup, runs: &mut [FaceRun]) -> TriangleSoup {
    let mut number_of = vec![UNUSED; file.positions.len()];
    runs.iter().flat_map(|run| &run.positions).for_each(|vertex| number_of[*vertex as usize] = 0);
    let mut sources = Vec::new();
    for (vertex, number) in number_of.iter_mut().enumerate().filter(|(_, number)| **number != UNUSED) {
        *number = sources.len() as u32;
        sources.push(vertex as u32);
    }
    runs.par_iter_mut().for_each(|run| {
        run.positions.iter_mut().for_each(|vertex| *vertex = number_of[*vertex as usize]);
        run.uvs = Indices::Absent;
    });
    let positions = chosen(&file.positions, &sources);
    let (normals, uvs) = (chosen(&file.normals, &sources), chosen(&file.uvs, &sources));
    let colors = chosen(&file.colors, &sources);
    TriangleSoup { positions, normals, uvs, colors, sources, ..file }
}

/// Entries of these vertices, with room for one more; none if the list is empty.
fn chosen<T: Copy>(list: &[T], vertices: &[u32]) -> Vec<T> {
    if list.is_empty() {
        return Vec::new();
    }
    let mut chosen = Vec::with_capacity(vertices.len() + 1);
    chosen.extend(vertices.iter().map(|vertex| list[*vertex as usize]));
    chosen
}
