//! Blender's texture nodes: see [`pattern`](crate::pattern).

use std::sync::Arc;

use glam::Vec3;

use crate::graph::{Definition, Function, Kind, Options, Socket, first_part, function, lane_by_lane};
use crate::lanes::Vec3x8;
use crate::pattern::Dimensions;
use crate::pattern::brick::{Brick, BrickInputs};
use crate::pattern::checker::{Checker, CheckerInputs};
use crate::pattern::fractal::{FractalKind, Noise, NoiseInputs};
use crate::pattern::gabor::{Gabor, GaborInputs};
use crate::pattern::gradient::Gradient;
use crate::pattern::magic::{Magic, MagicInputs};
use crate::pattern::voronoi::{Voronoi, VoronoiFeature, VoronoiInputs, VoronoiMetric};
use crate::pattern::wave::{Wave, WaveInputs, WaveProfile, WaveShape};
use crate::pattern::white::WhiteNoise;

type Made = Result<Arc<dyn Function>, String>;

const VECTOR: Socket = Socket::vector("vector", [0.0; 3]);
const W: Socket = Socket::number("w", 0.0);
const SCALE: Socket = Socket::number("scale", 5.0);

/// Outputs of textures that give a number and a colour.
const NUMBER_AND_COLOR: &[(&str, Kind)] = &[("value", Kind::Number), ("color", Kind::Color)];

/// Noise Texture. Options: `dimensions`, `kind`, `normalize`.
pub static NOISE: Definition = Definition {
    name: "blender_noise",
    inputs: &[
        VECTOR,
        W,
        SCALE,
        Socket::number("detail", 2.0),
        Socket::number("roughness", 0.5),
        Socket::number("lacunarity", 2.0),
        Socket::number("offset", 0.0),
        Socket::number("gain", 1.0),
        Socket::number("distortion", 0.0),
    ],
    outputs: NUMBER_AND_COLOR,
    function: noise,
};

/// Voronoi Texture. Options: `dimensions`, `feature`, `distance`, `normalize`.
pub static VORONOI: Definition = Definition {
    name: "blender_voronoi",
    inputs: &[
        VECTOR,
        W,
        SCALE,
        Socket::number("detail", 0.0),
        Socket::number("roughness", 0.5),
        Socket::number("lacunarity", 2.0),
        Socket::number("smoothness", 1.0),
        Socket::number("exponent", 0.5),
        Socket::number("randomness", 1.0),
    ],
    outputs: &[
        ("distance", Kind::Number),
        ("color", Kind::Color),
        ("position", Kind::Vector),
        ("w", Kind::Number),
        ("radius", Kind::Number),
    ],
    function: voronoi,
};

/// Wave Texture. Options: `shape` (such as `bands_x` and `rings_spherical`), `profile`.
pub static WAVE: Definition = Definition {
    name: "blender_wave",
    inputs: &[
        VECTOR,
        SCALE,
        Socket::number("distortion", 0.0),
        Socket::number("detail", 2.0),
        Socket::number("detail_scale", 1.0),
        Socket::number("detail_roughness", 0.5),
        Socket::number("phase_offset", 0.0),
    ],
    outputs: NUMBER_AND_COLOR,
    function: wave,
};

/// Magic Texture. Option: `depth`.
pub static MAGIC: Definition = Definition {
    name: "blender_magic",
    inputs: &[VECTOR, SCALE, Socket::number("distortion", 1.0)],
    outputs: NUMBER_AND_COLOR,
    function: |options, output| {
        let depth = options.numbers("depth")?.first().copied().unwrap_or(2.0).clamp(0.0, 10.0) as u32;
        Ok(lane_by_lane(format!("magic {depth} {output}"), move |a| {
            let (magic, inputs) = (Magic { depth }, MagicInputs { scale: a[1].x, distortion: a[2].x });
            if output == 0 { Vec3::splat(magic.value(a[0], &inputs)) } else { magic.color(a[0], &inputs) }
        }))
    },
};

/// Checker Texture.
pub static CHECKER: Definition = Definition {
    name: "blender_checker",
    inputs: &[VECTOR, Socket::color("color1", [0.8; 3]), Socket::color("color2", [0.2; 3]), SCALE],
    outputs: NUMBER_AND_COLOR,
    function: |_, output| {
        Ok(function(format!("checker {output}"), move |a, _| {
            let inputs = CheckerInputs { color1: a[1], color2: a[2], scale: a[3].x };
            match output {
                0 => Vec3x8::all_of(Checker.value(a[0], &inputs)),
                _ => Checker.color(a[0], &inputs),
            }
        }))
    },
};

