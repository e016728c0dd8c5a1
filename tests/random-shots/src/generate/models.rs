//! Things: meshes, quadrics and curves that rest, move, turn, grow, jump, deform, come and go, some in the same place as others.

use toml::{Table, Value};

use super::settings::Span;
use super::tracks::{Way, add_keys, add_visibility};
use super::{color, numbers, place, table};
use crate::dice::Dice;
use crate::files::{CURVES, MATERIALS, SHAPES};
use crate::glb::MOTIONS;

/// Models of a shot, at most.
const MOST: usize = 5;

pub fn add(dice: &mut Dice, span: &Span, shot: &mut Table) {
    let mut models = vec![];
    if dice.one_in(2) {
        let shell = *dice.pick(&["room", "floor"]);
        let mut model = table([("obj", mesh_name(dice, shell).into())]);
        if shell == "floor" {
            model.insert("translate".into(), numbers([0.0, -1.0, 0.0]));
        }
        models.push(model);
    }
    let count = 1 + dice.below(MOST - models.len());
    for _ in 0..count {
        let model = match models.last() {
            // in the same place, and perhaps with the same motion
            Some(before) if dice.one_in(8) => before.clone(),
            _ => model(dice, span),
        };
        models.push(model);
    }
    shot.insert("model".into(), Value::Array(models.into_iter().map(Value::Table).collect()));
    if dice.one_in(12) {
        let mut floor = table([("color", numbers(color(dice)))]);
        floor.insert("height".into(), Value::Float(-1.2));
        shot.insert("floor".into(), Value::Table(floor));
    }
}

/// Perhaps some copies of a mesh of the shot that rest: turned, stretched, mirrored, sheared, in its place.
pub fn add_copies(dice: &mut Dice, shot: &mut Table) {
    if !dice.one_in(3) {
        return;
    }
    let Some(models) = shot.get_mut("model").and_then(Value::as_array_mut) else { return };
    let of_mesh = |model: &&Value| model.get("obj").is_some_and(Value::is_str);
    let meshes: Vec<Table> =
        models.iter().filter(of_mesh).filter_map(|model| model.as_table().cloned()).collect();
    if meshes.is_empty() {
        return;
    }
    let model = dice.pick(&meshes).clone();
    for _ in 0..2 + dice.below(2) {
        models.push(Value::Table(copy_at_rest(dice, &model)));
    }
}

/// Perhaps one mesh of the shot comes from a glTF file, wherever it is, and moves as that says, on top of all else.
pub fn add_gltf(dice: &mut Dice, shot: &mut Table) {
    if !dice.one_in(3) {
        return;
    }
    let Some(models) = shot.get_mut("model").and_then(Value::as_array_mut) else { return };
    let mut models: Vec<&mut Table> = models.iter_mut().filter_map(Value::as_table_mut).collect();
    let obj = |model: &Table| model.get("obj").and_then(Value::as_str).map(String::from);
    let is_plain = |name: &String| {
        !models.iter().any(|model| obj(model).as_ref() == Some(name) && model.contains_key("shapes"))
    };
    let names: Vec<String> = models.iter().filter_map(|model| obj(model)).filter(is_plain).collect();
    if names.is_empty() {
        return;
    }
    let name = dice.pick(&names).clone();
    let file = format!("{}.{}.glb", name.trim_end_matches(".obj"), dice.pick(&MOTIONS));
    for model in models.iter_mut().filter(|model| obj(model).as_ref() == Some(&name)) {
        model.remove("obj");
        model.insert("gltf".into(), file.as_str().into());
    }
}

fn copy_at_rest(dice: &mut Dice, model: &Table) -> Table {
    let mut copy = model.clone();
    for key in ["key", "shapes", "visible", "interpolation"] {
        copy.remove(key);
    }
    // now and then where the mesh is, or has been, already
    if dice.one_in(6) {
        return copy;
    }
    copy.insert("translate".into(), numbers(place(dice, 1.2)));
    if dice.one_in(2) {
        copy.insert("rotate".into(), numbers(place(dice, 180.0)));
    }
    if dice.one_in(3) {
        let mut factor = || dice.between(0.2, 1.2);
        let [x, y, z] = [factor(), factor(), factor()];
        let sign = if dice.one_in(2) { -1.0 } else { 1.0 };
        copy.insert("scale".into(), numbers([sign * x, y, z]));
    }
    if dice.one_in(6) {
        copy.insert("matrix".into(), matrix(dice));
    }
    copy
}

fn mesh_name(dice: &mut Dice, shape: &str) -> String {
    format!("{shape}-{}.obj", dice.pick(&MATERIALS))
}

