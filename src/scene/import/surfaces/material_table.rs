//! `[[material]]` tables of shot files, as they are stated.

use std::path::PathBuf;

use glam::Vec3;

use crate::media::phase::MOST_ANISOTROPY;
use crate::scene::import::mtl::statements::Statements;
use crate::scene::medium::Medium;

/// A `[[material]]` of the shot file: values other than `None` replace those of the MTL file.
pub(crate) struct Override {
    pub values: Statements,
    /// MaterialX file whose material of the same name counts in place of that of the model's files.
    pub mtlx: Option<PathBuf>,
    /// What fills closed meshes of it.
    pub medium: StatedMedium,
    /// False if it has no surface.
    pub surface: Option<bool>,
    /// The shot file, and the line and column of the entry in it.
    pub path: PathBuf,
    pub line: usize,
    pub column: usize,
    /// True if any model has a material of the name.
    pub used: bool,
}

/// What a table states of a medium.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct StatedMedium {
    pub scatter: Option<Vec3>,
    pub absorb: Option<Vec3>,
    pub emit: Option<Vec3>,
    /// Factor on what the same table states.
    pub density: Option<f32>,
    pub anisotropy: Option<f32>,
    /// Cells along the longest edge of a mesh, where graphs give what is in it.
    pub cells: Option<u32>,
}

impl StatedMedium {
    /// The medium, with what is not stated as it is in another one.
    pub fn over(self, other: Option<Medium>) -> Medium {
        let other = other.unwrap_or(Medium::NONE);
        let density = |value: Vec3| value * self.density.unwrap_or(1.0);
        let anisotropy = self.anisotropy.unwrap_or(other.anisotropy);
        let medium = Medium {
            scatter: density(self.scatter.unwrap_or(other.scatter)),
            absorb: density(self.absorb.unwrap_or(other.absorb)),
            emit: density(self.emit.unwrap_or(other.emit)),
            anisotropy: anisotropy.clamp(-MOST_ANISOTROPY, MOST_ANISOTROPY),
        };
        medium.cleaned()
    }
}
