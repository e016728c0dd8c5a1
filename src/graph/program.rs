//! Programs: what is evaluated at a place.
//!
//! Values that a surface needs together are computed together: nodes that several of them take are evaluated once.

use std::sync::Arc;

use glam::Vec3;

use super::function::finite;
use super::{Function, Graph, Input, Place};

/// Number of registers that are held on the stack.
const FEW: usize = 32;

/// Steps that compute one value or several, in order.
#[derive(Debug, Clone)]
pub struct Program {
    steps: Vec<Step>,
    /// Number of registers.
    registers: usize,
    results: Vec<Operand>,
    is_filtered: bool,
}

/// A function of operands, whose value goes into a register.
#[derive(Debug, Clone)]
struct Step {
    function: Arc<dyn Function>,
    operands: Vec<Operand>,
    register: u32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Operand {
    Constant(Vec3),
    Register(u32),
}

/// Number of inputs that functions have, at most.
const MOST_INPUTS: usize = 16;

impl Program {
    /// Creates the program of a value of `graph`.
    pub fn new(graph: &Graph, value: Input) -> Self {
        Self::of_all(graph, &[value])
    }

    /// Creates the program of these values of `graph`, at most [`MOST_VALUES`](Self::MOST_VALUES): the nodes that they depend on, each of
    /// which leaves its register to others as soon as nothing needs it any more.
    pub fn of_all(graph: &Graph, values: &[Input]) -> Self {
        let last_use = last_uses(graph, values);
        let (mut register_of, mut free, mut registers) = (vec![u32::MAX; graph.len()], Vec::new(), 0);
        let mut steps = Vec::new();
        let operand = |register_of: &[u32], input: &Input| match input {
            Input::Constant(value) => Operand::Constant(*value),
            Input::Node(node) => Operand::Register(register_of[*node as usize]),
        };
        for (number, node) in graph.nodes.iter().enumerate().filter(|(number, _)| last_use[*number] > 0) {
            let operands = node.inputs.iter().map(|input| operand(&register_of, input)).collect();
            for input in &node.inputs {
                if let Input::Node(used) = input
                    && last_use[*used as usize] == number
                    && !free.contains(&register_of[*used as usize])
                {
                    free.push(register_of[*used as usize]);
                }
            }
            let register = free.pop().unwrap_or_else(|| {
                registers += 1;
                registers - 1
            });
            register_of[number] = register;
            steps.push(Step { function: Arc::clone(&node.function), operands, register });
        }
        let is_filtered = steps.iter().any(|step| step.function.is_filtered());
        let results =
            values.iter().take(Self::MOST_VALUES).map(|value| operand(&register_of, value)).collect();
        Self { steps, registers: registers as usize, results, is_filtered }
    }

    /// Values of a program, at most.
    pub const MOST_VALUES: usize = 6;

    /// Number of steps.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Returns true if its values are constants.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Returns true if a step filters over the place.
    pub fn is_filtered(&self) -> bool {
        self.is_filtered
    }

    /// The first value at a place: finite, and the same to the bit for the same place.
    pub fn value(&self, place: &dyn Place) -> Vec3 {
        self.values(place)[0]
    }

    /// All values at a place, in order; 0 for those that it does not have.
    pub fn values(&self, place: &dyn Place) -> [Vec3; Self::MOST_VALUES] {
        if self.registers <= FEW {
            self.run(place, &mut [Vec3::ZERO; FEW])
        } else {
            self.run(place, &mut vec![Vec3::ZERO; self.registers])
        }
    }

    fn run(&self, place: &dyn Place, registers: &mut [Vec3]) -> [Vec3; Self::MOST_VALUES] {
        let get = |registers: &[Vec3], operand: &Operand| match operand {
            Operand::Constant(value) => *value,
            Operand::Register(register) => registers[*register as usize],
        };
        let mut inputs = [Vec3::ZERO; MOST_INPUTS];
        for Step { function, operands, register } in &self.steps {
            for (input, operand) in inputs.iter_mut().zip(operands) {
                *input = get(registers, operand);
            }
            let value = function.value(&inputs[..operands.len().min(MOST_INPUTS)], place);
            registers[*register as usize] = finite(value);
        }
        let mut values = [Vec3::ZERO; Self::MOST_VALUES];
        values.iter_mut().zip(&self.results).for_each(|(value, result)| *value = get(registers, result));
        values
    }
}

impl PartialEq for Program {
    /// Programs are equal if they print the same.
    fn eq(&self, other: &Self) -> bool {
        format!("{self:?}") == format!("{other:?}")
    }
}

/// Number of the last node that takes the value of each node; 0: none does; the number of nodes: a result is it.
fn last_uses(graph: &Graph, values: &[Input]) -> Vec<usize> {
    let mut last_use = vec![0; graph.len()];
    for value in values {
        if let Input::Node(node) = value {
            last_use[*node as usize] = graph.len();
        }
    }
    // nodes take what those before them give: from the last one backwards all uses of a node are known when it is its turn
    for number in (0..graph.len()).rev() {
        if last_use[number] == 0 {
            continue;
        }
        for input in &graph.nodes[number].inputs {
            if let Input::Node(used) = input {
                last_use[*used as usize] = last_use[*used as usize].max(number);
            }
        }
    }
    last_use
}
