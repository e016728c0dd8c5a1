//! From Python's values to the text of a shot file: keys are written as the shot file has them, and read by its reader, so that they
//! mean the same and their errors say the same.

use afterimage::scene::SceneError;
use afterimage::scene::given::NAME;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyString};
use toml::{Table, Value};

use crate::errors::{Error, error};

/// Keys of other tables of a shot file than `[render]`, whose keys are the most.
const INDIRECT: [&str; 4] = ["paths", "bounces", "budget", "paths_per_frame"];
const OUTPUT: [&str; 4] = ["layers", "background", "denoise", "denoise_quality"];
const OCCLUSION: [(&str, &str); 2] = [("occlusion_radius", "radius"), ("occlusion_rays", "rays")];
const TABLES: [&str; 6] = ["render", "indirect", "occlusion", "output", "stereo", "shutter"];

/// Most lists and dicts that lie in one another: shot files have five.
const MOST_NESTED: usize = 16;

/// Most values in a dict, those of its lists and dicts among them; and most characters of a text. Shot files have thousands; an iterator
/// may have no end.
const MOST_VALUES: usize = 1_000_000;

/// Converts a dict with keys of text.
pub fn table(dict: &Bound<'_, PyDict>) -> PyResult<Table> {
    Reader { left: MOST_VALUES }.table(dict, 0)
}

/// Reads values, with a limit on their number.
struct Reader {
    left: usize,
}

impl Reader {
    fn table(&mut self, dict: &Bound<'_, PyDict>, depth: usize) -> PyResult<Table> {
        let mut table = Table::new();
        // reading a value may call functions of the caller, which may change the dict: its values are those of now
        for (key, object) in &dict.copy()? {
            let key: String = key.extract().map_err(|_| error("the keys of a dict must be texts"))?;
            if let Some(value) = self.value(&object, depth).map_err(|cause| of_key(dict.py(), &key, cause))? {
                table.insert(key, value);
            }
        }
        Ok(table)
    }

    /// Converts a value that lies in so many lists and dicts. `None` stands for a key that is not there.
    fn value(&mut self, object: &Bound<'_, PyAny>, depth: usize) -> PyResult<Option<Value>> {
        if depth > MOST_NESTED {
            return Err(error(format!(
                "lists or dicts lie in one another {MOST_NESTED} deep, or one is in itself: no key takes such a value"
            )));
        }
        self.left = self.left.checked_sub(1).ok_or_else(|| {
            error(format!("more than {MOST_VALUES} values: is a mesh or an iterator without end among them?"))
        })?;
        if object.is_none() {
            return Ok(None);
        }
        if let Ok(said) = object.extract::<bool>() {
            return Ok(Some(Value::Boolean(said)));
        }
        if let Ok(text) = object.cast::<PyString>() {
            return self.text(text);
        }
        if let Ok(dict) = object.cast::<PyDict>() {
            return self.table(dict, depth + 1).map(|table| Some(Value::Table(table)));
        }
        if !object.is_instance_of::<PyFloat>() {
            if let Ok(number) = object.extract::<i64>() {
                return Ok(Some(Value::Integer(number)));
            }
        }
        if let Ok(number) = object.extract::<f64>() {
            return Ok(Some(Value::Float(number)));
        }
        if let Ok(path) = object.call_method0("__fspath__") {
            let path = path.cast::<PyString>().map_err(|_| error("a path must be a text, and not bytes"))?;
            return self.text(path);
        }
        if let Ok(items) = object.try_iter() {
            let mut list = Vec::new();
            for item in items {
                let value = self.value(&item?, depth + 1)?;
                list.push(value.ok_or_else(|| error("None in a list: leave the key out instead"))?);
            }
            return Ok(Some(Value::Array(list)));
        }
        let kind = object.get_type().name()?;
        Err(error(format!("a {kind} is neither a number, a text, a list, nor a dict of these")))
    }

    fn text(&self, text: &Bound<'_, PyString>) -> PyResult<Option<Value>> {
        if text.len()? > MOST_VALUES {
            return Err(error(format!("a text of more than {MOST_VALUES} characters")));
        }
        let text = text.extract().map_err(|_| error("a text that is no Unicode"))?;
        Ok(Some(Value::String(text)))
    }
}

/// Names the key whose value cannot be read. What the caller's own functions raise, and what is no fault of the value, stays as it is.
fn of_key(py: Python<'_>, key: &str, cause: PyErr) -> PyErr {
    if !cause.is_instance_of::<Error>(py) {
        return cause;
    }
    error(format!("`{key}`: {}", cause.value(py)))
}

/// Sorts settings into the tables of a shot file.
pub fn tables_of_settings(settings: &Bound<'_, PyDict>) -> PyResult<Table> {
    let mut tables = Table::new();
    let mut put = |name: &str, key: &str, value: Value| {
        let table = tables.entry(name).or_insert_with(|| Value::Table(Table::new()));
        if let Some(table) = table.as_table_mut() {
            table.insert(key.into(), value);
        }
    };
    for (key, value) in table(settings)? {
        let occlusion = OCCLUSION.iter().find(|(name, _)| *name == key);
        match (key.as_str(), value) {
            (table, Value::Table(all)) if TABLES.contains(&table) => {
                all.into_iter().for_each(|(key, value)| put(table, &key, value));
            }
            // a quality says that there is to be one
            ("denoise", quality @ Value::String(_)) => {
                put("output", "denoise", Value::Boolean(true));
                put("output", "denoise_quality", quality);
            }
            ("layers", Value::String(names)) => {
                let names = names.split(',').map(|name| Value::from(name.trim())).collect();
                put("output", "layers", Value::Array(names));
            }
            (key, value) if INDIRECT.contains(&key) => put("indirect", key, value),
            (key, value) if OUTPUT.contains(&key) => put("output", key, value),
            (_, value) if occlusion.is_some() => {
                put("occlusion", occlusion.map_or("", |(_, key)| key), value);
            }
            (key, value) => put("render", key, value),
        }
    }
    Ok(tables)
}

/// Message of an error, without the name of a file that nobody has written.
pub fn told(error: &SceneError) -> String {
    if error.path.as_os_str() == NAME { error.message.clone() } else { error.to_string() }
}
