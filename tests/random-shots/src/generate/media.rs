//! What fills meshes and everything else: fog, smoke, ink, with and without surfaces around it.

use toml::{Table, Value};

use super::settings::Span;
use super::tracks::{Way, add_keys};
use super::{color, numbers, place, table};
use crate::dice::Dice;
use crate::files;

pub fn add(dice: &mut Dice, span: &Span, shot: &mut Table) {
    if dice.one_in(8) {
        let mut fog = Table::new();
        state(dice, &mut fog, "", 0.1);
        shot.insert("fog".into(), Value::Table(fog));
    }
    if let Some(Value::Array(materials)) = shot.get_mut("material") {
        for material in materials.iter_mut().filter_map(Value::as_table_mut) {
            if dice.one_in(10) {
                state(dice, material, "volume_", 1.0);
                if dice.one_in(2) {
                    material.insert("surface".into(), Value::Boolean(false));
                }
            }
        }
    }
    if dice.one_in(10) {
        add_smoke(dice, shot);
    }
    if dice.one_in(8) {
        add_cloud(dice, span, shot);
    }
    let has_media = shot.contains_key("fog") || shot.get("material").is_some_and(has_volumes);
    if has_media && dice.one_in(3) {
        set(shot, "render", "volume_samples", 2);
    }
    if has_media && dice.one_in(3) {
        set(shot, "indirect", "volume_bounces", *dice.pick(&[0, 1, 9]));
    }
}

/// Returns true if any of these materials has a volume.
fn has_volumes(materials: &Value) -> bool {
    let mut all = materials.as_array().into_iter().flatten().filter_map(Value::as_table);
    all.any(|material| material.keys().any(|key| key.starts_with("volume_")))
}

/// Has a material be smoke that a graph computes.
fn add_smoke(dice: &mut Dice, shot: &mut Table) {
    let Some(Value::Array(materials)) = shot.get_mut("material") else { return };
    if materials.is_empty() {
        return;
    }
    let number = dice.below(materials.len());
    let Some(Value::String(name)) = materials[number].get("name").cloned() else { return };
    let cells = i64::from(*dice.pick(&[1, 5, 24]));
    let keys =
        [("name", name.into()), ("mtlx", files::SMOKE.into()), ("volume_cells", Value::Integer(cells))];
    materials[number] = Value::Table(table(keys));
}

/// Adds a cloud, of one density or of what a graph makes of it, which may move.
fn add_cloud(dice: &mut Dice, span: &Span, shot: &mut Table) {
    let mut material = table([("name", files::OF_CLOUD.into()), ("surface", Value::Boolean(false))]);
    if dice.one_in(3) {
        material.insert("mtlx".into(), files::SMOKE.into());
    } else {
        material.insert("volume_scatter".into(), numbers(color(dice)));
        state(dice, &mut material, "volume_", 1.0);
    }
    let mut volume = table([("file", files::CLOUD.into()), ("material", files::OF_CLOUD.into())]);
    if dice.one_in(3) {
        volume.insert("file".into(), files::CLOUDS.into());
        volume.insert("first".into(), Value::Float(span.first as f64));
    }
    let [from, to] = [0, 1].map(|_| place(dice, 0.8));
    let mut model = table([("vdb", Value::Table(volume)), ("translate", numbers(from))]);
    model.insert("rotate".into(), numbers(place(dice, 90.0)));
    if dice.one_in(2) {
        let keys = Way::roll(dice).keys(dice, span);
        add_keys(&mut model, &keys, |number| vec![("translate", numbers([from, to][number]))]);
    }
    for (list, entry) in [("material", material), ("model", model)] {
        let all = shot.entry(list).or_insert_with(|| Value::Array(Vec::new()));
        if let Some(all) = all.as_array_mut() {
            all.push(Value::Table(entry));
        }
    }
}

fn set(shot: &mut Table, table: &str, key: &str, value: i64) {
    let table = shot.entry(table).or_insert_with(|| Value::Table(Table::new()));
    if let Some(table) = table.as_table_mut() {
        table.insert(key.into(), Value::Integer(value));
    }
}

/// States a medium that is about as `dense` as this.
fn state(dice: &mut Dice, table: &mut Table, prefix: &str, dense: f64) {
    for key in ["scatter", "absorb", "emit"] {
        if dice.one_in(2) {
            let most = dense * if key == "emit" { 0.3 } else { 1.0 };
            table.insert(format!("{prefix}{key}"), numbers(color(dice).map(|part| part * most)));
        }
    }
    if dice.one_in(3) {
        table.insert(format!("{prefix}anisotropy"), Value::Float(*dice.pick(&[-0.9, -0.3, 0.5, 0.95, 1.0])));
    }
    if dice.one_in(3) {
        table.insert(format!("{prefix}density"), Value::Float(*dice.pick(&[0.0, 0.2, 4.0])));
    }
}
