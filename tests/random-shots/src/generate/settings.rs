//! How a shot is rendered: sizes, samples, and each feature that takes part in reuse.

use toml::{Table, Value};

use super::camera::Choice;
use super::{color, numbers, table};
use crate::dice::Dice;
use crate::files::MAP;

/// The frames of a shot.
#[derive(Debug, Clone, Copy)]
pub struct Span {
    pub first: i64,
    pub last: i64,
    step: i64,
}

impl Span {
    pub fn roll(dice: &mut Dice) -> Self {
        let first = *dice.pick(&[1, 1, 1, 1, 0, -3, 1000, 70_000]);
        let step = *dice.pick(&[1, 1, 1, 1, 1, 1, 2, 3]);
        Self { first, last: first + step * dice.whole(2, 6), step }
    }

    fn text(self) -> String {
        let Self { first, last, step } = self;
        if step == 1 { format!("{first}-{last}") } else { format!("{first}-{last}x{step}") }
    }
}

/// Pictures are small, but some have several tiles, which are of 32 x 32 cells.
const SIZES: [[i64; 2]; 6] = [[10, 7], [12, 6], [8, 9], [36, 3], [3, 34], [18, 12]];

pub fn add(dice: &mut Dice, span: &Span, camera: Choice, shot: &mut Table) {
    let mut render = Table::new();
    render.insert("size".into(), Value::from(dice.pick(&SIZES).to_vec()));
    render.insert("frames".into(), span.text().into());
    render.insert("mode".into(), (*dice.pick(&["reproject", "reproject", "reproject", "auto"])).into());
    let is_adaptive = dice.one_in(8);
    if is_adaptive {
        let most = *dice.pick(&[2, 4]);
        let samples = table([("min", Value::Integer(1)), ("max", Value::Integer(most))]);
        render.insert("samples".into(), Value::Table(samples));
    } else {
        render.insert("samples".into(), Value::Integer(*dice.pick(&[1, 1, 1, 1, 1, 2, 2, 3])));
        if dice.one_in(4) {
            let filters = ["area", "tent", "gaussian", "mitchell", "blackman-harris", "lanczos"];
            render.insert("filter".into(), (*dice.pick(&filters)).into());
        }
    }
    let mut maybe = |chance: usize, key: &str, values: &[i64]| {
        if dice.one_in(chance) {
            render.insert(key.into(), Value::Integer(*dice.pick(values)));
        }
    };
    maybe(6, "depth", &[0, 1, 2, 8]);
    maybe(6, "reflections", &[0, 1, 2, 6]);
    maybe(4, "tree_memory", &[0, 1]);
    maybe(16, "overscan", &[1, 3]);
    maybe(3, "base_every", &[0, 2, 3, 5]);
    if dice.one_in(5) {
        render.insert("base_place".into(), "middle".into());
    }
    if dice.one_in(12) {
        render.insert("reuse".into(), "paper".into());
    }
    if dice.one_in(10) {
        let cut = span.first + dice.whole(1, (span.last - span.first).max(1));
        render.insert("cuts".into(), Value::from(vec![cut]));
    }
    if camera.is_blurred || dice.one_in(8) {
        // exposures divide samples: of one each, of several, and none
        if !is_adaptive {
            render.insert("samples".into(), Value::Integer(*dice.pick(&[1, 2, 2, 2, 3, 4, 4, 6])));
        }
        render.insert("exposures".into(), Value::Integer(*dice.pick(&[1, 4, 4, 9, 16])));
        if !camera.is_blurred || dice.one_in(2) {
            let open = dice.between(-0.6, 0.3);
            let close = open + *dice.pick(&[0.0, 0.25, 0.5, 1.0]);
            shot.insert(
                "shutter".into(),
                Value::Table(table([("open", open.into()), ("close", close.into())])),
            );
        }
    }
    shot.insert("render".into(), Value::Table(render));
    if !camera.is_orthographic && dice.one_in(8) {
        let mut stereo = table([("separation", dice.between(0.02, 0.5).into())]);
        if dice.one_in(2) {
            stereo.insert("convergence".into(), dice.between(1.0, 6.0).into());
        }
        shot.insert("stereo".into(), Value::Table(stereo));
    }
    shot.insert("output".into(), Value::Table(table([("layers", layers(dice))])));
    add_indirect(dice, shot);
    add_ambient(dice, shot);
    add_surroundings(dice, shot);
}

/// How light comes through glass.
pub fn add_caustics(dice: &mut Dice, shot: &mut Table) {
    if let Some(Value::Table(render)) = shot.get_mut("render").filter(|_| dice.one_in(4)) {
        render.insert("caustics".into(), "paths".into());
    }
}

