//! From Python's values to the text of a shot file: keys are written as the shot file has them, and read by its reader, so that they
//! mean the same and their errors say the same.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyString};
use toml::{Table, Value};

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
        let items = items.map(|item| {
            value(&item?)?.ok_or_else(|| PyTypeError::new_err("None in a list: leave the key out instead"))
        });
        return Ok(Some(Value::Array(items.collect::<PyResult<_>>()?)));
    }
    let kind = object.get_type().name()?;
    Err(PyTypeError::new_err(format!("a {kind} is neither a number, a text, a list, nor a dict of these")))
}

/// Converts a dict with keys of text.
pub fn table(dict: &Bound<'_, PyDict>) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, object) in dict {
        let key: String = key.extract()?;
        let of_key = |error: PyErr| PyTypeError::new_err(format!("`{key}`: {}", error.value(dict.py())));
        if let Some(value) = value(&object).map_err(of_key)? {
            table.insert(key, value);
        }
    }
    Ok(table)
}
