//! Graphs as they are made: node by node.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;

use super::function::{Nowhere, finite};
use super::{Definition, Function, Kind, Options, Place};

/// Source of a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Input {
    /// The same at all places.
    Constant(Vec3),
    /// Output of the node with this number of a [`Graph`].
    Node(u32),
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
            return Input::Constant(finite(function.value(&constants, &Nowhere)));
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

    /// A value of kind `from` where one of kind `to` is taken.
    pub fn converted(&mut self, input: Input, from: Kind, to: Kind) -> Input {
        match input {
            Input::Constant(value) => Input::Constant(finite(from.converted(to, value))),
            Input::Node(_) if !from.changes(to) => input,
            Input::Node(_) => self.add(Arc::new(Conversion { from, to }), vec![input]),
        }
    }
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
    fn value(&self, inputs: &[Vec3], _: &dyn Place) -> Vec3 {
        self.from.converted(self.to, inputs[0])
    }
}
