//! Meshes of OBJ files that stand for cages: what `subdivision` of a `[[model]]` asks for.

use std::path::Path;
use std::sync::Arc;

use super::{MeshFiles, known_as};
use crate::scene::cage::Cage;
use crate::scene::import::Import;
use crate::scene::import::obj::cage::{ObjCage, read_cage};
use crate::scene::{Mesh, SceneError};
use crate::subdivision::Scheme;

impl MeshFiles {
    /// The mesh of the OBJ file at `path`, which was read before, with its shapes if it has any, as one that stands for its cage.
    ///
    /// # Errors Tags of the cage that make no sense.
    pub fn caged(
        &mut self,
        import: &mut Import,
        path: &Path,
        mesh: Arc<Mesh>,
        scheme: Scheme,
    ) -> Result<Arc<Mesh>, SceneError> {
        let key = (Arc::as_ptr(&mesh), scheme);
        if let Some(caged) = self.caged.get(&key) {
            return Ok(caged.clone());
        }
        let file = &self.files[&known_as(path)];
        let ObjCage { cage, names, unused } = read_cage(path, scheme)?;
        unused.into_iter().for_each(|message| import.findings.note(SceneError::new(path, message)));
        let ids: Vec<u16> = names.iter().map(|name| file.materials.get(name).copied().unwrap_or(0)).collect();
        let material_of = cage.material_of.iter().map(|number| ids[usize::from(*number)]).collect();
        let shapes = mesh.shapes().map_or(Vec::new(), |shapes| {
            let of_points = |positions: &Vec<[f32; 3]>| {
                let mut points = cage.points.clone();
                for (position, origin) in positions.iter().zip(&file.origins.of_vertex) {
                    if let Some(point) = points.get_mut(*origin as usize) {
                        *point = *position;
                    }
                }
                points
            };
            shapes.list().iter().map(of_points).collect()
        });
        let cage = Cage { material_of, shapes, ..cage };
        let caged = Arc::new(Mesh::clone(&mesh).with_cage(Some(Arc::new(cage))));
        self.caged.insert(key, caged.clone());
        Ok(caged)
    }
}
