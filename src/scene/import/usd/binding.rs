//! Materials that are bound to prims (UsdShadeMaterialBindingAPI).

use std::collections::HashMap;

use openusd::sdf::{Path, Value};
use openusd::usd::{Prim, Stage};

use super::value::{Answer, said, targets};

/// Relationships that bind a material, the stronger one first: a preview is what is rendered here.
const DIRECT: [&str; 2] = ["material:binding:preview", "material:binding"];

/// Strength of a binding that goes before those below.
const STRONG: &str = "strongerThanDescendants";

/// Bindings of prims, looked up once each.
#[derive(Default)]
pub struct Bindings {
    /// For each prim: the path of its material, and true if it goes before those below.
    known: HashMap<String, Option<(Path, bool)>>,
    /// True if a collection binds a material anywhere.
    pub has_collections: bool,
}

impl Bindings {
    /// Path of the material of the prim at `path`: its own or that of the nearest parent, unless one farther up is stronger.
    ///
    /// # Errors What the library says.
    pub fn material(&mut self, stage: &Stage, path: &Path) -> Answer<Option<Path>> {
        let (mut found, mut at) = (None, Some(path.clone()));
        while let Some(path) = at.filter(|path| path.as_str() != "/") {
            let own = self.own(stage, &path)?;
            if let Some((material, is_strong)) = own
                && (found.is_none() || is_strong)
            {
                found = Some(material);
            }
            at = path.parent();
        }
        Ok(found)
    }

    fn own(&mut self, stage: &Stage, path: &Path) -> Answer<Option<(Path, bool)>> {
        if let Some(known) = self.known.get(path.as_str()) {
            return Ok(known.clone());
        }
        let own = self.read(&stage.prim(path.clone()))?;
        self.known.insert(path.to_string(), own.clone());
        Ok(own)
    }

    fn read(&mut self, prim: &Prim) -> Answer<Option<(Path, bool)>> {
        let names = said(prim.property_names())?;
        let is_collection = |name: &str| name.starts_with("material:binding:collection:");
        self.has_collections |= names.iter().any(|name| is_collection(name.as_str()));
        for name in DIRECT.into_iter().filter(|name| names.iter().any(|own| own.as_str() == *name)) {
            if let Some(material) = targets(prim, name)?.into_iter().next() {
                let strength = prim.attribute(name).get_metadata::<Value>("bindMaterialAs");
                // a token in binary layers, and a text in others
                let is_strong = match said(strength)? {
                    Some(Value::Token(strength)) => strength.as_str() == STRONG,
                    Some(Value::String(strength)) => strength == STRONG,
                    _ => false,
                };
                return Ok(Some((material, is_strong)));
            }
        }
        Ok(None)
    }
}
