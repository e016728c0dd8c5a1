//! Layers of a picture beside `R G B A`.

use std::fmt;

use serde::{Serialize, Serializer};

/// Groups of layers that are selected as one, by the name before the underscore: a layer of a file has four
/// channels at most (Blender takes no more), of one letter each.
const GROUPS: [&str; 3] = ["status", "rays", "light"];

/// Names of earlier versions, each with the present one.
const RENAMED: [(&str, &str); 2] = [("id", "object"), ("sky", "background")];

/// Set of layers. A layer that is not in it is neither computed (where nothing else needs it) nor written.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Layers(u64);

impl Layers {
    /// `R G B A` alone.
    pub const NONE: Self = Self(0);
    /// All layers.
    pub const ALL: Self = Self((1 << Self::NAMES.len()) - 1);
    /// Layers that files have by default: those that compositors need most, with little to write
    /// (docs/layers.md).
    pub const USUAL: Self = Self(Self::Z.0 | Self::OBJECT.0 | Self::STATUS.0);

    /// Names of the layers on the command line and in shot files: the part before the dot in the names of
    /// planes, or its beginning ([`GROUPS`]).
    pub const NAMES: [&'static str; 31] = [
        "diffuse",
        "specular",
        "reflection",
        "refraction",
        "albedo",
        "Z",
        "P",
        "N",
        "object",
        "status",
        "rays",
        "direct",
        "indirect",
        "emission",
        "background",
        "denoise_albedo",
        "denoise_normal",
        "occlusion",
        "motion",
        "forward",
        "backward",
        "CryptoObject",
        "CryptoMaterial",
        "CryptoGroup",
        "light",
        "depth",
        "material",
        "uv",
        "denoise_variance",
        "catcher",
        "mist",
    ];

