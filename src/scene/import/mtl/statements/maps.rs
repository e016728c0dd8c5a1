//! Pictures that materials state, by their use.

use std::ops::{Index, IndexMut};
use std::path::Path;

use glam::{Vec2, Vec3};

use crate::graph::nodes::picture::Shown;
use crate::scene::Material;
use crate::scene::import::pictures::decoded::ColorSpace;
use crate::scene::import::pictures::{Named, PictureUse};
use crate::scene::material::Optics;
use crate::scene::surface::{Parameter, Surface};
use crate::scene::texture::{Mapping, Wrap};

/// A texture as a material asks for it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MapStatement {
    /// File name as written; may hold spaces, backslashes and the case of another system.
    pub file: String,
    pub scale: Vec2,
    pub offset: Vec2,
    pub clamp: bool,
    /// `-bm`: factor on the slopes of a bump or normal map; of a displacement the length for which 1 stands.
    pub slope: f32,
    /// Of a displacement: value that moves nothing.
    pub middle: f32,
    /// `-imfchan`: what counts of it where one number is meant.
    pub channel: Shown,
    /// `-colorspace`: encoding of the colours, if it is stated.
    pub space: Option<ColorSpace>,
    /// Line of the statement, from 1.
    pub line: usize,
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
    /// `map_Tf`: colour of what goes through glass.
    Filter,
    /// Share that is glass; MTL has no such statement.
    Transmission,
    /// Heights that move vertices; of MTL none is read.
    Displacement,
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
            Self::Filter => "map_Tf",
            Self::Transmission => "map_transmission",
            Self::Displacement => "map_displacement",
        }
    }
}

/// Uses of pictures that give parameters of a material, beside its colour.
pub const PARAMETERS: [MapUse; 7] = [
    MapUse::Roughness,
    MapUse::Metal,
    MapUse::Shininess,
    MapUse::Emission,
    MapUse::Specular,
    MapUse::Filter,
    MapUse::Transmission,
];

impl MapUse {
    /// Returns true if `material` has the parameter that these pictures give.
    pub fn is_of(self, material: &Material) -> bool {
        let has_layer = material.metal_rough.is_some();
        match self {
            Self::Roughness => has_layer,
            Self::Metal => has_layer && !material.is_rough_glass(),
            Self::Shininess | Self::Specular => material.specular != Vec3::ZERO,
            Self::Filter | Self::Transmission => {
                matches!(material.optics, Optics::Glass { .. }) && !material.can_blend()
            }
            Self::Color | Self::Opacity | Self::Emission | Self::Normal | Self::Bump | Self::Displacement => {
                true
            }
        }
    }

    /// Use of a picture as such.
    pub(crate) fn of_picture(self) -> PictureUse {
        match self {
            Self::Color => PictureUse::Color,
            Self::Opacity => PictureUse::Opacity,
            Self::Specular | Self::Filter => PictureUse::ColorParameter,
            Self::Emission => PictureUse::Light,
            Self::Shininess | Self::Roughness | Self::Metal | Self::Transmission | Self::Displacement => {
                PictureUse::Parameter
            }
            Self::Normal => PictureUse::Normals,
            Self::Bump => PictureUse::Heights,
        }
    }

    /// Has nothing but numbers give the parameter. Of what a graph gave in whole nothing is left but a factor of 1.
    pub fn hide(self, surface: &mut Surface) {
        let phong = surface.beyond.phong.as_mut();
        let value = match self {
            Self::Roughness => &mut surface[Parameter::SpecularRoughness],
            Self::Metal => &mut surface[Parameter::BaseMetalness],
            Self::Emission => &mut surface[Parameter::EmissionColor],
            Self::Filter => &mut surface.beyond.glass_tint,
            Self::Transmission => &mut surface[Parameter::TransmissionWeight],
            Self::Specular => {
                return if let Some(phong) = phong {
                    phong.color.node = None
                };
            }
            Self::Shininess => {
                return if let Some(phong) = phong {
                    phong.exponent.node = None
                };
            }
            Self::Color | Self::Opacity | Self::Normal | Self::Bump | Self::Displacement => return,
        };
        value.node = None;
    }

    /// Has picture number `map` of the shot give the parameter.
    pub fn show(self, surface: &mut Surface, map: u32, channel: Shown) {
        match (self, &mut surface.beyond.phong) {
            (Self::Roughness, _) => surface.show(Parameter::SpecularRoughness, map, channel),
            (Self::Metal, _) => surface.show(Parameter::BaseMetalness, map, channel),
            (Self::Emission, _) => surface.show(Parameter::EmissionColor, map, Shown::Color),
            (Self::Filter, _) => surface.beyond.glass_tint.show(&mut surface.graph, map, Shown::Color),
            (Self::Transmission, _) => surface.show(Parameter::TransmissionWeight, map, channel),
            (Self::Specular, Some(phong)) => phong.color.show(&mut surface.graph, map, Shown::Color),
            (Self::Shininess, Some(phong)) => phong.exponent.show(&mut surface.graph, map, channel),
            _ => {}
        }
    }
}

/// Maps of a material by their use, with anything that belongs to each.
#[derive(Debug, Clone, PartialEq)]
pub struct ByUse<T>([Option<T>; 12]);

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
    /// The file, as that at `asking` names it.
    pub fn named_by<'a>(&'a self, asking: &'a Path) -> Named<'a> {
        let folder = asking.parent().unwrap_or(Path::new(""));
        Named { file: &self.file, folder, asking, line: self.line, space: self.space }
    }

    /// Places of its texels.
    pub fn mapping(&self) -> Mapping {
        let wrap = if self.clamp { Wrap::Clamp } else { Wrap::Repeat };
        Mapping::scaled(self.scale, self.offset, [wrap; 2])
    }

    /// Creates a statement for the whole picture, repeating.
    pub fn plain(file: impl Into<String>, line: usize) -> Self {
        Self {
            file: file.into(),
            scale: Vec2::ONE,
            offset: Vec2::ZERO,
            clamp: false,
            slope: 1.0,
            middle: 0.0,
            channel: Shown::Mean,
            space: None,
            line,
        }
    }
}
