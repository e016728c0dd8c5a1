//! The models of a USD file: one for each mesh that it shows.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::file::{ShownMesh, UsdFile, UsdMesh};
use super::reading::Reading;
use crate::animation::ShapeTrack;
use crate::scene::import::Import;
use crate::scene::import::curves::{self, CurveSet};
use crate::scene::import::deformed;
use crate::scene::import::deformed::Distinct;
use crate::scene::import::part_of_file::{NodeTrack, PartOfFile, Surface};
use crate::scene::{Mesh, SceneError};

/// Files that were read, and what was made of them.
#[derive(Default)]
pub(in crate::scene) struct UsdFiles {
    /// Files that were read, and not asked for yet.
    before: HashMap<PathBuf, Arc<UsdFile>>,
    parts: HashMap<PathBuf, Arc<Vec<PartOfFile>>>,
}

impl UsdFiles {
    /// Adds a file that was read in advance.
    pub fn with(mut self, file: Arc<UsdFile>) -> Self {
        self.before.insert(known_as(&file.path), file);
        self
    }
}

/// Names of materials that are told for one thing that is left out, at most.
const MOST_TOLD: usize = 3;

/// A mesh, and its shapes over time, if it deforms.
type BuiltMesh = (Arc<Mesh>, Option<ShapeTrack>);

fn known_as(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

impl UsdFiles {
    /// The models of the USD file at `path`.
    ///
    /// # Errors A file that cannot be read, is damaged, or shows nothing; in a strict load also one that names what is missing.
    pub fn models(&mut self, import: &mut Import, path: &Path) -> Result<Arc<Vec<PartOfFile>>, SceneError> {
        let known = known_as(path);
        if let Some(parts) = self.parts.get(&known) {
            return Ok(parts.clone());
        }
        let file = match self.before.remove(&known) {
            Some(file) => file,
            None => Arc::new(UsdFile::open(path)?),
        };
        import.inputs.add(file.files.iter().cloned(), file.digest);
        let parts = Arc::new(Reading::new(&file, import).models()?);
        self.parts.insert(known, parts.clone());
        Ok(parts)
    }
}

impl Reading<'_> {
    /// The models of the file.
    fn models(mut self) -> Result<Vec<PartOfFile>, SceneError> {
        let built = self.meshes()?;
        let Self { file, import, unused, left_out } = self;
        let parts: Vec<PartOfFile> =
            file.content.shown.iter().filter_map(|shown| part(shown, &built)).collect();
        for defect in &file.content.defects {
            import.findings.stand_in(file.fault(defect))?;
        }
        let unused: BTreeSet<&str> =
            unused.into_iter().chain(file.content.unused.iter().map(String::as_str)).collect();
        unused.into_iter().for_each(|message| import.findings.note(file.fault(message)));
        for (said, materials) in left_out {
            import.findings.note(file.fault(format!("{}: {said}", named(&materials))));
        }
        if parts.is_empty() {
            let why = file.content.defects.first().map_or(String::new(), |defect| format!(" ({defect})"));
            return Err(
                file.fault(format!("it shows no meshes with triangles, which alone can be rendered{why}"))
            );
        }
        Ok(parts)
    }

    /// Builds the meshes of the file.
    fn meshes(&mut self) -> Result<Vec<Option<BuiltMesh>>, SceneError> {
        let file = self.file;
        let mut materials: HashMap<Option<usize>, u16> = HashMap::new();
        let mut built = Vec::with_capacity(file.content.meshes.len());
        for mesh in &file.content.meshes {
            if let Some(curves) = &mesh.curves {
                built.push(self.curves(mesh, curves, &mut materials)?);
                continue;
            }
            let mut shapes = Distinct::default();
            mesh.shapes.iter().for_each(|(frame, points)| shapes.add(*frame, mesh.of_vertices(points)));
            let (mut triangles, mut uses) = (mesh.triangles.clone(), mesh.uses.clone());
            let kept = (!shapes.list.is_empty())
                .then(|| deformed::most_open(&mesh.positions, &mesh.triangles, &shapes));
            if let Some(kept) = kept {
                let positions = kept.among(&shapes).unwrap_or(&mesh.positions);
                deformed::remove_closed(positions, &mut triangles, &mut uses);
            }
            if triangles.is_empty() {
                built.push(None);
                continue;
            }
            let (mut runs, mut begin) = (Vec::with_capacity(uses.len()), 0);
            for (count, surface) in &uses {
                let index = match materials.get(surface) {
                    Some(index) => *index,
                    None => {
                        let index = self.material(*surface)?;
                        materials.insert(*surface, index);
                        index
                    }
                };
                runs.push((begin..begin + count, index));
                begin += count;
            }
            let UsdMesh { positions, normals, uvs, second_uvs, colors, point_of, .. } = mesh;
            let surface = Surface {
                positions: positions.clone(),
                normals: normals.clone(),
                uvs: uvs.clone(),
                second_uvs: second_uvs.clone(),
                colors: colors.clone(),
                triangles,
                ..Surface::default()
            };
            let own = self.import.arranger().mesh_of_runs(surface, runs);
            let (mesh, shapes) = match kept {
                Some(kept) => deformed::with_shapes(own, shapes, kept, point_of),
                None => (own, None),
            };
            built.push(Some((Arc::new(mesh), shapes)));
        }
        Ok(built)
    }
}

impl Reading<'_> {
    /// Builds curves, if there are any to be drawn.
    fn curves(
        &mut self,
        mesh: &UsdMesh,
        curves: &CurveSet,
        materials: &mut HashMap<Option<usize>, u16>,
    ) -> Result<Option<BuiltMesh>, SceneError> {
        let surface = mesh.uses.first().and_then(|(_, surface)| *surface);
        let material = match materials.get(&surface) {
            Some(index) => *index,
            None => {
                let index = self.material(surface)?;
                materials.insert(surface, index);
                index
            }
        };
        match curves::mesh_of(self.import, &self.file.path, curves, None, material) {
            Ok(mesh) => Ok(Some((Arc::new(mesh), None))),
            Err(why) => {
                self.import.findings.stand_in(why)?;
                Ok(None)
            }
        }
    }
}

/// Names of materials, as they are told.
fn named(materials: &BTreeSet<String>) -> String {
    let first: Vec<String> = materials.iter().take(MOST_TOLD).map(|name| format!("`{name}`")).collect();
    match materials.len() {
        1 => format!("material {}", first[0]),
        count if count > MOST_TOLD => {
            format!("materials {} and {} more", first.join(", "), count - MOST_TOLD)
        }
        _ => format!("materials {}", first.join(", ")),
    }
}

/// Model of a shown mesh. `None` if it is scaled to nothing for ever, or has no triangles.
fn part(shown: &ShownMesh, built: &[Option<BuiltMesh>]) -> Option<PartOfFile> {
    let keys = match shown.map.is_constant() {
        true => vec![(1.0, shown.map.at(1.0))],
        false => shown.map.frames().zip(shown.map.values()).collect(),
    };
    let NodeTrack { map, visible } = NodeTrack::through(keys, &[])?;
    let (mesh, shapes) = built[shown.mesh].clone()?;
    let visible = visible.and(&shown.visible);
    Some(PartOfFile {
        name: shown.name.clone(),
        mesh,
        map,
        visible,
        shapes,
        ray_visibility: Default::default(),
    })
}
