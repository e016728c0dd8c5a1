//! Assembles meshes from files: each OBJ once, with its materials looked up, overridden and settled.

use std::collections::{HashMap, HashSet};
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;

use super::map_statement::MapStatement;
use super::material_table::Override;
use super::mtl::{self, MtlFile, MtlMaterial};
use super::npy::{self, Array};
use super::objects::ObjectFiles;
use super::pictures::{PictureUse, Pictures};
use super::read_model::{ReadBefore, ReadModel, is_ply, name_material};
use super::shape_files::{self, Origins, ReadShapes, ShapeSource};
use super::varying::Settled;
use crate::digest::Digest;
use crate::input::{self, Input, Kind};
use crate::scene::error::Findings;
use crate::scene::given::meshes::Given;
use crate::scene::gltf::GltfFiles;
use crate::scene::keys::material::KdBesideMap;
use crate::scene::keys::spelling;
use crate::scene::mtlx::MtlxFiles;
use crate::scene::obj::lines::words;
use crate::scene::obj::{Named, ObjFile, OddNormals};
use crate::scene::paths::find_beside;
use crate::scene::usd::UsdFiles;
use crate::scene::warnings::limits;
use crate::scene::{Material, Mesh, SceneError, Texture};

/// Maximum number of materials of a shot: a triangle keeps 16 bits of index.
pub(super) const MOST_MATERIALS: usize = 1 << 16;

/// Maximum number of unknown materials, or odd statements, of a file that get a warning each.
const MOST_NAMED: usize = 10;

/// Meshes of the models, with their shared materials and textures.
#[derive(Default)]
pub(crate) struct Assembly {
    pub(in crate::scene) findings: Findings,
    pub(super) overrides: Vec<Override>,
    pub(in crate::scene) materials: Vec<Material>,
    pub(in crate::scene) pictures: Pictures,
    meshes: HashMap<PathBuf, Arc<Mesh>>,
    /// Origins in its file of the vertices of each of `meshes`.
    origins: HashMap<PathBuf, Arc<Origins>>,
    /// Objects of the files of `meshes`, and the parts that are models of their own.
    pub(super) of_objects: ObjectFiles,
    /// Deforming meshes, by file and the source of their shapes.
    deforming: HashMap<(PathBuf, ShapeSource), ReadShapes>,
    /// Indices of the quadrics' materials, by name.
    of_quadrics: HashMap<String, u16>,
    /// MaterialX files that were read.
    pub(super) mtlx: MtlxFiles,
    /// Parts of glTF files that were read.
    pub(in crate::scene) gltf: GltfFiles,
    /// Parts of USD files that were read.
    pub(in crate::scene) usd: UsdFiles,
    /// Files that were read so far, without pictures.
    pub(in crate::scene) files: Vec<PathBuf>,
    /// Digests of the files' contents.
    pub(in crate::scene) digests: Vec<Digest>,
    /// Names of all materials that files define, for hints.
    pub(in crate::scene) known_names: Vec<String>,
    pub(super) kd_beside_map: KdBesideMap,
    /// Model that was read in advance, until its mesh is asked for.
    read_before: Option<ReadModel>,
    /// Models that a program has handed over, until they are asked for.
    pub(in crate::scene) given_before: Option<Arc<Given>>,
}

/// Shared materials and textures of the models, and the files that they come from.
pub(crate) struct Assembled {
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub findings: Findings,
    /// All files that were read.
    pub files: Vec<PathBuf>,
    /// Digest of the files' contents.
    pub inputs: Digest,
}

/// A material of an MTL file, with the file.
pub(super) struct Defined {
    pub material: MtlMaterial,
    pub path: PathBuf,
}

impl Assembly {
    /// Creates an empty assembly. `strict`: stand-ins are errors.
    pub fn new(strict: bool, overrides: Vec<Override>) -> Self {
        Self { findings: Findings { strict, ..Findings::default() }, overrides, ..Self::default() }
    }

    /// Has `Kd` beside a `map_Kd` mean this.
    pub fn reading(self, kd_beside_map: KdBesideMap) -> Self {
        Self { kd_beside_map, ..self }
    }

