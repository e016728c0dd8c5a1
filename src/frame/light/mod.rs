//! Light that does not depend on the eye: computed once, and kept with the sample until something changes it.

mod asked_lights;
pub mod clamp;
pub mod direct;
pub mod indirect;
pub mod layer_paths;
pub mod light_choice;
pub mod light_paths;
pub mod lighting;
pub mod lobes;
pub mod next_event;
pub mod occlusion;
pub mod path_ends;
pub mod path_ray;
pub mod pdfs;
pub mod reflected;
pub mod scattering;
pub mod select;
pub mod shadow;
pub mod starts;
pub mod step;
pub mod subsurface;
mod vertex;
