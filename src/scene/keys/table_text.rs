//! Tables as text: what `init` writes for what a file says, and what tells shots apart.

use std::fmt::Write;

use toml::{Table, Value};

use super::toml_text::{At, List};

/// Keys with their values, in the order in which they are written.
pub(super) type Values = Vec<(&'static str, Said)>;

/// Digits of a number in a text. Both mean the same.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Digits {
    /// Always one of floating point: `90.0`, `1e-7`.
    #[default]
    Floating,
    /// As short as it goes, and never with an exponent: `90`, `0.0000001`.
    Short,
}

/// A value that a table says.
#[derive(Debug, Clone)]
pub(super) enum Said {
    Value(Value),
    /// A number with short digits.
    Short(f64),
}

impl Said {
    pub fn of(value: impl Into<Value>) -> Self {
        Self::Value(value.into())
    }

    /// The value, as if its text were read.
    fn value(self) -> Value {
        match self {
            Self::Value(value) => value,
            Self::Short(number) => number.to_string().parse().map_or(Value::Float(number), Value::Integer),
        }
    }

    fn text(&self) -> String {
        match self {
            Self::Value(value) => shown(value),
            Self::Short(number) => {
                let short = number.to_string();
                // a whole number of the format has 64 bits
                let is_one = short.contains('.') || short.parse::<i64>().is_ok();
                if is_one { short } else { format!("{number:?}") }
            }
        }
    }
}

/// Values that are stated.
pub(super) fn stated(all: impl IntoIterator<Item = (&'static str, Option<Said>)>) -> Values {
    all.into_iter().filter_map(|(key, value)| Some((key, value?))).collect()
}

pub(super) fn number(value: &Option<At<f64>>) -> Option<Said> {
    value.as_ref().map(|value| Said::of(*value.get_ref()))
}

/// A number with short digits.
pub(super) fn short(value: &Option<At<f64>>) -> Option<Said> {
    value.as_ref().map(|value| Said::Short(*value.get_ref()))
}

pub(super) fn whole(value: &Option<At<i64>>) -> Option<Said> {
    value.as_ref().map(|value| Said::of(*value.get_ref()))
}

pub(super) fn word(value: &Option<At<String>>) -> Option<Said> {
    value.as_ref().map(|value| Said::of(value.get_ref().as_str()))
}

pub(super) fn list<const N: usize>(value: &Option<At<List<f64, N>>>) -> Option<Said> {
    value.as_ref().map(|value| Said::of(value.get_ref().0.to_vec()))
}

/// A table with these values.
pub(super) fn table(values: Values) -> Table {
    values.into_iter().map(|(key, value)| (String::from(key), value.value())).collect()
}

/// A table with these values, and with keys if there are any.
pub(super) fn keyed(values: Values, keys: impl Iterator<Item = Table>) -> Table {
    let mut table = table(values);
    let keys: Vec<Value> = keys.map(Value::Table).collect();
    if !keys.is_empty() {
        table.insert(String::from("key"), Value::Array(keys));
    }
    table
}

/// Lines of these values.
pub(super) fn lines(values: &Values) -> String {
    let mut text = String::new();
    for (key, value) in values {
        // a write to a string does not fail
        let _ = writeln!(text, "{key} = {}", value.text());
    }
    text
}

/// Text of a value: numbers with all of their digits, and none more.
fn shown(value: &Value) -> String {
    match value {
        Value::Float(number) => format!("{number:?}"),
        Value::Array(list) => format!("[{}]", list.iter().map(shown).collect::<Vec<_>>().join(", ")),
        _ => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_numbers_are_whole_if_they_can_be() {
        for (number, text, is_whole) in [
            (90.0, "90", true),
            (-3.0, "-3", true),
            (0.5, "0.5", false),
            (1e-9, "0.000000001", false),
            (1e300, "1e300", false),
        ] {
            let short = Said::Short(number);
            assert_eq!(short.text(), text);
            assert_eq!(short.value().is_integer(), is_whole, "{text}");
        }
    }
}
