//! Do programs compute what their graphs say, whatever is folded, merged, left out and kept in the same register?

use glam::{Vec2, Vec3};

use super::function::Place;
use super::nodes::{self, inputs};
use super::*;
use crate::lanes::Vec3x8;

/// A place at which everything is known.
struct Known;

impl Place for Known {
    fn uv(&self, set: UvSet) -> Vec2 {
        if set == UvSet::First { Vec2::new(0.25, 0.5) } else { Vec2::new(0.75, 1.0) }
    }

    fn point(&self) -> Vec3 {
        Vec3::new(1.0, 2.0, 3.0)
    }

    fn generated(&self) -> Vec3 {
        Vec3::splat(0.5)
    }

    fn world_point(&self) -> Vec3 {
        Vec3::splat(7.0)
    }

    fn world_normal(&self) -> Vec3 {
        Vec3::X
    }

    fn normal(&self) -> Vec3 {
        Vec3::Y
    }

    fn model_place(&self) -> Vec3 {
        Vec3::new(7.0, 8.0, 9.0)
    }

    fn model_random(&self) -> f32 {
        0.375
    }

    fn vertex_color(&self) -> Vec3 {
        Vec3::X
    }

    fn facing(&self) -> f32 {
        -0.25
    }

    fn picture(&self, number: u32, at: Option<Vec2>) -> [f32; 4] {
        [number as f32, at.map_or(-1.0, |at| at.x), 0.0, 0.5]
    }
}

fn source(graph: &mut Graph, definition: &Definition) -> Input {
    graph.add_defined(definition, &Options::default(), &[], 0).expect("it takes no options")
}

fn sum(graph: &mut Graph, a: Input, b: Input) -> Input {
    graph.add(function(String::from("sum"), |values, _| values[0] + values[1]), vec![a, b])
}

#[test]
fn what_depends_on_nothing_is_a_constant() {
    let mut graph = Graph::default();
    let two = sum(&mut graph, Input::Constant(Vec3::ONE), Input::Constant(Vec3::ONE));
    assert_eq!((two, graph.len()), (Input::Constant(Vec3::splat(2.0)), 0));
    let program = Program::new(&graph, two);
    assert!(program.is_empty());
    assert_eq!(program.value(&Known), Vec3::splat(2.0));
}

#[test]
fn equal_nodes_are_one_and_dead_ones_are_left_out() {
    let mut graph = Graph::default();
    let point = source(&mut graph, &inputs::POINT);
    let again = source(&mut graph, &inputs::POINT);
    assert_eq!(point, again);
    let [first, second] = [(); 2].map(|()| sum(&mut graph, point, point));
    assert_eq!(first, second);
    let other = sum(&mut graph, point, Input::Constant(Vec3::ZERO));
    assert_ne!(first, other);
    let negative = sum(&mut graph, point, Input::Constant(-Vec3::ZERO));
    assert_eq!(other, negative, "there is one zero");
    assert_eq!(Program::new(&graph, first).len(), 2, "the place, and its double");
    assert_eq!(Program::new(&graph, first).value(&Known), Vec3::new(2.0, 4.0, 6.0));
}

/// Evaluates a node and all that it takes anew, without registers.
fn plain_value(graph: &Graph, input: Input) -> Vec3 {
    match input {
        Input::Constant(value) => value,
        Input::Node(number) => {
            let node = &graph.nodes[number as usize];
            let values = node.inputs.iter().map(|input| Vec3x8::splat(plain_value(graph, *input)));
            let values: Vec<Vec3x8> = values.collect();
            node.function.values(&values, Places::new(&[&Known])).finite_or_zero().lane(0)
        }
    }
}

#[test]
fn registers_hold_what_is_needed_until_it_was_used() {
    // small graphs of all shapes, by numbers that look random
    let mut random = 1_u64;
    let mut below = |end: usize| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as usize % end
    };
    for _ in 0..300 {
        let mut graph = Graph::default();
        let mut all = vec![source(&mut graph, &inputs::POINT), source(&mut graph, &inputs::UV)];
        for step in 0..12 {
            let (a, b) = (all[below(all.len())], all[below(all.len())]);
            let weight = 0.5 + step as f32;
            let made = function(format!("{step}"), move |values, _| values[0] * weight - values[1]);
            all.push(graph.add(made, vec![a, b]));
        }
        for value in all {
            assert_eq!(Program::new(&graph, value).value(&Known), plain_value(&graph, value));
        }
    }
}

#[test]
fn values_that_are_computed_together_are_what_each_is_alone() {
    let mut graph = Graph::default();
    let [point, uv] = [&inputs::POINT, &inputs::UV].map(|definition| source(&mut graph, definition));
    let both = sum(&mut graph, point, uv);
    let all = [point, both, Input::Constant(Vec3::ONE)];
    let together = Program::of_all(&graph, &all);
    assert_eq!(together.len(), 3, "the place is asked once");
    let alone = all.map(|value| Program::new(&graph, value).value(&Known));
    let values = together.values(Places::new(&[&Known])).map(|value| value.lane(0));
    assert_eq!(values[..3], alone);
    assert_eq!(values[3], Vec3::ZERO);
}