    /// Has textures take so many bytes at most; others are in pages of a file.
    pub fn with_texture_memory(mut self, bytes: u64) -> Self {
        self.pictures.set_memory(bytes);
        self
    }

    /// Adds a file that was read before, so that it is not read again.
    pub fn with(self, file: ReadBefore) -> Self {
        match file {
            ReadBefore::Obj(model) => Self { read_before: Some(*model), ..self },
            ReadBefore::Given(given) => Self { given_before: Some(given), ..self },
            ReadBefore::Gltf(document) => Self { gltf: self.gltf.with(document), ..self },
            #[cfg(feature = "usd")]
            ReadBefore::Usd(file) => Self { usd: self.usd.with(file), ..self },
        }
    }

    /// Path of the model that was read in advance, until its mesh is asked for.
    pub fn path_read_before(&self) -> Option<PathBuf> {
        self.read_before.as_ref().map(|model| model.path.clone())
    }

    /// Adds a material with what varies of it. Returns its index.
    pub fn add_settled(&mut self, Settled { material, graphs }: Settled) -> Option<u16> {
        let computed = graphs.computed(&material).map(Arc::new);
        self.add_material(Material { computed, ..material })
    }

    /// Adds a material beside those of the models. Returns its index.
    pub fn add_material(&mut self, material: Material) -> Option<u16> {
        let index = u16::try_from(self.materials.len()).ok()?;
        self.materials.push(material);
        Some(index)
    }

    /// Finds the material of quadrics that the `[[material]]` tables define under `name`: its index, or the
    /// error in it. Without a name, that of the stand-in material. `None` if no table defines the name.
    pub fn material_named(&mut self, name: &str) -> Option<Result<u16, String>> {
        if !name.is_empty() && !self.is_overridden(name) {
            return None;
        }
        if let Some(known) = self.of_quadrics.get(name) {
            return Some(Ok(*known));
        }
        let line = 1;
        let shot = self.overrides.iter().find(|entry| entry.values.name == name);
        let path = shot.map_or(PathBuf::new(), |entry| entry.path.clone());
        let material = self.settle(&Named { name: name.to_string(), line }, None, &path);
        Some(material.map_err(|why| why.to_string()).and_then(|material| {
            let index = self.add_settled(material).ok_or("there are too many materials")?;
            self.of_quadrics.insert(name.to_string(), index);
            Ok(index)
        }))
    }

    /// Suggests a name like `name` among those that the `[[material]]` tables define, if there is one, as a
    /// question.
    pub fn hint_at_material(&self, name: &str) -> String {
        spelling::hint(name, self.overrides.iter().map(|entry| entry.values.name.as_str()))
    }

    /// Returns true if a material has graphs.
    pub fn has_graphs(&self) -> bool {
        self.materials.iter().any(|material| material.programs().next().is_some())
    }

    /// Returns true if a graph gives a material's colour.
    pub fn has_computed_color(&self, material: u16) -> bool {
        self.materials[usize::from(material)].has_computed_color()
    }

    /// Returns true if a material casts shadows.
    pub fn casts_shadow(&self, material: u16) -> bool {
        self.materials[usize::from(material)].casts_shadow()
    }

    /// The mesh of the OBJ file at `path`, in object space.
    ///
    /// # Errors
    /// Where the OBJ is wrong or one of its files cannot be read; in a strict load also where one is missing or odd.
    pub fn mesh(&mut self, path: &Path) -> Result<Arc<Mesh>, SceneError> {
        let key = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        if let Some(mesh) = self.meshes.get(&key) {
            return Ok(mesh.clone());
        }
        let ReadModel { mut obj, digest, unused, .. } = match self.read_before.take() {
            Some(model) if model.path == path => model,
            _ => ReadModel::at(path)?,
        };
        self.files.push(path.to_path_buf());
        self.digests.push(digest);
        self.origins.insert(key.clone(), Arc::new(Origins::new(&obj)));
        unused.into_iter().for_each(|message| self.findings.note(SceneError::new(path, message)));
        if is_ply(path) {
            name_material(&mut obj, path, |name| self.is_overridden(name));
        }
        if let Some(OddNormals { count, line }) = obj.odd_normals {
            let message = format!(
                "a normal is no number, of {count} in all: where they count, faces have normals of their own; export them again"
            );
            self.findings.stand_in(SceneError::new(path, message).at_line(line))?;
        }
        let (defined, complete) = self.libraries(&obj, path)?;
        let ids = self.settle_all(&obj, &defined, complete, path)?;
        let (mesh, objects) = self.mesh_of(obj, &ids);
        let mesh = Arc::new(mesh);
        self.of_objects.add(key.clone(), objects);
        if let Some(message) = limits::coarse(&mesh) {
            self.findings.note(SceneError::new(path, message));
        }
        self.meshes.insert(key, mesh.clone());
        Ok(mesh)
    }

