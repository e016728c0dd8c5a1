//! The planes of a picture, and what is made into each.

use crate::film::{Film, PlaneKind, Values};
use crate::layers::Layers;
use crate::settings::{Filter, Settings};

/// The planes of sums: numbers of those that begin a colour. A colour lies within one group of eight
/// ([`mitchell`](super::mitchell)), so that some stay empty; what nearly every sample has is in the first, and what is
/// seldom asked for has groups of its own.
pub mod sums {
    /// Of the weights.
    pub const WEIGHT: usize = 0;
    /// Of samples that show a surface.
    pub const ALPHA: usize = 1;
    /// Three colours each, from here on.
    pub const DIFFUSE: usize = 2;
    /// Diffuse reflectance.
    pub const ALBEDO: usize = 5;
    /// Highlights.
    pub const SPECULAR: usize = 8;
    /// In mirrors and off glass.
    pub const REFLECTION: usize = 11;
    /// Through glass.
    pub const REFRACTION: usize = 16;
    /// Diffuse light of light sources.
    pub const DIRECT: usize = 24;
    /// Diffuse light that came by light paths.
    pub const INDIRECT: usize = 27;
    /// Emission and ambient light.
    pub const EMISSION: usize = 32;
    /// The background as the eye sees it.
    pub const SKY: usize = 35;
    /// For denoisers.
    pub const GUIDE_ALBEDO: usize = 40;
    /// For denoisers; the only sums that may be negative.
    pub const GUIDE_NORMAL: usize = 43;
    /// What share of the directions around is open.
    pub const OCCLUSION: usize = 46;
    /// All of them.
    pub const COUNT: usize = 47;
}

/// The planes of data: numbers of those that begin a vector or a table.
pub mod data {
    /// Distance along the view axis.
    pub const Z: usize = 0;
    /// World space.
    pub const POSITION: usize = 1;
    /// World space.
    pub const NORMAL: usize = 4;
    /// Model's number, from 1 on.
    pub const ID: usize = 7;
    /// To where the point was in the frame before, pixels.
    pub const BACKWARD: usize = 8;
    /// To where it will be in the next frame, pixels.
    pub const FORWARD: usize = 10;
    /// From there to where it is.
    pub const FROM_NEXT: usize = 12;
    /// Frames since the sample was traced.
    pub const AGE: usize = 14;
    /// Share of the samples that are base, good, overlapped, missed, obscured.
    pub const STATUS: usize = 15;
    /// Rays: primary, verification, shadow, secondary.
    pub const RAYS: usize = 20;
    /// All of them.
    pub const COUNT: usize = 24;
}

/// Where a plane's value comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// These sums together, over the sum of weights.
    Filtered(&'static [usize]),
    /// This datum.
    Data(usize),
}

/// A plane of the picture.
#[derive(Debug, Clone, Copy)]
pub struct Channel {
    /// As files have it.
    pub name: &'static str,
    /// As files have it.
    pub kind: PlaneKind,
    /// What it shows.
    pub source: Source,
}

impl Channel {
    const fn half(name: &'static str, source: Source) -> Self {
        Self { name, kind: PlaneKind::Half, source }
    }

    const fn float(name: &'static str, source: Source) -> Self {
        Self { name, kind: PlaneKind::Float, source }
    }

    /// Whether it counts samples or rays: it may change where the samples do not.
    pub fn is_count(&self) -> bool {
        matches!(self.source, Source::Data(data::STATUS..))
    }

    /// The least and the greatest value that a filter may make of it: its negative lobes must make neither negative light
    /// nor coverage of more than all.
    pub fn limits(&self) -> [f32; 2] {
        match self.source {
            Source::Filtered([sums::ALPHA | sums::OCCLUSION]) => [0.0, 1.0],
            Source::Filtered([sum]) if *sum >= sums::GUIDE_NORMAL => [-1.0, 1.0],
            Source::Filtered([sum]) if *sum >= sums::GUIDE_ALBEDO => [0.0, 1.0],
            _ => [0.0, f32::INFINITY],
        }
    }

