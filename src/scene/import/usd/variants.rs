//! Variants of a stage: which there are, and those that somebody chose.

use std::collections::HashMap;

use openusd::sdf::{Path, Value};
use openusd::usd::Stage;

use super::choice::VariantChoice;
use super::value::{Answer, said};

/// Most names that are told at once.
const MOST_NAMES: usize = 12;

/// Fields of layers: names of a prim's variant sets, those of a set's variants, and what a prim selects.
const SETS: &str = "variantSetChildren";
const VARIANTS: &str = "variantChildren";
const SELECTION: &str = "variantSelection";

/// A variant set of a prim.
#[derive(Debug, PartialEq, Eq)]
pub struct VariantSet {
    pub name: String,
    /// Its variants, the ones of stronger layers first.
    pub variants: Vec<String>,
}

/// Variant sets of the prim at a path, over all its layers.
///
/// # Errors What the library says.
pub fn sets(stage: &Stage, path: &Path) -> Answer<Vec<VariantSet>> {
    let graph = said(stage.prim(path.clone()).prim_index().graph())?;
    let mut sets: Vec<VariantSet> = Vec::new();
    for node in graph.all_nodes() {
        for (layer, _) in stage.node_layer_stack(node) {
            let Some(layer) = stage.layer_identifier(layer) else { continue };
            let Some(layer) = stage.layer(&layer) else { continue };
            let names = |path: &Path, field: &str| match layer.data().try_field(path, field) {
                Ok(Some(value)) => tokens(&value),
                _ => Vec::new(),
            };
            for name in names(node.path(), SETS) {
                let own = names(&node.path().append_variant_selection(&name, ""), VARIANTS);
                let known = match sets.iter().position(|set| set.name == name) {
                    Some(known) => known,
                    None => {
                        sets.push(VariantSet { name, variants: Vec::new() });
                        sets.len() - 1
                    }
                };
                let variants = &mut sets[known].variants;
                own.into_iter().for_each(|name| {
                    if !variants.contains(&name) {
                        variants.push(name);
                    }
                });
            }
        }
    }
    Ok(sets)
}

/// Variants that the prim at a path shows: of each set one, by their names.
///
/// # Errors What the library says.
pub fn selected(stage: &Stage, path: &Path) -> Answer<Vec<(String, String)>> {
    said(stage.prim(path.clone()).variant_sets().get_all_variant_selections())
}

/// Selects the chosen variants: in memory, above all that the layers select.
///
/// # Errors A prim, set or variant that is not there, with those that are.
pub fn select(stage: &Stage, choices: &[VariantChoice]) -> Answer<()> {
    // a variant may bring prims that have variants themselves
    let mut choices: Vec<&VariantChoice> = choices.iter().collect();
    choices.sort_by_key(|choice| choice.prim.matches('/').count());
    let mut made: HashMap<(String, String), &VariantChoice> = HashMap::new();
    for choice in choices {
        let path = Path::new(&choice.prim).map_err(|error| format!("the variant `{choice}`: {error}"))?;
        check_prim(stage, &path, &format!("the variant `{choice}`"))?;
        let sets = sets(stage, &path)?;
        let set = set_of(choice, &sets)?;
        if !set.variants.contains(&choice.variant) {
            return Err(format!(
                "the variant set {}:{} has no variant `{}`: it has {}",
                choice.prim,
                set.name,
                choice.variant,
                listed(&set.variants)
            ));
        }
        if let Some(other) = made.insert((choice.prim.clone(), set.name.clone()), choice) {
            return Err(format!("the variants `{other}` and `{choice}` exclude each other: name one"));
        }
        let select = |before: Option<Value>| {
            let mut all = match before {
                Some(Value::VariantSelectionMap(all)) => all,
                _ => HashMap::new(),
            };
            all.insert(set.name.clone(), choice.variant.clone());
            Value::VariantSelectionMap(all)
        };
        said(said(stage.override_prim(path.clone()))?.update_metadata(SELECTION, select))?;
        if !selected(stage, &path)?.contains(&(set.name.clone(), choice.variant.clone())) {
            return Err(format!(
                "the variant `{choice}` cannot be chosen from here: {} is a part of an instance; choose a variant of the instance, or make it \
                 no instance",
                choice.prim
            ));
        }
    }
    Ok(())
}

/// Set of a choice: the one that it names, or the only one.
fn set_of<'a>(choice: &VariantChoice, sets: &'a [VariantSet]) -> Answer<&'a VariantSet> {
    let prim = &choice.prim;
    let names: Vec<String> =
        sets.iter().map(|set| format!("{}:{} ({})", prim, set.name, listed(&set.variants))).collect();
    match (&choice.set, sets) {
        (_, []) => Err(format!("the variant `{choice}`: {prim} has no variant sets")),
        (None, [only]) => Ok(only),
        (None, _) => Err(format!(
            "the variant `{choice}`: {prim} has several variant sets: write the set as well; there are {}",
            listed(&names)
        )),
        (Some(name), _) => sets
            .iter()
            .find(|set| set.name == *name)
            .ok_or_else(|| format!("{prim} has no variant set `{name}`: it has {}", listed(&names))),
    }
}

/// Checks that there is a prim at a path, which `named` names.
///
/// # Errors It is not there; with what is there instead.
pub fn check_prim(stage: &Stage, path: &Path, named: &str) -> Answer<()> {
    if path.as_str() == "/" || said(stage.prim(path.clone()).is_valid())? {
        return Ok(());
    }
    let mut above = path.parent();
    while let Some(at) = above.clone().filter(|at| at.as_str() != "/") {
        if said(stage.prim(at.clone()).is_valid())? {
            break;
        }
        above = at.parent();
    }
    let above = above.unwrap_or_else(Path::abs_root);
    let children = said(stage.prim(above.clone()).child_names())?;
    let children: Vec<String> = children.iter().map(ToString::to_string).collect();
    let there = match &children[..] {
        [] => format!("there is nothing below {above}"),
        _ => format!("below {above} there are {}", listed(&children)),
    };
    Err(format!("{named}: the file has no prim {path}: {there}"))
}

/// Names as they are told.
pub fn listed(names: &[String]) -> String {
    let more = names.len().saturating_sub(MOST_NAMES);
    let first = names[..names.len() - more].join(", ");
    if more > 0 { format!("{first} and {more} more") } else { first }
}

fn tokens(value: &Value) -> Vec<String> {
    match value {
        Value::TokenVec(names) => names.iter().map(ToString::to_string).collect(),
        Value::StringVec(names) => names.clone(),
        _ => Vec::new(),
    }
}
