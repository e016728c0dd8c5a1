//! `map_` statements of MTL files: a file name behind options.

use glam::Vec2;

use super::statements::maps::{MapStatement, MapUse};
use crate::graph::nodes::picture::Shown;
use crate::scene::import::pictures::decoded::ColorSpace;

/// Finds the use that a statement's keyword (in small letters) means.
pub fn use_of_keyword(keyword: &str) -> Option<MapUse> {
    Some(match keyword {
        "map_kd" => MapUse::Color,
        "map_d" => MapUse::Opacity,
        "map_ks" => MapUse::Specular,
        "map_ns" => MapUse::Shininess,
        "map_ke" => MapUse::Emission,
        "map_pr" => MapUse::Roughness,
        "map_pm" => MapUse::Metal,
        "norm" | "map_kn" => MapUse::Normal,
        "bump" | "map_bump" => MapUse::Bump,
        _ => return None,
    })
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
                    "imfchan" => map.channel = channel_named(word),
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

fn channel_named(name: &str) -> Shown {
    match name {
        "r" => Shown::Channel(0),
        "g" => Shown::Channel(1),
        "b" => Shown::Channel(2),
        "m" => Shown::Alpha,
        _ => Shown::Mean,
    }
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
