//! Meshes of files that hold one: OBJ files with their MTL files, and PLY files. Each is read once.

mod black;
mod cages;
mod libraries;
mod mesh_of_obj;
mod obj_parts;
mod objects;
mod point_cache;
pub mod read_model;
pub mod shape_files;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::libraries::{Defined, libraries};
use self::mesh_of_obj::mesh_of;
use self::objects::Parts;
use self::read_model::{ReadModel, is_ply, name_material};
use self::shape_files::{Origins, ReadShapes, ShapeSource};
use crate::scene::import::Import;
use crate::scene::import::faces::{Named, OddNormals, TriangleSoup};
use crate::scene::import::mtl::statements::Statements;
use crate::scene::keys::material::KdBesideMap;
use crate::scene::keys::spelling;
use crate::scene::mesh::Groups;
use crate::scene::warnings::limits;
use crate::scene::{Mesh, SceneError};
use crate::subdivision::Scheme;

/// Maximum number of unknown materials of a file that get a warning each.
const MOST_NAMED: usize = 10;

/// Files that were read so far, and what was made of them.
#[derive(Default)]
pub(in crate::scene) struct MeshFiles {
    /// Meaning of `Kd` beside a `map_Kd`.
    kd_beside_map: KdBesideMap,
    /// Model that was read in advance, until its mesh is asked for.
    before: Option<ReadModel>,
    /// Files by their canonical paths.
    files: HashMap<PathBuf, MeshFile>,
    /// Objects and groups that are models of their own.
    parts: Parts,
    /// Meshes that stand for cages, by the address of the mesh that the file is by itself.
    caged: HashMap<(*const Mesh, Scheme), Arc<Mesh>>,
    /// Deforming meshes, by file and the source of their shapes.
    deforming: HashMap<(PathBuf, ShapeSource), ReadShapes>,
}

/// A file that was read.
struct MeshFile {
    /// Its mesh, in object space.
    pub mesh: Arc<Mesh>,
    /// Indices of its materials, by their names in the file.
    materials: HashMap<String, u16>,
    /// Objects of the mesh, which are runs of its triangles as groups are.
    pub objects: Groups,
    /// Origins in the file of the mesh's vertices.
    origins: Origins,
}

/// Name of a file among those that were read.
fn known_as(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

impl MeshFiles {
    /// Creates files of which none was read. `kd_beside_map`: meaning of `Kd` beside a `map_Kd`.
    pub fn new(kd_beside_map: KdBesideMap) -> Self {
        Self { kd_beside_map, ..Self::default() }
    }

    /// Adds a file that was read before, so that it is not read again.
    pub fn with(self, before: ReadModel) -> Self {
        Self { before: Some(before), ..self }
    }

    /// Path of the model that was read in advance, until its mesh is asked for.
    pub fn path_read_before(&self) -> Option<PathBuf> {
        self.before.as_ref().map(|model| model.path.clone())
    }

    /// The mesh of the file at `path`, in object space.
    ///
    /// # Errors
    /// Where the file is wrong or one of its files cannot be read; in a strict load also where one is missing or odd.
    pub fn mesh(&mut self, import: &mut Import, path: &Path) -> Result<Arc<Mesh>, SceneError> {
        let known = known_as(path);
        if let Some(file) = self.files.get(&known) {
            return Ok(file.mesh.clone());
        }
        let model = match self.before.take() {
            Some(model) if model.path == path => model,
            _ => ReadModel::at(path)?,
        };
        let file = MeshFile::of(import, model, self.kd_beside_map)?;
        let mesh = file.mesh.clone();
        self.files.insert(known, file);
        Ok(mesh)
    }

    /// The mesh of the file at `path` with the shapes in `source`.
    ///
    /// # Errors Those of [`mesh`](Self::mesh), and those of the shapes.
    pub fn deforming(
        &mut self,
        import: &mut Import,
        path: &Path,
        source: ShapeSource,
    ) -> Result<ReadShapes, SceneError> {
        let mesh = self.mesh(import, path)?;
        let known = known_as(path);
        if let Some(read) = self.deforming.get(&(known.clone(), source.clone())) {
            return Ok(read.clone());
        }
        let read = shape_files::read(&mesh, path, &self.files[&known].origins, &source)?;
        import.inputs.add(source.files(), read.digest);
        self.deforming.insert((known, source), read.clone());
        Ok(read)
    }
}

impl MeshFile {
    /// Looks up the materials of a file that was read, and makes its mesh.
    fn of(import: &mut Import, model: ReadModel, kd_beside_map: KdBesideMap) -> Result<Self, SceneError> {
        let ReadModel { mut obj, digest, unused, path } = model;
        let path = path.as_path();
        import.inputs.add([path.to_path_buf()], digest);
        let origins = Origins::new(&obj);
        unused.into_iter().for_each(|message| import.findings.note(SceneError::new(path, message)));
        if is_ply(path) {
            name_material(&mut obj, path, |name| import.surfaces.is_overridden(name));
        }
        if let Some(OddNormals { count, line }) = obj.odd_normals {
            let message = format!(
                "a normal is no number, of {count} in all: where they count, faces have normals of their own; export them again"
            );
            import.findings.stand_in(SceneError::new(path, message).at_line(line))?;
        }
        let (defined, complete) = libraries(import, &obj, path)?;
        let defined = Definitions { all: &defined, complete, kd_beside_map };
        let ids = defined.settle_all(import, &obj, path)?;
        let named = obj.materials.iter().zip(&ids);
        let materials = named.map(|(named, id)| (named.name.clone(), *id)).collect();
        let (mesh, objects) = mesh_of(import.arranger(), obj, &ids);
        if let Some(message) = limits::coarse(&mesh) {
            import.findings.note(SceneError::new(path, message));
        }
        Ok(Self { mesh: Arc::new(mesh), materials, objects, origins })
    }
}

/// Definitions of the materials that a file names.
struct Definitions<'a> {
    all: &'a [Defined],
    /// True if all of its material files were found.
    complete: bool,
    kd_beside_map: KdBesideMap,
}

