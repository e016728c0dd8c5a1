//! Start and result of a light path. Rays of ambient occlusion start in the same way.

use glam::Vec3;

use crate::changes::Until;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::links::OF_EYE;
use crate::scene::look::Look;
use crate::scene::material::Scattering;
use crate::shade::bsdf::SeenBsdf;
use crate::shade::horizon::Horizon;
use crate::shade::sampling::{PathRandom, PathSequence, cosine_direction};
use crate::shade::surface::off_surface;
use crate::shade::within::Within;

/// Start of a path.
#[derive(Debug, Clone, Copy)]
pub struct PathStart {
    /// Number by which its owner knows it.
    pub owner: u32,
    /// Cell for which it is traced.
    pub cell: u32,
    /// Model of the surface.
    pub model: u32,
    /// Number of the path among those of its surface.
    pub index: u32,
    /// Sequence of its random numbers; all paths of a surface share it.
    pub sequence: PathSequence,
    /// Point on the surface, world space.
    pub point: Vec3,
    /// Shading normal, world space, unit length.
    pub normal: Vec3,
    /// Tangent at right angles to the normal, unit length. It turns with the model, and the path with it.
    pub tangent: Vec3,
    /// Normal of the triangle, world space, unit length, on the same side.
    pub geometric_normal: Vec3,
    /// The curved surface that the triangle stands for.
    pub horizon: Horizon,
    /// Number of what its surface has beside that among the [`Starts`](super::starts::Starts): a rough layer by which the path is reflected,
    /// or what is below the surface; or of nothing.
    pub of_surface: u32,
    /// What the eye's ray went through on its way here.
    pub within: Within,
}

/// What is below the surface at which a path starts, or on its other side.
#[derive(Debug, Clone, Copy)]
pub struct Below {
    /// Where light goes; the mean free path is one in world space.
    pub scattering: Scattering,
    /// Model of the surface: others are in no walk's way, unless they are of its material.
    pub model: u32,
    /// Look of the surface: what lies in it and is of its material is a part of it.
    pub look: Look,
    /// True if the back of the surface was seen: then the backs of its triangles are outside.
    pub from_behind: bool,
    /// Colour that the surface has where it is evenly lit: the paths' light is multiplied by it.
    pub albedo: Vec3,
}

impl Below {
    /// What is below a surface of `model` with this look and this albedo, if light goes there.
    pub fn of(
        frame: &FrameView,
        (model, from_behind): (u32, bool),
        look: Look,
        albedo: Vec3,
    ) -> Option<Self> {
        Some(Self { scattering: frame.palette.scattering(look)?, model, look, from_behind, albedo })
    }

    /// Share of the paths that go below the surface, from 0 to 1.
    pub fn chance(&self) -> f32 {
        self.scattering.below.element_sum() / 3.0
    }

    /// Weight of the light of those paths: channels do not all go below alike.
    pub fn weight_below(&self) -> Vec3 {
        self.scattering.below / self.chance()
    }

    /// Weight of the light of paths that neither go below the surface nor through it.
    pub fn weight_at_surface(&self) -> Vec3 {
        let chance = 1.0 - self.chance() - self.scattering.through;
        if chance > 0.0 { self.scattering.at_surface() / chance } else { Vec3::ZERO }
    }
}

/// The rough layer of a surface as it was seen when its reflected paths were drawn.
#[derive(Debug, Clone, Copy)]
pub struct DrawnLayer {
    /// The layer. It is not smooth.
    pub seen: SeenBsdf,
    /// Number of its paths.
    pub paths: u32,
}

impl PathStart {
    /// Start of what media scatter along a ray from `origin` (world space), which is no surface. `owner` and `cell`: see there.
    pub fn on_ray(
        (owner, cell): (u32, u32),
        sequence: PathSequence,
        (origin, direction): (Vec3, Vec3),
    ) -> Self {
        Self {
            owner,
            cell,
            index: 0,
            sequence,
            point: origin,
            model: OF_EYE,
            normal: direction,
            tangent: Vec3::ZERO,
            geometric_normal: direction,
            horizon: Horizon::flat(direction),
            of_surface: 0,
            within: Within::NOTHING,
        }
    }

    /// Random numbers of the path.
    #[inline]
    pub fn random(&self) -> PathRandom {
        self.sequence.path(self.index)
    }

    /// Returns true if the path leaves the surface in `direction`, and not into it.
    #[inline]
    pub fn leaves(&self, direction: Vec3) -> bool {
        self.horizon.is_below(direction, self.geometric_normal)
    }

    /// Origin of a ray that leaves the surface in `direction`.
    #[inline]
    pub fn origin(&self, direction: Vec3) -> Vec3 {
        self.horizon.origin(off_surface(self.point, self.geometric_normal), direction, self.geometric_normal)
    }

    /// Direction by the cosine law about the normal, from two random numbers. Unit length.
    #[inline]
    pub fn direction(&self, random: [f32; 2]) -> Vec3 {
        cosine_direction(random, [self.tangent, self.normal.cross(self.tangent), self.normal])
    }
}

/// Result of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathResult {
    /// Radiance, linear RGB.
    pub radiance: Vec3,
    /// True if the light source that a rough layer asks beside the path is in sight.
    pub sees_light: bool,
    /// First frame in which the result may differ.
    pub until: Until,
}
