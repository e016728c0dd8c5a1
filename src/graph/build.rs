//! Graphs as they are made: node by node.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;

use super::{Definition, Function, Kind, Options, Places, function};
use crate::lanes::Vec3x8;

/// Source of a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Input {
    /// The same at all places.
    Constant(Vec3),
    /// Output of the node with this number of a [`Graph`].
    Node(u32),
}

impl Input {
    /// What it is where nodes have these values.
    pub(super) fn of(self, values: &[Self]) -> Self {
        match self {
            Self::Constant(_) => self,
            Self::Node(number) => values[number as usize],
        }
    }
}

/// Nodes, each of which takes what those before it give: there are no cycles.
#[derive(Debug, Clone, Default)]
pub struct Graph {
    pub(super) nodes: Vec<Node>,
    /// Number of each node, by its function and the bits of its inputs.
    known: HashMap<(String, Vec<Key>), u32>,
}

/// A function and its inputs.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub function: Arc<dyn Function>,
    pub inputs: Vec<Input>,
}

/// An input that can be compared.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Key {
    Constant([u32; 3]),
    Node(u32),
}

impl Graph {
    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Returns true if there are no nodes.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Adds a function of `inputs`, which are of the kinds that it takes. Returns its value, or the node that gives it: one that is
    /// there already where they are equal.
    pub fn add(&mut self, function: Arc<dyn Function>, inputs: Vec<Input>) -> Input {
        let constants = inputs.iter().map(|input| match input {
            Input::Constant(value) => Some(*value),
            Input::Node(_) => None,
        });
        if let Some(constants) = constants.collect::<Option<Vec<Vec3>>>().filter(|_| !function.is_of_place())
        {
            let constants: Vec<Vec3x8> = constants.into_iter().map(Vec3x8::splat).collect();
            return constant(function.values(&constants, Places::NOWHERE));
        }
        let key = (format!("{function:?}"), inputs.iter().map(Key::of).collect());
        let Self { nodes, known } = self;
        Input::Node(*known.entry(key).or_insert_with(|| {
            nodes.push(Node { function, inputs });
            (nodes.len() - 1) as u32
        }))
    }

    /// Adds output number `output` of a defined node. `inputs`: values with their kinds, or none where the defaults count.
    ///
    /// # Errors
    /// Options that make no sense, in a sentence.
    pub fn add_defined(
        &mut self,
        definition: &Definition,
        options: &Options,
        inputs: &[Option<(Input, Kind)>],
        output: usize,
    ) -> Result<Input, String> {
        let function = (definition.function)(options, output)?;
        let mut taken = Vec::with_capacity(definition.inputs.len());
        for (number, socket) in definition.inputs.iter().enumerate() {
            taken.push(match inputs.get(number).copied().flatten() {
                None => Input::Constant(socket.value()),
                Some((input, kind)) => self.converted(input, kind, socket.kind),
            });
        }
        Ok(self.add(function, taken))
    }

    /// The nodes that are `needed`, in a graph where functions that are the [first part](Function::whole) of others that are needed are not
    /// computed again; and where its values are then. Those of nodes that are not needed are 0.
    pub(super) fn without_parts(&self, needed: impl Fn(usize) -> bool) -> (Self, Vec<Input>) {
        let key = |function: &Arc<dyn Function>, node: &Node| {
            (format!("{function:?}"), node.inputs.iter().map(Key::of).collect::<Vec<_>>())
        };
        let of_needed = |number: &u32| needed(*number as usize);
        let (mut graph, mut values) = (Self::default(), Vec::with_capacity(self.nodes.len()));
        for (number, node) in self.nodes.iter().enumerate() {
            if !needed(number) {
                values.push(Input::Constant(Vec3::ZERO));
                continue;
            }
            let inputs: Vec<Input> = node.inputs.iter().map(|input| input.of(&values)).collect();
            let is_known =
                |whole: &&Arc<dyn Function>| self.known.get(&key(whole, node)).is_some_and(of_needed);
            values.push(match node.function.whole().filter(is_known) {
                Some(whole) => {
                    let whole = graph.add(Arc::clone(whole), inputs);
                    let first = |values: &[Vec3x8], _| Vec3x8::all_of(values[0].x);
                    graph.add(function(String::from("first part"), first), vec![whole])
                }
                None => graph.add(Arc::clone(&node.function), inputs),
            });
        }
        (graph, values)
    }

    /// A value of kind `from` where one of kind `to` is taken.
    pub fn converted(&mut self, input: Input, from: Kind, to: Kind) -> Input {
        match input {
            Input::Constant(value) => constant(from.converted(to, Vec3x8::splat(value))),
            Input::Node(_) if !from.changes(to) => input,
            Input::Node(_) => self.add(Arc::new(Conversion { from, to }), vec![input]),
        }
    }
}

/// The constant of the first lane.
fn constant(values: Vec3x8) -> Input {
    Input::Constant(values.finite_or_zero().lane(0))
}

impl Key {
    fn of(input: &Input) -> Self {
        match input {
            // no zero is negative
            Input::Constant(value) => Self::Constant(value.to_array().map(|number| (number + 0.0).to_bits())),
            Input::Node(number) => Self::Node(*number),
        }
    }
}

/// Function that makes values of one kind of those of another.
#[derive(Debug)]
struct Conversion {
    from: Kind,
    to: Kind,
}

impl Function for Conversion {
    fn values(&self, inputs: &[Vec3x8], _: Places) -> Vec3x8 {
        self.from.converted(self.to, inputs[0])
    }
}
