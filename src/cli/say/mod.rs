//! What a run says while it works, and what it amounts to.

pub mod table;
pub mod terminal;