fn model(dice: &mut Dice, span: &Span) -> Table {
    let mut model = Table::new();
    if dice.one_in(4) {
        model.insert("quadric".into(), Value::Table(quadric(dice)));
    } else if dice.one_in(6) {
        let curves = curves(dice);
        if let Some(name) = curves.get("file").and_then(Value::as_str).filter(|_| dice.one_in(3)) {
            model.insert("shapes".into(), Value::Table(shapes(dice, span, name)));
        }
        model.insert("curves".into(), Value::Table(curves));
    } else {
        let shape = *dice.pick(&SHAPES);
        let name = mesh_name(dice, shape);
        if dice.one_in(8) {
            model.insert("shapes".into(), Value::Table(shapes(dice, span, &name)));
        }
        model.insert("obj".into(), name.into());
        // meshes alone: a plane has no middle to look from
        if dice.one_in(6) {
            model.insert("reflection_map".into(), Value::Integer(8));
        }
    }
    if dice.one_in(4) {
        model.insert("interpolation".into(), "smooth".into());
    }
    let scale = if dice.one_in(3) { dice.between(0.2, 1.5) } else { 0.6 };
    model.insert("scale".into(), scale.into());
    if dice.one_in(10) {
        model.insert("matrix".into(), matrix(dice));
    }
    let [from, to] = [0, 1].map(|_| place(dice, 1.2));
    model.insert("translate".into(), numbers(from));
    let angles = [0, 1].map(|_| place(dice, 90.0));
    if dice.one_in(3) {
        model.insert("rotate".into(), numbers(angles[0]));
    }
    let way = Way::roll(dice);
    let keys = way.keys(dice, span);
    if !keys.is_empty() {
        let what = dice.below(4);
        let grown = (scale * dice.between(0.5, 1.5)).max(0.01);
        add_keys(&mut model, &keys, |number| {
            let mut key = vec![];
            if what != 1 {
                key.push(("translate", numbers([from, to][number])));
            }
            if what == 1 || what == 2 {
                key.push(("rotate", numbers(angles[number])));
            }
            if what == 3 {
                key.push(("scale", Value::Float([scale, grown][number])));
            }
            key
        });
    }
    if dice.one_in(5) {
        add_visibility(dice, span, &mut model);
        sort_keys(&mut model);
    }
    model
}

/// Keys of motion and of visibility are one list, in which frames rise.
fn sort_keys(model: &mut Table) {
    let frame = |key: &Value| {
        let frame = key.get("frame")?;
        frame.as_float().or_else(|| frame.as_integer().map(|frame| frame as f64))
    };
    if let Some(keys) = model.get_mut("key").and_then(Value::as_array_mut) {
        keys.sort_by(|a, b| frame(a).partial_cmp(&frame(b)).unwrap_or(std::cmp::Ordering::Equal));
        // where both have a key in one frame, what the second says is added to the first
        let mut merged: Vec<Value> = vec![];
        for key in keys.drain(..) {
            match merged.last_mut() {
                Some(Value::Table(last)) if last.get("frame") == key.get("frame") => {
                    if let Value::Table(key) = key {
                        last.extend(key);
                    }
                }
                _ => merged.push(key),
            }
        }
        *keys = merged;
    }
}

fn shapes(dice: &mut Dice, span: &Span, name: &str) -> Table {
    let (stem, kind) = name.rsplit_once('.').expect("files have an ending");
    // some curves grow out of next to nothing
    let grow = if kind == "curves" && dice.one_in(3) { "1" } else { "" };
    let mut shapes = table([
        (kind, format!("{stem}.{grow}##.{kind}").into()),
        ("first", Value::Integer(span.first + dice.whole(-1, 2))),
    ]);
    if dice.one_in(2) {
        shapes.insert("every".into(), Value::Float(*dice.pick(&[0.5, 1.0, 2.0])));
    }
    // rarely: the motion of 65,000 frames takes seconds to lay out
    if dice.one_in(30) {
        shapes.insert("repeat".into(), Value::Boolean(true));
    }
    shapes
}

fn quadric(dice: &mut Dice) -> Table {
    let kinds = ["sphere", "ellipsoid", "cylinder", "cone", "paraboloid", "hyperboloid", "plane"];
    let kind = *dice.pick(&kinds);
    let mut quadric = table([("type", kind.into()), ("material", (*dice.pick(&MATERIALS)).into())]);
    match kind {
        "ellipsoid" => drop(quadric.insert("radii".into(), numbers([1.0, 0.7, 0.5]))),
        "hyperboloid" if dice.one_in(2) => drop(quadric.insert("gap".into(), Value::Float(0.4))),
        _ => {}
    }
    if !["sphere", "ellipsoid", "plane"].contains(&kind) && dice.one_in(2) {
        quadric.insert("open".into(), Value::Boolean(true));
    }
    quadric
}

fn curves(dice: &mut Dice) -> Table {
    let mut curves =
        table([("file", (*dice.pick(&CURVES)).into()), ("material", (*dice.pick(&MATERIALS)).into())]);
    if dice.one_in(3) {
        curves.insert("tolerance".into(), Value::Float(*dice.pick(&[0.001, 0.1])));
    }
    curves
}

fn matrix(dice: &mut Dice) -> Value {
    let mut lean = || dice.between(-0.4, 0.4);
    let rows = [[1.0, lean(), 0.0, 0.0], [0.0, 1.0, lean(), 0.0], [lean(), 0.0, 0.8, 0.1]];
    Value::Array(rows.into_iter().map(numbers).collect())
}
