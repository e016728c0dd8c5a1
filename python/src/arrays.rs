//! From numpy's arrays to plain lists, whatever their type and layout.

use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::errors::error;

/// Reads an array of `N` numbers a row; `wanted` describes it. Other types of numbers and layouts are converted by numpy.
pub fn rows<const N: usize>(object: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<[f32; N]>> {
    let array = converted::<f32>(object, "float32", what)?;
    let shape = array.shape();
    if shape.len() != 2 || shape[1] != N {
        return Err(error(format!("`{what}` must have the shape (n, {N}), and has {shape:?}")));
    }
    let array = array.try_readonly().map_err(|cause| error(format!("`{what}`: {cause}")))?;
    let numbers = array.as_slice().map_err(|cause| error(format!("`{what}`: {cause}")))?;
    Ok(numbers.chunks_exact(N).map(|row| std::array::from_fn(|i| row[i])).collect())
}

/// Reads whole numbers that are not negative, in one dimension, or in rows of `row`.
pub fn numbers(object: &Bound<'_, PyAny>, row: Option<usize>, what: &str) -> PyResult<Vec<u32>> {
    let array = of_numpy(object, what)?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if !matches!(kind.as_str(), "i" | "u") && array.getattr("size")?.extract::<usize>()? > 0 {
        return Err(error(format!(
            "`{what}` must be whole numbers, and its dtype is {}",
            array.getattr("dtype")?
        )));
    }
    // as wide as any: what is negative or too large is told, and not wrapped around
    let array = converted::<i64>(&array, "int64", what)?;
    let shape = array.shape();
    match row {
        Some(row) if shape.len() != 2 || shape[1] != row => {
            return Err(error(format!("`{what}` must have the shape (m, {row}), and has {shape:?}")));
        }
        None if shape.len() != 1 => {
            return Err(error(format!("`{what}` must have one dimension, and has the shape {shape:?}")));
        }
        _ => {}
    }
    let array = array.try_readonly().map_err(|cause| error(format!("`{what}`: {cause}")))?;
    let all = array.as_slice().map_err(|cause| error(format!("`{what}`: {cause}")))?;
    let number = |number: &i64| {
        u32::try_from(*number)
            .map_err(|_| error(format!("`{what}` has {number}: numbers from 0 to 4294967295 are wanted")))
    };
    all.iter().map(number).collect()
}

/// Reads a matrix of 4 x 4 numbers, for column vectors: its last column is the translation.
pub fn matrix(object: &Bound<'_, PyAny>, what: &str) -> PyResult<[[f64; 4]; 4]> {
    let array = converted::<f64>(object, "float64", what)?;
    if array.shape() != [4, 4] {
        return Err(error(format!("`{what}` must have the shape (4, 4), and has {:?}", array.shape())));
    }
    let array = array.try_readonly().map_err(|cause| error(format!("`{what}`: {cause}")))?;
    let all = array.as_slice().map_err(|cause| error(format!("`{what}`: {cause}")))?;
    if !all.iter().all(|number| number.is_finite()) {
        return Err(error(format!("`{what}` has a number that is not finite")));
    }
    let rows: [[f64; 4]; 4] = std::array::from_fn(|row| std::array::from_fn(|column| all[4 * row + column]));
    if rows[3] != [0.0, 0.0, 0.0, 1.0] {
        return Err(error(format!(
            "`{what}`: the last row must be 0 0 0 1, and is {:?}; matrices are for column vectors: transpose those of row vectors",
            rows[3]
        )));
    }
    Ok(rows)
}

/// The object as an array of numpy, without a copy if it is one.
fn of_numpy<'py>(object: &Bound<'py, PyAny>, what: &str) -> PyResult<Bound<'py, PyAny>> {
    let made = object.py().import("numpy")?.call_method1("asarray", (object,));
    made.map_err(|cause| error(format!("`{what}` is no array of numbers: {}", cause.value(object.py()))))
}

/// An array of this type, one row behind the other: itself if it is one already, otherwise a copy.
fn converted<'py, T: numpy::Element>(
    object: &Bound<'py, PyAny>,
    dtype: &str,
    what: &str,
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let py = object.py();
    let array = of_numpy(object, what)?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    let refuse = |why: String| error(format!("`{what}` is no array of numbers: {why}"));
    if !matches!(kind.as_str(), "f" | "i" | "u") && array.getattr("size")?.extract::<usize>()? > 0 {
        return Err(refuse(format!("its dtype is {}", array.getattr("dtype")?)));
    }
    let made = py.import("numpy")?.call_method1("ascontiguousarray", (&array, dtype));
    let made = made.map_err(|cause| refuse(cause.value(py).to_string()))?;
    let array = made.cast_into::<PyArrayDyn<T>>();
    array.map_err(|_| refuse(String::from("numpy gave something else")))
}
