//! Types of a text layer's values.

use std::borrow::Cow;

use super::token::{Token, What};

/// Metadata that is kept, of layers, prims and properties; the rest has no effect.
pub const OF_LAYERS: [&str; 12] = [
    "defaultPrim",
    "doc",
    "endTimeCode",
    "expressionVariables",
    "framesPerSecond",
    "metersPerUnit",
    "relocates",
    "renderSettingsPrimPath",
    "startTimeCode",
    "subLayers",
    "timeCodesPerSecond",
    "upAxis",
];
pub const OF_PRIMS: [&str; 11] = [
    "active",
    "apiSchemas",
    "clipSets",
    "clips",
    "inherits",
    "instanceable",
    "payload",
    "references",
    "relocates",
    "specializes",
    "variantSets",
];
pub const OF_PROPERTIES: [&str; 4] = ["bindMaterialAs", "colorSpace", "elementSize", "interpolation"];

/// What a value is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Bool,
    Int,
    /// Unsigned: lists of these are lists of signed ones there.
    Unsigned,
    Real,
    Text,
    Asset,
    /// A pattern of paths, which is a text there.
    Pattern,
    Path,
    /// Metadata without a type.
    Any,
    /// Such as are not read: of colours in dictionaries, or of plug-ins.
    Unknown,
}

/// Type of a value.
#[derive(Debug, Clone, Copy)]
pub struct Type {
    pub kind: Kind,
    pub is_array: bool,
}

/// Names of types that the library knows: those of whole numbers, and of others.
const INTS: [&str; 6] = ["uchar", "int", "int2", "int3", "int4", "int64"];
const REALS: [&str; 41] = [
    "color3d",
    "color3f",
    "color3h",
    "color4d",
    "color4f",
    "color4h",
    "double",
    "double2",
    "double3",
    "double4",
    "float",
    "float2",
    "float3",
    "float4",
    "frame4d",
    "half",
    "half2",
    "half3",
    "half4",
    "matrix2d",
    "matrix3d",
    "matrix4d",
    "normal3d",
    "normal3f",
    "normal3h",
    "point3d",
    "point3f",
    "point3h",
    "quatd",
    "quatf",
    "quath",
    "texCoord2d",
    "texCoord2f",
    "texCoord2h",
    "texCoord3d",
    "texCoord3f",
    "texCoord3h",
    "timecode",
    "vector3d",
    "vector3f",
    "vector3h",
];

impl Type {
    /// One value of a kind.
    pub fn plain(kind: Kind) -> Self {
        Self { kind, is_array: false }
    }

    /// Type of a name.
    pub fn named(name: &str) -> Self {
        Self::plain(match name {
            "bool" => Kind::Bool,
            "uint" | "uint64" => Kind::Unsigned,
            "string" | "token" => Kind::Text,
            "asset" => Kind::Asset,
            "pathExpression" => Kind::Pattern,
            "dictionary" => Kind::Any,
            name if INTS.contains(&name) => Kind::Int,
            name if REALS.contains(&name) => Kind::Real,
            _ => Kind::Unknown,
        })
    }

    /// The type as the library knows it; `name`: as it is written.
    pub fn spelled(self, name: &str) -> String {
        let name = match self.kind {
            Kind::Unsigned if self.is_array => "int64",
            Kind::Pattern => "string",
            _ => name,
        };
        format!("{name}{}", if self.is_array { "[]" } else { "" })
    }

    /// What a value is to be, in words.
    pub fn expected(self) -> &'static str {
        match self.kind {
            Kind::Bool => "`true` or `false`",
            Kind::Int | Kind::Unsigned => "a whole number",
            Kind::Real => "a number",
            Kind::Text | Kind::Pattern => "a text in quotes",
            Kind::Asset => "a file between @",
            Kind::Path => "a path between < and >",
            Kind::Any | Kind::Unknown => "a value",
        }
    }

    /// A token of a value as the library reads it: borrowed if it stays as it is. `None` if it has another type.
    pub fn value<'a>(self, token: &Token<'a>) -> Option<Cow<'a, str>> {
        let same = Some(Cow::Borrowed(token.text));
        match (self.kind, token.what) {
            (Kind::Any | Kind::Unknown, _) => same,
            (Kind::Bool, _) => truth(token).map(|truth| Cow::Borrowed(if truth { "true" } else { "false" })),
            (Kind::Int | Kind::Unsigned, What::Number) => {
                let is_whole = !token.text.contains(['.', 'e', 'E', 'n']);
                if is_whole && (self.kind == Kind::Int || token.text.parse::<i64>().is_ok()) {
                    return same;
                }
                // converted as by a cast
                let number = token.spelled().parse::<f64>().ok()?;
                (is_whole && self.is_array || !is_whole && number.is_finite())
                    .then(|| Cow::Owned((number as i64).to_string()))
                    .or(same.filter(|_| is_whole))
            }
            (Kind::Real, What::Number) => same,
            (Kind::Real, What::Word) if token.text == "inf" => Some(Cow::Owned(String::from("1e999"))),
            (Kind::Real, What::Word) if token.text == "nan" => same,
            (Kind::Text | Kind::Pattern, What::Text) => same,
            (Kind::Text, What::Path) => Some(Cow::Owned(format!("\"{}\"", token.content()))),
            (Kind::Path, What::Path) => same,
            (Kind::Asset, What::Asset) => same,
            (Kind::Asset, What::Text) => {
                let mark = if token.content().contains('@') { "@@@" } else { "@" };
                Some(Cow::Owned(format!("{mark}{}{mark}", token.content())))
            }
            _ => None,
        }
    }
}

fn truth(token: &Token<'_>) -> Option<bool> {
    let text = if token.what == What::Text { token.content() } else { token.text };
    match text.to_ascii_lowercase().as_str() {
        "true" | "yes" | "on" => Some(true),
        "false" | "no" | "off" => Some(false),
        _ if token.what == What::Number => token.spelled().parse::<f64>().ok().map(|number| number != 0.0),
        _ => None,
    }
}
