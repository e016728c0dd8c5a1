//! Links of lights, and of what models emit: which models they light, and which cast shadows in their light.

use toml::{Table, Value};

use crate::dice::Dice;

/// Groups of models. Each is some model's.
const GROUPS: [&str; 2] = ["first", "second"];

/// Perhaps links some lights, and what some models emit, to groups of models.
pub fn add(dice: &mut Dice, shot: &mut Table) {
    if !dice.one_in(3) {
        return;
    }
    let Some(models) = shot.get_mut("model").and_then(Value::as_array_mut) else { return };
    let count = models.len();
    if count == 0 {
        return;
    }
    // a group has a member whatever the dice say, or its name would be unknown
    let first = dice.below(count);
    for (number, model) in models.iter_mut().filter_map(Value::as_table_mut).enumerate() {
        let is_in = |dice: &mut Dice, group: usize| number == (first + group) % count || dice.one_in(2);
        let groups: Vec<Value> =
            (0..GROUPS.len()).filter(|group| is_in(dice, *group)).map(|group| GROUPS[group].into()).collect();
        if !groups.is_empty() {
            model.insert("groups".into(), Value::Array(groups));
        }
        link(dice, 4, model);
    }
    group(dice, shot);
    for light in shot.get_mut("light").and_then(Value::as_array_mut).into_iter().flatten() {
        light.as_table_mut().into_iter().for_each(|light| link(dice, 2, light));
    }
}

/// Perhaps puts the world, and what some models emit, into a light group, and shows one group alone.
fn group(dice: &mut Dice, shot: &mut Table) {
    if !dice.one_in(3) {
        return;
    }
    let models = shot.get_mut("model").and_then(Value::as_array_mut).into_iter().flatten();
    for model in models.filter_map(Value::as_table_mut).filter(|_| dice.one_in(3)) {
        model.insert("light_group".into(), "key".into());
    }
    if let Some(environment) = shot.get_mut("environment").and_then(Value::as_table_mut) {
        if dice.one_in(2) {
            environment.insert("light_group".into(), "world".into());
        }
    }
    if let Some(render) = shot.get_mut("render").and_then(Value::as_table_mut) {
        // the only one that is there in any case
        render.insert("only_lights".into(), "others".into());
    }
}

/// Links a light, or what a model emits, one time in so many.
fn link(dice: &mut Dice, times: usize, table: &mut Table) {
    for key in ["light_link", "shadow_link"] {
        if dice.one_in(times) {
            let group = Value::from(*dice.pick(&GROUPS));
            let how = *dice.pick(&["include", "exclude"]);
            // a light that lights nothing is refused
            let how = if key == "light_link" { "include" } else { how };
            let is_none = key == "shadow_link" && how == "include" && dice.one_in(4);
            let names = if is_none { Vec::new() } else { vec![group] };
            let names = Table::from_iter([(String::from(how), Value::Array(names))]);
            table.insert(key.into(), Value::Table(names));
        }
    }
}
