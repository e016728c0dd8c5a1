//! From Python's values to the text of a shot file: keys are written as the shot file has them, and read by its reader, so that they
//! mean the same and their errors say the same.

use afterimage::scene::SceneError;
use afterimage::scene::given::NAME;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyString};
use toml::{Table, Value};

use crate::errors::error;

/// Keys of other tables of a shot file than `[render]`, whose keys are the most.
const INDIRECT: [&str; 4] = ["paths", "bounces", "budget", "paths_per_frame"];
const OUTPUT: [&str; 4] = ["layers", "background", "denoise", "denoise_quality"];
const OCCLUSION: [(&str, &str); 2] = [("occlusion_radius", "radius"), ("occlusion_rays", "rays")];
const TABLES: [&str; 6] = ["render", "indirect", "occlusion", "output", "stereo", "shutter"];

/// Converts a value. `None` stands for a key that is not there.
pub fn value(object: &Bound<'_, PyAny>) -> PyResult<Option<Value>> {
    if object.is_none() {
        return Ok(None);
    }
    if let Ok(said) = object.extract::<bool>() {
        return Ok(Some(Value::Boolean(said)));
    }
    if let Ok(text) = object.cast::<PyString>() {
        return Ok(Some(Value::String(text.to_string())));
    }
    if let Ok(dict) = object.cast::<PyDict>() {
        return table(dict).map(|table| Some(Value::Table(table)));
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
        return Ok(Some(Value::String(path.extract::<String>()?)));
    }
    if let Ok(items) = object.try_iter() {
        let items = items
            .map(|item| value(&item?)?.ok_or_else(|| error("None in a list: leave the key out instead")));
        return Ok(Some(Value::Array(items.collect::<PyResult<_>>()?)));
    }
    let kind = object.get_type().name()?;
    Err(error(format!("a {kind} is neither a number, a text, a list, nor a dict of these")))
}

/// Converts a dict with keys of text.
pub fn table(dict: &Bound<'_, PyDict>) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, object) in dict {
        let key: String = key.extract()?;
        let of_key = |cause: PyErr| error(format!("`{key}`: {}", cause.value(dict.py())));
        if let Some(value) = value(&object).map_err(of_key)? {
            table.insert(key, value);
        }
    }
    Ok(table)
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
