//! Lights of every type that rest, move, jump, fade from nothing, go out, and change their colour.

use toml::{Table, Value};

use super::settings::Span;
use super::tracks::{Way, add_keys};
use super::{color, numbers, place, table};
use crate::dice::Dice;

pub fn add(dice: &mut Dice, span: &Span, shot: &mut Table) {
    let few = *dice.pick(&[0, 1, 1, 1, 2, 2, 3]);
    // more than are weighed at once, and more than are weighed one by one
    let count = if few == 3 && dice.one_in(2) { *dice.pick(&[10, 10, 40]) } else { few };
    if count == 0 {
        return;
    }
    let lights = (0..count).map(|_| Value::Table(light(dice, span)));
    shot.insert("light".into(), Value::Array(lights.collect()));
}

/// Powers that a light goes between; the least and the largest are there to find what is compared with nothing.
const POWERS: [[f64; 2]; 7] =
    [[3.0, 0.0], [0.0, 3.0], [1e-30, 4.0], [2.0, 1e-30], [1.0, 5.0], [0.0, 0.0], [4.0, 1e-3]];

fn light(dice: &mut Dice, span: &Span) -> Table {
    let kind = *dice.pick(&["directional", "point", "spot", "rectangle", "disk", "sphere", "sun"]);
    let is_far = matches!(kind, "directional" | "sun");
    let name = if kind == "sun" { "directional" } else { kind };
    let mut light = table([("type", name.into()), ("power", dice.between(0.5, 4.0).into())]);
    let mut set = |key: &str, value: Value| drop(light.insert(key.into(), value));
    let [from, to] = [0, 1].map(|_| {
        let [x, y, z] = place(dice, 1.5);
        [x, y.abs() + 0.8, z + 0.5]
    });
    let downwards = |at: [f64; 3]| at.map(|along| -along);
    match is_far {
        true => set("direction", numbers(downwards(from))),
        false => set("position", numbers(from)),
    }
    match kind {
        "spot" => {
            set("cone", dice.between(20.0, 120.0).into());
            set("soft", Value::Float(*dice.pick(&[0.0, 0.5, 1.0])));
            if dice.one_in(2) {
                set("radius", dice.between(0.05, 0.8).into());
                set("samples", Value::Integer(*dice.pick(&[1, 4, 16])));
            }
        }
        "rectangle" => {
            set("size", numbers([dice.between(0.1, 2.0), dice.between(0.1, 2.0)]));
        }
        "disk" if dice.one_in(2) => set("size", numbers([dice.between(0.1, 1.5), dice.between(0.1, 1.5)])),
        "disk" | "sphere" => {
            set("radius", dice.between(0.05, 0.8).into());
            if kind == "sphere" && dice.one_in(2) {
                set("faces", true.into());
            }
        }
        "sun" => set("angle", Value::Float(*dice.pick(&[0.53, 5.0, 60.0, 179.0]))),
        _ => {}
    }
    if matches!(kind, "rectangle" | "disk") {
        if dice.one_in(2) {
            set("up", numbers(place(dice, 1.0)));
        }
        if dice.one_in(3) {
            set("spread", Value::Float(*dice.pick(&[1.0, 30.0, 90.0, 150.0, 180.0])));
        }
    }
    if matches!(kind, "spot" | "rectangle" | "disk") {
        set("target", numbers(place(dice, 0.5)));
    }
    if matches!(kind, "rectangle" | "disk" | "sphere" | "sun") {
        set("samples", Value::Integer(*dice.pick(&[1, 4, 16])));
    }
    if dice.one_in(8) {
        set("group", (*dice.pick(&["key", "fill"])).into());
    }
    let what = dice.below(7);
    let keys = Way::roll(dice).keys(dice, span);
    if !keys.is_empty() {
        let powers = *dice.pick(&POWERS);
        let sizes = sizes(dice, kind, &light);
        let colors = [color(dice), if dice.one_in(2) { [0.0; 3] } else { color(dice) }];
        add_keys(&mut light, &keys, |number| {
            let at = [from, to][number];
            let place =
                if is_far { ("direction", numbers(downwards(at))) } else { ("position", numbers(at)) };
            match what {
                0 | 1 => vec![place],
                2 | 3 => vec![("power", Value::Float(powers[number]))],
                4 => vec![("color", numbers(colors[number]))],
                6 if !sizes.is_empty() => {
                    sizes.iter().map(|(key, ends)| (*key, ends[number].clone())).collect()
                }
                _ => vec![place, ("power", Value::Float(powers[number]))],
            }
        });
    }
    light
}

/// What else may change of a light of a kind: keys, and two values of each.
fn sizes(dice: &mut Dice, kind: &str, light: &Table) -> Vec<(&'static str, [Value; 2])> {
    let mut between = |low: f64, high: f64| [0, 1].map(|_| Value::Float(dice.between(low, high)));
    match kind {
        "spot" => vec![
            ("cone", between(5.0, 150.0)),
            ("soft", between(0.0, 1.0)),
            // one of them may be a point now and then
            ("radius", [light.get("radius").cloned().unwrap_or(Value::Float(0.0)), Value::Float(0.3)]),
        ],
        "rectangle" => vec![
            ("size", [0, 1].map(|_| numbers(between(0.1, 2.0).map(|edge| edge.as_float().unwrap_or(1.0))))),
            ("spread", between(10.0, 170.0)),
        ],
        "disk" => vec![("radius", between(0.05, 0.8)), ("spread", between(10.0, 170.0))],
        "sphere" => vec![("radius", between(0.05, 0.8))],
        "sun" => vec![("angle", between(0.0, 90.0))],
        _ => vec![],
    }
}
