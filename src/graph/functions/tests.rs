//! Our arithmetic beside Blender's: `beside_blender.csv` is what Cycles renders of each operation (see
//! `integrations/blender/scripts/node_functions.py`, which wrote it).
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
use super::color::{self, Adjustment, Model};
use super::curve::{self, Table};
use super::map_range::{Clamp, Progress, Ranges};
use super::math::Math;
use super::mix::{self, Blend};
use super::ramp::{Interpolation, Mode, Ramp, Stop};
use super::vector::{Mapping, Rotate, Turn};
use super::vector_math::VectorMath;
use super::{fresnel, spectrum};
use crate::lanes::{F32x8, Vec3x8};
use glam::Vec3;
use std::collections::BTreeMap;

/// The largest difference that we allow, of values above 1 relative to them.
const TOLERANCE: f32 = 1e-4;

/// A line of the file.
struct Line<'a> {
    family: &'a str,
    operation: &'a str,
    inputs: Vec<f32>,
    outputs: Vec<f32>,
}

impl Line<'_> {
    fn number(&self, index: usize) -> F32x8 {
        F32x8::splat(self.one(index))
    }

    fn one(&self, index: usize) -> f32 {
        self.inputs.get(index).copied().unwrap_or(0.0)
    }

    fn vector(&self, index: usize) -> Vec3x8 {
        Vec3x8::from([self.number(index), self.number(index + 1), self.number(index + 2)])
    }

    /// The operation, and whether a word follows it.
    fn operation_and(&self, word: &str) -> (&str, bool) {
        match self.operation.split_once(' ') {
            Some((operation, following)) => (operation, following == word),
            None => (self.operation, false),
        }
    }
}

fn lines() -> Vec<Line<'static>> {
    let numbers = |text: &str| text.split_whitespace().map(|number| number.parse().unwrap()).collect();
    let line = |text: &'static str| {
        let [family, operation, inputs, outputs] = text.split(',').collect::<Vec<_>>().try_into().unwrap();
        Line { family, operation, inputs: numbers(inputs), outputs: numbers(outputs) }
    };
    include_str!("beside_blender.csv").lines().map(line).collect()
}

/// What the lines define that others use.
struct Defined {
    ramps: BTreeMap<&'static str, Vec<Stop>>,
    tables: BTreeMap<&'static str, Vec<Table>>,
}

