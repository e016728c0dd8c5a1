//! Exceptions.

use std::panic::{AssertUnwindSafe, catch_unwind};

use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

create_exception!(
    afterimage,
    Error,
    PyException,
    "An input that makes no sense, or work that could not be done. The text says what to do."
);
create_exception!(afterimage, Cancelled, Error, "The render was cancelled.");

/// Creates an `Error` with this message.
pub fn error(message: impl std::fmt::Display) -> PyErr {
    Error::new_err(message.to_string())
}

/// Calls a function of the library: its error becomes an `Error`, and so does a panic, which must not reach Python.
pub fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> PyResult<T> {
    let done = catch_unwind(AssertUnwindSafe(work));
    done.unwrap_or_else(|panic| Err(fault_of_ours(&*panic))).map_err(error)
}

/// Message about a panic, which is always our fault.
pub fn fault_of_ours(panic: &(dyn std::any::Any + Send)) -> String {
    let said = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let said = said.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    format!("afterimage has a fault, please report it with the scene: {said}")
}
