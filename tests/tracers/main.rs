//! Does every tracer answer what the trait says, and do all agree?
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

#[path = "../collection/mod.rs"]
mod collection;
#[path = "../toy/mod.rs"]
mod toy;

mod among_others;
mod conformance;
mod hidden;
mod kinds;
mod linked;
mod places;
mod sorts;