    /// Names of sets of layers.
    pub const SETS: [&'static str; 3] = ["all", "usual", "none"];

    /// Diffuse reflectance.
    pub const ALBEDO: Self = Self(1 << 4);
    /// Distance along the view axis.
    pub const Z: Self = Self(1 << 5);
    /// Positions.
    pub const POSITION: Self = Self(1 << 6);
    /// Normals.
    pub const NORMAL: Self = Self(1 << 7);
    /// Models.
    pub const OBJECT: Self = Self(1 << 8);
    /// Status of the samples, and their age.
    pub const STATUS: Self = Self(1 << 9);
    /// Numbers of rays that were cast.
    pub const RAYS: Self = Self(1 << 10);
    /// Diffuse light that comes straight from light sources.
    pub const DIRECT: Self = Self(1 << 11);
    /// Diffuse light that came by light paths.
    pub const INDIRECT: Self = Self(1 << 12);
    /// Emission and ambient light.
    pub const EMISSION: Self = Self(1 << 13);
    /// The background as the eye sees it.
    pub const BACKGROUND: Self = Self(1 << 14);
    /// Albedo and normals for denoisers.
    pub const GUIDES: Self = Self(1 << 15 | 1 << 16);
    /// Parts of `diffuse`, guides for denoisers, the light of single groups, and shadows on catchers.
    pub const PARTS: Self = Self(0b11_1111 << 11 | Self::LIGHT.0 | Self::CATCHER.0);
    /// Share of the directions around that is open.
    pub const OCCLUSION: Self = Self(1 << 17);
    /// Motion to the frame before and the next one, in all conventions.
    pub const ALL_MOTION: Self = Self(0b111 << 18);
    /// Mattes of models.
    pub const CRYPTO_OBJECT: Self = Self(1 << 21);
    /// Mattes of materials.
    pub const CRYPTO_MATERIAL: Self = Self(1 << 22);
    /// Mattes of objects and groups within OBJ files.
    pub const CRYPTO_GROUP: Self = Self(1 << 23);
    /// Mattes of all kinds.
    pub const CRYPTOMATTE: Self = Self(0b111 << 21);
    /// Diffuse light and highlights by groups of lights.
    pub const LIGHT: Self = Self(1 << 24);
    /// Distance along the view axis, filtered.
    pub const DEPTH: Self = Self(1 << 25);
    /// Materials.
    pub const MATERIAL: Self = Self(1 << 26);
    /// Texture coordinates.
    pub const UV: Self = Self(1 << 27);
    /// Variance of pixels, for denoisers.
    pub const VARIANCE: Self = Self(1 << 28);
    /// By what shadows on catchers dim a plate.
    pub const CATCHER: Self = Self(1 << 29);
    /// How much mist is before what is seen.
    pub const MIST: Self = Self(1 << 30);
    /// Layers that show one sample of each pixel.
    pub const OF_ONE_SAMPLE: Self = Self(
        Self::Z.0
            | Self::POSITION.0
            | Self::NORMAL.0
            | Self::OBJECT.0
            | Self::STATUS.0
            | Self::ALL_MOTION.0
            | Self::MATERIAL.0
            | Self::UV.0,
    );

    /// Union with `others`.
    #[must_use]
    pub const fn with(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// Returns true if any of `others` is in the set.
    #[inline]
    pub fn has(self, others: Self) -> bool {
        self.0 & others.0 != 0
    }

    /// Returns true if the plane of this name is in the picture.
    pub fn has_plane(self, name: &str) -> bool {
        match name.split_once('.').map_or(name, |(layer, _)| layer) {
            "R" | "G" | "B" | "A" => true,
            layer => Self::named(selected_as(layer)).is_some_and(|selected| self.has(selected)),
        }
    }

    /// Layer of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().position(|known| *known == name).map(|number| Self(1 << number))
    }

    /// Layers that a name selects: one, or those of one of the [`SETS`](Self::SETS).
    fn selected(name: &str) -> Option<Self> {
        match name {
            "all" => Some(Self::ALL),
            "usual" => Some(Self::USUAL),
            "none" => Some(Self::NONE),
            _ => Self::named(name),
        }
    }

    /// Layers of these names or sets of names, or the first name that is unknown.
    pub fn new<'a>(names: impl IntoIterator<Item = &'a str>) -> Result<Self, &'a str> {
        let mut names = names.into_iter();
        names
            .try_fold(Self::NONE, |all, name| Self::selected(name).map(|layers| all.with(layers)).ok_or(name))
    }

    /// Parses names with commas between them, from the command line.
    ///
    /// # Errors
    /// A name that is none, and what there is.
    pub fn parse(text: &str) -> Result<Self, UnknownLayer> {
        Self::new(text.split(',').map(str::trim)).map_err(UnknownLayer::new)
    }

    /// Names of the layers.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Self::NAMES
            .into_iter()
            .enumerate()
            .filter(move |(number, _)| self.0 >> number & 1 != 0)
            .map(|(_, name)| name)
    }
}

/// A name that selects no layer. The text says what does.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum UnknownLayer {
    /// The layer has another name now.
    Renamed {
        /// The former name.
        old: String,
        /// The name to write.
        new: &'static str,
    },
    /// The layer is selected with the others of its group.
    InGroup {
        /// The name of one of its layers.
        name: String,
        /// The name to write.
        group: &'static str,
    },
    /// No layer has ever been called so.
    Unknown(String),
}

impl UnknownLayer {
    /// Finds out what to write instead of `name`.
    pub fn new(name: &str) -> Self {
        let renamed = RENAMED.iter().find(|(old, _)| *old == name);
        let name = String::from(name);
        match (renamed, group_of(&name)) {
            (Some((_, new)), _) => Self::Renamed { old: name, new },
            (_, Some(group)) => Self::InGroup { name, group },
            _ => Self::Unknown(name),
        }
    }
}

impl fmt::Display for UnknownLayer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Renamed { old, new } => write!(f, "the layer `{old}` is called `{new}` now"),
            Self::InGroup { name, group } => {
                write!(f, "`{name}` is selected with the others of its group, as `{group}`")
            }
            Self::Unknown(name) => {
                write!(f, "there is no layer `{name}`; there are {}", Layers::NAMES.join(", "))
            }
        }
    }
}

