//! Models of a file that holds many: their places, and their meshes before they are arranged.

use std::iter;
use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, Vec2, Vec3};
use half::f16;

use super::arrange::Arranger;
use crate::animation::{Interpolation, ShapeTrack, Track, Visibility};
use crate::scene::cutout::VertexData;
use crate::scene::details::Details;
use crate::scene::{Geometry, Linked, Mesh, RayVisibility, Triangles};

/// Ratio of the volume of a map to that of a cube of its largest stretch below which it makes things flat.
const FLAT: f64 = 1e-24;

/// One model of a file.
pub struct PartOfFile {
    /// Name of its node.
    pub name: String,
    /// Its mesh, which it may share with others.
    pub mesh: Arc<Mesh>,
    /// Map from the mesh to the root of the scene.
    pub map: Track<DAffine3>,
    /// Frames in which it is there.
    pub visible: Visibility,
    /// Shapes over time, if it deforms.
    pub shapes: Option<ShapeTrack>,
    /// What rays of each kind see of it.
    pub ray_visibility: RayVisibility,
    /// What links of lights know of it.
    pub linked: Linked,
}

/// Place of a node over time.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeTrack {
    /// Map to the root of the scene. Always with an inverse.
    pub map: Track<DAffine3>,
    /// While the node is scaled to nothing it is not there.
    pub visible: Visibility,
}

/// Vertices and triangles of a mesh whose materials are known.
#[derive(Default)]
pub struct Surface {
    /// Vertex positions, finite.
    pub positions: Vec<[f32; 3]>,
    /// Vertex normals, none at all or one a vertex: unit length, or zero.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, none at all or one a vertex; v = 0 at the bottom of the picture.
    pub uvs: Vec<Vec2>,
    /// Second set of texture coordinates, none at all or one a vertex.
    pub second_uvs: Vec<Vec2>,
    /// Colours of the vertices, none at all or one a vertex; linear RGB.
    pub colors: Vec<[f16; 3]>,
    /// Alphas of the vertices, none at all or one a vertex; 0 to 1.
    pub alphas: Vec<f32>,
    /// Tangents that the file states, none at all or one a vertex: see [`Mesh::tangents`].
    pub tangents: Vec<[f32; 4]>,
    /// Vertices of the triangles.
    pub triangles: Vec<[u32; 3]>,
}

impl NodeTrack {
    /// Makes a track of keys in order. `None` if the node has a volume in none of them.
    pub fn through(mut keys: Vec<(f64, DAffine3)>, cuts: &[f64]) -> Option<Self> {
        let is_solid: Vec<bool> = keys.iter().map(|(_, map)| !is_flat(map)).collect();
        let first = is_solid.iter().position(|solid| *solid)?;
        let mut there = Vec::new();
        let mut cuts = cuts.to_vec();
        let mut last = keys[first].1;
        for (i, (frame, map)) in keys.iter_mut().enumerate() {
            if is_solid[i] {
                // through zero: it jumps, and is nowhere flat
                if map.matrix3.determinant() * last.matrix3.determinant() < 0.0 {
                    cuts.push(*frame);
                }
                last = *map;
            }
            *map = last;
            if i == 0 || is_solid[i] != is_solid[i - 1] {
                there.push((*frame, is_solid[i]));
            }
        }
        let before = is_solid[0];
        let visible = Visibility::through(before, there)?;
        let is_still = keys.iter().all(|(_, map)| *map == keys[0].1);
        let map = if is_still {
            Track::constant(keys[0].1)
        } else {
            Track::through(keys, Interpolation::Linear)?.cut_at(&cuts)
        };
        Some(Self { map, visible })
    }
}

/// Returns true if nothing has a volume after this map.
pub fn is_flat(map: &DAffine3) -> bool {
    let largest =
        map.matrix3.to_cols_array().into_iter().fold(0.0, |most: f64, number| most.max(number.abs()));
    let volume = map.matrix3.determinant().abs();
    // also for what is no number
    !(largest > 1e-9 && volume > FLAT * largest.powi(3) && largest < 1e9)
}

impl Arranger<'_> {
    /// Arranges a mesh: triangles that cast shadows come first. `runs`: consecutive triangles, and the index of their material.
    pub fn mesh_of_runs(&self, surface: Surface, mut runs: Vec<(Range<usize>, u16)>) -> Mesh {
        let has = VertexData { uvs: !surface.uvs.is_empty(), alphas: !surface.alphas.is_empty() };
        let casts = |material: u16| self.casts_shadow_on(material, has);
        runs.sort_by_key(|(_, material)| self.rank(*material, has));
        let casting = runs.iter().filter(|(_, material)| casts(*material));
        let shadow_casting = casting.map(|(range, _)| range.len()).sum();
        let count = surface.triangles.len();
        let (mut triangles, mut material_of) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for (range, material) in runs {
            material_of.extend(iter::repeat_n(material, range.len()));
            triangles.extend_from_slice(&surface.triangles[range]);
        }
        let mesh = Mesh {
            geometry: Geometry::Triangles(Triangles {
                normals: surface.normals,
                uvs: surface.uvs,
                ..Triangles::new(surface.positions, triangles)
            }),
            shadow_casting,
            cut: self.cut_triangles(&material_of, has),
            material_of,
            groups: Arc::default(),
            details: Arc::new(Details {
                colors: surface.colors,
                second_uvs: surface.second_uvs,
                alphas: surface.alphas,
                ..Details::default()
            }),
        };
        self.with_details(mesh, &surface.tangents)
    }
}
