//! TOML text that reports errors with file, line and column.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;
use std::ops::Range;
use std::path::Path;

use glam::DVec3;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, DeserializeOwned, Deserializer, Error, IgnoredAny, SeqAccess, Visitor};
use toml::Spanned;

use super::spelling;
use crate::scene::SceneError;

/// Linear RGB, or coordinates.
pub(crate) type Three = At<List<f64, 3>>;

/// A value that knows its place in the text.
#[derive(Debug, Clone)]
pub(crate) struct At<T>(Spanned<T>);

impl<T> At<T> {
    /// A value that no text states.
    pub fn of(value: T) -> Self {
        Self(Spanned::new(0..0, value))
    }

    /// Byte range of the value in the text.
    pub fn span(&self) -> Range<usize> {
        self.0.span()
    }

    /// Returns the value.
    pub fn get_ref(&self) -> &T {
        self.0.get_ref()
    }

    /// Takes the value without its place.
    pub fn into_inner(self) -> T {
        self.0.into_inner()
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for At<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Spanned::deserialize(deserializer).map(Self)
    }
}

/// The schema of the value.
impl<T: JsonSchema> JsonSchema for At<T> {
    fn inline_schema() -> bool {
        T::inline_schema()
    }

    fn schema_name() -> Cow<'static, str> {
        T::schema_name()
    }

    fn schema_id() -> Cow<'static, str> {
        T::schema_id()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        T::json_schema(generator)
    }
}

/// A list of exactly `N` values. (An array of the language does not do: values behind its last one would be
/// ignored.)
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct List<T, const N: usize>(pub [T; N]);

impl<T: JsonSchema, const N: usize> JsonSchema for List<T, N> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        format!("{N} of {}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let items = generator.subschema_for::<T>();
        json_schema!({"type": "array", "items": items, "minItems": N, "maxItems": N})
    }
}

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for List<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ListVisitor<T, const N: usize>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for ListVisitor<T, N> {
            type Value = List<T, N>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a list of {N} numbers")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<List<T, N>, A::Error> {
                let mut list = Vec::with_capacity(N);
                while list.len() < N {
                    match values.next_element()? {
                        Some(value) => list.push(value),
                        None => return Err(Error::invalid_length(list.len(), &self)),
                    }
                }
                let mut more = 0;
                while values.next_element::<IgnoredAny>()?.is_some() {
                    more += 1;
                }
                match list.try_into() {
                    Ok(list) if more == 0 => Ok(List(list)),
                    _ => Err(Error::invalid_length(N + more, &self)),
                }
            }
        }
        deserializer.deserialize_seq(ListVisitor(PhantomData))
    }
}

/// The text of a TOML file.
#[derive(Clone, Copy)]
pub(crate) struct TomlText<'a> {
    pub path: &'a Path,
    pub text: &'a str,
}

