//! The Python module `afterimage._afterimage`, of which the package `afterimage` is made.
//!
//! All that takes time happens on threads of its own ([`aside`]): the thread that Python calls from waits there without the
//! interpreter's lock, looks for signals, and reports progress. Rendering threads never call Python.
#![forbid(unsafe_code)]
#![allow(rustdoc::broken_intra_doc_links, reason = "docstrings of Python name tables in brackets")]

mod arrays;
mod aside;
mod convert;
mod curves;
mod errors;
mod forked;
mod frame;
mod keys;
mod meshes;
mod models;
mod motion;
mod render;
mod scene;
mod stated;
mod worker;

use pyo3::prelude::*;

/// Afterimage: a ray tracer for animations that reuses the previous frame's samples, exactly.
#[pymodule]
mod _afterimage {
    use pyo3::prelude::*;
    use pyo3::types::PyModule;

    #[pymodule_export]
    use crate::errors::{Cancelled, Error};
    #[pymodule_export]
    use crate::frame::Frame;
    #[pymodule_export]
    use crate::render::{Render, render};
    #[pymodule_export]
    use crate::scene::{Material, Mesh, Scene, load};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        // a thread that renders while the interpreter ends would use libraries that are gone
        let end = pyo3::wrap_pyfunction!(crate::end_all, module)?;
        PyModule::import(module.py(), "atexit")?.call_method1("register", (end,))?;
        Ok(())
    }
}

/// Ends all renders that are under way, and waits for their threads.
#[pyfunction]
fn end_all(py: Python<'_>) {
    let wait = worker::end_all();
    py.detach(wait);
}
