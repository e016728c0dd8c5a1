//! Definitions: what kinds of nodes take and give.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;

use super::{Function, Kind};

/// A kind of node.
#[derive(Debug)]
pub struct Definition {
    /// Name, as files have it.
    pub name: &'static str,
    /// Inputs, in the order in which functions take them.
    pub inputs: &'static [Socket],
    /// Names and kinds of the outputs.
    pub outputs: &'static [(&'static str, Kind)],
    /// Makes the function of the output with this number.
    pub function: Make,
}

/// Makes the function of an output, of what a file states of the node; else a sentence says what makes no sense.
pub type Make = fn(&Options, usize) -> Result<Arc<dyn Function>, String>;

/// An input of a kind of node.
#[derive(Debug)]
pub struct Socket {
    /// Name, as files have it.
    pub name: &'static str,
    /// Kind of its values.
    pub kind: Kind,
    /// Value where nothing is stated.
    pub default: [f32; 3],
}

impl Socket {
    /// An input that takes a number.
    pub const fn number(name: &'static str, default: f32) -> Self {
        Self { name, kind: Kind::Number, default: [default; 3] }
    }

    /// An input that takes a vector.
    pub const fn vector(name: &'static str, default: [f32; 3]) -> Self {
        Self { name, kind: Kind::Vector, default }
    }

    /// An input that takes a colour.
    pub const fn color(name: &'static str, default: [f32; 3]) -> Self {
        Self { name, kind: Kind::Color, default }
    }

    /// [`default`](Self::default) as a value.
    pub fn value(&self) -> Vec3 {
        Vec3::from(self.default)
    }
}

/// What a file states of a node beside its inputs: names of operations, lists of numbers, by key.
///
/// It knows which options were asked for: what a kind of node never asks for is none of its options.
#[derive(Debug, Clone, Default)]
pub struct Options(BTreeMap<String, Stated>);

/// Text of an option.
#[derive(Debug, Clone)]
struct Stated {
    text: String,
    is_asked: Cell<bool>,
}

impl Options {
    /// States an option.
    pub fn set(&mut self, key: &str, value: &str) {
        self.0.insert(key.to_string(), Stated { text: value.to_string(), is_asked: Cell::new(false) });
    }

    /// Text of an option.
    pub fn text(&self, key: &str) -> Option<&str> {
        let stated = self.0.get(key)?;
        stated.is_asked.set(true);
        Some(&stated.text)
    }

    /// Names of the options that nothing has asked for so far.
    pub fn unasked(&self) -> impl Iterator<Item = &str> {
        self.0.iter().filter(|(_, stated)| !stated.is_asked.get()).map(|(key, _)| key.as_str())
    }

    /// One of the things that `named` knows; the first one where nothing is stated.
    ///
    /// # Errors
    /// A name that it does not know, in a sentence.
    pub fn one_of<T>(&self, key: &str, default: T, named: impl Fn(&str) -> Option<T>) -> Result<T, String> {
        match self.text(key) {
            None => Ok(default),
            Some(name) => named(name).ok_or_else(|| format!("`{key}` is `{name}`, which is not known")),
        }
    }

    /// Returns true if an option is stated to be true.
    ///
    /// # Errors
    /// Text that is neither `true` nor `false`.
    pub fn flag(&self, key: &str, default: bool) -> Result<bool, String> {
        self.one_of(key, default, |text| text.parse().ok())
    }

    /// List of finite numbers, apart by commas or blanks. Empty where nothing is stated.
    ///
    /// # Errors
    /// What is no such number.
    pub fn numbers(&self, key: &str) -> Result<Vec<f32>, String> {
        numbers(self.text(key).unwrap_or("")).map_err(|fault| format!("`{key}` {fault}"))
    }
}

/// Finite numbers of a text, apart by commas or blanks.
///
/// # Errors
/// What is no such number: the end of a sentence.
pub fn numbers(text: &str) -> Result<Vec<f32>, String> {
    let words = text.split([',', ' ', '\t', '\n', '\r']).filter(|word| !word.is_empty());
    let number = |word: &str| word.parse::<f32>().ok().filter(|number| number.is_finite());
    words.map(|word| number(word).ok_or_else(|| format!("has `{word}`, which is no number"))).collect()
}
