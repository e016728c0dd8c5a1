//! Reads the keys of a model in a shot file into its track.

use std::ops::Range;

use glam::{DAffine3, DMat3, DVec3};

use super::tracks::{frames_between, in_order, or, through_or};
use crate::animation::{Track, TransformTrack, Visibility};
use crate::scene::SceneError;
use crate::scene::keys::toml_text::{At, Three, TomlText};
use crate::scene::keys::{ModelKey, ModelTable, Rows, Scale};

/// Largest factor, about, by which a matrix may stretch a length, or shrink it.
const MOST_STRETCH: f64 = 1e9;

/// Largest ratio, about, of the stretches of a matrix in two directions: beyond it nothing is left of the
/// other direction.
const MOST_UNEVEN: f64 = 1e9;

/// Reads the motion of a model.
///
/// # Errors
/// With line and column: a value that makes no sense, or a track along which the model has no volume at some frame.
pub fn track(text: TomlText<'_>, table: &At<ModelTable>) -> Result<TransformTrack, SceneError> {
    let (model, how) = (table.get_ref(), table.get_ref().interpolation);
    let all = in_order(text, &model.key, |key| &key.frame)?;
    let keys: Vec<(f64, &At<ModelKey>)> =
        all.iter().copied().filter(|(_, key)| !says_visible_alone(key.get_ref())).collect();
    let vector = |key: &str, value: &Three| text.vector(key, value);
    let factor = |key: &str, value: &At<Scale>| scale(text, key, value);
    let map = |key: &str, value: &Rows| matrix(text, key, value);
    let translate = or(&model.translate, "translate", DVec3::ZERO, vector)?;
    let rotate = or(&model.rotate, "rotate", DVec3::ZERO, vector)?;
    let constant = or(&model.scale, "scale", DVec3::ONE, factor)?;
    let constant_matrix = or(&model.matrix, "matrix", DAffine3::IDENTITY, map)?;
    let has_matrix = model.matrix.is_some() || keys.iter().any(|(_, key)| key.get_ref().matrix.is_some());
    let matrices =
        through_or(constant_matrix, &keys, how, |key| or(&key.matrix, "matrix", constant_matrix, map))?;
    let track = TransformTrack {
        translate: through_or(translate, &keys, how, |key| {
            or(&key.translate, "translate", translate, vector)
        })?,
        rotate: through_or(rotate, &keys, how, |key| or(&key.rotate, "rotate", rotate, vector))?,
        scale: through_or(constant, &keys, how, |key| or(&key.scale, "scale", constant, factor))?,
        matrix: has_matrix.then_some(matrices),
        visible: visibility(model, &all),
        shapes: None,
    };
    refuse_flat(text, table, &keys, &track)?;
    Ok(track)
}

/// Byte range of the shot file that says what a model is.
pub fn place_of(table: &At<ModelTable>) -> Range<usize> {
    let ModelTable { obj, gltf, usd, ply, quadric, .. } = table.get_ref();
    let file = obj.as_ref().or(gltf.as_ref()).or(usd.as_ref()).or(ply.as_ref()).map(At::span);
    file.or_else(|| quadric.as_ref().map(At::span)).unwrap_or_else(|| table.span())
}

/// Returns true if a key states visibility alone, and nothing of the model's place.
fn says_visible_alone(key: &ModelKey) -> bool {
    let ModelKey { frame: _, translate, rotate, scale, matrix, visible } = key;
    let places = [translate.is_some(), rotate.is_some(), scale.is_some(), matrix.is_some()];
    visible.is_some() && places == [false; 4]
}

/// Reads the visibility: that of each key that states it, and before the first of these that of the model.
fn visibility(model: &ModelTable, keys: &[(f64, &At<ModelKey>)]) -> Visibility {
    let said = keys.iter().filter_map(|(frame, key)| Some((*frame, key.get_ref().visible?)));
    Visibility::through(model.visible.unwrap_or(true), said.collect())
        .expect("keys are in order, no two at a frame")
}

