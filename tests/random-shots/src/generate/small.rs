//! Small things: dots, streaks, slats, grates, foliage, crowds, layers, and whole shots that are smaller than a cell. They are what a frame
//! loses first whose cells show what was seen before instead of what is seen now.
//!
//! Sizes are measured in cells of the shot, from a fifth of one to two: what is larger is seen by several targets whatever a renderer does.

use std::f64::consts::PI;

use toml::{Table, Value};

use super::settings::Span;
use super::tracks::{Way, add_keys, add_visibility};
use super::{numbers, place, table};
use crate::dice::Dice;
use crate::files::{MATERIALS, SMALL_SHAPES};
use crate::glb::MOTIONS;

/// One shot in so many has small things.
const SHARE: usize = 3;

/// Widths of small things, in cells.
const WIDTHS: [f64; 6] = [0.2, 0.3, 0.6, 1.0, 1.2, 2.0];

/// How far thin parts of a mesh are before its other parts, in their own widths.
const GAPS: [f64; 4] = [0.05, 0.3, 1.0, 4.0];

/// Sizes of pictures of small things: enough cells for shares of them to say something.
const SIZES: [[i64; 2]; 2] = [[24, 16], [34, 11]];

/// Frames of a long shot, after its first.
const CHAIN: i64 = 11;

/// A cell's width where the shot says nothing that could be used.
const USUAL_WIDTH: f64 = 0.1;

/// Perhaps adds small things to a shot, in one of the ways in which there may be any.
pub fn add(dice: &mut Dice, span: &Span, shot: &mut Table) {
    if !dice.one_in(SHARE) {
        return;
    }
    if let Some(Value::Table(render)) = shot.get_mut("render").filter(|_| dice.one_in(2)) {
        render.insert("size".into(), Value::from(dice.pick(&SIZES).to_vec()));
        // what is lost a little in each frame shows in long chains; and after its last key all comes to rest
        if dice.one_in(3) {
            render.insert("frames".into(), format!("{}-{}", span.first, span.first + CHAIN).into());
        }
    }
    let cell = cell_width(shot).unwrap_or(USUAL_WIDTH);
    let eye = first_key(shot).and_then(|key| vector(key, "eye")).unwrap_or([0.0, 0.0, 5.0]);
    let models = match dice.below(8) {
        0 => crowd(dice, span, cell),
        1 => vec![at_the_eye(dice, eye)],
        2 => {
            shrink_all(dice, cell, shot);
            vec![]
        }
        3 => {
            let one = small_mesh(dice, span, cell);
            vec![twin(dice, &one), one]
        }
        number => (0..number % 2 + 1).map(|_| small_mesh(dice, span, cell)).collect(),
    };
    if let Some(Value::Array(list)) = shot.get_mut("model") {
        list.extend(models.into_iter().map(Value::Table));
    }
}

/// Width of a cell of a shot at the distance of what its camera looks at, in its first frame.
pub fn cell_width(shot: &Table) -> Option<f64> {
    let render = shot.get("render")?;
    let rows = render.get("size")?.get(1)?.as_integer()? as f64;
    let samples = match render.get("samples") {
        Some(Value::Integer(samples)) => *samples,
        Some(Value::Table(samples)) => samples.get("max")?.as_integer()?,
        _ => 1,
    };
    let key = first_key(shot)?;
    let height = match key.get("height").and_then(number) {
        Some(height) => height,
        None => {
            let (eye, target) = (vector(key, "eye")?, vector(key, "target").unwrap_or_default());
            let distance = (0..3).map(|axis| (eye[axis] - target[axis]).powi(2)).sum::<f64>().sqrt();
            2.0 * distance * (number(key.get("fov")?)? * PI / 360.0).tan()
        }
    };
    let width = height / (rows * samples as f64);
    // numbers at the limits of what may be said may stand there
    (1e-3..2.0).contains(&width).then_some(width)
}

