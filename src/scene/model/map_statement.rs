//! `map_` statements of MTL files: a file name behind options.

use std::ops::{Index, IndexMut};

use glam::Vec2;

use super::decoded::ColorSpace;

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

impl Channel {
    fn named(name: &str) -> Self {
        match name {
            "r" => Self::Red,
            "g" => Self::Green,
            "b" => Self::Blue,
            "m" => Self::Alpha,
            _ => Self::Mean,
        }
    }
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

    /// Finds the use that a statement's keyword (in small letters) means.
    pub fn of_keyword(keyword: &str) -> Option<Self> {
        Some(match keyword {
            "map_kd" => Self::Color,
            "map_d" => Self::Opacity,
            "map_ks" => Self::Specular,
            "map_ns" => Self::Shininess,
            "map_ke" => Self::Emission,
            "map_pr" => Self::Roughness,
            "map_pm" => Self::Metal,
            "norm" | "map_kn" => Self::Normal,
            "bump" | "map_bump" => Self::Bump,
            _ => return None,
        })
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

/// Reads options, then a file name that may hold spaces. `None` without a name.
pub fn map_statement(text: &str, line: usize) -> Option<MapStatement> {
    let mut map = MapStatement::plain("", line);
    let mut rest = text.trim();
    while let Some((option, after)) = option(rest) {
        let (values, after) = match option {
            "s" | "o" | "t" => take_numbers(after, 3),
            "mm" => take_numbers(after, 2),
            "bm" | "boost" | "texres" => take_numbers(after, 1),
            _ => (Vec::new(), after),
        };
        rest = after;
        match option {
            // a factor of zero would be a single texel; exporters write it for "unset"
            "s" => map.scale = pair(&values, 1.0).map(|x| if x == 0.0 { 1.0 } else { x }),
            "o" => map.offset = pair(&values, 0.0),
            "bm" => map.slope = values.first().copied().unwrap_or(1.0),
            "t" | "mm" | "boost" | "texres" => {}
            _ => {
                let (word, after) = split_word(rest);
                match option {
                    "clamp" => map.clamp = word.eq_ignore_ascii_case("on"),
                    "imfchan" => map.channel = Channel::named(word),
                    "colorspace" => map.space = ColorSpace::named(word),
                    _ => {}
                }
                rest = after;
            }
        }
    }
    map.file = without_trailing_options(rest).trim_matches('"').to_string();
    (!map.file.is_empty()).then_some(map)
}

/// Options that `map_` statements take, each with values behind it.
const OPTIONS: [&str; 14] = [
    "s",
    "o",
    "t",
    "mm",
    "bm",
    "boost",
    "texres",
    "clamp",
    "blendu",
    "blendv",
    "cc",
    "imfchan",
    "type",
    "colorspace",
];

fn option(text: &str) -> Option<(&str, &str)> {
    let (word, rest) = split_word(text);
    let name = word.strip_prefix('-')?;
    OPTIONS.contains(&name).then_some((name, rest))
}

/// Removes trailing options: some files put options behind the name.
fn without_trailing_options(text: &str) -> &str {
    let ends = text.match_indices(" -").map(|(i, _)| i).find(|i| option(text[*i..].trim_start()).is_some());
    text[..ends.unwrap_or(text.len())].trim()
}

fn split_word(text: &str) -> (&str, &str) {
    let end = text.find(char::is_whitespace).unwrap_or(text.len());
    (&text[..end], text[end..].trim_start())
}

fn take_numbers(mut text: &str, most: usize) -> (Vec<f32>, &str) {
    let mut values = Vec::new();
    while values.len() < most {
        let (word, rest) = split_word(text);
        // a file may be called `1`: the last word is the name
        match word.parse::<f32>() {
            Ok(value) if value.is_finite() && !rest.is_empty() => values.push(value),
            _ => break,
        }
        text = rest;
    }
    (values, text)
}

fn pair(values: &[f32], default: f32) -> Vec2 {
    Vec2::new(values.first().copied().unwrap_or(default), values.get(1).copied().unwrap_or(default))
}
