//! Collections that say which prims a light lights, and which cast shadows in its light (UsdLuxLightAPI: `collection:lightLink`,
//! `collection:shadowLink`).

use openusd::usd::Prim;

use super::file::{Content, Link, UsdLight};
use super::value::{Answer, flag, targets, word};
use crate::scene::keys::links::NamesTable;
use crate::scene::keys::toml_text::At;

/// Reads the collection `name` of a light. `None` if all prims are in it.
///
/// # Errors What the library says.
pub fn read(prim: &Prim, name: &str, code: f64) -> Answer<Option<Link>> {
    let of = |part: &str| format!("collection:{name}:{part}");
    let paths = |part: &str| -> Answer<Vec<String>> {
        Ok(targets(prim, &of(part))?.iter().map(|path| path.to_string()).collect())
    };
    let (includes, excludes) = (paths("includes")?, paths("excludes")?);
    // the schema says so of lights
    let has_root = flag(prim, &of("includeRoot"), code)?.unwrap_or(true);
    if has_root && excludes.is_empty() {
        return Ok(None);
    }
    let is_exact = word(prim, &of("expansionRule"), code)?.as_deref() == Some("explicitOnly");
    Ok(Some(Link { includes, excludes, has_root, is_exact }))
}

impl Link {
    /// Returns true if a prim is in the collection: as the nearest path above it, or its own, says.
    pub fn has(&self, name: &str) -> bool {
        let nearest = |paths: &[String]| paths.iter().filter_map(|path| self.depth(path, name)).max();
        let included = nearest(&self.includes).or((self.has_root && !self.is_exact).then_some(0));
        let excluded = nearest(&self.excludes);
        included.is_some() && included > excluded
    }

    /// Length of `path`, counted from 1, if a prim is there or below it. `name`: its path without the first slash.
    fn depth(&self, path: &str, name: &str) -> Option<usize> {
        let path = path.trim_matches('/');
        let is_below = path.is_empty() || name.strip_prefix(path).is_some_and(|rest| rest.starts_with('/'));
        (name == path || is_below && !self.is_exact).then_some(path.len() + 1)
    }
}

/// Group of the models that are in a collection of a light.
fn group(light: &UsdLight, what: &str) -> String {
    format!("{what} {}", light.path)
}

/// Names of collections in groups of models.
const OF_LIGHT: &str = "lit by";
const OF_SHADOW: &str = "shadows of";

/// Groups of the model of a shown mesh.
pub fn groups(content: &Content, name: &str) -> Vec<String> {
    let links = content
        .lights
        .iter()
        .flat_map(|light| [(light, OF_LIGHT, &light.light_link), (light, OF_SHADOW, &light.shadow_link)]);
    let has = |link: &Option<Link>| link.as_ref().is_some_and(|link| link.has(name));
    links.filter(|(.., link)| has(link)).map(|(light, what, _)| group(light, what)).collect()
}

/// Keys `light_link` and `shadow_link` of a light; `None` if it lights nothing that is shown.
pub fn keys(content: &Content, light: &UsdLight) -> Option<[Option<At<NamesTable>>; 2]> {
    let is_shown = |link: &Link| {
        let meant = content.shown.iter().filter(|shown| link.has(&shown.name));
        meant.into_iter().any(|shown| !content.meshes[shown.mesh].triangles.is_empty())
    };
    let table = |names: Vec<String>| {
        let names = names.into_iter().map(At::of).collect();
        At::of(NamesTable { include: Some(At::of(names)), exclude: None })
    };
    let lights = match &light.light_link {
        Some(link) if is_shown(link) => Some(table(vec![group(light, OF_LIGHT)])),
        Some(_) => return None,
        None => None,
    };
    let shadows = light.shadow_link.as_ref();
    let shadows = shadows.map(|link| if is_shown(link) { vec![group(light, OF_SHADOW)] } else { Vec::new() });
    Some([lights, shadows.map(table)])
}