/// Brick Texture. Options: `offset`, `offset_frequency`, `squash`, `squash_frequency`.
pub static BRICK: Definition = Definition {
    name: "blender_brick",
    inputs: &[
        VECTOR,
        Socket::color("color1", [0.8; 3]),
        Socket::color("color2", [0.2; 3]),
        Socket::color("mortar", [0.0; 3]),
        SCALE,
        Socket::number("mortar_size", 0.02),
        Socket::number("mortar_smooth", 0.1),
        Socket::number("bias", 0.0),
        Socket::number("brick_width", 0.5),
        Socket::number("row_height", 0.25),
    ],
    outputs: NUMBER_AND_COLOR,
    function: brick,
};

/// Gradient Texture. Option: `kind`.
pub static GRADIENT: Definition = Definition {
    name: "blender_gradient",
    inputs: &[VECTOR],
    outputs: NUMBER_AND_COLOR,
    function: |options, _| {
        let gradient = options.one_of("kind", Gradient::Linear, |name| {
            Some(match name {
                "linear" => Gradient::Linear,
                "quadratic" => Gradient::Quadratic,
                "easing" => Gradient::Easing,
                "diagonal" => Gradient::Diagonal,
                "spherical" => Gradient::Spherical,
                "quadratic_sphere" => Gradient::QuadraticSphere,
                "radial" => Gradient::Radial,
                _ => return None,
            })
        })?;
        Ok(function(format!("gradient {gradient:?}"), move |a, _| Vec3x8::all_of(gradient.value(a[0]))))
    },
};

/// White Noise Texture. Option: `dimensions`.
pub static WHITE: Definition = Definition {
    name: "blender_white_noise",
    inputs: &[VECTOR, W],
    outputs: NUMBER_AND_COLOR,
    function: |options, output| {
        let noise = WhiteNoise { dimensions: dimensions(options)? };
        Ok(function(format!("{noise:?} {output}"), move |a, _| match output {
            0 => Vec3x8::all_of(noise.value(a[0], a[1].x)),
            _ => noise.color(a[0], a[1].x),
        }))
    },
};

/// Gabor Texture. Option: `kind` (`flat`: two dimensions; `solid`: three).
pub static GABOR: Definition = Definition {
    name: "blender_gabor",
    inputs: &[
        VECTOR,
        SCALE,
        Socket::number("frequency", 2.0),
        Socket::number("anisotropy", 1.0),
        Socket::number("orientation_2d", std::f32::consts::FRAC_PI_4),
        Socket::vector("orientation_3d", [std::f32::consts::SQRT_2, std::f32::consts::SQRT_2, 0.0]),
    ],
    outputs: &[("value", Kind::Number), ("phase", Kind::Number), ("intensity", Kind::Number)],
    function: |options, output| {
        let gabor = options.one_of("kind", Gabor::Flat, |name| match name {
            "flat" => Some(Gabor::Flat),
            "solid" => Some(Gabor::Solid),
            _ => None,
        })?;
        Ok(lane_by_lane(format!("gabor {gabor:?} {output}"), move |a| {
            let inputs = GaborInputs {
                scale: a[1].x,
                frequency: a[2].x,
                anisotropy: a[3].x,
                orientation_2d: a[4].x,
                orientation_3d: a[5],
            };
            let made = gabor.outputs(a[0], &inputs);
            Vec3::splat([made.value, made.phase, made.intensity][output.min(2)])
        }))
    },
};

fn dimensions(options: &Options) -> Result<Dimensions, String> {
    options.one_of("dimensions", Dimensions::Three, |name| match name {
        "1d" => Some(Dimensions::One),
        "2d" => Some(Dimensions::Two),
        "3d" => Some(Dimensions::Three),
        "4d" => Some(Dimensions::Four),
        _ => None,
    })
}

fn noise(options: &Options, output: usize) -> Made {
    let kind = options.one_of("kind", FractalKind::Fbm, |name| {
        Some(match name {
            "fbm" => FractalKind::Fbm,
            "multifractal" => FractalKind::Multifractal,
            "hybrid_multifractal" => FractalKind::HybridMultifractal,
            "ridged_multifractal" => FractalKind::RidgedMultifractal,
            "hetero_terrain" => FractalKind::HeteroTerrain,
            _ => return None,
        })
    })?;
    let is_normalized = options.flag("normalize", true)?;
    let noise = Noise { dimensions: dimensions(options)?, kind, is_normalized };
    let color = function(format!("{noise:?} color"), move |a, lanes| {
        noise.color(a[0], a[1].x, &noise_inputs(a), lanes)
    });
    if output == 1 {
        return Ok(color);
    }
    let value = function(format!("{noise:?}"), move |a, lanes| {
        Vec3x8::all_of(noise.value(a[0], a[1].x, &noise_inputs(a), lanes))
    });
    Ok(first_part(color, value))
}

