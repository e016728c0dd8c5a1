//! The planes of a picture and the source of each.

use std::borrow::Cow;
use std::ops::Range;

use glam::Vec3;

use super::kernel::Kernel;
use crate::cryptomatte::{Kind, RANKS};
use crate::film::{Film, PlaneKind, Values};
use crate::layers::Layers;
use crate::scene::LightGroups;

/// Numbers of the planes of sums; that of a colour is its first component's. A colour lies within one group
/// of eight ([`spread`](crate::frame::film::spread)), so that some planes stay empty. Colours that nearly
/// every sample has are in the first group; those that are seldom asked for have groups of their own.
pub mod sums {
    use crate::lanes::LANES;
    use crate::scene::LightGroups;

    /// Sum of the filter weights.
    pub const WEIGHT: usize = 0;
    /// Weights of samples that show a surface.
    pub const ALPHA: usize = 1;
    /// Diffuse light. Three components each, from here on.
    pub const DIFFUSE: usize = 2;
    /// Diffuse reflectance.
    pub const ALBEDO: usize = 5;
    /// Highlights.
    pub const SPECULAR: usize = 8;
    /// Light in mirrors and off glass.
    pub const REFLECTION: usize = 11;
    /// Variance of the mean of the pixel's samples.
    pub const VARIANCE: usize = 14;
    /// Light through glass.
    pub const REFRACTION: usize = 16;
    /// By what shadows on catchers dim a plate: 1 where there is none.
    pub const CATCHER: usize = 19;
    /// How much mist is before what is seen.
    pub const MIST: usize = 22;
    /// Diffuse light of light sources.
    pub const DIRECT: usize = 24;
    /// Diffuse light that came by light paths.
    pub const INDIRECT: usize = 27;
    /// Emission and ambient light.
    pub const EMISSION: usize = 32;
    /// The background as the eye sees it.
    pub const SKY: usize = 35;
    /// Albedo for denoisers.
    pub const GUIDE_ALBEDO: usize = 40;
    /// Normal for denoisers; the only sums that may be negative.
    pub const GUIDE_NORMAL: usize = 43;
    /// Share of the directions around that is open.
    pub const OCCLUSION: usize = 46;
    /// Distance along the view axis; 0 for the background.
    pub const DEPTH: usize = 47;
    const LIGHTS: usize = 48;
    /// Number of planes of sums.
    pub const COUNT: usize = LIGHTS + LightGroups::MOST / 2 * LANES;

    /// First of the planes that hold the share of a light group in the picture.
    pub const fn light(group: usize) -> usize {
        LIGHTS + group / 2 * LANES + group % 2 * 3
    }
}

/// Numbers of the planes of data; that of a vector or a table is its first component's.
pub mod data {
    /// Distance along the view axis.
    pub const Z: usize = 0;
    /// Position, world space.
    pub const POSITION: usize = 1;
    /// Normal, world space.
    pub const NORMAL: usize = 4;
    /// Model's number, from 1 on.
    pub const ID: usize = 7;
    /// Motion vector to the point's place in the frame before, in pixels; then 1 if that is known.
    pub const BACKWARD: usize = 8;
    /// Motion vector to the point's place in the next frame, in pixels; then 1 if that is known.
    pub const FORWARD: usize = 11;
    /// Motion vector from the place in the next frame to that in this one, in pixels.
    pub const FROM_NEXT: usize = 14;
    /// Frames since the sample was traced.
    pub const AGE: usize = 16;
    /// Shares of the samples that are base, good, overlapped, missed, obscured.
    pub const STATUS: usize = 17;
    /// Ray counts: primary, verification, shadow, secondary.
    pub const RAYS: usize = 22;
    /// Material's number, from 1 on.
    pub const MATERIAL: usize = 26;
    /// Texture coordinates; 1 where there are any.
    pub const UV: usize = 27;
    /// Number of planes of data.
    pub const COUNT: usize = 30;
}

