//! `[[material]]` tables of shot files: what they put in place of the materials of models.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::of_surface::OfSurface;
use super::varying::{Graphs, computed_by};
use crate::scene::cutout::Cutout;
use crate::scene::import::Import;
use crate::scene::import::mtlx::{self, Document};
use crate::scene::import::pictures::Named;
use crate::scene::import::statements::Statements;
use crate::scene::import::statements::maps::{ByUse, MapUse};
use crate::scene::keys::spelling;
use crate::scene::material::{Bump, Computes, NormalMap};
use crate::scene::{Material, SceneError};

/// What the `[[material]]` tables of a name put in place of a material's own.
#[derive(Default)]
pub(crate) struct Overridden {
    /// Shot file for each picture that it states.
    pub places: ByUse<PathBuf>,
    /// Graphs of its colour and its other parameters: no pictures of these count then.
    graphs: Graphs,
    /// Heights that bend its normals.
    bump: Option<Bump>,
    /// Picture of its normals.
    normals: Option<NormalMap>,
    /// True if nothing of the material's own counts: neither pictures nor numbers.
    pub is_whole: bool,
}

impl Overridden {
    /// Gives a material the normals of a file that counts in place of its own. Returns its graphs.
    pub fn apply(&self, material: &mut Material) -> Graphs {
        if self.is_whole {
            (material.bump, material.normal_map) = (self.bump.clone(), self.normals);
            let is_veil = self.graphs.has(Computes::Opacity) && material.can_blend();
            material.cutout = is_veil.then(|| Cutout::by_graph(material.opacity()));
        }
        self.graphs.clone()
    }
}

impl Import {
    /// Finds the material that the `[[material]]` tables define under `name`, without any model: its index, or the error in it. Without
    /// a name, that of the stand-in material. `None` if no table defines the name.
    pub fn material_of_table(&mut self, name: &str) -> Option<Result<u16, String>> {
        if !name.is_empty() && !self.surfaces.is_overridden(name) {
            return None;
        }
        if let Some(known) = self.surfaces.of_tables.get(name) {
            return Some(Ok(*known));
        }
        let shot = self.surfaces.overrides.iter().find(|entry| entry.values.name == name);
        let path = shot.map_or(PathBuf::new(), |entry| entry.path.clone());
        let stated = Statements { name: name.to_string(), ..Statements::default() };
        let material = self.settle(stated, &path);
        Some(material.map_err(|why| why.to_string()).and_then(|material| {
            let index = self.surfaces.add_settled(material).ok_or("there are too many materials")?;
            self.surfaces.of_tables.insert(name.to_string(), index);
            Ok(index)
        }))
    }

    /// Replaces values of a material by those that the `[[material]]` tables of its name state.
    ///
    /// # Errors
    /// Those of MaterialX files that they name.
    pub(in crate::scene) fn override_values(
        &mut self,
        stated: &mut Statements,
    ) -> Result<Overridden, SceneError> {
        self.override_surface(stated, None)
    }

    /// [`override_values`](Self::override_values) of a material that has a surface of its own, whose statements these are.
    pub(in crate::scene) fn override_surface(
        &mut self,
        stated: &mut Statements,
        own: Option<OfSurface>,
    ) -> Result<Overridden, SceneError> {
        let mut overridden = own.map_or_else(Overridden::default, |own| self.whole(own));
        for number in 0..self.surfaces.overrides.len() {
            if self.surfaces.overrides[number].values.name != stated.name {
                continue;
            }
            self.surfaces.overrides[number].used = true;
            if let Some(path) = self.surfaces.overrides[number].mtlx.clone() {
                let of_file = self.mtlx_surface(&path, &stated.name)?;
                *stated = of_file.stated.clone();
                overridden = self.whole(of_file);
            }
            let entry = &self.surfaces.overrides[number];
            stated.replace_with(&entry.values);
            let Statements { kd, pr, pm, ke, d, maps, .. } = &entry.values;
            for (is_number, used) in [
                (kd.is_some(), MapUse::Color),
                (pr.is_some(), MapUse::Roughness),
                (pm.is_some(), MapUse::Metal),
                (ke.is_some(), MapUse::Emission),
                (d.is_some(), MapUse::Opacity),
            ] {
                if let Some(of) = computed_by(used).filter(|_| is_number || maps.has(used)) {
                    overridden.graphs.remove(of);
                }
            }
            if maps.has(MapUse::Normal) || maps.has(MapUse::Bump) {
                (overridden.normals, overridden.bump) = (None, None);
            }
            let places = entry.values.maps.map(|_| entry.path.clone());
            overridden.places.replace_with(&places);
        }
        Ok(overridden)
    }

    /// A surface in place of all of a material's own.
    fn whole(&self, OfSurface { graphs, bump, normals, .. }: OfSurface) -> Overridden {
        let normals = normals.and_then(|(map, slope)| self.pictures.normal_map(map, slope));
        Overridden { graphs, bump, normals, is_whole: true, ..Overridden::default() }
    }

    /// The material of this name of the MaterialX file at `path`.
    ///
    /// # Errors
    /// Those of the file, and of its pictures.
    pub(in crate::scene) fn mtlx_surface(
        &mut self,
        path: &Path,
        name: &str,
    ) -> Result<OfSurface, SceneError> {
        let document = self.mtlx_document(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let Self { pictures, findings, .. } = self;
        let (surface, told) = mtlx::surface(&document, name, &mut |asked| {
            let named = Named { file: &asked.file, folder, asking: path, line: asked.line, space: None };
            let index = pictures.index_at(&named, asked.mapping, findings, asked.used)?;
            Ok(Some(index).filter(|index| asked.has_stand_in || !pictures.is_stand_in(*index)))
        })?;
        let of_surface = OfSurface::new(surface);
        let line = told.first().map_or(1, |(line, _)| *line);
        let left_out = of_surface.left_out.iter().map(|said| (line, String::from(*said)));
        for (line, said) in told.into_iter().chain(left_out) {
            self.findings.note(SceneError::new(path, format!("material `{name}`: {said}")).at_line(line));
        }
        Ok(of_surface)
    }

    /// The MaterialX file at `path`, read once.
    ///
    /// # Errors
    /// One that cannot be read, or is no MaterialX.
    pub(in crate::scene) fn mtlx_document(&mut self, path: &Path) -> Result<Arc<Document>, SceneError> {
        let (document, is_new) = self.surfaces.mtlx.at(path)?;
        if is_new {
            self.inputs.add([path.to_path_buf()], document.digest);
        }
        Ok(document)
    }

    /// Reports overrides that no model uses.
    ///
    /// # Errors Any such override, in a strict load.
    pub fn report_unused_overrides(&mut self) -> Result<(), SceneError> {
        let used: Vec<String> =
            self.surfaces.materials.iter().map(|material| material.name.clone()).collect();
        for entry in self.surfaces.overrides.iter().filter(|entry| !entry.used) {
            let name = &entry.values.name;
            let message = if self.surfaces.known_names.contains(name) {
                format!("the material `{name}` is defined, but no face uses it")
            } else {
                format!(
                    "no model has a material `{name}`{}",
                    spelling::hint(name, used.iter().map(String::as_str))
                )
            };
            let finding = SceneError::new(&entry.path, message).at(entry.line, entry.column);
            self.findings.stand_in(finding)?;
        }
        Ok(())
    }
}
