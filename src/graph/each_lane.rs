//! Does each lane give what its place alone gives, whatever is in the others?

use std::array;
use std::collections::HashSet;

use glam::{Vec2, Vec3};

use super::functions::map_range::{Clamp, Progress};
use super::functions::math::Math;
use super::functions::mix::Blend;
use super::functions::ramp::Interpolation;
use super::functions::vector::{Mapping, Rotate};
use super::functions::vector_math::VectorMath;
use super::nodes::{self, hextile, picture};
use super::{Function, Graph, Input, Kind, Options, Place, Places, Program, UvSet};
use crate::lanes::{LANES, Vec3x8};

/// A place that can be told from others.
struct Spot(f32);

impl Place for Spot {
    fn uv(&self, _: UvSet) -> Vec2 {
        Vec2::new(self.0, 0.5)
    }

    fn point(&self) -> Vec3 {
        Vec3::new(self.0, 1.5, -self.0 * 0.3)
    }

    fn generated(&self) -> Vec3 {
        self.point() * 0.25
    }

    fn world_point(&self) -> Vec3 {
        self.point() + 1.0
    }

    fn world_normal(&self) -> Vec3 {
        self.point().normalize()
    }

    fn normal(&self) -> Vec3 {
        self.point().normalize()
    }

    fn model_place(&self) -> Vec3 {
        Vec3::splat(2.0 - self.0)
    }

    fn model_random(&self) -> f32 {
        self.0 * 0.1
    }

    fn vertex_color(&self) -> Vec3 {
        Vec3::splat(self.0)
    }

    fn facing(&self) -> f32 {
        self.0.sin()
    }

    fn picture(&self, number: u32, at: Option<Vec2>) -> [f32; 4] {
        [self.0, number as f32, at.map_or(-1.0, |at| at.x), 0.5]
    }
}

/// Random numbers, the same in each run.
struct Chance(u64);

impl Chance {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end
    }

    /// A plain number, mostly.
    fn number(&mut self) -> f32 {
        const ODD: [f32; 16] = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            0.5,
            2.0,
            1e-40,
            1e5,
            -2e6,
            3e9,
            1e30,
            f32::MAX,
            f32::MIN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NAN,
        ];
        match self.below(5) {
            0 => ODD[self.below(ODD.len())],
            1 => self.below(9) as f32 / 4.0,
            _ => self.below(1 << 20) as f32 / 65_536.0 - 8.0,
        }
    }

    /// A number three times, or three.
    fn value(&mut self) -> Vec3 {
        match self.below(2) {
            0 => Vec3::splat(self.number()),
            _ => Vec3::new(self.number(), self.number(), self.number()),
        }
    }

    /// The values of eight lanes, which are often alike.
    fn eight(&mut self) -> [Vec3; LANES] {
        match self.below(2) {
            0 => [self.value(); LANES],
            _ => array::from_fn(|_| self.value()),
        }
    }
}

fn of_lanes(values: [Vec3; LANES]) -> Vec3x8 {
    let mut eight = Vec3x8::ZERO;
    values.into_iter().enumerate().for_each(|(lane, value)| eight.set_lane(lane, value));
    eight
}

fn bits(value: Vec3) -> [u32; 3] {
    value.to_array().map(f32::to_bits)
}

/// Fails if a lane of a function with so many inputs gives something else than the same lane alone, with other things beside it.
pub fn check(function: &dyn Function, inputs: usize) {
    let spots: [Spot; LANES] = array::from_fn(|lane| Spot(lane as f32 * 0.37 - 1.1));
    let places = spots.each_ref().map(|spot| spot as &dyn Place);
    let mut chance = Chance(inputs as u64);
    for lanes in [1, 2, 3, 4, 5, 8, 8, 8] {
        let values: Vec<[Vec3; LANES]> = (0..inputs).map(|_| chance.eight()).collect();
        let eight: Vec<Vec3x8> = values.iter().map(|values| of_lanes(*values)).collect();
        let together = function.values(&eight, Places::new(&places[..lanes])).finite_or_zero();
        for lane in 0..lanes {
            let beside = |values: &[Vec3; LANES]| {
                let others: [Vec3; LANES] = array::from_fn(|_| chance.value());
                of_lanes(array::from_fn(|at| if at == 0 { values[lane] } else { others[at] }))
            };
            let alone: Vec<Vec3x8> = values.iter().map(beside).collect();
            let alone = function.values(&alone, Places::new(&[places[lane]])).finite_or_zero();
            assert_eq!(
                bits(together.lane(lane)),
                bits(alone.lane(0)),
                "{function:?}, lane {lane} of {lanes}: {} beside others, {} alone, of {:?}",
                together.lane(lane),
                alone.lane(0),
                values.iter().map(|values| values[lane]).collect::<Vec<_>>()
            );
        }
    }
}

