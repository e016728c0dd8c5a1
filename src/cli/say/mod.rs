//! Output of a run: its progress, and its totals.

pub mod table;
pub mod terminal;
