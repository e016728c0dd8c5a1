//! Values at the limits of what a shot may say, and beyond.

use toml::{Table, Value};

use crate::dice::Dice;

/// What numbers become.
const FLOATS: [f64; 14] = [
    0.0,
    -0.0,
    -1.0,
    1e-9,
    1e-30,
    1e-300,
    1e9,
    1e18,
    1e30,
    1e300,
    f64::MAX,
    f64::INFINITY,
    f64::NAN,
    0.999_999_9,
];

/// What whole numbers become.
const INTEGERS: [i64; 7] = [0, -1, 1, 3, 65_536, i64::MAX, i64::MIN];

/// Keys that decide how much there is to do: a test of a second must not become one of an hour.
const LEFT: [&str; 12] = [
    "size",
    "samples",
    "paths",
    "bounces",
    "rays",
    "exposures",
    "frames",
    "overscan",
    "reflection_map",
    "budget",
    "paths_per_frame",
    "reflections",
];

/// Replaces one or two numbers of `shot`.
pub fn spoil(dice: &mut Dice, shot: &mut Table) {
    for _ in 0..1 + dice.below(2) {
        let mut leaves = vec![];
        find(shot, &mut leaves);
        if leaves.is_empty() {
            return;
        }
        let number = dice.below(leaves.len());
        match leaves.swap_remove(number) {
            Value::Float(value) => *value = *dice.pick(&FLOATS),
            Value::Integer(value) => *value = *dice.pick(&INTEGERS),
            _ => {}
        }
    }
}

/// All numbers below `table` that may be replaced.
fn find<'t>(table: &'t mut Table, leaves: &mut Vec<&'t mut Value>) {
    for (key, value) in table.iter_mut() {
        if !LEFT.contains(&key.as_str()) {
            find_in(value, leaves);
        }
    }
}

fn find_in<'t>(value: &'t mut Value, leaves: &mut Vec<&'t mut Value>) {
    match value {
        Value::Table(table) => find(table, leaves),
        Value::Array(list) => list.iter_mut().for_each(|value| find_in(value, leaves)),
        Value::Float(_) | Value::Integer(_) => leaves.push(value),
        _ => {}
    }
}
