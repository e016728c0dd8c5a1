//! Indices of refraction that MTL's statements can hold.

use crate::scene::material;

/// Bounds of the index of refraction: an index of 1 stands for "not stated" in MTL files.
const LEAST_INDEX: f64 = 1.0001;
const GREATEST_INDEX: f64 = 100.0;

/// Largest reflectance at normal incidence of what is no metal.
const MOST_HEAD_ON: f64 = 0.95;

/// An index of refraction that MTL's statements can hold.
pub(crate) fn stated_index(index: f64) -> f64 {
    index.clamp(LEAST_INDEX, GREATEST_INDEX)
}

/// Index of refraction, of those that MTL's statements can hold, of a surface that reflects so much at normal incidence.
pub(crate) fn index_of(head_on: f64) -> f64 {
    stated_index(material::index_of(head_on.clamp(0.0, MOST_HEAD_ON)))
}
