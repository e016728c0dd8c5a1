//! Kinds of rays by what they come from, and what each kind sees of a model.

use schemars::JsonSchema;
use serde::Deserialize;

/// Kind of a ray, by what it comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum RayKind {
    /// Ray from the eye, and what goes on straight from it through veils
    Camera,
    /// Ray that a surface scatters in all directions
    Diffuse,
    /// Ray that a mirror or the layer of a surface reflects
    Glossy,
    /// Ray through glass
    Transmission,
    /// Segment from a surface to a light, or to what may dim its ambient light
    Shadow,
}

impl RayKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Camera, Self::Diffuse, Self::Glossy, Self::Transmission, Self::Shadow];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Diffuse => "diffuse",
            Self::Glossy => "glossy",
            Self::Transmission => "transmission",
            Self::Shadow => "shadow",
        }
    }
}

/// A set of kinds of rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RayKinds(u8);

impl RayKinds {
    /// No kind.
    pub const NONE: Self = Self(0);

    /// All kinds.
    pub const ALL: Self = Self((1 << RayKind::ALL.len()) - 1);

    /// The set with this kind in it.
    pub const fn with(self, kind: RayKind) -> Self {
        Self(self.0 | 1 << kind as u8)
    }

    /// The set with all kinds of another.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// All kinds that are not in the set.
    pub const fn others(self) -> Self {
        Self(Self::ALL.0 & !self.0)
    }

    /// Returns true if a kind is in the set.
    #[inline]
    pub const fn has(self, kind: RayKind) -> bool {
        self.0 >> kind as u8 & 1 != 0
    }

    /// A bit for each kind, in the order of [`RayKind::ALL`].
    pub const fn bits(self) -> u8 {
        self.0
    }
}

/// What rays of each kind see of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RayVisibility {
    /// Kinds of rays that do not meet it. Its light still reaches what rays that start there may meet.
    pub hidden_from: RayKinds,
    /// What rays from the eye see of it. To all other rays it is itself.
    pub role: Role,
}

/// What the eye sees of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Role {
    /// The model itself.
    #[default]
    Itself,
    /// A hole in the picture: neither light nor coverage.
    Holdout,
    /// What is behind the picture, dimmed by the shadows on the model.
    ShadowCatcher,
}

impl RayVisibility {
    /// Returns true if rays of this kind meet the model.
    pub const fn is_seen_by(self, kind: RayKind) -> bool {
        !self.hidden_from.has(kind)
    }

    /// What rays see of a part of a whole of which they see `other`.
    pub fn and(self, other: Self) -> Self {
        Self {
            hidden_from: self.hidden_from.and(other.hidden_from),
            role: if self.role == Role::Itself { other.role } else { self.role },
        }
    }
}

impl FromIterator<RayKind> for RayKinds {
    fn from_iter<I: IntoIterator<Item = RayKind>>(kinds: I) -> Self {
        kinds.into_iter().fold(Self::NONE, Self::with)
    }
}
