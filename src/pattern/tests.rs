//! All patterns beside what Cycles of Blender gives: `beside_blender.csv`, which
//! `integrations/blender/scripts/patterns.py` writes.

use std::collections::BTreeMap;

use glam::Vec3;

use super::Dimensions;
use super::brick::{Brick, BrickInputs};
use super::checker::{Checker, CheckerInputs};
use super::fractal::{FractalKind, Noise, NoiseInputs};
use super::gabor::{Gabor, GaborInputs};
use super::gradient::Gradient;
use super::magic::{Magic, MagicInputs};
use super::voronoi::{Voronoi, VoronoiFeature, VoronoiInputs, VoronoiMetric};
use super::wave::{Wave, WaveInputs, WaveProfile, WaveShape};
use super::white::WhiteNoise;
use crate::lanes::{F32x8, Vec3x8};

/// The largest difference that passes, of numbers up to 1; a share of larger ones.
const TOLERANCE: f32 = 1e-4;

/// A line of the fixture.
struct Case<'a> {
    node: &'a str,
    options: Vec<&'a str>,
    vector: Vec3,
    w: f32,
    inputs: Vec<f32>,
    outputs: Vec<f32>,
}

impl<'a> Case<'a> {
    fn parse(line: &'a str) -> Self {
        let columns: Vec<&str> = line.split(',').collect();
        let numbers = |column: usize| -> Vec<f32> {
            columns[column].split_whitespace().map(|word| word.parse().expect("a number")).collect()
        };
        let place = numbers(2);
        Self {
            node: columns[0],
            options: columns[1].split_whitespace().collect(),
            vector: Vec3::from_slice(&place),
            w: place[3],
            inputs: numbers(3),
            outputs: numbers(4),
        }
    }

    fn dimensions(&self) -> Dimensions {
        match self.options[0] {
            "1D" => Dimensions::One,
            "2D" => Dimensions::Two,
            "3D" => Dimensions::Three,
            _ => Dimensions::Four,
        }
    }

    fn number<T: std::str::FromStr>(&self, option: usize) -> T {
        self.options[option].parse().ok().expect("a number")
    }

    /// The place, in all lanes.
    fn place(&self) -> (Vec3x8, F32x8) {
        (Vec3x8::splat(self.vector), F32x8::splat(self.w))
    }

    /// The inputs, in all lanes.
    fn eight(&self) -> Vec<F32x8> {
        self.inputs.iter().copied().map(F32x8::splat).collect()
    }

    /// Our outputs.
    fn ours(&self) -> Vec<f32> {
        match self.node {
            "Noise" => self.noise(),
            "Voronoi" => self.voronoi(),
            "Wave" => self.wave(),
            "Magic" => self.magic(),
            "Brick" => self.brick(),
            "Checker" => self.checker(),
            "Gradient" => vec![self.gradient().value(self.place().0).lane(0)],
            "WhiteNoise" => {
                let noise = WhiteNoise { dimensions: self.dimensions() };
                let (vector, w) = self.place();
                with_color(noise.value(vector, w).lane(0), noise.color(vector, w).lane(0))
            }
            "Gabor" => self.gabor(),
            other => panic!("no pattern {other}"),
        }
    }

    fn noise(&self) -> Vec<f32> {
        let noise = Noise {
            dimensions: self.dimensions(),
            kind: match self.options[1] {
                "FBM" => FractalKind::Fbm,
                "MULTIFRACTAL" => FractalKind::Multifractal,
                "HYBRID_MULTIFRACTAL" => FractalKind::HybridMultifractal,
                "RIDGED_MULTIFRACTAL" => FractalKind::RidgedMultifractal,
                _ => FractalKind::HeteroTerrain,
            },
            is_normalized: self.options[2] == "True",
        };
        let [scale, detail, roughness, lacunarity, offset, gain, distortion] = self.eight()[..] else {
            panic!("inputs of noise");
        };
        let inputs = NoiseInputs { scale, detail, roughness, lacunarity, offset, gain, distortion };
        let (vector, w) = self.place();
        let value = noise.value(vector, w, &inputs, 1).lane(0);
        with_color(value, noise.color(vector, w, &inputs, 8).lane(7))
    }

    fn voronoi(&self) -> Vec<f32> {
        let voronoi = Voronoi {
            dimensions: self.dimensions(),
            feature: match self.options[1] {
                "F1" => VoronoiFeature::F1,
                "F2" => VoronoiFeature::F2,
                "SMOOTH_F1" => VoronoiFeature::SmoothF1,
                "DISTANCE_TO_EDGE" => VoronoiFeature::DistanceToEdge,
                _ => VoronoiFeature::NSphereRadius,
            },
            metric: match self.options[2] {
                "EUCLIDEAN" => VoronoiMetric::Euclidean,
                "MANHATTAN" => VoronoiMetric::Manhattan,
                "CHEBYCHEV" => VoronoiMetric::Chebychev,
                _ => VoronoiMetric::Minkowski,
            },
            is_normalized: self.options[3] == "True",
        };
        let [scale, detail, roughness, lacunarity, smoothness, exponent, randomness] = self.eight()[..]
        else {
            panic!("inputs of Voronoi");
        };
        let inputs = VoronoiInputs { scale, detail, roughness, lacunarity, smoothness, exponent, randomness };
        let (vector, w) = self.place();
        let found = voronoi.outputs(vector, w, &inputs, 1);
        let numbers = [found.distance, found.w, found.radius].map(|number| number.lane(0));
        [numbers, found.color.lane(0).to_array(), found.position.lane(0).to_array()].concat()
    }

