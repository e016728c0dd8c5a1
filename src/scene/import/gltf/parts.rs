//! The models of a glTF file: one for each node that shows a mesh.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec3};
use serde::Deserialize;

use super::animation::Clip;
use super::bake;
use super::document::{Document, extension};
use super::geometry::{self, Geometry};
use super::json::Node;
use super::materials::{OfVertices, VertexAlpha, is_unlit, takes_alpha};
use super::nodes::{Tree, unit};
use super::reading::Reading;
use super::skin;
use crate::animation::{ShapeTrack, Track, Visibility};
use crate::digest::Digest;
use crate::scene::import::deformed;
use crate::scene::import::part_of_file::{NodeTrack, PartOfFile, Surface, is_flat};
use crate::scene::import::{Import, Inputs};
use crate::scene::{Mesh, SceneError};

/// What tells materials apart: file, number, and the bits of the alpha and colour of vertices.
type MaterialKey = (PathBuf, Option<usize>, Option<u32>, [u32; 3]);

/// Files that were read, and what was made of them.
#[derive(Default)]
pub(in crate::scene) struct GltfFiles {
    /// Files that were read, and not asked for yet.
    before: HashMap<PathBuf, Arc<Document>>,
    documents: HashMap<PathBuf, Arc<Document>>,
    /// Meshes by file and number; none without triangles.
    meshes: HashMap<(PathBuf, usize), Option<Arc<Mesh>>>,
    /// Indices of materials.
    materials: HashMap<MaterialKey, u16>,
    /// Models by file, name of the animation, and frame rate.
    parts: HashMap<(PathBuf, Option<String>, u64), Arc<Vec<PartOfFile>>>,
    /// True if frames are exposed over time, so that shapes between them are seen.
    pub is_shutter_open: bool,
}

/// Shapes that a mesh has in each frame where they are seen between frames as well: joints do not bend along straight lines.
const SHAPES_A_BLURRED_FRAME: u32 = 4;

impl GltfFiles {
    /// Adds a file that was read in advance.
    pub fn with(mut self, document: Arc<Document>) -> Self {
        self.before.insert(known_as(&document.path), document);
        self
    }
}

/// Mesh that a node shows, and its shapes over time, if it deforms.
type ShownMesh = (Arc<Mesh>, Option<ShapeTrack>);

/// Places of the copies of a node's mesh.
#[derive(Debug, Deserialize)]
struct Instancing {
    attributes: BTreeMap<String, usize>,
}