impl Defined {
    fn of(lines: &[Line<'static>]) -> Self {
        let of_family = |family: &'static str| lines.iter().filter(move |line| line.family == family);
        let stop = |stop: &[f32]| Stop { position: stop[0], color: stop[1..5].try_into().unwrap() };
        let table = |line: &Line, values: &[f32]| Table {
            from: line.one(0),
            to: line.one(1),
            values: values.to_vec(),
            extrapolate: line.one(2) == 1.0,
        };
        let stops = |line: &Line| line.inputs.chunks(5).map(stop).collect();
        let tables =
            |line: &Line| line.inputs[3..].chunks(curve::SAMPLES).map(|values| table(line, values)).collect();
        Self {
            ramps: of_family("ramp").map(|line| (line.operation, stops(line))).collect(),
            tables: of_family("table").map(|line| (line.operation, tables(line))).collect(),
        }
    }

    fn ramp(&self, line: &Line) -> [f32; 4] {
        let [name, mode, interpolation, hue] =
            line.operation.split(' ').collect::<Vec<_>>().try_into().unwrap();
        let mode = Mode::named(mode, hue).unwrap();
        let ramp = Ramp::new(self.ramps[name].clone(), Interpolation::named(interpolation).unwrap(), mode);
        ramp.value(line.number(0)).map(|channel| channel.lane(3))
    }

    fn curve(&self, line: &Line) -> Vec<f32> {
        let tables = &self.tables[line.operation];
        match <&[Table; 3]>::try_from(tables.as_slice()) {
            Ok(tables) => of_vector(curve::channels(line.number(0), line.vector(1), tables)),
            Err(_) => vec![curve::float(line.number(0), line.number(1), &tables[0]).lane(3)],
        }
    }
}

/// What we make of a line; `None` for a definition.
fn ours(line: &Line, defined: &Defined) -> Option<Vec<f32>> {
    let vector = |vector: Vec3x8| Some(of_vector(vector));
    let value = |value: F32x8| Some(vec![value.lane(3)]);
    let (a, b, c) = (line.number(0), line.number(1), line.number(2));
    match line.family {
        "math" => value(Math::named(line.operation).unwrap().apply(a, b, c)),
        "vector_math" => Some(vector_math(line)),
        "blend" => vector(Blend::named(line.operation).unwrap().apply(a, line.vector(1), line.vector(4))),
        "mix" => match line.operation {
            "float" => value(mix::float(a, b, c)),
            "uniform" => vector(mix::vector(a, line.vector(1), line.vector(4))),
            _ => vector(mix::vector_non_uniform(line.vector(0), line.vector(3), line.vector(6))),
        },
        "clamp" => value(Clamp::named(line.operation).unwrap().apply(a, b, c)),
        "map_range" | "map_range_vector" => Some(map_range(line)),
        "mapping" => vector(mapping(line)),
        "rotate" => vector(rotate(line)),
        "fresnel" | "layer_weight" => Some(vec![weight(line)]),
        "color" => Some(of_color(line)),
        "ramp_color" => Some(defined.ramp(line)[..3].to_vec()),
        "ramp_alpha" => Some(vec![defined.ramp(line)[3]]),
        "curve" => Some(defined.curve(line)),
        _ => None,
    }
}

/// A lane of a vector.
fn of_vector(vector: Vec3x8) -> Vec<f32> {
    vector.lane(3).to_array().to_vec()
}

fn vector_math(line: &Line) -> Vec<f32> {
    let operation = VectorMath::named(line.operation).unwrap();
    let used = 3 * operation.inputs();
    assert_eq!(line.inputs.len(), used + usize::from(operation.has_scale()), "{}", line.operation);
    match operation.gives_value() {
        true => vec![operation.value(line.vector(0), line.vector(3)).lane(3)],
        false => {
            of_vector(operation.vector(line.vector(0), line.vector(3), line.vector(6), line.number(used)))
        }
    }
}

fn map_range(line: &Line) -> Vec<f32> {
    let (progress, clamp) = line.operation_and("clamp");
    let progress = Progress::named(progress).unwrap();
    if line.family == "map_range" {
        let [from, to] = [[1, 2], [3, 4]].map(|ends| ends.map(|end| line.number(end)));
        let ranges = Ranges { from, to, steps: line.number(5) };
        return vec![ranges.map(progress, clamp, line.number(0)).lane(3)];
    }
    let [from, to] = [[3, 6], [9, 12]].map(|ends| ends.map(|end| line.vector(end)));
    of_vector(Ranges { from, to, steps: line.vector(15) }.map(progress, clamp, line.vector(0)))
}

fn mapping(line: &Line) -> Vec3x8 {
    let mapping = Mapping::named(line.operation).unwrap();
    match mapping {
        Mapping::Point | Mapping::Texture => {
            mapping.apply(line.vector(0), line.vector(3), line.vector(6), line.vector(9))
        }
        Mapping::Vector | Mapping::Normal => {
            mapping.apply(line.vector(0), Vec3x8::splat(Vec3::ONE), line.vector(3), line.vector(6))
        }
    }
}

fn rotate(line: &Line) -> Vec3x8 {
    let (kind, invert) = line.operation_and("invert");
    let kind = Rotate::named(kind).unwrap();
    let angle = line.number(if kind == Rotate::AxisAngle { 9 } else { 6 });
    let turn = Turn { axis: line.vector(6), angle, rotation: line.vector(6), invert };
    kind.apply(line.vector(0), line.vector(3), &turn)
}

fn weight(line: &Line) -> f32 {
    let (kind, inside) = line.operation_and("back");
    let (parameter, cosine) = (line.one(0), line.one(3));
    match (line.family, kind) {
        ("fresnel", _) => fresnel::fresnel(cosine, parameter, inside),
        (_, "fresnel") => fresnel::layer_fresnel(cosine, parameter, inside),
        _ => fresnel::layer_facing(cosine, parameter),
    }
}

fn of_color(line: &Line) -> Vec<f32> {
    let (number, color) = (|index| line.number(index), line.vector(0));
    let made = match line.operation {
        "hue_saturation_value" => {
            let change =
                Adjustment { hue: number(4), saturation: number(5), value: number(6), factor: number(0) };
            change.apply(line.vector(1))
        }
        "brightness_contrast" => color::brightness_contrast(color, number(3), number(4)),
        "gamma" => color::gamma(color, number(3)),
        "invert" => color::invert(number(0), line.vector(1)),
        "luma" => return vec![color::luma(color).lane(3)],
        "blackbody" => Vec3x8::splat(spectrum::blackbody(line.one(0))),
        "wavelength" => Vec3x8::splat(spectrum::wavelength(line.one(0))),
        "from_hsv" => Model::Hsv.combine(color),
        "from_hsl" => Model::Hsl.combine(color),
        "to_hsv" => Model::Hsv.separate(color),
        "to_hsl" => Model::Hsl.separate(color),
        other => panic!("{other}"),
    };
    of_vector(made)
}

#[test]
fn all_operations_give_what_blender_gives() {
    let lines = lines();
    let defined = Defined::of(&lines);
    let mut largest = BTreeMap::new();
    for line in &lines {
        let Some(ours) = ours(line, &defined) else { continue };
        assert_eq!(ours.len(), line.outputs.len(), "{} {}", line.family, line.operation);
        let difference = |(ours, theirs): (&f32, &f32)| (ours - theirs).abs() / theirs.abs().max(1.0);
        let difference = ours.iter().zip(&line.outputs).map(difference).fold(0.0, f32::max);
        let seen = largest.entry((line.family, line.operation)).or_insert((0.0, String::new()));
        if difference > seen.0 {
            *seen = (difference, format!("{:?}: {ours:?}, Blender has {:?}", line.inputs, line.outputs));
        }
    }
    let mut differing: Vec<_> =
        largest.into_iter().filter(|(_, (difference, _))| *difference > 0.0).collect();
    differing.sort_by(|(_, (a, _)), (_, (b, _))| b.total_cmp(a));
    let report = |(operation, (difference, example)): &(_, (f32, String))| {
        format!("{difference:9.2e} {operation:?} of {example}\n")
    };
    println!("{}", differing.iter().map(report).collect::<String>());
    let wrong: Vec<_> = differing.iter().filter(|(_, (difference, _))| *difference > TOLERANCE).collect();
    assert!(wrong.is_empty(), "{}", wrong.into_iter().map(report).collect::<String>());
}

#[test]
fn blender_has_all_operations_with_as_many_inputs() {
    let lines = lines();
    let find =
        |family: &str, name: &str| lines.iter().find(|line| (line.family, line.operation) == (family, name));
    for operation in Math::ALL {
        let line = find("math", operation.name()).unwrap_or_else(|| panic!("{operation:?}"));
        assert_eq!(line.inputs.len(), operation.inputs(), "{operation:?}");
    }
    // Rounding came after the Blender that wrote the file.
    for operation in VectorMath::ALL.iter().filter(|operation| **operation != VectorMath::Round) {
        assert!(find("vector_math", operation.name()).is_some(), "{operation:?}");
    }
    assert!(Blend::ALL.iter().all(|blend| find("blend", blend.name()).is_some()));
}
