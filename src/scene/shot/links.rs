//! Links of lights to models: their keys, read and compared with the names that there are.

use std::collections::HashSet;
use std::sync::Arc;

use crate::scene::keys::links::NamesTable;
use crate::scene::keys::spelling::hint;
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::keys::{LightTable, ModelTable};
use crate::scene::{BlockerSet, LightGroups, LightLinks, Linked, Model, ModelNames, SceneError};

const LIGHT_LINK: &str = "light_link";
const SHADOW_LINK: &str = "shadow_link";

/// A key of links, as it is written.
type Link = Option<At<NamesTable>>;

/// Reads the links of a light, or of what emits.
pub fn of_table(text: TomlText<'_>, light_link: &Link, shadow_link: &Link) -> Result<LightLinks, SceneError> {
    Ok(LightLinks {
        receivers: names(text, LIGHT_LINK, light_link)?,
        blockers: names(text, SHADOW_LINK, shadow_link)?,
    })
}

fn names(text: TomlText<'_>, key: &str, link: &Link) -> Result<ModelNames, SceneError> {
    let Some(link) = link else { return Ok(ModelNames::default()) };
    let NamesTable { include, exclude } = link.get_ref();
    if include.is_none() && exclude.is_none() {
        return Err(text.bad(key, link, "names nothing: give it `include` or `exclude`, or take it out"));
    }
    // nothing may cast shadows in a light, but a light that lights nothing is none
    if let Some(none) = include.as_ref().filter(|names| key == LIGHT_LINK && names.get_ref().is_empty()) {
        let what = "of `light_link` is empty: nothing would be lit; take it out to light all models, or take the light out";
        return Err(text.bad("include", none, what));
    }
    let list = |names: &Option<At<Vec<At<String>>>>| -> Result<Option<Vec<String>>, SceneError> {
        let Some(names) = names else { return Ok(None) };
        let names: Result<Vec<String>, SceneError> =
            names.get_ref().iter().map(|name| checked(text, key, name)).collect();
        names.map(Some)
    };
    Ok(ModelNames { include: list(include)?, exclude: list(exclude)?.unwrap_or_default() })
}

fn checked(text: TomlText<'_>, key: &str, name: &At<String>) -> Result<String, SceneError> {
    match name.get_ref().trim().is_empty() {
        true => Err(text.bad(key, name, "has an empty name: write that of a model or a group")),
        false => Ok(name.get_ref().clone()),
    }
}

/// Gives the models of a table their groups and the links of what they emit.
pub fn with_links(
    text: TomlText<'_>,
    table: &ModelTable,
    models: Vec<Model>,
) -> Result<Vec<Model>, SceneError> {
    let ModelTable { groups, light_link, shadow_link, light_group, .. } = table;
    let light_group = light_group.as_ref().map(|group| group_name(text, "light_group", group)).transpose()?;
    let light_group: Option<Arc<str>> = light_group.map(Arc::from);
    let groups = groups.as_ref().map_or(&[][..], |groups| groups.get_ref());
    let mut own: Vec<String> =
        groups.iter().map(|name| checked(text, "groups", name)).collect::<Result<_, _>>()?;
    // the name of a table of several models means all of them
    own.extend(table.name.clone().filter(|name| models.iter().any(|model| model.name != *name)));
    let own: Arc<[String]> = own.into();
    let emission = of_table(text, light_link, shadow_link)?;
    let emission = (emission != LightLinks::default()).then(|| Arc::new(emission));
    let linked = |model: Model| {
        let Linked { groups, emission: given, light_group: of_model } = &model.linked;
        let groups = match groups.is_empty() {
            true => Arc::clone(&own),
            false => groups.iter().chain(&*own).cloned().collect(),
        };
        let emission = emission.clone().or_else(|| given.clone());
        let light_group = light_group.clone().or_else(|| of_model.clone());
        Model { linked: Linked { groups, emission, light_group }, ..model }
    };
    if own.is_empty() && emission.is_none() && light_group.is_none() {
        return Ok(models);
    }
    Ok(models.into_iter().map(linked).collect())
}