/// Refuses a model that its track makes flat at some frame: it would have no inside, and its normals no
/// direction.
fn refuse_flat(
    text: TomlText<'_>,
    table: &At<ModelTable>,
    keys: &[(f64, &At<ModelKey>)],
    track: &TransformTrack,
) -> Result<(), SceneError> {
    let Some((first, _)) = keys.first() else { return Ok(()) };
    let place = || place_of(table);
    let flat = |frame| track.scale.at(frame).signum() != track.scale.at(*first).signum();
    if let Some(frame) = frames_between(keys).find(|frame| flat(*frame)) {
        let message =
            format!("the scale of this model passes through zero before frame {frame}: keep it off zero");
        return Err(text.fault(place(), message));
    }
    let Some(matrix) = &track.matrix else { return Ok(()) };
    if let Some(frame) = flat_at(matrix, frames_between(keys)) {
        let message = format!(
            "the `matrix` of this model makes it flat at frame {frame}, or between it and the frame before: elements are \
             interpolated one by one, so add a key there, or turn the model with `rotate`"
        );
        return Err(text.fault(place(), message));
    }
    Ok(())
}

/// The first of `frames` at which a matrix is flat, or on the other side than at the first of all.
pub fn flat_at(matrix: &Track<DAffine3>, frames: impl Iterator<Item = f64>) -> Option<f64> {
    let mut frames = frames.peekable();
    let first = *frames.peek()?;
    let side = |frame| matrix.at(frame).matrix3.determinant().signum();
    frames.find(|frame| fault(matrix.at(*frame)).is_some() || side(*frame) != side(first))
}

fn scale(text: TomlText<'_>, key: &str, value: &At<Scale>) -> Result<DVec3, SceneError> {
    let factors = DVec3::from_array(value.get_ref().0);
    let fits = factors.to_array().iter().all(|factor| (1e-9..=1e9).contains(&factor.abs()));
    fits.then_some(factors)
        .ok_or_else(|| text.bad(key, value, "must not be zero (or below 1e-9, or above 1e9) along any axis"))
}

/// Reads three or four rows, for column vectors.
fn matrix(text: TomlText<'_>, key: &str, value: &Rows) -> Result<DAffine3, SceneError> {
    let rows: Vec<[f64; 4]> = value.get_ref().iter().map(|row| row.0).collect();
    let bad = |message: &str| Err(text.bad(key, value, message));
    let ([x, y, z] | [x, y, z, _]) = rows[..] else {
        return bad(&format!(
            "has {} rows: it must have 3, or 4 of which the last is [0, 0, 0, 1]",
            rows.len()
        ));
    };
    let last = [0.0, 0.0, 0.0, 1.0];
    // what is not finite is told below
    if rows.get(3).is_some_and(|row| *row != last && row.iter().all(|number| number.is_finite())) {
        return bad(if [x[3], y[3], z[3]] == [0.0; 3] {
            "has its translation in the last row: it must be in the last column, and the last row [0, 0, 0, 1]; transpose it"
        } else {
            "must have [0, 0, 0, 1] as its last row: there is no perspective in a model's place"
        });
    }
    matrix_of([x, y, z].as_flattened()).or_else(bad)
}

/// Makes an affine map of the twelve numbers of its rows.
///
/// # Errors
/// What a map must be that places a model.
pub fn matrix_of(rows: &[f64]) -> Result<DAffine3, &'static str> {
    if !rows.iter().all(|number| (*number as f32).is_finite()) {
        return Err("must have finite numbers alone");
    }
    let row = |number: usize| DVec3::from_slice(&rows[4 * number..]);
    let map = DAffine3 {
        matrix3: DMat3::from_cols(row(0), row(1), row(2)).transpose(),
        translation: DVec3::new(rows[3], rows[7], rows[11]),
    };
    fault(map).map_or(Ok(map), Err)
}

/// Reason why `map` cannot place a model.
fn fault(map: DAffine3) -> Option<&'static str> {
    // Frobenius norms: up to three times as large as the greatest stretch, and as one over the least
    let size =
        |matrix: DMat3| matrix.to_cols_array().iter().map(|number| number * number).sum::<f64>().sqrt();
    let (most, least) = (size(map.matrix3), size(map.matrix3.inverse()).recip());
    // false for NaN as well
    let is_solid = least > 0.0 && most <= least * MOST_UNEVEN;
    if !is_solid {
        return Some("makes the model flat (it has no inverse): no row may follow from the others");
    }
    let in_range = most <= MOST_STRETCH && least >= MOST_STRETCH.recip();
    (!in_range).then_some("must not make the model more than 1e9 times as large or as small")
}
