//! Graphs: values that are computed at each place of a surface, of texture coordinates, patterns, pictures and arithmetic.
//!
//! A [`Graph`] is made node by node, each of which takes constants or what nodes before it give; what depends on nothing is a
//! constant as soon as it is added, and equal nodes are one. Of an output that a surface needs a [`Program`] is made: the nodes that
//! it depends on, in order. A program is evaluated where a sample is traced; the sample keeps what it gave.
//!
//! - [`Definition`]: what a kind of node takes and gives, and its [`Function`]; [`nodes`] has all of them, a file a family;
//! - [`functions`]: the arithmetic, as Blender's nodes have it; the patterns are in [`pattern`](crate::pattern);
//! - [`Place`]: what functions may ask of the surface.
//!
//! Graphs know nothing of scenes and files: readers make them (`scene::mtlx` does).

mod build;
mod definition;
#[cfg(test)]
pub mod each_lane;
mod function;
pub mod functions;
pub mod nodes;
mod program;
#[cfg(test)]
mod tests;

pub use build::{Graph, Input};
pub use definition::{Definition, Options, Socket, numbers};
pub use function::{Function, Kind, Place, Places, UvSet, first_part, function, lane_by_lane};
pub use program::Program;
