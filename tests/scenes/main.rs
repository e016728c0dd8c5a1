//! Is a shot read as it is written, and every mistake told with its place?
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

#[path = "../collection/mod.rs"]
mod collection;
#[path = "../small_shot/mod.rs"]
mod small_shot;

mod awkward;
mod camera;
mod curves;
mod deforming;
mod environment;
mod gltf;
mod mistakes;
mod model;
mod mtlx;
mod mutated;
mod objects;
mod places;
mod ply;
mod quadrics;
mod schema;
mod shot;
mod subdivision;
mod textures;
#[cfg(feature = "usd")]
mod usd;
mod volumes;
