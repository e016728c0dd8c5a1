//! Materials that are bound to prims (UsdShadeMaterialBindingAPI).

use std::collections::HashMap;

use openusd::sdf::{Path, Value};
use openusd::usd::{Prim, Stage};

use super::value::{Answer, said, targets};

/// Relationships that bind a material, the stronger one first: a preview is what is rendered here.
const DIRECT: [&str; 3] = ["material:binding:preview", "material:binding", "material:binding:full"];

/// Strength of a binding that goes before those below.
const STRONG: &str = "strongerThanDescendants";

/// Bindings of prims, looked up once each.
pub struct Bindings {
    /// Relationships, the stronger one first.
    order: Vec<String>,
    /// For each prim and each relationship: the path of its material, and true if it goes before those below.
    known: HashMap<String, Vec<Option<(Path, bool)>>>,
    /// True if a collection binds a material anywhere.
    pub has_collections: bool,
}

impl Bindings {
    /// Bindings of which those for the first of these purposes go before all others; none: previews do.
    pub fn in_order(purposes: Option<&[String]>) -> Self {
        let of_purpose = |purpose: &String| match purpose.as_str() {
            "" | "allPurpose" => String::from("material:binding"),
            purpose => format!("material:binding:{purpose}"),
        };
        let mut order: Vec<String> = purposes.unwrap_or_default().iter().map(of_purpose).collect();
        let others = DIRECT.into_iter().filter(|name| order.iter().all(|own| own != name));
        let others: Vec<String> = others.map(String::from).collect();
        order.extend(others);
        Self { order, known: HashMap::new(), has_collections: false }
    }

    /// Path of the material of the prim at `path`: its own or that of the nearest parent, unless one farther up is stronger. A purpose counts
    /// only where none before it has a binding at all.
    ///
    /// # Errors What the library says.
    pub fn material(&mut self, stage: &Stage, path: &Path) -> Answer<Option<Path>> {
        for purpose in 0..self.order.len() {
            let found = self.of_purpose(stage, path, purpose)?;
            if found.is_some() {
                return Ok(found);
            }
        }
        Ok(None)
    }

    fn of_purpose(&mut self, stage: &Stage, path: &Path, purpose: usize) -> Answer<Option<Path>> {
        let (mut found, mut at) = (None, Some(path.clone()));
        while let Some(path) = at.filter(|path| path.as_str() != "/") {
            let own = self.own(stage, &path, purpose)?;
            if let Some((material, is_strong)) = own
                && (found.is_none() || is_strong)
            {
                found = Some(material);
            }
            at = path.parent();
        }
        Ok(found)
    }

    fn own(&mut self, stage: &Stage, path: &Path, purpose: usize) -> Answer<Option<(Path, bool)>> {
        if let Some(known) = self.known.get(path.as_str()) {
            return Ok(known.get(purpose).cloned().flatten());
        }
        let all = self.read(&stage.prim(path.clone()))?;
        let own = all.get(purpose).cloned().flatten();
        self.known.insert(path.to_string(), all);
        Ok(own)
    }

    /// Bindings of a prim by relationship; none at all: it has none.
    fn read(&mut self, prim: &Prim) -> Answer<Vec<Option<(Path, bool)>>> {
        let names = said(prim.property_names())?;
        let is_collection = |name: &str| name.starts_with("material:binding:collection:");
        self.has_collections |= names.iter().any(|name| is_collection(name.as_str()));
        let mut all = Vec::new();
        for (purpose, name) in self.order.iter().enumerate() {
            if names.iter().any(|own| own.as_str() == name)
                && let Some(material) = targets(prim, name)?.into_iter().next()
            {
                let strength = prim.attribute(name).get_metadata::<Value>("bindMaterialAs");
                // a token in binary layers, and a text in others
                let is_strong = match said(strength)? {
                    Some(Value::Token(strength)) => strength.as_str() == STRONG,
                    Some(Value::String(strength)) => strength == STRONG,
                    _ => false,
                };
                all.resize(self.order.len(), None);
                all[purpose] = Some((material, is_strong));
            }
        }
        Ok(all)
    }
}