    /// The mesh of the OBJ file at `path` with the shapes in `source`.
    ///
    /// # Errors Those of [`mesh`](Self::mesh), and those of the shapes.
    pub fn deforming(&mut self, path: &Path, source: ShapeSource) -> Result<ReadShapes, SceneError> {
        let mesh = self.mesh(path)?;
        let key = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        let origins = Arc::clone(&self.origins[&key]);
        if let Some(read) = self.deforming.get(&(key.clone(), source.clone())) {
            return Ok(read.clone());
        }
        let read = shape_files::read(&mesh, path, &origins, &source)?;
        self.files.extend(source.files());
        self.digests.push(read.digest);
        self.deforming.insert((key, source), read.clone());
        Ok(read)
    }

    /// Reads an array.
    ///
    /// # Errors
    /// Those of [`npy::read`].
    pub fn array(&mut self, path: &Path) -> Result<Array, SceneError> {
        let array = npy::read(path)?;
        self.files.push(path.to_path_buf());
        self.digests.push(array.digest);
        Ok(array)
    }

    /// Reads the lines of a text.
    ///
    /// # Errors
    /// Where it cannot be read, or is no text.
    pub fn lines(&mut self, path: &Path) -> Result<Vec<String>, SceneError> {
        let unreadable =
            |error: &dyn Display| SceneError::new(path, format!("the names cannot be read: {error}"));
        let bytes =
            input::open(path, Kind::Names).and_then(Input::read_all).map_err(|error| unreadable(&error))?;
        let text = std::str::from_utf8(&bytes).map_err(|_| unreadable(&"they must be UTF-8 text"))?;
        self.files.push(path.to_path_buf());
        self.digests.push(Digest::new(&bytes));
        Ok(text.lines().map(String::from).collect())
    }

