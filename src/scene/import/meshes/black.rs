//! Models whose materials are black throughout, as some exporters write them.

use std::collections::HashSet;

use super::libraries::libraries;
use super::read_model::ReadModel;
use crate::scene::SceneError;
use crate::scene::import::Import;
use crate::scene::import::mtl::statements::maps::MapUse;
use crate::scene::keys::material::KdBesideMap;

impl ReadModel {
    /// The names of the materials that its faces use, if they are black throughout, as some exporters write them: no colour, no
    /// texture, no highlight, no light of their own.
    ///
    /// # Errors
    /// An MTL file cannot be read.
    pub fn black_materials(&self) -> Result<Option<Vec<String>>, SceneError> {
        let (defined, _) = libraries(&mut Import::default(), &self.obj, &self.path)?;
        let used: HashSet<u32> = self.obj.uses.iter().map(|(_, of)| of.material).collect();
        let names: HashSet<&str> =
            used.into_iter().map(|material| self.obj.materials[material as usize].name.as_str()).collect();
        let is_black = |name: &&str| {
            let found = defined.iter().rfind(|defined| defined.material.name == **name);
            found.is_some_and(|defined| {
                let meant = || defined.meant(KdBesideMap::default());
                let states = |used| defined.material.maps.has(used);
                !states(MapUse::Color) && !states(MapUse::Emission) && meant().surface().material().is_black()
            })
        };
        let mut names: Vec<&str> = names.into_iter().collect();
        names.sort_unstable();
        let black = names.iter().all(is_black);
        Ok(black.then(|| names.into_iter().map(String::from).collect()))
    }
}