#[test]
fn graphs_may_be_deep_and_wide() {
    let mut graph = Graph::default();
    let point = source(&mut graph, &inputs::POINT);
    let (mut deep, mut wide) = (point, Vec::new());
    for step in 0..10_000 {
        deep = sum(&mut graph, deep, Input::Constant(Vec3::ONE));
        let node = function(format!("step {step}"), move |values, _| values[0] + step as f32);
        wide.push(graph.add(node, vec![point]));
    }
    let program = Program::new(&graph, deep);
    assert_eq!((program.value(&Known).x, program.len()), (10_001.0, 10_001));
    let all = wide.into_iter().reduce(|a, b| sum(&mut graph, a, b)).expect("there are some");
    let expected: f32 = (0..10_000).map(|step| 1.0 + step as f32).sum();
    assert_eq!(Program::new(&graph, all).value(&Known).x, expected, "of as many values at once");
}

#[test]
fn no_value_is_infinite_or_none() {
    let mut graph = Graph::default();
    let point = source(&mut graph, &inputs::POINT);
    for (name, result) in [("nan", f32::NAN), ("infinity", f32::INFINITY), ("less", f32::NEG_INFINITY)] {
        let odd = graph
            .add(function(name.into(), move |_, _| Vec3x8::splat(Vec3::new(1.0, result, 2.0))), vec![point]);
        assert_eq!(Program::new(&graph, odd).value(&Known), Vec3::new(1.0, 0.0, 2.0), "{name}");
        let constant = graph.add(
            function(name.into(), move |_, _| Vec3x8::splat(Vec3::splat(result))),
            vec![Input::Constant(Vec3::ONE)],
        );
        assert_eq!(constant, Input::Constant(Vec3::ZERO), "{name}");
    }
}

#[test]
fn links_convert_values_as_blender_does() {
    let mut graph = Graph::default();
    let point = source(&mut graph, &inputs::POINT);
    let number = graph.converted(point, Kind::Vector, Kind::Number);
    assert_eq!(Program::new(&graph, number).value(&Known), Vec3::splat(2.0), "of a vector the mean");
    let red = Input::Constant(Vec3::X);
    let Input::Constant(luminance) = graph.converted(red, Kind::Color, Kind::Number) else {
        panic!("it is a constant")
    };
    assert!((luminance - 0.2126).abs().max_element() < 1e-4, "of a colour the luminance");
    assert_eq!(graph.converted(point, Kind::Vector, Kind::Color), point);
}

#[test]
fn sources_are_those_of_the_place() {
    let mut graph = Graph::default();
    let mut second = Options::default();
    second.set("set", "1");
    let second = graph.add_defined(&inputs::UV, &second, &[], 0).expect("there is a second set");
    for (definition, expected) in [
        (&inputs::UV, Vec3::new(0.25, 0.5, 0.0)),
        (&inputs::GENERATED, Vec3::splat(0.5)),
        (&inputs::NORMAL, Vec3::Y),
        (&inputs::WORLD_POINT, Vec3::splat(7.0)),
        (&inputs::WORLD_NORMAL, Vec3::X),
        (&inputs::VERTEX_COLOR, Vec3::X),
    ] {
        let value = source(&mut graph, definition);
        assert_eq!(Program::new(&graph, value).value(&Known), expected, "{}", definition.name);
    }
    assert_eq!(Program::new(&graph, second).value(&Known).x, 0.75);
    let plain = nodes::picture::add(&mut graph, 3, nodes::picture::Shown::Color, None);
    let moved = nodes::picture::add(&mut graph, 3, nodes::picture::Shown::Color, Some(second));
    let [plain, moved] = [plain, moved].map(|value| Program::new(&graph, value));
    assert!(plain.is_filtered() && !moved.is_filtered());
    assert_eq!((plain.value(&Known).y, moved.value(&Known).y), (-1.0, 0.75));
}

#[test]
fn what_programs_print_tells_them_apart() {
    let mut graph = Graph::default();
    let noise = |graph: &mut Graph, dimensions: &str| {
        let mut options = Options::default();
        options.set("dimensions", dimensions);
        let point = source(graph, &inputs::POINT);
        let input = [Some((point, Kind::Vector))];
        graph.add_defined(&nodes::patterns::NOISE, &options, &input, 0).expect("they are known")
    };
    let [two, three, again] = ["2d", "3d", "2d"].map(|dimensions| noise(&mut graph, dimensions));
    assert_eq!(two, again);
    assert_ne!(two, three);
    let [two, three, again] = [two, three, again].map(|value| Program::new(&graph, value));
    assert!(two == again && two != three);
}

/// Of a texture whose number and colour are both needed the colour alone is computed.
#[test]
fn parts_are_not_computed_again() {
    let mut graph = Graph::default();
    let point = source(&mut graph, &inputs::POINT);
    let of = |graph: &mut Graph, output| {
        let input = [Some((point, Kind::Vector))];
        graph
            .add_defined(&nodes::patterns::NOISE, &Options::default(), &input, output)
            .expect("they are known")
    };
    // the number comes first, and something depends on it before the colour is there
    let value = of(&mut graph, 0);
    let double = sum(&mut graph, value, value);
    let color = of(&mut graph, 1);
    let together = Program::of_all(&graph, &[color, double, value]);
    assert_eq!(together.len(), 4, "the place, the colour, its first part, and its double");
    assert!(format!("{together:?}").contains("first part"));
    let values = together.values(Places::new(&[&Known])).map(|value| value.lane(0));
    assert_eq!(values[..3], [color, double, value].map(|value| Program::new(&graph, value).value(&Known)));
    assert_eq!(values[2], Vec3::splat(values[0].x));
    assert!(
        !format!("{:?}", Program::new(&graph, double)).contains("first part"),
        "the number alone is cheaper"
    );
}
