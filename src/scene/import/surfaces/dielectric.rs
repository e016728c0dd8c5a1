//! The dielectric layer of files whose surfaces have several: a coat and what reflects below it become one.
//!
//! glTF's clear coats and USD's follow this rule, and so do exports from Blender.

use crate::scene::material::{self, head_on};

/// Bounds of the index of refraction: an index of 1 stands for "not stated" in MTL files.
const LEAST_INDEX: f64 = 1.0001;
const GREATEST_INDEX: f64 = 100.0;

/// Largest reflectance at normal incidence of what is no metal.
const MOST_HEAD_ON: f64 = 0.95;

/// Index of refraction of a coat, by glTF and USD.
pub(crate) const INDEX_OF_COAT: f64 = 1.5;

/// Share of metal above which the layer of a surface is that of the metal.
const MOST_METAL: f64 = 0.5;

/// Share of the reflectance of the surface below from which a coat decides how rough the layer is.
const DECIDING_SHARE: f64 = 0.5;

/// What is told where the layer of a surface is made of two.
const BECOMES_ONE: &str = "a clearcoat and what reflects below it are one layer: as rough as the coat if that reflects half as \
     much as the surface or more";

/// What is told where the coat of a metal is left out.
const NOT_ON_METAL: &str =
    "clearcoats of metals are not used: a surface has one layer, and that is the metal";

/// A clear coat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Coat {
    /// Share of the surface that it covers, 0 to 1.
    pub share: f64,
    pub roughness: f64,
    /// Index of refraction, 1 or more.
    pub index: f64,
}

/// Surface below a coat.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Below {
    /// Reflectance at normal incidence.
    pub head_on: f64,
    /// Share of metal, the mean over the surface.
    pub metallic: f64,
}

/// A dielectric layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Layer {
    /// Reflectance at normal incidence.
    pub head_on: f64,
    /// Roughness, if it is that of a coat: no picture of the surface counts then.
    pub coat_roughness: Option<f64>,
}

impl Coat {
    /// The one layer that it becomes with what is below. `None` if there is no coat, or one of a metal, which is left out. Tells what is
    /// not as it is meant by `leave_out`.
    pub fn over(self, below: Below, leave_out: impl FnOnce(&'static str)) -> Option<Layer> {
        let reflects = head_on(self.index) * self.share.clamp(0.0, 1.0);
        if reflects == 0.0 {
            return None;
        }
        if below.metallic > MOST_METAL {
            leave_out(NOT_ON_METAL);
            return None;
        }
        leave_out(BECOMES_ONE);
        let decides = reflects >= DECIDING_SHARE * below.head_on;
        Some(Layer {
            head_on: reflects + below.head_on * (1.0 - reflects),
            coat_roughness: decides.then_some(self.roughness.clamp(0.0, 1.0)),
        })
    }
}

/// An index of refraction that MTL's statements can hold.
pub(crate) fn stated_index(index: f64) -> f64 {
    index.clamp(LEAST_INDEX, GREATEST_INDEX)
}

/// Index of refraction, of those that MTL's statements can hold, of a surface that reflects so much at normal incidence.
pub(crate) fn index_of(head_on: f64) -> f64 {
    stated_index(material::index_of(head_on.clamp(0.0, MOST_HEAD_ON)))
}
