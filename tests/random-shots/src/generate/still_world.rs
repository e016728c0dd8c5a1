//! Still worlds before a blurred camera: in these alone exposures share samples.

use toml::{Table, Value};

use super::table;
use crate::dice::Dice;

/// Perhaps nothing moves in the shot but the camera, and each frame has several exposures of samples that gather light.
pub fn add(dice: &mut Dice, shot: &mut Table) {
    if !dice.one_in(8) {
        return;
    }
    let lists = ["model", "light"].into_iter().filter_map(|key| shot.get(key)?.as_array().map(|_| key));
    for list in lists.collect::<Vec<_>>() {
        let entries = shot.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten();
        for entry in entries.filter_map(Value::as_table_mut) {
            for key in ["key", "shapes", "interpolation"] {
                entry.remove(key);
            }
            // the one file whose mesh rests
            if let Some(name) = entry.get("gltf").and_then(Value::as_str) {
                let mesh = name.split('.').next().unwrap_or_default();
                entry.insert("gltf".into(), format!("{mesh}.painted.glb").into());
            }
        }
    }
    let entry = |shot: &mut Table, part: &str, key: &str, value: Value| {
        if let Some(part) = shot.entry(part).or_insert_with(|| Value::Table(Table::new())).as_table_mut() {
            part.insert(key.into(), value);
        }
    };
    let (samples, exposures) = *dice.pick(&[(2, 4), (4, 4), (4, 16), (6, 9)]);
    entry(shot, "render", "samples", samples.into());
    entry(shot, "render", "exposures", exposures.into());
    entry(shot, "indirect", "paths", dice.whole(1, 4).into());
    // beside a lens, or instead of one
    if dice.one_in(2) || !has_lens(shot) {
        let open = dice.between(-0.6, 0.0);
        let close = open + *dice.pick(&[0.25, 0.5, 1.0]);
        shot.insert("shutter".into(), Value::Table(table([("open", open.into()), ("close", close.into())])));
    }
}

fn has_lens(shot: &Table) -> bool {
    let camera = shot.get("camera").and_then(Value::as_table);
    let keys = camera.and_then(|camera| camera.get("key")).and_then(Value::as_array).into_iter().flatten();
    let mut tables = camera.into_iter().chain(keys.filter_map(Value::as_table));
    tables.any(|table| table.contains_key("aperture"))
}
