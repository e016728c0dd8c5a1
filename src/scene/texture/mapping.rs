//! Places of pictures on surfaces: from texture coordinates to texels.

use glam::{Mat2, Vec2, Vec3};

pub use crate::graph::UvSet;

/// From the texture coordinates of a surface to places of a picture, and what is beyond its edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mapping {
    /// Map of u and v, v upwards: scales (`-s`), turns and mirrors.
    pub linear: Mat2,
    /// Added to u and v then (`-o`).
    pub offset: Vec2,
    /// Beyond the edges across, and beyond those up and down.
    pub wrap: [Wrap; 2],
    /// Texture coordinates that are meant.
    pub uvs: UvSet,
    /// True if each place shows the texel that it is in: nothing is interpolated between the centres of texels.
    pub is_nearest: bool,
}

/// Way in which a picture goes on beyond an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Wrap {
    /// The whole repeats.
    #[default]
    Repeat,
    /// The texels of the edge go on (`-clamp on`).
    Clamp,
    /// The whole repeats, every other time mirrored.
    Mirror,
}

impl Default for Mapping {
    fn default() -> Self {
        Self {
            linear: Mat2::IDENTITY,
            offset: Vec2::ZERO,
            wrap: [Wrap::Repeat; 2],
            uvs: UvSet::First,
            is_nearest: false,
        }
    }
}

impl Mapping {
    /// Creates a mapping that scales u and v by themselves.
    pub fn scaled(scale: Vec2, offset: Vec2, wrap: [Wrap; 2]) -> Self {
        Self { linear: Mat2::from_diagonal(scale), offset, wrap, ..Self::default() }
    }

    /// Place in the picture of texture coordinates, v upwards; beyond 0 and 1 it wraps.
    #[inline]
    pub fn at(&self, uv: Vec2) -> Vec2 {
        self.linear * uv + self.offset
    }

    /// Texture coordinates of a place in the picture: not finite where the picture is scaled to nothing.
    pub fn uv_of(&self, place: Vec2) -> Vec2 {
        self.linear.inverse() * (place - self.offset)
    }
}

/// Place of a picture's texels on surfaces: see [`Texture`](super::Texture).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Places of texture coordinates on them.
    pub mapping: Mapping,
}

impl Placement {
    /// Finds the texels between whose centres `uv` (v upwards) lies.
    #[inline]
    pub fn between(&self, uv: Vec2) -> Between {
        self.between_at(self.mapping.at(uv))
    }

    /// Finds the texels between whose centres a place in the picture ([`Mapping::at`]) lies.
    #[inline]
    pub fn between_at(&self, place: Vec2) -> Between {
        let [across, down] = self.mapping.wrap;
        let (x0, x1, fx) = neighbours(place.x, self.width, across);
        let (y0, y1, fy) = neighbours(1.0 - place.y, self.height, down);
        let shares = if self.mapping.is_nearest { [fx.round(), fy.round()] } else { [fx, fy] };
        let index = |x: u32, y: u32| y as usize * self.width as usize + x as usize;
        Between { texels: [index(x0, y0), index(x1, y0), index(x0, y1), index(x1, y1)], shares }
    }

    /// Index of the texel to the left above a place in the picture: what [`between_at`](Self::between_at) finds first, in a part of the time.
    #[inline]
    pub fn first_at(&self, place: Vec2) -> usize {
        let [across, down] = self.mapping.wrap;
        let x = first_neighbour(place.x, self.width, across);
        let y = first_neighbour(1.0 - place.y, self.height, down);
        y as usize * self.width as usize + x as usize
    }
}

/// Finds the two texels between whose centres `t` (0..1 over the picture) lies, and the position between
/// them, 0..1.
fn neighbours(t: f32, size: u32, wrap: Wrap) -> (u32, u32, f32) {
    let (low, fraction) = between_centres(t, size, wrap);
    let last = size - 1;
    let second = low.wrapping_add(1);
    let second = match wrap {
        Wrap::Repeat if second > last => 0,
        _ => second.min(last),
    };
    (existing(low, last, wrap), second, fraction)
}

/// First of the [`neighbours`].
#[inline(always)]
fn first_neighbour(t: f32, size: u32, wrap: Wrap) -> u32 {
    existing(between_centres(t, size, wrap).0, size - 1, wrap)
}

/// Finds the texel whose centre is before `t` (0..1 over the picture), `u32::MAX` for that before the first, and the position
/// between it and the next one, 0..1.
#[inline(always)]
fn between_centres(t: f32, size: u32, wrap: Wrap) -> (u32, f32) {
    let t = match (t.is_finite(), wrap) {
        (false, _) => 0.0,
        (true, Wrap::Clamp) => t.clamp(0.0, 1.0),
        (true, Wrap::Repeat) => t - t.floor(),
        (true, Wrap::Mirror) => {
            let twice = (t * 0.5 - (t * 0.5).floor()) * 2.0;
            1.0 - (1.0 - twice).abs()
        }
    };
    let at = t * size as f32 - 0.5;
    let low = at.floor();
    // low is -1..=size - 1: the cast stops at 0
    let first = if low >= 0.0 { (low as u32).min(size - 1) } else { u32::MAX };
    (first, at - low)
}

/// Texel that stands for the one before the first.
#[inline(always)]
fn existing(low: u32, last: u32, wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => low.min(last),
        Wrap::Clamp | Wrap::Mirror if low == u32::MAX => 0,
        Wrap::Clamp | Wrap::Mirror => low,
    }
}

/// A place between the centres of four texels.
#[derive(Debug, Clone, Copy)]
pub struct Between {
    /// Indices of the texels: left and right above, left and right below.
    pub(super) texels: [usize; 4],
    /// Shares of the way to the right, and down; 0 to 1.
    pub(super) shares: [f32; 2],
}

impl Between {
    /// Column and row of the part that the place is in, of `count` between the centres of texels in each direction, in a picture of
    /// this `width`.
    pub fn part(&self, count: u32, width: u32) -> [u32; 2] {
        let first = self.texels[0] as u32;
        let [right, down] = self.shares.map(|share| ((share * count as f32) as u32).min(count - 1));
        [first % width * count + right, first / width * count + down]
    }

    /// Interpolates what texels have, bilinearly.
    #[inline(always)]
    pub fn of(&self, texel: impl Fn(usize) -> Vec3) -> Vec3 {
        let Self { texels: [a, b, c, d], shares: [across, down] } = *self;
        let above = texel(a).lerp(texel(b), across);
        let below = texel(c).lerp(texel(d), across);
        above.lerp(below, down)
    }

    /// Index of one of the texels, each as likely as interpolation weighs it: by two numbers below 1 and not
    /// below 0. The mean over all numbers is the interpolated value (Fajardo, Wronski, Salvi and Pharr, "Stochastic
    /// Texture Filtering", 2023).
    #[inline]
    pub fn chosen(&self, [across, down]: [f32; 2]) -> usize {
        let [right, below] = self.shares;
        self.texels[usize::from(across < right) + 2 * usize::from(down < below)]
    }
}
