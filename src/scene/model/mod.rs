//! Reads meshes and materials from files: OBJ, MTL, pictures, point caches.

pub mod assemble;
pub mod bake;
mod black;
pub mod copies;
pub mod decoded;
pub mod deformed;
pub mod dielectric;
pub mod exporter;
mod illumination;
pub mod map_statement;
mod meaning;
pub mod mtl;
mod normals;
pub mod npy;
mod obj_parts;
pub mod objects;
mod of_surface;
mod ordered;
pub mod pictures;
pub mod point_cache;
pub mod read_model;
pub mod settle;
pub mod shape_files;
pub mod trim;
pub mod unused_statements;
pub mod varying;
