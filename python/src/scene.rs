//! The class `Scene`: a shot that was loaded.

use std::path::PathBuf;
use std::sync::Arc;

use afterimage::scene::Shot;
use pyo3::prelude::*;

use crate::aside::aside;

/// A shot: models, lights, camera, and how they are rendered.
#[pyclass(frozen, module = "afterimage")]
pub struct Scene {
    /// The shot as it was loaded.
    pub shot: Arc<Shot>,
}

/// Loads a shot file (.toml), or a model (.obj, .ply, .gltf, .glb, .usda, .usdc, .usdz).
#[pyfunction]
#[pyo3(signature = (path, *, strict = false))]
pub fn load(py: Python<'_>, path: PathBuf, strict: bool) -> PyResult<Scene> {
    let shot = aside(py, move || afterimage::scene::load(&path, strict).map_err(|cause| cause.to_string()))?;
    Ok(Scene { shot: Arc::new(shot) })
}

#[pymethods]
impl Scene {
    /// Numbers of the frames that the shot names, in rising order.
    #[getter]
    fn frames(&self) -> Vec<i32> {
        self.shot.frames.list()
    }

    /// Warnings of the loader: what the picture shows a stand-in for, and what is odd.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.shot.warnings.iter().map(|warning| warning.0.to_string()).collect()
    }

    /// Width and height of the pictures, pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.shot.settings.width, self.shot.settings.height)
    }
}