/// Source of a plane's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaneSource {
    /// Total of these sums, over the sum of weights.
    Filtered(&'static [usize]),
    /// Plane of data with this number.
    Data(usize),
    /// Plane of [`mattes`](mod@crate::frame::film::mattes) with this number: see [`matte_planes`].
    Matte(usize),
}

/// Numbers of the planes of a kind of mattes: id and coverage of the first rank, of the second, ...
pub fn matte_planes(kind: Kind) -> Range<usize> {
    let first = kind as usize * 2 * RANKS;
    first..first + 2 * RANKS
}

/// Number of planes of mattes, of all kinds.
pub const MATTE_PLANES: usize = Kind::ALL.len() * 2 * RANKS;

/// A plane of the picture.
#[derive(Debug, Clone)]
pub struct Channel {
    /// Name in files.
    pub name: Cow<'static, str>,
    /// Type of its values in files.
    pub kind: PlaneKind,
    /// Source of its values.
    pub source: PlaneSource,
}

impl Channel {
    const fn half(name: &'static str, source: PlaneSource) -> Self {
        Self { name: Cow::Borrowed(name), kind: PlaneKind::Half, source }
    }

    const fn float(name: &'static str, source: PlaneSource) -> Self {
        Self { name: Cow::Borrowed(name), kind: PlaneKind::Float, source }
    }

    /// Returns true if the plane counts samples or rays: it may change where the samples do not.
    pub fn is_count(&self) -> bool {
        matches!(self.source, PlaneSource::Data(data::STATUS..data::MATERIAL))
    }

    /// Least and greatest value that a filter may give it. Negative lobes must make neither negative light
    /// nor coverage above 1, nor more reflectance than that of the `brightest` material.
    pub fn limits(&self, brightest: Vec3) -> [f32; 2] {
        match self.source {
            PlaneSource::Filtered([sum @ sums::ALBEDO..sums::SPECULAR]) => {
                [0.0, brightest[sum - sums::ALBEDO]]
            }
            PlaneSource::Filtered([sums::ALPHA | sums::OCCLUSION]) => [0.0, 1.0],
            PlaneSource::Filtered([sums::CATCHER..sums::DIRECT]) => [0.0, 1.0],
            PlaneSource::Filtered([sums::GUIDE_NORMAL..sums::OCCLUSION]) => [-1.0, 1.0],
            PlaneSource::Filtered([sums::GUIDE_ALBEDO..sums::GUIDE_NORMAL]) => [0.0, 1.0],
            _ => [0.0, f32::INFINITY],
        }
    }

    /// Returns true if its pixels are made of samples of several tiles when the filter is wider than a pixel.
    pub fn is_filtered(&self) -> bool {
        matches!(self.source, PlaneSource::Filtered(_) | PlaneSource::Matte(_))
    }

    /// Returns true if the film keeps it as floats, whatever files hold.
    pub fn is_float(&self) -> bool {
        // ages are counted up where they stand: halves would stop at 2048
        self.kind == PlaneKind::Float || self.source == PlaneSource::Data(data::AGE)
    }

    /// Creates storage for `count` values of the plane.
    pub fn room(&self, count: usize) -> Values {
        if self.is_float() { Values::floats(count) } else { Values::halves(count) }
    }
}

/// Number of the contract's planes that do not depend on the shot.
const COUNT: usize = 76;

