//! Cameras that rest, go, turn, zoom, jump, and stand in things.

use toml::{Table, Value};

use super::settings::Span;
use super::tracks::{Way, add_keys};
use super::{numbers, place};
use crate::dice::Dice;

/// What of a camera other settings depend on.
#[derive(Debug, Clone, Copy)]
pub struct Choice {
    pub is_orthographic: bool,
    /// It has a lens, or the shot a shutter.
    pub is_blurred: bool,
}

impl Choice {
    pub fn roll(dice: &mut Dice) -> Self {
        Self { is_orthographic: dice.one_in(5), is_blurred: dice.one_in(8) }
    }
}

/// What of the camera changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Motion {
    Rests,
    Goes,
    Turns,
    Zooms,
    Shifts,
    All,
}

pub fn add(dice: &mut Dice, span: &Span, choice: Choice, shot: &mut Table) {
    let motions = [
        Motion::Rests,
        Motion::Rests,
        Motion::Goes,
        Motion::Goes,
        Motion::Turns,
        Motion::Turns,
        Motion::Zooms,
        Motion::Shifts,
        Motion::All,
    ];
    let motion = *dice.pick(&motions);
    let changes = |kind: Motion| motion == kind || motion == Motion::All;
    let way =
        if motion == Motion::Rests { Way::Rests } else { *dice.pick(&[Way::Moves, Way::Jumps, Way::Pauses]) };
    let far = if choice.is_orthographic || !dice.one_in(10) {
        dice.between(4.0, 6.0)
    } else {
        dice.between(0.0, 1.0)
    };
    let eye = [dice.between(-1.0, 1.0), dice.between(-0.5, 1.5), far];
    let target = place(dice, 0.5);
    let aside = |dice: &mut Dice, reach: f64, from: [f64; 3]| {
        let step = place(dice, reach);
        [0, 1, 2].map(|axis| ((from[axis] + step[axis]) * 100.0).round() / 100.0)
    };
    let eyes = [eye, if changes(Motion::Goes) { aside(dice, 0.8, eye) } else { eye }];
    let targets = [target, if changes(Motion::Turns) { aside(dice, 0.6, target) } else { target }];
    let sizes =
        [0, 1].map(|key| if key == 0 || changes(Motion::Zooms) { dice.between(30.0, 60.0) } else { 0.0 });
    let shifts = [0, 1].map(|_| [dice.between(-0.2, 0.2), dice.between(-0.2, 0.2)]);
    let by_rotation = dice.one_in(6);
    let angles =
        [0, 1].map(|_| [dice.between(-10.0, 10.0), dice.between(-10.0, 10.0), dice.between(-20.0, 20.0)]);
    let aperture = [dice.between(0.0, 0.2), dice.between(0.0, 0.2)];
    let mut keys = way.keys(dice, span);
    if keys.is_empty() {
        keys.push((span.first as f64, 0));
    }
    let mut camera = Table::new();
    if choice.is_orthographic {
        camera.insert("projection".into(), "orthographic".into());
    }
    if dice.one_in(3) {
        camera.insert("interpolation".into(), "smooth".into());
    }
    add_keys(&mut camera, &keys, |number| {
        let mut key = vec![("eye", numbers(eyes[number]))];
        key.push(match by_rotation {
            true => ("rotation", numbers(angles[if changes(Motion::Turns) { number } else { 0 }])),
            false => ("target", numbers(targets[number])),
        });
        let size = if sizes[number] == 0.0 { sizes[0] } else { sizes[number] };
        match choice.is_orthographic {
            true => key.push(("height", (size / 12.0).into())),
            false => key.push(("fov", size.into())),
        }
        if changes(Motion::Shifts) {
            key.push(("shift", numbers(shifts[number])));
        }
        if choice.is_blurred && !choice.is_orthographic {
            key.push(("aperture", aperture[number].into()));
            key.push(("focus", Value::Float(4.0)));
        }
        key
    });
    if keys.len() > 1 && dice.one_in(8) {
        if let Some(key) = last_key(&mut camera) {
            key.insert("cut".into(), Value::Boolean(true));
            if let Some(frame) = key.get("frame").and_then(Value::as_float) {
                key.insert("frame".into(), Value::Integer(frame.ceil() as i64));
            }
        }
    }
    shot.insert("camera".into(), Value::Table(camera));
}

fn last_key(camera: &mut Table) -> Option<&mut Table> {
    camera.get_mut("key")?.as_array_mut()?.last_mut()?.as_table_mut()
}