    /// Reads the MTL files of `obj`. The flag says whether all were found.
    pub(super) fn libraries(
        &mut self,
        obj: &ObjFile,
        path: &Path,
    ) -> Result<(Vec<Defined>, bool), SceneError> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut defined = Vec::new();
        let mut complete = true;
        // some writers repeat the line before every object
        let (mut names, mut files) = (HashSet::new(), HashSet::new());
        for library in obj.libraries.iter().filter(|library| names.insert(library.name.as_str())) {
            let (mut found, missing) = library_files(folder, &library.name);
            // models are renamed together with their materials, and then name what was there before
            let own = (!missing.is_empty()).then(|| own_library(path)).flatten();
            let own = own.filter(|own| !files.contains(own) && !found.contains(own));
            complete &= missing.is_empty() || own.is_some();
            for name in missing {
                let place = |message| SceneError::new(path, message).at_line(library.line);
                let message = format!("the material file `{name}` cannot be found");
                match &own {
                    Some(own) => {
                        let own = own.file_name().unwrap_or_default().to_string_lossy();
                        self.findings.note(place(format!("{message}: `{own}` is read in its place")));
                    }
                    None => {
                        let message = format!("{message}; faces that need it are drawn grey");
                        self.findings.stand_in(place(message))?;
                    }
                }
            }
            found.extend(own);
            for file in found {
                if files.insert(file.clone()) {
                    self.read_library(file, &mut defined)?;
                }
            }
        }
        let names_materials = obj.materials.iter().any(|material| !material.name.is_empty());
        if let (true, true, Some(own)) = (obj.libraries.is_empty(), names_materials, own_library(path)) {
            let name = own.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let message =
                format!("it names no material file (mtllib): `{name}`, which is beside it, is read");
            self.findings.note(SceneError::new(path, message));
            self.read_library(own, &mut defined)?;
        }
        Ok((defined, complete))
    }

    /// Reads an MTL file, and adds what it defines.
    fn read_library(&mut self, file: PathBuf, defined: &mut Vec<Defined>) -> Result<(), SceneError> {
        let MtlFile { materials, oddities, unused, digest } = mtl::read(&file)?;
        self.files.push(file.clone());
        self.digests.push(digest);
        self.report_oddities(oddities, &file)?;
        self.note_contradictions(&materials, &file);
        for (line, message) in unused {
            self.findings.note(SceneError::new(&file, message).at_line(line));
        }
        self.known_names.extend(materials.iter().map(|material| material.name.clone()));
        defined.extend(materials.into_iter().map(|material| Defined { material, path: file.clone() }));
        Ok(())
    }

    fn report_oddities(&mut self, oddities: Vec<(usize, String)>, file: &Path) -> Result<(), SceneError> {
        let more = oddities.len().saturating_sub(MOST_NAMED);
        for (line, message) in oddities.into_iter().take(MOST_NAMED) {
            self.findings.stand_in(SceneError::new(file, message).at_line(line))?;
        }
        if more > 0 {
            self.findings.note(SceneError::new(file, format!("{more} more statements make no sense")));
        }
        Ok(())
    }

    fn note_contradictions(&mut self, materials: &[MtlMaterial], file: &Path) {
        if let Some(first) = materials.iter().find(|material| material.contradicts_itself()) {
            let message =
                format!("`d` and `Tr` of the material `{}` contradict each other: `d` counts", first.name);
            self.findings.note(SceneError::new(file, message).at_line(first.line));
        }
    }

    /// Settles the materials that `obj` uses. Returns the index into all materials for each of its names.
    fn settle_all(
        &mut self,
        obj: &ObjFile,
        defined: &[Defined],
        complete: bool,
        path: &Path,
    ) -> Result<Vec<u16>, SceneError> {
        // the last definition of a name counts
        let by_name: HashMap<&str, &Defined> =
            defined.iter().map(|defined| (defined.material.name.as_str(), defined)).collect();
        let mut used = vec![false; obj.materials.len()];
        obj.uses.iter().for_each(|(_, of)| used[of.material as usize] = true);
        let mut ids = vec![0; obj.materials.len()];
        let mut unknown = Vec::new();
        for (i, named) in obj.materials.iter().enumerate().filter(|(i, _)| used[*i]) {
            let found = by_name.get(named.name.as_str()).copied();
            if found.is_none() && complete && !named.name.is_empty() && !self.is_overridden(&named.name) {
                unknown.push(named);
            }
            let material = self.settle(named, found, path)?;
            ids[i] = self.add_material_of(path, material)?;
        }
        self.report_unknown(&unknown, defined, path)?;
        if !obj.colors.is_empty() {
            // scans have the same colours in both: twice they would be too dark
            let is_plain = |id: &&u16| {
                self.materials[usize::from(**id)].diffuse_map.is_none() && !self.has_computed_color(**id)
            };
            let plain: Vec<u16> = ids.iter().filter(is_plain).copied().collect();
            plain.into_iter().for_each(|id| self.color_vertices(id));
        }
        Ok(ids)
    }

    /// Has the colours of vertices show on a material: alone, where it is the one of faces without any.
    pub(in crate::scene) fn color_vertices(&mut self, material: u16) {
        let material = &mut self.materials[usize::from(material)];
        material.has_vertex_colors = true;
        if material.is_fallback() {
            (material.diffuse, material.ambient) = (Vec3::ONE, Vec3::ONE);
        }
    }

    /// Adds a material of the file at `path`. Returns its index.
    ///
    /// # Errors Too many materials.
    pub(in crate::scene) fn add_material_of(
        &mut self,
        path: &Path,
        material: Settled,
    ) -> Result<u16, SceneError> {
        let too_many = || format!("with this model the shot has more than {MOST_MATERIALS} materials");
        self.add_settled(material).ok_or_else(|| SceneError::new(path, too_many()))
    }

    fn report_unknown(
        &mut self,
        unknown: &[&Named],
        defined: &[Defined],
        path: &Path,
    ) -> Result<(), SceneError> {
        for named in unknown.iter().take(MOST_NAMED) {
            let near =
                spelling::hint(&named.name, defined.iter().map(|defined| defined.material.name.as_str()));
            let message =
                format!("no material file defines `{}`; its faces are drawn grey{near}", named.name);
            self.findings.stand_in(SceneError::new(path, message).at_line(named.line))?;
        }
        if unknown.len() > MOST_NAMED {
            let message = format!("{} more materials are not defined", unknown.len() - MOST_NAMED);
            self.findings.note(SceneError::new(path, message));
        }
        Ok(())
    }

    /// Index of the picture of `map`, a statement of the file `asking`.
    pub(in crate::scene) fn picture(
        &mut self,
        map: &MapStatement,
        asking: &Path,
        used: PictureUse,
    ) -> Result<u32, SceneError> {
        let folder = asking.parent().unwrap_or(Path::new(""));
        self.pictures.index_of(map, folder, asking, &mut self.findings, used)
    }

    /// Makes ambient light take the colours of diffuse light: exporters that know no ambient light write a Ka of 0.
    pub fn reflect_ambient_light_as_diffuse(&mut self) {
        self.materials.iter_mut().for_each(|material| material.ambient = material.diffuse);
    }

    /// Records a warning if no material reflects ambient light. `finding` adds the place to the description
    /// of the problem.
    pub fn note_without_ambient(&mut self, finding: impl FnOnce(&str) -> SceneError) {
        if self.materials.iter().all(|material| material.ambient == Vec3::ZERO) {
            self.findings.note(finding("the ambient light shows nowhere: Ka is 0 in all materials"));
        }
    }

    /// Returns the assembled materials, textures, files and findings.
    pub fn finish(mut self) -> Assembled {
        self.files.extend(self.pictures.files().cloned());
        let inputs = Digest::of_all(self.digests.into_iter().chain([self.pictures.digest()]));
        let (materials, textures) = (self.materials, self.pictures.textures);
        Assembled { materials, textures, findings: self.findings, files: self.files, inputs }
    }
}

