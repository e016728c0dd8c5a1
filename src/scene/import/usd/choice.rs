//! What of a USD file is read: variants, purposes, a part of its prims, and a part of its time. Options of the program and keys of shot
//! files state it in the same words.

use std::collections::BTreeSet;
use std::fmt;

use schemars::JsonSchema;
use serde::Deserialize;

/// What of a USD file is read.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub struct StageChoice {
    /// Variants, in place of those that the file selects.
    pub variants: Vec<VariantChoice>,
    /// Purposes that are shown beside `default`; none: those that the file's settings include, or `render`.
    pub purposes: Option<BTreeSet<Purpose>>,
    /// Paths of prims that alone are read, with all below and above them; none: all are.
    pub mask: Vec<String>,
    /// Paths of prims at and below which no payload is loaded.
    pub unloaded: Vec<String>,
    /// First and last frame of which times are read; none: all are.
    pub frames: Option<[i32; 2]>,
}

/// Choices for the shot of a bare file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ViewChoice {
    /// Path or name of the camera.
    pub camera: Option<String>,
    /// Path of the RenderSettings, or of a RenderPass.
    pub settings: Option<String>,
    /// True if payloads that the camera does not see are left out.
    pub only_seen: bool,
}

/// A variant of a prim's variant set.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct VariantChoice {
    /// Path of the prim.
    pub prim: String,
    /// Name of the set; none: the prim's only one.
    pub set: Option<String>,
    /// Name of the variant.
    pub variant: String,
}

/// Purpose of a prim (UsdGeomImageable) beside `default`, which is always shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Purpose {
    /// What final pictures show
    Render,
    /// Lighter stand-ins of that
    Proxy,
    /// Aids for people who work on the scene
    Guide,
}

impl Purpose {
    /// All purposes, by name.
    pub const ALL: [(&'static str, Self); 3] =
        [("render", Self::Render), ("proxy", Self::Proxy), ("guide", Self::Guide)];

    /// The purpose of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find_map(|(own, purpose)| (own == name).then_some(purpose))
    }

    /// Name of the purpose.
    pub fn name(self) -> &'static str {
        Self::ALL.into_iter().find(|(_, purpose)| *purpose == self).map_or("", |(name, _)| name)
    }
}

impl StageChoice {
    /// Returns true if prims of this purpose are shown.
    pub fn shows(&self, purpose: &str) -> bool {
        purpose == "default"
            || match (&self.purposes, Purpose::named(purpose)) {
                (Some(purposes), Some(purpose)) => purposes.contains(&purpose),
                (None, purpose) => purpose == Some(Purpose::Render),
                (Some(_), None) => false,
            }
    }
}

impl VariantChoice {
    /// Reads `/PRIM:SET=VARIANT`, or `/PRIM=VARIANT` for a prim with one set.
    ///
    /// # Errors What is wrong, and what to write.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wanted = || {
            format!(
                "`{text}` names no variant: write /PRIM:SET=VARIANT as /World/set:time=night, or /PRIM=VARIANT where the prim has one variant set"
            )
        };
        let (of, variant) = text.split_once('=').ok_or_else(wanted)?;
        let (prim, set) = match of.split_once(':') {
            Some((prim, set)) => (prim, Some(set)),
            None => (of, None),
        };
        let is_set = |set: &str| is_identifier(set);
        // as Pixar's library has them
        let is_variant = |name: &str| {
            let name = name.strip_prefix('.').unwrap_or(name);
            !name.is_empty() && name.chars().all(|l| l.is_alphanumeric() || matches!(l, '_' | '-' | '|'))
        };
        if set.is_some_and(|set| !is_set(set)) || !is_variant(variant) {
            return Err(wanted());
        }
        let prim = prim_path(prim)?;
        if prim == "/" {
            return Err(wanted());
        }
        Ok(Self { prim, set: set.map(String::from), variant: String::from(variant) })
    }
}

impl fmt::Display for VariantChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { prim, set, variant } = self;
        match set {
            Some(set) => write!(f, "{prim}:{set}={variant}"),
            None => write!(f, "{prim}={variant}"),
        }
    }
}

fn is_identifier(name: &str) -> bool {
    name.chars().next().is_some_and(|first| first.is_alphabetic() || first == '_')
        && name.chars().all(|letter| letter.is_alphanumeric() || letter == '_')
}

/// Reads the path of a prim: `/World/set`, or `/` for all.
///
/// # Errors What is wrong, and what to write.
pub fn prim_path(text: &str) -> Result<String, String> {
    let path = text.strip_suffix('/').unwrap_or(text);
    if text == "/" || path.strip_prefix('/').is_some_and(|names| names.split('/').all(is_identifier)) {
        return Ok(String::from(if path.is_empty() { "/" } else { path }));
    }
    Err(format!("`{text}` is no path of a prim: write it with all names above it, as /World/set"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    #[test]
    fn variants_are_a_prim_a_set_and_a_name() {
        let choice = VariantChoice::parse("/World/set:time=night-2").unwrap();
        assert_eq!(
            choice,
            VariantChoice { prim: "/World/set".into(), set: Some("time".into()), variant: "night-2".into() }
        );
        for good in ["/World/set:time=night-2", "/set=night", "/set:lod=.5"] {
            assert_eq!(VariantChoice::parse(good).unwrap().to_string(), good);
        }
        for bad in [
            "time=night",
            "/set",
            "/set:=night",
            "/set:time=",
            "/set:time",
            "/=night",
            "/a.b=c",
            "/a=b c",
            "",
        ] {
            assert!(VariantChoice::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn paths_of_prims_begin_at_the_root() {
        for (text, path) in [("/", "/"), ("/World/set/", "/World/set"), ("/_a1", "/_a1")] {
            assert_eq!(prim_path(text).unwrap(), path);
        }
        for bad in ["", "World", "//a", "/a//b", "/a.points", "/a b", "/1", "/a{v=b}", "./a"] {
            assert!(prim_path(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn default_is_always_shown_and_the_rest_by_choice() {
        let shown = |purposes: Option<&[Purpose]>| {
            let choice = StageChoice {
                purposes: purposes.map(|list| list.iter().copied().collect()),
                ..StageChoice::default()
            };
            ["default", "render", "proxy", "guide", "other"].map(|purpose| choice.shows(purpose))
        };
        assert_eq!(shown(None), [true, true, false, false, false]);
        assert_eq!(shown(Some(&[Purpose::Proxy])), [true, false, true, false, false]);
        assert_eq!(shown(Some(&[])), [true, false, false, false, false]);
    }
}