/// Planes of the contract that do not depend on the shot, mattes excepted.
const CHANNELS: [Channel; COUNT] = {
    use PlaneSource::{Data, Filtered};
    use data::{AGE, BACKWARD, FORWARD, FROM_NEXT, ID, MATERIAL, NORMAL, POSITION, RAYS, STATUS, UV, Z};
    use sums::{
        ALBEDO, ALPHA, CATCHER, DEPTH, DIFFUSE, DIRECT, EMISSION, GUIDE_ALBEDO, GUIDE_NORMAL, INDIRECT, MIST,
        OCCLUSION, REFLECTION, REFRACTION, SKY, SPECULAR, VARIANCE,
    };
    [
        Channel::half("R", Filtered(&[DIFFUSE, SPECULAR, REFLECTION, REFRACTION])),
        Channel::half("G", Filtered(&[DIFFUSE + 1, SPECULAR + 1, REFLECTION + 1, REFRACTION + 1])),
        Channel::half("B", Filtered(&[DIFFUSE + 2, SPECULAR + 2, REFLECTION + 2, REFRACTION + 2])),
        Channel::half("A", Filtered(&[ALPHA])),
        Channel::half("diffuse.R", Filtered(&[DIFFUSE])),
        Channel::half("diffuse.G", Filtered(&[DIFFUSE + 1])),
        Channel::half("diffuse.B", Filtered(&[DIFFUSE + 2])),
        Channel::half("specular.R", Filtered(&[SPECULAR])),
        Channel::half("specular.G", Filtered(&[SPECULAR + 1])),
        Channel::half("specular.B", Filtered(&[SPECULAR + 2])),
        Channel::half("reflection.R", Filtered(&[REFLECTION])),
        Channel::half("reflection.G", Filtered(&[REFLECTION + 1])),
        Channel::half("reflection.B", Filtered(&[REFLECTION + 2])),
        Channel::half("refraction.R", Filtered(&[REFRACTION])),
        Channel::half("refraction.G", Filtered(&[REFRACTION + 1])),
        Channel::half("refraction.B", Filtered(&[REFRACTION + 2])),
        Channel::half("albedo.R", Filtered(&[ALBEDO])),
        Channel::half("albedo.G", Filtered(&[ALBEDO + 1])),
        Channel::half("albedo.B", Filtered(&[ALBEDO + 2])),
        Channel::float("Z", Data(Z)),
        Channel::float("P.X", Data(POSITION)),
        Channel::float("P.Y", Data(POSITION + 1)),
        Channel::float("P.Z", Data(POSITION + 2)),
        Channel::half("N.X", Data(NORMAL)),
        Channel::half("N.Y", Data(NORMAL + 1)),
        Channel::half("N.Z", Data(NORMAL + 2)),
        Channel::float("object.V", Data(ID)),
        Channel::half("status_age.V", Data(AGE)),
        Channel::half("status_base.V", Data(STATUS)),
        Channel::half("status_good.V", Data(STATUS + 1)),
        Channel::half("status_overlapped.V", Data(STATUS + 2)),
        Channel::half("status_missed.V", Data(STATUS + 3)),
        Channel::half("status_obscured.V", Data(STATUS + 4)),
        Channel::half("rays_primary.V", Data(RAYS)),
        Channel::half("rays_verification.V", Data(RAYS + 1)),
        Channel::half("rays_shadow.V", Data(RAYS + 2)),
        Channel::half("rays_secondary.V", Data(RAYS + 3)),
        Channel::half("direct.R", Filtered(&[DIRECT])),
        Channel::half("direct.G", Filtered(&[DIRECT + 1])),
        Channel::half("direct.B", Filtered(&[DIRECT + 2])),
        Channel::half("indirect.R", Filtered(&[INDIRECT])),
        Channel::half("indirect.G", Filtered(&[INDIRECT + 1])),
        Channel::half("indirect.B", Filtered(&[INDIRECT + 2])),
        Channel::half("emission.R", Filtered(&[EMISSION])),
        Channel::half("emission.G", Filtered(&[EMISSION + 1])),
        Channel::half("emission.B", Filtered(&[EMISSION + 2])),
        Channel::half("background.R", Filtered(&[SKY])),
        Channel::half("background.G", Filtered(&[SKY + 1])),
        Channel::half("background.B", Filtered(&[SKY + 2])),
        Channel::half("denoise_albedo.R", Filtered(&[GUIDE_ALBEDO])),
        Channel::half("denoise_albedo.G", Filtered(&[GUIDE_ALBEDO + 1])),
        Channel::half("denoise_albedo.B", Filtered(&[GUIDE_ALBEDO + 2])),
        Channel::half("denoise_normal.X", Filtered(&[GUIDE_NORMAL])),
        Channel::half("denoise_normal.Y", Filtered(&[GUIDE_NORMAL + 1])),
        Channel::half("denoise_normal.Z", Filtered(&[GUIDE_NORMAL + 2])),
        Channel::float("denoise_variance.V", Filtered(&[VARIANCE])),
        Channel::half("occlusion.V", Filtered(&[OCCLUSION])),
        Channel::float("motion.X", Data(BACKWARD)),
        Channel::float("motion.Y", Data(BACKWARD + 1)),
        Channel::float("motion.Z", Data(FROM_NEXT)),
        Channel::float("motion.W", Data(FROM_NEXT + 1)),
        Channel::float("forward.U", Data(FORWARD)),
        Channel::float("forward.V", Data(FORWARD + 1)),
        Channel::float("forward.A", Data(FORWARD + 2)),
        Channel::float("backward.U", Data(BACKWARD)),
        Channel::float("backward.V", Data(BACKWARD + 1)),
        Channel::float("backward.A", Data(BACKWARD + 2)),
        Channel::float("depth.V", Filtered(&[DEPTH])),
        Channel::float("material.V", Data(MATERIAL)),
        Channel::float("uv.U", Data(UV)),
        Channel::float("uv.V", Data(UV + 1)),
        Channel::float("uv.A", Data(UV + 2)),
        Channel::half("catcher.R", Filtered(&[CATCHER])),
        Channel::half("catcher.G", Filtered(&[CATCHER + 1])),
        Channel::half("catcher.B", Filtered(&[CATCHER + 2])),
        Channel::half("mist.V", Filtered(&[MIST])),
    ]
};