    /// Whether it is made of floats, whatever files have.
    pub fn is_float(&self) -> bool {
        // ages are counted up where they stand: halves would stop at 2048
        self.kind == PlaneKind::Float || self.source == Source::Data(data::AGE)
    }

    /// Room for `count` values of it.
    pub fn room(&self, count: usize) -> Values {
        if self.is_float() { Values::floats(count) } else { Values::halves(count) }
    }
}

/// The contract's planes.
const CHANNELS: [Channel; 64] = {
    use Source::{Data, Filtered};
    use data::{AGE, BACKWARD, FORWARD, FROM_NEXT, ID, NORMAL, POSITION, RAYS, STATUS, Z};
    use sums::{ALBEDO, ALPHA, DIFFUSE, DIRECT, EMISSION, GUIDE_ALBEDO, GUIDE_NORMAL, INDIRECT};
    use sums::{OCCLUSION, REFLECTION, REFRACTION, SKY, SPECULAR};
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
        Channel::half("occlusion.V", Filtered(&[OCCLUSION])),
        Channel::float("motion.X", Data(BACKWARD)),
        Channel::float("motion.Y", Data(BACKWARD + 1)),
        Channel::float("motion.Z", Data(FROM_NEXT)),
        Channel::float("motion.W", Data(FROM_NEXT + 1)),
        Channel::float("forward.U", Data(FORWARD)),
        Channel::float("forward.V", Data(FORWARD + 1)),
        Channel::float("backward.U", Data(BACKWARD)),
        Channel::float("backward.V", Data(BACKWARD + 1)),
    ]
};

/// Those of `layers`.
pub fn channels(layers: Layers) -> impl Iterator<Item = Channel> {
    CHANNELS.into_iter().filter(move |channel| layers.has_plane(channel.name))
}

/// What is to be written.
#[derive(Debug)]
pub struct Picture {
    /// From samples to pixels.
    pub filter: Filter,
    /// Of the film's planes.
    pub channels: Vec<Channel>,
    /// For each plane, whether it was zero throughout before this frame.
    pub was_zero: Vec<bool>,
}

impl Picture {
    /// To be written over what `film` shows.
    pub fn over(film: &Film, settings: &Settings) -> Self {
        let was_zero = film.planes.iter().map(|plane| plane.is_zero).collect();
        Self { filter: settings.filter, channels: channels(settings.layers).collect(), was_zero }
    }

    /// Number of the plane with the ages.
    pub fn age(&self) -> Option<usize> {
        self.channels.iter().position(|channel| channel.source == Source::Data(data::AGE))
    }
}

/// Which channels of some tiles are not zero throughout, a bit each.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Written {
    some: u128,
    /// Whether the film showed any of the pixels already, so that it was left as it is.
    any_shown: bool,
}

const _: () = assert!(CHANNELS.len() <= u128::BITS as usize);

impl Written {
    /// Of pixels that the film showed already.
    pub const SHOWN: Self = Self { some: 0, any_shown: true };

    /// Notes that channel `number` holds something.
    pub fn note(&mut self, number: usize) {
        self.some |= 1 << number;
    }

    /// Of more tiles.
    pub fn plus(self, other: Self) -> Self {
        Self { some: self.some | other.some, any_shown: self.any_shown | other.any_shown }
    }

    /// Whether plane `number` is zero throughout now.
    pub fn is_zero(self, number: usize, was_zero: bool) -> bool {
        self.some >> number & 1 == 0 && (was_zero || !self.any_shown)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// What Blender 3.4 and 5 show: longer names of channels are scrambled by one and dropped by the other, and a fifth channel
    /// of a layer takes the place of another.
    #[test]
    fn names_are_such_as_other_programs_read() {
        let mut layers: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        let denoised = crate::denoise::PLANES;
        for name in channels(Layers::ALL).map(|channel| channel.name).chain(denoised) {
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
                &["U", "V"],
                &["V"],
                &["Z"],
            ];
            assert!(known.contains(&&letters[..]), "{layer}: {letters:?}");
        }
    }
}
