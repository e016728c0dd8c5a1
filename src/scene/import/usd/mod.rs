//! Reads USD files, text (`.usda`), binary (`.usdc`) and packed (`.usdz`): meshes, materials, instances, cameras and lights.
//!
//! The crate `openusd` composes the layers. It is asked on one thread, and all that it says becomes plain data there
//! (`file::UsdFile`): its stages cannot leave their thread, and damaged input may stop it. The rest of the module knows only that
//! data. Without the feature `usd` nothing of this is built, and a USD file is refused with what to do.

#[cfg(not(feature = "usd"))]
mod absent;
#[cfg(feature = "usd")]
mod binary;
#[cfg(feature = "usd")]
mod binding;
#[cfg(feature = "usd")]
mod cage;
#[cfg(feature = "usd")]
mod cameras;
mod choice;
#[cfg(feature = "usd")]
mod clock;
#[cfg(feature = "usd")]
mod curves;
#[cfg(feature = "usd")]
mod file;
#[cfg(feature = "usd")]
mod geometry;
#[cfg(feature = "usd")]
mod implicit;
#[cfg(feature = "usd")]
mod instancer;
#[cfg(feature = "usd")]
mod layer_of_mtlx;
#[cfg(feature = "usd")]
mod lights;
#[cfg(feature = "usd")]
mod links;
#[cfg(feature = "usd")]
mod materials;
#[cfg(feature = "usd")]
mod network;
#[cfg(feature = "usd")]
mod of_network;
#[cfg(feature = "usd")]
mod package;
#[cfg(feature = "usd")]
mod parts;
#[cfg(feature = "usd")]
mod place;
#[cfg(feature = "usd")]
mod points;
#[cfg(feature = "usd")]
mod reading;
#[cfg(feature = "usd")]
mod render;
#[cfg(feature = "usd")]
mod resolver;
#[cfg(feature = "usd")]
mod seen;
#[cfg(feature = "usd")]
mod shader;
#[cfg(feature = "usd")]
mod skeleton;
#[cfg(feature = "usd")]
mod skin;
#[cfg(feature = "usd")]
mod stage;
#[cfg(feature = "usd")]
mod temperature;
#[cfg(feature = "usd")]
mod text;
#[cfg(feature = "usd")]
mod tiles;
#[cfg(feature = "usd")]
mod value;
#[cfg(feature = "usd")]
mod variants;
#[cfg(feature = "usd")]
mod velocities;
#[cfg(feature = "usd")]
mod volume;
#[cfg(feature = "usd")]
mod walk;
#[cfg(feature = "usd")]
mod wanted;
#[cfg(feature = "usd")]
mod whole;
#[cfg(feature = "usd")]
mod written;

#[cfg(not(feature = "usd"))]
pub(in crate::scene) use absent::UsdFiles;
#[cfg(not(feature = "usd"))]
pub use absent::text;
#[cfg(not(feature = "usd"))]
pub(crate) use absent::{UsdFile, read};
pub use choice::{Purpose, StageChoice, VariantChoice, ViewChoice, prim_path};
#[cfg(feature = "usd")]
pub(crate) use file::UsdFile;
#[cfg(feature = "usd")]
pub(in crate::scene) use parts::UsdFiles;
#[cfg(feature = "usd")]
pub(crate) use whole::read;
#[cfg(feature = "usd")]
pub use whole::text;

/// Endings of USD files.
pub const ENDINGS: [&str; 4] = ["usd", "usda", "usdc", "usdz"];
