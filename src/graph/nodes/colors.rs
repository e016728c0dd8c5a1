//! Blender's nodes of colours: Hue/Saturation/Value, Brightness/Contrast, Gamma, Invert, RGB to BW, Separate and Combine Color, Color
//! Ramp, curves, Blackbody, Wavelength.

use std::sync::Arc;

use crate::graph::functions::color::{self, Adjustment, Model};
use crate::graph::functions::curve::{self, SAMPLES, Table};
use crate::graph::functions::ramp::{Interpolation, Mode, Ramp, Stop};
use crate::graph::functions::spectrum;
use crate::graph::{Definition, Function, Kind, Options, Socket, function, lane_by_lane};
use crate::lanes::{F32x8, Vec3x8};

type Made = Result<Arc<dyn Function>, String>;

const COLOR: Socket = Socket::color("color", [0.8; 3]);

/// Hue/Saturation/Value.
pub static HUE_SATURATION: Definition = Definition {
    name: "blender_hue_saturation",
    inputs: &[
        Socket::number("hue", 0.5),
        Socket::number("saturation", 1.0),
        Socket::number("value", 1.0),
        Socket::number("factor", 1.0),
        COLOR,
    ],
    outputs: &[("out", Kind::Color)],
    function: |_, _| {
        Ok(function(String::from("hue saturation"), |a, _| {
            let adjustment = Adjustment { hue: a[0].x, saturation: a[1].x, value: a[2].x, factor: a[3].x };
            adjustment.apply(a[4])
        }))
    },
};

/// Brightness/Contrast.
pub static BRIGHT_CONTRAST: Definition = Definition {
    name: "blender_bright_contrast",
    inputs: &[COLOR, Socket::number("bright", 0.0), Socket::number("contrast", 0.0)],
    outputs: &[("out", Kind::Color)],
    function: |_, _| {
        Ok(function(String::from("bright contrast"), |a, _| color::brightness_contrast(a[0], a[1].x, a[2].x)))
    },
};

/// Gamma.
pub static GAMMA: Definition = Definition {
    name: "blender_gamma",
    inputs: &[COLOR, Socket::number("gamma", 1.0)],
    outputs: &[("out", Kind::Color)],
    function: |_, _| Ok(function(String::from("gamma"), |a, _| color::gamma(a[0], a[1].x))),
};

/// Invert.
pub static INVERT: Definition = Definition {
    name: "blender_invert",
    inputs: &[Socket::number("factor", 1.0), COLOR],
    outputs: &[("out", Kind::Color)],
    function: |_, _| Ok(function(String::from("invert"), |a, _| color::invert(a[0].x, a[1]))),
};

/// RGB to BW.
pub static LUMINANCE: Definition = Definition {
    name: "blender_rgb_to_bw",
    inputs: &[COLOR],
    outputs: &[("out", Kind::Number)],
    function: |_, _| Ok(function(String::from("luma"), |a, _| Vec3x8::all_of(color::luma(a[0])))),
};

/// Separate Color. Option: `mode`.
pub static SEPARATE: Definition = Definition {
    name: "blender_separate_color",
    inputs: &[COLOR],
    outputs: &[("red", Kind::Number), ("green", Kind::Number), ("blue", Kind::Number)],
    function: |options, output| {
        let (model, channel) = (options.one_of("mode", Model::Rgb, Model::named)?, output.min(2));
        Ok(function(format!("separate {model:?} {channel}"), move |a, _| {
            Vec3x8::all_of(<[F32x8; 3]>::from(model.separate(a[0]))[channel])
        }))
    },
};

/// Combine Color. Option: `mode`.
pub static COMBINE: Definition = Definition {
    name: "blender_combine_color",
    inputs: &[Socket::number("red", 0.0), Socket::number("green", 0.0), Socket::number("blue", 0.0)],
    outputs: &[("out", Kind::Color)],
    function: |options, _| {
        let model = options.one_of("mode", Model::Rgb, Model::named)?;
        Ok(function(format!("combine {model:?}"), move |a, _| {
            model.combine(Vec3x8::from([a[0].x, a[1].x, a[2].x]))
        }))
    },
};

/// Color Ramp. Options: `mode`, `hue`, `interpolation`, and `stops`: five numbers each, the position, and linear RGB with alpha.
pub static RAMP: Definition = Definition {
    name: "blender_color_ramp",
    inputs: &[Socket::number("factor", 0.5)],
    outputs: &[("out", Kind::Color), ("alpha", Kind::Number)],
    function: ramp,
};