/// The planes of a kind of mattes, from number `$first` on: three layers of two ranks each.
macro_rules! mattes {
    ($name:literal, $first:expr) => {
        [
            Channel::float(concat!($name, "00.R"), PlaneSource::Matte($first)),
            Channel::float(concat!($name, "00.G"), PlaneSource::Matte($first + 1)),
            Channel::float(concat!($name, "00.B"), PlaneSource::Matte($first + 2)),
            Channel::float(concat!($name, "00.A"), PlaneSource::Matte($first + 3)),
            Channel::float(concat!($name, "01.R"), PlaneSource::Matte($first + 4)),
            Channel::float(concat!($name, "01.G"), PlaneSource::Matte($first + 5)),
            Channel::float(concat!($name, "01.B"), PlaneSource::Matte($first + 6)),
            Channel::float(concat!($name, "01.A"), PlaneSource::Matte($first + 7)),
            Channel::float(concat!($name, "02.R"), PlaneSource::Matte($first + 8)),
            Channel::float(concat!($name, "02.G"), PlaneSource::Matte($first + 9)),
            Channel::float(concat!($name, "02.B"), PlaneSource::Matte($first + 10)),
            Channel::float(concat!($name, "02.A"), PlaneSource::Matte($first + 11)),
        ]
    };
}

/// Planes of mattes, by kind.
const MATTES: [[Channel; 2 * RANKS]; Kind::ALL.len()] =
    [mattes!("CryptoObject", 0), mattes!("CryptoMaterial", 2 * RANKS), mattes!("CryptoGroup", 4 * RANKS)];

/// Planes with the share of each group of lights in the picture.
fn lights(groups: &LightGroups) -> impl Iterator<Item = Channel> {
    static NUMBERS: [usize; sums::COUNT] = {
        let mut numbers = [0; sums::COUNT];
        let mut number = 0;
        while number < sums::COUNT {
            numbers[number] = number;
            number += 1;
        }
        numbers
    };
    let channel = |(group, name): (usize, &String)| {
        ["R", "G", "B"]
            .into_iter()
            .zip(sums::light(group)..)
            .map(|(letter, sum)| Channel {
                name: format!("light_{name}.{letter}").into(),
                kind: PlaneKind::Half,
                source: PlaneSource::Filtered(std::slice::from_ref(&NUMBERS[sum])),
            })
            .collect::<Vec<_>>()
    };
    groups.names.iter().enumerate().flat_map(channel)
}