/// Checks that links of lights and of models name what there is, and that there are not too many sets of models that cast shadows.
/// `models`: all models of the shot; `has_floor`: it has a floor as well.
///
/// # Errors With line and column: unknown names, links that mean no model, more sets than there may be.
pub fn check(
    text: TomlText<'_>,
    (lights, tables): (&[At<LightTable>], &[At<ModelTable>]),
    models: &[Model],
    has_floor: bool,
) -> Result<(), SceneError> {
    let of_lights = lights
        .iter()
        .map(At::get_ref)
        .flat_map(|light| [(LIGHT_LINK, &light.light_link), (SHADOW_LINK, &light.shadow_link)]);
    let of_models = tables
        .iter()
        .map(At::get_ref)
        .flat_map(|model| [(LIGHT_LINK, &model.light_link), (SHADOW_LINK, &model.shadow_link)]);
    let links: Vec<(&str, &At<NamesTable>)> =
        of_lights.chain(of_models).filter_map(|(key, link)| Some((key, link.as_ref()?))).collect();
    let emission = models.iter().filter(|model| model.linked.emission.is_some());
    if links.is_empty() && emission.clone().next().is_none() {
        return Ok(());
    }
    let floor = has_floor.then_some(FLOOR);
    let groups = models.iter().flat_map(|model| model.linked.groups.iter());
    let known: HashSet<&str> = models.iter().map(|model| model.name.as_str()).collect();
    let known: HashSet<&str> = known.into_iter().chain(groups.map(String::as_str)).chain(floor).collect();
    let mut sets: HashSet<Vec<bool>> = HashSet::new();
    for (key, link) in links {
        let NamesTable { include, exclude } = link.get_ref();
        let lists = [include, exclude].into_iter().flatten();
        for name in lists.flat_map(|names| names.get_ref()) {
            let wrong = name.get_ref().as_str();
            if !known.contains(wrong) {
                let hint = hint(wrong, known.iter().copied());
                let message = format!("names `{wrong}`, which is no model and no group of models{hint}");
                return Err(text.bad(key, name, &format!("{message}: `info` lists the models")));
            }
        }
        let meant = names(text, key, &Some(link.clone()))?;
        let mut members: Vec<bool> = models.iter().map(|model| meant.has(model)).collect();
        members.extend(floor.map(|floor| {
            let is_named = |names: &[String]| names.iter().any(|name| name == floor);
            meant.include.as_deref().is_none_or(is_named) && !is_named(&meant.exclude)
        }));
        if key == LIGHT_LINK && !members.contains(&true) {
            let message = "means no model: all that it includes is excluded; take a name out of `exclude`";
            return Err(text.bad(key, link, message));
        }
        if key == SHADOW_LINK
            && members.contains(&false)
            && sets.insert(members)
            && sets.len() > BlockerSet::MOST
        {
            let message = format!(
                "is one of more than {} different sets of models: let some lights have the same",
                BlockerSet::MOST
            );
            return Err(text.bad(key, link, &message));
        }
    }
    // of models that no table states
    for model in emission {
        let links = model.linked.emission.iter().flat_map(|links| [&links.receivers, &links.blockers]);
        if let Some(wrong) = links.flat_map(ModelNames::names).find(|name| !known.contains(name)) {
            let hint = hint(wrong, known.iter().copied());
            let message =
                format!("a link of model `{}` names `{wrong}`, which is no model and no group", model.name);
            return Err(SceneError::new(text.path, format!("{message}{hint}: name another")));
        }
    }
    Ok(())
}

/// Name of the floor's model.
const FLOOR: &str = "floor";

/// Reads the name of a group, which becomes a part of channel names.
pub fn group_name(text: TomlText<'_>, key: &str, group: &At<String>) -> Result<String, SceneError> {
    /// Maximum length: names of channels end at 31 letters, for old readers, `light_` and `.R` included.
    const LONGEST: usize = 23;
    let name = group.get_ref();
    if name == LightGroups::OTHERS {
        return Err(text.bad(
            key,
            group,
            "is the name of the group of all lights that state none: choose another",
        ));
    }
    let is_plain = name.chars().all(|letter| letter.is_ascii_alphanumeric() || matches!(letter, '-' | '_'));
    let fits = (1..=LONGEST).contains(&name.len()) && is_plain;
    fits.then(|| name.clone())
        .ok_or_else(|| text.bad(key, group, "must be 1 to 23 letters, digits, `-` and `_`"))
}
