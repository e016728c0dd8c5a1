//! Places of prims below their parents (UsdGeomXformable): a track of maps out of a list of operations.

use std::collections::BTreeSet;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use openusd::usd::Prim;

use super::clock::Clock;
use super::value::{Answer, codes_read, numbers_at, value, words};
use crate::animation::{Interpolation, Track};

/// Parts of a frame after which what turns has keys: elements of matrices are interpolated one by one, which takes turned things off
/// their circles.
const STEPS_A_FRAME: f64 = 4.0;

/// Largest number of keys of a prim.
const MOST_KEYS: f64 = 4e6;

/// First entry of an order of operations that does without the parents' places.
const RESET: &str = "!resetXformStack!";

/// One operation.
struct Operation {
    /// Attribute that holds its value.
    attribute: String,
    kind: String,
    is_inverse: bool,
}

/// Place of a prim below its parent, or in the world.
pub struct Place {
    /// Map over frames. It may be flat.
    pub map: Track<DAffine3>,
    /// True if the parents' places mean nothing.
    pub is_reset: bool,
}

/// Reads the place of a prim. `None` if it has none of its own.
///
/// # Errors What the library says, or more keys than anybody needs.
pub fn place(prim: &Prim, clock: &Clock) -> Answer<Option<Place>> {
    let order = value(prim, "xformOpOrder", clock.code(clock.first()))?;
    let Some(order) = order.as_ref().and_then(words) else { return Ok(None) };
    let is_reset = order.iter().any(|name| name == RESET);
    let after_reset = order.iter().rposition(|name| name == RESET).map_or(0, |at| at + 1);
    let operations: Vec<Operation> = order[after_reset..].iter().map(|name| Operation::new(name)).collect();
    let (mut frames, mut moving, mut turns): (BTreeSet<u64>, usize, bool) = (BTreeSet::new(), 0, false);
    let mut times = Vec::new();
    for operation in &operations {
        let own = codes_read(prim, &operation.attribute, clock)?;
        if own.len() > 1 {
            moving += usize::from(operation.kind != "translate");
            turns |=
                operation.kind.starts_with("rotate") || operation.kind == "orient" || operation.is_inverse;
            times.extend(own.iter().map(|code| clock.frame(*code)));
        }
    }
    times.sort_by(f64::total_cmp);
    times.dedup();
    if let (Some(first), Some(last)) = (times.first(), times.last()) {
        if (last - first) * STEPS_A_FRAME > MOST_KEYS {
            return Err(String::from("it moves over more frames than anybody needs"));
        }
        if turns || moving > 1 {
            let steps = ((last - first) * STEPS_A_FRAME).ceil() as u32;
            let between = (0..steps).map(|step| first + f64::from(step) / STEPS_A_FRAME);
            times.extend(between.collect::<Vec<_>>());
        }
    }
    times.sort_by(f64::total_cmp);
    times.dedup();
    frames.extend(times.iter().map(|frame| frame.to_bits()));
    let at = |frame: f64| matrix(prim, &operations, clock.code(frame));
    if frames.is_empty() {
        return Ok(Some(Place { map: Track::constant(at(clock.first())?), is_reset }));
    }
    let keys = frames.into_iter().map(|bits| {
        let frame = f64::from_bits(bits);
        Ok((frame, at(frame)?))
    });
    let keys = keys.collect::<Answer<Vec<_>>>()?;
    let map = Track::through(keys, Interpolation::Linear).expect("frames are finite, and each is there once");
    Ok(Some(Place { map, is_reset }))
}

/// Map of a list of operations; the last one is applied first.
fn matrix(prim: &Prim, operations: &[Operation], code: f64) -> Answer<DAffine3> {
    let mut map = DAffine3::IDENTITY;
    for operation in operations {
        map *= operation.map(prim, code)?;
    }
    Ok(map)
}

impl Operation {
    /// Reads a name such as `!invert!xformOp:translate:pivot`.
    fn new(name: &str) -> Self {
        let (is_inverse, attribute) = match name.strip_prefix("!invert!") {
            Some(rest) => (true, rest),
            None => (false, name),
        };
        let kind = attribute.split(':').nth(1).unwrap_or_default().to_string();
        Self { attribute: attribute.to_string(), kind, is_inverse }
    }

