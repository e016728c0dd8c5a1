//! Cuts a shot that fails down to a few lines that fail in the same way.

use toml::{Table, Value};

/// A way to a value: keys of tables, and places in lists.
type Place = Vec<Step>;

#[derive(Debug, Clone, PartialEq)]
enum Step {
    Key(String),
    Number(usize),
}

/// The smallest shot found for which `fails` is true, as it is for `shot`. It is asked `most` times at most.
pub fn shrink(shot: &Table, most: usize, mut fails: impl FnMut(&Table) -> bool) -> Table {
    let mut best = Value::Table(shot.clone());
    let mut asked = 0;
    let mut ask = |candidate: &Value| {
        asked += 1;
        asked <= most && candidate.as_table().is_some_and(&mut fails)
    };
    loop {
        let before = best.clone();
        remove(&mut best, &mut ask);
        simplify(&mut best, &mut ask);
        if best == before {
            break;
        }
    }
    match best {
        Value::Table(table) => table,
        _ => shot.clone(),
    }
}

/// Removes whatever can be removed, large things first.
fn remove(best: &mut Value, fails: &mut impl FnMut(&Value) -> bool) {
    let mut places = vec![];
    find(best, &mut vec![], &mut places);
    places.sort_by_key(Vec::len);
    // from the end, so that places in lists that come before stay what they are
    places.reverse();
    places.sort_by_key(Vec::len);
    for place in places {
        let mut candidate = best.clone();
        if take(&mut candidate, &place) && fails(&candidate) {
            *best = candidate;
        }
    }
}

/// Makes numbers and texts simpler.
fn simplify(best: &mut Value, fails: &mut impl FnMut(&Value) -> bool) {
    let mut places = vec![];
    find(best, &mut vec![], &mut places);
    for place in places {
        let Some(value) = at(best, &place).cloned() else { continue };
        for simpler in simpler_than(&value) {
            let mut candidate = best.clone();
            if let Some(value) = at_mut(&mut candidate, &place) {
                *value = simpler;
            }
            if fails(&candidate) {
                *best = candidate;
                break;
            }
        }
    }
}

/// What may stand instead of a value, the simplest first.
fn simpler_than(value: &Value) -> Vec<Value> {
    match value {
        Value::Float(value) => {
            let rounded = [0.0, 1.0, value.round(), (value * 10.0).round() / 10.0];
            let better = rounded.into_iter().filter(|other| cost(*other) < cost(*value));
            better.map(Value::Float).collect()
        }
        Value::Integer(value) => {
            let smaller = [0, 1, 2, value / 2, value - 1].into_iter();
            smaller.filter(|other| *other >= 0 && other < value).map(Value::Integer).collect()
        }
        Value::String(text) => frames_less(text).into_iter().map(Value::String).collect(),
        _ => vec![],
    }
}

/// How much there is to read of a number.
fn cost(value: f64) -> usize {
    value.to_string().len() + usize::from(value != 0.0)
}

/// Of frames as `first-last`: fewer.
fn frames_less(text: &str) -> Vec<String> {
    let Some((first, last)) = text.rsplit_once('-') else { return vec![] };
    let (Ok(first), Ok(last)) = (first.parse::<i64>(), last.parse::<i64>()) else { return vec![] };
    let mut less = vec![];
    if first < last {
        less.push(format!("{first}-{}", first + (last - first) / 2));
        less.push(format!("{first}-{}", last - 1));
        less.push(format!("{}-{last}", first + 1));
    }
    less
}

/// The places of all values below `value`, outer ones before inner ones.
fn find(value: &Value, place: &mut Place, places: &mut Vec<Place>) {
    let mut below = |step: Step, value: &Value| {
        place.push(step);
        places.push(place.clone());
        find(value, place, places);
        place.pop();
    };
    match value {
        Value::Table(table) => {
            table.iter().for_each(|(key, value)| below(Step::Key(key.clone()), value));
        }
        // a list of numbers is one value to be removed, and each of them one to be made simpler
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(number, value)| below(Step::Number(number), value));
        }
        _ => {}
    }
}

fn at<'v>(value: &'v Value, place: &[Step]) -> Option<&'v Value> {
    place.iter().try_fold(value, |value, step| match step {
        Step::Key(key) => value.get(key),
        Step::Number(number) => value.get(number),
    })
}

fn at_mut<'v>(value: &'v mut Value, place: &[Step]) -> Option<&'v mut Value> {
    place.iter().try_fold(value, |value, step| match step {
        Step::Key(key) => value.get_mut(key),
        Step::Number(number) => value.get_mut(number),
    })
}

/// Keys that stay: without them pictures would be large, or have many samples, paths or exposures.
const STAY: [&str; 7] = ["render", "size", "samples", "exposures", "frames", "indirect", "paths"];

/// Takes away what is at `place`. Numbers of a vector stay: it would be none without them.
fn take(value: &mut Value, place: &[Step]) -> bool {
    let Some((last, before)) = place.split_last() else { return false };
    if matches!(last, Step::Key(key) if STAY.contains(&key.as_str())) {
        return false;
    }
    match (at_mut(value, before), last) {
        (Some(Value::Table(table)), Step::Key(key)) => table.remove(key).is_some(),
        (Some(Value::Array(list)), Step::Number(number)) => {
            let is_vector = list.iter().all(|value| value.is_float() || value.is_integer());
            let is_there = *number < list.len() && !is_vector;
            if is_there {
                list.remove(*number);
            }
            is_there
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_matter_goes() {
        let shot: Table = toml::from_str(
            "title = 'all'\n[shutter]\nopen = 0.5\n[[light]]\npower = 3.25\n[[light]]\npower = 7.0\n[[model]]\nobj = 'a'",
        )
        .expect("is TOML");
        let is_bright = |shot: &Table| {
            let lights = shot.get("light").and_then(Value::as_array);
            lights.is_some_and(|lights| {
                lights.iter().any(|light| light["power"].as_float().is_some_and(|power| power > 3.0))
            })
        };
        // a light without a power would stop the test: it is no answer
        let small = shrink(&shot, 1000, |shot| std::panic::catch_unwind(|| is_bright(shot)).unwrap_or(false));
        assert_eq!(toml::to_string(&small).expect("is TOML").lines().count(), 2, "{small}");
    }

    #[test]
    fn frames_become_fewer() {
        assert_eq!(frames_less("-3-5"), ["-3-1", "-3-4", "-2-5"]);
        assert!(frames_less("cube-m1.obj").is_empty() && frames_less("2-2").is_empty());
    }
}