impl std::error::Error for UnknownLayer {}

/// Name by which a layer of a file is selected: the mattes of one kind are several layers, numbered.
fn selected_as(layer: &str) -> &str {
    group_of(layer).unwrap_or_else(|| layer.trim_end_matches(|last: char| last.is_ascii_digit()))
}

/// Group that a layer of a file belongs to.
fn group_of(layer: &str) -> Option<&'static str> {
    let (start, _) = layer.split_once('_')?;
    GROUPS.into_iter().find(|group| *group == start)
}

impl Default for Layers {
    fn default() -> Self {
        Self::USUAL
    }
}

impl fmt::Debug for Layers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.names()).finish()
    }
}

impl Serialize for Layers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.names())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_constants_agree() {
        let named = |name: &str| Layers::named(name).expect("it is there");
        let constants = [
            ("albedo", Layers::ALBEDO),
            ("Z", Layers::Z),
            ("P", Layers::POSITION),
            ("N", Layers::NORMAL),
            ("object", Layers::OBJECT),
            ("status", Layers::STATUS),
            ("rays", Layers::RAYS),
            ("direct", Layers::DIRECT),
            ("indirect", Layers::INDIRECT),
            ("emission", Layers::EMISSION),
            ("background", Layers::BACKGROUND),
            ("occlusion", Layers::OCCLUSION),
            ("CryptoObject", Layers::CRYPTO_OBJECT),
            ("CryptoMaterial", Layers::CRYPTO_MATERIAL),
            ("CryptoGroup", Layers::CRYPTO_GROUP),
            ("light", Layers::LIGHT),
            ("depth", Layers::DEPTH),
            ("material", Layers::MATERIAL),
            ("uv", Layers::UV),
            ("denoise_variance", Layers::VARIANCE),
            ("catcher", Layers::CATCHER),
            ("mist", Layers::MIST),
        ];
        constants.iter().for_each(|(name, layer)| assert_eq!(named(name), *layer));
        assert_eq!(named("motion").with(named("forward")).with(named("backward")), Layers::ALL_MOTION);
        assert_eq!(named("denoise_albedo").with(named("denoise_normal")), Layers::GUIDES);
        assert!(Layers::USUAL.has(Layers::STATUS) && !Layers::USUAL.has(Layers::RAYS));
        assert!(Layers::NAMES.iter().all(|name| Layers::ALL.has(named(name))));
    }

    #[test]
    fn lists_are_read_and_wrong_names_told() {
        let some = Layers::parse("N, Z,status").expect("all are there");
        assert_eq!(some.names().collect::<Vec<_>>(), ["Z", "N", "status"]);
        assert!(some.has_plane("N.X") && some.has_plane("status_age.V") && some.has_plane("Z"));
        assert!(!some.has_plane("rays_shadow.V") && Layers::GUIDES.has_plane("denoise_normal.X"));
        assert!(some.has_plane("R") && some.has_plane("A") && !some.has_plane("P.X"));
        assert_eq!((Layers::parse("all"), Layers::parse("none")), (Ok(Layers::ALL), Ok(Layers::NONE)));
        assert_eq!(Layers::parse("usual"), Ok(Layers::default()));
        let wrong = Layers::parse("Z,far").expect_err("there is no such layer").to_string();
        assert!(wrong.starts_with("there is no layer `far`; there are diffuse, "), "{wrong}");
    }

    #[test]
    fn names_of_before_and_parts_of_groups_are_told_what_to_say_instead() {
        let wrong = |text: &str| Layers::parse(text).expect_err("it is no selection").to_string();
        assert_eq!(wrong("Z,id"), "the layer `id` is called `object` now");
        assert!(wrong("sky").contains("`background`"));
        assert!(wrong("status_missed").ends_with("as `status`"));
        assert!(wrong("rays_shadow").ends_with("as `rays`"));
        assert!(wrong("denoise_depth").starts_with("there is no layer"));
    }
}
