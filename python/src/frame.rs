//! The class `Frame`: the layers of a finished frame as arrays.

use afterimage::film::{Film, Plane, Values};
use afterimage::frame::Finished;
use afterimage::layers::Layers;
use numpy::IntoPyArray;
use numpy::ndarray::{Array3, ShapeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pyo3::{PyTraverseError, PyVisit};
use rayon::prelude::*;

use crate::errors::error;

/// Name of the layer of the planes `R G B A`, which have none in a file.
const PICTURE: &str = "RGBA";

/// Layers whose numbers count things: exact as 32-bit floats, and unsigned integers in Python.
const NUMBERS: [&str; 2] = ["object", "material"];

/// Pixels that one thread handles in one go.
const BLOCK: usize = 1 << 14;

/// Numbers of a layer: rows from the top, pixels from the left, channels.
enum Numbers {
    Floats(Array3<f32>),
    Whole(Array3<u32>),
}

/// The picture of one eye, as arrays.
pub struct Picture {
    frame: i32,
    seconds: f64,
    /// Statistics as JSON.
    stats: String,
    layers: Vec<(String, Numbers)>,
}

impl Picture {
    /// Turns the planes of a frame that are in `layers`, and those of the denoised picture, into arrays.
    pub fn new(finished: &Finished, layers: Layers, denoised: &[Plane]) -> Result<Self, String> {
        let Finished { film, stats, .. } = finished;
        let planes = film.planes.iter().filter(|plane| layers.has_plane(&plane.name)).chain(denoised);
        // planes of a layer follow one another
        let mut grouped: Vec<(&str, Vec<&Plane>)> = Vec::new();
        for plane in planes {
            let layer = layer_of(&plane.name);
            match grouped.iter_mut().find(|(name, _)| *name == layer) {
                Some((_, planes)) => planes.push(plane),
                None => grouped.push((layer, vec![plane])),
            }
        }
        let layers = grouped.into_iter().map(|(name, planes)| {
            let numbers = numbers(name, film, &planes).map_err(|cause| format!("layer `{name}`: {cause}"))?;
            Ok((String::from(name), numbers))
        });
        Ok(Self {
            frame: stats.frame,
            seconds: stats.seconds.total,
            stats: serde_json::to_string(stats).map_err(|cause| cause.to_string())?,
            layers: layers.collect::<Result<_, String>>()?,
        })
    }
}

/// Name of the layer that a plane belongs to.
fn layer_of(plane: &str) -> &str {
    match plane.split_once('.') {
        Some((layer, _)) => layer,
        None if ["R", "G", "B", "A"].contains(&plane) => PICTURE,
        None => plane,
    }
}

/// Interleaves planes.
fn numbers(name: &str, film: &Film, planes: &[&Plane]) -> Result<Numbers, ShapeError> {
    let shape = (film.height as usize, film.width as usize, planes.len());
    let count = planes.len();
    let pixels = film.width as usize * film.height as usize;
    if NUMBERS.contains(&name) {
        let whole = planes.iter().flat_map(|plane| (0..pixels).map(|pixel| plane.values.get(pixel) as u32));
        return Array3::from_shape_vec(shape, whole.collect()).map(Numbers::Whole);
    }
    let mut all = vec![0.0_f32; pixels * count];
    all.par_chunks_mut(BLOCK * count).enumerate().for_each(|(block, all)| {
        let first = block * BLOCK;
        for (channel, plane) in planes.iter().enumerate() {
            let places = all.iter_mut().skip(channel).step_by(count);
            match &plane.values {
                Values::Half(values) => {
                    places.zip(&values[first..]).for_each(|(place, value)| *place = value.to_f32());
                }
                Values::Float(values) => {
                    places.zip(&values[first..]).for_each(|(place, value)| *place = *value);
                }
            }
        }
    });
    Array3::from_shape_vec(shape, all).map(Numbers::Floats)
}

/// A finished frame.
#[pyclass(frozen, module = "afterimage")]
pub struct Frame {
    /// Number of the frame.
    #[pyo3(get)]
    pub number: i32,
    /// Arrays by the name of the layer.
    #[pyo3(get)]
    layers: Py<PyDict>,
    /// Statistics, as those that the program writes as JSON.
    #[pyo3(get)]
    stats: Py<PyDict>,
    /// Seconds that it took.
    #[pyo3(get)]
    seconds: f64,
}

impl Frame {
    /// Creates a frame from the pictures of all eyes, the left one first.
    pub fn new(py: Python<'_>, pictures: Vec<Picture>) -> PyResult<Self> {
        let (layers, json) = (PyDict::new(py), py.import("json")?);
        let mut all_stats = Vec::new();
        let (mut number, mut seconds) = (0, 0.0);
        for (eye, picture) in pictures.into_iter().enumerate() {
            number = picture.frame;
            seconds += picture.seconds;
            for (name, numbers) in picture.layers {
                let name = if eye == 0 { name } else { format!("{name}.right") };
                match numbers {
                    Numbers::Floats(array) => layers.set_item(name, array.into_pyarray(py))?,
                    Numbers::Whole(array) => layers.set_item(name, array.into_pyarray(py))?,
                }
            }
            let stats = json.call_method1("loads", (picture.stats,))?;
            all_stats.push(stats.cast_into::<PyDict>().map_err(|_| error("statistics are no table"))?);
        }
        let mut all_stats = all_stats.into_iter();
        let stats = all_stats.next().ok_or_else(|| error("a frame without a picture"))?;
        if let Some(right) = all_stats.next() {
            stats.set_item("right", right)?;
        }
        Ok(Self { number, layers: layers.unbind(), stats: stats.unbind(), seconds })
    }
}

#[pymethods]
impl Frame {
    fn __repr__(&self) -> String {
        format!("<afterimage.Frame {}, {:.3} s>", self.number, self.seconds)
    }

    /// What the garbage collector must know: a caller may put anything into these dicts, the frame itself, too. They are what it clears
    /// then.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.layers)?;
        visit.call(&self.stats)
    }
}