    fn map(&self, prim: &Prim, code: f64) -> Answer<DAffine3> {
        let numbers = numbers_at(prim, &self.attribute, code)?.unwrap_or_default();
        let map = map_of(&self.kind, &numbers).unwrap_or(DAffine3::IDENTITY);
        Ok(if self.is_inverse { map.inverse() } else { map })
    }
}

/// Map of a matrix. `None` if it has not 16 numbers.
pub fn affine(matrix: &[f64]) -> Option<DAffine3> {
    // rows there, for row vectors, are columns here
    let map = DMat4::from_cols_array(matrix.try_into().ok()?);
    Some(DAffine3 {
        matrix3: DMat3::from_cols(map.x_axis.truncate(), map.y_axis.truncate(), map.z_axis.truncate()),
        translation: map.w_axis.truncate(),
    })
}

/// Places of things whose scales, turns and translations are in lists: what a list lacks does nothing.
pub struct Places {
    pub translations: Vec<f64>,
    /// Quaternions, of any length: x, y, z, w.
    pub turns: Vec<f64>,
    pub scales: Vec<f64>,
}

impl Places {
    /// Place of thing `number`.
    pub fn at(&self, number: usize) -> DAffine3 {
        let three = |list: &[f64], default: DVec3| {
            list.get(3 * number..3 * number + 3).map_or(default, DVec3::from_slice)
        };
        let turn = self.turns.get(4 * number..4 * number + 4).map_or(DQuat::IDENTITY, DQuat::from_slice);
        let length = turn.length();
        let turn = if length.is_normal() { turn * length.recip() } else { DQuat::IDENTITY };
        let (scale, translation) = (three(&self.scales, DVec3::ONE), three(&self.translations, DVec3::ZERO));
        DAffine3::from_scale_rotation_translation(scale, turn, translation)
    }
}

/// Map of an operation; angles are in degrees. `None` for one that is not known, or has too few numbers.
fn map_of(kind: &str, numbers: &[f64]) -> Option<DAffine3> {
    let three = || (numbers.len() >= 3).then(|| DVec3::from_slice(numbers));
    let turn = |axis: DVec3, degrees: f64| DQuat::from_axis_angle(axis, degrees.to_radians());
    let axis = |name: u8| match name {
        b'X' => Some((DVec3::X, 0)),
        b'Y' => Some((DVec3::Y, 1)),
        b'Z' => Some((DVec3::Z, 2)),
        _ => None,
    };
    match kind {
        "translate" => three().map(DAffine3::from_translation),
        "scale" => three().map(DAffine3::from_scale),
        "transform" => affine(numbers),
        "orient" => {
            let [x, y, z, w] = numbers.try_into().ok()?;
            Some(DAffine3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize()))
        }
        _ => {
            let axes = kind.strip_prefix("rotate")?.as_bytes();
            let mut turned = DQuat::IDENTITY;
            // the first axis of the name is turned about first
            for name in axes {
                let (axis, index) = axis(*name)?;
                let degrees = *numbers.get(if axes.len() == 1 { 0 } else { index })?;
                turned = turn(axis, degrees) * turned;
            }
            Some(DAffine3::from_quat(turned))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_axis_of_a_name_is_turned_about_first() {
        let turned = |kind: &str| map_of(kind, &[90.0, 0.0, 90.0]).map(|map| map.transform_vector3(DVec3::Y));
        // Y goes to Z about X and stays there; about Z first it goes to -X and stays there
        let near =
            |turned: Option<DVec3>, to: DVec3| turned.is_some_and(|turned| turned.abs_diff_eq(to, 1e-12));
        assert!(near(turned("rotateXYZ"), DVec3::Z) && near(turned("rotateZYX"), DVec3::NEG_X));
        assert_eq!(map_of("rotateXY", &[1.0]), None);
        assert_eq!(map_of("bend", &[1.0, 2.0, 3.0]), None);
    }
}
