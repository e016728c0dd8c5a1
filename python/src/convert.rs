//! Arguments in the forms in which Python has them.

use afterimage::scene::Frames;
use afterimage::scene::frames::MOST_FRAMES;
use pyo3::prelude::*;
use pyo3::types::{PyRange, PyRangeMethods};
use toml::Value;

use crate::errors::{error, guarded};

/// Reads frames: a text as the program has it, a number, a range (whose step is that of the frames), or numbers one by one.
pub fn frames(object: &Bound<'_, PyAny>) -> PyResult<Frames> {
    let text = if let Ok(text) = object.extract::<String>() {
        text
    } else if let Ok(range) = object.cast::<PyRange>() {
        text_of_range(range)?
    } else if let Ok(number) = object.extract::<i32>() {
        number.to_string()
    } else {
        one_by_one(object)?.iter().map(i32::to_string).collect::<Vec<_>>().join(",")
    };
    if text.is_empty() {
        return Err(error("`frames` is empty: name one frame at least"));
    }
    guarded(|| Frames::parse(&text).map_err(|cause| format!("`frames`: {cause}")))
}

fn one_by_one(object: &Bound<'_, PyAny>) -> PyResult<Vec<i32>> {
    let wrong =
        || error("`frames` must be whole numbers: a list, a range, or a text like \"1-48\" or \"1-48x2\"");
    let mut numbers = Vec::new();
    for number in object.try_iter().map_err(|_| wrong())? {
        if numbers.len() as u64 == MOST_FRAMES {
            return Err(error(format!(
                "`frames`: more than {MOST_FRAMES} numbers: has the iterator an end?"
            )));
        }
        numbers.push(number?.extract().map_err(|_| wrong())?);
    }
    Ok(numbers)
}

fn text_of_range(range: &Bound<'_, PyRange>) -> PyResult<String> {
    if range.len()? == 0 {
        return Ok(String::new());
    }
    // the order is that of rendering in any case
    let ends = [range.get_item(0)?, range.get_item(-1)?].map(|end| end.extract::<i64>());
    let [a, b] = ends;
    let (a, b) = (a?, b?);
    Ok(format!("{}:{}x{}", a.min(b), a.max(b), range.step()?.unsigned_abs()))
}

/// Reads a frame rate: a number, or a fraction as text.
pub fn rate(object: &Bound<'_, PyAny>) -> PyResult<Value> {
    if let Ok(text) = object.extract::<String>() {
        return Ok(Value::String(text));
    }
    let rate = object.extract::<f64>().ok().filter(|rate| *rate > 0.0 && *rate <= 1e6);
    let rate =
        rate.ok_or_else(|| error("`fps` must be frames per second above 0, such as 24 or \"24000/1001\""))?;
    if rate.fract() == 0.0 {
        return Ok(Value::Integer(rate as i64));
    }
    Ok(Value::String(format!("{}/1000", (rate * 1000.0).round().max(1.0))))
}
