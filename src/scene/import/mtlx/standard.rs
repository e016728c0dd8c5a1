//! Nodes of MaterialX's standard library that are arithmetic or patterns.
//!
//! Of a number all three floats are the same, so that one function does for numbers, vectors and colours. Four channels are not kept:
//! the fourth is looked up where a node takes that alone ([`images`](super::images)).

use std::fmt;
use std::sync::Arc;

use glam::Vec3;

use super::noise;
use crate::graph::functions::color::{hsv_to_rgb, rgb_to_hsv};
use crate::graph::{Function, Place};

/// A kind of node.
pub struct Standard {
    pub name: &'static str,
    pub inputs: &'static [Taken],
    of: fn(&[Vec3], Asked) -> Vec3,
}

/// What is asked of a node.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// Number of the output.
    pub output: usize,
    /// Channels of its values that count, 1 to 3: of one all three are the same, of two the third is 0.
    pub channels: usize,
}

/// An input of a kind of node.
pub struct Taken {
    pub name: &'static str,
    pub default: Default,
}

/// What counts where nothing is stated.
#[derive(Debug, Clone, Copy)]
pub enum Default {
    Number(f32),
    Color([f32; 3]),
    /// Texture coordinates.
    Uv,
    /// The place in object space.
    Point,
}

/// The kind of node with this name.
pub fn named(name: &str) -> Option<&'static Standard> {
    ALL.iter().find(|standard| standard.name == name)
}

/// Number of an output with this name, of nodes with several.
pub fn output_number(name: &str) -> Option<usize> {
    match name {
        "outx" | "outr" | "out" | "outcolor" => Some(0),
        "outy" | "outg" => Some(1),
        "outz" | "outb" => Some(2),
        "outw" | "outa" => Some(3),
        _ => None,
    }
}

impl Standard {
    /// The function of what is asked.
    pub fn asked(&'static self, asked: Asked) -> Arc<dyn Function> {
        Arc::new(OfStandard { standard: self, asked })
    }

    /// The function of the first output, of three channels.
    pub fn whole(&'static self) -> Arc<dyn Function> {
        self.asked(Asked { output: 0, channels: 3 })
    }
}

/// The function of a kind of node that is in the list.
pub fn function(name: &'static str) -> Arc<dyn Function> {
    named(name).expect("it is in the list").whole()
}

/// Function that makes a number of a picture's colour: that of its first channel.
pub fn first_channel() -> Arc<dyn Function> {
    static FIRST: Standard = Standard {
        name: "first_channel",
        inputs: &[Taken { name: "in", default: ZERO }],
        of: |a, _| Vec3::splat(a[0].x),
    };
    FIRST.whole()
}

struct OfStandard {
    standard: &'static Standard,
    asked: Asked,
}

impl fmt::Debug for OfStandard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.standard.name, self.asked.output, self.asked.channels)
    }
}

impl Function for OfStandard {
    fn value(&self, inputs: &[Vec3], _: &dyn Place) -> Vec3 {
        let value = (self.standard.of)(inputs, self.asked);
        if self.asked.channels == 2 { value.with_z(0.0) } else { value }
    }
}

const ZERO: Default = Default::Number(0.0);
const ONE: Default = Default::Number(1.0);

/// Luminance of the primaries of ACEScg, which the specification has as default.
const LUMINANCE: Default = Default::Color([0.272_228_7, 0.674_081_8, 0.053_689_5]);

const fn taken(name: &'static str, default: Default) -> Taken {
    Taken { name, default }
}

/// Each channel by itself.
fn each(value: Vec3, of: impl Fn(f32) -> f32) -> Vec3 {
    Vec3::new(of(value.x), of(value.y), of(value.z))
}

/// Each channel of two values.
fn both(a: Vec3, b: Vec3, of: impl Fn(f32, f32) -> f32) -> Vec3 {
    Vec3::new(of(a.x, b.x), of(a.y, b.y), of(a.z, b.z))
}

fn chosen(is: impl Fn(f32, f32) -> bool, a: &[Vec3]) -> Vec3 {
    if is(a[0].x, a[1].x) { a[2] } else { a[3] }
}

