//! Programs: what is evaluated at a place.
//!
//! It is evaluated at up to eight places at once, one for each lane: what a lane gives is the same to the bit, whatever is in the others.
//! Values that a surface needs together are computed together: nodes that several of them take are evaluated once.

use std::sync::Arc;

use glam::Vec3;

use super::{Function, Graph, Input, Place, Places};
use crate::lanes::Vec3x8;

/// Number of values (registers, and the inputs of a step) that are held on the stack, for small programs: memory is cleared first, which
/// takes long beside a place by itself.
const FEW: usize = 8;

/// The same, for larger programs.
const MORE: usize = 24;

/// Steps that compute one value or several, in order.
#[derive(Debug, Clone)]
pub struct Program {
    steps: Vec<Step>,
    /// Number of registers.
    registers: usize,
    /// Number of operands that a step has, at most.
    most_operands: usize,
    results: Vec<Operand>,
    is_filtered: bool,
    is_of_eye: bool,
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

impl Program {
    /// Creates the program of a value of `graph`.
    pub fn new(graph: &Graph, value: Input) -> Self {
        Self::of_all(graph, &[value])
    }

    /// Creates the program of these values of `graph`, at most [`MOST_VALUES`](Self::MOST_VALUES): the nodes that they depend on, each of
    /// which leaves its register to others as soon as nothing needs it any more.
    pub fn of_all(graph: &Graph, values: &[Input]) -> Self {
        let needed = last_uses(graph, values);
        let (graph, known) = graph.without_parts(|number| needed[number] > 0);
        let values: Vec<Input> = values.iter().map(|value| value.of(&known)).collect();
        Self::of_nodes(&graph, &values)
    }

    fn of_nodes(graph: &Graph, values: &[Input]) -> Self {
        let last_use = last_uses(graph, values);
        let (mut register_of, mut free, mut registers) = (vec![u32::MAX; graph.len()], Vec::new(), 0);
        let mut steps: Vec<Step> = Vec::new();
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
        let is_of_eye = steps.iter().any(|step| step.function.is_of_eye());
        let results =
            values.iter().take(Self::MOST_VALUES).map(|value| operand(&register_of, value)).collect();
        let most_operands = steps.iter().map(|step| step.operands.len()).max().unwrap_or(0);
        Self { steps, registers: registers as usize, most_operands, results, is_filtered, is_of_eye }
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

    /// Returns true if its values depend on what sees the place.
    pub fn is_of_eye(&self) -> bool {
        self.is_of_eye
    }

    /// Returns true if a step filters over the place.
    pub fn is_filtered(&self) -> bool {
        self.is_filtered
    }

    /// The first value at a place: finite, and the same to the bit for the same place.
    pub fn value(&self, place: &dyn Place) -> Vec3 {
        let mut value = [Vec3x8::ZERO];
        self.evaluate(Places::new(&[place]), &mut value);
        value[0].lane(0)
    }

    /// All values at some places, in order; 0 for those that it does not have. Lanes without a place have anything.
    pub fn values(&self, places: Places) -> [Vec3x8; Self::MOST_VALUES] {
        let mut values = [Vec3x8::ZERO; Self::MOST_VALUES];
        self.evaluate(places, &mut values);
        values
    }

    fn evaluate(&self, places: Places, results: &mut [Vec3x8]) {
        let all = self.registers + self.most_operands;
        if all <= FEW {
            self.run(places, &mut [Vec3x8::ZERO; FEW], results);
        } else if all <= MORE {
            self.run(places, &mut [Vec3x8::ZERO; MORE], results);
        } else {
            self.run(places, &mut vec![Vec3x8::ZERO; all], results);
        }
    }

    /// Runs it in memory for its registers, and behind them for the inputs of a step.
    fn run(&self, places: Places, memory: &mut [Vec3x8], results: &mut [Vec3x8]) {
        let get = |registers: &[Vec3x8], operand: &Operand| match operand {
            Operand::Constant(value) => Vec3x8::splat(*value),
            Operand::Register(register) => registers[*register as usize],
        };
        let (registers, inputs) = memory.split_at_mut(self.registers);
        for Step { function, operands, register } in &self.steps {
            for (input, operand) in inputs.iter_mut().zip(operands) {
                *input = get(registers, operand);
            }
            let values = function.values(&inputs[..operands.len()], places);
            registers[*register as usize] = values.finite_or_zero();
        }
        results.iter_mut().zip(&self.results).for_each(|(value, result)| *value = get(registers, result));
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
