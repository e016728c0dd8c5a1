//! Nodes of MaterialX's standard library that are arithmetic or patterns.
//!
//! Of a number all three floats are the same, so that one function does for numbers, vectors and colours. Four channels are not kept:
//! the fourth is looked up where a node takes that alone ([`images`](super::images)).

use std::fmt;
use std::sync::Arc;

use super::noise::{self, Octaves};
use crate::graph::functions::color::{hsv_to_rgb, rgb_to_hsv};
use crate::graph::{Function, Places};
use crate::lanes::{F32x8, Mask, Vec3x8};

/// A kind of node.
pub struct Standard {
    pub name: &'static str,
    pub inputs: &'static [Taken],
    /// Values of what is wanted, eight at a time.
    of: fn(&[Vec3x8], Wanted) -> Vec3x8,
}

/// What is asked of a node.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// Number of the output.
    pub output: usize,
    /// Channels of its values that count, 1 to 3: of one all three are the same, of two the third is 0.
    pub channels: usize,
}

/// What is wanted of a function.
#[derive(Clone, Copy)]
struct Wanted {
    asked: Asked,
    /// How many lanes count, from the first on.
    lanes: usize,
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

/// Number of the output that is alpha.
pub const ALPHA: usize = 3;

/// Number of an output with this name, of nodes with several.
pub fn output_number(name: &str) -> Option<usize> {
    match name {
        "outx" | "outr" | "out" | "outcolor" => Some(0),
        "outy" | "outg" => Some(1),
        "outz" | "outb" => Some(2),
        "outw" | "outa" => Some(ALPHA),
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
        of: |a, _| Vec3x8::all_of(a[0].x),
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
    fn values(&self, inputs: &[Vec3x8], places: Places) -> Vec3x8 {
        let values = (self.standard.of)(inputs, Wanted { asked: self.asked, lanes: places.lanes() });
        if self.asked.channels == 2 { Vec3x8 { z: F32x8::ZERO, ..values } } else { values }
    }
}

const ZERO: Default = Default::Number(0.0);
const ONE: Default = Default::Number(1.0);

/// Luminance of the primaries of ACEScg, which the specification has as default.
const LUMINANCE: Default = Default::Color([0.272_228_7, 0.674_081_8, 0.053_689_5]);

const fn taken(name: &'static str, default: Default) -> Taken {
    Taken { name, default }
}

/// Where the first two numbers are as `is` says the third value, elsewhere the fourth.
fn chosen(is: fn(F32x8, F32x8) -> Mask, a: &[Vec3x8]) -> Vec3x8 {
    is(a[0].x, a[1].x).select3(a[2], a[3])
}

/// Between two values: the first where `share` is 0, the second where it is 1.
fn lerp(a: Vec3x8, b: Vec3x8, share: F32x8) -> Vec3x8 {
    a * rest(share) + b * share
}

/// 1 less the number.
fn rest(value: F32x8) -> F32x8 {
    F32x8::ONE - value
}

macro_rules! unary {
    ($name:literal, $of:expr) => {
        Standard { name: $name, inputs: &[taken("in", ZERO)], of: |a, _| a[0].each($of) }
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
            of: |a, _| lerp(a[1], a[0].each_with(a[1], $of), a[2].x),
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
    unary!("absval", F32x8::abs),
    unary!("sign", |x| x.is_zero().select(F32x8::ZERO, F32x8::ONE.with_sign_of(x))),
    unary!("floor", F32x8::floor),
    unary!("ceil", F32x8::ceil),
    unary!("round", |x| x.each(f32::round)),
    unary!("fract", |x| x - x.floor()),
    unary!("sin", |x| x.each(f32::sin)),
    unary!("cos", |x| x.each(f32::cos)),
    unary!("tan", |x| x.each(f32::tan)),
    unary!("asin", |x| x.clamp(-1.0, 1.0).each(f32::asin)),
    unary!("acos", |x| x.clamp(-1.0, 1.0).each(f32::acos)),
    unary!("sqrt", |x| x.max(F32x8::ZERO).sqrt()),
    unary!("ln", |x| x.each(f32::ln)),
    unary!("exp", |x| x.each(f32::exp)),
    binary!("add", ZERO, ZERO, |a: Vec3x8, b: Vec3x8| a + b),
    binary!("subtract", ZERO, ZERO, |a: Vec3x8, b: Vec3x8| a - b),
    binary!("multiply", ZERO, ONE, |a: Vec3x8, b: Vec3x8| a * b),
    binary!("divide", ZERO, ONE, |a: Vec3x8, b: Vec3x8| a / b),
    binary!("modulo", ZERO, ONE, |a: Vec3x8, b| a.each_with(b, |x, y| x - y * (x / y).floor())),
    binary!("power", ZERO, ONE, |a: Vec3x8, b| a.each_with(b, |x, y| x.each_with(y, f32::powf))),
    binary!("min", ZERO, ZERO, |a: Vec3x8, b| a.min(b)),
    binary!("max", ZERO, ZERO, |a: Vec3x8, b| a.max(b)),
    binary!("dotproduct", ZERO, ZERO, |a: Vec3x8, b| Vec3x8::all_of(a.dot(b))),
    binary!("crossproduct", ZERO, ZERO, |a: Vec3x8, b| a.cross(b)),
    Standard {
        name: "atan2",
        inputs: &[taken("iny", ZERO), taken("inx", ONE)],
        of: |a, _| a[0].each_with(a[1], |y, x| y.each_with(x, f32::atan2)),
    },
    Standard { name: "normalize", inputs: &[taken("in", ZERO)], of: |a, _| normalized(a[0]) },
    Standard { name: "magnitude", inputs: &[taken("in", ZERO)], of: |a, _| Vec3x8::all_of(a[0].length()) },
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
            let t = ((a[0] - a[1]) / (a[2] - a[1])).each(|t| t.clamp(0.0, 1.0));
            t.each(|t| t * t * (F32x8::splat(3.0) - t * 2.0))
        },
    },
    Standard {
        name: "mix",
        inputs: &[taken("fg", ZERO), taken("bg", ZERO), taken("mix", ZERO)],
        of: |a, _| a[1] * a[2].each(rest) + a[0] * a[2],
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
            let which = a[0].x.floor();
            a[1..].iter().enumerate().fold(Vec3x8::ZERO, |chosen, (number, value)| {
                which.equals(F32x8::splat(number as f32)).select3(*value, chosen)
            })
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
            let bent = share.each_with(a[3], |share, gamma| signed_power(share, F32x8::ONE / gamma));
            let value = a[4] + bent * (a[5] - a[4]);
            a[6].x.equals(F32x8::ONE).select3(value.max(a[4]).min(a[5]), value)
        },
    },
    Standard {
        name: "hsvadjust",
        inputs: &[taken("in", ZERO), taken("amount", Default::Color([0.0, 1.0, 1.0]))],
        of: |a, _| {
            let Vec3x8 { x: hue, y: saturation, z: value } = rgb_to_hsv(a[0]);
            let hue = hue + a[1].x;
            hsv_to_rgb([hue - hue.floor(), saturation * a[1].y, value * a[1].z].into())
        },
    },
    Standard { name: "inside", inputs: &[taken("in", ZERO), taken("mask", ONE)], of: |a, _| a[0] * a[1].x },
    Standard {
        name: "outside",
        inputs: &[taken("in", ZERO), taken("mask", ZERO)],
        of: |a, _| a[0] * rest(a[1].x),
    },
    binary!("safepower", ZERO, ONE, |a: Vec3x8, b| a.each_with(b, signed_power)),
    binary!("distance", ZERO, ZERO, |a: Vec3x8, b: Vec3x8| Vec3x8::all_of((a - b).length())),
    blend!("plus", |fg, bg| fg + bg),
    blend!("minus", |fg, bg| bg - fg),
    blend!("difference", |fg, bg| (fg - bg).abs()),
    blend!("screen", |fg, bg| rest(rest(fg) * rest(bg))),
    blend!("overlay", |fg, bg| {
        bg.lt(F32x8::splat(0.5)).select(fg * 2.0 * bg, rest(rest(fg) * 2.0 * rest(bg)))
    }),
    blend!("burn", |fg, bg| rest(rest(bg) / fg)),
    blend!("dodge", |fg, bg| bg / rest(fg)),
    compare!("ifgreater", ONE, F32x8::gt),
    compare!("ifgreatereq", ONE, F32x8::ge),
    compare!("ifequal", ZERO, F32x8::equals),
    Standard {
        name: "luminance",
        inputs: &[taken("in", ZERO), taken("lumacoeffs", LUMINANCE)],
        of: |a, _| Vec3x8::all_of(a[0].dot(a[1])),
    },
    Standard { name: "rgbtohsv", inputs: &[taken("in", ZERO)], of: |a, _| rgb_to_hsv(a[0]) },
    Standard {
        name: "hsvtorgb",
        inputs: &[taken("in", ZERO)],
        of: |a, _| hsv_to_rgb(Vec3x8 { x: a[0].x - a[0].x.floor(), ..a[0] }),
    },
    Standard {
        name: "saturate",
        inputs: &[taken("in", ZERO), taken("amount", ONE), taken("lumacoeffs", LUMINANCE)],
        of: |a, _| lerp(Vec3x8::all_of(a[0].dot(a[2])), a[0], a[1].x),
    },
    Standard {
        name: "contrast",
        inputs: &[taken("in", ZERO), taken("amount", ONE), taken("pivot", Default::Number(0.5))],
        of: |a, _| (a[0] - a[2]) * a[1] + a[2],
    },
    Standard {
        name: "extract",
        inputs: &[taken("in", ZERO), taken("index", ZERO)],
        of: |a, _| {
            let is = |number: f32| a[1].x.lt(F32x8::splat(number));
            Vec3x8::all_of(is(1.0).select(a[0].x, is(2.0).select(a[0].y, a[0].z)))
        },
    },
    Standard { name: "separate2", inputs: &[taken("in", ZERO)], of: channel },
    Standard { name: "separate3", inputs: &[taken("in", ZERO)], of: channel },
    Standard { name: "separate4", inputs: &[taken("in", ZERO)], of: channel },
    Standard {
        name: "combine2",
        inputs: &[taken("in1", ZERO), taken("in2", ZERO)],
        of: |a, _| Vec3x8::from([a[0].x, a[1].x, F32x8::ZERO]),
    },
    Standard {
        name: "combine3",
        inputs: &[taken("in1", ZERO), taken("in2", ZERO), taken("in3", ZERO)],
        of: |a, _| Vec3x8::from([a[0].x, a[1].x, a[2].x]),
    },
    Standard {
        name: "combine4",
        inputs: &[taken("in1", ZERO), taken("in2", ZERO), taken("in3", ZERO), taken("in4", ZERO)],
        of: |a, _| Vec3x8::from([a[0].x, a[1].x, a[2].x]),
    },
    Standard {
        name: "noise2d",
        inputs: &[taken("amplitude", ONE), taken("pivot", ZERO), taken("texcoord", Default::Uv)],
        of: |a, wanted| a[0] * perlin([a[2].x, a[2].y], wanted) + a[1].x,
    },
    Standard {
        name: "noise3d",
        inputs: &[taken("amplitude", ONE), taken("pivot", ZERO), taken("position", Default::Point)],
        of: |a, wanted| a[0] * perlin::<3>(a[2].into(), wanted) + a[1].x,
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
        of: |a, wanted| a[0] * fractal(a, [a[4].x, a[4].y], wanted),
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
        of: |a, wanted| a[0] * fractal::<3>(a, a[4].into(), wanted),
    },
    Standard {
        name: "cellnoise2d",
        inputs: &[taken("texcoord", Default::Uv)],
        of: |a, _| Vec3x8::all_of(noise::cell([a[0].x, a[0].y])),
    },
    Standard {
        name: "cellnoise3d",
        inputs: &[taken("position", Default::Point)],
        of: |a, _| Vec3x8::all_of(noise::cell::<3>(a[0].into())),
    },
    Standard {
        name: "worleynoise2d",
        inputs: &[taken("texcoord", Default::Uv), taken("jitter", ONE), taken("style", ZERO)],
        of: |a, wanted| worley(a, [a[0].x, a[0].y], wanted),
    },
    Standard {
        name: "worleynoise3d",
        inputs: &[taken("position", Default::Point), taken("jitter", ONE), taken("style", ZERO)],
        of: |a, wanted| worley::<3>(a, a[0].into(), wanted),
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
            let (centred, scale) = (a[0] - a[1], Vec3x8 { z: F32x8::ONE, ..a[2] });
            let moves_first = a[5].x.equals(F32x8::ONE);
            let turned = rotated(moves_first.select3(centred - a[4], centred / scale), -a[3].x);
            moves_first.select3(turned / scale, turned - a[4]) + a[1]
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
        of: |a, _| lerp(a[0], a[1], a[2].x.clamp(0.0, 1.0)),
    },
    Standard {
        name: "ramptb",
        inputs: &[taken("valuet", ZERO), taken("valueb", ZERO), taken("texcoord", Default::Uv)],
        of: |a, _| lerp(a[1], a[0], a[2].y.clamp(0.0, 1.0)),
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
            let at = a[4].max(Vec3x8::ZERO).min(Vec3x8::all_of(F32x8::ONE));
            lerp(lerp(a[2], a[3], at.x), lerp(a[0], a[1], at.x), at.y)
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
        of: |a, _| a[3].x.lt(a[2].x).select3(a[0], a[1]),
    },
    Standard {
        name: "splittb",
        inputs: &[
            taken("valuet", ZERO),
            taken("valueb", ZERO),
            taken("center", Default::Number(0.5)),
            taken("texcoord", Default::Uv),
        ],
        of: |a, _| a[3].y.lt(a[2].x).select3(a[1], a[0]),
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
            let at = (a[4] * a[2] - a[3]).each(F32x8::floor);
            let rest = (at.x + at.y).each(|sum| sum.rem_euclid(2.0));
            rest.gt(F32x8::ZERO).select3(a[1], a[0])
        },
    },
];

