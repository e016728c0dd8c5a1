//! What keys there are, and when: the ways in which anything may change in a shot.

use toml::{Table, Value};

use super::settings::Span;
use super::table;
use crate::dice::Dice;

/// How something changes over a shot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Never.
    Rests,
    /// From the first frame to the last.
    Moves,
    /// Between two frames.
    Jumps,
    /// Rests, moves, and rests again, with keys between frames.
    Pauses,
    /// There and back again.
    Returns,
}

impl Way {
    const CHANGING: [Self; 4] = [Self::Moves, Self::Jumps, Self::Pauses, Self::Returns];

    /// Any; it rests as often as all others together.
    pub fn roll(dice: &mut Dice) -> Self {
        if dice.one_in(2) { Self::Rests } else { *dice.pick(&Self::CHANGING) }
    }

    /// Frames of keys, rising, and which value each has: a number from 0 on.
    pub fn keys(self, dice: &mut Dice, span: &Span) -> Vec<(f64, usize)> {
        let [first, last] = [span.first as f64, span.last as f64];
        let middle = (span.first + dice.whole(1, (span.last - span.first).max(1))) as f64;
        match self {
            Self::Rests => vec![],
            Self::Moves => vec![(first, 0), (last, 1)],
            Self::Jumps => vec![(middle - 1.0, 0), (middle, 1)],
            Self::Pauses => {
                let late = if dice.one_in(2) { 0.5 } else { 0.0 };
                vec![(first, 0), (middle - 0.75, 0), (middle + 0.75 + late, 1), (last + 2.0, 1)]
            }
            Self::Returns => vec![(first, 0), (middle + 0.25, 1), (last.max(middle) + 1.0, 0)],
        }
    }
}

/// Adds keys to the list `key` of `table`: at each frame what `value` gives for the number of the value there.
pub fn add_keys(
    table: &mut Table,
    keys: &[(f64, usize)],
    mut value: impl FnMut(usize) -> Vec<(&'static str, Value)>,
) {
    let mut list: Vec<Value> = match table.remove("key") {
        Some(Value::Array(list)) => list,
        _ => vec![],
    };
    for (frame, number) in keys {
        let mut key = Table::new();
        key.insert("frame".into(), frame_value(*frame));
        key.extend(value(*number).into_iter().map(|(name, value)| (name.to_string(), value)));
        list.push(Value::Table(key));
    }
    table.insert("key".into(), Value::Array(list));
}

/// Adds keys between which a thing comes and goes, and says whether it is there before them.
pub fn add_visibility(dice: &mut Dice, span: &Span, model: &mut Table) {
    let mut is_there = dice.one_in(2);
    model.extend(table([("visible", Value::Boolean(is_there))]));
    let mut at = span.first + dice.whole(0, 2);
    let mut keys = vec![];
    while at <= span.last && keys.len() < 4 {
        is_there = !is_there;
        keys.push((at as f64 - if dice.one_in(4) { 0.5 } else { 0.0 }, usize::from(is_there)));
        at += dice.whole(1, 4);
    }
    if !keys.is_empty() {
        add_keys(model, &keys, |is_there| vec![("visible", Value::Boolean(is_there == 1))]);
    }
}

/// Whole where it can be: so people write frames.
fn frame_value(frame: f64) -> Value {
    if frame.fract() == 0.0 { Value::Integer(frame as i64) } else { Value::Float(frame) }
}
