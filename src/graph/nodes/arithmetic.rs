//! Blender's nodes of numbers and vectors: Math, Vector Math, Mix, Clamp, Map Range, Mapping, Vector Rotate, Separate and Combine XYZ.

use std::sync::Arc;

use crate::graph::functions::map_range::{Clamp, Progress, Ranges};
use crate::graph::functions::math::Math;
use crate::graph::functions::mix::{self, Blend};
use crate::graph::functions::vector::{Mapping, Rotate, Turn};
use crate::graph::functions::vector_math::VectorMath;
use crate::graph::{Definition, Function, Kind, Options, Socket, function};
use crate::lanes::{F32x8, Vec3x8};

type Made = Result<Arc<dyn Function>, String>;

const ZERO: [f32; 3] = [0.0; 3];

/// Math. Options: `operation`, `clamp`.
pub static MATH: Definition = Definition {
    name: "blender_math",
    inputs: &[Socket::number("a", 0.5), Socket::number("b", 0.5), Socket::number("c", 0.5)],
    outputs: &[("out", Kind::Number)],
    function: math,
};

/// Vector Math. Option: `operation`. Outputs: the vector, the value.
pub static VECTOR_MATH: Definition = Definition {
    name: "blender_vector_math",
    inputs: &[
        Socket::vector("a", ZERO),
        Socket::vector("b", ZERO),
        Socket::vector("c", ZERO),
        Socket::number("scale", 1.0),
    ],
    outputs: &[("out", Kind::Vector), ("value", Kind::Number)],
    function: vector_math,
};

/// Mix of numbers. Options: `clamp_factor`.
pub static MIX_NUMBER: Definition = Definition {
    name: "blender_mix_float",
    inputs: &[Socket::number("factor", 0.5), Socket::number("a", 0.0), Socket::number("b", 0.0)],
    outputs: &[("out", Kind::Number)],
    function: |options, _| mix_uniform(options),
};

/// Mix of vectors. Options: `clamp_factor`, `non_uniform`.
pub static MIX_VECTOR: Definition = Definition {
    name: "blender_mix_vector",
    inputs: &[Socket::vector("factor", [0.5; 3]), Socket::vector("a", ZERO), Socket::vector("b", ZERO)],
    outputs: &[("out", Kind::Vector)],
    function: |options, _| mix_uniform(options),
};

/// Mix of colours. Options: `blend`, `clamp_factor`, `clamp_result`.
pub static MIX_COLOR: Definition = Definition {
    name: "blender_mix_color",
    inputs: &[Socket::number("factor", 0.5), Socket::color("a", [0.5; 3]), Socket::color("b", [0.5; 3])],
    outputs: &[("out", Kind::Color)],
    function: mix_color,
};

/// Clamp. Option: `kind`.
pub static CLAMP: Definition = Definition {
    name: "blender_clamp",
    inputs: &[Socket::number("value", 1.0), Socket::number("min", 0.0), Socket::number("max", 1.0)],
    outputs: &[("out", Kind::Number)],
    function: |options, _| {
        let clamp = options.one_of("kind", Clamp::MinMax, Clamp::named)?;
        Ok(function(format!("clamp {clamp:?}"), move |a, _| {
            Vec3x8::all_of(clamp.apply(a[0].x, a[1].x, a[2].x))
        }))
    },
};

/// Map Range of numbers. Options: `interpolation`, `clamp`.
pub static MAP_RANGE: Definition = Definition {
    name: "blender_map_range",
    inputs: &[
        Socket::number("value", 1.0),
        Socket::number("from_min", 0.0),
        Socket::number("from_max", 1.0),
        Socket::number("to_min", 0.0),
        Socket::number("to_max", 1.0),
        Socket::number("steps", 4.0),
    ],
    outputs: &[("out", Kind::Number)],
    function: |options, _| {
        let progress = options.one_of("interpolation", Progress::Linear, Progress::named)?;
        let clamps = options.flag("clamp", true)?;
        Ok(function(format!("map range {progress:?} {clamps}"), move |a, _| {
            let ranges = Ranges { from: [a[1].x, a[2].x], to: [a[3].x, a[4].x], steps: a[5].x };
            Vec3x8::all_of(ranges.map(progress, clamps, a[0].x))
        }))
    },
};

/// Map Range of vectors. Options: `interpolation`, `clamp`.
pub static MAP_RANGE_VECTOR: Definition = Definition {
    name: "blender_map_range_vector",
    inputs: &[
        Socket::vector("value", ZERO),
        Socket::vector("from_min", ZERO),
        Socket::vector("from_max", [1.0; 3]),
        Socket::vector("to_min", ZERO),
        Socket::vector("to_max", [1.0; 3]),
        Socket::vector("steps", [4.0; 3]),
    ],
    outputs: &[("out", Kind::Vector)],
    function: |options, _| {
        let progress = options.one_of("interpolation", Progress::Linear, Progress::named)?;
        let clamps = options.flag("clamp", true)?;
        Ok(function(format!("map range of vectors {progress:?} {clamps}"), move |a, _| {
            Ranges { from: [a[1], a[2]], to: [a[3], a[4]], steps: a[5] }.map(progress, clamps, a[0])
        }))
    },
};

