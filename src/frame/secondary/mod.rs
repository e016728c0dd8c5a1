//! Light that depends on the eye: highlights, and light by way of mirrors, glass and rough surfaces. Computed
//! anew for every sample.

pub mod bounce;
pub mod bounced_ray;
pub mod enhance;
pub mod parts;
pub mod ray_trees;
pub mod rough_sky;
pub mod surroundings;
pub mod tree_times;