pub(super) fn known_as(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

impl GltfFiles {
    /// The models of the glTF file at `path`, moved by its animation of this name (none: the first) at `rate` frames a second.
    ///
    /// # Errors A file that cannot be read, is damaged, or shows nothing.
    pub fn models(
        &mut self,
        import: &mut Import,
        path: &Path,
        animation: Option<&str>,
        rate: f64,
    ) -> Result<Arc<Vec<PartOfFile>>, SceneError> {
        let known = known_as(path);
        let key = (known.clone(), animation.map(String::from), rate.to_bits());
        if let Some(parts) = self.parts.get(&key) {
            return Ok(parts.clone());
        }
        let document = self.document(&mut import.inputs, path, &known)?;
        let tree = Tree::new(&document)?;
        let clip = Clip::read(&document, animation, rate)?;
        if !clip.channels.is_empty() {
            import.inputs.depend_on(Digest::new(&rate.to_le_bytes()));
        }
        let parts = Arc::new(self.parts_of(import, &document, (&tree, &clip))?);
        for message in document.take_unused() {
            import.findings.note(document.fault(message));
        }
        if parts.is_empty() {
            let message = "it shows no triangles: points, lines and empty nodes alone cannot be rendered";
            return Err(document.fault(message));
        }
        self.parts.insert(key, parts.clone());
        Ok(parts)
    }

    /// The file at `path`, `known` by its canonical path, read once.
    ///
    /// # Errors One that cannot be read, or is damaged.
    pub(super) fn document(
        &mut self,
        inputs: &mut Inputs,
        path: &Path,
        known: &Path,
    ) -> Result<Arc<Document>, SceneError> {
        if let Some(document) = self.documents.get(known) {
            return Ok(document.clone());
        }
        let document = match self.before.remove(known) {
            Some(document) => document,
            None => Arc::new(Document::open(path)?),
        };
        inputs.add(document.files.iter().cloned(), document.digest);
        self.documents.insert(known.to_path_buf(), document.clone());
        Ok(document)
    }

    fn parts_of(
        &mut self,
        import: &mut Import,
        document: &Document,
        (tree, clip): (&Tree, &Clip),
    ) -> Result<Vec<PartOfFile>, SceneError> {
        let nodes = &document.json.nodes;
        let shown: Vec<(usize, usize)> =
            tree.shown.iter().filter_map(|node| Some((*node, nodes[*node].mesh?))).collect();
        let is_rigid = |node: &usize| nodes[*node].skin.is_none();
        let rigid: BTreeSet<usize> = shown.iter().map(|(node, _)| *node).filter(is_rigid).collect();
        let mut tracks = bake::tracks(document, tree, clip, &rigid)?;
        let mut parts = Vec::new();
        for (number, mesh) in shown {
            let node = &nodes[number];
            // a mesh with a skin is where its joints are
            let at_root = NodeTrack { map: Track::constant(DAffine3::IDENTITY), visible: Visibility::ALWAYS };
            let track = if node.skin.is_some() { Some(at_root) } else { tracks.remove(&number) };
            // without a track it is scaled to nothing for ever
            let Some(NodeTrack { map, visible }) = track else { continue };
            let Some((mesh, shapes)) = self.shown_mesh(import, document, (tree, clip), number, mesh)? else {
                continue;
            };
            let name = node.name.clone().unwrap_or_else(|| format!("node {number}"));
            let Some(copies) = copies(document, node)? else {
                parts.push(PartOfFile {
                    name,
                    mesh,
                    map,
                    visible,
                    shapes,
                    ray_visibility: Default::default(),
                    linked: Default::default(),
                });
                continue;
            };
            for (i, copy) in copies.into_iter().enumerate() {
                let (map, mesh) = (map.clone().map(|map| map * copy), mesh.clone());
                let (visible, shapes) = (visible.clone(), shapes.clone());
                parts.push(PartOfFile {
                    name: format!("{name}/{i}"),
                    mesh,
                    map,
                    visible,
                    shapes,
                    ray_visibility: Default::default(),
                    linked: Default::default(),
                });
            }
        }
        Ok(parts)
    }

    /// The mesh that a node shows, with its shapes over time. `None` without triangles.
    fn shown_mesh(
        &mut self,
        import: &mut Import,
        document: &Document,
        (tree, clip): (&Tree, &Clip),
        node: usize,
        mesh: usize,
    ) -> Result<Option<ShownMesh>, SceneError> {
        let json = document.get(&document.json.meshes, mesh, "mesh")?;
        let has_targets = json.primitives.iter().any(|primitive| !primitive.targets.is_empty());
        if document.json.nodes[node].skin.is_none() && !has_targets {
            return Ok(self.rigid_mesh(import, document, mesh)?.map(|mesh| (mesh, None)));
        }
        let geometry = geometry::read(document, mesh)?;
        if geometry.triangles.is_empty() {
            return Ok(None);
        }
        let a_frame = if self.is_shutter_open { SHAPES_A_BLURRED_FRAME } else { 1 };
        let shapes = skin::shapes(document, (tree, clip), node, &geometry, a_frame)?;
        let open = deformed::most_open(&geometry.positions, &geometry.triangles, &shapes);
        let geometry = geometry.without_closed(open.among(&shapes));
        if geometry.triangles.is_empty() {
            return Ok(None);
        }
        let own = self.arranged(import, document, geometry)?;
        let places = deformed::places(own.triangles().positions.as_slice(), &shapes.list);
        let (mesh, shapes) = deformed::with_shapes(own, shapes, open, &places);
        Ok(Some((Arc::new(mesh), shapes)))
    }

    /// A mesh that does not deform: nodes share it.
    fn rigid_mesh(
        &mut self,
        import: &mut Import,
        document: &Document,
        mesh: usize,
    ) -> Result<Option<Arc<Mesh>>, SceneError> {
        let key = (known_as(&document.path), mesh);
        if let Some(known) = self.meshes.get(&key) {
            return Ok(known.clone());
        }
        let geometry = geometry::read(document, mesh)?.without_closed(None);
        let mesh = match geometry.triangles.is_empty() {
            true => None,
            false => Some(Arc::new(self.arranged(import, document, geometry)?)),
        };
        self.meshes.insert(key, mesh.clone());
        Ok(mesh)
    }

    /// Looks up the materials of a geometry, and puts the triangles that cast shadows first.
    fn arranged(
        &mut self,
        import: &mut Import,
        document: &Document,
        mut geometry: Geometry,
    ) -> Result<Mesh, SceneError> {
        let mut runs = Vec::with_capacity(geometry.uses.len());
        let mut begin = 0;
        for (count, material) in geometry.uses.clone() {
            let range = begin..begin + count;
            begin += count;
            let alpha = match takes_alpha(document, material)? {
                true => geometry.alpha_of(range.clone()),
                false => VertexAlpha::OPAQUE,
            };
            let colored = if !geometry.colors.is_empty() && is_unlit(document, material) {
                let (colored, is_exact) = geometry.by_tint(range);
                if !is_exact {
                    document.leave_out(
                        "unlit materials have one colour a triangle, the mean of its vertices (COLOR_0)",
                    );
                }
                colored
            } else {
                vec![(range, Vec3::ONE)]
            };
            for (range, tint) in colored {
                let index = self.material(import, document, (material, OfVertices { alpha, tint }))?;
                if !geometry.colors.is_empty() && !import.surfaces.has_computed_color(index) {
                    import.surfaces.color_vertices(index);
                }
                runs.push((range, index));
            }
        }
        let Geometry { positions, normals, uvs, second_uvs, colors, mut alphas, tangents, triangles, .. } =
            geometry;
        let materials = &import.surfaces.materials;
        let cuts = |index: u16| materials[usize::from(index)].cutout.is_some_and(|cut| cut.by_vertices);
        if !runs.iter().any(|(_, index)| cuts(*index)) {
            alphas = Vec::new();
        }
        let surface = Surface { positions, normals, uvs, second_uvs, colors, alphas, tangents, triangles };
        Ok(import.arranger().mesh_of_runs(surface, runs))
    }

    /// Index of a material on triangles of such vertices, which is settled once.
    fn material(
        &mut self,
        import: &mut Import,
        document: &Document,
        (material, vertices): (Option<usize>, OfVertices),
    ) -> Result<u16, SceneError> {
        let alpha = if let VertexAlpha::Even(alpha) = vertices.alpha { Some(alpha.to_bits()) } else { None };
        let key = (known_as(&document.path), material, alpha, vertices.tint.to_array().map(f32::to_bits));
        if let Some(index) = self.materials.get(&key) {
            return Ok(*index);
        }
        let index = Reading { document, import }.settle(material, vertices)?;
        self.materials.insert(key, index);
        Ok(index)
    }
}

/// Places of a node's copies, if it has any (EXT_mesh_gpu_instancing).
pub(super) fn copies(document: &Document, node: &Node) -> Result<Option<Vec<DAffine3>>, SceneError> {
    let read: Option<Instancing> = extension(document, &node.extensions, "EXT_mesh_gpu_instancing")?;
    let Some(Instancing { attributes }) = read else { return Ok(None) };
    let three =
        |name: &str| attributes.get(name).map(|accessor| document.vectors::<3>(*accessor)).transpose();
    let (translations, scales) = (three("TRANSLATION")?, three("SCALE")?);
    let rotations =
        attributes.get("ROTATION").map(|accessor| document.vectors::<4>(*accessor)).transpose()?;
    let counts = [
        translations.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
    ];
    let count = counts.into_iter().flatten().min().unwrap_or(0);
    let vector = |list: &Option<Vec<[f32; 3]>>, i: usize, default: DVec3| {
        list.as_ref().map_or(default, |list| DVec3::from(list[i].map(f64::from)))
    };
    let place = |i: usize| {
        let rotation = rotations
            .as_ref()
            .map_or(DQuat::IDENTITY, |list| unit(DQuat::from_array(list[i].map(f64::from))));
        let (scale, translation) = (vector(&scales, i, DVec3::ONE), vector(&translations, i, DVec3::ZERO));
        DAffine3::from_scale_rotation_translation(scale, rotation, translation)
    };
    let places: Vec<DAffine3> = (0..count).map(place).filter(|map| !is_flat(map)).collect();
    if !places.iter().all(DAffine3::is_finite) {
        return Err(document
            .fault("a copy (EXT_mesh_gpu_instancing) is at a place that is not finite: export it again"));
    }
    Ok(Some(places))
}
