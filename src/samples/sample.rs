//! One sample: its place, and the record of all else that goes with it from cell to cell.

use glam::Vec3;
use half::f16;

use super::{ClearRegions, Footprint, Octahedral};
use crate::exposure::{TICKS, Tick};
use crate::scene::look::{Look, Varied};

/// A sample without its tags and what it has gathered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// See [`Tile::x`](super::Tile::x).
    pub point: Vec3,
    /// See [`Tile::model`](super::Tile::model).
    pub model: u32,
    /// Other data of the sample.
    pub record: Record,
    /// See [`Tile::varied`](super::Tile::varied).
    pub varied: Varied,
}

impl Sample {
    /// Material of its surface, with its parameters there.
    pub fn look(&self) -> Look {
        Look { material: self.record.material, varied: self.varied }
    }
}

/// Colour as it is stored: R, G and B in half floats.
pub type HalfColor = [f16; 3];

/// Data of a sample beside its place: 32 bytes that are copied as a whole when the sample finds its new cell.
///
/// Directions and colours are rounded when a sample is *traced*, before anything is computed from them: a
/// sample that was kept is shaded from the same numbers as one that was just made.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct Record {
    /// Number of the triangle, or of another primitive, of the model's mesh.
    pub triangle: u32,
    /// Shading normal, object space, on the side from which the sample is seen.
    pub normal: Octahedral,
    /// Geometric normal, object space, on the side from which the sample is seen.
    pub geometric_normal: Octahedral,
    /// Reflectance that the diffuse and the ambient one are shares of, texture included: see
    /// [`Material::painted`](crate::scene::Material::painted).
    pub reflectance: HalfColor,
    /// Light that does not depend on the eye: emission, ambient and diffuse light. Radiance, linear RGB.
    pub direct_diffuse: HalfColor,
    /// When it was traced, and at what tick of its exposure it is seen.
    pub traced: Traced,
    /// Index into [`Scene::materials`](crate::scene::Scene::materials).
    pub material: u16,
    /// Flags of the sample.
    pub flags: Flags,
    /// Place over which its textures are filtered.
    pub footprint: Footprint,
}

const _: () = assert!(size_of::<Record>() == 32);

/// The frame in which a sample was traced, and the tick of the exposure that goes with it from then on; and whether two exposures have it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Traced(u32);

impl Traced {
    /// Number of the low bits that are the tick.
    const TICK_BITS: u32 = 8;
    /// Bit of a sample that an exposure was lent by the one before it.
    const SHARED: u32 = 1 << 31;
    /// Greatest number of a frame.
    const LAST: u32 = (Self::SHARED - 1) >> Self::TICK_BITS;

    /// In rendered frame number `frame`, counted from the renderer's first; those that no bits are left for count as one.
    #[inline(always)]
    pub fn new(frame: u32, tick: Tick) -> Self {
        Self(frame.min(Self::LAST) << Self::TICK_BITS | u32::from(tick))
    }

    /// Number of the frame.
    pub fn frame(self) -> u32 {
        (self.0 & !Self::SHARED) >> Self::TICK_BITS
    }

    /// The tick.
    #[inline(always)]
    pub fn tick(self) -> Tick {
        self.0 as Tick
    }

    /// Returns true if another exposure has the sample as well.
    #[inline(always)]
    pub fn is_shared(self) -> bool {
        self.0 & Self::SHARED != 0
    }

    /// The same, of a sample that another exposure has as well.
    pub fn shared(self) -> Self {
        Self(self.0 | Self::SHARED)
    }

    /// Converts it to bits, to be saved.
    pub fn to_bits(self) -> u32 {
        self.0
    }

    /// Inverse of [`to_bits`](Self::to_bits); `None` for other bits.
    pub fn from_bits(bits: u32) -> Option<Self> {
        let traced = Self(bits);
        (usize::from(traced.tick()) < TICKS).then_some(traced)
    }
}

/// Set of flags, a bit each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Flags(u8);

impl Flags {
    /// The eye sees the back of the triangle.
    pub const FROM_BEHIND: Self = Self(1);
    /// Visibility from the eye was not verified in the frame before.
    pub const UNSEEN: Self = Self(2);
    /// The stored light must be summed anew.
    pub const STALE: Self = Self(4);

    /// Number of low bits that are flags.
    const BITS: u32 = 3;
    /// Number of a [region](super::ClearRegions), 0 for none, above the flags.
    const REGION: u8 = ClearRegions::MOST as u8;
    /// Bit above that number: there is no proof for that region.
    const UNPROVEN: Self = Self(0x80);

    /// Proof that the sample, and all that is around it, is seen by any eye in a region: the region's number, and whether there is such
    /// a proof or it is known that there is none.
    #[inline(always)]
    pub fn proof(self) -> Option<(u8, bool)> {
        let region = self.0 >> Self::BITS & Self::REGION;
        (region != 0).then_some((region, !self.has(Self::UNPROVEN)))
    }

    /// These flags with this [`proof`](Self::proof) instead of any other.
    #[inline(always)]
    pub fn with_proof(self, proof: Option<(u8, bool)>) -> Self {
        let flags = self.0 & ((1 << Self::BITS) - 1);
        let Some((region, is_proven)) = proof else { return Self(flags) };
        Self(flags | region << Self::BITS).with(Self::UNPROVEN.when(!is_proven))
    }

    /// These flags if `holds`, else none.
    pub fn when(self, holds: bool) -> Self {
        if holds { self } else { Self(0) }
    }

    /// Converts the flags to bits, to be saved.
    pub fn to_bits(self) -> u8 {
        self.0
    }

    /// Inverse of [`to_bits`](Self::to_bits); `None` for other bits.
    pub fn from_bits(bits: u8) -> Option<Self> {
        let flags = Self(bits);
        (flags.proof().is_some() || !flags.has(Self::UNPROVEN)).then_some(flags)
    }

    /// Returns true if all flags of `other` are set.
    pub fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Union with the flags of `other`.
    pub fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// These flags without those of `other`.
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
}

impl Record {
    /// Returns true if the eye sees the back of the triangle.
    pub fn is_from_behind(&self) -> bool {
        self.flags.has(Flags::FROM_BEHIND)
    }
}
