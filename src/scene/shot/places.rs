//! Reads the places of a model's copies from their file.

use std::fmt::Display;
use std::path::Path;

use glam::DAffine3;

use super::model;
use super::shapes::STEPS;
use super::tracks::whole_frames;
use crate::animation::{Interpolation, Track, Visibility};
use crate::digest::Digest;
use crate::input::{self, Input, Kind};
use crate::scene::import::Inputs;
use crate::scene::import::npy::{self, Array};
use crate::scene::keys::places::PlacesTable;
use crate::scene::keys::toml_text::TomlText;
use crate::scene::keys::values::file_of;
use crate::scene::{Model, SceneError};

/// Numbers of a matrix.
const MATRIX: usize = 12;

/// Place of a copy over time.
#[derive(Debug)]
pub struct Place {
    /// Its name, if a file has names.
    name: Option<String>,
    /// Its number for graphs, if a file has numbers.
    random: Option<f32>,
    matrix: Track<DAffine3>,
    visible: Visibility,
}

/// Reads the places of copies that `table` names.
///
/// # Errors With line and column: values that make no sense. With its file: an array of another shape, or matrices that place nothing.
pub fn of_table(
    text: TomlText<'_>,
    table: &PlacesTable,
    how: Interpolation,
    inputs: &mut Inputs,
) -> Result<Vec<Place>, SceneError> {
    let PlacesTable { file, names, randoms, first, every } = table;
    let path = file_of(text, "file", file)?;
    let array = array_at(&path, inputs)?;
    let keys = match array.shape[..] {
        [_, 3, 4] => 1,
        [_, keys, 3, 4] if keys > 0 => keys,
        _ => {
            let message = format!(
                "the array's shape is {:?}: it must be (copies, 3, 4), or (copies, keys, 3, 4)",
                array.shape
            );
            return Err(SceneError::new(path, message));
        }
    };
    for (key, value) in [("first", first), ("every", every)] {
        if let Some(value) = value.as_ref().filter(|_| array.shape.len() == 3) {
            let message =
                "goes with an array of copies x keys x 3 x 4: copies without keys are at rest; take it out";
            return Err(text.bad(key, value, message));
        }
    }
    let is_frame = |frame: f64| frame.abs() <= f64::from(i32::MAX);
    let first =
        first.as_ref().map_or(Ok(1.0), |first| text.number("first", first, "a frame's number", is_frame))?;
    let is_step = |every| STEPS.contains(&every);
    let every = every
        .as_ref()
        .map_or(Ok(1.0), |every| text.number("every", every, "from 1e-6 to 1e6 frames", is_step))?;
    let frames: Vec<f64> = (0..keys).map(|key| first + key as f64 * every).collect();
    if frames.windows(2).any(|pair| pair[0] == pair[1]) || !frames.iter().all(|frame| is_frame(*frame)) {
        return Err(
            text.fault(file.span(), "the frames of the keys are too large, or too close to each other")
        );
    }
    let copies = array.values.chunks_exact(MATRIX * keys).enumerate().map(|(copy, numbers)| {
        let place = place(numbers, &frames, how);
        place.map_err(|what| SceneError::new(&path, format!("copy {}, counted from 0: {what}", copy)))
    });
    let mut places: Vec<Place> = copies.collect::<Result<_, _>>()?;
    if let Some(names) = names {
        let path = file_of(text, "names", names)?;
        name_all(&mut places, &lines_of(&path, inputs)?, &path)?;
    }
    if let Some(randoms) = randoms {
        let path = file_of(text, "randoms", randoms)?;
        number_all(&mut places, &array_at(&path, inputs)?, &path)?;
    }
    Ok(places)
}

/// Reads an array.
///
/// # Errors
/// Those of [`npy::read`].
fn array_at(path: &Path, inputs: &mut Inputs) -> Result<Array, SceneError> {
    let array = npy::read(path)?;
    inputs.add([path.to_path_buf()], array.digest);
    Ok(array)
}

/// Reads the lines of a text.
///
/// # Errors
/// Where it cannot be read, or is no text.
fn lines_of(path: &Path, inputs: &mut Inputs) -> Result<Vec<String>, SceneError> {
    let unreadable =
        |error: &dyn Display| SceneError::new(path, format!("the names cannot be read: {error}"));
    let bytes =
        input::open(path, Kind::Names).and_then(Input::read_all).map_err(|error| unreadable(&error))?;
    let text = std::str::from_utf8(&bytes).map_err(|_| unreadable(&"they must be UTF-8 text"))?;
    inputs.add([path.to_path_buf()], Digest::new(&bytes));
    Ok(text.lines().map(String::from).collect())
}