/// Mapping. Option: `kind`.
pub static MAPPING: Definition = Definition {
    name: "blender_mapping",
    inputs: &[
        Socket::vector("vector", ZERO),
        Socket::vector("location", ZERO),
        Socket::vector("rotation", ZERO),
        Socket::vector("scale", [1.0; 3]),
    ],
    outputs: &[("out", Kind::Vector)],
    function: |options, _| {
        let kind = options.one_of("kind", Mapping::Point, Mapping::named)?;
        Ok(function(format!("mapping {kind:?}"), move |a, _| kind.apply(a[0], a[1], a[2], a[3])))
    },
};

/// Vector Rotate. Options: `kind`, `invert`.
pub static VECTOR_ROTATE: Definition = Definition {
    name: "blender_vector_rotate",
    inputs: &[
        Socket::vector("vector", ZERO),
        Socket::vector("center", ZERO),
        Socket::vector("axis", [0.0, 0.0, 1.0]),
        Socket::number("angle", 0.0),
        Socket::vector("rotation", ZERO),
    ],
    outputs: &[("out", Kind::Vector)],
    function: |options, _| {
        let kind = options.one_of("kind", Rotate::AxisAngle, Rotate::named)?;
        let invert = options.flag("invert", false)?;
        Ok(function(format!("vector rotate {kind:?} {invert}"), move |a, _| {
            kind.apply(a[0], a[1], &Turn { axis: a[2], angle: a[3].x, rotation: a[4], invert })
        }))
    },
};

/// Separate XYZ.
pub static SEPARATE_XYZ: Definition = Definition {
    name: "blender_separate_xyz",
    inputs: &[Socket::vector("vector", ZERO)],
    outputs: &[("x", Kind::Number), ("y", Kind::Number), ("z", Kind::Number)],
    function: |_, output| {
        let axis = output.min(2);
        Ok(function(format!("separate xyz {axis}"), move |a, _| {
            Vec3x8::all_of(<[F32x8; 3]>::from(a[0])[axis])
        }))
    },
};

/// Combine XYZ.
pub static COMBINE_XYZ: Definition = Definition {
    name: "blender_combine_xyz",
    inputs: &[Socket::number("x", 0.0), Socket::number("y", 0.0), Socket::number("z", 0.0)],
    outputs: &[("out", Kind::Vector)],
    function: |_, _| Ok(function(String::from("combine xyz"), |a, _| Vec3x8::from([a[0].x, a[1].x, a[2].x]))),
};

fn math(options: &Options, _: usize) -> Made {
    let operation = options.one_of("operation", Math::Add, Math::named)?;
    let clamps = options.flag("clamp", false)?;
    Ok(function(format!("math {operation:?} {clamps}"), move |a, _| {
        let value = operation.apply(a[0].x, a[1].x, a[2].x);
        Vec3x8::all_of(if clamps { value.clamp(0.0, 1.0) } else { value })
    }))
}

fn vector_math(options: &Options, output: usize) -> Made {
    let operation = options.one_of("operation", VectorMath::Add, VectorMath::named)?;
    Ok(match output {
        0 => function(format!("vector math {operation:?}"), move |a, _| {
            operation.vector(a[0], a[1], a[2], a[3].x)
        }),
        _ => function(format!("vector math {operation:?} value"), move |a, _| {
            Vec3x8::all_of(operation.value(a[0], a[1]))
        }),
    })
}

/// Mix of values that are three numbers each: the factor has one for each, too.
fn mix_uniform(options: &Options) -> Made {
    let clamps = options.flag("clamp_factor", true)?;
    Ok(function(format!("mix {clamps}"), move |a, _| {
        let factor = if clamps { clamped(a[0]) } else { a[0] };
        mix::vector_non_uniform(factor, a[1], a[2])
    }))
}

fn mix_color(options: &Options, _: usize) -> Made {
    let blend = options.one_of("blend", Blend::Mix, Blend::named)?;
    let [of_factor, of_result] = [options.flag("clamp_factor", true)?, options.flag("clamp_result", false)?];
    Ok(function(format!("mix of colours {blend:?} {of_factor} {of_result}"), move |a, _| {
        let factor = if of_factor { a[0].x.clamp(0.0, 1.0) } else { a[0].x };
        let mixed = blend.apply(factor, a[1], a[2]);
        if of_result { clamped(mixed) } else { mixed }
    }))
}

/// Each part from 0 to 1.
fn clamped(value: Vec3x8) -> Vec3x8 {
    value.each(|part| part.clamp(0.0, 1.0))
}