impl TomlText<'_> {
    /// Parses the whole text as a `T`.
    ///
    /// # Errors The first one: syntax, an unknown key, a value of another type.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, SceneError> {
        toml::from_str(self.text).map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            self.fault(span.clone(), reworded(error.message(), self.key_at(span.start)))
        })
    }

    /// Creates an error about the text at `span` (in bytes).
    pub fn fault(&self, span: Range<usize>, message: impl Into<String>) -> SceneError {
        let start = self.text.floor_char_boundary_at(span.start);
        let before = &self.text[..start];
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        SceneError::new(self.path, message).at(line, column)
    }

    /// Creates an error about `value`, which stands behind `key`.
    pub fn bad<T>(&self, key: &str, value: &At<T>, message: &str) -> SceneError {
        self.fault(value.span(), format!("`{key}` {message}"))
    }

    /// Reads a number for which `fits` holds; `wanted` describes the allowed ones.
    pub fn number(
        &self,
        key: &str,
        value: &At<f64>,
        wanted: &str,
        fits: impl Fn(f64) -> bool,
    ) -> Result<f64, SceneError> {
        let number = *value.get_ref();
        if number.is_finite() && fits(number) {
            return Ok(number);
        }
        Err(self.bad(key, value, &format!("is {number}: it must be {wanted}")))
    }

    /// Reads a whole number within `range`.
    pub fn whole(&self, key: &str, value: &At<i64>, range: Range<i64>) -> Result<u32, SceneError> {
        let number = *value.get_ref();
        let message =
            || format!("is {number}: it must be a whole number from {} to {}", range.start, range.end - 1);
        let fits = range.contains(&number).then(|| u32::try_from(number).ok()).flatten();
        fits.ok_or_else(|| self.bad(key, value, &message()))
    }

    /// Reads three numbers, all finite.
    pub fn vector(&self, key: &str, value: &At<List<f64, 3>>) -> Result<DVec3, SceneError> {
        // values that do not fit into the renderer's f32 are as good as infinite
        let vector = DVec3::from_array(value.get_ref().0);
        let fits = vector.as_vec3().is_finite();
        fits.then_some(vector).ok_or_else(|| self.bad(key, value, "must be three finite numbers"))
    }

    /// Reads linear RGB, finite and not negative.
    pub fn color(&self, key: &str, value: &At<List<f64, 3>>) -> Result<glam::Vec3, SceneError> {
        let color = self.vector(key, value)?.as_vec3();
        if color.min_element() < 0.0 {
            return Err(self.bad(key, value, "is a colour: none of its three numbers may be negative"));
        }
        Ok(color)
    }

    /// Finds the key of the line that `offset` lies in.
    fn key_at(&self, offset: usize) -> Option<&str> {
        let offset = self.text.floor_char_boundary_at(offset);
        let start = self.text[..offset].rfind('\n').map_or(0, |i| i + 1);
        let (key, _) = self.text[start..].lines().next()?.split_once('=')?;
        let key = key.trim();
        let plain = !key.is_empty() && key.chars().all(|c| c.is_alphanumeric() || "_-.\"".contains(c));
        plain.then_some(key)
    }
}

trait CharBoundary {
    fn floor_char_boundary_at(&self, index: usize) -> usize;
}

impl CharBoundary for str {
    /// Finds the last place at or before `index` where the text can be cut.
    fn floor_char_boundary_at(&self, index: usize) -> usize {
        (0..=index.min(self.len())).rev().find(|i| self.is_char_boundary(*i)).unwrap_or(0)
    }
}

/// Rewords the parser's message in the terms of the shot file.
fn reworded(message: &str, key: Option<&str>) -> String {
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    match quoted.as_slice() {
        [wrong, known @ ..] if message.starts_with("unknown field") => {
            let hint = spelling::hint(wrong, known.iter().copied());
            format!("unknown key `{wrong}`{hint} (known here: {})", known.join(", "))
        }
        [wrong, known @ ..] if message.starts_with("unknown variant") => {
            let key = key.map_or(String::new(), |key| format!("`{key}`: "));
            let hint = spelling::hint(wrong, known.iter().copied());
            format!("{key}unknown value `{wrong}`{hint} (known here: {})", known.join(", "))
        }
        [missing, ..] if message.starts_with("missing field") => format!("the key `{missing}` is missing"),
        _ => match key {
            Some(key) => format!("`{key}`: {}", message.trim()),
            None => message.trim().to_string(),
        },
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code, reason = "only read from text")]
    struct Table {
        size: At<List<f64, 3>>,
        filter: Option<crate::settings::Filter>,
    }

    fn error(text: &str) -> String {
        TomlText { path: Path::new("x.toml"), text }.read::<Table>().unwrap_err().to_string()
    }

    #[test]
    fn names_place_and_remedy() {
        assert_eq!(
            error("size = [1, 2, 3]\nfliter = \"box\""),
            "x.toml:2:1: unknown key `fliter`: did you mean `filter`? (known here: size, filter)"
        );
        assert_eq!(
            error("size = [1, 2, 3]\nfilter = \"bx\""),
            "x.toml:2:10: `filter`: unknown value `bx`: did you mean `box`? (known here: box, area, tent, gaussian, mitchell, blackman-harris, lanczos)"
        );
        assert!(error("").contains("the key `size` is missing"));
        let wrong_type = error("# ä\nsize = \"ä\"");
        assert!(wrong_type.starts_with("x.toml:2:8: `size`: invalid type"), "{wrong_type}");
        assert!(error("size = [1, 2").starts_with("x.toml:1:"), "{}", error("size = [1, 2"));
    }

    #[test]
    fn counts_columns_in_characters() {
        let text = TomlText { path: Path::new("x"), text: "a\näöü = 1" };
        let fault = text.fault(text.text.find('1').unwrap()..9, "odd");
        assert_eq!((fault.line, fault.column), (Some(2), Some(7)));
    }
}
