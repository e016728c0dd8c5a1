//! Light that depends on the eye: highlights, light by way of mirrors and glass, and the weights of kept paths
//! by which rough layers reflect. Computed anew for every sample.

pub mod bounce;
pub mod bounced_ray;
pub mod enhance;
pub mod in_media;
pub mod met_surfaces;
pub mod mirrors;
pub mod parts;
pub mod ray_trees;
pub mod roles;
pub mod surroundings;
pub mod tree_times;
pub mod ways;
