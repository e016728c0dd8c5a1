//! A scene as a program states it, table by table.

use std::sync::Arc;

use afterimage::scene::given::{self, Given};
use afterimage::scene::{Frames, Shot};
use afterimage::settings::Settings;
use pyo3::prelude::*;
use toml::{Table, Value};

use crate::errors::guarded;
use crate::keys::told;

/// Tables of a shot file, and the meshes beside them.
#[derive(Clone)]
pub struct Stated {
    /// All tables but those below.
    pub tables: Table,
    /// `[[material]]` tables.
    pub materials: Vec<Value>,
    /// `[[light]]` tables.
    pub lights: Vec<Value>,
    /// Meshes and models.
    pub given: Given,
    /// True if a stand-in in the picture is an error.
    pub strict: bool,
    /// The shot of all this, once it was asked for; none again after a change.
    pub built: Option<Arc<Shot>>,
}

impl Stated {
    /// Puts `keys` into the table `name`, in place of what it has of the same names.
    pub fn put(&mut self, name: &str, keys: Table) {
        self.built = None;
        let table = self.tables.entry(name).or_insert_with(|| Value::Table(Table::new()));
        if let Some(table) = table.as_table_mut() {
            table.extend(keys);
        }
    }

    /// Text of the shot file.
    pub fn text(&self) -> String {
        let mut tables = self.tables.clone();
        let lists = [("material", &self.materials), ("light", &self.lights)];
        for (name, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
            tables.insert(name.into(), Value::Array(list.clone()));
        }
        tables.to_string()
    }

    fn of_render(&self, key: &str) -> Option<&Value> {
        self.tables.get("render")?.get(key)
    }

    /// Frames that it names.
    pub fn frames(&self) -> Frames {
        let stated = self.of_render("frames").and_then(Value::as_str);
        // the text was made of frames
        stated.and_then(|text| Frames::parse(text).ok()).unwrap_or(Frames::between(1, 1))
    }

    /// Width and height of its pictures.
    pub fn size(&self) -> (u32, u32) {
        let usual = Settings::default();
        let side = |number: usize| {
            let side = self.of_render("size")?.get(number)?.as_integer()?;
            u32::try_from(side).ok()
        };
        (side(0).unwrap_or(usual.width), side(1).unwrap_or(usual.height))
    }
}

/// Checks a table by itself, so that its error is raised where it is stated. `is_list`: it is one of several, as
/// `[[light]]` is.
pub fn check(name: &str, table: &Value, is_list: bool) -> PyResult<()> {
    let value = if is_list { Value::Array(vec![table.clone()]) } else { table.clone() };
    let text = Table::from_iter([(String::from(name), value)]).to_string();
    guarded(|| given::check(&text).map_err(|cause| told(&cause)))
}