/// RGB Curves, with their combined curve in each. Options: `from`, `to`, `extrapolate`, and `red`, `green`, `blue`: 257 samples each.
pub static RGB_CURVES: Definition = Definition {
    name: "blender_rgb_curves",
    inputs: &[Socket::number("factor", 1.0), COLOR],
    outputs: &[("out", Kind::Color)],
    function: |options, _| curves(options, ["red", "green", "blue"]),
};

/// Vector Curves. Options: `from`, `to`, `extrapolate`, and `x`, `y`, `z`: 257 samples each.
pub static VECTOR_CURVES: Definition = Definition {
    name: "blender_vector_curves",
    inputs: &[Socket::number("factor", 1.0), Socket::vector("vector", [0.0; 3])],
    outputs: &[("out", Kind::Vector)],
    function: |options, _| curves(options, ["x", "y", "z"]),
};

/// Float Curve. Options: `from`, `to`, `extrapolate`, and `values`: 257 samples.
pub static FLOAT_CURVE: Definition = Definition {
    name: "blender_float_curve",
    inputs: &[Socket::number("factor", 1.0), Socket::number("value", 1.0)],
    outputs: &[("out", Kind::Number)],
    function: |options, _| {
        let table = table(options, "values")?;
        Ok(function(format!("float curve {table:?}"), move |a, _| {
            Vec3x8::all_of(curve::float(a[0].x, a[1].x, &table))
        }))
    },
};

/// Blackbody.
pub static BLACKBODY: Definition = Definition {
    name: "blender_blackbody",
    inputs: &[Socket::number("temperature", 1500.0)],
    outputs: &[("out", Kind::Color)],
    function: |_, _| Ok(lane_by_lane(String::from("blackbody"), |a| spectrum::blackbody(a[0].x))),
};

/// Wavelength.
pub static WAVELENGTH: Definition = Definition {
    name: "blender_wavelength",
    inputs: &[Socket::number("wavelength", 500.0)],
    outputs: &[("out", Kind::Color)],
    function: |_, _| Ok(lane_by_lane(String::from("wavelength"), |a| spectrum::wavelength(a[0].x))),
};

fn ramp(options: &Options, output: usize) -> Made {
    let numbers = options.numbers("stops")?;
    let stop = |five: &[f32]| Stop { position: five[0], color: [five[1], five[2], five[3], five[4]] };
    let stops: Vec<Stop> = numbers.chunks_exact(5).map(stop).collect();
    if stops.is_empty() || numbers.len() % 5 != 0 {
        return Err(String::from(
            "`stops` has five numbers for each stop: its position, red, green, blue and alpha",
        ));
    }
    let interpolation = options.one_of("interpolation", Interpolation::Linear, Interpolation::named)?;
    let hue = options.text("hue").unwrap_or("near");
    let mode = options.one_of("mode", Mode::Rgb, |mode| Mode::named(mode, hue))?;
    let ramp = Ramp::new(stops, interpolation, mode);
    let name = format!("ramp {interpolation:?} {mode:?} {numbers:?} {output}");
    Ok(function(name, move |a, _| {
        let [red, green, blue, alpha] = ramp.value(a[0].x);
        if output == 0 { Vec3x8::from([red, green, blue]) } else { Vec3x8::all_of(alpha) }
    }))
}

fn curves(options: &Options, names: [&str; 3]) -> Made {
    let [x, y, z] = names.map(|name| table(options, name));
    let tables = [x?, y?, z?];
    Ok(function(format!("curves {tables:?}"), move |a, _| curve::channels(a[0].x, a[1], &tables)))
}

/// Curve whose samples the option `key` has.
fn table(options: &Options, key: &str) -> Result<Table, String> {
    let values = options.numbers(key)?;
    if values.len() != SAMPLES {
        return Err(format!("`{key}` has {} samples: a curve has {SAMPLES}", values.len()));
    }
    let end = |key: &str, default: f32| {
        Ok::<f32, String>(options.numbers(key)?.first().copied().unwrap_or(default))
    };
    Ok(Table {
        from: end("from", 0.0)?,
        to: end("to", 1.0)?,
        values,
        extrapolate: options.flag("extrapolate", false)?,
    })
}
