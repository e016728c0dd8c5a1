//! Flat mirrors and panes before matt things, seen by an eye that moves: what they show is kept in these shots alone.

use toml::{Table, Value};

use super::{color, numbers, place, table};
use crate::dice::Dice;
use crate::files::{MATERIALS, TEXTURES};

/// Name of the models that are mirrors.
pub const NAME: &str = "flat mirror";

/// Perhaps some flat mirrors, which may move as the things of the shot do, and light that is gathered from all around.
pub fn add(dice: &mut Dice, shot: &mut Table) {
    if !dice.one_in(6) {
        return;
    }
    // each would have what mirrors show made anew in each frame
    for key in ["shutter", "fog"] {
        shot.remove(key);
    }
    let entry = |shot: &mut Table, part: &str, key: &str, value: Value| {
        if let Some(part) = shot.entry(part).or_insert_with(|| Value::Table(Table::new())).as_table_mut() {
            part.insert(key.into(), value);
        }
    };
    entry(shot, "indirect", "paths", dice.whole(1, 5).into());
    for (part, key) in
        [("render", "exposures"), ("render", "depth"), ("render", "reuse"), ("ambient", "occluded")]
    {
        if let Some(part) = shot.get_mut(part).and_then(Value::as_table_mut) {
            part.remove(key);
        }
    }
    let materials = shot.get_mut("material").and_then(Value::as_array_mut).into_iter().flatten();
    for material in materials.filter_map(Value::as_table_mut) {
        material.retain(|key, _| !key.starts_with("volume_") && key != "surface");
    }
    let (mirror, matt) = (MATERIALS[dice.below(3)], MATERIALS[3 + dice.below(3)]);
    set_material(shot, mirror, mirror_of(dice, mirror));
    set_material(shot, matt, matt_of(dice, matt));
    let other = MATERIALS[3 + dice.below(3)];
    let both = if other == matt || dice.one_in(2) {
        String::from(matt)
    } else {
        set_material(shot, other, matt_of(dice, other));
        format!("{matt}+{other}")
    };
    let count = 1 + dice.below(3);
    let Some(models) = shot.get_mut("model").and_then(Value::as_array_mut) else { return };
    let moves: Vec<Value> = models.iter().filter_map(|model| model.get("key").cloned()).collect();
    for _ in 0..count {
        let shape = *dice.pick(&["quad", "quad", "cube", "leaning", "sheet", "room", "ball"]);
        let mut model = table([("name", NAME.into()), ("obj", format!("{shape}-{mirror}.obj").into())]);
        model.insert("translate".into(), numbers(place(dice, 1.2)));
        model.insert("rotate".into(), numbers(place(dice, 60.0)));
        model.insert("scale".into(), dice.between(0.3, 1.6).into());
        if dice.one_in(5) && !moves.is_empty() {
            model.insert("key".into(), dice.pick(&moves).clone());
            model.retain(|key, _| !["translate", "rotate", "scale"].contains(&key));
        }
        models.push(Value::Table(model));
    }
    for _ in 0..2 {
        let shape = *dice.pick(&["cube", "room", "ball", "floor", "quad", "crossed"]);
        let mut model = table([("obj", format!("{shape}-{both}.obj").into())]);
        model.insert("translate".into(), numbers(place(dice, 1.5)));
        model.insert("scale".into(), dice.between(0.3, 1.5).into());
        models.push(Value::Table(model));
    }
    // hardly anything is shown twice in a shot that jumps in each frame
    if dice.one_in(2) {
        go_slowly(dice, shot);
    }
}

fn mirror_of(dice: &mut Dice, name: &str) -> Table {
    let mut material = table([("name", name.into()), ("kd", numbers(color(dice)))]);
    match dice.below(4) {
        // a pane
        0 => {
            material.insert("ks".into(), numbers([1.0; 3]));
            material.insert("ni".into(), Value::Float(1.5));
            material.insert("illum".into(), Value::Integer(7));
            material.insert("thin".into(), Value::Boolean(true));
        }
        // polished metal
        1 => {
            material.insert("pr".into(), Value::Float(0.0));
            material.insert("pm".into(), Value::Float(*dice.pick(&[0.0, 1.0])));
        }
        _ => {
            material.insert("ks".into(), numbers(color(dice)));
            material.insert("illum".into(), Value::Integer(*dice.pick(&[3, 5])));
        }
    }
    material
}

fn matt_of(dice: &mut Dice, name: &str) -> Table {
    let mut material = table([("name", name.into()), ("kd", numbers(color(dice)))]);
    if dice.one_in(2) {
        material.insert("map_kd".into(), (*dice.pick(&TEXTURES)).into());
    }
    if dice.one_in(4) {
        material.insert("ke".into(), numbers(color(dice)));
    }
    material
}

/// Replaces a material of the shot.
fn set_material(shot: &mut Table, name: &str, material: Table) {
    let materials = shot.get_mut("material").and_then(Value::as_array_mut).into_iter().flatten();
    for old in materials.filter(|old| old.get("name").and_then(Value::as_str) == Some(name)) {
        *old = Value::Table(material.clone());
    }
}

/// Has the camera go a short way through the shot.
fn go_slowly(dice: &mut Dice, shot: &mut Table) {
    let Some(camera) = shot.get_mut("camera").and_then(Value::as_table_mut) else { return };
    for key in ["key", "cut", "aperture", "projection"] {
        camera.remove(key);
    }
    let eye = [dice.between(-0.5, 0.5), dice.between(-0.5, 0.5), dice.between(2.0, 4.0)];
    let reach = *dice.pick(&[0.02, 0.1, 0.5]);
    let way = place(dice, reach);
    let key = |frame: i64, share: f64| {
        let at = [0, 1, 2].map(|axis| eye[axis] + share * way[axis]);
        let mut key = table([("frame", frame.into()), ("eye", numbers(at)), ("target", numbers([0.0; 3]))]);
        key.insert("fov".into(), Value::Float(50.0));
        Value::Table(key)
    };
    let keys = Value::Array(vec![key(-2, 0.0), key(12, 1.0)]);
    camera.clear();
    camera.insert("key".into(), keys);
}
