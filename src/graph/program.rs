//! Programs: what is evaluated at a place.

use std::sync::Arc;

use glam::Vec3;

use super::function::finite;
use super::{Function, Graph, Input, Place};

/// Number of registers that are held on the stack.
const FEW: usize = 32;

/// Steps that compute one value, in order.
#[derive(Debug, Clone)]
pub struct Program {
    steps: Vec<Step>,
    /// Number of registers.
    registers: usize,
    result: Operand,
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
    /// Creates the program of a value of `graph`: the nodes that it depends on, each of which leaves its register to others as soon as
    /// nothing needs it any more.
    pub fn new(graph: &Graph, value: Input) -> Self {
        let last_use = last_uses(graph, value);
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
        let result = operand(&register_of, &value);
        Self { steps, registers: registers as usize, result, is_filtered }
    }

    /// Number of steps.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Returns true if its value is a constant.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Returns true if a step filters over the place.
    pub fn is_filtered(&self) -> bool {
        self.is_filtered
    }

    /// The value at a place: finite, and the same to the bit for the same place.
    pub fn value(&self, place: &dyn Place) -> Vec3 {
        if self.registers <= FEW {
            self.run(place, &mut [Vec3::ZERO; FEW])
        } else {
            self.run(place, &mut vec![Vec3::ZERO; self.registers])
        }
    }

    fn run(&self, place: &dyn Place, registers: &mut [Vec3]) -> Vec3 {
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
        get(registers, &self.result)
    }
}

impl PartialEq for Program {
    /// Programs are equal if they print the same.
    fn eq(&self, other: &Self) -> bool {
        format!("{self:?}") == format!("{other:?}")
    }
}

/// Number of the last node that takes the value of each node; 0: none does; the number of nodes: the result is it.
fn last_uses(graph: &Graph, value: Input) -> Vec<usize> {
    let mut last_use = vec![0; graph.len()];
    if let Input::Node(node) = value {
        last_use[node as usize] = graph.len();
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