/// The MTL file beside an OBJ file that has its name, if there is one.
fn own_library(obj: &Path) -> Option<PathBuf> {
    if is_ply(obj) {
        return None;
    }
    let name = obj.with_extension("mtl");
    find_beside(obj.parent().unwrap_or(Path::new("")), &name.file_name()?.to_string_lossy())
}

/// The files that a `mtllib` line means: one name that may hold spaces, or several, or several that may
/// hold spaces. Then the names for which there is no file. A name may stand between quotes.
fn library_files(folder: &Path, text: &str) -> (Vec<PathBuf>, Vec<String>) {
    let quoted = text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
    if let Some(path) = quoted.and_then(|name| find_beside(folder, name)) {
        return (vec![path], Vec::new());
    }
    let words: Vec<String> =
        words(text.as_bytes()).map(|word| String::from_utf8_lossy(word).into_owned()).collect();
    let (mut found, mut missing) = (Vec::new(), Vec::new());
    if let Some(path) = find_beside(folder, text) {
        return (vec![path], missing);
    }
    let mut at = 0;
    while at < words.len() {
        // the longest name that there is a file for; limited, for lines of a thousand words
        let longest = words.len().min(at + 16);
        let file = (at + 1..=longest)
            .rev()
            .find_map(|end| Some((end, find_beside(folder, &words[at..end].join(" "))?)));
        at = match file {
            Some((end, path)) => {
                found.push(path);
                end
            }
            None => {
                missing.push(words[at].clone());
                at + 1
            }
        };
    }
    if found.is_empty() && !text.is_empty() {
        missing = vec![text.to_string()];
    }
    (found, missing)
}