/// Planes of `layers`, for lights of these groups.
pub fn channels(layers: Layers, groups: &LightGroups) -> impl Iterator<Item = Channel> {
    let all = CHANNELS.into_iter().chain(MATTES.into_iter().flatten()).chain(lights(groups));
    all.filter(move |channel| layers.has_plane(&channel.name))
}

/// Planes to be written in this frame, and their filter.
#[derive(Debug)]
pub struct Picture {
    /// Filter from samples to pixels, if it is wider than a pixel.
    pub kernel: Option<Kernel>,
    /// Channels of the film's planes, in their order.
    pub channels: Vec<Channel>,
    /// True for each plane that was zero throughout before this frame.
    pub was_zero: Vec<bool>,
    /// Largest diffuse reflectance of the scene's materials, by channel.
    pub brightest: Vec3,
}

impl Picture {
    /// Creates a picture of these channels, to be written over the one that `film` shows.
    pub fn over(film: &Film, kernel: Option<Kernel>, channels: &[Channel], brightest: Vec3) -> Self {
        let was_zero = film.planes.iter().map(|plane| plane.is_zero).collect();
        Self { kernel, channels: channels.to_vec(), was_zero, brightest }
    }

    /// Number of the plane of ages, if there is one.
    pub fn age(&self) -> Option<usize> {
        self.channels.iter().position(|channel| channel.source == PlaneSource::Data(data::AGE))
    }
}

/// Channels in a word of [`NonZeroPlanes`].
const WORD: usize = u128::BITS as usize;

/// Set of channels in which some tiles have values other than zero, a bit each.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct NonZeroPlanes {
    some: [u128; 2],
    /// True if the film showed any of the pixels already, so that they were left as they are.
    any_shown: bool,
}

const _: () = assert!(COUNT + MATTE_PLANES + 3 * LightGroups::MOST <= 2 * WORD);

impl NonZeroPlanes {
    /// State of pixels that the film showed already.
    pub const SHOWN: Self = Self { some: [0; 2], any_shown: true };

    /// Notes that channel `number` holds something.
    pub fn note(&mut self, number: usize) {
        self.some[number / WORD] |= 1 << (number % WORD);
    }

    /// Returns true if none of the pixels holds anything in plane number `number`.
    pub fn is_none(self, number: usize) -> bool {
        self.some[number / WORD] >> (number % WORD) & 1 == 0
    }

    /// Joins the sets of different tiles.
    pub fn plus(self, other: Self) -> Self {
        let some = [0, 1].map(|word| self.some[word] | other.some[word]);
        Self { some, any_shown: self.any_shown | other.any_shown }
    }

    /// Returns true if plane `number` is zero throughout now.
    pub fn is_zero(self, number: usize, was_zero: bool) -> bool {
        self.is_none(number) && (was_zero || !self.any_shown)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Checks names against the limits of Blender 3.4 and 5: longer names of channels are scrambled by one
    /// and dropped by the other, a fifth channel of a layer takes the place of another, and 3.4 shows nothing
    /// of use of two channels.
    #[test]
    fn names_are_such_as_other_programs_read() {
        let mut layers: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        let denoised = crate::denoise::PLANES;
        let groups = LightGroups { names: vec![String::from("a-name-of-23-letters-xx")], of: Vec::new() };
        let all: Vec<Channel> = channels(Layers::ALL, &groups).collect();
        let names: Vec<&str> = all.iter().map(|channel| &*channel.name).chain(denoised).collect();
        for name in names {
            let (layer, letter) = name.rsplit_once('.').unwrap_or(("", name));
            assert!(name.len() <= 31 && !layer.contains('.'), "{name}");
            // a picture and its depth: the one layer in which Z is no part of a vector
            let layer = if name == "Z" { "Z" } else { layer };
            layers.entry(layer).or_default().push(letter);
        }
        for (layer, letters) in layers {
            let known = [
                &["R", "G", "B", "A"][..],
                &["R", "G", "B"],
                &["X", "Y", "Z"],
                &["X", "Y", "Z", "W"],
                &["U", "V", "A"],
                &["V"],
                &["Z"],
            ];
            assert!(known.contains(&&letters[..]), "{layer}: {letters:?}");
        }
    }
}