fn noise_inputs(a: &[Vec3x8]) -> NoiseInputs {
    NoiseInputs {
        scale: a[2].x,
        detail: a[3].x,
        roughness: a[4].x,
        lacunarity: a[5].x,
        offset: a[6].x,
        gain: a[7].x,
        distortion: a[8].x,
    }
}

fn voronoi(options: &Options, output: usize) -> Made {
    let feature = options.one_of("feature", VoronoiFeature::F1, |name| {
        Some(match name {
            "f1" => VoronoiFeature::F1,
            "f2" => VoronoiFeature::F2,
            "smooth_f1" => VoronoiFeature::SmoothF1,
            "distance_to_edge" => VoronoiFeature::DistanceToEdge,
            "n_sphere_radius" => VoronoiFeature::NSphereRadius,
            _ => return None,
        })
    })?;
    let metric = options.one_of("distance", VoronoiMetric::Euclidean, |name| {
        Some(match name {
            "euclidean" => VoronoiMetric::Euclidean,
            "manhattan" => VoronoiMetric::Manhattan,
            "chebychev" => VoronoiMetric::Chebychev,
            "minkowski" => VoronoiMetric::Minkowski,
            _ => return None,
        })
    })?;
    let is_normalized = options.flag("normalize", false)?;
    let voronoi = Voronoi { dimensions: dimensions(options)?, feature, metric, is_normalized };
    Ok(function(format!("{voronoi:?} {output}"), move |a, lanes| {
        let inputs = VoronoiInputs {
            scale: a[2].x,
            detail: a[3].x,
            roughness: a[4].x,
            lacunarity: a[5].x,
            smoothness: a[6].x,
            exponent: a[7].x,
            randomness: a[8].x,
        };
        let made = voronoi.outputs(a[0], a[1].x, &inputs, lanes);
        match output {
            0 => Vec3x8::all_of(made.distance),
            1 => made.color,
            2 => made.position,
            3 => Vec3x8::all_of(made.w),
            _ => Vec3x8::all_of(made.radius),
        }
    }))
}

fn wave(options: &Options, _: usize) -> Made {
    let shape = options.one_of("shape", WaveShape::BandsX, |name| {
        Some(match name {
            "bands_x" => WaveShape::BandsX,
            "bands_y" => WaveShape::BandsY,
            "bands_z" => WaveShape::BandsZ,
            "bands_diagonal" => WaveShape::BandsDiagonal,
            "rings_x" => WaveShape::RingsX,
            "rings_y" => WaveShape::RingsY,
            "rings_z" => WaveShape::RingsZ,
            "rings_spherical" => WaveShape::RingsSpherical,
            _ => return None,
        })
    })?;
    let profile = options.one_of("profile", WaveProfile::Sine, |name| match name {
        "sin" => Some(WaveProfile::Sine),
        "saw" => Some(WaveProfile::Saw),
        "tri" => Some(WaveProfile::Triangle),
        _ => None,
    })?;
    let wave = Wave { shape, profile };
    Ok(function(format!("{wave:?}"), move |a, lanes| {
        let inputs = WaveInputs {
            scale: a[1].x,
            distortion: a[2].x,
            detail: a[3].x,
            detail_scale: a[4].x,
            detail_roughness: a[5].x,
            phase_offset: a[6].x,
        };
        Vec3x8::all_of(wave.value(a[0], &inputs, lanes))
    }))
}

fn brick(options: &Options, output: usize) -> Made {
    let number = |key: &str, default: f32| {
        Ok::<f32, String>(options.numbers(key)?.first().copied().unwrap_or(default))
    };
    let brick = Brick {
        offset: number("offset", 0.5)?,
        offset_frequency: number("offset_frequency", 2.0)?.max(0.0) as u32,
        squash: number("squash", 1.0)?,
        squash_frequency: number("squash_frequency", 2.0)?.max(0.0) as u32,
    };
    Ok(function(format!("{brick:?} {output}"), move |a, _| {
        let inputs = BrickInputs {
            color1: a[1],
            color2: a[2],
            mortar: a[3],
            scale: a[4].x,
            mortar_size: a[5].x,
            mortar_smooth: a[6].x,
            bias: a[7].x,
            brick_width: a[8].x,
            row_height: a[9].x,
        };
        match output {
            0 => Vec3x8::all_of(brick.value(a[0], &inputs)),
            _ => brick.color(a[0], &inputs),
        }
    }))
}