    fn wave(&self) -> Vec<f32> {
        let shape = match (self.options[0], self.options[1]) {
            ("BANDS", "X") => WaveShape::BandsX,
            ("BANDS", "Y") => WaveShape::BandsY,
            ("BANDS", "Z") => WaveShape::BandsZ,
            ("BANDS", _) => WaveShape::BandsDiagonal,
            (_, "X") => WaveShape::RingsX,
            (_, "Y") => WaveShape::RingsY,
            (_, "Z") => WaveShape::RingsZ,
            _ => WaveShape::RingsSpherical,
        };
        let profile = match self.options[2] {
            "SIN" => WaveProfile::Sine,
            "SAW" => WaveProfile::Saw,
            _ => WaveProfile::Triangle,
        };
        let [scale, distortion, detail, detail_scale, detail_roughness, phase_offset] = self.eight()[..]
        else {
            panic!("inputs of waves");
        };
        let inputs = WaveInputs { scale, distortion, detail, detail_scale, detail_roughness, phase_offset };
        vec![Wave { shape, profile }.value(self.place().0, &inputs, 1).lane(0)]
    }

    fn magic(&self) -> Vec<f32> {
        let magic = Magic { depth: self.number(0) };
        let inputs = MagicInputs { scale: self.inputs[0], distortion: self.inputs[1] };
        with_color(magic.value(self.vector, &inputs), magic.color(self.vector, &inputs))
    }

    fn brick(&self) -> Vec<f32> {
        let brick = Brick {
            offset: self.number(0),
            offset_frequency: self.number(1),
            squash: self.number(2),
            squash_frequency: self.number(3),
        };
        let [scale, mortar_size, mortar_smooth, bias, brick_width, row_height] = self.eight()[..] else {
            panic!("inputs of bricks");
        };
        let [color1, color2] = colors().map(Vec3x8::splat);
        let mortar = Vec3x8::splat(Vec3::new(0.375, 0.3125, 0.25));
        let inputs = BrickInputs {
            color1,
            color2,
            mortar,
            scale,
            mortar_size,
            mortar_smooth,
            bias,
            brick_width,
            row_height,
        };
        let vector = self.place().0;
        with_color(brick.value(vector, &inputs).lane(0), brick.color(vector, &inputs).lane(0))
    }

    fn checker(&self) -> Vec<f32> {
        let [color1, color2] = colors().map(Vec3x8::splat);
        let inputs = CheckerInputs { color1, color2, scale: self.eight()[0] };
        let vector = self.place().0;
        with_color(Checker.value(vector, &inputs).lane(0), Checker.color(vector, &inputs).lane(0))
    }

    fn gradient(&self) -> Gradient {
        match self.options[0] {
            "LINEAR" => Gradient::Linear,
            "QUADRATIC" => Gradient::Quadratic,
            "EASING" => Gradient::Easing,
            "DIAGONAL" => Gradient::Diagonal,
            "SPHERICAL" => Gradient::Spherical,
            "QUADRATIC_SPHERE" => Gradient::QuadraticSphere,
            _ => Gradient::Radial,
        }
    }

    fn gabor(&self) -> Vec<f32> {
        let gabor = if self.options[0] == "2D" { Gabor::Flat } else { Gabor::Solid };
        let inputs = GaborInputs {
            scale: self.inputs[0],
            frequency: self.inputs[1],
            anisotropy: self.inputs[2],
            orientation_2d: self.inputs[3],
            orientation_3d: Vec3::from_slice(&self.inputs[4..]),
        };
        let found = gabor.outputs(self.vector, &inputs);
        vec![found.value, found.phase, found.intensity]
    }
}

/// The two colours that the script gives to nodes with colours.
fn colors() -> [Vec3; 2] {
    [Vec3::new(0.8, 0.25, 0.125), Vec3::new(0.0625, 0.5, 0.75)]
}

fn with_color(value: f32, color: Vec3) -> Vec<f32> {
    vec![value, color.x, color.y, color.z]
}

#[test]
fn patterns_are_those_of_cycles() {
    let mut largest = BTreeMap::<&str, f32>::new();
    let mut wrong = Vec::new();
    for line in include_str!("beside_blender.csv").lines() {
        let case = Case::parse(line);
        let ours = case.ours();
        assert_eq!(ours.len(), case.outputs.len(), "{line}");
        let difference = |(our, theirs): (&f32, &f32)| (our - theirs).abs() / theirs.abs().max(1.0);
        let most = ours.iter().zip(&case.outputs).map(difference).fold(0.0, f32::max);
        let entry = largest.entry(case.node).or_default();
        *entry = entry.max(most);
        if most.is_nan() || most > TOLERANCE {
            wrong.push(format!("{most:.1e} {line}\n    ours: {ours:?}"));
        }
    }
    println!("largest differences: {largest:?}");
    assert!(wrong.is_empty(), "{} differ; largest: {largest:?}\n{}", wrong.len(), wrong.join("\n"));
}
