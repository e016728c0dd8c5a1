//! Links of lights in a shot file, as they are written: see [`shot_file`](super).

use schemars::JsonSchema;
use serde::Deserialize;
use toml::{Table, Value};

use super::table_text::Said;
use super::toml_text::At;

/// Models by name.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct NamesTable {
    /// Names of models, or of their groups: these models alone (all models)
    pub include: Option<At<Vec<At<String>>>>,
    /// Names of models, or of their groups: not these models ([])
    pub exclude: Option<At<Vec<At<String>>>>,
}

/// The table as a value, if it is there.
pub(super) fn value(table: &Option<At<NamesTable>>) -> Option<Said> {
    let NamesTable { include, exclude } = table.as_ref()?.get_ref();
    let list = |names: &Option<At<Vec<At<String>>>>| {
        let names = names.as_ref()?.get_ref().iter().map(|name| Value::from(name.get_ref().as_str()));
        Some(Value::Array(names.collect()))
    };
    let lists = [("include", list(include)), ("exclude", list(exclude))];
    let lists = lists.into_iter().filter_map(|(key, names)| Some((String::from(key), names?)));
    Some(Said::of(Value::Table(lists.collect::<Table>())))
}