impl Definitions<'_> {
    /// Settles the materials that `obj` uses. Returns the index into all materials for each of its names.
    fn settle_all(
        &self,
        import: &mut Import,
        obj: &TriangleSoup,
        path: &Path,
    ) -> Result<Vec<u16>, SceneError> {
        // the last definition of a name counts
        let by_name: HashMap<&str, &Defined> =
            self.all.iter().map(|defined| (defined.material.name.as_str(), defined)).collect();
        let mut used = vec![false; obj.materials.len()];
        obj.uses.iter().for_each(|(_, of)| used[of.material as usize] = true);
        let mut ids = vec![0; obj.materials.len()];
        let mut unknown = Vec::new();
        for (i, named) in obj.materials.iter().enumerate().filter(|(i, _)| used[*i]) {
            let found = by_name.get(named.name.as_str()).copied();
            let is_known = found.is_some() || import.surfaces.is_overridden(&named.name);
            if !is_known && self.complete && !named.name.is_empty() {
                unknown.push(named);
            }
            let (stated, own) = match found {
                // what the shot file says means what the format says
                Some(defined) => (defined.meant(self.kd_beside_map), defined.path.as_path()),
                None => (Statements { name: named.name.clone(), ..Statements::default() }, path),
            };
            let surface = import.stated_surface(stated, own)?;
            let settled = import.settle(surface);
            ids[i] = import.surfaces.add_of(path, settled)?;
        }
        self.report_unknown(import, &unknown, path)?;
        if !obj.colors.is_empty() {
            color_vertices(import, &ids);
        }
        Ok(ids)
    }

    fn report_unknown(&self, import: &mut Import, unknown: &[&Named], path: &Path) -> Result<(), SceneError> {
        for named in unknown.iter().take(MOST_NAMED) {
            let near =
                spelling::hint(&named.name, self.all.iter().map(|defined| defined.material.name.as_str()));
            let message =
                format!("no material file defines `{}`; its faces are drawn grey{near}", named.name);
            import.findings.stand_in(SceneError::new(path, message).at_line(named.line))?;
        }
        if unknown.len() > MOST_NAMED {
            let message = format!("{} more materials are not defined", unknown.len() - MOST_NAMED);
            import.findings.note(SceneError::new(path, message));
        }
        Ok(())
    }
}

/// Has the colours of vertices show on the materials at these indices that have no colours from place to place.
fn color_vertices(import: &mut Import, ids: &[u16]) {
    let surfaces = &mut import.surfaces;
    // scans have the same colours in both: twice they would be too dark
    let is_plain = |id: &&u16| {
        surfaces.materials[usize::from(**id)].diffuse_map.is_none() && !surfaces.has_computed_color(**id)
    };
    let plain: Vec<u16> = ids.iter().filter(is_plain).copied().collect();
    plain.into_iter().for_each(|id| surfaces.color_vertices(id));
}