/// What rays may bring by indirect ways, from what nearly none does to what most do.
pub fn add_clamp(dice: &mut Dice, shot: &mut Table) {
    if let Some(Value::Table(render)) = shot.get_mut("render").filter(|_| dice.one_in(4)) {
        render.insert("clamp".into(), (*dice.pick(&[0.05, 0.3, 1.0, 5.0])).into());
    }
}

/// An error from which counts follow: all of them, or those beside the stated samples.
pub fn add_error(dice: &mut Dice, shot: &mut Table) {
    if let Some(Value::Table(render)) = shot.get_mut("render").filter(|_| dice.one_in(16)) {
        render.insert("error".into(), (*dice.pick(&[0.1, 0.3, 0.9])).into());
        if dice.one_in(2) {
            render.remove("samples");
        }
    }
}

fn layers(dice: &mut Dice) -> Value {
    match dice.below(4) {
        0 => Value::from(vec!["all"]),
        1 => Value::from(vec!["none"]),
        2 => Value::from(vec!["usual"]),
        _ => {
            let all = [
                "direct",
                "indirect",
                "motion",
                "light",
                "occlusion",
                "CryptoObject",
                "denoise_normal",
                "reflection",
                "specular",
                "status",
                "depth",
                "rays",
                "object",
                "denoise_variance",
            ];
            let some: Vec<&str> = (0..3).map(|_| *dice.pick(&all)).collect();
            let is_first = |number: usize| !some[..number].contains(&some[number]);
            Value::from(
                (0..3).filter(|number| is_first(*number)).map(|number| some[number]).collect::<Vec<_>>(),
            )
        }
    }
}

fn add_indirect(dice: &mut Dice, shot: &mut Table) {
    let paths = *dice.pick(&[0, 0, 1, 2, 3, 4, 6]);
    let mut indirect = table([("paths", Value::Integer(paths))]);
    if dice.one_in(2) {
        indirect.insert("bounces".into(), Value::Integer(*dice.pick(&[0, 1, 1, 2, 3, 5])));
    }
    if paths > 0 && dice.one_in(6) {
        let budget =
            if dice.one_in(2) { Value::from("full") } else { Value::Integer(dice.whole(100, 20_000)) };
        indirect.insert("budget".into(), budget);
        indirect.insert("paths_per_frame".into(), Value::Integer(dice.whole(1, 4)));
    }
    shot.insert("indirect".into(), Value::Table(indirect));
}

fn add_ambient(dice: &mut Dice, shot: &mut Table) {
    if dice.one_in(3) {
        let mut ambient = table([("color", numbers(color(dice)))]);
        for key in ["everywhere", "occluded"] {
            if dice.one_in(2) {
                ambient.insert(key.into(), Value::Boolean(true));
            }
        }
        shot.insert("ambient".into(), Value::Table(ambient));
    }
    if dice.one_in(3) {
        let rays = Value::Integer(*dice.pick(&[1, 3, 8]));
        let radius = dice.between(0.1, 3.0).into();
        shot.insert("occlusion".into(), Value::Table(table([("rays", rays), ("radius", radius)])));
    }
}

/// What rays see that leave the shot.
fn add_surroundings(dice: &mut Dice, shot: &mut Table) {
    if dice.one_in(2) {
        let mut background = Table::new();
        if dice.one_in(2) {
            background.insert("color".into(), numbers(color(dice)));
        } else {
            for key in ["zenith", "horizon", "ground"] {
                background.insert(key.into(), numbers(color(dice)));
            }
        }
        shot.insert("background".into(), Value::Table(background));
    }
    if !dice.one_in(4) {
        return;
    }
    let mut environment = Table::new();
    match dice.below(3) {
        0 => drop(environment.insert("map".into(), MAP.into())),
        1 => {
            let elevation = Value::Float(dice.between(-6.0, 90.0));
            environment.insert("sky".into(), Value::Table(table([("elevation", elevation)])));
        }
        // the background is the environment
        _ if shot.contains_key("background") => {}
        _ => return,
    }
    environment.insert("power".into(), Value::Float(*dice.pick(&[0.0, 0.2, 1.0, 10.0])));
    environment.insert("samples".into(), Value::Integer(*dice.pick(&[0, 1, 1, 2])));
    environment.insert("visible".into(), Value::Boolean(dice.one_in(2)));
    environment.insert("rotation".into(), Value::Float(dice.between(0.0, 360.0)));
    shot.insert("environment".into(), Value::Table(environment));
}
