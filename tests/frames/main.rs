//! Are frames what they must be, and is what reuse keeps of them what would be made anew? docs/architecture/tests.md has
//! the question of each file.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

#[path = "../collection/mod.rs"]
mod collection;
#[path = "../program/runs.rs"]
mod runs;
#[path = "../small_shot/mod.rs"]
mod small_shot;
#[path = "../toy/mod.rs"]
mod toy;

mod adaptive;
mod affine;
mod analytic;
mod audit;
mod blur;
mod blur_by_formulas;
mod blurred_lights;
mod brushed;
mod caustics;
mod changing;
mod coats;
mod coverage;
mod curves;
mod cutouts;
mod deforming;
mod deforming_curves;
mod extremes;
mod eye;
mod filters;
mod fuzz;
mod gather;
mod golden;
mod graphs;
mod insides;
mod layers;
mod lens;
mod light_groups;
mod light_links;
mod maps;
mod mattes;
mod media;
mod metal_rough;
mod mirrored;
mod motion_vectors;
mod occlusion;
mod only_lights;
mod passing;
mod pilot;
mod quadrics;
mod quality;
mod ray_trees;
mod ray_visibility;
mod reflected;
mod reflection_maps;
mod reuse;
mod rough_glass;
mod rough_matt;
mod shared;
mod shots;
mod stereo;
mod subdivision;
mod subsurface;
mod terminator;
mod veils;
mod volumes;
mod windows;
