//! From numpy's arrays to plain lists, whatever their type and layout.

use afterimage::memory::{self, Need, Part};
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::{PyException, PyMemoryError};
use pyo3::prelude::*;

use crate::errors::error;

/// Numbers of a list, (n,).
pub fn list(object: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<f32>> {
    let array = converted::<f32>(object, "float32", what)?;
    let shape = array.shape();
    if shape.len() != 1 {
        return Err(error(format!("`{what}` must be a number or have the shape (n,), and has {shape:?}")));
    }
    let array = array.try_readonly().map_err(|cause| error(format!("`{what}`: {cause}")))?;
    let numbers = array.as_slice().map_err(|cause| error(format!("`{what}`: {cause}")))?;
    let mut all = room(numbers.len(), what)?;
    all.extend_from_slice(numbers);
    Ok(all)
}

/// Reads an array of `N` numbers a row; `wanted` describes it. Other types of numbers and layouts are converted by numpy.
pub fn rows<const N: usize>(object: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<[f32; N]>> {
    let array = converted::<f32>(object, "float32", what)?;
    let shape = array.shape();
    if shape.len() != 2 || shape[1] != N {
        return Err(error(format!("`{what}` must have the shape (n, {N}), and has {shape:?}")));
    }
    let array = array.try_readonly().map_err(|cause| error(format!("`{what}`: {cause}")))?;
    let numbers = array.as_slice().map_err(|cause| error(format!("`{what}`: {cause}")))?;
    let mut rows = room(numbers.len() / N, what)?;
    rows.extend(numbers.chunks_exact(N).map(|row| std::array::from_fn(|i| row[i])));
    Ok(rows)
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
    let mut numbers = room(all.len(), what)?;
    for all in all {
        numbers.push(number(all)?);
    }
    Ok(numbers)
}

/// An empty list with room for so many entries.
fn room<T>(count: usize, what: &str) -> PyResult<Vec<T>> {
    /// Bytes from which on the memory that is left is asked for: that takes as long as copying as many.
    const MANY: usize = 1 << 24;
    let bytes = count.saturating_mul(size_of::<T>());
    if bytes >= MANY {
        // where the system promises more than it has, it ends the process that takes it
        let need = Need::new(Part::new(format!("a copy of `{what}`"), bytes as u64, "smaller meshes"));
        need.check(&memory::left()).map_err(error)?;
    }
    let mut list = Vec::new();
    let reserved = list.try_reserve_exact(count);
    reserved.map_err(|_| PyMemoryError::new_err(format!("`{what}`: {bytes} bytes are not left")))?;
    Ok(list)
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
    made.map_err(|cause| refused(object.py(), cause, what))
}

/// An array of this type, one row behind the other, each number where the processor wants it: itself if it is one already, otherwise a
/// copy.
fn converted<'py, T: numpy::Element>(
    object: &Bound<'py, PyAny>,
    dtype: &str,
    what: &str,
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let py = object.py();
    let array = of_numpy(object, what)?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if !matches!(kind.as_str(), "f" | "i" | "u") && array.getattr("size")?.extract::<usize>()? > 0 {
        return Err(no_array(format!("its dtype is {}", array.getattr("dtype")?), what));
    }
    let wanted = ["C_CONTIGUOUS", "ALIGNED", "ENSUREARRAY"];
    let made = py.import("numpy")?.call_method1("require", (&array, dtype, wanted));
    let array = made.map_err(|cause| refused(py, cause, what))?.cast_into::<PyArrayDyn<T>>();
    array.map_err(|_| no_array("numpy gave something else", what))
}

/// The error for what numpy raises. What says that there is too little memory, and what is no exception that a program handles, such as
/// an interrupt, stays as it is.
fn refused(py: Python<'_>, cause: PyErr, what: &str) -> PyErr {
    if cause.is_instance_of::<PyMemoryError>(py) || !cause.is_instance_of::<PyException>(py) {
        return cause;
    }
    no_array(cause.value(py), what)
}

fn no_array(why: impl std::fmt::Display, what: &str) -> PyErr {
    error(format!("`{what}` is no array of numbers: {why}"))
}