fn first_key(shot: &Table) -> Option<&Table> {
    shot.get("camera")?.get("key")?.get(0)?.as_table()
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

fn vector(key: &Table, name: &str) -> Option<[f64; 3]> {
    let [x, y, z] = [0, 1, 2].map(|axis| key.get(name)?.get(axis).and_then(number));
    Some([x?, y?, z?]).filter(|at| at.iter().all(|along| along.abs() < 1e3))
}

/// A mesh of many small things, which rests, moves, deforms, comes and goes.
fn small_mesh(dice: &mut Dice, span: &Span, cell: f64) -> Table {
    // how far its things are strewn, to either side
    let reach = *dice.pick(&[0.5, 1.0, 1.5]);
    let width = dice.pick(&WIDTHS) * cell;
    let thousandths = |length: f64| (length / reach * 1000.0).round().clamp(1.0, 900.0);
    let shape = *dice.pick(&SMALL_SHAPES);
    let gap = width * dice.pick(&GAPS);
    let material = *dice.pick(&MATERIALS);
    let name = |material: &str| format!("{shape}{}x{}-{material}", thousandths(width), thousandths(gap));
    let mut model = Table::new();
    let way = dice.below(8);
    let second = (way > 0 && dice.one_in(3)).then(|| dice.pick(&MATERIALS));
    let name = second.map_or_else(|| name(material), |second| name(&format!("{material}+{second}")));
    match way {
        0 => drop(model.insert("gltf".into(), format!("{name}.{}.glb", dice.pick(&MOTIONS)).into())),
        number => {
            if number == 1 {
                let shapes =
                    [("obj", format!("{name}.##.obj").into()), ("first", Value::Integer(span.first))];
                model.insert("shapes".into(), Value::Table(table(shapes)));
            }
            model.insert("obj".into(), format!("{name}.obj").into());
        }
    }
    model.insert("scale".into(), Value::Float(reach));
    if dice.one_in(2) {
        model.insert("rotate".into(), numbers(place(dice, 40.0)));
    }
    move_by_cells(dice, span, cell, &mut model);
    if dice.one_in(6) && !model.contains_key("key") {
        add_visibility(dice, span, &mut model);
    }
    model
}

/// Places a model, and perhaps moves it by some cells.
fn move_by_cells(dice: &mut Dice, span: &Span, cell: f64, model: &mut Table) {
    let from = place(dice, 0.7);
    let step = place(dice, 5.0);
    let to = [0, 1, 2].map(|axis| ((from[axis] + step[axis] * cell) * 1000.0).round() / 1000.0);
    model.insert("translate".into(), numbers(from));
    let keys = Way::roll(dice).keys(dice, span);
    if !keys.is_empty() {
        add_keys(model, &keys, |number| vec![("translate", numbers([from, to][number]))]);
    }
}

/// Many movers of less than some cells, each on a way of its own.
fn crowd(dice: &mut Dice, span: &Span, cell: f64) -> Vec<Table> {
    let count = 6 + dice.below(9);
    let mover = |_| {
        let mut model = table([("obj", format!("speck-{}.obj", dice.pick(&MATERIALS)).into())]);
        model.insert("scale".into(), Value::Float(dice.pick(&WIDTHS) * cell));
        move_by_cells(dice, span, cell, &mut model);
        model
    };
    (0..count).map(mover).collect()
}

/// A model at rest in the place where another is, or was.
fn twin(dice: &mut Dice, model: &Table) -> Table {
    let mut twin = model.clone();
    for key in ["key", "shapes", "visible"] {
        twin.remove(key);
    }
    if let Some(name) = twin.get("obj").and_then(Value::as_str).filter(|_| dice.one_in(2)) {
        let shape = name.split('-').next().unwrap_or_default();
        let name = format!("{shape}-{}.obj", dice.pick(&MATERIALS));
        twin.insert("obj".into(), name.into());
    }
    twin
}

/// A surface in which the eye is in the first frame, or nearly: it is seen edge on, or from next to no distance.
fn at_the_eye(dice: &mut Dice, eye: [f64; 3]) -> Table {
    let turned = *dice.pick(&[[0.0, 0.0, 0.0], [90.0, 0.0, 0.0], [0.0, 90.0, 0.0], [0.0, 0.0, 30.0]]);
    // in a plane that leans rounding decides on which side of it the eye is, and then where it is met: the audit is not made for that
    let leans = turned[2] != 0.0;
    let off = *dice.pick(if leans { &[0.01, -0.01, 0.05] } else { &[0.0, 1e-4, -1e-4] });
    let mut model = table([("obj", format!("brink-{}.obj", dice.pick(&MATERIALS)).into())]);
    model.insert("translate".into(), numbers([eye[0], eye[1] + off, eye[2] + off]));
    model.insert("rotate".into(), numbers(turned));
    model
}

/// Makes every model smaller than a cell.
fn shrink_all(dice: &mut Dice, cell: f64, shot: &mut Table) {
    let scale = Value::Float(dice.pick(&[0.1, 0.3, 0.45]) * cell);
    shot.remove("floor");
    let Some(Value::Array(models)) = shot.get_mut("model") else { return };
    for model in models.iter_mut().filter_map(Value::as_table_mut) {
        if !model.contains_key("obj") {
            continue;
        }
        model.insert("scale".into(), scale.clone());
        for key in model.get_mut("key").and_then(Value::as_array_mut).into_iter().flatten() {
            if let Some(key) = key.as_table_mut().filter(|key| key.contains_key("scale")) {
                key.insert("scale".into(), scale.clone());
            }
        }
    }
    models.retain(|model| model.get("obj").is_some());
    if models.is_empty() {
        let mut model = table([("obj", "speck-m0.obj".into())]);
        model.insert("scale".into(), scale);
        models.push(Value::Table(model));
    }
}