/// What a file may state of a node.
type Stated = Vec<(&'static str, String)>;

/// Options one at a time, each with all numbers of dimensions, and what ramps and curves need.
fn stated() -> Vec<Stated> {
    let curve: String = (0..257).map(|sample| format!("{} ", (sample as f32 * 0.1).sin())).collect();
    let stops = String::from("0 0.1 0.2 0.3 1 0.4 0.9 0.1 0.5 0.5 0.8 0.3 0.7 1.5 1");
    let curves = ["values", "red", "green", "blue", "x", "y", "z"].map(|key| (key, curve.clone()));
    let needed: Stated =
        curves.into_iter().chain([("stops", stops), ("from", String::from("-0.5"))]).collect();
    let with = |options: [(&'static str, String); 2]| needed.iter().cloned().chain(options).collect();
    let one = |option: (&'static str, String)| {
        ["1d", "2d", "3d", "4d"]
            .map(|dimensions| with([option.clone(), ("dimensions", dimensions.to_string())]))
    };
    options().into_iter().flat_map(one).collect()
}

fn options() -> Stated {
    let mut all = Vec::new();
    let mut add = |key, names: Vec<&str>| all.extend(names.into_iter().map(|name| (key, name.to_string())));
    add("feature", vec!["f1", "f2", "smooth_f1", "distance_to_edge", "n_sphere_radius"]);
    add("distance", vec!["manhattan", "chebychev", "minkowski"]);
    add("kind", vec!["fbm", "multifractal", "hybrid_multifractal", "ridged_multifractal", "hetero_terrain"]);
    add("kind", vec!["linear", "quadratic", "easing", "diagonal", "spherical", "quadratic_sphere", "radial"]);
    add("kind", vec!["flat", "solid"]);
    add("kind", Clamp::ALL.iter().map(|of| of.name()).collect());
    add("kind", Mapping::ALL.iter().map(|of| of.name()).collect());
    add("kind", Rotate::ALL.iter().map(|of| of.name()).collect());
    add("shape", vec!["bands_x", "bands_y", "bands_z", "bands_diagonal"]);
    add("shape", vec!["rings_x", "rings_y", "rings_z", "rings_spherical"]);
    add("profile", vec!["sin", "saw", "tri"]);
    add("mode", vec!["rgb", "hsv", "hsl"]);
    add("set", vec!["0", "1"]);
    for key in ["normalize", "clamp", "clamp_factor", "clamp_result", "invert", "extrapolate"] {
        add(key, vec!["true", "false"]);
    }
    for key in ["offset_frequency", "squash_frequency", "depth"] {
        add(key, vec!["0", "1", "3"]);
    }
    add("operation", Math::ALL.iter().map(|of| of.name()).collect());
    add("operation", VectorMath::ALL.iter().map(|of| of.name()).collect());
    add("blend", Blend::ALL.iter().map(|of| of.name()).collect());
    add("interpolation", Progress::ALL.iter().map(|of| of.name()).collect());
    add("interpolation", Interpolation::ALL.iter().map(|of| of.name()).collect());
    all
}

#[test]
fn lanes_of_all_kinds_of_nodes_are_those_of_one_place() {
    let stated = stated();
    for definition in nodes::ALL {
        let mut seen = HashSet::new();
        for stated in &stated {
            let mut options = Options::default();
            stated.iter().for_each(|(key, text)| options.set(key, text));
            for output in 0..definition.outputs.len() {
                let Ok(function) = (definition.function)(&options, output) else { continue };
                if seen.insert(format!("{function:?}")) {
                    check(&*function, definition.inputs.len());
                }
            }
        }
        assert!(!seen.is_empty(), "{}", definition.name);
    }
}

#[test]
fn lanes_of_pictures_and_conversions_are_those_of_one_place() {
    let mut graph = Graph::default();
    let point = graph.add_defined(&nodes::inputs::POINT, &Options::default(), &[], 0).expect("it takes none");
    for shown in
        [picture::Shown::Color, picture::Shown::Mean, picture::Shown::Channel(1), picture::Shown::Alpha]
    {
        picture::add(&mut graph, 3, shown, None);
        picture::add(&mut graph, 3, shown, Some(point));
    }
    hextile::add(&mut graph, 3, point, hextile::INPUTS.map(|_| point));
    graph.converted(point, Kind::Color, Kind::Number);
    graph.converted(point, Kind::Vector, Kind::Number);
    for node in &graph.nodes {
        check(&*node.function, node.inputs.len());
    }
}

#[test]
fn programs_give_each_place_its_own_values() {
    let mut graph = Graph::default();
    let point = graph.add_defined(&nodes::inputs::POINT, &Options::default(), &[], 0).expect("it takes none");
    let input = [Some((point, Kind::Vector))];
    let of =
        |graph: &mut Graph, node| graph.add_defined(node, &Options::default(), &input, 1).expect("known");
    let [noise, cells] =
        [&nodes::patterns::NOISE, &nodes::patterns::VORONOI].map(|node| of(&mut graph, node));
    let program = Program::of_all(&graph, &[noise, cells, point, Input::Constant(Vec3::X)]);
    let spots: [Spot; LANES] = array::from_fn(|lane| Spot(lane as f32 * 0.71));
    let places = spots.each_ref().map(|spot| spot as &dyn Place);
    for lanes in 1..=LANES {
        let together = program.values(Places::new(&places[..lanes]));
        for lane in 0..lanes {
            let alone = program.values(Places::new(&places[lane..=lane]));
            for (together, alone) in together.iter().zip(&alone) {
                assert_eq!(bits(together.lane(lane)), bits(alone.lane(0)), "lane {lane} of {lanes}");
            }
            assert_eq!(bits(together[0].lane(lane)), bits(program.value(places[lane])));
        }
    }
    let no_place = program.values(Places::new(&[]));
    assert_eq!((no_place[2].lane(0), no_place[3].lane(0)), (Vec3::ZERO, Vec3::X));
    let more = [places, places].concat();
    assert_eq!(Places::new(&more).lanes(), LANES, "those beyond are left out");
}
