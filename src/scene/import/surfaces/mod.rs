//! The materials of a shot, and what its tables say of them.

mod lower;
pub mod material_table;
mod means;
mod overrides;
mod settle;
pub mod spread;
pub mod varying;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;

use self::material_table::{Override, StatedMedium};
use self::varying::Settled;
use crate::scene::import::mtl::statements::Statements;
use crate::scene::import::mtl::statements::maps::MapUse;
use crate::scene::import::mtlx::MtlxFiles;
use crate::scene::keys::spelling;
use crate::scene::{Material, SceneError};

/// Maximum number of materials of a shot: a triangle keeps 16 bits of index.
const MOST_MATERIALS: usize = 1 << 16;

/// Materials that were settled so far, and the `[[material]]` tables.
#[derive(Default)]
pub(in crate::scene) struct Surfaces {
    /// Materials. Triangles keep their indices.
    pub materials: Vec<Material>,
    /// `[[material]]` tables of the shot file.
    pub overrides: Vec<Override>,
    /// Names of all materials that files define, for hints.
    pub known_names: Vec<String>,
    /// Indices of the materials that tables alone define, by name.
    pub of_tables: HashMap<String, u16>,
    /// MaterialX files that tables and other files name.
    pub mtlx: MtlxFiles,
}

impl Surfaces {
    /// Adds a material with what varies of it. Returns its index, unless there are too many.
    pub fn add_settled(&mut self, Settled { material, graphs }: Settled) -> Option<u16> {
        let computed = graphs.computed(&material).map(Arc::new);
        self.add(Material { computed, ..material })
    }

    /// Adds a material. Returns its index, unless there are too many.
    pub fn add(&mut self, material: Material) -> Option<u16> {
        let index = u16::try_from(self.materials.len()).ok()?;
        self.materials.push(material);
        Some(index)
    }

    /// Adds a material of the file at `path`. Returns its index.
    ///
    /// # Errors Too many materials.
    pub fn add_of(&mut self, path: &Path, material: Settled) -> Result<u16, SceneError> {
        let too_many = || format!("with this model the shot has more than {MOST_MATERIALS} materials");
        self.add_settled(material).ok_or_else(|| SceneError::new(path, too_many()))
    }

    /// Returns true if a `[[material]]` table has this name.
    pub fn is_overridden(&self, name: &str) -> bool {
        self.overrides.iter().any(|entry| entry.values.name == name)
    }

    /// What the `[[material]]` tables of this name state, with their shot files: from the last table on that takes a MaterialX file. They
    /// are used then.
    pub fn tables_of(&mut self, name: &str) -> Vec<(Statements, PathBuf)> {
        let named = self.overrides.iter_mut().filter(|entry| entry.values.name == name);
        let entries: Vec<&Override> = named
            .map(|entry| {
                entry.used = true;
                &*entry
            })
            .collect();
        let first = entries.iter().rposition(|entry| entry.mtlx.is_some()).unwrap_or(0);
        entries[first..].iter().map(|entry| (entry.values.clone(), entry.path.clone())).collect()
    }

    /// The MaterialX file that the last table of this name takes that takes one.
    pub fn mtlx_of(&self, name: &str) -> Option<PathBuf> {
        let named = self.overrides.iter().filter(|entry| entry.values.name == name);
        named.rev().find_map(|entry| entry.mtlx.clone())
    }

    /// Returns true if a `[[material]]` table of this name replaces what a file says of the parameter that pictures of this use give.
    pub fn replaces(&self, name: &str, used: MapUse) -> bool {
        let entries = self.overrides.iter().filter(|entry| entry.values.name == name);
        entries.into_iter().any(|entry| entry.values.states_number(used) || entry.values.maps.has(used))
    }

    /// Gives materials what the tables of their names state of media, and takes the surfaces of those that have none.
    pub fn fill_media(&mut self) {
        for entry in &self.overrides {
            let named = self.materials.iter_mut().filter(|material| material.name == entry.values.name);
            for material in named {
                if entry.medium != StatedMedium::default() {
                    material.medium = Some(entry.medium.over(material.medium));
                }
                material.medium_cells = entry.medium.cells.or(material.medium_cells);
                material.has_surface = entry.surface.unwrap_or(material.has_surface);
            }
        }
        for material in self.materials.iter_mut().filter(|material| !material.has_surface) {
            material.emission = Vec3::ZERO;
        }
    }

    /// Suggests a name like `name` among those that the `[[material]]` tables define, if there is one, as a
    /// question.
    pub fn hint_at(&self, name: &str) -> String {
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

    /// Has the colours of vertices show on a material: alone, where it is the one of faces without any.
    pub fn color_vertices(&mut self, material: u16) {
        let material = &mut self.materials[usize::from(material)];
        material.has_vertex_colors = true;
        if material.is_fallback() {
            (material.diffuse, material.ambient) = (Vec3::ONE, Vec3::ONE);
        }
    }

    /// Makes ambient light take the colours of diffuse light: exporters that know no ambient light write a Ka of 0.
    pub fn reflect_ambient_light_as_diffuse(&mut self) {
        self.materials.iter_mut().for_each(|material| material.ambient = material.diffuse);
    }

    /// Returns true if a material reflects ambient light.
    pub fn reflects_ambient_light(&self) -> bool {
        self.materials.iter().any(|material| material.ambient != Vec3::ZERO)
    }
}