/// Perlin noise at a place.
fn perlin<const N: usize>(place: [F32x8; N], Wanted { asked, lanes }: Wanted) -> Vec3x8 {
    noise::perlin(place, asked.channels, lanes)
}

/// Octaves of noise at a place, of the inputs of a fractal.
fn fractal<const N: usize>(a: &[Vec3x8], place: [F32x8; N], Wanted { asked, lanes }: Wanted) -> Vec3x8 {
    let octaves = Octaves { count: a[1].x, lacunarity: a[2].x, diminish: a[3].x };
    octaves.noise(place, asked.channels, lanes)
}

/// Worley noise at a place, of its inputs.
fn worley<const N: usize>(a: &[Vec3x8], place: [F32x8; N], wanted: Wanted) -> Vec3x8 {
    noise::worley(place, a[1].x, a[2].x.equals(F32x8::ONE), wanted.asked.channels)
}

/// The power of a number without its sign, with it.
fn signed_power(base: F32x8, exponent: F32x8) -> F32x8 {
    base.each_with(exponent, |base, exponent| base.signum() * base.abs().powf(exponent))
}

/// The channel with the number of the output.
fn channel(a: &[Vec3x8], wanted: Wanted) -> Vec3x8 {
    Vec3x8::all_of(<[F32x8; 3]>::from(a[0])[wanted.asked.output.min(2)])
}

/// The vector at length 1; 0 where it has no length.
fn normalized(vector: Vec3x8) -> Vec3x8 {
    let scale = F32x8::ONE / vector.length();
    let has_direction = scale.gt(F32x8::ZERO) & scale.lt(F32x8::splat(f32::INFINITY));
    has_direction.select3(vector * scale, Vec3x8::ZERO)
}

/// A vector turned in the plane of x and y, by degrees against the clock.
fn rotated(vector: Vec3x8, degrees: F32x8) -> Vec3x8 {
    let radians = degrees.each(f32::to_radians);
    let (sin, cos) = (radians.each(f32::sin), radians.each(f32::cos));
    let Vec3x8 { x, y, z } = vector;
    Vec3x8::from([cos * x - sin * y, sin * x + cos * y, z])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::each_lane;

    #[test]
    fn lanes_are_those_of_one_place() {
        for standard in ALL {
            for (output, channels) in (0..3).flat_map(|output| (1..=3).map(move |count| (output, count))) {
                let asked = Asked { output, channels };
                each_lane::check(&*standard.asked(asked), standard.inputs.len());
            }
        }
    }
}