macro_rules! unary {
    ($name:literal, $of:expr) => {
        Standard { name: $name, inputs: &[taken("in", ZERO)], of: |a, _| each(a[0], $of) }
    };
}

macro_rules! binary {
    ($name:literal, $first:expr, $second:expr, $of:expr) => {
        Standard {
            name: $name,
            inputs: &[taken("in1", $first), taken("in2", $second)],
            of: |a, _| $of(a[0], a[1]),
        }
    };
}

macro_rules! blend {
    ($name:literal, $of:expr) => {
        Standard {
            name: $name,
            inputs: &[taken("fg", ZERO), taken("bg", ZERO), taken("mix", ONE)],
            of: |a, _| a[1].lerp($of(a[0], a[1]), a[2].x),
        }
    };
}

macro_rules! compare {
    ($name:literal, $first:expr, $is:expr) => {
        Standard {
            name: $name,
            inputs: &[taken("value1", $first), taken("value2", ZERO), taken("in1", ZERO), taken("in2", ZERO)],
            of: |a, _| chosen($is, a),
        }
    };
}

static ALL: &[Standard] = &[
    Standard { name: "constant", inputs: &[taken("value", ZERO)], of: |a, _| a[0] },
    Standard { name: "convert", inputs: &[taken("in", ZERO)], of: |a, _| a[0] },
    unary!("absval", f32::abs),
    unary!("sign", |x| if x == 0.0 { 0.0 } else { x.signum() }),
    unary!("floor", f32::floor),
    unary!("ceil", f32::ceil),
    unary!("round", f32::round),
    unary!("fract", |x| x - x.floor()),
    unary!("sin", f32::sin),
    unary!("cos", f32::cos),
    unary!("tan", f32::tan),
    unary!("asin", |x| x.clamp(-1.0, 1.0).asin()),
    unary!("acos", |x| x.clamp(-1.0, 1.0).acos()),
    unary!("sqrt", |x| x.max(0.0).sqrt()),
    unary!("ln", f32::ln),
    unary!("exp", f32::exp),
    binary!("add", ZERO, ZERO, |a: Vec3, b: Vec3| a + b),
    binary!("subtract", ZERO, ZERO, |a: Vec3, b: Vec3| a - b),
    binary!("multiply", ZERO, ONE, |a: Vec3, b: Vec3| a * b),
    binary!("divide", ZERO, ONE, |a: Vec3, b: Vec3| a / b),
    binary!("modulo", ZERO, ONE, |a, b| both(a, b, |x, y| x - y * (x / y).floor())),
    binary!("power", ZERO, ONE, |a, b| both(a, b, f32::powf)),
    binary!("min", ZERO, ZERO, |a: Vec3, b| a.min(b)),
    binary!("max", ZERO, ZERO, |a: Vec3, b| a.max(b)),
    binary!("dotproduct", ZERO, ZERO, |a: Vec3, b| Vec3::splat(a.dot(b))),
    binary!("crossproduct", ZERO, ZERO, |a: Vec3, b| a.cross(b)),
    Standard {
        name: "atan2",
        inputs: &[taken("iny", ZERO), taken("inx", ONE)],
        of: |a, _| both(a[0], a[1], f32::atan2),
    },
    Standard { name: "normalize", inputs: &[taken("in", ZERO)], of: |a, _| a[0].normalize_or_zero() },
    Standard { name: "magnitude", inputs: &[taken("in", ZERO)], of: |a, _| Vec3::splat(a[0].length()) },
    Standard { name: "invert", inputs: &[taken("in", ZERO), taken("amount", ONE)], of: |a, _| a[1] - a[0] },
    Standard {
        name: "clamp",
        inputs: &[taken("in", ZERO), taken("low", ZERO), taken("high", ONE)],
        of: |a, _| a[0].max(a[1]).min(a[2]),
    },
    Standard {
        name: "remap",
        inputs: &[
            taken("in", ZERO),
            taken("inlow", ZERO),
            taken("inhigh", ONE),
            taken("outlow", ZERO),
            taken("outhigh", ONE),
        ],
        of: |a, _| a[3] + (a[0] - a[1]) / (a[2] - a[1]) * (a[4] - a[3]),
    },
    Standard {
        name: "smoothstep",
        inputs: &[taken("in", ZERO), taken("low", ZERO), taken("high", ONE)],
        of: |a, _| {
            let t = ((a[0] - a[1]) / (a[2] - a[1])).clamp(Vec3::ZERO, Vec3::ONE);
            t * t * (3.0 - 2.0 * t)
        },
    },
    Standard {
        name: "mix",
        inputs: &[taken("fg", ZERO), taken("bg", ZERO), taken("mix", ZERO)],
        of: |a, _| a[1] * (Vec3::ONE - a[2]) + a[0] * a[2],
    },
    Standard {
        name: "switch",
        inputs: &[
            taken("which", ZERO),
            taken("in1", ZERO),
            taken("in2", ZERO),
            taken("in3", ZERO),
            taken("in4", ZERO),
            taken("in5", ZERO),
            taken("in6", ZERO),
            taken("in7", ZERO),
            taken("in8", ZERO),
            taken("in9", ZERO),
            taken("in10", ZERO),
        ],
        // what is not there is 0
        of: |a, _| {
            if a[0].x < 0.0 { Vec3::ZERO } else { a[1..].get(a[0].x as usize).copied().unwrap_or_default() }
        },
    },
    Standard {
        name: "range",
        inputs: &[
            taken("in", ZERO),
            taken("inlow", ZERO),
            taken("inhigh", ONE),
            taken("gamma", ONE),
            taken("outlow", ZERO),
            taken("outhigh", ONE),
            taken("doclamp", ZERO),
        ],
        of: |a, _| {
            let share = (a[0] - a[1]) / (a[2] - a[1]);
            let bent = both(share, a[3], |share, gamma| share.signum() * share.abs().powf(1.0 / gamma));
            let value = a[4] + bent * (a[5] - a[4]);
            if a[6].x == 1.0 { value.max(a[4]).min(a[5]) } else { value }
        },
    },
    Standard {
        name: "hsvadjust",
        inputs: &[taken("in", ZERO), taken("amount", Default::Color([0.0, 1.0, 1.0]))],
        of: |a, _| {
            let Vec3 { x: hue, y: saturation, z: value } = rgb_to_hsv(a[0]);
            let hue = hue + a[1].x;
            hsv_to_rgb(Vec3::new(hue - hue.floor(), saturation * a[1].y, value * a[1].z))
        },
    },
    Standard { name: "inside", inputs: &[taken("in", ZERO), taken("mask", ONE)], of: |a, _| a[0] * a[1].x },
    Standard {
        name: "outside",
        inputs: &[taken("in", ZERO), taken("mask", ZERO)],
        of: |a, _| a[0] * (1.0 - a[1].x),
    },
    binary!("safepower", ZERO, ONE, |a, b| both(a, b, |x: f32, y| x.signum() * x.abs().powf(y))),
    binary!("distance", ZERO, ZERO, |a: Vec3, b| Vec3::splat(a.distance(b))),
    blend!("plus", |a: Vec3, b: Vec3| a + b),
    blend!("minus", |a: Vec3, b: Vec3| b - a),
    blend!("difference", |a: Vec3, b: Vec3| (a - b).abs()),
    blend!("screen", |a: Vec3, b: Vec3| Vec3::ONE - (Vec3::ONE - a) * (Vec3::ONE - b)),
    blend!("overlay", |a, b| both(a, b, |fg, bg| {
        if bg < 0.5 { 2.0 * fg * bg } else { 1.0 - 2.0 * (1.0 - fg) * (1.0 - bg) }
    })),
    blend!("burn", |a, b| both(a, b, |fg, bg| 1.0 - (1.0 - bg) / fg)),
    blend!("dodge", |a, b| both(a, b, |fg, bg| bg / (1.0 - fg))),
    compare!("ifgreater", ONE, |a, b| a > b),
    compare!("ifgreatereq", ONE, |a, b| a >= b),
    compare!("ifequal", ZERO, |a, b| a == b),
    Standard {
        name: "luminance",
        inputs: &[taken("in", ZERO), taken("lumacoeffs", LUMINANCE)],
        of: |a, _| Vec3::splat(a[0].dot(a[1])),
    },
    Standard { name: "rgbtohsv", inputs: &[taken("in", ZERO)], of: |a, _| rgb_to_hsv(a[0]) },
    Standard {
        name: "hsvtorgb",
        inputs: &[taken("in", ZERO)],
        of: |a, _| hsv_to_rgb(a[0].with_x(a[0].x - a[0].x.floor())),
    },
    Standard {
        name: "saturate",
        inputs: &[taken("in", ZERO), taken("amount", ONE), taken("lumacoeffs", LUMINANCE)],
        of: |a, _| Vec3::splat(a[0].dot(a[2])).lerp(a[0], a[1].x),
    },
    Standard {
        name: "contrast",
        inputs: &[taken("in", ZERO), taken("amount", ONE), taken("pivot", Default::Number(0.5))],
        of: |a, _| (a[0] - a[2]) * a[1] + a[2],
    },
    Standard {
        name: "extract",
        inputs: &[taken("in", ZERO), taken("index", ZERO)],
        of: |a, _| Vec3::splat(a[0][(a[1].x.max(0.0) as usize).min(2)]),
    },
    Standard {
        name: "separate2",
        inputs: &[taken("in", ZERO)],
        of: |a, asked| Vec3::splat(a[0][asked.output.min(2)]),
    },
    Standard {
        name: "separate3",
        inputs: &[taken("in", ZERO)],
        of: |a, asked| Vec3::splat(a[0][asked.output.min(2)]),
    },
    Standard {
        name: "separate4",
        inputs: &[taken("in", ZERO)],
        of: |a, asked| Vec3::splat(a[0][asked.output.min(2)]),
    },
    Standard {
        name: "combine2",
        inputs: &[taken("in1", ZERO), taken("in2", ZERO)],
        of: |a, _| Vec3::new(a[0].x, a[1].x, 0.0),
    },
    Standard {
        name: "combine3",
        inputs: &[taken("in1", ZERO), taken("in2", ZERO), taken("in3", ZERO)],
        of: |a, _| Vec3::new(a[0].x, a[1].x, a[2].x),
    },
    Standard {
        name: "combine4",
        inputs: &[taken("in1", ZERO), taken("in2", ZERO), taken("in3", ZERO), taken("in4", ZERO)],
        of: |a, _| Vec3::new(a[0].x, a[1].x, a[2].x),
    },
    Standard {
        name: "noise2d",
        inputs: &[taken("amplitude", ONE), taken("pivot", ZERO), taken("texcoord", Default::Uv)],
        of: |a, asked| a[0] * noise::perlin(a[2].truncate().to_array(), asked.channels) + a[1].x,
    },
    Standard {
        name: "noise3d",
        inputs: &[taken("amplitude", ONE), taken("pivot", ZERO), taken("position", Default::Point)],
        of: |a, asked| a[0] * noise::perlin(a[2].to_array(), asked.channels) + a[1].x,
    },
    Standard {
        name: "fractal2d",
        inputs: &[
            taken("amplitude", ONE),
            taken("octaves", Default::Number(3.0)),
            taken("lacunarity", Default::Number(2.0)),
            taken("diminish", Default::Number(0.5)),
            taken("texcoord", Default::Uv),
        ],
        of: |a, asked| a[0] * octaves(a).noise(a[4].truncate().to_array(), asked.channels),
    },
    Standard {
        name: "fractal3d",
        inputs: &[
            taken("amplitude", ONE),
            taken("octaves", Default::Number(3.0)),
            taken("lacunarity", Default::Number(2.0)),
            taken("diminish", Default::Number(0.5)),
            taken("position", Default::Point),
        ],
        of: |a, asked| a[0] * octaves(a).noise(a[4].to_array(), asked.channels),
    },
    Standard {
        name: "cellnoise2d",
        inputs: &[taken("texcoord", Default::Uv)],
        of: |a, _| Vec3::splat(noise::cell(a[0].truncate().to_array())),
    },
    Standard {
        name: "cellnoise3d",
        inputs: &[taken("position", Default::Point)],
        of: |a, _| Vec3::splat(noise::cell(a[0].to_array())),
    },
    Standard {
        name: "worleynoise2d",
        inputs: &[taken("texcoord", Default::Uv), taken("jitter", ONE), taken("style", ZERO)],
        of: |a, asked| noise::worley(a[0].truncate().to_array(), a[1].x, a[2].x == 1.0, asked.channels),
    },
    Standard {
        name: "worleynoise3d",
        inputs: &[taken("position", Default::Point), taken("jitter", ONE), taken("style", ZERO)],
        of: |a, asked| noise::worley(a[0].to_array(), a[1].x, a[2].x == 1.0, asked.channels),
    },
    Standard {
        name: "place2d",
        inputs: &[
            taken("texcoord", Default::Uv),
            taken("pivot", ZERO),
            taken("scale", ONE),
            taken("rotate", ZERO),
            taken("offset", ZERO),
            taken("operationorder", ZERO),
        ],
        of: |a, _| {
            let (centred, scale) = (a[0] - a[1], a[2].with_z(1.0));
            match a[5].x == 1.0 {
                true => rotated(centred - a[4], -a[3].x) / scale + a[1],
                false => rotated(centred / scale, -a[3].x) - a[4] + a[1],
            }
        },
    },
    Standard {
        name: "rotate2d",
        inputs: &[taken("in", ZERO), taken("amount", ZERO)],
        of: |a, _| rotated(a[0], a[1].x),
    },
    Standard {
        name: "ramplr",
        inputs: &[taken("valuel", ZERO), taken("valuer", ZERO), taken("texcoord", Default::Uv)],
        of: |a, _| a[0].lerp(a[1], a[2].x.clamp(0.0, 1.0)),
    },
    Standard {
        name: "ramptb",
        inputs: &[taken("valuet", ZERO), taken("valueb", ZERO), taken("texcoord", Default::Uv)],
        of: |a, _| a[1].lerp(a[0], a[2].y.clamp(0.0, 1.0)),
    },
    Standard {
        name: "ramp4",
        inputs: &[
            taken("valuetl", ZERO),
            taken("valuetr", ZERO),
            taken("valuebl", ZERO),
            taken("valuebr", ZERO),
            taken("texcoord", Default::Uv),
        ],
        of: |a, _| {
            let at = a[4].clamp(Vec3::ZERO, Vec3::ONE);
            a[2].lerp(a[3], at.x).lerp(a[0].lerp(a[1], at.x), at.y)
        },
    },
    Standard {
        name: "splitlr",
        inputs: &[
            taken("valuel", ZERO),
            taken("valuer", ZERO),
            taken("center", Default::Number(0.5)),
            taken("texcoord", Default::Uv),
        ],
        of: |a, _| if a[3].x < a[2].x { a[0] } else { a[1] },
    },
    Standard {
        name: "splittb",
        inputs: &[
            taken("valuet", ZERO),
            taken("valueb", ZERO),
            taken("center", Default::Number(0.5)),
            taken("texcoord", Default::Uv),
        ],
        of: |a, _| if a[3].y < a[2].x { a[1] } else { a[0] },
    },
    Standard {
        name: "checkerboard",
        inputs: &[
            taken("color1", ONE),
            taken("color2", ZERO),
            taken("uvtiling", Default::Number(8.0)),
            taken("uvoffset", ZERO),
            taken("texcoord", Default::Uv),
        ],
        of: |a, _| {
            let at = (a[4] * a[2] - a[3]).floor();
            if (at.x + at.y).rem_euclid(2.0) > 0.0 { a[1] } else { a[0] }
        },
    },
];

/// Octaves of a fractal, of its inputs.
fn octaves(a: &[Vec3]) -> noise::Octaves {
    noise::Octaves { count: a[1].x, lacunarity: a[2].x, diminish: a[3].x }
}

/// A vector turned in the plane of x and y, by degrees against the clock.
fn rotated(vector: Vec3, degrees: f32) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vec3::new(cos * vector.x - sin * vector.y, sin * vector.x + cos * vector.y, vector.z)
}
