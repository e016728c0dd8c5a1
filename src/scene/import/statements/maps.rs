//! Pictures that materials state, by their use.

use std::ops::{Index, IndexMut};

use glam::Vec2;

use crate::scene::import::pictures::decoded::ColorSpace;

/// A texture as a material asks for it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MapStatement {
    /// File name as written; may hold spaces, backslashes and the case of another system.
    pub file: String,
    pub scale: Vec2,
    pub offset: Vec2,
    pub clamp: bool,
    /// `-bm`: factor on the slopes of a bump or normal map.
    pub slope: f32,
    /// `-imfchan`: the channel whose values count, where one number is meant.
    pub channel: Channel,
    /// `-colorspace`: encoding of the colours, if it is stated.
    pub space: Option<ColorSpace>,
    /// Line of the statement, from 1.
    pub line: usize,
}

/// Channel of a picture that holds one number a texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Channel {
    /// Mean of red, green and blue.
    #[default]
    Mean,
    Red,
    Green,
    Blue,
    Alpha,
}

/// Use of a map by a material: each has one map of a kind at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapUse {
    /// `map_Kd`.
    Color,
    /// `map_d`.
    Opacity,
    /// `map_Ks`.
    Specular,
    /// `map_Ns`.
    Shininess,
    /// `map_Ke`.
    Emission,
    /// `map_Pr`.
    Roughness,
    /// `map_Pm`.
    Metal,
    /// `norm`, `map_Kn`: directions of normals.
    Normal,
    /// `bump`, `map_Bump`: heights, or directions of normals.
    Bump,
}

impl MapUse {
    /// Usual spelling of the statement.
    pub fn keyword(self) -> &'static str {
        match self {
            Self::Color => "map_Kd",
            Self::Opacity => "map_d",
            Self::Specular => "map_Ks",
            Self::Shininess => "map_Ns",
            Self::Emission => "map_Ke",
            Self::Roughness => "map_Pr",
            Self::Metal => "map_Pm",
            Self::Normal => "norm",
            Self::Bump => "map_Bump",
        }
    }
}

/// Maps of a material by their use, with anything that belongs to each.
#[derive(Debug, Clone, PartialEq)]
pub struct ByUse<T>([Option<T>; 9]);

/// Maps that a material states.
pub type MapStatements = ByUse<MapStatement>;

impl<T> Default for ByUse<T> {
    fn default() -> Self {
        Self(Default::default())
    }
}

impl<T> ByUse<T> {
    /// Takes every entry that `other` has.
    pub fn replace_with(&mut self, other: &Self)
    where
        T: Clone,
    {
        for (own, other) in self.0.iter_mut().zip(&other.0) {
            if other.is_some() {
                own.clone_from(other);
            }
        }
    }

    /// Entries made of these ones.
    pub fn map<U>(&self, to: impl Fn(&T) -> U) -> ByUse<U> {
        ByUse(self.0.each_ref().map(|entry| entry.as_ref().map(&to)))
    }

    /// Returns true if there is an entry for this use.
    pub fn has(&self, used: MapUse) -> bool {
        self[used].is_some()
    }
}

impl<T> Index<MapUse> for ByUse<T> {
    type Output = Option<T>;

    fn index(&self, used: MapUse) -> &Option<T> {
        &self.0[used as usize]
    }
}

impl<T> IndexMut<MapUse> for ByUse<T> {
    fn index_mut(&mut self, used: MapUse) -> &mut Option<T> {
        &mut self.0[used as usize]
    }
}

impl MapStatement {
    /// Creates a statement for the whole picture, repeating.
    pub fn plain(file: impl Into<String>, line: usize) -> Self {
        Self {
            file: file.into(),
            scale: Vec2::ONE,
            offset: Vec2::ZERO,
            clamp: false,
            slope: 1.0,
            channel: Channel::Mean,
            space: None,
            line,
        }
    }
}