/// Gives each place its name.
fn name_all(places: &mut [Place], names: &[String], path: &Path) -> Result<(), SceneError> {
    if names.len() != places.len() {
        let message = format!(
            "it has {} lines, and there are {} copies: write a name a line",
            names.len(),
            places.len()
        );
        return Err(SceneError::new(path, message));
    }
    places.iter_mut().zip(names).for_each(|(place, name)| place.name = Some(name.clone()));
    Ok(())
}

/// Gives each place its number.
fn number_all(places: &mut [Place], numbers: &Array, path: &Path) -> Result<(), SceneError> {
    if numbers.shape != [places.len()] {
        let message = format!(
            "the array's shape is {:?}, and there are {} copies: it must have a number for each",
            numbers.shape,
            places.len()
        );
        return Err(SceneError::new(path, message));
    }
    if let Some(copy) = numbers.values.iter().position(|number| !(0.0..=1.0).contains(number)) {
        let message = format!("number {copy}, counted from 0, is not from 0 to 1");
        return Err(SceneError::new(path, message));
    }
    places.iter_mut().zip(&numbers.values).for_each(|(place, number)| place.random = Some(*number as f32));
    Ok(())
}

/// Makes a place of the matrices at these `frames`.
fn place(numbers: &[f64], frames: &[f64], how: Interpolation) -> Result<Place, String> {
    let mut matrices: Vec<(f64, DAffine3)> = Vec::with_capacity(frames.len());
    let (mut seen, mut appears) = (Vec::new(), Vec::new());
    for (numbers, frame) in numbers.chunks_exact(MATRIX).zip(frames) {
        let is_there = numbers.iter().any(|number| *number != 0.0);
        let comes = is_there && seen.last().is_some_and(|(_, was_there)| !was_there);
        if comes {
            appears.push(*frame);
        }
        seen.push((*frame, is_there));
        if is_there {
            let matrix =
                model::matrix_of(numbers).map_err(|what| format!("the matrix of frame {frame} {what}"))?;
            matrices.push((*frame, matrix));
        } else if let Some((_, before)) = matrices.last().copied() {
            // until then it is where it was last
            matrices.push((*frame, before));
        }
    }
    let Some((frame, matrix)) = matrices.first().copied() else {
        let visible = Visibility::through(false, Vec::new()).expect("there are no keys");
        return Ok(Place { name: None, random: None, matrix: Track::constant(DAffine3::IDENTITY), visible });
    };
    let is_first_there = seen[0].1;
    let changes = seen.chunk_by(|a, b| a.1 == b.1).skip(1).map(|run| run[0]);
    let visible = Visibility::through(is_first_there, changes.collect()).expect("frames are finite and rise");
    if matrices.iter().all(|(_, other)| *other == matrix) {
        return Ok(Place { name: None, random: None, matrix: Track::constant(matrix), visible });
    }
    let last = matrices[matrices.len() - 1].0;
    let matrix = Track::through(matrices, how).expect("frames are finite and rise").cut_at(&appears);
    match model::flat_at(&matrix, whole_frames(frame, last)) {
        Some(frame) => Err(format!(
            "it is flat, or turned inside out, at frame {frame}: elements are interpolated one by one"
        )),
        None => Ok(Place { name: None, random: None, matrix, visible }),
    }
}

/// Makes of each model a copy for each place.
pub fn copies(models: &[Model], places: &[Place]) -> Vec<Model> {
    let named = |place: &Place, number: usize, model: &Model| match &place.name {
        None => format!("{}/{number}", model.name),
        Some(name) if models.len() == 1 => name.clone(),
        Some(name) => format!("{name}/{}", model.name),
    };
    let all = places.iter().zip(1..).flat_map(|(place, number)| {
        models.iter().map(move |model| {
            let mut copy = Model { name: named(place, number, model), ..model.clone() };
            let own = copy.track.matrix.take();
            copy.track.matrix =
                Some(own.map_or_else(|| place.matrix.clone(), |own| place.matrix.after(&own)));
            copy.track.visible = place.visible.and(&copy.track.visible);
            copy.random = place.random.unwrap_or(copy.random);
            copy
        })
    });
    all.collect()
}
